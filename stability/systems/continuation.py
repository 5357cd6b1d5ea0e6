"""Continuation: a family followed along its parameter, round folds, and onto crossing branches."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..base.checks import flag, instance, one_number, whole_number
from ..base.citation import cited
from ..base.errors import NoMemberError, ParameterError
from ..base.printing import html_table
from ..base.types import Floats, Record, TupleRecord
from .family import A_FAMILY, Family
from .members import follow
from .singular_points import (
    FLAT,
    Curve,
    Located,
    crossings,
    directions,
    kind_of_crossing,
    locate_branch_point,
    locate_fold,
    singular_point,
)
from .system_checks import numbers_of


@dataclass(frozen=True, eq=False)
class SingularPoint(Record):
    """A point of a branch where the equations of members lose rank."""

    value: float
    """Family parameter, in the unit of that parameter."""
    state: Floats
    """State there, shape (n,)."""
    error: float
    """Last step of Newton's method in the parameter; half the last bracket if not resolved."""


@dataclass(frozen=True, eq=False)
class Fold(SingularPoint):
    """A turning point of a branch: no member lies beyond it nearby.

    Source: continuation as in E. L. Allgower & K. Georg (1990); closed forms: tests/systems.

    Examples
    --------
    >>> import stability as st
    >>> import casadi as ca
    >>> x, p = ca.SX.sym("x"), ca.SX.sym("p")
    >>> s = st.System("f", x, p, p - x**2, states=("x",), parameters=("p",))
    >>> up = st.Family(s, "up", at=("p",), unknown={"x": 1.0}, equations=("x",))
    >>> abs(st.branch(up, 1, -1, [], points=11).folds[0].value) < 1e-9
    True
    """

    resolved: bool
    """Whether the extended system was solved, to rounding."""


LONGEST = 60
"""Most rows of a table."""
LEAST = 1e-9
"""Shortest step, as a share of the longest."""
COSINE = 0.95
"""Least cosine of the angle between the tangents before and after a step."""
CONTRACTION = 0.25
"""Largest ratio of the second correction to the first."""
SETTLED = 1e-11
"""Corrections below this, in scaled coordinates, are rounding."""
APART = 1e-6
"""Step, as a share of the longest, at which a branch point that is not resolved ends the curve."""


class Trace(NamedTuple):
    """Points of a curve in order, and what lies between them."""

    z: Floats
    """Unknowns and parameter, shape (N, u + 1)."""
    folds: list[Located]
    """Folds in order."""
    crossings: list[tuple[Located, Floats]]
    """Branch points in order, each with the tangent of the curve there."""
    ended: str
    """The phrase that says why the curve was left; empty where `inside` said so."""


@dataclass(frozen=True, eq=False)
class Pace:
    """Coordinates scaled by typical sizes, in which steps along a curve are measured."""

    curve: Callable[[Floats], tuple[Floats, Floats]]
    """From a point to residuals and slopes, one row fewer than coordinates."""
    scale: Floats
    """Typical sizes of the coordinates."""

    def at(self, z: Floats) -> tuple[Floats, Floats]:
        """Residuals and scaled slopes."""
        r, slope = self.curve(z)
        return r, slope * self.scale

    def tangent(self, z: Floats, before: Floats) -> tuple[Floats, float] | None:
        """Unit tangent along `before`, and the sign that a branch point changes."""
        _, slope = self.at(z)
        if not np.isfinite(slope).all():
            return None
        tangent = np.linalg.svd(slope)[2][-1]
        tangent = tangent * (1.0 if tangent @ before >= 0 else -1.0)
        return tangent, float(np.linalg.slogdet(np.vstack([slope, tangent]))[0])

    def corrected(self, guess: Floats, tangent: Floats) -> Floats | None:
        """The point of the curve in the plane through a prediction, if it is reached fast."""
        z, sizes = guess, []
        for _ in range(8):
            r, slope = self.at(z)
            right = np.concatenate([r, [tangent @ ((z - guess) / self.scale)]])
            block = np.vstack([slope, tangent])
            if not (np.isfinite(block).all() and np.isfinite(right).all()):
                return None
            try:
                step = np.linalg.solve(block, right)
            except np.linalg.LinAlgError:
                return None
            z = z - step * self.scale
            sizes.append(float(np.abs(step).max()))
            if len(sizes) > 1 and sizes[-1] <= SETTLED * (1 + float(np.abs(z / self.scale).max())):
                return z if sizes[1] <= max(CONTRACTION * sizes[0], SETTLED) else None
        return None


