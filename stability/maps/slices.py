"""The characteristic polynomial of a family over Q, in the two axes of a map.

All other numbers are the exact ratios of their doubles, so the polynomials have two variables and
stay small.  For the disk they come from its stored polynomials, in which the sine of an angle may
be the variable of that axis.  For a user's family the polynomial holds at every member of the map,
on every branch: unknowns are quotients of polynomials in the axes, and all rates vanish.

A `Slice` holds the polynomial in factors, and the signs that decide.  Sines and roots of fixed
numbers make its coefficients balls.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import casadi as ca
from flint import Ordering, arb, fmpq, fmpq_mpoly, fmpq_mpoly_ctx, fmpq_poly
from flint.utils.flint_exceptions import DomainError

from ..algebra.exact.function_field import Expression, FunctionField, evaluate, occurring
from ..algebra.exact.hurwitz_forms import Budget, factors, hurwitz_determinants
from ..algebra.exact.number_fields import NotExact, characteristic, exact_upright, rational
from ..algebra.exact.routh import hurwitz_matrix, is_even, on_the_axis
from ..algebra.number_types import Algebra, balls, precision
from ..algebra.polynomial import Polynomial, TabulatedPolynomial
from ..algebra.program import Program
from ..algebra.upright import Upright
from ..base.errors import ParameterError, StabilityError
from ..base.types import fields_of
from ..base.verdict import Verdict, best
from ..derivation.deduction import even_conditions, hurwitz_conditions
from ..polynomials.characteristic import CharacteristicPolynomial
from ..polynomials.identities import certain
from ..spectra.problem import Problem
from ..systems.family import Family
from ..systems.structure.structural_zeros import structure

Exponents = tuple[int, int]


@dataclass(frozen=True, eq=False)
class BallPolynomial:
    """A polynomial with a ball for each coefficient; no term means an exact zero."""

    terms: dict[Exponents, Any]
    """Ball by exponents of x and y."""

    @classmethod
    def number(cls, value: Any) -> BallPolynomial:
        """A constant."""
        return cls({(0, 0): arb(value)})

    def __reduce__(self) -> Any:
        """For other processes: the bounds of each ball, exactly."""
        parts = {e: (_bits(c.mid()), _bits(c.rad())) for e, c in self.terms.items()}
        return _ball_polynomial, (parts,)

    def __add__(self, other: Any) -> BallPolynomial:
        out = dict(self.terms)
        for e, c in _terms(other).items():
            out[e] = out[e] + c if e in out else c
        return BallPolynomial(out)

    __radd__ = __add__

    def __neg__(self) -> BallPolynomial:
        return BallPolynomial({e: -c for e, c in self.terms.items()})

    def __sub__(self, other: Any) -> BallPolynomial:
        return self.__add__(-other)

    def __mul__(self, other: Any) -> BallPolynomial:
        out: dict[Exponents, Any] = {}
        for (i, j), c in self.terms.items():
            for (k, m), d in _terms(other).items():
                e = i + k, j + m
                out[e] = out[e] + c * d if e in out else c * d
        return BallPolynomial(out)

    __rmul__ = __mul__

    def __eq__(self, other: object) -> bool:
        """Whether both are the same object, or this is an exact zero and the other one 0."""
        return self is other or (other == 0 and self.is_zero())

    __hash__ = None  # type: ignore[assignment]

    def __len__(self) -> int:
        return len(self.terms)

    def is_zero(self) -> bool:
        """Whether every coefficient is exactly zero."""
        return all(c == 0 for c in self.terms.values())

    def is_constant(self) -> bool:
        """Whether this is a constant with a known sign."""
        return set(self.terms) <= {(0, 0)} and not (self.terms and self.terms[0, 0].contains(0))

    def leading_coefficient(self) -> Any:
        """The constant."""
        return self.terms.get((0, 0), arb(0))


def ball_determinants(coefficients: Sequence[BallPolynomial], budget: Budget) -> list[Any]:
    """Hurwitz determinants of order 1 … n - 1, without divisions.

    Parameters
    ----------
    coefficients
        Coefficients by powers of λ, lowest first.
    budget
        Limits of the work.
    """
    out: list[Any] = []
    for size in range(1, len(coefficients) - 1):
        determinant = characteristic(hurwitz_matrix(coefficients, size, 0))[0] + BallPolynomial({})
        out.append(-determinant if size % 2 else determinant)
        budget.watch(out[-1])
    return out


def _terms(value: Any) -> dict[Exponents, Any]:
    return value.terms if isinstance(value, BallPolynomial) else {(0, 0): arb(value)}


def _bits(value: Any) -> tuple[int, int]:
    man, exp = value.man_exp()
    return int(man), int(exp)


def _ball_polynomial(parts: dict[Exponents, Any]) -> BallPolynomial:
    from ..algebra.number_types import precision

    with precision(4096):
        return BallPolynomial(
            {
                e: arb(m[0]) * arb(2) ** m[1] + arb(0, arb(r[0]) * arb(2) ** r[1])
                for e, (m, r) in parts.items()
            }
        )


Poly = Any
"""An `fmpq_mpoly` in x, y, λ, or a `BallPolynomial` in x and y."""
Rows = tuple[tuple[tuple[Poly, ...], bool, int], ...]
"""(coefficients by powers of λ lowest first, whether even, multiplicity) of each factor."""
RING = fmpq_mpoly_ctx.get(("x", "y", "l"), Ordering.degrevlex)
"""The ring of all slices: x, y and λ."""
MOST_FACTORED = 80
"""Terms of a condition beyond which its factors are not sought."""


@dataclass(frozen=True)
class SignProduct:
    """A polynomial as a sign times powers of factors, given by their place in a list."""

    sign: int
    """1, -1, or 0 for the polynomial zero."""
    powers: tuple[tuple[int, int], ...]
    """(place of the factor, power)."""


@dataclass(frozen=True, eq=False)
class Slice:
    """The polynomial and the conditions of a family in the axes of a map, over Q."""

    factors: Rows
    """(coefficients by powers of λ lowest first, whether even, multiplicity) of each factor."""
    surfaces: tuple[Poly, ...]
    """Polynomials in x and y whose signs are asked."""
    conditions: tuple[SignProduct, ...]
    """All positive: best verdict; one negative: unstable."""
    required: tuple[SignProduct, ...]
    """Positive at every member of the family."""
    nonzero: tuple[SignProduct, ...]
    """Not zero where the polynomial holds."""
    even: bool
    """Whether the best verdict is neutral."""
    functions: tuple[str, str] = ("", "")
    """Functions of the axes that x and y are: sin, cos, or none."""

    def __reduce__(self) -> Any:
        """For other processes: polynomials as their terms."""
        return _unpacked, tuple(map(_packed, fields_of(self).values()))

    def verdict(self, x: float, y: float) -> Verdict | None:
        """The verdict of one cell over Q; None where it is no member, or this form fails.

        Parameters
        ----------
        x, y
            Doubles, taken as exact.
        """
        if any(isinstance(p, BallPolynomial) for p in self.surfaces) or any(self.functions):
            return None  # a ball proves no zero, and the sine of a double is no double
        point = rational(x), rational(y), fmpq(0)
        signs = [_sign(p(*point)) for p in self.surfaces]
        value = [_value(c, signs) for c in self.required]
        if any(v <= 0 for v in value) or any(_value(c, signs) == 0 for c in self.nonzero):
            return None
        value = [_value(c, signs) for c in self.conditions]
        if all(value):
            return best(even=self.even) if min(value, default=1) > 0 else Verdict.UNSTABLE
        polys = [fmpq_poly([c(*point) for c in row]) for row, _, _ in self.factors]
        return on_the_axis(polys)

    @property
    def exponents(self) -> Iterator[Exponents]:
        """Powers of x and y in every polynomial."""
        for poly in (*self.surfaces, *(c for row, _, _ in self.factors for c in row)):
            if poly != 0:
                terms = poly.terms if isinstance(poly, BallPolynomial) else poly.to_dict()
                yield from ((int(e[0]), int(e[1])) for e in terms)


def _packed(value: Any) -> Any:
    if isinstance(value, fmpq_mpoly):
        return {tuple(map(int, e)): (int(c.p), int(c.q)) for e, c in value.to_dict().items()}
    return tuple(map(_packed, value)) if type(value) is tuple else value


def _rebuilt(value: Any) -> Any:
    if isinstance(value, dict):
        return RING.from_dict({e: fmpq(*c) for e, c in value.items()})
    return tuple(map(_rebuilt, value)) if type(value) is tuple else value


def _unpacked(*values: Any) -> Slice:
    return Slice(*map(_rebuilt, values))


def _sign(value: Any) -> int:
    return 1 if value > 0 else -1 if value < 0 else 0


def _value(condition: SignProduct, signs: Sequence[int]) -> int:
    out = condition.sign
    for place, power in condition.powers:
        out *= signs[place] ** power
    return out


class SignTable:
    """Polynomials in x and y, each kept once, and conditions as products of them."""

    def __init__(self) -> None:
        self.polys: list[Poly] = []

    def condition(self, *product: Poly, whole: bool = False) -> SignProduct:
        """A product of polynomials as a product of kept ones, or of their factors."""
        sign, powers = 1, Counter[int]()
        for poly in product:
            if poly == 0:  # neither positive nor negative: exact arithmetic decides each cell
                return SignProduct(0, ())
            if poly.is_constant():
                sign *= _sign(poly.leading_coefficient())
                continue
            keep = whole or isinstance(poly, BallPolynomial) or len(poly) > MOST_FACTORED
            constant, factored = (fmpq(1), [(poly, 1)]) if keep else factors(poly)
            sign *= _sign(constant)
            for factor, count in factored:
                powers[self._place(factor)] += count
        return SignProduct(sign, tuple(powers.items()))

    def _place(self, poly: Poly) -> int:
        if poly not in self.polys:
            self.polys.append(poly)
        return self.polys.index(poly)


BITS = 2048
"""Precision of sines and roots of fixed numbers."""

MOST_STATES = 12
"""Most states of a system whose polynomial is sought."""
MOST_DEGREE = 64
"""Largest degree in x and y that the polynomial may reach."""
MOST_TERMS = 2000
"""Largest number of terms of a polynomial."""
SECONDS = 2.0
"""Time after which the work ends, and the map takes the graph's route."""
LAM = 2
"""Place of λ in the ring."""


