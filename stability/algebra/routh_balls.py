"""Characteristic polynomials in balls: proved verdicts and crossings at a boundary."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import islice
from typing import Any

from flint import arb, arb_mat

ROUGH = 1e-6
"""Largest rate at which a sampled member without solved unknowns counts as steady."""


def verdict_polynomial(coefficients: Sequence[Any], zeros: int, conservative: bool) -> list[Any]:
    """The polynomial whose Hurwitz stability is the verdict, lowest coefficient first.

    For a dissipative law: the reduced characteristic polynomial.  For a conservative law, with the
    reduced polynomial q(λ²): q(λ²) + λ q'(λ²), Hurwitz exactly when all λ² are real, negative and
    simple.

    Parameters
    ----------
    coefficients
        Coefficients of det(λ - A), lowest first.
    zeros
        Number of structural zeros.
    conservative
        Whether the reduced polynomial is even.

    Returns
    -------
    list of arb

    Source: Hermite-Biehler theorem; F. R. Gantmacher, The Theory of Matrices, vol. 2, ch. XV § 14.
    """
    reduced = list(coefficients[zeros:])
    if not conservative:
        return reduced
    for power in range(2, len(reduced), 2):
        reduced[power - 1] = reduced[power] * (power // 2)
    return reduced


def product(factors: Sequence[Sequence[Any]]) -> list[Any]:
    """The monic multiple of a product of polynomials, as balls.

    Parameters
    ----------
    factors
        Coefficients of each factor, lowest first; the last one is not zero.

    Returns
    -------
    list of arb
    """
    out = [arb(1)]
    for factor in factors:
        terms = [arb(c) for c in factor]
        longer = [arb(0)] * (len(out) + len(terms) - 1)
        for i, p in enumerate(out):
            for j, c in enumerate(terms):
                longer[i + j] += p * c
        out = longer
    return [c / out[-1] for c in out[:-1]] + [arb(1)]


def routh(polynomial: Sequence[Any]) -> Iterator[Any]:
    """First column of Routh's array, over any number type: all positive for a Hurwitz polynomial.

    Parameters
    ----------
    polynomial
        Coefficients, lowest first, leading one positive.

    Examples
    --------
    >>> list(routh([6.0, 11.0, 6.0, 1.0]))
    [1.0, 6.0, 10.0, 6.0]
    """
    high = list(reversed(polynomial))
    upper, lower = high[0::2], high[1::2]
    yield upper[0]
    while lower:
        yield lower[0]
        ratio = upper[0] / lower[0]
        padded = [*lower[1:], *[0] * len(upper)]
        following = [u - ratio * low for u, low in zip(upper[1:], padded, strict=False)]
        upper, lower = lower, following


def hurwitz_sign(polynomial: Sequence[Any]) -> int:
    """Whether all roots have negative real part, by Routh's array in balls.

    Parameters
    ----------
    polynomial
        Coefficients as balls, lowest first, leading one positive.

    Returns
    -------
    int
        1, proved: all roots in the open left half-plane; -1, proved: some root in the open right
        half-plane; 0, not decided at this precision.

    Source: F. R. Gantmacher, The Theory of Matrices, vol. 2, ch. XV §§ 3-6.  (A polynomial with all
    roots in Re ≤ 0 is a limit of stable ones, so its Hurwitz determinants are ≥ 0: a determinant
    proved negative proves a root in Re > 0.)

    Examples
    --------
    >>> from flint import arb
    >>> hurwitz_sign([arb(1), arb(2), arb(1)]), hurwitz_sign([arb(-1), arb(2), arb(1)])
    (1, -1)
    """
    if any(c < 0 for c in polynomial):
        return -1
    for first in islice(routh(polynomial), 1, None):  # ends before a division by zero
        if first < 0:
            return -1
        if not first > 0:
            return 0
    return 1


def hurwitz_determinant(polynomial: Sequence[Any]) -> Any:
    """The Hurwitz determinant of order n - 1, which vanishes where a pair meets the imaginary axis.

    Parameters
    ----------
    polynomial
        Coefficients as balls, lowest first.

    Returns
    -------
    arb
        1 for n < 2.

    Source: Orlando's formula, Gantmacher vol. 2, ch. XV § 7: Δ(n-1) = ± ∏ (λᵢ + λⱼ) over i < j.
    """
    degree = len(polynomial) - 1
    if degree < 2:
        return arb(1)
    high = list(reversed(polynomial))

    def entry(i: int, j: int) -> Any:
        index = 2 * (j + 1) - (i + 1)
        return high[index] if 0 <= index <= degree else arb(0)

    size = degree - 1
    return arb_mat(size, size, [entry(i, j) for i in range(size) for j in range(size)]).det()
