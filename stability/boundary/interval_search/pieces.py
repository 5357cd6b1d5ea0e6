"""An axis cut into pieces: each holds no meeting with the imaginary axis, or one, by proof.

Between two neighbouring meetings with the imaginary axis the verdict is constant.  A simple meeting
changes the verdict once or not at all.  So the verdicts at the ends of its piece decide.  (Where
both ends are unstable, another eigenvalue is unstable at the meeting too: no value is neutral.)

Parts on which the system's conditions fail have no member, and are left out first.

Source: tests/boundary/test_interval_search.py; tests/boundary/test_algebraic_boundaries.py.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import chain, groupby
from typing import Any, TypeVar

import numpy as np
from flint import arb

from ...algebra.number_types import balls, precision
from ...base.errors import NoMemberError, StabilityError
from ...base.types import Floats
from ...base.verdict import DECAYING, Verdict
from ...polynomials.identities import MOST_STATES, certain
from ...spectra.verdict_routes import BITS
from ...systems.structure.enclosure import ball_unknowns
from ...systems.structure.structural_zeros import structure
from ..brackets import (
    AxisScan,
    Boundaries,
    BoundaryPoint,
    Crossings,
    Unresolved,
    at_point,
    bracketed,
    refine,
)
from .disc_meetings import DiscMeetings
from .meetings import FormulaMeetings, GraphMeetings, Meetings, NoValueError, middle_of
from .quick_pieces import Leaf, quick_pieces

MOST_LOST = 200
"""Largest number of pieces that are cut because members are missing, or on several branches."""
FINEST = 2.0**-46
"""Width of the smallest piece, relative to the interval's largest number."""
CUT = 0.4916015625
"""Share of a piece at which it is cut: no simple number, since boundaries often are."""
OTHER_CUTS = (0.5283203125, 0.4619140625)
"""Shares of a cut in case an eigenvalue is on the imaginary axis exactly at the first one."""
CLOSE = 2.0**-16
"""Share of the interval below which a piece next to a singular value is not cut."""
EXPLORED = 1 / 16
"""Share of the interval up to which a piece is cut although no member was found in it."""

TOUCH = (
    "an eigenvalue may touch the imaginary axis here without crossing it, or several may meet it "
    "too near to each other"
)
NO_MEMBER = (
    "no unique steady motion is proved here: there is none, two of them meet, or the enclosures of "
    "a regular one are still too wide"
)
NO_VALUE = "the linearisation has no value, or no finite enclosure, somewhere here"
BRANCH = (
    "the members at both ends are not proved to lie on one branch of steady motions: the "
    "root-finder may pass to another one, or another is near; search shorter intervals, or take "
    "the family from System.steady and follow it with st.branch"
)
ALONG = "an eigenvalue stays on the imaginary axis along all of it, as far as {bits} bits show"


@dataclass(frozen=True)
class AxisPieces:
    """What was proved along an axis."""

    leaves: tuple[Leaf, ...]
    """Leaves in increasing order, neighbours alike joined; from `low` to `high` without a gap."""
    low: float
    """Low end of what was searched: the interval's, or a little below it."""
    high: float
    """High end."""
    count: int
    """Number of pieces that were examined."""


