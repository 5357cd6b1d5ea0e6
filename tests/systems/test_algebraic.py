"""Algebraic equations of index 1: spectra are the pencils' finite ones, boundaries the analytic.

The oracle is `scipy.linalg.eig(A, M)` of the whole Jacobian with a singular M, which solves no
algebraic equation and forms no Schur complement.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from typing import Any

import casadi as ca
import mpmath
import numpy as np
import pytest
import scipy.linalg as sl

import stability as st
from stability.base.types import Floats

X, Y, P, Q = (ca.SX.sym(n) for n in "xypq")
SIGN = {"stable": -1, "unstable": 1}


def semi_explicit(f: Any, g: Any, x: Any = X, y: Any = Y, p: Any = P, **names: Any) -> st.System:
    default = {"states": ("x", "y"), "parameters": ("p",), "algebraic": ("y",)}
    return st.System("equations", ca.vertcat(x, y), p, ca.vertcat(f, g), **(default | names))


def finite_values(system: st.System, state: Floats, p: Any) -> Floats:
    """The finite eigenvalues of the pencil, in order of their real parts."""
    whole = ca.Function("jacobian", [system.x, system.p], [ca.jacobian(system.rhs, system.x)])
    mass = np.diag([float(n not in system.algebraic) for n in system.states])
    values = sl.eig(np.array(whole(state, p)), mass, right=False, homogeneous_eigvals=True)
    alpha, beta = values
    fine = np.abs(beta) > 1e-9 * np.abs(alpha)
    found = np.sort_complex(alpha[fine] / beta[fine])
    assert len(found) == int(mass.sum())
    return np.asarray(found)


def random_system(rng: np.random.Generator) -> tuple[st.System, Floats, float]:
    """1 to 3 rates and 1 or 2 algebraic equations with a planted steady motion."""
    n, m = int(rng.integers(1, 4)), int(rng.integers(1, 3))
    z, p = ca.SX.sym("z", n + m), ca.SX.sym("p")
    state, value = rng.uniform(-1, 1, n + m).round(3), round(float(rng.uniform(-1, 1)), 3)
    functions: list[Callable[[Any], Any]] = [ca.sin, ca.exp, ca.tanh, lambda s: s**3, ca.cos]
    rows = []
    for _ in range(n + m):
        row: Any = float(rng.uniform(-1, 1)) * p
        for i in range(n + m):
            row += float(rng.uniform(-2, 2)) * z[i]
        for _ in range(3):
            i, j = rng.integers(0, n + m, 2)
            pick = functions[int(rng.integers(len(functions)))]
            row += float(rng.uniform(-1, 1)) * pick(z[i]) * (z[j] if rng.random() < 0.5 else 1)
        rows.append(row)
    rhs = ca.vertcat(*rows)
    rhs -= ca.Function("rhs", [z, p], [rhs])(state, value)  # the planted state is steady
    names = tuple(f"z{i}" for i in range(n + m))
    system = st.System("random", z, p, rhs, states=names, parameters=("p",), algebraic=names[n:])
    return system, state, value


@pytest.mark.few(12)
@pytest.mark.parametrize("seed", range(200))
def test_spectra_of_random_equations_are_those_of_their_pencils(seed: int) -> None:
    system, state, value = random_system(np.random.default_rng(seed))
    family = system.steady("p", guess=dict(zip(system.states, state, strict=True)) | {"p": value})
    found = st.spectrum(family, at=value)
    assert found.states == pytest.approx(state, abs=1e-9)
    values = finite_values(system, found.states, value)
    size = np.abs(values).max()
    apart = np.abs(found.eigenvalues[:, None] - values[None, :])
    assert max(*apart.min(axis=0), *apart.min(axis=1)) <= 1e-7 * size
    if abs(values.real.max()) > 1e-6 * size:
        assert SIGN[found.verdict.word] == np.sign(values.real.max())


@pytest.mark.few(5)
@pytest.mark.filterwarnings("ignore::stability.StabilityWarning")
@pytest.mark.parametrize("seed", range(60))
def test_boundaries_of_random_equations_part_the_signs_of_their_pencils(seed: int) -> None:
    system, state, value = random_system(np.random.default_rng(1000 + seed))
    family = system.steady("p", guess=dict(zip(system.states, state, strict=True)) | {"p": value})
    low, high = value - 0.2, value + 0.2
    try:
        found = st.boundaries(family, axis=("p", low, high, 9))
    except st.StabilityError as error:  # the family ends at a fold within the axis
        assert "no member" in str(error)
        return
    fence = [low, *(b.value for b in found), high]
    signs = []
    for a, b in pairwise(fence):
        inside = [v for v in np.linspace(a, b, 9)[1:-1] if not _open(found, float(v))]
        leads = [finite_values(system, family.member([v], []), v).real.max() for v in inside]
        signs.append({float(np.sign(lead)) for lead in leads})
    if found.complete:
        assert all(len(one) == 1 for one in signs)
        assert all(a != b for a, b in pairwise(signs))


def _open(found: Any, value: float) -> bool:
    return any(u.low <= value <= u.high for u in found.unresolved)


# --- a machine on a line, and its load of constant power ---


def machine() -> st.System:
    """ω' = Pm - V sin δ - D ω, and reactive power V cos δ - V² = Q at the load, with E = X = 1."""
    delta, omega, v = ca.vertsplit(ca.SX.sym("x", 3))
    pm, d, q = ca.vertsplit(ca.SX.sym("p", 3))
    return st.System(
        "machine",
        ca.vertcat(delta, omega, v),
        ca.vertcat(pm, d, q),
        ca.vertcat(omega, pm - v * ca.sin(delta) - d * omega, v * ca.cos(delta) - v**2 - q),
        states=("delta", "omega", "V"),
        parameters=("Pm", "D", "Q"),
        algebraic=("V",),
    )


