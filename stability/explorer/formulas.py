"""What decides a family's verdict: formulas in its quantities, and the text of each condition."""

from __future__ import annotations

import html
import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from ..algebra.linear_systems import solution
from ..algebra.number_types import Algebra
from ..algebra.polynomial import Polynomial
from ..algebra.upright import Upright
from ..base.errors import StabilityError
from ..base.verdict import Verdict
from ..systems.family import Family
from .source import graph

ROUNDINGS = 3
"""Roundings of a coefficient, of the bound itself, and one to spare."""
UP = 1.0 + 2.0**-20
"""Factor by which a bound is larger than its own rounding errors."""
FLOAT = 1e-9
"""Least condition, over the sizes of its terms, whose sign a float verdict gives."""

Values = Sequence[Any]
Coefficients = Callable[[Algebra, Values], list[list[Any]]]
Conditions = Callable[[Algebra, Values], list[tuple[Any, Any]]]


@dataclass(frozen=True)
class Rule:
    """A number whose sign decides; all positive means stable or neutral."""

    kind: str
    """What happens where it vanishes: static, flutter or auxiliary."""
    share: float
    """Error bound over the size that is given with its value."""
    text: str
    """The number as HTML with symbols."""
    filled: str = ""
    """The same with {name} for numbers; empty where that is too long."""


@dataclass(frozen=True)
class PageFormulas:
    """What decides the verdict of a family, as functions of a number type and its quantities."""

    names: tuple[str, ...]
    """Names of the quantities in their order, then of states that the page solves for."""
    even: tuple[bool, ...]
    """Whether each factor of the characteristic polynomial has even powers of λ alone."""
    zeros: int
    """Number of eigenvalues that vanish by structure."""
    coefficients: Coefficients
    """Coefficients of each factor in λ, lowest first."""
    rules: tuple[Rule, ...]
    """What decides by its sign."""
    signs: Conditions
    """(value, size) of each rule; the share of the rule times the size bounds the error."""
    unknown: Callable[[Algebra, Values], Mapping[str, Any]]
    """Further states of a member by name, those that follow from the quantities."""
    good: Verdict
    """Verdict where every rule is positive."""
    bounds: Conditions | None = None
    """(value, error bound) of each rule where that is no share of the size; None where it is."""
    members: Callable[[Algebra, Values], list[Any]] | None = None
    """Numbers that are positive where the family has a member; None where it always has one."""
    solver: Solver | None = None
    """How the page solves for states; None where it solves for none."""
    proved: bool = True
    """Whether the signs have a bound on their errors."""
    note: str = ""
    """What the letters of the conditions are."""
    numbers: str = ""
    """How decimals in the equations were read; empty where all numbers are exact."""

    def states(self, family: Family, algebra: Algebra, q: Values) -> list[Any]:
        """States of a member of the family."""
        numbers = dict(zip(self.names, q, strict=True))
        values = {**family.fixed, **self.unknown(algebra, q), **numbers}
        states = [values[n] for n in family.system.states]
        return [math.pi / 2 if isinstance(v, Upright) else v for v in states]


def share_of(polynomial: Polynomial, roundings: Mapping[str, int]) -> float:
    """Error bound over the sum of the sizes of all monomials, rounded up.

    The roundings are those in the value of each variable.
    """
    return UP * (polynomial.roundings(roundings) + ROUNDINGS) * 2.0**-53


def sized(polynomial: Polynomial, shift: int, algebra: Algebra, point: Values) -> tuple[Any, Any]:
    """Value, and the sum of the sizes of all monomials; every line is used for both."""
    terms = tuple((abs(c), e) for c, e in polynomial.terms)
    sizes = [algebra.functions["fabs"](v) for v in point]
    positive = Polynomial(polynomial.variables, terms)
    return value_of(polynomial, shift, point), value_of(positive, shift, sizes)


def _size(coefficient: int, shift: int) -> str:
    """A coefficient without its sign; one that was scaled is rounded to five digits."""
    return f"{_scaled(abs(coefficient), shift):.5g}" if shift else str(abs(coefficient))


def _scaled(coefficient: int, shift: int) -> float:
    # an integer of any size over a power of two, with one rounding
    return float(coefficient / (1 << shift))


WORD = re.compile(r"[A-Za-z]{2}")
"""Two letters: a name that is a word, whose product with another needs a space."""


def typeset(polynomial: Polynomial, names: Mapping[str, tuple[str, int]], shift: int = 0) -> str:
    """A polynomial as HTML.

    Parameters
    ----------
    polynomial
        The polynomial.
    names
        For each variable the symbol to write, and the power of it that the variable is.
    shift
        The polynomial is divided by 2 to this power; its coefficients are then rounded.

    Examples
    --------
    >>> p = Polynomial(("k", "z"), ((2, (1, 1)), (-1, (0, 0))))
    >>> typeset(p, {"k": ("k", 1), "z": ("ω₃", 2)})
    '2<i>k</i><i>ω₃</i><sup>2</sup> − 1'
    >>> typeset(p, {"k": ("k", 1), "z": ("speed", 1)})  # a space where a name is a word
    '2 <i>k</i> <i>speed</i> − 1'
    """

    def text(symbol: str) -> str:
        letter, _, below = html.escape(symbol).partition("_")
        return f"<i>{letter}</i>" + f"<sub>{below}</sub>" * bool(below)

    def between(symbols: Sequence[str]) -> str:
        return " " if any(WORD.search(symbol.partition("_")[0]) for symbol in symbols) else ""

    return _terms(polynomial, names, shift, text, between)


