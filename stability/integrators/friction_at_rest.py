"""A contact point at rest under dry friction: every continuation.

At rest every continuation is listed: sticking, if the force lies in the friction cone, and each
direction with h = 0, f > 0, gn > 0 in which a slip can set in (f and h: the slip's acceleration
along and across its direction).  h times the determinant D is a trigonometric polynomial of degree
two, so there are at most four directions.  docs/explanation/dry-friction.md proves that exactly one
continuation exists below mu = 2√(k(k+1)).  tests/integrators/test_coulomb.py compares this module
with closed formulas.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import casadi as ca
import numpy as np

from ..algebra.program import Program
from ..base.types import Floats
from ..bodies.thin_disk.disk_equations import disk_system


@dataclass(frozen=True, eq=False)
class Continuations:
    """Continuations of a motion from rest."""

    sticks: bool
    """Whether the force of sticking lies inside the friction cone, with gn > 0."""
    ratio: float
    """|F| / (mu gn) of sticking."""
    directions: tuple[float, ...]
    """Angles in which a slip can set in [rad]."""
    lifts: bool = False
    """Whether the contact point, left to itself, accelerates upwards, so that it can lift off."""

    @property
    def count(self) -> int:
        """Number of continuations."""
        return self.sticks + self.lifts + len(self.directions)

    @property
    def pressed(self) -> bool:
        """Whether a continuation keeps the contact."""
        return self.sticks or bool(self.directions)


@lru_cache(maxsize=1)
def _at_rest() -> tuple[Program, Program]:
    """Programs at rest: slip acceleration, gn and D in a direction; gn and force of sticking."""
    along = disk_system("coulomb", direction=True)
    seen = along.observables
    rough = disk_system("rough")
    held = rough.observables
    sliding = ca.vertcat(along.rhs[4:6], seen["normal_force"], seen["determinant"])
    sticking = ca.vertcat(held["normal_force"], held["contact_force"])
    return (
        Program(ca.Function("sliding", [along.x, along.p], [sliding])),
        Program(ca.Function("sticking", [rough.x, rough.p], [sticking])),
    )


def slip_acceleration(
    four: Floats, k: float, mu: float, angles: Floats
) -> tuple[Floats, Floats, Floats, Floats]:
    """The slip's acceleration at rest, for an onset in a direction.

    Parameters
    ----------
    four
        theta, theta_dot, phi_dot, omega3.
    k, mu
        Inertia factor and friction.
    angles
        Directions from x̂ [rad], shape (n,).

    Returns
    -------
    along, across, normal, determinant
        f, h, gn and D, shape (n,) each.
    """
    x = [*(np.full_like(angles, v) for v in four), np.zeros_like(angles), np.zeros_like(angles)]
    p = [np.full_like(angles, k), np.full_like(angles, mu), angles]
    vx, vy, normal, d = np.moveaxis(_at_rest()[0].arrays([x, p], angles.shape)[0][..., 0], -1, 0)
    c, s = np.cos(angles), np.sin(angles)
    return c * vx + s * vy, c * vy - s * vx, normal, d


def sticking_force(four: Floats, k: float) -> tuple[float, float, float]:
    """Normal force and horizontal force that hold the contact point at rest [m g].

    Parameters
    ----------
    four
        theta, theta_dot, phi_dot, omega3.
    k
        Inertia factor.

    Returns
    -------
    normal, force_x, force_y

    Examples
    --------
    >>> sticking_force(np.array([math.pi / 2, 0, 0, 1.2]), 0.25)[0]
    1.0
    """
    arguments = [[np.float64(v) for v in four], [np.float64(k)]]
    values = _at_rest()[1].arrays(arguments, ())[0][..., 0]
    return float(values[0]), float(values[1]), float(values[2])


def directions(four: Floats, k: float, mu: float) -> Floats:
    """Every direction in which the slip's acceleration at rest is radial (h = 0), to rounding.

    Parameters
    ----------
    four, k, mu
        As for `slip_acceleration`.

    Returns
    -------
    ndarray
        Angles, at most four.
    """
    angles: Floats = np.arange(8.0) * (math.pi / 4)
    _, across, _, d = slip_acceleration(four, k, mu, angles)
    if not np.isfinite(across * d).all():
        angles = angles + 0.1  # a sample hit D = 0
        _, across, _, d = slip_acceleration(four, k, mu, angles)
    waves = np.fft.fft(across * d) / 8
    waves = waves * np.exp(-1j * np.fft.fftfreq(8, 1 / 8) * angles[0])
    polynomial = np.array([waves[2], waves[1], waves[0], waves[-1], waves[-2]])
    roots = np.roots(polynomial)
    near = np.angle(roots[np.abs(np.abs(roots) - 1) < 1e-6])
    return np.array([polish(four, k, mu, a) for a in near])


def polish(four: Floats, k: float, mu: float, angle: float) -> float:
    """A direction with h = 0 near a given one, by Newton's rule with a difference for the slope.

    Parameters
    ----------
    four, k, mu
        As for `slip_acceleration`.
    angle
        Angle near that direction [rad].

    Returns
    -------
    float
        The angle [rad]; near the given one where h has no simple zero nearby.
    """
    step = 1e-6
    for _ in range(3):
        h = slip_acceleration(four, k, mu, np.array([angle - step, angle, angle + step]))[1]
        slope = (h[2] - h[0]) / (2 * step)
        if slope == 0 or not np.isfinite(slope) or abs(h[1] / slope) > 1e-3:
            break
        angle -= h[1] / slope
    return float(angle)


def continuations(four: Floats, k: float, mu: float) -> Continuations:
    """Every continuation from rest.

    Parameters
    ----------
    four, k, mu
        As for `slip_acceleration`.

    Returns
    -------
    Continuations

    Examples
    --------
    >>> at_rest = np.array([math.pi / 2, 0.0, 0.0, 1.2])
    >>> c = continuations(at_rest, 0.25, 0.3)
    >>> c.sticks, c.directions
    (True, ())
    """
    normal, fx, fy = sticking_force(four, k)
    ratio = math.hypot(fx, fy) / (mu * normal) if normal > 0 else math.inf
    candidates = directions(four, k, mu)
    free: tuple[float, ...] = ()
    # gn D = -k bz in every direction; with bz > 0 a direction with gn > 0 has D < 0
    _, _, weight, d = slip_acceleration(four, k, mu, np.zeros(1))
    lifts = bool(weight[0] * d[0] < 0)
    if candidates.size:
        along, _, gn, _ = slip_acceleration(four, k, mu, candidates)
        free = tuple(float(a) for a in candidates[(along > 1e-9) & (gn > 0)])
    return Continuations(ratio <= 1.0, ratio, free, lifts)
