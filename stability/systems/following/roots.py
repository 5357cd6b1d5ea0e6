"""CasADi's root-finder for many members at once, and what counts as a root."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ...base.types import Floats
from ..graph.family_graph import FamilyGraph
from .steadiness import step_noise

STEP = 1e-11
"""Largest relative size of a further Newton step at an accepted root."""
NOISE = 1e-6
"""Largest rounding of a Newton step at an accepted root, relative to 1 or to the root."""
SHARES = (2.0, 0.5, 4.0, 0.25)
"""First guesses of positive unknowns, over the given ones, where these lead to no such root."""
TINY = 1e-9
"""Positive unknowns below it are compared with their rounding."""
NUDGE = 0.01
"""Change of a guess at which the slope is singular, and over its size."""


def roots(
    graph: FamilyGraph, a: Floats, q: Floats, start: Floats, positive: Sequence[int]
) -> tuple[Floats, NDArray[np.bool_]]:
    """Isolated roots from first guesses.

    Parameters
    ----------
    graph
        The family's graph, with a root-finder.
    a, q, start
        Family parameters, parameters and first guesses, shapes (N, ·).
    positive
        Indices of unknowns that must be positive.

    Returns
    -------
    u, good
        Unknowns, shape (N, u), and whether each row is an isolated, admissible root.
    """
    u, good = _found(graph, a, q, start, positive)

    def again(rows: NDArray[np.intp], other: Floats) -> None:
        new, fine = _found(graph, a[rows], q[rows], other, positive)
        u[rows[fine]], good[rows[fine]] = new[fine], True

    for share in SHARES if positive else ():
        # the nearest root may be the mirror image, which is not admissible
        rows = np.flatnonzero(~good)
        if not len(rows):
            break
        other = start[rows].copy()
        other[:, positive] *= share
        again(rows, other)
    rows = np.flatnonzero(~good)
    if len(rows):  # Newton's method has no first step from a guess where the slope is singular
        step = newton_step(graph, a[rows], start[rows], q[rows])
        rows = rows[~np.isfinite(step).all(axis=1)]
    if len(rows):
        again(rows, start[rows] * (1 + NUDGE) + NUDGE)
    return u, good


def _found(
    graph: FamilyGraph, a: Floats, q: Floats, start: Floats, positive: Sequence[int]
) -> tuple[Floats, NDArray[np.bool_]]:
    assert graph.finder is not None
    finder = graph.finder.map(len(a))
    u = np.array(finder(start.T, np.hstack([a, q]).T)).T.reshape(len(a), -1)
    return u, accepted(graph, a, u, q, positive)


def accepted(
    graph: FamilyGraph, a: Floats, u: Floats, q: Floats, positive: Sequence[int]
) -> NDArray[np.bool_]:
    """Whether unknowns are isolated roots to the last digits, and admissible.

    Parameters
    ----------
    graph, a, u, q, positive
        As in `roots`.

    Returns
    -------
    ndarray of bool
        Shape (N,).
    """
    step = newton_step(graph, a, u, q)
    size = np.maximum(np.abs(u), 1e-300)
    close = np.abs(step) <= STEP * np.maximum(size, 1e-8)
    if not close.all():
        # a root at 0 is accurate within the rounding of its equation, not relatively
        noise = step_noise(graph, a, u, q)
        close |= (np.abs(step) <= 2 * noise) & (noise <= NOISE * np.maximum(size, 1.0))
    good: NDArray[np.bool_] = np.asarray((np.isfinite(u) & close).all(axis=1))
    signed = u[:, list(positive)]
    good &= (signed > 0).all(axis=1)
    if (good & (signed < TINY).any(axis=1)).any():  # a root at 0 comes out on either side
        off = step_noise(graph, a, u, q, whole=True)
        good &= (signed > 2 * off[:, list(positive)]).all(axis=1)
    return good


def newton_step(graph: FamilyGraph, a: Floats, u: Floats, q: Floats) -> Floats:
    """A further Newton step; infinite where the slope is singular.

    Parameters
    ----------
    graph, a, u, q
        As in `roots`.

    Returns
    -------
    ndarray
        Shape (N, u).
    """
    _, _, r, r_u, _ = graph.tangent.arrays([list(a.T), list(u.T), list(q.T)], a.shape[:1])
    return solved(r_u, r[..., 0])


def solved(slope: Floats, right: Floats) -> Floats:
    """Solutions of many linear systems; infinite where the matrix is singular.

    Parameters
    ----------
    slope, right
        Shapes (N, u, u) and (N, u).

    Returns
    -------
    ndarray
        Shape (N, u).
    """
    with np.errstate(all="ignore"):
        determinant = np.linalg.det(slope)
        bad = ~np.isfinite(slope).all(axis=(1, 2)) | ~np.isfinite(determinant) | (determinant == 0)
        slope = np.where(bad[:, None, None], np.eye(slope.shape[1]), slope)
        step: Floats = np.asarray(np.linalg.solve(slope, right[..., None])[..., 0], dtype=float)
    step[bad | ~np.isfinite(step).all(axis=1)] = np.inf
    return step
