"""The full nonlinear equations by CVODES, for tests of what linear analysis leaves open."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import casadi as ca
import numpy as np

import stability as st


def simulate(
    k: float, mu: float, start: Sequence[float], times: Any, tolerance: float = 1e-11
) -> np.ndarray[Any, Any]:
    """States of the viscous disk at given times, shape (times, 6); dimensionless."""
    system = st.disk_system("viscous")
    options = {"reltol": tolerance, "abstol": tolerance * 1e-3, "max_num_steps": 10**9}
    flow = ca.integrator(
        "flow",
        "cvodes",
        {"x": system.x, "p": system.p, "ode": system.rhs},
        0.0,
        list(np.asarray(times, dtype=float)),
        options,
    )
    found = flow(x0=list(start), p=[k, mu])["xf"]
    return np.array(found).T


def crossing(times: np.ndarray[Any, Any], values: np.ndarray[Any, Any], level: float) -> float:
    """First time at which a slowly falling quantity passes a level, by a local cubic."""
    first = int(np.argmax(values < level))
    assert first > 2
    window = slice(max(first - 3, 0), first + 3)
    cubic = np.polyfit(values[window] - level, times[window] - times[first], 3)
    return float(times[first] + cubic[-1])
