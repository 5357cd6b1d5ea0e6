"""Newton's and Euler's equations of a body of revolution on a plane, for one contact law.

Frames and signs are those of Przybylska & Rauch-Wojciechowski 2016, Section 2: 3̂ is the symmetry
axis, 1̂ points away from it in the vertical plane through the axis, 2̂ = 3̂×1̂ is horizontal; ẑ is
vertical, ŷ = 2̂, x̂ = ŷ×ẑ.  A body says its velocity, momentum, torque and energy; this module
does what is the same for all of them.
"""

from __future__ import annotations

from contextlib import suppress
from typing import Any

import casadi as ca

from ..base.errors import ParameterError, shown
from .contact import Contact

STATES = ("theta", "theta_dot", "phi_dot", "omega3", "slip_x", "slip_y")
"""State names in their order; laws without slip in the state keep the first four."""


class NewtonEuler:
    """Residuals that are linear in accelerations and contact force.

    Parameters
    ----------
    x
        The states, in the order of `STATES`.
    contact
        Class of the law.
    mu
        The law's coefficients, as its `force` takes them.
    slips
        Whether the two slip velocities are states.
    slip
        The slip along x̂ and ŷ where it follows from the other states; None for none.
    """

    mass: Any = 1
    """Mass in the units of the equations."""
    weight: Any = 1
    """Mass times gravity."""
    slip_rate: ca.SX | None = None
    """Rate of a slip that is stated and is a symbol; None where it follows from the states."""

    def __init__(
        self,
        x: ca.SX,
        contact: type[Contact],
        mu: Any,
        slips: bool,
        slip: list[ca.SX] | None = None,
    ) -> None:
        self.x, self.mu, self.slips = x, mu, slips
        self.law = contact.__new__(contact)  # only its formulas are used, never its coefficient
        self.holds = holds = contact.holds
        self.sine, self.cosine = ca.sin(x[0]), ca.cos(x[0])
        if slips:
            self.slip = [x[4], x[5]]
        elif holds:
            self.slip = [ca.SX(0), ca.SX(0)] if slip is None else slip
        else:  # smooth, centre without horizontal velocity
            self.slip = self.own_slip()
        self.d_theta_dot, self.d_phi_dot, self.d_omega3 = (
            ca.SX.sym("d_" + name) for name in STATES[1:4]
        )
        self.normal = ca.SX.sym("normal")
        self.extra = [ca.SX.sym("e1"), ca.SX.sym("e2")] if slips or holds else []
        self.force = self.extra if holds else self._stated(mu)
        acc = ["d_theta_dot", "d_phi_dot", "d_omega3", "normal"]
        more = ["force_x", "force_y"] if holds else ["d_slip_x", "d_slip_y"]
        self.unknown_names = tuple(acc + (more if self.extra else []))
        # gn from the vertical, φ̈ from 1̂ (pivot I₁ sinθ), θ̈ from 2̂ (pivot D), ω̇₃ from 3̂, the rest
        # from the horizontal: these pivots vanish only where sinθ = 0 or D = 0.  A force that holds
        # the slip is eliminated first, so that D of the rough disk is k + 1.
        order = [(2, 3), (3, 1), (4, 0), (5, 2), (0, 4), (1, 5)]
        if holds:
            order = [(0, 4), (1, 5), *order[:4]]
        if not self.extra:
            order = [(r - 2, c) for r, c in order[:4]]
        self.pivots = order
        self.pivot_d = order.index((4, 0) if self.extra else (2, 0))

    # --- what a body says ---

    def own_slip(self) -> list[ca.SX]:
        """Slip of a centre without horizontal velocity: ω×a along x̂ and ŷ."""
        raise NotImplementedError

    def velocity(self) -> ca.SX:
        """Velocity of the centre along (x̂, ŷ, ẑ)."""
        raise NotImplementedError

    def spin(self, momentum: ca.SX) -> ca.SX:
        """Angular velocity along (1̂, 2̂, 3̂), from the angular momentum."""
        raise NotImplementedError

    def momentum(self) -> ca.SX:
        """Angular momentum about the centre along (1̂, 2̂, 3̂)."""
        raise NotImplementedError

    def torque(self, fx: Any, fy: Any) -> ca.SX:
        """Torque of the contact force about the centre along (1̂, 2̂, 3̂)."""
        raise NotImplementedError

    def potential(self) -> ca.SX:
        """Potential energy."""
        raise NotImplementedError

    def law_force(self, slip: Any, normal: Any, mu: Any) -> Any:
        """Force of the law in the units of the equations."""
        return self.law.force(slip, normal, mu)

    def law_power(self, slip: Any, normal: Any, mu: Any) -> Any:
        """Power that the law dissipates in the units of the equations."""
        return self.law.power(slip, normal, mu)

    # --- the same for every body ---

    def _stated(self, mu: Any) -> list[Any]:
        """The force that the law states, which must be two expressions."""
        found = self.law_force(self.slip, self.normal, mu)
        if isinstance(found, (list, tuple)) and len(found) == 2:
            with suppress(NotImplementedError, TypeError):  # CasADi's errors for another type
                return [ca.SX(f) for f in found]
        raise ParameterError(
            f"the force of the {self.law.name} law is {shown(found)}; give a list of two "
            "expressions."
        )

    def rate(self, expression: ca.SX) -> ca.SX:
        """d/dt along the motion by the chain rule, with the accelerations as symbols."""
        rates = [self.x[1], self.d_theta_dot, self.d_phi_dot, self.d_omega3]
        if self.slips:
            rates += self.extra
        found = ca.jtimes(expression, self.x, ca.vertcat(*rates))
        if self.slip_rate is not None:
            found += ca.jtimes(expression, ca.vertcat(*self.slip), self.slip_rate)
        return found

    def implicit_form(self) -> tuple[ca.SX, ca.SX]:
        """The mass matrix and forcing of m s̈ = -mgẑ + force, L̇ = a × force."""
        theta_dot, phi_dot = self.x[1], self.x[2]
        fx, fy = self.force
        velocity, momentum = self.velocity(), self.momentum()
        turn_k = ca.vertcat(0, 0, phi_dot)
        acceleration = self.rate(velocity) + ca.cross(turn_k, velocity)
        newton = self.mass * acceleration - ca.vertcat(fx, fy, self.normal - self.weight)
        turn_body = ca.vertcat(-phi_dot * self.sine, theta_dot, phi_dot * self.cosine)
        euler = self.rate(momentum) + ca.cross(turn_body, momentum) - self.torque(fx, fy)
        residual = ca.vertcat(newton, euler) if self.extra else ca.vertcat(newton[2], euler)
        unknowns = ca.vertcat(
            self.d_theta_dot, self.d_phi_dot, self.d_omega3, self.normal, *self.extra
        )
        mass = ca.jacobian(residual, unknowns)
        if ca.depends_on(mass, unknowns):
            raise ParameterError(
                f"the force of the {self.law.name} law is not linear in the normal force; give one "
                "that is."
            )
        forcing = -ca.substitute(residual, unknowns, ca.SX.zeros(unknowns.numel()))
        return mass, forcing

    def observables(self, solved: dict[str, ca.SX], pivots: list[ca.SX]) -> dict[str, ca.SX]:
        """Energy, forces, slip, D and the dissipated power."""
        velocity, momentum = self.velocity(), self.momentum()
        kinetic = (self.mass * ca.sumsqr(velocity) + ca.dot(self.spin(momentum), momentum)) / 2
        normal = solved["normal"]
        if self.holds:
            force = [solved["force_x"], solved["force_y"]]
            power = -(force[0] * self.slip[0] + force[1] * self.slip[1])
        else:
            force = self.law_force(self.slip, normal, self.mu)
            power = self.law_power(self.slip, normal, self.mu)
        return {
            "energy": kinetic + self.potential(),
            "normal_force": normal,
            "contact_force": ca.SX(ca.vertcat(*force)),
            "slip": ca.SX(ca.vertcat(*self.slip)),
            "determinant": pivots[self.pivot_d],
            "power": ca.SX(power),
        }
