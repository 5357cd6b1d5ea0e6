"""Settling of the disk: closed forms of its members, and what surrounds them.

Near a family member the deviation e is five numbers that vanish on the family.  A state counts as
settled if its distance is below the asked one and `stability.settling.attraction` proves, in ball
arithmetic, that the motion from there on converges to one member.  Passing slowly by an unstable
member is not settling: nothing attracts there.  A stable rolling of a slipping disk drifts
(`stability.drift`) and so is never settled on.  tests/test_settling.py runs launches on from where
they were called settled.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import casadi as ca
import numpy as np

from ..algebra.number_types import casadi_algebra
from ..algebra.program import Program
from ..base.types import Floats
from ..bodies.contact import Contact
from ..bodies.disk_equations import disk_system
from .attraction import Attraction, Surroundings, Tilted, attraction
from .nearest import Nearest

FAMILIES = ("spinning", "tumbling", "rolling")
ACROSS = {"spinning": [0, 1, 3, 4, 5], "tumbling": [1, 2, 3, 4, 5]}
"""States whose deviations are e, by family."""


@dataclass(frozen=True)
class DiskSettling:
    """Settling of the disk under a contact law."""

    law: type[Contact]
    """The law."""

    def nearest(self, state: Floats, p: Floats, within: float) -> Nearest:
        """As `nearest`."""
        return nearest(state, self.law, p, within)

    def distances(self, states: Floats, p: Floats, near: Nearest) -> Floats:
        """Distances of states, shape (t, 6), from the family of a nearest member, shape (t,)."""
        found: Floats = np.linalg.norm(deviation(states, float(p[0]), near.family)[1], axis=-1)
        return found


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
    found = settled(law, family, p, sign, y, e)
    if found is None:
        why = (
            f"{distance:.3g} from {family} at {at:.6g}; convergence to it is not proved from there"
        )
        return Nearest(family, at, distance, False, 0.0, why)
    why = (
        f"{distance:.3g} from {family} at {at:.6g}; proved in ball arithmetic: from there on the "
        f"motion converges to {family} at {found.limit[0]:.6g} within {found.error:.2g}, its "
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


def settled(
    law: type[Contact], family: str, p: Floats, sign: float, y: Any, e: list[Any]
) -> Attraction | None:
    """A proof that a motion converges to one steady motion of the disk.

    Parameters
    ----------
    law, family
        As for `surroundings`.
    p
        Parameters of the law's system.
    sign
        Sign of φ̇.
    y, e
        Parameter of the nearest member and deviation, as balls that hold the true ones.

    Returns
    -------
    Attraction or None
        None where the test fails.
    """
    around = surroundings(law, family)  # type: ignore[arg-type]  # a class is hashable
    return attraction(around, [sign, *p.tolist()], [y], e)


@lru_cache(maxsize=16)
def surroundings(law: type[Contact], family: str) -> Surroundings:
    """Programs of (y, (sign, p), e) → ∂G/∂e and ∂g/∂e, and → gn, D and sinθ.

    Parameters
    ----------
    law
        A contact law with the slip in its state.
    family
        spinning or tumbling.

    Returns
    -------
    Surroundings
    """
    system = disk_system(law)
    y, sign, e = ca.SX.sym("y"), ca.SX.sym("sign"), ca.SX.sym("e", 5)
    parts = [e[i] for i in range(5)]
    x: list[Any]
    member = sign / ca.sqrt(system.p[0] * ca.sin(y))
    if family == "spinning":
        x = [Tilted(parts[0]), parts[1], y, *parts[2:]]
    else:
        x = [y, parts[0], member + parts[1], *parts[2:]]
    seen = system.observables
    positive = ca.vertcat(seen["normal_force"], seen["determinant"], ca.sin(system.x[0]))
    graph = Program(ca.Function("graph", [system.x, system.p], [system.rhs, positive]))
    values = graph.run(casadi_algebra(), [x, ca.vertsplit(system.p)])
    rhs = dict(zip((row for row, _ in graph.places[0]), values[0], strict=True))
    if family == "spinning":
        across, along = [rhs[i] for i in ACROSS[family]], rhs[2]
    else:
        across, along = [rhs[i] for i in ACROSS[family]], parts[0]
        across[1] = across[1] - ca.jacobian(member, y) * parts[0]  # the member moves with theta
    slope = ca.densify(ca.jacobian(ca.vertcat(*across, along), e))
    inputs = [y, ca.vertcat(sign, system.p), e]
    return Surroundings(
        1, 5, Program(ca.Function("slopes", inputs, [slope])),
        Program(ca.Function("positive", inputs, [ca.densify(ca.vertcat(*values[1]))])),
    )  # fmt: skip
