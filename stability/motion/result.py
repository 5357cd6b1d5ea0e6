"""Results of launches: settings, outcomes, errors."""

from __future__ import annotations

from collections.abc import Iterable
from concurrent.futures import Executor
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..base.checks import MOST_WORKERS, flag, one_number, whole_number
from ..base.errors import ParameterError
from ..base.types import Floats, Sentences
from ..bodies.model import FLAT, LIFT_OFF, NO_CONTACT
from ..integrators.leg import UNRESOLVED, Path
from ..integrators.selection import Choice
from ..integrators.stick_slip import NON_UNIQUE, DryPath
from ..settling.settling import SETTLE, Nearest


@dataclass(frozen=True, eq=False)
class Result:
    """One launch after its run, dimensionless for a disk."""

    path: Path
    """y at the times of the leg, and the end."""
    choice: Choice
    """The integrator and the reason for it."""
    outcome: Outcome
    """Outcome of the run."""
    time: float
    """Time of the end: the last time, or that of the event."""
    final: Floats
    """y at the end."""
    near: Nearest
    """The nearest steady motion."""
    settled_at: float
    """Time from which the distance stayed within `settle`; that of the end where not settled."""
    dry: DryPath | None
    """Sliding and sticking, for dry friction."""
    evidence: str
    """Reason for the outcome."""
    tolerance: float
    """Tolerance of the integrator, not below the smallest that it accepts."""
    compared: int
    """Entries of y, from the first, in which neighbours are compared."""
    doubt: ErrorEstimate | None = None
    """Error from its neighbours; None without neighbours, or for a run without an outcome."""


class Outcome(Sentences):
    """End of a run: exactly one of these, with its time and evidence.

    Source: definitions of docs/explanation/scenes.md; tests/motion/test_motion.py.

    Examples
    --------
    >>> import stability as st
    >>> st.results.Outcome.LIFT_OFF.word
    'lift-off'
    >>> st.results.Outcome.MOVING.code
    0
    """

    MOVING = (
        "moving: the run lasted, and it is not proved that the motion settles on a steady motion "
        "of a family that is known; the evidence says what is near, and whether anything changes "
        "at the end"
    )
    SETTLED = (
        "settled: the state lies so close to an asymptotically stable steady motion that its "
        "motion is proved, in ball arithmetic, to converge to that one or to a neighbour of the "
        "same family"
    )
    FLAT = "flat: the body has fallen on its side, where its equations of motion end"
    LIFT_OFF = "lift-off: the normal force has reached zero and the body leaves the plane"
    NO_CONTACT = (
        "no-contact: no contact force continues the motion (D ≤ 0 or no admissible slip, "
        "Painlevé's paradox); take a smaller mu"
    )
    NON_UNIQUE = (
        "non-unique: dry friction allows more than one continuation from here, and none is chosen; "
        "take a smaller mu, or RegularisedCoulomb to have one picked"
    )
    UNRESOLVED = (
        "unresolved: the integrator gave up and what came after is not shown; ask for another "
        "method, a larger max_steps, max_seconds or tolerance"
    )
    UNDETERMINED = (
        "undetermined: neighbours within the tolerance end differently; ask for a finer tolerance "
        "or an earlier last time"
    )
    DOMAIN_END = (
        "domain-end: a condition of the system has reached zero, beyond which its equations have "
        "no meaning; see the evidence for its sentence"
    )

    @property
    def code(self) -> int:
        """The flag value in files."""
        return CODES[self]


CODES = {outcome: code for code, outcome in enumerate(Outcome)}
"""Flag value of each outcome, in arrays and files."""

BY_CODE = {code: outcome for outcome, code in CODES.items()}
"""Outcome of each flag value."""

OF_END = {
    LIFT_OFF: Outcome.LIFT_OFF,
    FLAT: Outcome.FLAT,
    NO_CONTACT: Outcome.NO_CONTACT,
    NON_UNIQUE: Outcome.NON_UNIQUE,
    UNRESOLVED: Outcome.UNRESOLVED,
}
"""The outcome of each kind of end."""

LOOSEST, TIGHTEST = 1e-2, 1e-16
"""Range of `tolerance`."""

PATIENT = 1e7
"""Largest `max_seconds`."""


OF_BODY = (Outcome.FLAT, Outcome.LIFT_OFF, Outcome.NO_CONTACT, Outcome.NON_UNIQUE)
"""Outcomes of a body on a plane alone."""


def outcome_flags(outcomes: Iterable[Outcome]) -> dict[str, Any]:
    """The attributes of the flags of outcomes.

    Parameters
    ----------
    outcomes
        What may become of a launch.

    Returns
    -------
    dict
        `flag_values` and `flag_meanings`.
    """
    codes, words = zip(*((o.code, o.word) for o in outcomes), strict=True)
    return {"flag_values": np.array(codes, dtype=np.int8), "flag_meanings": " ".join(words)}


@dataclass(frozen=True)
class Settings:
    """Settings of a run; fields as the keywords of `simulate`."""

    method: str = "auto"
    """Name of the integrator."""
    tolerance: float = 1e-9
    """Error allowed in a step."""
    pose: bool = False
    """Whether y holds the pose."""
    flat: float = 1e-6
    """Angle that counts as flat [rad]."""
    settle: float = SETTLE
    """Largest distance that can count as settled."""
    max_steps: int = 1_000_000
    """Steps after which a run gives up."""
    workers: int | None = None
    """Number of threads; None for that of the cores."""
    check: bool = True
    """Whether each launch has neighbours, for its error."""
    max_seconds: float = 8.0
    """Computing time after which a run gives up [s]."""
    executor: Executor | None = None
    """Executor of the launches; None for threads of this process."""

    def refuse(self) -> None:
        """Refuse values out of range, in one sentence."""
        for name in ("tolerance", "flat", "settle", "max_seconds"):
            object.__setattr__(self, name, one_number(name, getattr(self, name)))
        for name in ("pose", "check"):
            flag(name, getattr(self, name))
        if not TIGHTEST <= self.tolerance <= LOOSEST:
            raise ParameterError(
                f"tolerance is {self.tolerance:g}; give one from {TIGHTEST:g} to {LOOSEST:g}."
            )
        if not 0 < self.flat <= 0.1:
            raise ParameterError(f"flat is {self.flat:g}; give an angle above 0 up to 0.1 rad.")
        if not 0 <= self.settle <= 0.1:
            raise ParameterError(f"settle is {self.settle:g}; give a distance from 0 to 0.1.")
        if not 0 < self.max_seconds <= PATIENT:
            raise ParameterError(
                f"max_seconds is {self.max_seconds:g}; give a time above 0 up to {PATIENT:g} s."
            )
        for name in ("max_steps", "workers"):
            value = getattr(self, name)
            if name == "workers" and value is None:
                continue
            whole_number(name, value, most=MOST_WORKERS if name == "workers" else None)


@dataclass(frozen=True)
class ErrorEstimate:
    """Error of a launch, estimated from its neighbours."""

    final_error: float
    """Estimated error of the final state: the largest, each over 1 or the state's own size."""
    time_error: float
    """Estimated error of the end's time, dimensionless; 0 where the run lasted to the last time."""
    contrary: str = ""
    """End of a neighbour that ends differently, in words; the outcome is then undetermined."""
    together: float = 1.0
    """Part of the run's time up to which its neighbours stay together."""
    growth: float = 1.0
    """Growth of an error on the way, where the neighbours do not show it; otherwise 1."""
