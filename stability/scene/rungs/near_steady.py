"""Rungs near a steady motion: the motion at rest there, its linear part, and the second order.

The deviation e from a family member obeys e' = J e + H(e, e)/2 + …  In the modes of J the linear
part is a sum of exponentials, and so is the second order that H drives.  Both are known at any time
at the same cost.  What drives the third order is the defect of the first two in the full equations.
It is sampled, and each mode carries the samples to the time asked for.
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import casadi as ca
import numpy as np

from ...algebra.eigensolver import eigenpairs
from ...algebra.program import Program, entries
from ...base.types import Floats
from ...systems.equations import Equations
from ...systems.system import System
from .track import LaunchProblem, Refused, Track, relative

STEADY, LINEARISED, SECOND = CLOSED_FORMS = "steady", "linearised", "second-order"
FAR = 0.3
"""Deviation above which a motion is not near its family, over 1 or the size of the state."""
PARALLEL = 1e7
"""Largest entry of the inverse of the modes with which they carry a deviation."""
ROUNDING = 1e-15
"""Size of an entry of a Jacobian, over the largest, below which it may be rounding."""
SAMPLES, ENDS = 32, 8
"""Samples of the third-order defect, and the times at which it is summed."""
GROWTH = 30.0
"""Exponent of growth above which no linear motion is small."""
SAFETY = 3.0
"""Factor on the third order, for the orders above it and for its sampling."""
DOUBTFUL, CHEAP, CLEAR = 3e-3, 1.5e-3, 0.1
"""Expected times of the full model [s] up to which the closed forms are left out: where their third
order may be above the tolerance at the horizon, and where it is not clearly below; the share of the
tolerance that is."""
VAIN = "not tried: the full model is expected to take no longer"
"""Why the closed forms are left out where the full model may be done first."""
TRUSTED = 0.2
"""Share of the linear deviation up to which the higher orders may be an estimate of its error."""


@lru_cache(maxsize=64)
def _slope(system: System) -> Program:
    """Program of (x, p) → J, without a check of conditions."""
    return Program(ca.Function("slope", [system.x, system.p], [system.jacobian]))


@lru_cache(maxsize=64)
def _bend(system: System) -> Program:
    """Program of (x, p) → the slope of vec J in x."""
    bend = ca.jacobian(ca.vec(ca.densify(system.jacobian)), system.x)
    return Program(ca.Function("bend", [system.x, system.p], [bend]))


@lru_cache(maxsize=64)
def _pairs(count: int) -> tuple[Any, Any]:
    """Indices i ≤ j of the pairs of modes."""
    return np.triu_indices(count)


@lru_cache(maxsize=64)
def rates_of(system: Equations) -> Program:
    """Program of (x, p) → rates, without a check of conditions."""
    return Program(ca.Function("rates", [system.x, system.p], [ca.densify(system.rhs)]))


def rates_at(problem: LaunchProblem, states: Floats) -> Floats:
    """Rates of a problem's equations at states, shape (…, n), without a check of conditions."""
    arguments = [entries(states), list(problem.p)]
    rates: Floats = rates_of(problem.flow.system).arrays(arguments, states.shape[:-1])[0][..., 0]
    return rates


def slope_at(problem: LaunchProblem, state: Floats) -> Floats:
    """J of a problem's equations at a state, shape (n, n), without a check of conditions."""
    slope: Floats = _slope(problem.flow.system).arrays([list(state), list(problem.p)], ())[0]
    return slope


