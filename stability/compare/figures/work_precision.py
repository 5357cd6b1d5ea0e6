"""Figures only: work against precision of motions, and what a first call costs."""

from __future__ import annotations

from ...figures.canvas import STYLE, figure_style  # isort: skip

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from ...figures.letters import SMALL  # fmt: skip
from ..motion import dataset as motion_data
from ..motion.cases import NO_ANSWER
from ..pareto import places
from .panels import (
    BETWEEN,
    FRONT,
    OWN,
    RIGHT,
    WIDTH,
    Panel,
    frame,
    handle,
    legend,
    log_axis,
    none,
    page,
    span,
    steps,
    title,
    under,
)

if TYPE_CHECKING:
    import xarray


LABELS = {
    "final": "error of the last state",
    "path": "error along the path",
    "audit": "error of the energy account",
    "event": "error of the times of events",
}
"""Label of the error by metric."""
LOWEST, HIGHEST = 1e-16, 1e2
"""Ends of an axis of errors."""
STROKES: tuple[dict[str, Any], ...] = (
    {"color": "#0072B2", "marker": "s"}, {"color": "#E69F00", "marker": "^"},
    {"color": "#000000", "marker": "v"}, {"color": "#CC79A7", "marker": "p"},
    {"color": "#882255", "marker": "h"}, {"color": "#56B4E9", "marker": "<"},
    {"color": "#332288", "marker": ">"},
)  # fmt: skip
"""Looks of the package's integrators other than its default."""
MODELS: tuple[dict[str, Any], ...] = (
    {"color": "#7f4f24"}, {"color": "#c08a3e"}, {"color": "#4d3b1f", "mfc": "white"},
)  # fmt: skip
"""Looks of models with another law in place of the true one."""
PEOPLE: tuple[dict[str, Any], ...] = ({"marker": "o"}, {"marker": "s"})
"""Looks of integrators that people use."""
BROAD: dict[str, Any] = {"color": FRONT, "alpha": 0.35, "linewidth": 3.2, "zorder": 1}
"""Stroke of the front."""
BAR: dict[str, Any] = {"alpha": 0.45, "linewidth": 0.6, "zorder": 2.5}
"""Stroke of the spread of the repeats."""


def motion_figure(chart: xarray.Dataset, metric: str = "path") -> Figure:
    """Work against precision: every driver through its tolerances, a panel for each scene.

    Parameters
    ----------
    chart
        From `stability.compare.motion.dataset.dataset`.
    metric
        One of `stability.compare.motion.measure.METRICS`.

    Returns
    -------
    Figure
        Two journal columns wide; runs with a wrong outcome stand in a strip over their panel.
    """
    looks = _looks(chart)
    low, high = span(chart.seconds.values.ravel())
    with figure_style(STYLE):
        figure, panels = page([3, 3], 1.9, 0.74)
        for panel, which in zip(panels, chart.scene.values.tolist(), strict=False):
            log_axis(panel.main.xaxis, low, high, 1)
            log_axis(panel.main.yaxis, LOWEST, HIGHEST, 4)
            title(panel.strip, str(chart.scene_title.sel(scene=which).values))
            _motion_panel(panel, chart.sel(scene=which), metric, looks)
            steps(panel.main, _front(chart, which, metric), **BROAD)
        frame(panels, "time of a run [s]", LABELS[metric], "wrong outcome")
        _driver_key(figure, looks)
    return figure


def _front(chart: xarray.Dataset, which: str, metric: str) -> list[tuple[float, float]]:
    flat = {
        f"{name} {rung}": point
        for name, rows in motion_data.points(chart, which, metric).items()
        for rung, point in enumerate(rows)
    }
    return [(p.time, max(p.error, 2 * LOWEST)) for p in places(flat).values() if p.on_front]


def _looks(chart: xarray.Dataset) -> dict[str, dict[str, Any]]:
    """Line and marker of every driver, by what it is."""
    found: dict[str, dict[str, Any]] = {}
    others, people, models = (iter(stock * 3) for stock in (STROKES, PEOPLE, MODELS))
    for name in chart.driver.values.tolist():
        one = chart.sel(driver=name)
        if name.endswith("-model") or name == "regularised":
            look = {"marker": "D", "ls": (0, (3, 1.2)), "lw": 1.0, "ms": 2.6, "zorder": 3.5}
            found[name] = look | next(models)
        elif bool(one.default):
            found[name] = {"color": OWN, "marker": "o", "lw": 1.6, "ms": 3.4, "zorder": 5}
        elif name == "unchecked":
            # the default without its check: the same colour, an open marker
            found[name] = {"color": OWN, "marker": "o", "mfc": "white", "lw": 0.8, "ms": 2.8,
                           "zorder": 4.5}  # fmt: skip
        elif bool(one.own):
            found[name] = {"lw": 0.8, "ms": 2.6, "zorder": 4} | next(others)
        else:
            found[name] = {"color": "#8a8a8a", "mfc": "white", "lw": 0.8, "ms": 2.8,
                           "zorder": 3} | next(people)  # fmt: skip
    return {name: {"ls": "-", "mew": 0.6} | look for name, look in found.items()}


