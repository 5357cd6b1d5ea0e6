"""Sums and products of doubles without an error, and polynomials in pairs of doubles.

For arrays and in compiled loops; `stability.algebra.double_double` builds numbers of them.
"""

from __future__ import annotations

from typing import Any

DOUBLED = 2.0**-90
"""Relative error of a value, to the sum of the sizes of its terms."""


def two_sum(x: Any, y: Any) -> Any:
    """Sum and its rounding error (Knuth)."""
    s = x + y
    t = s - x
    return s, (x - (s - t)) + (y - t)


def halves(x: Any) -> Any:
    """A number below 1e290 as a sum of two with at most 26 bits."""
    wide = 134217729.0 * x
    high = wide - (wide - x)
    return high, x - high


def left_over(p: Any, a: Any, b: Any, c: Any, d: Any) -> Any:
    """The rounding error of a product p of two numbers with halves a, b and c, d (Dekker)."""
    return ((a * c - p) + a * d + b * c) + b * d


def two_product(x: Any, y: Any) -> Any:
    """Product and its rounding error."""
    p = x * y
    a, b = halves(x)
    c, d = halves(y)
    return p, left_over(p, a, b, c, d)


def step(high: Any, low: Any, x: Any, rest: Any, more: Any, less: Any) -> Any:
    """A pair times another one plus a third: each step is right to 2⁻¹⁰⁰ of the terms' sizes."""
    p, q = two_product(high, x)
    q = q + (high * rest + low * x)
    s, r = two_sum(p, more)
    r = r + (q + less)
    both = s + r
    return both, r - (both - s)


def doubled(high: Any, rest: Any, x: Any, dx: Any) -> Any:
    """Value of a polynomial as a pair of doubles, and the sum of the sizes of its terms.

    Parameters
    ----------
    high, rest
        Coefficients by powers, and what rounding to doubles left of them.
    x, dx
        Number as a pair.
    """
    upper, lower, size = 0.0 * x, 0.0 * x, 0.0 * x
    for i in range(len(high) - 1, -1, -1):
        upper, lower = step(upper, lower, x, dx, high[i], rest[i])
        size = size * abs(x) + abs(high[i])
    return upper, lower, size
