"""Members whose verdict is a matter of polynomials in one variable: the axis, or its sine.

For the disk these are the conditions over Q of `stability.bodies.disk_polynomials`, where every
quantity but the axis is the exact ratio of its double.  For any other family that is rational in
the axis they come from its characteristic polynomial.  One exact verdict holds on each piece
between neighbouring roots.

Values found include single values, where the verdict differs from that on both sides.  Where an
eigenvalue reaches the imaginary axis while others keep the motion unstable, the verdict stays.
Where all unstable eigenvalues reach the axis together, as for undamped motions between damping and
driving, the member is neutral there and unstable on both sides.

Source: Orlando's formula (F. R. Gantmacher, The Theory of Matrices, vol. 2, ch. XV § 7) for the
Hurwitz determinant; tests/boundary/test_single_points.py; tests/boundary/test_boundaries.py counts
the roots by another route.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cache
from typing import Any

from flint import arb, arb_poly, fmpq_poly

from ...algebra.exact.function_field import Expression, FunctionField, counted, evaluate
from ...algebra.exact.hurwitz_forms import (
    coefficient_row,
    factors,
    hurwitz_determinants,
    subdiscriminants,
)
from ...algebra.exact.number_fields import EXACT, NotExact, rational
from ...algebra.exact.rational_functions import (
    RING,
    common_multiple,
    multivariate,
    primitive,
    univariate,
)
from ...algebra.exact.roots import BITS, MOST_BITS, sign_at
from ...algebra.exact.routh import is_even, least_sign, on_the_axis, unstable_roots
from ...algebra.number_types import MIXED, Algebra, precision
from ...algebra.polynomial import ExactPolynomial, TabulatedPolynomial
from ...base.errors import StabilityError
from ...base.verdict import Verdict
from ...spectra.certificate import verdict as certified
from ...spectra.verdict_routes import BITS as MEMBER_BITS
from ...spectra.verdict_routes import Point, decided
from ...systems.structure.structural_zeros import structure
from ..brackets import AxisScan
from ..pairs import crossing, grows, meeting, unstable_count
from .candidates import Candidate, Candidates, Watched, critical, in_base
from .members import FINE_BITS, NEAR, SHARES, AxisMembers, AxisVerdict, CandidateCell, growing
from .tower import AxisPolynomial, Base

POSITIVE = ("k", "mu", "c", "mass", "radius", "gravity")
"""Axes of the disk that are positive."""
SHORT = (8, 24)
"""Bits that are tried for a value between two roots."""
GUARD = 64
"""Bits beyond those of a root at which conditions are evaluated there."""
UPRIGHT = RING.gens()[0] - 1
"""It vanishes where a sine or cosine is 1."""
Row = list[Any]
"""Coefficients of a factor by powers of λ, lowest first: `fmpq_poly` in the variable."""


class StoredConditions:
    """Stored conditions: all positive, or some negative.

    Parameters
    ----------
    polynomials
        (kind, polynomial in x and perhaps s).
    sine
        Function that gives s at the working precision; None where there is no s.
    """

    def __init__(
        self, polynomials: Sequence[tuple[str, Any]], sine: Callable[[], Any] | None
    ) -> None:
        self.polynomials, self.sine = list(polynomials), sine

    def watched(self) -> list[tuple[str, Any]]:
        """(kind, polynomial) of what can vanish where the verdict changes."""
        return [(k, p) for k, p in self.polynomials if not p.derivative(0).is_zero()]

    def sign(self, x: Any) -> int:
        """1 stable or neutral, -1 unstable, 0 on a boundary; at a rational value."""
        return least_sign([sign_at(p, x, self.sine) for _, p in self.polynomials])

    def negative(self, x: Any) -> bool:
        """Whether some condition is proved negative in a ball of the variable."""
        sine = self.sine() if self.sine is not None else arb(0)
        return any(
            sum((arb(c) * x ** int(i) * sine ** int(j) for (i, j), c in p.terms()), arb(0)) < 0
            for _, p in self.polynomials
        )


class FactoredPolynomial:
    """A characteristic polynomial in factors, and the poles of the linearisation.

    Parameters
    ----------
    rows
        The factors other than λ, irreducible.
    powers
        Power of each.
    poles
        Polynomials at whose zeros there is no linearisation, or an eigenvalue is infinite.
    """

    sine = None

    def __init__(self, rows: Sequence[Row], powers: Sequence[int], poles: Sequence[Any]) -> None:
        self.rows, self.powers, self.poles = rows, powers, poles
        self.even = [is_even(row) for row in rows]

    def watched(self) -> list[tuple[str, Any]]:
        """(kind, polynomial) of what can vanish where the verdict changes."""
        conditions = [("pole", multivariate(p)) for p in self.poles]
        for row in self.rows:
            conditions += critical(
                [multivariate(c) for c in row], _pair_resultant, _meeting_discriminant
            )
        return [(kind, p) for kind, p in conditions if not p.is_constant()]

    def verdict(self, x: Any) -> Verdict:
        """The verdict at a rational value; zeros by structure do not count."""
        return on_the_axis([fmpq_poly([c(x) for c in row]) for row in self.rows])

    def unstable(self, x: Any) -> list[int]:
        """Number of unstable eigenvalues of each factor at a rational value."""
        return [
            power * unstable_roots(fmpq_poly([c(x) for c in row]))
            for row, power in zip(self.rows, self.powers, strict=True)
        ]

    def at(self, root: Any) -> list[list[Any]]:
        """The factors at a ball of the variable."""
        return [[arb_poly(c)(root) for c in row] for row in self.rows]

    def sign(self, x: Any) -> int:
        """1 stable or neutral, -1 unstable."""
        return -1 if self.verdict(x) is Verdict.UNSTABLE else 1

    def frequency(self, x: Any) -> float:
        """|Im λ| of the pair that meets the axis, or of two that meet on it, next to a rational."""
        pairs: list[tuple[float, float]] = []
        for row, even in zip(self.rows, self.even, strict=True):
            p = fmpq_poly([c(x) for c in row])
            pairs += meeting(fmpq_poly(p.coeffs()[::2])) if even else crossing(p)
        return min(pairs, default=(math.inf, 0.0))[1]


class SineFactors:
    """As `FactoredPolynomial`, with polynomials in x and a transcendental sine s; for counts."""

    def __init__(
        self,
        rows: Sequence[Row],
        powers: Sequence[int],
        poles: Sequence[Any],
        sine: Callable[[], Any],
    ) -> None:
        self.rows, self.powers, self.poles, self.sine = rows, powers, poles, sine
        self.even = [is_even(row) for row in rows]

    def watched(self) -> list[tuple[str, Any]]:
        """(kind, polynomial) of what can vanish where a number changes."""
        budget = counted()
        conditions = [("pole", p) for p in self.poles]
        for row in self.rows:
            conditions += critical(
                row,
                lambda a: hurwitz_determinants(a, budget)[-1],
                lambda q: subdiscriminants(q, budget)[-1],
            )
        return [(kind, p) for kind, p in conditions if not p.derivative(0).is_zero()]

    def at(self, root: Any) -> list[list[Any]]:
        """The factors at a ball of the variable."""
        place = {0: root, 1: self.sine()}
        return [[arb(evaluate(c, place)) for c in row] for row in self.rows]

    def unstable(self, x: Any) -> list[int] | None:
        """As `Factors.unstable`, in balls; None without a proof."""
        bits = BITS
        while bits <= MOST_BITS:
            with precision(bits):
                rows = zip(self.at(arb(x)), self.even, strict=True)
                counts = [unstable_count(row, even=even) for row, even in rows]
            if None not in counts:
                return [n * (c or 0) for n, c in zip(self.powers, counts, strict=True)]
            bits *= 2
        return None

    def sign(self, x: Any) -> int:
        """1 stable or neutral, -1 unstable; 0 without a proof."""
        counts = self.unstable(x)
        return 0 if counts is None else -1 if any(counts) else 1


def _pair_resultant(a: Sequence[Any]) -> Any:
    return _in_s(a[::2]).resultant(_in_s(a[1::2]), 1)


def _meeting_discriminant(q: Sequence[Any]) -> Any:
    return _in_s(q).discriminant(1)


def _in_s(coefficients: Sequence[Any]) -> Any:
    s = RING.gens()[1]
    return sum((c * s**k for k, c in enumerate(coefficients)), RING.constant(0))


class OneVariable(AxisMembers):
    """Members whose verdict follows from polynomials in the axis, or in the sine of it.

    Parameters
    ----------
    line
        The line.
    source
        The polynomials.
    base
        The axis as a function of their variable.
    ends
        Ends of the interval; None for no end.
    dissipative
        Whether the good verdict is stable.
    edge
        Whether the upright position, where families meet, may be a single value.
    bits
        Working precision of the first attempt.
    """

    exact = True
    how = "every real root of every condition that decides the verdict was isolated exactly"

    def __init__(
        self,
        line: AxisScan,
        source: StoredConditions | FactoredPolynomial | SineFactors,
        base: Base,
        ends: tuple[float | None, float | None],
        *,
        dissipative: bool,
        edge: bool = False,
        bits: int = BITS,
    ) -> None:
        self.line, self.source, self.dissipative = line, source, dissipative
        self.even = [] if isinstance(source, StoredConditions) else source.even
        self._sign = cache(source.sign)  # of an inclination two pieces may share their sine
        if line.problem.family.exact:
            self.how += ", from the family's polynomial"
        conditions = [*_apart(source.watched(), turned=base.turned)]
        conditions += [("edge", UPRIGHT)] if edge else []
        norms = ((p, Watched(kind, p, p)) for kind, p in conditions)
        self.candidates = Candidates(base, source.sine, norms, ends, bits)
        none = line.axis == "phi_dot" and not line.problem.plain
        low, high = ends
        around = (low is None or low <= 0) and (high is None or high >= 0)
        self.missing = [0.0] if none and around else []
        """Values at which there is no member."""

    def cell(self, low: Any, high: Any) -> CandidateCell:
        """The exact verdict at a rational between two neighbouring candidates."""
        base = self.candidates.base
        with precision(self.candidates.bits):
            first, width = low.upper(), high.lower() - low.upper()
            for share in SHARES:
                middle = base.variable(first + width * share).mid()
                for bits in (*SHORT, self.candidates.bits):
                    with precision(bits):
                        z = (+middle).mid()
                    if any(low < x < high for x in base.back(z, low, high)):
                        sign = self._sign(z.fmpq())
                        if sign:
                            return CandidateCell(
                                low, high, math.nan, AxisVerdict(sign, (), ""), sample=z.fmpq()
                            )
                        break
        return CandidateCell(low, high, math.nan, AxisVerdict(0, None, NEAR))

    def unstable_in(self, cell: CandidateCell) -> list[int] | None:
        """Counted over Q."""
        if cell.sample is None or isinstance(self.source, StoredConditions):
            return None
        return self.source.unstable(cell.sample)

    def holds(self, value: float, cell: CandidateCell) -> bool:  # noqa: ARG002
        """There is one member at every number."""
        return True

    def factors_at(self, candidate: Candidate) -> list[tuple[list[Any], int]]:
        """Factors in balls at a candidate, each with its power."""
        assert not isinstance(self.source, StoredConditions)
        root = self.candidates.base.variable(self.candidates.refined(candidate, FINE_BITS))
        with precision(FINE_BITS):
            return list(zip(self.source.at(root), self.source.powers, strict=True))

    def vanishing(self, candidate: Candidate) -> list[Watched]:
        """Every watched polynomial is its own norm."""
        return list(candidate.watched)

    def joined(self, candidate: Candidate, below: CandidateCell, above: CandidateCell) -> bool:  # noqa: ARG002
        """The members are a function of the axis."""
        return True

    def meets(
        self,
        candidate: Candidate,  # noqa: ARG002
        kept: list[Watched],  # noqa: ARG002
        below: CandidateCell,  # noqa: ARG002
        above: CandidateCell,  # noqa: ARG002
    ) -> bool:
        """Every watched polynomial is its own norm."""
        return True

    def unstable(self, candidate: Candidate) -> bool | None:
        """Whether the member at a candidate is unstable; None where this is not proved."""
        source = self.source
        assert not isinstance(source, SineFactors)
        with precision(max(BITS, min(candidate.root.rel_accuracy_bits(), MOST_BITS)) + GUARD):
            if isinstance(source, FactoredPolynomial):
                return self._grows(source, candidate)
            if source.negative(candidate.root):
                return True
        # no condition is proved negative; omitted ones follow only where the others are positive
        place = self.line.fixed | {self.line.axis: float(candidate.value.mid())}
        return False if certified(self.line.problem, place) is Verdict.NEUTRAL else None

    @staticmethod
    def _grows(source: FactoredPolynomial, candidate: Candidate) -> bool | None:
        balls = source.at(candidate.root)
        if any(map(grows, balls)):
            return True
        norm = next(
            p
            for p, _ in univariate(candidate.norm).factor()[1]
            if arb_poly(p)(candidate.root).contains(0)
        )
        if norm.degree() == 1:
            said = source.verdict(-norm[0] / norm[1])
            return None if said is Verdict.STABLE else said is Verdict.UNSTABLE
        growth = [
            growing(row, b, lambda c: (c % norm).is_zero())
            for row, b in zip(source.rows, balls, strict=True)
        ]
        return True if True in growth else None if None in growth else False

    def sign(self, value: float, cell: CandidateCell) -> int:  # noqa: ARG002
        """The proved verdict at a double: from the graph, by Routh's array or over Q."""
        if self.line.problem.exact is None:
            return self._exactly(value)
        if isinstance(
            self.source, FactoredPolynomial
        ):  # balls see no eigenvalue that stays on the axis
            return self._exactly(value) or self._by_graph(value)
        return self._by_graph(value) or self._exactly(value)

    def _exactly(self, value: float) -> int:
        if isinstance(self.source, StoredConditions):
            proof = decided(Point(self.line.problem, self.line.fixed | {self.line.axis: value}))
            return self.line.sign_of(proof.verdict, proof.nearby)
        return 0 if self.candidates.base.turned else self.source.sign(rational(value))

    def _by_graph(self, value: float) -> int:
        try:
            return self.line.sign(value)
        except StabilityError:  # outside the range of the body's values
            return 0

    def rate(self, candidate: Candidate, root: float) -> float:
        """|Im λ| of the pair that meets the imaginary axis at a candidate."""
        if self.line.problem.exact is None:
            assert isinstance(self.source, FactoredPolynomial)
            with precision(MEMBER_BITS):  # more digits than a double needs slow the roots down
                return self.source.frequency((candidate.root * 1).mid().fmpq())
        return super().rate(candidate, root)


