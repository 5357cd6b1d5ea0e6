"""Arrays of intervals: a graph over many boxes at once, forwards and backwards.

A number is a pair of arrays (lo, hi).  Ends are rounded outwards: by one unit in the last place for
+ - * / and roots, by `LOOSE` for other functions, whose values NumPy gives within a few units.
A function with a limited domain is read on the part of its argument inside it, so that a box in
which zero is excluded has no zero at which the graph has a value.

A `Tape` records the operations.  `narrowed` then goes back from what is known of the results, and
takes from each operand what no result allows (hull consistency; F. Benhamou et al., Revising hull
and box consistency, ICLP 1999, 230-244).

Slopes over a box, from the graph of the derivatives, hold for each pair of points of it at which
the graph has a value, since each function's domain is an interval.  They do not where a function
has a pole or a jump between two parts of its domain; there a tape is `broken`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from .number_types import BY_OTHERS, Algebra

LOOSE = 2.0**-49
"""Relative width that is added to values of functions."""
TINY = 2.0**-1070
"""What is added to them beyond this, for underflows."""
LARGEST = 2.0**1023
MOST_POWER = 1000
"""Largest whole exponent that is read as one."""
MOST_TURNS = 1e6
"""Largest angle whose sine is narrower than [-1, 1]."""

Pair = tuple[Any, Any]


def _outward(lo: Any, hi: Any) -> Pair:
    return np.nextafter(lo, -np.inf), np.nextafter(hi, np.inf)


def _loose(lo: Any, hi: Any) -> Pair:
    """Ends outside those that a function of NumPy gave."""
    lo, hi = np.minimum(lo, LARGEST), np.maximum(hi, -LARGEST)
    return lo - (np.abs(lo) * LOOSE + TINY), hi + (np.abs(hi) * LOOSE + TINY)


def plus(a: Pair, b: Pair) -> Pair:
    """Sum of intervals; that of two numbers is a number where it is exact, as n - 1 in a slope."""
    total = a[0] + b[0]
    if a[0] is a[1] and b[0] is b[1] and np.ndim(total) == 0:
        turn = total - a[0]
        if (a[0] - (total - turn)) + (b[0] - turn) == 0:
            return total, total
    return _outward(total, a[1] + b[1])


def minus(a: Pair, b: Pair) -> Pair:
    """Difference of intervals."""
    low = -b[1]
    return plus(a, (low, low if b[0] is b[1] else -b[0]))


def times(a: Pair, b: Pair) -> Pair:
    """Product of intervals; zero times infinity is zero."""
    (a_lo, a_hi), (b_lo, b_hi) = a, b
    if a_lo is a_hi:  # a number
        (a_lo, a_hi), (b_lo, b_hi) = b, a
    if b_lo is b_hi:
        first, second = a_lo * b_lo, a_hi * b_lo
        lo, hi = np.minimum(first, second), np.maximum(first, second)
    else:
        ends = a_lo * b_lo, a_lo * b_hi, a_hi * b_lo, a_hi * b_hi
        lo = np.minimum(np.minimum(ends[0], ends[1]), np.minimum(ends[2], ends[3]))
        hi = np.maximum(np.maximum(ends[0], ends[1]), np.maximum(ends[2], ends[3]))
    total = lo.sum()
    if total != total:  # zero times infinity, or no number
        valid = ~(np.isnan(a_lo) | np.isnan(b_lo))
        fixed = [
            np.where(np.isnan(v) & valid, 0.0, v)
            for v in (a_lo * b_lo, a_lo * b_hi, a_hi * b_lo, a_hi * b_hi)
        ]
        lo = np.minimum(np.minimum(fixed[0], fixed[1]), np.minimum(fixed[2], fixed[3]))
        hi = np.maximum(np.maximum(fixed[0], fixed[1]), np.maximum(fixed[2], fixed[3]))
    return _outward(lo, hi)


def inverse(b: Pair) -> Pair:
    """1/b; the whole line where zero is inside b."""
    lo, hi = _outward(1.0 / b[1], 1.0 / b[0])
    low, high = b[0] <= 0, b[1] >= 0
    return np.where(low & (b[1] >= 0) & ((b[0] < 0) | (b[1] == 0)), -np.inf, lo), np.where(
        high & (b[0] <= 0) & ((b[1] > 0) | (b[0] == 0)), np.inf, hi
    )


def over(a: Pair, b: Pair) -> Pair:
    """Quotient of intervals."""
    return times(a, inverse(b))


def square(a: Pair) -> Pair:
    """Square of an interval."""
    least, most = _sizes(a)
    lo, hi = _outward(least * least, most * most)
    return np.maximum(lo, 0.0), hi


def _sizes(a: Pair) -> Pair:
    """Least and largest modulus."""
    return np.maximum(np.maximum(a[0], -a[1]), 0.0), np.maximum(np.abs(a[0]), np.abs(a[1]))


def part_of(x: Pair, numerator: Pair, denominator: Pair) -> Pair:
    """The hull of what x has in common with a quotient whose denominator may be zero."""
    (lo, hi), (n, m), (d, e) = x, numerator, denominator
    q = over(numerator, denominator)
    zero = (d <= 0) & (e >= 0)
    if not np.any(zero):
        return np.fmax(lo, q[0]), np.fmin(hi, q[1])
    nonzero = (n > 0) | (m < 0)
    free = zero & ~nonzero
    lo, hi = np.where(free, lo, np.fmax(lo, q[0])), np.where(free, hi, np.fmin(hi, q[1]))
    # two half-lines with a gap between them, where the numerator is not zero
    gap = zero & nonzero
    if np.any(gap):
        near: Any = np.where(n > 0, n, m)
        left: Any = np.where(n > 0, d, e)
        right: Any = np.where(n > 0, e, d)
        below: Any = np.where(left == 0, -np.inf, np.nextafter(near / left, np.inf))
        above: Any = np.where(right == 0, np.inf, np.nextafter(near / right, -np.inf))
        lo, hi = _without(lo, hi, below, above, gap)
    return lo, hi


def _without(lo: Any, hi: Any, below: Any, above: Any, where: Any = True) -> Pair:
    """An interval without what lies between two numbers."""
    first = np.where(where & (lo > below), np.fmax(lo, above), lo)
    last = np.where(where & (hi < above), np.fmin(hi, below), hi)
    return first, last


# --- the number type ---


@dataclass
class Tape:
    """Operations in order, each with what it takes back from its result to its operands."""

    steps: list[tuple[Interval, Callable[[Interval], None]]] = field(default_factory=list)
    recording: bool = True
    """Whether operations are kept; marks are set in any case."""
    void: Any = False
    """Where a function has no value for any number of the box, or narrowing leaves nothing."""
    part: Any = False
    """Where a function may lack a value for a number of the box."""
    broken: Any = False
    """Where a function may have a pole or a jump inside the box."""

    def narrowed(self) -> None:
        """Take from each operand what its result excludes."""
        for result, back in reversed(self.steps):
            back(result)
            self.void = self.void | (result.lo > result.hi)


class Interval:
    """Arrays of intervals.

    Parameters
    ----------
    lo, hi
        Ends, arrays or numbers.
    tape
        Where operations are recorded; None for constants, and where nobody goes back.

    Examples
    --------
    >>> x = Interval(np.array([-1.0]), np.array([2.0]))
    >>> y = x * x
    >>> y.lo.tolist(), y.hi.round(9).tolist()
    ([0.0], [4.0])
    """

    __slots__ = ("hi", "lo", "tape")
    __array_ufunc__ = None

    def __init__(self, lo: Any, hi: Any, tape: Tape | None = None) -> None:
        self.lo, self.hi, self.tape = lo, hi, tape

    @property
    def pair(self) -> Pair:
        """Both ends."""
        return self.lo, self.hi

    def meet(self, pair: Pair) -> None:
        """Keep what lies in another interval too; an end that is no number says nothing."""
        self.lo, self.hi = np.fmax(self.lo, pair[0]), np.fmin(self.hi, pair[1])

    def made(self, pair: Pair, back: Callable[[Interval], None], other: Any = None) -> Interval:
        """A result, recorded where an operand is."""
        tape = self.tape if self.tape is not None else getattr(other, "tape", None)
        result = Interval(*pair, tape)
        if tape is not None and tape.recording:
            tape.steps.append((result, back))
        return result

    def _breaks(self, where: Any, other: Any = None) -> None:
        tape = self.tape if self.tape is not None else getattr(other, "tape", None)
        if tape is not None and np.any(where):
            tape.broken = tape.broken | where

    def __add__(self, other: Any) -> Interval:
        o = interval(other)
        if self.tape is None and o.tape is not None:
            return o + self

        def back(r: Interval) -> None:
            self.meet(minus(r.pair, o.pair))
            if o.tape is not None:
                o.meet(minus(r.pair, self.pair))

        return self.made(plus(self.pair, o.pair), back, o)

    __radd__ = __add__

    def __sub__(self, other: Any) -> Interval:
        o = interval(other)

        def back(r: Interval) -> None:
            if self.tape is not None:
                self.meet(plus(r.pair, o.pair))
            if o.tape is not None:
                o.meet(minus(self.pair, r.pair))

        return self.made(minus(self.pair, o.pair), back, o)

    def __rsub__(self, other: Any) -> Interval:
        return interval(other) - self

    def __neg__(self) -> Interval:
        return self.made((-self.hi, -self.lo), lambda r: self.meet((-r.hi, -r.lo)))

    def __mul__(self, other: Any) -> Interval:
        same = other is self
        if same:
            return self.made(square(self.pair), lambda r: self.even(_root(r.pair)))
        o = interval(other)
        if self.tape is None and o.tape is not None:
            return o * self

        def back(r: Interval) -> None:
            self.meet(part_of(self.pair, r.pair, o.pair))
            if o.tape is not None:
                o.meet(part_of(o.pair, r.pair, self.pair))

        return self.made(times(self.pair, o.pair), back, o)

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Interval:
        o = interval(other)

        def back(r: Interval) -> None:
            if self.tape is not None:
                self.meet(times(r.pair, o.pair))
            if o.tape is not None:
                o.meet(part_of(o.pair, self.pair, r.pair))

        if o.tape is not None:
            o._breaks((o.lo < 0) & (o.hi > 0))
        return self.made(over(self.pair, o.pair), back, o)

    def __rtruediv__(self, other: Any) -> Interval:
        return interval(other) / self

    def even(self, sizes: Pair) -> None:
        """Keep what has its modulus between two numbers."""
        least = np.where(np.isnan(sizes[0]), 0.0, np.maximum(sizes[0], 0.0))
        self.meet(_without(*self.pair, -least, least))
        self.meet((-sizes[1], sizes[1]))

    def within(self, low: float, high: float) -> Pair:
        """The part inside a function's domain; `void` is set where there is none."""
        if self.tape is not None:
            self.tape.void = self.tape.void | (self.hi < low) | (self.lo > high)
            self.tape.part = self.tape.part | (self.lo < low) | (self.hi > high)
        return np.clip(self.lo, low, high), np.clip(self.hi, low, high)


