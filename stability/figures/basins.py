"""The basin diagram: which launch ends where, over two numbers."""

from __future__ import annotations

from .styled_figure import checked_title, drawing, entry, fixed, halo, key, label_axes, note  # isort: skip
from .styled_figure import points, remembered, settle, small, wide, with_strips  # isort: skip

import json
from collections import Counter
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from ..base.errors import ParameterError, shown
from ..base.looks import LOOKS
from ..base.quantities import Kind, Quantity, axis_label, in_latex, readable, unit_of
from ..base.verdict import BY_CODE
from ..bodies.contact_laws import MOTION_LAWS
from ..bodies.families import FAMILIES
from ..bodies.quantities import disk_quantities, round_quantities
from ..bodies.round_body.pole_equations import TURN
from ..bodies.round_body.shape import MOMENTS, SCALES
from .fates import Fate, draw_sample, fates, is_sample, kinds, plane_of, sample_caption, told_below
from .modes import even_in_logarithm
from .shading import Strip, draw_strip, hatch

if TYPE_CHECKING:
    import xarray


LINEAR = "linear_verdict"
"""Coordinate with the verdict of the family near which launches start."""
FEW, LINE = 4, 0.17
"""Ends for whose legend there is room above the panel; room for each further one [in]."""
TIGHT = 0.7
"""Part of a panel's height that is there once legend and labels have their room."""
FINE = 600
"""Points of the strip where the places of its changes are known."""


@remembered
def plot_basins(
    dataset: xarray.Dataset,
    *,
    x: str = "",
    y: str = "",
    title: str = "",
    ax: Axes | None = None,
    width: float | None = None,
    fontsize: float | None = None,
) -> Figure:
    """Basin diagram: outcomes by colour and hatching, the final steady motion by lightness.

    Borders between outcomes are black: the refined ones where the dataset holds them, the edges of
    cells otherwise.  Dashes surround the sensitive parts of refined borders.  A strip shows the
    linear verdict of the family near which the launches start.

    A random sample has a mark for each launch instead, and fractions in the legend.

    Parameters
    ----------
    dataset
        Map from `basins`, with two axes; or a random sample.
    x, y
        Of a sample: the numbers along the axes, the first two that vary when left out; `end_time`
        is one too.
    title
        Title of the figure.
    ax
        Axes to draw on, without the strip; a figure of its own when left out.  Give their figure a
        layout (`constrained` or `tight`), which finds room for labels and scales.
    width
        Width of a figure of its own [in]; a journal column, 3.39, when left out.
    fontsize
        Size of the text [pt], 7 or more; 7.5 when left out.  The smallest text is 1 pt smaller.

    Returns
    -------
    Figure
        The parameters that the axes do not show stand below.

    Raises
    ------
    ParameterError
        If the dataset is no map of two axes and no sample, or a size or name is not accepted.

    Source: drawn from the dataset alone; each text is measured: tests/figures.

    Examples
    --------
    >>> import stability as st
    >>> found = st.basins(contact="viscous", mu=0.3, family="spinning", horizon=20.0,
    ...                   x=("at", 0.5, 3.0, 6), y=("tilt", 0.1, 0.5, 4))
    >>> round(float(st.plot_basins(found).get_figwidth()), 2)
    3.39
    """
    title = checked_title(title)
    x, y = _axes_of(dataset, x, y)
    strip = None if ax is not None else linear_strip(dataset, x)
    present = fates(dataset)
    more = LINE * max(0, len(present) - FEW)
    with drawing(
        ax, width, fontsize, lambda wide: min(0.98 * wide, 2.0 + 0.4 * wide) + more
    ) as figure:
        rows = [ax] if ax is not None else with_strips(figure, above=strip is not None)
        main = rows[-1]
        if is_sample(dataset):
            entries: list[Any] = draw_sample(main, dataset, present, x, y)
        else:
            _colour(main, dataset, present, x, y)
            draw_borders(main, dataset, kinds(dataset), x, y)
            entries = [f.patch for f in present] + draw_sensitive(main, dataset, x, y)
        label_axes(main, rows, label(dataset, x), label(dataset, y))
        _scales(figure, main, dataset, present)
        settle(figure)
        if strip is not None:
            draw_strip(rows[0], strip, Normalize(-1, 1))
        key(rows[0], entries, title)
        note(main, fixed_numbers(dataset) + told_below(dataset))
    return figure


