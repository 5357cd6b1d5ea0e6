"""Boundaries along an axis: all of them, each a proved bracket, or a statement of what is open."""

import math
import warnings
from collections.abc import Sequence
from fractions import Fraction
from typing import Any

import boundary_oracle as oracle
import casadi as ca
import numpy as np
import pytest

import stability as st
from stability.base.errors import StabilityWarning
from stability.bodies.contact_laws import Contact
from stability.boundary.brackets import Boundaries
from stability.boundary.changes import along
from stability.spectra.problem import disk_problem

LAWS: dict[str, type[Contact]] = {
    "smooth": st.Smooth,
    "viscous": st.Viscous,
    "linear-viscous": st.LinearViscous,
    "rough": st.Rough,
}


# --- against an independent count of real roots ---


def request(rng: np.random.Generator) -> tuple[str, str, str, float, float, dict[str, float], bool]:
    """A random question: family, law, axis, ends, everything else, whether logarithmic."""
    if rng.random() < 0.3:
        return crowded(rng)
    family, law = oracle.CASES[rng.integers(len(oracle.CASES))]
    if rng.random() < 0.35:
        law = "viscous"
        family = ("rolling", "spinning", "tumbling")[rng.integers(3)]
    si = rng.random() < 0.4
    given = {
        "k": float(rng.uniform(0.01, 0.5))
        if rng.random() < 0.7
        else float(rng.choice([0.25, 0.5, 0.375, 0.125])),
        "mass": 1.0,
        "radius": 1.0,
        "gravity": 1.0,
    }
    if si:
        given |= {
            "mass": float(10 ** rng.uniform(-3, 1)),
            "radius": float(10 ** rng.uniform(-2, 1)),
            "gravity": float(rng.uniform(1, 30)),
        }
    rate = math.sqrt(given["gravity"] / given["radius"])
    speed = math.sqrt(given["gravity"] * given["radius"])
    friction = 10 ** rng.uniform(-2, 1.5) if rng.random() < 0.4 else rng.uniform(0.3, 1.6)
    if law == "viscous":
        given["mu"] = float(friction / speed)
    if law == "linear-viscous":
        given["c"] = float(friction * given["mass"] * rate)
    names = ["k", *(("mu",) if law == "viscous" else ("c",) if law == "linear-viscous" else ())]
    if si:
        names += ["mass", "radius", "gravity"]
    turn = float(10 ** rng.uniform(-0.7, 1) * rate)
    if family == "circling":
        given |= {"theta": float(rng.uniform(0.02, 3.1)), "phi_dot": turn}
        names += ["theta", "phi_dot"] * 2
    elif family == "tumbling" and rng.random() < 0.3:
        given["lean"] = float(rng.uniform(-1.5, 1.5))
        names += ["lean"] * 3
    elif family == "tumbling":
        given["at"] = float(rng.uniform(0.01, 3.13))
        names += ["at"] * 4
    else:
        given["at"] = turn
        names += ["at"] * 4
    axis = names[rng.integers(len(names))]
    size = {"mu": 1 / speed, "c": given["mass"] * rate, "at": rate, "phi_dot": rate}
    size |= {n: given[n] for n in ("radius", "gravity", "mass")}
    ranges = {"k": (0.002, 0.5), "theta": (0.001, 3.14), "lean": (-1.57, 1.57)}
    if family == "tumbling":
        ranges["at"] = (0.001, 3.14)
    if axis in ranges:
        low, high = sorted(
            rng.beta(0.5, 0.5, 2) * (ranges[axis][1] - ranges[axis][0]) + ranges[axis][0]
        )
        if axis == "k" and rng.random() < 0.2:
            high = 0.5
    else:
        unit = size[axis]
        low = 10 ** rng.uniform(-2, 0.4) * unit
        high = low * 10 ** (2.5 * rng.random() ** 0.5)
    del given[axis]
    log = bool(axis not in ("lean",) and rng.random() < 0.4)
    return family, law, axis, float(low), float(high), given, log


