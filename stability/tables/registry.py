"""Names of the tables, and their rows as records."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from ..base.errors import NameUnknownError, listed, shown
from ..bodies.thin_disk.disk_families import FAMILIES
from .drift import drift_rows
from .hopf import hopf_rows
from .launches import launch_rows

if TYPE_CHECKING:
    pass

from .conditions import conditions
from .families import families

_LINES = listed([f.name for f in FAMILIES.values() if f.flutter])
_LAUNCHED = listed([f.name for f in FAMILIES.values() if f.launch])
TABLES = {
    "families": "the steady motions with their conditions, structural zeros and limits",
    "conditions": "where the verdict changes along each family, for several k and mu",
    "drift": "how long straight rolling under friction lasts before it crosses its threshold",
    "hopf": f"flutter boundaries of {_LINES} as Hopf bifurcations without parameters",
    "launches": f"what becomes of {_LAUNCHED} launched with a tilt, compared with linear theory",
    "theorems": "statements about the disk, proved step by step from its graph",
    "benchmarks": "systems with known answers: known value, recomputed value, certified verdicts",
    "completeness": "why the viscous disk has no other steady motions: proof and search",
}
"""Heading of each table, by name."""


# --- as records ---


def records(name: str, **options: Any) -> list[dict[str, Any]]:
    """A table as plain records, for JSON.

    Parameters
    ----------
    name
        A key of `TABLES`.
    **options
        Arguments of the table's function.

    Returns
    -------
    list of dict

    Raises
    ------
    NameUnknownError
        If the table is unknown.
    """
    if name == "families":
        return [asdict(row) for row in families()]
    if name == "conditions":
        return [asdict(row) for row in conditions(**options)]
    if name == "drift":
        return [asdict(row) for row in drift_rows(**options)]
    if name == "hopf":
        return [asdict(row) for row in hopf_rows(**options)]
    if name == "launches":
        return [asdict(row) for row in launch_rows(**options)]
    if name == "theorems":
        from .theorems import theorem_rows

        return [asdict(row) for row in theorem_rows(**options)]
    if name == "benchmarks":
        from .benchmarks.catalogue import benchmark_rows

        return [asdict(row) for row in benchmark_rows(**options)]
    if name == "completeness":
        from ..derivation.completeness import prove, search

        steps = [asdict(step) for step in prove()]
        return [*steps, {"search": asdict(search())}]
    raise NameUnknownError(f"table is {shown(name)}; known are {', '.join(TABLES)}.")
