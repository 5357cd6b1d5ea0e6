"""Maps too large for memory: computed part by part, straight into their file.

Proved verdicts are written band by band into a NetCDF file, which is complete or absent.  Into a
Zarr folder workers write whole chunks, of verdicts or of growth rates.
"""

from __future__ import annotations

import hashlib
import os
import shutil
from collections.abc import Callable, Mapping
from concurrent.futures import Executor
from contextlib import closing
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..algebra.eigensolver import name_of
from ..algebra.polynomial import TabulatedPolynomial
from ..base.axis import Axis, AxisLike
from ..base.checks import flag
from ..base.errors import FileError, ParameterError, listed
from ..base.types import Floats, Overwrite, Progress
from ..base.verdict import CODES, Verdict
from ..bodies.contact_laws import Contact
from ..bodies.disk import Disk
from ..bodies.round_body.body import Body
from ..jobs.dask import check_pool, pool_of
from ..jobs.filling import Blank, Work, fill
from ..jobs.pipeline import Counted, ordered, shared
from ..spectra.axes import swept
from ..spectra.labels import verdict_attributes
from ..spectra.problem import Problem
from ..storage.chunks import Arrays, Block, Layout, Store, Variable
from ..storage.datasets import dataset_target, format_to_write
from ..storage.formats import formats_for
from ..storage.targets import path_text, place
from ..systems.family import Family
from .cells import Cells, steady_memory
from .dataset import cell_attributes, coordinates, provenance
from .tiles import Codes
from .verdicts import ELSEWHERE, SliceVerdicts, slice_verdicts

METHOD = (
    "verdicts from the exact stability conditions: whole tiles proved at once, cells next to the "
    "boundary by a floating-point filter with a proved bound, what it leaves open in rational "
    "arithmetic or balls"
)
"""Method in words."""


def judge_of(problem: Problem, axes: tuple[Axis, Axis]) -> SliceVerdicts:
    """What gives the verdicts of a map.

    Parameters
    ----------
    problem
        Family with values in the user's units.
    axes
        x and y.

    Raises
    ------
    ParameterError
        If there are no exact polynomials.
    """
    stored = isinstance(problem.exact, TabulatedPolynomial)
    if not stored and not problem.plain:
        raise ParameterError(
            f"{problem.family.name} under the {problem.law.name if problem.law else ''} law has no "
            "exact polynomials, by which verdicts are streamed; use growth=True, or stability_map."
        )
    verdicts = slice_verdicts(problem, axes)
    if verdicts is None:
        raise ParameterError(
            f"{problem.family.name} has no polynomial over Q in {axes[0].name} and {axes[1].name} "
            "that proves its verdicts, by which verdicts are streamed; use growth=True, or "
            "stability_map."
        )
    if problem.may_drift:
        raise ParameterError(
            f"{problem.family.name} has zero eigenvalues that may form a Jordan block, which its "
            "polynomial does not show; use growth=True, or stability_map."
        )
    if not stored and not verdicts.everywhere:
        raise ParameterError(
            f"{problem.family.name} is not proved to have a member in every cell of this map; use "
            "growth=True, or stability_map."
        )
    return verdicts


def flags() -> dict[str, Any]:
    """Attributes of verdicts alone."""
    return {name: words for name, words in verdict_attributes().items() if name != "comment"}


def band(judge: Callable[[], SliceVerdicts], xs: Floats, ys: Floats) -> tuple[Codes, int]:
    """Flags of a band, and the number of its cells that went to exact arithmetic."""
    codes, left = judge()(xs, ys)
    codes[codes == ELSEWHERE] = CODES[Verdict.UNDECIDED]  # a sign that balls leave open
    return codes, left


RATES = {"abscissa": "abscissa", "abscissa_error": "error", "frequency": "frequency"}
"""Arrays of growth rates: the name in a dataset, and that in a chunk of `Cells`."""
GROWN = 25
"""Bytes of a cell with its growth rates, not compressed; one of a verdict alone."""


VERDICT = Variable("verdict", "int8", -1, flags())
"""The array of verdicts alone."""


@dataclass(frozen=True)
class ChunkWork:
    """Work of a chunk of a map."""

    arrays: Callable[[Floats, Floats], Arrays]
    """Gives the arrays of a grid, flat."""
    axes: tuple[Axis, Axis]
    """x and y."""
    layout: Layout
    """The grid of chunks."""

    def __call__(self, block: Block, part: slice) -> Arrays:
        """Arrays of a part of the chunk's cells."""
        rows, columns = self.layout.slices(block)
        arrays = self.arrays(self.axes[0].values[columns], self.axes[1].values[rows])
        return {name: array[part] for name, array in arrays.items()}


def verdicts_of(judge: Callable[[], SliceVerdicts], xs: Floats, ys: Floats) -> Arrays:
    """The verdicts of a grid, by this worker's judge."""
    codes, _ = band(judge, xs, ys)
    return {"verdict": codes.astype(np.int8, copy=False).ravel()}


