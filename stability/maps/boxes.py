"""Whole rectangles of parameters with one proved verdict, and proved verdicts at single points.

A rectangle has one proved verdict, or lies in the strip that encloses a boundary.  It is halved in
both directions until the conditions of its family keep their signs on all of it, or until it is as
narrow as the levels allow.  The conditions are polynomials over Q in the two axes, bounded over
many boxes at once by Taylor's sum, or Routh's array in wide balls.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..base.axis import Axis
from ..base.checks import whole_number
from ..base.errors import NoMemberError
from ..base.types import Floats
from ..base.verdict import CODES
from ..spectra.problem import Problem
from .verdicts import slice_verdicts

MOST_LEVELS = 16
"""Largest number of halvings; an axis is then cut into 65 536 parts."""


@dataclass(frozen=True, eq=False)
class ProvedBoxes:
    """Rectangles that cover a map."""

    x: Floats
    """Low and high end along x, shape (N, 2)."""
    y: Floats
    """Low and high end along y, shape (N, 2)."""
    codes: NDArray[np.int8]
    """Flag of the verdict that is proved everywhere in the box, 0 in the strip, shape (N,)."""
    levels: int
    """Number of halvings of the map; boxes of the strip are 2^-levels of each axis wide."""
    proved: float
    """Share of the map's area that is proved, each axis in its own scale."""


def prove_boxes(problem: Problem, axes: tuple[Axis, Axis], levels: int) -> ProvedBoxes:
    """Cover a map with rectangles of one proved verdict and a strip of narrow ones.

    Raises
    ------
    ParameterError
        If levels is not between 0 and `MOST_LEVELS`.

    Examples
    --------
    >>> from stability.bodies.contact_laws import Viscous
    >>> from stability.bodies.disk import Disk
    >>> from stability.spectra.problem import disk_problem
    >>> problem = disk_problem("rolling", Disk(), Viscous(1.0), 1.0)
    >>> axes = Axis("at", 0.1, 3.0, 9), Axis("mu", 0.1, 1.0, 9)
    >>> boxes = prove_boxes(problem, axes, 6)
    >>> round(boxes.proved, 2), sorted(set(boxes.codes.tolist()))
    (0.98, [0, 1, 2])
    """
    levels = whole_number("levels", levels, 0, MOST_LEVELS)
    judge = _judge(problem, axes)
    edges = [_edges(axis, levels) for axis in axes]
    i = j = np.zeros(1, dtype=np.int64)
    pieces: list[tuple[Any, Any, Any]] = []
    proved = 0.0
    for level in range(levels + 1):
        width = 1 << (levels - level)
        span = [(e[n * width], e[(n + 1) * width]) for e, n in zip(edges, (i, j), strict=True)]
        codes = judge({axes[0].name: span[0], axes[1].name: span[1]})
        proved += 4.0**-level * int((codes != 0).sum())
        keep = codes != 0 if level < levels else np.ones(len(codes), dtype=bool)
        pieces.append((np.stack(span[0], -1)[keep], np.stack(span[1], -1)[keep], codes[keep]))
        i, j = i[~keep], j[~keep]
        i = np.concatenate([2 * i, 2 * i + 1, 2 * i, 2 * i + 1])
        j = np.concatenate([2 * j, 2 * j, 2 * j + 1, 2 * j + 1])
        if not len(i):
            break
    x, y, c = (np.concatenate(part) for part in zip(*pieces, strict=True))
    return ProvedBoxes(x, y, c.astype(np.int8), levels, proved)


def _edges(axis: Axis, levels: int) -> Floats:
    return Axis(axis.name, axis.low, axis.high, (1 << levels) + 1, axis.log).values


Spans = Mapping[str, tuple[Floats, Floats]]


def _judge(problem: Problem, axes: tuple[Axis, Axis]) -> Callable[[Spans], NDArray[np.int8]]:
    """Verdicts over boxes of a family."""
    verdicts = None if problem.may_drift else slice_verdicts(problem, axes)
    return _WideBalls(problem) if verdicts is None else verdicts.boxes


class _WideBalls:
    """Routh's array in balls as wide as the box, for a family without an exact polynomial."""

    BITS = 96

    def __init__(self, problem: Problem) -> None:
        self.problem = problem

    def __call__(self, spans: Spans) -> NDArray[np.int8]:
        count = len(next(iter(spans.values()))[0])
        return np.array([self._code(spans, n) for n in range(count)], dtype=np.int8)

    def _code(self, spans: Spans, n: int) -> int:
        from flint import arb

        from ..algebra.number_types import precision
        from ..spectra.certificate import in_balls

        with precision(self.BITS):
            values = {name: arb(float(v)) for name, v in self.problem.values.items()}
            for name, (low, high) in spans.items():
                values[name] = arb(float(low[n])).union(arb(float(high[n])))
            a, q, _ = self.problem.reduce(values, lambda v: v.sqrt())
            try:
                verdict = in_balls(self.problem.family, a, q)
            except NoMemberError:
                return 0
        return CODES[verdict] if verdict is not None else 0
