"""A launch of a body that is smooth at a pole, told by its states along fixed axes.

The angles of such a body have no meaning where its axis is vertical.  Its axis, angular velocity
and slip along fixed axes have one everywhere, so that an error can be stated in each of them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from ...base.types import Floats
from ...bodies.contact_laws import Smooth
from ...bodies.model import Chart, Model
from ...bodies.round_body.pole_equations import AXIS, SLIP, TURN
from ...bodies.round_quantities import round_quantities
from ..body_lines import Vertical
from ..body_settling import BodySettling
from ..nearest import Nearest
from ..together.many import NearestMany

STATES = (*AXIS, *TURN, *SLIP)
"""States of a launch along fixed axes; the slip is 0 where the law allows none."""


@lru_cache(maxsize=32)
def fixed_model(model: Model) -> Model:
    """The model of the same motion that reports states along fixed axes.

    Parameters
    ----------
    model
        Model with a chart, of `stability.bodies.round_body.models.pole_model`.
    """
    known = dict(model.quantities) | dict(round_quantities("", Smooth, (), STATES))
    return replace(model, states=STATES, quantities=known, chart=None)


def fixed_states(chart: Chart, own: int, states: Floats) -> Floats:
    """States along fixed axes, with X along the direction x̂ of the given ones.

    Parameters
    ----------
    chart
        Chart of the model.
    own
        Number of states of its equations.
    states
        The six states of the angles, shape (…, 6).

    Returns
    -------
    ndarray
        Shape (…, 8).
    """
    found = np.zeros((*states.shape[:-1], len(STATES)))
    found[..., :own] = chart.pack(states)[..., :own]
    return found


@dataclass(frozen=True, eq=False)
class FixedSettling:
    """Settling of a body of revolution, for states along fixed axes."""

    inner: BodySettling
    """Its settling for the states of the angles."""
    chart: Chart
    """From states along fixed axes to those of the angles."""

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the families."""
        return self.inner.names

    def many(self, states: Floats, p: Floats, within: float | Floats) -> NearestMany:
        """The nearest families of many states, and which of them have settled."""
        return self.inner.many(self.chart.report(states), p, within)

    def nearest(self, state: Floats, p: Floats, within: float) -> Nearest:
        """The steady motion nearest to a state, and whether the state has settled on it."""
        return self.inner.nearest(self.chart.report(state), p, within)

    def closest(self, state: Floats, p: Floats) -> Nearest:
        """The nearest steady motion; with its states where these rest along fixed axes."""
        near = self.inner.closest(self.chart.report(state), p)
        line = next((one for one in self.inner.lines if one.name == near.family), None)
        if not isinstance(line, Vertical):
            return replace(near, member=None)
        member = np.zeros(len(STATES))
        member[2], member[5] = math.copysign(1.0, line.pole), near.at
        return replace(near, member=member)

    def distances(self, states: Floats, p: Floats, near: Nearest) -> Floats:
        """Distances of states, shape (t, 8), from the family of a nearest member, shape (t,)."""
        return self.inner.distances(self.chart.report(states), p, near)
