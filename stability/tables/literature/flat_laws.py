"""Dissipation of a disk that tumbles nearly flat: laws, with the decay that energy gives.

A disk that tumbles with its centre at rest at a small inclination a has the energy 3/2 m g R a, the
precession (g/(k R a))^(1/2) and, relative to the turning frame, a spin of the same size.  A law
whose power is P gives da/dt = -P/(3/2 m g R) = -C a^p.  Units m = R = g = 1.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import casadi as ca

from ...base.types import Record
from ...bodies.resistance import AirTorque, PivotingResistance, Resistance, RollingResistance
from ...systems.mechanics import mechanics
from ...systems.system import System

Force = Callable[[Any, Any], Any]
"""Force against the motion of the contact point along the rim, from its speed and sin theta."""


@dataclass(frozen=True, eq=False)
class Law(Record):
    """A law of dissipation, and what energy says of its decay.

    Examples
    --------
    >>> LAWS[3].name, LAWS[3].power, round(LAWS[3].ends, 12)
    ('dry friction along the rim', -0.5, 0.666666666667)
    """

    name: str
    """Name of the law."""
    formula: str
    """Coefficient C for the coefficient c of the law."""
    power: float
    """Exponent p."""
    over_k: float
    """Exponent of 1/k in C."""
    by: type[Resistance] | Force
    """A resistance of the package, or a force along the rim."""
    source: str
    """Where the law is from."""

    @property
    def ends(self) -> float:
        """Exponent of a in the time left, or in the time passed if p > 1; infinite for p = 1."""
        return 1 / (1 - self.power) if self.power != 1 else math.inf

    @property
    def decay(self) -> str:
        """The decay in words."""
        if self.power == 1:
            return "a ~ exp(-C t)"
        exponent = f"{self.ends:.4g}"
        return f"a ~ t^({exponent})" if self.power > 1 else f"a ~ (t_f - t)^{exponent}"

    def coefficient(self, c: float, k: float) -> float:
        """C for a coefficient of the law.

        Parameters
        ----------
        c
            Coefficient of the law, without dimension.
        k
            Inertia factor [-].
        """
        return float(2 / 3 * c / k**self.over_k)


OWN = "this package (`{}`)"
"""Source of a law that is a class of the package."""
LAWS = (
    Law(
        "rolling resistance",
        "2/3 c/k",
        1.0,
        1.0,
        RollingResistance,
        OWN.format("RollingResistance"),
    ),
    Law(
        "pivoting resistance",
        "2/3 c/k",
        3.0,
        1.0,
        PivotingResistance,
        OWN.format("PivotingResistance"),
    ),
    Law("air torque", "2/3 c/k", 1.0, 1.0, AirTorque, OWN.format("AirTorque")),
    Law(
        "dry friction along the rim",
        "2/3 c/k^(1/2)",
        -0.5,
        0.5,
        lambda rim, _: -ca.sign(rim),
        "contour friction of Le Saux, Leine & Glocker, J. Nonlinear Sci. 15 (2005)",
    ),
    Law(
        "viscous friction along the rim",
        "2/3 c/k",
        -1.0,
        1.0,
        lambda rim, _: -rim,
        "contour friction of Le Saux, Leine & Glocker, J. Nonlinear Sci. 15 (2005)",
    ),
    Law(
        "layer of air below",
        "2/3 c/k",
        -2.0,
        1.0,
        lambda rim, s: -rim / s,
        "Moffatt, Nature 404 (2000) 833-834, with c = pi k mu for air of viscosity mu",
    ),
)
"""The laws of the table."""


def rim_disk(force: Force) -> System:
    """A thin disk with viscous sliding and a force along its rim, from its energies.

    The force acts on the spin relative to the turning frame: that is the speed at which the contact
    point moves along the rim.

    Parameters
    ----------
    force
        The force, for a coefficient of 1.

    Returns
    -------
    System
        Parameters: k, the coefficient of sliding, that of the force.

    Source: Lagrange's equations.

    Examples
    --------
    >>> rim_disk(lambda rim, s: -rim).states
    ('phi', 'theta', 'dx', 'dy', 'dphi', 'dtheta', 'dpsi')
    """
    q = ca.vertcat(*(ca.SX.sym(n) for n in ("x", "y", "phi", "theta", "psi")))
    u = ca.vertcat(*(ca.SX.sym(n) for n in ("dx", "dy", "dphi", "dtheta", "dpsi")))
    k, sliding, c = (ca.SX.sym(n) for n in ("k", "sliding", "c"))
    east, north, level, up = ca.cos(q[2]), ca.sin(q[2]), ca.cos(q[3]), ca.sin(q[3])
    radius = ca.vertcat(east * level, north * level, -up)
    axis = ca.vertcat(east * up, north * up, level)
    across = ca.vertcat(-north, east, 0)
    turn = u[2] * ca.SX([0, 0, 1]) + u[3] * across + u[4] * axis
    one, two, three = (ca.dot(turn, e) for e in (radius, across, axis))
    centre = ca.vertcat(u[0], u[1], level * u[3])
    slip = (centre + ca.cross(turn, radius))[:2]
    forces = -sliding * ca.jacobian(slip, u).T @ slip
    forces[4] += c * force(u[4], up)
    return mechanics(
        q,
        u,
        ca.vertcat(k, sliding, c),
        potential=up,
        forces=forces,
        kinetic=(ca.sumsqr(centre) + k * (one**2 + two**2 + 2 * three**2)) / 2,
        ignorable=("x", "y", "psi"),
        name="disk with friction along its rim",
    )
