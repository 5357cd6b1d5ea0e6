"""Tables of what linear stability leaves open: rolling's drift, and flutter on lines of motions."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from .contact import Contact, LinearViscous, Viscous
from .disk import Disk
from .errors import NameUnknownError, shown
from .lines import hopf
from .passage import FORMULAS, drift

RATIOS = (1.25, 1.5, 2.0, 3.0)
"""omega3 over its threshold, for which the table of drift is worked out."""
Progress = Callable[[int, int], None]


@dataclass(frozen=True)
class DriftRow:
    """How long straight rolling lasts."""

    k: float
    """Inertia factor [-]."""
    mu: float
    """Friction coefficient in the user's unit."""
    omega3: float
    """At the start."""
    threshold: float
    """omega3 where spectral stability ends."""
    tilt: float
    """theta - π/2 at the start [rad]."""
    time_slow: float
    """Time to the threshold from the slow manifold."""
    time_launch: float
    """The same from a launch with phi_dot = 0 and no slip."""
    tilt_end: float
    """Tilt at the threshold after the launch [rad]."""


@dataclass(frozen=True)
class HopfRow:
    """A flutter boundary along spinning or tumbling, or none."""

    family: str
    """Name."""
    k: float
    """Inertia factor [-]."""
    mu: float
    """Friction coefficient in the user's unit."""
    at: float | None
    """Where on the family, or None if there is none."""
    stable: str
    """Which side of it is stable."""
    frequency: float | None
    """Of the pair."""
    crossing: float | None
    """Re μ' along the line, dimensionless."""
    push: float | None
    """c, dimensionless."""
    kind: str
    """elliptic, hyperbolic, degenerate, or none."""


def drift_rows(
    *,
    k: Sequence[float] = (0.25, 0.5),
    mu: Sequence[float] = (0.1, 1.0, 10.0),
    tilt: Sequence[float] = (0.01,),
    disk: Disk | None = None,
    law: str = "viscous",
) -> list[DriftRow]:
    """How long straight rolling lasts, to leading order in the tilt.

    Parameters
    ----------
    k, mu, tilt
        Inertia factors [-], friction coefficients, tilts [rad].
    disk
        Gives mass, radius, gravity.
    law
        viscous or linear-viscous.

    Returns
    -------
    list of DriftRow

    Source: tests/test_drift.py.

    Examples
    --------
    >>> rows = drift_rows(k=(0.25,), mu=(1.0,))
    >>> [round(r.time_launch / r.time_slow, 3) for r in rows]
    [0.798, 0.857, 0.918, 0.963]
    """
    rows = []
    for inertia in k:
        body = _body(disk, inertia)
        threshold = float(body.rate) / (2 * inertia) ** 0.5
        for value in mu:
            for angle in tilt:
                for ratio in RATIOS:
                    at = ratio * threshold
                    slow, fast = (
                        drift(at=at, tilt=angle, disk=body, contact=law_of(law, value), launch=f)
                        for f in (False, True)
                    )
                    rows.append(DriftRow(inertia, value, at, threshold, angle, slow.time, fast.time,
                                         fast.tilt_end))  # fmt: skip
    return rows


def hopf_rows(
    *,
    k: Sequence[float] = (0.25, 0.375, 0.5),
    mu: Sequence[float] = (0.5, 0.8, 1.0, 2.0),
    disk: Disk | None = None,
    law: str = "viscous",
    progress: Progress | None = None,
) -> list[HopfRow]:
    """Flutter boundaries along spinning and tumbling, with their type.

    Parameters
    ----------
    k, mu
        Inertia factors [-], friction coefficients.
    disk
        Gives mass, radius, gravity.
    law
        viscous or linear-viscous.
    progress
        Called with (lines done, lines in all).

    Returns
    -------
    list of HopfRow

    Source: tests/test_hopf.py.

    Examples
    --------
    >>> [(r.family, r.kind) for r in hopf_rows(k=(0.5,), mu=(1.0,))]
    [('spinning', 'elliptic'), ('tumbling', 'hyperbolic')]
    """
    rows: list[HopfRow] = []
    asked = [(f, inertia, value) for f in ("spinning", "tumbling") for inertia in k for value in mu]
    for done, (family, inertia, value) in enumerate(asked, start=1):
        found = hopf(family, contact=law_of(law, value), disk=_body(disk, inertia))
        rows += [
            HopfRow(family, inertia, value, p.at, "below" if p.stable_below else "above",
                    p.frequency, p.crossing, p.push, p.kind.word)
            for p in found
        ] or [HopfRow(family, inertia, value, None, "-", None, None, None, "none")]  # fmt: skip
        if progress:
            progress(done, len(asked))
    return rows


def law_of(name: str, mu: float) -> Contact:
    """The law of a table that compares with linear theory of a slipping disk.

    Parameters
    ----------
    name
        viscous or linear-viscous.
    mu
        Friction coefficient [s/m].

    Returns
    -------
    Contact

    Raises
    ------
    NameUnknownError
        If it is another.
    """
    if name not in ("viscous", "linear-viscous"):
        raise NameUnknownError(
            f"contact is {shown(name)}; this table has viscous and linear-viscous."
        )
    return Viscous(mu) if name == "viscous" else LinearViscous(mu=mu)


def _body(disk: Disk | None, k: float) -> Disk:
    base = Disk() if disk is None else disk
    return Disk(base.mass, base.radius, k, base.gravity)


DRIFT_NOTES = [
    "Spectrally stable rolling is Lyapunov-unstable: with any slow tilt, however small, tilt and",
    "spin drift by a finite amount, near the line of rolling until the threshold is crossed; to",
    "leading order in the tilt (relative error of the order of tilt²), with w = omega3 and",
    "tilt = theta - π/2, dimensionless,",
    *[f"  {name}: {formula}" for name, formula in FORMULAS.items()],
]
"""What the table of drift says below its rows."""
HOPF_NOTES = [
    "dy/dt = c |z|², d|z|/dt = Re μ' y |z| with y along the family and z along the mode of unit",
    "length; c < 0 throughout: energy rises along both families and falls while the rim slips.",
    "elliptic: beside the unstable part a motion swings out and settles as far beyond;",
    "hyperbolic: it leaves a neighbourhood, and may settle elsewhere on the family; beside the",
    "stable part only motions inside a cone settle nearby.",
    "Re μ' vanishes only where the boundary folds (tumbling, 0.3291… < k < 1/2).",
]
"""What the table of flutter boundaries says below its rows."""
