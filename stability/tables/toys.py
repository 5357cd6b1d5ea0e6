"""Table of values that are printed of spinning toys, recomputed."""

from __future__ import annotations

import math

import casadi as ca
from flint import arb

from ..algebra.number_types import precision, upper
from ..base.citation import cited
from ..bodies.contact_laws import Rough
from ..bodies.disk import Disk
from ..bodies.round_body.body import Body
from ..motion.simulate import simulate
from .benchmarks.row import CLOSED, QUOTED, BenchmarkRow, Source
from .peers import BITS
from .printed import of_printed_values, printed_row
from .table import About, Standing

BALLS = "hurricane balls, two equal welded balls"
RATE = Source(f"{BALLS} of 16 mm", "a college's page of demonstrations", QUOTED)
INCLINATION = Source(BALLS, "code of a tournament: cos θ = 2/5 - g/(Ω²R)", CLOSED)
TOY = Source("Euler's disk, the toy", "a public model of it", QUOTED)
COIN = Source("rolling coin, tilt 1°, 5 turns/s", "EXUDYN, rollingCoinTest", QUOTED)
CYLINDER = Source("spinning cylinder", "Am. J. Phys. 87 (2019) 85, abstract", QUOTED)
PLANE = Source("rolling disk on a smooth plane", "a public repository on the rolling disk", QUOTED)
ERROR = "the source steps by 0.5 ms"
LEAN = 10
"""Angle of the balls' axis from the level [°]."""


def _tumbling_rate(theta: float) -> float:
    """Rate at which the balls turn about a centre at rest, on the lower one [√(g/R)]."""
    pair = Body(lambda t: 1 - ca.cos(t), axial=0.4, transverse=1.4, between=(1.0, 3.1))
    return float(pair.family("tumbling", "rough").member([theta], [0.4, 1.4])[2])


def balls() -> list[BenchmarkRow]:
    """Rows of the hurricane balls: the rate at which one lifts, and the inclination of a rate."""
    rate = _tumbling_rate(math.pi / 2) * math.sqrt(9.81 / 0.008) / (2 * math.pi)
    inclined = math.sin(math.radians(LEAN))
    cosine = 0.4 - 1 / _tumbling_rate(math.pi / 2 + math.radians(LEAN)) ** 2
    what = f"its cos θ at the rate of tumbling {LEAN}° from the level"
    return [
        printed_row(RATE, "rate above which one ball lifts", "9", (rate, None), unit="Hz"),
        printed_row(INCLINATION, what, f"{cosine:.14f}", (inclined, None)),
    ]


def toy() -> list[BenchmarkRow]:
    """Row of the toy: mass of a disk with round edges, by Pappus, in balls."""
    with precision(BITS):
        R, h, f, density = (arb(v) for v in ("0.03755", "0.0128", "0.002", "7792.2775"))
        rim = (R - f) ** 2 * f + (R - f) * arb.pi() * f**2 / 2 + 2 * f**3 / 3
        mass = density * arb.pi() * (R**2 * (h - 2 * f) + 2 * rim)
        value = (float(mass), float(upper(abs(mass - arb(float(mass))))))
    return [printed_row(TOY, "mass", ".4387", value, unit="kg")]


def coin() -> list[BenchmarkRow]:
    """Row of the coin: how far its contact has moved along x in half a second."""
    theta, rate = math.pi / 2 + math.radians(1), 10 * math.pi
    start = {"theta": theta, "phi_dot": rate, "omega3": rate * math.cos(theta)}
    disk = Disk(k=0.25, mass=1.0, radius=0.01, gravity=9.81)
    run = simulate(disk, Rough(), start, [0.0, 0.25, 0.5], pose=True)
    moved = float(run["contact_x"][-1] - run["contact_x"][0])
    what = "x of the contact at 0.5 s"
    return [printed_row(COIN, what, ".002004099927", (moved, None), unit="m", note=ERROR)]


def without_value() -> list[BenchmarkRow]:
    """Rows of what is not covered."""
    words = "inclination, forbidden region, critical aspect ratio"
    none = "the numbers of its disk were not at hand"
    return [
        printed_row(CYLINDER, words, "words", None, note="the abstract prints no number"),
        printed_row(PLANE, "limit of spinning", "7.7459667", None, note=none),
        printed_row(PLANE, "limit of precession", "8.9442719", None, note=none),
    ]


TABLE = of_printed_values(
    "values that are printed of spinning toys: printed, recomputed, difference",
    (balls, toy, coin, without_value),
    about=About(
        "page, code or abstract for each toy, named in its rows",
        "nothing; the values are quoted at second hand",
        "steady members and one motion by this package; a mass by its closed form, in balls",
        Standing.RECOMPUTED,
        largest=3e-2,
    ),
    cites=cited(model=True),
    home=f"{__name__}:TABLE",
)
"""The table for the registry."""
