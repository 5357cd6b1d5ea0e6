"""The Taylor route: heyoka integrates the same graph, one launch or many at once (optional)."""

from __future__ import annotations

import copy
import importlib.util
import math
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from contextlib import closing, contextmanager
from dataclasses import dataclass, replace
from functools import cache, lru_cache, partial
from threading import Lock
from typing import Any

import casadi as ca
import numpy as np

from ..algebra.number_types import heyoka, heyoka_algebra
from ..algebra.program import Program
from ..base.errors import StabilityError
from ..base.types import Floats
from ..bodies.model import NO_CONTACT
from ..jobs.pipeline import Counted, here, ordered, shared, threads
from .flow import ASKING, Flow
from .leg import UNRESOLVED, Budget, End, Integrator, Leg, Path, guard_at, lost, too_many

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
FEW = 64
"""Largest number of launches that first run by code made quickly."""


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


def expressions(flow: Flow) -> tuple[list[Any], list[Any], list[Any]]:
    """Symbols, rates and events; lanes of a batch have one event, the product of the guards."""
    hy = heyoka()
    product, own = ca.SX(1), flow.model.parking is None
    for name, guard in flow.guards.items():
        if name == NO_CONTACT and flow.friction:
            continue  # it vanishes with gn D only: a change of both signs would hide in the product
        product = product * guard
    # a guard of the parameters alone never changes on the way, and heyoka takes no such event
    moving = [ca.SX(g) for g in flow.guards.values() if ca.depends_on(ca.SX(g), flow.x)]
    watched = moving if own else [product]
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
class _Held:
    """A compiled integrator, lent to one thread at a time."""

    spare: list[Any]
    """Copies that are not in use."""
    build: Callable[[], Any]
    """Function that makes the first copy."""
    lock: Any
    """Lock of the list."""

    def take(self) -> Any:
        with self.lock:
            if len(self.spare) > 1:
                return self.spare.pop()
            if not self.spare:
                self.spare.append(self.build())
            return copy.deepcopy(self.spare[0])

    def give(self, integrator: Any) -> None:
        with self.lock:
            if len(self.spare) <= CORES:
                self.spare.append(integrator)


@lru_cache(maxsize=64)
def _single(flow: Flow, tolerance: float, effort: int) -> _Held:
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

    return _Held([], build, Lock())


def _taken(leg: Leg, effort: int) -> tuple[_Held, Any]:
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
    return _sound(leg, Path(np.asarray(states), end, int(steps)))


def _longest(leg: Leg) -> float:
    """The longest step; no two tolerances have their steps at the same places."""
    if leg.flow.model.turning:
        return math.inf
    return float(leg.times[-1] - leg.times[0]) / (PIECES + 7 * abs(math.log10(leg.tolerance)))


def _sound(leg: Leg, path: Path) -> Path:
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
        return _on_guard(leg, time, state)
    why = too_many(leg.max_steps) if outcome.name == "step_limit" else lost("heyoka", state)
    return End(UNRESOLVED, time, state, why)


def longest_shift(flow: Flow, span: Any) -> Any:
    """Longest step that moves an event to its guard's zero in a run of some length."""
    return SHIFT if flow.model.turning else SHIFT * np.minimum(1.0, span)


def _on_guard(leg: Leg, time: float, state: Floats) -> End:
    """The end at an event, moved along the motion to where its guard is zero.

    At a loose tolerance the event lies on the step's polynomial, next to the guard's zero.
    """
    kind = guard_at(leg.flow, leg.p, state)
    index = list(leg.flow.guards).index(kind)
    rates = leg.flow.quick.rates
    most = longest_shift(leg.flow, float(leg.times[-1] - leg.times[0]))
    for _ in range(NEWTON):
        value, rate = (float(part[index]) for part in leg.flow.margins(state, leg.p))
        step = -value / rate if rate < 0 else 0.0
        moving = rates(leg.p, state)
        # no step at a crossing that flattens, or where the force has no value
        if not abs(step) < most or not np.isfinite(moving).all():
            break
        time, state = time + step, state + step * moving
    return End(kind, time, state)


class _Stop:
    """Records the end of a lane of a batch, and parks the lane.

    The other lanes continue, so the ended lane must follow a motion: that of the model's parking.
    """

    def __init__(self, parking: Callable[[Any, Any, int], None]) -> None:
        self.ends: dict[int, tuple[float, Floats]] = {}
        self.parking = parking

    def __call__(self, ta: Any, _sign: Any, lane: int) -> bool:
        if lane not in self.ends:
            self.ends[lane] = float(ta.time[lane]), ta.state[:, lane].copy()
        self.parking(ta.state, ta.pars, lane)
        return True


