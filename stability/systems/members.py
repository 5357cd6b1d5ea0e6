"""The unknowns of many members: from a first guess, or followed from a known member.

Running error analysis (`stability.algebra.running_error`) bounds the computed value of a zero rate.
Given numbers count as known to two units in the last place, since decimals, π and conversions of
units are rounded before.

The line from a known member runs through the space of all parameters, for all rows at once.  Each
step has a tangent predictor and Newton's method as corrector.  A step is taken again with less than
half its length where the corrector contracts slowly, where its first correction is large, where the
tangent turns far, or where the determinant of the slope changes sign.  Where that sign changes even
over a short step, a branch point is solved for: the member passes it only if it is one, and no
narrow gap between two branches.  A fold is never passed: the members that are reached form one
smooth sheet.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..algebra.running_error import UNIT, RunningError, running_error_arrays
from ..base.checks import known
from ..base.errors import NameUnknownError, ParameterError, listing, shown
from ..base.types import Floats
from .graph.family_graph import FamilyGraph
from .singular_points import Curve, locate_branch_point, singular_point

GIVEN = 4 * UNIT
"""Relative error of a given number: two units in the last place."""


def _rounded_columns(block: Floats) -> list[RunningError]:
    """Columns of given numbers, each with the error of a given number."""
    return [RunningError(c, GIVEN * np.abs(c)) for c in block.T]


def _step_noise(
    graph: FamilyGraph, a: Floats, u: Floats, q: Floats, *, whole: bool = False
) -> Floats:
    """Bound on the change of a Newton step at a root by rounding of the equations."""
    exact = [[RunningError(c, np.zeros_like(c)) for c in block.T] for block in (a, u, q)]
    (value, error), (slope, _) = running_error_arrays(graph.residual, exact, a.shape[:1])
    size = error + np.abs(value) if whole else error
    noise = np.full(u.shape, np.inf)
    with np.errstate(all="ignore"):
        sound = np.isfinite(slope).all(axis=(1, 2)) & (np.linalg.det(slope) != 0)
    if sound.any():
        with np.errstate(all="ignore"):  # an infinite error makes the noise infinite
            moves = (np.abs(np.linalg.inv(slope[sound])) @ size[sound])[..., 0]
        noise[sound] = np.where(np.isnan(moves), np.inf, moves)
    return noise


def rate_noise(
    graph: FamilyGraph, a: Floats, u: Floats, q: Floats, states: Floats, matrix: Floats
) -> Floats:
    """Bound on the rates of a motion that is steady except for rounding.

    Parameters
    ----------
    graph
        The family's graph.
    a, u, q
        Family parameters, unknowns and parameters, shapes (N, ·).
    states, matrix
        States and linearisation of the members, shapes (N, n) and (N, n, n).

    Returns
    -------
    ndarray
        Shape (N, n); NaN where running error analysis has no bound.
    """
    with np.errstate(all="ignore"):
        root = GIVEN * np.abs(u)
        if u.shape[1] and not graph.closed:
            root = root + 2 * _step_noise(graph, a, u, q, whole=True)
        solved = [RunningError(c, e) for c, e in zip(u.T, root.T, strict=True)]
        values = running_error_arrays(
            graph.rates, [_rounded_columns(a), solved, _rounded_columns(q)], a.shape[:1]
        )
        bound: Floats = 2 * values[0][1][..., 0] + given_noise(states, matrix)
    return bound


def given_noise(states: Floats, matrix: Floats) -> Floats:
    """The part of `rate_noise` that given states account for, which is quickly known.

    Held values are exact constants of the graph, so running error analysis leaves them out.
    """
    with np.errstate(all="ignore"):
        out: Floats = 2 * (np.abs(matrix) @ (GIVEN * np.abs(states))[..., None])[..., 0]
    return out


STEP = 1e-11
"""Largest relative size of a further Newton step at an accepted root."""
NOISE = 1e-6
"""Largest rounding of a Newton step at an accepted root, relative to 1 or to the root."""
SHARES = (2.0, 0.5, 4.0, 0.25)
"""First guesses of positive unknowns, over the given ones, where these lead to no such root."""
TINY = 1e-9
"""Positive unknowns below it are compared with their rounding."""
NUDGE = 0.01
"""Change of a guess at which the slope is singular, and over its size."""


def roots(
    graph: FamilyGraph, a: Floats, q: Floats, start: Floats, positive: Sequence[int]
) -> tuple[Floats, NDArray[np.bool_]]:
    """Isolated roots from first guesses.

    Parameters
    ----------
    graph
        The family's graph, with a root-finder.
    a, q, start
        Family parameters, parameters and first guesses, shapes (N, ·).
    positive
        Indices of unknowns that must be positive.

    Returns
    -------
    u, good
        Unknowns, shape (N, u), and whether each row is an isolated, admissible root.
    """
    u, good = _accepted_roots(graph, a, q, start, positive)

    def again(rows: NDArray[np.intp], other: Floats) -> None:
        new, fine = _accepted_roots(graph, a[rows], q[rows], other, positive)
        u[rows[fine]], good[rows[fine]] = new[fine], True

    for share in SHARES if positive else ():
        # the nearest root may be the mirror image, which is not admissible
        rows = np.flatnonzero(~good)
        if not len(rows):
            break
        other = start[rows].copy()
        other[:, positive] *= share
        again(rows, other)
    rows = np.flatnonzero(~good)
    if len(rows):  # Newton's method has no first step from a guess where the slope is singular
        step = newton_step(graph, a[rows], start[rows], q[rows])
        rows = rows[~np.isfinite(step).all(axis=1)]
    if len(rows):
        again(rows, start[rows] * (1 + NUDGE) + NUDGE)
    return u, good


def _accepted_roots(
    graph: FamilyGraph, a: Floats, q: Floats, start: Floats, positive: Sequence[int]
) -> tuple[Floats, NDArray[np.bool_]]:
    assert graph.finder is not None
    finder = graph.finder.map(len(a))
    u = np.array(finder(start.T, np.hstack([a, q]).T)).T.reshape(len(a), -1)
    return u, accepted(graph, a, u, q, positive)


def accepted(
    graph: FamilyGraph, a: Floats, u: Floats, q: Floats, positive: Sequence[int]
) -> NDArray[np.bool_]:
    """Whether unknowns are isolated roots to the last digits, and admissible.

    Returns
    -------
    ndarray of bool
        Shape (N,).
    """
    step = newton_step(graph, a, u, q)
    size = np.maximum(np.abs(u), 1e-300)
    close = np.abs(step) <= STEP * np.maximum(size, 1e-8)
    if not close.all():
        # a root at 0 is accurate within the rounding of its equation, not relatively
        noise = _step_noise(graph, a, u, q)
        close |= (np.abs(step) <= 2 * noise) & (noise <= NOISE * np.maximum(size, 1.0))
    good: NDArray[np.bool_] = np.asarray((np.isfinite(u) & close).all(axis=1))
    signed = u[:, list(positive)]
    good &= (signed > 0).all(axis=1)
    if (good & (signed < TINY).any(axis=1)).any():  # a root at 0 comes out on either side
        off = _step_noise(graph, a, u, q, whole=True)
        good &= (signed > 2 * off[:, list(positive)]).all(axis=1)
    return good


def newton_step(graph: FamilyGraph, a: Floats, u: Floats, q: Floats) -> Floats:
    """A further Newton step; infinite where the slope is singular.

    Returns
    -------
    ndarray
        Shape (N, u).
    """
    _, _, r, r_u, _ = graph.tangent.arrays([list(a.T), list(u.T), list(q.T)], a.shape[:1])
    return solved(r_u, r[..., 0])


def solved(slope: Floats, right: Floats) -> Floats:
    """Solutions of many linear systems; infinite where the matrix is singular.

    Parameters
    ----------
    slope, right
        Shapes (N, u, u) and (N, u).

    Returns
    -------
    ndarray
        Shape (N, u).
    """
    with np.errstate(all="ignore"):
        determinant = np.linalg.det(slope)
        bad = ~np.isfinite(slope).all(axis=(1, 2)) | ~np.isfinite(determinant) | (determinant == 0)
        slope = np.where(bad[:, None, None], np.eye(slope.shape[1]), slope)
        step: Floats = np.asarray(np.linalg.solve(slope, right[..., None])[..., 0], dtype=float)
    step[bad | ~np.isfinite(step).all(axis=1)] = np.inf
    return step


LEAST = 1e-8
"""Shortest step, as a share of the line."""
BRANCH = 1e-5
"""Longest step over which the determinant may change sign at a branch point, as a share."""
MOST_STEPS = 2000
"""Most steps along one line, tried ones included."""
SHORTER = 0.45
"""Factor of a step that failed; no half, so that steps do not meet a branch point exactly."""
REACH = 0.5
"""Largest change of an unknown over one step, relative to 1 or to the unknown."""
FIRST = 0.1
"""Largest first correction, relative to 1 or to the unknown."""
CONTRACTION = 0.25
"""Largest ratio of the second correction to the first."""
CLOSE = 1e-2
"""Largest ratio of the third correction to the first."""
BEND = 0.6
"""Largest change of a tangent over one step, relative to the tangent."""
SLIGHT = 0.01
"""Largest change of a tangent over one step, as its effect relative to the unknown."""
AHEAD = 2
"""Least way to where the determinant would vanish, over a step on which it keeps its sign."""
SETTLED = 1e-10
"""Corrections below this, relative to 1 or to the unknown, are rounding."""


@dataclass(frozen=True)
class Anchor:
    """A member that is known, from which others are followed."""

    at: tuple[float, ...]
    """Family parameters."""
    parameters: tuple[float, ...]
    """The system's other parameters, in the family's order."""
    unknown: tuple[float, ...]
    """The unknowns there, to double precision."""

    @property
    def given(self) -> Floats:
        """Family parameters and parameters, shape (m,)."""
        return np.array([*self.at, *self.parameters])


class Followed(NamedTuple):
    """How far members were followed along their lines."""

    u: Floats
    """Unknowns at the last point, shape (N, u)."""
    share: Floats
    """Share of the line that was followed; 1 where the end was reached, shape (N,)."""


def _at(lines: Curve, rows: Any, u: Floats, t: Floats) -> tuple[Floats, Floats, Floats]:
    """Residual, slope by the unknowns, and slope along the line, at shares of some lines."""
    some = replace(lines, start=lines.start[rows], turn=lines.turn[rows])
    with np.errstate(all="ignore"):
        r, slope = some.at(np.column_stack([u, t]))
    return r, slope[..., :-1], slope[..., -1]


def _crosses(line: Curve, u: Floats, t: float, h: float) -> bool:
    """Whether a branch point is resolved next to a point: no narrow gap, which is no way."""
    point = locate_branch_point(line, np.array([*u, t]))
    return point.resolved and bool(abs(point.z[-1] - t) <= h)


def follow(graph: FamilyGraph, cut: int, start: Floats, u: Floats, stop: Floats) -> Followed:
    """Follow members along straight lines, as far as they go.

    Parameters
    ----------
    graph
        The family's graph.
    cut
        Number of family parameters among the numbers of a row.
    start, stop
        Family parameters and parameters at the ends of each line, shapes (N, m).
    u
        Unknowns at `start`, shape (N, u).

    Examples
    --------
    The root of p = x² follows √p, and ends at the fold.

    >>> import casadi as ca
    >>> from stability.systems.system import System
    >>> from stability.systems.family import Family
    >>> x, p = ca.SX.sym("x"), ca.SX.sym("p")
    >>> fold = Family(System("fold", x, p, p - x**2, states=("x",), parameters=("p",)), "upper",
    ...               at=("p",), unknown={"x": 1.0}, equations=("x",))
    >>> start, stop = np.array([[1.0], [1.0]]), np.array([[4.0], [-1.0]])
    >>> found = follow(fold.graph, 1, start, np.ones((2, 1)), stop)
    >>> found.u[0].round(6), found.share.round(6)
    (array([2.]), array([1. , 0.5]))
    """
    lines = Curve(graph, cut, start, stop - start)
    u, t = u.copy(), np.zeros(len(u))
    step, patience = np.full(len(u), 1.0), np.zeros(len(u), dtype=int)
    jumped = np.zeros(len(u), dtype=bool)
    rows = np.arange(len(u))
    _, slope, along = _at(lines, rows, u, t)
    turn = -solved(slope, along)
    sign, size = _sign(slope)
    # the way to where the determinant would vanish, by its change over the last step
    left = _left(BRANCH, size, _sign(_at(lines, rows, u - BRANCH * turn, t - BRANCH)[1])[1])
    for _ in range(MOST_STEPS):
        rows = np.flatnonzero((t < 1) & (step >= np.minimum(LEAST, 1 - t)) & (sign != 0))
        if not len(rows):
            break
        room = REACH * (1 + np.abs(u[rows])) / np.maximum(np.abs(turn[rows]), 1e-300)
        # beyond where the determinant vanishes another sheet may have its sign
        rest = 1 - t[rows]
        ahead = np.where(rest > BRANCH, left[rows] / AHEAD, np.inf)  # or the end is such a place
        h = np.minimum(np.minimum(step[rows], np.minimum(room.min(axis=1), ahead)), rest)
        step[rows] = h
        # a branch point is passed from a distance to the same distance, not from where it is near
        jump = (left[rows] <= np.minimum(BRANCH, rest) / 2) & ~jumped[rows]
        h = np.where(jump, 2 * left[rows], h)
        jumped[rows] = jump
        following = np.where(h == rest, 1.0, t[rows] + h)
        new, fine, slopes = _corrected(lines, rows, u[rows] + h[:, None] * turn[rows], following)
        now, large = _sign(slopes[0])
        after = -solved(*slopes)
        fine &= (now != 0) & ((now == sign[rows]) | (h <= BRANCH))
        fine &= (now != sign[rows]) | ~jump
        fine &= _smooth(h, u[rows], new, turn[rows], after)
        for i in np.flatnonzero(fine & (now != sign[rows])):
            row = rows[i]
            line = replace(lines, start=start[row], turn=lines.turn[row])
            fine[i] = _crosses(line, (u[row] + new[i]) / 2, t[row] + h[i] / 2, h[i])
        done = rows[fine]
        left[done] = _left(h, large, size[rows])[fine]
        size[done] = large[fine]
        u[done], t[done], sign[done], turn[done] = (v[fine] for v in (new, following, now, after))
        jumped[done] = False
        failed = rows[~fine & ~jump]
        step[failed] *= SHORTER
        patience[failed] = 2
        step[done] = np.where(patience[done] > 0, h[fine], 2 * h[fine])
        patience[done] = np.maximum(patience[done] - 1, 0)
    return Followed(u, t)


def _sign(slope: Floats) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Sign of each determinant, and the logarithm of its size."""
    with np.errstate(all="ignore"):
        sign, size = np.linalg.slogdet(slope)
    finite = np.isfinite(slope).all(axis=(1, 2))
    return np.where(finite, sign, 0.0), np.where(finite, size, -np.inf)


