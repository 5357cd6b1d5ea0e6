"""Table of values that other codes print of models of their own, recomputed with bounds."""

from __future__ import annotations

import warnings
from typing import Any, NamedTuple

import casadi as ca
from flint import arb

from ..algebra.number_types import balls, precision, upper
from ..algebra.program import Program
from ..base.citation import cited
from ..base.errors import StabilityWarning
from ..boundary.brackets import Crossing
from ..boundary.changes import boundaries
from ..boundary.hopf import CycleBirth, hopf
from ..boundary.two_parameters.point_records import PointKind
from ..boundary.two_parameters.points import codimension_two
from ..systems.system import System
from .benchmarks.bicycle import BENCHMARK, bicycle
from .benchmarks.row import PUBLISHED, QUOTED, BenchmarkRow, Source, at_zero, symbols, system_of
from .printed import Value, of_printed_values, printed_row
from .table import About, Standing

BITS = 120
"""Working precision of a parameter at a proved member."""
RECALLED = "recalled, the print not at hand"
"""Origin of a number that is known from memory alone."""

REACTION = Source("reaction A → B", "AUTO-07p, demo ab, doc/tutorial.tex", QUOTED)
CONTROL = Source(
    "adaptive control, β = 1",
    "MatCont, testadapt, as kept by JaxCont, MC-EQ-003_events.csv",
    QUOTED,
)
LORENZ = Source("Lorenz, σ = 10, β = 8/3", "AUTO-07p, doc/auto.tex", PUBLISHED)
OXIDATION = Source("CO oxidation", "BifurcationKit.jl, test/hopf_codim_2/COModel.jl", PUBLISHED)
WINDS = Source(
    "extended Lorenz-84, T = 0.04", "BifurcationKit.jl, test/hopf_codim_2/lorenz84.jl", PUBLISHED
)
BAZYKIN = Source("Bazykin, d = 0", "log of AUTO in a course; model: Yu. A. Kuznetsov", QUOTED)
SKATE = Source(
    "two-mass-skate bicycle", "parameters: BicycleParameters, data/bicycles/Tms", RECALLED
)
SECTION = Source(
    "typical section in steady flow", "Hodges & Pierce, in the tests of AeroBeams.jl", QUOTED
)

CUSP = (
    "the source tests its value to a relative 1e-4; Newton's method of 40 digits on the equations "
    "of a cusp agrees with the recomputed value"
)


class SteadyCurve(NamedTuple):
    """Steady states along a curve in closed form."""

    system: System
    """The system by the coordinate of the curve, its states counted from the steady state."""
    at: ca.SX
    """The coordinate."""
    parameter: ca.SX
    """The parameter at a member."""


def curve(
    name: str,
    rates: list[ca.SX],
    members: dict[ca.SX, ca.SX],
    parameter: tuple[ca.SX, ca.SX],
    at: ca.SX,
) -> SteadyCurve:
    """The curve of steady states `members` of `rates`, at the parameter's value there."""
    states = [ca.SX.sym(x.name()) for x in members]
    shifted = [value + x for value, x in zip(members.values(), states, strict=True)]
    old, new = ca.vertcat(*members, parameter[0]), ca.vertcat(*shifted, parameter[1])
    moved = ca.vertsplit(ca.substitute(ca.vertcat(*rates), old, new))
    return SteadyCurve(system_of(name, states, [at], moved), at, parameter[1])


def _parameter(branch: SteadyCurve, member: Value) -> Value:
    """The parameter at a member, in balls."""
    program = Program(ca.Function("parameter", [branch.at], [branch.parameter]))
    with precision(BITS):
        [[ball]] = program.run(balls(), [[arb(*member)]])
        return float(ball), float(upper(abs(ball - arb(float(ball)))))


def hopf_points(branch: SteadyCurve, low: float, high: float) -> list[Value]:
    """The parameter where a pair crosses, with its bound, in the order of the curve."""
    name = branch.at.name()
    changes = boundaries(at_zero(branch.system, "curve", name), axis=(name, low, high, 9))
    pairs = [b for b in changes if b.crossing is Crossing.FLUTTER]
    return [_parameter(branch, (b.value, b.error)) for b in pairs]


def folds(branch: SteadyCurve, low: float, high: float) -> list[Value]:
    """The parameter at each fold, with its bound: every zero of its slope along the curve."""
    name, slope = branch.at.name(), ca.jacobian(branch.parameter, branch.at)
    slopes = System("slope", branch.at, ca.SX(0, 1), slope, states=(name,))
    zeros = slopes.equilibria({name: (low, high)})
    members = list(zip(zeros.states[:, 0].tolist(), zeros.errors[:, 0].tolist(), strict=True))
    for x, _ in members:
        at_zero(branch.system, "curve", name).member([x], [])  # refuses what is not steady
    return [_parameter(branch, member) for member in members]