@lru_cache(maxsize=64)
def _batch(flow: Flow, tolerance: float, width: int, effort: int) -> _Held:
    def build() -> Any:
        hy = heyoka()
        symbols, rates, guards = expressions(flow)
        down, events, more = hy.event_direction.negative, [], {}
        if flow.model.parking is not None:
            more = {"pars": np.ones((flow.p.numel(), width))}
            stop = _Stop(flow.model.parking)
            events = [hy.t_event_batch(guards[0], callback=stop, direction=down)]
        return hy.taylor_adaptive_batch(
            list(zip(symbols, rates, strict=True)),
            np.zeros((len(symbols), width)),
            tol=tolerance,
            t_events=events,
            compact_mode=compact(flow),
            opt_level=effort,
            **more,
        )

    return _Held([], build, Lock())


def integrate_many(
    legs: Sequence[Leg],
    workers: int | None = None,
    progress: Counted | None = None,
    executor: Executor | None = None,
) -> list[Path]:
    """Run many legs of one flow and tolerance: as many at once as the processor has lanes.

    A flow with guards needs a model that parks the lanes that have ended.

    Parameters
    ----------
    legs
        Legs that share flow, number of times and tolerance.
    workers
        Number of threads; by default that of the cores.  Each has its own integrator.
    progress
        Counts the legs of each batch when the batch is finished.
    executor
        Executor in place of the threads, or None.

    Returns
    -------
    list of Path
        In the order of the legs; a lane's result does not depend on the number of workers.
    """
    hy = heyoka()
    width: int = hy.recommended_simd_size()
    groups = [range(i, min(i + width, len(legs))) for i in range(0, len(legs), width)]
    flow, count = shared(legs[0].flow, executor), min(workers or CORES, len(groups))
    first = QUICK if len(legs) <= FEW else OPTIMISED

    def task(group: range) -> Callable[[], list[Path]]:
        return partial(_together, flow, width, first, [legs[i].numbers for i in group])

    with closing(
        ordered(
            groups,
            task,
            executor=executor,
            workers=count,
            own=threads if count > 1 else here,
            progress=progress,
            size=len,
        )
    ) as results:
        return [path for _, paths in results for path in paths]


def _together(
    flow: Callable[[], Flow], width: int, effort: int, numbers: list[tuple[Any, ...]]
) -> list[Path]:
    """One batch, in a worker."""
    return _lanes([Leg(flow(), *some) for some in numbers], width, effort)


def _lanes(legs: list[Leg], width: int, effort: int, budget: Budget | None = None) -> list[Path]:
    """One batch; lanes that have no launch repeat the last one.

    Without a budget it begins with `QUIET` steps; where they do not suffice it runs again with one.
    """
    hy = heyoka()
    held = _batch(legs[0].flow, max(legs[0].tolerance, FINEST), width, effort)
    ta = held.take()
    filled = legs + legs[-1:] * (width - len(legs))
    ends = ta.t_events[0].callback.ends if ta.with_events else {}
    ta.state[:] = np.column_stack([leg.start for leg in filled])
    ta.pars[:] = np.column_stack([leg.p for leg in filled])[: len(ta.pars)]
    ta.set_time([float(leg.times[0]) for leg in filled])
    if ta.with_events:
        ta.reset_cooldowns()
    ends.clear()
    most = max(leg.max_steps for leg in legs)
    steps, watch = (min(QUIET, most), {}) if budget is None else (most, {"callback": budget})
    states = ta.propagate_grid(
        np.column_stack([leg.times for leg in filled]),
        max_steps=steps,
        max_delta_t=[_longest(leg) for leg in filled],
        **watch,
    )[1]
    if steps < most and any(r[0] == hy.taylor_outcome.step_limit for r in ta.propagate_res):
        held.give(ta)
        return _lanes(legs, width, OPTIMISED, Budget(sum(leg.seconds for leg in legs)))
    with ASKING:
        paths = _read(ta, legs, states, ends)
    held.give(ta)
    return paths


def _read(
    ta: Any, legs: list[Leg], states: Floats, ends: Mapping[int, tuple[float, Floats]]
) -> list[Path]:
    """The paths of a batch that has run; evaluates the guards."""
    hy = heyoka()
    paths = []
    for lane, leg in enumerate(legs):
        outcome, _, _, steps = ta.propagate_res[lane]
        mine, end = states[:, :, lane], None
        if lane in ends:
            end = _on_guard(leg, *ends[lane])
            mine = mine[: np.searchsorted(leg.times, end.time)]
        if outcome != hy.taylor_outcome.time_limit or not np.isfinite(mine).all():
            paths.append(integrate(leg))  # one lane failed and stopped all: each runs alone
            continue
        paths.append(_sound(leg, Path(mine, end, int(steps))))
    return paths


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
