"""Numbers of unstable eigenvalues in the cells of maps, against exact counts."""

from fractions import Fraction

import casadi as ca
import numpy as np
import pytest
from planted_crossings import HIGH, LOW, Plan

import stability as st


def test_planted_numbers_are_those_of_the_map() -> None:
    values = set()
    for seed in (6, 13, 14, 16, 18):
        plan = Plan(seed)
        family, _ = plan.family("rational", pace=True)
        m = st.stability_map(
            family, x=("q", LOW, HIGH, 33), y=("s", 1, 2, 2), boundaries=False, unstable=True
        )
        for q, counts in zip(m.q.values, m.unstable.values.T, strict=True):
            p = Fraction(q)
            expected = sum(block.unstable(p) for block in plan.blocks)
            on_axis = any(zero(p) == 0 for block in plan.blocks for zero in block.zeros())
            assert all(n == expected or (n == -1 and on_axis) for n in counts)
            values.add(expected)
        assert f"in {(m.unstable.values < 0).sum()} of 66 cells" in m.unstable.comment
    assert len(values) > 3


def test_numbers_of_a_conservative_system_are_those_of_its_squares() -> None:
    """λ⁴ + (g² - a - b) λ² + a b: of ±√y one is unstable, unless y is real and negative."""
    x, p, g = ca.SX.sym("x", 4), ca.SX.sym("p", 2), 1.5
    rates = ca.vertcat(x[1], p[0] * x[0] + g * x[3], x[3], p[1] * x[2] - g * x[1])
    system = st.System("spin", x, p, rates, states=tuple("xuyv"), parameters=("a", "b"))
    family = st.Family(system, "rest", at=("a",), held=dict.fromkeys("xuyv", 0.0))
    m = st.stability_map(family, x=("a", -2, 2.1, 40), y=("b", -1.9, 2, 37), unstable=True)
    a, b = np.meshgrid(m.a.values, m.b.values)
    half = (a + b - g * g) / 2
    root = np.sqrt((half**2 - a * b).astype(complex))
    squares = np.array([half + root, half - root])
    expected = 2 - ((squares.imag == 0) & (squares.real < 0)).sum(axis=0)
    assert np.array_equal(m.unstable.values, expected) and set(expected.flat) == {0, 1, 2}


def test_a_map_counts_on_request_alone() -> None:
    m = st.stability_map("rolling", x=("at", 0.1, 3, 9), y=("mu", 0.1, 2, 5), unstable=True)
    edges = {"below": m.at < 3**-0.5, "above": m.at > 2**0.5}  # for every mu
    assert (m.unstable.where(edges["below"], 1) == 1).all()
    assert (m.unstable.where(edges["above"], 0) == 0).all()
    assert (m.unstable.where(~edges["below"] & ~edges["above"], 2) == 2).all()
    plain = st.stability_map("rolling", x=("at", 0.1, 3, 9), y=("mu", 0.1, 2, 5))
    assert "unstable" not in plain and plain.equals(m.drop_vars("unstable"))


def test_regions_are_named_by_their_numbers() -> None:
    m = st.stability_map("spinning", x=("at", 0.1, 4, 40), y=("mu", 0.1, 2, 20), unstable=True)
    figure = st.plot_map(m, unstable=True)
    words = {text.get_text() for text in figure.axes[0].texts}
    assert {"0", "1", "2"} <= words and not {"stable", "unstable"} & words
    with pytest.raises(st.StabilityError, match="ask stability_map with unstable=True"):
        st.plot_map(m.drop_vars("unstable"), unstable=True)
