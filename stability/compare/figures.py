"""Figures only, of the comparison: cost against error, shares of answers, work against precision.

To add a figure: a function from a dataset of the comparison to a `Figure`, and a `Plate` for it in
`compare/report.py`.
"""

from __future__ import annotations

from ..figures.canvas import COLUMN, STYLE, figure_style  # isort: skip

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from textwrap import fill, wrap
from typing import TYPE_CHECKING, Any, Literal

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Rectangle
from matplotlib.textpath import TextPath
from matplotlib.ticker import FixedLocator, NullLocator
from numpy.typing import NDArray

from ..base.looks import BLUE, GREEN, VERMILION
from ..base.looks import LOOKS as VERDICT_LOOKS
from ..base.printing import two_digits
from ..figures.letters import SMALL, Letter, letters
from .calls import QUESTIONS
from .failures import STEPS, Entry, asked_edges, ladder
from .marks import Mark
from .motion import chart as motion_chart
from .motion.cases import NO_ANSWER
from .motion.drivers import DRIVERS
from .spectrum import chart as spectrum_chart
from .spectrum.cases import DECADES
from .spectrum.routes import ROUTES

if TYPE_CHECKING:
    import xarray

WIDTH = COLUMN
"""Width of a figure: a journal column, which is also readable on a phone [in]."""
OWN, PEOPLE, FRONT, PALE = VERMILION, BLUE, GREEN, "#b4b4b4"
"""Colours of the package's routes, of those people use, of the front, and of all others."""
LEFT, RIGHT, BETWEEN = 0.46, 0.09, 0.12
"""Margins next to and between panels [in]."""
HEAD, FOOT = 0.4, 0.2
"""Room over a panel for its title and a note, and under it for its ticks [in]."""
CORNER = 0.1
"""Part of an x axis at each of its ends that has no tick [in]; half a number is as wide."""
NUMBER = 0.25
"""Least distance of ticks on an x axis, by the width of their numbers [in]."""
LETTERS = 29
"""Letters in a line of a title."""
DIGIT = 0.1
"""Error beyond which no digit is right, so that speed counts for nothing."""


