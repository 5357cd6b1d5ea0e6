"""Provenance: versions of libraries, the machine, the date."""

from __future__ import annotations

import contextlib
import os
import platform
from datetime import UTC, datetime
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
    found = {
        "processor": _processor(), "cores": str(os.cpu_count() or 1), "memory": _memory(),
        "system": f"{platform.system()} {platform.machine()}",
        "python": platform.python_version(), "stability": __version__,
    }  # fmt: skip
    for name in LIBRARIES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "missing"
    return found


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
    """The present time in UTC, to the second.

    Returns
    -------
    str
    """
    return datetime.now(UTC).isoformat(timespec="seconds")
