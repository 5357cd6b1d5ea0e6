"""A thin ring that rolls without slip, by hand: Euler's equations about the point of contact.

Units m = g = R = 1; k is the moment of inertia across the axis, 2k that along it.  The resisting
moments are -rho N w along the plane and -drag w, with N = 1 - sin(theta) theta_dot² +
cos(theta) theta_ddot.  No code of the package is used.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp


@dataclass(frozen=True)
class Ring:
    """Inertia and resistances."""

    k: float
    rho: float = 0.0
    drag: float = 0.0

    def spin(self, theta: float, precession: float) -> float:
        """omega3 of steady circling: where theta has no acceleration."""
        s, c, k = math.sin(theta), math.cos(theta), self.k
        return (k * precession * c - c / (precession * s)) / (2 * k + 1)

    def turn(self, y: Any) -> tuple[float, float, float]:
        """Angular velocity along two horizontal axes and the vertical."""
        s, c = math.sin(y[0]), math.cos(y[0])
        own = y[3] - y[2] * c
        return own * s, y[1], y[2] + own * c

    def energy(self, theta: float, precession: float) -> float:
        """Energy of steady circling."""
        spin, s = self.spin(theta, precession), math.sin(theta)
        return s + (self.k * (precession * s) ** 2 + (2 * self.k + 1) * spin**2) / 2

    def lost(self, theta: float, precession: float) -> float:
        """Power lost in steady circling."""
        x, y, z = self.turn((theta, 0.0, precession, self.spin(theta, precession)))
        return self.rho * (x * x + y * y) + self.drag * (x * x + y * y + z * z)

    def rates(self, y: Any) -> list[float]:
        """Rates of theta, theta_dot, phi_dot, omega3, phi, and the centre's x and y."""
        theta, falling, precession, spin, phi = y[:5]
        k, s, c = self.k, math.sin(theta), math.cos(theta)
        x, _, z = self.turn(y)
        # theta_ddot stands in the normal force, and the normal force in its equation
        free = k * precession**2 * s * c - (2 * k + 1) * precession * s * spin - c
        free += -self.rho * falling * (1 - s * falling**2) - self.drag * falling
        up = free / (k + 1 + self.rho * falling * c)
        normal = 1 - s * falling**2 + c * up
        level, upright = -(self.rho * normal + self.drag) * x, -self.drag * z
        first, third = c * level - s * upright, s * level + c * upright
        gain = (2 * k * spin * falling - 2 * k * precession * c * falling - first) / (k * s)
        along, side = s * falling, -spin
        return [
            falling,
            up,
            gain,
            (precession * s * falling + third) / (2 * k + 1),
            precession,
            along * math.cos(phi) - side * math.sin(phi),
            along * math.sin(phi) + side * math.cos(phi),
        ]

    def nutation(self, theta: float, precession: float) -> float:
        """Frequency of small nutation about steady circling, from the three equations by hand."""
        k, s, c = self.k, math.sin(theta), math.cos(theta)
        spin, turning = self.spin(theta, precession), precession
        by_theta = k * turning**2 * (c * c - s * s) - (2 * k + 1) * turning * c * spin + s
        by_turning = 2 * k * turning * s * c - (2 * k + 1) * s * spin
        square = by_theta + by_turning * 2 * (spin - turning * c) / s - (turning * s) ** 2
        return math.sqrt(-square / (k + 1))

    def drift(self, theta: float, precession: float) -> tuple[float, float]:
        """Slow rates of theta and phi_dot: the moments move the ring from member to member."""
        k, s, c = self.k, math.sin(theta), math.cos(theta)
        spin = self.spin(theta, precession)
        x, _, z = self.turn((theta, 0.0, precession, spin))
        level, upright = -(self.rho + self.drag) * x, -self.drag * z
        first, third = c * level - s * upright, s * level + c * upright
        # spin(theta, phi_dot) must stay that of a member: one linear equation for theta's rate
        by_theta = (-k * precession * s + 1 / (precession * s * s)) / (2 * k + 1)
        by_turning = (k * c + c / (precession**2 * s)) / (2 * k + 1)
        gain, push = 2 * (spin - precession * c) / s, -first / (k * s)
        rate = (third / (2 * k + 1) - by_turning * push) / (
            by_theta + by_turning * gain - precession * s / (2 * k + 1)
        )
        return rate, gain * rate + push

    def mean_path(
        self, theta: float, precession: float, kick: float, end: float
    ) -> tuple[np.ndarray, np.ndarray]:
        """Middle inclination of each nutation, and turn of the centre's shift to the next.

        The ring starts in circling with a kick to theta_dot, and is followed down to `end`.
        """

        def low(_: float, y: Any) -> float:
            return float(y[0] - end)

        def highest(_: float, y: Any) -> float:
            return float(y[1])

        def lowest(_: float, y: Any) -> float:
            return float(y[1])

        low.terminal, highest.direction, lowest.direction = True, -1, 1  # type: ignore[attr-defined]
        start = [theta, kick, precession, self.spin(theta, precession), 0.0, 0.0, 0.0]
        path = solve_ivp(
            lambda _, y: self.rates(y),
            (0, 10 / (self.rho + self.drag)),
            start,
            "DOP853",
            events=[low, highest, lowest],
            rtol=1e-8,
            atol=1e-10,
        )
        assert path.status == 1
        highs, lows = path.y_events[1], path.y_events[2]
        lows = lows[path.t_events[2] > path.t_events[1][0]]
        count = min(len(highs) - 1, len(lows))
        shift = np.diff(highs[:, 5] + 1j * highs[:, 6])[:count]
        middle = (highs[:count, 0] + highs[1 : count + 1, 0]) / 4 + lows[:count, 0] / 2
        return middle[:-1], np.angle(shift[1:] / shift[:-1])
