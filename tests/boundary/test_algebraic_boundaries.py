"""Boundaries along an axis in which a family is algebraic, though not rational: all, exactly."""

from __future__ import annotations

import math
import warnings
from collections import Counter
from collections.abc import Iterator
from functools import cache
from typing import Any

import casadi as ca
import mpmath
import pytest
from algebraic_boundaries import question
from transcendental_boundaries import judge

import stability as st
from stability.algebra.exact.hurwitz_forms import Budget
from stability.base.errors import StabilityError, StabilityWarning
from stability.boundary.algebraic import exact_search
from stability.boundary.algebraic.candidates import least_size
from stability.boundary.algebraic.tower import AxisPolynomial, Tower
from stability.boundary.brackets import AxisScan
from stability.spectra.axes import swept

EXACT = "isolated exactly, with functions and unknowns as algebraic numbers"


@pytest.fixture(autouse=True)
def _forty_digits() -> Iterator[None]:
    with mpmath.workdps(40):
        yield


def near(point: Any, exact: Any) -> bool:
    """Whether an exact value lies in the proved bracket, and the bracket is narrow."""
    bound = point.error + 1e-30
    return abs(mpmath.mpf(point.value) - exact) <= bound < 1e-13 * max(1, abs(exact))


def linear(entry: Any, *others: Any, condition: Any = None, **options: Any) -> st.Family:
    """dx/dt = diag(entry(p), -1, …) x about zero."""
    p = ca.SX.sym("p")
    values = [entry(p), -1, *(f(p) for f in others)]
    words = tuple(f"x{i}" for i in range(len(values)))
    x = ca.SX.sym("x", len(values))
    some = [st.Condition(condition(p), "it is {value:.3g}")] if condition else []
    system = st.System(
        "linear",
        x,
        p,
        ca.vertcat(*(v * x[i] for i, v in enumerate(values))),
        states=words,
        parameters=("p",),
        conditions=some,
    )
    return st.Family(system, "zero", ("p",), held=dict.fromkeys(words, 0.0), **options)


def solved(rate: Any, value: Any, guess: float, **options: Any) -> st.Family:
    """An unknown u with rate(u, p) = 0, next to an eigenvalue value(u, p)."""
    x, p = ca.SX.sym("x", 2), ca.SX.sym("p")
    rates = ca.vertcat(rate(x[0], p), value(x[0], p) * x[1])
    limit = (
        [st.Condition(options.pop("below") - x[0], "u is {value}")] if "below" in options else []
    )
    system = st.System(
        "solved", x, p, rates, states=("u", "y"), parameters=("p",), conditions=limit
    )
    return st.Family(
        system, "branch", ("p",), held={"y": 0.0}, unknown={"u": guess}, equations=("u",), **options
    )


# --- published boundaries ---


@cache
def governor() -> st.Family:
    """Watt's governor (Sotomayor, Mello & Braga, arXiv math/0606230): cos x = b, z² = 1/b."""
    x, q = ca.SX.sym("x", 3), ca.SX.sym("q", 3)
    a, b, e = ca.vertsplit(q)
    swing = x[2] ** 2 * ca.sin(x[0]) * ca.cos(x[0]) - ca.sin(x[0]) - e * x[1]
    system = st.System(
        "governor",
        x,
        q,
        ca.vertcat(x[1], swing, a * (ca.cos(x[0]) - b)),
        states=("x", "y", "z"),
        parameters=("a", "b", "e"),
    )
    return st.Family(
        system,
        "running",
        at=("e",),
        held={"y": 0.0},
        unknown={"x": 0.8, "z": 1.2},
        equations=("y", "z"),
        positive=("x", "z"),
        typical={"a": 0.5, "b": 0.7, "e": 0.6},
    )


