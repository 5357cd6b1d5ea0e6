"""Zeros that constant vectors prove, against polynomials multiplied out and against mpmath."""

import casadi as ca
import mpmath
import numpy as np
import pytest
from flint import fmpq, fmpq_mat

import stability as st
from stability.algebra.exact.function_field import FunctionField
from stability.polynomials.identities import SAMPLES, constant_zeros


def springs(h: int) -> np.ndarray:
    chance = np.random.default_rng(h)
    return np.round(64 * (1 + chance.random((h, h)))) / 64


def free(h: int) -> st.Family:
    """As many as h masses on a line, a spring between any two, no wall."""
    k = springs(h)
    x, p = ca.SX.sym("x", 2 * h), ca.SX.sym("p", 2)
    q, v = x[:h], x[h:]
    force = ca.SX(h, 1)
    for i in range(h):
        for j in range(h):
            if i != j:
                force[i] += k[i, j] * ca.sin(p[0]) * ca.sin(q[j] - q[i]) + p[1] * (v[j] - v[i])
    names = [f"q{i}" for i in range(h)] + [f"v{i}" for i in range(h)]
    system = st.System("free", x, p, ca.vertcat(v, force), states=names, parameters=("k", "c"))
    return st.Family(system, "rest", at=("k",), held=dict.fromkeys(names, 0.0))


@pytest.mark.long
def test_a_dense_free_chain_of_thirty_states_is_proved() -> None:
    """Its place and its speed are two zeros in one Jordan block; the others by mpmath."""
    h, k, c = 15, 0.75, 0.0625
    found = st.spectrum(free(h), at=k, c=c, certify=True)
    with mpmath.workdps(40):
        stiff = mpmath.matrix((springs(h) * (1 - np.eye(h))).tolist()) * mpmath.sin(k)
        rough = mpmath.matrix((c * (1 - np.eye(h))).tolist())
        for matrix in (stiff, rough):
            for i in range(h):
                matrix[i, i] = -sum(matrix[i, j] for j in range(h))
        whole = mpmath.zeros(2 * h)
        for i in range(h):
            whole[i, h + i] = 1
            for j in range(h):
                whole[h + i, j], whole[h + i, h + j] = stiff[i, j], rough[i, j]
        values = mpmath.eig(whole, left=False, right=False)
    true = np.array([complex(v) for v in values if abs(v) > 1e-15])
    assert (found.verdict.word, found.structural_zeros, len(true)) == ("stable", 2, 2 * h - 2)
    for value, radius in zip(found.eigenvalues, found.radius, strict=True):
        assert np.abs(true - value).min() <= radius + 1e-15 * abs(value)


@pytest.mark.few(2)
@pytest.mark.parametrize("seed", range(6))
def test_planted_chains_are_counted(seed: int) -> None:
    """S diag(J, B(k)) S⁻¹ with a nilpotent J: as many zeros as the polynomial has."""
    chance = np.random.default_rng(seed)
    size, planted = 7, int(chance.integers(1, 5))
    field = FunctionField(["k"])
    [k] = field.symbols
    core = [[field.number(0)] * size for _ in range(size)]
    for i in range(planted - 1):
        core[i][i + 1] = field.number(int(chance.integers(0, 2)))
    for i in range(planted, size):
        for j in range(planted, size):
            core[i][j] = k * int(chance.integers(-3, 4)) + int(chance.integers(1, 4)) * (i == j)
    while True:
        turn = fmpq_mat(size, size, [int(v) for v in chance.integers(-2, 3, size**2)])
        if turn.det() != 0:
            break
    back = turn.inv()
    matrix = [
        [
            _sum(turn[i, a] * core[a][b] * back[b, j] for a in range(size) for b in range(size))
            for j in range(size)
        ]
        for i in range(size)
    ]
    sample = fmpq_mat([[_at(e, fmpq(17, 19)) for e in row] for row in matrix])
    true = next(i for i, c in enumerate(sample.charpoly().coeffs()) if c != 0)
    assert constant_zeros(matrix, lambda v: bool(v == 0)) == planted == true


def test_a_vector_that_fails_between_the_samples_is_refused() -> None:
    """An entry that vanishes at each sample, and nowhere else."""
    [k] = FunctionField(["k"]).symbols
    entry = k**0
    for number in range(SAMPLES):
        entry = entry * (k - fmpq(3 + 2 * (7 * number % 11), 5 + number % 3))
    assert constant_zeros([[entry]], lambda v: bool(v == 0)) == 0
    assert constant_zeros([[entry - entry]], lambda v: bool(v == 0)) == 1


def _sum(terms: object) -> object:
    total = fmpq(0)
    for term in terms:  # type: ignore[attr-defined]
        total = total + term
    return total


def _at(entry: object, value: fmpq) -> fmpq:
    count = entry.num.context().nvars()  # type: ignore[attr-defined]
    point = [value] * count
    return fmpq(entry.num(*point)) / fmpq(entry.den(*point))  # type: ignore[attr-defined]
