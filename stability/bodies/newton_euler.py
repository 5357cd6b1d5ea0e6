"""Newton's and Euler's equations of a body of revolution on a plane, for one contact law.

Frames and signs are those of Przybylska & Rauch-Wojciechowski 2016, Section 2: 3̂ is the symmetry
axis, 1̂ points away from it in the vertical plane through the axis, 2̂ = 3̂×1̂ is horizontal; ẑ is
vertical, ŷ = 2̂, x̂ = ŷ×ẑ.  The contact point lies at a = h' x̂ - h ẑ from the centre of mass, where
h(θ) is the height of the centre.  Only h and h' stand in the equations.  Their rates bring in h'',
so a linearisation at a steady motion (θ̇ = 0) needs h, h' and h'' alone.
tests/bodies/test_round_bodies.py compares these equations with an inertial formulation,
tests/bodies/test_equations.py those of the disk with two derivations that share nothing with them.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from typing import Any, Protocol

import casadi as ca

from ..base.errors import ParameterError, shown
from .explicit import ContactGeometry, angular_velocity
from .resistance import Resistance, total_moment

STATES = ("theta", "theta_dot", "phi_dot", "omega3", "slip_x", "slip_y")
"""State names in their order; laws without slip in the state keep the first four."""


class StatedLaw(Protocol):
    """A contact law with its coefficients, in the units of the equations."""

    name: str
    holds: bool

    def force(self, slip: Sequence[Any], normal: Any) -> Any:
        """Horizontal force."""

    def power(self, slip: Sequence[Any], normal: Any) -> Any:
        """Dissipated power."""


class NewtonEuler:
    """Residuals that are linear in accelerations and contact force.

    Parameters
    ----------
    x
        The states, in the order of `STATES`.
    surface
        The body at the inclination `x[0]`.
    law
        The contact law.
    slips
        Whether the two slip velocities are states.
    slip
        The slip along x̂ and ŷ where it follows from the other states; None for none.
    mass, weight, square
        Mass, mass times gravity, and mass times length², in the units of the equations.
    against
        Resistances to rolling and turning, with their coefficients.
    """

    slip_rate: ca.SX | None = None
    """Rate of a slip that is stated and is a symbol; None where it follows from the states."""

    def __init__(
        self,
        x: ca.SX,
        surface: ContactGeometry,
        law: StatedLaw,
        slips: bool,
        slip: list[ca.SX] | None = None,
        *,
        mass: Any = 1,
        weight: Any = 1,
        square: Any = 1,
        against: Sequence[tuple[type[Resistance], Any]] = (),
    ) -> None:
        self.x, self.surface, self.law, self.slips = x, surface, law, slips
        self.mass, self.weight, self.square, self.against = mass, weight, square, against
        self.holds = holds = law.holds
        self.sine, self.cosine = surface.sine, surface.cosine
        if slips:
            self.slip = [x[4], x[5]]
        elif holds:
            self.slip = [ca.SX(0), ca.SX(0)] if slip is None else slip
        else:  # smooth, centre without horizontal velocity
            self.slip = [-x[1] * surface.height, self.rim_speed()]
        self.d_theta_dot, self.d_phi_dot, self.d_omega3 = (
            ca.SX.sym("d_" + name) for name in STATES[1:4]
        )
        self.normal = ca.SX.sym("normal")
        self.extra = [ca.SX.sym("e1"), ca.SX.sym("e2")] if slips or holds else []
        self.force = self.extra if holds else self._stated()
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

    def rim_speed(self) -> ca.SX:
        """(ω×a) along ŷ."""
        return ca.SX(self.surface.rim_speed(self.x[2], self.x[3]))

    def velocity(self) -> ca.SX:
        """ṡ = vA - ω×a along (x̂, ŷ, ẑ)."""
        theta_dot = self.x[1]
        return ca.vertcat(
            self.slip[0] + theta_dot * self.surface.height,
            self.slip[1] - self.rim_speed(),
            theta_dot * self.surface.slope,
        )

    def spin(self) -> ca.SX:
        """ω along (1̂, 2̂, 3̂)."""
        return ca.vertcat(-self.x[2] * self.sine, self.x[1], self.x[3])

    def momentum(self) -> ca.SX:
        """L along (1̂, 2̂, 3̂)."""
        across, along = self.surface.transverse, self.surface.axial
        return ca.SX(ca.vertcat(across, across, along) * self.spin())

    def moment(self, normal: Any) -> list[Any]:
        """Moment of all resistances along (x̂, ŷ, ẑ)."""
        return total_moment(self.against, angular_velocity(self.x), normal)

    def torque(self, fx: Any, fy: Any) -> ca.SX:
        """Torque along (1̂, 2̂, 3̂), where x̂ = cosθ 1̂ + sinθ 3̂, ẑ = -sinθ 1̂ + cosθ 3̂."""
        h, slope, _, outward, along, *_ = self.surface
        sliding = ca.vertcat(along * fy, -(h * fx + slope * self.normal), outward * fy)
        if not self.against:
            return ca.SX(sliding)
        level, side, up = self.moment(self.normal)
        resisting = ca.vertcat(
            self.cosine * level - self.sine * up, side, self.sine * level + self.cosine * up
        )
        return ca.SX(sliding + resisting)

    def _stated(self) -> list[Any]:
        """The force that the law states, which must be two expressions."""
        force = self.law.force(self.slip, self.normal)
        if isinstance(force, (list, tuple)) and len(force) == 2:
            with suppress(NotImplementedError, TypeError):  # CasADi's errors for another type
                return [ca.SX(f) for f in force]
        raise ParameterError(
            f"the force of the {self.law.name} law is {shown(force)}; give a list of two "
            "expressions."
        )

    def rate(self, expression: ca.SX) -> ca.SX:
        """d/dt along the motion by the chain rule, with the accelerations as symbols."""
        rates = [self.x[1], self.d_theta_dot, self.d_phi_dot, self.d_omega3]
        if self.slips:
            rates += self.extra
        slope = ca.jtimes(expression, self.x, ca.vertcat(*rates))
        if self.slip_rate is not None:
            slope += ca.jtimes(expression, ca.vertcat(*self.slip), self.slip_rate)
        return slope

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
        """Energy, forces, slip, D over m·length², the dissipated power, the rim's speed, and h'."""
        velocity, momentum = self.velocity(), self.momentum()
        kinetic = (self.mass * ca.sumsqr(velocity) + ca.dot(self.spin(), momentum)) / 2
        normal = solved["normal"]
        if self.holds:
            force = [solved["force_x"], solved["force_y"]]
            power = -(force[0] * self.slip[0] + force[1] * self.slip[1])
        else:
            force = self.law.force(self.slip, normal)
            power = self.law.power(self.slip, normal)
        if self.against:
            moment = self.moment(normal)
            power -= ca.dot(ca.vertcat(*moment), ca.vertcat(*angular_velocity(self.x)))
        return {
            "energy": kinetic + self.weight * self.surface.height,
            "normal_force": normal,
            "contact_force": ca.SX(ca.vertcat(*force)),
            "slip": ca.SX(ca.vertcat(*self.slip)),
            "determinant": pivots[self.pivot_d] / self.square,
            "power": ca.SX(power),
            "rim_speed": ca.SX(self.rim_speed()),
            "lever": ca.SX(self.surface.slope),
        }
