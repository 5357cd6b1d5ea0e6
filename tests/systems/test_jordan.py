"""Structural zeros that are not semisimple: the linear flow grows like t, and that is said."""

from typing import Any

import casadi as ca
import numpy as np
import pytest
import sympy as sp
from scipy.linalg import expm

import stability as st

# every system here is linear, so that no higher orders could decide
GROWS, LINEAR = st.Nonlinear.GROWS, st.Nonlinear.LINEAR


def steady(matrix: Any, at: int = 0) -> Any:
    """A linear system as a family along one state whose column is zero."""
    n = len(matrix)
    x = ca.SX.sym("x", n)
    names = tuple(f"x{i}" for i in range(n))
    system = st.System(
        "s", x, ca.SX(0, 1), ca.mtimes(ca.DM(matrix), x), states=names, parameters=()
    )
    held = {name: 0.0 for i, name in enumerate(names) if i != at}
    return st.Family(system, "steady", at=(names[at],), held=held)


def test_the_counterexample_grows_like_t() -> None:
    # x' = v, v' = 0, z' = -z: spectrally stable, and 0.4 said "open: higher orders decide"
    found = st.spectrum(steady([[0, 1, 0], [0, 0, 0], [0, 0, -1]]), at=0.3)
    assert found.verdict is st.Verdict.STABLE
    assert found.structural_zeros == 2
    assert found.nonlinear is GROWS
    assert found.nonlinear.word == "grows like t in the linear flow"


def test_semisimple_zeros_are_not_said_to_grow() -> None:
    found = st.spectrum(steady([[0, 0, 1], [0, 0, 2], [0, 0, -1]]), at=0.3)
    assert found.structural_zeros == 2
    assert found.nonlinear is LINEAR


@pytest.mark.few(6)
@pytest.mark.parametrize("seed", range(40))
def test_random_systems_with_planted_blocks_against_exact_ranks(seed: int) -> None:
    """The rank by SymPy over Q and the growth of expm decide; integers, so nothing is rounded."""
    rng = np.random.default_rng(seed)
    zeros, rest = int(rng.integers(2, 4)), int(rng.integers(1, 4))
    n = zeros + rest
    core = np.zeros((n, n), dtype=int)
    for i in range(zeros - 1):
        core[i, i + 1] = rng.integers(0, 2) * 2 ** int(rng.integers(0, 12))
    core[zeros:, zeros:] = -np.diag(rng.integers(1, 9, rest)) + np.triu(
        rng.integers(-4, 5, (rest, rest)), 1
    )
    core[:zeros, zeros:] = rng.integers(-5, 6, (zeros, rest))
    basis = np.eye(n, dtype=int)
    for _ in range(4):  # unimodular, and the first column stays the first unit vector
        i, j = rng.integers(1, n, 2)
        if i != j:
            step = np.eye(n, dtype=int)
            step[i, j] = rng.integers(-2, 3)
            basis = basis @ step
    matrix = basis @ core @ np.round(np.linalg.inv(basis)).astype(int)
    exact = sp.Matrix(matrix.tolist())
    found = st.spectrum(steady(matrix.tolist()), at=0.5)
    if found.verdict is not st.Verdict.STABLE:
        assert found.nonlinear is LINEAR
        return
    assert found.structural_zeros == zeros
    semisimple = exact.rank() == n - zeros
    assert found.nonlinear is (LINEAR if semisimple else GROWS)
    late = np.linalg.norm(expm(1e4 * matrix.astype(float)))
    early = np.linalg.norm(expm(1e3 * matrix.astype(float)))
    assert (late > 5 * early) == (not semisimple)


def test_a_coupling_below_its_rounding_is_left_open() -> None:
    """1e-17 made of a difference of ones is not proved to be there."""
    x, p = ca.SX.sym("x", 3), ca.SX.sym("p")
    small = (1 + p) * x[1] - x[1] - p * x[1]  # zero, but not for the graph
    system = st.System("s", x, p, ca.vertcat(small, 0, -x[2]), states=("x", "v", "z"),
                       parameters=("p",))  # fmt: skip
    rest = st.Family(system, "rest", at=("x",), held={"v": 0.0, "z": 0.0})
    assert st.spectrum(rest, at=0.3, p=0.1).nonlinear is LINEAR


def test_many_points_are_judged_one_by_one() -> None:
    x, p = ca.SX.sym("x", 3), ca.SX.sym("p")
    system = st.System("s", x, p, ca.vertcat(p * x[1], 0, -x[2]), states=("x", "v", "z"),
                       parameters=("p",))  # fmt: skip
    rest = st.Family(system, "rest", at=("x",), held={"v": 0.0, "z": 0.0})
    found = st.spectrum(rest, at=0.3, p=[0.0, 1.0, 1e-12])
    assert found.nonlinear.tolist() == [LINEAR, GROWS, GROWS]


def test_the_disks_rolling_is_semisimple_as_its_drift_requires() -> None:
    from stability.spectra.deflation import grows

    family = st.disk_family("rolling", "viscous")
    a, q = np.array([[1.8], [3.0]]), np.array([[0.25, 0.3], [0.5, 2.0]])
    assert not grows(family, a, q, family.solve(a, q), 2, None).any()