def stiffness(delta: Any, q: Any) -> tuple[Any, Any]:
    """Power P(δ) on the upper voltage, and its slope, by V solved from its quadratic equation."""
    cos, sin = mpmath.cos(delta), mpmath.sin(delta)
    root = mpmath.sqrt(cos**2 - 4 * q)
    v = (cos + root) / 2
    return v * sin, v * cos - sin * (sin + sin * cos / root) / 2


def operated(**guess: float) -> st.Family:
    given = {"delta": 0.4, "omega": 0.0, "V": 0.8, "Pm": 0.3, "D": 0.1, "Q": 0.1} | guess
    return machine().steady("Pm", guess=given)


def test_a_machine_oscillates_at_the_rate_of_its_stiffness() -> None:
    family = operated()
    [edge] = st.boundaries(family, axis=("D", -1, 1, 9), at=0.3, Q=0.1)
    with mpmath.workdps(30):
        delta = mpmath.findroot(lambda a: stiffness(a, mpmath.mpf(0.1))[0] - mpmath.mpf(0.3), 0.4)
        rate = mpmath.sqrt(stiffness(delta, mpmath.mpf(0.1))[1])
    assert (edge.value, edge.crossing.word) == (0.0, "flutter")
    assert edge.frequency == pytest.approx(float(rate), rel=1e-12)
    found = st.spectrum(family, at=0.3, D=0.2, Q=0.1, certify=True)
    root = np.sqrt(complex(0.01 - float(rate) ** 2))
    assert found.eigenvalues == pytest.approx([-0.1 - root, -0.1 + root], abs=1e-12)
    assert (found.verdict.word, found.nonlinear.word) == ("stable", "asymptotic")
    assert "one zero each for the algebraic variables V" in found.reason


def test_a_machine_ends_where_its_power_is_largest() -> None:
    """Beyond the fold dP/dδ = 0 a map has no member, and nowhere before it another boundary."""
    with mpmath.workdps(30):
        last = mpmath.findroot(lambda a: stiffness(a, mpmath.mpf(0.1))[1], 0.6)
        most = float(stiffness(last, mpmath.mpf(0.1))[0])
    m = st.stability_map(operated(), x=("Pm", 0.1, 0.6, 51), y=("D", 0.05, 0.5, 4), Q=0.1)
    there = m.verdict.values == 1
    assert (there == (m.Pm.values < most)[None, :]).all()
    assert (m.verdict.values[~there] == 4).all()
    assert not len(m.boundary_point)


def test_every_equilibrium_of_a_machine_is_found_with_its_verdict() -> None:
    box = {"delta": (0.0, 1.2), "omega": (-1.0, 1.0), "V": (0.05, 1.2)}
    found = machine().equilibria(box, Pm=0.3, D=0.2, Q=0.1)
    assert found.complete
    for state, verdict in zip(found.states, found.verdicts, strict=True):
        values = finite_values(machine(), state, [0.3, 0.2, 0.1])
        assert SIGN[verdict.word] == np.sign(values.real.max())
    assert {v.word for v in found.verdicts} == {"stable", "unstable"}