def _left(h: Any, now: Floats, before: Floats) -> Floats:
    """Way over which a determinant that shrank over h goes on to zero; infinite if it grew."""
    with np.errstate(all="ignore"):
        ratio = np.exp(before - now)
        return np.where(ratio > 1, h / (ratio - 1), np.inf)


def _smooth(h: Floats, u: Floats, new: Floats, turn: Floats, after: Floats) -> NDArray[np.bool_]:
    """Whether tangents before and after a step fit one smooth curve, unknown by unknown.

    The tangent of a square root meets zero at twice the distance of the branch point: there the
    predictor is exact on the other branch, and nothing but the tangents tells the two apart.
    """
    with np.errstate(all="ignore"):
        bend = np.abs(after - turn)
        fits = bend <= BEND * np.maximum(np.abs(after), np.abs(turn))
        fits |= h[:, None] * bend <= SLIGHT * np.maximum(np.abs(new), np.abs(u))
        fits |= h[:, None] * bend <= SETTLED * (1 + np.abs(new).max(axis=1, keepdims=True))
    return np.asarray(fits.all(axis=1))


def _corrected(
    lines: Curve, rows: NDArray[np.intp], u: Floats, t: Floats
) -> tuple[Floats, NDArray[np.bool_], tuple[Floats, Floats]]:
    """Newton's method from a prediction; whether it contracts fast; slopes at its result."""
    sizes = []
    for _ in range(3):
        r, slope, along = _at(lines, rows, u, t)
        correction = solved(slope, r)
        with np.errstate(all="ignore"):
            sizes.append((np.abs(correction) / (1 + np.abs(u))).max(axis=1))
            u = u - correction
    first, second, third = sizes
    fine = (first <= FIRST) & (second <= np.maximum(CONTRACTION * first, SETTLED))
    fine &= np.isfinite(u).all(axis=1) & (third <= np.maximum(CLOSE * first, SETTLED))
    return u, fine, (slope, along)


