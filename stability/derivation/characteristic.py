"""Symbols of the disk's polynomials, and a characteristic polynomial in factors.

notebooks/proofs/disk_polynomials.py derives these from the graph of a family.
"""

from __future__ import annotations

from dataclasses import dataclass

import sympy

LAM, K, MU, SIN, COS = sympy.symbols("lam k mu s c")
SQUARE, M = sympy.symbols("z M")


@dataclass(frozen=True)
class Derived:
    """The reduced characteristic polynomial of a family under a law, in factors."""

    zeros: int
    """Multiplicity of the factor λ."""
    even: bool
    """Whether the rest of the polynomial is even in λ."""
    factors: tuple[sympy.Poly, ...]
    """Irreducible factors of the rest over Q, polynomials in σ; λ = σ mu for a law with mu."""
