"""Figures only: stability diagrams, drawn from datasets."""

from __future__ import annotations

from .canvas import COLUMN, STYLE, figure_style, power_of_ten, spacing  # isort: skip

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.colors import LinearSegmentedColormap, SymLogNorm
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from ..base.errors import ParameterError
from ..base.quantities import axis_label, in_latex, unit_of
from ..base.verdict import CODES, NO_MEMBER, Verdict
from ..bodies.thin_disk.disk_quantities import quantities_of
from ..boundary.beyond_linear.two_parameters.point_records import CodimensionTwo
from ..boundary.crossings import Crossing
from ..boundary.curves import KINDS
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
"""Growth rates below this are drawn on a linear scale in a diagram."""


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
        Points to mark, from `codimension_two` with the axes of the map, or None.
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
        if points is not None:
            _points(main, dataset, points)
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
        unit = in_latex(unit_of(dataset.abscissa.attrs))
        bar.set_label(rf"largest growth rate max Re $\lambda$  [{unit}]")
        _bar_ticks(bar, mesh.norm)
        if title:
            rows[0].set_title(title, fontsize=8, pad=4)
        _region_names(main, dataset)
    return figure


def caption(dataset: xarray.Dataset, points: CodimensionTwo | None = None) -> str:
    """What a diagram shows: the family, colours, and how many cells have each verdict or no member.

    Parameters
    ----------
    dataset
        Map from `stability_map`.
    points
        Points that are marked, or None.

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
    codes = dataset.verdict.values
    words = {v.word: int((codes == c).sum()) for v, c in CODES.items()}
    missing = int((codes == NO_MEMBER).sum())
    cells = ", ".join(f"{n} {word}" for word, n in words.items() if n)
    none = f", {missing} without a member" * bool(missing)
    blank = "  Blank: no member, since no steady motion of the family is reached there." * bool(
        missing
    )
    return (
        f"{str(dataset.attrs['family']).capitalize()} of {dataset.attrs['system']}.  Colour: "
        f"largest growth rate; hatched where it is positive.{blank}  Cells: {cells}{none}."
        f"{counted(points) if points is not None else ''}"
    )


def _x(dataset: xarray.Dataset) -> str:
    return str(dataset.abscissa.dims[1])


def _y(dataset: xarray.Dataset) -> str:
    return str(dataset.abscissa.dims[0])


def _is_log(dataset: xarray.Dataset, name: str) -> bool:
    axes = dataset.attrs.get("axes", "").split()
    return any(a.startswith(f"{name}:") and a.endswith(":log") for a in axes)


def _colour(axes: Axes, dataset: xarray.Dataset) -> Any:
    x, y, values = dataset[_x(dataset)], dataset[_y(dataset)], dataset.abscissa.values
    missing = dataset.verdict.values == NO_MEMBER
    limit = max(float(np.abs(values[~missing]).max(initial=0.0)), 10 * SYMMETRIC_FROM)
    norm = SymLogNorm(SYMMETRIC_FROM, linscale=0.3, vmin=-limit, vmax=limit)
    mesh = axes.pcolormesh(
        x, y, np.ma.masked_where(missing, values), cmap=DIVERGING, norm=norm, shading="nearest",
        rasterized=True,
    )  # fmt: skip
    for name, scale in ((_x(dataset), axes.set_xscale), (_y(dataset), axes.set_yscale)):
        if _is_log(dataset, name):
            scale("log")
    # growth is hatched, so that the sign shows without colour too
    growing = np.where(~missing & (np.where(missing, 0.0, values) > 0), 1.0, 0.0)
    if growing.any() and not growing.all():
        axes.contourf(x, y, growing, levels=[0.5, 1.5], colors="none", hatches=["////"])
    elif growing.all():
        axes.contourf(x, y, growing, levels=[0.5, 1.5], colors="none", hatches=["////"])
    if missing.any():  # left blank within a thin line, so that white is not taken for a colour
        axes.contour(x, y, missing.astype(float), levels=[0.5], colors="#777777", linewidths=0.6)
        axes.set_facecolor("white")
    axes.set_ylim(float(y[0]), float(y[-1]))
    if "box_verdict" in dataset:
        _boxes(axes, dataset)
    return mesh


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
    powers = [p for p in range(round(np.log10(SYMMETRIC_FROM)), top + 1) if (top - p) % 2 == 0]
    ticks = [-(10.0**p) for p in reversed(powers)] + [0.0] + [10.0**p for p in powers]
    bar.set_ticks(ticks)
    bar.set_ticklabels([power_of_ten(t) for t in ticks])
    bar.ax.minorticks_off()


def _points(axes: Axes, dataset: xarray.Dataset, points: CodimensionTwo) -> None:
    names = tuple(name for name, _, _ in points.axes)
    known = (_x(dataset), _y(dataset))
    if sorted(names) != sorted(known):
        raise ParameterError(
            f"points has the axes {', '.join(names)}, and the map {', '.join(known)}; give points "
            "of the same two axes."
        )
    mark(axes, points, swapped=names != known)
    _legend(axes)


def _legend(axes: Axes) -> None:
    if axes.get_legend_handles_labels()[0]:
        axes.legend(
            loc="upper right", fontsize=6.5, frameon=True, framealpha=0.92, edgecolor="none",
            handlelength=2.2, borderpad=0.3,
        )  # fmt: skip


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
    _legend(axes)


def _runs(kind: NDArray[Any], curve: NDArray[Any]) -> list[tuple[int, int]]:
    """Index ranges (start, stop) of one polyline along which the crossing has one kind."""
    cuts = np.flatnonzero((np.diff(kind) != 0) | (np.diff(curve) != 0)) + 1
    ends = [0, *cuts.tolist(), len(kind)]
    return list(zip(ends[:-1], ends[1:], strict=True))


def _label(dataset: xarray.Dataset, name: str) -> str:
    attributes = dataset[name].attrs
    quantity = attributes.get("quantity", name)
    known = quantities_of(dataset.attrs.get("system", "")).get(quantity)
    return axis_label(known, quantity, unit_of(attributes))


def _axis_labels(axes: Axes, dataset: xarray.Dataset) -> None:
    axes.set_xlabel(_label(dataset, _x(dataset)))
    axes.set_ylabel(_label(dataset, _y(dataset)))


def _strip(axes: Axes, strip: Strip, norm: Any) -> None:
    values = np.tile(strip.abscissa, (2, 1))
    axes.pcolormesh(
        strip.x, [0.25, 0.75], values, cmap=DIVERGING, norm=norm, shading="nearest", rasterized=True
    )
    growing = np.where(values > 0, 1.0, 0.0)
    if growing.any():
        axes.contourf(
            strip.x, [0.0, 1.0], growing, levels=[0.5, 1.5], colors="none", hatches=["////"]
        )
    for threshold in strip.thresholds:
        axes.axvline(threshold, color="black", linewidth=1.3)
    axes.set_ylim(0, 1)
    axes.set_yticks([0.5], [strip.name])
    halo = [withStroke(linewidth=1.8, foreground="white")]
    for word, where in (("unstable", values[0] > 0), ("neutral", values[0] <= 0)):
        runs = np.flatnonzero(where)
        if len(runs) > 0.22 * len(strip.x):
            axes.text(strip.x[runs[len(runs) // 2]], 0.48, word, ha="center", va="center",
                      fontsize=6.5, path_effects=halo)  # fmt: skip
    axes.tick_params(axis="y", length=0)
    axes.tick_params(axis="x", labelbottom=False, length=2)


def _region_names(axes: Axes, dataset: xarray.Dataset) -> None:
    """Write each verdict into its region, at the point farthest from the region's edge."""
    from scipy.ndimage import distance_transform_edt

    codes = dataset.verdict.values
    halo = [withStroke(linewidth=2.2, foreground="white")]
    names = {CODES[v]: v.word for v in (Verdict.STABLE, Verdict.UNSTABLE, Verdict.NEUTRAL)}
    for code, word in (names | {NO_MEMBER: "no member"}).items():
        inside = np.pad(codes == code, 1)
        if inside.sum() < 0.03 * codes.size:
            continue
        depth = distance_transform_edt(inside, sampling=(1 / codes.shape[0], 1 / codes.shape[1]))
        # keep clear of the legend in the upper right corner
        rows, columns = np.indices(inside.shape)
        depth[(rows > 0.72 * inside.shape[0]) & (columns > 0.45 * inside.shape[1])] = 0
        i, j = np.unravel_index(int(depth.argmax()), depth.shape)
        x = float(dataset[_x(dataset)][min(max(j - 1, 0), codes.shape[1] - 1)])
        y = float(dataset[_y(dataset)][min(max(i - 1, 0), codes.shape[0] - 1)])
        axes.text(x, y, word, ha="center", va="center", fontsize=8, path_effects=halo)
