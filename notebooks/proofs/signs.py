"""Proofs of signs: by coefficients after a substitution, and for the disk's k by Sturm's theorem.

The disk's inertia factor k lies in (0, 1/2].
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any

import sympy

from stability.derivation.characteristic import SIN, K
from stability.derivation.hurwitz import positive

Expr = Any
"""A SymPy expression; SymPy states no types."""
HALF = sympy.Rational(1, 2)


def sign(expression: Expr, *cases: Mapping[Expr, Expr]) -> int:
    """The sign of a rational function that is proved in every case, or 0.

    After the substitution of each case every coefficient of the numerator has one sign, and every
    coefficient of the denominator too.  So the sign holds for all positive values of the symbols.

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


# --- in k, or in k and x ---


def positive_in_k(expression: Expr, low: Expr = 0, high: Expr = HALF) -> bool:
    """Whether a rational function of k is proved positive on (low, high].

    Examples
    --------
    >>> positive_in_k(1 - K), positive_in_k(1 - 2 * K), positive_in_k(1 - 3 * K)
    (True, False, False)
    """
    top, bottom = sympy.fraction(sympy.cancel(sympy.together(expression)))
    poly = sympy.Poly(top * bottom, K, domain="QQ")
    low, high = sympy.Rational(low), sympy.Rational(high)
    roots = poly.count_roots(low, high) if poly.degree() > 0 else 0
    roots -= 1 if poly.eval(low) == 0 else 0
    return bool(roots == 0 and poly.eval((low + high) / 2) > 0)


def positive_in_strip(expression: Expr, x: sympy.Symbol) -> str:
    """A proof that a polynomial is positive for k in (0, 1/2] and x in (0, 1), or no words.

    Examples
    --------
    >>> x = sympy.Symbol("x")
    >>> bool(positive_in_strip(1 - K * x, x)), positive_in_strip(1 - 3 * K * x, x)
    (True, '')
    """
    words = positive(sympy.expand(expression).subs(x, SIN))
    return "" if words is None else words.replace("s = ", f"{x} = ")


def roots_in_k(expression: Expr) -> list[tuple[Expr, Expr]]:
    """Rational intervals, each about one root in (0, 1/2), of an expression in k."""
    found: list[tuple[Expr, Expr]] = []
    for factor, _ in sympy.factor_list(expression, K)[1]:
        poly = sympy.Poly(factor, K)
        width = sympy.Rational(1, 10**12)
        for (a, b), _ in poly.intervals(eps=width, inf=0, sup=HALF):
            if not (a == b and a in (0, HALF)):
                found.append((a, b))
    return found


def cells(expressions: list[Expr]) -> tuple[list[tuple[Expr, Expr]], list[Expr]]:
    """Roots in k of the expressions on (0, 1/2), and one rational k in each cell between them."""
    factors: dict[Expr, None] = {}
    for expression in expressions:
        if sympy.expand(expression) == 0:
            raise ValueError("a polynomial that must not vanish for every k is zero")
        for factor, _ in sympy.factor_list(expression, K)[1]:
            factors[factor] = None
    roots = sorted(pair for factor in factors for pair in roots_in_k(factor))
    if any(a[1] >= b[0] for a, b in pairwise(roots)):
        raise ValueError("two roots in k are not separated")
    edges = [(sympy.Integer(0),) * 2, *roots, (HALF,) * 2]
    return roots, [(a[1] + b[0]) / 2 for a, b in pairwise(edges)]


def equal(left: Expr, right: Expr) -> bool:
    """Whether two rational functions are the same.

    Examples
    --------
    >>> equal((K**2 - 1) / (K - 1), K + 1)
    True
    """
    return bool(sympy.cancel(sympy.together(left - right)) == 0)
