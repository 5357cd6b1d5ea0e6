"""Boundary curves of a map: proved points on grid edges, linked to polylines."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..base.axis import Axis
from ..base.errors import NoMemberError
from ..base.types import Floats, Progress
from ..base.verdict import CODES, NO_MEMBER, Verdict
from ..spectra.problem import Problem
from .brackets import AxisScan, refine
from .crossings import BoundaryPoint, Crossing

KINDS = {crossing: crossing.code for crossing in Crossing}
"""Flag value of each crossing in files."""
MOST_DOUBTFUL = 20_000
"""Most undecided cells that are settled in balls; with more, by the sign of the abscissa."""


@dataclass(frozen=True, eq=False)
class Curves:
    """Boundary points linked to polylines."""

    x: Floats
    """Along the x axis."""
    y: Floats
    """Along the y axis."""
    axis: NDArray[np.int8]
    """0 for x or 1 for y: the axis along which the point was refined and has its error."""
    error: Floats
    """Half-width of the proved bracket along that axis."""
    kind: NDArray[np.int8]
    """Kind of crossing, as in `KINDS`."""
    frequency: Floats
    """|Im λ| of the crossing pair."""
    curve: NDArray[np.int32]
    """Number of the polyline; points of one polyline are in order."""
    unresolved: int
    """Grid edges on which a change was seen but not proved."""


def trace(
    problem: Problem,
    axes: tuple[Axis, Axis],
    codes: NDArray[np.int8],
    abscissa: Floats,
    progress: Progress | None = None,
) -> Curves:
    """Boundary curves of a map: one proved point on each grid edge whose ends differ in verdict.

    Parameters
    ----------
    problem
        Family with values in the user's units.
    axes
        The x and y axes.
    codes, abscissa
        Verdict flags and abscissas of the cells, shape (y, x).
    progress
        Called with (points done, points in all).

    Returns
    -------
    Curves
    """
    from contourpy import LineType, contour_generator

    # no edge is looked at whose square has a cell without a member
    # among stable cells a neutral one is on a boundary; without stable ones neutral is good
    neutral = not (codes == CODES[Verdict.STABLE]).any()
    signs = _signs(problem, axes, codes, abscissa, neutral=neutral)
    sign = np.ma.masked_where(codes == NO_MEMBER, signs)
    lines = contour_generator(z=sign, line_type=LineType.Separate).lines(0.0)
    xs, ys = axes[0].values, axes[1].values
    fixed = {n: float(v) for n, v in problem.values.items()}
    found: dict[tuple[int, int, int], BoundaryPoint | None] = {}
    rows: list[tuple[float, float, int, BoundaryPoint, int]] = []
    missing = 0
    total = sum(len(line) for line in lines)
    done = 0
    for curve, line in enumerate(lines):
        for column, row in np.asarray(line):
            done += 1
            if progress and done % 64 == 0:
                progress(done, total)
            # contourpy puts the zero of a ±1 field at the middle of a grid edge
            axis = 0 if row == math.floor(row) else 1
            i, j = math.floor(row), math.floor(column)
            if (axis, i, j) not in found:
                end = float((xs, ys)[axis][(j, i)[axis] + 1])
                found[axis, i, j] = _edge(
                    problem, axes, fixed, axis, float(xs[j]), float(ys[i]), end, neutral=neutral
                )
            point = found[axis, i, j]
            if point is None:
                missing += 1
                continue
            where = (point.value, float(ys[i])) if axis == 0 else (float(xs[j]), point.value)
            rows.append((*where, axis, point, curve))
    if progress:
        progress(total, total)
    return Curves(
        np.array([r[0] for r in rows]), np.array([r[1] for r in rows]),
        np.array([r[2] for r in rows], dtype=np.int8),
        np.array([r[3].error for r in rows]),
        np.array([KINDS[r[3].crossing] for r in rows], dtype=np.int8),
        np.array([r[3].frequency for r in rows]),
        np.array([r[4] for r in rows], dtype=np.int32), missing,
    )  # fmt: skip


def _edge(
    problem: Problem, axes: tuple[Axis, Axis], fixed: dict[str, float],
    axis: int, x: float, y: float, end: float, *, neutral: bool,
) -> BoundaryPoint | None:  # fmt: skip
    other = axes[1 - axis]
    line = AxisScan(problem, axes[axis].name, fixed | {other.name: (x, y)[1 - axis]})
    line.neutral = neutral
    try:
        return refine(line, (x, y)[axis], end)
    except NoMemberError:  # between two cells with members, as behind a fold
        return None


def _signs(
    problem: Problem, axes: tuple[Axis, Axis], codes: NDArray[np.int8], abscissa: Floats,
    *, neutral: bool,
) -> Floats:  # fmt: skip
    """+1 good, -1 unstable; balls settle cells that double precision leaves open."""
    sign = np.where(codes == CODES[Verdict.UNSTABLE], -1.0, 1.0)
    sign[codes == CODES[Verdict.NEUTRAL]] = float(neutral)
    doubtful = np.argwhere(codes == CODES[Verdict.UNDECIDED])
    sign[codes == CODES[Verdict.UNDECIDED]] = -np.sign(abscissa[codes == CODES[Verdict.UNDECIDED]])
    if len(doubtful) <= MOST_DOUBTFUL:
        fixed = {n: float(v) for n, v in problem.values.items()}
        xs, ys = axes[0].values, axes[1].values
        for i, j in doubtful:
            line = AxisScan(problem, axes[0].name, fixed | {axes[1].name: float(ys[i])})
            line.neutral = neutral
            sign[i, j] = line.quick_sign(float(xs[j]))
    # A cell on the boundary itself joins a stable neighbour, if it has one.
    padded = np.pad(sign, 1, constant_values=-1.0)
    around = np.max(
        [padded[:-2, 1:-1], padded[2:, 1:-1], padded[1:-1, :-2], padded[1:-1, 2:]], axis=0
    )
    return np.where(sign == 0, np.where(around > 0, 1.0, -1.0), sign)
