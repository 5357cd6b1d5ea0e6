"""Tests in any order: what one leaves behind fails it, and `--order-seed N` shuffles them."""

from __future__ import annotations

import locale
import os
import random
import signal
import sys
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, settings

# a loaded machine is no fault of a test
settings.register_profile(
    "any-machine", deadline=None, suppress_health_check=[HealthCheck.too_slow]
)
settings.load_profile("any-machine")
BACKEND = ("backend", "backend_fallback", "interactive")


def pytest_configure() -> None:
    """Hear SIGINT, as the commands under test must: what runs in the background may ignore it."""
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_addoption(parser: pytest.Parser) -> None:
    """Name a random order: that of the files, and that of the tests within each."""
    parser.addoption("--order-seed", type=int, help="run files, and tests within, in random order")


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Shuffle files, then the tests of each, so that fixtures of a file are made once."""
    seed = config.getoption("--order-seed")
    if seed is None:
        return
    files: dict[str, list[pytest.Item]] = {}
    for item in items:
        files.setdefault(str(item.path), []).append(item)
    draw = random.Random(seed)
    groups = list(files.values())
    draw.shuffle(groups)
    for group in groups:
        draw.shuffle(group)
    items[:] = [item for group in groups for item in group]


def _state() -> dict[str, Any]:
    """What belongs to the process, not to the library or to a test."""
    state: dict[str, Any] = {
        "working directory": os.getcwd(),
        "environment": {k: v for k, v in os.environ.items() if k != "PYTEST_CURRENT_TEST"},
        "floating-point errors": np.geterr(),
        "NumPy's random state": np.random.get_state()[1:3],  # noqa: NPY002
        "Python's random state": random.getstate(),
        "locale": locale.setlocale(locale.LC_ALL),
        "interrupt": signal.getsignal(signal.SIGINT),
        "alarm": signal.getsignal(signal.SIGALRM),
        "termination": signal.getsignal(signal.SIGTERM),
        "print options": {k: str(v) for k, v in np.get_printoptions().items()},
        "recursion limit": sys.getrecursionlimit(),
    }
    if "matplotlib" in sys.modules:
        known = dict.items(sys.modules["matplotlib"].rcParams)
        # those of the backend are settled when pyplot is first asked for
        state |= {f"rcParams {k}": str(v) for k, v in known if k not in BACKEND}
    if "flint" in sys.modules:
        state["precision of balls"] = sys.modules["flint"].ctx.prec
    return state


def _same(before: Any, after: Any) -> bool:
    if isinstance(before, tuple):
        return all(_same(a, b) for a, b in zip(before, after, strict=True))
    return bool(np.all(before == after))


@pytest.fixture(autouse=True)
def nothing_left() -> Iterator[None]:
    """Fail a test that leaves a figure open or a setting of the process changed."""
    before = _state()
    yield
    left = []
    if "matplotlib.pyplot" in sys.modules:
        plt = sys.modules["matplotlib.pyplot"]
        if plt.get_fignums():
            left.append(f"{len(plt.get_fignums())} figures open")
            plt.close("all")
    after = _state()
    left += [name for name, value in before.items() if not _same(value, after.get(name))]
    assert not left, f"left behind: {', '.join(left)}"
