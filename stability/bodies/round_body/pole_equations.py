"""Equations of motion in fixed axes, regular where the symmetry axis is vertical.

The angles φ and ψ have no meaning at θ = 0 and π.  Here the states are the symmetry axis e = 3̂, the
angular velocity and the slip along fixed axes X, Y, Z (Z up).  With the height f(c), c = cos θ =
e_Z, the contact point lies at a = -f' e - (f - c f') Ẑ from the centre, which is regular at the
poles of a body that is smooth there (a tippe top turns over through one).  Units are those of
`equations`.  tests/bodies/test_pole_equations.py compares both charts.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import casadi as ca
import numpy as np

from ...algebra.program import Program
from ...base.errors import NoMemberError, ParameterError
from ...systems.equations import Condition, eliminate
from ...systems.system import System
from ..contact_laws import Contact, Creep, Rough
from ..held_motion import SLIP as STATED
from ..held_motion import SLIP_RATE, held_programs
from ..resistance import Resistance, total_moment
from .equations import Resistances, with_quantities
from .height.pole_height import NotSmoothError, height_of_cosine
from .shape import RoundShape
from .si_law import BodySymbols, Law, Shape, shape_of

AXIS = ("axis_X", "axis_Y", "axis_Z")
"""Unit vector of the symmetry axis along fixed axes."""
TURN = ("omega_X", "omega_Y", "omega_Z")
"""Angular velocity along fixed axes."""
SLIP = ("slip_X", "slip_Y")
"""Slip along fixed axes."""
STRAIN = 1e-9
"""Largest difference of the forces of a law for turned slips, over the force, for an even law."""


def pole_system(
    body: RoundShape,
    law: type[Contact],
    parameters: tuple[str, ...],
    *,
    physical: bool,
    near: int = 0,
    slip_states: bool = False,
    resistance: Resistances = (),
) -> System:
    """A body under a contact law along fixed axes, built once for each.

    Parameters
    ----------
    body, law, parameters, physical, resistance
        As for `round_system`.
    near
        1 or -1 for the chart around θ = 0 or π, whose states leave axis_Z out; 0 for the equations
        with all of the axis, for motions from anywhere to anywhere.
    slip_states
        Whether the smooth body has its slip in the state too, as a motion needs.

    Returns
    -------
    System
        States `AXIS`, `TURN`, and `SLIP` for a law with slip in the state.  Observables as in
        `round_system`, the contact force and slip along X and Y.

    Raises
    ------
    NoMemberError
        If the body is not smooth at this pole (at both, for `near` = 0).
    ParameterError
        If the law is made for the disk's angles, or its force depends on the direction of slip.
    """
    if issubclass(law, Creep):
        raise ParameterError(
            f"the {law.name} law is made for the disk's angles, which have no meaning at a pole; "
            f"for {body.name} take Viscous(mu)."
        )
    if law.sticks:
        raise ParameterError(f"the {law.name} law sticks, which has no equations at a pole yet.")
    refuse_rough_pole(body, (near,) if near else (1, -1))
    _check_even(law, len(parameters))
    slips = law.slips or (slip_states and not law.holds)
    return _system(shape_of(body), law, parameters, physical, near, resistance, slips)  # type: ignore[arg-type]  # a class is hashable


def refuse_rough_pole(body: RoundShape, poles: tuple[int, ...]) -> None:
    """Refuse a body that is smooth at none of some poles.

    Parameters
    ----------
    body
        The body.
    poles
        1 for θ = 0, -1 for θ = π.
    """
    if not any(smooth_at(body, pole) for pole in poles):
        where = " or ".join({1: "0", -1: "π"}[pole] for pole in poles)
        raise NoMemberError(
            f"{body.name} is not smooth at theta = {where}, where it falls flat or stands on "
            "a point; there is no motion through it."
        )


def smooth_at(body: RoundShape, pole: int) -> bool:
    """Whether the height is a smooth function of cos θ at a pole, within the range of the body.

    Parameters
    ----------
    body
        The body.
    pole
        1 for θ = 0, -1 for θ = π.
    """
    low, high = body.between
    if (low > 0) if pole == 1 else (high < np.pi):
        return False
    seen = _of_cosine(shape_of(body)[1], tuple(body.shape))
    if seen is None:
        return False
    columns = np.broadcast_arrays(float(pole), *body.shape.values())
    values = seen(*[np.asarray(v, dtype=float).reshape(1, -1) for v in columns]).full()
    return bool(np.isfinite(values).all())


@lru_cache(maxsize=64)
def _of_cosine(height: Any, names: tuple[str, ...]) -> ca.Function | None:
    """A height with its two slopes by cos θ, built once; None where it is no function of it."""
    c, symbols = ca.SX.sym("c"), [ca.SX.sym(n) for n in names]
    try:
        f = height_of_cosine(height, c, symbols)
    except NotSmoothError:
        return None
    slope = ca.jacobian(f, c)
    return ca.Function(
        "f", [c, *symbols], [ca.densify(ca.vertcat(f, slope, ca.jacobian(slope, c)))]
    )


def _check_even(law: type[Contact], count: int) -> None:
    """Refuse a law whose force does not turn with the slip: it needs the body's directions."""
    if law.holds or law.conservative:
        return
    form = law.__new__(law)
    mu: Any = 0.7 if count < 2 else (0.7,) * count
    slip = np.array([0.3, -0.5])
    for angle in (0.9, 2.3):
        turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        straight = turn @ np.array([float(ca.DM(f)) for f in form.force(list(slip), 1.1, mu)])
        turned = np.array([float(ca.DM(f)) for f in form.force(list(turn @ slip), 1.1, mu)])
        if np.abs(turned - straight).max() > STRAIN * (1 + np.abs(straight).max()):
            raise ParameterError(
                f"the force of the {law.name} law depends on the direction of slip in the body, "
                "which has no meaning at a pole."
            )


