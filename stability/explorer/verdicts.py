"""What decides a family's verdict: stored polynomials, conditions derived over Q, a closed form."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from types import SimpleNamespace
from typing import Any

import casadi as ca
import numpy as np

from ..algebra.exact.routh import expanded_determinant, hurwitz_matrix
from ..algebra.number_types import Algebra
from ..algebra.program import Program
from ..algebra.running_error import TINY, UNIT, RunningError, Sized
from ..base.errors import NoMemberError, StabilityError
from ..base.verdict import Verdict, best
from ..bodies.disk_polynomials import PLAIN, DiskPolynomial, exact_polynomial
from ..bodies.families import FAMILIES
from ..derivation.conditions import conditions
from ..polynomials.zero_blocks import typical
from ..systems.closed_form import ImplicitForm
from ..systems.family import Family
from .formulas import (
    FLOAT,
    PageFormulas,
    Rule,
    Values,
    filled,
    share_of,
    shift_of,
    sized,
    solver_of,
    typeset,
    value_of,
)
from .quantities import PageQuantity


def stored_formulas(
    family: Family, law: str, quantities: Mapping[str, PageQuantity]
) -> PageFormulas:
    """What decides the verdict of a family of the disk."""
    record, exact = FAMILIES[family.name], DiskPolynomial(exact_polynomial(family.name, law))
    stored, [at] = exact.known, family.at
    written, put = {}, {}
    for variable, name, power in (("k", "k", 1), ("M", "mu", 2), ("z", at, 2), ("s", at, 1)):
        if name in quantities:  # each variable is a power of a quantity, or its sine
            quantity = quantities[name]
            sine = variable == "s"
            written[variable] = (f"sin {quantity.symbol}" if sine else quantity.symbol, power)
            put[variable] = (
                f"(sin {{{quantity.name}}})" if sine else f"{{{quantity.name}}}",
                power,
            )

    def by_name(q: Values) -> dict[str, Any]:
        # with the units of the dimensionless disk, the member as `at`
        names = ("at" if n == at else n for n in quantities)
        return {"mass": 1, "radius": 1, "gravity": 1} | dict(zip(names, q, strict=True))

    def point(algebra: Algebra, q: Values) -> list[Any]:
        return exact.point(by_name(q), algebra)

    def coefficients(algebra: Algebra, q: Values) -> list[list[Any]]:
        scale, _ = exact.scale(by_name(q))  # with λ = σ · scale the power i has scale^(n - i)
        rows = []
        for factor in stored.coefficients(point(algebra, q)):
            powers: list[Any] = [1.0]
            for _ in factor[1:]:
                powers.append(powers[-1] if scale is None else scale * powers[-1])
            rows.append([c * s for c, s in zip(factor, reversed(powers), strict=True)])
        return rows

    def signs(algebra: Algebra, q: Values) -> list[tuple[Any, Any]]:
        at = point(algebra, q)
        return [sized(p, 0, algebra, at) for _, p in stored.conditions]

    def unknown(algebra: Algebra, q: Values) -> dict[str, Any]:
        values, functions = by_name(q), SimpleNamespace(**algebra.functions)
        states = record.member(functions, values["at"], values["k"])
        return {n: states[n] for n in family.unknown}

    return PageFormulas(
        names=tuple(quantities),
        even=(stored.even,) * len(stored.factors),
        zeros=stored.zeros,
        coefficients=coefficients,
        signs=signs,
        rules=tuple(
            Rule(kind, share_of(p, PLAIN), typeset(p, written), filled(p, put))
            for kind, p in stored.conditions
        ),
        unknown=unknown,
        good=best(even=stored.even),
    )


SECONDS = 30.0
"""Longest time of the derivation of the conditions [s]."""
FUNCTION = re.compile(r"(sin|cos|sqrt)\((\w+)\)")
"""A variable that is a function of a quantity."""
SIZE = re.compile(r"sqrt\((\w+)\*\*2\)")
"""A variable that is the size of a quantity."""
ONE = "sqrt(1)"
"""A variable that is 1: the root of a graph at a point where it is a number."""


def derived_formulas(
    family: Family, quantities: Mapping[str, PageQuantity], positive: Sequence[str] = ()
) -> PageFormulas:
    """What decides the verdict of a family, derived with every quantity as a variable.

    Raises
    ------
    StabilityError
        If the conditions are too large, or too much of a member is solved for.
    """
    record = conditions(family, positive=positive, decimals=True, seconds=SECONDS)
    if record.left_out:
        raise StabilityError(
            f"{family.name}: {record.left_out[0]}; the page needs every condition."
        )
    solver = solver_of(family)
    names = (*quantities, *(solver.unknown if solver else ()))
    variables = [v.name for v in record.variables]
    read = [_read(family, v, names) for v in variables]
    symbols = {n: q.symbol for n, q in quantities.items()}
    parts = dict(zip(variables, read, strict=True))
    written = {v: (_written(v, *part, symbols), 1) for v, part in parts.items()}
    put = {v: (_in_braces(*part), 1) for v, part in parts.items()}
    roundings = {v: 2 * (v not in quantities) for v in variables}
    deciding = [c for c in record.deciding if str(c.polynomial) != ONE]
    polynomials = [(c.polynomial, shift_of([c.polynomial])) for c in deciding]
    factors = [f for f in record.factors for _ in range(f.multiplicity)]

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

    formulas = PageFormulas(
        names=names,
        even=tuple(f.even for f in factors),
        zeros=record.zeros,
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
        good=_good(family, even=any(f.even for f in record.factors) or record._extra_zeros > 0),
        members=members,
        solver=solver,
        proved=solver is None,
        numbers=record.numbers,
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


STEPS = 7
"""Steps of Newton's method for an inclination."""
SIGNS = 8
"""Samples between the start and the root, and as many on its other side: a part of those by which
`ImplicitForm` knows the nearest root."""
CLOSE = 1e-5
"""Largest last step of Newton's method [rad]; the error is about its square."""
SAME = 1e-6
"""Angle within which a change of sign is rounding, or the rest of Newton's method [rad]."""


