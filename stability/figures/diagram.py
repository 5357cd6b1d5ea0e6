"""Figures only: stability diagrams, drawn from datasets."""

from __future__ import annotations

from .styled_figure import checked_title, drawing, fixed, halo, key, label_axes, note, points  # isort: skip
from .styled_figure import remembered, settle, small, with_strips, write  # isort: skip

import json
import re
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from matplotlib.textpath import TextPath
from numpy.typing import NDArray

from ..base.checks import positive
from ..base.errors import ParameterError, shown
from ..base.looks import LOOKS, YELLOW
from ..base.quantities import Quantity, axis_label, in_latex, read, unit_of
from ..base.verdict import CODES, NO_MEMBER, Verdict
from ..bodies.quantities import quantities_of
from ..boundary.brackets import Crossing
from ..boundary.curves import KINDS
from ..boundary.two_parameters.point_records import CodimensionTwo, PointKind
from ..maps.dataset import points_of
from ..spectra.result import Spectrum
from .shading import (
    DIVERGING,
    colour_bar,
    draw_strip,
    linear_part,
    norm_of,
    paint_verdicts,
    patch,
)
from .shading import Strip as Strip

if TYPE_CHECKING:
    import xarray


STRIP = 1.2
"""Least width of the strip that encloses the boundary of a certified map [pt]."""
LINES = {
    Crossing.STATIC: "-",
    Crossing.FLUTTER: (0, (4, 1.6)),
    Crossing.TOUCHING: ":",
    Crossing.STATIC_AND_FLUTTER: "-",
}


@remembered
def plot_map(
    dataset: xarray.Dataset,
    *,
    above: Strip | None = None,
    below: Strip | None = None,
    points: CodimensionTwo | None = None,
    scale: tuple[float, float] | None = None,
    unstable: bool = False,
    title: str = "",
    ax: Axes | None = None,
    width: float | None = None,
    fontsize: float | None = None,
) -> Figure:
    """Stability diagram of a map: abscissa in colour, exact boundary curves, limits next to it.

    Parameters
    ----------
    dataset
        Map from `stability_map` or `read_map`.
    above, below
        Limit laws at the upper and the lower end of the y axis, or None.
    points
        Points to mark, from `codimension_two` with the axes of the map; those that the map holds
        when left out.
    scale
        Growth rate up to which the colours are linear, and the largest one, in the unit of the
        map: figures with one scale can be compared.  Those of this map when left out.
    unstable
        Whether regions are named by their numbers of unstable eigenvalues, with thin lines between
        them; for a map that has these numbers.
    title
        Title of the figure.
    ax
        Axes to draw on, without strips; a figure of its own when left out.  Give their figure a
        layout (`constrained` or `tight`), which finds room for labels and the colour bar.
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
        If a size is not accepted, or strips are given with axes.

    Source: drawn from the dataset alone; each text is measured: tests/figures.

    Examples
    --------
    >>> import stability as st
    >>> m = st.stability_map("spinning", x=("at", 1, 4, 9), y=("mu", 0.1, 2, 9))
    >>> figure = st.plot_map(m)
    >>> round(float(figure.get_figwidth()), 2)
    3.39
    """
    title = checked_title(title)
    if not {"abscissa", "verdict"} <= set(getattr(dataset, "data_vars", ())) or (
        dataset.abscissa.ndim != 2
    ):
        what = "a spectrum" if isinstance(dataset, Spectrum) else shown(dataset)
        raise ParameterError(
            f"dataset is {what}; give what stability_map or read_map returns (plot_locus draws a "
            "spectrum)."
        )
    if scale is not None and not 0 < positive("scale", scale[0]) < positive("scale", scale[1]):
        raise ParameterError(f"scale is {shown(scale)}; give the linear part, then the largest.")
    if unstable and "unstable" not in dataset:
        raise ParameterError(
            "the map has no numbers of unstable eigenvalues; ask stability_map with unstable=True."
        )
    if ax is not None and (above or below):
        raise ParameterError("above and below need a figure of their own; leave out ax.")
    with drawing(ax, width, fontsize, lambda wide: min(0.98 * wide, 2.05 + 0.38 * wide)) as figure:
        strips_at = {"above": above is not None, "below": below is not None}
        rows = [ax] if ax is not None else with_strips(figure, **strips_at)
        main = rows[1 if above else 0]
        mesh = _colour(main, dataset, norm_of(*(scale or colour_scale(dataset))))
        across = dataset[_x(dataset)]
        main.set_xlim(float(across[0]), float(across[-1]))
        label_axes(main, rows, *(_label(dataset, n) for n in (_x(dataset), _y(dataset))))
        strips = [(s, p) for s, p in ((above, rows[0]), (below, rows[-1])) if s is not None]
        _bar(figure, rows, mesh, dataset, [s for s, _ in strips])
        marked = points_of(dataset) if points is None else points
        if marked is not None:
            _mark_points(main, marked, (_x(dataset), _y(dataset)))
        _curves(main, dataset)
        settle(figure)
        nameless = {v for s, p in strips for v in draw_strip(p, s, mesh.norm)}
        if unstable:
            _draw_numbers(main, dataset)
        named = set() if unstable else _verdict_names(main, dataset)
        nameless = (nameless | _present(dataset.verdict.values)) - named
        key(rows[0], _handles(main, dataset, nameless), title)
        how = str(dataset.attrs.get("evidence", "")).partition(":")[0]
        note(rows[-1], "; ".join(filter(None, [_fixed(dataset), how])))
    return figure


