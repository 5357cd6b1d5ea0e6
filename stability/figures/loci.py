"""Eigenvalue loci: growth rate and frequency against the family parameter, modes labelled."""

from __future__ import annotations

from .canvas import COLUMN, STYLE, figure_style, power_of_ten, spacing  # isort: skip

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from ..base.errors import ParameterError, listed
from ..base.quantities import axis_label, in_latex, plain_text
from ..base.types import Complexes, Floats
from ..bodies.thin_disk.disk_quantities import disk_quantities
from ..spectra.result import Spectrum

MODE_COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#000000")
"""Okabe & Ito's colours, safe for colour-blind readers."""
DASHES: tuple[Any, ...] = ("-", (0, (3, 1.5)), (0, (1, 1)), (0, (4, 1.2, 1, 1.2)))
"""Lines of one mode: the second and later ones show only where a pair splits."""
LOCUS_LINEAR = 1e-3
"""Growth rates of the disk below this are drawn on a linear scale."""
LINEAR_SHARE = 1e-3
"""The same for a user's system, over the power of ten of its largest rate."""


def locus(
    spectrum: Spectrum, *, thresholds: Sequence[float] = (), title: str = "",
    unit: str | None = None,
) -> Figure:  # fmt: skip
    r"""Eigenvalues against the swept quantity: growth rate above, frequency below, modes labelled.

    Parameters
    ----------
    spectrum
        Spectrum along one axis, of one quantity given as an array; eigenvalues of shape
        (points, n).
    thresholds
        Values of the swept quantity at which the verdict changes.
    title
        Title of the figure.
    unit
        Unit of rates; that of the spectrum when left out.

    Returns
    -------
    Figure
        One journal column wide.

    Raises
    ------
    ParameterError
        If the spectrum has not one axis, or not one quantity changes along it.

    Examples
    --------
    >>> import stability as st
    >>> s = st.spectrum("rolling", at=[1.5, 2.0], contact=st.Viscous(0.3))
    >>> locus(s).axes[0].get_ylabel()
    'growth rate\nRe $\\lambda$  [$\\sqrt{g/R}$]'
    """
    name, at = swept(spectrum)
    order = spectrum.tracked()
    values = np.take_along_axis(spectrum.eigenvalues, order, axis=-1)
    share = np.take_along_axis(spectrum.modes.participation, order[..., None], axis=1)
    with figure_style(STYLE):
        figure = Figure(figsize=(COLUMN, 3.6), layout="constrained")
        top, bottom = figure.subplots(2, 1, sharex=True, gridspec_kw={"height_ratios": [1.25, 1]})
        spacing(figure, h_pad=0.02, w_pad=0.02)
        groups = mode_groups(values)
        names = [_symbols(spectrum, share, columns) for columns in groups]
        _growth(top, at, values, groups, names, spectrum)
        _frequencies(bottom, at, values, groups)
        for panel in (top, bottom):
            for threshold in thresholds:
                panel.axvline(threshold, color="black", linewidth=0.8, linestyle=(0, (1, 1.5)))
        word = spectrum.rate_unit if unit is None else unit
        units = "" if word in ("1", "") else f"  [{in_latex(word)}]"
        top.set_ylabel("growth rate\nRe $\\lambda$" + units)
        bottom.set_ylabel("frequency\n|Im $\\lambda$|" + units)
        figure.align_ylabels()
        bottom.set_xlabel(_axis(spectrum, name))
        bottom.xaxis.set_major_locator(MaxNLocator(6, steps=[1, 2, 2.5, 5, 10]))
        bottom.set_xlim(float(at.min()), float(at.max()))
        figure.legend(
            *top.get_legend_handles_labels(), loc="outside lower center",
            ncols=3 if max(map(len, names)) < 24 else 2, fontsize=6.5, frameon=False,
            handlelength=1.4, columnspacing=1.0,
        )  # fmt: skip
        if title:
            top.set_title(title, fontsize=8, pad=4)
    return figure


def swept(spectrum: Spectrum) -> tuple[str, Floats]:
    """Name and values of the one quantity that changes along a spectrum.

    Parameters
    ----------
    spectrum
        Spectrum along one axis.

    Returns
    -------
    name, values
        `at` for what names a member of a disk's family; shape (points,).

    Raises
    ------
    ParameterError
        If the spectrum has not one axis, or not one quantity changes along it.
    """
    shape = spectrum.codes.shape
    if len(shape) != 1 or shape[0] < 2:
        raise ParameterError(
            f"the spectrum has shape {shape}; give one along one axis, of two points or more."
        )
    given = spectrum.values or {spectrum.family.at[0]: np.asarray(spectrum.at)[:, 0]}
    along = {n: np.asarray(v, dtype=float) for n, v in given.items() if np.size(v) > 1}
    moved = {n: np.broadcast_to(v, shape) for n, v in along.items() if np.ptp(v) > 0}
    if len(moved) != 1:
        raise ParameterError(
            f"along the spectrum {listed(list(moved) or ['nothing'])} changes; give one quantity "
            "as an array, and the others as numbers."
        )
    return next(iter(moved.items()))


