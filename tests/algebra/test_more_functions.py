"""expm1, log1p, asinh, acosh, atanh, hypot and atan2 in every number type, against mpmath."""

from typing import Any

import casadi as ca
import mpmath as mp
import numpy as np
import pytest
import sympy as sp
from flint import arb, arb_series, fmpq
from own_systems import system_of

import stability as st
from stability.algebra.exact.number_fields import EXACT, NotExact
from stability.algebra.number_types import (
    BY_OTHERS,
    MIXED,
    casadi_algebra,
    function_of,
    numpy_algebra,
    precision,
    sympy_algebra,
)
from stability.algebra.program import Program
from stability.algebra.running_error import TRACKED, RunningError
from stability.boundary.interval_search.taylor import series_algebra, terms
from stability.systems.graph.family_graph import rates_and_slopes

INSIDE = {
    "expm1": [(0.3,), (-1e-9,), (-4.0,)],
    "log1p": [(0.7,), (1e-9,), (-0.9,)],
    "asinh": [(0.4,), (-30.0,), (1e-8,)],
    "acosh": [(1.5,), (40.0,)],
    "atanh": [(0.4,), (-0.99,)],
    "hypot": [(0.3, -0.4), (0.0, 2.0)],
    "atan2": [(0.3, 0.5), (0.3, -0.5), (-2.0, 0.0), (0.0, 1.5), (-1e-3, -1.0)],
}


def truth(name: str, *x: Any) -> Any:
    return getattr(mp, name)(*(mp.mpf(v) for v in x))


@pytest.fixture(autouse=True)
def digits() -> Any:
    with mp.workdps(60), np.errstate(all="ignore"):
        yield


@pytest.mark.parametrize("name", INSIDE)
def test_doubles_agree_and_their_error_bounds_hold(name: str) -> None:
    for x in INSIDE[name]:
        wanted = truth(name, *x)
        plain = function_of(numpy_algebra().functions, name)(*map(np.float64, x))
        assert float(plain) == pytest.approx(float(wanted), rel=1e-15)
        exact = function_of(TRACKED.functions, name)(*(RunningError(np.float64(v), 0.0) for v in x))
        assert abs(exact.value - wanted) <= exact.error <= 1e-14 * (1 + abs(wanted))
        for seed in range(40):  # inherited errors: any exact argument within them
            rng = np.random.default_rng(seed)
            error = 10 ** rng.uniform(-12, -1, len(x)) * np.maximum(np.abs(x), 1e-3)
            moved = [
                mp.mpf(v) + e * rng.choice([-1, 1, rng.uniform(-1, 1)])
                for v, e in zip(x, error, strict=True)
            ]
            found = function_of(TRACKED.functions, name)(
                *(RunningError(np.float64(v), e) for v, e in zip(x, error, strict=True))
            )
            there = truth(name, *moved)
            if not mp.im(there) and np.isfinite(found.error):
                assert abs(found.value - there) <= 1.01 * found.error
            elif mp.im(there):
                assert not np.isfinite(found.error)


@pytest.mark.parametrize("name", INSIDE)
def test_balls_hold_the_value_and_those_of_other_functions_too(name: str) -> None:
    for x in INSIDE[name]:
        with precision(150):
            for found in (
                function_of(MIXED.functions, name)(*map(arb, x)),
                BY_OTHERS[name](MIXED.functions, *map(arb, x)),
            ):
                assert abs(mp.mpf(found.mid().str(50, radius=False)) - truth(name, *x)) < 1e-38
                assert found.rad() < 1e-36


def test_a_ball_across_the_jump_of_an_angle_has_no_value() -> None:
    for angle in (MIXED.functions["atan2"], series_algebra().functions["atan2"]):
        assert angle(arb(0, 1), arb(2)).is_finite()
        assert not angle(arb(0, 1), arb(-2)).is_finite()
    jumping = TRACKED.functions["atan2"](RunningError(0.0, 1e-9), RunningError(-1.0, 0.0))
    assert not np.isfinite(jumping.error)
    assert np.isnan(numpy_algebra().functions["atan2"](0.0, -1.0))


@pytest.mark.parametrize("name", INSIDE)
def test_power_series_are_those_of_mpmath(name: str) -> None:
    for x in INSIDE[name]:
        slopes = (0.7, -0.3)[: len(x)]

        def moved(t: Any, x: Any = x, slopes: Any = slopes) -> Any:
            return truth(name, *(mp.mpf(v) + mp.mpf(s) * t for v, s in zip(x, slopes, strict=True)))

        wanted = mp.taylor(moved, 0, 3)
        with precision(300), terms(4):
            found = function_of(series_algebra().functions, name)(
                *(arb_series([v, s]) for v, s in zip(x, slopes, strict=True))
            )
            for k, w in enumerate(wanted):
                assert abs(mp.mpf(found[k].mid().str(50, radius=False)) - w) < 1e-15 * (1 + abs(w))


