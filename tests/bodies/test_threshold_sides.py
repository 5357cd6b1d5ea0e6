"""Certified verdicts on both sides of every threshold of bodies, at 1e-12 of it, exactly.

Thresholds are written once more from height and moments, over the rationals.  A root is taken to 60
digits, and values next to it are fractions: verdicts are about these numbers and no doubles.
"""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from typing import Any

import casadi as ca
import pytest
import sympy
from mpmath import mp
from proofs import spinning
from sides import HALF, ONE, STEP, root, words

import stability as st


def rounded(name: str) -> st.Body:
    """Height ρ + (1-ρ) sin θ, with all numbers free: h(π/2) = 1, ρ the radius of curvature."""
    return st.Body(
        lambda theta, rho: rho + (1 - rho) * ca.sin(theta),
        axial=0.5,
        transverse=0.4,
        shape={"rho": 0.25},
        name=name,
    )


# body, its numbers, then h, h′′, I1 and I3 upright
Upright = tuple[st.Body, dict[str, Fraction], Fraction, Fraction, Fraction, Fraction]


def torus(b: Fraction) -> Upright:
    return (
        st.Torus(float(b)),
        {"tube": b},
        1 + b,
        Fraction(-1),
        HALF + Fraction(5, 8) * b**2,
        1 + Fraction(3, 4) * b**2,
    )


def spheroid(a: Fraction) -> Upright:
    return (
        st.Spheroid(float(a)),
        {"aspect": a},
        Fraction(1),
        a**2 - 1,
        (1 + a**2) / 5,
        Fraction(2, 5),
    )


def coin(rho: Fraction, across: Fraction, along: Fraction) -> Upright:
    numbers = {"rho": rho, "transverse": across, "axial": along}
    return rounded("coin"), numbers, Fraction(1), rho - 1, across, along


BODIES = [
    torus(Fraction(1, 5)),
    torus(Fraction(1, 3)),
    spheroid(Fraction(1, 2)),
    coin(Fraction(1, 7), Fraction(2, 5), HALF),
    coin(Fraction(0), Fraction(1, 4), HALF),
    coin(Fraction(0), HALF, Fraction(1)),
]
MU = (Fraction(3, 10), Fraction(3))


@pytest.mark.few(2)
@pytest.mark.parametrize("case", BODIES, ids=lambda c: c[0].name)
def test_upright_rolling_and_spinning_turn_at_the_printed_thresholds(case: Upright) -> None:
    body, numbers, h, bend, i1, i3 = case
    known = {
        ("rolling", "rough"): -i1 * bend / (i3 * (i3 + h**2)),
        ("rolling", "smooth"): -i1 * bend / i3**2,
        ("spinning", "rough"): -bend / (i1 + h**2),
        ("spinning", "smooth"): -bend / i1,
    }
    for (name, law), square in known.items():
        family = body.family(name, law)
        assert words(family, root(square), numbers) == ["unstable", "neutral"], (name, law)
    square = -i1 * bend / (i3 * (i3 - i1))
    for mu in MU:
        family = body.family("rolling", "viscous")
        assert words(family, root(square), numbers | {"mu": mu}) == ["unstable", "stable"]


def test_rolling_of_a_long_body_turns_the_other_way() -> None:
    body, numbers, _, bend, i1, i3 = spheroid(Fraction(8, 5))
    square = i1 * bend / (i3 * (i1 - i3))
    for mu in MU:
        family = body.family("rolling", "viscous")
        assert words(family, root(square), numbers | {"mu": mu}) == ["stable", "unstable"]


def limits(rho: Fraction, i1: Fraction, i3: Fraction) -> tuple[Fraction, Fraction, Fraction]:
    """q1, M1 and M2 of spinning, with h = 1."""
    q1 = (1 - rho) / (i1 - i3 * rho)
    m1 = 2 * i3 * (1 + rho) / ((1 + i3) * (2 * i1 + 1 + rho))
    m2 = 2 * (1 - rho) * i3**2 * (i1 + i3) / ((1 + i3) * (i3 - i1) * (i1 + i3 + 2 * i1 * i3))
    return q1, m1, m2


