"""A problem without units, and the track of a model through it: samples with errors."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from ...base.quantities import Kind
from ...base.types import Floats
from ...bodies.model import LIFT_OFF
from ...integrators.flow import Flow, flow_of
from ...motion.result import Settings
from ...motion.starts import Starts
from ...settling.settling import SETTLE, Nearest

SPACING = 0.25
"""Distance of the samples of a whole path, in units of the motion's own time."""
MOST_SAMPLES = 200_000
"""Most samples of a path."""


@dataclass(frozen=True, eq=False)
class LaunchProblem:
    """One launch of one law or system, dimensionless, with the error that is allowed."""

    launches: Starts
    """The launch, with the user's units."""
    tolerance: float
    """Error allowed in each state, over 1 or its own size."""
    times: Floats
    """Rising dimensionless times at which the motion is asked for, shape (m,); the last counts."""
    settle: float = SETTLE
    """Largest distance from a steady motion at which the motion can count as settled."""
    flat: float = Settings.flat
    """Angle from 0 or π that counts as flat."""
    max_seconds: float = Settings.max_seconds
    """Computing time of one run [s]."""

    @cached_property
    def flow(self) -> Flow:
        """The full model as a flow."""
        return flow_of(self.launches.model)

    @cached_property
    def p(self) -> Floats:
        """Parameters of the system, shape (m,)."""
        numbers: Floats = self.launches.p[0]
        return numbers

    @cached_property
    def flow_p(self) -> Floats:
        """Parameters of the flow: those of the system, then those of the guards."""
        more = self.flow.p.numel() - len(self.p)
        return np.append(self.p, [np.sin(self.flat)] * more)

    @cached_property
    def start(self) -> Floats:
        """The states at time 0, shape (s,)."""
        states: Floats = self.launches.starts[0]
        return states

    @cached_property
    def own(self) -> int:
        """Number of states of the full model's equations."""
        return len(self.flow.system.states)

    @cached_property
    def friction(self) -> float:
        """The parameter that the decay rate of slip is proportional to; 0 for none."""
        name = self.launches.model.friction
        names = self.flow.system.parameters
        return float(self.p[names.index(name)]) if name else 0.0

    @cached_property
    def touches(self) -> bool:
        """Whether the model has a contact that may lift off."""
        return LIFT_OFF in self.flow.guards

    @cached_property
    def near(self) -> Nearest:
        """The steady motion nearest to the start."""
        return self.launches.settling.closest(self.start, self.p)

    def when(self, time: float) -> str:
        """A time in words, in the user's unit."""
        unit = "" if self.launches.unit("time") == "1" else f" {self.launches.unit('time')}"
        return f"{float(time) * float(self.launches.size(Kind.TIME)):.4g}{unit}"

    def stands(self, states: Floats) -> bool:
        """Whether all guards of the full model are positive at states, shape (…, s)."""
        values, _ = self.flow.margins(self.flow.pack(states), self.flow_p)
        return bool((values > 0).all())

    @property
    def last(self) -> float:
        """The horizon."""
        return float(self.times[-1])

    @cached_property
    def pace(self) -> float:
        """Rate at which the motion changes at the start."""
        y = self.flow.pack(self.start)[None]
        return float(self.flow.paces(y, self.flow_p[None], np.array([self.last]))[0])


@dataclass(frozen=True, eq=False)
class Finish:
    """The end of a track before the horizon."""

    kind: str
    """The outcome as a word."""
    time: float
    """Its time."""
    error: float
    """Estimated error of the time."""
    evidence: str
    """Why it ended, in words."""


@dataclass(frozen=True, eq=False)
class Track:
    """The motion of one model through a problem, with an estimate of its error at each sample."""

    times: Floats
    """Times of the samples, shape (m,)."""
    states: Floats
    """States of the full model at these times, shape (m, s)."""
    errors: Floats
    """Estimated errors, the largest over the states, each over 1 or its own size, shape (m,)."""
    at: Callable[[Floats], Floats]
    """The states at any times of the track, shape (t,) to (t, s)."""
    finish: Finish | None = None
    """The end before the horizon, or None."""
    steps: int = 0
    """Steps of integrators."""
    notes: tuple[str, ...] = ()
    """What happened on the way, in sentences."""
    indicators: dict[str, float] = field(default_factory=dict)
    """Numbers that say how valid the model is on the way, by name."""
    methods: tuple[str, ...] = ()
    """Names of the integrators of the full model."""

    @property
    def error(self) -> float:
        """The largest error of the samples."""
        return float(self.errors.max(initial=0.0))


@dataclass(frozen=True)
class Refused:
    """A model that does not apply to a problem."""

    why: str
    """The reason, in a sentence without its full stop."""
    indicators: dict[str, float] = field(default_factory=dict)
    """The numbers that say so."""


def decade(tolerance: float, least: float = 1e-15, most: float = 1e-7) -> float:
    """A power of ten not above a tolerance: an integrator is compiled once for each tolerance.

    Parameters
    ----------
    tolerance
        The tolerance.
    least, most
        Range of the result.

    Examples
    --------
    >>> decade(3e-9), decade(1e-30)
    (1e-09, 1e-15)
    """
    power = math.floor(math.log10(min(most, max(least, tolerance))) + 1e-9)
    return float(10.0**power)


def relative(errors: Floats, states: Floats) -> Floats:
    """Errors over 1 or the state's own size, the largest over the states.

    Parameters
    ----------
    errors, states
        Shape (…, s).

    Returns
    -------
    ndarray
        Shape (…).

    Examples
    --------
    >>> float(relative(np.array([0.1, 2.0]), np.array([0.0, 40.0])))
    0.1
    """
    share: Floats = (np.abs(errors) / np.maximum(1.0, np.abs(states))).max(axis=-1)
    return share