def closed_formulas(family: Family, quantities: Mapping[str, PageQuantity]) -> PageFormulas:
    """What decides the verdict of a family of a body in closed form.

    The stored polynomials have h, h′ and h′′ as variables.  Put in, they are a graph in the
    quantities, no polynomial: the signs of the conditions are read with the running error of that
    graph.  Where the inclination is solved for, by Newton's method written out, there is no such
    bound, and the page says that its verdict is a float.  Where that method ends at another
    inclination than the one that Python means, the page has no member.

    Raises
    ------
    NoMemberError
        If the family has no member at the parameters at which the page begins.

    Source: tests/explorer/test_bodies.py compares with `spectrum` at random points.
    """
    form: Any = family.formulas
    count, solved = len(family.at), isinstance(form, ImplicitForm)
    a, p = ca.SX.sym("a", count), ca.SX.sym("p", len(family.parameters))
    c = ca.SX.sym("c", len(form.constants))
    theta, there = ca.SX(0, 1), ca.SX(0, 1)
    if solved:
        theta, there = _nearest(form, p, [q.value for q in quantities.values()][count:])
    powers, unknown, positive = form.function(ca.vertcat(a, theta), p, c)
    degree = powers.numel() - 1
    rules = _rules(degree, even=form.even)
    results = [
        rule([Sized(entry, ca.fabs(entry), 0) for entry in ca.vertsplit(powers)])
        for _, _, rule in rules
    ]

    def part(*entries: Any) -> Callable[[Algebra, Values], list[Any]]:
        function = ca.Function("part", [a, p, c], [ca.densify(ca.vertcat(*entries))])
        program = Program(function, form.constants)
        return lambda algebra, q: [
            value for (value,) in program.dense(algebra, [list(q[:count]), list(q[count:])])
        ]

    coefficients, states = part(powers), part(unknown)
    values, sizes = (
        part(*(entry.value for entry in results)),
        part(*(entry.size for entry in results)),
    )
    note = "c₀, c₁, …: coefficients of the characteristic polynomial, lowest power first"
    if not form.even and degree >= 3:
        note += "; Δ: Hurwitz's determinants of it"
    return PageFormulas(
        names=tuple(quantities),
        even=(form.even,),
        zeros=form.zeros,
        coefficients=lambda algebra, q: [coefficients(algebra, q)],
        rules=tuple(Rule(kind, FLOAT, text) for kind, text, _ in rules),
        signs=lambda algebra, q: list(zip(values(algebra, q), sizes(algebra, q), strict=True)),
        unknown=lambda algebra, q: dict(zip(family.unknown, states(algebra, q), strict=True)),
        good=best(even=form.even),
        bounds=None if solved else lambda algebra, q: with_bounds(values, algebra, q),
        members=part(positive, there),
        proved=not solved,
        note=note,
    )