def crowded(rng: np.random.Generator) -> Any:
    """A request where boundaries come in pairs: static and flutter, folds, mirror images."""
    k = float(rng.uniform(0.02, 0.5))
    first, last = 4 * k / (2 * k + 1) ** 2, 24 * k / ((2 * k + 1) * (4 * k + 3))
    mu = float(math.sqrt(first + (last - first) * rng.beta(2, 0.4)))
    given = {"k": k, "mass": 1.0, "radius": 1.0, "gravity": 1.0, "mu": mu}
    which = rng.integers(3)
    if which == 0:  # along mu at a phi_dot a little beyond the static boundary
        given["at"] = float((1 + 10 ** rng.uniform(-3, 0)) / math.sqrt(k))
        del given["mu"]
        return "spinning", "viscous", "mu", 0.05, 20.0, given, True
    if which == 1:
        return "spinning", "viscous", "at", 0.05, 1e4, given, True
    low, high = float(rng.uniform(1e-4, 0.5)), float(rng.uniform(0.9, 3.13))
    return "tumbling", "viscous", "at", low, high, given, False


def ask(
    family: str,
    law: str,
    axis: str,
    low: float,
    high: float,
    given: dict[str, float],
    *,
    log: bool = False,
) -> Boundaries:
    """The package's answer, by the way of `boundaries` that takes any value by name."""
    body = st.Disk(
        **{n: given.get(n, 0.25 if n == "k" else 1.0) for n in ("mass", "radius", "k", "gravity")}
    )
    extra = {n: given.get(n, 1.0) for n in ("mu", "c") if n in given or n == axis}
    where: dict[str, Any] = {"at": given.get("at", 1.0)}
    if family == "circling":
        where = {"at": [given.get("theta", 1.0), given.get("phi_dot", 1.0)]}
    if "lean" in given or axis == "lean":
        where = {"lean": given.get("lean", 0.0)}
    question = disk_problem(family, body, LAWS[law](**extra), **where)
    return along(question, axis, low, high, points=2, log=log)


def compare(
    family: str,
    law: str,
    axis: str,
    low: float,
    high: float,
    given: dict[str, float],
    *,
    log: bool = False,
) -> list[float]:
    """Assert that the package finds exactly the changes of the oracle; where they are."""
    what = f"{(family, law, axis, low, high, given, log)!r}"
    wanted = oracle.changes(family, law, axis, low, high, given)
    found = ask(family, law, axis, low, high, given, log=log)
    assert found.complete, (what, found.unresolved)
    assert all(low <= p.value <= high for p in found), (what, found)
    assert len(found) == len(wanted), (what, found, wanted)
    for point, truth in zip(found, wanted, strict=True):
        assert abs(point.value - truth.value) <= point.error, (what, point, truth)
        assert point.error <= 1e-9 * abs(point.value), (what, point)
        assert point.stable_below == truth.stable_below, (what, point, truth)
    return [float(c.value) for c in wanted]


def campaign(seed: int, count: int) -> dict[str, int]:
    """Random requests, and for what they find requests that end next to a boundary."""
    rng = np.random.default_rng(seed)
    told = dict.fromkeys(("requests", "boundaries", "several", "next"), 0)
    for _ in range(count):
        family, law, axis, low, high, given, log = request(rng)
        values = compare(family, law, axis, low, high, given, log=log)
        told["requests"] += 1
        told["boundaries"] += len(values)
        told["several"] += len(values) > 1
        for value in values[:2]:  # the boundary lies within half an ulp of an end, in or out
            ulp = int(rng.integers(-1, 2)) * np.spacing(value)
            ends = (value + ulp, high) if rng.random() < 0.5 else (low, value + ulp)
            if ends[0] < ends[1]:
                compare(family, law, axis, float(ends[0]), float(ends[1]), given, log=log)
                told["next"] += 1
    return told


def test_random_requests_have_every_boundary() -> None:
    told = campaign(seed=5, count=25)
    assert told["boundaries"] > 8 and told["several"] > 0 and told["next"] > 8, told


@pytest.mark.long
def test_six_thousand_random_requests_have_every_boundary() -> None:
    """Family, law, axis, range, spacing, units at random, against Sturm on Kane's polynomial."""
    told = campaign(seed=20261121, count=6000)
    print(told)
    assert told["boundaries"] > 2500 and told["several"] > 500, told


