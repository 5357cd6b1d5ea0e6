"""A value that its source prints, recomputed with a bound: its row, and the table of such rows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import Any

from .benchmarks.row import (
    AGREES,
    COLUMNS,
    BenchmarkRow,
    Case,
    Source,
    compared,
    of_known_values,
    rows_of,
)
from .table import Column, Definition, as_printed

BOUND = Column(
    "bound", "proved bound on the error of the recomputed value, in 16 digits", form="{:.0e}"
)
PRINTED = tuple(
    column
    for other in COLUMNS
    if other.name not in ("below", "above")
    for column in ((BOUND, other) if other.name == "difference" else (other,))
)
"""Columns of a table of printed values."""

Value = tuple[float, float]
"""A number and a proved bound on its error."""


def printed_row(
    about: Source,
    quantity: str,
    reference: str,
    value: tuple[float, float | None] | None,
    *,
    unit: str = "",
    status: str = "",
    note: str = "",
) -> BenchmarkRow:
    """A row from a printed value and the package's; `note` says why these differ, or none is."""
    number, error = value or (None, None)
    row = compared(about, quantity, reference, number, unit=unit, reason=note)
    bound = None if number is None or error is None else as_printed(error, number, "{:.16g}")
    said = status or row.status
    if value is not None and not status and row.status != AGREES:
        said = f"differs: {row.status}" + (f"; {note}" if note else "")
    return replace(row, bound=bound, status=said)


def of_printed_values(heading: str, cases: tuple[Case, ...], **more: Any) -> Definition:
    """The definition of a table whose rows each case returns."""
    return of_known_values(heading, partial(rows_of, cases), columns=PRINTED, notes=_counts, **more)


def _counts(rows: Sequence[dict[str, Any]]) -> list[str]:
    differ = sum(row["status"].startswith("differs") for row in rows)
    missing = sum(row["recomputed"] is None for row in rows)
    agree = len(rows) - differ - missing
    return [f"{len(rows)} printed values: {agree} agree, {differ} differ, {missing} not covered."]
