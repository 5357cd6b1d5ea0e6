"""Figures only: one motion in time and in the plane, and its energy."""

from __future__ import annotations

from .canvas import COLUMN  # isort: skip
from .styled_figure import checked_size, drawing, entry, fixed, key, remembered  # isort: skip
from .styled_figure import note, points, settle, small, spacing, wide, write  # isort: skip

import json
from collections.abc import Callable, Mapping, Sequence
from functools import partial
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

from ..base.errors import NameUnknownError, ParameterError, listed, shown
from ..base.looks import BLUE, SKY, VERMILION
from ..base.quantities import Kind, Quantity, in_latex, plain_text, readable, unit_of
from ..bodies.families import FAMILIES
from ..bodies.newton_euler import STATES
from ..bodies.quantities import QUANTITIES, SYSTEM, quantities_of
from ..motion.result import BY_CODE, Outcome
from .single_run import SingleRun, length_of, one_launch, system_states

if TYPE_CHECKING:
    import xarray


PAGE = 7.0
"""Width of a figure over two journal columns [in]."""
NARROW = 5.0
"""Width below which the parts stand one below the other [in]."""
ENERGIES = ("potential", "kinetic", "dissipated")
POSE = ("contact_x", "contact_y", "centre_x", "centre_y")
FILLS = (SKY, "#F0E442", "#a3567f")
"""Colour of each of `ENERGIES`, of three shades of grey in print."""
# the palest end of the map would be lost on white paper
TIME_MAP = ListedColormap(matplotlib.colormaps["viridis"](np.linspace(0, 0.92, 256)))
WORDS = ("inclination", "rates", "slip", "normal force")
SERIES = (
    ("theta",),
    ("theta_dot", "phi_dot", "omega3"),
    ("slip_x", "slip_y"),
    ("normal_force",),
)
"""Word and series of each panel over time, of a disk's motion."""
ENDS = {"contact": ("s", 6.0), "centre": ("o", 3.4)}
"""Shape and size of the marks at the ends of each path, hollow at the start, filled at the end."""
COUNTS = {"states": len(SERIES), "paths": 1, "energy": 2}
"""Number of axes that each part of the figure of a disk's motion takes."""


@remembered
def plot_motion(
    dataset: xarray.Dataset,
    *,
    show: str | None = None,
    series: Sequence[str] = (),
    ax: Any = None,
    width: float | None = None,
    fontsize: float | None = None,
) -> Figure:
    """States, paths and energy of one launch, on one figure or each of them alone.

    Parameters
    ----------
    dataset
        From `simulate`, one launch.  The paths are left out without a pose, and the energy
        where a system has no energy account.
    show
        `states`, `paths` or `energy` for one part; all of them when left out.
    series
        Names of what the states' part draws over time, any variables of the dataset over time;
        when left out inclination, rates, slip and normal force of a body, and every state of a
        user's system.
    ax
        Axes to draw one part on, from the top: 4 for the states of a disk, 1 for the paths, 2
        for the energy; a figure of its own when left out.
    width
        Width of a figure of its own [in]: when left out 7.0 for all parts, and a journal column,
        3.39, for one.  Below 5 the parts stand one below the other.
    fontsize
        Size of the text [pt], 7 or more; 7.5 when left out.  The smallest text is 1 pt smaller.

    Returns
    -------
    Figure
        The parameters stand below; sticking is grey, events are vertical lines with a word.

    Raises
    ------
    ParameterError
        If the dataset holds several launches or lacks a series, or an option is not accepted.

    Source: drawn from the dataset alone; each text is measured: tests/figures.

    Examples
    --------
    >>> import stability as st
    >>> run = st.simulate(st.Disk(), st.Viscous(0.3), {"theta": 1.5, "omega3": 1.2}, 9.0)
    >>> figure = st.plot_motion(run)
    >>> len(figure.axes), float(figure.get_figwidth())
    (6, 7.0)
    """
    if show not in (None, *COUNTS):
        options = ", ".join(COUNTS)
        raise ParameterError(f"show is {shown(show)}; give one of {options}, or leave it out.")
    if ax is not None and show is None:
        raise ParameterError(f"ax takes one part; give show as one of {', '.join(COUNTS)}.")
    states = system_states(dataset)
    names = _asked(dataset, series) or states
    motion = one_launch(dataset, _needed(dataset, states, show))
    parts = [show] if show else _parts(dataset, states)
    across = PAGE if len(parts) > 1 else COLUMN
    if width is not None and ax is None:
        across = checked_size("width", width, 2.0, "inches")
    stacked = across < NARROW
    usual = COLUMN if stacked or len(parts) == 1 else PAGE
    tall = sum(_heights(parts, names, stacked=stacked)) * (across / usual) ** 0.5
    draw: dict[str, Callable[[Any, SingleRun], None]] = {
        "states": partial(_draw_states, names=names),
        "paths": _draw_paths,
        "energy": _draw_energy,
    }
    with drawing(ax, width if ax is not None else across, fontsize, lambda _: tall) as figure:
        if ax is not None:
            draw[parts[0]](GivenAxes(figure, ax, parts[0]), motion)
        else:
            spacing(figure, hspace=0.02, wspace=0.03, h_pad=0.02, w_pad=0.03)
            pages = _pages(figure, _heights(parts, names, stacked=True), stacked=stacked)
            for part, page in zip(parts, pages, strict=True):
                draw[part](page, motion)
        drawn = figure.axes if ax is None else np.ravel(ax).tolist()
        lowest = next(a for a in drawn if a.get_xlabel())
        note(lowest, fixed_of(dataset))
        settle(figure)
        for axes in drawn:  # equal scales have their ticks only now, and labels next to these
            axes.apply_aspect()
    return figure


