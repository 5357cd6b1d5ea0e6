"""Statements about vertical spin, against exact linearisations of another formulation.

`tests/oracles/ellipsoid_on_end.py` takes the contact point from the quadric of the surface, over
the rationals; verdicts are certified spectra of single bodies.
"""

from __future__ import annotations

import math
from fractions import Fraction
from itertools import pairwise
from typing import Any

import casadi as ca
import numpy as np
import pytest
import sympy as sp
from body_heights import numbers_at
from body_profiles import eccentric_sphere
from convex_body import Law, axis_rates
from ellipsoid_on_end import Ellipsoid, jacobian
from proofs.body_polynomials import PAIRS, characteristic
from proofs.pole.polynomials import bilharz, vertical
from proofs.pole.vertical import THRESHOLD

import stability as st
from stability.bodies.contact_laws import LAWS
from stability.bodies.round_body.equations import round_system
from stability.bodies.round_body.families import round_family
from stability.tables.benchmarks.spinning import sphere

LAM = sp.Symbol("lam")
SIDES = {1: 0, -1: "pi"}
"""Sign of cosθ, and the pole as the package names it."""


def body_of(found: Ellipsoid) -> st.Body:
    """The same ellipsoid by its height."""
    square, half, centre = (float(v) for v in (found.square, found.half, found.centre))
    return st.Body(
        lambda t: ca.sqrt(square * ca.sin(t) ** 2 + half**2 * ca.cos(t) ** 2) - centre * ca.cos(t),
        axial=float(found.axial),
        transverse=float(found.transverse),
        name="ellipsoid",
    )


def values(found: Ellipsoid, side: int, mu: Any = 0, n: Any = 0) -> dict[sp.Symbol, Any]:
    """Values of the symbols of the package."""
    h, rho = found.height(side), found.curvature
    table = {
        "h": h,
        "h′′": rho - h,
        "ρ": rho,
        "I1": found.transverse,
        "I3": found.axial,
        "mu": mu,
        "n": n,
    }
    return {sp.Symbol(name): value for name, value in table.items()}


def drawn(rng: np.random.Generator) -> tuple[Ellipsoid, int, sp.Rational, sp.Rational]:
    """A random ellipsoid, its side, friction and rate, all rational."""

    def number(low: int, high: int) -> sp.Rational:
        return sp.Rational(int(rng.integers(low, high)), int(rng.integers(7, 15)))

    half, across = number(5, 20), number(3, 9)
    body = Ellipsoid(
        number(3, 30),
        half,
        half * sp.Rational(int(rng.integers(-8, 9)), 10),
        across,
        across * sp.Rational(int(rng.integers(2, 20)), 10),
    )
    return body, int(rng.choice([1, -1])), number(1, 30), number(-40, 40)


# --- polynomials ---


@pytest.mark.parametrize(
    ("law", "count"),
    [("smooth", 1)]
    + [pytest.param(law, 6, marks=pytest.mark.long) for law in ("viscous", "rough", "smooth")],
)
def test_exact_jacobians_of_another_formulation_have_the_printed_polynomial(
    law: str, count: int
) -> None:
    rng = np.random.default_rng(3)
    printed = vertical(law)
    seen: list[int] = []
    while len(seen) < count or len(set(seen)) < 2:
        body, side, mu, n = drawn(rng)
        given = values(body, side, mu, n)
        parts = [
            sum(
                sp.sympify(c[k]).subs(given) * LAM**i
                for i, c in enumerate(reversed(printed.coefficients))
            )
            for k in (0, 1)
        ]
        lead = sp.sympify(printed.coefficients[0][0]).subs(given)
        exact = jacobian(body, law, side, mu, n).charpoly(LAM).as_expr()
        assert (
            sp.expand(exact * lead**2 - LAM**printed.zeros * (parts[0] ** 2 + parts[1] ** 2)) == 0
        )
        seen.append(side)


