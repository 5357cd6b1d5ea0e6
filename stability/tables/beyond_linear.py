"""Tables of flutter boundaries and of points of codimension two, of any family."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, replace
from typing import Any

from ..base.citation import gathered, joined
from ..base.printing import to_bound
from ..base.quantities import Kind, Quantity, rate_unit, readable
from ..boundary.hopf import CycleBirth, hopf
from ..boundary.two_parameters.point_records import CodimensionTwo, DegeneratePoint
from ..boundary.two_parameters.points import MOST_LINES, in_plane
from ..derivation.latex import symbol
from ..spectra.axes import swept
from ..systems.family import Family
from .table import About, Column, Definition, Standing, Table, framed, word

HOPF_HEADING = "flutter boundaries of {name}: how oscillation begins (recomputed)"
POINT_HEADING = "points of codimension two of {name} (recomputed)"
BIRTH_NOTES = (
    "crossing: d Re λ / d axis; l1: first Lyapunov coefficient for the mode of unit length over",
    "the states, whose sign alone depends on no unit; each ± is a proved bound.",
)


def birth_table(family: Family, axis: tuple[Any, ...], **parameters: Any) -> Table:
    """The table of the flutter boundaries of a family along an axis."""
    with gathered() as works:
        births = hopf(family, axis=axis, **parameters)
    units, aside = family.system.units, ("mode", "unit", "units", "citation")
    rows = []
    for point in births:
        row = {k: v for k, v in vars(point).items() if k not in aside} | {"kind": point.kind.word}
        rows.append({k: None if v != v else v for k, v in row.items()})  # NaN is no JSON
    return Table(
        "hopf",
        BIRTHS.heading.format(name=family.name),
        _birth_columns(axis[0], units, rows),
        rows,
        definition=BIRTHS,
        found=(axis[0], births, units),
        citation=joined(works),
    )


def _birth_text(table: Table) -> str:
    axis, births, units = table.found
    unit = f" [{readable(units[axis])}]" if axis in units else ""
    lines = []
    for point in births:
        side = "above" if point.stable_below else "below"
        grows = "unstable"
        if isinstance(point, CycleBirth) and point.unstable:
            grows = "the pair grows"
        lines.append(f"{axis} = {point.at:.15g}{unit}: {point.kind.word}, {grows} {side}")
        if isinstance(point, CycleBirth):
            lines.append(f"    frequency {to_bound(point.frequency, point.frequency_error)}")
            lines.append(f"    crossing {to_bound(point.crossing, point.crossing_error)}")
            lines.append(f"    l1 {to_bound(point.coefficient, point.coefficient_error)}")
            lines += [f"    {point.reason}"] if point.reason else []
        else:
            lines.append(f"    frequency {point.frequency:.12g}")
            lines.append(f"    crossing {point.crossing:.12g}, push {point.push:.12g}")
    return framed(table, lines or ["none"])


def point_table(
    family: Family | str, x: tuple[Any, ...], y: tuple[Any, ...], **options: Any
) -> Table:
    """The table of the points of codimension two of a family in a plane of two numbers."""
    numbers, axes = dict(options), {"x": x, "y": y}
    disk, contact, at = (numbers.pop(name, None) for name in ("disk", "contact", "at"))
    problem, grids = swept(family, axes, disk, None, contact, at, numbers, most=MOST_LINES)
    points = in_plane(problem, grids)  # type: ignore[arg-type]  # two axes
    points.warn()
    system, more = problem.family.system, point_records(points)
    names = [problem.family.meaning(axis.name) for axis in grids]
    return Table(
        "codimension",
        POINTS.heading.format(name=problem.family.name),
        _point_columns(names, system.units, system.quantities),
        more.pop("rows"),
        problem.dimensionless,
        more=more,
        definition=POINTS,
        found=points,
        citation=points.citation,
    )


def point_records(points: CodimensionTwo) -> dict[str, Any]:
    """Points of codimension two as a plain record, for JSON."""
    return {
        "axes": [list(axis) for axis in points.axes],
        "rows": [_row(p) for p in points],
        "members": [dict(p.member) for p in points],
        "complete": points.complete,
        "unresolved": [b._asdict() | {"kind": b.kind.word} for b in points.unresolved],
        "how": points.how,
        "vanishing": points.vanishing,
        "vanishing_complete": points.vanishing_complete,
    }


def _row(point: DegeneratePoint) -> dict[str, Any]:
    row = asdict(point) | {"kind": point.kind.word}
    del row["member"]  # the unknowns of a family, whose names are no columns
    return row


def point_text(name: str, points: CodimensionTwo) -> str:
    """Points of codimension two as lines of text."""
    lines = point_lines(points)
    return "\n".join([POINT_HEADING.format(name=name), "", *lines, "", f"{points.statement}."])


def point_lines(points: CodimensionTwo) -> list[str]:
    """Two lines of text for each point of codimension two."""
    (x, *_), (y, *_) = points.axes
    lines = []
    for p in points:
        pairs = ", ".join(f"{w:.10g}" for w in p.frequencies)
        lines.append(
            f"{p.kind.word}: {x} = {to_bound(p.x, p.x_error)}, {y} = {to_bound(p.y, p.y_error)}"
        )
        said = [f"frequency {pairs}"] if pairs else []
        lines.append(f"    {'; '.join([*said, f'other eigenvalues: {p.others}'])}")
    return lines or ["none"]


# --- for the registry ---


def _bound(name: str, of: str, form: str) -> Column:
    return Column(name, "bound on its error", latex=r"\pm", form="{:.0e}", of=(of, form))


BIRTHS = Definition(
    HOPF_HEADING,
    (
        Column("at", "quantity of the axis at the boundary", form="{:.8g}"),
        _bound("error", "at", "{:.8g}"),
        word("kind", "how oscillation begins", share=0.13),
        Column("stable_below", "whether it is stable below the boundary", share=0.08),
        Column("frequency", "frequency of the crossing pair", latex=r"\omega", form="{:.6g}"),
        _bound("frequency_error", "frequency", "{:.6g}"),
        Column("crossing", "d Re λ by the axis", latex="c", form="{:.6g}"),
        _bound("crossing_error", "crossing", "{:.6g}"),
        Column("coefficient", "first Lyapunov coefficient", latex="l_{1}", form="{:.6g}"),
        _bound("coefficient_error", "coefficient", "{:.6g}"),
        Column("push", "coefficient of the drift along a line", latex="p"),
        Column("unstable", "other eigenvalues that are unstable", latex="n"),
        word("reason", "reason for an open kind", "below"),
    ),
    lambda **_: [],
    notes=lambda _: BIRTH_NOTES,
    text=_birth_text,
    home=f"{__name__}:BIRTHS",
)
"""Flutter boundaries of a family of the user's own."""
POINTS = Definition(
    POINT_HEADING,
    (
        word("kind", "kind of the point", share=0.2),
        Column("x", "quantity of the first axis", form="{:.12g}"),
        _bound("x_error", "x", "{:.12g}"),
        Column("y", "quantity of the second axis", form="{:.12g}"),
        _bound("y_error", "y", "{:.12g}"),
        Column("frequencies", "frequencies on the axis", form="{:.10g}"),
        word("others", "real parts of the other eigenvalues", "below"),
    ),
    lambda **_: [],
    notes=lambda table: [f"{table.found.statement}."],
    text=lambda table: framed(table, point_lines(table.found)),
    about=About(
        "this package: points of codimension two of any family",
        "no value; tests compare them with normal forms",
        "points and their kinds from the family's equations",
        Standing.DERIVED,
    ),
    home=f"{__name__}:POINTS",
)
"""Points of codimension two."""


