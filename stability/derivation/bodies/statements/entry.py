"""One row of the table of statements about bodies, and its letters."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any

from ....bodies.thin_disk.disk_quantities import QUANTITIES
from ...proof import Step

PARTS = ("theorem", "polynomial", "known result", "rounded rim", "Painlevé limit")
"""Parts of the table."""
_SUPER = str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹")
_NAMES = {n: QUANTITIES[n].symbol for n in ("phi_dot", "omega3")} | {"lam": "λ"}


@dataclass(frozen=True)
class Entry:
    """One statement."""

    part: str
    """One of `PARTS`."""
    name: str
    """Short name."""
    status: str
    """What stands behind it: proved, derived, recomputed, published, enclosed."""
    statement: tuple[str, ...]
    """Sentences or formulas."""
    limit: float | None = None
    """Painlevé's limit of mu |vx|, the proved lower end."""
    assumptions: tuple[str, ...] = ()
    """Assumptions."""
    steps: tuple[Step, ...] = ()
    """Steps of a proof as checked."""
    refuters: tuple[str, ...] = ()
    """Tests that try to refute it."""
    source: str = ""
    """Where a known result is from, and how much of it was at hand."""
    published: str = ""
    """What the source prints, as far as it was at hand; empty where it was not."""


def raised(power: int) -> str:
    """A whole number as a superscript.

    Parameters
    ----------
    power
        The number.

    Examples
    --------
    >>> raised(12)
    '¹²'
    """
    return str(power).translate(_SUPER)


def written(expression: Any) -> str:
    """An expression of SymPy in the letters of the table.

    Parameters
    ----------
    expression
        The expression.

    Examples
    --------
    >>> from stability.derivation.bodies.graph import I1, H
    >>> written(I1 * H**2 - 1)
    'I1 h² - 1'
    """
    text = str(expression)
    text = re.sub(r"\*\*(\d+)", lambda m: m[1].translate(_SUPER), text)
    for name, letter in _NAMES.items():
        text = text.replace(name, letter)
    return text.replace("*", " ")