def page(count: int, body: float, below: float) -> tuple[Figure, list[Axes]]:
    """A figure with rows of two panels; a single panel is as wide as the figure.

    Parameters
    ----------
    count
        Number of panels.
    body
        Height of a panel [in].
    below
        Height left free at the bottom, for the label of the axes and a legend [in].

    Returns
    -------
    Figure, list of Axes
        Row by row.
    """
    height = -(-count // 2) * (HEAD + body + FOOT) + below
    wide = WIDTH - LEFT - RIGHT if count == 1 else (WIDTH - LEFT - RIGHT - BETWEEN) / 2
    figure = Figure(figsize=(WIDTH, height))
    panels = []
    for index in range(count):
        row, column = divmod(index, 2)
        x, y = LEFT + column * (wide + BETWEEN), height - row * FOOT - (row + 1) * (HEAD + body)
        panels.append(panel(figure, x, y, wide, body))
    return figure, panels


def panel(figure: Figure, x: float, y: float, wide: float, tall: float) -> Axes:
    """A panel by its lower left corner and its size [in]."""
    width, height = figure.get_figwidth(), figure.get_figheight()
    return figure.add_axes((x / width, y / height, wide / width, tall / height))


def rules(axes: Axes, along: Literal["both", "x", "y"] = "both") -> None:
    """Pale lines at the ticks, below what is drawn."""
    axes.grid(True, axis=along, linewidth=0.3, color="#dddddd")
    axes.set_axisbelow(True)


def title(axes: Axes, text: str, note: str = "", width: int = LETTERS) -> None:
    """A title in at most two lines, broken after its colon where it has one, and a grey note."""
    text = text.replace(" = ", "\u00a0=\u00a0")  # no line ends within an equation
    first, colon, rest = text.partition(": ")
    lines = [first + colon.strip(), rest]
    if not colon or len(text) <= width or max(map(len, lines)) > width:
        # lines of about the same length
        count = len(wrap(text, width))
        lines = next(ls for n in range(1, width + 1) if len(ls := wrap(text, n)) <= count)
    axes.annotate(
        note,
        (0.5, 1),
        (0, 2),
        xycoords="axes fraction",
        textcoords="offset points",
        fontsize=SMALL,
        color="#555555",
        ha="center",
        va="bottom",
    )
    axes.set_title("\n".join(lines), fontsize=6.5, pad=10.5 if note else 3, linespacing=1.05)


def log_axis(axis: Any, low: float, high: float, step: int) -> None:
    """A log axis with a tick at every `step` decades.

    An x axis has no tick at its ends, where a number would reach into those of the y axis or of
    the next panel, and fewer ticks where the numbers would touch.  Set the panel's place before.
    """
    axes = axis.axes
    axes.set(**{f"{axis.axis_name}scale": "log", f"{axis.axis_name}lim": (low, high)})
    start, end = np.log10([low, high])
    room = 0.0
    if axis.axis_name == "x":
        wide = axes.get_position().width * axes.get_figure().get_figwidth()
        room = CORNER / wide * (end - start)
        step *= int(np.ceil(NUMBER / wide * (end - start) / step))
    powers = np.arange(np.ceil(start + room), np.floor(end - room) + 1)
    axis.set_major_locator(FixedLocator(10.0 ** powers[powers % step == 0]))
    axis.set_minor_locator(NullLocator())


def span(values: Any, room: float = 1.8) -> tuple[float, float]:
    """Ends of a log axis that holds the values, with some room."""
    positive = np.asarray(values, dtype=float).ravel()
    positive = positive[np.isfinite(positive) & (positive > 0)]
    if not positive.size:
        return 1e-3, 1.0
    return float(positive.min() / room), float(positive.max() * room)


def frame(panels: Sequence[Axes], x: str, y: str) -> None:
    """Label the outer axes of a page; inner panels have ticks alone."""
    for index, axes in enumerate(panels):
        rules(axes)
        axes.tick_params(labelsize=SMALL + 0.5, length=2, pad=1.5, labelleft=index % 2 == 0)
        if index % 2 == 0:
            axes.set_ylabel(y, fontsize=7, labelpad=1)
        if index >= len(panels) - 2:
            axes.set_xlabel(x, fontsize=7, labelpad=2)


def steps(axes: Axes, spots: Sequence[tuple[float, float]]) -> None:
    """Draw the front as a broad step line: the least error within a time."""
    if not spots:
        return
    times, errors = np.array(sorted(spots)).T
    # ties on the front must not make the line rise again
    errors = np.minimum.accumulate(errors)
    # corners one by one, so that labels can avoid the line
    axes.plot(
        np.append(np.repeat(times, 2)[1:], axes.get_xlim()[1]),
        np.repeat(errors, 2),
        solid_joinstyle="miter",
        solid_capstyle="butt",
        **BROAD,
    )


BROAD: dict[str, Any] = {"color": FRONT, "alpha": 0.35, "linewidth": 2.6, "zorder": 1.5}
"""Stroke of the front."""


def handle(words: str, **look: Any) -> Line2D:
    """An entry of a legend."""
    plain: dict[str, Any] = {"ls": "", "ms": 4.2, "mew": 0.8}
    return Line2D([], [], label=words, **(plain | look))


def front_handle() -> Line2D:
    """The entry of the front in a legend."""
    return handle("Pareto front", ls="-", **{k: v for k, v in BROAD.items() if k != "zorder"})


def legend(figure: Figure, top: float, handles: Sequence[Any], columns: int) -> None:
    """A legend across the figure.

    Parameters
    ----------
    figure
        The figure.
    top
        Upper edge of the legend, from the bottom of the figure [in].
    handles
        Entries of the legend.
    columns
        Number of columns.
    """
    figure.legend(
        handles=handles,
        loc="upper center",
        ncols=columns,
        frameon=False,
        bbox_to_anchor=(0.5, top / figure.get_figheight()),
        fontsize=SMALL + 0.5,
        columnspacing=1.0,
        handletextpad=0.4,
        handlelength=1.8,
        borderpad=0,
        labelspacing=0.35,
    )


def named(words: str, names: Sequence[str], count: int, width: int = LETTERS + 3) -> str:
    """A note on some of the methods: their names, or where these are too long how many.

    Examples
    --------
    >>> named("wrong", ["rk4"], 9), named("wrong", [], 9)
    ('wrong: rk4', '')
    >>> named("wrong", ["a-long-name"] * 4, 9)
    'wrong: 4 of 9 methods'
    """
    if not names:
        return ""
    text = f"{words}: {', '.join(names)}"
    return text if len(text) <= width else f"{words}: {len(names)} of {count} methods"


# --- cost against error of spectra and boundaries ---


BOTTOM, FLOOR = 3e-18, 1e-17
"""Lower end of an axis of errors, and the least error that is drawn."""
REFERENCE_ROUTES = ("ad-1e-9", "spectrum", "certified")
"""Routes that are named wherever they are right: what people do, and what the package does."""


@dataclass(frozen=True)
class _Spot:
    """A route in a panel: its time, its largest error and the median one."""

    name: str
    own: bool
    time: float
    worst: float
    median: float

    @classmethod
    def of(cls, route: xarray.Dataset, time: float, errors: Any) -> _Spot:
        """A route by its part of the chart, its time, and its errors."""
        sizes = np.maximum(errors, FLOOR)
        name, ours = str(route.route.values), bool(route.own)
        return cls(name, ours, time, float(sizes.max()), float(np.median(sizes)))


def spectrum_figure(chart: xarray.Dataset) -> Figure:
    """Time against error of the eigenvalues, a panel for each class of hardness.

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
            log_axis(axes.yaxis, BOTTOM, top * 60, 2 if top < 1e-10 else 4)
            spots, wrong = shown[index]
            title(
                axes,
                str(chart.class_title.sel(hardness=kind).values),
                named("wrong verdicts", wrong, len(names)),
            )
            standing = spectrum_chart.standing(chart, "eigenvalues", kind)
            _draw_routes(
                axes, spots, {n for n, p in standing.items() if p.on_front}, set(REFERENCE_ROUTES)
            )
        frame(panels, "time per point [s]", "error of eigenvalues")
        legend(figure, 0.3, _route_handles(), 3)
    return figure


def answering(chart: xarray.Dataset) -> list[str]:
    """Routes that have eigenvalues anywhere."""
    some = np.isfinite(chart.eigenvalues.values).any(axis=(1, 2))
    return [n for n, has in zip(chart.route.values.tolist(), some, strict=True) if has]


def _spots(chart: xarray.Dataset, names: Sequence[str], kind: str) -> tuple[list[_Spot], list[str]]:
    """Routes whose verdicts are right, and the names of those that have a wrong one."""
    spots, wrong = [], []
    for name in names:
        cell = chart.sel(route=name, hardness=kind)
        errors = cell.eigenvalues.values
        errors = errors[np.isfinite(errors)]
        if float(cell.wrong) > 0:
            wrong.append(name)
        elif errors.size and str(cell.status.values) == "done":
            time = spectrum_chart.seconds(chart, name, kind)[0]
            spots.append(_Spot.of(cell, time, errors))
    return spots, wrong


def _draw_routes(axes: Axes, spots: Sequence[_Spot], front: set[str], named: set[str]) -> None:
    """The front, a mark for each route, and names of those on the front and of others by name."""
    steps(axes, [(s.time, s.worst) for s in spots if s.name in front])
    written = []
    for spot in spots:
        bold = spot.name in front or spot.name in named
        colour = (OWN if spot.own else PEOPLE) if bold else PALE
        axes.plot(
            [spot.time] * 2,
            [spot.median, spot.worst],
            lw=0.7,
            alpha=0.6,
            color=colour,
            zorder=2,
            solid_capstyle="butt",
        )
        look = _look(colour, ours=spot.own)
        axes.plot([spot.time], [spot.worst], ms=3, mew=0.7, zorder=4 if bold else 3, **look)
        if bold:
            written.append(Letter(spot.time, spot.worst, spot.name, colour))
    letters(axes, written)


def _look(colour: str, *, ours: bool) -> dict[str, Any]:
    """Mark of a route: the package's are full diamonds."""
    return {
        "ls": "",
        "marker": "D" if ours else "o",
        "color": colour,
        "mfc": colour if ours else "white",
    }


def _route_handles() -> list[object]:
    return [
        handle("the package's", **_look(OWN, ours=True)),
        handle("common", **_look(PEOPLE, ours=False)),
        handle("other common", **_look(PALE, ours=False)),
        handle("down to the median", marker="|", ms=6, color="#555555"),
        front_handle(),
    ]


def boundary_figure(chart: xarray.Dataset) -> Figure:
    """Time against error of finding a boundary, and the errors at each boundary.

    Returns
    -------
    Figure
        A journal column wide; routes that miss a boundary have no mark in the upper panel.
    """
    names: list[str] = chart.route.values.tolist()
    edges: list[str] = chart.boundary.values.tolist()
    with figure_style(STYLE):
        body, rows, gap, foot = 1.1, 0.125 * (len(edges) + 0.8), 0.36, 0.62
        tall = HEADROOM + body + gap + rows + foot
        figure = Figure(figsize=(WIDTH, tall))
        upper = panel(figure, LEFT, foot + rows + gap, WIDTH - LEFT - RIGHT, body)
        lower = panel(figure, 1.78, foot, WIDTH - 1.78 - RIGHT, rows)
        _boundary_panel(upper, chart, names)
        _boundary_rows(lower, chart, edges)
        ours, common, _, median, front = _route_handles()
        missed = handle("missed, by how many", marker="x", color="black", ms=3.4)
        legend(figure, 0.33, [ours, common, median, front, missed], 3)
    return figure


HEADROOM = 0.28
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
            spots.append(_Spot.of(route, float(np.median(times)), errors))
    log_axis(axes.xaxis, *span([s.time for s in spots], 3), 1)
    log_axis(axes.yaxis, BOTTOM, max([1e-12, *(s.worst for s in spots)]) * 60, 4)
    standing = spectrum_chart.standing(chart, "boundary")
    _draw_routes(
        axes, spots, {n for n, p in standing.items() if p.on_front}, {s.name for s in spots}
    )
    frame([axes], "time per boundary [s]", "relative error")
    title(axes, named("miss at least one boundary", missing, len(names), 62), "", 70)


def _boundary_rows(axes: Axes, chart: xarray.Dataset, edges: Sequence[str]) -> None:
    """A row for each boundary: errors as marks, and how many routes miss it."""
    log_axis(axes.xaxis, BOTTOM, 30.0, 4)
    axes.set_xticks([1e-16, 1e-12, 1e-8, 1e-4])
    axes.set_ylim(len(edges) - 0.4, -0.6)
    for row, edge in enumerate(edges):
        here = chart.sel(boundary=edge)
        asked = here.boundary_asked.values & np.isfinite(here.boundary_seconds.values)
        error, ours = here.boundary_error.values, here.own.values
        for mine, colour in ((False, PEOPLE), (True, OWN)):
            errors = np.maximum(error[asked & (ours == mine) & np.isfinite(error)], FLOOR)
            line = [row + (0.14 if mine else -0.14)] * errors.size
            axes.plot(errors, line, ms=2.4, mew=0.6, **_look(colour, ours=mine))
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
    rules(axes, "y")


def _edge_words(edge: str) -> str:
    family, law, k, mu = edge.split()
    return f"{family}, {law}, k = {k}" + ("" if mu == "None" else f", μ = {float(mu):g}")


# --- whole calls ---


def calls_figure(rows: Sequence[Mapping[str, Any]]) -> Figure:
    """Time against error of whole calls, a panel for each question, a larger mark for each size.

    Parameters
    ----------
    rows
        Lines of `stability.compare.calls.rows`.
    """
    questions = list(dict.fromkeys(row["question"] for row in rows))
    with figure_style(STYLE):
        figure, panels = page(len(questions), 1.0, 0.45)
        low, high = span([row["time [s]"] for row in rows])
        for axes, name in zip(panels, questions, strict=True):
            mine = [r for r in rows if r["question"] == name and r["error"] is not None]
            log_axis(axes.xaxis, low, high * 3, 1)
            log_axis(axes.yaxis, BOTTOM, 1e2, 4)
            title(axes, QUESTIONS[name].title)
            written = []
            for way, marker in zip(dict.fromkeys(r["way"] for r in mine), "Dos", strict=False):
                ours = QUESTIONS[name].ways[way].own
                colour = OWN if ours else PEOPLE
                spots = [(r["time [s]"], max(r["error"], FLOOR)) for r in mine if r["way"] == way]
                if isinstance(QUESTIONS[name].sizes[0], int):  # others are no scale
                    axes.plot(*zip(*spots, strict=True), lw=0.6, alpha=0.6, color=colour)
                for size, (time, error) in zip((2.2, 3.2, 4.4), spots, strict=False):
                    look = _look(colour, ours=ours) | {"marker": marker}
                    axes.plot([time], [error], ms=size, mew=0.7, **look)
                written.append(Letter(*spots[-1], way, colour))
            letters(axes, written)
        frame(panels, "time of the call [s]", "largest relative error")
        legend(figure, 0.2, _route_handles()[:2], 2)
    return figure


# --- shares of right and wrong answers, a row for each method ---


LINE, APART = 0.125, 0.45
"""Height of a row [in], and the gap between people's methods and the package's [rows]."""
TIMES = ("s", 1.0), ("ms", 1e-3), ("µs", 1e-6)
"""Units of a time in a note."""
KEY = 0.16
"""Height of a legend of one line [in]."""


def _shares_figure(
    methods: Iterable[str],
    heads: Sequence[str],
    counts: NDArray[np.float64],
    *,
    marks: Sequence[str],
    notes: Sequence[str] = (),
    label: str = "",
    blank: str = "no answer",
) -> Figure:
    """Rows of methods against columns; each cell is split by its shares.

    `counts` has shape (methods, columns, marks): numbers over the number of questions, so that a
    cell in which some were not asked is not full.  `notes` stands to the right of each row.
    """
    methods = list(methods)
    ours = [(ROUTES | DRIVERS)[name].own for name in methods]
    cuts = [0, *np.cumsum([a != b for a, b in zip(ours[:-1], ours[1:], strict=True)]).tolist()]
    y = [i + APART * cut for i, cut in zip(range(len(ours)), cuts, strict=False)]
    turned = [fill(h, 17) for h in heads] if not label else []
    top = 0.05 + 0.056 * max((len(part) for h in turned for part in h.split("\n")), default=0)
    seen = [m for m, n in zip(marks, np.nansum(counts, axis=(0, 1)), strict=True) if n > 0]
    blanks = bool((np.nan_to_num(counts).sum(axis=-1) < 1 - 1e-9).any())
    tall = y[-1] + 1.0
    below = 0.14 * (len(seen) + blanks > 4)
    foot = 0.2 + (0.28 if label else 0.0) + below
    left, right = 0.08 + max(map(_wide, methods)), 0.42 if notes else 0.05
    with figure_style(STYLE | {"hatch.linewidth": 0.5, "hatch.color": "black"}):
        figure = Figure(figsize=(WIDTH, LINE * tall + top + foot))
        axes = panel(figure, left, foot, WIDTH - left - right, LINE * tall)
        axes.set(xlim=(-0.5, len(heads) - 0.5), ylim=(tall - 0.5, -0.5))
        for i, j in np.ndindex(counts.shape[:2]):
            _share_cell(axes, j, y[i], counts[i, j], marks)
        _label(axes, (y, methods, ours), label, heads if label else turned)
        for place, text in zip(y, notes, strict=False):
            axes.annotate(
                text,
                (1, place),
                (28, 0),
                annotation_clip=False,
                xycoords=("axes fraction", "data"),
                textcoords="offset points",
                fontsize=SMALL,
                ha="right",
                va="center_baseline",
            )
        _key(figure, seen, blank if blanks else "", KEY + below)
    return figure


def _wide(name: str) -> float:
    """Width of the name of a method, as if it were bold [in]."""
    bold = FontProperties(family=matplotlib.rcParamsDefault["font.sans-serif"][0], weight="bold")
    return float(TextPath((0, 0), name, size=SMALL, prop=bold).get_extents().width) / 72


def _label(
    axes: Axes,
    rows: tuple[Sequence[float], Sequence[str], Sequence[bool]],
    label: str,
    heads: Sequence[str],
) -> None:
    places, methods, ours = rows
    if label:
        axes.set_xticks(range(len(heads)), heads, fontsize=SMALL + 0.5)
        axes.set_xlabel(label, fontsize=7, labelpad=2)
    else:
        axes.xaxis.tick_top()
        axes.set_xticks(range(len(heads)), heads, rotation=90, fontsize=SMALL, linespacing=1.0)
    axes.set_yticks(places, methods, fontsize=SMALL)
    axes.tick_params(length=0, pad=2)
    for text, mine in zip(axes.get_yticklabels(), ours, strict=True):
        text.set_fontweight("bold" if mine else "normal")
    for spine in axes.spines.values():
        spine.set_visible(False)


def _share_cell(axes: Axes, x: float, y: float, shares: Any, marks: Sequence[str]) -> None:
    start = x - 0.46
    for word, share in zip(marks, np.nan_to_num(shares), strict=True):
        if share > 0:
            colour, hatch = VERDICT_LOOKS[word].cell
            axes.add_patch(
                Rectangle(
                    (start, y - 0.41),
                    0.92 * share,
                    0.82,
                    facecolor=colour,
                    hatch=hatch,
                    edgecolor="black",
                    linewidth=0,
                )
            )
            start += 0.92 * share
    axes.add_patch(
        Rectangle(
            (x - 0.46, y - 0.41), 0.92, 0.82, facecolor="none", linewidth=0.3, edgecolor="#909090"
        )
    )


def _key(figure: Figure, marks: Sequence[str], blank: str, top: float) -> None:
    shown = []
    for word in marks:
        colour, hatch = VERDICT_LOOKS[word].cell
        shown.append(Patch(facecolor=colour, hatch=hatch, label=word, linewidth=0))
    if blank:
        shown.append(Patch(facecolor="none", edgecolor="#909090", linewidth=0.4, label=blank))
    legend(figure, top, shown, 4)


def verdict_figure(chart: xarray.Dataset) -> Figure:
    """Shares of right, undecided and wrong verdicts of every route in each class of hardness.

    Returns
    -------
    Figure
        A journal column wide, with the time per point at the right.
    """
    wrong, open_, count = (chart[k].values for k in ("wrong", "undecided", "count"))
    shares = np.stack([count - wrong - open_, open_, wrong], axis=-1) / count[..., None]
    names, kinds = chart.route.values.tolist(), chart.hardness.values.tolist()
    times = [[spectrum_chart.seconds(chart, n, k)[0] for k in kinds] for n in names]
    return _shares_figure(
        names,
        [_short(str(t)) for t in chart.class_title.values],
        shares,
        marks=STEPS,
        notes=[
            two_digits(float(np.nanmedian(t)), TIMES) if np.isfinite(t).any() else "" for t in times
        ],
    )


def _short(text: str) -> str:
    return text.split(": ")[0].split(",")[0].split(" (")[0].split(" at ")[0]


def ladder_figure(cases: Sequence[Entry]) -> Figure:
    """How near a boundary the verdict of each route holds.

    Parameters
    ----------
    cases
        Cells of the catalogue.

    Returns
    -------
    Figure
        A journal column wide.
    """
    counts, count = ladder(cases), len(asked_edges(cases))
    shares = [[[c[word] / count for word in STEPS] for c in row] for row in counts.values()]
    heads = [f"$10^{{{-d}}}$" if i % 3 == 0 else "" for i, d in enumerate(DECADES)]
    label = "relative distance from the boundary"
    return _shares_figure(counts, heads, np.array(shares), marks=STEPS, label=label)


def failure_figure(cases: Sequence[Entry]) -> Figure:
    """Shares of each mark among the hard cases of a group, for every method.

    Parameters
    ----------
    cases
        Cells of one part of the catalogue.

    Returns
    -------
    Figure
        A journal column wide; a cell is not full where a method is not asked every case.
    """
    methods = dict.fromkeys(e.method for e in cases)
    groups: dict[str, set[str]] = {}
    for e in cases:
        groups.setdefault(e.group, set()).add(e.case)
    counts = Counter((e.method, e.group, e.mark.word) for e in cases if e.mark)
    marks = [mark.word for mark in Mark]
    shares = [
        [[counts[m, g, word] / len(names) for word in marks] for g, names in groups.items()]
        for m in methods
    ]
    heads = [f"{words} ({len(names)})" for words, names in groups.items()]
    return _shares_figure(methods, heads, np.array(shares), marks=marks, blank="not asked")


# --- work against precision of motions, and what a first call costs ---


LABELS = {
    "final": "error of the last state",
    "path": "error along the path",
    "audit": "error of the energy account",
    "event": "error of event times",
}
"""Label of the error by metric."""
LOWEST, HIGHEST = 1e-16, 1e2
"""Ends of an axis of errors."""
REFERENCE_DRIVERS = ("simulate", "rk45")
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
    "heyoka": {"color": "#117733", "marker": "s"},
    "dop853": {"color": "#E69F00", "marker": "^"},
    "lsoda": {"color": "#000000", "marker": "v"},
    "radau": {"color": "#CC79A7", "marker": "p"},
    "bdf": {"color": "#882255", "marker": "h"},
    "cvodes": {"color": "#56B4E9", "marker": "<"},
    "idas": {"color": "#332288", "marker": ">"},
    "rk45": {"color": PEOPLE, "marker": "X", "ms": 3.2},
    "rk4": {"color": PEOPLE, "marker": "s", "mfc": "white"},
    "rough-model": {"color": "#7f4f24", "marker": "D"},
    "smooth-model": {"color": "#9c6b24", "marker": "d"},
    "regularised": {"color": "#4d3b1f", "marker": "D", "mfc": "white"},
}
"""Line and marker of the drivers, in the colours of all charts for `simulate` and what people
use; `OTHER` is that of one without its own."""
OTHER: dict[str, Any] = {"color": "#6a6a6a", "marker": "*"}
PLAIN: dict[str, Any] = {"ls": "-", "lw": 0.8, "ms": 2.4, "mew": 0.6, "zorder": 4}
"""What their looks have in common."""


