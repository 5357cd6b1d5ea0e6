"""Newton's and Euler's equations of a body of revolution, solved by hand for the accelerations.

An elimination (`newton_euler.py`) serves every contact law, and leaves a graph that is half as long
again; a launch evaluates it some thousand times.  With s = sinθ, c = cosθ, P = φ̇ s, the height
h(θ), the arms r = h s + h' c and z = h c - h' s, and the moment M of resistances along (x̂, ŷ, ẑ),
where mass, gravity and length are 1,

    I₁ Ṗ = θ̇ (I₃ ω₃ - I₁ φ̇ c) - z F_y - (c M_x - s M_z),   I₃ ω̇₃ = r F_y + s M_x + c M_z,
    I₁ θ̈ = P (I₁ φ̇ c - I₃ ω₃) - h F_x - h' N + M_y,         N = 1 + h' θ̈ + h'' θ̇².

Force and moment are linear in the normal force N.  The slip is the velocity of the centre plus
(-θ̇ h, φ̇ h' + (ω₃ - φ̇ c) r).
Source: tests/bodies/test_explicit.py finds the same rates in the graph of Newton and Euler.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import casadi as ca


class ContactGeometry(NamedTuple):
    """What the equations need of a body at an inclination."""

    height: Any
    """h."""
    slope: Any
    """h'."""
    curve: Any
    """h''."""
    outward: Any
    """r = h sinθ + h' cosθ, the distance of the contact point from the axis."""
    along: Any
    """z = h cosθ - h' sinθ, its distance from the centre along the axis."""
    sine: ca.SX
    """sin θ."""
    cosine: ca.SX
    """cos θ; one node for all that holds it, so that a graph becomes short."""
    transverse: Any
    """I₁."""
    axial: Any
    """I₃."""

    def rim_speed(self, phi_dot: Any, omega3: Any) -> Any:
        """Speed of the contact point about the centre, along ŷ."""
        return (omega3 - phi_dot * self.cosine) * self.outward + phi_dot * self.slope


def surface(
    theta: ca.SX, height: ca.SX, transverse: Any, axial: Any, unit: Any = 1
) -> ContactGeometry:
    """A body at a symbol θ; a disk without thickness, h = sinθ, has r = 1 and z = 0 exactly.

    Parameters
    ----------
    theta
        Symbol of the inclination.
    height
        The height at θ, over `unit`.
    transverse, axial
        Moments of inertia.
    unit
        Unit of length.

    Examples
    --------
    >>> t = ca.SX.sym("t")
    >>> surface(t, ca.sin(t), 0.25, 0.5)[3:5]
    (1, 0)
    """
    s, c = ca.sin(theta), ca.cos(theta)
    if ca.is_equal(height, s, 1):
        return ContactGeometry(unit * s, unit * c, -unit * s, unit, 0, s, c, transverse, axial)
    slope = ca.jacobian(height, theta)
    arms = height * s + slope * c, height * c - slope * s
    h, first, second, r, z = (unit * v for v in (height, slope, ca.jacobian(slope, theta), *arms))
    return ContactGeometry(h, first, second, r, z, s, c, transverse, axial)


class Explicit(NamedTuple):
    """The equations of motion, solved."""

    rates: ca.SX
    """Rates of the six states."""
    normal: ca.SX
    """Normal force N."""
    pressing: ca.SX
    """N D."""
    determinant: ca.SX
    """D: positive where a contact force holds the body on the plane."""


def angular_velocity(x: ca.SX) -> list[ca.SX]:
    """The angular velocity along (x̂, ŷ, ẑ)."""
    s, c = ca.sin(x[0]), ca.cos(x[0])
    relative = x[3] - x[2] * c
    return [relative * s, x[1], x[2] + relative * c]


def explicit(
    x: ca.SX,
    surface: ContactGeometry,
    force: Callable[[Sequence[Any], Any], Sequence[Any]],
    moment: Callable[[Sequence[Any], Any], Sequence[Any]] | None = None,
) -> Explicit:
    """The rates of a body under a law that states its force.

    Parameters
    ----------
    x
        The six states.
    surface
        The body at the inclination of x.
    force
        (slip, N) → the force along x̂ and ŷ.
    moment
        (angular velocity along x̂, ŷ and ẑ, N) → moment of the resistances along them.

    Returns
    -------
    Explicit
    """
    theta, turning, phi_dot, omega3, slip_x, slip_y = ca.vertsplit(x)
    h, slope, curve, r, z, s, c, across, axial = surface
    ratio = axial / across
    upward = phi_dot * c
    excess = upward - ratio * omega3
    gyroscopic = phi_dot * s * excess
    symbol = ca.SX.sym("normal")
    resisting = moment(angular_velocity(x), symbol) if moment else (0, 0, 0)
    acting = [*force([slip_x, slip_y], symbol), *resisting]
    column = ca.vertcat(*acting)
    share = ca.vertsplit(ca.densify(ca.jacobian(column, symbol)))
    bare = ca.vertsplit(ca.densify(ca.substitute(column, symbol, ca.SX(0))))
    lever = slope + h * share[0] - share[3]
    determinant = across + slope * lever
    pressing = across * (1 + curve * turning**2 + slope * gyroscopic)
    pressing -= slope * (h * bare[0] - bare[3])
    normal = pressing / determinant
    fx, fy, mx, my, mz = (b + normal * g for b, g in zip(bare, share, strict=True))
    tilting = gyroscopic + (my - h * fx - slope * normal) / across
    swinging = -turning * excess - (z * fy + c * mx - s * mz) / across
    spinning = (r * fy + s * mx + c * mz) / across / ratio
    precessing = (swinging - upward * turning) / s
    rim, relative = surface.rim_speed(phi_dot, omega3), omega3 - upward
    rim_rate = precessing * slope + phi_dot * curve * turning + relative * (h + curve) * c * turning
    rim_rate += (spinning - precessing * c + phi_dot * s * turning) * r
    rates = ca.vertcat(
        turning,
        tilting,
        precessing,
        spinning,
        phi_dot * (slip_y - rim) + fx - tilting * h - turning**2 * slope,
        fy + rim_rate - phi_dot * (slip_x + turning * h),
    )
    return Explicit(rates, normal, pressing, determinant)
