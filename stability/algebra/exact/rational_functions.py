"""Rational functions of one axis over Q: exact + - * /, and characteristic polynomials in them.

The second variable of the ring is λ (or σ) in a characteristic polynomial, and the sine of a given
angle in the disk's conditions.  Such a sine is transcendental (Lindemann), so no polynomial over Q
distinguishes the sine from a free variable.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from flint import fmpq, fmpq_mpoly_ctx, fmpq_poly

from .number_fields import Element, NotExact

RING = fmpq_mpoly_ctx.get(("x", "s"), "lex")
"""Q[x, s]: x is the axis."""
MOST_DEGREE = 48
"""Degree in x beyond which a graph is not read in rational functions."""


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
        """One over the quotient."""
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
    x^2 + x
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
    [x, 1]
    """
    content = coefficients[-1]
    for c in coefficients:
        content = content.gcd(c)
    return [c / content for c in coefficients]
