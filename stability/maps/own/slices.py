"""The characteristic polynomial of a user's family over Q, in the two axes of a map.

All other numbers are the exact ratios of their doubles, so the polynomials have two variables and
stay small.  The polynomial holds at every member of the map, on every branch: unknowns occur
linearly or not at all, and the equations vanish identically.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from functools import cached_property, lru_cache
from typing import Any

import casadi as ca
from flint import arb
from flint.utils.flint_exceptions import DomainError

from ...algebra.balls import precision
from ...algebra.exact.function_field import Expression
from ...algebra.exact.hurwitz_forms import (
    Budget,
    by_power,
    factors,
    hurwitz_determinants,
    subdiscriminants,
)
from ...algebra.exact.number_fields import (
    EXACT,
    NotExact,
    characteristic,
    exact_upright,
    rational,
)
from ...algebra.exact.rational_functions import common_multiple, primitive
from ...algebra.exact.triangular import RecordingField, occurring
from ...algebra.number_types import balls
from ...algebra.program import Program
from ...algebra.upright import Upright
from ...base.errors import ParameterError, StabilityError
from ...derivation.general.elimination import evaluate
from ...spectra.problem import Problem
from ...systems.family import Family
from ...systems.structure.identities import blocks_of, certain
from ...systems.structure.structural_zeros import structure
from .ball_polynomials import BallPolynomial, ball_determinants
from .slice_record import RING, Poly, Rows, Slice, Table

BITS = 2048
"""Precision of sines and roots of fixed numbers."""

MOST_STATES = 12
"""Most states of a system whose polynomial is sought."""
MOST_DEGREE = 64
"""Largest degree in x and y that the polynomial may reach."""
MOST_TERMS = 2000
"""Largest number of terms of a polynomial."""
SECONDS = 2.0
"""Time after which the work ends, and the map takes the graph's route."""
LAM = 2
"""Place of λ in the ring."""


def slice_of(problem: Problem, x: str, y: str) -> Slice | None:
    """The polynomial of a problem over two axes; None where there is none.

    Parameters
    ----------
    problem
        Problem of a user's family, without a polynomial of its own.
    x, y
        Names of the axes.

    Returns
    -------
    Slice or None
        None for a family that is not algebraic, whose zeros by structure are not proved for every
        member, or whose polynomial is beyond the limits of this module.
    """
    if not problem.plain or problem.exact is not None:
        return None
    names = (*problem.family.at, *problem.family.parameters)
    fixed = tuple((n, float(problem.values[n])) for n in names if n not in (x, y))
    return _cached(problem.family, x, y, fixed)


@lru_cache(maxsize=32)
def _cached(family: Family, x: str, y: str, fixed: tuple[tuple[str, float], ...]) -> Slice | None:
    if len(family.system.states) > MOST_STATES or not certain(family):
        return None
    budget = Budget(MOST_TERMS, SECONDS)
    try:
        return _Reading(family, (x, y), dict(fixed), budget).slice()
    except (NotExact, ZeroDivisionError, StabilityError, OverflowError):
        return None


class _Field(RecordingField):
    """A recording field in which the root of a square p², or |p|, is p, on one side of p = 0."""

    def __init__(self, names: Sequence[str], budget: Budget, near: Sequence[Any]) -> None:
        super().__init__(names, budget)
        self.near = near
        self.sides: list[Poly] = []
        """Polynomials that are positive where the roots are the ones taken."""

    def root(self, kind: str, square: Any, over: Any = None) -> Expression:
        """An indeterminate whose square is a polynomial, or a polynomial."""
        own = range(len(self.near))
        used = occurring(square) | (set() if over is None else occurring(over))
        value = None
        if used <= {*own}:
            with suppress(DomainError):  # no square
                value = square.sqrt()
        if value is None:
            return super().root(kind, square, over)
        side = value if over is None else value * over
        if evaluate(side, dict(zip(own, self.near, strict=True))) < 0:
            value, side = -value, -side
        if not side.is_constant():
            self.sides.append(side)
        return Expression(self, value, self.one)


