"""Tables as lines of text."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from ..bodies.thin_disk.disk_families import FAMILIES
from ..derivation.branches import LIMITS
from .drift import DRIFT_NOTES
from .hopf import HOPF_NOTES
from .launches import NOTES as LAUNCH_NOTES
from .launches import contact_lines
from .registry import TABLES
from .theorems import theorem_lines

if TYPE_CHECKING:
    from ..derivation.formulas import Formulas


def text(name: str, rows: list[dict[str, Any]], unit: str) -> str:
    """A table as lines of text, below its heading from `TABLES`.

    Parameters
    ----------
    name
        A key of `TABLES`.
    rows
        From `records`.
    unit
        Unit of angular velocities.

    Returns
    -------
    str
    """
    head = [f"{TABLES[name]} (recomputed)", ""]
    if name == "families":
        return "\n".join(head + _family_lines(rows))
    if name == "completeness":
        return "\n".join(head + _completeness_lines(rows))
    if name == "benchmarks":
        from .benchmarks.catalogue import benchmark_lines

        return "\n".join(head + benchmark_lines(rows))
    if name == "theorems":
        return "\n".join(head + theorem_lines(rows))
    if name in ("drift", "hopf", "launches"):
        notes = {"drift": DRIFT_NOTES, "hopf": HOPF_NOTES, "launches": LAUNCH_NOTES}[name]
        units = f"angular velocities in {unit}; angles in rad; times in 1/({unit})"
        units = units.replace("1/(rad/s)", "s")
        if name == "launches":
            notes = (*contact_lines(rows), "", *notes)
        return "\n".join(head + _aligned(_cells(rows)) + ["", *notes, units])
    cells = _cells(rows, {"error": "± proved"})
    ranges = {n: f.searched for n, f in FAMILIES.items() if f.searched}
    foot = [
        "",
        f"at: {_names(unit)}; frequency in {unit}.",
        f"Searched: {', '.join(f'{n} {a:g}…{b:.4g}' for n, (a, b) in ranges.items())} "
        "(dimensionless), completely: every real root of the conditions over Q is isolated; each "
        "place is a bracket proved in ball arithmetic.",
    ]
    return "\n".join(head + _aligned(cells) + foot)


def _names(unit: str) -> str:
    """Quantity that names a member of each family, with its unit."""
    kinds: dict[str, list[str]] = {unit: [], "rad": []}
    for family in FAMILIES.values():
        if family.searched:
            kinds["rad" if family.by_angle else unit].append(f"{family.at[0]} ({family.name})")
    return ", ".join(f"{', '.join(words)} in {u}" for u, words in kinds.items() if words)


FORMATS = {
    "k": "{:g}", "tilt": "{:g}", "at": "{:.12g}", "error": "{:.1e}",
    "frequency": "{:.10g}", "omega3": "{:.6g}", "threshold": "{:.6g}", "tilt_end": "{:.4g}",
    "rate": "{:+.3g}", "final_at": "{:.6g}", "time": "{:.4g}", "energy": "{:.4f}",
    "normal_force": "{:.3f}", "mu": "{:g}",
    "time_slow": "{:.6g}", "time_launch": "{:.6g}", "crossing": "{:.6g}", "push": "{:.6g}",
}  # fmt: skip
"""Format of the numbers in each column."""


def _cells(rows: list[dict[str, Any]], titles: dict[str, str] | None = None) -> list[list[str]]:
    cells = [[(titles or {}).get(key, key) for key in rows[0]]]
    for row in rows:
        cells.append([
            "-" if value is None
            else value if isinstance(value, str)
            else FORMATS[key].format(value)
            for key, value in row.items()
        ])  # fmt: skip
    return cells


def formula_lines(found: Sequence[Formulas]) -> list[str]:
    """The formulas of `stability.derivation.formulas` as lines of text.

    Parameters
    ----------
    found
        One record for each family and law.

    Returns
    -------
    list of str
    """
    lines = ["stability conditions as formulas, dimensionless (recomputed)", ""]
    for one in found:
        product = "".join(f"({p})" for p in one.polynomial)
        lines += [
            f"{one.family}, {one.contact}",
            f"    det(λ - A) ~ λ^{one.structural_zeros} {product}",
        ]
        lines += [f"    decides: {c['kind']:<9} {c['positive']} > 0" for c in one.conditions]
        for b in one.boundaries:
            lines.append(f"    {b['kind']} boundary: {b['of']} = {b['formula']}")
            lines += [f"        for {b['where']}"] if "where" in b else []
        for limit, values in one.limits.items():
            lines += [f"    as {limit}, at each member: {value} > 0" for value in values]
        lines += [f"    {p['name']} {p['positive']} > 0: {p['proof']}" for p in one.proved]
        lines += [f"    * {s}" for s in one.statements] + [""]
    last = "lam = λ; where M = mu*² occurs, λ = σ mu; z = at*², s = sin(theta)."
    return [*lines, last, f"The {LIMITS}.", ""]


def _aligned(cells: list[list[str]]) -> list[str]:
    widths = [max(len(row[i]) for row in cells) for i in range(len(cells[0]))]
    lines = [
        "  ".join(c.ljust(w) for c, w in zip(row, widths, strict=True)).rstrip() for row in cells
    ]
    return [lines[0], "  ".join("-" * w for w in widths), *lines[1:]]


def _family_lines(rows: list[dict[str, Any]]) -> list[str]:
    lines = []
    for row in rows:
        zeros = ", ".join(f"{law} {count}" for law, count in row["structural_zeros"].items())
        lines += [
            f"{row['family']} (named by {row['at']}): {row['motion']}",
            f"    condition         {row['condition']}",
            f"    structural zeros  {zeros}",
        ]
        for law, values in row["thresholds"].items():
            what = "no change of verdict"
            if values:
                what = f"neutral above {row['at']}² = " + ", ".join(f"{v:.12g}" for v in values)
                what += " (k = 1/4), unstable below"
            lines.append(f"    {law:<6}            {what}")
        lines.append("")
    return [*lines, "Dimensionless: m = R = g = 1, angular velocities in √(g/R)."]


def _completeness_lines(rows: list[dict[str, Any]]) -> list[str]:
    lines = []
    for number, row in enumerate(rows[:-1], start=1):
        mark = "holds" if row["holds"] else "FAILS"
        lines += [f"{number}. {row['claim']}", f"   {row['identity']}  [{mark}]"]
    found = rows[-1]["search"]
    names = ", ".join(f"{n} {c}" for n, c in found["found"].items())
    return [
        *lines, "",
        f"Search: {found['starts']} starts in the box {found['box']};",
        f"{found['converged']} reached a root ({names});",
        f"{found['outside']} outside the three families.",
    ]  # fmt: skip
