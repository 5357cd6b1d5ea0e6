"""A linearisation without its structural zeros, each entry with a bound on its error.

Structural zeros are removed through null vectors, never by size: first the family's tangents, then
null vectors of the remaining matrix, as many as the family's structure has.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..algebra.linear_systems import contraction, inverse_of, null_vector, solve
from ..algebra.program import Program
from ..algebra.running_error import TINY, UNIT, RunningError, ball_arrays, running_error_arrays
from ..base.types import Floats, Record
from ..base.verdict import CODES, Verdict
from ..polynomials.member import Member
from ..systems.family import Family
from ..systems.structure.structural_zeros import structure

Reader = Callable[[Program], list[tuple[Floats, Floats]]]
"""From a program of a family's graph to its outputs at members, each with a bound on its error."""


def drift_powers(
    family: Family, a: Floats, q: Floats, u: Floats, zeros: int, roundings: Sequence[int] | None
) -> NDArray[np.int8]:
    """The power of time with which structural zeros are proved to let a disturbance grow.

    Parameters
    ----------
    family
        The family.
    a, q, u
        Family parameters, parameters and unknowns, shapes (N, ·).
    zeros
        Number of eigenvalues that vanish by structure.
    roundings
        As for `stability.spectra.deflation.deflate`.

    Returns
    -------
    ndarray of int
        Lower bounds, shape (N,); 0 means no proof of growth.

    Source: G. W. Stewart & J. Sun, Matrix Perturbation Theory (1990), for Weyl's inequality.

    Examples
    --------
    >>> import casadi as ca, stability as st
    >>> x = ca.SX.sym("x", 3)
    >>> free = st.System("free", x, ca.SX(0, 1), ca.vertcat(x[1], 0, -x[2]),
    ...                  states=("x", "v", "z"), parameters=())
    >>> rest = st.Family(free, "rest", at=("x",), held={"v": 0.0, "z": 0.0})
    >>> st.spectrum(rest, at=1.0).verdict.word
    'drifting'
    """
    powers = np.zeros(len(a), dtype=np.int8)
    count = zeros - len(family.idle)
    with np.errstate(all="ignore"):
        matrix, error = tracked_matrix(family, a, q, u, roundings)
        if family.idle:  # the other states are a system of their own
            kept = np.array(family.kept, dtype=np.intp)
            pick = np.ix_(np.arange(len(a)), kept, kept)
            matrix, error = matrix[pick], error[pick]
        n = matrix.shape[-1]
        whole, doubt, left = matrix, error, np.ones(len(a), dtype=bool)
        for power in range(1, count):
            left &= _has_rank(whole, doubt, n - count + 1)
            powers[left] = power
            if not left.any() or power + 1 == count:
                break
            size, reach = np.abs(matrix), np.abs(whole)
            doubt = doubt @ (size + error) + reach @ error + 2 * n * UNIT * (reach @ size)
            whole, doubt = whole @ matrix, 1.01 * doubt + n * TINY
    return powers


def drifting(codes: NDArray[np.int8], powers: NDArray[np.int8]) -> None:
    """Say *drifting* of stable members whose zeros are proved to form a Jordan block.

    Parameters
    ----------
    codes
        Flag values, shape (N,), changed in place; a stable member without this proof is left open.
    powers
        From `drift_powers`, for a family whose zeros are not proved to be semisimple.
    """
    stable = codes == CODES[Verdict.STABLE]
    codes[stable] = CODES[Verdict.UNDECIDED]
    codes[stable & (powers > 0)] = CODES[Verdict.DRIFTING]


def _has_rank(matrix: Floats, error: Floats, rank: int) -> NDArray[np.bool_]:
    """Whether matrices within the error are proved to have at least this rank."""
    for axis in (2, 1):  # rows and columns of like size, by powers of two: exact, same rank
        size = np.abs(matrix).max(axis=axis, keepdims=True)
        scale = np.exp2(-np.round(np.log2(np.where(size > 0, size, 1.0))))
        matrix, error = matrix * scale, error * scale
    sound = np.isfinite(matrix).all(axis=(1, 2)) & np.isfinite(error).all(axis=(1, 2))
    proved = np.zeros(len(matrix), dtype=bool)
    if sound.any():
        n = matrix.shape[-1]
        sizes = np.linalg.svd(matrix[sound], compute_uv=False)
        noise = np.sqrt((error[sound] ** 2).sum(axis=(1, 2))) + 8 * n * UNIT * sizes[:, 0]
        proved[sound] = sizes[:, rank - 1] > 2 * noise
    return proved


