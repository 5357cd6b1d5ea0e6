"""Sizes of units by kind, against the dimensions that the SI unit of each kind states."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import stability as st
from stability.base.quantities import Kind, Units
from tests.tools.similarity import size

MASS, LENGTH, GRAVITY = 0.7, 0.03, 1.62


@pytest.mark.parametrize("kind", Kind)
def test_a_dimensionless_one_has_the_size_that_its_unit_states(kind: Kind) -> None:
    found = Units(MASS, LENGTH, GRAVITY).size(kind)
    assert found == pytest.approx(size(kind.si, MASS, LENGTH, GRAVITY), rel=1e-14)


def test_sizes_of_many_bodies_are_those_of_each() -> None:
    lengths = np.array([0.01, 0.5, 2.0])
    found = Units(MASS, lengths, GRAVITY, np.sqrt).size(Kind.POWER)
    assert found.tolist() == [Units(MASS, one, GRAVITY).size(Kind.POWER) for one in lengths]


@pytest.mark.parametrize("kind", [SimpleNamespace(si="m"), None, "TIME"])
def test_an_unknown_kind_is_refused(kind: Any) -> None:
    with pytest.raises(st.StabilityError, match="of which no size in the units of a body is known"):
        Units().size(kind)


@pytest.mark.parametrize("name", ["time", "rate", "speed", "force", "energy"])
def test_the_disk_has_the_same_units(name: str) -> None:
    units = {"time": "s", "rate": "1/s", "speed": "m/s", "force": "N", "energy": "J"}
    disk = st.Disk(mass=MASS, radius=LENGTH, gravity=GRAVITY)
    expected = size(units[name], MASS, LENGTH, GRAVITY)
    assert getattr(disk, name) == pytest.approx(expected, rel=1e-14)
