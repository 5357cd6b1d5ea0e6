"""Verdict maps too large for memory: computed band by band, straight into their file."""

from __future__ import annotations

import hashlib
import io
import math
import os
import shutil
from collections.abc import Callable, Iterator
from concurrent.futures import Executor
from contextlib import closing, contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..algebra.exact.known_polynomial import TabulatedPolynomial
from ..base.axis import Axis, AxisLike
from ..base.errors import FileError, ParameterError
from ..base.types import Floats, Progress
from ..base.verdict import CODES, Verdict
from ..bodies.contact import Contact
from ..bodies.disk import Disk
from ..bodies.round_body.body import Body
from ..bodies.round_body.by_name import of_body
from ..jobs.chunks import Arrays, Block, Layout, Variable
from ..jobs.filling import fill
from ..jobs.pipeline import Counted, check_run, ordered
from ..jobs.shared import shared
from ..jobs.zarr_store import ZarrStore
from ..spectra.arguments import axis_of, prepare
from ..spectra.presentation.labels import axis_attributes
from ..spectra.problem import Problem
from ..storage.checksum import ATTRIBUTE, STATEMENT, seal
from ..storage.files import atomic_write, postponed
from ..storage.targets import NETCDF, STORES, check_folder, check_suffix, check_target, path_text
from ..systems.family import Family
from .dataset import provenance
from .growth_rates import steady_memory
from .own.slice_verdicts import SliceVerdicts, slice_verdicts
from .verdict_tiles import Codes, GridVerdicts

Judge = GridVerdicts | SliceVerdicts
"""What gives the verdicts of a band."""

BAND = 2**20
"""Cells of a band of rows."""
MOST_CELLS = 10**11
"""Largest streamed map."""

METHOD = (
    "verdicts from the exact stability conditions: whole tiles proved at once, cells next to the "
    "boundary by a floating-point filter with a proved bound, what it leaves open in rational "
    "arithmetic or balls"
)


def stream_map(
    family: str | Family,
    *,
    x: AxisLike,
    y: AxisLike,
    out: str | os.PathLike[str],
    disk: Disk | None = None,
    body: Body | Disk | None = None,
    contact: Contact | type[Contact] | str | None = None,
    at: ArrayLike | None = None,
    workers: int | None = None,
    executor: Executor | None = None,
    overwrite: bool = False,
    progress: Progress | None = None,
    **parameters: ArrayLike,
) -> Path:
    """Proved verdicts over two parameters, written in bands, for very large maps.

    Parameters
    ----------
    family
        Name of a disk's family, or a `Family` that is algebraic in both axes.
    x, y
        Axes, as for `stability_map`.
    out
        NetCDF file to write, or folder ending in `.zarr`; `read_map(out, lazy=True)` opens it
        without loading it.  A folder of the same map that is not complete is continued.
    disk, body, contact, at
        As for `stability_map`.
    workers
        Threads in addition to the one that writes; one when left out, since bands are short.
    executor
        Any `concurrent.futures.Executor` in place of the threads, for processes or another machine.
        `workers` is then the number of its workers; the number of processors when left out.
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

    Source: tests/maps/test_kernels.py; the figures of benchmarks/kernels.py.

    Examples
    --------
    >>> import tempfile, stability as st
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = stream_map("spinning", x=("at", 1, 4, 50), y=("mu", 0.1, 2, 40),
    ...                       out=Path(folder) / "map.nc")
    ...     st.read_map(file).verdict.shape
    (40, 50)
    """
    check_run(workers, progress, executor)
    family, disk, contact, parameters = of_body(family, body, disk, contact, parameters, (x, y))
    axes = axis_of(family, x, "x"), axis_of(family, y, "y")
    own = isinstance(family, Family)
    problem = prepare(family if own else str(family), axes, disk, contact, at, parameters)
    verdicts = _own_verdicts(problem, axes) if own else None
    if verdicts is None and not isinstance(problem.exact, TabulatedPolynomial):
        raise ParameterError(
            f"{problem.family.name} under the {problem.law.name if problem.law else ''} law has no "
            "exact polynomials, by which maps are streamed; use stability_map."
        )
    total = axes[0].count * axes[1].count
    if total > MOST_CELLS:
        raise ParameterError(
            f"the map has {total:.3g} cells; at most {MOST_CELLS:.0e} are streamed."
        )
    stored = check_suffix(out, (*NETCDF, *STORES)).suffix.lower() in STORES
    target = check_folder(out) if stored else check_target(out, overwrite=overwrite)
    free = shutil.disk_usage(target.parent).free
    if free < total + 2**24:
        raise FileError(
            f"{path_text(target)} may need {total / 2**20:.0f} MiB, and {free / 2**20:.0f} MiB are "
            "free there."
        )
    steady_memory()
    judge = verdicts or GridVerdicts(problem, axes[0].name, axes[1].name)
    count = workers or (1 if executor is None else os.cpu_count() or 1)
    if stored:
        store = _store(target, problem, axes, overwrite)
        work = _Chunk(shared(judge, executor), axes, store.layout)
        fill(store, work, blank=_undecided, executor=executor, workers=count, progress=progress)
    else:
        _write(target, problem, axes, partial(
            _fill, verdicts=judge, axes=axes, workers=count, progress=progress, executor=executor,
        ), overwrite)  # fmt: skip
    return Path(out)