def pieces(
    line: AxisScan,
    low: float,
    high: float,
    *,
    log: bool = False,
    singular: Mapping[float, str] | None = None,
    every: bool = False,
) -> AxisPieces:
    """Proof along an axis of where an eigenvalue meets the imaginary axis, and where none does.

    Parameters
    ----------
    line
        The line.
    low, high
        Ends of the interval.
    log
        Whether pieces are cut at equal ratios.
    singular
        Values near which no member can be proved, each with the reason.
    every
        Whether pieces on which another eigenvalue stays unstable are searched too.
    """
    try:
        meetings = _meetings(line)
    except StabilityError as error:
        meetings = str(error)
    if isinstance(meetings, str):
        return AxisPieces((Leaf(low, high, None, meetings),), low, high, 0)
    meetings.every = every
    leaves, waiting, count = [], [(low, high)], 0
    quick = (
        quick_pieces(meetings, low, high, log=log)
        if isinstance(meetings, FormulaMeetings)
        else None
    )
    if quick is not None:
        leaves, waiting, count = list(quick.leaves), list(quick.left), quick.count
        if not waiting:
            return AxisPieces(tuple(_joined(leaves)), low, high, count)
    tests = [low + share * (high - low) for share in (0.2718, 0.5772, 0.8541)]
    if (
        not leaves
        and not any(meetings.clear(v) for v in tests)
        and any(meetings.root(v) is not None for v in tests)
    ):
        reason = ALONG.format(bits=BITS)
        return AxisPieces((Leaf(low, high, None, reason),), low, high, len(tests))
    least = FINEST * max(abs(low), abs(high))
    ends = _beyond(meetings, low, -least), _beyond(meetings, high, least)
    waiting = [(ends[0] if a == low else a, ends[1] if b == high else b) for a, b in waiting]
    search = _PieceSearch(meetings, *ends, least, log=log and ends[0] > 0)
    search.singular = singular or {}
    searched = search.run(waiting, count)
    return AxisPieces(tuple(_joined([*leaves, *searched[0]])), *ends, searched[1])


def _meetings(line: AxisScan) -> Meetings | str:
    family = line.problem.family
    if line.formulas is not None:
        return FormulaMeetings(line, line.formulas)
    zeros = structure(family).zeros
    if not line.problem.derived and not certain(family):
        return "the number of eigenvalues that are zero by structure is not proved for all members"
    meetings = GraphMeetings(line, zeros)
    if not meetings.even and zeros < 2:
        return DiscMeetings(line, zeros)
    largest = max(map(len, meetings.blocks))
    if largest > MOST_STATES:
        return (
            f"the linearisation has a block of {largest} states; where its spectrum is symmetric, "
            f"or several eigenvalues are zero by structure, pieces are proved up to {MOST_STATES}"
        )
    return meetings


def _beyond(meetings: Meetings, end: float, step: float) -> float:
    """The end, or a number a little beyond where an eigenvalue is on the axis at the end itself."""
    if meetings.root(end) is None or meetings.clear(end):
        return end
    for factor in (5.3, 37.1, 1021.7):
        if meetings.clear(end + factor * step):
            return end + factor * step
    return end


