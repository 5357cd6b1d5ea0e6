"""The SciPy routes: DOP853, LSODA, Radau and BDF on the CasADi graph, watched step by step."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from .flow import Evaluator
from .route import UNRESOLVED, End, Floats, Leg, Path

FINEST = 100 * np.finfo(float).eps
"""Smallest relative tolerance that SciPy accepts."""
NAMES = {"dop853": "DOP853", "lsoda": "LSODA", "radau": "Radau", "bdf": "BDF"}
"""SciPy's class by the name of the method."""
ULPS = 4 * np.finfo(float).eps
"""Relative accuracy to which an event is located."""
STIFF = ("lsoda", "radau", "bdf")
"""Those that use the Jacobian, which is automatic."""


def integrate(leg: Leg, *, method: str) -> Path:
    """Run one leg with a SciPy solver and locate the first guard that reaches zero.

    After each step the guards and their rates are evaluated at its end.  A sign change, or a
    cubic through both ends that dips below zero, is resolved on the solver's dense output.

    Parameters
    ----------
    leg
        What is asked.
    method
        A key of `NAMES`.

    Returns
    -------
    Path
    """
    from scipy import integrate as scipy_integrate

    run = Evaluator(leg.flow, leg.p)
    options: dict[str, Any] = {"rtol": max(leg.tolerance, FINEST), "atol": leg.tolerance}
    if method in STIFF:
        options["jac"] = run.jacobian
    states = np.empty((len(leg.times), len(leg.start)))
    states[0] = leg.start
    filled, steps = 1, 0
    last = float(leg.times[-1])
    if len(leg.times) == 1:
        return Path(states, None, 0)
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")  # a solver's trouble is reported by its status
        solver = getattr(scipy_integrate, NAMES[method])(
            run.rates, float(leg.times[0]), leg.start, last, **options
        )
        good = leg.start.copy()
        before = run.watch(leg.start)
        while solver.status == "running":
            message = solver.step()
            steps += 1
            if (
                solver.status == "failed"
                or not np.isfinite(solver.y).all()
                or steps > leg.max_steps
            ):
                why = message or (
                    f"more than {leg.max_steps} steps" if steps > leg.max_steps
                    else "the state is not finite"
                )  # fmt: skip
                end = End(UNRESOLVED, float(solver.t_old or leg.times[0]), good, why)
                return Path(states[:filled], end, steps)
            after = run.watch(solver.y)
            dense = None
            when = _first_zero(solver, run, before, after)
            reached = solver.t if when is None else when[0]
            upto = int(np.searchsorted(leg.times, reached, "left" if when else "right"))
            if upto > filled or when is not None:
                dense = solver.dense_output()
                if upto > filled:
                    states[filled:upto] = dense(leg.times[filled:upto]).T
                    if reached == last and when is None:
                        states[-1] = solver.y
                filled = max(upto, filled)
            if when is not None and dense is not None:
                state = dense(when[0])
                return Path(states[:filled], End(when[1], when[0], state), steps)
            before, good = after, solver.y.copy()
    return Path(states[:filled], None, steps)


def _first_zero(
    solver: Any, run: Evaluator, before: tuple[Floats, Floats], after: tuple[Floats, Floats]
) -> tuple[float, str] | None:
    """The first zero of a guard within the last step, and the guard's name."""
    step = solver.t - solver.t_old
    found: list[tuple[float, str]] = []
    dense = None
    for i, name in enumerate(run.flow.guards):
        g0, g1 = before[0][i], after[0][i]
        d0, d1 = step * before[1][i], step * after[1][i]
        if g1 > 0 and not dips(g0, g1, d0, d1):
            continue
        dense = dense or solver.dense_output()
        zero = _locate(partial(_value, run, dense, i), solver.t_old, solver.t)
        if zero is not None:
            found.append((zero, name))
    return min(found, default=None)


def _value(run: Evaluator, dense: Any, i: int, t: float) -> float:
    """Guard i on the dense output."""
    return float(run.watch(dense(t))[0][i])


def dips(g0: float, g1: float, d0: float, d1: float) -> bool:
    """Whether the cubic with these values and slopes on [0, 1] comes within reach of zero."""
    if d0 >= 0 or d1 <= 0:
        return False
    s = np.linspace(0.0, 1.0, 9)
    cubic = (
        g0 * (1 + 2 * s) * (1 - s) ** 2 + d0 * s * (1 - s) ** 2
        + g1 * s**2 * (3 - 2 * s) + d1 * s**2 * (s - 1)
    )  # fmt: skip
    return bool(cubic.min() < 0.2 * min(g0, g1))


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
        best = minimize_scalar(guard, bounds=bracket, method="bounded")
        if not best.fun < 0:
            return None
        left, right = bracket[0], float(best.x)
    else:
        left, right = grid[below[0] - 1], grid[below[0]]
    if not np.isfinite(guard(right)):
        return None
    if guard(left) <= 0:
        return float(left)
    return float(brentq(guard, left, right, xtol=1e-15 * max(1.0, abs(right)), rtol=ULPS))


METHODS = {name: partial(integrate, method=name) for name in NAMES}
"""The SciPy routes by name."""
