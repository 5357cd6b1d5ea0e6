"""Table of stability conditions: where verdicts change along each family."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from ..base.errors import NameUnknownError, ParameterError, shown
from ..bodies.contact import Contact
from ..bodies.contact_laws import LAWS
from ..bodies.disk import Disk
from ..bodies.thin_disk.disk_families import FAMILIES, DiskFamily
from ..boundary.changes import along
from ..boundary.crossings import BoundaryPoint
from ..spectra.disk_problem import disk_problem


@dataclass(frozen=True)
class ConditionRow:
    """One change of verdict along a family, or none."""

    family: str
    """Name of the family."""
    contact: str
    """Contact law."""
    k: float
    """Inertia factor [-]."""
    mu: float | None
    """Friction coefficient in the user's unit, or None for a law without one."""
    at: float | None
    """Family parameter where the verdict changes, or None without a change."""
    error: float | None
    """Half-width of the proved bracket around `at`."""
    crossing: str
    """static, flutter, or none."""
    frequency: float | None
    """Frequency of the crossing pair."""
    below: str
    """Verdict below `at` (or everywhere)."""
    above: str
    """Verdict above `at` (or everywhere)."""


def conditions(
    *,
    k: Sequence[float] = (0.25, 0.3125, 0.5),
    mu: Sequence[float] = (0.1, 0.3, 1.0, 3.0, 10.0),
    disk: Disk | None = None,
    laws: Sequence[str] = ("smooth", "viscous", "rough"),
    progress: Callable[[int, int], None] | None = None,
) -> list[ConditionRow]:
    """Changes of the verdict along each family, each with a proved bracket.

    Parameters
    ----------
    k
        Inertia factors [-].
    mu
        Friction coefficients, in the unit of the disk.
    disk
        Gives mass, radius, gravity.
    laws
        Contact laws.
    progress
        Called with (lines done, lines in all).

    Returns
    -------
    list of ConditionRow
        `at` is searched over `DiskFamily.searched` (in √(g/R), or rad for tumbling; tumbling ends
        at upright, since larger angles are its mirror image).

    Source: recomputed; thresholds are tested in tests/spectra/test_published.py.

    Examples
    --------
    >>> rows = conditions(k=(0.25,), mu=(0.3,), laws=("viscous",))
    >>> [(r.family, r.crossing) for r in rows]
    [('rolling', 'flutter'), ('spinning', 'static'), ('tumbling', 'none')]
    """
    base = Disk() if disk is None else disk
    bodies = [Disk(base.mass, base.radius, inertia, base.gravity) for inertia in k]
    asked = [
        (family, body, contact)
        for family in FAMILIES.values()
        if family.searched
        for body in bodies
        for law in laws
        if family.law in ("", law)
        for contact in _contacts(law, mu)
    ]
    rows: list[ConditionRow] = []
    for done, problem in enumerate(asked, start=1):
        rows += _rows(*problem)
        if progress:
            progress(done, len(asked))
    return rows


def _contacts(law: str, mu: Sequence[float]) -> list[Contact]:
    if law not in LAWS:
        raise NameUnknownError(f"contact is {shown(law)}; known are {', '.join(LAWS)}.")
    if not LAWS[law].parameters:
        return [LAWS[law]()]
    if len(LAWS[law].symbols()) > 1:
        raise ParameterError(f"contact is {law}; the table is of laws of one coefficient, mu.")
    of_mu: Any = LAWS[law]
    return [of_mu(mu=m) for m in mu]


def scan(family: DiskFamily, disk: Disk, contact: Contact) -> list[BoundaryPoint]:
    """Every change of verdict along the family, over `searched` of its record."""
    assert family.searched is not None
    low, high = family.searched
    unit = family.unit(float(disk.rate))
    problem = disk_problem(family.name, disk, contact)
    found = along(problem, "at", low * unit, high * unit)
    found.warn("at")
    return list(found)


def _rows(family: DiskFamily, disk: Disk, contact: Contact) -> list[ConditionRow]:
    from ..spectra.spectrum import spectrum

    mu = contact.given.get("mu")
    points = scan(family, disk, contact)
    good = "neutral" if contact.conservative else "stable"
    common: dict[str, Any] = {
        "family": family.name, "contact": contact.name, "k": float(disk.k), "mu": mu,
    }  # fmt: skip
    if not points:
        assert family.searched is not None
        low, high = family.searched
        middle = math.sqrt(low * high) * family.unit(float(disk.rate))
        verdict = spectrum(family.name, at=middle, disk=disk, contact=contact).verdict.word
        return [ConditionRow(**common, at=None, error=None, crossing="none", frequency=None,
                             below=verdict, above=verdict)]  # fmt: skip
    return [
        ConditionRow(
            **common, at=p.value, error=p.error, crossing=p.crossing.word, frequency=p.frequency,
            below=good if p.stable_below else "unstable",
            above="unstable" if p.stable_below else good,
        )
        for p in points
    ]  # fmt: skip
