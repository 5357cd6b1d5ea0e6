"""Pieces that the figures of the charts share: panels under strips, letters, fronts and keys."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from textwrap import wrap
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FixedLocator, NullLocator

from ...figures.letters import SMALL, Letter

WIDTH = 7.1
"""Width of a figure over two journal columns [in]."""
OWN, PEOPLE, FRONT = "#D55E00", "#0072B2", "#009E73"
"""Colours of the package's routes, of those people use, and of the front."""
LEFT, RIGHT, BETWEEN = 0.46, 0.06, 0.1
"""Margins next to and between panels [in]."""
ROW = 0.088
"""Height of a line of small text [in]."""
CROSS: dict[str, Any] = {"marker": "x", "ls": "", "ms": 3.6, "mew": 0.9, "color": "black"}


@dataclass(frozen=True, eq=False)
class Panel:
    """A panel and the strip over it, which share their x axis."""

    main: Axes
    """Cost against error."""
    strip: Axes
    """Routes that have no error to plot."""


def page(strips: Sequence[int], body: float, legend: float) -> tuple[Figure, list[Panel]]:
    """A figure with rows of four panels, each under its strip.

    Parameters
    ----------
    strips
        Lines of text that the strips of each row of panels have room for.
    body
        Height of a panel [in].
    legend
        Height left free at the bottom [in].

    Returns
    -------
    Figure, list of Panel
        Row by row.
    """
    head, gap, foot, label = 0.3, 0.03, 0.3, 0.12
    tall = [ROW * (n + 0.6) for n in strips]
    height = sum(tall) + len(strips) * (head + gap + body + foot) + label + legend
    wide = (WIDTH - LEFT - RIGHT - 3 * BETWEEN) / 4
    figure, found, top = Figure(figsize=(WIDTH, height)), [], height
    for strip in tall:
        top -= head + strip
        for column in range(4):
            x = (LEFT + column * (wide + BETWEEN)) / WIDTH
            upper = figure.add_axes((x, top / height, wide / WIDTH, strip / height))
            lower = figure.add_axes(
                (x, (top - gap - body) / height, wide / WIDTH, body / height), sharex=upper
            )
            upper.set(ylim=(0, 1), yticks=[], facecolor="#f1f1f1")
            upper.tick_params(axis="x", which="both", length=0, labelbottom=False)
            found.append(Panel(lower, upper))
        top -= gap + body + foot
    return figure, found


def title(axes: Axes, text: str, width: int = 31) -> None:
    """A title in at most two lines, broken after its colon where it has one.

    Parameters
    ----------
    axes
        The upper axes of a panel.
    text
        The words.
    width
        Letters in a line.
    """
    first, colon, rest = text.partition(": ")
    lines = [first + colon.strip(), rest]
    if not colon or len(text) <= width or max(map(len, lines)) > width:
        # lines of about the same length
        count = len(wrap(text, width))
        lines = next(ls for n in range(1, width + 1) if len(ls := wrap(text, n)) <= count)
    axes.set_title("\n".join(lines), fontsize=6.6, pad=2.5, linespacing=1.05)


def log_axis(axis: Any, low: float, high: float, step: int) -> None:
    """A log axis with a tick at every `step` decades.

    Parameters
    ----------
    axis
        The x or y axis of a panel.
    low, high
        Ends of the axis.
    step
        Decades between ticks; one tick is at 1.
    """
    axis.axes.set(**{f"{axis.axis_name}scale": "log", f"{axis.axis_name}lim": (low, high)})
    powers = np.arange(np.ceil(np.log10(low)), np.floor(np.log10(high)) + 1)
    axis.set_major_locator(FixedLocator(10.0 ** powers[powers % step == 0]))
    axis.set_minor_locator(NullLocator())


def span(values: Any) -> tuple[float, float]:
    """Ends of a log axis that holds the values, with some room.

    Parameters
    ----------
    values
        Numbers, of which the positive and finite ones count.

    Returns
    -------
    low, high
    """
    known = np.asarray(values)[np.isfinite(values) & (np.asarray(values) > 0)]
    if not known.size:
        return 1e-3, 1.0
    return float(known.min() / 1.8), float(known.max() * 1.8)


