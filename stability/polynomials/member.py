"""A member in exact numbers: its zeros by structure, and its eigenvalues on the imaginary axis.

Samples show how many eigenvalues vanish at the sampled members.  Such a count may fail on another
branch of steady motions, or where p in |p| has the other sign.  So a count is proved for the whole
family, as an identity of expressions, or otherwise exactly at the given member.

Balls never prove that two eigenvalues coincide, or that one lies on the axis next to others.  The
unknowns of an irrational member obey their equations exactly.  One algebraic unknown spans a number
field, in which every sign is decided.  Otherwise unknowns, and sines or other functions of these,
are indeterminates reduced by the equations: an expression that reduces to zero is zero at the
member, one whose ball excludes zero has the ball's sign, and any other leaves the verdict open.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from contextlib import suppress
from functools import cached_property
from math import prod
from typing import Any

from flint import arb, arb_poly, ctx, fmpq, fmpq_mat, fmpq_poly, fmpz, fmpz_mat

from ..algebra.exact.function_field import (
    MOST_TERMS,
    Expression,
    FunctionField,
    counted,
    evaluate,
)
from ..algebra.exact.hurwitz_forms import Budget, TooLarge
from ..algebra.exact.number_fields import (
    EXACT,
    Algebraic,
    NotExact,
    NumberField,
    rational,
    vanishes,
)
from ..algebra.exact.routh import Ground, on_the_axis_over
from ..algebra.number_types import balls, precision
from ..base.errors import NoMemberError, StabilityError
from ..base.verdict import Verdict
from ..systems.family import Family
from ..systems.structure.enclosure import ball_unknowns, matrix_polynomial
from ..systems.structure.places import LARGE, blocks_of, mirrored, nonzero, sparse_zeros
from .characteristic import CharacteristicPolynomial
from .identities import (
    MOST_STATES,
    identity,
    known_coefficients,
    whole_polynomial,
    with_symbols,
    zeros_and_parity,
)

# --- unknowns as exact numbers ---


MOST_DEGREE = 6
"""Largest degree of a number field that is recognised from digits."""


def exact_unknowns(
    family: Family,
    parameters: tuple[Sequence[Any], Sequence[Any]],
    root: list[Any],
    wide: list[Any],
) -> list[Any]:
    """The unknowns of a member as rationals or as elements of one number field, or `NotExact`.

    A number is recognised from its digits (integer relations: A. K. Lenstra, H. W. Lenstra,
    L. Lovász, Math. Ann. 261 (1982) 515-534), and then proved: the exact numbers solve the
    equations, and lie in the wide balls, which hold no other root.
    """
    simple = [_simplest(ball) for ball in root]
    if None not in simple and _solve(family, parameters, simple):
        return simple
    if len(root) == 1:
        with suppress(NotExact):
            return [_of_equation(family, parameters, root[0])]
    if None not in simple:
        raise NotExact("rationals that do not solve the equations")
    recognised = _recognised(root, simple, wide)
    if not _solve(family, parameters, recognised):
        raise NotExact("unknowns beyond one number field")
    return recognised


def _solve(family: Family, parameters: tuple[Sequence[Any], Sequence[Any]], u: list[Any]) -> bool:
    """Whether numbers solve the equations exactly."""
    try:
        residual, _ = family.graph.residual.run(EXACT, [parameters[0], u, parameters[1]])
    except ZeroDivisionError:
        return False
    return all(vanishes(r) for r in residual)


def _of_equation(family: Family, parameters: tuple[Sequence[Any], Sequence[Any]], ball: Any) -> Any:
    """A single unknown as an element of its number field over Q, from its own equation."""
    field = FunctionField(["u"])
    a, q = ([field.number(v) for v in some] for some in parameters)
    residual, _ = family.graph.residual.run(EXACT, [a, field.symbols, q])
    terms = residual[0].num.to_dict()
    if any(any(exponents[1:]) for exponents in terms):
        raise NotExact("an equation that is not algebraic")
    coefficients = [fmpq(0)] * (1 + max(int(e[0]) for e in terms))
    for exponents, coefficient in terms.items():
        coefficients[int(exponents[0])] = coefficient
    _, factors = fmpq_poly(coefficients).numer().factor()
    near = [f for f, _ in factors if arb_poly(f.coeffs())(ball).contains(0)]
    if len(near) != 1:
        raise NotExact("a root that two factors share")
    return NumberField(fmpq_poly(near[0].coeffs()), ball).generator


# --- from digits ---


def _recognised(root: list[Any], simple: list[Any], wide: list[Any]) -> list[Any]:
    """The unknowns over the field of the first that is not rational."""
    first = simple.index(None)
    field = _field(root[first])
    powers = [root[first] ** k for k in range(field.modulus.degree())]
    out = []
    for ball, number, room in zip(root, simple, wide, strict=True):
        if number is not None:
            out.append(number)
            continue
        *terms, denominator = _relation([*powers, ball])
        if not denominator:
            raise NotExact("an unknown of another field")
        poly = fmpq_poly([fmpq(-c, denominator) for c in terms])
        if not room.contains(arb_poly(poly)(root[first])):
            raise NotExact("an unknown of another field")
        out.append(Algebraic(field, field.reduced(poly)))
    return out


def _field(ball: Any) -> NumberField:
    """The number field of a number that is known to many digits."""
    for degree in range(2, MOST_DEGREE + 1):
        with suppress(NotExact):
            relation = fmpq_poly(_relation([ball**k for k in range(degree + 1)]))
            _, factors = relation.numer().factor()
            for factor, _ in factors:
                if _one_root(factor, ball):
                    return NumberField(fmpq_poly(factor.coeffs()), ball)
    raise NotExact("no number field of small degree")


def _one_root(poly: Any, ball: Any) -> bool:
    """Whether a ball is proved to hold one root of an irreducible polynomial, no more."""
    coefficients = poly.coeffs()
    with precision(2 * ctx.prec):
        f, slope = arb_poly(coefficients), arb_poly(coefficients).derivative()
        ends = f(ball.lower()), f(ball.upper())
        return bool((ends[0] * ends[1] < 0) and not slope(ball).contains(0))


def _relation(numbers: Sequence[Any]) -> list[Any]:
    """Small integers with a vanishing sum of products, as far as the digits show (LLL)."""
    # an exact number has digits without end, for which the library has no memory
    bits = min(ctx.prec, *(int(v.rel_accuracy_bits()) for v in numbers)) - 8
    if bits < 1:
        raise NotExact("too few digits")
    rows = []
    for i, v in enumerate(numbers):
        scaled = (v.mid() * arb(fmpz(1) << bits)).mid().floor().mid()
        rows.append([int(i == j) for j in range(len(numbers))] + [int(scaled.fmpq().p)])
    short = [int(c) for c in fmpz_mat(rows).lll().tolist()[0]]
    if sum(abs(c).bit_length() for c in short) > bits // 2:
        raise NotExact("no small relation")
    return short[:-1]


def _simplest(ball: Any) -> Any:
    """The rational of least denominator in a ball, by continued fractions; None if it is large."""
    before, here = (0, 1), (1, 0)  # numerators and denominators (p, q) of the convergents
    rest = ball.mid().fmpq()
    for _ in range(ctx.prec):
        whole = int(rest.floor())
        before, here = here, (whole * here[0] + before[0], whole * here[1] + before[1])
        convergent = fmpq(*here)
        if ball.contains(arb(convergent)):
            return convergent if here[1].bit_length() < ctx.prec // 3 else None
        rest = rest - whole
        if rest == 0:
            return None
        rest = 1 / rest
    return None


# --- a member ---


ROOT_BITS = 512
"""Precision of a root's enclosure, before the search for its exact form."""
LOCAL_BITS = 1024
"""Precision of the samples next to a given member."""
MOST_STEPS = 1000
"""Most operations of a linearisation that is read as an expression without need."""
OFFSETS = (40, 80, 120)
"""Exponents n of relative distances 2⁻ⁿ of these samples; the first on one branch is used."""


