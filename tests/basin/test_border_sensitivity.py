"""A map with refined borders says how sensitive they are, in its attributes and block by block."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray
from kicked_flow import DIMENSION, kicked, side

import stability as st
from stability.base.axis import Axis
from stability.basin.borders import borders
from stability.basin.launch_labels import FAMILIES
from stability.basin.refinement import border_arrays
from stability.motion.result import Outcome

ALPHA = 2 - DIMENSION
ROUGH: dict[str, Any] = {
    "x": ("x", 0.03, 0.97, 12),
    "y": ("y", -2, 2, 13),
    "held": {"clock": 0.0, "size": 4.0},
    "horizon": 26.0,
    "check": False,
    "levels": 4,
}


def refined(label: Any, x: Any, y: Any, levels: int) -> tuple[Any, xarray.Dataset]:
    found = borders(label, x, y, levels=levels)
    return found, border_arrays(found, (Axis.of(x, "x"), Axis.of(y, "y")))


def inside(points: np.ndarray) -> np.ndarray:
    return np.asarray(np.hypot(points[:, 0], points[:, 1]) < 0.8)


@pytest.mark.long
def test_a_rough_border_is_marked_and_a_circle_is_not() -> None:
    rough, told = refined(lambda p: side(p) < 0, ("x", 0.03, 0.97, 12), ("y", -2, 2, 13), 6)
    low, high = told.attrs["border_exponent_interval"]
    assert low < ALPHA < high and high - low < 0.3
    assert told.attrs["border_exponent"] == pytest.approx(ALPHA, abs=0.1)
    assert told.border_sensitive.values.mean() > 0.8
    _, smooth = refined(inside, ("x", -1, 1, 9), ("y", -1, 1, 9), 7)
    low, high = smooth.attrs["border_exponent_interval"]
    assert low < 1 < high
    assert smooth.border_sensitive.size > 10 and not smooth.border_sensitive.values.any()
    assert told.attrs["border_sensitive_note"].startswith("Sensitive: ")


SETTLED = FAMILIES * Outcome.SETTLED.code
STRIP = 0.005


def around(side: np.ndarray) -> np.ndarray:
    """Two ends, and between them a strip of launches that still move at the horizon."""
    return np.where(np.abs(side) < STRIP, 0, SETTLED + 1 + (side > 0))


def test_a_strip_of_unfinished_launches_is_open_where_the_border_is_smooth() -> None:
    axes = ("x", 0, 1, 9), ("y", 0, 1, 9)
    _, told = refined(lambda p: around(p[:, 1] - 0.31 * p[:, 0] - 0.2), *axes, 6)
    marked = told.border_sensitive.values
    assert (marked == 2).sum() > 4 and not (marked == 1).any()
    assert (told.border_block_exponent.values[marked == 2] < 0.9).all()
    assert "Open: the same, but through a strip" in told.attrs["border_sensitive_note"]
    assert "100 % of the finest pairs hold a launch whose end" in told.attrs["border_exponent_note"]
    _, known = refined(lambda p: SETTLED + 1 + (p[:, 1] > 0.31 * p[:, 0] + 0.2), *axes, 6)
    assert not known.border_sensitive.values.any()
    assert "end is not known" not in known.attrs["border_exponent_note"]


@pytest.mark.long
def test_a_strip_along_a_rough_border_leaves_it_sensitive() -> None:
    _, told = refined(lambda p: around(side(p)), ("x", 0.03, 0.97, 12), ("y", -2, 2, 13), 6)
    assert (told.border_sensitive.values == 1).mean() > 0.8


@pytest.mark.parametrize("scale", [(), ("log",)])
def test_the_blocks_cover_the_border_and_nothing_else(scale: tuple[str, ...]) -> None:
    def left(points: np.ndarray) -> np.ndarray:
        return np.asarray(points[:, 0] < 0.3 + 0.5 * points[:, 1])

    _, told = refined(left, ("x", 0.1, 1.0, 7, *scale), ("y", 0.1, 1.0, 5), 5)
    ends = [told[f"border_block_{n}"].values for n in "xy"]
    assert all((e[:, 0] < e[:, 1]).all() for e in ends)
    points = np.stack([told.border_x.values, told.border_y.values], axis=1)
    held = [((e[:, :1] <= p) & (p <= e[:, 1:])) for e, p in zip(ends, points.T, strict=True)]
    each = held[0] & held[1]
    assert each.any(axis=0).all()  # each point of the line is in a block
    assert each.any(axis=1).all()  # and each block holds one


def test_few_halvings_say_why_nothing_is_marked() -> None:
    _, told = refined(inside, ("x", -1, 1, 9), ("y", -1, 1, 9), 2)
    assert "border_sensitive" not in told and "border_exponent" not in told.attrs
    assert told.attrs["border_exponent_note"].startswith("none: fewer than 4 of 3 levels")
    assert told.attrs["border_sensitive_note"] == (
        "not sought: sensitive parts need 4 halvings, and 2 are complete"
    )
    _, nowhere = refined(lambda p: np.zeros(len(p), int), ("x", 0, 1, 3), ("y", 0, 1, 3), 5)
    assert nowhere.sizes["border_block"] == 0


@pytest.mark.long
def test_a_map_of_a_flow_with_a_known_border_says_its_exponent(tmp_path: Path) -> None:
    found = st.basins(kicked(), **ROUGH, store=tmp_path / "a.zarr")
    low, high = found.attrs["border_exponent_interval"]
    assert low < ALPHA < high < 1  # wide, since there are few halvings, but not smooth
    opened = xarray.open_zarr(tmp_path / "a.zarr")
    for name in ("border_block_x", "border_block_y", "border_block_exponent", "border_sensitive"):
        np.testing.assert_array_equal(opened[name].values, found[name].values)
    assert opened.attrs["border_exponent_interval"] == found.attrs["border_exponent_interval"]
    assert 0 < found.border_sensitive.values.mean() < 1
