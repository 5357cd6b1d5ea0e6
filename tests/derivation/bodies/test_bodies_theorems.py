"""Statements about every body of revolution, against spectra and boundaries of single bodies.

The package's spectra and boundaries take the body's own graph, in doubles and balls; the statements
come from symbols.  Closed forms are compared with quadrature-free numerics of the height.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
import pytest
import sympy as sp
from body_heights import numbers_at
from proofs import spinning
from proofs.body_polynomials import PAIRS, characteristic
from proofs.catalogue import BODIES
from proofs.entry import written
from proofs.known_results import known_results
from proofs.printed_polynomials import polynomial, polynomials
from proofs.rim import (
    COS,
    SIN,
    THRESHOLDS,
    M,
    shifts,
    tumbling_formula,
    tumbling_shift,
)
from proofs.signs import sign
from proofs.spinning import conditions
from proofs.tumbling import energy_slope
from scipy.integrate import solve_ivp

import stability as st
from stability.bodies.contact_laws import LAWS
from stability.bodies.round_body.equations import round_system
from stability.bodies.round_body.families import round_family

ROOT = Path(__file__).resolve().parents[3]
CONTACT: dict[str, Callable[..., st.Contact]] = {
    "viscous": st.Viscous,
    "rough": lambda _: st.Rough(),
    "smooth": lambda _: st.Smooth(),
}
EGG = st.Body(
    lambda theta, a, b: 1 + a * ca.cos(theta) + b * ca.cos(2 * theta) + 0.01 * ca.cos(3 * theta),
    axial=0.3,
    transverse=0.4,
    shape={"a": 0.1, "b": 0.08},
    name="egg",
)
LEAN = st.Body(
    lambda t: 1 + 0.3 * ca.cos(t - 1.2),
    axial=0.3,
    transverse=0.35,
    name="leaning",
    between=(0.3, 2.8),
)
LOW = st.Body(
    lambda t: 1 - 0.3 * ca.cos(t - 1.2), axial=0.3, transverse=0.35, name="low", between=(0.3, 2.8)
)


@lru_cache
def upright(rho: float, axial: float, transverse: float) -> st.Body:
    """A body with h(π/2) = 1 and radius of curvature rho there."""
    return st.Body(
        lambda theta, rho: rho + (1 - rho) * ca.sin(theta),
        axial=axial,
        transverse=transverse,
        shape={"rho": rho},
        name="upright",
    )


@lru_cache
def _function(expression: sp.Expr) -> tuple[list[str], Callable[..., Any]]:
    letters = sorted(expression.free_symbols, key=str)
    return [s.name for s in letters], sp.lambdify(letters, expression, "math")


def at(expression: Any, values: dict[str, float]) -> float:
    names, function = _function(sp.sympify(expression))
    return float(function(*(values[n] for n in names)))


def member_of(family: str, at: float | tuple[float, float], body: st.Body, law: str) -> np.ndarray:
    """State of a member, from the body's own graph."""
    given = ("mu",) if law == "viscous" else ()
    found = round_family(body, family, LAWS[law], given, physical=False)
    table = dict(body.shape) | dict(zip(("axial", "transverse"), body.moments(), strict=True))
    return found.member(np.atleast_1d(at), [(table | {"mu": 0.7})[n] for n in found.parameters])


# --- proofs ---


SOON = ("spinning-conservative", "painleve")
"""Theorems that are proved within a second."""


@pytest.mark.parametrize(
    "name", [n if n in SOON else pytest.param(n, marks=pytest.mark.long) for n in BODIES]
)
def test_every_step_about_every_body_is_proved(name: str) -> None:
    theorem = BODIES[name]()
    assert [(s.claim, s.detail) for s in theorem.steps if not s.proved] == []
    assert theorem.proved and theorem.statement and theorem.assumptions
    for refuter in theorem.refuters:
        file, test = refuter.split("::")
        assert f"def {test}(" in (ROOT / file).read_text("utf-8")


def test_a_sign_is_proved_only_where_it_holds() -> None:
    x, t, u = sp.symbols("x t u")
    assert sign(x + u) == 1 and sign(-x / u) == -1
    assert sign(x - u) == sign(x - x) == 0
    assert sign(1 - x**2, {x: t / (1 + t)}) == 1 and sign(1 - 2 * x, {x: t / (1 + t)}) == 0
    assert sign(x - 1, {x: 1 + t}, {x: 1 / (1 + t)}) == 0


# --- polynomials ---


