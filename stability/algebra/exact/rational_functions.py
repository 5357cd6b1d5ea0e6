"""Polynomials of one axis over Q, and characteristic polynomials in it.

The second variable of the ring is λ (or σ) in a characteristic polynomial, and the sine of a given
angle in the disk's conditions.  Such a sine is transcendental (Lindemann), so no polynomial over Q
distinguishes the sine from a free variable.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from flint import Ordering, fmpq_mpoly_ctx, fmpq_poly

from .number_fields import NotExact

RING = fmpq_mpoly_ctx.get(("x0", "x1"), Ordering.degrevlex)
"""Q[x, s]: x is the axis.  It is the ring of a `FunctionField` of two names."""


def univariate(p: Any, index: int = 0) -> Any:
    """A polynomial in one variable of its ring as an `fmpq_poly`.

    Parameters
    ----------
    p
        The polynomial; no other variable occurs.
    index
        Index of the variable.

    Examples
    --------
    >>> univariate(RING.gens()[0] ** 2 - 2)
    x^2 + (-2)
    """
    out: dict[int, Any] = {}
    for powers, c in p.terms():
        if any(power for i, power in enumerate(powers) if i != index):
            raise NotExact("a second variable is in it")
        out[int(powers[index])] = c
    return fmpq_poly([out.get(i, 0) for i in range(max(out, default=-1) + 1)])


def multivariate(p: Any) -> Any:
    """An `fmpq_poly` in x as an element of the ring."""
    return RING.from_dict({(i, 0): c for i, c in enumerate(p.coeffs()) if c != 0})


def common_multiple(polynomials: Iterable[Any], one: Any) -> Any:
    """A least common multiple of polynomials of one ring.

    Parameters
    ----------
    polynomials
        None of them zero.
    one
        The polynomial 1 of their ring.

    Examples
    --------
    >>> x = RING.gens()[0]
    >>> common_multiple([x, x * (x + 1)], RING.constant(1))
    x0^2 + x0
    """
    for p in polynomials:
        one = one * (p / one.gcd(p))
    return one


def primitive(coefficients: Sequence[Any]) -> list[Any]:
    """Coefficients without their common factor.

    Parameters
    ----------
    coefficients
        Polynomials of one ring, the last one not zero.

    Examples
    --------
    >>> x = RING.gens()[0]
    >>> primitive([x**2, x])
    [x0, 1]
    """
    content = coefficients[-1]
    for c in coefficients:
        content = content.gcd(c)
    return [c / content for c in coefficients]
