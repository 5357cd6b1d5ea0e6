"""Linear systems and null vectors of inexact matrices, each answer with an error bound."""

from __future__ import annotations

from contextlib import suppress

import numpy as np

from ..base.types import Floats
from .running_error import TINY, UNIT


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
    """Approximate inverses; NaN for a singular matrix."""
    try:
        return np.asarray(np.linalg.inv(matrix))
    except np.linalg.LinAlgError:  # at least one matrix is singular
        alone = np.linalg.matrix_rank(matrix, tol=0.0) == matrix.shape[-1]
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
    found = inverse @ right
    size, absolute = np.abs(inverse), np.abs(found)
    residual = np.abs(matrix @ found - right) + unsure + error @ absolute
    residual += 2 * n * (UNIT * (np.abs(matrix) @ absolute + np.abs(right)) + TINY)
    doubt = (1 + 4 * n * UNIT) * (size @ residual) + n * TINY
    return found, widened(doubt, contraction(inverse, matrix, error))
