"""Characteristic polynomials in balls: structure, proved verdicts, what crosses at a boundary."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import lru_cache
from threading import RLock
from typing import Any

from flint import arb, arb_mat, ctx, fmpq_poly

from .algebra import balls
from .enclosure import ball_unknowns, matrix_polynomial
from .errors import StabilityError
from .families import Family

SAMPLES = 3
"""Random members at which the structure of a spectrum is established."""
SAMPLE_BITS = 400
"""Precision there; a coefficient that vanishes to this many bits at every sample is structural."""


ROUGH = 1e-6
"""Largest rate of a sampled member that is held, not solved for, and counts as steady."""
_PRECISION = RLock()


@dataclass(frozen=True)
class Structure:
    """What a family's characteristic polynomial has by structure, not by its point."""

    zeros: int
    """Multiplicity of the factor λ over the rational functions of the parameters."""
    even: bool
    """Whether the rest is even in λ."""
    how: str
    """A sentence that says how it was established."""
    steady: bool
    """Whether the sampled members are steady motions; if not, the count says nothing of others."""


@contextmanager
def precision(bits: int) -> Iterator[None]:
    """Work in balls of so many bits, and put the precision back.

    Parameters
    ----------
    bits
        Working precision.

    Examples
    --------
    >>> from flint import arb
    >>> with precision(200):
    ...     print((arb(1) / 3).rel_accuracy_bits() > 190)
    True
    """
    with _PRECISION:  # one precision for the whole process: threads take turns
        before = ctx.prec
        ctx.prec = bits
        try:
            yield
        finally:
            ctx.prec = before


def characteristic(family: Family, a: Sequence[Any], q: Sequence[Any]) -> list[Any]:
    """Coefficients of det(λ - A) at a member as balls, lowest first.

    Parameters
    ----------
    family
        The family.
    a, q
        Family parameters and parameters as balls (or exact numbers).

    Returns
    -------
    list of arb
        n + 1 coefficients, structural zeros included.

    Raises
    ------
    NoMemberError
        If no root is proved to exist there.
    """
    return matrix_polynomial(family, a, ball_unknowns(family, a, q), q)


@lru_cache(maxsize=64)
def structure(family: Family) -> Structure:
    """The structural zeros of a family's spectrum, established once.

    Coefficients of the characteristic polynomial are analytic in the parameters, so one that
    vanishes identically vanishes at random members, and one that does not is proved nonzero at
    almost any of them.  For the disk the count is derived exactly over Q(k, mu, at) in
    tests/test_structure.py.

    Parameters
    ----------
    family
        The family; its `typical` sizes say where to sample.

    Returns
    -------
    Structure

    Raises
    ------
    StabilityError
        If the family is called conservative but its polynomial is not even.

    Examples
    --------
    >>> from stability.steady import disk_family
    >>> structure(disk_family("rolling", "viscous")).zeros
    2
    """
    vanishing, steady = [True] * (len(family.system.states) + 1), True
    for sample in range(SAMPLES):
        found, rests = _vanishing(family, sample)
        steady = steady and rests
        vanishing = [v and f for v, f in zip(vanishing, found, strict=True)]
    zeros = vanishing.index(False)
    rest = vanishing[zeros:]
    even = all(rest[1::2]) and len(rest) > 1
    if family.conservative and not even:
        raise StabilityError(
            f"family {family.name} is called conservative, but its characteristic polynomial is "
            "not even in λ; leave conservative out."
        )
    how = (
        f"vanishing to {SAMPLE_BITS // 2} bits at {SAMPLES} random members, the next proved nonzero"
    )
    return Structure(zeros, even, how, steady)


