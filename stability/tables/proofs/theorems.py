"""Table of theorems: statements, steps as checked, and the tests that try to refute them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from textwrap import wrap
from typing import Any

from ...base.citation.used import cited
from ...derivation.proof import Step
from ..formats.about import About, Standing
from ..formats.column import Column, word
from ..formats.latex import END, breaking, longtable, start
from ..formats.letters import prose
from ..formats.plain import framed
from ..formats.table import Definition, Table

WIDTH = 100
"""Columns of the text."""
NOTES = (
    "Dimensionless: m = R = g = 1, s = sinθ, c = cosθ, I1 = k, I3 = 2k, vA the slip, gn the",
    "normal force, F the horizontal contact force; M = mu*², z = at*².",
)
"""Meaning of the symbols."""


@dataclass(frozen=True)
class TheoremRow:
    """One theorem about the disk."""

    name: str
    """Short name."""
    proved: bool
    """Whether every step is proved."""
    statement: tuple[str, ...]
    """Sentences that the steps prove together; without proof where `proved` is false."""
    assumptions: tuple[str, ...]
    """Assumptions of the statement."""
    steps: tuple[Step, ...]
    """Steps of the proof as checked."""
    refuters: tuple[str, ...]
    """Tests that try to refute the statement, as `file::test`."""


def theorem_rows(progress: Callable[[int, int], None] | None = None) -> list[TheoremRow]:
    """Every theorem, proved again.

    Parameters
    ----------
    progress
        Called with (theorems done, theorems in all).

    Returns
    -------
    list of TheoremRow

    Source: each step is computed from the graph; tests/derivation/test_theorems.py.
    """
    from ...derivation.theorems.catalogue import theorems

    return [
        TheoremRow(t.name, t.proved, t.statement, t.assumptions, t.steps, t.refuters)
        for t in theorems(progress)
    ]


def theorem_lines(rows: list[dict[str, Any]]) -> list[str]:
    """The theorems as lines of text.

    Parameters
    ----------
    rows
        Rows as records.

    Returns
    -------
    list of str
    """
    lines: list[str] = []
    for number, row in enumerate(rows, start=1):
        lines.append(f"{number}. {row['name']}  [{'proved' if row['proved'] else 'NOT PROVED'}]")
        if not row["proved"]:
            lines.append("   A step failed: what follows is a conjecture.")
        lines += [line for text in row["statement"] for line in paragraph(text, "   ")]
        lines.append("   Assumptions:")
        lines += [line for text in row["assumptions"] for line in paragraph(text, "     ", "- ")]
        lines.append("   Steps as checked:")
        for place, step in enumerate(row["steps"], start=1):
            lines += step_lines(place, step)
        lines.append("   Tests that try to refute it:")
        lines += [f"     - {name}" for name in row["refuters"]] + [""]
    return [*lines, *NOTES]


def step_lines(place: int, step: dict[str, Any]) -> list[str]:
    """One step of a proof as lines of text.

    Parameters
    ----------
    place
        Number of the step.
    step
        The step as a record.
    """
    mark = "proved" if step["proved"] else "FAILS"
    lines = paragraph(f"{step['claim']}  [{mark}]", "     ", f"{place}. ")
    lines += paragraph(f"by {step['method']}", "        ")
    return lines + (paragraph(f"-> {step['detail']}", "        ") if step["detail"] else [])


def step_rows(steps: Sequence[dict[str, Any]]) -> list[str]:
    """Steps of a proof as rows of LaTeX.

    Parameters
    ----------
    steps
        The steps as records.
    """
    rows = []
    for place, step in enumerate(steps, start=1):
        how = prose(step["method"]) + (f": {prose(step['detail'])}" if step["detail"] else "")
        fails = "" if step["proved"] else r"\textbf{fails:} "
        rows.append(rf"{place} & {prose(step['claim'])} & {fails}{how} \\")
    return rows


def paragraph(text: str, indent: str, mark: str = "") -> list[str]:
    """A text as lines of at most `WIDTH` columns.

    Parameters
    ----------
    text
        The text.
    indent, mark
        What stands before it, on each line and on the first.
    """
    return wrap(
        text, WIDTH, initial_indent=indent + mark, subsequent_indent=indent + " " * len(mark),
        break_long_words=False, break_on_hyphens=False,
    )  # fmt: skip


def _latex(table: Table) -> str:
    out = [start("theorems")]
    for number, row in enumerate(table.rows, start=1):
        mark = "proved" if row["proved"] else "not proved: a conjecture"
        out += ["", rf"\paragraph{{{number}. {prose(row['name'])}}} ({mark})", ""]
        out += [f"{prose(text)}\n" for text in row["statement"]]
        out += ["Assumptions: " + "; ".join(prose(text) for text in row["assumptions"]) + "."]
        out += longtable(
            f"Steps of theorem {number} as checked: {row['name']}",
            ["r", breaking(0.42), breaking(0.5)], ["", "step", "checked by"],
            step_rows(row["steps"]), label=f"theorem-{number}",
        )  # fmt: skip
        out += ["Tests that try to refute it: " + "; ".join(map(prose, row["refuters"])) + "."]
    return "\n".join([*out, "", prose(" ".join(NOTES)), END])


TABLE = Definition(
    "statements about the disk, proved step by step from its graph",
    (
        word("name", "short name"),
        Column("proved", "whether every step is proved"),
        word("statement", "sentences that the steps prove together"),
        word("assumptions", "assumptions of the statement"),
        word("steps", "steps of the proof as checked"),
        word("refuters", "tests that try to refute the statement"),
    ),
    lambda **options: [asdict(row) for row in theorem_rows(**options)],
    ("progress",),
    text=lambda table: framed(table, theorem_lines(table.rows)),
    latex=_latex,
    about=About(
        "this package: statements on the disk",
        "no value",
        "each step of each proof, by computer algebra",
        Standing.DERIVED,
    ),
    cites=cited(model=True, theory=["sympy"]),
    home=f"{__name__}:TABLE",
)
"""The table for the registry."""
