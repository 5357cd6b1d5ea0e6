"""Changes of verdict between the points of a scan, and the pieces on which it excludes none."""

from __future__ import annotations

from collections.abc import Sequence

from ..base.errors import StabilityError
from ..base.types import Floats
from ..base.verdict import DECAYING, Verdict
from .brackets import AxisScan, at_point, refine
from .crossings import Boundaries, BoundaryPoint, Unresolved

SCANNED = "verdicts at the points of a scan, refined and proved where neighbours differ"


def scanned(line: AxisScan, grid: Floats, why: str = "") -> Boundaries:
    """Changes between the points of a scan, and the pieces on which it excludes none.

    Parameters
    ----------
    line
        The line.
    grid
        Points of the scan, in increasing order.
    why
        Reason why the axis is scanned, for the statement.

    Returns
    -------
    Boundaries

    Raises
    ------
    StabilityError
        If there is no member at any point.
    """
    values = [float(v) for v in grid]
    signs, left = _signs(line, values)
    known = [i for i, s in enumerate(signs) if s]
    if not known:
        reason = (
            f"no verdict is proved at any of the {len(grid)} points of the scan: eigenvalues stay "
            "on the imaginary axis, or coincide, as far as the budget of precision sees."
        )
        return Boundaries((), (Unresolved(values[0], values[-1], reason),), how=SCANNED)
    for end, first in ((0, known[0]), (len(values) - 1, known[-1])):
        if end != first:
            low, high = sorted((values[end], values[first]))
            left.append(Unresolved(low, high, _open(values[end])))
    points: list[BoundaryPoint] = []
    for i, j in zip(known[:-1], known[1:], strict=True):
        point = _between(line, values[i : j + 1], changed=signs[i] != signs[j])
        if point is not None:
            points.append(point)
        elif signs[i] != signs[j]:
            reason = "the verdicts at the ends differ, but the change could not be bracketed."
            left.append(Unresolved(values[i], values[j], reason))
        elif j > i + 1:
            left.append(Unresolved(values[i], values[j], _open(values[i + 1])))
    left.append(
        Unresolved(
            values[0],
            values[-1],
            f"between neighbours of the {len(grid)} points of the scan a pair "
            "of changes is not excluded" + (f": {why}." if why else "."),
        )
    )
    return Boundaries(tuple(points), tuple(left), how=SCANNED)


def _signs(line: AxisScan, values: Sequence[float]) -> tuple[list[int], list[Unresolved]]:
    """Signs by `look` at the points of a scan, and the points without a member."""
    found: list[tuple[Verdict, bool]] = []
    left: list[Unresolved] = []
    errors: list[StabilityError] = []
    for value in values:
        try:
            found.append(line.look(value))
        except StabilityError as error:
            found.append((Verdict.UNDECIDED, False))
            errors.append(error)
            left.append(Unresolved(value, value, f"no verdict there: {error}"))
    if len(errors) == len(values):
        raise errors[0]
    # among decaying members a neutral one is on a boundary; without these neutral is good
    line.neutral = all(verdict not in DECAYING for verdict, _ in found)
    return [line.sign_of(*pair) for pair in found], left


def _open(value: float) -> str:
    return (
        f"no verdict is proved at {value:.10g}: an eigenvalue lies on the imaginary axis there, or "
        "too near to it."
    )


def _between(line: AxisScan, values: Sequence[float], *, changed: bool) -> BoundaryPoint | None:
    """The change between two points with a verdict; points between the two have none."""
    if not changed:
        return None
    try:
        point = at_point(line, values[1]) if len(values) == 3 else None  # on the boundary itself
        return point or refine(line, values[0], values[-1])
    except StabilityError:  # there is no member somewhere between
        return None
