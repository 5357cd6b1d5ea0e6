"""Eigenvalue loci: growth rate and frequency along a quantity, or one spectrum in the plane."""

from __future__ import annotations

from .styled_figure import checked_title, drawing, entry, fixed, key, note, panels, points  # isort: skip
from .styled_figure import remembered, settle, signed_ticks, ticks_along, write  # isort: skip

import math
from collections.abc import Sequence
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from ..base.checks import instance
from ..base.errors import ParameterError
from ..base.looks import BLUE, GREEN, LIGHT, PURPLE, SKY, VERMILION
from ..base.quantities import axis_label, in_latex
from ..base.types import Complexes, Floats
from ..base.verdict import BY_CODE
from ..boundary.brackets import Crossings
from ..spectra.result import Spectrum
from .letters import Letter, letters
from .modes import (
    LEAST_SHARE,
    crossings,
    even_in_logarithm,
    linear_width,
    mode_groups,
    mode_names,
    sure_signs,
    tracked,
)
from .modes import swept as swept

MODE_COLOURS = (BLUE, VERMILION, GREEN, PURPLE, SKY, "#000000")
DASHES: tuple[Any, ...] = ("-", (0, (3, 1.5)), (0, (6, 1.2, 1.5, 1.2)), (0, (7, 2)))
"""The line of each mode, whole or broken; a dotted line tells of a change of verdict alone."""
SHARE = 0.22
"""Least share of an axis of growth rates on each side of zero."""
PLAIN = 0.03
"""Least rate over the largest one that a linear scale shows apart from zero."""
LOOKS: dict[int, tuple[str, str, dict[str, Any]]] = {
    1: ("growing", "#b34700", {"marker": "^", "mfc": VERMILION, "ms": 5.0}),
    0: ("near the axis", "#303030", {"marker": "D", "mfc": "white", "ms": 4.0}),
    -1: ("decaying", BLUE, {"marker": "o", "mfc": BLUE, "ms": 4.2}),
}
"""Word, colour and marker by the sign of the real part, where the error disc leaves no doubt."""
SOME_GROWTH = LIGHT.ramp[3]
"""Colour of the side of growth."""
HALO = 2.0
"""White edge of words [pt]."""
Groups = list[tuple[int, ...]]


