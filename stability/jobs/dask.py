"""Workers by one word, or by the address of a scheduler of `distributed`."""

from __future__ import annotations

import logging
import os
import socket
from collections.abc import Iterator
from concurrent.futures import Executor, ThreadPoolExecutor
from contextlib import contextmanager
from typing import Any

from ..base.checks import MOST_WORKERS, whole_number
from ..base.errors import NameUnknownError, StabilityError, one_line, shown
from .following import processes

WORDS = ("threads", "processes", "dask", "local")
"""Engines on this machine; the last two are one: a scheduler and its workers."""
PATIENCE = 10.0
"""Time in which a scheduler must answer [s]."""
SCHEMES = ("tcp", "tls", "ws", "wss")
"""Beginnings of an address that a socket can be tried at first: a client tells late and twice."""
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
    if name == "threads":
        with ThreadPoolExecutor(count) as threads:
            yield threads, count
    elif name == "processes":
        with processes(count) as pool:
            yield pool, count
    elif name in WORDS:
        with _cluster(count) as client:
            yield client.get_executor(pure=False), count
    elif isinstance(name, str) and "://" in name:
        with _client(name) as client:
            yield client.get_executor(pure=False), _workers(client, name)
    else:
        raise NameUnknownError(
            f"the engine is {shown(name)}; give threads, processes, dask, or the address of a "
            "scheduler such as tcp://127.0.0.1:8786."
        )


def workers_of(name: str, workers: int | None = None) -> int:
    """Number of workers of an engine, none of which is started.

    Parameters
    ----------
    name, workers
        As for `engine`; a running scheduler is asked.

    Raises
    ------
    StabilityError
        As for `engine`.

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
            "workers of dask need the package distributed; `pip install stability[scale]`, or "
            "give threads or processes."
        ) from None
    return distributed


@contextmanager
def _cluster(workers: int) -> Iterator[Any]:
    """A client of a new scheduler on this machine, whose workers are processes of one thread.

    A chunk that ends a worker comes back at once: `fill` counts the tries.
    """
    distributed = _library()
    import dask

    with (
        dask.config.set({"distributed.scheduler.allowed-failures": 0}),
        distributed.LocalCluster(
            n_workers=workers, threads_per_worker=1, host="127.0.0.1", dashboard_address=None,
            silence_logs=logging.CRITICAL,
        ) as cluster,
        distributed.Client(cluster) as client,
    ):  # fmt: skip
        yield client


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
