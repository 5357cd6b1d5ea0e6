"""The disk is bit for bit what it was in version 0.4.0, before there were other bodies."""

import json
from typing import Any

import disk_bits
import numpy as np
import pytest

from stability.bodies.thin_disk.disk_polynomials import DIGEST

KEPT: dict[str, Any] = json.loads(disk_bits.PLACE.read_text())


def test_every_law_has_the_same_graph() -> None:
    found = disk_bits.graphs()
    assert found == KEPT["graphs"]
    assert set(found) == set(disk_bits.LAWS)
    assert all("jacobian" in parts and "condition 0" in parts for parts in found.values())


def test_the_exact_data_are_the_same() -> None:
    assert disk_bits.data() == KEPT["data"] == DIGEST


def test_numbers_are_the_same_to_the_last_bit() -> None:
    """Where LAPACK, sine and cosine round otherwise, to 1e-12, and verdicts as they were."""
    found, kept = disk_bits.numbers(), KEPT["numbers"]
    assert found.keys() == kept.keys()
    if disk_bits.machine() == KEPT["machine"]:
        assert found == kept
    assert found["map"] == kept["map"]
    for name in found.keys() - {"map"}:
        ours, theirs = _values(found[name]), _values(kept[name])
        assert [v for v in ours if isinstance(v, str)] == [v for v in theirs if isinstance(v, str)]
        pair = [np.array([v for v in one if not isinstance(v, str)]) for one in (ours, theirs)]
        assert pair[0] == pytest.approx(pair[1], rel=1e-12, abs=1e-12), name


def _values(kept: list[Any]) -> list[Any]:
    """Numbers, and words as they are."""
    flat = [v for one in kept for v in (one if isinstance(one, list) else [one])]
    return [float.fromhex(v) if isinstance(v, str) and "0x" in v else v for v in flat]
