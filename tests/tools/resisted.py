"""Resistances of the package as moments of the oracle along fixed axes."""

from __future__ import annotations

from typing import Any

import numpy as np
from convex_body import Pose

import stability as st


def moments(resistance: tuple[st.Resistance, ...]) -> tuple[Any, ...]:
    """The moments of resistances along fixed axes, without and per normal force."""

    def of(one: st.Resistance) -> Any:
        def moment(pose: Pose) -> tuple[np.ndarray, np.ndarray]:
            w, none = pose.spin, 0 * pose.spin
            if isinstance(one, st.AirTorque):
                return -one.drag * w, none
            flat = isinstance(one, st.RollingResistance)
            return none, -one.value * w * ([1, 1, 0] if flat else [0, 0, 1])

        return moment

    return tuple(of(one) for one in resistance)
