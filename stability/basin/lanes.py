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
from ..integrators.flow import ASKING, Flow
from ..integrators.taylor import FINEST, PIECES, expressions

STRIDE = 64
"""Steps of a lane between two looks of the watcher."""
TURNS = 64
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
    flow: Flow, starts: Floats, p: Floats, horizon: Floats, tolerance: float, most: int,
    watch: Watch | None = None,
) -> Ends:  # fmt: skip
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
    found = Ends(np.zeros(count, dtype=np.int8), np.zeros(count), np.array(starts, dtype=float),
                 np.zeros(count, dtype=np.int64))  # fmt: skip
    if not count:
        return found
    with _lent(flow, max(tolerance, FINEST), count) as batches:
        _Run(flow, batches, p, horizon, tolerance, most, watch, found).to_the_end()
    return found


class _Run:
    """Lanes in use: which launch each carries, and the launches that wait."""

    def __init__(
        self, flow: Flow, batches: list[Any], p: Floats, horizon: Floats, tolerance: float,
        most: int, watch: Watch | None, found: Ends,
    ) -> None:  # fmt: skip
        self.batches, self.p, self.horizon, self.most = batches, p, horizon, most
        self.watch, self.found, self.next = watch, found, 0
        self.width = batches[0].batch_size
        self.lanes = np.full((len(batches), self.width), -1, dtype=np.intp)
        pieces = math.inf if flow.model.turning else PIECES + 7 * abs(math.log10(tolerance))
        self.longest = horizon / pieces if math.isfinite(pieces) else np.full(len(p), np.inf)
        self.codes = _outcomes()

    def to_the_end(self) -> None:
        """Move all lanes until no launch is left."""
        for at, batch in enumerate(self.batches):
            # a lane without a launch stands still at a state where the equations have a value
            batch.state[:] = self.found.state[:1].T
            batch.pars[:] = self.p[0, : len(batch.pars), None]
            batch.set_time(0.0)
            self._refill(at, range(self.width))
        while (used := np.flatnonzero((self.lanes >= 0).any(axis=1))).size:
            self._look(used, np.stack([self._move(at) for at in used.tolist()]))

    def _refill(self, at: int, free: Any) -> None:
        batch = self.batches[at]
        # both parts of each time: rounding would change the launches on the other lanes
        high, low = (np.array(part) for part in batch.dtime)
        for lane in free:
            mine = self.next
            if mine >= len(self.p):
                self.lanes[at, lane] = -1
                batch.state[:, lane] = self.found.state[0]
                batch.pars[:, lane] = self.p[0, : len(batch.pars)]
                continue
            self.next += 1
            self.lanes[at, lane] = mine
            batch.state[:, lane] = self.found.state[mine]
            batch.pars[:, lane] = self.p[mine, : len(batch.pars)]
            high[lane] = low[lane] = 0.0
            if batch.with_events:
                batch.reset_cooldowns(lane)
        batch.set_dtime(high, low)

    def _move(self, at: int) -> NDArray[np.int8]:
        """Move one batch by a stride; how its lanes stand.

        A launch that ends stops the whole batch.  The others then finish their stride, so that each
        is seen at the same steps and not where a neighbour ended.
        """
        carried, batch, left = self.lanes[at], self.batches[at], STRIDE
        going = carried >= 0
        stand = np.full(self.width, RUNNING, dtype=np.int8)
        longest = np.where(going, self.longest[carried], np.inf)
        while left > 0 and going.any():
            last = np.where(going, self.horizon[carried], batch.time)
            batch.propagate_until(last, max_steps=left, max_delta_t=longest)
            made = 0
            for lane, (outcome, _, _, steps) in enumerate(batch.propagate_res):
                if going[lane]:
                    made = max(made, steps)
                    self.found.steps[carried[lane]] += steps
                    stand[lane] = self.codes.get(int(outcome), EVENT)
            # of lanes that another one has stopped the library says that they have lasted
            stand[stand == LASTED] = RUNNING
            stand[going & (stand == RUNNING) & (np.asarray(batch.time) >= last)] = LASTED
            wild = going & ~(np.isfinite(batch.state).all(axis=0) & np.isfinite(batch.time))
            if wild.any():
                stand[wild] = FAILED
                batch.state[:, wild] = self.found.state[:1].T
                high, low = (np.where(wild, 0.0, part) for part in batch.dtime)
                batch.set_dtime(high, low)
            going &= stand == RUNNING
            left -= made or left
        return stand

    def _look(self, used: NDArray[np.intp], stand: NDArray[np.int8]) -> None:
        """Show the states to the watcher, write what has ended, and refill the lanes."""
        states = np.stack([self.batches[at].state for at in used])  # (batches, n, lanes)
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
        self.lanes[to, place], self.lanes[at, lane] = self.lanes[at, lane], -1


@lru_cache(maxsize=1)
def _outcomes() -> dict[int, int]:
    """Standing of a lane by the library's outcome; any other is an event."""
    known = heyoka().taylor_outcome
    return {
        int(known.success): RUNNING, int(known.step_limit): RUNNING,
        int(known.time_limit): LASTED, int(known.err_nf_state): FAILED,
        int(known.cb_stop): FAILED,
    }  # fmt: skip


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
    width = hy.recommended_simd_size()
    down = hy.event_direction.negative
    batch = hy.taylor_adaptive_batch(
        list(zip(symbols, rates, strict=True)), np.zeros((len(symbols), width)), tol=tolerance,
        t_events=[hy.t_event_batch(g, direction=down) for g in guards],
    )  # fmt: skip
    return batch, []
