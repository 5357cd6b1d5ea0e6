"""Many launches on the lanes of heyoka's batch mode; a lane takes the next launch when one ends.

A map of outcomes keeps no samples: after every `STRIDE` steps of a lane its state is shown to a
watcher, which ends the launch where its outcome is proved.  Many batches then move by turns, so
that the watcher sees many states at once.  Motions keep their samples, and have no watcher.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor
from contextlib import closing, contextmanager
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..algebra.number_types import heyoka
from ..base.types import Floats
from ..bodies.model import WORK
from ..jobs.pipeline import Counted, here, ordered, shared, threads
from .flow import ASKING, Flow, flow_of
from .leg import Budget, Leg, Path
from .taylor import (
    CORES,
    FINEST,
    OPTIMISED,
    PIECES,
    QUICK,
    QUIET,
    Compiled,
    compact,
    expressions,
    integrate,
    on_guards,
    sound,
)

STRIDE, UNSEEN = 128, 256
"""Steps of a lane between two looks of the watcher, and of a lane without one: its launches are
replaced later, but fewer calls are made."""
WIDTH = 2
"""Lanes of a batch over those of the processor's registers: fewer calls of the library."""
TURNS = 256
"""Most batches of one thread that move by turns, for a watcher."""
ALONE, FEW = 16, 256
"""Largest numbers of motions that run one by one, and for which the compiler makes no effort: to
compile lanes, or to optimise their code, takes longer than the motions."""
TOGETHER = 128
"""Motions in one piece of work."""
TINY, SPACE = 1e-300, 1e-15
"""Length of a step of a lane that stands still; least distance of two times, over the last one."""
RUNNING, LASTED, EVENT, PROVED, FAILED = range(5)
"""How a launch stands: it runs, it lasted to its last time, a guard's product reached zero, its
outcome is proved, or the integrator gave up."""

Watch = Callable[[NDArray[np.intp], Floats, Floats], NDArray[np.bool_]]
"""(launches, their states y, their times) → whether the outcome of each is proved."""


@dataclass(frozen=True, eq=False)
class Ends:
    """Ends of N launches, dimensionless for a body."""

    kind: NDArray[np.int8]
    """One of `LASTED`, `EVENT`, `PROVED`, `FAILED`, shape (N,)."""
    time: Floats
    """Time of the end, shape (N,)."""
    state: Floats
    """y at the end, shape (N, n)."""
    steps: NDArray[np.int64]
    """Steps taken, shape (N,)."""
    samples: Floats | None = None
    """y at the times that were asked for, NaN after the end, shape (N, t, n), or None."""


