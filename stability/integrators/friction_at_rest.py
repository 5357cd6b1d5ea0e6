"""A contact point at rest under dry friction: every continuation.

At rest every continuation is listed: sticking, if the force lies in the friction cone, and each
direction with h = 0, f > 0, gn > 0 in which a slip can set in (f and h: the slip's acceleration
along and across its direction).  h times the determinant D is a trigonometric polynomial of degree
two, so there are at most four directions.  Exactly one continuation of a disk exists below
mu = 2√(k(k+1)): docs/explanation/dry-friction.md.  tests/integrators/test_coulomb.py compares this
module with closed formulas.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from ..algebra.program import Program
from ..base.types import Floats
from ..bodies.model import Dry

WIDE = 1e-4
"""Distance of a root from the unit circle, and of an acceleration from 0, for a closer look."""


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


@lru_cache(maxsize=32)
def _at_rest(dry: Dry) -> tuple[Program, Program]:
    """Programs at rest: slip acceleration, gn and D in a direction; gn and force of sticking."""
    along, held = dry.sliding, dry.held
    seen, there = along.observables, held.observables
    sliding = ca.vertcat(along.rhs[4:6], seen["normal_force"], seen["determinant"])
    sticking = ca.vertcat(there["normal_force"], there["contact_force"])
    return (
        Program(ca.Function("sliding", [along.x, along.p], [sliding])),
        Program(ca.Function("sticking", [held.x, held.p], [sticking])),
    )


def slip_acceleration(
    dry: Dry, four: Floats, p: Floats, angles: Floats
) -> tuple[Floats, Floats, Floats, Floats]:
    """The slip's acceleration at rest, for an onset in a direction.

    Parameters
    ----------
    dry
        The body at rest.
    four
        theta, theta_dot, phi_dot, omega3, shape (4, …).
    p
        Parameters of its system of sliding.
    angles
        Directions from x̂ [rad], shape (…, n).

    Returns
    -------
    along, across, normal, determinant
        f, h, gn and D, shape (…, n) each.
    """
    x = [np.broadcast_to(np.asarray(v)[..., None], angles.shape) for v in four]
    x += [np.zeros_like(angles), np.zeros_like(angles)]
    given = dry.in_direction([np.full_like(angles, v) for v in p], angles)
    found = _at_rest(dry)[0].arrays([x, given], angles.shape)[0][..., 0]
    vx, vy, normal, d = np.moveaxis(found, -1, 0)
    c, s = np.cos(angles), np.sin(angles)
    return c * vx + s * vy, c * vy - s * vx, normal, d


def sticking_force(dry: Dry, four: Floats, p: Floats) -> tuple[float, float, float]:
    """Normal force and horizontal force that hold the contact point at rest [m g].

    Parameters
    ----------
    dry, four, p
        As for `slip_acceleration`.

    Returns
    -------
    normal, force_x, force_y

    Examples
    --------
    >>> from stability.bodies.thin_disk import disk_model
    >>> dry = disk_model("coulomb").dry
    >>> sticking_force(dry, np.array([math.pi / 2, 0, 0, 1.2]), np.array([0.25, 0.3]))[0]
    1.0
    """
    arguments = [[np.float64(v) for v in four], [np.float64(v) for v in dry.at_rest(p)]]
    values = _at_rest(dry)[1].arrays(arguments, ())[0][..., 0]
    return float(values[0]), float(values[1]), float(values[2])


def directions(dry: Dry, four: Floats, p: Floats) -> Floats:
    """Every direction in which the slip's acceleration at rest is radial (h = 0), to rounding.

    Parameters
    ----------
    dry, four, p
        As for `slip_acceleration`.

    Returns
    -------
    ndarray
        Angles, at most four.
    """
    angles: Floats = np.arange(8.0) * (math.pi / 4)
    _, across, _, d = slip_acceleration(dry, four, p, angles)
    if not np.isfinite(across * d).all():
        angles = angles + 0.1  # a sample hit D = 0
        _, across, _, d = slip_acceleration(dry, four, p, angles)
    waves = np.fft.fft(across * d) / 8
    waves = waves * np.exp(-1j * np.fft.fftfreq(8, 1 / 8) * angles[0])
    polynomial = np.array([waves[2], waves[1], waves[0], waves[-1], waves[-2]])
    roots = np.roots(polynomial)
    near = np.angle(roots[np.abs(np.abs(roots) - 1) < 1e-6])
    return np.array([polish(dry, four, p, a) for a in near])


def suspects(dry: Dry, rows: Floats, p: Floats) -> NDArray[np.bool_]:
    """Rows at which a slip may set in, or the contact may lift off; the others have no such way.

    Parameters
    ----------
    dry, p
        As for `slip_acceleration`.
    rows
        theta, theta_dot, phi_dot, omega3, shape (n, 4).

    Returns
    -------
    ndarray
        Shape (n,).
    """
    angles = np.tile(0.1 + np.arange(8.0) * (math.pi / 4), (len(rows), 1))
    with np.errstate(all="ignore"):
        _, across, normal, d = slip_acceleration(dry, rows.T, p, angles)
        waves = np.fft.fft(across * d) / 8
        first = waves[:, [2]]
        known = np.isfinite(waves).all(axis=1) & (np.abs(first[:, 0]) > 0)
        companion = np.tile(np.eye(4, k=-1, dtype=complex), (len(rows), 1, 1))
        companion[known, 0] = -(waves[:, [1, 0, -1, -2]] / first)[known]
        roots = np.linalg.eigvals(companion)
        near = np.abs(np.abs(roots) - 1) < WIDE
        along, _, pressed, _ = slip_acceleration(dry, rows.T, p, np.angle(roots) + 0.1)
        free = near & ~((along < -WIDE * (1 + np.abs(along))) | (pressed < 0))
    found: NDArray[np.bool_] = ~known | free.any(axis=1) | ~(normal[:, 0] * d[:, 0] > 0)
    return found


def polish(dry: Dry, four: Floats, p: Floats, angle: float) -> float:
    """A direction with h = 0 near a given one, by Newton's rule with a difference for the slope.

    Parameters
    ----------
    dry, four, p
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
        h = slip_acceleration(dry, four, p, np.array([angle - step, angle, angle + step]))[1]
        slope = (h[2] - h[0]) / (2 * step)
        if slope == 0 or not np.isfinite(slope) or abs(h[1] / slope) > 1e-3:
            break
        angle -= h[1] / slope
    return float(angle)


