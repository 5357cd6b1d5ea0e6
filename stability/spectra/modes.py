"""Modes of a spectrum: eigenvectors over the states, readable labels, and tracking."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..base.types import Complexes, Floats
from .deflation import Reduced
from .eigenvalues import Eigenpairs


class Modes(NamedTuple):
    """Eigenvectors of the linearisation, in the order of the eigenvalues."""

    vectors: Complexes
    """Unit vectors over the states, shape (…, mode, state), in the units of the spectrum."""
    participation: Floats
    """Share of each state in each mode, shape (…, mode, state); each mode sums to 1."""
    labels: NDArray[np.object_] | tuple[str, ...]
    """Readable names, shape (…, mode); a tuple for a single spectrum."""


def lift(
    eigenvalues: Complexes, reduced: Reduced, pairs: Eigenpairs, scale: Floats
) -> tuple[Complexes, Floats]:
    """Eigenvectors over the states, and each state's share, in the order of the eigenvalues.

    Parameters
    ----------
    eigenvalues
        Dimensionless, shape (…, mode).
    reduced
        The linearisation without structural zeros, one row per point.
    pairs
        Eigenvalues and eigenvectors of `reduced`, in any order.
    scale
        Unit of each state, broadcastable to (…, states).

    Returns
    -------
    vectors, participation
        Shapes (…, mode, state).
    """
    shape = eigenvalues.shape
    values = eigenvalues.reshape(pairs.values.shape)
    pick = _match(values, pairs.values)
    w = np.take_along_axis(pairs.vectors, pick[:, None, :], axis=2)
    for step in reversed(reduced.steps):
        # (r·w, λ w) up to a factor; at λ = 0 a mode may coincide with the removed direction
        head = (step.row[:, :, None] * w).sum(axis=1)
        size = np.maximum(np.abs(head), np.abs(values))
        alone = size < 1e-300
        size = np.where(alone, 1.0, size)
        first = head / size
        rest = np.where(alone, 1.0, values / size)
        tail = w * rest[:, None, :] + step.multipliers[:, :, None] * first[:, None, :]
        full = np.concatenate([first[:, None, :], tail], axis=1)
        w = np.empty_like(full)
        np.put_along_axis(w, step.order[:, :, None], full, axis=1)
    vectors = np.swapaxes(w, 1, 2)
    vectors = vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)
    share = np.abs(vectors) ** 2
    units = np.broadcast_to(scale, (*shape[:-1], vectors.shape[-1]))
    lifted = vectors.reshape(*shape, -1) * units[..., None, :]
    lifted = lifted / np.linalg.norm(lifted, axis=-1, keepdims=True)
    return lifted, share.reshape(*shape, -1)


def _match(values: Complexes, given: Complexes) -> NDArray[np.intp]:
    """Place of the nearest given eigenvalue for each value; each place is used once."""
    distance = np.abs(values[:, :, None] - given[:, None, :])
    pick: NDArray[np.intp] = distance.argmin(axis=2)
    twice = np.flatnonzero((np.sort(pick, axis=1) != np.arange(values.shape[1])).any(axis=1))
    if len(twice):
        from scipy.optimize import linear_sum_assignment

        for row in twice:
            pick[row] = linear_sum_assignment(distance[row])[1]
    return pick


def mode_labels(values: Complexes, radius: Floats, share: Floats, states: tuple[str, ...]) -> Any:
    """Names such as `growing oscillation of q, v`: kind of motion, and its leading states.

    A word on growth is there where the error disc leaves no doubt.
    """
    flat, r, s = (
        array.reshape(-1, *array.shape[values.ndim - 1 :]) for array in (values, radius, share)
    )
    labels = np.empty(flat.shape, dtype=object)
    for row in np.ndindex(flat.shape):
        value = flat[row]
        what = "oscillation" if abs(value.imag) > r[row] else "mode"
        sure = "growing " if value.real > r[row] else "decaying " if value.real < -r[row] else ""
        kind = f"{sure}{what}" if sure or what == "oscillation" else "slow mode"
        lead = np.argsort(-s[row], kind="stable")
        count = 1 if s[row][lead[0]] > 0.8 else 2
        labels[row] = f"{kind} of {', '.join(states[i] for i in sorted(lead[:count]))}"
    labels = labels.reshape(values.shape)
    return tuple(labels) if values.ndim == 1 else labels


def track(values: Complexes, vectors: Complexes) -> NDArray[np.intp]:
    """Order that follows each mode along the second-last axis, by eigenvector overlap.

    Parameters
    ----------
    values
        Eigenvalues, shape (…, points, n).
    vectors
        Unit eigenvectors, shape (…, points, n, states).

    Returns
    -------
    ndarray
        Indices, shape (…, points, n).

    Examples
    --------
    >>> v = np.array([[1.0, 2.0], [2.1, 1.1]], dtype=complex)
    >>> e = np.array([np.eye(2), np.eye(2)[::-1]], dtype=complex)
    >>> track(v, e).tolist()
    [[0, 1], [1, 0]]
    """
    from scipy.optimize import linear_sum_assignment

    count = values.shape[-1]
    flat_values = values.reshape(-1, *values.shape[-2:])
    flat_vectors = vectors.reshape(-1, *vectors.shape[-3:])
    order = np.empty(flat_values.shape, dtype=np.intp)
    for line, (lam, vec) in enumerate(zip(flat_values, flat_vectors, strict=True)):
        order[line, 0] = np.arange(count)
        size = np.abs(lam).max() + 1e-300
        for point in range(1, len(lam)):
            last = order[line, point - 1]
            overlap = np.abs(vec[point - 1][last].conj() @ vec[point].T)
            jump = np.abs(lam[point - 1][last][:, None] - lam[point][None, :])
            # overlap decides; distance decides where vectors are alike, as near equal eigenvalues
            order[line, point] = linear_sum_assignment((1 - overlap) + 4 * jump / size)[1]
    return order.reshape(values.shape)
