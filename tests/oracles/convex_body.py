"""A convex body of revolution on a plane, in inertial axes, apart from the package.

Newton's and Euler's laws for centre position, attitude (a rotation matrix), velocity and angular
velocity; the contact point is the lowest point of the rotated body, found from its geometry by
`body_surfaces`.  Nine linear equations give the acceleration of the centre, the angular
acceleration and the force at the contact.  All numbers may be doubles or mpmath's.

`rates` converts to the disk's coordinates and back: (theta, theta_dot, phi_dot, omega3, slip_x,
slip_y), where theta is the angle between the axis n and the vertical Z, the horizontal y = Z x n /
sin theta, x = y x Z, the angular velocity w = phi_dot Z + theta_dot y + (omega3 - phi_dot cos
theta) n, and the slip is the velocity of the material point in contact along x and y.

Contact laws, with v the slip and N the normal force: smooth F = 0; viscous F = -mu N v;
linear-viscous F = -c v; coulomb F = -mu N v/|v| (sliding only); rough v = 0.
Source of the laws: P. Painleve, Lecons sur le frottement (1895), and M. Przybylska and
S. Rauch-Wojciechowski, Regul. Chaotic Dyn. 21 (2016) 204.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import mpmath as mp
import numpy as np
from body_surfaces import Surface
from jets import (
    EYE,
    UP,
    Array,
    atan2,
    cos,
    cross,
    crossing,
    norm,
    precise,
    sin,
    solve,
    sqrt,
    vector,
)

LAWS = ("smooth", "viscous", "linear-viscous", "coulomb", "rough")


@dataclass(frozen=True)
class ConvexBody:
    """A rigid body of revolution; its surface is in axes with the centre of mass as origin."""

    name: str
    parameters: Mapping[str, float]
    """What the constructor was given."""
    surface: Surface
    axial: Any
    """Moment of inertia about the axis."""
    transverse: Any
    """Moment of inertia across it, for the centre of mass."""
    mass: Any = 1
    gravity: Any = 1


@dataclass(frozen=True)
class Pose:
    """A body in motion: everything in inertial axes, the plane at height zero."""

    body: ConvexBody
    centre: Array
    attitude: Array
    """Rotation matrix from body axes to inertial axes."""
    velocity: Array
    spin: Array
    """Angular velocity."""
    arm: Array
    """From the centre to the contact point."""
    arm_rate: Array
    """Its time derivative: the contact point moves on the body too."""

    @property
    def axis(self) -> Array:
        """Unit vector of the symmetry axis."""
        return self.attitude[:, 2]

    @property
    def slip(self) -> Array:
        """Velocity of the material point in contact."""
        return self.velocity + cross(self.spin, self.arm)

    @property
    def inertia(self) -> Array:
        """Tensor of inertia."""
        body = self.body
        return EYE * body.transverse + np.outer(self.axis, self.axis) * (
            body.axial - body.transverse
        )

    @property
    def momentum(self) -> Array:
        """Angular momentum about the centre."""
        return self.inertia @ self.spin

    @property
    def energy(self) -> Any:
        """Kinetic and potential energy."""
        kinetic = self.body.mass * (self.velocity @ self.velocity) + self.spin @ self.momentum
        return kinetic / 2 + self.body.mass * self.body.gravity * self.centre[2]

    @property
    def jellett(self) -> Any:
        """Minus angular momentum times arm: constant for spherical surfaces (J. H. Jellett)."""
        return -(self.momentum @ self.arm)


Moment = Callable[[Pose], tuple[Array, Array]]
"""A moment M0 + N M1 at a pose, with N the normal force."""


@dataclass(frozen=True)
class Law:
    """A contact law, and moments that act in addition to the contact force."""

    name: str
    coefficient: Any = 0
    moments: tuple[Moment, ...] = field(default=())

    def drag(self, slip: Array) -> tuple[Array, Array]:
        """Force at the contact without and per normal force, against the slip (horizontal)."""
        none = 0 * slip
        if self.name == "viscous":
            return none, slip * self.coefficient
        if self.name == "linear-viscous":
            return slip * self.coefficient, none
        if self.name == "coulomb":
            return none, slip * self.coefficient / norm(slip)
        return none, none


@dataclass(frozen=True)
class Response:
    """Accelerations and forces at a pose."""

    acceleration: Array
    """Of the centre."""
    spin_rate: Array
    """Angular acceleration."""
    force: Array
    """At the contact; its last entry is the normal force N."""
    slip_rate: Array
    """Time derivative of the slip."""
    power: Any
    """Power that contact force and moments take from the body."""
    compliance: Any
    """m times the vertical acceleration of the contact for each unit of N.

    It is one plus terms of the arm and friction; at zero or below is Painleve's paradox.
    For the thin disk k times it is D = k + cos^2 theta - mu slip_x sin theta cos theta.
    """


def posed(body: ConvexBody, centre: Array, attitude: Array, velocity: Array, spin: Array) -> Pose:
    """The contact point, and its motion, added to the motion of a body."""
    up = attitude.T @ (UP + 0 * spin)
    point, slopes = body.surface.contact(up)
    up_rate = -cross(attitude.T @ spin, up)
    arm = attitude @ point
    arm_rate = cross(spin, arm) + attitude @ (slopes @ up_rate)
    return Pose(body, centre, attitude, velocity, spin, arm, arm_rate)


def respond(pose: Pose, law: Law) -> Response:
    """Solve Newton's and Euler's laws with the contact kept, and the contact law.

    Unknowns: acceleration of the centre, angular acceleration, force at the contact.  The height
    of the lowest point stays zero; differentiated twice, the velocity of the material point in
    contact has vertical rate zero, since the lowest point moves horizontally on the body.
    """
    body, arm = pose.body, pose.arm
    zero = np.zeros((3, 3), dtype=arm.dtype)
    one = EYE + zero
    fixed = np.array([m(pose) for m in law.moments]).reshape(-1, 2, 3).sum(0) + zero[:2]
    push = crossing(arm)
    push[:, 2] += fixed[1]
    swing = cross(pose.spin, pose.arm_rate)
    newton = np.hstack([one * body.mass, zero, -one])
    euler = np.hstack([zero, pose.inertia, -push])
    contact = np.hstack([one, -crossing(arm), zero])
    right = np.concatenate(
        [
            -body.mass * body.gravity * UP + 0 * arm,
            fixed[0] - cross(pose.spin, pose.momentum),
            -swing,
        ]
    )
    if law.name != "rough":
        always, per_normal = law.drag(pose.slip[:2])
        contact[:2] = 0
        contact[0, 6], contact[1, 7] = one[0, 0], one[0, 0]
        contact[:2, 8] = per_normal
        right[6:8] = -always
    solved = solve(np.vstack([newton, euler, contact]), right)
    force, spin_rate = solved[6:], solved[3:6]
    moment = fixed[0] + fixed[1] * force[2]
    return Response(
        acceleration=solved[:3],
        spin_rate=spin_rate,
        force=force,
        slip_rate=solved[:3] + cross(spin_rate, arm) + swing,
        power=-(force @ pose.slip) - moment @ pose.spin,
        compliance=_compliance(pose, law, push),
    )


def _compliance(pose: Pose, law: Law, push: Array) -> Any:
    """Vertical acceleration of the material contact point for each unit of N, times m."""
    unit = UP + 0 * pose.arm
    if law.name != "rough":
        unit[:2] = -law.drag(pose.slip[:2])[1]
    turned = solve(pose.inertia, push @ unit)
    return 1 + pose.body.mass * cross(turned, pose.arm)[2]


# ------------------------------------------------------------------ coordinates of the disk


def pose_at(body: ConvexBody, state: Array, azimuth: Any = 0, turn: Any = 0) -> Pose:
    """The pose of a state in the disk's coordinates, above the origin of the plane.

    azimuth: direction of the horizontal part of the axis; turn: angle of the body about its axis.
    """
    theta, theta_dot, phi_dot, omega3, slip_x, slip_y = state
    x = vector(cos(azimuth), sin(azimuth), 0 * theta)
    y = vector(-sin(azimuth), cos(azimuth), 0 * theta)
    axis = x * sin(theta) + UP * cos(theta)
    side = x * cos(theta) - UP * sin(theta)
    spin = side * -phi_dot * sin(theta) + y * theta_dot + axis * omega3
    first = side * cos(turn) + y * sin(turn)
    attitude = np.column_stack([first, cross(axis, first), axis])
    still = posed(body, 0 * axis, attitude, 0 * axis, spin)
    velocity = x * slip_x + y * slip_y - cross(spin, still.arm)
    return replace(still, centre=UP * -still.arm[2], velocity=velocity)


def state_of(pose: Pose) -> Array:
    """The disk's coordinates of a pose with a tilted axis."""
    x, y, axis, tilt = _frame(pose)
    phi_dot = -(pose.spin @ cross(y, axis)) / tilt
    return vector(
        atan2(tilt, axis[2]), pose.spin @ y, phi_dot, pose.spin @ axis, pose.slip @ x, pose.slip @ y
    )


