"""An axis cut into pieces: each is proved to hold no meeting with the imaginary axis, or one.

Source: tests/boundary/test_interval_search.py.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import chain, groupby
from typing import Any

from ...algebra.balls import precision
from ...base.errors import NoMemberError, StabilityError
from ...systems.structure.identities import certain
from ...systems.structure.structural_zeros import structure
from ..brackets import BITS, AxisScan
from ..crossings import Crossing
from .blocks import NoValueError
from .formula_meetings import FormulaMeetings
from .meetings import Meetings, middle_of
from .quick_pieces import Quick, quick_pieces

MOST_PIECES = 1200
"""Largest number of pieces for a system of few states."""
MOST_WORK = 400_000
"""Largest number of pieces times the cube of the number of states."""
MOST_LOST = 200
"""Largest number of pieces that are cut because members are missing, or on several branches."""
MOST_STATES = 16
"""Largest number of states in one block of the linearisation."""
FINEST = 2.0**-46
"""Width of the smallest piece, relative to the interval's largest number."""
CUT = 0.4916015625
"""Share of a piece at which it is cut: no simple number, since boundaries often are."""
OTHER_CUTS = (0.5283203125, 0.4619140625)
"""Shares of a cut in case an eigenvalue is on the imaginary axis exactly at the first one."""
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
class Leaf:
    """A piece of the axis at which the search ended."""

    low: float
    """Low end."""
    high: float
    """High end."""
    meetings: int | None
    """Number of simple meetings with the imaginary axis in it; None where this is not proved."""
    reason: str = ""
    """Reason why nothing is proved."""
    near: tuple[float, Crossing] | None = None
    """The single meeting to double precision, where it is known."""


@dataclass(frozen=True)
class Pieces:
    """What was proved along an axis."""

    leaves: tuple[Leaf, ...]
    """Leaves in increasing order, neighbours alike joined; from `low` to `high` without a gap."""
    low: float
    """Low end of what was searched: the interval's, or a little below it."""
    high: float
    """High end."""
    count: int
    """Number of pieces that were examined."""


def pieces(line: AxisScan, low: float, high: float, *, log: bool = False) -> Pieces:
    """Proof along an axis of where an eigenvalue meets the imaginary axis, and where none does.

    Parameters
    ----------
    line
        The line.
    low, high
        Ends of the interval.
    log
        Whether pieces are cut at equal ratios.

    Returns
    -------
    Pieces
    """
    try:
        found = _meetings(line)
    except StabilityError as error:
        found = str(error)
    if isinstance(found, str):
        return Pieces((Leaf(low, high, None, found),), low, high, 0)
    leaves, waiting, count = [], [(low, high)], 0
    quick = quick_pieces(found, low, high, log=log) if isinstance(found, FormulaMeetings) else None
    if quick is not None:
        leaves, waiting, count = _leaves(quick), list(quick.left), quick.count
        if not waiting:
            return Pieces(tuple(_joined(leaves)), low, high, count)
    tests = [low + share * (high - low) for share in (0.2718, 0.5772, 0.8541)]
    if (
        not leaves
        and not any(found.clear(v) for v in tests)
        and any(found.root(v) is not None for v in tests)
    ):
        reason = ALONG.format(bits=BITS)
        return Pieces((Leaf(low, high, None, reason),), low, high, len(tests))
    least = FINEST * max(abs(low), abs(high))
    ends = _beyond(found, low, -least), _beyond(found, high, least)
    waiting = [(ends[0] if a == low else a, ends[1] if b == high else b) for a, b in waiting]
    searched = _Search(found, *ends, least, log=log and ends[0] > 0).run(waiting, count)
    return Pieces(tuple(_joined([*leaves, *searched[0]])), *ends, searched[1])


def _leaves(quick: Quick) -> list[Leaf]:
    """The pieces that doubles prove."""
    one = [
        Leaf(s.low, s.high, 1, near=None if s.crossing is None else (s.root, s.crossing))
        for s in quick.single
    ]
    return [*(Leaf(*ends, 0) for ends in quick.clear), *one]


