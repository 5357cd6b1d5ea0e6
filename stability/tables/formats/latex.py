"""Tables as LaTeX: booktabs rules, symbols defined, lines that break."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from decimal import ROUND_CEILING, Decimal, localcontext
from fractions import Fraction
from typing import Any

from .column import Column, Content
from .letters import escaped, number, prose, unit
from .plain import units_note

NEEDS = "% needs amsmath, array, booktabs and longtable; run LaTeX twice"
"""Comment at the start of a table."""
SHORT = 60
"""Most characters of a heading of rows in one line."""


def latex(table: Content) -> str:
    """A table as LaTeX: a longtable as wide as the line, then its symbols and notes.

    Parameters
    ----------
    table
        The table.

    Returns
    -------
    str
    """
    rows = [line for block in _blocks(table) for line in block]
    cells = [c for c in table.columns if c.place == "cell"]
    notes = [line for line in table.notes if line != units_note(table)]  # the header has the units
    body = longtable(
        table.heading,
        [spec(c, table) for c in cells],
        [_head(c) for c in cells],
        rows,
        [_unit(c, table) for c in cells],
        label=table.name,
    )
    return "\n".join([start(table.name), *body, *symbols(table), *paragraphs(notes), END])


END = r"\par\endgroup"
"""Last line of a table."""


def start(name: str) -> str:
    """First lines of a table: where it is from, and its size of letters."""
    return "\n".join(
        [
            f"% stability table {name}: recomputed",
            NEEDS,
            r"\begingroup\footnotesize\setlength{\tabcolsep}{2pt}\setlength{\parindent}{0pt}"
            r"\raggedright",
            r"\setlength{\LTleft}{0pt}\setlength{\LTright}{0pt}",
        ]
    )


def longtable(
    caption: str,
    specs: Sequence[str],
    head: Sequence[str],
    rows: Sequence[str],
    units: Sequence[str] = (),
    *,
    label: str,
) -> list[str]:
    r"""Lines of a longtable with booktabs rules.

    Parameters
    ----------
    caption
        Caption as plain text.
    specs
        Alignment of each column.
    head, units
        Header and units in LaTeX.
    rows
        Lines in LaTeX, each with its end.
    label
        What follows `tab:` in the label.

    Returns
    -------
    list of str

    Examples
    --------
    >>> print(longtable("two", ["l", "r"], ["a", "b"], [r"1 & 2 \\"], label="two")[1])
    \caption{Two.}\label{tab:two}\\
    """
    titles = [" & ".join(head) + r" \\"]
    titles += [" & ".join(units) + r" \\"] if any(units) else []
    return [
        rf"\begin{{longtable}}{{@{{\extracolsep{{\fill}}}}{''.join(specs)}@{{}}}}",
        rf"\caption{{{prose(caption[:1].upper() + caption[1:])}.}}\label{{tab:{label}}}\\",
        r"\toprule",
        *titles,
        r"\midrule",
        r"\endfirsthead",
        r"\toprule",
        *titles,
        r"\midrule",
        r"\endhead",
        r"\bottomrule",
        r"\endfoot",
        *rows,
        r"\end{longtable}",
    ]


def breaking(share: float) -> str:
    """Alignment of a column of texts that break, as a share of the line."""
    return rf">{{\raggedright\arraybackslash}}p{{{share:g}\linewidth}}"


def across(columns: int, text: str, indent: str = "") -> str:
    """A line across all columns."""
    box = rf"\parbox[t]{{\linewidth}}{{\raggedright {indent}{text}\strut}}"  # stretches no column
    return rf"\multicolumn{{{columns}}}{{@{{}}l@{{}}}}{{\makebox[0pt][l]{{{box}}}}} \\"


def spec(column: Column, table: Content) -> str:
    """Alignment of a column."""
    if column.share:
        return breaking(column.share)
    values = [row[column.name] for row in table.rows]
    return "r" if any(isinstance(v, (int, float)) for v in values) else "l"


def _head(column: Column) -> str:
    return f"${column.latex}$" if column.latex else escaped(column.name.replace("_", " "))


def _unit(column: Column, table: Content) -> str:
    text = column.unit(dimensionless=table.dimensionless)
    if not text or column.latex == r"\pm":  # an error has the unit of the column before it
        return ""
    plain = table.dimensionless and not isinstance(column.kind, str)
    return f"{{[{unit(text, dimensionless=plain)}]}}"  # a bare [ would belong to the line before


def _blocks(table: Content) -> list[list[str]]:
    """Lines of each row, with those of a heading where it changes."""
    groups = [c for c in table.columns if c.place == "group"]
    cells = [c for c in table.columns if c.place == "cell"]
    below = [c for c in table.columns if c.place == "below"]
    out: list[list[str]] = []
    last = None
    for row in table.rows:
        block = []
        title = "; ".join(_titled(c, row) for c in groups if row[c.name] not in (None, ""))
        if out and not groups and any(c.share for c in cells):
            block.append(r"\addlinespace")
        if title != last and groups:
            block += [r"\addlinespace"] if out else []
            line = rf"\multicolumn{{{len(cells)}}}{{@{{}}l@{{}}}}{{\textit{{{title}}}}} \\*"
            block.append(line if len(title) < SHORT else across(len(cells), rf"\textit{{{title}}}"))
            last = title
        block.append(" & ".join(cell(c, row) for c in cells) + r" \\" + "*" * bool(below))
        said = [_said(c, row) for c in below if row[c.name] not in (None, "")]
        block += [across(len(cells), "; ".join(said), r"\quad ")] if said else []
        out.append(block)
    return out


def _titled(column: Column, row: Mapping[str, Any]) -> str:
    text = column.written(row[column.name])
    return f"${column.latex}={number(text).strip('$')}$" if column.latex else prose(text)


def _said(column: Column, row: Mapping[str, Any]) -> str:
    text = prose(column.written(row[column.name]))
    return text if column.name in ("why", "status", "origin") else f"{column.name}: {text}"


def cell(column: Column, row: Mapping[str, Any]) -> str:
    """A value in LaTeX.

    Parameters
    ----------
    column, row
        Column and row.

    Returns
    -------
    str
    """
    value = row[column.name]
    if column.of and isinstance(value, float) and math.isfinite(value):
        value = _as_printed(value, row[column.of[0]], column.of[1])
    text = column.written(value)
    return prose(text) if column.share else number(text)


def _as_printed(bound: float, value: float, form: str) -> float:
    """A bound that holds for the printed digits of its number, rounded up to two digits."""
    off = abs(Fraction(form.format(value)) - Fraction(value))
    whole = max(Fraction(bound) + off, Fraction(math.ulp(value)))
    with localcontext(rounding=ROUND_CEILING):
        return float(f"{Decimal(math.nextafter(float(whole), math.inf)):.0e}")


def symbols(table: Content) -> list[str]:
    """A paragraph that defines the symbols of a table, and its other columns.

    Parameters
    ----------
    table
        The table.

    Returns
    -------
    list of str
    """
    said = []
    for column in table.columns:
        named = []
        for word, quantity in column.quantities(table.rows).items():
            label = quantity.kind.label(dimensionless=table.dimensionless)
            words = unit(label, dimensionless=table.dimensionless)
            named.append(f"{prose(word)}: ${quantity.latex or quantity.symbol}$ in {words}")
        units = f" ({', '.join(named)})" if named else ""
        said.append(f"{_head(column)}: {prose(column.meaning)}{units}")
    return [r"\noindent " + "; ".join(said) + "."]


def paragraphs(lines: Sequence[str]) -> list[str]:
    r"""Notes in LaTeX: lines of one paragraph joined, an indented line alone.

    Parameters
    ----------
    lines
        Notes as in the text.

    Returns
    -------
    list of str

    Examples
    --------
    >>> paragraphs(["one", "two", "  alone"])
    ['', 'one two', '', '\\quad alone']
    """
    out: list[str] = []
    whole: list[str] = []
    for line in (*lines, ""):
        if whole and (not line or line.startswith(" ")):
            out += ["", prose(" ".join(whole))]
            whole = []
        if line.startswith(" "):
            out += ["", rf"\quad {prose(line)}"]
        elif line:
            whole.append(line)
    return out