def _frame(pose: Pose) -> tuple[Array, Array, Array, Any]:
    """x, y, axis and sin theta."""
    axis = pose.axis
    tilt = norm(axis[:2])
    y = cross(UP, axis) / tilt
    return cross(y, UP), y, axis, tilt


def rates_of(pose: Pose, response: Response) -> Array:
    """Rates of the disk's coordinates, from the accelerations in inertial axes.

    The frame (side, y, axis) turns with W = -phi_dot sin theta side + theta_dot y + phi_dot cos
    theta axis, the frame (x, y, Z) with phi_dot Z.
    """
    x, y, axis, tilt = _frame(pose)
    theta_dot, phi_dot = state_of(pose)[1:3]
    frame = UP * phi_dot + y * theta_dot
    seen = response.spin_rate - cross(frame, pose.spin)
    slip = response.slip_rate - cross(UP * phi_dot + 0 * axis, pose.slip)
    side = -(seen @ cross(y, axis))
    return vector(
        theta_dot,
        seen @ y,
        (side - phi_dot * theta_dot * axis[2]) / tilt,
        seen @ axis,
        slip @ x,
        slip @ y,
    )


def rates(body: ConvexBody, law: Law, state: Any, azimuth: Any = 0, turn: Any = 0) -> Array:
    """Rates of (theta, theta_dot, phi_dot, omega3, slip_x, slip_y); units as given.

    Numbers of mpmath in the state give mpmath's numbers, with its precision.
    """
    pose = pose_at(body, np.asarray(state), azimuth, turn)
    return rates_of(pose, respond(pose, law))