UNKNOWN = 1e-10
"""Largest rate that counts as zero, in units of the linearisation, if its rounding has no bound."""

NEXT = 1e-4
"""Longest way from the end of a line to the fold or branch point that ended it, as a share."""
LAST = 1e-2
"""Largest correction of an unknown at the end of a line, relative to 1 or to the unknown."""
THIRD = 1e-6
"""Largest correction after three Newton steps there."""
CROSSES = (
    ", where another branch crosses; branch lists this point in branch_points, and its switch "
    "follows the other branch"
)
BEYOND = {
    "cusp": ", through which this line runs: lines on one side of it go on, and those on the other "
    "end at a fold; take a known member from which the line does not meet it",
    "fold": ", where this branch turns; branch with arclength=True goes round it",
    "pitchfork": CROSSES,
    "transcritical point": CROSSES,
    "branch point": CROSSES,
}
"""What is on the other side of each singular point, and how to get there."""
STEEP = ", where it changes too fast to follow; a known member closer by may reach it"
"""The same where no singular point is resolved."""


class FamilyRoots(NamedTuple):
    """Unknowns row by row, and where there are none."""

    u: Floats
    """Unknowns, shape (N, u); of no meaning where not good."""
    good: NDArray[np.bool_]
    """Whether a member was found, shape (N,)."""
    why: Callable[[int], str]
    """The sentence that says why a row has no member."""