def _asked(dataset: xarray.Dataset, series: Sequence[str]) -> tuple[str, ...]:
    """The series that are asked for, which the dataset has over time."""
    if isinstance(series, str) or not isinstance(series, Sequence):
        raise ParameterError(f"series is {shown(series)}; give a list of names.")
    names = [str(n) for n, v in getattr(dataset, "data_vars", {}).items() if "time" in v.dims]
    for name in series:
        if name not in names:
            raise NameUnknownError(
                f"series names {shown(name)}; the dataset has {listed(names)} over time."
            )
    return tuple(series)


def _parts(dataset: xarray.Dataset, names: tuple[str, ...]) -> list[str]:
    """The parts that a dataset has."""
    posed = not names and all(name in dataset for name in POSE)
    energetic = not names or "audit" in dataset
    return ["states", *["paths"] * posed, *["energy"] * energetic]


def _needed(dataset: xarray.Dataset, names: tuple[str, ...], show: str | None) -> tuple[str, ...]:
    """The series that a part draws."""
    of = {
        "states": names or (*STATES, "normal_force"),
        "paths": POSE,
        "energy": (*_energies(dataset), "energy", "audit"),
    }
    if show:
        return of[show]
    return names or of["states"] + of["energy"]


def _heights(parts: list[str], names: tuple[str, ...], *, stacked: bool) -> list[float]:
    """Heights of the rows of a figure of the usual width [in]."""
    tall = {
        "states": 1.35 + min(len(names), MOST_PANELS) if names else 4.9,
        "paths": 3.4,
        "energy": 3.45,
    }
    if len(parts) == 1 or stacked:
        return [tall[part] for part in parts]
    return [max(3.45, tall["states"]) if names else 4.6 + 1.2 * (len(parts) > 2)]


def _pages(figure: Figure, heights: list[float], *, stacked: bool) -> list[Any]:
    """One part fills the figure; of several the states fill the left half, or stand on top."""
    count = len(heights)
    if count == 1:
        return [figure]
    if stacked:
        rows: Any = figure.subfigures(count, 1, height_ratios=heights)
        return list(rows)
    halves: Any = figure.subfigures(1, 2)
    left, right = halves
    return [left, *(np.ravel(right.subfigures(2, 1)).tolist() if count > 2 else [right])]


def _energies(dataset: Any) -> tuple[str, ...]:
    """Layers of the energy: those of a disk, or of a user's system."""
    return ("energy", "dissipated") if system_states(dataset) else ENERGIES