def continuations(dry: Dry, four: Floats, p: Floats) -> Continuations:
    """Every continuation from rest.

    Parameters
    ----------
    dry, four, p
        As for `slip_acceleration`.

    Returns
    -------
    Continuations

    Examples
    --------
    >>> at_rest = np.array([math.pi / 2, 0.0, 0.0, 1.2])
    >>> from stability.bodies.thin_disk import disk_model
    >>> c = continuations(disk_model("coulomb").dry, at_rest, np.array([0.25, 0.3]))
    >>> c.sticks, c.directions
    (True, ())
    """
    normal, fx, fy = sticking_force(dry, four, p)
    ratio = math.hypot(fx, fy) / (dry.friction(p) * normal) if normal > 0 else math.inf
    candidates = directions(dry, four, p)
    free: tuple[float, ...] = ()
    # gn D has one value in every direction; with bz > 0 a direction with gn > 0 has D < 0
    _, _, weight, d = slip_acceleration(dry, four, p, np.zeros(1))
    lifts = bool(weight[0] * d[0] < 0)
    if candidates.size:
        along, _, gn, _ = slip_acceleration(dry, four, p, candidates)
        free = tuple(float(a) for a in candidates[(along > 1e-9) & (gn > 0)])
    return Continuations(ratio <= 1.0, ratio, free, lifts)
