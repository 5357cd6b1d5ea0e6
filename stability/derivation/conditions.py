"""`conditions`: exact conditions of stability for any family, with the proof of each sign.

Numbers are taken as they are, or doubles are read as the decimals that were written.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from fractions import Fraction
from functools import cached_property
from typing import Any

import numpy as np
from flint import arb, fmpq, fmpq_poly
from numpy.typing import ArrayLike

from ..algebra.exact.hurwitz_forms import Budget, TooLarge
from ..algebra.exact.number_fields import NotExact, rational
from ..algebra.exact.routh import hurwitz_sign, on_the_axis, verdict_polynomial
from ..algebra.number_types import precision
from ..algebra.polynomial import Polynomial
from ..base.checks import flag, instance, known, one_number, whole_number
from ..base.checks import positive as above_zero
from ..base.citation import cited
from ..base.errors import ParameterError, StabilityError, shown
from ..base.exact_numbers import decimal_of, double, exact_ratio, written
from ..base.types import Record, fields_of
from ..base.verdict import Verdict, best
from ..bodies.contact_laws import Contact
from ..bodies.disk import Disk
from ..bodies.round_body.body import Body
from ..bodies.subject import family_by_name
from ..polynomials.characteristic import CharacteristicPolynomial
from ..polynomials.member import Member
from ..polynomials.zero_blocks import semisimple, typical, zero_power
from ..systems.family import A_FAMILY, Family, refuse_system
from ..systems.graph.family_graph import FamilyGraph
from ..systems.structure.structural_zeros import steady_where, structure
from .deduction import Deduction, closed_forms, domain_of, sloped_somewhere


@dataclass(frozen=True)
class ConditionVariable:
    """A variable of the polynomials."""

    name: str
    """Name as it occurs in a polynomial: `v`, `sin(theta)`, `sqrt(b)`."""
    kind: str
    """Kind: parameter, state, unknown, sine, cosine, root or function."""
    meaning: str
    """What it is, in words."""


@dataclass(frozen=True)
class Factor:
    """A factor of the characteristic polynomial, irreducible over Q."""

    coefficients: tuple[Polynomial, ...]
    """Coefficients by powers of λ, lowest first."""
    even: bool
    """Whether only even powers of λ occur: its roots come in pairs ±λ."""
    multiplicity: int
    """How often it occurs."""

    @property
    def degree(self) -> int:
        """Degree in λ."""
        return len(self.coefficients) - 1


@dataclass(frozen=True)
class Witness:
    """A member at which the sign of a condition is proved."""

    point: Mapping[str, Fraction]
    """Family parameters and parameters, exactly."""
    sign: int
    """1 or -1."""


@dataclass(frozen=True)
class SignCondition:
    """A polynomial that is positive wherever a factor has all its roots in the left half-plane."""

    name: str
    """What it is, such as `constant term` or `Hurwitz determinant 3`."""
    factor: int
    """Index of the factor of the characteristic polynomial."""
    kind: str
    """What happens where it vanishes: static (an eigenvalue is 0), flutter (a pair on the
    imaginary axis, or two pairs that meet there), or auxiliary."""
    status: str
    """positive or negative (proved in the whole domain), follows (from another condition),
    changes (both signs occur at members), open (neither is proved), or zero (identically)."""
    polynomial: Polynomial
    """The polynomial, without factors of proved sign."""
    whole: Polynomial
    """The polynomial with all its factors."""
    proof: str
    """Proof of the status, or of the signs of the factors that are left out."""
    witnesses: tuple[Witness, ...] = ()
    """Members with proved signs; one of each sign where the status is `changes`."""

    @property
    def decides(self) -> bool:
        """Whether the verdict depends on its sign."""
        return self.status in ("changes", "open", "zero", "negative")

    @property
    def doubt(self) -> str:
        """A sentence on a sign that is open: what would have to be proved."""
        where = "anywhere" if any(w.sign < 0 for w in self.witnesses) else "everywhere"
        return f"It is open whether {self.polynomial} > 0 {where}."


AS_DOUBLES = (
    "Numbers such as {decimal} are taken as their nearest doubles, exactly ({double}); with "
    "decimals=True (--decimals) as they are written."
)
AS_DECIMALS = (
    "Read as decimals, as written: {listed}.  The conditions hold for the model with these "
    "decimals; `spectrum`, `boundaries` and maps take the nearest doubles."
)
KEPT = (
    "Exact doubles still, since they are no decimals of at most 15 digits (CasADi may have joined "
    "them): {listed}."
)
"""Statements on the numbers of a result."""
MOST_LISTED = 12
"""Decimals that a statement lists."""


@dataclass(frozen=True, eq=False, repr=False)
class DecimalFamily(Family):
    """A family in whose graph each double next to a short decimal is the decimal, exactly."""

    @cached_property
    def graph(self) -> FamilyGraph:
        """The system's graph with decimals."""
        return FamilyGraph(self._frame(decimals=True))