def _axes_of(dataset: Any, x: str = "", y: str = "") -> tuple[str, str]:
    """Names of the numbers along x and y, or a refusal."""
    if not {"outcome", "family", "member"} <= set(getattr(dataset, "data_vars", ())):
        raise ParameterError(
            f"dataset is {shown(dataset)}; give what basins returns, or its store, read "
            "by read_basins."
        )
    names = tuple(map(str, dataset.outcome.dims))
    if is_sample(dataset):
        return plane_of(dataset, x, y)
    if x or y:
        raise ParameterError("x and y choose numbers of a random sample; leave them out for a map.")
    if len(names) != 2:
        raise ParameterError(
            f"dataset has the axes {', '.join(names)}; choose two, such as "
            f"dataset.isel({names[0]}=0)."
        )
    return names[1], names[0]


def linear_strip(dataset: xarray.Dataset, x: str) -> Strip | None:
    """The linear verdict along the x axis, as a strip; None where the dataset has none.

    Parameters
    ----------
    dataset
        Map from `basins`.
    x
        Name of its x axis.
    """
    if LINEAR not in dataset.coords or dataset[LINEAR].dims != (x,):
        return None
    at, codes = dataset[x].values, dataset[LINEAR].values
    attributes = dataset[LINEAR].attrs
    if "zones" in attributes:
        changes, zones = (np.atleast_1d(attributes[n]) for n in ("changes", "zones"))
        at = np.linspace(at[0], at[-1], FINE)
        codes = zones[np.searchsorted(changes, at)]
    else:
        steps = np.flatnonzero(np.diff(codes))
        changes = (at[steps] + at[steps + 1]) / 2
    shade = np.array([2 * LOOKS[BY_CODE[int(c)].word].shade - 1 for c in codes])
    return Strip("linear", at, shade, tuple(float(v) for v in changes), codes)


def _colour(axes: Axes, dataset: xarray.Dataset, present: list[Fate], x: str, y: str) -> None:
    across, along = dataset[x].values, dataset[y].values
    colours = np.ones((*dataset.outcome.shape, 3))
    for fate in present:
        colours[fate.where] = fate.shades(dataset.member.values[fate.where])
    axes.pcolormesh(across, along, colours, shading="nearest", rasterized=True)
    for values, scale, limits in (
        (across, axes.set_xscale, axes.set_xlim),
        (along, axes.set_yscale, axes.set_ylim),
    ):
        if even_in_logarithm(values):
            scale("log")
        limits(float(values[0]), float(values[-1]))
    for fate in present:
        if fate.texture:
            hatch(axes, across, along, fate.where, fate.texture)


def _scales(figure: Figure, main: Axes, dataset: xarray.Dataset, present: list[Fate]) -> None:
    """A scale of lightness for each family whose members differ, one above the other."""
    drawn = [f for f in present if f.spread]
    share = 1 / max(len(drawn), 1)
    room = TIGHT * main.get_window_extent().height * points(main) * share
    for i, fate in enumerate(drawn):
        panel = main.inset_axes((1.03, 1 - (i + 0.94) * share, 0.035, 0.88 * share))
        assert fate.members is not None
        bar = figure.colorbar(ScalarMappable(Normalize(*fate.members), fate.ramp), cax=panel)
        bar.set_label(member_label(dataset, fate.family, room), fontsize=small())
        bar.ax.tick_params(labelsize=small(), length=2)
        bar.locator = MaxNLocator(max(2, round(5 * share)), steps=[1, 2, 2.5, 5, 10])
        bar.update_ticks()
        if fate.texture and not is_sample(dataset):
            low, high = fate.members
            ends = np.array([low, high])
            hatch(bar.ax, np.array([0.0, 1.0]), ends, np.ones((2, 2), dtype=bool), fate.texture)


