"""Many launches on the lanes of heyoka's batch mode; a lane takes the next launch when one ends.

No samples are kept.  After every `STRIDE` steps of a lane its state is shown to a watcher, which
ends the launch where its outcome is proved.  Many batches move by turns, so that the watcher sees
many states at once.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..algebra.number_types import heyoka
from ..base.types import Floats
from ..bodies.model import WORK
from ..integrators.flow import ASKING, Flow, flow_of
from ..integrators.taylor import FINEST, PIECES, compact, expressions

STRIDE = 128
"""Steps of a lane between two looks of the watcher."""
WIDTH = 2
"""Lanes of a batch over those of the processor's registers: fewer calls of the library."""
TURNS = 256
"""Most batches of one thread that move by turns."""
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


def ends(
    flow: Flow,
    starts: Floats,
    p: Floats,
    horizon: Floats,
    tolerance: float,
    most: int,
    watch: Watch | None = None,
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
        Steps after which a launch fails.
    watch
        Watcher, or None.

    Returns
    -------
    Ends
        A launch's end does not depend on the other launches.

    Source: tests/basin/test_lanes.py.
    """
    count = len(starts)
    found = Ends(
        np.zeros(count, dtype=np.int8),
        np.zeros(count),
        np.array(starts, dtype=float),
        np.zeros(count, dtype=np.int64),
    )
    if not count:
        return found
    with _lent(flow, max(tolerance, FINEST), count) as batches:
        _Run(flow, batches, p, horizon, tolerance, most, watch, found).to_the_end()
    return found


class _Run:
    """Lanes in use: which launch each carries, and the launches that wait."""

    def __init__(
        self,
        flow: Flow,
        batches: list[Any],
        p: Floats,
        horizon: Floats,
        tolerance: float,
        most: int,
        watch: Watch | None,
        found: Ends,
    ) -> None:
        self.batches, self.p, self.horizon, self.most = batches, p, horizon, most
        self.watch, self.found, self.next = watch, found, 0
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
        batch.state[:, lane] = self.found.state[0]
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
            batch.state[:, lane] = self.found.state[mine]
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
        batch.propagate_until(last, max_steps=steps, **more)
        found: list[Any] = batch.propagate_res
        return found

    def _move(self, at: int) -> NDArray[np.int8]:
        """Move one batch by a stride; how its lanes stand.

        A launch that ends stops the whole batch.  The others then finish their stride, so that each
        is seen at the same steps and not where a neighbour ended.
        """
        results, carried = self._propagate(at, self.last[at], STRIDE), self.lanes[at]
        stand, batch = np.zeros(self.width, dtype=np.int8), self.batches[at]
        # the library says of all lanes at once that they have reached their limit of steps
        if results[0][0] == self.full and (batch.time < self.last[at]).all():
            self.found.steps[carried] += STRIDE
            return stand
        left, going = STRIDE, carried >= 0
        while True:
            made = 0
            for lane, (outcome, _, _, steps) in enumerate(results):
                if going[lane]:
                    made = max(made, steps)
                    self.found.steps[carried[lane]] += steps
                    stand[lane] = self.codes.get(int(outcome), EVENT)
            # of lanes that another one has stopped the library says that they have lasted
            stand[stand == LASTED] = RUNNING
            now = np.asarray(batch.time)
            stand[going & (stand == RUNNING) & (now >= self.last[at])] = LASTED
            wild = going & ~(np.isfinite(batch.state).all(axis=0) & np.isfinite(now))
            if wild.any():
                stand[wild] = FAILED
                batch.state[:, wild] = self.found.state[:1].T
                high, low = (np.where(wild, 0.0, part) for part in batch.dtime)
                batch.set_dtime(high, low)
            going = going & (stand == RUNNING)
            left -= made or left
            if left <= 0 or not going.any():
                return stand
            results = self._propagate(at, np.where(going, self.last[at], batch.time), left)

    def _look(self, used: NDArray[np.intp], stand: NDArray[np.int8]) -> None:
        """Show the states to the watcher, write what has ended, and refill the lanes."""
        states = np.stack([self.states[at] for at in used.tolist()])  # (batches, n, lanes)
        times, carried = np.stack([self.batches[at].time for at in used]), self.lanes[used]
        going = (carried >= 0) & (stand == RUNNING)
        spent = going & (self.found.steps[carried] >= self.most)
        stand[spent] = FAILED
        if self.watch is not None:
            shown = (carried >= 0) & ((stand == RUNNING) | (stand == LASTED))
            if shown.any():
                where = np.nonzero(shown)
                proved = self.watch(carried[where], states[where[0], :, where[1]], times[where])
                stand[where[0][proved], where[1][proved]] = PROVED
        ended = np.nonzero((carried >= 0) & (stand != RUNNING))
        mine = carried[ended]
        self.found.kind[mine] = stand[ended]
        self.found.time[mine] = times[ended]
        self.found.state[mine] = states[ended[0], :, ended[1]]
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
    known = heyoka().taylor_outcome
    return {
        int(known.success): RUNNING,
        int(known.step_limit): RUNNING,
        int(known.time_limit): LASTED,
        int(known.err_nf_state): FAILED,
        int(known.cb_stop): FAILED,
    }


@contextmanager
def _lent(flow: Flow, tolerance: float, launches: int) -> Iterator[list[Any]]:
    """Compiled batches that no other thread uses."""
    with ASKING:  # one thread compiles, and CasADi's graph is read
        first, spare = _compiled(flow, tolerance)
        count = min(TURNS, -(-launches // first.batch_size))
        taken = [spare.pop() for _ in range(min(count, len(spare)))]
    taken += [copy.deepcopy(first) for _ in range(count - len(taken))]
    yield taken
    spare += taken


@lru_cache(maxsize=32)
def _compiled(flow: Flow, tolerance: float) -> tuple[Any, list[Any]]:
    """A batch integrator, and the copies of it that are not in use."""
    hy = heyoka()
    symbols, rates, guards = expressions(flow)
    width = lanes_of_batch()
    down = hy.event_direction.negative
    batch = hy.taylor_adaptive_batch(
        list(zip(symbols, rates, strict=True)),
        np.zeros((len(symbols), width)),
        tol=tolerance,
        t_events=[hy.t_event_batch(g, direction=down) for g in guards],
        fast_math=True,
        compact_mode=compact(flow),
    )
    return batch, []


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
            return self.flow.pack(self.whole_flow.reported(y))
        return y[:, : len(self.flow.names)]

    def whole(self, y: Floats) -> Floats:
        """States of the whole flow from those of the lean one; no work is done."""
        if self.short:
            return self.whole_flow.pack(self.flow.reported(y))
        found = np.zeros((len(y), len(self.whole_flow.names)))
        found[:, : y.shape[1]] = y
        return found

    def report(self, y: Floats) -> Floats:
        """States that a motion reports, shape (N, s), from those of the lean flow."""
        if self.short:
            return self.flow.reported(y)
        return self.whole_flow.reported(self.whole(y))


@lru_cache(maxsize=64)
def lean_of(flow: Flow) -> Lean:
    """The lean flow of a model; built once for each.

    Parameters
    ----------
    flow
        Flow of a body or of a user's system.
    """
    model = flow.model
    if model.short is not None:
        return Lean(flow, flow_of(model.short(model)))
    if flow.names[-1] != WORK:
        return Lean(flow, flow)
    n = len(flow.names) - 1
    return Lean(flow, flow.having(x=flow.x[:n], rhs=flow.rhs[:n], names=flow.names[:n]))