def _exactly(value: Fraction) -> Any:
    return fmpq(value.numerator, value.denominator)


@dataclass(frozen=True)
class NumberReading:
    """How numbers are read: fractions exactly, doubles exactly or as decimals."""

    decimals: bool = False
    """Whether a double that is the nearest one to a short decimal is read as the decimal."""

    def family(self, family: Family) -> Family:
        """The family whose graph has these numbers."""
        if not self.decimals:
            return family
        return DecimalFamily(**{f.name: getattr(family, f.name) for f in fields(family)})

    def ratio(self, value: float) -> Any:
        """A double as a rational.

        Examples
        --------
        >>> NumberReading(decimals=True).ratio(9.81), NumberReading().ratio(0.375)
        (981/100, 3/8)
        """
        short = decimal_of(value) if self.decimals else None
        return rational(value) if short is None else _exactly(short)

    def rational(self, name: str, value: Any) -> Any:
        """A number that a user gives as a rational, or a refusal.

        Parameters
        ----------
        name
            Name of the number in the message.
        value
            A float, or a number that is exact by its type.
        """
        exact = exact_ratio(value)
        if exact is None:
            return self.ratio(one_number(name, value))
        one_number(name, double(exact))  # refuses what no double is near
        return _exactly(exact)

    def point(self, values: Mapping[str, Any]) -> dict[str, Any]:
        """Numbers by name as rationals; balls stay."""
        return {
            n: v if isinstance(v, (arb, fmpq)) else self.rational(n, v) for n, v in values.items()
        }

    def intervals(
        self, family: Family, positive: Sequence[str], between: Mapping[str, tuple[Any, Any]]
    ) -> dict[str, tuple[Any, Any]]:
        """Open intervals by name, as rationals; None for an infinite end."""
        names = (*family.at, *family.unknown, *family.parameters)
        if isinstance(positive, str):
            raise ParameterError(f"positive is {shown(positive)}; give a tuple of names.")
        out: dict[str, tuple[Any, Any]] = {}
        for name in positive:
            out[known("positive", name, names)] = (fmpq(0), None)
        for name, limits in between.items():
            known("between", name, names)
            out[name] = self._interval(name, limits)
        return out

    def _interval(self, name: str, limits: Any) -> tuple[Any, Any]:
        if isinstance(limits, (tuple, list, np.ndarray)) and len(limits) == 2:
            below, above = (isinstance(v, float) and math.isinf(v) for v in limits)
            low = None if below else self.rational(f"an end of {name}", limits[0])
            high = None if above else self.rational(f"an end of {name}", limits[1])
            ordered = low is None or high is None or low < high
            if ordered and not (below and limits[0] > 0) and not (above and limits[1] < 0):
                return low, high
        raise ParameterError(f"between of {name} is {shown(limits)}; give (low, high).")

    def statement(self, family: Family, numbers: Sequence[Any]) -> str:
        """Sentences on the doubles that are no short decimals exactly, or empty."""
        asis, read = family.graph.numbers
        floats = (v for v in numbers if isinstance(v, float))
        doubles = {v: decimal_of(v) for v in (*floats, *asis, *read)}
        short = {v: d for v, d in doubles.items() if d is not None and d != Fraction(v)}
        others = [f"{v!r}" for v, d in doubles.items() if d is None]
        if not self.decimals:
            v, d = next(iter(short.items()), (0.0, Fraction(0)))
            return AS_DOUBLES.format(decimal=written(d), double=Fraction(v)) if short else ""
        said = []
        if short:
            listed = (f"{written(d)} = {d}" for d in short.values())
            said = [AS_DECIMALS.format(listed=_shortened(list(listed)))]
        if others:
            said += [KEPT.format(listed=_shortened(others))]
        return "  ".join(said)


def _shortened(texts: list[str]) -> str:
    more = len(texts) - MOST_LISTED
    return ", ".join(texts[:MOST_LISTED]) + (f" and {more} more" if more > 0 else "")


