"""The steady motion nearest to a state: the result of every settling."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

from ..base.types import Floats

if TYPE_CHECKING:
    from .together.many import NearestMany

SETTLE = 1e-3
"""Largest distance from a steady motion, dimensionless, at which a motion counts as settled: the
default of launches, basins and scenes.  No eye sees such a distance; its convergence is proved."""


@dataclass(frozen=True)
class Nearest:
    """The steady motion nearest to a state, and whether the state has settled on it."""

    family: str
    """Name of its family; empty where no family was given, or none has a member there."""
    at: float
    """Parameter of the disk's member: phi_dot, theta or omega3; 0 for a user's system."""
    distance: float
    """Norm of the deviation; infinite where there is no member."""
    settled: bool
    """Whether the state counts as settled."""
    reach: float
    """Size of the box across the family in which convergence is proved; 0 where it is not."""
    evidence: str
    """Evidence, in one sentence."""
    member: Floats | None = None
    """The states of the steady motion, for a user's system, and where `closest` was asked."""


class Settling(Protocol):
    """Steady motions of a body or system, as a launch needs them."""

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the families."""
        ...

    def nearest(self, state: Floats, p: Floats, within: float) -> Nearest:
        """The steady motion nearest to a state, and whether the state has settled on it."""
        ...

    def closest(self, state: Floats, p: Floats) -> Nearest:
        """The steady motion nearest to a state, with its states; settling is not tested."""
        ...

    def many(self, states: Floats, p: Floats, within: float | Floats) -> NearestMany:
        """The nearest families of many states, shape (N, s), and which of them have settled."""
        ...

    def distances(self, states: Floats, p: Floats, near: Nearest) -> Floats:
        """Distances of states, shape (t, n), from the family of a nearest member, shape (t,)."""
        ...
