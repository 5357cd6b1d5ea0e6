"""Whether a motion has settled on a family: a distance, and a Lyapunov function that proves it.

Near a family member the deviation e (five numbers that vanish on the family) obeys
ė = A e + N(e).  Where A is stable, V = eᵀPe with AᵀP + PA = -1 falls on the ball |e| ≤ ρ if
2 |P| H ρ < 1, H the largest norm of the second derivatives of ė, sampled on that ball (the 2 is
a margin for what lies between the samples).  A state counts as settled if that holds on the ball
around its level set of V, and its distance is below the asked one.  Passing slowly by an unstable
member is not settling: A has no P.
A stable rolling of a slipping disk drifts (`stability.drift`) and so is never settled on.
tests/test_settling.py runs launches on from where they were called settled.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import casadi as ca
import numpy as np

from .contact import MOTION_LAWS
from .equations import disk_system
from .flow import Floats

FAMILIES = ("spinning", "tumbling", "rolling")


@dataclass(frozen=True)
class Nearest:
    """The steady motion nearest to a state, and whether the state has settled on it."""

    family: str
    """Its family; empty for a law that settles on none."""
    at: float
    """The family's parameter there: phi_dot, theta or omega3."""
    distance: float
    """Norm of the deviation, dimensionless."""
    settled: bool
    """Whether the state counts as settled."""
    reach: float
    """Radius of the ball on which the Lyapunov function falls; 0 where there is none."""
    evidence: str
    """One sentence."""


def deviation(six: Floats, k: float, family: str) -> tuple[Floats, Floats]:
    """The member of a family that goes with a state, and the deviation from it.

    Parameters
    ----------
    six
        States, shape (…, 6), dimensionless.
    k
        Inertia factor.
    family
        One of `FAMILIES`.

    Returns
    -------
    at, deviation
        Shapes (…) and (…, 5).

    Examples
    --------
    >>> at, e = deviation(np.array([math.pi / 2, 0, 2.5, 0, 0, 0]), 0.25, "spinning")
    >>> float(at), float(abs(e).max())
    (2.5, 0.0)
    """
    at, parts = _parts(np.moveaxis(six, -1, 0), k, np)[family]
    return at, np.stack(parts, axis=-1)


def _parts(six: Any, k: float, maths: Any) -> dict[str, tuple[Any, tuple[Any, ...]]]:
    """For each family its parameter and the five deviations, with NumPy or with `math`."""
    theta, theta_dot, phi_dot, omega3, vx, vy = six
    lean = theta - math.pi / 2
    rate = maths.copysign(1 / maths.sqrt(k * maths.sin(theta)), phi_dot)
    return {
        "spinning": (phi_dot, (lean, theta_dot, omega3, vx, vy)),
        "tumbling": (theta, (theta_dot, phi_dot - rate, omega3, vx, vy)),
        "rolling": (omega3, (lean, theta_dot, phi_dot, vx, vy)),
    }


def _closest(six: Floats, k: float) -> tuple[str, float, float]:
    """Family, parameter and distance of the nearest member, for one state."""
    parts = _parts(six.tolist(), k, math)
    distance, family = min((math.hypot(*e), name) for name, (_, e) in parts.items())
    return family, parts[family][0], distance


@lru_cache(maxsize=16)
def _transverse(law: str, family: str) -> ca.Function:
    """(at, sign, p, e) → A at the member, and the second derivatives of ė at the deviation e."""
    system = disk_system(law)
    at, sign, e = ca.SX.sym("at"), ca.SX.sym("sign"), ca.SX.sym("e", 5)
    half = math.pi / 2
    rate = sign / ca.sqrt(system.p[0] * ca.sin(at))
    if family == "spinning":
        x = ca.vertcat(half + e[0], e[1], at, e[2:5])
    elif family == "rolling":
        x = ca.vertcat(half + e[0], e[1], e[2], at, e[3:5])
    else:
        x = ca.vertcat(at, e[0], rate + e[1], e[2:5])
    rates = ca.substitute(system.rhs, system.x, x)
    own = {"spinning": [0, 1, 3, 4, 5], "rolling": [0, 1, 2, 4, 5], "tumbling": [1, 2, 3, 4, 5]}
    rate_of_e = rates[own[family]]
    if family == "tumbling":  # the member moves along with theta
        rate_of_e[1] -= ca.jacobian(rate, at) * rates[0]
    jacobian = ca.jacobian(rate_of_e, e)
    second = ca.jacobian(ca.vec(jacobian), e)
    linear = ca.substitute(ca.densify(jacobian), e, ca.SX.zeros(5))
    return ca.Function("transverse", [at, sign, system.p, e], [linear, ca.densify(second)])


