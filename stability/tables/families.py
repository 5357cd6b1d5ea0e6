"""Table of the families with their conditions."""

from __future__ import annotations

import cmath
from collections.abc import Mapping
from functools import lru_cache
from itertools import product
from typing import Any

from ..base.citation import cited
from ..base.errors import ParameterError
from ..bodies.contact_laws import LAWS
from ..bodies.disk import Disk
from ..bodies.families import FAMILIES, SteadyFamily, families_of_disk
from ..bodies.subject import disk_family
from ..systems.structure.structural_zeros import structure
from .conditions import scan
from .table import About, Column, Definition, Standing, Table, framed, word

SAMPLES, INERTIAS = (0.3, 0.9, 1.5, 2.3, 3.7, 6.1), (0.2, 0.45)
"""Values of at and k at which a root is compared with a closed form."""
SAME = 1e-9
"""Relative difference of values that are the same."""


@lru_cache(maxsize=8)
def condition(name: str) -> str:
    """The condition for a family, solved by SymPy from the graph's own equation.

    Raises
    ------
    ParameterError
        If the record has a closed form that no root of the equation is.

    Examples
    --------
    >>> condition("tumbling")
    'phi_dot**2 = 1/(k*sin(theta))'
    """
    import sympy

    from ..algebra.number_types import sympy_algebra

    record = FAMILIES[name]
    family = disk_family(name, record.law or "viscous")
    if family.closed or not family.unknown:
        return f"none: every {family.at[0]}"
    symbols = {n: sympy.Symbol(n, positive=True) for n in (*family.at, *family.unknown, "k", "mu")}
    arguments = [
        [symbols[n] for n in names] for names in (family.at, family.unknown, family.parameters)
    ]
    _, _, residual, *_ = family.graph.tangent.run(sympy_algebra(), arguments)
    [unknown] = family.unknown
    numerator = sympy.fraction(sympy.together(sympy.simplify(residual[0])))[0]
    if unknown in family.positive:  # solve for its square, since the sign is free
        square = sympy.Symbol("square", positive=True)
        [root] = sympy.solve(
            sympy.expand(numerator).subs(symbols[unknown], sympy.sqrt(square)), square
        )
        return f"{unknown}**2 = {sympy.simplify(root)}"
    roots = sympy.solve(numerator, symbols[unknown])
    if record.solution is not None:  # other roots belong to other families
        roots = [root for root in roots if _is_closed_form(record, root, symbols)]
        if not roots:
            raise ParameterError(
                f"solution of {name} is no root of its equation for {unknown}; correct it, or "
                "leave it out."
            )
    return " or ".join(f"{unknown} = {sympy.simplify(root)}" for root in roots)


def _is_closed_form(record: SteadyFamily, root: Any, symbols: Mapping[str, Any]) -> bool:
    """Whether a root has the values of the record's closed form, wherever that has any.

    Values are compared and not formulas: a record may hold a number that is a double.
    """
    import sympy

    at, k = symbols[record.at[0]], symbols["k"]
    closed = sympy.sympify(record.solution(sympy, at, k, 1))  # type: ignore[misc]
    pairs = [
        [complex(formula.subs({at: value, k: inertia})) for formula in (root, closed)]
        for value, inertia in product(SAMPLES, INERTIAS)
    ]
    real = [
        (computed, stated)
        for computed, stated in pairs
        if cmath.isfinite(stated) and not stated.imag
    ]
    return bool(real) and all(cmath.isclose(*pair, rel_tol=SAME) for pair in real)


def families() -> list[dict[str, Any]]:
    """The families of steady motions with their conditions, derived from the graph.

    Returns
    -------
    list of dict
        One row for each family; thresholds are computed for the uniform disk.

    Source: equations of Przybylska & Rauch-Wojciechowski 2016; recomputed.

    Examples
    --------
    >>> [row["family"] for row in families()]
    ['rolling', 'spinning', 'tumbling', 'circling', 'precession']
    """
    rows = []
    for name, record in families_of_disk().items():
        laws = [record.law] if record.law else list(LAWS)
        zeros = {law: structure(disk_family(name, law)).zeros for law in laws}
        thresholds: dict[str, list[float]] = {}
        if record.searched:
            for law in (n for n in ("smooth", "rough") if n in laws):
                points = scan(record, Disk(), LAWS[law]())
                power = 1 if record.by_angle else 2
                thresholds[law] = [p.value**power for p in points]
        rows.append(
            {
                "family": name,
                "at": ", ".join(record.at),
                "motion": record.disk_motion,
                "condition": condition(name),
                "structural_zeros": zeros,
                "thresholds": thresholds,
            }
        )
    return rows


def _text(table: Table) -> str:
    lines = []
    for row in table.rows:
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
    return framed(table, lines[:-1])


TABLE = Definition(
    "the steady motions with their conditions, structural zeros and limits",
    (
        word("family", "name of the family", share=0.12),
        word("at", "quantities that name a member", share=0.07),
        word("motion", "the motion in words", share=0.19),
        word("condition", "condition for a member", share=0.24),
        Column(
            "structural_zeros", "number of structural zeros by contact law", share=0.13, form="{:d}"
        ),
        Column(
            "thresholds",
            "squares of at where the verdict turns from unstable below to neutral "
            "above, for k = 1/4, without friction (smooth) and without slip (rough)",
            share=0.14,
            form="{:.6g}",
        ),
    ),
    families,
    notes=lambda _: ["Dimensionless: m = R = g = 1, angular velocities in √(g/R)."],
    text=_text,
    about=About(
        "Przybylska & Rauch-Wojciechowski, Regul. Chaotic Dyn. 21 (2016) 204-231",
        "the model, in abstract, introduction and the start of section 2; no table of it",
        "conditions, structural zeros and limits, from polynomials of the equations",
        Standing.RECOMPUTED,
    ),
    cites=cited(model=True, proofs=True, theory=["sympy"]),
    home=f"{__name__}:TABLE",
)
"""The table for the registry."""