class _Reading:
    """A family's graph as expressions in the axes."""

    def __init__(
        self, family: Family, axes: tuple[str, str], fixed: Mapping[str, float], budget: Budget
    ) -> None:
        self.family, self.budget = family, budget
        near = [rational(float(family.typical.get(n, 1.0))) for n in axes]
        self.field = _Field([*axes, *family.unknown], budget, near)
        self.required: list[Poly] = []
        self.nonzero: list[Poly] = []
        known: dict[str, Any] = {n: self.field.number(rational(v)) for n, v in fixed.items()}
        known |= dict(zip(axes, self.field.symbols, strict=False))
        self.a, self.q = ([known[n] for n in names] for names in (family.at, family.parameters))
        self.u = self._unknowns()
        self._check_members(known)

    def _unknowns(self) -> list[Any]:
        """The unknowns as expressions: known, or from equations in which they occur linearly."""
        family, field = self.family, self.field
        if family.closed or not family.unknown:
            return [field.number(rational(v)) for v in family.unknown.values()]
        symbols = field.symbols[2:]
        graph = family.graph
        residual, entries = graph.residual.run(EXACT, [self.a, symbols, self.q])
        slope = [[self._element(v) for v in row] for row in graph.place(entries)]
        if any(self._unsolved(v) for row in slope for v in row):
            raise NotExact("unknowns that do not occur linearly")
        rest = []
        for value, row in zip(residual, slope, strict=True):
            total = self._element(value)
            for c, u in zip(row, symbols, strict=True):
                total = total - c * u
            if self._unsolved(total):
                raise NotExact("unknowns that do not occur linearly")
            rest.append(-total)
        return self._eliminated(slope, rest)

    def _unsolved(self, value: Expression) -> bool:
        return any(i >= 2 for i in occurring(value.num) | occurring(value.den))

    def _element(self, value: Any) -> Expression:
        return value if isinstance(value, Expression) else self.field.number(value)

    def _eliminated(self, matrix: list[list[Any]], right: list[Any]) -> list[Any]:
        """The solution of linear equations; where a pivot vanishes nothing is said."""
        rows = [[*row, r] for row, r in zip(matrix, right, strict=True)]
        size = len(rows)
        for k in range(size):
            place = next((i for i in range(k, size) if rows[i][k].num != 0), None)
            if place is None:
                raise NotExact("equations that leave an unknown open")
            rows[k], rows[place] = rows[place], rows[k]
            pivot = rows[k][k]
            self._apart(pivot.num, pivot.den)
            rows[k] = [v / pivot for v in rows[k]]
            for i in range(size):
                if i != k and rows[i][k].num != 0:
                    factor = rows[i][k]
                    rows[i] = [v - factor * w for v, w in zip(rows[i], rows[k], strict=True)]
        for row in rows:
            self._apart(row[-1].den)
        return [row[-1] for row in rows]

    def _apart(self, *polys: Poly) -> None:
        self.nonzero += [p for p in polys if not p.is_constant()]

    def _check_members(self, known: Mapping[str, Any]) -> None:
        """Every rate vanishes identically; conditions and positive unknowns are required."""
        family = self.family
        rates = family.graph.rates.run(EXACT, [self.a, self.u, self.q])[0]
        if any(self._element(r).num != 0 for r in rates):
            raise NotExact("a rate that does not vanish identically")
        table = dict(known) | dict(zip(family.unknown, self.u, strict=True))
        table |= {
            n: v if isinstance(v, Upright) else self.field.number(rational(v))
            for n, v in family.held.items()
        }
        values = [table[n] for n in family.positive]
        system = family.system
        place = [[table[n] for n in names] for names in (system.states, system.parameters)]
        asked = _asked(family)
        if asked is not None:
            try:
                values += [v[0] for v in asked.run(exact_upright(), place)]
            except (TypeError, ParameterError):  # of the right angle only sine and cosine are exact
                raise NotExact("a condition at the right angle") from None
        for found in map(self._element, values):
            self.required.append(found.num * found.den)

    # --- the polynomial ---

    def slice(self) -> Slice:
        """The slice of this reading."""
        entries = self.family.graph.matrix.dense(EXACT, [self.a, self.u, self.q])
        matrix = [[self._element(v) for v in row] for row in entries]
        rows = self._in_balls(matrix) if self.field.meaning else self._over_q(matrix)
        convert = self._enclosed if self.field.meaning else self._moved
        table = Table()
        sides = self.field.sides  # roots of squares were taken on one side of zero
        required = tuple(table.condition(convert(p)) for p in (*self.required, *sides))
        apart = [convert(p) for p in self.nonzero] + [row[-1] for row, _, _ in rows]
        nonzero = tuple(table.condition(p) for p in apart if not p.is_constant())
        with precision(BITS):
            polys = [p for row, even, _ in rows for p in _conditions(row, even, self.budget)]
        conditions = tuple(table.condition(*some) for some in polys)
        even = any(even for _, even, _ in rows)
        return Slice(rows, tuple(table.polys), conditions, required, nonzero, even)

    def _over_q(self, matrix: list[list[Expression]]) -> Rows:
        """The factors of the polynomial over Q."""
        zeros, found = 0, []
        for block in blocks_of(matrix, lambda e: bool(e.num == 0)):
            poly = self._determinant(block)
            for factor, count in factors(poly)[1]:
                if factor == RING.gens()[LAM]:
                    zeros += count
                else:
                    found.append((_coefficients(factor), count))
        if zeros != structure(self.family).zeros or not found:
            raise NotExact("zeros in addition to those by structure")
        return tuple((row, _is_even(row), count) for row, count in found)

    def _in_balls(self, matrix: list[list[Expression]]) -> Rows:
        """The polynomial with sines and roots of fixed numbers as narrow balls."""
        common, plain = self._cleared(matrix, self.field.one, lambda p: p)
        self._apart(common)
        reduced = self.field.reduced
        powers = [
            self._element(c).num
            for c in characteristic(
                [[Expression(self.field, reduced(p), self.field.one) for p in row] for row in plain]
            )
        ]
        powers = [reduced(c * common**k) for k, c in enumerate(powers)]
        row = [self._enclosed(c) for c in primitive(powers)]
        row = row[structure(self.family).zeros :]
        even = self.family.conservative  # an identity, as its zeros are
        if even:
            row = [BallPolynomial({}) if k % 2 else c for k, c in enumerate(row)]
        if len(row) < 2 or row[0].is_zero():
            raise NotExact("zeros in addition to those by structure")
        return ((tuple(row), even, 1),)

    @cached_property
    def _atoms(self) -> dict[int, Any]:
        """Values of the functions of fixed numbers, as balls."""
        known: dict[int, Any] = {}
        for index, (name, x, over) in sorted(self.field.meaning.items()):
            if not self.field.uses(index) <= set(self.field.meaning):
                raise NotExact("functions of what varies")
            argument = arb(evaluate(x.num, known)) / arb(evaluate(x.den, known))
            known[index] = balls().functions[name](argument)
            if name == "sqrt" and over is not None:
                known[index] = known[index] * arb(evaluate(over, known)).sgn()
        return known

    def _enclosed(self, poly: Poly) -> BallPolynomial:
        """A polynomial of the field, with balls for the functions in it."""
        with precision(BITS):
            terms: dict[tuple[int, int], Any] = {}
            for e, c in poly.to_dict().items():
                value = arb(c)
                for index, power in enumerate(e[2:], start=2):
                    if power:
                        value = value * self._atoms[index] ** int(power)
                key = int(e[0]), int(e[1])
                terms[key] = terms[key] + value if key in terms else value
        return BallPolynomial(terms)

    def _cleared(
        self, block: list[list[Expression]], one: Poly, convert: Callable[[Poly], Poly]
    ) -> tuple[Poly, list[list[Poly]]]:
        """A common denominator, and the entries times it; a polynomial of low degree."""
        dens = [[convert(e.den) for e in row] for row in block]
        common = common_multiple((den for row in dens for den in row), one)
        plain = [
            [convert(e.num) * (common / den) for e, den in zip(*both, strict=True)]
            for both in zip(block, dens, strict=True)
        ]
        reach = max((int(p.total_degree()) for row in plain for p in row if p != 0), default=0)
        if len(block) * max(reach, int(common.total_degree())) > MOST_DEGREE:
            raise NotExact("a polynomial of high degree")
        return common, plain

    def _moved(self, poly: Poly) -> Poly:
        """A polynomial of the field, in the ring of slices."""
        if poly.context() is RING:
            return poly
        if any(i >= 2 for i in occurring(poly)):
            raise NotExact("an expression in functions")
        terms = {(int(e[0]), int(e[1]), 0): c for e, c in poly.to_dict().items()}
        return RING.from_dict(terms)

    def _determinant(self, block: list[list[Expression]]) -> Poly:
        """A multiple of det(λ - A), without common factor of its coefficients."""
        common, plain = self._cleared(block, RING.constant(1), self._moved)
        self._apart(common)
        powers = [c * common**k for k, c in enumerate(characteristic(plain))]
        powers = [RING.constant(c) if isinstance(c, int) else c for c in powers]
        lam, total = RING.gens()[LAM], RING.constant(0)
        for k, c in enumerate(primitive(powers)):
            total = total + c * lam**k
        self.budget.watch(total)
        return total


