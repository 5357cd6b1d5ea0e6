"""Tables and splines in equations: SciPy's values and slopes, fractions, planted boundaries."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from itertools import pairwise
from typing import Any

import casadi as ca
import numpy as np
import pytest
import scipy.interpolate as si
import sympy as sm
from numpy.typing import NDArray

import stability as st
from stability.algebra.number_types import Algebra
from stability.algebra.program import Program
from stability.systems.tabulated import Tabulated

X = np.array([-2.0, -1.0, 0.0, 0.3, 1.7, 3.0])
Y = np.array([1.0, 2.0, -1.0, 0.5, 0.25, 3.0])
Table = Callable[[NDArray[np.float64], NDArray[np.float64]], Any]

KINDS: dict[str, Table] = {
    "cubic": si.CubicSpline,
    "pchip": si.PchipInterpolator,
    "akima": si.Akima1DInterpolator,
    "quadratic": lambda x, y: si.make_interp_spline(x, y, k=2),
    "quintic": lambda x, y: si.make_interp_spline(x, y, k=5),
    "lines": lambda x, y: si.make_interp_spline(x, y, k=1),
    "lines of interp1d": lambda x, y: si.interp1d(x, y, fill_value="extrapolate"),
    "univariate": lambda x, y: si.InterpolatedUnivariateSpline(x, y),
    "slope of a cubic": lambda x, y: si.CubicSpline(x, y).derivative(),
    "with kinks": lambda x, y: si.CubicSpline(x, y).derivative(2),
}


def oscillator(damping: Any, p: ca.SX, x: ca.SX) -> st.Family:
    """ÿ = -y - damping · ẏ: stable where the damping is above zero."""
    system = st.System(
        "oscillator",
        x,
        p,
        ca.vertcat(x[1], -x[0] - damping * x[1]),
        states=("y", "v"),
        parameters=("p",),
    )
    return st.Family(system, "rest", at=("p",), held={"y": 0.0, "v": 0.0})


@pytest.mark.parametrize("kind", KINDS)
def test_values_are_those_of_scipy(kind: str) -> None:
    chance = np.random.default_rng(4)
    x = np.sort(chance.uniform(-3, 7, 9))
    theirs = KINDS[kind](x, chance.normal(size=9))
    ours = st.tabulated(theirs)
    places = np.concatenate([chance.uniform(x[0], x[-1], 300), x])
    beyond = np.array([x[0] - 0.5, x[-1] + 0.5])
    scale = np.abs(theirs(places)).max()
    assert ours(places) == pytest.approx(theirs(places), abs=1e-11 * scale)
    outside = ours(beyond)
    assert np.isnan(outside).all() != ours.extrapolates
    if ours.extrapolates:
        assert outside == pytest.approx(theirs(beyond), rel=1e-9)


def exact(table: Tabulated) -> Callable[[Fraction], Fraction]:
    """A table's graph over the rational numbers."""
    x = ca.SX.sym("x")
    rate = st.System("t", x, ca.SX(0, 1), table(x), states=("x",)).rhs
    program = Program(ca.Function("t", [x], [rate]))
    algebra = Algebra("fractions", Fraction, {"fabs": abs})
    return lambda at: program.run(algebra, [[at]])[0][0]


def test_straight_lines_are_exact_in_the_doubles_of_the_table() -> None:
    x, y = [0.1, 0.3, 0.7, 1e3], [1 / 3, 0.1, 1e-9, 2.0]
    value = exact(st.tabulated(x, y))
    for (a, b), (c, d) in zip(pairwise(x), pairwise(y), strict=True):
        for share in (Fraction(0), Fraction(1, 7), Fraction(1)):
            at = Fraction(a) + share * (Fraction(b) - Fraction(a))
            assert value(at) == Fraction(c) + share * (Fraction(d) - Fraction(c))


@pytest.mark.parametrize("kind", ["cubic", "pchip", "akima", "quadratic", "quintic", "univariate"])
def test_a_spline_has_one_slope_at_each_knot_over_the_rationals(kind: str) -> None:
    """One-sided difference quotients at 2⁻²⁰⁰ differ by the size of the step alone."""
    table = st.tabulated(KINDS[kind](X, Y))
    value, step = exact(table), Fraction(1, 2**200)
    assert not table.kinks
    for knot in map(Fraction, table.knots[1:-1]):
        above, below = (value(knot + step) - value(knot), value(knot) - value(knot - step))
        assert abs(above - below) / step < Fraction(1, 2**150)