def walk(
    curve: Curve,
    z: Floats,
    tangent: Floats,
    scale: Floats,
    longest: float,
    most: int,
    inside: Callable[[Floats], bool],
) -> Trace:
    """Follow a curve from a point in a direction, until it leaves a region.

    Parameters
    ----------
    curve
        The curve.
    z, tangent
        A point of the curve and a direction, shapes (u + 1,).
    scale
        Typical sizes of unknowns and parameter; steps are measured in them.
    longest
        Longest step.
    most
        Most points.
    inside
        Whether to go on after a point; the point that is outside is the last one.
    """

    def single(z: Floats) -> tuple[Floats, Floats]:
        r, slope = (v[0] for v in curve.at(z[None]))
        return r, slope

    pace = Pace(single, scale)
    points = [z]
    folds: list[Located] = []
    crossings: list[tuple[Located, Floats]] = []
    before = pace.tangent(z, tangent / scale / np.linalg.norm(tangent / scale))
    if before is None:
        return Trace(np.array(points), [], [], "the equations have no meaning there")
    (along, sign), step = before, longest

    def ended(said: str) -> Trace:
        return Trace(np.array(points), folds, crossings, said)

    while len(points) < most:
        if step < LEAST * longest:
            return ended("the corrector fails there")
        # in the parameter at most `longest`; in large unknowns more, in proportion
        room = longest * max(1.0, float(np.abs(z[:-1] / scale[:-1]).max()))
        step = min(step, room, longest / max(abs(float(along[-1])), 1e-300))
        new = pace.corrected(z + step * along * scale, along)
        following = pace.tangent(new, along) if new is not None else None
        if new is None or following is None or following[0] @ along < COSINE:
            step /= 2
            continue
        after, now = following
        if now != sign:
            point = locate_branch_point(curve, (z + new) / 2)
            near = float(np.abs((point.z - (z + new) / 2) / scale).max()) <= step
            if not (point.resolved and near):
                if step <= APART * longest:
                    return ended(
                        "a branch point, or a narrow gap between two branches, is not resolved"
                    )
                step /= 2
                continue
            crossings.append((point, along * scale))
        elif along[-1] * after[-1] < 0:
            folds += _fold_between(curve, z, new, (along[-1], after[-1]), scale, step)
        z, along, sign = new, after, now
        points.append(z)
        if not inside(z):
            return ended("")
        way = np.abs((z - points[0]) / scale).max()
        if len(points) > 3 and way < 0.6 * step and along @ before[0] > COSINE:
            return ended("the branch closes on itself")
        step = 2 * step
    return ended(f"{most} members were found")


def _fold_between(
    curve: Curve, z: Floats, new: Floats, parts: tuple[float, float], scale: Floats, step: float
) -> list[Located]:
    """The fold between two points, where the tangent's parameter changes sign."""
    share = parts[0] / (parts[0] - parts[1])
    guess = z + share * (new - z)
    fold = locate_fold(curve, guess)
    if fold.resolved and np.abs((fold.z - guess) / scale).max() <= step:
        return [fold]
    return [Located(guess, np.abs(new - z), False, fold.left)]


MOST_POINTS = 100_000
"""Largest number of members of a branch, since each one is solved for."""
LONGER = 20
"""Most members round folds, as a multiple of `points`."""
LEAVE = 1e-3
"""First step onto a crossing branch, as a share of the interval."""