class _PieceSearch:
    """Pieces in the order of their width, widest first."""

    def __init__(
        self, meetings: Meetings, low: float, high: float, least: float, *, log: bool
    ) -> None:
        self.meetings, self.low, self.high = meetings, low, high
        self.least, self.log = least, log
        self.most, self.lost = meetings.most, 0
        self.singular: Mapping[float, str] = {}

    def run(self, waiting: list[tuple[float, float]], count: int) -> tuple[list[Leaf], int]:
        """The leaves of pieces, not in order, and the number of pieces with those before."""
        heap = [(-self._width(*ends), *ends, "") for ends in waiting]
        heapq.heapify(heap)
        leaves: list[Leaf] = []
        self.most += count
        while heap:
            if not self.meetings.prepared(middle_of(*heap[0][1:3])):
                self._prepare([waiting[1:3] for waiting in heap[: self.most - count]])
            _, low, high, reason = heapq.heappop(heap)
            if count >= self.most:
                why = f"the budget of {self.most} pieces ended" + (reason and f"; {reason}")
                leaves.append(Leaf(low, high, None, why))
                continue
            count += 1
            leaf = self._singular(low, high) or self._examined(low, high)
            if leaf.meetings in (0, 1) or leaf.reason in self.singular.values():
                leaves.append(leaf)
                continue
            cut = self._cut(low, high)
            if not self._divisible(leaf, cut):
                leaves.append(leaf)
                continue
            for part in ((low, cut), (cut, high)):
                heapq.heappush(heap, (-self._width(*part), *part, leaf.reason))
        return leaves, count

    def _prepare(self, waiting: list[tuple[float, float]]) -> None:
        """Members in all pieces that wait, at once: one at a time each takes as long as all."""
        places = (middle_of, lambda low, high: self._at(low, high, CUT))
        self.meetings.prepare([*chain(*waiting), *(at(*pair) for pair in waiting for at in places)])

    def _width(self, low: float, high: float) -> float:
        return math.log(high / low) if self.log else high - low

    def _cut(self, low: float, high: float) -> float:
        """Where a piece is cut: not where an eigenvalue is on the axis, if that can be avoided."""
        cuts = [self._at(low, high, share) for share in (CUT, *OTHER_CUTS)]
        return next((c for c in cuts if self.meetings.clear(c)), cuts[0])

    def _at(self, low: float, high: float, share: float) -> float:
        if self.log:
            return low * math.exp(share * math.log(high / low))
        return low + (high - low) * share

    def _divisible(self, leaf: Leaf, cut: float) -> bool:
        width = leaf.high - leaf.low
        if width <= self.least or not leaf.low < cut < leaf.high:
            return False
        if not self.meetings.divisible(leaf.low, leaf.high):
            return False
        here = self.meetings.root(middle_of(leaf.low, leaf.high)) is not None
        if leaf.reason == BRANCH or (leaf.reason == NO_MEMBER and not here):
            self.lost += 1
            if self.lost > MOST_LOST:
                return False
        if leaf.reason == NO_MEMBER and width < EXPLORED * (self.high - self.low):
            return any(self.meetings.root(v) is not None for v in (leaf.low, cut, leaf.high))
        return True

    def _singular(self, low: float, high: float) -> Leaf | None:
        """A narrow piece next to a value near which no member can be proved."""
        width = high - low
        if width > CLOSE * (self.high - self.low):
            return None
        near = (v for v in self.singular if low - width <= v <= high + width)
        return next((Leaf(low, high, None, self.singular[v]) for v in near), None)

    def _examined(self, low: float, high: float) -> Leaf:
        try:
            with precision(BITS):
                piece = self.meetings.piece(low, high)
                if not self.meetings.joined(piece):
                    return Leaf(low, high, None, BRANCH)
                count = self.meetings.zeros_in(piece)
                near = None
                with suppress(NoMemberError):  # the middle of a box need not be near its member
                    near = self.meetings.near(piece) if count == 1 else None
        except NoMemberError:
            return Leaf(low, high, None, NO_MEMBER)
        except (NoValueError, ZeroDivisionError, OverflowError):
            return Leaf(low, high, None, NO_VALUE)
        except StabilityError as error:
            return Leaf(low, high, None, str(error))
        reason = TOUCH if count is None or count > 1 else ""
        return Leaf(low, high, count, reason, near, sure=near is not None)


def _joined(leaves: list[Leaf]) -> Iterator[Leaf]:
    """Leaves in order; neighbours without meetings as one, and so neighbours without a proof."""
    ordered = sorted(leaves, key=lambda leaf: leaf.low)
    for meetings, group in groupby(ordered, key=lambda leaf: leaf.meetings):
        some = list(group)
        if meetings:
            yield from some
        else:
            reasons = dict.fromkeys(leaf.reason for leaf in some if leaf.reason)
            yield Leaf(some[0].low, some[-1].high, meetings, "; or ".join(reasons))


SCANNED = "verdicts at the points of a scan, refined and proved where neighbours differ"


def scanned(line: AxisScan, grid: Floats, why: str = "") -> Boundaries:
    """Changes between the points of a scan, and the pieces on which it excludes none.

    Parameters
    ----------
    line
        The line.
    grid
        Points of the scan, in increasing order.
    why
        Reason why the axis is scanned, for the statement.

    Raises
    ------
    StabilityError
        If there is no member at any point.
    """
    values = [float(v) for v in grid]
    signs, left = _scan_signs(line, values)
    signed = [i for i, s in enumerate(signs) if s]
    if not signed:
        reason = (
            f"no verdict is proved at any of the {len(grid)} points of the scan: eigenvalues stay "
            "on the imaginary axis, or coincide, as far as the budget of precision sees."
        )
        return Boundaries((), (Unresolved(values[0], values[-1], reason),), how=SCANNED)
    for end, first in ((0, signed[0]), (len(values) - 1, signed[-1])):
        if end != first:
            low, high = sorted((values[end], values[first]))
            left.append(Unresolved(low, high, _no_verdict(values[end])))
    points: list[BoundaryPoint] = []
    for i, j in zip(signed[:-1], signed[1:], strict=True):
        point = _between(line, values[i : j + 1], changed=signs[i] != signs[j])
        if point is not None:
            points.append(point)
        elif signs[i] != signs[j]:
            reason = "the verdicts at the ends differ, but the change could not be bracketed."
            left.append(Unresolved(values[i], values[j], reason))
        elif j > i + 1:
            left.append(Unresolved(values[i], values[j], _no_verdict(values[i + 1])))
    left.append(
        Unresolved(
            values[0],
            values[-1],
            f"between neighbours of the {len(grid)} points of the scan a pair "
            "of changes is not excluded" + (f": {why}." if why else "."),
        )
    )
    return Boundaries(tuple(points), tuple(left), how=SCANNED)


