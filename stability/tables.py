"""Tables, recomputed: the families with their conditions, and where their verdicts change."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np

from .beyond import DRIFT_NOTES, HOPF_NOTES, drift_rows, hopf_rows
from .branches import LIMITS
from .changes import along
from .contact import LAWS, Contact, LinearViscous, Viscous
from .disk import Disk
from .errors import NameUnknownError, shown
from .polynomial import structure
from .problem import disk_problem
from .steady import AT, FAMILIES, ONLY, disk_family
from .survey import NOTES as LAUNCH_NOTES
from .survey import contact_lines, launch_rows

if TYPE_CHECKING:
    from .formulas import Formulas

TABLES = {
    "families": "the steady motions with their conditions, structural zeros and limits",
    "conditions": "where the verdict changes along each family, for several k and mu",
    "drift": "how long straight rolling under friction lasts before it crosses its threshold",
    "hopf": "flutter boundaries of spinning and tumbling as Hopf bifurcations without parameters",
    "launches": "what becomes of rolling and spinning launched with a tilt, beside linear theory",
    "completeness": "why the viscous disk has no other steady motions: proof and search",
}
"""What each table holds."""
SCAN = {"rolling": (0.02, 50.0), "spinning": (0.02, 50.0), "tumbling": (1e-3, np.pi / 2)}
"""Dimensionless interval of `at` in which boundaries are looked for."""


@dataclass(frozen=True)
class FamilyRow:
    """A family of steady motions."""

    family: str
    """Name."""
    at: str
    """What names a member."""
    motion: str
    """The state, in words."""
    condition: str
    """What must hold, derived from the graph; dimensionless (m = R = g = 1)."""
    structural_zeros: dict[str, int]
    """By contact law."""
    thresholds: dict[str, list[float]]
    """Squares of `at` where the smooth and rough verdicts change, for k = 1/4."""


MOTION = {
    "rolling": "upright, rolling straight ahead",
    "spinning": "upright, turning about its vertical diameter on the spot",
    "tumbling": "inclined, its centre at rest, axial angular velocity zero",
    "circling": "inclined, its contact point running round a circle without slip",
    "precession": "inclined, its centre at rest or in uniform straight motion, without friction",
}


@lru_cache(maxsize=8)
def condition(name: str) -> str:
    """The condition for a family, solved by SymPy from the graph's own equation.

    Parameters
    ----------
    name
        One of the families.

    Returns
    -------
    str

    Examples
    --------
    >>> condition("tumbling")
    'phi_dot**2 = 1/(k*sin(theta))'
    """
    import sympy

    from .algebra import sympy_algebra

    law = ONLY.get(name, "viscous")
    family = disk_family(name, law)
    if family.closed:
        return f"none: every {family.at[0]}"
    symbols = {n: sympy.Symbol(n, positive=True) for n in (*family.at, *family.unknown, "k", "mu")}
    arguments = [
        [symbols[n] for n in names] for names in (family.at, family.unknown, family.parameters)
    ]
    _, _, residual, *_ = family.graph.tangent.run(sympy_algebra(), arguments)
    [unknown] = family.unknown
    numerator = sympy.fraction(sympy.together(sympy.simplify(residual[0])))[0]
    if name == "tumbling":
        square = sympy.Symbol("square", positive=True)
        [root] = sympy.solve(
            sympy.expand(numerator).subs(symbols[unknown], sympy.sqrt(square)), square
        )
        return f"{unknown}**2 = {sympy.simplify(root)}"
    [root] = sympy.solve(numerator, symbols[unknown])
    return f"{unknown} = {sympy.simplify(root)}"


def families() -> list[FamilyRow]:
    """The families of steady motions with their conditions, recomputed from the graph.

    Returns
    -------
    list of FamilyRow
        Thresholds are computed for the uniform disk.

    Source: equations of Przybylska & Rauch-Wojciechowski 2016; recomputed.

    Examples
    --------
    >>> [row.family for row in families()]
    ['rolling', 'spinning', 'tumbling', 'circling', 'precession']
    """
    rows = []
    for name in FAMILIES:
        laws = [ONLY[name]] if name in ONLY else list(LAWS)
        zeros = {law: structure(disk_family(name, law)).zeros for law in laws}
        thresholds: dict[str, list[float]] = {}
        if name in SCAN:
            for law in ("smooth", "rough"):
                points = _scan(name, Disk(), LAWS[law]())
                power = 1 if name == "tumbling" else 2
                thresholds[law] = [p.value**power for p in points]
        rows.append(
            FamilyRow(name, ", ".join(AT[name]), MOTION[name], condition(name), zeros, thresholds)
        )
    return rows


@dataclass(frozen=True)
class ConditionRow:
    """One change of verdict along a family, or none."""

    family: str
    """Name."""
    contact: str
    """Contact law."""
    k: float
    """Inertia factor [-]."""
    mu: float | None
    """Friction coefficient in the user's unit, or None for a law without one."""
    at: float | None
    """Where the verdict changes, or None if it does not."""
    error: float | None
    """Half-width of the proved bracket."""
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
    """Where the verdict changes along each family, each place a proved bracket.

    Parameters
    ----------
    k
        Inertia factors [-].
    mu
        Friction coefficients, in the unit that goes with the disk.
    disk
        Gives mass, radius, gravity.
    laws
        Contact laws.
    progress
        Called with (lines done, lines in all).

    Returns
    -------
    list of ConditionRow
        `at` is scanned over `SCAN` (in √(g/R); tumbling up to upright, beyond it is the mirror
        image).

    Source: recomputed; thresholds are tested in tests/test_published.py.

    Examples
    --------
    >>> rows = conditions(k=(0.25,), mu=(0.3,), laws=("viscous",))
    >>> [(r.family, r.crossing) for r in rows]
    [('rolling', 'flutter'), ('spinning', 'static'), ('tumbling', 'none')]
    """
    base = Disk() if disk is None else disk
    bodies = [Disk(base.mass, base.radius, inertia, base.gravity) for inertia in k]
    asked = [
        (name, body, contact)
        for name in SCAN
        for body in bodies
        for law in laws
        for contact in _contacts(law, mu)
    ]
    rows: list[ConditionRow] = []
    for done, question in enumerate(asked, start=1):
        rows += _rows(*question)
        if progress:
            progress(done, len(asked))
    return rows


