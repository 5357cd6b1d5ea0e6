"""Figures only: cost against error of spectra and boundaries."""

from __future__ import annotations

from ...figures.canvas import STYLE, figure_style  # isort: skip

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ...figures.letters import SMALL, Letter, letters
from ..spectrum import dataset as spectral_data
from .panels import (
    LEFT,
    OWN,
    PALE,
    PEOPLE,
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


LOWEST, FLOOR = 3e-18, 1e-17
"""Lower end of an axis of errors, and the least error that is drawn."""
REFERENCES = ("ad-1e-9", "spectrum", "map", "certified")
"""Routes that are named wherever they are right: what people do, and what the package does."""


@dataclass(frozen=True)
class _Spot:
    """A route in a panel: its time, its largest error and the median one."""

    name: str
    own: bool
    time: float
    worst: float
    median: float


def spectrum_figure(chart: xarray.Dataset) -> Figure:
    """Time against error of the eigenvalues, a panel for each class of hardness.

    Parameters
    ----------
    chart
        From `stability.compare.spectrum.dataset.dataset`.

    Returns
    -------
    Figure
        A journal column wide.  Routes on the front and references have names, others are grey; a
        route with a wrong verdict has no mark.
    """
    names = answering(chart)
    kinds = chart.hardness.values.tolist()
    with figure_style(STYLE):
        figure, panels = page(len(kinds), 0.82, 0.5)
        low, high = span(np.concatenate([chart.one.values.ravel(), chart.many.values.ravel()]))
        shown = [_spots(chart, names, kind) for kind in kinds]
        for index, (axes, kind) in enumerate(zip(panels, kinds, strict=True)):
            row = shown[index - index % 2 : index - index % 2 + 2]
            worst = [s.worst for spots, _ in row for s in spots]
            log_axis(axes.xaxis, low, high * 4, 2)
            top = max([1e-13, *worst])
            log_axis(axes.yaxis, LOWEST, top * 60, 2 if top < 1e-10 else 4)
            spots, wrong = shown[index]
            title(
                axes,
                str(chart.class_title.sel(hardness=kind).values),
                named("wrong verdicts", wrong, len(names)),
            )
            standing = spectral_data.standing(chart, "eigenvalues", kind)
            _draw(axes, spots, {n for n, p in standing.items() if p.on_front}, set(REFERENCES))
        frame(panels, "time per point [s]", "error of eigenvalues")
        legend(figure, 0.3, _route_handles(), 3)
    return figure


def answering(chart: xarray.Dataset) -> list[str]:
    """Routes that have eigenvalues anywhere.

    Parameters
    ----------
    chart
        From `stability.compare.spectrum.dataset.dataset`.

    Returns
    -------
    list of str
    """
    some = np.isfinite(chart.eigenvalues.values).any(axis=(1, 2))
    return [n for n, has in zip(chart.route.values.tolist(), some, strict=True) if has]


def _spots(chart: xarray.Dataset, names: Sequence[str], kind: str) -> tuple[list[_Spot], list[str]]:
    """Routes whose verdicts are right, and the names of those that have a wrong one."""
    found, wrong = [], []
    for name in names:
        cell = chart.sel(route=name, hardness=kind)
        errors = cell.eigenvalues.values
        errors = np.maximum(errors[np.isfinite(errors)], FLOOR)
        if float(cell.wrong) > 0:
            wrong.append(name)
        elif errors.size and str(cell.status.values) == "done":
            time = spectral_data.seconds(chart, name, kind)[0]
            found.append(
                _Spot(name, bool(cell.own), time, float(errors.max()), float(np.median(errors)))
            )
    return found, wrong


def _draw(axes: Axes, spots: Sequence[_Spot], front: set[str], named: set[str]) -> None:
    """The front, a mark for each route, and names of those on the front and of others by name."""
    steps(axes, [(s.time, s.worst) for s in spots if s.name in front])
    written = []
    for spot in spots:
        told = spot.name in front or spot.name in named
        colour = (OWN if spot.own else PEOPLE) if told else PALE
        axes.plot(
            [spot.time] * 2,
            [spot.median, spot.worst],
            lw=0.7,
            alpha=0.6,
            color=colour,
            zorder=2,
            solid_capstyle="butt",
        )
        axes.plot(
            [spot.time],
            [spot.worst],
            "D" if spot.own else "o",
            ms=3,
            mew=0.7,
            mec=colour,
            mfc=colour if spot.own else "white",
            zorder=4 if told else 3,
        )
        if told:
            written.append(Letter(spot.time, spot.worst, spot.name, colour))
    letters(axes, written)


def _route_handles() -> list[object]:
    return [
        handle("the package's", marker="D", color=OWN),
        handle("common", marker="o", color=PEOPLE, mfc="white"),
        handle("other common", marker="o", color=PALE, mfc="white"),
        handle("down to the median", marker="|", ms=6, color="#555555"),
        front_handle(),
    ]


def boundary_figure(chart: xarray.Dataset) -> Figure:
    """Time against error of finding a boundary, and the errors at each boundary.

    Parameters
    ----------
    chart
        From `stability.compare.spectrum.dataset.dataset`.

    Returns
    -------
    Figure
        A journal column wide; routes that miss a boundary have no mark in the upper panel.
    """
    names: list[str] = chart.route.values.tolist()
    edges: list[str] = chart.boundary.values.tolist()
    with figure_style(STYLE):
        body, rows, gap, foot = 1.1, 0.125 * (len(edges) + 0.8), 0.36, 0.62
        tall = HEAD + body + gap + rows + foot
        figure = Figure(figsize=(WIDTH, tall))
        upper = figure.add_axes(
            (LEFT / WIDTH, (foot + rows + gap) / tall, (WIDTH - LEFT - RIGHT) / WIDTH, body / tall)
        )
        lower = figure.add_axes(
            (1.78 / WIDTH, foot / tall, (WIDTH - 1.78 - RIGHT) / WIDTH, rows / tall)
        )
        _boundary_panel(upper, chart, names)
        _boundary_rows(lower, chart, edges)
        own, common, _, median, front = _route_handles()
        missed = handle("missed, by how many", marker="x", color="black", ms=3.4)
        legend(figure, 0.33, [own, common, median, front, missed], 3)
    return figure


HEAD = 0.28
"""Room over the panel of boundaries [in]."""


def _boundary_panel(axes: Axes, chart: xarray.Dataset, names: Sequence[str]) -> None:
    spots, missing = [], []
    for name in names:
        route = chart.sel(route=name)
        asked = route.boundary_asked.values
        errors, times = route.boundary_error.values[asked], route.boundary_seconds.values[asked]
        if not np.isfinite(errors).all():
            missing.append(name)
        elif errors.size:
            known = np.maximum(errors, FLOOR)
            spots.append(
                _Spot(
                    name,
                    bool(route.own),
                    float(np.median(times)),
                    float(known.max()),
                    float(np.median(known)),
                )
            )
    log_axis(axes.xaxis, *span([s.time for s in spots], 3), 1)
    log_axis(axes.yaxis, LOWEST, max([1e-12, *(s.worst for s in spots)]) * 60, 4)
    standing = spectral_data.standing(chart, "boundary")
    _draw(axes, spots, {n for n, p in standing.items() if p.on_front}, {s.name for s in spots})
    frame([axes], "time per boundary [s]", "relative error")
    title(axes, named("miss at least one boundary", missing, len(names), 62), "", 70)


def _boundary_rows(axes: Axes, chart: xarray.Dataset, edges: Sequence[str]) -> None:
    """A row for each boundary: errors as marks, and how many routes miss it."""
    log_axis(axes.xaxis, LOWEST, 30.0, 4)
    axes.set_xticks([1e-16, 1e-12, 1e-8, 1e-4])
    axes.set_ylim(len(edges) - 0.4, -0.6)
    for row, edge in enumerate(edges):
        here = chart.sel(boundary=edge)
        asked = here.boundary_asked.values & np.isfinite(here.boundary_seconds.values)
        error, own = here.boundary_error.values, here.own.values
        for mine, colour in ((False, PEOPLE), (True, OWN)):
            known = np.maximum(error[asked & (own == mine) & np.isfinite(error)], FLOOR)
            axes.plot(
                known,
                [row + (0.14 if mine else -0.14)] * known.size,
                "D" if mine else "o",
                ms=2.4,
                mew=0.6,
                mec=colour,
                mfc=colour if mine else "white",
            )
        missed = int((asked & np.isnan(error)).sum())
        if missed:
            axes.plot([0.08], [row], "x", ms=3.2, mew=0.9, color="black")
            axes.annotate(
                str(missed),
                (0.08, row),
                (4, 0),
                textcoords="offset points",
                fontsize=SMALL,
                va="center_baseline",
            )
    axes.set_yticks(range(len(edges)), [_edge_words(e) for e in edges], fontsize=SMALL)
    axes.tick_params(labelsize=SMALL, length=2, pad=1.5)
    axes.set_xlabel("relative error", fontsize=7, labelpad=2)
    axes.grid(True, axis="y", linewidth=0.3, color="#dddddd")
    axes.set_axisbelow(True)


def _edge_words(edge: str) -> str:
    family, law, k, mu = edge.split()
    return f"{family}, {law}, k = {k}" + ("" if mu == "None" else f", μ = {float(mu):g}")
