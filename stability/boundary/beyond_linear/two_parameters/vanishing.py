"""Points of flutter boundaries at which the first Lyapunov coefficient changes sign."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from flint import arb

from ....algebra.balls import precision
from ....base.axis import Axis
from ....base.errors import StabilityError
from ....spectra.problem import Problem
from ....systems.family import Family
from ...changes import along
from ...crossings import Crossing
from ..crossings_proved import Pair, PairEquations, guess, pair_of
from ..derivatives import Line
from ..first_coefficient import coefficients, others, signed
from ..krawczyk import NotProvedError, polished, tested

BITS = 192
"""Working precision."""
SAME = 1e-7
"""Largest distance of a followed crossing from a boundary that was found, relative to the axis."""
WIDEST = 2**12
"""Widest bracket of a point, in units of the last digit."""


@dataclass(frozen=True)
class Vanishing:
    """A proved change of sign along a flutter boundary."""

    place: tuple[Any, Any]
    """Balls of x and y."""
    frequency: Any
    """ω."""
    others: int
    """As in `first_coefficient.others`, next to the point."""


class Follower:
    """Crossing pairs along one axis, followed as the other quantity changes.

    Parameters
    ----------
    family
        The family.
    axis
        Name of the axis along which pairs cross.
    other
        Name of the quantity that changes.
    fixed
        Every other quantity.
    """

    def __init__(self, family: Family, axis: str, other: str, fixed: dict[str, float]) -> None:
        self.family, self.axis, self.other, self.fixed = family, axis, other, fixed

    def line(self, place: Any) -> Line:
        """The line at a value of the other quantity."""
        return Line(self.family, self.axis, self.fixed | {self.other: place})

    def first(self, place: float, value: float, frequency: float) -> tuple[PairEquations, Pair]:
        """The pair at a boundary that was found."""
        equations, start = guess(self.line(place), value, frequency)
        return equations, self._pair(equations, start)

    @staticmethod
    def _pair(equations: PairEquations, start: Sequence[Any]) -> Pair:
        box, _ = tested(equations, polished(equations, [float(arb(v).mid()) for v in start]))
        return pair_of(equations, box)

    def moved(self, equations: PairEquations, near: Pair, place: float) -> Pair:
        """The pair at another value, from one nearby, with the same phase."""
        return self._pair(self._at(equations, place), near.box)

    def _at(self, equations: PairEquations, place: Any) -> PairEquations:
        phase = [complex(float(a), float(b)) for a, b in equations.phase]
        return PairEquations(self.line(place), phase)

    def one_branch(self, equations: PairEquations, low: Pair, high: Pair) -> Any:
        """The pair over all values between two, proved to be one branch with both at its ends."""
        places = [p.line.fixed[self.other] for p in (low, high)]
        over = self._at(equations, arb(places[0]).union(arb(places[1])))
        middle = [((a + b) / 2).mid() for a, b in zip(low.box, high.box, strict=True)]
        far = [4 * abs(a - b) for a, b in zip(low.box, high.box, strict=True)]
        image, box = tested(over, middle, [v.abs_upper() + arb(2) ** (8 - BITS // 2) for v in far])
        for pair in (low, high):
            if not all(b.contains(v) for b, v in zip(box, pair.box, strict=True)):
                raise NotProvedError
        return image


def vanishing(problem: Problem, axes: tuple[Axis, Axis]) -> list[Vanishing]:
    """Changes of sign of the first Lyapunov coefficient along the flutter boundaries of a plane.

    Boundaries are found along the lines of a grid, in both directions, and followed from each line
    to the next.

    Parameters
    ----------
    problem
        A user's family of isolated steady motions, with values.
    axes
        x and y; their numbers of points are those of the lines.
    """
    out: list[Vanishing] = []
    swept = {g.name for g in axes}
    fixed = {n: float(v) for n, v in problem.values.items() if n not in swept}
    with precision(BITS):
        for way in (0, 1):
            axis, other = axes[way], axes[1 - way]
            follower = Follower(problem.family, axis.name, other.name, fixed)
            rows = [_row(problem, follower, axis, float(t)) for t in other.values]
            for low, high, start, end in zip(
                other.values, other.values[1:], rows, rows[1:], strict=False
            ):
                for entry in start:
                    found = _between(follower, entry, end, (float(low), float(high)))
                    if found is not None:
                        place = found.place if way == 0 else found.place[::-1]
                        out = _added(out, replace(found, place=(place[0], place[1])))
    return out


def _added(out: list[Vanishing], new: Vanishing) -> list[Vanishing]:
    for old in out:
        near = [
            abs(float(arb(a).mid()) - float(arb(b).mid())) <= 1e-10 * (1 + abs(float(arb(a).mid())))
            for a, b in zip(old.place, new.place, strict=True)
        ]
        if all(near):
            return out
    return [*out, new]


Entry = tuple[PairEquations, Pair, int]


def _row(problem: Problem, follower: Follower, axis: Axis, place: float) -> list[Entry]:
    """Flutter boundaries on one line, each with the proved sign of its coefficient."""
    values = dict(problem.values) | {follower.other: place}
    line = replace(problem, values=values)
    try:
        found = along(line, axis.name, axis.low, axis.high, points=max(axis.count, 2), log=axis.log)
    except StabilityError:
        return []
    out = []
    for b in found:
        if b.crossing is Crossing.FLUTTER:
            try:
                equations, pair = follower.first(place, b.value, b.frequency)
                out.append((equations, pair, signed(coefficients(pair).first)))
            except (NotProvedError, StabilityError):
                continue
    return out


def _between(
    follower: Follower, entry: Entry, end: Sequence[Entry], places: tuple[float, float]
) -> Vanishing | None:
    """The change of sign on one boundary between two lines, proved; None if there is none."""
    equations, pair, sign = entry
    try:
        last = follower.moved(equations, pair, places[1])
        same = [e for e in end if abs(e[1].value - last.value) <= SAME * (1 + abs(last.value))]
        if not same or sign * same[0][2] >= 0:
            return None
        return _refined(follower, equations, pair, places)
    except (NotProvedError, StabilityError):
        return None


def _refined(
    follower: Follower, equations: PairEquations, pair: Pair, places: tuple[float, float]
) -> Vanishing | None:
    near = pair

    def at(place: float) -> Pair:
        nonlocal near
        near = follower.moved(equations, near, place)
        return near

    def size(place: float) -> float:
        return float(coefficients(at(place)).first.mid())

    from scipy.optimize import brentq

    root = float(brentq(size, *places, xtol=1e-300, rtol=4 * np.finfo(float).eps))
    width = float(np.spacing(abs(root))) or 1e-300
    while width <= WIDEST * (np.spacing(abs(root)) or 1e-300):
        low, high = at(root - width), at(root + width)
        if signed(coefficients(low).first) * signed(coefficients(high).first) < 0:
            over = follower.one_branch(equations, low, high)
            place = arb(root - width).union(arb(root + width))
            return Vanishing((over[0], place), over[-1], others(low))
        width *= 2
    return None
