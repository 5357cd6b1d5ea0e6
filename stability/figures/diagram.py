"""Figures only: stability diagrams, drawn from datasets."""

from __future__ import annotations

from .canvas import COLUMN, STYLE, figure_style, power_of_ten, spacing  # isort: skip

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.colors import LinearSegmentedColormap, SymLogNorm
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from matplotlib.patheffects import withStroke
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from ..base.quantities import Quantity, axis_label, in_latex, unit_of
from ..base.verdict import CODES, NO_MEMBER, Verdict
from ..bodies.thin_disk.disk_quantities import quantities_of
from ..boundary.beyond_linear.two_parameters.point_records import CodimensionTwo
from ..boundary.crossings import Crossing
from ..boundary.curves import KINDS
from ..maps.points import points_of
from .point_marks import counted, mark

if TYPE_CHECKING:
    import xarray


# Decay is blue, growth vermilion: distinct in every common colour vision; in grey, by hatching.
DIVERGING = LinearSegmentedColormap.from_list(
    "decay-growth", ["#08306b", "#4292c6", "#deebf7", "#fdebdc", "#e6703a", "#7f2704"]
)
"""Colours of the abscissa."""
LINES = {Crossing.STATIC: "-", Crossing.FLUTTER: (0, (4, 1.6)), Crossing.TOUCHING: ":"}
SYMMETRIC_FROM = 1e-4
"""Growth rates of the disk below this are drawn on a linear scale in a diagram."""
LINEAR_SHARE = 1e-4
"""The same for a user's system, over the power of ten of its largest rate."""
TEXTURES = {
    Verdict.UNSTABLE: ("////", "slanted lines"), Verdict.NEUTRAL: ("....", "dots"),
    Verdict.UNDECIDED: ("xxxx", "crosses"),
}  # fmt: skip
"""Hatching of each verdict, and its name; stable cells have none."""
FINEST = 600
"""Most cells along an axis whose edges the hatching follows exactly."""


@dataclass(frozen=True, eq=False)
class Strip:
    """A limit law next to a diagram: its verdict along the x axis of the main panel."""

    name: str
    """Name of the law on the figure."""
    x: NDArray[np.float64]
    """Points along the axis, shape (n,)."""
    abscissa: NDArray[np.float64]
    """Abscissa at these points, shape (n,)."""
    thresholds: tuple[float, ...]
    """Points where the verdict changes."""
    codes: NDArray[np.int8]
    """Verdicts at the points as flag values (`Verdict.code`), shape (n,)."""


def diagram(
    dataset: xarray.Dataset,
    *,
    above: Strip | None = None,
    below: Strip | None = None,
    points: CodimensionTwo | None = None,
    title: str = "",
) -> Figure:
    """Stability diagram of a map: abscissa in colour, exact boundary curves, limits next to it.

    Parameters
    ----------
    dataset
        Map from `stability_map`.
    above, below
        Limit laws at the upper and the lower end of the y axis, or None.
    points
        Points to mark, from `codimension_two` with the axes of the map; those that the map holds
        when left out.
    title
        Title of the figure.

    Returns
    -------
    Figure
        One journal column wide.

    Examples
    --------
    >>> import stability as st
    >>> m = st.stability_map("spinning", x=("at", 1, 4, 9), y=("mu", 0.1, 2, 9))
    >>> figure = diagram(m)
    >>> round(float(figure.get_figwidth()), 2)
    3.39
    """
    with figure_style(STYLE):
        heights = [s for s, strip in ((0.075, above), (1.0, True), (0.075, below)) if strip]
        figure = Figure(figsize=(COLUMN, 3.05), layout="constrained")
        panels = figure.subplots(
            len(heights), 1, sharex=True, squeeze=False,
            gridspec_kw={"height_ratios": heights, "hspace": 0.05},
        )  # fmt: skip
        spacing(figure, hspace=0.02, h_pad=0.02, w_pad=0.02)
        rows = [row[0] for row in panels]
        main = rows[1 if above else 0]
        mesh = _colour(main, dataset)
        marked = points_of(dataset) if points is None else points
        if marked is not None:
            mark(main, marked, (_x(dataset), _y(dataset)))
        _curves(main, dataset)
        _axis_labels(main, dataset)
        for strip, panel in ((above, rows[0]), (below, rows[-1])):
            if strip is not None:
                _strip(panel, strip, mesh.norm)
        if below is not None:
            rows[-1].set_xlabel(main.get_xlabel())
            main.set_xlabel("")
            main.tick_params(labelbottom=False)
            rows[-1].tick_params(labelbottom=True)
        if not _is_log(dataset, _x(dataset)):
            main.xaxis.set_major_locator(MaxNLocator(6))
        main.set_xlim(float(dataset[_x(dataset)][0]), float(dataset[_x(dataset)][-1]))
        bar = figure.colorbar(mesh, ax=rows, pad=0.02, aspect=32, fraction=0.05)
        unit = unit_of(dataset.abscissa.attrs)
        shown = "" if unit == "1" else f"  [{in_latex(unit)}]"
        bar.set_label(r"largest growth rate max Re $\lambda$" + shown)
        _bar_ticks(bar, mesh.norm)
        if title:
            rows[0].set_title(title, fontsize=8, pad=4)
        named = _region_names(main, dataset)
        _legend(main, dataset, named)
    return figure