def test_watts_governor_has_one_boundary_along_each_parameter() -> None:
    """E = 2 a b^(3/2): stable above along e, below along a and b."""
    a, b, e = map(mpmath.mpf, (0.5, 0.7, 0.6))
    half = mpmath.mpf(3) / 2
    asked: list[tuple[str, float, float, dict[str, float], Any, bool]] = [
        ("e", 0.05, 2.0, {"a": 0.5, "b": 0.7}, 2 * a * b**half, False),
        ("b", 0.2, 0.99, {"a": 0.5, "at": 0.6}, (e / (2 * a)) ** (mpmath.mpf(2) / 3), True),
        ("a", 0.05, 3.0, {"b": 0.7, "at": 0.6}, e / (2 * b**half), True),
    ]
    for name, low, high, given, exact, below in asked:
        [point] = found = st.boundaries(governor(), axis=(name, low, high, 2), **given)
        assert found.complete and EXACT in found.how and "one branch" in found.how
        assert near(point, exact) and point.stable_below is below
        assert point.crossing.word == "flutter"


@cache
def lorenz() -> st.Family:
    """C+ of Lorenz's equations: x² = b (r - 1)."""
    x, q = ca.SX.sym("x", 3), ca.SX.sym("q", 3)
    s, b, r = ca.vertsplit(q)
    rates = ca.vertcat(s * (x[1] - x[0]), x[0] * (r - x[2]) - x[1], x[0] * x[1] - b * x[2])
    system = st.System(
        "lorenz", x, q, rates, states=("x", "y", "z"), parameters=("sigma", "b", "r")
    )
    return st.Family(
        system,
        "C+",
        at=("r",),
        unknown={"x": 8.0, "y": 8.0, "z": 27.0},
        equations=("x", "y", "z"),
        positive=("x",),
        typical={"r": 28.0, "sigma": 10.0, "b": 8 / 3},
    )


def test_lorenz_equations_lose_stability_at_the_published_value_alone() -> None:
    """R = σ (σ + b + 3)/(σ - b - 1); along b it is linear, along σ quadratic."""
    s, b, r = mpmath.mpf(10), mpmath.mpf(8 / 3), mpmath.mpf(28)
    [point] = found = st.boundaries(lorenz(), axis=("r", 1.01, 60, 2), sigma=10, b=8 / 3)
    assert found.complete and EXACT in found.how and near(point, s * (s + b + 3) / (s - b - 1))
    assert point.stable_below and point.crossing.word == "flutter"
    [point] = found = st.boundaries(lorenz(), axis=("b", 0.1, 8.5, 2), at=28, sigma=10)
    assert found.complete and near(point, (r * (s - 1) - s * (s + 3)) / (s + r))
    found = st.boundaries(lorenz(), axis=("sigma", 0.1, 60, 2), at=28, b=8 / 3)
    middle, half = (r - b - 3) / 2, mpmath.sqrt(((r - b - 3) / 2) ** 2 - r * (b + 1))
    assert found.complete and len(found) == 2
    assert near(found[0], middle - half) and near(found[1], middle + half)


def test_the_triangular_point_of_three_bodies_is_lost_at_the_mass_of_gascheau() -> None:
    x, m = ca.SX.sym("x", 4), ca.SX.sym("m")
    far, close = (ca.sqrt((x[0] + m - k) ** 2 + x[1] ** 2) for k in (0, 1))
    pull = [
        2 * x[3] + x[0] - (1 - m) * (x[0] + m) / far**3 - m * (x[0] - 1 + m) / close**3,
        -2 * x[2] + x[1] - (1 - m) * x[1] / far**3 - m * x[1] / close**3,
    ]
    system = st.System(
        "three-body",
        x,
        m,
        ca.vertcat(x[2], x[3], *pull),
        states=("X", "Y", "U", "V"),
        parameters=("m",),
    )
    family = st.Family(
        system,
        "L4",
        at=("m",),
        held={"U": 0.0, "V": 0.0},
        unknown={"X": 0.47, "Y": 0.866},
        equations=("U", "V"),
        positive=("Y",),
        typical={"m": 0.03},
    )
    [point] = found = st.boundaries(family, axis=("m", 0.001, 0.5, 2))
    assert found.complete and near(point, (1 - mpmath.sqrt(69) / 9) / 2) and point.stable_below


# --- sines, roots and exponentials of the axis ---