MEMBERS: list[tuple[str, st.Body, float | tuple[float, float]]] = [
    ("rolling", st.Torus(0.2), 1.3),
    ("rolling", LEAN, 0.7),
    ("rolling", LOW, 1.1),
    ("rolling", st.ThickDisk(0.4), 2.0),
    ("spinning", st.Spheroid(1.7), 1.2),
    ("spinning", st.Torus(0.3, solid=False), 2.1),
    ("tumbling", st.Spheroid(0.4), 0.8),
    ("tumbling", st.Torus(0.2), 1.1),
    ("tumbling", st.ThickDisk(0.3), 0.9),
    ("tumbling", EGG, 0.9),
    ("circling", EGG, (0.9, 1.3)),
    ("circling", LEAN, (1.6, 0.7)),
    ("circling", st.ThickDisk(0.3), (1.1, 2.1)),
    ("precession", EGG, (2.1, 0.8)),
    ("precession", st.Torus(0.2), (0.8, 1.9)),
]


SLOW = {
    ("rolling", "viscous"),
    ("rolling", "rough"),
    ("tumbling", "viscous"),
    ("tumbling", "rough"),
    ("circling", "rough"),
}
"""Polynomials that take a second and more."""


@pytest.mark.few(4)
@pytest.mark.parametrize(
    ("family", "body", "member", "law"),
    [
        pytest.param(*m, law, marks=[pytest.mark.long] if (m[0], law) in SLOW else [])
        for m in MEMBERS
        for law in CONTACT
        if PAIRS.get(m[0], law) == law
    ],
)
def test_polynomials_have_the_eigenvalues_of_the_spectrum(
    family: str, body: st.Body, member: float | tuple[float, float], law: str
) -> None:
    mu = 0.7
    spectrum = st.spectrum(family, at=member, body=body, contact=CONTACT[law](mu))
    found = characteristic(family, law)
    theta, _, phi, spin = member_of(family, member, body, law)[:4]
    values = numbers_at(body, theta) | {"phi_dot": phi, "omega3": spin, "mu": mu}
    roots = np.roots([at(c, values) for c in found.coefficients])
    ours = np.array(spectrum.eigenvalues)
    assert len(ours) + spectrum.structural_zeros == found.zeros + len(roots)
    for root in roots:
        assert np.abs(ours - root).min() < 1e-8 * np.abs(ours).max()


@pytest.mark.parametrize("count", [12, pytest.param(40, marks=pytest.mark.long)])
def test_conditions_are_those_of_the_roots(count: int) -> None:
    rng = np.random.default_rng(2)
    found = characteristic("spinning", "viscous")
    named = conditions(found)
    seen = set()
    for _ in range(count):
        values = {
            "I1": rng.uniform(0.2, 1),
            "h": 1.0,
            "h′′": rng.uniform(-1, 1),
            "phi_dot": rng.uniform(0.3, 4),
            "mu": rng.uniform(0.1, 3),
        }
        values["I3"] = values["I1"] * rng.uniform(0.3, 1.9)
        roots = np.roots([at(c, values) for c in found.coefficients])
        holds = all(at(c, values) > 0 for _, c in named)
        assert holds == (roots.real.max() < 0)
        seen.add(holds)
    assert seen == {True, False}


# --- rolling and spinning ---


@pytest.mark.few(3)
@pytest.mark.parametrize(
    ("body", "law"),
    [(st.Torus(0.2), law) for law in CONTACT]
    + [(st.Spheroid(0.5), law) for law in CONTACT]
    + [(LEAN, "rough"), (LEAN, "smooth")],  # under viscous friction for upright rolling alone
)
def test_rolling_turns_at_the_printed_threshold(body: st.Body, law: str) -> None:
    theta = 1.2 if body is LEAN else math.pi / 2
    v = numbers_at(body, theta)
    i1, i3, h, bend = v["I1"], v["I3"], v["h"], v["h′′"]
    q = i1 * i3 + h**2 * (i1 * v["s"] ** 2 + i3 * v["c"] ** 2)
    known = {
        "rough": -bend * q / (i3 * (i3 + h**2) * (i3 + h**2 + h * bend * v["c"] ** 2)),
        "smooth": -i1 * bend / i3**2,
        "viscous": -i1 * bend / (i3 * (i3 - i1)),
    }[law]
    for mu in (0.3, 3.0):
        found = st.boundaries(
            "rolling", axis=("omega3", 0.05, 6, 20), body=body, contact=CONTACT[law](mu)
        )
        assert [b.value**2 for b in found] == pytest.approx([known], rel=1e-12)
        assert not found[0].stable_below


