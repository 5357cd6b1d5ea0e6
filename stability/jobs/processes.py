"""Worker processes that end when the process that started them ends, even by SIGKILL."""

from __future__ import annotations

import ctypes
import math
import multiprocessing
import os
import pickle
import signal
import sys
import threading
import time
import traceback
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import BrokenExecutor, Executor, Future
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from functools import cache, partial
from itertools import chain
from multiprocessing.connection import Connection, wait
from multiprocessing.context import BaseContext
from multiprocessing.reduction import ForkingPickler
from typing import Any, TypeVar, cast

from ..storage.files import ignoring_signals

T = TypeVar("T")
LOOK = 0.5
"""Time between two looks at the parent [s]."""
PR_SET_PDEATHSIG = 1
"""Option of Linux's prctl: the signal that a process gets when its parent ends."""
STARTS = 3
"""Processes in a row that end before they start, after which no other is tried."""
NOT_STARTED = "the processes do not start"


def follow(parent: int) -> None:
    """End this process as soon as its parent has ended; called first in a worker.

    On Linux the kernel sends the signal, even in the middle of a long call.  On every system a
    thread also looks twice a second.
    """
    if sys.platform.startswith("linux"):
        with suppress(OSError, AttributeError):
            ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, int(signal.SIGKILL), 0, 0, 0)
    if os.getppid() != parent:  # the parent ended before
        os._exit(1)
    threading.Thread(target=_watch, args=(parent,), daemon=True).start()


def _watch(parent: int) -> None:
    while os.getppid() == parent:
        time.sleep(LOOK)
    os._exit(1)


@cache
def follow_starter() -> None:
    """End this process when the one that started it by `multiprocessing` has ended.

    For a worker of an executor that a user gives.  The kernel's signal would come with the end of
    the thread that started the worker; the rest of the program may run longer than that thread.
    """
    starter = multiprocessing.parent_process()
    if starter is not None:
        threading.Thread(target=_outlived, args=(starter,), daemon=True).start()


def _outlived(starter: Any) -> None:
    starter.join()
    os._exit(1)


class WorkerEnded(BrokenExecutor):
    """The worker of a piece of work ended before the work did; others are not concerned."""

    seconds = 0.0
    """Time since the piece was sent [s]."""


class WorkerLate(WorkerEnded):
    """The worker was ended at the limit of time of its piece."""


def worker_ended(error: BaseException) -> bool:
    """Whether an error says that a worker ended, while its executor takes more work."""
    kind = type(error)
    return isinstance(error, WorkerEnded) or (
        kind.__name__ == "KilledWorker" and kind.__module__.startswith("distributed")
    )


@dataclass(frozen=True)
class _Sent:
    """A piece that was given to an executor of processes."""

    content: bytes
    """Function and arguments."""
    limit: float
    """Time after which its process is ended [s]."""
    future: Future[Any] = field(default_factory=Future)
    """What waits for it."""


_Group = deque[_Sent]
"""Pieces that one process does in order."""


@dataclass
class _Lane:
    """A process and the group that it does; one thread alone uses it."""

    process: Any
    """The process."""
    pipe: Connection
    """Pieces to it, answers from it."""
    deadline: float
    """Time at which it must have started, or answered."""
    ready: bool = False
    """Whether the process has started."""
    group: _Group = field(default_factory=deque)
    """The piece that it does, and those that it does afterwards."""
    since: float = 0.0
    """Time at which it got its piece."""

    def begin(self) -> None:
        """Send the next piece of the group that is not cancelled."""
        while self.group and not self.group[0].future.set_running_or_notify_cancel():
            self.group.popleft()
        self.since = time.monotonic()
        self.deadline = math.inf
        if self.group:
            self.deadline = self.since + self.group[0].limit
            with suppress(OSError):  # it has ended, as its answer will show
                self.pipe.send_bytes(self.group[0].content)

    def answer(self) -> tuple[bool, Any] | None:
        """Whether the piece has a result, and the result or error; None if the process ended."""
        try:
            if not self.pipe.poll():  # a process that it started holds the pipe
                return None
            return cast(tuple[bool, Any], pickle.loads(self.pipe.recv_bytes()))
        except (EOFError, OSError):
            return None
        except Exception as error:  # the answer's own code may raise anything
            return False, error

    def stop(self) -> None:
        """Kill the process."""
        self.process.kill()
        self.process.join()
        self.pipe.close()


