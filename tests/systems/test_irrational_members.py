"""Pairs of eigenvalues that coincide on the imaginary axis, at members that are irrational.

The spectra are planted: (λ² + k)² in a basis of whole numbers, with k > 0 a function of the member,
next to the equations of the member itself, whose eigenvalues have negative real parts.
"""

from collections.abc import Callable
from typing import Any

import casadi as ca
import mpmath as mp
import numpy as np
import pytest

import stability as st
from stability import Verdict

BASIS = np.array([[1, 2, 0, 1], [0, 1, 1, 0], [0, 0, 1, 3], [0, 0, 0, 1]]) @ np.array(
    [[1, 0, 0, 0], [1, 1, 0, 0], [0, 2, 1, 0], [1, 0, 1, 1]]
)
ADDED = ["y1", "y2", "y3", "y4"]
Rule = Callable[..., Any]

MEMBERS: dict[str, tuple[Rule, dict[str, float], Rule, dict[str, float]]] = {
    # rates, first guess, k, parameters
    "a square root": (lambda u, p: [p - u**2], {"u": 1.4}, lambda u: u, {"p": 2.0}),
    "a quintic": (lambda u, p: [p + u - u**5], {"u": 1.2}, lambda u: u**2 + 1, {"p": 1.0}),
    "two algebraic unknowns": (
        lambda u, w, p: [p - u**2 - w, u - w**3],
        {"u": 1.1, "w": 1.0},
        lambda u, w: u + w,
        {"p": 3.0},
    ),
    "Lorenz' equations": (
        lambda x, y, z, r, b: [y - x, x * (r - z) - y, x * y - b * z],
        {"x": 8.0, "y": 8.0, "z": 27.0},
        lambda x, y, z: x * y + z + x,
        {"r": 28.0, "b": 8 / 3},
    ),
    "an angle": (
        lambda u, p: [ca.sin(u) * (p * ca.cos(u) - 1)],
        {"u": 1.0},
        lambda u: ca.sin(u) ** 2 + ca.sin(u),
        {"p": 3.0},
    ),
    "the governor": (
        lambda u, w, p: [w**2 * ca.cos(u) - 1, ca.cos(u) - p],
        {"u": 1.0, "w": 1.4},
        lambda u, w: ca.sin(u) + w,
        {"p": 0.3},
    ),
    "Kepler's equation": (
        lambda u, p: [p - u - ca.sin(u) / 2],
        {"u": 1.0},
        lambda u: 1 + u + ca.cos(u),
        {"p": 1.0},
    ),
    "an exponential": (
        lambda u, p: [p - u - ca.exp(u)],
        {"u": 0.3},
        lambda u: u + ca.exp(u) + 1,
        {"p": 2.0},
    ),
}


def planted(name: str, matrix: Callable[[Any], ca.SX]) -> tuple[Any, dict[str, float]]:
    """The family of members next to four states with the matrix of k, in another basis."""
    rates, guess, stiffness, values = MEMBERS[name]
    x, p = ca.SX.sym("x", len(guess) + 4), ca.SX.sym("p", len(values))
    u = [*ca.vertsplit(x[: len(guess)]), *ca.vertsplit(p)]
    back = np.round(np.linalg.inv(BASIS))
    assert (BASIS @ back == np.eye(4)).all()
    other = ca.mtimes(
        [ca.DM(BASIS), matrix(stiffness(*u[: len(guess)])), ca.DM(back), x[len(guess) :]]
    )
    system = st.System(
        "planted",
        x,
        p,
        ca.vertcat(*rates(*u), other),
        states=(*guess, *ADDED),
        parameters=tuple(values),
    )
    at = next(iter(values))
    family = system.steady(at, held=dict.fromkeys(ADDED, 0.0), guess={**guess, **values})
    return family, {"at": values[at], **{n: v for n, v in values.items() if n != at}}


def pairs(k: Any, joined: float, damping: float = 0.0, twist: float = 0.0) -> ca.SX:
    """Two oscillators of stiffness k; a twist splits k into k ± i twist."""
    return ca.vertcat(
        ca.horzcat(0, 1, joined, 0),
        ca.horzcat(-k, -damping, -twist, joined),
        ca.horzcat(0, 0, 0, 1),
        ca.horzcat(twist, 0, -k, -damping),
    )


@pytest.mark.long
@pytest.mark.parametrize("joined", [0.0, 1.0], ids=["semisimple", "Jordan"])
@pytest.mark.parametrize("name", MEMBERS)
def test_a_double_pair_on_the_axis_is_neutral(name: str, joined: float) -> None:
    family, values = planted(name, lambda k: pairs(k, joined))
    found = st.spectrum(family, certify=True, **values)
    assert found.verdict is Verdict.NEUTRAL
    assert found.structural_zeros == 0
    assert "proved in exact algebra modulo the member's equations" in found.reason
    stiffness = MEMBERS[name][2]
    u = [float(v) for v in family.anchor.unknown]
    k = float(ca.DM(stiffness(*u)))
    near = np.abs(found.eigenvalues[:, None] - 1j * np.array([1, -1]) * np.sqrt(k)) < 1e-9 * k
    assert near.sum(axis=0).tolist() == [2, 2]
    assert (found.eigenvalues.real[~near.any(axis=1)] < -1e-3).all()
    assert st.spectrum(family, **values).verdict is Verdict.NEUTRAL  # it certifies by itself