def _bar(
    figure: Figure, rows: list[Axes], mesh: Any, dataset: xarray.Dataset, strips: list[Strip]
) -> None:
    unit = unit_of(dataset.abscissa.attrs)
    shown = "" if unit == "1" else f"  [{in_latex(unit)}]"
    codes = [dataset.verdict.values, *(s.codes for s in strips)]
    unstable = any((c == CODES[Verdict.UNSTABLE]).any() for c in codes)
    label = r"largest growth rate max Re $\lambda$" + shown
    colour_bar(figure, mesh, rows, label, hatched=unstable)


def _fixed(dataset: xarray.Dataset) -> str:
    """The parameters that the axes do not show."""
    attributes, quantities = dataset.attrs, _quantities(dataset)
    at = {"at": str(attributes["at"])} if attributes.get("contact") else {}
    values, units = (json.loads(attributes.get(n, "{}")) for n in ("parameters", "parameter_units"))
    return fixed(
        {at.get(n, n): v for n, v in values.items()},
        quantities,
        units,
        law=str(attributes.get("contact", _body(dataset))),
        dimensionless=bool(attributes.get("dimensionless", 0)),
    )


def _body(dataset: xarray.Dataset) -> str:
    """Body and law of a map; empty for the disk's, which names its law, and for a user's."""
    return str(dataset.attrs["system"]) if "quantities" in dataset.attrs else ""


def _x(dataset: xarray.Dataset) -> str:
    return str(dataset.abscissa.dims[1])


def _y(dataset: xarray.Dataset) -> str:
    return str(dataset.abscissa.dims[0])


def _is_log(dataset: xarray.Dataset, name: str) -> bool:
    # a name may hold a space, as the entries are parted by one
    entry = rf"(^| ){re.escape(name)}:[^: ]+:[^: ]+:\d+:log( |$)"
    return re.search(entry, str(dataset.attrs.get("axes", ""))) is not None


def colour_scale(*datasets: xarray.Dataset) -> tuple[float, float]:
    """The scale of the colours of maps that are compared, for `plot_map`.

    Parameters
    ----------
    *datasets
        Maps from `stability_map`.

    Returns
    -------
    tuple of float
        Growth rate up to which the colours are linear, and the largest one.

    Examples
    --------
    >>> import stability as st
    >>> m = st.stability_map("spinning", x=("at", 1, 4, 9), y=("mu", 0.1, 2, 9))
    >>> linear, largest = colour_scale(m)
    >>> linear, largest == float(abs(m.abscissa).max())
    (0.0001, True)
    """
    rates = [d.abscissa.values[d.verdict.values != NO_MEMBER] for d in datasets]
    return linear_part(np.concatenate(rates))


