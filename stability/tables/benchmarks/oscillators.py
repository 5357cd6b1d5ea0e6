"""Ziegler's column, the Jeffcott rotor, the rotating saddle, the triangular points."""

from __future__ import annotations

from typing import Any

import casadi as ca

from ...boundary.two_parameters.points import codimension_two
from ...motion.simulate import simulate
from ...systems.equations import Condition
from ...systems.family import Family
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
    return at_zero(system, "straight", "P")


def ziegler() -> list[BenchmarkRow]:
    """Rows of Ziegler's column: the load above which it flutters, with and without damping."""
    what = "load above which it flutters"
    free = threshold(column(damped=False), 0.5, 3.0)
    rows = [at_threshold(ZIEGLER, f"{what}, undamped", "2.0857864376269049", free)]
    for b, reference in (
        (1.0, "1.9642857142857142"),
        (0.1, "1.4692857142857143"),
        (1e-3, "1.4642862142857143"),
    ):
        change = threshold(column(damped=True), 0.5, 3.0, b=b)
        rows.append(at_threshold(ZIEGLER, f"{what}, b = {b:g}", reference, change))
    return rows


# --- rotor and saddle ---


def rotor() -> list[BenchmarkRow]:
    """Row of the Jeffcott rotor: the rate above which it whirls."""
    x, y, u, v, W, w0, de, di = symbols("x y u v W w0 de di")
    system = system_of(
        "Jeffcott rotor",
        [x, y, u, v],
        [W, w0, de, di],
        [
            u,
            v,
            -(de + di) * u - w0**2 * x - W * di * y,
            -(de + di) * v - w0**2 * y + W * di * x,
        ],
        units={"W": "rad/s", "w0": "rad/s", "de": "1/s", "di": "1/s"},
    )
    centred = at_zero(system, "centred", "W")
    change = threshold(centred, 10.0, 1000.0, w0=100.0, de=3.0, di=2.0)
    what = "rate above which it whirls, w0 = 100, de = 3, di = 2"
    return [at_threshold(ROTOR, what, "250", change, unit="rad/s")]


def saddle() -> list[BenchmarkRow]:
    """Row of the rotating saddle: the rate above which it holds a ball."""
    x, y, u, v, W, k = symbols("x y u v W k")
    system = system_of(
        "rotating saddle",
        [x, y, u, v],
        [W, k],
        [u, v, (W**2 - k) * x + 2 * W * v, (W**2 + k) * y - 2 * W * u],
        units={"W": "rad/s", "k": "1/s²"},
    )
    change = threshold(at_zero(system, "centre", "W"), 0.1, 5.0, k=3.0)
    what = "rate above which it holds a ball, k = 3"
    return [at_threshold(SADDLE, what, "1.7320508075688773", change, unit="rad/s")]


# --- three bodies ---


def triangle() -> Family:
    """The triangular point L4 in the frame of two heavy bodies, by the share m of the lighter."""
    x, y, u, v, m = symbols("x y u v m")
    near, far = ca.sqrt((x + m - 1) ** 2 + y**2), ca.sqrt((x + m) ** 2 + y**2)
    pull = ca.gradient((x**2 + y**2) / 2 + (1 - m) / far + m / near, ca.vertcat(x, y))
    system = system_of("three bodies", [x, y, u, v], [m], [u, v, pull + 2 * ca.vertcat(v, -u)])
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
    """Row of the triangular points: the mass ratio below which they are neutral."""
    change = threshold(triangle(), 0.03, 0.05, 3)
    what = "mass ratio below which they are neutral"
    return [at_threshold(POINTS, what, "0.038520896504551397", change)]


GOVERNOR = Source("Watt governor", "Sotomayor, Mello & Braga, arXiv math/0606230")
NERVE = Source("FitzHugh-Nagumo nerve", "R. FitzHugh, Biophys. J. 1 (1961) 445")
AXON = Source("Hodgkin-Huxley axon", "Hodgkin & Huxley, J. Physiol. 117 (1952) 500", ELSEWHERE)
BELT = Source("mass on a belt", "Coulomb friction, static larger than kinetic")
MASS = {"belt": 0.2, "rest": 1.0, "sliding": 0.5}
"""Speed of the belt, friction at rest, sliding friction; mass and spring are 1."""


def governor() -> Family:
    """The engine that runs evenly, by the friction e of the governor."""
    x, y, z, e, a, b = symbols("x y z e a b")
    swing = z**2 * ca.sin(x) * ca.cos(x) - ca.sin(x) - e * y
    rates = [y, swing, a * (ca.cos(x) - b)]
    system = system_of("Watt governor", [x, y, z], [e, a, b], rates)
    near = {"x": 1.0, "z": 1.4, "e": 0.4, "a": 0.5, "b": 0.5}
    return system.steady("e", held={"y": 0.0}, guess=near, equations=("y", "z"), name="running")