def test_rolling_of_a_long_body_turns_the_other_way() -> None:
    body = st.Spheroid(1.6)
    v = numbers_at(body, math.pi / 2)
    known = v["I1"] * v["h′′"] / (v["I3"] * (v["I1"] - v["I3"]))
    found = st.boundaries(
        "rolling", axis=("omega3", 0.05, 8, 20), body=body, contact=st.Viscous(0.8)
    )
    assert [b.value**2 for b in found] == pytest.approx([known], rel=1e-12)
    assert found[0].stable_below
    assert not len(
        st.boundaries("rolling", axis=("omega3", 0.05, 8, 20), body=body, contact=st.Rough())
    )


@pytest.mark.parametrize("law", ["rough", "smooth"])
@pytest.mark.parametrize("body", [st.Torus(0.3), st.Spheroid(0.6)], ids=lambda b: b.name)
def test_spinning_turns_at_the_printed_threshold(body: st.Body, law: str) -> None:
    v = numbers_at(body, math.pi / 2)
    known = -v["h′′"] / (v["I1"] + (v["h"] ** 2 if law == "rough" else 0))
    found = st.boundaries(
        "spinning", axis=("phi_dot", 0.1, 5, 20), body=body, contact=CONTACT[law](0)
    )
    assert [b.value**2 for b in found] == pytest.approx([known], rel=1e-12)


def _limits(rho: float, axial: float, transverse: float) -> tuple[float, float, float]:
    """q1, M1 and M2, written once more."""
    q1 = (1 - rho) / (transverse - axial * rho)
    m1 = 2 * axial * (1 + rho) / ((1 + axial) * (2 * transverse + 1 + rho))
    m2 = math.inf
    if axial > transverse:
        m2 = (
            2
            * (1 - rho)
            * axial**2
            * (transverse + axial)
            / ((1 + axial) * (axial - transverse) * (transverse + axial + 2 * transverse * axial))
        )
    return q1, m1, m2


def _member(rho: float, axial: float, transverse: float, m: float, q: float) -> str:
    return st.spectrum(
        "spinning",
        at=math.sqrt(q),
        body=upright(rho, axial, transverse),
        contact=st.Viscous(math.sqrt(m)),
        certify=True,
    ).verdict.word


@pytest.mark.parametrize("count", [1, pytest.param(3, marks=pytest.mark.long)])
def test_spinning_is_stable_exactly_where_the_theorem_says(count: int) -> None:
    rng = np.random.default_rng(11)
    near, kinds = 1e-6, {"flat": 0, "round": 0}
    while min(kinds.values()) < count:
        axial, rho = rng.uniform(0.1, 1.2), rng.choice([0.0, rng.uniform(0, 0.5)])
        transverse = axial * max(rng.uniform(0.5, 1.4), rho + 0.05)
        body = (float(rho), float(axial), float(transverse))
        q1, m1, m2 = _limits(*body)
        kind = "flat" if axial > transverse else "round"
        if kinds[kind] == count:
            continue
        kinds[kind] += 1
        assert m1 < m2
        for m in (m1, m2 * 2, m1 / 2, 0.3)[: 1 + count]:
            if math.isfinite(m):
                assert _member(*body, m, q1 * (1 - near)) == "unstable"
        for q in (q1 * (1 + near), 2 * q1, 50 * q1, 1e5):
            assert _member(*body, m1 * (1 - near), q) == "stable"
            if math.isfinite(m2):
                assert _member(*body, m2 * (1 + near), q) == "unstable"
        middle = (m1 + m2) / 2 if math.isfinite(m2) else 3 * m1
        coefficients = [
            at(c, {"ρ": rho, "I1": transverse, "I3": axial, "M": middle})
            for c in spinning.flutter()
        ]
        [edge] = [r.real for r in np.roots(coefficients) if r.real > 0]
        for share, word in ((1 - near, "stable"), (1 + near, "unstable")):
            assert _member(*body, middle, q1 + edge * share) == word


def test_a_wrong_limit_would_be_refuted() -> None:
    body = (0.2, 0.5, 0.3)
    q1, m1, m2 = _limits(*body)
    assert _member(*body, m1 * 1.01, 1e6) == "unstable"
    assert _member(*body, m2 * 0.99, q1 * (1 + 1e-6)) == "stable"


