"""Signs of polynomials in two variables over many points and boxes, each sign proved.

A polynomial is shifted exactly to the middle of a narrow map, and scaled by powers of two so that
both variables are at most one in size.  Doubles then give its value with an error of a few units in
the last place of the sum of its terms' sizes.  Over a box Taylor's sum at the middle bounds it.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from math import comb, frexp
from typing import Any

import numpy as np
from flint import arb, fmpq
from numpy.typing import NDArray

from ..algebra.exact.number_fields import NotExact, rational
from ..algebra.kernels.pairs import DOUBLED, doubled, step, two_product, two_sum
from ..algebra.number_types import precision
from ..algebra.running_error import UNIT
from ..base.axis import Axis
from ..base.types import Floats

Signs = NDArray[np.int8]

NARROW = 0.5
"""An axis whose width is less than this share of its largest number is shifted to its middle."""
BITS = 2048
"""Precision in which balls are shifted."""
LOSS = 2.0**-180
"""Radius of a ball, relative to the largest coefficient, that is allowed; far below rounding."""
LEAST = 1e-280
"""Size below which no sign is taken as proved: far above every loss by underflow."""


WIDEST = 1e30
"""Largest number, and inverse of the least one, whose powers are taken before they are scaled."""
ORDERS = 6
"""Largest order of Taylor's coefficients for the points of a small box."""


class Window:
    """An axis of a map as t = (v(x) - middle)/unit, with |t| at most about one.

    Parameters
    ----------
    axis
        The axis.
    function
        Variable v of the polynomials: x itself (empty), or its sine or cosine.
    power
        Power of x in v, where every polynomial is one in it.
    """

    def __init__(self, axis: Axis, function: str = "", power: int = 1) -> None:
        size = max(abs(axis.low), abs(axis.high))
        narrow = axis.high - axis.low < NARROW * size and not function
        fits = 1 / WIDEST < size < WIDEST  # so that no power of x over- or underflows
        self.function, self.power = function, power if fits and not narrow else 1
        self.middle = axis.low + 0.5 * (axis.high - axis.low) if narrow else 0.0
        reach = max(abs(axis.low - self.middle), abs(axis.high - self.middle))
        self.unit = 2.0 ** frexp(1.0 if function else (reach or 1.0) ** self.power)[1]

    @property
    def roundings(self) -> int:
        """Most roundings of a scaled number: of the difference, or of v."""
        return 2 if self.function else max(int(self.middle != 0), self.power - 1)

    def __call__(self, x: Floats) -> Floats:
        """Scaled numbers, each with a few roundings."""
        if self.function:
            v = np.sin(x) if self.function == "sin" else np.cos(x)
        else:
            v = x - self.middle
            for _ in range(self.power - 1):
                v = v * x
        out: Floats = v / self.unit
        return out

    def pairs(self, x: Floats) -> tuple[Floats, Floats]:
        """Scaled numbers as pairs of doubles, exact but for a sine."""
        high = self(x)
        if self.function:
            with precision(128):
                true = [getattr(arb(float(v)), self.function)() / self.unit for v in x]
                low = [float(v - arb(float(h))) for v, h in zip(true, high, strict=True)]
            return high, np.array(low)
        v, rest = two_sum(x, -self.middle)
        for _ in range(self.power - 1):
            first, more = two_product(v, x)
            v, rest = first, more + rest * x
        return v / self.unit, rest / self.unit

    def ends(self, low: Floats, high: Floats) -> tuple[Floats, Floats]:
        """Least and largest scaled number between both."""
        t, s = self(low), self(high)
        least, most = np.minimum(t, s), np.maximum(t, s)
        if self.function:
            middle = np.pi / 2 if self.function == "sin" else 0.0
            # the right angle is no double, so that a box may end there
            over = (low <= middle) & (high > middle if self.function == "sin" else high >= middle)
            return least, np.where(over, 1 / self.unit, most)
        if self.power % 2 == 0:
            least = np.where((low <= 0) & (high >= 0), 0.0, least)
        return least, most


def powers(t: Floats, degree: int) -> Floats:
    """Powers 0 … degree, shape (degree + 1, N)."""
    out = np.empty((degree + 1, *np.shape(t)), dtype=t.dtype)
    out[0] = 1.0
    for i in range(degree):
        np.multiply(out[i], t, out=out[i + 1])
    return out