@pytest.mark.parametrize("count", [10, pytest.param(60, marks=pytest.mark.long)])
def test_bilharz_counts_the_roots_on_the_right(count: int) -> None:
    rng = np.random.default_rng(4)
    nu, counts = sp.Symbol("nu"), set()
    for _ in range(count):
        roots = [(int(re or 1), int(im)) for re, im in rng.integers(-20, 20, (3, 2))]
        on_axis = sp.expand(sp.prod([sp.I * nu - re - im * sp.I for re, im in roots]))
        conjugate = on_axis.subs(sp.I, -sp.I)
        real, imaginary = (on_axis + conjugate) / 2, (on_axis - conjugate) / (2 * sp.I)
        parts = [sp.Poly(sp.expand(e), nu) for e in (real, imaginary)]
        signs = [1, *bilharz(*parts, 3)]
        if 0 in signs:
            continue
        changes = sum((a > 0) != (b > 0) for a, b in pairwise(signs))
        assert changes == sum(re > 0 for re, _ in roots)
        counts.add(changes)
    assert counts == {0, 1, 2, 3}


# --- thresholds ---


def kind_of(body: Ellipsoid, side: int) -> str:
    h, rho = body.height(side), body.curvature
    lever = body.axial * h - body.transverse * rho
    return ("low" if rho > h else "high") + ("-up" if lever > 0 else "-down")


def word(body: st.Body, side: int, rate: float, contact: st.Contact) -> str:
    found = st.spectrum(
        "vertical", at=rate, body=body, contact=contact, pole=SIDES[side], certify=True
    )
    return found.verdict.word


@pytest.mark.parametrize("mus", [(0.9,), pytest.param((0.05, 0.9, 14.0), marks=pytest.mark.long)])
def test_vertical_spin_is_stable_exactly_where_the_theorem_says(mus: tuple[float, ...]) -> None:
    rng = np.random.default_rng(6)
    near, kinds = 1e-6, dict.fromkeys(("low-up", "low-down", "high-up", "high-down"), 0)
    while min(kinds.values()) < 1:
        body, side, _, _ = drawn(rng)
        kind = kind_of(body, side)
        h, rho = (float(v) for v in (body.height(side), body.curvature))
        lever = float(body.axial) * h - float(body.transverse) * rho
        if kinds[kind] >= 1 or body.axial > 2 * body.transverse or abs(lever) < 0.02:
            continue
        if abs(rho - h) < 0.02:
            continue
        kinds[kind] += 1
        round_body = body_of(body)
        if kind in ("low-up", "high-down"):
            expected = "stable" if kind == "low-up" else "unstable"
            for mu, rate in zip((0.05, 0.9, 14.0)[-len(mus) :], (0.01, 1.3, 60.0), strict=False):
                assert word(round_body, side, rate, st.Viscous(mu)) == expected, kind
            continue
        edge = math.sqrt(h**2 * (h - rho) / (rho * lever))
        inside, outside = ("stable", "unstable") if kind == "low-down" else ("unstable", "stable")
        for mu in mus:
            for rate, wanted in (
                (edge * (1 - near), inside),
                (edge * (1 + near), outside),
                (-edge * (1 + near), outside),
                (20 * edge, outside),
                (edge / 20, inside),
            ):
                assert word(round_body, side, rate, st.Viscous(mu)) == wanted, (kind, mu, rate)


def test_a_wrong_threshold_would_be_refuted() -> None:
    """The lever with I1 and I3 exchanged is another threshold, and verdicts tell."""
    body = Ellipsoid(
        sp.Rational(1), sp.Rational(1), sp.Rational(1, 5), sp.Rational(1, 2), sp.Rational(2, 5)
    )
    h, rho = 0.8, 1.0
    wrong = math.sqrt(h**2 * (rho - h) / (rho * (0.4 * rho - 0.3 * h)))
    right = math.sqrt(h**2 * (rho - h) / (rho * (0.5 * rho - 0.4 * h)))
    assert abs(wrong - right) > 0.05
    middle = (wrong + right) / 2
    found = word(body_of(body), 1, middle, st.Viscous(0.7))
    assert (
        found
        == ("stable" if middle < right else "unstable")
        != ("stable" if middle < wrong else "unstable")
    )


