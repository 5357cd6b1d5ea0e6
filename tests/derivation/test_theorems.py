"""The theorems about the disk: proved, and tried to be refuted.

The refuters share no code with the package: exact arithmetic on the characteristic polynomials from
Kane's equations (tests/data/kane_polynomials.json), and two derivations of the equations of motion
(tests/oracles/kane_disk.py).  For each refuter a wrong statement shows that it can refute.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import lru_cache
from typing import Any

import casadi as ca
import mpmath
import numpy as np
import pytest
import sympy as sp
from boundary_oracle import good, polynomials
from flint import fmpq
from kane_disk import Solution, fixed_axes, kane_system
from numpy.typing import NDArray
from proofs import spinning as spinning_theorem
from proofs.catalogue import DISK
from proofs.disk import case
from proofs.disk import tumbling as tumbling_theorem
from proofs.entry import Entry, listed
from proofs.proof import Proof, Theorem, shown

import stability as st
from stability.motion.result import BY_CODE

Array = NDArray[Any]
Verdict = Callable[..., bool]
K, X, M = sp.symbols("k x M")
NEAR = Fraction(1, 10**12)


# --- proofs ---


SLOW = ("case", "settling", "spinning-elliptic", "tumbling", "tumbling-shape")


@pytest.mark.few(2)
@pytest.mark.parametrize(
    "name", [pytest.param(n, marks=pytest.mark.long) if n in SLOW else n for n in DISK]
)
def test_every_step_of_a_theorem_is_proved(name: str) -> None:
    theorem = DISK[name]()
    assert [s.claim for s in theorem.steps if not s.proved] == []
    assert theorem.proved
    assert len(theorem.steps) >= 4
    assert theorem.statement and theorem.assumptions and theorem.refuters


def test_a_failed_step_is_printed_and_fails_the_page(capsys: pytest.CaptureFixture[str]) -> None:
    proof = Proof()
    proof.step("2 = 2", "equality", lambda: True)
    proof.step("1 = 2", "equality", lambda: (1 == 2, "they differ"))
    proof.step("1/0 > 0", "division", lambda: 1 / 0 > 0)
    proof.conclude("everything", "the steps above")
    assert [s.proved for s in proof.steps] == [True, False, False, False]
    theorem = Theorem("false", ("1 = 2",), (), tuple(proof.steps), ())
    assert not theorem.proved
    with pytest.raises(AssertionError, match=r"a conjecture: false; steps that fail: \['1 = 2'"):
        shown(theorem)
    printed = capsys.readouterr().out
    assert printed.count("[FAILS]") == 3 and printed.count("[proved]") == 1
    with pytest.raises(AssertionError, match="nothing"):
        shown(Theorem("nothing", (), (), (), ()))
    with pytest.raises(AssertionError, match="not recovered: a value"):
        listed(Entry("a value", "not recovered", ("1 = 2",)))


def failing(prove: Any) -> list[str]:
    """Claims that fail when a theorem is proved again."""
    prove.cache_clear()
    wrong = prove()
    prove.cache_clear()
    return [step.claim for step in wrong.steps if not step.proved]


@pytest.mark.long
def test_a_theorem_with_a_wrong_threshold_is_not_proved(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(spinning_theorem, "M1", spinning_theorem.M1 * (1 + NEAR))
    assert failing(spinning_theorem.spinning_viscous)[0][:6] == "a2 > 0"
    claims = failing(case.disk_case)  # the disk's M1 is not the general one, which is not proved
    assert len(claims) == 2 and "M1 = 4k/(2k+1)²" in claims[0]


@pytest.mark.long
def test_theorems_of_other_equations_are_not_proved(monkeypatch: pytest.MonkeyPatch) -> None:
    """A sign in the graph's condition is changed: the shape of the theorem is lost."""
    a2, a1, a0 = spinning_theorem.flutter()
    monkeypatch.setattr(spinning_theorem, "flutter", lambda: (a2, -a1, a0))
    assert failing(spinning_theorem.spinning_viscous)
    a, b, c = tumbling_theorem.coefficients()
    monkeypatch.setattr(tumbling_theorem, "coefficients", lambda: (a, -b, c))
    assert failing(tumbling_theorem.tumbling)


