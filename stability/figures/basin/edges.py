"""Borders between fates on a diagram: refined lines of a dataset, or the edges of cells."""

from __future__ import annotations

from ..canvas import figure_style  # isort: skip  # noqa: F401  # before Matplotlib

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from numpy.typing import NDArray

if TYPE_CHECKING:
    import xarray

POINT = "border_point"
"""Dimension of refined borders."""
WIDTH = 0.7
"""Width of a border [pt]."""


def refined(dataset: xarray.Dataset) -> bool:
    """Whether a dataset holds refined borders."""
    return POINT in dataset.sizes and "border_curve" in dataset.variables


def draw_borders(axes: Axes, dataset: xarray.Dataset, kinds: NDArray[Any], x: str, y: str) -> None:
    """Draw the borders between fates.

    Parameters
    ----------
    axes
        The panel.
    dataset
        Map from `basins`; refined borders are drawn where it holds them.
    kinds
        A number for each fate, shape (y, x); negative where nothing is computed yet.
    x, y
        Names of the axes.
    """
    lines: Any = (
        _lines(dataset, x, y)
        if refined(dataset)
        else cell_edges(dataset[x].values, dataset[y].values, kinds)
    )
    axes.add_collection(
        LineCollection(lines, colors="black", linewidths=WIDTH, zorder=3, capstyle="round"),
        autolim=False,
    )


def _lines(dataset: xarray.Dataset, x: str, y: str) -> list[NDArray[np.float64]]:
    points = np.stack([dataset[f"border_{x}"].values, dataset[f"border_{y}"].values], axis=1)
    cuts = np.flatnonzero(np.diff(dataset.border_curve.values)) + 1
    return [line for line in np.split(points, cuts) if len(line)]


def edges_of(centres: NDArray[np.float64]) -> NDArray[np.float64]:
    """Edges of cells about their centres, as they are drawn; the ends are the outer centres.

    Examples
    --------
    >>> edges_of(np.array([0.0, 1.0, 3.0])).tolist()
    [0.0, 0.5, 2.0, 3.0]
    """
    middle = (centres[1:] + centres[:-1]) / 2
    return np.concatenate([centres[:1], middle, centres[-1:]])


def cell_edges(
    x: NDArray[np.float64], y: NDArray[np.float64], kinds: NDArray[Any]
) -> list[list[tuple[float, float]]]:
    """The edges between cells of different kinds, those in one line joined.

    Parameters
    ----------
    x, y
        Centres of the cells.
    kinds
        A number for each cell, shape (len(y), len(x)); a negative one has no edges.

    Examples
    --------
    >>> cell_edges(np.arange(3.0), np.arange(2.0), np.array([[0, 0, 1], [0, 0, 1]]))
    [[(1.5, 0.0), (1.5, 1.0)]]
    >>> cell_edges(np.arange(3.0), np.arange(2.0), np.array([[0, 0, -1], [0, 0, -1]]))
    []
    """
    across, along = edges_of(x), edges_of(y)
    found = []
    for column in range(len(x) - 1):
        for first, last in _runs(_differ(kinds[:, column], kinds[:, column + 1])):
            at = float(across[column + 1])
            found.append([(at, float(along[first])), (at, float(along[last]))])
    for row in range(len(y) - 1):
        for first, last in _runs(_differ(kinds[row], kinds[row + 1])):
            at = float(along[row + 1])
            found.append([(float(across[first]), at), (float(across[last]), at)])
    return found


def _differ(one: NDArray[Any], other: NDArray[Any]) -> NDArray[np.bool_]:
    """Where two fates differ and both are known."""
    return np.asarray((one != other) & (one >= 0) & (other >= 0))


def _runs(where: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """First and last edge of each run of cells."""
    change = np.flatnonzero(np.diff(np.concatenate([[False], where, [False]]).astype(np.int8)))
    return list(zip(change[::2].tolist(), change[1::2].tolist(), strict=True))
