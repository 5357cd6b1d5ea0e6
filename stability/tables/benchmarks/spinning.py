"""Motions that spin: a gyropendulum, Routh's sphere, a body in a liquid, a square of vortices."""

from __future__ import annotations

from typing import Any

import casadi as ca

from ...systems.family import Family
from ...systems.system import System
from .row import CLOSED, BenchmarkRow, Source, at_threshold, threshold

GYROPENDULUM = Source("gyropendulum", "S. H. Crandall, Z. angew. Math. Phys. 46 (1995) S761")
SPHERE = Source(
    "Routh's sphere", "E. J. Routh, Dynamics of a System of Rigid Bodies, Advanced Part"
)
BODY = Source("body in a liquid", "H. Lamb, Hydrodynamics, ch. VI (Kirchhoff's equations)")
VORTICES = Source("vortices about a vortex", "Cabral & Schmidt, SIAM J. Math. Anal. 31 (2000) 231")


def gyropendulum() -> list[BenchmarkRow]:
    """Row of the spinning inverted pendulum, held up by damping that turns with it.

    Returns
    -------
    list of BenchmarkRow
    """
    names = ("spin", "fixed", "turning", "gyro", "fall")
    x, y, u, v = (ca.SX.sym(n) for n in "xyuv")
    spin, fixed, turning, gyro, fall = (ca.SX.sym(n) for n in names)
    damping, follow = fixed + turning, turning * spin
    system = System(
        "gyropendulum",
        ca.vertcat(x, y, u, v),
        ca.vertcat(spin, fixed, turning, gyro, fall),
        ca.vertcat(
            u,
            v,
            -damping * u - gyro * spin * v + fall * x - follow * y,
            -damping * v + gyro * spin * u + fall * y + follow * x,
        ),
        states=("x", "y", "u", "v"),
        parameters=names,
    )
    upright = Family(system, "upright", at=("spin",), held=dict.fromkeys(system.states, 0.0))
    found = threshold(upright, 0.1, 10.0, fixed=0.125, turning=0.375, gyro=1.5, fall=2.0)
    return [
        at_threshold(
            GYROPENDULUM,
            found,
            "1.8856180831641267",
            origin=CLOSED,
            quantity="rate above which damping that turns holds it",
        )
    ]


def rolling_sphere() -> Family:
    """A sphere that rolls and spins about the vertical, its centre of mass above its centre.

    Angular momentum about the point of contact; arm from the centre of mass to that point.
    """
    turn, up = ca.SX.sym("w", 3), ca.SX.sym("up", 3)
    p = {n: ca.SX.sym(n) for n in ("I1", "I3", "R", "a", "g", "m")}
    axis, inertia = ca.SX([0, 0, 1]), ca.diag(ca.vertcat(p["I1"], p["I1"], p["I3"]))
    d_up = ca.cross(up, turn)
    arm, d_arm = -(p["R"] * up + p["a"] * axis), -p["R"] * d_up

    def momentum(w: Any) -> Any:
        return inertia @ w + p["m"] * ca.cross(arm, ca.cross(w, arm))

    balance = (
        ca.cross(momentum(turn), turn)
        - p["m"] * ca.cross(arm, ca.cross(turn, d_arm))
        + p["m"] * p["g"] * ca.cross(arm, up)
    )
    states = [f"{word}_{i}" for word in ("w", "up") for i in range(3)]
    system = System.from_mass_matrix(
        "Routh's sphere",
        ca.vertcat(turn, up),
        ca.vertcat(*p.values()),
        mass=ca.jacobian(momentum(turn), turn),
        forcing=balance,
        unknowns=[f"d_w_{i}" for i in range(3)],
        rates={f"up_{i}": d_up[i] for i in range(3)},
        states=states,
        parameters=tuple(p),
    )
    held = dict.fromkeys(("w_0", "w_1", "up_0", "up_1"), 0.0) | {"up_2": 1.0}
    return Family(system, "spinning", at=("w_2",), held=held)


