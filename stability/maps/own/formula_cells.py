"""Verdicts and growth rates of the cells of a map from formulas, without members or matrices.

Each coefficient of the characteristic polynomial comes with a bound on its rounding error, so the
discs about its roots hold the eigenvalues.  Cells whose numbers are not proved to be those of a
member, or whose discs decide nothing, are left to the graph.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import Any

import numpy as np

from ...algebra.kernels.compiled import numba_found
from ...algebra.number_types import numpy_algebra
from ...algebra.running_error import TRACKED, RunningError
from ...base.axis import Axis
from ...base.types import Floats
from ...base.verdict import CODES, NO_MEMBER, Verdict
from ...spectra.problem import Problem, formulas_of
from ...systems.closed_form import ClosedForm, ImplicitForm
from ..compiled.swept import swept
from .rates import MOST_POOR, WANTED, Bands, Rates, monic, rates, sample
from .slice_verdicts import ELSEWHERE, Codes

FORMULAS = (
    "characteristic polynomial of the family by formulas in its numbers: coefficients with bounds "
    "on every rounding, growth rates and verdicts by the discs of Braess and Hadeler; what these "
    "leave open from the graph by the eigensolver with Gershgorin's discs"
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


class FormulaCells(Bands):
    """The cells of a map of a family with formulas.

    Parameters
    ----------
    problem
        Problem of a family.
    formulas
        Its formulas.
    axes
        x and y.
    modes
        Whether to keep all eigenvalues.
    """

    def __init__(
        self, problem: Problem, formulas: ClosedForm, axes: tuple[Axis, Axis], modes: bool
    ) -> None:
        self.modes, self.even = modes, formulas.even
        self.formulas = formulas
        family = problem.family
        self.names = family.at, family.parameters
        self.axes = axes[0].name, axes[1].name
        self.values = {n: float(v) for n, v in problem.values.items() if n not in self.axes}
        x, y = sample(axes)
        self._xs = axes[0].values
        self.sized = formulas.even and not isinstance(formulas, ImplicitForm)
        self.how, self.swept = FORMULAS, False
        self.growth = self._fine(x, y)
        many = axes[0].count * axes[1].count >= COMPILED_FROM and numba_found()
        self.swept = self.growth and self.sized and many and not modes and self._square
        if self.swept:
            self.how += LOOPS
        if self.sized and not self.growth:
            self.sized = False
            self.growth = self._fine(x, y)

    def _fine(self, xs: Floats, ys: Floats) -> bool:
        """Whether few cells of a sample are left open."""
        return bool(np.isinf(self.band(xs, ys)[2].error).mean() <= MOST_POOR)

    def judged(self, xs: Floats, ys: Floats) -> tuple[Codes, int, Rates]:
        """Flags and growth rates over a grid, flat; none is decided over Q.

        Parameters
        ----------
        xs, ys
            Increasing values of the axes.
        """
        if self.swept:
            place = self._places(xs, ys)
            quick, codes = swept(self.formulas.with_bounds, place, self._moving, WANTED, FLAGS)
            return codes, 0, Rates(*quick, codes, None, codes == ELSEWHERE)
        rows = max(1, BLOCK // len(xs))
        along = self._line if np.array_equal(xs, self._xs) else self._along(xs)
        parts = [self._block(xs, ys[i : i + rows], along) for i in range(0, len(ys), rows)]
        columns = zip(*parts, strict=True)
        joined = [None if c[0] is None else np.concatenate(c) for c in columns]
        found = Rates(*joined)  # type: ignore[arg-type]  # only the eigenvalues may be None
        open_ = found.poor | (found.codes == 0)
        found.codes[open_ & (found.codes != NO_MEMBER)] = ELSEWHERE
        return found.codes, 0, found

    def _places(self, xs: Floats, ys: Floats) -> list[list[Any]]:
        """Family parameters and parameters of a block."""
        values: dict[str, Any] = dict(self.values)
        values |= {self.axes[0]: xs[None, :], self.axes[1]: ys[:, None]}
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
            tracked = self.formulas.begun(TRACKED, a, q, rows)
        return lambda places: tracked(*_exact(places))

    def _block(self, xs: Floats, ys: Floats, along: Along) -> Rates:
        shape = len(ys), len(xs)
        with np.errstate(all="ignore"):
            (value, error), numbers = self._bounded(self._places(xs, ys), along)
            member: Any = np.True_
            lacking: Any = np.False_
            for v, e in numbers:
                member, lacking = member & (v > e), lacking | (v < -e)
            coefficients = [
                [np.broadcast_to(v, shape).reshape(-1) for v in some] for some in (value, error)
            ]
            out = rates([(monic(*coefficients), self.even, 1)], modes=self.modes)
        out.poor[:] |= ~np.broadcast_to(member, shape).reshape(-1)
        out.poor[:] |= ~np.isfinite(out.error)
        none = np.broadcast_to(lacking, shape).reshape(-1)
        out.codes[none] = NO_MEMBER
        for rate in (out.abscissa, out.error, out.frequency):
            rate[none] = np.nan
        if out.values is not None:
            out.values[none] = np.nan
        return out

    def _bounded(self, places: list[list[Any]], along: Along) -> tuple[Any, list[tuple[Any, Any]]]:
        """Coefficients with bounds, and the numbers that are positive at members with theirs.

        A polynomial in λ² needs few digits of its coefficients, so one bound for all roundings is
        enough, and quick.  Other roots need the bound of each operation.
        """
        found = along(places)
        if self.sized:
            return (found[0], found[3]), list(zip(found[2], found[5], strict=True))
        some, _, positive = found
        pairs = [(v.value, 1.01 * v.error) for v in map(_tracked, positive)]
        columns = zip(*((v.value, 1.01 * v.error) for v in map(_tracked, some)), strict=True)
        return tuple(columns), pairs


def _exact(places: list[list[Any]]) -> list[list[RunningError]]:
    return [[RunningError(np.asarray(v), 0.0) for v in some] for some in places]


def _tracked(value: Any) -> RunningError:
    return value if isinstance(value, RunningError) else RunningError(np.float64(value), 0.0)


def formula_cells(problem: Problem, axes: tuple[Axis, Axis], modes: bool) -> FormulaCells | None:
    """The cells of a map by formulas; None where the family has none, or they have no bounds.

    Parameters
    ----------
    problem, axes, modes
        As for `stability.maps.cells.Cells`.
    """
    formulas = formulas_of(problem.family)
    if formulas is None or not problem.plain or problem.exact is not None:
        return None
    try:
        return FormulaCells(problem, formulas, axes, modes)
    except KeyError:  # a function whose rounding is not counted
        return None