def _draw_states(page: Any, motion: SingleRun, names: tuple[str, ...]) -> None:
    """Draw the states of a disk, or those of a user's system by name, in panels over time."""
    data, times = motion.data, motion.times
    groups, labels = _groups(data, names)
    panels = np.atleast_1d(page.subplots(len(groups), 1, sharex=True))
    steady = _settled_on(data, system_states(data))
    for axes, (word, group) in zip(panels, groups, strict=True):
        for i, name in enumerate(group):
            stroke = STROKES[i % len(STROKES)]
            axes.plot(times, data[name].values, label=labels[name], **stroke)
        for name in group if not names or len(group) == 1 else ():
            if name in steady:
                axes.axhline(
                    steady[name], label="steady", color="black", linestyle=":", linewidth=1.0
                )
        symbol = labels[group[0]] if len(group) == 1 and not names else ""
        lines = [word, f"{symbol} {unit(data, group[0])}".strip()]
        axes.set_ylabel("\n".join(line for line in lines if line))
        axes.yaxis.set_major_locator(MaxNLocator(5))
        for start, stop in motion.sticking:
            axes.axvspan(start, stop, zorder=0, **STUCK)
        for t, _ in motion.events:
            axes.axvline(t, color=GREY, linewidth=0.5, zorder=1)
        _fade(axes, motion)
        if len(axes.get_legend_handles_labels()[0]) > 1:
            legend(axes)
    if not names:
        _mark_upright(panels[0])
        panels[3].axhline(0, color=GREY, linewidth=0.7, zorder=1)
    words(panels[0], motion)
    faded = (motion.times[-1] - motion.trusted) / (motion.times[-1] - motion.times[0])
    room = faded * panels[-1].get_window_extent().width * points(panels[-1])
    if wide(UNKNOWN) < room:
        middle, across = (motion.trusted + motion.times[-1]) / 2, panels[-1].get_xaxis_transform()
        write(panels[-1], middle, 0.5, UNKNOWN, edge=2.0, transform=across, zorder=5)
    panels[-1].set_xlim(times[0], times[-1])
    time = "time" if names else "time $t$"
    panels[-1].set_xlabel(f"{time}  {unit(data, 'time')}")
    page.align_ylabels()


def _fade(axes: Axes, motion: SingleRun) -> None:
    """Veil a panel over time where the motion is not known."""
    if motion.trusted < motion.times[-1]:
        axes.axvspan(motion.trusted, motion.times[-1], zorder=2.6, **VEIL)


def _groups(
    data: xarray.Dataset, names: tuple[str, ...]
) -> tuple[list[tuple[str, tuple[str, ...]]], dict[str, str]]:
    """Word and series of each panel, and the label of each series.

    Many states of a user's system share panels by unit.  A state whose unit comes after the first
    `MOST_PANELS` units is not drawn.
    """
    if not names:
        labels = {name: QUANTITIES[name].typeset for group in SERIES for name in group}
        return list(zip(WORDS, SERIES, strict=True)), labels
    groups: list[tuple[str, ...]] = [(name,) for name in names]
    if len(names) > MOST_PANELS:
        units = list(dict.fromkeys(unit(data, n) for n in names))[:MOST_PANELS]
        groups = [tuple(n for n in names if unit(data, n) == u) for u in units]
    plain = {name: name.replace("$", r"\$") for name in names}
    titles = [plain[g[0]].replace("_", " ") if len(g) == 1 else "" for g in groups]
    return list(zip(titles, groups, strict=True)), plain


def _mark_upright(axes: Axes) -> None:
    """Draw a line at π/2, and keep the axis from shrinking to rounding errors."""
    axes.axhline(np.pi / 2, color=GREY, linestyle="--", linewidth=0.7, zorder=1)
    axes.annotate(
        r"$\pi/2$",
        (1.01, np.pi / 2),
        xycoords=("axes fraction", "data"),
        va="center",
        fontsize=small(),
        annotation_clip=False,
    )
    low, high = axes.get_ylim()
    axes.set_ylim(min(low, high - 0.02), max(high, low + 0.02))
    axes.ticklabel_format(useOffset=False)