@pytest.mark.parametrize("sign", [-1, 1])
def test_double_zeros_are_single_points_and_no_changes(sign: int) -> None:
    """(cos p - 1/2)² is zero at ±π/3 + 2πk; 1 - cos p at 2πk."""
    found = st.boundaries(linear(lambda p: sign * (ca.cos(p) - 0.5) ** 2), axis=("p", -1.5, 8, 2))
    assert found == [] and found.complete and EXACT in found.how
    exact = [-math.pi / 3, math.pi / 3, 5 * math.pi / 3, 7 * math.pi / 3]
    assert found.touching == pytest.approx(exact, abs=1e-15)
    found = st.boundaries(linear(lambda p: sign * (1 - ca.cos(p))), axis=("p", -1.5, 8, 2))
    assert found == [] and found.complete
    assert found.touching == pytest.approx([0, 2 * math.pi], abs=1e-15)


def test_a_zero_behind_a_touching_one_is_still_found() -> None:
    """(1 - cos p)(p-free sine) changes at π/6 and 5π/6 alone; sin 3p and cos p are one angle."""
    found = st.boundaries(
        linear(lambda p: (1 - ca.cos(p)) * (ca.sin(p) - 0.5), lambda p: ca.sin(3 * p) - 2),
        axis=("p", -1, 6.5, 2),
    )
    assert found.complete and len(found) == 2
    assert near(found[0], mpmath.pi / 6) and near(found[1], 5 * mpmath.pi / 6)
    assert [b.stable_below for b in found] == [True, False]
    assert found.touching == pytest.approx([0, 2 * math.pi], abs=1e-14)


def test_an_undamped_motion_is_neutral_between_damping_and_driving_alone() -> None:
    """λ² - sin(p)² λ + 1: unstable but at 0 and π."""
    x, p = ca.SX.sym("x", 2), ca.SX.sym("p")
    rates = ca.vertcat(x[1], -x[0] + ca.sin(p) ** 2 * x[1])
    system = st.System("driven", x, p, rates, states=("q", "v"), parameters=("p",))
    family = st.Family(system, "rest", ("p",), held={"q": 0.0, "v": 0.0})
    found = st.boundaries(family, axis=("p", -1, 4, 2))
    assert found == [] and found.complete
    assert found.touching == pytest.approx([0, math.pi], abs=1e-15)


def test_roots_and_exponentials_of_the_axis() -> None:
    [point] = found = st.boundaries(linear(lambda p: ca.sqrt(p) - 1), axis=("p", 0, 4, 2))
    assert found.complete and point.value == 1 and point.stable_below
    [point] = found = st.boundaries(
        linear(lambda p: ca.exp(2 * p) - ca.exp(p) - 1), axis=("p", -3, 4, 2)
    )
    assert found.complete and near(point, mpmath.log(mpmath.phi))
    found = st.boundaries(linear(lambda p: 2 - ca.cosh(p)), axis=("p", -3, 4, 2))
    assert found.complete and near(found[0], -mpmath.acosh(2)) and near(found[1], mpmath.acosh(2))
    [point] = found = st.boundaries(
        linear(lambda p: ca.sqrt(p + 2) + ca.sqrt(3 * p + 7) - 4), axis=("p", -1, 4, 2)
    )
    exact = mpmath.findroot(lambda t: mpmath.sqrt(t + 2) + mpmath.sqrt(3 * t + 7) - 4, 0.0)
    assert found.complete and near(point, exact)


def test_a_given_angle_is_a_transcendental_constant() -> None:
    """P = tan 0.3 for a spring that is tilted by a held angle."""
    x, p = ca.SX.sym("x", 3), ca.SX.sym("p")
    rates = ca.vertcat(x[1], -x[0] * ca.sqrt(p) - x[1] * (p * ca.cos(x[2]) - ca.sin(x[2])), 0)
    system = st.System("tilted", x, p, rates, states=("q", "v", "tilt"), parameters=("p",))
    family = st.Family(system, "rest", ("p", "tilt"), held={"q": 0.0, "v": 0.0})
    [point] = found = st.boundaries(family, axis=("p", 0.01, 2, 2), tilt=0.3)
    assert near(point, mpmath.tan(mpmath.mpf(0.3)))
    assert found.complete and EXACT in found.how and not point.stable_below


