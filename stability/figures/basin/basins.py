"""The basin diagram: which launch ends where, over two numbers."""

from __future__ import annotations

from ..styled_figure import drawing, key, note, settle, small, ticks_along  # isort: skip

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from ...base.errors import ParameterError
from ...base.verdict import BY_CODE
from ..shading import Strip, draw_strip, hatch
from .edges import draw_borders, refined
from .fates import Fate, fates, kinds
from .labels import even_ratios, fixed_numbers, label, member_label
from .sample import draw_sample, is_sample, plane_of, sample_caption, told_below
from .sensitive import draw_sensitive, sensitive_words

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
SHADE = {"stable": -0.35, "unstable": 0.5}
"""Place of a verdict on the scale of growth rates, -1 to 1."""


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
    x, y = _axes_of(dataset, x, y)
    strip = None if ax is not None else linear_strip(dataset, x)
    present = fates(dataset)
    more = LINE * max(0, len(present) - FEW)
    with drawing(
        ax, width, fontsize, lambda wide: min(0.98 * wide, 2.0 + 0.4 * wide) + more
    ) as figure:
        above, main = (None, ax) if ax is not None else _panels(figure, strip)
        if is_sample(dataset):
            entries: list[Any] = draw_sample(main, dataset, present, x, y)
        else:
            _colour(main, dataset, present, x, y)
            draw_borders(main, dataset, kinds(dataset), x, y)
            entries = [f.patch for f in present] + draw_sensitive(main, dataset, x, y)
        _labels(main, above, dataset, x, y)
        _scales(figure, main, dataset, present)
        settle(figure)
        if strip is not None and above is not None:
            draw_strip(above, strip, Normalize(-1, 1))
        key(main if above is None else above, entries, title)
        note(main, fixed_numbers(dataset) + told_below(dataset))
    return figure


def _axes_of(dataset: Any, x: str = "", y: str = "") -> tuple[str, str]:
    """Names of the numbers along x and y, or a refusal."""
    if not {"outcome", "family", "member"} <= set(getattr(dataset, "data_vars", ())):
        raise ParameterError(
            f"dataset is {type(dataset).__name__}; give what basins returns, or its store, read "
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


def _panels(figure: Figure, strip: Strip | None) -> tuple[Axes | None, Axes]:
    if strip is None:
        return None, figure.subplots()
    above, main = figure.subplots(
        2, 1, sharex=True, gridspec_kw={"height_ratios": [0.075, 1.0], "hspace": 0.05}
    )
    return above, main


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
    told = dataset[LINEAR].attrs
    if "zones" in told:
        changes, zones = (np.atleast_1d(told[n]) for n in ("changes", "zones"))
        at = np.linspace(at[0], at[-1], FINE)
        codes = zones[np.searchsorted(changes, at)]
    else:
        steps = np.flatnonzero(np.diff(codes))
        changes = (at[steps] + at[steps + 1]) / 2
    shade = np.array([SHADE.get(BY_CODE[int(c)].word, 0.0) for c in codes])
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
        if even_ratios(values):
            scale("log")
        limits(float(values[0]), float(values[-1]))
    for fate in present:
        if fate.texture:
            hatch(axes, across, along, fate.where, fate.texture)


def _labels(main: Axes, above: Axes | None, dataset: xarray.Dataset, x: str, y: str) -> None:
    main.set_xlabel(label(dataset, x))
    main.set_ylabel(label(dataset, y))
    if main.get_xscale() != "log":
        main.xaxis.set_major_locator(ticks_along(main))
    if above is not None:
        above.tick_params(axis="x", labelbottom=False)


def _scales(figure: Figure, main: Axes, dataset: xarray.Dataset, present: list[Fate]) -> None:
    """A scale of lightness for each family whose members differ, one above the other."""
    shown = [f for f in present if f.spread]
    share = 1 / max(len(shown), 1)
    room = TIGHT * main.get_window_extent().height * 72 / figure.dpi * share
    for i, fate in enumerate(shown):
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
    told, present = dataset.attrs, fates(dataset)
    body = str(told.get("body", ""))
    what = told.get("system") or f"a{'n' * body.startswith(tuple('aeiou'))} {body}"
    near = f" near {told['launched_near']}" if "launched_near" in told else ""
    law = f" under {told['contact']} contact" if "contact" in told else ""
    rest = (
        f"  Each runs until its end is proved or until {told['horizon']:g}, at a "
        f"tolerance of {told['tolerance']:g}{_check_words(told)}."
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


def _check_words(told: Mapping[str, Any]) -> str:
    return ", and once more at a looser one to estimate its error" * bool(told.get("checked"))
