"""Programs that tests of the outside tier ask for."""

from __future__ import annotations

import shutil

import pytest


def needed(package: str, *names: str) -> str:
    """The first of these programs that is there; without one the test is skipped in a sentence."""
    for name in names:
        if shutil.which(name):
            return name
    pytest.skip(f"no {' or '.join(names)} on this machine (Debian: {package}).")
