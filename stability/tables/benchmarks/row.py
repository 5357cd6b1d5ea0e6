"""A known value, the recomputed one, and what can be said: a row, its columns, their table."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction
from typing import Any, NamedTuple

import casadi as ca

from ...base.errors import StabilityWarning, listed
from ...base.types import Progress
from ...base.verdict import Verdict
from ...boundary.changes import boundaries
from ...spectra.spectrum import spectrum
from ...systems.family import Family
from ...systems.system import System
from ..table import Column, Definition, framed, word

PUBLISHED = "published"
"""Origin of a number that its source prints."""
QUOTED = "quoted at second hand"
"""Origin of a number that its source prints by the word of another, the print not at hand."""
CLOSED = "closed form"
"""Origin of a number from a formula of its source."""
ELSEWHERE = "recomputed elsewhere"
"""Origin of a number from at least one route outside the package."""
AGREES = "agrees to all digits"
"""Status where the recomputed value rounds to the known one."""
SIDE = 1e-12
"""Relative distance from a threshold at which the verdicts on both sides are certified."""


class Source(NamedTuple):
    """A system, and where its known values come from."""

    system: str
    """Name of the system."""
    source: str
    """Paper, course or code."""
    origin: str = CLOSED
    """How its values are known: `PUBLISHED`, `QUOTED`, `CLOSED` or `ELSEWHERE`."""


@dataclass(frozen=True)
class BenchmarkRow:
    """One known value, and the same quantity from the package."""

    system: str
    """Name of the system."""
    quantity: str
    """What is compared."""
    unit: str
    """SI unit, or empty."""
    source: str
    """Where the equations or the value are from."""
    origin: str
    """How the value is known: `PUBLISHED`, `QUOTED`, `CLOSED` or `ELSEWHERE`."""
    known: str
    """The known value with all its digits."""
    recomputed: float | None
    """The package's value, or None."""
    difference: float | None
    """Recomputed minus known, or None."""
    status: str
    """`AGREES`, how many digits agree, or why the package has no value."""
    below: str
    """Certified verdict at a relative distance of 1e-12 below a threshold; empty elsewhere."""
    above: str
    """Certified verdict at a relative distance of 1e-12 above a threshold; empty elsewhere."""
    bound: float | None = None
    """Proved bound on the error of the recomputed value, in 16 digits; None where there is none."""


Case = Callable[[], list[BenchmarkRow]]
"""A function that returns the rows of a system."""
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
"""The fields of a row, as columns of a table."""
IN_SENTENCES = (
    *("system", "quantity", "unit", "source", "origin", "known"),
    *("recomputed", "difference", "status", "below", "above"),
)
"""Columns that the sentences of the text name; any further one has a line of its own."""


def compared(
    about: Source,
    quantity: str,
    reference: str,
    recomputed: float | None,
    *,
    unit: str = "",
    sides: tuple[str, str] = ("", ""),
    reason: str = "",
    inputs: float = 0.0,
    exact: str = "",
) -> BenchmarkRow:
    """A row from a known value and the package's.

    Parameters
    ----------
    about
        System and source.
    quantity
        What is compared.
    reference
        The known value as it is given, with all its digits.
    recomputed
        The package's value, or None.
    unit
        SI unit.
    sides
        Certified verdicts below and above.
    reason
        Why there is no value.
    inputs
        What rounding of the published inputs can change in the value.
    exact
        The value from arithmetic of many digits, where the last published digits are not right.

    Examples
    --------
    >>> pi = Source("circle", "Archimedes")
    >>> compared(pi, "half its length", "3.14159", 3.141592653589793).status
    'agrees to all digits'
    >>> compared(pi, "half its length", "3.14159", 3.1415).status
    'agrees to 4 digits of 6'
    """
    if recomputed is None or not math.isfinite(recomputed):
        recomputed, difference, status = None, None, f"not covered: {reason}"
    else:
        off = Fraction(recomputed) - Fraction(reference)
        difference, status = float(off), _status(reference, recomputed, off, inputs, exact)
    return BenchmarkRow(
        about.system,
        quantity,
        unit,
        about.source,
        about.origin,
        reference,
        recomputed,
        difference,
        status,
        *sides,
    )


def _status(reference: str, recomputed: float, off: Fraction, inputs: float, exact: str) -> str:
    last = _last_digit(reference)
    if abs(off) <= last / 2 + Fraction(math.ulp(recomputed)):
        return AGREES
    beyond = abs(Fraction(recomputed) - Fraction(exact or reference))
    if exact and beyond <= _last_digit(exact) / 2 + Fraction(math.ulp(recomputed)):
        return f"agrees to all digits of {exact}; the last published digits are not right"
    if abs(off) <= last / 2 + Fraction(inputs):
        return f"agrees within the rounding of the published inputs, {inputs:.0e}"
    digits = -math.log10(float(abs(off)) / abs(float(reference) or 1.0)) - math.log10(2)
    all_digits = len(Decimal(reference).as_tuple().digits)
    return f"agrees to {max(0, math.floor(digits))} digits of {all_digits}"


def _last_digit(value: str) -> Fraction:
    return Fraction(Decimal(1).scaleb(int(Decimal(value).as_tuple().exponent)))