def nearest(six: Floats, law: str, p: Floats, within: float) -> Nearest:
    """The steady motion nearest to a state and whether it counts as settled on.

    Parameters
    ----------
    six
        The state, shape (6,), dimensionless.
    law
        A key of `stability.contact.MOTION_LAWS`.
    p
        Parameters of the law's system.
    within
        Largest distance that counts.

    Returns
    -------
    Nearest
    """
    family, at, distance = _closest(six, float(p[0]))
    where = f"nearest is {family} at {at:.6g}, {distance:.3g} away"
    if MOTION_LAWS[law].conservative:
        where += "; energy is kept, so nothing is settled on"
        return Nearest(family, at, distance, False, 0.0, where)
    if law == "coulomb":
        where += "; dry friction ends in sticking, which keeps energy and settles on nothing"
        return Nearest(family, at, distance, False, 0.0, where)
    if distance > within:
        return Nearest(family, at, distance, False, 0.0, where)
    if family == "rolling":
        why = "rolling with slip drifts on its centre manifold (stability.drift): not settled"
        return Nearest(family, at, distance, False, 0.0, why)
    e = deviation(six, float(p[0]), family)[1]
    reach, inside = _reach(law, family, at, math.copysign(1.0, six[2]), p, e)
    if reach == 0.0:
        why = f"{distance:.3g} from {family} at {at:.6g}, which is not asymptotically stable"
    elif not inside:
        why = f"{distance:.3g} from {family} at {at:.6g}, too far for its Lyapunov function"
    else:
        why = (
            f"{distance:.3g} from {family} at {at:.6g}; a Lyapunov function falls on a "
            f"ball of radius {reach:.3g}"
        )
    return Nearest(family, at, distance, inside, reach, why)


def _reach(
    law: str, family: str, at: float, sign: float, p: Floats, e: Floats
) -> tuple[float, bool]:
    """Radius of the ball around the level set of V through e, and whether V falls on it."""
    from scipy.linalg import solve_continuous_lyapunov

    transverse = _transverse(law, family)
    a = np.array(transverse(at, sign, p, np.zeros(5))[0])
    with np.errstate(all="ignore"):
        try:
            matrix = solve_continuous_lyapunov(a.T, -np.eye(5))
        except (ValueError, np.linalg.LinAlgError):
            return 0.0, False
    matrix = (matrix + matrix.T) / 2
    residual = np.abs(a.T @ matrix + matrix @ a + np.eye(5)).max()
    levels = np.linalg.eigvalsh(matrix) if np.isfinite(matrix).all() else np.array([-1.0])
    if not (residual < 0.1 and levels[0] > 0):
        return 0.0, False
    radius = math.sqrt(float(e @ matrix @ e) / levels[0])
    points = radius * _directions()
    second = np.array(transverse(at, sign, p, points.T)[1])
    largest = max(np.linalg.norm(block) for block in np.split(second, len(points), axis=1))
    return radius, bool(2 * levels[-1] * largest * radius < 1)


@lru_cache(maxsize=1)
def _directions() -> Floats:
    """The centre, and points of the unit sphere: both ends of each axis and a fixed scatter."""
    scatter = np.random.default_rng(5).normal(size=(32, 5))
    scatter /= np.linalg.norm(scatter, axis=1, keepdims=True)
    return np.vstack([np.zeros((1, 5)), np.eye(5), -np.eye(5), scatter])
