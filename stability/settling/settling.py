"""Settling: the steady motions nearest to states, and which of the states settle on them.

A state has settled where it lies within a distance of a family and its motion is proved to converge
to one member.  A slow passage near an unstable member is not settling: nothing attracts there.  A
body, a disk and a system differ by their families alone (`line.py`).

A tube belongs to a member that one number names, and all launches near it share it (`tube.py`).
Where no tube is proved about a member, or none is known, a box about the state is tried (`box.py`).

`Settling.many` is the definition, of one state and of many; launches, basins and scenes ask it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np
from numpy.typing import NDArray

from ..base.errors import StabilityError
from ..base.types import Floats
from .box import Balls, Settled, attraction, boxes, nothing, tapes
from .line import FamilyLine, Near, nearest
from .surroundings import NOT_PROVED, Surroundings
from .tube import in_tube

SETTLE = 1e-3
"""Largest distance from a steady motion, dimensionless, at which a motion counts as settled: the
default of launches, basins and scenes.  No eye sees such a distance; its convergence is proved."""
NONE = -1
"""Number of no family."""


def is_close(distance: Floats, within: float | Floats) -> NDArray[np.bool_]:
    """Whether distances from steady motions are so small that states there can have settled."""
    return np.asarray(distance <= within)


def last_outside(distance: Floats, within: float) -> int:
    """The last of some samples that is not close; -1 for none."""
    outside = np.flatnonzero(~is_close(distance, within))
    return int(outside[-1]) if outside.size else -1


def settled(  # noqa: PLR0913
    around: Surroundings,
    y: Balls,
    arguments: Floats,
    e: Balls,
    *,
    alone: bool = False,
    plain: bool = False,
) -> Settled:
    """Which launches are proved to converge to one steady motion of a family.

    Parameters
    ----------
    around
        The family's surroundings.
    y, e
        Parameters of the nearest members and deviations, as balls that contain the true values,
        shapes (launches, n) and (launches, m).
    arguments
        Second argument of its programs, shape (launches, ·).
    alone
        Whether boxes are tried one by one in flint's balls.  One launch is then soonest done.
    plain
        Whether NumPy does the work although Numba is installed.

    Returns
    -------
    Settled

    Examples
    --------
    >>> import stability as st
    >>> from stability.settling.body_lines import disk_settling
    >>> spinning = disk_settling(st.Viscous).lines[1]
    >>> y, e = np.array([[2.5], [1.9]]), np.full((2, 5), 1e-5)
    >>> arguments = np.array([[1, 0.25, 0.3]] * 2)
    >>> settled(spinning.around, Balls(y, 0 * y), arguments, Balls(e, 0 * e)).proved
    array([ True, False])
    """
    result, left = nothing(len(arguments), around.along), np.ones(len(arguments), bool)
    try:
        tapes(around)
        if around.field is not None:
            left = ~_by_tubes(around, y, arguments, e, result)
        if left.any() and not alone:
            boxes(around, y, arguments, e, result, left, plain=plain)
            return result
    except StabilityError:  # a function without a kernel
        pass
    for i in np.flatnonzero(left):
        _alone(around, y, arguments, e, result, int(i))
    return result


def _by_tubes(
    around: Surroundings, y: Balls, arguments: Floats, e: Balls, result: Settled
) -> NDArray[np.bool_]:
    """Which launches are near a member with a tube; those in it are proved."""
    near = np.asarray(np.isfinite(np.hstack([y.mid, arguments, e.mid])).all(1), dtype=bool)
    if not near.any():
        return near
    balls = (y.mid[near, 0], y.rad[near, 0]), (e.mid[near], e.rad[near])
    has_tube, proofs = in_tube(around, balls[0], arguments[near], balls[1])
    result.put(np.flatnonzero(near), proofs)
    near[near] = has_tube
    return near


def _alone(
    around: Surroundings, y: Balls, arguments: Floats, e: Balls, result: Settled, i: int
) -> None:
    """Try the box of one launch in flint's balls."""
    from flint import arb

    member, off = (
        [arb(*v) for v in zip(b.mid[i].tolist(), b.rad[i].tolist(), strict=True)] for b in (y, e)
    )
    proof = attraction(around, arguments[i].tolist(), member, off)
    if proof is not None:
        result.proved[i], result.limit[i] = True, proof.limit
        result.error[i], result.rate[i], result.reach[i] = proof.error, proof.rate, proof.reach


