"""Soft or hard, elliptic or hyperbolic, for any family, against normal forms in closed form.

Oracles: averaging; Guckenheimer & Holmes (3.4.11) for planar systems by SymPy; planted normal forms
in other coordinates; the Watt governor of Sotomayor, Mello & Braga, arXiv math/0606230.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from typing import Any

import casadi as ca
import mpmath
import numpy as np
import pytest
import sympy

import stability as st
from stability.boundary.hopf import HopfKind, Onset
from stability.tables.beyond_linear import birth_table


def at_rest(
    states: str, parameters: Sequence[str], rates: Callable[[Any, Any], Any], **options: Any
) -> st.Family:
    x, p = ca.SX.sym("x", len(states)), ca.SX.sym("p", len(parameters))
    system = st.System(
        "planted", x, p, rates(x, p), states=tuple(states), parameters=tuple(parameters)
    )
    options = {"at": parameters[:1], "held": dict.fromkeys(states, 0)} | options
    return st.Family(system, "rest", **options)


def within(point: st.CycleBirth, coefficient: Any, crossing: Any, frequency: Any) -> bool:
    """Whether the true numbers lie inside the proved bounds, and these are small."""
    found = (point.coefficient, point.crossing, point.frequency)
    bounds = (point.coefficient_error, point.crossing_error, point.frequency_error)
    true = (coefficient, crossing, frequency)
    with mpmath.workdps(40):
        inside = [abs(mpmath.mpf(f) - t) <= e for f, t, e in zip(found, true, bounds, strict=True)]
        return all(inside) and all(
            e <= 1e-15 * (1 + abs(f)) for f, e in zip(found, bounds, strict=True)
        )


def planar(f: Any, g: Any, x: Any, y: Any, place: dict[Any, Any]) -> tuple[Any, Any]:
    """(l1 for the mode of unit length, ω) by the formula of Guckenheimer & Holmes (3.4.11)."""
    matrix = sympy.Matrix([f, g]).jacobian([x, y]).subs(place).applyfunc(sympy.nsimplify)
    omega = sympy.sqrt(matrix.det())
    q = sympy.Matrix([matrix[0, 1], sympy.I * omega - matrix[0, 0]])
    q = q / sympy.sqrt(abs(q[0]) ** 2 + abs(q[1]) ** 2)
    turn = sympy.Matrix.hstack(q.applyfunc(sympy.re), -q.applyfunc(sympy.im))
    u, v = sympy.symbols("u v", real=True)
    moved = turn * sympy.Matrix([u, v])
    shift = {x: place[x] + moved[0], y: place[y] + moved[1]}
    rest = {k: w for k, w in place.items() if k not in (x, y)}
    a, b = turn.inv() * sympy.Matrix([f, g]).subs(rest).subs(shift, simultaneous=True)

    def d(h: Any, *by: Any) -> Any:
        return sympy.diff(h, *by).subs({u: 0, v: 0})

    cubic = d(a, u, u, u) + d(a, u, v, v) + d(b, u, u, v) + d(b, v, v, v)
    squares = (
        d(a, u, v) * (d(a, u, u) + d(a, v, v))
        - d(b, u, v) * (d(b, u, u) + d(b, v, v))
        - d(a, u, u) * d(b, u, u)
        + d(a, v, v) * d(b, v, v)
    )
    growth = (cubic + squares / omega) / 16  # r' = growth r³, and r is twice |z|
    return sympy.N(4 * growth / omega, 40), sympy.N(omega, 40)


@pytest.mark.parametrize(("s", "kind"), [(-1.5, Onset.SOFT), (0.25, Onset.HARD)])
def test_a_normal_form_has_its_own_coefficient(s: float, kind: Onset) -> None:
    def rates(x: Any, p: Any) -> Any:
        r = x[0] ** 2 + x[1] ** 2
        return ca.vertcat(p * x[0] - 2 * x[1] + s * r * x[0], 2 * x[0] + p * x[1] + s * r * x[1])

    [point] = st.hopf(at_rest("xy", ["p"], rates), axis=("p", -1, 1.5, 9))
    assert isinstance(point, st.CycleBirth)
    assert (point.at, point.kind, point.stable_below) == (0, kind, True)
    assert within(point, 2 * s / 2, 1, 2)  # r² is twice |z|²


def test_van_der_pol_is_soft_with_the_coefficient_of_averaging() -> None:
    # r' = c r/2 - r³/8 with q = r cos, and r is √2 |z|
    family = at_rest("qv", ["c"], lambda x, p: ca.vertcat(x[1], -x[0] + (p - x[0] ** 2) * x[1]))
    [point] = st.hopf(family, axis=("c", -1, 1.5, 9))
    assert point.kind is Onset.SOFT
    assert within(point, mpmath.mpf(-1) / 4, mpmath.mpf(1) / 2, 1)


@pytest.mark.parametrize(
    "seed", [1, *(pytest.param(k, marks=pytest.mark.long) for k in range(2, 12))]
)
def test_a_planted_coefficient_is_found_in_other_coordinates(seed: int) -> None:
    """X = L (Z + h(Z)), h quadratic: l1 changes by the length of the mode alone."""
    rng = np.random.default_rng(seed)
    n, omega, s = 4, 1.5, float(rng.uniform(-2, 2))
    linear = np.round(rng.uniform(-1, 1, (n, n)) * 64) / 64 + 2 * np.eye(n)
    square = np.round(rng.uniform(-1, 1, (n, n, n)) * 8) / 8

    def rates(z: Any, p: Any) -> Any:
        bent = [
            z[i] + sum(square[i, j, k] * z[j] * z[k] for j in range(n) for k in range(n))
            for i in range(n)
        ]
        x = ca.mtimes(ca.DM(linear), ca.vertcat(*bent))
        r = x[0] ** 2 + x[1] ** 2
        f = ca.vertcat(
            p * x[0] - omega * x[1] + s * r * x[0],
            omega * x[0] + p * x[1] + s * r * x[1],
            -x[2] + x[0] * x[2],
            -2 * x[3] + x[2] * x[1],
        )
        return ca.mtimes(ca.inv_minor(ca.jacobian(x, z)), f)

    [point] = st.hopf(at_rest("abcd", ["p"], rates), axis=("p", -0.5, 0.75, 9))
    mode = np.linalg.solve(linear, np.array([1, -1j, 0, 0]) / np.sqrt(2))
    true = 2 * s / omega / np.linalg.norm(mode) ** 2
    assert point.kind is (Onset.SOFT if s < 0 else Onset.HARD)
    assert point.coefficient == pytest.approx(true, rel=1e-12)
    assert point.coefficient_error < 1e-14
    assert (point.crossing, point.frequency) == pytest.approx((1, omega), abs=1e-14)


@pytest.mark.filterwarnings("ignore::stability.StabilityWarning")
def test_the_brusselator_has_the_coefficient_of_the_planar_formula() -> None:
    def rates(x: Any, p: Any) -> Any:
        square = x[0] ** 2 * x[1]
        return ca.vertcat(p[1] - (p[0] + 1) * x[0] + square, p[0] * x[0] - square)

    family = at_rest(
        "xy",
        ["B", "A"],
        rates,
        held={},
        unknown={"x": 1.5, "y": 2.0},
        equations=("x", "y"),
        typical={"B": 3, "A": 1.5},
    )
    x, y, big, small = sympy.symbols("x y B A", real=True)
    f, g = small - (big + 1) * x + x**2 * y, big * x - x**2 * y
    for a in (sympy.Rational(1, 2), sympy.Rational(3, 2)):
        place = {x: a, y: (1 + a**2) / a, big: 1 + a**2, small: a}
        [point] = st.hopf(family, axis=("B", 1, 5, 9), A=float(a))
        true, omega = planar(f, g, x, y, place)
        assert abs(point.at - float(1 + a**2)) <= point.error < 1e-15
        assert point.kind is Onset.SOFT
        assert within(point, mpmath.mpf(str(true)), mpmath.mpf(1) / 2, mpmath.mpf(str(omega)))


def test_predator_and_prey_begin_to_oscillate_softly() -> None:
    # Rosenzweig & MacArthur: prey x (1 - x/K) - x y/(1 + x), predators y (x/(1 + x) - 1/2)
    def rates(x: Any, p: Any) -> Any:
        eaten = x[0] * x[1] / (1 + x[0])
        return ca.vertcat(x[0] * (1 - x[0] / p[0]) - eaten, eaten - x[1] / 2)

    family = at_rest(
        "xy", ["K"], rates, held={"x": 1}, unknown={"y": 1.0}, equations=("x",), typical={"K": 3}
    )
    x, y, k = sympy.symbols("x y K", real=True)
    f, g = x * (1 - x / k) - x * y / (1 + x), x * y / (1 + x) - y / 2
    place = {x: 1, y: sympy.Rational(4, 3), k: 3}  # tr = 0 where K = 2 x + 1
    [point] = st.hopf(family, axis=("K", 1.5, 5, 9))
    true, omega = planar(f, g, x, y, place)
    trace = (sympy.diff(f, x) + sympy.diff(g, y)).subs({y: (1 + x) * (1 - x / k)}).subs(x, 1)
    slope = sympy.diff(trace, k).subs(k, 3) / 2
    assert point.kind is Onset.SOFT and true < 0
    assert within(
        point, mpmath.mpf(str(true)), mpmath.mpf(str(sympy.N(slope, 40))), mpmath.mpf(str(omega))
    )


def test_the_lorenz_system_loses_its_steady_motion_hard() -> None:
    # J. E. Marsden & M. McCracken, The Hopf Bifurcation (1976), § 4B: subcritical here
    def rates(x: Any, p: Any) -> Any:
        return ca.vertcat(10 * (x[1] - x[0]), x[0] * (p - x[2]) - x[1], x[0] * x[1] - 8 * x[2] / 3)

    family = at_rest(
        "xyz",
        ["rho"],
        rates,
        held={},
        unknown=dict(x=8.0, y=8.0, z=24.0),
        equations=tuple("xyz"),
        positive=("x",),
        typical={"rho": 25},
    )
    [point] = st.hopf(family, axis=("rho", 20, 30, 9))
    assert point.kind is Onset.HARD
    assert abs(point.at - 470 / 19) <= 4e-15 and point.stable_below
    assert point.frequency == pytest.approx((8 / 3 * (10 + 470 / 19)) ** 0.5, rel=1e-15)


def governor(b: float = 0.5) -> st.Family:
    def rates(x: Any, p: Any) -> Any:
        turn = x[2] ** 2 * ca.sin(x[0]) * ca.cos(x[0]) - ca.sin(x[0]) - p[0] * x[1]
        return ca.vertcat(x[1], turn, p[1] * (ca.cos(x[0]) - p[2]))

    return at_rest(
        "xyz",
        ["e", "a", "b"],
        rates,
        held={"y": 0},
        positive=("x", "z"),
        equations=("y", "z"),
        unknown={"x": float(np.arccos(b)), "z": b**-0.5},
        typical={"e": 0.5, "a": 0.5, "b": b},
    )


@pytest.mark.few(2)
@pytest.mark.filterwarnings("ignore::stability.StabilityWarning")
@pytest.mark.parametrize(("a", "b"), [(0.5, 0.5), (0.5, 0.9), (0.25, 0.78), (0.25, 0.779)])
def test_the_watt_governor_is_soft_or_hard_as_published(a: float, b: float) -> None:
    [point] = st.hopf(governor(b), axis=("e", 0.05, 3, 9), a=a, b=b)
    assert point.at == pytest.approx(2 * a * b**1.5, rel=1e-15)
    sign = 3 + (a**2 - 5) * b**2 + a**4 * b**6  # positive where soft
    assert point.kind is (Onset.SOFT if sign > 0 else Onset.HARD)
    assert not point.stable_below


def test_states_on_which_nothing_depends_change_nothing() -> None:
    def rates(x: Any, p: Any) -> Any:
        return ca.vertcat(x[1], -x[0] + (p - x[0] ** 2) * x[1], x[0], x[2] + x[1])

    family = at_rest("qvst", ["c"], rates)
    [point] = st.hopf(family, axis=("c", -1, 1.5, 9))
    assert (point.kind, point.coefficient) == (Onset.SOFT, -0.25)


@pytest.mark.parametrize(("c", "kind"), [(-0.5, HopfKind.ELLIPTIC), (0.75, HopfKind.HYPERBOLIC)])
def test_a_line_of_steady_motions_has_its_planted_form(c: float, kind: HopfKind) -> None:
    def rates(x: Any, p: Any) -> Any:
        r = x[0] ** 2 + x[1] ** 2
        return ca.vertcat(x[2] * x[0] - x[1], x[0] + x[2] * x[1], p * r)

    family = at_rest("xyw", ["c"], rates, at=("w",), held={"x": 0, "y": 0})
    [point] = st.hopf(family, axis=("w", -1, 1.5, 9), c=c)
    assert (point.kind, point.at, point.stable_below) == (kind, 0, True)
    assert (point.crossing, point.push, point.frequency) == (1, 2 * c, 1)  # |x|² is twice |z|²
    if kind is HopfKind.ELLIPTIC:
        assert point.landing(0.25) == -0.25


def test_the_disk_as_a_users_family_has_the_disks_normal_form() -> None:
    family = st.disk_family("spinning", "viscous")
    [own] = st.hopf(family, axis=(family.at[0], 2.5, 5, 9), k=0.25, mu=0.8)
    [known] = st.hopf("spinning", contact=st.Viscous(0.8))
    assert isinstance(own, st.HopfPoint)
    assert (own.at, own.kind, own.stable_below) == (known.at, known.kind, known.stable_below)
    numbers = (own.frequency, own.crossing, own.push)
    assert numbers == pytest.approx((known.frequency, known.crossing, known.push), rel=1e-13)


def test_what_is_not_proved_is_undecided() -> None:
    def quintic(x: Any, p: Any) -> Any:
        r = (x[0] ** 2 + x[1] ** 2) ** 2
        return ca.vertcat(p * x[0] - x[1] - r * x[0], x[0] + p * x[1] - r * x[1])

    [point] = st.hopf(at_rest("xy", ["p"], quintic), axis=("p", -1, 1.5, 9))
    assert point.kind is Onset.UNDECIDED and "zero within its bound" in point.reason

    def pairs(x: Any, p: Any) -> Any:
        return ca.vertcat(
            p * x[0] - x[1] - x[0] ** 3, x[0] + p * x[1], p * x[2] - 2 * x[3], 2 * x[2] + p * x[3]
        )

    points = st.hopf(at_rest("abcd", ["p"], pairs), axis=("p", -1, 1.5, 9))
    assert [p.frequency for p in points] == pytest.approx([1, 2])
    assert all(p.kind is Onset.UNDECIDED and p.reason and p.unstable == -1 for p in points)


@pytest.mark.parametrize("s", [-1.5, 0.25])
def test_a_pair_that_crosses_while_others_are_unstable_has_its_coefficient(s: float) -> None:
    """The normal form with a + i b by s r², next to rates of growth 1 and 2: others do not act."""

    def form(x: Any, p: Any) -> Any:
        r = s * (x[0] ** 2 + x[1] ** 2)
        pair = [p * x[0] - x[1] + r * x[0], x[0] + p * x[1] + r * x[1]]
        return ca.vertcat(*pair, *((i - 1) * x[i] for i in range(2, x.numel())))

    family, axis = at_rest("abcd", ["p"], form), ("p", -1, 1.5, 9)
    [point] = st.hopf(family, axis=axis)
    assert isinstance(point, st.CycleBirth) and point.kind is Onset.UNSTABLE
    assert (point.at, point.stable_below, point.unstable) == (0, True, 2)
    assert point.reason == "2 other eigenvalues are unstable there"
    assert within(point, 2 * s, 1, 1)
    assert "unstable, the pair grows above" in birth_table(family, axis).to_text()


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ({}, "axis is missing"),
        ({"axis": ("c", -1, 1, 9), "contact": st.Rough()}, "contact belongs to the disk"),
        ({"axis": ("d", -1, 1, 9)}, "known for rest are c"),
    ],
)
def test_a_bad_question_is_refused_in_one_sentence(options: Any, sentence: str) -> None:
    family = at_rest("qv", ["c"], lambda x, p: ca.vertcat(x[1], -x[0] - p * x[1]))
    with pytest.raises(st.StabilityError, match=sentence):
        st.hopf(family, **options)


def test_conservative_families_and_other_zeros_are_refused() -> None:
    swing = at_rest("qv", ["c"], lambda x, p: ca.vertcat(x[1], -p * x[0]), conservative=True)
    with pytest.raises(st.StabilityError, match="conservative"):
        st.hopf(swing, axis=("c", -1, 1, 9))

    def rates(x: Any, p: Any) -> Any:
        return ca.vertcat(x[2] * x[0] - x[1], x[0] + (x[2] + p) * x[1], x[0] ** 2)

    line = at_rest("xyw", ["c"], rates, at=("w",), held={"x": 0, "y": 0})
    with pytest.raises(st.StabilityError, match="line of steady motions along w"):
        st.hopf(line, axis=("c", -1, 1, 9), w=0.1)


def test_the_table_says_the_same(tmp_path: Any, capsys: pytest.CaptureFixture[str]) -> None:
    from stability.cli.commands import main

    file = tmp_path / "swing.py"
    file.write_text(
        "import casadi as ca, stability as st\n"
        "x, c = ca.SX.sym('x', 2), ca.SX.sym('c')\n"
        "rates = ca.vertcat(x[1], -x[0] + (c - x[0] ** 2) * x[1])\n"
        "s = st.System('swing', x, c, rates, states=('q', 'v'), parameters=('c',))\n"
        "rest = st.Family(s, 'rest', at=('c',), held={'q': 0, 'v': 0})\n"
    )
    place = ["table", "hopf", "--system", f"{file}:rest", "--x", "c:-1:1.5:9"]
    assert main([*place, "--json"]) == 0
    [row] = json.loads(capsys.readouterr().out)["rows"]
    assert (row["at"], row["kind"], row["coefficient"]) == (0, "soft", -0.25)
    assert main(place) == 0
    assert "soft, unstable above" in capsys.readouterr().out
    assert main([*place, "--y", "c:0:1:3"]) == 2


def test_the_member_may_be_named_as_for_boundaries() -> None:
    """Soft at c = 0 for every k, asked along c at the member k: q'' = -k q + (c - q²) q'."""
    rest = at_rest(
        "qv", ("k", "c"), lambda x, p: ca.vertcat(x[1], -p[0] * x[0] + (p[1] - x[0] ** 2) * x[1])
    )
    (named,), (by_at,) = (
        st.hopf(rest, axis=("c", -1, 1, 9), **given) for given in ({"k": 4.0}, {"at": 4.0})
    )
    assert by_at == named
    assert (by_at.kind, by_at.frequency) == (Onset.SOFT, 2.0)
    with pytest.raises(st.StabilityError, match="give it once"):
        st.hopf(rest, axis=("k", 1, 4, 9), at=4.0, c=1.0)


def test_linear_rates_begin_neither_softly_nor_hard() -> None:
    x, c = ca.SX.sym("x", 2), ca.SX.sym("c")
    swing = st.System(
        "swing", x, c, ca.vertcat(x[1], -x[0] - c * x[1]), states=("q", "v"), parameters=("c",)
    )
    rest = st.Family(swing, "rest", at=("c",), held={"q": 0, "v": 0})
    [one] = st.hopf(rest, axis=("c", -1, 1, 9))
    assert one.kind is st.Onset.LINEAR
    assert "proved to be linear" in one.reason
