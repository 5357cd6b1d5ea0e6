"""Roots of polynomials as balls: exactly isolated, or in clusters of a known count.

Flint isolates complex roots by an iteration that starts on a circle.  The iteration needs minutes
for roots of size 1e-614 and of size 1 in one polynomial.  Halving needs one step for each binary
digit between the sizes.

Real roots along an axis are isolated over Q, or at a given sine.

Source: F. Johansson, IEEE Trans. Comput. 66 (2017) 1281-1292 (Arb, whose isolation is used).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import lru_cache
from typing import Any

import numpy as np
from flint import acb, acb_poly, arb, arb_poly, ctx, fmpq, fmpq_poly, fmpz, fmpz_poly

from ..number_types import precision
from .rational_functions import univariate

NEAR_BITS = 400
"""Bits of a coefficient above which a polynomial is factored before its roots are sought."""
MOST_FACTORED = 12
"""Largest degree of such a polynomial: factors of long polynomials cost more than they save."""
ONWARD = fmpz_poly([1, 1])
"""x + 1."""


def halved_roots(p: Any) -> list[Any]:
    """Every real root of a polynomial without multiple roots, in balls.

    Parameters
    ----------
    p
        An `fmpz_poly`, squarefree and not zero.

    Returns
    -------
    list of arb
        In no stated order, each to the working precision relative to its size.

    Source: G. E. Collins, A. G. Akritas, Polynomial real root isolation using Descartes' rule of
    signs, Proc. SYMSAC (1976) 272-275.

    Examples
    --------
    >>> [round(float(r), 9) for r in halved_roots(fmpz_poly([-2, 0, 1]))]
    [1.414213562, -1.414213562]
    """
    roots = []
    if p[0] == 0:
        roots.append(arb(0))
        p = fmpz_poly(p.coeffs()[1:])
    for sign in (1, -1):
        mirrored = [int(c) * sign**i for i, c in enumerate(p.coeffs())]
        for low, high in _intervals(tuple(mirrored)):
            roots.append(sign * _refined(fmpz_poly(mirrored), low, high))
    return roots


@lru_cache(maxsize=16)
def _intervals(coefficients: tuple[int, ...]) -> tuple[tuple[Any, Any], ...]:
    """Rational ends of open intervals with one positive root each; two equal ends are a root.

    The intervals do not depend on the working precision, which a search raises step by step.
    """
    p = fmpz_poly(list(coefficients))
    if p.degree() < 1:
        return ()
    top = (
        max(map(_bits, coefficients)) - _bits(coefficients[-1]) + 2
    )  # Cauchy: roots are below 2^top
    waiting = [(_scaled(p, top), fmpq(0), fmpq(2) ** top)]
    intervals = []
    while waiting:
        q, low, width = waiting.pop()
        if q[0] == 0:
            intervals.append((low, low))
            q = fmpz_poly(q.coeffs()[1:])
        count = _variations(fmpz_poly(q.coeffs()[::-1])(ONWARD).coeffs())
        if count == 1:
            intervals.append((low, low + width))
        elif count > 1:
            left = _scaled(q, -1)
            waiting.append((left, low, width / 2))
            waiting.append((left(ONWARD), low + width / 2, width / 2))
    return tuple(intervals)


def _bits(c: int) -> int:
    return abs(c).bit_length()


def _scaled(p: Any, power: int) -> Any:
    """p(2^power x) without its content, which is positive."""
    shifts = [power * i for i in range(p.degree() + 1)]
    least = min(shifts)
    scaled = fmpz_poly([c << (s - least) for c, s in zip(p.coeffs(), shifts, strict=True)])
    return scaled / scaled.content()


def _variations(coefficients: Sequence[Any]) -> int:
    """Number of changes of sign, zeros left out."""
    signs = [c > 0 for c in coefficients if c != 0]
    return sum(a != b for a, b in zip(signs[:-1], signs[1:], strict=True))


def _refined(p: Any, low: Any, high: Any) -> Any:
    """A ball around the one root between two numbers, as narrow as the working precision.

    Source: J. Abbott, Quadratic interval refinement for real roots, ACM Commun. Comput. Algebra 48
    (2014) 3-12: try the part that the chord points at; after a success make the parts finer.
    """
    if low == high:
        return arb(low)
    # an end may be another root; the slope then gives the sign inside
    below = p(low) if p(low) != 0 else p.derivative()(low) * (high - low)
    above = p(high) if p(high) != 0 else p.derivative()(high) * (low - high)
    bits = 1
    while low == 0 or (high - low) * (fmpz(1) << ctx.prec) > low:
        part = (high - low) / (1 << bits)
        chord = below / (below - above) if bits > 1 else fmpq(1, 2)
        left = low + part * min((1 << bits) - 1, (chord * (1 << bits)).floor())
        right = left + part
        at_left = p(left) if left != low else below
        at_right = p(right) if right != high else above
        for place, value in ((left, at_left), (right, at_right)):
            if value == 0:
                return arb(place)
        if (at_left > 0) == (below > 0) and (at_right > 0) == (above > 0):
            low, high, below, above = left, right, at_left, at_right
            bits *= 2
        elif bits > 1:
            bits //= 2
        else:  # the tried half does not hold the root
            low, high, below, above = low, left, below, at_left
    return arb(low).union(arb(high))


def height(p: Any) -> int:
    """Bits of the longest coefficient of an `fmpz_poly`."""
    return max(int(abs(c)).bit_length() for c in p.coeffs())


def factored_roots(p: Any) -> list[tuple[Any, int]]:
    """Every root of a polynomial over Z as (ball, multiplicity), at the current precision.

    Flint's search needs minutes where roots are 2⁻²⁰⁰⁰ apart.  Most such roots belong to different
    factors, or to a factor of degree 2, whose roots need no search.

    Examples
    --------
    >>> from flint import fmpz_poly
    >>> [(float(r.real.mid()), count) for r, count in factored_roots(fmpz_poly([1, 2, 1]))]
    [(-1.0, 2)]
    """
    if p.degree() > MOST_FACTORED or height(p) < NEAR_BITS:
        roots: list[tuple[Any, int]] = p.complex_roots()
        return roots
    return [(root, count) for factor, count in p.factor()[1] for root in _of_factor(factor)]


def _of_factor(p: Any) -> list[Any]:
    """The roots of an irreducible polynomial, by a formula up to degree 2."""
    if p.degree() > 2:
        return [root for root, _ in p.complex_roots()]
    low, middle, *high = (arb(c) for c in p.coeffs())
    if not high:
        return [acb(-low / middle)]
    square = p[1] ** 2 - 4 * p[0] * p[2]
    root = arb(abs(square)).sqrt() / (2 * high[0])
    centre = -middle / (2 * high[0])
    if square > 0:
        return [acb(centre - root), acb(centre + root)]
    return [acb(centre, root), acb(centre, -root)]


FAR_BITS = 1800
"""Bits of a coefficient above which roots of one irreducible factor may be too near to isolate."""
CLUSTER_BITS = 1024
"""Precision at which such roots are isolated, or else enclosed in clusters."""
STARTS = (0.0, 0.3711, -0.5873)
"""Centres of further attempts to isolate the roots of a monic polynomial, over their mean size."""

FAR = 250
"""Bits by which the sizes of roots differ, above which real roots are found by halving."""

Balls = list[Any]


def exact_roots(p: Any) -> Balls:
    """Every root of a polynomial over Q at the current precision, repeated by multiplicity.

    Parameters
    ----------
    p
        An `fmpq_poly`, not zero.

    Returns
    -------
    list of acb
        A root on the imaginary axis has a real part of exactly zero.

    Examples
    --------
    >>> exact_roots(fmpq_poly([4, 0, 1]))
    [2.00000000000000j, -2.00000000000000j]
    """
    zeros, symmetric, rest = split(p)
    out = [acb(0)] * zeros
    for square, count in squares(symmetric):
        out += _both(square) * count
    if rest.degree() > 0:
        out += [root for root, count in factored_roots(rest.numer()) for _ in range(count)]
    return out


def bounded_roots(p: Any) -> Balls:
    """As `exact_roots`; roots that are too near to be separated in seconds are in clusters.

    Parameters
    ----------
    p
        An `fmpq_poly`, not zero.

    Examples
    --------
    >>> near = fmpq_poly([1, 3, 1, 1]) ** 2 - fmpq_poly([2], 2**4000)
    >>> [float(r.real.rad()) > 0 for r in bounded_roots(near)]
    [True, True, True, True, True, True]
    """
    zeros, symmetric, rest = split(p)
    if rest.degree() < 3 or rest.degree() > MOST_FACTORED or height(rest.numer()) < FAR_BITS:
        return exact_roots(p)
    out = exact_roots(p / rest)
    for factor, count in rest.numer().factor()[1]:
        out += _of_long(fmpq_poly(factor)) * count
    return out


def _of_long(factor: Any) -> Balls:
    """Roots of an irreducible polynomial over Q with long coefficients."""
    if factor.degree() < 3 or height(factor.numer()) < FAR_BITS:
        return exact_roots(factor)
    with precision(CLUSTER_BITS):
        balls = [arb(c / factor[factor.degree()]) for c in factor.coeffs()]
        roots = isolated(balls, even=False)
        if roots is None:
            roots = clustered([*balls[:-1], arb(1)])
    return roots


def _both(square: Any) -> Balls:
    """±√y, exactly real or imaginary where y is real."""
    if square.imag == 0 and square.real < 0:
        root = acb(0, (-square.real).sqrt())
    else:
        root = acb(square.real.sqrt()) if square.imag == 0 else square.sqrt()
    return [root, -root]


def isolated(coefficients: Balls, even: bool) -> Balls | None:
    """Roots of a polynomial whose coefficients are balls; None where the roots are not separated.

    Parameters
    ----------
    coefficients
        Balls, lowest first.
    even
        Whether the odd coefficients are zero.
    """
    balls = [arb(c) for c in (coefficients[::2] if even else coefficients)]
    if balls[-1].contains(0):
        return None
    separated = _separated(balls)
    if separated is None:
        return None
    # conjugates are roots too: if a ball's mirror image meets it and no other, its root is real
    for i, r in enumerate(separated):
        others = (s for j, s in enumerate(separated) if j != i)
        if r.imag.contains(0) and any(r.conjugate().overlaps(s) for s in others):
            return None
    real = [acb(r.real) if r.imag.contains(0) else r for r in separated]
    if even:
        clear = not any(square.contains(0) for square in real)
        return [root for square in real for root in _both(square)] if clear else None
    upper = [r for r in real if r.imag > 0]
    return [r for r in real if r.imag == 0] + [w for r in upper for w in (r, r.conjugate())]


def _separated(balls: Balls) -> Balls | None:
    """Roots in balls that do not meet, from one of a few starts; None where there are none.

    The iteration starts at fixed numbers and has few steps: now and then it ends too early, also
    for roots that are far apart.  For the monic polynomial or about another centre it differs.
    """
    tolerance = arb(2) ** (-3 * ctx.prec // 4)
    with suppress(ValueError):
        roots: Balls = acb_poly(balls).roots(tol=tolerance)
        return roots
    size = float(abs(balls[0] / balls[-1]).mid()) ** (1 / max(len(balls) - 1, 1))
    near = arb(size) if 0 < size < math.inf else arb(1)
    monic = acb_poly([c / balls[-1] for c in balls])
    for centre in (share * near for share in STARTS):
        with suppress(ValueError):
            return [r + centre for r in monic(acb_poly([centre, 1])).roots(tol=tolerance)]
    return None


def clustered(coefficients: Sequence[Any]) -> Balls:
    """Balls that hold the roots of a monic polynomial, also where some coincide.

    The roots of the polynomial at the midpoints are isolated exactly.  A root of any polynomial
    within the balls is at most ρ from one of these roots, with ρⁿ the largest change of the value.
    Each cluster of overlapping discs holds as many roots as discs.

    Parameters
    ----------
    coefficients
        Balls, lowest first, the last one exactly 1.

    Returns
    -------
    list of acb

    Source: continuity of roots, A. M. Ostrowski, Solution of Equations in Euclidean and Banach
    Spaces, 3rd ed. (1973), appendix A.
    """
    from scipy.sparse.csgraph import connected_components

    degree = len(coefficients) - 1
    middle = fmpq_poly([c.mid().fmpq() for c in coefficients])
    roots = exact_roots(middle)
    bound = 1 + max(abs(c).abs_upper() for c in coefficients)  # Cauchy: no root is larger
    change = arb(0)
    for power, c in enumerate(coefficients):
        change += c.rad() * bound**power
    reach = change.root(degree).abs_upper() if change > 0 else arb(0)
    touching = np.array([[not abs(r - s) > 2 * reach for s in roots] for r in roots])
    _, labels = connected_components(touching, directed=False)
    out = []
    for root, label in zip(roots, labels, strict=True):
        wide = (2 * int((labels == label).sum()) * reach).abs_upper()
        out.append(acb(root.real + arb(0, wide), root.imag + arb(0, wide)) if reach != 0 else root)
    return out


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
        roots = []
        for factor, count in whole.factor_squarefree()[1]:
            real = halved_roots(factor)
            if len(real) < factor.degree():
                break
            roots += [(acb(root), count) for root in real]
        else:
            return roots
    return factored_roots(whole)


def _spread(p: Any) -> float:
    """Bound on the ratio of the largest and the smallest root, in bits."""
    bits = [int(abs(c)).bit_length() for c in p.coeffs()]
    size = len(bits) - 1
    high = max((b - bits[-1] + 1) / (size - i) for i, b in enumerate(bits[:-1]) if b)
    low = min((bits[0] - b - 1) / i for i, b in enumerate(bits) if i and b)
    return high - low


BITS = 256
"""Working precision of the first attempt."""
MOST_BITS = 16384
"""Largest working precision."""
WIDE = 2000
"""Binary digits of a coefficient above which real roots are isolated by halving."""


class UnclearError(ArithmeticError):
    """The precision does not separate two numbers."""


def complex_roots(p: Any) -> list[Any]:
    """Isolated roots with multiplicities of an `fmpq_poly`; an empty list for a constant.

    Parameters
    ----------
    p
        The polynomial, not zero.
    """
    if p.degree() < 1:
        return []
    roots: list[Any] = p.numer().complex_roots()
    return roots


def specialised(p: Any, x: Any) -> Any:
    """An element of the ring at one x, as a polynomial in its second variable.

    Parameters
    ----------
    p
        Element of `RING`, in x and s.
    x
        Value of the axis, a rational.
    """
    return univariate(p.subs({0: x}), 1)


def sign_at(p: Any, x: Any, sine: Callable[[], Any] | None) -> int:
    """Sign of a polynomial at a rational x and the given sine.

    Parameters
    ----------
    p
        Polynomial in x and s.
    x
        Value of the axis, a rational.
    sine
        Function that returns the ball of s at the working precision; None without s.  The sine
        is transcendental, so that only a polynomial that vanishes for every s is zero.

    Raises
    ------
    UnclearError
        If the budget of precision ends.
    """
    value = specialised(p, x)
    if value.degree() < 1:
        exact = value[0]
        return int(exact > 0) - int(exact < 0)
    assert sine is not None
    bits = BITS
    while bits <= MOST_BITS:
        with precision(bits):
            ball = arb_poly(value)(sine())
            if not ball.contains(0):
                return 1 if ball > 0 else -1
        bits *= 2
    raise UnclearError


def real_roots(polynomials: Sequence[Any], sine: Callable[[], Any] | None) -> list[Any]:
    """Every distinct real root in x of some polynomials, in balls that do not overlap.

    Parameters
    ----------
    polynomials
        Polynomials in x and perhaps s, none zero.
    sine
        As for `sign_at`.

    Returns
    -------
    list of arb
        In increasing order, at the working precision.

    Raises
    ------
    UnclearError
        If the working precision does not separate the roots.

    Examples
    --------
    >>> from stability.algebra.exact.rational_functions import RING
    >>> x = RING.gens()[0]
    >>> [float(r) for r in real_roots([x**2 - 4, (x - 2) ** 2 * (x**2 + 1)], None)]
    [-2.0, 2.0]
    """
    apart: list[Any] = []  # squarefree, no two with a common root
    for p in polynomials:
        slope = p.derivative(0)
        if slope.is_zero():
            continue
        rest = p / p.gcd(slope)
        for other in apart:
            rest = rest / rest.gcd(other)
        if not rest.derivative(0).is_zero():
            apart.append(rest)
    roots: list[Any] = []
    for p in apart:  # one by one: nearly equal roots of two polynomials are slow to separate
        if p.degrees()[1] == 0:
            roots += _rational_roots(univariate(p).numer())
        else:
            assert sine is not None
            roots += _ball_roots(p, sine())
    roots.sort(key=lambda r: r.mid())
    if any(not low < high for low, high in zip(roots[:-1], roots[1:], strict=True)):
        raise UnclearError
    return roots


def _rational_roots(p: Any) -> list[Any]:
    """Real roots of a squarefree polynomial over Z."""
    if max(abs(int(c)).bit_length() for c in p.coeffs()) > WIDE:
        return halved_roots(p)
    return [r.real for r, _ in p.complex_roots() if r.imag == 0]


def _ball_roots(product: Any, sine: Any) -> list[Any]:
    """Real roots of a squarefree polynomial whose coefficients are polynomials in the sine."""
    rows: dict[int, list[Any]] = {}
    for (i, j), c in product.terms():
        row = rows.setdefault(int(i), [])
        row += [arb(0)] * (int(j) + 1 - len(row))
        row[int(j)] = arb(c)
    coefficients = [arb_poly(rows.get(i, []))(sine) for i in range(max(rows) + 1)]
    roots = isolated(coefficients, even=False)
    if roots is None:
        raise UnclearError
    return [r.real for r in roots if r.imag == 0]
