"""The thin disk derived twice, apart from the package: by Kane's method and in fixed axes.

Everything is dimensionless (m = R = g = 1, I1 = k, I3 = 2k).  A state is (theta, theta_dot,
phi_dot, omega3, slip_x, slip_y).  Contact laws: "viscous" F = -mu N v, "linear-viscous" F = -mu v,
"smooth" F = 0, "rough" v = 0, with v the velocity of the disk's material contact point.

`kane_system` uses SymPy's `KanesMethod` with body components of the angular velocity and inertial
components of the centre's velocity as generalised speeds; the contact forces are unknowns, brought
in by auxiliary speeds.  `fixed_axes` writes Newton's and Euler's laws in inertial components, where
the disk is known by its symmetry axis n alone: its rate is w x n, its lowest point follows from n.
Neither divides by cos theta.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
import sympy as sp
import sympy.physics.mechanics as me
from numpy.typing import ArrayLike, NDArray
from scipy.integrate import solve_ivp

LAWS = ("smooth", "viscous", "linear-viscous", "rough")

Array = NDArray[Any]


@dataclass(frozen=True)
class Solution:
    """What an oracle finds at states of shape (..., 6)."""

    rates: Array
    """Rates of the six states, (..., 6)."""
    normal_force: Array
    """N, (...)."""
    contact_force: Array
    """Components along x^ and y^, (..., 2)."""
    energy: Array
    """Kinetic and potential energy, (...)."""
    power: Array
    """Power lost in the contact, -F . v, (...)."""


# --------------------------------------------------------------------------- Kane's method


@dataclass(frozen=True)
class KaneSystem:
    """Kane's equations of one law, as functions over any numbers with + - * and /.

    Every function takes the point (sin theta, cos theta, sin phi, cos phi, theta_dot, phi_dot,
    omega3, slip_x, slip_y, k, mu) and then what its line names.  The unknowns of the equations are
    the five u_dot and N, F_x, F_y (force components along z^, x^, y^).
    """

    matrix: Callable[..., list[list[Any]]]
    """8 x 8 matrix of the equations."""
    forcing: Callable[..., list[Any]]
    """Their right-hand side."""
    rates: Callable[..., list[Any]]
    """Then u_dot: the six state rates by the chain rule."""
    unknown: Callable[..., list[Any]]
    """Then the six state rates: u_dot."""
    energy: Callable[..., Any]
    """`RigidBody.kinetic_energy` plus the height of the centre."""


@lru_cache
def kane_system(law: str) -> KaneSystem:
    """Derive the equations of one law with SymPy's KanesMethod.

    Coordinates: phi, theta, psi (yaw, tilt of the axis, spin) and X, Y of the centre, whose height
    is sin theta.  Speeds: u1, u2, u3 = components of the full angular velocity along the contact
    radius 1^, the horizontal 2^ and the axis 3^; u4, u5 = X_dot, Y_dot.  Auxiliary speeds lift the
    disk and, for the rough law, shift it along x^ and y^, so that the contact forces appear.  The
    rough law goes through KanesMethod's own velocity constraints, with u4 and u5 dependent (their
    coefficients form the unit matrix).
    """
    rough = law == "rough"
    k, mu = sp.symbols("k mu")
    q = phi, theta, psi, x, y = me.dynamicsymbols("phi theta psi X Y")
    u = u1, u2, u3, u4, u5 = me.dynamicsymbols("u1:6")
    extra = extra_x, extra_y, extra_z = me.dynamicsymbols("a_x a_y a_z")
    normal, force_x, force_y = forces = sp.symbols("N F_x F_y")
    time = me.dynamicsymbols._t

    fixed = me.ReferenceFrame("N")
    yaw = fixed.orientnew("Y", "Axis", [phi, fixed.z])
    lean = yaw.orientnew("L", "Axis", [theta, yaw.y])
    disk = lean.orientnew("R", "Axis", [psi, lean.z])
    spin = u1 * lean.x + u2 * lean.y + u3 * lean.z
    true_spin = disk.ang_vel_in(fixed)
    kinematic = [(spin - true_spin).dot(axis) for axis in (lean.x, lean.y, lean.z)]
    kinematic += [u4 - x.diff(time), u5 - y.diff(time)]
    disk.set_ang_vel(fixed, spin)
    q_dot = {
        phi.diff(time): -u1 / sp.sin(theta),
        theta.diff(time): u2,
        psi.diff(time): u3 + u1 * sp.cos(theta) / sp.sin(theta),
        x.diff(time): u4,
        y.diff(time): u5,
    }
    if any(sp.simplify(e.subs(q_dot)) != 0 for e in kinematic):
        message = "the kinematic equations are not solved by the written rates"
        raise AssertionError(message)

    centre = me.Point("C")
    velocity = u4 * fixed.x + u5 * fixed.y + sp.cos(theta) * u2 * fixed.z
    shift = extra_x * yaw.x + extra_y * yaw.y if rough else 0
    centre.set_vel(fixed, velocity + extra_z * fixed.z + shift)
    contact = centre.locatenew("A", lean.x)
    contact.v2pt_theory(centre, fixed, disk)
    slip = velocity + spin.cross(lean.x)
    slips = [slip.dot(yaw.x), slip.dot(yaw.y)]
    body = me.RigidBody("B", centre, disk, 1, (me.inertia(lean, k, k, 2 * k), centre))
    push = force_x * yaw.x + force_y * yaw.y + normal * fixed.z
    if rough:
        constraints = [slip.dot(fixed.x), slip.dot(fixed.y)]
        method = me.KanesMethod(
            fixed,
            q,
            [u1, u2, u3],
            u_dependent=[u4, u5],
            kd_eqs=kinematic,
            velocity_constraints=constraints,
            u_auxiliary=list(extra),
        )
        law_rows = [c.diff(time) for c in constraints]
    else:
        method = me.KanesMethod(fixed, q, u, kd_eqs=kinematic, u_auxiliary=[extra_z])
        drag = {"smooth": 0, "viscous": mu * normal, "linear-viscous": mu}[law]
        law_rows = [force_x + drag * slips[0], force_y + drag * slips[1]]
    active, inertial = method.kanes_equations([body], [(centre, -fixed.z), (contact, push)])

    # plain symbols instead of functions of time; the auxiliary speeds are zero
    u_dot, v, r = sp.symbols("w1:6"), sp.symbols("v1:6"), sp.symbols("r1:7")
    point = sp.symbols("s c s_phi c_phi theta_dot phi_dot omega3 slip_x slip_y k mu")
    s, c, sin_phi, cos_phi, theta_dot, phi_dot, omega3, slip_x, slip_y, *_ = point
    first: dict[Any, Any] = {a.diff(time): b for a, b in zip(u, u_dot, strict=True)}
    first |= dict.fromkeys((a.diff(time) for a in extra), sp.Integer(0))
    last: dict[Any, Any] = dict(zip(u, v, strict=True)) | dict.fromkeys(extra, sp.Integer(0))
    last |= {sp.sin(theta): s, sp.cos(theta): c, sp.sin(phi): sin_phi, sp.cos(phi): cos_phi}

    def bare(expression: Any) -> Any:
        return sp.sympify(expression).xreplace(first).xreplace(q_dot).xreplace(last)

    # speeds of the state: u4, u5 from the slip, linear with a rotation by phi as matrix
    planar = sp.Matrix([bare(e) for e in slips])
    turn = planar.jacobian(v[3:])
    rest = planar.subs(dict.fromkeys(v[3:], 0))
    across = turn.T * (sp.Matrix([slip_x, slip_y]) - rest)
    speeds = {v[0]: -phi_dot * s, v[1]: theta_dot, v[2]: omega3}
    speeds |= {v[3]: across[0].subs(speeds), v[4]: across[1].subs(speeds)}

    rows = sp.Matrix([bare(e) for e in [*active, *law_rows]])
    rows[: len(active), :] += sp.Matrix([bare(e) for e in inertial])
    unknowns = [*u_dot, *forces]
    matrix, forcing = rows.jacobian(unknowns), -rows.subs(dict.fromkeys(unknowns, 0))
    derived = [u2, -u1 / sp.sin(theta), u3, *slips]
    chain = sp.Matrix([bare(e.diff(time)) for e in derived])
    gain, bias = chain.jacobian(u_dot), chain.subs(dict.fromkeys(u_dot, 0))
    back = sp.solve(list(gain * sp.Matrix(u_dot) + bias - sp.Matrix(r[1:])), u_dot)

    def compiled(expressions: Any, more: Sequence[sp.Symbol] = ()) -> Callable[..., Any]:
        if isinstance(expressions, sp.MatrixBase):
            expressions = expressions.xreplace(speeds).tolist()
        elif isinstance(expressions, list):
            expressions = [e.xreplace(speeds) for e in expressions]
        else:
            expressions = expressions.xreplace(speeds)
        function: Callable[..., Any] = sp.lambdify([*point, *more], expressions, modules="math")
        return function

    return KaneSystem(
        matrix=compiled(matrix),
        forcing=compiled(list(forcing)),
        rates=compiled([theta_dot, *chain], u_dot),
        unknown=compiled([back[symbol] for symbol in u_dot], r),
        energy=compiled(bare(body.kinetic_energy(fixed)) + s),
    )


def kane(law: str, x: ArrayLike, p: ArrayLike, phi: ArrayLike = 0.0) -> Solution:
    """Kane's equations solved by `numpy.linalg.solve`; x (..., 6), p (..., 2) = (k, mu)."""
    xs, (k, mu) = np.moveaxis(np.asarray(x), -1, 0), np.moveaxis(np.asarray(p), -1, 0)
    system = kane_system(law)
    point = [np.sin(xs[0]), np.cos(xs[0]), np.sin(phi), np.cos(phi), *xs[1:], k, mu]
    matrix = np.stack([_stack(row, xs[0]) for row in system.matrix(*point)], axis=-2)
    solved = np.linalg.solve(matrix, _stack(system.forcing(*point), xs[0])[..., None])[..., 0]
    *u_dot, normal, force_x, force_y = np.moveaxis(solved, -1, 0)
    return Solution(
        rates=_stack(system.rates(*point, *u_dot), xs[0]),
        normal_force=normal,
        contact_force=_stack([force_x, force_y], xs[0]),
        energy=np.asarray(system.energy(*point)),
        power=-(force_x * xs[4] + force_y * xs[5]),
    )