def _scan_signs(line: AxisScan, values: Sequence[float]) -> tuple[list[int], list[Unresolved]]:
    """Signs by `look` at the points of a scan, and the points without a member."""
    verdicts: list[tuple[Verdict, bool]] = []
    left: list[Unresolved] = []
    errors: list[StabilityError] = []
    for value in values:
        try:
            verdicts.append(line.look(value))
        except StabilityError as error:
            verdicts.append((Verdict.UNDECIDED, False))
            errors.append(error)
            left.append(Unresolved(value, value, f"no verdict there: {error}"))
    if len(errors) == len(values):
        raise errors[0]
    # among decaying members a neutral one is on a boundary; without these neutral is good
    line.neutral = all(verdict not in DECAYING for verdict, _ in verdicts)
    return [line.sign_of(*pair) for pair in verdicts], left


def _no_verdict(value: float) -> str:
    return (
        f"no verdict is proved at {value:.10g}: an eigenvalue lies on the imaginary axis there, or "
        "too near to it."
    )


def _between(line: AxisScan, values: Sequence[float], *, changed: bool) -> BoundaryPoint | None:
    """The change between two points with a verdict; points between the two have none."""
    if not changed:
        return None
    try:
        point = at_point(line, values[1]) if len(values) == 3 else None  # on the boundary itself
        return point or refine(line, values[0], values[-1])
    except StabilityError:  # there is no member somewhere between
        return None


PIECES = (
    "in ball arithmetic each of {count} pieces was proved to hold no eigenvalue on the imaginary "
    "axis, or a single crossing"
)
NARROW = 8
"""Largest half-width of a bracket about a root that is known, in units of its last place."""
ON_ONE_BRANCH = "on one branch of steady motions"


def proved(
    line: AxisScan,
    grid: Floats,
    *,
    log: bool = False,
    singular: Mapping[float, str] | None = None,
) -> Boundaries:
    """Every change of verdict along an axis that need not be rational, with what stays open.

    Parameters
    ----------
    line
        The line.
    grid
        Points of a scan for the pieces without proof; its ends are those of the interval.
    log
        Whether the points have equal ratios.
    singular
        As for `pieces`.
    """
    low, high = float(grid[0]), float(grid[-1])
    searched = pieces(line, low, high, log=log, singular=singular)
    if all(leaf.meetings is None for leaf in searched.leaves):
        return scanned(line, grid, searched.leaves[0].reason)
    points: list[BoundaryPoint] = []
    left: list[Unresolved] = []
    for leaf in searched.leaves:
        if leaf.meetings is None:
            part = _open(line, leaf, grid)
        elif leaf.meetings:
            part = _meeting(line, leaf, low, high)
        else:
            continue
        points += part[0]
        left += part[1]
    inside = [p for p in points if low <= p.value + p.error and p.value - p.error <= high]
    return Boundaries(tuple(inside), tuple(left), how=how_in_pieces(line, searched))


def how_in_pieces(line: AxisScan, searched: AxisPieces) -> str:
    """How an axis was searched, in words."""
    family = line.problem.family
    solved = family.unknown and not family.closed
    return PIECES.format(count=searched.count) + (f", {ON_ONE_BRANCH}" if solved else "")


LeafResult = tuple[list[BoundaryPoint], list[Unresolved]]


