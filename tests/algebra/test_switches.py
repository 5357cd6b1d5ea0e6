"""Maxima, branches and comparisons: the pieces by hand, and CasADi's own values of the graph."""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np
import pytest
import sympy as sm

import stability as st
from stability.algebra.switches import by_signs
from stability.base.errors import DomainError


def rest(rate: Any, x: ca.SX, p: ca.SX, held: float = 0.0) -> st.Family:
    system = st.System("pieces", x, p, rate, states=("x",), parameters=("p",))
    return st.Family(system, "rest", at=("p",), held={"x": held})


def grown(chance: np.random.Generator, symbols: list[ca.SX], depth: int) -> ca.SX:
    """A random expression with switches."""
    if depth == 0:
        return symbols[chance.integers(len(symbols))] + float(chance.normal())
    a, b, c, d = (grown(chance, symbols, depth - 1) for _ in range(4))
    makers = [
        lambda: ca.fmax(a, b),
        lambda: ca.fmin(a, b) * c,
        lambda: ca.if_else(a < b, c, d),
        lambda: ca.if_else(ca.logic_and(a > b, c <= d), a, d),
        lambda: ca.if_else(ca.logic_or(a >= b, ca.logic_not(c > d)), b - c, a),
        lambda: ca.if_else(a != b, c, d) + ca.if_else(a == b, a, b),
        lambda: ca.fabs(a) * ca.sign(b) - ca.sin(c),
    ]
    return makers[chance.integers(len(makers))]()


@pytest.mark.parametrize("seed", range(12))
def test_a_graph_by_signs_has_the_values_of_its_pieces(seed: int) -> None:
    chance = np.random.default_rng(seed)
    x, p = ca.SX.sym("x", 2), ca.SX.sym("p", 2)
    graph = ca.vertcat(*[grown(chance, [*ca.vertsplit(x), *ca.vertsplit(p)], 3) for _ in range(2)])
    written = by_signs([x, p], [graph])
    if written is None:  # no switch was drawn
        return
    one, two = (ca.Function("f", [x, p], [g]) for g in (graph, written[0]))
    slopes = [ca.Function("f", [x, p], [ca.jacobian(g, x)]) for g in (graph, written[0])]
    for _ in range(50):
        place = chance.normal(size=2), chance.normal(size=2)
        assert np.array(one(*place)) == pytest.approx(np.array(two(*place)), rel=1e-13, abs=1e-13)
        first, second = (np.array(ca.densify(s(*place))) for s in slopes)
        assert first == pytest.approx(second, rel=1e-12, abs=1e-12)


def test_each_piece_has_its_own_proved_boundaries() -> None:
    """The slope is p - 1/2 for 0 < p < 1 and -1 elsewhere: one crossing, and two switches."""
    x, p = ca.SX.sym("x"), ca.SX.sym("p")
    family = rest(ca.if_else(ca.logic_and(p > 0, p < 1), x * (p - 0.5), -x), x, p)
    with pytest.warns(st.StabilityWarning, match="not complete"):
        found = st.boundaries(family, axis=("p", -1, 2, 7))
    assert [b.value for b in found] == [0.5]
    assert [(u.low < s < u.high) for u, s in zip(found.unresolved, (0, 1), strict=True)] == [
        True
    ] * 2
    assert "the same on both sides" in found.unresolved[0].reason
    assert "differs on the two sides" in found.unresolved[1].reason
    words = [st.spectrum(family, at=at, certify=True).verdict.word for at in (-1, 0.25, 0.75, 2)]
    assert words == ["stable", "stable", "unstable", "stable"]


def test_a_map_has_the_larger_of_two_numbers_in_each_cell() -> None:
    """On the diagonal, where the two are equal, no cell lies: a maximum has no slope there."""
    x, p, q = (ca.SX.sym(n) for n in "xpq")
    rates = -ca.fmax(p, q) * x
    system = st.System("two", x, ca.vertcat(p, q), rates, states=("x",), parameters=("p", "q"))
    family = st.Family(system, "rest", at=("p",), held={"x": 0})
    cells = st.stability_map(family, x=("p", -1, 1, 6), y=("q", -0.9, 0.9, 6))
    larger = np.maximum(cells.p.values[None, :], cells.q.values[:, None])
    assert (np.asarray(cells.verdict) == np.where(larger > 0, 1, 2)).all()


def test_on_a_switch_of_slopes_there_is_no_verdict() -> None:
    x, p = ca.SX.sym("x"), ca.SX.sym("p")
    for rate in (-p * ca.fmax(x, x / 2), ca.if_else(x > 0, -x, -2 * x)):
        with pytest.raises(DomainError, match="max\\(x, 0\\) on its switch"):
            st.spectrum(rest(rate, x, p), at=1.0)
    away = rest(ca.if_else(x > 1, -p * (x - 2), x), x, p, held=2.0)
    assert st.spectrum(away, at=1.5, certify=True).eigenvalues == [-1.5]


def test_a_motion_crosses_switches() -> None:
    """ẍ = -1 above 0 and +1 below: parabolas of the quarter period √2."""
    x, p = ca.SX.sym("x", 2), ca.SX.sym("p", 0)
    pull = ca.if_else(x[0] > 0, -1, 1)
    system = st.System("bang", x, p, ca.vertcat(x[1], pull), states=("x", "v"), parameters=())
    run = st.simulate(system, [], [1.0, 0.0], [1.0, 3.0, 7.0])
    quarter = 2**0.5
    second, third = 2 * quarter - 3, 7 - 4 * quarter  # times from the rests at ∓1
    exact = [0.5, second**2 / 2 - 1, 1 - third**2 / 2]
    off = np.abs(np.asarray(run.x) - exact).max()
    assert off <= float(run.final_error) or off < 1e-9


def test_pieces_of_sympy_are_read() -> None:
    x, p = sm.symbols("x p")
    rates = [
        sm.Piecewise((-p * x, x < 1), (x, True)),
        sm.Piecewise((x, sm.And(x > 1, p > 0)), (-p * x, sm.Not(x > 2)), (sm.Integer(7), True)),
        -p * sm.Max(x / 3, x - 1, 2 * x - 5),
        -p * x * sm.sign(1 + x),
        -p * x * sm.Heaviside(1 - x),
        -p * sm.Min(x / 7, 1),
    ]
    slopes = [-1.0, -1.0, -1 / 3, -1.0, -1.0, -1 / 7]
    for rate, slope in zip(rates, slopes, strict=True):
        system = st.System.from_sympy({x: rate}, parameters=[p])
        family = st.Family(system, "rest", at=("p",), held={"x": 0})
        found = st.spectrum(family, at=1, certify=True)
        assert found.eigenvalues == pytest.approx([slope], rel=1e-15)
        assert found.verdict is st.Verdict.STABLE
