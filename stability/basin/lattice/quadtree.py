"""Cells of a lattice over two axes, cut into four where labels differ."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...base.axis import Axis
from ...base.checks import positive, whole_number
from ...base.errors import ParameterError
from ...base.types import Floats
from .labels import Ints, Label, asked

FINEST = 2**30
"""Most steps of the finest lattice along an axis."""
_SIDES = ((0, 0, 0), (0, 0, 1), (1, 0, 0), (1, 1, 0))
"""Edges of a cell: direction, and offset of the cell's corner at which each starts."""


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


def _known(keys: Ints, among: Ints) -> NDArray[np.bool_]:
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
        new = new[~_known(new, self.keys)]
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
        found = np.zeros(len(i), bool)
        for way, a, b in _SIDES:
            found |= _known(key(i + a, j + b), self.mixed[way][level])
        return self.leaves[level][found]

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
