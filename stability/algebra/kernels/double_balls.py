"""Ball arithmetic in double precision, on rows of numbers: a kernel for `compiled`.

A ball (m, r) holds every x with |x - m| ≤ r; r = inf or nan holds everything, and no comparison
accepts it.  With u = 2⁻⁵³, a rounded sum errs by at most u |m|, a rounded product, quotient or root
by at most u |m| + 2⁻¹⁰⁷⁵ (round to nearest, gradual underflow).  Each radius is a sum of products
of numbers ≥ 0 with at most 10 roundings.  So (computed) UP + TINY, with UP = 1 + 64 u and
TINY = 2⁻¹⁰⁰⁰, is no smaller than its exact value: 10 roundings cost a factor of at most 1 + 11 u,
the factor UP and the last sum at most 1 + 3 u more, and each underflow at most 2⁻¹⁰⁷⁵.

Sine and cosine: for |a| ≤ 10⁵ the quarter turns k = rint(a/PI1) are below 2¹⁶, PI1 and PI2 have 33
bits, so k PI1 and k PI2 are exact and a - k PI1 is exact by Sterbenz; two differences below 1 are
rounded by at most 2⁻⁵⁴ each, |k (π/2 - PI1 - PI2 - PI3)| < 2⁻¹⁰⁷.  The reduced argument errs by
less than 1.1 · 2⁻⁵³, and its size is at most π/4 + 4e-6 < 0.7855, since PI1 is π/2 within 6.1e-11.
There Taylor's remainders are below 1e-19 (sine to y¹⁷) and 3e-18 (cosine to y¹⁶), and the roundings
of Horner's rule below 2⁻⁵² for both.  Together the error is below 2⁻⁵¹; SINE = 2⁻⁵⁰ is twice that.

`follow` runs a tape (`stability.algebra.kernels.tape`).  The functions take rows of any length.
"""

from __future__ import annotations

from typing import Any

import numpy as np

U = 2.0**-53
UP = 1.0 + 2.0**-47
TINY = 2.0**-1000
SINE = 2.0**-50
LARGEST = 1e5
PI1 = float.fromhex("0x1.921fb544p+0")
PI2 = float.fromhex("0x1.0b4611a6p-34")
PI3 = float.fromhex("0x1.3198a2e037073p-69")
"""π/2 = PI1 + PI2 + PI3 within 2e-37; the first two have 33 bits."""
SUM, DIFFERENCE, PRODUCT, RATIO, NEGATIVE, ROOT, SINES, SIZE = range(8)
"""Operations of a tape."""
INLINE = ("add", "multiply", "divide", "root", "sines")
"""Functions that are written into the loops of `follow`: an array for each row costs four times as
much."""


def add(a: Any, ra: Any, b: Any, rb: Any) -> Any:
    """Sum of balls."""
    m = a + b
    return m, (ra + rb + U * np.abs(m)) * UP + TINY


def multiply(a: Any, ra: Any, b: Any, rb: Any) -> Any:
    """Product of balls: |xy - ab| ≤ |a| rb + ra (|b| + rb)."""
    m = a * b
    return m, (np.abs(a) * rb + ra * (np.abs(b) + rb) + U * np.abs(m)) * UP + TINY


def divide(a: Any, ra: Any, b: Any, rb: Any) -> Any:
    """Quotient of balls: |1/y - 1/b| ≤ rb/(|b| - rb) / |b|; infinite where b may be 0.

    TINY within the bracket covers an underflow of its quotient, which 1/|b| may enlarge.
    """
    gap = np.abs(b) - rb
    inverse = 1.0 / b
    r = (
        (rb / (0.5 * (gap + np.abs(gap))) + TINY) * np.abs(inverse) + U * np.abs(inverse)
    ) * UP + TINY
    return multiply(a, ra, inverse, r)


def root(a: Any, ra: Any) -> Any:
    """Square root of a ball: |√x - √a| ≤ ra/(√(a - ra) + √a); nan where x may be negative."""
    m = np.sqrt(a)
    return m, (ra / (np.sqrt(a - ra) + m) + U * m) * UP + TINY


