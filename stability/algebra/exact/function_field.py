"""Functions of a graph as indeterminates: quotients of polynomials that obey known relations.

An expression that vanishes as a polynomial in its indeterminates vanishes at every point.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import cached_property
from typing import Any

from flint import Ordering, arb, fmpq, fmpq_mpoly_ctx

from ..number_types import Algebra, balls
from .hurwitz_forms import Budget
from .number_fields import EXACT, RATIONAL_AT, Element, NotExact

SPARE = 24
"""Number of indeterminates reserved for sines, roots and other functions, unless said."""
MOST_TERMS = 1500
"""Largest number of terms of a numerator or denominator; beyond it exact work ends."""
MOST_WORK = 1_000_000
"""Largest number of terms that one calculation handles; a count, so that machines agree."""


def counted() -> Budget:
    """Limits by numbers of terms alone."""
    return Budget(MOST_TERMS, math.inf, work=MOST_WORK)


class TooManyFunctions(NotExact):
    """More functions than the field has room for."""

    def __init__(self) -> None:
        super().__init__("too many functions")


class Expression(Element):
    """A quotient of polynomials in indeterminates, reduced by their relations."""

    __slots__ = ("den", "field", "num")

    def __init__(self, field: FunctionField, num: Any, den: Any) -> None:
        self.field, self.num, self.den = field, num, den

    def _other(self, other: Any) -> tuple[Any, Any]:
        if isinstance(other, Expression):
            return other.num, other.den
        return self.field.ring.constant(fmpq(other)), self.field.one

    def __add__(self, other: Any) -> Expression:
        num, den = self._other(other)
        if den == self.den:
            return self.field.quotient(self.num + num, den)
        return self.field.quotient(self.num * den + num * self.den, self.den * den)

    def __neg__(self) -> Expression:
        return Expression(self.field, -self.num, self.den)

    def __mul__(self, other: Any) -> Expression:
        num, den = self._other(other)
        return self.field.quotient(self.num * num, self.den * den)

    def reciprocal(self) -> Expression:
        """One over the quotient."""
        return self.field.quotient(self.den, self.num)

    def __eq__(self, other: object) -> bool:
        difference = self - other
        return bool(difference.num == 0)

    __hash__ = None

    def plain(self) -> Any:
        """The quotient as a rational."""
        if not (self.num.is_constant() and self.den.is_constant()):
            raise NotExact("an expression in indeterminates")
        return (self.num / self.den).leading_coefficient() if self.num != 0 else fmpq(0)

    def sqrt(self) -> Any:
        """The square root: rational, or an indeterminate whose square is known."""
        with suppress(NotExact):
            return super().sqrt()
        # √(num/den) = r/den with r² = num · den; the sign of r is that of den, so that the root of
        # num · den itself is another indeterminate
        square = self.field.reduced(self.num * self.den)
        root = self.field.root("sqrt", square, self.den)
        return root / Expression(self.field, self.den, self.field.one)

    def fabs(self) -> Any:
        """√(x²): rational, or an indeterminate whose square is known and whose sign is not."""
        with suppress(NotExact):
            return super().fabs()
        return self._size(self.num) / self._size(self.den)

    def _size(self, part: Any) -> Expression:
        if part.is_constant():
            return self.field.number(abs(part.leading_coefficient()) if part != 0 else 0)
        return self.field.root("fabs", self.field.reduced(part * part))

    def function(self, name: str) -> Any:
        """The function's value: rational, or an indeterminate with a relation to its partner."""
        with suppress(NotExact):
            return super().function(name)
        return self.field.of_argument(name, self)


_PAIRS = {
    "sin": ("sin", "cos", 1),
    "cos": ("sin", "cos", 1),
    "sinh": ("sinh", "cosh", -1),
    "cosh": ("sinh", "cosh", -1),
}
_QUOTIENTS = {"tan": ("sin", "cos"), "tanh": ("sinh", "cosh")}


def occurring(poly: Any) -> set[int]:
    """Indices of the variables that occur in a polynomial."""
    return {i for i, d in enumerate(poly.degrees()) if d} if poly != 0 else set()


def evaluate(poly: Any, values: Mapping[int, Any]) -> Any:
    """The value of a polynomial at rationals or balls.

    Parameters
    ----------
    poly
        The polynomial.
    values
        Values by index of the variables that occur.
    """
    total: Any = fmpq(0)
    for exponents, c in poly.to_dict().items():
        term: Any = c
        for index, power in enumerate(exponents):
            for _ in range(int(power)):  # python-flint's power of a ball around 0 is nan
                term = values[index] * term
        total = term + total
    return total if isinstance(total, fmpq) else arb(total)


