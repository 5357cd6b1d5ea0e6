"""Cells of a comparison: each runs in a process that may fail, and is stored as soon as it ends.

A group of tasks shares one fresh process, in order.  Several groups may run at the same time.  If a
task raises, exceeds its time limit or ends its process, its cell records that.  The rest of the
group continues, after a time limit or a dead process in another process.  Finished cells are lines
of a journal in the folder of the comparison, so that a stopped run continues where it was.

A task that hangs in a library ends only with its process (`Future.cancel` stops no running work),
which `Lanes` kill at the limit.
"""

from __future__ import annotations

import hashlib
import json
import multiprocessing
import os
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import BrokenExecutor, Future
from contextlib import closing, contextmanager
from dataclasses import dataclass
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from ..base.errors import StabilityError
from ..base.main_module import check_main
from ..base.provenance import machine
from ..base.types import Progress
from ..storage.files import postponed
from ..storage.pieces import Pieces, Records
from .pipeline import Counted, ordered, resumable
from .processes import WorkerEnded, WorkerLate, processes

START = 120.0
"""Time in which a process must start [s]."""
NOT_STARTED = (
    "the processes that do the work cannot start; in a script, make the call under "
    "`if __name__ == '__main__':`."
)
THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
"""Variables set to 1 in the processes: several threads do not help with small matrices."""
DONE, REFUSED, CRASHED, LATE = "done", "refused", "crashed", "time-out"
"""Ways in which a cell can end."""
ENDS = (DONE, REFUSED, CRASHED, LATE)
JOURNAL = "cells.jsonl"
"""Name of the journal in its folder."""
SHOWN = (
    "figures",
    "tables",
    "atlas",
    "cli",
    "compare/figures",
    "compare/report.py",
    "compare/page.py",
    "compare/plan.py",
    "compare/csv_files.py",
)
"""Folders and files that only show results: a change in them leaves cells valid."""


@dataclass(frozen=True)
class Task:
    """One cell to compute."""

    key: str
    """Name of the cell, unique in the comparison."""
    function: Callable[..., Any]
    """Function of a module, so that a process finds it; its result must fit JSON."""
    arguments: tuple[Any, ...]
    """Arguments of the function."""
    limit: float = 60.0
    """Time limit [s]."""


def run(
    groups: Sequence[Sequence[Task]],
    keep: Pieces[str, Cell],
    *,
    workers: int = 1,
    progress: Progress | None = None,
) -> dict[str, Cell]:
    """Compute the cells that are not stored yet.

    Parameters
    ----------
    groups
        Groups of tasks, in order; each group starts in a fresh process.
    keep
        Store of finished cells: a `Journal`.
    workers
        Number of groups at a time, at most the number of cores.
    progress
        Called with (cells done, cells in all).

    Returns
    -------
    dict
        Every cell by key.

    Raises
    ------
    KeyboardInterrupt
        On Ctrl-C, with a sentence on where the finished cells are.
    """
    keys = [task.key for group in groups for task in group]
    waiting = [[t for t in group if not keep.done(t.key)] for group in groups]
    tasks = {task.key: task for group in waiting for task in group}
    counted = Counted(progress, len(keys))
    with resumable(keep.folder, counted):
        counted.add(len(keys) - len(tasks))
        if tasks:
            _measure([group for group in waiting if group], tasks, keep, workers, counted)
    return {key: cell for key in keys if (cell := keep.get(key)) is not None}


def _measure(
    groups: Sequence[Sequence[Task]],
    tasks: Mapping[str, Task],
    keep: Pieces[str, Cell],
    workers: int,
    counted: Counted,
) -> None:
    """Compute cells: a process for each group, which a cell loses at its limit of time."""

    def lost(key: str, error: Exception) -> Cell:
        limit = tasks[key].limit
        if isinstance(error, WorkerLate):
            return Cell(key, LATE, None, f"no answer in {limit:g} s", limit)
        if isinstance(error, WorkerEnded):
            return Cell(key, CRASHED, None, f"its process {error}", error.seconds)
        if isinstance(error, BrokenExecutor):
            raise error
        return Cell(key, CRASHED, None, str(error), 0.0)  # an answer that cannot be sent

    number = min(workers, os.cpu_count() or 1)
    futures: dict[str, Future[Cell]] = {}
    with (
        _single_threads(),
        processes(number, _context(), fresh=True, patience=START) as pool,
    ):
        with postponed():
            for group in groups:
                pieces = [(partial(_answer, t), 1.5 * t.limit + 10.0) for t in group]
                sent = pool.submit_group(pieces)
                futures |= {t.key: future for t, future in zip(group, sent, strict=True)}
        cells = ordered(
            futures,
            futures.__getitem__,
            executor=pool,
            keep=keep,
            progress=counted,
            ahead=len(futures) + 1,
            in_order=False,
            lost=lost,
            broken=NOT_STARTED,
        )
        with closing(cells):
            for _ in cells:
                pass


