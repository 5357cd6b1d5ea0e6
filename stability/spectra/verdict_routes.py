"""Routes to a proved verdict at a point, in the order in which they are tried.

A route is a `VerdictRoute`: what it needs of a `Point`, what it proves, and one attempt.  `ROUTES`
lists them, and `first_proof` is the one loop over the list.  Certificates, boundaries and open
cells of maps ask it.  A new route is a function, here or in a module that does not import this one,
and its `VerdictRoute` in `ROUTES`; one of your own is added to `ROUTES` by your module.  A route is
asked at a point that no route before it decides.

A known polynomial and the point's doubles are rational.  The sine of a double is transcendental
(Lindemann), so that no condition of the disk vanishes there and some precision decides.  A graph
takes the same steps: over Q where its member is rational, otherwise in balls, and over the field
of its unknowns where balls leave a zero open.  A graph with many states is first taken block by
block, in double precision with proved bounds.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any

import numpy as np
from flint import arb, ctx, fmpq_poly
from numpy.typing import ArrayLike

from ..algebra.exact.number_fields import EXACT, NotExact, nearest_root
from ..algebra.exact.roots import clustered, isolated
from ..algebra.exact.routh import (
    hurwitz_sign,
    is_even,
    on_the_axis,
    product,
    verdict_polynomial,
)
from ..algebra.number_types import MIXED, Algebra, precision
from ..base.errors import ParameterError
from ..base.verdict import Verdict, best
from ..polynomials.identities import certain, symmetric
from ..polynomials.member import Member, exact_verdict
from ..polynomials.zero_blocks import zero_power
from ..systems.family import Family
from ..systems.structure.places import LARGE
from ..systems.structure.structural_zeros import structure
from .blocks import Blocks
from .eigenvalues import (
    BY_ACCIDENT,
    NO_PROOF_OF_BLOCKS,
    NO_PROOF_OF_ZERO,
    NOT_STEADY,
    REASONS,
)
from .problem import Problem

BITS = 128
"""Precision of the first balls."""
FINE_BITS = 1024
"""Precision up to which balls come before the field of the unknowns."""
MOST_BITS = 8192
"""Largest precision; the verdict is undecided beyond it."""

Balls = Sequence[Any]


@dataclass(frozen=True)
class Proof:
    """What a route proves."""

    verdict: Verdict
    """The verdict; undecided where the reason for this is known."""
    bits: int
    """Precision of the balls; 0 for rational arithmetic, the route's `code` for another one; or a
    key of `eigenvalues.REASONS`."""
    nearby: bool = False
    """Whether the verdict holds at all members nearby too."""


ANYTHING = "any point"
ALONE = "a verdict that is asked for without its arithmetic, so that the quickest proof will do"
POLYNOMIAL = "a known polynomial"
GRAPH = "a member of a graph"
"""What a route may need, and a point may have."""


class Point:
    """A member whose verdict is asked for.

    Parameters
    ----------
    problem
        Family with values in the user's units.
    values
        Doubles by name, taken as exact, or as the ratios that the problem has for them.
    member
        For a user's family: the member, if known.
    most
        For a user's family: the largest precision of balls.
    alone
        Whether the verdict is asked for without the arithmetic of its proof.
    """

    quick: tuple[int, ...] = (BITS,)
    """Precisions at which Routh's array is tried before all else."""

    def __init__(
        self,
        problem: Problem,
        values: Mapping[str, float],
        member: Member | None = None,
        most: int | None = None,
        *,
        alone: bool = False,
    ) -> None:
        self.problem, self.values, self.most = problem, values, most or MOST_BITS
        self.has = {ANYTHING, GRAPH if problem.exact is None else POLYNOMIAL}
        """What routes may need."""
        if alone and problem.exact is None:
            self.has.add(ALONE)
        if member is not None:
            self.member = member

    @cached_property
    def member(self) -> Member:
        """The member in exact numbers."""
        return member_at(self.problem, self.values)

    @cached_property
    def zeros(self) -> int:
        """Number of eigenvalues that are zero by structure, each proved zero."""
        if POLYNOMIAL in self.has and self.problem.exact is not None:
            return self.problem.exact.zeros
        if GRAPH in self.has and not certain(self.problem.family):
            return structural_zeros(self.member)
        return structure(self.problem.family).zeros

    @cached_property
    def power(self) -> int | None:
        """The power of time with which its zeros let a disturbance grow; None without a proof."""
        return zero_power(self.member, self.zeros)

    @cached_property
    def blocks(self) -> Blocks | None:
        """The blocks of a large member; None where its root is not proved, or a rate not zero."""
        member = self.member
        large = len(member.family.system.states) > LARGE
        return Blocks(member, self.zeros) if large and member.reached else None

    def coefficients(self, bits: int) -> Balls | None:
        """The characteristic polynomial in balls, no zero proved; None without a member."""
        member = self.member
        with precision(bits):
            return member.plainly_enclosed()


