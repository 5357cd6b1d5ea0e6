"""Signs of rational functions of a body's numbers, by coefficients after a substitution."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import sympy

Expr = Any
"""A SymPy expression; SymPy states no types."""


def sign(expression: Expr, *cases: Mapping[Expr, Expr]) -> int:
    """The sign of a rational function that is proved in every case, or 0.

    After the substitution of each case every coefficient of the numerator has one sign, and every
    coefficient of the denominator too.  So the sign holds for all positive values of the symbols.

    Parameters
    ----------
    expression
        Rational function over Q.
    cases
        Values of symbols by rational functions of positive symbols; none at all is one case.

    Examples
    --------
    >>> x, t = sympy.symbols("x t")
    >>> sign(1 - x, {x: 1 / (1 + t)}), sign(x - 2, {x: 1 + t}), sign(-x)
    (1, 0, -1)
    """
    found = {_sign(expression, case) for case in cases or ({},)}
    return found.pop() if len(found) == 1 else 0


def _sign(expression: Expr, case: Mapping[Expr, Expr]) -> int:
    inserted = sympy.sympify(expression).subs(case, simultaneous=True)
    signs = [_one(part) for part in sympy.fraction(sympy.cancel(sympy.together(inserted)))]
    return signs[0] * signs[1]


def _one(polynomial: Expr) -> int:
    free = sorted(polynomial.free_symbols, key=str)
    found: Sequence[Expr] = sympy.Poly(polynomial, *free).coeffs() if free else [polynomial]
    return int(all(bool(c > 0) for c in found)) - int(all(bool(c < 0) for c in found))
