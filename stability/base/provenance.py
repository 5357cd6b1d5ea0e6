"""Provenance: versions of libraries, the machine, the date."""

from __future__ import annotations

import contextlib
import os
import platform
from datetime import UTC, datetime
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from .version import __version__

LIBRARIES = ("casadi", "numpy", "scipy", "sympy", "python-flint", "mpmath", "heyoka")
"""Libraries whose versions a comparison depends on."""


def machine() -> dict[str, str]:
    """The machine and the versions of libraries, as texts.

    Returns
    -------
    dict
        processor, cores, memory, system, python and the version of each library.

    Examples
    --------
    >>> machine()["stability"] == __version__
    True
    """
    record = {
        "processor": _processor(),
        "cores": str(os.cpu_count() or 1),
        "memory": _memory(),
        "system": f"{platform.system()} {platform.machine()}",
        "python": platform.python_version(),
        "stability": __version__,
    }
    for name in LIBRARIES:
        try:
            record[name] = version(name)
        except PackageNotFoundError:
            record[name] = "missing"
    return record


@cache
def versions(names: tuple[str, ...]) -> str:
    """Versions of libraries and of Python in one line, without those that are missing.

    They are read from files once: a small result takes no longer itself.

    Examples
    --------
    >>> versions(("no-such-library",)) == f"python {platform.python_version()}"
    True
    """
    words = []
    for name in names:
        with contextlib.suppress(PackageNotFoundError):
            words.append(f"{name} {version(name)}")
    return ", ".join([*words, f"python {platform.python_version()}"])


def _processor() -> str:
    with contextlib.suppress(OSError):
        for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.split(":", 1)[1].strip()
    return platform.processor() or platform.machine()


def _memory() -> str:
    try:
        size = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    except (AttributeError, ValueError, OSError):
        return "unknown"
    return f"{size / 2**30:.0f} GiB"


def today() -> str:
    """The present time in UTC, to the second."""
    return datetime.now(UTC).isoformat(timespec="seconds")
