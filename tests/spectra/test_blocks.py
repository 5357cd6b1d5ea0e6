"""Large members, proved block by block: closed forms, 60 digits, blocks that discs leave open."""

from typing import Any

import casadi as ca
import numpy as np
import pytest
import scipy.sparse as sp
from flint import acb, arb, fmpq, fmpq_mat
from scipy.sparse.csgraph import maximum_bipartite_matching

import stability as st
from stability.algebra.number_types import precision
from stability.spectra import blocks

SEED = 20261128
Random = np.random.Generator


def rotated(block: np.ndarray, random: Random) -> np.ndarray:
    """A similar matrix of whole numbers: shears by 1 and -1."""
    out = block.copy()
    for _ in range(2 * len(block)):
        i, j = random.choice(len(block), 2, replace=False)
        out[i] += out[j]
        out[:, j] -= out[:, i]
    return out


def small_block(random: Random, kind: str) -> np.ndarray:
    """A block of whole numbers that its discs leave open."""
    block = {
        "axis": np.array([[0.0, 2.0, 1.0], [-2.0, 0.0, 0.0], [0.0, 0.0, -3.0]]),
        "defective": np.eye(3, k=1) - np.eye(3),
        "defective axis": np.array(
            [[0.0, 1.0, 1.0, 0.0], [-1.0, 0.0, 0.0, 1.0], [0, 0, 0, 1], [0, 0, -1, 0]]
        ),
        "zero": np.array([[0.0, 1.0], [0.0, -1.0]]),
        "growing": np.array([[1.0, 1.0, 0.0], [0.0, 1.0, 1.0], [0.0, 0.0, 1.0]]),
    }[kind]
    return rotated(block, random)


def composed(random: Random, kinds: list[str], dense: int) -> np.ndarray:
    """These blocks and one dense stable block, coupled one way, in a random order of states."""
    parts = [small_block(random, kind) for kind in kinds]
    parts.append(random.normal(size=(dense, dense)) / np.sqrt(dense) - 2 * np.eye(dense))
    n = sum(map(len, parts))
    whole, start = np.zeros((n, n)), 0
    for part in parts:
        end = start + len(part)
        whole[start:end, start:end] = part
        whole[start:end, end:] = random.normal(size=(len(part), n - end))
        start = end
    order = random.permutation(n)
    return whole[np.ix_(order, order)]


VERDICTS = {
    ("defective",): "stable",
    ("axis",): "neutral",
    ("defective", "axis", "defective"): "neutral",
    ("defective axis",): "neutral",
    ("growing", "axis"): "unstable",
    ("axis", "defective", "growing"): "unstable",
}


@pytest.mark.parametrize("kinds", VERDICTS, ids="+".join)
def test_each_block_is_proved_by_itself(kinds: tuple[str, ...]) -> None:
    """A dense block by discs, small ones over Q: together no polynomial of 40 states is made."""
    random = np.random.default_rng(SEED)
    found = st.spectrum(st.linear(composed(random, list(kinds), 36)), certify=True)
    assert (found.verdict.word, found.certified) == (VERDICTS[kinds], True)
    assert "block by block" in found.reason
    assert found.radius.max() < 1e-13


def true_values(matrix: np.ndarray) -> list[acb]:
    """Eigenvalues to 60 digits and more, over Q."""
    exact = [[fmpq(*float(v).as_integer_ratio()) for v in row] for row in matrix]
    with precision(400):
        roots = fmpq_mat(exact).charpoly().numer().complex_roots()
    return [root for root, count in roots for _ in range(count)]


def check(found: st.Spectrum, true: list[acb]) -> None:
    """Each true eigenvalue in a disc of its own, and a verdict that the true ones have."""
    with precision(400):
        discs = [
            (acb(v.real, v.imag), arb(float(r)))
            for v, r in zip(found.eigenvalues, found.radius, strict=True)
        ]
        inside = [[not abs(t - c) > r for t in true] for c, r in discs]
        top = max((t.real for t in true), key=float)
        assert not abs(top - arb(found.abscissa)) > arb(found.abscissa_error)
    assert (maximum_bipartite_matching(sp.csr_array(np.array(inside))) >= 0).all()
    word = found.verdict.word
    assert word == "undecided" or word == ("stable" if top < 0 else "unstable")


