"""Real roots of integer polynomials by halving, also where their sizes differ by 600 decimals.

Flint isolates complex roots by an iteration that starts on a circle.  The iteration needs minutes
for roots of size 1e-614 and of size 1 in one polynomial.  Halving needs one step for each binary
digit between the sizes.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import Any

from flint import acb, arb, ctx, fmpq, fmpz, fmpz_poly

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
    found = []
    if p[0] == 0:
        found.append(arb(0))
        p = fmpz_poly(p.coeffs()[1:])
    for sign in (1, -1):
        mirrored = [int(c) * sign**i for i, c in enumerate(p.coeffs())]
        for low, high in _intervals(tuple(mirrored)):
            found.append(sign * _refined(fmpz_poly(mirrored), low, high))
    return found


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
    found = []
    while waiting:
        q, low, width = waiting.pop()
        if q[0] == 0:
            found.append((low, low))
            q = fmpz_poly(q.coeffs()[1:])
        count = _variations(fmpz_poly(q.coeffs()[::-1])(ONWARD).coeffs())
        if count == 1:
            found.append((low, low + width))
        elif count > 1:
            left = _scaled(q, -1)
            waiting.append((left, low, width / 2))
            waiting.append((left(ONWARD), low + width / 2, width / 2))
    return tuple(found)


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

    Parameters
    ----------
    p
        An `fmpz_poly`, not constant.

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