def member_at(
    problem: Problem, values: Mapping[str, float], near: ArrayLike | None = None
) -> Member:
    """The member of a user's family at exact parameters.

    Parameters
    ----------
    problem, values
        As for `Point`.
    near
        Unknowns of the member to double precision, shape (u,); from the family's root-finder
        when left out.

    Returns
    -------
    Member
    """
    family = problem.family
    a, q, _ = exact_numbers(problem, values)
    if near is None:
        rows = [np.array([float(arb(v)) for v in part])[None, :] for part in (a, q)]
        near = family.solve(*rows)[0]
    return Member(family, a, q, np.asarray(near, dtype=float).tolist())


def exact_numbers(
    problem: Problem, values: Mapping[str, float]
) -> tuple[list[Any], list[Any], Any]:
    """Family parameters, parameters and unit of rate: rationals, or balls where irrational."""
    numbers = problem.rationals(values)
    if "lean" in numbers:  # π/2 - lean is a ball at best
        numbers["lean"] = arb(numbers["lean"])
    with precision(MOST_BITS):
        return problem.reduce(numbers, nearest_root)


def structural_zeros(member: Member) -> int:
    """Number of structural zero eigenvalues of a member, each proved zero at this member."""
    if certain(member.family):
        return structure(member.family).zeros
    return member.structural[0]


# --- the loop ---


def proved(point: Point) -> Proof:
    """The verdict of a point, with what its zero eigenvalues do to a disturbance."""
    proof = decided(point)
    if proof.verdict is not Verdict.STABLE:
        return proof
    if POLYNOMIAL in point.has and not point.problem.may_drift:
        return proof
    if point.power is None:
        return Proof(Verdict.UNDECIDED, NO_PROOF_OF_BLOCKS)
    return replace(proof, verdict=Verdict.DRIFTING) if point.power else proof


def decided(point: Point) -> Proof:
    """The verdict from the eigenvalues that are not zero by structure."""
    proof = first_proof(point, point.zeros)
    sure = proof.nearby or proof.verdict is Verdict.UNSTABLE or proof.bits == NOT_STEADY
    if sure or GRAPH not in point.has:
        return proof
    member, zeros = point.member, point.zeros
    ended = proof.verdict is Verdict.UNDECIDED and proof.bits == MOST_BITS
    if ended and member.seems_zero(zeros, MOST_BITS):
        return Proof(Verdict.UNDECIDED, NO_PROOF_OF_ZERO)
    low, high = (zeros, zeros) if certain(member.family) else member.structural
    if zeros == low < high and first_proof(point, high).verdict is not proof.verdict:
        # a zero that is not left out may be structural
        return Proof(Verdict.UNDECIDED, BY_ACCIDENT)
    return proof


def first_proof(point: Point, zeros: int) -> Proof:
    """The proof of the first route that has one, without a number of zero eigenvalues."""
    for route in ROUTES:
        proof = route.attempt(point, zeros) if route.needs in point.has else None
        if proof is not None:
            return proof
    return Proof(Verdict.UNDECIDED, MOST_BITS)


# --- the routes ---


ROUTES: list[VerdictRoute] = []
"""Every route, in the order in which they are tried."""


