"""Figures only: work against precision of motions, and what a first call costs."""

from __future__ import annotations

from ...figures.canvas import STYLE, figure_style  # isort: skip

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from ..motion import dataset as motion_data
from ..motion.cases import NO_ANSWER
from ..pareto import places
from .panels import (
    DIGIT,
    LETTERS,
    OWN,
    PALE,
    RIGHT,
    WIDTH,
    frame,
    front_handle,
    handle,
    legend,
    log_axis,
    named,
    page,
    span,
    steps,
    title,
)

if TYPE_CHECKING:
    import xarray


LABELS = {
    "final": "error of the last state",
    "path": "error along the path",
    "audit": "error of the energy account",
    "event": "error of event times",
}
"""Label of the error by metric."""
LOWEST, HIGHEST = 1e-16, 1e2
"""Ends of an axis of errors."""
REFERENCES = ("simulate", "rk45")
"""Drivers that are drawn in colour in every panel: the package's default and SciPy's."""
SHORT = {
    "simulate": "simulate()",
    "unchecked": "simulate(check=False)",
    "rk45": "SciPy RK45",
    "rough-model": "rough model",
    "smooth-model": "smooth model",
}
"""Names in the legend where they differ from those of the drivers."""
LOOKS: dict[str, dict[str, Any]] = {
    "simulate": {"color": OWN, "marker": "o", "lw": 1.6, "ms": 3.2, "zorder": 5},
    "unchecked": {"color": OWN, "marker": "o", "mfc": "white", "zorder": 4.5},
    "heyoka": {"color": "#0072B2", "marker": "s"},
    "dop853": {"color": "#E69F00", "marker": "^"},
    "lsoda": {"color": "#000000", "marker": "v"},
    "radau": {"color": "#CC79A7", "marker": "p"},
    "bdf": {"color": "#882255", "marker": "h"},
    "cvodes": {"color": "#56B4E9", "marker": "<"},
    "idas": {"color": "#332288", "marker": ">"},
    "rk45": {"color": "#6a6a6a", "marker": "X", "ms": 3.2},
    "rk4": {"color": "#6a6a6a", "marker": "s", "mfc": "white"},
    "rough-model": {"color": "#7f4f24", "marker": "D"},
    "smooth-model": {"color": "#9c6b24", "marker": "d"},
    "regularised": {"color": "#4d3b1f", "marker": "D", "mfc": "white"},
}
"""Line and marker of every driver."""
PLAIN: dict[str, Any] = {"ls": "-", "lw": 0.8, "ms": 2.4, "mew": 0.6, "zorder": 4}
"""What their looks have in common."""


def panels_of(chart: xarray.Dataset, metric: str) -> list[str]:
    """Scenes in which any driver has the error.

    Parameters
    ----------
    chart
        From `stability.compare.motion.dataset.dataset`.
    metric
        One of `stability.compare.motion.measure.METRICS`.

    Returns
    -------
    list of str
    """
    return [w for w in chart.scene.values.tolist() if motion_data.points(chart, w, metric)]