@pytest.mark.parametrize(
    ("rho", "i1", "i3"),
    [
        (Fraction(0), Fraction(1, 4), HALF),
        (Fraction(1, 7), Fraction(2, 5), HALF),
        (Fraction(1, 3), Fraction(3, 10), Fraction(2, 5)),
    ],
)
def test_spinning_with_friction_turns_at_its_three_limits(
    rho: Fraction, i1: Fraction, i3: Fraction
) -> None:
    """q1 at a friction with and without a second limit; M1 far out, M2 next to q1, at all q."""
    body, numbers, *_ = coin(rho, i1, i3)
    family = body.family("spinning", "viscous")
    q1, m1, m2 = limits(rho, i1, i3)
    for m in (m1 / 2, m1, (m1 + m2) / 2):
        assert words(family, root(q1), numbers | {"mu": root(m)}) == ["unstable", "stable"]
    fast = numbers | {"at": Fraction(10**12)}  # the second value of q lies near 1e12 a1/|a2| there
    assert words(family, root(m1), fast, "mu") == ["stable", "unstable"]
    near = numbers | {"at": root(q1 * (1 + STEP**2))}
    assert words(family, root(m2), near, "mu") == ["stable", "unstable"]
    for q in (q1 * (1 + STEP**2), 2 * q1, 50 * q1):  # no value of q is stable at M2
        one = st.spectrum(family, at=root(q), mu=root(m2) * (1 + STEP), certify=True, **numbers)
        assert one.verdict.word == "unstable"


@pytest.mark.few(3)
@pytest.mark.parametrize("aspect", [Fraction(6, 5), Fraction(2), Fraction(5, 6), HALF])
def test_a_lying_spheroid_turns_at_five(aspect: Fraction) -> None:
    body, numbers, *_ = spheroid(aspect)
    family = body.family("spinning", "viscous")
    expected = ["stable", "unstable"] if aspect > 1 else ["unstable", "stable"]
    assert words(family, root(Fraction(5)), numbers | {"mu": Fraction(1, 20)}) == expected


@pytest.mark.parametrize(
    ("offset", "across"), [(Fraction(1, 10), Fraction(2, 5)), (Fraction(1, 5), Fraction(21, 50))]
)
def test_a_tippe_top_turns_at_its_published_thresholds(offset: Fraction, across: Fraction) -> None:
    """Ebenfeld & Scheck (1995): as in tests/bodies/test_pole_equations.py."""
    c = Fraction(2, 5)
    top = st.EccentricSphere(0.1, axial=0.4, transverse=0.4)
    numbers = {"offset": offset, "axial": c, "transverse": across}
    upright = offset * (1 - offset) ** 2 / (across - c * (1 - offset))
    inverted = offset * (1 + offset) ** 2 / (c * (1 + offset) - across)
    for mu in MU:
        for pole, square, expected in (
            (0, upright, ["stable", "unstable"]),
            ("pi", inverted, ["unstable", "stable"]),
        ):
            family = top.family("vertical", "viscous", pole=pole)
            assert words(family, root(square), numbers | {"mu": mu}) == expected