@pytest.mark.long
def test_another_height_or_another_graph_is_no_disk(monkeypatch: pytest.MonkeyPatch) -> None:
    system = st.disk_system(case.StatedForce)
    assert system.mass is not None and system.forcing is not None
    forcing = ca.SX(system.forcing)
    forcing[4] = forcing[4] + system.p[0] * system.x[2]  # a torque about 2̂
    broken = replace(system, forcing=forcing)
    with monkeypatch.context() as patch:
        patch.setattr(case, "disk_system", lambda _: broken)
        [claim] = failing(case.disk_case)
        assert claim.startswith("the disk's own graph has the rows")
    monkeypatch.setattr(case, "DISK", case.DISK | {case.I3: 3 * case.K})
    kept = (case.rows, case.energy)
    for cached in kept:
        cached.cache_clear()
    claims = failing(case.disk_case)
    for cached in kept:
        cached.cache_clear()
    assert any(c.startswith("rolling, viscous: the disk's characteristic") for c in claims)
    assert any(c.startswith("without slip: (2k+1)") for c in claims)
    assert any(c.startswith("the disk's own graph") for c in claims)


# --- stability, exactly ---


def stable(family: str, k: Fraction, m: Fraction, z: Fraction, s: Fraction) -> bool:
    """Whether every eigenvalue but the structural ones has a negative real part, over Q."""
    q = [fmpq(v.numerator, v.denominator) for v in (k, m, z, s)]
    total = []
    for terms in polynomials()[f"{family} viscous"]:
        value = fmpq(0)
        for coefficient, *powers in terms:
            product = fmpq(coefficient)
            for x, p in zip(q, powers, strict=True):
                if p:
                    product = product * x**p
            value += product
        total.append(value)
    return bool(total[0] != 0) and good(total)


def rational(value: Any, digits: int = 40) -> Fraction:
    """A rational number near an mpmath one."""
    with mpmath.workdps(digits + 10):
        return Fraction(int(mpmath.nint(mpmath.mpf(value) * 10**digits)), 10**digits)


def real(value: Fraction) -> Any:
    return mpmath.mpf(value.numerator) / value.denominator


def inertia(rng: np.random.Generator) -> Fraction:
    """A rational k in (0, 1/2], its ends and the limits of the theorems included."""
    special = (
        Fraction(1, 2),
        Fraction(1, 4),
        Fraction(1, 10**6),
        Fraction(1, 3),
        Fraction(27429, 10**5),
        Fraction(274292, 10**6),
        Fraction(1, 2) - NEAR,
    )
    if rng.random() < 0.3:
        return special[rng.integers(len(special))]
    return Fraction(int(rng.integers(1, 5001)), 10**4)


def next_to(value: Fraction, rng: np.random.Generator) -> Fraction:
    """A number a relative 1e-12 below or above."""
    return value * (1 + (NEAR if rng.random() < 0.5 else -NEAR))


@lru_cache
def spinning_excess() -> Any:
    """v* of the statement from k and M, for mpmath."""
    a2, a1, a0 = case.flutter()
    k, m = case.K, case.M
    return sp.lambdify((k, m), (-a1 - sp.sqrt(a1**2 - 4 * a2 * a0)) / (2 * a2), "mpmath")


def thresholds(k: Fraction) -> tuple[Fraction, Fraction]:
    return 4 * k / (2 * k + 1) ** 2, 24 * k / ((2 * k + 1) * (4 * k + 3))


def spinning_says(k: Fraction, m: Fraction, z: Fraction) -> bool:
    """The statement on spinning."""
    m1, m2 = thresholds(k)
    if z <= 1 / k or m >= m2:
        return False
    if m <= m1:
        return True
    with mpmath.workdps(80):
        return bool(real(z) < 1 / real(k) + spinning_excess()(real(k), real(m)))


