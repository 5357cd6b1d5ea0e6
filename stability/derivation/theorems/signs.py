"""Proofs of signs: of polynomials in k by Sturm's theorem, in k and x by their coefficients.

The disk's inertia factor k lies in (0, 1/2].
"""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import sympy

from ..characteristic import SIN, K
from ..hurwitz import positive

Expr = Any
"""A SymPy expression; SymPy states no types."""
HALF = sympy.Rational(1, 2)


def positive_in_k(expression: Expr, low: Expr = 0, high: Expr = HALF) -> bool:
    """Whether a rational function of k is proved positive on (low, high].

    Parameters
    ----------
    expression
        Rational function of k over Q.
    low, high
        Rational ends; the low end is left out.

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

    Parameters
    ----------
    expression
        Polynomial in k and x.
    x
        The second variable.

    Examples
    --------
    >>> x = sympy.Symbol("x")
    >>> bool(positive_in_strip(1 - K * x, x)), positive_in_strip(1 - 3 * K * x, x)
    (True, '')
    """
    words = positive(sympy.expand(expression).subs(x, SIN))
    return "" if words is None else words.replace("s = ", f"{x} = ")


def roots_in_k(expression: Expr) -> list[tuple[Expr, Expr]]:
    """Rational intervals, each about one root in (0, 1/2), of an expression in k.

    Parameters
    ----------
    expression
        Polynomial in k, not zero.  Roots at 0 and 1/2 are left out.
    """
    found: list[tuple[Expr, Expr]] = []
    for factor, _ in sympy.factor_list(expression, K)[1]:
        poly = sympy.Poly(factor, K)
        width = sympy.Rational(1, 10**12)
        for (a, b), _ in poly.intervals(eps=width, inf=0, sup=HALF):
            if not (a == b and a in (0, HALF)):
                found.append((a, b))
    return found


def cells(expressions: list[Expr]) -> tuple[list[tuple[Expr, Expr]], list[Expr]]:
    """Roots in k of the expressions on (0, 1/2), and one rational k in each cell between them.

    Parameters
    ----------
    expressions
        Polynomials in k, none of them zero.

    Raises
    ------
    ValueError
        If two roots are not separated.
    """
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

    Parameters
    ----------
    left, right
        Rational functions over Q.

    Examples
    --------
    >>> equal((K**2 - 1) / (K - 1), K + 1)
    True
    """
    return bool(sympy.cancel(sympy.together(left - right)) == 0)
