"""Polynomials over Q in several variables, evaluated in any algebra."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from ..base.errors import ParameterError, shown
from ..base.types import fields_of

MOST = 1000
"""Largest exponent."""


@dataclass(frozen=True)
class Polynomial:
    """A polynomial with integer coefficients in named variables, evaluated over any number type.

    Examples
    --------
    >>> p = Polynomial(("k", "z"), ((2, (1, 1)), (-1, (0, 0))))  # 2kz - 1
    >>> from fractions import Fraction
    >>> p(Fraction(1, 4), 2), p(0.25, 4.0), str(p)
    (Fraction(0, 1), 1.0, '2*k*z - 1')
    """

    variables: tuple[str, ...]
    """Names of the variables."""
    terms: tuple[tuple[int, tuple[int, ...]], ...]
    """(coefficient, exponents) of each monomial."""

    __getstate__ = fields_of

    def __post_init__(self) -> None:
        """Refuse other terms: the terms become the source of a function."""
        for c, e in self.terms:
            whole = type(c) is int and all(type(p) is int and 0 <= p <= MOST for p in e)
            if not whole or len(e) != len(self.variables):
                raise ParameterError(
                    f"a term is {shown((c, e))}; give an integer and {len(self.variables)} "
                    f"exponents from 0 to {MOST}."
                )

    def __call__(self, *values: Any) -> Any:
        """The value by nested Horner schemes, with the last variable outermost."""
        return self._compiled(*values)

    @cached_property
    def _compiled(self) -> Any:
        names = [f"x{i}" for i in range(len(self.variables))]
        body = _horner(list(self.terms), names)
        space: dict[str, Any] = {}
        exec(f"def value({', '.join(names)}):\n    return {body}\n", space)
        return space["value"]

    def factored(self, values: Mapping[str, Any], outer: Sequence[str] = ()) -> Any:
        """The value with few products: each Horner scheme is in the variable that most terms share.

        Parameters
        ----------
        values
            Values of the variables, by name.
        outer
            Variables of the outermost schemes, outermost first: over broadcast arrays, those that
            vary most.

        Examples
        --------
        >>> p = Polynomial(("x", "y", "z"), ((1, (1, 2, 0)), (2, (0, 1, 1)), (-3, (0, 0, 1))))
        >>> p.factored({"x": 2, "y": 3, "z": 5})  # y (x y + 2z) - 3z
        33
        """
        ahead = tuple(self.variables.index(n) for n in outer if n in self.variables)
        return _factored(list(self.terms), [values[n] for n in self.variables], ahead)

    @cached_property
    def parts(self) -> tuple[Polynomial, Polynomial]:
        """(P⁺, P⁻) with P = P⁺ - P⁻, both with positive coefficients."""
        plus = tuple(t for t in self.terms if t[0] > 0)
        minus = tuple((-c, e) for c, e in self.terms if c < 0)
        return Polynomial(self.variables, plus), Polynomial(self.variables, minus)

    @property
    def degrees(self) -> tuple[int, ...]:
        """Degree in each variable."""
        return tuple(
            max((e[i] for _, e in self.terms), default=0) for i in range(len(self.variables))
        )

    def ordered(self) -> tuple[Polynomial, list[int]]:
        """The polynomial with the least-degree variable outermost, and the order of its arguments.

        Over broadcast arrays only the outermost scheme runs over the full shape.
        """
        order = sorted(range(len(self.variables)), key=lambda i: -self.degrees[i])
        terms = tuple((c, tuple(e[i] for i in order)) for c, e in self.terms)
        return Polynomial(tuple(self.variables[i] for i in order), terms), order

    def roundings(self, behind: Mapping[str, int]) -> int:
        """Largest number of roundings of any monomial in the Horner schemes.

        Parameters
        ----------
        behind
            Number of roundings in the value of each variable, by name.
        """
        return _roundings(list(self.terms), [behind[n] for n in self.variables])

    def derivative(self, variable: str) -> Polynomial:
        """The derivative by one variable.

        Parameters
        ----------
        variable
            Name of the variable.
        """
        i = self.variables.index(variable)
        terms = tuple((c * e[i], (*e[:i], e[i] - 1, *e[i + 1 :])) for c, e in self.terms if e[i])
        return Polynomial(self.variables, terms)

    def __str__(self) -> str:
        words = []
        for c, e in self.terms:
            powers = [
                f"{n}**{p}" if p > 1 else n for n, p in zip(self.variables, e, strict=True) if p
            ]
            size = [str(abs(c))] if abs(c) != 1 or not powers else []
            words.append(("-" if c < 0 else "+") + " " + "*".join([*size, *powers]))
        text = " ".join(words) or "0"
        return text[2:] if text.startswith("+") else text.replace("- ", "-", 1)


def _horner(terms: list[tuple[int, tuple[int, ...]]], names: list[str]) -> str:
    """Source of the value; constants stay integers, which every number type accepts."""
    if not terms:
        return "0"
    if not names:
        return repr(sum(c for c, _ in terms))
    groups: dict[int, list[tuple[int, tuple[int, ...]]]] = {}
    for c, e in terms:
        groups.setdefault(e[-1], []).append((c, e[:-1]))
    powers = sorted(groups, reverse=True)
    text = ""
    x = names[-1]
    for place, power in enumerate(powers):
        inner = _horner(groups[power], names[:-1])
        text = f"({text} + {inner})" if text else f"({inner})"
        following = powers[place + 1] if place + 1 < len(powers) else 0
        text += f" * {x}" * (power - following)
    return text


def _factored(
    terms: list[tuple[int, tuple[int, ...]]], values: list[Any], ahead: tuple[int, ...]
) -> Any:
    """The value, first in the variables at the places `ahead`, then in those that most share."""
    while ahead and not any(e[ahead[0]] for _, e in terms):
        ahead = ahead[1:]
    shared = [sum(e[i] > 0 for _, e in terms) for i in range(len(values))]
    if not any(shared):
        return sum(c for c, _ in terms)
    i = ahead[0] if ahead else max(range(len(values)), key=shared.__getitem__)
    least = min(e[i] for _, e in terms if e[i])
    inner = [(c, (*e[:i], e[i] - least, *e[i + 1 :])) for c, e in terms if e[i]]
    rest = [(c, e) for c, e in terms if not e[i]]
    power = values[i]  # powers are shared by many terms
    for _ in range(least - 1):
        power = power * values[i]
    value = _factored(inner, values, ahead)
    value = power if isinstance(value, int) and value == 1 else power * value
    return value + _factored(rest, values, ahead) if rest else value


def _roundings(terms: list[tuple[int, tuple[int, ...]]], behind: list[int]) -> int:
    """Roundings in `_horner`: one for each product and sum, and those of each factor."""
    if not terms or not behind:
        return 0
    groups: dict[int, list[tuple[int, tuple[int, ...]]]] = {}
    for c, e in terms:
        groups.setdefault(e[-1], []).append((c, e[:-1]))
    count, last = -1, 0
    for power in sorted(groups, reverse=True):
        inner = _roundings(groups[power], behind[:-1])
        if count < 0:
            count = inner
        else:
            count = max(count + (last - power) * (1 + behind[-1]), inner) + 1
        last = power
    return count + last * (1 + behind[-1])
