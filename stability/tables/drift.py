"""Table of the slow drift of rolling, which linear stability leaves open."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from ..base.citation import MODEL
from ..base.errors import NameUnknownError, shown
from ..base.quantities import Kind
from ..bodies.contact_laws import Contact, law_named
from ..bodies.disk import Disk
from ..boundary.drift import FORMULAS, drift
from .conditions import MU, K
from .table import About, Column, Definition, Standing, units_note

RATIOS = (1.25, 1.5, 2.0, 3.0)
"""Values of omega3 over its threshold in the table of drift."""


def drift_rows(
    *,
    k: Sequence[float] = (0.25, 0.5),
    mu: Sequence[float] = (0.1, 1.0, 10.0),
    tilt: Sequence[float] = (0.01,),
    disk: Disk | None = None,
    law: str = "viscous",
) -> list[dict[str, float]]:
    """How long straight rolling lasts, to leading order in the tilt.

    Parameters
    ----------
    k, mu, tilt
        Inertia factors [-], friction coefficients, tilts [rad].
    disk
        Gives mass, radius, gravity.
    law
        viscous or linear-viscous.

    Source: tests/boundary/test_drift.py.

    Examples
    --------
    >>> rows = drift_rows(k=(0.25,), mu=(1.0,))
    >>> [round(r["time_launch"] / r["time_slow"], 3) for r in rows]
    [0.798, 0.857, 0.918, 0.963]
    """
    rows = []
    for inertia in k:
        body = replace(disk or Disk(), k=inertia)
        threshold = float(body.rate) / (2 * inertia) ** 0.5
        for value in mu:
            for angle in tilt:
                for ratio in RATIOS:
                    at = ratio * threshold
                    slow, fast = (
                        drift(at=at, tilt=angle, disk=body, contact=law_of(law, value), launch=f)
                        for f in (False, True)
                    )
                    rows.append(
                        {
                            "k": inertia,
                            "mu": value,
                            "omega3": at,
                            "threshold": threshold,
                            "tilt": angle,
                            "time_slow": slow.time,
                            "time_launch": fast.time,
                            "tilt_end": fast.tilt_end,
                        }
                    )
    return rows


def law_of(name: str, mu: float) -> Contact:
    """The contact law of a table on slipping disks, by its name.

    Parameters
    ----------
    name
        viscous or linear-viscous.
    mu
        Friction coefficient [s/m].

    Raises
    ------
    NameUnknownError
        If the name is another.
    """
    if name not in ("viscous", "linear-viscous"):
        raise NameUnknownError(
            f"contact is {shown(name)}; this table has viscous and linear-viscous."
        )
    return law_named(name, mu)


DRIFT_NOTES = [
    "Spectrally stable rolling is Lyapunov-unstable: with any slow tilt, however small, tilt and",
    "spin drift by a finite amount, near the line of rolling until the threshold is crossed; to",
    "leading order in the tilt (relative error of the order of tilt²), with w = omega3 and",
    "tilt = theta - π/2, dimensionless,",
    *[f"  {name}: {formula}" for name, formula in FORMULAS.items()],
]
"""Lines below the rows of the table of drift."""

TABLE = Definition(
    "how long straight rolling under friction lasts before it crosses its threshold",
    (
        K,
        MU,
        Column(
            "omega3", "axial angular velocity at the start", Kind.ANGULAR_VELOCITY, r"\omega_{3}"
        ),
        Column(
            "threshold",
            "axial angular velocity where spectral stability ends",
            Kind.ANGULAR_VELOCITY,
            r"\omega_{3,c}",
        ),
        Column("tilt", "theta - π/2 at the start", Kind.ANGLE, form="{:g}"),
        Column("time_slow", "time to the threshold on the slow manifold", Kind.TIME, "T_{s}"),
        Column(
            "time_launch",
            "time to the threshold from a launch with phi_dot = 0 and no slip",
            Kind.TIME,
            "T_{l}",
        ),
        Column("tilt_end", "tilt at the threshold after the launch", Kind.ANGLE, form="{:.4g}"),
    ),
    drift_rows,
    ("k", "mu", "contact", "disk", "tilt"),
    lambda table: [*DRIFT_NOTES, units_note(table)],
    about=About(
        "this package: the slow manifold of rolling",
        "no value",
        "times by the closed form; tests compare them with simulated motions",
        Standing.DERIVED,
    ),
    cites=MODEL,
    home=f"{__name__}:TABLE",
)
"""The table for the registry."""
