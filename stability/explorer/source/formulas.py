"""Formulas of a family in its quantities: coefficients in λ, conditions with their sizes, text."""

from __future__ import annotations

import html
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from ...algebra.number_types import Algebra
from ...algebra.polynomial import Polynomial

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
    scale: float = 1.0
    """Power of two that the polynomial is multiplied by, where its coefficients are large."""

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
        sizes = [size(v) for v in values]
        return value_of(self.polynomial, self.scale, values), value_of(positive, self.scale, sizes)


def _size(coefficient: int, scale: float) -> str:
    """A coefficient without its sign; one that was scaled is rounded to five digits."""
    return str(abs(coefficient)) if scale == 1 else f"{_scaled(abs(coefficient), scale):.5g}"


def _scaled(coefficient: int, scale: float) -> float:
    # an integer of any size over a power of two, with one rounding
    return float(coefficient / (1 << round(-math.log2(scale))))


def typeset(
    polynomial: Polynomial, names: Mapping[str, tuple[str, int]], scale: float = 1.0
) -> str:
    """A polynomial as HTML.

    Parameters
    ----------
    polynomial
        The polynomial.
    names
        For each variable the symbol to write, and the power of it that the variable is.
    scale
        Power of two that the polynomial is multiplied by; its coefficients are then rounded.

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
        size = "" if abs(c) == 1 and factors else _size(c, scale)
        words.append((" − " if c < 0 else " + ") + size + "".join(factors))
    found = "".join(words) or "0"
    return found[3:] if found.startswith(" + ") else found.replace(" − ", "−", 1)


MOST_FILLED = 4
"""Largest number of monomials of a formula that is shown with numbers."""


def filled(polynomial: Polynomial, names: Mapping[str, tuple[str, int]], scale: float = 1.0) -> str:
    """A short polynomial as HTML with {name} in place of each number; empty for a long one.

    Parameters
    ----------
    polynomial
        The polynomial.
    names
        For each variable its number as text with {name}, and the power of it that the variable is.
    scale
        As for `typeset`.

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
        factors = [_size(c, scale)] if abs(c) != 1 or not any(exponents) else []
        for variable, exponent in zip(polynomial.variables, exponents, strict=True):
            number, power = names.get(variable, (variable, 1))
            raised = exponent * power
            if raised:
                factors.append(number if raised == 1 else f"{number}<sup>{raised}</sup>")
        words.append((" − " if c < 0 else " + ") + " · ".join(factors))
    found = "".join(words)
    return found[3:] if found.startswith(" + ") else found.replace(" − ", "−", 1)


def scale_of(polynomials: Sequence[Polynomial]) -> float:
    """A power of two that makes the largest coefficient about 1; 1 where all are small.

    Parameters
    ----------
    polynomials
        Polynomials with one factor.
    """
    largest = max((abs(c) for p in polynomials for c, _ in p.terms), default=1)
    return 1.0 if largest < 2**40 else 2.0 ** -(largest.bit_length() - 1)


def value_of(polynomial: Polynomial, scale: float, point: Sequence[Any]) -> Any:
    """A polynomial times a power of two, with each coefficient rounded once.

    Parameters
    ----------
    polynomial, scale
        The polynomial and the factor.
    point
        Values of its variables.

    Examples
    --------
    >>> value_of(Polynomial(("x",), ((2**60, (2,)), (3, (0,)))), 2.0**-60, [0.5])
    0.25
    """
    if scale == 1:
        return polynomial(*point)
    return _horner([(_scaled(c, scale), e) for c, e in polynomial.terms], list(point))


def _horner(terms: list[tuple[float, tuple[int, ...]]], values: list[Any]) -> Any:
    if not values:
        return sum(c for c, _ in terms)
    groups: dict[int, list[tuple[float, tuple[int, ...]]]] = {}
    for c, e in terms:
        groups.setdefault(e[-1], []).append((c, e[:-1]))
    total: Any = 0.0
    for power in range(max(groups, default=0), -1, -1):
        total = total * values[-1] if power < max(groups, default=0) else total
        if power in groups:
            total = total + _horner(groups[power], values[:-1])
    return total