def find(family: Any, a: Floats, q: Floats, start: Floats | None) -> FamilyRoots:
    """The unknowns of each row, from first guesses or from the family's known member.

    Parameters
    ----------
    family
        A `Family` with unknowns and a root-finder.
    a, q
        Family parameters and parameters, shapes (N, ·).
    start
        First guesses, shape (N, u); None to follow from the family's anchor.
    """
    # members that differ only in numbers outside the equations (mu, for the disk) share a root
    numbers = np.hstack([a, q])
    key = (
        numbers[:, family.graph.used]
        if start is None
        else np.hstack([numbers[:, family.graph.used], start])
    )
    inverse = np.arange(len(key))
    unused = np.setdiff1d(np.arange(numbers.shape[1]), family.graph.used)
    if len(key) > 1 and (numbers[:, unused] != numbers[:1, unused]).any():
        inverse = np.unique(key, axis=0, return_inverse=True)[1].ravel()
    first = np.zeros(inverse.max(initial=-1) + 1, dtype=int)
    first[inverse] = np.arange(len(a))
    positive = [i for i, name in enumerate(family.unknown) if name in family.positive]
    if start is None:
        members = _followed(family, a[first], q[first], positive)
    else:
        u, good = _rooted(family, a[first], q[first], start[first], positive)
        members = FamilyRoots(u, good, lambda row: _unreached(family, a[first][row], q[first][row]))
    return FamilyRoots(
        members.u[inverse], members.good[inverse], lambda row: members.why(inverse[row])
    )