class Threshold(NamedTuple):
    """A change of verdict, and what is certified next to it."""

    value: float | None
    """Value of the family's parameter, or None where none was found."""
    frequency: float | None
    """Frequency of the pair that crosses, or None."""
    sides: tuple[str, str]
    """Certified verdicts at a relative distance of 1e-12 below and above."""
    reason: str
    """Why there is no value."""


def threshold(family: Family, low: float, high: float, points: int = 9, **values: Any) -> Threshold:
    """The only change of verdict along a family, and the certified verdicts on both sides."""
    for end in (low, high):
        if certified(family, end, values) == Verdict.UNDECIDED.word:
            why = f"the verdict at {family.at[0]} = {end:g} is undecided"
            return Threshold(None, None, ("", ""), why)
    with warnings.catch_warnings():  # an incomplete search is no reason to hide what it found
        warnings.simplefilter("ignore", StabilityWarning)
        changes = boundaries(family, axis=(family.at[0], low, high, points), **values)
    if len(changes) != 1:
        why = f"{len(changes)} changes of verdict between {low:g} and {high:g}"
        return Threshold(None, None, ("", ""), why)
    value = changes[0].value
    sides = [certified(family, value + side * abs(value), values) for side in (-SIDE, SIDE)]
    return Threshold(value, changes[0].frequency, (sides[0], sides[1]), "")


def certified(family: Family, at: float, values: Mapping[str, Any]) -> str:
    """The verdict at a member in one word; `undecided` where there is no proof."""
    result = spectrum(family, at=at, certify=True, **values)
    return str((result.verdict if result.certified else Verdict.UNDECIDED).word)


def at_threshold(
    about: Source,
    quantity: str,
    reference: str,
    change: Threshold,
    *,
    unit: str = "",
    scale: float = 1.0,
    exact: str = "",
) -> BenchmarkRow:
    """A row of a threshold; `scale` leads from the family's parameter to the known quantity."""
    value = None if change.value is None else change.value * scale
    return compared(
        about,
        quantity,
        reference,
        value,
        unit=unit,
        sides=change.sides,
        reason=change.reason,
        exact=exact,
    )


# --- the table of such rows ---


def rows_of(cases: Iterable[Case], progress: Progress | None = None) -> list[BenchmarkRow]:
    """The rows of some cases; `progress` is called with (cases done, cases in all)."""
    cases = list(cases)
    rows: list[BenchmarkRow] = []
    for done, case in enumerate(cases, start=1):
        rows += case()
        if progress is not None:
            progress(done, len(cases))
    return rows


def of_known_values(
    heading: str,
    rows: Callable[..., list[BenchmarkRow]],
    takes: tuple[str, ...] = ("progress",),
    columns: tuple[Column, ...] = COLUMNS,
    notes: Callable[[Sequence[dict[str, Any]]], list[str]] | None = None,
    **more: Any,
) -> Definition:
    """The definition of a table of known values; `rows` takes the options in `takes`."""
    return Definition(
        heading,
        columns,
        lambda **options: [{c.name: getattr(r, c.name) for c in columns} for r in rows(**options)],
        takes,
        lambda table: (notes or benchmark_notes)(table.rows),
        lambda table: framed(table, benchmark_lines(table.rows, columns)),
        **more,
    )


def benchmark_lines(
    rows: Sequence[dict[str, object]], columns: Sequence[Column] = COLUMNS
) -> list[str]:
    """The table of benchmarks as lines of text, one paragraph for each system."""
    lines: list[str] = []
    title = None
    for row in rows:
        if row["system"] != title:
            title = row["system"]
            lines += ["", f"{title}  ({row['source']})"]
        lines += _lines_of(row, columns)
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


def _lines_of(row: dict[str, object], columns: Sequence[Column]) -> list[str]:
    unit = f" {row['unit']}" if row["unit"] else ""
    value, off = row["recomputed"], row["difference"]
    text = "-" if value is None else f"{value:.16g}{unit}"
    by = "" if off is None else f", difference {off:.1e}"
    lines = [
        f"    {row['quantity']}",
        f"        known {row['known']}{unit} ({row['origin']})",
        f"        found {text}{by}: {row['status']}",
    ]
    if row.get("below"):
        lines += [f"        below {row['below']}, above {row['above']} (certified)"]
    further = [c for c in columns if c.name not in IN_SENTENCES and row[c.name] not in (None, "")]
    for column in further:
        written = f"{column.written(row[column.name])} {column.unit(dimensionless=False)}"
        lines += [f"        {column.name} {written.rstrip()}"]
    return lines


# --- how a system is written down ---


def symbols(names: str) -> list[ca.SX]:
    """Scalar symbols of these names."""
    return [ca.SX.sym(name) for name in names.split()]


def system_of(
    name: str,
    states: Sequence[ca.SX],
    parameters: Sequence[ca.SX],
    rates: Sequence[ca.SX],
    **more: Any,
) -> System:
    """A system of scalar symbols, which have their names already."""
    return System(
        name,
        ca.vertcat(*states),
        ca.vertcat(*parameters),
        ca.vertcat(*rates),
        states=tuple(s.name() for s in states),
        parameters=tuple(p.name() for p in parameters),
        **more,
    )


def at_zero(system: System, name: str, at: str, **others: float) -> Family:
    """A family all of whose states vanish but `others`."""
    return Family(system, name, at=(at,), held=dict.fromkeys(system.states, 0.0) | others)
