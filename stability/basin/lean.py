"""The flow that many launches follow: in the fewest operations, without the account of energy."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from ..base.types import Floats
from ..bodies.model import WORK
from ..integrators.flow import Flow, flow_of


@dataclass(frozen=True, eq=False)
class Lean:
    """A flow for lanes, and the states of the flow that it takes the place of."""

    whole_flow: Flow
    """The flow of the model."""
    flow: Flow
    """The flow to integrate."""

    @property
    def short(self) -> bool:
        """Whether the states are others, those of `Model.short`."""
        return self.flow.model.chart is not self.whole_flow.model.chart

    def pack(self, y: Floats) -> Floats:
        """States of the lean flow, shape (N, l), from those of the whole one, shape (N, n)."""
        if self.short:
            return self.flow.pack(self.whole_flow.reported(y))
        return y[:, : len(self.flow.names)]

    def whole(self, y: Floats) -> Floats:
        """States of the whole flow from those of the lean one; no work is done."""
        if self.short:
            return self.whole_flow.pack(self.flow.reported(y))
        found = np.zeros((len(y), len(self.whole_flow.names)))
        found[:, : y.shape[1]] = y
        return found

    def report(self, y: Floats) -> Floats:
        """States that a motion reports, shape (N, s), from those of the lean flow."""
        if self.short:
            return self.flow.reported(y)
        return self.whole_flow.reported(self.whole(y))


@lru_cache(maxsize=64)
def lean_of(flow: Flow) -> Lean:
    """The lean flow of a model; built once for each.

    Parameters
    ----------
    flow
        Flow of a body or of a user's system.
    """
    model = flow.model
    if model.short is not None:
        return Lean(flow, flow_of(model.short(model)))
    if flow.names[-1] != WORK:
        return Lean(flow, flow)
    n = len(flow.names) - 1
    return Lean(flow, flow.having(x=flow.x[:n], rhs=flow.rhs[:n], names=flow.names[:n]))
