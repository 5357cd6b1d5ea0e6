"""Statements: the characteristic polynomials of every body of revolution."""

from __future__ import annotations

from typing import Any

import sympy

from .body_polynomials import (
    PAIRS,
    PHI,
    SPIN,
    STATES,
    STORED_LAWS,
    characteristic,
)
from .entry import Entry, raised, written
from .pole.polynomials import vertical
from .proof import BODY_TESTS, POLE_TESTS

Expr = Any
"""A SymPy expression; SymPy states no types."""
UNITS = "m = g = 1"
PLACES = {
    "rolling": "h′ = 0; s = sinθ",
    "spinning": "θ = π/2, h′ = 0",
    "tumbling": "φ̇² s (I1 r c - I3 z s) = h′ r, ω₃ = φ̇ s z/r; h = r s + z c, h′ = r c - z s, "
    "ρ = h + h′′",
    "circling": "h′ + φ̇ (ω₃ (r h + I3 s) - φ̇ s (z h + I1 c)) = 0, φ̇ ≠ 0; h = r s + z c, "
    "h′ = r c - z s, ρ = h + h′′",
    "precession": "h′ + φ̇ s (I3 ω₃ - I1 φ̇ c) = 0, φ̇ ≠ 0",
}
"""Where each polynomial holds."""


def polynomials() -> tuple[tuple[str, str], ...]:
    """Family and law of each polynomial, in order.

    Examples
    --------
    >>> polynomials()[-1]
    ('vertical', 'smooth')
    """
    pairs = [(f, law) for f in STATES for law in STORED_LAWS]
    return (*pairs, *PAIRS.items(), *(("vertical", law) for law in STORED_LAWS))


def polynomial(family: str, law: str) -> Entry:
    """The statement of one polynomial."""
    if family == "vertical":
        return _vertical(law)
    found = characteristic(family, law)
    degree = len(found.coefficients) - 1
    lines = tuple(
        f"λ{raised(degree - i)}: {_by_rates(c) if family in PAIRS else written(c)}"
        for i, c in enumerate(found.coefficients)
        if c != 0
    )
    verdict: tuple[str, ...] = ()
    if family in PAIRS:
        verdict = (
            "Neutral where the coefficient of λ⁰ is positive, and unstable where it is "
            "negative; that of λ² is positive.",
        )
    return Entry(
        f"{family}, {law}",
        "derived from the general graph",
        (
            f"λ = 0 with multiplicity {found.zeros}; the other eigenvalues are roots of the "
            "polynomial with coefficients",
            *lines,
            *verdict,
        ),
        assumptions=(PLACES[family], UNITS),
        refuters=(f"{BODY_TESTS}::test_polynomials_have_the_eigenvalues_of_the_spectrum",),
    )


def _by_rates(expression: Expr) -> str:
    """A polynomial in φ̇ and ω₃, by their powers."""
    parts = []
    for powers, c in sympy.Poly(expression, PHI, SPIN).terms():
        rates = written(PHI ** powers[0] * SPIN ** powers[1]) if any(powers) else ""
        factor = written(sympy.factor(c))
        simple = not rates or not (sympy.factor(c).is_Add or factor.startswith("-"))
        parts.append(f"{rates} {factor}".strip() if simple else f"{rates} ({factor})")
    return " + ".join(parts).replace("+ -", "- ")


def _vertical(law: str) -> Entry:
    found = vertical(law)
    degree = len(found.coefficients) - 1
    lines = []
    for i, (real, imaginary) in enumerate(found.coefficients):
        parts = [written(real)] if real != 0 else []
        if imaginary != 0:
            parts.append(f"i ({written(imaginary)})")
        lines.append(f"λ{raised(degree - i)}: {' + '.join(parts)}")
    return Entry(
        f"vertical, {law}",
        "derived from the general graph around a pole",
        (
            "λ = 0 with multiplicity 1; the other eigenvalues are roots of the complex polynomial "
            "with coefficients",
            *lines,
            "and the conjugates of these roots.",
        ),
        assumptions=("θ = 0 or π, where h is a smooth function of cosθ; n = omega_Z", UNITS),
        refuters=(
            f"{POLE_TESTS}::"
            "test_exact_jacobians_of_another_formulation_have_the_printed_polynomial",
        ),
    )
