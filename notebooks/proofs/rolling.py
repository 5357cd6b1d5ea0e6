"""Theorems: which rolling bodies of revolution are stable, by the height's second derivative."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import sympy

from stability.derivation.characteristic import COS, LAM, MU, SIN

from .body_polynomials import BEND, I1, I3, RHO, SPIN, H, characteristic
from .mechanics import same_linearisation, vanishes
from .proof import BODY_TESTS, Proof, Theorem
from .signs import sign

Expr = Any
"""A SymPy expression; SymPy states no types."""
Q = I1 * I3 + H**2 * (I1 * SIN**2 + I3 * COS**2)
WITHOUT_SLIP = BEND * Q + I3 * (I3 + H**2) * (I3 + H**2 + H * BEND * COS**2) * SPIN**2
"""Positive where rolling without slip is neutral."""
WITHOUT_FRICTION = I1 * BEND + I3**2 * SPIN**2
"""Positive where rolling without friction is neutral."""
FLUTTER = I1 * BEND + I3 * (I3 - I1) * SPIN**2
"""Positive where upright rolling is stable under viscous friction."""
STATIC = I1 * BEND + I3 * (I3 + H**2) * SPIN**2
"""Positive where the constant term of upright rolling is, without slip and under friction."""
UPRIGHT = {SIN: 1, COS: 0}


@lru_cache(maxsize=1)
def rolling_conservative() -> Theorem:
    """Rolling at any inclination without slip, and without friction."""
    proof = Proof()
    proof.step(
        "without slip: (I1 + h²) Q λ² + h′′ Q + I3 (I3+h²) (I3 + h² + h h′′ c²) ω₃² = 0, and λ = 0 "
        "twice, with Q = I1 I3 + h² (I1 s² + I3 c²)",
        "characteristic polynomial of the general graph at h′ = 0",
        lambda: _equals("rough", (I1 + H**2) * Q, WITHOUT_SLIP),
    )
    proof.step(
        "I3 + h² + h h′′ c² = I3 + h² s² + h (h + h′′) c² > 0",
        "identity; h + h′′ ≥ 0 is the radius of curvature of a convex body",
        lambda: (
            vanishes(H**2 + H * BEND * COS**2 - H**2 * SIN**2 - H * (H + BEND) * COS**2)
            and sign((I3 + H**2 * SIN**2 + H * RHO * COS**2) * Q) == 1
        ),
    )
    proof.step(
        "without friction: I1² λ² + I1 h′′ + I3² ω₃² = 0, and λ = 0 twice",
        "characteristic polynomial of the general graph at h′ = 0",
        lambda: _equals("smooth", I1**2, WITHOUT_FRICTION),
    )
    proof.conclude(
        "a threshold ω₃² exists for every convex body with h′′ < 0, and none where h′′ > 0",
        "the steps above: the factors of ω₃² are positive",
    )
    return Theorem(
        "rolling without slip, or without friction",
        ("Rolling without slip is neutral where ω₃² > -h′′ Q/(I3 (I3+h²) (I3 + h² + h h′′ c²)), "
         "and unstable below.",
         "Upright this is ω₃² > -I1 h′′/(I3 (I3+h²)).",
         "Rolling without friction is neutral where ω₃² > -I1 h′′/I3², and unstable below, at any "
         "inclination.",
         "At h′′ > 0, where the height is least, both are neutral for every ω₃."),
        ("h′ = 0 at θ, 0 < θ < π, h > 0, h + h′′ ≥ 0; m = g = 1",
         "neutral: every eigenvalue but the two structural zeros is on the imaginary axis"),
        tuple(proof.steps),
        (f"{BODY_TESTS}::test_rolling_turns_at_the_printed_threshold",),
    )  # fmt: skip


def _equals(law: str, lead: Expr, constant: Expr) -> bool:
    found = characteristic("rolling", law)
    wanted = (lead, 0, constant)
    pairs = zip(found.coefficients, wanted, strict=True)
    return found.zeros == 2 and all(vanishes(a - b) for a, b in pairs)


@lru_cache(maxsize=1)
def rolling_viscous() -> Theorem:
    """Upright rolling under viscous friction, for every mu."""
    proof = Proof()
    cubic: list[Expr] = []

    def splits() -> tuple[bool, str]:
        found = characteristic("rolling", "viscous")
        upright = sympy.Poly(found.polynomial.as_expr().subs(UPRIGHT), LAM)
        other = sympy.Poly((I3 + H**2) * MU + I3 * LAM, LAM)
        quotient, rest = sympy.div(upright, other)
        cubic.extend(quotient.all_coeffs())
        return found.zeros == 2 and rest.is_zero, "; ".join(map(str, map(sympy.factor, cubic)))

    proof.step(
        "at s = 1 the polynomial is λ² (I3 λ + (I3+h²) mu) times a cubic a0 λ³ + a1 λ² + a2 λ + a3",
        "characteristic polynomial of the general graph at h′ = 0, division",
        splits,
    )
    proof.step(
        "a0 > 0, a1 > 0, and a3 = mu (I1 h′′ + I3 (I3+h²) ω₃²)",
        "coefficients of one sign; identity",
        lambda: sign(cubic[0]) == sign(cubic[1]) == 1 and vanishes(cubic[3] - MU * STATIC),
    )
    proof.step(
        "a1 a2 - a0 a3 = mu I1 h² (I1 h′′ + I3 (I3-I1) ω₃²)",
        "identity",
        lambda: vanishes(cubic[1] * cubic[2] - cubic[0] * cubic[3] - MU * I1 * H**2 * FLUTTER),
    )
    proof.step(
        "where this is positive, a3 is: the two differ by I3 (I1+h²) ω₃²",
        "identity",
        lambda: vanishes(STATIC - FLUTTER - I3 * (I1 + H**2) * SPIN**2),
    )
    proof.step(
        "linear viscous friction with c = mu has the same linearisation",
        "first derivatives of both forces at vA = 0, gn = 1",
        same_linearisation,
    )
    proof.conclude(
        "the sign of I1 h′′ + I3 (I3-I1) ω₃² decides for every mu > 0", "Routh and Hurwitz"
    )
    return Theorem(
        "upright rolling with viscous friction, for every mu",
        ("Upright rolling is stable where I3 (I3-I1) ω₃² + I1 h′′ > 0, and unstable where this is "
         "negative; mu does not enter.",
         "At h′′ < 0 a body with I3 > I1 is stable for ω₃² > -I1 h′′/(I3 (I3-I1)); with I3 ≤ I1 it "
         "is never stable.",
         "At h′′ > 0 a body with I3 ≥ I1 is always stable; with I3 < I1 it is stable for "
         "ω₃² < I1 h′′/(I3 (I1-I3))."),
        ("h′(π/2) = 0, h > 0, mu > 0; m = g = 1; viscous or linear viscous friction",
         "stable: every eigenvalue but the two zeros has a negative real part"),
        tuple(proof.steps),
        (f"{BODY_TESTS}::test_rolling_turns_at_the_printed_threshold",),
    )  # fmt: skip
