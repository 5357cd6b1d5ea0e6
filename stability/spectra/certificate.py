"""Proved verdicts and eigenvalue enclosures, in rational arithmetic where possible or in balls.

If the body or the family has an exact polynomial, the proof starts from the polynomial and from the
given doubles as rationals.  If the disk's θ is a double, its sine is transcendental (Lindemann), so
no condition vanishes there and some precision decides.  A lean of exactly zero is the right angle.
Any other family takes the same steps: over Q where its member and its graph are rational, otherwise
in balls with proved zeros.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from flint import acb, arb, ctx, fmpq_poly
from numpy.typing import ArrayLike

from ..algebra.exact.number_fields import EXACT, NotExact, nearest_root
from ..algebra.exact.roots import bounded_roots, clustered, isolated
from ..algebra.exact.routh import hurwitz_sign, on_the_axis, product, verdict_polynomial
from ..algebra.number_types import MIXED, balls, precision, upper
from ..algebra.polynomial import ExactPolynomial
from ..base.verdict import Verdict, best
from ..systems.family import Family
from ..systems.structure.enclosure import ball_unknowns, characteristic
from ..systems.structure.identities import certain, symmetric
from ..systems.structure.member import Member, exact_verdict
from ..systems.structure.structural_zeros import structure
from ..systems.structure.zero_blocks import kept_block, proved_power, semisimple, zero_power
from .eigenvalues import (
    BY_ACCIDENT,
    BY_EQUATIONS,
    NO_PROOF_OF_BLOCKS,
    NO_PROOF_OF_ZERO,
    NOT_STEADY,
    in_words,
)
from .problem import Problem

BITS = 128
"""Working precision of the first attempt."""
MOST_BITS = 8192
"""Largest working precision; the verdict is undecided beyond it."""
FINE_BITS = 1024
"""Largest precision for eigenvalues; eigenvalues that still coincide come as clusters."""
WANTED = 58
"""Bits of relative accuracy of each real and imaginary part, before rounding to double."""

Balls = list[Any]


@dataclass(frozen=True)
class Certificate:
    """A proved verdict and enclosures at one point."""

    verdict: Verdict
    """The verdict; undecided where the precision ended or the member is not steady."""
    eigenvalues: tuple[complex, ...]
    """Sorted by real, then imaginary part, in the user's unit of rate; empty if undecided."""
    radius: tuple[float, ...]
    """Radius of the disc about each that holds the exact eigenvalue; 0 where it is exact."""
    abscissa_error: float
    """Proved bound on the error of the largest real part."""
    bits: int
    """Precision of the balls that decided; 0 for rational arithmetic; or a key of `REASONS`."""
    power: int = 0
    """Power of time with which zeros let a disturbance grow, a lower bound; 0 unless drifting."""

    @property
    def how(self) -> str:
        """Arithmetic of the verdict's proof, in words."""
        return in_words(self.bits)


def certify(
    problem: Problem,
    values: Mapping[str, float],
    zeros: int | None = None,
    member: Member | None = None,
) -> Certificate:
    """A proved verdict with eigenvalue enclosures at one point.

    Parameters
    ----------
    problem
        Family with values in the user's units.
    values
        Doubles by name, taken as exact, or as the ratios that the problem has for them.
    zeros
        For a user's family: number of zero eigenvalues to leave out.  If not given: all
        structural ones that are proved zero at this point.
    member
        For a user's family: the member, if known.

    Returns
    -------
    Certificate

    Examples
    --------
    >>> from stability.bodies.contact_laws import Viscous
    >>> from stability.bodies.disk import Disk
    >>> from stability.spectra.problem import disk_problem
    >>> problem = disk_problem("rolling", Disk(k=0.5), Viscous(0.3), 1.0)
    >>> found = certify(problem, problem.values)  # the boundary is omega3² = 1/(2k) = 1
    >>> found.verdict.word, found.how
    ('neutral', 'rational arithmetic')
    """
    if problem.exact is None:
        member = member or member_at(problem, values)
        own = structural_zeros(member)
        zeros = own if zeros is None else zeros
        decided, bits = of_member(member, own)  # other members of a batch may have other counts
        attempt = partial(_member_roots, member, zeros, _exact(problem, values)[2])
    else:
        decided, bits = _decided(problem.exact, problem, values)
        attempt = partial(_roots, problem.exact, problem, values)
    if decided is Verdict.UNDECIDED:
        return Certificate(decided, (), (), np.inf, bits)
    power = 0
    if decided is Verdict.DRIFTING:
        member = member or member_at(problem, values)
        power = zero_power(member, structural_zeros(member)) or 0
    precise = BITS
    while True:
        last = precise >= FINE_BITS
        with precision(precise):
            roots = attempt(last=last)
            if roots is not None and (last or all(map(_sharp, roots))):
                return replace(_rounded(decided, roots, bits), power=power)
        precise *= 2