@pytest.mark.few(1)
@pytest.mark.parametrize("aspect", [1.2, 2.0, 3.0])
def test_a_lying_spheroid_rises_above_the_same_number(aspect: float) -> None:
    for mu in (0.05, 0.7):
        words = [
            st.spectrum(
                "spinning",
                at=math.sqrt(5 * (1 + d)),
                body=st.Spheroid(aspect),
                contact=st.Viscous(mu),
                certify=True,
            ).verdict.word
            for d in (-1e-9, 1e-9)
        ]
        assert words == ["stable", "unstable"]
    fast = st.spectrum("spinning", at=2.3, body=st.Spheroid(aspect), contact=st.Viscous(2.0))
    assert fast.verdict.word == "unstable"
    flat = st.boundaries(
        "spinning",
        axis=("phi_dot", 1.0, 3, 20),
        body=st.Spheroid(1 / aspect),
        contact=st.Viscous(0.05),
    )
    assert [b.value**2 for b in flat] == pytest.approx([5], rel=1e-12)


# --- families ---


def test_members_of_circling_and_precession_lie_on_the_surfaces() -> None:
    for name, law in (("circling", "rough"), ("precession", "smooth")):
        family = round_family(EGG, name, LAWS[law], (), physical=False)
        p = [{"axial": 0.3, "transverse": 0.4, "a": 0.1, "b": 0.08}[n] for n in family.parameters]
        for theta, phi in ((0.9, 1.3), (2.1, 0.4)):
            state = family.member([theta, phi], p)
            v, spin = numbers_at(EGG, theta), state[3]
            arm = (v["r"] * v["h"], v["z"] * v["h"]) if law == "rough" else (0, 0)
            value = v["h′"] + phi * (
                spin * (arm[0] + v["I3"] * v["s"]) - phi * v["s"] * (arm[1] + v["I1"] * v["c"])
            )
            assert value == pytest.approx(0, abs=1e-12)


def test_tumbling_meets_spinning_and_rest_where_the_theorem_says() -> None:
    for body in (st.Torus(0.2), st.Spheroid(0.5)):
        v = numbers_at(body, math.pi / 2)
        known = v["h"] * v["h′′"] / (v["I3"] * v["ρ"] - v["I1"] * v["h"])
        state = member_of("tumbling", math.pi / 2 - 1e-4, body, "rough")
        assert state[2] ** 2 == pytest.approx(known, rel=1e-6)
    thick = st.ThickDisk(0.4)
    level, v = math.atan(5), numbers_at(thick, math.atan(5))
    for step in (1e-4, -1e-4):
        square = v["h′′"] * step / ((v["I1"] - v["I3"]) * v["s"] * v["c"])
        if square > 0:
            state = member_of("tumbling", level + step, thick, "rough")
            assert state[2] ** 2 == pytest.approx(square, rel=1e-2)
        else:
            with pytest.raises(st.StabilityError):
                st.spectrum("tumbling", at=level + step, body=thick, contact=st.Rough())


def _energy(body: st.Body, theta: float) -> float:
    """Energy of tumbling, from the height alone."""
    v = numbers_at(body, theta)
    square = v["h′"] * v["r"] / (v["s"] * (v["I1"] * v["r"] * v["c"] - v["I3"] * v["z"] * v["s"]))
    turn = v["I1"] * v["s"] ** 2 + v["I3"] * (v["s"] * v["z"] / v["r"]) ** 2
    return float(v["h"] + square * turn / 2)


@pytest.mark.parametrize("whole", [False, pytest.param(True, marks=pytest.mark.long)])
def test_tumbling_has_its_static_boundary_where_energy_is_stationary(whole: bool) -> None:
    body = st.Spheroid(1.5)
    slopes = [at(energy_slope(), numbers_at(body, t)) for t in (0.4, 1.1)]
    for slope, t in zip(slopes, (0.4, 1.1), strict=True):
        measured = (_energy(body, t + 1e-5) - _energy(body, t - 1e-5)) / 2e-5
        assert slope == pytest.approx(measured, rel=1e-6)
    turned = 0
    for shape in (st.ThickDisk(0.5), st.ThickDisk(1.0), EGG, LOW, LEAN)[: 5 if whole else 1]:
        low, high = shape.between
        for theta in np.linspace(low, high, 30)[2 : -2 : 1 if whole else 3]:
            try:
                found = st.spectrum(
                    "tumbling", at=float(theta), body=shape, contact=st.Viscous(0.4)
                )
            except st.StabilityError:
                continue
            v = numbers_at(shape, theta)
            sign_of = v["h′"] * at(energy_slope(), v)
            rest = np.array(found.eigenvalues)  # the structural zero is not among them
            assert len(rest) == 5
            positive = (np.abs(rest.imag) < 1e-9) & (rest.real > 1e-7)
            assert (sign_of < 0) == (int(positive.sum()) % 2 == 1)
            turned += sign_of < 0
    assert turned > (3 if whole else 0)