@dataclass(frozen=True, eq=False)
class BranchPoint(SingularPoint):
    """A static boundary on a branch: another branch of members crosses it there.

    Source: continuation as in E. L. Allgower & K. Georg (1990); closed forms: tests/systems.

    Examples
    --------
    >>> import stability as st
    >>> import casadi as ca
    >>> x, p = ca.SX.sym("x"), ca.SX.sym("p")
    >>> s = st.System("f", x, p, p * x - x**3, states=("x",), parameters=("p",))
    >>> rest = st.Family(s, "rest", at=("p",), unknown={"x": 0.0}, equations=("x",))
    >>> st.branch(rest, -1, 1, [], points=11).branch_points[0].kind
    'pitchfork'
    """

    kind: str
    """`pitchfork`, `transcritical`, or `unresolved`, where neither direction leads along `at`."""
    own: Floats = field(repr=False)
    """Direction of the branch itself in (unknowns, parameter), shape (u + 1,)."""
    other: Floats | None = field(repr=False)
    """Direction of the crossing branch, shape (u + 1,); None where unresolved."""
    _line: _Line = field(repr=False)
    _z: Floats = field(repr=False)

    def switch(self, stop: float, *, points: int = 101, side: int = 1) -> Branch:
        """Follow the crossing branch from here.

        Parameters
        ----------
        stop
            Value of the family parameter at which to stop.
        points
            As for `branch` with arclength.
        side
            1 or -1: for a pitchfork, the sign of the largest unknown's change along the branch.

        Returns
        -------
        Branch

        Raises
        ------
        ParameterError, NoMemberError
            If the other branch is not resolved, or the first step onto it fails.

        Examples
        --------
        >>> import casadi as ca, stability as st
        >>> x, p = ca.SX.sym("x"), ca.SX.sym("p")
        >>> system = st.System("pitchfork", x, p, p * x - x**3, states=("x",), parameters=("p",))
        >>> rest = st.Family(system, "rest", at=("p",), unknown={"x": 0.0}, equations=("x",))
        >>> [point] = st.branch(rest, -1, 1, [], points=11).branch_points
        >>> point.kind, abs(point.value) < 1e-12, point.switch(1.0).state[-1].round(12)
        ('pitchfork', True, array([1.]))
        """
        points = whole_number("points", points, 2, MOST_POINTS, "follow a longer branch in pieces")
        end = one_number("stop", stop)
        if side not in (1, -1):
            raise ParameterError(f"side is {side!r}; give 1 or -1.")
        if self.other is None:
            raise ParameterError(
                f"the branch that crosses {self._line.family.name} at {self.value:g} is not "
                "resolved."
            )
        if end == self.value:
            raise ParameterError(f"stop is {end:g}, the branch point itself; take another.")
        return self._line.switched(self, end, points, side)


class _Members(NamedTuple):
    at: Floats
    """Family parameter, shape (n,)."""
    state: Floats
    """State of each member, shape (n, states)."""
    complete: bool
    """Whether the whole interval was reached."""
    ended: str
    """A sentence that says where and why the branch ended."""
    folds: tuple[Fold, ...] = ()
    """Turning points in order; without arclength the one that ended the branch."""
    branch_points: tuple[BranchPoint, ...] = ()
    """Points between two members at which another branch crosses, in order."""
    citation: str = ""
    """Keys of the works to cite, for `stability.citation`."""
    names: tuple[str, ...] = ()
    """Names of the number along the branch and of the states."""


class Branch(TupleRecord, _Members):
    """A run of members found by continuation along `at`.

    Source: continuation as in E. L. Allgower & K. Georg (1990); closed forms: tests/systems.

    Examples
    --------
    >>> import stability as st
    >>> import casadi as ca
    >>> x, p = ca.SX.sym("x"), ca.SX.sym("p")
    >>> s = st.System("f", x, p, p * x - x**3, states=("x",), parameters=("p",))
    >>> rest = st.Family(s, "rest", at=("p",), unknown={"x": 0.0}, equations=("x",))
    >>> st.branch(rest, -1, 1, [], points=11).complete
    True
    """

    __slots__ = ()

    def __repr__(self) -> str:
        ends = f" from {self.at[0]:.6g} to {self.at[-1]:.6g}" if len(self.at) else ""
        words = "complete" if self.complete else f"ended: {self.ended.rstrip('.')}"
        counts = {"fold": len(self.folds), "branch point": len(self.branch_points)}
        said = [f"{n} {name}{'s' * (n != 1)}" for name, n in counts.items() if n]
        return f"<Branch of {len(self.at)} members{ends}: {', '.join([words, *said])}>"

    def _repr_html_(self) -> str:
        names = self.names or ("at", *(f"state {i}" for i in range(self.state.shape[-1])))
        rows = np.column_stack([self.at, self.state])[:LONGEST]
        cells = [[f"{value:.6g}" for value in row] for row in rows]
        left = len(self.at) - len(rows)
        foot = f"and {left} more members" if left else ""
        return html_table(repr(self)[1:-1], names, cells, foot)