def _write(
    target: Path, problem: Problem, axes: tuple[Axis, Axis], filled: Callable[..., int],
    overwrite: bool,
) -> None:  # fmt: skip
    """A NetCDF file with its checksum."""
    with atomic_write(target, overwrite=overwrite) as draft:
        with _Sink(draft) as sink:
            # an exception within HDF5's calls of the sink, even Ctrl-C, would end the process
            file = None
            try:
                with postponed():
                    file, variable = _created(sink, problem, axes)
                left = filled(variable, sink)
                total = math.prod(g.count for g in axes)
                with postponed():
                    file.attrs["method"] = f"{METHOD} ({left} of {total} cells there)"
                    file.attrs[ATTRIBUTE] = STATEMENT
            finally:
                if file is not None:
                    with postponed():
                        file.close()
            sink.check()
        seal(draft)


def _own_verdicts(problem: Problem, axes: tuple[Axis, Axis]) -> SliceVerdicts:
    """Verdicts of a user's family, which exist in every cell."""
    found = slice_verdicts(problem, axes)
    if found is None:
        raise ParameterError(
            f"{problem.family.name} has no polynomial over Q in {axes[0].name} and {axes[1].name} "
            "that proves its verdicts, by which maps are streamed; use stability_map."
        )
    if not found.everywhere:
        raise ParameterError(
            f"{problem.family.name} is not proved to have a member in every cell of this map; use "
            "stability_map."
        )
    return found


class _Sink(io.RawIOBase):
    """A file for HDF5 that never fails: `check` raises the first error afterwards.

    HDF5 ends the process when it closes a file that it could not write.
    """

    def __init__(self, path: Path) -> None:
        self._file = path.open("r+b", buffering=0)
        self._error: OSError | None = None

    def check(self) -> None:
        """Raise the first error, if there is one."""
        if self._error is not None:
            raise self._error

    def readable(self) -> bool:
        return True

    def writable(self) -> bool:
        return True

    def seekable(self) -> bool:
        return True

    def seek(self, offset: int, whence: int = os.SEEK_SET) -> int:
        return self._file.seek(offset, whence)

    def tell(self) -> int:
        return self._file.tell()

    def truncate(self, size: int | None = None) -> int:
        with self._kept():
            self._file.truncate(size)
        return size or 0

    def readinto(self, buffer: Any) -> int:
        view = memoryview(buffer).cast("B")
        got = self._file.readinto(view) or 0
        view[got:] = bytes(len(view) - got)  # zeros for bytes that could not be written
        return len(view)

    def write(self, data: Any) -> int:
        view = memoryview(data).cast("B")
        count = len(view)
        with self._kept():
            while len(view) and self._error is None:
                view = view[self._file.write(view) or 0 :]
        return count

    def close(self) -> None:
        with self._kept():
            self._file.close()
        super().close()

    @contextmanager
    def _kept(self) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            self._error = self._error or error


