"""Real factors of a cubic, quartic or quintic: their corrections, and discs around their roots.

Formulas and proofs are those of `stability.algebra.real_factors`, for one cell instead of arrays.
Loops over cells call these functions, and the compiler turns them into vector instructions: there
are no branches, only choices between two computed values.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

INLINE = (
    "two_sum",
    "halves",
    "left_over",
    "two_product",
    "step",
    "larger",
    "smaller",
    "change_of",
    "_shifted",
    "_quadratic",
    "pair",
    "clear",
    "weight",
    "correct_cubic",
    "correct_quartic",
    "correct_quintic",
    "cubic_discs",
    "quartic_discs",
    "quintic_discs",
)
"""Functions, here and in `algebra.kernels.pairs`, that are written into the loops over cells."""
SIDE = 128
"""Cells of a block."""
U = np.uintp
"""Type of an index that cannot be negative, so that it needs no test."""

EPS = 2.0**-52
"""Relative distance of doubles."""


# lines of a page, in cells
PLACE = 0  # scaled numbers of x
UNIT = SIDE  # of the rate
LEAD, LEAD_ERROR = 2 * SIDE, 3 * SIDE
A = 4 * SIDE  # coefficients, up to five
E = 9 * SIDE  # their errors
F = 14 * SIDE  # factors
CHANGE = 19 * SIDE
REAL = 20 * SIDE  # of up to six roots
IMAG = 26 * SIDE
RADIUS = 32 * SIDE
TOP, ERROR, TURN, LARGEST, HIGH = 38 * SIDE, 39 * SIDE, 40 * SIDE, 41 * SIDE, 42 * SIDE
PAGE = 43 * SIDE


def larger(x: float, y: float) -> float:
    """The larger of two numbers; the second one where either is not a number."""
    return x if x > y else y


def smaller(x: float, y: float) -> float:
    """The smaller of two numbers; the second one where either is not a number."""
    return x if x < y else y


def change_of(dp: Any, dq: Any, p: Any, q: Any) -> Any:
    """Square of the change of x² + p x + q, relative to its roots."""
    return (dq / q) ** 2 + dp * dp / (abs(q) + p * p)


def correct_cubic(j: int, w: Any) -> None:
    """One correction of (x - r)(x² + p x + q), and the square of its change."""
    a, b, c = w[A + j], w[A + SIDE + j], w[A + 2 * SIDE + j]
    r, p, q = w[F + j], w[F + SIDE + j], w[F + 2 * SIDE + j]
    dr = -(((r + c) * r + b) * r + a) / ((r + p) * r + q)
    high = c - p
    alpha, beta = b - p * high - q, a - q * high
    m = -r - p
    det = q - r * m
    dp, dq = (-r * alpha - beta) / det, (m * beta + q * alpha) / det
    w[F + j], w[F + SIDE + j], w[F + 2 * SIDE + j] = r + dr, p + dp, q + dq
    w[CHANGE + j] = larger((dr / r) ** 2, change_of(dp, dq, p, q))


def _quadratic(
    a: Any, b: Any, c: Any, d: Any, e: Any, r: Any, p: Any, q: Any, u: Any, v: Any
) -> Any:
    """Change of x² + p x + q, next to x - r and x² + u x + v."""
    square = e - p
    linear = d - p * square - q
    constant = c - p * linear - q * square
    alpha, beta = b - p * constant - q * linear, a - q * constant
    s, f = u - p, v - q
    return _shifted(alpha, beta, f - s * (r + p), -r * f - s * q, p, q)


def _shifted(alpha: Any, beta: Any, gamma: Any, delta: Any, p: Any, q: Any) -> Any:
    """Change of x² + p x + q, modulo which the polynomial is αx + β, the other factors γx + δ."""
    m = delta - gamma * p
    det = delta * m + gamma * gamma * q
    dp, dq = (alpha * delta - beta * gamma) / det, (m * beta + gamma * q * alpha) / det
    return dp, dq, change_of(dp, dq, p, q)


def correct_quartic(j: int, w: Any) -> None:
    """The same for (x² + p x + q)(x² + u x + v)."""
    a, b, c, d = w[A + j], w[A + SIDE + j], w[A + 2 * SIDE + j], w[A + 3 * SIDE + j]
    p, q, u, v = w[F + j], w[F + SIDE + j], w[F + 2 * SIDE + j], w[F + 3 * SIDE + j]
    s, f = u - p, v - q
    linear, other_linear = d - p, d - u
    constant, other_constant = c - p * linear - q, c - u * other_linear - v
    dp, dq, first = _shifted(b - p * constant - q * linear, a - q * constant, s, f, p, q)
    du, dv, last = _shifted(
        b - u * other_constant - v * other_linear, a - v * other_constant, -s, -f, u, v
    )
    w[F + j], w[F + SIDE + j] = p + dp, q + dq
    w[F + 2 * SIDE + j], w[F + 3 * SIDE + j] = u + du, v + dv
    w[CHANGE + j] = larger(first, last)


def correct_quintic(j: int, w: Any) -> None:
    """The same for a factor of degree 5, with a second quadratic x² + u x + v."""
    a, b, c = w[A + j], w[A + SIDE + j], w[A + 2 * SIDE + j]
    d, e = w[A + 3 * SIDE + j], w[A + 4 * SIDE + j]
    r, p, q = w[F + j], w[F + SIDE + j], w[F + 2 * SIDE + j]
    u, v = w[F + 3 * SIDE + j], w[F + 4 * SIDE + j]
    value = ((((r + e) * r + d) * r + c) * r + b) * r + a
    dr = -value / (((r + p) * r + q) * ((r + u) * r + v))
    dp, dq, first = _quadratic(a, b, c, d, e, r, p, q, u, v)
    du, dv, second = _quadratic(a, b, c, d, e, r, u, v, p, q)
    w[F + j], w[F + SIDE + j], w[F + 2 * SIDE + j] = r + dr, p + dp, q + dq
    w[F + 3 * SIDE + j], w[F + 4 * SIDE + j] = u + du, v + dv
    w[CHANGE + j] = larger(larger((dr / r) ** 2, first), second)


def pair(p: Any, q: Any) -> Any:
    """Roots of x² + p x + q: two real parts, |imaginary part|, two moduli, |disc|, their error."""
    half = -0.5 * p
    square = half * half
    disc = square - q
    size = abs(disc)
    root = math.sqrt(size)
    slip = EPS * ((square + abs(q)) / root + abs(half) + root)
    big = half + (root if half >= 0 else -root)
    real = disc > 0
    other = q / (1.0 if big == 0 else big)
    common = math.sqrt(abs(q))
    return (
        big if real else half,
        other if real else half,
        0.0 if real else root,
        abs(big) if real else common,
        abs(other) if real else common,
        4 * size,
        slip,
    )


def cubic_discs(j: int, w: Any) -> None:
    """Roots of a cubic by their real parts and |imaginary parts|, and the radii of their discs."""
    a, b, c = w[A + j], w[A + SIDE + j], w[A + 2 * SIDE + j]
    x, y, z = w[E + j], w[E + SIDE + j], w[E + 2 * SIDE + j]
    r, p, q = w[F + j], w[F + SIDE + j], w[F + 2 * SIDE + j]
    s, ps, qs = abs(r), abs(p), abs(q)
    x = abs(a + r * q) + x + 3 * EPS * (s * qs)
    y = abs(b - (q - r * p)) + y + 3 * EPS * (s * ps + qs)
    z = abs(c - (p - r)) + z + 3 * EPS * (s + ps)
    first, second, turn, m, n, apart, slip = pair(p, q)
    up, down = (first - r) ** 2 + turn * turn, (second - r) ** 2 + turn * turn
    closest = smaller(apart, smaller(up, down))
    m, n = m + slip, n + slip
    w0 = weight(x, y, z, 0.0, 0.0, s, up * down)
    w1 = weight(x, y, z, 0.0, 0.0, m, apart * up) + slip
    w2 = weight(x, y, z, 0.0, 0.0, n, apart * down) + slip
    far = clear(3, larger(larger(w0, w1), w2), w0 + w1 + w2, closest)
    w[REAL + j], w[REAL + SIDE + j], w[REAL + 2 * SIDE + j] = r, first, second
    w[IMAG + j], w[IMAG + SIDE + j], w[IMAG + 2 * SIDE + j] = 0.0, turn, turn
    w[RADIUS + j] = far + 1.2 * w0
    w[RADIUS + SIDE + j], w[RADIUS + 2 * SIDE + j] = far + 1.2 * w1, far + 1.2 * w2


def clear(n: int, heaviest: Any, total: Any, closest: Any) -> Any:
    """0 where every disc is clear of the others and all weights are numbers, infinity elsewhere."""
    away = 12 * n * heaviest
    return 0.0 if (closest > away * away) & (total < math.inf) else math.inf


def quartic_discs(j: int, w: Any) -> None:
    """The same for a factor of degree 4."""
    a, b, c, d = w[A + j], w[A + SIDE + j], w[A + 2 * SIDE + j], w[A + 3 * SIDE + j]
    ea, eb, ec, ed = w[E + j], w[E + SIDE + j], w[E + 2 * SIDE + j], w[E + 3 * SIDE + j]
    p, q, u, v = w[F + j], w[F + SIDE + j], w[F + 2 * SIDE + j], w[F + 3 * SIDE + j]
    ps, qs, us, vs = abs(p), abs(q), abs(u), abs(v)
    ea = abs(a - q * v) + ea + 5 * EPS * (qs * vs)
    eb = abs(b - (p * v + q * u)) + eb + 5 * EPS * (ps * vs + qs * us)
    ec = abs(c - (q + p * u + v)) + ec + 5 * EPS * (qs + ps * us + vs)
    ed = abs(d - (p + u)) + ed + 5 * EPS * (ps + us)
    x1, x2, y, m1, m2, near, slip = pair(p, q)
    x3, x4, z, m3, m4, close, slide = pair(u, v)
    same, cross = (y - z) ** 2, (y + z) ** 2
    d13, d24 = (x1 - x3) ** 2 + same, (x2 - x4) ** 2 + same
    d14, d23 = (x1 - x4) ** 2 + cross, (x2 - x3) ** 2 + cross
    closest = smaller(smaller(near, close), smaller(smaller(d13, d24), smaller(d14, d23)))
    m1, m2, m3, m4 = m1 + slip, m2 + slip, m3 + slide, m4 + slide
    w1 = weight(ea, eb, ec, ed, 0.0, m1, near * (d13 * d14)) + slip
    w2 = weight(ea, eb, ec, ed, 0.0, m2, near * (d23 * d24)) + slip
    w3 = weight(ea, eb, ec, ed, 0.0, m3, close * (d13 * d23)) + slide
    w4 = weight(ea, eb, ec, ed, 0.0, m4, close * (d14 * d24)) + slide
    far = clear(4, larger(larger(w1, w2), larger(w3, w4)), w1 + w2 + w3 + w4, closest)
    w[REAL + j], w[REAL + SIDE + j] = x1, x2
    w[REAL + 2 * SIDE + j], w[REAL + 3 * SIDE + j] = x3, x4
    w[IMAG + j], w[IMAG + SIDE + j] = y, y
    w[IMAG + 2 * SIDE + j], w[IMAG + 3 * SIDE + j] = z, z
    w[RADIUS + j], w[RADIUS + SIDE + j] = far + 1.3 * w1, far + 1.3 * w2
    w[RADIUS + 2 * SIDE + j], w[RADIUS + 3 * SIDE + j] = far + 1.3 * w3, far + 1.3 * w4


def quintic_discs(j: int, w: Any) -> None:
    """The same for a factor of degree 5."""
    a, b, c = w[A + j], w[A + SIDE + j], w[A + 2 * SIDE + j]
    d, e = w[A + 3 * SIDE + j], w[A + 4 * SIDE + j]
    ea, eb, ec = w[E + j], w[E + SIDE + j], w[E + 2 * SIDE + j]
    ed, ee = w[E + 3 * SIDE + j], w[E + 4 * SIDE + j]
    r, p, q = w[F + j], w[F + SIDE + j], w[F + 2 * SIDE + j]
    u, v = w[F + 3 * SIDE + j], w[F + 4 * SIDE + j]
    c0, c1, c2 = -r * q, -r * p + q, -r + p
    s, ps, qs, us, vs = abs(r), abs(p), abs(q), abs(u), abs(v)
    s0, s1, s2 = s * qs, s * ps + qs, s + ps
    ea = abs(a - c0 * v) + ea + 5 * EPS * (s0 * vs)
    eb = abs(b - (c0 * u + c1 * v)) + eb + 5 * EPS * (s0 * us + s1 * vs)
    ec = abs(c - (c0 + c1 * u + c2 * v)) + ec + 5 * EPS * (s0 + s1 * us + s2 * vs)
    ed = abs(d - (c1 + c2 * u + v)) + ed + 5 * EPS * (s1 + s2 * us + vs)
    ee = abs(e - (c2 + u)) + ee + 5 * EPS * (s2 + us)
    x1, x2, y, m1, m2, near, slip = pair(p, q)
    x3, x4, z, m3, m4, close, slide = pair(u, v)
    turn, tilt = y * y, z * z
    d1, d2 = (x1 - r) ** 2 + turn, (x2 - r) ** 2 + turn
    d3, d4 = (x3 - r) ** 2 + tilt, (x4 - r) ** 2 + tilt
    same, cross = (y - z) ** 2, (y + z) ** 2
    d13, d24 = (x1 - x3) ** 2 + same, (x2 - x4) ** 2 + same
    d14, d23 = (x1 - x4) ** 2 + cross, (x2 - x3) ** 2 + cross
    closest = smaller(smaller(smaller(near, close), smaller(d1, d2)), smaller(d3, d4))
    closest = smaller(closest, smaller(smaller(d13, d24), smaller(d14, d23)))
    m1, m2, m3, m4 = m1 + slip, m2 + slip, m3 + slide, m4 + slide
    w0 = weight(ea, eb, ec, ed, ee, s, (d1 * d2) * (d3 * d4))
    w1 = weight(ea, eb, ec, ed, ee, m1, (near * d1) * (d13 * d14)) + slip
    w2 = weight(ea, eb, ec, ed, ee, m2, (near * d2) * (d23 * d24)) + slip
    w3 = weight(ea, eb, ec, ed, ee, m3, (close * d3) * (d13 * d23)) + slide
    w4 = weight(ea, eb, ec, ed, ee, m4, (close * d4) * (d14 * d24)) + slide
    heaviest = larger(larger(larger(w0, w1), larger(w2, w3)), w4)
    far = clear(5, heaviest, w0 + w1 + w2 + w3 + w4, closest)
    w[REAL + j], w[REAL + SIDE + j], w[REAL + 2 * SIDE + j] = r, x1, x2
    w[REAL + 3 * SIDE + j], w[REAL + 4 * SIDE + j] = x3, x4
    w[IMAG + j], w[IMAG + SIDE + j], w[IMAG + 2 * SIDE + j] = 0.0, y, y
    w[IMAG + 3 * SIDE + j], w[IMAG + 4 * SIDE + j] = z, z
    w[RADIUS + j] = far + 1.4 * w0
    w[RADIUS + SIDE + j], w[RADIUS + 2 * SIDE + j] = far + 1.4 * w1, far + 1.4 * w2
    w[RADIUS + 3 * SIDE + j], w[RADIUS + 4 * SIDE + j] = far + 1.4 * w3, far + 1.4 * w4


def weight(a: Any, b: Any, c: Any, d: Any, e: Any, size: Any, spread: Any) -> Any:
    """Weight of a root of this modulus; 1.2 covers the rounding of the distances."""
    value = 1.2 * ((((e * size + d) * size + c) * size + b) * size + a) / math.sqrt(spread)
    return value if spread < math.inf else math.inf  # no weight is small by an overflow
