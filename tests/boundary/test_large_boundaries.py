"""Boundaries of large systems: crossings planted in blocks under a similarity of integers."""

from __future__ import annotations

import warnings
from fractions import Fraction
from itertools import pairwise
from typing import Any, NamedTuple

import casadi as ca
import numpy as np
import pytest

import stability as st
from stability.boundary.algebraic import exact_search

SEED = 20261129
LOW, HIGH = -1.0, 1.0


class Planted(NamedTuple):
    """A matrix A + B p + C p² with known real parts of its eigenvalues."""

    tables: list[np.ndarray]
    """A, B and C, exact in doubles."""
    real: list[list[Fraction]]
    """For each block, the real part of its eigenvalues by powers of p."""
    frequency: list[Fraction]
    """For each block, |Im λ|; 0 for a real eigenvalue."""


def unimodular(random: np.random.Generator, n: int, turns: int) -> tuple[Any, Any]:
    """A matrix of integers and its inverse."""
    one, back = (np.array(np.eye(n), dtype=object).astype(object) for _ in range(2))
    one, back = one.astype(int).astype(object), back.astype(int).astype(object)
    for _ in range(turns):
        i, j = random.choice(n, 2, replace=False)
        c = int(random.integers(-2, 3))
        one[:, j] = one[:, j] + c * one[:, i]
        back[i] = back[i] - c * back[j]
    assert (one @ back == np.eye(n).astype(int)).all()
    return one, back


def real_part(random: np.random.Generator) -> list[Fraction]:
    """A real part by powers of p: off the axis, simple, double, near-double or touching roots."""

    def dyadic(bits: int, most: float) -> Fraction:
        return Fraction(round(float(random.uniform(-most, most)) * 2**bits), 2**bits)

    kind = random.integers(0, 10)
    root, scale = dyadic(8, 0.95), 1 + abs(dyadic(3, 2))
    scale *= int(random.choice([-1, 1]))
    if kind < 4:
        return [-abs(dyadic(8, 1)) - Fraction(3, 8), dyadic(8, 0.3), Fraction(0)]
    if kind < 7:
        return [-scale * root, scale, Fraction(0)]
    if kind == 7:  # two roots, perhaps very near
        apart = Fraction(1, 2 ** int(random.integers(1, 22)))
        return [scale * root * (root + apart), -scale * (2 * root + apart), scale]
    lift = Fraction(0) if kind == 8 else Fraction(1, 2 ** int(random.integers(4, 24)))
    return [-abs(scale) * root * root - lift, 2 * abs(scale) * root, -abs(scale)]


def planted(random: np.random.Generator, n: int, turns: int, most: int = 4) -> Planted:
    """A matrix with at most some blocks that may meet the axis."""
    real, frequency, left = [], [], n
    while left:
        pair = left > 1 and random.random() < 0.6
        part = real_part(random)
        if len(real) >= most:
            part = [-Fraction(1 + len(real), 4), Fraction(0), Fraction(0)]
        real.append(part)
        frequency.append(Fraction(int(random.integers(1, 64)), 8) if pair else Fraction(0))
        left -= 1 + pair
    order = random.permutation(n)
    tables = [np.full((n, n), Fraction(0), dtype=object) for _ in range(3)]
    at = 0
    for part, turn in zip(real, frequency, strict=True):
        rows = range(at, at + 1 + (turn > 0))
        for i in rows:
            for table, c in zip(tables, part, strict=True):
                table[i, i] = c
        if turn:
            tables[0][at, at + 1], tables[0][at + 1, at] = turn, -turn
        at = rows[-1] + 1
    one, back = unimodular(random, n, turns)
    out = []
    for table in tables:
        moved = (one @ table @ back)[np.ix_(order, order)]
        out.append(moved.astype(float))
        assert all(Fraction(float(v)) == v for v in moved.ravel())
    return Planted(out, real, frequency)


def family(case: Planted) -> st.Family:
    p = ca.SX.sym("p")
    a, b, c = (ca.sparsify(ca.SX(ca.DM(table))) for table in case.tables)
    return st.linear(ca.sparsify(a + b * p + c * p * p))


def roots(part: list[Fraction]) -> list[float]:
    """Real roots of a real part, a double one twice."""
    c, b, a = part
    if not a:
        return [float(-c / b)] if b else []
    gap = b * b - 4 * a * c
    if gap < 0:
        return []
    width = np.sqrt(float(gap))
    return sorted((float(-b) + s * width) / float(2 * a) for s in (-1, 1))


