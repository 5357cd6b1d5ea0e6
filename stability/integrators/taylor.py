"""The Taylor route: heyoka integrates the same graph (optional); many launches are in `lanes`."""

from __future__ import annotations

import copy
import importlib.util
import math
import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import cache, lru_cache
from threading import Lock
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from ..algebra.number_types import heyoka, heyoka_algebra
from ..algebra.program import Program
from ..base.errors import StabilityError
from ..base.types import Floats
from ..bodies.model import NO_CONTACT
from .flow import Flow
from .leg import UNRESOLVED, Budget, End, Integrator, Leg, Path, lost, too_many

CORES = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
"""Default number of threads for batches."""
FINEST = 1e-16
"""Smallest tolerance that is passed to the library."""
NEWTON, SHIFT = 3, 1e-3
"""Steps that move an event to its guard's zero, and the longest of them [√(R/g)]."""
PIECES = 1000
"""Least number of steps where the model names no angular velocities.  A series does not see a pulse
that is flat at the series' centre: its step and those of all neighbours would pass over it."""
LONG = 400
"""Most operations of a flow whose machine code is unrolled."""
QUIET = 20_000
"""Steps before the computing time is checked: a check at each step costs a tenth.  So many steps
take less time than optimising their machine code: it is optimised for longer runs alone."""
QUICK, OPTIMISED = 0, 3
"""Effort of the compiler."""


@cache
def available() -> bool:
    """Whether heyoka is installed."""
    return importlib.util.find_spec("heyoka") is not None


@lru_cache(maxsize=64)
def unread(flow: Flow) -> str:
    """Reason why heyoka cannot integrate a flow; empty where it can."""
    try:
        expressions(flow)
    except StabilityError as error:
        return str(error)
    except KeyError as error:
        return f"the graph has the function {error.args[0]}, which has no Taylor series everywhere"
    return ""


@lru_cache(maxsize=64)
def expressions(flow: Flow) -> tuple[list[Any], list[Any], list[Any]]:
    """Symbols, rates and events: the guards, or their product where `sound` tells what it hides."""
    hy = heyoka()
    product, separate = ca.SX(1), flow.model.sound is None
    for name, guard in flow.guards.items():
        if name == NO_CONTACT and flow.friction:
            continue  # it vanishes with gn D only: a change of both signs would hide in the product
        product = product * guard
    # a guard of the parameters alone never changes on the way, and heyoka takes no such event
    moving = [ca.SX(g) for g in flow.guards.values() if ca.depends_on(ca.SX(g), flow.x)]
    watched = moving if separate else [product]
    program = Program(ca.Function("taylor", [flow.x, flow.p], [flow.rhs, *watched]))
    symbols = [hy.make_vars(name) for name in flow.names]
    parameters = [hy.par[i] for i in range(flow.p.numel())]
    algebra = heyoka_algebra()
    values = program.dense(algebra, [symbols, parameters])
    events = program.run(algebra, [symbols, parameters])[1:]
    return symbols, [row[0] for row in values], [event[0] for event in events if event]


def compact(flow: Flow) -> bool:
    """Whether machine code is made of loops: a long graph unrolled takes the compiler minutes."""
    return ca.Function("size", [flow.x, flow.p], [flow.rhs]).n_instructions() > LONG


@dataclass(frozen=True, eq=False)
class Compiled:
    """A compiled integrator, lent to one thread at a time."""

    build: Callable[[], Any]
    """Function that makes the first copy."""
    most: int = CORES
    """Most copies that are kept."""
    spare: list[Any] = field(default_factory=list)
    """Copies that are not in use."""
    lock: Any = field(default_factory=Lock)
    """Lock of the list."""

    def take(self) -> Any:
        """A copy for the calling thread."""
        with self.lock:
            if len(self.spare) > 1:
                return self.spare.pop()
            if not self.spare:
                self.spare.append(self.build())
            return copy.deepcopy(self.spare[0])

    def give(self, integrator: Any) -> None:
        """Take a copy back."""
        with self.lock:
            if len(self.spare) <= self.most:
                self.spare.append(integrator)


@lru_cache(maxsize=64)
def _single(flow: Flow, tolerance: float, effort: int) -> Compiled:
    def build() -> Any:
        hy = heyoka()
        symbols, rates, guards = expressions(flow)
        down = hy.event_direction.negative
        return hy.taylor_adaptive(
            list(zip(symbols, rates, strict=True)),
            np.zeros(len(symbols)),
            tol=tolerance,
            compact_mode=compact(flow),
            opt_level=effort,
            t_events=[hy.t_event(guard, direction=down) for guard in guards],
        )

    return Compiled(build)


def _taken(leg: Leg, effort: int) -> tuple[Compiled, Any]:
    """A compiled integrator at the start of a leg, and what it is to be given back to."""
    held = _single(leg.flow, max(leg.tolerance, FINEST), effort)
    ta = held.take()
    ta.state[:] = leg.start
    ta.pars[:] = leg.p[: len(ta.pars)]  # as many as the equations have
    ta.time = leg.times[0]
    if ta.with_events:
        ta.reset_cooldowns()
    return held, ta


@contextmanager
def lent(leg: Leg) -> Iterator[Any]:
    """A compiled integrator at the start of a leg, for a run of another kind."""
    held, ta = _taken(leg, QUICK)
    yield ta
    held.give(ta)