def _settled_on(data: xarray.Dataset, names: tuple[str, ...]) -> dict[str, float]:
    """The steady motion on which a run settled, by name of state; empty for another outcome."""
    if BY_CODE[int(data.outcome)] is not Outcome.SETTLED:
        return {}
    if names:
        member = data.nearest_member.values if "nearest_member" in data else ()
        return dict(zip(names, map(float, member), strict=False))
    family = FAMILIES.get(str(data.nearest_family.values)) if "nearest_at" in data else None
    if family is None:  # a file from elsewhere may name an unknown family
        return {}
    rate = np.sqrt(float(data.gravity) / length_of(data))
    turned = np.copysign(rate, data.phi_dot.values[-1])
    states = family.member(np, float(data.nearest_at), float(data.k), turned)
    shown = [*family.at, *(family.disk_unknown if family.solution else ())]
    return {name: float(states[name]) for name in shown}


def _draw_paths(page: Any, motion: SingleRun) -> None:
    data, times, axes = motion.data, motion.times, page.subplots()
    shade: dict[str, Any] = {"cmap": TIME_MAP, "norm": Normalize(times[0], times[-1])}
    for name, width in (("contact", 1.8), ("centre", 0.8)):
        x, y = data[f"{name}_x"].values, data[f"{name}_y"].values
        corners = np.column_stack([x, y])
        # each piece overlaps the next, so that no seams show
        pieces = [corners[i : i + 3] for i in range(len(x) - 1)]
        middle = (times[1:] + times[:-1]) / 2
        axes.add_collection(
            LineCollection(
                pieces,
                array=middle,
                **shade,
                alpha=np.where(middle > motion.trusted, 1 - VEIL["alpha"], 1.0),
                linewidths=width,
                rasterized=len(x) > 20_000,
                zorder=2 if width > 1 else 3,
            )
        )
        shape, size = ENDS[name]
        for at, filled in ((0, False), (-1, True)):
            # a white edge keeps one filled mark visible on another
            axes.plot(
                x[at],
                y[at],
                shape,
                color="black",
                markersize=size + 0.6 * (not filled),
                markerfacecolor="black" if filled else "none",
                markeredgewidth=0.8,
                markeredgecolor="white" if filled else "black",
                zorder=4,
            )
    for a, b in motion.sticking:
        # white gaps over the colours, since a line of many colours cannot be dashed
        when = np.union1d([a, b], times[(times > a) & (times < b)])
        x, y = (np.interp(when, times, data[f"contact_{c}"].values) for c in "xy")
        axes.plot(
            x,
            y,
            color="white",
            linewidth=2.4,
            dashes=(0.7, 1.3),
            dash_capstyle="butt",
            label="gaps",
            zorder=2.5,
        )
    # for a disk that spins on the spot the axes must not shrink to rounding errors
    spot = 0.02 * length_of(data) * np.array([[-1, -1], [1, 1]])
    axes.update_datalim([data.centre_x.values[0], data.centre_y.values[0]] + spot)
    axes.set_aspect("equal", adjustable="datalim")
    axes.autoscale_view()
    for axis, letter in ((axes.xaxis, "X"), (axes.yaxis, "Y")):
        axis.set_major_locator(MaxNLocator(4 if letter == "X" else 5))
        axis.set_label_text(f"${letter}$  {unit(data, 'centre_x')}")
    axes.ticklabel_format(useOffset=False)
    key(axes, _keys(bool(motion.sticking), "first sample" if motion.times[0] else "start"))
    bar = page.colorbar(ScalarMappable(**shade), ax=axes, pad=0.02, aspect=30, fraction=0.05)
    bar.set_label(f"time $t$  {unit(data, 'time')}")


