"""Files without a checksum: read first by another process, with bounds on its time and memory.

HDF5 follows the links of a damaged file for ever, and allocates what it declares.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from contextlib import suppress
from pathlib import Path

from ..base.errors import FileError
from .targets import path_text

SECONDS = 5
"""Processor time that reading may take, in addition to that in proportion to the size."""
RATE = 2e7
"""Bytes of variables that are read in a second at least."""
WALL = 600.0
"""Seconds after which the process is given up in any case, on a machine however busy."""
MEMORY = 2**30
"""Bytes that reading may take, in addition to those of the variables."""
LONGEST = 300
"""Characters of a sentence that are told."""


def inspect(source: Path, form: str, what: str, *, lazy: bool) -> None:
    """Let a process of its own read a file, and refuse the file if the process fails.

    Parameters
    ----------
    source
        The file.
    form, what
        What it must be, as for `stability.storage.reading.opened`.
    lazy
        Whether only what opening needs is to be read.

    Raises
    ------
    FileError
        If the process says why not, or exceeds its time or memory.
    """
    if not sys.executable:  # embedded: there is no other process to be had
        return
    home = str(Path(__file__).resolve().parents[2])
    code = (
        f"import sys; sys.path.insert(0, {home!r}); "
        "from stability.storage.inspection import main; main(*sys.argv[1:])"
    )
    how = "lazy" if lazy else "all"
    words = [sys.executable, "-c", code, os.fspath(source.absolute()), form, what, how]
    calm = {n: "1" for n in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")}
    try:
        done = subprocess.run(
            words, env=os.environ | calm, stdin=subprocess.DEVNULL, capture_output=True,
            timeout=WALL, check=False,
        )  # fmt: skip
    except subprocess.TimeoutExpired:
        raise FileError(_endless(source)) from None
    except OSError as error:
        raise FileError(
            f"{path_text(source)} has no checksum, and no process can be started to inspect it: "
            f"{error.strerror}."
        ) from None
    if done.returncode == 0:
        return
    if done.returncode == 2:
        raise FileError(done.stdout.decode("utf-8", "replace")[:LONGEST])
    if done.returncode == -getattr(signal, "SIGXCPU", 0):
        raise FileError(_endless(source))
    raise FileError(
        f"{path_text(source)} is damaged: the process that read it ended with code "
        f"{done.returncode}."
    )


def _endless(source: Path) -> str:
    return f"{path_text(source)} is damaged: reading it comes to no end."


def main(path: str, form: str, what: str, how: str) -> None:
    """Read a file within bounds; the process ends with code 2 and a sentence if it is refused.

    Parameters
    ----------
    path
        The file.
    form, what
        What it must be.
    how
        `lazy` or `all`.
    """
    import h5netcdf  # noqa: F401  # before time and memory are counted
    import xarray  # noqa: F401

    from .netcdf import check_sizes, loaded

    source, lazy = Path(path), how == "lazy"
    try:
        bound(SECONDS, MEMORY)
        total = 0 if lazy else check_sizes(source, lazy=False)
        bound(SECONDS + int(total / RATE), MEMORY + 3 * total)
        loaded(source, form, what, lazy=lazy).close()
        answer = ""
    except FileError as error:
        answer = str(error)
    except MemoryError:
        answer = f"{path_text(source)} is damaged: reading it takes more memory than it declares."
    except Exception as error:
        answer = f"{path_text(source)} cannot be read as NetCDF ({type(error).__name__})."
    os.write(1, answer.encode("utf-8", "replace"))
    os._exit(2 if answer else 0)  # no clean-up of what HDF5 may have left in disorder


def bound(seconds: int, memory: int) -> None:
    """Limit this process from now on, where the system can.

    Parameters
    ----------
    seconds
        Processor time [s].
    memory
        Bytes beyond those it has.
    """
    try:
        import resource
    except ImportError:  # Windows
        return
    with suppress(OSError, ValueError, AttributeError):
        used = resource.getrusage(resource.RUSAGE_SELF)
        limit = int(used.ru_utime + used.ru_stime) + 1 + seconds
        _, hard = resource.getrlimit(resource.RLIMIT_CPU)
        resource.setrlimit(resource.RLIMIT_CPU, (limit, hard))
    with suppress(OSError, ValueError, AttributeError, IndexError):
        pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0])
        has = pages * resource.getpagesize()
        _, hard = resource.getrlimit(resource.RLIMIT_AS)
        resource.setrlimit(resource.RLIMIT_AS, (has + memory, hard))