def verdict(problem: Problem, values: Mapping[str, float], most: int | None = None) -> Verdict:
    """The proved verdict alone.

    Parameters
    ----------
    problem, values, most
        As in `certify`; for a user's family the largest precision of balls.
    """
    if problem.exact is not None:
        return _decided(problem.exact, problem, values)[0]
    member = member_at(problem, values)
    with precision(BITS):  # most are decided without exact numbers
        found = _plainly(problem.family, member.plainly_enclosed)
    if found is Verdict.STABLE:
        found = _with_zeros(member, structure(problem.family).zeros, 0)[0]
    return found or of_member(member, structural_zeros(member), most)[0]


def member_at(
    problem: Problem, values: Mapping[str, float], near: ArrayLike | None = None
) -> Member:
    """The member of a user's family at exact parameters.

    Parameters
    ----------
    problem, values
        As in `certify`.
    near
        Unknowns of the member to double precision, shape (u,); from the family's root-finder
        when left out.

    Returns
    -------
    Member
    """
    family = problem.family
    a, q, _ = _exact(problem, values)
    if near is None:
        rows = [np.array([float(arb(v)) for v in part])[None, :] for part in (a, q)]
        near = family.solve(*rows)[0]
    return Member(family, a, q, np.asarray(near, dtype=float).tolist())


def _exact(problem: Problem, values: Mapping[str, float]) -> tuple[list[Any], list[Any], Any]:
    """Family parameters, parameters and unit of rate: rationals, or balls where irrational."""
    given = problem.rationals(values)
    if "lean" in given:  # π/2 - lean is a ball at best
        given["lean"] = arb(given["lean"])
    with precision(MOST_BITS):
        return problem.reduce(given, nearest_root)


def structural_zeros(member: Member) -> int:
    """Number of structural zero eigenvalues of a member, each proved zero at this member."""
    if certain(member.family):
        return structure(member.family).zeros
    return member.structural[0]


# --- verdicts ---


def _decided(
    exact: ExactPolynomial, problem: Problem, values: Mapping[str, float]
) -> tuple[Verdict, int]:
    """The verdict from an exact polynomial, and the bits of the deciding balls, or 0."""
    given = problem.rationals(values)
    even = problem.family.conservative
    try:
        conditions = exact.conditions(given, EXACT)
        found = _by_conditions(conditions, even) if conditions is not None else None
        if found is None:
            found = on_the_axis([fmpq_poly(c) for c in exact.coefficients(given, EXACT)])
        bits = 0
    except NotExact:
        found, bits = _raised(lambda: _in_balls(exact, given, even))
    if found is not Verdict.STABLE or not problem.may_drift:
        return found, bits
    return _with_zeros(member_at(problem, values), exact.zeros, bits)


