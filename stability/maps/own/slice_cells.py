"""Verdicts and growth rates of the cells of a map from a slice, without members or matrices."""

from __future__ import annotations

from contextlib import suppress
from typing import Any

import numpy as np

from ...algebra.exact.number_fields import NotExact
from ...base.axis import Axis
from ...base.types import Floats
from ...spectra.problem import Problem
from .rates import MOST_POOR, Bands, Coefficients, Rates, monic, rates, sample
from .slice_record import Slice
from .slice_verdicts import Codes, SliceVerdicts, surface
from .slices import slice_of
from .surfaces import LEAST, Surface, Window, powers

SLICE = (
    "characteristic polynomial of the family over Q in the two axes: verdicts from its conditions "
    "by a floating-point filter with a proved bound, growth rates by Weierstrass' correction with "
    "the discs of Braess and Hadeler; what these leave open in rational arithmetic, or from the "
    "graph by the eigensolver with Gershgorin's discs"
)
"""Method in words."""


class SliceCells(Bands):
    """The cells of a map of a family with a slice.

    Parameters
    ----------
    found
        The slice.
    axes
        x and y.
    modes
        Whether to keep all eigenvalues.
    """

    how = SLICE
    """Method in words."""

    def __init__(self, found: Slice, axes: tuple[Axis, Axis], modes: bool) -> None:
        self.modes = modes
        self.verdicts = SliceVerdicts(found, axes)
        self.windows = Window(axes[0]), Window(axes[1])
        self._factors = [
            ([surface(c, self.windows) if c != 0 else None for c in row], even, count)
            for row, even, count in found.factors
        ]
        present = [s for row, _, _ in self._factors for s in row if s is not None]
        self._degrees = tuple(max(s.degrees[k] for s in present) for k in (0, 1))
        self.growth = bool(self.rates(*sample(axes)).poor.mean() <= MOST_POOR)

    def rates(self, xs: Floats, ys: Floats) -> Rates:
        """Growth rates over a grid, flat, with y outermost.

        Parameters
        ----------
        xs, ys
            Values of the axes.
        """
        with np.errstate(all="ignore"):
            t, s = (
                powers(w(v), d)
                for w, v, d in zip(self.windows, (xs, ys), self._degrees, strict=True)
            )
            parts = [(_coefficients(row, t, s), even, count) for row, even, count in self._factors]
        return rates(parts, modes=self.modes)

    def judged(self, xs: Floats, ys: Floats) -> tuple[Codes, int, Rates]:
        """Flags and growth rates over a grid, flat, as from `SliceVerdicts` and `rates`.

        Parameters
        ----------
        xs, ys
            Increasing values of the axes.
        """
        codes, exact = self.verdicts(xs, ys)
        return codes.reshape(-1), exact, self.rates(xs, ys)


def slice_cells(problem: Problem, axes: tuple[Axis, Axis], modes: bool) -> SliceCells | None:
    """The cells of a map by a slice; None where the family has none.

    Parameters
    ----------
    problem, axes, modes
        As for `stability.maps.cells.Cells`.
    """
    found = slice_of(problem, axes[0].name, axes[1].name)
    with suppress(NotExact):
        return None if found is None else SliceCells(found, axes, modes)
    return None


def _coefficients(row: list[Surface | None], t: Floats, s: Floats) -> Coefficients:
    """Monic coefficients of a factor over a grid, flat."""
    top = max(p.exponent for p in row if p is not None)
    shape = s.shape[1] * t.shape[1]
    values: list[Any] = []
    errors: list[Any] = []
    for p in row:
        if p is None:
            values.append(np.zeros(shape))
            errors.append(np.zeros(shape))
            continue
        value, error = p.product(t, s)
        scale = 2.0 ** (p.exponent - top)  # exact, or zero: LEAST is far above that
        values.append((value * scale).reshape(-1))
        errors.append((error * scale).reshape(-1) + LEAST)
    return monic(values, errors)