def _nearest(form: ImplicitForm, p: ca.SX, first: Sequence[float]) -> tuple[ca.SX, ca.SX]:
    """The inclination, and numbers that are positive where it is the root nearest to the start.

    Newton's method is written out, from the root at the first parameters.
    """
    equation = ca.Function.deserialize(form.equation)
    begin = float(form.near(list(first)))
    if not np.isfinite(begin):
        raise NoMemberError("no inclination is found at the numbers with which the page begins.")
    theta, step, slope = ca.SX(begin), ca.SX(0), ca.SX(1)
    for _ in range(STEPS):
        value, slope = equation(theta, p)
        step = value / slope
        theta = theta - step
    low, high = form.between
    least = (SAME * slope) ** 2
    at_start, _ = equation(form.start, p)
    there = [CLOSE - ca.fabs(step), theta - low, high - theta]
    for share in (*range(1 - SIGNS, 0), *range(1, SIGNS + 1)):  # the root itself at -SIGNS
        place = _within(form.start - share / SIGNS * (theta - form.start), low, high)
        there.append(equation(place, p)[0] * at_start + least)
    return theta, ca.vertcat(*there)


def _within(u: ca.SX, low: float, high: float) -> ca.SX:
    """A number moved into an interval, without a branch."""
    above = (u + low + ca.fabs(u - low)) / 2
    return (above + high - ca.fabs(high - above)) / 2


def _rules(degree: int, *, even: bool) -> list[tuple[str, str, Callable[[list[Any]], Any]]]:
    """(kind, text, function of the coefficients): Liénard and Chipart's signs.

    Each has the sign that it has for a polynomial with positive leading coefficient.
    """
    rules: list[Any] = [
        (
            "auxiliary" if i else "static",
            f"c<sub>{i}</sub> c<sub>{degree}</sub>",
            partial(_product, i, degree),
        )
        for i in range(0, 1 if even else degree, 2)
    ]
    for order in range(degree - 1, 0, -2) if not even else ():
        kind = "flutter" if order == degree - 1 else "auxiliary"
        text = f"Δ<sub>{order}</sub>" if order > 1 else f"c<sub>{degree - 1}</sub>"
        text += f" c<sub>{degree}</sub>" * (order % 2)
        rules.append((kind, text, partial(_determinant, order)))
    return rules


def _product(i: int, j: int, c: list[Any]) -> Any:
    return c[i] * c[j]


def _determinant(order: int, c: list[Any]) -> Any:
    value = expanded_determinant(hurwitz_matrix(c, order, None))
    return c[-1] * value if order % 2 else value


WIDER = 1.01
"""Factor of a bound for its own roundings."""
ULPS = 2.0
"""Units in the last place, halved, by which a sine of a browser may be off, and one to spare."""


def tracked(algebra: Algebra) -> Algebra:
    """The number type whose numbers have a value and a bound, both of another number type.

    Source: stability/algebra/running_error.py; tests/explorer/test_bodies.py compares with balls.
    """
    plain = algebra.functions

    def with_change(name: str, change: Callable[[Any, Any, Any], Any]) -> Callable[[Any], Any]:
        def bounded(x: Any) -> Any:
            number = x if isinstance(x, RunningError) else RunningError(x, 0.0)
            value = plain[name](number.value)
            rounding = 2 * ULPS * UNIT * abs(value) + TINY
            return RunningError(value, change(number.value, number.error, value) + rounding)

        return bounded

    def root(x: Any, e: Any, y: Any) -> Any:
        least = x - e
        return e / (y + plain["sqrt"]((least + abs(least)) / 2))

    def power(x: Any, n: Any) -> Any:
        out: Any = 1.0
        for _ in range(int(n)):
            out = x * out
        return out

    table: dict[str, Callable[..., Any]] = {
        "sin": with_change("sin", lambda _, e, __: e),
        "cos": with_change("cos", lambda _, e, __: e),
        "sqrt": with_change("sqrt", root),
        "fabs": with_change("fabs", lambda _, e, __: e),
        "pow": power,
    }
    return Algebra(f"tracked {algebra.name}", float, table, lasting=False)


def with_bounds(
    formula: Callable[..., list[Any]], algebra: Algebra, *inputs: Any
) -> list[tuple[Any, Any]]:
    """(value, bound) of each entry of a formula."""
    numbers = [[RunningError(v, 0.0) for v in some] for some in inputs]
    outputs = formula(tracked(algebra), *numbers)
    return [
        (v.value, WIDER * v.error) if isinstance(v, RunningError) else (v, 0.0) for v in outputs
    ]
