"""Workers by one word or by the address of a scheduler."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import Executor
from contextlib import contextmanager


@contextmanager
def engine(name: str, workers: int | None = None) -> Iterator[tuple[Executor, int]]:
    """An executor and the number of its workers.

    Parameters
    ----------
    name
        threads, processes, dask (or local: a scheduler and workers on this machine), or the
        address of a running scheduler such as tcp://host:8786.
    workers
        Number of workers; that of the processors when left out.  A running scheduler has its own.
    """
    raise NotImplementedError
