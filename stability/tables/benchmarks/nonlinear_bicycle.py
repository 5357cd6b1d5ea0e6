"""The nonlinear bicycle: four bodies, nine coordinates, six rolling constraints."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cache
from typing import Any

import casadi as ca
import numpy as np

from ...systems.family import Family
from ...systems.mechanics import mechanics
from ...systems.system import System
from .linear_bicycle import BENCHMARK, of_spectrum, of_speeds
from .row import PUBLISHED, BenchmarkRow, Source, compared

MOVING = Source("nonlinear bicycle", "Basu-Mandal et al., Proc. R. Soc. A 463 (2007) 1983, Table 1")
STRAIGHT = Source("nonlinear bicycle, straight", "Meijaard et al., Proc. R. Soc. A 463 (2007) 1955")
COORDINATES = ("x", "y", "z", "yaw", "lean", "pitch", "steer", "rear", "front")
"""Coordinates; axes x forward, y right, z down."""
GIVEN = {
    "z": "0.2440472102925",
    "theta": "0.0",
    "psi": "0.9501292851472",
    "phi": "3.1257073014894",
    "psif": "0.2311385135743",
    "xd": "-2.8069345714545",
    "yd": "-0.1480982396001",
    "zd": "0.1058778746261",
    "thetad": "0.7830033527065",
    "psid": "0.6068425835418",
    "phid": "-0.0119185528069",
    "psifd": "0.4859824687093",
    "betard": "8.9129896614890",
    "betafd": "8.0133620584155",
}
"""State of Table 1 as printed, as in DynamicistToolKit's `basu_table_one_input`."""
ACCELERATIONS = {
    "xdd": "-.5041626315047",
    "ydd": "-.3449706619454",
    "zdd": "-1.4604528332980",
    "thetadd": ".8353281706379",
    "psidd": "-7.8555281128244",
    "phidd": ".1205543897884",
    "psifdd": "-4.6198904039403",
    "betardd": "1.8472554144217",
    "betafdd": "2.4548072904550",
}
"""Accelerations of Table 1, as in `basu_table_one_output`."""
SIGNS = np.array([-1, 1, -1, -1, -1, -1, -1, 1, 1])
"""From the paper's velocities to those of the coordinates, in which wheels turn to the front."""
ROUNDING = 0.5e-13
"""Largest rounding of a number of the published state."""
DOWN = ca.SX([0, 0, 1])


def _turn(axis: int, angle: ca.SX) -> ca.SX:
    """Matrix of the rotation about a coordinate axis."""
    c, s, i, j = ca.cos(angle), ca.sin(angle), (axis + 1) % 3, (axis + 2) % 3
    matrix = ca.SX.eye(3)
    matrix[i, i], matrix[i, j], matrix[j, i], matrix[j, j] = c, -s, s, c
    return matrix


def _inertia(xx: ca.SX, yy: ca.SX, zz: ca.SX, xz: ca.SX | float = 0.0) -> ca.SX:
    """Inertia matrix of a body that is symmetric about its xz plane."""
    return ca.vertcat(ca.horzcat(xx, 0, xz), ca.horzcat(0, yy, 0), ca.horzcat(xz, 0, zz))


def _contact(centre: ca.SX, axle: ca.SX, radius: ca.SX, spin: ca.SX) -> ca.SX:
    """Velocity of the lowest point of a wheel, from that of its centre, as a point of its rim."""
    across = DOWN - ca.dot(DOWN, axle) * axle
    return centre + ca.cross(spin, radius * across / ca.sqrt(ca.dot(across, across)))


