"""The characteristic polynomial of any family over Q: sines, roots and unknowns as variables.

The Jacobian is read from the graph over the field of rational functions.  The family's equations
are brought to triangular form on the branch of its typical members, so unknowns that occur
linearly are gone, and others are reduced by the equations that they obey.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, reduce
from typing import Any

import casadi as ca
import numpy as np
from flint import Ordering, arb, fmpq_mpoly_ctx, fmpq_poly, fmpz

from ..algebra.exact.function_field import SPARE, Expression, FunctionField, evaluate, occurring
from ..algebra.exact.hurwitz_forms import Budget, coefficient_row, factors
from ..algebra.exact.number_fields import EXACT, NotExact, characteristic, rational
from ..algebra.exact.rational_functions import common_multiple, primitive, univariate
from ..algebra.exact.triangular import Triangular
from ..algebra.number_types import Algebra, precision
from ..algebra.program import Program
from ..algebra.upright import Upright
from ..base.errors import NoMemberError
from ..systems.family import Family
from ..systems.structure.enclosure import ball_unknowns
from ..systems.structure.places import blocks_of
from ..systems.structure.structural_zeros import SAMPLE_BITS, SAMPLES, sampled

Poly = Any
"""An `fmpq_mpoly`."""
LONGEST = 24
"""Characters of an argument that a variable's name shows; longer ones get a number."""


@dataclass(frozen=True, eq=False)
class Factored:
    """A characteristic polynomial in factors, in a ring of the variables that occur and λ."""

    names: tuple[str, ...]
    """Names of the variables; λ is the last variable of the ring."""
    indices: tuple[int, ...]
    """Index of each variable in the field of the reading."""
    ring: Any
    """Context of the polynomials."""
    zeros: int
    """Power of λ."""
    factors: tuple[tuple[tuple[Poly, ...], int], ...]
    """(coefficients by powers of λ, lowest first; multiplicity) of each other factor."""
    nonzero: tuple[Poly, ...]
    """Polynomials that are not zero, since there is no linearisation or no member otherwise."""
    crossed: tuple[Poly, ...]
    """Those at whose zeros another branch crosses: this branch has a linearisation there."""
    required: tuple[tuple[Poly, str], ...]
    """Polynomials that the system requires to be positive."""
    relations: tuple[tuple[int, Poly], ...]
    """(index of the variable, polynomial that vanishes)."""


