"""Polynomials over Q and the imaginary axis: Routh's array and the roots on the axis, exactly."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from flint import fmpq, fmpq_poly

from ...base.verdict import Verdict


def on_the_axis(factors: Sequence[Any]) -> Verdict:
    """The verdict of a product of polynomials over Q, for any roots on the imaginary axis.

    Parameters
    ----------
    factors
        Polynomials, `fmpq_poly` each, none of them zero.

    Returns
    -------
    Verdict
        Never undecided.

    Examples
    --------
    >>> on_the_axis([fmpq_poly([1, 0, 2, 0, 1])]).word  # (λ² + 1)²
    'neutral'
    """
    neutral = False
    for factor in factors:
        zeros, symmetric, rest = split(factor)
        neutral = neutral or zeros > 0 or symmetric.degree() > 0
        if not _hurwitz(rest):
            return Verdict.UNSTABLE
        for square, _ in squares(symmetric):
            if not (square.imag == 0 and square.real < 0):
                return Verdict.UNSTABLE
    return Verdict.NEUTRAL if neutral else Verdict.STABLE


def split(p: Any) -> tuple[int, Any, Any]:
    """A polynomial over Q as λ^zeros · symmetric · rest.

    Parameters
    ----------
    p
        An `fmpq_poly`, not zero.

    Returns
    -------
    zeros, symmetric, rest
        Number of roots at 0, and two polynomials.  `symmetric` is even; its roots are the nonzero
        roots λ for which -λ is a root too.  `rest` has no such pair.

    Examples
    --------
    >>> split(fmpq_poly([0, 1, 1, 1, 1]))  # λ (λ² + 1) (λ + 1)
    (1, x^2 + 1, x + 1)
    """
    coefficients = p.coeffs()
    zeros = next(i for i, c in enumerate(coefficients) if c != 0)
    kept = fmpq_poly(coefficients[zeros:])
    mirror = fmpq_poly([-c if i % 2 else c for i, c in enumerate(kept.coeffs())])
    common = kept.gcd(mirror)
    return zeros, common, kept / common


def squares(symmetric: Any) -> list[Any]:
    """The roots λ² of an even polynomial over Q, as (ball, multiplicity)."""
    if symmetric.degree() < 1:
        return []
    found: list[Any] = fmpq_poly(symmetric.coeffs()[::2]).numer().complex_roots()
    return found


def _hurwitz(p: Any) -> bool:
    """Routh's array over Q, for a polynomial without mirrored roots."""
    rows = list(reversed(p.coeffs()))
    here, following = rows[::2], rows[1::2]
    while following:
        if following[0] / here[0] <= 0:
            return False
        ratio = here[0] / following[0]
        padded = [*following[1:], fmpq(0)][: len(here) - 1]
        here, following = (
            following,
            [x - ratio * y for x, y in zip(here[1:], padded, strict=True)],
        )
    return True