# --- a bead on a wire y² = 1 + x² that turns about its vertical axis ---


def bead() -> st.Family:
    x, v, y = ca.vertsplit(ca.SX.sym("x", 3))
    g, spin, c = ca.vertsplit(ca.SX.sym("p", 3))
    system = st.System(
        "bead",
        ca.vertcat(x, v, y),
        ca.vertcat(g, spin, c),
        ca.vertcat(v, spin**2 * x - g * x / y - c * v, y**2 - 1 - x**2),
        states=("x", "v", "y"),
        parameters=("g", "spin", "c"),
        algebraic=("y",),
    )
    return st.Family(
        system, "lowest", at=("spin",), held={"x": 0, "v": 0}, unknown={"y": 1.1}, equations=("y",)
    )


def test_a_bead_leaves_the_lowest_place_at_the_analytic_rate() -> None:
    found = st.boundaries(bead(), axis=("spin", 0.1, 9, 9), g=9.0, c=0.3)
    assert [(b.value, b.crossing.word, b.stable_below) for b in found] == [(3.0, "static", True)]
    assert found.complete
    m = st.stability_map(bead(), x=("spin", 0.1, 5, 40), y=("g", 1, 9, 30), c=0.3)
    assert (m.verdict.values == np.where(m.spin.values**2 < m.g.values[:, None], 1, 2)).all()
    assert m.boundary_spin.values**2 == pytest.approx(m.boundary_g.values, rel=1e-12)
    said = str(st.conditions(bead()))
    assert "g" in said and "spin" in said


# --- where index 1 is lost ---


def passing(g: Any) -> st.Family:
    """Members with y = p, and with the rate 1/(∂g/∂y): negative, then positive."""
    return semi_explicit(Y - P, g).steady("p", guess={"x": 0.3, "y": -0.5, "p": -0.5})


@pytest.mark.parametrize("every", [False, True])
@pytest.mark.parametrize("g", [X - Y**2, X - ca.exp(Y) + Y], ids=["algebraic", "exponential"])
def test_a_singularity_induced_point_is_named(g: Any, every: bool) -> None:
    family = passing(g)
    with pytest.warns(st.StabilityWarning, match="singularity-induced"):
        found = st.boundaries(family, axis=("p", -0.25, 0.5, 4), every=every)
    [part] = found.unresolved
    assert not found.points
    assert part.low <= 0 <= part.high < 1e-12
    assert "changes its sign here (a singularity-induced point)" in part.reason
    assert [st.spectrum(family, at=p).verdict.word for p in (-0.5, 0.5)] == ["stable", "unstable"]
    with pytest.raises(st.StabilityError, match="do not determine y to first order"):
        st.spectrum(family, at=0.0)


def test_a_cell_at_a_singularity_induced_point_has_no_member() -> None:
    system = semi_explicit(
        Y - P, X - ca.exp(Y) + Y + 0 * Q, p=ca.vertcat(P, Q), parameters=("p", "q")
    )
    family = system.steady("p", guess={"y": -0.5, "p": -0.5, "q": 0.5})
    m = st.stability_map(family, x=("p", -1, 1, 5), y=("q", 0, 1, 2))
    assert m.verdict.values.tolist() == [[1, 1, 4, 2, 2]] * 2


def test_a_factor_that_cancels_loses_index_1_all_the_same() -> None:
    """The rate -q - 1 has no pole at p = 0, where y is not determined."""
    system = semi_explicit(-Q * X - Y, P * (Y - X), p=ca.vertcat(P, Q), parameters=("p", "q"))
    family = st.Family(system, "rest", at=("p",), held={"x": 0, "y": 0})
    with pytest.warns(st.StabilityWarning, match="singularity-induced"):
        found = st.boundaries(family, axis=("p", -1, 1, 11), q=0.2)
    assert [(u.low, u.high) for u in found.unresolved] == [(0.0, 0.0)]
    m = st.stability_map(family, x=("p", -1, 1, 41), y=("q", -2, 1, 40))
    assert set(m.verdict.values[:, 20]) == {4}
    assert st.boundaries(family, axis=("p", 0.1, 1, 11), q=0.2).complete