def basins_caption(dataset: xarray.Dataset) -> str:
    """What a basin diagram shows: launches, colours, borders, and how many end in which way.

    Parameters
    ----------
    dataset
        Map from `basins`, or a random sample, as drawn without `x` and `y`.

    Returns
    -------
    str
        Several sentences.

    Raises
    ------
    ParameterError
        If the dataset is no map of two axes and no sample.

    Examples
    --------
    >>> import stability as st
    >>> found = st.basins(contact="viscous", mu=0.3, family="spinning", horizon=20.0,
    ...                   x=("at", 2.8, 3.0, 3), y=("tilt", 0.1, 0.2, 2))
    >>> basins_caption(found).split(".  ")[0]
    'Ends of 6 launches of a disk near spinning under viscous contact, over phi_dot and tilt'
    """
    x, y = _axes_of(dataset)
    attributes, present = dataset.attrs, fates(dataset)
    body = str(attributes.get("body", ""))
    what = attributes.get("system") or f"a{'n' * body.startswith(tuple('aeiou'))} {body}"
    near = f" near {attributes['launched_near']}" if "launched_near" in attributes else ""
    law = f" under {attributes['contact']} contact" if "contact" in attributes else ""
    rest = (
        f"  Each runs until its end is proved or until {attributes['horizon']:g}, at a "
        f"tolerance of {attributes['tolerance']:g}{_check_words(attributes)}."
    )
    if is_sample(dataset):
        return sample_caption(dataset, x, y, f"{what}{near}{law}") + rest
    total = dataset.outcome.size
    ways = "; ".join(f"{f.way}: {f.label}" for f in present)
    counts = ", ".join(f"{int(f.where.sum())} {f.label}" for f in present)
    missing = total - sum(int(f.where.sum()) for f in present)
    counts += f", {missing} not computed yet (white)" * bool(missing)
    lightness = "  Lightness: the steady motion that is settled on." * any(
        f.spread for f in present
    )
    return (
        f"Ends of {total} launches of {what}{near}{law}, over {x} and {y}.  Hatching: {ways}."
        f"{lightness}  Black: {_border_words(dataset)}.{sensitive_words(dataset)}"
        f"{_strip_words(dataset, x)}  Launches: "
        f"{counts}.{rest}"
    )


def _border_words(dataset: xarray.Dataset) -> str:
    if refined(dataset):
        return "borders between ends, refined where neighbours differ"
    return "edges between cells whose launches end differently"


def _strip_words(dataset: xarray.Dataset, x: str) -> str:
    if linear_strip(dataset, x) is None:
        return ""
    return f"  Strip: {dataset[LINEAR].attrs['long_name']}, proved."


def _check_words(attributes: Mapping[str, Any]) -> str:
    return ", and once more at a looser one to estimate its error" * bool(attributes.get("checked"))


def _quantities(dataset: xarray.Dataset) -> Mapping[str, Quantity]:
    """Quantities by name; none of a user's system, whose `theta` may be anything."""
    attributes = dataset.attrs
    if "system" in attributes:
        return {}
    law = MOTION_LAWS.get(str(attributes["contact"]))
    quantities = dict(disk_quantities(law))
    body = str(attributes.get("body", "disk"))
    if body != "disk":
        numbers = {*json.loads(attributes.get("parameters", "{}")), *map(str, dataset.coords)}
        shape = numbers - set(quantities) - {*MOMENTS, *SCALES, *TURN}
        quantities |= round_quantities(body, law, sorted(shape), sorted({*numbers, *TURN}))
    return quantities | {"tilt": Quantity("tilt", "", "tilt from the steady motion", Kind.ANGLE)}


def label(dataset: xarray.Dataset, name: str) -> str:
    """A number in words, with its symbol and unit.

    Parameters
    ----------
    dataset
        What `basins` returns.
    name
        Name of a coordinate or variable.
    """
    if name == "end_time":  # its long name says what an end is
        return axis_label(
            Quantity(name, "", "time of the end", Kind.TIME), name, unit_of(dataset[name].attrs)
        )
    return axis_label(_quantities(dataset).get(name), name, unit_of(dataset[name].attrs))


def member_label(dataset: xarray.Dataset, family: str, room: float) -> str:
    """What names the members of a family, with its unit; the family alone where it is not known.

    Parameters
    ----------
    dataset
        What `basins` returns.
    family
        Name of the family, which may be followed by its place: vertical at theta = 0.
    room
        Width [pt]; a longer label is left without the family, which colour and hatching tell.
    """
    record = FAMILIES.get(family.split(" ")[0])
    if record is None or "system" in dataset.attrs:
        return family
    quantity = _quantities(dataset)[record.at[0]]
    unit = in_latex(quantity.kind.label(dimensionless=bool(dataset.attrs.get("dimensionless", 0))))
    bare = quantity.typeset + f" [{unit}]" * bool(unit)
    whole = f"{family} {bare}"
    return whole if wide(whole) <= room else bare


