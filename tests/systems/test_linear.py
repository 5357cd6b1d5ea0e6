"""Linear systems from matrices: closed forms, every kind of matrix, and refusals."""

import copy
import pickle

import casadi as ca
import mpmath
import numpy as np
import pytest
import scipy.sparse as sp
from scipy.linalg import expm

import stability as st
from stability.base.errors import ParameterError


def toeplitz(n: int, low: float, middle: float, high: float) -> sp.dia_array:
    return sp.diags_array([low, middle, high], offsets=[-1, 0, 1], shape=(n, n))


def holds(found: st.Spectrum, true: list[mpmath.mpc]) -> None:
    """Each disc holds the eigenvalue of its rank, to 40 digits."""
    with mpmath.workdps(40):
        left = list(true)
        for value, radius in zip(found.eigenvalues, found.radius, strict=True):
            off = [abs(mpmath.mpc(complex(value)) - t) for t in left]
            best = min(off)
            assert best <= mpmath.mpf(float(radius)), (value, radius)
            left.pop(off.index(best))
    assert not left


def chain_values(n: int, c: float, m: float) -> list[mpmath.mpc]:
    """M λ² + μ c λ + μ = 0 with μ = 4 sin²(j π/(2 n + 2))."""
    found = []
    with mpmath.workdps(40):
        for j in range(1, n + 1):
            mu = 4 * mpmath.sin(j * mpmath.pi / (2 * n + 2)) ** 2
            half = mu * mpmath.mpf(c) / 2
            root = mpmath.sqrt(mpmath.mpc(half**2 - m * mu))
            found += [(-half + root) / m, (-half - root) / m]
    return found


@pytest.mark.parametrize(("n", "low"), [(40, 16.0), (200, 1.0)])
def test_a_band_has_the_eigenvalues_of_the_closed_form(n: int, low: float) -> None:
    """-9 + 2 √(low high) cos(k π/(n + 1)); the first is far from normal: 4^39 apart."""
    found = st.spectrum(st.linear(toeplitz(n, low, -9.0, 1.0)), certify=True)
    with mpmath.workdps(40):
        true = [
            mpmath.mpc(-9 + 2 * mpmath.sqrt(low) * mpmath.cos(k * mpmath.pi / (n + 1)))
            for k in range(1, n + 1)
        ]
    assert (found.verdict.word, found.certified) == ("stable", True)
    assert found.radius.max() < 1e-13
    holds(found, true)


@pytest.mark.parametrize("damping", [0.0, 0.5])
def test_masses_and_springs_have_the_eigenvalues_of_the_closed_form(damping: float) -> None:
    """Masses of 3 at sparse springs: stiffnesses over a mass are no doubles."""
    n = 40
    stiff = toeplitz(n, -1.0, 2.0, -1.0)
    family = st.linear(3.0 * sp.eye_array(n), damping * stiff, stiff)
    found = st.spectrum(family, certify=True)
    assert found.verdict.word == ("stable" if damping else "neutral")
    assert (found.radius.max() < 1e-13) and ("x" not in family.system.states)
    assert family.system.states[0::n] == ("q0", "q0_dot")
    assert "rhs" not in vars(family.system)  # no expression was made
    holds(found, chain_values(n, damping, 3.0))


def bar(n: int) -> st.Family:
    """Finite elements of a bar: M and K of one shape."""
    return st.linear(toeplitz(n, 1.0, 4.0, 1.0), np.zeros((n, n)), toeplitz(n, -6.0, 12.0, -6.0))


def bar_values(n: int) -> list[mpmath.mpc]:
    """Both roots of λ² = -6 (1 - cos)/(2 + cos)."""
    with mpmath.workdps(40):
        angles = [mpmath.cos(k * mpmath.pi / (n + 1)) for k in range(1, n + 1)]
        roots = [mpmath.sqrt(6 * (1 - c) / (2 + c)) for c in angles]
        return [mpmath.mpc(0, sign * root) for root in roots for sign in (1, -1)]


def test_the_radius_of_a_mass_matrix_that_is_not_diagonal_covers_its_solution() -> None:
    """To 40 digits: λ² = -6 (1 - cos)/(2 + cos)."""
    holds(st.spectrum(bar(6), certify=True), bar_values(6))


@pytest.mark.parametrize("seed", range(8))
def test_discs_hold_the_eigenvalues_for_the_very_doubles_of_a_full_mass_matrix(seed: int) -> None:
    """M, C and K of decimals, read as the doubles that they are; M is solved for in 40 digits."""
    chance = np.random.default_rng(seed)
    root, damping, stiff = (np.round(chance.normal(size=(4, 4)), 1) for _ in range(3))
    three = root @ root.T + np.eye(4), damping, stiff
    with mpmath.workdps(40):
        m, c, k = (mpmath.matrix(v.tolist()) for v in three)
        matrix = mpmath.zeros(8)
        matrix[:4, 4:] = mpmath.eye(4)
        matrix[4:, :4], matrix[4:, 4:] = -(m**-1) * k, -(m**-1) * c
        true = list(mpmath.eig(matrix, left=False, right=False))
    holds(st.spectrum(st.linear(*three), certify=True), true)


def test_a_mass_matrix_that_is_not_diagonal_is_solved_for() -> None:
    """Finite elements of a bar: M and K of one shape, λ² = -6 (1 - cos)/(2 + cos)."""
    found = st.spectrum(bar(6), certify=True)
    assert found.verdict.word == "neutral"
    true = sorted(float(v.imag) for v in bar_values(6))
    assert found.eigenvalues.imag == pytest.approx(true, rel=1e-15)


MATRIX = np.array([[-1.0, 0.1, 0.0], [0.0, -0.3, 2.0], [0.0, -2.0, -0.3]])