def of_member(member: Member, zeros: int, most: int | None = None) -> tuple[Verdict, int]:
    """The verdict of a member without some zero eigenvalues, and the bits that decided it.

    Parameters
    ----------
    member, zeros, most
        The member; the number of zeros, proved, to leave out; the largest precision of balls.

    Returns
    -------
    verdict, bits
        Bits are 0 for rational arithmetic; where there is no proof, a key of `REASONS` may say why.
    """
    if not member.steady:  # a root of the equations that is not a steady motion
        return Verdict.UNDECIDED, NOT_STEADY
    decided, bits = _without(member, zeros, most)
    if decided is Verdict.UNDECIDED and bits == MOST_BITS and member.seems_zero(zeros, MOST_BITS):
        return decided, NO_PROOF_OF_ZERO
    if decided is Verdict.UNSTABLE:
        return decided, bits
    low, high = (zeros, zeros) if certain(member.family) else member.structural
    if zeros == low < high and _without(member, high, most)[0] is not decided:
        return Verdict.UNDECIDED, BY_ACCIDENT  # a zero that is not left out may be structural
    return _with_zeros(member, zeros, bits) if decided is Verdict.STABLE else (decided, bits)


def _with_zeros(member: Member, zeros: int, bits: int) -> tuple[Verdict, int]:
    """The verdict of a member whose other eigenvalues all have negative real parts."""
    power = zero_power(member, zeros)
    if power is None:
        return Verdict.UNDECIDED, NO_PROOF_OF_BLOCKS
    return Verdict.DRIFTING if power else Verdict.STABLE, bits


def _without(member: Member, zeros: int, most: int | None) -> tuple[Verdict, int]:
    if member.rational is not None:
        if any(c != 0 for c in member.rational[:zeros]):  # these zeros are not proved
            return Verdict.UNDECIDED, NO_PROOF_OF_ZERO
        return on_the_axis([fmpq_poly(member.rational[zeros:])]), 0
    exactly = partial(exact_verdict, member, zeros)
    return _raised(lambda: _enclosed_verdict(member.enclosed()[zeros:]), exactly, most)


def _enclosed_verdict(polynomial: Balls) -> Verdict | None:
    """The verdict by Routh's array, or by the roots where the array meets a zero.

    A ball equals 0 only as the exact zero; a wider ball around 0 is neither equal nor unequal.
    """
    if not all(c.is_finite() for c in polynomial):
        return None
    extra = next(i for i, c in enumerate(polynomial) if not c == 0)
    rest = polynomial[extra:]
    if len(rest) == 1:
        return Verdict.NEUTRAL
    even = len(rest) % 2 == 1 and all(c == 0 for c in rest[1::2])
    sign = hurwitz_sign(verdict_polynomial(rest, 0, even))
    if sign == 0:
        sign = _sign_by_roots(isolated(rest, even))
    if sign == 0 and ctx.prec <= FINE_BITS:  # a ball of a cluster holds all roots of the cluster
        sign = _sign_by_roots(clustered(rest))
    if sign > 0:
        return Verdict.NEUTRAL if even or extra else Verdict.STABLE
    return Verdict.UNSTABLE if sign else None


def _sign_by_roots(roots: Balls | None) -> int:
    if roots is not None and any(r.real > 0 for r in roots):
        return -1
    return int(roots is not None and all(r.real < 0 for r in roots))


def _raised(
    attempt: Callable[[], Any], exactly: Any = lambda: None, most: int | None = None
) -> tuple[Verdict, int]:
    bits = BITS
    while bits <= (most or MOST_BITS):
        with precision(bits):
            found = attempt()
        if found is not None:
            return found, bits
        if bits == FINE_BITS and (found := exactly()) is not None:
            return found, BY_EQUATIONS
        bits *= 2
    return Verdict.UNDECIDED, MOST_BITS


def _in_balls(exact: ExactPolynomial, given: Mapping[str, Any], even: bool) -> Verdict | None:
    conditions = exact.conditions(given, MIXED)
    if conditions is not None:
        return _by_conditions(conditions, even)
    return _enclosed_verdict(product(exact.coefficients(given, MIXED)))


def _by_conditions(conditions: Sequence[tuple[str, Any]], even: bool) -> Verdict | None:
    if any(v < 0 for _, v in conditions):
        return Verdict.UNSTABLE
    return best(even=even) if all(v > 0 for _, v in conditions) else None