class FunctionField:
    """Quotients of polynomials over Q in named indeterminates and in values of functions.

    Parameters
    ----------
    names
        Names of the indeterminates.
    budget
        Limits of the work; a number of terms when left out, so that all machines agree.
    spare
        Most functions (sines, roots) that are read as indeterminates.
    """

    def __init__(
        self, names: Sequence[str], budget: Budget | None = None, spare: int = SPARE
    ) -> None:
        self.budget = counted() if budget is None else budget
        symbols = tuple(f"x{i}" for i in range(len(names) + spare))
        self.ring = fmpq_mpoly_ctx.get(symbols, Ordering.degrevlex)
        self._gens = self.ring.gens()
        self._used = len(names)
        self.one = self.ring.constant(1)
        self.symbols = [Expression(self, g, self.one) for g in self._gens[: len(names)]]
        """The named indeterminates, in order."""
        self.squares: dict[int, Any] = {}
        """The known square of each indeterminate, by index."""
        self.meaning: dict[int, tuple[str, Expression, Any]] = {}
        """(function, argument, divisor with the same sign or None) by index of indeterminate."""
        self._atoms: dict[tuple[str, str], Any] = {}
        self.integral = True
        """Whether a product of elements that are not zero is never zero: not with √ or |x|."""

    @cached_property
    def algebra(self) -> Algebra:
        """Exact numbers, with an indeterminate where a function of a rational is irrational."""

        def of(name: str) -> Callable[[Any], Any]:
            plain = EXACT.functions[name]

            def value(x: Any) -> Any:
                with suppress(NotExact):
                    return plain(x)
                return plain(x if isinstance(x, Element) else self.number(x))

            return value

        table = {name: of(name) for name in (*RATIONAL_AT, "sqrt")}
        return replace(EXACT, functions=EXACT.functions | table, lasting=False)

    def number(self, value: Any) -> Expression:
        """A rational as an element."""
        return Expression(self, self.ring.constant(fmpq(value)), self.one)

    def quotient(self, num: Any, den: Any) -> Expression:
        """num/den, reduced by the relations and without a common factor."""
        num = self.reduced(num)
        den = den if den.is_constant() else self.reduced(den)
        if den == 0:
            raise NotExact("a division by zero")
        if num == 0:
            return Expression(self, num, self.one)
        if den.is_constant():
            return Expression(self, num if den == 1 else num / den.leading_coefficient(), self.one)
        common = num.gcd(den)
        if not common.is_constant():
            num, den = num / common, den / common
        self.budget.watch(num, den)
        return Expression(self, num, den)

    def reduced(self, poly: Any) -> Any:
        """The normal form: no indeterminate with a known square occurs squared."""
        self.budget.watch(poly)
        for index in sorted(self.squares, reverse=True):
            if poly != 0 and poly.degrees()[index] > 1:
                poly = self._without_squares(poly, index)
                self.budget.watch(poly)
        return poly

    def _without_squares(self, poly: Any, index: int) -> Any:
        parts: dict[int, dict[tuple[int, ...], Any]] = {}
        for exponents, coefficient in poly.to_dict().items():
            half, odd = divmod(int(exponents[index]), 2)
            rest = (*exponents[:index], odd, *exponents[index + 1 :])
            parts.setdefault(half, {})[rest] = coefficient
        out = self.ring.constant(0)
        for half, terms in parts.items():
            out = out + self.ring.from_dict(terms) * self.squares[index] ** half
            self.budget.watch(out)
        return out

    def _new(self, function: str, x: Expression, over: Any = None) -> int:
        if self._used == len(self._gens):
            raise TooManyFunctions
        self._used += 1
        self.meaning[self._used - 1] = function, x, over
        return self._used - 1

    def root(self, kind: str, square: Any, over: Any = None) -> Expression:
        """An indeterminate whose square is a polynomial; `over` has the same sign."""
        key, self.integral = (f"{kind} over {over}", str(square)), False
        if key not in self._atoms:
            index = self._new("sqrt", Expression(self, square, self.one), over)
            self.squares[index] = square
            self._atoms[key] = self._gens[index]
        return Expression(self, self._atoms[key], self.one)

    def of_argument(self, name: str, x: Expression) -> Any:
        """A function at an expression as an indeterminate."""
        if name in _QUOTIENTS:
            over, under = _QUOTIENTS[name]
            return self.of_argument(over, x) / self.of_argument(under, x)
        if name in _PAIRS:
            odd, even, sign = _PAIRS[name]
            turned = x.num.leading_coefficient() < 0  # sin(-x) = -sin x, cos(-x) = cos x
            plain = -x if turned else x
            key = self._name(plain)
            if (odd, key) not in self._atoms:
                first, second = self._new(odd, plain), self._new(even, plain)
                self._atoms[odd, key], self._atoms[even, key] = (
                    self._gens[first],
                    self._gens[second],
                )
                # sin² = 1 - cos², sinh² = cosh² - 1
                self.squares[first] = sign * (1 - self._gens[second] ** 2)
            atom = Expression(self, self._atoms[name, key], self.one)
            return -atom if turned and name == odd else atom
        key = self._name(x)
        if (name, key) not in self._atoms:
            self._atoms[name, key] = self._gens[self._new(name, x)]
        return Expression(self, self._atoms[name, key], self.one)

    @staticmethod
    def _name(x: Expression) -> str:
        return f"{x.num} / {x.den}"

    # --- indeterminates by index ---

    def generator(self, index: int) -> Any:
        """An indeterminate as a polynomial."""
        return self._gens[index]

    def enclosed(self, index: int, values: Mapping[int, Any]) -> Any:
        """A function's indeterminate as a ball, from those that its argument holds."""
        name, x, over = self.meaning[index]
        value = balls().functions[name](arb(evaluate(x.num, values) / evaluate(x.den, values)))
        if name == "sqrt" and over is not None and not over.is_constant():
            value = value * arb(evaluate(over, values)).sgn()
        return value

    def uses(self, index: int) -> set[int]:
        """Indices of all indeterminates on which one depends through its argument."""
        if index not in self.meaning:
            return {index}
        _, x, over = self.meaning[index]
        direct = occurring(x.num) | occurring(x.den) | (set() if over is None else occurring(over))
        return {index}.union(*(self.uses(i) for i in direct))
