"""The uncertainty exponent of a flow whose border has a known dimension."""

from typing import Any

import numpy as np
import pytest
from kicked_flow import DIMENSION, WIDE, kicked, side

import stability as st


def labels() -> Any:
    return st.launch_labels(
        kicked(), varied=("x", "y"), held={"clock": 0.0, "size": 4.0}, horizon=26.0, check=False
    )


@pytest.mark.parametrize("count", [60, pytest.param(2000, marks=pytest.mark.long)])
def test_a_kicked_flow_falls_on_the_side_of_the_sum(count: int) -> None:
    points = np.random.default_rng(3).uniform([0, -2], [1, 2], (count, 2))
    away = np.abs(side(points)) > 2e-3  # the last time leaves the others open
    found = labels()(points[away])
    assert set(np.unique(found)) == set(np.unique(labels()(np.array([[0.2, -3.0], [0.2, 3.0]]))))
    below = found == labels()(np.array([[0.2, -3.0]]))[0]
    np.testing.assert_array_equal(below, side(points[away]) < 0)


@pytest.mark.parametrize("integrated", [False, pytest.param(True, marks=pytest.mark.long)])
def test_its_uncertainty_exponent_is_the_codimension_of_the_border(integrated: bool) -> None:
    label = labels() if integrated else lambda points: (side(points) < 0).astype(int)
    steps = 0.03 * float(WIDE) ** -np.linspace(0, 4, 9)  # whole periods of its structure
    found = st.uncertainty_exponent(label, [0, -2], [1, 2], steps, points=2500)
    assert found.interval[0] < 2 - DIMENSION < found.interval[1]
    assert found.interval[1] - found.interval[0] < 0.2
