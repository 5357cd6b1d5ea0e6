"""Eigenvalue loci: growth rate and frequency against the family parameter, modes labelled."""

from __future__ import annotations

from .canvas import COLUMN, STYLE, figure_style, power_of_ten, spacing  # isort: skip

import math
from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke
from numpy.typing import NDArray

from ..base.quantities import Kind, axis_label, in_latex
from ..bodies.thin_disk.disk_quantities import is_angle, quantities_of
from ..spectra.result import Spectrum

MODE_COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#000000")
"""Okabe & Ito's colours, safe for colour-blind readers."""
LOCUS_LINEAR = 1e-3
"""Growth rates below this are drawn on a linear scale."""


def locus(
    spectrum: Spectrum, *, thresholds: Sequence[float] = (), title: str = "",
    unit: str = Kind.GROWTH_RATE.words,
) -> Figure:  # fmt: skip
    """Eigenvalues against the family parameter: growth rate above, frequency below, modes labelled.

    Parameters
    ----------
    spectrum
        Spectrum along one axis; eigenvalues of shape (points, n).
    thresholds
        Values of the family parameter at which the verdict changes.
    title
        Title of the figure.
    unit
        Unit of rates.

    Returns
    -------
    Figure
        One journal column wide.
    """
    name = spectrum.family.at[0]
    known = quantities_of(spectrum.family.system.name)
    at = np.asarray(spectrum.at)[:, 0]
    order = spectrum.tracked()
    values = np.take_along_axis(spectrum.eigenvalues, order, axis=-1)
    share = np.take_along_axis(spectrum.modes.participation, order[..., None], axis=1)
    with figure_style(STYLE):
        figure = Figure(figsize=(COLUMN, 3.6), layout="constrained")
        top, bottom = figure.subplots(2, 1, sharex=True, gridspec_kw={"height_ratios": [1.25, 1]})
        spacing(figure, h_pad=0.02, w_pad=0.02)
        top.axhspan(0, 1e9, facecolor="#fdebdc", zorder=0)
        top.axhline(0, color="0.3", linewidth=0.6)
        groups = mode_groups(values)
        halo = [withStroke(linewidth=2, foreground="white")]
        for index, columns in enumerate(groups):
            colour = MODE_COLOURS[index % len(MODE_COLOURS)]
            states = mode_states(share, columns, spectrum.family.system.states)
            symbols = [known[s].typeset if s in known else s for s in states]
            text = f"{index + 1}: {', '.join(symbols)}"
            for position, column in enumerate(columns):
                top.plot(at, values[:, column].real, color=colour, zorder=3,
                         linestyle="-" if position == 0 else (0, (3, 1.5)),
                         label=text if position == 0 else None)  # fmt: skip
            imaginary = np.abs(values[:, columns].imag).max(axis=1)
            shown = np.ma.masked_where(imaginary == 0, imaginary)
            bottom.plot(at, shown, color=colour)
            if shown.count():
                spot = np.flatnonzero(imaginary)[int((0.3 + 0.2 * index) % 1 * (shown.count() - 1))]
                bottom.text(at[spot], imaginary[spot], str(index + 1), color=colour, fontsize=7,
                            ha="center", va="center", path_effects=halo)  # fmt: skip
        for panel in (top, bottom):
            for threshold in thresholds:
                panel.axvline(threshold, color="black", linewidth=0.8, linestyle=(0, (1, 1.5)))
        _locus_limits(top, values)
        for word, height, colour in (("growth", 0.75, "#7f2704"), ("decay", 0.25, "#08306b")):
            top.text(1.015, height, word, transform=top.transAxes, rotation=90, ha="left",
                     va="center", fontsize=7, color=colour)  # fmt: skip
        _locus_numbers(top, at, values, groups)
        units = in_latex(unit)
        top.set_ylabel(rf"growth rate Re $\lambda$  [{units}]")
        bottom.set_ylabel(rf"frequency |Im $\lambda$|  [{units}]")
        if name not in known or is_angle(name):
            unit = spectrum.family.system.units.get(name, "1")
        bottom.set_xlabel(axis_label(known.get(name), name, unit))
        bottom.set_xlim(at[0], at[-1])
        bottom.set_ylim(bottom=0)
        figure.legend(
            *top.get_legend_handles_labels(), loc="outside lower center", ncols=3, fontsize=6.5,
            frameon=False, handlelength=1.4, columnspacing=1.0,
        )  # fmt: skip
        if title:
            top.set_title(title, fontsize=8, pad=4)
    return figure


