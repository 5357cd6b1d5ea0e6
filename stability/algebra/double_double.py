"""Arrays of numbers of two doubles each, with a bound on how far each is from the exact result.

A number is hi + lo with |lo| at most half a unit in the last place of hi: about 106 bits.  Sums
and products of doubles are split exactly (T. J. Dekker, Numer. Math. 18 (1971) 224-242).  With
u = 2⁻⁵³ a sum errs by at most 12 u² times the sizes of its terms, a product by at most 8 u² times
its size (M. Joldes, J.-M. Muller and V. Popescu, ACM Trans. Math. Softw. 44 (2017) 15), beyond
2⁻¹⁰⁶⁰ for all underflows; `ROUNDING` and `LOST` are larger.  Quotients and roots are judged by
their residual, sines by Taylor's remainder.  Other functions are taken from balls, one by one.

A number with a wide bound is a ball: its image then encloses the function over all of the ball.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from fractions import Fraction
from functools import lru_cache
from typing import Any

import numpy as np
from flint import arb, fmpq

from .kernels.pairs import halves, left_over, two_sum
from .number_types import MORE, UNARY, Algebra, balls, precision, upper

ROUNDING = 2.0**-101
"""Relative error of a sum, to the sizes of its terms, and of a product."""
LOST = 2.0**-1050
"""Largest loss by underflows."""
ROOM = 1.01
"""Factor for the roundings of a bound itself."""
BITS = 160
"""Precision of functions that are taken from balls."""
TURNS = 2.0**20
"""Largest number of quarter turns of an angle whose sine is not taken from balls."""
TERMS = 15
"""Terms of Taylor's series of a sine or cosine."""
REMAINDER = 2.0**-114
"""Largest remainder of these series for |x| ≤ 0.79."""
HEAD = 8
"""Terms before those that need no more than a double: these are below 2⁻⁴⁴ z⁸, z < 0.63."""
NARROW = 2.0**-20
"""Largest error of such an angle."""
HARMONICS = 4096
"""Largest multiple of an angle whose sine follows from those of smaller ones."""


