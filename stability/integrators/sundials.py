"""The CasADi routes: CVODES on the explicit graph, IDAS on the implicit one; good where stiff.

A CasADi integrator runs through its whole grid in one call and cannot be stopped on the way.  So a
leg is first run as a whole, and the guards are then checked on the grid.  Where the library gave
up, an eighth of the intervals is tried, and twice as many behind each stretch that it finished.
Only an interval where a guard falls, or where the library gave up, is run again in small pieces.
"""

from __future__ import annotations

import io
from contextlib import redirect_stderr
from functools import lru_cache, partial
from typing import Any

import casadi as ca
import numpy as np

from ..base.types import Floats
from .flow import Flow
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

FILL, FILL_OWN = 200, 2000
"""Least number of intervals at which the guards are checked: of a body, of a user's system."""
LOOKS, MOST_LOOKS = 10.0, 50_000
"""Intervals in a unit of time over the motion's pace at the start, and most intervals."""
EARLY, EARLY_LOOKS = 1e-6, 25
"""Looks within the first of these intervals: the first, as a share of it, and their number."""
FINEST = 1e-15
"""Smallest tolerance that is passed to the library."""
STEPS, FEW = 5_000, 500
"""Steps within an interval after which the library gives up: one that is run alone, and others."""
EIGHTHS, ENDS = np.linspace(0.0, 1.0, 9), np.array([0.0, 1.0])
"""Where a short piece is checked, as shares of it."""
ZERO = 1e-6
"""Most that a guard may differ from zero at an event, over 1 or its size just before."""
DIP = 0.8
"""Least value of a guard's cubic, over the smaller one at an end, below which it may reach zero."""
SHORTEST = 1e-10
"""Length of an interval, relative to the whole, below which a failure is final."""


@lru_cache(maxsize=64)
def _integrator(
    flow: Flow, plugin: str, tolerance: tuple[float, float], steps: int, grid: bytes
) -> tuple[Any, Any]:
    """A CasADi integrator over a grid of fractions of a span T, and the function for its z0."""
    span = ca.SX.sym("span")
    problem = {"x": flow.x, "p": ca.vertcat(flow.p, span), "ode": span * flow.rhs}
    guess = None
    if plugin == "idas":
        system = flow.system
        assert system.mass is not None
        assert system.forcing is not None
        z = ca.SX.sym("z", len(system.unknowns))
        by_name = dict(zip(system.unknowns, ca.vertsplit(z), strict=True))
        rates = [by_name.get(f"d_{s}", flow.rhs[i]) for i, s in enumerate(system.states)]
        rest = flow.rhs[len(rates) :]
        problem |= {
            "z": z,
            "ode": span * ca.vertcat(*rates, rest),
            "alg": system.mass @ z - system.forcing,
        }
        guess = ca.Function("z0", [flow.x, flow.p], [ca.solve(system.mass, system.forcing)])
    options = {
        "reltol": tolerance[0],
        "abstol": tolerance[1],
        "max_num_steps": steps,
        "disable_internal_warnings": True,
        "show_eval_warnings": False,
    }
    if plugin == "idas":
        options["suppress_algebraic"] = True
    fractions = np.frombuffer(grid).tolist()
    return ca.integrator("run", plugin, problem, 0.0, fractions, options), guess


def _run(
    leg: Leg, plugin: str, start: Floats, span: float, fractions: Floats, most: int = STEPS
) -> tuple[Floats, int] | None:
    """States at fractions 0 to 1 of a span, and steps; None where the library gave up.

    A number that is not finite counts as given up.
    """
    tolerance = max(leg.tolerance, FINEST), max(leg.absolute, FINEST * 1e-3)
    most = min(most, leg.max_steps)
    run, guess = _integrator(leg.flow, plugin, tolerance, most, fractions[1:].tobytes())
    inputs = {"x0": start, "p": np.append(leg.p, span)}
    if guess is not None:
        inputs["z0"] = guess(start, leg.p)
    said = io.StringIO()
    try:
        with redirect_stderr(said):  # the library prints errors that it returns too
            states = np.array(run(**inputs)["xf"]).T
    except RuntimeError:
        if "KeyboardInterrupt" in said.getvalue():  # CasADi takes it for a failure of the graph
            raise KeyboardInterrupt from None
        return None
    steps = int(run.stats().get("nsteps", 0))
    return (np.vstack([start[None], states]), steps) if np.isfinite(states).all() else None


