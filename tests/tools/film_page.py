"""The page of a film, as a test reads it."""

import json
import re
from pathlib import Path
from typing import Any

import pytest


def motion_of(path: Path) -> dict[str, Any]:
    """The data in a page."""
    found = re.search(r'type="application/json" id="motion">(.*?)</script>', path.read_text())
    assert found
    return dict(json.loads(found[1], parse_constant=lambda name: pytest.fail(name)))