def spinning_points(count: int, seed: int) -> list[tuple[Fraction, Fraction, Fraction]]:
    rng = np.random.default_rng(seed)
    out = []
    for _ in range(count):
        k = inertia(rng)
        m1, m2 = thresholds(k)
        between = m1 + (m2 - m1) * Fraction(int(rng.integers(1, 1000)), 1000)
        anywhere = Fraction(int(10 ** rng.uniform(0, 8)), 10**4)
        m = [m1, m2, next_to(m1, rng), next_to(m2, rng), between, between, anywhere][
            rng.integers(7)
        ]
        z = 1 / k + Fraction(int(10 ** rng.uniform(0, 12)), 10**6)
        choice = rng.integers(6)
        if choice == 0:
            z = next_to(1 / k, rng)
        elif choice == 1:
            z *= 10**15
        elif choice >= 4 and m1 < m < m2:
            with mpmath.workdps(80):
                edge = 1 / real(k) + spinning_excess()(real(k), real(m))
                # next to its ends the excess v* is itself small or large: a part of v*
                z = 1 / k + next_to(rational(edge - 1 / real(k), 60), rng)
        out.append((k, m, z))
    return out


@pytest.mark.parametrize("count", [500, pytest.param(2000, marks=pytest.mark.long)])
def test_spinning_is_stable_exactly_where_the_theorem_says(count: int) -> None:
    points = spinning_points(count, 1)
    wrong = [p for p in points if stable("spinning", *p, Fraction(1)) != spinning_says(*p)]
    assert wrong == []
    kinds = [spinning_says(*p) for p in points]
    assert count < 4 * sum(kinds) < 3 * count


def test_a_wrong_statement_on_spinning_is_refuted() -> None:
    def wrong(k: Fraction, m: Fraction, z: Fraction) -> bool:
        m1, m2 = thresholds(k)
        if m1 < m < m1 * (1 + 2 * NEAR):  # the threshold moved by a relative 2e-12
            return z > 1 / k
        return spinning_says(k, m, z)

    points = spinning_points(200, 2)
    assert any(stable("spinning", *p, Fraction(1)) != wrong(*p) for p in points)


@lru_cache
def tumbling_boundary() -> Any:
    """M_b of the statement from k and s, written as it is printed, for mpmath."""
    s = sp.Symbol("s")
    x = 1 - s**2
    a = (2 * K + 1) ** 2 * (K * (4 * K + 3) + (2 * K + 1) * x) * ((1 - 3 * K) * (1 + 2 * K) * x - K)
    b = (
        4
        * K
        * (2 * K + 1)
        * (6 * K**2 + K * (8 - 25 * K) * x + (2 - 7 * K + 9 * K**2 - 36 * K**3) * x**2)
    )
    c = 96 * K**3 * x * (K + (1 - 3 * K) * x)
    return sp.lambdify((K, s), 2 * c / ((sp.sqrt(b**2 - 4 * a * c) - b) * s), "mpmath")


def steep(k: Fraction, s: Fraction) -> bool:
    return (1 - 3 * k) * (1 + 2 * k) * (1 - s**2) >= k and 3 * k < 1


def tumbling_says(k: Fraction, m: Fraction, s: Fraction) -> bool:
    """The statement on tumbling."""
    if steep(k, s):
        return True
    with mpmath.workdps(80):
        return bool(real(m) < tumbling_boundary()(real(k), real(s)))


def tumbling_points(count: int, seed: int) -> list[tuple[Fraction, Fraction, Fraction]]:
    rng = np.random.default_rng(seed)
    out = []
    for _ in range(count):
        k = inertia(rng)
        s = Fraction(int(rng.integers(1, 10**4)), 10**4)
        s = [s, s, s, Fraction(1, 10**5), 1 - NEAR][rng.integers(5)]
        m = Fraction(int(10 ** rng.uniform(0, 9)), 10**6)
        lead = (1 - 3 * k) * (1 + 2 * k)
        with mpmath.workdps(80):
            if rng.random() < 0.2 and 0 < k < lead:  # next to A = 0, at a large mu
                x = next_to(k / lead, rng)
                s, m = rational(mpmath.sqrt(1 - real(x))), m * 10**20
            elif rng.random() < 0.5 and not steep(k, s):
                m = next_to(rational(tumbling_boundary()(real(k), real(s)), 60), rng)
        if m > 0 and 0 < s < 1:
            out.append((k, m, s))
    return out