def _apart(conditions: list[tuple[str, Any]], *, turned: bool) -> Iterator[tuple[str, Any]]:
    """Polynomials without a common or multiple root; a pole, then a zero eigenvalue names it."""
    earlier = [UPRIGHT] if turned else []
    for kind, p in sorted(conditions, key=lambda w: ("pole", "static", w[0]).index(w[0])):
        rest = p / p.gcd(p.derivative(0))
        for other in earlier:
            rest = rest / rest.gcd(other)
        if not rest.derivative(0).is_zero():
            earlier.append(rest)
            yield kind, rest


def of_family(
    line: AxisScan,
    polynomial: AxisPolynomial,
    ends: tuple[float | None, float | None],
    bits: int = BITS,
) -> OneVariable:
    """The members of a family that is rational in the axis."""
    form, problem = polynomial.factored, line.problem
    rows = [[univariate(c) for c in row] for row, _ in form.factors]
    powers = [power for _, power in form.factors]
    source = FactoredPolynomial(rows, powers, [univariate(p) for p in form.nonzero])
    zeros = structure(problem.family).zeros  # refuses what is declared conservative and is not
    base = Base("positive" if not problem.plain and line.axis in POSITIVE else "plain")
    good = form.zeros <= zeros and not any(source.even)
    return OneVariable(line, source, base, ends, dissipative=good, bits=bits)


