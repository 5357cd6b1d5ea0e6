"""Proved verdicts over a grid from a slice: whole tiles at once, then cells, then over Q."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from functools import cached_property
from math import gcd
from typing import Any

import numpy as np

from ..algebra.exact.number_fields import NotExact
from ..base.axis import Axis
from ..base.types import Floats
from ..base.verdict import CODES, Verdict, best
from ..spectra.certificate import verdict
from ..spectra.problem import Problem
from .slices import BallPolynomial, SignProduct, Slice, slice_of
from .surfaces import Box, Signs, Surface, Window, powers
from .tiles import Codes, Ends, tiled

SIDES = (64, 16)
"""Cells along the side of a tile, coarse to fine."""
MESH = 64
"""Boxes along each axis on which every point is proved to be a member."""
ELSEWHERE = -1
"""Flag of a cell that the slice leaves open: perhaps no member, or a sign that balls leave open."""


class SliceVerdicts:
    """Verdicts of the members in the axes of a map.

    Parameters
    ----------
    problem
        Problem of the family.
    slice_
        Its slice in the axes.
    axes
        x and y.

    Examples
    --------
    >>> from stability.bodies.contact_laws import Viscous
    >>> from stability.bodies.disk import Disk
    >>> from stability.spectra.problem import disk_problem
    >>> problem = disk_problem("rolling", Disk(), Viscous(1.0), 1.0)
    >>> axes = Axis("at", 1.0, 2.0, 200), Axis("mu", 0.1, 1.0, 100)
    >>> codes, exact = slice_verdicts(problem, axes)(axes[0].values, axes[1].values)
    >>> codes.shape, np.unique(codes).tolist(), exact
    ((100, 200), [1, 2], 0)
    """

    def __init__(self, problem: Problem, slice_: Slice, axes: tuple[Axis, Axis]) -> None:
        self.problem, self.slice, self.axes = problem, slice_, axes
        self.windows = windows_of(slice_, axes)
        self.surfaces = [surface(p, self.windows) for p in slice_.surfaces]
        self.degrees = tuple(max((s.degrees[k] for s in self.surfaces), default=0) for k in (0, 1))
        self.good = CODES[best(even=slice_.even)]
        x, y = ((np.array([g.low]), np.array([g.high])) for g in axes)
        with np.errstate(all="ignore"):
            self.known = self._over(x, y, np.zeros((len(self.surfaces), 1)))
        """Signs of the surfaces that are one on all of the map, 0 for the others."""

    @cached_property
    def everywhere(self) -> bool:
        """Whether every point of the map is proved to be a member at which the slice holds."""
        edges = [np.linspace(g.low, g.high, MESH + 1) for g in self.axes]
        x, y = (
            [v.ravel() for v in np.meshgrid(*pair)]
            for pair in zip(*((e[:-1], e[1:]) for e in edges), strict=True)
        )
        with np.errstate(all="ignore"):
            signs = self._over((x[0], y[0]), (x[1], y[1]), np.repeat(self.known, MESH**2, axis=1))
        return bool(self._member(signs).all())

    # --- signs to flags ---

    def _member(self, signs: Any) -> Any:
        """Where the signs prove a member at which the slice holds."""
        count = signs.shape[1]
        out = np.ones(count, dtype=bool)
        for condition in self.slice.required:
            out &= _product(condition, signs, count) > 0
        for condition in self.slice.nonzero:
            out &= _product(condition, signs, count) != 0
        return out

    def _codes(self, signs: Any) -> Codes:
        """Flags from the signs of the surfaces, 0 where these do not decide."""
        count = signs.shape[1]
        good, bad = np.ones(count, dtype=bool), np.zeros(count, dtype=bool)
        for condition in self.slice.conditions:
            sign = _product(condition, signs, count)
            good, bad = good & (sign > 0), bad | (sign < 0)
        codes: Any = good * np.int8(self.good) + bad * np.int8(CODES[Verdict.UNSTABLE])
        codes[~self._member(signs)] = 0
        return np.asarray(codes, dtype=np.int8)

    def _over(self, x: Ends, y: Ends, signs: Any) -> Signs:
        """Signs over boxes; those known already stay."""
        t, s = (w.ends(*ends) for w, ends in zip(self.windows, (x, y), strict=True))
        signs, box = signs.astype(np.int8), Box(t, s, self.degrees)
        for row, polynomial in zip(signs, self.surfaces, strict=True):
            left = np.flatnonzero(row == 0)
            if not len(left):
                continue
            if len(left) == len(row):
                row[:] = polynomial.over(box)
            else:
                row[left] = polynomial.over(box.take(left))
        out: Signs = signs
        return out

    def boxes(self, spans: Mapping[str, tuple[Floats, Floats]]) -> Codes:
        """Flags proved over whole boxes inside the map, 0 where none is."""
        x, y = (spans[g.name] for g in self.axes)
        with np.errstate(all="ignore"):
            return self._codes(self._over(x, y, np.repeat(self.known, len(x[0]), axis=1)))

    # --- a grid ---

    def __call__(self, xs: Floats, ys: Floats, proved: Codes | None = None) -> tuple[Codes, int]:
        """Flags over a grid inside the map.

        Parameters
        ----------
        xs, ys
            Increasing values of the axes.
        proved
            Flags that are proved already, flat, 0 for others; they change in place.

        Returns
        -------
        codes, exact
            Flags, shape (y, x), `ELSEWHERE` where the slice has none; and how many cells were
            decided over Q.
        """
        with np.errstate(all="ignore"):
            if proved is not None:
                left = np.flatnonzero(proved == 0)
                proved[left], exact = self.at(xs, ys, *np.divmod(left, len(xs)))
                return proved.reshape(len(ys), len(xs)), exact
            padded, i, j, signs = tiled(xs, ys, SIDES, self._tiles, self.known)
            exact = self._single(padded, i, j, signs, xs, ys) if len(i) else 0
            return padded[: len(ys), : len(xs)], exact

    def _tiles(self, x: Ends, y: Ends, signs: Any) -> tuple[Codes, Signs]:
        signs = self._over(x, y, signs)
        return self._codes(signs), signs

    def _single(self, padded: Codes, i: Any, j: Any, signs: Any, xs: Floats, ys: Floats) -> int:
        """Flags of the cells of the last tiles, into their places."""
        side = SIDES[-1]
        steps = np.arange(side)
        rows, columns = (
            np.minimum(first[:, None] * side + steps, len(v) - 1) for first, v in ((i, ys), (j, xs))
        )
        grid = self.windows[0](xs)[columns], self.windows[1](ys)[rows]
        ends = [(v.min(axis=1), v.max(axis=1)) for v in grid]  # a sine may turn inside a tile
        box = Box(ends[0], ends[1], self.degrees)
        offsets = [v - middle[:, None] for v, middle in zip(grid, box.middle, strict=True)]
        cells = np.repeat(signs, side * side, axis=1).reshape(len(signs), -1, side, side)
        for row, before, polynomial in zip(cells, signs, self.surfaces, strict=True):
            left = np.flatnonzero(before == 0)
            if len(left):
                row[left] = polynomial.inside(box.take(left), *(v[left] for v in offsets))
        codes = self._codes(cells.reshape(len(signs), -1))
        left = np.flatnonzero(codes == 0)
        tile, rest = np.divmod(left, side * side)
        place = rows[tile, rest // side], columns[tile, rest % side]
        some = cells.reshape(len(signs), -1)[:, left]
        codes[left], exact = self._each(some, xs, ys, *place)
        whole = padded.reshape(padded.shape[0] // side, side, padded.shape[1] // side, side)
        whole[i, :, j, :] = codes.reshape(-1, side, side)
        return exact

    def at(self, xs: Floats, ys: Floats, rows: Any, columns: Any) -> tuple[Codes, int]:
        """Flags of single cells, and how many of them were decided over Q."""
        signs = np.repeat(self.known, len(rows), axis=1)
        return self._each(signs, xs, ys, rows, columns)

    def _each(
        self, signs: Any, xs: Floats, ys: Floats, rows: Any, columns: Any
    ) -> tuple[Codes, int]:
        """The same from signs that are known: by the surfaces that are open, then over Q."""
        if not len(rows):
            return np.empty(0, dtype=np.int8), 0
        t, s = (
            powers(w(v), d) for w, v, d in zip(self.windows, (xs, ys), self.degrees, strict=True)
        )
        for row, polynomial in zip(signs, self.surfaces, strict=True):
            left = np.flatnonzero(row == 0)
            if len(left):
                row[left] = polynomial.at(t[:, columns[left]], s[:, rows[left]])
                self._twice(polynomial, row, xs, ys, rows, columns)
        codes = self._codes(signs)
        by_place: dict[tuple[int, int], int] = {}
        for place in np.flatnonzero(codes == 0):
            key = int(rows[place]), int(columns[place])
            if key not in by_place:  # tiles that reach beyond the grid repeat its last cells
                by_place[key] = self._exactly(float(xs[key[1]]), float(ys[key[0]]))
            codes[place] = by_place[key]
        return codes, len(by_place)

    def _twice(
        self, polynomial: Surface, row: Signs, xs: Floats, ys: Floats, rows: Any, columns: Any
    ) -> None:
        """Signs that are open, from pairs of doubles."""
        left = np.flatnonzero(row == 0)
        if len(left) and polynomial.rest is not None:
            x, i = np.unique(xs[columns[left]], return_inverse=True)
            y, j = np.unique(ys[rows[left]], return_inverse=True)
            row[left] = polynomial.surely(self.windows[0].pairs(x), self.windows[1].pairs(y), j, i)

    def _exactly(self, x: float, y: float) -> int:
        """The flag of one cell by exact arithmetic, `ELSEWHERE` where the slice has none."""
        proved = self.slice.verdict(x, y)
        if proved is None and self.problem.derived:
            swept = {self.axes[0].name: x, self.axes[1].name: y}
            values = {n: float(v) for n, v in (dict(self.problem.values) | swept).items()}
            return CODES[verdict(self.problem, values)]
        return ELSEWHERE if proved is None else CODES[proved]


def slice_verdicts(problem: Problem, axes: tuple[Axis, Axis]) -> SliceVerdicts | None:
    """Verdicts from the slice of a problem; None where it has none, or no conditions."""
    section = slice_of(problem, axes[0].name, axes[1].name)
    with suppress(NotExact):
        return None if section is None else SliceVerdicts(problem, section, axes)
    return None


def windows_of(slice_: Slice, axes: tuple[Axis, Axis]) -> tuple[Window, Window]:
    """Windows of the variables of a slice."""
    x, y = (gcd(*some) for some in zip(*slice_.exponents, (0, 0), strict=True))
    first, second = slice_.functions
    return Window(axes[0], first, x or 1), Window(axes[1], second, y or 1)


def surface(poly: Any, windows: tuple[Window, Window]) -> Surface:
    """A polynomial of a slice, over the windows of a map.

    Parameters
    ----------
    poly
        An `fmpq_mpoly` in x, y and λ, without λ.
    windows
        Windows of x and y.
    """
    p, q = (w.power for w in windows)
    if isinstance(poly, BallPolynomial):
        return Surface({(i // p, j // q): c for (i, j), c in poly.terms.items()}, windows)
    return Surface(
        {(int(e[0]) // p, int(e[1]) // q): c for e, c in poly.to_dict().items()}, windows
    )


def _product(condition: SignProduct, signs: Any, count: int) -> Signs:
    """Sign of a product of powers; 0 where one is open."""
    out: Signs = np.full(count, condition.sign, dtype=np.int8)
    for place, power in condition.powers:
        out = out * (signs[place] if power % 2 else np.abs(signs[place]))
    return out