def ends(
    flow: Flow,
    starts: Floats,
    p: Floats,
    horizon: Floats,
    tolerance: float,
    most: int | NDArray[np.int64],
    watch: Watch | None = None,
    *,
    times: Floats | None = None,
    seconds: Floats | None = None,
    effort: int = OPTIMISED,
) -> Ends:
    """Run launches of one flow to their ends.

    Parameters
    ----------
    flow
        The flow; heyoka must be able to read it.
    starts, p
        y and parameters of the launches, shapes (N, n) and (N, m), dimensionless for a body.
    horizon
        Last time of each, shape (N,).
    tolerance
        Error allowed in a step.
    most
        Steps after which a launch fails, one number or shape (N,).
    watch
        Watcher, or None.
    times
        Times of samples, rising from 0 to the horizon, shape (N, t), or None; not with a watcher.
    seconds
        Computing time after which each launch fails, shape (N,), or None [s].
    effort
        Effort of the compiler.

    Returns
    -------
    Ends
        A launch's end does not depend on the other launches.  With samples it does by rounding:
        the library goes on from a time in one double.

    Source: tests/integrators/test_lanes.py.
    """
    count = len(starts)
    result = Ends(
        np.zeros(count, dtype=np.int8),
        np.zeros(count),
        np.array(starts, dtype=float),
        np.zeros(count, dtype=np.int64),
        None if times is None else np.full((count, times.shape[1], starts.shape[1]), np.nan),
    )
    if not count:
        return result
    if result.samples is not None:
        result.samples[:, 0] = starts
    batches = min(1 if watch is None else TURNS, -(-count // lanes_of_batch()))
    with _lent(_batch(flow, max(tolerance, FINEST), effort), batches) as taken:
        steps = np.broadcast_to(most, count)
        run = _LaneRun(flow, taken, p, horizon, tolerance, steps, watch, result)
        run.times, run.seconds = times, seconds
        run.to_the_end()
    return result


class _LaneRun:
    """Lanes in use: which launch each carries, and the launches that wait."""

    def __init__(
        self,
        flow: Flow,
        batches: list[Any],
        p: Floats,
        horizon: Floats,
        tolerance: float,
        most: NDArray[np.int64],
        watch: Watch | None,
        ends: Ends,
    ) -> None:
        self.batches, self.p, self.horizon, self.most = batches, p, horizon, most
        self.watch, self.ends, self.next = watch, ends, 0
        self.idle = ends.state[0].copy()
        self.times: Floats | None = None
        self.sampled = np.ones(len(p), dtype=np.intp)  # the start is the first
        self.seconds: Floats | None = None
        self.budgets: dict[int, Budget] = {}
        self.width = batches[0].batch_size
        shape = len(batches), self.width
        self.lanes = np.full(shape, -1, dtype=np.intp)
        self.last, self.longest = np.zeros(shape), np.full(shape, np.inf)
        pieces = math.inf if flow.model.turning else PIECES + 7 * abs(math.log10(tolerance))
        self.piece = horizon / pieces if math.isfinite(pieces) else None
        self.states = [batch.state for batch in batches]  # views of their memory
        self.codes, self.full = _outcomes(), heyoka().taylor_outcome.step_limit

    def to_the_end(self) -> None:
        """Move all lanes until no launch is left."""
        for at, batch in enumerate(self.batches):
            batch.set_time(0.0)
            for lane in range(self.width):
                self._clear(at, lane)
            self._refill(at, range(self.width))
        while (used := np.flatnonzero((self.lanes >= 0).any(axis=1))).size:
            self._look(used, np.stack([self._move(at) for at in used.tolist()]))

    def _clear(self, at: int, lane: int) -> None:
        """Let a lane stand still at a state where the equations have a value."""
        batch = self.batches[at]
        self.lanes[at, lane], self.last[at, lane], self.longest[at, lane] = -1, 0.0, np.inf
        batch.state[:, lane] = self.idle
        batch.pars[:, lane] = self.p[0, : len(batch.pars)]

    def _refill(self, at: int, free: Any) -> None:
        batch = self.batches[at]
        # both parts of each time: rounding would change the launches on the other lanes
        high, low = (np.array(part) for part in batch.dtime)
        for lane in free:
            high[lane] = low[lane] = 0.0
            mine = self.next
            if mine >= len(self.p):
                self._clear(at, lane)
                continue
            self.next += 1
            self._put(at, lane, mine)
            if self.seconds is not None:  # the lanes of a batch share its time
                self.budgets[mine] = Budget(float(self.seconds[mine]) * self.width)
            batch.state[:, lane] = self.ends.state[mine]
            batch.pars[:, lane] = self.p[mine, : len(batch.pars)]
            if batch.with_events:
                batch.reset_cooldowns(lane)
        batch.set_dtime(high, low)

    def _put(self, at: int, lane: int, launch: int) -> None:
        self.lanes[at, lane], self.last[at, lane] = launch, self.horizon[launch]
        if self.piece is not None:
            self.longest[at, lane] = self.piece[launch]

    def _propagate(self, at: int, last: Floats, steps: int) -> list[Any]:
        """Move a batch; outcome and number of steps of each lane."""
        batch, more = self.batches[at], {}
        if self.piece is not None:
            more = {"max_delta_t": self.longest[at]}
        if self.times is None or self.ends.samples is None:
            batch.propagate_until(last, max_steps=steps, **more)
        else:
            self._sample(at, self.times, self.ends.samples, steps, more)
        outcomes: list[Any] = batch.propagate_res
        return outcomes

    def _sample(
        self, at: int, times: Floats, samples: Floats, steps: int, more: dict[str, Any]
    ) -> None:
        """Move a batch, and keep the states at the times that its lanes have passed.

        The library takes equally many times for each lane.  In front of those that a lane has left
        come others, whose states are not kept.
        """
        batch, launches = self.batches[at], self.lanes[at]
        now, left = np.array(batch.time), times.shape[1] - self.sampled[launches]
        left[launches < 0] = 0
        most = int(left.max())
        place, others = np.arange(most + 1)[:, None], most + 1 - left
        gap = times[launches, -np.maximum(left, 1)] - now
        cramped = (launches >= 0) & (gap < others * SPACE * times[launches, -1])
        if cramped.any():  # too few doubles lie in front of its next time: it runs alone
            self.ends.kind[launches[cramped]] = FAILED
            self._refill(at, np.flatnonzero(cramped))
            self._sample(at, times, samples, steps, more)
            return
        gap[launches < 0] = TINY * (most + 1)  # stands still
        grid = times[launches, -most - 1 :].T
        grid = np.where(place < others, now + gap * (place / others), grid)
        states = batch.propagate_grid(grid, max_steps=steps, **more)[1]
        passed = (times[launches] <= np.array(batch.time)[:, None]).sum(axis=1)
        for lane in np.flatnonzero((launches >= 0) & (passed > self.sampled[launches])):
            launch, first = launches[lane], others[lane]
            kept = slice(self.sampled[launch], passed[lane])
            samples[launch, kept] = states[first:, :, lane][: kept.stop - kept.start]
            self.sampled[launch] = kept.stop

    def _move(self, at: int) -> NDArray[np.int8]:
        """Move one batch by a stride; how its lanes stand.

        A launch that ends stops the whole batch.  For a watcher the others then finish their
        stride, so that each is seen at the same steps and not where a neighbour ended.
        """
        stand, batch = np.zeros(self.width, dtype=np.int8), self.batches[at]
        carried, stride = self.lanes[at], STRIDE
        if self.watch is None:
            mine = carried[carried >= 0]
            stride = int(min(UNSEEN, (self.most[mine] - self.ends.steps[mine]).min()))
        results = self._propagate(at, self.last[at], stride)
        # the library says of all lanes at once that they have reached their limit of steps
        if results[0][0] == self.full and (batch.time < self.last[at]).all():
            self.ends.steps[carried] += stride
            return stand
        left, going = stride, carried >= 0
        while True:
            made = 0
            for lane, (outcome, _, _, steps) in enumerate(results):
                if going[lane]:
                    made = max(made, steps)
                    self.ends.steps[carried[lane]] += steps
                    stand[lane] = self.codes.get(int(outcome), EVENT)
            # of lanes that another one has stopped the library says that they have lasted
            stand[stand == LASTED] = RUNNING
            now = np.asarray(batch.time)
            stand[going & (stand == RUNNING) & (now >= self.last[at])] = LASTED
            wild = going & ~(np.isfinite(batch.state).all(axis=0) & np.isfinite(now))
            if wild.any():
                stand[wild] = FAILED
                batch.state[:, wild] = self.idle[:, None]
                high, low = (np.where(wild, 0.0, part) for part in batch.dtime)
                batch.set_dtime(high, low)
            going = going & (stand == RUNNING)
            left -= made or left
            if left <= 0 or not going.any() or self.watch is None:
                return stand
            results = self._propagate(at, np.where(going, self.last[at], batch.time), left)

    def _look(self, used: NDArray[np.intp], stand: NDArray[np.int8]) -> None:
        """Show the states to the watcher, write what has ended, and refill the lanes."""
        carried = self.lanes[used]
        going = (carried >= 0) & (stand == RUNNING)
        spent = going & (self.ends.steps[carried] >= self.most[carried])
        if self.seconds is not None:
            spent |= going & [[i >= 0 and self.budgets[i].spent for i in row] for row in carried]
        stand[spent] = FAILED
        if self.watch is None and not stand.any():
            return
        states = np.stack([self.states[at] for at in used.tolist()])  # (batches, n, lanes)
        times = np.stack([self.batches[at].time for at in used])
        if self.watch is not None:
            shown = (carried >= 0) & ((stand == RUNNING) | (stand == LASTED))
            if shown.any():
                where = np.nonzero(shown)
                proved = self.watch(carried[where], states[where[0], :, where[1]], times[where])
                stand[where[0][proved], where[1][proved]] = PROVED
        ended = np.nonzero((carried >= 0) & (stand != RUNNING))
        mine = carried[ended]
        self.ends.kind[mine] = stand[ended]
        self.ends.time[mine] = times[ended]
        self.ends.state[mine] = states[ended[0], :, ended[1]]
        for at in np.unique(ended[0]):
            self._refill(int(used[at]), ended[1][ended[0] == at])
        if self.next >= len(self.p):
            self._close_up()

    def _close_up(self) -> None:
        """Move the last launches together: a batch costs the same for one lane as for all."""
        for at in np.flatnonzero((self.lanes >= 0).any(axis=1))[::-1]:
            free = np.argwhere((self.lanes < 0) & (np.arange(len(self.lanes)) < at)[:, None])
            mine = np.flatnonzero(self.lanes[at] >= 0)
            if len(free) < len(mine):
                return
            for lane, (to, place) in zip(mine, free.tolist(), strict=False):
                self._carry(int(at), int(lane), to, place)

    def _carry(self, at: int, lane: int, to: int, place: int) -> None:
        """Move a launch to a free lane of another batch."""
        old, new = self.batches[at], self.batches[to]
        new.state[:, place], new.pars[:, place] = old.state[:, lane], old.pars[:, lane]
        high, low = (np.array(part) for part in new.dtime)
        high[place], low[place] = (part[lane] for part in old.dtime)
        new.set_dtime(high, low)
        if new.with_events:
            new.reset_cooldowns(place)
        self._put(to, place, int(self.lanes[at, lane]))
        self._clear(at, lane)


@lru_cache(maxsize=1)
def lanes_of_batch() -> int:
    """Number of launches that a batch moves at once."""
    return WIDTH * int(heyoka().recommended_simd_size())


@lru_cache(maxsize=1)
def _outcomes() -> dict[int, int]:
    """Standing of a lane by the library's outcome; any other is an event."""
    codes = heyoka().taylor_outcome
    return {
        int(codes.success): RUNNING,
        int(codes.step_limit): RUNNING,
        int(codes.time_limit): LASTED,
        int(codes.err_nf_state): FAILED,
        int(codes.cb_stop): FAILED,
    }


@contextmanager
def _lent(compiled: Compiled, count: int) -> Iterator[list[Any]]:
    """Batches that no other thread uses."""
    with ASKING:  # one thread compiles, and CasADi's graph is read
        taken = [compiled.take() for _ in range(count)]
    yield taken
    for batch in taken:
        compiled.give(batch)


@lru_cache(maxsize=64)
def _batch(flow: Flow, tolerance: float, effort: int) -> Compiled:
    def build() -> Any:
        hy = heyoka()
        symbols, rates, guards = expressions(flow)
        down = hy.event_direction.negative
        return hy.taylor_adaptive_batch(
            list(zip(symbols, rates, strict=True)),
            np.zeros((len(symbols), lanes_of_batch())),
            tol=tolerance,
            t_events=[hy.t_event_batch(g, direction=down) for g in guards],
            fast_math=True,
            compact_mode=compact(flow),
            opt_level=effort,
        )

    return Compiled(build, TURNS)


@dataclass(frozen=True, eq=False)
class Lean:
    """A flow for lanes, and the states of the flow that it takes the place of."""

    whole_flow: Flow
    """The flow of the model."""
    flow: Flow
    """The flow to integrate."""

    @property
    def short(self) -> bool:
        """Whether the states are others, those of `Model.short`."""
        return self.flow.model.chart is not self.whole_flow.model.chart

    def pack(self, y: Floats) -> Floats:
        """States of the lean flow, shape (N, l), from those of the whole one, shape (N, n)."""
        if self.short:
            y = self.flow.pack(self.whole_flow.reported(y))
        return y[:, : len(self.flow.names)]

    def whole(self, y: Floats) -> Floats:
        """States of the whole flow from those of the lean one; work is 0 where it is left out."""
        count = len(self.whole_flow.system.states)
        states = np.zeros((*y.shape[:-1], len(self.whole_flow.names)))
        states[..., : y.shape[-1]] = y
        if self.short:
            states[..., :count] = self.flow.reported(y)[..., :count]
        return states

    def report(self, y: Floats) -> Floats:
        """States that a motion reports, shape (N, s), from those of the lean flow."""
        return self.flow.reported(y) if self.short else self.whole_flow.reported(self.whole(y))


@lru_cache(maxsize=64)
def lean_of(flow: Flow, *, account: bool = False) -> Lean:
    """The lean flow of a model; built once for each.

    Parameters
    ----------
    flow
        Flow of a body or of a user's system.
    account
        Whether to count the energy lost.
    """
    model = flow.model
    lean = flow if model.short is None else flow_of(model.short(model))
    if account or lean.names[-1] != WORK:
        return Lean(flow, lean)
    n = len(lean.names) - 1
    return Lean(flow, lean.having(x=lean.x[:n], rhs=lean.rhs[:n], names=lean.names[:n]))


def integrate_many(
    legs: Sequence[Leg],
    workers: int | None = None,
    progress: Counted | None = None,
    executor: Executor | None = None,
) -> list[Path]:
    """Run many legs of one flow, tolerance and number of times.

    Parameters
    ----------
    legs
        Legs that share flow, tolerance and number of times.
    workers
        Number of threads; by default that of the cores.
    progress
        Counts the legs of each piece of work when it is finished.
    executor
        Executor in place of the threads, or None.

    Returns
    -------
    list of Path
        In the order of the legs; a path does not depend on the number of workers.
    """
    groups = [range(i, min(i + TOGETHER, len(legs))) for i in range(0, len(legs), TOGETHER)]
    flow, count = shared(legs[0].flow, executor), min(workers or CORES, len(groups))
    effort = QUICK if len(legs) <= FEW else OPTIMISED

    def task(group: range) -> Callable[[], list[Path]]:
        return partial(_together, flow, effort, [legs[i].numbers for i in group])

    with closing(
        ordered(
            groups,
            task,
            executor=executor,
            workers=count,
            start_pool=threads if count > 1 else here,
            progress=progress,
            size=len,
        )
    ) as results:
        return [path for _, paths in results for path in paths]


def _together(
    flow: Callable[[], Flow], effort: int, numbers: Sequence[tuple[Any, ...]]
) -> list[Path]:
    """One piece of work, in a worker."""
    legs = [Leg(flow(), *some) for some in numbers]
    starts, p = np.array([leg.start for leg in legs]), np.array([leg.p for leg in legs])
    times = np.array([leg.times for leg in legs])
    most = np.array([leg.max_steps for leg in legs])
    after = times - times[:, :1]
    with ASKING:
        lean = lean_of(legs[0].flow, account=True)
    done = ends(
        lean.flow,
        lean.pack(starts),
        p,
        after[:, -1],
        legs[0].tolerance,
        most if effort == OPTIMISED else np.minimum(most, QUIET),
        times=after,
        seconds=np.array([leg.seconds for leg in legs]),
        effort=effort,
    )
    assert done.samples is not None
    states = lean.whole(done.samples)
    states[:, 0] = starts
    long = (done.kind == FAILED) & (done.steps >= QUIET) & (most > QUIET) & (effort != OPTIMISED)
    left = np.flatnonzero(long).tolist()
    longer = _together(flow, OPTIMISED, [numbers[i] for i in left]) if left else []
    paths = dict(zip(left, longer, strict=True))
    with ASKING:
        rows = np.flatnonzero(done.kind == EVENT)
        last = lean.whole(done.state[rows])
        events = on_guards([legs[i] for i in rows], times[rows, 0] + done.time[rows], last)
        ended = dict(zip(rows.tolist(), events, strict=True))
        for i, leg in enumerate(legs):
            if i not in paths:
                path = Path(states[i], ended.get(i), int(done.steps[i]))
                paths[i] = _path(leg, path, failed=done.kind[i] == FAILED)
    return [paths[i] for i in range(len(legs))]


def _path(leg: Leg, path: Path, *, failed: bool) -> Path:
    """A path up to its end; a launch that failed runs alone."""
    if path.end is not None:
        path = replace(path, states=path.states[: np.searchsorted(leg.times, path.end.time)])
    if failed or not np.isfinite(path.states).all():
        return integrate(leg)
    return sound(leg, path)