def _axis(spectrum: Spectrum, name: str) -> str:
    """Label of the swept quantity, with the unit of its system."""
    family = spectrum.family
    if spectrum.law is None:
        return axis_label(None, name, family.system.units.get(name, "1"))
    meaning = family.at[0] if name == "at" else name
    known = disk_quantities(type(spectrum.law)).get(meaning)
    unit = known.kind.label(dimensionless=spectrum.dimensionless) if known else "1"
    return axis_label(known, meaning, unit or "1")


def _symbols(spectrum: Spectrum, share: Floats, columns: tuple[int, ...]) -> str:
    """The states that lead a mode, by the symbols of the disk or the names of the user."""
    states = mode_states(share, columns, spectrum.family.system.states)
    known = disk_quantities() if spectrum.law is not None else {}
    return ", ".join(known[s].typeset if s in known else plain_text(s) for s in states)


def _growth(
    axes: Axes, at: Floats, values: Complexes, groups: list[tuple[int, ...]],
    names: Sequence[str], spectrum: Spectrum,
) -> None:  # fmt: skip
    """Draw the real parts; growth is shaded, and a number stands on each mode."""
    axes.axhline(0, color="0.3", linewidth=0.6)
    for index, columns in enumerate(groups):
        for position, column in enumerate(columns):
            axes.plot(at, values[:, column].real, color=MODE_COLOURS[index % len(MODE_COLOURS)],
                      zorder=3, linestyle=DASHES[position % len(DASHES)],
                      label=None if position else f"{index + 1}: {names[index]}")  # fmt: skip
    linear = LOCUS_LINEAR
    largest = float(np.abs(values.real).max())
    if spectrum.law is None:
        linear = LINEAR_SHARE * 10.0 ** math.floor(math.log10(largest or 1.0))
    _locus_limits(axes, largest, linear)
    axes.axhspan(0, axes.get_ylim()[1], facecolor="#fdebdc", zorder=0)
    for word, height, colour in (("growth", 0.75, "#7f2704"), ("decay", 0.25, "#08306b")):
        axes.text(1.015, height, word, transform=axes.transAxes, rotation=90, ha="left",
                  va="center", fontsize=7, color=colour)  # fmt: skip
    _locus_numbers(axes, at, values, groups)


def _frequencies(axes: Axes, at: Floats, values: Complexes, groups: list[tuple[int, ...]]) -> None:
    """Draw the frequencies where eigenvalues are complex; say so where none is."""
    halo = [withStroke(linewidth=2, foreground="white")]
    every = np.abs(values.imag)
    if not every.any():
        axes.text(0.5, 0.5, "no oscillation: every eigenvalue is real", ha="center", va="center",
                  transform=axes.transAxes, fontsize=7, path_effects=halo, zorder=5)  # fmt: skip
        axes.set_yticks([])
        return
    for index, columns in enumerate(groups):
        colour = MODE_COLOURS[index % len(MODE_COLOURS)]
        for column in columns:
            axes.plot(at, np.ma.masked_equal(every[:, column], 0.0), color=colour)
        imaginary = every[:, columns].max(axis=1)
        seen = np.flatnonzero(imaginary)
        if len(seen):
            spot = seen[int((0.3 + 0.2 * index) % 1 * (len(seen) - 1))]
            axes.text(at[spot], imaginary[spot], str(index + 1), color=colour, fontsize=7,
                      ha="center", va="center", path_effects=halo)  # fmt: skip
    axes.set_ylim(0, 1.08 * float(every.max()))


def mode_groups(values: NDArray[np.complex128]) -> list[tuple[int, ...]]:
    """Group tracked eigenvalues by mode: columns that are conjugate somewhere share a mode.

    Where a pair splits and one half meets a third eigenvalue, all three share a mode, so that no
    pair has two colours.

    Parameters
    ----------
    values
        Tracked eigenvalues, shape (points, n).

    Returns
    -------
    list of tuple
        Columns of each mode: one real eigenvalue, a pair, or more that exchange partners.

    Examples
    --------
    >>> mode_groups(np.array([[1 + 1j, -2, 1 - 1j]]))
    [(0, 2), (1,)]
    >>> mode_groups(np.array([[1 + 1j, 1 - 1j, -2], [1, -2 + 1j, -2 - 1j]]))
    [(0, 1, 2)]
    """
    left = list(range(values.shape[1]))
    close = 1e-9 * np.abs(values).max(initial=0.0)
    groups: list[tuple[int, ...]] = []
    while left:
        group, fresh = [], [left.pop(0)]
        while fresh:
            column = fresh.pop()
            group.append(column)
            pair = np.abs(values[:, left].conj() - values[:, [column]]) <= close
            pair &= np.abs(values[:, [column]].imag) > close
            mates = [c for c, together in zip(left, pair.any(axis=0), strict=True) if together]
            fresh += mates
            left = [c for c in left if c not in mates]
        groups.append(tuple(sorted(group)))
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


def _locus_limits(axes: Axes, largest: float, linear: float) -> None:
    # Rates span many orders of magnitude on both sides of zero, and their sign matters most.
    axes.set_yscale("symlog", linthresh=linear, linscale=0.8)
    size = max(largest, 10 * linear)
    axes.set_ylim(-2.5 * size, 2.5 * size)
    powers = [*range(round(np.log10(linear)), math.floor(np.log10(2.5 * size)) + 1)]
    powers = powers[:: 1 + len(powers) // 7]
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
