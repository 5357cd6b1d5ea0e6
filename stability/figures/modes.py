"""Modes of a spectrum along one quantity: which eigenvalues they hold, their names, crossings."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..base.errors import ParameterError, listed
from ..base.quantities import plain_text
from ..base.types import Complexes, Floats
from ..spectra.result import Spectrum

LINEAR_SHARE, LEAST_SHARE = 1e-3, 1e-9
"""Largest and smallest linear part of the axis, over the power of ten of the largest rate."""


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
            f"the spectrum has shape {shape}; give a single one, or one along one axis."
        )
    quantities = spectrum.values or {spectrum.family.at[0]: np.asarray(spectrum.at)[:, 0]}
    solved = spectrum.family.trimmed
    several = {n: v for n, v in quantities.items() if np.size(v) > 1 and n not in solved}
    along = {n: np.asarray(v, dtype=float) for n, v in several.items()}
    moved = {n: np.broadcast_to(v, shape) for n, v in along.items() if np.ptp(v) > 0}
    if len(moved) != 1:
        raise ParameterError(
            f"along the spectrum {listed(list(moved) or ['nothing'])} changes; give one quantity "
            "as an array, and the others as numbers."
        )
    return next(iter(moved.items()))


def even_in_logarithm(at: Floats) -> bool:
    """Whether three points or more have equal ratios, and not equal steps.

    Examples
    --------
    >>> even_in_logarithm(np.geomspace(0.1, 50, 9)), even_in_logarithm(np.linspace(0.1, 50, 9))
    (True, False)
    """
    if len(at) < 3 or not (at > 0).all():
        return False
    steps = np.diff(np.log(at))
    return bool(np.allclose(steps, steps[0], rtol=1e-6, atol=0) and abs(steps[0]) > 1e-3)


def tracked(spectrum: Spectrum) -> tuple[Complexes, Floats]:
    """Eigenvalues followed along a spectrum, and the radii of their error discs, (points, n)."""
    order = _order(spectrum)
    values, radius = spectrum.eigenvalues.reshape(order.shape), spectrum.radius.reshape(order.shape)
    return np.take_along_axis(values, order, axis=-1), np.take_along_axis(radius, order, axis=-1)


def _order(spectrum: Spectrum) -> NDArray[np.intp]:
    """Order of the eigenvalues at each point that follows the modes; one row if it is single."""
    if spectrum.codes.size > 1:
        return spectrum.tracked()
    return np.arange(spectrum.eigenvalues.shape[-1])[None]


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


def mode_states(share: Floats, columns: Sequence[int], states: Sequence[str]) -> list[str]:
    """The states of a mode by their share, on average along the branch, the largest first.

    Parameters
    ----------
    share
        Participation, shape (points, n, states).
    columns
        The mode's columns.
    states
        State names.
    """
    mean = share[:, list(columns)].mean(axis=(0, 1))
    return [states[i] for i in np.argsort(-mean, kind="stable")]


def mode_names(
    spectrum: Spectrum, groups: Sequence[tuple[int, ...]], *, apart: bool = True
) -> list[str]:
    """A name for each mode: the states that lead it.

    Parameters
    ----------
    spectrum
        The spectrum.
    groups
        Columns of each mode among the tracked eigenvalues.
    apart
        Whether a name has as many states as it takes to have no name twice; otherwise at most two.

    Returns
    -------
    list of str
        Symbols of the disk, or names of the user.
    """
    states, order = spectrum.family.system.states, _order(spectrum)
    share = spectrum.modes.participation.reshape(*order.shape, len(states))
    share = np.take_along_axis(share, order[..., None], axis=1)
    leads = [mode_states(share, columns, states) for columns in groups]
    mean = [share[:, list(columns)].mean(axis=(0, 1)).max() for columns in groups]
    count = [1 if largest > 0.8 else min(2, len(states)) for largest in mean]

    def names() -> list[frozenset[str]]:
        return [frozenset(lead[:n]) for lead, n in zip(leads, count, strict=True)]

    for _ in states if apart else ():
        labels = names()
        twice = [i for i, name in enumerate(labels) if labels.count(name) > 1]
        count = [n + (i in twice and n < len(states)) for i, n in enumerate(count)]
    quantities = spectrum.family.system.quantities
    return [
        ", ".join(
            quantities[s].typeset if s in quantities else plain_text(s) for s in states if s in name
        )
        for name in names()
    ]


def sure_signs(real: Floats, radius: Floats) -> NDArray[np.int8]:
    """Sign of each real part; 0 where its error disc reaches the axis."""
    return np.where(np.abs(real) > radius, np.sign(real), 0).astype(np.int8)


def changes_of_sign(at: Floats, real: Floats, radius: Floats) -> list[tuple[float, float, float]]:
    """Where a real part changes its sign: two neighbouring points, and a straight line's zero.

    Parameters
    ----------
    at
        Swept quantity, shape (points,).
    real, radius
        Real parts and radii of the error discs of tracked eigenvalues, shape (points, n).

    Returns
    -------
    list of (low, high, value)
        The two halves of a pair both give one.
    """
    changes = []
    for values, signs in zip(real.T, sure_signs(real, radius).T, strict=True):
        sure = np.flatnonzero(signs)
        for i, j in zip(sure[:-1], sure[1:], strict=True):
            if signs[i] != signs[j] and j - i <= 2:  # a longer stretch on the axis is no crossing
                share = values[i] / (values[i] - values[j])
                low, high = sorted((float(at[i]), float(at[j])))
                changes.append((low, high, float(at[i] + share * (at[j] - at[i]))))
    return changes


def crossings(at: Floats, real: Floats, radius: Floats, zeros: Sequence[float] = ()) -> list[float]:
    """Places where a real part changes its sign, of those that are known; no other is marked.

    Parameters
    ----------
    at, real, radius
        As for `changes_of_sign`.
    zeros
        Zeros of growth rates, as `boundaries` proves them.  Of several between the same points
        that nearest to a straight line is taken.

    Returns
    -------
    list of float
        Rising; the two halves of a pair give one place.

    Examples
    --------
    >>> at, real = np.array([0.0, 1.0]), np.array([[-1.0, 2.0], [3.0, 1.0]])
    >>> crossings(at, real, np.zeros((2, 2)), [0.3]), crossings(at, real, np.zeros((2, 2)))
    ([0.3], [])
    """
    exact, places = np.asarray(zeros, dtype=float), []
    for low, high, value in changes_of_sign(at, real, radius):
        near = exact[(low <= exact) & (exact <= high)]
        if len(near):
            places.append(float(near[np.abs(near - value).argmin()]))
    close = 1e-6 * float(np.ptp(at))
    places.sort()
    return [v for i, v in enumerate(places) if not i or v - places[i - 1] > close]


def linear_width(real: Floats, radius: Floats) -> float:
    """Size up to which rates are drawn on a linear scale: small enough to show every arc.

    Parameters
    ----------
    real, radius
        As for `crossings`.

    Returns
    -------
    float
        At most a third of the height of the lowest arc between two crossings, as a power of ten.
    """
    scale = 10.0 ** math.floor(math.log10(float(np.abs(real).max()) or 1.0))
    lowest = LINEAR_SHARE * scale
    for values, signs in zip(real.T, sure_signs(real, radius).T, strict=True):
        kept = np.abs(values[signs != 0])
        cuts = np.flatnonzero(np.diff(signs[signs != 0])) + 1
        if len(cuts):
            lowest = min([lowest, *(float(arc.max()) / 3 for arc in np.split(kept, cuts))])
    return max(10.0 ** math.floor(math.log10(lowest) + 1e-9), LEAST_SHARE * scale)