class Deflation(NamedTuple):
    """One structural zero removed by a similarity with multipliers of at most 1."""

    order: NDArray[np.intp]
    """Order of the coordinates, the removed one first, shape (N, n)."""
    multipliers: Floats
    """Null vector below its first entry, which is 1, shape (N, n - 1)."""
    doubt: Floats
    """Bound on the error of the multipliers, shape (N, n - 1)."""
    row: Floats
    """Row of the removed coordinate: its rate by the other coordinates, shape (N, n - 1)."""


class Reduced(NamedTuple):
    """A linearisation without its structural zeros."""

    matrix: Floats
    """The reduced linearisation, shape (N, m, m)."""
    error: Floats
    """Bound on the error of each entry, shape (N, m, m)."""
    steps: list[Deflation]
    """Steps of the removal in order, from which modes are lifted back."""
    supported: NDArray[np.intp]
    """Number of first removed eigenvalues that are zero within their rounding, shape (N,)."""


@dataclass(frozen=True, eq=False)
class MemberNumbers(Record):
    """Dimensionless numbers from which the linearisation of members is computed."""

    a: Floats
    """Family parameters, shape (N, ·)."""
    q: Floats
    """Parameters, shape (N, ·)."""
    u: Floats
    """Unknowns, shape (N, ·)."""
    rate: Floats
    """Unit of rate, shape (N,) [1/s, or √(g/R)]."""
    roundings: tuple[int, ...]
    """Number of roundings in each column of a and q."""

    def __getitem__(self, rows: slice) -> MemberNumbers:
        a, q, u = self.a[rows], self.q[rows], self.u[rows]
        return MemberNumbers(a, q, u, self.rate[rows], self.roundings)

    def reduced(self, family: Family, zeros: int, *, watch: bool = False) -> Reduced:
        """The linearisation without structural zeros."""
        return deflate(family, self.a, self.q, self.u, self.roundings, zeros, watch)


def deflate(
    family: Family,
    a: Floats,
    q: Floats,
    u: Floats | None = None,
    roundings: Sequence[int] | None = None,
    zeros: int | None = None,
    watch: bool = False,
) -> Reduced:
    """Linearise at members and remove the structural zeros.

    Parameters
    ----------
    family
        The family.
    a, q
        Family parameters and parameters, dimensionless, shapes (N, ·).
    u
        Unknowns from `family.solve`, shape (N, ·), or None.
    roundings
        Number of roundings in each column of a and q; 0 when left out.
    zeros
        Number of zero eigenvalues to remove; the family's structural zeros when left out.
    watch
        Whether to compare each removed zero with its rounding; if not, all count as supported.

    Returns
    -------
    Reduced
    """
    u = family.solve(a, q) if u is None else u
    with np.errstate(all="ignore"):  # `eigenvalues` refuses matrices that are not finite
        count = structure(family).zeros if zeros is None else zeros
        rounding_counts = roundings or [0] * (a.shape[1] + q.shape[1])
        arguments = _arguments(family, a, q, u, rounding_counts)
        read = partial(running_error_arrays, arguments=arguments, shape=a.shape[:1])
        return _linearised(family, read, len(a), count, watch)


def deflated(member: Member, zeros: int) -> Reduced:
    """As `deflate`, for one member in balls at the current precision."""
    place = [member.balls(member.a), member.unknowns_in_balls(), member.balls(member.q)]
    with np.errstate(all="ignore"):
        return _linearised(member.family, partial(ball_arrays, arguments=place), 1, zeros, False)


def _linearised(family: Family, read: Reader, count: int, zeros: int, watch: bool) -> Reduced:
    matrix, error = read(family.graph.matrix)[0]
    steps: list[Deflation] = []
    sound: list[NDArray[np.bool_]] = []
    states = list(family.system.states)
    for name in family.idle[:zeros]:  # no other rate depends on it: no rounding at all
        matrix, error = _dropped(matrix, error, states.index(name), steps)
        states.remove(name)
        sound.append(np.ones(count, dtype=bool))
    left = zeros - len(steps)
    along = min(left, family.tangents)
    tangents, doubts = tangent_vectors(family, read) if along else (matrix, error)
    for index in range(along):
        vector, doubt = _push(tangents[..., index], doubts[..., index], steps)
        matrix, error, within = _deflate(matrix, error, vector, doubt, steps, watch)
        sound.append(within)
    for _ in range(left - along):
        if not np.isfinite(matrix).all():
            break
        vector, doubt = null_vector(matrix, error)
        matrix, error, within = _deflate(matrix, error, vector, doubt, steps, watch)
        sound.append(within)
    supported = np.cumprod(np.array(sound, dtype=int).reshape(len(sound), count), axis=0)
    return Reduced(matrix, error, steps, supported.sum(axis=0))


