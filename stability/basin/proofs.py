"""Proofs that launches have settled, for the lanes of many launches at once."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from ..base.types import Floats
from ..settling.settling import NONE, Settling


class Watcher:
    """Tries proofs of settling where a launch has come nearer since the last try.

    Parameters
    ----------
    settling
        Steady motions that the launches may settle on.
    report
        Function from the states that are shown to those that a motion reports.
    parameters
        Names of the system's parameters.
    p
        Their values, then others, shape (N, m).
    horizon
        Last time of each launch, at which it is tried in any case, shape (N,).
    within
        Largest distance at which a proof is tried.
    """

    def __init__(
        self,
        settling: Settling,
        report: Callable[[Floats], Floats],
        parameters: Sequence[str],
        p: Floats,
        horizon: Floats,
        within: float,
    ) -> None:
        self.settling, self.report, self.horizon, self.within = settling, report, horizon, within
        self.p = p[:, : len(parameters)]
        count = len(p)
        self.limit = np.full(count, within)
        self.family = np.full(count, NONE, dtype=np.int8)
        self.member, self.error = np.full(count, np.nan), np.full(count, np.nan)

    def __call__(self, rows: NDArray[np.intp], states: Floats, times: Floats) -> NDArray[np.bool_]:
        """Whether the outcome of each launch is proved."""
        limit = np.where(times < self.horizon[rows], self.limit[rows], self.within)
        found = self.settling.many(self.report(states), self.p[rows], limit)
        proved = found.settled.proved
        tried = found.distance <= limit
        self.limit[rows[tried]] = (found.settled.nearer * found.distance)[tried]
        mine = rows[proved]
        self.family[mine], self.error[mine] = found.family[proved], found.settled.error[proved]
        self.member[mine] = found.limit[proved]
        return proved