def sign_of(value: Any) -> int | None:
    """The sign of a rational or a ball; None where a ball has both.

    Examples
    --------
    >>> sign_of(2), sign_of(0)
    (1, 0)
    """
    return 1 if value > 0 else -1 if value < 0 else 0 if value == 0 else None


MOST_TERMS = 4000
"""Largest number of terms of a polynomial; beyond it the work ends."""
SECONDS = 60.0
"""Time after which the work ends."""
BITS = (128, 512, 2048)
"""Precisions of the balls in which signs at a member are sought."""


@dataclass(frozen=True, eq=False, repr=False)
class Conditions(Record):
    """Exact conditions of stability of a family: polynomials, what decides, boundaries, proofs.

    Every polynomial has integer coefficients.  Numbers of the graph are the exact ratios of their
    doubles, or the decimals that were written: `numbers` says which.

    Source: A. Hurwitz (1895); hand formulas of nine systems: tests/derivation/test_conditions.py.

    Examples
    --------
    >>> import stability as st
    >>> import casadi as ca
    >>> x, p = ca.SX.sym("x"), ca.SX.sym("p")
    >>> s = st.System("f", x, p, -p * x, states=("x",), parameters=("p",))
    >>> st.conditions(st.Family(s, "rest", at=("p",), held={"x": 0})).rule
    'Stable where p > 0; unstable where it is negative.'
    """

    family: Family
    """The family."""
    given: Mapping[str, Fraction]
    """Parameters that have a number."""
    variables: tuple[ConditionVariable, ...]
    """Variables of the polynomials."""
    domain: tuple[str, ...]
    """What is assumed of the variables, such as `v > 0`."""
    relations: tuple[tuple[str, Polynomial], ...]
    """(variable, polynomial that vanishes): sin² + cos² = 1, equations of unknowns."""
    solved: tuple[tuple[str, str], ...]
    """(unknown or function, its closed form), those that a reader can place."""
    nonzero: tuple[Polynomial, ...]
    """Polynomials that do not vanish at a member of this branch."""
    zeros: int
    """Power of λ in the characteristic polynomial: zeros by structure."""
    factors: tuple[Factor, ...]
    """The other factors over Q."""
    conditions: tuple[SignCondition, ...]
    """The conditions of every factor, those that decide first."""
    left_out: tuple[str, ...]
    """What was too large, one sentence each."""
    degree: int
    """Degree of the characteristic polynomial in λ."""
    terms: int
    """Largest number of terms of a polynomial on the way."""
    seconds: float = field(compare=False)
    """Time of the derivation."""
    numbers: str
    """How decimals in the graph and in the given numbers were read; empty where all are exact."""
    _reads: NumberReading
    _intervals: Mapping[str, tuple[Any, Any]]

    __getstate__ = fields_of

    @cached_property
    def _deduction(self) -> Deduction:
        """What checks members; derived again after a pickle, which cannot hold it."""
        numbers = {n: _exactly(v) for n, v in self.given.items()}
        family, limits = self._reads.family(self.family), Budget(MOST_TERMS + self.terms, math.inf)
        polynomial = CharacteristicPolynomial(family, numbers, limits, self._reads.ratio)
        domain = domain_of(polynomial, self._intervals)
        return Deduction(polynomial, domain, structure(family).zeros)

    def __repr__(self) -> str:
        family = self.family
        return f"<Conditions of {family.name} of {family.system.name}: {self.rule}>"

    @property
    def citation(self) -> str:
        """Keys of the works to cite, for `stability.citation`."""
        system = self.family.system
        return cited(system=system.name, model=bool(system.quantities), proofs=True)

    @property
    def deciding(self) -> tuple[SignCondition, ...]:
        """Conditions whose sign decides the verdict."""
        return tuple(c for c in self.conditions if c.decides)

    @property
    def boundaries(self) -> tuple[SignCondition, ...]:
        """Conditions at whose zeros the verdict may change: static, then flutter."""
        rank = {"static": 0, "flutter": 1}
        changing = [c for c in self.deciding if c.kind in rank]
        return tuple(sorted(changing, key=lambda c: rank[c.kind]))

    @property
    def branch(self) -> str:
        """The branch of steady motions that is meant, in words; empty where there is one alone."""
        if self._deduction.polynomial.triangular.alone:
            return ""
        unknown = self.family.unknown
        parts = [f"{n} = {v}" for n, v in self.solved if n in unknown]
        parts += [f"{p} = 0" for n, p in self.relations if n in unknown]
        return f"the branch with {', '.join(parts)}" if parts else "the branch of typical members"

    @property
    def rule(self) -> str:
        """The verdict in one sentence, with the branch where there are several."""
        said = self._rule
        return f"On {self.branch}: {said[0].lower()}{said[1:]}" if self.branch else said

    @property
    def _rule(self) -> str:
        even = any(f.even for f in self.factors) or self._extra_zeros > 0
        good = typical(self.family, even=even)
        word = "stable or drifting" if good is Verdict.UNDECIDED else good.word
        asked = [f"{c.polynomial} > 0" for c in self.deciding]
        if self.left_out:
            return f"The conditions are incomplete: {self.left_out[0]}."
        if any(c.status == "negative" for c in self.deciding):
            return "Unstable at every member of the domain."
        if any(c.status == "zero" for c in self.deciding):
            return "Never stable: a condition is zero at every member of the domain."
        if not asked:
            return f"{word.capitalize()} at every member of the domain."
        joined, below = " and ".join(asked), "it" if len(asked) == 1 else "one of these"
        said = "".join(f" {c.doubt}" for c in self.deciding if c.status == "open")
        return f"{word.capitalize()} where {joined}; unstable where {below} is negative.{said}"

    @property
    def _extra_zeros(self) -> int:
        return max(0, self.zeros - self._deduction.structural)

    # --- at points ---

    def decide(self, values: Mapping[str, Any]) -> Verdict:
        """The verdict from the conditions at numbers for the variables.

        Parameters
        ----------
        values
            A rational (integer, Fraction, double) or ball for each of `variables`.

        Returns
        -------
        Verdict
            Undecided where a ball leaves a sign open.

        Raises
        ------
        ParameterError
            If a number is missing.
        DomainError
            If the point is outside the domain, or no member of this branch.

        Examples
        --------
        >>> from fractions import Fraction
        >>> import casadi as ca, stability as st
        >>> x, c = ca.SX.sym("x", 2), ca.SX.sym("c")
        >>> system = st.System("oscillator", x, c, ca.vertcat(x[1], -x[0] - c * x[1]),
        ...                    states=("q", "v"), parameters=("c",))
        >>> rest = st.Family(system, "rest", at=("c",), held={"q": 0, "v": 0})
        >>> st.conditions(rest).decide({"c": Fraction(-1, 3)}).word
        'unstable'
        """
        return self._decide(values, values)

    def _decide(self, values: Mapping[str, Any], every: Mapping[str, Any]) -> Verdict:
        """The verdict at numbers for the variables; of zeros, by the numbers of everything."""
        names = [v.name for v in self.variables]
        for name in names:
            if name not in values:
                raise ParameterError(f"{name} is missing; give a number for {', '.join(names)}.")
        table = self._reads.point({n: values[n] for n in names})
        point = [table[n] for n in names]
        if not self._deduction.members.check(point):
            return Verdict.UNDECIDED
        signs = [sign_of(c.polynomial(*point)) for c in self.deciding]
        if -1 in signs:
            return Verdict.UNSTABLE
        verdict = self._by_signs(point, signs)
        return self._with_zeros(every) if verdict is Verdict.STABLE else verdict

    def _by_signs(self, point: Sequence[Any], signs: Sequence[int | None]) -> Verdict:
        even = any(f.even for f in self.factors) or self._extra_zeros > 0
        if not self.left_out and all(s == 1 for s in signs):
            return best(even=even)
        if all(isinstance(v, fmpq) for v in point):
            polys = [[fmpq(c(*point)) for c in f.coefficients] for f in self.factors]
            zeros = [fmpq_poly([0, 1])] * self._extra_zeros
            return on_the_axis([*map(fmpq_poly, polys), *zeros])
        return self._by_routh(point, best(even=even)) if self.left_out else Verdict.UNDECIDED

    def _with_zeros(self, every: Mapping[str, Any]) -> Verdict:
        """The verdict where all other eigenvalues have negative real parts."""
        family, zeros = self.family, self._deduction.structural
        if semisimple(family, zeros):
            return Verdict.STABLE
        numbers = {n: _exactly(v) for n, v in self.given.items()}
        numbers |= self._reads.point(every)
        if not numbers.keys() >= {*family.at, *family.parameters}:
            return Verdict.UNDECIDED
        a, q = ([numbers[n] for n in names] for names in (family.at, family.parameters))
        rows = [np.array([[float(v) for v in part]]).reshape(1, -1) for part in (a, q)]
        near = [
            numbers.get(n, u) for n, u in zip(family.unknown, family.solve(*rows)[0], strict=True)
        ]
        power = zero_power(Member(family, a, q, [float(u) for u in near]), zeros)
        if power is None:
            return Verdict.UNDECIDED
        return Verdict.DRIFTING if power else Verdict.STABLE

    def _by_routh(self, point: Sequence[Any], good: Verdict) -> Verdict:
        """The verdict from Routh's array in balls, where determinants were too large."""
        signs = []
        for factor in self.factors:
            balls = [arb(c(*point)) for c in factor.coefficients]
            turned = [c if balls[-1] > 0 else -c for c in balls]
            clear = bool(turned[-1] > 0)
            signs.append(hurwitz_sign(verdict_polynomial(turned, 0, factor.even)) if clear else 0)
        if -1 in signs:
            return Verdict.UNSTABLE
        return Verdict.UNDECIDED if 0 in signs else good

    def values(self, at: ArrayLike, **parameters: Any) -> dict[str, Any]:
        """Values of the variables at a member: rationals, or balls where these are irrational.

        Parameters
        ----------
        at
            The member, one number for each of the family's `at`.
        **parameters
            The system's other parameters.

        Returns
        -------
        dict
            By name of the variable, at the current precision of python-flint.

        Raises
        ------
        NoMemberError
            If there is no such member, or none is proved to exist.
        """
        point = self._point(at, parameters)
        numbers = self._deduction.members.values(point)
        return dict(zip((v.name for v in self.variables), numbers, strict=True))

    def verdict(self, at: ArrayLike, **parameters: Any) -> Verdict:
        """The verdict from the conditions at a member.

        Parameters
        ----------
        at, **parameters
            As in `values`.

        Returns
        -------
        Verdict

        Raises
        ------
        DomainError
            If the member is outside the domain, or on another branch.
        NoMemberError
            If there is no such member, or none is proved to exist.
        """
        verdict = Verdict.UNDECIDED
        for bits in BITS:
            with precision(bits):
                values = self.values(at, **parameters)
                verdict = self._decide(values, values | self._point(at, parameters))
            if verdict is not Verdict.UNDECIDED:
                break
        return verdict

    def _point(self, at: Any, parameters: Mapping[str, Any]) -> dict[str, Any]:
        a = np.atleast_1d(np.asarray(at, dtype=object))
        if a.shape != (len(self.family.at),):
            raise ParameterError(
                f"at has shape {a.shape}; give one member ({', '.join(self.family.at)})."
            )
        point = self._reads.point(dict(zip(self.family.at, a, strict=True)))
        for name, value in parameters.items():
            known("parameter", name, self.family.parameters)
            point[name] = self._reads.rational(name, value)
        for name in self.family.parameters:
            if name in self.given:
                number = _exactly(self.given[name])
                if point.setdefault(name, number) != number:
                    raise ParameterError(f"{name} is {float(self.given[name]):g} here; leave it.")
            if name not in point:
                raise ParameterError(f"{name} is missing; give a number.")
        return point