@pytest.mark.few(1)
@pytest.mark.parametrize("pole", [0, "pi"])
@pytest.mark.parametrize(
    ("h", "rho", "i1", "i3"),
    [
        (Fraction(4, 5), Fraction(1), HALF, HALF),
        (Fraction(6, 5), Fraction(9, 10), Fraction(2, 5), HALF),
        (Fraction(3, 2), Fraction(1), Fraction(7, 10), HALF),
    ],
)
def test_vertical_spin_turns_at_the_printed_thresholds(
    h: Fraction, rho: Fraction, i1: Fraction, i3: Fraction, pole: int | str
) -> None:
    """A ball of radius ρ whose centre of mass is at h over this end, every number free."""
    side = 1 if pole == 0 else -1
    body = st.Body(
        lambda t, tall, rho: rho + side * (tall - rho) * ca.cos(t),
        axial=0.5,
        transverse=0.4,
        shape={"tall": 1.2, "rho": 1.0},
        name="ball",
    )
    numbers = {"tall": h, "rho": rho, "transverse": i1, "axial": i3}
    bend, lever = rho - h, i3 * h - i1 * rho
    expected = ["stable", "unstable"] if bend > 0 else ["unstable", "stable"]
    family = body.family("vertical", "viscous", pole=pole)
    edge = root(-(h**2) * bend / (rho * lever))
    for mu in (Fraction(1, 100), *MU, Fraction(50)):
        assert words(family, edge, numbers | {"mu": mu}) == expected
    if bend < 0:
        known = {"rough": (i1 + h**2) / (i3 + h * rho) ** 2, "smooth": i1 / i3**2}
        for law, share in known.items():
            family = body.family("vertical", law, pole=pole)
            assert words(family, root(-4 * bend * share), numbers) == ["unstable", "neutral"], law


@pytest.mark.parametrize(
    ("theta", "b"), [(Fraction(7, 5), Fraction(1, 5)), (Fraction(13, 10), HALF)]
)
def test_precession_is_unstable_between_its_printed_thresholds(
    theta: Fraction, b: Fraction
) -> None:
    """A torus: I1² X² + I1 (h′′ + h′ cot θ) X + (h′/sin θ)² < 0 with X = φ̇², to 60 digits."""
    body, numbers, _, _, i1, _ = torus(b)
    with mp.workdps(80):
        at, across = (mp.mpf(v.numerator) / v.denominator for v in (theta, i1))
        s, c = mp.sin(at), mp.cos(at)
        middle, last = across * (-s + c * c / s), (c / s) ** 2
        spread = mp.sqrt(middle**2 - 4 * across**2 * last)
        edges = [mp.sqrt((-middle + sign * spread) / (2 * across**2)) for sign in (-1, 1)]
        low, high = (Fraction(int(mp.nint(e * ONE)), ONE) for e in edges)
    family = body.family("precession", "smooth")
    for edge, expected in ((low, ["neutral", "unstable"]), (high, ["unstable", "neutral"])):
        found = [
            st.spectrum(family, certify=True, at=[theta, edge * side], **numbers).verdict.word
            for side in (1 - STEP, 1 + STEP)
        ]
        assert found == expected


@pytest.mark.parametrize("k", [Fraction(1, 4), HALF])
def test_coin_and_hoop_roll_above_their_published_speeds(k: Fraction) -> None:
    """Rolling without slip: v² = g R/3 of a coin and g R/4 of a hoop; spinning: 1/(1 + k)."""
    thin = st.Body(lambda theta: ca.sin(theta), axial=0.5, transverse=0.25, name="thin")
    numbers = {"axial": 2 * k, "transverse": k}
    square = {Fraction(1, 4): Fraction(1, 3), HALF: Fraction(1, 4)}[k]
    known = {"rolling": square, "spinning": 1 / (1 + k)}
    for name, value in known.items():
        family = thin.family(name, "rough")
        assert words(family, root(value), numbers) == ["unstable", "neutral"]


