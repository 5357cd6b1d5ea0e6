"""Pseudo-arclength continuation: a curve of members followed round its folds."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ...base.types import Floats
from .singular_points import Curve, Located, locate_branch_point, locate_fold

LEAST = 1e-9
"""Shortest step, as a share of the longest."""
COSINE = 0.95
"""Least cosine of the angle between the tangents before and after a step."""
CONTRACTION = 0.25
"""Largest ratio of the second correction to the first."""
SETTLED = 1e-11
"""Corrections below this, in scaled coordinates, are rounding."""
APART = 1e-6
"""Step, as a share of the longest, at which a branch point that is not resolved ends the curve."""


class Trace(NamedTuple):
    """Points of a curve in order, and what lies between them."""

    z: Floats
    """Unknowns and parameter, shape (N, u + 1)."""
    folds: list[Located]
    """Folds in order."""
    crossings: list[tuple[Located, Floats]]
    """Branch points in order, each with the tangent of the curve there."""
    ended: str
    """The phrase that says why the curve was left; empty where `inside` said so."""


class _Pace:
    """Coordinates scaled by typical sizes, in which steps are measured."""

    def __init__(self, curve: Curve, scale: Floats) -> None:
        self.curve, self.scale = curve, scale

    def at(self, z: Floats) -> tuple[Floats, Floats]:
        r, slope = (v[0] for v in self.curve.at(z[None]))
        return r, slope * self.scale

    def tangent(self, z: Floats, before: Floats) -> tuple[Floats, float] | None:
        """Unit tangent along `before`, and the sign that a branch point changes."""
        _, slope = self.at(z)
        if not np.isfinite(slope).all():
            return None
        found = np.linalg.svd(slope)[2][-1]
        found = found * (1.0 if found @ before >= 0 else -1.0)
        return found, float(np.linalg.slogdet(np.vstack([slope, found]))[0])

    def corrected(self, guess: Floats, tangent: Floats) -> Floats | None:
        """The point of the curve in the plane through a prediction, if it is reached fast."""
        z, sizes = guess, []
        for _ in range(8):
            r, slope = self.at(z)
            right = np.concatenate([r, [tangent @ ((z - guess) / self.scale)]])
            block = np.vstack([slope, tangent])
            if not (np.isfinite(block).all() and np.isfinite(right).all()):
                return None
            try:
                step = np.linalg.solve(block, right)
            except np.linalg.LinAlgError:
                return None
            z = z - step * self.scale
            sizes.append(float(np.abs(step).max()))
            if len(sizes) > 1 and sizes[-1] <= SETTLED * (1 + float(np.abs(z / self.scale).max())):
                return z if sizes[1] <= max(CONTRACTION * sizes[0], SETTLED) else None
        return None


def walk(
    curve: Curve,
    z: Floats,
    tangent: Floats,
    scale: Floats,
    longest: float,
    most: int,
    inside: Callable[[Floats], bool],
) -> Trace:
    """Follow a curve from a point in a direction, until it leaves a region.

    Parameters
    ----------
    curve
        The curve.
    z, tangent
        A point of the curve and a direction, shapes (u + 1,).
    scale
        Typical sizes of unknowns and parameter; steps are measured in them.
    longest
        Longest step.
    most
        Most points.
    inside
        Whether to go on after a point; the point that is outside is the last one.

    Returns
    -------
    Trace
    """
    pace = _Pace(curve, scale)
    points = [z]
    folds: list[Located] = []
    crossings: list[tuple[Located, Floats]] = []
    before = pace.tangent(z, tangent / scale / np.linalg.norm(tangent / scale))
    if before is None:
        return Trace(np.array(points), [], [], "the equations have no meaning there")
    (along, sign), step = before, longest
    while len(points) < most:
        if step < LEAST * longest:
            return Trace(np.array(points), folds, crossings, "the corrector fails there")
        # in the parameter at most `longest`; in large unknowns more, in proportion
        room = longest * max(1.0, float(np.abs(z[:-1] / scale[:-1]).max()))
        step = min(step, room, longest / max(abs(float(along[-1])), 1e-300))
        new = pace.corrected(z + step * along * scale, along)
        found = pace.tangent(new, along) if new is not None else None
        if new is None or found is None or found[0] @ along < COSINE:
            step /= 2
            continue
        after, now = found
        if now != sign:
            point = locate_branch_point(curve, (z + new) / 2)
            near = float(np.abs((point.z - (z + new) / 2) / scale).max()) <= step
            if not (point.resolved and near):
                if step <= APART * longest:
                    said = "a branch point, or a narrow gap between two branches, is not resolved"
                    return Trace(np.array(points), folds, crossings, said)
                step /= 2
                continue
            crossings.append((point, along * scale))
        elif along[-1] * after[-1] < 0:
            folds += _fold_between(curve, z, new, (along[-1], after[-1]), scale, step)
        z, along, sign = new, after, now
        points.append(z)
        if not inside(z):
            return Trace(np.array(points), folds, crossings, "")
        way = np.abs((z - points[0]) / scale).max()
        if len(points) > 3 and way < 0.6 * step and along @ before[0] > COSINE:
            return Trace(np.array(points), folds, crossings, "the branch closes on itself")
        step = 2 * step
    return Trace(np.array(points), folds, crossings, f"{most} members were found")


def _fold_between(
    curve: Curve, z: Floats, new: Floats, parts: tuple[float, float], scale: Floats, step: float
) -> list[Located]:
    """The fold between two points, where the tangent's parameter changes sign."""
    share = parts[0] / (parts[0] - parts[1])
    guess = z + share * (new - z)
    found = locate_fold(curve, guess)
    if found.resolved and np.abs((found.z - guess) / scale).max() <= step:
        return [found]
    return [Located(guess, np.abs(new - z), False, found.left)]