def interval(number: Any) -> Interval:
    """A number as an interval."""
    if isinstance(number, Interval):
        return number
    exact = np.float64(number)
    return Interval(exact, exact)


def _nothing(_: Interval) -> None:
    """Take nothing back."""


def _root(a: Pair) -> Pair:
    lo, hi = _outward(np.sqrt(np.maximum(a[0], 0.0)), np.sqrt(np.maximum(a[1], 0.0)))
    return np.maximum(lo, 0.0), hi


RIGHT = np.pi / 2
"""The double below π/2."""


def _rising(
    function: Any, undo: Any, domain: Pair = (-np.inf, np.inf), image: Pair = (-np.inf, np.inf)
) -> Any:
    """A function that rises on its domain, from its inverse; the image may be larger than it is."""

    def rising(x: Interval) -> Interval:
        lo, hi = x.within(*domain) if np.isfinite(domain).any() else x.pair
        lo, hi = _loose(function(lo), function(hi))
        pair = np.maximum(lo, image[0]), np.minimum(hi, image[1])

        def narrow(r: Interval) -> None:
            x.meet(domain)
            x.meet(_loose(*(undo(np.clip(v, *image)) for v in r.pair)))

        return x.made(pair, narrow)

    return rising


def _cosh(x: Interval) -> Interval:
    lo, hi = _loose(*(np.cosh(v) for v in _sizes(x.pair)))
    return x.made(
        (np.maximum(lo, 1.0), hi),
        lambda r: x.even(_loose(*(np.arccosh(np.maximum(v, 1.0)) for v in r.pair))),
    )


