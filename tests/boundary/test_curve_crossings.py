"""Curves of a map that cross go straight on, and those that do not cross keep apart.

Oracle: planted curves, whose crossings are known in closed form; the Euler top.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import casadi as ca
import numpy as np
import pytest
import xarray as xr

import stability as st
from stability.boundary import curves

AXES: dict[str, Any] = {"x": ("p", -1, 1, 41), "y": ("q", -1, 1, 31)}
U, V = 0.0137, 0.0171


def planted(function: Callable[[Any, Any], Any], pair: bool) -> xr.Dataset:
    """A map whose members are stable where a function is positive, by one eigenvalue or a pair."""
    x, p = ca.SX.sym("x", 2), ca.SX.sym("p", 2)
    f = function(p[0], p[1])
    turn = 2 if pair else 0
    rates = ca.vertcat(-f * x[0] - turn * x[1], turn * x[0] - (f if pair else 1) * x[1])
    system = st.System("planted", x, p, rates, states=("a", "b"), parameters=("p", "q"))
    rest = st.Family(system, "rest", at=("p",), held={"a": 0, "b": 0})
    return st.stability_map(rest, **AXES)


def pieces(drawn: xr.Dataset, x: str = "p", y: str = "q") -> list[tuple[Any, Any, Any]]:
    numbers = drawn.boundary_curve.values
    columns = (drawn[f"boundary_{n}"].values for n in (x, y, "error"))
    parts = np.array(list(columns))
    return [tuple(parts[:, numbers == k]) for k in np.unique(numbers)]


@pytest.mark.parametrize("pair", [False, True], ids=["real", "pair"])
@pytest.mark.parametrize(
    ("first", "second", "crossing"),
    [
        (lambda p, _: p - U, lambda _, q: q - V, (U, V)),
        (lambda p, q: p - U - q + V, lambda p, q: p - U + q - V, (U, V)),
        (lambda p, q: p - U - 4 * (q - V), lambda p, q: 4 * (p - U) - q + V, (U, V)),
    ],
    ids=["upright", "oblique", "narrow"],
)
def test_two_lines_that_cross_are_two_straight_lines(
    first: Any, second: Any, crossing: tuple[float, float], pair: bool
) -> None:
    drawn = planted(lambda p, q: first(p, q) * second(p, q), pair)
    assert drawn.attrs["boundary_unresolved"] == 0
    curves = pieces(drawn)
    assert len(curves) == 2
    for x, y, error in curves:
        assert min(np.abs(f(x, y)).max() for f in (first, second)) < 1e-12
        place = np.flatnonzero(np.hypot(x - crossing[0], y - crossing[1]) < 1e-11)
        assert len(place) == 1 and 0 < place[0] < len(x) - 1
        assert 0 < error[place[0]] < 1e-11
        assert np.delete(error, place).max() < 1e-15
    kinds = {st.Crossing.FLUTTER.code if pair else st.Crossing.STATIC.code}
    assert set(drawn.boundary_kind.values.tolist()) == kinds
    assert drawn.boundary_frequency.values == pytest.approx(2.0 * pair)


@pytest.mark.parametrize("gap", [3e-4, -3e-4, 1e-7, -1e-7])
def test_two_arcs_within_one_cell_keep_apart(gap: float) -> None:
    """Of u v = gap: the diagonal on which the arcs' corners lie is that of the sign of the gap."""
    drawn = planted(lambda p, q: (p - U) * (q - V) - gap, False)
    curves = pieces(drawn)
    assert len(curves) == 2
    for x, y, _ in curves:
        u, v = x - U, y - V
        assert np.abs(u * v - gap).max() < 1e-14
        assert (u > 0).all() or (u < 0).all()
        assert (v > 0).all() or (v < 0).all()


def test_a_line_through_a_circle_crosses_it_twice() -> None:
    """Sides of a tip were once followed beyond the crossing, to the end of the map."""
    drawn = planted(lambda p, q: (p * p + q * q - 0.36) * (p - q - 0.1), False)
    curves = pieces(drawn)
    assert len(curves) == 2
    off = [
        (np.abs(x - y - 0.1).max(), np.abs(x**2 + y**2 - 0.36).max(), np.diff(x), np.diff(y))
        for x, y, _ in curves
    ]
    assert sorted(np.argmin(v[:2]) for v in off) == [0, 1]
    for line, circle, along, up in off:
        assert min(line, circle) < 1e-11
        assert np.hypot(along, up).max() < 0.12


def test_no_bracket_is_sought_along_a_boundary(monkeypatch: pytest.MonkeyPatch) -> None:
    """At ω₃ = 2 a spinning disk is neutral up to μ = 1, and only there the line has a neighbour."""
    sought: list[float] = []

    def refine(line: Any, low: float, high: float) -> Any:
        sought.append(low)
        return real(line, low, high)

    real = curves.refine
    monkeypatch.setattr(curves, "refine", refine)
    axes = {"x": ("at", 1.0, 3.0, 41), "y": ("mu", 0.05, 3.0, 30)}
    chart = st.stability_map("spinning", **axes)
    assert chart.at.values[20] == 2
    assert (chart.verdict.values[:, 20] == st.Verdict.NEUTRAL.code).sum() > 5
    assert chart.boundary_unresolved == 1
    assert not sought


def test_a_wedge_round_one_grid_point_is_not_followed_across_the_map() -> None:
    """It once had 1271 points, and a line of eleven cells from one side to the other."""
    (a, b), (u, v) = (2.35744043, 1.80473973), (0.11727214, 0.00655149)
    lines = [lambda p, q, t=t: np.cos(t) * (p - u) + np.sin(t) * (q - v) for t in (a, b)]
    drawn = planted(lambda p, q: lines[0](p, q) * lines[1](p, q), True)
    assert drawn.sizes["boundary_point"] < 200
    for x, y, _ in pieces(drawn):
        assert np.minimum(*(np.abs(line(x, y)) for line in lines)).max() < 1e-11
        assert np.hypot(np.diff(x), np.diff(y)).max() < 0.12


@pytest.mark.parametrize("count", [(41, 41), (40, 37)])
def test_the_euler_tops_lines_cross_where_all_moments_are_equal(count: tuple[int, int]) -> None:
    """Rotation about the first axis is neutral where I₁ is the largest or the least moment."""
    x, p = ca.SX.sym("x", 3), ca.SX.sym("p", 3)
    rates = [(p[i - 2] - p[i - 1]) * x[i - 2] * x[i - 1] / p[i] for i in range(3)]
    system = st.System(
        "top", x, p, ca.vertcat(*rates), states=("a", "b", "c"), parameters=("I1", "I2", "I3")
    )
    about = st.Family(system, "first axis", at=("a",), held={"b": 0, "c": 0}, conservative=True)
    drawn = st.stability_map(
        about, x=("I1", 1, 3, count[0]), y=("I2", 1, 3, count[1]), I3=2.0, at=1.0
    )
    curves = pieces(drawn, "I1", "I2")
    assert len(curves) == 2
    ends = set()
    for one, two, _ in curves:
        assert min(np.abs(one - 2).max(), np.abs(one - two).max()) < 1e-11
        assert np.hypot(one - 2, two - 2).min() < 1e-11
        assert np.abs(np.diff(two)).max() < 0.2
        ends |= {(round(float(one[k]), 9), round(float(two[k]), 9)) for k in (0, -1)}
    assert ends == {(1.0, 1.0), (3.0, 3.0), (2.0, 1.0), (2.0, 3.0)}