def _rooted(
    family: Any, a: Floats, q: Floats, start: Floats, positive: Sequence[int]
) -> tuple[Floats, NDArray[np.bool_]]:
    """Roots next to those of the family's formulas; where it has none, next to first guesses."""
    u, good, left = start.copy(), np.zeros(len(a), dtype=bool), np.ones(len(a), dtype=bool)
    guessed = family.formulas.guess(a, q) if family.formulas is not None else None
    if guessed is not None:
        near, lacking = guessed
        some = np.flatnonzero(np.isfinite(near).all(axis=1) & ~lacking)
        if len(some):
            u[some] = near[some]
            good[some] = accepted(family.graph, a[some], u[some], q[some], positive)
        left = ~good & ~lacking
    rows = np.flatnonzero(left)
    if len(rows):
        u[rows], good[rows] = roots(family.graph, a[rows], q[rows], u[rows], positive)
    return u, good


def _unreached(family: Any, a: Floats, q: Floats) -> str:
    return (
        f"{family.name} has no member that the root-finder reaches at "
        f"{listing((*family.at, *family.parameters), (*a, *q))}: the equation for "
        f"{', '.join(family.unknown)} has no admissible isolated solution there; "
        "choose another point of the family or give a guess."
    )


def _followed(family: Any, a: Floats, q: Floats, positive: Sequence[int]) -> FamilyRoots:
    """Members on the smooth sheet of the anchor, each along a straight line."""
    numbers, anchor = np.hstack([a, q]), family.anchor
    start = np.tile(anchor.given, (len(a), 1)), np.tile(anchor.unknown, (len(a), 1))
    # each row from the anchor itself: a member next to another may lie beyond the end of the sheet
    u, good, share = _ended(family.graph, a.shape[1], (*start, numbers), positive)
    return FamilyRoots(
        u, good, lambda row: _stopped(family, numbers[row], u[row], share[row], positive)
    )


