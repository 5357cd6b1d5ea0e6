"""Boundary curves of a map: proved points on grid edges, linked to polylines."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..base.axis import Axis
from ..base.errors import StabilityError
from ..base.types import Floats, Progress
from ..base.verdict import CODES, DECAYING, NO_MEMBER, Verdict
from ..spectra.problem import Problem
from ..systems.sources.numeric import NumericSystem
from .brackets import AxisScan, BoundaryPoint, Crossing, refine
from .by_floats import FloatScan
from .curve_crossings import PlacedPoint, Turn, linked
from .grid_edges import Edges, GridPolynomials, bracketed

KINDS = {crossing: crossing.code for crossing in Crossing}
"""Flag value of each crossing in files."""
WIDEST = 3
"""Most grid points of one row round which a curve turns at a tip."""
LEAST_STEP = 1 / 64
"""Share of a cell in which the two sides of a wedge may meet unseen."""
WIDER = 1.1
"""Largest width of a wedge towards its end, over the least one before."""
TRIES = 9
"""Points across a wedge at which its verdict is looked for."""
ASIDE = 1e-6
"""Distance, over an edge, at which a line that leaves a boundary is decided."""
MOST_DOUBTFUL = 20_000
"""Most undecided cells that are settled in balls; with more, by the sign of the abscissa."""

Cell = tuple[int, int]
"""Row and column."""


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

    Where a curve turns round a few grid points of one row, more points follow its two sides until
    they meet.

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
    """
    from contourpy import LineType, contour_generator

    # no edge is looked at whose square has a cell without a member
    # among decaying cells a neutral one is on a boundary; without these neutral is good
    neutral = not np.isin(codes, [CODES[v] for v in DECAYING]).any()
    scans = GridScans(problem, axes, neutral=neutral)
    signs = scans.signs(codes, abscissa)
    sign = np.ma.masked_where(codes == NO_MEMBER, signs)
    lines = contour_generator(z=sign, line_type=LineType.Separate).lines(0.0)
    places = [_edges(line) for line in lines]
    total = sum(map(len, lines))
    changes = scans.changes(np.concatenate([np.empty((0, 3), dtype=int), *places]), codes, progress)
    turns = _turns(changes)
    tips, xs, ys = Tips(scans), axes[0].values, axes[1].values
    curves: list[Sequence[PlacedPoint | Turn]] = []
    missing = 0
    for line, edges in zip(lines, places, strict=True):
        points = [changes[axis, i, j] for axis, i, j in edges.tolist()]
        missing += points.count(None)
        between: list[Sequence[Turn]] = [()] * len(points)
        if turns:
            cells = np.floor((line[1:] + line[:-1]) / 2).astype(int).tolist()
            between = [turns.get((i, j), ()) for j, i in cells]
        curves.append(tips.continued(line, points, between))
    through = linked(curves, scans.polynomials, (xs, ys))
    rows = [p for points in through for p in points]
    number = [k for k, points in enumerate(through) for _ in points]
    if progress:
        progress(total, total)
    return Curves(
        np.array([r.place(0) for r in rows]),
        np.array([r.place(1) for r in rows]),
        np.array([r.axis for r in rows], dtype=np.int8),
        np.array([r.point.error for r in rows]),
        np.array([KINDS[r.point.crossing] for r in rows], dtype=np.int8),
        np.array([r.point.frequency for r in rows]),
        np.array(number, dtype=np.int32),
        missing,
    )


def _edges(line: Floats) -> NDArray[np.int_]:
    """(axis, row, column) of the first end of each grid edge that a line of contourpy crosses.

    The zero of a field of 1 and -1 is at the middle of an edge.
    """
    columns, rows = line.T
    first = [(rows != np.floor(rows)), np.floor(rows), np.floor(columns)]
    return np.array(first, dtype=int).T


def _turns(changes: Mapping[tuple[int, int, int], PlacedPoint | None]) -> dict[Cell, list[Turn]]:
    """Where two curves may cross within a cell, by its row and column.

    All four edges of the cell change, or two curves come near to each other on both sides of a row
    (or column) of grid points, and their lines meet between two of these points.
    """
    turns: dict[Cell, list[Turn]] = {}
    for axis, i, j in changes:
        if axis == 0:
            sides = (0, i, j), (0, i + 1, j), (1, i, j), (1, i, j + 1)
            ends = [end for side in sides if (end := changes.get(side)) is not None]
            if len(ends) == len(sides):
                turns[i, j] = _meeting(*ends)
        up, right = axis, 1 - axis  # from the edge before, over the grid point between them
        if changes.get((axis, i - up, j - right)) is None:
            continue
        ahead = [(i + k * right, j + k * up) for k in (-1, 0, 1, 2)]
        after = [end for r, c in ahead if (end := changes.get((axis, r, c))) is not None]
        before = [e for r, c in ahead if (e := changes.get((axis, r - up, c - right))) is not None]
        if len(after) == len(before) == len(ahead):
            apart = [a.point.value - b.point.value for a, b in zip(after, before, strict=True)]
            if apart[0] >= 2 * apart[1] and apart[3] >= 2 * apart[2]:
                turn = _meeting(*after[:2], *before[:2])
                turns[i, j] = turns[i - up, j - right] = turn
    return turns