# --------------------------------------------------------------------------- fixed axes


_UP = np.array([0.0, 0.0, 1.0])


def fixed_axes(law: str, x: ArrayLike, p: ArrayLike, phi: ArrayLike = 0.0) -> Solution:
    """Newton and Euler in inertial components; x (..., 6), p (..., 2) = (k, mu).

    Nine linear equations for the acceleration of the centre, the angular acceleration and the
    contact force: m a = F - g z, d/dt(k w + k n (n.w)) = a x F, height of the centre =
    sqrt(n_x^2 + n_y^2) twice differentiated, and two rows of the contact law.
    """
    xs, (k, mu) = np.moveaxis(np.asarray(x), -1, 0), np.moveaxis(np.asarray(p), -1, 0)
    theta, theta_dot, phi_dot, omega3, slip_x, slip_y = xs
    like = xs[0] + k + mu + phi
    n = _stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], like)
    k = (k + 0 * like)[..., None]

    # geometry: the height is |horizontal part of n|; the lowest rim point is along -z
    # projected on the plane of the disk
    height = np.sqrt(n[..., 0] ** 2 + n[..., 1] ** 2)[..., None]
    x_hat = _flat(n) / height
    y_hat = np.cross(_UP, x_hat)
    w = phi_dot[..., None] * _UP + theta_dot[..., None] * y_hat
    w = w + (omega3 - phi_dot * n[..., 2])[..., None] * n
    n_dot = np.cross(w, n)
    height_dot = _dot(_flat(n), n_dot) / height
    a = (n * n[..., 2:] - _UP) / height
    a_dot = (n_dot * n[..., 2:] + n * n_dot[..., 2:] - a * height_dot) / height
    slip = slip_x[..., None] * x_hat + slip_y[..., None] * y_hat
    velocity = _flat(slip - np.cross(w, a)) + height_dot * _UP

    # rows over the unknowns (acceleration, angular acceleration, force)
    one, zero = np.eye(3) + 0 * n[..., None], 0 * n[..., None] * np.eye(3)
    inertia = k[..., None] * (one + n[..., :, None] * n[..., None, :])
    newton = np.concatenate([one, zero, -one], axis=-1)
    euler = np.concatenate([zero, inertia, -_cross(a)], axis=-1)
    right_newton = -_UP + 0 * n
    right_euler = -k * (n_dot * _dot(n, w) + n * _dot(n_dot, w))
    # height * height_ddot + height_dot^2 = (n_h . n_dot_h)', with n_ddot = w_dot x n + w x n_dot
    lift = [height * _UP, -np.cross(n, _flat(n)), 0 * n]
    vertical = np.concatenate(lift, axis=-1)[..., None, :]
    twisted = np.cross(w, n_dot)
    right_vertical = _dot(_flat(n_dot), n_dot) + _dot(_flat(n), twisted) - height_dot**2
    if law == "rough":  # acceleration of the contact point, a following the lowest place
        contact = np.concatenate([one, -_cross(a), zero], axis=-1)[..., :2, :]
        right_contact = -np.cross(w, a_dot)[..., :2]
    else:
        fixed_drag, per_weight = {
            "smooth": (0 * mu, 0 * mu),
            "viscous": (0 * mu, mu),
            "linear-viscous": (mu, 0 * mu),
        }[law]
        pull = one + (per_weight[..., None] * slip)[..., None] * _UP
        contact = np.concatenate([zero, zero, pull], axis=-1)[..., :2, :]
        right_contact = -(fixed_drag[..., None] * slip)[..., :2]
    matrix = np.concatenate([newton, euler, vertical, contact], axis=-2)
    right = np.concatenate([right_newton, right_euler, right_vertical, right_contact], axis=-1)
    solved = np.linalg.solve(matrix, right[..., None])[..., 0]
    acceleration, w_dot, force = solved[..., :3], solved[..., 3:6], solved[..., 6:]

    # chain rule to the state: n = (sin theta cos phi, sin theta sin phi, cos theta)
    n_ddot = np.cross(w_dot, n) + twisted
    slip_dot = acceleration + np.cross(w_dot, a) + np.cross(w, a_dot)
    x_turn = (_flat(n_dot) - x_hat * height_dot) / height
    y_turn = np.cross(_UP, x_turn)
    h, h_dot = height[..., 0], height_dot[..., 0]
    turning = (n[..., 0] * n_dot[..., 1] - n[..., 1] * n_dot[..., 0]) / h**2
    rates = [
        -n_dot[..., 2] / h,
        -(n_ddot[..., 2] - h_dot * n_dot[..., 2] / h) / h,
        (n[..., 0] * n_ddot[..., 1] - n[..., 1] * n_ddot[..., 0]) / h**2 - 2 * h_dot * turning / h,
        (_dot(w_dot, n) + _dot(w, n_dot))[..., 0],
        (_dot(slip_dot, x_hat) + _dot(slip, x_turn))[..., 0],
        (_dot(slip_dot, y_hat) + _dot(slip, y_turn))[..., 0],
    ]
    momentum = k * (w + n * _dot(n, w))
    kinetic = (_dot(velocity, velocity) + _dot(w, momentum))[..., 0] / 2
    return Solution(
        rates=_stack(rates, like),
        normal_force=force[..., 2],
        contact_force=np.concatenate([_dot(force, x_hat), _dot(force, y_hat)], axis=-1),
        energy=kinetic + h,
        power=-_dot(force, slip)[..., 0],
    )