@pytest.mark.parametrize("law", ["rough", "smooth"])
def test_energy_is_least_at_neutral_members(law: str) -> None:
    system = round_system(EGG, LAWS[law], (), physical=False)
    table = {"axial": 0.3, "transverse": 0.4, "a": 0.1, "b": 0.08}
    p = [table[n] for n in system.parameters]
    words = set()
    for family, member in (
        ("rolling", 0.2),
        ("rolling", 3.0),
        ("tumbling", 0.9),
        ("tumbling", 2.2),
    ):
        theta_star = {"theta": 1.4} if family == "rolling" else {}
        try:
            found = st.spectrum(family, at=member, body=EGG, contact=CONTACT[law](0), **theta_star)
        except st.StabilityError:
            continue
        theta, _, phi, spin = member_of(family, member, EGG, law)[:4]

        def turn(t: float, y: np.ndarray) -> np.ndarray:
            # φ̈ and ω̇₃ are in proportion to θ̇
            return np.asarray(system.rates([t, 1.0, *y], p))[2:4]

        energies = []
        for step in (-2e-3, 0.0, 2e-3):
            y = [phi, spin]
            if step:
                y = solve_ivp(turn, (theta, theta + step), y, rtol=1e-12, atol=1e-13).y[:, -1]
            energies.append(system.observe([theta + step, 0.0, *y], p)["energy"])
        bend = (energies[0] - 2 * energies[1] + energies[2]) / 4e-6
        inertia = numbers_at(EGG, theta)["I1"] + numbers_at(EGG, theta)["h′"] ** 2
        inertia += numbers_at(EGG, theta)["h"] ** 2 if law == "rough" else 0
        square = max((e**2 for e in found.eigenvalues), key=abs)
        assert bend == pytest.approx(-inertia * square.real, rel=2e-4)
        words.add(found.verdict.word)
    assert words


# --- a rounded rim ---


def rounded(kind: str, k: float, eps: float) -> st.Body:
    """A coin with a rounded rim."""
    outer = 1.0 if kind == "h = sinθ + ε" else 1 - eps
    return st.Body(
        lambda theta, eps, outer: outer * ca.sin(theta) + eps,
        axial=2 * k,
        transverse=k,
        shape={"eps": eps, "outer": outer},
        name="coin",
    )


@pytest.mark.few(4)
@pytest.mark.parametrize("shift", shifts(), ids=lambda s: f"{s.family}-{s.law}-{s.quantity}")
def test_thresholds_of_a_rounded_coin_move_at_the_printed_rate(shift: Any) -> None:
    k = 0.3
    value, slope = (float(e.subs(sp.Symbol("k"), k)) for e in (shift.value, shift.slope))
    left = []
    for eps in (0.02, 0.01):
        body = rounded(shift.rounded, k, eps)
        if shift.quantity.startswith("mu"):
            # far above the static boundary for M1, just above it for M2
            static = THRESHOLDS["spinning", "viscous", "φ̇²"]
            lower = at(static, numbers_at(body, math.pi / 2))
            rate = 1e5 if shift.quantity.endswith("M1") else math.sqrt(lower * (1 + 1e-9))
            found = st.boundaries(
                "spinning", at=rate, axis=("mu", 0.3, 3, 30), body=body, contact="viscous"
            )
        else:
            axis = "omega3" if shift.family == "rolling" else "phi_dot"
            found = st.boundaries(
                shift.family, axis=(axis, 0.2, 4, 20), body=body, contact=CONTACT[shift.law](0.2)
            )
        left.append(abs(found[0].value ** 2 - value - eps * slope))
    assert left[0] < 20 * 0.02**2 * max(value, 1)
    if left[1] > 1e-7:
        assert 3.4 < left[0] / left[1] < 4.8  # the rest is of second order