def _dropped(
    matrix: Floats, error: Floats, index: int, steps: list[Deflation]
) -> tuple[Floats, Floats]:
    """The linearisation without a state that no remaining rate depends on: e is a null vector."""
    count, size = matrix.shape[:2]
    kept = np.delete(np.arange(size), index)
    order = np.tile(np.concatenate([[index], kept]).astype(np.intp), (count, 1))
    none = np.zeros((count, size - 1))
    steps.append(Deflation(order, none, none, matrix[:, index, kept]))
    pick = np.ix_(np.arange(count), kept, kept)
    return matrix[pick], error[pick]


def _arguments(
    family: Family, a: Floats, q: Floats, u: Floats, roundings: Sequence[int]
) -> list[list[RunningError]]:
    """Family parameters, unknowns and parameters, each with its error."""
    cut = a.shape[1]
    parameters = [_rounded(a, roundings[:cut]), _rounded(q, roundings[cut:])]
    doubt = _root_error(family, parameters, u)
    return [
        parameters[0],
        [RunningError(c, e) for c, e in zip(u.T, doubt.T, strict=True)],
        parameters[1],
    ]


def tracked_matrix(
    family: Family, a: Floats, q: Floats, u: Floats, roundings: Sequence[int] | None
) -> tuple[Floats, Floats]:
    """The linearisation at members, and a bound on the error of each entry.

    Returns
    -------
    matrix, error
        Shape (N, n, n) each.
    """
    arguments = _arguments(family, a, q, u, roundings or [0] * (a.shape[1] + q.shape[1]))
    return running_error_arrays(family.graph.matrix, arguments, a.shape[:1])[0]


def _rounded(block: Floats, roundings: Sequence[int]) -> list[RunningError]:
    return [RunningError(c, n * UNIT * np.abs(c)) for c, n in zip(block.T, roundings, strict=True)]


def _root_error(family: Family, parameters: list[list[RunningError]], u: Floats) -> Floats:
    """Bound on the error of the solved unknowns, by Krawczyk's test to first order.

    The inverse slope turns the residual into a reach.  Where the slope changes too much within this
    reach, as near a double root, the bound is infinite.
    """
    if not u.shape[1] or family.closed:
        return np.zeros_like(u)
    exact = [RunningError(c, np.zeros_like(c)) for c in u.T]
    residual, slope = running_error_arrays(
        family.graph.residual, [parameters[0], exact, parameters[1]], (len(u),)
    )
    inverse = inverse_of(slope[0])
    size = np.abs(residual[0]) + residual[1]
    reach: Floats = 2.01 * (np.abs(inverse) @ size)[..., 0] + 2 * UNIT * np.abs(u)
    wide = [RunningError(c, e) for c, e in zip(u.T, reach.T, strict=True)]
    _, over = running_error_arrays(
        family.graph.residual, [parameters[0], wide, parameters[1]], (len(u),)
    )
    change = contraction(inverse, slope[0], over[1] + np.abs(over[0] - slope[0]))
    return np.where((change.sum(axis=-1).max(axis=-1) < 0.5)[:, None], reach, np.inf)


def tangent_vectors(family: Family, read: Reader) -> tuple[Floats, Floats]:
    """Tangents of the family and a bound on their error, which grows where the equations fold.

    Near a branch point the slope of the unknowns is a quotient of two small numbers.  Its error is
    then far above a few roundings and must enter the error discs.
    """
    by_a, by_u, _, r_u, r_a = read(family.graph.tangent)
    tangent, error = by_a
    if family.unknown and not family.closed:
        slope, doubt = solve(*r_u, *r_a)
        size, absolute = np.abs(by_u[0]), np.abs(slope)
        tangent = tangent - by_u[0] @ slope
        carried = (size + by_u[1])[..., :, :, None] * doubt[..., None, :, :]
        carried[(size == 0) & (by_u[1] == 0)] = 0.0  # no share of an infinite doubt
        error = error + carried.sum(axis=-2) + by_u[1] @ absolute
        error += 4 * (len(family.unknown) * UNIT * (size @ absolute + np.abs(tangent)) + TINY)
    keep = list(family.moved)
    return tangent[..., keep], error[..., keep]


