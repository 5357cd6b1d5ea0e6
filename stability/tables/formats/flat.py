"""Tables as plain cells, for CSV and pandas: one header with units, no nested values."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from .column import Column


def flat(
    columns: Sequence[Column], rows: Sequence[Mapping[str, Any]], *, dimensionless: bool
) -> tuple[list[str], list[list[Any]]]:
    """Header and cells without nested values.

    Parameters
    ----------
    columns, rows
        Of a table.
    dimensionless
        Whether mass, radius and gravity are 1.

    Returns
    -------
    (list of str, list of list)
        A column of mappings becomes one for each key; a unit that differs by row has a column.
    """
    header: list[str] = []
    cells: list[list[Any]] = [[] for _ in rows]
    for column in columns:
        values = [row[column.name] for row in rows]
        keys = list(dict.fromkeys(k for v in values if isinstance(v, Mapping) for k in v))
        names = [f"{column.name}.{key}" for key in keys]
        header += names or [column.header(dimensionless=dimensionless)]
        for cell, value in zip(cells, values, strict=True):
            cell += [_plain(value.get(k)) for k in keys] if keys else [_plain(value)]
        if not callable(column.kind):
            continue
        header.append(f"{column.name}_unit")
        for cell, row in zip(cells, rows, strict=True):
            cell.append(column.unit_in(row, dimensionless=dimensionless) or None)
    return header, cells


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return ", ".join(f"{k}: {_plain(v)}" for k, v in value.items())
    if isinstance(value, (list, tuple)):
        return "; ".join(str(_plain(v)) for v in value) or None
    return value
