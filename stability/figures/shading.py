"""Growth rates and verdicts drawn: colours, hatching, the colour bar, and strips of limit laws."""

from __future__ import annotations

from .styled_figure import StyledFigure, points, signed_ticks, wide, write  # isort: skip

import math
from dataclasses import dataclass
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap, ListedColormap, SymLogNorm
from matplotlib.patches import Patch
from numpy.typing import NDArray

from ..base.looks import LIGHT, LOOKS
from ..base.verdict import BY_CODE, CODES, Verdict

DIVERGING = LinearSegmentedColormap.from_list("decay-growth", LIGHT.ramp)
"""Colours of the abscissa."""
FINEST = 600
"""Most cells along an axis whose edges the hatching follows exactly."""
NEAR_ZERO = 0.02
"""Share of the cells that may lie on the linear part of the scale."""
LINEAR_SHARE, LEAST_SHARE = 1e-4, 1e-9
"""Largest and smallest linear part, over the power of ten of the largest rate."""


def linear_part(values: NDArray[np.float64]) -> tuple[float, float]:
    """Size up to which a growth rate is drawn on a linear scale, and the largest size.

    Parameters
    ----------
    values
        Growth rates, any shape.

    Examples
    --------
    >>> rates = 10.0 ** np.linspace(-8, 0, 81)
    >>> linear_part(rates), linear_part(np.array([0.5, 1.0]))
    ((1e-08, 1.0), (0.0001, 1.0))
    """
    sizes = np.abs(values[np.isfinite(values) & (values != 0)])
    largest = float(sizes.max(initial=0.0))
    scale = 10.0 ** math.floor(math.log10(largest or 1.0))
    typical = float(np.quantile(sizes, NEAR_ZERO)) if sizes.size else scale
    linear = 10.0 ** math.floor(math.log10(typical) + 1e-9)
    return min(max(linear, LEAST_SHARE * scale), LINEAR_SHARE * scale), largest


def norm_of(linear: float, largest: float) -> SymLogNorm:
    """The scale of the colours, symmetric about zero."""
    limit = max(largest, 10 * linear)
    return SymLogNorm(linear, linscale=0.3, vmin=-limit, vmax=limit)


def hatch(axes: Axes, x: NDArray[Any], y: NDArray[Any], where: NDArray[Any], texture: str) -> None:
    """Hatch cells, up to the edges of each cell; of a very fine map between the centres.

    Parameters
    ----------
    axes
        The panel.
    x, y
        Centres of the cells, or the ends of a strip.
    where
        Cells to hatch, shape (len(y), len(x)).
    texture
        Hatching, as Matplotlib takes it.
    """
    if not where.any():
        return
    if max(where.shape) <= FINEST:
        rows, columns = (np.repeat(np.arange(n), 2) for n in where.shape)
        where, x, y = where[np.ix_(rows, columns)], _edges(x), _edges(y)
    drawn: Any = axes.contourf(
        x, y, where.astype(float), levels=[0.5, 1.5], colors="none", hatches=[texture]
    )
    drawn.set_hatch_linewidth(matplotlib.rcParams["hatch.linewidth"])


def _edges(centres: NDArray[Any]) -> NDArray[Any]:
    """Both edges of each cell, a hair inside; the ends are the first and the last centre."""
    middle = (centres[1:] + centres[:-1]) / 2
    low, high = np.append(centres[:1], middle), np.append(middle, centres[-1:])
    hair = 1e-6 * (high - low)
    return np.stack([low + hair, high - hair], axis=1).reshape(-1)


def patch(verdict: Verdict) -> Patch:
    """The entry of a verdict in a legend: its colour and hatching."""
    look = LOOKS[verdict.word]
    colour = look.fill[0] if look.fill else DIVERGING(look.shade)
    return hatched_patch(colour, look.hatching, verdict.word)


def hatched_patch(colour: Any, texture: str, label: str) -> Patch:
    """An entry of a legend, hatched a little more densely than its regions."""
    return Patch(
        facecolor=colour,
        edgecolor=matplotlib.rcParams["hatch.color"],
        linewidth=0.3,
        hatch=texture and texture + texture[:2],
        label=label,
    )


def paint_verdicts(
    axes: Axes, x: NDArray[Any], y: NDArray[Any], codes: NDArray[Any]
) -> set[Verdict]:
    """Give the cells of each verdict its own colour, where it has one, and its hatching.

    A verdict without a colour of its own leaves that of the growth rates.

    Parameters
    ----------
    axes, x, y
        As for `hatch`.
    codes
        Verdicts as flag values, shape (len(y), len(x)).

    Returns
    -------
    set of Verdict
        Those that are hatched.
    """
    for verdict in Verdict:
        fill, where = LOOKS[verdict.word].fill, codes == CODES[verdict]
        if fill and where.any():
            axes.pcolormesh(
                x,
                y,
                np.ma.masked_where(~where, where.astype(float)),
                cmap=ListedColormap([fill[0]]),
                shading="nearest",
                rasterized=True,
            )
    return _hatch_verdicts(axes, x, y, codes)


