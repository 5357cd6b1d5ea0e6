"""Theorems: what energy says about steady motions of every body, tumbling first."""

from __future__ import annotations

from functools import lru_cache, partial
from typing import Any

import sympy
from sympy.polys.matrices import DomainMatrix

from stability.derivation.characteristic import COS, LAM, MU, SIN

from .body_polynomials import (
    AXIAL,
    BEND,
    CENTRE,
    FORCE_X,
    FORCE_Y,
    I1,
    I3,
    PAIRS,
    PHI,
    PHI_DDOT,
    RADIUS,
    RHO,
    SLOPE,
    SPIN,
    SPIN_DOT,
    SQUARE,
    THETA_DDOT,
    THETA_DOT,
    H,
    R,
    Z,
    characteristic,
    equations,
    folded,
    pencil,
)
from .mechanics import NO_SLIP, along, power_theorem, vanishes
from .proof import BODY_TESTS, POLE_TESTS, Proof, Theorem
from .signs import sign
from .steady_motions import MOMENT, RIM, SURFACE

Expr = Any
"""A SymPy expression; SymPy states no types."""


@lru_cache(maxsize=1)
def tumbling_static() -> Theorem:
    """The static boundary of tumbling under viscous friction lies where energy is stationary."""
    proof = Proof()
    proof.step("the energy's gradient is a left eigenvector of λ = 0 where vA = 0",
               "dE/dt = F·vA, which is of second order in the slip", power_theorem)  # fmt: skip
    proof.step("along tumbling dr/dθ = ρ cosθ and dz/dθ = -ρ sinθ", "derivatives along θ",
               lambda: vanishes(along(RADIUS) - (H + BEND) * COS)
               and vanishes(along(AXIAL) + (H + BEND) * SIN))  # fmt: skip
    proof.step("the coefficient of λ is 2 mu (r⁴/s²) h′ dE/dθ",
               "identity with φ̇² of tumbling inserted", _static)  # fmt: skip
    proof.step("the highest coefficient is positive",
               "I1 I3 r² (I1 + h′²)", _leading)  # fmt: skip
    return Theorem(
        "tumbling with viscous friction: the static boundary",
        ("Tumbling has a positive real eigenvalue for every mu where h′ dE/dθ < 0, with E the "
         "energy along the family: it must rise with θ where h does.",
         "An eigenvalue but the structural one is zero exactly where dE/dθ = 0 along the family."),
        ("h′ ≠ 0, r > 0, I1 r cosθ ≠ I3 z sinθ, mu > 0; m = g = 1",
         "the flutter condition follows from the printed polynomial and has no theorem here"),
        tuple(proof.steps),
        (f"{BODY_TESTS}::test_tumbling_has_its_static_boundary_where_energy_is_stationary",),
    )  # fmt: skip


def energy_slope() -> Expr:
    """dE/dθ along tumbling, in r, z, ρ, s and c."""
    height = CENTRE[H]
    energy = height + (I1 * SQUARE * SIN**2 + I3 * SQUARE * (SIN * Z / R) ** 2) / 2
    turned = energy.diff(SIN) * COS - energy.diff(COS) * SIN
    return turned + energy.diff(R) * RHO * COS - energy.diff(Z) * RHO * SIN