def fixed_numbers(dataset: xarray.Dataset) -> str:
    """The numbers that the axes do not show.

    Parameters
    ----------
    dataset
        What `basins` returns.
    """
    attributes = dataset.attrs
    held = {str(n): float(c) for n, c in dataset.coords.items() if c.ndim == 0}
    values = json.loads(attributes.get("parameters", "{}")) | held
    units = {n: unit_of(dataset[n].attrs) for n in held}
    plain = bool(attributes.get("dimensionless", 0))
    quantities = _quantities(dataset)
    law = str(attributes.get("contact", ""))
    text = fixed(values, quantities, units, law=law, dimensionless=plain)
    if str(attributes.get("body", "disk")) != "disk":
        text = f"{attributes['body']}, {text}"
    unit = unit_of(dataset.end_time.attrs)
    if quantities:
        unit = quantities["time"].kind.label(dimensionless=plain)
    # a root in mathematics would be taller than a line of the note
    last = f"$t$ = {float(attributes['horizon']):g} {readable(unit)}".removesuffix(" 1")
    near = f"launched near {attributes['launched_near']}, " if "launched_near" in attributes else ""
    return f"{near}{text}, until {last}" if text else f"{near}until {last}"


MARK = "border_sensitive"
"""Array that marks the sensitive blocks."""
LOOK: dict[str, Any] = {"color": "#a3123f", "linestyle": (0, (3.0, 1.6)), "linewidth": 1.1}
"""Dashes about sensitive parts."""
Point = tuple[float, float]


def draw_sensitive(axes: Axes, dataset: xarray.Dataset, x: str, y: str) -> list[Line2D]:
    """Draw dashes about the sensitive parts of the borders.

    Parameters
    ----------
    axes
        The panel.
    dataset
        Map from `basins` with `levels`.
    x, y
        Names of the axes.

    Returns
    -------
    list of Line2D
        The entry of the legend; empty where no part is sensitive.
    """
    marked = _marked(dataset, 1)
    if not marked.any():
        return []
    across, along = (dataset[f"border_block_{n}"].values[marked] for n in (x, y))
    lines = LineCollection(outline(across, along), zorder=4, path_effects=halo(2.2), **LOOK)
    axes.add_collection(lines, autolim=False)
    return [entry("sensitive", **LOOK)]


def _marked(dataset: xarray.Dataset, flag: int) -> np.ndarray[Any, np.dtype[np.bool_]]:
    if MARK not in dataset.variables:
        return np.zeros(0, dtype=bool)
    return np.asarray(dataset[MARK].values == flag)


def outline(across: Any, along: Any) -> list[list[Point]]:
    """The outline of a union of blocks, the sides in one line joined.

    Parameters
    ----------
    across, along
        Low and high edge of each block, shape (n, 2).

    Examples
    --------
    >>> outline(np.array([[0.0, 1.0], [1.0, 2.0]]), np.array([[0.0, 1.0], [0.0, 1.0]]))
    [[(0.0, 0.0), (0.0, 1.0)], [(2.0, 0.0), (2.0, 1.0)], \
[(0.0, 0.0), (2.0, 0.0)], [(0.0, 1.0), (2.0, 1.0)]]
    """
    lines: list[list[Point]] = []
    for way, (sides_at, free) in enumerate(((across, along), (along, across))):
        sides = Counter(
            (float(place), float(low), float(high))
            for places, (low, high) in zip(sides_at, free, strict=True)
            for place in places
        )
        lines += _joined((side for side, count in sides.items() if count == 1), turned=way == 1)
    return lines


def _joined(sides: Iterable[tuple[float, float, float]], *, turned: bool) -> list[list[Point]]:
    """Sides (place, low, high) as lines, those in one line joined; turned ones are level."""
    joined: list[list[float]] = []
    for place, low, high in sorted(sides):
        if joined and joined[-1][0] == place and joined[-1][2] == low:
            joined[-1][2] = high
        else:
            joined.append([place, low, high])
    lines = [[(place, low), (place, high)] for place, low, high in joined]
    return [[(b, a) for a, b in line] for line in lines] if turned else lines


