"""Basin entropy of a map of labels, and the entropy of its borders.

Daza, Wagemakers, Georgeot, Guéry-Odelin & Sanjuán, "Basin entropy: a new tool to analyze
uncertainty in dynamical systems", Sci. Rep. 6 (2016) 31416.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ...base.checks import whole_number
from ...base.errors import ParameterError, shown
from ..labels import Ints

BOX = 5
"""Launches along each side of a box, as in the paper."""


@dataclass(frozen=True)
class BasinEntropy:
    """Entropy of the labels within boxes of a map."""

    basin: float
    """Basin entropy S_b: mean over all boxes, natural logarithm."""
    boundary: float
    """Boundary basin entropy S_bb: mean over boxes with more than one label; 0 if there is none."""
    boxes: int
    """Boxes of the map."""
    mixed: int
    """Boxes with more than one label."""
    box: int
    """Launches along each side of a box."""

    @property
    def fractal(self) -> bool:
        """Whether S_bb > ln 2, the published criterion.

        It suffices for a fractal border and is not needed for one: a smooth border of two regions
        has at most ln 2, and boxes where three smooth borders meet are too few to change the mean.
        """
        return self.boundary > math.log(2)


def basin_entropy(labels: ArrayLike, box: int = BOX) -> BasinEntropy:
    """Basin entropy of a map.

    Parameters
    ----------
    labels
        Whole numbers over an even grid of launches, shape (ny, nx).  What is left over behind the
        last whole box does not count.
    box
        Launches along each side of a box, at least 2.

    Returns
    -------
    BasinEntropy

    Raises
    ------
    ParameterError
        If the labels are not whole numbers over a grid of at least one box.

    Source: Daza et al. (2016), equations (2) to (5), with p = share of a label in the box.

    Examples
    --------
    >>> halves = np.repeat([[0] * 10 + [1] * 15], 25, axis=0)
    >>> found = basin_entropy(halves)
    >>> found.basin, found.boundary, found.fractal  # the border runs between boxes
    (0.0, 0.0, False)
    >>> print(f"{basin_entropy(halves, box=4).boundary:.4f}")  # ln 2 in the boxes that it halves
    0.6931
    """
    box = whole_number("box", box, least=2)
    grid = np.asarray(labels)
    if grid.ndim != 2 or grid.dtype.kind not in "iub" or min(grid.shape) < box:
        raise ParameterError(
            f"the labels are {shown(labels)}; whole numbers over a grid of at least "
            f"{box} by {box} launches are needed."
        )
    counts = _counts(grid.astype(np.int64), box)
    share = counts / box**2
    entropy = -np.sum(share * np.log(np.where(counts > 0, share, 1)), axis=1)
    mixed = (counts > 0).sum(axis=1) > 1
    boundary = float(entropy[mixed].mean()) if mixed.any() else 0.0
    basin = float(np.abs(entropy).mean())
    return BasinEntropy(basin, boundary, len(counts), int(mixed.sum()), box)


def _counts(grid: Ints, box: int) -> Ints:
    """Launches of each label in each box, shape (boxes, labels)."""
    ny, nx = (n // box for n in grid.shape)
    boxes = grid[: ny * box, : nx * box].reshape(ny, box, nx, box)
    return np.stack([(boxes == n).sum(axis=(1, 3)).ravel() for n in np.unique(grid)], axis=1)
