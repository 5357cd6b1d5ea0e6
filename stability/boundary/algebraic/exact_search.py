"""Changes of verdict along an axis in which a family is algebraic: every candidate is judged.

Between neighbouring candidates no condition vanishes on any branch, no members meet, and the
linearisation has a value.  So the member depends continuously on the axis there, and its verdict is
constant.

A member is the one that the family's root-finder gives, proved in balls.  Where every unknown obeys
a polynomial without multiple roots, its place among the real roots of that polynomial names the
branch: roots that depend continuously on the axis keep their order.

Source: tests/boundary/test_algebraic_boundaries.py.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from flint import arb

from ...algebra.exact.hurwitz_forms import Budget, coefficient_row, factors
from ...algebra.exact.number_fields import NotExact
from ...algebra.exact.roots import UnclearError, isolated
from ...algebra.exact.routh import (
    hurwitz_sign,
    is_even,
    least_sign,
    monic,
    verdict_polynomial,
)
from ...algebra.exact.triangular import evaluate, occurring
from ...algebra.number_types import precision
from ...base.errors import NoMemberError, StabilityError
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
    crossing_rate,
)
from ..interval_search.pieces import BRANCH, NO_MEMBER, NO_VALUE
from ..search import grows
from .candidates import Candidate, Candidates, Watched, least_size, watched
from .tower import Along, Tower

LADDER = (128, 512, 2048)
"""Precisions of the balls at members."""
MOST_BITS = 8192
"""Largest precision at which a value is proved to be zero."""
OPEN = "no verdict is proved at the values tried here"
OTHER = "the members here lie on another branch than those from which the conditions were derived"
CLOSE = tuple(2.0**-k for k in (4, 8, 14, 20, 26, 32))
"""Shares of the room around a candidate at which members on both sides are compared."""


@dataclass(frozen=True)
class Look:
    """What is proved at one value of the axis."""

    sign: int
    """1 stable or neutral, -1 unstable, 0 where nothing is proved."""
    label: tuple[int, ...] | None
    """The branch."""
    reason: str
    """Reason for a 0, without a full stop."""


class Branch:
    """The family's members along a line."""

    def __init__(self, line: AxisScan, tower: Tower, budget: Budget) -> None:
        self.line, self.tower, self.budget = line, tower, budget
        self.family = line.problem.family

    # --- at a number ---

    def look(self, value: float) -> Look:
        """The verdict and the branch at a number."""
        reason, label = OPEN, None
        for bits in LADDER:
            with precision(bits):
                try:
                    full = self._full(arb(value))
                except (StabilityError, ZeroDivisionError):
                    return Look(0, None, NO_MEMBER)
                known = self._compact(full)
                if not all(v.is_finite() for v in known.values()):
                    return Look(0, None, NO_VALUE)
                if self.tower.along.elsewhere(full) is not None:
                    return Look(0, None, OTHER)
                label = self._label(known)
                sign = self._sign(known) if label is not None and self._regular(known) else 0
            if sign:
                return Look(sign, label, "")
        return Look(0, label, reason)

    def known(self, value: Any) -> Mapping[int, Any]:
        """Values of the polynomials' variables at a ball of the axis.

        Raises
        ------
        NoMemberError
            If there is no member, or an unknown is not proved to be positive.
        """
        return self._compact(self._full(value))

    def _full(self, value: Any) -> dict[int, Any]:
        """Values of every indeterminate."""
        known = self.tower.along.at(value)
        names = list(self.tower.along.base)
        for name in self.family.positive:
            if not known[names.index(name)] > 0:
                raise NoMemberError(f"{self.family.name}: {name} is not proved to be positive.")
        return known

    def _compact(self, known: Mapping[int, Any]) -> dict[int, Any]:
        return {new: known[old] for new, old in enumerate(self.tower.whole.indices)}

    def sign(self, value: float, label: tuple[int, ...] | None) -> int:
        """The proved verdict at a number, by the graph or the polynomials; 0 on another branch."""
        found = self.look(value)
        if found.label != label:
            return 0
        try:
            return found.sign and (self.line.sign(value) or found.sign)
        except StabilityError:
            return 0

    def _regular(self, known: Mapping[int, Any]) -> bool:
        return not any(arb(evaluate(p, known)).contains(0) for p in self.tower.whole.nonzero)

    def _label(self, known: Mapping[int, Any]) -> tuple[int, ...] | None:
        out = []
        for level in self.tower.levels:
            if level.own is None:
                continue
            row = coefficient_row(level.own, level.place)
            balls = [arb(evaluate(c, known)) for c in row]
            roots = None if balls[-1].contains(0) else isolated(balls, even=False)
            if roots is None:
                return None
            real = sorted((r.real for r in roots if r.imag == 0), key=lambda r: r.mid())
            same = [i for i, r in enumerate(real) if r.overlaps(known[level.place])]
            if len(same) != 1:
                return None
            out.append(same[0])
        return tuple(out)

    def factors(self, known: Mapping[int, Any]) -> list[list[Any]]:
        """Coefficients of each factor as balls, lowest first.

        Parameters
        ----------
        known
            Values of the variables.
        """
        return [[arb(evaluate(c, known)) for c in a] for a, _ in self.tower.whole.factors]

    def even(self, index: int) -> bool:
        """Whether a factor has even powers alone."""
        return is_even(self.tower.whole.factors[index][0])

    def _sign(self, known: Mapping[int, Any]) -> int:
        every = self.factors(known)
        if any(a[-1].contains(0) for a in every):
            return 0
        return least_sign(
            [
                hurwitz_sign(verdict_polynomial(monic(a), 0, self.even(index)))
                for index, a in enumerate(every)
            ]
        )

    # --- at a candidate ---

    def vanishing(self, all_: Candidates, one: Candidate) -> list[Watched] | None:
        """Polynomials that are not proved to differ from zero; None without a member.

        Parameters
        ----------
        all_, one
            The candidates, and one of them.
        """
        left = list(one.watched)
        for bits in LADDER[1:]:
            try:
                value = all_.refined(one, bits)
                with precision(bits):
                    known = self.known(value)
                    left = [w for w in left if arb(evaluate(w.poly, known)).contains(0)]
            except (StabilityError, ZeroDivisionError, UnclearError):
                return None
            if not left:
                break
        return left

    def joined(self, one: Candidate, ends: tuple[float, float], labels: Sequence[Any]) -> bool:
        """Whether the members on both sides of a candidate lie on one branch through it.

        Parameters
        ----------
        one
            The candidate.
        ends
            Numbers below and above, between which there is no other candidate.
        labels
            The branch below and above.
        """
        middle = float(one.value.mid())
        for share in CLOSE:
            low = middle - share * (middle - ends[0])
            high = middle + share * (ends[1] - middle)
            if not (low < one.value < high):
                continue
            if [self.look(low).label, self.look(high).label] != list(labels):
                return False
            if self.line.joined(low, middle, high):
                return True
        return False

    def zero(self, all_: Candidates, one: Candidate, what: Watched, ends: Sequence[float]) -> bool:
        """Whether a polynomial is proved to vanish at a candidate.

        Parameters
        ----------
        all_, one
            The candidates, and one of them.
        what
            One of its polynomials.
        ends
            Numbers on the same branch, between which there is no other candidate.
        """
        if occurring(what.image) <= {0, 1}:
            return True  # the polynomial is its own norm
        with precision(LADDER[0]):
            signs = [arb(evaluate(what.poly, self.known(arb(end)))) for end in ends]
        if signs[0] * signs[1] < 0:
            return True
        return self._small(all_, one, what.image, what.poly)

    def _small(self, all_: Candidates, one: Candidate, image: Any, poly: Any) -> bool:
        """Whether a value is smaller than each of its conjugates that is not zero."""
        least = least_size(self.tower, image, one.norm, self.budget)
        if least is None:
            return False
        bits = 2 * (int(least.q).bit_length() - int(least.p).bit_length()) + 128
        if bits > MOST_BITS:
            return False
        try:
            value = all_.refined(one, bits)
            with precision(bits):
                return bool(abs(arb(evaluate(poly, self.known(value)))) < arb(least))
        except (StabilityError, UnclearError):
            return False

    # --- the verdict at a candidate between unstable members ---

    def unstable(self, all_: Candidates, one: Candidate) -> bool | None:
        """Whether the member at a candidate is unstable; None where this is not proved.

        Parameters
        ----------
        all_, one
            The candidates, and one of them.
        """
        try:
            value = all_.refined(one, LADDER[1])
            with precision(LADDER[1]):
                known = self.known(value)
                found = [self._grows(all_, one, i, a) for i, a in enumerate(self.factors(known))]
        except (StabilityError, UnclearError, ZeroDivisionError):
            return None
        return True if True in found else None if None in found else False

    def _grows(self, all_: Candidates, one: Candidate, index: int, a: list[Any]) -> bool | None:
        """Whether a factor has a root with a positive real part at a candidate."""
        if grows(a):
            return True
        polys = self.tower.whole.factors[index][0]
        zero = [
            c == 0 or (b.contains(0) and self._nothing(all_, one, c))
            for c, b in zip(polys, a, strict=True)
        ]
        low = zero.index(False)
        rest = [arb(0) if z else b for z, b in zip(zero, a, strict=True)][low:]
        if rest[-1].contains(0):
            return None
        if len(rest) == 1:
            return False
        sign = hurwitz_sign(verdict_polynomial(monic(rest), 0, is_even(rest)))
        return None if sign == 0 else sign < 0

    def _nothing(self, all_: Candidates, one: Candidate, poly: Any) -> bool:
        """Whether a coefficient is proved to vanish at a candidate."""
        for factor, _ in factors(poly)[1]:
            image = self.tower.image(factor)
            if occurring(image) <= {0, 1} and not divmod(image, one.norm)[1]:
                return True
            if self._small(all_, one, image, factor):
                return True
        return False


