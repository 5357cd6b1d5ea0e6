"""Workers by one word, or by the address of a scheduler of `distributed`."""

from __future__ import annotations

import logging
import os
import socket
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import (
    BrokenExecutor,
    CancelledError,
    Executor,
    Future,
    InvalidStateError,
    ThreadPoolExecutor,
)
from contextlib import AbstractContextManager, contextmanager, nullcontext, suppress
from functools import partial
from typing import Any, TypeVar
from weakref import WeakSet

from ..base.checks import MOST_WORKERS, whole_number
from ..base.errors import NameUnknownError, ParameterError, StabilityError, one_line, shown
from ..base.main_module import check_main
from ..base.types import Progress
from ..base.version import install_line
from .pipeline import check_run
from .processes import Lanes, processes

T = TypeVar("T")
PROCESSES = ("processes", "dask", "local")
"""Engines that start processes on this machine."""
WORDS = ("threads", *PROCESSES)
"""Engines on this machine; the last two are one: a scheduler and its workers."""
PATIENCE = 10.0
"""Time in which a scheduler must answer [s]."""
SCHEMES = ("tcp", "tls", "ws", "wss")
"""Beginnings of an address that a socket can be tried at first: a client tells late and twice."""
ABANDONED = 60.0
"""Time without any worker after which a scheduler counts as abandoned [s]."""
LOOK = 0.5
"""Time between two looks at the workers [s]."""
SHORT = 80


@contextmanager
def engine(name: str, workers: int | None = None) -> Iterator[tuple[Executor, int]]:
    """An executor and the number of its workers.

    Parameters
    ----------
    name
        threads, processes, dask (or local: a scheduler and its workers on this machine), or the
        address of a running scheduler such as tcp://127.0.0.1:8786.
    workers
        Number of workers; that of the processors when left out.  A running scheduler has its own.

    Yields
    ------
    tuple
        Executor and number of workers; both end with the block, a running scheduler does not.

    Raises
    ------
    StabilityError
        If the word is unknown, `distributed` is missing, or the scheduler does not answer or has
        no workers.

    Source: documentation of dask.distributed; tests/jobs/test_dask.py.

    Examples
    --------
    >>> with engine("threads", 2) as (executor, workers):
    ...     executor.submit(abs, -3).result(), workers
    (3, 2)
    """
    count = _count(workers)
    _check_word(name)
    if name == "threads":
        with ThreadPoolExecutor(count) as threads:
            yield threads, count
    elif name == "processes":
        with processes(count) as pool:
            yield pool, count
    elif name in WORDS:
        with _cluster(count) as pool_and_count:
            yield pool_and_count
    else:
        with _client(name) as client, _Scheduled(client) as executor:
            yield executor, _workers(client, name)


def _check_word(name: str) -> None:
    if name in PROCESSES:
        check_main(f'executor="{name}"')
    elif name not in WORDS and not (isinstance(name, str) and "://" in name):
        raise NameUnknownError(
            f"the engine is {shown(name)}; give threads, processes, dask, or the address of a "
            "scheduler such as tcp://127.0.0.1:8786."
        )


Pooled = tuple[Executor | None, int | None]
"""An executor, None for threads of the job itself, and the number of its workers."""


def pool_of(
    executor: Executor | str | None, workers: int | None = None
) -> AbstractContextManager[Pooled]:
    """The executor that an argument `executor` means, and the number of its workers.

    Parameters
    ----------
    executor
        A word or an address as for `engine`, any `concurrent.futures.Executor`, or None.
    workers
        Number of workers, or None.

    Returns
    -------
    context manager
        Gives executor and number.  For `threads` and None the executor is None: the job starts
        threads itself, which share their data.  An executor that was given is not shut down.

    Raises
    ------
    StabilityError
        As for `check_pool` and `engine`.

    Source: tests/jobs/test_dask.py.

    Examples
    --------
    >>> with pool_of("threads", 2) as (executor, number):
    ...     executor, number
    (None, 2)
    """
    check_pool(executor, workers)
    if isinstance(executor, str) and executor != "threads":
        return engine(executor, workers)
    return nullcontext((None if isinstance(executor, str) else executor, workers))


def check_pool(executor: Any, workers: Any = None, progress: Progress | None = None) -> None:
    """Refuse at once what `pool_of` does not take; no scheduler is asked.

    Parameters
    ----------
    executor, workers
        As for `pool_of`.
    progress
        A function of two numbers, or None.

    Raises
    ------
    ParameterError
        With the value.

    Examples
    --------
    >>> check_pool(5)
    Traceback (most recent call last):
    ...
    stability.base.errors.ParameterError: executor is 5; give threads, processes, dask, the \
address of a scheduler such as tcp://127.0.0.1:8786, or a concurrent.futures.Executor.
    """
    check_run(workers, progress)
    if isinstance(executor, str):
        _check_word(executor)
    elif executor is not None and not isinstance(executor, Executor):
        raise ParameterError(
            f"executor is {shown(executor)}; give threads, processes, dask, the address of a "
            "scheduler such as tcp://127.0.0.1:8786, or a concurrent.futures.Executor."
        )


def workers_of(name: str, workers: int | None = None) -> int:
    """Number of workers of an engine, none of which is started.

    Examples
    --------
    >>> workers_of("dask", 3)
    3
    """
    if name in WORDS:
        return _count(workers)
    with engine(name, workers) as (_, count):
        return count


def _count(workers: int | None) -> int:
    """A number of workers; that of the processors when left out."""
    if workers is None:
        return os.cpu_count() or 1
    return whole_number("workers", workers, most=MOST_WORKERS)