class Member:
    """A member at exact parameters, with the proved zeros of its characteristic polynomial.

    Parameters
    ----------
    family
        The family.
    a, q
        Family parameters and parameters as rationals, or as balls where irrational.  With balls
        only zeros at every member are proved.
    near
        Unknowns to double precision, shape (u,).
    """

    def __init__(
        self, family: Family, a: Sequence[Any], q: Sequence[Any], near: Sequence[float]
    ) -> None:
        self.family, self.a, self.q = family, list(a), list(q)
        self.enclosed_only = any(isinstance(v, arb) for v in (*a, *q))
        """Whether the numbers are known as balls only."""
        self.near = None if family.closed or not family.unknown else [float(v) for v in near]
        self._flags: list[bool] | None = None
        self._rational: list[Any] | None = None
        self._algebraic: list[Any] | None = None
        self._tried, self._bits = False, ctx.prec  # balls may decide without exact numbers
        self.root = self._enclosed_root()
        """The solved unknowns, to many digits; None without unknowns or where none is proved."""
        self.steady = self._rests()
        """Whether no rate is proved to differ from zero at the root of the solved equations."""

    @property
    def rational(self) -> list[Any] | None:
        """Coefficients of det(λ - A) over Q, lowest first, where they are rational."""
        self._try_exactly()
        return self._rational

    @property
    def algebraic(self) -> list[Any] | None:
        """The same over the number field of a single algebraic unknown, where it is one."""
        self._try_exactly()
        return self._algebraic

    def _try_exactly(self) -> None:
        if self._tried or not self.steady or self.enclosed_only:
            return
        self._tried = True
        with precision(self._bits):
            try:
                self._exact()
            except NotExact:
                self._flags = self._as_expressions()

    def _enclosed_root(self) -> list[Any] | None:
        if self.near is None:
            return None
        with precision(ROOT_BITS):
            try:
                return ball_unknowns(self.family, self.balls(self.a), self.balls(self.q), self.near)
            except (NoMemberError, ZeroDivisionError):  # raised again where the root is needed
                return None

    def _rests(self) -> bool:
        if self.root is None:
            return True
        with precision(ROOT_BITS):
            place = [self.balls(self.a), self.root, self.balls(self.q)]
            rates = self.family.graph.rates.dense(balls(), place)
        return all(arb(rates[i][0]).contains(0) for i in self.family.resting)

    def _exact(self) -> None:
        """The polynomial over Q, or over Q[u]/(g) where one unknown is algebraic."""
        # of numbers: without variables, the library's own polynomial of a matrix is the fastest
        matrix = self.matrix()
        if all(isinstance(entry, (int, fmpq)) for row in matrix for entry in row):
            blocks = [matrix] if len(matrix) <= LARGE else blocks_of(matrix)
            polynomials = [fmpq_mat(block).charpoly() for block in blocks]
            self._rational = poly = prod(polynomials, start=fmpq_poly([1])).coeffs()
        else:
            self._algebraic = poly = whole_polynomial(matrix)
        self._flags = [vanishes(c) for c in poly]

    def matrix(self) -> list[list[Any]]:
        """The linearisation as rationals or algebraic numbers.

        Raises
        ------
        NotExact
            If an entry is neither.
        """
        place = [self.a, self.unknowns(), self.q]
        try:
            return self.family.graph.matrix.dense(EXACT, place)
        except (ZeroDivisionError, StabilityError) as error:
            raise NotExact(str(error)) from None

    def unknowns(self) -> list[Any]:
        """The unknowns as rationals or algebraic numbers.

        Raises
        ------
        NotExact
            If they are neither.
        """
        if self.near is None:
            return [rational(v) for v in self.family.unknown.values()]
        if self.root is None:
            raise NotExact("no root is proved")
        with precision(ROOT_BITS // 2):  # a wider ball, which holds no other root either
            wide = ball_unknowns(self.family, self.balls(self.a), self.balls(self.q), self.near)
        with precision(ROOT_BITS):
            return exact_unknowns(self.family, (self.a, self.q), self.root, wide)

    @staticmethod
    def balls(values: Sequence[Any]) -> list[Any]:
        """Rationals as balls at the current precision."""
        return [arb(v) for v in values]

    @property
    def flags(self) -> list[bool]:
        """Whether each coefficient of det(λ - A), lowest first, is proved to be zero."""
        self._try_exactly()
        if self._flags is None:
            self._flags = self._as_expressions()
        return self._flags

    def _as_expressions(self) -> list[bool]:
        """Flags of the coefficients, with sines, roots and unknowns as indeterminates."""
        family = self.family
        proved, size = identity(family), len(family.system.states)
        structural = known_coefficients(size, proved.zeros, even=proved.even)
        large = size > MOST_STATES or family.graph.matrix.size > MOST_STEPS
        if self.enclosed_only or (large and self._all_known(structural)):
            return structural
        flags = structural
        with suppress(NotExact, StabilityError):
            matrix = MemberPolynomial(self, counted()).matrix
            places = nonzero(matrix)
            flags = known_coefficients(size, sparse_zeros(places), even=mirrored(places))
            blocks = with_symbols(blocks_of(matrix), vanishes)
            count, even = zeros_and_parity(blocks, vanishes)
            more = known_coefficients(size, count, even=even)
            flags = [o or m for o, m in zip(flags, more, strict=True)]
            poly = whole_polynomial(matrix)
            flags = [o or vanishes(c) for o, c in zip(flags, poly, strict=True)]
            if self.has_value():  # entries such as √2, whose products are rational
                self._rational = [_plain(c) for c in poly]
        return [k or o for k, o in zip(structural, flags, strict=True)]

    def _all_known(self, flags: list[bool]) -> bool:
        """Whether every coefficient that is not known to be zero is proved nonzero by balls."""
        self._flags = flags  # `enclosed` reads them
        try:
            with precision(ROOT_BITS):
                return not any(c.contains(0) for c in self.enclosed() if not c == 0)
        except NoMemberError:
            return False
        finally:
            self._flags = None

    def has_value(self) -> bool:
        """Whether a root is proved, and balls there are finite: the rules of √ hold for √-2 too."""
        if self.near is not None and self.root is None:
            return False
        return all(arb(e).is_finite() for row in self.matrix_in_balls() for e in row)

    def unknowns_in_balls(self) -> list[Any]:
        """The root that is proved, or the guess that needs no proof."""
        return self.root or self.balls([rational(v) for v in self.family.unknown.values()])

    def matrix_in_balls(self) -> list[list[Any]]:
        """The linearisation in balls of `ROOT_BITS`, at a root that is proved or needs no proof."""
        with precision(ROOT_BITS):
            place = [self.balls(self.a), self.unknowns_in_balls(), self.balls(self.q)]
            matrix: list[list[Any]] = self.family.graph.matrix.dense(balls(), place)
        return matrix

    def enclosed(self) -> list[Any]:
        """Coefficients as balls at the current precision; proved zeros are exact.

        Raises
        ------
        NoMemberError
            If no root is proved to exist.
        """
        if self.rational is not None:
            return self.balls(self.rational)
        a, q = self.balls(self.a), self.balls(self.q)
        poly = matrix_polynomial(self.family, a, ball_unknowns(self.family, a, q, self.near), q)
        return [arb(0) if flag else c for flag, c in zip(self.flags, poly, strict=True)]

    @property
    def reached(self) -> bool:
        """Whether the root is proved or needs no proof, and no rate differs from zero there."""
        return self.steady and (self.near is None or self.root is not None)

    def plainly_enclosed(self) -> list[Any] | None:
        """Coefficients as balls at the current precision, no zero proved; None without a root."""
        if not self.reached:
            return None
        a, q = self.balls(self.a), self.balls(self.q)
        return matrix_polynomial(self.family, a, self.unknowns_in_balls(), q)

    def seems_zero(self, power: int, bits: int) -> bool:
        """Whether the first coefficient without a proof of zero cannot be told from zero.

        Parameters
        ----------
        power
            Number of coefficients left out.
        bits
            Precision of the balls.
        """
        with precision(bits), suppress(NoMemberError):
            return bool(next(c for c in self.enclosed()[power:] if not c == 0).contains(0))
        return False

    def zeros(self) -> int:
        """Number of eigenvalues proved zero at this member: a lower bound unless all is exact."""
        return next(i for i, flag in enumerate(self.flags) if not flag)

    @cached_property
    def structural(self) -> tuple[int, int]:
        """Least and largest number of eigenvalues that are zero here and at the members nearby.

        Zeros at this member are proved.  Both numbers agree except where no neighbourhood of the
        member is reached, or where a coefficient nearby is too small to prove it nonzero.
        """
        count = self.zeros()
        if self.enclosed_only:
            return count, count
        low, high = _generic(self.family, self.a, self.q, self.near) if count else (0, 0)
        return min(count, low), min(count, high)


def _generic(
    family: Family, a: Sequence[Any], q: Sequence[Any], near: Sequence[float] | None
) -> tuple[int, int]:
    """Least and largest number of eigenvalues that vanish at nearby members on the same branch."""
    with precision(LOCAL_BITS):
        for offset in OFFSETS:
            step = fmpq(1, 2**offset)
            wide = [arb(v) + arb(0, arb((abs(v) + step) * step)) for v in (*a, *q)]
            try:  # one root for the whole neighbourhood: the samples lie on the branch
                ball_unknowns(family, wide[: len(a)], wide[len(a) :], near)
                counts = [_sampled(family, a, q, near, step, turn) for turn in range(3)]
            except (NoMemberError, ZeroDivisionError):
                continue
            return min(low for low, _ in counts), min(high for _, high in counts)
    return identity(family).zeros, len(family.system.states)


def _sampled(
    family: Family, a: Sequence[Any], q: Sequence[Any], near: Any, step: Any, turn: int
) -> tuple[int, int]:
    """Number of eigenvalues proved zero at a nearby member, and number of those that may be."""
    place = []
    for index, v in enumerate((*a, *q)):
        share = fmpq(16 + (13 * turn + 7 * index) % 33, 64)  # between 1/4 and 3/4
        if turn == 1 or (turn == 2 and index % 2):  # both sides of a kink such as that of |p|
            share = -share
        place.append(v + share * (abs(v) + step) * step)
    member = Member(family, place[: len(a)], place[len(a) :], near or [])
    low = member.zeros()
    if member.rational is not None:  # exact, however small a coefficient is
        return low, low
    return low, next(i for i, c in enumerate(member.enclosed()) if not c.contains(0))


def _plain(value: Any) -> Any:
    """A coefficient as a rational; `NotExact` where it has indeterminates."""
    return fmpq(value) if isinstance(value, (int, fmpq)) else value.plain()


# --- eigenvalues on the imaginary axis ---


MOST_SECONDS = 20.0
"""Longest work with expressions at one member; the verdict is then left open."""


def exact_verdict(member: Member, zeros: int) -> Verdict | None:
    """The verdict of a member without some zero eigenvalues, over the member's own field.

    Returns
    -------
    Verdict or None
        None where no proof is found.
    """
    large = member.algebraic is None and len(member.family.system.states) > MOST_STATES
    if large or member.enclosed_only or not member.has_value():
        return None
    for reading in READINGS:
        try:
            matrix, ground = reading(member)
            algebraic = member.algebraic if reading is _over_number_field else None
            coefficients = algebraic or whole_polynomial(matrix)
            nonzero = next(i for i, c in enumerate(coefficients) if ground.sign(c))
            # a zero that is proved here alone may be structural, and would have to be left out
            if zeros <= nonzero == member.zeros():
                return on_the_axis_over(ground, coefficients[zeros:])
        except (NotExact, TooLarge, ZeroDivisionError):
            continue
    return None


class MemberPolynomial(CharacteristicPolynomial):
    """The polynomial of one member: its unknowns are variables, modulo their equations."""

    constants = True
    bits = ROOT_BITS

    def __init__(self, member: Member, budget: Budget) -> None:
        family = member.family
        values = dict(zip((*family.at, *family.parameters), (*member.a, *member.q), strict=True))
        super().__init__(family, values, budget, free=())
        self._unknowns = member.unknowns_in_balls

    @property
    def conditions(self) -> list[tuple[Expression, str]]:
        """None: the member was found."""
        return []

    @cached_property
    def samples(self) -> list[dict[int, Any]]:
        """The member alone."""
        with precision(ROOT_BITS):
            return [_Enclosed(self.field, enumerate(self._unknowns()))]

    def tidy(self, entry: Any) -> Any:
        """An entry modulo the equations of the unknowns."""
        if not isinstance(entry, Expression):
            return entry
        entry = self.triangular.value(entry)
        return self.field.quotient(*self.triangular.reduce([entry.num, entry.den]))

    def sign(self, entry: Any) -> int:
        """The sign of an entry, 0 where it vanishes modulo the equations."""
        if not isinstance(entry, Expression):
            return int(entry > 0) - int(entry < 0)
        entry = self.tidy(entry)
        if entry.num == 0:
            return 0
        with precision(ROOT_BITS):
            num, den = (arb(evaluate(p, self.samples[0])) for p in (entry.num, entry.den))
        return _sign(num / den)


def _over_number_field(member: Member) -> tuple[list[list[Any]], Ground]:
    """The linearisation over Q, or over Q[u]/(g)."""
    if member.algebraic is None and member.rational is None:
        raise NotExact("no single algebraic unknown")

    def sign(value: Any) -> int:
        if not isinstance(value, Algebraic):
            return int(value > 0) - int(value < 0)
        with precision(ROOT_BITS):
            return 0 if value.poly == 0 else _sign(arb_poly(value.poly)(value.field.root))

    return member.matrix(), Ground(sign, lambda value: value)


def _over_expressions(member: Member) -> tuple[list[list[Any]], Ground]:
    """The linearisation with unknowns and functions as indeterminates, modulo their equations."""
    polynomial = MemberPolynomial(member, Budget(MOST_TERMS, MOST_SECONDS))
    matrix = [[polynomial.tidy(entry) for entry in row] for row in polynomial.matrix]
    return matrix, Ground(polynomial.sign, polynomial.tidy)


READINGS = _over_number_field, _over_expressions
"""Linearisations of a member in exact numbers with signs, the cheaper first."""


def _sign(ball: Any) -> int:
    if ball > 0 or ball < 0:
        return 1 if ball > 0 else -1
    raise NotExact("a sign that the balls leave open")


class _Enclosed(dict[int, Any]):
    """Balls of indeterminates; those of functions are found when they are asked for."""

    def __init__(self, field: FunctionField, values: Iterable[tuple[int, Any]]) -> None:
        super().__init__(values)
        self._field = field

    def __missing__(self, index: int) -> Any:
        self[index] = self._field.enclosed(index, self)
        return self[index]