@remembered
def plot_locus(
    spectrum: Spectrum,
    *,
    thresholds: Sequence[Any] = (),
    zeros: Sequence[float] = (),
    title: str = "",
    unit: str | None = None,
    ax: Any = None,
    width: float | None = None,
    fontsize: float | None = None,
) -> Figure:
    r"""Eigenvalues against the swept quantity: growth rate above, frequency below, modes labelled.

    Each mode has one colour and one line.  Circles mark where a growth rate crosses zero, as far as
    that is known: at the thresholds and zeros that are given, and nowhere else.  The scale of
    growth rates is an inverse hyperbolic sine: linear near zero, so far as shows every arc between
    two crossings, and logarithmic beyond.

    A single spectrum is drawn in the plane of eigenvalues, with its verdict.

    Parameters
    ----------
    spectrum
        Spectrum along one axis, of one quantity given as an array, eigenvalues of shape
        (points, n); or a single one.
    thresholds
        Where the verdict changes: what `boundaries` returns, or values of the swept quantity.  Of
        every crossing those with unstable eigenvalues on both sides are zeros.
    zeros
        Further values at which a growth rate crosses zero, with no change of verdict.
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
    title = checked_title(title)
    instance("spectrum", spectrum, Spectrum, "give what spectrum returns, or plot_map for a map")
    if spectrum.codes.size == 1:
        for word, places in (("thresholds", thresholds), ("zeros", zeros)):
            if len(places):
                raise ParameterError(
                    f"{word} belongs to a spectrum along a quantity; leave it out."
                )
        return _plane(spectrum, title, _unit(spectrum, unit), ax, width, fontsize)
    name, at = swept(spectrum)
    if ax is not None and np.size(ax) not in (1, 2):
        raise ParameterError(f"ax holds {np.size(ax)} axes; give one or two.")
    values, radius = tracked(spectrum)
    groups = mode_groups(values)
    names = mode_names(spectrum, groups)
    if isinstance(thresholds, Crossings):
        behind = [c for c in thresholds if c.unstable_below and c.unstable_above]
        zeros = [*zeros, *(c.value for c in behind)]
        thresholds = [c for c in thresholds if c not in behind]
    changes = [float(getattr(threshold, "value", threshold)) for threshold in thresholds]
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
            ticks_along(lowest.xaxis)
        top.set_xlim(float(at.min()), float(at.max()))
        lowest.set_xlim(top.get_xlim())
        if len(panels) > 1:
            lowest.set_ylabel("frequency\n|Im $\\lambda$|" + units)
            top.tick_params(labelbottom=False)
            figure.align_ylabels(panels)
        settle(figure)
        _growth(top, at, values, radius, groups, names, [*changes, *zeros])
        if len(panels) > 1:
            _frequencies(lowest, at, values, groups)
        for panel in panels:
            for threshold in changes:
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
    quantity, unit = system.quantities.get(meaning), system.units.get(meaning, "1")
    unit = quantity.kind.label(dimensionless=spectrum.dimensionless) if quantity else unit
    return axis_label(quantity, meaning, unit or "1")


def _growth(
    axes: Axes,
    at: Floats,
    values: Complexes,
    radius: Floats,
    groups: Groups,
    names: Sequence[str],
    exact: Sequence[float],
) -> None:
    """Draw the real parts; growth is shaded, crossings are marked, a number is on each mode."""
    axes.axhline(0, color="0.3", linewidth=0.6)
    for index, columns in enumerate(groups):
        for column in columns:
            axes.plot(
                at,
                values[:, column].real,
                zorder=3,
                label=f"{index + 1}: {names[index]}",
                **_line(index),
            )
    _asinh_scale(axes, "y", values.real, linear_width(values.real, radius))
    axes.axhspan(0, axes.get_ylim()[1], facecolor=SOME_GROWTH, zorder=0)
    zero = float(axes.transAxes.inverted().transform(axes.transData.transform((at[0], 0.0)))[1])
    for word, height, colour in (
        ("growth", (1 + zero) / 2, "#7f2704"),
        ("decay", zero / 2, LIGHT.ramp[0]),
    ):
        look: dict[str, Any] = {"ha": "left", "rotation": 90, "color": colour}
        write(axes, 1.015, height, word, transform=axes.transAxes, **look)
    zeros = crossings(at, values.real, radius, exact)
    if zeros:
        axes.plot(
            zeros,
            np.zeros(len(zeros)),
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


def _line(index: int) -> dict[str, Any]:
    """Colour and line of a mode, the same in both panels."""
    return {"color": _colour(index), "linestyle": DASHES[index % len(DASHES)]}


def _colour(index: int) -> str:
    return MODE_COLOURS[index % len(MODE_COLOURS)]


def _frequencies(axes: Axes, at: Floats, values: Complexes, groups: Groups) -> None:
    """Draw the frequencies where eigenvalues are complex; say so where none is."""
    every = np.abs(values.imag)
    if not every.any():
        words = "no oscillation: every eigenvalue is real"
        write(axes, 0.5, 0.5, words, edge=HALO, transform=axes.transAxes, zorder=5)
        axes.set_yticks([])
        return
    shown = np.ma.masked_equal(every, 0.0)
    for index, columns in enumerate(groups):
        for column in columns:
            axes.plot(at, shown[:, column], **_line(index))
    axes.set_ylim(0, 1.08 * float(every.max()))
    _numbers(axes, at, shown.filled(np.nan), groups)


def _numbers(axes: Axes, at: Floats, values: Floats, groups: Groups) -> None:
    """Write the number of each mode on its curve, where it is farthest from the other curves."""
    point = points(axes)

    def place(column: int) -> Floats:  # along the curve [pt], NaN outside the panel
        pairs = np.column_stack([at, values[:, column]])
        spots = np.asarray(axes.transData.transform(pairs))
        inside = np.isfinite(spots).all(axis=1)
        (x0, y0), (x1, y1) = axes.bbox.min, axes.bbox.max
        x, y = np.nan_to_num(spots).T
        inside &= (x0 + 3 < x) & (x < x1 - 3) & (y0 + 3 < y) & (y < y1 - 3)
        return np.where(inside[:, None], spots, np.nan) * point

    curves = [[place(c) for c in columns] for columns in groups]
    written: list[Floats] = []
    for index, mine in enumerate(curves):
        others = [p for j, c in enumerate(curves) if j != index for p in c]
        # from the middle outward, since the first of equal spots is taken
        picked = [
            int((0.5 + side * off) * (len(at) - 1))
            for off in np.linspace(0, 0.44, 23)
            for side in (1, -1)
        ]
        tries = [p[i] for p in mine for i in picked if np.isfinite(p[i]).all()]
        if not tries:
            continue
        clear = [_clearance(spot, others, written) for spot in tries]
        best = tries[int(np.argmax(clear))]
        written.append(best)
        x, y = axes.transData.inverted().transform(best / point)
        write(axes, x, y, str(index + 1), edge=HALO, color=_colour(index), zorder=4)


def _clearance(spot: Floats, others: list[Floats], written: list[Floats]) -> float:
    """Distance of a number from other curves, at most 12 pt, and from other numbers [pt]."""
    gaps = [12.0, *(float(np.nanmin(np.hypot(*(c - spot).T), initial=99.0)) for c in others)]
    apart = [20.0, *(float(np.hypot(*(w - spot))) for w in written)]
    return min(gaps) + min(apart)


def _plane(
    spectrum: Spectrum, title: str, units: str, ax: Any, width: float | None, fontsize: float | None
) -> Figure:
    """A single spectrum in the plane of eigenvalues: a marker for each, a number for each mode."""
    if ax is not None and (count := len(panels(ax))) != 1:
        raise ParameterError(f"ax holds {count} axes; a single spectrum is drawn on one.")
    verdict = BY_CODE[int(np.ravel(spectrum.codes)[0])].word
    with drawing(ax, width, fontsize, lambda wide: min(0.85 * wide, 1.5 + 0.4 * wide)) as figure:
        axes: Axes = np.ravel(np.asarray(figure.subplots() if ax is None else ax))[0]
        axes.set_xlabel("growth rate Re $\\lambda$" + units)
        axes.set_ylabel("Im $\\lambda$" + units)
        settle(figure)
        key(
            axes,
            _eigenvalues(axes, spectrum),
            f"{title or spectrum.family.name}: {verdict}",
            reach=1.0,
        )
        note(axes, fixed_numbers(spectrum, ""))
    return figure


def _eigenvalues(axes: Axes, spectrum: Spectrum) -> list[Line2D]:
    """Draw the eigenvalues with their errors, and return an entry of the legend for each mode."""
    values, radius = tracked(spectrum)
    (row,), (errors,), (signs,) = values, radius, sure_signs(values.real, radius)
    tall = 1.35 * (float(np.abs(row.imag).max()) or 1.0)
    axes.set_ylim(-tall, tall)
    axes.yaxis.set_major_locator(MaxNLocator(5, steps=[1, 2, 2.5, 5, 10]))
    if not row.imag.any():
        axes.set_yticks([0.0])
    _growth_scale(axes, row.real, np.abs(row.real[signs != 0]))
    axes.axvspan(0, axes.get_xlim()[1], facecolor=SOME_GROWTH, zorder=0)
    axes.axhline(0, color="0.6", linewidth=0.5, zorder=1)
    axes.axvline(0, color="0.3", linewidth=0.8, zorder=1)
    entries, marks = [], []
    groups = mode_groups(values)
    for number, (columns, name) in enumerate(
        zip(groups, mode_names(spectrum, groups, apart=False), strict=True), 1
    ):
        picked = list(columns)
        word, colour, look = LOOKS[int(signs[picked].max())]
        look = look | {"mec": colour, "mew": 0.8, "ls": ""}
        where = row[picked]
        axes.errorbar(
            where.real,
            where.imag,
            errors[picked],
            errors[picked],
            fmt="none",
            ecolor="0.5",
            elinewidth=0.6,
            zorder=2,
        )
        axes.plot(where.real, where.imag, zorder=3, **look)
        entries.append(entry(f"{number}: {word}, {name}", **look))
        marks += [Letter(v.real, v.imag, str(number), colour) for v in where]
    if spectrum.structural_zeros:
        zeros = int(spectrum.structural_zeros)
        look = {"marker": "+", "mec": "black", "ms": 6.0, "mew": 0.9, "ls": ""}
        label = f"{zeros} zero{'s' * (zeros > 1)} by structure"
        axes.plot([0.0], [0.0], zorder=2.5, **look)
        entries.append(entry(label, **look))
    for word, side, place in (("growth", "right", 0.985), ("decay", "left", 0.015)):
        look = {"ha": side, "va": "bottom", "color": "0.25", "zorder": 4}
        write(axes, place, 0.02, word, edge=HALO, transform=axes.transAxes, **look)
    letters(axes, marks, 2.6)
    return entries


def _growth_scale(axes: Axes, real: Floats, sure: Floats) -> None:
    """A linear axis of growth rates, or a logarithmic one where it would hide a sign."""
    largest = float(np.abs(real).max()) or 1.0
    least = float(sure.min(initial=largest))
    if least < PLAIN * largest:
        unit = 10.0 ** math.floor(math.log10(largest))
        linear = max(10.0 ** math.floor(math.log10(least) + 1e-9), LEAST_SHARE * unit)
        _asinh_scale(axes, "x", real, linear)
        return
    ends = [max(1.15 * float((sign * real).max()), SHARE * largest) for sign in (-1, 1)]
    axes.set_xlim(-ends[0], ends[1])
    axes.xaxis.set_major_locator(MaxNLocator(5, steps=[1, 2, 2.5, 5, 10]))


def _asinh_scale(axes: Axes, along: str, real: Floats, linear: float) -> None:
    """An axis of rates over many orders of magnitude on both sides of zero, without a kink."""
    getattr(axes, f"set_{along}scale")("asinh", linear_width=linear)

    def place(value: float) -> float:
        return float(np.arcsinh(value / linear))

    ends = [place(1.6 * max(float((sign * real).max()), linear)) for sign in (-1, 1)]
    ends = [
        max(end, SHARE / (1 - SHARE) * other) for end, other in zip(ends, ends[::-1], strict=True)
    ]
    low, high = (linear * float(np.sinh(end)) for end in ends)
    getattr(axes, f"set_{along}lim")(-low, high)
    box = axes.get_window_extent()
    long, letters_ = (box.height, 1.35) if along == "y" else (box.width, 3.6)
    unit = long * points(axes) / sum(ends)
    gap = letters_ * matplotlib.rcParams["ytick.labelsize"]
    ticks = signed_ticks(lambda v: unit * place(v), -low, high, linear, gap)
    getattr(axes, f"set_{along}ticks")(*ticks)
    axes.minorticks_off()


def fixed_numbers(spectrum: Spectrum, name: str) -> str:
    """The numbers that are the same all over a figure.

    Parameters
    ----------
    spectrum
        The spectrum.
    name
        The quantity that is not, or empty.
    """
    system, law = spectrum.family.system, spectrum.law
    held = {
        spectrum.family.meaning(n): np.ravel(v)[0]
        for n, v in spectrum.values.items()
        if n != name and np.size(v) == 1
    }
    said = law.name if law else system.name if system.quantities else ""
    plain = spectrum.dimensionless
    return fixed(held, system.quantities, system.units, law=said, dimensionless=plain)
