"""A table with its columns and rows, in every form."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from importlib import import_module
from pathlib import Path
from typing import Any

from ...base.quantities import readable
from ...base.types import Record
from ...storage.files import atomic_write
from ...storage.targets import check_suffix, check_target
from ...storage.text import csv_text, json_text
from .about import About
from .column import Column
from .flat import flat
from .latex import latex
from .plain import plain

FORMS = {".csv": "csv", ".json": "json", ".tex": "latex", ".txt": "text"}
"""Form of a table by the ending of its file."""


@dataclass(frozen=True)
class Definition:
    """How a table is computed, and what is printed of it; one for each name of the registry."""

    heading: str
    """Heading, without `(recomputed)`."""
    columns: tuple[Column, ...]
    """Columns, in order."""
    rows: Callable[..., list[dict[str, Any]]]
    """Rows as plain records, from the options in `takes`."""
    takes: tuple[str, ...] = ()
    """Options of `stability.table` that `rows` takes; with `progress`, calls of it."""
    notes: Callable[[Table], Sequence[str]] = field(default=lambda table: ())  # noqa: ARG005
    """Lines below the rows; an indented line is a line of its own in LaTeX too."""
    text: Callable[[Table], str] = plain
    """The table as text."""
    latex: Callable[[Table], str] = latex
    """The table as LaTeX."""
    more: Callable[..., dict[str, Any]] | None = None
    """Further keys of the JSON object, from the same options."""
    about: About | None = field(default=None, kw_only=True)
    """Source and standing, of a table that the list of tables names."""
    cites: str = field(default="stability", kw_only=True)
    """Keys of the works to cite, beyond those of the results that the rows are from."""
    home: str = field(kw_only=True)
    """Where it is, as `module:name`: it is pickled by this."""

    def __reduce__(self) -> tuple[Callable[[str], Definition], tuple[str]]:
        return _at_home, (self.home,)


def _at_home(home: str) -> Definition:
    module, _, name = home.partition(":")
    found: Definition = getattr(import_module(module), name)
    return found


@dataclass(frozen=True, eq=False)
class Table(Record):
    """A table: columns with meaning and unit, rows as records, in every form.

    It prints as text, and is a table in a notebook.

    Source: this package; each form is read back: tests/tables/test_forms.py.

    Examples
    --------
    >>> from stability import table
    >>> drift = table("drift", k=0.25, mu=1)
    >>> round(drift.rows[0]["threshold"], 12)
    1.414213562373
    >>> drift.units["time_slow"]
    '√(R/g)'
    >>> drift.to_csv().splitlines()[0]
    'k,mu [1/√(gR)],omega3 [√(g/R)],threshold [√(g/R)],tilt [rad],time_slow [√(R/g)],time_launch [√(R/g)],tilt_end [rad]'
    """  # noqa: E501

    name: str
    """Name of the table."""
    heading: str
    """What the table shows."""
    columns: tuple[Column, ...]
    """Columns, in order."""
    rows: list[dict[str, Any]]
    """Rows, each a record by the names of the columns."""
    dimensionless: bool = True
    """Whether mass, radius and gravity are 1; otherwise numbers are in SI units."""
    more: Mapping[str, Any] = field(default_factory=dict)
    """Further keys of the JSON object."""
    definition: Definition = field(kw_only=True, repr=False, compare=False)
    """How it is printed."""
    found: Any = field(default=None, kw_only=True, repr=False, compare=False)
    """Result that the rows are from, for a family of the user's own."""
    citation: str = field(kw_only=True, repr=False, compare=False)
    """Keys of the works to cite, for `stability.citation`."""

    @property
    def units(self) -> dict[str, str]:
        """Unit of each column of numbers, by name; a unit that differs by row is left out."""
        units = {c.name: c.unit(dimensionless=self.dimensionless) for c in self.columns}
        return {name: unit for name, unit in units.items() if unit}

    @property
    def notes(self) -> list[str]:
        """Lines below the rows."""
        return list(self.definition.notes(self))

    def __len__(self) -> int:
        return len(self.rows)

    def __iter__(self) -> Iterator[dict[str, Any]]:
        return iter(self.rows)

    def __str__(self) -> str:
        return self.to_text()

    def to_text(self) -> str:
        """The table as lines of text."""
        return self.definition.text(self)

    def to_latex(self) -> str:
        """The table as LaTeX, for a document with amsmath, array, booktabs and longtable."""
        return self.definition.latex(self)

    def to_json(self) -> str:
        """The table as one JSON object: name, heading, citation, columns with units, rows."""
        columns: list[dict[str, Any]] = []
        for c in self.columns:
            units: dict[str, Any] = {"unit": c.unit(dimensionless=self.dimensionless)}
            if c.by:
                units = {
                    "unit_by": c.by,
                    "units": {
                        word: q.kind.label(dimensionless=self.dimensionless)
                        for word, q in c.quantities(self.rows).items()
                    },
                }
            columns.append({"name": c.name, "meaning": c.meaning, **units})
        body = {
            "table": self.name,
            "heading": self.heading,
            "citation": self.citation,
            "columns": columns,
            "rows": self.rows,
        }
        return json_text(body | dict(self.more))

    def to_csv(self) -> str:
        """The table as CSV: one header line with units, numbers with all their digits."""
        return csv_text(*flat(self.columns, self.rows, dimensionless=self.dimensionless))

    def to_pandas(self) -> Any:
        """The table as a pandas DataFrame, with the header of the CSV."""
        import pandas as pd

        header, cells = flat(self.columns, self.rows, dimensionless=self.dimensionless)
        return pd.DataFrame(cells, columns=header)

    def _repr_html_(self) -> str:
        frame = self.to_pandas()
        words = (re.fullmatch(r"(.*) \[(.*)\]", name) for name in frame.columns)
        frame.columns = [
            f"{m[1]} [{readable(m[2])}]" if m else name
            for m, name in zip(words, frame.columns, strict=True)
        ]
        return str(frame.to_html(index=False, na_rep=""))

    def printed(self, form: str) -> str:
        """The table in a form of `FORMS`: text, csv, json or latex."""
        forms = {"csv": self.to_csv, "json": self.to_json, "latex": self.to_latex}
        return forms.get(form, self.to_text)()

    def write(self, path: str | os.PathLike[str], *, overwrite: bool = False) -> Path:
        """Write the table to a file, in the form that its ending names.

        Parameters
        ----------
        path
            A file that ends in .csv, .json, .tex or .txt.
        overwrite
            Whether an existing file may be replaced.

        Returns
        -------
        Path

        Raises
        ------
        FileError
            If the name has another ending, exists, or cannot be written.
        """
        target = check_target(check_suffix(path, tuple(FORMS)), overwrite=overwrite)
        text = self.printed(FORMS[target.suffix.lower()])
        with atomic_write(target, overwrite=overwrite) as draft:
            draft.write_text(text.rstrip("\n") + "\n", "utf-8")
        return target