MOST_TERMS = 4000
"""Largest number of terms of a polynomial."""
SECONDS = 10.0
"""Time after which the exact search ends."""
MOST_STATES = 12
"""States of the largest system that is searched in this way."""
SHARES = (0.5, 0.2578125, 0.7265625, 0.0859375, 0.9140625)
"""Shares of a piece at which its member is examined, in the order of trial."""
FEWEST, MORE = 4, 24
"""Numbers in each piece at which a root-finder is tried, and more in all of the interval."""
HOW = (
    "every value at which a condition can vanish, or members can meet, was isolated exactly, with "
    "functions and unknowns as algebraic numbers"
)
NEAR = "another candidate is too near for a number between the two"
JUMP = (
    "the root-finder passes to another steady motion here, so the members are not one family; "
    "take the family from System.steady, which follows one branch"
)
MEET = "two steady motions meet at this value, or one goes to infinity, so the branch may end"
END = "an unknown that must be positive is zero at this value, so the branch may end"
POLE = "the linearisation of {family} may have no value there; the verdict {said}"


def algebraic(line: AxisScan, low: float, high: float) -> Boundaries:
    """Every change of verdict along an axis in which a family is algebraic.

    Parameters
    ----------
    line
        The line.
    low, high
        Ends of the interval, both included.

    Raises
    ------
    NotExact
        If the family is not algebraic along the axis, or the polynomials are too large.
    """
    problem, family = line.problem, line.problem.family
    if problem.exact is not None or not problem.plain:
        raise NotExact("the family's own polynomial is not algebraic along the axis")
    if len(family.system.states) > MOST_STATES:
        raise NotExact(f"{len(family.system.states)} states, more than {MOST_STATES}")
    zeros = structure(family)
    if not zeros.steady:
        raise NotExact("a rate does not vanish at typical members")
    budget = Budget(MOST_TERMS, SECONDS)
    along = Along(line, low, high, budget)
    found = along.factored
    if found.zeros < zeros.zeros:
        raise NotExact("zeros by structure are not proved")
    tower = Tower(along, found)
    try:
        candidates = Candidates(tower, watched(tower, budget), low, high, budget)
    except UnclearError:
        raise NotExact("candidates could not be separated") from None
    extra = found.zeros > zeros.zeros
    return _Judge(line, candidates, Branch(line, tower, budget), extra=extra).result()


