"""Single values of an axis at which the verdict differs from that on both sides.

Where an eigenvalue reaches the imaginary axis while others keep the motion unstable, the verdict
stays.  Where all unstable eigenvalues reach the axis together, as for undamped motions between
damping and driving, the member is neutral there and unstable on both sides.

Source: a polynomial p of degree n has, for every j, a zero within (C(n, j) |p(z) j!/p⁽ʲ⁾(z)|)^(1/j)
of z: the j-th elementary symmetric function of 1/(z - zeros) has C(n, j) terms;
tests/boundary/test_single_points.py.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from math import comb
from typing import Any

import numpy as np
from flint import acb, acb_poly, arb, arb_poly, fmpq

from ..algebra.balls import precision
from ..algebra.exact.real_roots import BITS, MOST_BITS, specialised
from ..base.verdict import Verdict
from .critical import Characteristic, Conditions
from .search import Mark, Search

GUARD = 64
"""Bits beyond those of a root at which conditions are evaluated there."""


def single(found: Search, mark: Mark, proved: Callable[[float], Verdict]) -> Verdict:
    """The verdict at a mark on whose two sides it is the same.

    Parameters
    ----------
    found
        Result of `search`.
    mark
        One of its marks, not a pole.
    proved
        The proved verdict at a double.

    Returns
    -------
    Verdict
        The verdict of both sides where it is proved to hold there too; neutral where neutral is
        proved; otherwise undecided.
    """
    if mark.below > 0:
        # the limit of stable motions with an eigenvalue on the axis
        return Verdict.NEUTRAL
    # as precisely as the search had to be to separate this root from the next
    with precision(max(BITS, min(mark.root.rel_accuracy_bits(), MOST_BITS)) + GUARD):
        if _unstable(found.source, mark.root):
            return Verdict.UNSTABLE
    if isinstance(found.source, Conditions):
        # no condition is proved negative; omitted ones follow only where the others are positive
        neutral = proved(float(mark.value.mid())) is Verdict.NEUTRAL
        return Verdict.NEUTRAL if neutral else Verdict.UNDECIDED
    exact = _rational(found.source, mark.root)
    return Verdict.UNDECIDED if exact is None else found.source.verdict(exact)


def _unstable(source: Conditions | Characteristic, x: Any) -> bool:
    """Whether some eigenvalue with a positive real part is proved in a ball of the variable."""
    if isinstance(source, Conditions):
        sine = source.sine() if source.sine is not None else arb(0)
        return any(_at(p, x, sine) < 0 for _, p in source.critical)
    return any(grows([arb_poly(c)(x) for c in factor]) for factor in source.factors)


def _at(p: Any, x: Any, sine: Any) -> Any:
    return sum((arb(c) * x ** int(i) * sine ** int(j) for (i, j), c in p.terms()), arb(0))


def grows(coefficients: Sequence[Any]) -> bool:
    """Whether a polynomial of balls is proved to have a zero right of the imaginary axis.

    Parameters
    ----------
    coefficients
        Balls, lowest first.

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


def _rational(source: Characteristic, x: Any) -> Any | None:
    """The root as a rational, where it is a short one."""
    with precision(BITS):
        middle = x.mid().fmpq()
    near = Fraction(int(middle.p), int(middle.q)).limit_denominator(10**18)
    exact = fmpq(near.numerator, near.denominator)
    if x.contains(exact) and any(specialised(p, exact).is_zero() for _, p in source.critical):
        return exact
    return None
