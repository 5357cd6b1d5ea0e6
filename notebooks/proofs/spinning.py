"""Theorems: which spinning bodies of revolution are stable, for every body and every mu.

The length is h(π/2).  So I1 and I3 are over m h², ρ is over h, M = mu² g h, and q = φ̇² h/g.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import sympy

from stability.derivation.characteristic import MU, SQUARE, M
from stability.derivation.hurwitz import determinant

from .body_polynomials import (
    BEND,
    I1,
    I3,
    PHI,
    RHO,
    Characteristic,
    H,
    characteristic,
)
from .mechanics import same_linearisation, vanishes
from .proof import BODY_TESTS, Proof, Theorem
from .signs import sign

Expr = Any
"""A SymPy expression; SymPy states no types."""
EXCESS, T, U = sympy.symbols("v t u")
UNIT = {H: 1, BEND: RHO - 1}
WITHOUT_SLIP = (I1 + H**2) * PHI**2 + BEND
"""Positive where spinning without slip is neutral."""
WITHOUT_FRICTION = I1 * PHI**2 + BEND
"""Positive where spinning without friction is neutral."""
STATIC = (I1 * H - I3 * (H + BEND)) * PHI**2 + BEND * H
"""Positive where the constant term under viscous friction is."""
EDGE = (1 - RHO) / (I1 - I3 * RHO)
"""q where `STATIC` vanishes."""
M1 = 2 * I3 * (1 + RHO) / ((1 + I3) * (2 * I1 + 1 + RHO))
"""Limit of M for fast spinning."""
M2 = 2 * (1 - RHO) * I3**2 * (I1 + I3) / ((1 + I3) * (I3 - I1) * (I1 + I3 + 2 * I1 * I3))
"""Limit of M just above the static boundary, for I3 > I1."""
FLAT = {I1: I3 / (1 + T), RHO: 1 / ((1 + T) * (1 + U))}
"""I3 > I1 > I3 ρ, ρ > 0."""
ROUND = {I1: I3 * (1 + T), RHO: 1 / (1 + U)}
"""I1 > I3, 0 < ρ < 1."""
SHARP = ({I1: I3 / (1 + T), RHO: 0}, {I1: I3 * (1 + T), RHO: 0})
EQUAL = ({I1: I3, RHO: 1 / (1 + U)}, {I1: I3, RHO: 0})
EVERY = (FLAT, ROUND, *SHARP, *EQUAL)
"""Every body with 0 ≤ ρ < 1 and I1 > I3 ρ."""
FLATTER = (FLAT, SHARP[0])
"""Those with I3 > I1."""


@lru_cache(maxsize=1)
def spinning_conservative() -> Theorem:
    """Spinning without slip, and without friction."""
    proof = Proof()
    proof.step(
        "without slip: (I1+h²) λ² + (I1+h²) φ̇² + h′′ = 0, and λ = 0 twice",
        "characteristic polynomial of the general graph at h′ = 0, θ = π/2",
        lambda: _equals("rough", (I1 + H**2, 0, WITHOUT_SLIP)),
    )
    proof.step(
        "without friction: I1 λ² + I1 φ̇² + h′′ = 0, and λ = 0 twice",
        "the same",
        lambda: _equals("smooth", (I1, 0, WITHOUT_FRICTION)),
    )
    return Theorem(
        "spinning without slip, or without friction",
        ("Spinning without slip is neutral for φ̇² > -h′′/(I1+h²), and unstable below.",
         "Spinning without friction is neutral for φ̇² > -h′′/I1, and unstable below.",
         "The axial moment does not enter."),
        ("h′(π/2) = 0, h > 0; m = g = 1",
         "neutral: every eigenvalue but the two structural zeros is on the imaginary axis"),
        tuple(proof.steps),
        (f"{BODY_TESTS}::test_spinning_turns_at_the_printed_threshold",),
    )  # fmt: skip


def _equals(law: str, wanted: tuple[Expr, ...]) -> bool:
    found = characteristic("spinning", law)
    pairs = zip(found.coefficients, wanted, strict=True)
    return found.zeros == 2 and all(vanishes(a - b) for a, b in pairs)


def conditions(found: Characteristic) -> tuple[tuple[str, Expr], ...]:
    """Polynomials of a polynomial in λ that must all be positive, after Liénard and Chipart.

    Source: F. R. Gantmacher, The Theory of Matrices, vol. 2, ch. XV § 13.
    """
    poly, n = found.polynomial, len(found.coefficients) - 1
    out = [(f"coefficient of λ^{n - i}", found.coefficients[i]) for i in range(n, -1, -2)]
    return (
        *out,
        *((f"Hurwitz determinant {i}", determinant(poly, i)) for i in range(n - 1, 0, -2)),
    )


@lru_cache(maxsize=1)
def deciding() -> dict[str, Expr]:
    """Conditions of Liénard and Chipart for spinning under viscous friction, h = 1, in M and q."""
    found = {}
    for name, value in conditions(characteristic("spinning", "viscous")):
        inserted = sympy.Poly(sympy.expand(value.subs(UNIT)), MU, PHI)
        low = min(i for i, _ in inserted.monoms())
        terms = [c * M ** ((i - low) // 2) * SQUARE ** (j // 2) for (i, j), c in inserted.terms()]
        if any((i - low) % 2 or j % 2 for i, j in inserted.monoms()):
            raise ValueError("a condition is not even in mu and φ̇")
        found[name] = sympy.factor(sympy.Add(*terms))
    return found


@lru_cache(maxsize=1)
def flutter() -> tuple[Expr, Expr, Expr]:
    """(a2, a1, a0) of the flutter polynomial in v = q - `EDGE`."""
    whole = deciding()["Hurwitz determinant 4"]
    inner = sympy.cancel(whole / (1 - RHO) ** 2)
    poly = sympy.Poly(sympy.expand(inner.subs(SQUARE, EXCESS + EDGE)), EXCESS)
    if poly.degree() != 2:
        raise ValueError(f"the condition has degree {poly.degree()} in v, not 2")
    a2, a1, a0 = (sympy.factor(c) for c in poly.all_coeffs())
    return a2, a1, a0


@lru_cache(maxsize=1)
def spinning_viscous() -> Theorem:
    """Upright spinning of a body whose height is largest there, for every body and mu."""
    proof = Proof()
    above = {SQUARE: EXCESS + EDGE}
    proof.step(
        "the constant term has the sign of (I1-I3 ρ) q - (1-ρ)",
        "characteristic polynomial of the general graph at h′ = 0, θ = π/2",
        lambda: (
            characteristic("spinning", "viscous").zeros == 1
            and vanishes(
                deciding()["coefficient of λ^0"] / SQUARE - STATIC.subs(UNIT).subs(PHI**2, SQUARE)
            )
        ),
    )
    proof.step(
        "where it is positive, every condition but the flutter condition holds: q = q1 + v, v > 0, "
        "q1 = (1-ρ)/(I1-I3 ρ)",
        "Liénard and Chipart; coefficients of one sign for ρ < 1 and I1 > I3 ρ",
        lambda: _others(above),
    )
    proof.step(
        "the flutter condition is a2 v² + a1 v + a0 > 0, times (1-ρ)²",
        "expansion of the Hurwitz determinant",
        lambda: (True, "; ".join(f"a{2 - i} = {c}" for i, c in enumerate(flutter()))),
    )
    proof.step(
        "a2 > 0 exactly for M < M1",
        "a2 falls linearly in M, with its zero at M1",
        lambda: _falls(flutter()[0], M1),
    )
    proof.step(
        "a0 > 0 exactly for M < M2 if I3 > I1, and for every M if I3 ≤ I1",
        "a0/M is a positive factor times one that is linear in M, with its zero at M2",
        _last,
    )
    proof.step(
        "M1 < M2 for I3 > I1",
        "coefficients of one sign",
        lambda: sign(M2 - M1, *FLATTER) == 1,
    )
    proof.step(
        "a1 changes its sign once in M > 0, from + to -; it is positive at M1, and negative at M2 "
        "if I3 > I1",
        "a1 is concave in M with a1 > 0 at 0; coefficients of one sign at M1 and M2",
        _middle,
    )
    proof.step(
        "linear viscous friction with c = mu has the same linearisation",
        "first derivatives of both forces at vA = 0, gn = 1",
        same_linearisation,
    )
    proof.conclude(
        "M ≤ M1: no root v > 0, stable; M ≥ M2: no root, unstable; between: one simple root, "
        "stable below",
        "Descartes' rule: signs (+ or 0, +, +), (-, -, - or 0), (-, ±, +)",
    )
    return Theorem(
        "spinning with viscous friction, for every body that is highest upright",
        ("Lengths over h(π/2): q = φ̇² h/g, M = mu² g h, q1 = (1-ρ)/(I1-I3 ρ), "
         "M1 = 2 I3 (1+ρ)/((1+I3) (2 I1+1+ρ)), "
         "M2 = 2 (1-ρ) I3² (I1+I3)/((1+I3) (I3-I1) (I1+I3+2 I1 I3)), and M2 = ∞ for I3 ≤ I1.",
         "M ≤ M1: stable for every q > q1.",
         "M1 < M < M2: stable exactly for q1 < q < q1 + v1, with v1 the one positive root of "
         "a2 v² + a1 v + a0.",
         "M ≥ M2: unstable for every q.",
         "q < q1: unstable for every mu. I1 ≤ I3 ρ: unstable for every q and mu. The disk is "
         "ρ = 0."),
        ("h′(π/2) = 0, h > 0, 0 ≤ ρ < 1 (so h′′ < 0), I1 > I3 ρ, mu > 0",
         "viscous or linear viscous friction",
         "stable: every eigenvalue but the structural zero has a negative real part"),
        tuple(proof.steps),
        (f"{BODY_TESTS}::test_spinning_is_stable_exactly_where_the_theorem_says",),
    )  # fmt: skip


def _others(above: dict[Expr, Expr]) -> tuple[bool, str]:
    rest = {n: c for n, c in deciding().items()
            if n not in ("coefficient of λ^0", "Hurwitz determinant 4")}  # fmt: skip
    signs = {n: sign(c.subs(above), *EVERY) for n, c in rest.items()}
    return set(signs.values()) == {1}, ", ".join(signs)


def _falls(expression: Expr, zero: Expr) -> bool:
    poly = sympy.Poly(sympy.together(expression), M)
    return poly.degree() == 1 and sign(-poly.LC(), *EVERY) == 1 and vanishes(poly.eval(zero))


def _last() -> bool:
    a0 = flutter()[2]
    positive = M * (1 + I3) * (I1 - I3 * RHO) * (1 + I3 * RHO) + I3**2 * RHO * (1 - RHO)
    other = sympy.cancel(a0 / positive)
    poly = sympy.Poly(sympy.together(other), M)
    return (
        sign(positive, *EVERY) == 1
        and poly.degree() == 1
        and vanishes(poly.eval(M2))
        and sign(-poly.LC(), *FLATTER) == 1
        and sign(poly.LC(), ROUND, SHARP[1]) == 1
        and vanishes(poly.LC().subs(I1, I3))
        and sign(poly.nth(0), *EVERY) == 1
    )


def _middle() -> bool:
    a1 = flutter()[1]
    poly = sympy.Poly(sympy.together(a1), M)
    return (
        poly.degree() == 2
        and sign(-poly.LC(), *EVERY) == 1
        and sign(poly.nth(0), *EVERY) == 1
        and sign(poly.eval(M1), *EVERY) == 1
        and sign(-poly.eval(M2), *FLATTER) == 1
    )


@lru_cache(maxsize=1)
def spinning_low() -> Theorem:
    """Spinning of a body that is lowest upright: the egg that lies and rises."""
    proof = Proof()
    proof.step(
        "the constant term has the sign of (I1-I3 ρ) q - (1-ρ)",
        "characteristic polynomial of the general graph at h′ = 0, θ = π/2",
        lambda: spinning_viscous().steps[0].proved,
    )
    proof.step(
        "for ρ > 1 and I1 < I3 ρ it is negative exactly for q > q1 = (ρ-1)/(I3 ρ-I1)",
        "the constant term falls linearly in q",
        lambda: sign(EDGE, {RHO: 1 + T, I1: I3 * (1 + T) / (1 + U)}) == 1,
    )
    aspect = sympy.Symbol("a")
    solid = {I1: (1 + aspect**2) / 5, I3: sympy.Rational(2, 5), RHO: aspect**2}
    proof.step(
        "solid spheroid of aspect a: I1 = (1+a²)/5, I3 = 2/5, ρ = a², so q1 = 5",
        "identity",
        lambda: vanishes(EDGE.subs(solid) - 5),
    )
    proof.conclude("one real eigenvalue is positive there for every mu", "sign of the product")
    return Theorem(
        "a body that lies with its axis level rises when it spins fast",
        ("At ρ > 1, that is h′′ > 0, with I1 < I3 ρ, spinning is unstable for every mu where "
         "q = φ̇² h/g > (ρ-1)/(I3 ρ-I1).",
         "For the solid spheroid this is φ̇² > 5 g/R for every aspect above 1, R the radius of its "
         "equator; for an aspect below 1 it is stable only above the same number."),
        ("h′(π/2) = 0, h > 0, mu > 0; lengths over h(π/2)",
         "below this number the flutter condition decides, which is printed among the "
         "polynomials and has no theorem here"),
        tuple(proof.steps),
        (f"{BODY_TESTS}::test_a_lying_spheroid_rises_above_the_same_number",),
    )  # fmt: skip