def in_balls(family: Family, a: Balls, q: Balls) -> Verdict | None:
    """The verdict for all parameters in balls, by Routh's array at the current precision.

    Returns
    -------
    Verdict or None
        None where the balls do not decide.

    Raises
    ------
    NoMemberError
        If no root is proved to exist there.
    """
    found = _plainly(family, lambda: characteristic(family, a, q))
    zeros = structure(family).zeros
    if found is not Verdict.STABLE or semisimple(family, zeros):
        return found
    place = [list(a), ball_unknowns(family, a, q), list(q)]
    matrix = family.graph.matrix.dense(balls(), place)
    drifts = proved_power(kept_block(family, matrix), zeros - len(family.left_out)) > 0
    return Verdict.DRIFTING if drifts else None


def _plainly(family: Family, coefficients: Callable[[], Balls | None]) -> Verdict | None:
    if not certain(family):
        return None  # the number of zeros is proved for single members only
    found = coefficients()
    if found is None:
        return None
    even = family.conservative or symmetric(family)
    sign = hurwitz_sign(verdict_polynomial(found, structure(family).zeros, even))
    return {1: best(even=even), -1: Verdict.UNSTABLE}.get(sign)


# --- enclosures ---


def _roots(
    exact: ExactPolynomial, problem: Problem, values: Mapping[str, float], *, last: bool
) -> Balls | None:
    """Every eigenvalue that is not zero by structure, as a complex ball; None if not isolated."""
    given = problem.rationals(values)
    scale, square = exact.scale(given)
    unit = arb(square).sqrt() if scale is None else arb(scale)
    out: Balls = []
    try:
        for factor in exact.coefficients(given, EXACT):
            out += bounded_roots(fmpq_poly(factor))
    except NotExact:
        for factor in exact.coefficients(given, MIXED):
            found = _ball_roots(factor, problem.family.conservative, last=last)
            if found is None:
                return None
            out += found
    return [root * unit for root in out]


def _ball_roots(coefficients: Sequence[Any], even: bool, *, last: bool) -> Balls | None:
    found = isolated(list(coefficients), even)
    if found is None and last:
        lead = arb(coefficients[-1])
        found = clustered([arb(c) / lead for c in coefficients[:-1]] + [arb(1)])
    return found


def _member_roots(member: Member, zeros: int, unit: Any, *, last: bool) -> Balls | None:
    """As `_roots`, from the graph; at the last precision, clusters where roots coincide."""
    found = _of_graph(member, zeros, last=last)
    return found if found is None or unit == 1 else [root * arb(unit) for root in found]


def _of_graph(member: Member, zeros: int, *, last: bool) -> Balls | None:
    if member.rational is not None:
        return bounded_roots(fmpq_poly(member.rational[zeros:]))
    polynomial = member.enclosed()[zeros:]
    extra = next(i for i, c in enumerate(polynomial) if not c == 0)
    rest = polynomial[extra:]
    even = len(rest) % 2 == 1 and all(c == 0 for c in rest[1::2])
    found = _ball_roots(rest, even, last=last) if len(rest) > 1 else []
    return None if found is None else [acb(0)] * extra + found


def _sharp(root: Any) -> bool:
    return all(part == 0 or part.rel_accuracy_bits() >= WANTED for part in (root.real, root.imag))


def _rounded(decided: Verdict, roots: Balls, bits: int) -> Certificate:
    """A certificate in doubles, with bounds on the distance to the exact eigenvalues."""
    entries = []
    for root in roots:
        value = complex(float(root.real.mid()), float(root.imag.mid()))
        off = abs(root - acb(value.real, value.imag))
        entries.append((value.real + 0.0, value.imag + 0.0, upper(off), root))
    entries.sort(key=lambda entry: entry[:2])
    # in balls: real parts of several eigenvalues may round to one double
    beyond = [root.real - arb(max(entry[0] for entry in entries)) for root in roots]
    high = max(upper(b) if b > 0 or b.contains(0) else 0.0 for b in beyond)
    low = min(upper(-b) if b < 0 or b.contains(0) else 0.0 for b in beyond)
    return Certificate(
        decided,
        tuple(complex(e[0], e[1]) for e in entries),
        tuple(e[2] for e in entries),
        max(high, low),
        bits,
    )
