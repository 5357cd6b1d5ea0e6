"""Ziegler's column, the Jeffcott rotor, the rotating saddle, the triangular points."""

from __future__ import annotations

import casadi as ca

from ...systems.family import Family
from ...systems.system import System
from .row import CLOSED, BenchmarkRow, Source, at_threshold, threshold

ZIEGLER = Source("Ziegler column", "Kirillov & Verhulst, ZAMM 90 (2010) 462")
ROTOR = Source("Jeffcott rotor", "A. L. Kimball (1924), internal damping")
SADDLE = Source("rotating saddle", "L. E. J. Brouwer (1918)")
POINTS = Source("triangular points", "E. J. Routh (1875)")


# --- Ziegler ---


def column(*, damped: bool) -> Family:
    """The straight column under a follower force, by its load P; b is the damping, if any."""
    x, P, b = ca.SX.sym("x", 4), ca.SX.sym("P"), ca.SX.sym("b")
    stiffness = ca.vertcat(ca.horzcat(2 - P, P - 1), ca.horzcat(-1, 1))
    friction = b * ca.SX([[2, -1], [-1, 1]]) @ x[2:] if damped else 0
    system = System.from_mass_matrix(
        "Ziegler column",
        x,
        ca.vertcat(P, b) if damped else P,
        mass=ca.SX([[3, 1], [1, 1]]),
        forcing=-stiffness @ x[:2] - friction,
        unknowns=("d_lower_rate", "d_upper_rate"),
        rates={"lower": x[2], "upper": x[3]},
        states=("lower", "upper", "lower_rate", "upper_rate"),
        parameters=("P", "b") if damped else ("P",),
    )
    return Family(
        system,
        "straight",
        at=("P",),
        held=dict.fromkeys(system.states, 0.0),
    )


def ziegler() -> list[BenchmarkRow]:
    """Rows of Ziegler's column: the load above which it flutters, with and without damping.

    Returns
    -------
    list of BenchmarkRow
    """
    free = threshold(column(damped=False), 0.5, 3.0)
    rows = [
        at_threshold(
            ZIEGLER,
            free,
            "2.0857864376269049",
            origin=CLOSED,
            quantity="load above which it flutters, undamped",
        )
    ]
    for b, known in (
        (1.0, "1.9642857142857142"),
        (0.1, "1.4692857142857143"),
        (1e-3, "1.4642862142857143"),
    ):
        found = threshold(column(damped=True), 0.5, 3.0, b=b)
        rows.append(
            at_threshold(
                ZIEGLER,
                found,
                known,
                origin=CLOSED,
                quantity=f"load above which it flutters, b = {b:g}",
            )
        )
    return rows


# --- rotor and saddle ---


def rotor() -> list[BenchmarkRow]:
    """Row of the Jeffcott rotor: the rate above which it whirls.

    Returns
    -------
    list of BenchmarkRow
    """
    x, y, u, v, W, w0, de, di = (ca.SX.sym(n) for n in ("x", "y", "u", "v", "W", "w0", "de", "di"))
    system = System(
        "Jeffcott rotor",
        ca.vertcat(x, y, u, v),
        ca.vertcat(W, w0, de, di),
        ca.vertcat(
            u,
            v,
            -(de + di) * u - w0**2 * x - W * di * y,
            -(de + di) * v - w0**2 * y + W * di * x,
        ),
        states=("x", "y", "u", "v"),
        parameters=("W", "w0", "de", "di"),
        units={"W": "rad/s", "w0": "rad/s", "de": "1/s", "di": "1/s"},
    )
    centred = Family(system, "centred", at=("W",), held=dict.fromkeys(system.states, 0.0))
    found = threshold(centred, 10.0, 1000.0, w0=100.0, de=3.0, di=2.0)
    return [
        at_threshold(
            ROTOR,
            found,
            "250",
            quantity="rate above which it whirls, w0 = 100, de = 3, di = 2",
            origin=CLOSED,
            unit="rad/s",
        )
    ]


def saddle() -> list[BenchmarkRow]:
    """Row of the rotating saddle: the rate above which it holds a ball.

    Returns
    -------
    list of BenchmarkRow
    """
    x, y, u, v, W, k = (ca.SX.sym(n) for n in ("x", "y", "u", "v", "W", "k"))
    system = System(
        "rotating saddle",
        ca.vertcat(x, y, u, v),
        ca.vertcat(W, k),
        ca.vertcat(u, v, (W**2 - k) * x + 2 * W * v, (W**2 + k) * y - 2 * W * u),
        states=("x", "y", "u", "v"),
        parameters=("W", "k"),
        units={"W": "rad/s", "k": "1/s²"},
    )
    centre = Family(
        system,
        "centre",
        at=("W",),
        held=dict.fromkeys(system.states, 0.0),
    )
    found = threshold(centre, 0.1, 5.0, k=3.0)
    return [
        at_threshold(
            SADDLE,
            found,
            "1.7320508075688773",
            origin=CLOSED,
            unit="rad/s",
            quantity="rate above which it holds a ball, k = 3",
        )
    ]


# --- three bodies ---


def triangle() -> Family:
    """The triangular point L4 in the frame of two heavy bodies, by the share m of the lighter."""
    x, y, u, v, m = (ca.SX.sym(n) for n in ("x", "y", "u", "v", "m"))
    near, far = ca.sqrt((x + m - 1) ** 2 + y**2), ca.sqrt((x + m) ** 2 + y**2)
    pull = ca.gradient((x**2 + y**2) / 2 + (1 - m) / far + m / near, ca.vertcat(x, y))
    system = System(
        "three bodies",
        ca.vertcat(x, y, u, v),
        m,
        ca.vertcat(u, v, pull + 2 * ca.vertcat(v, -u)),
        states=("x", "y", "u", "v"),
        parameters=("m",),
    )
    return Family(
        system,
        "L4",
        at=("m",),
        held={"u": 0.0, "v": 0.0},
        unknown={"x": 0.49, "y": 0.87},
        equations=("u", "v"),
        typical={"m": 0.02},
    )


def triangular_points() -> list[BenchmarkRow]:
    """Row of the triangular points: the mass ratio below which they are neutral.

    Returns
    -------
    list of BenchmarkRow
    """
    found = threshold(triangle(), 0.03, 0.05, 3)
    return [
        at_threshold(
            POINTS,
            found,
            "0.038520896504551397",
            origin=CLOSED,
            quantity="mass ratio below which they are neutral",
        )
    ]
