"""Table of the proof that the viscous disk has no other steady motions."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from ...base.citation.used import cited
from ..formats.about import About, Standing
from ..formats.column import Column, word
from ..formats.plain import framed
from ..formats.table import Definition, Table


def _rows() -> list[dict[str, Any]]:
    from ...derivation.completeness import prove

    return [asdict(step) for step in prove()]


def _search() -> dict[str, Any]:
    from ...derivation.completeness import search

    return {"search": asdict(search())}


def _notes(table: Table) -> list[str]:
    found = table.more["search"]
    names = ", ".join(f"{n} {c}" for n, c in found["found"].items())
    return [
        f"Search: {found['starts']} starts in the box {found['box']};",
        f"{found['converged']} reached a root ({names});",
        f"{found['outside']} outside the three families.",
    ]


def _text(table: Table) -> str:
    lines = []
    for number, row in enumerate(table.rows, start=1):
        mark = "holds" if row["holds"] else "FAILS"
        lines += [f"{number}. {row['claim']}", f"   {row['identity']}  [{mark}]"]
    return framed(table, lines)


TABLE = Definition(
    "why the viscous disk has no other steady motions: proof and search",
    (
        word("claim", "consequence of the identity", share=0.46),
        word("identity", "identity of the graph from which the claim follows", share=0.4),
        Column("holds", "whether computer algebra confirms the identity"),
    ),
    _rows,
    notes=_notes, text=_text, more=_search,
    about=About(
        "this package: the steady motions of the viscous disk",
        "no value",
        "a proof step by step, and a search from random starts",
        Standing.DERIVED,
    ),
    cites=cited(model=True, theory=["sympy"]),
    home=f"{__name__}:TABLE",
)  # fmt: skip
"""The table for the registry."""
