"""One leg of a motion and its path: the input and the output of every integrator."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from ..base.types import Floats
from .flow import Flow

LARGE = 1e3
"""Friction from which the slip is resolved more finely."""
BRIEF = 0.01
"""Share of a run's computing time up to which the wall clock measures it."""
RESOLVED = 0.01
"""mu times the slip that is always resolved."""
LOOSE = 1e-2
"""Tolerance down to which `RESOLVED` holds; below, that slip falls like tolerance^(1/4)."""
HALVINGS = 1000
"""Most iterations of a search for a guard's zero; a multiple zero takes many."""
LOWEST = 1e-6
"""Accuracy of the place of a guard's lowest point, over the length of its interval."""
UNRESOLVED = "unresolved"
"""Kind of the end at which an integrator gave up."""
GROWN = 1e30
"""Size of a state from which a motion without a further state is said to have grown."""


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
    """Rising times at which y is reported, the first that of the start, shape (t,)."""
    tolerance: float
    """Local error allowed in a step, relative and absolute."""
    max_steps: int
    """Steps after which the run gives up."""
    seconds: float = math.inf
    """Computing time of the thread after which the run gives up [s]."""
    dense: bool = False
    """Whether the times are so close that guards need no look between them."""

    @property
    def numbers(self) -> tuple[Any, ...]:
        """All fields but the flow, of which a worker has its own copy."""
        return tuple(getattr(self, f.name) for f in fields(self) if f.name != "flow")

    @property
    def absolute(self) -> float:
        """The absolute tolerance: finer where friction is large and the slip small."""
        mu = 0.0
        if self.flow.friction:
            mu = float(self.p[self.flow.system.parameters.index(self.flow.friction)])
        # where D vanishes mu times the slip is of order one: an error must be far smaller
        share = math.sqrt(
            math.sqrt(min(1.0, self.tolerance / LOOSE))
        )  # so a finer neighbour has a finer bound too
        bound = RESOLVED * share / max(mu, 1.0)
        return min(self.tolerance * min(1.0, LARGE / max(mu, LARGE)), bound)


@dataclass(frozen=True, eq=False)
class End:
    """End of a leg before its last time."""

    kind: str
    """Name of the guard that reached zero, or `unresolved`."""
    time: float
    """Time of the end."""
    state: Floats
    """y at the end, shape (n,); for `unresolved` the last state that passed its error test."""
    message: str = ""
    """The integrator's own words, for `unresolved`."""
    lags: Floats | None = None
    """Most by which a unit change of each entry of the state moves the guard's zero in time."""
    early: float = 0.0
    """Time from the end of the run to the guard's zero, where that zero is singular."""
    short: float = 0.0
    """Distance of the state from that at the singular zero, over 1 or its own size."""


@dataclass(frozen=True, eq=False)
class Path:
    """Path of a leg: y at its times, as far as the run went."""

    states: Floats
    """y at `times[:len(states)]`, shape (≤ t, n)."""
    end: End | None
    """The early end, or None."""
    steps: int
    """Steps taken, or evaluations where the library counts no steps."""
    seconds: float = 0.0
    """Computing time of the thread [s]; 0 for a run in a batch."""


_READ = threading.local()
"""Wall clock and thread clock when a thread last read its own clock."""


class Budget:
    """The computing time that a run has left, counted for the thread that made the budget.

    Other work on the machine does not count.  A reading of the thread's clock may take a
    millisecond, so one reading serves for `BRIEF` of the time.  The budget is exact to this share.
    As a callback it is called at every step, and is false once the time is spent.

    Parameters
    ----------
    seconds
        Computing time of the run [s].

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
        """Seconds since the start; the wall clock, which is never behind, measures short times."""
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
        """Reason for the end of the run."""
        if self.seconds <= 0:
            return "no computing time is left for it and its neighbours; give a larger max_seconds"
        return f"more than {self.seconds:.3g} s of computing; give a larger max_seconds"

    def __call__(self, _integrator: object) -> bool:
        """Whether to continue."""
        return not self.spent


def too_many(steps: int) -> str:
    """Reason for the end of a run that has taken all its steps, with the remedy."""
    return f"max_steps = {steps} steps were not enough; give a larger max_steps"


def lost(method: str, state: Floats) -> str:
    """Reason for the end of a run that finds no further state, with the remedy.

    Examples
    --------
    >>> lost("heyoka", np.array([1e150, 0.0]))
    'the state has grown to 1e+150, and its numbers soon overflow; ask for an earlier last time'
    """
    size = float(np.abs(state).max())
    if size > GROWN:
        return (
            f"the state has grown to {size:.1g}, and its numbers soon overflow; ask for an "
            "earlier last time"
        )
    return (
        f"{method} finds no further state: the motion grows without bound, or its equations have "
        "no value there; ask for an earlier last time, or for another method"
    )


@dataclass(frozen=True)
class Integrator:
    """An integrator: how it runs a leg, and all that the rest of the package knows of it.

    Examples
    --------
    >>> still = Integrator("still", "stays where it is", lambda leg: Path(leg.start[None], None, 0))
    >>> still.finest, still.refuses(None)
    (1e-12, '')
    """

    name: str
    """Its name, as `method` of `simulate`."""
    about: str
    """What it is, in a few words."""
    run: Callable[[Leg], Path]
    """A leg in, a path out."""
    finest: float = 1e-12
    """Smallest tolerance that it passes to its library."""
    works: tuple[str, ...] = ()
    """Keys of the works to cite, in `base/works.json`."""
    finer: float = 1e-1
    """The finer neighbour's tolerance over that of a launch, by which its error is estimated."""
    turn: float = 0.0
    """Of an explicit method that `auto` may take: the stiffness, at a tolerance of 1e-6, above
    which it costs more than an implicit one; 0 for any other."""
    available: Callable[[], bool] = lambda: True
    """Whether its library is installed, the extra of the package that has its name."""
    refuses: Callable[[Any], str] = lambda _flow: ""
    """Function of a flow: the end of a sentence on why it cannot integrate that; empty where it
    can."""

    def __call__(self, leg: Leg) -> Path:
        """Run a leg."""
        return self.run(leg)
