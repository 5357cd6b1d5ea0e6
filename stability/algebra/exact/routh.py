"""Polynomials and the imaginary axis: Routh's array, exactly or in balls, and roots on the axis.

Over Q all is decided.  Over any other real field the same steps need a proved sign of each number.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import reduce
from itertools import islice, pairwise
from typing import Any, NamedTuple

from flint import arb, arb_mat, fmpq, fmpq_poly

from ...base.verdict import Verdict
from .roots import split, squares


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
        if not _hurwitz(RATIONALS, rest.coeffs()):
            return Verdict.UNSTABLE
        if symmetric.degree() > 0:
            squares = fmpq_poly(symmetric.coeffs()[::2])
            plain = squares / squares.gcd(squares.derivative())
            if not _negative_roots(RATIONALS, plain.coeffs()):
                return Verdict.UNSTABLE
    return Verdict.NEUTRAL if neutral else Verdict.STABLE


def unstable_roots(p: Any) -> int:
    """Number of roots with a positive real part, with multiplicities.

    Parameters
    ----------
    p
        An `fmpq_poly`, not zero.

    Source: Routh-Hurwitz theorem, F. R. Gantmacher, The Theory of Matrices, vol. 2, ch. XV § 3,
    with the Cauchy index by Sturm's chain.

    Examples
    --------
    >>> unstable_roots(fmpq_poly([-1, 0, 1]) * fmpq_poly([5, -2, 1]) ** 2)
    5
    """
    _, symmetric, rest = split(p)
    # of ±√y one is unstable, unless both are on the axis
    count = sum(m for y, m in squares(symmetric) if not (y.imag == 0 and y.real < 0))
    turned = [(-1) ** (i // 2) * c for i, c in enumerate(rest.coeffs())]  # the polynomial at iω
    parts = [fmpq_poly([c if i % 2 == k else 0 for i, c in enumerate(turned)]) for k in (0, 1)]
    degree = rest.degree()
    chain = [parts[degree % 2], parts[1 - degree % 2] * (-1) ** (degree + 1)]
    while chain[-1] != 0:
        chain.append(-(chain[-2] % chain[-1]))
    leading = [f[f.degree()] for f in chain[:-1]]
    behind = [c * (-1) ** f.degree() for c, f in zip(leading, chain[:-1], strict=True)]
    index = _variations(behind) - _variations(leading)  # stable roots, less the unstable ones
    return int(count + (degree - index) // 2)


def _variations(numbers: Sequence[Any]) -> int:
    return sum(a * b < 0 for a, b in pairwise(numbers))


def _sign(number: Any) -> int:
    return int(number > 0) - int(number < 0)


def is_even(coefficients: Sequence[Any]) -> bool:
    """Whether a polynomial has even powers alone.

    Parameters
    ----------
    coefficients
        Coefficients of any number type, lowest first; only an exact zero equals 0.
    """
    return len(coefficients) % 2 == 1 and all(c == 0 for c in coefficients[1::2])


def monic(coefficients: Sequence[Any]) -> list[Any]:
    """A polynomial in balls over its leading coefficient, which is then exactly 1."""
    lead = arb(coefficients[-1])
    return [arb(c) / lead for c in coefficients[:-1]] + [arb(1)]


def divided(p: Sequence[Any], by: Sequence[Any]) -> list[Any]:
    """Quotient of polynomials in balls by a monic divisor, whose remainder is zero."""
    rest, size, out = list(p), len(by) - 1, []
    for k in range(len(rest) - 1, size - 1, -1):  # highest power first
        lead = rest[k]
        out.append(lead)
        for j in range(size):
            rest[k - size + j] = rest[k - size + j] - lead * by[j]
    return out[::-1]


def least_sign(signs: Sequence[int]) -> int:
    """-1 where one of some signs is negative, 1 where all are positive, otherwise 0."""
    return -1 if -1 in signs else int(0 not in signs)


class Ground(NamedTuple):
    """A real field by what proofs need of it."""

    sign: Callable[[Any], int]
    """Proved sign of a number: 1, -1, or 0 where it is zero; `NotExact` where none is proved."""
    tidy: Callable[[Any], Any]
    """The number in a form that does not grow."""


RATIONALS = Ground(_sign, lambda number: number)


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
    if not _hurwitz(ground, _trimmed(ground, _mixed(*parts))):
        return Verdict.UNSTABLE
    if len(common) > 1:  # a polynomial in λ²
        plain = _divided(ground, common, _common(ground, common, _slope(common)))[0]
        if not _negative_roots(ground, plain):
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


def _slope(p: Sequence[Any]) -> list[Any]:
    return [i * c for i, c in enumerate(p)][1:]


def _negative_roots(ground: Ground, plain: Sequence[Any]) -> bool:
    """Whether all roots of a polynomial without multiple roots are real and negative.

    Source: Hermite-Biehler, for q(λ²) + λ q'(λ²).
    """
    return _hurwitz(ground, _trimmed(ground, _mixed(plain, _slope(plain))))


def _hurwitz(ground: Ground, p: Sequence[Any]) -> bool:
    """Whether all roots lie in the open left half-plane; the leading coefficient is not zero."""
    column = routh(p, ground.tidy)
    first = ground.sign(next(column))
    return all(ground.sign(number) == first for number in column)


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


def times(p: Sequence[Any], q: Sequence[Any]) -> list[Any]:
    """Product of two polynomials over any ring, by powers.

    Examples
    --------
    >>> times([1, 1], [-1, 1])
    [-1, 0, 1]
    """
    out: list[Any] = [0] * (len(p) + len(q) - 1)
    for i, x in enumerate(p):
        for j, y in enumerate(q):
            out[i + j] = out[i + j] + x * y
    return out


def product(factors: Sequence[Sequence[Any]]) -> list[Any]:
    """The monic multiple of a product of polynomials, as balls.

    Parameters
    ----------
    factors
        Coefficients of each factor, lowest first; the last one is not zero.
    """
    return monic(reduce(times, ([arb(c) for c in factor] for factor in factors), [arb(1)]))


def routh(
    polynomial: Sequence[Any], tidy: Callable[[Any], Any] = lambda number: number
) -> Iterator[Any]:
    """First column of Routh's array, over any number type: all positive for a Hurwitz polynomial.

    Parameters
    ----------
    polynomial
        Coefficients, lowest first, leading one positive.
    tidy
        Function that writes a number in a form that does not grow.

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
        following = [tidy(u - ratio * low) for u, low in zip(upper[1:], padded, strict=False)]
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


