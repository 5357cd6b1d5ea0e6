"""Neutral beyond unstable: spectra that are symmetric by structure, at known thresholds."""

from collections.abc import Callable
from fractions import Fraction
from math import isqrt
from typing import Any

import casadi as ca
import numpy as np
import pytest
from symmetric_systems import (
    STRAIGHT,
    body,
    column,
    rolling_disc,
    saddle,
    system,
    top_in_a_chart,
    top_in_space,
    top_pair,
    top_with_constraint,
    triangular_point,
)

import stability as st
from stability import Verdict
from stability.polynomials.identities import mirrored, sparse_zeros, symmetric

DISC = st.Family(rolling_disc(place=False), "straight", at=("u2",), held=STRAIGHT)
WHEEL = st.Family(rolling_disc(place=True), "straight", at=("u2",), held=STRAIGHT)
SPIN = st.Family(body(), "spin", at=("w",), held={"u": 0.0, "v": 0.0})
UNIT = {"I1": 1.0, "mgl": 1.0}
ROUTH = (1 - Fraction(isqrt(69 * 10**60), 9 * 10**30)) / 2
"""(1 - √69/9)/2, by a root in whole numbers."""
ZIEGLER = Fraction(7, 2) - Fraction(isqrt(2 * 10**60), 10**30)

Known = tuple[Callable[[], st.Family], str, dict[str, float], Fraction, bool, int]
THRESHOLDS: dict[str, Known] = {
    # family, axis, parameters, the threshold (30 digits or exact), neutral above it, zeros
    "top, pair": (top_pair, "W", {**UNIT, "I3": 0.5}, Fraction(4), True, 0),
    "top, in space": (top_in_space, "n", UNIT, Fraction(2), True, 2),
    "top, constraint": (top_with_constraint, "H", UNIT, Fraction(2), True, 2),
    "top, chart": (top_in_a_chart, "H", UNIT, Fraction(2), True, 0),
    "saddle": (saddle, "W", {"k": 2.0}, Fraction("1.41421356237309504880168872421"), True, 0),
    "L4": (triangular_point, "m", {}, ROUTH, False, 0),
    "column": (column, "P", {"damping": 0.0}, ZIEGLER, False, 0),
    "disc": (
        lambda: DISC,
        "u2",
        {"r": 1.0, "g": 1.0},
        Fraction("0.577350269189625764509148780502"),
        True,
        4,
    ),
    "wheel": (
        lambda: WHEEL,
        "u2",
        {"r": 1.0, "g": 1.0},
        Fraction("0.577350269189625764509148780502"),
        True,
        6,
    ),
    "body": (lambda: SPIN, "B", {"w": 1.0, "A": 1.0, "C": 2.0}, Fraction(2), False, 1),
}


def test_the_critical_mass_is_that_of_routh() -> None:
    assert float(ROUTH) == 0.038520896504551397  # published: .0385208965…


@pytest.mark.few(6)
@pytest.mark.parametrize("name", THRESHOLDS)
@pytest.mark.parametrize("far", [1e-12, 1e-3])
def test_verdicts_on_both_sides_of_a_threshold(name: str, far: float) -> None:
    make, axis, others, threshold, above, count = THRESHOLDS[name]
    family = make()
    for side in (-1, 1):
        value = float(threshold * (1 + side * Fraction(far)))
        assert (Fraction(value) > threshold) == (side > 0)
        if name == "body" and side > 0:  # the middle moment is now C, about which the body turns
            wanted = Verdict.UNSTABLE
        else:
            wanted = Verdict.NEUTRAL if (side > 0) == above else Verdict.UNSTABLE
        given = {**others, axis: value}
        at = {"at": given.pop(family.at[0])}
        for way in ({"certify": True}, {}):
            found = st.spectrum(family, **at, **given, **way)
            assert found.verdict is wanted
            assert found.structural_zeros == count
            assert found.eigenvalues.shape == (len(family.system.states) - count,)
        plain = st.spectrum(family, **at, **given, escalate=False)
        assert plain.verdict in (wanted, Verdict.UNDECIDED)
        if far > 1e-6 and name != "column":  # whose other members are damped
            assert plain.verdict is wanted  # λ² decides in double precision too
    if name != "column":
        assert symmetric(family)
        assert (
            "symmetric under λ → -λ by structure"
            in st.spectrum(family, **at, **given, certify=True).reason
        )


@pytest.mark.parametrize("name", THRESHOLDS)
def test_the_boundary_between_neutral_and_unstable_is_found(name: str) -> None:
    make, axis, others, threshold, above, _ = THRESHOLDS[name]
    family = make()
    given = dict(others)
    at = {"at": given.pop(family.at[0])} if family.at[0] in given else {}
    low, high = float(threshold) * 0.7, float(threshold) * 1.4
    found = st.boundaries(family, axis=(axis, low, high, 5), **at, **given)
    [point] = found
    assert abs(Fraction(point.value) - threshold) <= Fraction(point.error)
    assert point.stable_below == (not above)
    assert found.complete
    static = name in ("saddle", "disc", "wheel", "body")
    assert point.crossing is (st.Crossing.STATIC if static else st.Crossing.FLUTTER)


