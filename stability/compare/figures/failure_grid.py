"""Figures only: which method fails at which hard case, and how near a boundary verdicts hold."""

from __future__ import annotations

from ...figures.canvas import STYLE, figure_style  # isort: skip

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch, Rectangle
from numpy.typing import NDArray

from ...figures.letters import SMALL
from .panels import WIDTH, handle

MARKS: dict[str, tuple[str, str, str]] = {
    "right": ("#2b6ca3", "", "right"), "degraded": ("#b9d6ec", "", "degraded (digits left)"),
    "wrong": ("#D55E00", "x", "wrong"), "undecided": ("#e2e2e2", "_", "undecided"),
    "refused": ("#e2e2e2", ".", "refused"), "crashed": ("black", "x", "crashed"),
    "late": ("#d0d0d0", "//////", "late"), "": ("white", "", "not asked"),
}  # fmt: skip
"""Colour, symbol or hatching, and words of each mark."""
INK = {"crashed": "white"}
"""Colour of a symbol where it is not black."""
APART = 0.45
"""Gap between the package's columns and people's, and above a group's heading [cells]."""


def catalogue_figure(
    rows: Sequence[str], columns: Sequence[str], own: Sequence[bool], marks: NDArray[np.str_],
    digits: NDArray[np.float64], *, groups: Sequence[tuple[str, int]] = (), title: str = "",
) -> Figure:  # fmt: skip
    """A table of hard cases and methods, with a mark in each cell.

    Parameters
    ----------
    rows, columns
        Names of the cases and of the methods.
    own
        Whether each method is the package's.
    marks
        One of `MARKS` for each case and method.
    digits
        Digits left where a mark is degraded, NaN where there are none.
    groups
        (heading, number of rows), in order.
    title
        A few words over the figure.

    Returns
    -------
    Figure
        Two journal columns wide.
    """
    x, y, headings = _columns(own), *_lines(len(rows), groups)
    foot = max(y, default=0) + 0.5
    with figure_style(STYLE | {"hatch.linewidth": 0.5, "hatch.color": "#606060"}):
        names = 0.048 * max(map(len, columns), default=1) + 0.1
        height = 0.116 * (foot + 0.7) + names + 0.35 + (0.2 if title else 0)
        figure = Figure(figsize=(WIDTH, height))
        left = min(0.046 * max(map(len, rows), default=1) + 0.1, 3.2)
        axes = figure.add_axes((left / WIDTH, 0.33 / height, (WIDTH - left - 0.05) / WIDTH,
                                0.116 * (foot + 0.7) / height))  # fmt: skip
        axes.set(xlim=(-0.6, max(x, default=0) + 0.6), ylim=(foot, -0.7))
        for i, j in np.ndindex(len(rows), len(columns)):
            _square(axes, x[j], y[i], str(marks[i, j]), float(digits[i, j]))
        _names(axes, (x, columns), (y, rows), own)
        for line, words in headings:
            axes.annotate(words, (0, line), (-left * 72 + 4, 0), xycoords=("axes fraction", "data"),
                          textcoords="offset points", fontsize=6.8, weight="bold", va="center",
                          annotation_clip=False)  # fmt: skip
        if title:
            figure.text(0.5, 1 - 0.03 / height, title, fontsize=8, ha="center", va="top")
        _mark_key(figure, 0.24 / height)
    return figure


def _columns(own: Sequence[bool]) -> list[float]:
    """Places of the columns: a gap wherever the package's begin or end."""
    cuts = [0, *np.cumsum([a != b for a, b in zip(own[:-1], own[1:], strict=True)]).tolist()]
    return [i + APART * cut for i, cut in zip(range(len(own)), cuts, strict=False)]


def _lines(count: int, groups: Sequence[tuple[str, int]]) -> tuple[list[float], list[Any]]:
    """Places of the rows, and (place, words) of the headings."""
    places: list[float] = []
    headings, line = [], 0.0
    for words, size in groups or [("", count)]:
        if words:
            line += APART if places else 0.0
            headings.append((line, words))
            line += 1.0
        places += [line + i for i in range(size)]
        line += size
    return places, headings


def _square(axes: Axes, x: float, y: float, mark: str, digits: float) -> None:
    colour, symbol, _ = MARKS[mark]
    hatch = symbol if symbol.startswith("/") else ""
    edge = "#606060" if hatch else "white"
    axes.add_patch(Rectangle((x - 0.47, y - 0.45), 0.94, 0.9, facecolor=colour, hatch=hatch,
                             edgecolor=edge, linewidth=0))  # fmt: skip
    if mark == "":
        axes.add_patch(Rectangle((x - 0.47, y - 0.45), 0.94, 0.9, facecolor="none",
                                 edgecolor="#d5d5d5", linewidth=0.3))  # fmt: skip
    elif symbol and not hatch:
        axes.plot([x], [y], symbol, ms=4 if symbol != "." else 3.5, mew=1.0,
                  color=INK.get(mark, "black"))  # fmt: skip
    elif mark == "degraded":
        words = f"{digits:.0f}" if np.isfinite(digits) else "~"
        axes.text(x, y - 0.05, words, fontsize=SMALL, ha="center", va="center_baseline")


