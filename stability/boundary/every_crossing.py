"""Every crossing of the imaginary axis, with the number of unstable eigenvalues on both sides.

By exact numbers unstable eigenvalues are counted in each piece between candidates, for each factor
of the characteristic polynomial.  A factor whose number changes crosses at the candidate between.
Otherwise they are counted at both ends of each piece that is proved to hold a single meeting with
the imaginary axis.

Source: tests/boundary/test_every_crossing.py.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from contextlib import suppress
from itertools import compress
from typing import Any

from flint import arb

from ..algebra.number_types import precision
from ..base.errors import StabilityError
from ..base.types import Floats
from ..systems.structure.structural_zeros import structure
from .algebraic.candidates import Candidate, Watched
from .algebraic.exact_search import DIGITS, Judge, members_along, tidy
from .algebraic.members import FINE_BITS, OPEN, CandidateCell
from .brackets import (
    LADDER,
    LATE,
    AxisCrossing,
    AxisScan,
    Crossing,
    Crossings,
    Unresolved,
    bracket,
    crossing_rate,
    zero_between,
)
from .interval_search.pieces import BRANCH, TOUCH, how_in_pieces, pieces
from .interval_search.quick_pieces import Leaf
from .pairs import on_axis, unstable_count

HOW = (
    "every value at which an eigenvalue can meet the imaginary axis was isolated exactly, and "
    "unstable eigenvalues were counted between these values"
)
SHARE = 0.382
"""Share of an interval at which eigenvalues are counted where none crosses."""
NOTHING = 1e-300
"""Distance from 0 up to which a crossing is one at 0."""
REACHED = "whether eigenvalues of {family} reach the imaginary axis there is not decided"


def every_crossing(line: AxisScan, low: float, high: float, digits: int = DIGITS) -> Crossings:
    """Every value of an axis at which eigenvalues cross the imaginary axis.

    Raises
    ------
    NotExact
        As `members_along`.
    """
    members = members_along(line, (low, high), digits=digits, every=True)
    return _EveryCrossing(line, members, low, high).crossings()


class _EveryCrossing(Judge):
    """Candidates judged by the unstable eigenvalues of each factor on both sides."""

    what = "the number of unstable eigenvalues"

    def crossings(self) -> Crossings:
        """The record."""
        self.every: list[AxisCrossing] = []
        self.counts: dict[int, list[int] | None] = {}
        self.judge()
        number = None
        if not self.left and not self.every:
            # a candidate a little beyond the interval bounds a piece outside it
            inside = (c for c in self.members.cells if c.high > arb(self.low))
            side = self.side(next(inside))
            if side is None:
                self.left.append(Unresolved(self.low, self.high, f"{OPEN}."))
            else:
                number = sum(side)
        left, touching = tuple(tidy(self.left)), tuple(self.touching)
        return Crossings(tuple(self.every), left, touching, HOW, throughout=number)

    def side(self, cell: CandidateCell) -> list[int] | None:
        """Number of unstable eigenvalues of each factor."""
        if id(cell) not in self.counts:  # cells live as long as the members
            self.counts[id(cell)] = self.members.unstable_in(cell)
        return self.counts[id(cell)]

    def single(
        self, candidate: Candidate, kept: list[Watched], below: CandidateCell, above: CandidateCell
    ) -> None:
        """A candidate where eigenvalues may reach the axis, and as many are unstable beyond it."""
        rows = zip(self._on_axis(candidate), self.members.even, strict=False)
        if any(w == 0 or not even for row, even in rows for w in row):
            if self.members.meets(candidate, kept, below, above):
                self.touching.append(float(candidate.value.mid()))
            else:
                self.leave_at(candidate, REACHED.format(family=self.name))

    def change(
        self,
        candidate: Candidate,
        below: CandidateCell,
        above: CandidateCell,
        others: list[Any],  # noqa: ARG002
    ) -> None:
        """A crossing as a proved bracket: its ends lie in the pieces on both sides."""

        def side(value: float) -> int:
            if below.low < arb(value) < candidate.value and self.members.holds(value, below):
                return 1
            inside = candidate.value < arb(value) < above.high
            return -1 if inside and self.members.holds(value, above) else 0

        root = self.root(candidate)
        proof = bracket(side, root)
        numbers = self.side(below), self.side(above)
        if proof is None or numbers[0] is None or numbers[1] is None:
            self.leave(candidate.value, candidate.value, LATE)
            return
        changed = [a != b for a, b in zip(numbers[0], numbers[1], strict=True)]
        rows = self._on_axis(candidate)  # what touches the axis in another factor does not cross
        rates = sorted(w for row in compress(rows, changed) for w in row)
        if not rates and any(w.kind == "static" for w in self.members.vanishing(candidate) or ()):
            rates = [0.0]  # where branches cross no member was found
        kind = Crossing.STATIC if rates and not any(rates) else Crossing.FLUTTER
        if any(rates) and not all(rates):
            kind = Crossing.STATIC_AND_FLUTTER
        unit = self._rate(root)
        self.every.append(
            AxisCrossing(
                root,
                proof[0],
                kind,
                tuple(unit * w for w in rates),
                sum(numbers[0]),
                sum(numbers[1]),
            )
        )

    def _on_axis(self, candidate: Candidate) -> list[list[float]]:
        """|Im λ| of what is on the axis at a candidate, by factor; empty without a member."""
        with suppress(StabilityError, ArithmeticError), precision(FINE_BITS):
            rows = zip(self.members.factors_at(candidate), self.members.even, strict=True)
            return [on_axis(row, even=even) * power for (row, power), even in rows]
        return []

    def _rate(self, value: float) -> float:
        """Unit of the polynomial's λ in the user's unit of rate."""
        exact = self.line.problem.exact
        if exact is None:
            return self.line.rate(value)
        scale, square = exact.scale(self.line.fixed | {self.line.axis: value})
        return float(scale) if scale is not None else math.sqrt(square)


# --- in pieces ---


def crossings_in_pieces(
    line: AxisScan,
    grid: Floats,
    *,
    log: bool = False,
    singular: Mapping[float, str] | None = None,
) -> Crossings:
    """Every crossing along an axis that need not be algebraic, with what stays open.

    Parameters
    ----------
    line
        The line.
    grid
        Numbers whose first and last are the ends of the interval.
    log
        Whether pieces are cut at equal ratios.
    singular
        As for `pieces`.
    """
    low, high = float(grid[0]), float(grid[-1])
    searched = pieces(line, low, high, log=log, singular=singular, every=True)
    points: list[AxisCrossing] = []
    left: list[Unresolved] = []
    for leaf in searched.leaves:
        if leaf.meetings == 0:
            continue
        outcome = _crossing(line, leaf) if leaf.meetings == 1 else leaf.reason
        if isinstance(outcome, str):
            left.append(Unresolved(max(leaf.low, low), min(leaf.high, high), f"{outcome}."))
        elif outcome and low <= outcome.value + outcome.error:
            points += [outcome] if outcome.value - outcome.error <= high else []
    number = None if left or points else unstable_at(line, low + SHARE * (high - low))
    how = how_in_pieces(line, searched)
    return Crossings(tuple(points), tuple(left), how=how, throughout=number)


def _crossing(line: AxisScan, leaf: Leaf) -> AxisCrossing | str | None:
    """The crossing at the single meeting of a piece, None, or why it is not known."""
    below, above = unstable_at(line, leaf.low), unstable_at(line, leaf.high)
    if below is None or above is None:
        return TOUCH
    if below == above:
        return None  # two opposite real eigenvalues

    def side(value: float) -> int:
        inside = leaf.low <= value <= leaf.high
        count = unstable_at(line, value) if inside else None
        return (count == below) - (count == above)

    if leaf.low < 0 < leaf.high and side(-NOTHING) * side(NOTHING) < 0:
        root = 0.0
    elif leaf.near:
        root = leaf.near[0]
    else:
        root = zero_between(lambda v: float(side(v)), leaf.low, leaf.high)
    proof = bracket(side, root)
    if proof is None:
        return LATE
    if not line.joined(root - proof[0], root, root + proof[0]):
        return BRANCH
    kind = Crossing.STATIC if abs(above - below) == 1 else Crossing.FLUTTER
    return AxisCrossing(root, proof[0], kind, (crossing_rate(line, root, kind),), below, above)


def unstable_at(line: AxisScan, value: float) -> int | None:
    """Number of unstable eigenvalues at a number; None where this is not proved."""
    zeros = structure(line.problem.family).zeros
    with suppress(StabilityError, ArithmeticError):
        for bits in LADDER:
            with precision(bits):
                coefficients = line.coefficients(value, bits)[zeros:]
                count = unstable_count(coefficients, even=line.even)
            if count is not None:
                return count
    return None
