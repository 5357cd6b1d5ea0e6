"""Work on chunks that logs each execution, and ends its worker in the cells that it is told."""

from __future__ import annotations

import hashlib
import os
import signal
import sys
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stability.jobs.dask import engine
from stability.jobs.filling import Filled, fill
from stability.storage.chunks import Layout, Variable
from stability.storage.zarr_store import ZarrStore

LAYOUT = Layout(("y", "x"), (9, 10), (2, 4))
"""Fifteen chunks; those at two edges are smaller."""
VARIABLES = (
    Variable(
        "outcome",
        "int8",
        -1,
        {"flag_values": [0, 1, 2, 3, 4, 9], "flag_meanings": "a b c d e unresolved"},
    ),
    Variable("time", "float64", float("nan"), {"units": "s", "long_name": "time of the event"}),
    Variable("last", "float32", 0.0, {}, (("state", 3),)),
)
COORDS: dict[str, Any] = {
    "x": ("x", np.linspace(0.0, 1.0, 10), {"units": "rad"}),
    "y": ("y", np.arange(9.0), {}),
    "start": (("y", "x"), np.arange(90.0).reshape(9, 10) ** 2, {"units": "m/s"}),
    "state": ("state", ["theta", "phi", "psi"], {}),
}
ATTRS = {"title": "numbers of cells", "lengths": np.array([1, 2])}


@dataclass(frozen=True)
class Logged:
    """Values that follow from the number of a cell."""

    log: str
    """File that gets a line for each execution."""
    seconds: float = 0.0
    """Time that it takes [s]."""
    deadly: tuple[int, ...] = ()
    """Numbers of the cells that end their worker."""
    spare: str = ""
    """Once this file is there, no cell ends its worker; the first death makes it."""
    layout: Layout = LAYOUT

    def __call__(self, block: tuple[int, ...], part: slice) -> Mapping[str, NDArray[Any]]:
        line = f"{'.'.join(map(str, block))} {part.start} {part.stop}\n"
        handle = os.open(self.log, os.O_WRONLY | os.O_CREAT | os.O_APPEND)
        os.write(handle, line.encode())
        os.close(handle)
        time.sleep(self.seconds)
        rows, columns = self.layout.slices(block)
        cells = np.arange(self.layout.total).reshape(self.layout.shape)[rows, columns].ravel()[part]
        if set(cells.tolist()) & set(self.deadly) and not (
            self.spare and Path(self.spare).exists()
        ):
            if self.spare:
                Path(self.spare).touch()
            os.kill(os.getpid(), signal.SIGKILL)
        return values(cells)


def values(cells: NDArray[Any]) -> dict[str, NDArray[Any]]:
    return {
        "outcome": (cells % 5).astype(np.int8),
        "time": np.sqrt(cells),
        "last": np.stack([np.sin(cells), np.cos(cells), cells], axis=-1).astype(np.float32),
    }


def blank(count: int) -> dict[str, NDArray[Any]]:
    return {
        "outcome": np.full(count, 9, np.int8),
        "time": np.full(count, np.nan),
        "last": np.zeros((count, 3), np.float32),
    }


def store(path: Path, **changed: Any) -> ZarrStore:
    parts: dict[str, Any] = {
        "layout": LAYOUT,
        "variables": VARIABLES,
        "coords": COORDS,
        "attrs": ATTRS,
        "question": {"horizon": 40.0, "body": {"k": 0.25}},
    }
    return ZarrStore(path, **(parts | changed))


def cells(block: tuple[int, ...]) -> list[int]:
    """Numbers of the cells of a chunk."""
    found = np.arange(90).reshape(9, 10)[LAYOUT.slices(block)].ravel()
    return [int(cell) for cell in found]


def done(log: Path) -> list[str]:
    """The executions: chunk, first and last cell."""
    return log.read_text().splitlines() if log.exists() else []


def tree(folder: Path) -> dict[str, str]:
    """Checksum of every file of a folder."""
    return {
        str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }


def undisturbed(path: Path) -> dict[str, str]:
    """Files of a store that one thread fills from end to end, once in a process."""
    from stability.jobs.pipeline import here

    if not _ALONE:
        fill(store(path), Logged(os.devnull), blank=blank, start_pool=here)
        _ALONE.update(tree(path))
    return dict(_ALONE)


_ALONE: dict[str, str] = {}


def others_kept(path: Path, lost: set[int]) -> None:
    """Every cell but the lost ones has its value, and these are blank."""
    found = store(path).dataset().load()
    empty = blank(1)
    for name, array in values(np.arange(LAYOUT.total)).items():
        there = found[name].values.reshape(array.shape)
        for cell in range(LAYOUT.total):
            wanted = empty[name][0] if cell in lost else array[cell]
            assert np.array_equal(there[cell], wanted, equal_nan=name != "outcome"), (name, cell)


def run(name: str, seconds: float, path: str = "a.zarr", log: str = "log") -> Filled:
    """Fill a store by two workers of an engine."""
    with engine(name, 2) as (executor, workers):
        return fill(
            store(Path(path)),
            Logged(os.path.abspath(log), seconds),
            blank=blank,
            executor=executor,
            workers=workers,
        )


if __name__ == "__main__":
    run(sys.argv[1], float(sys.argv[2]))
