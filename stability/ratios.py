"""Rational functions of one axis over Q: exact + - * /, and characteristic polynomials in them.

The second variable of the ring is λ (or σ) in a characteristic polynomial, and the sine of a given
angle in the disk's conditions: that sine is transcendental (Lindemann), so it is as free as a
variable.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from flint import fmpq, fmpq_mpoly_ctx, fmpq_poly

from .exact_fields import EXACT, Element, NotExact, characteristic, rational
from .families import Family

RING = fmpq_mpoly_ctx.get(("x", "s"), "lex")
"""Q[x, s]: x is the axis."""
MOST_DEGREE = 48
"""Degree in x beyond which a graph is not read in rational functions."""
MOST_WORK = 300_000
"""Degree of what has to be solved, times states, times bits of a coefficient, beyond which it is
not: about ten seconds."""
MOST_STATES = 12
"""States of the largest system whose characteristic polynomial is expanded."""


class Ratio(Element):
    """A quotient of two polynomials in x and s over Q, in lowest terms.

    Parameters
    ----------
    top, bottom
        Elements of `RING`; bottom is not zero.

    Examples
    --------
    >>> x = Ratio(RING.gens()[0])
    >>> print((x * x - 1) / (x - 1))
    x + 1
    """

    __slots__ = ("bottom", "top")

    def __init__(self, top: Any, bottom: Any = 1) -> None:
        bottom = RING.constant(1) if isinstance(bottom, int) else bottom
        if not bottom.is_constant():
            common = top.gcd(bottom)
            top, bottom = top / common, bottom / common
        self.top, self.bottom = top, bottom

    @staticmethod
    def of(value: Any) -> Ratio:
        """A number as a ratio.

        Parameters
        ----------
        value
            A ratio, a rational or an integer.
        """
        return value if isinstance(value, Ratio) else Ratio(RING.constant(fmpq(value)))

    def _checked(self) -> Ratio:
        if self.top.degrees()[0] > MOST_DEGREE or self.bottom.degrees()[0] > MOST_DEGREE:
            raise NotExact("the degree is too high")
        return self

    def __add__(self, other: Any) -> Ratio:
        o = Ratio.of(other)
        return Ratio(self.top * o.bottom + o.top * self.bottom, self.bottom * o.bottom)._checked()

    def __mul__(self, other: Any) -> Ratio:
        o = Ratio.of(other)
        return Ratio(self.top * o.top, self.bottom * o.bottom)._checked()

    def __neg__(self) -> Ratio:
        return Ratio(-self.top, self.bottom)

    def reciprocal(self) -> Ratio:
        """The quotient turned over."""
        if self.top.is_zero():
            raise ZeroDivisionError
        return Ratio(self.bottom, self.top)

    def plain(self) -> Any:
        """The quotient as a rational."""
        if not (self.top.is_constant() and self.bottom.is_constant()):
            raise NotExact("a function of the axis")
        return self.top.leading_coefficient() / self.bottom.leading_coefficient()

    def __str__(self) -> str:
        return f"{self.top}" if self.bottom.is_one() else f"({self.top})/({self.bottom})"


def univariate(p: Any) -> Any:
    """A polynomial of the ring without s as an `fmpq_poly` in x.

    Parameters
    ----------
    p
        An element of `RING`.

    Examples
    --------
    >>> univariate(RING.gens()[0] ** 2 - 2)
    x^2 + (-2)
    """
    out: dict[int, Any] = {}
    for (power, other), c in p.terms():
        if other:
            raise NotExact("a second variable is in it")
        out[int(power)] = c
    return fmpq_poly([out.get(i, 0) for i in range(max(out, default=-1) + 1)])


def multivariate(p: Any) -> Any:
    """An `fmpq_poly` in x as an element of the ring.

    Parameters
    ----------
    p
        The polynomial.
    """
    return RING.from_dict({(i, 0): c for i, c in enumerate(p.coeffs()) if c != 0})


def characteristic_ratios(family: Family, a: Sequence[Any], q: Sequence[Any]) -> tuple[Any, Any]:
    """The characteristic polynomial of a family along an axis, exactly.

    Parameters
    ----------
    family
        A family without equations to solve, or whose guess solves them identically.
    a, q
        Family parameters and parameters: rationals, and ratios in the axis.

    Returns
    -------
    coefficients, denominator
        Of a positive multiple (up to sign) of det(λ - A) by powers of λ, lowest first, without
        common factor; and the polynomial in x at whose zeros an entry of A has no value.  All are
        `fmpq_poly` in x.

    Raises
    ------
    NotExact
        If the graph is not rational in the axis, or too large.
    """
    size = len(family.system.states)
    if size > MOST_STATES or (family.unknown and not family.closed):
        raise NotExact("no closed form")
    u = [rational(v) for v in family.unknown.values()]
    try:
        rows = family.graph.matrix.dense(EXACT, [list(a), u, list(q)])
    except ZeroDivisionError:
        raise NotExact("a denominator vanishes all along the axis") from None
    entries = [[Ratio.of(v) for v in row] for row in rows]
    common = RING.constant(1)
    for row in entries:
        for e in row:
            common = common * (e.bottom / common.gcd(e.bottom))
    below = univariate(common)
    matrix = [[univariate(e.top * (common / e.bottom)) for e in row] for row in entries]
    degree = max(1, below.degree(), *(e.degree() for row in matrix for e in row))
    bits = max(_bits(e) for row in matrix for e in row)
    if degree * size * size * size // 2 * bits > MOST_WORK:
        raise NotExact("the polynomials are too large")
    scaled = [c * below**j for j, c in enumerate(characteristic(matrix))]
    content = scaled[-1]
    for c in scaled:
        content = content.gcd(c)
    return [c / content for c in scaled], below


def _bits(p: Any) -> int:
    longest = [max(int(c.p.height_bits()), int(c.q.height_bits())) for c in p.coeffs()]
    return max(longest, default=0)