def sign_changes(polynomial: Sequence[Any]) -> int | None:
    """Number of roots with a positive real part, by Routh's array in balls.

    Parameters
    ----------
    polynomial
        Coefficients as balls, lowest first.

    Returns
    -------
    int or None
        None where a number of the first column is not proved to differ from zero.

    Examples
    --------
    >>> sign_changes([arb(5), arb(-2), arb(1)]), sign_changes([arb(1), arb(0), arb(1)])
    (2, None)
    """
    signs = [_sign(number) for number in routh(polynomial)]
    return None if 0 in signs or len(signs) < len(polynomial) else _variations(signs)


def hurwitz_matrix(polynomial: Sequence[Any], size: int, zero: Any) -> list[list[Any]]:
    """Rows of the matrix whose determinant is the Hurwitz determinant of one order.

    Parameters
    ----------
    polynomial
        Coefficients of any type, lowest first.
    size
        Order of the determinant.
    zero
        Entry beyond the coefficients.

    Examples
    --------
    >>> hurwitz_matrix([1, 2, 3, 4], 3, 0)
    [[3, 1, 0], [4, 2, 0], [0, 3, 1]]
    """
    high = list(reversed(polynomial))

    def entry(i: int, j: int) -> Any:
        index = 2 * (j + 1) - (i + 1)
        return high[index] if 0 <= index < len(high) else zero

    return [[entry(i, j) for j in range(size)] for i in range(size)]


def expanded_determinant(rows: Sequence[Sequence[Any]]) -> Any:
    """A determinant without divisions, by the minors of its last rows; for small matrices.

    Parameters
    ----------
    rows
        Numbers of any type; None for an entry that is zero by structure.

    Examples
    --------
    >>> expanded_determinant(hurwitz_matrix([1, 2, 3, 4], 2, None))
    2
    """
    minors: dict[tuple[int, tuple[int, ...]], Any] = {}

    def minor(row: int, columns: tuple[int, ...]) -> Any:
        if not columns:
            return 1
        if (row, columns) not in minors:
            total: Any = 0
            for place, j in enumerate(columns):
                entry = rows[row][j]
                if entry is not None:
                    term = entry * minor(row + 1, columns[:place] + columns[place + 1 :])
                    total = total - term if place % 2 else total + term
            minors[row, columns] = total
        return minors[row, columns]

    return minor(0, tuple(range(len(rows))))


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
    return arb_mat(hurwitz_matrix(polynomial, degree - 1, arb(0))).det()
