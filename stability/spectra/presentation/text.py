"""A spectrum in one line, and as a table of HTML."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from html import escape
from typing import Any

import numpy as np

from ...base.errors import StabilityError
from ...base.quantities import Kind, Quantity
from ...base.types import Complexes

MOST = 8
"""Most eigenvalues in one line; those that decay fastest are left out."""
LONGEST = 60
"""Most rows of a table."""


def numbers(values: Complexes) -> list[str]:
    """Sorted eigenvalues as texts, a pair as one with ±.

    Examples
    --------
    >>> numbers(np.array([-2, -0.5 - 3j, -0.5 + 3j]))
    ['-2', '-0.5 ± 3i']
    """
    said, left = [], list(values)
    while left:
        one = left.pop(0)
        real, imag = f"{one.real + 0.0:.6g}", f"{abs(one.imag):.6g}i"
        if one.imag and left and left[0] == one.conjugate():
            left.pop(0)
            said.append(f"{real} ± {imag}")
        else:
            said.append(real + (f" {'+' if one.imag > 0 else '-'} {imag}" if one.imag else ""))
    return said


def counted(spectrum: Any) -> str:
    """How many points have which verdict."""
    words = Counter(verdict.word for verdict in spectrum.verdict.flat)
    return ", ".join(f"{count} {word}" for word, count in words.most_common())


def member(spectrum: Any) -> str:
    """Family parameters of a single spectrum by name."""
    given = zip(spectrum.family.at, np.asarray(spectrum.at), strict=True)
    return ", ".join(f"{n} = {v:.6g}" for n, v in given)


def of_body(spectrum: Any) -> str:
    """Every number of a spectrum of a body that is no array, with symbol and unit."""
    system = spectrum.family.system
    values = {spectrum.family.meaning(n): v for n, v in spectrum.values.items()}
    single = {n: float(v) for n, v in values.items() if np.ndim(v) == 0}
    single = {n: single[n] for n in (*spectrum.family.at, *single) if n in single}
    known = {n: Quantity(n, "", n, Kind.NUMBER) for n in single} | dict(system.quantities)
    return ", ".join(
        known[n].value(v, dimensionless=spectrum.dimensionless) for n, v in single.items()
    )


def line(spectrum: Any) -> str:
    """The verdict and the eigenvalues of a spectrum, or the verdicts of its points, in one line.

    Parameters
    ----------
    spectrum
        The `Spectrum`.
    """
    shape, count = spectrum.eigenvalues.shape[:-1], spectrum.eigenvalues.shape[-1]
    unit = f" [{spectrum.rate_unit}]" if spectrum.rate_unit != "1" else ""
    number = f"{count} eigenvalue{'s' * (count != 1)}"
    if not shape:
        said = numbers(spectrum.eigenvalues)
        verdict = ": ".join(filter(None, [spectrum.verdict.word, spectrum.growth()]))
        more = "…, " * (len(said) > MOST)
        told = f"{number}{unit}: {more}{', '.join(said[-MOST:])}" if said else number
        there = f" at {where}" if (where := member(spectrum)) else ""
        return f"<Spectrum of {spectrum.family.name}{there}: {verdict}; {told}>"
    what = f"{' x '.join(map(str, shape))} points"
    rates = ""
    if spectrum.codes.size and count:
        low, high = np.min(spectrum.abscissa), np.max(spectrum.abscissa)
        rates = f"; {number} each, the largest real part from {low:.4g} to {high:.4g}{unit}"
    return f"<Spectrum of {spectrum.family.name}, {what}: {counted(spectrum)}{rates}>"


def page(spectrum: Any) -> str:
    """A table for a notebook: eigenvalues with error and mode, or a row for each point.

    Parameters
    ----------
    spectrum
        The `Spectrum`.
    """
    family, unit = spectrum.family, spectrum.rate_unit
    units = f" [{escape(unit)}]" if unit != "1" else ""
    title = f"<b>{escape(family.name)}</b> of {escape(family.system.name)}"
    names = list(family.at)
    where = "" if spectrum.codes.ndim else member(spectrum)
    if family.system.quantities:
        names, where = [family.system.quantities[n].symbol for n in names], of_body(spectrum)
        title += " contact"
    if not spectrum.codes.ndim:
        head = f"{title}, {escape(where)}: {escape(spectrum.verdict.value)}"
        head += f"; {escape(spectrum.growth())}" * bool(spectrum.growth())
        rows = zip(spectrum.eigenvalues, spectrum.radius, _labels(spectrum), strict=True)
        cells = [
            (f"{v.real + 0.0:+.6g}", f"{v.imag + 0.0:+.6g}", f"{r:.1g}", m) for v, r, m in rows
        ]
        columns = [f"Re λ{units}", f"Im λ{units}", "error", "mode"]
        return _table(head, columns, cells, f"<i>{escape(spectrum.reason)}</i>")
    fixed = f", {escape(where)}" * bool(where)
    head = f"{title}{fixed}: {counted(spectrum)}"
    shape = spectrum.codes.shape
    picked = list(np.ndindex(shape))[:LONGEST]
    cells = [
        (
            *(f"{v:.6g}" for v in spectrum.at[i]),
            spectrum.verdict[i].word,
            f"{spectrum.abscissa[i]:+.6g}",
            f"{spectrum.abscissa_error[i]:.1g}",
        )
        for i in picked
    ]
    columns = [*map(escape, names), "verdict", f"largest Re λ{units}", "error"]
    left = spectrum.codes.size - len(picked)
    return _table(head, columns, cells, f"and {left} more points" if left else "")


def _labels(spectrum: Any) -> list[str]:
    try:
        return list(spectrum.modes.labels)
    except StabilityError:  # a reader still gets the eigenvalues
        return [""] * spectrum.eigenvalues.shape[-1]


def _table(head: str, names: list[str], rows: Sequence[tuple[str, ...]], foot: str) -> str:
    top = "".join(f"<th>{n}</th>" for n in names)
    body = "".join("<tr>" + "".join(f"<td>{escape(c)}</td>" for c in row) + "</tr>" for row in rows)
    below = f"<div>{foot}</div>" if foot else ""
    return (
        f"<div>{head}</div><table><thead><tr>{top}</tr></thead><tbody>{body}</tbody></table>{below}"
    )