@dataclass(frozen=True)
class Cell:
    """A piece between neighbouring candidates."""

    low: Any
    """Ball of its low end."""
    high: Any
    """Ball of its high end."""
    place: float
    """Number at which its member was examined."""
    look: Look
    """What is proved there."""
    doubts: tuple[tuple[Any, Any, str], ...] = ()
    """Parts (low, high, reason) in which the root-finder gives other members, or none."""


class _Judge:
    """Cells and candidates of a line, and what follows from them."""

    def __init__(
        self, line: AxisScan, candidates: Candidates, branch: Branch, *, extra: bool
    ) -> None:
        self.line, self.candidates, self.branch = line, candidates, branch
        self.low, self.high = candidates.ends
        self.points: list[BoundaryPoint] = []
        self.left: list[Unresolved] = []
        self.touching: list[float] = []
        count = len(branch.tower.whole.factors)
        self.dissipative = not extra and not any(branch.even(i) for i in range(count))

    def result(self) -> Boundaries:
        """The record."""
        for cell in self.cells:
            inside = cell.high > arb(self.low) and cell.low < arb(self.high)
            if inside and not cell.look.sign:
                self._leave(cell.low, cell.high, cell.look.reason)
            for low, high, reason in cell.doubts if inside else ():
                self._leave(low, high, reason)
        changes = []
        for i, one in enumerate(self.candidates.found):
            if not (one.value < arb(self.low) or one.value > arb(self.high)):
                below, above = self.cells[i], self.cells[i + 1]
                if self._judged(one, below, above):
                    changes.append((one, below, above))
        for i, change in enumerate(changes):
            others = [c[0].value for j, c in enumerate(changes) if abs(i - j) == 1]
            self._change(*change, others)
        family = self.line.problem.family
        how = HOW
        if family.unknown and not family.closed:
            how += ", on one branch of steady motions"
        return Boundaries(tuple(self.points), tuple(_tidy(self.left)), tuple(self.touching), how)

    # --- cells ---

    @cached_property
    def cells(self) -> list[Cell]:
        """The piece below each candidate, and the last one above them all."""
        low, high = arb(self.low), arb(self.high)
        room = (high - low) / 64
        values = [c.value for c in self.candidates.found]
        if not values:
            return [self._cell(low, high)]
        first, last = min(low, values[0] - room), max(high, values[-1] + room)
        # next to a candidate at an end the members beyond the interval count too
        first = low if low < values[0] else first
        last = high if high > values[-1] else last
        fence = [first, *values, last]
        return [self._cell(a, b) for a, b in zip(fence[:-1], fence[1:], strict=True)]

    def _cell(self, low: Any, high: Any) -> Cell:
        looks = list(self._looks(low, high))
        known = [(place, look) for place, look in looks if look.sign]
        if not known:
            place, look = looks[0] if looks else (math.nan, Look(0, None, NEAR))
            return Cell(low, high, place, look)
        [(label, _)] = Counter(look.label for _, look in known).most_common(1)
        good = [one for one in known if one[1].label == label]
        if len({look.sign for _, look in good}) > 1:
            raise NotExact("verdicts on one branch differ between candidates")
        place, look = good[len(good) // 2]
        fence = [low, *(arb(v) for v, _ in good), high]
        doubts = []
        for value, other in looks:
            if other.label != label:
                above = next(i for i, f in enumerate(fence) if f > value)
                reason = JUMP if other.sign else other.reason
                doubts.append((fence[above - 1], fence[above], reason))
        return Cell(low, high, place, look, tuple(doubts))

    def _looks(self, low: Any, high: Any) -> Iterator[tuple[float, Look]]:
        """Numbers in a piece, in increasing order, with what is proved there.

        One number is enough where nothing is solved for.  A root-finder may pass to another branch
        anywhere, most often near an end of the piece, so more numbers show whether it does.
        """
        ends = low.upper(), high.lower()
        family = self.line.problem.family
        shares: tuple[float, ...] = SHARES
        if family.unknown and not family.closed:
            part = float(((ends[1] - ends[0]) / (arb(self.high) - arb(self.low))).mid())
            count = FEWEST + math.ceil(MORE * min(part, 1.0))
            shares = tuple(math.sin(math.pi * (i + 0.5) / (2 * count)) ** 2 for i in range(count))
        for share in shares:
            place = float((ends[0] + (ends[1] - ends[0]) * share).mid())
            if not (arb(place) > low and arb(place) < high):
                continue
            look = self.branch.look(place)
            yield place, look
            if look.sign and shares is SHARES:
                return

    # --- candidates ---

    def _judged(self, one: Candidate, below: Cell, above: Cell) -> bool:
        """Whether the verdict changes at a candidate; anything else is recorded."""
        signs = below.look.sign, above.look.sign
        if 0 in signs:
            if not self._closed(one, below, above):
                self._leave(one.value, one.value, (above if signs[0] else below).look.reason)
            return False
        kept = self.branch.vanishing(self.candidates, one)
        events = [w for w in one.watched if w.kind in ("fold", "pole", "end")]
        if kept is None and not events and any(w.kind == "crossed" for w in one.watched):
            kept = list(one.watched)  # the root-finder fails there, and the branch goes on
        if kept is None or any(w in kept for w in events):
            kinds = {w.kind for w in events if kept is None or w in kept}
            self._leave(one.value, one.value, self._event(kinds, same=signs[0] == signs[1]))
            return False
        labels = below.look.label, above.look.label
        ends = below.place, above.place
        same = self.branch.joined(one, ends, labels) if events else labels[0] == labels[1]
        if not same:
            self._leave(arb(below.place), arb(above.place), BRANCH)
            return False
        kept = [w for w in kept if w.kind != "kink"]
        if signs[0] == signs[1] and kept:
            self._single(one, kept, ends, signs[0])
        return signs[0] != signs[1]

    def _event(self, kinds: set[str], *, same: bool) -> str:
        """Reason why a candidate stays open."""
        for kind, reason in (("fold", MEET), ("end", END)):
            if kind in kinds:
                return reason
        said = "is the same on both sides" if same else "differs on the two sides"
        return POLE.format(family=self.line.problem.family.name, said=said)

    def _closed(self, one: Candidate, below: Cell, above: Cell) -> bool:
        """Whether the member at an end has the verdict of those inside; beyond there is none."""
        for end, inner in ((self.low, above), (self.high, below)):
            if one.value == arb(end) and inner.look.sign:
                with suppress(StabilityError):
                    return self.line.sign(end) == inner.look.sign
        return False

    def _single(
        self, one: Candidate, kept: list[Watched], ends: tuple[float, float], sign: int
    ) -> None:
        """A candidate between members with the same verdict."""
        family = self.line.problem.family.name
        if sign > 0:
            if not self.dissipative:
                return  # neutral on both sides too
            known = [self.branch.zero(self.candidates, one, w, ends) for w in kept]
            if any(known):
                self.touching.append(float(one.value.mid()))
            else:
                self._leave(one.value, one.value, HERE.format(family=family, sides="stable"))
            return
        found = self.branch.unstable(self.candidates, one)
        if found is None:
            self._leave(one.value, one.value, HERE.format(family=family, sides="unstable"))
        elif not found:
            self.touching.append(float(one.value.mid()))

    def _change(self, one: Candidate, below: Cell, above: Cell, others: list[Any]) -> None:
        """A change of verdict as a proved bracket."""
        root = self._inside(one)
        labels = {False: below.look.label, True: above.look.label}
        room = min((float(abs(v - one.value).mid()) for v in others), default=math.inf)
        proof = bracket(lambda v: self.branch.sign(v, labels[v > root]), root, room)
        if proof is None:
            self._leave(one.value, one.value, LATE)
            return
        kept = self.branch.vanishing(self.candidates, one) or list(one.watched)
        static = any(w.kind == "static" for w in kept)
        crossing = Crossing.STATIC if static else Crossing.FLUTTER
        rate = crossing_rate(self.line, root, crossing)
        self.points.append(BoundaryPoint(root, proof[0], crossing, rate, proof[1]))

    def _inside(self, one: Candidate) -> float:
        """The candidate as a double in the interval."""
        return min(max(float(one.value.mid()), self.low), self.high)

    def _leave(self, low: Any, high: Any, reason: str) -> None:
        """Leave a part of the interval open, rounded outwards."""
        if low > arb(self.high) or high < arb(self.low):
            return
        first = max(float(np.nextafter(float(low.mid()), -np.inf)), self.low)
        last = min(float(np.nextafter(float(high.mid()), np.inf)), self.high)
        if first <= last:
            self.left.append(Unresolved(first, last, f"{reason}."))


def _tidy(left: list[Unresolved]) -> Iterator[Unresolved]:
    """Parts in order; overlapping ones with the same reason as one."""
    open_: list[Unresolved] = []
    for part in sorted(left):
        if open_ and part.reason == open_[-1].reason and part.low <= open_[-1].high:
            before = open_.pop()
            open_.append(Unresolved(before.low, max(before.high, part.high), part.reason))
        elif not any(o.low <= part.low and part.high <= o.high for o in open_):
            open_.append(part)
    yield from open_
