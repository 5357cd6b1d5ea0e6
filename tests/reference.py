"""Reference values: from the project's shared folder where it lies beside, else from tests/data."""

import json
from pathlib import Path
from typing import Any

DATA = Path(__file__).parent / "data"
SHARED = Path(__file__).resolve().parents[2] / "shared" / "reference"


def spectra() -> list[dict[str, Any]]:
    """The sixteen spectra to 25 digits."""
    beside = SHARED / "spectra.json"
    kept: list[dict[str, Any]] = json.loads((DATA / "spectra.json").read_text())["spectra"]
    if beside.is_file():
        fresh: list[dict[str, Any]] = json.loads(beside.read_text())
        assert fresh == kept, "tests/data/spectra.json has aged: copy it anew"
    return kept


def beyond() -> dict[str, Any]:
    """The independent derivation of slow drift and of flutter on lines of steady motions."""
    found: dict[str, Any] = json.loads((DATA / "beyond.json").read_text())
    return found