@dataclass(frozen=True, eq=False)
class Monomial:
    """A number times powers of x and y, which may be negative."""

    number: Any
    """An `fmpq`, or a ball."""
    powers: Exponents = (0, 0)

    def __mul__(self, other: Monomial) -> Monomial:
        (a, b), (c, d) = self.powers, other.powers
        return Monomial(self.number * other.number, (a + c, b + d))

    def __truediv__(self, other: Monomial) -> Monomial:
        (a, b), (c, d) = self.powers, other.powers
        return Monomial(self.number / other.number, (a - c, b - d))

    def __eq__(self, other: object) -> bool:
        return bool(other == 0 and self.number == 0)

    __hash__ = None  # type: ignore[assignment]


def _ball_of(function: str) -> Callable[[Monomial], Monomial]:
    """The sine or cosine of a fixed number as a ball, or of an axis as that axis' variable."""

    def apply(angle: Monomial) -> Monomial:
        if angle.powers != (0, 0):
            return angle
        return Monomial(balls().functions[function](arb(angle.number)))

    return apply


MONOMIALS = Algebra("monomials", Monomial, {n: _ball_of(n) for n in ("sin", "cos")})


def stored_slice(problem: Problem, x: str, y: str) -> Slice:
    """The slice of a stored polynomial, whose variables are monomials in the axes.

    Parameters
    ----------
    problem
        Problem of a family with a `TabulatedPolynomial`.
    x, y
        Names of the axes.
    """
    exact = problem.exact
    assert isinstance(exact, TabulatedPolynomial)
    unit, axes = Monomial(fmpq(1)), {x: (1, 0), y: (0, 1)}
    values = {
        n: Monomial(fmpq(1), axes[n]) if n in axes else Monomial(rational(float(v)))
        for n, v in problem.values.items()
    }
    with precision(BITS):
        point = [v if isinstance(v, Monomial) else unit for v in exact.point(values, MONOMIALS)]
        rows = tuple(
            (_cleared_terms([_at_monomials(c, point) for c in factor]), exact.known.even, 1)
            for factor in exact.known.factors
        )
        polys = [_cleared_terms([_at_monomials(p, point)])[0] for _, p in exact.known.conditions]
    table = SignTable()
    conditions = tuple(table.condition(p, whole=True) for p in polys)
    if "lean" not in axes and exact.edge(problem.values):
        conditions += (SignProduct(0, ()),)
    first, second = ({"theta": "sin", "lean": "cos"}.get(exact.angle(n), "") for n in (x, y))
    functions = first, second
    # what the conditions leave out: the right angle, and a precession of zero, without a member
    gone = [RING.gens()[k] for k, n in enumerate((x, y)) if n == "phi_dot"]
    if "s" in exact.known.variables:
        gone += [1 - RING.gens()[k] for k, function in enumerate(functions) if function]
    nonzero = tuple(table.condition(p, whole=True) for p in gone)
    return Slice(rows, tuple(table.polys), conditions, (), nonzero, exact.known.even, functions)


