"""Jordan blocks of the eigenvalues that are zero by structure: how a disturbance in them grows.

With m zero eigenvalues in the n states that are kept, A^p has rank n - m from some power p on.  If
A itself has this rank, the zeros are semisimple and a disturbance stays; if A^p has more, it grows
at least like t^p.

Source: tests/systems/test_jordan.py.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import lru_cache
from typing import Any

import numpy as np
from flint import arb, fmpq, fmpq_mat

from ..algebra.exact.hurwitz_forms import TooLarge
from ..algebra.exact.number_fields import NotExact, vanishes
from ..algebra.number_types import balls, precision
from ..base.errors import NoMemberError, StabilityError
from ..base.verdict import Verdict, best
from ..systems.family import Family
from ..systems.structure.enclosure import ball_unknowns
from ..systems.structure.places import Pattern, nonzero
from ..systems.structure.structural_zeros import SAMPLE_BITS, sampled, structure
from .identities import MOST_STATES, FreePolynomial, constant_kernels, stored
from .member import READINGS, ROOT_BITS, Member

Rows = Sequence[Sequence[Any]]


def semisimple(family: Family, zeros: int) -> bool:
    """Whether the zero eigenvalues are proved to be semisimple at every member."""
    return most_power(family, zeros) == 0


def most_power(family: Family, zeros: int) -> int:
    """The largest power of time with which zero eigenvalues may let a disturbance grow.

    Returns
    -------
    int
        An upper bound that holds at every member; 0 where the zeros are semisimple.

    Examples
    --------
    >>> import casadi as ca, stability as st
    >>> x, p = ca.SX.sym("x", 3), ca.SX.sym("p")
    >>> chain = st.System("chain", x, p, ca.vertcat(x[1], 0, p * x[0] - x[2]),
    ...                   states=("x", "v", "z"), parameters=("p",))
    >>> most_power(st.Family(chain, "rest", at=("p",), held={"x": 0, "v": 0, "z": 0}), 2)
    1
    """
    count = zeros - len(family.idle)
    if count < 2:
        return 0
    sizes = kernels(family, count)
    enough = [p for p, size in enumerate(sizes) if size >= count]
    return min([*enough, count - max(sizes[0], 1)])


@lru_cache(maxsize=64)
def kernels(family: Family, count: int) -> tuple[int, ...]:
    """Dimensions of the kernels of A, A², …, A^count, each a lower bound at every member.

    Parameters
    ----------
    family
        The family; A is the linearisation of the states that it keeps.
    count
        Number of zero eigenvalues of A.
    """
    sizes = [_sparse(stored(family)[np.ix_(family.kept, family.kept)])] * count
    with suppress(ArithmeticError, StabilityError):
        free = FreePolynomial(family)
        directions = free.tangents - len(family.idle)
        matrix = kept_block(family, free.matrix)
        constant = constant_kernels(matrix, free.zero)
        least = max(directions, _sparse(nonzero(matrix, free.zero)), sizes[0])
        sizes = [max(size, least) for size in _extended(constant, count)]
        if sizes[0] < count and len(matrix) <= MOST_STATES:
            for p, whole in enumerate(_powers(matrix, count)):
                rank = rank_of(whole, lambda v: not vanishes(v))
                if not free.field.integral:  # a divisor of zero may have been a pivot
                    break
                sizes[p] = max(sizes[p], len(matrix) - rank)
                if sizes[p] >= count:
                    break
    return tuple(int(size) for size in np.maximum.accumulate(sizes))


def _extended(sizes: Sequence[int], count: int) -> list[int]:
    return [*sizes, *[max([*sizes, 0])] * count][:count]


def _sparse(places: Pattern) -> int:
    """Least dimension of the kernel for any values of the entries."""
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import structural_rank

    return len(places) - int(structural_rank(csr_array(places.astype(float))))


@lru_cache(maxsize=64)
def typical(family: Family, *, even: bool) -> Verdict:
    """The verdict of almost every member without growing eigenvalues.

    Parameters
    ----------
    family
        The family.
    even
        Whether its eigenvalues lie on the imaginary axis where none grows.

    Returns
    -------
    Verdict
        Drifting where a Jordan block is proved at one member, and so at almost all; undecided where
        nothing is proved.
    """
    zeros = structure(family).zeros
    if even or semisimple(family, zeros):
        return best(even=even)
    point, cut = sampled(family, 0), len(family.at)
    with suppress(NoMemberError), precision(SAMPLE_BITS):
        place = [point[:cut], ball_unknowns(family, point[:cut], point[cut:]), point[cut:]]
        kept = kept_block(family, family.graph.matrix.dense(balls(), place))
        if proved_power(kept, zeros - len(family.idle)):
            return Verdict.DRIFTING
    return Verdict.UNDECIDED


def zero_power(member: Member, zeros: int) -> int | None:
    """The power of time with which the zero eigenvalues of a member let a disturbance grow.

    Parameters
    ----------
    member
        The member.
    zeros
        Number of eigenvalues that vanish by structure; no other is zero.

    Returns
    -------
    int or None
        0 where the zeros are proved to be semisimple; the power where it is proved, or, in balls,
        a lower bound; None where nothing is proved.
    """
    count = zeros - len(member.family.idle)
    if semisimple(member.family, zeros):
        return 0
    for reading in READINGS:
        with suppress(NotExact, TooLarge, ZeroDivisionError):
            matrix, ground = reading(member)
            kept = kept_block(member.family, matrix)
            for p, whole in enumerate(_powers(kept, count)):
                if rank_of(whole, ground.sign) <= len(kept) - count:
                    return p
    return _power_in_balls(member, count)


def _power_in_balls(member: Member, count: int) -> int | None:
    """The largest power p for which balls prove that A^p has too large a rank, or None."""
    if member.near is not None and member.root is None:
        return None
    kept = kept_block(member.family, member.matrix_in_balls())
    with precision(ROOT_BITS):
        return proved_power(kept, count) or None


def proved_power(kept: Rows, count: int) -> int:
    """The largest power p for which balls prove that A^p has a rank above n - count; 0 for none."""
    most = 0
    for p, whole in enumerate(_powers(kept, count - 1)):
        if rank_of(whole, lambda v: not arb(v).contains(0)) <= len(kept) - count:
            break
        most = p + 1
    return most


def kept_block(family: Family, matrix: Rows) -> list[list[Any]]:
    """The entries of a linearisation between states that the family keeps."""
    return [[matrix[i][j] for j in family.kept] for i in family.kept]


def _powers(matrix: Rows, count: int) -> Any:
    """A, A², …, A^count, one after the other."""
    whole = [list(row) for row in matrix]
    if _over_q(matrix):
        yield from ((fmpq_mat(whole) ** p).tolist() for p in range(1, count + 1))
        return
    for p in range(count):
        yield whole
        if p + 1 < count:
            whole = [
                [
                    _sum(v * w for v, w in zip(row, column, strict=True))
                    for column in zip(*matrix, strict=True)
                ]
                for row in whole
            ]


def _over_q(matrix: Rows) -> bool:
    return bool(len(matrix)) and all(isinstance(v, (int, fmpq)) for row in matrix for v in row)


def _sum(terms: Any) -> Any:
    return sum(terms, start=0)


def rank_of(matrix: Rows, nonzero: Callable[[Any], Any]) -> int:
    """The number of pivots of an elimination.

    Parameters
    ----------
    matrix
        Numbers of one field, or balls.
    nonzero
        Whether a number is known to differ from zero.

    Returns
    -------
    int
        The rank where zeros are known; with balls a lower bound of it.

    Examples
    --------
    >>> from flint import fmpq
    >>> rank_of([[fmpq(1), fmpq(2)], [fmpq(2), fmpq(4)]], bool)
    1
    """
    if _over_q(matrix):
        return int(fmpq_mat(matrix).rank())
    rows, rank = [list(row) for row in matrix], 0
    while rows and rows[0]:
        places = (
            (i, j) for j in range(len(rows[0])) for i in range(len(rows)) if nonzero(rows[i][j])
        )
        i, j = next(places, (-1, -1))
        if i < 0:
            break
        first, rank = rows.pop(i), rank + 1
        pivot = first.pop(j)
        for row in rows:
            share = row.pop(j)
            if not (isinstance(share, int) and share == 0):
                row[:] = [v - share * w / pivot for v, w in zip(row, first, strict=True)]
    return rank