def sensitive_words(dataset: xarray.Dataset) -> str:
    """Sentences of a caption: the sensitive parts, and the uncertainty exponent of the borders.

    Parameters
    ----------
    dataset
        Map from `basins`.

    Returns
    -------
    str
        Empty where the dataset has no refined borders, or these are too coarse for both.
    """
    marked, open_ = (_marked(dataset, flag) for flag in (1, 2))
    attributes, sentences = dataset.attrs, ""
    if marked.any():
        sentences = (
            f"  Dashes: {int(marked.sum())} of {marked.size} blocks along the borders are "
            "sensitive: there uncertainty falls more slowly than the width."
        )
    elif marked.size:
        sentences = f"  None of the {marked.size} blocks along the borders is sensitive."
    if open_.any():
        sentences += (
            f"  {int(open_.sum())} blocks are open: a strip of launches that still move lies "
            "between two ends, and a longer horizon decides."
        )
    if "border_exponent" in attributes:
        low, high = attributes["border_exponent_interval"]
        sentences += (
            f"  Uncertainty exponent of all borders: {attributes['border_exponent']:.2f} "
            f"[{low:.2f}, {high:.2f}], {100 * attributes['border_exponent_level']:g} % confidence."
        )
    return sentences


POINT = "border_point"
"""Dimension of refined borders."""
WIDTH = 0.7
"""Width of a border [pt]."""


def refined(dataset: xarray.Dataset) -> bool:
    """Whether a dataset holds refined borders."""
    return POINT in dataset.sizes and "border_curve" in dataset.variables


def draw_borders(axes: Axes, dataset: xarray.Dataset, kinds: NDArray[Any], x: str, y: str) -> None:
    """Draw the borders between fates.

    Parameters
    ----------
    axes
        The panel.
    dataset
        Map from `basins`; refined borders are drawn where it holds them.
    kinds
        A number for each fate, shape (y, x); negative where nothing is computed yet.
    x, y
        Names of the axes.
    """
    lines: Any = (
        _lines(dataset, x, y)
        if refined(dataset)
        else cell_edges(dataset[x].values, dataset[y].values, kinds)
    )
    axes.add_collection(
        LineCollection(lines, colors="black", linewidths=WIDTH, zorder=3, capstyle="round"),
        autolim=False,
    )


def _lines(dataset: xarray.Dataset, x: str, y: str) -> list[NDArray[np.float64]]:
    points = np.stack([dataset[f"border_{x}"].values, dataset[f"border_{y}"].values], axis=1)
    cuts = np.flatnonzero(np.diff(dataset.border_curve.values)) + 1
    return [line for line in np.split(points, cuts) if len(line)]


def edges_of(centres: NDArray[np.float64]) -> NDArray[np.float64]:
    """Edges of cells about their centres, as they are drawn; the ends are the outer centres.

    Examples
    --------
    >>> edges_of(np.array([0.0, 1.0, 3.0])).tolist()
    [0.0, 0.5, 2.0, 3.0]
    """
    middle = (centres[1:] + centres[:-1]) / 2
    return np.concatenate([centres[:1], middle, centres[-1:]])


def cell_edges(
    x: NDArray[np.float64], y: NDArray[np.float64], kinds: NDArray[Any]
) -> list[list[tuple[float, float]]]:
    """The edges between cells of different kinds, those in one line joined.

    Parameters
    ----------
    x, y
        Centres of the cells.
    kinds
        A number for each cell, shape (len(y), len(x)); a negative one has no edges.

    Examples
    --------
    >>> cell_edges(np.arange(3.0), np.arange(2.0), np.array([[0, 0, 1], [0, 0, 1]]))
    [[(1.5, 0.0), (1.5, 1.0)]]
    >>> cell_edges(np.arange(3.0), np.arange(2.0), np.array([[0, 0, -1], [0, 0, -1]]))
    []
    """
    across, along = edges_of(x), edges_of(y)
    lines: list[list[Point]] = []
    for way, (grid, at, free) in enumerate(((kinds, across, along), (kinds.T, along, across))):
        first, second = grid[:, :-1], grid[:, 1:]
        rows, columns = np.nonzero((first != second) & (first >= 0) & (second >= 0))
        ends = (at[columns + 1], free[rows], free[rows + 1])
        lines += _joined(zip(*(v.tolist() for v in ends), strict=True), turned=way == 1)
    return lines