@contextmanager
def _single_threads() -> Iterator[None]:
    before = {name: os.environ.get(name) for name in THREADS}
    os.environ |= dict.fromkeys(THREADS, "1")
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


def _context() -> Any:
    """A server that forks processes with the libraries imported, where the system has one.

    Each process has no graphs and no compiled code yet: their cost is that of a first call.
    """
    check_main("the comparison")
    if "forkserver" not in multiprocessing.get_all_start_methods():
        return multiprocessing.get_context("spawn")
    context = multiprocessing.get_context("forkserver")
    wanted = [
        "numpy",
        "casadi",
        "scipy.integrate",
        "flint",
        "xarray",
        "stability.motion.simulate",
        "stability.spectra.certificate",
        "stability.spectra.spectrum",
    ]
    if find_spec("heyoka") is not None:
        wanted.append("heyoka")
    context.set_forkserver_preload(wanted)
    return context


class Late(BaseException):
    """Raised in a task at its time limit; a task with part of an answer may catch it."""


def _answer(task: Task) -> Cell:
    """How a task ends, in a process of its group."""
    import signal
    import warnings

    signal.signal(signal.SIGINT, signal.SIG_IGN)
    warnings.simplefilter("ignore")  # an error in the answer counts, not a warning

    def late(*_: Any) -> None:
        raise Late

    timer = hasattr(signal, "setitimer")
    if timer:
        signal.signal(signal.SIGALRM, late)
    start = time.perf_counter()
    try:
        if timer:
            signal.setitimer(signal.ITIMER_REAL, task.limit)
        answer: tuple[str, Any, str] = (DONE, task.function(*task.arguments), "")
    except StabilityError as error:
        answer = (REFUSED, None, str(error))
    except Late:
        answer = (LATE, None, f"no answer in {task.limit:g} s")
    except Exception as error:
        answer = (CRASHED, None, f"{type(error).__name__}: {error}"[:300])
    finally:
        if timer:
            signal.setitimer(signal.ITIMER_REAL, 0)
    return Cell(task.key, *answer, time.perf_counter() - start)


@dataclass(frozen=True)
class Cell:
    """One cell that has ended."""

    key: str
    """Name of the cell's task."""
    status: str
    """done, refused, crashed or time-out."""
    value: Any
    """Result of the task; None unless done."""
    message: str
    """Message of the error or of the time limit; empty if done."""
    seconds: float
    """Time of the task [s], without the start of its process."""


class Journal(Records[str, Cell]):
    """Finished cells in a file of a folder.

    Parameters
    ----------
    folder
        Folder of the journal; created if it is missing.

    Raises
    ------
    FileError
        If the folder or its journal cannot be used.
    """

    def __init__(self, folder: Path) -> None:
        super().__init__(folder / JOURNAL, fingerprint(), _cell)


def _cell(record: dict[str, Any]) -> Cell:
    cell = Cell(**record)
    if not isinstance(cell.key, str) or cell.status not in ENDS:
        raise ValueError
    return cell


def fingerprint() -> str:
    """Checksum of what cells depend on: sources of the package, versions and the machine.

    Examples
    --------
    >>> fingerprint() == fingerprint()
    True
    """
    digest = hashlib.sha256()
    root = Path(__file__).resolve().parents[1]
    for path in sorted([*root.rglob("*.py"), *root.rglob("*.json")]):
        place = path.relative_to(root).as_posix()
        if any(place == shown or place.startswith(f"{shown}/") for shown in SHOWN):
            continue
        digest.update(path.read_bytes())
    digest.update(json.dumps(machine(), sort_keys=True).encode())
    return digest.hexdigest()