@pytest.mark.parametrize("name", INSIDE)
def test_slopes_of_large_graphs_and_symbols_agree(name: str) -> None:
    for x in INSIDE[name]:
        s = ca.SX.sym("x", len(x))
        graph = Program(ca.Function("f", [s, ca.SX(0, 1)], [getattr(ca, name)(*ca.vertsplit(s))]))
        _, (slopes,) = rates_and_slopes(graph, casadi_algebra(), ca.vertsplit(s), [])
        for i in range(len(x)):
            slope = ca.Function("d", [s], [slopes[i]])(list(x)) if i in slopes else 0.0
            wanted = mp.diff(
                lambda *v: getattr(mp, name)(*v), x, tuple(int(j == i) for j in range(len(x)))
            )
            assert float(slope) == pytest.approx(float(wanted), rel=1e-9, abs=1e-12)
        symbolic = graph.run(sympy_algebra(), [[sp.Rational(v) for v in x], []])[0][0]
        assert sp.N(symbolic, 30) == pytest.approx(float(truth(name, *x)), rel=1e-14)


def test_exact_numbers_know_the_values_that_are_rational_and_no_other() -> None:
    f = EXACT.functions
    zero, one = fmpq(0), fmpq(1)
    for name, x in (("expm1", zero), ("log1p", zero), ("asinh", zero), ("acosh", one)):
        assert function_of(f, name)(x) == 0
        with pytest.raises(NotExact):
            function_of(f, name)(x + 1)
    assert function_of(f, "hypot")(fmpq(3), fmpq(-4)) == 5
    assert function_of(f, "atan2")(zero, one) == 0
    with pytest.raises(NotExact):
        function_of(f, "atan2")(one, one)
    with pytest.raises(ArithmeticError):
        function_of(f, "atan2")(zero, -one)


# --- in systems ---

X, V, C = (ca.SX.sym(n) for n in ("x", "v", "c"))


def rest(force: ca.SX, **held: float) -> st.Family:
    system = system_of("s", [X, V], [C], [V, force])
    return st.Family(system, "rest", ("c",), held={"x": 0.0, "v": 0.0} | held)


FORCES = {
    "expm1": -X - ca.expm1(C * V),
    "log1p": -X - ca.log1p(C * V),
    "asinh": -X - ca.asinh(C * V),
    "atanh": -X - ca.atanh(C * V),
    "acosh": -X - C * V * (1 + ca.acosh(1 + (X - V) ** 2 + 1)),
    "hypot": -X - C * V * ca.hypot(1, X),
    "atan2": -X - ca.atan2(C * V, 1 + X),
}


@pytest.mark.parametrize("name", FORCES)
def test_damping_by_each_function_has_its_boundary_where_c_vanishes(name: str) -> None:
    """λ² + c s λ + 1 with s > 0, the slope of the function at rest."""
    family = rest(FORCES[name])
    s = float(1 + mp.acosh(2)) if name == "acosh" else 1.0
    found = st.spectrum(family, at=0.5, certify=True)
    wanted = np.roots([1, 0.5 * s, 1])
    assert found.certified and found.verdict.word == "stable"
    assert sorted(found.eigenvalues.imag) == pytest.approx(sorted(wanted.imag), rel=1e-13)
    assert found.eigenvalues.real == pytest.approx(wanted.real, rel=1e-13)
    edges = st.boundaries(family, axis=("c", -1, 2, 5))
    assert edges.complete and [b.value for b in edges] == [0.0]


@pytest.mark.parametrize(
    "force",
    [
        -X - C * V + ca.hypot(X, V),
        -X - C * V - ca.atan2(V, X),
        -X - C * V - ca.atan2(V, -1 + X),
        -X - C * V - V * 0 - ca.acosh(1 + X * X),
    ],
)
def test_members_at_an_edge_of_a_function_are_refused(force: ca.SX) -> None:
    family = rest(force)
    with pytest.raises(st.StabilityError):
        st.spectrum(family, at=0.5, certify=True)


@pytest.mark.parametrize(
    ("force", "word"),
    [
        (ca.erf(V), "erf"),
        (ca.floor(X), "floor"),
        (ca.fmod(X, 2), "fmod"),
        (ca.copysign(X, V), "copysign"),
        (ca.remainder(X, 2), "remainder"),
    ],
)
def test_a_function_that_is_not_read_is_refused_by_its_name(force: ca.SX, word: str) -> None:
    with pytest.raises(st.StabilityError, match=f"uses (.*{word}).*smooth elementary .*asinh"):
        st.spectrum(rest(-X - C * V - force), at=0.5)


def test_a_motion_under_an_angle_and_a_distance_is_that_of_scipy() -> None:
    from scipy.integrate import solve_ivp

    force = -ca.hypot(X + 2, 0.5) + 2 - ca.atan2(V, 2 + X) - ca.asinh(X) - ca.expm1(V) * C
    system = rest(force).system
    run = st.simulate(system, {"c": 0.3}, {"x": 0.3, "v": 0.1}, 3.0)

    def rates(_: float, y: Any) -> list[float]:
        x, v = y
        return [
            v,
            -np.hypot(x + 2, 0.5) + 2 - np.arctan2(v, 2 + x) - np.arcsinh(x) - np.expm1(v) * 0.3,
        ]

    wanted = solve_ivp(rates, (0, 3), [0.3, 0.1], rtol=1e-12, atol=1e-12, method="DOP853").y[:, -1]
    assert [float(run[n][-1]) for n in ("x", "v")] == pytest.approx(wanted, rel=1e-8)
