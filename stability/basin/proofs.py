"""Proofs that launches have settled, for many states at once."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..base.types import Floats
from ..bodies.thin_disk.disk_families import FAMILIES, lines_under
from ..integrators.flow import Flow
from ..settling.disk_settling import DiskSettling, _balls, deviation, settled
from ..settling.nearest import Settling
from ..settling.system_settling import SystemSettling, _proved

AGAIN = 0.6
"""A proof that failed is tried again where the distance has fallen to this part."""


class Proofs:
    """Proofs of settling for one kind of launches.

    Parameters
    ----------
    settling
        Steady motions that the launches may settle on.
    law
        Contact law, or None.
    """

    def __init__(self, settling: Settling, law: Any) -> None:
        self.settling, self.law = settling, law
        if isinstance(settling, DiskSettling):
            none = law.conservative or law.sticks
            self.names = tuple(f.name for f in lines_under(law.name))
            self.tried = () if none else tuple(n for n in self.names if not FAMILIES[n].drifts)
        elif isinstance(settling, SystemSettling):
            self.names = tuple(f.name for f in settling.families)
            self.tried = self.names
        else:
            self.names = tuple(line.name for line in getattr(settling, "lines", ()))
            self.tried = self.names

    def watcher(self, flow: Flow, p: Floats, horizon: Floats, within: float) -> Watcher | None:
        """A watcher of launches with parameters p, or None where nothing settles."""
        return Watcher(self, flow, p, horizon, within) if self.tried else None

    def near(self, states: Floats, p: Floats) -> tuple[NDArray[np.intp], Floats]:
        """The nearest family of each state, by its number, and the distance."""
        if isinstance(self.settling, DiskSettling):
            far = np.stack([
                np.linalg.norm(deviation(states, p[:, 0], n)[1], axis=-1) for n in self.names
            ])  # fmt: skip
            which = np.argmin(far, axis=0)
            return which, far[which, np.arange(len(states))]
        found = [self.settling.closest(x, q) for x, q in zip(states, p, strict=True)]
        index = {n: i for i, n in enumerate(self.names)}
        return (np.array([index.get(n.family, -1) for n in found], dtype=np.intp),
                np.array([n.distance for n in found]))  # fmt: skip

    def of(self, y: Floats, flow: Flow, p: Floats) -> tuple[int, float, float]:
        """Family, member and error bound of a state that has settled."""
        state = flow.reported(y)
        which, _ = self.near(state[None], p[None])
        proof = self.proof(int(which[0]), state, p[: len(flow.system.parameters)])
        if proof is None:
            return int(which[0]), math.nan, math.nan
        return int(which[0]), *proof

    def proof(self, which: int, state: Floats, p: Floats) -> tuple[float, float] | None:
        """Member and error bound where convergence is proved."""
        name = self.names[which]
        if name not in self.tried:
            return None
        if isinstance(self.settling, DiskSettling):
            sign = math.copysign(1.0, state[2])
            y, e = _balls(state, float(p[0]), name, sign)
            found = settled(self.law, name, p, sign, y, e)
            return None if found is None else (found.limit[0], found.error)
        if isinstance(self.settling, SystemSettling):
            family = self.settling.families[which]
            near = self.settling.closest(state, p)
            if near.member is None or near.family != name:
                return None
            found = _proved(family, state, near.member, p)[1]
            if found is None:
                return None
            return (found.limit[0] if found.limit else math.nan), found.error
        return None


class Watcher:
    """Tries proofs where a launch has come nearer since the last try."""

    def __init__(
        self, proofs: Proofs, flow: Flow, p: Floats, horizon: Floats, within: float
    ) -> None:
        self.of, self.flow, self.horizon, self.within = proofs, flow, horizon, within
        self.p = p[:, : len(flow.system.parameters)]
        self.limit = np.full(len(p), within)
        self.found: dict[int, tuple[int, float, float]] = {}

    def __call__(self, rows: NDArray[np.intp], states: Floats, times: Floats) -> Any:
        """Whether the outcome of each launch is proved."""
        n = len(self.flow.names)
        full = np.zeros((len(states), n))
        full[:, : states.shape[1]] = states
        reported = self.flow.reported(full)
        which, far = self.of.near(reported, self.p[rows])
        proved = np.zeros(len(rows), dtype=bool)
        limit = np.where(times < self.horizon[rows], self.limit[rows], self.within)
        for i in np.flatnonzero(far < limit):
            row = int(rows[i])
            proof = self.of.proof(int(which[i]), reported[i], self.p[row])
            if proof is None:
                self.limit[row] = AGAIN * far[i]
            else:
                proved[i] = True
                self.found[row] = (int(which[i]), *proof)
        return proved

    def proofs(self, rows: NDArray[np.intp]) -> tuple[Any, Floats, Floats]:
        """Family, member and error bound of launches that are proved."""
        found = [self.found[int(r)] for r in rows]
        family, member, error = zip(*found, strict=True)
        return np.array(family), np.array(member), np.array(error)
