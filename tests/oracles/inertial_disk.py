"""A thin disk along fixed axes under smoothed dry friction and resistances; m = R = g = 1.

The normal force follows from the height of the centre.  Friction is -mu N v/sqrt(v² + eps²), which
tends to Coulomb's as eps does to 0.
"""

import math
from collections.abc import Callable
from typing import Any

from scipy.integrate import solve_ivp


def _cross(a: Any, b: Any) -> tuple[float, float, float]:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def rates(k: float, mu: float, rho: float, sigma: float, eps: float) -> Callable[..., Any]:
    """Rates of the axis n, the angular velocity w and the horizontal velocity of the centre.

    Inertia is k (1 + n nᵀ); angular momentum k w + k (w·n) n has the rate of the torque.
    """

    def turned(torque: Any, n: Any) -> Any:
        half = sum(t * a for t, a in zip(torque, n, strict=True)) / 2
        return [(t - half * a) / k for t, a in zip(torque, n, strict=True)]

    def of(_: float, y: Any) -> Any:
        n, w, nz, s = y[:3], y[3:6], y[2], math.hypot(y[0], y[1])
        moved = _cross(w, n)
        arm = nz * n[0] / s, nz * n[1] / s, -s
        about = _cross(w, arm)
        slip = y[6] + about[0], y[7] + about[1]
        size = math.sqrt(slip[0] ** 2 + slip[1] ** 2 + eps**2)
        push = -mu * slip[0] / size, -mu * slip[1] / size, 1.0
        torque = _cross(arm, push)
        torque = torque[0] - rho * w[0], torque[1] - rho * w[1], torque[2] - sigma * w[2]
        spin = k * sum(a * b for a, b in zip(w, n, strict=True))
        free, forced = turned([-spin * m for m in moved], n), turned(torque, n)
        lift = _cross(free, n)[2] + _cross(w, moved)[2]
        bare = -(moved[2] ** 2 + nz * lift + (nz * moved[2] / s) ** 2) / s
        normal = (1 + bare) / (1 + nz * _cross(forced, n)[2] / s)
        turn = [a + normal * b for a, b in zip(free, forced, strict=True)]
        return [*moved, *turn, normal * push[0], normal * push[1]]

    return of


def fall_time(six: Any, flat: float, last: float, *law: float) -> float:
    """Time at which the disk of `rates(*law)` lies within an angle of flat."""
    theta, theta_dot, phi_dot, omega3, slip_x, slip_y = six
    s, c = math.sin(theta), math.cos(theta)
    turn = omega3 - phi_dot * c
    w = turn * s, theta_dot, phi_dot + turn * c
    about = _cross(w, (c, 0.0, -s))

    def flat_now(_: float, y: Any) -> float:
        return math.hypot(y[0], y[1]) - math.sin(flat)

    flat_now.terminal = True  # type: ignore[attr-defined]
    start = [s, 0.0, c, *w, slip_x - about[0], slip_y - about[1]]
    run = solve_ivp(rates(*law), (0, last), start, "LSODA", events=flat_now, rtol=1e-9, atol=1e-12)
    return float(run.t_events[0][0])
