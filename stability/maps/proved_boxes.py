"""Whole rectangles of parameters with one proved verdict, and the strip that encloses a boundary.

A rectangle is halved in both directions until the conditions of its family keep their signs on all
of it, or until it is as narrow as the levels allow.  For the disk the conditions are the
polynomials of `stability.bodies.disk_polynomials`, bounded over many boxes at once by the
mean value form.  For a user's family they are its polynomials over Q in the two axes, or Routh's
array in wide balls.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..algebra.exact.known_polynomial import TabulatedPolynomial
from ..algebra.number_types import Algebra
from ..algebra.polynomial import Polynomial
from ..algebra.running_error import UNIT
from ..base.axis import Axis
from ..base.checks import whole_number
from ..base.errors import NoMemberError
from ..base.types import Floats, Progress
from ..base.verdict import CODES, Verdict, best
from ..spectra.problem import Problem
from .own.slice_verdicts import slice_verdicts
from .verdict_filter import tabulated

MOST_LEVELS = 16
"""Largest number of halvings; an axis is then cut into 65 536 parts."""
SLACK = 64 * UNIT
"""Relative slack of every product of bounds, more than its few roundings."""


@dataclass(frozen=True, eq=False)
class Boxes:
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


class Interval:
    """A closed interval of nonnegative numbers, elementwise, rounded outwards."""

    def __init__(self, low: Any, high: Any) -> None:
        self.low, self.high = low, high

    def __mul__(self, other: Interval) -> Interval:
        return Interval(self.low * other.low * (1 - SLACK), self.high * other.high * (1 + SLACK))

    def __truediv__(self, other: Interval) -> Interval:
        return Interval(self.low / other.high * (1 - SLACK), self.high / other.low * (1 + SLACK))


def prove_boxes(
    problem: Problem, axes: tuple[Axis, Axis], levels: int, progress: Progress | None = None
) -> Boxes:
    """Cover a map with rectangles of one proved verdict and a strip of narrow ones.

    Parameters
    ----------
    problem
        Family with values in the user's units.
    axes
        x and y.
    levels
        Largest number of halvings of the map in both directions.
    progress
        Called with (boxes examined, a bound on their number).

    Returns
    -------
    Boxes

    Raises
    ------
    ParameterError
        If levels is not between 0 and `MOST_LEVELS`.

    Examples
    --------
    >>> from stability.bodies.contact_laws import Viscous
    >>> from stability.bodies.disk import Disk
    >>> from stability.spectra.disk_problem import disk_problem
    >>> problem = disk_problem("rolling", Disk(), Viscous(1.0), 1.0)
    >>> axes = Axis("at", 0.1, 3.0, 9), Axis("mu", 0.1, 1.0, 9)
    >>> boxes = prove_boxes(problem, axes, 6)
    >>> round(boxes.proved, 2), sorted(set(boxes.codes.tolist()))
    (0.98, [0, 1, 2])
    """
    levels = whole_number("levels", levels, 0, MOST_LEVELS)
    fast = isinstance(problem.exact, TabulatedPolynomial)
    judge = BoxConditions(problem) if fast else _own(problem, axes)
    edges = [_edges(axis, levels) for axis in axes]
    i = j = np.zeros(1, dtype=np.int64)
    found: list[tuple[Any, Any, Any]] = []
    done, proved = 0, 0.0
    for level in range(levels + 1):
        width = 1 << (levels - level)
        span = [(e[n * width], e[(n + 1) * width]) for e, n in zip(edges, (i, j), strict=True)]
        codes = judge({axes[0].name: span[0], axes[1].name: span[1]})
        done += len(codes)
        if progress:
            progress(done, done + 4 * int((codes == 0).sum()) * (level < levels))
        proved += 4.0**-level * int((codes != 0).sum())
        keep = codes != 0 if level < levels else np.ones(len(codes), dtype=bool)
        found.append((np.stack(span[0], -1)[keep], np.stack(span[1], -1)[keep], codes[keep]))
        i, j = i[~keep], j[~keep]
        i = np.concatenate([2 * i, 2 * i + 1, 2 * i, 2 * i + 1])
        j = np.concatenate([2 * j, 2 * j, 2 * j + 1, 2 * j + 1])
        if not len(i):
            break
    x, y, c = (np.concatenate(part) for part in zip(*found, strict=True))
    return Boxes(x, y, c.astype(np.int8), levels, proved)


def _edges(axis: Axis, levels: int) -> Floats:
    return Axis(axis.name, axis.low, axis.high, (1 << levels) + 1, axis.log).values


Spans = Mapping[str, tuple[Floats, Floats]]


def _own(problem: Problem, axes: tuple[Axis, Axis]) -> Callable[[Spans], NDArray[np.int8]]:
    """Verdicts over boxes of a user's family."""
    found = None if problem.may_drift else slice_verdicts(problem, axes)
    return _WideBalls(problem) if found is None else found.boxes