@pytest.mark.parametrize("count", [500, pytest.param(2000, marks=pytest.mark.long)])
def test_tumbling_is_stable_exactly_where_the_theorem_says(count: int) -> None:
    points = tumbling_points(count, 3)
    wrong = [
        (k, m, s)
        for k, m, s in points
        if stable("tumbling", k, m, Fraction(0), s) != tumbling_says(k, m, s)
    ]
    assert wrong == []
    kinds = [tumbling_says(*p) for p in points]
    assert count < 4 * sum(kinds) < 3 * count
    assert sum(steep(k, s) for k, _, s in points) > 0.075 * count


def test_a_wrong_statement_on_tumbling_is_refuted() -> None:
    points = tumbling_points(120, 4)
    wrong = [
        (k, m, s)
        for k, m, s in points  # the boundary moved by a relative 2e-12
        if stable("tumbling", k, m, Fraction(0), s) != tumbling_says(k, m * (1 + 2 * NEAR), s)
    ]
    assert len(wrong) > 8


# --- the shape of M_b ---


def boundary(k: Fraction, s: Fraction) -> Fraction:
    """M_b by halving, on exact verdicts: stable below, unstable above."""
    low, high = Fraction(1, 10**12), Fraction(10**12)
    assert stable("tumbling", k, low, Fraction(0), s)
    if stable("tumbling", k, high, Fraction(0), s):
        return Fraction(10**15)  # beyond the range, or stable for every mu
    for _ in range(130):
        middle = (
            rational(mpmath.sqrt(real(low) * real(high)), 60)
            if high > 2 * low
            else ((low + high) / 2)
        )
        if stable("tumbling", k, middle, Fraction(0), s):
            low = middle
        else:
            high = middle
        if high - low < low * Fraction(1, 10**28):
            break
    return low


FOLD = Fraction(32913651889476756, 10**17)
"""k_f to 17 digits, by SymPy's nroots of 128k³+196k²+31k-36."""
COSINES = [
    Fraction(1, 10**8),
    Fraction(1, 10**3),
    Fraction(1, 20),
    Fraction(1, 5),
    Fraction(2, 5),
    Fraction(3, 5),
    Fraction(4, 5),
    Fraction(9, 10),
    Fraction(99, 100),
    Fraction(9999, 10**4),
]


SHAPES = [
    (Fraction(1, 50), "falls"),
    (Fraction(1, 4), "falls"),
    (Fraction(3, 10), "falls"),
    (FOLD - Fraction(1, 10**9), "falls"),
    (FOLD + Fraction(1, 10**9), "minimum"),
    (Fraction(7, 20), "minimum"),
    (Fraction(49, 100), "minimum"),
    (Fraction(1, 2), "rises"),
]


@pytest.mark.parametrize(
    ("k", "shape", "whole"),
    [(*SHAPES[i], False) for i in (1, 5, 7)]
    + [pytest.param(*s, True, marks=pytest.mark.long) for s in SHAPES],
)
def test_the_boundary_of_tumbling_has_the_stated_shape(
    k: Fraction, shape: str, whole: bool
) -> None:
    """Along θ, from flat to upright."""
    with mpmath.workdps(80):
        cosines = sorted([*COSINES, Fraction(1, 10**6), Fraction(1, 10**5)], reverse=True)
        if not whole:
            cosines = [COSINES[i] for i in (6, 5, 3, 1, 0)]
        sines = [rational(mpmath.sqrt(1 - real(c) ** 2)) for c in cosines]
        found = [boundary(k, s) for s in sines]
    finite = [m for m in found if m < 10**15]
    assert len(finite) >= 5 - 2 * (not whole)
    signs = [b > a for a, b in zip(finite[:-1], finite[1:], strict=True)]
    turns = sum(a != b for a, b in zip(signs[:-1], signs[1:], strict=True))
    assert (signs[0], signs[-1], turns) == {
        "falls": (False, False, 0),
        "minimum": (False, True, 1),
        "rises": (True, True, 0),
    }[shape]
    assert abs(finite[-1] / thresholds(k)[1] - 1) < Fraction(1, 10**10)


