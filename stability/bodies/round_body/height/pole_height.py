"""The height by cos θ and sin θ, and by cos θ alone where the body is smooth at a pole.

A height is smooth at θ = 0 and π if it is a smooth function of c = cos θ.  Its graph is read over
numbers p + q sinθ, where p and q are functions of c and sin²θ is 1 - c².  The height is one of c
alone where q vanishes in the end.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import casadi as ca

from ....algebra.number_types import MORE, UNARY, Algebra
from ....algebra.program import Program
from ....base.errors import StabilityError
from .expression import ShapeFunction


class NotSmoothError(StabilityError):
    """A height that is no function of cos θ alone, as far as its graph shows."""


class Inclination:
    """A whole multiple n θ of the inclination.

    Parameters
    ----------
    cosine
        Symbol of cos θ.
    times
        The whole number n.
    multiples
        cos nθ and sin nθ / sinθ for n = 0, 1, …, as far as they are known, which all multiples of
        one angle share: a series of n terms has n of them.
    """

    def __init__(
        self, cosine: ca.SX, times: int = 1, multiples: list[tuple[ca.SX, ca.SX]] | None = None
    ) -> None:
        self.cosine, self.times = cosine, times
        self.multiples = (
            [(ca.SX(1), ca.SX(0)), (cosine, ca.SX(1))] if multiples is None else multiples
        )

    def _times(self, times: int) -> Inclination:
        return Inclination(self.cosine, times, self.multiples)

    def __mul__(self, other: Any) -> Inclination:
        value = other.even if isinstance(other, InCosine) else other
        if isinstance(value, ca.SX) and value.is_constant() and float(value).is_integer():
            return self._times(self.times * int(float(value)))
        raise NotSmoothError("theta stands outside sines and cosines of its whole multiples")

    __rmul__ = __mul__

    def __add__(self, other: Any) -> Inclination:
        if isinstance(other, Inclination):
            return self._times(self.times + other.times)
        raise NotSmoothError("theta stands outside sines and cosines of its whole multiples")

    def __neg__(self) -> Inclination:
        return self._times(-self.times)

    def wave(self) -> tuple[InCosine, InCosine]:
        """Cosine and sine, by the recurrence of Chebyshev's polynomials."""
        c, multiples = self.cosine, self.multiples
        while len(multiples) <= abs(self.times):
            (a, b), (a1, b1) = multiples[-2:]
            multiples.append((2 * c * a1 - a, 2 * c * b1 - b))
        (even, odd), zero = multiples[abs(self.times)], ca.SX(0)
        return InCosine(c, even, zero), InCosine(c, zero, -odd if self.times < 0 else odd)


class InCosine:
    """A number p + q sinθ with p and q functions of cos θ.

    Parameters
    ----------
    cosine
        Symbol of cos θ.
    even, odd
        p and q.
    """

    def __init__(self, cosine: ca.SX, even: ca.SX, odd: ca.SX) -> None:
        self.cosine, self.even, self.odd = cosine, even, odd

    def _of(self, other: Any) -> InCosine:
        if isinstance(other, InCosine):
            return other
        if isinstance(other, Inclination):
            raise NotSmoothError("theta stands outside sines and cosines of its whole multiples")
        return InCosine(self.cosine, ca.SX(other), ca.SX(0))

    def __add__(self, other: Any) -> InCosine:
        b = self._of(other)
        return InCosine(self.cosine, self.even + b.even, self.odd + b.odd)

    __radd__ = __add__

    def __neg__(self) -> InCosine:
        return InCosine(self.cosine, -self.even, -self.odd)

    def __sub__(self, other: Any) -> InCosine:
        b = self._of(other)
        return InCosine(self.cosine, self.even - b.even, self.odd - b.odd)

    def __rsub__(self, other: Any) -> InCosine:
        return self._of(other) - self

    def __mul__(self, other: Any) -> Any:
        if isinstance(other, Inclination):
            return other * self
        b = self._of(other)
        square = 1 - self.cosine * self.cosine
        return InCosine(
            self.cosine,
            self.even * b.even + self.odd * b.odd * square,
            self.even * b.odd + self.odd * b.even,
        )

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> InCosine:
        below = self._of(other).plain()
        return InCosine(self.cosine, self.even / below, self.odd / below)

    def __rtruediv__(self, other: Any) -> InCosine:
        return self._of(other) / self

    def plain(self) -> ca.SX:
        """The number as a function of cos θ alone."""
        if not self.odd.is_zero():
            raise NotSmoothError("a sine of theta is left, without a slope in cos θ at the poles")
        return self.even