def _at_monomials(poly: Polynomial, point: Sequence[Monomial]) -> dict[Exponents, Any]:
    """Coefficient by powers of x and y, where the variables are monomials in them."""
    terms: dict[Exponents, Any] = {}
    for c, exponents in poly.terms:
        total = Monomial(fmpq(c))
        for variable, power in zip(point, exponents, strict=True):
            for _ in range(power):
                total = total * variable
        if total.powers in terms:
            terms[total.powers] += total.number
        else:
            terms[total.powers] = total.number
    return terms


def _cleared_terms(polys: Sequence[dict[Exponents, Any]]) -> tuple[Poly, ...]:
    """Polynomials in the ring times the least monomial that leaves no negative power."""
    every = [e for poly in polys for e in poly]
    low = [min(0, *(e[k] for e in every)) for k in (0, 1)] if every else [0, 0]
    inexact = any(isinstance(c, arb) for poly in polys for c in poly.values())
    out = []
    for poly in polys:
        moved = {(i - low[0], j - low[1]): c for (i, j), c in poly.items()}
        if inexact:
            out.append(BallPolynomial({e: arb(c) for e, c in moved.items()}))
        else:
            out.append(RING.from_dict({(*e, 0): c for e, c in moved.items()}))
    return tuple(out)


def slice_of(problem: Problem, x: str, y: str) -> Slice | None:
    """The polynomial of a problem over two axes; None where there is none.

    Parameters
    ----------
    problem
        Problem of a family with a stored polynomial, or of a user's without one of its own.
    x, y
        Names of the axes.

    Returns
    -------
    Slice or None
        None for a family that is not algebraic, whose zeros by structure are not proved for every
        member, or whose polynomial is beyond the limits of this module.
    """
    if isinstance(problem.exact, TabulatedPolynomial):
        return stored_slice(problem, x, y)
    if not problem.plain or problem.exact is not None:
        return None
    names = (*problem.family.at, *problem.family.parameters)
    fixed = tuple((n, float(problem.values[n])) for n in names if n not in (x, y))
    return _cached(problem.family, x, y, fixed)


