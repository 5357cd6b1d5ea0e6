"""A mass matrix solved for in the number type: against mpmath, and against the expanded graph."""

import casadi as ca
import mpmath
import numpy as np
import pytest
import sympy
from flint import arb
from sympy.physics.mechanics import dynamicsymbols

import stability as st
from stability.algebra import program
from stability.algebra.linear_systems import solution
from stability.algebra.number_types import balls, precision
from stability.boundary.interval_search.taylor import series_algebra, terms
from stability.systems.graph import family_graph

BEND = 0.125


def links(n: int, *, pulled: bool) -> st.Family:
    """Links of length and mass 1: joint springs bent at rest; or a weight and a pull at the tip."""
    q, u = (ca.vertcat(*[ca.SX.sym(f"{w}{i}") for i in range(n)]) for w in "qu")
    p = ca.vertcat(*[ca.SX.sym(w) for w in "kc"])
    across = up = ca.SX(0)
    kinetic = potential = ca.SX(0)
    for i in range(n):
        across, up = across + u[i] * ca.cos(q[i]), up + u[i] * ca.sin(q[i])
        kinetic += (across**2 + up**2) / 2
        below = q[i - 1] if i else 0
        if pulled:
            potential -= (n - i) * ca.cos(q[i]) + p[0] * ca.sin(q[i])
        else:
            potential += p[0] * (q[i] - below - BEND) ** 2 / 2
    rates = ca.vertcat(0, u)
    turn = ca.diff(rates)
    forces = p[1] * (ca.vertcat(turn[1:], 0) - turn)
    system = st.mechanics(q, u, p, kinetic=kinetic, potential=potential, forces=forces)
    still = {f"u{i}": 0.0 for i in range(n)}
    if pulled:
        guess = {f"q{i}": 0.5 / (n - i) for i in range(n)}
        return st.Family(
            system, "pulled", ("k",), held=still, unknown=guess, equations=tuple(still)
        )
    return st.Family(
        system, "bent", ("k",), held=still | {f"q{i}": BEND * (i + 1) for i in range(n)}
    )


def true_values(n: int, k: float, c: float, *, pulled: bool) -> np.ndarray:
    """Eigenvalues of the linearised equations, written down by hand, by mpmath."""
    with mpmath.workdps(50):
        k, c = mpmath.mpf(k), mpmath.mpf(c)
        angle = [
            mpmath.atan(k / (n - i)) if pulled else mpmath.mpf(BEND) * (i + 1) for i in range(n)
        ]
        mass, stiff, rough = (mpmath.zeros(n) for _ in range(3))
        for i in range(n):
            for j in range(n):
                mass[i, j] = (n - max(i, j)) * mpmath.cos(angle[i] - angle[j])
            rough[i, i] = 2 * c if i < n - 1 else c
            if i:
                rough[i, i - 1] = rough[i - 1, i] = -c
        if pulled:
            for i in range(n):
                stiff[i, i] = (n - i) * mpmath.cos(angle[i]) + k * mpmath.sin(angle[i])
        else:
            stiff = rough * (k / c)
        whole, inverse = mpmath.zeros(2 * n), mass**-1
        for i in range(n):
            whole[i, n + i] = 1
        a, b = -inverse * stiff, -inverse * rough
        for i in range(n):
            for j in range(n):
                whole[n + i, j], whole[n + i, n + j] = a[i, j], b[i, j]
        return np.array([complex(v) for v in mpmath.eig(whole, left=False, right=False)])


