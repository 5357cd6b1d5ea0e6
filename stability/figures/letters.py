"""Letters next to markers, placed where they hide nothing."""

from __future__ import annotations

from .canvas import STYLE, figure_style  # isort: skip
from .styled_figure import halo, points  # isort: skip

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.textpath import TextPath
from numpy.typing import NDArray

SMALL = 6.0
"""Size of the smallest text [pt]."""

MARK = 1.7
"""Half the size of a marker next to which a letter stands [pt]."""

REACH = np.array([5.0, 6.5, 9.0, 12.0, 16.0, 21.0, 27.0, 34.0, 42.0])
"""Distances between a letter and its marker that are tried [pt]."""


@dataclass(frozen=True)
class Letter:
    """A letter next to a marker."""

    x: float
    """x of the marker, in data coordinates."""
    y: float
    """y of the marker, in data coordinates."""
    text: str
    """Text to write."""
    colour: str
    """Colour of the text."""


def letters(axes: Axes, marks: Sequence[Letter], size: float = MARK) -> None:
    """Write letters next to their markers; a thin line leads back from a letter that moved far.

    Parameters
    ----------
    axes
        The panel, with its limits set.
    marks
        Letters to write.
    size
        Half the size of the markers [pt].
    """
    if not marks:
        return
    scale = points(axes)
    at = axes.transData.transform([(m.x, m.y) for m in marks]) * scale
    half = np.array([_half(m.text) for m in marks])
    room = np.array([axes.bbox.p0, axes.bbox.p1]) * scale
    off = _apart(at, half, room, _drawn(axes, scale), size)
    for mark, shift, box in zip(marks, off, half, strict=True):
        far, wide = np.hypot(*shift) > 8, len(mark.text) > 2 and abs(shift[0]) > 9
        if size > MARK:  # from the mark to the nearest side of the text
            far = np.hypot(*np.maximum(np.abs(shift) - box, 0)) > size + 4
        # the line starts at the near end of a wide text
        start = (float(shift[0] < 0) if wide else 0.5, 0.5)
        arrow = (
            {
                "arrowstyle": "-",
                "linewidth": 0.35,
                "color": mark.colour,
                "shrinkA": 0.5,
                "shrinkB": size - 0.2,
                "relpos": start,
            }
            if far
            else None
        )
        axes.annotate(
            mark.text,
            (mark.x, mark.y),
            tuple(shift),
            textcoords="offset points",
            fontsize=SMALL,
            color=_dark(mark.colour),
            ha="center",
            va="center",
            path_effects=halo(1.2),
            arrowprops=arrow,
            zorder=6,
        )


def _dark(colour: str) -> tuple[float, ...]:
    """A colour for small text, which needs more contrast than a mark."""
    return tuple(0.8 * part for part in to_rgb(colour))


def _half(text: str) -> tuple[float, float]:
    """Half the width and height of a text [pt]; words are measured, letters take the same room."""
    if len(text) <= 1:
        return 0.3 * SMALL + 0.8, 0.42 * SMALL
    with figure_style(STYLE):
        box = TextPath((0, 0), text, size=SMALL).get_extents()
    return box.width / 2 + 1.0, 0.6 * SMALL


def _drawn(axes: Axes, scale: float) -> NDArray[Any]:
    """Points along all lines of a panel and about its markers [pt]."""
    spots = [np.zeros((0, 2))]
    about = np.array([(1.6, 0.0), (-1.6, 0.0), (0.0, 1.6), (0.0, -1.6)])
    for line in axes.lines:
        corners = line.get_transform().transform(line.get_xydata()) * scale
        if line.get_marker() != "None":
            spots.append((corners[:, None] + about).reshape(-1, 2))
        for a, b in zip(corners[:-1], corners[1:], strict=True):
            count = int(np.hypot(*(b - a)) / 1.5) + 2 if np.isfinite([a, b]).all() else 0
            spots.append(a + np.linspace(0, 1, count)[:, None] * (b - a))
    return np.concatenate(spots)


