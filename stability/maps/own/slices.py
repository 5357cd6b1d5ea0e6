"""The characteristic polynomial of a user's family over Q, in the two axes of a map.

All other numbers are the exact ratios of their doubles, so the polynomials have two variables and
stay small.  The polynomial holds at every member of the map, on every branch: unknowns occur
linearly or not at all, and the equations vanish identically.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import casadi as ca
import numpy as np
from flint import Ordering, fmpq, fmpq_mpoly, fmpq_mpoly_ctx, fmpq_poly
from scipy.sparse.csgraph import connected_components

from ...algebra.exact.function_field import Expression
from ...algebra.exact.hurwitz_forms import (
    Budget,
    TooLarge,
    by_power,
    factors,
    hurwitz_determinants,
    subdiscriminants,
)
from ...algebra.exact.number_fields import EXACT, NotExact, characteristic, rational
from ...algebra.exact.routh import on_the_axis
from ...algebra.exact.triangular import RecordingField, occurring
from ...algebra.program import Program
from ...base.errors import StabilityError
from ...base.types import fields_of
from ...base.verdict import Verdict
from ...spectra.problem import Problem
from ...systems.family import Family
from ...systems.structure.multiplicity import certain
from ...systems.structure.structural_zeros import structure

Poly = Any
"""An `fmpq_mpoly` in x, y, λ."""

MOST_STATES = 12
"""Most states of a system whose polynomial is sought."""
MOST_DEGREE = 64
"""Largest degree in x and y that the polynomial may reach."""
MOST_TERMS = 2000
"""Largest number of terms of a polynomial."""
SECONDS = 2.0
"""Time after which the work ends, and the map takes the graph's route."""
MOST_FACTORED = 80
"""Terms of a condition beyond which its factors are not sought."""
RING = fmpq_mpoly_ctx.get(("x", "y", "l"), Ordering.degrevlex)
"""The ring of all slices: x, y and λ."""
LAM = 2
"""Place of λ in the ring."""


@dataclass(frozen=True)
class Condition:
    """A polynomial as a sign times powers of factors, given by their place in a list."""

    sign: int
    """1, -1, or 0 for the polynomial zero."""
    powers: tuple[tuple[int, int], ...]
    """(place of the factor, power)."""


@dataclass(frozen=True, eq=False)
class Slice:
    """The polynomial and the conditions of a family in the axes of a map, over Q."""

    zeros: int
    """Power of λ that is left out: zeros by structure."""
    factors: tuple[tuple[tuple[Poly, ...], bool, int], ...]
    """(coefficients by powers of λ lowest first, whether even, multiplicity) of each factor."""
    surfaces: tuple[Poly, ...]
    """Polynomials in x and y whose signs are asked."""
    conditions: tuple[Condition, ...] | None
    """All positive: best verdict; one negative: unstable.  None where they are too large."""
    required: tuple[Condition, ...]
    """Positive at every member of the family."""
    nonzero: tuple[Condition, ...]
    """Not zero where the polynomial holds."""
    even: bool
    """Whether the best verdict is neutral."""

    def __reduce__(self) -> Any:
        """For other processes: polynomials as their terms."""
        return _unpacked, tuple(map(_packed, fields_of(self).values()))

    def verdict(self, x: float, y: float) -> Verdict | None:
        """The verdict of one cell over Q; None where it is no member, or this form fails.

        Parameters
        ----------
        x, y
            Doubles, taken as exact.
        """
        point = rational(x), rational(y), fmpq(0)
        signs = [_sign(p(*point)) for p in self.surfaces]
        value = [_value(c, signs) for c in self.required]
        if any(v <= 0 for v in value) or any(_value(c, signs) == 0 for c in self.nonzero):
            return None
        polys = [fmpq_poly([c(*point) for c in row]) for row, _, _ in self.factors]
        return on_the_axis(polys)


def _packed(value: Any) -> Any:
    if isinstance(value, fmpq_mpoly):
        return {tuple(map(int, e)): (int(c.p), int(c.q)) for e, c in value.to_dict().items()}
    return tuple(map(_packed, value)) if type(value) is tuple else value


def _rebuilt(value: Any) -> Any:
    if isinstance(value, dict):
        return RING.from_dict({e: fmpq(*c) for e, c in value.items()})
    return tuple(map(_rebuilt, value)) if type(value) is tuple else value


def _unpacked(*values: Any) -> Slice:
    return Slice(*map(_rebuilt, values))


def _sign(value: Any) -> int:
    return 1 if value > 0 else -1 if value < 0 else 0


def _value(condition: Condition, signs: Sequence[int]) -> int:
    out = condition.sign
    for place, power in condition.powers:
        out *= signs[place] ** power
    return out


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
    if problem.law is not None or problem.exact is not None:
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


