"""Numbers of the body oracles: floats or mpmath's, and jets that carry two derivatives.

A vector is a NumPy array, of doubles or of mpmath numbers (dtype object).  The functions below read
the type from their argument, so one formula serves both.  A `Jet` holds a value with its first and
second partial derivatives in two variables: geometry is written once, and differentiated exactly.

An array stands left of a number: mpmath would try to read what stands right of its own, as text.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import mpmath as mp
import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]
EYE, UP = np.eye(3, dtype=int), np.array([0, 0, 1])


@dataclass(frozen=True)
class Jet:
    """A value and its partial derivatives up to the second order in x and y."""

    v: Any
    x: Any = 0
    y: Any = 0
    xx: Any = 0
    xy: Any = 0
    yy: Any = 0

    def through(self, f: Any, d: Any, dd: Any) -> Jet:
        """A function of this jet, from its value and two derivatives."""
        return Jet(
            f,
            d * self.x,
            d * self.y,
            d * self.xx + dd * self.x * self.x,
            d * self.xy + dd * self.x * self.y,
            d * self.yy + dd * self.y * self.y,
        )

    def __add__(self, other: Any) -> Jet:
        b = other if isinstance(other, Jet) else Jet(other)
        return Jet(
            self.v + b.v, self.x + b.x, self.y + b.y, self.xx + b.xx, self.xy + b.xy, self.yy + b.yy
        )

    def __mul__(self, other: Any) -> Jet:
        if not isinstance(other, Jet):
            return self.through(self.v * other, other, 0)
        a, b = self, other
        return Jet(
            a.v * b.v,
            a.x * b.v + a.v * b.x,
            a.y * b.v + a.v * b.y,
            a.xx * b.v + 2 * a.x * b.x + a.v * b.xx,
            a.xy * b.v + a.x * b.y + a.y * b.x + a.v * b.xy,
            a.yy * b.v + 2 * a.y * b.y + a.v * b.yy,
        )

    __radd__, __rmul__ = __add__, __mul__

    def __neg__(self) -> Jet:
        return self * -1

    def __sub__(self, other: Any) -> Jet:
        return self + (-other)

    def __rsub__(self, other: Any) -> Jet:
        return -self + other

    def __pow__(self, p: Any) -> Jet:
        # at a value of zero a negative power would fail where its factor is zero
        first = p * self.v ** (p - 1) if p else 0
        second = p * (p - 1) * self.v ** (p - 2) if p not in (0, 1) else 0
        return self.through(self.v**p, first, second)

    def __truediv__(self, other: Any) -> Jet:
        return self * (other**-1 if isinstance(other, Jet) else 1 / other)

    def __rtruediv__(self, other: Any) -> Jet:
        return self**-1 * other


def _mp(value: Any) -> bool:
    return isinstance(value, mp.mpf | mp.mpc)


def sqrt(value: Any) -> Any:
    """Square root of a float, an mpmath number or a jet."""
    if isinstance(value, Jet):
        root = sqrt(value.v)
        return value.through(root, 1 / (2 * root), -1 / (4 * root * value.v))
    return mp.sqrt(value) if _mp(value) else math.sqrt(value)


def sin(value: Any) -> Any:
    """Sine of a float, an mpmath number or a jet."""
    if isinstance(value, Jet):
        return value.through(sin(value.v), cos(value.v), -sin(value.v))
    return mp.sin(value) if _mp(value) else math.sin(value)


def cos(value: Any) -> Any:
    """Cosine of a float, an mpmath number or a jet."""
    if isinstance(value, Jet):
        return value.through(cos(value.v), -sin(value.v), -cos(value.v))
    return mp.cos(value) if _mp(value) else math.cos(value)


def atan2(y: Any, x: Any) -> Any:
    """Angle of the point (x, y), floats or mpmath numbers."""
    return mp.atan2(y, x) if _mp(y) or _mp(x) else math.atan2(y, x)


def half_turns(u: Any) -> Any:
    """The angle pi u, with pi in the precision of u."""
    return u * (mp.pi if _mp(u.v if isinstance(u, Jet) else u) else math.pi)


def like(value: Any, u: Any) -> Any:
    """A constant as a number of the type of u, so that functions of it have its precision."""
    return mp.mpf(value) if _mp(u.v if isinstance(u, Jet) else u) else value


def vector(*entries: Any) -> Array:
    """An array of doubles, or of mpmath numbers where an entry is one."""
    if any(_mp(e) for e in entries):
        return np.array([mp.mpf(e) for e in entries], dtype=object)
    return np.array(entries, dtype=float)


def precise(values: Sequence[Any] | Array) -> Array:
    """The exact values of doubles as mpmath numbers."""
    return np.array([mp.mpf(v) for v in values], dtype=object)


def plain(values: Any) -> Array:
    """The nearest doubles."""
    return np.asarray(values).astype(float)


def epsilon(values: Array) -> float:
    """Rounding unit of the numbers in an array."""
    return float(mp.eps) if values.dtype == object else float(np.finfo(float).eps)


def norm(values: Array) -> Any:
    """Euclidean length."""
    return sqrt(values @ values)


def cross(a: Array, b: Array) -> Array:
    """Vector product of two triples."""
    return np.array(
        [
            a[1] * b[2] - a[2] * b[1],
            a[2] * b[0] - a[0] * b[2],
            a[0] * b[1] - a[1] * b[0],
        ]
    )


def crossing(a: Array) -> Array:
    """Matrix of the map b -> a x b."""
    zero = a[0] * 0
    return np.array([[zero, -a[2], a[1]], [a[2], zero, -a[0]], [-a[1], a[0], zero]])


def solve(matrix: Array, right: Array) -> Array:
    """Solution of linear equations; `right` a vector or a matrix of columns."""
    if matrix.dtype != object and right.dtype != object:
        return np.linalg.solve(matrix, right)
    size, both = len(matrix), np.hstack([matrix, right.reshape(len(right), -1)])
    rows = [[mp.mpmathify(e) for e in row] for row in both.tolist()]
    for k in range(size):  # elimination in lists of numbers: mp.lu_solve takes three times as long
        pivot = max(range(k, size), key=lambda i: abs(rows[i][k]))
        rows[k], rows[pivot] = rows[pivot], rows[k]
        row = rows[k] = [e / rows[k][k] for e in rows[k]]
        for i in range(size):
            if i != k and (factor := rows[i][k]):
                rows[i] = [
                    e - factor * top if top else e for e, top in zip(rows[i], row, strict=True)
                ]
    return np.array([row[size:] for row in rows], dtype=object).reshape(right.shape)


def newton(residual: Callable[[Array], tuple[Array, Array]], start: Array) -> Array:
    """Newton's method, until the step is below the root of the rounding unit, and once more."""
    x, last = start, False
    for _ in range(60):
        value, slope = residual(x)
        step = solve(slope, -value)
        x = x + step
        if last:
            return x
        last = float(norm(step)) <= math.sqrt(epsilon(x)) * float(norm(x))
    raise ArithmeticError("Newton's method does not converge")
