"""One leg of a motion and its path: what every integrator is asked, and what it answers."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..base.types import Floats
from .flow import Flow

LARGE = 1e3
"""Friction from which the slip is resolved more finely."""
BRIEF = 0.01
"""Share of the computing time that a run may take, up to which the wall's clock tells it."""
RESOLVED = 0.01
"""mu times the slip that is always resolved."""
LOOSE = 1e-2
"""Tolerance at which that is so; it falls with its fourth root."""
HALVINGS = 1000
"""Iterations of a search for a guard's zero, which at a multiple one takes long."""
UNRESOLVED = "unresolved"
"""The kind of an end at which an integrator gave up."""


@dataclass(frozen=True, eq=False)
class Leg:
    """One run of one flow from one start; dimensionless."""

    flow: Flow
    """The equations and guards."""
    p: Floats
    """Parameters of the flow, shape (m,)."""
    start: Floats
    """y at times[0], shape (n,)."""
    times: Floats
    """Times at which y is asked, rising, the first that of the start, shape (t,)."""
    tolerance: float
    """Local error allowed in a step, relative and absolute."""
    max_steps: int
    """Steps after which the run gives up."""
    seconds: float = math.inf
    """Computing time of the thread after which it gives up [s]."""
    dense: bool = False
    """Whether the times are so close that guards need no look between them."""

    @property
    def numbers(self) -> tuple[Any, ...]:
        """All but the flow, of which a worker has a copy of its own."""
        return (
            self.p, self.start, self.times, self.tolerance, self.max_steps, self.seconds,
            self.dense,
        )  # fmt: skip

    @property
    def absolute(self) -> float:
        """The absolute tolerance: finer where friction is large and the slip small."""
        mu = 0.0
        if self.flow.friction:
            mu = float(self.p[self.flow.system.parameters.index(self.flow.friction)])
        # where D vanishes mu times the slip is of order one: an error that large is no motion
        share = math.sqrt(
            math.sqrt(min(1.0, self.tolerance / LOOSE))
        )  # a finer neighbour has a finer one too
        bound = RESOLVED * share / max(mu, 1.0)
        return min(self.tolerance * min(1.0, LARGE / max(mu, LARGE)), bound)


@dataclass(frozen=True, eq=False)
class End:
    """Where a leg ended before its last time."""

    kind: str
    """Name of the guard that reached zero, or `unresolved`."""
    time: float
    """When."""
    state: Floats
    """y there, shape (n,); for `unresolved` the last state that passed its error test."""
    message: str = ""
    """The integrator's own words, for `unresolved`."""
    lags: Floats | None = None
    """Most by which a change of each entry of the state moves the guard's zero in time."""
    early: float = 0.0
    """How long before the guard's zero the run was stopped, where that is singular."""
    short: float = 0.0
    """How far the state may be from that at the zero, over 1 or its own size."""


@dataclass(frozen=True, eq=False)
class Path:
    """The answer: y at the asked times as far as the run went."""

    states: Floats
    """y at `times[:len(states)]`, shape (≤ t, n)."""
    end: End | None
    """Where it ended early, or None."""
    steps: int
    """Steps taken, or evaluations where the library counts no steps."""
    seconds: float = 0.0
    """Computing time of the thread that it took [s]; 0 where it was run among others."""


_READ = threading.local()
"""Wall's and thread's clock when a thread last read its own."""


class Budget:
    """The computing time that a run has left, counted for the thread that made the budget.

    Other work on the machine takes nothing from it.  The thread's own clock may take a millisecond
    to read: a reading serves for as long as `BRIEF` of the time, to which the budget is exact.  As
    a callback it is asked at every step, and is false once the time is spent.

    Parameters
    ----------
    seconds
        What the run may take [s].

    Examples
    --------
    >>> Budget(60.0).spent, Budget(0.0).spent
    (False, True)
    """

    def __init__(self, seconds: float) -> None:
        self.seconds, self._began = seconds, time.perf_counter()
        wall, used = getattr(_READ, "clocks", (-math.inf, 0.0))
        if not self._began - wall < BRIEF * seconds:
            wall, used = _READ.clocks = self._began, time.thread_time()
        self._start = used + (self._began - wall)  # the thread has computed no more than that

    @property
    def used(self) -> float:
        """Seconds since it was made; by the wall's clock, which is never behind, while few."""
        now = time.perf_counter()
        if now - self._began < BRIEF * self.seconds:
            return now - self._began
        used = time.thread_time()
        _READ.clocks = now, used
        return max(0.0, used - self._start)

    @property
    def left(self) -> float:
        """Seconds that are left."""
        return self.seconds - self.used

    @property
    def spent(self) -> bool:
        """Whether nothing is left."""
        return self.left <= 0

    @property
    def message(self) -> str:
        """What ended the run."""
        if self.seconds <= 0:
            return "no computing time is left of max_seconds"
        return f"more than {self.seconds:.3g} s of computing"

    def __call__(self, _integrator: object) -> bool:
        """Whether to go on."""
        return not self.spent


Integrate = Callable[[Leg], Path]
"""An integrator: a leg in, a path out."""


def guard_at(flow: Flow, p: Floats, state: Floats) -> str:
    """The guard that is zero at an event: the one nearest to it.

    Parameters
    ----------
    flow
        The flow.
    p
        Its parameters.
    state
        y at the event.

    Returns
    -------
    str
    """
    values, _ = flow.margins(state, p)
    return list(flow.guards)[int(np.argmin(np.abs(values)))]
