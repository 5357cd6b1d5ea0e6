"""Verdicts and growth rates of the cells of a map: from formulas, from a slice, or from any graph.

Formulas and slices need no members and no matrices; of a graph most cells take the polynomials of
their matrices.  Each coefficient of the characteristic polynomial comes with a bound on its
rounding error, so the discs about its roots hold the eigenvalues.  Cells whose numbers are not
proved to be those of a member, or whose discs decide nothing, are left to the graph.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..algebra.exact.number_fields import NotExact
from ..algebra.kernels.compiled import numba_found
from ..algebra.number_types import numpy_algebra
from ..algebra.real_factors import Factors
from ..algebra.running_error import TRACKED, RunningError, tracked
from ..base.axis import Axis
from ..base.errors import DomainError
from ..base.types import Floats
from ..base.verdict import CODES, NO_MEMBER, Verdict
from ..polynomials.identities import certain, symmetric
from ..spectra.deflation import Reduced, deflate
from ..spectra.eigenvalues import decide, eigenvalues, unstable_in_discs
from ..spectra.problem import Problem, formulas_of
from ..storage.pieces import Chunk
from ..systems.closed_form import ClosedForm, ImplicitForm
from ..systems.structure.structural_zeros import structure
from .compiled.rates import CompiledRates, of_coefficients
from .compiled.swept import swept
from .rates import (
    PROVED,
    WANTED,
    Coefficients,
    Rates,
    arrays_of,
    monic,
    of_eigenvalues,
    of_matrices,
    rates,
)
from .slices import Slice, slice_of
from .surfaces import LEAST, Surface, powers
from .tiles import Codes
from .verdicts import ELSEWHERE, SliceVerdicts, surface

FORMULAS = (
    "characteristic polynomial of the family by formulas in its numbers: coefficients with bounds "
    "on every rounding, growth rates and verdicts from real factors with Gershgorin bounds; what "
    "these leave open from the graph by the eigensolver with Gershgorin's discs"
)
"""Method in words."""
LOOPS = "; compiled loops"
"""What is added to it where loops run over the cells."""
COMPILED_FROM = 10**6
"""Fewest cells for which compiled loops are loaded, which takes as long as these by NumPy."""
FLAGS = CODES[Verdict.NEUTRAL], CODES[Verdict.UNSTABLE], ELSEWHERE, NO_MEMBER
"""Flags of neutral and unstable cells, of cells that are left open, and of none."""
BLOCK = 16384
"""Cells that are computed at once: few enough for the cache."""
NUMPY = numpy_algebra()
Along = Callable[[list[list[Any]]], Any]
"""Formulas of family parameters and parameters of a block, begun for the values of x."""
TRIED = 16
"""Cells along each axis on which discs are tried before a map."""
MOST_POOR = 0.25
"""Share of these cells beyond which the graph takes all cells."""
LEFT = "left"
"""Key in a chunk, in addition to its arrays: number of cells sent to exact arithmetic."""
Room = tuple[Any, ...]
"""Arrays for abscissa, bound on its error, |imaginary part| and flags, each flat."""


def may_sweep(axes: tuple[Axis, Axis], modes: bool) -> bool:
    """Whether compiled loops may run over the cells of a map."""
    many = axes[0].count * axes[1].count >= COMPILED_FROM
    return many and not modes and numba_found()


Parts = Sequence[tuple[Coefficients, bool, int]]
"""Monic coefficients with bounds, whether even, and the multiplicity, of each factor."""


def in_loops(parts: Parts) -> bool:
    """Whether compiled loops know the degrees of the factors of a polynomial."""
    (a, _), even, _ = parts[0]
    return len(parts) == 1 and not even and 3 <= len(a) <= 5


def _rates(parts: Parts, shape: tuple[int, int], *, modes: bool, loops: bool) -> Rates:
    """Growth rates of a grid; by compiled loops where these are wanted and know the degree."""
    if not (loops and in_loops(parts)):
        return rates(parts, shape, modes=modes)
    (a, e), even, _ = parts[0]
    growth = of_coefficients((a, e), shape[1], WANTED)
    left = np.flatnonzero(growth.poor)
    if len(left):
        some: Coefficients = [v[left] for v in a], [v[left] for v in e]
        growth.put(left, rates([(some, even, 1)], (1, len(left)), modes=modes))
    return growth


class Bands(ABC):
    """The cells of a map by a polynomial, many rows at a time.

    Parameters
    ----------
    problem
        Problem of the family.
    axes
        x and y.
    modes
        Whether to keep all eigenvalues.
    """

    how: str
    """Method in words."""
    growth: bool
    """Whether the discs are good enough for growth rates."""
    complete = False
    """Whether no cell is left to the graph."""
    swept = False
    """Whether compiled loops do all the work, so that many rows at once need no more memory."""
    looped: bool
    """Whether compiled loops take the coefficients of the cells."""

    def __init__(self, problem: Problem, axes: tuple[Axis, Axis], modes: bool) -> None:
        self.problem, self.modes = problem, modes
        self.axes = axes[0].name, axes[1].name
        x, y = (g.values[:: max(1, g.count // TRIED)] for g in axes)
        self._sample = x, y
        self._may_sweep, self.looped = may_sweep(axes, modes), False

    @abstractmethod
    def judged(self, xs: Floats, ys: Floats, room: Room | None) -> tuple[Codes, int, Rates]:
        """Flags, `ELSEWHERE` where none is proved, cells decided over Q, and growth rates, flat."""

    def band(self, xs: Floats, ys: Floats, room: Room | None = None) -> Chunk:
        """The arrays of a grid, flat; the error is infinite in cells that are left to the graph.

        Compiled loops may fill the arrays of `room`.
        """
        codes, exact, growth = self.judged(xs, ys, room)
        if not self.complete:
            growth.error[(growth.poor & (codes != NO_MEMBER)) | (codes == ELSEWHERE)] = np.inf
        return {LEFT: np.array([exact]), "codes": codes, **arrays_of(growth, modes=self.modes)}

    def swept_values(self, x: Any, y: Any) -> dict[str, Any]:
        """Values of the problem with those of the axes."""
        return dict(self.problem.values) | dict(zip(self.axes, (x, y), strict=True))


class FormulaCells(Bands):
    """The cells of a map of a family with formulas."""

    def __init__(
        self, problem: Problem, formulas: ClosedForm, axes: tuple[Axis, Axis], modes: bool
    ) -> None:
        super().__init__(problem, axes, modes)
        self.formulas, self.even, self.how = formulas, formulas.even, FORMULAS
        self.names = problem.family.at, problem.family.parameters
        self._xs = axes[0].values
        self.sized = formulas.even and not isinstance(formulas, ImplicitForm)
        self.growth = self._fine
        self.swept = self.growth and self.sized and self._may_sweep and self._square
        self.how += LOOPS * (self.swept or self.looped)
        if self.sized and not self.growth:
            self.sized = False
            self.growth = self._fine

    @property
    def _fine(self) -> bool:
        """Whether few cells of a sample are open."""
        return bool(np.isinf(self.band(*self._sample)["error"]).mean() <= MOST_POOR)

    def judged(
        self,
        xs: Floats,
        ys: Floats,
        room: Room | None = None,  # noqa: ARG002
    ) -> tuple[Codes, int, Rates]:
        """Flags and growth rates over a grid, flat; none is decided over Q."""
        if self.swept:
            place = self._places(xs, ys)
            quick, codes = swept(self.formulas.with_bounds, place, self._moving, WANTED, FLAGS)
            return codes, 0, Rates(*quick, codes, None, codes == ELSEWHERE)
        along = self._line if np.array_equal(xs, self._xs) else self._along(xs)
        rows = max(1, BLOCK // len(xs))
        blocks = [self._block(xs, ys[i : i + rows], along) for i in range(0, len(ys), rows)]
        a, e, member, none = (np.concatenate(v, axis=-1) for v in zip(*blocks, strict=True))
        parts, shape = [((a, e), self.even, 1)], (len(ys), len(xs))
        self.looped = self._may_sweep and in_loops(parts)
        growth = _rates(parts, shape, modes=self.modes, loops=self.looped)
        growth.poor[:] |= ~(member & np.isfinite(growth.error))
        growth.codes[growth.poor | (growth.codes == 0)] = ELSEWHERE
        growth.codes[none] = NO_MEMBER
        for array in (growth.abscissa, growth.error, growth.frequency, growth.values):
            if array is not None:
                array[none] = np.nan
        return growth.codes, 0, growth

    def _places(self, xs: Floats, ys: Floats) -> list[list[Any]]:
        """Family parameters and parameters of a block."""
        values = self.swept_values(xs[None, :], ys[:, None])
        return [[values[n] for n in names] for names in self.names]

    def __getstate__(self) -> dict[str, Any]:
        """The state without formulas that are begun, which every process begins by itself."""
        return {name: value for name, value in vars(self).items() if name != "_line"}

    @cached_property
    def _line(self) -> Along:
        """The formulas for all values of x."""
        return self._along(self._xs)

    @property
    def _moving(self) -> frozenset[tuple[int, int]]:
        """Places of the y axis among family parameters and parameters."""
        return frozenset(
            (i, names.index(self.axes[1]))
            for i, names in enumerate(self.names)
            if self.axes[1] in names
        )

    @property
    def _square(self) -> bool:
        """Whether the polynomial is c₂ λ² + c₀."""
        return len(self.formulas.with_bounds.places[0]) == 3

    def _along(self, xs: Floats) -> Along:
        """The formulas of places; what follows from x alone is the same for every row."""
        rows = self._moving
        with np.errstate(all="ignore"):
            places = self._places(xs, np.empty(0))
            if self.sized:
                return self.formulas.with_bounds.begun(NUMPY, places, rows)
            a, q = _exact(places)
            begun = self.formulas.begun(TRACKED, a, q, rows)
        return lambda places: begun(*_exact(places))

    def _block(self, xs: Floats, ys: Floats, along: Along) -> tuple[Any, Any, Any, Any]:
        """Monic coefficients with bounds, where members are proved, and where there are none."""
        shape = len(ys), len(xs)
        with np.errstate(all="ignore"):
            coefficients, numbers = self._bounded(self._places(xs, ys), along)
            member: Any = np.True_
            lacking: Any = np.False_
            for v, e in numbers:
                member, lacking = member & (v > e), lacking | (v < -e)
            flat = [[np.broadcast_to(v, shape).reshape(-1) for v in c] for c in coefficients]
            flags = [np.broadcast_to(v, shape).reshape(-1) for v in (member, lacking)]
            a, e = monic(flat[0], flat[1])
        return np.array(a), np.array(e), flags[0], flags[1]

    def _bounded(self, places: list[list[Any]], along: Along) -> tuple[Any, list[tuple[Any, Any]]]:
        """Coefficients with bounds, and the numbers that are positive at members with theirs.

        A polynomial in λ² needs few digits of its coefficients, so one bound for all roundings is
        enough, and quick.  Other roots need the bound of each operation.
        """
        values = along(places)
        if self.sized:
            return (values[0], values[3]), list(zip(values[2], values[5], strict=True))
        some, _, positive = values
        pairs = [(v.value, 1.01 * v.error) for v in map(tracked, positive)]
        columns = zip(*((v.value, 1.01 * v.error) for v in map(tracked, some)), strict=True)
        return tuple(columns), pairs


def _exact(places: list[list[Any]]) -> list[list[RunningError]]:
    return [[RunningError(np.asarray(v), 0.0) for v in some] for some in places]


def formula_cells(problem: Problem, axes: tuple[Axis, Axis], modes: bool) -> FormulaCells | None:
    """The cells of a map by formulas; None where the family has none, or they have no bounds."""
    formulas = formulas_of(problem.family)
    if formulas is None or not problem.plain or problem.exact is not None:
        return None
    try:
        return FormulaCells(problem, formulas, axes, modes)
    except KeyError:  # a function whose rounding is not counted
        return None


SAMPLE = 128
"""Members on which the discs are tried."""
FEWEST = 1024
"""Number of members below which the eigensolver alone is as good."""
MOST_STATES = 8
"""Largest matrix whose polynomial is formed in doubles."""


def quick_rates(
    reduced: Reduced, *, even: bool, modes: bool, columns: int = 0, loops: bool = False
) -> Rates | None:
    """Growth rates and verdicts of many members; None where the eigensolver is as good.

    Parameters
    ----------
    reduced
        Matrices of the members.
    even, modes
        As for `rates`.
    columns
        Columns of the grid whose rows follow each other; 0 where the members are no grid.
    loops
        Whether compiled loops may run over the members.

    Returns
    -------
    Rates or None
        Members whose discs are large or meet have the eigensolver's values and Gershgorin's discs.
    """
    matrix, error = reduced.matrix, reduced.error
    count, n = matrix.shape[:2]
    if not 2 <= n <= MOST_STATES or count < FEWEST or not np.isfinite(matrix).all():
        return None
    step = -(-count // SAMPLE)
    some, off = matrix[::step], error[::step]
    if _of(some, off, even=even, modes=False, columns=len(some)).poor.mean() > MOST_POOR:
        return None
    whole = columns and count % columns == 0
    across = columns if whole else count
    growth = _of(matrix, error, even=even, modes=modes, columns=across, loops=loops)
    left = np.flatnonzero(growth.poor | (growth.codes == 0))
    if len(left):
        part = Reduced(matrix[left], error[left], [], reduced.supported[left])
        values, radius, _ = eigenvalues(part, even=even)
        again = of_eigenvalues(values, radius, decide(values, radius, even=even))
        for name in ("codes", "abscissa", "error", "frequency", *(["values"] * modes)):
            getattr(growth, name)[left] = getattr(again, name)
    return growth


def _of(
    matrix: Floats, error: Floats, *, even: bool, modes: bool, columns: int, loops: bool = False
) -> Rates:
    shape = len(matrix) // columns, columns
    with np.errstate(all="ignore"):
        parts = [(of_matrices(matrix, error), even, 1)]
        return _rates(parts, shape, modes=modes, loops=loops)


class GraphCells:
    """The arrays of members by the graph; compiled loops may run over many."""

    def __init__(self, problem: Problem, modes: bool, *, loops: bool) -> None:
        self.problem, self.modes, self._loops = problem, modes, loops
        family = problem.family
        self.zeros = structure(family).zeros  # established here, before the threads start
        self._certain = problem.derived or certain(family)
        declared = family.conservative and self._certain
        self._even = declared or (not problem.derived and symmetric(family))
        self.count = len(family.system.states) - self.zeros
        """Eigenvalues of a member without the structural zeros."""

    def __call__(self, a: Floats, q: Floats, rate: Floats, u: Floats, columns: int = 0) -> Chunk:
        """Flags, growth rates with bounds, and frequencies of members.

        Parameters
        ----------
        a, q, u
            Numbers that name the members, parameters and unknowns, one row for each.
        rate
            Unit of rate of each.
        columns
            As for `quick_rates`.
        """
        family, even = self.problem.family, self._even
        family.checked_states(a, u, q)
        watch = not self._certain
        reduced = deflate(family, a, q, u, self.problem.roundings, watch=watch)
        growth = None
        if not watch:
            how = {"even": even, "modes": self.modes, "loops": self._loops}
            growth = quick_rates(reduced, columns=columns, **how)
        if growth is None:
            values, radius, _ = eigenvalues(reduced, even=even)
            codes = decide(values, radius, even=even)
            if watch:
                self._restore(values, radius, codes, (a, q, u), reduced.supported)
            growth = of_eigenvalues(values, radius, codes)
        return {"codes": growth.codes, **arrays_of(growth, modes=self.modes, unit=rate)}

    def unstable(self, a: Floats, q: Floats, u: Floats) -> NDArray[np.int16]:
        """Number of unstable eigenvalues of members, -1 where discs leave it open."""
        watch = not self._certain
        reduced = deflate(self.problem.family, a, q, u, self.problem.roundings, watch=watch)
        values, radius, _ = eigenvalues(reduced, even=self._even)
        counts = unstable_in_discs(values, radius, even=self._even)
        return np.where(watch & (reduced.supported < self.zeros), -1, counts)

    def _restore(
        self,
        values: Any,
        radius: Floats,
        codes: NDArray[np.int8],
        place: tuple[Floats, Floats, Floats],
        supported: NDArray[np.intp],
    ) -> None:
        """Restore the leading eigenvalue of members that have fewer zeros than typical ones."""
        for count in range(self.zeros):
            rows = np.flatnonzero(supported == count)
            if not len(rows):
                continue
            if self.modes:
                raise DomainError(
                    f"{self.problem.family.name} has {self.zeros} eigenvalues that are zero by "
                    f"structure at typical members but {count} somewhere on this map; leave out "
                    "modes, or map that part by itself."
                )
            a, q, u = (part[rows] for part in place)
            reduced = deflate(self.problem.family, a, q, u, self.problem.roundings, count)
            all_values, discs, _ = eigenvalues(reduced, even=False)
            codes[rows] = decide(all_values, discs, even=False)
            kept = values.shape[1]
            values[rows], radius[rows] = all_values[:, -kept:], discs[:, -kept:]


SLICE = (
    "characteristic polynomial of the family over Q in the two axes: verdicts from its conditions "
    "by a floating-point filter with a proved bound, growth rates from real factors "
    "with Gershgorin bounds; what these leave open in rational arithmetic, or from the graph by "
    "the eigensolver with Gershgorin's discs"
)
"""Method in words."""


STORED = (
    "exact polynomials of the family: verdicts by a floating-point filter with a proved bound, "
    "growth rates from real factors with Gershgorin bounds; what these leave open in extended "
    "precision, then in rational arithmetic or balls"
)
"""Method in words for a stored polynomial."""
FINE: Any = np.longdouble if np.finfo(np.longdouble).eps < 1e-18 else np.float64
"""Type of the numbers in which poor cells are computed again."""


class SliceCells(Bands):
    """The cells of a map of a family with a slice.

    Those of a stored polynomial are complete: certified eigenvalues serve cells that are left open.
    """

    def __init__(
        self, problem: Problem, section: Slice, axes: tuple[Axis, Axis], modes: bool
    ) -> None:
        super().__init__(problem, axes, modes)
        self.verdicts = SliceVerdicts(problem, section, axes)
        self.windows = self.verdicts.windows
        self._factors = [
            ([surface(c, self.windows) if c != 0 else None for c in row], even, count)
            for row, even, count in section.factors
        ]
        present = [s for row, _, _ in self._factors for s in row if s is not None]
        self._degrees = tuple(max(s.degrees[k] for s in present) for k in (0, 1))
        self.complete = problem.derived
        self.how = STORED if self.complete else SLICE
        self._wanted = PROVED if self.complete else WANTED
        self._exact = all(s.rest is not None for s in present)
        self.loops = None
        if self.complete and self._may_sweep:
            self.loops = CompiledRates.of([row for row, _, _ in self._factors], even=section.even)
        self.swept = self.loops is not None
        self.growth = self.complete or bool(self.rates(*self._sample).poor.mean() <= MOST_POOR)
        self.how += LOOPS * (self.swept or self.looped)

    def judged(self, xs: Floats, ys: Floats, room: Room | None = None) -> tuple[Codes, int, Rates]:
        """Flags and growth rates over a grid, flat."""
        growth = None if self.loops is None else self._swept(xs, ys, room)
        proved = None if growth is None or "lean" in self.problem.values else growth.codes
        codes, exact = self.verdicts(xs, ys, proved)
        codes = codes.reshape(-1)
        if growth is None:
            growth = self.rates(xs, ys)
        if self.complete:
            exact += self._complete(growth, xs, ys, codes)
        return codes, exact, growth

    def _swept(self, xs: Floats, ys: Floats, room: Room | None) -> Rates | None:
        """Growth rates by compiled loops; None where a number is too small for them."""
        assert self.loops is not None
        places = self.windows[0].pairs(xs), self.windows[1].pairs(ys)
        return self.loops(places, self._unit(xs, ys), room)

    def rates(self, xs: Floats, ys: Floats) -> Rates:
        """Growth rates over a grid, flat, with y outermost."""
        with np.errstate(all="ignore"):
            t, s = (
                powers(w(v), d)
                for w, v, d in zip(self.windows, (xs, ys), self._degrees, strict=True)
            )
            parts = [(_coefficients(row, t, s), even, count) for row, even, count in self._factors]
            shape = len(ys), len(xs)
            if not self.complete:
                self.looped = self._may_sweep and in_loops(parts)
                return _rates(parts, shape, modes=self.modes, loops=self.looped)
            growth = rates(parts, shape, modes=self.modes, wanted=self._wanted)
            growth.poor[:] |= growth.open
            growth.scale(_flat(self._unit(xs, ys), xs, ys))
        return growth

    def _complete(self, growth: Rates, xs: Floats, ys: Floats, codes: Codes) -> int:
        """Compute poor cells again; the number of those that get certified eigenvalues."""
        left = np.flatnonzero(growth.poor)
        still = left[(codes[left] == CODES[Verdict.NEUTRAL]) & (growth.error[left] < np.inf)]
        growth.abscissa[still] = growth.error[still] = 0.0
        growth.poor[still] = False
        left = np.flatnonzero(growth.poor & self._exact)
        for first in range(0, len(left), BLOCK):
            some = left[first : first + BLOCK]
            near = [f and f.take(some).astype(FINE) for f in growth.factors]
            growth.put(some, self._again(xs, ys, some, near))
        left = np.flatnonzero(growth.poor)
        for cell in left:
            i, j = divmod(int(cell), len(xs))
            values = {n: float(v) for n, v in self.swept_values(xs[j], ys[i]).items()}
            growth.prove(self.problem, int(cell), values)
        return len(left)

    def _again(self, xs: Floats, ys: Floats, cells: Any, near: Sequence[Factors | None]) -> Rates:
        """Rates of some cells from coefficients in pairs of doubles, and from factors near them."""
        place = self.windows[0].pairs(xs), self.windows[1].pairs(ys)
        rows, columns = np.divmod(cells, len(xs))
        with np.errstate(all="ignore"):
            parts = [
                (_coefficients_twice(row, place, rows, columns), even, count)
                for row, even, count in self._factors
            ]
            shape = 1, len(cells)
            growth = rates(parts, shape, modes=self.modes, wanted=self._wanted, near=near)
            growth.poor[:] |= growth.open
        growth.scale(_flat(self._unit(xs, ys), xs, ys)[cells])
        return growth

    def _unit(self, xs: Floats, ys: Floats) -> Any:
        """Unit of the polynomial's variable in the user's unit of rate, over a grid."""
        assert self.problem.exact is not None
        scale, square = self.problem.exact.scale(self.swept_values(xs[None, :], ys[:, None]))
        return np.sqrt(square) if scale is None else scale


def slice_cells(problem: Problem, axes: tuple[Axis, Axis], modes: bool) -> SliceCells | None:
    """The cells of a map by a slice; None where the family has none."""
    section = slice_of(problem, axes[0].name, axes[1].name)
    with suppress(NotExact):
        return None if section is None else SliceCells(problem, section, axes, modes)
    return None


def _flat(unit: Any, xs: Floats, ys: Floats) -> Floats:
    """A unit of rate of each cell, flat."""
    return np.broadcast_to(unit, (len(ys), len(xs))).reshape(-1)


def _coefficients(row: list[Surface | None], t: Floats, s: Floats) -> Coefficients:
    """Monic coefficients of a factor over a grid, flat."""
    top, width = max(p.exponent for p in row if p is not None), t.shape[1]
    rows = max(1, BLOCK // width)
    out = np.empty((2, len(row) - 1, width * s.shape[1]))
    for first in range(0, s.shape[1], rows):
        some = s[:, first : first + rows]
        values, errors = [], []
        for p in row:
            if p is None:
                value = error = np.zeros((some.shape[1], width))
            else:
                value, error = p.product(t, some)
                if p.exponent != top:
                    scale = 2.0 ** (p.exponent - top)  # exact, or zero: LEAST is far above that
                    value, error = value * scale, error * scale
                error = error + LEAST
            values.append(value.reshape(-1))
            errors.append(error.reshape(-1))
        place = slice(first * width, first * width + len(values[0]))
        for lines, part in zip(out, monic(values, errors), strict=True):
            for line, v in zip(lines, part, strict=True):
                line[place] = v
    return out[0], out[1]


def _coefficients_twice(
    row: list[Surface | None], place: tuple[Any, Any], rows: Any, columns: Any
) -> Coefficients:
    """Monic coefficients of a factor at cells of a grid, from pairs of doubles."""
    top = max(p.exponent for p in row if p is not None)
    values, errors = [], []
    for p in row:
        value = error = np.zeros(len(rows), dtype=FINE)
        if p is not None:
            scale = 2.0 ** (p.exponent - top)
            high, low, error = p.twice(*place, rows, columns)
            value = high.astype(FINE) * scale + low.astype(FINE) * scale
            error = error * scale + np.finfo(FINE).eps / 2 * np.abs(value)
        values.append(value)
        errors.append(error + LEAST)
    return monic(values, errors)
