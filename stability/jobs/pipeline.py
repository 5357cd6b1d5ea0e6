"""Ordered, bounded work over any executor of `concurrent.futures`, interrupted and resumed.

An interruption within a condition of `threading` ends in `RuntimeError: release unlocked lock`
(CPython; tests/jobs/test_pipeline.py shows it).  Here signals wait while such a condition is used.

What all pieces need is shared: each worker reads its own copy, since CasADi's objects must not be
used by several threads at once, and a process has none of its parent's objects.
"""

from __future__ import annotations

import hashlib
import os
import pickle
import threading
from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator
from concurrent.futures import (
    BrokenExecutor,
    CancelledError,
    Executor,
    Future,
    ThreadPoolExecutor,
)
from contextlib import AbstractContextManager, contextmanager, nullcontext, suppress
from dataclasses import dataclass, field
from functools import partial
from os import PathLike
from queue import Empty, SimpleQueue
from typing import Any, Generic, TypeVar, cast

from ..base.checks import MOST_WORKERS, callback, instance, whole_number
from ..base.errors import ParameterError, StabilityError, one_line
from ..base.types import Progress
from ..storage.files import postponed
from ..storage.pieces import Pieces
from ..storage.targets import path_text
from .processes import follow_starter

K = TypeVar("K")
T = TypeVar("T")
Pool = Callable[[int], AbstractContextManager[Executor | None]]
"""Starts a number of workers; gives None where this thread does the work."""

LOOK = 0.05
"""Longest time that a signal waits [s]."""
AHEAD = 4
"""Pieces in flight for each worker: running, waiting to run, or waiting for an earlier result."""
ENDED = (
    "a worker was ended from outside, or did not start; if the memory is short, take a smaller "
    "task or fewer workers, and in a script make the call under `if __name__ == '__main__':`."
)
MOST_COPIES = 8
"""Largest number of copies in a thread; the oldest is dropped first."""
SHORT = 120
"""Largest number of characters of an error in a message."""
_THREAD = threading.local()


class Counted:
    """A progress function and its count, which never falls.

    Examples
    --------
    >>> counted = Counted(lambda done, total: print(done, "of", total), 5)
    >>> counted.add(2)
    2 of 5
    """

    def __init__(self, progress: Progress | None, total: int) -> None:
        self.progress, self.total, self.done = progress, total, 0

    def add(self, count: int) -> None:
        """Add pieces to the count, and call the progress function."""
        self.done += count
        if self.progress is not None:
            self.progress(self.done, self.total)


def check_run(workers: Any, progress: Any, executor: Any = None) -> None:
    """Refuse an invalid number of workers, progress function or executor."""
    if workers is not None:
        whole_number("workers", workers, most=MOST_WORKERS)
    callback(progress)
    if executor is not None:
        instance("executor", executor, Executor, "give a concurrent.futures.Executor")


@contextmanager
def resumable(
    folder: str | PathLike[str],
    count: Counted | None = None,
    *,
    said: str = "finished cells are kept in",
    then: str = "go on",
) -> Iterator[None]:
    """Say where the finished work is, and how to continue, when a job is interrupted.

    `said` stands before the folder, and `then` at the end of the sentence.
    """
    try:
        yield
    except KeyboardInterrupt:
        some = "" if count is None else f"{count.done} of {count.total} "
        raise KeyboardInterrupt(
            f"interrupted; {some}{said} {path_text(folder)}: give the same command again to {then}"
        ) from None


def threads(workers: int) -> AbstractContextManager[Executor]:
    """Threads that this package starts."""
    return ThreadPoolExecutor(workers)


def here(workers: int) -> AbstractContextManager[None]:  # noqa: ARG001
    """No workers: this thread does one piece after another."""
    return nullcontext()