def of_exact(
    line: AxisScan,
    exact: ExactPolynomial,
    ends: tuple[float | None, float | None],
    bits: int = BITS,
    *,
    every: bool = False,
) -> OneVariable:
    """The members of a family with a polynomial of its own, stored or stated.

    With `every` the polynomial itself is searched, where conditions say less.

    Raises
    ------
    NotExact
        If the polynomial is not rational in the axis, or in its sine.
    """
    problem, axis = line.problem, line.axis
    field = FunctionField(("x", "s"), spare=0)
    axes = problem.rationals(line.fixed) | {axis: field.symbols[0]}
    angle, edge, over, sine = "", False, EXACT, None
    if isinstance(exact, TabulatedPolynomial):
        angle, edge = exact.angle(axis), exact.borders
        over, sine = _tabulated(exact, axes, angle, field)
    base = Base(angle or ("positive" if not problem.plain and axis in POSITIVE else "plain"))
    conditions = None if every else exact.conditions(axes, over)
    if conditions is not None:
        # of the same sign, since a denominator is a power of a positive axis
        quotients = [(kind, _quotient(field, p)) for kind, p in conditions]
        cleared = [(kind, q.num * q.den) for kind, q in quotients]
        if all(not p.is_zero() for _, p in cleared):
            good, edge = not problem.family.conservative, edge and bool(angle)
            source = StoredConditions(cleared, sine)
            return OneVariable(line, source, base, ends, dissipative=good, edge=edge, bits=bits)
    # with `every`, or where a condition vanishes all along the axis: the polynomial is searched
    source_ = _itself(exact, problem.rationals(line.fixed), axis, angle)
    return OneVariable(line, source_, base, ends, dissipative=not any(source_.even), bits=bits)