def motion_figure(chart: xarray.Dataset, metric: str = "path") -> Figure:
    """Work against precision through the tolerances, a panel for each scene that has the error.

    Parameters
    ----------
    chart
        From `stability.compare.motion.dataset.dataset`.
    metric
        One of `stability.compare.motion.measure.METRICS`.

    Returns
    -------
    Figure
        A journal column wide.  In colour: drivers on the front with at least one digit, and
        references; others are grey, and those with a wrong outcome are named over the panel.
    """
    scenes = panels_of(chart, metric)
    low, high = span(chart.seconds.values)
    with figure_style(STYLE):
        told = {which: _told(chart, which, metric) for which in scenes}
        everywhere = [n for n in LOOKS if any(n in names for names in told.values())]
        handles = _handles(everywhere)
        figure, panels = page(len(scenes), 1.0, 0.3 + 0.13 * -(-len(handles) // 3))
        for axes, which in zip(panels, scenes, strict=True):
            log_axis(axes.xaxis, low, high, 1)
            log_axis(axes.yaxis, LOWEST, HIGHEST, 4)
            here = chart.sel(scene=which)
            title(axes, str(here.scene_title.values), _silent(here))
            _draw(axes, motion_data.points(chart, which, metric), told[which])
            steps(axes, _front(chart, which, metric)[1])
        frame(panels, "time of a run [s]", LABELS[metric])
        legend(figure, 0.05 + 0.13 * -(-len(handles) // 3), handles, 3)
    return figure


def _front(
    chart: xarray.Dataset, which: str, metric: str
) -> tuple[set[str], list[tuple[float, float]]]:
    """Drivers on the front that have a digit right, and the points of the front."""
    flat = {
        f"{name} {rung}": point
        for name, rows in motion_data.points(chart, which, metric).items()
        for rung, point in enumerate(rows)
    }
    best = {key: p for key, p in places(flat).items() if p.on_front and p.error < DIGIT}
    spots = [(p.time, max(p.error, 2 * LOWEST)) for p in best.values()]
    return {key.split()[0] for key in best}, spots


def _told(chart: xarray.Dataset, which: str, metric: str) -> set[str]:
    """Drivers in colour in a panel."""
    return (_front(chart, which, metric)[0] | set(REFERENCES)) & set(
        motion_data.points(chart, which, metric)
    )


def _draw(axes: Axes, found: dict[str, list[tuple[float, float]]], told: set[str]) -> None:
    for name, rows in found.items():
        times, errors = np.array(rows).T
        errors = np.clip(errors, 2 * LOWEST, HIGHEST / 2)
        if name in told:
            axes.plot(times, errors, **(PLAIN | LOOKS[name]))
        else:
            axes.plot(times, errors, color=PALE, lw=0.6, marker=".", ms=1.6, zorder=2)


def _silent(here: xarray.Dataset) -> str:
    """A note: drivers with a wrong outcome at some tolerance, and those without any answer."""
    ran = np.isfinite(here.seconds.values).any(axis=-1)
    wrong = ran & (here.outcome.values != str(here.true_outcome.values))
    wrong &= ~np.isin(here.outcome.values, NO_ANSWER)
    asked = here.status.values != "not asked"
    mute = asked & ~ran.any(axis=-1)
    names = here.driver.values
    bad, none = names[wrong.any(axis=-1)].tolist(), names[mute].tolist()
    both = "; ".join(
        named(*pair, int(asked.sum()), 99)
        for pair in (("wrong", bad), ("no answer", none))
        if pair[1]
    )
    if len(both) <= LETTERS + 3:
        return both
    return "; ".join(f"{w}: {len(n)}" for w, n in (("wrong", bad), ("no answer", none)) if n) + (
        f" of {int(asked.sum())}"
    )


def _handles(names: list[str]) -> list[Any]:
    return [
        *(handle(SHORT.get(name, name), **(PLAIN | LOOKS[name])) for name in names),
        handle("others", ls="-", color=PALE, lw=0.8, marker=".", ms=1.6),
        front_handle(),
    ]


def first_call_figure(chart: xarray.Dataset) -> Figure:
    """Time of the first call, graphs built and code compiled, next to that of a repeat.

    Parameters
    ----------
    chart
        From `stability.compare.motion.dataset.dataset`.

    Returns
    -------
    Figure
        A journal column wide: a row for each driver, with the median over the scenes and a line
        from the least to the most.
    """
    names = chart.driver.values.tolist()
    left, body, foot = 0.78, 0.15 * len(names), 0.52
    height = body + foot + 0.05
    with figure_style(STYLE):
        figure = Figure(figsize=(WIDTH, height))
        axes = figure.add_axes(
            (left / WIDTH, foot / height, (WIDTH - left - RIGHT) / WIDTH, body / height)
        )
        log_axis(axes.xaxis, *span([*_repeats(chart).ravel(), *chart["first"].values.ravel()]), 1)
        axes.grid(True, axis="x", linewidth=0.3, color="#dddddd")
        for line, (again, first) in enumerate(
            zip(_repeats(chart).T, chart["first"].values.T, strict=True)
        ):
            for times, shift, look in ((again, -0.16, SOLID), (first, 0.16, OPEN)):
                known = times[np.isfinite(times)]
                if known.size:
                    axes.plot(
                        [known.min(), known.max()],
                        [line + shift] * 2,
                        lw=0.8,
                        color=look["mec"],
                        alpha=0.6,
                    )
                    axes.plot([np.median(known)], [line + shift], **look)
        axes.set_yticks(range(len(names)), names)
        axes.set_ylim(len(names) - 0.4, -0.6)
        axes.tick_params(labelsize=6.5, length=2, pad=1.5)
        axes.set_xlabel("time of a run [s]", fontsize=7, labelpad=2)
        legend(
            figure,
            0.24,
            [
                handle("repeat, middle tolerance", **SOLID),
                handle("first call in a process", **OPEN),
            ],
            2,
        )
    return figure


SOLID: dict[str, Any] = {
    "marker": "o",
    "ms": 3.2,
    "mew": 0.8,
    "mec": "#303030",
    "mfc": "#303030",
    "ls": "",
}
OPEN: dict[str, Any] = SOLID | {"mec": OWN, "mfc": "white"}
"""Marks of repeats and of first calls."""


def _repeats(chart: xarray.Dataset) -> NDArray[Any]:
    """Least repeat at the middle tolerance, shape (scenes, drivers); NaN without an answer."""
    found = np.full((chart.sizes["scene"], chart.sizes["driver"]), np.nan)
    for place in np.ndindex(found.shape):
        times = chart.seconds.values[place]
        times = times[np.isfinite(times).any(axis=-1)]
        if len(times):
            found[place] = np.nanmin(times[len(times) // 2])
    return found