class BoxConditions:
    """Verdicts proved over whole boxes from the exact conditions, vectorised.

    Parameters
    ----------
    problem
        Problem of a family with a tabulated polynomial.
    """

    def __init__(self, problem: Problem) -> None:
        self.problem, self.exact = problem, tabulated(problem)
        self.parts = [_Range(p) for _, p in self.exact.known.conditions]

    def __call__(self, spans: Spans) -> NDArray[np.int8]:
        """Verdict flags, 0 where none is proved.

        Parameters
        ----------
        spans
            Low and high ends by name of what varies, shapes (N,).

        Returns
        -------
        ndarray
            Shape (N,).
        """
        count = len(next(iter(spans.values()))[0])
        values: dict[str, Any] = {}
        upright = np.zeros(count, dtype=bool)
        for name, value in self.problem.values.items():
            # what does not vary stays a number, which is bounded once
            low, high = spans.get(name) or (np.asarray(value, float), np.asarray(value, float))
            if self.exact.angle(name):
                upright |= _upright(name, low, high)
                values[name] = (name, low, high)
            else:
                inside = (low <= 0) & (high >= 0)
                if name == "phi_dot":  # circling and precession, which have no member at zero
                    upright |= inside
                least = np.where(inside, 0.0, np.minimum(np.abs(low), np.abs(high)))
                values[name] = Interval(least, np.maximum(np.abs(low), np.abs(high)))
        with np.errstate(all="ignore"):
            point = self.exact.point(values, INTERVALS)
            box = [p if isinstance(p, Interval) else Interval(p, p) for p in point]
            signs = [part(box) for part in self.parts]
        good: Any = np.ones(count, dtype=bool)
        bad: Any = np.zeros(count, dtype=bool)
        for sign in signs:
            good, bad = good & (sign > 0), bad | (sign < 0)
        codes = np.zeros(count, dtype=np.int8)
        codes[good] = CODES[best(even=self.exact.known.even)]
        codes[bad] = CODES[Verdict.UNSTABLE]
        codes[upright] = 0  # the static boundary itself runs through such a box
        return codes


def _upright(name: str, low: Floats, high: Floats) -> NDArray[np.bool_]:
    """Whether a box may hold the right angle: no double theta is one, a lean of 0 is."""
    if name == "lean":
        return (low <= 0) & (high >= 0)
    return (low <= np.pi / 2) & (high > np.pi / 2)


def _sine(angle: tuple[str, Floats, Floats]) -> Interval:
    name, low, high = angle
    ends = (np.cos(low), np.cos(high)) if name == "lean" else (np.sin(low), np.sin(high))
    top = np.where(_upright(name, low, high), 1.0, np.maximum(*ends) * (1 + SLACK))
    return Interval(np.minimum(*ends) * (1 - SLACK), np.minimum(top, 1.0))


INTERVALS = Algebra("intervals", float, {"sin": _sine, "cos": _sine})
"""Sines over boxes; the sine of theta is the cosine of a lean."""


class _Range:
    """Sign of a polynomial over boxes by the mean value form."""

    def __init__(self, polynomial: Polynomial) -> None:
        self.value = polynomial.parts
        self.slopes = [polynomial.derivative(n).parts for n in polynomial.variables]
        most = max(p.roundings(dict.fromkeys(polynomial.variables, 1)) for p in self.value)
        self.error = 4 * (most + 4) * UNIT

    def __call__(self, box: list[Interval]) -> NDArray[np.int8]:
        """1: positive everywhere, proved; -1: negative everywhere; 0: open."""
        low, high = [b.low for b in box], [b.high for b in box]
        middle = [0.5 * (b.low + b.high) for b in box]
        plus, minus = self.value[0](*middle), self.value[1](*middle)
        spread: Any = self.error * (plus + minus)
        for b, m, (up, down) in zip(box, middle, self.slopes, strict=True):
            if np.all(b.low == b.high):
                continue
            # |∂P| is at most the larger of these over the box
            steepest = np.maximum(up(*high) - down(*low), down(*high) - up(*low))
            steepest = steepest + self.error * (up(*high) + down(*high))
            reach = np.maximum(b.high - m, m - b.low) * (1 + SLACK)
            spread = spread + reach * steepest * (1 + SLACK)
        size = plus - minus
        sure = np.abs(size) > spread  # NaN, from an overflow, is not sure
        return np.where(sure, np.sign(size), 0).astype(np.int8)


class _WideBalls:
    """Routh's array in balls as wide as the box, for a family without an exact polynomial."""

    BITS = 96

    def __init__(self, problem: Problem) -> None:
        self.problem = problem

    def __call__(self, spans: Spans) -> NDArray[np.int8]:
        count = len(next(iter(spans.values()))[0])
        return np.array([self._one(spans, n) for n in range(count)], dtype=np.int8)

    def _one(self, spans: Spans, n: int) -> int:
        from flint import arb

        from ..algebra.balls import precision
        from ..spectra.certificate import in_balls

        with precision(self.BITS):
            values = {name: arb(float(v)) for name, v in self.problem.values.items()}
            for name, (low, high) in spans.items():
                values[name] = arb(float(low[n])).union(arb(float(high[n])))
            a, q, _ = self.problem.reduce(values, lambda v: v.sqrt())
            try:
                found = in_balls(self.problem.family, a, q)
            except NoMemberError:
                return 0
        return CODES[found] if found is not None else 0
