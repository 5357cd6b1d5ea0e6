"""Files without a checksum: another process, limited in time and memory, reads them first.

HDF5 follows the links of a damaged file for ever, and allocates what the file declares.
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
"""Processor time for reading [s], in addition to a time in proportion to the size."""
RATE = 2e7
"""Lowest speed of reading [bytes of variables per second]."""
WALL = 600.0
"""Time after which the process is ended in any case, even on a busy machine [s]."""
MEMORY = 2**30
"""Memory for reading [bytes], in addition to three times the size of the variables."""
LONGEST = 300
"""Largest number of characters of the process's sentence in a message."""


def inspect(source: Path, form: str, what: str, *, lazy: bool) -> None:
    """Let another process read a file, and refuse the file if the process fails.

    Parameters
    ----------
    source
        The file.
    form, what
        Format and content, as for `stability.storage.reading.opened`.
    lazy
        Whether to read only what opening needs.

    Raises
    ------
    FileError
        If the process refuses the file, or exceeds its time or memory.
    """
    if not sys.executable:  # Python is embedded: no other process can be started
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
            words,
            env=os.environ | calm,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            timeout=WALL,
            check=False,
        )
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
    """Read a file within bounds; for a refused file the process ends with code 2 and a sentence.

    Parameters
    ----------
    path
        The file.
    form, what
        Format and content, as for `inspect`.
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
    os._exit(2 if answer else 0)  # no clean-up, since HDF5 may be in disorder


def bound(seconds: int, memory: int) -> None:
    """Limit this process from now on, where the system can.

    Parameters
    ----------
    seconds
        Further processor time [s].
    memory
        Further memory [bytes].
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