def _meeting(line: AxisScan, leaf: Leaf, low: float, high: float) -> LeafResult:
    """The change at the meetings of a piece: one or two, so that ends that differ mean one."""
    first, last = max(leaf.low, low), min(leaf.high, high)
    try:
        point = _at_once(line, leaf)
        if point is not None:
            return [point], []
        signs = line.sign(leaf.low), line.sign(leaf.high)
        if signs[0] == signs[1] != 0 and leaf.meetings == 1:
            return [], []
        if signs[0] * signs[1] < 0 and leaf.meetings in (1, 2):
            point = _at_end(line, leaf, low, high) or _change_at(line, leaf)
            point = point or refine(line, leaf.low, leaf.high)
            if point is not None:
                return [point], []
    except StabilityError as error:
        return [], [Unresolved(first, last, f"no verdict there: {error}")]
    reason = TOUCH if signs[0] == signs[1] else "the change could not be bracketed"
    return [], [Unresolved(first, last, f"{reason}.")]


def _at_once(line: AxisScan, leaf: Leaf) -> BoundaryPoint | None:
    """The change at a known single meeting with proved verdicts that differ right next to it.

    The verdicts at the ends of the piece follow from these, since nothing else changes on it.
    """
    if leaf.near is None or leaf.meetings != 1:
        return None
    step = float(np.spacing(abs(leaf.near[0])))
    sides = leaf.near[0] - step, leaf.near[0] + step
    if not leaf.low <= sides[0] < sides[1] <= leaf.high:
        return None
    return _change_at(line, leaf) if line.sign(sides[0]) * line.sign(sides[1]) < 0 else None


def _change_at(line: AxisScan, leaf: Leaf) -> BoundaryPoint | None:
    """The change at a meeting that is known to double precision."""
    if leaf.near is None:
        return None
    change = bracketed(line, *leaf.near, sure=leaf.sure)
    return change if change and change.error <= NARROW * np.spacing(abs(change.value)) else None


def _at_end(line: AxisScan, leaf: Leaf, low: float, high: float) -> BoundaryPoint | None:
    """The change at an end of the interval itself, beyond which the search went on a little."""
    for end, beyond in ((low, leaf.low < low), (high, leaf.high > high)):
        if beyond and not line.sign(end):
            return at_point(line, end)
    return None


def _open(line: AxisScan, leaf: Leaf, grid: Floats) -> LeafResult:
    """What a scan finds on a piece without proof, which stays unresolved."""
    first, last = max(leaf.low, float(grid[0])), min(leaf.high, float(grid[-1]))
    inside = grid[(grid > leaf.low) & (grid < leaf.high)]
    before = line.neutral
    try:
        points = list(scanned(line, np.array([leaf.low, *inside, leaf.high])))
    except StabilityError:  # no member at any point: the reason says so
        points = []
    finally:
        line.neutral = before
    if NO_VALUE in leaf.reason:  # through a pole the verdict changes, and no eigenvalue is zero
        points = [point for point in points if _has_value(line, point)]
    return points, [Unresolved(first, last, f"{leaf.reason}.")]


def _has_value(line: AxisScan, point: BoundaryPoint) -> bool:
    """Whether the linearisation has a finite enclosure over the bracket of a change."""
    with precision(BITS):
        over = arb(point.value, 2 * point.error)
        try:
            return all(c.is_finite() for c in line.enclosed(over, BITS))
        except (StabilityError, ArithmeticError):
            return False


AxisResult = TypeVar("AxisResult", Boundaries, Crossings)
MOST_PARTS = 600
"""Largest number of pieces."""
UNSURE = "whether the conditions of {system} hold here is not decided"
FAILS = "{family} has no member here, since a condition of {system} fails: {sentence}"


