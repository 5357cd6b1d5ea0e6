"""Proved verdicts and eigenvalue enclosures, in rational arithmetic where possible or in balls.

The verdict comes from the first route of `verdict_routes` that has a proof.  Enclosures start from
the same numbers: from the polynomial of the body or the family where it is known, otherwise from
the graph at the member.  A lean of exactly zero is the right angle.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from flint import acb, arb, fmpq_poly

from ..algebra.exact.number_fields import EXACT, NotExact
from ..algebra.exact.roots import bounded_roots, clustered, isolated
from ..algebra.exact.routh import is_even, monic
from ..algebra.number_types import MIXED, balls, precision, upper
from ..algebra.polynomial import ExactPolynomial
from ..base.types import Complexes, Floats
from ..base.verdict import Verdict
from ..polynomials.identities import certain
from ..polynomials.member import Member
from ..polynomials.zero_blocks import kept_block, proved_power, semisimple
from ..systems.family import Family
from ..systems.structure.enclosure import ball_unknowns, characteristic
from ..systems.structure.structural_zeros import structure
from .problem import Problem
from .verdict_routes import (
    BITS,
    BLOCKS,
    FINE_BITS,
    Point,
    Proof,
    by_routh,
    exact_numbers,
    in_words,
    proved,
)

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
    >>> certificate = certify(problem, problem.values)  # the boundary is omega3² = 1/(2k) = 1
    >>> certificate.verdict.word, certificate.how
    ('neutral', 'rational arithmetic')
    """
    point = Point(problem, values, member)
    proof = proved(point)
    if proof.verdict is Verdict.UNDECIDED:
        return Certificate(proof.verdict, (), (), np.inf, proof.bits)
    power = 0
    if proof.verdict is Verdict.DRIFTING:
        power = point.power or 0
    left_out = point.zeros if zeros is None else zeros
    blocks = point.blocks if proof.bits == BLOCKS and left_out == point.zeros else None
    if blocks is not None and np.isfinite(blocks.radius).all():
        return _of_discs(proof, blocks.values, blocks.radius, power)
    if problem.exact is not None:
        attempt = partial(_roots, problem.exact, problem, values)
    else:  # other members of a batch may have other counts of zeros
        attempt = partial(_member_roots, point.member, left_out, exact_numbers(problem, values)[2])
    precise = BITS
    while True:
        last = precise >= FINE_BITS
        with precision(precise):
            roots = attempt(last=last)
            if roots is not None and (last or all(map(_sharp, roots))):
                return replace(_rounded(proof, roots), power=power)
        precise *= 2


def verdict(problem: Problem, values: Mapping[str, float], most: int | None = None) -> Verdict:
    """The proved verdict alone.

    Parameters
    ----------
    problem, values, most
        As in `certify`; for a user's family the largest precision of balls.
    """
    return proved(Point(problem, values, most=most, alone=True)).verdict


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
    if not certain(family):
        return None  # the number of zeros is proved for single members only
    zeros = structure(family).zeros
    verdict = by_routh(family, characteristic(family, a, q), zeros)
    if verdict is not Verdict.STABLE or semisimple(family, zeros):
        return verdict
    place = [list(a), ball_unknowns(family, a, q), list(q)]
    matrix = family.graph.matrix.dense(balls(), place)
    drifts = proved_power(kept_block(family, matrix), zeros - len(family.idle)) > 0
    return Verdict.DRIFTING if drifts else None


# --- enclosures ---


def _roots(
    exact: ExactPolynomial, problem: Problem, values: Mapping[str, float], *, last: bool
) -> Balls | None:
    """Every eigenvalue that is not zero by structure, as a complex ball; None if not isolated."""
    rationals = problem.rationals(values)
    scale, square = exact.scale(rationals)
    unit = arb(square).sqrt() if scale is None else arb(scale)
    out: Balls = []
    try:
        for factor in exact.coefficients(rationals, EXACT):
            out += bounded_roots(fmpq_poly(factor))
    except NotExact:
        for factor in exact.coefficients(rationals, MIXED):
            roots = _ball_roots(factor, problem.family.conservative, last=last)
            if roots is None:
                return None
            out += roots
    return [root * unit for root in out]


def _ball_roots(coefficients: Sequence[Any], even: bool, *, last: bool) -> Balls | None:
    roots = isolated(list(coefficients), even)
    if roots is None and last:
        roots = clustered(monic(coefficients))
    return roots


def _member_roots(member: Member, zeros: int, unit: Any, *, last: bool) -> Balls | None:
    """As `_roots`, from the graph; at the last precision, clusters where roots coincide."""
    roots: Balls | None
    if member.rational is not None:
        roots = bounded_roots(fmpq_poly(member.rational[zeros:]))
    else:
        polynomial = member.enclosed()[zeros:]
        extra = next(i for i, c in enumerate(polynomial) if not c == 0)
        rest = polynomial[extra:]
        roots = _ball_roots(rest, is_even(rest), last=last) if len(rest) > 1 else []
        roots = None if roots is None else [acb(0)] * extra + roots
    return roots if roots is None or unit == 1 else [root * arb(unit) for root in roots]


def _sharp(root: Any) -> bool:
    return all(part == 0 or part.rel_accuracy_bits() >= WANTED for part in (root.real, root.imag))


def _of_discs(proof: Proof, values: Complexes, radius: Floats, power: int) -> Certificate:
    """A certificate from discs in doubles."""
    order = np.lexsort((values.imag, values.real))
    values, radius = values[order] + 0.0, radius[order]
    error = float((radius + (values.real - values.real.max())).max())
    return Certificate(
        proof.verdict, tuple(values.tolist()), tuple(radius.tolist()), error, proof.bits, power
    )


def _rounded(proof: Proof, roots: Balls) -> Certificate:
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
        proof.verdict,
        tuple(complex(e[0], e[1]) for e in entries),
        tuple(e[2] for e in entries),
        max(high, low),
        proof.bits,
    )