@lru_cache(maxsize=32)
def _cached(family: Family, x: str, y: str, fixed: tuple[tuple[str, float], ...]) -> Slice | None:
    if len(family.system.states) > MOST_STATES or not certain(family):
        return None
    try:
        return _AxesPolynomial(family, (x, y), dict(fixed)).slice()
    except (NotExact, ZeroDivisionError, StabilityError, OverflowError):
        return None


class _Field(FunctionField):
    """A field in which the root of a square p², or |p|, is p, on one side of p = 0."""

    def __init__(
        self, names: Sequence[str], budget: Budget, spare: int, near: Sequence[Any]
    ) -> None:
        super().__init__(names, budget, spare)
        self.near = near
        self.sides: list[Poly] = []
        """Polynomials that are positive where the roots are the ones taken."""

    def root(self, kind: str, square: Any, over: Any = None) -> Expression:
        """An indeterminate whose square is a polynomial, or a polynomial."""
        places = range(len(self.near))
        used = occurring(square) | (set() if over is None else occurring(over))
        value = None
        if used <= {*places}:
            with suppress(DomainError):  # no square
                value = square.sqrt()
        if value is None:
            return super().root(kind, square, over)
        side = value if over is None else value * over
        if evaluate(side, dict(zip(places, self.near, strict=True))) < 0:
            value, side = -value, -side
        if not side.is_constant():
            self.sides.append(side)
        return Expression(self, value, self.one)