def _names(
    axes: Axes, across: tuple[Sequence[float], Sequence[str]],
    down: tuple[Sequence[float], Sequence[str]], own: Sequence[bool],
) -> None:  # fmt: skip
    axes.xaxis.tick_top()
    axes.set_xticks(*across, rotation=90, fontsize=6.5)
    axes.set_yticks(*down, fontsize=SMALL)
    axes.tick_params(length=0, pad=1.5)
    for label, mine in zip(axes.get_xticklabels(), own, strict=True):
        label.set_fontweight("bold" if mine else "normal")
    for spine in axes.spines.values():
        spine.set_visible(False)


def _mark_key(figure: Figure, top: float) -> None:
    handles: list[Any] = []
    for mark, (colour, symbol, words) in MARKS.items():
        edge = {"": "#bbbbbb", "late": "#606060"}.get(mark, colour)
        patch = Patch(facecolor=colour, edgecolor=edge, linewidth=0.4, label=words,
                      hatch=symbol if symbol.startswith("/") else None)  # fmt: skip
        if symbol and not symbol.startswith("/"):
            look = handle("", marker=symbol, color=INK.get(mark, "black"), ms=3.6, mew=0.9)
            handles.append(((patch, look), words))
        else:
            handles.append((patch, words))
    figure.legend(*zip(*handles, strict=True), loc="upper center", bbox_to_anchor=(0.5, top),
                  ncols=len(handles), frameon=False, fontsize=6.5, borderpad=0, handlelength=1.8,
                  columnspacing=1.2, handletextpad=0.4)  # fmt: skip


def ladder_figure(
    methods: Sequence[str], own: Sequence[bool], decades: Sequence[int],
    marks_share: NDArray[np.float64],
) -> Figure:  # fmt: skip
    """How near a boundary the verdict of each method holds.

    Parameters
    ----------
    methods
        Names of the methods.
    own
        Whether each method is the package's.
    decades
        Powers of ten of the relative distances, -1 ... -15.
    marks_share
        Shares of right, undecided and wrong verdicts, shape (methods, decades, 3); NaN where a
        method was not asked.

    Returns
    -------
    Figure
        Two journal columns wide.
    """
    y, left = _columns(own), min(0.05 * max(map(len, methods), default=1) + 0.25, 2.6)
    tall = max(y, default=0) + 1.1
    with figure_style(STYLE | {"hatch.linewidth": 0.7, "hatch.color": "black"}):
        height = 0.175 * tall + 0.72
        figure = Figure(figsize=(WIDTH, height))
        axes = figure.add_axes((left / WIDTH, 0.62 / height, (WIDTH - left - 0.08) / WIDTH,
                                0.175 * tall / height))  # fmt: skip
        axes.set(xlim=(-0.55, len(decades) - 0.45), ylim=(tall - 0.5, -0.55))
        for i, j in np.ndindex(len(methods), len(decades)):
            _split(axes, j, y[i], marks_share[i, j])
        axes.set_xticks(range(len(decades)), [f"$10^{{{d}}}$" for d in decades], fontsize=7)
        axes.set_yticks(y, methods, fontsize=6.5)
        axes.tick_params(length=0, pad=2)
        for label, mine in zip(axes.get_yticklabels(), own, strict=True):
            label.set_fontweight("bold" if mine else "normal")
        for spine in axes.spines.values():
            spine.set_visible(False)
        axes.set_xlabel("relative distance from the boundary", fontsize=7.5, labelpad=2)
        shares = [Patch(facecolor=c, hatch=h, label=w, linewidth=0) for c, h, w in SHARES]
        blank = Patch(facecolor="none", edgecolor="#bbbbbb", linewidth=0.4, label="no answer")
        figure.legend(handles=[*shares, blank], loc="lower center", ncols=4, frameon=False,
                      fontsize=6.5)  # fmt: skip
    return figure


SHARES = (
    (MARKS["right"][0], "", "share right"), (MARKS["undecided"][0], "....", "share undecided"),
    (MARKS["wrong"][0], "xxxxx", "share wrong"),
)  # fmt: skip
"""Colour, hatching and words of the shares of a ladder."""


def _split(axes: Axes, x: float, y: float, shares: NDArray[np.float64]) -> None:
    """A square split by its shares; an empty outline where the method was not asked."""
    known, start = bool(np.isfinite(shares).all()), x - 0.46
    for (colour, hatch, _), share in zip(SHARES, shares if known else (0, 0, 0), strict=True):
        axes.add_patch(Rectangle((start, y - 0.41), 0.92 * share, 0.82, facecolor=colour,
                                 hatch=hatch, edgecolor="black", linewidth=0))  # fmt: skip
        start += 0.92 * share
    axes.add_patch(Rectangle((x - 0.46, y - 0.41), 0.92, 0.82, facecolor="none", linewidth=0.3,
                             edgecolor="#707070" if known else "#d5d5d5"))  # fmt: skip
