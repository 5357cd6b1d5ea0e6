"""Growth rates of tiles by compiled loops: tables of the polynomials, and variables of the axes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...algebra.kernels.compiled import compiled
from ...algebra.polynomial import Polynomial, TabulatedPolynomial
from ...algebra.running_error import UNIT
from ...base.types import Floats
from ...base.verdict import CODES, Verdict, best
from . import factors, loops

WIDEST = 1e30
"""Largest variable and inverse of the least one for which no step over- or underflows."""
VARIABLES = 4
"""Most variables of a polynomial."""


def scheme(polynomial: Polynomial) -> tuple[list[tuple[int, int, int]], list[float]]:
    """Steps of the nested Horner schemes of a polynomial, in the order of its source text.

    Returns
    -------
    steps, numbers
        (what, level, variable) of each step, and the number that a step sets or adds.
    """
    steps: list[tuple[int, int, int]] = []
    numbers: list[float] = []

    def step(what: int, level: int, variable: int = 0, number: float = 0.0) -> None:
        joint = {loops.SET: loops.SCALE, loops.COPY: loops.PRODUCT}
        if what == loops.TIMES and steps[-1][0] in joint:
            steps[-1] = joint[steps[-1][0]], level, variable
            return
        steps.append((what, level, variable))
        numbers.append(number)

    def value(terms: Sequence[tuple[int, tuple[int, ...]]], level: int) -> None:
        """The value of a sum of terms, on the line of its level, or as a number at level 0."""
        groups: dict[int, list[tuple[int, tuple[int, ...]]]] = {}
        for c, e in terms:
            groups.setdefault(e[-1], []).append((c, e[:-1]))
        powers = [*sorted(groups, reverse=True), 0]
        for place, power in enumerate(powers[:-1]):
            if level > 1:
                value(groups[power], level - 1)
                step(loops.ADD if place else loops.COPY, level)
            else:
                number = float(sum(c for c, _ in groups[power]))
                step(loops.PLUS if place else loops.SET, level, number=number)
            for _ in range(power - powers[place + 1]):
                step(loops.TIMES, level, level - 1)

    if polynomial.terms:
        value(polynomial.terms, len(polynomial.variables))
    else:
        step(loops.SET, len(polynomial.variables))
    while steps[-1][0] == loops.COPY:  # the value may stay on the line of a lower level
        del steps[-1], numbers[-1]
    return steps, numbers


class Tables(NamedTuple):
    """Polynomials of a family and law as the loops read them."""

    steps: NDArray[np.int64]
    """(what, level, variable) of each step of every scheme."""
    numbers: Floats
    """The number of each step."""
    parts: NDArray[np.int64]
    """First step of P⁺, first of P⁻ and end, for each coefficient."""
    bounds: Floats
    """Relative error of P⁺ and P⁻."""
    factors: NDArray[np.int64]
    """(row of the first coefficient, degree) of each factor, the largest degree first."""
    order: list[int]
    """Order of the variables, by level."""
    even: bool
    """Whether the polynomial is linear in λ²."""


def tables(exact: TabulatedPolynomial, behind: Mapping[str, int]) -> Tables | None:
    """Tables of the polynomials of a family; None where the loops have no such degrees."""
    known = exact.known
    every = sorted(known.factors, key=len, reverse=True)
    if known.even:
        every = [(every[0][0], every[0][2])] if [len(f) for f in every] == [3] else []
    degrees = [len(f) - 1 for f in every]
    fits = degrees and degrees[0] in (1, 3, 5) and all(n == 1 for n in degrees[1:])
    if not fits or sum(degrees) > 6 or len(known.variables) > VARIABLES:
        return None
    steps: list[tuple[int, int, int]] = []
    numbers: list[float] = []
    parts: list[list[int]] = []
    bounds: list[float] = []
    rows: list[tuple[int, int]] = []
    order = order_of(exact)
    for factor in every:
        rows.append((len(parts), len(factor) - 1))
        for c in factor:
            turned = Polynomial(
                tuple(known.variables[i] for i in order),
                tuple((n, tuple(e[i] for i in order)) for n, e in c.terms),
            )
            ends = [len(steps)]
            for part in turned.parts:
                more, some = scheme(part)
                steps += more
                numbers += some
                ends.append(len(steps))
            most = max(part.roundings(behind) for part in turned.parts) + 1
            parts.append(ends)
            bounds.append(1.02 * most * UNIT)
    return Tables(
        np.array(steps),
        np.array(numbers),
        np.array(parts),
        np.array(bounds),
        np.array(rows),
        order,
        known.even,
    )


def order_of(exact: TabulatedPolynomial) -> list[int]:
    """One order of the variables for all polynomials, so that a scheme knows them by level.

    Those that no polynomial has are left out: a level costs a copy.
    """
    known = exact.known
    terms = tuple(t for f in known.factors for c in f for t in c.terms)
    degrees = Polynomial(known.variables, terms).degrees
    order = sorted(range(len(known.variables)), key=lambda i: -degrees[i])
    return [i for i in order if degrees[i]] or order[:1]


class Found(NamedTuple):
    """Growth rates of a tile, flat, in the user's unit of rate."""

    rates: tuple[Floats, ...]
    """Abscissa, bound on its error and |imaginary part|, each of shape (N,)."""
    codes: NDArray[np.int8]
    """Flags of verdicts, 0 where the sign is open or the bound too large, shape (N,)."""
    poor: NDArray[np.int64]
    """Cells whose bound is too large, or whose sign is open."""
    factors: Floats
    """Factors of the polynomial of largest degree in these cells, shape (degree, cells)."""