def integrate(leg: Leg) -> Path:
    """Run one leg with heyoka's adaptive Taylor integrator and its event detection."""
    hy = heyoka()
    held, ta = _taken(leg, QUICK)
    quiet = min(QUIET, leg.max_steps)
    longest = _longest(leg)
    outcome, _, _, steps, _, states = ta.propagate_grid(
        leg.times, max_steps=quiet, max_delta_t=longest
    )
    message = ""
    if outcome == hy.taylor_outcome.step_limit and leg.max_steps > quiet:
        left, state = np.append(ta.time, leg.times[len(states) :]), ta.state.copy()
        held.give(ta)
        held, ta = _taken(leg, OPTIMISED)
        ta.state[:], ta.time = state, left[0]
        most, budget = leg.max_steps - quiet, Budget(leg.seconds)
        outcome, _, _, more, _, rest = ta.propagate_grid(
            left, max_steps=most, max_delta_t=longest, callback=budget
        )
        steps, states, message = steps + more, np.vstack([states, rest[1:]]), budget.message
    end = None
    if outcome != hy.taylor_outcome.time_limit:
        end = _end(leg, outcome, ta, np.asarray(states))
        if outcome == hy.taylor_outcome.cb_stop:
            end = replace(end, message=message)
        states = states[: max(1, int(np.searchsorted(leg.times, end.time)))]
    held.give(ta)
    return sound(leg, Path(np.asarray(states), end, int(steps)))


def _longest(leg: Leg) -> float:
    """The longest step; no two tolerances have their steps at the same places."""
    if leg.flow.model.turning:
        return math.inf
    return float(leg.times[-1] - leg.times[0]) / (PIECES + 7 * abs(math.log10(leg.tolerance)))


def sound(leg: Leg, path: Path) -> Path:
    """The path, or an unresolved one where an event was lost: a guard is not positive at a sample.

    heyoka logs a root that it could not isolate, and continues.
    """
    if path.end is not None:
        return path
    last = path.states[-1]
    look = leg.flow.model.sound
    seen = path.states if look is None else last
    if (leg.flow.margins(seen, leg.p)[0] > 0).all() and (look is None or look(path.states)):
        return path
    end = End(UNRESOLVED, float(leg.times[0]), leg.start, "heyoka lost an event")
    return Path(leg.start[None], end, path.steps)


def _end(leg: Leg, outcome: Any, ta: Any, states: Floats) -> End:
    time, state = float(ta.time), ta.state.copy()
    if not (np.isfinite(state).all() and math.isfinite(time)):
        good = max(0, int(np.isfinite(states).all(axis=1).sum()) - 1)  # the start is one of them
        time, state = float(leg.times[good]), states[good] if len(states) else leg.start
    elif int(outcome) > -(2**32) - 1:
        return on_guards([leg], np.array([time]), state[None])[0]
    why = too_many(leg.max_steps) if outcome.name == "step_limit" else lost("heyoka", state)
    return End(UNRESOLVED, time, state, why)


def at_guards(
    flow: Flow, p: Floats, states: Floats, times: Floats, spans: Floats
) -> tuple[NDArray[np.intp], Floats, Floats]:
    """Events moved along the motion to where their guards are zero.

    At a loose tolerance an event lies on the polynomial of a step, next to the guard's zero.

    Parameters
    ----------
    flow
        The flow.
    p, states
        Its parameters and y at the events, shapes (N, m) and (N, n).
    times, spans
        Times of the events, and lengths of their runs, shape (N,).

    Returns
    -------
    which, times, states
        Number of the guard that is zero, and the moved event.
    """
    which, pick = np.argmin(np.abs(flow.margins(states, p)[0]), axis=1), np.arange(len(states))
    longest = SHIFT if flow.model.turning else SHIFT * np.minimum(1.0, spans)
    for _ in range(NEWTON):
        values, rates = (part[pick, which] for part in flow.margins(states, p))
        with np.errstate(all="ignore"):
            step = np.where(rates < 0, -values / rates, 0.0)
            moving = flow.rates_at(states, p)
            # no step at a crossing that flattens, or where the force has no value
            good = (np.abs(step) < longest) & np.isfinite(moving).all(axis=1)
        step = np.where(good, step, 0.0)
        times = times + step
        states = states + step[:, None] * np.where(good[:, None], moving, 0.0)
    return which, times, states


def on_guards(legs: Sequence[Leg], times: Floats, states: Floats) -> list[End]:
    """The ends of legs of one flow at events."""
    if not legs:
        return []
    flow, p = legs[0].flow, np.array([leg.p for leg in legs])
    spans = np.array([leg.times[-1] - leg.times[0] for leg in legs])
    which, times, states = at_guards(flow, p, states, times, spans)
    names = list(flow.guards)
    return [
        End(names[k], time, state)
        for k, time, state in zip(which.tolist(), times.tolist(), states, strict=True)
    ]


def _refuses(flow: Flow) -> str:
    """Why heyoka cannot integrate a flow, as the end of a sentence."""
    why = unread(flow)
    return f"but {why.rstrip('.')}; take another method" if why else ""


INTEGRATORS = (
    Integrator(
        "heyoka",
        "Taylor series in compiled code",
        integrate,
        FINEST,
        ("heyoka",),
        finer=1e-2,  # its cost hardly rises
        turn=500.0,
        available=lambda: available(),  # read when asked
        refuses=_refuses,
    ),
)
"""The one integrator of heyoka, which is optional."""