MOST_FILLED = 4
"""Largest number of monomials of a formula that is shown with numbers."""


def filled(polynomial: Polynomial, names: Mapping[str, tuple[str, int]], shift: int = 0) -> str:
    """A short polynomial as HTML with {name} in place of each number; empty for a long one.

    Parameters
    ----------
    polynomial
        The polynomial.
    names
        For each variable its number as text with {name}, and the power of it that the variable is.
    shift
        As for `typeset`.

    Examples
    --------
    >>> p = Polynomial(("k", "z"), ((2, (1, 1)), (-1, (0, 0))))
    >>> filled(p, {"k": ("{k}", 1), "z": ("{at}", 2)})
    '2 · {k} · {at}<sup>2</sup> − 1'
    """
    if len(polynomial.terms) > MOST_FILLED:
        return ""
    return _terms(polynomial, names, shift, str, lambda _: " · ")


def _terms(
    polynomial: Polynomial,
    names: Mapping[str, tuple[str, int]],
    shift: int,
    text: Callable[[str], str],
    between: Callable[[Sequence[str]], str],
) -> str:
    """The terms of a polynomial, with a text for each symbol and one between factors."""
    words = []
    for c, exponents in polynomial.terms:
        symbols, factors = [], []
        for variable, exponent in zip(polynomial.variables, exponents, strict=True):
            symbol, power = names.get(variable, (variable, 1))
            raised = exponent * power
            if raised and symbol != "1":
                symbols.append(symbol)
                factors.append(text(symbol) + f"<sup>{raised}</sup>" * (raised != 1))
        if abs(c) != 1 or not factors:
            factors.insert(0, _size(c, shift))
        words.append((" − " if c < 0 else " + ") + between(symbols).join(factors))
    line = "".join(words) or "0"
    return line[3:] if line.startswith(" + ") else line.replace(" − ", "−", 1)


def shift_of(polynomials: Sequence[Polynomial]) -> int:
    """The power of two over which the largest coefficient is about 1; 0 where all are small."""
    largest = max((abs(c) for p in polynomials for c, _ in p.terms), default=1)
    return 0 if largest < 2**40 else largest.bit_length() - 1


def value_of(polynomial: Polynomial, shift: int, point: Sequence[Any]) -> Any:
    """A polynomial over a power of two, with each coefficient rounded once.

    Examples
    --------
    >>> value_of(Polynomial(("x",), ((2**60, (2,)), (3, (0,)))), 60, [0.5])
    0.25
    """
    if not shift:
        return polynomial(*point)
    return _horner([(_scaled(c, shift), e) for c, e in polynomial.terms], list(point))


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


MOST_UNKNOWNS = 4
"""Largest number of unknowns: the page writes their elimination out."""
STEPS = 5
"""Steps of Newton's method at a point of a picture, from the members of a grid."""
CLOSE = 1e-6
"""Largest last step there, over 1 plus the unknown; elsewhere no member is drawn."""


@dataclass(frozen=True)
class Solver:
    """The equations of a family's unknowns, and where a search for them starts."""

    family: Family
    """A family with a root-finder."""

    @property
    def unknown(self) -> tuple[str, ...]:
        """States that are solved for."""
        return tuple(self.family.unknown)

    def told(self) -> dict[str, Any]:
        """The record in the page."""
        family, names = self.family, self.unknown
        anchor = family.anchor
        return {
            "names": names,
            "equations": graph(family.graph.along),
            "cut": len(family.at),
            "guess": list(family.unknown.values()),
            "positive": [i for i, name in enumerate(names) if name in family.positive],
            "anchor": {"given": anchor.given.tolist(), "unknown": list(anchor.unknown)}
            if anchor
            else None,
        }

    def polished(self, algebra: Algebra, q: Sequence[Any]) -> tuple[list[Any], list[Any]]:
        """Quantities with unknowns, by Newton's method from a guess, and what is positive there."""
        family, count = self.family, len(q) - len(self.unknown)
        cut, program, size = len(family.at), family.graph.along, algebra.functions["fabs"]
        numbers, u = list(q[:count]), list(q[count:])
        trust: list[Any] = []
        for _ in range(STEPS):
            at = [numbers[:cut], u, numbers[cut:]]
            r, slope = (program.dense(algebra, at, i) for i in (0, 1))
            step = [row[0] for row in solution(algebra, slope, r)]
            u = [a - b for a, b in zip(u, step, strict=True)]
            trust = [CLOSE * (1.0 + size(a)) - size(b) for a, b in zip(u, step, strict=True)]
        trust += [a for a, name in zip(u, self.unknown, strict=True) if name in family.positive]
        return [*numbers, *u], trust


def solver_of(family: Family) -> Solver | None:
    """How the members of a family are found; None where they are known in closed form.

    Raises
    ------
    StabilityError
        If more is solved for than the page can find.
    """
    if family.trimmed:
        raise StabilityError(
            f"{family.name} is solved for {', '.join(family.trimmed)}; the page solves for states "
            "alone. Name the family by it."
        )
    if not family.unknown or family.closed:
        return None
    if len(family.unknown) > MOST_UNKNOWNS or family.graph.finder is None:
        raise StabilityError(
            f"{family.name}: {', '.join(family.unknown)} of its members is solved for; the page "
            f"finds up to {MOST_UNKNOWNS} unknowns, which their equations fix."
        )
    return Solver(family)