@dataclass(frozen=True)
class Nearest:
    """The steady motion nearest to a state, and whether the state has settled on it."""

    family: str
    """Name of its family; empty where no family was given, or none has a member there."""
    at: float
    """First of the states that name the member; 0 where it stands alone, nan where none is near."""
    distance: float
    """Norm of the deviation; infinite where there is no member."""
    settled: bool
    """Whether the state counts as settled."""
    reach: float
    """Size of the box across the family in which convergence is proved; 0 where it is not."""
    evidence: str
    """Evidence, in one sentence."""
    limit: float = np.nan
    """First of the numbers that name the steady motion that is converged to; nan where none."""
    error: float = np.nan
    """Bound on the error of the limit; nan where convergence is not proved."""
    place: Callable[[], Floats | None] = lambda: None
    """Gives `member`."""

    @cached_property
    def member(self) -> Floats | None:
        """The states of the steady motion; None where they are not known."""
        return self.place()


NOWHERE = Nearest("", np.nan, np.inf, False, 0.0, "")
"""What is nearest where nothing is sought."""


@dataclass(frozen=True, eq=False)
class NearestMany:
    """The steady motions nearest to many states, and which of the states have settled."""

    names: tuple[str, ...]
    """Names of the families."""
    family: NDArray[np.int64]
    """Number of the nearest family among `names`, shape (launches,); `NONE` for none."""
    distance: Floats
    """Distances from the nearest members, shape (launches,)."""
    close: NDArray[np.bool_]
    """Which distances are within the limit, so that a proof was tried."""
    settled: Settled
    """Proofs; `limit` has as many columns as any family has states y that name a member."""
    near: tuple[Near, ...]
    """The nearest members of each family."""
    states: Floats
    """The states, as the families name them, shape (launches, s)."""
    p: Floats
    """The parameters, shape (launches, ·)."""

    @property
    def at(self) -> Floats:
        """States y that name the nearest members, in the columns of `settled.limit`."""
        at = np.full(self.settled.limit.shape, np.nan)
        for number, near in enumerate(self.near):
            mine = self.family == number
            at[mine, : near.y.shape[1]] = near.y[mine]
        return at

    @property
    def limit(self) -> Floats:
        """First of the numbers that name the motion each launch converges to, nan for none."""
        limit = self.settled.limit
        return limit[:, 0] if limit.shape[1] else np.full(len(limit), np.nan)


