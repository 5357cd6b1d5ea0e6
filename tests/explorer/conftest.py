"""One page of the disk for all tests of the explorer."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from chromium import Visit, visit

import stability as st


@pytest.fixture(scope="session")
def page_of_disk(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path: Path = st.explore("spinning", mu=0.3, out=tmp_path_factory.mktemp("page") / "disk.html")
    return path


@pytest.fixture(scope="session")
def disk(browser: Any, page_of_disk: Path) -> Iterator[Visit]:
    """One page for every test that only asks it for numbers."""
    with visit(browser, page_of_disk) as found:
        yield found
