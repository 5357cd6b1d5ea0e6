"""Limit laws next to a diagram: strips with the verdict along the x axis."""

from __future__ import annotations

from .styled_figure import small, wide  # isort: skip

from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patheffects import withStroke
from numpy.typing import NDArray

from ..base.verdict import CODES, Verdict
from .shading import DIVERGING, TEXTURES, hatch

HALO = [withStroke(linewidth=1.8, foreground="white")]


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
    """Draw a strip; each zone has its word, or an arrow from it where the zone is too short.

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
    for verdict, (texture, _) in TEXTURES.items():
        where = np.tile(strip.codes == CODES[verdict], (2, 1))
        hatch(axes, strip.x, np.array([0.0, 1.0]), where, texture)
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
    by_code = {code: verdict for verdict, code in CODES.items()}
    return [
        (by_code[int(strip.codes[i])], float(strip.x[i]), float(strip.x[min(j, len(strip.x) - 1)]))
        for i, j in zip(ends[:-1], ends[1:], strict=True)
    ]


def _words(axes: Axes, strip: Strip) -> set[Verdict]:
    zones, size = _zones(strip), small()
    low, high = axes.get_xlim()
    room = axes.get_window_extent().width * 72 / axes.get_figure(root=True).dpi  # type: ignore[union-attr]

    def need(verdict: Verdict) -> float:  # width of a word and its halo along the axis
        return (wide(verdict.word) + 4) / room * (high - low)

    begins = [begin for _, begin, _ in zones]  # where the free room of each zone begins
    ends = [end for _, _, end in zones]
    said: set[Verdict] = set()
    style: dict[str, Any] = {"va": "center", "fontsize": size, "path_effects": HALO}
    arrow = {
        "arrowstyle": "-|>",
        "linewidth": 0.6,
        "color": "black",
        "shrinkA": 0,
        "shrinkB": 0,
        "mutation_scale": 5,
    }
    lead = 9 / room * (high - low)
    for i, (verdict, begin, end) in enumerate(zones):
        if need(verdict) <= end - begin:
            continue
        for j, side in ((i + 1, 1), (i - 1, -1)):  # a longer zone next to it lends room
            if not 0 <= j < len(zones) or verdict in said:
                continue
            other, asked = zones[j], need(verdict) + lead
            if need(other[0]) + asked > ends[j] - begins[j]:
                continue
            foot = end if side > 0 else begin
            axes.annotate(
                verdict.word,
                ((begin + end) / 2, 0.48),
                (foot + side * lead, 0.48),
                ha="left" if side > 0 else "right",
                arrowprops=arrow,
                **style,
            )
            begins[j], ends[j] = (
                (begins[j] + asked, ends[j]) if side > 0 else (begins[j], ends[j] - asked)
            )
            said.add(verdict)
    for i, (verdict, begin, end) in enumerate(zones):
        if need(verdict) <= end - begin:
            axes.text((begins[i] + ends[i]) / 2, 0.48, verdict.word, ha="center", **style)
            said.add(verdict)
    return {verdict for verdict, _, _ in zones} - said