@pytest.mark.few(2)
@pytest.mark.parametrize(
    "shift",
    [s for s in shifts() if s.rounded == "h = sinθ + ε" and not s.quantity.startswith("mu")],
    ids=lambda s: f"{s.family}-{s.law}-{s.quantity}",
)
def test_the_solid_torus_moves_as_the_rounded_hoop(shift: Any) -> None:
    value, slope = (float(e.subs(sp.Symbol("k"), 0.5)) for e in (shift.value, shift.slope))
    axis, left = ("omega3" if shift.family == "rolling" else "phi_dot"), []
    for eps in (0.02, 0.01):
        found = st.boundaries(
            shift.family,
            axis=(axis, 0.2, 4, 20),
            body=st.Torus(eps),
            contact=CONTACT[shift.law](0.2),
        )
        left.append(abs(found[0].value ** 2 - value - eps * slope))
    assert 3.4 < left[0] / left[1] < 4.8


@pytest.mark.long
@pytest.mark.parametrize("kind", ["h = sinθ + ε", "h = (1-ε) sinθ + ε"])
def test_tumbling_of_a_rounded_coin_moves_at_the_printed_rate(kind: str) -> None:
    for k, theta in ((0.25, 1.2), (0.5, 1.0)):
        pair = tumbling_shift(kind, k, theta)
        assert pair is not None
        value, slope = (float(x) for x in pair)
        assert all(x.rad() < 1e-40 for x in pair)
        left = []
        for eps in (0.004, 0.002):
            found = st.boundaries(
                "tumbling",
                at=theta,
                axis=("mu", 0.2, 3, 30),
                body=rounded(kind, k, eps),
                contact="viscous",
            )
            assert len(found) == 1
            left.append(abs(found[0].value ** 2 - value - eps * slope))
        assert left[0] < 50 * 0.004**2
        assert 3.4 < left[0] / left[1] < 4.8


@pytest.mark.long
@pytest.mark.parametrize("kind", ["h = sinθ + ε", "h = (1-ε) sinθ + ε"])
def test_tumbling_of_a_rounded_coin_ends_at_the_limit_of_spinning(kind: str) -> None:
    """Upright, tumbling branches off spinning: its limit of mu² is M2, and moves as M2 does."""
    found = tumbling_formula(kind)
    [m2] = [s for s in shifts() if s.quantity == "mu² M2" and s.rounded == kind]
    upright = {COS: 0, SIN: 1}
    assert sp.simplify(found.condition.subs(upright).subs(M, m2.value)) == 0
    assert sp.simplify(found.slope.subs(upright).subs(M, m2.value) - m2.slope) == 0
    assert sp.simplify(found.condition.subs(M, found.limit)) == 0


@pytest.mark.long
@pytest.mark.parametrize("k", [0.05, 0.2])
def test_a_flat_coin_tumbles_stably_for_every_mu_where_there_is_no_limit(k: float) -> None:
    kind, theta = "h = sinθ + ε", 0.5  # cos²θ > k/((1-3k)(1+2k))
    assert tumbling_shift(kind, k, theta) is None
    for mu in (0.1, 3.0, 100.0):
        found = st.spectrum(
            "tumbling", at=theta, body=rounded(kind, k, 1e-9), contact=st.Viscous(mu), certify=True
        )
        assert found.verdict.word == "stable"


# --- known results and polynomials ---


def test_known_results_are_recovered_and_say_what_of_their_source_was_at_hand() -> None:
    known = {entry.name: entry for entry in (make() for make in known_results())}
    assert len(known) == 10
    assert "1/4 g/R" in known["rolling hoop"].statement[0]
    assert "1/3 g/R" in known["rolling coin"].statement[0]
    for entry in known.values():
        assert "not recovered" not in entry.status
        if entry.status.startswith("published"):
            assert entry.published and "at hand" in entry.source
        elif entry.status.startswith("recomputed"):
            assert not entry.published
    assert {n for n, e in known.items() if e.status.startswith("published")} == {
        "tippe top, inverted",
        "rolling coin",
        "gyroscopic balance",
    }


@pytest.mark.long
def test_every_polynomial_is_printed_with_its_coefficients() -> None:
    entries = [polynomial(*names) for names in polynomials()]
    assert {"circling, rough", "precession, smooth", "vertical, viscous"} <= {
        entry.name for entry in entries
    }
    assert len(entries) == 14
    assert all(len(entry.statement) > 2 and entry.refuters for entry in entries)
    assert written(sp.Symbol("phi_dot") ** 12 * sp.Symbol("mu")) == "mu φ̇¹²"
