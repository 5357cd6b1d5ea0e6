"""How motions are run: the keywords of `simulate`, checked."""

from __future__ import annotations

from dataclasses import dataclass

from .checks import MOST_WORKERS, flag, one_number, whole_number
from .errors import ParameterError

LOOSEST, TIGHTEST = 1e-2, 1e-16
"""Range of `tolerance`."""
PATIENT = 1e7
"""Largest `max_seconds`."""


@dataclass(frozen=True)
class Settings:
    """How a run is made; fields as the keywords of `simulate`."""

    method: str
    """Integrator."""
    tolerance: float
    """Error allowed in a step."""
    pose: bool
    """Whether the pose is carried along."""
    flat: float
    """Angle that counts as flat [rad]."""
    settle: float
    """Largest distance that can count as settled."""
    max_steps: int
    """Steps after which a run gives up."""
    workers: int | None
    """Threads."""
    check: bool = True
    """Whether each launch has a shadow."""
    max_seconds: float = 10.0
    """Computing time after which a run gives up [s]."""

    def refuse(self) -> None:
        """Refuse what is out of range, in one sentence."""
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
