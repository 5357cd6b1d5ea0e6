"""Datasets from arrays that fit are those of xarray's public constructor."""

from typing import Any

import numpy as np
import pytest
import xarray

from stability.storage.datasets import Labelled, labelled

VARIABLES: dict[str, Labelled] = {
    "rate": (("y", "at"), np.arange(6.0).reshape(2, 3), {"units": "1/s"}),
    "word": ("at", np.array(["a", "bc", ""]), {}),
    "why": ((), "a sentence", {"long_name": "why"}),
}
COORDINATES: dict[str, Labelled] = {
    "at": ("at", np.array([0.5, 1.0, 2.0]), {"units": "rad"}),
    "y": ("y", ["low", "high"], {}),
    "omega3": ("at", np.array([1.0, 2.0, 4.0]), {"units": "rad/s"}),
    "mu": ((), 0.3, {}),
}
ATTRIBUTES = {"title": "a map"}


def test_the_dataset_is_the_one_that_the_constructor_makes() -> None:
    dataset = labelled(VARIABLES, COORDINATES, ATTRIBUTES)
    plain = xarray.Dataset(VARIABLES, COORDINATES, ATTRIBUTES)
    assert dataset.identical(plain)
    assert list(dataset.variables) == list(plain.variables)
    assert dict(dataset.sizes) == dict(plain.sizes)
    assert list(dataset.indexes) == list(plain.indexes)
    for name, index in dataset.indexes.items():
        assert index.equals(plain.indexes[name]) and index.name == plain.indexes[name].name
    for name, variable in dataset.variables.items():
        assert variable.dtype == plain[name].dtype
        assert type(variable) is type(plain.variables[name])
    assert dataset.sel(at=1.0, y="high").identical(plain.sel(at=1.0, y="high"))
    dataset.at.attrs["units"] = "deg"
    assert COORDINATES["at"][2] == {"units": "rad"}


def test_without_the_direct_constructor_the_public_one_is_taken(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    real = xarray.Dataset._construct_direct
    calls = []

    def once(*arguments: Any, **options: Any) -> Any:
        if not calls:
            calls.append(1)
            raise AttributeError("_construct_direct")
        return real(*arguments, **options)

    monkeypatch.setattr(xarray.Dataset, "_construct_direct", once)
    dataset = labelled(VARIABLES, COORDINATES, ATTRIBUTES)
    assert calls
    assert dataset.identical(xarray.Dataset(VARIABLES, COORDINATES, ATTRIBUTES))
