"""Verdicts written band by band into a NetCDF file, which is complete or absent."""

from __future__ import annotations

import io
import math
import os
from collections.abc import Callable, Iterator
from concurrent.futures import Executor
from contextlib import closing, contextmanager
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from ...base.axis import Axis
from ...base.types import Progress
from ...jobs.chunks import Layout
from ...jobs.pipeline import Counted, ordered, shared
from ...spectra.presentation.labels import axis_attributes
from ...spectra.problem import Problem
from ...storage.checksum import ATTRIBUTE, STATEMENT, seal
from ...storage.files import atomic_write, postponed
from ..dataset import provenance
from ..verdict_tiles import Codes
from .verdicts import METHOD, Judge, band, flags


def write_verdicts(
    target: Path,
    judge: Judge,
    problem: Problem,
    axes: tuple[Axis, Axis],
    layout: Layout,
    *,
    executor: Executor | None,
    workers: int,
    progress: Progress | None,
    overwrite: bool,
) -> None:
    """Write a NetCDF file with its checksum.

    Parameters
    ----------
    target
        The file.
    judge
        What gives the verdicts.
    problem, axes
        Family with values in the user's units; x and y.
    layout
        Chunks of the file; a band is a row of them.
    executor, workers, progress, overwrite
        As for `stream_map`.
    """
    with atomic_write(target, overwrite=overwrite) as draft:
        with _Sink(draft) as sink:
            # an exception within HDF5's calls of the sink, even Ctrl-C, would end the process
            file = None
            try:
                with postponed():
                    file, variable = _created(sink, problem, axes, layout)
                left = _fill(
                    variable, sink, judge, axes, layout.chunk[0], workers, progress, executor
                )
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


def _fill(
    variable: Any,
    sink: _Sink,
    verdicts: Judge,
    axes: tuple[Axis, Axis],
    step: int,
    workers: int,
    progress: Progress | None,
    executor: Executor | None,
) -> int:
    """Write the bands in order; return the number of cells that went to exact arithmetic."""
    xs, ys = axes[0].values, axes[1].values
    left, judge, total = 0, shared(verdicts, executor), math.prod(g.count for g in axes)

    def task(first: int) -> Callable[[], tuple[Codes, int]]:
        return partial(band, judge, xs, ys[first : first + step])

    with closing(
        ordered(
            range(0, len(ys), step),
            task,
            executor=executor,
            workers=workers,
            progress=Counted(progress, total),
            size=lambda first: min(step, len(ys) - first) * len(xs),
        )
    ) as results:
        for first, (codes, open_cells) in results:
            with postponed():
                variable[first : first + len(codes), :] = codes
            sink.check()
            left += open_cells
    return left


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


def _created(
    path: _Sink, problem: Problem, axes: tuple[Axis, Axis], layout: Layout
) -> tuple[Any, Any]:
    import h5netcdf

    file = h5netcdf.File(path, "w")
    file.dimensions = {g.name: g.count for g in axes}
    for grid in axes:
        for name in filter(None, (grid.name, grid.alias)):
            coordinate = file.create_variable(name, (grid.name,), float, data=grid.values)
            coordinate.attrs.update(axis_attributes(problem, grid.name))
    second = [g.alias for g in axes if g.alias]
    verdict = file.create_variable(
        "verdict",
        (axes[1].name, axes[0].name),
        np.int8,
        chunks=layout.chunk,
        compression="gzip",
        compression_opts=1,
    )
    verdict.attrs.update(flags() | ({"coordinates": " ".join(second)} if second else {}))
    file.attrs.update(provenance(problem, axes, METHOD))
    return file, verdict
