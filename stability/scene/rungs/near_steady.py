"""Rungs near a steady motion: the motion at rest there, its linear part, and the second order.

The deviation e from a family member obeys e' = J e + H(e, e)/2 + …  In the modes of J the linear
part is a sum of exponentials, and so is the second order that H drives.  Both are known at any time
at the same cost.  What drives the third order is the defect of the first two in the full equations.
It is sampled, and each mode carries the samples to the time asked for.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import casadi as ca
import numpy as np

from ...algebra.eigensolver import eigenpairs
from ...base.types import Floats
from ...systems.system import System
from .track import Problem, Refused, Track, relative

STEADY, LINEARISED, SECOND = "steady", "linearised", "second-order"
FAR = 0.3
"""Deviation above which a motion is not near its family, over 1 or the size of the state."""
PARALLEL = 1e7
"""Condition number of the modes above which they do not carry a deviation."""
SAMPLES = 48
"""Samples of the third-order defect."""
GROWTH = 30.0
"""Exponent of growth above which no linear motion is small."""
TRUSTED = 0.2
"""Share of the linear deviation up to which the higher orders may be an estimate of its error."""
REACH = 30.0
"""Ratio of a quick bound of the second order to the tolerance above which it is not computed."""


@lru_cache(maxsize=64)
def _slopes(system: System) -> ca.Function:
    """CasADi function (x, p) → J, and the slope of vec J in x."""
    matrix = ca.densify(ca.jacobian(system.rhs, system.x))
    bend = ca.densify(ca.jacobian(ca.vec(matrix), system.x))
    return ca.Function("bend", [system.x, system.p], [matrix, bend])


@dataclass(frozen=True, eq=False)
class Modes:
    """The deviation from a steady motion in the modes of its Jacobian, to second order."""

    system: System
    """The full model's equations."""
    p: Floats
    """Its parameters."""
    member: Floats
    """The steady motion, shape (n,)."""
    family: str
    """Its family."""
    values: Any
    """Eigenvalues, shape (n,)."""
    vectors: Any
    """Modes as columns, shape (n, n)."""
    first: Any
    """Deviation at the start in the modes, shape (n,)."""
    pairs: Any
    """Rate of each mode driven by each pair of modes, shape (n, n, n)."""
    bend: Floats
    """Second derivative of the rates, shape (n, n, n)."""

    def linear(self, times: Floats) -> Any:
        """The linear deviation in the modes, shape (t, n)."""
        return np.exp(np.multiply.outer(times, self.values)) * self.first

    def second(self, times: Floats) -> Any:
        """The deviation of second order in the modes, shape (t, n)."""
        n = len(self.values)
        both = np.add.outer(self.values, self.values).ravel()
        drive = self.pairs.reshape(n, n * n)
        size = np.abs(drive).max(initial=0.0)
        keep = np.abs(drive).max(axis=0) > 1e-14 * size
        rates, drive = both[keep], drive[:, keep]
        t = times[:, None]
        fast, slow = np.exp(t * rates), np.exp(t * self.values)
        apart = rates[None] - self.values[:, None]  # (n, pairs)
        near = np.abs(apart) * max(float(times.max(initial=0.0)), 1e-300) < 1e-4
        over = drive / np.where(near, 1.0, apart)
        over = np.where(near, 0.0, over)
        found = fast @ over.T - slow * over.sum(axis=1)
        if near.any():  # resonance: the limit, to second order in the difference
            rows, columns = np.nonzero(near)
            z = t * apart[rows, columns]
            limit = t * slow[:, rows] * (1 + z / 2) * drive[rows, columns]
            for i, row in enumerate(rows.tolist()):
                found[:, row] += limit[:, i]
        return found

    def states(self, modal: Any) -> Floats:
        """Deviations from their modes, shape (t, n)."""
        return np.ascontiguousarray((modal @ self.vectors.T).real)

    def third(self, times: Floats) -> tuple[Floats, Floats]:
        """Sampled size of the third order, at rising times.

        Parameters
        ----------
        times
            Last time of each stretch, shape (t,); the first stretch begins at 0.

        Returns
        -------
        size, drive
            The third order at these times, shape (t, n), and the defect that drives it.
        """
        edges = np.concatenate([[0.0], times])
        width = np.diff(edges)
        share = (np.arange(1, len(width) + 1) * (5**0.5 - 1) / 2) % 1.0
        inside = edges[:-1] + width * (0.1 + 0.8 * share)
        one, two = self.states(self.linear(inside)), self.states(self.second(inside))
        e = one + two
        here = self.member + e
        rates = self.system.rates(here, np.broadcast_to(self.p, (len(here), len(self.p))))
        known = e @ self.jacobian.T + np.einsum("iab,ta,tb->ti", self.bend, one, one) / 2
        drive = (rates - known) @ np.linalg.inv(self.vectors).T
        later = times[:, None] - inside
        kernel = np.where(later[..., None] >= 0, np.exp(
            np.where(later >= 0, later, 0.0)[..., None] * self.values), 0.0)  # fmt: skip
        swift = -self.values.real[None, :] * width[:, None] > 1
        rate = np.where(self.values == 0, 1.0, self.values)
        found = np.einsum("tsn,s,sn->tn", kernel, width, np.where(swift, 0.0, drive))
        found = found + np.where(swift, -drive / rate, 0.0)
        return self.states(found), np.abs(drive).max(axis=1)

    @property
    def jacobian(self) -> Floats:
        """J, shape (n, n)."""
        matrix = (self.vectors * self.values) @ np.linalg.inv(self.vectors)
        return np.ascontiguousarray(matrix.real)


