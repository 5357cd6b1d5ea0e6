"""Eigenvalue loci: growth rate and frequency along a quantity, or one spectrum in the plane."""

from __future__ import annotations

from ..styled_figure import drawing, key, note, settle, small, ticks_along  # isort: skip

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke

from ...base.checks import instance
from ...base.errors import ParameterError
from ...base.quantities import axis_label, in_latex
from ...base.types import Complexes, Floats
from ...spectra.result import Spectrum
from .modes import (
    crossings,
    even_in_logarithm,
    linear_width,
    mode_groups,
    mode_names,
    tracked,
)
from .modes import swept as swept
from .plane import asinh_scale, fixed_numbers, plane

MODE_COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#000000")
"""Okabe & Ito's colours, safe for colour-blind readers."""
DASHES: tuple[Any, ...] = ("-", (0, (3, 1.5)), (0, (1, 1)), (0, (4, 1.2, 1, 1.2)))
"""Lines of one mode: the second and later ones show only where a pair splits."""
HALO = [withStroke(linewidth=2, foreground="white")]
Groups = list[tuple[int, ...]]


def plot_locus(
    spectrum: Spectrum,
    *,
    thresholds: Sequence[float] = (),
    title: str = "",
    unit: str | None = None,
    ax: Any = None,
    width: float | None = None,
    fontsize: float | None = None,
) -> Figure:
    r"""Eigenvalues against the swept quantity: growth rate above, frequency below, modes labelled.

    Circles mark where a growth rate crosses zero.  The scale of growth rates is an inverse
    hyperbolic sine: linear near zero, so far as shows every arc between two crossings, and
    logarithmic beyond.

    A single spectrum is drawn in the plane of eigenvalues, with its verdict.

    Parameters
    ----------
    spectrum
        Spectrum along one axis, of one quantity given as an array, eigenvalues of shape
        (points, n); or a single one.
    thresholds
        Values of the swept quantity at which the verdict changes; circles lie exactly on them.
    title
        Title of the figure.
    unit
        Unit of rates; that of the spectrum when left out.
    ax
        Axes to draw on: two, the upper one first, or one for the growth rates alone, or for a
        single spectrum; a figure of its own when left out.
    width
        Width of a figure of its own [in]; a journal column, 3.39, when left out.
    fontsize
        Size of the text [pt], 7 or more; 7.5 when left out.  The smallest text is 1 pt smaller.

    Returns
    -------
    Figure
        The numbers that do not change along the axis stand below.

    Raises
    ------
    ParameterError
        If the spectrum has several axes, or not one quantity changes along it, or a size is not
        accepted.

    Source: drawn from the dataset alone; each text is measured: tests/figures.

    Examples
    --------
    >>> import stability as st
    >>> s = st.spectrum("rolling", at=[1.5, 2.0], contact=st.Viscous(0.3))
    >>> st.plot_locus(s).axes[0].get_ylabel()
    'growth rate\nRe $\\lambda$  [$\\sqrt{g/R}$]'
    """
    instance("spectrum", spectrum, Spectrum, "give what spectrum returns, or plot_map for a map")
    if spectrum.codes.size == 1:
        if np.size(thresholds):
            raise ParameterError("thresholds belongs to a spectrum along a quantity; leave it out.")
        return plane(spectrum, title, _unit(spectrum, unit), ax, width, fontsize)
    name, at = swept(spectrum)
    if ax is not None and np.size(ax) not in (1, 2):
        raise ParameterError(f"ax holds {np.size(ax)} axes; give one or two.")
    values, radius = tracked(spectrum)
    groups = mode_groups(values)
    names = mode_names(spectrum, groups)
    with drawing(ax, width, fontsize, lambda wide: min(1.15 * wide, 2.2 + 0.5 * wide)) as figure:
        panels = np.ravel(_panels(figure) if ax is None else ax).tolist()
        top, lowest = panels[0], panels[-1]
        units = _unit(spectrum, unit)
        top.set_ylabel("growth rate\nRe $\\lambda$" + units)
        lowest.set_xlabel(_axis(spectrum, name))
        if even_in_logarithm(at):
            for panel in panels:
                panel.set_xscale("log")
        else:
            lowest.xaxis.set_major_locator(ticks_along(lowest))
        top.set_xlim(float(at.min()), float(at.max()))
        lowest.set_xlim(top.get_xlim())
        if len(panels) > 1:
            lowest.set_ylabel("frequency\n|Im $\\lambda$|" + units)
            top.tick_params(labelbottom=False)
            figure.align_ylabels(panels)
        settle(figure)
        _growth(top, at, values, radius, groups, names, thresholds)
        if len(panels) > 1:
            _frequencies(lowest, at, values, groups)
        for panel in panels:
            for threshold in thresholds:
                panel.axvline(
                    threshold,
                    color="black",
                    linewidth=0.8,
                    linestyle=(0, (1, 1.5)),
                    label="change of verdict",
                )
        key(top, _entries(top), title)
        note(lowest, fixed_numbers(spectrum, name))
    return figure


def _unit(spectrum: Spectrum, unit: str | None) -> str:
    """The unit of rates as the end of a label."""
    word = spectrum.rate_unit if unit is None else unit
    return "" if word in ("1", "") else f"  [{in_latex(word)}]"


def _panels(figure: Figure) -> Any:
    return figure.subplots(2, 1, sharex=True, gridspec_kw={"height_ratios": [1.3, 1]})


