"""Refined borders as arrays of a dataset."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ...base.axis import Axis
from ...base.types import Floats
from ..borders import Borders
from ..launch_labels import FAMILIES
from .sensitivity import blocks, exponent

if TYPE_CHECKING:
    import xarray


def border_arrays(found: Borders, axes: tuple[Axis, Axis]) -> xarray.Dataset:
    """The borders between the outcomes of a map.

    Parameters
    ----------
    found
        Borders of its labels.
    axes
        x and y.

    Returns
    -------
    xarray.Dataset
        Along `border_point`: `border_X` for each axis X, the points of each line in turn
        (`border_curve`), and the flag values of the outcomes and families on both sides; along
        `border_block`, which parts are sensitive.  Attributes hold the uncertainty exponent.
    """
    import xarray

    parts, meaning = blocks(found, axes)
    return xarray.Dataset(
        _variables(found, axes) | parts,
        attrs={
            "border_width": [float(w) for w in found.widths[-1]],
            "border_levels": found.lattice_levels,
            "border_launches": found.asked,
            "border_note": found.note,
            "border_cells": [int(n) for n in found.counts],
            **exponent(found),
            **meaning,
        },
    )


def _variables(found: Borders, axes: tuple[Axis, Axis]) -> dict[str, Any]:
    lines = [_closed(line) for line in found.lines]
    points, lengths = np.concatenate([np.zeros((0, 2)), *lines]), [len(p) for p in lines]
    pairs = np.array([line.labels for line in found.lines], dtype=np.int64).reshape(-1, 2)
    sides = np.repeat(pairs, lengths, axis=0)
    made: dict[str, Any] = {
        f"border_{a.name}": (
            "border_point",
            points[:, i],
            {"long_name": f"{a.name} of the border, off the true one by less than border_width"},
        )
        for i, a in enumerate(axes)
    }
    made["border_curve"] = (
        "border_point",
        np.repeat(np.arange(len(lines)), lengths),
        {"long_name": "number of the line"},
    )
    for side, column in (("low", 0), ("high", 1)):
        for name, part in (
            ("outcome", sides[:, column] // FAMILIES),
            ("family", sides[:, column] % FAMILIES),
        ):
            made[f"border_{name}_{side}"] = (
                "border_point",
                part.astype(np.int8),
                {"long_name": f"{name} on the {side} side, a flag value of {name}"},
            )
    return made


def _closed(line: Any) -> Floats:
    points: Floats = np.vstack([line.points, line.points[:1]]) if line.closed else line.points
    return points
