"""Members followed along straight lines from known ones, all rows at once.

The line from a known member runs through the space of all parameters.  Each step has a tangent
predictor and Newton's method as corrector.  A step is taken again with less than half its length
where the corrector contracts slowly, where its first correction is large, where the tangent turns
far, or where the determinant of the slope changes sign.  Where that sign changes even over a short
step, a branch point is solved for: the member passes it only if it is one, and no narrow gap
between two branches.  A fold is never passed: the members that are reached form one smooth sheet.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...base.types import Floats
from ..graph.family_graph import FamilyGraph
from .roots import solved
from .singular_points import Curve, locate_branch_point

LEAST = 1e-8
"""Shortest step, as a share of the line."""
BRANCH = 1e-5
"""Longest step over which the determinant may change sign at a branch point, as a share."""
MOST_STEPS = 2000
"""Most steps along one line, tried ones included."""
SHORTER = 0.45
"""Factor of a step that failed; no half, so that steps do not meet a branch point exactly."""
REACH = 0.5
"""Largest change of an unknown over one step, relative to 1 or to the unknown."""
FIRST = 0.1
"""Largest first correction, relative to 1 or to the unknown."""
CONTRACTION = 0.25
"""Largest ratio of the second correction to the first."""
CLOSE = 1e-2
"""Largest ratio of the third correction to the first."""
BEND = 0.6
"""Largest change of a tangent over one step, relative to the tangent."""
SLIGHT = 0.01
"""Largest change of a tangent over one step, as its effect relative to the unknown."""
AHEAD = 2
"""Least way to where the determinant would vanish, over a step on which it keeps its sign."""
SETTLED = 1e-10
"""Corrections below this, relative to 1 or to the unknown, are rounding."""


@dataclass(frozen=True)
class Anchor:
    """A member that is known, from which others are followed."""

    at: tuple[float, ...]
    """Family parameters."""
    parameters: tuple[float, ...]
    """The system's other parameters, in the family's order."""
    unknown: tuple[float, ...]
    """The unknowns there, to double precision."""

    @property
    def given(self) -> Floats:
        """Family parameters and parameters, shape (m,)."""
        return np.array([*self.at, *self.parameters])


class Followed(NamedTuple):
    """How far members were followed along their lines."""

    u: Floats
    """Unknowns at the last point, shape (N, u)."""
    share: Floats
    """Share of the line that was followed; 1 where the end was reached, shape (N,)."""


class _Lines:
    """The equations along lines from `start` to `stop`, rows of (family parameters, parameters)."""

    def __init__(self, graph: FamilyGraph, cut: int, start: Floats, stop: Floats) -> None:
        self.graph, self.cut = graph, cut
        self.start, self.turn = start, stop - start

    def at(self, rows: NDArray[np.intp], u: Floats, t: Floats) -> tuple[Floats, Floats, Floats]:
        """Residual, slope by the unknowns, and slope along the line."""
        turn = self.turn[rows]
        with np.errstate(all="ignore"):
            given = self.start[rows] + t[:, None] * turn
            arguments = [list(given.T[: self.cut]), list(u.T), list(given.T[self.cut :])]
            r, r_u, r_g = self.graph.along.arrays(arguments, (len(rows),))
            return r[..., 0], r_u, (r_g @ turn[..., None])[..., 0]

    def crosses(self, row: int, u: Floats, t: float, h: float) -> bool:
        """Whether a branch point is resolved next to a point: no narrow gap, which is no way."""
        curve = Curve(self.graph, self.cut, self.start[row], self.turn[row])
        found = locate_branch_point(curve, np.array([*u, t]))
        return found.resolved and bool(abs(found.z[-1] - t) <= h)


def follow(graph: FamilyGraph, cut: int, start: Floats, u: Floats, stop: Floats) -> Followed:
    """Follow members along straight lines, as far as they go.

    Parameters
    ----------
    graph
        The family's graph.
    cut
        Number of family parameters among the numbers of a row.
    start, stop
        Family parameters and parameters at the ends of each line, shapes (N, m).
    u
        Unknowns at `start`, shape (N, u).

    Returns
    -------
    Followed

    Examples
    --------
    The root of p = x² follows √p, and ends at the fold.

    >>> import casadi as ca
    >>> from stability.systems.system import System
    >>> from stability.systems.family import Family
    >>> x, p = ca.SX.sym("x"), ca.SX.sym("p")
    >>> fold = Family(System("fold", x, p, p - x**2, states=("x",), parameters=("p",)), "upper",
    ...               at=("p",), unknown={"x": 1.0}, equations=("x",))
    >>> start, stop = np.array([[1.0], [1.0]]), np.array([[4.0], [-1.0]])
    >>> found = follow(fold.graph, 1, start, np.ones((2, 1)), stop)
    >>> found.u[0].round(6), found.share.round(6)
    (array([2.]), array([1. , 0.5]))
    """
    lines = _Lines(graph, cut, start, stop)
    u, t = u.copy(), np.zeros(len(u))
    step, patience = np.full(len(u), 1.0), np.zeros(len(u), dtype=int)
    jumped = np.zeros(len(u), dtype=bool)
    rows = np.arange(len(u))
    _, slope, along = lines.at(rows, u, t)
    turn = -solved(slope, along)
    sign, size = _sign(slope)
    # the way to where the determinant would vanish, by its change over the last step
    left = _left(BRANCH, size, _sign(lines.at(rows, u - BRANCH * turn, t - BRANCH)[1])[1])
    for _ in range(MOST_STEPS):
        rows = np.flatnonzero((t < 1) & (step >= np.minimum(LEAST, 1 - t)) & (sign != 0))
        if not len(rows):
            break
        room = REACH * (1 + np.abs(u[rows])) / np.maximum(np.abs(turn[rows]), 1e-300)
        # beyond where the determinant vanishes another sheet may have its sign
        rest = 1 - t[rows]
        ahead = np.where(rest > BRANCH, left[rows] / AHEAD, np.inf)  # or the end is such a place
        h = np.minimum(np.minimum(step[rows], np.minimum(room.min(axis=1), ahead)), rest)
        step[rows] = h
        # a branch point is passed from a distance to the same distance, not from where it is near
        jump = (left[rows] <= np.minimum(BRANCH, rest) / 2) & ~jumped[rows]
        h = np.where(jump, 2 * left[rows], h)
        jumped[rows] = jump
        following = np.where(h == rest, 1.0, t[rows] + h)
        new, fine, slopes = _corrected(lines, rows, u[rows] + h[:, None] * turn[rows], following)
        now, large = _sign(slopes[0])
        after = -solved(*slopes)
        fine &= (now != 0) & ((now == sign[rows]) | (h <= BRANCH))
        fine &= (now != sign[rows]) | ~jump
        fine &= _smooth(h, u[rows], new, turn[rows], after)
        for i in np.flatnonzero(fine & (now != sign[rows])):
            fine[i] = lines.crosses(rows[i], (u[rows[i]] + new[i]) / 2, t[rows[i]] + h[i] / 2, h[i])
        done = rows[fine]
        left[done] = _left(h, large, size[rows])[fine]
        size[done] = large[fine]
        u[done], t[done], sign[done], turn[done] = (v[fine] for v in (new, following, now, after))
        jumped[done] = False
        failed = rows[~fine & ~jump]
        step[failed] *= SHORTER
        patience[failed] = 2
        step[done] = np.where(patience[done] > 0, h[fine], 2 * h[fine])
        patience[done] = np.maximum(patience[done] - 1, 0)
    return Followed(u, t)


def _sign(slope: Floats) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Sign of each determinant, and the logarithm of its size."""
    with np.errstate(all="ignore"):
        sign, size = np.linalg.slogdet(slope)
    finite = np.isfinite(slope).all(axis=(1, 2))
    return np.where(finite, sign, 0.0), np.where(finite, size, -np.inf)