class _AxesPolynomial(CharacteristicPolynomial):
    """A family's characteristic polynomial in the axes of a map, at every member."""

    field: _Field

    def __init__(self, family: Family, axes: tuple[str, str], fixed: Mapping[str, float]) -> None:
        self.near = [rational(float(family.typical.get(n, 1.0))) for n in axes]
        values = {n: rational(v) for n, v in fixed.items()}
        super().__init__(family, values, Budget(MOST_TERMS, SECONDS, MOST_DEGREE), free=axes)
        if self.bound > self.places or self.triangular.kept or not self.triangular.alone:
            raise NotExact("unknowns that the equations do not give as quotients")
        if len(self.triangular.solved) < len(self.places):
            raise NotExact("equations that leave an unknown open")
        rates = [self.element(row[0]) for row in self.rows(family.graph.rates)]
        if any(self.triangular.value(rate).num != 0 for rate in rates):
            raise NotExact("a rate that does not vanish identically")

    def _field_of(self, names: Sequence[str], spare: int) -> _Field:
        return _Field(names, self.budget, spare, self.near)

    @cached_property
    def conditions(self) -> list[tuple[Expression, str]]:
        """Every condition of a member: where one is not read, a cell may hold none."""
        family = self.family
        values = [self.symbols[n] for n in family.positive]
        asked = _asked(family)
        if asked is not None:
            try:
                values += [v[0] for v in asked.run(exact_upright(), self.place)]
            except (TypeError, ParameterError):  # of the right angle only sine and cosine are exact
                raise NotExact("a condition at the right angle") from None
        return [(self.element(v), "") for v in values]

    def slice(self) -> Slice:
        """The slice of this polynomial."""
        exact, table = not self.field.meaning, SignTable()
        with precision(BITS):
            rows, apart = self._over_q() if exact else self._in_balls()
            # roots of squares were taken on one side of zero
            required = [*(p for p, _ in self.required), *self.field.sides]
            moved = _moved if exact else self._enclosed
            positive = tuple(table.condition(moved(p)) for p in required)
            apart += [row[-1] for row, _, _ in rows]
            nonzero = tuple(table.condition(p) for p in apart if not p.is_constant())
            polys = [p for row, even, _ in rows for p in _conditions(row, even, self.budget)]
            conditions = tuple(table.condition(*some) for some in polys)
        even = any(even for _, even, _ in rows)
        return Slice(rows, tuple(table.polys), conditions, positive, nonzero, even)

    def _over_q(self) -> tuple[Rows, list[Poly]]:
        """The factors of the polynomial over Q, and polynomials that are not zero."""
        form = self.factored
        if form.zeros != structure(self.family).zeros or not form.factors:
            raise NotExact("zeros in addition to those by structure")
        rows: list[tuple[tuple[Poly, ...], bool, int]] = []
        for factor, count in form.factors:
            row = [_moved(c, form.indices) for c in factor]
            turn = -1 if row[-1].is_constant() and row[-1].leading_coefficient() < 0 else 1
            rows.append((tuple(c * turn for c in row), is_even(row), count))
        return tuple(rows), [_moved(p, form.indices) for p in form.nonzero]

    def _in_balls(self) -> tuple[Rows, list[Poly]]:
        """The polynomial with sines and roots of fixed numbers as narrow balls."""
        common, powers = self.powers(self.entries)
        row = [self._enclosed(c) for c in powers][structure(self.family).zeros :]
        even = self.family.conservative  # an identity, as its zeros are
        if even:
            row = [BallPolynomial({}) if k % 2 else c for k, c in enumerate(row)]
        if len(row) < 2 or row[0].is_zero():
            raise NotExact("zeros in addition to those by structure")
        apart = [self._enclosed(p) for p in (*self.triangular.nonzero, common)]
        return ((tuple(row), even, 1),), apart

    @cached_property
    def _atoms(self) -> dict[int, Any]:
        """Values of the functions of fixed numbers, as balls."""
        values: dict[int, Any] = {}
        for index in sorted(self.field.meaning):
            if not self.field.uses(index) <= set(self.field.meaning):
                raise NotExact("functions of what varies")
            values[index] = self.field.enclosed(index, values)
        return values

    def _enclosed(self, poly: Poly) -> BallPolynomial:
        """A polynomial of the field, with balls for the functions in it."""
        terms: dict[Exponents, Any] = {}
        for (i, j, *rest), c in poly.to_dict().items():
            value = arb(c)
            for index, power in enumerate(rest, start=2):
                if power:
                    value = value * self._atoms[index] ** int(power)
            key = int(i), int(j)
            terms[key] = terms[key] + value if key in terms else value
        return BallPolynomial(terms)


