"""The members of a family at single values of an axis: their verdicts, and the branch they lie on.

A member is the one that the family's root-finder gives, proved in balls.  Where every unknown obeys
a polynomial without multiple roots, its place among the real roots of that polynomial names the
branch: roots that depend continuously on the axis keep their order.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from flint import arb

from ...algebra.balls import precision
from ...algebra.exact.hurwitz_forms import Budget, by_power, factors
from ...algebra.exact.real_roots import UnclearError
from ...algebra.exact.root_balls import isolated
from ...algebra.exact.triangular import occurring
from ...algebra.routh_balls import hurwitz_sign, verdict_polynomial
from ...base.errors import NoMemberError, StabilityError
from ...derivation.general.elimination import evaluate
from ..brackets import AxisScan
from ..interval_search.pieces import NO_MEMBER, NO_VALUE
from ..single_points import grows
from .candidates import Candidate, Candidates
from .polynomials import Watched, least_size
from .tower import Tower

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
    """The family's members along a line.

    Parameters
    ----------
    line
        The line.
    tower
        Its variables.
    budget
        Limits of the work.
    """

    def __init__(self, line: AxisScan, tower: Tower, budget: Budget) -> None:
        self.line, self.tower, self.budget = line, tower, budget
        self.family = line.problem.family

    # --- at a number ---

    def look(self, value: float) -> Look:
        """The verdict and the branch at a number.

        Parameters
        ----------
        value
            Value of the axis.
        """
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

        Parameters
        ----------
        value
            The ball.

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
        """The proved verdict at a number, by the graph or the polynomials; 0 on another branch.

        Parameters
        ----------
        value
            Value of the axis.
        label
            The branch.
        """
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
            parts = by_power(level.own, level.place)
            balls = [
                arb(evaluate(parts[k], known)) if k in parts else arb(0)
                for k in range(max(parts) + 1)
            ]
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
        a = self.tower.whole.factors[index][0]
        return len(a) % 2 == 1 and all(c == 0 for c in a[1::2])

    def _sign(self, known: Mapping[int, Any]) -> int:
        signs = []
        for index, a in enumerate(self.factors(known)):
            if a[-1].contains(0):
                return 0
            upright = [c / a[-1] for c in a[:-1]] + [arb(1)]
            signs.append(hurwitz_sign(verdict_polynomial(upright, 0, self.even(index))))
        return -1 if -1 in signs else 0 if 0 in signs else 1

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
        even = len(rest) % 2 == 1 and all(c == 0 for c in rest[1::2])
        upright = [c / rest[-1] for c in rest[:-1]] + [arb(1)]
        sign = hurwitz_sign(verdict_polynomial(upright, 0, even))
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