def conditions(
    family: Family | str,
    *,
    contact: Contact | type[Contact] | str | None = None,
    body: Body | Disk | None = None,
    positive: Sequence[str] = (),
    between: Mapping[str, tuple[float, float]] | None = None,
    decimals: bool = False,
    terms: int = MOST_TERMS,
    seconds: float = SECONDS,
    **parameters: Any,
) -> Conditions:
    """Exact conditions of stability of a family, over Q.

    Parameters
    ----------
    family
        A family whose Jacobian is algebraic in parameters, states, and functions of these; or the
        name of a family of the disk or of `body`, with `contact`.
    contact, body
        With a family by its name, as for `spectrum`; their numbers stay variables, and are given
        as parameters where they are not to.
    positive
        Names of parameters, family parameters or unknowns that are positive.
    between
        Open intervals by name; an end may be infinite.
    decimals
        Whether a float, in the graph or given, is read as the decimal that was written: 9.81 as
        981/100.  A float that is nearest to no decimal of 15 digits stays as it is, such as 1/3.
        If False, every float is its exact double, as in certified spectra.
    terms
        Largest number of terms of a polynomial.
    seconds
        Longest time [s].
    **parameters
        Numbers of some of the system's parameters; the others stay variables.  An integer, a
        `Fraction`, a `Decimal` or a rational of SymPy is taken exactly.

    Returns
    -------
    Conditions
        Polynomials, conditions with what is proved of each, and exact boundaries.

    Raises
    ------
    NameUnknownError, ParameterError
        If a name or an interval does not fit.
    StabilityError
        If the characteristic polynomial is too large, or its zeros by structure are not proved.

    Source: F. R. Gantmacher, The Theory of Matrices, vol. 2, ch. XV §§ 6, 13 (Liénard & Chipart);
    the hand formulas in tests/derivation/test_conditions.py.

    Examples
    --------
    >>> import stability as st
    >>> import casadi as ca, stability as st
    >>> x, c = ca.SX.sym("x", 2), ca.SX.sym("c")
    >>> system = st.System("oscillator", x, c, ca.vertcat(x[1], -x[0] - c * x[1]),
    ...                    states=("q", "v"), parameters=("c",))
    >>> rest = st.Family(system, "rest", at=("c",), held={"q": 0, "v": 0})
    >>> st.conditions(rest).rule
    'Stable where c > 0; unstable where it is negative.'
    """
    refuse_system(family)
    family = family_by_name(family, body, contact, parameters)
    family = instance("family", family, Family, A_FAMILY)
    reads = NumberReading(flag("decimals", decimals))
    intervals = reads.intervals(family, positive, between or {})
    values = {
        known("parameter", n, family.parameters): reads.rational(n, v)
        for n, v in parameters.items()
    }
    family = steady_where(family, values)
    stated, family = family, reads.family(family)
    budget = Budget(whole_number("terms", terms, 1), float(above_zero("seconds", seconds)))
    zeros = structure(family)
    if not zeros.steady:
        raise StabilityError(
            f"{family.name}: a rate does not vanish at its typical members; conditions need a "
            "family of steady motions."
        )
    if not sloped_somewhere(family, values):
        raise StabilityError(f"{family.name}: the rates have no slope at its members, as |x| at 0.")
    try:
        polynomial = CharacteristicPolynomial(family, values, budget, reads.ratio)
        proved = polynomial.factored.zeros
    except NotExact as reason:
        large, why = isinstance(reason, TooLarge), f"has no exact form here ({reason})"
        why = f"is too large: {reason}; terms= and seconds= move these limits" if large else why
        raise StabilityError(
            f"{family.name}: the characteristic polynomial, of degree {len(family.system.states)} "
            f"in λ, {why}; verdicts, boundaries and maps need no formula."
        ) from None
    if proved < zeros.zeros:
        raise StabilityError(
            f"{family.name}: {zeros.zeros} zeros by structure, of which {proved} are proved; "
            "the equations of its unknowns do not reduce the polynomial far enough."
        )
    deduction = Deduction(polynomial, domain_of(polynomial, intervals), zeros.zeros)
    said = reads.statement(family, tuple(parameters.values()))
    record = _record(deduction, budget, stated, said, (reads, intervals))
    record.__dict__["_deduction"] = deduction
    return record


