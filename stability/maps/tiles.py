"""Whole tiles of a grid of cells, coarse to fine, of which many have one proved verdict."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..base.types import Floats

Codes = NDArray[np.int8]
Ends = tuple[Floats, Floats]
"""Low and high ends of boxes along an axis, shapes (N,)."""
Judge = Callable[[Ends, Ends, Any], tuple[Codes, Any]]
"""From ends along x and y and signs, shape (·, N), to flags, 0 where none is proved, and signs."""


def tiled(
    xs: Floats, ys: Floats, sides: Sequence[int], judge: Judge, proved: Any
) -> tuple[Codes, Any, Any, Any]:
    """Flags of the cells of a grid by tiles, those that stay open cut into smaller ones.

    Parameters
    ----------
    xs, ys
        Increasing values of the axes.
    sides
        Cells along the side of a tile, coarse to fine.
    judge
        What proves one verdict on all of a box.
    proved
        Signs that hold on the whole grid, shape (·, 1).

    Returns
    -------
    padded, i, j, signs
        Flags, with room for whole tiles of the coarsest side, and rows, columns and signs of the
        finest tiles that stay open.
    """
    shape, side = (len(ys), len(xs)), sides[0]
    tall, wide = (-(-n // side) for n in shape)
    padded = np.empty((tall * side, wide * side), dtype=np.int8)
    i, j = (v.ravel() for v in np.indices((tall, wide)))
    signs: Any = np.repeat(proved, len(i), axis=1)
    for finer in (*sides[1:], None):
        x, y = (
            (v[first], v[np.minimum(first + side, len(v)) - 1])
            for v, first in ((xs, j * side), (ys, i * side))
        )
        codes, signs = judge(x, y, signs)
        if side == sides[0]:  # all tiles: whole rows at once
            rows = np.repeat(codes.reshape(tall, wide), side, axis=1)
            padded.reshape(tall, side, wide * side)[...] = rows[:, None, :]
        else:
            tall, wide = padded.shape[0] // side, padded.shape[1] // side
            padded.reshape(tall, side, wide, side)[i, :, j, :] = codes[:, None, None]
        left = codes == 0
        i, j, signs = i[left], j[left], signs[:, left]
        if finer is None or not len(i):
            break
        ratio, side = side // finer, finer
        down, along = (v.ravel() for v in np.indices((ratio, ratio)))
        i, j = (ratio * i[:, None] + down).ravel(), (ratio * j[:, None] + along).ravel()
        signs = np.repeat(signs, ratio * ratio, axis=1)
        inside = (i * side < shape[0]) & (j * side < shape[1])
        i, j, signs = i[inside], j[inside], signs[:, inside]
    return padded, i, j, signs