def _meeting(a: PlacedPoint, b: PlacedPoint, c: PlacedPoint, d: PlacedPoint) -> list[Turn]:
    """Where the lines through two points each meet; none where they are parallel."""
    (ax, ay), (bx, by), (cx, cy), (dx, dy) = ([p.place(0), p.place(1)] for p in (a, b, c, d))
    across = (bx - ax) * (dy - cy) - (by - ay) * (dx - cx)
    if not across:
        return []
    share = ((cx - ax) * (dy - cy) - (cy - ay) * (dx - cx)) / across
    return [Turn(ax + share * (bx - ax), ay + share * (by - ay))]


class GridScans:
    """Lines of a grid along either axis, and what is proved on them.

    Parameters
    ----------
    problem, axes
        As for `trace`.
    neutral
        Whether neutral members are on the good side.
    """

    def __init__(self, problem: Problem, axes: tuple[Axis, Axis], *, neutral: bool) -> None:
        self.problem, self.axes, self.neutral = problem, axes, neutral
        self.fixed = {n: float(v) for n, v in problem.values.items()}
        self.polynomials = GridPolynomials(problem, (axes[0].name, axes[1].name))

    def along(self, axis: int, other: float) -> AxisScan | FloatScan:
        """The line along one axis at a value of the other."""
        names = self.axes[axis].name, self.axes[1 - axis].name
        numeric = isinstance(self.problem.family.system, NumericSystem)
        line = (FloatScan if numeric else AxisScan)(
            self.problem, names[0], self.fixed | {names[1]: other}
        )
        line.neutral = self.neutral
        return line

    def changes(
        self, edges: NDArray[np.int_], codes: NDArray[np.int8], progress: Progress | None
    ) -> dict[tuple[int, int, int], PlacedPoint | None]:
        """The change of verdict on each edge: all together, then in balls what is left open.

        Parameters
        ----------
        edges
            (axis, row, column) of the first end of each.
        codes, progress
            As for `trace`.
        """
        axis, i, j = different = np.unique(edges, axis=0).T
        total, xs, ys = len(edges), self.axes[0].values, self.axes[1].values
        to_j, to_i = np.minimum(j + 1, len(xs) - 1), np.minimum(i + 1, len(ys) - 1)
        ends = codes[i, j], np.where(axis == 0, codes[i, to_j], codes[to_i, j])
        on_boundary = [(e == CODES[Verdict.NEUTRAL]) & (not self.neutral) for e in ends]
        after = xs[to_j], ys[to_i]
        along = Edges(
            axis,
            np.where(axis == 0, xs[j], ys[i]),
            np.where(axis == 0, *after),
            np.where(axis == 0, ys[i], xs[j]),
        )
        done = None if progress is None else lambda k: progress(min(k, total), total)
        neutral = np.where(on_boundary[0], along.low, along.high)
        some = np.flatnonzero(on_boundary[0] | on_boundary[1])
        placed = self.placed(
            along, done, dict(zip(some.tolist(), neutral[some].tolist(), strict=True))
        )
        return dict(zip(map(tuple, different.T.tolist()), placed, strict=True))

    def placed(
        self,
        edges: Edges,
        done: Callable[[int], None] | None = None,
        neutral: Mapping[int, float] | None = None,
    ) -> list[PlacedPoint | None]:
        """The change of verdict on each of some edges; some have an end that is neutral."""
        points: list[BoundaryPoint | None] = [None] * len(edges.axis)
        joined = np.flatnonzero(~self.polynomials.separated(edges)).tolist()
        for k, point in zip(joined, bracketed(self.polynomials, edges[joined]), strict=True):
            points[k] = point
        for k in [k for k in joined if points[k] is None]:
            with suppress(StabilityError):  # no member between two cells that have one, as a fold
                line = self.along(int(edges.axis[k]), float(edges.other[k]))
                low, high = float(edges.low[k]), float(edges.high[k])
                if neutral and k in neutral and _along(line, neutral[k], ASIDE * (high - low)):
                    continue  # no bracket about that end exists
                if isinstance(line, FloatScan):
                    points[k] = line.refined(low, high)
                else:
                    points[k] = refine(line, low, high)
            if done:
                done(k)
        return [
            None if point is None else PlacedPoint(point, *where)
            for point, *where in zip(points, edges.axis.tolist(), edges.other.tolist(), strict=True)
        ]

    def signs(self, codes: NDArray[np.int8], abscissa: Floats) -> Floats:
        """+1 good, -1 unstable; balls settle cells that double precision leaves open."""
        sign = np.where(codes == CODES[Verdict.UNSTABLE], -1.0, 1.0)
        sign[codes == CODES[Verdict.NEUTRAL]] = float(self.neutral)
        open_ = codes == CODES[Verdict.UNDECIDED]
        sign[open_] = -np.sign(abscissa[open_])
        doubtful = np.argwhere(open_)
        if len(doubtful) > MOST_DOUBTFUL:
            doubtful = doubtful[:0]
        xs, ys = self.axes[0].values, self.axes[1].values
        proved = self.polynomials.signs(xs[doubtful[:, 1]], ys[doubtful[:, 0]])
        sign[tuple(doubtful[proved != 0].T)] = proved[proved != 0]
        for i, j in doubtful[proved == 0]:
            try:
                sign[i, j] = self.along(0, float(ys[i])).quick_sign(float(xs[j]))
            except StabilityError:  # no member is proved there, as where branches cross
                sign[i, j] = 0
        # A cell on the boundary itself joins a stable neighbour, if it has one.
        padded = np.pad(sign, 1, constant_values=-1.0)
        around = np.max(
            [padded[:-2, 1:-1], padded[2:, 1:-1], padded[1:-1, :-2], padded[1:-1, 2:]], axis=0
        )
        return np.where(sign == 0, np.where(around > 0, 1.0, -1.0), sign)