@pytest.mark.long
def test_the_kept_polynomials_are_those_of_kanes_equations() -> None:
    for family, law in oracle.CASES:
        assert oracle.derive(family, law) == oracle.polynomials()[f"{family} {law}"]


# --- pairs, ends, degenerate lines ---


def test_a_pair_between_points_of_the_scan_is_found() -> None:
    """The flutter boundary: root of a2 v² + a1 v + a0 in v = z - 1/k, worked out by hand."""
    found = st.boundaries("spinning", axis=("at", 0.1, 5, 50), contact=st.Viscous(0.97))
    assert [p.crossing.word for p in found] == ["static", "flutter"]
    assert found[0].value == 2.0 and found.complete
    assert found[1].value == pytest.approx(2.0451355787150489602, rel=1e-15)
    assert [p.stable_below for p in found] == [False, True]


@pytest.mark.parametrize(
    ("low", "high", "count"),
    [(2.0, 5.0, 1), (0.5, 2.0, 1), (np.nextafter(2.0, 3), 5.0, 0), (0.5, np.nextafter(2.0, 1), 0)],
)
def test_a_boundary_at_an_end_belongs_to_the_interval(low: float, high: float, count: int) -> None:
    found = st.boundaries(
        "spinning",
        axis=("at", float(low), float(high), 9),
        contact=st.Rough(),
        disk=st.Disk(k=0.25),
    )
    # rough: (1 + k) phi_dot² = 1, far below; smooth: k phi_dot² = 1, at 2 exactly
    assert found.complete
    smooth = st.boundaries("spinning", axis=("at", float(low), float(high), 9), contact=st.Smooth())
    assert [p.value for p in smooth] == [2.0] * count
    assert smooth.complete
    for point in smooth:
        sides = [
            st.spectrum(
                "spinning", at=point.value + s * point.error, contact=st.Smooth(), certify=True
            ).verdict.word
            for s in (-1, 1)
        ]
        assert sides == ["unstable", "neutral"]


def test_the_hoops_end_of_k_belongs_to_the_interval() -> None:
    """Smooth rolling: 4 k at² = 1; at² = 1/2 puts the boundary at the hoop, k = 1/2 ... times."""
    at = math.sqrt(0.5)
    found = st.boundaries("rolling", axis=("k", 0.1, 0.5, 3), at=at, contact=st.Smooth())
    exactly = 1 / (4 * Fraction(at) ** 2)
    assert len(found) == (exactly <= Fraction(1, 2))
    for at in (0.75, 1.0):  # 4/9 and 1/4
        [point] = st.boundaries("rolling", axis=("k", 0.1, 0.5, 3), at=at, contact=st.Smooth())
        assert point.value == pytest.approx(1 / (4 * at * at), rel=1e-15)
    [point] = st.boundaries("rolling", axis=("k", 0.1, 0.5, 3), at=1.0, contact=st.Viscous(0.3))
    assert point.value == 0.5 and point.stable_below is False  # 2 k at² = 1 at the hoop itself


def test_a_line_that_lies_on_a_boundary_has_what_is_left_of_it() -> None:
    """phi_dot = 2 at k = 1/4 is static for every mu; beyond M2 = 1 a pair is unstable as well."""
    found = st.boundaries("spinning", axis=("mu", 0.1, 5, 9), at=2.0)
    assert [(p.value, p.crossing.word, p.stable_below) for p in found] == [(1.0, "flutter", True)]
    assert found.complete
    for mu, word in ((0.99, "neutral"), (1.01, "unstable")):
        assert (
            st.spectrum("spinning", at=2.0, contact=st.Viscous(mu), certify=True).verdict.word
            == word
        )
    # 2 k at² = 1 for every mu: a pair on the axis all along
    flat = st.boundaries("rolling", axis=("mu", 0.1, 5, 9), at=1.0, disk=st.Disk(k=0.5))
    assert flat == [] and flat.complete


def test_both_signs_of_the_spin_are_searched() -> None:
    found = st.boundaries("rolling", axis=("at", -3, 3, 5), contact=st.Viscous(0.3))
    assert [p.value for p in found] == [-(2**0.5), 2**0.5]
    assert [p.stable_below for p in found] == [True, False]


