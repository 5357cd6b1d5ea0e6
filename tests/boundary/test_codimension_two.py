"""Points of codimension two against planted ones, a published family, and the disk's conditions.

Oracles: normal forms; the vanishing coefficient of the Watt governor (Sotomayor, Mello & Braga,
arXiv math/0606230); factors multiplied by hand; Sturm's theorem by SymPy.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any

import casadi as ca
import matplotlib
import mpmath
import numpy as np
import pytest
import sympy
from flint import arb

import stability as st
from stability.algebra.exact.routh import expanded_determinant
from stability.algebra.krawczyk import NotProvedError, proved
from stability.algebra.number_types import balls
from stability.boundary.two_parameters.planes import nature, subresultant
from stability.boundary.two_parameters.point_records import PointKind

matplotlib.use("Agg")
DOUBLE_ZERO, ZERO_HOPF, DOUBLE_HOPF, VANISHING, CUSP = PointKind


def at_rest(
    states: str, parameters: Sequence[str], rates: Any, name: str = "rest", **options: Any
) -> st.Family:
    x, p = ca.SX.sym("x", len(states)), ca.SX.sym("p", len(parameters))
    names = {"states": tuple(states), "parameters": tuple(parameters)}
    system = st.System("planted", x, p, rates(x, p), **names)
    options = {"at": tuple(parameters[:1]), "held": dict.fromkeys(states, 0)} | options
    return st.Family(system, name, **options)


def listed(found: st.CodimensionTwo) -> list[tuple[Any, ...]]:
    return [(p.kind, round(p.x, 12), round(p.y, 12)) for p in found]


def takens(f: Any, g: Any) -> st.Family:
    """X' = y, y' = b1 + b2 x + x² + x y at its steady motion x0, moved to the origin."""

    def rates(x: Any, p: Any) -> Any:
        a, b = f(p[0]), g(p[1])
        return ca.vertcat(x[1], (b + 2 * a) * x[0] + x[0] ** 2 + (x[0] + a) * x[1])

    return at_rest("xy", ["x0", "b2"], rates)


def two_pairs(f: Any, g: Any) -> st.Family:
    def rates(x: Any, p: Any) -> Any:
        return ca.vertcat(
            x[1],
            -x[0] + f(p[0]) * x[1] - x[0] ** 2 * x[1] + x[2] / 4,
            x[3],
            -3 * x[2] + g(p[1]) * x[3] - x[2] ** 2 * x[3],
        )

    return at_rest("abcd", ["p", "q"], rates)


def zero_and_pair(f: Any, g: Any) -> st.Family:
    def rates(x: Any, p: Any) -> Any:
        cubic = x[0] ** 2 * x[1]
        return ca.vertcat(x[1], -4 * x[0] + f(p[0]) * x[1] - cubic, g(p[1]) * x[2] - x[2] ** 3)

    return at_rest("abc", ["p", "q"], rates)


PLANTED = [
    (takens, DOUBLE_ZERO, (), "x0", "b2"),
    (zero_and_pair, ZERO_HOPF, (2,), "p", "q"),
    (two_pairs, DOUBLE_HOPF, (1, 3**0.5), "p", "q"),
]


@pytest.mark.few(1)
@pytest.mark.parametrize(("make", "kind", "frequencies", "x", "y"), PLANTED)
def test_a_planted_point_is_found_over_q(
    make: Any, kind: PointKind, frequencies: Any, x: str, y: str
) -> None:
    family = make(lambda v: v - 0.25, lambda v: v + 0.5)
    found = st.codimension_two(family, x=(x, -1, 1, 3), y=(y, -1, 1, 3))
    true = (kind, 0.25, -0.5)
    assert listed(found) == [true] and found.complete and "over Q" in found.how
    assert found[0].frequencies == pytest.approx(frequencies, rel=1e-15)
    assert found[0].others == "stable" and found[0].x_error < 1e-50
    # the closed rectangle: a point in its corner belongs to it, and one next to it does not
    corner = st.codimension_two(family, x=(x, 0.25, 1, 3), y=(y, -1, -0.5, 3))
    assert listed(corner) == [true] and corner.complete
    near = st.codimension_two(family, x=(x, np.nextafter(0.25, 1), 1, 3), y=(y, -1, 1, 3))
    assert listed(near) == [] and near.complete


@pytest.mark.few(1)
@pytest.mark.parametrize(("make", "kind", "frequencies", "x", "y"), PLANTED)
def test_a_planted_point_is_found_in_boxes(
    make: Any, kind: PointKind, frequencies: Any, x: str, y: str
) -> None:
    family = make(lambda v: ca.sinh(v - 0.25), lambda v: ca.exp(v + 0.5) - 1)
    found = st.codimension_two(family, x=(x, -1, 1, 2), y=(y, -1, 1.1, 2))
    assert listed(found) == [(kind, 0.25, -0.5)] and found.complete and "boxes" in found.how
    assert found[0].frequencies == pytest.approx(frequencies, rel=1e-15)


def test_two_points_near_each_other_are_both_found_in_boxes() -> None:
    """A box holds one point only where this is proved: exp v = 1 + 1.02 v at 0 and near 0.04."""
    family = takens(lambda v: ca.exp(v) - 1 - 1.02 * v, lambda v: ca.sinh(v + 0.5))
    found = st.codimension_two(family, x=("x0", -1, 1, 2), y=("b2", -1, 1.1, 2))
    second = float(mpmath.findroot(lambda v: mpmath.exp(v) - 1 - mpmath.mpf(1.02) * v, 0.04))
    assert [p.x for p in found] == pytest.approx([0, second], abs=1e-15) and found.complete
    assert [p.kind for p in found] == [DOUBLE_ZERO] * 2


def test_the_variable_of_an_axis_may_be_its_sine_or_cosine() -> None:
    family = takens(lambda v: ca.sin(v) ** 3 * ca.cos(v) ** 2 - 0.125, lambda v: ca.cos(v) - 0.75)
    found = st.codimension_two(family, x=("x0", 0, 1.5, 2), y=("b2", 0, 2, 2))
    t = sympy.Symbol("t")
    roots = sympy.real_roots(sympy.Poly(t**3 * (1 - t**2) - sympy.Rational(1, 8), t))
    true = [float(sympy.asin(r)) for r in roots if 0 < r < 1]
    assert len(true) == 2 and found.complete and "over Q" in found.how
    assert [p.x for p in found] == pytest.approx(sorted(true), rel=1e-15)
    assert [p.y for p in found] == pytest.approx([np.arccos(0.75)] * 2, rel=1e-15)


def test_points_behind_an_unstable_eigenvalue_are_listed_as_such() -> None:
    def rates(x: Any, p: Any) -> Any:
        return ca.vertcat(x[1], -p[0] * x[0] - p[1] * x[1] - x[0] ** 3, x[2])

    family = at_rest("xyz", ["k", "c"], rates)
    [point] = st.codimension_two(family, x=("k", -1, 1, 2), y=("c", -1, 1, 2))
    assert (point.kind, point.x, point.y, point.others) == (DOUBLE_ZERO, 0, 0, "unstable")


def test_opposite_real_eigenvalues_are_no_pair() -> None:
    """λ and -λ real also cancel in the determinant; such points are none of these."""

    def rates(x: Any, p: Any) -> Any:
        return ca.vertcat(x[0], (p[0] - 1) * x[1], p[1] * x[2])

    family = at_rest("xyz", ["p", "q"], rates)
    found = st.codimension_two(family, x=("p", -0.5, 0.5, 2), y=("q", -1, 1, 2))
    assert listed(found) == [] and found.complete


def test_a_curve_of_degenerate_points_is_not_called_complete() -> None:
    def rates(x: Any, p: Any) -> Any:
        return ca.vertcat(p[0] * x[0], p[0] * x[1] - x[1] * p[1] ** 2 * p[0])

    family = at_rest("xy", ["p", "q"], rates)
    with pytest.warns(st.StabilityWarning, match="along a whole curve"):
        found = st.codimension_two(family, x=("p", -1, 1, 2), y=("q", -0.5, 0.5, 2))
    assert not found.complete and found.unresolved[0].kind is DOUBLE_ZERO


def test_a_point_that_is_not_simple_stays_unresolved() -> None:
    def rates(x: Any, p: Any) -> Any:  # k = p² + q² and c = p: they meet at 0, where k is flat
        return ca.vertcat(x[1], -(p[0] ** 2 + p[1] ** 2) * x[0] - p[0] * x[1])

    with pytest.warns(st.StabilityWarning, match="not simple"):
        found = st.codimension_two(
            at_rest("xy", ["p", "q"], rates), x=("p", -1, 1, 2), y=("q", -1, 1, 2)
        )
    [box] = found.unresolved
    assert box.x[0] <= 0 <= box.x[1] and box.y[0] <= 0 <= box.y[1]
    assert listed(found) == []


def solutions(f: Any, g: Any, x: Any, y: Any) -> list[tuple[Any, Any]]:
    """Real solutions of f = 0 = g, where f has degree one in y."""
    [of_x] = sympy.solve(f, y)
    return [(u, of_x.subs(x, u)) for u in sympy.real_roots(sympy.Poly(g.subs(y, of_x), x))]


@pytest.mark.parametrize(
    "seed", [5, *(pytest.param(k, marks=pytest.mark.long) for k in range(6, 16))]
)
def test_random_quartics_have_the_points_of_sympy(seed: int) -> None:
    """λ⁴ + c3 λ³ + c2 λ² + c1 λ + c0, each linear in x and y: solutions by hand and SymPy."""
    rng = np.random.default_rng(seed)
    x, y = sympy.symbols("x y")
    counts = 0
    for _ in range(2):
        signs = rng.choice([-1, 1], (4, 3))
        table = [[int(v) for v in row] for row in signs * rng.integers(1, 6, (4, 3))]
        c = [r[0] + r[1] * x + r[2] * y for r in table]

        def rates(z: Any, p: Any, rows: Any = table) -> Any:
            a = [r[0] + r[1] * p[0] + r[2] * p[1] for r in rows]
            return ca.vertcat(z[1], z[2], z[3], -sum(a[i] * z[i] for i in range(4)) - z[0] ** 3)

        family = at_rest("abcd", ["x", "y"], rates)
        found = st.codimension_two(family, x=("x", -4, 4, 2), y=("y", -4, 4, 2))
        true = []
        for kind, pair in (
            (DOUBLE_ZERO, (c[0], c[1])),
            (ZERO_HOPF, (c[0], c[1] - c[2] * c[3])),
            (DOUBLE_HOPF, (c[1], c[3])),
        ):
            for u, v in solutions(*pair, x, y):
                u, v = float(u), float(v)
                b0, b2, b3 = (r[0] + r[1] * u + r[2] * v for r in (table[0], table[2], table[3]))
                b1 = table[1][0] + table[1][1] * u + table[1][2] * v
                fine = max(abs(u), abs(v)) <= 4
                if kind is ZERO_HOPF:  # λ³ + c3 λ² + c2 λ + c1 with c1 = c2 c3
                    fine = fine and b2 > 0 and abs(b1 - b2 * b3) < 1e-9
                if kind is DOUBLE_HOPF:
                    fine = fine and b2 > 0 and b0 > 0 and b2**2 > 4 * b0
                if fine:
                    true.append((kind.name, round(u, 9), round(v, 9)))
        assert found.complete
        seen = [
            (k.name, round(u, 9), round(v, 9)) for k, u, v in listed(found) if k is not VANISHING
        ]
        assert sorted(seen) == sorted(true)
        counts += len(true)
    assert counts >= 1


# --- vanishing first coefficients ---


@pytest.mark.parametrize(
    ("a", "b"),
    [
        (0.5, 0.7968357154),
        pytest.param(0.25, 0.7795976849, marks=pytest.mark.long),
        pytest.param(0.8, 0.8506928506, marks=pytest.mark.long),
    ],
)
def test_the_watt_governor_turns_from_soft_to_hard_where_published(a: float, b: float) -> None:
    def rates(x: Any, p: Any) -> Any:
        turn = x[2] ** 2 * ca.sin(x[0]) * ca.cos(x[0]) - ca.sin(x[0]) - p[0] * x[1]
        return ca.vertcat(x[1], turn, p[1] * (ca.cos(x[0]) - p[2]))

    family = at_rest(
        "xyz",
        ["e", "a", "b"],
        rates,
        held={"y": 0},
        positive=("x", "z"),
        equations=("y", "z"),
        unknown={"x": 0.7, "z": 1.2},
        typical={"e": 0.5, "a": 0.5, "b": 0.75},
    )
    found = st.codimension_two(family, x=("b", 0.75, 0.9, 2), y=("e", 0.2, 1.6, 2), a=a)
    [point] = found
    assert point.kind is VANISHING and point.others == "stable"
    assert point.x == pytest.approx(b, abs=6e-11)
    root = sympy.nsolve(  # 3 + (a² - 5) b² + a⁴ b⁶, in 30 digits
        3
        + (sympy.Rational(a) ** 2 - 5) * sympy.Symbol("b") ** 2
        + sympy.Rational(a) ** 4 * sympy.Symbol("b") ** 6,
        b,
        prec=30,
    )
    assert abs(point.x - float(root)) <= point.x_error + 2e-16 and point.x_error < 1e-12
    assert point.y == pytest.approx(2 * a * float(root) ** 1.5, rel=1e-14)


def test_a_planted_change_from_soft_to_hard_is_found() -> None:
    def rates(x: Any, p: Any) -> Any:
        r = x[0] ** 2 + x[1] ** 2
        s = p[1] - 0.3 + p[0]
        return ca.vertcat(
            (p[0] - p[1] ** 2) * x[0] - 2 * x[1] + s * r * x[0],
            2 * x[0] + (p[0] - p[1] ** 2) * x[1] + s * r * x[1],
        )

    found = st.codimension_two(
        at_rest("xy", ["p", "q"], rates), x=("p", -1, 1.1, 2), y=("q", -0.9, 1, 2)
    )
    # on p = q² the coefficient vanishes where q + q² is the double 0.3
    q = (-1 + sympy.sqrt(1 + 4 * sympy.Rational(0.3))) / 2
    [point] = found
    assert point.kind is VANISHING and point.frequencies == pytest.approx((2,))
    assert abs(point.y - float(q)) <= point.y_error + 1e-16 and point.y_error < 1e-14
    assert abs(point.x - float(q**2)) <= point.x_error + 1e-16


# --- the disk ---


def test_the_spinning_disk_has_a_zero_with_a_pair_where_its_boundaries_meet() -> None:
    """Static k at² = 1 meets flutter at M2 = 24 k/((2k+1)(4k+3)): at = 2, mu = 1 for k = 1/4."""
    found = st.codimension_two("spinning", x=("at", 0.5, 5, 2), y=("mu", 0.1, 3, 2))
    assert listed(found) == [(ZERO_HOPF, 2.0, 1.0)] and found.complete
    near = st.boundaries("spinning", axis=("at", 0.5, 5, 9), contact=st.Viscous(1 - 2.0**-12))
    static, flutter = near
    assert static.value == 2 < flutter.value < 2.001
    assert found[0].frequencies == pytest.approx((flutter.frequency,), rel=2e-3)
    for k in (0.3, 0.5):
        disk = st.Disk(k=k)
        [point] = st.codimension_two(
            "spinning", disk=disk, x=("at", 0.5, 5, 2), y=("mu", 0.1, 3, 2)
        )
        mu = (24 * k / ((2 * k + 1) * (4 * k + 3))) ** 0.5
        assert (point.x, point.y) == pytest.approx((k**-0.5, mu), rel=1e-14)


def test_tumbling_has_no_such_point() -> None:
    """Its constant coefficient has one sign; two pairs need the Hurwitz forms of order 2 too."""
    found = st.codimension_two(
        "tumbling", disk=st.Disk(k=0.375), x=("at", 0.01, 1.57, 2), y=("mu", 0.01, 5, 2)
    )
    assert listed(found) == [] and found.complete and "over Q" in found.how


# --- what a user sees ---


def test_points_are_marked_listed_and_written(
    tmp_path: Any, capsys: pytest.CaptureFixture[str]
) -> None:
    from stability.cli.commands import main

    axes = {"x": ("p", -1, 1.1, 4), "y": ("q", -1, 1.2, 4)}
    family = zero_and_pair(lambda v: v, lambda v: v)
    dataset = st.stability_map(family, **axes)
    found = st.codimension_two(family, **axes)
    figure = st.plot_map(dataset, points=found)
    labels = [t.get_text() for t in figure.axes[0].get_legend().get_texts()]
    assert "zero and pair" in labels
    [line] = [a for a in figure.axes[0].lines if a.get_label() == "zero and pair"]
    assert (line.get_xdata()[0], line.get_ydata()[0]) == (0, 0)
    other = st.codimension_two(
        takens(lambda v: v, lambda v: v), x=("x0", -1, 1, 2), y=("b2", -1, 1, 2)
    )
    with pytest.raises(st.StabilityError, match="points of the same two axes"):
        st.plot_map(dataset, points=other)

    file = tmp_path / "planted.py"
    file.write_text(
        "import casadi as ca, stability as st\n"
        "x, p = ca.SX.sym('x', 2), ca.SX.sym('p', 2)\n"
        "rates = ca.vertcat(x[1], -p[0] * x[0] - p[1] * x[1] - x[0] ** 3)\n"
        "s = st.System('s', x, p, rates, states=('u', 'v'), parameters=('k', 'c'))\n"
        "rest = st.Family(s, 'rest', at=('k',), held={'u': 0, 'v': 0})\n"
    )
    asked = [
        "table",
        "codimension",
        "--system",
        f"{file}:rest",
        "--x",
        "k:-1:1:2",
        "--y",
        "c:-1:1:2",
    ]
    assert main([*asked, "--json"]) == 0
    record = json.loads(capsys.readouterr().out)
    assert record["complete"] and record["rows"][0]["kind"] == "double zero"
    assert main(asked) == 0
    assert "double zero: k = 0 ± 0.0e+00, c = 0" in capsys.readouterr().out
    disk = ["table", "codimension", "--family", "spinning", "--x", "at:1:3:2", "--y", "mu:0.5:2:2"]
    assert main(disk) == 0
    assert "zero hopf: at = 2 ±" in capsys.readouterr().out
    assert main([*disk, "--mu", "1"]) == 2
    assert main(asked[:-2]) == 2


def test_conservative_families_are_refused() -> None:
    swing = at_rest(
        "qv", ["k", "m"], lambda x, p: ca.vertcat(x[1], -p[0] * x[0] * p[1]), conservative=True
    )
    with pytest.raises(st.StabilityError, match="conservative"):
        st.codimension_two(swing, x=("k", 1, 2, 2), y=("m", 1, 2, 2))


# --- the arithmetic ---


def test_determinants_and_subresultants_are_those_of_sympy() -> None:
    rng = np.random.default_rng(2)
    for size in (1, 2, 3, 5):
        table = rng.integers(-9, 10, (size, size))
        rows = [[sympy.Integer(int(v)) for v in row] for row in table]
        assert expanded_determinant(rows) == sympy.Matrix(rows).det()
    x = sympy.Symbol("x")
    common = sympy.Poly((x + 2) * (x + 5), x)
    f = sympy.Poly(x + 3, x) * common
    g = sympy.Poly(2 * x - 7, x) * common
    coefficients = [list(reversed(p.all_coeffs())) for p in (f, g)]
    assert subresultant(*coefficients, 0) == [0] and subresultant(*coefficients, 1) == [0, 0]
    low, middle, high = subresultant(*coefficients, 2)
    assert high != 0 and (low / high, middle / high) == (10, 7)
    f, g = sympy.Poly(x**3 - x + 1, x), sympy.Poly(x**2 + 4 * x - 3, x)
    coefficients = [list(reversed(p.all_coeffs())) for p in (f, g)]
    assert abs(subresultant(*coefficients, 0)[0]) == abs(sympy.resultant(f, g))


def test_meetings_of_more_eigenvalues_are_left_open() -> None:
    with pytest.raises(NotProvedError):  # three zeros
        nature(DOUBLE_ZERO, [arb(0), arb(0), arb(0), arb(1)])
    with pytest.raises(NotProvedError):  # (λ² + 1)²
        nature(DOUBLE_HOPF, [arb(1), arb(0), arb(2), arb(0), arb(1)])
    found = nature(DOUBLE_HOPF, [arb(4), arb(0), arb(5), arb(0), arb(1)])
    assert found is not None and [float(w) for w in found.frequencies] == [1, 2]


def test_a_double_solution_is_not_proved() -> None:
    with pytest.raises(NotProvedError):
        proved(lambda z: ([z[0] * z[0]], [[2 * z[0]]]), [arb(0)])


def test_whole_powers_of_balls_around_zero_are_finite() -> None:
    power = balls().functions["pow"]
    cube = power(arb(0, 0.5), arb(3))
    assert cube.is_finite() and cube.contains(0.1) and cube.contains(-0.1)
    assert power(arb(2), arb(0.5)) * power(arb(2), arb(0.5)) - 2 < 1e-12


def test_a_family_that_is_steady_without_its_torque_alone_has_conditions_and_double_zeros() -> None:
    """λ² + c λ + k: a hanging arm is at rest where the torque T is 0, and only there."""
    x, p = ca.SX.sym("x", 2), ca.SX.sym("p", 3)
    rates = ca.vertcat(x[1], p[2] - p[0] * ca.sin(x[0]) - p[1] * x[1])
    arm = st.System("arm", x, p, rates, states=("angle", "rate"), parameters=("k", "c", "T"))
    hang = st.Family(arm, "hang", at=("k",), held={"angle": 0, "rate": 0})
    assert st.conditions(hang, T=0).rule.startswith("Stable where k > 0 and c > 0;")
    assert "k > 0" in st.latex(hang, T=0)
    found = st.codimension_two(hang, x=("k", -1, 1, 5), y=("c", -1, 1, 5), T=0)
    assert [(q.kind.word, q.x, q.y) for q in found] == [("double zero", 0.0, 0.0)]
    for given in ({}, {"T": 1}):
        with pytest.raises(st.StabilityError, match="a rate does not vanish"):
            st.conditions(hang, **given)
