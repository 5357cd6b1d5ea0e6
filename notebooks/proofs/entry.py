"""A statement that is no theorem: a polynomial, a known result or a shifted threshold."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any

from stability.bodies.quantities import QUANTITIES

from .proof import paragraph

_SUPER = str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹")
_NAMES = {n: QUANTITIES[n].symbol for n in ("phi_dot", "omega3")} | {"lam": "λ"}


@dataclass(frozen=True)
class Entry:
    """One statement."""

    name: str
    """Short name."""
    status: str
    """What stands behind it: derived, recomputed, published."""
    statement: tuple[str, ...]
    """Sentences or formulas."""
    assumptions: tuple[str, ...] = ()
    """Assumptions."""
    refuters: tuple[str, ...] = ()
    """Tests that try to refute it."""
    source: str = ""
    """Where a known result is from, and how much of it was at hand."""
    published: str = ""
    """What the source prints, as far as it was at hand; empty where it was not."""


def listed(entry: Entry) -> None:
    """Print a statement; one that is not recovered raises an AssertionError."""
    lines = [f"{entry.name}  [{entry.status}]"]
    lines += [f"   {line}" for text in entry.statement for line in paragraph(text)]
    for title, text in (("Source", entry.source), ("Published", entry.published)):
        lines += paragraph(f"{title}: {text}", "   ") if text else []
    for title, texts in (("Assumptions", entry.assumptions), ("Tests", entry.refuters)):
        lines += paragraph(f"{title}: {'; '.join(texts)}", "   ") if texts else []
    print("\n".join(lines))
    if "not recovered" in entry.status:
        raise AssertionError(f"not recovered: {entry.name}")


def raised(power: int) -> str:
    """A whole number as a superscript.

    Examples
    --------
    >>> raised(12)
    '¹²'
    """
    return str(power).translate(_SUPER)


def written(expression: Any) -> str:
    """An expression of SymPy in the letters of the pages.

    Examples
    --------
    >>> from proofs.body_polynomials import I1, H
    >>> written(I1 * H**2 - 1)
    'I1 h² - 1'
    """
    text = str(expression)
    text = re.sub(r"\*\*(\d+)", lambda m: m[1].translate(_SUPER), text)
    for name, letter in _NAMES.items():
        text = text.replace(name, letter)
    return text.replace("*", " ")
