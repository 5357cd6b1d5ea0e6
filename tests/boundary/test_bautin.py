"""Vanishing first Lyapunov coefficients over Q against formulas, projections and published points.

Oracles: the coefficient of a planar system in closed form (A. A. Andronov et al., Theory of
Bifurcations of Dynamic Systems on a Plane, 1973; L. Perko, Differential Equations and Dynamical
Systems, § 4.4) with SymPy's resultants and real roots; the projection in NumPy's complex arithmetic
along a boundary in closed form; the Watt governor (Sotomayor, Mello & Braga, arXiv
math/0606230).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import casadi as ca
import numpy as np
import pytest
import sympy
from scipy.optimize import brentq

import stability as st
from stability.boundary.two_parameters import bautin
from stability.boundary.two_parameters.point_records import PointKind

VANISHING = PointKind.VANISHING


def at_rest(states: str, rates: Any, **options: Any) -> st.Family:
    x, p = ca.SX.sym("x", len(states)), ca.SX.sym("p", 2)
    system = st.System("planted", x, p, rates(x, p), states=tuple(states), parameters=("p", "q"))
    return st.Family(system, "rest", at=("p",), held=dict.fromkeys(states, 0), **options)


def searched(family: st.Family, x: tuple[float, float], y: tuple[float, float]) -> Any:
    found = st.codimension_two(family, x=("p", *x, 2), y=("q", *y, 2))
    assert "isolated over Q" in found.vanishing, found.vanishing
    return found


def points(found: Any) -> list[tuple[float, float]]:
    return [(p.x, p.y) for p in found if p.kind is VANISHING]


def close(some: Sequence[Any], true: Sequence[Any], size: float = 1e-10) -> bool:
    pairs = zip(sorted(some), sorted(true), strict=True)
    return all(
        abs(float(a) - float(b)) <= size for u, v in pairs for a, b in zip(u, v, strict=True)
    )


# --- planar systems ---

NAMES = ("20", "11", "02", "30", "21", "12", "03")


def planar(table: Any, p: Any, q: Any) -> tuple[list[Any], list[list[Any]]]:
    """Linear part (a, b, c, d) and the other coefficients of both rates, each of degree one."""
    linear = [r[0] + r[1] * p + r[2] * q for r in table[:4]]
    rest = [r[0] + r[1] * p + r[2] * q for r in table[4:]]
    return linear, [rest[:7], rest[7:]]


def closed_form(linear: list[Any], rest: list[list[Any]]) -> Any:
    """The coefficient times a number that is not zero where the trace vanishes."""
    a, b, c, _ = linear
    f, g = (dict(zip(NAMES, row, strict=True)) for row in rest)
    first = (
        a * c * (f["11"] ** 2 + f["11"] * g["02"] + f["02"] * g["11"])
        + a * b * (g["11"] ** 2 + f["20"] * g["11"] + f["11"] * g["20"])
        + c**2 * (f["11"] * f["02"] + 2 * f["02"] * g["02"])
        - 2 * a * c * (g["02"] ** 2 - f["20"] * f["02"])
        - 2 * a * b * (f["20"] ** 2 - g["20"] * g["02"])
        - b**2 * (2 * f["20"] * g["20"] + g["11"] * g["20"])
        + (b * c - 2 * a**2) * (g["11"] * g["02"] - f["11"] * f["20"])
    )
    second = 3 * (c * g["03"] - b * f["30"]) + 2 * a * (f["21"] + g["12"])
    return first - (a**2 + b * c) * (second + c * f["12"] - b * g["21"])


def planar_rates(table: Any) -> Any:
    def rates(x: Any, p: Any) -> Any:
        (a, b, c, d), rest = planar(table, p[0], p[1])
        u, v = x[0], x[1]
        terms = [u**2, u * v, v**2, u**3, u**2 * v, u * v**2, v**3]
        tail = [sum(k * t for k, t in zip(row, terms, strict=True)) for row in rest]
        return ca.vertcat(a * u + b * v + tail[0], c * u + d * v + tail[1])

    return rates


def crossings(table: Any, size: int) -> list[tuple[float, float]]:
    """Points of a square with zero trace, a pair, and no coefficient: by SymPy."""
    p, q = sympy.symbols("p q")
    linear, rest = planar([[sympy.Integer(int(v)) for v in r] for r in table], p, q)
    a, b, c, d = linear
    of_p = sympy.solve(a + d, q)[0]
    poly = sympy.Poly(sympy.expand(closed_form(linear, rest).subs(q, of_p)), p)
    out = []
    for u in sympy.real_roots(poly):
        at = {p: u.evalf(40), q: of_p.subs(p, u).evalf(40)}
        if (a * d - b * c).subs(at) > 0 and max(map(abs, at.values())) <= size:
            out.append((float(at[p]), float(at[q])))
    return out


@pytest.mark.parametrize(
    ("seed", "least"), [(6, 1), *(pytest.param(k, 0, marks=pytest.mark.long) for k in range(7, 50))]
)
def test_random_planar_families_have_the_points_of_the_closed_form(seed: int, least: int) -> None:
    rng = np.random.default_rng(seed)
    count = 0
    for _ in range(2):
        table = rng.integers(-4, 5, (18, 3))
        table[3, 2] = 1 - table[0, 2]  # the trace contains q
        found = searched(at_rest("uv", planar_rates(table)), (-3, 3), (-3, 3))
        true = crossings(table, 3)
        assert found.vanishing_complete
        assert close(points(found), true), (points(found), true)
        count += len(true)
    assert count >= least


def test_points_in_a_corner_belong_to_the_rectangle_and_those_next_to_it_do_not() -> None:
    """On p = q² the coefficient has the sign of (q - 1/4)(q + 1/2)(q - 3/4): three points."""

    def rates(x: Any, p: Any) -> Any:
        u, v = x[0] + 2 * x[1], x[1] - x[0]  # the normal form in oblique coordinates
        r, s = u**2 + v**2, (p[1] - 0.25) * (p[1] + 0.5) * (p[1] - 0.75)
        du = (p[0] - p[1] ** 2) * u - 2 * v + s * r * u
        dv = 2 * u + (p[0] - p[1] ** 2) * v + s * r * v
        return ca.vertcat((du - 2 * dv) / 3, (du + dv) / 3)

    family = at_rest("uv", rates)
    found = searched(family, (-1, 1), (-1, 1))
    assert points(found) == [(0.0625, 0.25), (0.25, -0.5), (0.5625, 0.75)]
    assert found.vanishing_complete and found.complete
    assert all(p.frequencies == (2.0,) and p.others == "stable" for p in found)
    assert points(searched(family, (0.0625, 0.25), (-0.5, 0.25))) == [(0.0625, 0.25), (0.25, -0.5)]
    inside = np.nextafter(0.0625, 1), np.nextafter(0.25, 0)
    near = searched(family, inside, (-0.5, 0.25))
    assert points(near) == [] and near.vanishing_complete


# --- three states ---


def jerk(table: Any, turn: Any) -> Any:
    """X''' = -c x - q x' - p x'' + quadratic and cubic terms, in other coordinates."""

    def rates(x: Any, p: Any) -> Any:
        y = ca.DM(turn) @ x
        terms = nonlinear(table, [y[0], y[1], y[2]])
        last = -2 * y[0] - p[1] * y[1] - p[0] * y[2] + terms
        back = np.round(np.linalg.inv(turn))  # whole numbers: the determinant is 1
        return ca.DM(back) @ ca.vertcat(y[1], y[2], last)

    return rates


def nonlinear(table: Any, y: Any) -> Any:
    pairs = [(0, 0), (0, 1), (1, 1), (0, 2)]
    quadratic = sum(int(k) * y[i] * y[j] for k, (i, j) in zip(table[:4], pairs, strict=True))
    return quadratic + int(table[4]) * y[0] ** 3 + int(table[5]) * y[0] ** 2 * y[1]


def projected(table: Any, p: float) -> float:
    """L1 on the boundary p q = 2, up to a positive factor, by the projection in NumPy."""
    q = 2 / p
    w = np.sqrt(q)
    a = np.array([[0, 1, 0], [0, 0, 1], [-2, -q, -p]], dtype=complex)
    mode = np.array([1, 1j * w, -(w**2)])
    values, vectors = np.linalg.eig(a.T)
    left = vectors[:, np.argmin(abs(values - 1j * w))]
    left = left / (left @ mode)
    pairs = [(0, 0), (0, 1), (1, 1), (0, 2)]

    def second(u: Any, v: Any) -> Any:
        total = sum(
            k * (u[i] * v[j] + u[j] * v[i]) for k, (i, j) in zip(table[:4], pairs, strict=True)
        )
        return np.array([0, 0, total])

    def third(u: Any, v: Any, z: Any) -> Any:
        mixed = u[0] * v[0] * z[1] + u[0] * v[1] * z[0] + u[1] * v[0] * z[0]
        return np.array([0, 0, 6 * table[4] * u[0] * v[0] * z[0] + 2 * table[5] * mixed])

    bar = mode.conj()
    total = left @ third(mode, mode, bar)
    total -= 2 * left @ second(mode, np.linalg.solve(a, second(mode, bar)))
    total += left @ second(bar, np.linalg.solve(2j * w * np.eye(3) - a, second(mode, mode)))
    return float(total.real)


@pytest.mark.long
@pytest.mark.parametrize(
    ("seed", "least"), [(3, 1), *(pytest.param(k, 0, marks=pytest.mark.long) for k in range(4, 40))]
)
def test_random_families_of_three_states_have_the_points_of_the_projection(
    seed: int, least: int
) -> None:
    rng = np.random.default_rng(seed)
    turn = np.array([[1, 0, 0], [2, 1, 0], [-1, 3, 1]]) @ np.array(
        [[1, 1, 0], [0, 1, -2], [0, 0, 1]]
    )
    count = 0
    for _ in range(3):
        table = rng.integers(-4, 5, 6)
        found = searched(at_rest("uvw", jerk(table, turn)), (0.25, 5), (0.25, 9))
        grid = np.geomspace(0.25, 5, 4001)
        grid = grid[(grid * 0.25 <= 2) & (grid * 9 >= 2)]
        size = [projected(table, p) for p in grid]
        pieces = [
            (a, b) for a, b, s, t in zip(grid, grid[1:], size, size[1:], strict=False) if s * t < 0
        ]
        roots = [
            brentq(lambda p, t: projected(t, p), a, b, args=(table,), xtol=1e-14) for a, b in pieces
        ]
        if found.vanishing_complete:  # an exact double zero stays open
            assert close(points(found), [(p, 2 / p) for p in roots])
        assert all(p.others == "stable" for p in found if p.kind is VANISHING)
        count += found.vanishing_complete and len(roots)
    assert count >= least


def test_a_pair_behind_an_unstable_eigenvalue_and_a_state_without_effect() -> None:
    def rates(x: Any, p: Any) -> Any:
        r = x[0] ** 2 + x[1] ** 2
        du = p[0] * x[0] - x[1] + (p[1] - 0.5) * r * x[0]
        dv = x[0] + p[0] * x[1] + (p[1] - 0.5) * r * x[1]
        return ca.vertcat(du, dv, 3 * x[2] + x[0] ** 2, x[0])

    found = searched(at_rest("uvwz", rates), (-1, 1.5), (-1, 1))
    [point] = [p for p in found if p.kind is VANISHING]
    assert (point.x, point.y, point.others) == (0, 0.5, "unstable") and found.vanishing_complete


# --- the governor, and what is left to the lines ---


def governor() -> st.Family:
    x, p = ca.SX.sym("x", 3), ca.SX.sym("p", 3)
    turn = x[2] ** 2 * ca.sin(x[0]) * ca.cos(x[0]) - ca.sin(x[0]) - p[0] * x[1]
    rates = ca.vertcat(x[1], turn, p[1] * (ca.cos(x[0]) - p[2]))
    system = st.System("governor", x, p, rates, states=tuple("xyz"), parameters=("e", "a", "b"))
    return st.Family(
        system,
        "turning",
        at=("e",),
        held={"y": 0},
        positive=("x", "z"),
        equations=("y", "z"),
        unknown={"x": 0.7, "z": 1.2},
        typical={"e": 0.5, "a": 0.5, "b": 0.75},
    )


@pytest.mark.few(1)
@pytest.mark.parametrize(
    ("a", "b"), [(0.5, 0.7968357154), (0.25, 0.7795976849), (0.8, 0.8506928506)]
)
def test_the_watt_governor_has_its_published_point_and_no_other(a: float, b: float) -> None:
    """Its speed is the square root of 1/b, which a norm eliminates."""
    found = st.codimension_two(governor(), x=("b", 0.6, 0.99, 2), y=("e", 0.1, 2, 2), a=a)
    [point] = [p for p in found if p.kind is VANISHING]
    z, a_ = sympy.Symbol("z"), sympy.Rational(a)
    poly = sympy.Poly(3 + (a_**2 - 5) * z**2 + a_**4 * z**6, z)
    [root] = [r.evalf(40) for r in sympy.real_roots(poly) if 0 < r < 1]
    assert found.vanishing_complete and point.x == pytest.approx(b, abs=6e-11)
    assert abs(point.x - root) <= point.x_error + 1e-16 and point.x_error < 1e-15
    assert abs(point.y - 2 * a_ * root ** sympy.Rational(3, 2)) <= point.y_error + 1e-16


def test_what_is_not_algebraic_or_too_large_is_followed_between_lines_with_the_reason(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def rates(f: Any) -> Any:
        def of(x: Any, p: Any) -> Any:
            r, s, c = x[0] ** 2 + x[1] ** 2, p[1] - 0.25 + p[0], f(p[0])
            return ca.vertcat(c * x[0] - x[1] + s * r * x[0], x[0] + c * x[1] + s * r * x[1])

        return of

    axes: Any = {"x": ("p", -1, 1.1, 2), "y": ("q", -0.9, 1, 2)}
    other = st.codimension_two(at_rest("uv", rates(ca.sinh)), **axes)
    assert "no exact search, since" in other.vanishing and close(points(other), [(0, 0.25)])
    assert not other.vanishing_complete
    monkeypatch.setattr(bautin, "MOST_DEGREE", 0)
    large = st.codimension_two(at_rest("uv", rates(lambda v: v)), **axes)
    assert "has degree" in large.vanishing and "from 8 lines" in large.vanishing
    assert close(points(large), [(0, 0.25)]) and not large.vanishing_complete


def test_linear_rates_have_no_such_point() -> None:
    found = searched(
        at_rest("uv", lambda x, p: ca.vertcat(x[1], -x[0] - p[0] * x[1] - p[1] * x[0])),
        (-1, 1),
        (-0.5, 1),
    )
    assert points(found) == [] and "zero all along" in found.statement


def test_a_boundary_with_a_coefficient_of_zero_on_one_side_is_left_open() -> None:
    """The coefficient is q times the trace's factor: zero all along p = 0."""

    def rates(x: Any, p: Any) -> Any:
        r = x[0] ** 2 + x[1] ** 2
        return ca.vertcat(
            p[0] * x[0] - x[1] + p[0] * r * x[0], x[0] + p[0] * x[1] + p[0] * r * x[1]
        )

    found = searched(at_rest("uv", rates), (-1, 1), (-1, 1))
    assert not found.vanishing_complete and found.complete
    assert found.unresolved[0].kind is VANISHING and "whole curve" in found.statement
