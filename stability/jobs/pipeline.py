"""Work handed to an executor, with results in order and an interruption at any moment.

An interruption within a condition of `threading` ends in `RuntimeError: release unlocked lock`
(CPython; tests/test_pipeline.py shows it).  Here signals wait while such a condition is used.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Executor, Future, wait
from typing import Any, TypeVar

from ..base.checks import MOST_WORKERS, callback, whole_number
from ..storage.files import postponed


def check_run(workers: Any, progress: Any) -> None:
    """Refuse a number of workers or a progress function that cannot be.

    Parameters
    ----------
    workers
        A whole number of at least 1, or None.
    progress
        A function of two numbers, or None.

    Raises
    ------
    ParameterError
        With the value.
    """
    if workers is not None:
        whole_number("workers", workers, most=MOST_WORKERS)
    callback(progress)


K = TypeVar("K")
T = TypeVar("T")

LOOK = 0.05
"""Longest time that a signal waits [s]."""


def in_order(
    pool: Executor, tasks: Iterable[tuple[K, Callable[[], T]]], ahead: int
) -> Generator[tuple[K, T], None, None]:
    """Run tasks in an executor and yield their results in the order of the tasks.

    Parameters
    ----------
    pool
        Any executor of the protocol of `concurrent.futures`.
    tasks
        Pairs of a key and a function without arguments; taken one at a time, in this thread.
    ahead
        Tasks that wait or run at once.

    Yields
    ------
    tuple
        Key and result.  Tasks that did not begin are cancelled when the iterator is closed.

    Source: tests/test_pipeline.py.

    Examples
    --------
    >>> from concurrent.futures import ThreadPoolExecutor
    >>> with ThreadPoolExecutor(2) as pool:
    ...     list(in_order(pool, [("a", lambda: 1), ("b", lambda: 2)], ahead=2))
    [('a', 1), ('b', 2)]
    """
    pending: deque[tuple[K, Future[T]]] = deque()
    try:
        for key, work in tasks:
            with postponed():
                pending.append((key, pool.submit(work)))
            if len(pending) > ahead:
                yield _settled(*pending.popleft())
        while pending:
            yield _settled(*pending.popleft())
    finally:
        for _, future in pending:
            future.cancel()


def _settled(key: K, future: Future[T]) -> tuple[K, T]:
    return key, next(completed([future]))


def completed(futures: Iterable[Future[T]]) -> Iterator[T]:
    """Yield results of futures as soon as there are any.

    Parameters
    ----------
    futures
        From an executor of `concurrent.futures`.

    Yields
    ------
    object
        Results, in the order in which the work ends.

    Examples
    --------
    >>> from concurrent.futures import ThreadPoolExecutor
    >>> with ThreadPoolExecutor(1) as pool:
    ...     list(completed([pool.submit(abs, -1)]))
    [1]
    """
    left = set(futures)
    while left:
        with postponed():
            done, left = wait(left, LOOK, FIRST_COMPLETED)
        for future in done:
            yield future.result()