def caption(dataset: xarray.Dataset, points: CodimensionTwo | None = None) -> str:
    """What a diagram shows: the family, colours, and how many cells have each verdict or no member.

    Parameters
    ----------
    dataset
        Map from `stability_map`.
    points
        Points that are marked, as for `diagram`.

    Returns
    -------
    str
        Two sentences or more.

    Examples
    --------
    >>> import stability as st
    >>> caption(st.stability_map("spinning", x=("at", 1, 4, 9), y=("mu", 0.1, 2, 9)))[-30:]
    'Cells: 20 stable, 61 unstable.'
    """
    points = points_of(dataset) if points is None else points
    codes = dataset.verdict.values
    words = {v.word: int((codes == c).sum()) for v, c in CODES.items()}
    missing = int((codes == NO_MEMBER).sum())
    cells = ", ".join(f"{n} {word}" for word, n in words.items() if n)
    none = f", {missing} without a member" * bool(missing)
    hatched = "; ".join(
        f"{way}: {v.word}" for v, (_, way) in TEXTURES.items() if words[v.word]
    )  # fmt: skip
    texture = f"; {hatched}" * bool(hatched)
    title = str(dataset.attrs["family"])
    blank = "  Blank: no member, since no steady motion of the family is reached there." * bool(
        missing
    )
    return (
        f"{title[:1].upper()}{title[1:]} of {dataset.attrs['system']}.  Colour: largest growth "
        f"rate, grey within {_grey(dataset)[0]:g} of zero{texture}.{blank}  Cells: {cells}{none}."
        f"{counted(points) if points is not None else ''}"
    )


def _x(dataset: xarray.Dataset) -> str:
    return str(dataset.abscissa.dims[1])


def _y(dataset: xarray.Dataset) -> str:
    return str(dataset.abscissa.dims[0])


def _is_log(dataset: xarray.Dataset, name: str) -> bool:
    # a name may hold a space, as the entries are parted by one
    entry = rf"(^| ){re.escape(name)}:[^: ]+:[^: ]+:\d+:log( |$)"
    return re.search(entry, str(dataset.attrs.get("axes", ""))) is not None


def _grey(dataset: xarray.Dataset) -> tuple[float, float]:
    """Size up to which a growth rate is grey, and the largest size."""
    there = dataset.verdict.values != NO_MEMBER
    largest = float(np.abs(dataset.abscissa.values[there]).max(initial=0.0))
    if _quantities(dataset):
        return SYMMETRIC_FROM, largest
    return LINEAR_SHARE * 10.0 ** math.floor(math.log10(largest or 1.0)), largest


def _colour(axes: Axes, dataset: xarray.Dataset) -> Any:
    x, y, values = dataset[_x(dataset)], dataset[_y(dataset)], dataset.abscissa.values
    missing = dataset.verdict.values == NO_MEMBER
    grey, largest = _grey(dataset)
    limit = max(largest, 10 * grey)
    norm = SymLogNorm(grey, linscale=0.3, vmin=-limit, vmax=limit)
    mesh = axes.pcolormesh(
        x, y, np.ma.masked_where(missing, values), cmap=DIVERGING, norm=norm, shading="nearest",
        rasterized=True,
    )  # fmt: skip
    for name, scale in ((_x(dataset), axes.set_xscale), (_y(dataset), axes.set_yscale)):
        if _is_log(dataset, name):
            scale("log")
    # the verdict shows without colour too
    for verdict, (hatch, _) in TEXTURES.items():
        _hatch(axes, x.values, y.values, dataset.verdict.values == CODES[verdict], hatch)
    if missing.any():  # left blank within a thin line, so that white is not taken for a colour
        axes.contour(x, y, missing.astype(float), levels=[0.5], colors="#777777", linewidths=0.6)
        axes.set_facecolor("white")
    axes.set_ylim(float(y[0]), float(y[-1]))
    if "box_verdict" in dataset:
        _boxes(axes, dataset)
    return mesh


