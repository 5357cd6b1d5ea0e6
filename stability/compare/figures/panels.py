"""Pieces that the figures of the charts share: panels in two columns, labels, fronts and keys."""

from __future__ import annotations

from collections.abc import Sequence
from textwrap import wrap
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FixedLocator, NullLocator

from ...figures.canvas import COLUMN
from ...figures.letters import SMALL

WIDTH = COLUMN
"""Width of a figure: a journal column, which is also readable on a phone [in]."""
OWN, PEOPLE, FRONT, PALE = "#D55E00", "#0072B2", "#009E73", "#b4b4b4"
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
    found = []
    for index in range(count):
        row, column = divmod(index, 2)
        x, y = LEFT + column * (wide + BETWEEN), height - row * FOOT - (row + 1) * (HEAD + body)
        found.append(figure.add_axes((x / WIDTH, y / height, wide / WIDTH, body / height)))
    return figure, found


def title(axes: Axes, text: str, note: str = "", width: int = LETTERS) -> None:
    """A title in at most two lines, broken after its colon where it has one, and a grey note.

    Parameters
    ----------
    axes
        The panel.
    text, note
        The words.
    width
        Letters in a line.
    """
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

    Parameters
    ----------
    axis
        The x or y axis of a panel.
    low, high
        Ends of the axis.
    step
        Decades between ticks; one tick is at 1.
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
    """Ends of a log axis that holds the values, with some room.

    Parameters
    ----------
    values
        Numbers, of which the positive and finite ones count.
    room
        Factor between the outermost values and the ends.

    Returns
    -------
    low, high
    """
    known = np.asarray(values, dtype=float).ravel()
    known = known[np.isfinite(known) & (known > 0)]
    if not known.size:
        return 1e-3, 1.0
    return float(known.min() / room), float(known.max() * room)


def frame(panels: Sequence[Axes], x: str, y: str) -> None:
    """Label the outer axes of a page; inner panels have ticks alone.

    Parameters
    ----------
    panels
        From `page`.
    x, y
        Labels of the axes.
    """
    for index, axes in enumerate(panels):
        axes.grid(True, linewidth=0.3, color="#dddddd")
        axes.set_axisbelow(True)
        axes.tick_params(labelsize=SMALL + 0.5, length=2, pad=1.5, labelleft=index % 2 == 0)
        if index % 2 == 0:
            axes.set_ylabel(y, fontsize=7, labelpad=1)
        if index >= len(panels) - 2:
            axes.set_xlabel(x, fontsize=7, labelpad=2)


def steps(axes: Axes, spots: Sequence[tuple[float, float]]) -> None:
    """Draw the front as a broad step line: the least error within a time.

    Parameters
    ----------
    axes
        The panel.
    spots
        (seconds, error) of the routes on the front.
    """
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
    """An entry of a legend.

    Parameters
    ----------
    words
        Text of the entry.
    **look
        Properties of the line.

    Returns
    -------
    Line2D
    """
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

    Parameters
    ----------
    words
        What these methods have in common.
    names
        Their names.
    count
        Number of methods asked.
    width
        Letters in the note.

    Returns
    -------
    str

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