@pytest.mark.long
def test_two_eigenvalues_are_on_the_right_beyond_the_threshold() -> None:
    rng = np.random.default_rng(9)
    seen = 0
    while seen < 12:
        body, side, mu, n = drawn(rng)
        given = values(body, side, mu, n)
        size = THRESHOLD.subs(given)
        if size == 0 or body.height(side) == body.curvature:
            continue
        exact = np.array(jacobian(body, "viscous", side, mu, n).evalf(30).tolist(), dtype=float)
        right = int((np.linalg.eigvals(exact).real > 1e-9).sum())
        assert right == (0 if size > 0 else 2)
        seen += bool(size < 0)


@pytest.mark.parametrize("law", ["rough", "smooth"])
@pytest.mark.parametrize("count", [1, pytest.param(4, marks=pytest.mark.long)])
def test_vertical_spin_is_neutral_exactly_where_the_theorem_says(law: str, count: int) -> None:
    rng = np.random.default_rng(8)
    seen = {"low": 0, "high": 0}
    while min(seen.values()) < count:
        body, side, _, _ = drawn(rng)
        h, rho = (float(v) for v in (body.height(side), body.curvature))
        i1, i3 = float(body.transverse), float(body.axial)
        if body.axial > 2 * body.transverse or abs(rho - h) < 0.02:
            continue
        if seen["low" if rho > h else "high"] >= count:
            continue
        contact: st.Contact = st.Rough() if law == "rough" else st.Smooth()
        own = body_of(body)
        if rho > h:
            seen["low"] += 1
            rates = (0.01, 1.0, 50.0)[3 - min(count, 3) :]
            words = [word(own, side, rate, contact) for rate in rates]
            assert words == ["neutral"] * len(rates)
            continue
        seen["high"] += 1
        squares = {"rough": (i1 + h**2) / (i3 + h * rho) ** 2, "smooth": i1 / i3**2}
        edge = math.sqrt(4 * (h - rho) * squares[law])
        words = [word(own, side, edge * (1 + d), contact) for d in (-1e-6, 1e-6)]
        assert words == ["unstable", "neutral"]


@pytest.mark.few(2)
@pytest.mark.parametrize("aspect", [Fraction(3, 2), Fraction(5), Fraction(2, 3), Fraction(1, 8)])
def test_spheroids_on_their_ends_turn_at_the_same_number(aspect: Fraction) -> None:
    """n² = 5 a³, exactly: a square for 4/5 and 5, otherwise to 12 digits."""
    edge = math.sqrt(5 * float(aspect) ** 3)
    words = ["unstable", "stable"] if aspect > 1 else ["stable", "unstable"]
    body = st.Spheroid(float(aspect))
    for mu in (0.03, 2.0):
        found = [word(body, 1, edge * (1 + d), st.Viscous(mu)) for d in (-1e-9, 1e-9)]
        assert found == words


def test_rouths_sphere_has_the_value_of_the_benchmarks() -> None:
    [row] = sphere()
    i1, i3, e = 0.5, 0.375, 0.25  # the numbers of that table, over mass and radius
    square = 4 * e * (i1 + (1 + e) ** 2) / (i3 + 1 + e) ** 2
    assert math.sqrt(square) == pytest.approx(float(row.known), rel=1e-14)
    top = st.EccentricSphere(e, axial=i3, transverse=i1)
    [edge] = st.boundaries(
        "vertical", axis=("at", 0.1, 5, 20), body=top, contact=st.Rough(), pole="pi"
    )
    assert edge.value**2 == pytest.approx(square, rel=1e-12)


# --- completeness ---


@pytest.mark.few(3)
@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("law", ["viscous", "linear-viscous", "coulomb"])
@pytest.mark.parametrize("count", [10, pytest.param(40, marks=pytest.mark.long)])
def test_no_other_steady_motion_is_found_at_a_pole(law: str, side: int, count: int) -> None:
    """With the axis vertical a level angular velocity or a slip changes, by the other formulation.

    Every rate vanishes at vertical spin; no random state with slip or level angular velocity has
    rates below a hundredth of these.
    """
    rng = np.random.default_rng(2)
    for _ in range(count):
        body = eccentric_sphere(rng.uniform(-0.5, 0.5), rng.uniform(0.2, 0.5), 0.4)
        contact, n = Law(law, 0.6), rng.normal(0, 3)
        if law != "coulomb":  # whose force jumps where the slip vanishes
            still = axis_rates(body, contact, [0, 0, 0, 0, n, 0, 0], side)
            assert np.abs(still).max() < 1e-13
        for size in (1e-4, 1.0):
            level, slip = size * rng.normal(0, 1, (2, 2))
            for w, v in ((level, slip), (0 * level, slip), (level, 0.1 * slip)):
                found = axis_rates(body, contact, [0, 0, *w, n, *v], side)
                assert np.abs(found).max() > 0.01 * max(np.abs(w).max(), np.abs(v).max())


