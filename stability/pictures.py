"""Figures only: one motion in time and in the plane, its energy, and a caption that says it all."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import ListedColormap, Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import LogLocator, MaxNLocator, NullLocator

from .errors import ParameterError
from .flow import Floats
from .outcome import BY_CODE, Outcome
from .plots import COLUMN, STYLE, SYMBOLS, UNITS, spacing
from .sticking import REVERSE, SLIP, STICK, STICKING

if TYPE_CHECKING:
    import xarray

PAGE = 7.0
"""Width of a figure over two journal columns [in]."""
IN_LATEX = UNITS | {
    "√(R/g)": r"$\sqrt{R/g}$", "√(gR)": r"$\sqrt{gR}$", "m g": r"$mg$", "m g R": r"$mgR$",
    "R": r"$R$",
}  # fmt: skip
"""LaTeX unit by its words."""
STATES = ("theta", "theta_dot", "phi_dot", "omega3", "slip_x", "slip_y")
ENERGIES = ("potential", "kinetic", "dissipated")
POSE = ("contact_x", "contact_y", "centre_x", "centre_y")
# apart for every common colour vision, and in grey by the dashes
STROKES: tuple[dict[str, Any], ...] = (
    {"color": "#0072B2", "linestyle": "-", "linewidth": 1.0},
    {"color": "#D55E00", "linestyle": (0, (4, 1.4)), "linewidth": 1.0},
    {"color": "#000000", "linestyle": (0, (4, 1.2, 1, 1.2)), "linewidth": 0.9},
)
FILLS = (("#56B4E9", ""), ("#F0E442", "////"), ("#CC79A7", "...."))
"""Colour and hatching of each of `ENERGIES`."""
# the palest end of the map would be lost on white paper
TIME_MAP = ListedColormap(matplotlib.colormaps["viridis"](np.linspace(0, 0.92, 256)))
PANELS = (
    ("inclination", ("theta",)), ("rates", ("theta_dot", "phi_dot", "omega3")),
    ("slip", ("slip_x", "slip_y")), ("normal force", ("normal_force",)),
)  # fmt: skip
"""Words and lines of each panel over time."""
LAWS = {
    "smooth": "without friction", "viscous": "under viscous friction", "rough": "without slip",
    "linear-viscous": "under linear viscous friction", "coulomb": "under dry friction",
    "coulomb-regularised": "under regularised dry friction",
}  # fmt: skip
GIVEN = {
    "mass": ("m", "kg"), "radius": ("R", "m"), "gravity": ("g", "m/s²"), "k": ("k", ""),
    "mu": ("μ", ""), "c": ("c", "kg/s"), "epsilon": ("ε", "m/s"),
}  # fmt: skip
"""Symbol and SI unit of a parameter; the μ of viscous friction is in s/m."""
Event = tuple[float, str]
Span = tuple[float, float]


@dataclass(frozen=True, eq=False)
class Motion:
    """One launch, up to its end, with what happened on the way."""

    data: xarray.Dataset
    """Its samples; the last is its end."""
    times: Floats
    """Of the samples."""
    events: list[Event]
    """Time and word of each."""
    sticking: list[Span]
    """From when to when it stuck."""


def states(dataset: xarray.Dataset) -> Figure:
    """The states and the normal force over time, one panel below the other.

    Parameters
    ----------
    dataset
        From `simulate`, one launch.

    Returns
    -------
    Figure
        One journal column wide; sticking is hatched, events are upright lines with a word.

    Raises
    ------
    ParameterError
        If there are several launches, fewer than two samples, or a series is missing.

    Examples
    --------
    >>> import stability as st
    >>> run = st.simulate(st.Disk(), st.Viscous(0.3), {"theta": 1.5, "omega3": 1.2}, 9.0)
    >>> len(states(run).axes)
    4
    """
    motion = _motion(dataset, (*STATES, "normal_force"))
    with matplotlib.rc_context(STYLE):
        figure = _page(COLUMN, 4.7)
        _draw_states(list(figure.subplots(len(PANELS), 1, sharex=True)), motion)
        figure.draw_without_rendering()  # ticks take their style when first drawn
    return figure


def paths(dataset: xarray.Dataset) -> Figure:
    """The paths of the contact point and of the centre in the plane, time told by colour.

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
        If there are several launches, fewer than two samples, or no pose.

    Examples
    --------
    >>> import stability as st
    >>> start = {"theta": 1.5, "omega3": 1.2}
    >>> run = st.simulate(st.Disk(), st.Viscous(0.3), start, 9.0, pose=True)
    >>> paths(run).axes[0].get_xlabel()
    '$X$  [$R$]'
    """
    motion = _motion(dataset, POSE)
    with matplotlib.rc_context(STYLE):
        figure = _page(COLUMN, 3.2)
        _draw_paths(figure.subplots(), motion)
        figure.draw_without_rendering()
    return figure


def energy(dataset: xarray.Dataset) -> Figure:
    """Where the energy is, stacked to its constant total, and how well the audit closes.

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
        If there are several launches, fewer than two samples, or a series is missing.

    Examples
    --------
    >>> import stability as st
    >>> run = st.simulate(st.Disk(), st.Viscous(0.3), {"theta": 1.5, "omega3": 1.2}, 9.0)
    >>> [axes.get_yscale() for axes in energy(run).axes]
    ['linear', 'log']
    """
    motion = _motion(dataset, (*ENERGIES, "energy", "audit"))
    with matplotlib.rc_context(STYLE):
        figure = _page(COLUMN, 3.3)
        _draw_energy(list(figure.subplots(2, 1, sharex=True, height_ratios=(1.5, 1))), motion)
        figure.draw_without_rendering()
    return figure


def motion_figure(dataset: xarray.Dataset) -> Figure:
    """States, paths and energy of one launch on one figure.

    Parameters
    ----------
    dataset
        From `simulate`, one launch; the paths are left out where it has no pose.

    Returns
    -------
    Figure
        Two journal columns wide.

    Raises
    ------
    ParameterError
        If there are several launches, fewer than two samples, or a series is missing.

    Examples
    --------
    >>> import stability as st
    >>> run = st.simulate(st.Disk(), st.Viscous(0.3), {"theta": 1.5, "omega3": 1.2}, 9.0)
    >>> figure = motion_figure(run)
    >>> len(figure.axes), figure.get_figwidth()
    (6, 7.0)
    """
    motion = _motion(dataset, (*STATES, "normal_force", *ENERGIES, "energy", "audit"))
    posed = all(name in dataset for name in POSE)
    with matplotlib.rc_context(STYLE):
        figure = _page(PAGE, 5.6 if posed else 4.4)
        left, right = figure.subfigures(1, 2)
        _draw_states(list(left.subplots(len(PANELS), 1, sharex=True)), motion)
        if posed:
            upper, right = right.subfigures(2, 1, height_ratios=(1, 1))
            _draw_paths(upper.subplots(), motion)
        _draw_energy(list(right.subplots(2, 1, sharex=True, height_ratios=(1.5, 1))), motion)
        figure.draw_without_rendering()
    return figure


def caption(dataset: xarray.Dataset) -> str:
    """What was computed and what came of it, in two sentences.

    Parameters
    ----------
    dataset
        From `simulate`, one launch.

    Returns
    -------
    str
        Body, contact law, span of time, method, tolerance; outcome and evidence.

    Raises
    ------
    ParameterError
        If there are several launches, fewer than two samples, or a series is missing.

    Examples
    --------
    >>> import stability as st
    >>> run = st.simulate(st.Disk(), st.Smooth(), {"theta": 1.0}, 5.0)
    >>> caption(run).split("  ")[1]
    'Outcome: flat, at time 1.571 √(R/g) (flat at time 1.57113661).'
    """
    motion = _motion(dataset, (*STATES, "outcome", "evidence", "end_time", "method"))
    data, plain = motion.data, bool(dataset.attrs.get("dimensionless", 0))
    law = str(dataset.attrs.get("contact", ""))
    unit = " √(R/g)" if plain else " s"
    given = [_given(data, name, plain, law) for name in GIVEN if name in data.coords]
    start = ", ".join(_number(data, name, plain) for name in STATES)
    note = "" if plain else "; its numbers in units of m, R, g"
    audit = ""
    if "energy_error" in data:
        audit = (
            f"; the energy audit closes to {float(data.energy_error):.1g} of the initial energy"
        )
    return (
        f"Motion of a disk {LAWS.get(law, f'with {law} contact')} ("
        f"{', '.join(given)}{', dimensionless' if plain else ''}) from {start} at time "
        f"{motion.times[0]:.4g} to {motion.times[-1]:.4g}{unit}, by {data.method.item()} at "
        f"tolerance {_tolerance(dataset):.3g}{audit}.  "
        f"Outcome: {BY_CODE[int(data.outcome)].word}, at time {float(data.end_time):.4g}{unit} "
        f"({data.evidence.item()}{note})."
    )


def _motion(dataset: xarray.Dataset, needed: tuple[str, ...]) -> Motion:
    """One launch up to its end, refused in a sentence if it is not one or lacks something."""
    import xarray

    if not isinstance(dataset, xarray.Dataset):
        raise ParameterError(f"dataset is {type(dataset).__name__}; give what simulate returns.")
    missing = [name for name in ("time", *needed) if name not in dataset.variables]
    if missing:
        remedy = "with pose=True" if missing[0] in POSE else "unchanged"
        raise ParameterError(f"dataset has no {missing[0]}; give what simulate returns {remedy}.")
    several = [d for d in dataset.sizes if d not in ("time", "event", "state")]
    if several:
        taken = ", ".join(f"{d}=i" for d in several)
        count = " x ".join(str(dataset.sizes[d]) for d in several)
        raise ParameterError(f"dataset holds {count} launches; take one by .isel({taken}).")
    data = _until_end(dataset)
    if data.sizes.get("time", 0) < 2:
        raise ParameterError("dataset has fewer than two samples; ask simulate for more times.")
    times = np.asarray(data.time.values, dtype=float)
    log = _log(data, times)
    spans = _spans(log, data, times)
    seen = [(t, word) for t, word in log if times[0] <= t <= times[-1]]
    return Motion(data, times, seen, spans)


def _until_end(dataset: xarray.Dataset) -> xarray.Dataset:
    """A slice of several launches without what is only held, its end dated as in a single run."""
    if "running" not in dataset or dataset.running.values.all():
        return dataset
    count = int(np.argmin(dataset.running.values))
    times, end = dataset.time.values[: count + 1].astype(float), float(dataset.end_time)
    if count and times[count - 1] >= end:
        return dataset.isel(time=slice(0, count))
    times[-1] = end
    kept = dataset.isel(time=slice(0, count + 1))
    return kept.assign_coords(time=("time", times, dataset.time.attrs))


def _log(data: xarray.Dataset, times: Floats) -> list[Event]:
    """The events of this launch; none where a slice does not show which are its own."""
    if "event_kind" not in data or not data.sizes.get("event"):
        return []
    owner = data.event_launch.values
    own = owner == owner[0]
    if "running" in data:
        fitting = [j for j in np.unique(owner) if _fits(data, times, owner == j)]
        own = owner == fitting[0] if len(fitting) == 1 else np.zeros(len(owner), dtype=bool)
    pairs = zip(data.event_time.values[own], data.event_kind.values[own], strict=True)
    return sorted((float(t), str(word)) for t, word in pairs)


def _fits(data: xarray.Dataset, times: Floats, own: Any) -> bool:
    """Whether events can be those of this launch: its end, its modes and its states agree.

    A slice still lists the events of all launches, and even a log with one owner may be that of
    a neighbour, because a launch without events has no entry.
    """
    when, kinds = data.event_time.values[own], data.event_kind.values[own]
    end = float(data.end_time)
    ended = BY_CODE[int(data.outcome)] not in (Outcome.MOVING, Outcome.SETTLED)
    last = kinds[-1] not in (STICK, SLIP, REVERSE)
    if ended != last or (last and not np.isclose(when[-1], end, rtol=1e-12, atol=0)):
        return False
    if when.max() > end:
        return False
    if "mode" in data:
        log = list(zip(when.tolist(), kinds.tolist(), strict=True))
        stuck = [any(a <= t < b for a, b in _spans(log, data, times)) for t in times]
        clear = ~np.isin(times, when) & (times < times[-1])
        if (np.array(stuck) != (data["mode"].values == STICKING))[clear].any():
            return False
    series = np.stack([data[name].values for name in STATES])
    margin = np.abs(np.diff(series)).max(axis=1) + 1e-9  # a sample's step is as near as can be
    inside = (when >= times[0]) & (when <= times[-1])
    for t, state in zip(when[inside], data.event_state.values[own][inside], strict=True):
        between = np.array([np.interp(t, times, row) for row in series])
        if (np.abs(state - between) > margin).any():
            return False
    return True


def _spans(log: list[Event], data: xarray.Dataset, times: Floats) -> list[Span]:
    """From when to when the disk stuck: from the log, or from the samples where there is none."""
    if "mode" not in data:
        return []
    stuck = data["mode"].values == STICKING
    turns = [(t, word) for t, word in log if word in (STICK, SLIP)]
    if not turns:
        flips = np.flatnonzero(np.diff(stuck.astype(int))) + 1
        turns = [(float(times[i]), STICK if stuck[i] else SLIP) for i in flips]
    begins = turns[0][1] == SLIP if turns else bool(stuck[0])
    edges = [-np.inf] * begins + [t for t, _ in turns]
    edges += [np.inf] * (len(edges) % 2)
    clipped = np.clip(edges, times[0], times[-1]).reshape(-1, 2).tolist()
    return [(a, b) for a, b in clipped if b > a]


def _page(width: float, height: float) -> Figure:
    figure = Figure(figsize=(width, height), layout="constrained")
    spacing(figure, hspace=0.02, wspace=0.03, h_pad=0.02, w_pad=0.03)
    return figure


def _unit(data: xarray.Dataset, name: str) -> str:
    attributes = data[name].attrs
    unit = attributes.get("unit_in_words", attributes.get("units", "1"))
    return "" if unit == "1" else f"[{IN_LATEX.get(unit, unit)}]"


def _legend(axes: Axes, handles: list[Any] | None = None, columns: int = 4) -> None:
    """Above the panel, where it can hide no data."""
    given = {"handles": handles} if handles else {}
    axes.legend(
        **given, loc="lower right", bbox_to_anchor=(1.02, 0.98), ncols=columns, fontsize=6.5,
        frameon=False, handlelength=2.2, borderpad=0.1, columnspacing=1.1, handletextpad=0.4,
    )  # fmt: skip


def _draw_states(panels: list[Axes], motion: Motion) -> None:
    data, times = motion.data, motion.times
    for axes, (word, names) in zip(panels, PANELS, strict=True):
        for name, stroke in zip(names, STROKES, strict=False):
            axes.plot(times, data[name].values, label=SYMBOLS.get(name), **stroke)
        symbol = SYMBOLS.get(names[0], "") if len(names) == 1 else ""
        axes.set_ylabel(f"{word}\n{symbol} {_unit(data, names[0])}".replace("\n ", "\n"))
        axes.yaxis.set_major_locator(MaxNLocator(5))
        for start, stop in motion.sticking:
            axes.axvspan(start, stop, facecolor="#e4e4e4", edgecolor="#9a9a9a", hatch="////",
                         linewidth=0, zorder=0)  # fmt: skip
        for t, _ in motion.events:
            axes.axvline(t, color="#404040", linewidth=0.5, zorder=1)
    panels[0].axhline(np.pi / 2, color="#404040", linestyle="--", linewidth=0.7, zorder=1)
    panels[0].annotate(r"$\pi/2$", (1.01, np.pi / 2), xycoords=("axes fraction", "data"),
                       va="center", fontsize=6.5, annotation_clip=False)  # fmt: skip
    panels[3].axhline(0, color="#404040", linewidth=0.7, zorder=1)
    _steady(panels, data)
    for axes in panels[1:3]:
        _legend(axes)
    _words(panels[0], motion)
    panels[-1].set_xlim(times[0], times[-1])
    panels[-1].set_xlabel(f"time $t$  {_unit(data, 'time')}")


def _steady(panels: list[Axes], data: xarray.Dataset) -> None:
    """Dotted, the steady motion that was settled on."""
    if "nearest_at" not in data or BY_CODE[int(data.outcome)] is not Outcome.SETTLED:
        return
    family, at = str(data.nearest_family.values), float(data.nearest_at)
    dots: dict[str, Any] = {"color": "black", "linestyle": ":", "linewidth": 1.0}
    if family == "tumbling":
        panels[0].axhline(at, label="steady", **dots)
        _legend(panels[0])
        scale = np.sqrt(float(data.gravity) / float(data.radius) / float(data.k) / np.sin(at))
        at = float(np.copysign(scale, data.phi_dot.values[-1]))
    panels[1].axhline(at, label="steady", **dots)


def _words(axes: Axes, motion: Motion) -> None:
    """The word of each event over its line; of a crowd only those that can be read."""
    span = motion.times[-1] - motion.times[0]
    room = 0.035 * span
    marks = motion.events
    if not marks:  # a slice whose events are not known
        marks = [((a + b) / 2, "sticking") for a, b in motion.sticking]
    free: list[float] = []
    # the end comes first: it is the one that matters most
    for t, word in marks[-1:] + marks[:-1]:
        if all(abs(t - other) > room for other in free):
            free.append(t)
            axes.text(t, 1.03, word, rotation=90, fontsize=6.5, ha="center", va="bottom",
                      transform=axes.get_xaxis_transform())  # fmt: skip


def _draw_paths(axes: Axes, motion: Motion) -> None:
    data, times = motion.data, motion.times
    norm = Normalize(times[0], times[-1])
    all_x, all_y = (np.stack([data[f"{n}_{c}"].values for n in ("contact", "centre")])
                    for c in "xy")  # fmt: skip
    middle = [(v.max() + v.min()) / 2 for v in (all_x, all_y)]
    # a disk that spins on the spot must not be blown up to its rounding errors
    half = [max(float(np.ptp(v)) * 0.54, 0.02 * float(data.radius)) for v in (all_x, all_y)]
    dash = max(half) / 28
    for x, y, width in zip(all_x, all_y, (1.8, 0.8), strict=True):
        lines, colours = _pieces(times, x, y, motion.sticking if width > 1 else [], dash)
        axes.add_collection(LineCollection(
            lines, array=colours, cmap=TIME_MAP, norm=norm, linewidths=width,
            capstyle="butt", rasterized=len(lines) > 20_000,
        ), autolim=False)  # fmt: skip
        edge = {"color": "black", "markersize": 2 + 1.6 * width, "markeredgewidth": 0.7}
        axes.plot(x[:1], y[:1], "o", markerfacecolor="white", zorder=4, **edge)
        axes.plot(x[-1:], y[-1:], "s", zorder=4, **edge)
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_xlim(middle[0] - half[0], middle[0] + half[0])
    axes.set_ylim(middle[1] - half[1], middle[1] + half[1])
    for axis, letter, name in ((axes.xaxis, "X", "centre_x"), (axes.yaxis, "Y", "centre_y")):
        axis.set_major_locator(MaxNLocator(5))
        axis.set_label_text(f"${letter}$  {_unit(data, name)}")
    axes.ticklabel_format(useOffset=False)
    _legend(axes, _keys(bool(motion.sticking)), 3)
    bar = axes.figure.colorbar(
        matplotlib.cm.ScalarMappable(norm, TIME_MAP), ax=axes, pad=0.02, aspect=30, fraction=0.05
    )
    bar.set_label(f"time $t$  {_unit(data, 'time')}")


def _keys(sticks: bool) -> list[Line2D]:
    ink: dict[str, Any] = {"color": "#303030"}
    keys = [Line2D([], [], linewidth=1.8, label="contact, sliding" if sticks else "contact", **ink)]
    if sticks:
        keys.append(Line2D([], [], linewidth=1.8, linestyle=(0, (1.7, 1)),
                           label="contact, sticking", **ink))  # fmt: skip
    keys.append(Line2D([], [], linewidth=0.8, label="centre", **ink))
    point: dict[str, Any] = {"linestyle": "", "color": "black", "markersize": 4}
    keys.append(Line2D([], [], marker="o", markerfacecolor="white", label="start", **point))
    keys.append(Line2D([], [], marker="s", label="end", **point))
    return keys


def _pieces(
    times: Floats, x: Floats, y: Floats, dashed: list[Span], dash: float
) -> tuple[list[Floats], Floats]:
    """A path in short pieces with the time of each; dashes and gaps of a set length in spans.

    The dashes are cut here, because a line of many colours starts its dashes anew in each piece.
    """
    cuts = np.unique(np.concatenate([times, *map(np.array, dashed)]))
    px, py = np.interp(cuts, times, x), np.interp(cuts, times, y)
    inside = np.zeros(len(cuts) - 1, dtype=bool)
    lines, middles = [], []
    for a, b in dashed:
        own = (cuts >= a) & (cuts <= b)
        inside |= own[:-1] & own[1:]
        run = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(px[own]), np.diff(py[own])))])
        for begin in np.arange(0.0, run[-1], 1.6 * dash):
            stop = min(begin + dash, run[-1])
            s = np.concatenate([[begin], run[(run > begin) & (run < stop)], [stop]])
            lines.append(np.column_stack([np.interp(s, run, p[own]) for p in (px, py)]))
            middles.append(float(np.interp((begin + stop) / 2, run, cuts[own])))
    points = np.column_stack([px, py])
    for i in np.flatnonzero(~inside):
        lines.append(points[i : i + 2])
        middles.append((cuts[i] + cuts[i + 1]) / 2)
    return lines, np.array(middles)


def _draw_energy(panels: list[Axes], motion: Motion) -> None:
    data, times = motion.data, motion.times
    upper, lower = panels
    first = float(data.energy.values[0])
    layers = np.stack([data[name].values for name in ENERGIES])
    fills = upper.stackplot(times, layers, colors=[c for c, _ in FILLS], labels=ENERGIES)
    for fill, (_, hatch) in zip(fills, FILLS, strict=True):
        fill.set(hatch=hatch, edgecolor="#606060", linewidth=0)
    for line in np.cumsum(layers, axis=0):
        upper.plot(times, line, color="black", linewidth=0.5)
    upper.set_ylabel(f"energy\n{_unit(data, 'energy')}")
    upper.set_ylim(0, 1.04 * float(layers.sum(axis=0).max()))
    upper.set_xlim(times[0], times[-1])
    _legend(upper)
    audit = np.abs(data.audit.values) / first
    seen = np.where(audit > 0, audit, np.nan)  # a log axis has no zero; a gap says so
    lower.set_yscale("log")
    lower.plot(times, seen, marker=".", markersize=1.2, color=STROKES[0]["color"], linewidth=0.7)
    tolerance = _tolerance(data)
    lower.axhline(tolerance, color="black", linestyle="--", linewidth=0.8)
    shown = np.append(seen[audit > 0], tolerance)
    lower.set_ylim(shown.min() / 5, shown.max() * 30)  # room for the word over the line
    lower.annotate("tolerance of a step", (0.99, tolerance), (0, 2), textcoords="offset points",
                   xycoords=("axes fraction", "data"), ha="right", fontsize=6.5)  # fmt: skip
    lower.yaxis.set_major_locator(LogLocator(numticks=6))
    lower.yaxis.set_minor_locator(NullLocator())
    lower.set_ylabel("|audit| over\ninitial energy")
    lower.set_xlabel(f"time $t$  {_unit(data, 'time')}")


def _tolerance(dataset: xarray.Dataset) -> float:
    return float(dataset.attrs.get("tolerance_used", dataset.attrs.get("tolerance", np.nan)))


def _number(data: xarray.Dataset, name: str, plain: bool) -> str:
    unit = "" if plain else f" {data[name].attrs.get('units', '')}"
    return f"{name} = {float(data[name].values[0]):.4g}{unit}"


def _given(data: xarray.Dataset, name: str, plain: bool, law: str) -> str:
    symbol, unit = GIVEN[name]
    if name == "mu" and law == "viscous":
        unit = "s/m"
    return f"{symbol} = {float(data[name]):.4g}" + (f" {unit}" if unit and not plain else "")
