"""A family for the page by conditions that are derived over Q, every quantity a variable."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any

import casadi as ca

from ...algebra.number_types import Algebra
from ...algebra.program import Program
from ...base.errors import StabilityError
from ...base.verdict import Verdict
from ...derivation.conditions import conditions
from ...systems.family import Family
from ...systems.structure.zero_blocks import typical
from ..quantity import Quantity
from ..source.formulas import (
    FLOAT,
    Formulas,
    Rule,
    Values,
    filled,
    share_of,
    shift_of,
    sized,
    typeset,
    value_of,
)
from ..source.solver import solver_of

SECONDS = 30.0
"""Longest time of the derivation of the conditions [s]."""
FUNCTION = re.compile(r"(sin|cos|sqrt)\((\w+)\)")
"""A variable that is a function of a quantity."""
SIZE = re.compile(r"sqrt\((\w+)\*\*2\)")
"""A variable that is the size of a quantity."""
ONE = "sqrt(1)"
"""A variable that is 1: the root of a graph at a point where it is a number."""


def derived_formulas(
    family: Family, quantities: Mapping[str, Quantity], positive: Sequence[str] = ()
) -> Formulas:
    """What decides the verdict of a family, derived with every quantity as a variable.

    Raises
    ------
    StabilityError
        If the conditions are too large, or too much of a member is solved for.
    """
    found = conditions(family, positive=positive, decimals=True, seconds=SECONDS)
    if found.left_out:
        raise StabilityError(f"{family.name}: {found.left_out[0]}; the page needs every condition.")
    solver = solver_of(family)
    names = (*quantities, *(solver.unknown if solver else ()))
    variables = [v.name for v in found.variables]
    read = [_read(family, v, names) for v in variables]
    symbols = {n: q.symbol for n, q in quantities.items()}
    parts = dict(zip(variables, read, strict=True))
    written = {v: (_written(v, *one, symbols), 1) for v, one in parts.items()}
    put = {v: (_in_braces(*one), 1) for v, one in parts.items()}
    roundings = {v: 2 * (v not in quantities) for v in variables}
    deciding = [c for c in found.deciding if str(c.polynomial) != ONE]
    polynomials = [(c.polynomial, shift_of([c.polynomial])) for c in deciding]
    factors = [f for f in found.factors for _ in range(f.multiplicity)]

    def point(algebra: Algebra, q: Values) -> list[Any]:
        values = dict(zip(names, q, strict=True)) | {"": 1.0}
        return [
            algebra.functions[function](values[name]) if function else values[name]
            for function, name in read
        ]

    def coefficients(algebra: Algebra, q: Values) -> list[list[Any]]:
        at, out = point(algebra, q), []
        for factor in factors:
            shift = shift_of(factor.coefficients)
            out.append([value_of(c, shift, at) for c in factor.coefficients])
        return out

    def signs(algebra: Algebra, q: Values) -> list[tuple[Any, Any]]:
        at = point(algebra, q)
        return [sized(p, shift, algebra, at) for p, shift in polynomials]

    system: Any = family.system
    exists = Program(
        ca.Function("exists", [system.x, system.p], [c.value for c in system.conditions])
    )

    def members(algebra: Algebra, q: Values) -> list[Any]:
        # the system's conditions at a member are positive where it exists
        values = dict(zip(names, q, strict=True))
        states = formulas.states(family, algebra, q)
        out = exists.run(algebra, [states, [values[n] for n in system.parameters]])
        return [v[0] if v else 0.0 for v in out]

    formulas = Formulas(
        names=names,
        even=tuple(f.even for f in factors),
        zeros=found.zeros,
        coefficients=coefficients,
        rules=tuple(
            Rule(
                c.kind,
                FLOAT if solver else share_of(p, roundings),
                typeset(p, written, shift),
                filled(p, put, shift),
            )
            for c, (p, shift) in zip(deciding, polynomials, strict=True)
        ),
        signs=signs,
        unknown=lambda _, __: {} if solver else family.unknown,
        good=_good(family, even=any(f.even for f in found.factors) or found._extra_zeros > 0),
        members=members,
        solver=solver,
        proved=solver is None,
        numbers=found.numbers,
    )
    return formulas


def _good(family: Family, *, even: bool) -> Verdict:
    good = typical(family, even=even)
    if good is Verdict.UNDECIDED:
        raise StabilityError(
            f"{family.name}: nothing proves whether its zero eigenvalues form a Jordan block, so "
            "that the page cannot tell stable from drifting; ask stability.spectrum."
        )
    return good


def _read(family: Family, variable: str, names: Sequence[str]) -> tuple[str, str]:
    """A variable of the polynomials as (function, quantity); the number 1 has neither."""
    if variable in names:
        return "", variable
    match, size = FUNCTION.fullmatch(variable), SIZE.fullmatch(variable)
    if match and match[2] in names:
        return match[1], match[2]
    if size and size[1] in names:
        return "fabs", size[1]
    if variable == ONE:
        return "", ""
    raise StabilityError(
        f"{family.name}: {variable} in its conditions is a function of several quantities; the "
        "page draws families whose conditions are polynomials in quantities, in their sines, "
        "cosines and roots, and in the states that are solved for."
    )


def _in_braces(function: str, name: str) -> str:
    number = f"{{{name}}}" if name else "1"
    return {"": number, "fabs": f"|{number}|"}.get(function, f"({function} {number})")


def _written(variable: str, function: str, name: str, symbols: Mapping[str, str]) -> str:
    symbol = symbols.get(name, name) if name else "1"
    return {"": symbol, "fabs": f"|{symbol}|"}.get(function, variable)
