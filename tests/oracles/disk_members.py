"""Members of the disk's families and deviations from them, by formulas written for tests alone."""

from typing import Any

import numpy as np


def deviation(six: Any, k: float, family: str) -> tuple[Any, Any]:
    """The number that names the nearest member, and the five deviations, of states (…, 6)."""
    theta, theta_dot, phi_dot, omega3, *slip = np.moveaxis(np.asarray(six, dtype=float), -1, 0)
    tilt = theta - np.pi / 2
    at, off = {
        "rolling": (omega3, (tilt, theta_dot, phi_dot)),
        "spinning": (phi_dot, (tilt, theta_dot, omega3)),
        "tumbling": (
            theta,
            (theta_dot, phi_dot - np.copysign(1, phi_dot) / np.sqrt(k * np.sin(theta)), omega3),
        ),
    }[family]
    return at, np.stack([*off, *slip], axis=-1)