@dataclass(frozen=True, eq=False)
class Settling:
    """The families of steady motions on which motions of one body or system may settle."""

    lines: tuple[FamilyLine, ...]
    """The families."""
    none: str = "no steady motion is near"
    """What is said where no family has a member."""

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Names of the families."""
        return tuple(line.name for line in self.lines)

    @cached_property
    def idle(self) -> bool:
        """Whether nothing settles on any family."""
        return all(line.idle for line in self.lines)

    def many(
        self,
        states: Floats,
        p: Floats,
        within: float | Floats,
        *,
        alone: bool = False,
        plain: bool = False,
    ) -> NearestMany:
        """The nearest family of each state, and whether its motion is proved to converge there.

        Distances come first, by array operations.  Only states within the limit, near a family on
        which motions settle, meet the proof.

        Parameters
        ----------
        states, p
            States, shape (launches, s), taken as exact; parameters, shape (launches, ·) or (·,).
        within
            Largest distance that counts as settled, shape () or (launches,).
        alone, plain
            As for `stability.settling.settling.settled`.

        Returns
        -------
        NearestMany
        """
        states, count = self.read(states), len(states)
        p = p if p.ndim == 2 else np.broadcast_to(p, (count, len(p)))
        near = nearest(self.lines, states, p)
        apart = np.full((1 + len(near), count), np.inf)  # the first row is that of no family
        for row, member in zip(apart[1:], near, strict=True):
            np.fmin(row, member.distance, out=row)
        family, distance = apart.argmin(axis=0) - 1, apart.min(axis=0)
        whole = nothing(count, max((member.y.shape[1] for member in near), default=0))
        close = is_close(distance, within)
        for number in set(family[close].tolist()) - {NONE}:
            line, member = self.lines[number], near[number]
            if not isinstance(around := line.around, Surroundings):
                continue
            some = (close & (family == number)).nonzero()[0]
            with np.errstate(all="ignore"):
                y, e = line.enclosed(states[some], member.arguments[some], plain=plain or alone)
            proofs = settled(around, y, member.arguments[some], e, alone=alone, plain=plain)
            whole.put(some, proofs)
        return NearestMany(self.names, family, distance, close, whole, tuple(near), states, p)

    def closest(self, state: Floats, p: Floats) -> Nearest:
        """The steady motion nearest to a state; settling is not tested."""
        return self.nearest(state, p, -1.0)

    def nearest(self, state: Floats, p: Floats, within: float) -> Nearest:
        """The steady motion nearest to a state, and whether the state has settled on it."""
        return self.each(state[None], p, within)[0]

    def each(self, states: Floats, p: Floats, within: float) -> list[Nearest]:
        """What is nearest to each of some states, which share all work but proofs by boxes.

        Parameters
        ----------
        states, p, within
            As for `many`; a negative distance asks for no proof.

        Returns
        -------
        list of Nearest
        """
        nearest = self.many(states, p, within, alone=True)
        return [self._in_words(nearest, i, within) for i in range(len(states))]

    def _in_words(self, nearest: NearestMany, i: int, within: float) -> Nearest:
        """What is nearest to one of some launches, in words."""
        number, distance, proof = (
            int(nearest.family[i]),
            float(nearest.distance[i]),
            nearest.settled,
        )
        if number == NONE:
            return replace(NOWHERE, evidence=self.none)
        line, y, done = self.lines[number], nearest.near[number].y[i], bool(proof.proved[i])
        error, called = float(proof.error[i]), line.called(y, nearest.p[i])
        evidence = f"{distance:.3g} from {called}; "
        if line.idle or not nearest.close[i]:
            idle = f"; {line.idle}" if line.idle and within >= 0 else ""
            evidence = f"nearest is {called}, {distance:.3g} away{idle}"
        elif done:
            evidence += line.proved(proof.limit[i, : len(y)], error, float(proof.rate[i]))
        else:
            evidence += line.around if isinstance(line.around, str) else NOT_PROVED
        return Nearest(
            line.name,
            float(y[0]) if len(y) else 0.0,
            distance,
            done,
            float(proof.reach[i]) if done else 0.0,
            evidence,
            float(nearest.limit[i]),
            error,
            partial(self._member, nearest, i),
        )

    def _member(self, nearest: NearestMany, i: int) -> Floats | None:
        """The states of the member that is nearest to one of some launches."""
        line, near = self.lines[number := nearest.family[i]], nearest.near[number]
        row = slice(i, i + 1)
        return self.member(
            line, line.members(nearest.states[row], near.y[row], near.arguments[row])[0]
        )

    def distances(self, states: Floats, p: Floats, near: Nearest) -> Floats:
        """Distances of states, shape (t, s), from the family of a nearest member, shape (t,)."""
        line = next(line for line in self.lines if line.name == near.family)
        p = np.broadcast_to(p, (len(states), np.shape(p)[-1]))
        return np.nan_to_num(line.near(self.read(states), p).distance, nan=np.inf)

    def since(self, states: Floats, p: Floats, near: Nearest, within: float) -> int:
        """The first of the samples of a settled motion from which it stays within the limit."""
        last = last_outside(self.distances(states, p, near), within)
        return min(last + 1, len(states) - 1)

    def read(self, states: Floats) -> Floats:
        """The states as the families name them."""
        return states

    def member(self, line: FamilyLine, states: Floats) -> Floats | None:  # noqa: ARG002
        """The states of a member, as launches are read, from those that the family names."""
        return states


class Watcher:
    """Tries proofs of settling where a launch has come nearer since the last try.

    Parameters
    ----------
    settling
        Steady motions that the launches may settle on.
    report
        Function from the states that are shown to those that a motion reports.
    p
        Parameters of the system, shape (N, m).
    horizon
        Last time of each launch, at which it is tried in any case, shape (N,).
    within
        Largest distance at which a proof is tried.
    """

    def __init__(
        self,
        settling: Settling,
        report: Callable[[Floats], Floats],
        p: Floats,
        horizon: Floats,
        within: float,
    ) -> None:
        self.settling, self.report, self.horizon, self.within = settling, report, horizon, within
        self.p, count = p, len(p)
        self.limit = np.full(count, within)
        self.family = np.full(count, NONE, dtype=np.int8)
        self.member, self.error = np.full(count, np.nan), np.full(count, np.nan)

    def __call__(self, rows: NDArray[np.intp], states: Floats, times: Floats) -> NDArray[np.bool_]:
        """Whether the outcome of each launch is proved."""
        limit = np.where(times < self.horizon[rows], self.limit[rows], self.within)
        nearest = self.settling.many(self.report(states), self.p[rows], limit)
        proved = nearest.settled.proved
        tried = nearest.close
        self.limit[rows[tried]] = (nearest.settled.nearer * nearest.distance)[tried]
        mine = rows[proved]
        self.family[mine], self.error[mine] = nearest.family[proved], nearest.settled.error[proved]
        self.member[mine] = nearest.limit[proved]
        return proved