def _along(line: AxisScan | FloatScan, value: float, aside: float) -> bool:
    """Whether a line runs along a boundary at a point of it."""
    return not line.quick_sign(value - aside) and not line.quick_sign(value + aside)


class Tips:
    """Wedges between two boundaries that are narrower than a cell, followed to their ends.

    Near a point where two boundaries cross, the region between them falls between grid points.
    Without its ends a map would show a corridor that does not exist.
    """

    def __init__(self, lines: GridScans) -> None:
        self.lines, self.axes = lines, lines.axes

    def continued(
        self,
        line: Floats,
        points: Sequence[PlacedPoint | None],
        between: Sequence[Sequence[Turn]],
    ) -> list[PlacedPoint | Turn]:
        """Points of a curve, with the two sides of each tip continued as far as they are apart.

        Parameters
        ----------
        line
            Middles of grid edges from contourpy, rows of (column, row).
        points
            The boundary point on each, or None.
        between
            Where two curves may cross between a point and the next one.
        """
        out: list[PlacedPoint | Turn] = []
        k, ends = 0, _tips(line)
        while k < len(points):
            if end := ends[k]:
                turn = [p for p in points[k : k + end + 1] if p is not None]
                outside = (points[k - 1] if k else None), next(iter(points[k + end + 1 :]), None)
                sides = self._walls(turn, outside) if len(turn) > end else []
                if sides:
                    out += [turn[0], *sides]
                    k += end
                    continue
            here, following = points[k], points[k + 1 : k + 2]
            if here is not None:
                out.append(here)
                out += between[k] if following and following[0] is not None else ()
            k += 1
        return out

    def _walls(
        self, turn: list[PlacedPoint], outside: tuple[PlacedPoint | None, PlacedPoint | None]
    ) -> list[PlacedPoint | Turn]:
        """Points between both sides of a tip: up along one side, and down along the other.

        Parameters
        ----------
        turn
            The tip's own points.
        outside
            The point before them and the one after them, for the first slopes.
        """
        first, *middle, last = turn
        across, along = first.axis, 1 - first.axis
        ends = self.axes[along].values
        index = int(np.argmin(np.abs(ends - first.other)))
        step = 1 if middle[0].place(along) > first.other else -1
        height, to = first.other, float(ends[index + step])
        whole = to - height
        before, after = outside
        pairs = (
            [(first, last)] if before is None or after is None else [(before, after), (first, last)]
        )
        start = len(pairs)
        grid = self.axes[across].values
        margin = float(np.diff(grid).max())
        while abs(to - height) > abs(whole) * LEAST_STEP and ends[0] <= to <= ends[-1]:
            narrow = min(abs(a.place(across) - b.place(across)) for a, b in pairs[start - 1 :])
            pair = self._across(across, to, pairs, margin, narrow)
            if pair is None:
                to = (to + height) / 2
                continue
            pairs.append(pair)
            way = 2 * (to - height)
            height, to = to, to + (way if abs(way) < abs(whole) else whole)
        up, down = [p for p, _ in pairs[start:]], [p for _, p in pairs[start:]]
        return self._with(middle, first, up, last, down) if up else []

    def _with(
        self,
        middle: list[PlacedPoint],
        first: PlacedPoint,
        up: list[PlacedPoint],
        last: PlacedPoint,
        down: list[PlacedPoint],
    ) -> list[PlacedPoint | Turn]:
        """Both sides, and each of the tip's own points on the side that it belongs to."""
        axis = first.axis

        def off(side: list[PlacedPoint], point: PlacedPoint) -> float:
            order = sorted(side, key=lambda p: p.place(1 - axis))
            at = np.interp(
                point.place(1 - axis),
                [p.place(1 - axis) for p in order],
                [p.place(axis) for p in order],
            )
            return abs(float(at) - point.place(axis))

        sides = [first, *up], [last, *down]
        way = 1 if up[0].place(1 - axis) > first.place(1 - axis) else -1
        for point in middle:
            (up if off(sides[0], point) <= off(sides[1], point) else down).append(point)
        up.sort(key=lambda p: way * p.place(1 - axis))
        down.sort(key=lambda p: -way * p.place(1 - axis))
        meeting = _meeting(*[first, *up][-2:], *[*down, last][:2])
        return [*up, *meeting, *down]

    def _across(
        self,
        axis: int,
        height: float,
        pairs: list[tuple[PlacedPoint, PlacedPoint]],
        margin: float,
        narrow: float,
    ) -> tuple[PlacedPoint, PlacedPoint] | None:
        """Both sides of the wedge at a height, looked for where straight lines meet that height.

        Parameters
        ----------
        axis
            The axis from side to side.
        height
            Value of the other axis.
        pairs
            Points of both sides so far.
        margin
            Way beyond the sides that is looked at.
        narrow
            Least distance of the sides so far.
        """
        line = self.lines.along(axis, height)
        low, high = (_extended(side, axis, height) for side in zip(*pairs[-2:], strict=True))
        before = [pair.place(axis) for pair in pairs[-1]]
        flip = before[0] > before[1]
        low, high = (high, low) if flip else (low, high)
        if low > high:  # the sides have met before
            return None
        limits = self.axes[axis].low, self.axes[axis].high
        outer = max(low - margin, limits[0]), min(high + margin, limits[1])
        tries = [(low + high) / 2, *np.linspace(low, high, TRIES)]
        values = np.array([*outer, *tries, *np.linspace(*outer, TRIES)])
        heights = np.full(len(values), height)
        signs = self.lines.polynomials.signs(
            *((values, heights) if axis == 0 else (heights, values))
        )

        def sign(k: int) -> int:
            return int(signs[k]) or line.quick_sign(float(values[k]))

        try:
            ground = sign(0)
            between = (k for k in range(2, len(values)) if outer[0] < values[k] < outer[1])
            inside = next((float(values[k]) for k in between if sign(k) == -ground), None)
            if not ground or inside is None or sign(1) != ground:
                return None
        except StabilityError:  # no member there
            return None
        ends = np.array([[outer[0], inside], [inside, outer[1]], [height, height]])
        left, right = self.lines.placed(Edges(np.full(2, axis, dtype=np.int8), *ends))
        if left is None or right is None:
            return None
        if right.point.value - left.point.value > WIDER * narrow:
            return None  # it is the wedge beyond the point where they meet
        return (right, left) if flip else (left, right)


def _tips(line: Floats) -> list[int]:
    """Steps in which a curve turns round a few grid points of one row, 0 where it does not.

    Parameters
    ----------
    line
        Middles of grid edges, as for `Tips.continued`.
    """
    steps = np.zeros(len(line), dtype=int)
    for v in line.T:  # a middle of an edge along x has a whole row
        aside = np.abs(np.diff(v)) == 0.5
        for count in range(2, min(WIDEST + 2, len(line))):
            first = v[: len(v) - count]
            back = (first == np.floor(first)) & aside[: len(first)] & (v[count:] == first)
            for k in range(2, count):
                back &= v[k : len(first) + k] == v[1 : len(first) + 1]
            steps[: len(first)][back] = count
    return steps.tolist()


def _extended(side: tuple[PlacedPoint, ...], axis: int, height: float) -> float:
    """Where the straight line through the last points of a side meets a height."""
    *earlier, last = side
    if not earlier:
        return last.place(axis)
    rise = last.place(1 - axis) - earlier[-1].place(1 - axis)
    slope = (last.place(axis) - earlier[-1].place(axis)) / rise if rise else 0.0
    return last.place(axis) + slope * (height - last.place(1 - axis))
