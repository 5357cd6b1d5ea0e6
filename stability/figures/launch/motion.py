"""Figures only: one motion in time and in the plane, and its energy."""

from __future__ import annotations

from ..canvas import COLUMN, STYLE, figure_style  # isort: skip
from ..styled_figure import spacing  # isort: skip

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection
from matplotlib.colors import ListedColormap, Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import LogLocator, MaxNLocator, NullLocator

from ...bodies.thin_disk.disk_equations import STATES
from ...bodies.thin_disk.disk_families import FAMILIES
from ...bodies.thin_disk.disk_quantities import QUANTITIES
from ...motion.result import BY_CODE, Outcome
from .motion_panels import MOST_PANELS, STROKES, draw_system, legend, lines_of_energy, unit, words
from .single_run import SingleRun, one_launch, system_states

if TYPE_CHECKING:
    import xarray

from .caption import tolerance_of

PAGE = 7.0
"""Width of a figure over two journal columns [in]."""
ENERGIES = ("potential", "kinetic", "dissipated")
POSE = ("contact_x", "contact_y", "centre_x", "centre_y")
FILLS = (("#56B4E9", ""), ("#F0E442", "////"), ("#CC79A7", "...."))
"""Colour and hatching of each of `ENERGIES`."""
# the palest end of the map would be lost on white paper
TIME_MAP = ListedColormap(matplotlib.colormaps["viridis"](np.linspace(0, 0.92, 256)))
PANELS = (
    ("inclination", ("theta",)), ("rates", ("theta_dot", "phi_dot", "omega3")),
    ("slip", ("slip_x", "slip_y")), ("normal force", ("normal_force",)),
)  # fmt: skip
"""Word and series of each panel over time."""
START: dict[str, Any] = {"marker": "o", "ls": "", "color": "black", "mfc": "none"}
END: dict[str, Any] = {"marker": "s", "ls": "", "color": "black"}


def states(dataset: xarray.Dataset) -> Figure:
    """The states and the normal force over time, one panel below the other.

    Parameters
    ----------
    dataset
        From `simulate`, one launch.

    Returns
    -------
    Figure
        One journal column wide; sticking is hatched, events are vertical lines with a word.

    Raises
    ------
    ParameterError
        If the dataset holds several launches or lacks a series.

    Examples
    --------
    >>> import stability as st
    >>> run = st.simulate(st.Disk(), st.Viscous(0.3), {"theta": 1.5, "omega3": 1.2}, 9.0)
    >>> len(states(run).axes)
    4
    """
    if names := system_states(dataset):
        motion = one_launch(dataset, names)
        height = 1.2 + min(len(names), MOST_PANELS)
        return _drawn(COLUMN, height, lambda page: draw_system(page, motion, names))
    motion = one_launch(dataset, (*STATES, "normal_force"))
    return _drawn(COLUMN, 4.7, lambda page: _draw_states(page, motion))


def paths(dataset: xarray.Dataset) -> Figure:
    """The paths of the contact point and of the centre in the plane, time shown by colour.

    Parameters
    ----------
    dataset
        From `simulate` with `pose=True`, one launch.

    Returns
    -------
    Figure
        One journal column wide; the path is dashed where the disk sticks.

    Raises
    ------
    ParameterError
        If the dataset holds several launches or lacks the pose.

    Examples
    --------
    >>> import stability as st
    >>> start = {"theta": 1.5, "omega3": 1.2}
    >>> run = st.simulate(st.Disk(), st.Viscous(0.3), start, 9.0, pose=True)
    >>> paths(run).axes[0].get_xlabel()
    '$X$  [$R$]'
    """
    motion = one_launch(dataset, POSE)
    return _drawn(COLUMN, 3.2, lambda page: _draw_paths(page, motion))


def energy(dataset: xarray.Dataset) -> Figure:
    """The energy by kind with its constant total, and the error of the energy audit.

    Parameters
    ----------
    dataset
        From `simulate`, one launch.

    Returns
    -------
    Figure
        One journal column wide.

    Raises
    ------
    ParameterError
        If the dataset holds several launches or lacks a series.

    Examples
    --------
    >>> import stability as st
    >>> run = st.simulate(st.Disk(), st.Viscous(0.3), {"theta": 1.5, "omega3": 1.2}, 9.0)
    >>> [axes.get_yscale() for axes in energy(run).axes]
    ['linear', 'log']
    """
    motion = one_launch(dataset, (*_energies(dataset), "energy", "audit"))
    return _drawn(COLUMN, 3.3, lambda page: _draw_energy(page, motion))


