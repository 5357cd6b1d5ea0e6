"""Polynomials and the imaginary axis: Routh's array and the roots on the axis, exactly.

Over Q all is decided.  Over any other real field the same steps need a proved sign of each number.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from flint import acb, fmpq, fmpq_poly

from ...base.verdict import Verdict
from .isolation import factored_roots, halved_roots

FAR = 250
"""Bits by which the sizes of roots differ, above which real roots are found by halving."""


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
        if not _squares_negative(symmetric):
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
    whole = fmpq_poly(symmetric.coeffs()[::2]).numer()
    if _spread(whole) > FAR:  # Flint's search for complex roots would take minutes
        found = []
        for factor, count in whole.factor_squarefree()[1]:
            real = halved_roots(factor)
            if len(real) < factor.degree():
                break
            found += [(acb(root), count) for root in real]
        else:
            return found
    return factored_roots(whole)


def _spread(p: Any) -> float:
    """Bound on the ratio of the largest and the smallest root, in bits."""
    bits = [int(abs(c)).bit_length() for c in p.coeffs()]
    size = len(bits) - 1
    high = max((b - bits[-1] + 1) / (size - i) for i, b in enumerate(bits[:-1]) if b)
    low = min((bits[0] - b - 1) / i for i, b in enumerate(bits) if i and b)
    return high - low


def _squares_negative(symmetric: Any) -> bool:
    """Whether all roots λ² of an even polynomial over Q are real and negative, by Routh's array.

    Source: Hermite-Biehler, for q(λ²) + λ q'(λ²) with q without multiple roots.
    """
    if symmetric.degree() < 1:
        return True
    whole = fmpq_poly(symmetric.coeffs()[::2])
    plain = whole / whole.gcd(whole.derivative())
    slope = plain.derivative().coeffs()
    mixed: list[Any] = []
    for i, c in enumerate(plain.coeffs()):
        mixed += [c, slope[i] if i < len(slope) else fmpq(0)]
    return _hurwitz(fmpq_poly(mixed))


def _hurwitz(p: Any) -> bool:
    """Routh's array over Q: whether all roots lie in the open left half-plane."""
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


class Ground(NamedTuple):
    """A real field by what proofs need of it."""

    sign: Callable[[Any], int]
    """Proved sign of a number: 1, -1, or 0 where it is zero; `NotExact` where none is proved."""
    tidy: Callable[[Any], Any]
    """The number in a form that does not grow."""


def on_the_axis_over(ground: Ground, coefficients: Sequence[Any]) -> Verdict:
    """As `on_the_axis`, for one polynomial over a real field.

    Parameters
    ----------
    ground
        The field.
    coefficients
        Numbers of the field or rationals, lowest first.

    Returns
    -------
    Verdict
        Never undecided.

    Raises
    ------
    NotExact
        If a sign is not proved.

    Examples
    --------
    >>> rationals = Ground(lambda c: (c > 0) - (c < 0), lambda c: c)
    >>> on_the_axis_over(rationals, [fmpq(1), 1, 2, 2, 1, 1]).word  # (λ² + 1)² (λ + 1)
    'neutral'
    """
    kept = _trimmed(ground, [fmpq(c) if isinstance(c, int) else c for c in coefficients])
    zeros = next(i for i, c in enumerate(kept) if ground.sign(c))
    even, odd = kept[zeros::2], _trimmed(ground, kept[zeros + 1 :: 2])
    common = _common(ground, _trimmed(ground, even), odd)
    parts = [_divided(ground, p, common)[0] for p in (even, odd)]
    if not _hurwitz_over(ground, _mixed(*parts)):
        return Verdict.UNSTABLE
    if len(common) > 1:  # a polynomial in λ²
        slope = [i * c for i, c in enumerate(common)][1:]
        plain = _divided(ground, common, _common(ground, common, slope))[0]
        slope = [i * c for i, c in enumerate(plain)][1:]
        if not _hurwitz_over(ground, _mixed(plain, slope)):
            return Verdict.UNSTABLE
    return Verdict.NEUTRAL if zeros or len(common) > 1 else Verdict.STABLE


def _trimmed(ground: Ground, p: Sequence[Any]) -> list[Any]:
    """Without leading coefficients that are zero."""
    size = next((i for i in range(len(p), 0, -1) if ground.sign(p[i - 1])), 0)
    return list(p[:size])


def _mixed(even: Sequence[Any], odd: Sequence[Any]) -> list[Any]:
    """The polynomial even(λ²) + λ odd(λ²)."""
    size = max(2 * len(even) - 1, 2 * len(odd))
    out = [fmpq(0)] * size
    out[: 2 * len(even) : 2], out[1 : 2 * len(odd) : 2] = even, odd
    return out


def _divided(ground: Ground, p: Sequence[Any], by: Sequence[Any]) -> tuple[list[Any], list[Any]]:
    """Quotient and remainder."""
    rest, quotient = list(p), [fmpq(0)] * max(len(p) - len(by) + 1, 0)
    for place in reversed(range(len(quotient))):
        quotient[place] = ratio = ground.tidy(rest[place + len(by) - 1] / by[-1])
        for i, c in enumerate(by[:-1]):
            rest[place + i] = ground.tidy(rest[place + i] - ratio * c)
        del rest[place + len(by) - 1]
    return quotient, _trimmed(ground, rest)


def _common(ground: Ground, p: list[Any], q: list[Any]) -> list[Any]:
    """The greatest common divisor, monic, by Euclid's algorithm."""
    while q:
        p, q = q, _divided(ground, p, q)[1]
    return [ground.tidy(c / p[-1]) for c in p[:-1]] + [fmpq(1)]


def _hurwitz_over(ground: Ground, p: Sequence[Any]) -> bool:
    """As `_hurwitz`."""
    rows = list(reversed(_trimmed(ground, p)))
    here, following = rows[::2], rows[1::2]
    while following:
        if ground.sign(following[0]) * ground.sign(here[0]) <= 0:
            return False
        ratio = here[0] / following[0]
        padded = [*following[1:], fmpq(0)][: len(here) - 1]
        rest = [x - ratio * y for x, y in zip(here[1:], padded, strict=True)]
        here, following = following, [ground.tidy(c) for c in rest]
    return True