def _asked(family: Family) -> Program | None:
    """The conditions that depend on more than a right angle; the others are proved here."""
    system = family.system
    right = [i for i, n in enumerate(system.states) if isinstance(family.held.get(n), Upright)]
    others = ca.vertcat(
        *[s for i, s in enumerate(ca.vertsplit(system.x)) if i not in right], system.p
    )
    asked = [c.value for c in system.conditions if ca.depends_on(c.value, others)]
    if len(asked) == len(system.conditions):
        return system.condition_program if asked else None
    alone = [c.value for c in system.conditions if not ca.depends_on(c.value, others)]
    with precision(BITS):
        place = [arb.pi() / 2 if i in right else arb(0) for i in range(len(system.states))]
        program = Program(ca.Function("alone", [system.x, system.p], alone))
        numbers = program.run(balls(), [place, [arb(0)] * len(system.parameters)])
    if not all(v[0] > 0 for v in numbers):
        raise NotExact("a condition at the right angle")
    return Program(ca.Function("conditions", [system.x, system.p], asked)) if asked else None


def _coefficients(poly: Poly) -> tuple[Poly, ...]:
    """Coefficients by powers of λ, with a positive leading one where that is a number."""
    parts = by_power(poly, LAM)
    row = [parts.get(k, RING.constant(0)) for k in range(max(parts) + 1)]
    turn = -1 if row[-1].is_constant() and row[-1].leading_coefficient() < 0 else 1
    return tuple(c * turn for c in row)