def test_upright_is_named_as_a_point_that_touches() -> None:
    """At lean 0 tumbling meets spinning: neutral there, stable on both sides."""
    found = st.boundaries("tumbling", axis=("lean", -0.5, 0.5, 5), contact=st.Viscous(0.3))
    assert found == [] and found.complete and found.touching == (0.0,)
    words = [
        st.spectrum("tumbling", lean=v, contact=st.Viscous(0.3), certify=True).verdict.word
        for v in (-1e-3, 0.0, 1e-3)
    ]
    assert words == ["stable", "neutral", "stable"]


@pytest.mark.parametrize("axis", ["theta", "phi_dot", "k", "gravity"])
def test_circling_is_searched_along_any_axis(axis: str) -> None:
    given = {"theta": 2.4, "phi_dot": 1.1, "k": 0.3, "mass": 1.0, "radius": 0.7, "gravity": 3.0}
    ends = {"theta": (0.01, 3.1), "phi_dot": (0.05, 30.0), "k": (0.01, 0.5), "gravity": (0.1, 30)}
    del given[axis]
    compare("circling", "rough", axis, *ends[axis], given)


def test_circlings_other_number_is_given_as_at() -> None:
    found = st.boundaries("circling", axis=("theta", 0.01, 3.1, 9), at=0.7, contact=st.Rough())
    body = {"k": 0.25, "mass": 1.0, "radius": 1.0, "gravity": 1.0}
    wanted = oracle.changes("circling", "rough", "theta", 0.01, 3.1, body | {"phi_dot": 0.7})
    assert [p.value for p in found] == pytest.approx([float(c.value) for c in wanted], rel=1e-15)
    assert len(wanted) == 2
    with pytest.warns(StabilityWarning, match="no member"):
        across = st.boundaries("circling", axis=("phi_dot", -3, 3, 9), at=0.4, contact=st.Rough())
    assert not across.complete and across.unresolved[0][:2] == (0.0, 0.0)  # no member at 0


# --- what the result is ---


def test_the_result_is_used_like_a_list() -> None:
    found = st.boundaries("spinning", axis=("at", 0.1, 5, 9), contact=st.Viscous(0.97))
    none = st.boundaries("rolling", axis=("at", 2, 3, 9), contact=st.Viscous(0.97))
    assert isinstance(found, Sequence) and isinstance(found, st.Boundaries)
    first, second = found
    assert (found[0], found[-1], found[:1], found[::-1]) == (
        first,
        second,
        [first],
        [second, first],
    )
    assert found == [first, second] and [first, second] == found and found != [first]
    assert len(found) == 2 and found and not none and none == [] and list(none) == []
    assert found + none == [first, second] and [first] + found == [first, first, second]
    assert first in found and found.index(second) == 1 and sorted(found, key=id)
    assert found.complete is True and found.unresolved == ()
    assert repr(none).startswith(
        "<0 boundaries along at from 2 to 3 √(g/R), stable throughout; complete: every real root of"
    )


# --- systems with known answers ---


def linear(name: str, rhs: Any, names: Sequence[str], at: str, **options: Any) -> st.Family:
    """A linear system about zero; `rhs` takes the states and the parameters by name."""
    x = ca.SX.sym("x", options.pop("states", 4))
    p = [ca.SX.sym(n) for n in names]
    states = tuple(f"x{i}" for i in range(x.numel()))
    system = st.System(
        name, x, ca.vertcat(*p), ca.vertcat(*rhs(x, *p)), states=states, parameters=tuple(names)
    )
    return st.Family(system, "straight", at=(at,), held=dict.fromkeys(states, 0.0), **options)


def sleeping(*, conservative: bool) -> st.Family:
    return linear(
        "top",
        lambda x, h: (x[2], x[3], x[0] - h * x[3], x[1] + h * x[2]),
        ("H",),
        "H",
        conservative=conservative,
    )


@pytest.mark.parametrize("conservative", [True, False])
def test_the_sleeping_top_is_neutral_above_two(conservative: bool) -> None:
    """λ⁴ + (H² - 2) λ² + 1: two pairs meet in (λ² + 1)² at H = 2."""
    found = st.boundaries(sleeping(conservative=conservative), axis=("H", 0.5, 5, 20))
    [point] = found
    assert (point.value, point.frequency, point.stable_below) == (2.0, 1.0, False)
    assert point.crossing is st.Crossing.FLUTTER and found.complete