def meaningful(line: AxisScan, low: float, high: float, result: AxisResult) -> AxisResult:
    """A result without the parts of the axis on which the system's conditions are not proved.

    Parameters
    ----------
    line
        The line.
    low, high
        Ends of the interval.
    result
        What was found without regard to the conditions.

    Returns
    -------
    Boundaries
        These parts are unresolved, each with the condition.
    """
    if not line.problem.plain or not line.problem.family.system.conditions:
        return result
    parts: list[Unresolved] = [
        u for u in _Conditions(line).fail(low, high) if not _inside(u, result.unresolved)
    ]
    if not parts:
        return result

    def free(value: float, error: float = 0.0) -> bool:
        return not any(u.low <= value + error and value - error <= u.high for u in parts)

    return replace(
        result,
        points=tuple(p for p in result.points if free(p.value, p.error)),
        touching=tuple(v for v in result.touching if free(v)),
        unresolved=tuple(
            sorted([*(u for u in result.unresolved if not _inside(u, parts)), *parts])
        ),
    )


def _inside(part: Unresolved, others: Sequence[Unresolved]) -> bool:
    return any(o.low <= part.low and part.high <= o.high for o in others)


class _Conditions:
    """The system's conditions along a line, in balls."""

    def __init__(self, line: AxisScan) -> None:
        self.line, self.family = line, line.problem.family

    def fail(self, low: float, high: float) -> list[Unresolved]:
        """Parts on which a condition fails, or is not decided, neighbours alike as one."""
        least = FINEST * max(abs(low), abs(high))
        level = [(low, high)]
        parts: list[Unresolved] = []
        count = 0
        while level:
            cuts = [first + (last - first) * CUT for first, last in level]
            wider, level = level, []
            for (first, last), cut, near in zip(wider, cuts, self._members(wider), strict=True):
                count += 1
                reason = self._reason(first, last, near)
                if reason == "":
                    continue
                if reason or count > MOST_PARTS or last - first <= least or not first < cut < last:
                    unsure = UNSURE.format(system=self.family.system.name)
                    parts.append(Unresolved(first, last, f"{reason or unsure}."))
                    continue
                level += [(first, cut), (cut, last)]
        return _joined_parts(parts)

    def _members(self, level: Sequence[tuple[float, float]]) -> list[list[float] | None]:
        """Unknowns at the middle of each piece in double precision, followed all at once."""
        family = self.family
        if not family.unknown or family.closed:
            return [[]] * len(level)
        with precision(BITS):
            return self.line.followed([_ball(*ends).mid() for ends in level])

    def _reason(self, low: float, high: float, near: list[float] | None) -> str | None:
        """Empty where all conditions hold on a piece; None where this is open."""
        if near is None:
            return None
        with precision(BITS):
            try:
                values = self._values(_ball(low, high), near)
            except (StabilityError, ZeroDivisionError):
                return None
            if all(v > 0 for v in values):
                return ""
            for condition, value in zip(self.family.system.conditions, values, strict=True):
                if value <= 0:
                    said = condition.refusal(float(value.mid())).rstrip(".")
                    names = {"family": self.family.name, "system": self.family.system.name}
                    return FAILS.format(sentence=said, **names)
        return None

    def _values(self, place: Any, near: list[float]) -> list[Any]:
        family = self.family
        a, q = self.line.numbers_at(place)
        u = ball_unknowns(family, a, q, near)
        states = [arb(row[0]) for row in family.graph.state.dense(balls(), [a, u, q])]
        names = (*family.at, *family.unknown, *family.parameters)
        values = dict(zip(names, (*a, *u, *q), strict=True))
        parameters = [values[n] for n in family.system.parameters]
        return [
            arb(v[0]) if v else arb(0)
            for v in family.system.condition_program.run(balls(), [states, parameters])
        ]


def _ball(low: float, high: float) -> Any:
    """A ball that holds a piece."""
    half = (arb(high) - arb(low)) / 2
    middle = arb(low) + half
    return arb(middle.mid(), (half + middle.rad()).abs_upper())


def _joined_parts(parts: list[Unresolved]) -> list[Unresolved]:
    """Touching parts as one, with every reason; a tiny part takes that of its neighbour."""
    out: list[Unresolved] = []
    for part in sorted(parts):
        if out and part.low <= np.nextafter(out[-1].high, np.inf):
            before = out.pop()
            wide = max(before, part, key=lambda u: u.high - u.low)
            out.append(Unresolved(before.low, part.high, wide.reason))
        else:
            out.append(part)
    return out