def _hatch_verdicts(
    axes: Axes, x: NDArray[Any], y: NDArray[Any], codes: NDArray[Any]
) -> set[Verdict]:
    """Hatch the cells of each verdict, so that it shows without colour too."""
    hatched = {v for v in Verdict if LOOKS[v.word].pattern and (codes == CODES[v]).any()}
    for verdict in Verdict:
        if verdict in hatched:
            hatch(axes, x, y, codes == CODES[verdict], LOOKS[verdict.word].hatching)
    return hatched


def hatching_words(codes: NDArray[Any]) -> list[str]:
    """What each hatching of some verdicts means, for a caption.

    Examples
    --------
    >>> hatching_words(np.array([1, 2, 3]))
    ['slanted lines: unstable', 'dots: neutral']
    """
    present = {BY_CODE[c].word for c in np.unique(codes).tolist() if c in BY_CODE}
    return [f"{look.pattern}: {w}" for w, look in LOOKS.items() if look.pattern and w in present]


def colour_bar(figure: Any, mesh: Any, axes: Any, label: str, *, hatched: bool) -> None:
    """The colour bar, hatched like the map where rates grow.

    Parameters
    ----------
    figure
        The figure.
    mesh
        Colours of the map.
    axes
        Axes from which the bar takes its room.
    label
        Label of the bar.
    hatched
        Whether unstable cells are drawn.
    """
    norm = mesh.norm
    alone = axes[0] if len(axes) == 1 else axes  # the room of one panel is known to every layout
    bar = figure.colorbar(mesh, ax=alone, pad=0.02, aspect=32, fraction=0.05)
    styled = isinstance(figure, StyledFigure)  # a user's panel may be low
    bar.set_label(label if styled else label.replace(" max ", "\nmax "))
    panel = np.ravel(axes)[0]
    length: float = panel.get_figure(root=True).get_figheight() * 72 * 0.7
    if not styled:  # a layout has yet to take room from it
        length = panel.get_window_extent().height * points(panel) * 0.6

    def place(value: float) -> float:
        return float(norm(value)) * length

    gap = 1.6 * matplotlib.rcParams["ytick.labelsize"]
    ticks, labels = signed_ticks(place, norm.vmin, norm.vmax, norm.linthresh, gap)
    bar.set_ticks(ticks, labels=labels)
    bar.ax.minorticks_off()
    if hatched:
        ends = np.array([norm.linthresh / 3, norm.vmax])
        texture = LOOKS[Verdict.UNSTABLE.word].hatching
        hatch(bar.ax, np.array([0.0, 1.0]), ends, np.ones((2, 2), dtype=bool), texture)


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


def draw_strip(axes: Axes, strip: Strip, norm: Any) -> set[Verdict]:
    """Draw a strip; each zone has its word where there is room for it.

    Parameters
    ----------
    axes
        Panel of the strip, with the limits of the main panel.
    strip
        Limit law.
    norm
        Scale of the colours.

    Returns
    -------
    set of Verdict
        Verdicts without a word, for the legend.
    """
    values = np.tile(strip.abscissa, (2, 1))
    axes.pcolormesh(
        strip.x, [0.25, 0.75], values, cmap=DIVERGING, norm=norm, shading="nearest", rasterized=True
    )
    paint_verdicts(axes, strip.x, np.array([0.25, 0.75]), np.tile(strip.codes, (2, 1)))
    for threshold in strip.thresholds:
        axes.axvline(threshold, color="black", linewidth=1.3)
    axes.set_ylim(0, 1)
    axes.set_yticks([0.5], [strip.name])
    axes.tick_params(axis="y", length=0)
    axes.tick_params(axis="x", length=2)
    return _words(axes, strip)


def _zones(strip: Strip) -> list[tuple[Verdict, float, float]]:
    """Verdict and ends of each zone."""
    cuts = np.flatnonzero(np.diff(strip.codes)) + 1
    ends = [0, *cuts.tolist(), len(strip.codes)]
    return [
        (BY_CODE[int(strip.codes[i])], float(strip.x[i]), float(strip.x[min(j, len(strip.x) - 1)]))
        for i, j in zip(ends[:-1], ends[1:], strict=True)
    ]


def _words(axes: Axes, strip: Strip) -> set[Verdict]:
    zones, (low, high) = _zones(strip), axes.get_xlim()
    room = axes.get_window_extent().width * points(axes) / (high - low)
    said = set()
    for verdict, begin, end in zones:
        if wide(verdict.word) + 4 <= room * (end - begin):  # a word stands in its own zone
            write(axes, (begin + end) / 2, 0.48, verdict.word, edge=1.8)
            said.add(verdict)
    return {verdict for verdict, _, _ in zones} - said
