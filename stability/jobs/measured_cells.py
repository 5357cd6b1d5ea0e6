"""Cells of a comparison: each runs in a process that may fail, and is stored as soon as it ends.

A group of tasks shares one fresh process, in order.  Several groups may run at the same time.  If a
task raises, exceeds its time limit or ends its process, its cell records that.  The rest of the
group continues, after a time limit or a dead process in another process.  Finished cells are lines
of a journal in the folder of the comparison, so that a stopped run continues where it was.

No `concurrent.futures.Executor` can end a task that hangs in a library (`Future.cancel` stops no
running work).  So each group has an executor of its own, with one process, and that executor is
killed at the limit.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import multiprocessing
import os
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import BrokenExecutor, Future
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from queue import Empty, SimpleQueue
from typing import Any

from ..base.errors import FileError, StabilityError
from ..base.main_module import check_main
from ..base.provenance import machine
from ..base.types import Progress
from ..storage.files import atomic_write, postponed
from ..storage.litter import clear
from ..storage.targets import path_text, refusing
from ..storage.text import marked, unmarked
from .pipeline import Counted, Keep, resumable
from .processes import Lanes, WorkerEnded

START = 120.0
"""Time in which a process must start [s]."""
LOOK = 0.5
"""Time between two looks at the limits of time [s]."""
THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
"""Variables set to 1 in the processes: several threads do not help with small matrices."""
MARK = "fingerprint"
"""The first word of a journal."""
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
    keep: Keep[str, Cell],
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
    lanes_at_most = min(workers, os.cpu_count() or 1)
    keys = [task.key for group in groups for task in group]
    counted = Counted(progress, len(keys))
    waiting = [[t for t in group if not keep.done(t.key)] for group in groups]
    waiting = [group for group in waiting if group]
    lanes: list[_Lane] = []
    ended: SimpleQueue[Any] = SimpleQueue()
    with resumable(keep.folder, counted), _single_threads():
        try:
            counted.add(len(keys) - sum(len(group) for group in waiting))
            while waiting or lanes:
                while waiting and len(lanes) < lanes_at_most:
                    lanes.append(_Lane(waiting.pop(0), ended))
                with contextlib.suppress(Empty):
                    ended.get(timeout=LOOK)
                for lane in list(lanes):
                    cell = lane.outcome()
                    if cell is None:
                        continue
                    keep.add(cell.key, cell)
                    counted.add(1)
                    if not lane.left:
                        lane.pool.kill()
                        lanes.remove(lane)
        finally:
            for lane in lanes:
                lane.pool.kill()
    return {key: found for key in keys if (found := keep.get(key)) is not None}


class _Lane:
    """A process that works through a group."""

    def __init__(self, tasks: Sequence[Task], ended: SimpleQueue[Any]) -> None:
        self.left, self._ended = list(tasks), ended
        self._start()

    def _start(self) -> None:
        self.pool = Lanes(1, _context())
        try:
            started: SimpleQueue[Any] = SimpleQueue()
            self._sent(started, int)
            started.get(timeout=START).result()
        except (Empty, BrokenExecutor):
            self.pool.kill()
            raise StabilityError(
                "the processes that do the work cannot start; in a script, make the call under "
                "`if __name__ == '__main__':`."
            ) from None
        except KeyboardInterrupt:
            self.pool.kill()
            raise
        self._next()

    def _sent(self, ended: SimpleQueue[Any], work: Callable[..., Any], *given: Any) -> Future[Any]:
        with postponed():
            future = self.pool.submit(work, *given)
            future.add_done_callback(ended.put)
        return future

    def _next(self) -> None:
        task = self.left[0]
        self.since = time.monotonic()  # the process has started
        self.deadline = self.since + 1.5 * task.limit + 10.0
        self.future = self._sent(self._ended, _answer, task.function, task.arguments, task.limit)

    def outcome(self) -> Cell | None:
        """The cell that has just ended, or None."""
        task = self.left[0]
        if self.future.done():
            found = self._cell(task)
        elif time.monotonic() > self.deadline:
            found = Cell(task.key, LATE, None, f"no answer in {task.limit:g} s", task.limit)
        else:
            return None
        self.left.pop(0)
        if found.status == LATE or self.future.exception() is not None:
            self.pool.kill()
            if self.left:
                self._start()
        elif self.left:
            self._next()
        return found

    def _cell(self, task: Task) -> Cell:
        """The cell of a task whose process has answered or ended."""
        try:
            return Cell(task.key, *self.future.result())
        except WorkerEnded as error:
            why = f"its process {error}"
        except Exception as error:  # an answer that cannot be sent
            why = str(error)
        return Cell(task.key, CRASHED, None, why, time.monotonic() - self.since)


@contextlib.contextmanager
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


def _answer(
    function: Callable[..., Any], arguments: tuple[Any, ...], limit: float
) -> tuple[str, Any, str, float]:
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
            signal.setitimer(signal.ITIMER_REAL, limit)
        answer: tuple[str, Any, str] = (DONE, function(*arguments), "")
    except StabilityError as error:
        answer = (REFUSED, None, str(error))
    except Late:
        answer = (LATE, None, f"no answer in {limit:g} s")
    except Exception as error:
        answer = (CRASHED, None, f"{type(error).__name__}: {error}"[:300])
    finally:
        if timer:
            signal.setitimer(signal.ITIMER_REAL, 0)
    return (*answer, time.perf_counter() - start)


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


class Journal:
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
        self.folder, self.path = folder, folder / JOURNAL
        self.cells: dict[str, Cell] = {}
        head = json.dumps({MARK: fingerprint()})
        try:
            folder.mkdir(exist_ok=True)
            clear(folder, always=True)
            there = self.path.is_symlink() or self.path.exists()
            if there and not is_journal(self.path):
                raise FileError(
                    f"{path_text(self.path)} is not a journal of ours; choose another folder."
                )
            text = self.path.read_text(encoding="utf-8", errors="replace") if there else ""
            lines = text.splitlines()
            if lines and lines[0] == head:  # otherwise sources, versions or machine have changed
                self._read(lines[1:])
            kept = "".join(_line(cell) for cell in self.cells.values())
            if text != f"{head}\n{kept}":  # a line is cut short, or cells are no longer valid
                with atomic_write(self.path, overwrite=True, result=False) as draft:
                    draft.write_text(f"{head}\n{kept}", encoding="utf-8")
        except OSError as error:
            raise FileError(
                f"{path_text(self.path)} cannot be used: {error.strerror or error}."
            ) from None

    def _read(self, lines: list[str]) -> None:
        for line in lines:
            body, _, digest = line.rpartition("\t")
            if digest != _digest(body):  # cut short or damaged: the cell is computed again
                continue
            with contextlib.suppress(ValueError, TypeError, RecursionError):
                cell = Cell(**json.loads(body, object_hook=unmarked))
                if isinstance(cell.key, str) and cell.status in ENDS:
                    self.cells[cell.key] = cell

    def done(self, key: str) -> bool:
        """Whether a cell has ended."""
        return key in self.cells

    def get(self, key: str) -> Cell | None:
        """A cell that has ended, or None."""
        return self.cells.get(key)

    def add(self, key: str, value: Cell) -> None:
        """Write a cell at once."""
        self.cells[key] = value
        with refusing(self.path), self.path.open("a", encoding="utf-8") as handle:
            handle.write(_line(value))


def _line(cell: Cell) -> str:
    """A cell as JSON, a tab, and the beginning of the checksum of the JSON."""
    body = json.dumps(marked(vars(cell)), allow_nan=False)
    return f"{body}\t{_digest(body)}\n"


def _digest(body: str) -> str:
    return hashlib.sha256(body.encode()).hexdigest()[:16]


def is_journal(path: Path) -> bool:
    """Whether a file is a journal of a comparison.

    Parameters
    ----------
    path
        The file, which may be missing.

    Returns
    -------
    bool
    """
    if path.is_symlink() or not path.is_file():
        return False
    with path.open("rb") as handle:
        return handle.read(len(MARK) + 2) == f'{{"{MARK}'.encode()


def fingerprint() -> str:
    """Checksum of what cells depend on: sources of the package, versions and the machine.

    Returns
    -------
    str

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