# --- completeness ---


def any_motion(
    x: Array, k: Array, law: Callable[[Array], Array], per_weight: bool
) -> tuple[Array, Array]:
    """State rates and normal force by Kane's equations, F = law(slip) or normal force times it."""
    system = kane_system("linear-viscous")
    point = [np.sin(x[0]), np.cos(x[0]), 0.0, 1.0, *x[1:], k, 0 * k]

    def stacked(entries: Sequence[Any]) -> Array:
        return np.stack([e + 0 * x[0] for e in entries], axis=-1)

    matrix = np.stack([stacked(row) for row in system.matrix(*point)], axis=-2)
    forcing = stacked(system.forcing(*point))
    force = law(x[4:])
    for i in (0, 1):  # rows of the law: F_i - (N) f_i = 0
        matrix[..., 6 + i, :] = 0
        matrix[..., 6 + i, 6 + i] = 1
        forcing[..., 6 + i] = 0 if per_weight else force[i]
        if per_weight:
            matrix[..., 6 + i, 5] = -force[i]
    solved = np.linalg.solve(matrix, forcing[..., None])[..., 0]
    return stacked(system.rates(*point, *np.moveaxis(solved, -1, 0)[:5])), solved[..., 5]


FORCES: dict[str, tuple[Callable[[Array], Array], bool]] = {
    "turned": (lambda v: -np.stack([v[0] + 2 * v[1], 0.5 * v[1] - 2 * v[0]]), True),
    "cubic": (lambda v: -(v[0] ** 2 + v[1] ** 2 + 0.1 * np.abs(v[0])) * v, True),
    "saturating": (lambda v: -3 * v / np.sqrt(0.01 + v[0] ** 2 + v[1] ** 2), True),
    "anisotropic": (lambda v: -np.stack([4 * v[0], 0.3 * v[1]]), False),
    "none": (lambda v: 0 * v, False),
}
"""Forces with F·v < 0 off v = 0, and one without."""


def steady_roots(name: str, starts: int, seed: int) -> tuple[Array, Array]:
    """Roots (θ, φ̇, ω₃, slip) of the rates by Newton's method, and their k."""
    law, per_weight = FORCES[name]
    rng = np.random.default_rng(seed)
    low, high = np.array([0.1, -4, -4, -2, -2]), np.array([np.pi - 0.1, 4, 4, 2, 2])
    y, k = rng.uniform(low, high, (starts, 5)).T, rng.uniform(0.05, 0.5, starts)

    def residual(y: Array) -> Array:
        x = np.stack([y[0], 0 * y[0], *y[1:]])
        return any_motion(x, k, law, per_weight)[0][..., [1, 2, 3, 4, 5]]

    for _ in range(40):
        value = residual(y)
        steps = 1e-6 * np.eye(5)[:, :, None]
        slopes = [(residual(y + step) - residual(y - step)) / 2e-6 for step in steps]
        change = np.linalg.pinv(np.stack(slopes, axis=-1), rcond=1e-9) @ value[..., None]
        size = np.linalg.norm(change[..., 0], axis=-1, keepdims=True)
        y = y - (change[..., 0] / np.maximum(1, size / 0.5)).T
        y[0] = np.clip(y[0], 0.02, np.pi - 0.02)
    found = np.abs(residual(y)).max(axis=-1) < 1e-9
    found &= (np.sin(y[0]) > 0.05) & (np.abs(y) < 50).all(axis=0)
    return y[:, found], k[found]


def families_of(y: Array, k: Array, near: float = 1e-3) -> dict[str, int]:
    rest = np.abs(y[3:]).max(axis=0) < near
    upright = np.abs(np.cos(y[0])) < near
    rolling = rest & upright & (np.abs(y[1]) < near)
    spinning = rest & upright & (np.abs(y[2]) < near) & ~rolling
    tumbling = rest & ~upright & (np.abs(y[2]) < near)
    tumbling &= np.abs(k * y[1] ** 2 * np.sin(y[0]) - 1) < near
    names = {"rolling": rolling, "spinning": spinning, "tumbling": tumbling}
    counts = {name: int(mask.sum()) for name, mask in names.items()}
    return counts | {"other": y.shape[1] - sum(counts.values())}