def integrate(leg: Leg, *, plugin: str) -> Path:
    """Run one leg with CVODES or IDAS: as a whole, and where that fails over fewer intervals."""
    times = leg.times
    if len(times) == 1:
        return Path(leg.start[None], None, 0)
    grid, budget = _grid(leg), Budget(leg.seconds)
    last, count, steps = len(grid) - 1, len(grid) - 1, 0
    rows, end = leg.start[None], None
    while end is None and len(rows) <= last:
        if count < last and budget.spent:  # the whole has failed
            end = End(UNRESOLVED, float(grid[len(rows) - 1]), rows[-1], budget.message)
            break
        some = grid[len(rows) - 1 :][: count + 1]
        states, end, more = _stretch(leg, plugin, some, rows[-1], budget)
        steps += more
        if steps > leg.max_steps and not (end and end.kind == UNRESOLVED):
            end = End(UNRESOLVED, float(some[0]), rows[-1], too_many(leg.max_steps))
            states, steps = states[:0], leg.max_steps
        rows = np.vstack([rows, states])
        count = 2 * count if len(states) else max(1, count // 8)
    at = np.searchsorted(grid, times)
    return Path(rows[at[at < len(rows)]], end, steps)


def _stretch(
    leg: Leg, plugin: str, grid: Floats, start: Floats, budget: Budget
) -> tuple[Floats, End | None, int]:
    """States behind the start, at times of a grid before an end; none where the library gave up.

    Of one interval there is always a state or an end.
    """
    span = float(grid[-1] - grid[0])
    fractions = (grid - grid[0]) / span
    fractions[-1] = 1.0
    got = _run(leg, plugin, start, span, fractions, STEPS if len(grid) < 3 else FEW)
    if got is None:
        if len(grid) > 2:
            return np.empty((0, len(start))), None, 0
        state, end, steps = _march(leg, plugin, grid, start, budget)
        return state[None][: end is None], end, steps
    states, steps = got
    for i in _suspects(leg, grid, states):  # nearly always a minimum that stays above zero
        _, end, more = _march(leg, plugin, grid[i : i + 2], states[i], budget)
        steps += more
        if end is not None:
            return states[1 : i + 1], end, steps
    return states[1:], None, steps


def _grid(leg: Leg) -> Floats:
    """Times at which guards are checked: those of the leg, and as many as the motion's pace needs.

    In a stiff motion slip first decays, over a time that an even grid would miss.
    """
    times = leg.times
    if leg.dense or not leg.flow.guards:
        return times
    span = float(times[-1] - times[0])
    pace = float(leg.flow.paces(leg.start[None], leg.p[None], np.array([span]))[0])
    least = FILL if leg.flow.model.turning else FILL_OWN
    count = int(min(max(least, LOOKS * span * pace), MOST_LOOKS))
    even = np.linspace(times[0], times[-1], count + 1)
    early = times[0] + (even[1] - even[0]) * np.geomspace(EARLY, 0.7, EARLY_LOOKS)
    grid = np.union1d(times, np.union1d(even, early))
    grid = grid[np.append(True, np.diff(grid) > 1e-14 * max(abs(times[-1]), 1e-300))]
    return np.union1d(grid, times)


def lowest(g0: Floats, g1: Floats, d0: Floats, d1: Floats) -> Floats:
    """Least value between the ends of cubics with these values and slopes at 0 and 1.

    Slopes are times the length of the interval.  It is infinite for a cubic without a minimum
    between the ends.

    Examples
    --------
    >>> ones = np.ones(2)
    >>> lowest(ones, np.array([1.0, 2.0]), np.array([-4.0, 0.5]), np.array([4.0, 0.5])).tolist()
    [0.0, inf]
    """
    rise = g1 - g0
    square, cube = 3 * rise - 2 * d0 - d1, d0 + d1 - 2 * rise
    with np.errstate(all="ignore"):
        root = np.sqrt(square**2 - 3 * cube * d0)
        s = np.where(square > 0, -d0 / (square + root), (root - square) / (3 * cube))
        value = g0 + s * (d0 + s * (square + s * cube))
    return np.where((s > 0) & (s < 1), value, np.inf)


def _falls(steps: Floats, values: Floats, rates: Floats) -> Any:
    """For each interval whether a guard ends it below zero, or may dip below within it."""
    ends, slopes = values[1:], steps[:, None] * rates[:-1]
    least = lowest(values[:-1], ends, slopes, steps[:, None] * rates[1:])
    return (~(ends > 0) | (least < DIP * np.minimum(values[:-1], ends))).any(axis=-1)


def _suspects(leg: Leg, grid: Floats, states: Floats) -> list[int]:
    """The intervals in which a guard may reach zero."""
    values, rates = leg.flow.margins(states, leg.p)
    return [int(i) for i in np.flatnonzero(_falls(np.diff(grid), values, rates))]


def _march(
    leg: Leg, plugin: str, span: Floats, start: Floats, budget: Budget
) -> tuple[Floats, End | None, int]:
    """Run over one interval in pieces as short as needed, each checked; the state where it ends."""
    state, time, target, steps = start, float(span[0]), float(span[1]), 0
    # the library cannot be stopped on the way: the time is checked between the pieces
    shortest = SHORTEST * float(leg.times[-1] - leg.times[0])
    piece = target - time
    while time < target:
        if budget.spent:
            return state, End(UNRESOLVED, time, state, budget.message), steps
        piece = min(piece, target - time)
        got = _run(leg, plugin, state, piece, EIGHTHS)
        if got is None:
            piece /= 8
            steps += min(STEPS, leg.max_steps)
            if piece < shortest or steps > leg.max_steps:
                why = lost(plugin, state) if piece < shortest else too_many(leg.max_steps)
                return state, End(UNRESOLVED, time, state, why), steps
            continue
        states, more = got
        steps += more
        if steps > leg.max_steps:
            return state, End(UNRESOLVED, time, state, too_many(leg.max_steps)), steps
        fine = time + piece * EIGHTHS
        for fall in _suspects(leg, fine, states):
            end = _locate(leg, plugin, fine[fall : fall + 2], states[fall])
            if end is not None:
                return states[fall], end, steps
        whole = piece == target - time
        state, time = states[-1], target if whole else float(fine[-1])
    return state, None, steps


def _locate(leg: Leg, plugin: str, span: Floats, start: Floats) -> End | None:
    """The first guard that reaches zero within a short interval, by bisection on its length."""
    from scipy.optimize import brentq, minimize_scalar

    low, high = float(span[0]), float(span[1])

    def at(t: float) -> Floats:
        if t <= low:
            return start
        got = _run(leg, plugin, start, t - low, ENDS)
        return np.full_like(start, np.nan) if got is None else got[0][-1]

    ends: list[tuple[float, str]] = []
    for i, name in enumerate(leg.flow.guards):

        def guard(t: float, i: int = i) -> float:
            value = float(leg.flow.margins(at(t), leg.p)[0][i])
            return value if np.isfinite(value) else -1.0

        right = high
        if guard(high) > 0:
            best = minimize_scalar(
                guard,
                bounds=(low, high),
                method="bounded",
                options={"xatol": LOWEST * (high - low)},
            )
            if not best.fun < 0:
                continue
            right = float(best.x)
        if guard(low) <= 0:
            ends.append((low, name))
            continue
        xtol = 4 * np.finfo(float).eps * max(1.0, abs(high))
        ends.append((float(brentq(guard, low, right, xtol=xtol, maxiter=HALVINGS)), name))
    if not ends:
        return None
    when, name = min(ends)
    state = at(when)
    index = list(leg.flow.guards).index(name)
    left, first = (abs(float(leg.flow.margins(y, leg.p)[0][index])) for y in (state, start))
    if not left < ZERO * max(1.0, first):  # the integrator failed there, or the state is not finite
        return End(UNRESOLVED, low, start, lost(plugin, start))
    return End(name, when, state)


def _without_mass(flow: Flow) -> str:
    """Why IDAS cannot integrate a flow."""
    if flow.system.mass is not None:
        return ""
    return (
        f"which integrates mass · u = forcing, and {flow.system.name} has no mass matrix; take "
        "cvodes, or System.from_mass_matrix"
    )


INTEGRATORS = (
    Integrator(
        "cvodes",
        "implicit multistep, in SUNDIALS",
        partial(integrate, plugin="cvodes"),
        FINEST,
        ("sundials",),
        finer=1e-2,  # the errors at two neighbouring decades can be equal by chance
    ),
    Integrator(
        "idas",
        "implicit multistep for differential-algebraic equations, in SUNDIALS",
        partial(integrate, plugin="idas"),
        FINEST,
        ("sundials",),
        finer=1e-2,
        refuses=_without_mass,
    ),
)
"""The CasADi routes."""
