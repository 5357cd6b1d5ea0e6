"""Points at which two boundary curves of a map cross, and curves linked straight through them.

There the function that vanishes on both curves has a saddle.  Newton's method on its gradient finds
the place, from values in numbers of two doubles.  A saddle is taken as a crossing only where the
verdicts very close to it, twice on either side, are proved to alternate.  At another saddle two
curves pass each other, and its own verdict says on which sides.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import suppress
from itertools import count
from typing import Any, NamedTuple

import numpy as np

from ..algebra.double_double import DOUBLE_DOUBLE, DoubleDouble
from ..base.errors import StabilityError
from ..base.types import Floats
from .brackets import BoundaryPoint, Crossing
from .grid_edges import GridPolynomials, rates

SHARES = (0.25, 1e-2, 1e-4, 1e-6, 1e-6)
"""Distances of the values from which each step is taken, over a cell."""
REACH = 1e-11
"""Distance from a crossing at which verdicts alternate, over a cell; at least `ULPS`."""
ULPS = 64
MOST = 500
"""Most places at which a saddle is sought; more of them are noise."""
SAME = 1e-6
"""Distance of two places of one crossing, over a cell."""
AROUND = np.array([(i, j) for i in (-1, 0, 1) for j in (-1, 0, 1)], dtype=float).T[:, :, None]
"""Nine places of a stencil, shape (axis, place, 1)."""


class PlacedPoint(NamedTuple):
    """A boundary point in the plane of a map."""

    point: BoundaryPoint
    axis: int
    """Axis along which it was refined."""
    other: float
    """Value of the other axis."""

    def place(self, axis: int) -> float:
        """Its value along one of the axes."""
        return self.point.value if axis == self.axis else self.other


class Turn(NamedTuple):
    """Where a curve may go over from one line to another that crosses it."""

    x: float
    y: float


class Saddle(NamedTuple):
    """A saddle of the function that vanishes on boundary curves."""

    place: PlacedPoint
    """Its place; the error bounds how far the curves pass it where they cross."""
    sign: int
    """Verdict there, 1 or -1; 0 where two curves cross."""
    turn: float
    """Angle of a direction in which the verdict is not unstable, over the widths of a cell."""
    cell: tuple[float, float]
    """Widths of the cell."""

    def angle(self, other: PlacedPoint) -> float:
        """Direction of a point."""
        x, y = ((other.place(k) - self.place.place(k)) / self.cell[k] for k in (0, 1))
        return math.atan2(y, x)

    def far(self, other: Sequence[float]) -> float:
        """Distance of a place, over the widths of a cell."""
        return max(abs(other[k] - self.place.place(k)) / self.cell[k] for k in (0, 1))

    def partners(self, angles: Sequence[float]) -> list[int]:
        """The end with which each of four ends of curves is linked, by their angles in order."""
        if not self.sign:
            return [2, 3, 0, 1]
        good = (self.turn - angles[0]) % math.pi < angles[1] - angles[0]
        return [1, 0, 3, 2] if good == (self.sign < 0) else [3, 2, 1, 0]


def saddles(
    polynomials: GridPolynomials, turns: Sequence[Turn], grid: tuple[Floats, Floats]
) -> list[Saddle | None]:
    """The saddle next to each place; None where it is not resolved.

    Parameters
    ----------
    polynomials
        The polynomial of the family.
    turns
        First guesses.
    grid
        Values of both axes.
    """
    resolved: list[Saddle | None] = [None] * len(turns)
    if not 1 < len(turns) <= MOST or not polynomials.readable:
        return resolved
    place = np.array(turns).T
    first = (np.searchsorted(g, v).clip(1, len(g) - 1) for g, v in zip(grid, place, strict=True))
    cell = np.array([np.diff(g)[k - 1] for g, k in zip(grid, first, strict=True)])
    apart = (np.abs(place[:, None] - place[:, :, None]) / cell[:, None]).max(axis=0)
    some = np.flatnonzero((apart < 1).sum(axis=0) > 1)  # a crossing is seen from both sides
    if len(some):
        with np.errstate(all="ignore"), suppress(StabilityError, ArithmeticError):
            for k, saddle in _resolved(polynomials, place[:, some], cell[:, some]):
                resolved[some[k]] = saddle
    return resolved


def _resolved(
    polynomials: GridPolynomials, place: Floats, cell: Floats
) -> Iterator[tuple[int, Saddle]]:
    """Number and saddle of each place that has one."""

    def read(points: Floats) -> Any:
        return polynomials(DOUBLE_DOUBLE, *(DoubleDouble(v) for v in points))

    start, lanes = place, place.shape[1]
    chosen: Any = None
    for share in SHARES:
        points = place[:, None] + AROUND * share * cell[:, None]
        reading = read(points.reshape(2, -1))
        values = np.reshape(reading.functions, (-1, 9, lanes))
        if chosen is None:  # the function that is least at the saddle, over its size around it
            chosen = np.argmin(np.abs(values[:, 4]) / np.abs(values).max(axis=1), axis=0)
        f = values[chosen, :, np.arange(lanes)].T
        xx, yy = f[7] - 2 * f[4] + f[1], f[5] - 2 * f[4] + f[3]
        xy = (f[8] - f[6] - f[2] + f[0]) / 4
        gx, gy = (f[7] - f[1]) / 2, (f[5] - f[3]) / 2
        determinant = xx * yy - xy * xy
        step = np.array([xy * gy - yy * gx, xy * gx - xx * gy]) / determinant
        place = place + np.clip(step * share, -1, 1) * cell
    reach = np.maximum(REACH, ULPS * (np.spacing(np.abs(place)) / cell).max(axis=0))
    turn = 0.5 * np.arctan2(2 * xy, xx - yy)  # of the direction in which the function rises most
    along = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    points = np.concatenate([place + side * along * reach * cell for side in (0, 1, -1)])
    signs = read(np.moveaxis(points, 1, 0).reshape(2, -1)).sign.reshape(6, lanes)
    crossed = (signs[2:] == np.array([1, -1, 1, -1])[:, None]).all(axis=0)
    square = np.reshape(reading.squares, (-1, 9, lanes))[chosen // 2, 4, np.arange(lanes)]
    frequency = np.where(chosen % 2, rates(polynomials, place[0], place[1], square), 0.0)
    near = (np.abs(place - start) <= cell).all(axis=0) & (determinant < 0)
    for k in np.flatnonzero(near & (crossed | (signs[0] != 0))):
        kind = Crossing.FLUTTER if chosen[k] % 2 else Crossing.STATIC
        error = float((reach * cell)[0, k])
        point = BoundaryPoint(float(place[0, k]), error, kind, float(frequency[k]), False)
        sign = 0 if crossed[k] else int(signs[0, k])
        placed = PlacedPoint(point, 0, float(place[1, k]))
        yield int(k), Saddle(placed, sign, float(turn[k]), (float(cell[0, k]), float(cell[1, k])))


# --- curves through crossings ---


class Arm(NamedTuple):
    """A piece of a curve between two saddles, or between one and an end."""

    points: list[PlacedPoint]
    ends: tuple[int | None, int | None]
    """Number of the saddle at its first and last point."""


def linked(
    curves: Sequence[Sequence[PlacedPoint | Turn]],
    polynomials: GridPolynomials,
    grid: tuple[Floats, Floats],
) -> list[list[PlacedPoint]]:
    """Curves that go straight on where two of them cross.

    Parameters
    ----------
    curves
        Points in order, with a `Turn` between two points where a curve may leave its line.
    polynomials, grid
        As for `saddles`.
    """
    turns = [p for curve in curves for p in curve if isinstance(p, Turn)]
    groups: list[tuple[Saddle, list[int]]] = []
    for k, saddle in enumerate(saddles(polynomials, turns, grid)):
        if saddle is not None:
            place = saddle.place.place(0), saddle.place.place(1)
            same = [some for earlier, some in groups if earlier.far(place) < SAME]
            same[0].append(k) if same else groups.append((saddle, [k]))
    groups = [
        (saddle, sorted(some, key=lambda k: saddle.far(turns[k]))[:2])
        for saddle, some in groups
        if len(some) > 1
    ]
    number = {k: place for place, (_, some) in enumerate(groups) for k in some}
    order = count()
    arms = [arm for curve in curves for arm in _arms(curve, number, order)]
    partner: dict[tuple[int, int], tuple[int, int]] = {}
    for k, (saddle, _) in enumerate(groups):
        angles = {
            (i, e): saddle.angle(arm.points[-e])
            for i, arm in enumerate(arms)
            for e in (0, 1)
            if arm.ends[e] == k
        }
        ends = sorted(angles, key=angles.__getitem__)
        others = saddle.partners([angles[end] for end in ends])
        partner |= {end: ends[n] for end, n in zip(ends, others, strict=True)}
    return _joined(arms, partner, [saddle for saddle, _ in groups])


def _arms(
    curve: Sequence[PlacedPoint | Turn], number: dict[int, int], order: Iterator[int]
) -> list[Arm]:
    """A curve cut at saddles, by the numbers of the turns."""
    arms: list[Arm] = []
    points: list[PlacedPoint] = []
    start: int | None = None
    for place in curve:
        if isinstance(place, PlacedPoint):
            points.append(place)
        elif (saddle := number.get(next(order))) is not None:
            arms.append(Arm(points, (start, saddle)))
            points, start = [], saddle
    arms.append(Arm(points, (start, None)))
    if len(arms) > 1 and arms[0].points[0] == points[-1]:  # a closed curve
        first, *middle, last = arms
        return [Arm(last.points + first.points[1:], (last.ends[0], first.ends[1])), *middle]
    return arms


def _joined(
    arms: list[Arm], partner: dict[tuple[int, int], tuple[int, int]], saddles: list[Saddle]
) -> list[list[PlacedPoint]]:
    """Arms in a row, each with its partner at a saddle."""
    curves, left = [], set(range(len(arms)))
    for i in sorted(left, key=lambda i: None not in arms[i].ends):  # closed curves last
        if i not in left:
            continue
        end = int(arms[i].ends[0] is not None and arms[i].ends[1] is None)
        points: list[PlacedPoint] = []
        while i in left:
            left.remove(i)
            points += arms[i].points[::-1] if end else arms[i].points
            leaving, at = (i, 1 - end), arms[i].ends[1 - end]
            if at is not None:
                points += [saddles[at].place] if not saddles[at].sign else []
                i, end = partner[leaving]
                if i not in left:
                    points.append(points[0])
        curves.append(points)
    return curves
