"""Columns of a table: meaning, unit, symbol, and the form of numbers."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

from ...base.quantities import Kind, Quantity
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
    kind: Kind | str | Callable[[str], Quantity | None] = Kind.NUMBER
    """Kind of the numbers, or a unit; where it differs by row, the quantity that a word names."""
    latex: str = ""
    """Symbol in LaTeX without dollars; empty for a column of words."""
    form: str = "{:.6g}"
    """Format of a number."""
    by: str = ""
    """Column of the words that name the quantity."""
    place: str = "cell"
    """Place in LaTeX: `cell`; `group`, once above the rows that share it; `below` its row."""
    share: float = 0.0
    """Share of the line in LaTeX for a column of texts that break; 0 for a natural width."""
    of: tuple[str, str] | None = None
    """Of a bound: the column of its number, and the format of that; it then holds as printed."""
    title: str = ""
    """Name for a reader, in CSV and pandas, where it is not `name`."""

    def unit(self, *, dimensionless: bool) -> str:
        """The unit for a reader; empty for words, pure numbers, and units that differ by row."""
        if isinstance(self.kind, str):
            return "" if self.kind == "1" else self.kind
        if not isinstance(self.kind, Kind) or self.kind is Kind.NUMBER:
            return ""
        return self.kind.label(dimensionless=dimensionless)

    def unit_in(self, row: Mapping[str, Any], *, dimensionless: bool) -> str:
        """The unit of the value in a row; empty where there is none."""
        if isinstance(self.kind, (Kind, str)):
            return self.unit(dimensionless=dimensionless)
        found = self.quantities([row])
        return "".join(q.kind.label(dimensionless=dimensionless) for q in found.values())

    def quantities(self, rows: Iterable[Mapping[str, Any]]) -> dict[str, Quantity]:
        """Where the quantity differs by row: the one that each word names, if it has a value."""
        if isinstance(self.kind, (Kind, str)):
            return {}
        words = [str(r[self.by]).removeprefix("~") for r in rows if r[self.name] is not None]
        named = {w: self.kind(w) for w in dict.fromkeys(words)}
        return {w: q for w, q in named.items() if q is not None}

    def header(self, *, dimensionless: bool) -> str:
        """Name and unit."""
        unit = self.unit(dimensionless=dimensionless)
        name = self.title or self.name
        return f"{name} [{unit}]" if unit else name

    def written(self, value: Any) -> str:
        """A value as text; a dash for None."""
        if value is None:
            return "-"
        if isinstance(value, bool):
            return "yes" if value else "no"
        if isinstance(value, (list, tuple)):
            return "; ".join(self.written(v) for v in value) or "none"
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


class Content(Protocol):
    """What a form reads of a `Table`."""

    @property
    def name(self) -> str:
        """Name of the table."""

    @property
    def heading(self) -> str:
        """What the table shows."""

    @property
    def columns(self) -> tuple[Column, ...]:
        """Columns, in order."""

    @property
    def rows(self) -> Sequence[Mapping[str, Any]]:
        """Rows, each a record."""

    @property
    def dimensionless(self) -> bool:
        """Whether mass, radius and gravity are 1."""

    @property
    def notes(self) -> Sequence[str]:
        """Lines below the rows."""