@pytest.mark.parametrize("damping", [1e-12, 1e-17, 1e-300])
def test_a_little_damping_is_never_neutral(damping: float) -> None:
    """Kirillov & Verhulst: with damping however small the limit is 41/28 + b²/2, not 7/2 - √2."""
    family = column()
    assert not symmetric(family)
    for load, wanted in ((1.4, Verdict.STABLE), (1.5, Verdict.UNSTABLE), (2.05, Verdict.UNSTABLE)):
        for way in ({"certify": True}, {}):
            assert st.spectrum(family, at=load, damping=damping, **way).verdict is wanted
        plain = st.spectrum(family, at=load, damping=damping, escalate=False).verdict
        assert plain in (wanted, Verdict.UNDECIDED)


def gain_and_loss() -> st.Family:
    """Two coupled oscillators, one with damping p and one with gain q."""
    pair = system(
        "pair",
        "abcd",
        ("p", "q"),
        lambda x, p, q: (
            x[2],
            x[3],
            -2 * x[0] + 1.5 * x[1] - p * x[2],
            -2 * x[1] + 1.5 * x[0] + q * x[3],
        ),
    )
    return st.Family(pair, "rest", at=("p",), held=dict.fromkeys("abcd", 0.0))


def test_a_symmetry_of_single_members_is_not_that_of_the_family() -> None:
    """Gain equals loss: the polynomial is even there, and neutral is proved there alone."""
    family = gain_and_loss()
    assert not symmetric(family)
    assert st.spectrum(family, at=0.5, q=0.5, certify=True).verdict is Verdict.NEUTRAL
    for p in (np.nextafter(0.5, 1), np.nextafter(0.5, 0), 0.5 + 1e-9, 0.5 - 1e-9):
        wanted = Verdict.STABLE if p > 0.5 else Verdict.UNSTABLE
        for way in ({"certify": True}, {}):
            assert st.spectrum(family, at=p, q=0.5, **way).verdict is wanted
        plain = st.spectrum(family, at=p, q=0.5, escalate=False).verdict
        assert plain in (wanted, Verdict.UNDECIDED)


def test_blocks_do_not_share_a_symbol_for_different_entries() -> None:
    """Eigenvalues -e^y and e^y - p: no mirror images, though each block is one expression."""
    pair = system("pair", "yz", ("p",), lambda x, p: (p - ca.exp(x[0]), (ca.exp(x[0]) - 3) * x[1]))
    family = st.Family(
        pair, "rest", at=("p",), held={"z": 0.0}, unknown={"y": 0.5}, equations=("y",)
    )
    assert not symmetric(family)
    assert st.spectrum(family, at=2.0, certify=True).verdict is Verdict.STABLE
    assert st.spectrum(family, at=4.0, certify=True).verdict is Verdict.UNSTABLE


def test_a_symmetric_spectrum_is_proved_at_a_size_where_nothing_is_multiplied_out() -> None:
    """A chain of twenty pendulums of irrational lengths: every cycle of the graph is even."""
    n = 20
    states = [f"q{i}" for i in range(n)] + [f"v{i}" for i in range(n)]

    def rates(x: Any, k: Any) -> list[Any]:
        q, v = x[:n], x[n:]
        ends = ca.vertcat(0, q, 0)
        pull = [k * ca.sin(ends[i] - 2 * ends[i + 1] + ends[i + 2]) * ca.exp(k) for i in range(n)]
        return [*ca.vertsplit(v), *[pull[i] - ca.sqrt(2 + k) * ca.sin(q[i]) for i in range(n)]]

    chain = system("chain", states, ("k",), rates)
    family = st.Family(chain, "rest", at=("k",), held=dict.fromkeys(states, 0.0))
    assert symmetric(family)
    assert st.spectrum(family, at=0.3).verdict is Verdict.NEUTRAL


@pytest.mark.parametrize("count", [80, pytest.param(150, marks=pytest.mark.long)])
def test_places_of_zeros_prove_zeros_and_symmetry_of_random_matrices(count: int) -> None:
    rng = np.random.default_rng(3)
    seen = [0, 0]
    for _ in range(count):
        n = int(rng.integers(1, 6))
        pattern = rng.random((n, n)) < rng.choice([0.15, 0.3])
        many, even = sparse_zeros(pattern), mirrored(pattern)
        ranks = []
        for _ in range(3):
            matrix = pattern * rng.integers(1, 10**6, (n, n)).astype(object)
            poly = exact_polynomial(matrix.tolist())
            ranks.append(next(i for i, c in enumerate(poly) if c != 0))
            assert not even or not any(c for i, c in enumerate(poly) if (n - i) % 2)
        assert min(ranks) == many
        seen[0] += many > 0
        seen[1] += even and many < n
    assert min(seen) > count // 30


def exact_polynomial(rows: list[list[Any]]) -> list[Fraction]:
    from planted_structure import polynomial

    return polynomial([[Fraction(int(v)) for v in row] for row in rows])