def hostile(random: Random, n: int) -> np.ndarray:
    """Non-normal, badly scaled, clustered or sparse, with an abscissa near zero."""
    kind = int(random.integers(5))
    matrix = random.normal(size=(n, n)) / np.sqrt(n)
    if kind == 1:
        size = np.exp2(random.integers(-40, 40, n))
        matrix = size[:, None] * matrix / size
    elif kind == 2:
        matrix = np.triu(matrix, 1) * 8 + np.tril(matrix, -1) * 1e-3
    elif kind == 3:
        matrix = np.where(random.random((n, n)) < 2 / n, random.normal(size=(n, n)), 0.0)
        matrix += np.diag(random.normal(size=n))
    elif kind == 4:
        low = np.tril(random.integers(-1, 2, (n, n)) * (random.random((n, n)) < 0.1), -1)
        near = np.diag(-1 + 2.0 ** -random.integers(20, 40, n) * random.integers(1, 9, n))
        matrix = near + 0.5 * low
        matrix[0, -1] = 1e-9
    shift = np.linalg.eigvals(matrix).real.max() if random.random() < 0.5 else 0.0
    return matrix - (shift + random.normal() * 10.0 ** -random.integers(0, 10)) * np.eye(n)


@pytest.mark.parametrize("count", [4, pytest.param(200, marks=pytest.mark.long)])
def test_hostile_matrices_are_those_of_sixty_digits(count: int) -> None:
    random = np.random.default_rng([SEED, count])
    decided = 0
    for _ in range(count):
        matrix = hostile(random, int(random.integers(33, 49)))
        problem = blocks.Blocks(*_member(matrix))
        if not np.isfinite(problem.radius).all():
            continue
        found = st.spectrum(st.linear(matrix), certify=True)
        check(found, true_values(matrix))
        decided += found.verdict.word != "undecided"
    assert decided >= count // 2


def _member(matrix: np.ndarray) -> tuple[Any, int]:
    from stability.polynomials.member import Member

    return Member(st.linear(matrix), [], [], []), 0


def test_a_ring_of_28_cars_is_decided() -> None:
    """λ (λ + a) = a V'(h) (ω - 1) with ωⁿ = 1; one λ = 0, since the ring keeps its length."""
    n = 28
    x, p = ca.SX.sym("x", 2 * n), ca.SX.sym("p")
    gap, speed = x[:n], x[n:]
    drive = p * (ca.tanh(gap - 2.25) - speed)
    rates = ca.vertcat(ca.vertcat(speed[1:], speed[0]) - speed, drive)
    names = [f"h{i}" for i in range(n)] + [f"v{i}" for i in range(n)]
    ring = st.System("ring", x, p, rates, states=names, parameters=("a",))
    flow = st.Family(
        ring,
        "flow",
        at=("a",),
        held={f"h{i}": 2.0 for i in range(n)},
        unknown={f"v{i}": -0.25 for i in range(n)},
        equations=names[n:],
    )
    slope = 1 / np.cosh(0.25) ** 2
    for a, word in ((2.5, "stable"), (1.0, "unstable")):
        found = st.spectrum(flow, at=a, certify=True)
        turn = np.exp(2j * np.pi * np.arange(n) / n)
        true = np.array([np.roots([1.0, a, a * slope * (1 - w)]) for w in turn]).ravel()
        true = true[np.abs(true) > 1e-9]
        assert (found.verdict.word, found.structural_zeros) == (word, 1)
        for value, radius in zip(found.eigenvalues, found.radius, strict=True):
            assert np.abs(true - value).min() <= radius + 1e-14


def test_a_free_chain_keeps_its_jordan_block_out_of_the_discs() -> None:
    n = 24
    stiff = sp.lil_array(sp.diags_array([-1.0, 2.0, -1.0], offsets=[-1, 0, 1], shape=(n, n)))
    stiff[0, 0] = stiff[-1, -1] = 1.0
    mass, none = sp.eye_array(n), sp.csr_array((n, n))
    free = st.spectrum(st.linear(mass, none, stiff), certify=True)
    damped = st.spectrum(st.linear(mass, 0.25 * stiff, stiff), certify=True)
    assert (free.verdict.word, damped.verdict.word) == ("neutral", "drifting")
    assert free.structural_zeros == damped.structural_zeros == 2
    true = 2 * np.sin(np.arange(1, n) * np.pi / (2 * n))
    assert np.sort(free.eigenvalues.imag) == pytest.approx(np.sort([*true, *-true]), abs=1e-11)
    assert (free.eigenvalues.real == 0).all()


def test_a_sparse_network_of_270_states_is_a_product_of_small_blocks() -> None:
    random = np.random.default_rng(SEED)
    n = 270
    matrix = sp.lil_array(sp.diags_array(-random.integers(1, 2**20, n) / 2.0**20, shape=(n, n)))
    rows, columns = random.integers(0, n, (2, 135))
    matrix[np.maximum(rows, columns), np.minimum(rows, columns)] = random.normal(size=135)
    found = st.spectrum(st.linear(matrix), certify=True)
    assert found.eigenvalues.real.tolist() == np.sort(matrix.diagonal()).tolist()
    assert not found.radius.any()
