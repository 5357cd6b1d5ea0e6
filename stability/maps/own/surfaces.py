"""Signs of polynomials in two variables over many points and boxes, each sign proved.

A polynomial is shifted exactly to the middle of a narrow map, and scaled by powers of two so that
both variables are at most one in size.  Doubles then give its value with an error of a few units in
the last place of the sum of its terms' sizes.  Over a box the linear part is exact, and the rest is
bounded by the terms' sizes.
"""

from __future__ import annotations

from fractions import Fraction
from math import comb, frexp
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...algebra.running_error import UNIT
from ...base.axis import Axis
from ...base.types import Floats

Signs = NDArray[np.int8]

NARROW = 0.5
"""An axis whose width is less than this share of its largest number is shifted to its middle."""
LEAST = 1e-280
"""Size below which no sign is taken as proved: far above every loss by underflow."""


class Window:
    """An axis of a map as t = (x - middle)/unit, with |t| at most about one.

    Parameters
    ----------
    axis
        The axis.
    """

    def __init__(self, axis: Axis) -> None:
        size = max(abs(axis.low), abs(axis.high))
        narrow = axis.high - axis.low < NARROW * size
        self.middle = axis.low + 0.5 * (axis.high - axis.low) if narrow else 0.0
        reach = max(abs(axis.low - self.middle), abs(axis.high - self.middle))
        self.unit = 2.0 ** frexp(reach or 1.0)[1]

    def __call__(self, x: Floats) -> Floats:
        """Scaled numbers, each with a relative error of one rounding."""
        out: Floats = (x - self.middle) / self.unit
        return out


def powers(t: Floats, degree: int) -> Floats:
    """Powers 0 … degree, shape (degree + 1, N)."""
    out = np.empty((degree + 1, *np.shape(t)))
    out[0] = 1.0
    for i in range(degree):
        np.multiply(out[i], t, out=out[i + 1])
    return out


def slopes(table: Floats) -> Floats:
    """Derivatives of powers, from the powers."""
    out = np.zeros_like(table)
    for i in range(1, len(table)):
        np.multiply(table[i - 1], float(i), out=out[i])
    return out


class Surface:
    """A polynomial in x and y over the windows of a map.

    Parameters
    ----------
    terms
        Rational coefficient by exponents (i, j).
    windows
        Windows of x and y.
    """

    def __init__(self, terms: dict[tuple[int, int], Fraction], windows: tuple[Window, Window]):
        shape = tuple(1 + max(e[k] for e in terms) for k in (0, 1))
        table = [[Fraction(0)] * shape[1] for _ in range(shape[0])]
        for (i, j), c in terms.items():
            table[i][j] = c
        table = _shifted(table, windows[0])
        turned = _shifted([list(column) for column in zip(*table, strict=True)], windows[1])
        top = max(abs(c) for row in turned for c in row)
        self.exponent = top.numerator.bit_length() - top.denominator.bit_length()
        """The polynomial is 2^exponent times the stored one."""
        scale = Fraction(2) ** -self.exponent
        self.matrix = np.array([[_double(c * scale) for c in row] for row in turned]).T.copy()
        self.size = np.abs(self.matrix)
        rows, columns = self.matrix.shape
        self.unit = (6 * (rows + columns) + 20) * UNIT
        """Relative rounding error of a value, to the sum of the sizes of its terms."""
        self.most = self.unit * self.size.sum() * 1.01
        """Largest rounding error of a value where |t| <= 1."""

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
            bound = self.unit * 1.01 * _sum(self.size, *some)
            signs[left] = _sure(value[left], bound)
        return signs

    def over(self, box: Box) -> Signs:
        """Proved signs over whole boxes, 0 where open.

        Parameters
        ----------
        box
            The boxes.
        """
        rows, columns = self.matrix.shape
        t, s, dt, ds = box.t[:rows], box.s[:columns], box.dt[:rows], box.ds[:columns]
        along = self.matrix @ s
        value = (along * t).sum(0)
        slope = np.abs((along * dt).sum(0)) * box.h
        slope += np.abs(_sum(self.matrix, t, ds)) * box.k
        at, as_, adt, ads = np.abs(t), np.abs(s), np.abs(dt), np.abs(ds)
        sized = self.size @ as_
        rest = _sum(self.size, box.far_t[:rows], box.far_s[:columns]) - (sized * at).sum(0)
        rest -= (sized * adt).sum(0) * box.h + _sum(self.size, at, ads) * box.k
        # eleven sums above, each with slopes at most `rows + columns` times the terms, and h, k <= 2
        slack = 16.0 * (rows + columns) * self.most
        return _sure(value, (slope + np.maximum(rest, 0.0)) * (1 + 1e-9) + slack * box.reach)

    def product(self, t: Floats, s: Floats) -> tuple[Floats, Floats]:
        """Values and bounds on their errors over a grid, in units of 2^exponent.

        Parameters
        ----------
        t, s
            Powers of the scaled numbers along x and y.
        """
        rows, columns = self.matrix.shape
        t, s = t[:rows], s[:columns]
        value = s.T @ (self.matrix.T @ t)
        error = np.abs(s).T @ (self.unit * 1.02 * self.size.T @ np.abs(t)) + LEAST
        return value, error