def _colour(axes: Axes, dataset: xarray.Dataset, norm: Any) -> Any:
    x, y, values = dataset[_x(dataset)], dataset[_y(dataset)], dataset.abscissa.values
    missing = dataset.verdict.values == NO_MEMBER
    mesh = axes.pcolormesh(
        x,
        y,
        np.ma.masked_where(missing, values),
        cmap=DIVERGING,
        norm=norm,
        shading="nearest",
        rasterized=True,
    )
    for name, scale in ((_x(dataset), axes.set_xscale), (_y(dataset), axes.set_yscale)):
        if _is_log(dataset, name):
            scale("log")
    paint_verdicts(axes, x.values, y.values, dataset.verdict.values)
    if missing.any():  # left blank within a thin line, so that white is not taken for a colour
        axes.contour(x, y, missing.astype(float), levels=[0.5], colors="#777777", linewidths=0.6)
        axes.set_facecolor("white")
    axes.set_ylim(float(y[0]), float(y[-1]))
    if "box_verdict" in dataset:
        _boxes(axes, dataset)
    return mesh


def _boxes(axes: Axes, dataset: xarray.Dataset) -> None:
    """Outlines of the proved boxes in white, and the strip that encloses the boundary, filled.

    White is no colour of the hatching.  The strip is drawn at least as wide as `STRIP`.
    """
    ends = [dataset[f"box_{name}"].values for name in (_x(dataset), _y(dataset))]
    (x0, x1), (y0, y1) = (e.T for e in ends)
    corners = np.stack([np.stack([x0, x1, x1, x0], 1), np.stack([y0, y0, y1, y1], 1)], axis=-1)
    strip = dataset.box_verdict.values == CODES[Verdict.UNDECIDED]
    inside, edge = _undecided_box()
    dark: dict[str, Any] = {"facecolors": inside, "edgecolors": edge, "linewidths": STRIP + 0.8}
    looks: tuple[dict[str, Any], ...] = (
        {"facecolors": "none", "edgecolors": "white", "linewidths": 0.4},
        dark,
        dark | {"edgecolors": inside, "linewidths": STRIP},
    )
    for where, look, z in zip((~strip, strip, strip), looks, (2.0, 2.1, 2.2), strict=True):
        axes.add_collection(PolyCollection(corners[where], zorder=z, **look), autolim=False)


def _undecided_box() -> tuple[str, str]:
    """Colours of the inside and the edge of a box in which nothing is proved."""
    return LOOKS[Verdict.UNDECIDED.word].fill or ("none", "black")


def _curves(axes: Axes, dataset: xarray.Dataset) -> None:
    if "boundary_curve" not in dataset or not dataset.sizes["boundary_point"]:
        return
    x = dataset[f"boundary_{_x(dataset)}"].values
    y = dataset[f"boundary_{_y(dataset)}"].values
    kind, curve = dataset.boundary_kind.values, dataset.boundary_curve.values
    by_code = {code: crossing for crossing, code in KINDS.items()}
    seen: set[Crossing] = set()
    # on a certified map the line is thin, so that the strip shows on both its sides
    boxed = "box_verdict" in dataset
    edge = [] if boxed else halo(2.6)
    kind = _without_single_points(kind, curve)
    for start, stop in _runs(kind, curve):
        crossing = by_code[int(kind[start])]
        last = min(stop + 1, len(x)) if stop < len(x) and curve[stop] == curve[start] else stop
        label = {Crossing.STATIC: "static", Crossing.FLUTTER: "flutter"}.get(crossing, "touching")
        axes.plot(
            x[start:last],
            y[start:last],
            color="black",
            linestyle=LINES[crossing],
            label=None if crossing in seen else f"{label} boundary",
            path_effects=edge,
            solid_capstyle="butt",
            linewidth=0.5 if boxed else 1.3,
            zorder=3,
        )
        seen.add(crossing)