def response_at(body: ConvexBody, law: Law, state: Any) -> Response:
    """Forces and accelerations at a state in the disk's coordinates."""
    return respond(pose_at(body, np.asarray(state)), law)


# ------------------------------------------------------------------ linearisation


def axis_pose(body: ConvexBody, values: Array, side: int = 1) -> Pose:
    """The pose of (n_x, n_y, w_x, w_y, w_z, slip_X, slip_Y), in inertial axes, regular at a pole.

    side: sign of n_z.
    """
    lean = values[:2]
    axis = vector(*lean, side * sqrt(1 - lean @ lean))
    first = cross(vector(0, 1, 0) + 0 * axis, axis)
    first = first / norm(first)
    attitude = np.column_stack([first, cross(axis, first), axis])
    spin = values[2:5]
    still = posed(body, 0 * axis, attitude, 0 * axis, spin)
    velocity = vector(*values[5:7], 0 * lean[0]) - cross(spin, still.arm)
    return replace(still, centre=UP * -still.arm[2], velocity=velocity)


def axis_rates(body: ConvexBody, law: Law, values: Any, side: int = 1) -> Array:
    """Rates of (n_x, n_y, w_x, w_y, w_z, slip_X, slip_Y), in inertial axes, regular at a pole."""
    pose = axis_pose(body, np.asarray(values), side)
    response = respond(pose, law)
    turning = cross(pose.spin, pose.axis)
    return np.concatenate([turning[:2], response.spin_rate, response.slip_rate[:2]])


def jacobian(function: Callable[[Array], Array], at: Any, digits: int = 60) -> Array:
    """Derivatives of a function of mpmath numbers, by central differences; good to digits / 2.

    The step 10^(-digits / 3) leaves errors of its square, and rounding of 10^(-2 digits / 3).
    """
    with mp.workdps(digits):
        x, step = precise(at), mp.mpf(10) ** (-digits // 3)
        columns = []
        for i in range(len(x)):
            move = np.array([step if j == i else 0 * step for j in range(len(x))], dtype=object)
            columns.append((function(x + move) - function(x - move)) / (2 * step))
        return np.array(columns).T


def spectrum(matrix: Array, digits: int = 40) -> Array:
    """Eigenvalues as complex doubles, sorted by real and imaginary part."""
    with mp.workdps(digits):
        values = mp.eig(mp.matrix(matrix.tolist()), left=False, right=False)
    return np.sort_complex(np.array([complex(v) for v in values]))
