"""Complex characteristic polynomials of vertical spin, and where their roots lie.

Vertical spin looks the same from every side.  So disturbances X + i Y of axis, angular velocity and
slip have a complex matrix, and the eigenvalues are λ = 0, the roots of its characteristic
polynomial, and their conjugates.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import sympy
from sympy.polys.matrices import DomainMatrix

from stability.base.errors import StabilityError
from stability.derivation.characteristic import LAM

from ..mechanics import vanishes
from .graph import POLES, complex_matrix, pole_graph

Expr = Any
"""A SymPy expression; SymPy states no types."""
FREQUENCY = sympy.Symbol("nu")
"""ν of λ = i ν."""


@dataclass(frozen=True)
class ComplexPolynomial:
    """The polynomial of vertical spin: half of the eigenvalues; the others are conjugate."""

    law: str
    """Name of the law."""
    zeros: int
    """Further multiplicity of λ = 0."""
    coefficients: tuple[tuple[Expr, Expr], ...]
    """Real and imaginary part of each coefficient, the highest power of λ first."""

    @property
    def polynomial(self) -> sympy.Poly:
        """The polynomial in λ."""
        return sympy.Poly([a + sympy.I * b for a, b in self.coefficients], LAM)

    def on_axis(self) -> tuple[sympy.Poly, sympy.Poly]:
        """Real and imaginary part at λ = i ν, as polynomials in ν."""
        turns = ((1, 0), (0, 1), (-1, 0), (0, -1))
        parts = [sympy.Integer(0), sympy.Integer(0)]
        for power, (a, b) in enumerate(reversed(self.coefficients)):
            re, im = turns[power % 4]
            parts[0] += (a * re - b * im) * FREQUENCY**power
            parts[1] += (a * im + b * re) * FREQUENCY**power
        return sympy.Poly(parts[0], FREQUENCY), sympy.Poly(parts[1], FREQUENCY)


@lru_cache(maxsize=8)
def vertical(law: str) -> ComplexPolynomial:
    """The polynomial of vertical spin of every body, the same at both poles.

    Examples
    --------
    >>> vertical("smooth").coefficients
    ((I1, 0), (0, -I3*n), (h′′, 0))
    """
    found = [_at(law, side) for side in POLES]
    if not all(
        vanishes(a - b) for p, q in zip(*found, strict=True) for a, b in zip(p, q, strict=True)
    ):
        raise StabilityError(f"the polynomials of both poles differ ({law}).")
    own = ComplexPolynomial(law, 1, found[0])
    _check(own)
    return own


def _at(law: str, side: int) -> tuple[tuple[Expr, Expr], ...]:
    """Coefficients at one pole, without denominator."""
    matrix = complex_matrix(law, side)
    turned = (LAM * sympy.eye(matrix.rows) - matrix).applyfunc(sympy.together)
    whole = DomainMatrix.from_Matrix(turned)
    top = sympy.fraction(sympy.together(whole.domain.to_sympy(whole.det())))[0]
    poly = sympy.Poly(sympy.expand(top), LAM)
    lead = poly.LC()
    if lead.could_extract_minus_sign():
        poly = -poly
    pairs = []
    for coefficient in poly.all_coeffs():
        split = sympy.Poly(sympy.expand(coefficient), sympy.I) if coefficient.has(sympy.I) else None
        parts = (split.nth(0), split.nth(1)) if split else (coefficient, sympy.Integer(0))
        pairs.append(tuple(sympy.factor(p) for p in parts))
    return tuple(pairs)


def _check(found: ComplexPolynomial) -> None:
    """Refuse a polynomial whose product with its conjugate and λ is not the real one."""
    for side in POLES:
        matrix = pole_graph(found.law, side).by_state
        whole = (LAM * sympy.eye(matrix.rows) - matrix).applyfunc(sympy.together)
        ring = DomainMatrix.from_Matrix(whole)
        real = ring.domain.to_sympy(ring.det())
        parts = [
            sum(c[k] * LAM**i for i, c in enumerate(reversed(found.coefficients))) for k in (0, 1)
        ]
        product = LAM**found.zeros * (parts[0] ** 2 + parts[1] ** 2)
        scale = found.coefficients[0][0] ** 2
        if not vanishes(real * scale - product):
            raise StabilityError(f"the {found.law} polynomial at a pole does not split.")


def bilharz(real: sympy.Poly, imaginary: sympy.Poly, degree: int) -> tuple[Expr, ...]:
    """Determinants B2, B4, … of a complex polynomial f, from its parts at λ = i ν.

    With f(iν) = b0 ν^n + … + i (a0 ν^n + …), a0 ≠ 0, and B2n ≠ 0, no root is on the imaginary axis,
    and the roots to the right of it are as many as the changes of sign in 1, B2, B4, …, B2n.

    Source: H. Bilharz, Z. angew. Math. Mech. 24 (1944) 77; F. R. Gantmacher, The Theory of
    Matrices, vol. 2, ch. XV; tests/derivation/bodies/test_vertical.py counts roots.

    Examples
    --------
    >>> nu = sympy.Symbol("nu")
    >>> bilharz(sympy.Poly(2, nu), sympy.Poly(nu, nu), 1)  # λ + 2
    (2,)
    """
    a = [imaginary.nth(degree - i) for i in range(degree + 1)]
    b = [real.nth(degree - i) for i in range(degree + 1)]
    found = []
    for order in range(1, degree + 1):
        size = 2 * order

        def entry(i: int, j: int) -> Expr:
            place, row = j - i // 2, (a, b)[i % 2]
            return row[place] if 0 <= place <= degree else sympy.Integer(0)

        matrix = DomainMatrix.from_Matrix(sympy.Matrix(size, size, entry))
        found.append(sympy.factor(matrix.domain.to_sympy(matrix.det())))
    return tuple(found)