def _read(height: ShapeFunction, cosine: ca.SX, symbols: list[ca.SX]) -> InCosine:
    """The height as p + q sinθ; a `NotSmoothError` if its graph is none."""
    zero = ca.SX(0)

    def in_cosine(name: str, *values: Any) -> Any:
        if name in ("sin", "cos") and isinstance(values[0], Inclination):
            return values[0].wave()[name == "sin"]
        if any(isinstance(v, Inclination) for v in values):
            raise NotSmoothError("theta stands outside sines and cosines of its whole multiples")
        plain = [v.plain() if isinstance(v, InCosine) else v for v in values]
        function: Callable[..., Any] = getattr(ca, {"pow": "power"}.get(name, name))
        return InCosine(cosine, function(*plain), zero)

    names = (*UNARY, *MORE, "pow", "atan2", "hypot")
    table: dict[str, Callable[..., Any]] = {name: partial(in_cosine, name) for name in names}
    algebra = Algebra("cosine", lambda v: InCosine(cosine, ca.SX(v), zero), table)
    numbers = [InCosine(cosine, v, zero) for v in symbols]
    arguments: list[list[Any]] = [[Inclination(cosine)], *([n] for n in numbers)]
    try:
        [[result]] = Program(height.function).run(algebra, arguments)
    except KeyError as function:  # such as the absolute value
        raise NotSmoothError(f"the height uses {function}") from None
    return result if isinstance(result, InCosine) else InCosine(cosine, ca.SX(result), zero)


def height_of_cosine(height: ShapeFunction, cosine: ca.SX, symbols: list[ca.SX]) -> ca.SX:
    """The height as an expression in cos θ and the numbers of the shape.

    Parameters
    ----------
    height
        The height as a function of θ and the numbers of the shape.
    cosine
        Symbol of cos θ.
    symbols
        Symbols of the numbers.

    Returns
    -------
    SX

    Raises
    ------
    NotSmoothError
        If the height is not seen to be a function of cos θ alone.

    Examples
    --------
    >>> from .expression import expression
    >>> c = ca.SX.sym("c")
    >>> egg = expression("height", lambda theta: 1 + ca.cos(2 * theta) / 8, ["theta"], 1)
    >>> ca.Function("f", [c], [height_of_cosine(egg, c, [])])(0.5)
    DM(0.9375)
    """
    return _read(height, cosine, symbols).plain()


def height_of_angle(height: ShapeFunction, theta: ca.SX, symbols: list[ca.SX]) -> ca.SX:
    """The height at a symbol θ, with sines and cosines of multiples of θ by those of θ itself.

    So the graph is rational in sin θ and cos θ wherever the height is, and has a value at the exact
    right angle.

    Parameters
    ----------
    height, symbols
        As for `height_of_cosine`.
    theta
        Symbol of θ.

    Returns
    -------
    SX

    Examples
    --------
    >>> from .expression import expression
    >>> t = ca.SX.sym("t")
    >>> egg = expression("height", lambda theta: 1 + ca.cos(2 * theta) / 8, ["theta"], 1)
    >>> f = ca.Function("f", [t], [height_of_angle(egg, t, [])])
    >>> round(float(f(0.3) - ca.cos(0.6) / 8), 15)
    1.0
    """
    cosine = ca.SX.sym("c")
    try:
        waves = _read(height, cosine, symbols)
    except NotSmoothError:
        return ca.SX(height(theta, *symbols))
    even, odd = ca.substitute([waves.even, waves.odd], [cosine], [ca.cos(theta)])
    return even if odd.is_zero() else even + odd * ca.sin(theta)
