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
from numpy.typing import ArrayLike

from ..base.axis import Axis
from ..base.checks import whole_number
from ..base.errors import ParameterError, shown
from ..base.types import Floats
from .lattice.labels import Ints, Label
from .lattice.lines import BorderLine, by_pair, segments
from .lattice.quadtree import Tree, between, halvings, key, pair, step

MOST_LABELS = 10_000_000
"""Labels at most, unless the caller allows more."""


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
    >>> found = borders(inside, ("x", -1, 1, 5), ("y", -1, 1, 5), levels=6)
    >>> found.mixed, found.asked, found.full
    ((12, 28, 52, 100, 204, 412, 820), 3257, 66049)
    >>> [line] = found.lines
    >>> line.closed, bool(np.abs(np.hypot(*line.points.T) - 0.8).max() < found.widths[-1, 0])
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
    known: Borders | ArrayLike | None, axes: tuple[Axis, Axis]
) -> tuple[Ints, Ints, int] | None:
    """Indices, labels and lattice of what is known before."""
    if known is None:
        return None
    if isinstance(known, Borders):
        if (known.x, known.y) != axes:
            raise ParameterError("the known borders have other axes; give the same ones.")
        return known.index, known.labels, known.lattice_levels
    grid = np.asarray(known)
    shape = axes[1].count, axes[0].count
    if grid.shape != shape or grid.dtype.kind not in "iub":
        raise ParameterError(
            f"known is {shown(known)}; whole numbers of shape {shape} (y, x) are needed."
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
    ends = [_ends(tree, way, reached) for way in (0, 1)]
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


def _ends(tree: Tree, way: int, level: int) -> tuple[Floats, Ints]:
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