def modes(problem: Problem, member: Floats, family: str) -> Modes | Refused:
    """The modes of a member, and the start in them.

    Parameters
    ----------
    problem
        The problem.
    member
        States of the steady motion, shape (n,) at least.
    family
        Its family.

    Returns
    -------
    Modes or Refused
    """
    n, system = problem.own, problem.flow.system
    at = member[:n]
    matrix, bend = (np.array(v) for v in _slopes(system)(at, problem.p))
    if not (np.isfinite(matrix).all() and np.isfinite(bend).all()):
        return Refused("the rates have no second derivative at the steady motion")
    values, vectors = (v for v in eigenpairs(matrix))
    if not np.linalg.cond(vectors) < PARALLEL:
        return Refused(f"two modes of {family} are parallel: the linear motion grows with time")
    bend = bend.reshape(n, n, n, order="F")
    back = np.linalg.inv(vectors)
    first = back @ (problem.start[:n] - at)
    carried = first * vectors
    pairs = np.einsum("ia,abc,bj,ck->ijk", back, bend, carried, carried, optimize=True) / 2
    return Modes(system, problem.p, at, family, values, vectors, first, pairs, bend)


def near_steady(problem: Problem) -> dict[str, Track | Refused]:
    """The three rungs near the nearest steady motion, cheapest first.

    Parameters
    ----------
    problem
        The problem.

    Returns
    -------
    dict
        Track or refusal by name; rungs above the first that is fine enough are left out.
    """
    every = (STEADY, LINEARISED, SECOND)
    near = problem.launches.settling.closest(problem.start, problem.p)
    if near.member is None:
        return dict.fromkeys(every, Refused(near.evidence))
    size = float(relative(problem.start - near.member, near.member))
    where = {"distance": size}
    if size > FAR:
        why = f"the start is {size:.2g} from {near.family}, the nearest steady motion"
        return dict.fromkeys(every, Refused(why, where))
    if size**2 > REACH * problem.tolerance and size**3 > REACH * problem.tolerance:
        why = f"the start is {size:.2g} from {near.family}, whose cube is far above the tolerance"
        return dict.fromkeys(every, Refused(why, where))
    found = modes(problem, near.member, near.family)
    if isinstance(found, Refused):
        return dict.fromkeys(every, found)
    growth = float(found.values.real.max(initial=0.0)) * problem.last
    where["growth"] = growth
    if growth > GROWTH or size * np.exp(min(growth, 700.0)) > FAR:
        why = f"the linear deviation from {near.family} grows e^{growth:.3g} times"
        return dict.fromkeys(every, Refused(why, where))
    return _three(problem, found, where)


def _three(problem: Problem, found: Modes, where: dict[str, float]) -> dict[str, Track | Refused]:
    """The tracks of a motion near a member."""
    times, n = problem.times, problem.own
    share = (np.arange(1, SAMPLES + 1) / SAMPLES) ** 2
    looks = problem.last * share
    third, _ = found.third(looks)
    sampled = np.maximum.accumulate(relative(third, found.member))
    one, two = found.states(found.linear(times)), found.states(found.second(times))
    size = np.interp(times, np.concatenate([[0.0], looks]), np.concatenate([[0.0], sampled]))
    rounding = 1e-15 * (1 + np.abs(found.values).max() * times)
    member = np.zeros(len(problem.start))
    member[:n] = found.member

    def track(name: str, deviation: Any, errors: Floats) -> Track:
        def at(when: Floats) -> Floats:
            states = np.tile(member, (len(when), 1))
            states[:, :n] += deviation(when)
            return states

        note = f"{name} at {found.family}"
        return Track(times, at(times), errors, at, None, 0, (note,), dict(where))

    small, middle, rest = relative(one, member[:n]), relative(two, member[:n]), size + rounding
    where |= {"second order": float(middle.max()), "third order": float(size.max())}
    if middle.max() + size.max() > max(TRUSTED * small.max(), 1e-14):
        why = f"the orders of the deviation from {found.family} do not fall"
        return dict.fromkeys((STEADY, LINEARISED, SECOND), Refused(why, where))
    tracks: dict[str, Track | Refused] = {
        STEADY: track("at rest", lambda when: np.zeros((len(when), n)),
                      relative(one + two, member[:n]) + rest),
        LINEARISED: track("linear motion", lambda when: found.states(found.linear(when)),
                          middle + rest),
        SECOND: track("linear motion and its second order", lambda when: found.states(
            found.linear(when) + found.second(when)), rest),
    }  # fmt: skip
    return {name: _kept(problem, one) for name, one in tracks.items() if isinstance(one, Track)}


def _kept(problem: Problem, track: Track) -> Track | Refused:
    """The track, unless a guard fails on it."""
    looks = track.states[:: max(1, len(track.states) // 64)]
    y = problem.flow.pack(looks)
    values, _ = problem.flow.margins(y, problem.flow_p)
    if values.size and not (values > 0).all():
        return Refused("a guard of the full model fails on the way", track.indicators)
    if values.size:
        track.indicators["least guard"] = float(values.min())
    return track