def _contacts(law: str, mu: Sequence[float]) -> list[Contact]:
    if law not in LAWS:
        raise NameUnknownError(f"contact is {shown(law)}; known are {', '.join(LAWS)}.")
    if law == "viscous":
        return [Viscous(m) for m in mu]
    if law == "linear-viscous":
        return [LinearViscous(mu=m) for m in mu]
    return [LAWS[law]()]


def _scan(name: str, disk: Disk, contact: Contact) -> list[Any]:
    low, high = SCAN[name]
    unit = 1.0 if name == "tumbling" else float(disk.rate)
    question = disk_problem(name, disk, contact)
    found = along(question, "at", low * unit, high * unit)
    found.warn("at")
    return list(found)


def _rows(name: str, disk: Disk, contact: Contact) -> list[ConditionRow]:
    from .query import spectrum

    mu = contact.given.get("mu")
    points = _scan(name, disk, contact)
    good = "neutral" if contact.conservative else "stable"
    common: dict[str, Any] = {
        "family": name, "contact": contact.name, "k": float(disk.k), "mu": mu,
    }  # fmt: skip
    if not points:
        low, high = SCAN[name]
        middle = np.sqrt(low * high) * (1.0 if name == "tumbling" else float(disk.rate))
        verdict = spectrum(name, at=middle, disk=disk, contact=contact).verdict.word
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


# --- as text ---