def _entries(top: Axes) -> list[Any]:
    """Entries of the legend, each label once."""
    handles, labels = top.get_legend_handles_labels()
    return [h for i, h in enumerate(handles) if labels[i] not in labels[:i]]


def _axis(spectrum: Spectrum, name: str) -> str:
    """Label of the swept quantity, with the unit of its system."""
    system, meaning = spectrum.family.system, spectrum.family.meaning(name)
    known, unit = system.quantities.get(meaning), system.units.get(meaning, "1")
    unit = known.kind.label(dimensionless=spectrum.dimensionless) if known else unit
    return axis_label(known, meaning, unit or "1")


def _growth(
    axes: Axes,
    at: Floats,
    values: Complexes,
    radius: Floats,
    groups: Groups,
    names: Sequence[str],
    known: Sequence[float],
) -> None:
    """Draw the real parts; growth is shaded, crossings are marked, a number is on each mode."""
    axes.axhline(0, color="0.3", linewidth=0.6)
    for index, columns in enumerate(groups):
        for position, column in enumerate(columns):
            axes.plot(
                at,
                values[:, column].real,
                color=_colour(index),
                zorder=3,
                linestyle=DASHES[position % len(DASHES)],
                label=None if position else f"{index + 1}: {names[index]}",
            )
    asinh_scale(axes, "y", values.real, linear_width(values.real, radius))
    axes.axhspan(0, axes.get_ylim()[1], facecolor="#fdebdc", zorder=0)
    zero = float(axes.transAxes.inverted().transform(axes.transData.transform((at[0], 0.0)))[1])
    for word, height, colour in (
        ("growth", (1 + zero) / 2, "#7f2704"),
        ("decay", zero / 2, "#08306b"),
    ):
        axes.text(
            1.015,
            height,
            word,
            transform=axes.transAxes,
            rotation=90,
            ha="left",
            va="center",
            fontsize=small(),
            color=colour,
        )
    found = crossings(at, values.real, radius, known)
    if found:
        axes.plot(
            found,
            np.zeros(len(found)),
            "o",
            markersize=4,
            markerfacecolor="white",
            markeredgecolor="black",
            markeredgewidth=0.9,
            zorder=5,
            clip_on=False,
            label=r"Re $\lambda$ = 0",
        )
    _numbers(axes, at, values.real, groups)


def _colour(index: int) -> str:
    return MODE_COLOURS[index % len(MODE_COLOURS)]


def _frequencies(axes: Axes, at: Floats, values: Complexes, groups: Groups) -> None:
    """Draw the frequencies where eigenvalues are complex; say so where none is."""
    every = np.abs(values.imag)
    if not every.any():
        axes.text(
            0.5,
            0.5,
            "no oscillation: every eigenvalue is real",
            ha="center",
            va="center",
            transform=axes.transAxes,
            fontsize=small(),
            path_effects=HALO,
            zorder=5,
        )
        axes.set_yticks([])
        return
    shown = np.ma.masked_equal(every, 0.0)
    for index, columns in enumerate(groups):
        for column in columns:
            axes.plot(at, shown[:, column], color=_colour(index))
    axes.set_ylim(0, 1.08 * float(every.max()))
    _numbers(axes, at, shown.filled(np.nan), groups)


def _numbers(axes: Axes, at: Floats, values: Floats, groups: Groups) -> None:
    """Write the number of each mode on its curve, where it is farthest from the other curves."""
    points = 72 / axes.get_figure(root=True).dpi  # type: ignore[union-attr]

    def place(column: int) -> Floats:  # along the curve [pt], NaN outside the panel
        pairs = np.column_stack([at, values[:, column]])
        spots = np.asarray(axes.transData.transform(pairs))
        inside = np.isfinite(spots).all(axis=1)
        (x0, y0), (x1, y1) = axes.bbox.min, axes.bbox.max
        x, y = np.nan_to_num(spots).T
        inside &= (x0 + 3 < x) & (x < x1 - 3) & (y0 + 3 < y) & (y < y1 - 3)
        return np.where(inside[:, None], spots, np.nan) * points

    curves = [[place(c) for c in columns] for columns in groups]
    written: list[Floats] = []
    for index, own in enumerate(curves):
        others = [p for j, c in enumerate(curves) if j != index for p in c]
        # from the middle outward, since the first of equal spots is taken
        picked = [
            int((0.5 + side * off) * (len(at) - 1))
            for off in np.linspace(0, 0.44, 23)
            for side in (1, -1)
        ]
        tries = [p[i] for p in own for i in picked if np.isfinite(p[i]).all()]
        if not tries:
            continue
        clear = [_clearance(spot, others, written) for spot in tries]
        best = tries[int(np.argmax(clear))]
        written.append(best)
        x, y = axes.transData.inverted().transform(best / points)
        axes.text(
            x,
            y,
            str(index + 1),
            color=_colour(index),
            ha="center",
            va="center",
            fontsize=small(),
            path_effects=HALO,
            zorder=4,
        )


def _clearance(spot: Floats, others: list[Floats], written: list[Floats]) -> float:
    """Distance of a number from other curves, at most 12 pt, and from other numbers [pt]."""
    gaps = [12.0, *(float(np.nanmin(np.hypot(*(c - spot).T), initial=99.0)) for c in others)]
    apart = [20.0, *(float(np.hypot(*(w - spot))) for w in written)]
    return min(gaps) + min(apart)
