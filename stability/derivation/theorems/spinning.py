"""Theorem: for every k, between which mu spinning changes its stability, by Descartes."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import sympy

from ..characteristic import SQUARE, K, M
from ..proof import Proof, Theorem
from .flutter import deciding, drift, premises
from .motion import PHI
from .signs import equal, positive_in_k
from .steady_motions import FILE

Expr = Any
"""A SymPy expression; SymPy states no types."""
EXCESS = sympy.Symbol("v")
"""v = φ̇² - 1/k."""
M1 = 4 * K / (2 * K + 1) ** 2
M2 = 24 * K / ((2 * K + 1) * (4 * K + 3))


@lru_cache(maxsize=1)
def coefficients() -> tuple[Expr, Expr, Expr]:
    """(a2, a1, a0) of the flutter condition a2 v² + a1 v + a0, from the graph.

    Examples
    --------
    >>> sympy.factor(coefficients()[0])
    -8*k**3*(4*M*k**2 + 4*M*k + M - 4*k)
    """
    condition = deciding("spinning").conditions["flutter"].subs(SQUARE, EXCESS + 1 / K)
    poly = sympy.Poly(sympy.expand(condition), EXCESS)
    if poly.degree() != 2:
        raise ValueError(f"the condition has degree {poly.degree()} in v, not 2")
    a2, a1, a0 = (sympy.cancel(c) for c in poly.all_coeffs())
    return a2, a1, a0


@lru_cache(maxsize=1)
def spinning() -> Theorem:
    """Spinning for every k.

    Examples
    --------
    >>> spinning().proved
    True
    """
    proof = Proof()
    premises(proof, "spinning", {"static", "flutter"})
    proof.step(
        "unstable for φ̇² < 1/k; let v = φ̇² - 1/k > 0",
        "the static polynomial is kφ̇² - 1",
        lambda: equal(deciding("spinning").conditions["static"], K * SQUARE - 1),
    )
    proof.step(
        "the flutter polynomial is a2 v² + a1 v + a0",
        "expansion",
        lambda: (
            True,
            "; ".join(f"a{2 - i} = {sympy.factor(c)}" for i, c in enumerate(coefficients())),
        ),
    )
    proof.step(
        "a2 > 0 for mu*² < M1, 0 at M1, < 0 above",
        "a2 is linear in mu*², with sign of slope and place of zero",
        lambda: _falls_through(coefficients()[0], M1),
    )
    proof.step(
        "a0 > 0 for mu*² < M2, 0 at M2, < 0 above",
        "a0/mu*² is linear in mu*², with sign of slope and place of zero",
        lambda: _falls_through(sympy.cancel(coefficients()[2] / M), M2),
    )
    proof.step(
        "M1 < M2", "sign of M2 - M1 for k in (0, 1/2] (Sturm)", lambda: positive_in_k(M2 - M1)
    )
    proof.step(
        "a1 > 0 for mu*² ≤ M1, and a1 < 0 for mu*² ≥ M2",
        "-a1 is convex in mu*², negative at 0 and at M1, positive at M2 (Sturm in k)",
        _middle,
    )
    proof.step(
        "mu*² ≤ M1: no root v > 0, stable; mu*² ≥ M2: no root v > 0, unstable; between: one "
        "simple root, stable below it and unstable above",
        "Descartes' rule: signs (+ or 0, +, +), (-, -, - or 0) and (-, ±, +)",
        lambda: all(step.proved for step in proof.steps),
    )
    drift(proof, "spinning", K * PHI)
    proof.conclude(
        "the boundary is elliptic: the drift leads from unstable members, at larger φ̇, "
        "to stable ones",
        "the steps above; the root is simple, so the pair crosses the "
        "axis with nonzero speed (Orlando's formula)",
    )
    return Theorem(
        "spinning for every k",
        ("Let M1 = 4k/(2k+1)² and M2 = 24k/((2k+1)(4k+3)); mu*² = mu² g R, and φ̇ is in √(g/R).",
         "mu*² ≤ M1: spinning is stable for every φ̇² > 1/k.",
         "M1 < mu*² < M2: stable exactly for 1/k < φ̇² < 1/k + v*, unstable above, with v* the one "
         "positive root, simple, of a2 v² + a1 v + a0; the boundary is elliptic.",
         "mu*² ≥ M2: unstable for every φ̇.",
         "φ̇² < 1/k: unstable for every mu."),
        ("0 < k ≤ 1/2, mu > 0; viscous or linear viscous friction",
         "stable: every eigenvalue but the structural zero has a negative real part",
         "elliptic or hyperbolic: by the direction of the drift along the family at leading order"),
        tuple(proof.steps),
        (f"{FILE}::test_spinning_is_stable_exactly_where_the_theorem_says",),
    )  # fmt: skip


def _falls_through(expression: Expr, zero: Expr) -> bool:
    """Whether an expression linear in M has this zero and a negative slope for every k."""
    poly = sympy.Poly(expression, M)
    return (
        poly.degree() == 1
        and positive_in_k(-poly.LC())
        and equal(poly.as_expr().subs(M, zero), sympy.Integer(0))
    )


def _middle() -> bool:
    poly = sympy.Poly(-coefficients()[1], M)
    if poly.degree() != 2:
        return False
    at_m1, at_m2 = (poly.as_expr().subs(M, m) for m in (M1, M2))
    signs = (poly.LC(), -poly.nth(0), -at_m1, at_m2)
    return all(positive_in_k(sign) for sign in signs)