def _left(h: Any, now: Floats, before: Floats) -> Floats:
    """Way over which a determinant that shrank over h goes on to zero; infinite if it grew."""
    with np.errstate(all="ignore"):
        ratio = np.exp(before - now)
        return np.where(ratio > 1, h / (ratio - 1), np.inf)


def _smooth(h: Floats, u: Floats, new: Floats, turn: Floats, after: Floats) -> NDArray[np.bool_]:
    """Whether tangents before and after a step fit one smooth curve, unknown by unknown.

    The tangent of a square root meets zero at twice the distance of the branch point: there the
    predictor is exact on the other branch, and nothing but the tangents tells the two apart.
    """
    with np.errstate(all="ignore"):
        bend = np.abs(after - turn)
        fits = bend <= BEND * np.maximum(np.abs(after), np.abs(turn))
        fits |= h[:, None] * bend <= SLIGHT * np.maximum(np.abs(new), np.abs(u))
        fits |= h[:, None] * bend <= SETTLED * (1 + np.abs(new).max(axis=1, keepdims=True))
    return np.asarray(fits.all(axis=1))


def _corrected(
    lines: _Lines, rows: NDArray[np.intp], u: Floats, t: Floats
) -> tuple[Floats, NDArray[np.bool_], tuple[Floats, Floats]]:
    """Newton's method from a prediction; whether it contracts fast; slopes at its result."""
    sizes = []
    for _ in range(3):
        r, slope, along = lines.at(rows, u, t)
        correction = solved(slope, r)
        with np.errstate(all="ignore"):
            sizes.append((np.abs(correction) / (1 + np.abs(u))).max(axis=1))
            u = u - correction
    first, second, third = sizes
    fine = (first <= FIRST) & (second <= np.maximum(CONTRACTION * first, SETTLED))
    fine &= np.isfinite(u).all(axis=1) & (third <= np.maximum(CLOSE * first, SETTLED))
    return u, fine, (slope, along)
