"""Figures only: cost against error of spectra and boundaries; the charts' other figures by name."""

from __future__ import annotations

from ...figures.canvas import STYLE, figure_style  # isort: skip

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ...figures.letters import SMALL, Letter, lettered, letters  # fmt: skip
from ..spectrum import dataset as spectral_data
from .failure_grid import catalogue_figure, ladder_figure
from .panels import (
    CROSS,
    FRONT,
    OWN,
    PEOPLE,
    ROW,
    WIDTH,
    Panel,
    crosses,
    frame,
    handle,
    key,
    legend,
    log_axis,
    page,
    span,
    steps,
    title,
    under,
)
from .work_precision import first_call_figure, motion_figure

if TYPE_CHECKING:
    import xarray


__all__ = ["boundary_figure", "catalogue_figure", "first_call_figure", "ladder_figure",
           "motion_figure", "spectrum_figure"]  # fmt: skip
LABELS = {
    "eigenvalues": "error of the eigenvalues",
    "abscissa": "relative error of the abscissa",
    "verdict": "share undecided",
}
"""Label of the error by quantity."""
LOWEST, HIGHEST = 3e-18, 3e2
"""Ends of an axis of errors."""


@dataclass(frozen=True)
class _Spot:
    """A route in a panel."""

    name: str
    letter: str
    own: bool
    default: bool
    best: float
    one: float
    worst: float
    median: float
    note: str = ""

    @property
    def colour(self) -> str:
        return OWN if self.own else PEOPLE

    def marked(self, words: str = "") -> Letter:
        return Letter(self.best, min(self.worst, HIGHEST / 10), f"{self.letter} {words}".strip(),
                      self.colour)  # fmt: skip


