"""Negative terms of a polynomial that squares outweigh: 2 a b ≤ a² + b²."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from itertools import combinations
from typing import Any

MOST_NEGATIVE = 4
"""Negative terms beyond which no squares are sought."""
MOST_TERMS = 40
"""Terms beyond which no squares are sought."""
Exponents = tuple[int, ...]
Terms = Mapping[Exponents, Any]
"""Rational coefficients by the exponents of their monomials."""


def outweighed(terms: Terms, never_negative: Callable[[Exponents], bool]) -> dict[Any, Any] | None:
    """What is left of a polynomial after every negative term is completed to a square, or None.

    A term -c·M with M² = A·B is outweighed by p·A + q·B where A, B ≥ 0 and c² ≤ 4 p q.  Where c²
    is less, with s = c²/(4 p q), the part (1 - s)/2 of both is left, since √s ≤ (1 + s)/2.

    Parameters
    ----------
    terms
        The polynomial.
    never_negative
        Whether the monomial of some exponents is nowhere negative.

    Returns
    -------
    dict or None
        Terms with positive coefficients: the polynomial is nowhere less than their sum.

    Source: tests/derivation/test_signs.py.

    Examples
    --------
    >>> from fractions import Fraction
    >>> one = Fraction(1)
    >>> outweighed({(4, 0): one, (2, 1): -2 * one, (0, 2): one, (0, 0): 3 * one},
    ...            lambda e: all(n % 2 == 0 for n in e))
    {(0, 0): Fraction(3, 1)}
    """
    negative = [e for e, c in terms.items() if c < 0 or not never_negative(e)]
    if not negative or len(negative) > MOST_NEGATIVE or len(terms) > MOST_TERMS:
        return None
    return _completed(
        {e: c for e, c in terms.items() if e not in negative}, [(e, terms[e]) for e in negative]
    )


def _completed(
    good: dict[Exponents, Any], negative: list[tuple[Exponents, Any]]
) -> dict[Exponents, Any] | None:
    """The terms left after all negative ones are completed, by any choice of pairs."""
    if not negative:
        return good
    (middle, c), *others = negative
    for a, b in combinations(good, 2):
        if any(i + j != 2 * k for i, j, k in zip(a, b, middle, strict=True)):
            continue
        share = c * c / (4 * good[a] * good[b])
        if share > 1:
            continue
        left = {e: v * (1 - share) / 2 if e in (a, b) else v for e, v in good.items()}
        found = _completed({e: v for e, v in left.items() if v}, others)
        if found is not None:
            return found
    return None