class Surface:
    """A polynomial in x and y over the windows of a map.

    Parameters
    ----------
    terms
        Coefficient by exponents (i, j): all are `fmpq`, or narrow balls.
    windows
        Windows of x and y.
    """

    def __init__(self, terms: dict[tuple[int, int], Any], windows: tuple[Window, Window]):
        shape = tuple(1 + max(e[k] for e in terms) for k in (0, 1))
        number = arb if isinstance(next(iter(terms.values())), arb) else fmpq
        table = [[number(0)] * shape[1] for _ in range(shape[0])]
        for (i, j), c in terms.items():
            table[i][j] = c
        with precision(BITS):
            table = _shifted(table, windows[0], number)
            turned = _shifted([list(c) for c in zip(*table, strict=True)], windows[1], number)
            self.exponent = max(_exponent(c) for row in turned for c in row)
            """The polynomial is 2^exponent times the stored one."""
            rows_ = [[_double(c, self.exponent) for c in row] for row in turned]
        self.matrix = np.array(rows_).T.copy()
        self.rest: Floats | None = None
        """What rounding to doubles left of the matrix, as doubles; None for balls."""
        self.least = LEAST if number is fmpq else LOSS * len(rows_) * len(rows_[0])
        """Absolute error that the sum of the terms' sizes does not tell."""
        if number is fmpq:
            scale = fmpq(2) ** -self.exponent
            rest = [
                [_nearest(c * scale - rational(d)) for c, d in zip(*both, strict=True)]
                for both in zip(turned, rows_, strict=True)
            ]
            self.rest = np.array(rest).T.copy()
        self.size = np.abs(self.matrix)
        rows, columns = self.matrix.shape
        self.unit = (6 * (rows + columns) + 20) * UNIT
        """Relative rounding error of a value, to the sum of the sizes of its terms."""
        self.roundings = self._counted(*(w.roundings for w in windows))
        """Most roundings of a term of a value at a point."""
        self.most = self.unit * self.size.sum() * 1.01 + self.least
        """Largest rounding error of a value where |t| <= 1."""

    def _counted(self, behind: int, across: int) -> int:
        """Most roundings of a term, in Horner's scheme and in a product of matrices.

        Terms are summed along one variable, then along the other; a zero adds none.
        """
        there = self.matrix != 0
        i, j = np.nonzero(there)
        exact = self.rest is not None and not self.rest.any()
        term = int((i * (behind + 1) + j * (across + 1)).max()) + (not exact)
        sums = [
            max(int(v.sum(axis)[v.any(axis)].max()), 1) + int(v.any(axis).sum()) - 2
            for v, axis in ((there, 0), (there, 1))
        ]
        return term + max(sums)

    @property
    def degrees(self) -> tuple[int, int]:
        """Degrees in x and y."""
        return self.matrix.shape[0] - 1, self.matrix.shape[1] - 1

    def at(self, t: Floats, s: Floats) -> Signs:
        """Proved signs at points, 0 where open.

        Parameters
        ----------
        t, s
            Powers of the scaled numbers, shapes (at least degree + 1, N).
        """
        rows, columns = self.matrix.shape
        value = _sum(self.matrix, t[:rows], s[:columns])
        signs = _sure(value, self.most)
        left = np.flatnonzero(signs == 0)
        if len(left):
            some = np.abs(t[:rows, left]), np.abs(s[:columns, left])
            bound = self.unit * 1.01 * _sum(self.size, *some) + self.least
            signs[left] = _sure(value[left], bound)
        return signs

    def over(self, box: Box) -> Signs:
        """Proved signs over whole boxes, 0 where open."""
        value: Any = 0.0
        spread: Any = 0.0
        rounding = self._rounding(box)
        terms, left_out = self._taylor(box, sum(self.degrees), rounding)
        for a, b, coefficient in terms:
            if a or b:
                np.abs(coefficient, out=coefficient)
                spread = spread + coefficient * box.far_t[a] * box.far_s[b]
            else:
                value = coefficient
        # all sums together round as one of the terms' sizes
        slack = 2.0 * rounding + left_out
        return _sure(value, spread * (1 + 1e-9) + slack)

    def inside(self, box: Box, t: Floats, s: Floats) -> Signs:
        """Proved signs at points of a grid in each box, 0 where open.

        Parameters
        ----------
        box
            The boxes.
        t, s
            Scaled numbers of the grid less those of the middle of its box, shapes (N, ·).

        Returns
        -------
        ndarray
            Shape (N, points along s, points along t).
        """
        rounding = self._rounding(box)
        terms, left_out = self._taylor(box, ORDERS, rounding)
        by_power: dict[int, Any] = {}
        size: Any = 0.0
        for a, b, coefficient in terms:
            size = size + np.abs(coefficient) * box.far_t[a] * box.far_s[b]
            term = coefficient[:, None] * t**a if a else coefficient[:, None]
            by_power[b] = by_power[b] + term if b in by_power else term
        value: Any = np.zeros((len(t), s.shape[1], t.shape[1]))
        for b in range(max(by_power), -1, -1):
            if b < max(by_power):
                value *= s[:, :, None]
            if b in by_power:
                value += by_power[b][:, None, :]
        # the scaled numbers are rounded too: as much as a unit of the terms' sizes
        bound = 4.0 * rounding + left_out + 64 * UNIT * size
        return _sure(value, bound[:, None, None])

    def _rounding(self, box: Box) -> Floats:
        """Rounding error of a value anywhere in each box."""
        rows, columns = self.matrix.shape
        most = _sum(self.size, box.end_t[:rows], box.end_s[:columns])
        out: Floats = self.unit * 1.01 * most + self.least
        return out

    def _taylor(
        self, box: Box, orders: int, rounding: Floats
    ) -> tuple[list[tuple[int, int, Floats]], Any]:
        """(a, b, Taylor's coefficient at the middle of each box), and a bound on the rest.

        Coefficients whose terms are small, or of higher order than asked, are left out.
        """
        terms = []
        high, wide, left_out = float(box.h.max()), float(box.k.max()), 0.0
        limit = 2.0 * float(rounding.min())
        for a, b, matrix, size in self.derivatives:
            largest = size * high**a * wide**b * 1.001
            if a + b and (a + b > orders or left_out + largest < limit):
                left_out += largest
            else:
                value = _sum(matrix, box.t[: len(matrix)], box.s[: matrix.shape[1]])
                terms.append((a, b, value))
        return terms, left_out * box.reach

    @cached_property
    def derivatives(self) -> list[tuple[int, int, Floats, float]]:
        """(a, b, derivative of these orders by a! b! as a matrix, its size), last orders first."""
        rows, columns = self.matrix.shape
        along = [
            [float(comb(n, k)) for n in range(max(rows, columns))]
            for k in range(max(rows, columns))
        ]
        terms = []
        for a in range(rows):
            for b in range(columns):
                factor = np.outer(along[a][a:rows], along[b][b:columns])
                matrix = self.matrix[a:, b:] * factor
                terms.append((a, b, matrix, float(np.abs(matrix).sum())))
        return sorted((v for v in terms if v[3]), key=lambda v: -(v[0] + v[1]))

    def product(self, t: Floats, s: Floats) -> tuple[Floats, Floats]:
        """Values and bounds on their errors over a grid, in units of 2^exponent."""
        rows, columns = self.matrix.shape
        t, s = t[:rows], s[:columns]
        value = s.T @ (self.matrix.T @ t)
        unit = 1.02 * self.roundings * UNIT
        error = np.abs(s).T @ (unit * self.size.T @ np.abs(t)) + self.least
        return value, error

    def surely(self, t: tuple[Any, Any], s: tuple[Any, Any], rows: Any, columns: Any) -> Signs:
        """Proved signs at some cells of a grid in pairs of doubles, 0 where open, as `twice`."""
        high, low, bound = self.twice(t, s, rows, columns)
        return _sure(high, bound + np.abs(low))

    def twice(
        self, t: tuple[Any, Any], s: tuple[Any, Any], rows: Any, columns: Any
    ) -> tuple[Any, Any, Any]:
        """Values at some cells of a grid in pairs of doubles, and bounds on their errors.

        Parameters
        ----------
        t, s
            Scaled numbers of columns and rows as pairs of doubles.
        rows, columns
            The cells.
        """
        assert self.rest is not None
        high = low = size = np.zeros(len(rows))
        x, dx = (v[columns] for v in t)
        for line, rest in zip(self.matrix[::-1], self.rest[::-1], strict=True):
            more, less, part = (v[rows] for v in doubled(line, rest, *s))
            high, low = step(high, low, x, dx, more, less)
            size = size * np.abs(x) + part
        return high, low, DOUBLED * size + self.least


