"""Borders between the regions of a map of labels, refined only where labels differ.

A coarse lattice of launches is labelled.  A cell is *mixed* where known labels on its edges differ.
Mixed cells are cut into four, to a stated width.  A cut may show another label on an edge of a
neighbour that was not mixed before; that neighbour is cut too, so that a border that is found is
followed until it closes or leaves the map.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..base.axis import Axis
from ..base.checks import positive, whole_number
from ..base.errors import ParameterError, shown
from ..base.types import Floats
from .labels import Ints, Label, asked

MOST_LABELS = 10_000_000
"""Labels at most, unless the caller allows more."""
FINEST = 2**30
"""Most steps of the finest lattice along an axis."""
_SIDES = ((0, 0, 0), (0, 0, 1), (1, 0, 0), (1, 1, 0))
"""Edges of a cell: direction, and offset of the cell's corner at which each starts."""
NODES = np.array([[1, 0], [2, 1], [1, 2], [0, 1]])
"""Middles of the edges of a cell, in half cells: below, right, above, left."""
CENTRE = np.array([1, 1])


@dataclass(frozen=True, eq=False)
class Borders:
    """Borders of a map of labels, with every point that was asked.

    A point's index divided by 2^`lattice_levels` counts coarse steps of its axis.
    """

    x: Axis
    """First axis, with its coarse lattice."""
    y: Axis
    """Second axis."""
    levels: int
    """Halvings of the coarse steps that were completed."""
    points: Floats
    """All labelled points, shape (n, 2)."""
    labels: Ints
    """Their labels, shape (n,)."""
    index: Ints
    """Their indices on the lattice after `lattice_levels` halvings, shape (n, 2)."""
    lattice_levels: int
    """Halvings that were wanted."""
    cells: Ints
    """Finest mixed cells: index of the corner with the least x and y, in cells, shape (m, 2)."""
    mixed: tuple[int, ...]
    """Number of mixed cells of each level, the coarse one first; the last ones are `cells`."""
    counts: tuple[int, ...]
    """Those whose own corners differ, N(w) for box counting.

    The last level knows no points between its corners.  If the others used theirs, they would see
    more of a rough border than the last one, and the dimension would come out too small."""
    crossings: Ints
    """Pairs of neighbours of each level with different labels, along x and y, (levels + 1, 2)."""
    pairs: Floats
    """Pairs of neighbours with different labels, one finest step apart, shape (k, 2, 2)."""
    pair_labels: Ints
    """Their labels, shape (k, 2)."""
    lines: tuple[BorderLine, ...]
    """The border between each two labels; off the true one by less than one finest step."""
    asked: int
    """Labels that were computed for this result; known ones do not count."""
    calls: tuple[int, ...]
    """Points of each wave of questions."""
    note: str
    """What was searched, and what can be missed, in sentences."""

    @property
    def complete(self) -> bool:
        """Whether the wanted width was reached."""
        return self.levels == self.lattice_levels

    @property
    def full(self) -> int:
        """Points of the full lattice at the finest width, which was not computed."""
        return math.prod((a.count - 1) * 2**self.levels + 1 for a in (self.x, self.y))

    @property
    def widths(self) -> Floats:
        """Widest cells of each level along x and y, in the units of the axes, (levels + 1, 2)."""
        return np.array([[step(a, n) for a in (self.x, self.y)] for n in range(self.levels + 1)])


def borders(
    label: Label,
    x: Sequence[Any],
    y: Sequence[Any],
    *,
    levels: int | None = None,
    width: ArrayLike | None = None,
    known: Borders | ArrayLike | None = None,
    chunk: int | None = None,
    most: int = MOST_LABELS,
) -> Borders:
    """Borders of a map of labels to a stated width, by refinement of the cells where labels differ.

    The launches of each wave depend on the labels of the waves before alone, and no launch is
    asked twice.  A level is complete before the next one starts, so that a result with fewer
    levels is the beginning of one with more.

    Parameters
    ----------
    label
        Function of launches, shape (n, 2), that returns their labels, n whole numbers.
    x, y
        Axes with the coarse lattice: (name, low, high, count), with "log" for even ratios.
    levels
        Halvings of the coarse steps.  Give `levels` or `width`.
    width
        Largest distance of two neighbours at a border, one number or one for each axis, in the
        units of the axes.
    known
        Labels of the coarse lattice, shape (y count, x count), or a result on the same axes: these
        launches are not asked again.
    chunk
        Most launches of one call of `label`; None for all of a wave in one call.
    most
        Most labels to compute.  A level that needs more is left out, and `complete` is False.

    Returns
    -------
    Borders

    Raises
    ------
    ParameterError
        If an argument or what `label` returns is not accepted.

    Examples
    --------
    >>> def inside(points):
    ...     return (np.hypot(points[:, 0], points[:, 1]) < 0.8).astype(int)
    >>> outline = borders(inside, ("x", -1, 1, 5), ("y", -1, 1, 5), levels=6)
    >>> outline.mixed, outline.asked, outline.full
    ((12, 28, 52, 100, 204, 412, 820), 3257, 66049)
    >>> [line] = outline.lines
    >>> line.closed, bool(np.abs(np.hypot(*line.points.T) - 0.8).max() < outline.widths[-1, 0])
    (True, True)
    """
    axes = Axis.of(x, "x"), Axis.of(y, "y")
    wanted = halvings(axes, levels, width)
    most = whole_number("most", most)
    if chunk is not None:
        whole_number("chunk", chunk)
    tree = Tree(axes, wanted, label, chunk, most)
    if (former := _known(known, axes)) is not None:
        tree.remember(*former)
    reached = tree.grow()
    return _result(tree, reached)


