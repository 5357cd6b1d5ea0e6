"""A family of a body whose polynomial holds for every height, for the page.

The stored polynomials have h, h′ and h′′ as variables.  Put in, they are a graph in the quantities,
no polynomial.  So the signs of the conditions are read with the running error of that graph
(`source.tracked`).  Where the inclination is solved for, by Newton's
method written out, there is no such bound, and the page says that its verdict is a float.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

import casadi as ca

from ...algebra.number_types import Algebra
from ...algebra.program import Program
from ...algebra.upright import Upright
from ...systems.family import Family
from ...systems.graph.implicit_form import ImplicitForm
from ..source.formulas import FLOAT, Sign, Values
from ..source.source_text import graph, javascript
from ..source.tracked import with_bounds
from ..subject import Quantity, Subject

STEPS = 7
"""Steps of Newton's method for an inclination."""


class Closed:
    """Coefficients, conditions and members of a family in closed form, as graphs.

    Parameters
    ----------
    family
        A family with `formulas`.
    """

    def __init__(self, family: Family) -> None:
        form: Any = family.formulas
        self.form, self.count = form, len(family.at)
        a, p = ca.SX.sym("a", len(family.at)), ca.SX.sym("p", len(family.parameters))
        c = ca.SX.sym("c", len(form.constants))
        self.solved = isinstance(form, ImplicitForm)
        full = ca.vertcat(a, _newton(form, p)) if self.solved else a
        powers, unknown, positive = form.function(full, p, c)
        self.even = form.even
        self.rules = _rules(powers.numel() - 1, even=form.even)
        values, sizes = zip(*[rule(powers) for _, _, rule in self.rules], strict=True)
        inputs = [a, p, c]
        self._coefficients = self._program(inputs, ca.densify(powers))
        self._unknown = self._program(inputs, ca.densify(unknown))
        self._members = self._program(inputs, ca.densify(positive))
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


def _newton(form: ImplicitForm, p: ca.SX) -> ca.SX:
    """The inclination after some steps of Newton's method, written out."""
    equation, theta = ca.Function.deserialize(form.equation), ca.SX(form.start)
    for _ in range(STEPS):
        value, slope = equation(theta, p)
        theta = theta - value / slope
    return theta


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


def closed_subject(
    family: Family, quantities: tuple[Quantity, ...], axes: tuple[str, str],
    words: Mapping[str, Any],
) -> Subject:  # fmt: skip
    """A family of a body in closed form, for the page.

    Parameters
    ----------
    family
        The family, with `formulas`.
    quantities
        Its quantities, in the order of `at`, then parameters.
    axes
        Quantities on the axes at first.
    words
        `key`, `family`, `law`, `title`, `model`, `call` and `symbols` of the subject.

    Source: tests/explorer/test_bodies.py compares with `spectrum` at random points.
    """
    closed = Closed(family)
    names = [q.name for q in quantities]
    system = family.system
    x, p = system.x, system.p
    degree = closed.form.function.numel_out(0) - 1
    signs = tuple(Sign(kind, FLOAT) for kind, _, _ in closed.rules)
    return Subject(
        quantities=quantities, axes=axes, even=(closed.even,), zeros=closed.form.zeros,
        coefficients=closed.coefficients, rules=signs, signs=closed.signs,
        bounds=None if closed.solved else closed.bounds,
        members=closed.members, texts=tuple((text, "") for _, text, _ in closed.rules),
        states=system.states, member=javascript([len(names)], partial(_member, family, closed)),
        jacobian=graph(Program(ca.Function("slopes", [x, p], [ca.jacobian(system.rhs, x)]))),
        parameters=tuple(names.index(n) for n in system.parameters),
        good="neutral" if closed.even else "stable", proved=not closed.solved,
        note=_note(degree, even=closed.even), **words,
    )  # fmt: skip


def closed_states(family: Family) -> Callable[[Algebra, Values], list[Any]]:
    """States of a member as a function of the number type and the quantities."""
    return partial(_member, family, Closed(family))


def _note(degree: int, *, even: bool) -> str:
    """What the letters of the conditions are."""
    said = "c₀, c₁, …: coefficients of the characteristic polynomial, lowest power first"
    return said if even or degree < 3 else f"{said}; Δ: Hurwitz's determinants of it"


def _member(family: Family, closed: Closed, algebra: Algebra, q: Values) -> list[Any]:
    names = (*family.at, *family.parameters)
    given = dict(zip(names, q, strict=True))
    solved = dict(zip(family.unknown, closed.unknown(algebra, q), strict=True))
    found = [given.get(n, solved.get(n, family.fixed.get(n))) for n in family.system.states]
    return [math.pi / 2 if isinstance(v, Upright) else v for v in found]
