"""A table with its columns and rows, in every form."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from decimal import ROUND_CEILING, Decimal, localcontext
from fractions import Fraction
from importlib import import_module
from pathlib import Path
from typing import Any

from ..base.printing import html_table
from ..base.quantities import Kind, Quantity, readable
from ..base.types import Overwrite, Record, Sentences
from ..derivation.latex import escaped, width
from ..storage.files import write_file
from ..storage.targets import check_suffix, check_target
from ..storage.text import csv_text, json_text
from .letters import number, prose, unit


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
        quantities = self.quantities([row])
        return "".join(q.kind.label(dimensionless=dimensionless) for q in quantities.values())

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
    """A column of words."""
    return Column(name, meaning, place=place, share=share)


class Standing(Sentences):
    """Whether a table is reproduced; the value of each member is the sentence a user reads.

    Examples
    --------
    >>> print(Standing.REPRODUCED)
    reproduced
    >>> Standing("recomputed") is Standing.RECOMPUTED
    True
    """

    REPRODUCED = "reproduced: every value was at hand as printed, and is recomputed"
    PARTLY = (
        "reproduced in part: values that were at hand as printed are marked `published`; all "
        "others are recomputed by a second route"
    )
    RECOMPUTED = "recomputed: no printed value was at hand"
    DERIVED = "derived: the statements are this package's own, and each is proved or computed here"


@dataclass(frozen=True, eq=False)
class About(Record):
    """Where a table comes from, and what its numbers are compared with.

    Examples
    --------
    >>> About("this package", "no value", "all", Standing.DERIVED).difference
    'no value to compare with'
    >>> About("a paper", "one value", "all", Standing.PARTLY, largest=3e-12).difference
    'at most 3e-12 of the known value, its rounding included'
    """

    source: str
    """Paper, course, code or derivation."""
    published: str
    """What of it was at hand as printed."""
    recomputed: str
    """What the package computes, and by which route."""
    standing: Standing
    """Whether it is reproduced."""
    largest: float | None = None
    """Bound on the difference, relative to the known values; None without such values."""

    @property
    def difference(self) -> str:
        """How far recomputed values are from known ones."""
        if self.largest is None:
            return "no value to compare with"
        return f"at most {self.largest:.0e} of the known value, its rounding included"


# --- as lines of text ---


def plain(table: Table) -> str:
    """Heading, rows in columns of equal width, notes."""
    cells = [[c.name for c in table.columns]]
    cells += [[c.written(row[c.name]) for c in table.columns] for row in table.rows]
    return framed(table, _aligned(cells))


def framed(table: Table, lines: Sequence[str]) -> str:
    """Lines of a table between its heading and its notes."""
    notes = table.notes
    return "\n".join([table.heading, "", *lines, *([""] if notes else []), *notes])


def _aligned(cells: Sequence[Sequence[str]]) -> list[str]:
    """Lines of columns with equal width, the first line underlined.

    Examples
    --------
    >>> _aligned([["k", "mu"], ["0.25", "1"]])
    ['k     mu', '----  --', '0.25  1']
    """
    widths = [max(len(row[i]) for row in cells) for i in range(len(cells[0]))]
    lines = [
        "  ".join(c.ljust(w) for c, w in zip(row, widths, strict=True)).rstrip() for row in cells
    ]
    return [lines[0], "  ".join("-" * w for w in widths), *lines[1:]]


def units_note(table: Table) -> str:
    """Units of a table's columns in one line."""
    by_unit: dict[str, list[str]] = {}
    for column in table.columns:
        for word, quantity in column.quantities(table.rows).items():
            unit = quantity.kind.label(dimensionless=table.dimensionless)
            by_unit.setdefault(unit, []).append(f"{column.name} ({word})")
        unit = column.unit(dimensionless=table.dimensionless)
        if unit:
            by_unit.setdefault(unit, []).append(column.name)
    return "; ".join(f"{', '.join(names)} in {unit}" for unit, names in by_unit.items())


# --- as plain cells, for CSV and pandas ---


