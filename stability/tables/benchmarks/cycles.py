"""Watt's governor, two models of a nerve, and a mass that sticks and slips on a belt."""

from __future__ import annotations

from typing import Any

import casadi as ca

from ...boundary.two_parameters.points import codimension_two
from ...motion.simulate import simulate
from ...systems.condition import Condition
from ...systems.family import Family
from ...systems.system import System
from .row import CLOSED, ELSEWHERE, BenchmarkRow, Source, at_threshold, compared, threshold

GOVERNOR = Source("Watt governor", "Sotomayor, Mello & Braga, arXiv math/0606230")
NERVE = Source("FitzHugh-Nagumo nerve", "R. FitzHugh, Biophys. J. 1 (1961) 445")
AXON = Source("Hodgkin-Huxley axon", "Hodgkin & Huxley, J. Physiol. 117 (1952) 500")
BELT = Source("mass on a belt", "Coulomb friction, static larger than kinetic")
MASS = {"belt": 0.2, "rest": 1.0, "sliding": 0.5}
"""Speed of the belt, friction at rest, sliding friction; mass and spring are 1."""


def governor() -> Family:
    """The engine that runs evenly, by the friction e of the governor."""
    x, y, z, e, a, b = (ca.SX.sym(n) for n in ("x", "y", "z", "e", "a", "b"))
    swing = z**2 * ca.sin(x) * ca.cos(x) - ca.sin(x) - e * y
    system = System(
        "Watt governor",
        ca.vertcat(x, y, z),
        ca.vertcat(e, a, b),
        ca.vertcat(y, swing, a * (ca.cos(x) - b)),
        states=("x", "y", "z"),
        parameters=("e", "a", "b"),
    )
    near = {"x": 1.0, "z": 1.4, "e": 0.4, "a": 0.5, "b": 0.5}
    return system.steady("e", held={"y": 0.0}, guess=near, equations=("y", "z"), name="running")


def swinging() -> list[BenchmarkRow]:
    """Rows of the governor: where it begins to swing, and whether gently.

    Returns
    -------
    list of BenchmarkRow
    """
    rows: list[BenchmarkRow] = []
    for a, b, known in ((0.5, 0.5, "0.3535533905932738"), (0.25, 0.64, "0.256")):
        found = threshold(governor(), float(known) / 2, 2 * float(known), a=a, b=b)
        quantity = f"friction above which it is even, a = {a}, b = {b}"
        rows.append(at_threshold(GOVERNOR, found, known, origin=CLOSED, quantity=quantity))
    for a, known in ((0.25, ".7795976849"), (0.5, ".7968357154"), (0.8, ".8506928506")):
        [point] = codimension_two(governor(), x=("b", 0.75, 0.9, 2), y=("e", 0.2, 1.6, 2), a=a)
        rows.append(
            compared(
                GOVERNOR,
                f"b where the first Lyapunov coefficient is 0, a = {a}",
                f"0{known}",
                point.x,
                origin=ELSEWHERE,
            )
        )
    return rows


def nerve() -> list[BenchmarkRow]:
    """Rows of FitzHugh's nerve: currents between which it fires again and again.

    Returns
    -------
    list of BenchmarkRow
    """
    v, w, current, a, b, slow = (ca.SX.sym(n) for n in ("v", "w", "current", "a", "b", "slow"))
    system = System(
        "nerve",
        ca.vertcat(v, w),
        ca.vertcat(current, a, b, slow),
        ca.vertcat(v - v**3 / 3 - w + current, slow * (v + a - b * w)),
        states=("v", "w"),
        parameters=("current", "a", "b", "slow"),
    )
    numbers: dict[str, Any] = {"a": 0.7, "b": 0.8, "slow": 0.08}
    rest = system.steady("current", guess={"v": -1.2, "w": -0.6, "current": 0.0, **numbers})
    return _firing(
        NERVE, rest, ((0.0, 0.8, "0.331281337454746"), (1.0, 2.0, "1.41871866254525")), **numbers
    )


