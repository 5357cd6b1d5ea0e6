"""Cells of a comparison: each runs in a process that may fail, and is stored as soon as it ends.

A group of tasks shares one fresh process, in order.  Several groups may run at the same time.  If a
task raises, exceeds its time limit or ends its process, its cell records that.  The rest of the
group continues, after a time limit or a dead process in another process.  Finished cells are lines
of a journal in the folder of the comparison, so that a stopped run continues where it was.

No `concurrent.futures.Executor` can do this.  A task that hangs in a library cannot be ended
(`Future.cancel` stops no running work).  A worker that dies breaks the whole pool, and with it
every other task.  So this module starts the processes.  Progress, interruption and the protocol of
the store are those of `pipeline`.
"""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from multiprocessing.connection import Connection, wait
from typing import Any

from ..base.calls.main_module import check_main
from ..base.errors import StabilityError
from ..base.types import Progress
from ..storage.files import STOPS, ignoring_signals
from .following import follow
from .journal import CRASHED, DONE, LATE, REFUSED, Cell
from .pipeline import Counted, Keep, resumable

START = 120.0
"""Time in which a process must start [s]."""
THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
"""Variables set to 1 in the processes: several threads do not help with small matrices."""


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


# --- running ---


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
    with resumable(keep.folder, counted):
        try:
            counted.add(len(keys) - sum(len(group) for group in waiting))
            while waiting or lanes:
                while waiting and len(lanes) < lanes_at_most:
                    lanes.append(_Lane(waiting.pop(0)))
                for lane, cell in _ended(lanes):
                    keep.add(cell.key, cell)
                    counted.add(1)
                    if not lane.left:
                        lane.stop()
                        lanes.remove(lane)
        finally:
            for lane in lanes:
                lane.stop()
    return {key: found for key in keys if (found := keep.get(key)) is not None}


class _Lane:
    """A process that works through a group."""

    def __init__(self, tasks: Sequence[Task]) -> None:
        self.left = list(tasks)
        self._start()

    def _start(self) -> None:
        context = _context()
        self.pipe, theirs = context.Pipe()
        self.process = context.Process(target=_work, args=(theirs,), daemon=True)
        try:
            with (
                _single_threads(),
                ignoring_signals(),
            ):  # this process handles signals to stop
                self.process.start()
            theirs.close()
            if not self.pipe.poll(START):
                raise EOFError
            self.pipe.recv()
        except KeyboardInterrupt:
            self.stop()
            raise
        except (EOFError, OSError):
            self.stop()
            raise StabilityError(
                "the processes that do the work cannot start; in a script, make the call under "
                "`if __name__ == '__main__':`."
            ) from None
        self._next()

    def _next(self) -> None:
        task = self.left[0]
        self.since = time.monotonic()
        # time counts from here, after the start of the process
        self.deadline = self.since + 1.5 * task.limit + 10.0
        with contextlib.suppress(OSError):
            self.pipe.send((task.function, task.arguments, task.limit))

    def outcome(self) -> Cell | None:
        """The cell that has just ended, or None."""
        task = self.left[0]
        found: Cell | None = None
        dead = False
        if self.pipe.poll():
            try:
                status, value, message, seconds = self.pipe.recv()
                found = Cell(task.key, status, value, message, seconds)
            except (EOFError, OSError):
                dead = True
        if found is None and not dead and time.monotonic() > self.deadline:
            found = Cell(task.key, LATE, None, f"no answer in {task.limit:g} s", task.limit)
            dead = True
        elif dead or (found is None and not self.process.is_alive()):
            dead = True
            self.process.join(5)
            code = self.process.exitcode
            took = time.monotonic() - self.since
            found = Cell(task.key, CRASHED, None, f"its process ended with code {code}", took)
        if found is None:
            return None
        self.left.pop(0)
        if dead or found.status == LATE:
            self.stop()
            if self.left:
                self._start()
        elif self.left:
            self._next()
        return found

    def stop(self) -> None:
        """End the process."""
        if self.process.pid is not None:
            self.process.kill()
            self.process.join()
        self.pipe.close()


def _ended(lanes: list[_Lane]) -> Iterator[tuple[_Lane, Cell]]:
    wait([lane.pipe for lane in lanes], timeout=0.5)
    for lane in list(lanes):
        cell = lane.outcome()
        if cell is not None:
            yield lane, cell


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


def _work(pipe: Connection) -> None:
    """Answer tasks until the pipe closes."""
    import signal

    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if hasattr(signal, "pthread_sigmask"):  # SIGTERM, blocked at the start, must end it
        signal.pthread_sigmask(signal.SIG_UNBLOCK, STOPS)
    follow(os.getppid())
    with contextlib.suppress(OSError):  # the parent has ended
        _answer(pipe)


def _answer(pipe: Connection) -> None:
    import signal
    import warnings

    pipe.send("ready")
    warnings.simplefilter("ignore")  # an error in the answer counts, not a warning

    def late(*_: Any) -> None:
        raise Late

    timer = hasattr(signal, "setitimer")
    if timer:
        signal.signal(signal.SIGALRM, late)
    while True:
        try:
            function, arguments, limit = pipe.recv()
        except (EOFError, OSError):
            return
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
        pipe.send((*answer, time.perf_counter() - start))
