"""The list of tables."""

from __future__ import annotations

from ...base.errors import StabilityError
from ..formats.column import word
from ..formats.plain import framed
from ..formats.table import Definition, Table
from .places import PLACES, definition


def listed() -> list[dict[str, str]]:
    """One row for each table.

    Returns
    -------
    list of dict

    Raises
    ------
    StabilityError
        If a table does not say where it is from.

    Examples
    --------
    >>> [row["name"] for row in listed()][:3]
    ['families', 'conditions', 'drift']
    """
    from ..beyond_linear import POINTS

    every = {name: definition(name) for name in PLACES if name != "list"} | {"codimension": POINTS}
    rows = []
    for name, one in every.items():
        if one.about is None:
            raise StabilityError(f"the table {name} has no source; give its Definition `about`.")
        shows = one.heading.format(name="a family").removesuffix(" (recomputed)")
        rows.append(
            {
                "name": name,
                "shows": shows,
                "source": one.about.source,
                "published": one.about.published,
                "recomputed": one.about.recomputed,
                "difference": one.about.difference,
                "status": str(one.about.standing.value),
            }
        )
    return rows


def _text(table: Table) -> str:
    lines: list[str] = []
    for row in table.rows:
        lines += ["", f"{row['name']}: {row['shows']}"]
        lines += [f"    {c.name:<11} {row[c.name]}" for c in table.columns[2:]]
    return framed(table, lines[1:])


TABLE = Definition(
    "the tables, and whether each is reproduced or recomputed",
    (
        word("name", "name of the table"),
        word("shows", "what the table shows", share=0.15),
        word("source", "where equations, statements or values are from", share=0.17),
        word("published", "what of the source was at hand as printed", share=0.13),
        word("recomputed", "what the package computes, and by which route", share=0.15),
        word("difference", "largest difference from the known values", share=0.11),
        word("status", "whether the table is reproduced", "below"),
    ),
    listed,
    notes=lambda table: [f"{len(table.rows)} tables; `stability table NAME` computes one."],
    text=_text,
    home=f"{__name__}:TABLE",
)
"""The table for the registry."""