@pytest.mark.parametrize("points", [2, 19, 20, 91])
def test_two_tops_meet_their_boundaries_at_once(points: int) -> None:
    """Symmetric spectra: every eigenvalue is double for every H, and fourfold at H = 2."""
    two = linear(
        "tops",
        lambda x, h: (
            x[2],
            x[3],
            x[0] - h * x[3],
            x[1] + h * x[2],
            x[6],
            x[7],
            x[4] - h * x[7],
            x[5] + h * x[6],
        ),
        ("H",),
        "H",
        states=8,
        conservative=True,
    )
    found = st.boundaries(two, axis=("H", 0.5, 5, points))
    assert [(p.value, p.frequency) for p in found] == [(2.0, 1.0)] and found.complete


def ziegler() -> st.Family:
    """M = [[3, 1], [1, 1]], K = [[2 - P, P - 1], [-1, 1]], C = b [[2, -1], [-1, 1]]."""

    def rhs(x: Any, p: Any, b: Any) -> tuple[Any, ...]:
        f = -((2 - p) * x[0] + (p - 1) * x[1]) - b * (2 * x[2] - x[3])
        g = -(-x[0] + x[1]) - b * (-x[2] + x[3])
        return x[2], x[3], (f - g) / 2, (3 * g - f) / 2

    return linear("ziegler", rhs, ("P", "b"), "P")


def test_zieglers_column_flutters_at_its_two_published_loads() -> None:
    """Kirillov & Verhulst: P = 7/2 - √2 undamped, 41/28 + b²/2 damped, however small b is."""
    found = st.boundaries(ziegler(), axis=("P", 0.5, 3, 5), b=0.0)
    [point] = found
    assert abs(Fraction(point.value) - Fraction("2.08578643762690495119831127579030")) <= Fraction(
        point.error
    )
    assert found.complete and point.stable_below
    assert point.frequency == pytest.approx(2**-0.25, rel=1e-14)  # 2 λ⁴ + (7 - 2P) λ² + 1
    for b in (1e-9, 1e-3, 0.5, 1.25):
        [point] = st.boundaries(ziegler(), axis=("P", 0.5, 3, 5), b=b)
        truth = Fraction(41, 28) + Fraction(b) ** 2 / 2
        assert abs(Fraction(point.value) - truth) <= Fraction(point.error) < 1e-14
        assert point.frequency == pytest.approx((2 / 7) ** 0.5, rel=1e-13)  # 7 b λ² + 2 b = 0


def test_along_the_damping_zieglers_boundary_is_found_too() -> None:
    found = st.boundaries(ziegler(), axis=("b", -1, 3, 4), at=2.0)
    truth = float(np.sqrt(2 * (2 - 41 / 28)))
    # negative damping is unstable; at 0 neutral; small damping destabilises; then stable
    assert [p.value for p in found] == [pytest.approx(truth, rel=1e-14)]
    assert found.complete and not found[0].stable_below


def test_sympys_own_rolling_disc_is_neutral_above_its_published_speed() -> None:
    """sympy/physics/mechanics/tests/test_kane.py, rates as printed there; u2² = g/(3 r)."""
    x, p = ca.SX.sym("x", 6), ca.SX.sym("p", 2)
    _, q2, _, u1, u2, u3 = ca.vertsplit(x)
    r, g = ca.vertsplit(p)
    rhs = (
        u3 / ca.cos(q2),
        u1,
        u2 - u3 * ca.tan(q2),
        (6 * u2 * u3 * r - u3**2 * r * ca.tan(q2) + 4 * g * ca.sin(q2)) / (5 * r),
        -2 * u1 * u3 / 3,
        u1 * (-2 * u2 + u3 * ca.tan(q2)),
    )
    # without the angles that no rate depends on, else straight rolling is no rest point
    kept = [1, 3, 4, 5]
    names = ("q2", "u1", "u2", "u3")
    y = ca.SX.sym("y", 4)
    rates = ca.substitute(ca.vertcat(*[rhs[i] for i in kept]), ca.vertcat(*[x[i] for i in kept]), y)
    system = st.System("disc", y, p, rates, states=names, parameters=("r", "g"))
    straight = st.Family(system, "straight", at=("u2",), held={"q2": 0.0, "u1": 0.0, "u3": 0.0})
    for r_, g_ in ((1.0, 1.0), (0.3, 9.81)):
        found = st.boundaries(straight, axis=("u2", -9, 9, 3), r=r_, g=g_)
        speed = (g_ / (3 * r_)) ** 0.5
        assert [p.value for p in found] == pytest.approx([-speed, speed], rel=1e-15)
        assert [p.stable_below for p in found] == [True, False] and found.complete
        assert [p.crossing.word for p in found] == ["static", "static"]


