"""Columns of a table: meaning, unit, symbol, and the form of numbers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from ...base.quantities import Kind
from ...base.types import Record


@dataclass(frozen=True, eq=False)
class Column(Record):
    """A column of a table.

    Examples
    --------
    >>> Column("time", "time to the threshold", Kind.TIME).header(dimensionless=False)
    'time [s]'
    """

    name: str
    """Name, the key of a row's value."""
    meaning: str
    """What the column holds."""
    kind: Kind | str | Mapping[str, Kind] = Kind.NUMBER
    """Kind of the numbers, or a unit; where it differs by row, by the word in the column `by`."""
    latex: str = ""
    """Symbol in LaTeX without dollars; empty for a column of words."""
    form: str = "{:.6g}"
    """Format of a number."""
    by: str = ""
    """Column whose word fixes the kind."""
    place: str = "cell"
    """Place in LaTeX: `cell`; `group`, once above the rows that share it; `below` its row."""
    share: float = 0.0
    """Share of the line in LaTeX for a column of texts that break; 0 for a natural width."""

    def unit(self, *, dimensionless: bool) -> str:
        """The unit for a reader; empty for words, pure numbers, and units that differ by row."""
        if isinstance(self.kind, str):
            return "" if self.kind == "1" else self.kind
        if not isinstance(self.kind, Kind) or self.kind is Kind.NUMBER:
            return ""
        return self.kind.label(dimensionless=dimensionless)

    def unit_in(self, row: Mapping[str, Any], *, dimensionless: bool) -> str:
        """The unit of the value in a row; empty where there is none."""
        if not isinstance(self.kind, Mapping):
            return self.unit(dimensionless=dimensionless)
        kind = self.kind.get(str(row[self.by]).removeprefix("~"))
        return "" if kind is None or row[self.name] is None else kind.label(
            dimensionless=dimensionless)  # fmt: skip

    def header(self, *, dimensionless: bool) -> str:
        """Name and unit."""
        unit = self.unit(dimensionless=dimensionless)
        return f"{self.name} [{unit}]" if unit else self.name

    def written(self, value: Any) -> str:
        """A value as text; a dash for None."""
        if value is None:
            return "-"
        if isinstance(value, bool):
            return "yes" if value else "no"
        if isinstance(value, (list, tuple)):
            return "; ".join(self.written(v) for v in value)
        if isinstance(value, Mapping):
            return ", ".join(f"{k} {self.written(v)}" for k, v in value.items())
        return value if isinstance(value, str) else self.form.format(value)


def word(name: str, meaning: str, place: str = "cell", share: float = 0.0) -> Column:
    """A column of words.

    Parameters
    ----------
    name, meaning, place, share
        As in `Column`.

    Returns
    -------
    Column
    """
    return Column(name, meaning, place=place, share=share)