def _known(
    former: Borders | ArrayLike | None, axes: tuple[Axis, Axis]
) -> tuple[Ints, Ints, int] | None:
    """Indices, labels and lattice of what is known before."""
    if former is None:
        return None
    if isinstance(former, Borders):
        if (former.x, former.y) != axes:
            raise ParameterError("the known borders have other axes; give the same ones.")
        return former.index, former.labels, former.lattice_levels
    grid = np.asarray(former)
    shape = axes[1].count, axes[0].count
    if grid.shape != shape or grid.dtype.kind not in "iub":
        raise ParameterError(
            f"known is {shown(former)}; whole numbers of shape {shape} (y, x) are needed."
        )
    j, i = (n.ravel() for n in np.indices(shape))
    return np.stack([i, j], axis=1), grid.ravel().astype(np.int64), 0


def _result(tree: Tree, reached: int) -> Borders:
    """The record of a refinement after its last complete level."""
    mixed = [*tree.cut[:reached], tree.unlike(reached)]
    corners = [_corners(tree, level, cells) for level, cells in enumerate(mixed)]
    cells = np.stack(pair(mixed[-1]), axis=1)
    lines = []
    for labels, nodes, closed in by_pair(*segments(cells, corners[-1])):
        place = [between(a, n, reached + 1) for a, n in zip(tree.axes, nodes.T, strict=True)]
        lines.append(BorderLine(labels, np.stack(place, axis=1), closed))
    ends = [_pairs_of_unlike(tree, way, reached) for way in (0, 1)]
    pairs = np.concatenate([e for e, _ in ends])
    return Borders(
        x=tree.axes[0],
        y=tree.axes[1],
        levels=reached,
        points=tree.places(tree.keys),
        labels=tree.labels,
        index=np.stack(pair(tree.keys), axis=1),
        lattice_levels=tree.levels,
        cells=cells,
        mixed=tuple(map(len, mixed)),
        pairs=pairs,
        crossings=np.array([[_unlike(tree, way, n) for way in (0, 1)] for n in range(reached + 1)]),
        counts=tuple(int((c != c[:, :1]).any(axis=1).sum()) for c in corners),
        pair_labels=np.concatenate([n for _, n in ends]),
        lines=tuple(lines),
        asked=sum(tree.calls),
        calls=tuple(tree.calls),
        note=_note(tree, reached),
    )


def _corners(tree: Tree, level: int, cells: Ints) -> Ints:
    """Labels at the corners of cells, anticlockwise from the lower left, shape (n, 4)."""
    i, j = pair(cells)
    around = ((0, 0), (1, 0), (1, 1), (0, 1))
    return np.stack([tree.at(level, i + a, j + b) for a, b in around], axis=1)


def _unlike(tree: Tree, way: int, level: int) -> int:
    """Number of edges of a level along x or y whose own ends differ."""
    i, j = pair(tree.mixed[way][level])
    return int((tree.at(level, i, j) != tree.at(level, i + (way == 0), j + (way == 1))).sum())


def _pairs_of_unlike(tree: Tree, way: int, level: int) -> tuple[Floats, Ints]:
    """Both ends of the mixed edges of a level, and their labels."""
    i, j = pair(tree.mixed[way][level])
    far = i + (way == 0), j + (way == 1)
    shift = tree.levels - level
    both = [tree.places(key(a << shift, b << shift)) for a, b in ((i, j), far)]
    labels = [tree.at(level, a, b) for a, b in ((i, j), far)]
    return np.stack(both, axis=1), np.stack(labels, axis=1)