class DoubleDouble:
    """Numbers hi + lo within an error, arrays of one shape or plain numbers.

    Examples
    --------
    >>> third = DoubleDouble(1.0) / 3
    >>> float(third.hi), bool(0 < third.lo < 2e-17), bool(third.error < 1e-29)
    (0.3333333333333333, True, True)
    """

    __slots__ = ("_parts", "_size", "error", "hi", "lo", "multiple", "waves")
    __array_ufunc__ = None

    def __init__(self, hi: Any, lo: Any = 0.0, error: Any = 0.0) -> None:
        self.hi, self.lo, self.error = hi, lo, error
        self._size: Any = None
        self._parts: Any = None
        self.waves: dict[int, tuple[DoubleDouble, DoubleDouble]] = {}
        """Sine and cosine of its multiples, where these were asked for."""
        self.multiple: tuple[DoubleDouble, int] | None = None
        """An angle and a whole number of which this is the product."""

    @property
    def size(self) -> Any:
        """|hi|."""
        if self._size is None:
            self._size = np.abs(self.hi)
        return self._size

    @property
    def most(self) -> Any:
        """A bound on the size."""
        return ROOM * (self.size + self.error)

    @property
    def least(self) -> Any:
        """A bound on the size from below."""
        return np.maximum(self.size - ROOM * self.error, 0.0) / ROOM

    @property
    def parts(self) -> Any:
        """Hi in two halves."""
        if self._parts is None:
            self._parts = halves(self.hi)
        return self._parts

    @property
    def constant(self) -> bool:
        """Whether it is one double, exactly."""
        return type(self.hi) is np.float64 and not self.lo and not self.error

    def __add__(self, other: Any) -> DoubleDouble:
        o = exact(other)
        if o is self:
            return self * 2
        if o.constant or self.constant:
            return self._moved(o) if o.constant else o._moved(self)
        total, rest = two_sum(self.hi, o.hi)
        rest = rest + (self.lo + o.lo)
        hi = total + rest
        error = self.error + o.error + ROUNDING * (self.size + o.size)
        return DoubleDouble(hi, rest - (hi - total), error)

    __radd__ = __add__

    def _moved(self, constant: DoubleDouble) -> DoubleDouble:
        """The sum with a constant."""
        total = self.hi + constant.hi
        turn = total - self.hi
        rest = (self.hi - (total - turn)) + (constant.hi - turn) + self.lo
        hi = total + rest
        error = self.error + ROUNDING * (self.size + constant.size)
        return DoubleDouble(hi, rest - (hi - total), error)

    def __neg__(self) -> DoubleDouble:
        return DoubleDouble(-self.hi, -self.lo, self.error)

    def __sub__(self, other: Any) -> DoubleDouble:
        return self + -exact(other)

    def __rsub__(self, other: Any) -> DoubleDouble:
        return exact(other) + -self

    def __mul__(self, other: Any) -> DoubleDouble:
        o = exact(other)
        if o.constant or self.constant:
            return self._scaled(o) if o.constant else o._scaled(self)
        total = self.hi * o.hi
        rest = left_over(total, *self.parts, *o.parts) + (self.hi * o.lo + self.lo * o.hi)
        hi = total + rest
        passed = self.size * o.error + (o.size + o.error) * self.error
        return DoubleDouble(hi, rest - (hi - total), passed + (ROUNDING * np.abs(total) + LOST))

    __rmul__ = __mul__

    def _scaled(self, constant: DoubleDouble) -> DoubleDouble:
        """The product with a constant."""
        factor = constant.hi
        total = self.hi * factor
        (a, b), (c, d) = self.parts, constant.parts
        rest = (a * c - total) + a * d + b * c + b * d if d else (a * c - total) + b * c
        rest = rest + self.lo * factor
        hi = total + rest
        passed = constant.size * self.error
        product = DoubleDouble(hi, rest - (hi - total), passed + (ROUNDING * np.abs(total) + LOST))
        if abs(factor) <= HARMONICS and factor == (whole := int(factor)):
            base, times = self.multiple or (self, 1)
            product.multiple = (base, times * whole)
        return product

    def __truediv__(self, other: Any) -> DoubleDouble:
        o = exact(other)
        first = DoubleDouble(self.hi / o.hi)
        rest = self - first * o
        second = rest.hi / o.hi
        hi = first.hi + second
        quotient = DoubleDouble(hi, second - (hi - first.hi))
        quotient.error = (self - quotient * o).most / o.least
        return quotient

    def __rtruediv__(self, other: Any) -> DoubleDouble:
        return exact(other) / self

    def sqrt(self) -> DoubleDouble:
        """The root; its error is no number where the number may be negative."""
        first = np.sqrt(self.hi)
        second = (self - DoubleDouble(first) * DoubleDouble(first)).hi / (2 * first)
        hi = first + second
        root = DoubleDouble(hi, second - (hi - first))
        sound = self.hi - ROOM * self.error >= 0
        root.error = (self - root * root).most / np.where(sound, hi, np.nan)
        return root

    @staticmethod
    def pi() -> DoubleDouble:
        """π, by the name that balls have for it."""
        return QUARTER * 2

    def sign(self) -> Any:
        """Proved signs, 0 where open."""
        bound = ROOM * self.error + LOST
        return np.where(self.hi > bound, 1, 0) - np.where(self.hi < -bound, 1, 0)


def exact(number: Any) -> DoubleDouble:
    """A number as one of two doubles: a double or a short whole number exactly.

    Parameters
    ----------
    number
        A number, or an array of doubles.

    Examples
    --------
    >>> float(exact(2**70 + 1).lo)
    1.0
    """
    if isinstance(number, DoubleDouble):
        return number
    if isinstance(number, (int, Fraction, fmpq)) and not isinstance(number, bool):
        ratio = Fraction(int(number.p), int(number.q)) if isinstance(number, fmpq) else number
        return _ratio(Fraction(ratio))
    return DoubleDouble(np.float64(number) if np.ndim(number) == 0 else number)


@lru_cache(maxsize=1024)
def _ratio(number: Fraction) -> DoubleDouble:
    hi = float(number)
    lo = float(number - Fraction(hi))
    rest = abs(number - Fraction(hi) - Fraction(lo))
    return DoubleDouble(np.float64(hi), np.float64(lo), float(rest) * ROOM)


def _from_balls(name: str) -> Callable[..., DoubleDouble]:
    """A function that balls have, number by number."""

    def by_balls(*arguments: Any) -> DoubleDouble:
        numbers = [exact(v) for v in arguments]
        parts = np.broadcast_arrays(*(w for v in numbers for w in (v.hi, v.lo, v.error)))
        rows = np.array([v.ravel() for v in parts]).T
        different, place = np.unique(rows, axis=0, return_inverse=True)
        function, values = balls().functions[name], []
        with precision(BITS):
            for row in different.tolist():
                inputs = [
                    arb(row[i]) + row[i + 1] + arb(0, ROOM * row[i + 2])
                    for i in range(0, len(row), 3)
                ]
                value = function(*inputs)
                hi = float(value.mid())
                lo = float((value - hi).mid()) if math.isfinite(hi) else math.nan
                values.append((hi, lo, upper(value - hi - lo) if math.isfinite(lo) else math.nan))
        shape = parts[0].shape
        return DoubleDouble(*(v[place.ravel()].reshape(shape) for v in np.array(values).T))

    return by_balls


