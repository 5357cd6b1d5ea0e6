"""A railway wheelset, Chaplygin's sleigh, and SymPy's rolling disc."""

from __future__ import annotations

import math
from typing import Any

import casadi as ca

from ...motion.simulate import simulate
from ...spectra.spectrum import spectrum
from ...systems.family import Family
from ...systems.mechanics import mechanics
from ...systems.system import System
from .row import (
    ELSEWHERE,
    BenchmarkRow,
    Source,
    at_threshold,
    at_zero,
    compared,
    symbols,
    system_of,
    threshold,
)

WHEELSET = Source("railway wheelset", "J. K. Moore, course EME 134 (UC Davis), lab 1", ELSEWHERE)
SLEIGH = Source("Chaplygin sleigh", "S. A. Chaplygin (1911)")
DISC = Source("SymPy's rolling disc", "sympy/physics/mechanics/tests/test_kane.py")
AXLE: dict[str, Any] = {
    "m": 1000.0,
    "d": 0.72,
    "I": 1000 * 0.72**2,
    "N": 20e3,
    "R": 0.23,
    "Rr": 0.2,
    "d1": 0.36,
    "cone": math.pi / 180,
    "f": 1e6,
    "k1": 13e3,
    "k2": 13e3,
    "r0": 0.46,
}
"""The wheelset in SI units: mass, half gauge, moment, load, radii, arm, cone, creep, springs."""
BLADE: dict[str, Any] = {"m": 1.0, "a": 0.3, "I": 0.2}
"""The sleigh: mass, distance of its centre from the blade, moment of inertia."""


def wheelset() -> Family:
    """The wheelset in the middle of its track, by its speed."""
    y, yaw, dy, dyaw, v = symbols("y yaw dy dyaw v")
    p = {n: ca.SX.sym(n) for n in AXLE}
    lam = p["R"] * p["cone"] / (p["R"] - p["Rr"])
    guide = 2 * p["k1"] + 2 * p["N"] / (p["R"] - p["Rr"])
    side = -guide * y + 2 * p["f"] * yaw - 2 * p["f"] / v * dy
    steer = 2 * p["f"] * lam * p["d"] / p["r0"]
    turn = -steer * y - 2 * p["k2"] * p["d1"] ** 2 * yaw - 2 * p["f"] * p["d"] ** 2 / v * dyaw
    rates = [dy, dyaw, side / p["m"], turn / p["I"]]
    system = system_of("wheelset", [y, yaw, dy, dyaw], [v, *p.values()], rates, units={"v": "m/s"})
    return at_zero(system, "centred", "v")


def hunting() -> list[BenchmarkRow]:
    """Rows of the wheelset: the speed above which it hunts, and its spectrum at 20 m/s."""
    change = threshold(wheelset(), 1.0, 100.0, **AXLE)
    slow = spectrum(wheelset(), at=20.0, **AXLE).eigenvalues
    numbers = {
        "real part of the fast pair at 20 m/s": ("-94.32282188", slow[0].real),
        "imaginary part of the fast pair at 20 m/s": ("12.14204292", slow[1].imag),
        "real part of the slow pair at 20 m/s": ("-5.67717812", slow[2].real),
        "imaginary part of the slow pair at 20 m/s": ("12.14204292", slow[3].imag),
    }
    return [
        at_threshold(WHEELSET, "speed above which it hunts", "48.558435944090", change, unit="m/s"),
        compared(
            WHEELSET,
            "frequency of hunting",
            "26.132674311418",
            change.frequency,
            unit="rad/s",
            reason=change.reason,
        ),
        *(
            compared(WHEELSET, quantity, reference, float(value), unit="1/s")
            for quantity, (reference, value) in numbers.items()
        ),
    ]


def sleigh() -> System:
    """The sleigh, by its kinetic energy and its knife edge."""
    x, y, heading, v, across, w = symbols("x y heading v across w")
    m, a, inertia = (ca.SX.sym(n) for n in BLADE)
    c, s = ca.cos(heading), ca.sin(heading)
    return mechanics(
        ca.vertcat(x, y, heading),
        ca.vertcat(v, across, w),
        ca.vertcat(m, a, inertia),
        q_dot=ca.vertcat(c * v - s * across, s * v + c * across, w),
        kinetic=(m * (v**2 + (across + a * w) ** 2) + inertia * w**2) / 2,
        velocity_constraints={"blade": across},
        independent=("v", "w"),
        ignorable=("x", "y", "heading"),
        name="sleigh",
    )


def turning() -> list[BenchmarkRow]:
    """Rows of the sleigh: its attraction, and its speed after it has turned."""
    system = sleigh()
    straight = Family(system, "straight", at=("v",), held={"w": 0.0})
    rate = spectrum(straight, at=1.0, **BLADE).eigenvalues[0].real
    run = simulate(system, BLADE, {"v": -1.0, "w": 0.05}, 60.0, tolerance=1e-14)
    return [
        compared(SLEIGH, "rate of attraction at speed 1", "-1.0344827586206897", float(rate)),
        compared(SLEIGH, "final speed from v = -1, w = 0.05", "1.00036243432068", float(run.v[-1])),
    ]


def kane_model() -> tuple[Any, dict[str, Any]]:
    """SymPy's model of a rolling disc, as its own test has it, and the symbols that it needs."""
    from sympy import symbols
    from sympy.physics import mechanics as me

    (q1, q2, q3), (u1, u2, u3) = me.dynamicsymbols("q1:4"), me.dynamicsymbols("u1:4")
    (m, r, g), n, contact = symbols("m r g"), me.ReferenceFrame("N"), me.Point("C")
    yaw = n.orientnew("Y", "Axis", [q1, n.z])
    lean = yaw.orientnew("L", "Axis", [q2, yaw.x])
    disc = lean.orientnew("R", "Axis", [q3, lean.y])
    spin, turn = disc.ang_vel_in(n), u1 * lean.x + u2 * lean.y + u3 * lean.z
    disc.set_ang_vel(n, turn)
    contact.set_vel(n, 0)
    centre = contact.locatenew("Dmc", r * lean.z)
    centre.v2pt_theory(contact, n, disc)
    inertia = me.inertia(lean, m * r**2 / 4, m * r**2 / 2, m * r**2 / 4)
    kane = me.KanesMethod(n, [q1, q2, q3], [u1, u2, u3], [me.dot(turn - spin, e) for e in lean])
    body = me.RigidBody("B", centre, disc, m, (inertia, centre))
    kane.kanes_equations([body], [(centre, -m * g * yaw.z)])
    return kane, {"parameters": [m, r, g], "cyclic": [q1, q3]}


def sympy_disc() -> list[BenchmarkRow]:
    """Row of SymPy's disc: the rate above which it rolls straight."""
    kane, needed = kane_model()
    system = System.from_sympy(kane, name="disc", **needed)
    straight = Family(system, "straight", at=("u2",), held=dict.fromkeys(("q2", "u1", "u3"), 0.0))
    change = threshold(straight, 0.1, 9.0, m=1.0, r=1.0, g=9.81)
    return [
        at_threshold(
            DISC,
            "rate of rolling above which it is neutral",
            "1.808314132002512",
            change,
            unit="rad/s",
        )
    ]
