"""Formulas of the disk's stability conditions, as text and as LaTeX."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from ..derivation.formulas import LIMITS
from .formats.latex import END, NEEDS
from .formats.letters import escaped, mathematics, prose

Formulas = Mapping[str, Any]
"""A record of `stability.derivation.formulas.Formulas`."""
SHORT = 60
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


def formula_lines(found: Sequence[Formulas]) -> list[str]:
    """The formulas as lines of text.

    Parameters
    ----------
    found
        One record for each family and law.

    Returns
    -------
    list of str
    """
    lines = ["stability conditions as formulas, dimensionless (recomputed)", ""]
    for one in found:
        product = "".join(f"({p})" for p in one["polynomial"])
        lines += [
            f"{one['family']}, {one['contact']}",
            f"    det(λ - A) ~ λ^{one['structural_zeros']} {product}",
        ]
        lines += [f"    decides: {c['kind']:<9} {c['positive']} > 0" for c in one["conditions"]]
        for b in one["boundaries"]:
            lines.append(f"    {b['kind']} boundary: {b['of']} = {b['formula']}")
            lines += [f"        for {b['where']}"] if "where" in b else []
        for limit, values in one["limits"].items():
            lines += [f"    as {limit}, at each member: {value} > 0" for value in values]
        lines += [f"    {p['name']} {p['positive']} > 0: {p['proof']}" for p in one["proved"]]
        lines += [f"    * {s}" for s in one["statements"]] + [""]
    last = "lam = λ; where M = mu*² occurs, λ = σ mu; z = at*², s = sin(theta)."
    return [*lines, last, f"The {LIMITS}.", ""]


def formula_latex(found: Sequence[Formulas]) -> str:
    r"""The formulas as LaTeX: a table of the symbols, then a list for each family and law.

    Parameters
    ----------
    found
        One record for each family and law.

    Returns
    -------
    str

    Examples
    --------
    >>> from dataclasses import asdict
    >>> from stability.derivation.formulas import formulas
    >>> text = formula_latex([asdict(formulas("spinning", "rough"))])
    >>> print(text[text.index(r"\item static b"):].splitlines()[0])
    \item static boundary: $\dot\varphi ^{2} = \frac{1}{k + 1}$
    """
    lines = [
        "% stability table conditions: recomputed from the equations of motion",
        NEEDS,
        r"\begingroup\raggedright\setlength{\parindent}{0pt}",
        r"\begin{tabular}{@{}ll@{}}",
        r"\toprule",
        r"symbol & meaning \\",
        r"\midrule",
        *(rf"${symbol}$ & {prose(meaning)} \\" for symbol, meaning in SYMBOLS),
        r"\bottomrule",
        r"\end{tabular}",
    ]
    for one in found:
        lines += ["", *_list(one)]
    return "\n".join([*lines, "", prose(f"Dimensionless: m = R = g = 1. The {LIMITS}."), END])


def _list(one: Formulas) -> list[str]:
    """Formulas of one family and law as an itemised list."""
    product = r"\,".join(f"({mathematics(p)})" for p in one["polynomial"])
    lines = [
        rf"\paragraph{{{escaped(one['family'])}, {escaped(one['contact'])} contact}} "
        rf"Characteristic polynomial: $\lambda^{{{one['structural_zeros']}}}$ times ${product}$.",
        r"\begin{itemize}",
    ]
    lines += [rf"\item {c['kind']}: {_formula(c['positive'], '> 0')}" for c in one["conditions"]]
    for b in one["boundaries"]:
        where = f" for {prose(b['where'])}" if "where" in b else ""
        lines.append(rf"\item {b['kind']} boundary: {_formula(b['formula'], head=b['of'])}{where}")
    for limit, values in one["limits"].items():
        lines += [rf"\item ${mathematics(limit)}$: {_formula(v, '> 0')}" for v in values]
    lines += [rf"\item {prose(s)}" for s in one["statements"]]
    if not any(line.startswith(r"\item") for line in lines):
        lines.append(r"\item no condition")
    return [*lines, r"\end{itemize}"]


def _formula(text: str, relation: str = "", head: str = "") -> str:
    """A formula: with fractions where it is short, otherwise one that breaks over lines."""
    before = f"{mathematics(head)} = " if head else ""
    if len(text) > SHORT:
        return f"${before}{mathematics(text)}{relation and ' ' + relation}$"
    import sympy

    names = {sympy.Symbol("lam"): r"\lambda", sympy.Symbol("mu"): r"\mu"}
    value = sympy.sympify(text, locals={"S": sympy.Symbol("S")})
    return f"${before}{sympy.latex(value, symbol_names=names)}{relation and ' ' + relation}$"
