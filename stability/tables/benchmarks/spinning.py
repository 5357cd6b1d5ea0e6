"""Motions that spin: a gyropendulum, Routh's sphere, a body in a liquid, a square of vortices."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any

import casadi as ca

from ...derivation.conditions import conditions
from ...spectra.spectrum import spectrum
from ...systems.family import Family
from ...systems.mechanics import mechanics
from ...systems.system import System
from .row import (
    BenchmarkRow,
    Source,
    at_threshold,
    at_zero,
    compared,
    symbols,
    system_of,
    threshold,
)

LAGRANGE = Source("Lagrange top", "J. L. Lagrange (1788)")
TIPPE = Source("tippe top", "Rauch-Wojciechowski & Rutstam, SIGMA 10 (2014) 017")
TOP: dict[str, Any] = {"I1": 1.0, "I3": 0.5, "mgl": 1.0}
"""Numbers of the top, without unit."""
SPHERE: dict[str, Any] = {"m": 0.02, "R": 0.02, "a": 0.3, "g": 9.82}
"""Mass [kg], radius [m], offset over radius, gravity [m/s²] of the tippe top."""
BODY: dict[str, Any] = SPHERE | {"I3": 2 / 5 * 0.02 * 0.02**2, "I1": 131 / 350 * 0.02 * 0.02**2}
"""The same, with its moments of inertia [kg m²]."""


# --- Lagrange's top ---


def _top(
    angles: Sequence[ca.SX],
    rates: Sequence[ca.SX],
    across: ca.SX,
    along: ca.SX,
    height: ca.SX,
    *,
    ignorable: Sequence[str],
) -> System:
    """The top in some angles, from the squares of its angular velocities and its height."""
    transverse, axial, mgl = (ca.SX.sym(n) for n in TOP)
    return mechanics(
        ca.vertcat(*angles),
        ca.vertcat(*rates),
        ca.vertcat(transverse, axial, mgl),
        kinetic=(transverse * across + axial * along) / 2,
        potential=mgl * height,
        ignorable=ignorable,
        name="Lagrange top",
    )


def sleeping() -> Family:
    """The top that spins upright, by its spin; its axis leans by two angles."""
    lean, tilt, turn, d_lean, d_tilt, spin = symbols("lean tilt turn d_lean d_tilt spin")
    across = (d_lean * ca.cos(tilt)) ** 2 + d_tilt**2
    along = (spin + d_lean * ca.sin(tilt)) ** 2
    angles, height = (lean, tilt, turn), ca.cos(lean) * ca.cos(tilt)
    top = _top(angles, (d_lean, d_tilt, spin), across, along, height, ignorable=("turn",))
    held = dict.fromkeys(("lean", "tilt", "d_lean", "d_tilt"), 0.0)
    return Family(top, "sleeping", at=("spin",), held=held)


def precessing() -> Family:
    """The top that precesses steadily, by inclination and rate of precession, in Euler's angles."""
    theta, phi, psi, d_theta, d_phi, spin = symbols("theta phi psi d_theta d_phi spin")
    across = d_theta**2 + (d_phi * ca.sin(theta)) ** 2
    along = (spin + d_phi * ca.cos(theta)) ** 2
    angles, rates = (theta, phi, psi), (d_theta, d_phi, spin)
    top = _top(angles, rates, across, along, ca.cos(theta), ignorable=("phi", "psi"))
    return Family(
        top,
        "precessing",
        at=("theta", "d_phi"),
        held={"d_theta": 0.0},
        unknown={"spin": 3.0},
        equations=("d_theta",),
    )


def lagrange() -> list[BenchmarkRow]:
    """Rows of Lagrange's top: where it sleeps, and how fast it nods."""
    change = threshold(sleeping(), 1.0, 9.0, **TOP)
    nodding = spectrum(precessing(), at=(1.0, 0.7), **TOP).eigenvalues.imag.max()
    return [
        at_threshold(LAGRANGE, "spin above which it sleeps", "4", change),
        compared(
            LAGRANGE,
            "nutation at inclination 1, precession 0.7",
            "1.20424736445397",
            float(nodding),
        ),
    ]


