"""Exact conditions of a user's family as lines of text, as LaTeX and as a record for JSON."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from ..algebra.polynomial import Polynomial
from ..base.exact_numbers import decimal_of, written
from ..base.quantities import readable
from ..derivation.latex import converted, escaped, polynomial_rows, symbol
from .letters import unit as unit_in_latex
from .table import END, Column, Definition, Table, word

if TYPE_CHECKING:
    from ..derivation.conditions import Conditions
    from ..systems.family import Family

DIGITS = 12
"""Digits of a coefficient in text; longer ones are rounded and marked."""
ROWS = 20
"""Most lines of one display."""
MOST_OF_RULE = 120
"""Characters of a rule in full; a longer one has the labels of its conditions."""
ROUNDED = (
    f"≈: coefficients divided by a positive number and rounded to {DIGITS} digits; exact in JSON."
)
"""Note below a text with rounded coefficients."""


def _size(*polys: Polynomial) -> int:
    """What coefficients are divided by: 1, or the largest one where some have many digits."""
    largest = max((abs(c) for p in polys for c, _ in p.terms), default=1)
    return largest if largest >= 10**DIGITS else 1


def _terms(poly: Polynomial, size: int) -> list[tuple[str, str, tuple[int, ...]]]:
    """(sign, coefficient, exponents) of each term; long coefficients become decimals."""
    return [
        ("-" if c < 0 else "+", str(abs(c)) if size == 1 else f"{abs(c) / size:.{DIGITS}g}", e)
        for c, e in poly.terms
    ]


def _text(poly: Polynomial, size: int = 0) -> str:
    """A polynomial as text, with ≈ where its coefficients are rounded."""
    size = size or _size(poly)
    words = []
    for sign, number, exponents in _terms(poly, size):
        powers = [
            n + (f"**{e}" if e > 1 else "")
            for n, e in zip(poly.variables, exponents, strict=True)
            if e
        ]
        words += [sign, "*".join([number] * (number != "1" or not powers) + powers)]
    joined = (" ".join(words) or "0").removeprefix("+ ")
    joined = f"-{joined[2:]}" if joined.startswith("- ") else joined
    return joined if size == 1 else f"≈ {joined}"


def lines(conditions: Conditions) -> list[str]:
    """Conditions as lines of text."""
    out = [_heading(conditions), ""]
    out += [f"    {v.name}: {v.meaning}{_unit(conditions, v.name)}" for v in conditions.variables]
    if conditions.given:
        out += [f"    given: {_place(conditions, conditions.given)}"]
    if conditions.domain:
        out += [f"    assumed: {', '.join(conditions.domain)}"]
    out += [f"    {name} = {value}" for name, value in conditions.solved]
    out += [f"    {_text(p)} = 0, which {name} obeys" for name, p in conditions.relations]
    out += [f"    {_text(p)} is not 0" for p in conditions.nonzero]
    power, count = f"λ^{conditions.zeros} times " * bool(conditions.zeros), len(conditions.factors)
    out += ["", f"    det(λ - A) ~ {power}{count} factor{'s' * (count != 1)}:"]
    for factor in conditions.factors:
        power = f" (to the power {factor.multiplicity})" if factor.multiplicity > 1 else ""
        out += [f"      of degree {factor.degree} in λ{power}"]
        size = _size(*factor.coefficients)
        out += [
            f"        λ^{k}: {_text(c, size)}" for k, c in enumerate(factor.coefficients) if c.terms
        ]
    out += ["", *_condition_lines(conditions)]
    out += [f"    left out: {sentence}" for sentence in conditions.left_out]
    out += ["", f"    {_rule(conditions)}", ""]
    if any(_size(p) > 1 for p in _polynomials(conditions)):
        out += [ROUNDED]
    out += [conditions.numbers] if conditions.numbers else []
    return [*out, f"Degree {conditions.degree} in λ, at most {conditions.terms} terms."]


def _condition_lines(conditions: Conditions) -> list[str]:
    """Each condition with its proof and witnesses, then the boundaries."""
    out = []
    names = _labels(conditions)
    for c in conditions.conditions:
        mark = f"{names[id(c)]} decides" if c.decides else "holds"
        poly = c.polynomial if c.decides or c.status == "follows" else c.whole
        out += [f"    {mark}: {c.kind:<9} {_text(poly)} > 0"]
        out += [f"        {c.name} of factor {c.factor + 1}, {c.status}: {c.proof or 'as it is'}"]
        for w in c.witnesses:
            free = {n: v for n, v in w.point.items() if n not in conditions.given}
            sign = "positive" if w.sign > 0 else "negative"
            out += [f"        {sign} at {_place(conditions, free)}"]
    return out + [f"    {b.kind} boundary: {names[id(b)]} = 0" for b in conditions.boundaries]


def _labels(conditions: Conditions) -> dict[int, str]:
    """C1, C2, … for the conditions that decide, by identity."""
    return {id(c): f"C{i}" for i, c in enumerate(conditions.deciding, start=1)}


def _place(conditions: Conditions, point: Mapping[str, Fraction]) -> str:
    """Numbers with their names and units; ≈ stands before a decimal next to a double."""
    return ", ".join(f"{n} {_number(v)}{_unit(conditions, n, ' {}')}" for n, v in point.items())


def _number(value: Fraction) -> str:
    near = decimal_of(float(value)) if Fraction(float(value)) == value else value
    return f"= {written(value)}" if near in (None, value) else f"≈ {float(value)!r}"


def _unit(conditions: Conditions, name: str, form: str = " [{}]") -> str:
    """The unit of a parameter or state, where the user gave one."""
    unit = conditions.family.system.units.get(name, "1")
    return "" if unit == "1" else form.format(readable(unit))


def _unit_latex(conditions: Conditions, name: str, form: str = " [{}]") -> str:
    """The same in LaTeX."""
    word = conditions.family.system.units.get(name, "1")
    return "" if word == "1" else form.format(unit_in_latex(word))


def _rule(conditions: Conditions, *, labels: bool = False) -> str:
    """The verdict in a sentence, with labels where the polynomials are long."""
    names = _labels(conditions)
    text = conditions.rule
    long = labels or len(text) > MOST_OF_RULE
    for c in conditions.deciding:
        short = names[id(c)] if long or _size(c.polynomial) > 1 else _text(c.polynomial)
        text = text.replace(f"{c.polynomial} > 0", f"{short} > 0")
    return text


def _polynomials(conditions: Conditions) -> list[Polynomial]:
    inside = [c for f in conditions.factors for c in f.coefficients]
    return [*inside, *(c.polynomial for c in conditions.conditions)]


def record(conditions: Conditions) -> dict[str, Any]:
    """Conditions as a record for JSON; polynomials are exact texts."""
    units = conditions.family.system.units
    names = (*(v.name for v in conditions.variables), *conditions.given)
    return {
        "system": conditions.family.system.name,
        "family": conditions.family.name,
        "given": {n: str(v) for n, v in conditions.given.items()},
        "numbers": conditions.numbers,
        "units": {n: units[n] for n in names if n in units},
        "variables": [
            {"name": v.name, "kind": v.kind, "meaning": v.meaning} for v in conditions.variables
        ],
        "domain": list(conditions.domain),
        "relations": [{"variable": n, "zero": str(p)} for n, p in conditions.relations],
        "solved": dict(conditions.solved),
        "nonzero": [str(p) for p in conditions.nonzero],
        "structural_zeros": conditions.zeros,
        "factors": [
            {
                "coefficients": [str(c) for c in f.coefficients],
                "even": f.even,
                "multiplicity": f.multiplicity,
            }
            for f in conditions.factors
        ],
        "conditions": [
            {
                "name": c.name,
                "factor": c.factor,
                "kind": c.kind,
                "status": c.status,
                "decides": c.decides,
                "positive": str(c.polynomial),
                "whole": str(c.whole),
                "proof": c.proof,
                "witnesses": [
                    {"at": {n: str(v) for n, v in w.point.items()}, "sign": w.sign}
                    for w in c.witnesses
                ],
            }
            for c in conditions.conditions
        ],
        "boundaries": [{"kind": b.kind, "zero": str(b.polynomial)} for b in conditions.boundaries],
        "rule": conditions.rule,
        "left_out": list(conditions.left_out),
        "degree": conditions.degree,
        "terms": conditions.terms,
    }


# --- LaTeX ---


def _formula(poly: Polynomial, relation: str, label: str = "") -> str:
    """A polynomial with a relation as displayed mathematics, broken into lines, with a label."""
    names = {n: symbol(n) for n in poly.variables}
    rows = polynomial_rows(_terms(poly, _size(poly)), poly.variables, names)
    rows[-1] += f" {relation}"
    mark = r"\approx{}" if _size(poly) > 1 else ""
    pages = [rows[i : i + ROWS] for i in range(0, len(rows), ROWS)]  # no page breaks in a display
    bodies = [" \\\\\n  & ".join(page) for page in pages]
    marks, labels = [mark] + [""] * len(pages), [""] * (len(pages) - 1) + [label]
    return "\n".join(
        f"\\[\n  \\begin{{aligned}}\n  {first}& {body}\n  \\end{{aligned}}{last}\n\\]"
        for first, body, last in zip(marks, bodies, labels, strict=False)
    )


def latex(conditions: Conditions) -> str:
    """Conditions as LaTeX; needs amsmath and booktabs."""
    family = conditions.family
    out = [
        "% stability table conditions --system: derived from the equations of motion",
        "% needs amsmath and booktabs",
        r"\begingroup\raggedright",
        rf"\paragraph{{{escaped(family.system.name)}, {escaped(family.name)}}}\mbox{{}}\par",
        r"\noindent",
        r"\begin{tabular}{@{}lp{0.7\linewidth}@{}}",
        r"  \toprule",
        r"  symbol & meaning \\",
        r"  \midrule",
    ]
    out += [
        rf"  ${symbol(v.name)}$ & {escaped(v.meaning)}{_unit_latex(conditions, v.name)} \\"
        for v in conditions.variables
    ]
    out += [r"  $\lambda$ & eigenvalue \\", r"  \bottomrule", r"\end{tabular}", ""]
    out += _latex_assumptions(conditions)
    for name, poly in conditions.relations:
        out += [f"Equation of ${symbol(name)}$:", _formula(poly, "= 0")]
    count = len(conditions.factors)
    number = f"{count} factor{'s' * (count != 1)}"
    if conditions.zeros:
        number = f"the factor $\\lambda^{{{conditions.zeros}}}$ and {count} more"
    out += [f"The characteristic polynomial has {number}."]
    for i, c in enumerate(conditions.deciding, start=1):
        out += [f"{c.kind.capitalize()} condition ({escaped(c.name)}):"]
        out += [_formula(c.polynomial, "> 0", f"\\tag{{C{i}}}")]
    out += [escaped(_rule(conditions, labels=True))]
    if any(_size(c.polynomial) > 1 for c in conditions.deciding):
        out += [rf"Where $\approx$ is written, coefficients are rounded to {DIGITS} digits."]
    out += [
        escaped(sentence)
        for sentence in (*conditions.left_out, *filter(None, [conditions.numbers]))
    ]
    return "\n".join([*out, END])


def _latex_assumptions(conditions: Conditions) -> list[str]:
    """Given numbers, assumptions and closed forms, each as one sentence."""
    names = [v.name for v in conditions.variables] + [n for n, _ in conditions.solved]
    numbers = [
        rf"${symbol(n)} {_number(v)}$".replace("≈", r"\approx") + _unit_latex(conditions, n, " {}")
        for n, v in conditions.given.items()
    ]
    assumed = [f"${converted(text, names)}$" for text in conditions.domain]
    solved = [f"${symbol(n)} = {converted(value, names)}$" for n, value in conditions.solved]
    apart = [rf"${converted(_text(p), names)} \neq 0$" for p in conditions.nonzero]
    parts = (("Given", numbers), ("Assumed", assumed + apart), ("With", solved))
    return [f"{word}: {', '.join(texts)}." for word, texts in parts if texts]


# --- for the registry ---


def condition_table(family: Family, **options: Any) -> Table:
    """The table of the exact conditions of a family; options are those of `conditions`."""
    from ..derivation.conditions import conditions

    derived = conditions(family, **options)
    names = _labels(derived)
    rows = [
        {
            "label": names.get(id(c)),
            "kind": c.kind,
            "name": c.name,
            "factor": c.factor + 1,
            "status": c.status,
            "decides": c.decides,
            "positive": str(c.polynomial),
            "proof": c.proof,
        }
        for c in derived.conditions
    ]
    return Table(
        "conditions",
        _heading(derived),
        TABLE.columns,
        rows,
        more=record(derived),
        definition=TABLE,
        found=derived,
        citation=derived.citation,
    )


def _heading(conditions: Conditions) -> str:
    family = conditions.family
    return f"{family.system.name}, {family.name}: exact conditions of stability (derived)"


TABLE = Definition(
    "exact conditions of stability",
    (
        word("label", "label of a condition that decides"),
        word("kind", "kind of the change of verdict"),
        word("name", "coefficient or determinant"),
        Column("factor", "number of the factor of the characteristic polynomial", form="{:d}"),
        word("status", "how the condition is known"),
        Column("decides", "whether its sign decides the verdict"),
        word("positive", "polynomial that is positive where the motion is stable"),
        word("proof", "proof of a condition that holds"),
    ),
    lambda **_: [],
    text=lambda table: "\n".join(lines(table.found)),
    latex=lambda table: latex(table.found),
    home=f"{__name__}:TABLE",
)
"""Conditions of a family of the user's own."""
