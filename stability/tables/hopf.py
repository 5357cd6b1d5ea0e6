"""Table of flutter on lines of steady motions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from ..base.citation import MODEL
from ..base.errors import listed
from ..base.types import Progress
from ..bodies.disk import Disk
from ..bodies.families import FAMILIES
from ..boundary.hopf import hopf
from .conditions import FREQUENCY, MU, K, member
from .drift import law_of
from .table import About, Column, Definition, Standing, units_note, word

NONE: dict[str, Any] = {
    **dict.fromkeys(("at", "frequency", "crossing", "push")),
    "stable": "-",
    "kind": "none",
}
"""Row of a line without a boundary."""


def hopf_rows(
    *,
    k: Sequence[float] = (0.25, 0.375, 0.5),
    mu: Sequence[float] = (0.5, 0.8, 1.0, 2.0),
    disk: Disk | None = None,
    law: str = "viscous",
    progress: Progress | None = None,
) -> list[dict[str, Any]]:
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

    Source: tests/boundary/test_hopf.py.

    Examples
    --------
    >>> [(r["family"], r["kind"]) for r in hopf_rows(k=(0.5,), mu=(1.0,))]
    [('spinning', 'elliptic'), ('tumbling', 'hyperbolic')]
    """
    rows: list[dict[str, Any]] = []
    lines = [name for name, family in FAMILIES.items() if family.flutter]
    asked = [(f, inertia, value) for f in lines for inertia in k for value in mu]
    for done, (family, inertia, value) in enumerate(asked, start=1):
        onsets = hopf(family, contact=law_of(law, value), disk=replace(disk or Disk(), k=inertia))
        line = {"family": family, "k": inertia, "mu": value}
        points = [
            {
                "at": p.at,
                "stable": "below" if p.stable_below else "above",
                "frequency": p.frequency,
                "crossing": p.crossing,
                "push": p.push,
                "kind": p.kind.word,
            }
            for p in onsets
        ]
        rows += [line | point for point in points or [NONE]]
        if progress:
            progress(done, len(asked))
    return rows


HOPF_NOTES = [
    "dy/dt = c |z|², d|z|/dt = Re μ' y |z| with y along the family and z along the mode of unit",
    "length; c < 0 throughout: energy rises along both families and falls while the rim slips.",
    "elliptic: near the unstable part a motion swings out and settles as far beyond;",
    "hyperbolic: it leaves a neighbourhood, and may settle elsewhere on the family; near the",
    "stable part only motions inside a cone settle nearby.",
    "Re μ' vanishes only where the boundary folds (tumbling, 0.3291… < k < 1/2).",
]
"""Lines below the rows of the table of flutter boundaries."""

_LINES = listed([f.name for f in FAMILIES.values() if f.flutter])
TABLE = Definition(
    f"flutter boundaries of {_LINES} as Hopf bifurcations without parameters",
    (
        word("family", "family of steady motions", "group"),
        K,
        MU,
        Column("at", "member at the boundary", member, "", "{:.12g}", "family"),
        word("stable", "stable side of the boundary"),
        FREQUENCY,
        Column("crossing", "Re μ' along the family, dimensionless", latex=r"\mathrm{Re}\,\mu'"),
        Column("push", "coefficient of the drift, dimensionless", latex="c"),
        word("kind", "elliptic, hyperbolic, degenerate, or none"),
    ),
    hopf_rows,
    ("k", "mu", "contact", "disk", "progress"),
    lambda table: [*HOPF_NOTES, units_note(table)],
    about=About(
        "this package: Hopf bifurcations of lines of steady motions",
        "no value",
        "kinds from the centre manifold; tests compare them with simulated motions",
        Standing.DERIVED,
    ),
    cites=MODEL,
    home=f"{__name__}:TABLE",
)
"""The table for the registry."""
