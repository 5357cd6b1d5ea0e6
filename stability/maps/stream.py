"""Maps too large for memory: computed part by part, straight into their file."""

from __future__ import annotations

import os
import shutil
from concurrent.futures import Executor
from dataclasses import dataclass
from pathlib import Path

from numpy.typing import ArrayLike

from ..base.axis import Axis, AxisLike
from ..base.checks import flag
from ..base.errors import FileError, ParameterError, listed
from ..base.types import Progress
from ..bodies.contact import Contact
from ..bodies.disk import Disk
from ..bodies.round_body.body import Body
from ..jobs.chunks import Layout
from ..jobs.dask import check_pool, pool_of
from ..jobs.filling import fill
from ..jobs.pipeline import shared
from ..spectra.arguments import swept
from ..spectra.problem import Problem
from ..storage.targets import (
    NETCDF,
    STORES,
    check_folder,
    check_suffix,
    check_target,
    path_text,
    place,
)
from ..systems.family import Family
from .cells import Cells
from .growth_rates import steady_memory
from .streamed.netcdf_file import write_verdicts
from .streamed.verdicts import Judge, judge_of
from .streamed.zarr_folder import (
    GROWN,
    GrowthChunk,
    VerdictChunk,
    growth_store,
    no_rates,
    no_verdicts,
    verdict_store,
)

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
    overwrite: bool = False,
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
        Whether an existing file may be replaced.
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
    problem, (across, up) = swept(family, {"x": x, "y": y}, disk, body, contact, at, parameters)
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
    overwrite: bool
    """Whether an existing file may be replaced."""


def _target(out: str | os.PathLike[str], growth: bool, overwrite: bool) -> Path:
    """The file or folder to write."""
    if growth and place(out).suffix.lower() not in STORES:
        raise FileError(
            f"{path_text(out)} cannot hold streamed growth rates; give a folder whose name ends in "
            f"{listed(STORES, 'or')}, or leave growth out."
        )
    stored = check_suffix(out, (*NETCDF, *STORES)).suffix.lower() in STORES
    return check_folder(out) if stored else check_target(out, overwrite=overwrite)


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
    target: Path, judge: Judge, problem: Problem, axes: tuple[Axis, Axis], how: _How
) -> None:
    """Verdicts alone, to a file or a folder."""
    layout = _layout(axes, BAND)
    if target.suffix.lower() not in STORES:
        write_verdicts(
            target,
            judge,
            problem,
            axes,
            layout,
            executor=how.executor,
            workers=how.workers,
            progress=how.progress,
            overwrite=how.overwrite,
        )
        return
    store = verdict_store(target, problem, axes, layout, overwrite=how.overwrite)
    work = VerdictChunk(shared(judge, how.executor), axes, layout)
    fill(
        store,
        work,
        blank=no_verdicts,
        executor=how.executor,
        workers=how.workers,
        progress=how.progress,
    )


def _grow(target: Path, problem: Problem, axes: tuple[Axis, Axis], how: _How) -> None:
    """Verdicts and growth rates, to a folder."""
    cells = Cells(problem, axes, False, whole=False)
    layout = _layout(axes, cells.band)
    store = growth_store(target, cells, layout, overwrite=how.overwrite)
    work = GrowthChunk(shared(cells, how.executor), layout)
    fill(
        store,
        work,
        blank=no_rates,
        executor=how.executor,
        workers=how.workers,
        progress=how.progress,
    )