# --- the tippe top ---


@cache
def tippe_system() -> System:
    """A sphere with its centre of mass off its centre, by Newton's and Euler's equations.

    The axis is a unit vector, so that both upright and inverted are regular points.
    """
    axis, spin, slide = ca.SX.sym("axis", 3), ca.SX.sym("spin", 3), ca.SX.sym("slide", 2)
    p = {n: ca.SX.sym(n) for n in ("m", "R", "a", "I1", "I3", "g", "mu")}
    d_spin, d_slide, load = ca.SX.sym("d_spin", 3), ca.SX.sym("d_slide", 2), ca.SX.sym("load")
    turned = ca.cross(spin, axis)
    arm = p["R"] * (p["a"] * axis - ca.SX([0, 0, 1]))  # from the centre of mass to the contact
    rise = -p["R"] * p["a"] * (ca.cross(d_spin, axis) + ca.cross(spin, turned))[2]
    friction = -p["mu"] * load * (slide + ca.cross(spin, arm)[:2])
    force = ca.vertcat(friction, load)
    along = ca.dot(d_spin, axis) * axis + ca.dot(spin, axis) * turned
    moment = p["I1"] * d_spin + (p["I3"] - p["I1"]) * along
    newton = ca.vertcat(p["m"] * d_slide - friction, p["m"] * (rise + p["g"]) - load)
    balance, unknowns = ca.vertcat(moment - ca.cross(arm, force), newton), (d_spin, d_slide, load)
    names = [f"{word}_{i}" for word in ("axis", "spin", "slide") for i in "xyz"][:-1]
    return System.from_mass_matrix(
        "tippe top",
        ca.vertcat(axis, spin, slide),
        ca.vertcat(*p.values()),
        mass=ca.jacobian(balance, ca.vertcat(*unknowns)),
        forcing=-ca.substitute(balance, ca.vertcat(*unknowns), ca.SX.zeros(6)),
        unknowns=(*(f"d_{n}" for n in names[3:]), "load"),
        rates=dict(zip(names[:3], ca.vertsplit(turned), strict=True)),
        states=names,
        parameters=tuple(p),
        units={"spin_z": "rad/s", "m": "kg", "R": "m", "mu": "s/m"},
    )


def spinning(way: str) -> Family:
    """The tippe top that spins about the vertical, `upright` or `inverted`, by its spin."""
    system = tippe_system()
    held = dict.fromkeys((n for n in system.states if n != "spin_z"), 0.0)
    held["axis_z"] = 1.0 if way == "upright" else -1.0
    return Family(system, way, at=("spin_z",), held=held)


def for_every_friction(
    family: Family, low: float, high: float, others: Mapping[float, float]
) -> tuple[float | None, str]:
    """The spin at which the verdict changes for every friction, from exact conditions.

    Between `low` and `high` one condition must decide, a polynomial in the spin alone; the
    intervals `others`, which cover the rest, must be unstable for every friction.

    Returns
    -------
    value, reason
        None and a reason where this is not proved.
    """
    settings: dict[str, Any] = {"positive": ("mu",), **BODY}
    near = conditions(family, between={"spin_z": (low, high)}, **settings)
    square = near.deciding[0].polynomial if len(near.deciding) == 1 else None
    if square is None or near.left_out or [e for _, e in square.terms] != [(2, 0), (0, 0)]:
        return None, "the conditions near the threshold contain the friction"
    for start, end in others.items():
        far = conditions(family, between={"spin_z": (start, end)}, **settings)
        if not any(c.status == "negative" for c in far.conditions):
            return None, f"the verdict from {start:g} to {end:g} rad/s is not proved"
    (leading, _), (constant, _) = square.terms
    return math.sqrt(-constant / leading), ""