def test_kinks_are_named_and_jumps_refused() -> None:
    assert st.tabulated(X, Y).kinks == tuple(X[1:-1])
    assert st.tabulated([0, 1, 2, 3], [0, 1, 2, 2]).kinks == (2.0,)
    jumping = si.PPoly(np.array([[1.0, 1.0], [0.0, 5.0]]), [0, 1, 2])
    for table, values, said in (
        (jumping, None, "jumps at 1; give one table for each side"),
        (si.CubicSpline(X, np.append(Y[:-1], Y[0]), bc_type="periodic"), None, "repeats itself"),
        (si.RegularGridInterpolator((X, X), np.outer(Y, Y)), None, "no function of one number"),
        (si.CubicSpline(X, np.column_stack([Y, Y])), None, "no function of one number"),
        ([1, 0], [2, 3], "each larger than the one before"),
        ([0, 1], [2, 3, 4], r"x and y have shapes \(2,\) and \(3,\)"),
        ([0, np.nan], [2, 3], "a finite number is needed"),
        ("a", None, "give arrays x and y, a CasADi interpolant"),
        (ca.interpolant("two", "linear", [X, X], np.outer(Y, Y).ravel()), None, "from one number"),
    ):
        with pytest.raises(st.StabilityError, match=said):
            st.tabulated(table, values)
    with pytest.raises(st.StabilityError, match="give one expression"):
        st.tabulated(X, Y)(ca.SX.sym("x", 2))


def planted(seed: int) -> tuple[Any, si.PPoly]:
    """A random table as a user has it, and as SciPy's piecewise polynomial."""
    chance = np.random.default_rng(seed)
    count = int(chance.integers(4, 10))
    x = np.sort(chance.choice(np.arange(-20, 20), count, replace=False) / 4)
    x = np.sort(chance.uniform(-5, 5, count)) if seed % 2 else x
    y = chance.normal(size=count)
    y = y if seed % 3 else np.round(y, 1)
    y[[0, -1]] += 0.03  # no zero at an end, which rounding might move out of the table
    lines = si.PPoly.from_spline(si.make_interp_spline(x, y, k=1))
    spline = si.CubicSpline(x, y)
    quadratic = si.make_interp_spline(x, y, k=2)
    made: list[tuple[Any, si.PPoly]] = [
        ((x, y), lines),
        ((spline,), spline),
        ((si.PchipInterpolator(x, y),), si.PchipInterpolator(x, y)),
        ((si.Akima1DInterpolator(x, y),), si.Akima1DInterpolator(x, y)),
        ((quadratic,), si.PPoly.from_spline(quadratic)),
        ((ca.interpolant("a", "linear", [x], y),), lines),
        ((ca.interpolant("a", "bspline", [x], y),), spline),
    ]
    return made[seed % len(made)]


def crossings(polynomial: si.PPoly, low: float, high: float) -> list[float]:
    """The zeros at which a piecewise polynomial changes sign, by SciPy."""
    zeros = np.unique(polynomial.roots(extrapolate=False))
    inside = zeros[np.isfinite(zeros) & (zeros > low + 1e-9) & (zeros < high - 1e-9)]
    apart = [v for i, v in enumerate(inside) if i == 0 or v - inside[i - 1] > 1e-9]
    return [float(v) for v in apart if polynomial(v - 1e-7) * polynomial(v + 1e-7) < 0]


