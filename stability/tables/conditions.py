"""Table of stability conditions: where verdicts change along each family."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, replace
from typing import Any

from ..base.citation import cited
from ..base.errors import NameUnknownError, ParameterError, shown
from ..base.quantities import Kind, Quantity
from ..bodies.contact_laws import LAWS, Contact
from ..bodies.disk import Disk
from ..bodies.disk_polynomials import known_polynomial, stored_laws
from ..bodies.families import FAMILIES, SteadyFamily
from ..bodies.quantities import QUANTITIES
from ..boundary.brackets import BoundaryPoint
from ..boundary.changes import along
from ..derivation.formulas import LIMITS
from ..derivation.latex import escaped
from ..spectra.problem import disk_problem
from .letters import mathematics, prose
from .table import END, NEEDS, About, Column, Definition, Standing, Table, latex, plain, word


def conditions(
    *,
    k: Sequence[float] = (0.25, 0.3125, 0.5),
    mu: Sequence[float] = (0.1, 0.3, 1.0, 3.0, 10.0),
    disk: Disk | None = None,
    laws: Sequence[str] = ("smooth", "viscous", "rough"),
    progress: Callable[[int, int], None] | None = None,
) -> list[dict[str, Any]]:
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
    list of dict
        `at` is searched over `SteadyFamily.searched` (in √(g/R), or rad for tumbling; tumbling ends
        at upright, since larger angles are its mirror image).

    Source: recomputed; thresholds are tested in tests/spectra/test_published.py.

    Examples
    --------
    >>> rows = conditions(k=(0.25,), mu=(0.3,), laws=("viscous",))
    >>> [(r["family"], r["crossing"]) for r in rows]
    [('rolling', 'flutter'), ('spinning', 'static'), ('tumbling', 'none')]
    """
    bodies = [replace(disk or Disk(), k=inertia) for inertia in k]
    asked = [
        (family, body, contact)
        for family in FAMILIES.values()
        if family.searched
        for body in bodies
        for law in laws
        if family.law in ("", law)
        for contact in _contacts(law, mu)
    ]
    rows: list[dict[str, Any]] = []
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
    [*_, coefficient] = LAWS[law].parameters
    return [LAWS[law](**{coefficient.name: m}) for m in mu]


def scan(family: SteadyFamily, disk: Disk, contact: Contact) -> list[BoundaryPoint]:
    """Every change of verdict along the family, over `searched` of its record."""
    assert family.searched is not None
    low, high = family.searched
    unit = family.unit(float(disk.rate))
    problem = disk_problem(family.name, disk, contact)
    changes = along(problem, "at", low * unit, high * unit)
    changes.warn("at")
    return list(changes)


def _rows(family: SteadyFamily, disk: Disk, contact: Contact) -> list[dict[str, Any]]:
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
        none = {"at": None, "error": None, "crossing": "none", "frequency": None}
        return [common | none | {"below": verdict, "above": verdict}]
    return [
        common
        | {
            "at": p.value,
            "error": p.error,
            "crossing": p.crossing.word,
            "frequency": p.frequency,
            "below": good if p.stable_below else "unstable",
            "above": "unstable" if p.stable_below else good,
        }
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

    return {"formulas": [asdict(entry) for entry in rows(laws, k, progress)]}


def _notes(table: Table) -> list[str]:
    kinds: dict[str, list[str]] = {}
    for family in FAMILIES.values():
        if family.searched:
            kind = Kind.ANGLE if family.by_angle else Kind.ANGULAR_VELOCITY
            unit = kind.label(dimensionless=table.dimensionless)
            kinds.setdefault(unit, []).append(f"{family.at[0]} ({family.name})")
    names = ", ".join(f"{', '.join(words)} in {u}" for u, words in kinds.items())
    ends = {n: f.searched for n, f in FAMILIES.items() if f.searched}
    ranges = {n: f"{n} {low:g}…{high:.4g}" for n, (low, high) in ends.items()}
    stored = {n for n in ranges if any(known_polynomial(n, law) for law in stored_laws())}
    frequency = Kind.ANGULAR_VELOCITY.label(dimensionless=table.dimensionless)
    return [
        f"at: {names}; frequency in {frequency}.",
        f"Searched: {', '.join(ranges[n] for n in ranges if n in stored)} "
        "(dimensionless), completely: every real root of the conditions over Q is isolated; each "
        "place is a bracket proved in ball arithmetic.",
        *[
            f"{ranges[n]}: no polynomial is stored; the places are those that `boundaries` finds."
            for n in ranges
            if n not in stored
        ],
    ]


def _text(table: Table) -> str:
    return "\n".join([*formula_lines(table.more["formulas"]), plain(table)])


def _latex(table: Table) -> str:
    return "\n\n".join([formula_latex(table.more["formulas"]), latex(table)])


def member(family: str) -> Quantity | None:
    """The quantity that names a member of a family, if it is one."""
    names = FAMILIES[family].at if family in FAMILIES else ()
    return QUANTITIES[names[0]] if len(names) == 1 else None


K = Column("k", "inertia factor", latex="k", form="{:g}")
MU = Column("mu", "friction coefficient", Kind.INVERSE_VELOCITY, r"\mu", "{:g}")
FREQUENCY = Column(
    "frequency", "frequency of the crossing pair", Kind.ANGULAR_VELOCITY, r"\omega", "{:.10g}"
)
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
        FREQUENCY,
        word("below", "verdict below at, or everywhere"),
        word("above", "verdict above at, or everywhere"),
    ),
    conditions,
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


