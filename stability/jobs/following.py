"""Worker processes that end when the process that started them ends, even by SIGKILL."""

from __future__ import annotations

import ctypes
import multiprocessing
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from contextlib import contextmanager, suppress
from functools import cache
from typing import Any, TypeVar

from ..storage.files import ignoring_signals

T = TypeVar("T")
LOOK = 0.5
"""Time between two looks at the parent [s]."""
PR_SET_PDEATHSIG = 1
"""Option of Linux's prctl: the signal that a process gets when its parent ends."""


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


class _Processes(ProcessPoolExecutor):
    """Fresh processes that block signals to stop, which this process handles."""

    def submit(self, fn: Callable[..., T], /, *args: Any, **kwargs: Any) -> Future[T]:
        with ignoring_signals():  # a process starts here
            return super().submit(fn, *args, **kwargs)


@contextmanager
def processes(workers: int) -> Iterator[Executor]:
    """Processes of this package, killed where the work fails: they need no clean-up.

    Parameters
    ----------
    workers
        Number of processes.
    """
    context = multiprocessing.get_context("spawn")
    others = set(multiprocessing.active_children())
    with ignoring_signals():  # its queues start the helper of multiprocessing
        pool = _Processes(workers, context, follow, (os.getpid(),))
    try:
        yield pool
        pool.shutdown()
    except BaseException:
        pool.shutdown(wait=False, cancel_futures=True)
        for child in set(multiprocessing.active_children()) - others:
            child.kill()
            child.join()
        raise
