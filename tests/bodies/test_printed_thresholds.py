"""Certified verdicts on both sides of what `stability table bodies` prints, at 1e-12 of it.

Closed thresholds of theorems: tests/bodies/test_threshold_sides.py.  Here are numbers without a
closed form: they are computed to 30 digits from the surface of the body (`convex_body`).
"""

from __future__ import annotations

import re
from collections.abc import Callable
from fractions import Fraction
from functools import partial
from pathlib import Path
from typing import Any

import body_profiles as surfaces
import casadi as ca
import convex_body as oracle
import numpy as np
import pytest
from flint import arb
from jets import Array
from mpmath import mp
from proofs.catalogue import BODIES
from proofs.rim import INCLINED, shifts
from proofs.rounded_rim import EXAMPLES, tumbling
from sides import HALF, fraction, root, words

import stability as st
from stability.algebra.number_types import balls, precision
from stability.bodies.painleve import painleve_limit
from stability.bodies.round_body.equations import round_system
from stability.tables.painleve import bodies

Number = Any
"""A number of mpmath."""


def _mp(value: Fraction) -> Number:
    return mp.mpf(value.numerator) / value.denominator


# --- Painlevé's limit ---


def _series(body: st.Body) -> Callable[[Number], Number]:
    """The cosine series of an egg, from its values at equal angles."""
    count = 256
    values = body.height_at(np.pi * np.arange(count + 1) / count)
    terms = np.fft.rfft(np.concatenate([values, values[-2:0:-1]])).real / count
    terms[[0, -1]] /= 2
    kept = [(n, mp.mpf(a)) for n, a in enumerate(terms) if abs(a) > 1e-16]
    return lambda t: mp.fsum(a * mp.cos(n * t) for n, a in kept)


HEIGHTS: dict[str, Callable[[st.Body], Callable[[Number], Number]]] = {
    "disk": lambda _: mp.sin,
    "thick disk": lambda b: lambda t: mp.sin(t) + mp.mpf(b.shape["thickness"]) / 2 * mp.cos(t),
    "torus": lambda b: lambda t: mp.sin(t) + mp.mpf(b.shape["tube"]),
    "hollow torus": lambda b: lambda t: mp.sin(t) + mp.mpf(b.shape["tube"]),
    "spheroid": lambda b: lambda t: mp.hypot(mp.sin(t), mp.mpf(b.shape["aspect"]) * mp.cos(t)),
    "eccentric sphere": lambda b: lambda t: 1 - mp.mpf(b.shape["offset"]) * mp.cos(t),
    "egg": _series,
}
PRINTED = {name: body for name, body, _ in bodies()}


@pytest.mark.few(3)
@pytest.mark.parametrize("name", PRINTED)
def test_the_determinant_changes_sign_at_painleves_limit(name: str) -> None:
    """D of the graph in balls, on both sides of the least value of (I1 + h′²)/(h |h′|)."""
    body = PRINTED[name]
    moment, limit = body.moments()[1], painleve_limit(body)
    with mp.workdps(50):
        height = HEIGHTS[body.name](body)

        def ratio(t: Number) -> Number:
            slope = mp.diff(height, t)
            return (mp.mpf(moment) + slope**2) / (height(t) * abs(slope))

        theta = mp.findroot(lambda t: mp.diff(ratio, t), mp.mpf(limit.theta))
        least, sign = ratio(theta), mp.sign(mp.diff(height, theta))
        low, high = (mp.mpf(v) for v in body.between)
        scan = [low + (high - low) * (i + 0.5) / 400 for i in range(400)]
        assert all(ratio(t) > least for t in scan if abs(t - theta) > 1e-2)
        ends = [least * (1 + side * mp.mpf(10) ** -12) for side in (-1, 1)]
    with precision(400):
        below, above, place, side = (arb(mp.nstr(v, 45)) for v in (*ends, theta, sign))
        assert below < arb(limit.low) and arb(limit.high) < above  # so D > 0 everywhere, or not
        system = round_system(body, st.Viscous, ("mu",), physical=False)
        table = {n: arb(float(v)) for n, v in body.given.items()} | {"mu": arb(1)}
        p = [table[n] for n in system.parameters]
        for slip, positive in ((below, True), (above, False)):
            state = {"theta": place, "slip_x": slip * side}
            x = [state.get(n, arb(0)) for n in system.states]
            [[determinant]] = system.condition_program.run(balls(), [x, p])[-1:]
            assert (determinant > 0) is positive and (determinant < 0) is not positive


# --- numbers from the surface ---


def _coefficients(matrix: Any) -> list[Number]:
    """Coefficients of det(λ - J) from the highest, by the method of Faddeev and LeVerrier."""
    n, out, power = matrix.rows, [mp.mpf(1)], mp.eye(matrix.rows)
    for k in range(1, n + 1):
        power = matrix * power
        out.append(-sum(power[i, i] for i in range(n)) / k)
        power += out[-1] * mp.eye(n)
    return out