class Box:
    """Boxes in scaled numbers, with the tables that every surface needs.

    Parameters
    ----------
    t, s
        Low and high ends of the scaled numbers, shapes (N,).
    degrees
        Largest degrees in both.
    """

    def __init__(self, t: Sequence[Floats], s: Sequence[Floats], degrees: Sequence[int]) -> None:
        middle = self.middle = 0.5 * (t[0] + t[1]), 0.5 * (s[0] + s[1])
        # the ends, and the middle, are rounded: a few units of their size
        self.h, self.k = (
            np.maximum(v[1] - m, m - v[0]) * (1 + 8 * UNIT) + 8 * UNIT * (np.abs(m) + 1e-30)
            for v, m in zip((t, s), middle, strict=True)
        )
        self.t, self.s = (powers(m, d) for m, d in zip(middle, degrees, strict=True))
        self.far_t, self.far_s = (
            powers(r, d) for r, d in zip((self.h, self.k), degrees, strict=True)
        )
        ends = [np.abs(m) + r for m, r in zip(middle, (self.h, self.k), strict=True)]
        self.end_t, self.end_s = (powers(e, d) for e, d in zip(ends, degrees, strict=True))
        self.reach = np.maximum(self.end_t[-1], 1.0) * np.maximum(self.end_s[-1], 1.0)
        """Largest size of a monomial over each box, at least one."""

    def take(self, index: Any) -> Box:
        """Some of the boxes."""
        out = object.__new__(Box)
        for name, value in vars(self).items():
            taken = tuple(v[index] for v in value) if name == "middle" else value[..., index]
            setattr(out, name, taken)
        return out


