"""The lowest point of an inclined body of revolution, from the body's geometry.

Body axes have the centre of mass as origin and the third axis as axis of symmetry.  A surface is
asked by the vertical in body axes, `up`, and gives the point with outward normal -up, with its
matrix of derivatives in `up` (for changes of `up` across itself).  No support function is used.

`Profile`: a meridian curve (r(u), z(u)) in arcs, corners allowed; the lowest point is a tangency
(Newton's method on the slope, within bisection) or a corner.  It needs a tilted axis.
`Implicit`: a smooth surface f(x^2 + y^2, z) = 0; the point and a multiplier solve f = 0,
grad f = -factor up.  It is regular at the poles too.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Protocol

import numpy as np
from jets import Array, Jet, epsilon, newton, norm, plain, solve

Curve = Callable[[Any], tuple[Any, Any]]
"""Parameter u to (r, z), for floats, mpmath numbers and jets."""


class Surface(Protocol):
    """Contact point of a body, by its geometry."""

    def contact(self, up: Array) -> tuple[Array, Array]:
        """Lowest point (3,) and its derivatives (3, 3) in `up`."""


@dataclass(frozen=True)
class Arc:
    """A smooth convex piece of a meridian, from the lower pole towards the upper one."""

    curve: Curve
    start: Any
    end: Any

    def shift(self, z: Any) -> Arc:
        """The arc in axes whose origin lies at height z."""
        curve = self.curve

        def moved(u: Any) -> tuple[Any, Any]:
            r, height = curve(u)
            return r, height - z

        return Arc(moved, self.start, self.end)

    def at(self, u: Any) -> tuple[Jet, Jet]:
        """Point with derivatives in u."""
        r, z = self.curve(Jet(u, 1))
        return _jet(r), _jet(z)


def _jet(value: Any) -> Jet:
    return value if isinstance(value, Jet) else Jet(value)


@dataclass(frozen=True)
class Profile:
    """A body by its meridian: convex arcs in order, from the lower pole to the upper one.

    An arc along the axis or a flat end may be left out: no tilted body touches there.
    """

    arcs: Sequence[Arc]

    def contact(self, up: Array) -> tuple[Array, Array]:
        """Lowest point and its derivatives; the axis must be tilted."""
        flat, c = up[:2], up[2]
        s = norm(flat)
        r, z, r_theta, z_theta = self.lowest(s, c)
        away = -flat / s
        # theta = atan2(s, c): its slope in `up`, then that of the horizontal direction
        theta_slope = np.array([c * flat[0] / s, c * flat[1] / s, -s])
        turn = np.array([-away[1], away[0]])
        point = np.array([r * away[0], r * away[1], z])
        slopes = np.outer([r_theta * away[0], r_theta * away[1], z_theta], theta_slope)
        slopes[:2, :2] += -np.outer(turn, turn) * (r / s)
        return point, slopes

    def lowest(self, s: Any, c: Any) -> tuple[Any, Any, Any, Any]:
        """(r, z) of the lowest point where the tilt has sine s and cosine c, and slopes in tilt."""
        found = [_lowest(arc, s, c) for arc in self.arcs]
        return min(found, key=lambda p: -p[0] * s + p[1] * c)


def _lowest(arc: Arc, s: Any, c: Any) -> tuple[Any, Any, Any, Any]:
    """Lowest point of one arc; its height z c - r s has at most one minimum there."""
    zero = 0 * s
    ends = arc.start + zero, arc.end + zero
    for end, sign in zip(ends, (1, -1), strict=True):
        value, _, r, z = _slope(arc, end, s, c)
        if sign * value >= 0:
            return r.v, z.v, zero, zero
    if isinstance(zero, float):
        u = _tangency(arc, ends, s, c)
    else:  # from the root in doubles, where there is one
        doubles = tuple(map(float, ends))
        inside = all(
            sign * _slope(arc, end, float(s), float(c))[0] < 0
            for end, sign in zip(doubles, (1, -1), strict=True)
        )
        start = _tangency(arc, doubles, float(s), float(c)) + zero if inside else None
        u = _tangency(arc, ends, s, c, start)
    value, bend, _, _ = _slope(arc, u, s, c)
    _, bend, r, z = _slope(arc, u - value / bend, s, c)
    u_theta = (r.x * c + z.x * s) / bend
    return r.v, z.v, r.x * u_theta, z.x * u_theta


def _slope(arc: Arc, u: Any, s: Any, c: Any) -> tuple[Any, Any, Jet, Jet]:
    """Two derivatives of the height z c - r s in u, and the point."""
    r, z = arc.at(u)
    return z.x * c - r.x * s, z.xx * c - r.xx * s, r, z


def _tangency(arc: Arc, ends: tuple[Any, Any], s: Any, c: Any, start: Any = None) -> Any:
    """Where the slope of the height vanishes, by Newton's method within bisection."""
    (low, high), u = ends, start
    for _ in range(9 if start is None else 0):
        # not the middle: a symmetric curve may be less smooth there
        u = low + (high - low) * 7 / 16
        low, high = (u, high) if _slope(arc, u, s, c)[0] < 0 else (low, u)
    near = math.sqrt(epsilon(np.array([0 * s]))) * float(high - low)
    for _ in range(300):
        value, bend, _, _ = _slope(arc, u, s, c)
        low, high = (u, high) if value < 0 else (low, u)
        new = u - value / bend if bend > 0 else low
        new = new if low <= new <= high else (low + high) / 2
        close, u = abs(new - u) <= near, new
        if close:
            return u
    raise ArithmeticError("no tangency is found on the arc")