def records(name: str, **options: Any) -> list[dict[str, Any]]:
    """A table as plain records, for JSON.

    Parameters
    ----------
    name
        A key of `TABLES`.
    **options
        As for the table's function.

    Returns
    -------
    list of dict

    Raises
    ------
    NameUnknownError
        If there is no such table.
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
    if name == "completeness":
        from .completeness import prove, search

        steps = [asdict(step) for step in prove()]
        return [*steps, {"search": asdict(search())}]
    raise NameUnknownError(f"table is {shown(name)}; known are {', '.join(TABLES)}.")


def text(name: str, rows: list[dict[str, Any]], unit: str) -> str:
    """A table as lines of text, headed by what it is and that it was recomputed.

    Parameters
    ----------
    name
        A key of `TABLES`.
    rows
        From `records`.
    unit
        Unit of angular velocities.

    Returns
    -------
    str
    """
    head = [f"{TABLES[name]} (recomputed)", ""]
    if name == "families":
        return "\n".join(head + _family_lines(rows))
    if name == "completeness":
        return "\n".join(head + _completeness_lines(rows))
    if name in ("drift", "hopf", "launches"):
        notes = {"drift": DRIFT_NOTES, "hopf": HOPF_NOTES, "launches": LAUNCH_NOTES}[name]
        units = f"angular velocities in {unit}; angles in rad; times in 1/({unit})"
        units = units.replace("1/(rad/s)", "s")
        if name == "launches":
            notes = (*contact_lines(rows), "", *notes)
        return "\n".join(head + _aligned(_cells(rows)) + ["", *notes, units])
    cells = _cells(rows, {"error": "± proved"})
    foot = [
        "",
        f"at: omega3 (rolling), phi_dot (spinning) in {unit}, theta (tumbling) in rad; "
        f"frequency in {unit}.",
        f"Searched: {', '.join(f'{n} {a:g}…{b:.4g}' for n, (a, b) in SCAN.items())} "
        "(dimensionless), completely: every real root of the conditions over Q is isolated; each "
        "place is a bracket proved in ball arithmetic.",
    ]
    return "\n".join(head + _aligned(cells) + foot)


FORMATS = {
    "k": "{:g}", "tilt": "{:g}", "at": "{:.12g}", "error": "{:.1e}",
    "frequency": "{:.10g}", "omega3": "{:.6g}", "threshold": "{:.6g}", "tilt_end": "{:.4g}",
    "rate": "{:+.3g}", "final_at": "{:.6g}", "time": "{:.4g}", "energy": "{:.4f}",
    "normal_force": "{:.3f}", "mu": "{:g}",
    "time_slow": "{:.6g}", "time_launch": "{:.6g}", "crossing": "{:.6g}", "push": "{:.6g}",
}  # fmt: skip
"""How each number is printed."""


def _cells(rows: list[dict[str, Any]], titles: dict[str, str] | None = None) -> list[list[str]]:
    cells = [[(titles or {}).get(key, key) for key in rows[0]]]
    for row in rows:
        cells.append([
            "-" if value is None
            else value if isinstance(value, str)
            else FORMATS[key].format(value)
            for key, value in row.items()
        ])  # fmt: skip
    return cells


def formula_lines(found: Sequence[Formulas]) -> list[str]:
    """The formulas of `stability.formulas` as lines of text.

    Parameters
    ----------
    found
        One a family and law.

    Returns
    -------
    list of str
    """
    lines = ["stability conditions as formulas, dimensionless (recomputed)", ""]
    for one in found:
        product = "".join(f"({p})" for p in one.polynomial)
        lines += [
            f"{one.family}, {one.contact}",
            f"    det(λ - A) ~ λ^{one.structural_zeros} {product}",
        ]
        lines += [f"    decides: {c['kind']:<9} {c['positive']} > 0" for c in one.conditions]
        for b in one.boundaries:
            lines.append(f"    {b['kind']} boundary: {b['of']} = {b['formula']}")
            lines += [f"        for {b['where']}"] if "where" in b else []
        for limit, values in one.limits.items():
            lines += [f"    as {limit}, at each member: {value} > 0" for value in values]
        lines += [f"    {p['name']} {p['positive']} > 0: {p['proof']}" for p in one.proved]
        lines += [f"    * {s}" for s in one.statements] + [""]
    last = "lam = λ; where M = mu*² occurs, λ = σ mu; z = at*², s = sin(theta)."
    return [*lines, last, f"The {LIMITS}.", ""]


def _aligned(cells: list[list[str]]) -> list[str]:
    widths = [max(len(row[i]) for row in cells) for i in range(len(cells[0]))]
    lines = [
        "  ".join(c.ljust(w) for c, w in zip(row, widths, strict=True)).rstrip() for row in cells
    ]
    return [lines[0], "  ".join("-" * w for w in widths), *lines[1:]]


def _family_lines(rows: list[dict[str, Any]]) -> list[str]:
    lines = []
    for row in rows:
        zeros = ", ".join(f"{law} {count}" for law, count in row["structural_zeros"].items())
        lines += [
            f"{row['family']} (named by {row['at']}): {row['motion']}",
            f"    condition         {row['condition']}",
            f"    structural zeros  {zeros}",
        ]
        for law, values in row["thresholds"].items():
            what = "no change of verdict"
            if values:
                what = f"neutral above {row['at']}² = " + ", ".join(f"{v:.12g}" for v in values)
                what += " (k = 1/4), unstable below"
            lines.append(f"    {law:<6}            {what}")
        lines.append("")
    return [*lines, "Dimensionless: m = R = g = 1, angular velocities in √(g/R)."]


def _completeness_lines(rows: list[dict[str, Any]]) -> list[str]:
    lines = []
    for number, row in enumerate(rows[:-1], start=1):
        mark = "holds" if row["holds"] else "FAILS"
        lines += [f"{number}. {row['claim']}", f"   {row['identity']}  [{mark}]"]
    found = rows[-1]["search"]
    names = ", ".join(f"{n} {c}" for n, c in found["found"].items())
    return [
        *lines, "",
        f"Search: {found['starts']} starts in the box {found['box']};",
        f"{found['converged']} reached a root ({names});",
        f"{found['outside']} outside the three families.",
    ]  # fmt: skip