def spectrum_figure(chart: xarray.Dataset, quantity: str) -> Figure:
    """Time against error of every route to a spectrum, a panel for each class of hardness.

    Parameters
    ----------
    chart
        From `stability.compare.spectrum.dataset.dataset`.
    quantity
        eigenvalues, abscissa or verdict.

    Returns
    -------
    Figure
        Two journal columns wide; routes with a wrong verdict stand in a strip over their panel.
    """
    names = _answering(chart, quantity)
    mine = chart.sel(route=names)
    # a letter means the same route in every figure
    every = dict(zip(chart.route.values.tolist(), lettered(chart.own.values.tolist()), strict=True))
    marks = {name: every[name] for name in names}
    wrong = (mine.wrong > 0).sum("route").values
    strips = [max(2, int(wrong[i : i + 4].max())) for i in range(0, len(wrong), 4)]
    low, high = span([v for k in ("one", "many") for v in mine[k].values.ravel()])
    with figure_style(STYLE):
        listed = (-(-len(names) // 2) + 0.5) * 1.12 * ROW
        figure, panels = page(strips, 1.1 if quantity == "verdict" else 1.5, listed + 0.42)
        for index, panel in enumerate(panels[: mine.sizes["hardness"]]):
            here = mine.isel(hardness=index)
            log_axis(panel.main.xaxis, low, high, 2)
            _error_axis(panel.main, quantity)
            title(panel.strip, str(here.class_title.values))
            _spectrum_panel(panel, here, chart, quantity, marks, strips[index // 4])
        frame(panels, "time per point [s]", LABELS[quantity], "wrong verdicts")
        _route_key(figure, mine, marks, listed, quantity)
    return figure


def _answering(chart: xarray.Dataset, quantity: str) -> list[str]:
    """Routes that have the quantity anywhere, or have no answer at all."""
    names: list[str] = chart.route.values.tolist()
    if quantity == "verdict":
        return names
    done = (chart.status == "done").any("hardness").values
    some = np.isfinite(chart[quantity].values).any(axis=(1, 2))
    return [n for n, d, s in zip(names, done, some, strict=True) if s or not d]


def _error_axis(axes: Axes, quantity: str) -> None:
    if quantity == "verdict":
        axes.set_ylim(-0.17, 1.06)
    else:
        log_axis(axes.yaxis, LOWEST, HIGHEST, 4)


def _spectrum_panel(
    panel: Panel, here: xarray.Dataset, chart: xarray.Dataset, quantity: str,
    marks: dict[str, str], rows: int,
) -> None:  # fmt: skip
    hardness = str(here.hardness.values)
    shown, wrong, silent = [], [], []
    for name, letter in marks.items():
        cell = here.sel(route=name)
        spot = _spot(chart, cell, quantity, letter)
        if str(cell.status.values) != "done" or not np.isfinite(spot.best):
            silent.append(letter)
        elif float(cell.wrong) > 0:
            count = f"{int(cell.wrong)}/{int(cell['count'])}"
            wrong.append(Letter(spot.best, 0.0, f"{letter} {count}", spot.colour))
        elif np.isfinite(spot.worst):
            shown.append(spot)
        else:
            silent.append(letter)
    standing = spectral_data.standing(chart, quantity, hardness)
    steps(panel.main, [(p.time, max(p.error, LOWEST)) if quantity != "verdict" else
                       (p.time, p.error) for p in standing.values() if p.on_front])  # fmt: skip
    for spot in shown:
        _draw_spot(panel.main, spot)
    crosses(panel.strip, wrong, rows)
    letters(panel.main, [s.marked(s.note) for s in shown])
    under(panel.main, f"no answer: {', '.join(silent)}" if silent else "")


def _spot(chart: xarray.Dataset, cell: xarray.Dataset, quantity: str, letter: str) -> _Spot:
    name = str(cell.route.values)
    best, one = spectral_data.seconds(chart, name, str(cell.hardness.values))
    undecided, note = float(cell.undecided), ""
    if quantity == "verdict":
        errors = np.array([undecided / float(cell["count"])])
    else:
        errors = cell[quantity].values
        errors = np.maximum(errors[np.isfinite(errors)], 2 * LOWEST)
        note = f"{undecided:.0f} undecided" if undecided > 0 else ""
    worst, median = (float(f(errors)) if errors.size else np.nan for f in (np.max, np.median))
    return _Spot(name, letter, bool(cell.own), bool(cell.default), best, one, worst, median, note)


def _draw_spot(axes: Axes, spot: _Spot) -> None:
    """Marker at the largest error, bar down to the median, line to the time of one point."""
    thin: dict[str, Any] = {"color": spot.colour, "solid_capstyle": "butt"}
    top = HIGHEST / 10 if spot.worst > HIGHEST / 10 else spot.worst
    if spot.median < top:
        axes.plot([spot.best] * 2, [spot.median, top], lw=0.7, alpha=0.6, zorder=2, **thin)
    if np.isfinite(spot.one) and spot.one != spot.best:
        axes.plot([spot.best, spot.one], [top] * 2, lw=0.4, alpha=0.55, zorder=1.8, **thin)
        axes.plot([spot.one], [top], marker="|", ms=2.6, mew=0.5, color=spot.colour, zorder=1.8)
    shape = "^" if spot.worst > top else "D" if spot.default else "o"
    axes.plot([spot.best], [top], shape, ms=3.2 if spot.own else 3.0, mew=0.7, mec=spot.colour,
              mfc=spot.colour if spot.own else "white", zorder=5 if spot.own else 4,
              clip_on=False)  # fmt: skip


def _route_key(
    figure: Figure, mine: xarray.Dataset, marks: dict[str, str], listed: float, quantity: str
) -> None:
    plain = quantity == "verdict"
    handles = [
        handle("the package, default", marker="D", color=OWN),
        handle("the package, other", marker="o", color=OWN),
        handle("people's", marker="o", color=PEOPLE, mfc="white"),
        *([] if plain else [handle("down to the median error", marker="|", ms=7, color="#555555")]),
        *([] if plain or quantity == "boundary" else
          [handle("off the scale", marker="^", color="#555555")]),
        *([] if quantity == "boundary" else
          [handle("to the time of a call with one point", ls="-", lw=0.6, color="#555555")]),
        handle("front: nothing faster is as accurate", ls="-", lw=1.3, color=FRONT),
        handle("not found: boundaries missed" if quantity == "boundary" else
               "wrong verdicts/points", **CROSS),
    ]  # fmt: skip
    legend(figure, listed + 0.36, handles, 4)
    words = dict(zip(mine.route.values.tolist(), mine.title.values.tolist(), strict=True))
    own = dict(zip(mine.route.values.tolist(), mine.own.values.tolist(), strict=True))
    # people's routes first, as in the dataset
    key(figure, listed, [(marks[n], f"{n}: {words[n]}", own[n]) for n in marks])


def boundary_figure(chart: xarray.Dataset) -> Figure:
    """Time against error of finding a boundary, and the error of each route at each boundary.

    Parameters
    ----------
    chart
        From `stability.compare.spectrum.dataset.dataset`.

    Returns
    -------
    Figure
        Two journal columns wide; routes that miss a boundary stand in a strip.
    """
    names: list[str] = chart.route.values.tolist()
    marks = dict(zip(names, lettered(chart.own.values.tolist()), strict=True))
    spots = [_edge_spot(chart.sel(route=n), marks[n]) for n in names]
    wrong = [s for s in spots if s.note]
    with figure_style(STYLE):
        listed = (-(-len(names) // 2) + 0.5) * 1.12 * ROW
        foot, strip, body = listed + 0.75, ROW * (max(2, len(wrong)) + 0.6), 3.0
        tall = foot + body + 0.03 + strip + 0.2
        figure = Figure(figsize=(WIDTH, tall))
        upper = figure.add_axes((0.075, (foot + body + 0.03) / tall, 0.325, strip / tall))
        lower = figure.add_axes((0.075, foot / tall, 0.325, body / tall), sharex=upper)
        upper.set(ylim=(0, 1), yticks=[], facecolor="#f1f1f1")
        upper.tick_params(axis="x", length=0, labelbottom=False)
        log_axis(lower.xaxis, *span([s.best for s in spots]), 1)
        log_axis(lower.yaxis, LOWEST, 3.0, 4)
        _boundary_panel(Panel(lower, upper), chart, spots)
        frame([Panel(lower, upper)], "", "relative error of a boundary", "")
        lower.set_xlabel("time per boundary [s]", fontsize=7, labelpad=2)
        title(upper, "boundaries missed", 40)
        rows = figure.add_axes((0.665, foot / tall, 0.325, (body + 0.03 + strip) / tall))
        _boundary_rows(rows, chart, marks)
        _route_key(figure, chart, marks, listed, "boundary")
    return figure


def _edge_spot(route: xarray.Dataset, letter: str) -> _Spot:
    asked = route.boundary_asked.values
    errors, times = route.boundary_error.values[asked], route.boundary_seconds.values[asked]
    known = np.maximum(errors[np.isfinite(errors)], 2 * LOWEST)
    missed, times = len(errors) - len(known), times[np.isfinite(times)]
    worst, median = (float(f(known)) if known.size else np.nan for f in (np.max, np.median))
    best = float(np.median(times)) if times.size else np.nan
    return _Spot(str(route.route.values), letter, bool(route.own), bool(route.default), best,
                 best, worst, median, f"{missed}/{len(errors)}" if missed else "")  # fmt: skip


def _boundary_panel(panel: Panel, chart: xarray.Dataset, spots: Sequence[_Spot]) -> None:
    standing = spectral_data.standing(chart, "boundary")
    steps(panel.main, [(p.time, p.error) for p in standing.values() if p.on_front])
    wrong = [s for s in spots if s.note and np.isfinite(s.best)]
    shown = [s for s in spots if not s.note and np.isfinite(s.worst)]
    silent = [s.letter for s in spots if not np.isfinite(s.best)]
    for spot in shown:
        _draw_spot(panel.main, spot)
    found = [Letter(s.best, 0.0, f"{s.letter} {s.note}", s.colour) for s in wrong]
    crosses(panel.strip, found, max(2, len(wrong)))
    letters(panel.main, [s.marked() for s in shown])
    under(panel.main, f"no answer: {', '.join(silent)}" if silent else "")


def _boundary_rows(axes: Axes, chart: xarray.Dataset, marks: dict[str, str]) -> None:
    """A row for each boundary: errors as markers, nearly equal errors with one text."""
    log_axis(axes.xaxis, LOWEST / 30, 1e6, 4)
    axes.set_xticks([1e-16, 1e-12, 1e-8, 1e-4])
    edges = chart.boundary.values.tolist()
    axes.set_ylim(len(edges) - 0.4, -0.7)
    axes.axvspan(1e-1, 1e6, color="#f1f1f1", zorder=0)
    axes.text(300, -0.8, "missed", fontsize=SMALL, ha="center", va="bottom")
    written: list[Letter] = []
    for row, edge in enumerate(edges):
        here = chart.sel(boundary=edge)
        groups: dict[tuple[int, bool], list[tuple[float, str]]] = {}
        for name, letter in marks.items():
            one = here.sel(route=name)
            # the other panel lists routes without any answer
            if bool(one.boundary_asked) and np.isfinite(one.boundary_seconds):
                error = max(float(one.boundary_error), 2 * LOWEST)
                where = 99 if np.isnan(error) else round(np.log10(error) * 0.8)
                groups.setdefault((where, bool(one.own)), []).append((error, letter))
        written += [mark for g in groups.items() if (mark := _together(axes, row, *g))]
    letters(axes, written)
    axes.set_yticks(range(len(edges)), [_edge_words(e) for e in edges], fontsize=SMALL)
    axes.tick_params(labelsize=SMALL, length=2, pad=1.5)
    axes.set_xlabel("relative error of a boundary", fontsize=7, labelpad=2)
    axes.grid(True, axis="y", linewidth=0.3, color="#dddddd")


def _together(
    axes: Axes, row: int, kind: tuple[int, bool], found: list[tuple[float, str]]
) -> Letter | None:
    where, own = kind
    colour, text = OWN if own else PEOPLE, "".join(letter for _, letter in found)
    if where == 99:
        axes.plot([0.8], [row], **CROSS)
        axes.annotate(text, (0.8, row), (3.5, 0), textcoords="offset points", fontsize=SMALL,
                      color=colour, va="center_baseline")  # fmt: skip
        return None
    errors = [e for e, _ in found]
    y = row + (0.1 if own else -0.1)
    axes.plot(errors, [y] * len(errors), "o", ms=2.8, mew=0.6, mec=colour,
              mfc=colour if own else "white")  # fmt: skip
    return Letter(max(errors), y, text, colour)


def _edge_words(edge: str) -> str:
    family, law, k, mu = edge.split()
    return f"{family}, {law}, k = {k}" + ("" if mu == "None" else f", μ = {float(mu):g}")