@dataclass(frozen=True)
class Implicit:
    """A smooth surface f(x^2 + y^2, z) = 0, negative inside, with points of it to start from."""

    function: Callable[[Any, Any], Any]
    arcs: Sequence[Arc]

    @cached_property
    def points(self) -> Array:
        """Points (r, z) of the meridian, forty on each arc."""
        grid = np.linspace(0, 1, 40)
        ends = [(arc.curve, float(arc.start), float(arc.end)) for arc in self.arcs]
        return plain([curve(a + (b - a) * t) for curve, a, b in ends for t in grid])

    def derivatives(self, point: Array) -> tuple[Any, Array, Array]:
        """Value, gradient and Hessian at a point."""
        x, y, z = point
        f = self.function(Jet(x * x + y * y, 1), Jet(z, 0, 1))
        gradient = np.array([2 * x * f.x, 2 * y * f.x, f.y])
        hessian = np.array(
            [
                [2 * f.x + 4 * x * x * f.xx, 4 * x * y * f.xx, 2 * x * f.xy],
                [4 * x * y * f.xx, 2 * f.x + 4 * y * y * f.xx, 2 * y * f.xy],
                [2 * x * f.xy, 2 * y * f.xy, f.yy],
            ]
        )
        return f.v, gradient, hessian

    def contact(self, up: Array) -> tuple[Array, Array]:
        """Lowest point and its derivatives, at any inclination."""

        def residual(unknown: Array) -> tuple[Array, Array]:
            value, gradient, hessian = self.derivatives(unknown[:3])
            left = np.append(gradient + up * unknown[3], value)
            return left, self._bordered(gradient, hessian, up)

        if up.dtype == object:
            near, factor = self._solved(plain(up))
            start = np.append(near, factor) + 0 * up[0]
        else:
            start = self._start(up)
        unknown = newton(residual, start)
        _, gradient, hessian = self.derivatives(unknown[:3])
        right = np.zeros((4, 3), dtype=up.dtype)
        right[:3] = np.eye(3, dtype=int) * -unknown[3]
        return unknown[:3], solve(self._bordered(gradient, hessian, up), right)[:3]

    def _solved(self, up: Array) -> tuple[Array, float]:
        point, _ = self.contact(up)
        return point, float(norm(self.derivatives(point)[1]))

    def _start(self, up: Array) -> Array:
        s = math.hypot(up[0], up[1])
        r, z = self.points[np.argmin(self.points[:, 1] * up[2] - self.points[:, 0] * s)]
        away = -up[:2] / s if s > 0 else np.array([1.0, 0.0])
        point = np.array([r * away[0], r * away[1], z])
        return np.append(point, norm(self.derivatives(point)[1]))

    @staticmethod
    def _bordered(gradient: Array, hessian: Array, up: Array) -> Array:
        matrix = np.zeros((4, 4), dtype=up.dtype)
        matrix[:3, :3], matrix[:3, 3], matrix[3, :3] = hessian, up, gradient
        return matrix