def check_planted(seed: int) -> None:
    arguments, polynomial = planted(seed)
    table = st.tabulated(*arguments)
    low, high = table.knots[0], table.knots[-1]
    x, p = ca.SX.sym("x", 2), ca.SX.sym("p")
    family = oscillator(table(p), p, x)
    found = st.boundaries(family, axis=("p", low, high, 9))
    assert found.complete
    every = st.boundaries(family, axis=("p", low, high, 9), every=True)
    assert every.complete
    inner, crossed = (
        [b.value for b in points if low + 1e-9 < b.value < high - 1e-9] for points in (found, every)
    )
    assert inner == crossed == pytest.approx(crossings(polynomial, low, high), abs=1e-10)
    for at in (table.knots[1], low + 0.377 * (high - low)):
        spectrum = st.spectrum(family, at=at, certify=True)
        expected = np.roots([1, float(polynomial(at)), 1])
        assert spectrum.eigenvalues == pytest.approx(np.sort_complex(expected), abs=1e-9)


@pytest.mark.parametrize("seed", range(7))
def test_boundaries_of_a_tabled_coefficient_are_the_zeros_of_the_table(seed: int) -> None:
    check_planted(seed)


@pytest.mark.long
@pytest.mark.parametrize("seed", range(7, 207))
def test_boundaries_of_200_random_tables(seed: int) -> None:
    check_planted(seed)


def test_a_boundary_at_a_kink_is_proved_and_a_touch_is_none() -> None:
    x, p = ca.SX.sym("x", 2), ca.SX.sym("p")
    [edge] = st.boundaries(
        oscillator(st.tabulated([-1, 0, 1], [-1, 0, 3])(p), p, x), axis=("p", -1, 1, 5)
    )
    assert (edge.value, edge.crossing.word, edge.stable_below) == (0, "flutter", False)
    touching = oscillator(st.tabulated([-1, 0, 1], [1, 0, 3])(p), p, x)
    for ends in ((-1, 1), (0, 1), (-1, 0)):
        found = st.boundaries(touching, axis=("p", *ends, 5))
        assert (list(found), found.complete, found.touching) == ([], True, (0.0,))


def test_outside_the_table_there_is_no_member() -> None:
    x, p = ca.SX.sym("x", 2), ca.SX.sym("p")
    family = oscillator(st.tabulated(X, Y)(p), p, x)
    for at, said in ((3.01, "3 is less than p"), (-2.01, "p is less than -2")):
        with pytest.raises(st.StabilityError, match=said + ", where a table ends"):
            st.spectrum(family, at=at)
    assert [st.spectrum(family, at=end).verdict.word for end in (-2, 3)] == ["stable"] * 2
    system = st.System(
        "two",
        x,
        ca.vertcat(p, q := ca.SX.sym("q")),
        ca.vertcat(x[1], -q * x[0] - st.tabulated(X, Y)(p) * x[1]),
        states=("y", "v"),
        parameters=("p", "q"),
    )
    rest = st.Family(system, "rest", at=("p",), held={"y": 0.0, "v": 0.0})
    cells = st.stability_map(rest, x=("p", -3, 2.9, 60), y=("q", 0.5, 1, 3))
    inside = cells.p.values >= -2
    assert np.isnan(cells.abscissa.values[:, ~inside]).all()
    signs = np.sign(np.interp(cells.p.values[inside], X, Y))
    assert (np.sign(cells.abscissa.values[:, inside]) == -signs).all()


def spring(force: Any) -> st.Family:
    """ẍ = -force(x) - sin(p) ẋ at rest at x = 0, a knot."""
    x, p = ca.SX.sym("x", 2), ca.SX.sym("p")
    rates = ca.vertcat(x[1], -force(x[0]) - ca.sin(p) * x[1])
    system = st.System("spring", x, p, rates, states=("x", "v"), parameters=("p",))
    return st.Family(system, "rest", at=("p",), held={"x": 0.0, "v": 0.0})


def test_at_a_knot_in_a_state_a_smooth_spline_is_proved_and_a_kink_is_named() -> None:
    levels = np.array([-3.0, -1.0, 0.0, 0.5, 2.0, 4.0])
    for spline in (si.CubicSpline(X, levels), si.PchipInterpolator(X, levels)):
        slope = float(spline(0.0, 1))
        rest = spring(st.tabulated(spline))
        found = st.spectrum(rest, at=0.7, certify=True)
        expected = np.sort_complex(np.roots([1, np.sin(0.7), slope]))
        assert found.verdict is st.Verdict.STABLE
        assert found.eigenvalues == pytest.approx(expected, rel=1e-12)
        assert [b.value for b in st.boundaries(rest, axis=("p", -1, 1, 5))] == [0.0]
    with pytest.raises(
        st.StabilityError, match="next to x = 0 the verdict is stable below and stable"
    ):
        st.spectrum(spring(st.tabulated(X, levels)), at=0.7)
    levels[3:] *= -1
    with pytest.raises(
        st.StabilityError, match="x = 0 the verdict is stable below and unstable above"
    ):
        st.spectrum(spring(st.tabulated(X, levels)), at=0.7)