def swinging() -> list[BenchmarkRow]:
    """Rows of the governor: where it begins to swing, and whether gently."""
    rows: list[BenchmarkRow] = []
    for a, b, reference in ((0.5, 0.5, "0.3535533905932738"), (0.25, 0.64, "0.256")):
        change = threshold(governor(), float(reference) / 2, 2 * float(reference), a=a, b=b)
        quantity = f"friction above which it is even, a = {a}, b = {b}"
        rows.append(at_threshold(GOVERNOR, quantity, reference, change))
    for a, reference in ((0.25, ".7795976849"), (0.5, ".7968357154"), (0.8, ".8506928506")):
        [point] = codimension_two(governor(), x=("b", 0.75, 0.9, 2), y=("e", 0.2, 1.6, 2), a=a)
        quantity = f"b where the first Lyapunov coefficient is 0, a = {a}"
        rows.append(
            compared(GOVERNOR._replace(origin=ELSEWHERE), quantity, f"0{reference}", point.x)
        )
    return rows


def nerve() -> list[BenchmarkRow]:
    """Rows of FitzHugh's nerve: currents between which it fires again and again."""
    v, w, current, a, b, slow = symbols("v w current a b slow")
    rates = [v - v**3 / 3 - w + current, slow * (v + a - b * w)]
    system = system_of("nerve", [v, w], [current, a, b, slow], rates)
    numbers: dict[str, Any] = {"a": 0.7, "b": 0.8, "slow": 0.08}
    rest = system.steady("current", guess={"v": -1.2, "w": -0.6, "current": 0.0, **numbers})
    ends = ((0.0, 0.8, "0.331281337454746"), (1.0, 2.0, "1.41871866254525"))
    return _firing(NERVE, rest, ends, **numbers)


def axon() -> list[BenchmarkRow]:
    """Rows of the squid axon: currents between which it fires again and again."""
    v, m, h, n, current = symbols("v m h n current")
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
    units = {"current": "uA/cm2", "v": "mV"}
    system = system_of("axon", [v, m, h, n], [current], [flow, *gates], units=units)
    rest = system.steady("current", guess={"v": 0.01, "m": 0.05, "h": 0.6, "n": 0.32, "current": 0})
    ends = ((9.5, 10.0, "9.779337995393"), (154.0, 155.0, "154.526333665808"))
    return _firing(AXON, rest, ends, unit=units["current"])


def _firing(
    about: Source,
    rest: Family,
    ends: tuple[tuple[float, float, str], ...],
    unit: str = "",
    **numbers: Any,
) -> list[BenchmarkRow]:
    """Rows of both currents at which a nerve's rest changes."""
    rows: list[BenchmarkRow] = []
    for (low, high, reference), word in zip(ends, ("begins", "ceases"), strict=True):
        change = threshold(rest, low, high, **numbers)
        quantity = f"current at which firing {word}"
        rows.append(at_threshold(about, quantity, reference, change, unit=unit))
    return rows


def _phase(name: str, end: str) -> System:
    """The mass while it slips, or sticks; its run ends where its condition reaches zero."""
    x, u, belt, rest, sliding = symbols(" ".join(["x", "u", *MASS]))
    pull, ahead = x - sliding, belt - u
    # positive where the belt is ahead or the spring pulls forwards: a + b + sqrt(a² + b²), smooth
    slips = pull + ahead + ca.sqrt(pull**2 + ahead**2)
    rates, positive = {
        "slip": ([u, -pull], slips),
        "stick": ([belt, ca.SX(0)], rest - x),
    }[name]
    limit = Condition(positive, end)
    return system_of(name, [x, u], [belt, rest, sliding], rates, conditions=(limit,))


def stick_slip() -> list[BenchmarkRow]:
    """Row of the mass on a belt: the period of its cycle, from one run of each phase."""
    start = {"x": MASS["rest"], "u": MASS["belt"]}
    slip = simulate(_phase("slip", "the belt catches it"), MASS, start, 20.0, tolerance=1e-13)
    caught = {"x": float(slip.x[-1]), "u": float(slip.u[-1])}
    stick = simulate(_phase("stick", "the spring wins"), MASS, caught, 20.0, tolerance=1e-13)
    period = float(slip.end_time) + float(stick.end_time)
    return [compared(BELT, "period of sticking and slipping", "8.9026054078145", period)]