def model(P: Mapping[str, ca.SX]) -> dict[str, Any]:
    """Coordinates, velocities, energies, and the velocities of both contact points."""
    Q = {n: ca.SX.sym(n) for n in COORDINATES}
    U = {n: ca.SX.sym(f"{n}_rate") for n in Q}
    q, u = ca.vertcat(*Q.values()), ca.vertcat(*U.values())
    heading = _turn(2, Q["yaw"])
    rolled = heading @ _turn(0, Q["lean"])
    frame = rolled @ _turn(1, Q["pitch"])
    tilt = _turn(1, P["lam"])
    fork = frame @ tilt @ _turn(2, Q["steer"]) @ tilt.T
    spin = U["yaw"] * DOWN + U["lean"] * heading[:, 0] + U["pitch"] * rolled[:, 1]
    fork_spin = spin + U["steer"] * (frame @ tilt)[:, 2]
    rear_spin = spin - U["rear"] * frame[:, 1]
    front_spin = fork_spin - U["front"] * fork[:, 1]
    rear = ca.vertcat(Q["x"], Q["y"], Q["z"])
    hub = ca.vertcat(0, 0, -P["rR"])  # the rear hub; the origin of the figures is below it
    body = rear + frame @ (ca.vertcat(P["xB"], 0, P["zB"]) - hub)
    pin = ca.vertcat(P["w"] + P["c"], 0, 0)  # where the steering axis meets the ground
    front, handle = (
        rear + frame @ (pin - hub) + fork @ (ca.vertcat(x, 0, z) - pin)
        for x, z in ((P["w"], -P["rF"]), (P["xH"], P["zH"]))
    )
    parts = (
        (P["mR"], rear, frame, rear_spin, _inertia(P["IRxx"], P["IRyy"], P["IRxx"])),
        (P["mB"], body, frame, spin, _inertia(P["IBxx"], P["IByy"], P["IBzz"], P["IBxz"])),
        (P["mH"], handle, fork, fork_spin, _inertia(P["IHxx"], P["IHyy"], P["IHzz"], P["IHxz"])),
        (P["mF"], front, fork, front_spin, _inertia(P["IFxx"], P["IFyy"], P["IFxx"])),
    )
    kinetic = potential = ca.SX(0)
    for mass, place, axes, omega, moments in parts:
        local = axes.T @ omega
        kinetic += (mass * ca.sumsqr(ca.jtimes(place, q, u)) + ca.dot(local, moments @ local)) / 2
        potential -= mass * P["g"] * place[2]
    rear_slip = _contact(ca.jtimes(rear, q, u), frame[:, 1], P["rR"], rear_spin)
    front_slip = _contact(ca.jtimes(front, q, u), fork[:, 1], P["rF"], front_spin)
    return {
        "q": q,
        "u": u,
        "kinetic": kinetic,
        "potential": potential,
        "velocity_constraints": ca.vertcat(rear_slip, front_slip),
    }


def _system(**choice: Any) -> System:
    p = {n: ca.SX.sym(n) for n in BENCHMARK}
    return mechanics(p=ca.vertcat(*p.values()), **model(p), name="nonlinear bicycle", **choice)


@cache
def straight() -> Family:
    """Straight running, by the rate of the rear wheel."""
    system = _system(
        independent=("lean_rate", "steer_rate", "rear_rate"),
        ignorable=("x", "y", "yaw", "rear", "front"),
    )
    held = dict.fromkeys((n for n in system.states if n != "rear_rate"), 0.0)
    held["z"] = -BENCHMARK["rR"]
    return Family(system, "straight", at=("rear_rate",), held=held, typical=BENCHMARK)


def accelerations() -> tuple[list[float], list[float]]:
    """The nine accelerations in the paper's symbols, and what the state's rounding can change.

    Returns
    -------
    values, bounds
    """
    system = _system()
    g = {name: float(digits) for name, digits in GIVEN.items()}
    place = [
        0.0,
        0.0,
        -g["z"],
        -g["theta"],
        math.pi / 2 - g["psi"],
        math.pi - g["phi"],
        -g["psif"],
        0.0,
        0.0,
    ]
    rates = SIGNS * [v for n, v in g.items() if n.endswith("d")]
    x, values = [*place, *rates], list(BENCHMARK.values())
    found = SIGNS * system.rates(x, values)[9:]
    slopes = system.linearise(x, values)[9:]
    return found.tolist(), (abs(slopes).sum(axis=1) * ROUNDING).tolist()


def nonlinear_bicycle() -> list[BenchmarkRow]:
    """Rows of the nonlinear bicycle: nine accelerations, spectrum, weave and capsize.

    Returns
    -------
    list of BenchmarkRow
    """
    values, bounds = accelerations()
    rows = [
        compared(MOVING, f"acceleration {name}", known, value, origin=PUBLISHED, inputs=bound)
        for (name, known), value, bound in zip(ACCELERATIONS.items(), values, bounds, strict=True)
    ]
    radius = BENCHMARK["rR"]
    brackets = {"weave": (10.0, 17.0), "capsize": (17.0, 25.0)}
    found = of_spectrum(STRAIGHT, straight(), 5.0 / radius, zeros=3)
    return [*rows, *found, *of_speeds(STRAIGHT, straight(), brackets, radius)]