def motion_figure(dataset: xarray.Dataset) -> Figure:
    """States, paths and energy of one launch on one figure.

    Parameters
    ----------
    dataset
        From `simulate`, one launch.  The paths are left out without a pose, and the energy
        where a system has no energy account.

    Returns
    -------
    Figure
        Two journal columns wide.

    Raises
    ------
    ParameterError
        If the dataset holds several launches or lacks a series.

    Examples
    --------
    >>> import stability as st
    >>> run = st.simulate(st.Disk(), st.Viscous(0.3), {"theta": 1.5, "omega3": 1.2}, 9.0)
    >>> figure = motion_figure(run)
    >>> len(figure.axes), float(figure.get_figwidth())
    (6, 7.0)
    """
    if names := system_states(dataset):
        return _system_figure(dataset, names)
    motion = one_launch(dataset, (*STATES, "normal_force", *ENERGIES, "energy", "audit"))

    def draw(page: Any) -> None:
        left, right = page.subfigures(1, 2)
        _draw_states(left, motion)
        if posed:
            upper, right = right.subfigures(2, 1)
            _draw_paths(upper, motion)
        _draw_energy(right, motion)

    posed = all(name in dataset for name in POSE)
    return _drawn(PAGE, 5.6 if posed else 4.4, draw)


def _system_figure(dataset: xarray.Dataset, names: tuple[str, ...]) -> Figure:
    motion = one_launch(dataset, names)
    if "audit" not in dataset:
        return states(dataset)

    def draw(page: Any) -> None:
        left, right = page.subfigures(1, 2)
        draw_system(left, motion, names)
        _draw_energy(right, motion)

    return _drawn(PAGE, max(3.3, 1.2 + min(len(names), MOST_PANELS)), draw)


def _energies(dataset: Any) -> tuple[str, ...]:
    """Layers of the energy: those of a disk, or of a user's system."""
    return ("energy", "dissipated") if system_states(dataset) else ENERGIES


def _drawn(width: float, height: float, draw: Callable[[Any], None]) -> Figure:
    with figure_style(STYLE):
        figure = Figure(figsize=(width, height), layout="constrained")
        spacing(figure, hspace=0.02, wspace=0.03, h_pad=0.02, w_pad=0.03)
        draw(figure)
        figure.draw_without_rendering()  # ticks take their style when first drawn
    return figure


def _draw_states(page: Any, motion: SingleRun) -> None:
    panels = page.subplots(len(PANELS), 1, sharex=True)
    data, times = motion.data, motion.times
    for axes, (word, names) in zip(panels, PANELS, strict=True):
        for name, stroke in zip(names, STROKES, strict=False):
            axes.plot(times, data[name].values, label=QUANTITIES[name].typeset, **stroke)
        symbol = QUANTITIES[names[0]].typeset if len(names) == 1 else ""
        axes.set_ylabel(f"{word}\n{symbol} {unit(data, names[0])}".replace("\n ", "\n"))
        axes.yaxis.set_major_locator(MaxNLocator(5))
        for start, stop in motion.sticking:
            axes.axvspan(start, stop, facecolor="#e4e4e4", edgecolor="#9a9a9a", hatch="////",
                         linewidth=0, zorder=0)  # fmt: skip
        for t, _ in motion.events:
            axes.axvline(t, color="#404040", linewidth=0.5, zorder=1)
    panels[0].axhline(np.pi / 2, color="#404040", linestyle="--", linewidth=0.7, zorder=1)
    panels[0].annotate(r"$\pi/2$", (1.01, np.pi / 2), xycoords=("axes fraction", "data"),
                       va="center", fontsize=6.5, annotation_clip=False)  # fmt: skip
    low, high = panels[0].get_ylim()
    panels[0].set_ylim(min(low, high - 0.02), max(high, low + 0.02))  # not down to rounding errors
    panels[0].ticklabel_format(useOffset=False)
    panels[3].axhline(0, color="#404040", linewidth=0.7, zorder=1)
    _steady(panels, data)
    for axes in panels[1:3]:
        legend(axes)
    words(panels[0], motion)
    panels[-1].set_xlim(times[0], times[-1])
    panels[-1].set_xlabel(f"time $t$  {unit(data, 'time')}")
    page.align_ylabels()


def _steady(panels: list[Axes], data: xarray.Dataset) -> None:
    """Draw dotted lines at the steady motion on which the run settled."""
    if "nearest_at" not in data or BY_CODE[int(data.outcome)] is not Outcome.SETTLED:
        return
    family, at = FAMILIES.get(str(data.nearest_family.values)), float(data.nearest_at)
    if family is None:  # a file from elsewhere may name an unknown family
        return
    rate = np.sqrt(float(data.gravity) / float(data.radius))
    turned = np.copysign(rate, data.phi_dot.values[-1])
    member = family.member(np, at, float(data.k), turned)
    shown = [*family.at, *(family.unknown if family.solution else ())]
    for axes, (_, names) in zip(panels, PANELS, strict=True):
        for name in (n for n in names if n in shown):
            axes.axhline(member[name], label="steady", color="black", linestyle=":", linewidth=1.0)
            if axes is panels[0]:
                legend(axes)


