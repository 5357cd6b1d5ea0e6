"""A motion as polynomials on elements of time, and linear equations along it.

A path is known at Chebyshev points of each element.  The derivative is a matrix, so the defect of
the path in any equations is an evaluation, without a run of them.  A linear equation along the path
(`LinearEquation`, or `carried` where it is stiff) gives the error that a defect causes.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray
from scipy.linalg.lapack import dtbtrs

from ...algebra.program import Program
from ...base.types import Floats
from ...integrators.taylor import available

POINTS = 16
"""Chebyshev points of an element."""
TOGETHER = 128
"""Elements whose equations are solved at once, for memory."""
MOST_COMPILED = 4
"""Most states for which the steps of `LinearEquation` are machine code: more take long to build."""


@lru_cache(maxsize=8)
def chebyshev(count: int) -> tuple[Floats, Floats, Floats]:
    """Chebyshev points of the second kind on [0, 1], their derivative matrix and weights.

    Parameters
    ----------
    count
        Number of points, both ends among them.

    Returns
    -------
    points, derivative, weights
        Rising points, shape (count,); the matrix that takes values to values of the derivative,
        shape (count, count); the barycentric weights, shape (count,).

    Source: L. N. Trefethen, Spectral Methods in MATLAB, SIAM (2000), chapter 6; J.-P. Berrut and
    L. N. Trefethen, SIAM Rev. 46 (2004) 501-517, for the weights.

    Examples
    --------
    >>> points, derivative, _ = chebyshev(5)
    >>> bool(np.allclose(derivative @ points**4, 4 * points**3))
    True
    """
    angle = np.pi * np.arange(count) / (count - 1)
    points: Floats = np.sin(angle / 2) ** 2  # exact near both ends
    weights: Floats = np.where(np.arange(count) % 2, -1.0, 1.0)
    weights[[0, -1]] /= 2
    # differences of points by the product formula, without cancellation
    sums, gaps = np.add.outer(angle, angle) / 2, np.subtract.outer(angle, angle) / 2
    apart = np.sin(sums) * np.sin(gaps)
    np.fill_diagonal(apart, 1.0)
    derivative: Floats = np.divide.outer(1 / weights, 1 / weights) / apart
    np.fill_diagonal(derivative, 0.0)
    np.fill_diagonal(derivative, -derivative.sum(axis=1))
    return points, derivative, weights


@dataclass(frozen=True, eq=False)
class Elements:
    """A division of time into elements with Chebyshev points.

    Examples
    --------
    >>> some = Elements(np.array([0.0, 1.0, 3.0]))
    >>> some.times.shape
    (2, 16)
    >>> slope = some.derivative(np.sin(some.times)[..., None])[..., 0]
    >>> bool(np.allclose(slope, np.cos(some.times)))
    True
    """

    edges: Floats
    """Rising ends of the elements, shape (E + 1,)."""
    points: int = POINTS
    """Points of each element."""

    def first(self, count: int) -> Elements:
        """The first elements alone."""
        return Elements(self.edges[: count + 1], self.points)

    @cached_property
    def lengths(self) -> Floats:
        """Lengths of the elements, shape (E,)."""
        return np.diff(self.edges)

    @cached_property
    def times(self) -> Floats:
        """Times of the points, shape (E, N)."""
        share, _, _ = chebyshev(self.points)
        times: Floats = self.edges[:-1, None] + self.lengths[:, None] * share
        times[:, -1] = self.edges[1:]
        return times

    @cached_property
    def gaps(self) -> Floats:
        """Steps between the points, shape (E, N - 1, 1, 1)."""
        gaps: Floats = (self.lengths[:, None] * _midpoints(self.points)[1])[..., None, None]
        return gaps

    def halved(self, which: NDArray[np.bool_]) -> Elements:
        """The elements, of which some are halved."""
        halves = (self.edges[:-1] + self.edges[1:])[which] / 2
        return Elements(np.union1d(self.edges, halves), self.points)

    def derivative(self, values: Floats) -> Floats:
        """Time derivative of values at the points, shape (E, N, n)."""
        matrix = chebyshev(self.points)[1]
        rates: Floats = matrix @ values / self.lengths[:, None, None]
        return rates

    def at(self, times: Floats, values: Floats) -> Floats:
        """Values at other times, shape (t, n), by barycentric interpolation."""
        share, _, weights = chebyshev(self.points)
        which = np.clip(np.searchsorted(self.edges, times, side="right") - 1, 0, len(values) - 1)
        apart = (times - self.edges[which])[:, None] / self.lengths[which, None] - share
        hit = apart == 0
        factors = weights / np.where(hit, 1.0, apart)
        on = hit.any(axis=1)
        factors[on] = hit[on]
        interpolated: Floats = np.einsum("tj,tjn->tn", factors, values[which])
        interpolated /= factors.sum(axis=1)[:, None]
        return interpolated

    def tails(self, values: Floats) -> Floats:
        """Size of the last two Chebyshev coefficients of each element: what is not resolved.

        The largest over the n values, each over 1 or its own size, shape (E,).
        """
        matrix = coefficients(self.points)[-2:]
        size = np.maximum(1.0, np.abs(values).max(axis=1))
        tails: Floats = (np.abs(matrix @ values).sum(axis=1) / size).max(axis=-1)
        return tails


@lru_cache(maxsize=8)
def coefficients(count: int) -> Floats:
    """Rows that take values at Chebyshev points to the coefficients of their polynomial.

    Examples
    --------
    >>> (coefficients(3) @ [1.0, 0.0, 1.0]).round(12).tolist()  # x² = 1/2 + (2 x² - 1)/2
    [0.5, 0.0, 0.5]
    """
    order = np.arange(count)
    cosines: Floats = np.cos(np.pi * np.outer(order, order[::-1]) / (count - 1)) * 2 / (count - 1)
    cosines[:, [0, -1]] /= 2
    cosines[[0, -1]] /= 2
    return cosines


@lru_cache(maxsize=32)
def _midpoints(count: int) -> tuple[Floats, Floats]:
    """Rows that take values at the points to the midpoints between them; the gaps of the points."""
    points, _, weights = chebyshev(count)
    apart = weights / np.subtract.outer((points[1:] + points[:-1]) / 2, points)
    return apart / apart.sum(axis=1, keepdims=True), np.diff(points)


def _between(elements: Elements, values: Floats) -> Floats:
    """Values in the middle of each step, shape (E, N - 1, …)."""
    count, points = values.shape[:2]
    inner = _midpoints(elements.points)[0] @ values.reshape(count, points, -1)
    middle: Floats = inner.reshape(count, points - 1, *values.shape[2:])
    return middle


@dataclass(frozen=True, eq=False)
class LinearEquation:
    """The equation e' = A(t) e + δ(t) along a path, built once for any δ and start.

    From one point to the next: Magnus' series to fourth order for e, whose exponential keeps the
    phase of turns at which the path itself hardly moves, and Simpson's rule for δ.

    Source: A. Iserles & S. P. Nørsett, Phil. Trans. R. Soc. A 357 (1999) 983-1019, for the series;
    tests/scene/test_elements.py for the order.
    """

    elements: Elements
    """The division of time."""
    half: Floats
    """Matrices that take e from the middle of each step to its end, shape (E, N-1, n, n)."""
    step: Floats
    """Matrices that take e from each point to the next, shape (E, N-1, n, n)."""

    @classmethod
    def along(cls, elements: Elements, matrices: Floats) -> LinearEquation:
        """The equation with the matrices A at the points, shape (E, N, n, n)."""
        middle, h = _between(elements, matrices), elements.gaps
        first, last, n = matrices[:, :-1], matrices[:, 1:], matrices.shape[-1]
        if n > MOST_COMPILED or not available():
            step, half = _steps(first, middle, last, h, np.eye(n))
            return cls(elements, half, step)
        columns = np.empty((3 * n * n + 1, h.size))
        for i, part in enumerate((first, middle, last)):
            columns[i * n * n : (i + 1) * n * n] = part.reshape(h.size, -1).T
        columns[-1] = h.ravel()
        solved = np.ascontiguousarray(_program(n).many(columns).T)
        both = solved.reshape(*h.shape[:2], 2, n, n)
        return cls(elements, both[:, :, 1], both[:, :, 0])

    def first(self, count: int) -> LinearEquation:
        """The equation on the first elements alone."""
        return LinearEquation(self.elements.first(count), self.half[:count], self.step[:count])

    @cached_property
    def _chain(self) -> Floats:
        """The steps as a banded matrix of all points but the first of the elements after the first.

        It is unit lower triangular: e at a point less the step from the point before it.
        """
        n = self.step.shape[-1]
        steps = self.step.reshape(-1, n, n)
        band = np.zeros((n * (len(steps) + 1), 2 * n))
        columns = band[:-n].reshape(-1, n, 2 * n)
        for i in range(n):
            columns[:, i, n - i : 2 * n - i] = -steps[:, :, i]
        return band.T  # as LAPACK stores it

    def solve(self, defect: Floats, start: Floats) -> Floats:
        """The solution e at the points for a defect δ there and a start.

        Shapes (E, N, n) and (n,), or (E, N, n, c) and (n, c) for c solutions at once.
        """
        count, points, n = defect.shape[:3]
        every = defect.reshape(count, points, n, -1)
        push = self.half @ _between(self.elements, every)
        push *= 4
        push += self.step @ every[:, :-1]
        push += every[:, 1:]
        push *= self.elements.gaps / 6
        drive = np.concatenate([start.reshape(n, -1), push.reshape(-1, every.shape[-1])])
        chain, _ = dtbtrs(self._chain, drive, uplo="L", diag="U")
        solution = np.empty(every.shape)
        solution[:, 1:] = chain[n:].reshape(push.shape)
        solution[0, 0], solution[1:, 0] = chain[:n], solution[:-1, -1]
        return solution.reshape(defect.shape)


def _steps(first: Any, middle: Any, last: Any, h: Any, identity: Any) -> tuple[Any, Any]:
    """Matrices over a step h and its second half, from the slopes at three points of it."""
    turn = h / 6 * (first + 4 * middle + last) - h**2 / 12 * (first @ last - last @ first)
    half = h / 4 * (middle + last)
    square = half @ half
    return _exponential(turn, identity), identity + half + square / 2 + half @ square / 6


def _exponential(matrices: Any, identity: Any) -> Any:
    """The exponential of small matrices, shape (…, n, n), to eighth order."""
    second = matrices @ matrices
    third, fourth = matrices @ second, second @ second
    later = identity / 24 + matrices / 120 + second / 720 + third / 5040 + fourth / 40320
    return identity + matrices + second / 2 + third / 6 + fourth @ later


@lru_cache(maxsize=MOST_COMPILED)
def _program(n: int) -> Program:
    """`_steps` of matrices by rows, which are the columns of its transposes."""
    (a, b, c), h = (ca.SX.sym("A", n, n) for _ in range(3)), ca.SX.sym("h")
    matrices = _steps(a.T, b.T, c.T, h, ca.SX.eye(n))
    return Program(ca.Function("steps", [a, b, c, h], [ca.densify(v.T) for v in matrices]))


def carried(elements: Elements, matrices: Floats, defect: Floats, start: Floats) -> Floats:
    """The solution of e' = A(t) e + δ(t), stiff or not, by collocation on each element.

    Shapes are those of `Linear.along` and `Linear.solve`.  The equation holds at all points but the
    first.  The end of an element is a point, so that a part that decays fast is small there.

    Examples
    --------
    >>> some, rate = Elements(np.linspace(0.0, 1.0, 3)), -1e6
    >>> matrices, defect = np.full((2, 16, 1, 1), rate), np.full((2, 16, 1), 1e6)
    >>> float(carried(some, matrices, defect, np.zeros(1))[-1, -1, 0].round(9))
    1.0
    """
    solution = np.empty(defect.shape)
    many = solution.reshape(*defect.shape[:3], -1)
    drive, at = defect.reshape(many.shape), start.reshape(defect.shape[2], -1)
    for first in range(0, len(solution), TOGETHER):
        part = slice(first, first + TOGETHER)
        solved = _collocated(elements, elements.lengths[part], matrices[part], drive[part])
        n = len(at)
        for maps, out in zip(solved, many[part], strict=True):
            out[0] = at
            out[1:] = maps[..., :n] @ at + maps[..., n:]
            at = out[-1]
    return solution


def _collocated(elements: Elements, lengths: Floats, matrices: Floats, defect: Floats) -> Floats:
    """On each element the solutions from unit starts, and from no start with each defect."""
    derivative = chebyshev(elements.points)[1]
    count, points, n, columns = defect.shape
    rows = points - 1
    table = np.zeros((count, rows, n, rows, n))
    state, point = np.arange(n), np.arange(rows)
    table[:, :, state, :, state] = derivative[1:, 1:] / lengths[:, None, None]
    table[:, point, :, point, :] -= np.moveaxis(matrices[:, 1:], 1, 0)
    first = -derivative[1:, 0] / lengths[:, None]
    right = np.zeros((count, rows, n, n + columns))
    right[..., :n] = first[:, :, None, None] * np.eye(n)
    right[..., n:] = defect[:, 1:]
    size = rows * n
    flat = right.reshape(count, size, n + columns)
    solved = np.linalg.solve(table.reshape(count, size, size), flat)
    return solved.reshape(count, rows, n, n + columns)