def _push(vector: Floats, doubt: Floats, steps: Sequence[Deflation]) -> tuple[Floats, Floats]:
    """A vector of the full space, and its error, in the coordinates after the given steps."""
    for step in steps:
        ordered = np.take_along_axis(vector, step.order, axis=1)
        unsure = np.take_along_axis(doubt, step.order, axis=1)
        size, first = np.abs(step.multipliers), np.abs(ordered[:, :1])
        vector = ordered[:, 1:] - step.multipliers * ordered[:, :1]
        doubt = unsure[:, 1:] + size * unsure[:, :1] + step.doubt * first
        doubt = doubt + 2 * (UNIT * (np.abs(vector) + size * first) + TINY)
    return vector, doubt


def lowered(vectors: Floats, steps: Sequence[Deflation]) -> Floats:
    """Deviations from members in the coordinates of their reduced linearisations.

    Parameters
    ----------
    vectors
        Shape (N, n).
    steps
        Steps of the removal, as in `Reduced`.

    Returns
    -------
    ndarray
        Shape (N, m).
    """
    return _push(vectors, np.zeros_like(vectors), steps)[0]


def _deflate(
    matrix: Floats,
    error: Floats,
    vector: Floats,
    doubt: Floats,
    steps: list[Deflation],
    watch: bool,
) -> tuple[Floats, Floats, NDArray[np.bool_]]:
    """Remove one null vector: B = A[1:, 1:] - m ⊗ A[0, 1:] with its largest entry first.

    Returns B, the error of its entries, and whether A v is zero within its rounding.
    """
    count, size = vector.shape
    pivot = np.abs(vector).argmax(axis=1)
    order = np.tile(np.arange(size), (count, 1))
    order[np.arange(count), pivot] = 0
    order[:, 0] = pivot
    if (pivot == pivot[:1]).all():  # one order for all rows: plain slices, no gathering
        pick = np.ix_(np.arange(count), order[0], order[0])
        matrix, error = matrix[pick], error[pick]
    else:
        for axis in (1, 2):
            index = order[:, :, None] if axis == 1 else order[:, None, :]
            matrix = np.take_along_axis(matrix, index, axis=axis)
            error = np.take_along_axis(error, index, axis=axis)
    vector = np.take_along_axis(vector, order, axis=1)
    doubt = np.take_along_axis(doubt, order, axis=1)
    m = vector[:, 1:] / vector[:, :1]
    least = np.abs(vector[:, :1]) - doubt[:, :1]  # the pivot of the true vector may be zero
    least = np.where(least > 0, least, 0.0)
    m_error = (doubt[:, 1:] + np.abs(m) * doubt[:, :1]) / least + UNIT * np.abs(m)
    row, row_error = matrix[:, 0, 1:], error[:, 0, 1:]
    product = m[:, :, None] * row[:, None, :]
    reduced = matrix[:, 1:, 1:] - product
    size_product = np.abs(product)
    bound = (
        error[:, 1:, 1:]
        + m_error[:, :, None] * (np.abs(row) + row_error)[:, None, :]
        + np.abs(m)[:, :, None] * row_error[:, None, :]
        + UNIT * (size_product + np.abs(reduced))
        + 2 * TINY
    )
    bound[least[:, 0] == 0] = np.inf  # nothing is known of the remaining matrix
    steps.append(Deflation(order, m, m_error, row))
    within = _vanishes(matrix, error, m, m_error) if watch else np.ones(count, dtype=bool)
    return reduced, bound, within


def _vanishes(matrix: Floats, error: Floats, m: Floats, m_error: Floats) -> NDArray[np.bool_]:
    """Whether A (1, m) is zero within the rounding of A and m."""
    whole = np.concatenate([np.ones((len(m), 1)), m], axis=1)
    unsure = np.concatenate([np.zeros((len(m), 1)), m_error], axis=1)
    size = np.abs(matrix)
    value = np.abs((matrix @ whole[:, :, None])[..., 0])
    rough = (size @ unsure[:, :, None] + error @ (np.abs(whole) + unsure)[:, :, None])[..., 0]
    rough += whole.shape[1] * UNIT * (size @ np.abs(whole)[:, :, None])[..., 0]
    within: NDArray[np.bool_] = (value <= rough).all(axis=1)
    return within