def _steep(v: Any) -> Any:
    """The tangent, infinite next to a right angle."""
    return np.where(np.abs(v) < 1.57, np.tan(v), np.copysign(np.inf, v))


def _next_phase(x: Any, least: Any, most: Any) -> Any:
    """The least number from x on whose cosine has its angle between two in [0, π]."""
    turn = 2 * np.pi
    base = turn * np.floor(x / turn)
    t = x - base
    t = np.where(t <= least, least, t)
    t = np.where((t > most) & (t < turn - most), turn - most, t)
    t = np.where(t > turn - least, turn + least, t)
    return base + t - 1e-14 * (1 + np.abs(base))


def _wave(shift: float) -> Any:
    """The cosine of x less a quarter turn (the sine), or of x itself."""

    def angles(x: Pair) -> Pair:
        room = 1e-15 * (1 + np.maximum(np.abs(x[0]), np.abs(x[1]))) * bool(shift)
        return x[0] - shift - room, x[1] - shift + room

    def wave(x: Interval) -> Interval:
        lo, hi = angles(x.pair)
        first, second = np.cos(lo), np.cos(hi)
        bent = 1e-15 * (1 + np.maximum(np.abs(lo), np.abs(hi)))
        least = np.minimum(first, second) - bent
        most = np.maximum(first, second) + bent
        turn = 2 * np.pi
        far = ~(np.maximum(np.abs(lo), np.abs(hi)) < MOST_TURNS)
        top = far | (np.floor((hi + bent) / turn) != np.floor((lo - bent) / turn))
        half = np.floor((hi + bent) / turn - 0.5) != np.floor((lo - bent) / turn - 0.5)
        pair = (
            np.where(far | half, -1.0, np.maximum(least, -1.0)),
            np.where(top, 1.0, np.minimum(most, 1.0)),
        )

        def narrow(r: Interval) -> None:
            lo, hi = angles(x.pair)
            near = np.maximum(np.abs(lo), np.abs(hi)) < MOST_TURNS
            a, b = np.clip(r.hi, -1.0, 1.0), np.clip(r.lo, -1.0, 1.0)
            least, most = np.maximum(np.arccos(a) - 1e-15, 0.0), np.arccos(b) + 1e-15
            room = 1e-14 * (1 + np.abs(shift))
            ends = (
                _next_phase(lo, least, most) + shift - room,
                -_next_phase(-hi, least, most) + shift + room,
            )
            x.meet((np.where(near, ends[0], -np.inf), np.where(near, ends[1], np.inf)))

        return x.made(pair, narrow)

    return wave


