"""Whether rates vanish within their rounding, for the root-finder and for steady motions.

Running error analysis (`stability.algebra.running_error`) bounds the computed value of a zero rate.
Given numbers count as known to two units in the last place, since decimals, π and conversions of
units are rounded before.
"""

from __future__ import annotations

import numpy as np

from ...algebra.running_error import UNIT, RunningError, running_error_arrays
from ...base.types import Floats
from ..graph.family_graph import FamilyGraph

GIVEN = 4 * UNIT
"""Relative error of a given number: two units in the last place."""


def _known(block: Floats) -> list[RunningError]:
    """Columns of given numbers, each with the error of a given number."""
    return [RunningError(c, GIVEN * np.abs(c)) for c in block.T]


def step_noise(
    graph: FamilyGraph, a: Floats, u: Floats, q: Floats, *, whole: bool = False
) -> Floats:
    """Bound on the change of a Newton step at a root by rounding of the equations.

    Parameters
    ----------
    graph
        The family's graph.
    a, u, q
        Family parameters, unknowns and parameters, shapes (N, ·).
    whole
        Whether the residual counts too; the result then bounds the distance to the root.

    Returns
    -------
    ndarray
        Shape (N, u); infinite where the slope is singular.
    """
    exact = [[RunningError(c, np.zeros_like(c)) for c in block.T] for block in (a, u, q)]
    (value, error), (slope, _) = running_error_arrays(graph.residual, exact, a.shape[:1])
    size = error + np.abs(value) if whole else error
    noise = np.full(u.shape, np.inf)
    with np.errstate(all="ignore"):
        sound = np.isfinite(slope).all(axis=(1, 2)) & (np.linalg.det(slope) != 0)
    if sound.any():
        with np.errstate(all="ignore"):  # an infinite error makes the noise infinite
            found = (np.abs(np.linalg.inv(slope[sound])) @ size[sound])[..., 0]
        noise[sound] = np.where(np.isnan(found), np.inf, found)
    return noise


def rate_noise(
    graph: FamilyGraph, a: Floats, u: Floats, q: Floats, states: Floats, matrix: Floats
) -> Floats:
    """Bound on the rates of a motion that is steady except for rounding.

    Parameters
    ----------
    graph
        The family's graph.
    a, u, q
        Family parameters, unknowns and parameters, shapes (N, ·).
    states, matrix
        States and linearisation of the members, shapes (N, n) and (N, n, n).

    Returns
    -------
    ndarray
        Shape (N, n); NaN where running error analysis has no bound.
    """
    with np.errstate(all="ignore"):
        root = GIVEN * np.abs(u)
        if u.shape[1] and not graph.closed:
            root = root + 2 * step_noise(graph, a, u, q, whole=True)
        solved = [RunningError(c, e) for c, e in zip(u.T, root.T, strict=True)]
        found = running_error_arrays(graph.rates, [_known(a), solved, _known(q)], a.shape[:1])
        bound: Floats = 2 * found[0][1][..., 0] + given_noise(states, matrix)
    return bound


def given_noise(states: Floats, matrix: Floats) -> Floats:
    """The part of `rate_noise` that given states account for, which is quickly known.

    Held values are exact constants of the graph, so running error analysis leaves them out.

    Parameters
    ----------
    states, matrix
        As for `rate_noise`.

    Returns
    -------
    ndarray
        Shape (N, n).
    """
    with np.errstate(all="ignore"):
        out: Floats = 2 * (np.abs(matrix) @ (GIVEN * np.abs(states))[..., None])[..., 0]
    return out
