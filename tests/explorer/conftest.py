"""One page of the disk, and one of a coin, for all tests of the explorer."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from chromium import Visit, visit
from node import Engine
from page_numbers import COIN

import stability as st


@pytest.fixture(scope="session")
def page_of_disk(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path: Path = st.explore("spinning", mu=0.3, out=tmp_path_factory.mktemp("page") / "disk.html")
    return path


@pytest.fixture(scope="session")
def disk(page_of_disk: Path) -> Engine:
    """Its scripts, for every test that only asks for numbers."""
    return Engine(page_of_disk)


@pytest.fixture(scope="session")
def opened_disk(browser: Any, page_of_disk: Path) -> Iterator[Visit]:
    """The page itself."""
    with visit(browser, page_of_disk) as found:
        yield found


@pytest.fixture(scope="session")
def page_of_coin(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path: Path = st.explore(
        "rolling",
        disk=COIN,
        at=45.0,
        mu=0.9,
        x=("at", 5.0, 100.0),
        certify=False,
        out=tmp_path_factory.mktemp("page") / "coin.html",
    )
    return path
