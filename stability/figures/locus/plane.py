"""One spectrum in the plane of eigenvalues; scales and notes that loci share with it."""

from __future__ import annotations

from ..styled_figure import drawing, fixed, key, note, panels, settle, signed_ticks, small  # isort: skip

import math
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patheffects import withStroke
from matplotlib.ticker import MaxNLocator

from ...base.errors import ParameterError
from ...base.quantities import without_dimension
from ...base.types import Floats
from ...base.verdict import BY_CODE
from ...bodies.quantities import disk_quantities
from ...spectra.result import Spectrum
from ..letters import Letter, letters
from .modes import LEAST_SHARE, mode_groups, mode_names, sure_signs, tracked

HALO = [withStroke(linewidth=2, foreground="white")]
SHARE = 0.22
"""Least share of an axis of growth rates on each side of zero."""
PLAIN = 0.03
"""Least rate over the largest one that a linear scale shows apart from zero."""
LOOKS: dict[int, tuple[str, str, dict[str, Any]]] = {
    1: ("growing", "#b34700", {"marker": "^", "mfc": "#d55e00", "ms": 5.0}),
    0: ("near the axis", "#303030", {"marker": "D", "mfc": "white", "ms": 4.0}),
    -1: ("decaying", "#0072b2", {"marker": "o", "mfc": "#0072b2", "ms": 4.2}),
}
"""Word, colour and marker by the sign of the real part, where the error disc leaves no doubt."""


def plane(
    spectrum: Spectrum, title: str, units: str, ax: Any, width: float | None, fontsize: float | None
) -> Figure:
    """A single spectrum in the plane of eigenvalues: a marker for each, a number for each mode.

    Parameters
    ----------
    spectrum
        A single spectrum.
    title, ax, width, fontsize
        As for `plot_locus`; the verdict follows the title.
    units
        Unit of the eigenvalues, as the end of a label.

    Returns
    -------
    Figure
    """
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
    axes.axvspan(0, axes.get_xlim()[1], facecolor="#fdebdc", zorder=0)
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
        entries.append(Line2D([], [], label=f"{number}: {word}, {name}", **look))
        marks += [Letter(v.real, v.imag, str(number), colour) for v in where]
    if spectrum.structural_zeros:
        zeros = int(spectrum.structural_zeros)
        look = {"marker": "+", "mec": "black", "ms": 6.0, "mew": 0.9, "ls": ""}
        label = f"{zeros} zero{'s' * (zeros > 1)} by structure"
        axes.plot([0.0], [0.0], zorder=2.5, **look)
        entries.append(Line2D([], [], label=label, **look))
    for word, side, place in (("growth", "right", 0.985), ("decay", "left", 0.015)):
        axes.text(
            place,
            0.02,
            word,
            transform=axes.transAxes,
            ha=side,
            va="bottom",
            fontsize=small(),
            color="0.25",
            path_effects=HALO,
            zorder=4,
        )
    letters(axes, marks, 2.6)
    return entries


def _growth_scale(axes: Axes, real: Floats, sure: Floats) -> None:
    """A linear axis of growth rates, or a logarithmic one where it would hide a sign."""
    largest = float(np.abs(real).max()) or 1.0
    least = float(sure.min(initial=largest))
    if least < PLAIN * largest:
        unit = 10.0 ** math.floor(math.log10(largest))
        linear = max(10.0 ** math.floor(math.log10(least) + 1e-9), LEAST_SHARE * unit)
        asinh_scale(axes, "x", real, linear)
        return
    ends = [max(1.15 * float((sign * real).max()), SHARE * largest) for sign in (-1, 1)]
    axes.set_xlim(-ends[0], ends[1])
    axes.xaxis.set_major_locator(MaxNLocator(5, steps=[1, 2, 2.5, 5, 10]))


def asinh_scale(axes: Axes, along: str, real: Floats, linear: float) -> None:
    """An axis of rates over many orders of magnitude on both sides of zero, without a kink.

    Parameters
    ----------
    axes
        The panel.
    along
        The axis: x or y.
    real
        Rates to show, of any shape.
    linear
        Size up to which the scale is linear.
    """
    getattr(axes, f"set_{along}scale")("asinh", linear_width=linear)

    def place(value: float) -> float:
        return float(np.arcsinh(value / linear))

    ends = [place(1.6 * max(float((sign * real).max()), linear)) for sign in (-1, 1)]
    ends = [
        max(end, SHARE / (1 - SHARE) * other) for end, other in zip(ends, ends[::-1], strict=True)
    ]
    low, high = (linear * float(np.sinh(end)) for end in ends)
    getattr(axes, f"set_{along}lim")(-low, high)
    box, dpi = axes.get_window_extent(), axes.get_figure(root=True).dpi  # type: ignore[union-attr]
    long, letters_ = (box.height, 1.35) if along == "y" else (box.width, 3.6)
    unit = long * 72 / dpi / sum(ends)
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
    family, law = spectrum.family, spectrum.law
    held = {n: np.ravel(v)[0] for n, v in spectrum.values.items() if n != name and np.size(v) == 1}
    if law is None:
        system = family.system
        body = system.name if system.quantities else ""
        plain = without_dimension(system.quantities, system.units)
        return fixed(held, system.quantities, system.units, law=body, dimensionless=plain)
    return fixed(
        {family.at[0] if n == "at" else n: v for n, v in held.items()},
        disk_quantities(type(law)),
        {},
        law=law.name,
        dimensionless=spectrum.dimensionless,
    )