@dataclass(frozen=True, eq=False)
class ModalMotion:
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
    back: Any
    """Their inverse, shape (n, n)."""
    jacobian: Floats
    """J, shape (n, n)."""
    first: Any
    """Deviation at the start in the modes, shape (n,)."""
    pairs: Any
    """Rate of each mode driven by each pair of modes i ≤ j, shape (n, n (n + 1)/2)."""
    bend: Floats
    """Second derivative of the rates, shape (n, n, n)."""

    def linear(self, times: Floats) -> Any:
        """The linear deviation in the modes, shape (t, n)."""
        return np.exp(np.multiply.outer(times, self.values)) * self.first

    def second(self, times: Floats) -> Any:
        """The deviation of second order in the modes, shape (t, n)."""
        first, second = _pairs(len(self.values))
        rates, drive, t = self.values[first] + self.values[second], self.pairs, times[:, None]
        fast, slow = np.exp(t * rates), np.exp(t * self.values)
        apart = rates[None] - self.values[:, None]  # (n, pairs)
        near = np.abs(apart) * max(float(times.max(initial=0.0)), 1e-300) < 1e-4
        over = drive / np.where(near, 1.0, apart)
        over = np.where(near, 0.0, over)
        deviation = fast @ over.T - slow * over.sum(axis=1)
        if near.any():  # resonance: the limit, to second order in the difference
            rows, columns = np.nonzero(near)
            z = t * apart[rows, columns]
            limit = t * slow[:, rows] * (1 + z / 2) * drive[rows, columns]
            for i, row in enumerate(rows.tolist()):
                deviation[:, row] += limit[:, i]
        return deviation

    def states(self, modal: Any) -> Floats:
        """Deviations from their modes, shape (t, n)."""
        return np.ascontiguousarray((modal @ self.vectors.T).real)

    def only(self, some: Any) -> ModalMotion:
        """The motion in those modes for which `some` is 1, as if the start had no others."""
        first, second = _pairs(len(self.values))
        return replace(self, first=self.first * some, pairs=self.pairs * some[first] * some[second])

    def third(self, times: Floats) -> tuple[Floats, Floats]:
        """Sampled size of the third order at some of the times, the last among them.

        Of each stretch, from 0 to the first of `times` and so on, there is one sample.
        """
        edges = np.concatenate([[0.0], times])
        width = np.diff(edges)
        share = (np.arange(1, len(width) + 1) * (5**0.5 - 1) / 2) % 1.0
        inside = edges[:-1] + width * (0.1 + 0.8 * share)
        linear = self.states(self.linear(inside))
        e = linear + self.states(self.second(inside))
        arguments = [list((self.member + e).T), list(self.p)]
        rates = rates_of(self.system).arrays(arguments, inside.shape)
        bent = np.tensordot(linear, self.bend, axes=(1, 2))
        modelled = e @ self.jacobian.T + (bent @ linear[:, :, None])[..., 0] / 2
        drive = (rates[0][..., 0] - modelled) @ self.back.T
        ends = times[:: len(times) // ENDS][-ENDS:] if len(times) > ENDS else times
        later = ends[:, None] - inside
        past = later >= 0
        swift = -self.values.real[None, :] * width[:, None] > 1
        rate = np.where(self.values == 0, 1.0, self.values)
        slow = np.where(swift, 0.0, width[:, None] * drive)
        carried = np.exp(np.maximum(later, 0.0)[..., None] * self.values) * past[..., None]
        sizes = np.einsum("eim,im->em", carried, slow)
        quick = np.abs(np.where(swift, drive / rate, 0.0)).max(axis=0)
        size = np.abs(self.states(sizes)) + quick @ np.abs(self.vectors).T
        return ends, SAFETY * relative(size, self.member)


def modes_of(matrix: Floats) -> tuple[Any, Any, Any]:
    """Eigenvalues of J, modes, and their inverse, which is None where two modes are parallel."""
    clean = np.where(np.abs(matrix) < ROUNDING * np.abs(matrix).max(), 0.0, matrix)
    for tried in (matrix, clean):  # an entry of rounding may join two zeros
        values, vectors = eigenpairs(tried)
        with suppress(np.linalg.LinAlgError):
            back = np.linalg.inv(vectors)
            if np.abs(back).max() < PARALLEL:
                return values, vectors, back
    return values, vectors, None


def _vain(problem: LaunchProblem, size: float, price: float, length: float) -> bool:
    """Whether the full model may be done before the closed forms have turned out too coarse.

    The third order of a deviation of a size has grown for a length of time.
    """
    third, tolerance = size**3 * max(1.0, length), problem.tolerance
    limit = CLEAR * tolerance if price < CHEAP else tolerance
    return price < DOUBTFUL and third > limit and size > tolerance


def _hopeless(problem: LaunchProblem, size: float) -> bool:
    """Whether the third power of a deviation is far above the tolerance."""
    return size > problem.tolerance < size**3


def modes(
    problem: LaunchProblem,
    member: Floats,
    family: str,
    *,
    always: bool = True,
    price: float = np.inf,
) -> ModalMotion | Refused:
    """The modes of a member, and the start in them.

    `always` asks for them even where no closed form can be fine enough; `price` is the expected
    time of the full model [s].
    """
    n, system = problem.own, problem.flow.system
    at = member[:n]
    place = [list(at), list(problem.p)]
    matrix = slope_at(problem, at)
    if not np.isfinite(matrix).all():
        return Refused("the rates have no derivative at the steady motion")
    values, vectors, back = modes_of(matrix)
    if back is None:
        return Refused(f"two modes of {family} are parallel: the linear motion grows with time")
    growth = float(values.real.max(initial=0.0)) * problem.last
    size = float(relative(problem.start[:n] - at, at)) * np.exp(min(growth, 700.0))
    if growth > GROWTH or size > FAR or (growth > 1 and not always and _hopeless(problem, size)):
        return Refused(
            f"the linear deviation from {family} grows e^{growth:.3g} times",
            {"growth exponent to the horizon": growth},
        )
    length = 1.0 if growth > 1 else problem.last  # what grows has most of its size at the end
    if not always and _vain(problem, size, price, length):
        return Refused(VAIN)
    bend = _bend(system).arrays(place, ())[0]
    if not np.isfinite(bend).all():
        return Refused("the rates have no second derivative at the steady motion")
    bend = bend.reshape(n, n, n, order="F")
    first = back @ (problem.start[:n] - at)
    moved = first * vectors
    pairs = (back @ (moved.T @ (bend @ moved)).reshape(n, n * n)).reshape(n, n, n)
    i, j = _pairs(n)
    pairs = pairs[:, i, j] * np.where(i == j, 0.5, 1.0)
    return ModalMotion(
        system, problem.p, at, family, values, vectors, back, matrix, first, pairs, bend
    )


def near_steady(
    problem: LaunchProblem, *, always: bool = False, price: float = np.inf
) -> dict[str, Track] | Refused:
    """The three rungs near the nearest steady motion, cheapest first, or why there is none.

    Options are those of `modes`.
    """
    near = problem.near
    if near.member is None:
        why = "no steady motion is known near the start"
        if not problem.touches:
            named = problem.launches.settling.lines
            why += f": {near.evidence}" if named else "; name some with families="
        elif near.family:
            why = f"near {near.family} the heading turns without end, and no closed form follows it"
        return Refused(why)
    size = float(relative(problem.start - near.member, near.member))
    where = {f"distance from {near.family}": size}
    if size > FAR:
        why = f"the start is {size:.2g} from {near.family}, the nearest steady motion"
        return Refused(why, where)
    if not always and _hopeless(problem, size):
        cube = f"{size:.2g}³ = {size**3:.2g} is above the tolerance"
        return Refused(f"the start is {size:.2g} from {near.family}, and {cube}", where)
    if not always and _vain(problem, size, price, problem.last):
        return Refused(VAIN, where)
    motion = modes(problem, near.member, near.family, always=always, price=price)
    if isinstance(motion, Refused):
        return Refused(motion.why, where | motion.indicators)
    growth = float(motion.values.real.max(initial=0.0)) * problem.last
    return _three(problem, motion, where | {"growth exponent to the horizon": growth})


def _three(
    problem: LaunchProblem, motion: ModalMotion, where: dict[str, float]
) -> dict[str, Track] | Refused:
    """The tracks of a motion near a member."""
    times, n = problem.times, problem.own
    looks, sizes = motion.third(problem.last * (np.arange(1, SAMPLES + 1) / SAMPLES) ** 2)
    every = np.concatenate([looks, times])
    member = np.zeros(len(problem.start))
    member[:n] = motion.member

    def lifted(deviations: Floats) -> Floats:
        states = np.tile(member, (len(deviations), 1))
        states[:, :n] += deviations
        return states

    for when in (looks, every) if len(times) > len(looks) else (every,):  # few say no at once
        first, second = motion.states(motion.linear(when)), motion.states(motion.second(when))
        small, middle = relative(first, motion.member), relative(second, motion.member)
        where |= {
            "size of the second order": float(middle.max()),
            "size of the third order": float(sizes.max()),
        }
        if not problem.stands(lifted((first + second)[: len(looks)])):
            return Refused("a guard of the full model fails on the way", where)
        if not middle.max() + sizes.max() <= max(TRUSTED * small.max(), 1e-14):
            return Refused(f"the orders of the deviation from {motion.family} do not fall", where)
    here = slice(len(looks), None)
    third = np.interp(times, np.append(0.0, looks), np.append(0.0, np.maximum.accumulate(sizes)))
    third += 1e-15 * (1 + np.abs(motion.values).max() * times)

    def track(name: str, modal: Any, deviations: Floats, errors: Floats) -> Track:
        def at(when: Floats) -> Floats:
            return lifted(motion.states(modal(when)))

        notes = (f"{name} at {motion.family}",)
        return Track(times, lifted(deviations), errors, at, notes=notes, indicators=where)

    def still(when: Floats) -> Any:
        return np.zeros((len(when), n))

    def both(when: Floats) -> Any:
        return motion.linear(when) + motion.second(when)

    whole = (first + second)[here]
    return {
        STEADY: track("at rest", still, 0 * first[here], relative(whole, member[:n]) + third),
        LINEARISED: track("linear motion", motion.linear, first[here], middle[here] + third),
        SECOND: track("linear motion and its second order", both, whole, third),
    }
