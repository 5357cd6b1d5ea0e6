"""Tables of flutter boundaries and of points of codimension two, of any family."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, replace
from decimal import ROUND_CEILING, Decimal, localcontext
from fractions import Fraction
from typing import Any

from ..base.quantities import Kind, Quantity, rate_unit, readable
from ..boundary.hopf import CycleBirth, HopfPoint
from ..boundary.two_parameters.point_records import CodimensionTwo
from .letters import symbol
from .table import About, Column, Definition, Standing, Table, word

HOPF_HEADING = "flutter boundaries of {name}: how oscillation begins (recomputed)"
POINT_HEADING = "points of codimension two of {name} (recomputed)"
BIRTH_NOTES = (
    "crossing: d Re λ / d axis; l1: first Lyapunov coefficient for the mode of unit length over",
    "the states, whose sign alone depends on no unit; each ± is a proved bound.",
)


def to_bound(value: float, error: float) -> str:
    """A number with its proved bound: digits up to the bound, which holds for what is printed.

    Parameters
    ----------
    value, error
        The number, and a bound of its error.

    Examples
    --------
    >>> to_bound(24.535893446115182, 3.5e-6), to_bound(24.535893446115182, 3.5e-18)
    ('24.5358934 ± 3.6e-06', '24.535893446115182 ± 1.5e-16')
    """
    if not math.isfinite(error + value):
        return f"{value:.12g} ± {error:.1e}"
    small = 0 < error < abs(value)
    digits = min(math.ceil(math.log10(abs(value)) - math.log10(error)) + 2, 17) if small else 17
    said = f"{value:.{digits}g}"
    off = Fraction(error) + abs(Fraction(said) - Fraction(value))
    if not off:
        return f"{said} ± {0:.1e}"
    with localcontext(rounding=ROUND_CEILING):  # a bound is rounded up
        bound = f"{Decimal(math.nextafter(float(off), math.inf)):.1e}"
    return f"{said} ± {float(bound):.1e}"


def birth_records(
    found: Sequence[CycleBirth | HopfPoint],
) -> list[dict[str, Any]]:
    """Flutter boundaries as plain records, for JSON.

    Parameters
    ----------
    found
        From `stability.hopf`.

    Returns
    -------
    list of dict
    """
    out, aside = [], ("mode", "unit", "citation")
    for point in found:
        row: dict[str, Any] = {k: v for k, v in vars(point).items() if k not in aside}
        row["kind"] = point.kind.word
        out.append({k: None if v != v else v for k, v in row.items()})  # NaN is no JSON
    return out


def birth_text(
    heading: str, axis: str, found: Sequence[CycleBirth | HopfPoint], units: Mapping[str, str]
) -> str:
    """Flutter boundaries as lines of text.

    Parameters
    ----------
    heading
        First line.
    axis
        Name of the axis.
    found
        From `stability.hopf`.
    units
        Unit by name.

    Returns
    -------
    str
    """
    unit = f" [{readable(units[axis])}]" if axis in units else ""
    lines = [heading, ""]
    for point in found:
        side = "above" if point.stable_below else "below"
        lines.append(f"{axis} = {point.at:.15g}{unit}: {point.kind.word}, unstable {side}")
        if isinstance(point, CycleBirth):
            lines.append(f"    frequency {to_bound(point.frequency, point.frequency_error)}")
            lines.append(f"    crossing {to_bound(point.crossing, point.crossing_error)}")
            lines.append(f"    l1 {to_bound(point.coefficient, point.coefficient_error)}")
            lines += [f"    {point.reason}"] if point.reason else []
        else:
            lines.append(f"    frequency {point.frequency:.12g}")
            lines.append(f"    crossing {point.crossing:.12g}, push {point.push:.12g}")
    if not found:
        lines.append("none")
    return "\n".join([*lines, "", *BIRTH_NOTES])


def point_records(found: CodimensionTwo) -> dict[str, Any]:
    """Points of codimension two as a plain record, for JSON.

    Parameters
    ----------
    found
        From `stability.codimension_two`.

    Returns
    -------
    dict
    """
    return {
        "axes": [list(axis) for axis in found.axes],
        "rows": [asdict(p) | {"kind": p.kind.word} for p in found],
        "complete": found.complete,
        "unresolved": [b._asdict() | {"kind": b.kind.word} for b in found.unresolved],
        "how": found.how,
        "vanishing": found.vanishing,
        "vanishing_complete": found.vanishing_complete,
    }


def point_text(name: str, found: CodimensionTwo) -> str:
    """Points of codimension two as lines of text.

    Parameters
    ----------
    name
        Name of the family.
    found
        From `stability.codimension_two`.

    Returns
    -------
    str
    """
    (x, *_), (y, *_) = found.axes
    lines = [POINT_HEADING.format(name=name), ""]
    for p in found:
        pairs = ", ".join(f"{w:.10g}" for w in p.frequencies)
        lines.append(
            f"{p.kind.word}: {x} = {to_bound(p.x, p.x_error)}, {y} = {to_bound(p.y, p.y_error)}"
        )
        said = [f"frequency {pairs}"] if pairs else []
        lines.append(f"    {'; '.join([*said, f'other eigenvalues: {p.others}'])}")
    if not found:
        lines.append("none")
    return "\n".join([*lines, "", f"{found.statement}."])


# --- for the registry ---


def _birth_text(table: Table) -> str:
    return birth_text(table.heading, *table.found)


def _point_text(table: Table) -> str:
    return point_text(table.heading.split(" of ")[-1].removesuffix(" (recomputed)"), table.found)


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
    text=_point_text,
    about=About(
        "this package: points of codimension two of any family",
        "no value; tests compare them with normal forms",
        "points and their kinds from the family's equations",
        Standing.DERIVED,
    ),
    home=f"{__name__}:POINTS",
)
"""Points of codimension two."""


def birth_columns(
    axis: str, units: Mapping[str, str], rows: Sequence[Mapping[str, Any]]
) -> tuple[Column, ...]:
    """Columns of flutter boundaries of a family, without those that no row has.

    Parameters
    ----------
    axis
        Name of the axis.
    units
        Unit by name.
    rows
        From `birth_records`.

    Returns
    -------
    tuple of Column
    """
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


def point_columns(
    axes: Sequence[str], units: Mapping[str, str], known: Mapping[str, Quantity] | None = None
) -> tuple[Column, ...]:
    """Columns of points of codimension two, each with the name and unit of its axis.

    Parameters
    ----------
    axes
        Names of both axes, as a reader knows them.
    units
        Unit by name, for a system of the user's own.
    known
        Quantities of the disk by name.

    Returns
    -------
    tuple of Column
    """
    known, named, out = known or {}, dict(zip("xy", axes, strict=True)), []
    for c in POINTS.columns:
        axis = named.get(c.name[0], "") if c.name[0] in named else ""
        if not axis:
            rate: Any = Kind.GROWTH_RATE if known else rate_unit(units)
            out.append(replace(c, kind=rate) if c.name == "frequencies" else c)
            continue
        quantity = known.get(axis)
        kind: Any = quantity.kind if quantity else units.get(axis, "1")
        letter = (quantity.latex or quantity.symbol) if quantity else symbol(axis)
        bound = c.name not in named
        words = quantity.long_name if quantity else axis
        out.append(
            replace(
                c,
                kind=kind,
                title=f"{axis} error" if bound else axis,
                latex=c.latex if bound else letter,
                meaning=f"bound on the error of {axis}" if bound else words,
            )
        )
    return tuple(out)
