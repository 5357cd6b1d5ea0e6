"""Tables of flutter boundaries and of points of codimension two, of any family."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from decimal import ROUND_CEILING, Decimal, localcontext
from fractions import Fraction
from typing import Any

from ..boundary.beyond_linear.records import CycleBirth, HopfPoint
from ..boundary.beyond_linear.two_parameters.point_records import CodimensionTwo
from ..storage.json_text import json_text

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
    small = 0 < error < abs(value)
    digits = min(math.ceil(math.log10(abs(value) / error)) + 2, 17) if small else 17
    said = f"{value:.{digits}g}"
    off = Fraction(error) + abs(Fraction(said) - Fraction(value))
    if not off:
        return said
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
    out = []
    for point in found:
        row: dict[str, Any] = {k: v for k, v in vars(point).items() if k not in ("mode", "unit")}
        row["kind"] = point.kind.word
        out.append({k: None if v != v else v for k, v in row.items()})  # NaN is no JSON
    return out


def birth_text(
    name: str, axis: str, found: Sequence[CycleBirth | HopfPoint], units: Mapping[str, str]
) -> str:
    """Flutter boundaries as lines of text.

    Parameters
    ----------
    name
        Name of the family.
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
    unit = f" [{units[axis]}]" if axis in units else ""
    lines = [HOPF_HEADING.format(name=name), ""]
    for point in found:
        side = "below" if point.stable_below else "above"
        lines.append(f"{axis} = {point.at:.15g}{unit}: {point.kind.word}, stable {side}")
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


def birth_json(name: str, found: Sequence[CycleBirth | HopfPoint]) -> str:
    """Flutter boundaries as JSON."""
    heading = HOPF_HEADING.format(name=name)
    return json_text({"table": "hopf", "heading": heading, "rows": birth_records(found)})


def point_json(name: str, found: CodimensionTwo) -> str:
    """Points of codimension two as JSON."""
    heading = POINT_HEADING.format(name=name)
    return json_text({"table": "codimension", "heading": heading, **point_records(found)})
