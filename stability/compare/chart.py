"""A chart as data: its cells as labelled arrays, and as CSV."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from ..base.provenance import machine, today
from ..jobs.measured_cells import Cell
from ..storage.text import csv_text

Line = dict[str, Any]
"""Values of a line of CSV by the names of the columns."""


def padded(
    rows: Sequence[Sequence[float | None] | None], shape: tuple[int, ...], longest: int = 0
) -> Any:
    """Rows of different lengths as one array of doubles, with NaN for missing numbers.

    Parameters
    ----------
    rows
        Rows of numbers, or None for a missing row.
    shape
        Leading shape that the rows fill.
    longest
        Least length of the last axis.

    Examples
    --------
    >>> padded([[1.0, 2.0], None, [3.0]], (3,)).tolist()
    [[1.0, 2.0], [nan, nan], [3.0, nan]]
    """
    longest = max((len(r) for r in rows if r), default=longest or 1)
    out = np.full((len(rows), longest), np.nan)
    for index, row in enumerate(rows):
        if row:
            out[index, : len(row)] = [np.nan if v is None else v for v in row]
    return out.reshape(*shape, longest)


def numbers(values: Sequence[float | None], shape: tuple[int, ...]) -> Any:
    """Numbers as one array of doubles, with NaN for missing ones."""
    return np.array([np.nan if v is None else v for v in values], float).reshape(shape)


def words(values: Sequence[str], shape: tuple[int, ...], most: int) -> Any:
    """Texts of at most so many letters as one array."""
    return np.array(values, dtype=f"U{most}").reshape(shape)


def variable(along: Sequence[str], values: Any, text: str, unit: str = "1") -> tuple[Any, ...]:
    """A variable of a dataset with its description and unit."""
    return tuple(along), values, {"units": unit, "long_name": text}


def methods(along: str, records: Mapping[str, Any], names: Sequence[str]) -> dict[str, Any]:
    """Coordinates of the methods of a chart: name, title, and whether each is the package's."""
    coordinates: dict[str, Any] = {along: list(names)}
    for word in ("title", "own", "default"):
        coordinates[word] = (along, [getattr(records[name], word) for name in names])
    return coordinates


def attributes(form: str, title: str, truth: str) -> dict[str, str]:
    """Attributes of a chart that is made here and now."""
    return {
        "format": form,
        "title": title,
        "machine": json.dumps(machine()),
        "created": today(),
        "truth": truth,
    }


def csv_of(
    part: str, cells: Mapping[str, Cell], lines: Callable[[Sequence[str], Cell], list[Line]]
) -> str:
    """The cells of a part as CSV; `lines` takes the names in a cell's key, and the cell."""
    nothing = Cell("", "", None, "", 0.0)
    [header, *_] = lines(["", ""], nothing)
    rows = [
        [*line.values()]
        for key, cell in cells.items()
        if key.startswith(f"{part}/")
        for line in lines(key.split("/")[1:], cell)
    ]
    return csv_text([*header], rows)