def _note(tree: Tree, reached: int) -> str:
    """What was searched, in sentences."""
    steps = " by ".join(f"{step(a, 0):.3g}" for a in tree.axes)
    text = (
        "Every border that separates two labelled launches is followed.  A region without a "
        f"labelled launch, so one that fits between the lattice points of {steps}, can be missed."
    )
    if reached < tree.levels:
        text += (
            f"  {tree.most} labels were allowed: {reached} of {tree.levels} halvings are complete."
        )
    return text


def halvings(axes: tuple[Axis, Axis], levels: int | None, width: ArrayLike | None) -> int:
    """Halvings that were asked for, by number or by width."""
    if (levels is None) == (width is None):
        raise ParameterError("give levels or width, one of the two.")
    if levels is None:
        levels = _by_width(axes, width)
    levels = whole_number("levels", levels, least=0)
    steps = max(a.count - 1 for a in axes)
    if levels > 30 or steps << levels > FINEST:
        raise ParameterError(
            f"the border is wanted after {levels} halvings of {steps} coarse steps; "
            "a lattice has at most 2^30 steps along an axis."
        )
    for axis in axes:
        last = (axis.count - 1) << levels
        ends = between(axis, np.array([0, 1, last - 1, last]), levels)
        if not (ends[0] < ends[1] and ends[2] < ends[3]):
            raise ParameterError(
                f"{levels} halvings of the steps of {axis.name} are finer than double precision."
            )
    return levels


def _by_width(axes: tuple[Axis, Axis], width: Any) -> int:
    """Halvings after which no step is wider than wanted."""
    wide = np.asarray(positive("width", width))
    if wide.shape not in ((), (2,)):
        raise ParameterError(f"width has shape {wide.shape}; give one number or two.")
    return max(
        max(0, math.ceil(math.log2(step(a, 0) / w) - 1e-9))
        for a, w in zip(axes, np.broadcast_to(wide, 2), strict=True)
    )


def step(axis: Axis, level: int) -> float:
    """Widest step of an axis after some halvings."""
    if not axis.log:
        return float((axis.high - axis.low) / (axis.count - 1) / 2**level)
    ratio = math.log(axis.high / axis.low) / (axis.count - 1) / 2**level
    return -axis.high * math.expm1(-ratio)


def between(axis: Axis, index: Ints, levels: int) -> Floats:
    """Values of an axis at indices of a lattice; the same doubles for every number of levels."""
    coarse = axis.values
    whole = np.minimum(index >> levels, axis.count - 2)
    part = (index - (whole << levels)) / float(2**levels)
    low, high = coarse[whole], coarse[whole + 1]
    inner = low * (high / low) ** part if axis.log else low + (high - low) * part
    return np.asarray(np.where(part == 1, high, inner))


def key(i: Ints, j: Ints) -> Ints:
    """One number for a pair of indices; in order of x, then y."""
    return (i << 31) | j


def pair(keys: Ints) -> tuple[Ints, Ints]:
    """The indices of some keys."""
    return keys >> 31, keys & (2**31 - 1)


def _among(keys: Ints, among: Ints) -> NDArray[np.bool_]:
    """Which keys are in a sorted array."""
    if not len(among):
        return np.zeros(len(keys), bool)
    place = np.minimum(np.searchsorted(among, keys), len(among) - 1)
    return np.asarray(among[place] == keys)


