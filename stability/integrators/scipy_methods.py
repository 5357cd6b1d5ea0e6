"""The SciPy routes: DOP853, LSODA, Radau and BDF on the CasADi graph, checked step by step."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable
from functools import cache, partial
from inspect import signature
from typing import Any

import numpy as np

from ..base.types import Floats
from .flow import Evaluator
from .leg import (
    HALVINGS,
    LOWEST,
    UNRESOLVED,
    Budget,
    End,
    Integrator,
    Leg,
    Path,
    lost,
    too_many,
)

FINEST = 100 * np.finfo(float).eps
"""Smallest relative tolerance that SciPy accepts."""
ULPS = 4 * np.finfo(float).eps
"""Relative accuracy to which an event is located."""
LARGEST = 1e120
"""Entries of a state up to which the norms of SciPy's step control are finite."""
LOOKS = 1.0
"""Looks at the guards per radian of the fastest turn; a longer step has looks within."""
MOST_LOOKS = 1000
"""Most looks within one step."""


Trail = list[tuple[float, Floats, Floats]]
"""Time and y after each step, from the start, and y at `GAUSS` within the step, shape (n, 2)."""
GAUSS = np.array([0.5 - 3**0.5 / 6, 0.5 + 3**0.5 / 6])
"""Points of Gauss in a step of length one."""


@cache
def _solver(name: str) -> tuple[Any, bool]:
    """A class of SciPy, and whether it takes a Jacobian."""
    from scipy import integrate

    solver = getattr(integrate, name)
    return solver, "jac" in signature(solver).parameters


def integrate(
    leg: Leg, *, solver: str, clock: Floats | None = None, trail: Trail | None = None
) -> Path:
    """Run one leg with a SciPy solver and locate the first guard that reaches zero.

    After each step the guards and their rates are evaluated at its end, and within a step that is
    long for the motion's pace.  A sign change, or a lowest point, is resolved on the solver's dense
    output.

    Parameters
    ----------
    leg
        Leg to run.
    solver
        Name of SciPy's class; one that takes a Jacobian gets it by automatic differentiation.
    clock
        Values of the last state variable, which must rise, at which to sample in place of times.
        The run ends when all of them are reached, and the path begins at the first of them.
    trail
        List that takes the steps, or None.

    Returns
    -------
    Path
    """
    kind, implicit = _solver(solver)
    run = Evaluator(leg.flow, leg.p)
    options: dict[str, Any] = {"rtol": max(leg.tolerance, FINEST), "atol": leg.absolute}
    if implicit:
        options["jac"] = run.jacobian
    samples, budget = _Samples(leg, clock), Budget(leg.seconds)
    steps, last = 0, float(leg.times[-1])
    if len(leg.times) == 1:
        return Path(leg.start[None], None, 0)
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")  # the solver's status reports a failure
        running = kind(run.rates, float(leg.times[0]), leg.start, last, **options)
        good, time = leg.start.copy(), float(leg.times[0])
        before = run.watch(leg.start)
        if trail is not None:
            trail.append((time, good, np.tile(good[:, None], 2)))
        while running.status == "running" and not samples.done:
            try:
                if steps < leg.max_steps:
                    running.step()
            except (ValueError, np.linalg.LinAlgError):  # a Jacobian that is not finite
                end = End(UNRESOLVED, time, good, lost(solver.lower(), good))
                return Path(samples.kept, end, steps)
            steps += 1
            ended = steps > leg.max_steps or budget.spent
            if ended or running.status == "failed" or not np.abs(running.y).max() < LARGEST:
                many = budget.message if budget.spent else too_many(leg.max_steps)
                why = many if ended else lost(solver.lower(), good)
                return Path(samples.kept, End(UNRESOLVED, time, good, why), steps - ended)
            after = run.watch(running.y)
            zero = _first_zero(running, run, before, after)
            samples.take(running, None if zero is None else zero[0])
            if zero is not None:
                end = End(zero[1], zero[0], running.dense_output()(zero[0]))
                return Path(samples.kept, end, steps)
            before, good, time = after, running.y.copy(), float(running.t)
            if trail is not None:
                inner = running.dense_output()(running.t_old + (time - running.t_old) * GAUSS)
                trail.append((time, good, inner))
    return Path(samples.kept, None, steps)


class _Samples:
    """Samples of a run: the states at given times, or at given values of a clock."""

    def __init__(self, leg: Leg, clock: Floats | None) -> None:
        self.clock = clock
        self.wanted = leg.times if clock is None else clock
        self.states = np.empty((len(self.wanted), len(leg.start)))
        self.filled = 0
        if clock is None:
            self.states[0], self.filled = leg.start, 1

    @property
    def kept(self) -> Floats:
        return self.states[: self.filled]

    @property
    def done(self) -> bool:
        """Whether all values of a clock are sampled; false for times, which last to the end."""
        return self.clock is not None and self.filled == len(self.wanted)

    def take(self, solver: Any, until: float | None) -> None:
        """Keep the samples within the last step, up to an event in it."""
        reached = solver.t if until is None else until
        value = reached
        if self.clock is not None:
            value = solver.y[-1] if until is None else solver.dense_output()(until)[-1]
        upto = int(np.searchsorted(self.wanted, value, "right" if until is None else "left"))
        if upto <= self.filled:
            return
        dense, wanted = solver.dense_output(), self.wanted[self.filled : upto]
        if self.clock is not None:
            wanted = np.array([_when(dense, w, solver.t_old, reached) for w in wanted])
        self.states[self.filled : upto] = dense(wanted).T
        if self.clock is None and until is None and wanted[-1] == solver.t:
            self.states[upto - 1] = solver.y
        self.filled = upto