def _vanishing(family: Family, sample: int) -> tuple[list[bool], bool]:
    """Which coefficients vanish to 200 bits at a random member, and whether its rates vanish.

    Large entries take more bits.  Held values may be rounded: rates vanish to a few digits only.
    """
    names = (*family.at, *family.parameters)
    cut, least = len(family.at), 2.0 ** (-SAMPLE_BITS // 2)
    for bits in (SAMPLE_BITS, 4 * SAMPLE_BITS, 16 * SAMPLE_BITS):
        with precision(SAMPLE_BITS):
            # Incommensurable factors near 1, away from every special value.
            spread = [arb(2 + 7 * sample + 3 * i).sqrt() for i in range(len(names))]
            factor = [1 + (s - s.floor()) / 4 - arb(1) / 8 for s in spread]
            point = [
                (arb(family.typical.get(n, 1.0)) * f).mid()
                for n, f in zip(names, factor, strict=True)
            ]
        with precision(bits):
            a, q = point[:cut], point[cut:]
            u = ball_unknowns(family, a, q)
            found = matrix_polynomial(family, a, u, q)
            rates = family.graph.rates.dense(balls(), [a, u, q])
        near = [bool(c.contains(0)) for c in found]
        small = [float(c.abs_upper()) < least for c in found]
        if all(s for s, n in zip(small, near, strict=True) if n):
            break
    solved = family.unknown and not family.closed  # another root may be as close as one likes
    rests = [
        arb(rate).contains(0) if solved else arb(rate).abs_lower() < ROUGH for (rate,) in rates
    ]
    return [n and s for n, s in zip(near, small, strict=True)], all(rests)


def verdict_polynomial(coefficients: Sequence[Any], zeros: int, conservative: bool) -> list[Any]:
    """The polynomial whose Hurwitz stability is the verdict, lowest coefficient first.

    For a dissipative law it is the reduced characteristic polynomial.  For a conservative one,
    q(λ²), it is q(λ²) + λ q'(λ²): Hurwitz exactly when all λ² are real, negative and simple.

    Parameters
    ----------
    coefficients
        Of det(λ - A), lowest first.
    zeros
        Structural zeros.
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
    roots in Re ≤ 0 is a limit of stable ones, so its Hurwitz determinants are ≥ 0: one that is
    proved negative proves a root in Re > 0.)

    Examples
    --------
    >>> from flint import arb
    >>> hurwitz_sign([arb(1), arb(2), arb(1)]), hurwitz_sign([arb(-1), arb(2), arb(1)])
    (1, -1)
    """
    if any(c < 0 for c in polynomial):
        return -1
    high = list(reversed(polynomial))
    upper, lower = high[0::2], high[1::2]
    while lower:
        if lower[0] < 0:
            return -1
        if not lower[0] > 0:
            return 0
        ratio = upper[0] / lower[0]
        following = [
            u - ratio * low
            for u, low in zip(upper[1:], [*lower[1:], *[0] * len(upper)], strict=False)
        ]
        upper, lower = lower, following
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


def frequency(polynomial: Sequence[Any], *, even: bool = False) -> float:
    """Frequency of the pair on (or next to) the imaginary axis, from the polynomial.

    Parameters
    ----------
    polynomial
        Coefficients as balls, lowest first, of a polynomial with a pair near the axis.
    even
        Whether it is q(λ²) with two squares that meet; every pair is on the axis then, and asked is
        the one that meets another.

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
    with precision(SAMPLE_BITS):
        if even:
            return _meeting(fmpq_poly(exact[::2]))
        roots = [r for r, _ in fmpq_poly(exact).numer().complex_roots() if r.imag != 0]
        off = [(abs(float((r.real / r.imag).mid())), abs(float(r.imag.mid()))) for r in roots]
    return min(off)[1] if off else 0.0


def _meeting(squares: Any) -> float:
    """√-y where two roots y of a polynomial are nearest to each other."""
    roots = [r for r, count in squares.numer().complex_roots() for _ in range(count)]
    best = (math.inf, 0.0)
    for i, y in enumerate(roots):
        for z in roots[:i]:
            middle = float(((y + z) / 2).real.mid())
            if middle < 0:
                best = min(best, (float(abs(y - z).mid()) / -middle, math.sqrt(-middle)))
    return best[1]
