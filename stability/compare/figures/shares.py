"""Figures only: shares of right and wrong answers, a row for each method."""

from __future__ import annotations

from ...figures.canvas import STYLE, figure_style  # isort: skip

from collections.abc import Sequence
from textwrap import fill
from typing import TYPE_CHECKING, Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.patches import Patch, Rectangle
from matplotlib.textpath import TextPath
from numpy.typing import NDArray

from ...figures.letters import SMALL
from ..spectrum import dataset as spectral_data
from .panels import WIDTH, legend

if TYPE_CHECKING:
    import xarray

MARKS: dict[str, tuple[str, str]] = {
    "right": ("#2b6ca3", ""),
    "degraded": ("#b9d6ec", ""),
    "undecided": ("#e2e2e2", "....."),
    "refused": ("#f4f4f4", "-----"),
    "wrong": ("#D55E00", "xxxxx"),
    "crashed": ("black", ""),
    "late": ("#b0b0b0", "//////"),
}
"""Colour and hatching of each mark."""
LINE, APART = 0.125, 0.45
"""Height of a row [in], and the gap between people's methods and the package's [rows]."""
KEY = 0.16
"""Height of a legend of one line [in]."""


def _figure(
    methods: Sequence[str],
    own: Sequence[bool],
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
    cuts = [0, *np.cumsum([a != b for a, b in zip(own[:-1], own[1:], strict=True)]).tolist()]
    y = [i + APART * cut for i, cut in zip(range(len(own)), cuts, strict=False)]
    turned = [fill(h, 17) for h in heads] if not label else []
    top = 0.05 + 0.056 * max((len(part) for h in turned for part in h.split("\n")), default=0)
    seen = [m for m, n in zip(marks, np.nansum(counts, axis=(0, 1)), strict=True) if n > 0]
    blanks = bool((np.nan_to_num(counts).sum(axis=-1) < 1 - 1e-9).any())
    tall = y[-1] + 1.0
    below = 0.14 * (len(seen) + blanks > 4)
    foot = 0.2 + (0.28 if label else 0.0) + below
    left, right = 0.08 + max(map(_wide, methods)), 0.42 if notes else 0.05
    with figure_style(STYLE | {"hatch.linewidth": 0.5, "hatch.color": "black"}):
        height = LINE * tall + top + foot
        figure = Figure(figsize=(WIDTH, height))
        axes = figure.add_axes(
            (left / WIDTH, foot / height, (WIDTH - left - right) / WIDTH, LINE * tall / height)
        )
        axes.set(xlim=(-0.5, len(heads) - 0.5), ylim=(tall - 0.5, -0.5))
        for i, j in np.ndindex(counts.shape[:2]):
            _cell(axes, j, y[i], counts[i, j], marks)
        _label(axes, (y, methods, own), label, heads if label else turned)
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
    places, methods, own = rows
    if label:
        axes.set_xticks(range(len(heads)), heads, fontsize=SMALL + 0.5)
        axes.set_xlabel(label, fontsize=7, labelpad=2)
    else:
        axes.xaxis.tick_top()
        axes.set_xticks(range(len(heads)), heads, rotation=90, fontsize=SMALL, linespacing=1.0)
    axes.set_yticks(places, methods, fontsize=SMALL)
    axes.tick_params(length=0, pad=2)
    for text, mine in zip(axes.get_yticklabels(), own, strict=True):
        text.set_fontweight("bold" if mine else "normal")
    for spine in axes.spines.values():
        spine.set_visible(False)


def _cell(axes: Axes, x: float, y: float, shares: Any, marks: Sequence[str]) -> None:
    start = x - 0.46
    for word, share in zip(marks, np.nan_to_num(shares), strict=True):
        if share > 0:
            colour, hatch = MARKS[word]
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
    shown = [Patch(facecolor=MARKS[w][0], hatch=MARKS[w][1], label=w, linewidth=0) for w in marks]
    if blank:
        shown.append(Patch(facecolor="none", edgecolor="#909090", linewidth=0.4, label=blank))
    legend(figure, top, shown, 4)


def verdict_figure(chart: xarray.Dataset) -> Figure:
    """Shares of right, undecided and wrong verdicts of every route in each class of hardness.

    Parameters
    ----------
    chart
        From `stability.compare.spectrum.dataset.dataset`.

    Returns
    -------
    Figure
        A journal column wide, with the time per point at the right.
    """
    wrong, open_, count = (chart[k].values for k in ("wrong", "undecided", "count"))
    shares = np.stack([count - wrong - open_, open_, wrong], axis=-1) / count[..., None]
    names, kinds = chart.route.values.tolist(), chart.hardness.values.tolist()
    times = [[spectral_data.seconds(chart, n, k)[0] for k in kinds] for n in names]
    return _figure(
        names,
        chart.own.values.tolist(),
        [_short(str(t)) for t in chart.class_title.values],
        shares,
        marks=("right", "undecided", "wrong"),
        notes=[_time(float(np.nanmedian(t))) if np.isfinite(t).any() else "" for t in times],
    )


def _short(text: str) -> str:
    return text.split(": ")[0].split(",")[0].split(" (")[0].split(" at ")[0]


def _time(seconds: float) -> str:
    unit, size = next(
        (pair for pair in (("s", 1.0), ("ms", 1e-3)) if seconds >= pair[1]), ("µs", 1e-6)
    )
    return f"{float(f'{seconds / size:.2g}'):g} {unit}"


def ladder_figure(
    methods: Sequence[str],
    own: Sequence[bool],
    decades: Sequence[int],
    shares: NDArray[np.float64],
) -> Figure:
    """How near a boundary the verdict of each method holds.

    Parameters
    ----------
    methods
        Names of the methods.
    own
        Whether each method is the package's.
    decades
        Powers of ten of the relative distances, -1 ... -15.
    shares
        Shares of right, undecided and wrong verdicts, shape (methods, decades, 3).

    Returns
    -------
    Figure
        A journal column wide.
    """
    heads = [f"$10^{{{d}}}$" if i % 3 == 0 else "" for i, d in enumerate(decades)]
    return _figure(
        methods,
        own,
        heads,
        shares,
        marks=("right", "undecided", "wrong"),
        label="relative distance from the boundary",
    )


def failure_figure(
    methods: Sequence[str],
    own: Sequence[bool],
    groups: Sequence[tuple[str, int]],
    shares: NDArray[np.float64],
) -> Figure:
    """Shares of each mark among the hard cases of a group, for every method.

    Parameters
    ----------
    methods
        Names of the methods.
    own
        Whether each method is the package's.
    groups
        (heading, number of cases).
    shares
        Shares of each of `MARKS`, shape (methods, groups, marks); they add up to less than 1 where
        a method is not asked.

    Returns
    -------
    Figure
        A journal column wide.
    """
    heads = [f"{words} ({count})" for words, count in groups]
    return _figure(methods, own, heads, shares, marks=tuple(MARKS), blank="not asked")