def truth(case: Planted) -> tuple[list[float], list[float]]:
    """Values where the verdict changes, and values where a neutral member is alone."""
    every = [r for part in case.real for r in roots(part) if LOW < r < HIGH]
    ends = np.array(sorted({LOW, HIGH, *every}))
    middles = [Fraction(float(v)) for v in (ends[:-1] + ends[1:]) / 2]
    unstable = [any(c + b * m + a * m * m > 0 for c, b, a in case.real) for m in middles]
    sides = [(v, *pair) for v, pair in zip(ends[1:-1].tolist(), pairwise(unstable), strict=True)]
    return [v for v, a, b in sides if a != b], [v for v, a, b in sides if not a and not b]


def judged(case: Planted) -> str:
    """What is said of a planted matrix: complete or open; anything false fails."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        found = st.boundaries(family(case), axis=("p", LOW, HIGH, 9))
    changes, alone = truth(case)
    near = [min((abs(point.value - v) for v in changes), default=np.inf) for point in found]
    for point, off in zip(found, near, strict=True):
        assert off <= point.error + 1e-15 or not found.complete, (point, changes)
    if not found.complete:
        return "open"
    assert len(found) == len(changes), (found, changes)
    assert len(found.touching) == len(alone), (found, alone)
    return "complete"


@pytest.mark.parametrize("count", [3, pytest.param(60, marks=pytest.mark.long)])
def test_planted_boundaries_of_large_systems_are_all(count: int) -> None:
    random = np.random.default_rng([SEED, count])
    said = [
        judged(planted(random, int(random.integers(17, 33)), int(random.integers(10, 60))))
        for _ in range(count)
    ]
    assert said.count("complete") >= count // 3


@pytest.mark.parametrize("count", [12, pytest.param(600, marks=pytest.mark.long)])
def test_the_same_proofs_hold_for_small_systems(
    count: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(exact_search, "MOST_STATES", 0)
    random = np.random.default_rng([SEED, 7, count])
    said = []
    for _ in range(count):
        n = int(random.integers(2, 9))
        said.append(judged(planted(random, n, int(random.integers(0, 5 * n)))))
    assert said.count("complete") >= count // 3


@pytest.mark.parametrize("n", [9, pytest.param(28, marks=pytest.mark.long)])
def test_the_boundary_of_a_ring_of_cars_is_that_of_its_longest_wave(n: int) -> None:
    """λ (λ + a) = a V'(h) (ω - 1) with ωⁿ = 1 has λ = i w at a = 2 V'(h) cos²(π/n)."""
    x, p = ca.SX.sym("x", 2 * n), ca.SX.sym("p")
    gap, speed = x[:n], x[n:]
    drive = p * (ca.tanh(gap - 2.25) - speed)
    rates = ca.vertcat(ca.vertcat(speed[1:], speed[0]) - speed, drive)
    gaps, speeds = ([f"{v}{i}" for i in range(n)] for v in "hv")
    ring = st.System("ring", x, p, rates, states=gaps + speeds, parameters=("a",))
    guess = dict.fromkeys(speeds, -0.25)
    same = dict.fromkeys(gaps, 2.0)
    flow = st.Family(ring, "flow", at=("a",), held=same, unknown=guess, equations=speeds)
    found = st.boundaries(flow, axis=("a", 0.5, 4.0, 9))
    true = 2 / np.cosh(0.25) ** 2 * np.cos(np.pi / n) ** 2
    assert found.complete
    assert [(point.crossing.word, point.stable_below) for point in found] == [("flutter", False)]
    assert found[0].value == pytest.approx(true, rel=1e-14)


def test_a_defective_block_is_proved_by_polynomials_where_doubles_end() -> None:
    n, p = 17, ca.SX.sym("p")
    one, back = unimodular(np.random.default_rng(SEED), n, 30)
    jordan = (one @ (np.eye(n, k=1).astype(int) - 2 * np.eye(n).astype(int)) @ back).astype(float)
    family = st.linear(ca.SX(ca.DM(jordan)) + 0.25 * p * ca.SX.eye(n))
    found = st.boundaries(family, axis=("p", -1.0, 1.0, 9))
    assert found.complete
    assert not found.points