def _draw_paths(page: Any, motion: SingleRun) -> None:
    data, times, axes = motion.data, motion.times, page.subplots()
    shade: dict[str, Any] = {"cmap": TIME_MAP, "norm": Normalize(times[0], times[-1])}
    for name, width in (("contact", 1.8), ("centre", 0.8)):
        x, y = data[f"{name}_x"].values, data[f"{name}_y"].values
        corners = np.column_stack([x, y])
        # each piece overlaps the next, so that no seams show
        pieces = [corners[i : i + 3] for i in range(len(x) - 1)]
        axes.add_collection(LineCollection(pieces, array=(times[1:] + times[:-1]) / 2, **shade,
                            linewidths=width, rasterized=len(x) > 20_000,
                            zorder=2 if width > 1 else 3))  # fmt: skip
        # the start is larger and hollow, so that an end on top of it does not hide it
        axes.plot(x[:1], y[:1], markersize=4 + 1.6 * width, zorder=4, **START)
        axes.plot(x[-1:], y[-1:], markersize=2 + 1.2 * width, zorder=4, **END)
    for a, b in motion.sticking:
        # white gaps over the colours, since a line of many colours cannot be dashed
        when = np.union1d([a, b], times[(times > a) & (times < b)])
        x, y = (np.interp(when, times, data[f"contact_{c}"].values) for c in "xy")
        axes.plot(x, y, color="white", linewidth=2.4, dashes=(0.7, 1.3), dash_capstyle="butt",
                  label="gaps", zorder=2.5)  # fmt: skip
    # for a disk that spins on the spot the axes must not shrink to rounding errors
    spot = 0.02 * float(data.radius) * np.array([[-1, -1], [1, 1]])
    axes.update_datalim([data.centre_x.values[0], data.centre_y.values[0]] + spot)
    axes.set_aspect("equal", adjustable="datalim")
    axes.autoscale_view()
    for axis, letter in ((axes.xaxis, "X"), (axes.yaxis, "Y")):
        axis.set_major_locator(MaxNLocator(5))
        axis.set_label_text(f"${letter}$  {unit(data, 'centre_x')}")
    axes.ticklabel_format(useOffset=False)
    legend(axes, _keys(bool(motion.sticking), "first sample" if motion.times[0] else "start"))
    bar = page.colorbar(ScalarMappable(**shade), ax=axes, pad=0.02, aspect=30, fraction=0.05)
    bar.set_label(f"time $t$  {unit(data, 'time')}")


def _keys(sticks: bool, first: str) -> list[Line2D]:
    ink: dict[str, Any] = {"color": "#303030"}
    slides = Line2D([], [], linewidth=1.8, label="contact, sliding" if sticks else "contact", **ink)
    stuck = Line2D([], [], linewidth=1.8, dashes=(1.7, 1), label="contact, sticking", **ink)
    centre = Line2D([], [], linewidth=0.8, label="centre", **ink)
    ends = [Line2D([], [], label=first, markersize=5, **START),
            Line2D([], [], label="end", markersize=4, **END)]  # fmt: skip
    return [slides, *([stuck] if sticks else []), centre, *ends]


def _draw_energy(page: Any, motion: SingleRun) -> None:
    data, times = motion.data, motion.times
    upper, lower = page.subplots(2, 1, sharex=True, height_ratios=(1.5, 1))
    if system_states(data):
        lines_of_energy(upper, motion)
    else:
        _layers_of_energy(upper, motion)
    # largest audit over stated error: the scale of the energy, for a disk its value at time 0
    largest = float(np.abs(data.audit.values).max())
    first = largest / (float(data.energy_error) or 1.0) or 1.0
    upper.set_ylabel(f"energy\n{unit(data, 'energy')}")
    upper.set_xlim(times[0], times[-1])
    legend(upper)
    audit = np.abs(data.audit.values) / first
    seen = np.where(audit > 0, audit, np.nan)  # a log axis has no zero, so leave a gap
    lower.set_yscale("log")
    lower.plot(times, seen, label="audit", marker=".", markersize=1.2, linewidth=0.7,
               color=STROKES[0]["color"])  # fmt: skip
    tolerance = tolerance_of(data)
    lower.axhline(tolerance, label="tolerance of a step", color="black", linestyle="--",
                  linewidth=0.8)  # fmt: skip
    shown = np.append(seen[audit > 0], tolerance)
    lower.set_ylim(shown.min() / 5, shown.max() * 5)
    legend(lower)
    lower.yaxis.set_major_locator(LogLocator(numticks=6))
    lower.yaxis.set_minor_locator(NullLocator())
    lower.set_ylabel("|audit| over\n" + ("energy" if system_states(data) else "initial energy"))
    lower.set_xlabel(f"time $t$  {unit(data, 'time')}")
    page.align_ylabels()


def _layers_of_energy(upper: Axes, motion: SingleRun) -> None:
    """The energies of a disk, stacked to their constant total."""
    data, times = motion.data, motion.times
    layers = np.stack([data[name].values for name in ENERGIES])
    fills = upper.stackplot(times, layers, colors=[c for c, _ in FILLS], labels=ENERGIES)
    for fill, (_, hatch) in zip(fills, FILLS, strict=True):
        fill.set(hatch=hatch, edgecolor="#606060", linewidth=0)
    for line in np.cumsum(layers, axis=0):
        upper.plot(times, line, color="black", linewidth=0.3)
    upper.set_ylim(0, 1.04 * float(layers.sum(axis=0).max()))