@pytest.mark.few(2)
@pytest.mark.parametrize("name", [n for n in FORCES if n != "none"])
@pytest.mark.parametrize("starts", [30, pytest.param(100, marks=pytest.mark.long)])
def test_no_other_steady_motion_is_found_under_several_laws(name: str, starts: int) -> None:
    y, k = steady_roots(name, starts, 5)
    found = families_of(y, k)
    assert found["other"] == 0
    assert found["tumbling"] > 0.02 * starts
    assert found["rolling"] + found["spinning"] > 0.05 * starts


def test_without_friction_the_same_search_finds_other_steady_motions() -> None:
    y, k = steady_roots("none", 20, 6)
    assert families_of(y, k)["other"] > 3


def circling(law: str, count: int, seed: int, off: float = 0.0) -> tuple[Solution, Array]:
    """Motions at random points on the surface of a law, or off it, from inertial components."""
    rng = np.random.default_rng(seed)
    theta, k = rng.uniform(0.2, np.pi - 0.2, count), rng.uniform(0.05, 0.5, count)
    turn = rng.uniform(0.2, 3, count) * rng.choice([-1, 1], count)
    share = 2 * k + (law == "rough")
    s, c = np.sin(theta), np.cos(theta)
    spin = c * (k * turn**2 * s - 1) / (share * turn * s) + off
    zero = 0 * theta
    slip = zero if law == "rough" else spin
    x = np.stack([theta, zero, turn, spin, zero, slip], axis=-1)
    return fixed_axes(law, x, np.stack([k, zero + 1], axis=-1)), x


@pytest.mark.parametrize("law", ["rough", "smooth"])
def test_rough_and_smooth_motions_off_the_surface_are_not_steady(law: str) -> None:
    kept = [0, 1, 2, 3, 5]  # the smooth disk's slip along x̂ is that of a centre at rest
    on, _ = circling(law, 300, 7)
    assert np.abs(on.rates[:, kept]).max() < 1e-10
    for off in (-1e-3, 1e-3):
        off_it, _ = circling(law, 300, 7, off)
        assert np.abs(off_it.rates[:, kept]).max(axis=1).min() > 1e-5


def test_dry_friction_holds_a_steady_motion_exactly_inside_the_cone() -> None:
    on, x = circling("rough", 300, 8)
    product = x[:, 2] * x[:, 3]
    assert on.contact_force[:, 0] == pytest.approx(product, abs=1e-10)
    assert np.abs(on.contact_force[:, 1]).max() < 1e-10
    assert on.normal_force == pytest.approx(1, abs=1e-10)
    k, theta, turn = 0.25, 1.1, 1.5
    s, c = np.sin(theta), np.cos(theta)
    spin = c * (k * turn**2 * s - 1) / ((2 * k + 1) * turn * s)
    start = [theta, 0, turn, spin, 0, 0]
    for factor, stays in ((1.02, True), (0.98, False)):
        run = st.simulate(
            st.Disk(), st.Coulomb(factor * abs(turn * spin)), start, np.linspace(0, 3, 31)
        )
        moved = float(np.abs(run.theta - theta).max())
        assert (moved < 1e-6) == stays


# --- settling ---


def slip_at(x0: Array, k: Array, steps: int = 8, length: float = 0.1) -> Array:
    """Slip of the free disk at four instants, by Runge and Kutta; x0 (4, n) with zero slip."""
    x = np.concatenate([x0, np.zeros((2, x0.shape[1]))]).T
    p = np.stack([k, 0 * k + 1], axis=-1)
    out = []
    for i in range(steps):
        a = fixed_axes("smooth", x, p).rates
        b = fixed_axes("smooth", x + length / 2 * a, p).rates
        c = fixed_axes("smooth", x + length / 2 * b, p).rates
        d = fixed_axes("smooth", x + length * c, p).rates
        x = np.clip(x + length / 6 * (a + 2 * b + 2 * c + d), -20, 20)
        x[:, 0] = np.clip(x[:, 0], 0.1, np.pi - 0.1)  # nearly flat: no motion of interest
        if i % 2:
            out.append(x[:, 4:])
    return np.concatenate(out, axis=1)


