"""Tables as lines of text."""

from __future__ import annotations

from collections.abc import Sequence

from .column import Content


def plain(table: Content) -> str:
    """Heading, rows in columns of equal width, notes.

    Parameters
    ----------
    table
        The table.

    Returns
    -------
    str
    """
    cells = [[c.name for c in table.columns]]
    cells += [[c.written(row[c.name]) for c in table.columns] for row in table.rows]
    return framed(table, aligned(cells))


def framed(table: Content, lines: Sequence[str]) -> str:
    """Lines of a table between its heading and its notes.

    Parameters
    ----------
    table
        The table.
    lines
        Its rows as text.

    Returns
    -------
    str
    """
    notes = table.notes
    return "\n".join([table.heading, "", *lines, *([""] if notes else []), *notes])


def aligned(cells: Sequence[Sequence[str]]) -> list[str]:
    """Lines of columns with equal width, the first line underlined.

    Parameters
    ----------
    cells
        Words of each line.

    Returns
    -------
    list of str

    Examples
    --------
    >>> aligned([["k", "mu"], ["0.25", "1"]])
    ['k     mu', '----  --', '0.25  1']
    """
    widths = [max(len(row[i]) for row in cells) for i in range(len(cells[0]))]
    lines = [
        "  ".join(c.ljust(w) for c, w in zip(row, widths, strict=True)).rstrip() for row in cells
    ]
    return [lines[0], "  ".join("-" * w for w in widths), *lines[1:]]


def units_note(table: Content) -> str:
    """Units of a table's columns in one line.

    Parameters
    ----------
    table
        The table.

    Returns
    -------
    str
    """
    by_unit: dict[str, list[str]] = {}
    for column in table.columns:
        for word, quantity in column.quantities(table.rows).items():
            unit = quantity.kind.label(dimensionless=table.dimensionless)
            by_unit.setdefault(unit, []).append(f"{column.name} ({word})")
        unit = column.unit(dimensionless=table.dimensionless)
        if unit:
            by_unit.setdefault(unit, []).append(column.name)
    return "; ".join(f"{', '.join(names)} in {unit}" for unit, names in by_unit.items())
