"""A family of a body whose polynomial holds for every height, for the page.

The stored polynomials have h, h′ and h′′ as variables.  Put in, they are a graph in the quantities,
no polynomial.  So the signs of the conditions are read with the running error of that graph
(`source.tracked`).  Where the inclination is solved for, by Newton's
method written out, there is no such bound, and the page says that its verdict is a float.  Where
that method ends at another inclination than the one that Python means, the page has no member.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

import casadi as ca
import numpy as np

from ...algebra.number_types import Algebra
from ...algebra.program import Program
from ...algebra.running_error import Sized
from ...base.errors import NoMemberError
from ...base.verdict import best
from ...boundary.interval_search.meetings import hurwitz
from ...systems.family import Family
from ...systems.graph.implicit_form import ImplicitForm
from ..quantity import Quantity
from ..source.formulas import FLOAT, Formulas, Rule, Values
from ..source.tracked import with_bounds

STEPS = 7
"""Steps of Newton's method for an inclination."""
SIGNS = 8
"""Samples between the start and the root, and as many on its other side: a part of those by which
`ImplicitForm` knows the nearest root."""
CLOSE = 1e-5
"""Largest last step of Newton's method [rad]; the error is about its square."""
SAME = 1e-6
"""Angle within which a change of sign is rounding, in the shader's single precision [rad]."""


def closed_formulas(family: Family, quantities: Mapping[str, Quantity]) -> Formulas:
    """What decides the verdict of a family of a body in closed form.

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
    found = [
        rule([Sized(one, ca.fabs(one), 0) for one in ca.vertsplit(powers)]) for _, _, rule in rules
    ]

    def part(*entries: Any) -> Callable[[Algebra, Values], list[Any]]:
        function = ca.Function("part", [a, p, c], [ca.densify(ca.vertcat(*entries))])
        program = Program(function, form.constants)
        return lambda algebra, q: [
            value for (value,) in program.dense(algebra, [list(q[:count]), list(q[count:])])
        ]

    coefficients, states = part(powers), part(unknown)
    values, sizes = part(*(one.value for one in found)), part(*(one.size for one in found))
    note = "c₀, c₁, …: coefficients of the characteristic polynomial, lowest power first"
    if not form.even and degree >= 3:
        note += "; Δ: Hurwitz's determinants of it"
    return Formulas(
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
    value = hurwitz(c, order)
    return c[-1] * value if order % 2 else value