class CharacteristicPolynomial:
    """det(λ - A) of a family over Q: its Jacobian as expressions, with what its unknowns obey.

    Parameters
    ----------
    family
        The family.
    values
        Numbers of the family that are given, as rationals by name.
    budget
        Limits of the work.
    number
        Function from a double to the rational as which it is read.
    free
        Names of the variables; by default every number of the family without a value.
    numbers
        Function from numbers by name to family parameters and parameters, where `values` and `free`
        have other names than the family.
    spare
        Most functions (sines, roots) that are read as variables.

    Raises
    ------
    NotExact
        If the graph is not algebraic in functions of the variables, or too large.
    """

    constants = False
    """Whether functions of constants are variables too; otherwise irrational ones are refused."""
    bits = SAMPLE_BITS
    """Precision of the samples."""

    def __init__(
        self,
        family: Family,
        values: Mapping[str, Any],
        budget: Budget,
        number: Callable[[float], Any] = rational,
        *,
        free: Sequence[str] | None = None,
        numbers: Callable[[Mapping[str, Any]], Sequence[Sequence[Any]]] | None = None,
        spare: int = SPARE,
    ) -> None:
        self.family, self.values, self.budget, self.number = family, values, budget, number
        solved = () if family.closed else tuple(family.unknown)
        if free is None:
            names = (*family.at, *family.unknown, *family.parameters)
            closed = family.unknown if family.closed else ()
            self.base = tuple(n for n in names if n not in values and n not in closed)
        else:
            self.base = (*free, *solved)
        self.field = self._field_of([*self.base, "λ"], spare)
        symbols: dict[str, Any] = {n: self.field.number(v) for n, v in values.items()}
        symbols |= dict(zip(self.base, self.field.symbols, strict=False))
        if family.closed:
            symbols |= {n: self.field.number(number(v)) for n, v in family.unknown.items()}
        self.symbols = symbols
        """The numbers of a member as elements of the field, by name."""
        a, q = (
            ([symbols[n] for n in names] for names in (family.at, family.parameters))
            if numbers is None
            else numbers(symbols)
        )
        self.parts = [list(a), [symbols[n] for n in family.unknown], list(q)]
        """Family parameters, unknowns and parameters."""
        self.places = {self.base.index(n) for n in solved}
        """Indices of the unknowns that are solved for."""

    def _field_of(self, names: Sequence[str], spare: int) -> FunctionField:
        return FunctionField(names, self.budget, spare)

    @property
    def algebra(self) -> Algebra:
        """The algebra in which the graph is read."""
        return self.field.algebra if self.constants else EXACT

    def rows(self, program: Program) -> list[list[Any]]:
        """The first output of a program of the family's graph over the field, as rows."""
        try:
            return program.dense(self.algebra, self.parts)
        except ZeroDivisionError:
            raise NotExact("a denominator vanishes all along the family") from None

    @cached_property
    def place(self) -> list[list[Any]]:
        """States and parameters of a member as elements of the field, and the right angle."""
        family, system = self.family, self.family.system
        table = dict(self.symbols) | {
            n: v if isinstance(v, Upright) else self.field.number(self.number(v))
            for n, v in family.fixed.items()
        }
        return [[table[n] for n in names] for names in (system.states, system.parameters)]

    @cached_property
    def matrix(self) -> list[list[Any]]:
        """The Jacobian: rationals, and expressions in the indeterminates."""
        return self.rows(self.family.graph.matrix)

    @cached_property
    def equations(self) -> list[Expression]:
        """Expressions that vanish at a member: the equations of its unknowns."""
        if not self.places:
            return []
        return [self.element(row[0]) for row in self.rows(self.family.graph.residual)]

    @cached_property
    def determinant(self) -> Expression | None:
        """The determinant of algebraic equations, which is not zero at a member; None without."""
        if not self.family.system.algebraic:
            return None
        return self.element(self.rows(self.family.graph.determinant)[0][0])

    @cached_property
    def bound(self) -> set[int]:
        """Indices of the unknowns, and of the functions of them."""
        _ = self.matrix, self.determinant, self.conditions, self.equations  # each brings functions
        return {i for i in (*self.places, *self.field.meaning) if self.field.uses(i) & self.places}

    @cached_property
    def triangular(self) -> Triangular:
        """The equations of the unknowns on the branch of the typical members."""
        bound, numerators = self.bound, [e.num for e in self.equations]
        system = Triangular(self.field, numerators, bound, self.vanishes)
        system.settle()
        if self.determinant is not None:
            # a factor of it may cancel in the linearisation, and index 1 is lost all the same
            system.nonzero.append(self.field.reduced(system.value(self.determinant).num))
        return system

    @property
    def lam(self) -> int:
        """Index of λ."""
        return len(self.base)

    def element(self, value: Any) -> Expression:
        """A value of the graph as an expression."""
        return value if isinstance(value, Expression) else self.field.number(value)

    @cached_property
    def conditions(self) -> list[tuple[Expression, str]]:
        """What the system requires to be positive, as far as it is read, with its sentences."""
        system = self.family.system
        table: dict[str, Any] = {
            n: self.number(v) for n, v in self.family.fixed.items() if not isinstance(v, Upright)
        } | dict(self.symbols)
        out: list[tuple[Expression, str]] = []
        as_read = replace(EXACT, name="read", constant=self._constant)
        for condition in system.conditions:
            program = Program(ca.Function("condition", [system.x, system.p], [condition.value]))
            place = [
                [table.get(n, "upright") for n in names]
                for names in (system.states, system.parameters)
            ]
            try:
                value = program.run(as_read, place)[0][0]
            except (NotExact, TypeError, ZeroDivisionError):
                continue  # assumed nowhere: the result is then weaker, never wrong
            if isinstance(value, Expression):
                out.append((value, condition.sentence))
            elif not isinstance(value, str) and not value > 0:
                said = condition.refusal(float(value))
                raise NoMemberError(f"{self.family.name} has no member anywhere: {said}")
        return out

    def _constant(self, value: float) -> Any:
        return self.number(value) if np.isfinite(value) else EXACT.constant(value)

    # --- in factors ---

    @cached_property
    def entries(self) -> list[list[Expression]]:
        """The Jacobian on the branch of the typical members."""
        value = self.triangular.value
        return [[value(self.element(v)) for v in row] for row in self.matrix]

    @cached_property
    def required(self) -> list[tuple[Poly, str]]:
        """Polynomials that the system requires to be positive, each with its sentence."""
        values = [(self.triangular.value(v), sentence) for v, sentence in self._positive()]
        return [(self.field.reduced(v.num * v.den), sentence) for v, sentence in values]

    def _positive(self) -> list[tuple[Expression, str]]:
        return self.conditions

    @cached_property
    def factored(self) -> Factored:
        """The polynomial in factors over Q; `NotExact` where it grows beyond the budget."""
        zeros, irreducible = 0, []
        nonzero = list(self.triangular.nonzero)
        lam = self.field.generator(self.lam)
        for block in blocks_of(self.entries, lambda e: bool(e.num == 0)):
            common, powers = self.powers(block)
            nonzero.append(common)
            whole = sum((c * lam**k for k, c in enumerate(powers)), self.field.ring.constant(0))
            self.budget.watch(whole)
            for factor, count in factors(whole)[1]:
                if self.lam not in occurring(factor):
                    nonzero.append(factor)
                elif factor == lam:
                    zeros += count
                else:
                    irreducible.append((factor, count))
        nonzero += [e.den for row in self.entries for e in row]  # between the blocks too
        nonzero = [p for p in nonzero if not p.is_constant()]
        return self._compact(zeros, irreducible, nonzero, self.required)

    def powers(self, block: list[list[Expression]]) -> tuple[Poly, list[Poly]]:
        """The characteristic polynomial of a matrix of expressions.

        Returns
        -------
        common
            A common denominator of the entries.
        powers
            Coefficients of a multiple of det(λ - A), lowest first, without common factor.
        """
        one = self.field.one
        common = common_multiple((e.den for row in block for e in row), one)
        plain = [[e.num * (common / e.den) for e in row] for row in block]
        self.budget.expect(len(block), [common, *(p for row in plain for p in row)])
        if len(self.base) == 1 and not self.field.meaning:
            return common, self._over_integers(plain, common)
        coefficients = characteristic(
            [[Expression(self.field, p, one) for p in row] for row in plain]
        )
        powers = [self.element(c).num * common**k for k, c in enumerate(coefficients)]
        return common, primitive(self.triangular.reduce(powers))

    def _over_integers(self, plain: list[list[Poly]], common: Poly) -> list[Poly]:
        """The coefficients in one variable, over Z: products need no common denominators."""
        entries = [[univariate(p) for p in row] for row in plain]
        scale = reduce(fmpz.lcm, (p.denom() for row in entries for p in row), fmpz(1))
        coefficients = characteristic(
            [[(p * scale).numer() if p != 0 else 0 for p in r] for r in entries]
        )
        below = univariate(common) * scale
        powers = [fmpq_poly([c]) if isinstance(c, int) else fmpq_poly(c) for c in coefficients]
        powers = primitive([c * below**k for k, c in enumerate(powers)])
        x = self.field.generator(0)
        return [
            sum((a * x**i for i, a in enumerate(c.coeffs())), self.field.ring.constant(0))
            for c in powers
        ]

    def _compact(
        self,
        zeros: int,
        irreducible: Sequence[tuple[Poly, int]],
        nonzero: Sequence[Poly],
        required: Sequence[tuple[Poly, str]],
    ) -> Factored:
        """The same in a ring of the variables that occur."""
        kept = {i: self.field.generator(i) ** 2 - s for i, s in self.field.squares.items()}
        kept = dict(self.triangular.kept) | {
            i: f for i, f in kept.items() if i not in dict(self.triangular.kept)
        }
        polys = [*(f for f, _ in irreducible), *nonzero, *(p for p, _ in required)]
        used = set().union(*map(occurring, polys)) - {self.lam}
        while True:  # a variable brings the variables of its equation
            more = set().union(*(occurring(f) for f in kept.values() if occurring(f) & used)) - used
            if not more:
                break
            used |= more
        order = sorted(used)
        symbols = tuple(f"x{i}" for i in range(len(order) + 1))
        ring = fmpq_mpoly_ctx.get(symbols, Ordering.degrevlex)

        def moved(poly: Poly) -> Poly:
            terms = {
                tuple(int(row[i]) for i in (*order, self.lam)): c
                for row, c in poly.to_dict().items()
            }
            return ring.from_dict(terms)

        clean: list[Poly] = []
        ending: list[Poly] = []
        for poly in nonzero:
            some = [f for f, _ in factors(moved(poly))[1]]
            clean += [f for f in some if f not in clean]
            ending += [] if poly in self.triangular.crossed else some
        return Factored(
            tuple(self.name(i) for i in order),
            tuple(order),
            ring,
            zeros,
            tuple(
                (tuple(coefficient_row(moved(f), len(order))), count) for f, count in irreducible
            ),
            tuple(clean),
            tuple(f for f in clean if f not in ending),
            tuple((moved(p), s) for p, s in required),
            tuple((order.index(i), moved(f)) for i, f in kept.items() if occurring(f) <= used),
        )

    # --- members in balls ---

    @cached_property
    def samples(self) -> list[dict[int, Any]]:
        """Values of every indeterminate at typical members, as balls."""
        out = []
        names = (*self.family.at, *self.family.parameters)
        with precision(SAMPLE_BITS):
            for number in range(SAMPLES):
                point = dict(zip(names, sampled(self.family, number), strict=True))
                point |= {n: arb(v) for n, v in self.values.items()}
                out.append(self.member(point))
        return out

    def member(self, point: Mapping[str, Any]) -> dict[int, Any]:
        """Values of every indeterminate at a member, as balls at the current precision.

        Parameters
        ----------
        point
            Family parameters and parameters, rationals or balls by name.

        Raises
        ------
        NoMemberError
            If no root of the equations is proved there.
        """
        family = self.family
        a, q = ([arb(point[n]) for n in names] for names in (family.at, family.parameters))
        names = (*family.at, *family.unknown, *family.parameters)
        table = dict(zip(names, [*a, *ball_unknowns(family, a, q), *q], strict=True))
        return self.completed({i: table[n] for i, n in enumerate(self.base)})

    def completed(self, values: dict[int, Any]) -> dict[int, Any]:
        """Values with those of the functions added, as balls."""
        for index in sorted(self.field.meaning):
            values[index] = self.field.enclosed(index, values)
        return values

    def elsewhere(self, values: Mapping[int, Any]) -> int | None:
        """Index of an unknown that lacks its value on the branch of the samples, or None.

        Parameters
        ----------
        values
            Values of every indeterminate at a member, as balls.
        """
        for index, form in self.triangular.solved.items():
            value = arb(evaluate(form.num, values)) / arb(evaluate(form.den, values))
            if not value.overlaps(arb(values[index])):
                return index
        for index, equation in self.triangular.kept:
            if not arb(evaluate(equation, values)).contains(0):
                return index
        return None

    def vanishes(self, poly: Poly) -> bool | None:
        """Whether a polynomial is zero at every sample (True), at none (False), or else (None)."""
        if poly.is_constant():
            return bool(poly == 0)
        least = 2.0 ** (-self.bits // 4)
        with precision(self.bits):
            values = [arb(evaluate(poly, sample)) for sample in self.samples]
        if all(v.is_finite() and not v.contains(0) for v in values):
            return False
        return True if all(v.contains(0) and float(v.abs_upper()) < least for v in values) else None

    # --- names ---

    def text(self, x: Expression) -> str:
        """An expression as text that a computer algebra system reads."""
        top = text(x.num, self.name)
        if x.den.is_constant():
            return top
        bottom = text(x.den, self.name)
        top = f"({top})" if len(x.num) > 1 else top
        return f"{top}/({bottom})"

    @cached_property
    def _names(self) -> dict[int, str]:
        return {}

    def name(self, index: int) -> str:
        """Name of an indeterminate: sin(theta), sqrt(b), or with a number where it is long."""
        if index < len(self.base):
            return self.base[index]
        if index == self.lam:
            return "λ"
        if index not in self._names:
            function, x, over = self.field.meaning[index]
            inner = self.text(x)
            plain = len(inner) <= LONGEST and (over is None or over.is_constant())
            count = 1 + sum(n.startswith(f"{function}_") for n in self._names.values())
            self._names[index] = f"{function}({inner})" if plain else f"{function}_{count}"
        return self._names[index]


def text(poly: Poly, name: Callable[[int], str]) -> str:
    """A polynomial as text, highest term first.

    Parameters
    ----------
    poly
        The polynomial.
    name
        Function from the index of a variable to its name.
    """
    out = ""
    for exponents, c in poly.to_dict().items():
        powers = [name(i) + (f"**{int(e)}" if e > 1 else "") for i, e in enumerate(exponents) if e]
        size = abs(c)
        words = ([] if size == 1 and powers else [str(size)]) + powers
        sign = ("-" if c < 0 else "") if not out else (" - " if c < 0 else " + ")
        out += sign + "*".join(words)
    return out or "0"
