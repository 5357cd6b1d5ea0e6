"""Creep along a path: the slip of a stiff viscous contact follows the motion, order by order.

Slip decays within a time of 1/mu.  Until then the full model runs, in a few steps.  From there on
the rough disk gives the motion of order 0, and the force that holds it gives the slip of order 1 as
a function of time.  The disk held to that slip is again a motion without stiffness, a small
correction away, with a force of its own.  Each turn costs one evaluation along the path and gains a
factor of about 1/mu; the correction of the next order is the error of this one.

Source: N. Fenichel, J. Differ. Equ. 31 (1979) 53-98, for the slow manifold; the iteration is that
of `stability.bodies.contact_laws.Creep`, along one motion (tests/scene/test_creep_path.py).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from ...algebra.program import Program
from ...base.types import Floats
from ...bodies.contact_laws import LinearViscous, Viscous
from ...bodies.creep import LEAST_RELAXATION
from ...bodies.model import LIFT_OFF, NO_CONTACT
from ...integrators.flow import Flow, flow_of
from ...integrators.leg import Leg
from ...integrators.selection import METHODS, dense, explicit
from .elements import Elements, LinearEquation
from .track import LaunchProblem, decade, relative

LAWS = (Viscous, LinearViscous)
"""Laws whose slip the force gives."""
MOST_ORDERS = 12
"""Largest order of creep."""
BENT = 3e-3
"""Correction of the path above which the slopes along it are computed again."""
WINDOW = 0.3
"""Distance of the rough path at which creep starts again from its own state."""
CLEAR = 0.3
"""Least D over its value without slip."""
STALLS = 0.7
"""Ratio of two corrections above which the orders no longer converge."""
NEARLY, DOUBT = 0.5, 2.0
"""Ratio that the next two corrections are expected to have, above which the rest of the orders is
hardly known; factor on the error there."""
LAYER = 1e-3
"""Share of the tolerance to which the slip of the start has decayed when creep begins."""
LAYER_LOOKS = 25
"""Times in a run of the transient at which the rate of decay is looked at; the lower counts."""
STEPS = 6
"""Steps of the Taylor method in an element."""
RESOLVED = 10.0
"""Sum of the last coefficients of all elements, over the tolerance, above which some are halved."""
SUPER = 0.1
"""Error of a path over the sum of the last coefficients of its elements, which add up."""
SPLITS = 4
"""Most divisions of an element that does not resolve the motion."""
PHASE = 0.1
"""Phase that `LinearEquation` may lose in all turns of a small deviation."""


@dataclass(frozen=True, eq=False)
class Order:
    """The motion of one order of creep on the elements."""

    path: Floats
    """The n states without slip at the points, shape (E, N, n)."""
    slip: Floats
    """The slip, shape (E, N, 2)."""
    errors: Floats = field(default_factory=lambda: np.empty(0))
    """What the next order changes in all states, shape (E, N, n + 2)."""

    @property
    def states(self) -> Floats:
        """All states at the points, shape (E, N, n + 2)."""
        return np.concatenate([self.path, self.slip], axis=-1)


@dataclass(frozen=True, eq=False)
class CreepPath:
    """The orders of creep from one state on, as far as they converge."""

    elements: Elements
    """The division of time."""
    orders: tuple[Order, ...]
    """Orders 0, 1, …, each with its error; at least one where creep holds at all."""
    relaxation: Floats
    """Rate at which slip decays over that at which it is driven, at the points, shape (E, N)."""
    bound: bool
    """Whether the slip still follows the motion at the end: creep may go on from there."""
    linear: LinearEquation
    """The equation of a small deviation along the path."""
    normal: float
    """Least normal force on the rough path."""
    tried: int
    """Number of elements of the rough path, of which these are the first."""
    unresolved: float
    """Error of the path between and at the points, from the last coefficients of the elements."""


@dataclass(frozen=True, eq=False)
class HeldMotion:
    """The body of a problem held to a slip, at all points of a path."""

    problem: LaunchProblem
    """The problem, whose law has creep."""
    rough: Flow
    """The body without slip."""
    programs: tuple[Program, Program]
    """From `stability.bodies.held_motion.held_programs`."""

    @cached_property
    def n(self) -> int:
        """Number of states without slip."""
        return len(self.rough.system.states)

    @cached_property
    def p(self) -> Floats:
        """Parameters without the law's."""
        names = self.problem.flow.system.parameters
        return self.problem.p[[names.index(n) for n in self.rough.system.parameters]]

    @cached_property
    def mu(self) -> float:
        """Friction coefficient."""
        return self.problem.friction

    @cached_property
    def by_force(self) -> bool:
        """Whether slip follows from the force alone and not from that over the normal force."""
        return self.problem.launches.law is LinearViscous

    def motion(self, path: Floats, *slip: Floats) -> tuple[Floats, Floats]:
        """Rates, (E, N, n), and forces, (E, N, 3), with a slip and its rate, (E, N, 2), or none."""
        values = self._run(0, path, *slip)
        return values[..., : self.n], values[..., self.n :]

    def slope(self, path: Floats, *slip: Floats) -> Floats:
        """Slope of the rates in the states, shape (E, N, n, n)."""
        entries = self._run(1, path, *slip)
        columns = entries.reshape(*path.shape[:-1], self.n, self.n)
        return np.ascontiguousarray(columns.swapaxes(-1, -2))

    def _run(self, which: int, path: Floats, *slip: Floats) -> Floats:
        n, inputs = self.n, self.n + len(self.p)
        points = np.zeros((inputs + 4, path.size // n))
        points[:n], points[n:inputs] = path.reshape(-1, n).T, self.p[:, None]
        for i, part in enumerate(slip):
            points[inputs + 2 * i : inputs + 2 * i + 2] = part.reshape(-1, 2).T
        values = self.programs[which].many(points)
        return np.ascontiguousarray(values.T).reshape(*path.shape[:-1], -1)

    def slip(self, forces: Floats) -> Floats:
        """The slip at which the law has these forces, shape (E, N, 2)."""
        normal = 1.0 if self.by_force else forces[..., 2:]
        slip: Floats = -forces[..., :2] / (self.mu * normal)
        return slip

    def relaxation(self, forces: Floats, slip_rate: Floats) -> Floats:
        """Rate at which slip decays over that at which the motion drives it, shape (E, N)."""
        drag = self.mu * slip_rate
        normal = np.ones(forces.shape[:-1]) if self.by_force else forces[..., 2]
        decay: Floats = self.mu * normal / np.sqrt(1 + (drag**2).sum(axis=-1))
        return np.where(forces[..., 2] > 0, decay, 0.0)

    def held_by_contact(self, path: Floats, slip: Floats) -> NDArray[np.bool_]:
        """Whether D of the viscous law stays clear of zero with this slip, shape (E, N).

        Beyond D = 0 slip grows where it decayed before.
        """
        if self.by_force:
            return np.ones(path.shape[:-1], dtype=bool)
        states = np.concatenate([path, slip], axis=-1).reshape(-1, self.n + 2)
        _, share = contact_at(self.problem, states)
        return share.reshape(path.shape[:-1]) > CLEAR


def contact_at(problem: LaunchProblem, states: Floats) -> tuple[Floats, Floats]:
    """Normal force of the full model, and D over its value without slip, at states (t, n + 2)."""
    flow = problem.flow
    rows = [flow.pack(states).T, np.tile(problem.flow_p[:, None], len(states))]
    normal, share = _contact(flow).many(np.concatenate(rows))
    return normal, share


def applies(problem: LaunchProblem) -> bool:
    """Whether creep is solved for the body and the law of a problem."""
    return problem.launches.law in LAWS and problem.launches.model.held is not None


def held_of(problem: LaunchProblem) -> HeldMotion:
    """The held body of a problem to which creep applies."""
    held = problem.launches.model.held
    assert held is not None
    return HeldMotion(problem, flow_of(held.rough()), held.programs())


def creep_path(
    problem: LaunchProblem,
    held: HeldMotion,
    start: Floats,
    begin: float,
    last: float,
    tolerance: float,
) -> CreepPath | str:
    """Creep from a state whose slip has decayed, up to `last` at most, or why there is none.

    No further order is computed where the error is below `tolerance`.
    """
    rough = _rough(problem, held, start, begin, last, tolerance)
    if isinstance(rough, str):
        return rough
    elements, path, slope = rough
    _, forces = held.motion(path)
    slip = held.slip(forces)
    rate = elements.derivative(slip)
    relaxation = held.relaxation(forces, rate)
    relaxation = np.where(held.held_by_contact(path, slip), relaxation, 0.0)
    valid = _follows(relaxation)
    if valid == 0:
        return f"slip follows the motion only {relaxation[0].min():.3g} times faster than it moves"
    bound = valid == len(path)
    linear = LinearEquation.along(elements.first(valid), slope[:valid])
    rates, _ = held.motion(path[:valid], slip[:valid], rate[:valid])
    change = linear.solve(rates - linear.elements.derivative(path[:valid]), np.zeros(held.n))
    near = _window(change, path[:valid])
    if near < valid:
        valid, bound, linear, change = near, True, linear.first(near), change[:near]
    orders = _orders(held, linear, path[:valid], slip[:valid], rate[:valid], change, tolerance)
    if not orders:
        return "the orders of creep do not converge"
    elements, least = linear.elements, float(forces[:valid, :, 2].min())
    unresolved = float(SUPER * elements.tails(orders[-1].states).sum())
    return CreepPath(
        elements, orders, relaxation[:valid], bound, linear, least, len(path), unresolved
    )


def _window(change: Floats, path: Floats) -> int:
    """Number of elements, one at least, on which the rough path is near: there orders converge."""
    far = np.flatnonzero(~(relative(change, path).max(axis=1) < WINDOW))
    return max(1, int(far[0])) if far.size else len(path)


def _orders(
    held: HeldMotion,
    linear: LinearEquation,
    path: Floats,
    slip: Floats,
    rate: Floats,
    change: Floats,
    tolerance: float,
) -> tuple[Order, ...]:
    """Orders from the first change on, until one is fine enough or they no longer fall."""
    orders: list[Order] = []
    size, ratio, elements = np.inf, 0.0, linear.elements
    now, zero = Order(path, np.zeros_like(slip)), np.zeros(held.n)
    for _ in range(MOST_ORDERS + 1):
        then = Order(now.path + change, slip)
        errors = np.concatenate([change, slip - now.slip], axis=-1)
        before, size = size, float(relative(errors, then.states).max())
        earlier, ratio = ratio, size / before
        # the orders are an asymptotic series: the share by which each falls grows, soon above 1
        following = ratio * max(1.0, ratio / earlier) if earlier else ratio
        if not (ratio < STALLS and following < STALLS and np.isfinite(size)):
            if orders:  # what the next order would change is not known to be its error, but counts
                last = orders[-1]
                orders[-1] = replace(last, errors=np.abs(last.errors) + np.abs(errors))
            break
        rest = (DOUBT if following > NEARLY else 1.0) / (1 - following)
        orders.append(Order(now.path, now.slip, rest * errors))
        if size <= tolerance or size < 1e-14:
            break
        now = then
        if size > BENT:
            linear = LinearEquation.along(elements, held.slope(now.path, slip, rate))
        _, forces = held.motion(now.path, slip, rate)
        if not (forces[..., 2] > 0).all():
            break
        slip = held.slip(forces)
        rate = elements.derivative(slip)
        rates, _ = held.motion(now.path, slip, rate)
        change = linear.solve(rates - elements.derivative(now.path), zero)
    return tuple(orders)


def _follows(relaxation: Floats) -> int:
    """Number of elements, from the first, on which slip follows the motion."""
    bad = np.flatnonzero(~(relaxation.min(axis=1) > LEAST_RELAXATION))
    return int(bad[0]) if bad.size else len(relaxation)


def _rough(
    problem: LaunchProblem,
    held: HeldMotion,
    start: Floats,
    begin: float,
    last: float,
    tolerance: float,
) -> tuple[Elements, Floats, Floats] | str:
    """The rough disk's path on elements that resolve it, up to its own end, and its slope."""
    rough = held.rough
    points = int(np.clip(8 + np.ceil(-0.75 * np.log10(tolerance)), 8, 18))
    p = np.append(held.p, [np.sin(problem.flat)] * (rough.p.numel() - len(held.p)))
    fine = decade(tolerance / 100, most=1e-12)
    span = np.array([begin, last])
    leg = Leg(rough, p, rough.pack(start[: held.n]), span, fine, 10_000_000, problem.max_seconds)
    run = dense(leg)
    if len(run.steps) < 2 or not run.steps[-1] > begin:
        return "the body without slip ends at once"

    def along(elements: Elements) -> Floats:
        return run.at(elements.times.ravel())[:, : held.n].reshape(-1, points, held.n)

    elements = Elements(np.append(run.steps[:-1:STEPS], run.steps[-1]), points)
    path = along(elements)
    for _ in range(SPLITS):
        coarse = elements.tails(path) > RESOLVED * tolerance / len(path)
        if not coarse.any():
            break
        elements = elements.halved(coarse)
        path = along(elements)
    slope = held.slope(path)
    pieces = _pieces(elements, slope)
    if (pieces > 1).any():
        inner = np.repeat(elements.edges[:-1], pieces)
        share = np.concatenate([np.arange(n) / n for n in pieces])
        edges = inner + share * np.repeat(elements.lengths, pieces)
        elements = Elements(np.append(edges, elements.edges[-1]), points)
        path = along(elements)
        slope = held.slope(path)
    return elements, path, slope


def _pieces(elements: Elements, slope: Floats) -> NDArray[np.intp]:
    """Number of parts of each element in which `LinearEquation` follows turns of small deviations.

    Near a steady motion the path is smooth at the size of the tolerance on long elements, but the
    linear equation still turns at its own rate.  A step h of an exponential to eighth order loses
    a phase of (ω h)⁹/9!.
    """
    some = slope[:, :: max(1, slope.shape[1] // 4)]
    gaps = elements.gaps[..., 0, 0]

    def lost(rates: Floats) -> Floats:
        errors: Floats = ((rates[:, None] * gaps) ** 9).sum(axis=1) / math.factorial(9)
        return errors

    least = np.ones(len(some), dtype=np.intp)
    if lost(np.sqrt((some**2).sum(axis=(2, 3)).max(axis=1))).sum() <= PHASE:
        return least  # no rate is above the norm
    phases = lost(np.abs(np.linalg.eigvals(some)).max(axis=(1, 2)))
    if not phases.sum() > PHASE:
        return least
    parts = (phases * (len(phases) / PHASE)) ** 0.125
    counts: NDArray[np.intp] = np.ceil(np.maximum(parts, 1.0)).astype(np.intp)
    return counts


def transient(
    problem: LaunchProblem, held: HeldMotion, start: Floats, begin: float, tolerance: float
) -> tuple[Floats, Floats, Any] | str:
    """The full model until the slip of the start has decayed, or why it does not.

    Times, shape (t,), and states, shape (t, n + 2), of which the last begin creep; the end of the
    run where a guard failed.
    """
    flow, p = problem.flow, problem.flow_p
    pull = _pull(problem, held, start[None])[0]
    apart = max(float(np.abs(start[held.n :]).max()), 1.0 / held.mu)
    needed = np.log(max(apart / (LAYER * tolerance), 1.0))
    times, states = np.array([begin]), start[None]
    done, now = 0.0, begin
    for _ in range(6):
        span = min(1.05 * (needed - done) / pull, problem.last - now)
        if span <= 0:
            break
        inner = now + span * np.linspace(0, 1, LAYER_LOOKS)
        inner[-1] = min(inner[-1], problem.last)
        asked = problem.times[(problem.times > now) & (problem.times < inner[-1])][:1000]
        grid = np.union1d(inner, asked)
        leg = Leg(
            flow,
            p,
            flow.pack(states[-1]),
            grid,
            decade(tolerance / 100, most=1e-10),
            100_000,
            problem.max_seconds,
        )
        run = METHODS[explicit(flow)](leg)
        times = np.concatenate([times, grid[1 : len(run.states)]])
        states = np.concatenate([states, run.states[1:, : problem.own]])
        if run.end is not None:
            return times, states, run.end
        pulls = _pull(problem, held, run.states)
        decay = np.minimum(pulls[1:], pulls[:-1]) * np.diff(grid)
        past = done + np.append(0.0, np.cumsum(decay))
        free = np.maximum(_free(held, run.states[:, : problem.own]) / (LAYER * tolerance), 1e-300)
        needed = max(needed, float((past + np.log(free)).max()))
        done = float(past[-1])
        now = float(grid[-1])
        if done >= needed or now >= problem.last:
            break
        pull = max(float(pulls[-1]), 1e-3 * held.mu)
    else:
        return "the slip of the start does not decay"
    return times, states, None


def _free(held: HeldMotion, states: Floats) -> Floats:
    """Distance of slip from the slip that the rough disk's force gives, 0 where it is bound.

    Slip that was bound is free again while the normal force fades, and has to decay again.
    """
    _, forces = held.motion(states[None, :, : held.n])
    bound = held.slip(forces)[0]
    apart = np.abs(states[:, held.n :] - bound).max(axis=1)
    fades = (forces[0, :, 2] <= 0) | (apart > np.abs(bound).max(axis=1))
    apart = np.where(forces[0, :, 2] > 0, apart, np.abs(states[:, held.n :]).max(axis=1))
    return np.where(fades, apart, 0.0)


def _pull(problem: LaunchProblem, held: HeldMotion, states: Floats) -> Floats:
    """Least rate at which slip decays.

    A force at the contact meets an inverse inertia of at least 1/m.  The normal force falls as D
    grows with the slip along x̂, which leaves the share D(0)/D of that rate.
    """
    if held.by_force:
        return np.full(len(states), held.mu)
    normal, share = contact_at(problem, states[:, : problem.own])
    return held.mu * normal / np.maximum(1.0, share)


@lru_cache(maxsize=8)
def _contact(flow: Flow) -> Program:
    """Program of (y, p) → the normal force of the full model, and D over its value without slip."""
    there = flow.guards[NO_CONTACT]
    slip = flow.x[list(flow.model.sliding)]
    share = there / ca.substitute(there, slip, ca.SX.zeros(2))
    normal = flow.guards[LIFT_OFF] / there
    return Program(ca.Function("contact", [flow.x, flow.p], [ca.vertcat(normal, share)]))
