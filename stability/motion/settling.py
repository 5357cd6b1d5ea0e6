"""Whether a motion has settled on a family: a distance, and a proof that it converges.

Near a family member the deviation e is five numbers that vanish on the family.  A state counts as
settled if its distance is below the asked one and `stability.motion.attraction` proves, in ball
arithmetic, that the motion from there on converges to one member.  Passing slowly by an unstable
member is not settling: nothing attracts there.  A stable rolling of a slipping disk drifts
(`stability.drift`) and so is never settled on.  tests/test_settling.py runs launches on from where
they were called settled.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..base.types import Floats
from ..bodies.contact import Contact
from .attraction import attraction

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
    """Size of the box across the family in which convergence is proved; 0 where it is not."""
    evidence: str
    """One sentence."""


def deviation(six: Floats, k: float, family: str) -> tuple[Floats, Floats]:
    """The member of a family that belongs to a state, and the deviation from it.

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
    sine = maths.sin(theta)
    # at θ = 0 and beyond, where no disk stands, tumbling is infinitely far
    with np.errstate(divide="ignore"):
        size = 1 / np.sqrt(k * np.maximum(sine, 0.0)) if maths is np else _rate(k * sine)
    rate = maths.copysign(size, phi_dot)
    return {
        "spinning": (phi_dot, (lean, theta_dot, omega3, vx, vy)),
        "tumbling": (theta, (theta_dot, phi_dot - rate, omega3, vx, vy)),
        "rolling": (omega3, (lean, theta_dot, phi_dot, vx, vy)),
    }


def _rate(square: float) -> float:
    """One over the root; infinite where there is none."""
    return 1 / math.sqrt(square) if square > 0 else math.inf


def _closest(six: Floats, k: float) -> tuple[str, float, float]:
    """Family, parameter and distance of the nearest member, for one state."""
    parts = _parts(six.tolist(), k, math)
    distance, family = min((math.hypot(*e), name) for name, (_, e) in parts.items())
    return family, parts[family][0], distance


def nearest(six: Floats, law: type[Contact], p: Floats, within: float) -> Nearest:
    """The steady motion nearest to a state and whether it counts as settled on.

    Parameters
    ----------
    six
        The state, shape (6,), dimensionless.
    law
        The law.
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
    if law.conservative:
        where += "; energy is kept, so nothing is settled on"
        return Nearest(family, at, distance, False, 0.0, where)
    if law.sticks:
        where += "; dry friction ends in sticking, which keeps energy and settles on nothing"
        return Nearest(family, at, distance, False, 0.0, where)
    if distance > within:
        return Nearest(family, at, distance, False, 0.0, where)
    if family == "rolling":
        why = "rolling with slip drifts on its centre manifold (stability.drift): not settled"
        return Nearest(family, at, distance, False, 0.0, why)
    sign = math.copysign(1.0, six[2])
    y, e = _balls(six, float(p[0]), family, sign)
    found = attraction(law, family, p, sign, y, e)
    if found is None:
        why = (
            f"{distance:.3g} from {family} at {at:.6g}; convergence to it is not proved from there"
        )
        return Nearest(family, at, distance, False, 0.0, why)
    why = (
        f"{distance:.3g} from {family} at {at:.6g}; proved in ball arithmetic: from there on the "
        f"motion converges to {family} at {found.limit:.6g} within {found.error:.2g}, its "
        f"deviation falling at the rate {found.rate:.3g} at least"
    )
    return Nearest(family, at, distance, True, found.reach, why)


def _balls(six: Floats, k: float, family: str, sign: float) -> tuple[Any, list[Any]]:
    """The family's parameter and the deviation, as balls that hold what the doubles mean."""
    from flint import arb

    theta, theta_dot, phi_dot, omega3, vx, vy = (arb(v) for v in six.tolist())
    if family == "spinning":
        return phi_dot, [theta - arb.pi() / 2, theta_dot, omega3, vx, vy]
    return theta, [theta_dot, phi_dot - sign / (k * theta.sin()).sqrt(), omega3, vx, vy]
