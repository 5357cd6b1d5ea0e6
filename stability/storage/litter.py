"""Temporary files named after their process, and the removal of those whose process has ended."""

from __future__ import annotations

import hashlib
import os
import re
import secrets
import shutil
import socket
import sys
import time
from contextlib import suppress
from functools import cache
from pathlib import Path

PATTERN = re.compile(r"\.stability-([0-9a-f]{8})-(\d+)-(\d+)-[0-9a-f]{8}(\.\w{1,16})?")
"""Name of a temporary file: host, process, start of the process, random digits, suffix."""
FOREIGN = 7 * 86400.0
"""Age after which a temporary file of another host counts as left behind [s]."""
AGAIN = 60.0
"""Time after which a folder is searched again by the same process [s]."""
_searched: dict[str, float] = {}


def temporary(suffix: str = "") -> str:
    """A new name for a temporary file of this process.

    Examples
    --------
    >>> PATTERN.fullmatch(temporary(".nc")) is not None
    True
    """
    kept = suffix if re.fullmatch(r"\.\w{1,16}", suffix, re.ASCII) else ""
    pid = os.getpid()
    return f".stability-{_host()}-{pid}-{_start(pid) or 0}-{secrets.token_hex(4)}{kept}"


def clear(folder: Path, *, always: bool = False) -> None:
    """Remove temporary files of ended processes from a folder; those of live processes stay."""
    here, now = str(folder), time.monotonic()
    if not always and now - _searched.get(here, -AGAIN) < AGAIN:
        return
    _searched[here] = now
    with suppress(OSError), os.scandir(folder) as entries:
        for entry in entries:
            if entry.name.startswith(".stability-") and _left(entry):
                with suppress(OSError):
                    if entry.is_dir(follow_symlinks=False):
                        shutil.rmtree(entry.path, ignore_errors=True)
                    else:
                        os.unlink(entry.path)


def _left(entry: os.DirEntry[str]) -> bool:
    """Whether an entry is a temporary file whose process has ended."""
    match = PATTERN.fullmatch(entry.name)
    if match is None:
        return False
    host, pid, start = match[1], int(match[2]), int(match[3])
    if host == _host() and not (start == 0 and sys.platform == "win32"):
        return not _lives(pid, start)
    with suppress(OSError):
        return time.time() - entry.stat(follow_symlinks=False).st_mtime > FOREIGN
    return False


def _lives(pid: int, start: int) -> bool:
    """Whether the process with this number and start still runs."""
    if start and Path("/proc/self/stat").exists():
        return _start(pid) == start
    try:
        os.kill(pid, 0)
    except (ProcessLookupError, OverflowError):
        return False
    except OSError:  # a process of another user
        return True
    return True


def _start(pid: int) -> int | None:
    """Start of a process in clock ticks since boot; None if ended or unknown."""
    try:
        text = Path(f"/proc/{pid}/stat").read_bytes()
    except OSError:
        return None
    fields = text.rpartition(b")")[2].split()
    if len(fields) < 20 or fields[0] in (b"Z", b"X"):
        return None
    return int(fields[19])


@cache
def _host() -> str:
    """Eight digits for the machine and its space of process numbers."""
    space = ""
    with suppress(OSError):
        space = os.readlink("/proc/self/ns/pid")
    return hashlib.sha256(f"{socket.gethostname()} {space}".encode()).hexdigest()[:8]