class _Reading:
    """A family's graph as expressions in the axes."""

    def __init__(
        self, family: Family, axes: tuple[str, str], fixed: Mapping[str, float], budget: Budget
    ) -> None:
        self.family, self.budget = family, budget
        self.field = RecordingField([*axes, *family.unknown], budget)
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
        table |= {n: self.field.number(rational(float(v))) for n, v in family.held.items()
                  if family.system.conditions}  # fmt: skip
        values = [table[n] for n in family.positive]
        system = family.system
        for condition in system.conditions:
            program = Program(ca.Function("condition", [system.x, system.p], [condition.value]))
            place = [[table[n] for n in names] for names in (system.states, system.parameters)]
            values.append(program.run(EXACT, place)[0][0])
        for value in map(self._element, values):
            self.required.append(value.num * value.den)

    # --- the polynomial ---

    def slice(self) -> Slice:
        """The slice of this reading."""
        entries = self.family.graph.matrix.dense(EXACT, [self.a, self.u, self.q])
        matrix = [[self._element(v) for v in row] for row in entries]
        if self.field.meaning:
            raise NotExact("functions that are not algebraic")
        zeros, found = 0, []
        for block in _blocks(matrix):
            poly = self._determinant(block)
            for factor, count in factors(poly)[1]:
                if factor == RING.gens()[LAM]:
                    zeros += count
                elif LAM in occurring(factor):
                    found.append((_coefficients(factor), count))
                else:
                    self._apart(factor)
        if zeros != structure(self.family).zeros or not found:
            raise NotExact("zeros beside those by structure")
        rows = tuple((row, _is_even(row), count) for row, count in found)
        table = _Table()
        required = tuple(map(table.condition, map(self._moved, self.required)))
        apart = [self._moved(p) for p in self.nonzero] + [row[-1] for row, _, _ in rows]
        nonzero = tuple(table.condition(p) for p in apart if not p.is_constant())
        conditions: tuple[Condition, ...] | None = None
        try:
            polys = [p for row, even, _ in rows for p in _conditions(row, even, self.budget)]
            conditions = tuple(map(table.condition, polys))
        except TooLarge:
            pass
        even = any(even for _, even, _ in rows)
        return Slice(zeros, rows, tuple(table.polys), conditions, required, nonzero, even)

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
        common = RING.constant(1)
        dens = [[self._moved(e.den) for e in row] for row in block]
        for row in dens:
            for den in row:
                common = common * (den / common.gcd(den))
        self._apart(common)
        plain = [[self._moved(e.num) * (common / den) for e, den in zip(*both, strict=True)]
                 for both in zip(block, dens, strict=True)]  # fmt: skip
        reach = max((int(p.total_degree()) for row in plain for p in row if p != 0), default=0)
        if len(block) * max(reach, int(common.total_degree())) > MOST_DEGREE:
            raise NotExact("a polynomial of high degree")
        powers = [c * common**k for k, c in enumerate(characteristic(plain))]
        powers = [RING.constant(c) if isinstance(c, int) else c for c in powers]
        content = powers[-1]
        for c in powers:
            content = content.gcd(c)
        lam, total = RING.gens()[LAM], RING.constant(0)
        for k, c in enumerate(powers):
            total = total + c / content * lam**k
        self.budget.watch(total)
        return total


class _Table:
    """Polynomials in x and y, each kept once, and conditions as products of them."""

    def __init__(self) -> None:
        self.polys: list[Poly] = []

    def condition(self, poly: Poly) -> Condition:
        """A polynomial as a product of kept ones."""
        if poly == 0:  # neither positive nor negative: exact arithmetic decides each cell
            return Condition(0, ())
        if poly.is_constant():
            return Condition(_sign(poly.leading_coefficient()), ())
        constant, found = (fmpq(1), [(poly, 1)]) if len(poly) > MOST_FACTORED else factors(poly)
        return Condition(_sign(constant), tuple((self._place(f), n) for f, n in found))

    def _place(self, poly: Poly) -> int:
        if poly not in self.polys:
            self.polys.append(poly)
        return self.polys.index(poly)


def _blocks(matrix: list[list[Expression]]) -> list[list[list[Expression]]]:
    """Diagonal blocks of the block triangular form."""
    pattern = np.array([[entry.num != 0 for entry in row] for row in matrix])
    _, labels = connected_components(pattern, directed=True, connection="strong")
    members = [np.flatnonzero(labels == label) for label in np.unique(labels)]
    return [[[matrix[i][j] for j in some] for i in some] for some in members]


def _coefficients(poly: Poly) -> tuple[Poly, ...]:
    """Coefficients by powers of λ, with a positive leading one where that is a number."""
    parts = by_power(poly, LAM)
    row = [parts.get(k, RING.constant(0)) for k in range(max(parts) + 1)]
    turn = -1 if row[-1].is_constant() and row[-1].leading_coefficient() < 0 else 1
    return tuple(c * turn for c in row)


def _is_even(row: Sequence[Poly]) -> bool:
    return len(row) % 2 == 1 and all(c == 0 for c in row[1::2])


def _conditions(row: Sequence[Poly], even: bool, budget: Budget) -> list[Poly]:
    """Polynomials, all positive only where no root has Re > 0; one negative: some root has.

    Liénard and Chipart's conditions; for q(λ²) coefficients and subdiscriminants of q.
    """
    lead = row[-1]
    if even:
        q = row[::2]
        named = [(c, 1) for c in q[:-1]]
        minors = subdiscriminants(q, budget) if len(q) > 2 else []
        named += [(d, 2) for d in (minors[-1:] if len(q) < 5 else minors)]
    else:
        n = len(row) - 1
        minors = hurwitz_determinants(row, budget) if n > 1 else []
        named = [(minors[k - 1], k) for k in range(n - 1, 1, -2)]
        sets: list[set[int]] = [{0, *range(2, n, 2)}, {0, *range(1, n, 2)}]
        cost: Callable[[set[int]], int] = lambda some: sum(len(row[k]) for k in some)  # noqa: E731
        chosen = min(sets, key=cost) | ({n - 1} if n % 2 == 0 else set())
        named = [(row[k], 1) for k in sorted(chosen)] + named
    open_lead = not lead.is_constant()
    out = [p * lead if open_lead and power % 2 else p for p, power in named]
    return out