def least_slip(nutation: float, seed: int, starts: int = 60) -> float:
    """Least slip at these instants that a search finds among motions with |θ̇| at least this."""
    rng = np.random.default_rng(seed)
    low, high = np.array([0.4, nutation, -2.5, -2.5]), np.array([np.pi - 0.4, 2.5, 2.5, 2.5])
    y, k = rng.uniform(low, high, (starts, 4)).T, rng.uniform(0.1, 0.5, starts)
    best = np.full(starts, np.inf)
    for _ in range(15):
        moved = [y] + [y + 1e-5 * np.eye(4)[:, i : i + 1] for i in range(4)]
        value, *others = np.split(slip_at(np.hstack(moved), np.tile(k, 5)), 5)
        best = np.fmin(best, np.abs(value).max(axis=1))
        slopes = [(other - value) / 1e-5 for other in others]
        matrix = np.nan_to_num(np.stack(slopes, axis=-1), posinf=0, neginf=0)
        change = (np.linalg.pinv(matrix, rcond=1e-6) @ np.nan_to_num(value)[..., None])[..., 0].T
        size = np.maximum(1, np.linalg.norm(change, axis=0) / 0.3)
        y = np.clip(y - change / size, low[:, None], high[:, None])
    return float(best.min())


@pytest.mark.long
def test_no_slip_on_an_interval_without_rest_is_found() -> None:
    """The least slip is found where the disk passes upright with θ̇² = sinθ/(1 + k)."""
    assert least_slip(0.5, 9) > 1e-4
    assert least_slip(0.0, 9) < 1e-7  # without a least θ̇ it finds steady motions


def unsettled(count: int, seed: int, most: float, length: float) -> tuple[int, list[float]]:
    """Number of runs that settled; of those that move on, how far the slip has fallen."""
    rng = np.random.default_rng(seed)
    settled, falls = 0, []
    for _ in range(count):
        k, mu = rng.uniform(0.1, 0.3), 10 ** rng.uniform(-0.5, most)
        theta = rng.uniform(0.5, 1.3)
        start = [theta, 0, (k * np.sin(theta)) ** -0.5, 0, 0, 0] + rng.normal(size=6) * 0.1
        run = st.simulate(st.Disk(k=k), st.Viscous(mu), start, np.linspace(0, length, 401))
        outcome = BY_CODE[int(run.outcome)].word
        settled += outcome == "settled"
        if outcome == "moving":
            slip = np.hypot(run.slip_x.values, run.slip_y.values)
            falls.append(float(slip[300:].max() / slip[100:200].max()))
    return settled, falls


def test_bounded_launches_end_settled() -> None:
    assert unsettled(4, 11, -0.1, 600.0) == (4, [])


@pytest.mark.long
def test_many_bounded_launches_end_settled() -> None:
    """Next to a flutter boundary the slip falls as a power of time: it must still fall."""
    settled, falls = unsettled(200, 12, 0.5, 5000.0)
    assert settled > 150
    assert len(falls) < 20
    assert max(falls, default=0.0) < 0.9


# --- dry friction ---


def response(x: Array, k: Array) -> tuple[Array, Array, Array, Array]:
    """Slip acceleration and normal force without friction, and their change with the force."""
    fixed = [
        any_motion(x, k, lambda v, f=force: 0 * v + np.array(f)[:, None], False)
        for force in ((0.0, 0.0), (1.0, 0.0), (0.0, 1.0))
    ]
    (rates, normal), *others = fixed
    gain = np.stack([r[:, 4:] - rates[:, 4:] for r, _ in others], axis=-1)
    lift = np.stack([n - normal for _, n in others], axis=-1)
    return rates[:, 4:], normal, gain, lift