def flat(
    columns: Sequence[Column], rows: Sequence[Mapping[str, Any]], *, dimensionless: bool
) -> tuple[list[str], list[list[Any]]]:
    """Header and cells without nested values.

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


# --- as LaTeX ---


NEEDS = "% needs amsmath, array, booktabs and longtable, in a page of one column; run LaTeX twice"
"""Comment at the start of a table."""
SHORT = 60
"""Most characters of a heading of rows in one line."""


def latex(table: Table) -> str:
    """A table as LaTeX, then its symbols and notes: a float as wide as it needs, or a longtable."""
    blocks = _blocks(table)
    cells = [c for c in table.columns if c.place == "cell"]
    notes = [line for line in table.notes if line != units_note(table)]  # the header has the units
    heading = table.heading[:1].upper() + table.heading[1:]
    caption = rf"\caption{{{prose(heading)}.}}\label{{tab:{table.name}}}"
    titles = [" & ".join(_head(c) for c in cells) + r" \\"]
    units = [_unit(c, table) for c in cells]
    titles += [" & ".join(units) + r" \\"] if any(units) else []
    titles = [r"\toprule", *titles, r"\midrule"]
    specs = rf"{{@{{\extracolsep{{\fill}}}}{''.join(_spec(c, table) for c in cells)}@{{}}}}"
    rows = [line for block in blocks for line in block]
    said = [*symbols(table), *_paragraphs(notes)]
    if len(blocks) > FEW:
        body = [rf"\begin{{longtable}}{specs}", rf"{caption}\\", *titles, r"\endfirsthead", *titles]
        body += [r"\endhead", r"\bottomrule", r"\endfoot", *rows, r"\end{longtable}"]
        return "\n".join([start(table.name), *body, *said, END])
    wide = sum(_width(c, table) for c in cells) > COLUMN or sum(c.share for c in cells) > 0.5
    kind = "table*" if wide else "table"
    return "\n".join(
        [
            f"% stability table {table.name}: recomputed",
            f"% needs amsmath, array and booktabs; as wide as {'the page' if wide else 'a column'}",
            rf"\begin{{{kind}}}{SMALL}",
            caption,
            rf"\begin{{tabular*}}{{\linewidth}}{specs}",
            *titles,
            *(row.replace(r"\\*", r"\\") for row in rows),
            r"\bottomrule",
            r"\end{tabular*}\par\smallskip",
            *said,
            rf"\end{{{kind}}}",
        ]
    )


END = r"\par\endgroup"
"""Last line of a table."""
SMALL = r"\footnotesize\setlength{\tabcolsep}{2pt}\setlength{\parindent}{0pt}\raggedright"
FEW = 30
"""Most rows of a table that floats."""
COLUMN = 30.0
"""Width of a column of 85 mm in footnotesize [em]."""


def _width(column: Column, table: Table) -> float:
    """The width of a column of a table, roughly [em]."""
    if column.share:
        return column.share * COLUMN
    texts = [_head(column), _unit(column, table), *(cell(column, row) for row in table.rows)]
    return 0.5 + max(width(text.replace("$", "")) for text in texts)


def start(name: str) -> str:
    """First lines of a long table: where it is from, and its size of letters."""
    return "\n".join(
        [
            f"% stability table {name}: recomputed",
            NEEDS,
            rf"\begingroup{SMALL}",
            r"\setlength{\LTleft}{0pt}\setlength{\LTright}{0pt}",
        ]
    )


def across(columns: int, text: str, indent: str = "") -> str:
    """A line across all columns."""
    box = rf"\parbox[t]{{\linewidth}}{{\raggedright {indent}{text}\strut}}"  # stretches no column
    return rf"\multicolumn{{{columns}}}{{@{{}}l@{{}}}}{{\makebox[0pt][l]{{{box}}}}} \\"


def _spec(column: Column, table: Table) -> str:
    """Alignment of a column."""
    if column.share:
        return rf">{{\raggedright\arraybackslash}}p{{{column.share:g}\linewidth}}"
    values = [row[column.name] for row in table.rows]
    return "r" if any(isinstance(v, (int, float)) for v in values) else "l"


def _head(column: Column) -> str:
    return f"${column.latex}$" if column.latex else escaped(column.name.replace("_", " "))


def _unit(column: Column, table: Table) -> str:
    words = _measure(column, table)
    if not words or column.latex == r"\pm":  # an error has the unit of the column before it
        return ""
    return f"{{[{words}]}}"  # a bare [ would belong to the line before


def _measure(column: Column, table: Table) -> str:
    """The unit of a column in LaTeX; empty where it has none."""
    text = column.unit(dimensionless=table.dimensionless)
    plain = table.dimensionless and not isinstance(column.kind, str)
    return unit(text, dimensionless=plain) if text else ""


def _blocks(table: Table) -> list[list[str]]:
    """Lines of each row, with those of a heading where it changes."""
    groups = [c for c in table.columns if c.place == "group"]
    cells = [c for c in table.columns if c.place == "cell"]
    below = [c for c in table.columns if c.place == "below"]
    out: list[list[str]] = []
    last = None
    for row in table.rows:
        block = []
        title = "; ".join(_titled(c, row) for c in groups if row[c.name] not in (None, ""))
        if out and not groups and any(c.share for c in cells):
            block.append(r"\addlinespace")
        if title != last and groups:
            block += [r"\addlinespace"] if out else []
            line = rf"\multicolumn{{{len(cells)}}}{{@{{}}l@{{}}}}{{\textit{{{title}}}}} \\*"
            block.append(line if len(title) < SHORT else across(len(cells), rf"\textit{{{title}}}"))
            last = title
        block.append(" & ".join(cell(c, row) for c in cells) + r" \\" + "*" * bool(below))
        said = [_said(c, row, table) for c in below if row[c.name] not in (None, "")]
        block += [across(len(cells), "; ".join(said), r"\quad ")] if said else []
        out.append(block)
    return out


def _titled(column: Column, row: Mapping[str, Any]) -> str:
    text = column.written(row[column.name])
    return f"${column.latex}={number(text).strip('$')}$" if column.latex else prose(text)


def _said(column: Column, row: Mapping[str, Any], table: Table) -> str:
    text = prose(column.written(row[column.name]))
    if column.name in ("why", "status", "origin"):
        return text
    measure = _measure(column, table)
    return f"{prose(column.name)}: {text}{' ' * bool(measure)}{measure}"


def cell(column: Column, row: Mapping[str, Any]) -> str:
    """A value in LaTeX."""
    value = row[column.name]
    if column.of and isinstance(value, float) and math.isfinite(value):
        value = as_printed(value, row[column.of[0]], column.of[1])
    text = column.written(value)
    return prose(text) if column.share else number(text)


def as_printed(bound: float, value: float, form: str) -> float:
    """A bound that holds for the printed digits of its number, rounded up to two digits."""
    off = abs(Fraction(form.format(value)) - Fraction(value))
    whole = max(Fraction(bound) + off, Fraction(math.ulp(value)))
    with localcontext(rounding=ROUND_CEILING):
        return float(f"{Decimal(math.nextafter(float(whole), math.inf)):.0e}")


def symbols(table: Table) -> list[str]:
    """A paragraph that defines the symbols of a table, and its other columns."""
    said = []
    for column in table.columns:
        named = []
        for word, quantity in column.quantities(table.rows).items():
            label = quantity.kind.label(dimensionless=table.dimensionless)
            words = unit(label, dimensionless=table.dimensionless)
            named.append(f"{prose(word)}: ${quantity.latex or quantity.symbol}$ in {words}")
        units = f" ({', '.join(named)})" if named else ""
        said.append(f"{_head(column)}: {prose(column.meaning)}{units}")
    return [r"\noindent " + "; ".join(said) + "."]


def _paragraphs(lines: Sequence[str]) -> list[str]:
    r"""Notes in LaTeX: lines of one paragraph joined, an indented line alone.

    Examples
    --------
    >>> _paragraphs(["one", "two", "  alone"])
    ['', 'one two', '', '\\quad alone']
    """
    out: list[str] = []
    whole: list[str] = []
    for line in (*lines, ""):
        if whole and (not line or line.startswith(" ")):
            out += ["", prose(" ".join(whole))]
            whole = []
        if line.startswith(" "):
            out += ["", rf"\quad {prose(line)}"]
        elif line:
            whole.append(line)
    return out


# --- a table ---


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
    definition: Definition = getattr(import_module(module), name)
    return definition


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
    >>> drift.to_csv().splitlines()[0].split(",")[:3]
    ['k', 'mu [1/√(gR)]', 'omega3 [√(g/R)]']
    """

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

    def __repr__(self) -> str:
        rows = f"{len(self.rows)} row{'s' * (len(self.rows) != 1)}"
        names = [c.header(dimensionless=self.dimensionless) for c in self.columns]
        return f"<Table {self.name}, {rows}: {', '.join(names)}>"

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
        header, cells = flat(self.columns, self.rows, dimensionless=self.dimensionless)
        words = (re.fullmatch(r"(.*) \[(.*)\]", name) for name in header)
        names = [
            f"{m[1]} [{readable(m[2])}]" if m else name
            for m, name in zip(words, header, strict=True)
        ]
        rows = [
            ["" if v is None else f"{v:.6g}" if isinstance(v, float) else str(v) for v in row]
            for row in cells
        ]
        return html_table(self.heading, names, rows)

    def printed(self, form: str) -> str:
        """The table in a form of `FORMS`: text, csv, json or latex."""
        forms = {"csv": self.to_csv, "json": self.to_json, "latex": self.to_latex}
        return forms.get(form, self.to_text)()

    def write(self, path: str | os.PathLike[str], *, overwrite: Overwrite = False) -> Path:
        """Write the table to a file, in the form that its ending names.

        Parameters
        ----------
        path
            A file that ends in .csv, .json, .tex or .txt.
        overwrite
            Whether an existing file may be replaced; "same": if the same call wrote it.

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
        write_file(target, text.rstrip("\n") + "\n", overwrite=overwrite)
        return target
