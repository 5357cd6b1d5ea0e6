"""Rationals and algebraic numbers, for reading a graph: numbers that are provably zero or not.

Balls enclose a number but never prove that the number is zero.  A double is a rational number, so
a graph of + - * / has rational values at doubles, and algebraic values at roots of polynomials.
Sines, roots and other functions are indeterminates (`stability.algebra.exact.function_field`).
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from math import prod
from typing import Any

from flint import arb, arb_poly, fmpq, fmpq_poly

from ..number_types import Algebra
from ..upright import Upright


class NotExact(ArithmeticError):  # noqa: N818  (internal: never reaches a user)
    """The graph has no value in this field, or the value is too large to compute."""


def rational(value: float) -> Any:
    """The double as an exact rational.

    Examples
    --------
    >>> rational(0.375)
    3/8
    """
    return fmpq(*float(value).as_integer_ratio())


def _constant(value: float) -> Any:
    if not math.isfinite(value):
        raise NotExact("a constant is not finite")
    return rational(value)


def rational_root(x: Any) -> Any:
    """√x where the root is rational."""
    parts = [int(x.p), int(x.q)]
    if parts[0] < 0:
        raise NotExact("the root of a negative number")
    roots = [math.isqrt(n) for n in parts]
    if any(r * r != n for r, n in zip(roots, parts, strict=True)):
        raise NotExact("an irrational root")
    return fmpq(*roots)


def nearest_root(value: Any) -> Any:
    """√value, as a rational where possible, otherwise as a ball."""
    try:
        return rational_root(value)
    except NotExact:
        return arb(value).sqrt()


def _at(point: int, value: int) -> Callable[[Any], Any]:
    """A function with a rational value at one rational point only."""

    def rational(x: Any) -> Any:
        if _is(x, point):
            return fmpq(value)
        raise NotExact("a transcendental value")

    return rational


def _is(x: Any, number: int) -> bool:
    return isinstance(x, (int, fmpq)) and x == number


def _power(x: Any, exponent: Any) -> Any:
    if not isinstance(exponent, (int, fmpq)):
        raise NotExact("an exponent that is not a number")
    number = fmpq(exponent)
    if number.q == 1:
        if abs(int(number.p)) > 64:
            raise NotExact("a high power")
        power = x ** abs(int(number.p))
        return power if number.p >= 0 else 1 / power
    if number.q == 2:
        return _power(_sqrt(x), fmpq(number.p))
    raise NotExact("a power that is not whole")


def _sqrt(x: Any) -> Any:
    return x.sqrt() if isinstance(x, Element) else rational_root(fmpq(x))


def _fabs(x: Any) -> Any:
    return x.fabs() if isinstance(x, Element) else abs(fmpq(x))


RATIONAL_AT = {
    "sin": (0, 0),
    "cos": (0, 1),
    "tan": (0, 0),
    "exp": (0, 1),
    "log": (1, 0),
    "asin": (0, 0),
    "acos": (1, 0),
    "atan": (0, 0),
    "sinh": (0, 0),
    "cosh": (0, 1),
    "tanh": (0, 0),
}
"""Point where each transcendental function is rational, and its value there."""
RATIONAL_TOO = {"expm1": (0, 0), "log1p": (0, 0), "asinh": (0, 0), "acosh": (1, 0), "atanh": (0, 0)}
"""The same of functions that exact numbers know by others."""


def _function(name: str) -> Callable[[Any], Any]:
    here = _at(*RATIONAL_AT[name])

    def exact_value(x: Any) -> Any:
        return x.function(name) if isinstance(x, Element) else here(x)

    return exact_value


EXACT = Algebra(
    "exact",
    _constant,
    {name: _function(name) for name in RATIONAL_AT} | {"sqrt": _sqrt, "fabs": _fabs, "pow": _power},
)
"""Rationals and elements of the fields below: one algebra, since all fields contain Q."""


def exact_upright() -> Algebra:
    """Exact numbers and the right angle."""

    def with_right_angle(name: str) -> Any:
        plain = EXACT.functions[name]
        return lambda x: EXACT.constant(getattr(x, name)()) if isinstance(x, Upright) else plain(x)

    return replace(
        EXACT,
        name="exact, upright",
        functions=EXACT.functions | {n: with_right_angle(n) for n in ("sin", "cos")},
    )


class Element(ABC):
    """A number of a field beyond Q; sum, product, sign and reciprocal define the rest."""

    __slots__ = ()
    __hash__ = None  # type: ignore[assignment]

    @abstractmethod
    def __add__(self, other: Any) -> Any: ...

    @abstractmethod
    def __mul__(self, other: Any) -> Any: ...

    @abstractmethod
    def __neg__(self) -> Any: ...

    @abstractmethod
    def reciprocal(self) -> Any:
        """One over the number."""

    @abstractmethod
    def plain(self) -> Any:
        """The number as a rational; `NotExact` where the number is not rational."""

    def __radd__(self, other: Any) -> Any:
        return self + other

    def __rmul__(self, other: Any) -> Any:
        return self * other

    def __sub__(self, other: Any) -> Any:
        return self + -other

    def __rsub__(self, other: Any) -> Any:
        return -self + other

    def __truediv__(self, other: Any) -> Any:
        return self * (other.reciprocal() if isinstance(other, Element) else 1 / fmpq(other))

    def __rtruediv__(self, other: Any) -> Any:
        return self.reciprocal() * other

    def __pow__(self, power: int) -> Any:
        return prod([self] * power, start=fmpq(1))

    def sqrt(self) -> Any:
        """The square root, where it is rational."""
        return rational_root(self.plain())

    def fabs(self) -> Any:
        """The absolute value, where the number is rational."""
        return abs(self.plain())

    def function(self, name: str) -> Any:
        """A transcendental function, where it is rational."""
        return EXACT.functions[name](self.plain())


class Algebraic(Element):
    """An element of Q[u]/(g) for an irreducible g, at the root of g that a ball holds.

    Parameters
    ----------
    field
        The number field.
    poly
        `fmpq_poly` in u, of smaller degree than g.
    """

    __slots__ = ("field", "poly")

    def __init__(self, field: NumberField, poly: Any) -> None:
        self.field, self.poly = field, poly

    def _other(self, other: Any) -> Any:
        if isinstance(other, Algebraic):
            return other.poly
        return fmpq_poly([fmpq(other)])

    def __add__(self, other: Any) -> Algebraic:
        return Algebraic(self.field, self.poly + self._other(other))

    def __mul__(self, other: Any) -> Algebraic:
        return Algebraic(self.field, self.field.reduced(self.poly * self._other(other)))

    def __neg__(self) -> Algebraic:
        return Algebraic(self.field, -self.poly)

    def __eq__(self, other: object) -> bool:
        return bool(self.poly == self._other(other))

    __hash__ = None

    def reciprocal(self) -> Algebraic:
        """One over the number, by Euclid's algorithm with g."""
        return Algebraic(self.field, self.field.inverse(self.poly))

    def fabs(self) -> Any:
        """The absolute value, with the sign from the ball of the root."""
        value = arb_poly(self.poly)(self.field.root)
        if value > 0:
            return self
        if value < 0:
            return -self
        if self.poly == 0:
            return fmpq(0)
        raise NotExact("a sign that the ball of the root leaves open")

    def plain(self) -> Any:
        """The number as a rational."""
        if self.poly.degree() > 0:
            raise NotExact("a function of an algebraic number")
        return self.poly[0]