@pytest.mark.long
@pytest.mark.parametrize("pulled", [False, True])
@pytest.mark.parametrize("n", [3, 6])
def test_bent_links_are_proved(n: int, pulled: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(family_graph, "LARGE", 0)
    family = links(n, pulled=pulled)
    assert family.graph.matrix.name == "implicit"
    found = st.spectrum(family, at=0.75, c=0.25, certify=True)
    true = true_values(n, 0.75, 0.25, pulled=pulled)
    assert found.verdict.word == "stable"
    for value, radius in zip(found.eigenvalues, found.radius, strict=True):
        assert np.abs(true - value).min() <= radius + 1e-15 * abs(value)


@pytest.mark.long
@pytest.mark.parametrize("n", [13, pytest.param(29, marks=pytest.mark.long)])
def test_large_systems_at_a_shape_that_is_solved_for(n: int) -> None:
    """With 58 states the expanded graph lost too many digits to prove a member at all."""
    family = links(n, pulled=True)
    assert family.graph.matrix.name == "implicit"
    found = st.spectrum(family, at=1.0, c=0.25, certify=True)
    true = true_values(n, 1.0, 0.25, pulled=True)
    assert found.verdict.word == "stable"
    assert found.abscissa == pytest.approx(true.real.max(), rel=1e-9)


@pytest.mark.long
def test_no_kernel_runs_an_implicit_form(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(family_graph, "LARGE", 0)
    monkeypatch.setattr(program, "LONGER", 0)  # every other list is long now
    family = links(3, pulled=True)
    assert family.graph.matrix.name == "implicit" and family.graph.matrix.tape is None
    found = st.spectrum(family, at=0.75, c=0.25, certify=True)
    assert found.abscissa == pytest.approx(true_values(3, 0.75, 0.25, pulled=True).real.max())


@pytest.mark.parametrize("pulled", [False, True])
def test_slopes_are_those_of_the_expanded_graph(
    pulled: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    place = [np.array([[0.75]]), np.array([[0.25]])]
    found = []
    for large in (0, 10**9):
        monkeypatch.setattr(family_graph, "LARGE", large)
        family = links(4, pulled=pulled)
        u = family.solve(*place)
        found.append(
            (u, family.matrix(place[0], u, place[1]), family.tangent(place[0], u, place[1]))
        )
    for one, other in zip(*found, strict=True):
        assert one == pytest.approx(other, rel=1e-12, abs=1e-13)


def test_a_rational_that_is_no_double_keeps_the_expanded_graph(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The graph of M holds a rounded third, that of the rates holds 1/3: λ = ± i exactly."""
    monkeypatch.setattr(family_graph, "LARGE", 0)
    q1, q2, u1, u2 = dynamicsymbols("q1 q2 u1 u2")
    c, third = sympy.symbols("c"), sympy.Rational(1, 3)
    mass = sympy.Matrix([[1, third], [third, 1]])
    rate = sympy.Matrix([third * c * u1 - u1 - q1, -u2 - q2])
    system = st.System.from_sympy((mass, mass * rate, [q1, q2], [u1, u2]))
    family = st.Family(system, "rest", at=("c",), held=dict.fromkeys(system.states, 0.0))
    assert st.spectrum(family, at=3.0, certify=True).verdict.word == "neutral"


def test_a_series_is_solved_order_by_order() -> None:
    """M X = B in power series, multiplied out again."""
    chance = np.random.default_rng(1)
    with precision(128), terms(4):
        from flint import arb_series

        rows = [
            [arb_series(chance.integers(-4, 5, 4).tolist()) for _ in range(5)] for _ in range(3)
        ]
        matrix, right = [row[:3] for row in rows], [row[3:] for row in rows]
        found = solution(series_algebra(), matrix, right)
        for i in range(3):
            for j in range(2):
                total = sum((matrix[i][k] * found[k][j] for k in range(3)), arb_series([0]))
                assert all(total[k].contains(right[i][j][k]) for k in range(4))
                assert all(total[k].rad() < 1e-25 for k in range(4))


def test_a_singular_ball_matrix_has_no_finite_solution() -> None:
    found = solution(balls(), [[arb(1), arb(2)], [arb(2), arb(4)]], [[arb(1)], [arb(1)]])
    assert not found[0][0].is_finite()
