"""The cells of a map: workers compute them in chunks, which a checkpoint may store."""

from __future__ import annotations

import math
from collections.abc import Callable
from concurrent.futures import Executor
from contextlib import closing, suppress
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..algebra.eigensolver import chosen, eigensolver, name_of
from ..algebra.polynomial import TabulatedPolynomial
from ..base.axis import Axis
from ..base.errors import NoMemberError, ParameterError, StabilityError
from ..base.types import Floats, Progress
from ..base.verdict import CODES, NO_MEMBER, Verdict
from ..base.version import __version__
from ..integrators.flow import CASADI
from ..jobs.pipeline import Counted, ordered, shared
from ..spectra.certificate import verdict
from ..spectra.deflation import drift_powers, drifting
from ..spectra.problem import Problem
from ..spectra.verdict_routes import BITS
from ..storage.pieces import Chunk, Pieces
from ..systems.graph.smoothness import edged
from ..systems.sources.numeric import NumericSystem
from .by_floats import FLOATS, NumericCells
from .dataset import GRAPH, POLYNOMIAL, SINGLE
from .engine import (
    LEFT,
    MOST_STATES,
    Bands,
    GraphCells,
    Room,
    SliceCells,
    formula_cells,
    may_sweep,
    slice_cells,
)
from .verdicts import ELSEWHERE

CHUNK = 16384
"""Cells of a chunk: few enough for the cache, many enough for NumPy."""
BAND = 65536
"""The same where most cells take polynomials: few enough for the arrays of their roots."""
SWEPT_BAND = 2**19
"""The same where compiled loops run over them: many, so that no thread waits for Python."""
LEAST = 1024
"""Fewest cells for which a user's family gets its polynomial over Q."""
MOST_SETTLED = 2000
"""Most cells of a user's family that are decided one by one without `certify`."""
Grid = tuple[Floats, Floats]
"""Values of x and y."""
MOST_CELLS = 10**9
"""Largest map [cells]; without `modes` its arrays take 25 bytes a cell."""


def steady_memory() -> None:
    """Let freed arrays of megabytes stay with the process, where the C library is glibc.

    One allocation of 31 MiB raises the threshold at which glibc gives memory back.  Without this,
    the arrays of a map are fetched from the system again and again.  Elsewhere nothing changes.
    """
    np.empty(31 * 2**20, dtype=np.uint8)


