"""Sixty states: chains of thirty masses, judged and proved; slopes folded on the way."""

import runpy
from collections.abc import Callable
from pathlib import Path
from typing import Any

import casadi as ca
import mpmath
import numpy as np
import pytest
import sympy
from sympy.physics.mechanics import dynamicsymbols

import stability as st
from stability.systems.graph import family_graph
from stability.systems.structure import structural_zeros

ROOT = Path(__file__).resolve().parents[2]


def chain(n: int, law: Callable[[Any], Any], *, damped: bool) -> st.System:
    """As many as n masses between two walls; `law` is the force of a spring by its stretch."""
    x, p = ca.SX.sym("x", 2 * n), ca.SX.sym("p", 2)
    stretch = ca.diff(ca.vertcat(0, x[:n], 0))
    force = p[0] * law(stretch)
    if damped:
        force += p[1] * ca.diff(ca.vertcat(0, x[n:], 0))
    names = [f"q{i}" for i in range(n)] + [f"v{i}" for i in range(n)]
    return st.System(
        "chain", x, p, ca.vertcat(x[n:], ca.diff(force)), states=names, parameters=("k", "c")
    )


def at_rest(system: st.System) -> st.Family:
    return st.Family(system, "rest", at=("k",), held=dict.fromkeys(system.states, 0.0))


def true_values(n: int, k: float, c: float) -> np.ndarray:
    """λ² + μ c λ + μ k = 0 with μ = 4 sin²(j π/(2 n + 2)), by mpmath."""
    found = []
    with mpmath.workdps(40):
        for j in range(1, n + 1):
            mu = 4 * mpmath.sin(j * mpmath.pi / (2 * n + 2)) ** 2
            half = mu * mpmath.mpf(c) / 2
            root = mpmath.sqrt(half**2 - mu * mpmath.mpf(k))
            found += [complex(-half + root), complex(-half - root)]
    return np.array(found)


@pytest.mark.long
def test_a_chain_of_sixty_states_is_proved() -> None:
    """Hardening springs, in the example's words; rational arithmetic."""
    space = runpy.run_path(str(ROOT / "examples" / "long_chain.py"))
    found, true = space["spectrum"], true_values(30, 1.0, 0.1)
    assert found.verdict.word == "stable"
    assert found.certified
    for value, radius in zip(found.eigenvalues, found.radius, strict=True):
        assert np.abs(true - value).min() <= radius + 2e-16 * abs(value)
    assert found.abscissa == pytest.approx(true.real.max(), rel=1e-12)


def test_an_irrational_chain_of_sixty_states_is_proved() -> None:
    """Springs with the force sin(s + 0.3) - sin 0.3: stiffness k cos 0.3, no rational number."""
    system = chain(30, lambda s: ca.sin(s + 0.3) - np.sin(0.3), damped=True)
    found = st.spectrum(at_rest(system), at=1.0, c=0.1, certify=True)
    true = true_values(30, float(mpmath.cos(mpmath.mpf(0.3))), 0.1)
    assert found.verdict.word == "stable"
    assert "balls" in found.reason
    assert found.abscissa == pytest.approx(true.real.max(), rel=1e-11)


def test_an_undamped_chain_of_sixty_states_is_neutral() -> None:
    system = chain(30, lambda s: s + s**3, damped=False)
    found = st.spectrum(at_rest(system), at=1.0, c=0.0, certify=True)
    assert found.verdict.word == "neutral"
    assert np.sort(found.eigenvalues.imag) == pytest.approx(
        np.sort(true_values(30, 1.0, 0.0).imag), abs=1e-13
    )


def swings(n: int) -> st.Family:
    """A chain of n links of length and mass 1 under gravity g, damped in each joint by c."""
    q, u = dynamicsymbols(f"q:{n}"), dynamicsymbols(f"u:{n}")
    g, c = sympy.symbols("g c")

    def weight(i: int, j: int) -> int:
        return n - max(i, j)

    mass = sympy.Matrix(n, n, lambda i, j: weight(i, j) * sympy.cos(q[i] - q[j]))
    rates = [0, *u]
    joint = [c * (rates[i + 1] - rates[i]) if i else c * u[0] for i in range(n)] + [0]
    forcing = [
        -sum(weight(i, j) * sympy.sin(q[i] - q[j]) * u[j] ** 2 for j in range(n))
        - weight(i, i) * g * sympy.sin(q[i])
        - joint[i]
        + joint[i + 1]
        for i in range(n)
    ]
    system = st.System.from_sympy((mass, sympy.Matrix(forcing), q, u), name="swings")
    return st.Family(system, "hanging", at=("g",), held=dict.fromkeys(system.states, 0.0))