def sines(a: Any, ra: Any) -> Any:
    """Sine and cosine of a ball: |sin x - sin a| ≤ ra |cos a| + ra²/2, and so for the cosine."""
    k = np.rint(a / PI1)
    y = ((a - k * PI1) - k * PI2) - k * PI3
    z = y * y
    s = z * (1.0 / 355687428096000.0) - 1.0 / 1307674368000.0
    s = z * (z * (z * s + 1.0 / 6227020800.0) - 1.0 / 39916800.0) + 1.0 / 362880.0
    s = z * (z * (z * s - 1.0 / 5040.0) + 1.0 / 120.0) - 1.0 / 6.0
    s = y + y * (z * s)
    c = z * (1.0 / 20922789888000.0) - 1.0 / 87178291200.0
    c = z * (z * (z * c + 1.0 / 479001600.0) - 1.0 / 3628800.0) + 1.0 / 40320.0
    c = z * (z * (z * c - 1.0 / 720.0) + 1.0 / 24.0) - 0.5
    c = 1.0 + z * c
    quarter = k - 4.0 * np.floor(0.25 * k)
    half = np.floor(0.5 * quarter)
    odd = quarter - 2.0 * half
    sign = 1.0 - 2.0 * half
    sine = sign * ((1.0 - odd) * s + odd * c)
    cosine = sign * ((1.0 - odd) * c - odd * s)
    in_range = 1.0 * (np.abs(a) <= LARGEST)  # elsewhere the radius is infinite
    bent = 0.5 * ra * ra + SINE
    rs = (((np.abs(cosine) + SINE) * ra + bent) * UP + TINY) / in_range
    rc = (((np.abs(sine) + SINE) * ra + bent) * UP + TINY) / in_range
    return sine, rs, cosine, rc


def follow(tape: Any, mid: Any, rad: Any) -> None:
    """Run a tape on rows of balls.

    Parameters
    ----------
    tape
        Rows (operation, target, first, second), shape (instructions, 4); sines have two targets,
        the second in the last place.
    mid, rad
        Registers, shape (registers, lanes): inputs and constants are set, the rest is overwritten.
        In plain Python the shape (registers, 1, lanes) makes each step one of whole rows.
    """
    for i in range(len(tape)):
        kind, t, a, b = tape[i, 0], tape[i, 1], tape[i, 2], tape[i, 3]
        m, r, am, ar, bm, br = mid[t], rad[t], mid[a], rad[a], mid[b], rad[b]
        if kind == SUM:
            for j in range(len(m)):
                m[j], r[j] = add(am[j], ar[j], bm[j], br[j])
        elif kind == DIFFERENCE:
            for j in range(len(m)):
                m[j], r[j] = add(am[j], ar[j], -bm[j], br[j])
        elif kind == PRODUCT:
            for j in range(len(m)):
                m[j], r[j] = multiply(am[j], ar[j], bm[j], br[j])
        elif kind == RATIO:
            for j in range(len(m)):
                m[j], r[j] = divide(am[j], ar[j], bm[j], br[j])
        elif kind == NEGATIVE:
            for j in range(len(m)):
                m[j], r[j] = -am[j], ar[j]
        elif kind == ROOT:
            for j in range(len(m)):
                m[j], r[j] = root(am[j], ar[j])
        elif kind == SINES:
            for j in range(len(m)):
                m[j], r[j], bm[j], br[j] = sines(am[j], ar[j])
        else:
            for j in range(len(m)):
                m[j], r[j] = np.abs(am[j]), ar[j]


def product(a: Any, b: Any, rb: Any, c: Any, rc: Any) -> None:
    """Product of an exact matrix with one of balls, lane by lane.

    A sum of n products errs by at most (n + 1) u Σ|a||b|, n ≤ 60, and by underflows.

    Parameters
    ----------
    a, b, rb
        Shapes (rows, inner, lanes) and (inner, columns, lanes).
    c, rc
        Where the product goes, shape (rows, columns, lanes).
    """
    for i in range(a.shape[0]):
        for j in range(b.shape[1]):
            s = a[i, 0] * b[0, j]
            r = np.abs(a[i, 0]) * (rb[0, j] + 64.0 * U * np.abs(b[0, j]))
            for k in range(1, a.shape[1]):
                s = s + a[i, k] * b[k, j]
                r = r + np.abs(a[i, k]) * (rb[k, j] + 64.0 * U * np.abs(b[k, j]))
            c[i, j] = s
            rc[i, j] = r * UP + TINY
