"""Pieces that figures of a motion share, and the panels of a user's system."""

from __future__ import annotations

from ..styled_figure import small  # isort: skip

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from ...base.errors import ParameterError
from ...base.quantities import in_latex, unit_of
from ...motion.result import BY_CODE, Outcome
from .single_run import SingleRun

if TYPE_CHECKING:
    import xarray

# distinct in every common colour vision; in grey, by the dashes
STROKES: tuple[dict[str, Any], ...] = (
    {"color": "#0072B2", "linestyle": "-", "linewidth": 1.0},
    {"color": "#D55E00", "linestyle": (0, (4, 1.4)), "linewidth": 1.0},
    {"color": "#000000", "linestyle": (0, (4, 1.2, 1, 1.2)), "linewidth": 0.9},
)
MOST_PANELS = 8
"""Most panels of a user's system."""


class GivenAxes:
    """Axes of a user in the place of a figure: a part of a motion takes its panels from here."""

    def __init__(self, figure: Any, axes: Any, part: str) -> None:
        self.figure, self.axes, self.part = figure, np.ravel(axes), part

    def subplots(self, rows: int = 1, columns: int = 1, **_: Any) -> Any:  # noqa: ARG002
        """The axes, if they are as many as the part has panels."""
        if len(self.axes) != rows:
            raise ParameterError(f"ax holds {len(self.axes)} axes; give {rows} for {self.part}.")
        return self.axes if rows > 1 else self.axes[0]

    def colorbar(self, *args: Any, **options: Any) -> Any:
        """A colour bar in the figure of the axes."""
        return self.figure.colorbar(*args, **options)

    def align_ylabels(self) -> None:
        """Line up the labels of the panels."""
        self.figure.align_ylabels(self.axes)


def unit(data: xarray.Dataset, name: str) -> str:
    """The unit of a series in brackets, as an axis shows it; nothing for a bare number."""
    word = unit_of(data[name].attrs)
    return "" if word == "1" else f"[{in_latex(word)}]"


def legend(axes: Axes, handles: list[Line2D] | None = None) -> None:
    """Draw a legend above the panel, where it hides no data."""
    shown = handles or axes.get_legend_handles_labels()[0]
    axes.legend(
        handles=shown,
        loc="lower right",
        bbox_to_anchor=(1.02, 0.98),
        ncols=len(shown) if len(shown) < 5 else 3,
        frameon=False,
        handlelength=2.2,
        borderpad=0.1,
        columnspacing=1.1,
        handletextpad=0.4,
    )


def words(axes: Axes, motion: SingleRun) -> None:
    """Write the word of each event over its line; words that would overlap are left out."""
    room = 0.035 * (motion.times[-1] - motion.times[0])
    marks = motion.events
    if not marks:  # a slice whose events are not known
        marks = [((a + b) / 2, "sticking") for a, b in motion.sticking]
    free: list[float] = []
    # the last event comes first, since it matters most
    for t, word in marks[-1:] + marks[:-1]:
        if all(abs(t - other) > room for other in free):
            free.append(t)
            axes.text(
                t,
                1.03,
                word,
                rotation=90,
                fontsize=small(),
                ha="center",
                va="bottom",
                transform=axes.get_xaxis_transform(),
            )


def draw_system(page: Any, motion: SingleRun, names: tuple[str, ...]) -> None:
    """Draw the states of a user's system; many states share panels by unit.

    A state whose unit comes after the first `MOST_PANELS` units is not drawn.
    """
    data, times = motion.data, motion.times
    groups: list[tuple[str, ...]] = [(n,) for n in names]
    if len(names) > MOST_PANELS:
        units = list(dict.fromkeys(unit(data, n) for n in names))[:MOST_PANELS]
        groups = [tuple(n for n in names if unit(data, n) == u) for u in units]
    panels = np.atleast_1d(page.subplots(len(groups), 1, sharex=True))
    for axes, group in zip(panels, groups, strict=True):
        for i, name in enumerate(group):
            axes.plot(
                times,
                data[name].values,
                label=name.replace("$", r"\$"),
                **STROKES[i % len(STROKES)],
            )
        word = group[0].replace("_", " ").replace("$", r"\$") if len(group) == 1 else ""
        axes.set_ylabel(f"{word}\n{unit(data, group[0])}".strip("\n"))
        axes.yaxis.set_major_locator(MaxNLocator(5))
        for t, _ in motion.events:
            axes.axvline(t, color="#404040", linewidth=0.5, zorder=1)
        if len(group) > 1:
            legend(axes)
    if "nearest_member" in data and BY_CODE[int(data.outcome)] is Outcome.SETTLED:
        _dotted(dict(zip(groups, panels, strict=True)), names, data.nearest_member.values)
    words(panels[0], motion)
    panels[-1].set_xlim(times[0], times[-1])
    panels[-1].set_xlabel(f"time  {unit(data, 'time')}")
    page.align_ylabels()


def _dotted(panels: dict[tuple[str, ...], Axes], names: tuple[str, ...], member: Any) -> None:
    """Draw dotted lines at the steady motion on which the run settled."""
    for group, axes in panels.items():
        if len(group) == 1:
            at = float(member[names.index(group[0])])
            axes.axhline(at, color="black", linestyle=":", linewidth=1.0, label="steady")
            legend(axes)


def lines_of_energy(axes: Axes, motion: SingleRun) -> None:
    """Draw energy, dissipated energy and their constant sum as lines.

    Stacked layers would be wrong, since a user's energy may be negative.
    """
    data = motion.data
    lines = {"energy": data.energy.values, "dissipated": data.dissipated.values}
    lines["sum"] = lines["energy"] + lines["dissipated"]
    for (name, values), stroke in zip(lines.items(), STROKES, strict=True):
        axes.plot(motion.times, values, label=name, **stroke)