def _created(path: _Sink, problem: Any, axes: tuple[Axis, Axis]) -> tuple[Any, Any]:
    import h5netcdf

    file = h5netcdf.File(path, "w")
    file.dimensions = {g.name: g.count for g in axes}
    for grid in axes:
        for name in filter(None, (grid.name, grid.alias)):
            coordinate = file.create_variable(name, (grid.name,), float, data=grid.values)
            coordinate.attrs.update(axis_attributes(problem, grid.name))
    second = [g.alias for g in axes if g.alias]
    rows = min(_rows(axes), axes[1].count)
    verdict = file.create_variable(
        "verdict", (axes[1].name, axes[0].name), np.int8,
        chunks=(rows, min(axes[0].count, BAND)), compression="gzip", compression_opts=1,
    )  # fmt: skip
    verdict.attrs.update(
        _flags() | ({"coordinates": " ".join(second)} if second else {})
    )  # fmt: skip
    file.attrs.update(provenance(problem, axes, METHOD))
    return file, verdict


def _flags() -> dict[str, Any]:
    return {
        "flag_values": np.array(list(CODES.values()), dtype=np.int8),
        "flag_meanings": " ".join(v.word for v in CODES),
        "long_name": "spectral verdict",
    }


def _rows(axes: tuple[Axis, Axis]) -> int:
    return max(1, BAND // axes[0].count)


def _fill(
    variable: Any, sink: _Sink, verdicts: Judge, axes: tuple[Axis, Axis], workers: int,
    progress: Progress | None, executor: Executor | None,
) -> int:  # fmt: skip
    """Write the bands in order; return the number of cells that went to exact arithmetic."""
    xs, ys = axes[0].values, axes[1].values
    step, total = _rows(axes), math.prod(g.count for g in axes)
    left, judge = 0, shared(verdicts, executor)

    def task(first: int) -> Callable[[], tuple[Codes, int]]:
        return partial(_band, judge, xs, ys[first : first + step])

    with closing(ordered(
        range(0, len(ys), step), task, executor=executor, workers=workers,
        progress=Counted(progress, total),
        size=lambda first: min(step, len(ys) - first) * len(xs),
    )) as results:  # fmt: skip
        for first, (codes, open_cells) in results:
            with postponed():
                variable[first : first + len(codes), :] = codes
            sink.check()
            left += open_cells
    return left


def _band(judge: Callable[[], Judge], xs: Floats, ys: Floats) -> tuple[Codes, int]:
    return judge()(xs, ys)


# --- a folder of chunks ---


def _store(folder: Path, problem: Problem, axes: tuple[Axis, Axis], overwrite: bool) -> ZarrStore:
    """The store of a map; equal maps have equal files, so it holds no date."""
    x, y = axes
    layout = Layout((y.name, x.name), (y.count, x.count),
                    (min(_rows(axes), y.count), min(x.count, BAND)))  # fmt: skip
    coords = {
        name: (grid.name, grid.values, axis_attributes(problem, grid.name))
        for grid in axes for name in filter(None, (grid.name, grid.alias))
    }  # fmt: skip
    attrs = {n: v for n, v in provenance(problem, axes, METHOD).items() if n != "created"}
    graph = hashlib.sha256(str(problem.family.system.rhs).encode()).hexdigest()
    verdict = Variable("verdict", "int8", -1, _flags())
    return ZarrStore(folder, layout, (verdict,), coords, attrs,
                     {"equations": graph, "anchor": repr(problem.family.anchor)},
                     overwrite=overwrite)  # fmt: skip


@dataclass(frozen=True)
class _Chunk:
    """Work of a chunk."""

    judge: Callable[[], Judge]
    axes: tuple[Axis, Axis]
    layout: Layout

    def __call__(self, block: Block, part: slice) -> Arrays:
        rows, columns = self.layout.slices(block)
        codes, _ = _band(self.judge, self.axes[0].values[columns], self.axes[1].values[rows])
        return {"verdict": codes.astype(np.int8, copy=False).ravel()[part]}


def _undecided(count: int) -> Arrays:
    return {"verdict": np.full(count, CODES[Verdict.UNDECIDED], dtype=np.int8)}