def _itself(
    exact: ExactPolynomial, fixed: Mapping[str, Any], axis: str, angle: str
) -> FactoredPolynomial | SineFactors:
    """The polynomial in factors, where conditions say less."""
    field = FunctionField(("x", "s", "λ"), spare=0)
    axes = {**fixed, axis: field.symbols[0]}
    over, sine, lam = EXACT, None, field.symbols[2].num
    if isinstance(exact, TabulatedPolynomial):
        over, sine = _tabulated(exact, axes, angle, field)
    rows: list[Row] = []
    powers: list[int] = []
    poles: list[Any] = []
    for factor in exact.coefficients(axes, over):
        quotients = [_quotient(field, c) for c in factor]
        common = common_multiple((q.den for q in quotients), field.one)
        if not isinstance(exact, TabulatedPolynomial):  # whose axes there are positive
            poles.append(common)
        row = primitive([q.num * (common / q.den) for q in quotients])
        whole = sum((c * lam**k for k, c in enumerate(row)), field.ring.constant(0))
        for p, power in factors(whole)[1]:
            if p != lam and len(row := coefficient_row(p, 2)) > 1:
                rows.append(row)
                powers.append(power)
    poles += [row[-1] for row in rows]
    if sine is not None:
        flat = [[in_base(c) for c in row] for row in rows]
        return SineFactors(flat, powers, [in_base(p) for p in poles], sine)
    plain = [[univariate(c) for c in row] for row in rows]
    return FactoredPolynomial(plain, powers, [univariate(p) for p in poles])


def _tabulated(
    exact: TabulatedPolynomial, axes: Mapping[str, Any], angle: str, field: FunctionField
) -> tuple[Algebra, Callable[[], Any] | None]:
    """Sines along an axis: the variable itself for an angle; otherwise exact, or s in balls."""

    def sines(value: Any) -> Algebra:
        return Algebra("sines", EXACT.constant, dict.fromkeys(("sin", "cos"), lambda _: value))

    x, s = field.symbols[:2]
    if angle:
        return sines(x), None
    try:
        exact.point(axes, EXACT)
    except NotExact:
        return sines(s), lambda: exact.sine(axes, MIXED)
    return EXACT, None


def _quotient(field: FunctionField, value: Any) -> Expression:
    return value if isinstance(value, Expression) else field.number(value)