class CompiledRates:
    """Growth rates over tiles by compiled loops."""

    def __init__(self, tables: Tables) -> None:
        self.tables = tables
        self.flags = float(CODES[best(even=tables.even)]), float(CODES[Verdict.UNSTABLE])

    @property
    def loops(self) -> SimpleNamespace:
        """The functions of `loops`, compiled at the first call of each."""
        return compiled(factors, loops)

    def __call__(
        self,
        point: list[Any],
        unit: Any,
        shape: tuple[int, int],
        out: tuple[Any, ...] | None = None,
    ) -> Found | None:
        """Growth rates of a tile; None where a variable is too large or too small.

        Parameters
        ----------
        point
            Variables of the polynomial, floats or arrays that broadcast to the shape.
        unit
            Unit of the rates, the same.
        shape
            Rows and columns.
        out
            Four contiguous arrays to fill, of shape (N,): three for rates, one for flags; new ones
            when left out.
        """
        where, values = _lines([*(point[i] for i in self.tables.order), unit])
        if not in_range(values[: where[-1, 0]]):
            return None
        count = shape[0] * shape[1]
        *rates, codes = out or (*(np.empty(count) for _ in range(3)), np.empty(count, np.int8))
        poor = np.empty(count, dtype=np.int64)
        degree = int(self.tables.factors[0, 1])
        kept = np.empty((degree, count))
        left = self.loops.sweep(
            self.tables[:5],
            where,
            values,
            shape,
            self.tables.even,
            self.flags,
            tuple(rates),
            codes,
            poor,
            kept,
        )
        return Found(tuple(rates), codes, poor[:left], kept[:, :left])

    def refine(self, found: Found, point: list[Any], unit: Any, columns: int) -> Found:
        """The same with coefficients from pairs of doubles, where the first bounds are too large.

        Parameters
        ----------
        found
            Growth rates of the tile, which change in place.
        point
            Variables in long double, arrays that broadcast to the tile.
        unit
            As before.
        columns
            Columns of the tile.
        """
        where, values = _lines([*(point[i] for i in self.tables.order), unit])
        doubles = values.astype(float)
        rest = (values - doubles).astype(float)
        poor, kept = np.empty_like(found.poor), np.empty_like(found.factors)
        left = self.loops.refine(
            self.tables[:5],
            where,
            doubles,
            rest,
            columns,
            found.poor,
            found.factors,
            self.tables.even,
            self.flags,
            found.rates,
            found.codes,
            poor,
            kept,
        )
        return Found(found.rates, found.codes, poor[:left], kept[:, :left])


def in_range(values: Any) -> bool:
    """Whether numbers are zero, or of a size whose products neither over- nor underflow."""
    size = np.abs(values)
    return bool(((size == 0) | ((size > 1 / WIDEST) & (size < WIDEST))).all())


def _lines(arrays: list[Any]) -> tuple[NDArray[np.int64], Any]:
    """(offset, step of a row, step of a column) of each array in one flat array, and that."""
    where, flat, offset = [], [], 0
    for array in arrays:
        whole = np.atleast_2d(array)
        rows, columns = whole.shape
        where.append((offset, columns if rows > 1 else 0, 1 if columns > 1 else 0))
        flat.append(whole.reshape(-1))
        offset += whole.size
    return np.array(where), np.concatenate(flat)