def _hatch(axes: Axes, x: NDArray[Any], y: NDArray[Any], where: NDArray[Any], hatch: str) -> None:
    """Hatch cells, up to the edges of each cell; of a very fine map between the centres."""
    if not where.any():
        return
    if max(where.shape) <= FINEST:
        rows, columns = (np.repeat(np.arange(n), 2) for n in where.shape)
        where, x, y = where[np.ix_(rows, columns)], _edges(x), _edges(y)
    axes.contourf(
        x, y, where.astype(float), levels=[0.5, 1.5], colors="none", hatches=[hatch]
    )  # fmt: skip


def _edges(centres: NDArray[Any]) -> NDArray[Any]:
    """Both edges of each cell, a hair inside; the ends are the first and the last centre."""
    middle = (centres[1:] + centres[:-1]) / 2
    low, high = np.append(centres[:1], middle), np.append(middle, centres[-1:])
    hair = 1e-6 * (high - low)
    return np.stack([low + hair, high - hair], axis=1).reshape(-1)


def _boxes(axes: Axes, dataset: xarray.Dataset) -> None:
    """Outlines of the proved boxes, and the strip that encloses the boundary, filled."""
    ends = [dataset[f"box_{name}"].values for name in (_x(dataset), _y(dataset))]
    (x0, x1), (y0, y1) = (e.T for e in ends)
    corners = np.stack([np.stack([x0, x1, x1, x0], 1), np.stack([y0, y0, y1, y1], 1)], axis=-1)
    strip = dataset.box_verdict.values == CODES[Verdict.UNDECIDED]
    proved = PolyCollection(corners[~strip], facecolors="none", edgecolors="#00000055",
                            linewidths=0.25, label="proved boxes")  # fmt: skip
    open_boxes = PolyCollection(corners[strip], facecolors="#f7d038", edgecolors="#f7d038",
                                linewidths=0.4, label="enclosing strip")  # fmt: skip
    axes.add_collection(proved, autolim=False)
    axes.add_collection(open_boxes, autolim=False)


def _bar_ticks(bar: Any, norm: Any) -> None:
    top = math.floor(np.log10(norm.vmax))
    powers = [p for p in range(round(np.log10(norm.linthresh)), top + 1) if (top - p) % 2 == 0]
    powers = powers[-1::-2][::-1] if len(powers) > 6 else powers
    ticks = [-(10.0**p) for p in reversed(powers)] + [0.0] + [10.0**p for p in powers]
    bar.set_ticks(ticks)
    bar.set_ticklabels([power_of_ten(t) for t in ticks])
    bar.ax.minorticks_off()


def _curves(axes: Axes, dataset: xarray.Dataset) -> None:
    if "boundary_curve" not in dataset or not dataset.sizes["boundary_point"]:
        return
    x = dataset[f"boundary_{_x(dataset)}"].values
    y = dataset[f"boundary_{_y(dataset)}"].values
    kind, curve = dataset.boundary_kind.values, dataset.boundary_curve.values
    by_code = {code: crossing for crossing, code in KINDS.items()}
    seen: set[Crossing] = set()
    halo = [withStroke(linewidth=2.6, foreground="white")]
    for start, stop in _runs(kind, curve):
        crossing = by_code[int(kind[start])]
        last = min(stop + 1, len(x)) if stop < len(x) and curve[stop] == curve[start] else stop
        label = {Crossing.STATIC: "static", Crossing.FLUTTER: "flutter"}.get(crossing, "touching")
        axes.plot(
            x[start:last], y[start:last], color="black", linestyle=LINES[crossing],
            label=None if crossing in seen else f"{label} boundary", path_effects=halo,
            solid_capstyle="butt",
        )  # fmt: skip
        seen.add(crossing)