class Lanes(Executor):
    """Processes that do one piece each at a time; one that ends is replaced and fails its piece.

    A thread starts and serves them, because Linux ends a process with the thread that started it.

    Parameters
    ----------
    workers
        Number of processes.
    context
        How `multiprocessing` starts them; by `spawn` when left out.
    fresh
        Whether each group of pieces gets a process of its own, which ends with the group.
    patience
        Time in which a process must start [s].
    """

    def __init__(
        self,
        workers: int,
        context: BaseContext | None = None,
        *,
        fresh: bool = False,
        patience: float = math.inf,
    ) -> None:
        self._workers, self._fresh, self._patience = workers, fresh, patience
        self._context: Any = context or multiprocessing.get_context("spawn")
        self._lock = threading.Lock()
        self._waiting: deque[_Group] = deque()
        self._heard, self._bell = self._context.Pipe(duplex=False)
        self._closed = self._broken = self._killed = False
        self._failures = 0
        self._lanes: list[_Lane] = []
        self._thread = threading.Thread(target=self._serve, daemon=True)
        self._thread.start()

    def submit(self, fn: Callable[..., T], /, *args: Any, **kwargs: Any) -> Future[T]:
        """Send a piece, as for any executor."""
        [future] = self.submit_group([(partial(fn, *args, **kwargs), math.inf)])
        return future

    def submit_group(self, pieces: Iterable[tuple[Callable[[], T], float]]) -> list[Future[T]]:
        """Send pieces that one process does in order, each with its limit of time [s].

        A process that ends, or is ended at a limit, fails its piece; another one does the rest.
        """
        futures: list[Future[T]] = []
        group: _Group = deque()
        for work, limit in pieces:
            try:
                group.append(_Sent(bytes(ForkingPickler.dumps(work)), limit))
                futures.append(group[-1].future)
            except Exception as error:
                futures.append(Future())
                futures[-1].set_exception(error)
        with self._lock:
            if self._closed:
                raise RuntimeError("cannot schedule new futures after shutdown")
            if self._broken:
                raise BrokenExecutor(NOT_STARTED)
            if group:
                self._waiting.append(group)
            self._bell.send_bytes(b".")
        return futures

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """End the processes when the pieces are done, as for any executor."""
        with self._lock:
            if cancel_futures:
                for sent in chain.from_iterable(self._waiting):
                    sent.future.cancel()
                self._waiting.clear()
            if not self._closed:
                self._closed = True
                self._bell.send_bytes(b".")
        if wait:
            self._thread.join()

    def kill(self) -> None:
        """End every process at once, and wait for that."""
        self._killed = True
        self.shutdown(cancel_futures=True)

    def _serve(self) -> None:
        try:
            while not self._killed and not (self._closed and not self._waiting and self._idle()):
                self._send()
                pipes: list[Any] = [lane.pipe for lane in self._lanes]
                ends = [lane.process.sentinel for lane in self._lanes]
                ready = set(wait([self._heard, *pipes, *ends], self._until_deadline()))
                if self._heard in ready:
                    self._heard.recv_bytes()
                for lane, end in zip(list(self._lanes), ends, strict=True):
                    if lane.pipe in ready or end in ready:
                        self._hear(lane)
                    elif lane.deadline <= time.monotonic():
                        self._replace(lane, WorkerLate("ended at its limit of time"))
        finally:  # also where the system starts no process or has no memory
            for lane in self._lanes:
                lane.stop()
                if lane.group:
                    lane.group.popleft().future.set_exception(
                        BrokenExecutor("the work was stopped")
                    )
                    self._waiting.append(lane.group)
            self._fail()

    def _idle(self) -> bool:
        return not any(lane.group for lane in self._lanes)

    def _until_deadline(self) -> float | None:
        """Time until the next limit; None without one."""
        first = min((lane.deadline for lane in self._lanes), default=math.inf)
        return None if math.isinf(first) else max(0.0, first - time.monotonic())

    def _send(self) -> None:
        """Give waiting groups to idle processes, and start those that are needed."""
        free = [lane for lane in self._lanes if lane.ready and not lane.group]
        with self._lock:
            while self._waiting and free:
                free[-1].group = self._waiting.popleft()
                free[-1].begin()
                if free[-1].group:
                    free.pop()
            wanted = len(self._waiting)
        starting = sum(not lane.ready for lane in self._lanes)
        for _ in range(min(wanted - starting, self._workers - len(self._lanes))):
            self._start()

    def _start(self) -> None:
        pipe, theirs = self._context.Pipe()
        # a server that forks processes is their parent
        parent = os.getpid() if self._context.get_start_method() == "spawn" else None
        process = self._context.Process(target=_serve_pieces, args=(theirs, parent), daemon=False)
        with ignoring_signals():
            process.start()
        theirs.close()
        self._lanes.append(_Lane(process, pipe, time.monotonic() + self._patience))

    def _hear(self, lane: _Lane) -> None:
        """Take the answer of a process, or replace it."""
        answer = lane.answer()
        if answer is None:
            self._replace(lane, WorkerEnded())
        elif not lane.ready:
            lane.ready, lane.deadline, self._failures = True, math.inf, 0
        else:
            done, value = answer
            future = lane.group.popleft().future
            if done:
                future.set_result(value)
            else:
                future.set_exception(value)
            lane.begin()
            if self._fresh and not lane.group:
                lane.stop()
                self._lanes.remove(lane)

    def _replace(self, lane: _Lane, error: WorkerEnded) -> None:
        """Stop a process that ended or is late, and fail its piece; the rest of its group waits."""
        lane.stop()
        self._lanes.remove(lane)
        if not lane.ready:
            self._failures += STARTS if isinstance(error, WorkerLate) else 1
            if self._failures >= STARTS:
                self._fail()
        elif lane.group:
            error.args = error.args or (f"ended with code {lane.process.exitcode}",)
            error.seconds = time.monotonic() - lane.since
            lane.group.popleft().future.set_exception(error)
            if lane.group:
                with self._lock:
                    self._waiting.appendleft(lane.group)

    def _fail(self) -> None:
        """Take no more pieces; those that wait fail."""
        with self._lock:
            self._broken = True
            waiting, self._waiting = self._waiting, deque()
        for sent in chain.from_iterable(waiting):
            if sent.future.set_running_or_notify_cancel():
                sent.future.set_exception(BrokenExecutor(NOT_STARTED))


