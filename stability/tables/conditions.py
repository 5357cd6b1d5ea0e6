"""Table of stability conditions: where verdicts change along each family."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from ..base.citation import cited
from ..base.errors import NameUnknownError, ParameterError, shown
from ..base.quantities import Kind, Quantity
from ..bodies.contact import Contact
from ..bodies.contact_laws import LAWS
from ..bodies.disk import Disk
from ..bodies.families import FAMILIES, SteadyFamily
from ..bodies.quantities import QUANTITIES
from ..boundary.changes import along
from ..boundary.crossings import BoundaryPoint
from ..spectra.disk_problem import disk_problem
from .disk_formulas import formula_latex, formula_lines
from .formats.about import About, Standing
from .formats.column import Column, word
from .formats.latex import latex
from .formats.plain import plain
from .formats.table import Definition, Table


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
        `at` is searched over `SteadyFamily.searched` (in √(g/R), or rad for tumbling; tumbling ends
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


def scan(family: SteadyFamily, disk: Disk, contact: Contact) -> list[BoundaryPoint]:
    """Every change of verdict along the family, over `searched` of its record."""
    assert family.searched is not None
    low, high = family.searched
    unit = family.unit(float(disk.rate))
    problem = disk_problem(family.name, disk, contact)
    found = along(problem, "at", low * unit, high * unit)
    found.warn("at")
    return list(found)


def _rows(family: SteadyFamily, disk: Disk, contact: Contact) -> list[ConditionRow]:
    from ..spectra.spectrum import spectrum

    mu = contact.given.get("mu")
    points = scan(family, disk, contact)
    good = "neutral" if contact.conservative else "stable"
    common: dict[str, Any] = {
        "family": family.name,
        "contact": contact.name,
        "k": float(disk.k),
        "mu": mu,
    }
    if not points:
        assert family.searched is not None
        low, high = family.searched
        middle = math.sqrt(low * high) * family.unit(float(disk.rate))
        verdict = spectrum(family.name, at=middle, disk=disk, contact=contact).verdict.word
        return [
            ConditionRow(
                **common,
                at=None,
                error=None,
                crossing="none",
                frequency=None,
                below=verdict,
                above=verdict,
            )
        ]
    return [
        ConditionRow(
            **common,
            at=p.value,
            error=p.error,
            crossing=p.crossing.word,
            frequency=p.frequency,
            below=good if p.stable_below else "unstable",
            above="unstable" if p.stable_below else good,
        )
        for p in points
    ]


def _formulas(
    *,
    k: Sequence[float] = (0.25, 0.5),
    laws: Sequence[str] = ("smooth", "viscous", "rough"),
    progress: Callable[[int, int], None] | None = None,
    **_: Any,
) -> dict[str, Any]:
    from ..derivation.formulas import rows

    return {"formulas": [asdict(one) for one in rows(laws, k, progress)]}


def _notes(table: Table) -> list[str]:
    kinds: dict[str, list[str]] = {}
    for family in FAMILIES.values():
        if family.searched:
            kind = Kind.ANGLE if family.by_angle else Kind.ANGULAR_VELOCITY
            unit = kind.label(dimensionless=table.dimensionless)
            kinds.setdefault(unit, []).append(f"{family.at[0]} ({family.name})")
    names = ", ".join(f"{', '.join(words)} in {u}" for u, words in kinds.items())
    ranges = [
        f"{f.name} {f.searched[0]:g}…{f.searched[1]:.4g}" for f in FAMILIES.values() if f.searched
    ]
    frequency = Kind.ANGULAR_VELOCITY.label(dimensionless=table.dimensionless)
    return [
        f"at: {names}; frequency in {frequency}.",
        f"Searched: {', '.join(ranges)} "
        "(dimensionless), completely: every real root of the conditions over Q is isolated; each "
        "place is a bracket proved in ball arithmetic.",
    ]


def _text(table: Table) -> str:
    return "\n".join([*formula_lines(table.more["formulas"]), plain(table)])


def _latex(table: Table) -> str:
    return "\n\n".join([formula_latex(table.more["formulas"]), latex(table)])


def member(family: str) -> Quantity | None:
    """The quantity that names a member of a family, if it is one.

    Parameters
    ----------
    family
        Name of the family.
    """
    names = FAMILIES[family].at if family in FAMILIES else ()
    return QUANTITIES[names[0]] if len(names) == 1 else None


K = Column("k", "inertia factor", latex="k", form="{:g}")
MU = Column("mu", "friction coefficient", Kind.INVERSE_VELOCITY, r"\mu", "{:g}")
TABLE = Definition(
    "where the verdict changes along each family, for several k and mu",
    (
        word("family", "family of steady motions", "group"),
        word("contact", "contact law", "group"),
        K,
        MU,
        Column("at", "member where the verdict changes", member, "", "{:.12g}", "family"),
        Column(
            "error",
            "half-width of the proved bracket around at",
            member,
            r"\pm",
            "{:.1e}",
            "family",
        ),
        word("crossing", "static, flutter or none"),
        Column(
            "frequency",
            "frequency of the crossing pair",
            Kind.ANGULAR_VELOCITY,
            r"\omega",
            "{:.10g}",
        ),
        word("below", "verdict below at, or everywhere"),
        word("above", "verdict above at, or everywhere"),
    ),
    lambda **options: [asdict(row) for row in conditions(**options)],
    ("k", "mu", "contact", "disk", "progress"),
    _notes,
    _text,
    _latex,
    _formulas,
    about=About(
        "Przybylska & Rauch-Wojciechowski, Regul. Chaotic Dyn. 21 (2016) 204-231",
        "no value",
        "every change of verdict in a bracket with proved ends, for the package's laws",
        Standing.RECOMPUTED,
    ),
    cites=cited(model=True, proofs=True),
    home=f"{__name__}:TABLE",
)
"""The table for the registry."""
