"""Changes of verdict along an axis: every candidate is judged, by exact numbers and by members.

Source: tests/boundary/test_boundaries.py; tests/boundary/test_algebraic_boundaries.py.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import suppress
from typing import Any

import numpy as np
from flint import arb

from ...algebra.exact.function_field import Expression, TooManyFunctions
from ...algebra.exact.hurwitz_forms import Budget
from ...algebra.exact.number_fields import NotExact
from ...algebra.exact.roots import BITS
from ...base.errors import StabilityError
from ...systems.structure.structural_zeros import structure
from ..brackets import (
    HERE,
    LATE,
    AxisScan,
    Boundaries,
    BoundaryPoint,
    Crossing,
    Unresolved,
    bracket,
)
from ..interval_search.pieces import BRANCH
from .candidates import Candidate, Watched
from .members import OPEN, AxisMembers, BranchMembers, CandidateCell
from .one_variable import of_exact, of_family
from .tower import AxisPolynomial, Tower

MOST_TERMS = 4000
"""Largest number of terms of a polynomial."""
SECONDS = 10.0
"""Time after which the exact search ends."""
MOST_STATES = 30
"""States of the largest system whose characteristic polynomial is expanded."""
DIGITS = 30_000
"""Bits of the entries of its Jacobian, times the states, up to which that takes a second; beyond
a few states."""
MOST_DIGITS = 200_000
"""The same, where a search in pieces stays open: ten seconds."""
FEW_STATES = 12
"""States up to which the entries may have any size, and unknowns are solved for."""
MEET = "two steady motions meet at this value, or one goes to infinity, so the branch may end"
END = "an unknown that must be positive is zero at this value, so the branch may end"
POLE = "the linearisation of {family} {has} no value there; {what} {said}"
NOBODY = "{family} has no member at this value of {axis}"


def members_along(
    line: AxisScan,
    ends: tuple[float | None, float | None],
    bits: int = BITS,
    digits: int = DIGITS,
    *,
    every: bool = False,
) -> AxisMembers:
    """The members along an axis, with every candidate for a change of their verdict.

    Parameters
    ----------
    line
        The line.
    ends
        Ends of the interval, both included; None for no end.
    bits
        Working precision of the first attempt.
    digits
        Most bits of the entries of a Jacobian, times the states, beyond a few states.
    every
        Whether every crossing of the imaginary axis is a candidate, and not those alone that can
        change the verdict.

    Raises
    ------
    NotExact
        If the family is not algebraic along the axis, or the polynomials are too large.
    """
    problem, family = line.problem, line.problem.family
    budget = Budget(MOST_TERMS, SECONDS)
    if problem.exact is not None:
        return of_exact(line, problem.exact, ends, bits, every=every)
    count = len(family.system.states)
    most = FEW_STATES if family.unknown and not family.closed else MOST_STATES
    if count > most:
        raise NotExact(f"{count} states, more than {most}")
    if "lean" in (line.axis, *line.fixed) and not problem.plain:
        raise NotExact("π is in it")
    try:  # a ring of few variables is faster
        polynomial = AxisPolynomial(line, ends, budget, spare=0)
    except TooManyFunctions:
        if not problem.plain:
            raise NotExact("functions of units or angles occur") from None
        polynomial = AxisPolynomial(line, ends, budget)
    if count > FEW_STATES:
        terms = [c for row in polynomial.entries for e in row for c in _coefficients(e)]
        if count * sum(int(c.height_bits()) for c in terms) > digits:
            raise NotExact(f"{count} states, and numbers of many digits")
    if polynomial.rational:
        return of_family(line, polynomial, ends, bits)
    zeros = structure(family)
    if not zeros.steady:
        raise NotExact("a rate does not vanish at typical members")
    proved = polynomial.factored.zeros
    if proved < zeros.zeros:
        raise NotExact("zeros by structure are not proved")
    return BranchMembers(line, Tower(polynomial), budget, extra=proved > zeros.zeros)


def _coefficients(entry: Expression) -> list[Any]:
    return [*entry.num.coeffs(), *entry.den.coeffs()]


def searched(line: AxisScan, low: float, high: float, digits: int = DIGITS) -> Boundaries:
    """Every change of verdict along an axis, each as a proved bracket.

    Raises
    ------
    NotExact
        As `members_along`.
    """
    return Judge(line, members_along(line, (low, high), digits=digits), low, high).result()


class Judge:
    """Cells and candidates of a line, and what follows from them."""

    what = "the verdict"
    """What is compared on both sides of a candidate."""

    def __init__(self, line: AxisScan, members: AxisMembers, low: float, high: float) -> None:
        self.line, self.members, self.low, self.high = line, members, low, high
        self.name = line.problem.family.name
        self.points: list[BoundaryPoint] = []
        self.left: list[Unresolved] = []
        self.touching: list[float] = []

    def result(self) -> Boundaries:
        """The record."""
        self.judge()
        left = tuple(tidy(self.left))
        return Boundaries(tuple(self.points), left, tuple(self.touching), self.members.how)

    def side(self, cell: CandidateCell) -> Any:
        """What is proved of the members in a piece; None for nothing."""
        return cell.look.sign or None

    def judge(self) -> None:
        """Every candidate, in increasing order."""
        candidates = self.members.candidates
        for value in self.members.missing:
            said = NOBODY.format(family=self.name, axis=self.line.axis)
            self.left.append(Unresolved(value, value, f"{said}."))
        for cell in () if self.members.exact else self.members.cells:
            inside = cell.high > arb(self.low) and cell.low < arb(self.high)
            if inside and self.side(cell) is None:
                self.leave(cell.low, cell.high, cell.look.reason or OPEN)
            for low, high, reason in cell.doubts if inside else ():
                self.leave(low, high, reason)
        changes = [
            (candidate, below, above)
            for candidate, below, above in self.members.between()
            if candidates.inside(candidate) and self._judged(candidate, below, above)
        ]
        for i, change in enumerate(changes):
            others = [c[0].value for j, c in enumerate(changes) if abs(i - j) == 1]
            self.change(*change, others)

    def _judged(self, candidate: Candidate, below: CandidateCell, above: CandidateCell) -> bool:
        """Whether the verdict changes at a candidate; anything else is recorded."""
        sides = self.side(below), self.side(above)
        if None in sides:
            if not self._closed(candidate, below, above):
                self.leave_at(candidate, (above if sides[0] else below).look.reason or OPEN)
            return False
        kept = self.members.vanishing(candidate)
        ending = {w.kind for w in (candidate.watched if kept is None else kept)} & {
            "fold",
            "pole",
            "end",
        }
        if kept is None or ending:
            self.leave_at(candidate, self._event(ending, same=sides[0] == sides[1]))
            return False
        if not self.members.joined(candidate, below, above):
            self.leave(arb(below.place), arb(above.place), BRANCH)
            return False
        kept = [w for w in kept if w.kind != "kink"]
        if sides[0] == sides[1] and kept:
            self.single(candidate, kept, below, above)
        return bool(sides[0] != sides[1])

    def _event(self, kinds: set[str], *, same: bool) -> str:
        """Reason why a candidate stays open."""
        for kind, reason in (("fold", MEET), ("end", END)):
            if kind in kinds:
                return reason
        said = "is the same on both sides" if same else "differs on the two sides"
        has = "has" if self.members.exact else "may have"
        return POLE.format(family=self.name, has=has, what=self.what, said=said)

    def _closed(self, candidate: Candidate, below: CandidateCell, above: CandidateCell) -> bool:
        """Whether the member at an end has the verdict of those inside; beyond there is none."""
        for end, inner in ((self.low, above), (self.high, below)):
            if candidate.value == arb(end) and inner.look.sign:
                with suppress(StabilityError):
                    return self.line.sign(end) == inner.look.sign
        return False

    def single(
        self, candidate: Candidate, kept: list[Watched], below: CandidateCell, above: CandidateCell
    ) -> None:
        """A candidate between members that are alike."""
        sign = below.look.sign
        if sign > 0:
            if not self.members.dissipative:
                return  # neutral on both sides too
            # the limit of stable motions with an eigenvalue on the axis is neutral
            unstable = False if self.members.meets(candidate, kept, below, above) else None
        else:
            unstable = self.members.unstable(candidate)
        if unstable is None:
            sides = "stable" if sign > 0 else "unstable"
            self.leave_at(candidate, HERE.format(family=self.name, sides=sides))
        elif not unstable:
            self.touching.append(float(candidate.value.mid()))

    def change(
        self, candidate: Candidate, below: CandidateCell, above: CandidateCell, others: list[Any]
    ) -> None:
        """A change of verdict as a proved bracket."""
        root = self.root(candidate)
        room = min((float(abs(v - candidate.value).mid()) for v in others), default=math.inf)
        proof = bracket(lambda v: self.members.sign(v, above if v > root else below), root, room)
        if proof is None:
            self.leave(candidate.value, candidate.value, LATE)
            return
        kept = self.members.vanishing(candidate) or list(candidate.watched)
        static = any(w.kind == "static" for w in kept)
        crossing = Crossing.STATIC if static else Crossing.FLUTTER
        rate = 0.0 if static else self.members.rate(candidate, root)
        self.points.append(BoundaryPoint(root, proof[0], crossing, rate, proof[1]))

    def root(self, candidate: Candidate) -> float:
        """The double next to a candidate, in the interval."""
        return min(max(float(candidate.value.mid()), self.low), self.high)

    def leave_at(self, candidate: Candidate, reason: str) -> None:
        """Leave a candidate open: one double where the search is exact."""
        if not self.members.exact:
            self.leave(candidate.value, candidate.value, reason)
            return
        value = float(candidate.value.mid())
        self.left.append(Unresolved(value, value, f"{reason}."))

    def leave(self, low: Any, high: Any, reason: str) -> None:
        """Leave a part of the interval open, rounded outwards."""
        if low > arb(self.high) or high < arb(self.low):
            return
        first = max(float(np.nextafter(float(low.mid()), -np.inf)), self.low)
        last = min(float(np.nextafter(float(high.mid()), np.inf)), self.high)
        if first <= last:
            self.left.append(Unresolved(first, last, f"{reason}."))


def tidy(left: list[Unresolved]) -> Iterator[Unresolved]:
    """Parts in order; overlapping ones with the same reason as one."""
    open_: list[Unresolved] = []
    for part in sorted(left):
        if open_ and part.reason == open_[-1].reason and part.low <= open_[-1].high:
            before = open_.pop()
            open_.append(Unresolved(before.low, max(before.high, part.high), part.reason))
        elif not any(o.low <= part.low and part.high <= o.high for o in open_):
            open_.append(part)
    yield from open_