@pytest.mark.parametrize("conservative", [True, False])
def test_a_centre_becomes_a_saddle_where_its_stiffness_vanishes(conservative: bool) -> None:
    centre = linear(
        "centre", lambda x, p: (x[1], -p * x[0]), ("p",), "p", states=2, conservative=conservative
    )
    for axis in (("p", -1.0, 1.0, 2), ("p", -1.0, 1.0, 3), ("p", 0.0, 1.0, 3), ("p", -1.0, 0.0, 3)):
        found = st.boundaries(centre, axis=axis)
        assert [(p.value, p.crossing.word, p.stable_below) for p in found] == [
            (0.0, "static", False)
        ]
        assert found.complete


def test_the_wheelset_hunts_at_its_published_speed() -> None:
    """J. K. Moore, EME 134, lab 1: 48.558435944090 m/s, 26.132674311418 rad/s, by two routes."""
    m, d, n, r, rail, d1, cone = 1000, 0.72, 20000, 0.23, 0.2, 0.36, np.pi / 180
    f, k, r0 = 1e6, 13000, 0.46
    i, conicity = m * d * d, r * cone / (r - rail)
    rhs = lambda x, v: (  # noqa: E731
        x[2],
        x[3],
        -(2 * k / m + 2 * n / (m * (r - rail))) * x[0] + 2 * f / m * x[1] - 2 * f / (v * m) * x[2],
        -2 * f * conicity * d / (r0 * i) * x[0]
        - 2 * k * d1**2 / i * x[1]
        - 2 * f * d * d / (v * i) * x[3],
    )
    family = linear("wheelset", rhs, ("V",), "V")
    [point] = found = st.boundaries(family, axis=("V", 1, 100, 3))
    assert found.complete and point.stable_below
    assert point.value == pytest.approx(48.558435944090, rel=1e-12)
    assert point.frequency == pytest.approx(26.132674311418, rel=1e-12)
    with pytest.warns(StabilityWarning, match="no value there"):  # 1/V has a pole at standstill
        through = st.boundaries(family, axis=("V", -10, 100, 3))
    assert list(through) == list(found) and (through.unresolved[0][:2]) == (0.0, 0.0)


def test_the_triangular_points_are_lost_at_rouths_mass() -> None:
    """L4, linear: x'' - 2 y' = 3/4 x + c y, y'' + 2 x' = c x + 9/4 y, c = 3√3/4 (1 - 2m).

    The double √3 moves the boundary by its rounding error, no more.
    """
    c = 3 * 3**0.5 / 4
    rhs = lambda x, m: (  # noqa: E731
        x[2],
        x[3],
        2 * x[3] + 0.75 * x[0] + c * (1 - 2 * m) * x[1],
        -2 * x[2] + c * (1 - 2 * m) * x[0] + 2.25 * x[1],
    )
    family = linear("l4", rhs, ("m",), "m", conservative=True)
    low, high = st.boundaries(family, axis=("m", 0.001, 0.999, 2))
    critical = (1 - 69**0.5 / 9) / 2
    assert low.value == pytest.approx(critical, rel=1e-13) and low.stable_below
    assert high.value == pytest.approx(1 - critical, rel=1e-13) and not high.stable_below
    assert low.frequency == pytest.approx(0.5**0.5, rel=1e-7)


