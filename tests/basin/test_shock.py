"""Smallest shocks against distances that geometry gives; the same search for every budget."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from stability.base.errors import ParameterError
from stability.basin.statistics.shock import fatal_shock

Label = Callable[[np.ndarray], np.ndarray]


def disc(points: np.ndarray) -> np.ndarray:
    return (np.hypot(points[:, 0], points[:, 1]) < 1).astype(int)


def strip(points: np.ndarray) -> np.ndarray:
    """Three regions: the nearer line to the origin is at 0.4, the other at 0.5."""
    a = points @ [0.6, 0.8]
    return np.where(a > 0.5, 2, np.where(a < -0.4, 1, 0))


def plane(normal: np.ndarray, distance: float) -> Label:
    return lambda p: (p @ normal > distance).astype(int)


NORMAL = np.array([0.1, -0.7, 0.3, 0.2, 0.4, 0.5]) / np.sqrt(1.04)


@pytest.mark.parametrize("seed", range(5))
def test_the_distance_to_a_circle(seed: int) -> None:
    for start in ([0.3, 0.2], [1.5, -0.4]):
        truth = abs(np.hypot(*start) - 1)
        found = fatal_shock(disc, start, reach=2, seed=seed)
        assert truth <= found.size < truth * 1.001
        assert 0 < found.size - found.inner < 2e-3 * truth


@pytest.mark.parametrize("seed", range(5))
def test_the_nearer_of_two_lines(seed: int) -> None:
    found = fatal_shock(strip, [0.0, 0.0], seed=seed)
    assert 0.4 <= found.size < 0.4004
    assert (found.label, found.start_label) == (1, 0)


@pytest.mark.parametrize("seed", range(5))
def test_the_distance_to_a_plane_in_six_dimensions(seed: int) -> None:
    found = fatal_shock(plane(NORMAL, 0.8), np.zeros(6), reach=3, seed=seed)
    assert 0.8 <= found.size < 0.801


def test_scales_measure_each_coordinate() -> None:
    scale = np.array([1.0, 10.0, 0.1, 2.0, 1.0, 5.0])
    start = np.arange(6.0)
    found = fatal_shock(
        lambda p: plane(NORMAL, 0.8)((p - start) / scale), start, scale=scale, reach=3
    )
    assert 0.8 <= found.size < 0.801
    assert np.linalg.norm((found.launch - start) / scale) == pytest.approx(found.size, rel=1e-12)


@pytest.mark.parametrize("label", [strip, disc, plane(NORMAL[:2], 0.3)])
def test_the_launch_has_the_label_and_the_size_that_are_said(label: Label) -> None:
    found = fatal_shock(label, [0.1, -0.1], reach=2, budget=700)
    assert label(found.launch[None])[0] == found.label != found.start_label
    assert np.linalg.norm(found.launch - found.start) == pytest.approx(found.size, rel=1e-12)
    towards = (found.launch - found.start) / found.size
    inner = found.start + found.inner * towards
    assert label(inner[None])[0] == found.start_label


@pytest.mark.parametrize("seed", range(3))
def test_a_larger_budget_continues_the_same_search(seed: int) -> None:
    asked: dict[int, np.ndarray] = {}
    sizes = []
    for budget in (1, 2, 33, 34, 100, 400, 3000):
        seen: list[np.ndarray] = []

        def label(points: np.ndarray, seen: list[np.ndarray] = seen) -> np.ndarray:
            seen.append(points)
            return strip(points)

        found = fatal_shock(label, [0.0, 0.0], budget=budget, seed=seed, reach=2)
        sizes.append(found.size)
        asked[budget] = np.concatenate(seen)
        assert found.searched == len(asked[budget]) <= budget
        if found.found:  # only draws after the bound was found count
            when = np.flatnonzero((asked[budget] == found.launch).all(axis=1))[0]
            assert found.clear <= budget - 1 - when
    assert all(b <= a for a, b in zip(sizes, sizes[1:], strict=False))
    for few in asked.values():
        assert (asked[3000][: len(few)] == few).all()


def test_ranges_are_respected() -> None:
    seen: list[np.ndarray] = []

    def label(points: np.ndarray) -> np.ndarray:
        seen.append(points)
        return strip(points)

    found = fatal_shock(label, [0.0, 0.0], low=[-0.1, -0.2], high=[1.0, 1.0], reach=2)
    points = np.concatenate(seen)
    assert (points >= [-0.1, -0.2]).all()
    assert (points <= 1).all()
    assert found.label == 2  # the nearer line is out of range
    assert 0.5 <= found.size < 0.5005


def test_where_nothing_is_found_it_says_so() -> None:
    found = fatal_shock(lambda p: np.zeros(len(p), int), np.zeros(3), budget=500)
    assert not found.found
    assert found.size == np.inf
    assert (found.launch == 0).all()
    assert found.clear == 499
    assert found.excluded == pytest.approx(1 - 0.05 ** (1 / 499))
    assert "No disturbance up to 1" in found.note


@pytest.mark.parametrize(("count", "most"), [(20, 3), pytest.param(60, 8, marks=pytest.mark.long)])
def test_what_is_not_excluded_holds_as_often_as_it_says(count: int, most: int) -> None:
    """A second, small region inside the ball: its share is below the bound, or it is found."""
    misses = 0
    for seed in range(count):

        def label(points: np.ndarray) -> np.ndarray:
            small = np.hypot(points[:, 0] - 0.5, points[:, 1]) < 0.15
            return np.where(small, 2, (points[:, 0] < -0.9).astype(int))

        found = fatal_shock(label, [0.0, 0.0], budget=400, seed=seed)
        if found.label != 2:
            misses += 0.15**2 / found.size**2 > found.excluded
    assert misses <= most  # one of 20 is expected at a risk of 5 %


def test_a_range_far_smaller_than_the_reach_ends() -> None:
    found = fatal_shock(
        lambda p: np.zeros(len(p), int), np.zeros(6), low=-1e-3, high=1e-3, budget=50
    )
    assert not found.found


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"budget": 0}, "budget"),
        ({"reach": -1}, "reach"),
        ({"scale": [1, 2, 3]}, "2 coordinates"),
        ({"scale": 0}, "scale"),
        ({"low": 0.5}, "outside its range"),
        ({"seed": -1}, "seed"),
    ],
)
def test_refusals_say_what_is_wrong(options: dict[str, object], words: str) -> None:
    with pytest.raises(ParameterError, match=words):
        fatal_shock(disc, [0.0, 0.0], **options)