def test_members_pass_the_knots_of_a_smooth_spline() -> None:
    """The force p = t(x); damping x - 1/2 changes sign at the member x = 1/2."""
    spline = si.PchipInterpolator([-1, 0, 1, 2], [-1.0, 0.25, 1, 3])
    x, p = ca.SX.sym("x", 2), ca.SX.sym("p")
    rates = ca.vertcat(x[1], p - st.tabulated(spline)(x[0]) - (x[0] - 0.5) * x[1])
    system = st.System("loaded", x, p, rates, states=("x", "v"), parameters=("p",))
    loaded = system.steady("p", held={"v": 0.0}, guess={"x": 0.6, "p": 0.7})
    found = st.boundaries(loaded, axis=("p", 0.1, 0.9, 9))
    assert found.complete
    assert [b.value for b in found] == pytest.approx([float(spline(0.5))], rel=1e-14)


def test_a_jump_along_a_state_is_left_open_with_both_verdicts() -> None:
    x, p = ca.SX.sym("x", 2), ca.SX.sym("p", 0)
    rates = ca.vertcat(x[1], ca.if_else(x[0] > 1, -1, 2) * x[1])
    system = st.System("jump", x, p, rates, states=("x", "v"))
    family = st.Family(system, "line", at=("x",), held={"v": 0.0})
    with pytest.warns(st.StabilityWarning, match="not complete"):
        found = st.boundaries(family, axis=("x", 0, 2, 9))
    [part] = found.unresolved
    assert part.low < 1 < part.high and not found
    assert part.reason.endswith(
        "the verdict differs on the two sides: unstable below, stable above."
    )


@pytest.mark.parametrize("kind", ["linear", "bspline"])
def test_interpolants_of_casadi_are_read_from_sx_and_mx(kind: str) -> None:
    one, two = (ca.interpolant("same", kind, [X], y) for y in (Y, 3 * Y[::-1]))
    systems = []
    for symbol in (ca.SX, ca.MX):
        x, p = symbol.sym("x", 2), symbol.sym("p")
        rates = ca.vertcat(x[1] - one(2 * p), -two(x[0]) - one(p) * two(x[1] * p))
        function = ca.Function("f", [x, p], [rates], ["x", "p"], ["rates"])
        systems.append(st.System.from_function(function))
    x, p = ca.SX.sym("x", 2), ca.SX.sym("p")
    systems.append(
        st.System(
            "f", x, p, ca.SX(function.call([x, p])[0]), states=("x_0", "x_1"), parameters=("p",)
        )
    )
    chance = np.random.default_rng(3)
    for _ in range(20):
        place = chance.uniform(-1.4, 1.4, 2), [chance.uniform(-1, 1.4)]
        expected = np.array(function(*place)).ravel()
        for system in systems:
            assert system.rates(*place) == pytest.approx(expected, rel=1e-12, abs=1e-12)


def test_tables_in_sympy_are_the_same_system() -> None:
    y, v, p = sm.symbols("y v p")
    for table in (st.tabulated(X, Y), st.tabulated(si.CubicSpline(X, Y))):
        system = st.System.from_sympy({y: v, v: -y - table(p) * v}, parameters=[p])
        family = st.Family(system, "rest", at=("p",), held={"y": 0, "v": 0})
        own = oscillator(table(q := ca.SX.sym("p")), q, ca.SX.sym("x", 2))
        axis = ("p", -2, 3, 9)
        values = [[b.value for b in st.boundaries(f, axis=axis)] for f in (family, own)]
        assert values[0] == pytest.approx(values[1], rel=1e-15) and values[0]
        if not table.extrapolates:
            with pytest.raises(st.StabilityError, match="where a table ends"):
                st.spectrum(family, at=3.5)