def _meetings(line: AxisScan) -> Meetings | FormulaMeetings | str:
    family = line.problem.family
    if line.formulas is not None:
        return FormulaMeetings(line, line.formulas)
    zeros = structure(family).zeros
    if not line.problem.derived and not certain(family):
        return "the number of eigenvalues that are zero by structure is not proved for all members"
    found = Meetings(line, zeros)
    largest = max(map(len, found.blocks))
    if largest > MOST_STATES:
        return (
            f"the linearisation has a block of {largest} states; pieces are proved up to "
            f"{MOST_STATES}"
        )
    return found


def _beyond(found: Meetings | FormulaMeetings, end: float, step: float) -> float:
    """The end, or a number a little beyond where an eigenvalue is on the axis at the end itself."""
    if found.root(end) is None or found.clear(end):
        return end
    for factor in (5.3, 37.1, 1021.7):
        if found.clear(end + factor * step):
            return end + factor * step
    return end


class _Search:
    """Pieces in the order of their width, widest first."""

    def __init__(
        self, found: Meetings | FormulaMeetings, low: float, high: float, least: float, *, log: bool
    ) -> None:
        self.found, self.low, self.high = found, low, high
        self.least, self.log = least, log
        self.most = min(MOST_PIECES, MOST_WORK // max(map(len, found.blocks)) ** 3)
        self.lost = 0

    def run(self, waiting: list[tuple[float, float]], count: int) -> tuple[list[Leaf], int]:
        """The leaves of pieces, not in order, and the number of pieces with those before."""
        heap = [(-self._width(*ends), *ends, "") for ends in waiting]
        heapq.heapify(heap)
        leaves: list[Leaf] = []
        self.most += count
        while heap:
            if not self.found.prepared(middle_of(*heap[0][1:3])):
                self._prepare([waiting[1:3] for waiting in heap[: self.most - count]])
            _, low, high, reason = heapq.heappop(heap)
            if count >= self.most:
                why = f"the budget of {self.most} pieces ended" + (reason and f"; {reason}")
                leaves.append(Leaf(low, high, None, why))
                continue
            count += 1
            leaf = self._examined(low, high)
            if leaf.meetings in (0, 1):
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
        self.found.prepare([*chain(*waiting), *(at(*pair) for pair in waiting for at in places)])

    def _width(self, low: float, high: float) -> float:
        return math.log(high / low) if self.log else high - low

    def _cut(self, low: float, high: float) -> float:
        """Where a piece is cut: not where an eigenvalue is on the axis, if that can be avoided."""
        cuts = [self._at(low, high, share) for share in (CUT, *OTHER_CUTS)]
        return next((c for c in cuts if self.found.clear(c)), cuts[0])

    def _at(self, low: float, high: float, share: float) -> float:
        if self.log:
            return low * math.exp(share * math.log(high / low))
        return low + (high - low) * share

    def _divisible(self, leaf: Leaf, cut: float) -> bool:
        width = leaf.high - leaf.low
        if width <= self.least or not leaf.low < cut < leaf.high:
            return False
        here = self.found.root(middle_of(leaf.low, leaf.high)) is not None
        if leaf.reason == BRANCH or (leaf.reason == NO_MEMBER and not here):
            self.lost += 1
            if self.lost > MOST_LOST:
                return False
        if leaf.reason == NO_MEMBER and width < EXPLORED * (self.high - self.low):
            return any(self.found.root(v) is not None for v in (leaf.low, cut, leaf.high))
        return True

    def _examined(self, low: float, high: float) -> Leaf:
        try:
            with precision(BITS):
                found: Any = self.found
                piece = found.piece(low, high)
                if not found.joined(piece):
                    return Leaf(low, high, None, BRANCH)
                count = found.zeros_in(piece)
        except NoMemberError:
            return Leaf(low, high, None, NO_MEMBER)
        except (NoValueError, ZeroDivisionError, OverflowError):
            return Leaf(low, high, None, NO_VALUE)
        except StabilityError as error:
            return Leaf(low, high, None, str(error))
        return Leaf(low, high, count, TOUCH if count is None or count > 1 else "")


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