def axon() -> list[BenchmarkRow]:
    """Rows of the squid axon: currents between which it fires again and again.

    Returns
    -------
    list of BenchmarkRow
    """
    v, m, h, n, current = (ca.SX.sym(name) for name in ("v", "m", "h", "n", "current"))
    opens = {
        m: ca.SX(0.1) * (25 - v) / (ca.exp((25 - v) / 10) - 1),
        h: 0.07 * ca.exp(-v / 20),
        n: 0.01 * (10 - v) / (ca.exp((10 - v) / 10) - 1),
    }
    closes = {
        m: 4 * ca.exp(-v / 18),
        h: 1 / (ca.exp((30 - v) / 10) + 1),
        n: 0.125 * ca.exp(-v / 80),
    }
    flow = current - 120 * m**3 * h * (v - 115) - 36 * n**4 * (v + 12) - 0.3 * (v - 10.6)
    gates = [opens[gate] * (1 - gate) - closes[gate] * gate for gate in (m, h, n)]
    system = System(
        "axon",
        ca.vertcat(v, m, h, n),
        current,
        ca.vertcat(flow, *gates),
        states=("v", "m", "h", "n"),
        parameters=("current",),
        units={"current": "uA/cm2", "v": "mV"},
    )
    rest = system.steady("current", guess={"v": 0.01, "m": 0.05, "h": 0.6, "n": 0.32, "current": 0})
    ends = ((9.5, 10.0, "9.779337995393"), (154.0, 155.0, "154.526333665808"))
    return _firing(AXON, rest, ends, origin=ELSEWHERE, unit="uA/cm2")


def _firing(
    about: Source,
    rest: Family,
    ends: tuple[tuple[float, float, str], ...],
    origin: str = CLOSED,
    unit: str = "",
    **numbers: Any,
) -> list[BenchmarkRow]:
    """Rows of both currents at which a nerve's rest changes."""
    rows: list[BenchmarkRow] = []
    for (low, high, known), word in zip(ends, ("begins", "ceases"), strict=True):
        found = threshold(rest, low, high, **numbers)
        rows.append(
            at_threshold(
                about,
                found,
                known,
                origin=origin,
                unit=unit,
                quantity=f"current at which firing {word}",
            )
        )
    return rows


def _phase(name: str, end: str) -> System:
    """The mass while it slips, or sticks; its run ends where its condition reaches zero."""
    x, u, belt, rest, sliding = (ca.SX.sym(n) for n in ("x", "u", *MASS))
    pull, ahead = x - sliding, belt - u
    # positive where the belt is ahead or the spring pulls forwards: a + b + sqrt(a² + b²), smooth
    slips = pull + ahead + ca.sqrt(pull**2 + ahead**2)
    rates, positive = {
        "slip": (ca.vertcat(u, -pull), slips),
        "stick": (ca.vertcat(belt, 0), rest - x),
    }[name]
    return System(
        name,
        ca.vertcat(x, u),
        ca.vertcat(belt, rest, sliding),
        rates,
        states=("x", "u"),
        parameters=tuple(MASS),
        conditions=(Condition(positive, end),),
    )


def stick_slip() -> list[BenchmarkRow]:
    """Row of the mass on a belt: the period of its cycle, from one run of each phase.

    Returns
    -------
    list of BenchmarkRow
    """
    start = {"x": MASS["rest"], "u": MASS["belt"]}
    slip = simulate(_phase("slip", "the belt catches it"), MASS, start, 20.0, tolerance=1e-13)
    caught = {"x": float(slip.x[-1]), "u": float(slip.u[-1])}
    stick = simulate(_phase("stick", "the spring wins"), MASS, caught, 20.0, tolerance=1e-13)
    period = float(slip.end_time) + float(stick.end_time)
    return [
        compared(BELT, "period of sticking and slipping", "8.9026054078145", period, origin=CLOSED)
    ]
