"""Lagrange's top and the tippe top."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cache
from typing import Any

import casadi as ca

from ...derivation.conditions import conditions
from ...spectra.spectrum import spectrum
from ...systems.family import Family
from ...systems.mechanics import mechanics
from ...systems.system import System
from .row import CLOSED, BenchmarkRow, Source, at_threshold, compared, threshold

LAGRANGE = Source("Lagrange top", "J. L. Lagrange (1788)")
TIPPE = Source("tippe top", "Rauch-Wojciechowski & Rutstam, SIGMA 10 (2014) 017")
TOP: dict[str, Any] = {"I1": 1.0, "I3": 0.5, "mgl": 1.0}
"""Numbers of the top, without unit."""
SPHERE: dict[str, Any] = {"m": 0.02, "R": 0.02, "a": 0.3, "g": 9.82}
"""Mass [kg], radius [m], offset over radius, gravity [m/s²] of the tippe top."""
BODY: dict[str, Any] = SPHERE | {"I3": 2 / 5 * 0.02 * 0.02**2, "I1": 131 / 350 * 0.02 * 0.02**2}
"""The same, with its moments of inertia [kg m²]."""


# --- Lagrange's top ---


def sleeping() -> Family:
    """The top that spins upright, by its spin; its axis leans by two angles."""
    lean, tilt, turn, d_lean, d_tilt, spin, one, three, mgl = (
        ca.SX.sym(n) for n in ("lean", "tilt", "turn", "d_lean", "d_tilt", "spin", *TOP)
    )
    across = (d_lean * ca.cos(tilt)) ** 2 + d_tilt**2
    along = (spin + d_lean * ca.sin(tilt)) ** 2
    top = mechanics(
        ca.vertcat(lean, tilt, turn),
        ca.vertcat(d_lean, d_tilt, spin),
        ca.vertcat(one, three, mgl),
        kinetic=(one * across + three * along) / 2,
        potential=mgl * ca.cos(lean) * ca.cos(tilt),
        ignorable=("turn",),
        name="Lagrange top",
    )
    held = dict.fromkeys(("lean", "tilt", "d_lean", "d_tilt"), 0.0)
    return Family(
        top,
        "sleeping",
        at=("spin",),
        held=held,
    )


def precessing() -> Family:
    """The top that precesses steadily, by inclination and rate of precession, in Euler's angles."""
    theta, phi, psi, d_theta, d_phi, spin, one, three, mgl = (
        ca.SX.sym(n) for n in ("theta", "phi", "psi", "d_theta", "d_phi", "spin", *TOP)
    )
    across = d_theta**2 + (d_phi * ca.sin(theta)) ** 2
    along = (spin + d_phi * ca.cos(theta)) ** 2
    top = mechanics(
        ca.vertcat(theta, phi, psi),
        ca.vertcat(d_theta, d_phi, spin),
        ca.vertcat(one, three, mgl),
        kinetic=(one * across + three * along) / 2,
        potential=mgl * ca.cos(theta),
        ignorable=("phi", "psi"),
        name="Lagrange top",
    )
    return Family(
        top,
        "precessing",
        at=("theta", "d_phi"),
        held={"d_theta": 0.0},
        unknown={"spin": 3.0},
        equations=("d_theta",),
    )


def lagrange() -> list[BenchmarkRow]:
    """Rows of Lagrange's top: where it sleeps, and how fast it nods.

    Returns
    -------
    list of BenchmarkRow
    """
    found = threshold(sleeping(), 1.0, 9.0, **TOP)
    nodding = spectrum(precessing(), at=(1.0, 0.7), **TOP).eigenvalues.imag.max()
    return [
        at_threshold(LAGRANGE, found, "4", quantity="spin above which it sleeps", origin=CLOSED),
        compared(
            LAGRANGE,
            "nutation at inclination 1, precession 0.7",
            "1.20424736445397",
            float(nodding),
            origin=CLOSED,
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

    Parameters
    ----------
    family
        Upright or inverted spinning.
    low, high
        Interval of the spin around the threshold.
    others
        Ends of the other intervals, by their beginnings.

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
    """Rows of the tippe top: thresholds for three frictions, and for every friction.

    Returns
    -------
    list of BenchmarkRow
    """
    known = {"upright": "27.667917094780", "inverted": "41.332688957659"}
    words = {
        "upright": "spin below which upright is stable",
        "inverted": "spin above which inverted is stable",
    }
    rows: list[BenchmarkRow] = []
    last = None
    for way, value in known.items():
        for mu in (0.3, 3.0, 30.0):
            last = threshold(spinning(way), 1.0, 99.0, mu=mu, **BODY)
            words_now = f"{words[way]}, mu = {mu:g} s/m"
            rows.append(
                at_threshold(TIPPE, last, value, quantity=words_now, origin=CLOSED, unit="rad/s")
            )
    integral = None
    if last is not None and last.value is not None:
        integral = BODY["I3"] * BODY["R"] * (1 + BODY["a"]) * last.value
    rows.append(
        compared(
            TIPPE,
            "Jellett's integral above which inverted is stable",
            "3.438879721e-6",
            integral,
            origin=CLOSED,
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
        rows.append(
            compared(
                TIPPE,
                f"{words[way]}, every mu, exact condition",
                known[way],
                edge,
                origin=CLOSED,
                unit="rad/s",
                reason=why,
            )
        )
    return rows
