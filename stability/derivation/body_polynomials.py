"""Characteristic polynomials of every body of revolution, derived from the general graph.

At rolling and spinning h′ = 0.  At tumbling h = r sinθ + z cosθ and h′ = r cosθ - z sinθ, where r
and z say where the contact point lies: the centre rests, so ω₃ = φ̇ sinθ z/r, and φ̇² follows from
φ̇² sinθ (I1 r cosθ - I3 z sinθ) = h′ r.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import sympy
from sympy.polys.matrices import DomainMatrix

from ..base.checks import known
from .body_graph import BEND, FORCE_X, I1, I3, PHI, RHO, SLOPE, SPIN, H, R, Z, folded, pencil
from .characteristic import COS, LAM, MU, SIN
from .hurwitz import factored, terms

Expr = Any
"""A SymPy expression; SymPy states no types."""
CENTRE = {H: R * SIN + Z * COS, SLOPE: R * COS - Z * SIN}
"""The height and its slope by the place of the contact point."""
SQUARE = CENTRE[SLOPE] * R / (SIN * (I1 * R * COS - I3 * Z * SIN))
"""φ̇² of tumbling."""
STATES: dict[str, dict[Expr, Expr]] = {
    "rolling": {SLOPE: 0, PHI: 0},
    "spinning": {SLOPE: 0, SPIN: 0, SIN: 1, COS: 0},
    "tumbling": CENTRE | {SPIN: PHI * SIN * Z / R, BEND: RHO - CENTRE[H]},
}
"""Values of a family's states."""
RADIUS, AXIAL = H * SIN + SLOPE * COS, H * COS - SLOPE * SIN
"""r and z of the contact point."""
LAWS = ("viscous", "rough", "smooth")
"""Laws whose polynomials are derived."""
PAIRS = {"circling": "rough", "precession": "smooth"}
"""Families that two numbers name, each under its one law."""
PLACED = CENTRE | {BEND: RHO - CENTRE[H]}
"""The height and its slopes by r, z and ρ."""
PAIRED: dict[str, dict[Expr, Expr]] = {"circling": PLACED, "precession": {}}
"""Values by which the polynomials of such families are short."""


@dataclass(frozen=True)
class Characteristic:
    """The characteristic polynomial of a family of every body, without factors of known sign."""

    family: str
    """Name of the family."""
    law: str
    """Name of the law."""
    zeros: int
    """Multiplicity of the factor λ."""
    coefficients: tuple[Expr, ...]
    """Coefficients of the rest, the highest power of λ first, each factored."""
    left_out: Expr
    """The factor without λ that is left out."""

    @property
    def polynomial(self) -> sympy.Poly:
        """The rest as a polynomial in λ."""
        return sympy.Poly(list(self.coefficients), LAM)


@lru_cache(maxsize=16)
def characteristic(family: str, law: str) -> Characteristic:
    """The characteristic polynomial of a family with an inclined axis, for every body.

    Parameters
    ----------
    family
        rolling, spinning or tumbling; circling or precession, where ω₃ follows from their surface.
    law
        viscous, rough or smooth; rough for circling, smooth for precession.

    Returns
    -------
    Characteristic

    Examples
    --------
    >>> characteristic("spinning", "smooth").coefficients
    (I1, 0, I1*phi_dot**2 + h′′)
    """
    known("family", family, (*STATES, *PAIRS))
    if family in PAIRS:
        known("law", law, (PAIRS[family],))
        poly = _of_pair(family, PAIRED[family])
    else:
        rest = dict(STATES[family])
        spin = {SPIN: rest.pop(SPIN, SPIN)}  # with its fraction only after the determinant
        det = _determinant(known("law", law, LAWS), {FORCE_X: 0} | rest)
        poly = sympy.Poly(folded(sympy.fraction(sympy.together(det.subs(spin)))[0]), LAM)
    zeros = min(n for (n,) in poly.monoms())
    content, factors = sympy.factor_list(poly.as_expr())
    left = sympy.Mul(content, *[f**n for f, n in factors if not f.has(LAM)])
    rest = sympy.Poly(sympy.cancel(poly.as_expr() / left / LAM**zeros), LAM)
    if _negative(rest.LC()):
        rest, left = -rest, -left
    coefficients = tuple(factored(c) for c in rest.all_coeffs())
    return Characteristic(family, law, zeros, coefficients, left)


def _determinant(law: str, values: dict[Expr, Expr]) -> Expr:
    """The determinant of the pencil at values of its symbols."""
    whole = DomainMatrix.from_Matrix(pencil(law).subs(values, simultaneous=True).expand())
    return whole.domain.to_sympy(whole.det())


def _of_pair(family: str, place: dict[Expr, Expr]) -> sympy.Poly:
    """The whole polynomial in λ of circling or precession; ω₃ and φ̇ both stay in it."""
    law = PAIRS[family]
    force = PHI * (R * SPIN - PHI * SIN * Z) if law == "rough" else 0  # mass times acceleration
    det = _determinant(law, place | {FORCE_X: force})
    return sympy.Poly(folded(det), LAM)


def _negative(expression: Expr) -> bool:
    """Whether an expression is negative at one body, which only chooses a sign."""
    point = {
        I1: sympy.Rational(1, 3),
        I3: sympy.Rational(1, 2),
        H: 1,
        SLOPE: 0,
        R: 1,
        Z: 0,
        SIN: sympy.Rational(4, 5),
        COS: sympy.Rational(3, 5),
    }
    return bool(expression.subs(point) < 0)


# --- for use without SymPy ---

VARIABLES = (I1, I3, H, BEND, R, Z, RHO, SIN, COS, PHI, SPIN, MU)
"""Variables of a stored polynomial; that of tumbling has no ω₃, that of rolling no r, z and ρ."""


def stored() -> dict[str, Any]:
    """Every polynomial that `stability.bodies.round_body.polynomials` reads, as JSON.

    Returns
    -------
    dict
        By family and law: `zeros`, `even`, and `coefficients` (terms of each, lowest power first).
    """
    cases: dict[str, Any] = {}
    for law in LAWS:
        for family in ("rolling", "tumbling"):
            found = characteristic(family, law)
            cases[f"{family} {law}"] = _record(found.zeros, found.coefficients[::-1])
    for family, law in PAIRS.items():
        poly = _of_pair(family, PLACED)
        zeros = min(n for (n,) in poly.monoms())
        cases[f"{family} {law}"] = _record(zeros, poly.all_coeffs()[::-1][zeros:])
    return {"format": 1, "cases": cases}


def _record(zeros: int, coefficients: Sequence[Expr]) -> dict[str, Any]:
    used = [v for v in VARIABLES if any(sympy.sympify(c).has(v) for c in coefficients)]
    return {
        "variables": [str(v) for v in used],
        "zeros": int(zeros),
        "even": all(c == 0 for c in coefficients[1::2]),
        "coefficients": [terms(c, used) for c in coefficients],
    }
