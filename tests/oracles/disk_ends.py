"""Where launches of a disk end, apart from the package: Kane's equations and SciPy's DOP853.

All launches of a call take the same steps, so that each right-hand side is one call.  A launch that
lifts off stops.  The normal force is looked at in the middle of steps too.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from kane_disk import kane
from numpy.typing import NDArray
from scipy.integrate import DOP853

LOOKS = (0.2, 0.4, 0.6, 0.8, 1.0)
"""Parts of a step at which the normal force is looked at."""
UPRIGHT, LEANING, STILL = 1e-5, 1e-2, 1e-3
"""Largest lean [rad] and rates of an upright end; least lean and largest rates of a leaning one."""


def ends(
    starts: NDArray[Any], k: float, mu: float, horizon: float, tolerance: float = 1e-10
) -> list[str]:
    """The end of each launch under viscous friction: a word, *open* where it is not plain.

    Parameters
    ----------
    starts
        Shape (n, 6), dimensionless.
    k, mu
        Inertia and friction.
    horizon
        Last time.
    tolerance
        Relative, and a hundred times the absolute one.
    """
    n, gone = len(starts), np.zeros(len(starts), bool)
    p = np.tile([k, mu], (n, 1))

    def rates(_: float, y: NDArray[Any]) -> NDArray[Any]:
        found = kane("viscous", y.reshape(n, 6), p).rates
        found[gone] = 0.0
        return found.ravel()

    def lifted(y: NDArray[Any]) -> NDArray[np.bool_]:
        return kane("viscous", y.reshape(n, 6), p).normal_force <= 0

    run = DOP853(rates, 0.0, starts.ravel(), horizon, rtol=tolerance, atol=0.01 * tolerance)
    gone |= lifted(run.y)
    while run.status == "running":
        run.step()
        dense, before = run.dense_output(), gone.copy()
        for part in LOOKS:
            gone |= lifted(dense(run.t_old + part * (run.t - run.t_old)))
        if (gone & ~before).any():  # those stop here; the stages that DOP853 keeps are renewed
            run.f = run.fun(run.t, run.y)
    last, speeds = run.y.reshape(n, 6), run.f.reshape(n, 6)
    lean, moving = np.abs(np.cos(last[:, 0])), np.abs(np.delete(speeds, 0, axis=1)).max(axis=1)
    moving = np.maximum(moving, np.abs(last[:, 1]))
    words = np.full(n, "open", dtype=object)
    words[(lean < UPRIGHT) & (moving < STILL)] = "spinning"
    words[(lean > LEANING) & (moving < STILL)] = "tumbling"
    words[gone] = "lift-off"
    return [str(w) for w in words]