class Tree:
    """Labelled launches, the cells of each level, and the edges on which labels differ."""

    def __init__(
        self, axes: tuple[Axis, Axis], levels: int, label: Label, chunk: int | None, most: int
    ) -> None:
        self.axes, self.levels, self.label = axes, levels, label
        self.chunk, self.most = chunk, most
        none = np.zeros(0, np.int64)
        self.keys, self.labels = none, none
        """Launches as indices on the finest lattice, in order, and their labels."""
        self.leaves = [none] * (levels + 1)
        """Cells of each level that are not cut."""
        self.cut = [none] * (levels + 1)
        """Cells of each level that are."""
        self.mixed = [[none] * (levels + 1) for _ in range(2)]
        """Edges along x and along y, of each level, on which known labels differ."""
        self.calls: list[int] = []

    # --- launches ---

    def remember(self, index: Ints, labels: Ints, levels: int) -> None:
        """Take over labels at indices of a lattice, those that are points of this one."""
        if levels > self.levels:
            coarse = 2 ** (levels - self.levels)
            fits = (index % coarse == 0).all(axis=1)
            index, labels, levels = index[fits] // coarse, labels[fits], self.levels
        i, j = index.T << (self.levels - levels)
        self._store(key(i, j), labels)

    def _store(self, keys: Ints, labels: Ints) -> None:
        order = np.argsort(np.concatenate([self.keys, keys]), kind="stable")
        self.keys = np.concatenate([self.keys, keys])[order]
        self.labels = np.concatenate([self.labels, labels])[order]

    def places(self, keys: Ints) -> Floats:
        """Launches at lattice keys, shape (n, 2)."""
        return np.stack(
            [between(a, i, self.levels) for a, i in zip(self.axes, pair(keys), strict=True)],
            axis=1,
        )

    def ask(self, keys: Ints) -> bool:
        """Label the launches that are not known; False where these are too many."""
        new = np.unique(keys)
        new = new[~_among(new, self.keys)]
        if sum(self.calls) + len(new) > self.most:
            return False
        if len(new):
            self.calls.append(len(new))
            self._store(new, asked(self.label, self.places(new), self.chunk))
        return True

    def at(self, level: int, i: Ints, j: Ints) -> Ints:
        """Known labels at indices of a level."""
        shift = self.levels - level
        return np.asarray(self.labels[np.searchsorted(self.keys, key(i << shift, j << shift))])

    # --- cells ---

    def grow(self) -> int:
        """Label the coarse lattice and refine it; the number of completed levels."""
        nx, ny = (a.count for a in self.axes)
        i, j = (a.ravel() for a in np.indices((nx, ny)))
        if not self.ask(key(i << self.levels, j << self.levels)):
            raise ParameterError(f"most is {self.most}; the coarse lattice has {nx * ny} launches.")
        i, j = (a.ravel() for a in np.indices((nx - 1, ny - 1)))
        self.leaves[0] = key(i, j)
        for way, shape in enumerate(((nx - 1, ny), (nx, ny - 1))):
            self._note(way, 0, *(a.ravel() for a in np.indices(shape)))
        for target in range(1, self.levels + 1):
            before = list(self.leaves), list(self.cut), [list(m) for m in self.mixed]
            if not self._reach(target):
                self.leaves, self.cut, self.mixed = before
                return target - 1
        return self.levels

    def _note(self, way: int, level: int, i: Ints, j: Ints) -> None:
        """Keep those of some edges whose ends differ, and the longer edges that hold them."""
        unlike = self.at(level, i, j) != self.at(level, i + (way == 0), j + (way == 1))
        i, j = i[unlike], j[unlike]
        while len(i):
            self.mixed[way][level] = np.union1d(self.mixed[way][level], key(i, j))
            inner = (j if way == 0 else i) % 2 == 0  # else no edge of the level above is here
            i, j, level = i[inner] >> 1, j[inner] >> 1, level - 1
            if level < 0:
                break

    def unlike(self, level: int) -> Ints:
        """Cells of a level that are mixed and not cut."""
        i, j = pair(self.leaves[level])
        mask = np.zeros(len(i), bool)
        for way, a, b in _SIDES:
            mask |= _among(key(i + a, j + b), self.mixed[way][level])
        return self.leaves[level][mask]

    def _reach(self, target: int) -> bool:
        """Cut mixed cells until none is coarser than a level; False where labels run out."""
        while True:
            waiting = [(n, cells) for n in range(target) if len(cells := self.unlike(n))]
            if not waiting:
                return True
            shifts = [(self.levels - n - 1, pair(cells)) for n, cells in waiting]
            wanted = [
                key((2 * i + a) << shift, (2 * j + b) << shift)
                for shift, (i, j) in shifts
                for a, b in ((1, 0), (0, 1), (1, 1), (2, 1), (1, 2))
            ]
            if not self.ask(np.concatenate(wanted)):
                return False
            for level, cells in waiting:
                self._cut(level, cells)

    def _cut(self, level: int, cells: Ints) -> None:
        """Replace cells by their quarters."""
        self.leaves[level] = np.setdiff1d(self.leaves[level], cells, assume_unique=True)
        self.cut[level] = np.union1d(self.cut[level], cells)
        i, j = pair(cells)
        quarters = [key(2 * i + a, 2 * j + b) for a in (0, 1) for b in (0, 1)]
        self.leaves[level + 1] = np.union1d(self.leaves[level + 1], np.concatenate(quarters))
        for a in (0, 1):
            for b in (0, 1, 2):
                self._note(0, level + 1, 2 * i + a, 2 * j + b)
                self._note(1, level + 1, 2 * i + b, 2 * j + a)


@dataclass(frozen=True, eq=False)
class BorderLine:
    """A line between the regions of two labels."""

    labels: tuple[int, int]
    """The two labels, the smaller first."""
    points: Floats
    """Points of the line, shape (n, 2): the middles of pairs of neighbours with different labels.

    Ends where more than two labels meet are centres of cells."""
    closed: bool
    """Whether the last point is joined to the first."""


