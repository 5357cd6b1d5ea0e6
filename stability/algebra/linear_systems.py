"""Linear systems and null vectors of inexact matrices, each answer with an error bound.

A system whose entries are numbers of a graph is solved in the number type of the graph.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from typing import Any

import numpy as np

from ..base.types import Floats
from .number_types import Algebra
from .running_error import TINY, UNIT, RunningError


def null_vector(matrix: Floats, error: Floats) -> tuple[Floats, Floats]:
    """Null vector whose largest entry is 1, and a bound on its error.

    The other entries m solve A₁ m = -a₀, where a₀ is the column of the largest entry and A₁ holds
    the other columns.  Any approximate inverse L of A₁ bounds the error δ of m: with the residual r
    and K = 1 - L A₁, δ = L r + K δ, and |K| < 1 proves that A has at most one null vector.
    """
    count, n = matrix.shape[:2]
    left, sizes, right = np.linalg.svd(matrix)
    vector = right[:, -1]
    pivot = np.abs(vector).argmax(axis=1)
    rows = np.arange(count)
    vector = vector / vector[rows, pivot][:, None]
    first = np.arange(n) == pivot[:, None]
    # the pseudo-inverse of rank n - 1, projected along the vector: its pivot row is zero
    inverse = np.swapaxes(right[:, :-1], 1, 2) / sizes[:, None, :-1]
    inverse = inverse @ np.swapaxes(left[:, :, :-1], 1, 2)
    inverse = inverse - vector[:, :, None] * inverse[rows, pivot][:, None, :]
    inverse[first] = 0.0
    size, whole = np.abs(inverse), np.abs(matrix)
    others = ~first[:, None, :]
    change = contraction(inverse, matrix, error)
    change = np.where(others & others.swapaxes(1, 2), change, 0.0)
    residual = np.abs(matrix @ vector[:, :, None])
    residual += (error + 2 * n * UNIT * whole) @ np.abs(vector)[:, :, None] + 2 * n * TINY
    doubt = (1 + 4 * n * UNIT) * (size @ residual) + n * TINY
    return vector, widened(doubt, change)[..., 0]


def inverse_of(matrix: Floats) -> Floats:
    """Approximate inverses; NaN for a matrix that is singular or not finite."""
    try:
        return np.asarray(np.linalg.inv(matrix))
    except np.linalg.LinAlgError:  # at least one matrix is singular
        finite = np.isfinite(matrix).all(axis=(1, 2), keepdims=True)  # without that no SVD
        alone = np.linalg.matrix_rank(np.where(finite, matrix, 0.0), tol=0.0) == matrix.shape[-1]
        out = np.full_like(matrix, np.nan)
        for row in np.flatnonzero(alone):
            with suppress(np.linalg.LinAlgError):
                out[row] = np.linalg.inv(matrix[row])
        return out


def contraction(inverse: Floats, matrix: Floats, error: Floats) -> Floats:
    """Bound on |1 - L M'| for every matrix M' within the error of M."""
    n = matrix.shape[-1]
    size = np.abs(inverse)
    change: Floats = np.abs(np.eye(n) - inverse @ matrix) + n * TINY
    change += size @ (error + 2 * n * UNIT * np.abs(matrix))
    return change


def widened(doubt: Floats, change: Floats) -> Floats:
    """Bound on δ with |δ| ≤ doubt + change |δ|, entry by entry; infinite where none follows."""
    spread = change.sum(axis=-1)[:, :, None]
    factor = spread.max(axis=1, keepdims=True)
    sound = factor < 0.5
    most = doubt.max(axis=1, keepdims=True) / np.where(sound, 1 - factor, 1.0)
    return np.where(sound, doubt + spread * most, np.inf)


def solve(matrix: Floats, error: Floats, right: Floats, unsure: Floats) -> tuple[Floats, Floats]:
    """The solution of M X = B, and a bound on its error δ = L r + (1 - L M) δ with residual r."""
    n = matrix.shape[-1]
    inverse = inverse_of(matrix)
    solution = inverse @ right
    size, absolute = np.abs(inverse), np.abs(solution)
    residual = np.abs(matrix @ solution - right) + unsure + error @ absolute
    residual += 2 * n * (UNIT * (np.abs(matrix) @ absolute + np.abs(right)) + TINY)
    doubt = (1 + 4 * n * UNIT) * (size @ residual) + n * TINY
    return solution, widened(doubt, contraction(inverse, matrix, error))


# --- in any number type ---

Rows = Sequence[Sequence[Any]]


def solution(algebra: Algebra, matrix: Rows, right: Rows) -> list[list[Any]]:
    """The solution of M X = B in the number type of a graph; one system for each array entry.

    Balls and power series are solved with an approximate inverse, so that enclosures stay narrow
    where an elimination of balls would lose a digit with each pivot.

    Parameters
    ----------
    algebra
        The number type.
    matrix, right
        Entries of M and B, numbers of that type or plain zeros.

    Returns
    -------
    list of list
        Entries of X; not finite where M is singular, or not proved to be regular.

    Raises
    ------
    ZeroDivisionError
        If M is singular in exact numbers.

    Examples
    --------
    >>> from stability.algebra.number_types import numpy_algebra
    >>> solution(numpy_algebra(), [[2.0, 0.0], [0.0, 4.0]], [[1.0], [1.0]])
    [[array(0.5)], [array(0.25)]]
    """
    by_name = {"numpy": _in_doubles, "tracked": _tracked, "ball": _in_balls, "series": _in_series}
    return by_name.get(algebra.name, _eliminated)(matrix, right)


def _stacked(rows: Rows, shape: tuple[int, ...]) -> Floats:
    entries = [[np.broadcast_to(v, shape) for v in row] for row in rows]
    return np.moveaxis(np.array(entries, dtype=float), (0, 1), (-2, -1))


def _split(array: Any) -> list[list[Any]]:
    return [[array[..., i, j] for j in range(array.shape[-1])] for i in range(array.shape[-2])]


def _in_doubles(matrix: Rows, right: Rows) -> list[list[Any]]:
    shape = _shape(matrix, right)
    m, b = _stacked(matrix, shape), _stacked(right, shape)
    flat = m.reshape(-1, *m.shape[-2:])
    fine = np.isfinite(flat).all(axis=(1, 2))
    inverse = np.full_like(flat, np.nan)
    inverse[fine] = inverse_of(flat[fine])
    inverse = inverse.reshape(m.shape)
    solution = inverse @ b
    return _split(solution + inverse @ (b - m @ solution))


def _tracked(matrix: Rows, right: Rows) -> list[list[Any]]:
    parts = [_parts(rows) for rows in (matrix, right)]
    shape = _shape(*(rows for part in parts for rows in part))
    stacks = [_stacked(rows, shape) for part in parts for rows in part]
    value, error = solve(*(s.reshape(-1, *s.shape[-2:]) for s in stacks))
    size = stacks[2].shape
    both = _split(value.reshape(size)), _split(error.reshape(size))
    return [
        [RunningError(v, e) for v, e in zip(*row, strict=True)] for row in zip(*both, strict=True)
    ]


def _parts(rows: Rows) -> tuple[Rows, Rows]:
    tracked = [
        [v if isinstance(v, RunningError) else RunningError(v, 0.0) for v in row] for row in rows
    ]
    values = [[v.value for v in row] for row in tracked]
    # a bound that is no number says nothing
    return values, [[np.where(np.isnan(v.error), np.inf, v.error) for v in row] for row in tracked]


def _shape(*blocks: Rows) -> tuple[int, ...]:
    return np.broadcast_shapes(*(np.shape(v) for rows in blocks for row in rows for v in row))


def _in_balls(matrix: Rows, right: Rows) -> list[list[Any]]:
    from flint import arb_mat

    m, b = arb_mat([list(row) for row in matrix]), arb_mat([list(row) for row in right])
    solution: list[list[Any]] = m.solve(b, nonstop=True, algorithm="precond").tolist()
    return solution


def _in_series(matrix: Rows, right: Rows) -> list[list[Any]]:
    """Order by order: M₀ X_k = B_k - M₁ X_(k-1) - … - M_k X₀."""
    from flint import arb_mat, arb_series, ctx

    def order(rows: Rows, k: int) -> Any:
        return arb_mat(
            [
                [v[k] if isinstance(v, arb_series) else (v if k == 0 else 0) for v in row]
                for row in rows
            ]
        )

    terms = [order(matrix, k) for k in range(ctx.cap)]
    solution: list[Any] = []
    for k in range(ctx.cap):
        rest = order(right, k)
        for i in range(1, k + 1):
            rest = rest - terms[i] * solution[k - i]
        solution.append(terms[0].solve(rest, nonstop=True, algorithm="precond"))
    rows, columns = solution[0].nrows(), solution[0].ncols()
    return [[arb_series([x[i, j] for x in solution]) for j in range(columns)] for i in range(rows)]


def _eliminated(matrix: Rows, right: Rows) -> list[list[Any]]:
    """By Gauss and Jordan, over a field whose zeros are known."""
    rows = [[*m, *b] for m, b in zip(matrix, right, strict=True)]
    size = len(rows)
    for k in range(size):
        place = next((i for i in range(k, size) if not _is_zero(rows[i][k])), None)
        if place is None:
            raise ZeroDivisionError("a singular matrix")
        rows[k], rows[place] = rows[place], rows[k]
        pivot = rows[k][k]
        rows[k] = [v if _is_zero(v) else v / pivot for v in rows[k]]
        for i in range(size):
            if i != k and not _is_zero(rows[i][k]):
                share = rows[i][k]
                rows[i] = [
                    v if _is_zero(w) else v - share * w
                    for v, w in zip(rows[i], rows[k], strict=True)
                ]
    return [row[size:] for row in rows]


def _is_zero(value: Any) -> bool:
    return bool(value.is_zero() if hasattr(value, "is_zero") else value == 0)