SCALES = ("mass", "gravity", "length")
EGG = st.Egg(0.2)
HOLLOW = st.Torus(0.1, solid=False)
THIN = st.Body(lambda theta: ca.sin(theta), axial=0.5, transverse=0.25, name="thin disk")
NAMED: list[tuple[str, Any, st.Body, dict[str, Any]]] = (
    [
        (name, law, body, {})
        for body in (st.Torus(0.2), st.Spheroid(0.6), st.ThickDisk(0.1), HOLLOW, THIN)
        for name in ("rolling", "spinning")
        for law in ("viscous", "rough", "smooth")
        if not (name == "spinning" and body.name == "thick disk")
    ]
    + [
        ("rolling", "viscous", EGG, {}),
        ("tumbling", "viscous", st.Torus(0.2), {"axis": (0.05, 1.55)}),
        ("tumbling", "viscous", st.Spheroid(0.6), {"axis": (1.6, 3.0)}),
        ("tumbling", "viscous", EGG, {"axis": (1.0, 1.7)}),
        ("precession", "smooth", st.ThickDisk(0.1), {"axis": (0.3, 1.3), "held": ("phi_dot", 1.7)}),
        ("vertical", "viscous", st.Spheroid(0.6), {}),
        ("vertical", "viscous", st.EccentricSphere(0.2), {}),
        ("tumbling", "viscous", THIN, {"axis": (0.05, 1.55), "mu": 2}),
        ("tumbling", "viscous", st.Torus(0.2, solid=False), {"axis": (0.05, 1.55)}),
        ("spinning", "viscous", st.Spheroid(1.7), {"axis": (0.05, 4.0)}),
        ("spinning", "viscous", st.Spheroid(1.7), {"axis": (0.05, 4.0), "mu": 3}),
        ("circling", "rough", st.Torus(0.2), {"axis": (0.05, 6.0), "held": ("theta", 1.4)}),
        ("circling", "rough", st.ThickDisk(0.3), {"axis": (0.05, 6.0), "held": ("theta", 1.2)}),
        ("circling", "rough", st.Spheroid(0.5), {"axis": (0.05, 6.0), "held": ("theta", 1.9)}),
        ("circling", "rough", EGG, {"axis": (0.05, 6.0), "held": ("theta", 0.5)}),
    ]
    + [
        ("vertical", law, body, {"pole": pole})
        for law in ("rough", "smooth")
        for body, pole in ((st.Spheroid(1.7), 0), (st.EccentricSphere(0.2), "pi"), (EGG, "pi"))
    ]
)


QUICK = {
    ("rolling", "viscous", "torus"),
    ("spinning", "smooth", "spheroid"),
    ("vertical", "viscous", "eccentric sphere"),
    ("circling", "rough", "torus"),
    ("precession", "smooth", "thick disk"),
    ("tumbling", "viscous", "thin disk"),
}
"""One case of each family stays in the fast tests."""


@pytest.mark.parametrize(
    ("name", "law", "body", "more"),
    [
        pytest.param(*case, marks=() if (*case[:2], case[2].name) in QUICK else pytest.mark.long)
        for case in NAMED
    ],
    ids=lambda v: getattr(v, "name", str(v)),
)
def test_boundaries_of_named_bodies_have_two_sides(
    name: str, law: str, body: st.Body, more: dict[str, Any]
) -> None:
    """Every threshold that `boundaries` returns, over its range, with the verdicts that it says."""
    low, high = more.get("axis", (0.05, 6.0))
    numbers = {n: Fraction(v) for n, v in body.given.items() if n not in SCALES}
    if law == "viscous":
        numbers["mu"] = Fraction(more.get("mu", Fraction(3, 10)))
    family = body.family(name, law, pole=more.get("pole"))
    [axis] = [n for n in family.at if n != more.get("held", ("",))[0]]
    held = {more["held"][0]: Fraction(more["held"][1])} if "held" in more else {}
    given = {n: float(v) for n, v in (numbers | held).items()}
    found = st.boundaries(family, axis=(axis, low, high, 50), **given)
    assert found.complete and found
    for point in found:
        value = Fraction(point.value)
        seen = []
        for side in (1 - STEP, 1 + STEP):
            place = {axis: value * side} | held
            at = [place[n] for n in family.at]
            one = st.spectrum(family, at=at if len(at) > 1 else at[0], certify=True, **numbers)
            seen.append(one.verdict.word)
        good = "stable" if law == "viscous" else "neutral"
        assert seen == ([good, "unstable"] if point.stable_below else ["unstable", good])


def thick(t: Fraction) -> tuple[st.Body, dict[str, Fraction], Fraction, Fraction]:
    """A thick disk, its number, I1 and I3; it leans with h² = 1 + t²/4, h′′ = -h, tan θ = 2/t."""
    return st.ThickDisk(float(t)), {"thickness": t}, (3 + t**2) / 12, HALF


