"""Every system of the table, and the table itself."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict

from ...base.checks import chosen
from ...base.citation import cited
from ...base.errors import listed
from ..table import About, Column, Definition, Standing, framed, word
from .bicycle import linear_bicycle, nonlinear_bicycle
from .oscillators import (
    axon,
    nerve,
    rotor,
    saddle,
    stick_slip,
    swinging,
    triangular_points,
    ziegler,
)
from .row import BenchmarkRow, Case
from .spinning import gyropendulum, lagrange, liquid, sphere, tippe, vortices
from .wheels import hunting, sympy_disc, turning

CASES: dict[str, Case] = {
    "nonlinear bicycle": nonlinear_bicycle,
    "linear bicycle": linear_bicycle,
    "tippe top": tippe,
    "railway wheelset": hunting,
    "Watt governor": swinging,
    "Ziegler column": ziegler,
    "Lagrange top": lagrange,
    "triangular points": triangular_points,
    "Chaplygin sleigh": turning,
    "mass on a belt": stick_slip,
    "Jeffcott rotor": rotor,
    "rotating saddle": saddle,
    "SymPy's rolling disc": sympy_disc,
    "gyropendulum": gyropendulum,
    "Routh's sphere": sphere,
    "body in a liquid": liquid,
    "vortices about a vortex": vortices,
    "FitzHugh-Nagumo nerve": nerve,
    "Hodgkin-Huxley axon": axon,
}
"""The function of each system's rows, by name."""


def benchmark_rows(
    systems: str | Sequence[str] | None = None, progress: Callable[[int, int], None] | None = None
) -> list[BenchmarkRow]:
    """Every known value, recomputed.

    Parameters
    ----------
    systems
        Names from `CASES`, or words of names; every system when left out.
    progress
        Called with (systems done, systems in all).

    Raises
    ------
    NameUnknownError
        If a system is unknown.

    Source: each row names its own; tests/tables/test_benchmarks.py.

    Examples
    --------
    >>> for row in benchmark_rows(["Jeffcott rotor"]):
    ...     print(row.recomputed, row.below, row.above, row.status)
    250.0 stable unstable agrees to all digits
    """
    known = {name: name.split()[-1] for name in CASES}  # a refusal has room for these
    names = list(known) if systems is None else chosen("system", systems, known)
    rows: list[BenchmarkRow] = []
    for done, name in enumerate(names, start=1):
        rows += CASES[name]()
        if progress is not None:
            progress(done, len(names))
    return rows


def benchmark_lines(rows: Sequence[dict[str, object]]) -> list[str]:
    """The table of benchmarks as lines of text, one paragraph for each system."""
    lines: list[str] = []
    title = None
    for row in rows:
        if row["system"] != title:
            title = row["system"]
            lines += ["", f"{title}  ({row['source']})"]
        lines += _lines_of(row)
    return lines[1:]


def benchmark_notes(rows: Sequence[dict[str, object]]) -> list[str]:
    """How many known values agree, as lines of text."""
    missing = [row for row in rows if row["recomputed"] is None]
    agree = sum(str(row["status"]).startswith("agrees") for row in rows)
    systems = list(dict.fromkeys(str(row["system"]) for row in missing))
    where = f"; not covered: {len(missing)} ({listed(systems)})" if missing else ""
    return [
        f"{len(rows)} known values, {agree} agree{where}.",
        "below, above: certified verdicts at a relative distance of 1e-12 from a threshold.",
    ]


def _lines_of(row: dict[str, object]) -> list[str]:
    unit = f" {row['unit']}" if row["unit"] else ""
    value, off = row["recomputed"], row["difference"]
    found = "-" if value is None else f"{value:.16g}{unit}"
    by = "" if off is None else f", difference {off:.1e}"
    lines = [
        f"    {row['quantity']}",
        f"        known {row['known']}{unit} ({row['origin']})",
        f"        found {found}{by}: {row['status']}",
    ]
    if row["below"]:
        lines += [f"        below {row['below']}, above {row['above']} (certified)"]
    return lines


COLUMNS = (
    word("system", "name of the system", "group"),
    word("quantity", "quantity that is compared", share=0.22),
    word("unit", "unit of the values"),
    word("source", "source of the equations or the value", "group"),
    word("origin", "origin of the known value", "below"),
    word("known", "known value with all its digits"),
    Column("recomputed", "the value of this package", form="{:.16g}"),
    Column("difference", "recomputed minus known", form="{:.1e}"),
    word("status", "digits that agree, or why there is no value", "below"),
    word("below", "certified verdict below a threshold", "below"),
    word("above", "certified verdict above a threshold", "below"),
)
"""Columns of a table of known values."""

TABLE = Definition(
    "systems with known answers: known value, recomputed value, certified verdicts",
    COLUMNS,
    lambda **options: [asdict(row) for row in benchmark_rows(**options)],
    ("systems", "progress"),
    lambda table: benchmark_notes(table.rows),
    lambda table: framed(table, benchmark_lines(table.rows)),
    about=About(
        "a paper, course or code for each system, named in its rows",
        "values of the rows that are marked `published`",
        "every value by this package, from the system's equations",
        Standing.PARTLY,
        largest=4e-10,
    ),
    cites=cited(eigenvalues=True, proofs=True),
    home=f"{__name__}:TABLE",
)
"""The table for the registry."""
