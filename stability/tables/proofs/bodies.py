"""Table of statements about every body of revolution: theorems, polynomials, limits."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict
from typing import Any

from ...base.citation.used import cited
from ..formats.about import About, Standing
from ..formats.column import Column, word
from ..formats.latex import END, breaking, longtable, start
from ..formats.letters import prose
from ..formats.plain import framed
from ..formats.table import Definition, Table
from .theorems import paragraph, step_lines, step_rows

NOTES = (
    "Over mass and length: m = g = 1. s = sinθ, c = cosθ; h, h′, h′′ the height of the centre and",
    "its derivatives at the state, ρ = h + h′′; r = h s + h′ c and z = h c - h′ s say where the",
    "contact point lies; I1 and I3 the transverse and axial moment; F the contact force, gn the",
    "normal force, vA the slip; n = omega_Z the rate of vertical spin, Ẑ the vertical; κ = I1/L².",
)
"""Meaning of the symbols."""


def _rows(progress: Callable[[int, int], None] | None = None) -> list[dict[str, Any]]:
    from ...derivation.bodies.catalogue import entries

    return [asdict(entry) for entry in entries(progress)]


def _lines(rows: list[dict[str, Any]]) -> list[str]:
    lines: list[str] = []
    for number, row in enumerate(rows, start=1):
        lines.append(f"{number}. {row['part']}: {row['name']}  [{row['status']}]")
        lines += [line for text in row["statement"] for line in paragraph(text, "   ")]
        for title, key in (("Source", "source"), ("Published", "published")):
            lines += paragraph(f"{title}: {row[key]}", "   ") if row[key] else []
        for title, key in (("Assumptions:", "assumptions"), ("Tests:", "refuters")):
            if row[key]:
                lines.append(f"   {title}")
                lines += [x for text in row[key] for x in paragraph(text, "     ", "- ")]
        if row["steps"]:
            lines.append("   Steps as checked:")
            for place, step in enumerate(row["steps"], start=1):
                lines += step_lines(place, step)
        lines.append("")
    return [*lines, *NOTES]


def _latex(table: Table) -> str:
    out = [start("bodies")]
    for number, row in enumerate(table.rows, start=1):
        title = f"{row['part']}: {row['name']}"
        out += ["", rf"\paragraph{{{number}. {prose(title)}}} ({prose(row['status'])})", ""]
        out += [f"{prose(text)}\n" for text in row["statement"]]
        for title, key in (("Source", "source"), ("Published", "published")):
            out += [f"{title}: {prose(row[key])}.\n"] if row[key] else []
        if row["assumptions"]:
            out += ["Assumptions: " + "; ".join(map(prose, row["assumptions"])) + "."]
        if row["steps"]:
            out += longtable(
                f"Steps of statement {number} as checked: {row['name']}",
                ["r", breaking(0.42), breaking(0.5)], ["", "step", "checked by"],
                step_rows(row["steps"]), label=f"body-{number}",
            )  # fmt: skip
    return "\n".join([*out, "", prose(" ".join(NOTES)), END])


TABLE = Definition(
    "statements about every body of revolution, derived and proved from the general graph",
    (
        word("part", "theorem, polynomial, known result, rounded rim, or Painlevé limit"),
        word("name", "short name"),
        word("status", "what stands behind the statement"),
        word("statement", "sentences, or coefficients of a polynomial"),
        Column("limit", "Painlevé's limit of mu |vx|, its proved lower end", form="{:.12g}"),
        word("assumptions", "assumptions of the statement"),
        word("steps", "steps of the proof as checked"),
        word("refuters", "tests that try to refute the statement"),
        word("source", "where a known result is from, and how much of it was at hand"),
        word("published", "what the source prints, where that was at hand"),
    ),
    _rows,
    ("progress",),
    text=lambda table: framed(table, _lines(table.rows)),
    latex=_latex,
    about=About(
        "this package: statements on bodies of revolution; known results named row by row",
        "formulas and words in the column `published` of known results",
        "each statement from the general equations, by computer algebra",
        Standing.DERIVED,
    ),
    cites=cited(model=True, proofs=True, theory=["sympy"]),
    home=f"{__name__}:TABLE",
)
"""The table for the registry."""