def growth_of(cells: Callable[[], Cells], xs: Floats, ys: Floats) -> Arrays:
    """Verdicts and growth rates of a grid, by this worker's cells."""
    part = cells().part(xs, ys)
    return {"verdict": part["codes"], **{name: part[source] for name, source in RATES.items()}}


def no_verdicts(count: int) -> Arrays:
    """Verdicts of cells that ended their worker."""
    return {"verdict": np.full(count, CODES[Verdict.UNDECIDED], dtype=np.int8)}


def no_rates(count: int) -> Arrays:
    """The same with growth rates: numbers are missing, and the bound is infinite."""
    missing = np.full(count, np.nan)
    bound = np.full(count, np.inf)
    return {
        **no_verdicts(count),
        "abscissa": missing,
        "abscissa_error": bound,
        "frequency": missing,
    }


def _store(
    target: Path,
    problem: Problem,
    axes: tuple[Axis, Axis],
    layout: Layout,
    arrays: tuple[Variable, ...],
    method: str,
    more: Mapping[str, Any],
    overwrite: Overwrite,
) -> Store:
    """The store of a map; equal maps have equal files, so it holds no date."""
    attrs = {n: v for n, v in provenance(problem, axes, method).items() if n != "created"}
    system = problem.family.system
    text = " ".join([str(system.rhs), *system.algebraic])
    graph = hashlib.sha256(text.encode()).hexdigest()
    question = {"equations": graph, "anchor": repr(problem.family.anchor), **more}
    chunks: Any = format_to_write(target, "chunks").chunks
    store: Store = chunks(
        target, layout, arrays, coordinates(problem, axes), attrs, question, overwrite=overwrite
    )
    return store


BAND = 2**20
"""Cells of a chunk of verdicts; one with growth rates has as many as `Cells` computes at once."""
MOST_CELLS = 10**11
"""Largest streamed map."""


def stream_map(
    family: str | Family,
    *,
    x: AxisLike,
    y: AxisLike,
    out: str | os.PathLike[str],
    growth: bool = False,
    disk: Disk | None = None,
    body: Body | Disk | None = None,
    contact: Contact | type[Contact] | str | None = None,
    at: ArrayLike | None = None,
    workers: int | None = None,
    executor: Executor | str | None = None,
    overwrite: Overwrite = False,
    progress: Progress | None = None,
    **parameters: ArrayLike,
) -> Path:
    """Proved verdicts over two parameters, and growth rates, for maps that memory cannot hold.

    Parameters
    ----------
    family
        Name of a disk's family, or a `Family`.  For verdicts alone it must be algebraic in both
        axes, with a member in every cell.
    x, y
        Axes, as for `stability_map`.
    out
        Folder to write, whose name ends in `.zarr`, or for verdicts alone a NetCDF file.
        `read_map(out, lazy=True)` opens it without loading it.  A folder of the same map that is
        not complete is continued.
    growth
        Whether to write growth rates too: `abscissa`, `abscissa_error` (a bound) and `frequency`,
        as in the dataset of `stability_map`, in the unit of rates.
    disk, body, contact, at
        As for `stability_map`.
    workers
        Number of workers.  When left out, one for each core; one thread for verdicts without an
        executor, since they take little time.
    executor
        `threads`, `processes`, `dask` (a scheduler and workers on this machine), the address of a
        running scheduler, or any `concurrent.futures.Executor`.
    overwrite
        Whether an existing file may be replaced; "same": if it holds the same map.
    progress
        Called with (cells done, cells in all).
    **parameters
        For a `Family`: its fixed parameters by name.

    Returns
    -------
    Path
        The file, which is complete or absent; or the folder.

    Raises
    ------
    StabilityError
        One sentence that says what is wrong and what is accepted.

    Notes
    -----
    With growth rates each chunk is computed as `stability_map` computes its bands, so the numbers
    of a disk are the same.  Those that a user's family has from its graph agree within their
    bounds.  Its open cells are settled chunk by chunk, so more of them may be decided.  The flags
    of a user's family include `no_member`; numbers are missing there.  There are no boundary
    curves.  A cell that ends its worker is *undecided*, without numbers, and its bound is infinite.

    Source: tests/maps/test_kernels.py and tests/maps/test_streamed_growth.py; the figures of
    benchmarks/kernels.py.

    Examples
    --------
    >>> from pathlib import Path
    >>> import tempfile, stability as st
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = st.stream_map("spinning", x=("at", 1, 4, 50), y=("mu", 0.1, 2, 40),
    ...                       out=Path(folder) / "map.nc")
    ...     st.read_map(file).verdict.shape
    (40, 50)
    """
    growth = flag("growth", growth)
    check_pool(executor, workers, progress)
    problem, (across, up) = swept(
        family, {"x": x, "y": y}, disk, body, contact, at, parameters, linear=True
    )
    axes = across, up
    judge = None if growth else judge_of(problem, axes)
    total = axes[0].count * axes[1].count
    if total > MOST_CELLS:
        raise ParameterError(
            f"the map has {total:.3g} cells; at most {MOST_CELLS:.0e} are streamed."
        )
    target = _target(out, growth, overwrite)
    _check_room(target, total * (GROWN if growth else 1))
    steady_memory()
    usual = 1 if executor is None and not growth else os.cpu_count() or 1
    with pool_of(executor, workers) as (pool, number):
        how = _How(pool, number or usual, progress, overwrite)
        if judge is None:
            _grow(target, problem, axes, how)
        else:
            _judge(target, judge, problem, axes, how)
    return Path(out)