def _tan(x: Interval) -> Interval:
    same = np.floor(x.lo / np.pi + 0.5 - 1e-12) == np.floor(x.hi / np.pi + 0.5 + 1e-12)
    same &= np.maximum(np.abs(x.lo), np.abs(x.hi)) < 1e3
    room = 1e-15 * (1 + np.abs(x.lo) + np.abs(x.hi))
    lo, hi = _loose(np.tan(x.lo - room), np.tan(x.hi + room))
    x._breaks(~same)

    def after(number: Any, least: Any, most: Any) -> Any:
        base = np.pi * np.rint(number / np.pi)
        t = np.maximum(number - base, least)
        return base + np.where(t > most, least + np.pi, t) - 1e-14 * (1 + np.abs(base))

    def narrow(r: Interval) -> None:
        a, b = np.arctan(r.lo) - 1e-15, np.arctan(r.hi) + 1e-15
        near = np.maximum(np.abs(x.lo), np.abs(x.hi)) < MOST_TURNS
        ends = after(x.lo, a, b), -after(-x.hi, -b, -a)
        x.meet((np.where(near, ends[0], -np.inf), np.where(near, ends[1], np.inf)))

    return x.made((np.where(same, lo, -np.inf), np.where(same, hi, np.inf)), narrow)


def _acos(x: Interval) -> Interval:
    quarter = Interval(*_outward(np.pi / 2, np.pi / 2))
    angle: Interval = FUNCTIONS["asin"](x)
    return quarter - angle