def _is_even(row: Sequence[Poly]) -> bool:
    return len(row) % 2 == 1 and all(c == 0 for c in row[1::2])


def _conditions(row: Sequence[Poly], even: bool, budget: Budget) -> list[tuple[Poly, ...]]:
    """Products: all positive only where no root has Re >= 0; one negative only where one has > 0.

    Liénard and Chipart's conditions; for q(λ²) coefficients and subdiscriminants of q.
    """
    lead = row[-1]
    if even:
        q = row[::2]
        named = [(c, 1) for c in q[:-1]]
        if isinstance(lead, BallPolynomial) and len(q) > 3:
            raise NotExact("subdiscriminants need divisions")
        minors = subdiscriminants(q, budget) if len(q) > 2 else []
        named += [(d, 2) for d in (minors[-1:] if len(q) < 5 else minors)]
    else:
        n = len(row) - 1
        by = ball_determinants if isinstance(lead, BallPolynomial) else hurwitz_determinants
        minors = by(row, budget) if n > 1 else []
        named = [(minors[k - 1], k) for k in range(n - 1, 1, -2)]
        sets: list[set[int]] = [{0, *range(2, n, 2)}, {0, *range(1, n, 2)}]
        cost: Callable[[set[int]], int] = lambda some: sum(len(row[k]) for k in some)  # noqa: E731
        chosen = min(sets, key=cost) | ({n - 1} if n % 2 == 0 else set())
        named = [(row[k], 1) for k in sorted(chosen)] + named
    open_lead = not lead.is_constant()
    return [(p, lead) if open_lead and power % 2 else (p,) for p, power in named]