@pytest.mark.parametrize("n", [4, pytest.param(6, marks=pytest.mark.long)])
def test_a_dense_mass_matrix_is_proved(n: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """M q'' + C q' + K q = 0 in exact numbers, its spectrum by mpmath."""
    monkeypatch.setattr(family_graph, "LARGE", 1000)
    g, c = 9.75, 0.25
    with mpmath.workdps(40):
        mass = mpmath.matrix(n, n)
        damping = mpmath.matrix(n, n)
        for i in range(n):
            for j in range(n):
                mass[i, j] = n - max(i, j)
            damping[i, i] = 2 * c if i < n - 1 else c
            if i:
                damping[i, i - 1] = damping[i - 1, i] = -c
        whole = mpmath.zeros(2 * n)
        inverse = mass**-1
        for i in range(n):
            whole[i, n + i] = 1
        stiff = -inverse * mpmath.diag([(n - i) * mpmath.mpf(g) for i in range(n)])
        rough = -inverse * damping
        for i in range(n):
            for j in range(n):
                whole[n + i, j], whole[n + i, n + j] = stiff[i, j], rough[i, j]
        true = np.array([complex(v) for v in mpmath.eig(whole, left=False, right=False)])
    found = st.spectrum(swings(n), at=g, c=c, certify=True)
    assert found.verdict.word == "stable"
    for value, radius in zip(found.eigenvalues, found.radius, strict=True):
        assert np.abs(true - value).min() <= radius + 1e-15 * abs(value)


def mixed() -> st.System:
    """Every function of a graph, in four rates."""
    x, p = ca.SX.sym("x", 4), ca.SX.sym("p", 2)
    first = x[1] ** 3 / ca.cos(x[0]) + ca.exp(x[2] * p[0]) + (2 + x[0]) ** x[1]
    second = ca.sqrt(1 + x[3] ** 2) * ca.log(2 + x[0]) - ca.atan(x[1] * x[2])
    third = ca.asin(x[0] / 3) + ca.acos(x[1] / 3) * ca.tanh(x[3]) + ca.fabs(p[1])
    fourth = ca.sinh(x[0]) * ca.cosh(x[1]) / (3 + x[2]) - ca.tan(x[3]) - 5 / (3 + x[0])
    fourth += (2 + x[2]) ** 1.5 + ca.power(p[0], x[2]) + 1 / (2 + x[1])
    rates = ca.vertcat(first, second, third, fourth)
    return st.System("mixed", x, p, rates, states=tuple("abcd"), parameters=("p", "q"))


@pytest.mark.parametrize("place", [(0.3, -0.2, 0.7, 0.1), (0.0, 0.0, 0.7, 0.0)])
def test_slopes_folded_on_the_way_are_casadis(
    place: tuple[float, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Against CasADi's own Jacobian of the system, with no family."""
    monkeypatch.setattr(family_graph, "LARGE", 0)
    system = mixed()
    held = dict(zip("bcd", place[1:], strict=True))
    family = st.Family(system, "somewhere", at=("a",), held=held)
    found = family.matrix(np.array([[place[0]]]), np.zeros((1, 0)), np.array([[1.3, -0.4]]))[0]
    slope = ca.Function("J", [system.x, system.p], [ca.jacobian(system.rhs, system.x)])
    assert found == pytest.approx(np.array(slope(place, [1.3, -0.4])), rel=1e-14, abs=1e-15)


def test_folded_slopes_keep_the_right_angle_and_exact_numbers(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(family_graph, "LARGE", 0)
    x, p = ca.SX.sym("x", 2), ca.SX.sym("p")
    rate = -p * ca.cos(x[0]) - 0.1 * x[1]
    system = st.System("up", x, p, ca.vertcat(x[1], rate), states=("q", "v"), parameters=("g",))
    family = st.Family(system, "up", at=("g",), held={"q": st.UPRIGHT, "v": 0.0})
    # -g cos q has the slope g sin q = g at the right angle: a saddle, proved over Q
    found = st.spectrum(family, at=1.0, certify=True)
    assert (found.verdict.word, "rational" in found.reason) == ("unstable", True)


def test_an_absolute_value_of_a_state_is_refused_on_the_way(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(family_graph, "LARGE", 0)
    x = ca.SX.sym("x")
    system = st.System("kink", x, ca.SX(0, 1), -ca.fabs(x), states=("q",))
    with pytest.raises(st.StabilityError, match="absolute value of a state"):
        st.spectrum(st.Family(system, "rest", at=("q",), held={}), at=0.0)


def network(seed: int, n: int) -> st.Family:
    """A sparse network; some states stand still, and others only drive."""
    random = np.random.default_rng(seed)
    matrix = np.where(random.random((n, n)) < 1.5 / n, random.normal(size=(n, n)), 0.0)
    matrix -= np.diag((random.random(n) < 0.1 * seed) * 0.5)
    matrix[random.random(n) < 0.1] = 0.0
    return st.linear(matrix)


def masses(seed: int, n: int) -> st.Family:
    """A chain of n/2 masses, the ends free for odd seeds, and every third one without damping."""
    free, damping = seed % 2, 0.0 if seed % 3 == 0 else 0.25
    stiff = 2 * np.eye(n // 2) - np.eye(n // 2, k=1) - np.eye(n // 2, k=-1)
    stiff[0, 0] -= free
    stiff[-1, -1] -= free
    return st.linear(np.eye(n // 2), damping * stiff, stiff)


@pytest.mark.parametrize("family_of", [network, masses])
@pytest.mark.parametrize("seed", range(6))
def test_the_structure_by_places_is_that_of_the_polynomial(
    family_of: Callable[[int, int], st.Family], seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    quick = structural_zeros.structure(family_of(seed, 36))
    monkeypatch.setattr(structural_zeros, "LARGE", 100)
    slow = structural_zeros.structure.__wrapped__(family_of(seed, 36))
    assert (quick.zeros, quick.even, quick.steady) == (slow.zeros, slow.even, slow.steady)
