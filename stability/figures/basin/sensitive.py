"""The sensitive parts of a border on a basin diagram, and what a caption says about them."""

from __future__ import annotations

from ..canvas import figure_style  # isort: skip  # noqa: F401  # before Matplotlib

from collections import Counter
from typing import TYPE_CHECKING, Any

import matplotlib.patheffects
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.lines import Line2D

if TYPE_CHECKING:
    import xarray

MARK = "border_sensitive"
"""Array that marks the sensitive blocks."""
LOOK: dict[str, Any] = {"color": "#a3123f", "linestyle": (0, (3.0, 1.6)), "linewidth": 1.1}
"""Dashes about sensitive parts."""
Point = tuple[float, float]


def draw_sensitive(axes: Axes, dataset: xarray.Dataset, x: str, y: str) -> list[Line2D]:
    """Draw dashes about the sensitive parts of the borders.

    Parameters
    ----------
    axes
        The panel.
    dataset
        Map from `basins` with `levels`.
    x, y
        Names of the axes.

    Returns
    -------
    list of Line2D
        The entry of the legend; empty where no part is sensitive.
    """
    marked = _marked(dataset, 1)
    if not marked.any():
        return []
    across, along = (dataset[f"border_block_{n}"].values[marked] for n in (x, y))
    halo = [matplotlib.patheffects.withStroke(linewidth=2.2, foreground="white")]
    lines = LineCollection(outline(across, along), zorder=4, path_effects=halo, **LOOK)
    axes.add_collection(lines, autolim=False)
    return [Line2D([], [], label="sensitive", **LOOK)]


def _marked(dataset: xarray.Dataset, flag: int) -> np.ndarray[Any, np.dtype[np.bool_]]:
    if MARK not in dataset.variables:
        return np.zeros(0, dtype=bool)
    return np.asarray(dataset[MARK].values == flag)


def outline(across: Any, along: Any) -> list[list[Point]]:
    """The outline of a union of blocks, the sides in one line joined.

    Parameters
    ----------
    across, along
        Low and high edge of each block, shape (n, 2).

    Examples
    --------
    >>> outline(np.array([[0.0, 1.0], [1.0, 2.0]]), np.array([[0.0, 1.0], [0.0, 1.0]]))
    [[(0.0, 0.0), (0.0, 1.0)], [(2.0, 0.0), (2.0, 1.0)], \
[(0.0, 0.0), (2.0, 0.0)], [(0.0, 1.0), (2.0, 1.0)]]
    """
    found: list[list[Point]] = []
    for way, (fixed, free) in enumerate(((across, along), (along, across))):
        sides = Counter(
            (float(f), float(low), float(high))
            for at, (low, high) in zip(fixed, free, strict=True)
            for f in at
        )
        joined: list[list[float]] = []
        for place, low, high in sorted(s for s, count in sides.items() if count == 1):
            if joined and joined[-1][0] == place and joined[-1][2] == low:
                joined[-1][2] = high
            else:
                joined.append([place, low, high])
        for place, low, high in joined:
            ends = [(place, low), (place, high)]
            found.append(ends if way == 0 else [(b, a) for a, b in ends])
    return found


def sensitive_words(dataset: xarray.Dataset) -> str:
    """Sentences of a caption: the sensitive parts, and the uncertainty exponent of the borders.

    Parameters
    ----------
    dataset
        Map from `basins`.

    Returns
    -------
    str
        Empty where the dataset has no refined borders, or these are too coarse for both.
    """
    marked, open_ = (_marked(dataset, flag) for flag in (1, 2))
    told, found = dataset.attrs, ""
    if marked.any():
        found = (
            f"  Dashes: {int(marked.sum())} of {marked.size} blocks along the borders are "
            "sensitive: there uncertainty falls more slowly than the width."
        )
    elif marked.size:
        found = f"  None of the {marked.size} blocks along the borders is sensitive."
    if open_.any():
        found += (
            f"  {int(open_.sum())} blocks are open: a strip of launches that still move lies "
            "between two ends, and a longer horizon decides."
        )
    if "border_exponent" in told:
        low, high = told["border_exponent_interval"]
        found += (
            f"  Uncertainty exponent of all borders: {told['border_exponent']:.2f} "
            f"[{low:.2f}, {high:.2f}], {100 * told['border_exponent_level']:g} % confidence."
        )
    return found