def ordered(
    keys: Iterable[K],
    task: Callable[[K], Callable[[], T] | Future[T]],
    *,
    executor: Executor | None = None,
    workers: int = 1,
    start_pool: Pool = threads,
    keep: Pieces[K, T] | None = None,
    progress: Counted | None = None,
    size: Callable[[K], int] = lambda _: 1,
    ahead: int = AHEAD,
    in_order: bool = True,
    lost: Callable[[K, Exception], T] | None = None,
    broken: str = ENDED,
) -> Generator[tuple[K, T], None, None]:
    """Do pieces of work, a limited number at once, and yield their results in order.

    Parameters
    ----------
    keys
        Names of the pieces, in order.
    task
        Makes the work of a piece in this thread when its turn comes: a function without arguments,
        or the future of work that was sent before.  For processes it must be picklable.  Data that
        all pieces need are best `shared`.
    executor
        Any executor of the protocol of `concurrent.futures`; it is not shut down.
    workers
        Number of workers; at most `ahead` pieces for each are in flight.
    start_pool
        Starts the workers where there is no executor.
    keep
        Store of finished pieces: pieces in it are not done again, others are added.
    progress
        Count that grows with each finished piece, in any order.
    size
        Size of a piece in that count.
    ahead
        Pieces in flight for each worker.
    in_order
        Whether results come in the order of the keys; as soon as they are there otherwise.
    lost
        Result for a piece that failed, by its key and error, such as that of a worker that ended
        and is replaced; or raises it.  The error ends the work when left out.
    broken
        Sentence for a worker that ended where that ends the work.

    Yields
    ------
    tuple
        Key and result.  When the iterator is closed, or fails, waiting pieces are cancelled, and
        workers started here end.

    Raises
    ------
    StabilityError
        If a worker was ended from outside, or the executor takes no work.

    Source: tests/jobs/test_pipeline.py.

    Examples
    --------
    >>> with ThreadPoolExecutor(2) as pool:
    ...     list(ordered("ab", lambda key: key.upper, executor=pool, workers=2))
    [('a', 'A'), ('b', 'B')]
    """
    with start_pool(workers) if executor is None else nullcontext(executor) as pool:
        work = _Work(pool, task, keep, progress, size, in_order, lost)
        most = ahead * workers if pool is not None else 1
        try:
            for key in keys:
                work.begin(key)
                if work.flight == most:
                    yield work.take()
            while work.flight:
                yield work.take()
        except BrokenExecutor:
            raise StabilityError(broken) from None
        except CancelledError:
            raise StabilityError(
                "the executor has cancelled the work; give one that runs."
            ) from None
        finally:
            if work.unfinished:
                with postponed():
                    for future in work.unfinished:
                        future.cancel()


@dataclass
class _Work(Generic[K, T]):
    """Pieces in flight, each with a list for its result."""

    pool: Executor | None
    task: Callable[[K], Callable[[], T] | Future[T]]
    keep: Pieces[K, T] | None
    progress: Counted | None
    size: Callable[[K], int]
    in_order: bool
    lost: Callable[[K, Exception], T] | None
    flight: int = 0
    """Pieces that were begun and not taken."""
    queue: deque[tuple[K, list[T]]] = field(default_factory=deque)
    """Pieces to take, in order; without an order those that have a result."""
    unfinished: dict[Future[T], tuple[K, list[T]]] = field(default_factory=dict)
    ended: SimpleQueue[Future[T]] = field(default_factory=SimpleQueue)

    def begin(self, key: K) -> None:
        """Fetch a stored piece, or send its work."""
        piece: tuple[K, list[T]] = (key, [])
        kept = self.keep.get(key) if self.keep is not None and self.keep.done(key) else None
        self.flight += 1
        if self.in_order:
            self.queue.append(piece)
        if kept is not None:
            self._arrived(piece, kept)
            return
        work = self.task(key)
        if self.pool is None and not isinstance(work, Future):
            self._finished(piece, work())
            return
        with postponed():
            future = work if isinstance(work, Future) else _sent(self.pool, work)
            self.unfinished[future] = piece
            future.add_done_callback(self.ended.put)

    def take(self) -> tuple[K, T]:
        """Wait for the next piece, and return its key and result."""
        while not (self.queue and self.queue[0][1]):
            self._wait()
        key, results = self.queue.popleft()
        self.flight -= 1
        return key, results[0]

    def _wait(self) -> None:
        """Take the result of a future; the time of that does not grow with their number."""
        future = None
        while future is None:
            with suppress(Empty):
                future = self.ended.get(timeout=LOOK)
        piece = self.unfinished.pop(future)
        try:
            result = future.result()
        except Exception as error:
            if self.lost is None:
                raise
            result = self.lost(piece[0], error)
        self._finished(piece, result)

    def _finished(self, piece: tuple[K, list[T]], result: T) -> None:
        if self.keep is not None:
            self.keep.add(piece[0], result)
        self._arrived(piece, result)

    def _arrived(self, piece: tuple[K, list[T]], result: T) -> None:
        piece[1].append(result)
        if not self.in_order:
            self.queue.append(piece)
        if self.progress is not None:
            self.progress.add(self.size(piece[0]))


