"""Worker processes that end when the process that started them ends, even by SIGKILL."""

from __future__ import annotations

import ctypes
import multiprocessing
import os
import pickle
import signal
import sys
import threading
import time
import traceback
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import BrokenExecutor, Executor, Future
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import cache
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

    Parameters
    ----------
    parent
        Process number of the parent.
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


def worker_ended(error: BaseException) -> bool:
    """Whether an error says that a worker ended, while its executor takes more work.

    Parameters
    ----------
    error
        What a future raised: our own, or that of `distributed`, which is not imported for this.

    Returns
    -------
    bool
    """
    kind = type(error)
    return isinstance(error, WorkerEnded) or (
        kind.__name__ == "KilledWorker" and kind.__module__.startswith("distributed")
    )


@dataclass
class _Lane:
    """A process and the piece that it does; one thread alone uses it."""

    process: Any
    """The process."""
    pipe: Connection
    """Pieces to it, answers from it."""
    ready: bool = False
    """Whether the process has started."""
    future: Future[Any] | None = None
    """What waits for the piece; None where there is none."""

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
    """

    def __init__(self, workers: int, context: BaseContext | None = None) -> None:
        self._workers = workers
        self._context: Any = context or multiprocessing.get_context("spawn")
        self._lock = threading.Lock()
        self._waiting: deque[tuple[Future[Any], bytes]] = deque()
        self._heard, self._bell = self._context.Pipe(duplex=False)
        self._closed = self._broken = self._killed = False
        self._failures = 0
        self._lanes: list[_Lane] = []
        self._thread = threading.Thread(target=self._serve, daemon=True)
        self._thread.start()

    def submit(self, fn: Callable[..., T], /, *args: Any, **kwargs: Any) -> Future[T]:
        """Send a piece, as for any executor."""
        future: Future[T] = Future()
        try:
            piece = bytes(ForkingPickler.dumps((fn, args, kwargs)))
        except Exception as error:
            future.set_exception(error)
            return future
        with self._lock:
            if self._closed:
                raise RuntimeError("cannot schedule new futures after shutdown")
            if self._broken:
                raise BrokenExecutor(NOT_STARTED)
            self._waiting.append((future, piece))
            self._bell.send_bytes(b".")
        return future

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """End the processes when the pieces are done, as for any executor."""
        with self._lock:
            if cancel_futures:
                for future, _ in self._waiting:
                    future.cancel()
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
                ready = set(wait([self._heard, *pipes, *ends]))
                if self._heard in ready:
                    self._heard.recv_bytes()
                for lane, end in zip(list(self._lanes), ends, strict=True):
                    if lane.pipe in ready or end in ready:
                        self._hear(lane)
        finally:  # also where the system starts no process or has no memory
            for lane in self._lanes:
                lane.stop()
                if lane.future is not None:
                    lane.future.set_exception(BrokenExecutor("the work was stopped"))
            self._fail()

    def _idle(self) -> bool:
        return all(lane.future is None for lane in self._lanes)

    def _send(self) -> None:
        """Give waiting pieces to idle processes, and start those that are needed."""
        free = [lane for lane in self._lanes if lane.ready and lane.future is None]
        with self._lock:
            while self._waiting and free:
                future, piece = self._waiting.popleft()
                if future.set_running_or_notify_cancel():
                    lane = free.pop()
                    lane.future = future
                    with suppress(OSError):  # it has ended, as its answer will show
                        lane.pipe.send_bytes(piece)
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
        self._lanes.append(_Lane(process, pipe))

    def _hear(self, lane: _Lane) -> None:
        """Take the answer of a process, or replace it."""
        answer = lane.answer()
        if answer is not None and not lane.ready:
            lane.ready, self._failures = True, 0
            return
        future, lane.future = lane.future, None
        if answer is None:
            lane.stop()
            self._lanes.remove(lane)
            if not lane.ready:
                self._not_started()
            elif future is not None:
                future.set_exception(WorkerEnded(f"ended with code {lane.process.exitcode}"))
        elif future is not None:
            done, value = answer
            if done:
                future.set_result(value)
            else:
                future.set_exception(value)

    def _not_started(self) -> None:
        """Give up where no process starts."""
        self._failures += 1
        if self._failures >= STARTS:
            self._fail()

    def _fail(self) -> None:
        """Take no more pieces; those that wait fail."""
        with self._lock:
            self._broken = True
            waiting, self._waiting = self._waiting, deque()
        for future, _ in waiting:
            if future.set_running_or_notify_cancel():
                future.set_exception(BrokenExecutor(NOT_STARTED))


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
            function, args, kwargs = pickle.loads(piece)
            answer: tuple[bool, Any] = (True, function(*args, **kwargs))
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
def processes(workers: int) -> Iterator[Executor]:
    """Processes of this package, killed where the work fails: they need no clean-up.

    Parameters
    ----------
    workers
        Number of processes.
    """
    pool = Lanes(workers)
    try:
        yield pool
        pool.shutdown()
    except BaseException:
        pool.kill()
        raise
