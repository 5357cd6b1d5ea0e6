"""Growth rates of a grid by compiled loops, from the surfaces of its coefficients."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ...algebra.kernels import pairs
from ...algebra.kernels.compiled import compiled
from ...algebra.running_error import UNIT
from ...base.types import Floats
from ...base.verdict import CODES, Verdict, best
from ..rates import PROVED, Coefficients, Rates
from ..surfaces import LEAST, Surface
from . import factors, loops

TINIEST = 1e-30
"""Least scaled number but zero for which no step underflows."""


class CompiledRates:
    """Growth rates over grids by compiled loops.

    Parameters
    ----------
    rows
        Surfaces of the coefficients of each factor, None for zero, lowest power first.
    even
        Whether the polynomial is even.
    """

    def __init__(self, rows: Sequence[Sequence[Surface | None]], *, even: bool) -> None:
        every = [[c for c in row if c is not None] if even else row for row in rows]
        order = self.order = sorted(range(len(every)), key=lambda i: -len(every[i]))
        """Places of the factors, the largest degree first."""
        shapes = [c.matrix.shape for row in every for c in row if c is not None]
        whole = max(n for n, _ in shapes), max(n for _, n in shapes)
        tables: list[Floats] = []
        degrees, bounds, starts = [], [], []
        for place in order:
            row = every[place]
            starts.append((len(tables), len(row) - 1))
            top = max(c.exponent for c in row if c is not None)
            for c in row:
                table = np.zeros((2, *whole))
                if c is not None and c.rest is not None:
                    n, m = c.matrix.shape
                    scale = 2.0 ** (c.exponent - top)
                    table[:, :n, :m] = c.matrix * scale, c.rest * scale
                tables.append(table)
                degrees.append(0 if c is None else c.degrees[0])
                bounds.append((0.0 if c is None else 1.02 * c.roundings * UNIT, LEAST))
        high, self.rest = np.array(tables).swapaxes(0, 1).copy()
        self.table = high, np.array(degrees), np.array(bounds), np.array(starts)
        self.even = even
        self.flags = *_flags(even=even), PROVED

    @classmethod
    def of(cls, rows: Sequence[Sequence[Surface | None]], *, even: bool) -> CompiledRates | None:
        """The same, or None where the loops have no such degrees."""
        degrees = sorted((len(row) - 1 for row in rows), reverse=True)
        exact = all(c is None or c.rest is not None for row in rows for c in row)
        odd = degrees[0] in (1, 3, 5) and all(n == 1 for n in degrees[1:]) and sum(degrees) <= 6
        return cls(rows, even=even) if exact and (degrees == [2] if even else odd) else None

    def __call__(
        self,
        place: tuple[Any, Any],
        unit: Any,
        out: tuple[Any, ...] | None = None,
    ) -> Rates | None:
        """Growth rates of a grid, flat, with flags that the bounds prove, 0 for others.

        None where a number is too small.

        Parameters
        ----------
        place
            Scaled numbers of the axes as pairs of doubles.
        unit
            Unit of the rates, which broadcasts to rows and columns.
        out
            Four contiguous arrays to fill, of shape (N,): three for rates, one for flags; new ones
            when left out.
        """
        xs, ys = (np.array(v) for v in place)
        if not (in_range(xs[0]) and in_range(ys[0])):
            return None
        count = xs.shape[1] * ys.shape[1]
        units = np.atleast_2d(np.asarray(unit, dtype=float))
        down, across = (units.shape[1] if units.shape[0] > 1 else 0), int(units.shape[1] > 1)
        scale = units.reshape(-1), down, across
        top, error, turn, codes = out or (
            *(np.empty(count) for _ in range(3)),
            np.empty(count, np.int8),
        )
        left, kept = np.empty(count, dtype=np.int64), np.empty((self.table[3][0, 1], count))
        run = compiled(pairs, factors, loops)
        how = scale, self.even, self.flags, (top, error, turn), codes
        open_cells = run.sweep(self.table, xs[0], ys[0], *how, left, kept)
        if open_cells:
            starts = left[:open_cells].copy(), np.ascontiguousarray(kept[:, :open_cells])
            open_cells = run.refine(self.table, self.rest, xs, ys, *how, *starts, left, kept)
        return _collected((top, error, turn), codes, left[:open_cells])


def _flags(*, even: bool) -> tuple[float, float]:
    """Flags of stable and unstable cells."""
    return float(CODES[best(even=even)]), float(CODES[Verdict.UNSTABLE])


def of_coefficients(coefficients: Coefficients, columns: int, wanted: float) -> Rates:
    """Growth rates by compiled loops from monic coefficients of degree 3 to 5 over a grid, flat.

    Flags are 0 in cells whose bound is not good, which are poor.
    """
    a, e = (np.ascontiguousarray(some) for some in coefficients)
    degree, count = a.shape
    out = np.empty(count), np.empty(count), np.empty(count)
    codes = np.empty(count, dtype=np.int8)
    left, kept = np.empty(count, dtype=np.int64), np.empty((degree, count))
    flags = *_flags(even=False), wanted
    run = compiled(pairs, factors, loops).sweep_cells
    open_cells = run(a, e, columns, flags, out, codes, left, kept)
    return _collected(out, codes, left[:open_cells])


def _collected(rates: tuple[Floats, Floats, Floats], codes: Any, left: Any) -> Rates:
    """Abscissa, error and frequency with flags; the cells that are left are poor."""
    poor = np.zeros(len(codes), dtype=bool)
    poor[left] = True
    return Rates(*rates, codes, None, poor)


def in_range(values: Floats) -> bool:
    """Whether numbers are zero, or of a size whose products do not underflow."""
    size = np.abs(values)
    return bool(((size == 0) | (size > TINIEST)).all())