def test_an_index_above_1_is_refused() -> None:
    with pytest.raises(st.StabilityError, match="open for all numbers .index above 1."):
        semi_explicit(Y - X, X - P)
    twice = ca.SX.sym("y", 2)
    system = st.System(
        "twice",
        ca.vertcat(X, twice),
        P,
        ca.vertcat(twice[0] - X * P, *[(k * (twice[0] + twice[1] - X)) for k in (1, 2)]),
        states=("x", "a", "b"),
        parameters=("p",),
        algebraic=("a", "b"),
    )
    family = st.Family(system, "rest", at=("p",), held=dict.fromkeys(system.states, 0))
    with pytest.raises(st.StabilityError, match="an index above 1"):
        st.spectrum(family, at=1.0)


# --- how equations are given, and what takes rates alone ---


def test_a_singular_mass_matrix_gives_algebraic_equations() -> None:
    z = ca.vertcat(X, Y)
    whole = ca.vertcat(P - Y - Y**3, -X + Y)
    mass = ca.SX(2, 2)
    mass[1, 0] = 2 + P**2
    given: dict[str, Any] = {"unknowns": ("d_x", "d_y"), "rates": {}, "states": ("x", "y")}
    system = st.System.from_mass_matrix("m", z, P, mass, whole, parameters=("p",), **given)
    assert system.algebraic == ("y",)
    family = system.steady("p", guess={"p": 1.0})
    found = st.spectrum(family, at=2.0, certify=True)
    assert found.states == pytest.approx([1.0, 1.0])
    assert found.eigenvalues == pytest.approx([-1 / 6], abs=1e-15)
    with pytest.raises(st.StabilityError, match="1 zero columns, for d_y, and 0 zero rows"):
        mass[0, 0] = 1
        st.System.from_mass_matrix("m", z, P, mass, whole, parameters=("p",), **given)


@pytest.mark.parametrize(
    "ask",
    [
        lambda s, _: st.simulate(s, {"p": 1}, {"x": 1, "y": 1}, 1.0),
        lambda s, _: st.Scene(s, {"p": 1}, {"x": 1, "y": 1}, 1.0).answer(),
        lambda s, _: st.basins(s, x=("x", 0, 1, 2), y=("y", 0, 1, 2), horizon=1.0, p=1),
        lambda _, f: st.hopf(f, axis=("p", -1, -0.5, 9)),
        lambda _, f: st.export.latex(f),
        lambda s, _: st.export.latex(s),
        lambda _, f: st.explore(f, at=-0.5),
        lambda s, _: st.export.c_code(s, out="unused"),
        lambda _, f: st.export.auto_input(f, "unused", free="p", start=-1.0, stop=-0.5),
    ],
)
def test_what_takes_rates_alone_is_refused_in_one_sentence(ask: Callable[..., Any]) -> None:
    system = semi_explicit(Y - P, X - Y - Y**3)
    family = system.steady("p", guess={"p": -0.5})
    with pytest.raises(st.StabilityError, match="algebraic equations, for y, and .* rates alone"):
        ask(system, family)


def test_a_member_off_its_algebraic_equation_is_refused() -> None:
    system = semi_explicit(Y - X, X - Y - P)
    family = st.Family(system, "off", at=("p",), held={"x": 0, "y": 0})
    with pytest.raises(st.StabilityError, match="equation of y is off by 1, .*; add y to the fam"):
        st.spectrum(family, at=1.0)


def test_a_heading_and_an_algebraic_variable_are_zeros_of_their_own() -> None:
    """With x' = y - 2x - p, h' = y and y + y³ = x the rate is 1/(1 + 3y²) - 2."""
    h = ca.SX.sym("h")
    system = st.System(
        "heading",
        ca.vertcat(X, h, Y),
        P,
        ca.vertcat(Y - 2 * X - P, Y, Y + Y**3 - X),
        states=("x", "h", "y"),
        parameters=("p",),
        algebraic=("y",),
    )
    assert system.ignorable == ("h",)
    found = st.spectrum(system.steady("p", guess={"p": 0.0}), at=0.3, certify=True)
    y = found.states[2]
    assert found.eigenvalues == pytest.approx([1 / (1 + 3 * y**2) - 2], rel=1e-14)
    assert (found.structural_zeros, found.nonlinear.word) == (2, "asymptotic")
    vector = found.modes.vectors[0]
    assert vector[2] / vector[0] == pytest.approx(1 / (1 + 3 * y**2), rel=1e-12)


def test_systems_with_other_algebraic_variables_differ() -> None:
    one, other = semi_explicit(X - Y, X + Y), semi_explicit(X - Y, X + Y, algebraic=())
    assert one != other
    with pytest.raises(st.StabilityError, match="algebraic is 'w'"):
        semi_explicit(X - Y, X + Y, algebraic=("w",))
