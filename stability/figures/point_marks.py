"""Points of codimension two on a diagram: a marker for each kind, and their part of the caption."""

from __future__ import annotations

from matplotlib.axes import Axes
from matplotlib.patheffects import withStroke

from ..base.errors import ParameterError
from ..boundary.two_parameters.point_records import CodimensionTwo, PointKind

MARKERS = {
    PointKind.DOUBLE_ZERO: "s",
    PointKind.ZERO_HOPF: "D",
    PointKind.DOUBLE_HOPF: "^",
    PointKind.VANISHING: "o",
}
"""Marker of each kind."""
LABELS = {
    PointKind.DOUBLE_ZERO: "double zero",
    PointKind.ZERO_HOPF: "zero and pair",
    PointKind.DOUBLE_HOPF: "two pairs",
    PointKind.VANISHING: "soft to hard",
}
"""Word of each kind in the legend."""


def mark(axes: Axes, found: CodimensionTwo, known: tuple[str, str]) -> None:
    """Mark points; open markers where other eigenvalues are unstable.

    Parameters
    ----------
    axes
        Axes of the diagram.
    found
        From `stability.codimension_two`.
    known
        Names of the diagram's x and y.

    Raises
    ------
    ParameterError
        If these are not the axes of the search.
    """
    names = tuple(name for name, _, _ in found.axes)
    if sorted(names) != sorted(known):
        raise ParameterError(
            f"points has the axes {', '.join(names)}, and the map {', '.join(known)}; give points "
            "of the same two axes."
        )
    swapped = names != known
    halo = [withStroke(linewidth=2.2, foreground="white")]
    seen: set[PointKind] = set()
    for p in found:
        x, y = (p.y, p.x) if swapped else (p.x, p.y)
        filled = p.others != "unstable"
        axes.plot(
            [x],
            [y],
            MARKERS[p.kind],
            color="black",
            markersize=4.5,
            zorder=6,
            markerfacecolor="#f7d038" if filled else "none",
            markeredgewidth=0.9,
            label=None if p.kind in seen else LABELS[p.kind],
            path_effects=halo,
            clip_on=False,
        )
        seen.add(p.kind)


def counted(found: CodimensionTwo) -> str:
    """A sentence for the caption: how many points of each kind, and what stays open.

    Parameters
    ----------
    found
        From `stability.codimension_two`.
    """
    counts = {k: sum(p.kind is k for p in found) for k in PointKind}
    words = ", ".join(f"{n} {LABELS[k]}" for k, n in counts.items() if n) or "none"
    open_ = "" if found.complete else "; the search is not complete"
    hollow = any(p.others == "unstable" for p in found)
    rest = "  Hollow: another eigenvalue is unstable." if hollow else ""
    return f"  Points of codimension two: {words}{open_}.{rest}"
