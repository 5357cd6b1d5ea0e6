"""Values of an axis at which a watched polynomial can vanish, isolated as roots of norms.

A watched polynomial can vanish where a verdict changes; its norm is a polynomial in z alone.  The
norm of a polynomial is its resultant with the relations of all variables but z.  It vanishes
wherever the polynomial vanishes at some solution of the relations, so its roots are candidates.

Source: B. L. van der Waerden, Algebra I, § 5.8 (the resultant lies in the ideal of both).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from flint import arb, ctx, fmpq_poly

from ...algebra.exact.function_field import occurring
from ...algebra.exact.hurwitz_forms import (
    Budget,
    by_power,
    factors,
    hurwitz_determinants,
    subdiscriminants,
)
from ...algebra.exact.number_fields import NotExact
from ...algebra.exact.rational_functions import RING
from ...algebra.exact.roots import BITS, MOST_BITS, UnclearError, real_roots
from ...algebra.exact.routh import is_even
from ...algebra.exact.triangular import remainder
from ...algebra.number_types import precision
from .tower import Base, Tower

MOST_DEGREE = 12
"""Largest degree of a relation in its variable."""
MOST_CONJUGATES = 100
"""Largest number of conjugates of a value that is proved to be zero."""


@dataclass(frozen=True)
class Watched:
    """A polynomial that may vanish."""

    kind: str
    """static, flutter, pole (no linearisation), fold (members meet, or go to infinity), end (an
    unknown that must be positive vanishes), kink (the argument of a square root, as of |x|) or
    crossed (another branch crosses this one)."""
    poly: Any
    """The polynomial in the ring of the family's polynomials."""
    image: Any
    """The same in the ring of the tower."""


def watched(tower: Tower, budget: Budget) -> list[Watched]:
    """Every polynomial whose zeros on the branch may end a piece of constant verdict."""
    form = tower.polynomial.factored
    conditions: list[tuple[str, Any]] = [
        ("crossed" if p in form.crossed else "pole", p) for p in form.nonzero
    ]
    conditions += [("end", p) for p, _ in form.required]
    for a, _ in form.factors:
        conditions.append(("pole", a[-1]))
        conditions += critical(
            a,
            lambda p: hurwitz_determinants(p, budget)[-1],
            lambda q: subdiscriminants(q, budget)[-1],
        )
    for level in tower.levels:
        if level.equation is not None:
            # √ is the larger root on both sides, so nothing meets where its argument vanishes
            root = tower.polynomial.field.meaning.get(form.indices[level.place], ("",))[0]
            kind = "kink" if root == "sqrt" else "fold"
            conditions.append((kind, level.equation.derivative(level.place)))
            parts = by_power(level.equation, level.place)
            conditions.append(("fold", parts[max(parts)]))
    out: dict[tuple[str, str], Watched] = {}
    for kind, poly in conditions:
        for factor, _ in factors(_reduced(tower, poly))[1]:
            out[kind, str(factor)] = Watched(kind, factor, tower.image(factor))
    return list(out.values())


def critical(
    a: Sequence[Any], pair: Callable[[Sequence[Any]], Any], meeting: Callable[[Sequence[Any]], Any]
) -> list[tuple[str, Any]]:
    """Polynomials that vanish where a root of one factor meets the imaginary axis.

    Parameters
    ----------
    a
        Coefficients of the factor, lowest first.
    pair, meeting
        Functions from coefficients to the Hurwitz determinant of order n - 1, and of q to the
        discriminant of q, up to powers of the leading coefficient.
    """
    n = len(a) - 1
    conditions, even = [("static", a[0])], is_even(a)
    if even and n > 2:
        conditions.append(("flutter", meeting(a[::2])))
    if not even and n > 1:
        conditions.append(("flutter", pair(a)))
    return conditions


def _reduced(tower: Tower, poly: Any) -> Any:
    """A polynomial modulo relations whose leading coefficient is a number."""
    for level in tower.levels:
        if level.equation is not None and level.place in occurring(poly):
            parts = by_power(level.equation, level.place)
            if parts[max(parts)].is_constant():
                poly = remainder(poly, level.equation, level.place)[0]
    if poly == 0:
        raise NotExact("a condition vanishes all along the axis")
    return poly