def _sum(matrix: Floats, t: Floats, s: Floats) -> Floats:
    out: Floats = ((matrix @ s) * t).sum(0)
    return out


def _sure(value: Floats, bound: Any) -> Signs:
    """The sign where the size is beyond the bound; NaN, from an overflow, is open."""
    bound = bound + LEAST
    signs: Signs = (value > bound).astype(np.int8) - (value < -bound).astype(np.int8)
    return signs


def _shifted(table: list[list[Any]], window: Window, number: Any) -> list[list[Any]]:
    """P(middle + unit t) by powers of t, for the first index; exact, or in balls."""
    middle, unit = (arb(v) if number is arb else rational(v) for v in (window.middle, window.unit))
    out = []
    for k in range(len(table)):
        rows = [(number(comb(i, k)) * middle ** (i - k), table[i]) for i in range(k, len(table))]
        rows = [(c, row) for c, row in rows if c != 0]
        out.append(
            [
                unit**k * sum((c * row[j] for c, row in rows), number(0))
                for j in range(len(table[0]))
            ]
        )
    return out


def _nearest(value: Any) -> float:
    """The double nearest to a rational number."""
    return int(value.p) / int(value.q)


def _exponent(value: Any) -> int:
    """An exponent e with |value| <= 2^e; very small for zero."""
    if isinstance(value, fmpq):
        return int(value.p).bit_length() - int(value.q).bit_length() + 1 if value else -9999
    man, exp = value.abs_upper().man_exp()
    return int(man).bit_length() + int(exp) if man else -9999


def _double(value: Any, exponent: int) -> float:
    """value/2^exponent as the nearest double, of a size of at most one."""
    if isinstance(value, fmpq):
        return _nearest(value * fmpq(2) ** -exponent)
    scaled = value * arb(2) ** -exponent
    if not scaled.rad() < LOSS / 4:
        raise NotExact("a ball that is not narrow")
    middle = float(scaled.mid())
    return middle if abs(middle) > LOSS else 0.0
