"""Formulas of a family in its quantities: coefficients in λ, conditions with their sizes, text."""

from __future__ import annotations

import html
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from ..algebra.number_types import Algebra
from ..algebra.polynomial import Polynomial

ROUNDINGS = 3
"""Roundings of a coefficient, of the bound itself, and one to spare."""
UP = 1.0 + 2.0**-20
"""Factor by which a bound is larger than its own rounding errors."""

Values = Sequence[Any]
Coefficients = Callable[[Algebra, Values], list[list[Any]]]
Conditions = Callable[[Algebra, Values], list[tuple[Any, Any]]]


@dataclass(frozen=True)
class Rule:
    """A polynomial whose sign decides."""

    kind: str
    """What happens where it vanishes: static, flutter or auxiliary."""
    polynomial: Polynomial
    """The polynomial; all positive means stable or neutral."""
    roundings: Mapping[str, int]
    """Roundings in the value of each variable."""

    @property
    def share(self) -> float:
        """Error bound over the sum of the sizes of all monomials, rounded up."""
        count = self.polynomial.roundings(self.roundings) + ROUNDINGS
        return UP * count * 2.0**-53

    def sizes(self, algebra: Algebra, values: Values) -> tuple[Any, Any]:
        """Value, and the sum of the sizes of all monomials; every line is used for both."""
        positive = Polynomial(
            self.polynomial.variables, tuple((abs(c), e) for c, e in self.polynomial.terms)
        )
        size = algebra.functions["fabs"]
        return self.polynomial(*values), positive(*[size(v) for v in values])


def typeset(polynomial: Polynomial, names: Mapping[str, tuple[str, int]]) -> str:
    """A polynomial as HTML.

    Parameters
    ----------
    polynomial
        The polynomial.
    names
        For each variable the symbol to write, and the power of it that the variable is.

    Examples
    --------
    >>> p = Polynomial(("k", "z"), ((2, (1, 1)), (-1, (0, 0))))
    >>> typeset(p, {"k": ("k", 1), "z": ("ω₃", 2)})
    '2<i>k</i><i>ω₃</i><sup>2</sup> − 1'
    """
    words = []
    for c, exponents in polynomial.terms:
        factors = []
        for variable, exponent in zip(polynomial.variables, exponents, strict=True):
            symbol, power = names.get(variable, (variable, 1))
            raised = exponent * power
            text = f"<i>{html.escape(symbol)}</i>"
            if raised:
                factors.append(text if raised == 1 else f"{text}<sup>{raised}</sup>")
        size = "" if abs(c) == 1 and factors else str(abs(c))
        words.append((" − " if c < 0 else " + ") + size + "".join(factors))
    found = "".join(words) or "0"
    return found[3:] if found.startswith(" + ") else found.replace(" − ", "−", 1)


MOST_FILLED = 4
"""Largest number of monomials of a formula that is shown with numbers."""


def filled(polynomial: Polynomial, names: Mapping[str, tuple[str, int]]) -> str:
    """A short polynomial as HTML with {name} in place of each number; empty for a long one.

    Parameters
    ----------
    polynomial
        The polynomial.
    names
        For each variable its number as text with {name}, and the power of it that the variable is.

    Examples
    --------
    >>> p = Polynomial(("k", "z"), ((2, (1, 1)), (-1, (0, 0))))
    >>> filled(p, {"k": ("{k}", 1), "z": ("{at}", 2)})
    '2 · {k} · {at}<sup>2</sup> − 1'
    """
    if len(polynomial.terms) > MOST_FILLED:
        return ""
    words = []
    for c, exponents in polynomial.terms:
        factors = [str(abs(c))] if abs(c) != 1 or not any(exponents) else []
        for variable, exponent in zip(polynomial.variables, exponents, strict=True):
            number, power = names.get(variable, (variable, 1))
            raised = exponent * power
            if raised:
                factors.append(number if raised == 1 else f"{number}<sup>{raised}</sup>")
        words.append((" − " if c < 0 else " + ") + " · ".join(factors))
    found = "".join(words)
    return found[3:] if found.startswith(" + ") else found.replace(" − ", "−", 1)


def whole(value: Any) -> Any:
    """A coefficient as a number that JavaScript reads; a ratio is rounded once."""
    return float(Fraction(value)) if isinstance(value, Fraction) else value