def test_a_swing_equation_with_a_saturation_curve_has_the_spectrum_of_scipy() -> None:
    """E' behind a reactance, δ and its rate; the field drives E through a tabled saturation."""
    from scipy.optimize import fsolve

    curve = si.PchipInterpolator([0, 0.8, 1.0, 1.2, 1.4], [0, 0.8, 1.05, 1.4, 2.0])
    x, p = ca.SX.sym("x", 3), ca.SX.sym("p", 2)
    delta, rate, flux = ca.vertsplit(x)
    power = flux * ca.sin(delta) / 0.6
    field = (p[1] - st.tabulated(curve)(flux) - 0.4 * (flux - ca.cos(delta))) / 5
    rates = ca.vertcat(rate, (p[0] - power - 0.1 * rate) / 0.03, field)
    swing = st.System(
        "swing", x, p, rates, states=("delta", "rate", "flux"), parameters=("power", "field")
    )
    box = {"delta": (0, 1.5), "rate": (-1, 1), "flux": (0.1, 1.4)}
    [state] = swing.equilibria(box, power=0.8, field=1.5)

    def still(z: NDArray[np.float64]) -> list[float]:
        return [
            0.8 - z[1] * np.sin(z[0]) / 0.6,
            1.5 - float(curve(z[1])) - 0.4 * (z[1] - np.cos(z[0])),
        ]

    d, e = fsolve(still, [0.5, 1.1], xtol=1e-14)
    assert [state["delta"], state["flux"]] == pytest.approx([d, e], rel=1e-10)
    jacobian = np.array(
        [
            [0, 1, 0],
            [-e * np.cos(d) / 0.018, -0.1 / 0.03, -np.sin(d) / 0.018],
            [-0.4 * np.sin(d) / 5, 0, (-float(curve(e, 1)) - 0.4) / 5],
        ]
    )
    family = swing.steady(
        ("power", "field"),
        held={"rate": 0.0},
        guess={"delta": d, "flux": e, "power": 0.8, "field": 1.5},
    )
    spectrum = st.spectrum(family, at=[0.8, 1.5], certify=True)
    assert spectrum.verdict is st.Verdict.STABLE
    assert spectrum.eigenvalues == pytest.approx(
        np.sort_complex(np.linalg.eigvals(jacobian)), rel=1e-8
    )


def test_a_rotor_whose_bearing_is_tabled_over_speed_has_the_threshold_of_numpy() -> None:
    """A Jeffcott rotor: the cross stiffness of the bearing is interpolated over the speed."""
    from scipy.optimize import brentq

    speeds = np.array([50.0, 100, 200, 400, 600])
    cross = si.PchipInterpolator(speeds, [2e4, 6e4, 2.2e5, 7e5, 1.4e6])
    damping = si.PchipInterpolator(speeds, [1500.0, 1300, 1100, 950, 900])
    x, w = ca.SX.sym("x", 4), ca.SX.sym("w")
    q, c = st.tabulated(cross)(w), st.tabulated(damping)(w)
    mass, stiff = 10.0, 1e6
    rates = ca.vertcat(
        x[2],
        x[3],
        (-stiff * x[0] - q * x[1] - c * x[2]) / mass,
        (-stiff * x[1] + q * x[0] - c * x[3]) / mass,
    )
    rotor = st.System("rotor", x, w, rates, states=("x", "y", "u", "v"), parameters=("speed",))
    centred = st.Family(rotor, "centred", at=("speed",), held=dict.fromkeys(rotor.states, 0.0))
    [edge] = st.boundaries(centred, axis=("speed", 50, 600, 12))

    def growth(speed: float) -> float:
        k, d = float(cross(speed)), float(damping(speed))
        block = np.array([[-stiff, -k], [k, -stiff]]) / mass
        matrix = np.block([[np.zeros((2, 2)), np.eye(2)], [block, -d / mass * np.eye(2)]])
        return float(np.linalg.eigvals(matrix).real.max())

    assert edge.value == pytest.approx(brentq(growth, 60, 590, xtol=1e-11), rel=1e-9)
    assert edge.crossing.word == "flutter" and edge.stable_below