def continuations_from_rest(x: Array, k: Array, mu: Array) -> tuple[Array, Array]:
    """Number of continuations in contact, and whether the contact is pressed."""
    free, normal, gain, lift = response(x, k)
    lam = np.concatenate([[0.0], np.logspace(-7, 7, 6000)])
    # the linear map of each force, normal force included: A = free + gain F
    shifted = gain[:, None] + lam[None, :, None, None] * np.eye(2)
    right = -np.broadcast_to(free[:, None, :, None], (len(k), len(lam), 2, 1))
    force = np.linalg.solve(shifted, right)[..., 0]
    psi = np.hypot(force[..., 0], force[..., 1])
    psi -= mu[:, None] * (normal[:, None] + np.einsum("nlj,nj->nl", force, lift))
    roots = (np.sign(psi[:, 1:]) != np.sign(psi[:, :-1])).sum(axis=1)
    return roots + (psi[:, 0] < 0), normal > 0


@pytest.mark.parametrize("n", [40, pytest.param(500, marks=pytest.mark.long)])
def test_the_number_of_continuations_from_rest_is_as_stated(n: int) -> None:
    rng = np.random.default_rng(13)
    k = rng.uniform(0.02, 0.5, n)
    speeds = rng.normal(size=(3, n)) * 1.5
    x = np.stack([rng.uniform(0.05, np.pi - 0.05, n), *speeds, np.zeros(n), np.zeros(n)])
    below = 2 * np.sqrt(k * (k + 1)) * (1 - 10 ** rng.uniform(-4, 0, n) * 0.999)
    count, pressed = continuations_from_rest(x, k, below)
    assert (count[pressed] == 1).all()
    assert pressed.sum() > 0.3 * n and (~pressed).sum() > 0.1 * n
    assert (count[~pressed] % 2 == 0).all()
    count, pressed = continuations_from_rest(x, k, below * 10 ** rng.uniform(0, 1, n))
    assert (count % 2 == pressed).all()


def test_just_above_the_threshold_the_same_count_finds_three() -> None:
    """The state of docs/explanation/dry-friction.md: sticking, and slip in two directions."""
    start = [
        1.1405036155603199,
        -0.003713908095680414 * 0.9999,
        1.82547123230798,
        1.1032082780622803,
        0,
        0,
    ]
    x, k = np.array(start)[:, None], np.array([0.25])
    count, pressed = continuations_from_rest(x, k, np.array([1.1191520227386447]))
    assert pressed.all()
    assert count.tolist() == [3]


def test_d_runs_to_zero_in_slip_exactly_where_stated() -> None:
    """dD/dt times D next to D = 0 from Kane's equations, against the formula."""
    rng = np.random.default_rng(14)
    n = 400
    k, theta = rng.uniform(0.05, 0.5, n), rng.uniform(0.2, np.pi - 0.2, n)
    s, c = np.sin(theta), np.cos(theta)
    across = rng.uniform(0.2, 0.95, n)  # |cos a|
    u, v = across * np.sign(c), np.sqrt(1 - across**2) * rng.choice([-1, 1], n)
    small, speed = 1e-9, 0.7
    mu = (k + c * c) * (1 - small) / (s * c * u)
    x = np.stack([theta, *rng.normal(size=(3, n)), speed * u, speed * v])
    rates, normal = any_motion(x, k, lambda slip: -mu * slip / np.hypot(*slip), True)
    d = k + c * c - mu * s * c * u
    turn = (x[4] * rates[:, 5] - x[5] * rates[:, 4]) / speed**2
    d_dot = -2 * s * c * x[1] - mu * (c * c - s * s) * x[1] * u + mu * s * c * v * turn
    weight = normal * d
    stated = mu * weight * v * v * (k - (2 * k + 1) * c * c) / (2 * k * speed)
    assert d * d_dot == pytest.approx(stated, rel=1e-4, abs=1e-5)
    clear = (np.abs(stated) > 1e-3) & (weight > 0)
    falls = c * c > k / (2 * k + 1)
    assert ((d_dot < 0) == falls)[clear].all()
    assert falls[clear].sum() > 20 and (~falls[clear]).sum() > 20