@dataclass(frozen=True)
class VerdictRoute:
    """One way to prove a verdict."""

    name: str
    """What it takes, in words."""
    needs: str
    """What a point must have; others are not tried."""
    proves: str
    """Verdicts that it proves."""
    attempt: Callable[[Point, int], Proof | None]
    """(point, number of eigenvalues to leave out, each zero by structure) → the proof, or None."""
    code: int = 0
    """For arithmetic that is neither over Q nor in balls: the negative number in place of bits."""
    arithmetic: str = ""
    """This arithmetic in words."""

    def __post_init__(self) -> None:
        taken = {r.code: r.name for r in ROUTES if r.name != self.name} | REASONS
        if self.code > 0 or (self.code < 0 and self.code in taken):
            raise ParameterError(
                f"the code of the route {self.name} is {self.code}, "
                + (f"which means: {taken[self.code]}" if self.code < 0 else "and not negative")
                + f"; give {min(taken) - 1}, or 0 for balls and rational numbers."
            )


def _by_blocks(point: Point, zeros: int) -> Proof | None:
    blocks = point.blocks if zeros == point.zeros else None
    if blocks is None or blocks.verdict is Verdict.UNDECIDED:
        return None
    return Proof(blocks.verdict, BLOCKS)


def _quick_array(point: Point, zeros: int) -> Proof | None:
    family = point.problem.family
    if GRAPH in point.has and not certain(family):
        return None
    for bits in point.quick:
        coefficients = point.coefficients(bits)
        with precision(bits):
            verdict = by_routh(family, coefficients, zeros)
        if verdict is not None:
            return Proof(verdict, bits, nearby=True)
    return None


def _signs_over_q(point: Point, _: int) -> Proof | None:
    with suppress(NotExact):
        verdict = by_signs(point.problem, _conditions(point, EXACT))
        return None if verdict is None else Proof(verdict, 0, nearby=True)
    return None


def _polynomial_over_q(point: Point, _: int) -> Proof | None:
    with suppress(NotExact):
        return Proof(on_the_axis([fmpq_poly(c) for c in _factors(point, EXACT)]), 0)
    return None


def _signs_in_balls(point: Point, _: int) -> Proof | None:
    if _conditions(point, MIXED) is None:
        return None
    proof = _raised(lambda: by_signs(point.problem, _conditions(point, MIXED)), BITS, MOST_BITS)
    return proof and replace(proof, nearby=True)


def _polynomial_in_balls(point: Point, _: int) -> Proof | None:
    if _conditions(point, MIXED) is not None:  # its signs are as good, and cost less
        return None
    return _raised(lambda: by_roots(product(_factors(point, MIXED))), BITS, MOST_BITS)


def _conditions(point: Point, algebra: Algebra) -> Sequence[tuple[str, Any]] | None:
    assert point.problem.exact is not None
    return point.problem.exact.conditions(point.problem.rationals(point.values), algebra)


def _factors(point: Point, algebra: Algebra) -> Sequence[Sequence[Any]]:
    assert point.problem.exact is not None
    return point.problem.exact.coefficients(point.problem.rationals(point.values), algebra)


def _not_steady(point: Point, _: int) -> Proof | None:
    return None if point.member.steady else Proof(Verdict.UNDECIDED, NOT_STEADY)


def _graph_over_q(point: Point, zeros: int) -> Proof | None:
    coefficients = point.member.rational
    if coefficients is None:
        return None
    if any(c != 0 for c in coefficients[:zeros]):  # these zeros are not proved
        return Proof(Verdict.UNDECIDED, NO_PROOF_OF_ZERO)
    return Proof(on_the_axis([fmpq_poly(coefficients[zeros:])]), 0)


def _graph_in_balls(low: int, high: int, point: Point, zeros: int) -> Proof | None:
    return _raised(lambda: by_roots(point.member.enclosed()[zeros:]), low, min(high, point.most))


def _field_of_unknowns(point: Point, zeros: int) -> Proof | None:
    if point.most < FINE_BITS:
        return None
    verdict = exact_verdict(point.member, zeros)
    return None if verdict is None else Proof(verdict, FIELD)


def _raised(attempt: Callable[[], Verdict | None], low: int, high: int) -> Proof | None:
    """The first verdict as the precision is doubled."""
    bits = low
    while bits <= high:
        with precision(bits):
            verdict = attempt()
        if verdict is not None:
            return Proof(verdict, bits)
        bits *= 2
    return None


