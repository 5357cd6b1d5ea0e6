"""Formulas as source of another language: a number type that writes down what is done to it.

A graph (`Program`), a stored polynomial, and any formula over a number type run on `Line`s.  Each
operation becomes one line of the language; equal operations share their line.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from typing import Any

from ..base.errors import StabilityError, shown
from .number_types import BY_OTHERS, MORE, UNARY, Algebra


@dataclass(frozen=True)
class Language:
    """How one language writes numbers, lines and functions."""

    name: str
    """Name of the language."""
    line: str
    """A line, or its part, that gives `{text}` the name `{name}`."""
    number: Callable[[float], str]
    """A number as text."""
    function: str
    """A function of one number, of `{name}` and `{value}`."""
    power: str = "pow({a}, {b})"
    """A power of `{a}` and `{b}`, both as text."""
    lacking: tuple[str, ...] = ()
    """Functions that are computed from others."""
    renamed: tuple[tuple[str, str], ...] = ()
    """Functions with another name."""


@dataclass(eq=False)
class Record:
    """The lines of one function."""

    language: Language
    """Language of the lines."""
    lines: list[str] = field(default_factory=list)
    """Lines so far."""
    lines_by_text: dict[str, Line] = field(default_factory=dict)
    """Result by its text, so that an operation is written once."""

    def line(self, text: str) -> Line:
        """The name of what a text computes."""
        if text not in self.lines_by_text:
            name = f"t{len(self.lines)}"
            self.lines.append(self.language.line.format(name=name, text=text))
            self.lines_by_text[text] = Line(self, name)
        return self.lines_by_text[text]

    def text(self, value: Any) -> str:
        """A number or line as text."""
        if isinstance(value, Line):
            return value.name
        number = float(value)
        if not math.isfinite(number):
            raise StabilityError(f"a formula of the page holds {shown(value)}, which is no number.")
        text = self.language.number(number)
        return f"({text})" if number < 0 else text

    def algebra(self) -> Algebra:
        """The number type of these lines."""

        def call(name: str, value: Any) -> Any:
            spelling = dict(self.language.renamed).get(name, name)
            if not isinstance(value, Line) and hasattr(math, name):
                return getattr(math, name)(value)
            return self.line(self.language.function.format(name=spelling, value=self.text(value)))

        names = [n for n in (*UNARY, *MORE, "fabs") if n not in self.language.lacking]
        table: dict[str, Callable[..., Any]] = {n: partial(call, n) for n in names}
        table |= {n: partial(BY_OTHERS[n], table) for n in self.language.lacking}
        table["pow"] = self._power
        table["atan2"] = partial(BY_OTHERS["atan2"], table)
        return Algebra(self.language.name, float, table, lasting=False)

    def _power(self, base: Any, exponent: Any) -> Any:
        if not isinstance(exponent, Line) and float(exponent) == int(exponent) and exponent >= 0:
            product: Any = 1.0
            for _ in range(int(exponent)):
                product = base * product
            return product
        return self.line(self.language.power.format(a=self.text(base), b=self.text(exponent)))


class Line:
    """A number that has a name in the source.

    Parameters
    ----------
    record
        The lines that the name belongs to.
    name
        The name.
    """

    __slots__ = ("name", "record")
    __array_ufunc__ = None

    def __init__(self, record: Record, name: str) -> None:
        self.record, self.name = record, name

    def _with(self, sign: str, other: Any, *, behind: bool) -> Any:
        texts = [self.name, self.record.text(other)]
        a, b = texts[::-1] if behind else texts
        return self.record.line(f"{a} {sign} {b}")

    def __add__(self, other: Any) -> Any:
        return self if _is(other, 0) else self._with("+", other, behind=False)

    def __radd__(self, other: Any) -> Any:
        return self if _is(other, 0) else self._with("+", other, behind=True)

    def __sub__(self, other: Any) -> Any:
        return self if _is(other, 0) else self._with("-", other, behind=False)

    def __rsub__(self, other: Any) -> Any:
        return -self if _is(other, 0) else self._with("-", other, behind=True)

    def __mul__(self, other: Any) -> Any:
        if _is(other, 0):
            return 0.0
        return self if _is(other, 1) else self._with("*", other, behind=False)

    def __rmul__(self, other: Any) -> Any:
        if _is(other, 0):
            return 0.0
        return self if _is(other, 1) else self._with("*", other, behind=True)

    def __truediv__(self, other: Any) -> Any:
        return self if _is(other, 1) else self._with("/", other, behind=False)

    def __rtruediv__(self, other: Any) -> Any:
        return 0.0 if _is(other, 0) else self._with("/", other, behind=True)

    def __neg__(self) -> Any:
        return self.record.line(f"-{self.name}")

    def __abs__(self) -> Any:
        return self.record.algebra().functions["fabs"](self)

    def __pos__(self) -> Any:
        return self


def _is(value: Any, number: float) -> bool:
    return isinstance(value, (int, float)) and value == number
