"""Boundaries of numeric systems by floats: a scan, and bisection of what is beyond an estimate.

At each value eigenvalues are counted whose discs lie on one side of the imaginary axis.  The discs
rest on an estimated error of finite differences, so that no bracket here is proved.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import pairwise
from operator import attrgetter

import numpy as np

from ..base.axis import Axis
from ..base.errors import NoMemberError, StabilityError
from ..base.types import Complexes, Floats
from ..base.verdict import CODES, Evidence, Verdict
from ..spectra.eigenvalues import decide, eigenvalues, unstable_in_discs
from ..spectra.numeric import numeric_linearised
from ..spectra.problem import Problem
from .brackets import (
    AxisCrossing,
    Boundaries,
    BoundaryPoint,
    Crossing,
    Crossings,
    Unresolved,
    zero_between,
)

HOW = (
    "by floats, not proved: the sign of the abscissa beyond its estimated error at {} points, and "
    "bisection between them"
)
PAIR = (
    "by floats, not proved: between neighbours of the {} points of the scan a pair of changes is "
    "not excluded."
)
NOTHING = "by floats no member is found here: {}"
WITHIN = "by floats the abscissa is within its estimated error of zero here."
JUMPS = (
    "by floats the verdict changes here, but members or eigenvalues jump, as on another branch, on "
    "a switch or at a pole."
)
NARROW = 4 * np.finfo(float).eps
"""Half-width of the first bracket that is tried, relative to its place."""
SIGNS = {CODES[Verdict.STABLE]: 1, CODES[Verdict.UNSTABLE]: -1}
"""Sign of each verdict by its code."""
SIGN = attrgetter("sign")
"""What is followed along an axis for changes of verdict."""
WIDER = 4.0
"""Width of each next bracket over that before."""
JUMP = 1e-3
"""Change of a state within a bracket, over 1 or its size, above which members jump; and distance of
a crossing eigenvalue from the imaginary axis, over the largest one around the bracket."""


@dataclass(frozen=True)
class Look:
    """What floats show at one value of an axis."""

    values: Complexes
    """Eigenvalues; empty without a member."""
    states: Floats
    """The member."""
    sign: int | None = None
    """1 stable, -1 unstable, None where it is open."""
    unstable: int | None = None
    """Number of unstable eigenvalues; None where a disc meets the imaginary axis."""
    why: str = ""
    """Why there is no member."""

    @property
    def growing(self) -> int:
        """Number of eigenvalues with a positive real part, sure or not."""
        return int((self.values.real > 0).sum())


class FloatScan:
    """A line along one axis of a numeric system, with the face that maps ask of an `AxisScan`.

    Parameters
    ----------
    problem, axis, fixed
        As for `AxisScan`.
    """

    neutral: bool | None = None
    """As for `AxisScan`; nothing is neutral by floats."""

    def __init__(self, problem: Problem, axis: str, fixed: Mapping[str, float]) -> None:
        self.problem, self.axis = problem, axis
        self.fixed = {n: v for n, v in fixed.items() if n != axis}
        self._looks: dict[float, Look] = {}

    def look(self, value: float) -> Look:
        """What is found at a value."""
        if value not in self._looks:
            self._looks[value] = self._looked(value)
        return self._looks[value]

    def _looked(self, value: float) -> Look:
        family = self.problem.family
        a, q, rate, _ = self.problem.arrays({**self.fixed, self.axis: value})
        try:
            u = family.solve(a, q)
            found = numeric_linearised(family, a, q, u)
        except StabilityError as error:
            return Look(np.empty(0, dtype=complex), np.empty(0), why=str(error))
        values, radius, _ = eigenvalues(found, even=False)
        sign = SIGNS.get(int(decide(values, radius, even=False)[0]))
        count = int(unstable_in_discs(values, radius, even=False)[0])
        state = family.states(a, u, q)[0]
        return Look(values[0] * rate[0], state, sign, count if count >= 0 else None)

    def quick_sign(self, value: float) -> int:
        """The verdict by floats: 1, -1, or 0."""
        return self.look(value).sign or 0

    def brackets(
        self, low: float, high: float, key: Callable[[Look], int | None]
    ) -> list[tuple[float, float]]:
        """Narrow intervals at whose ends a key differs, between two values where it does.

        Parameters
        ----------
        low, high
            Values whose keys are known and differ.
        key
            From a look to what is followed; None where it is not known.

        Raises
        ------
        NoMemberError
            If a value between has no member.
        """
        if high - low <= NARROW * max(abs(low), abs(high)):
            return [(low, high)]
        ends = key(self.look(low)), key(self.look(high))
        first = min(self.look(v).growing for v in (low, high))
        root = zero_between(lambda v: self._growth(v, first), low, high)
        width = max(NARROW * abs(root), NARROW * (high - low) / WIDER)
        while True:
            near = max(root - width, low), min(root + width, high)
            sides = key(self.look(near[0])), key(self.look(near[1]))
            if None not in sides:
                break
            width *= WIDER
        out = self.brackets(low, near[0], key) if sides[0] != ends[0] else []
        out += [near] if sides[0] != sides[1] else []
        return out + (self.brackets(near[1], high, key) if sides[1] != ends[1] else [])

    def _growth(self, value: float, place: int) -> float:
        """The growth rate with a place in falling order."""
        look = self.look(value)
        if look.why:
            raise NoMemberError(look.why)
        return float(np.sort(look.values.real)[::-1][place])

    def crossings(
        self, low: float, high: float, key: Callable[[Look], int | None]
    ) -> dict[tuple[float, float], AxisCrossing | None]:
        """What crosses the imaginary axis, by narrow intervals; None where something jumps."""
        size = max(float(np.abs(self.look(v).values).max()) for v in (low, high))
        return {ends: self._crossing(*ends, size) for ends in self.brackets(low, high, key)}

    def _crossing(self, low: float, high: float, size: float) -> AxisCrossing | None:
        one, two = self.look(low), self.look(high)
        if not (np.abs(one.states - two.states) <= JUMP * (1 + np.abs(one.states))).all():
            return None
        below, above = one.growing, two.growing
        grown = max((one, two), key=lambda look: look.growing).values
        crossed = grown[grown.real > 0]
        crossed = crossed[np.argsort(crossed.real)][: abs(above - below)]
        if not (crossed.real <= JUMP * size).all():
            return None
        rates = sorted(float(w) for w in crossed.imag if w >= 0)
        kind = Crossing.STATIC_AND_FLUTTER if 0 in rates and any(rates) else Crossing.FLUTTER
        kind = kind if any(rates) else Crossing.STATIC
        middle, half = float(low + high) / 2, float(high - low) / 2
        error = half + abs(middle) * NARROW
        numbers = tuple(rates), below, above
        return AxisCrossing(middle, error, kind, *numbers, Evidence.BY_FLOATS)

    def refined(self, low: float, high: float) -> BoundaryPoint | None:
        """A change of verdict between two values, by floats; None where none is found."""
        width = high - low
        low = low if self.quick_sign(low) else low - width  # an end on the boundary itself
        high = high if self.quick_sign(high) else high + width
        if not self.quick_sign(low) * self.quick_sign(high) < 0:
            return None
        found = next(iter(self.crossings(low, high, SIGN).values()))
        return _as_boundary(found) if found is not None else None


def _as_boundary(one: AxisCrossing) -> BoundaryPoint:
    several = one.frequencies if len(one.frequencies) > 1 else ()
    turning = next((w for w in one.frequencies if w), 0.0)
    below = one.unstable_below < one.unstable_above
    numbers = one.value, one.error, one.crossing, turning, below
    return BoundaryPoint(*numbers, Verdict.STABLE, several, Evidence.BY_FLOATS)


def float_boundaries(problem: Problem, grid: Axis) -> Boundaries:
    """Changes of verdict that a scan finds; never complete.

    Parameters
    ----------
    problem
        A problem of a numeric system.
    grid
        The axis; its points are those of the scan.
    """
    points, left = _scanned(problem, grid, SIGN)
    return Boundaries(tuple(map(_as_boundary, points)), left, how=HOW.format(grid.count))


def float_crossings(problem: Problem, grid: Axis) -> Crossings:
    """As `float_boundaries`, every crossing of the imaginary axis that a scan finds."""
    return Crossings(*_scanned(problem, grid, attrgetter("unstable")), how=HOW.format(grid.count))


def _scanned(
    problem: Problem, grid: Axis, key: Callable[[Look], int | None]
) -> tuple[tuple[AxisCrossing, ...], tuple[Unresolved, ...]]:
    """Crossings at which a key changes, and what is open; two between neighbours are not seen."""
    fixed = {n: float(v) for n, v in problem.values.items() if n != grid.name}
    scan = FloatScan(problem, grid.name, fixed)
    places = [float(v) for v in grid.values]
    points: list[AxisCrossing] = []
    left = [Unresolved(grid.low, grid.high, PAIR.format(grid.count))]
    known = [v for v in places if key(scan.look(v)) is not None]
    for low, high in pairwise([places[0], *known, places[-1]]):
        between = [scan.look(v) for v in places if low <= v <= high]
        lost = next((look.why for look in between if look.why), "")
        open_ = any(key(look) is None for look in between)
        ends = key(scan.look(low)), key(scan.look(high))
        if lost or None in ends or (open_ and ends[0] == ends[1]):
            left.append(Unresolved(low, high, NOTHING.format(lost) if lost else WITHIN))
        elif ends[0] != ends[1]:
            try:
                found = scan.crossings(low, high, key)
            except StabilityError as error:
                left.append(Unresolved(low, high, NOTHING.format(error)))
                continue
            points += [one for one in found.values() if one is not None]
            left += [Unresolved(*ends, JUMPS) for ends, one in found.items() if one is None]
    return tuple(points), tuple(left)