def _library() -> Any:
    try:
        import distributed
    except ImportError:
        raise StabilityError(
            f"workers of dask need the package distributed; {install_line('scale')}, or give "
            "threads or processes."
        ) from None
    return distributed


class _Scheduled(Executor):
    """Work for a client's scheduler; it fails where there are no workers any more.

    The executor of `distributed` never answers for a piece whose result was lost with its worker.
    """

    def __init__(self, client: Any, revive: Callable[[], object] = lambda: None) -> None:
        self._client, self._revive = client, revive
        self._futures: WeakSet[Future[Any]] = WeakSet()
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._watch, daemon=True)
        self._thread.start()

    def submit(self, fn: Callable[..., T], /, *args: Any, **kwargs: Any) -> Future[T]:
        """Send a piece, as for any executor."""
        sent = self._client.submit(fn, *args, **kwargs, pure=False)
        future: Future[T] = Future()
        self._futures.add(future)
        future.add_done_callback(lambda ended: sent.cancel() if ended.cancelled() else None)
        sent.add_done_callback(partial(_passed_on, future))
        return future

    def shutdown(self, wait: bool = True, **_: Any) -> None:
        """End the watch."""
        self._ended.set()
        if wait:
            self._thread.join()

    def _watch(self) -> None:
        seen = time.monotonic()
        while not self._ended.is_set():
            self._revive()
            self._ended.wait(LOOK)
            if self._client.scheduler_info().get("workers"):
                seen = time.monotonic()
            elif time.monotonic() - seen > ABANDONED:
                self._abandon()

    def _abandon(self) -> None:
        for future in list(self._futures):
            with suppress(InvalidStateError):
                future.set_exception(StabilityError(
                    f"the scheduler has had no workers for {ABANDONED:.0f} s; finished chunks are "
                    "kept: start workers, and give the same command again to go on."
                ))  # fmt: skip


def _passed_on(future: Future[Any], sent: Any) -> None:
    """Give a future what a client's future holds; a result that was lost is computed again."""
    try:
        result = sent.result()
    except BaseException as error:
        with suppress(InvalidStateError):
            future.set_exception(CancelledError() if sent.cancelled() else error)
        return
    with suppress(InvalidStateError):  # cancelled meanwhile
        future.set_result(result)


class _Workers:
    """Workers on this machine, each a process of one thread; one that ends is replaced.

    The nannies of `distributed` do not replace a worker that ends while it starts.
    """

    def __init__(self, address: str, count: int) -> None:
        self._address, self._pool = address, Lanes(count)
        self._lives = [self._pool.submit(_serve, address) for _ in range(count)]

    def revive(self) -> None:
        """Start what has ended."""
        for i, life in enumerate(self._lives):
            if life.done():
                with suppress(BrokenExecutor):
                    self._lives[i] = self._pool.submit(_serve, self._address)

    def stop(self) -> None:
        """End them at once: they need no clean-up."""
        self._pool.kill()


def _serve(address: str) -> None:
    """The life of a worker."""
    import asyncio

    distributed = _library()
    logging.getLogger("distributed").setLevel(logging.CRITICAL)

    async def serve() -> None:
        async with distributed.Worker(
            address, nthreads=1, memory_limit=0, dashboard_address="127.0.0.1:0"
        ) as worker:
            await worker.finished()

    asyncio.run(serve())


@contextmanager
def _cluster(workers: int) -> Iterator[tuple[Any, int]]:
    """A client's executor for a new scheduler and its workers on this machine.

    A chunk that ends a worker comes back at once: `fill` counts the tries.
    """
    distributed = _library()
    import dask

    with (
        dask.config.set({"distributed.scheduler.allowed-failures": 0}),
        distributed.LocalCluster(
            n_workers=0, host="127.0.0.1", dashboard_address="127.0.0.1:0",
            silence_logs=logging.CRITICAL,
        ) as cluster,
        distributed.Client(cluster, set_as_default=False) as client,
    ):  # fmt: skip
        processes = _Workers(cluster.scheduler_address, workers)
        try:
            with _Scheduled(client, processes.revive) as executor:
                client.wait_for_workers(workers, timeout=ABANDONED)
                yield executor, workers
        except distributed.TimeoutError:
            raise StabilityError(
                f"the workers have not started within {ABANDONED:.0f} s; in a script, make the "
                "call under `if __name__ == '__main__':`."
            ) from None
        finally:
            processes.stop()


@contextmanager
def _client(address: str) -> Iterator[Any]:
    distributed = _library()
    try:
        scheme, _, place = address.partition("://")
        host, _, port = place.rpartition(":")
        if scheme not in SCHEMES or not port.isdigit():
            raise ValueError(f"an address is {', '.join(SCHEMES)}, then ://host:port")
        socket.create_connection((host.strip("[]"), int(port)), PATIENCE).close()
        client = distributed.Client(address, timeout=PATIENCE, set_as_default=False)
    except (OSError, ValueError, OverflowError, RuntimeError, ImportError) as error:
        why = one_line(str(error), SHORT).rstrip(".")
        raise StabilityError(
            f"the scheduler {one_line(address, SHORT)} does not answer ({why}); start it by `dask "
            "scheduler`, or give threads, processes or dask."
        ) from None
    with client:
        yield client


def _workers(client: Any, address: str) -> int:
    """Number of threads of all workers."""
    count = sum(client.ncores().values())
    if not count:
        raise StabilityError(
            f"the scheduler {one_line(address, SHORT)} has no workers; start some by `dask worker "
            f"{one_line(address, SHORT)}`."
        )
    return int(count)