@pytest.mark.few(2)
@pytest.mark.parametrize(
    ("damping", "twist", "wanted"),
    [
        (1e-12, 0.0, Verdict.STABLE),
        (-1e-12, 0.0, Verdict.UNSTABLE),
        (0.0, 1e-12, Verdict.UNSTABLE),
        (1e-12, 1e-9, Verdict.UNSTABLE),
        (1e-9, 1e-12, Verdict.STABLE),
    ],
)
@pytest.mark.parametrize("name", MEMBERS)
def test_next_to_the_double_pair_each_side_is_decided(
    name: str, damping: float, twist: float, wanted: Verdict
) -> None:
    """λ² + δ λ + k ± i ε = 0: stable if and only if δ² k > ε², by Routh and Hurwitz."""
    family, values = planted(name, lambda k: pairs(k, 0.0, damping, twist))
    stiffness = MEMBERS[name][2]
    k = float(ca.DM(stiffness(*family.anchor.unknown)))
    assert wanted is (
        Verdict.STABLE if damping > 0 and damping**2 * k > twist**2 else Verdict.UNSTABLE
    )
    assert st.spectrum(family, certify=True, **values).verdict is wanted


@pytest.mark.parametrize("joined", [0.0, 1.0])
def test_pairs_that_coincide_by_the_equations_alone(joined: float) -> None:
    """One pair has u + exp w, the other p; they are equal since p - u - exp w = 0, w = u²."""
    x, p = ca.SX.sym("x", 6), ca.SX.sym("p")
    u, w, a, b, c, d = ca.vertsplit(x)
    rates = [p - u - ca.exp(w), u * u - w, b, -(u + ca.exp(w)) * a + joined * c, d, -p * c]
    system = st.System(
        "two", x, p, ca.vertcat(*rates), states=("u", "w", *ADDED), parameters=("p",)
    )
    family = system.steady(
        "p", held=dict.fromkeys(ADDED, 0.0), guess={"u": 0.6, "w": 0.3, "p": 2.0}
    )
    found = st.spectrum(family, at=2.0, certify=True)
    assert found.verdict is Verdict.NEUTRAL
    near = np.abs(np.abs(found.eigenvalues.imag) - 2**0.5) + np.abs(found.eigenvalues.real) < 1e-9
    assert near.sum() == 4
    assert (found.eigenvalues.real[~near] < -0.1).all()


@pytest.mark.long
def test_pairs_whose_equality_nothing_proves_stay_undecided() -> None:
    """Exp(2u) = p² where exp u = p, but the rule of the exponential is not among the relations."""
    x, p = ca.SX.sym("x", 5), ca.SX.sym("p")
    u, a, b, c, d = ca.vertsplit(x)
    rates = [p - ca.exp(u), b, -ca.exp(2 * u) * a + c, d, -p * p * c]
    system = st.System("two", x, p, ca.vertcat(*rates), states=("u", *ADDED), parameters=("p",))
    family = system.steady("p", held=dict.fromkeys(ADDED, 0.0), guess={"u": 0.6, "p": 2.0})
    found = st.spectrum(family, at=2.0, certify=True)
    assert found.verdict is Verdict.UNDECIDED
    assert "undecided within the budget of precision" in found.reason


def test_a_zero_that_only_the_equations_prove_is_not_taken_for_a_boundary() -> None:
    """The eigenvalue p - u² - w of z is zero at every member: structural, so never neutral."""
    x, p = ca.SX.sym("x", 3), ca.SX.sym("p")
    u, w, z = ca.vertsplit(x)
    system = st.System(
        "zero",
        x,
        p,
        ca.vertcat(p - u**2 - w, u - w**3, (p - u**2 - w) * z),
        states=("u", "w", "z"),
        parameters=("p",),
    )
    family = system.steady("p", held={"z": 0.0}, guess={"u": 1.1, "w": 1.0, "p": 3.0})
    found = st.spectrum(family, at=3.0, certify=True)
    assert (found.verdict, found.structural_zeros) in (
        (Verdict.STABLE, 1),
        (Verdict.UNDECIDED, 0),
    )


@pytest.mark.few(1)
@pytest.mark.parametrize("seed", range(12))
def test_what_stands_next_to_the_pairs_decides(seed: int) -> None:
    """The rest is a random block of the member's u: mpmath has its eigenvalues to 50 digits."""
    rng = np.random.default_rng(seed)
    size = int(rng.integers(1, 4))
    block, slope = rng.integers(-4, 4, (size, size)), rng.integers(-2, 3, (size, size))
    block = block - 2 * np.eye(size, dtype=int)
    x, p = ca.SX.sym("x", 6 + size), ca.SX.sym("p")
    u, w = x[0], x[1]
    k = u * u + w
    states = ["u", "w", *ADDED, *"xyz"[:size]]
    mixed = ca.mtimes([ca.DM(BASIS), pairs(k, 1.0), ca.DM(np.round(np.linalg.inv(BASIS))), x[2:6]])
    more = ca.mtimes(ca.DM(block) + u * ca.DM(slope), x[6:]) + x[2] * ca.DM.ones(size)
    system = st.System(
        "rest",
        x,
        p,
        ca.vertcat(p - u**3 - w, u - w**3, mixed, more),
        states=states,
        parameters=("p",),
    )
    family = system.steady(
        "p", held=dict.fromkeys(states[2:], 0.0), guess={"u": 1.0, "w": 1.0, "p": 3.0}
    )
    with mp.workdps(50):
        root = mp.findroot(lambda w: 3 - w**9 - w, family.anchor.unknown[1])
        matrix = mp.matrix(block.tolist()) + root**3 * mp.matrix(slope.tolist())
        values = mp.eig(matrix, left=False, right=False) if size > 1 else [matrix[0]]
        largest = max(mp.re(v) for v in values)
    assert abs(largest) > 1e-6
    found = st.spectrum(family, at=3.0, certify=True)
    assert found.verdict is (Verdict.NEUTRAL if largest < 0 else Verdict.UNSTABLE)