# --- models ---


def reaction() -> list[BenchmarkRow]:
    """Rows of the reaction: both folds and the Hopf point."""
    u, w, p, m = symbols("u w p m")
    made = p * (1 - u) * ca.exp(w)
    value = m * ca.exp(-14 * m / 3) / (1 - m)
    branch = curve(
        "reaction", [-u + made, -3 * w + 14 * made], {u: m, w: 14 * m / 3}, (p, value), m
    )
    first, second = folds(branch, 0.05, 0.95)
    [pair] = hopf_points(branch, 0.05, 0.95)
    values = (("first fold", ".1057390"), ("second fold", ".08893185"), ("Hopf point", ".1308998"))
    return [
        printed_row(REACTION, f"p at the {what}", reference, value)
        for (what, reference), value in zip(values, (first, second, pair), strict=True)
    ]


def control() -> list[BenchmarkRow]:
    """Rows of the adaptive control: Hopf point, frequency, first Lyapunov coefficient."""
    x, v, a, alpha = symbols("x v a alpha")
    system = system_of("control", [x, v, a], [alpha], [v, a, -alpha * a - v - x + x**2])
    [birth] = hopf(at_zero(system, "rest", "alpha"), axis=("alpha", 0.5, 2.0, 9))
    assert isinstance(birth, CycleBirth)
    soft = "first Lyapunov coefficient"
    return [
        printed_row(CONTROL, "α at the Hopf point", "0.999997742302781", (birth.at, birth.error)),
        printed_row(
            CONTROL, "its frequency", "1.00000056442399", (birth.frequency, birth.frequency_error)
        ),
        printed_row(
            CONTROL, soft, "-0.299999881265773", (birth.coefficient, birth.coefficient_error)
        ),
    ]


def lorenz() -> list[BenchmarkRow]:
    """Row of Lorenz's equations: the Hopf point."""
    x, y, z, r = symbols("x y z r")
    system = system_of(
        "Lorenz", [x, y, z], [r], [10 * (y - x), r * x - y - x * z, x * y - 8 * z / 3]
    )
    family = system.steady("r", guess={"x": 7.0, "y": 7.0, "z": 20.0, "r": 21.0})
    [point] = boundaries(family, axis=("r", 14.0, 30.0, 9))
    return [printed_row(LORENZ, "r at the Hopf point", "24.7368", (point.value, point.error))]


def oxidation() -> list[BenchmarkRow]:
    """Rows of the oxidation: Hopf points at k = 2/5, double zeros, the cusp."""
    x, y, s, q, k, r = symbols("x y s q k r")
    z = 1 - x - y - s
    states, fast = [x, y, s], [5 * z**2 - 2 * x**2 - 10 * x * y, q * z - y / 10 - 10 * x * y]
    low = 10 / (5 * r**2 + 35 * r + 8)  # r = z/x
    free, slow = r * low, 5 * r * low / 2
    high = 1 - low - free - slow
    value = (high / 10 + 10 * low * high) / free
    rates = [*fast, 27 * (z - 2 * s / 5) / 400]
    branch = curve("oxidation", rates, {x: low, y: high, s: slow}, (q, value), r)
    second, first = hopf_points(branch, 1.0, 20.0)
    rows = [
        printed_row(OXIDATION, "q2 at a Hopf point, k = 0.4", reference, value)
        for reference, value in (("1.05158367", first), ("1.04099606", second))
    ]
    system = system_of("oxidation", states, [q, k], [*fast, 27 * (z - k * s) / 400])
    guess = {"x": 0.001137, "y": 0.891483, "s": 0.062345, "q": 1.0, "k": 0.4}
    family = system.steady(("q", "k"), guess=guess)
    with warnings.catch_warnings():  # the search is not complete, and what it lists is proved
        warnings.simplefilter("ignore", StabilityWarning)
        points = codimension_two(family, x=("q", 0.8, 2.0, 3), y=("k", 0.2, 1.2, 3))
    zeros = [p for p in points if p.kind is PointKind.DOUBLE_ZERO]
    printed = (("1.161199", "0.7223392465523879"), ("1.417628", "0.97139757"))
    for point, (q2, other) in zip(zeros, printed, strict=True):
        what = "at a double zero (Bogdanov-Takens)"
        rows.append(printed_row(OXIDATION, f"q2 {what}", q2, (point.x, point.x_error)))
        rows.append(printed_row(OXIDATION, f"k {what}", other, (point.y, point.y_error)))
    [cusp] = [p for p in points if p.kind is PointKind.CUSP]
    k_cusp = (cusp.y, cusp.y_error)
    return [*rows, printed_row(OXIDATION, "k at the cusp", "0.35665351", k_cusp, note=CUSP)]