@lru_cache(maxsize=32)
def _system(  # noqa: PLR0913
    shape: Shape,
    law: type[Contact],
    parameters: tuple[str, ...],
    physical: bool,
    near: int,  # noqa: FBT001
    resistance: Resistances,
    slips: bool,  # noqa: FBT001
) -> System:
    name, height, *_ = shape
    numbers = BodySymbols.of(
        shape, (*parameters, *(r.coefficient for r in resistance)), physical=physical
    )
    axis = AXIS[:2] if near else AXIS
    states = (*axis, *TURN, *(SLIP if slips else ()))
    x = ca.SX.sym("x", len(states))
    flat = ca.sumsqr(x[:2])
    up = near * ca.sqrt(1 - flat) if near else x[2]
    cosine = ca.SX.sym("c")
    body = PoleBody(
        ca.vertcat(x[0], x[1], up),
        x[len(axis) : len(axis) + 3],
        x[len(axis) + 3 :],
        (cosine, height_of_cosine(height, cosine, numbers.shape_symbols)),
        Law(law, numbers.table, parameters),
        numbers.table,
    )
    body.against = [(r, numbers.table[r.coefficient]) for r in resistance]
    rhs, seen = body.solved()
    turning = ca.cross(body.turn, body.axis)
    conditions = [
        Condition(
            seen["determinant"],
            "D = {value:.3g} is not positive: no contact force holds the body on the plane there "
            "(Painlevé's paradox); take a smaller mu or slip",
        )
    ]
    if near:
        inside = "axis_X² + axis_Y² must be below 1 in this chart; 1 less that is {value:.3g}"
        conditions.append(Condition(1 - flat, inside))
    system = System(
        f"{name}, {law.name}",
        x,
        numbers.p,
        ca.vertcat(turning[: len(axis)], rhs),
        states=states,
        parameters=numbers.names,
        observables=seen,
        conditions=tuple(conditions),
    )
    return with_quantities(system, shape, law, resistance, physical=physical)