@dataclass(frozen=True)
class _How:
    """How a map is computed and written."""

    executor: Executor | None
    """Executor that does the work, or None."""
    workers: int
    """Number of workers."""
    progress: Progress | None
    """Called with (cells done, cells in all)."""
    overwrite: Overwrite
    """Whether an existing file may be replaced; "same": if the same call wrote it."""


def _target(out: str | os.PathLike[str], growth: bool, overwrite: Overwrite) -> Path:
    """The file or folder to write."""
    folders = [ending for f in formats_for("chunks") for ending in f.endings]
    if growth and place(out).suffix.lower() not in folders:
        raise FileError(
            f"{path_text(out)} cannot hold streamed growth rates; give a folder whose name ends in "
            f"{listed(folders, 'or')}, or leave growth out."
        )
    return dataset_target(out, "rows", "chunks", overwrite=overwrite)


def _check_room(target: Path, size: int) -> None:
    """Refuse a map that may not fit on the disk; its size is in bytes."""
    free = shutil.disk_usage(target.parent).free
    if free < size + 2**24:
        raise FileError(
            f"{path_text(target)} may need {size / 2**20:.0f} MiB, and {free / 2**20:.0f} MiB are "
            "free there."
        )


def _layout(axes: tuple[Axis, Axis], cells: int) -> Layout:
    """Chunks of about so many cells, whole rows where these are not longer."""
    x, y = axes
    rows = max(1, cells // x.count)
    return Layout((y.name, x.name), (y.count, x.count), (min(rows, y.count), min(x.count, cells)))


def _judge(
    target: Path, judge: SliceVerdicts, problem: Problem, axes: tuple[Axis, Axis], how: _How
) -> None:
    """Verdicts alone, to a file or a folder."""
    layout = _layout(axes, BAND)
    rows = format_to_write(target, "rows", "chunks").rows
    if rows is not None:
        _write_rows(rows, target, judge, problem, axes, layout, how)
        return
    store = _store(target, problem, axes, layout, (VERDICT,), METHOD, {}, how.overwrite)
    compute = partial(verdicts_of, shared(judge, how.executor))
    _fill(store, ChunkWork(compute, axes, layout), no_verdicts, how)


def _write_rows(
    rows: Any,
    target: Path,
    verdicts: SliceVerdicts,
    problem: Problem,
    axes: tuple[Axis, Axis],
    layout: Layout,
    how: _How,
) -> None:
    """Verdicts band by band, in order, to a file."""
    xs, ys, step = axes[0].values, axes[1].values, layout.chunk[0]
    judge, open_cells = shared(verdicts, how.executor), 0

    def task(first: int) -> Callable[[], tuple[Codes, int]]:
        return partial(band, judge, xs, ys[first : first + step])

    coords, attrs = coordinates(problem, axes), provenance(problem, axes, METHOD)
    with (
        rows(target, layout, (VERDICT,), coords, attrs, overwrite=how.overwrite) as file,
        closing(
            ordered(
                range(0, len(ys), step),
                task,
                executor=how.executor,
                workers=how.workers,
                progress=Counted(how.progress, layout.total),
                size=lambda first: min(step, len(ys) - first) * len(xs),
            )
        ) as bands,
    ):
        for first, (codes, left) in bands:
            file.add(first, {VERDICT.name: codes})
            open_cells += left
        file.note({"method": f"{METHOD} ({open_cells} of {layout.total} cells there)"})


def _grow(target: Path, problem: Problem, axes: tuple[Axis, Axis], how: _How) -> None:
    """Verdicts and growth rates, to a folder."""
    cells = Cells(problem, axes, False, whole=False)
    layout = _layout(axes, cells.band)
    attributes = cell_attributes(problem, missing=not cells.complete)
    arrays = (
        Variable("verdict", "int8", -1, attributes["verdict"]),
        *(Variable(name, "float64", np.nan, attributes[name]) for name in RATES),
    )
    question = {"growth rates": True, "solver of eigenvalues": name_of(cells.solver)}
    store = _store(target, problem, axes, layout, arrays, cells.method, question, how.overwrite)
    compute = partial(growth_of, shared(cells, how.executor))
    _fill(store, ChunkWork(compute, axes, layout), no_rates, how)


def _fill(store: Store, work: Work, blank: Blank, how: _How) -> None:
    fill(
        store,
        work,
        blank=blank,
        executor=how.executor,
        workers=how.workers,
        progress=how.progress,
    )