def _motion_panel(
    panel: Panel, here: xarray.Dataset, metric: str, looks: dict[str, dict[str, Any]]
) -> None:
    silent = []
    panel.strip.set_ylim(-0.6, 2.6)
    asked = bool(np.isfinite(here[metric].values).any())
    if not asked:
        panel.main.text(0.5, 0.5, "no such error here", transform=panel.main.transAxes,
                        fontsize=SMALL, color="#666666", ha="center")  # fmt: skip
    for index, (name, look) in enumerate(looks.items()):
        mine = here.sel(driver=name)
        if str(mine.status.values) == "not asked":
            continue
        ran = np.isfinite(mine.seconds.values).any(axis=-1)
        if not ran.any():
            silent.append(name)
            continue
        right = ran & (mine.outcome.values == str(here.true_outcome.values))
        times, error = _times(mine.seconds.values), np.where(right, mine[metric].values, np.nan)
        error = np.clip(error, 2 * LOWEST, HIGHEST / 2)
        panel.main.plot(times[1], error, **look)
        panel.main.hlines(error, times[0], times[2], color=look["color"], **BAR)
        # each driver is a little lower than the last, so that none hides another
        down = index / len(looks)
        open_ = ran & np.isin(mine.outcome.values, NO_ANSWER)
        rows = ((ran & ~right & ~open_, 2.3 - 1.2 * down, "x"), (open_, 2.3 - 1.2 * down, "_"),
                (right & np.isnan(error) & asked, 0.6 - 0.9 * down, "|"))  # fmt: skip
        for where, y, mark in rows:
            panel.strip.plot(times[1][where], [y] * int(where.sum()), mark, ms=3.3, mew=0.9,
                             color=look["color"])  # fmt: skip
    if not any(np.size(line.get_xdata()) for line in panel.strip.lines):
        none(panel.strip)
    under(panel.main, f"no answer: {', '.join(silent)}" if silent else "")


def _times(raw: NDArray[Any]) -> NDArray[Any]:
    """Fastest, median and slowest repeat of each rung; NaN where none ran."""
    ran = np.isfinite(raw).any(axis=-1)
    out = np.full((3, len(raw)), np.nan)
    if ran.any():
        known = raw[ran]
        out[:, ran] = np.nanmin(known, -1), np.nanmedian(known, -1), np.nanmax(known, -1)
    return out


def _driver_key(figure: Figure, looks: dict[str, dict[str, Any]]) -> None:
    extra = [
        handle("front", ls="-", **{k: v for k, v in BROAD.items() if k != "zorder"}),
        handle("wrong outcome", marker="x", color="#555555", ms=3.2),
        handle("says it has none", marker="_", color="#555555", ms=3.6, mew=0.9),
        handle("right, but no such error", marker="|", color="#555555"),
        handle("fastest to slowest repeat", ls="-", color="#555555", lw=0.6),
    ]
    names = {"simulate": "simulate() (default)", "unchecked": "simulate(check=False)",
             "rk45": "people's: RK45", "rk4": "people's: RK4", "rough-model": "model: rough",
             "smooth-model": "model: smooth", "regularised": "model: regularised"}  # fmt: skip
    handles = [handle(names.get(name, name), **look) for name, look in looks.items()]
    legend(figure, 0.66, handles + extra, 5)


def first_call_figure(chart: xarray.Dataset) -> Figure:
    """Time of the first call, graphs built and code compiled, next to that of a repeat.

    Parameters
    ----------
    chart
        From `stability.compare.motion.dataset.dataset`.

    Returns
    -------
    Figure
        Two journal columns wide: a panel for each scene, a line for each driver.
    """
    looks = _looks(chart)
    names = list(looks)
    left, body, height = 0.86, 0.118 * len(names), 2 * 0.118 * len(names) + 1.45
    wide = (WIDTH - left - RIGHT - 3 * BETWEEN) / 4
    low, high = span(np.append(chart.seconds.values, chart["first"].values))
    with figure_style(STYLE):
        figure = Figure(figsize=(WIDTH, height))
        for index, which in enumerate(chart.scene.values.tolist()):
            row, column = divmod(index, 4)
            bottom = height - (row + 1) * (0.32 + body) - row * 0.2
            axes = figure.add_axes(((left + column * (wide + BETWEEN)) / WIDTH, bottom / height,
                                    wide / WIDTH, body / height))  # fmt: skip
            log_axis(axes.xaxis, low, high, 1)
            _first_panel(axes, chart.sel(scene=which), looks)
            title(axes, str(chart.scene_title.sel(scene=which).values), 29)
            axes.set_yticks(range(len(names)), names if column == 0 else [])
            axes.set_ylim(len(names) - 0.4, -0.6)
            axes.tick_params(labelsize=6.5, length=2, pad=1.5)
            if row == 1:
                axes.set_xlabel("time of a run [s]", fontsize=7, labelpad=2)
        dot: dict[str, Any] = {"marker": "o", "color": "#303030"}
        handles = [
            handle("first call in a process, loosest tolerance", mfc="white", **dot),
            handle("median repeat, middle tolerance", **dot),
            handle("no answer", marker="x", color="#303030", ms=3), handle("blank: not asked"),
        ]  # fmt: skip
        legend(figure, 0.14, handles, 4)
    return figure


def _first_panel(axes: Axes, here: xarray.Dataset, looks: dict[str, dict[str, Any]]) -> None:
    axes.grid(True, axis="x", linewidth=0.3, color="#dddddd")
    for line, (name, look) in enumerate(looks.items()):
        mine = here.sel(driver=name)
        colour = look["color"]
        if str(mine.status.values) == "not asked":
            continue
        rungs = np.flatnonzero(np.isfinite(mine.tolerance.values))
        times = mine.seconds.values[rungs]
        times = times[np.isfinite(times).any(axis=-1)]
        first = float(mine["first"])
        if not len(times):
            axes.plot([0.03], [line], "x", ms=3, mew=0.8, color=colour,
                      transform=axes.get_yaxis_transform())  # fmt: skip
            continue
        again = float(np.nanmedian(times[len(times) // 2]))
        axes.plot([again, first], [line] * 2, color=colour, linewidth=0.7, alpha=0.6)
        axes.plot([first], [line], "o", ms=3.2, mew=0.8, mec=colour, mfc="white")
        axes.plot([again], [line], "o", ms=3.2, mew=0.8, color=colour)
