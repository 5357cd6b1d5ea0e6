"""Changes of verdict from the pieces of an axis: each as a proved bracket.

Between two neighbouring meetings with the imaginary axis the verdict is constant.  A simple meeting
changes the verdict once or not at all.  So the verdicts at the ends of its piece decide.  (Where
both ends are unstable, another eigenvalue is unstable at the meeting too: no value is neutral.)
"""

from __future__ import annotations

import numpy as np
from flint import arb

from ...algebra.balls import precision
from ...base.errors import StabilityError
from ...base.types import Floats
from ..brackets import BITS, AxisScan, at_point, bracketed, refine
from ..crossings import Boundaries, BoundaryPoint, Unresolved
from ..scan import scanned
from .pieces import NO_VALUE, TOUCH, Leaf, pieces

PIECES = (
    "in ball arithmetic each of {count} pieces was proved to hold no eigenvalue on the imaginary "
    "axis, or a single crossing"
)
NARROW = 8
"""Largest half-width of a bracket about a root that is known, in units of its last place."""
BRANCH = "on one branch of steady motions"


def proved(line: AxisScan, grid: Floats, *, log: bool = False) -> Boundaries:
    """Every change of verdict along an axis that need not be rational, with what stays open.

    Parameters
    ----------
    line
        The line.
    grid
        Points of a scan for the pieces without proof; its ends are those of the interval.
    log
        Whether the points have equal ratios.

    Returns
    -------
    Boundaries
    """
    low, high = float(grid[0]), float(grid[-1])
    found = pieces(line, low, high, log=log)
    if all(leaf.meetings is None for leaf in found.leaves):
        return scanned(line, grid, found.leaves[0].reason)
    points: list[BoundaryPoint] = []
    left: list[Unresolved] = []
    for leaf in found.leaves:
        if leaf.meetings is None:
            part = _open(line, leaf, grid)
        elif leaf.meetings:
            part = _meeting(line, leaf, low, high)
        else:
            continue
        points += part[0]
        left += part[1]
    family = line.problem.family
    how = PIECES.format(count=found.count)
    if family.unknown and not family.closed:
        how += f", {BRANCH}"
    inside = [p for p in points if low <= p.value + p.error and p.value - p.error <= high]
    return Boundaries(tuple(inside), tuple(left), how=how)


Part = tuple[list[BoundaryPoint], list[Unresolved]]


def _meeting(line: AxisScan, leaf: Leaf, low: float, high: float) -> Part:
    """The change at the meetings of a piece: one or two, so that ends that differ mean one."""
    first, last = max(leaf.low, low), min(leaf.high, high)
    try:
        point = _at_once(line, leaf)
        if point is not None:
            return [point], []
        signs = line.sign(leaf.low), line.sign(leaf.high)
        if signs[0] == signs[1] != 0 and leaf.meetings == 1:
            return [], []
        if signs[0] * signs[1] < 0 and leaf.meetings in (1, 2):
            point = _at_end(line, leaf, low, high) or _near(line, leaf)
            point = point or refine(line, leaf.low, leaf.high)
            if point is not None:
                return [point], []
    except StabilityError as error:
        return [], [Unresolved(first, last, f"no verdict there: {error}")]
    reason = TOUCH if signs[0] == signs[1] else "the change could not be bracketed"
    return [], [Unresolved(first, last, f"{reason}.")]


def _at_once(line: AxisScan, leaf: Leaf) -> BoundaryPoint | None:
    """The change at a known single meeting with proved verdicts that differ right next to it.

    The verdicts at the ends of the piece follow from these, since nothing else changes on it.
    """
    if leaf.near is None or leaf.meetings != 1:
        return None
    step = float(np.spacing(abs(leaf.near[0])))
    sides = leaf.near[0] - step, leaf.near[0] + step
    if not leaf.low <= sides[0] < sides[1] <= leaf.high:
        return None
    return _near(line, leaf) if line.sign(sides[0]) * line.sign(sides[1]) < 0 else None


def _near(line: AxisScan, leaf: Leaf) -> BoundaryPoint | None:
    """The change at a meeting that is known to double precision."""
    if leaf.near is None:
        return None
    found = bracketed(line, *leaf.near)
    return found if found and found.error <= NARROW * np.spacing(abs(found.value)) else None


def _at_end(line: AxisScan, leaf: Leaf, low: float, high: float) -> BoundaryPoint | None:
    """The change at an end of the interval itself, beyond which the search went on a little."""
    for end, beyond in ((low, leaf.low < low), (high, leaf.high > high)):
        if beyond and not line.sign(end):
            return at_point(line, end)
    return None


def _open(line: AxisScan, leaf: Leaf, grid: Floats) -> Part:
    """What a scan finds on a piece without proof, which stays unresolved."""
    first, last = max(leaf.low, float(grid[0])), min(leaf.high, float(grid[-1]))
    inside = grid[(grid > leaf.low) & (grid < leaf.high)]
    before = line.neutral
    try:
        found = list(scanned(line, np.array([leaf.low, *inside, leaf.high])))
    except StabilityError:  # no member at any point: the reason says so
        found = []
    finally:
        line.neutral = before
    if NO_VALUE in leaf.reason:  # through a pole the verdict changes, and no eigenvalue is zero
        found = [point for point in found if _has_value(line, point)]
    return found, [Unresolved(first, last, f"{leaf.reason}.")]


def _has_value(line: AxisScan, point: BoundaryPoint) -> bool:
    """Whether the linearisation has a finite enclosure over the bracket of a change."""
    with precision(BITS):
        over = arb(point.value, 2 * point.error)
        try:
            return all(c.is_finite() for c in line.enclosed(over, BITS))
        except (StabilityError, ArithmeticError):
            return False