ORACLES: Mapping[str, Callable[..., Solution]] = {"kane": kane, "fixed axes": fixed_axes}


def _stack(entries: Sequence[Any], like: Array) -> Array:
    """Entries, some of them plain numbers, as the last axis of one array shaped as `like`."""
    return np.stack([entry + 0 * like for entry in entries], axis=-1)


def _dot(a: Array, b: Array) -> Array:
    """Scalar product without conjugation, the axis kept."""
    return (a * b).sum(axis=-1, keepdims=True)


def _flat(a: Array) -> Array:
    """Horizontal part."""
    return a * np.array([1.0, 1.0, 0.0])


def _cross(a: Array) -> Array:
    """Matrix of the map b -> a x b."""
    return np.cross(a[..., None, :], np.eye(3)).swapaxes(-1, -2)


def states_after(six: Any, p: Any, span: float) -> Any:
    """States of viscous disks after a time, by Newton's laws in fixed axes, shape (launches, 6)."""

    def rates(_: float, flat: Any) -> Any:
        return fixed_axes("viscous", flat.reshape(six.shape), p).rates.ravel()

    run = solve_ivp(rates, (0, span), six.ravel(), method="DOP853", rtol=1e-9, atol=1e-12)
    assert run.success
    return run.y[:, -1].reshape(six.shape)
