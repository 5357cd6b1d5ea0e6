"""How results print: numbers with their bounds, and tables of HTML for notebooks."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from decimal import ROUND_CEILING, Decimal, localcontext
from fractions import Fraction
from html import escape
from typing import Any

import numpy as np

from .quantities import readable


def html_table(
    head: str,
    columns: Sequence[str],
    rows: Iterable[Sequence[str]],
    foot: str = "",
    *,
    name: str = "",
) -> str:
    """A table of a notebook, with a line above and below; every text is plain.

    Parameters
    ----------
    head, foot
        The lines; an empty one is left out.
    columns
        Names of the columns; without any there is no table.
    rows
        Cells.
    name
        What stands before the head, in bold.

    Examples
    --------
    >>> html_table("two", ["a"], [["<1"]])
    '<div>two</div><table><thead><tr><th>a</th></tr></thead><tbody><tr><td>&lt;1</td></tr></tbody>\
</table>'
    """
    top = "".join(f"<th>{escape(name)}</th>" for name in columns)
    body = "".join("<tr>" + "".join(f"<td>{escape(c)}</td>" for c in row) + "</tr>" for row in rows)
    bold = f"<b>{escape(name)}</b>" if name else ""
    above = f"<div>{bold}{escape(head)}</div>" if head or name else ""
    below = f"<div><i>{escape(foot)}</i></div>" if foot else ""
    table = f"<table><thead><tr>{top}</tr></thead><tbody>{body}</tbody></table>" if top else ""
    return f"{above}{table}{below}"


def in_brackets(unit: str) -> str:
    """A unit as it stands behind a name; nothing for a number without one.

    Examples
    --------
    >>> in_brackets("m/s2"), in_brackets("1")
    (' [m/s²]', '')
    """
    return "" if unit in ("", "1") else f" [{readable(unit)}]"


def in_short(value: Any) -> str:
    """A number, or the ends of an array.

    Examples
    --------
    >>> in_short(0.25), in_short([1.0, 2.0])
    ('0.25', '1 to 2 (2 values)')
    """
    values = np.asarray(value)
    if not values.ndim:
        return f"{float(values):.6g}"
    return f"{values.min():.6g} to {values.max():.6g} ({values.size} values)"


def two_digits(value: float, units: Sequence[tuple[str, float]]) -> str:
    """A number to two digits, in the first of some units that it reaches, or in the last.

    Examples
    --------
    >>> units = [("h", 3600.0), ("s", 1.0)]
    >>> two_digits(9000.0, units), two_digits(0.2, units)
    ('2.5 h', '0.2 s')
    """
    unit, size = next((entry for entry in units if value >= entry[1]), units[-1])
    return f"{float(f'{value / size:.2g}'):g} {unit}"


def to_bound(value: float, error: float) -> str:
    """A number with its proved bound: digits up to the bound, which holds for what is printed.

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