def _moved(poly: Poly, indices: Sequence[int] = (0, 1)) -> Poly:
    """A polynomial without functions in the ring of slices, its variables by their place there."""
    terms: dict[tuple[int, ...], Any] = {}
    for exponents, c in poly.to_dict().items():
        powers = dict(zip(indices, map(int, exponents), strict=False))
        terms[powers.get(0, 0), powers.get(1, 0), 0] = c
    return RING.from_dict(terms)


def _asked(family: Family) -> Program | None:
    """The conditions that depend on more than a right angle; the others are proved here."""
    system = family.system
    right = [i for i, n in enumerate(system.states) if isinstance(family.held.get(n), Upright)]
    others = ca.vertcat(
        *[s for i, s in enumerate(ca.vertsplit(system.x)) if i not in right], system.p
    )
    asked = [c.value for c in system.conditions if ca.depends_on(c.value, others)]
    if len(asked) == len(system.conditions):
        return system.condition_program if asked else None
    alone = [c.value for c in system.conditions if not ca.depends_on(c.value, others)]
    with precision(BITS):
        place = [arb.pi() / 2 if i in right else arb(0) for i in range(len(system.states))]
        program = Program(ca.Function("alone", [system.x, system.p], alone))
        numbers = program.run(balls(), [place, [arb(0)] * len(system.parameters)])
    if not all(v[0] > 0 for v in numbers):
        raise NotExact("a condition at the right angle")
    return Program(ca.Function("conditions", [system.x, system.p], asked)) if asked else None


def _conditions(row: Sequence[Poly], even: bool, budget: Budget) -> list[tuple[Poly, ...]]:
    """Products: all positive only where no root has Re >= 0; one negative only where one has > 0.

    Liénard and Chipart's conditions; for q(λ²) coefficients and subdiscriminants of q.
    """
    lead = row[-1]
    if even:
        if isinstance(lead, BallPolynomial) and len(row) > 5:
            raise NotExact("subdiscriminants need divisions")
        named = even_conditions(row, budget)
    else:
        by = ball_determinants if isinstance(lead, BallPolynomial) else hurwitz_determinants
        sets = hurwitz_conditions(row, by(row, budget) if len(row) > 2 else [])
        named = min(sets, key=lambda some: sum(len(p) for _, _, p, _ in some))
    open_lead = not lead.is_constant()
    return [(p, lead) if open_lead and power % 2 else (p,) for _, _, p, power in named]
