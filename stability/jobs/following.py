"""Worker processes: they end when the process that started them ends, by SIGKILL too."""

from __future__ import annotations

import ctypes
import os
import signal
import sys
import threading
import time
from contextlib import suppress

LOOK = 0.5
"""Time between two looks at the parent [s]."""
PR_SET_PDEATHSIG = 1
"""Option of Linux's prctl: the signal that a process gets when its parent ends."""


def follow(parent: int) -> None:
    """End this process as soon as its parent has ended; called first in a worker.

    On Linux the kernel sends the signal, in the middle of a long call too; elsewhere, and where
    that fails, a thread looks twice a second.

    Parameters
    ----------
    parent
        Process number of the parent.
    """
    if sys.platform.startswith("linux"):
        with suppress(OSError, AttributeError):
            ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, int(signal.SIGKILL), 0, 0, 0)
    if os.getppid() != parent:  # it ended before
        os._exit(1)
    threading.Thread(target=_watch, args=(parent,), daemon=True).start()


def _watch(parent: int) -> None:
    while os.getppid() == parent:
        time.sleep(LOOK)
    os._exit(1)