def norms(tower: Tower, image: Any, budget: Budget) -> list[Any]:
    """Irreducible polynomials in z and s, one of which vanishes wherever a polynomial does.

    Parameters
    ----------
    tower
        The variables.
    image
        A polynomial in the ring of the tower, perhaps with w.
    budget
        Limits of the work.

    Raises
    ------
    NotExact
        If a norm vanishes identically, or is too large.
    """
    waiting = [image]
    for level in tower.levels:
        following: dict[str, Any] = {}
        for poly in waiting:
            for factor in _eliminated(poly, level, budget):
                following[str(factor)] = factor
        waiting = list(following.values())
    return waiting


def _eliminated(poly: Any, level: Any, budget: Budget) -> list[Any]:
    if level.index in occurring(poly):
        degree = level.relation.degrees()[level.index]
        if degree > MOST_DEGREE:
            raise NotExact(f"a relation has degree {degree}, more than {MOST_DEGREE}")
        rest = remainder(poly, level.relation, level.index)[0]
        if rest == 0:
            raise NotExact("a condition vanishes all along the axis")
        if len(rest) ** degree > budget.terms**2:
            raise NotExact(f"a norm of {len(rest)} terms and degree {degree} is too large")
        # the leading coefficient that the remainder was multiplied with adds candidates only
        poly = (
            rest.resultant(level.relation, level.index) if level.index in occurring(rest) else rest
        )
        budget.watch(poly)
        if poly == 0:
            raise NotExact("a condition vanishes all along the axis, on some branch")
    return [f for f, _ in factors(poly)[1]]


def in_base(poly: Any) -> Any:
    """A polynomial in z and s as an element of `RING`."""
    if not occurring(poly) <= {0, 1}:
        raise NotExact("a variable was not eliminated")
    return RING.from_dict({tuple(map(int, e[:2])): c for e, c in poly.to_dict().items()})


def least_size(tower: Tower, image: Any, norm: Any, budget: Budget) -> Any | None:
    """A positive number below the size of every conjugate of a value, unless this is zero.

    The conjugates are the values of a polynomial at all solutions of the relations over all roots
    of its norm.  They are the roots of a polynomial T(w) over Q, whose coefficients bound its
    roots other than zero from below (Cauchy).

    Parameters
    ----------
    tower
        The variables, without a transcendental constant.
    image
        The polynomial, in the ring of the tower.
    norm
        An irreducible polynomial in z, in the ring of the tower.
    budget
        Limits of the work.

    Returns
    -------
    fmpq or None
        None where the work is too large.
    """
    count = norm.degrees()[0]
    for level in tower.levels:
        count *= level.relation.degrees()[level.index]
    if count > MOST_CONJUGATES or 1 in occurring(image) | occurring(norm):
        return None
    w = tower.ring.gens()[-1]
    poly = w - image
    try:
        for level in tower.levels:
            if level.index in occurring(poly):
                poly = poly.resultant(level.relation, level.index)
                budget.watch(poly)
        poly = poly.resultant(norm, 0)
        budget.watch(poly)
    except NotExact:
        return None
    if poly == 0 or not occurring(poly) <= {len(tower.ring.gens()) - 1}:
        return None
    terms = {int(e[-1]): abs(c) for e, c in poly.to_dict().items()}
    low = min(terms)
    above = [c for power, c in terms.items() if power > low]
    if not above:
        return None if low == 0 else fmpq_poly([1])[0]
    return terms[low] / (terms[low] + max(above))


MOST_CANDIDATES = 400
"""Largest number of candidates."""
BEYOND = 64
"""The interval over the part beyond each of its ends in which candidates are sought."""


@dataclass(frozen=True)
class Candidate:
    """A value of the axis at which some polynomials can vanish."""

    value: Any
    """Ball that holds no other candidate."""
    root: Any
    """Ball of the base variable there."""
    norm: Any
    """Irreducible polynomial in z (and s) with this root, in the ring of the watched images."""
    watched: tuple[Watched, ...]
    """Polynomials that can vanish there."""

    @property
    def kinds(self) -> set[str]:
        """Kinds of these."""
        return {w.kind for w in self.watched}