INSIDE = "verdicts off the boundaries"
SEEN = "verdicts off the boundaries, and with roots on the axis where balls show them"
ALL = "every verdict"
FIELD, FIELD_IN_WORDS = -5, "exact algebra modulo the member's equations"
BLOCKS, BLOCKS_IN_WORDS = -7, "balls of doubles, block by block"
FIRST = partial(_graph_in_balls, BITS, FINE_BITS)
LAST = partial(_graph_in_balls, 2 * FINE_BITS, MOST_BITS)

ROUTES += [
    VerdictRoute("discs of a large member", GRAPH, SEEN, _by_blocks, BLOCKS, BLOCKS_IN_WORDS),
    VerdictRoute("Routh's array of the graph in balls", ALONE, INSIDE, _quick_array),
    VerdictRoute("signs of conditions over Q", POLYNOMIAL, INSIDE, _signs_over_q),
    VerdictRoute("known polynomial over Q", POLYNOMIAL, ALL, _polynomial_over_q),
    VerdictRoute("signs of conditions in balls", POLYNOMIAL, INSIDE, _signs_in_balls),
    VerdictRoute("known polynomial in balls", POLYNOMIAL, SEEN, _polynomial_in_balls),
    VerdictRoute("a rate that is not zero", GRAPH, "that there is no verdict", _not_steady),
    VerdictRoute("polynomial of the graph over Q", GRAPH, ALL, _graph_over_q),
    VerdictRoute("polynomial of the graph in balls", GRAPH, SEEN, FIRST),
    VerdictRoute("field of the unknowns", GRAPH, ALL, _field_of_unknowns, FIELD, FIELD_IN_WORDS),
    VerdictRoute("polynomial of the graph in more digits", GRAPH, SEEN, LAST),
]


def in_words(bits: int) -> str:
    """Arithmetic of a proof, in words.

    Parameters
    ----------
    bits
        Precision of the balls, 0 for rational arithmetic, or the code of a route.
    """
    words = {route.code: route.arithmetic for route in ROUTES if route.code}
    if bits < 0:
        return words.get(bits, "no arithmetic")
    return f"balls of {bits} bits" if bits else "rational arithmetic"


# --- from numbers to a verdict ---


def by_routh(family: Family, coefficients: Balls | None, zeros: int) -> Verdict | None:
    """The verdict of a characteristic polynomial in balls, by Routh's array alone."""
    if coefficients is None:
        return None
    even = family.conservative or symmetric(family)
    sign = hurwitz_sign(verdict_polynomial(coefficients, zeros, even))
    return {1: best(even=even), -1: Verdict.UNSTABLE}.get(sign)


def by_signs(problem: Problem, conditions: Sequence[tuple[str, Any]] | None) -> Verdict | None:
    """The verdict of conditions: all positive, or some negative."""
    if conditions is None:
        return None
    if any(v < 0 for _, v in conditions):
        return Verdict.UNSTABLE
    good = all(v > 0 for _, v in conditions)
    return best(even=problem.family.conservative) if good else None


def by_roots(polynomial: Balls) -> Verdict | None:
    """The verdict by Routh's array, or by the roots where the array meets a zero.

    A ball equals 0 only as the exact zero; a wider ball around 0 is neither equal nor unequal.
    """
    if not all(c.is_finite() for c in polynomial):
        return None
    extra = next(i for i, c in enumerate(polynomial) if not c == 0)
    rest = list(polynomial[extra:])
    if len(rest) == 1:
        return Verdict.NEUTRAL
    even = is_even(rest)
    sign = hurwitz_sign(verdict_polynomial(rest, 0, even))
    if sign == 0:
        sign = _sign_of(isolated(rest, even))
    if sign == 0 and ctx.prec <= FINE_BITS:  # a ball of a cluster holds all roots of the cluster
        sign = _sign_of(clustered(rest))
    if sign > 0:
        return Verdict.NEUTRAL if even or extra else Verdict.STABLE
    return Verdict.UNSTABLE if sign else None


def _sign_of(roots: Balls | None) -> int:
    if roots is not None and any(r.real > 0 for r in roots):
        return -1
    return int(roots is not None and all(r.real < 0 for r in roots))
