"""Boundary points of maps, bracketed all together: against eigenvalues to 60 digits, and balls.

Oracle: `mpmath.eig` of the linearisation written out by hand, and the search in balls edge by edge.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import casadi as ca
import mpmath
import numpy as np
import pytest
from own_systems import system_of
from scipy.optimize import brentq

import stability as st
from stability.algebra.double_double import DoubleDouble
from stability.base.axis import Axis
from stability.boundary import curves, grid_edges
from stability.boundary.brackets import AxisScan, refine
from stability.boundary.grid_edges import Edges, GridPolynomials, Reading, bracketed
from stability.spectra.axes import swept

STATES = ("a", "b", "c", "d")


def rest(matrix: Callable[[Any, Any, Any], list[list[Any]]], size: int = 4) -> st.Family:
    x, p = ca.SX.sym("x", size), ca.SX.sym("p", 2)
    rates = ca.mtimes(ca.blockcat(matrix(p[0], p[1], ca)), x)
    names = STATES[:size]
    system = st.System("rest", x, p, rates, states=names, parameters=("p", "q"))
    return st.Family(system, "rest", at=("p",), held=dict.fromkeys(names, 0.0))


def coupled(p: Any, q: Any, f: Any) -> list[list[Any]]:
    """Functions that no polynomial holds; static and flutter boundaries."""
    return [
        [0, 1, 0, 0],
        [-f.sin(p) - q * q / 3, -(q + f.exp(p) / 3), p / 5, 0],
        [0, 0, 0, 1],
        [-0.75, 0, -f.cosh(q) + p * p / 4, -f.log(2 + p) / 5],
    ]


def gyroscopic(p: Any, q: Any, f: Any) -> list[list[Any]]:
    """Even in λ: pairs meet on the axis, or λ² passes through zero."""
    k = f.sqrt(1 + p * p) - 1.5
    return [[0, 1, 0, 0], [-k, 0, 0, q], [0, 0, 0, 1], [0, -q, 2 - p, 0]]


def turning(p: Any, q: Any, f: Any) -> list[list[Any]]:
    """An even number of unstable eigenvalues on one side, far from the boundary."""
    rate = (p - 0.3) * (p - 0.31) * f.cos(q) + 0.002 * q
    return [[rate, -2, 0], [2, rate, 0], [p, q, -1]]


def abscissa(matrix: Any, p: float, q: float) -> list[Any]:
    with mpmath.workdps(60):
        rows = matrix(mpmath.mpf(p), mpmath.mpf(q), mpmath)
        return sorted(
            mpmath.eig(mpmath.matrix(rows), left=False, right=False), key=lambda v: -mpmath.re(v)
        )


@pytest.mark.parametrize(
    ("matrix", "size", "axes", "even"),
    [
        (coupled, 4, {"x": ("p", -1, 2, 31), "y": ("q", -2, 1, 29)}, False),
        (gyroscopic, 4, {"x": ("p", -2, 3, 33), "y": ("q", -3, 3, 26)}, True),
        (turning, 3, {"x": ("p", 0.01, 1, 21, "log"), "y": ("q", -1, 1.3, 24)}, False),
    ],
    ids=["coupled", "gyroscopic", "turning"],
)
def test_verdicts_differ_at_both_ends_to_60_digits(
    matrix: Any, size: int, axes: dict[str, Any], even: bool
) -> None:
    drawn = st.stability_map(rest(matrix, size), **axes)
    assert drawn.attrs["boundary_unresolved"] == 0
    codes = {crossing.code: crossing for crossing in st.Crossing}
    count = drawn.sizes["boundary_point"]
    assert count > 25
    tiny = mpmath.mpf(10) ** -22  # of a double eigenvalue, 60 digits hold half
    for k in range(0, count, 6):
        point = [float(drawn[f"boundary_{n}"][k]) for n in ("p", "q")]
        axis, error = int(drawn.boundary_axis[k]), float(drawn.boundary_error[k])
        assert error <= 2 * np.spacing(abs(point[axis]))
        good = []
        for way in (-error, error):
            ends = list(point)
            ends[axis] += way
            lead = mpmath.re(abscissa(matrix, *ends)[0])
            good.append(lead < (tiny if even else 0))
        assert good[0] != good[1], point
        crossing = codes[int(drawn.boundary_kind[k])]
        frequency = float(drawn.boundary_frequency[k])
        near = min(abs(v - 1j * frequency) for v in abscissa(matrix, *point))
        assert near < (1e-6 if even else 1e-12)  # two that meet are apart by the root of rounding
        assert (frequency == 0) == (crossing is st.Crossing.STATIC)


CASES: list[tuple[str, Any, dict[str, Any]]] = [
    ("rolling", {"x": ("at", 0.2, 3.0, 23), "y": ("mu", 0.05, 3.0, 19)}, {}),
    ("spinning", {"x": ("at", 0.5, 5.0, 23), "y": ("mu", 0.05, 3.0, 19)}, {}),
    ("tumbling", {"x": ("lean", 0.05, 1.5, 23), "y": ("mu", 0.05, 3.0, 19)}, {}),
    (
        "tumbling",
        {"x": ("at", 0.05, 1.55, 23), "y": ("mu", 0.05, 3.0, 19)},
        {"disk": st.Disk(k=0.3, mass=1.3, radius=0.2, gravity=9.81)},
    ),
    (
        "rolling",
        {"x": ("at", 0.2, 3.0, 23), "y": ("k", 0.1, 0.5, 19)},
        {"contact": "rough"},
    ),
    (
        "tumbling",
        {"x": ("at", 0.3, 1.5, 17), "y": ("mu", 0.05, 3.0, 13)},
        {"body": st.Torus(0.2)},
    ),
    (
        "rolling",
        {"x": ("at", 0.2, 3.0, 9), "y": ("axial", 0.35, 0.45, 5)},
        {"body": st.Egg(0.2), "contact": st.Viscous(0.4)},
    ),
    (
        "circling",
        {"x": ("theta", 0.3, 1.3, 23), "y": ("phi_dot", 0.5, 3.0, 19)},
        {"contact": "rough"},
    ),
]


def edges_of(problem: Any, axes: tuple[Axis, Axis]) -> Edges:
    """Edges on which `quick_sign` differs, found in balls at every point of a small grid."""
    names = axes[0].name, axes[1].name
    xs, ys = (a.values for a in axes)
    fixed = {n: float(v) for n, v in problem.values.items()}
    signs = np.array(
        [
            [
                AxisScan(problem, names[0], fixed | {names[1]: float(y)}).quick_sign(float(x))
                for x in xs
            ]
            for y in ys
        ]
    )
    rows = []
    for i, j in np.argwhere(signs[:, 1:] * signs[:, :-1] < 0):
        rows.append((0, xs[j], xs[j + 1], ys[i]))
    for i, j in np.argwhere(signs[1:] * signs[:-1] < 0):
        rows.append((1, ys[i], ys[i + 1], xs[j]))
    axis, *others = np.array(rows).T
    return Edges(axis.astype(np.int8), *others)


@pytest.mark.parametrize("case", range(len(CASES)))
def test_edges_together_are_edges_one_by_one_in_balls(case: int) -> None:
    family, asked, more = CASES[case]
    problem, axes = swept(family, asked, *(more.get(n) for n in ("disk", "body", "contact")))
    edges = edges_of(problem, axes)  # type: ignore[arg-type]
    names = axes[0].name, axes[1].name
    found = bracketed(GridPolynomials(problem, names), edges)
    fixed = {n: float(v) for n, v in problem.values.items()}
    assert len(found) > 4
    for k in range(0, len(found), 3):
        axis = int(edges.axis[k])
        line = AxisScan(problem, names[axis], fixed | {names[1 - axis]: float(edges.other[k])})
        wanted = refine(line, float(edges.low[k]), float(edges.high[k]))
        point = found[k]
        assert wanted is not None and point is not None
        assert abs(point.value - wanted.value) <= point.error + wanted.error
        assert point.error <= 4 * np.spacing(point.value)
        assert (point.crossing, point.stable_below) == (wanted.crossing, wanted.stable_below)
        assert point.frequency == pytest.approx(wanted.frequency, rel=1e-11)
        signs = line.sign(point.value - point.error), line.sign(point.value + point.error)
        assert signs[0] * signs[1] < 0


def test_members_that_are_solved_for_have_proved_boundaries() -> None:
    """Lorenz' C+, whose unknowns are found by Krawczyk's test: r = s (s + b + 3)/(s - b - 1)."""
    x, p = ca.SX.sym("x", 3), ca.SX.sym("p", 3)
    s, r, b = p[0], p[1], p[2]
    rates = ca.vertcat(s * (x[1] - x[0]), x[0] * (r - x[2]) - x[1], x[0] * x[1] - b * x[2])
    system = st.System("lorenz", x, p, rates, states=("x", "y", "z"), parameters=("s", "r", "b"))
    guess = {"x": 8, "y": 8, "z": 27, "r": 28, "s": 10, "b": 8 / 3}
    plus = system.steady("r", guess=guess, name="C+")
    problem, axes = swept(
        plus, {"x": ("r", 15.0, 40.0, 30), "y": ("b", 1.5, 4.0, 20)}, parameters={"s": 10.0}
    )
    b_values = axes[1].values
    low, high = 14.0 + 0 * b_values, 60.0 + 0 * b_values
    edges = Edges(np.zeros(20, dtype=np.int8), low, high, b_values)
    found = bracketed(GridPolynomials(problem, ("r", "b")), edges)
    for b_, point in zip(b_values.tolist(), found, strict=True):
        assert point is not None and point.crossing is st.Crossing.FLUTTER
        with mpmath.workdps(40):
            true = 10 * (mpmath.mpf(13) + b_) / (9 - mpmath.mpf(b_))
            assert abs(point.value - true) <= point.error <= 2 * np.spacing(point.value)
            rate = mpmath.sqrt(2 * mpmath.mpf(b_) * 10 * 11 / (9 - mpmath.mpf(b_)))
        assert point.frequency == pytest.approx(float(rate), rel=1e-13)


def test_a_map_needs_no_search_edge_by_edge(monkeypatch: pytest.MonkeyPatch) -> None:
    def refused(*_: Any) -> None:
        raise AssertionError("an edge was left to balls")

    monkeypatch.setattr(curves, "refine", refused)
    for family, asked, more in CASES:
        assert st.stability_map(family, **asked, **more).sizes["boundary_point"] > 4


def test_an_edge_that_stays_open_is_left_to_balls() -> None:
    """A real part of third order, expanded: its sign near the root is below all rounding."""

    def cubed(p: Any, q: Any, _: Any) -> list[list[Any]]:
        rate = -(p * p * p) + 3 * p * p * q - 3 * p * q * q + q * q * q
        return [[rate, -1], [1, rate]]

    family = rest(cubed, 2)
    problem, _ = swept(family, {"x": ("p", -1.0, 1.0, 9), "y": ("q", -1.0, 1.0, 9)})
    ends = (np.array([v]) for v in (0.25, 0.5, 0.37))
    edges = Edges(np.zeros(1, dtype=np.int8), *ends)
    assert bracketed(GridPolynomials(problem, ("p", "q")), edges) == [None]
    drawn = st.stability_map(family, x=("p", -1, 1, 8), y=("q", -0.9, 1.1, 7))
    assert drawn.attrs["boundary_unresolved"] == 0
    assert np.abs(drawn.boundary_p - drawn.boundary_q).max() < 1e-12


def test_no_verdict_is_proved_where_a_number_of_members_is_not_positive(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    family = rest(lambda p, q, _: [[-1, p], [q, -2]], 2)
    problem, _ = swept(family, {"x": ("p", -1.0, 1.0, 9), "y": ("q", -1.0, 1.0, 9)})

    def formulas(_: Any, a: list[Any], __: Any) -> Any:
        return [2 - a[0] * 0, 3, 1], [], [a[0]]

    monkeypatch.setattr(grid_edges, "formulas_of", lambda _: formulas)
    p = np.array([-0.5, 0.0, 0.5])
    assert GridPolynomials(problem, ("p", "q")).signs(p, 0 * p).tolist() == [0, 0, 1]


def test_members_of_two_branches_are_not_joined() -> None:
    """Ends and middle of two brackets, each middle with its box of one root."""
    places, width = np.array([1.0, 1.0, 1.1, 5.0, 1.05, 1.05]), np.full(6, 0.3)
    reading = Reading([], [], None, [], [DoubleDouble(places, np.zeros(6), width)])
    assert reading.joined(2).tolist() == [True, False]


def test_no_point_is_named_without_two_proved_verdicts(monkeypatch: pytest.MonkeyPatch) -> None:
    problem, _ = swept("rolling", {"x": ("at", 0.2, 3.0, 9), "y": ("mu", 0.1, 1.0, 9)})
    edges = Edges(np.zeros(1, dtype=np.int8), *(np.array([v]) for v in (1.0, 2.0, 0.3)))
    polynomials = GridPolynomials(problem, ("at", "mu"))
    [point] = bracketed(polynomials, edges)
    assert point is not None and point.value == pytest.approx(2**0.5, rel=1e-15)
    read = GridPolynomials.__call__
    monkeypatch.setattr(
        GridPolynomials, "__call__", lambda *given: replace(read(*given), sign=np.zeros(3))
    )
    assert bracketed(polynomials, edges) == [None]


def test_edges_over_a_branch_point_of_a_symmetric_pair_are_not_searched() -> None:
    # on x = y = s the slope across is 1 - p s (1 - s/a); s by bisection of its one equation
    x, y, p, a = (ca.SX.sym(n) for n in "xypa")
    rates = [a / (1 + ca.exp(p * (other - 1))) - own for own, other in ((x, y), (y, x))]
    system = system_of("pair", [x, y], [p, a], ca.vertcat(*rates))
    family = system.steady("p", guess={"x": 1, "y": 1, "p": 0.5}, a=2.2)
    problem, (across, up) = swept(family, {"x": ("p", 0.2, 6, 9), "y": ("a", 1, 4, 4)})

    def slope(at: float, scale: float) -> float:
        s = float(brentq(lambda v: scale / (1 + np.exp(at * (v - 1))) - v, 0, scale))
        return 1 - at * s * (1 - s / scale)

    low, other = (v.ravel() for v in np.meshgrid(across.values[:-1], up.values))
    high = low + (across.values[1] - across.values[0])
    edges = Edges(np.zeros(len(low), dtype=np.int8), low, high, other)
    separated = GridPolynomials(problem, ("p", "a")).separated(edges)
    ends = [[slope(v, s) for v, s in zip(e, other, strict=True)] for e in (low, high)]
    assert separated.any() and not separated.all()
    assert np.array_equal(separated, np.prod(ends, axis=0) < 0)
