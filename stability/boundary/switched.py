"""Changes of verdict along an axis with switches: from one smooth piece to the next.

Between two switches, such as knots of a table, the system is that of the smooth piece, and its
search is complete up to both ends.  At a switch the pieces agree, so that the verdict at the switch
is that of either, or the verdict on it stays open, with those on its two sides.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from itertools import pairwise
from types import MappingProxyType
from typing import Any, TypeVar

import numpy as np

from ..base.errors import StabilityError
from ..base.types import Floats
from ..base.verdict import Verdict
from ..spectra.certificate import verdict
from ..spectra.problem import Problem, known_numbers
from ..systems.family import Family
from ..systems.graph.sides import continuous, on_sides, switches
from ..systems.members import Anchor
from .brackets import (
    AxisCrossing,
    AxisScan,
    Boundaries,
    Crossings,
    Unresolved,
    at_point,
    crossed,
    zero_between,
)

Points = TypeVar("Points", Boundaries, Crossings)
Search = Callable[[Problem, str, float, float], Boundaries]
"""A search for changes of verdict, of (problem, axis, low, high)."""
NONE: Mapping[tuple[str, float], int] = MappingProxyType({})
WIDER = 8
"""Widths of an open part by which it is widened to see a switch."""
JUMP = "the equations switch here, and the linearisation jumps; "
PASSED = "members pass a switch of the equations here, {} = {:.12g}; "
LOST = "no crossing is proved at the switch here, and "


def switched(family: Family, axis: str) -> tuple[float, ...]:
    """Places of the switches along an axis of a user's family."""
    if family.formulas is not None or family.exact is not None:
        return ()
    return switches(family.system).get(family.meaning(axis), ())


def joined(
    problem: Problem,
    axis: str,
    places: Sequence[float],
    search: Callable[[Problem, str, float, float], Points],
) -> Points:
    """The changes of verdict, or crossings, on the smooth pieces of an axis, and at the switches.

    Parameters
    ----------
    problem, axis
        As in `along`.
    places
        The ends of the interval, and the switches between.
    search
        The search on a smooth piece.
    """
    fixed = {n: float(v) for n, v in problem.values.items() if n != axis}
    line, family = AxisScan(problem, axis, fixed), problem.family
    name, numbers = family.meaning(axis), known_numbers(family, fixed)
    parts = [
        search(_piece(line, (low + high) / 2, {name: (low + high) / 2}), axis, low, high)
        for low, high in pairwise(places)
    ]
    met = set(places) & set(switched(family, axis))
    points: list[list[Any]] = [
        [b for b in part if not any(_on(b, v) for v in met)] for part in parts
    ]
    left = [part for one in parts for part in one.unresolved]
    found: list[Any] = [b for some in points for b in some]
    touching = {v for part in parts for v in part.touching}
    for i, place in enumerate(places):
        if place not in met:
            continue
        words = [_beside(line, places, points, j, place) for j in (i - 1, i)]
        changes = 0 < i < len(parts) and words[0] != words[1]
        reached = [b for part in parts[max(i - 1, 0) : i + 1] for b in part if _on(b, place)]
        if not continuous(family.system, {**numbers, name: place}):
            left.append(_open(place, JUMP, words))
        elif point := _at_switch(line, place, reached, changes=changes):
            if isinstance(point, AxisCrossing) and point.unstable_below == point.unstable_above:
                touching.add(place)
            else:
                found.append(point)
        elif changes or any(isinstance(b, AxisCrossing) for b in reached):
            if not any(part.low <= place <= part.high for part in left):
                left.append(_open(place, LOST, words))
        elif reached:
            touching.add(place)
    return replace(
        parts[0],
        throughout=None if found else parts[0].throughout,
        points=tuple(sorted(found, key=lambda b: b.value)),
        unresolved=tuple(sorted(left)),
        touching=tuple(sorted(touching - {b.value for b in found})),
        how=f"between neighbouring switches of {axis}, {parts[0].how}",
    )


def _at_switch(line: AxisScan, place: float, reached: Sequence[Any], *, changes: bool) -> Any:
    """What crosses at a switch that pieces reach, or at which the verdict changes; or None."""
    if any(isinstance(b, AxisCrossing) for b in reached):
        below, above = reached[0], reached[-1]
        if len(reached) != 2 or below.crossing is not above.crossing:
            return None
        error = max(abs(b.value - place) + b.error for b in reached)
        return replace(above, value=place, error=error, unstable_below=below.unstable_below)
    with suppress(StabilityError):
        if (changes or reached) and (point := at_point(line, place)):
            return crossed(line, point)
    return None


def _open(place: float, reason: str, words: Sequence[str]) -> Unresolved:
    """The doubles next to a switch, left open with the verdicts on its two sides."""
    low, high = (float(np.nextafter(place, way)) for way in (-np.inf, np.inf))
    return Unresolved(low, high, reason + _sides(words))


def _sides(words: Sequence[str]) -> str:
    said = "is the same on both sides" if words[0] == words[1] else "differs on the two sides"
    return f"the verdict {said}: {words[0]} below, {words[1]} above."


