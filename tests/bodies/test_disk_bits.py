"""The disk has the numbers of version 0.4.0, when it had equations of its own."""

import json
from typing import Any

import disk_bits
import numpy as np
import pytest

from stability.bodies.disk_polynomials import DIGEST

KEPT: dict[str, Any] = json.loads(disk_bits.PLACE.read_text())


def test_the_exact_data_are_the_same() -> None:
    assert disk_bits.data() == KEPT["data"] == DIGEST


def test_numbers_are_the_same_but_for_rounding() -> None:
    found, kept = disk_bits.numbers(), KEPT["numbers"]
    assert found.keys() == kept.keys()
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
