"""Members whose unknowns are solved for: what the page and its shader need to find them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from ...algebra.linear_systems import solution
from ...algebra.number_types import Algebra
from ...base.errors import StabilityError
from ...systems.family import Family
from .source_text import graph

MOST = 4
"""Largest number of unknowns: a texture of the shader has four channels."""
STEPS = 3
"""Steps of Newton's method in the shader, from the members of a grid."""
CLOSE = 1e-3
"""Largest last step in the shader, over 1 plus the unknown; elsewhere no member is drawn."""


@dataclass(frozen=True)
class Solver:
    """The equations of a family's unknowns, and where a search for them starts."""

    family: Family
    """A family with a root-finder."""

    @property
    def unknown(self) -> tuple[str, ...]:
        """States that are solved for."""
        return tuple(self.family.unknown)

    def told(self) -> dict[str, Any]:
        """The record in the page."""
        family, names = self.family, self.unknown
        known = family.anchor
        return {
            "names": names,
            "equations": graph(family.graph.along),
            "cut": len(family.at),
            "guess": list(family.unknown.values()),
            "positive": [i for i, name in enumerate(names) if name in family.positive],
            "anchor": {"given": known.given.tolist(), "unknown": list(known.unknown)}
            if known
            else None,
        }

    def polished(self, algebra: Algebra, q: Sequence[Any]) -> tuple[list[Any], list[Any]]:
        """Quantities with unknowns, by Newton's method from a guess, and what is positive there."""
        family, count = self.family, len(q) - len(self.unknown)
        cut, program, size = len(family.at), family.graph.along, algebra.functions["fabs"]
        given, u = list(q[:count]), list(q[count:])
        trust: list[Any] = []
        for _ in range(STEPS):
            at = [given[:cut], u, given[cut:]]
            r, slope = (program.dense(algebra, at, i) for i in (0, 1))
            step = [row[0] for row in solution(algebra, slope, r)]
            u = [a - b for a, b in zip(u, step, strict=True)]
            trust = [CLOSE * (1.0 + size(a)) - size(b) for a, b in zip(u, step, strict=True)]
        trust += [a for a, name in zip(u, self.unknown, strict=True) if name in family.positive]
        return [*given, *u], trust


def solver_of(family: Family) -> Solver | None:
    """How the members of a family are found; None where they are known in closed form.

    Raises
    ------
    StabilityError
        If more is solved for than the page can find.
    """
    if not family.unknown or family.closed:
        return None
    if len(family.unknown) > MOST or family.graph.finder is None:
        raise StabilityError(
            f"{family.name}: {', '.join(family.unknown)} of its members is solved for; the page "
            f"finds up to {MOST} unknowns, which their equations fix."
        )
    return Solver(family)
