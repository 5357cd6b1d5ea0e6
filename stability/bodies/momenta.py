"""The disk's motion in momenta: the equations of `newton_euler.py` in fewer operations.

The states are θ, θ̇, φ̇ sinθ, ω₃ and the velocity of the centre along x̂ and ŷ.  A series of a
product costs as much as many sums, and these states need 18 products where the slip needs 40.
With s = sinθ, c = cosθ, P = φ̇ s, φ̇ = P/s, e = P (φ̇c - 2ω₃), and the law's force f + N h, where f
and h do not depend on the normal force N,

    L̇ = a × force along 1̂, 2̂, 3̂:  Ṗ = -θ̇ (φ̇c - 2ω₃),  k θ̈ = k e - N c - Fₓ s,  2k ω̇₃ = F_y,
    m s̈ = -mgẑ + force:             Ẋ = φ̇ Y + Fₓ,  Ẏ = -φ̇ X + F_y,  N = 1 + θ̈ c - θ̇² s,

so that N (k + c² + s c hₓ) = k (1 - θ̇² s + c e) - s c fₓ.
Source: tests/bodies/test_disk_momenta.py finds the same rates in the graph of Newton and Euler.
"""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np

from ..base.types import Floats
from .contact_laws import Contact
from .model import WORK, Chart, Model

NAMES = ("theta", "theta_dot", "momentum", "omega3", "velocity_x", "velocity_y")
"""Names of the states: the momentum is φ̇ sinθ, the velocity that of the centre."""


def momenta_model(law: type[Contact], whole: Model) -> Model:
    """The disk in momenta under a law whose slip is a state.

    Parameters
    ----------
    law
        Class of a law that states its force.
    whole
        The model of the disk under this law in its six states.

    Returns
    -------
    Model

    Examples
    --------
    >>> from stability.bodies.contact_laws import Viscous
    >>> from stability.bodies.thin_disk import disk_model
    >>> momenta_model(Viscous, disk_model("viscous")).names
    ('theta', 'theta_dot', 'momentum', 'omega3', 'velocity_x', 'velocity_y', 'work')
    """
    z, work = ca.SX.sym("z", len(NAMES)), ca.SX.sym(WORK)
    k, flat = whole.p[0], whole.p[-1]
    theta, turning, momentum, omega3, vx, vy = ca.vertsplit(z)
    s, c = ca.sin(theta), ca.cos(theta)
    rising = turning * s
    slip = [vx - rising, vy + omega3]
    mu = ca.vertsplit(whole.p[1:-1])
    stated, numbers = law.__new__(law), mu[0] if len(mu) == 1 else tuple(mu)
    bare, share = _parts(stated, slip, numbers)
    phi_dot = momentum / s
    excess = phi_dot * c - 2 * omega3
    gyroscopic = momentum * excess
    lever = c + share[0] * s
    determinant = k + c * lever
    pressing = k * (1 - turning * rising + c * gyroscopic) - c * (bare[0] * s)
    normal = pressing / determinant
    fx, fy = (b + normal * h for b, h in zip(bare, share, strict=True))
    rates = ca.vertcat(
        turning,
        gyroscopic - (normal * lever + bare[0] * s) / k,
        -turning * excess,
        (fy / k) / 2,
        phi_dot * vy + fx,
        fy - phi_dot * vx,
        stated.power(slip, normal, numbers),
    )
    guards = dict(zip(whole.guards, (pressing, s - flat, determinant), strict=False))
    return Model(
        whole.system,
        whole.states,
        ca.vertcat(z, work),
        whole.p,
        rates,
        (*NAMES, WORK),
        guards,
        whole.words,
        quantities=whole.quantities,
        friction=whole.friction,
        turning=(1, 3),
        sound=whole.sound,
        chart=Chart(pack, report, _along),
        title=whole.title,
        source=whole.source,
    )


def _parts(law: Contact, slip: list[ca.SX], numbers: Any) -> tuple[Any, Any]:
    """The parts f and h of the law's force f + N h, which is linear in the normal force."""
    normal = ca.SX.sym("normal")
    force = ca.vertcat(*law.force(slip, normal, numbers))
    share = ca.jacobian(force, normal)
    bare = ca.substitute(force, normal, ca.SX(0))
    return ca.vertsplit(bare), ca.vertsplit(share)


def pack(states: Floats) -> Floats:
    """The six states in momenta; no work is done.

    Parameters
    ----------
    states
        States in the order of `STATES`, shape (…, 6).

    Examples
    --------
    >>> pack(np.array([np.pi / 2, 0.1, 2.0, 0.5, 0.0, 0.25])).tolist()
    [1.5707963267948966, 0.1, 2.0, 0.5, 0.1, -0.25, 0.0]
    """
    theta, turning, phi_dot, omega3, slip_x, slip_y = np.moveaxis(states, -1, 0)
    s = np.sin(theta)
    momenta = [theta, turning, phi_dot * s, omega3, slip_x + turning * s, slip_y - omega3]
    return np.stack([*momenta, np.zeros_like(theta)], axis=-1)


def report(z: Floats) -> Floats:
    """The six states of a motion from those in momenta, the inverse of `pack`.

    Parameters
    ----------
    z
        States in momenta, and possibly the work, shape (…, 6) or (…, 7).
    """
    theta, turning, momentum, omega3, vx, vy = np.moveaxis(z[..., :6], -1, 0)
    s = np.sin(theta)
    return np.stack([theta, turning, momentum / s, omega3, vx - turning * s, vy + omega3], axis=-1)


def _along(_z: Floats, series: dict[str, Floats]) -> dict[str, Floats]:
    return series
