"""Values of an axis at which a watched polynomial can vanish, isolated as roots of norms."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from flint import arb, ctx

from ...algebra.balls import precision
from ...algebra.exact.hurwitz_forms import Budget
from ...algebra.exact.number_fields import NotExact, rational
from ...algebra.exact.real_roots import UnclearError, real_roots
from .polynomials import Watched, in_base, norms
from .tower import Tower

BITS = 256
"""Working precision of the first attempt."""
MOST_BITS = 4096
"""Largest working precision."""
MOST_CANDIDATES = 400
"""Largest number of candidates."""
BEYOND = 1 / 64
"""Share of the interval by which candidates are sought beyond its ends."""


@dataclass(frozen=True)
class Candidate:
    """A value of the axis at which some polynomials can vanish."""

    value: Any
    """Ball that holds no other candidate."""
    norm: Any
    """Irreducible polynomial in z (and s) with the value's z as a root, in the tower's ring."""
    watched: tuple[Watched, ...]
    """Polynomials that can vanish there."""


class Candidates:
    """All candidates along an interval.

    Parameters
    ----------
    tower
        The variables.
    polynomials
        The watched polynomials.
    low, high
        Ends of the interval.
    budget
        Limits of the work.

    Raises
    ------
    NotExact
        If norms are too large, vanish identically, or have too many roots.
    UnclearError
        If the budget of precision ends.
    """

    def __init__(
        self, tower: Tower, polynomials: Sequence[Watched], low: float, high: float, budget: Budget
    ) -> None:
        self.tower, self.ends = tower, (low, high)
        self._norms: dict[str, tuple[Any, list[Watched]]] = {}
        self._known: dict[tuple[str, int], list[Any]] = {}
        for one in polynomials:
            for norm in norms(tower, one.image, budget):
                self._norms.setdefault(str(norm), (norm, []))[1].append(one)
        self.found = self._separated()
        """Candidates in increasing order, some of them a little beyond the interval."""

    def _values(self, norm: Any) -> list[Any]:
        """Values of the axis at the roots of a norm, at the working precision; cached."""
        key = str(norm), ctx.prec
        if key not in self._known:
            self._known[key] = self._isolated(norm)
        return self._known[key]

    def _isolated(self, norm: Any) -> list[Any]:
        poly = in_base(norm)
        if poly.derivative("x").is_zero():  # a number other than zero, or transcendental
            return []
        low, high = map(rational, self.ends)
        room = (high - low) * rational(BEYOND)
        ends = arb(low - room), arb(high + room)
        roots = real_roots([poly], self.tower.number)
        return [x for z in roots for x in self.tower.base.back(z, *ends)]

    def _separated(self) -> list[Candidate]:
        bits = BITS
        while bits <= MOST_BITS:
            with precision(bits):
                try:
                    return self._all()
                except UnclearError:
                    bits *= 2
        raise UnclearError

    def _all(self) -> list[Candidate]:
        found = [
            Candidate(value, norm, tuple(some))
            for norm, some in self._norms.values()
            for value in self._values(norm)
        ]
        if len(found) > MOST_CANDIDATES:
            raise NotExact(f"there are {len(found)} candidates, more than {MOST_CANDIDATES}")
        found.sort(key=lambda c: c.value.mid())
        for one, other in zip(found[:-1], found[1:], strict=True):
            if not one.value < other.value:
                raise UnclearError
        return found

    def refined(self, one: Candidate, bits: int) -> Any:
        """The value of a candidate at another precision.

        Parameters
        ----------
        one
            The candidate.
        bits
            The precision.

        Raises
        ------
        UnclearError
            If the value is not found again.
        """
        with precision(bits):
            same = [x for x in self._values(one.norm) if x.overlaps(one.value)]
        if len(same) != 1:
            raise UnclearError
        return same[0]