def passings(line: AxisScan, grid: Floats) -> dict[float, str]:
    """Where members pass a switch through which the linearisation goes: there both sides decide."""
    problem, family = line.problem, line.problem.family
    found: dict[float, str] = {}
    for name, place in _unknown_switches(family):
        if not continuous(family.system, {name: place}):
            continue
        index = list(family.unknown).index(name)

        def beyond(value: Any, index: int = index, place: float = place) -> Any:
            a, q, *_ = problem.arrays({**line.fixed, line.axis: value})
            members = family.search(a, q)
            return np.where(members.good, members.u[:, index] - place, np.nan)

        values = beyond(np.asarray(grid))
        for i in np.flatnonzero(values[:-1] * values[1:] < 0):
            with suppress(ValueError, StabilityError):
                root = zero_between(lambda v: float(beyond(v)[0]), grid[i], grid[i + 1])
                found[root] = PASSED.format(name, place)
    return found


def _unknown_switches(family: Family) -> list[tuple[str, float]]:
    """The switches of the states that a family solves for."""
    if not family.unknown or family.closed:
        return []
    every = switches(family.system)
    return [(name, place) for name in family.unknown for place in every.get(name, ())]


def met_by_members(line: AxisScan, found: Boundaries, search: Search) -> Boundaries:
    """A result where members pass switches: proved there by both sides, or open with both verdicts.

    A member on a switch belongs to the equations of either side.  Where the linearisation goes
    through, and the verdict of each side is proved not to change nearby, so is that of the members.
    """
    problem, family = line.problem, line.problem.family
    if not (places := _unknown_switches(family)):
        return found
    left = []
    for part in found.unresolved:
        room = WIDER * (part.high - part.low)
        values = part.low - room, part.high + room
        a, q, *_ = problem.arrays({**line.fixed, line.axis: np.array(values)})
        members = family.search(a, q)
        if members.good.all() and (passed := _passed(family, members.u, places)):
            words = [_verdict(line, value) for value in values]
            if words[0] == words[1] and continuous(family.system, dict([passed])):
                sides = [
                    _piece(line, sum(values) / 2, dict([passed]), {passed: way}) for way in (1, -1)
                ]
                if all(_constant(side, line, values, words[0], search) for side in sides):
                    continue
            part = part._replace(reason=PASSED.format(*passed) + _sides(words))
        left.append(part)
    return replace(found, unresolved=tuple(left))


def _passed(
    family: Family, u: Floats, places: Sequence[tuple[str, float]]
) -> tuple[str, float] | None:
    """The one switch between two members, or None."""
    ends = dict(zip(family.unknown, u.T, strict=True))
    passed = [(n, v) for n, v in places if (ends[n][0] - v) * (ends[n][1] - v) <= 0]
    return passed[0] if len(passed) == 1 else None


def _constant(
    side: Problem, line: AxisScan, ends: tuple[float, float], word: str, search: Search
) -> bool:
    """Whether the verdict of one side is proved to be one word between two values."""
    found = search(side, line.axis, *ends)
    middle = AxisScan(side, line.axis, line.fixed)
    return (
        found.complete
        and not found
        and not found.touching
        and _verdict(middle, sum(ends) / 2) == word
    )


def _on(point: Any, place: float) -> bool:
    """Whether a place lies in the proved bracket of a crossing."""
    return bool(abs(point.value - place) <= point.error)


def _verdict(line: AxisScan, value: float) -> str:
    with suppress(StabilityError):
        return verdict(line.problem, {**line.fixed, line.axis: value}).word
    return Verdict.UNDECIDED.word


def _beside(
    line: AxisScan,
    places: Sequence[float],
    points: Sequence[Sequence[Any]],
    j: int,
    place: float,
) -> str:
    """The verdict on piece j next to one of its ends."""
    if not 0 <= j < len(points):
        return "not asked"
    values = [places[j], *(b.value for b in points[j]), places[j + 1]]
    other = values[1] if place == places[j] else values[-2]
    return _verdict(line, (place + other) / 2)


def _piece(
    line: AxisScan,
    middle: float,
    numbers: Mapping[str, float],
    ways: Mapping[tuple[str, float], int] = NONE,
) -> Problem:
    """The problem with the equations around some numbers, followed from a member of the line."""
    family = line.problem.family
    near = ", ".join(f"{name} near {value:.6g}" for name, value in numbers.items())[:50]
    below = "below " if -1 in ways.values() else ""
    # a name of its own: systems of one name would be compared in full
    system = on_sides(family.system, numbers, ways)
    smooth = replace(family, system=replace(system, name=f"{system.name[:40]} ({below}{near})"))
    if family.unknown and not family.closed:
        with suppress(StabilityError):
            a, q, *_ = line.problem.arrays({**line.fixed, line.axis: middle})
            u = tuple(family.solve(a, q)[0].tolist())
            anchor = Anchor(tuple(a[0].tolist()), tuple(q[0].tolist()), u)
            guess = dict(zip(family.unknown, u, strict=True))
            smooth = replace(smooth, unknown=guess, anchor=anchor if family.anchor else None)
    return replace(line.problem, family=smooth, exact=None)