def segments(cells: Ints, corners: Ints) -> tuple[Ints, Ints]:
    """Segments of the border in cells of a lattice (marching squares for any number of labels).

    A cell with two changes along its edge has one segment.  Where three or more regions meet, or
    two regions cross, the segments meet at its centre.  Two different labels at opposite corners
    of a third one are cut off separately.

    Parameters
    ----------
    cells
        Lower left corner of each cell in lattice units, shape (n, 2).
    corners
        Labels, shape (n, 4), anticlockwise from the lower left corner.

    Returns
    -------
    ends : ndarray
        Both ends of each segment in half lattice units, shape (m, 2, 2).
    labels : ndarray
        The two labels of each, the smaller first, shape (m, 2).

    Examples
    --------
    >>> ends, labels = segments(np.array([[0, 0]]), np.array([[0, 1, 1, 0]]))
    >>> ends.tolist(), labels.tolist()
    ([[[1, 0], [1, 2]]], [[0, 1]])
    """
    following = np.roll(corners, -1, axis=1)
    pairs = np.sort(np.stack([corners, following], axis=2), axis=2)
    changes = corners != following
    count = changes.sum(axis=1)
    even = corners[:, 0] == corners[:, 2]
    odd = corners[:, 1] == corners[:, 3]
    ends: list[Ints] = []
    labels: list[Ints] = []

    def add(chosen: NDArray[np.bool_], first: Ints, second: Ints, edge: int) -> None:
        ends.append(np.stack([2 * cells[chosen] + first, 2 * cells[chosen] + second], axis=1))
        labels.append(pairs[chosen, edge])

    for a in range(4):
        for b in range(a + 1, 4):
            add((count == 2) & changes[:, a] & changes[:, b], NODES[a], NODES[b], a)
    for lone, opposite in ((even & ~odd, (0, 1, 2, 3)), (odd & ~even, (3, 0, 1, 2))):
        for a, b in (opposite[:2], opposite[2:]):
            add((count == 4) & lone, NODES[a], NODES[b], a)
    central = (count == 3) | ((count == 4) & (even == odd))
    for a in range(4):
        add(central & changes[:, a], NODES[a], CENTRE, a)
    return np.concatenate(ends), np.concatenate(labels)


def chained(ends: Ints) -> list[tuple[Ints, bool]]:
    """Segments of one pair of labels, joined to lines that end where other than two meet.

    Parameters
    ----------
    ends
        Both ends of each segment, shape (m, 2, 2).

    Returns
    -------
    list of (ndarray, bool)
        Nodes of each line, shape (n, 2), and whether it is closed.

    Examples
    --------
    >>> [(nodes, closed)] = chained(np.array([[[1, 0], [1, 2]], [[2, 3], [1, 2]]]))
    >>> nodes.tolist(), closed
    ([[1, 0], [1, 2], [2, 3]], False)
    """
    nodes, index = np.unique(ends.reshape(-1, 2), axis=0, return_inverse=True)
    joined = index.reshape(-1, 2).tolist()
    at: list[list[int]] = [[] for _ in nodes]
    for number, (a, b) in enumerate(joined):
        at[a].append(number)
        at[b].append(number)
    used = [False] * len(joined)

    def line(node: int, segment: int) -> list[int]:
        path = [node]
        while not used[segment]:
            used[segment] = True
            a, b = joined[segment]
            path.append(b if path[-1] == a else a)
            here = at[path[-1]]
            if len(here) != 2:
                break
            segment = here[0] if used[here[1]] else here[1]
        return path

    lines: list[tuple[Ints, bool]] = []
    loose = [n for n, here in enumerate(at) if len(here) != 2]
    for node in (*loose, *range(len(nodes))):  # what is left after the loose ends are loops
        for segment in at[node]:
            if not used[segment]:
                path = line(node, segment)
                closed = path[0] == path[-1] and len(at[node]) == 2
                lines.append((nodes[path[:-1] if closed else path], closed))
    return lines


def by_pair(ends: Ints, labels: Ints) -> Sequence[tuple[tuple[int, int], Ints, bool]]:
    """The lines of every pair of labels, in order of the labels.

    Parameters
    ----------
    ends, labels
        As `segments` gives them.

    Returns
    -------
    sequence of (labels, nodes, closed)
    """
    lines = []
    for a, b in np.unique(labels, axis=0).tolist():
        rows = (labels == (a, b)).all(axis=1)
        lines += [((a, b), nodes, closed) for nodes, closed in chained(ends[rows])]
    return lines
