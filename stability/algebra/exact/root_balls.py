"""Every root of a polynomial as a ball: exactly isolated, or in clusters of a known count."""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import suppress
from typing import Any

import numpy as np
from flint import acb, acb_poly, arb, ctx, fmpq_poly

from ..balls import precision
from .isolation import MOST_FACTORED, factored_roots, height
from .routh import split, squares

FAR_BITS = 1800
"""Bits of a coefficient above which roots of one irreducible factor may be too near to isolate."""
CLUSTER_BITS = 1024
"""Precision at which such roots are isolated, or else enclosed in clusters."""
STARTS = (0.0, 0.3711, -0.5873)
"""Centres of further attempts to isolate the roots of a monic polynomial, over their mean size."""

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
        found = isolated(balls, even=False)
        if found is None:
            found = clustered([*balls[:-1], arb(1)])
    return found


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
    found = _separated(balls)
    if found is None:
        return None
    # conjugates are roots too: if a ball's mirror image meets it and no other, its root is real
    for i, r in enumerate(found):
        others = (s for j, s in enumerate(found) if j != i)
        if r.imag.contains(0) and any(r.conjugate().overlaps(s) for s in others):
            return None
    real = [acb(r.real) if r.imag.contains(0) else r for r in found]
    if even:
        return [root for square in real for root in _both(square)] if _clear(real) else None
    upper = [r for r in real if r.imag > 0]
    return [r for r in real if r.imag == 0] + [w for r in upper for w in (r, r.conjugate())]


def _separated(balls: Balls) -> Balls | None:
    """Roots in balls that do not meet, from one of a few starts; None where there are none.

    The iteration starts at fixed numbers and has few steps: now and then it ends too early, also
    for roots that are far apart.  For the monic polynomial or about another centre it differs.
    """
    tolerance = arb(2) ** (-3 * ctx.prec // 4)
    with suppress(ValueError):
        found: Balls = acb_poly(balls).roots(tol=tolerance)
        return found
    size = float(abs(balls[0] / balls[-1]).mid()) ** (1 / max(len(balls) - 1, 1))
    near = arb(size) if 0 < size < math.inf else arb(1)
    monic = acb_poly([c / balls[-1] for c in balls])
    for centre in (share * near for share in STARTS):
        with suppress(ValueError):
            return [r + centre for r in monic(acb_poly([centre, 1])).roots(tol=tolerance)]
    return None


def _clear(squares: Balls) -> bool:
    return not any(y.contains(0) for y in squares)


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