def panels_of(chart: xarray.Dataset, metric: str) -> list[str]:
    """Scenes in which any driver has the error."""
    return [w for w in chart.scene.values.tolist() if motion_chart.points(chart, w, metric)]


def motion_figure(chart: xarray.Dataset, metric: str = "path") -> Figure:
    """Work against precision through the tolerances, a panel for each scene that has the error.

    Returns
    -------
    Figure
        A journal column wide.  In colour: drivers on the front with at least one digit, and
        references; others are grey, and those with a wrong outcome are named over the panel.
    """
    scenes = panels_of(chart, metric)
    low, high = span(chart.seconds.values)
    with figure_style(STYLE):
        labelled = {which: _coloured(chart, which, metric) for which in scenes}
        names = {name for names in labelled.values() for name in names}
        everywhere = [n for n in (*LOOKS, *sorted(names - set(LOOKS))) if n in names]
        handles = _driver_handles(everywhere)
        figure, panels = page(len(scenes), 1.0, 0.3 + 0.13 * -(-len(handles) // 3))
        for axes, which in zip(panels, scenes, strict=True):
            log_axis(axes.xaxis, low, high, 1)
            log_axis(axes.yaxis, LOWEST, HIGHEST, 4)
            here = chart.sel(scene=which)
            title(axes, str(here.scene_title.values), _silent(here))
            _draw_drivers(axes, motion_chart.points(chart, which, metric), labelled[which])
            steps(axes, _front(chart, which, metric)[1])
        frame(panels, "time of a run [s]", LABELS[metric])
        legend(figure, 0.05 + 0.13 * -(-len(handles) // 3), handles, 3)
    return figure


def _front(
    chart: xarray.Dataset, which: str, metric: str
) -> tuple[set[str], list[tuple[float, float]]]:
    """Drivers on the front that have a digit right, and the points of the front."""
    every = motion_chart.rungs(chart, which, metric)
    best = {key: p for key, p in every.items() if p.on_front and p.error < DIGIT}
    spots = [(p.time, max(p.error, 2 * LOWEST)) for p in best.values()]
    return {key.split()[0] for key in best}, spots


def _coloured(chart: xarray.Dataset, which: str, metric: str) -> set[str]:
    """Drivers in colour in a panel."""
    return (_front(chart, which, metric)[0] | set(REFERENCE_DRIVERS)) & set(
        motion_chart.points(chart, which, metric)
    )


def _draw_drivers(
    axes: Axes, points: dict[str, list[tuple[float, float]]], labelled: set[str]
) -> None:
    for name, rows in points.items():
        times, errors = np.array(rows).T
        errors = np.clip(errors, 2 * LOWEST, HIGHEST / 2)
        if name in labelled:
            axes.plot(times, errors, **(PLAIN | LOOKS.get(name, OTHER)))
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


def _driver_handles(names: list[str]) -> list[Any]:
    return [
        *(handle(SHORT.get(name, name), **(PLAIN | LOOKS.get(name, OTHER))) for name in names),
        handle("others", ls="-", color=PALE, lw=0.8, marker=".", ms=1.6),
        front_handle(),
    ]


def first_call_figure(chart: xarray.Dataset) -> Figure:
    """Time of the first call, graphs built and code compiled, next to that of a repeat.

    Returns
    -------
    Figure
        A journal column wide: a row for each driver, with the median over the scenes and a line
        from the least to the most.
    """
    names = chart.driver.values.tolist()
    left, body, foot = 0.78, 0.15 * len(names), 0.52
    with figure_style(STYLE):
        figure = Figure(figsize=(WIDTH, body + foot + 0.05))
        axes = panel(figure, left, foot, WIDTH - left - RIGHT, body)
        log_axis(axes.xaxis, *span([*_repeats(chart).ravel(), *chart["first"].values.ravel()]), 1)
        rules(axes, "x")
        for line, (again, first) in enumerate(
            zip(_repeats(chart).T, chart["first"].values.T, strict=True)
        ):
            for times, shift, look in ((again, -0.16, SOLID), (first, 0.16, OPEN)):
                finite = times[np.isfinite(times)]
                if finite.size:
                    axes.plot(
                        [finite.min(), finite.max()],
                        [line + shift] * 2,
                        lw=0.8,
                        color=look["mec"],
                        alpha=0.6,
                    )
                    axes.plot([np.median(finite)], [line + shift], **look)
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
OPEN: dict[str, Any] = SOLID | {"mfc": "white"}
"""Marks of repeats and of first calls."""


def _repeats(chart: xarray.Dataset) -> NDArray[Any]:
    """Least repeat at the middle tolerance, shape (scenes, drivers); NaN without an answer."""
    repeats = np.full((chart.sizes["scene"], chart.sizes["driver"]), np.nan)
    for place in np.ndindex(repeats.shape):
        times = chart.seconds.values[place]
        times = times[np.isfinite(times).any(axis=-1)]
        if len(times):
            repeats[place] = np.nanmin(times[len(times) // 2])
    return repeats