def rough_at_pole(shape: Shape, resistance: Resistances) -> System:
    """The body that does not slip along fixed axes, dimensionless."""
    return _system(shape, Rough, (), False, 0, resistance, False)


@lru_cache(maxsize=32)
def held_at_pole(shape: Shape, resistance: Resistances) -> tuple[Program, Program]:
    """A body held to a slip along fixed axes, dimensionless: see `held_programs`."""
    numbers = BodySymbols.of(shape, [r.coefficient for r in resistance], physical=False)
    x, cosine = ca.SX.sym("x", 6), ca.SX.sym("c")
    height = cosine, height_of_cosine(shape[1], cosine, numbers.shape_symbols)
    law = Law(Rough, numbers.table, ())
    body = PoleBody(x[:3], x[3:], STATED, height, law, numbers.table)
    body.against = [(r, numbers.table[r.coefficient]) for r in resistance]
    turning, force, normal, _ = body.held(SLIP_RATE)
    rates = ca.vertcat(body.moving, turning)
    return held_programs(x, numbers.p, rates, ca.vertcat(force, normal))


class PoleBody:
    """Newton's and Euler's equations along fixed axes, solved for one contact law.

    Parameters
    ----------
    axis, turn, slip
        Symmetry axis (3), angular velocity (3), slip (2; empty where it is no state).
    height
        Symbol of cos θ, and the height as a function of it.
    law
        The contact law.
    table
        Mass, gravity, length and moments.
    """

    def __init__(
        self,
        axis: ca.SX,
        turn: ca.SX,
        slip: ca.SX,
        height: tuple[ca.SX, ca.SX],
        law: Law,
        table: dict[str, Any],
    ) -> None:
        self.axis, self.turn, self.law, self.mass = axis, turn, law, law.mass
        c, f = height
        slope = ca.jacobian(f, c)
        values = ca.vertcat(f, slope, ca.jacobian(slope, c)) * table["length"]
        self.f, self.f1, self.f2 = ca.vertsplit(ca.substitute(ca.densify(values), c, axis[2]))
        square = self.mass * table["length"] * table["length"]
        self.square = square
        self.across, self.along = square * table["transverse"], square * table["axial"]
        self.z = ca.SX([0, 0, 1])
        self.point = -self.f1 * axis - (self.f - axis[2] * self.f1) * self.z
        self.moving = ca.cross(turn, axis)  # ė
        rise = self.moving[2]
        self.drift = -self.f1 * self.moving - self.f2 * rise * (axis - axis[2] * self.z)  # ȧ
        plane = -ca.cross(turn, self.point)  # ṡ where nothing slips
        self.slips = slip.numel() > 0
        if self.slips:
            self.slip = slip
        elif law.holds:
            self.slip = ca.SX.zeros(2)
        else:  # smooth: a centre without horizontal velocity
            self.slip = -plane[:2]
        self.velocity = ca.vertcat(plane[:2] + self.slip, self.f1 * rise)
        spin = ca.dot(turn, axis)
        self.momentum = self.across * turn + (self.along - self.across) * spin * axis
        self.against: list[tuple[type[Resistance], ca.SX]] = []
        self.gyro = (self.along - self.across) * spin * self.moving  # L̇ with ω̇ = 0

    def response(self, torque: ca.SX) -> ca.SX:
        """ω̇ of a torque: the inverse of the inertia."""
        along = ca.dot(torque, self.axis)
        acceleration: ca.SX = (
            torque / self.across + (1 / self.along - 1 / self.across) * along * self.axis
        )
        return acceleration

    def moment(self, normal: Any) -> ca.SX:
        """Moment of all resistances along fixed axes."""
        return ca.SX(ca.vertcat(*total_moment(self.against, ca.vertsplit(self.turn), normal)))

    def solved(self) -> tuple[ca.SX, dict[str, ca.SX]]:
        """Rates of angular velocity and slip, and the observables."""
        turning, force, normal, determinant = self.held() if self.law.holds else self._free()
        rates = [turning]
        if self.slips:
            swing = ca.cross(turning, self.point) + ca.cross(self.turn, self.drift)
            rates.append(force / self.mass + swing[:2])
        kinetic = (self.mass * ca.sumsqr(self.velocity) + ca.dot(self.turn, self.momentum)) / 2
        sides = ca.vertsplit(self.slip)
        power = -ca.dot(force, self.slip) if self.law.holds else self.law.power(sides, normal)
        power = power - ca.dot(self.moment(normal), self.turn)
        seen = {
            "energy": kinetic + self.law.weight * self.f,
            "normal_force": normal,
            "contact_force": force,
            "slip": self.slip,
            "determinant": determinant,
            "power": power,
            "jellett": -ca.dot(self.momentum, self.point),
        }
        return ca.vertcat(*rates), {n: ca.SX(v) for n, v in seen.items()}

    def _free(self) -> tuple[ca.SX, ca.SX, ca.SX, ca.SX]:
        """A force that the law states: the normal force N is the one unknown, with pivot D/I₁."""
        normal = ca.SX.sym("normal")
        stated = ca.SX(ca.vertcat(*self.law.force(ca.vertsplit(self.slip), normal)))
        part = ca.jacobian(stated, normal)
        rest = ca.substitute(stated, normal, 0)
        moment = self.moment(normal)
        pushed, still = ca.jacobian(moment, normal), ca.substitute(moment, normal, 0)
        unit_response = self.response(ca.cross(self.point, ca.vertcat(part, 1)) + pushed)
        free = self.response(ca.cross(self.point, ca.vertcat(rest, 0)) + still - self.gyro)
        rise = self.moving[2]
        lift = ca.cross(self.turn, self.moving)[2] + ca.cross(free, self.axis)[2]
        weight = self.law.weight + self.mass * (self.f1 * lift + self.f2 * rise * rise)
        pivot = 1 - self.mass * self.f1 * ca.cross(unit_response, self.axis)[2]
        value = weight / pivot
        turning = free + value * unit_response
        return turning, rest + value * part, value, pivot * self.across / self.square

    def held(self, slip_rate: Any = (0, 0)) -> tuple[ca.SX, ca.SX, ca.SX, ca.SX]:
        """A force that holds the slip: (I + m(a²1 - a aᵀ)) ω̇ is known, and positive definite.

        Parameters
        ----------
        slip_rate
            Rate of the slip along X and Y.
        """
        a, e = self.point, self.axis
        inertia = self.across * ca.SX.eye(3) + (self.along - self.across) * e @ e.T
        inertia += self.mass * (ca.sumsqr(a) * ca.SX.eye(3) - a @ a.T)
        swing = ca.cross(self.turn, self.drift) - ca.vertcat(slip_rate[0], slip_rate[1], 0)
        right = ca.cross(a, self.law.weight * self.z - self.mass * swing) - self.gyro
        if self.against:  # N = m g - m (ω̇×a + ω×ȧ)·Ẑ
            normal = ca.SX.sym("normal")
            moment = self.moment(normal)
            pushed = ca.densify(ca.jacobian(moment, normal))
            right += ca.substitute(moment, normal, self.law.weight - self.mass * swing[2])
            inertia += self.mass * pushed @ ca.horzcat(a[1], -a[0], 0)
        solution, pivots = eliminate(ca.densify(inertia), right, [(0, 0), (1, 1), (2, 2)])
        turning = ca.vertcat(*solution)
        force = self.law.weight * self.z - self.mass * (ca.cross(turning, a) + swing)
        scale = pivots[0] * pivots[1] * pivots[2] / self.square**3
        return turning, force[:2], force[2], scale