def _legend(axes: Axes, dataset: xarray.Dataset, named: set[Verdict]) -> None:
    """The boundaries, and the texture of each verdict whose region is too small for its name."""
    handles, _ = axes.get_legend_handles_labels()
    codes = dataset.verdict.values
    handles = [h for h in handles if not isinstance(h, PolyCollection)]
    handles += [
        Patch(facecolor="white", edgecolor="#5a2a0a", linewidth=0.3, hatch=hatch, label=v.word)
        for v, (hatch, _) in TEXTURES.items()
        if v not in named and (codes == CODES[v]).any()
    ]  # fmt: skip
    if handles:
        axes.legend(
            handles=handles, loc="upper right", fontsize=6.5, frameon=True, framealpha=0.92,
            edgecolor="none", handlelength=2.2, borderpad=0.3,
        )  # fmt: skip


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
    """The disk's quantities; none of a user's map, which has no contact law."""
    if not dataset.attrs.get("contact"):
        return {}
    return quantities_of(str(dataset.attrs.get("system", "")))


def _axis_labels(axes: Axes, dataset: xarray.Dataset) -> None:
    axes.set_xlabel(_label(dataset, _x(dataset)))
    axes.set_ylabel(_label(dataset, _y(dataset)))


def _strip(axes: Axes, strip: Strip, norm: Any) -> None:
    values = np.tile(strip.abscissa, (2, 1))
    axes.pcolormesh(
        strip.x, [0.25, 0.75], values, cmap=DIVERGING, norm=norm, shading="nearest", rasterized=True
    )
    for verdict, (hatch, _) in TEXTURES.items():
        where = np.tile(strip.codes == CODES[verdict], (2, 1))
        _hatch(axes, strip.x, np.array([0.0, 1.0]), where, hatch)
    for threshold in strip.thresholds:
        axes.axvline(threshold, color="black", linewidth=1.3)
    axes.set_ylim(0, 1)
    axes.set_yticks([0.5], [strip.name])
    halo = [withStroke(linewidth=1.8, foreground="white")]
    for verdict, code in CODES.items():
        word, runs = verdict.word, np.flatnonzero(strip.codes == code)
        if len(runs) > 0.22 * len(strip.x):
            axes.text(strip.x[runs[len(runs) // 2]], 0.48, word, ha="center", va="center",
                      fontsize=6.5, path_effects=halo)  # fmt: skip
    axes.tick_params(axis="y", length=0)
    axes.tick_params(axis="x", labelbottom=False, length=2)


def _region_names(axes: Axes, dataset: xarray.Dataset) -> set[Verdict]:
    """Write each verdict into its region, at the point farthest from the edge; those written."""
    from scipy.ndimage import distance_transform_edt

    codes = dataset.verdict.values
    halo = [withStroke(linewidth=2.2, foreground="white")]
    names = {code: v.word for v, code in CODES.items()}
    named = set()
    for code, word in (names | {NO_MEMBER: "no member"}).items():
        where = codes == code
        if where.sum() < 0.03 * codes.size:
            continue
        # of a coarse map each cell in pieces, since a word may fill a part of it
        fine = [max(1, 60 // n) for n in codes.shape]
        where = where.repeat(fine[0], axis=0).repeat(fine[1], axis=1)
        inside = np.pad(where, 1)
        half = (0.035 * where.shape[0], 0.014 * len(word) * where.shape[1])  # the word's extent
        depth = distance_transform_edt(inside, sampling=(1 / half[0], 1 / half[1]))
        # keep clear of the legend in the upper right corner
        rows, columns = np.indices(inside.shape)
        depth[(rows > 0.72 * inside.shape[0]) & (columns > 0.45 * inside.shape[1])] = 0
        if depth.max() < 1:  # the word would leave its region
            continue
        i, j = np.unravel_index(int(depth.argmax()), depth.shape)
        x = float(dataset[_x(dataset)][min(max(j - 1, 0) // fine[1], codes.shape[1] - 1)])
        y = float(dataset[_y(dataset)][min(max(i - 1, 0) // fine[0], codes.shape[0] - 1)])
        axes.text(x, y, word, ha="center", va="center", fontsize=8, path_effects=halo)
        named |= {v for v in Verdict if v.word == word}
    return named