class NumberField:
    """Q[u]/(g): a root u of an irreducible polynomial.

    Parameters
    ----------
    modulus
        g, an `fmpq_poly` irreducible over Q.
    root
        Ball that holds the root u, and no other root of g.
    """

    def __init__(self, modulus: Any, root: Any) -> None:
        self.modulus, self.root = modulus, root

    @property
    def generator(self) -> Algebraic:
        """The root as an element."""
        return Algebraic(self, self.reduced(fmpq_poly([0, 1])))

    def reduced(self, poly: Any) -> Any:
        """The remainder modulo g."""
        return poly % self.modulus

    def inverse(self, poly: Any) -> Any:
        """1/poly modulo g."""
        if poly == 0:
            raise NotExact("a division by zero")
        divisor, factor, _ = poly.xgcd(self.modulus)
        return factor / divisor[0]


def characteristic(matrix: Sequence[Sequence[Any]]) -> list[Any]:
    """Coefficients of det(λ - A), lowest first, over any commutative ring (Berkowitz).

    Source: S. J. Berkowitz, Inf. Process. Lett. 18 (1984) 147-150; no division takes place.

    Examples
    --------
    >>> characteristic([[1, 2], [3, 4]])
    [-2, -5, 1]
    """
    rows = [{j: v for j, v in enumerate(row) if not _is(v, 0)} for row in matrix]
    poly: list[Any] = [1]  # highest first, of the leading principal block so far
    for size, row in enumerate(rows):
        column = {i: rows[i][size] for i in range(size) if size in rows[i]}
        band: list[Any] = [1, -matrix[size][size]]
        for _ in range(size):
            band.append(-_dot(row, column))
            column = {i: v for i in range(size) if not _is(v := _dot(rows[i], column), 0)}
        poly = [
            _sum(
                band[i - j] * poly[j]
                for j in range(len(poly))
                if 0 <= i - j < len(band) and not _is(band[i - j], 0)
            )
            for i in range(size + 2)
        ]
    return poly[::-1]


def _dot(row: dict[int, Any], column: dict[int, Any]) -> Any:
    """Product of a row and a column by their entries other than zero."""
    return _sum(row[j] * v for j, v in column.items() if j in row)


def _sum(terms: Iterable[Any]) -> Any:
    total: Any = 0
    for term in terms:
        if not _is(term, 0):
            total = term if _is(total, 0) else total + term
    return total


def vanishes(value: Any) -> bool:
    """Whether an element is zero: exactly, or identically in the indeterminates."""
    return bool(value == 0)
