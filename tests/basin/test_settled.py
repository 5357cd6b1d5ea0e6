"""One meaning of *settled* in launches, basins and scenes."""

from __future__ import annotations

import inspect
from typing import Any

import numpy as np
from kane_disk import fixed_axes
from scipy.integrate import solve_ivp

import stability as st
from stability.motion.result import Settings
from stability.scene.rungs.track import LaunchProblem
from stability.settling.settling import SETTLE

STATES = ("theta", "theta_dot", "phi_dot", "omega3", "slip_x", "slip_y")


def test_every_default_is_the_same() -> None:
    for function in (st.simulate, st.basins):
        assert inspect.signature(function).parameters["settle"].default == SETTLE
    assert Settings.settle == LaunchProblem.settle == SETTLE


def test_a_launch_that_has_settled_hardly_moves_on() -> None:
    """From its end on, Newton's equations move no state by more than three times the distance."""
    asked: dict[str, Any] = {"contact": "viscous", "mu": 0.3, "horizon": 400.0}
    axes = {"x": ("phi_dot", 6.0, 6.1, 2), "y": ("theta", 1.4, 1.5, 2)}
    found, early = st.basins(**asked, **axes), st.basins(**asked, **axes, settle=0.05)
    assert (found.outcome == 1).all() and (early.outcome == 1).all()

    def rates(_: float, x: Any) -> Any:
        return fixed_axes("viscous", x, (0.25, 0.3)).rates

    for dataset, least, most in ((found, 0.0, 3 * SETTLE), (early, 3 * SETTLE, np.inf)):
        cell = dataset.isel(phi_dot=0, theta=0)
        run = st.simulate(
            st.Disk(), st.Viscous(0.3), cell.start_state.values, [float(cell.end_time)]
        )
        ended = [float(run[name][-1]) for name in STATES]
        moved = solve_ivp(rates, (0, 3), ended, rtol=1e-7, atol=1e-9)
        assert least < np.ptp(moved.y, axis=1).max() < most