def frame(panels: Sequence[Panel], x: str, y: str, strip: str) -> None:
    """Label the outer axes of a page; inner panels have ticks alone.

    Parameters
    ----------
    panels
        From `page`.
    x, y
        Labels of the axes.
    strip
        Heading of the strips.
    """
    for index, panel in enumerate(panels):
        panel.main.grid(True, linewidth=0.3, color="#dddddd")
        panel.main.set_axisbelow(True)
        panel.main.tick_params(labelsize=6.5, length=2, pad=1.5, labelleft=index % 4 == 0)
        if index % 4 == 0:
            panel.main.set_ylabel(y, fontsize=7, labelpad=2)
            panel.strip.set_ylabel(strip.replace(" ", "\n"), fontsize=SMALL, rotation=0,
                                   ha="right", va="center", labelpad=3)  # fmt: skip
        if index >= len(panels) - 4:
            panel.main.set_xlabel(x, fontsize=7, labelpad=9)


def under(axes: Axes, text: str) -> None:
    """A few words below the ticks of a panel.

    Parameters
    ----------
    axes
        The panel.
    text
        The words, or nothing.
    """
    axes.annotate(text, (0, 0), (0, -12), xycoords="axes fraction", textcoords="offset points",
                  fontsize=SMALL, va="top", annotation_clip=False)  # fmt: skip


def steps(axes: Axes, spots: Sequence[tuple[float, float]], **stroke: Any) -> None:
    """Draw the front as a step line: the least error within a time.

    Parameters
    ----------
    axes
        The panel.
    spots
        (seconds, error) of the routes on the front.
    **stroke
        Properties of the line; green when left out.
    """
    if not spots:
        return
    times, errors = np.array(sorted(spots)).T
    # ties on the front must not make the line rise again
    errors = np.minimum.accumulate(errors)
    look: dict[str, Any] = {"color": FRONT, "linewidth": 1.3, "zorder": 1.5} | stroke
    # corners one by one, so that letters can avoid the line
    axes.plot(np.append(np.repeat(times, 2)[1:], axes.get_xlim()[1]), np.repeat(errors, 2),
              solid_joinstyle="miter", solid_capstyle="butt", **look)  # fmt: skip


def crosses(axes: Axes, wrongs: Sequence[Letter], rows: int) -> None:
    """Draw crosses in a strip at their times, each in its own row with its text.

    Parameters
    ----------
    axes
        The strip.
    wrongs
        Times and texts of the crosses; y is not used.
    rows
        Lines that the strip has room for.
    """
    for line, it in enumerate(sorted(wrongs, key=lambda w: w.x)):
        y = 1 - (line + 0.8) / (rows + 0.6)
        axes.plot([it.x], [y], **CROSS)
        # to the right, or to the left where the right-hand edge is near
        low, high = np.log10(axes.get_xlim())
        side = 1 if (np.log10(it.x) - low) / (high - low) < 0.6 else -1
        axes.annotate(it.text, (it.x, y), (3.4 * side, -0.3), textcoords="offset points",
                      fontsize=SMALL, color=it.colour, va="center",
                      ha="left" if side > 0 else "right")  # fmt: skip
    if not wrongs:
        none(axes)


def none(axes: Axes) -> None:
    """Write "none" in the middle of an empty strip.

    Parameters
    ----------
    axes
        The strip.
    """
    axes.text(0.5, 0.5, "none", transform=axes.transAxes, fontsize=SMALL, color="#666666",
              ha="center", va="center")  # fmt: skip


def key(figure: Figure, top: float, entries: Sequence[tuple[str, str, bool]]) -> None:
    """Write the meaning of the letters, in two columns.

    Parameters
    ----------
    figure
        The figure.
    top
        Upper edge of the list, from the bottom of the figure [in].
    entries
        (letter, words, whether the route is the package's).
    """
    tall, rows = figure.get_figheight(), -(-len(entries) // 2)
    for index, (letter, words, own) in enumerate(entries):
        x, y = 0.12 + (index // rows) * 3.5, top - (index % rows) * 1.12 * ROW
        colour = OWN if own else PEOPLE
        figure.text(x / WIDTH, y / tall, letter, fontsize=SMALL, weight="bold", color=colour,
                    ha="center", va="top")  # fmt: skip
        figure.text((x + 0.08) / WIDTH, y / tall, words, fontsize=SMALL, va="top")


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
    figure.legend(handles=handles, loc="upper center", ncols=columns, frameon=False,
                  bbox_to_anchor=(0.5, top / figure.get_figheight()), fontsize=SMALL,
                  columnspacing=1.2, handletextpad=0.4, handlelength=2.0, borderpad=0,
                  labelspacing=0.35)  # fmt: skip