def _hurwitz(a: list[Number]) -> Number:
    """Determinant of order n - 1 of a polynomial of degree n: zero at a purely imaginary pair."""
    n = len(a) - 1

    def entry(i: int, j: int) -> Number:
        k = 2 * (j + 1) - (i + 1)
        return a[k] if 0 <= k <= n else mp.mpf(0)

    return mp.det(mp.matrix([[entry(i, j) for j in range(n - 1)] for i in range(n - 1)]))


def _matrix(body: oracle.ConvexBody, law: oracle.Law, state: list[Number], count: int) -> Any:
    values = np.array([mp.mpf(v) for v in state], dtype=object)
    slopes: Array = oracle.jacobian(lambda x: oracle.rates(body, law, x), values, 120)
    return mp.matrix(slopes[:count, :count].tolist())


def _flutter(body: oracle.ConvexBody, mu: Number, state: list[Number]) -> Number:
    """The flutter condition of a viscous member with one structural zero, over its size."""
    a = _coefficients(_matrix(body, oracle.Law("viscous", mu), state, 6))
    assert abs(a[-1]) < mp.mpf(10) ** -25
    return _hurwitz(a[:-1])


def _by_square(body: oracle.ConvexBody, state: list[Number], square: Number) -> Number:
    return _flutter(body, mp.sqrt(square), state)


def _secant(function: Callable[[Number], Number], near: Number, step: float) -> Number:
    """A root to 40 digits."""
    return mp.findroot(function, (mp.mpf(near), mp.mpf(near) + mp.mpf(step)), tol=1e-40)


@pytest.mark.long
@pytest.mark.parametrize("rounded", INCLINED)
def test_tumbling_of_a_coin_turns_at_the_printed_mu(rounded: str) -> None:
    """At ε = 0; the printed digits are those of the surface, and mu² is certified on both sides."""
    text = "\n".join(tumbling(rounded).statement)
    printed = re.findall(r"k = ([\d.]+), θ = ([\d.]+): mu² = ([\d.]+) ", text)
    assert [(Fraction(k), Fraction(t)) for k, t, _ in printed] == list(EXAMPLES)
    for k, theta, number in printed:
        with mp.workdps(60):
            inertia, at = _mp(Fraction(k)), _mp(Fraction(theta))
            coin = surfaces.thin_disk(inertia, mp.mpf(1), mp.mpf(1), mp.mpf(1))
            turn = 1 / mp.sqrt(inertia * mp.sin(at))  # φ̇² k sinθ = 1, ω₃ = 0
            condition = partial(_by_square, coin, [at, 0, turn, 0, 0, 0])
            square = _secant(condition, mp.mpf(number), 1e-8)
            assert mp.nstr(square, 14) == mp.nstr(mp.mpf(number), 14)
        thin = st.Body(lambda t: ca.sin(t), axial=0.5, transverse=0.25, name="thin")
        numbers = {"axial": 2 * Fraction(k), "transverse": Fraction(k), "at": Fraction(theta)}
        found = words(thin.family("tumbling", "viscous"), root(fraction(square)), numbers, "mu")
        assert found == ["stable", "unstable"], (k, theta)


@pytest.mark.long
@pytest.mark.parametrize(
    ("aspect", "mu", "near"),
    [
        (Fraction(13, 10), Fraction(1), 2.0),
        (Fraction(17, 10), Fraction(1), 1.93),
        (Fraction(5, 2), Fraction(3), 1.25),
    ],
)
def test_a_lying_spheroid_flutters_below_five_from_the_value_of_its_surface(
    aspect: Fraction, mu: Fraction, near: float
) -> None:
    """Where mu is large, flutter comes before the printed 5 g/R."""
    with mp.workdps(60):
        a = _mp(aspect)
        body = surfaces.spheroid(mp.mpf(1), a, mp.mpf(2) / 5, (1 + a**2) / 5, mp.mpf(1), mp.mpf(1))
        rate = _secant(lambda q: _flutter(body, _mp(mu), [mp.pi / 2, 0, q, 0, 0, 0]), near, 1e-3)
        assert rate**2 < 5
    own = st.Spheroid(float(aspect))
    [edge] = st.boundaries(
        "spinning", axis=("at", 0.05, 2.2, 40), body=own, contact=st.Viscous(float(mu))
    )
    assert edge.value == pytest.approx(float(rate), rel=1e-13)
    numbers = {"aspect": aspect, "mu": mu}
    found = words(own.family("spinning", "viscous"), fraction(rate), numbers)
    assert found == ["stable", "unstable"]