class Cells:
    """The arrays of a map, filled chunk by chunk.

    Parameters
    ----------
    problem
        Family with values in the user's units.
    axes
        x and y.
    modes
        Whether to store all eigenvalues.
    whole
        Whether there are arrays for all cells; without them `part` computes some.
    """

    def __init__(
        self, problem: Problem, axes: tuple[Axis, Axis], modes: bool, *, whole: bool = True
    ) -> None:
        self.problem, self.axes = problem, axes
        self.shape = axes[1].count, axes[0].count
        self.values: NDArray[np.complex128] | None = None
        self.modes, self.solver = modes, chosen()
        self._numeric = isinstance(problem.family.system, NumericSystem)
        self._by_graph: GraphCells | NumericCells = (
            NumericCells(problem, modes)
            if self._numeric
            else GraphCells(problem, modes, loops=may_sweep(axes, modes))
        )
        if whole:
            self._make_room()
        self.handed_on = 0
        self.refusal = ""
        self._graph = GRAPH.replace("LAPACK", name_of(self.solver))
        if self._numeric:
            self._graph = FLOATS.replace("LAPACK", name_of(self.solver))
        if problem.exact is not None:
            self._graph += POLYNOMIAL
        self.bands = self._bands()
        """What computes many rows at once; None where the graph computes every cell."""
        if self.bands is None:
            self.band = BAND if len(problem.family.system.states) <= MOST_STATES else CHUNK
        else:
            self.band = SWEPT_BAND if self.bands.swept else BAND
        self.chunk = self._even_rows(max(1, self.band // self.shape[1])) * self.shape[1]
        if self.bands is None:  # the graph may take parts of rows
            self.chunk = min(self.chunk, self.band)
        steady_memory()

    def _even_rows(self, most: int) -> int:
        """Rows of a chunk, so that an even number of chunks of one size hold all of them."""
        chunks = -(-self.shape[0] // most)
        return -(-self.shape[0] // (chunks + chunks % 2)) if chunks > 1 else self.shape[0]

    def _bands(self) -> Bands | None:
        asked = self.problem, self.axes, self.modes
        stored = isinstance(self.problem.exact, TabulatedPolynomial)
        if self._numeric:
            return None
        if not stored and (not self.problem.plain or math.prod(self.shape) < LEAST):
            return None
        bands = formula_cells(*asked) or slice_cells(*asked)
        return bands if bands is not None and bands.growth else None

    def _make_room(self) -> None:
        """Arrays for all cells."""
        if math.prod(self.shape) > MOST_CELLS:
            raise ParameterError(
                f"the map has {math.prod(self.shape):.3g} cells; at most {MOST_CELLS:.0e} are "
                "accepted."
            )
        self.abscissa = np.empty(self.shape)
        self.error = np.empty(self.shape)
        self.frequency = np.empty(self.shape)
        self.codes = np.zeros(self.shape, dtype=np.int8)
        if self.modes:
            self.values = np.empty((*self.shape, self._by_graph.count), dtype=complex)

    @property
    def _names(self) -> tuple[str, ...]:
        """Names of the arrays of a chunk."""
        return ("codes", "abscissa", "error", "frequency", *(["values"] * self.modes))

    @property
    def _grid(self) -> Grid:
        """The values of both axes."""
        return self.axes[0].values, self.axes[1].values

    @property
    def complete(self) -> bool:
        """Whether every cell has a member, and no other method computes any."""
        return self.bands is not None and self.bands.complete

    @property
    def route(self) -> str:
        """Method of computation of the cells, in words."""
        if self.bands is None and not self.handed_on and self.problem.exact is None:
            return self._graph
        return f"{self.method} ({self.handed_on} of {math.prod(self.shape)} cells there)"

    @property
    def method(self) -> str:
        """The same before anything is computed."""
        if self.bands is not None:
            return self.bands.how
        single = (self.problem.plain and not self._numeric) or bool(self.handed_on)
        return self._graph + SINGLE * (single and self.problem.exact is None)

    def key(self) -> dict[str, Any]:
        """Description of the map for a checkpoint, with all digits: no other map has it."""
        swept = {g.name for g in self.axes}
        family = self.problem.family
        return {
            "software": __version__,
            "system": family.system.name,
            "graph": str(family.system.rhs),
            "family": family.name,
            "axes": [[g.name, g.low, g.high, g.count, g.log] for g in self.axes],
            "values": {n: float(v) for n, v in self.problem.values.items() if n not in swept},
            "modes": self.values is not None,
            **({"anchor": repr(family.anchor)} if family.anchor else {}),
            **({"algebraic": some} if (some := [*family.system.algebraic]) else {}),
            "chunk": self.chunk,
            "route": self._graph if self.bands is None else self.bands.how,
        }

    def __getstate__(self) -> dict[str, Any]:
        """The state without the arrays, which no worker fills."""
        filled = (*self._names, "values")
        return {name: value for name, value in vars(self).items() if name not in filled}

    def fill(
        self,
        workers: int,
        progress: Progress | None,
        keep: Pieces[int, Chunk] | None = None,
        executor: Executor | None = None,
    ) -> None:
        """Compute the chunks: members here, since CasADi is not shared; spectra by workers.

        Parameters
        ----------
        workers
            Number of workers; threads where there is no executor.
        progress
            Called with (cells done, cells in all), or None.
        keep
            Store of finished chunks, or None.
        executor
            Executor that does the work, or None.
        """
        total, cells = math.prod(self.shape), shared(self, executor)

        def task(start: int) -> Callable[[], Chunk]:
            if self.bands is not None:
                return partial(_band, cells, start, total)
            return partial(_work, cells, *self._inputs(start, total), self.shape[1])

        with closing(
            ordered(
                range(0, total, self.chunk),
                task,
                executor=executor,
                workers=workers,
                keep=keep,
                progress=Counted(progress, total),
                size=lambda start: min(self.chunk, total - start),
            )
        ) as results:
            for start, chunk in results:
                self._place(start, chunk)
        if self.bands is not None and not self.complete:
            whole = {n: getattr(self, n) for n in self._names}
            flat = {n: a.reshape(-1, *a.shape[2:]) for n, a in whole.items()}
            self._complete(flat, self._grid)
        if (self.codes == NO_MEMBER).all():
            self._inputs(0, 1)  # says why
            raise NoMemberError(self.refusal or f"{self.problem.family.name} has no member here.")

    def settle(self, *, certify: bool) -> None:
        """Decide over Q or in balls cells that double precision left open: with `certify` each."""
        self._settled(self.codes.reshape(-1), self._grid, certify=certify)

    def _settled(self, codes: Any, grid: Grid, *, certify: bool) -> None:
        """Decide each, or all by a user's polynomial; without one few, at low precision."""
        if self._numeric:
            return
        self._look_at_zeros(codes, grid)
        if certify or (self.problem.exact is not None and not self.complete):
            self._settle(codes, grid, len(codes), None)
        elif self.problem.plain:
            self._settle(codes, grid, MOST_SETTLED, BITS)

    def _look_at_zeros(self, codes: NDArray[np.int8], grid: Grid) -> None:
        """Tell drifting members from stable ones; those without a proof are left open."""
        if not self.problem.may_drift:
            return
        family, roundings = self.problem.family, self.problem.roundings
        zeros, stable = self._by_graph.zeros, np.flatnonzero(codes == CODES[Verdict.STABLE])
        for first in range(0, len(stable), CHUNK):
            some = stable[first : first + CHUNK]
            a, q, _, u, _ = self._members_of(some, grid)
            judged = codes[some]
            drifting(judged, drift_powers(family, a, q, u, zeros, roundings))
            codes[some] = judged

    def _settle(self, codes: Any, grid: Grid, few: int, most: int | None) -> None:
        """Decide open cells of a grid, where they are few."""
        left = np.flatnonzero(codes == CODES[Verdict.UNDECIDED])
        for cell in left if len(left) <= few else ():
            i, j = divmod(int(cell), len(grid[0]))
            swept = {self.axes[0].name: float(grid[0][j]), self.axes[1].name: float(grid[1][i])}
            values = {n: float(v) for n, v in (dict(self.problem.values) | swept).items()}
            with suppress(StabilityError):  # no member is proved there: the cell stays open
                codes[cell] = CODES[verdict(self.problem, values, most)]
            self.handed_on += 1

    def unstable(self, some: NDArray[np.intp]) -> NDArray[np.int16]:
        """Number of unstable eigenvalues in some cells, -1 where discs leave it open."""
        a, q, _, u, good = self._members_of(some, self._grid)
        counts = np.full(len(some), -1, dtype=np.int16)
        counts[good] = self._by_graph.unstable(a, q, u)
        return counts

    def part(self, xs: Floats, ys: Floats) -> Chunk:
        """The arrays of a grid inside the map, complete, without the others.

        Returns
        -------
        Chunk
            Flags, growth rates with bounds, and frequencies, flat, as the whole map has them.
            Threads may share these cells: what calls CasADi takes turns.
        """
        grid = xs, ys
        with eigensolver(self.solver):  # each thread has its own context
            if self.bands is not None:
                chunk = self.bands.band(xs, ys)
                if self.complete:
                    return chunk
                with CASADI:
                    self._complete(chunk, grid)
            else:
                with CASADI:
                    members = self._members_of(np.arange(len(xs) * len(ys)), grid)
                chunk = self._work(*members, len(xs))
            with CASADI:
                self._settled(chunk["codes"], grid, certify=False)
        return chunk

    def _band(self, start: int, total: int) -> Chunk:
        """Compute whole rows, which takes no CasADi function."""
        assert self.bands is not None
        rows = slice(start // self.shape[1], min(start + self.chunk, total) // self.shape[1])
        xs, ys = self._grid
        return self.bands.band(xs, ys[rows], self._room(rows))

    def _room(self, rows: slice) -> Room | None:
        """Whole rows of the map, which a worker of this process fills in place."""
        here = "abscissa" in vars(self)
        arrays = (self.abscissa, self.error, self.frequency, self.codes) if here else ()
        return tuple(a[rows].reshape(-1) for a in arrays) or None

    def _complete(self, flat: Chunk, grid: Grid) -> None:
        """The cells that the slice left open: by the graph, verdicts of members as they are."""
        self._leave_edges(flat["codes"], grid)
        left = np.flatnonzero(np.isinf(flat["error"]) | (flat["codes"] == ELSEWHERE))
        for first in range(0, len(left), CHUNK):
            some = left[first : first + CHUNK]
            chunk = self._work(*self._members_of(some, grid))
            judged = flat["codes"][some]
            chunk["codes"] = np.where(judged == ELSEWHERE, chunk["codes"], judged)
            for name, array in chunk.items():
                flat[name][some] = array

    def _leave_edges(self, codes: NDArray[np.int8], grid: Grid) -> None:
        """Leave to the graph the cells in which the rates have no slope: no polynomial shows it."""
        # a formula whose bound is finite has slopes: a root's argument is away from zero
        if isinstance(self.bands, SliceCells) and edged(self.problem.family.system):
            for first in range(0, len(codes), CHUNK):
                cells = np.arange(first, min(first + CHUNK, len(codes)))
                bad = cells[~self._members_of(cells, grid)[-1]]
                codes[bad[codes[bad] != NO_MEMBER]] = ELSEWHERE

    def _inputs(
        self, start: int, total: int
    ) -> tuple[Floats, Floats, Floats, Floats, NDArray[np.bool_]]:
        """Numbers and unknowns of the members of a chunk, and which of its cells have one."""
        return self._members_of(np.arange(start, min(start + self.chunk, total)), self._grid)

    def _members_of(
        self, cells: NDArray[np.intp], grid: Grid
    ) -> tuple[Floats, Floats, Floats, Floats, NDArray[np.bool_]]:
        xs, ys = grid
        row, column = np.divmod(cells, len(xs))
        swept = {self.axes[0].name: xs[column], self.axes[1].name: ys[row]}
        values = dict(self.problem.values) | swept
        a, q, rate, _ = self.problem.arrays(values)
        members = self.problem.family.members(a, q)
        good = members.good
        if not good.all():
            self.refusal = self.refusal or members.why(int(np.argmin(good)))
        return a[good], q[good], rate[good], members.u[good], good

    def _work(
        self,
        a: Floats,
        q: Floats,
        rate: Floats,
        u: Floats,
        good: NDArray[np.bool_],
        columns: int = 0,
    ) -> Chunk:
        """The arrays of a chunk; cells without a member have their flag, and no numbers."""
        part = self._by_graph(a, q, rate, u, columns) if len(a) else {}
        if good.all():
            return part
        chunk: Chunk = {}
        for name in self._names:
            kind: Any = {"codes": np.int8, "values": complex}.get(name, float)
            shape = len(good), *((self._by_graph.count,) if name == "values" else ())
            chunk[name] = np.full(shape, NO_MEMBER if name == "codes" else np.nan, dtype=kind)
            if part:
                chunk[name][good] = part[name]
        return chunk

    def fits(self, start: int, chunk: Chunk) -> bool:
        """Whether a stored chunk is whole: every array, of the right length and type."""
        count = min(self.chunk, math.prod(self.shape) - start)
        return chunk.keys() - {LEFT} == {*self._names} and all(
            chunk[n].shape == (count, *getattr(self, n).shape[2:])
            and chunk[n].dtype == getattr(self, n).dtype
            for n in self._names
        )

    def _place(self, start: int, chunk: Chunk) -> None:
        count = len(chunk["codes"])
        for name, array in chunk.items():
            if name == LEFT:  # counted here, so that a resumed map counts them too
                self.handed_on += int(array[0])
                continue
            whole_array = getattr(self, name)
            flat = whole_array.reshape(-1, *whole_array.shape[2:])
            flat[start : start + count] = array


def _band(cells: Callable[[], Cells], start: int, total: int) -> Chunk:
    worker = cells()
    with eigensolver(worker.solver):
        return worker._band(start, total)


def _work(cells: Callable[[], Cells], *members: Any) -> Chunk:
    worker = cells()
    with eigensolver(worker.solver):  # each thread has its own context
        return worker._work(*members)