class Box:
    """Boxes in scaled numbers, with the tables that every surface needs.

    Parameters
    ----------
    t, s
        Low and high ends of the scaled numbers, shapes (N,).
    degrees
        Largest degrees in both.
    """

    def __init__(
        self, t: tuple[Floats, Floats], s: tuple[Floats, Floats], degrees: tuple[int, int]
    ) -> None:
        middle = 0.5 * (t[0] + t[1]), 0.5 * (s[0] + s[1])
        # the ends, and the middle, are rounded: a few units of their size
        self.h, self.k = (
            np.maximum(v[1] - m, m - v[0]) * (1 + 8 * UNIT) + 8 * UNIT * (np.abs(m) + 1e-30)
            for v, m in zip((t, s), middle, strict=True)
        )
        self.t, self.s = (powers(m, d) for m, d in zip(middle, degrees, strict=True))
        self.dt, self.ds = slopes(self.t), slopes(self.s)
        self.far_t, self.far_s = (
            powers(np.abs(m) + r, d)
            for m, r, d in zip(middle, (self.h, self.k), degrees, strict=True)
        )
        self.reach = np.maximum(self.far_t[-1], 1.0) * np.maximum(self.far_s[-1], 1.0)
        """Largest size of a monomial over each box, at least one."""

    def take(self, index: Any) -> Box:
        """Some of the boxes.

        Parameters
        ----------
        index
            Their places.
        """
        out = object.__new__(Box)
        for name, value in vars(self).items():
            setattr(out, name, value[..., index])
        return out


def _sum(matrix: Floats, t: Floats, s: Floats) -> Floats:
    out: Floats = ((matrix @ s) * t).sum(0)
    return out


def _sure(value: Floats, bound: Any) -> Signs:
    """The sign where the size is beyond the bound; NaN, from an overflow, is open."""
    bound = bound + LEAST
    return (value > bound).astype(np.int8) - (value < -bound).astype(np.int8)


def _shifted(table: list[list[Fraction]], window: Window) -> list[list[Fraction]]:
    """P(middle + unit t) by powers of t, for the first index; exact."""
    middle, unit = Fraction(window.middle), Fraction(window.unit)
    out = []
    for k in range(len(table)):
        rows = [(comb(i, k) * middle ** (i - k), table[i]) for i in range(k, len(table))]
        rows = [(c, row) for c, row in rows if c]
        out.append([unit**k * sum((c * row[j] for c, row in rows), Fraction(0))
                    for j in range(len(table[0]))])  # fmt: skip
    return out


def _double(value: Fraction) -> float:
    """The nearest double; a size of at most 2, so nothing overflows."""
    return value.numerator / value.denominator
