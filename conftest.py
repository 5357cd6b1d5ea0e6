"""Tests in any order: what one leaves behind fails it, and `--order-seed N` shuffles them.

`--tenth N` runs the tests whose turn it is, `--no-skips` fails those that would be skipped.
"""

from __future__ import annotations

import gc
import locale
import os
import random
import signal
import sys
import zlib
from collections.abc import Iterator
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # workers share the cores already

import numpy as np
import pytest
from hypothesis import HealthCheck, settings

# a loaded machine is no fault of a test
settings.register_profile(
    "any-machine", deadline=None, suppress_health_check=[HealthCheck.too_slow]
)
settings.load_profile("any-machine")
SLOW_EXAMPLES = (
    "stability/derivation/", "stability/tables/families.py", "stability/figures/retrograde.py",
    "stability/boundary/mean_path.py", "notebooks/proofs/centre_manifold.py",
)  # fmt: skip
"""Their doctests derive or integrate what takes seconds."""
BACKEND = ("backend", "backend_fallback", "interactive")
"""Settings of matplotlib that are settled when pyplot is first asked for."""
SIGNALS = [n for n in ("SIGINT", "SIGALRM", "SIGTERM") if hasattr(signal, n)]


def pytest_configure(config: pytest.Config) -> None:
    """Hear SIGINT, as the commands under test must: what runs in the background may ignore it."""
    config.pluginmanager.register(Tiers())
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Any:
    """With `--dist loadscope`, a folder to each worker in turn: what it builds is built once."""
    if config.getoption("dist") != "loadscope":
        return None
    from xdist.scheduler import LoadScopeScheduling

    class ByFolder(LoadScopeScheduling):
        def _split_scope(self, nodeid: str) -> str:
            return "/".join(nodeid.partition("::")[0].split("/")[:2])

    return ByFolder(config, log)


def pytest_addoption(parser: pytest.Parser) -> None:
    """Name a random order, a tenth of the tests, and whether one may be skipped."""
    parser.addoption("--order-seed", type=int, help="run files, and tests within, in random order")
    parser.addoption("--tenth", type=int, choices=range(10), help="run one test of ten, by name")
    parser.addoption("--no-skips", action="store_true", help="a test that is skipped fails")


def _drawn(items: list[pytest.Item], count: int) -> list[pytest.Item]:
    """So many of the cases of a test, by a seeded draw that meets as many values as it can.

    Of a product of bodies and laws, each body and each law is met before one of them comes twice.
    """
    left = sorted(items, key=lambda item: item.nodeid)
    random.Random(left[0].location[2].partition("[")[0]).shuffle(left)
    chosen: list[pytest.Item] = []
    met: set[tuple[str, int]] = set()
    while left and len(chosen) < count:
        best = max(left, key=lambda item: len(item.callspec.indices.items() - met))
        left.remove(best)
        chosen.append(best)
        met |= best.callspec.indices.items()
    return chosen


class Tiers:
    """Marks what opens a browser, and as long what `few(n)` leaves out, before pytest selects."""

    @pytest.hookimpl(tryfirst=True)
    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        """Of each marked test, draw the cases that stay."""
        cases: dict[tuple[pytest.Item | None, str], list[pytest.Item]] = {}
        for item in items:
            if item.nodeid.startswith(SLOW_EXAMPLES):
                item.add_marker(pytest.mark.long)
            if "browser" in getattr(item, "fixturenames", ()):
                item.add_marker(pytest.mark.browser)
            if item.get_closest_marker("few") and not item.get_closest_marker("long"):
                cases.setdefault((item.parent, item.originalname), []).append(item)
        for group in cases.values():
            count = group[0].get_closest_marker("few").args[0]
            for item in set(group) - set(_drawn(group, count)):
                item.add_marker(pytest.mark.long)


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Keep a tenth; shuffle files, then the tests of each: fixtures of a file are made once."""
    tenth = config.getoption("--tenth")
    if tenth is not None:
        left_out = [item for item in items if zlib.crc32(item.nodeid.encode()) % 10 != tenth]
        config.hook.pytest_deselected(items=left_out)
        items[:] = [item for item in items if item not in left_out]
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


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item: pytest.Item) -> Any:
    """Where every program is installed, as in CI, a skipped test is one that nobody runs."""
    report = yield
    if report.skipped and item.config.getoption("--no-skips"):
        report.outcome, report.longrepr = "failed", f"skipped: {report.longrepr[-1]}"
    return report


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Any:
    """Spare the collector of garbage the half million objects of what is imported."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.enable()
        gc.freeze()


def _state() -> dict[str, Any]:
    """What belongs to the process, not to the library or to a test."""
    _, drawn, place, *_ = np.random.get_state()  # noqa: NPY002
    state: dict[str, Any] = {
        "working directory": os.getcwd(),
        "environment": {k: v for k, v in os.environ.items() if k != "PYTEST_CURRENT_TEST"},
        "floating-point errors": np.geterr(),
        "NumPy's random state": (drawn.tobytes(), place),
        "Python's random state": random.getstate(),
        "locale": locale.setlocale(locale.LC_ALL),
        "signals": [signal.getsignal(getattr(signal, name)) for name in SIGNALS],
        "print options": {k: str(v) for k, v in np.get_printoptions().items()},
        "recursion limit": sys.getrecursionlimit(),
    }
    if "matplotlib" in sys.modules:
        known = dict(dict.items(sys.modules["matplotlib"].rcParams))
        state["rcParams"] = {k: v for k, v in known.items() if k not in BACKEND}
    if "mpmath" in sys.modules:
        state["precision of mpmath"] = sys.modules["mpmath"].mp.prec
    if "flint" in sys.modules:
        state["precision of balls"] = sys.modules["flint"].ctx.prec
    return state


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
    left += [name for name, value in before.items() if value != after.get(name)]
    assert not left, f"left behind: {', '.join(left)}"