def _sent(pool: Any, work: Callable[[], T]) -> Future[T]:
    try:
        future: Future[T] = pool.submit(_Piece(work, os.getpid()))
        return future
    except BrokenExecutor:
        raise
    except RuntimeError as error:
        why = one_line(str(error), SHORT)
        raise ParameterError(f"executor takes no more work: {why}.") from None


@dataclass(frozen=True)
class _Piece(Generic[T]):
    """One piece of work, for any thread or process."""

    work: Callable[[], T]
    """The work."""
    home: int
    """Number of the process that sent it."""

    def __call__(self) -> T:
        if os.getpid() != self.home:
            follow_starter()
        return self.work()


def shared(value: T, executor: Executor | None) -> Callable[[], T]:
    """A function that gives the value to a worker; pieces of work use it in place of the value.

    Parameters
    ----------
    value
        Data that every piece needs.
    executor
        Executor whose workers use the value: each thread or process then has its own copy.  None
        for threads of this package, which share the value: they avoid CasADi or take turns.

    Returns
    -------
    callable

    Raises
    ------
    ParameterError
        If the value cannot be sent.

    Examples
    --------
    >>> from concurrent.futures import ThreadPoolExecutor
    >>> value = {"k": 0.25}
    >>> with ThreadPoolExecutor(1) as pool:
    ...     copy = pool.submit(shared(value, pool)).result()
    >>> copy == value, copy is value
    (True, False)
    """
    if executor is None:
        return partial(_same, value)
    from casadi import global_pickle_context

    try:
        with global_pickle_context():
            content = pickle.dumps(value)
    except Exception as error:
        raise ParameterError(
            "the work cannot be sent to the workers of the executor: "
            f"{one_line(str(error), SHORT)}; define contact laws in a module, not in a function."
        ) from None
    return _Copied(hashlib.sha256(content).digest(), content)


def _same(value: T) -> T:
    return value


@dataclass(frozen=True)
class _Copied(Generic[T]):
    """A value as bytes, read once in each thread."""

    name: bytes
    """Checksum of the bytes."""
    content: bytes = field(repr=False)
    """The bytes."""

    def __call__(self) -> T:
        """The copy of this thread."""
        held: dict[bytes, Any] = _THREAD.__dict__.setdefault("held", {})
        if self.name not in held:
            while len(held) >= MOST_COPIES:
                del held[next(iter(held))]
            held[self.name] = self._read()
        return cast(T, held[self.name])

    def _read(self) -> Any:
        from casadi import global_unpickle_context

        try:
            with global_unpickle_context():
                return pickle.loads(self.content)
        except Exception as error:
            raise StabilityError(
                f"a worker cannot read its work: {one_line(str(error), SHORT)}; define contact "
                "laws in a module that it can import."
            ) from None