def _apart(
    at: NDArray[Any],
    half: NDArray[Any],
    room: NDArray[Any],
    lines: NDArray[Any],
    size: float = MARK,
) -> NDArray[Any]:
    """Offsets of the letters: each in turn goes where it disturbs the others least."""
    angles = np.arange(24) * np.pi / 12 + 0.01
    round_ = np.stack([np.cos(angles), np.sin(angles)], -1)
    tries = ((REACH + size - MARK)[:, None, None] * round_).reshape(-1, 2)
    off = np.full(at.shape, np.inf)
    for _ in range(4):
        for i in range(len(at)):
            # a wide text starts next to its marker, or stands above or below it
            aside = np.sign(tries) * (np.abs(tries) > 0.6)
            here = tries + aside * np.array([half[i, 0] - 2.5, 0.0])
            spots = at[i] + here
            struck = (np.abs(spots[:, None] - lines) < half[i] + 0.2).all(axis=-1).sum(axis=-1)
            cost = np.hypot(*tries.T) + np.minimum(4.0 * (struck > 0) + 0.8 * struck, 14.0)
            outside = (spots - half[i] < room[0] + 1) | (spots + half[i] > room[1] - 1)
            cost = cost + 500.0 * outside.any(axis=-1)
            others = np.arange(len(at)) != i
            # nearer to another marker than to its own, a text seems to name that one
            gaps = [
                np.hypot(*np.maximum(np.abs(spots[:, None] - m) - half[i], 0).T)
                for m in (at[i : i + 1], at[others])
            ]
            cost = cost + 10.0 * (gaps[1] < gaps[0] - 0.1).any(axis=0)
            for centre, extent, price in (
                ((at + off)[others], half[others], 300.0),
                (at, np.full_like(at, size), 40.0),
            ):
                gap = np.abs(spots[:, None] - centre) - half[i] - extent
                cost = cost + price * (gap < 0).all(axis=-1).sum(axis=-1)
            cost = cost + 12.0 * _crossings(at[i], spots, at[others], (at + off)[others])
            theirs = at[others], (at + off)[others], half[others]
            cost = cost + 25.0 * _struck((at[i], spots, half[i]), theirs)
            off[i] = here[int(cost.argmin())]
    return off


def _crossings(start: Any, ends: Any, starts: Any, stops: Any) -> Any:
    """How many leading lines each new one would cross."""

    def side(a: Any, b: Any, c: Any) -> Any:
        return (b - a)[..., 0] * (c - a)[..., 1] - (b - a)[..., 1] * (c - a)[..., 0]

    drawn = np.isfinite(stops).all(axis=-1)
    a, b, c, d = start, ends[:, None], starts[drawn], stops[drawn]
    apart = side(a, b, c) * side(a, b, d) < 0
    return (apart & (side(c, d, a + 0 * b) * side(c, d, b) < 0)).sum(axis=-1)


def _struck(mine: tuple[Any, Any, Any], other: tuple[Any, Any, Any]) -> NDArray[Any]:
    """How many texts each new leading line strikes, and how many leading lines each new text.

    Both are given as marks, centres of texts, and halves of their widths and heights.
    """
    drawn = np.isfinite(other[1]).all(axis=-1)
    starts, spots, halves = (part[drawn] for part in other)
    start, tried, half = mine
    ours, theirs = _leading(start, tried, half), _leading(starts, spots, halves)
    over = (np.abs(ours[:, :, None] - spots) < halves).all(axis=-1).any(axis=1).sum(axis=-1)
    under = (np.abs(tried[:, None, None] - theirs) < half).all(axis=-1).any(axis=-1).sum(axis=-1)
    return np.asarray(over + under)


def _leading(start: Any, spots: Any, half: Any) -> NDArray[Any]:
    """Points along each line from a mark to the near end of its text."""
    shift = spots - start
    ends = spots - np.where(np.abs(shift) > 9, np.sign(shift) * half, 0.0) * [1.0, 0.0]
    # a mark next to another text is judged by the distance of texts from marks
    along = np.linspace(0.25, 0.95, 12)[:, None]
    return np.asarray(np.expand_dims(start, -2) + along * (ends - start)[:, None])
