"""Systems with ignorable, redundant or mirrored structure whose thresholds are known."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import casadi as ca

import stability as st


def system(
    name: str, states: Sequence[str], parameters: Sequence[str], rates: Callable[..., Any]
) -> st.System:
    """A system from a function of the states and of each parameter."""
    x, p = ca.SX.sym("x", len(states)), [ca.SX.sym(n) for n in parameters]
    symbols = ca.vertcat(*p) if p else ca.SX(0, 1)
    rhs = ca.vertcat(*rates(x, *p))
    return st.System(name, x, symbols, rhs, states=tuple(states), parameters=tuple(parameters))


# --- the sleeping Lagrange top: neutral for I3² W² > 4 I1 m g l, unstable below -----------------


def top_pair() -> st.Family:
    """Linear, on two coordinates: I1 a'' + I3 W b' - mgl a = 0, and the same for b."""

    def rates(x: Any, spin: Any, i1: Any, i3: Any, mgl: Any) -> tuple[Any, ...]:
        return (
            x[2],
            x[3],
            (mgl * x[0] - i3 * spin * x[3]) / i1,
            (mgl * x[1] + i3 * spin * x[2]) / i1,
        )

    top = system("top", "ablm", ("W", "I1", "I3", "mgl"), rates)
    return st.Family(top, "sleeping", at=("W",), held=dict.fromkeys("ablm", 0.0))


def _torque(axis: Any, mgl: Any) -> Any:
    return ca.cross(axis, ca.vertcat(0, 0, -mgl))


def top_in_space() -> st.Family:
    """Axis and angular momentum in space: two Casimirs, |axis|² and axis · momentum = I3 W."""

    def rates(x: Any, i1: Any, mgl: Any) -> list[Any]:
        axis, momentum = x[:3], x[3:]
        turn = ca.cross(momentum / i1, axis)
        return [*ca.vertsplit(turn), *ca.vertsplit(_torque(axis, mgl))]

    top = system("top", "abclmn", ("I1", "mgl"), rates)
    return st.Family(top, "sleeping", at=("n",), held={"a": 0, "b": 0, "c": 1, "l": 0, "m": 0})


def top_with_constraint() -> st.Family:
    """Axis and its velocity, held to |axis| = 1 by the length that the axis has at the start."""

    def rates(x: Any, spin: Any, i1: Any, mgl: Any) -> list[Any]:
        axis, velocity = x[:3], x[3:]
        across = (_torque(axis, mgl) - spin * velocity) / i1  # axis × axis''
        turn = -ca.cross(axis, across) - ca.sumsqr(velocity) * axis
        return [*ca.vertsplit(velocity), *ca.vertsplit(turn)]

    top = system("top", "abcuvw", ("H", "I1", "mgl"), rates)
    held = {"a": 0, "b": 0, "c": 1, "u": 0, "v": 0, "w": 0}
    return st.Family(top, "sleeping", at=("H",), held=held)


def top_in_a_chart() -> st.Family:
    """Two entries of the axis, the third as a root, and the momentum across."""

    def rates(x: Any, up: Any, i1: Any, mgl: Any) -> list[Any]:
        a, b, across, along = ca.vertsplit(x)
        axis = ca.vertcat(a, b, ca.sqrt(1 - a**2 - b**2))
        turn = ca.cross(ca.vertcat(across, along, up) / i1, axis)
        return [turn[0], turn[1], *ca.vertsplit(_torque(axis, mgl))[:2]]

    top = system("top", "ablm", ("H", "I1", "mgl"), rates)
    return st.Family(top, "sleeping", at=("H",), held=dict.fromkeys("ablm", 0.0))


# --- mirrored spectra ---------------------------------------------------------------------------


