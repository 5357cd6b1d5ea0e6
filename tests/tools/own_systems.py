"""Systems as a user would bring them: pendulum, spinning top, Chaplygin sleigh."""

from collections.abc import Sequence
from typing import Any

import casadi as ca

import stability as st


def symbols(*names: str) -> list[ca.SX]:
    return [ca.SX.sym(n) for n in names]


def system_of(
    name: str,
    states: Sequence[ca.SX],
    parameters: Sequence[ca.SX],
    rates: Sequence[Any] | ca.SX,
    **more: Any,
) -> st.System:
    """A system with the names of its symbols."""
    words = {"states": states, "parameters": parameters}
    return st.System(
        name,
        ca.vertcat(*states),
        ca.vertcat(*parameters),
        rates if isinstance(rates, ca.SX) else ca.vertcat(*rates),
        **{word: tuple(s.name() for s in symbols) for word, symbols in words.items()},
        **more,
    )


def pendulum(*, observed: bool = True) -> st.System:
    x, p = ca.SX.sym("x", 2), ca.SX.sym("p", 2)
    seen = {"energy": x[1] ** 2 / 2 - p[0] * ca.cos(x[0]), "power": p[1] * x[1] ** 2}
    units = {"angle": "rad", "rate": "rad/s", "g": "1/s2", "c": "1/s"}
    return st.System(
        "pendulum",
        x,
        p,
        ca.vertcat(x[1], -p[0] * ca.sin(x[0]) - p[1] * x[1]),
        states=("angle", "rate"),
        parameters=("g", "c"),
        observables=seen if observed else {},
        units=units | ({"energy": "J/kg"} if observed else {}),
    )


def hanging(system: st.System) -> st.Family:
    return st.Family(system, "hanging", at=("c",), held={"angle": 0, "rate": 0})


def top() -> st.System:
    """Euler's equations of a symmetric top with weight, on the axis' two Cartesian entries.

    State: direction of the axis (a, b, c), angular velocity (across: u, v, w in space).  The spin
    about the axis is constant: a parameter.  I₁ = 1, m g l = 1.
    """
    x, p = ca.SX.sym("x", 6), ca.SX.sym("p")  # p: angular momentum about the axis
    axis, momentum = x[:3], x[3:]
    omega = momentum + 0 * axis  # I₁ = 1 across the axis; along it ω does not move the axis
    down = ca.SX([0, 0, -1])
    return st.System(
        "top",
        x,
        p,
        ca.vertcat(ca.cross(omega, axis), ca.cross(axis, down)),
        states=("a", "b", "c", "l", "m", "n"),
        parameters=("spin",),
        observables={
            "energy": ca.sumsqr(momentum - ca.dot(momentum, axis) * axis) / 2 + x[2],
            "power": ca.SX(0),
            "momentum_up": x[5],
            "along": ca.dot(momentum, axis),
            "size": ca.sumsqr(axis),
        },
    )


def sleigh() -> st.System:
    """Chaplygin sleigh: v' = a w², (I + m a²) w' = -m a v w, with heading and place."""
    x, p = ca.SX.sym("x", 2), ca.SX.sym("p", 3)
    v, w = x[0], x[1]
    m, a, inertia = p[0], p[1], p[2]
    whole = inertia + m * a**2
    return st.System(
        "sleigh",
        x,
        p,
        ca.vertcat(a * w**2, -m * a * v * w / whole),
        states=("v", "w"),
        parameters=("m", "a", "I"),
        observables={"energy": (m * v**2 + whole * w**2) / 2, "power": ca.SX(0)},
    )


SLEIGH = {"m": 1.0, "a": 0.3, "I": 0.2}
BLADE = 0.2 + 0.09
