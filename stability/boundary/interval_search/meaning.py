"""Parts of an axis on which the system's conditions fail, so that there is no member.

Source: tests/boundary/test_algebraic_boundaries.py.
"""

from __future__ import annotations

import heapq
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from flint import arb

from ...algebra.balls import precision
from ...algebra.number_types import balls
from ...base.errors import StabilityError
from ...systems.structure.enclosure import ball_unknowns
from ..brackets import BITS, AxisScan
from ..crossings import Boundaries, Unresolved
from .pieces import CUT, FINEST

MOST_PIECES = 600
"""Largest number of pieces."""
UNSURE = "whether the conditions of {system} hold here is not decided"
FAILS = "{family} has no member here, since a condition of {system} fails: {sentence}"


def meaningful(line: AxisScan, low: float, high: float, found: Boundaries) -> Boundaries:
    """A result without the parts of the axis on which the system's conditions are not proved.

    Parameters
    ----------
    line
        The line.
    low, high
        Ends of the interval.
    found
        What was found without regard to the conditions.

    Returns
    -------
    Boundaries
        These parts are unresolved, each with the condition.
    """
    if line.problem.law is not None or not line.problem.family.system.conditions:
        return found
    parts = [u for u in _Conditions(line).fail(low, high) if not _inside(u, found.unresolved)]
    if not parts:
        return found

    def free(value: float, error: float = 0.0) -> bool:
        return not any(u.low <= value + error and value - error <= u.high for u in parts)

    return replace(
        found,
        points=tuple(p for p in found.points if free(p.value, p.error)),
        touching=tuple(v for v in found.touching if free(v)),
        unresolved=tuple(sorted([
            *(u for u in found.unresolved if not _inside(u, parts)), *parts])),
    )  # fmt: skip


def _inside(part: Unresolved, others: Sequence[Unresolved]) -> bool:
    return any(o.low <= part.low and part.high <= o.high for o in others)


class _Conditions:
    """The system's conditions along a line, in balls."""

    def __init__(self, line: AxisScan) -> None:
        self.line, self.family = line, line.problem.family

    def fail(self, low: float, high: float) -> list[Unresolved]:
        """Parts on which a condition fails, or is not decided, neighbours alike as one."""
        least = FINEST * max(abs(low), abs(high))
        heap = [(low - high, low, high)]
        parts: list[Unresolved] = []
        count = 0
        while heap:
            _, first, last = heapq.heappop(heap)
            count += 1
            reason = self._reason(first, last)
            if reason == "":
                continue
            cut = first + (last - first) * CUT
            if reason or count > MOST_PIECES or last - first <= least or not first < cut < last:
                unsure = UNSURE.format(system=self.family.system.name)
                parts.append(Unresolved(first, last, f"{reason or unsure}."))
                continue
            for part in ((first, cut), (cut, last)):
                heapq.heappush(heap, (part[0] - part[1], *part))
        return _joined(parts)

    def _reason(self, low: float, high: float) -> str | None:
        """Empty where all conditions hold on a piece; None where this is open."""
        with precision(BITS):
            half = (arb(high) - arb(low)) / 2
            middle = arb(low) + half
            try:
                values = self._values(arb(middle.mid(), (half + middle.rad()).abs_upper()))
            except (StabilityError, ZeroDivisionError):
                return None
            if all(v > 0 for v in values):
                return ""
            for condition, value in zip(self.family.system.conditions, values, strict=True):
                if value <= 0:
                    said = condition.refusal(float(value.mid())).rstrip(".")
                    names = {"family": self.family.name, "system": self.family.system.name}
                    return FAILS.format(sentence=said, **names)
        return None

    def _values(self, place: Any) -> list[Any]:
        family, given = self.family, self.line.exact()
        given[self.line.axis] = place
        a, q = ([given[n] for n in names] for names in (family.at, family.parameters))
        near = None
        if family.unknown and not family.closed:
            point = given | {self.line.axis: arb(place.mid())}
            here = [[point[n] for n in names] for names in (family.at, family.parameters)]
            near = [float(v.mid()) for v in ball_unknowns(family, *here)]
        u = ball_unknowns(family, a, q, near)
        states = [arb(row[0]) for row in family.graph.state.dense(balls(), [a, u, q])]
        own = [given[n] for n in family.system.parameters]
        return [
            arb(v[0]) if v else arb(0)
            for v in family.system.condition_program.run(balls(), [states, own])
        ]


def _joined(parts: list[Unresolved]) -> list[Unresolved]:
    """Touching parts as one, with every reason; a tiny part takes that of its neighbour."""
    out: list[Unresolved] = []
    for part in sorted(parts):
        if out and part.low <= np.nextafter(out[-1].high, np.inf):
            before = out.pop()
            wide = max(before, part, key=lambda u: u.high - u.low)
            out.append(Unresolved(before.low, part.high, wide.reason))
        else:
            out.append(part)
    return out
