"""The numbers of a graph as symbols: CasADi rounds no sum, product or function of them."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import casadi as ca
import numpy as np

from ...algebra.exact.number_fields import RATIONAL_AT, RATIONAL_TOO
from ...algebra.number_types import Algebra, casadi_algebra
from ...algebra.program import operations
from ...base.exact_numbers import decimal_of

TEN = 22
"""Largest power of ten that is a double without rounding."""


class Constants:
    """The numbers of a graph as symbols, so that CasADi folds only zeros.

    CasADi computes sums, products or sines of numbers in double precision when it builds an
    expression.  A graph for exact arithmetic must not hold such rounded numbers.

    Parameters
    ----------
    decimals
        Whether 9.81 is read as 981/100: a quotient of two symbols, exact in every algebra.
    """

    def __init__(self, *, decimals: bool = False) -> None:
        self._symbols: dict[float, ca.SX] = {}
        self._decimals = decimals
        self._quotients: dict[float, ca.SX] = {}

    def __call__(self, value: float) -> ca.SX:
        """The number as a symbol; zero stays a number, since zeros fold without rounding."""
        if value == 0:
            return ca.SX(0)
        value = float(value)
        ratio = decimal_of(value) if self._decimals else None
        if ratio is None or ratio == Fraction(value):
            return self._kept(value)
        if value not in self._quotients:  # one expression for each number, so that x - x folds
            self._quotients[value] = self._quotient(ratio)
        return self._quotients[value]

    @property
    def read(self) -> tuple[float, ...]:
        """Doubles that are read as decimals."""
        return tuple(self._quotients)

    def _quotient(self, decimal: Fraction) -> ca.SX:
        """Digits times or over powers of ten, each a double without rounding."""
        power = 0
        while decimal.denominator != 1:
            decimal, power = decimal * 10, power + 1
        while decimal.numerator % 10 == 0:
            decimal, power = decimal / 10, power - 1
        out = self._kept(float(decimal.numerator))
        for _ in range(abs(power) // TEN):
            out = out / self._kept(10.0**TEN) if power > 0 else out * self._kept(10.0**TEN)
        last = self._kept(10.0 ** (abs(power) % TEN))
        return out / last if power > 0 else out * last

    @property
    def column(self) -> ca.SX:
        """All symbols so far, as a column."""
        return ca.vertcat(*self._symbols.values()) if self._symbols else ca.SX(0, 1)

    @property
    def values(self) -> list[float]:
        """Values of the symbols, in the same order."""
        return list(self._symbols)

    def algebra(self, met: list[tuple[str, Any]] | None = None, *, strict: bool = False) -> Algebra:
        """CasADi's own expressions with these constants; `met` collects functions' arguments.

        With `strict`, cos(0) is a symbol too, and so is 2 in √2: no number is left to be rounded.
        """
        plain = casadi_algebra()

        def kept(name: str) -> Any:
            def apply(x: Any) -> Any:
                if met is not None:
                    met.append((name, x))
                if rounded(name, x):
                    x = ca.SX.sym("folded") if np.isnan(float(x)) else self._kept(float(x))
                if strict and name == "sqrt" and isinstance(x, ca.SX) and x.is_constant():
                    x = x if float(x) in (0, 1) else self._kept(float(x))
                value = plain.functions[name](x)
                return self(float(value)) if strict and ca.SX(value).is_constant() else value

            return apply

        def power(x: Any, exponent: Any) -> Any:
            if met is not None:
                met.append(("pow", x))
            return self._power(x, exponent)

        def size(x: Any) -> Any:
            if met is not None:
                met.append(("fabs", x))
            return ca.fabs(x)

        def sign(x: Any) -> Any:
            if met is not None:
                met.append(("sign", x))
            return plain.functions["sign"](x)

        def angle(y: Any, x: Any) -> Any:
            if met is not None:
                met.append(("atan2", y))
            numbers = all(isinstance(v, ca.SX) and v.is_constant() for v in (y, x))
            return ca.atan2(*(self._kept(float(v)) if numbers else v for v in (y, x)))

        other = {"pow": power, "fabs": size, "sign": sign, "atan2": angle}
        table = {name: kept(name) for name in plain.functions if name not in other}
        return Algebra("casadi", self, table | other)

    def _kept(self, value: float) -> ca.SX:
        """A number, also zero, as a symbol: acos(0) is not rational."""
        return self._symbols.setdefault(value, ca.SX.sym(f"c{len(self._symbols)}"))

    def _power(self, x: Any, exponent: Any) -> Any:
        """A power; a whole or half exponent stays a number, so that its rule is known."""
        number = next((v for v, s in self._symbols.items() if ca.is_equal(s, exponent)), None)
        if number is None and exponent.is_constant():
            number = float(exponent)
        if number is not None and 2 * number == round(2 * number) and abs(number) < 2**20:
            return ca.power(x, number)
        return ca.power(x, exponent)


def rounded(name: str, x: Any) -> bool:
    """Whether CasADi's own number for a function of an argument may be wrong.

    CasADi rounds functions of numbers as soon as it builds an expression, and gives |x| a slope and
    x a sign at 0.  `atan2` has two arguments, and is read again in any case.
    """
    constant = isinstance(x, ca.SX) and x.is_constant()
    if name in ("pow", "fabs", "sign", "atan2"):
        return bool(constant or name != "pow")
    return bool(constant and float(x) != (RATIONAL_AT | RATIONAL_TOO).get(name, (float(x), 0))[0])


def exact_numbers(*outputs: ca.SX) -> bool:
    """Whether every number in expressions is a small multiple of 2⁻²⁰, so that none was rounded."""
    free = ca.symvar(ca.veccat(*outputs))
    graph = ca.Function("numbers", [ca.vertcat(*free)], list(outputs))
    codes = [i for i, code in enumerate(operations(graph)) if code == ca.OP_CONST]
    values = [float(graph.instruction_constant(i)) for i in codes]
    return all(abs(v) < 2.0**20 and (v * 2.0**20).is_integer() for v in values)