CIRCLES = [
    ("torus", st.Torus(0.2), {"tube": Fraction(1, 5)}, Fraction(7, 5), (0.1617, 0.6833)),
    (
        "thick disk",
        st.ThickDisk(0.3),
        {"thickness": Fraction(3, 10)},
        Fraction(6, 5),
        (0.3007, 0.7867),
    ),
    ("spheroid", st.Spheroid(0.5), {"aspect": HALF}, Fraction(19, 10), (0.4864, 0.5104)),
]


def _circling_surface(name: str, number: Number) -> oracle.ConvexBody:
    one = mp.mpf(1)
    if name == "torus":
        return surfaces.torus(one, number, 1 + 3 * number**2 / 4, one / 2 + 5 * number**2 / 8)
    if name == "thick disk":
        return surfaces.thick_disk(one, number / 2, one / 2, (3 + number**2) / 12)
    return surfaces.spheroid(one, number, 2 * one / 5, (1 + number**2) / 5)


@pytest.mark.long
@pytest.mark.parametrize(
    ("name", "body", "numbers", "theta", "edges"), CIRCLES, ids=[c[0] for c in CIRCLES]
)
def test_circling_turns_where_its_square_of_frequency_vanishes(
    name: str,
    body: st.Body,
    numbers: dict[str, Fraction],
    theta: Fraction,
    edges: tuple[float, float],
) -> None:
    """λ² of a member without slip is minus the sum of the principal minors of order 2."""
    family = body.family("circling", "rough")
    sides = (["neutral", "unstable"], ["unstable", "neutral"])
    for near, expected in zip(edges, sides, strict=True):
        with mp.workdps(60):
            surface = _circling_surface(name, _mp(*numbers.values()))
            rate = _secant(partial(_square, surface, _mp(theta)), mp.mpf(near), 1e-4)
        assert float(rate) == pytest.approx(near, abs=1e-3)
        assert words(family, fraction(rate), numbers, at=(theta,)) == expected


def _square(body: oracle.ConvexBody, theta: Number, turn: Number) -> Number:
    """The sum of the principal minors of order 2 at the member of an inclination and a rate."""
    rough = oracle.Law("rough")

    def left(spin: Number) -> Number:
        x = np.array([theta, mp.mpf(0), turn, spin, mp.mpf(0), mp.mpf(0)], dtype=object)
        return oracle.rates(body, rough, x)[1]

    spin = mp.findroot(left, (mp.mpf(0), mp.mpf(1)), tol=1e-50)
    a = _coefficients(_matrix(body, rough, [theta, 0, turn, spin, 0, 0], 4))
    assert max(abs(v) for v in a[3:]) < mp.mpf(10) ** -25
    return a[2]


@pytest.mark.parametrize("aspect", [Fraction(3, 2), HALF])
def test_spheroids_on_their_ends_turn_at_the_printed_number(aspect: Fraction) -> None:
    """n² = 5 a³ for every mu."""
    family = st.Spheroid(float(aspect)).family("vertical", "viscous", pole=0)
    expected = ["unstable", "stable"] if aspect > 1 else ["stable", "unstable"]
    for mu in (Fraction(1, 10), Fraction(4)):
        numbers = {"aspect": aspect, "mu": mu}
        assert words(family, root(5 * aspect**3), numbers) == expected


# --- every printed threshold has its test ---

CERTIFIED = {
    "rolling-conservative": "test_upright_rolling_and_spinning_turn_at_the_printed_thresholds",
    "rolling-viscous": "test_rolling_of_a_long_body_turns_the_other_way",
    "spinning-conservative": "test_upright_rolling_and_spinning_turn_at_the_printed_thresholds",
    "spinning-viscous": "test_spinning_with_friction_turns_at_its_three_limits",
    "spinning-low": "test_a_lying_spheroid_turns_at_five",
    "vertical-conservative": "test_vertical_spin_turns_at_the_printed_thresholds",
    "vertical-viscous": "test_vertical_spin_turns_at_the_printed_thresholds",
    "tumbling-static": "test_tumbling_turns_where_its_energy_is_stationary",
    "surfaces": "test_precession_is_unstable_between_its_printed_thresholds",
    "painleve": "test_the_determinant_changes_sign_at_painleves_limit",
}
WITHOUT = {"steady-motions", "steady-at-poles", "rough-smooth", "branches", "energy"}
"""Theorems that state no number at which a verdict turns, or say so by one of the others."""


def test_every_statement_with_a_threshold_is_certified() -> None:
    assert CERTIFIED.keys() | WITHOUT == BODIES.keys()
    assert {body.name for body in PRINTED.values()} == HEIGHTS.keys()
    here = Path(__file__)
    files = (here, here.with_name("test_threshold_sides.py"))
    sources = [file.read_text(encoding="utf-8") for file in files]
    for test in CERTIFIED.values():
        assert any(f"def {test}(" in text for text in sources), test
    upright = {(s.family, s.law) for s in shifts()}
    laws = ("rough", "smooth", "viscous")
    assert upright == {(family, law) for family in ("rolling", "spinning") for law in laws}
