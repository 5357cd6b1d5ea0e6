"""Members of a family along an axis: what is proved of them between candidates, and at one.

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
from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise, product
from typing import Any

from flint import arb

from ...algebra.exact.function_field import evaluate, occurring
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
from ...algebra.number_types import precision
from ...base.errors import NoMemberError, StabilityError
from ..brackets import AxisScan, Crossing, crossing_rate
from ..interval_search.pieces import NO_MEMBER, NO_VALUE
from ..pairs import grows, unstable_count
from .candidates import Candidate, Candidates, Watched, least_size, norms, watched
from .tower import Tower

LADDER = (128, 512, 2048)
"""Precisions of the balls at members."""
FINE_BITS = 512
"""Precision of the factors at a candidate."""
MOST_BITS = 8192
"""Largest precision at which a value is proved to be zero."""
SHARES = (0.5, 0.2578125, 0.7265625, 0.0859375, 0.9140625)
"""Shares of a piece at which its member is examined, in the order of trial."""
FEWEST, MORE = 4, 24
"""Numbers in each piece at which a root-finder is tried, and more in all of the interval."""
CLOSE = tuple(2.0**-k for k in (4, 8, 14, 20, 26, 32))
"""Shares of the room around a candidate at which members on both sides are compared."""
OPEN = "no verdict is proved at the values tried here"
OTHER = "the members here lie on another branch than those from which the conditions were derived"
NEAR = "another candidate is too near for a number between the two"
JUMP = (
    "the root-finder passes to another steady motion here, so the members are not one family; "
    "take the family from System.steady, which follows one branch"
)


@dataclass(frozen=True)
class AxisVerdict:
    """What is proved at one value of the axis."""

    sign: int
    """1 stable or neutral, -1 unstable, 0 where nothing is proved."""
    label: tuple[int, ...] | None
    """The branch."""
    reason: str
    """Reason for a 0, without a full stop."""


@dataclass(frozen=True)
class CandidateCell:
    """A piece between neighbouring candidates."""

    low: Any
    """Ball of its low end."""
    high: Any
    """Ball of its high end."""
    place: float
    """Number at which its member was examined, or next to it."""
    look: AxisVerdict
    """What is proved there."""
    doubts: tuple[tuple[Any, Any, str], ...] = ()
    """Parts (low, high, reason) in which the root-finder gives other members, or none."""
    sample: Any = None
    """Rational value of the base variable, where the verdict is exact there."""


class AxisMembers(ABC):
    """The members along an axis, with every candidate for a change of their verdict."""

    line: AxisScan
    """The line."""
    candidates: Candidates
    """The candidates."""
    dissipative: bool
    """Whether the good verdict is stable, so that a member with an eigenvalue on the axis differs.
    """
    exact: bool
    """Whether verdicts are exact on each piece, and what stays open is single values."""
    how: str
    """How the axis is searched."""
    even: Sequence[bool]
    """Whether each factor is even, so that pairs stay on the imaginary axis."""
    missing: Sequence[float] = ()
    """Values at which there is no member."""

    @cached_property
    def cells(self) -> list[CandidateCell]:
        """The piece below each candidate, and the last one above them all."""
        return [self.cell(low, high) for low, high in pairwise(self.candidates.fence)]

    def between(self) -> Iterator[tuple[Candidate, CandidateCell, CandidateCell]]:
        """Each candidate with the pieces below and above."""
        if self.candidates.ordered:
            yield from zip(self.candidates.ordered, self.cells, self.cells[1:], strict=False)

    @abstractmethod
    def cell(self, low: Any, high: Any) -> CandidateCell:
        """What is proved between two neighbouring candidates, or a candidate and an end."""

    @abstractmethod
    def unstable_in(self, cell: CandidateCell) -> list[int] | None:
        """Number of unstable eigenvalues of each factor in a piece; None where not proved."""

    @abstractmethod
    def holds(self, value: float, cell: CandidateCell) -> bool:
        """Whether the member at a number in a piece is proved to be that of the piece."""

    @abstractmethod
    def factors_at(self, candidate: Candidate) -> list[tuple[list[Any], int]]:
        """Factors in balls at a candidate, each with its power."""

    @abstractmethod
    def vanishing(self, candidate: Candidate) -> list[Watched] | None:
        """Polynomials that are not proved to differ from zero; None without a member."""

    @abstractmethod
    def joined(self, candidate: Candidate, below: CandidateCell, above: CandidateCell) -> bool:
        """Whether the members on both sides of a candidate lie on one branch through it."""

    @abstractmethod
    def meets(
        self, candidate: Candidate, kept: list[Watched], below: CandidateCell, above: CandidateCell
    ) -> bool:
        """Whether one of some polynomials is proved to vanish at a candidate."""

    @abstractmethod
    def unstable(self, candidate: Candidate) -> bool | None:
        """Whether the member at a candidate is unstable; None where this is not proved."""

    @abstractmethod
    def sign(self, value: float, cell: CandidateCell) -> int:
        """The proved verdict at a number in a piece; 0 where none is proved."""

    def rate(self, candidate: Candidate, root: float) -> float:  # noqa: ARG002
        """|Im λ| of the pair that meets the imaginary axis at a candidate."""
        return crossing_rate(self.line, root, Crossing.FLUTTER)


def growing(polys: Sequence[Any], balls: list[Any], zero: Callable[[Any], bool]) -> bool | None:
    """Whether a factor has a root with a positive real part; None where this is not proved.

    Parameters
    ----------
    polys, balls
        Its coefficients, lowest first, and their values.
    zero
        Whether a coefficient is proved to vanish.
    """
    if grows(balls):
        return True
    gone = [c == 0 or (b.contains(0) and zero(c)) for c, b in zip(polys, balls, strict=True)]
    if all(gone):
        return None
    rest = [arb(0) if z else b for z, b in zip(gone, balls, strict=True)][gone.index(False) :]
    if rest[-1].contains(0):
        return None
    if len(rest) == 1:
        return False
    sign = hurwitz_sign(verdict_polynomial(monic(rest), 0, is_even(rest)))
    return None if sign == 0 else sign < 0


class BranchMembers(AxisMembers):
    """The members of a family with functions of the axis, or with unknowns."""

    exact = False
    how = (
        "every value at which a condition can vanish, or members can meet, was isolated exactly, "
        "with functions and unknowns as algebraic numbers"
    )

    def __init__(self, line: AxisScan, tower: Tower, budget: Budget, *, extra: bool) -> None:
        self.line, self.tower, self.budget = line, tower, budget
        self.family = line.problem.family
        self.sought = bool(self.family.unknown) and not self.family.closed
        if self.sought:
            self.how += ", on one branch of steady motions"
        self.even = [is_even(a) for a, _ in tower.whole.factors]
        self.dissipative = not extra and not any(self.even)
        watched_norms = (
            (norm, w) for w in watched(tower, budget) for norm in norms(tower, w.image, budget)
        )
        self.candidates = Candidates(tower.base, tower.number, watched_norms, tower.polynomial.ends)

    # --- at a number ---

    def look(self, value: float) -> AxisVerdict:
        """The verdict and the branch at a number."""
        reason, label = OPEN, None
        for bits in LADDER:
            with precision(bits):
                try:
                    full = self._full(arb(value))
                except (StabilityError, ZeroDivisionError):
                    return AxisVerdict(0, None, NO_MEMBER)
                values = self._compact(full)
                if not all(v.is_finite() for v in values.values()):
                    return AxisVerdict(0, None, NO_VALUE)
                if self.tower.polynomial.elsewhere(full) is not None:
                    return AxisVerdict(0, None, OTHER)
                label = self._label(values)
                sign = self._sign(values) if label is not None and self._regular(values) else 0
            if sign:
                return AxisVerdict(sign, label, "")
        return AxisVerdict(0, label, reason)

    def values_at(self, value: Any) -> Mapping[int, Any]:
        """Values of the polynomials' variables at a ball of the axis.

        Raises
        ------
        NoMemberError
            If there is no member, or an unknown is not proved to be positive.
        """
        return self._compact(self._full(value))

    def _full(self, value: Any) -> dict[int, Any]:
        """Values of every indeterminate."""
        values = self.tower.polynomial.at(value)
        names = self.tower.polynomial.base
        for name in self.family.positive if self.sought else ():
            if not values[names.index(name)] > 0:
                raise NoMemberError(f"{self.family.name}: {name} is not proved to be positive.")
        return values

    def _compact(self, values: Mapping[int, Any]) -> dict[int, Any]:
        return {new: values[old] for new, old in enumerate(self.tower.whole.indices)}

    def sign(self, value: float, cell: CandidateCell) -> int:
        """The proved verdict at a number, by the graph or the polynomials; 0 on another branch."""
        look = self.look(value)
        if look.label != cell.look.label:
            return 0
        try:
            return look.sign and (self.line.sign(value) or look.sign)
        except StabilityError:
            return 0

    def _regular(self, values: Mapping[int, Any]) -> bool:
        return not any(arb(evaluate(p, values)).contains(0) for p in self.tower.whole.nonzero)

    def _label(self, values: Mapping[int, Any]) -> tuple[int, ...] | None:
        out = []
        for level in self.tower.levels:
            if level.equation is None:
                continue
            row = coefficient_row(level.equation, level.place)
            balls = [arb(evaluate(c, values)) for c in row]
            roots = None if balls[-1].contains(0) else isolated(balls, even=False)
            if roots is None:
                return None
            real = sorted((r.real for r in roots if r.imag == 0), key=lambda r: r.mid())
            same = [i for i, r in enumerate(real) if r.overlaps(values[level.place])]
            if len(same) != 1:
                return None
            out.append(same[0])
        return tuple(out)

    def factors(self, values: Mapping[int, Any]) -> list[list[Any]]:
        """Coefficients of each factor as balls, lowest first.

        Parameters
        ----------
        values
            Values of the variables.
        """
        return [[arb(evaluate(c, values)) for c in a] for a, _ in self.tower.whole.factors]

    def _sign(self, values: Mapping[int, Any]) -> int:
        every = self.factors(values)
        if any(a[-1].contains(0) for a in every):
            return 0
        return least_sign(
            [
                hurwitz_sign(
                    verdict_polynomial(monic(a), 0, is_even(self.tower.whole.factors[index][0]))
                )
                for index, a in enumerate(every)
            ]
        )

    # --- between candidates ---

    def cell(self, low: Any, high: Any) -> CandidateCell:
        """What is proved between two neighbouring candidates, or a candidate and an end."""
        looks = list(self._looks(low, high))
        proved = [(place, look) for place, look in looks if look.sign]
        if not proved:
            place, look = looks[0] if looks else (math.nan, AxisVerdict(0, None, NEAR))
            return CandidateCell(low, high, place, look)
        [(label, _)] = Counter(look.label for _, look in proved).most_common(1)
        good = [entry for entry in proved if entry[1].label == label]
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
        return CandidateCell(low, high, place, look, tuple(doubts))

    def _looks(self, low: Any, high: Any) -> Iterator[tuple[float, AxisVerdict]]:
        """Numbers in a piece, in increasing order, with what is proved there.

        One number is enough where nothing is solved for.  A root-finder may pass to another branch
        anywhere, most often near an end of the piece, so more numbers show whether it does.
        """
        ends = low.upper(), high.lower()
        shares: tuple[float, ...] = SHARES
        if self.sought:
            width = self.candidates.high - self.candidates.low
            part = float(((ends[1] - ends[0]) / width).mid())
            count = FEWEST + math.ceil(MORE * min(part, 1.0))
            shares = tuple(math.sin(math.pi * (i + 0.5) / (2 * count)) ** 2 for i in range(count))
        for share in shares:
            place = float((ends[0] + (ends[1] - ends[0]) * share).mid())
            if not (arb(place) > low and arb(place) < high):
                continue
            look = self.look(place)
            yield place, look
            if look.sign and shares is SHARES:
                return

    def unstable_in(self, cell: CandidateCell) -> list[int] | None:
        """Counted in balls, at numbers where the member is proved."""
        if not cell.look.sign:
            return None
        middles = (float((cell.low + (cell.high - cell.low) * s).mid()) for s in SHARES)
        places = [cell.place, *(m for m in middles if arb(m) > cell.low and arb(m) < cell.high)]
        powers = [power for _, power in self.tower.whole.factors]
        for place, bits in product(places, LADDER):
            if bits == LADDER[0] and not self.holds(place, cell):
                continue
            with precision(bits):
                every = self.factors(self.values_at(arb(place)))
                counts = [
                    unstable_count(a, even=even) for a, even in zip(every, self.even, strict=True)
                ]
            if None not in counts:
                return [power * (n or 0) for n, power in zip(counts, powers, strict=True)]
        return None

    def holds(self, value: float, cell: CandidateCell) -> bool:
        """Whether the member lies on the branch of the piece."""
        return self.look(value).label == cell.look.label

    # --- at a candidate ---

    def factors_at(self, candidate: Candidate) -> list[tuple[list[Any], int]]:
        """Factors in balls at a candidate, each with its power."""
        value = self.candidates.refined(candidate, FINE_BITS)
        with precision(FINE_BITS):
            rows = self.factors(self.values_at(value))
        return list(zip(rows, (power for _, power in self.tower.whole.factors), strict=True))

    def vanishing(self, candidate: Candidate) -> list[Watched] | None:
        """Polynomials that are not proved to differ from zero; None without a member."""
        left = list(candidate.watched)
        for bits in LADDER[1:]:
            try:
                value = self.candidates.refined(candidate, bits)
                with precision(bits):
                    values = self.values_at(value)
                    left = [w for w in left if arb(evaluate(w.poly, values)).contains(0)]
            except (StabilityError, ZeroDivisionError, UnclearError):
                # the root-finder fails where branches cross, and the branch goes on
                through = "crossed" in candidate.kinds and not candidate.kinds & {
                    "fold",
                    "pole",
                    "end",
                }
                return list(candidate.watched) if through else None
            if not left:
                break
        return left

    def joined(self, candidate: Candidate, below: CandidateCell, above: CandidateCell) -> bool:
        """Whether the members on both sides of a candidate lie on one branch through it."""
        labels = [below.look.label, above.look.label]
        if not candidate.kinds & {"fold", "pole", "end"}:
            return labels[0] == labels[1]
        middle = float(candidate.value.mid())
        for share in CLOSE:
            low = middle - share * (middle - below.place)
            high = middle + share * (above.place - middle)
            if not (low < candidate.value < high):
                continue
            if [self.look(low).label, self.look(high).label] != labels:
                return False
            if self.line.joined(low, middle, high):
                return True
        return False

    def meets(
        self, candidate: Candidate, kept: list[Watched], below: CandidateCell, above: CandidateCell
    ) -> bool:
        """Whether one of some polynomials is proved to vanish at a candidate."""
        return any(self._vanishes(candidate, what, (below.place, above.place)) for what in kept)

    def _vanishes(self, candidate: Candidate, what: Watched, ends: tuple[float, float]) -> bool:
        if occurring(what.image) <= {0, 1}:
            return True  # the polynomial is its own norm
        with precision(LADDER[0]):
            signs = [arb(evaluate(what.poly, self.values_at(arb(end)))) for end in ends]
        if signs[0] * signs[1] < 0:
            return True
        return self._small(candidate, what.image, what.poly)

    def _small(self, candidate: Candidate, image: Any, poly: Any) -> bool:
        """Whether a value is smaller than each of its conjugates that is not zero."""
        least = least_size(self.tower, image, candidate.norm, self.budget)
        if least is None:
            return False
        bits = 2 * (int(least.q).bit_length() - int(least.p).bit_length()) + 128
        if bits > MOST_BITS:
            return False
        try:
            value = self.candidates.refined(candidate, bits)
            with precision(bits):
                return bool(abs(arb(evaluate(poly, self.values_at(value)))) < arb(least))
        except (StabilityError, UnclearError):
            return False

    def unstable(self, candidate: Candidate) -> bool | None:
        """Whether the member at a candidate is unstable; None where this is not proved."""

        def zero(poly: Any) -> bool:
            return self._nothing(candidate, poly)

        rows = [a for a, _ in self.tower.whole.factors]
        try:
            value = self.candidates.refined(candidate, LADDER[1])
            with precision(LADDER[1]):
                balls = self.factors(self.values_at(value))
                growth = [growing(a, b, zero) for a, b in zip(rows, balls, strict=True)]
        except (StabilityError, UnclearError, ZeroDivisionError):
            return None
        return True if True in growth else None if None in growth else False

    def _nothing(self, candidate: Candidate, poly: Any) -> bool:
        """Whether a coefficient is proved to vanish at a candidate."""
        for factor, _ in factors(poly)[1]:
            image = self.tower.image(factor)
            if occurring(image) <= {0, 1} and not divmod(image, candidate.norm)[1]:
                return True
            if self._small(candidate, image, factor):
                return True
        return False