def test_the_rotating_saddle_is_neutral_above_the_root_of_its_curvature() -> None:
    """X'' - 2 W y' = (W² - k) x, y'' + 2 W x' = (W² + k) y: stable for W² > k."""
    rhs = lambda x, w, k: (  # noqa: E731
        x[2],
        x[3],
        2 * w * x[3] + (w**2 - k) * x[0],
        -2 * w * x[2] + (w**2 + k) * x[1],
    )
    family = linear("saddle", rhs, ("W", "k"), "W", conservative=True)
    for k in (1.0, 2.0, 0.3):
        found = st.boundaries(family, axis=("W", -3, 3, 4), k=k)
        assert found.complete
        assert [p.value for p in found] == pytest.approx([-(k**0.5), k**0.5], rel=1e-15)
        assert [p.crossing.word for p in found] == ["static", "static"]


def test_an_isotropic_rotor_whose_pairs_cross_together() -> None:
    """Jeffcott: z'' + (de + di) z' + (1 - i W di) z = 0; the real form has each pair twice."""
    rhs = lambda x, w, de, di: (  # noqa: E731
        x[2],
        x[3],
        -(de + di) * x[2] - x[0] - w * di * x[1],
        -(de + di) * x[3] - x[1] + w * di * x[0],
    )
    rotor = linear("rotor", rhs, ("W", "de", "di"), "W")
    [point] = found = st.boundaries(rotor, axis=("W", 0.1, 9, 3), de=0.25, di=0.125)
    assert (point.value, point.stable_below) == (3.0, True) and found.complete
    assert point.frequency == pytest.approx(1, rel=1e-14)


def test_random_linear_systems_against_their_own_eigenvalues() -> None:
    """Rational in the axis, of every degree: no change beyond those found, by many eigenvalues."""
    rng = np.random.default_rng(11)
    seen = 0
    for _ in range(10):
        size = int(rng.integers(2, 6))
        parts = [rng.integers(-3, 4, (size, size)) for _ in range(3)]
        rhs = lambda x, p, a=parts: tuple(  # noqa: E731
            sum(
                (int(a[0][i, j]) + p * int(a[1][i, j]) + p**2 / 4 * int(a[2][i, j])) * x[j]
                for j in range(len(a[0]))
            )
            - 2 * x[i]
            for i in range(len(a[0]))
        )
        family = linear("random", rhs, ("p",), "p", states=size)
        found = st.boundaries(family, axis=("p", -2, 2, 2))
        assert found.complete
        grid = np.linspace(-2, 2, 801)
        matrices = [parts[0] + p * parts[1] + p * p / 4 * parts[2] - 2 * np.eye(size) for p in grid]
        abscissa = np.linalg.eigvals(np.array(matrices)).real.max(axis=1)
        clear = np.abs(abscissa) > 1e-3
        seen += len(found)
        for low, high, a, b in zip(grid, grid[1:], abscissa, abscissa[1:], strict=False):
            inside = [p for p in found if low < p.value <= high]
            if min(abs(a), abs(b)) > 1e-3:
                assert len(inside) % 2 == (a * b < 0), (parts, low, found)
        assert clear.mean() > 0.5
    assert seen > 5


# --- what a scan leaves open ---


def pendulum(**options: Any) -> st.Family:
    """X'' = -p sin x - c x', about an angle that is given: no rational graph."""
    x, p = ca.SX.sym("x", 2), ca.SX.sym("p", 3)
    system = st.System(
        "pendulum",
        x,
        p,
        ca.vertcat(x[1], -p[0] * ca.sin(x[0]) + p[2] - p[1] * x[1]),
        states=("angle", "rate"),
        parameters=("g", "c", "torque"),
    )
    return st.Family(
        system,
        "tilted",
        at=("torque",),
        held={"rate": 0.0},
        unknown={"angle": 0.2},
        equations=("rate",),
        typical={"torque": 0.3},
        **options,
    )


def softened() -> st.Family:
    """The same with the angle in an exponential too: not algebraic either."""
    x, p = ca.SX.sym("x", 2), ca.SX.sym("p", 3)
    force = p[0] * (ca.sin(x[0]) + ca.exp(x[0] / 8) - 1)
    system = st.System(
        "pendulum",
        x,
        p,
        ca.vertcat(x[1], -force + p[2] - p[1] * x[1]),
        states=("angle", "rate"),
        parameters=("g", "c", "torque"),
    )
    return st.Family(
        system,
        "tilted",
        at=("torque",),
        held={"rate": 0.0},
        unknown={"angle": 0.2},
        equations=("rate",),
        typical={"torque": 0.3},
    )