def _ended(
    graph: FamilyGraph, cut: int, line: tuple[Floats, Floats, Floats], positive: Sequence[int]
) -> tuple[Floats, NDArray[np.bool_], Floats]:
    """Members at the ends of lines, polished; whether each was reached; shares of the lines."""
    start, u, stop = line
    members, share = follow(graph, cut, start, u, stop)
    good = share == 1
    if good.any():
        a, q, near = stop[good][:, :cut], stop[good][:, cut:], members[good]
        steps = []
        for _ in range(3):  # the last correction on the way need not be small
            steps.append(newton_step(graph, a, near, q))
            near = near - np.where(np.isfinite(steps[-1]), steps[-1], 0.0)
        size = 1 + np.abs(near)
        way = [np.abs(s / size).max(axis=1) for s in steps]
        fine = (way[0] <= LAST) & (way[1] <= way[0] / 4 + THIRD) & (way[2] <= way[1] / 4 + THIRD)
        polished, root = roots(graph, a, q, near, positive)
        # the polish moves by rounding alone, or it went to another root
        fine &= root & (np.abs(polished - near) <= THIRD * size).all(axis=1)
        members[good] = np.where(fine[:, None], polished, near)
        good[good] = fine
    return members, good, share


def _stopped(family: Any, asked: Floats, u: Floats, share: float, positive: Sequence[int]) -> str:
    """The sentence that says where continuation stopped."""
    names = (*family.at, *family.parameters)
    anchor = family.anchor.given
    moved = [i for i in family.graph.used if asked[i] != anchor[i]] or list(range(len(names)))
    stop = anchor + share * (asked - anchor)
    place, start = (listing([names[i] for i in moved], p[moved]) for p in (stop, anchor))
    wrong = [n for i, n in enumerate(family.unknown) if i in positive and not u[i] > 0]
    if share == 1 and wrong:
        return f"{family.name} has no member at {place}: {wrong[0]} is not positive there."
    curve = Curve(family.graph, len(family.at), anchor, asked - anchor)
    point = singular_point(curve, np.array([*u, share]), NEXT)
    what, beyond = "", STEEP if share < 1 else ""
    if point is not None:
        what, beyond, share = f"a {point[0]} at ", BEYOND[point[0]], float(point[1].z[-1])
    stop = anchor + share * (asked - anchor)
    stop[np.abs(stop) < 1e-12 * np.abs(asked - anchor)] = 0.0
    return (
        f"{family.name} has no member at "
        f"{listing([names[i] for i in moved], asked[moved])} that continuation from {start} "
        f"reaches: it stopped at {what}{listing([names[i] for i in moved], stop[moved])}"
        f"{beyond}."
    )


def check_states(family: Any) -> None:
    """Refuse a family that does not name each state of its system once.

    Raises
    ------
    ParameterError, NameUnknownError
        If a name is unknown, a state is missing or named twice, or the equations are not as many
        as the unknowns.
    """
    system, whose = family.system, f"family {family.name}"
    for name in family.unknown:
        known("an unknown", name, (*system.states, *system.parameters))
        if name in family.at:
            raise ParameterError(f"{shown(name)} of {whose} is in at and unknown; name it once.")
    for name in (*family.held, *family.equations):
        seen = system.observables.get(name) if name in family.equations else None
        if seen is None or seen.shape != (1, 1):
            system.index(name)
    for name in family.at:
        if name not in (*system.states, *system.parameters):
            raise NameUnknownError(
                f"at is {shown(name)}, neither a state nor a parameter of {system.name}."
            )
    labels = family.named
    for state in system.states:
        if labels.count(state) != 1 and (state in labels or state not in family.left_out):
            raise ParameterError(
                f"state {shown(state)} of {whose} is given {labels.count(state)} "
                "times; name each state once, in at, held or unknown."
            )
    if len(family.unknown) != len(family.equations):
        raise ParameterError(
            f"{whose} has {len(family.unknown)} unknowns and {len(family.equations)} "
            "equations; give as many of one as of the other."
        )