class Candidates:
    """All candidates along an interval.

    Parameters
    ----------
    base
        The axis as a function of z.
    number
        Function that gives the ball of s at the working precision.
    norms
        Irreducible polynomials, each with the watched polynomial that can vanish at its roots.
    ends
        Ends of the interval, doubles; None for no end.
    bits
        Working precision of the first attempt.

    Raises
    ------
    NotExact
        If there are too many.
    UnclearError
        If the budget of precision ends.
    """

    def __init__(
        self,
        base: Base,
        number: Callable[[], Any] | None,
        norms: Iterable[tuple[Any, Watched]],
        ends: tuple[float | None, float | None],
        bits: int = BITS,
    ) -> None:
        self.base, self.number = base, number
        # exact: ends are doubles
        self.low: Any = None if ends[0] is None else arb(ends[0])
        self.high: Any = None if ends[1] is None else arb(ends[1])
        self._norms: dict[str, tuple[Any, list[Watched]]] = {}
        self._known: dict[tuple[str, int], list[tuple[Any, Any]]] = {}
        for norm, watched in norms:
            self._norms.setdefault(str(norm), (norm, []))[1].append(watched)
        self.ordered = self._separated(bits)
        """Candidates in increasing order, some of them a little beyond the interval."""

    def _values(self, norm: Any) -> list[tuple[Any, Any]]:
        """Values of the axis and of z at the roots of a norm, at the working precision; cached."""
        key = str(norm), ctx.prec
        if key not in self._known:
            self._known[key] = self._isolated(in_base(norm))
        return self._known[key]

    def _isolated(self, poly: Any) -> list[tuple[Any, Any]]:
        if poly.derivative(0).is_zero():  # a number other than zero, or transcendental
            return []
        low = arb("-inf") if self.low is None else self.low - self._room(self.low)
        high = arb("inf") if self.high is None else self.high + self._room(self.high)
        roots = real_roots([poly], self.number)
        return [(x, z) for z in roots for x in self.base.back(z, low, high)]

    def _separated(self, bits: int) -> list[Candidate]:
        while bits <= MOST_BITS:
            with precision(bits):
                try:
                    candidates, self.bits = self._all(), bits
                    return candidates
                except UnclearError:
                    bits *= 2
        raise UnclearError("candidates could not be separated")

    def _all(self) -> list[Candidate]:
        candidates = [
            Candidate(value, root, norm, tuple(some))
            for norm, some in self._norms.values()
            for value, root in self._values(norm)
        ]
        if len(candidates) > MOST_CANDIDATES:
            raise NotExact(f"there are {len(candidates)} candidates, more than {MOST_CANDIDATES}")
        candidates.sort(key=lambda c: c.value.mid())
        for lower, upper in zip(candidates[:-1], candidates[1:], strict=True):
            if not lower.value < upper.value:
                raise UnclearError
        return candidates

    @cached_property
    def fence(self) -> list[Any]:
        """Ends of the pieces between candidates; next to one at an end of the interval, beyond."""
        values = [c.value for c in self.ordered]
        if not values:
            return [self.low, self.high]
        first, last = values[0], values[-1]
        low = self.low if self.low is not None and self.low < first else first - self._room(first)
        high = self.high if self.high is not None and self.high > last else last + self._room(last)
        bottom, top = self.base.domain
        low = bottom if bottom is not None and low < bottom else low
        high = top if top is not None and high > top else high
        return [low, *values, high]

    def _room(self, value: Any) -> Any:
        """Way beyond the interval, or beyond the last value where it has no end."""
        if self.low is None or self.high is None:
            return 2 + abs(value)
        return (self.high - self.low) / BEYOND

    def inside(self, candidate: Candidate) -> bool:
        """Whether a candidate may lie in the closed interval."""
        under = self.low is not None and candidate.value < self.low
        return not under and not (self.high is not None and candidate.value > self.high)

    def refined(self, candidate: Candidate, bits: int) -> Any:
        """The value of a candidate at another precision.

        Raises
        ------
        UnclearError
            If the value is not found again.
        """
        with precision(bits):
            same = [x for x, _ in self._values(candidate.norm) if x.overlaps(candidate.value)]
        if len(same) != 1:
            raise UnclearError
        return same[0]