@pytest.mark.parametrize("t", [Fraction(1, 5), HALF, Fraction(3, 2)])
def test_leaning_rolling_turns_at_its_printed_thresholds(t: Fraction) -> None:
    body, numbers, i1, i3 = thick(t)
    h2 = 1 + t**2 / 4
    sine2, cosine2 = 1 / h2, t**2 / 4 / h2
    q = i1 * i3 + h2 * (i1 * sine2 + i3 * cosine2)
    over_h = {"rough": q / (i3 * (i3 + h2) * (i3 + h2 - h2 * cosine2)), "smooth": i1 / i3**2}
    for law, share in over_h.items():
        family = body.family("rolling", law)
        square = root(h2 * share**2)  # -h′′ = h is a root itself
        assert words(family, root(square), numbers) == ["unstable", "neutral"], law


@pytest.mark.long  # the flutter polynomial takes two seconds; its two limits are above
@pytest.mark.parametrize("share", [Fraction(1, 4), HALF, Fraction(9, 10)])
@pytest.mark.parametrize("rho", [Fraction(0), Fraction(1, 7)])
def test_fast_spinning_flutters_from_its_second_limit(rho: Fraction, share: Fraction) -> None:
    """M1 < M < M2: stable exactly for q1 < q < q1 + v1, v1 the positive root as printed."""
    i1, i3 = Fraction(2, 5), HALF
    body, numbers, *_ = coin(rho, i1, i3)
    q1, m1, m2 = limits(rho, i1, i3)
    mu = root(m1 + share * (m2 - m1))
    values = {"ρ": rho, "I1": i1, "I3": i3, "M": mu**2}
    a2, a1, a0 = (exactly(c, values) for c in spinning.flutter())
    assert a2 < 0 < a0
    v1 = (-a1 - root(a1**2 - 4 * a2 * a0)) / (2 * a2)
    family = body.family("spinning", "viscous")
    assert words(family, root(q1 + v1), numbers | {"mu": mu}) == ["stable", "unstable"]


def exactly(expression: Any, values: Mapping[str, Fraction]) -> Fraction:
    """A rational expression in symbols at fractions."""
    given = {
        s: sympy.Rational(values[s.name].numerator, values[s.name].denominator)
        for s in expression.free_symbols
    }
    found = sympy.Rational(expression.subs(given))
    return Fraction(int(found.p), int(found.q))


@pytest.mark.few(1)
@pytest.mark.parametrize("t", [Fraction(1), Fraction(9, 10)])
def test_tumbling_turns_where_its_energy_is_stationary(t: Fraction) -> None:
    """The static boundary of a thick disk: E is computed from the height alone, to 60 digits."""
    body, numbers, i1, i3 = thick(t)

    def energy(theta: Any) -> Any:
        s, c, half = mp.sin(theta), mp.cos(theta), mp.mpf(t.numerator) / (2 * t.denominator)
        h, slope = s + half * c, c - half * s
        r, z = h * s + slope * c, h * c - slope * s
        across, along = (mp.mpf(i.numerator) / i.denominator for i in (i1, i3))
        square = slope * r / (s * (across * r * c - along * z * s))
        return h + square * (across * s**2 + along * (s * z / r) ** 2) / 2

    with mp.workdps(80):
        found = mp.findroot(lambda x: mp.diff(energy, x), mp.mpf("1.49"))
        theta = Fraction(int(mp.nint(found * ONE)), ONE)
        rises = [mp.diff(energy, found * (1 + side * mp.mpf(10) ** -6)) > 0 for side in (-1, 1)]
        falls = mp.cos(found) < mp.mpf(t.numerator) / (2 * t.denominator) * mp.sin(found)  # h′ < 0
    family = body.family("tumbling", "viscous")
    seen = words(family, theta, numbers | {"mu": Fraction(2, 5)})
    unstable = [rise == falls for rise in rises]  # h′ dE/dθ < 0
    assert sorted(unstable) == [False, True]
    assert [word == "unstable" for word in seen] == unstable, seen
