"""Theorems: at which rates a body of revolution spins stably about its vertical axis."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import sympy

from stability.derivation.characteristic import COS, MU, SIN

from ..body_polynomials import (
    AXIAL,
    BEND,
    I1,
    I3,
    RADIUS,
    RHO,
    SLOPE,
    SQUARE,
    H,
    R,
    Z,
)
from ..mechanics import along, same_linearisation, vanishes
from ..proof import POLE_TESTS, Proof, Theorem
from ..signs import sign
from .graph import RATE
from .polynomials import FREQUENCY, bilharz, vertical

Expr = Any
"""A SymPy expression; SymPy states no types."""
LEVER = I3 * H - I1 * RHO
THRESHOLD = RATE**2 * RHO * LEVER + H**2 * (RHO - H)
"""Positive where vertical spin is stable under viscous friction; h′′ = ρ - h."""
WITHOUT_SLIP = RATE**2 * (I3 + H * RHO) ** 2 + 4 * (I1 + H**2) * BEND
"""Positive where vertical spin without slip is neutral."""
WITHOUT_FRICTION = RATE**2 * I3**2 + 4 * I1 * BEND
"""Positive where vertical spin without friction is neutral."""
SECOND = RATE**2 * (I3 + H * RHO) * LEVER + H * (I1 + H**2) * (RHO - H)
"""B4 without its positive factor."""
CURVED = {BEND: RHO - H}
SMOOTH_POLE = "h is a smooth function of cosθ at the pole, θ = 0 or π; h > 0, ρ = h + h′′ ≥ 0"
T, U = sympy.symbols("t u")


@lru_cache(maxsize=1)
def vertical_viscous() -> Theorem:
    """Vertical spin under viscous friction, for every mu."""
    proof = Proof()
    nabla: list[Expr] = []

    def determinants() -> tuple[bool, str]:
        found = bilharz(*vertical("viscous").on_axis(), 3)
        nabla.extend(sympy.factor(d.subs(CURVED)) for d in found)
        return len(nabla) == 3 and vertical("viscous").zeros == 1, "; ".join(map(str, nabla))

    proof.step(
        "λ = 0 once, the roots of a complex cubic, and their conjugates; B2, B4, B6 of the cubic",
        "the graph around the pole, which turns with the vertical; the product with the conjugate "
        "is the real polynomial; both poles agree",
        determinants,
    )
    proof.step("B2 = mu I1 (I1+h²) > 0, B4 = mu² I1 h Y, B6 = mu³ I1 h² h′′² T, with "
               "Y = n² (I3 + h ρ) (I3 h - I1 ρ) + h h′′ (I1+h²)", "identity",
               lambda: _determinants(nabla))  # fmt: skip
    proof.step("T < 0: B6 < 0, so the signs of 1, B2, B4, B6 change once: one root of the cubic "
               "lies to the right", "Bilharz", lambda: sign(nabla[0]) == 1)  # fmt: skip
    proof.step("ρ Y = (I3 + h ρ) T + h h′′ (I1 ρ - I3 h)", "identity",
               lambda: vanishes((RHO * SECOND - (I3 + H * RHO) * THRESHOLD
                                 + H * BEND * LEVER).subs(CURVED)))  # fmt: skip
    proof.step("T > 0, h′′ < 0: I3 h > I1 ρ and ρ > 0, so Y > 0",
               "T is at most h² h′′ < 0 otherwise; then the last identity", _falling)  # fmt: skip
    proof.step("T > 0, h′′ > 0: ρ > h > 0, and Y > 0 whether I3 h ≥ I1 ρ or not",
               "both terms of Y; the last identity", _rising)  # fmt: skip
    proof.step("so T > 0: 1, B2, B4, B6 have one sign, and all roots of the cubic lie to the left",
               "Bilharz", lambda: all(s.proved for s in proof.steps))  # fmt: skip
    proof.step("T = h² S(n ρ/h) = h² R(n ρ/h), with S and R the polynomials in ν without friction "
               "and without slip, λ = i ν, which are h′′ at ν = 0 and fall for large ν",
               "identity; so both have real roots where T > 0", _neutral)  # fmt: skip
    proof.step("T = 0 with h′′ ≠ 0: the cubic has the root i n ρ/h; there tumbling ends at the "
               "pole, with φ̇ = n ρ/h", "identity; limit of the closed form of tumbling",
               _meets)  # fmt: skip
    proof.step("linear viscous friction with c = mu has the same linearisation",
               "first derivatives of both forces at vA = 0, gn = 1",
               same_linearisation)  # fmt: skip
    return Theorem(
        "vertical spin with viscous friction, for every mu",
        ("Let T = n² ρ (I3 h - I1 ρ) + h² h′′ at the pole, n = omega_Z. Vertical spin is stable "
         "where T > 0, and unstable where T < 0, with two eigenvalues on the right; mu does not "
         "enter.",
         "At h′′ < 0 a body with I3 h > I1 ρ > 0 is stable for n² > -h² h′′/(ρ (I3 h - I1 ρ)); any "
         "other is never stable.",
         "At h′′ > 0 a body with I3 h ≥ I1 ρ is always stable; with I3 h < I1 ρ it is stable for "
         "n² < h² h′′/(ρ (I1 ρ - I3 h)).",
         "Where T > 0 vertical spin is neutral without slip and without friction too.",
         "Tumbling branches off at T = 0."),
        (SMOOTH_POLE, "h′′ ≠ 0, mu > 0; m = g = 1; viscous or linear viscous friction",
         "stable: every eigenvalue but the structural zero has a negative real part"),
        tuple(proof.steps),
        (f"{POLE_TESTS}::test_vertical_spin_is_stable_exactly_where_the_theorem_says",
         f"{POLE_TESTS}::test_exact_jacobians_of_another_formulation_have_the_printed_polynomial"),
    )  # fmt: skip


def _determinants(nabla: list[Expr]) -> bool:
    wanted = (MU * I1 * (I1 + H**2), MU**2 * I1 * H * SECOND,
              MU**3 * I1 * H**2 * BEND**2 * THRESHOLD)  # fmt: skip
    return all(vanishes(a - b.subs(CURVED)) for a, b in zip(nabla, wanted, strict=True))


def _falling() -> bool:
    """At h = ρ + t: T < 0 unless I3 h > I1 ρ > 0, and then both terms of ρ Y are positive."""
    high = {H: RHO + T}
    less = {I3: (I1 * RHO - U) / H}
    none = ({**less, RATE: 0}, less, {I3: I1 * RHO / H}, {RHO: 0})
    other = (I1 * RHO - I3 * H) * (RHO - H)
    return all(sign(THRESHOLD.subs(case).subs(high)) == -1 for case in none) and (
        sign(other.subs(I3, (I1 * RHO + U) / H).subs(high)) == 1
    )


def _rising() -> bool:
    """At ρ = h + t: both terms of Y where I3 h ≥ I1 ρ, otherwise both of ρ Y, are positive."""
    low = {RHO: H + T}
    more = {I3: (I1 * RHO + U) / H}
    every = ({**more, RATE: 0}, more, {I3: I1 * RHO / H})
    other = (I1 * RHO - I3 * H) * (RHO - H)
    return all(sign(SECOND.subs(case).subs(low)) == 1 for case in every) and (
        sign(other.subs(I3, (I1 * RHO - U) / H).subs(low)) == 1
    )


def _at(polynomial: sympy.Poly, value: Expr) -> Expr:
    return polynomial.eval(value).subs(CURVED)


def _neutral() -> bool:
    found = []
    for law in ("smooth", "rough"):
        real, imaginary = vertical(law).on_axis()
        found.append(
            imaginary.is_zero
            and sign(-real.LC()) == 1
            and vanishes(real.nth(0) - BEND)
            and vanishes(H**2 * _at(real, RATE * RHO / H) - THRESHOLD)
        )
    return all(found)


def _meets() -> bool:
    real, imaginary = vertical("viscous").on_axis()
    place = RATE * RHO / H
    divides = (
        vanishes(_at(real, place) - MU * THRESHOLD / H**2)
        and vanishes(_at(imaginary, place) - place * THRESHOLD / H**2)
    )  # fmt: skip
    # tumbling at θ = t → 0: r → ρ t and z → h, from their slopes along θ; the ratio has no t left
    pole = {SLOPE: 0, SIN: 0, COS: 1}
    near = vanishes(along(RADIUS).subs(pole).subs(CURVED) - RHO) and vanishes(AXIAL.subs(pole) - H)
    square = sympy.cancel(SQUARE.subs({R: RHO * T, Z: H, SIN: T, COS: 1}, simultaneous=True))
    rate = square * (H / RHO) ** 2  # n = ω₃ = φ̇ sinθ z/r
    return divides and near and vanishes(THRESHOLD.subs(RATE**2, rate))


@lru_cache(maxsize=1)
def vertical_conservative() -> Theorem:
    """Vertical spin without slip, and without friction."""
    proof = Proof()
    proof.step(
        "without slip: (I1+h²) λ² - i n (I3 + h ρ) λ + h′′ = 0, its conjugate, and λ = 0 once",
        "the graph around the pole; both poles agree",
        lambda: _equals("rough", (I1 + H**2, -RATE * (I3 + H * RHO), BEND)),
    )
    proof.step(
        "without friction: I1 λ² - i n I3 λ + h′′ = 0, its conjugate, and λ = 0 once",
        "the same",
        lambda: _equals("smooth", (I1, -RATE * I3, BEND)),
    )
    proof.step(
        "λ = i ν turns each into a real quadratic in ν, whose discriminant is the condition",
        "identity; both roots ν are real where it is positive, and conjugate where it is negative",
        _discriminants,
    )
    return Theorem(
        "vertical spin without slip, or without friction",
        ("Vertical spin without slip is neutral where n² (I3 + h ρ)² + 4 (I1+h²) h′′ > 0, and "
         "unstable where this is negative.",
         "Vertical spin without friction is neutral where n² I3² + 4 I1 h′′ > 0, and unstable "
         "where this is negative.",
         "At h′′ > 0, where the height is least, both are neutral for every n."),
        (SMOOTH_POLE, "h′′ ≠ 0; m = g = 1",
         "neutral: every eigenvalue but the structural zero is on the imaginary axis"),
        tuple(proof.steps),
        (f"{POLE_TESTS}::test_vertical_spin_is_neutral_exactly_where_the_theorem_says",),
    )  # fmt: skip


def _equals(law: str, wanted: tuple[Expr, Expr, Expr]) -> bool:
    found = vertical(law)
    lead, middle, last = wanted
    pairs = zip(found.coefficients, ((lead, 0), (0, middle), (last, 0)), strict=True)
    return found.zeros == 1 and all(
        vanishes((a - b).subs(RHO, H + BEND))
        for got, right in pairs
        for a, b in zip(got, right, strict=True)
    )


def _discriminants() -> bool:
    found = []
    for law, condition in (("rough", WITHOUT_SLIP), ("smooth", WITHOUT_FRICTION)):
        real, imaginary = vertical(law).on_axis()
        discriminant = sympy.Poly(real, FREQUENCY).discriminant()
        found.append(imaginary.is_zero and vanishes(discriminant - condition.subs(RHO, H + BEND)))
    return all(found)
