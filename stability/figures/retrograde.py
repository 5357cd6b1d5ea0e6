"""The map of rings whose mean path turns back, over inner radius and kind of resistance."""

from __future__ import annotations

from .styled_figure import drawing, entry, remembered, spacing  # isort: skip

from typing import TYPE_CHECKING, Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import TwoSlopeNorm
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from ..base.errors import ParameterError, shown
from ..base.looks import HATCHES
from .shading import DIVERGING, hatch

if TYPE_CHECKING:
    import xarray

LINES = ("-", "--", ":", "-.")
"""Line of each start."""
CURVE = "#000000"


@remembered
def plot_retrograde(dataset: xarray.Dataset, *, width: float | None = None) -> Figure:
    """Where the mean path of a ring turns back: colours for the first start, a line for each.

    Parameters
    ----------
    dataset
        From `stability.boundary.mean_path.retrograde_map`, two points or more along
        both axes.
    width
        Width [in]; a journal column when left out.

    Returns
    -------
    Figure
        A figure of matplotlib.

    Raises
    ------
    ParameterError
        If the dataset is another one.

    Source: drawn from the dataset alone; each text is measured: tests/figures.

    Examples
    --------
    >>> import stability as st
    >>> chart = st.retrograde_map([0.0, 1.0], [0.0, 1.0], starts=[(80.0, 1.0)])
    >>> len(st.plot_retrograde(chart).axes)
    2
    """
    _check(dataset)
    x, y = dataset.share.values, dataset.inner.values
    values = dataset.largest_ratio.values
    with drawing(None, width, None, lambda wide: 0.98 * wide) as figure:
        axes = figure.add_subplot()
        first = values[0]
        reach = max(float(np.nanmax(np.abs(first - 1))), 0.01)
        norm = TwoSlopeNorm(1.0, 1 - reach, 1 + reach)
        mesh = axes.pcolormesh(
            x, y, first, cmap=DIVERGING, norm=norm, shading="gouraud", rasterized=True
        )
        hatch(axes, x, y, first > 1, HATCHES["turns back"][0])
        _lines(axes, x, y, values)
        _words(axes, x, y, first)
        axes.set(xlim=(x[0], x[-1]), ylim=(y[0], y[-1]))
        axes.set_xlabel(r"share of air in the resistance, $d^*/(d^*+\rho^*)$ [-]")
        axes.set_ylabel(r"inner radius over outer radius, $r/R$ [-]")
        bar = figure.colorbar(mesh, ax=axes, pad=0.02, aspect=32, fraction=0.05)
        bar.set_label(r"largest nutation over precession, $\Omega/\dot\varphi$ [-]")
        figure.legend(
            handles=_keys(dataset),
            loc="outside lower center",
            ncols=1,
            frameon=False,
            title="edge of turning back, by start",
            title_fontsize=matplotlib.rcParams["legend.fontsize"],
        )
        spacing(figure, hspace=0.02, h_pad=0.03, w_pad=0.02)
    return figure


def _check(dataset: Any) -> None:
    if not str(getattr(dataset, "attrs", {}).get("format", "")).startswith("stability retrograde"):
        raise ParameterError(f"dataset is {shown(dataset)}; give what retrograde_map returns.")
    if min(dataset.sizes["inner"], dataset.sizes["share"]) < 2:
        raise ParameterError("the dataset has one point along an axis; give at least two.")


def _lines(axes: Axes, x: Any, y: Any, values: Any) -> None:
    for index, ratio in enumerate(values):
        if np.nanmin(ratio) < 1 < np.nanmax(ratio):
            look: dict[str, Any] = {
                "linestyles": LINES[index % len(LINES)],
                "linewidths": 1.1 if index else 1.4,
            }
            axes.contour(x, y, ratio, levels=[1.0], colors=CURVE, **look)


def _words(axes: Axes, x: Any, y: Any, first: Any) -> None:
    """A word on white in each region: along its height where it is narrow."""
    wide, tall = x[-1] - x[0], y[-1] - y[0]
    white = {"facecolor": "white", "edgecolor": "none", "pad": 1.2}
    where = first <= 1
    if where.mean() > 0.02:
        upright = x[np.nonzero(where)[1]].max() - x[0] < 0.3 * wide
        turn = 90 if upright else 0
        place = x[0] + 0.02 * wide, y[0] + 0.03 * tall
        axes.text(*place, "does not", ha="left", va="bottom", rotation=turn)
    if first[-1, -1] > 1:
        place = x[-1] - 0.04 * wide, y[-1] - 0.04 * tall
        axes.text(*place, "turns back", ha="right", va="top", bbox=white)


def _keys(dataset: xarray.Dataset) -> list[Line2D]:
    starts = [(rf"$\theta_0$ = {angle:g}°", _speed(speed)) for angle, speed in _starts(dataset)]
    looks = [{"color": CURVE, "ls": LINES[i % len(LINES)]} for i in range(len(starts))]
    return [entry(", ".join(words), **look) for words, look in zip(starts, looks, strict=True)]


def _speed(speed: float) -> str:
    return "centre at rest" if speed == 1 else rf"$\dot\varphi_0$ {speed:g} times that of rest"


def _starts(dataset: xarray.Dataset) -> list[tuple[float, float]]:
    pairs = dataset.start_theta.values, dataset.start_speed.values
    return [(float(a), float(b)) for a, b in zip(*pairs, strict=True)]