def _record(
    deduction: Deduction, budget: Budget, family: Family, said: str, read: tuple[NumberReading, Any]
) -> Conditions:
    polynomial, shown_ = deduction.polynomial, deduction.shown
    factored = polynomial.factored
    rows_ = deduction.conditions(budget)
    for row in rows_:
        row["witnesses"] = tuple(Witness(*w) for w in row["witnesses"])
    ordered = sorted((SignCondition(**r) for r in rows_), key=lambda c: not c.decides)
    return Conditions(
        family=family,
        given={n: Fraction(int(v.p), int(v.q)) for n, v in polynomial.values.items()},
        variables=tuple(ConditionVariable(*row) for row in deduction.variables()),
        domain=tuple(deduction.assumptions()),
        relations=tuple((factored.names[i], shown_(f)) for i, f in factored.relations),
        solved=closed_forms(polynomial),
        nonzero=tuple(shown_(f) for f in factored.nonzero if not deduction.certain(f)),
        zeros=factored.zeros,
        factors=tuple(
            Factor(tuple(shown_(c, whole) for c in whole), even, count)
            for whole, even, count in deduction.factors
        ),
        conditions=tuple(ordered),
        left_out=tuple(deduction.left_out),
        degree=len(polynomial.matrix),
        terms=budget.largest,
        seconds=budget.spent,
        numbers=said,
        _reads=read[0],
        _intervals=read[1],
    )
