"""Boundaries at symmetric pitchforks of families that are solved for and are not algebraic."""

from __future__ import annotations

import math

import casadi as ca
import numpy as np
import pytest
from own_systems import symbols, system_of
from scipy.optimize import brentq

import stability as st
from stability.systems.symmetry import symmetric_family


def columns(sign: int) -> st.Family:
    """Two columns on springs, coupled so that x = sign u: a pitchfork where k cos x = 1 + 2 c."""
    x, v, u, w, k, c = symbols(*"xvuwkc")
    pull = c * ca.sin(sign * u - x)
    rates = ca.vertcat(
        v,
        k * ca.sin(x) - x + pull + 0.1 - v,
        w,
        k * ca.sin(u) - u - sign * pull + sign * 0.1 - w,
    )
    system = system_of("columns", [x, v, u, w], [k, c], rates)
    guess = {"x": 0.2, "u": sign * 0.2, "v": 0, "w": 0, "k": 0.5}
    return system.steady("k", guess=guess, c=-0.3)


def angle(k: float) -> float:
    return float(brentq(lambda x: k * math.sin(x) - x + 0.1, 0, 3.2, xtol=1e-15))


def crossings() -> list[float]:
    def growth(k: float) -> float:
        return k * math.cos(angle(k)) - 1 + 0.6

    places = np.linspace(0.2, 3, 100)
    pairs = zip(places, places[1:], strict=False)
    return [float(brentq(growth, a, b, xtol=1e-15)) for a, b in pairs if growth(a) * growth(b) < 0]


def test_two_neurons_differ_beyond_the_pitchfork() -> None:
    x, y, p, q = symbols(*"xypq")
    rates = ca.vertcat(-x + q - p * ca.tanh(y), -y + q - p * ca.tanh(x))
    pair = system_of("neurons", [x, y], [p, q], rates)
    even = pair.steady("p", guess={"x": 0.3, "y": 0.3, "p": 0.5}, q=0.5)
    found = st.boundaries(even, axis=("p", 0.2, 4, 40), q=0.5)
    assert found.complete and "symmetric" in found.how
    [point] = found

    def growth(p: float) -> float:
        x = brentq(lambda x: -x + 0.5 - p * math.tanh(x), 0, 1, xtol=1e-15)
        return p / math.cosh(x) ** 2 - 1

    assert point.value == pytest.approx(brentq(growth, 1, 1.2, xtol=1e-15), abs=1e-13)
    assert (point.crossing.word, point.stable_below, point.good.word) == ("static", True, "stable")
    [same] = st.branch(even, 0.2, 4, q=0.5, arclength=True).branch_points
    assert same.kind == "pitchfork" and same.value == pytest.approx(point.value, abs=1e-13)


@pytest.mark.parametrize("sign", [1, -1])
def test_every_pitchfork_of_a_symmetric_branch_is_listed(sign: int) -> None:
    found = st.boundaries(columns(sign), axis=("k", 0.2, 3, 40), c=-0.3)
    assert found.complete
    assert [b.value for b in found] == pytest.approx(crossings(), abs=1e-13)
    assert [b.stable_below for b in found] == [True, False]


def test_a_symmetry_that_is_only_nearly_one_is_not_taken() -> None:
    x, y, p, e = symbols(*"xype")
    rates = ca.vertcat(
        p * ca.sin(x) - 2 * x + y + (1 + e) * ca.exp(0.1), p * ca.sin(y) - 2 * y + x + ca.exp(0.1)
    )
    system = system_of("near", [x, y], [p, e], rates)
    family = system.steady("p", guess={"x": 2, "y": 2, "p": 0.5}, e=0.0)
    state, way = np.array([2.0, 2.0]), np.array([1.0, -1.0])
    assert symmetric_family(family, state, way) is None  # e is a parameter, which may differ from 0


def test_a_crossing_branch_without_a_symmetry_is_named_and_ends_the_search_early() -> None:
    x, p = symbols(*"xp")
    rate = -(x - ca.sin(p)) * (ca.exp(x) - 1 - 2 * p)
    system = st.System("two branches", x, p, rate, states=("x",), parameters=("p",))
    family = system.steady("p", guess={"x": math.sin(0.5), "p": 0.5})
    with pytest.warns(st.StabilityWarning, match="crosses at p = 0, a transcritical point"):
        found = st.boundaries(family, axis=("p", -0.7, 0.8, 40))
    [left] = found.unresolved
    assert left.low < 0 < left.high and left.high - left.low < 1e-4
