"""Eigenvalues that are zero by structure: their number, and a proof at a member.

Samples show how many eigenvalues vanish at the sampled members.  Such a count may fail on another
branch of steady motions, or where p in |p| has the other sign.  So a count is proved for the whole
family, as an identity of expressions, or otherwise exactly at the given member.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from functools import cached_property
from typing import Any

from flint import arb, ctx, fmpq, fmpq_mat

from ...algebra.exact.function_field import FunctionField
from ...algebra.exact.number_fields import (
    NotExact,
    rational,
    vanishes,
)
from ...algebra.number_types import balls, precision
from ...base.errors import NoMemberError
from ..family import Family
from . import pattern
from .enclosure import ball_unknowns, matrix_polynomial
from .entries import with_symbols
from .exact_unknowns import exact_unknowns
from .identities import (
    MOST_STATES,
    blocks_of,
    exact_matrix,
    nonzero,
    whole_polynomial,
    zeros_and_parity,
)
from .identities import certain as certain
from .identities import identity as identity
from .identities import symmetric as symmetric

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
        matrix = exact_matrix(self.family, self.a, self.unknowns(), self.q)
        if all(isinstance(entry, (int, fmpq)) for row in matrix for entry in row):
            self._rational = poly = fmpq_mat(matrix).charpoly().coeffs()
        else:
            self._algebraic = poly = whole_polynomial(matrix)
        self._flags = [vanishes(c) for c in poly]

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
        known = pattern.known_coefficients(size, proved.zeros, even=proved.even)
        large = size > MOST_STATES or family.graph.matrix.size > MOST_STEPS
        if self.enclosed_only or (large and self._all_known(known)):
            return known
        field = FunctionField([*family.unknown])
        given = [[field.number(v) for v in some] for some in (self.a, self.q)]
        own = known
        with suppress(NotExact):
            matrix = exact_matrix(family, given[0], field.symbols, given[1])
            places = nonzero(matrix)
            own = pattern.known_coefficients(
                size, pattern.zeros(places), even=pattern.mirrored(places)
            )
            blocks = with_symbols(blocks_of(matrix), vanishes)
            count, even = zeros_and_parity(blocks, vanishes)
            more = pattern.known_coefficients(size, count, even=even)
            own = [o or m for o, m in zip(own, more, strict=True)]
            poly = whole_polynomial(matrix)
            own = [o or vanishes(c) for o, c in zip(own, poly, strict=True)]
            if self.has_value():  # entries such as √2, whose products are rational
                self._rational = [_plain(c) for c in poly]
        return [k or o for k, o in zip(known, own, strict=True)]

    def _all_known(self, known: list[bool]) -> bool:
        """Whether every coefficient that is not known to be zero is proved nonzero by balls."""
        self._flags = known  # `enclosed` reads them
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

    def matrix_in_balls(self) -> list[list[Any]]:
        """The linearisation in balls of `ROOT_BITS`, at a root that is proved or needs no proof."""
        with precision(ROOT_BITS):
            root = self.root or self.balls([rational(v) for v in self.family.unknown.values()])
            place = [self.balls(self.a), root, self.balls(self.q)]
            found: list[list[Any]] = self.family.graph.matrix.dense(balls(), place)
        return found

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

    def plainly_enclosed(self) -> list[Any] | None:
        """Coefficients as balls at the current precision, no zero proved; None without a root."""
        if not self.steady or (self.near is not None and self.root is None):
            return None
        root = self.root or self.balls([rational(v) for v in self.family.unknown.values()])
        return matrix_polynomial(self.family, self.balls(self.a), root, self.balls(self.q))

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
                found = [_sampled(family, a, q, near, step, turn) for turn in range(3)]
            except (NoMemberError, ZeroDivisionError):
                continue
            return min(low for low, _ in found), min(high for _, high in found)
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