def winds() -> list[BenchmarkRow]:
    """Rows of Lorenz-84: the ends of the bracket of its fold."""
    x, y, z, u, F, X = symbols("x y z u F X")
    size = (X - 1) ** 2 + X**2
    Y, Z, U = (1 - X) / (4 * size), X / (4 * size), 0.04 / (1.04 - 0.987 * X)
    value = X + 4 * (Y**2 + Z**2 + 0.987 * U**2)
    rates = [
        -(y**2) - z**2 - x / 4 + F / 4 - 0.987 * u**2,
        x * y - x * z - y + 0.25,
        x * y + x * z - z,
        -1.04 * u + 0.987 * u * x + 0.04,
    ]
    branch = curve("Lorenz-84", rates, {x: X, y: Y, z: Z, u: U}, (F, value), X)
    [fold] = folds(branch, 1.1, 2.0)
    ends = ("1.546648372620807", "1.5466483727182652")
    inside = float(ends[0]) < fold[0] - fold[1] and fold[0] + fold[1] < float(ends[1])
    status = f"{'agrees: inside' if inside else 'differs: outside'} the printed bracket"
    return [
        printed_row(
            WINDS, f"F at the fold, {end} end of its bracket", reference, fold, status=status
        )
        for end, reference in zip(("lower", "upper"), ends, strict=True)
    ]


def bazykin() -> list[BenchmarkRow]:
    """Rows of Bazykin's equations without crowding of the predator: both Hopf points."""
    x, y, a = symbols("x y a")
    eaten = x * y / (1 + a * x)
    system = system_of("Bazykin", [x, y], [a], [x - eaten - x**2 / 100, -y + eaten])
    family = system.steady("a", guess={"x": 2.0, "y": 2.0, "a": 0.5})
    points = boundaries(family, axis=("a", 0.005, 0.985, 9))
    return [
        printed_row(BAZYKIN, "a at a Hopf point", reference, (point.value, point.error))
        for reference, point in zip((".01020625", ".9797938"), points, strict=True)
    ]


def skate() -> list[BenchmarkRow]:
    """Row of the skate: the speed above which weave is stable."""
    numbers: dict[str, Any] = dict.fromkeys(BENCHMARK, 0.0) | {
        "w": 1.0,
        "lam": 0.0872664626,
        "g": 9.81,
    }
    numbers |= {"xB": 1.2, "zB": -0.4, "mB": 10.0, "xH": 1.02, "zH": -0.2, "mH": 1.0}
    numbers |= {"rR": 0.1, "rF": 0.1}  # no inertia spins: of no effect
    [weave] = boundaries(bicycle(), axis=("v", 1.0, 5.0, 9), **numbers)
    value = (weave.value, weave.error)
    return [printed_row(SKATE, "speed of weave", "2.841008324", value, unit="m/s")]


def section() -> list[BenchmarkRow]:
    """Rows of the typical section in steady flow: reduced speeds of flutter and divergence.

    a = -1/5, e = -1/10, μ = 20, r² = 6/25, σ = 2/5; lengths in semichords, rates in those of twist.
    """
    h, twist, dh, dtwist, V = symbols("h twist dh dtwist V")
    lift = V**2 / 10
    mass = ca.SX([[1, 0.1], [0.1, 0.24]])
    system = System.from_mass_matrix(
        "typical section",
        ca.vertcat(h, twist, dh, dtwist),
        V,
        mass=mass,
        forcing=-ca.vertcat(0.16 * h + lift * twist, (0.24 - 0.3 * lift) * twist),
        unknowns=("d_dh", "d_dtwist"),
        rates={"h": dh, "twist": dtwist},
        states=("h", "twist", "dh", "dtwist"),
        parameters=("V",),
    )
    [flutter] = boundaries(at_zero(system, "rest", "V"), axis=("V", 0.5, 2.5, 9))
    stiffness = System("stiffness", V, ca.SX(0, 1), 0.24 - 0.3 * lift, states=("V",))
    divergence = stiffness.equilibria({"V": (0.5, 3.5)})
    [value], [error] = divergence.states[0].tolist(), divergence.errors[0].tolist()
    return [
        printed_row(SECTION, "flutter", "1.843", (flutter.value, flutter.error)),
        printed_row(SECTION, "divergence, where the stiffness vanishes", "2.828", (value, error)),
    ]


TABLE = of_printed_values(
    "values that other codes print of their models: printed, recomputed, difference",
    (reaction, control, lorenz, oxidation, winds, bazykin, skate, section),
    about=About(
        "manual, test or log of a code for each model, named in its rows",
        "values of the rows that are marked `published`",
        "every value by this package, with a proved bound, from the model's equations",
        Standing.PARTLY,
        largest=2e-3,
    ),
    cites=cited(proofs=True),
    home=f"{__name__}:TABLE",
)
"""The table for the registry."""
