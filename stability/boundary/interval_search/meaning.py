"""Parts of an axis on which the system's conditions fail, so that there is no member.

Source: tests/boundary/test_algebraic_boundaries.py.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from flint import arb

from ...algebra.number_types import balls, precision
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
    if not line.problem.plain or not line.problem.family.system.conditions:
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
        unresolved=tuple(sorted([*(u for u in found.unresolved if not _inside(u, parts)), *parts])),
    )


def _inside(part: Unresolved, others: Sequence[Unresolved]) -> bool:
    return any(o.low <= part.low and part.high <= o.high for o in others)


class _Conditions:
    """The system's conditions along a line, in balls."""

    def __init__(self, line: AxisScan) -> None:
        self.line, self.family = line, line.problem.family

    def fail(self, low: float, high: float) -> list[Unresolved]:
        """Parts on which a condition fails, or is not decided, neighbours alike as one."""
        least = FINEST * max(abs(low), abs(high))
        level = [(low, high)]
        parts: list[Unresolved] = []
        count = 0
        while level:
            cuts = [first + (last - first) * CUT for first, last in level]
            wider, level = level, []
            for (first, last), cut, near in zip(wider, cuts, self._members(wider), strict=True):
                count += 1
                reason = self._reason(first, last, near)
                if reason == "":
                    continue
                if reason or count > MOST_PIECES or last - first <= least or not first < cut < last:
                    unsure = UNSURE.format(system=self.family.system.name)
                    parts.append(Unresolved(first, last, f"{reason or unsure}."))
                    continue
                level += [(first, cut), (cut, last)]
        return _joined(parts)

    def _members(self, level: Sequence[tuple[float, float]]) -> list[list[float] | None]:
        """Unknowns at the middle of each piece in double precision, followed all at once."""
        family = self.family
        if not family.unknown or family.closed:
            return [[]] * len(level)
        with precision(BITS):
            given = [self._given(arb(_ball(*ends).mid())) for ends in level]
        a, q = (
            np.array([[float(v.mid()) for v in part[i]] for part in given]).reshape(len(level), -1)
            for i in (0, 1)
        )
        found = family.search(a, q)
        return [u.tolist() if good else None for good, u in zip(found.good, found.u, strict=True)]

    def _given(self, place: Any) -> tuple[list[Any], list[Any]]:
        """Family parameters and parameters at a value of the axis, as balls."""
        given = self.line.exact() | {self.line.axis: place}
        at, others = self.family.at, self.family.parameters
        return [arb(given[n]) for n in at], [arb(given[n]) for n in others]

    def _reason(self, low: float, high: float, near: list[float] | None) -> str | None:
        """Empty where all conditions hold on a piece; None where this is open."""
        if near is None:
            return None
        with precision(BITS):
            try:
                values = self._values(_ball(low, high), near)
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

    def _values(self, place: Any, near: list[float]) -> list[Any]:
        family = self.family
        a, q = self._given(place)
        u = ball_unknowns(family, a, q, near)
        states = [arb(row[0]) for row in family.graph.state.dense(balls(), [a, u, q])]
        known = dict(zip((*family.at, *family.parameters), (*a, *q), strict=True))
        own = [known[n] for n in family.system.parameters]
        return [
            arb(v[0]) if v else arb(0)
            for v in family.system.condition_program.run(balls(), [states, own])
        ]


def _ball(low: float, high: float) -> Any:
    """A ball that holds a piece."""
    half = (arb(high) - arb(low)) / 2
    middle = arb(low) + half
    return arb(middle.mid(), (half + middle.rad()).abs_upper())


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
