"""Settling of a body of revolution: closed forms of its steady motions, and their surroundings.

The families are those of docs/explanation/bodies.md that one number names: rolling at each zero of
the height's slope, spinning where that slope vanishes upright, tumbling, vertical spin at smooth
poles. As for the disk, a state counts as settled if its distance is within the limit and
`stability.settling.attraction` proves that the motion from there on converges to one member.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from ..base.types import Floats
from ..systems.family import Family
from .body_lines import Line, Vertical
from .nearest import Nearest
from .together.many import NearestMany, nearest_many


@dataclass(frozen=True, eq=False)
class BodySettling:
    """Settling of a body of revolution under a contact law."""

    lines: tuple[Line | Vertical, ...]
    """Its families that one number names."""

    @property
    def families(self) -> tuple[Family, ...]:
        """The families, for the verdicts of their members."""
        return tuple(line.family for line in self.lines)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the families."""
        return tuple(line.name for line in self.lines)

    def closest(self, state: Floats, p: Floats) -> Nearest:
        """The steady motion nearest to a state, with its states; settling is not tested."""
        return self._closest(state, p)[0]

    def many(
        self, states: Floats, p: Floats, within: float | Floats, *, plain: bool = False
    ) -> NearestMany:
        """The nearest family of many states, and which have settled, as `nearest_many`."""
        return nearest_many(self.lines, states, p, within, plain=plain)

    def at_of(self, family: Family, state: Floats, p: Floats) -> Floats:  # noqa: ARG002
        """The number that names the nearest member of a family, shape (1,)."""
        return np.array([line.at(state) for line in self.lines if line.family is family])

    def deviation(self, family: Family, state: Floats, p: Floats) -> Floats | None:
        """Deviation from the member with the same `at`, in the states of the family's equations."""
        [line] = (one for one in self.lines if one.family is family)
        values = line.deviations(state[None], p)[0]
        if not np.isfinite(values).all():
            return None
        states = line.system.states
        names = [n for n in states if n != line.family.at[0]]
        table = dict(zip(names, values, strict=False))
        return np.array([table.get(n, 0.0) for n in family.system.states])

    def _closest(self, state: Floats, p: Floats) -> tuple[Nearest, Line | Vertical | None]:
        far = [float(np.linalg.norm(line.deviations(state[None], p))) for line in self.lines]
        if not far or not math.isfinite(min(far)):
            return Nearest("", math.nan, math.inf, False, 0.0, "no steady motion is near"), None
        line = self.lines[int(np.argmin(far))]
        at = line.at(state)
        where = f"nearest is {line.name} at {at:.6g}, {min(far):.3g} away"
        member = line.at_member(state, p)
        return Nearest(line.name, at, min(far), False, 0.0, where, member), line

    def nearest(self, state: Floats, p: Floats, within: float) -> Nearest:
        """The steady motion nearest to a state, and whether the state has settled on it."""
        near, line = self._closest(state, p)
        if line is None:
            return near
        if line.conservative:
            said = f"{near.evidence}; energy is kept, so nothing is settled on"
            return replace(near, evidence=said)
        if near.distance > within:
            return near
        found = line.settled(state, p)
        where = f"{near.distance:.3g} from {line.name} at {near.at:.6g}"
        if found is None:
            said = f"{where}; convergence to it is not proved from there"
            return replace(near, evidence=said)
        said = (
            f"{where}; proved in ball arithmetic: from there on the motion converges to "
            f"{line.name} at {found.limit[0]:.6g} within {found.error:.2g}, its deviation falling "
            f"at the rate {found.rate:.3g} at least"
        )
        said = line.system.qualified(said)
        return replace(near, settled=True, reach=found.reach, evidence=said)

    def distances(self, states: Floats, p: Floats, near: Nearest) -> Floats:
        """Distances of states, shape (t, 6), from the family of a nearest member, shape (t,)."""
        line = next(one for one in self.lines if one.name == near.family)
        found: Floats = np.linalg.norm(line.deviations(states, p), axis=-1)
        return found