def test_a_body_of_equal_moments_leans_and_spins() -> None:
    """ω = φ̇ Ẑ at a leaning zero of h′ is steady for every φ̇ under friction, if I1 = I3."""
    level, law = 1.2, LAWS["viscous"]
    for axial, steady in ((0.3, True), (0.31, False)):
        body = st.Body(
            lambda t: 1 + 0.3 * ca.cos(t - level),
            axial=axial,
            transverse=0.3,
            name="leaning",
            between=(0.3, 2.8),
        )
        system = round_system(body, law, ("mu",), physical=False)
        table = {"axial": axial, "transverse": 0.3, "mu": 0.6}
        p = [table[n] for n in system.parameters]
        for rate in (0.4, 1.7, 6.0):
            state = [level, 0.0, rate, rate * math.cos(level), 0.0, 0.0]
            assert bool(np.abs(system.rates(state, p)).max() < 1e-13) is steady


# --- circling and precession ---


EGG = st.Body(
    lambda theta, a, b: 1 + a * ca.cos(theta) + b * ca.cos(2 * theta) + 0.01 * ca.cos(3 * theta),
    axial=0.3,
    transverse=0.4,
    shape={"a": 0.1, "b": 0.08},
    name="egg",
)
THIN = st.Body(lambda t: ca.sin(t), axial=0.5, transverse=0.25, name="coin")
THICK = st.ThickDisk(0.4)


@pytest.mark.parametrize(
    ("family", "count"),
    [("precession", 3), *(pytest.param(f, 14, marks=pytest.mark.long) for f in PAIRS)],
)
def test_circling_and_precession_turn_where_the_theorem_says(family: str, count: int) -> None:
    rng = np.random.default_rng(12 if count > 3 else 24)
    law = PAIRS[family]
    contact: st.Contact = st.Rough() if law == "rough" else st.Smooth()
    lead, _, printed = characteristic(family, law).coefficients
    words = set()
    for body in (EGG, THIN, THICK) if count > 3 else (EGG, THIN):
        low, high = body.between
        own = round_family(body, family, LAWS[law], (), physical=False)
        numbers = dict(body.shape) | dict(zip(("axial", "transverse"), body.moments(), strict=True))
        p = [numbers[n] for n in own.parameters]
        for _ in range(count):
            theta, phi = rng.uniform(low + 0.2, high - 0.1), rng.choice([0.1, 0.4, 1.1, 3.0])
            found = st.spectrum(family, at=(theta, phi), body=body, contact=contact, certify=True)
            spin = own.member([theta, phi], p)[3]
            given = numbers_at(body, theta) | {"phi_dot": phi, "omega3": spin}
            table = {sp.Symbol(n): v for n, v in given.items()}
            value = float(printed.subs(table))
            square = max((e**2 for e in found.eigenvalues), key=abs)
            assert square == pytest.approx(-value / float(lead.subs(table)), rel=1e-7)
            assert found.verdict.word == ("neutral" if value > 0 else "unstable")
            words.add(found.verdict.word)
            v = given
            closed = (
                v["I1"] ** 2 * phi**2
                + v["I1"] * (v["h′′"] + v["h′"] * v["c"] / v["s"])
                + (v["h′"] / (phi * v["s"])) ** 2
            )
            if family == "precession":
                assert value == pytest.approx(closed, rel=1e-9)
                if v["h′′"] * v["s"] + v["h′"] * v["c"] + 2 * abs(v["h′"]) > 0:
                    assert found.verdict.word == "neutral"
    assert words == {"neutral", "unstable"}