def _birth_columns(
    axis: str, units: Mapping[str, str], rows: Sequence[Mapping[str, Any]]
) -> tuple[Column, ...]:
    """Columns of flutter boundaries of a family, without those that no row has."""
    there = {name for row in rows for name in row} or {c.name for c in BIRTHS.columns}
    unit, rate = units.get(axis, "1"), rate_unit(units)
    kinds = {"at": unit, "error": unit, "frequency": rate, "frequency_error": rate}
    return tuple(
        replace(
            c, kind=kinds.get(c.name, c.kind), latex=symbol(axis) if c.name == "at" else c.latex
        )
        for c in BIRTHS.columns
        if c.name in there
    )


def _point_columns(
    axes: Sequence[str], units: Mapping[str, str], quantities: Mapping[str, Quantity]
) -> tuple[Column, ...]:
    """Columns of points of codimension two, each with the name and unit of its axis.

    A system of the user's own has units by name, a body quantities by name.
    """
    rate: Any = Kind.GROWTH_RATE if quantities else rate_unit(units)
    columns = {c.name: c for c in POINTS.columns}
    columns["frequencies"] = replace(columns["frequencies"], kind=rate)
    for place, axis in zip("xy", axes, strict=True):
        quantity = quantities.get(axis)
        kind: Any = quantity.kind if quantity else units.get(axis, "1")
        letter = (quantity.latex or quantity.symbol) if quantity else symbol(axis)
        columns[place] = replace(
            columns[place],
            kind=kind,
            title=axis,
            latex=letter,
            meaning=quantity.long_name if quantity else axis,
        )
        columns[f"{place}_error"] = replace(
            columns[f"{place}_error"],
            kind=kind,
            title=f"{axis} error",
            meaning=f"bound on the error of {axis}",
        )
    return tuple(columns.values())