# --- branches ---


def test_the_branch_of_the_family_decides_which_roots_count() -> None:
    """U² = p² + 1: u = 2 - p on the upper branch at 3/4; the lower one never meets that line."""
    rate = lambda u, p: p * p + 1 - u * u  # noqa: E731
    upper = solved(rate, lambda u, p: u + p - 2, 1.2, positive=("u",))
    [point] = found = st.boundaries(upper, axis=("p", -3, 3, 2))
    assert found.complete and near(point, mpmath.mpf(0.75)) and point.stable_below
    lower = solved(lambda u, p: u * u - p * p - 1, lambda u, p: u + p - 2, -1.2)
    found = st.boundaries(lower, axis=("p", -3, 3, 2))
    assert found == [] and found.complete


@pytest.mark.long
def test_the_gap_between_two_folds_is_exact() -> None:
    family = solved(
        lambda u, p: (p - 1) * (p - 2) - u * u, lambda u, _: u - 1, 1.0, positive=("u",)
    )
    with pytest.warns(StabilityWarning, match="no unique steady motion"):
        found = st.boundaries(family, axis=("p", -1, 4, 2))
    [gap] = found.unresolved
    assert gap.low == pytest.approx(1, abs=1e-15) and gap.low <= 1
    assert gap.high == pytest.approx(2, abs=1e-15) and gap.high >= 2
    exact = [mpmath.mpf(1.5) + k * mpmath.sqrt(1.25) for k in (-1, 1)]
    assert near(found[0], exact[0]) and near(found[1], exact[1])


@pytest.mark.long
def test_a_fold_behind_which_another_branch_is_found_stays_open() -> None:
    """U³ = u + p folds at p = ±2/(3√3); the guess 1.2 leaves its branch at the lower one."""
    family = solved(lambda u, p: p + u - u**3, lambda u, _: u - 3, 1.2)
    with pytest.warns(StabilityWarning, match="not complete"):
        found = st.boundaries(family, axis=("p", -1.5, 1.5, 2))
    [fold] = [u for u in found.unresolved if "two steady motions meet" in u.reason]
    exact = -2 / (3 * math.sqrt(3))
    assert found == [] and fold.low <= exact <= fold.high and fold.high - fold.low < 1e-14


def test_a_pole_is_named() -> None:
    with pytest.warns(StabilityWarning, match="may have no value there"):
        found = st.boundaries(linear(lambda p: 1 / (ca.cos(p) - 0.5)), axis=("p", 0, 2, 2))
    [pole] = found.unresolved
    assert found == [] and pole.low <= math.pi / 3 <= pole.high < pole.low + 1e-14


# --- conditions of the system ---


@pytest.mark.parametrize(
    "entry",
    [
        lambda p: (p - 1) * (p - 3),
        lambda p: ca.cos(p) - ca.cos(ca.SX(3)),
        lambda p: p - ca.exp(p - 3) - 2,
    ],
)
def test_parts_where_a_condition_fails_have_no_members(entry: Any) -> None:
    """(p - 1)² > 0.25 leaves out 0.5 … 1.5, in each of the three searches."""
    family = linear(entry, condition=lambda p: (p - 1) ** 2 - 0.25)
    with pytest.warns(StabilityWarning, match="a condition of linear fails: it is -0"):
        found = st.boundaries(family, axis=("p", 0, 2.5, 2))
    [part] = found.unresolved
    assert found == [] and not found.complete
    assert part.low == pytest.approx(0.5) and part.low <= 0.5
    assert part.high == pytest.approx(1.5) and part.high >= 1.5


def test_a_condition_on_an_unknown_is_checked_along_the_branch() -> None:
    """U = √(p² + 1) < 2 holds up to √3; both ends inside, so nothing is left open."""
    family = solved(
        lambda u, p: p * p + 1 - u * u, lambda u, _: u - 1.5, 1.2, positive=("u",), below=2
    )
    found = st.boundaries(family, axis=("p", -1.5, 1.5, 2))
    assert found.complete and near(found[1], mpmath.sqrt(1.25)) and len(found) == 2