def _keys(sticks: bool, first: str) -> list[Any]:
    """Entries of the legend: each path with the mark of its end, and what is hollow."""
    (square, large), (ring, little) = ENDS["contact"], ENDS["centre"]
    path: dict[str, Any] = {"linewidth": 1.8, "color": "#303030"}
    ends: dict[str, Any] = {"marker": square, "markersize": large, "markevery": [1]}
    centre = path | {"marker": ring, "markersize": little, "markevery": [1], "linewidth": 0.8}
    alone: dict[str, Any] = {"ls": "", "marker": square, "markersize": large, "color": "black"}
    name = "contact, sliding" if sticks else "contact point"
    stuck = [entry("contact, sticking", dashes=(1.7, 1), **path)] if sticks else []
    return [
        entry(name, **path, **ends),
        *stuck,
        entry("centre", **centre),
        entry(f"{first} (hollow)", markerfacecolor="none", **alone),
        entry("end (filled)", **alone),
    ]


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
    for panel in (upper, lower):
        _fade(panel, motion)
    audit = np.abs(data.audit.values) / first
    seen = np.where(audit > 0, audit, np.nan)  # a log axis has no zero, so leave a gap
    lower.set_yscale("log")
    lower.set_autoscaley_on(False)  # an audit of zeros alone has no range
    lower.plot(
        times,
        seen,
        label="audit",
        marker=".",
        markersize=1.2,
        linewidth=0.7,
        color=STROKES[0]["color"],
    )
    tolerance = tolerance_of(data)
    lower.axhline(
        tolerance, label="tolerance of a step", color="black", linestyle="--", linewidth=0.8
    )
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
    upper.stackplot(times, layers, colors=FILLS, labels=ENERGIES)
    for line in np.cumsum(layers, axis=0):
        upper.plot(times, line, color="black", linewidth=0.3)
    upper.set_ylim(0, 1.04 * float(layers.sum(axis=0).max()))


# distinct in every common colour vision; in grey, by the dashes
STROKES: tuple[dict[str, Any], ...] = (
    {"color": BLUE, "linestyle": "-", "linewidth": 1.0},
    {"color": VERMILION, "linestyle": (0, (4, 1.4)), "linewidth": 1.0},
    {"color": "#000000", "linestyle": (0, (4, 1.2, 1, 1.2)), "linewidth": 0.9},
)
GREY = "#404040"
"""Colour of lines across a panel."""
STUCK: dict[str, Any] = {"facecolor": "#d8d8d8", "edgecolor": "none"}
"""Look of a span of sticking."""
VEIL: dict[str, Any] = {"facecolor": "white", "edgecolor": "none", "alpha": 0.75}
"""What lies over a motion that is not known."""
UNKNOWN = "faded: not known"
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
            across = axes.get_xaxis_transform()
            write(axes, t, 1.03, word, rotation=90, va="bottom", transform=across)


def lines_of_energy(axes: Axes, motion: SingleRun) -> None:
    """Draw energy, dissipated energy and their constant sum as lines.

    Stacked layers would be wrong, since a user's energy may be negative.
    """
    data = motion.data
    lines = {"energy": data.energy.values, "dissipated": data.dissipated.values}
    lines["sum"] = lines["energy"] + lines["dissipated"]
    for (name, values), stroke in zip(lines.items(), STROKES, strict=True):
        axes.plot(motion.times, values, label=name, **stroke)


def caption(dataset: xarray.Dataset) -> str:
    """The computation and its outcome, in two sentences.

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
        If the dataset holds several launches or lacks a series.

    Examples
    --------
    >>> import stability as st
    >>> run = st.simulate(st.Disk(), st.Smooth(), {"theta": 1.0}, 5.0)
    >>> caption(run).split("  ")[1].split(",")[0]
    'Outcome: flat'
    """
    names = system_states(dataset)
    needed = ("outcome", "evidence", "end_time", "method")
    motion = one_launch(dataset, (*(names or STATES), *needed, *["energy_error"] * (not names)))
    data, plain = motion.data, bool(dataset.attrs.get("dimensionless", 0))
    start = ", ".join(_number(data, name, bare=plain and not names) for name in names or STATES)
    audit = ""
    if "energy_error" in data:
        whole = "energy" if names else "initial energy"
        audit = f"; the energy audit closes to {float(data.energy_error):.1g} of the {whole}"
    if names:
        held = ", ".join(_number(data, n) for n in json.loads(data.attrs.get("parameters", "{}")))
        moving = f"{data.attrs['system']}{f' ({held})' if held else ''}"
        second = "" if (word := data.time.attrs["units"]) == "1" else f" {word}"
    else:
        numbers = [
            f"{q.symbol} = {float(data[name]):.4g}{'' if plain else q.kind.suffix}"
            f"{f' ({q.formula})' if q.formula else ''}"
            for name, q in _quantities(dataset).items()
            if name in data.coords and not data[name].ndim
        ]
        numbers += [
            f"{words} {name} = {value:.4g}{'' if word == '1' else f' {word}'}"
            for name, (words, value, word) in _resistances(data).items()
        ]
        numbers += ["dimensionless"] * plain
        law = str(dataset.attrs.get("contact", ""))
        moving = f"{_body_of(dataset)} with {law} contact ({', '.join(numbers)})"
        second = f" {Kind.TIME.label(dimensionless=plain)}"
    return (
        f"Motion of {moving} from {start} at time {motion.times[0]:.4g} to "
        f"{motion.times[-1]:.4g}{second}, by {data.method.item()} at tolerance "
        f"{tolerance_of(dataset):.3g}{audit}.  Outcome: {BY_CODE[int(data.outcome)].word}, at "
        f"time {float(data.end_time):.4g}{second} ({data.evidence.item()}).{_faded(motion, second)}"
    )