def _static() -> bool:
    found = characteristic("tumbling", "viscous")
    poly = sympy.Poly(found.coefficients[-1], PHI)
    inserted = sum(c * SQUARE ** (n // 2) for (n,), c in poly.terms())
    return vanishes(inserted - 2 * MU * R**4 / SIN**2 * CENTRE[SLOPE] * energy_slope())


def _leading() -> bool:
    lead = characteristic("tumbling", "viscous").coefficients[0]
    wanted = I1 * I3 * R**2 * (I1 + CENTRE[SLOPE] ** 2)
    return vanishes(lead - wanted)


@lru_cache(maxsize=1)
def energy_decides() -> Theorem:
    """Without slip and without friction the second variation of energy is -λ²."""
    proof = Proof()
    for law, words in (("rough", "without slip: V′′ = -(I1 + h² + h′²) λ²"),
                       ("smooth", "without friction: V′′ = -(I1 + h′²) λ²")):  # fmt: skip
        proof.step(f"{words}, with V the energy at θ̇ = 0 on the curve in (θ, φ̇, ω₃) on which a "
                   "motion stays",
                   "φ̈/θ̇ and ω̇₃/θ̇ from the graph, two derivatives along θ, λ² from its pencil",
                   partial(_second, law))  # fmt: skip
    proof.step("V′ is the left side of the equation of steady motion, without slip and without "
               "friction", "derivative along the curve",
               lambda: _first("smooth", MOMENT) and _first("rough", SURFACE))  # fmt: skip
    return Theorem(
        "energy decides without slip, and without friction",
        ("A steady motion is neutral exactly where energy has a strict minimum among the motions "
         "with the same integrals, and unstable where it has a maximum.",
         "So neutral members are stable in the sense of Lyapunov in θ, θ̇, φ̇ and ω₃: under the full "
         "equations, not the linearised ones alone."),
        ("0 < θ < π, h > 0, r > 0; λ² ≠ 0; the integrals are linear in φ̇ and ω₃, by two linear "
         "differential equations in θ",),
        tuple(proof.steps),
        (f"{BODY_TESTS}::test_energy_is_least_at_neutral_members",),
    )  # fmt: skip


@lru_cache(maxsize=1)
def surfaces_neutral() -> Theorem:
    """Which motions of the surfaces without slip and without friction are neutral."""
    proof = Proof()
    proof.step("circling: λ² (a λ² + K) = 0, a = s (I1 + r² + z²) (I1 I3 + I1 r² + I3 z²) > 0",
               "characteristic polynomial of the general graph, coefficients of one sign",
               lambda: _lead("circling", SIN * (I1 + R**2 + Z**2)
                             * (I1 * I3 + I1 * R**2 + I3 * Z**2)))  # fmt: skip
    proof.step("precession: λ² (a λ² + K) = 0, a = I1 (I1 + h′²) > 0", "the same",
               lambda: _lead("precession", I1 * (I1 + SLOPE**2)))  # fmt: skip
    proof.step("where the centre rests, K of circling is s/r² times the constant term of tumbling "
               "without slip", "identity with ω₃ = φ̇ s z/r", _rests_too)  # fmt: skip
    proof.step("precession: K = I1² φ̇² + I1 (h′′ + h′ c/s) + (h′/(φ̇ s))²",
               "identity with I3 ω₃ = I1 φ̇ c - h′/(φ̇ s)", _precession)  # fmt: skip
    proof.step("I1² φ̇² + (h′/(φ̇ s))² ≥ 2 I1 |h′|/s, with equality at I1 φ̇² = |h′|/s",
               "the difference is a square", lambda: vanishes(
                   I1**2 * PHI**2 + (SLOPE / (PHI * SIN)) ** 2 - 2 * I1 * SLOPE / SIN
                   - (I1 * PHI - SLOPE / (PHI * SIN)) ** 2))  # fmt: skip
    return Theorem(
        "circling without slip, and precession without friction",
        ("Circling without slip is neutral where K > 0, and unstable where K < 0, with K the "
         "coefficient of λ⁰ that is printed among the polynomials.",
         "Precession without friction is neutral where I1² φ̇² + I1 (h′′ + h′ cosθ/sinθ) + "
         "(h′/(φ̇ sinθ))² > 0, and unstable where this is negative; the axial moment does not "
         "enter.",
         "It is neutral for every φ̇ ≠ 0 where h′′ sinθ + h′ cosθ + 2 |h′| > 0."),
        ("0 < θ < π, h > 0, r > 0, φ̇ ≠ 0; m = g = 1; ω₃ from the surface of steady motions",
         "neutral: every eigenvalue but the two structural zeros is on the imaginary axis"),
        tuple(proof.steps),
        (f"{POLE_TESTS}::test_circling_and_precession_turn_where_the_theorem_says",),
    )  # fmt: skip


def _lead(family: str, wanted: Expr) -> bool:
    found = characteristic(family, PAIRS[family])
    even = found.zeros == 2 and len(found.coefficients) == 3 and found.coefficients[1] == 0
    return even and vanishes(found.coefficients[0] - wanted) and sign(wanted) == 1


def _rests_too() -> bool:
    circling = characteristic("circling", "rough").coefficients[-1]
    resting = circling.subs(SPIN, PHI * SIN * Z / R) * R**2 / SIN
    return vanishes(resting - characteristic("tumbling", "rough").coefficients[-1])


def _precession() -> bool:
    constant = characteristic("precession", "smooth").coefficients[-1]
    inserted = constant.subs(SPIN, (I1 * PHI * COS - SLOPE / (PHI * SIN)) / I3)
    wanted = I1**2 * PHI**2 + I1 * (BEND + SLOPE * COS / SIN) + (SLOPE / (PHI * SIN)) ** 2
    return vanishes(inserted - wanted)


@lru_cache(maxsize=2)
def turns(law: str) -> tuple[Expr, Expr, Expr]:
    """dφ̇/dθ, dω₃/dθ along a motion without slip or without friction, and their denominator."""
    rows = [r.subs(NO_SLIP).subs(THETA_DDOT, 0) for r in equations(law).rows]
    across = rows[1:6:2] if law == "rough" else (rows[1], rows[3])
    unknown = [PHI_DDOT, SPIN_DOT] + [FORCE_Y] * (law == "rough")
    # each row is linear in these and θ̇; Cramer's rule
    matrix = sympy.Matrix([[r.diff(x) for x in unknown] for r in across])
    right = sympy.Matrix([-r.diff(THETA_DOT) for r in across])
    found = []
    for place in range(2):
        own = matrix.copy()
        own[:, place] = right
        found.append(folded(own.det(method="berkowitz")))
    return found[0], found[1], folded(matrix.det(method="berkowitz"))


def follow(law: str, expression: Expr) -> tuple[Expr, Expr]:
    """The derivative of an expression along a motion's curve at θ̇ = 0, as a fraction."""
    phi, spin, bottom = turns(law)
    top = along(expression) * bottom + expression.diff(PHI) * phi + expression.diff(SPIN) * spin
    return folded(top), bottom


def _first(law: str, steady: Expr) -> bool:
    """Whether V′ is the left side of the equation of steady motion."""
    top, bottom = follow(law, equations(law).energy.subs(THETA_DOT, 0))
    return bool(folded(top - steady * bottom) == 0)


def _second(law: str) -> bool:
    """Whether V′′ is -λ² times the mass, on the surface of steady motions."""
    rough = law == "rough"
    inertia = I1 + SLOPE**2 + (H**2 if rough else 0)
    matrix = DomainMatrix.from_Matrix(pencil(law).subs(FORCE_X, PHI * RIM).expand())
    poly = sympy.Poly(folded(matrix.domain.to_sympy(matrix.det())), LAM)
    steady = SURFACE if rough else MOMENT  # V′ itself
    second = follow(law, steady)
    top = second[0] * poly.nth(4) - inertia * poly.nth(2) * second[1]
    inserted = folded(top.subs(CENTRE | {BEND: RHO - CENTRE[H]}, simultaneous=True))
    line = sympy.Poly(steady.subs(CENTRE, simultaneous=True), SPIN)
    root, lead = -line.nth(0), line.nth(1)
    terms = sympy.Poly(inserted, SPIN)
    whole = sum(c * root**n * lead ** (terms.degree() - n) for (n,), c in terms.terms())
    return {n for (n,) in poly.monoms()} == {2, 4} and bool(folded(whole) == 0)
