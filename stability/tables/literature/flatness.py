"""Table of the last stage of a spun disk: its decay by several laws, simulated and by energy."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from typing import cast

import numpy as np
import xarray
from scipy.interpolate import CubicSpline

from ...base.errors import StabilityError
from ...base.types import Floats, Progress
from ...bodies.contact_laws import Viscous
from ...bodies.disk import Disk
from ...bodies.resistance import Resistance
from ...motion.simulate import simulate
from ..conditions import K
from ..formats.about import About, Standing
from ..formats.column import Column, word
from ..formats.table import Definition
from .flat_laws import LAWS, Law, rim_disk

START, HIGH, LOW, RATIO = 0.04, 0.03, 0.01, 1.5
"""Inclinations [rad]: at the start, and of the two stretches that are timed, with their ratio."""
SLOW = 1e-3
"""Rate of decay at the start, da/dt over a; the precession is some ten thousand times as fast."""
SLIDING = 20.0
"""Coefficient of viscous sliding, which keeps the centre at rest."""
WEAK = 1e-3 * SLIDING
"""Largest coefficient of a law: sliding changes the power of a law by some c over `SLIDING`."""
POINTS = 801
"""Times of a simulated motion."""


@dataclass(frozen=True)
class FlatRow:
    """How a disk comes down by one law."""

    law: str
    """Name of the law."""
    source: str
    """Where the law is from."""
    k: float
    """Inertia factor [-]."""
    decay: str
    """Inclination over time, by energy."""
    formula: float
    """Exponent p of da/dt = -C a^p by energy."""
    simulated: float
    """The same from a simulated motion."""
    difference: float
    """Simulated minus formula."""
    coefficient: str
    """C by energy."""
    relative: float
    """Simulated C over that by energy, minus 1."""


def flat_rows(*, k: Sequence[float] = (0.25,), progress: Progress | None = None) -> list[FlatRow]:
    """Decay of the inclination near flatness, simulated and by energy.

    Parameters
    ----------
    k
        Inertia factors [-].
    progress
        Called with (motions done, motions in all).

    Returns
    -------
    list of FlatRow

    Raises
    ------
    StabilityError
        If a motion does not come down far enough to be measured.

    Source: energy of tumbling; tests/tables/test_literature.py.
    """
    cases = [(law, value) for value in k for law in LAWS]
    rows = []
    for done, (law, value) in enumerate(cases, start=1):
        rows.append(_row(law, value))
        if progress is not None:
            progress(done, len(cases))
    return rows


def _row(law: Law, k: float) -> FlatRow:
    c = SLOW * START ** (1 - law.power) / law.coefficient(1.0, k)  # each law as slow at the start
    c = min(c, WEAK)
    run = descent(law, k, c)
    power, rate = measured(run.time.values, np.ravel(run.theta.values), law.power)
    return FlatRow(
        law.name,
        law.source,
        k,
        law.decay,
        law.power,
        power,
        power - law.power,
        law.formula,
        rate / law.coefficient(c, k) - 1,
    )


def descent(law: Law, k: float, c: float) -> xarray.Dataset:
    """A simulated motion from tumbling at the inclination `START` to one below `LOW`.

    Parameters
    ----------
    law
        The law.
    k
        Inertia factor [-].
    c
        Coefficient of the law.

    Returns
    -------
    xarray.Dataset
    """
    turn = (k * math.sin(START)) ** -0.5
    times = np.linspace(0.0, _time(law, law.coefficient(c, k), START, 0.9 * LOW), POINTS)
    if isinstance(law.by, type) and issubclass(law.by, Resistance):
        start = {"theta": START, "phi_dot": turn}
        resistance = cast(Callable[[float], Resistance], law.by)
        return simulate(
            Disk(k=k),
            Viscous(SLIDING),
            start,
            times,
            resistance=resistance(c),
            check=False,
            max_seconds=60.0,
            max_steps=10**7,
        )
    system = rim_disk(law.by)
    rest = dict.fromkeys(system.states, 0.0)
    moving = {"theta": START, "dphi": turn, "dpsi": -turn * math.cos(START)}
    return simulate(
        system,
        [k, SLIDING, c],
        rest | moving,
        times,
        check=False,
        max_seconds=60.0,
        max_steps=10**7,
    )


def _time(law: Law, rate: float, high: float, low: float) -> float:
    """Time between two inclinations by energy."""
    if law.power == 1:
        return math.log(high / low) / rate
    p = 1 - law.power
    return float((high**p - low**p) / (p * rate))


def measured(times: Floats, angle: Floats, power: float) -> tuple[float, float]:
    """Exponent and coefficient of da/dt = -C a^p from the times of two stretches.

    Both stretches have the same ratio of inclinations, so that their times have the ratio of their
    inclinations to the power 1 - p, for every C.

    Parameters
    ----------
    times, angle
        A motion that comes down, shape (t,).
    power
        Exponent for the coefficient.

    Returns
    -------
    tuple of float

    Raises
    ------
    StabilityError
        If the motion does not reach `LOW`.

    Examples
    --------
    >>> t = np.linspace(0, 0.99, 400)
    >>> p, c = measured(t, 0.04 * (1 - t) ** 0.5, -1.0)
    >>> round(p, 6), round(c / 0.0008, 6)
    (-1.0, 1.0)
    """
    seen = np.isfinite(angle)
    if not (angle[seen] < LOW).any():
        raise StabilityError(
            f"the motion ends at an inclination of {angle[seen][-1]:.3g} rad, above {LOW} rad."
        )
    last = int(np.argmax(angle[seen] < LOW)) + 2
    spline = CubicSpline(times[seen][:last], np.log(angle[seen][:last]))
    ends = [HIGH, HIGH / RATIO, LOW * RATIO, LOW]
    at = [float(spline.solve(math.log(a), extrapolate=False)[0]) for a in ends]
    upper, lower = at[1] - at[0], at[3] - at[2]
    found = 1 - math.log(lower / upper) / math.log(LOW * RATIO / HIGH)
    p = 1 - power
    grown = math.log(HIGH / LOW) if p == 0 else (HIGH**p - LOW**p) / p
    return found, grown / (at[3] - at[0])


NOTES = (
    "a: inclination; da/dt = -C a^p.  Formula: energy 3/2 m g R a and the power of the law while "
    "the disk tumbles with its centre at rest.",
    f"Simulated: all equations, from {START} rad, with viscous sliding; p and C from the times "
    f"between {HIGH} and {LOW} rad.  Units m = R = g = 1, c: coefficient of the law.",
)
"""Lines below the rows."""

TABLE = Definition(
    "how a spun disk comes down: exponents near flatness by the law of dissipation",
    (
        word("law", "law of dissipation", share=0.2),
        word("source", "where the law is from", "below"),
        K,
        word("decay", "inclination over time, by energy"),
        Column("formula", "exponent p of da/dt = -C a^p, by energy", form="{:g}"),
        Column("simulated", "the same from a simulated motion", form="{:.5f}"),
        Column("difference", "simulated minus formula", form="{:.1e}"),
        word("coefficient", "C by energy, for the law's coefficient c"),
        Column("relative", "simulated C over that by energy, minus 1", form="{:.1e}"),
    ),
    lambda **options: [asdict(row) for row in flat_rows(**options)],
    ("k", "progress"),
    lambda table: NOTES,  # noqa: ARG005
    about=About(
        "Le Saux, Leine & Glocker (2005); Moffatt (2000); this package's resistances",
        "laws, and Moffatt's time to rest, seen at second hand; no table of exponents",
        "exponents and coefficients from simulated motions, and from the balance of energy",
        Standing.RECOMPUTED,
        largest=3e-3,
    ),
    home=f"{__name__}:TABLE",
)
"""The table for the registry."""