def tippe() -> list[BenchmarkRow]:
    """Rows of the tippe top: thresholds for three frictions, and for every friction."""
    references = {"upright": "27.667917094780", "inverted": "41.332688957659"}
    words = {
        "upright": "spin below which upright is stable",
        "inverted": "spin above which inverted is stable",
    }
    rows: list[BenchmarkRow] = []
    last = None
    for way, value in references.items():
        for mu in (0.3, 3.0, 30.0):
            last = threshold(spinning(way), 1.0, 99.0, mu=mu, **BODY)
            quantity = f"{words[way]}, mu = {mu:g} s/m"
            rows.append(at_threshold(TIPPE, quantity, value, last, unit="rad/s"))
    integral = None
    if last is not None and last.value is not None:
        integral = BODY["I3"] * BODY["R"] * (1 + BODY["a"]) * last.value
    rows.append(
        compared(
            TIPPE,
            "Jellett's integral above which inverted is stable",
            "3.438879721e-6",
            integral,
            unit="J s m",
            reason="no threshold",
        )
    )
    proofs = {
        "upright": (0.0, 27.7, {27.69: math.inf}),
        "inverted": (41.29, math.inf, {0.0: 22.95, 22.9: 41.3}),
    }
    for way, (low, high, others) in proofs.items():
        edge, why = for_every_friction(spinning(way), low, high, others)
        quantity = f"{words[way]}, every mu, exact condition"
        rows.append(compared(TIPPE, quantity, references[way], edge, unit="rad/s", reason=why))
    return rows


GYROPENDULUM = Source("gyropendulum", "S. H. Crandall, Z. angew. Math. Phys. 46 (1995) S761")
ROUTH = Source("Routh's sphere", "E. J. Routh, Dynamics of a System of Rigid Bodies, Advanced Part")
LIQUID = Source("body in a liquid", "H. Lamb, Hydrodynamics, ch. VI (Kirchhoff's equations)")
VORTICES = Source("vortices about a vortex", "Cabral & Schmidt, SIAM J. Math. Anal. 31 (2000) 231")


def gyropendulum() -> list[BenchmarkRow]:
    """Row of the spinning inverted pendulum, held up by damping that turns with it."""
    x, y, u, v = symbols("x y u v")
    spin, fixed, turning, gyro, fall = numbers = symbols("spin fixed turning gyro fall")
    damping, follow = fixed + turning, turning * spin
    rates = [
        u,
        v,
        -damping * u - gyro * spin * v + fall * x - follow * y,
        -damping * v + gyro * spin * u + fall * y + follow * x,
    ]
    upright = at_zero(system_of("gyropendulum", [x, y, u, v], numbers, rates), "upright", "spin")
    change = threshold(upright, 0.1, 10.0, fixed=0.125, turning=0.375, gyro=1.5, fall=2.0)
    what = "rate above which damping that turns holds it"
    return [at_threshold(GYROPENDULUM, what, "1.8856180831641267", change)]


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
    """Row of Routh's sphere: the spin above which it stands with its centre of mass on top."""
    numbers: dict[str, Any] = {"I1": 0.5, "I3": 0.375, "R": 1.0, "a": 0.25, "g": 1.0, "m": 1.0}
    change = threshold(rolling_sphere(), 0.1, 5.0, **numbers)
    what = "spin above which its centre of mass stays on top"
    return [at_threshold(ROUTH, what, "0.8837788686981583", change)]


def liquid() -> list[BenchmarkRow]:
    """Row of a long body of revolution that moves along its axis, by its spin."""
    velocity, turn = ca.SX.sym("v", 3), ca.SX.sym("w", 3)
    m1, m3, J1, J3 = symbols("m1 m3 J1 J3")
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
    change = threshold(along, 0.1, 10.0, m1=3.0, m3=1.0, J1=2.0, J3=0.5)
    what = "spin above which it keeps its course"
    return [at_threshold(LIQUID, what, "4.6188021535170061", change)]


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
    """Rows of the vortex square: circulations of the fifth vortex between which it is neutral."""
    low, high = threshold(square(), -1.2, 0.7), threshold(square(), 0.7, 4.0)
    below = "circulation in the middle above which the square is neutral"
    above = "circulation in the middle above which it is unstable"
    return [
        at_threshold(VORTICES, below, "-0.5", low),
        at_threshold(VORTICES, above, "2.25", high),
    ]