def mode_groups(values: NDArray[np.complex128]) -> list[tuple[int, ...]]:
    """Group tracked eigenvalues by mode: columns that are conjugate somewhere share a mode.

    Parameters
    ----------
    values
        Tracked eigenvalues, shape (points, n).

    Returns
    -------
    list of tuple
        Columns of each mode: a pair, or one real eigenvalue.

    Examples
    --------
    >>> mode_groups(np.array([[1 + 1j, -2, 1 - 1j]]))
    [(0, 2), (1,)]
    """
    count = values.shape[1]
    left = list(range(count))
    groups: list[tuple[int, ...]] = []
    while left:
        first = left.pop(0)
        pair = np.abs(values[:, left].conj() - values[:, [first]]) <= 1e-9 * np.abs(values).max()
        pair &= np.abs(values[:, [first]].imag) > 0
        mates = list(zip(pair.sum(axis=0).tolist(), left, strict=True))
        together, mate = max(mates, default=(0, -1))
        if together:
            left.remove(mate)
            groups.append((first, mate))
        else:
            groups.append((first,))
    return groups


def mode_states(
    share: NDArray[np.float64], columns: tuple[int, ...], states: Sequence[str]
) -> list[str]:
    """The states that lead a mode, on average along the branch.

    Parameters
    ----------
    share
        Participation, shape (points, n, states).
    columns
        The mode's columns.
    states
        State names.

    Returns
    -------
    list of str
        One or two names, in the order of the states.
    """
    mean = share[:, list(columns)].mean(axis=(0, 1))
    lead = np.argsort(-mean, kind="stable")
    count = 1 if mean[lead[0]] > 0.8 else 2
    return [states[i] for i in sorted(lead[:count])]


def _locus_limits(axes: Axes, values: NDArray[np.complex128]) -> None:
    # Rates span many orders of magnitude on both sides of zero, and their sign matters most.
    axes.set_yscale("symlog", linthresh=LOCUS_LINEAR, linscale=0.8)
    size = max(float(np.abs(values.real).max()), 10 * LOCUS_LINEAR)
    axes.set_ylim(-2.5 * size, 2.5 * size)
    powers = range(round(np.log10(LOCUS_LINEAR)), math.floor(np.log10(2.5 * size)) + 1)
    ticks = [-(10.0**p) for p in reversed(powers)] + [0.0] + [10.0**p for p in powers]
    axes.set_yticks(ticks, [power_of_ten(t) for t in ticks])
    axes.minorticks_off()


def _locus_numbers(
    axes: Axes,
    at: NDArray[np.float64],
    values: NDArray[np.complex128],
    groups: list[tuple[int, ...]],
) -> None:
    """Write the number of each mode on its curve, spread along the axis against overlaps."""
    halo = [withStroke(linewidth=2, foreground="white")]
    low, high = axes.get_ylim()
    for index, columns in enumerate(groups):
        colour = MODE_COLOURS[index % len(MODE_COLOURS)]
        real = values[:, columns[0]].real
        visible = np.flatnonzero((real > low) & (real < high))
        if not len(visible):
            continue
        spot = visible[int((0.12 + 0.2 * index) % 1 * (len(visible) - 1))]
        axes.text(at[spot], real[spot], str(index + 1), color=colour, fontsize=7, ha="center",
                  va="center", path_effects=halo, zorder=4)  # fmt: skip