# --- limits ---


def test_what_is_too_large_goes_to_the_interval_search_and_says_so(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    family = linear(lambda p: ca.cos(p) - 0.25)
    monkeypatch.setattr(exact_search, "MOST_TERMS", 1)
    [point] = found = st.boundaries(family, axis=("p", 0, 3, 2))
    assert near(point, mpmath.acos(0.25)) and found.complete
    assert "pieces" in found.how and "no exact search" in found.how and "limits" in found.how
    monkeypatch.undo()
    mixed = st.boundaries(linear(lambda p: ca.cos(p) - p), axis=("p", 0, 3, 2))
    assert "no exact search, since p and sin of it both occur" in mixed.how


def test_a_zero_at_a_cut_between_two_pieces_is_found() -> None:
    """The search would cut the interval at the planted zero: it shifts the cut."""
    zero = -1 + 4 * 0.4916015625
    family = linear(lambda p: (ca.exp(p - zero) - 1) * (2 + ca.sin(p)))
    [point] = found = st.boundaries(family, axis=("p", -1, 3, 2))
    assert found.complete and "pieces" in found.how and abs(point.value - zero) <= point.error


def test_the_slope_of_an_absolute_value_is_read_away_from_zero() -> None:
    """V |v| drag: the eigenvalue p - 2 |v| at v = 1.5, and at -1.5."""
    for speed in (1.5, -1.5):
        v, p = ca.SX.sym("v"), ca.SX.sym("p")
        rate = p * (v - speed) - v * ca.fabs(v) + speed * abs(speed)
        system = st.System("drag", v, p, rate, states=("v",), parameters=("p",))
        family = st.Family(system, "steady", ("p",), held={"v": speed})
        [point] = found = st.boundaries(family, axis=("p", 0, 4, 2))
        assert found.complete and abs(point.value - 3) <= point.error
    system = st.System("dry", v, p, -p * ca.sign(v), states=("v",), parameters=("p",))
    with pytest.raises(StabilityError, match="no value there, such as the sign of 0"):
        st.spectrum(st.Family(system, "rest", ("p",), held={"v": 0.0}), at=1.0)


@pytest.mark.parametrize(("shift", "least"), [(1, math.sqrt(2) - 1), (0, math.sqrt(2))])
def test_the_bound_for_a_zero_is_below_every_other_conjugate(shift: int, least: float) -> None:
    """√p - k at p = 2 has the conjugates ±√2 - k; times p - 2 it is zero, without a conjugate."""
    family = linear(lambda p: ca.sqrt(p) - 3)
    problem = swept(family, {"axis": ("p", 1, 4, 2)})[0]
    budget = Budget(4000, 10)
    tower = Tower(AxisPolynomial(AxisScan(problem, "p", {}), (1, 4), budget))
    z, root = tower.ring.gens()[0], tower.ring.gens()[tower.levels[0].index]
    bound = least_size(tower, root - shift, z - 2, budget)
    assert bound is not None and 0 < float(bound.p) / float(bound.q) <= least
    assert least_size(tower, root - shift, z**60 - 2, budget) is None  # too many conjugates


# --- planted families ---


def campaign(seeds: range) -> tuple[Counter[tuple[str, str]], list[str]]:
    """How searches ended, and what was wrong."""
    ends: Counter[tuple[str, str]] = Counter()
    wrong = []
    for seed in seeds:
        one = question(seed)
        how, faults, _ = judge(one)
        ends[one.kind, how] += 1
        wrong += [f"{seed} {one.kind}: {fault}" for fault in faults]
    return ends, wrong


@pytest.mark.parametrize("count", [5, pytest.param(15, marks=pytest.mark.long)])
def test_random_planted_boundaries_are_all_found(count: int) -> None:
    """Only the families with a gap, where there is no member, are not complete."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", StabilityWarning)
        ends, wrong = campaign(range(count))
    assert not wrong, "\n".join(wrong)
    assert set(ends) <= {(k, "complete") for k in ("turn", "root", "cubic", "hyperbola")} | {
        ("gap", "open")
    }


def test_a_verdict_that_its_number_field_leaves_open_is_sought_with_expressions() -> None:
    assert campaign(range(1373, 1374))[1] == []


@pytest.mark.long
def test_a_thousand_planted_families_have_every_boundary() -> None:
    ends, wrong = campaign(range(1000, 2000))
    assert not wrong, "\n".join(wrong[:20])
    assert sum(n for (kind, how), n in ends.items() if kind != "gap" and how != "complete") <= 5


# --- branches that cross ---


def prey_and_predator(h: float = 1.0) -> st.Family:
    """Rosenzweig and MacArthur's model at coexistence, where the predator may be negative too."""
    x, y, *given = (ca.SX.sym(n) for n in ("x", "y", "K", "d"))
    capacity, death = given
    eaten = x * y / (1 + h * x)
    system = st.System(
        "prey",
        ca.vertcat(x, y),
        ca.vertcat(*given),
        ca.vertcat(x * (1 - x / capacity) - eaten, eaten - death * y),
        states=("x", "y"),
        parameters=("K", "d"),
    )
    return system.steady("K", guess={"x": 0.6, "y": 0.8, "K": 2.0, "d": 0.375})


@pytest.mark.few(1)
@pytest.mark.parametrize("death", [0.375, 0.25, 0.5])
def test_a_branch_that_another_one_crosses_goes_on_through_the_crossing(death: float) -> None:
    """The prey is x = d/(1 - d); trans-critical at K = x, oscillation from K = (1 + d)/(1 - d)."""
    found = st.boundaries(prey_and_predator(), axis=("K", 0.1, 5, 9), d=death)
    assert found.complete
    assert [(b.crossing.word, b.stable_below) for b in found] == [
        ("static", False),
        ("flutter", True),
    ]
    wanted = [death / (1 - death), (1 + death) / (1 - death)]
    assert [b.value for b in found] == pytest.approx(wanted, rel=1e-14)


def test_a_root_finder_that_passes_to_another_branch_between_samples_is_seen() -> None:
    """dx/dt = x (p - x): the guess 1/2 leads to x = p up to p = 1, and then to the unstable 0."""
    x, p = ca.SX.sym("x"), ca.SX.sym("p")
    system = st.System("s", x, p, x * (p - x), states=("x",), parameters=("p",))
    family = st.Family(system, "f", ("p",), unknown={"x": 0.5}, equations=("x",))
    assert [st.spectrum(family, at=v).verdict.word for v in (0.9, 1.01)] == ["stable", "unstable"]
    with pytest.warns(st.StabilityWarning, match="not complete"):
        found = st.boundaries(family, axis=("p", 0.2, 1.02, 9))
    assert any(u.high >= 1.0 for u in found.unresolved)


@pytest.mark.parametrize(
    ("damping", "expected", "touching"),
    [
        (lambda p: 1 + ca.fabs(p), [], ()),
        (lambda p: 1 + ca.sqrt((p - 0.3) ** 2), [], ()),
        (lambda p: ca.fabs(p - 1) - 0.5, [0.5, 1.5], ()),
        (lambda p: 3 * ca.fabs(p) + p, [], (0.0,)),
        (lambda p: ca.fabs(p) + 2 * p, [0.0], ()),
    ],
)
def test_a_kink_along_the_axis_is_no_end_of_the_family(
    damping: Any, expected: list[float], touching: tuple[float, ...]
) -> None:
    """An oscillator with damping that is linear on both sides of each kink."""
    x, p = ca.SX.sym("x", 2), ca.SX.sym("p")
    rates = ca.vertcat(x[1], -4 * x[0] - damping(p) * x[1])
    system = st.System("kinked", x, p, rates, states=("x", "v"), parameters=("p",))
    rest = st.Family(system, "rest", at=("p",), held={"x": 0, "v": 0})
    found = st.boundaries(rest, axis=("p", -2, 2, 20))
    assert found.complete
    assert [b.value for b in found] == pytest.approx(expected, abs=1e-12)
    assert [(b.crossing.word, b.frequency) for b in found] == [("flutter", 2.0)] * len(expected)
    assert found.touching == pytest.approx(touching, abs=1e-12)
