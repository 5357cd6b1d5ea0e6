"""Real factors of one cubic or quintic: their corrections, and discs around their roots.

Formulas and proofs are those of `stability.algebra.real_factors`, for one cell instead of arrays.
Loops over cells call these functions, and the compiler turns them into vector instructions: there
are no branches, only choices between two computed values.
"""

from __future__ import annotations

import math
from typing import Any

INLINE = (
    "larger",
    "smaller",
    "corrected_cubic",
    "corrected_quintic",
    "_quadratic",
    "pair",
    "clear",
    "weight",
    "cubic_discs",
    "quintic_discs",
    "correct_cubic",
    "correct_quintic",
)
"""Functions, here and in `loops`, that are written into the loops over cells."""
EPS = 2.0**-52
"""Relative distance of doubles."""


def larger(x: float, y: float) -> float:
    """The larger of two numbers; the second one where either is not a number."""
    return x if x > y else y


def smaller(x: float, y: float) -> float:
    """The smaller of two numbers; the second one where either is not a number."""
    return x if x < y else y


def corrected_cubic(a: Any, b: Any, c: Any, r: Any, p: Any, q: Any) -> Any:
    """(r, p, q) of x³ + c x² + b x + a after one correction, and the square of the change."""
    dr = -(((r + c) * r + b) * r + a) / ((r + p) * r + q)
    high = c - p
    alpha, beta = b - p * high - q, a - q * high
    m = -r - p
    det = q - r * m
    dp, dq = (-r * alpha - beta) / det, (m * beta + q * alpha) / det
    change = larger((dr / r) ** 2, (dq / q) ** 2 + dp * dp / (abs(q) + p * p))
    return r + dr, p + dp, q + dq, change


def _quadratic(
    a: Any, b: Any, c: Any, d: Any, e: Any, r: Any, p: Any, q: Any, u: Any, v: Any
) -> Any:
    """Change of x² + p x + q, next to x - r and x² + u x + v."""
    one = e - p
    two = d - p * one - q
    three = c - p * two - q * one
    alpha, beta = b - p * three - q * two, a - q * three
    s, f = u - p, v - q
    gamma, delta = f - s * (r + p), -r * f - s * q
    m = delta - gamma * p
    det = delta * m + gamma * gamma * q
    dp, dq = (alpha * delta - beta * gamma) / det, (m * beta + gamma * q * alpha) / det
    return dp, dq, (dq / q) ** 2 + dp * dp / (abs(q) + p * p)


def corrected_quintic(
    a: Any, b: Any, c: Any, d: Any, e: Any, r: Any, p: Any, q: Any, u: Any, v: Any
) -> Any:
    """The five numbers of the factors after one correction, and the square of the change."""
    value = ((((r + e) * r + d) * r + c) * r + b) * r + a
    dr = -value / (((r + p) * r + q) * ((r + u) * r + v))
    dp, dq, first = _quadratic(a, b, c, d, e, r, p, q, u, v)
    du, dv, second = _quadratic(a, b, c, d, e, r, u, v, p, q)
    change = larger(larger((dr / r) ** 2, first), second)
    return r + dr, p + dp, q + dq, u + du, v + dv, change


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


def cubic_discs(a: Any, b: Any, c: Any, x: Any, y: Any, z: Any, r: Any, p: Any, q: Any) -> Any:
    """Three real parts, the pair's |imaginary part|, three radii.

    The coefficients a, b, c have errors x, y, z.
    """
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
    return r, first, second, turn, far + 1.2 * w0, far + 1.2 * w1, far + 1.2 * w2


def clear(n: int, heaviest: Any, total: Any, closest: Any) -> Any:
    """0 where every disc is clear of the others and all weights are numbers, infinity elsewhere."""
    away = 2 * (n + 10) * heaviest
    return 0.0 if (closest > away * away) & (total < math.inf) else math.inf


def quintic_discs(
    a: Any,
    b: Any,
    c: Any,
    d: Any,
    e: Any,
    ea: Any,
    eb: Any,
    ec: Any,
    ed: Any,
    ee: Any,
    r: Any,
    p: Any,
    q: Any,
    u: Any,
    v: Any,
) -> Any:
    """Five real parts, |imaginary parts| of both pairs, five radii; ea … ee are errors."""
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
    return (
        r,
        x1,
        x2,
        x3,
        x4,
        y,
        z,
        far + 1.4 * w0,
        far + 1.4 * w1,
        far + 1.4 * w2,
        far + 1.4 * w3,
        far + 1.4 * w4,
    )


def weight(a: Any, b: Any, c: Any, d: Any, e: Any, size: Any, spread: Any) -> Any:
    """Weight of a root of this modulus; 1.2 covers the rounding of the distances."""
    value = 1.2 * ((((e * size + d) * size + c) * size + b) * size + a) / math.sqrt(spread)
    return value if spread < math.inf else math.inf  # no weight is small by an overflow