def _faded(motion: SingleRun, second: str) -> str:
    """A sentence on the part that is drawn pale."""
    if not motion.trusted < motion.times[-1]:
        return ""
    return f"  Faded after {motion.trusted:.4g}{second}: runs within the tolerance part there."


def _number(data: xarray.Dataset, name: str, *, bare: bool = False) -> str:
    """A parameter, or a state at the first sample, with its unit."""
    word = "1" if bare else str(data[name].attrs.get("units", "1"))
    number = f"{name} = {float(data[name].values.flat[0]):.4g}"
    return number if word == "1" else f"{number} {readable(word)}"


def _body_of(dataset: xarray.Dataset) -> str:
    name = str(dataset.attrs.get("body", "disk"))
    return f"{'an' if name[0] in 'aeiou' else 'a'} {name}"


def _quantities(dataset: xarray.Dataset) -> Mapping[str, Quantity]:
    """The quantities of a motion; those that a body adds to the disk's are named as it names them.

    The number of a launch is none of them.
    """
    quantities = quantities_of(SYSTEM + str(dataset.attrs.get("contact", "")))
    if "body" not in dataset.attrs:
        return quantities
    added = {
        str(n): Quantity(str(n), str(n), str(n), Kind.NUMBER)
        for n in dataset.coords
        if n not in quantities and n not in ("time", "number", "length", *_resistances(dataset))
    }
    if not dataset.attrs.get("dimensionless", 0):
        added |= {"length": Quantity("length", "L", "length", Kind.LENGTH)}
    return added | dict(quantities)


def tolerance_of(dataset: xarray.Dataset) -> float:
    """The tolerance that the integrator was given."""
    return float(dataset.attrs.get("tolerance_used", dataset.attrs.get("tolerance", np.nan)))


def fixed_of(dataset: xarray.Dataset) -> str:
    """The parameters of a motion, for the note of its figure."""
    if system_states(dataset):
        names = json.loads(dataset.attrs.get("parameters", "{}"))
        values = {n: dataset[n].values.flat[0] for n in names if n in dataset}
        return fixed(values, {}, {n: str(dataset[n].attrs.get("units", "1")) for n in values})
    law = str(dataset.attrs.get("contact", ""))
    quantities = _quantities(dataset)
    values = {
        n: dataset[n].item() for n in quantities if n in dataset.coords and not dataset[n].ndim
    }
    values.pop("time", None)
    plain = bool(dataset.attrs.get("dimensionless", 0))
    lines = [fixed(values, quantities, {}, law=law, dimensionless=plain)]
    for name, (words, value, unit) in _resistances(dataset).items():
        shown_unit = "" if unit == "1" else f" {in_latex(unit)}"
        lines.append(f"{words} {GREEK.get(name, plain_text(name))} = {value:.5g}{shown_unit}")
    return ", ".join(lines)


GREEK = {"rho": r"$\rho$", "sigma": r"$\sigma$", "drag": "$d$"}
"""Symbols of the coefficients of the package's resistances."""


def _resistances(dataset: xarray.Dataset) -> dict[str, tuple[str, float, str]]:
    """Name in words, value and unit of each resistance, by its coefficient."""
    return {
        str(name): (str(at.attrs["long_name"]), float(at), str(at.attrs.get("units", "1")))
        for name, at in dataset.coords.items()
        if name not in ("time", "number") and not at.ndim and "long_name" in at.attrs
    }