# --- the conditions as formulas ---


Formulas = Mapping[str, Any]
"""A record of `stability.derivation.formulas.Formulas`."""
SHORT_FORMULA = 60
"""Most characters of a formula that is set with fractions; a longer one breaks over lines."""
SYMBOLS = (
    (r"\lambda", "eigenvalue; where M occurs, λ = σ mu"),
    ("k", "inertia factor"),
    (r"\mu", "friction coefficient, dimensionless, also written mu*"),
    (r"\omega_{3}", "axial angular velocity"),
    (r"\dot\varphi", "precession rate"),
    (r"\theta", "axis inclination"),
    ("z", "square of omega3 (rolling) or phi_dot (spinning, circling, precession)"),
    ("s", "sin(theta)"),
    ("M", "mu**2"),
)
"""Symbols of the formulas, in LaTeX, with their meaning."""


def formula_lines(formulas: Sequence[Formulas]) -> list[str]:
    """The formulas as lines of text."""
    lines = ["stability conditions as formulas, dimensionless (recomputed)", ""]
    for entry in formulas:
        product = "".join(f"({p})" for p in entry["polynomial"])
        lines += [
            f"{entry['family']}, {entry['contact']}",
            f"    det(λ - A) ~ λ^{entry['structural_zeros']} {product}",
        ]
        lines += [f"    decides: {c['kind']:<9} {c['positive']} > 0" for c in entry["conditions"]]
        for b in entry["boundaries"]:
            lines.append(f"    {b['kind']} boundary: {b['of']} = {b['formula']}")
            lines += [f"        for {b['where']}"] if "where" in b else []
        for limit, values in entry["limits"].items():
            lines += [f"    as {limit}, at each member: {value} > 0" for value in values]
        lines += [f"    {p['name']} {p['positive']} > 0: {p['proof']}" for p in entry["proved"]]
        lines += [f"    * {s}" for s in entry["statements"]] + [""]
    last = "lam = λ; where M = mu*² occurs, λ = σ mu; z = at*², s = sin(theta)."
    return [*lines, last, f"The {LIMITS}.", ""]


def formula_latex(formulas: Sequence[Formulas]) -> str:
    r"""The formulas as LaTeX: a table of the symbols, then a list for each family and law.

    Examples
    --------
    >>> from dataclasses import asdict, replace
    >>> from stability.derivation.formulas import formulas
    >>> text = formula_latex([asdict(formulas("spinning", "rough"))])
    >>> print(text[text.index(r"\item static b"):].splitlines()[0])
    \item static boundary: $\dot\varphi ^{2} = \frac{1}{k + 1}$
    """
    lines = [
        "% stability table conditions: recomputed from the equations of motion",
        NEEDS,
        r"\begingroup\raggedright\setlength{\parindent}{0pt}",
        r"\begin{tabular}{@{}l>{\raggedright\arraybackslash}p{0.7\linewidth}@{}}",
        r"\toprule",
        r"symbol & meaning \\",
        r"\midrule",
        *(rf"${symbol}$ & {prose(meaning)} \\" for symbol, meaning in SYMBOLS),
        r"\bottomrule",
        r"\end{tabular}",
    ]
    for entry in formulas:
        lines += ["", *_list(entry)]
    return "\n".join([*lines, "", prose(f"Dimensionless: m = R = g = 1. The {LIMITS}."), END])


def _list(entry: Formulas) -> list[str]:
    """Formulas of one family and law as an itemised list."""
    product = r"\,".join(f"({mathematics(p)})" for p in entry["polynomial"])
    lines = [
        rf"\paragraph{{{escaped(entry['family'])}, {escaped(entry['contact'])} contact}} "
        rf"Characteristic polynomial: $\lambda^{{{entry['structural_zeros']}}}$ times ${product}$.",
        r"\begin{itemize}",
    ]
    lines += [rf"\item {c['kind']}: {_formula(c['positive'], '> 0')}" for c in entry["conditions"]]
    for b in entry["boundaries"]:
        where = f" for {prose(b['where'])}" if "where" in b else ""
        lines.append(rf"\item {b['kind']} boundary: {_formula(b['formula'], head=b['of'])}{where}")
    for limit, values in entry["limits"].items():
        lines += [rf"\item ${mathematics(limit)}$: {_formula(v, '> 0')}" for v in values]
    lines += [rf"\item {prose(s)}" for s in entry["statements"]]
    if not any(line.startswith(r"\item") for line in lines):
        lines.append(r"\item no condition")
    return [*lines, r"\end{itemize}"]


def _formula(text: str, relation: str = "", head: str = "") -> str:
    """A formula: with fractions where it is short, otherwise one that breaks over lines."""
    before = f"{mathematics(head)} = " if head else ""
    if len(text) > SHORT_FORMULA:
        return f"${before}{mathematics(text)}{relation and ' ' + relation}$"
    import sympy

    names = {sympy.Symbol("lam"): r"\lambda", sympy.Symbol("mu"): r"\mu"}
    value = sympy.sympify(text, locals={"S": sympy.Symbol("S")})
    return f"${before}{sympy.latex(value, symbol_names=names)}{relation and ' ' + relation}$"
