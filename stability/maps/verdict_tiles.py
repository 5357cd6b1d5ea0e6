"""Verdicts over the grid of a map: whole tiles proved at once, cells only along the boundary.

A tile of cells lies in a box.  The conditions are bounded over that box as in
`stability.maps.proved_boxes`; where their signs are proved, all cells have one verdict.  Other
tiles are cut into smaller ones.  Cells of tiles that remain open go through the filter of
`stability.maps.verdict_filter`, and from there to exact arithmetic.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..base.types import Floats
from ..spectra.problem import Problem
from .proved_boxes import BoxConditions
from .verdict_filter import FilteredVerdicts

Codes = NDArray[np.int8]

SIDES = (32, 8)
"""Cells along the side of a tile, coarse to fine."""


class GridVerdicts:
    """Proved verdicts over grids of two axes of a problem.

    Parameters
    ----------
    problem
        Problem of a family with a tabulated polynomial.
    x, y
        Names of the axes.

    Examples
    --------
    >>> from stability.bodies.contact_laws import Viscous
    >>> from stability.bodies.disk import Disk
    >>> from stability.spectra.disk_problem import disk_problem
    >>> verdicts = GridVerdicts(disk_problem("rolling", Disk(), Viscous(1.0), 1.0), "at", "mu")
    >>> codes, handed_on = verdicts(np.linspace(1, 2, 200), np.linspace(0.1, 1, 100))
    >>> codes.shape, np.unique(codes).tolist(), handed_on
    ((100, 200), [1, 2], 0)
    """

    def __init__(self, problem: Problem, x: str, y: str) -> None:
        self.x, self.y = x, y
        self.problem = problem
        self.cells = FilteredVerdicts(problem)
        self.boxes = BoxConditions(problem)

    def __call__(self, xs: Floats, ys: Floats, known: Codes | None = None) -> tuple[Codes, int]:
        """Verdict flags over a grid.

        Parameters
        ----------
        xs, ys
            Increasing values of the axes.
        known
            Flags that are proved already, flat, 0 for others; they change in place.

        Returns
        -------
        codes, handed_on
            Flags, shape (y, x), and how many cells went to exact arithmetic.
        """
        shape = len(ys), len(xs)
        if known is not None:
            codes = known.reshape(shape)
            return codes, self._single(
                codes, *np.divmod(np.flatnonzero(known == 0), len(xs)), 1, xs, ys
            )
        side = SIDES[0]
        tall, wide = (-(-n // side) for n in shape)
        # whole tiles, so that each is written at once; cells beyond the grid are cut off below
        padded = np.empty((tall * side, wide * side), dtype=np.int8)
        i, j = (v.ravel() for v in np.indices((tall, wide)))
        found = self._judge(i * side, j * side, side, xs, ys)
        padded.reshape(tall, side, wide, side)[...] = found.reshape(tall, 1, wide, 1)
        i, j = i[found == 0], j[found == 0]
        for finer in SIDES[1:]:
            ratio, side = side // finer, finer
            i, j = (
                ratio * v[:, None] + s.ravel()
                for v, s in zip((i, j), np.indices((ratio, ratio)), strict=True)
            )
            i, j = i.ravel(), j.ravel()
            inside = (i * side < shape[0]) & (j * side < shape[1])
            i, j = i[inside], j[inside]
            part = self._judge(i * side, j * side, side, xs, ys)
            tall, wide = padded.shape[0] // side, padded.shape[1] // side
            padded.reshape(tall, side, wide, side)[i, :, j, :] = part[:, None, None]
            i, j = i[part == 0], j[part == 0]
        codes = padded[: shape[0], : shape[1]]
        return codes, self._single(codes, i * side, j * side, side, xs, ys)

    def _judge(self, i: Any, j: Any, side: int, xs: Floats, ys: Floats) -> Codes:
        if not len(i):
            return np.zeros(0, dtype=np.int8)
        spans = {
            name: (values[first], values[np.minimum(first + side, len(values)) - 1])
            for name, values, first in ((self.x, xs, j), (self.y, ys, i))
        }
        return self.boxes(spans)

    def _single(self, codes: Codes, i: Any, j: Any, side: int, xs: Floats, ys: Floats) -> int:
        if not len(i):
            return 0
        steps = np.arange(side)
        rows, columns = (
            np.broadcast_to(v, (len(i), side, side)).reshape(-1)
            for v in (i[:, None, None] + steps[:, None], j[:, None, None] + steps)
        )
        inside = (rows < codes.shape[0]) & (columns < codes.shape[1])
        rows, columns = rows[inside], columns[inside]
        swept = {self.x: xs[columns], self.y: ys[rows]}
        found, left = self.cells.codes(dict(self.problem.values) | swept)
        codes[rows, columns] = found
        return left