def branch(
    family: Family,
    start: float,
    stop: float,
    parameters: Any = (),
    *,
    points: int = 101,
    guess: ArrayLike | None = None,
    fixed: Any = (),
    arclength: bool = False,
    **named: float,
) -> Branch:
    """Follow a family along its first `at`: tangent predictor, Newton's method as corrector.

    Parameters
    ----------
    family
        The family.
    start, stop
        Interval of the first family parameter; either may be the larger.
    parameters
        The system's other parameters, shape (m,), or by name.
    points
        Number of members, evenly spaced.  With arclength: members lie no farther apart than with
        so many, both in the parameter and, in their own size, in the unknowns.
    guess
        First guess of the unknowns at `start`, shape (u,); the family's guess when left out.
    fixed
        Values of the further family parameters, if the family has more than one; or by name.
    arclength
        Whether to go round folds, until the branch reaches `stop`, returns to `start`, or closes.
    **named
        Parameters and further family parameters by name, in place of `parameters` and `fixed`.

    Returns
    -------
    Branch
        Members up to `stop`, or up to the point where the branch ended.

    Raises
    ------
    ParameterError, NoMemberError
        If there are fewer than two points, or there is no member at `start`.

    Source: closed forms in tests/systems/test_continuation.py.

    Examples
    --------
    >>> import stability as st
    >>> run = st.branch(st.disk_family("tumbling", "viscous"), 1.5, 0.1, k=0.25, mu=0.3, points=5)
    >>> run.complete, float(run.state[0, 2].round(6))
    (True, 2.00251)
    """
    instance("family", family, Family, A_FAMILY)
    if not family.at:
        raise ParameterError(f"{family.name} has one member alone, and no branch.")
    points = whole_number("points", points, 2, MOST_POINTS, "follow a longer branch in pieces")
    lo, hi = one_number("start", start), one_number("stop", stop)
    rest, q = numbers_of(family, fixed, parameters, named)
    u = family.solve(np.array([[lo, *rest]]), q[None], guess)
    curve = Curve(
        family.graph, len(family.at), np.array([0.0, *rest, *q]), np.eye(len(rest) + len(q) + 1)[0]
    )
    line = _Line(family, curve)
    if not flag("arclength", arclength) or not family.unknown or lo == hi:
        return line.members(lo, hi, u, points)
    if family.closed:
        raise ParameterError(
            f"{family.name} is known in closed form and has no folds; leave arclength out."
        )
    z = np.array([*u[0], lo])
    _, slope = curve.at(z[None])
    tangent = np.linalg.svd(slope[0])[2][-1]
    tangent *= np.copysign(1.0, tangent[-1] * (hi - lo))
    return line.arc(z, tangent, lo, hi, points)