def _handles(axes: Axes, dataset: xarray.Dataset, nameless: set[Verdict]) -> list[Any]:
    """Entries of the legend: boundaries, points, boxes, and verdicts whose region has no word."""
    handles, _ = axes.get_legend_handles_labels()
    if "box_verdict" in dataset:
        inside, edge = _undecided_box()
        handles.append(
            Patch(facecolor=inside, edgecolor=edge, linewidth=0.4, label="strip that encloses it")
        )
        handles.append(
            Patch(facecolor=DIVERGING(0.2), edgecolor="white", linewidth=0.8, label="proved box")
        )
    return handles + [patch(v) for v in Verdict if v in nameless]


def _without_single_points(kind: NDArray[Any], curve: NDArray[Any]) -> NDArray[Any]:
    """Kinds of points; a single one, such as the static end of flutter, has its neighbour's."""
    kinds, runs = kind.copy(), _runs(kind, curve)
    long = {i for start, stop in runs if stop > start + 1 for i in range(start, stop)}
    for start, stop in runs:
        near = [i for i in (stop, start - 1) if i in long and curve[i] == curve[start]]
        if stop == start + 1 and near:
            kinds[start] = kind[near[0]]
    return kinds


def _runs(kind: NDArray[Any], curve: NDArray[Any]) -> list[tuple[int, int]]:
    """Index ranges (start, stop) of one polyline along which the crossing has one kind."""
    cuts = np.flatnonzero((np.diff(kind) != 0) | (np.diff(curve) != 0)) + 1
    ends = [0, *cuts.tolist(), len(kind)]
    return list(zip(ends[:-1], ends[1:], strict=True))


def _label(dataset: xarray.Dataset, name: str) -> str:
    attributes = dataset[name].attrs
    quantity = attributes.get("quantity", name)
    return axis_label(_quantities(dataset).get(quantity), quantity, unit_of(attributes))


def _quantities(dataset: xarray.Dataset) -> Mapping[str, Quantity]:
    """The quantities of the disk or of a body; none of a user's map."""
    if "quantities" in dataset.attrs:
        return read(str(dataset.attrs["quantities"]))
    if not dataset.attrs.get("contact"):
        return {}
    return quantities_of(str(dataset.attrs.get("system", "")))


def _draw_numbers(axes: Axes, dataset: xarray.Dataset) -> None:
    """Numbers of unstable eigenvalues in their regions, and lines between those that have some."""
    counts = dataset.unstable.values
    levels = np.arange(1.5, counts.max())
    if levels.size:
        across, up = dataset[_x(dataset)], dataset[_y(dataset)]
        some = np.ma.masked_less(counts, 1)
        axes.contour(across, up, some, levels=levels, colors="#333333", linewidths=0.5)
        axes.plot([], [], color="#333333", linewidth=0.5, label="unstable eigenvalues")
    numbers = {n: str(n) for n in np.unique(counts[counts >= 0]).tolist()}
    _region_names(axes, dataset, counts, numbers)


def _verdict_names(axes: Axes, dataset: xarray.Dataset) -> set[Verdict]:
    """Write each verdict into its region; those that are written."""
    names = {code: v.word for v, code in CODES.items()} | {NO_MEMBER: LOOKS["absent"].word}
    named = _region_names(axes, dataset, dataset.verdict.values, names)
    return {v for v in Verdict if v.word in named}