def _serve_pieces(pipe: Connection, parent: int | None) -> None:
    """Do pieces until the pipe closes: the life of a process of `Lanes`."""
    follow(os.getppid() if parent is None else parent)
    pipe.send_bytes(pickle.dumps((True, None)))
    while True:
        try:
            piece = pipe.recv_bytes()
        except (EOFError, OSError):
            return
        try:
            answer: tuple[bool, Any] = (True, pickle.loads(piece)())
        except BaseException as error:
            error.add_note("".join(traceback.format_exception(error)))
            answer = (False, error)
        try:
            content = bytes(ForkingPickler.dumps(answer))
            if not answer[0]:  # errors may be written and not be read again
                pickle.loads(content)
        except Exception as error:
            said = RuntimeError(f"the answer of a worker cannot be sent: {answer[1]!r} ({error})")
            content = pickle.dumps((False, said))
        pipe.send_bytes(content)


@contextmanager
def processes(
    workers: int,
    context: BaseContext | None = None,
    *,
    fresh: bool = False,
    patience: float = math.inf,
) -> Iterator[Lanes]:
    """Processes of this package, killed where the work fails: they need no clean-up.

    Parameters
    ----------
    workers, context, fresh, patience
        As for `Lanes`.
    """
    pool = Lanes(workers, context, fresh=fresh, patience=patience)
    try:
        yield pool
        pool.shutdown()
    except BaseException:
        pool.kill()
        raise