@dataclass(frozen=True, eq=False)
class _Line(Record):
    """A family along its first parameter, with the curve of its unknowns and that parameter."""

    family: Family
    curve: Curve

    # --- evenly spaced members ---

    def members(self, lo: float, hi: float, u: Floats, points: int) -> Branch:
        """Evenly spaced members, up to the first that is not reached."""
        places = [np.array([*u[0], lo])]
        ended, complete = f"the whole interval from {lo:g} to {hi:g} was reached", True
        folds: list[Located] = []
        last: list[tuple[Located, Floats]] = []
        for target in np.linspace(lo, hi, points)[1:]:
            try:
                following, reached = self._next(places[-1], float(target))
                if not reached:  # from a branch point itself no way leads on
                    again, reached = self._next(places[-2:][0], float(target))
                    if reached or (following == places[-1]).all():
                        following = again
            except NoMemberError as error:
                complete, ended = False, f"ended after {places[-1][-1]:g}: {error}"
                break
            if not reached:
                before = places[-1] if (places[-1] != following).any() else places[-2:][0]
                where, folds, last = self._stop(before, following)
                complete, ended = False, f"ended after {places[-1][-1]:g}: {where}"
                break
            places.append(following)
        z = np.array(places)
        return self._branch(z, complete, ended, folds, [*crossings(self.curve, z), *last])

    def _next(self, z: Floats, target: float) -> tuple[Floats, bool]:
        """The member at the next value, on the smooth sheet of the last, or where that ends."""
        family, (a, q) = self.family, self._numbers(target)
        if not family.unknown or family.closed:
            return np.array([*family.solve(a, q)[0], target]), True
        here = self.curve.given(z[None])
        reached = follow(family.graph, a.shape[1], here, z[None, :-1], np.hstack([a, q]))
        if reached.share[0] < 1:
            place = z[-1] + float(reached.share[0]) * (target - z[-1])
            return np.array([*reached.u[0], place]), False
        return np.array([*family.solve(a, q, reached.u)[0], target]), True

    def _stop(
        self, z: Floats, end: Floats
    ) -> tuple[str, list[Located], list[tuple[Located, Floats]]]:
        """What ended a branch: words, and the fold or the branch point there."""
        name, way = self.family.at[0], end - z
        point = singular_point(self.curve, end, 1e-3 * (abs(way[-1]) + 1e-300))
        if point is None:
            said = "has no member that continuation reaches beyond"
            return f"{self.family.name} {said} {name} = {end[-1]:.10g}", [], []
        word, located = point
        said = f"a {word} at {name} = {located.z[-1]:.10g}"
        if word == "fold":
            return said, [located], []
        return said, [], [] if word == "cusp" else [(located, way)]

    # --- round folds ---

    def arc(self, z: Floats, tangent: Floats, lo: float, hi: float, points: int) -> Branch:
        """Members by arclength, within the interval."""
        trace = self._walked(z, tangent, _scale(z, abs(hi - lo)), (lo, hi), points)
        members, ended, complete = trace.z, self._left(trace), False
        if not trace.ended:
            members, ended, complete = self._landed(trace, lo, hi)
        return self._branch(members, complete, ended, trace.folds, trace.crossings)

    def switched(self, point: BranchPoint, stop: float, points: int, side: int) -> Branch:
        """Leave a branch point along the crossing branch."""
        other, here = point.other, point._z
        assert other is not None
        width = abs(stop - point.value)
        flat = abs(other[-1]) <= FLAT
        lead = int(np.argmax(np.abs(other[:-1]))) if flat else -1
        wanted = side if flat else np.sign(stop - point.value)
        tangent = other * np.copysign(1.0, other[lead] * wanted)
        scale = _scale(here, width)
        first = here + LEAVE / float(np.linalg.norm(tangent / scale)) * tangent
        ends = point.value - width, point.value + width
        trace = self._walked(first, tangent, scale, ends, points)
        if len(trace.z) < 2:
            raise NoMemberError(
                f"{self.family.name}: the crossing branch at {point.value:g} is left at once; "
                f"{trace.ended}."
            )
        # the first point is a prediction, and the branch point takes its place
        trace = trace._replace(z=np.vstack([here, trace.z[1:]]))
        z, ended, complete = trace.z, self._left(trace), False
        if not trace.ended:
            z, ended, complete = self._landed(trace, 2 * point.value - stop, stop)
            ended = f"the whole interval from {point.value:g} to {stop:g} was reached"
            if not complete:
                ended = f"the branch runs the other way, from {point.value:g} to {z[-1, -1]:g}"
        return self._branch(z, complete, ended, trace.folds, trace.crossings)

    def _walked(
        self, z: Floats, tangent: Floats, scale: Floats, ends: tuple[float, float], points: int
    ) -> Trace:
        """The curve from a point until it leaves an interval, or an unknown is not positive."""
        low, high = sorted(ends)
        family = self.family
        positive = [i for i, n in enumerate(family.unknown) if n in family.positive]
        return walk(
            self.curve,
            z,
            tangent,
            scale,
            1 / (points - 1),
            LONGER * points,
            lambda y: bool(low < y[-1] < high and (y[positive] > 0).all()),
        )

    def _left(self, trace: Trace) -> str:
        return f"ended at {self.family.at[0]} = {trace.z[-1, -1]:.6g}: {trace.ended}"

    def _landed(self, trace: Trace, lo: float, hi: float) -> tuple[Floats, str, bool]:
        """The members with the last one moved back to the end of the interval."""
        before, last = trace.z[-2], trace.z[-1]
        low, high = min(lo, hi), max(lo, hi)
        if low < last[-1] < high:
            return (
                trace.z[:-1],
                f"ended at {before[-1]:g}: an unknown is not positive beyond",
                False,
            )
        end = low if last[-1] <= low else high
        share = (end - before[-1]) / (last[-1] - before[-1])
        guess = (before + share * (last - before))[None, :-1]
        try:
            u = self.family.solve(*self._numbers(end), guess)[0]
        except NoMemberError as error:
            return trace.z[:-1], f"ended after {before[-1]:g}: {error}", False
        if not np.abs(u - guess).max() <= 0.1 * (1 + np.abs(guess)).max():
            return trace.z[:-1], f"ended after {before[-1]:g}: the last step is not reached", False
        members = np.vstack([trace.z[:-1], [*u, end]])
        if end == hi:
            return members, f"the whole interval from {lo:g} to {hi:g} was reached", True
        return members, f"the branch turned and came back to {lo:g}", False

    # --- records ---

    def _numbers(self, value: float) -> tuple[Floats, Floats]:
        """Family parameters and parameters at a value of the first family parameter."""
        numbers = self.curve.given(np.array([[value]]))
        return numbers[:, : self.curve.cut], numbers[:, self.curve.cut :]

    def _states(self, z: Floats) -> Floats:
        family, cut, numbers = self.family, self.curve.cut, self.curve.given(z)
        states = family.states(numbers[:, :cut], z[:, :-1], numbers[:, cut:])
        # where the guess is exact, the family itself knows no other unknowns
        for name, column in zip(family.unknown, z.T, strict=False):
            if name in family.system.states:
                states[:, family.system.index(name)] = column
        return states

    def _point(self, located: Located) -> tuple[float, Floats, float]:
        """Family parameter, state and error of a singular point."""
        return float(located.z[-1]), self._states(located.z[None])[0], float(located.step[-1])

    def _branch_point(self, located: Located, tangent: Floats) -> BranchPoint:
        """A branch point; the more parallel one of its directions is the branch's."""
        along, other = tangent / np.linalg.norm(tangent), None
        both = directions(self.curve, located) if located.resolved else None
        if both is not None:
            mine = int(np.argmax(np.abs(both @ along)))
            along, other = both[mine], both[1 - mine]
        kind = kind_of_crossing(both)
        return BranchPoint(*self._point(located), kind, along, other, self, located.z)

    def _branch(
        self,
        z: Floats,
        complete: bool,
        ended: str,  # noqa: FBT001
        folds: Sequence[Located],
        crossings: Sequence[tuple[Located, Floats]],
    ) -> Branch:
        turned = tuple(Fold(*self._point(f), f.resolved) for f in folds)
        crossed = tuple(self._branch_point(p, t) for p, t in crossings)
        system = self.family.system
        works = cited(system=system.name, model=bool(system.quantities))
        names = (self.family.at[0], *system.states)
        return Branch(z[:, -1], self._states(z), complete, ended, turned, crossed, works, names)


def _scale(z: Floats, width: float) -> Floats:
    """Typical sizes of the unknowns at a point, and the width of the interval."""
    return np.array([*np.maximum(np.abs(z[:-1]), 1.0), width])
