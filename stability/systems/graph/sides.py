"""A system on one side of its switches: where it has some, and whether its slopes go through.

A switch is a place s = c of a symbol s and a number c, from |s - c| or the sign of s - c.  With one
side chosen, the graph has no switch there, and is that of the smooth piece.

Whether rates and slopes are the same on both sides is read from the graph.  Each number has a value
for each side: a fraction where it follows from numbers that are known, and otherwise nothing.  A
product with a fraction 0 is 0.  What holds so holds for all numbers that are not known.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import lru_cache
from itertools import product
from typing import Any

import casadi as ca

from ...algebra.number_types import MORE, UNARY, Algebra
from ...algebra.program import Program
from ...algebra.switches import one_sided
from ...base.errors import ParameterError, StabilityError
from ..equations import Equations
from .family_graph import rates_and_slopes

MOST_SWITCHES = 4
"""Most switches at one state of which all sides are compared."""


def _written(system: Equations, side: Callable[[int, float], Any]) -> list[ca.SX]:
    implicit = [v for v in (system.mass, system.forcing) if v is not None]
    parts = [system.rhs, *system.observables.values(), *implicit]
    return one_sided([system.x, system.p], parts, side)


@lru_cache(maxsize=64)
def switches(system: Equations) -> dict[str, tuple[float, ...]]:
    """Places of the switches along each state and parameter, in increasing order."""
    names = (*system.states, *system.parameters)
    met: dict[str, set[float]] = {}

    def side(index: int, place: float) -> None:
        met.setdefault(names[index], set()).add(place)

    if system.coefficients is None and not system.quantities:
        with suppress(ParameterError):  # a numeric system has no graph
            _written(system, side)
    return {name: tuple(sorted(places)) for name, places in met.items()}


def on_sides(
    system: Equations, numbers: Mapping[str, float], ways: Mapping[tuple[str, float], int]
) -> Equations:
    """The system around numbers, and on chosen sides of the switches on which they lie.

    Parameters
    ----------
    system
        The system.
    numbers
        Values of some states and parameters, by name.
    ways
        1 or -1 by name and place of a switch.
    """
    names = (*system.states, *system.parameters)

    def side(index: int, place: float) -> int | None:
        name = names[index]
        if name not in numbers:
            return None
        return ways.get((name, place)) or (1 if numbers[name] > place else -1)

    rest = iter(_written(system, side))
    rhs = next(rest)
    seen = {n: next(rest) for n in system.observables}
    mass, forcing = (None if v is None else next(rest) for v in (system.mass, system.forcing))
    return replace(system, rhs=rhs, observables=seen, mass=mass, forcing=forcing)


def switches_at(system: Equations, numbers: Mapping[str, float]) -> list[tuple[str, float]]:
    """The switches on which numbers lie."""
    places = switches(system)
    return [(n, v) for n, v in numbers.items() if v in places.get(n, ())]


def continuous(system: Equations, numbers: Mapping[str, float]) -> bool:
    """Whether rates and slopes are proved the same on all sides of the switches at some numbers.

    Examples
    --------
    >>> import stability as st
    >>> v = ca.SX.sym("v")
    >>> rates = -v * ca.fabs(v), ca.if_else(v > 0, -v, -2 * v)
    >>> drags = [st.System("drag", v, ca.SX(0, 1), rate, states=("v",)) for rate in rates]
    >>> [continuous(drag, {"v": 0.0}) for drag in drags]
    [True, False]
    """
    here = switches_at(system, numbers)
    if not 0 < len(here) <= MOST_SWITCHES:
        return False
    names = (*system.states, *system.parameters)
    way = ca.SX.sym("way", len(here))

    def side(index: int, place: float) -> Any:
        pair = names[index], place
        if pair in here:
            return way[here.index(pair)]
        return None if pair[0] not in numbers else (1 if numbers[pair[0]] > place else -1)

    rhs = _written(system, side)[0]
    program = Program(
        ca.Function("rates", [system.x, ca.vertcat(system.p, way)], [ca.densify(rhs)])
    )
    sided = [TwoSided.known(numbers.get(name)) for name in names]
    cut = len(system.states)
    for turned, others in product(range(len(here)), product((1, -1), repeat=len(here) - 1)):
        ways = [TwoSided.known(w) for w in others]
        ways.insert(turned, TwoSided(Fraction(1), Fraction(-1), same=False))
        try:
            values, slopes = rates_and_slopes(
                program, TWO_SIDED, sided[:cut], [*sided[cut:], *ways]
            )
        except (StabilityError, ZeroDivisionError, OverflowError):
            return False
        numbers_met = [*values, *(s for row in slopes for s in row.values())]
        if not all(TwoSided.of(v).same for v in numbers_met):
            return False
    return True


@dataclass(frozen=True, eq=False)
class TwoSided:
    """A number on the two sides of a switch; None where it is not known."""

    above: Fraction | None
    below: Fraction | None
    same: bool

    @classmethod
    def known(cls, value: float | None) -> TwoSided:
        """A number that is the same on both sides."""
        number = None if value is None else Fraction(value)
        return cls(number, number, same=True)

    @staticmethod
    def of(value: Any) -> TwoSided:
        """A number, or an integer as slopes start with."""
        return value if isinstance(value, TwoSided) else TwoSided.known(value)

    def _with(self, other: Any, function: Callable[[Any, Any], Any]) -> Any:
        if not isinstance(other, (TwoSided, int)):
            return NotImplemented
        other = TwoSided.of(other)
        above, below = function(self.above, other.above), function(self.below, other.below)
        equal = above is not None and above == below
        return TwoSided(above, below, same=equal or (self.same and other.same))

    def __add__(self, other: Any) -> Any:
        return self._with(other, lambda a, b: None if None in (a, b) else a + b)

    def __mul__(self, other: Any) -> Any:
        def times(a: Any, b: Any) -> Any:
            return Fraction(0) if 0 in (a, b) else None if None in (a, b) else a * b

        return self._with(other, times)

    def __truediv__(self, other: Any) -> Any:
        def over(a: Any, b: Any) -> Any:
            return Fraction(0) if a == 0 else None if None in (a, b) else a / b

        return self._with(other, over)

    def __neg__(self) -> Any:
        return self * -1

    def __sub__(self, other: Any) -> Any:
        return self._with(other, lambda a, b: None if None in (a, b) else a - b)

    def __rsub__(self, other: Any) -> Any:
        return TwoSided.of(other) - self

    def __rtruediv__(self, other: Any) -> Any:
        return TwoSided.of(other) / self

    __radd__, __rmul__ = __add__, __mul__

    def __eq__(self, other: object) -> bool:
        return self.same and self.above == other

    __hash__ = None  # type: ignore[assignment]


def _unknown(*numbers: Any) -> TwoSided:
    return TwoSided(None, None, same=all(TwoSided.of(n).same for n in numbers))


TWO_SIDED = Algebra(
    "two sides",
    TwoSided.known,
    {name: _unknown for name in (*UNARY, *MORE, "pow", "fabs", "sign", "atan2", "hypot")},
)