def _fabs(x: Interval) -> Interval:
    return x.made(_sizes(x.pair), lambda r: x.even(r.pair))


def _sign(x: Interval) -> Interval:
    return Interval(np.where(x.lo > 0, 1.0, -1.0), np.where(x.hi < 0, -1.0, 1.0), x.tape)


def _angle(y: Interval, x: Interval) -> Interval:
    """The angle of (x, y), which jumps by a turn."""
    y._breaks((x.lo <= 0) & (y.lo <= 0) & (y.hi >= 0), x)
    result: Interval = BY_OTHERS["atan2"](FUNCTIONS, y, x)
    return result


def _power(x: Interval, y: Interval) -> Interval:
    single = np.size(y.lo) and np.all(y.lo == np.ravel(y.hi)[0]) and np.all(y.lo == y.hi)
    exponent = float(np.ravel(y.lo)[0]) if single else np.nan
    if exponent != np.round(exponent) or abs(exponent) > MOST_POWER:
        whole = np.floor(y.hi) >= np.ceil(y.lo)  # then a negative number may have a power
        unclear = whole & ~(x.lo > 0)
        x._breaks(unclear, y)
        if np.any(unclear):
            return x.made((np.full_like(x.lo * y.lo, -np.inf), x.lo * 0 + np.inf), _nothing, y)
        logarithm: Interval = FUNCTIONS["log"](x) * y
        power: Interval = FUNCTIONS["exp"](logarithm)
        return power
    if exponent < 0:
        return interval(1.0) / _power(x, -y)
    if exponent in (0.0, 1.0, 2.0):
        return [interval(1.0), x, x * x][int(exponent)]
    odd = exponent % 2 == 1
    ends = x.pair if odd else _sizes(x.pair)
    pair = _loose(*(np.power(v, exponent) for v in ends))

    def narrow(r: Interval) -> None:
        roots = _loose(*(np.sign(v) * np.abs(v) ** (1 / exponent) for v in r.pair))
        x.meet(roots) if odd else x.even(roots)

    return x.made(pair if odd else (np.maximum(pair[0], 0.0), pair[1]), narrow)


FUNCTIONS: dict[str, Callable[..., Any]] = {
    "sin": _wave(np.pi / 2),
    "cos": _wave(0.0),
    "tan": _tan,
    "sqrt": _rising(np.sqrt, np.square, (0.0, np.inf), (0.0, np.inf)),
    "exp": _rising(np.exp, np.log, image=(0.0, np.inf)),
    "log": _rising(np.log, np.exp, (0.0, np.inf)),
    "expm1": _rising(np.expm1, np.log1p, image=(-1.0, np.inf)),
    "log1p": _rising(np.log1p, np.expm1, (-1.0, np.inf)),
    "sinh": _rising(np.sinh, np.arcsinh),
    "cosh": _cosh,
    "tanh": _rising(np.tanh, np.arctanh, image=(-1.0, 1.0)),
    "asinh": _rising(np.arcsinh, np.sinh),
    "acosh": _rising(np.arccosh, np.cosh, (1.0, np.inf), (0.0, np.inf)),
    "atanh": _rising(np.arctanh, np.tanh, (-1.0, 1.0)),
    "asin": _rising(np.arcsin, lambda v: np.sin(np.clip(v, -RIGHT, RIGHT)), (-1.0, 1.0)),
    "atan": _rising(np.arctan, _steep),
    "acos": _acos,
    "fabs": _fabs,
    "sign": _sign,
    "atan2": _angle,
    "pow": _power,
}
INTERVALS = Algebra("intervals", interval, FUNCTIONS, lasting=False)
"""The algebra of these numbers."""
