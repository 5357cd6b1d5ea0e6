"""Motions of a convex body in inertial axes: quaternions, and the contact watched, not imposed.

Unknowns: centre (3), quaternion of the attitude (4), velocity (3), angular velocity (3), and the
energy taken by contact force and moments.  Nothing is singular where the axis is vertical, given a
surface that is regular there.  Doubles go through SciPy's DOP853; mpmath numbers through Gragg's
extrapolated midpoint rule (Hairer, Norsett & Wanner, Solving ODEs I, II.9).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from convex_body import ConvexBody, Law, Pose, posed, respond
from jets import UP, Array, cross, norm, sqrt, vector
from scipy.integrate import solve_ivp


@dataclass(frozen=True)
class Motion:
    """A motion at sample times; all vectors in inertial axes."""

    times: Array
    """(n,)"""
    centre: Array
    """Position of the centre of mass, (n, 3)."""
    axis: Array
    """Unit vector of the symmetry axis, (n, 3)."""
    spin: Array
    """Angular velocity, (n, 3)."""
    slip: Array
    """Velocity of the material point in contact, (n, 3)."""
    normal_force: Array
    """(n,)"""
    energy: Array
    """Kinetic and potential energy, (n,)."""
    lost: Array
    """Energy taken by contact force and moments since the start, (n,)."""
    gap: Array
    """Height of the lowest point: zero but for errors of integration, (n,)."""
    jellett: Array
    """Minus angular momentum times arm, (n,)."""


def rotation(q: Array) -> Array:
    """Rotation matrix of a quaternion of any length (scalar part first)."""
    w, x, y, z = q / norm(q)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def quaternion(matrix: Array) -> Array:
    """A unit quaternion of a rotation matrix, by its largest entry."""
    m, trace = matrix, matrix[0, 0] + matrix[1, 1] + matrix[2, 2]
    pairs = [(m[2, 1], m[1, 2]), (m[0, 2], m[2, 0]), (m[1, 0], m[0, 1])]
    squares = [1 + trace, *(1 + 2 * m[i, i] - trace for i in range(3))]
    best = max(range(4), key=lambda i: squares[i])
    root = sqrt(squares[best])
    if best == 0:
        rest = [(a - b) / root for a, b in pairs]
        return vector(root, *rest) / 2
    i = best - 1
    rest = [(m[i, j] + m[j, i]) / root if j != i else root for j in range(3)]
    return vector((pairs[i][0] - pairs[i][1]) / root, *rest) / 2


def pose_of(body: ConvexBody, values: Array) -> Pose:
    """The pose of the unknowns of a motion."""
    return posed(body, values[:3], rotation(values[3:7]), values[7:10], values[10:13])


def unknowns(pose: Pose) -> Array:
    """The unknowns of a motion that starts at a pose."""
    zero = 0 * pose.spin[:1]
    parts = [pose.centre, quaternion(pose.attitude), pose.velocity, pose.spin, zero]
    return np.concatenate(parts)


def derivative(body: ConvexBody, law: Law) -> Callable[[Array], Array]:
    """Rates of the unknowns of a motion."""

    def rates(values: Array) -> Array:
        pose = pose_of(body, values)
        response = respond(pose, law)
        scalar, part = values[3], values[4:7]
        turn = [-(pose.spin @ part), *(pose.spin * scalar + cross(pose.spin, part))]
        moving = [pose.velocity, vector(*turn) / 2, response.acceleration, response.spin_rate]
        return np.concatenate([*moving, [response.power]])

    return rates


def move(body: ConvexBody, law: Law, start: Pose, times: Any, tolerance: float = 1e-13) -> Motion:
    """The motion in doubles; leg by leg, so that no sample is interpolated.

    times: increasing from 0, the time of the start.
    """
    rates = derivative(body, law)
    values, path = unknowns(start), [unknowns(start)]

    def sliding(_: float, y: Array) -> float:
        return float(norm(pose_of(body, y).slip[:2])) - 1e-4

    sliding.terminal = True  # type: ignore[attr-defined]
    events = sliding if law.name == "coulomb" else None
    for begin, end in zip(times[:-1], times[1:], strict=True):
        leg = solve_ivp(
            lambda _, y: rates(y),
            (begin, end),
            values,
            "DOP853",
            rtol=tolerance,
            atol=tolerance,
            events=events,
        )
        if leg.status:
            raise ArithmeticError(leg.message if leg.status < 0 else "the contact begins to stick")
        values = leg.y[:, -1]
        path.append(values)
    return observed(body, law, np.asarray(times, dtype=float), path)


def observed(body: ConvexBody, law: Law, times: Array, path: list[Array]) -> Motion:
    """What is seen of a motion, from its unknowns."""
    poses = [pose_of(body, values) for values in path]
    return Motion(
        times=times,
        centre=np.array([p.centre for p in poses]),
        axis=np.array([p.axis for p in poses]),
        spin=np.array([p.spin for p in poses]),
        slip=np.array([p.slip for p in poses]),
        normal_force=np.array([respond(p, law).force[2] for p in poses]),
        energy=np.array([p.energy for p in poses]),
        lost=np.array([values[13] for values in path]),
        gap=np.array([p.centre[2] + p.arm[2] for p in poses]),
        jellett=np.array([p.jellett for p in poses]),
    )


def standing(body: ConvexBody, spin: Any, slip: Any = (0, 0), axis: Any = (0, 0, 1)) -> Pose:
    """A pose above the origin by its axis, angular velocity and slip, all in inertial axes.

    The axis may be vertical; it need not have length one.
    """
    third = vector(*axis)
    third = third / norm(third)
    across = vector(0, 1, 0) if abs(third[1]) < abs(third[0]) else vector(1, 0, 0)
    first = cross(across + 0 * third, third)
    first = first / norm(first)
    attitude = np.column_stack([first, cross(third, first), third])
    turning = vector(*spin) + 0 * third
    still = posed(body, 0 * third, attitude, 0 * third, turning)
    velocity = vector(*slip, 0 * third[0]) - cross(turning, still.arm)
    return replace(still, centre=UP * -still.arm[2], velocity=velocity)


def extrapolated(
    rates: Callable[[Array], Array], values: Array, time: Any, steps: int, order: int = 9
) -> tuple[Array, Any]:
    """The unknowns after a time, in the numbers given, and the sum of the steps' error estimates.

    Each of the equal steps has `order` rows of midpoint rules, extrapolated in the square of the
    substep: order 2 `order`.
    """
    doubt, step = 0 * values[0], time / steps
    for _ in range(steps):
        first, last = rates(values), []
        for row in range(1, order + 1):
            parts = 2 * row
            h = step / parts
            before, now = values, values + first * h
            for _ in range(parts - 1):
                before, now = now, before + rates(now) * (2 * h)
            table = [(before + now + rates(now) * h) / 2]
            for j, coarse in enumerate(last):
                ratio = (parts * parts * 1) - 4 * (row - 1 - j) ** 2
                gain = (table[j] - coarse) * 4 * (row - 1 - j) ** 2 / ratio
                table.append(table[j] + gain)
            last = table
        doubt += norm(last[-1] - last[-2])
        values = last[-1]
    return values, doubt