def sphere() -> list[BenchmarkRow]:
    """Row of Routh's sphere: the spin above which it stands with its centre of mass on top.

    Returns
    -------
    list of BenchmarkRow
    """
    numbers: dict[str, Any] = {"I1": 0.5, "I3": 0.375, "R": 1.0, "a": 0.25, "g": 1.0, "m": 1.0}
    found = threshold(rolling_sphere(), 0.1, 5.0, **numbers)
    return [
        at_threshold(
            SPHERE,
            found,
            "0.8837788686981583",
            origin=CLOSED,
            quantity="spin above which its centre of mass stays on top",
        )
    ]


def liquid() -> list[BenchmarkRow]:
    """Row of a long body of revolution that moves along its axis, by its spin.

    Returns
    -------
    list of BenchmarkRow
    """
    velocity, turn = ca.SX.sym("v", 3), ca.SX.sym("w", 3)
    m1, m3, J1, J3 = (ca.SX.sym(n) for n in ("m1", "m3", "J1", "J3"))
    masses, inertias = ca.vertcat(m1, m1, m3), ca.vertcat(J1, J1, J3)
    impulse, moment = masses * velocity, inertias * turn
    rates = ca.vertcat(
        ca.cross(impulse, turn) / masses,
        (ca.cross(moment, turn) + ca.cross(impulse, velocity)) / inertias,
    )
    states = tuple(f"{word}_{i}" for word in ("v", "w") for i in range(3))
    system = System(
        "body in a liquid",
        ca.vertcat(velocity, turn),
        ca.vertcat(m1, m3, J1, J3),
        rates,
        states=states,
        parameters=("m1", "m3", "J1", "J3"),
    )
    held = dict.fromkeys(("v_0", "v_1", "w_0", "w_1"), 0.0) | {"v_2": 1.0}
    along = Family(system, "along its axis", at=("w_2",), held=held)
    found = threshold(along, 0.1, 10.0, m1=3.0, m3=1.0, J1=2.0, J3=0.5)
    return [
        at_threshold(
            BODY,
            found,
            "4.6188021535170061",
            origin=CLOSED,
            quantity="spin above which it keeps its course",
        )
    ]


def square() -> Family:
    """Four unit vortices on a square about a fifth, seen from the frame that turns with them."""
    corners = ((1, 0), (0, 1), (-1, 0), (0, -1), (0, 0))
    x, y, middle = ca.SX.sym("x", 5), ca.SX.sym("y", 5), ca.SX.sym("middle")
    circulation = [*[ca.SX(1)] * 4, middle]
    spin = middle + ca.SX(3) / 2  # of the square with unit radius
    rates = []
    for i in range(5):
        u, v = spin * y[i], -spin * x[i]
        for j in (j for j in range(5) if j != i):
            across, up = x[i] - x[j], y[i] - y[j]
            share = circulation[j] / (across**2 + up**2)
            u, v = u - share * up, v + share * across
        rates += [u, v]
    states = tuple(f"{word}_{i}" for i in range(5) for word in "xy")
    columns = [c for i in range(5) for c in (x[i], y[i])]
    system = System(
        "five vortices",
        ca.vertcat(*columns),
        middle,
        ca.vertcat(*rates),
        states=states,
        parameters=("middle",),
    )
    held = dict(zip(states, (float(c) for corner in corners for c in corner), strict=True))
    return Family(system, "square", at=("middle",), held=held)


def vortices() -> list[BenchmarkRow]:
    """Rows of the vortex square: circulations of the fifth vortex between which it is neutral.

    Returns
    -------
    list of BenchmarkRow
    """
    low, high = threshold(square(), -1.2, 0.7), threshold(square(), 0.7, 4.0)
    return [
        at_threshold(
            VORTICES,
            low,
            "-0.5",
            origin=CLOSED,
            quantity="circulation in the middle above which the square is neutral",
        ),
        at_threshold(
            VORTICES,
            high,
            "2.25",
            origin=CLOSED,
            quantity="circulation in the middle above which it is unstable",
        ),
    ]
