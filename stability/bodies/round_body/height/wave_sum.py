"""A height as a sum of sines and cosines of multiples of θ, where its graph is one.

Such are a coin, a ring, an eccentric ball, a cylinder on its rim, and every series of a profile.
Each coefficient has a bound on its rounding error, and cosines of the same multiple cancel exactly:
the radius of curvature h + h'' of a disk is zero, not nearly zero.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ....algebra.number_types import Algebra
from ....algebra.program import Program
from ....base.errors import StabilityError
from ....base.types import Floats

U = 2.0**-52
MOST_TERMS = 4096
"""Most products of two terms in one product of sums."""
LARGEST, FINEST = 1e5, 1024
"""Largest multiple of θ, and the parts of one to which multiples are exact."""
Term = tuple[float, float, float]
"""Coefficients of the cosine and of the sine, and a bound on the errors of both."""


class NoSumError(StabilityError):
    """A height that is no sum of waves, as far as its graph shows."""


@dataclass(frozen=True, eq=False)
class Angle:
    """A multiple of θ."""

    times: float

    def __mul__(self, other: Any) -> Angle:
        return Angle(self.times * _constant(other))

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Angle:
        return Angle(self.times / _constant(other))

    def __neg__(self) -> Angle:
        return Angle(-self.times)

    def __add__(self, other: Any) -> Angle:
        if not isinstance(other, Angle):
            raise NoSumError("theta stands outside a sine or cosine of its multiples")
        return Angle(self.times + other.times)

    def __sub__(self, other: Any) -> Angle:
        negative: Angle = -other
        return self + negative


@dataclass(frozen=True, eq=False)
class WaveSum:
    """A sum over n of a cos nθ + b sin nθ."""

    terms: dict[float, Term]
    """Coefficients of each multiple n ≥ 0."""

    @staticmethod
    def of(value: Any) -> WaveSum:
        """A number as a sum of one term."""
        if isinstance(value, WaveSum):
            return value
        if isinstance(value, Angle):
            raise NoSumError("theta stands outside a sine or cosine of its multiples")
        return WaveSum({0.0: (float(value), 0.0, 0.0)})

    def __add__(self, other: Any) -> WaveSum:
        first, second = self.terms, WaveSum.of(other).terms
        if len(first) < len(second):
            first, second = second, first
        terms = dict(first)
        for n, (a, b, e) in second.items():
            if n in terms:
                c, d, f = terms[n]
                terms[n] = _term(a + c, b + d, e + f)
            else:
                terms[n] = a, b, e
        return WaveSum(terms)

    __radd__ = __add__

    def __neg__(self) -> WaveSum:
        return WaveSum({n: (-a, -b, e) for n, (a, b, e) in self.terms.items()})

    def __sub__(self, other: Any) -> WaveSum:
        return self + -WaveSum.of(other)

    def __rsub__(self, other: Any) -> WaveSum:
        return WaveSum.of(other) - self

    def __mul__(self, other: Any) -> WaveSum | Angle:
        if isinstance(other, Angle):
            return other * self
        second = WaveSum.of(other).terms
        if len(self.terms) * len(second) > MOST_TERMS:
            raise NoSumError("a product of long sums")
        product = WaveSum({})
        for n, (a, b, e) in self.terms.items():
            for m, (c, d, f) in second.items():
                size = (abs(a) + abs(b)) * f + (abs(c) + abs(d)) * e + 2 * e * f
                parts = {n + m: (a * c - b * d, a * d + b * c)}
                near = (a * c + b * d, (b * c - a * d) * (1 if n >= m else -1))
                if n == m:
                    near = near[0], 0.0
                for k, (p, q) in (*parts.items(), (abs(n - m), near)):
                    product += WaveSum(
                        {
                            k: _term(
                                p / 2,
                                q / 2,
                                size
                                + U * abs(a * c)
                                + U * abs(b * d)
                                + U * abs(a * d)
                                + U * abs(b * c),
                            )
                        }
                    )
        return product

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> WaveSum:
        below = _constant(other)
        if below == 0 or not math.isfinite(below):
            raise NoSumError("a quotient by zero")
        return WaveSum(
            {n: _term(a / below, b / below, e / abs(below)) for n, (a, b, e) in self.terms.items()}
        )

    def __rtruediv__(self, other: Any) -> WaveSum:
        return WaveSum.of(other) / self

    def values(self, theta: Floats, half: Floats) -> tuple[Floats, Floats]:
        """Balls of h, h', ρ = h + h'', ρ' and ρ'' on pieces of θ, shape (5, pieces) each.

        Parameters
        ----------
        theta, half
            Middles and half lengths of the pieces, shape (pieces,).
        """
        n = np.array(list(self.terms))
        a, b, e = np.array(list(self.terms.values())).reshape(-1, 3).T
        curve = (1 - n) * (1 + n)
        wave = np.outer(theta, n)
        cosine, sine = np.cos(wave), np.sin(wave)
        level, slope = cosine * a + sine * b, (cosine * b - sine * a) * n
        size = abs(a) + abs(b)
        # n θ is rounded, and so are sine, cosine, each product, and the sums
        error = 2 * e + size * U * (4 * n + len(n) + 16)
        rows: list[Floats] = []
        bounds: list[Floats] = []
        for part, weight in (
            (level, 1 + 0 * n),
            (slope, 1 + 0 * n),
            (level, curve),
            (slope, curve),
            (-level * n * n, curve),
        ):
            power = len(rows) - 2 * (len(rows) > 1)  # of n in this row
            rows.append(part @ weight)
            steep = abs(weight) * n**power
            bounds.append(steep @ error + half * ((steep * n) @ (size + error)))
        return np.array(rows), np.array(bounds) * (1 + 1e-12)


def _term(a: float, b: float, error: float) -> Term:
    return a, b, (error + U * max(abs(a), abs(b))) * (1 + U)


def _constant(value: Any) -> float:
    """A number that no θ is in; its rounding error is none."""
    if isinstance(value, Angle):
        raise NoSumError("theta stands outside a sine or cosine of its multiples")
    if not isinstance(value, WaveSum):
        return float(value)
    if set(value.terms) - {0.0} or value.terms.get(0.0, (0, 0, 0))[2]:
        raise NoSumError("a quotient or an argument is no plain number")
    return value.terms.get(0.0, (0.0, 0.0, 0.0))[0]


def _sine(x: Any) -> WaveSum:
    n = _multiple(x)
    return WaveSum({abs(n): (0.0, math.copysign(1.0, n) if n else 0.0, 0.0)})


def _cosine(x: Any) -> WaveSum:
    return WaveSum({abs(_multiple(x)): (1.0, 0.0, 0.0)})


def _multiple(x: Any) -> float:
    """A multiple of θ whose sums with others are exact."""
    if not isinstance(x, Angle) or abs(x.times) > LARGEST or x.times * FINEST % 1:
        raise NoSumError("a sine of a number, or of a multiple of theta with many digits")
    return x.times


def _power(x: Any, y: Any) -> WaveSum:
    times = _constant(y)
    if times not in (1.0, 2.0, 3.0, 4.0):
        raise NoSumError("a power")
    product = WaveSum.of(x)
    for _ in range(int(times) - 1):
        product = WaveSum.of(product * x)
    return product


_WAVES = Algebra("waves", WaveSum.of, {"sin": _sine, "cos": _cosine, "pow": _power})


def wave_sum(height: Program, shape: Sequence[float]) -> WaveSum | None:
    """The height as a sum of waves; None where its graph is none.

    Parameters
    ----------
    height
        The height as a function of θ and the numbers of the shape.
    shape
        These numbers.

    Examples
    --------
    >>> import casadi as ca
    >>> t, tube = ca.SX.sym("t"), ca.SX.sym("tube")
    >>> ring = Program(ca.Function("h", [t, tube], [ca.sin(t) + tube]))
    >>> wave_sum(ring, [0.25]).terms
    {1.0: (0.0, 1.0, 0.0), 0.0: (0.25, 0.0, 0.0)}
    """
    try:
        [[value]] = height.run(_WAVES, [[Angle(1.0)], *([WaveSum.of(v)] for v in shape)])
        return WaveSum.of(value)
    except (NoSumError, KeyError, TypeError):  # a function or an operation that makes no waves
        return None