@pytest.mark.parametrize(
    "kind", [np.array, sp.csr_array, sp.coo_matrix, ca.DM, ca.SX, np.ndarray.tolist]
)
def test_every_kind_of_matrix_is_read(kind: type) -> None:
    found = st.spectrum(st.linear(kind(MATRIX), states=("a", "b", "c"), name="three"), certify=True)
    true = st.spectrum(st.linear(MATRIX), certify=True)
    assert found.eigenvalues.tolist() == true.eigenvalues.tolist()
    assert found.family.system.states == ("a", "b", "c")
    assert found.eigenvalues == pytest.approx([-1.0, -0.3 - 2j, -0.3 + 2j])


def test_symbols_of_a_matrix_are_parameters() -> None:
    """The rotor of mass 1: whirl begins at mu² = 2 k / 3 with these numbers."""
    mu, k = ca.SX.sym("mu"), ca.SX.sym("k")
    skew = ca.SX([[0, 1], [-1, 0]])
    family = st.linear(ca.SX.eye(2), ca.SX.eye(2), k * ca.SX.eye(2) + mu * skew)
    assert family.at == ("mu", "k") or family.at == ("k", "mu")
    # (λ² + λ + k)² + mu² = 0: a pair on the axis at λ = i ω with ω² = k, ω = mu
    [whirl] = st.boundaries(family, axis=("mu", 0.5, 3.0, 9), k=4.0)
    assert whirl.value == pytest.approx(2.0, abs=1e-14)
    plain = st.linear(ca.vertcat(ca.horzcat(0, 1), ca.horzcat(-k, -mu)))
    assert st.spectrum(plain, k=1.0, mu=0.5, certify=True).verdict.word == "stable"


def test_a_linear_system_is_a_system() -> None:
    """Rates, motion, copies, and another family: as of the same system from expressions."""
    family = st.linear(MATRIX, states=("a", "b", "c"))
    system = family.system
    x = ca.SX.sym("x", 3)
    rates = ca.mtimes(ca.SX(ca.DM(MATRIX)), x)
    same = st.System("same", x, ca.SX(0, 1), rates, states=("a", "b", "c"))
    assert system.rates([1.0, 2.0, 3.0], []) == pytest.approx(same.rates([1.0, 2.0, 3.0], []))
    assert system.linearise([0.0, 0.0, 0.0], []) == pytest.approx(MATRIX)
    run = st.simulate(system, {}, {"a": 1.0, "b": 0.5, "c": 0.0}, np.linspace(0.0, 2.0, 5))
    end = np.array([float(run[n][-1]) for n in "abc"])
    assert end == pytest.approx(expm(2.0 * MATRIX) @ [1.0, 0.5, 0.0], rel=1e-9)
    for other in (pickle.loads(pickle.dumps(system)), copy.copy(system), copy.deepcopy(system)):
        assert other == system
        assert hash(other) == hash(system)
    assert system != st.linear(2 * MATRIX, states=("a", "b", "c")).system
    assert system != same
    named = st.Family(system, "turning", at=(), held={"a": 0.0, "b": 0.0, "c": 0.0})
    assert st.spectrum(named).eigenvalues.tolist() == st.spectrum(family).eigenvalues.tolist()


def test_divided_rates_are_not_rounded_on_the_way() -> None:
    """K/M with M = 3: an expression keeps the quotient, so that λ² = -0.1/3 is proved."""
    system = st.linear([[3.0]], [[0.0]], [[0.1]]).system
    family = st.Family(system, "rest", at=("q0",), held={"q0_dot": 0.0})
    assert system.linearise([0.0, 0.0], [])[1, 0] == pytest.approx(-0.1 / 3)
    assert "rhs" in vars(system)
    with pytest.raises(st.StabilityError):
        st.spectrum(family, at=1.0)  # no motion rests there


def test_sparse_zeros_are_not_entries() -> None:
    stored = sp.coo_array(([0.0, -1.0, -2.0], ([0, 0, 1], [1, 0, 1])), shape=(2, 2))
    family = st.linear(stored)
    assert family.graph.matrix.places == (((0, 0), (1, 1)),)
    twice = sp.coo_array(([-1.0, -1.0, -1.0], ([0, 0, 1], [0, 0, 1])), shape=(2, 2))
    assert st.spectrum(st.linear(twice)).eigenvalues.tolist() == [-2.0, -1.0]


@pytest.mark.parametrize(
    ("matrices", "said"),
    [
        ((), "0 matrices"),
        ((np.eye(2), np.eye(2)), "2 matrices"),
        ((np.ones((2, 3)),), "A 2 x 3"),
        ((np.zeros(3),), "shape"),
        ((sp.coo_array(([1.0], ([0],)), shape=(3,)),), "shape"),
        ((sp.csr_array([[np.nan]]),), "A is nan"),
        ((sp.csr_array([[1j]]),), "A"),
        ((np.eye(2), np.eye(3), np.eye(2)), "C 3 x 3"),
        (([[np.nan]],), "A"),
        (([["a"]],), "A"),
        ((np.diag([1.0, 0.0]), np.eye(2), np.eye(2)), "singular"),
        ((np.eye(2) * 1j,), "A"),
        (("A",), "A"),
    ],
)
def test_what_is_no_linear_system_is_refused(matrices: tuple[object, ...], said: str) -> None:
    with pytest.raises(ParameterError, match=said):
        st.linear(*matrices)


@pytest.mark.parametrize("states", [("a",), ("a", "a"), "ab", ("a", 3)])
def test_names_that_do_not_fit_are_refused(states: object) -> None:
    with pytest.raises(ParameterError, match="states"):
        st.linear(np.eye(2), states=states)
