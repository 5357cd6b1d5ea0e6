"""A launch of a body that is smooth at a pole, by its states along fixed axes.

The angles of such a body have no meaning where its axis is vertical.  Its axis, angular velocity
and slip along fixed axes have one everywhere, so that an error can be stated in each of them.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import lru_cache

import numpy as np

from ..base.types import Floats
from ..bodies.contact_laws import Smooth
from ..bodies.model import Chart, Model
from ..bodies.quantities import round_quantities
from ..bodies.round_body.pole_equations import AXIS, SLIP, TURN
from .line import FamilyLine
from .settling import Settling

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
    quantities = dict(model.quantities) | dict(round_quantities("", Smooth, (), STATES))
    return replace(model, states=STATES, quantities=quantities, chart=None)


def fixed_states(chart: Chart, count: int, states: Floats) -> Floats:
    """States along fixed axes, with X along the direction x̂ of the given ones.

    Parameters
    ----------
    chart
        Chart of the model.
    count
        Number of states of its equations.
    states
        The six states of the angles, shape (…, 6).

    Returns
    -------
    ndarray
        Shape (…, 8).
    """
    fixed = np.zeros((*states.shape[:-1], len(STATES)))
    fixed[..., :count] = chart.pack(states)[..., :count]
    return fixed


@dataclass(frozen=True, eq=False)
class FixedSettling(Settling):
    """Settling of a body of revolution, for states along fixed axes."""

    chart: Chart = field(kw_only=True)
    """From states along fixed axes to those of the angles."""

    def read(self, states: Floats) -> Floats:
        """The states of the angles."""
        return self.chart.report(states)

    def member(self, line: FamilyLine, states: Floats) -> Floats | None:
        """The states of a member; None where these do not rest along fixed axes."""
        if line.chart is None:
            return None
        theta, _, _, turning, *_ = states
        member = np.zeros(len(STATES))
        member[2], member[5] = np.cos(theta), turning * np.cos(theta)
        return member
