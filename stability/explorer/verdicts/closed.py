"""A family of a body whose polynomial holds for every height, for the page.

The stored polynomials have h, h′ and h′′ as variables.  Put in, they are a graph in the quantities,
no polynomial.  So the signs of the conditions are read with the running error of that graph
(`source.tracked`).  Where the inclination is solved for, by Newton's
method written out, there is no such bound, and the page says that its verdict is a float.  Where
that method ends at another inclination than the one that Python means, the page has no member.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import casadi as ca
import numpy as np

from ...algebra.number_types import Algebra
from ...algebra.program import Program
from ...base.errors import NoMemberError
from ...base.verdict import best
from ...systems.family import Family
from ...systems.graph.implicit_form import ImplicitForm
from ..quantity import Quantity
from ..source.formulas import FLOAT, Formulas, Sign, Values
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


class Closed:
    """Coefficients, conditions and members of a family in closed form, as graphs.

    Parameters
    ----------
    family
        A family with `formulas`.
    first
        Parameters at which the page begins.

    Raises
    ------
    NoMemberError
        If the family has no member at these parameters.
    """

    def __init__(self, family: Family, first: Sequence[float]) -> None:
        form: Any = family.formulas
        self.form, self.count = form, len(family.at)
        a, p = ca.SX.sym("a", len(family.at)), ca.SX.sym("p", len(family.parameters))
        c = ca.SX.sym("c", len(form.constants))
        self.solved = isinstance(form, ImplicitForm)
        theta, there = _nearest(form, p, first) if self.solved else (ca.SX(0, 1), ca.SX(0, 1))
        powers, unknown, positive = form.function(ca.vertcat(a, theta), p, c)
        self.even = form.even
        self.rules = _rules(powers.numel() - 1, even=form.even)
        values, sizes = zip(*[rule(powers) for _, _, rule in self.rules], strict=True)
        inputs = [a, p, c]
        self._coefficients = self._program(inputs, ca.densify(powers))
        self._unknown = self._program(inputs, ca.densify(unknown))
        self._members = self._program(inputs, ca.densify(ca.vertcat(positive, there)))
        self._values = self._program(inputs, ca.densify(ca.vertcat(*values)))
        self._sizes = self._program(inputs, ca.densify(ca.vertcat(*sizes)))

    def _program(self, inputs: list[ca.SX], output: ca.SX) -> Program:
        return Program(ca.Function("part", inputs, [output]), self.form.constants)

    def _run(self, program: Program, algebra: Algebra, q: Values) -> list[list[Any]]:
        zero: list[list[Any]] = []
        found = program.run(algebra, [list(q[: self.count]), list(q[self.count :])])
        for values, places, (rows, _) in zip(found, program.places, program.shapes, strict=True):
            column = [0.0] * rows
            for (row, _), value in zip(places, values, strict=True):
                column[row] = value
            zero.append(column)
        return zero

    def coefficients(self, algebra: Algebra, q: Values) -> list[list[Any]]:
        """The one factor: coefficients in λ, lowest first, those of even powers if it is even."""
        return self._run(self._coefficients, algebra, q)

    def unknown(self, algebra: Algebra, q: Values) -> list[Any]:
        """States that follow from the quantities, in the order of the family."""
        return self._run(self._unknown, algebra, q)[0]

    def members(self, algebra: Algebra, q: Values) -> list[Any]:
        """Numbers that are positive at every member."""
        return self._run(self._members, algebra, q)[0]

    def signs(self, algebra: Algebra, q: Values) -> list[tuple[Any, Any]]:
        """(value, size of its products) of each condition."""
        values, sizes = (self._run(p, algebra, q)[0] for p in (self._values, self._sizes))
        return list(zip(values, sizes, strict=True))

    def bounds(self, algebra: Algebra, q: Values) -> list[tuple[Any, Any]]:
        """(value, bound on its error) of each condition."""
        return with_bounds(lambda a, z: self._run(self._values, a, z)[0], algebra, q)


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


def _rules(degree: int, *, even: bool) -> list[tuple[str, str, Any]]:
    """(kind, text, function of the coefficients to value and size): Liénard and Chipart's signs."""

    def product(i: int, j: int, c: ca.SX) -> tuple[ca.SX, ca.SX]:
        return c[i] * c[j], ca.fabs(c[i] * c[j])

    if even:
        return [("static", f"c<sub>0</sub> c<sub>{degree}</sub>", partial(product, 0, degree))]
    rules = [
        ("auxiliary" if i else "static", f"c<sub>{i}</sub> c<sub>{degree}</sub>",
         partial(product, i, degree)) for i in range(0, degree, 2)
    ]  # fmt: skip
    for order in range(degree - 1, 0, -2):
        kind = "flutter" if order == degree - 1 else "auxiliary"
        text = f"Δ<sub>{order}</sub>" if order > 1 else f"c<sub>{degree - 1}</sub>"
        text += f" c<sub>{degree}</sub>" * (order % 2)
        rules.append((kind, text, partial(_hurwitz, degree, order)))
    return rules


def _hurwitz(degree: int, order: int, c: ca.SX) -> tuple[ca.SX, ca.SX]:
    """A Hurwitz determinant by its minors, and the same with every product positive.

    Its sign is that for a polynomial with positive leading coefficient where the order is even; an
    odd one is multiplied by the leading coefficient.
    """
    odd = c[degree] if order % 2 else ca.SX(1)
    places = [[degree - (2 * i - j + 1) for j in range(order)] for i in range(order)]

    def entry(i: int, j: int) -> ca.SX:
        inside = 0 <= places[j][i] <= degree
        return c[places[j][i]] if inside else ca.SX(0)

    value = _minors([[entry(i, j) for j in range(order)] for i in range(order)], -1)
    size = _minors([[ca.fabs(entry(i, j)) for j in range(order)] for i in range(order)], 1)
    return odd * value, ca.fabs(odd) * size


def _minors(rows: Sequence[Sequence[ca.SX]], sign: int) -> ca.SX:
    """Determinant (`sign` -1) or permanent (1) by the first row."""
    if len(rows) == 1:
        return rows[0][0]
    total = ca.SX(0)
    for j, first in enumerate(rows[0]):
        if not first.is_zero():
            rest = [[*row[:j], *row[j + 1 :]] for row in rows[1:]]
            total += sign**j * first * _minors(rest, sign)
    return total


def closed_formulas(family: Family, quantities: Mapping[str, Quantity]) -> Formulas:
    """What decides the verdict of a family of a body in closed form.

    Parameters
    ----------
    family
        The family, with `formulas`.
    quantities
        What names a member, by name in the family: `at`, then parameters.

    Source: tests/explorer/test_bodies.py compares with `spectrum` at random points.
    """
    closed = Closed(family, [q.value for q in quantities.values()][len(family.at) :])
    degree = closed.form.function.numel_out(0) - 1
    note = "c₀, c₁, …: coefficients of the characteristic polynomial, lowest power first"
    if not closed.even and degree >= 3:
        note += "; Δ: Hurwitz's determinants of it"
    return Formulas(
        names=tuple(quantities), even=(closed.even,), zeros=closed.form.zeros,
        coefficients=closed.coefficients, signs=closed.signs,
        rules=tuple(Sign(kind, FLOAT) for kind, _, _ in closed.rules),
        texts=tuple((text, "") for _, text, _ in closed.rules),
        unknown=lambda a, q: dict(zip(family.unknown, closed.unknown(a, q), strict=True)),
        good=best(even=closed.even), bounds=None if closed.solved else closed.bounds,
        members=closed.members, proved=not closed.solved, note=note,
    )  # fmt: skip