def _region_names(
    axes: Axes, dataset: xarray.Dataset, codes: NDArray[Any], names: Mapping[int, str]
) -> set[str]:
    """Write the word of each code into its region, far from its edge; those that are written."""
    from scipy.ndimage import distance_transform_edt

    named = set()
    for code, word in names.items():
        where = codes == code
        if where.sum() < 0.03 * codes.size:
            continue
        # of a coarse map each cell in pieces, since a word may fill a part of it
        fine = [max(1, 60 // n) for n in codes.shape]
        where = where.repeat(fine[0], axis=0).repeat(fine[1], axis=1)
        inside = np.pad(where, 1)
        # the word's extent, and the share of it that stays free
        half = [0.5 * e * n for e, n in zip(_extent(axes, word), where.shape, strict=True)]
        depth = distance_transform_edt(inside, sampling=(1 / half[0], 1 / half[1]))
        if depth.max() < 1:  # the word would leave its region
            continue
        # of the points that are about as deep the one nearest to the middle of the region
        rows, columns = np.nonzero(depth >= 0.9 * depth.max())
        inner = np.nonzero(inside)
        nearest = np.hypot(rows - inner[0].mean(), columns - inner[1].mean()).argmin()
        i, j = int(rows[nearest]), int(columns[nearest])
        x = float(dataset[_x(dataset)][min(max(j - 1, 0) // fine[1], codes.shape[1] - 1)])
        y = float(dataset[_y(dataset)][min(max(i - 1, 0) // fine[0], codes.shape[0] - 1)])
        write(axes, x, y, word, edge=2.2, zorder=5, fontsize=small() + 1.5)
        named.add(word)
    return named


def _present(codes: NDArray[Any]) -> set[Verdict]:
    """Verdicts in a map that have a hatching."""
    return {v for v in Verdict if LOOKS[v.word].pattern and (codes == CODES[v]).any()}


def _extent(axes: Axes, word: str) -> tuple[float, float]:
    """Height and width of a word with its halo, over those of the panel."""
    box = axes.get_window_extent()
    size = small() + 1.5
    width = TextPath((0, 0), word, size=size).get_extents().width
    return (1.3 * size + 3) / box.height / points(axes), (width + 7) / box.width / points(axes)


MARKERS = {
    PointKind.DOUBLE_ZERO: "s",
    PointKind.ZERO_HOPF: "D",
    PointKind.DOUBLE_HOPF: "^",
    PointKind.VANISHING: "o",
    PointKind.CUSP: "v",
}
"""Marker of each kind."""
LABELS = {
    PointKind.DOUBLE_ZERO: "double zero",
    PointKind.ZERO_HOPF: "zero and pair",
    PointKind.DOUBLE_HOPF: "two pairs",
    PointKind.VANISHING: "soft to hard",
    PointKind.CUSP: "cusp",
}
"""Word of each kind in the legend."""


def _mark_points(axes: Axes, marked: CodimensionTwo, swept: tuple[str, str]) -> None:
    """Mark points of codimension two, and draw their curves.

    Markers are open where other eigenvalues are unstable.
    """
    names = tuple(name for name, _, _ in marked.axes)
    if sorted(names) != sorted(swept):
        raise ParameterError(
            f"points has the axes {', '.join(names)}, and the map {', '.join(swept)}; give points "
            "of the same two axes."
        )
    swapped = names != swept
    seen: set[PointKind | Crossing] = set()
    for curve in marked.curves:
        along = (curve.y, curve.x) if swapped else (curve.x, curve.y)
        label = "curve of zeros" if curve.crossing is Crossing.STATIC else "curve of pairs"
        axes.plot(
            *along,
            color="black",
            linestyle=LINES[curve.crossing],
            linewidth=0.7,
            zorder=4,
            label=None if curve.crossing in seen else label,
        )
        seen.add(curve.crossing)
    for p in marked:
        x, y = (p.y, p.x) if swapped else (p.x, p.y)
        filled = p.others != "unstable"
        axes.plot(
            [x],
            [y],
            MARKERS[p.kind],
            color="black",
            markersize=4.5,
            zorder=6,
            markerfacecolor=YELLOW if filled else "none",
            markeredgewidth=0.9,
            label=None if p.kind in seen else LABELS[p.kind],
            path_effects=halo(2.2),
            clip_on=False,
        )
        seen.add(p.kind)
