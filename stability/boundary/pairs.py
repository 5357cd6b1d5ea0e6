"""Roots on the imaginary axis and beyond it, from the coefficients of a polynomial.

Source: a polynomial p of degree n has, for every j, a zero within (C(n, j) |p(z) j!/p⁽ʲ⁾(z)|)^(1/j)
of z: the j-th elementary symmetric function of 1/(z - zeros) has C(n, j) terms;
tests/boundary/test_single_points.py.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import combinations
from math import comb
from typing import Any

import numpy as np
from flint import acb, acb_poly, arb, fmpq_poly

from ..algebra.exact.roots import complex_roots, isolated
from ..algebra.exact.routh import monic, sign_changes
from ..algebra.number_types import precision

CLOSE = 2.0**-64
"""Distance from the imaginary axis, over |Im λ|, up to which a root is on it."""
FREQUENCY_BITS = 128
"""Digits of the roots for a frequency in doubles."""


def frequency(polynomial: Sequence[Any], *, even: bool = False) -> float:
    """Frequency of the pair on (or next to) the imaginary axis, from the polynomial.

    Parameters
    ----------
    polynomial
        Coefficients as balls, lowest first, of a polynomial with a pair near the axis.
    even
        Whether the polynomial is q(λ²) with two roots in λ² that meet.  Every pair is then on the
        axis, and the frequency is that of two pairs that meet.

    Returns
    -------
    float
        |Im λ| of the root nearest the imaginary axis among those that are not real, or of the two
        nearest to each other; 0 if all are real.

    Examples
    --------
    >>> frequency([arb(4), arb(0), arb(1)]), frequency([arb(c) for c in (9, 0, 6, 0, 1)], even=True)
    (2.0, 1.7320508075688772)
    """
    # over Q, where roots of any multiplicity are isolated
    exact = [c.mid().fmpq() for c in map(arb, polynomial)]
    with precision(FREQUENCY_BITS):
        pairs = meeting(fmpq_poly(exact[::2])) if even else crossing(fmpq_poly(exact))
        return min(pairs, default=(math.inf, 0.0))[1]


def crossing(polynomial: Any) -> Iterator[tuple[float, float]]:
    """(distance from the imaginary axis over |Im λ|, |Im λ|) of each root that is not real."""
    for root, count in complex_roots(polynomial):
        if root.imag != 0:
            distance = abs(float((root.real / root.imag).mid()))
            yield from [(distance, abs(float(root.imag.mid())))] * count


def meeting(squares: Any) -> Iterator[tuple[float, float]]:
    """(distance over size, √-y) of each two roots of a polynomial in λ² about some y < 0."""
    roots = [root for root, count in complex_roots(squares) for _ in range(count)]
    for y, z in combinations(roots, 2):
        middle = float(((y + z) / 2).real.mid())
        if middle < 0:
            yield float(abs(z - y).mid()) / -middle, math.sqrt(-middle)


def on_axis(coefficients: Sequence[Any], *, even: bool) -> list[float]:
    """|Im λ| of what is on the imaginary axis: 0 for each zero, one number for each pair.

    Parameters
    ----------
    coefficients
        Narrow balls, lowest first; one that contains zero counts as zero.
    even
        Whether the polynomial is q(λ²), of whose pairs only those that meet are listed.
    """
    zeros = next(i for i, c in enumerate(coefficients) if not c.contains(0))
    rest = [c.mid().fmpq() for c in coefficients[zeros:]]
    if even:
        meetings = meeting(fmpq_poly(rest[::2]))
        return [0.0] * (zeros // 2) + [w for distance, w in meetings if distance < CLOSE]
    pairs = sorted(w for distance, w in crossing(fmpq_poly(rest)) if distance < CLOSE)
    return [0.0] * zeros + pairs[::2]


def unstable_count(coefficients: Sequence[Any], *, even: bool) -> int | None:
    """Number of zeros with Re > 0 of a polynomial of balls, lowest first; None without a proof.

    Examples
    --------
    >>> unstable_count([arb(-1), arb(0), arb(1)], even=True)
    1
    """
    if not even and (count := sign_changes(monic(coefficients))) is not None:
        return count
    roots = isolated(list(coefficients), even)
    # a ball that holds zero is not unequal to it: only an exact zero is on the axis
    if roots is None or any(z.real.contains(0) and not z.real.is_zero() for z in roots):
        return None
    return sum(bool(z.real > 0) for z in roots)


def grows(coefficients: Sequence[Any]) -> bool:
    """Whether a polynomial of balls, lowest first, is proved to have a zero with Re > 0.

    Examples
    --------
    >>> grows([arb(-1), arb(0), arb(1)]), grows([arb(1), arb(1)])
    (True, False)
    """
    polynomial = acb_poly([acb(c) for c in coefficients])
    middle = np.array([float(c.mid()) for c in map(arb, coefficients)])
    if not np.isfinite(middle).all() or not middle[-1]:
        return False
    degree = len(coefficients) - 1
    for guess in np.roots(middle[::-1]):
        if guess.real > 0:
            taylor = list(polynomial(acb_poly([acb(complex(guess)), acb(1)])))
            for j in range(1, degree + 1):
                if taylor[j].contains(0):
                    continue
                ratio = comb(degree, j) * abs(taylor[0]) / abs(taylor[j])
                if ratio.upper().root(j) < float(guess.real):
                    return True
    return False