def _when(dense: Any, value: float, low: float, high: float) -> float:
    """The time within a step at which the clock has a value."""
    from scipy.optimize import brentq

    ends = [float(dense(t)[-1]) - value for t in (low, high)]
    if ends[0] >= 0:
        return low
    if ends[1] <= 0:
        return high
    return float(brentq(lambda t: float(dense(t)[-1]) - value, low, high, xtol=1e-300, rtol=ULPS))


def _first_zero(
    solver: Any, run: Evaluator, before: tuple[Floats, Floats], after: tuple[Floats, Floats]
) -> tuple[float, str] | None:
    """The first zero of a guard within the last step, and the guard's name."""
    if not run.flow.guards:
        return None
    step = solver.t - solver.t_old
    rates = [solver.y[i].item() for i in run.turning]
    parts, dense = run.looks, None
    if run.turning and LOOKS * step * math.hypot(1.0, *rates) > 1:
        pace = max(1.0, *(abs(r) for r in rates))
        parts = int(min(max(1.0, np.ceil(LOOKS * step * pace)), MOST_LOOKS))
    times, seen = [solver.t_old, solver.t], [before, after]
    if parts > 1:
        dense = solver.dense_output()
        times = np.linspace(solver.t_old, solver.t, parts + 1).tolist()
        seen = [before, *(run.watch(dense(t)) for t in times[1:-1]), after]
    zeros: list[tuple[float, str]] = []
    for low, high, at_low, at_high in zip(times, times[1:], seen, seen[1:], strict=False):
        step = high - low
        for i, name in enumerate(run.flow.guards):
            # positive at the end, and no lowest point within
            if at_high[0][i] > 0 and not (step * at_low[1][i] < 0 < step * at_high[1][i]):
                continue
            if dense is None:
                dense = solver.dense_output()
            zero = _locate(partial(_value, run, dense, i), low, high)
            if zero is not None:
                zeros.append((zero, name))
        if zeros:
            break
    return min(zeros, default=None)


def _value(run: Evaluator, dense: Any, i: int, t: float) -> float:
    """Value of guard i on the dense output."""
    value = float(run.watch(dense(t))[0][i])
    # a user's condition may have no value beyond its zero
    return -1.0 if math.isnan(value) and not run.flow.model.turning else value


def _locate(guard: Callable[[float], float], low: float, high: float) -> float | None:
    """The first zero of a falling guard on [low, high], if it has one."""
    from scipy.optimize import brentq, minimize_scalar

    grid = np.linspace(low, high, 9)
    values = np.array([guard(t) for t in grid])
    below = np.flatnonzero(~(values > 0))
    below = below[below > 0]  # a run starts with its guards positive, or at zero and rising
    if below.size == 0:
        lowest = int(np.argmin(values))
        bracket = grid[max(lowest - 1, 0)], grid[min(lowest + 1, 8)]
        near = LOWEST * (bracket[1] - bracket[0])
        best = minimize_scalar(guard, bounds=bracket, method="bounded", options={"xatol": near})
        if not best.fun < 0:
            return None
        left, right = bracket[0], float(best.x)
    else:
        left, right = grid[below[0] - 1], grid[below[0]]
    if not np.isfinite(guard(right)):
        return None
    if guard(left) <= 0:
        return float(left)
    xtol = 1e-15 * max(1.0, abs(right))
    return float(brentq(guard, left, right, xtol=xtol, rtol=ULPS, maxiter=HALVINGS))


def of_scipy(
    name: str, solver: str, about: str, work: str = "", *, turn: float = 0.0
) -> Integrator:
    """A method of SciPy as an integrator.

    Parameters
    ----------
    name, about, turn
        As for `Integrator`.
    solver
        Name of its class in `scipy.integrate`.
    work
        Key of the work on the method, beyond that on SciPy.
    """
    run = partial(integrate, solver=solver)
    works = ("scipy", work) if work else ("scipy",)
    return Integrator(name, about, run, FINEST, works, turn=turn)


INTEGRATORS = (
    of_scipy("dop853", "DOP853", "explicit Runge-Kutta, order 8", "hairer1993", turn=190.0),
    of_scipy("lsoda", "LSODA", "multistep, switches at stiffness", "petzold1983"),
    of_scipy("radau", "Radau", "implicit Runge-Kutta, order 5", "hairer1996"),
    of_scipy("bdf", "BDF", "implicit multistep, in SciPy", "shampine1997"),
)
"""The SciPy routes."""