def saddle() -> st.Family:
    """Rotating saddle with curvatures ±k: neutral for W² > k."""

    def rates(x: Any, w: Any, k: Any) -> tuple[Any, ...]:
        return (x[2], x[3], 2 * w * x[3] + (w**2 - k) * x[0], -2 * w * x[2] + (w**2 + k) * x[1])

    turning = system("saddle", "xyuv", ("W", "k"), rates)
    return st.Family(turning, "rest", at=("W",), held=dict.fromkeys("xyuv", 0.0))


def triangular_point() -> st.Family:
    """Restricted three-body problem at L4, x and y solved for (y = √3/2 is irrational)."""

    def rates(s: Any, m: Any) -> tuple[Any, ...]:
        x, y, u, v = ca.vertsplit(s)
        one, two = ca.sqrt((x + m) ** 2 + y**2), ca.sqrt((x - 1 + m) ** 2 + y**2)
        pull = (1 - m) / one**3, m / two**3
        return (
            u,
            v,
            2 * v + x - pull[0] * (x + m) - pull[1] * (x - 1 + m),
            -2 * u + y - (pull[0] + pull[1]) * y,
        )

    problem = system("three bodies", "xyuv", ("m",), rates)
    return st.Family(
        problem,
        "L4",
        at=("m",),
        held={"u": 0, "v": 0},
        unknown={"x": 0.45, "y": 0.87},
        equations=("u", "v"),
        typical={"m": 0.02},
    )


def column() -> st.Family:
    """Ziegler's column (Kirillov & Verhulst): without damping flutter at P = 7/2 - √2."""

    def rates(x: Any, p: Any, damping: Any) -> tuple[Any, ...]:
        f = -((2 - p) * x[0] + (p - 1) * x[1]) - damping * (2 * x[2] - x[3])
        g = -(-x[0] + x[1]) - damping * (-x[2] + x[3])
        return x[2], x[3], (f - g) / 2, (3 * g - f) / 2

    held = dict.fromkeys("abcd", 0.0)
    return st.Family(system("column", "abcd", ("P", "damping"), rates), "straight", ("P",), held)


def body() -> st.System:
    """Euler's free body: rotation about the axis of the middle moment is unstable."""
    return system(
        "body",
        ("u", "v", "w"),
        ("A", "B", "C"),
        lambda w, a, b, c: (
            (b - c) / a * w[1] * w[2],
            (c - a) / b * w[2] * w[0],
            (a - b) / c * w[0] * w[1],
        ),
    )


# --- systems with heading and place -------------------------------------------------------------

STRAIGHT = {"q2": 0.0, "u1": 0.0, "u3": 0.0}


def rolling_disc(*, place: bool) -> st.System:
    """SymPy's rolling disc (test_kane.py): heading q1, lean q2, wheel angle q3; and its place."""

    def rates(x: Any, r: Any, g: Any) -> list[Any]:
        q1, q2, _, u1, u2, u3, *_ = ca.vertsplit(x)
        spin = u2 - u3 * ca.tan(q2)
        fall = (6 * u2 * u3 * r - u3**2 * r * ca.tan(q2) + 4 * g * ca.sin(q2)) / (5 * r)
        out = [u3 / ca.cos(q2), u1, spin, fall, -2 * u1 * u3 / 3, u1 * (-2 * u2 + u3 * ca.tan(q2))]
        return out + [-r * spin * ca.cos(q1), -r * spin * ca.sin(q1)] * int(place)

    names = ("q1", "q2", "q3", "u1", "u2", "u3", *(("px", "py") if place else ()))
    return system("disc", names, ("r", "g"), rates)


def sleigh() -> st.System:
    """Chaplygin's sleigh with heading and place."""

    def rates(x: Any, m: Any, a: Any, inertia: Any) -> tuple[Any, ...]:
        v, w, heading, _, _ = ca.vertsplit(x)
        return (
            a * w**2,
            -m * a * v * w / (inertia + m * a * a),
            w,
            v * ca.cos(heading),
            v * ca.sin(heading),
        )

    return system("sleigh", ("v", "w", "heading", "px", "py"), ("m", "a", "I"), rates)