def test_an_undamped_family_that_is_scanned_is_decided_or_says_so() -> None:
    """The angle solves g sin x = torque: neutral up to torque = 1, where the two branches meet."""
    with pytest.warns(StabilityWarning, match="not complete"):
        found = st.boundaries(softened(), axis=("torque", 0.1, 0.9, 9), g=1.0, c=0.0)
    assert found == [] and [u.reason[:18] for u in found.unresolved] == ["between neighbours"]
    found = st.boundaries(pendulum(), axis=("torque", 0.1, 0.9, 9), g=1.0, c=0.0)
    assert found == [] and found.complete and found.touching == ()


@pytest.mark.long
def test_a_scan_that_proves_nothing_says_so() -> None:
    """Two equal pendulums, undamped, coupled by nothing: double pairs that balls cannot part."""
    x, p = ca.SX.sym("x", 4), ca.SX.sym("p")
    rhs = (x[1], p - ca.exp(x[0]) + 1 - x[0], x[3], p - ca.exp(x[2]) + 1 - x[2])
    system = st.System(
        "pair", x, p, ca.vertcat(*rhs), states=("a", "b", "c", "d"), parameters=("p",)
    )
    pair = st.Family(
        system,
        "steady",
        at=("p",),
        held={"b": 0.0, "d": 0.0},
        unknown={"a": 0.3, "c": 0.3},
        equations=("b", "d"),
    )
    with pytest.warns(StabilityWarning, match="not complete"):
        found = st.boundaries(pair, axis=("p", 0.1, 0.9, 9))
    assert found == [] and not found.complete
    [piece] = found.unresolved
    assert (piece.low, piece.high) == (0.1, 0.9)
    assert "no verdict is proved at any of the 9 points" in piece.reason


@pytest.mark.long
def test_a_member_that_is_missing_within_a_scan_is_stated() -> None:
    """Y (p - y) = 0, y measured from -1: the branches cross at p = 0, with no isolated root."""
    x, p = ca.SX.sym("x", 2), ca.SX.sym("p")
    y = x[0] - 1
    system = st.System(
        "fork", x, p, ca.vertcat(y * (p - y), -x[1]), states=("y", "z"), parameters=("p",)
    )
    fork = st.Family(
        system, "steady", at=("p",), held={"z": 0.0}, unknown={"y": 1.3}, equations=("y",)
    )
    with pytest.warns(StabilityWarning):
        found = st.boundaries(fork, axis=("p", -2, 2, 9))
    said = "two of them meet, or the enclosures"
    assert any(u.low <= 0 <= u.high and said in u.reason for u in found.unresolved)
    for point in found:
        sides = [
            st.spectrum(fork, at=point.value + s * point.error, certify=True).verdict
            for s in (-1, 1)
        ]
        assert sides[0] != sides[1]


def test_a_scan_states_that_pairs_are_not_excluded_and_warns_once() -> None:
    family = softened()  # undamped: pieces prove nothing where eigenvalues stay on the axis
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        found = st.boundaries(family, axis=("g", 0.6, 1, 9), at=0.5, c=0.0)
    assert [w.category for w in caught] == [st.StabilityWarning]
    assert "\n" not in str(caught[0].message) and len(str(caught[0].message)) < 300
    assert not found.complete and "a pair of changes" in found.unresolved[-1].reason
    assert all(math.isfinite(u.low) and u.low <= u.high for u in found.unresolved)


@pytest.mark.parametrize("low", [-0.31, 0.0])
def test_the_damping_of_a_tilted_pendulum_decides_also_at_an_end(low: float) -> None:
    found = st.boundaries(pendulum(), axis=("c", low, 1, 9), at=0.5, g=1.0)
    [point] = found
    assert found.complete and abs(point.value) <= point.error <= 1e-9


def test_the_command_line_prints_the_warning_in_one_line(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    from stability.cli import commands as cli

    def run(_: Any) -> None:
        st.boundaries(softened(), axis=("g", 0.6, 1, 9), at=0.5, c=0.0)

    monkeypatch.setattr(cli.table, "run", run)
    assert cli.main(["table", "families"]) == 0
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 1 and lines[0].startswith("stability: note: the search along g is not")
