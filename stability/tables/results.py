"""A spectrum and boundaries as tables, for LaTeX."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from ..base.quantities import Kind
from ..base.verdict import Evidence
from ..boundary.brackets import Crossings
from ..derivation.latex import symbol
from .table import Column, Definition, Table, latex, word


def _without_origin(table: Table) -> str:
    """LaTeX of a result, which is no table of the list."""
    text = latex(table)
    return text.replace(
        f"% stability table {table.name}: recomputed", f"% stability {table.name}", 1
    )


SPECTRUM = Definition(
    "{subject}", (), lambda: [], latex=_without_origin, home="stability.tables.results:SPECTRUM"
)
BOUNDARIES = Definition(
    "{subject}", (), lambda: [], latex=_without_origin, home="stability.tables.results:BOUNDARIES"
)


def _heading(subject: str) -> str:
    """A subject whose units have no digit that LaTeX would put to the number before it."""
    return re.sub(r"(?<=\d) 1/", "/", subject)


def spectrum_table(spectrum: Any, subject: str) -> Table:
    """The eigenvalues of one member, a row for each.

    Parameters
    ----------
    spectrum
        A single `Spectrum`.
    subject
        What it is of, for the heading.
    """
    rate: Kind | str = spectrum.rate_unit
    if spectrum.family.system.quantities:
        rate = Kind.GROWTH_RATE
    columns = (
        Column("real", "real part of an eigenvalue", rate, r"\operatorname{Re}\lambda", "{:.9g}"),
        Column("imaginary", "imaginary part", rate, r"\operatorname{Im}\lambda", "{:.9g}"),
        Column("error", "bound on the error before rounding to these digits", rate, form="{:.0e}"),
        word("mode", "what the mode does, and in which states", share=0.36),
    )
    rows = [
        {"real": v.real + 0.0, "imaginary": v.imag + 0.0, "error": float(r), "mode": label}
        for v, r, label in zip(
            spectrum.eigenvalues, spectrum.radius, spectrum.modes.labels, strict=True
        )
    ]
    return Table(
        "spectrum",
        f"{_heading(subject)}: {spectrum.verdict.word}, {spectrum.reason}",
        columns,
        rows,
        spectrum.dimensionless,
        definition=SPECTRUM,
        citation=spectrum.citation,
    )


def boundaries_table(points: Any, subject: str, axis: str, kinds: Mapping[str, Any]) -> Table:
    """Boundaries along an axis, a row for each.

    Parameters
    ----------
    points
        The `Boundaries`, or every crossing.
    subject
        What they are of, for the heading.
    axis
        Name of the axis for a reader.
    kinds
        The quantities of a body by name; none of a user's system.
    """
    quantity = kinds.get(axis)
    unit: Kind | str = quantity.kind if quantity else points.unit
    rate: Kind | str = Kind.GROWTH_RATE if kinds else points.rate_unit
    letter = (quantity.latex or quantity.symbol) if quantity else symbol(axis)
    form = "{:.15g}"
    every = isinstance(points, Crossings)
    bound = "proved bound" if points.evidence is Evidence.PROVED else str(points.evidence)
    sides = (
        (
            Column("below", "unstable eigenvalues below", latex="n_{<}"),
            Column("above", "unstable eigenvalues above", latex="n_{>}"),
        )
        if every
        else (
            word("verdict", "verdict on the side that is not unstable"),
            word("side", "that side"),
        )
    )
    columns = (
        Column("value", quantity.long_name if quantity else "the axis", unit, letter, form),
        Column("error", bound, unit, r"\pm", "{:.0e}", of=("value", form)),
        word("crossing", "what crosses the imaginary axis"),
        *sides,
        Column("frequency", "angular frequency there", rate, r"\omega", "{:.12g}"),
    )
    names = [c.name for c in columns[:-1]]
    rows = [dict(zip(names, row, strict=False)) for row in points.flat()[1]]
    for row, b in zip(rows, points, strict=True):
        row["frequency"] = b.frequencies or (None if every else b.frequency or None)
    heading = _heading(subject)
    if points.constant:
        heading += f": no {points.one}, {points.constant} throughout"
    return Table(
        "boundaries",
        heading,
        columns,
        rows,
        any("√" in u for u in (points.unit, points.rate_unit)),
        definition=BOUNDARIES,
        citation=points.citation,
    )