def _wave(shift: int) -> Callable[[Any], DoubleDouble]:
    """The sine (shift 0) or cosine (1): by Taylor's series after quarter turns, or by balls."""
    by_balls = _from_balls("cos" if shift else "sin")

    def wave(number: Any) -> DoubleDouble:
        x = exact(number)
        base, times = x.multiple or (x, 1)
        if not 1 <= times <= HARMONICS or not _first_waves(base):
            base, times = x, 1
            if not _first_waves(x):
                return by_balls(x)
        return _harmonic(base, times)[shift]

    return wave


def _first_waves(x: DoubleDouble) -> bool:
    """Whether sine and cosine follow from Taylor's series; they are then known."""
    if 1 not in x.waves:  # a graph asks for both, and often
        turns = np.rint(x.hi / QUARTER.hi)
        near = (np.abs(turns) <= TURNS) & (x.error <= NARROW)
        if not np.all(near | ~np.isfinite(x.hi + x.error)):
            return False
        x.waves[1] = _waves(x - QUARTER * turns, turns)
    return True


def _harmonic(x: DoubleDouble, times: int) -> tuple[DoubleDouble, DoubleDouble]:
    """Sine and cosine of a multiple, by the theorem of addition."""
    if times not in x.waves:
        (s, c), (t, d) = _harmonic(x, times // 2), _harmonic(x, times - times // 2)
        x.waves[times] = s * d + c * t, c * d - s * t
    return x.waves[times]


def _waves(y: DoubleDouble, turns: Any) -> tuple[DoubleDouble, DoubleDouble]:
    """Sine and cosine of y and some quarter turns, |y| ≤ 0.79."""
    z = y * y
    both = _taylor(z, SINE) * y, _taylor(z, COSINE)
    waves = []
    for shift in (0, 1):
        odd = (turns + shift) % 2 == 1
        sign = np.where((turns + shift) % 4 >= 2, -1.0, 1.0)
        hi, lo, error = (
            np.where(odd, *(getattr(v, n) for v in reversed(both))) for n in ("hi", "lo", "error")
        )
        waves.append(DoubleDouble(sign * hi, sign * lo, error + REMAINDER))
    return waves[0], waves[1]


def _taylor(z: DoubleDouble, terms: list[DoubleDouble]) -> DoubleDouble:
    """A series by powers of z, its last terms in doubles."""
    rest = 0.0
    for c in reversed(terms[HEAD:]):
        rest = rest * z.hi + c.hi
    value = DoubleDouble(rest, 0.0, 2.0**-44 * (z.error + 2.0**-52))
    for c in reversed(terms[:HEAD]):
        value = value * z + c
    return value


SINE, COSINE = (
    [_ratio(Fraction((-1) ** k, math.factorial(2 * k + first))) for k in range(TERMS)]
    for first in (1, 0)
)
"""Taylor's coefficients of sin(y)/y and cos(y) by squares of y."""


def _quarter() -> DoubleDouble:
    with precision(BITS):
        exact = arb.pi() / 2
        hi = float(exact.mid())
        lo = float((exact - hi).mid())
        return DoubleDouble(np.float64(hi), np.float64(lo), upper(exact - hi - lo))


QUARTER = _quarter()
"""π/2."""


def _power(x: Any, y: Any) -> DoubleDouble:
    """A power; a whole one is a product."""
    exponent = exact(y)
    if np.ndim(exponent.hi) == 0 and exponent.lo == 0 == exponent.error:
        whole = int(exponent.hi)
        if whole == exponent.hi and abs(whole) <= MOST_FACTORS:
            value, number = DoubleDouble(np.float64(1.0)), exact(x)
            for _ in range(abs(whole)):
                value = value * number
            return value if whole >= 0 else 1 / value
    return BY_BALLS["pow"](x, exponent)


def _size(x: Any) -> DoubleDouble:
    x = exact(x)
    sign = np.where(x.hi < 0, -1.0, 1.0)
    return DoubleDouble(sign * x.hi, sign * x.lo, x.error)


MOST_FACTORS = 16
"""Largest whole exponent that is a product."""
BY_BALLS = {name: _from_balls(name) for name in (*UNARY, *MORE, "pow", "atan2")}
DOUBLE_DOUBLE = Algebra(
    "double-double",
    lambda constant: DoubleDouble(np.float64(constant)),
    BY_BALLS
    | {
        "sin": _wave(0),
        "cos": _wave(1),
        "tan": lambda x: _wave(0)(x) / _wave(1)(x),
        "sqrt": lambda x: exact(x).sqrt(),
        "pow": _power,
        "fabs": _size,
    },
)
"""The algebra of these numbers."""
