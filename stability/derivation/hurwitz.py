"""Hurwitz's conditions over Q: the polynomials that decide a verdict, and proofs of the others.

By the criterion of Liénard and Chipart a real polynomial with positive leading coefficient is
stable exactly when certain coefficients and Hurwitz determinants are positive.  If one of these is
negative, some root lies in the right half plane, because a polynomial without such a root is a
limit of stable ones.  So signs alone decide a point at which none of these is zero.  Most of the
conditions hold everywhere, or follow from another; `decisive` proves these and returns the rest.

Source: F. R. Gantmacher, The Theory of Matrices, vol. 2, ch. XV §§ 6, 13;
tests/derivation/test_exact.py.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import sympy
from sympy.polys.matrices import DomainMatrix
from sympy.polys.rings import PolyRing

from ..algebra.exact.routh import hurwitz_matrix
from ..base.errors import StabilityError
from .characteristic import LAM, SIN, Derived, K

Expr = Any
"""A SymPy expression; SymPy states no types."""
SLACK = sympy.symbols("u t v", positive=True)
"""Positive unknowns in place of a strict inequality."""


@dataclass(frozen=True)
class StabilityCondition:
    """A polynomial of a verdict: all positive means stable (or neutral), one negative unstable."""

    kind: str
    """Kind: static (an eigenvalue through zero), flutter (a pair through the axis) or auxiliary."""
    polynomial: sympy.Poly
    """Polynomial in k, M = mu*² and z = at*² or s = sinθ; positive if stable (or neutral)."""


@dataclass(frozen=True)
class Obligation:
    """A condition that holds wherever the deciding conditions hold, with its proof."""

    name: str
    """Name of the condition."""
    polynomial: Expr
    """The polynomial that is proved positive."""
    proof: str
    """A sentence; the substitution in it turns every coefficient positive."""


def factored(expression: Expr) -> Expr:
    """A polynomial as the product of its irreducible factors.

    As `sympy.factor`, which first looks for denominators and needs most of its time for that.

    Examples
    --------
    >>> factored(2 * K * SIN**2 - 2 * K)
    2*k*(s - 1)*(s + 1)
    """
    expression = sympy.sympify(expression)
    if not expression.free_symbols:
        return expression
    content, factors = sympy.Poly(expression).factor_list()
    product = sympy.Mul(*[factor.as_expr() ** power for factor, power in factors])
    # SymPy would multiply a sum out
    apart = product.is_Add and abs(content) != 1
    return sympy.Mul(content, product, evaluate=not apart)


def determinant(polynomial: sympy.Poly, order: int) -> Expr:
    """Hurwitz determinant of one order, factored.

    Examples
    --------
    >>> x, a = sympy.symbols("x a")
    >>> [determinant(sympy.Poly(x**3 + a * x**2 + x + 1, x), i) for i in (1, 2, 3)]
    [a, a - 1, a - 1]
    """
    rows = hurwitz_matrix(polynomial.all_coeffs()[::-1], order, sympy.Integer(0))
    # over the ring of polynomials, not of expressions
    matrix = DomainMatrix.from_Matrix(sympy.Matrix(rows))
    return factored(matrix.domain.to_sympy(matrix.det()))


@lru_cache(maxsize=64)
def conditions(derived: Derived) -> tuple[tuple[str, Expr], ...]:
    """Polynomials that must all be positive, by name, for every factor.

    For an even factor q(λ²), linear in λ², the conditions say that λ² is negative.

    Parameters
    ----------
    derived
        Result of `derive`.

    Returns
    -------
    tuple of (str, Expr)
    """
    out: list[tuple[str, Expr]] = []
    for factor in derived.factors:
        poly = sympy.Poly(factor.as_expr(), LAM)
        if derived.even:
            if poly.degree() != 2:
                raise StabilityError(f"{factor.as_expr()} is not linear in λ².")
            lead, _, constant = poly.all_coeffs()
            out += [("leading coefficient", lead), ("constant term", constant)]
            continue
        n = poly.degree()
        a = poly.all_coeffs()
        out.append(("leading coefficient", a[0]))
        # Liénard-Chipart: every second coefficient from the constant, every second determinant
        out += [
            ("constant term" if i == n else f"coefficient of λ^{n - i}", a[i])
            for i in range(n, 0, -2)
        ]
        out += [(f"Hurwitz determinant {i}", determinant(poly, i)) for i in range(n - 1, 0, -2)]
    return tuple((name, factored(value)) for name, value in out)


@lru_cache(maxsize=1024)
def positive(expression: Expr, assumed: Expr | None = None) -> str | None:
    """A proof that an expression is positive for k in (0, 1/2], s in (0, 1), M > 0, z > 0.

    Parameters
    ----------
    expression
        Polynomial in k, M, z, s.
    assumed
        A polynomial that is assumed positive and is linear in some variable.

    Returns
    -------
    str or None
        The proof, or None if these substitutions give none.

    Examples
    --------
    >>> positive(K * SIN**2 + 1 - SIN)
    'every coefficient is positive after k = 1/(2 + u), s = 1/(1 + t)'
    """
    u, t, v = SLACK
    domain = [
        (K, sympy.Integer(1), 2 + u, "k = 1/(2 + u)"),
        (SIN, sympy.Integer(1), 1 + t, "s = 1/(1 + t)"),
    ]
    trials: list[list[tuple[sympy.Symbol, Expr, Expr, str]]] = [[]]
    if assumed is not None:
        trials = []
        for variable in sorted(assumed.free_symbols - {K}, key=str):
            poly = sympy.Poly(assumed, variable)
            if poly.degree() == 1 and positive(poly.LC()):
                said = f"{variable} from {assumed} = v > 0"
                trials.append([(variable, v - poly.nth(0), poly.LC(), said)])
    names = expression.free_symbols | {K, SIN, *SLACK}.union(
        assumed.free_symbols if assumed else ()
    )
    # elements of a ring: polynomials of SymPy go through expressions, at six times the cost
    ring = PolyRing(sorted(names, key=str), sympy.QQ)
    start = ring.from_expr(expression)
    for trial in trials:
        result, words = start, []
        for variable, top, bottom, said in [*trial, *domain]:
            place = ring.symbols.index(variable)
            if result.degree(place) > 0:
                result = _inserted(result, place, ring.from_expr(top), ring.from_expr(bottom))
                words.append(said)
        if _all_positive(result, ring.symbols.index(u)):
            text = "every coefficient is positive"
            return text + (f" after {', '.join(words)}" if words else "")
    return None


def _inserted(polynomial: Any, place: int, top: Any, bottom: Any) -> Any:
    """The polynomial at variable = top/bottom, times a power of bottom > 0: no fractions."""
    ring = polynomial.ring
    powers: list[dict[Any, Any]] = [{} for _ in range(polynomial.degree(place) + 1)]
    for exponents, c in polynomial.terms():
        rest = (*exponents[:place], 0, *exponents[place + 1 :])
        powers[exponents[place]][rest] = c
    result, power = ring.zero, ring.one
    for part in reversed(powers):  # Horner's scheme
        result, power = result * top + power * ring.from_dict(part), power * bottom
    return result


def _all_positive(polynomial: Any, place: int) -> bool:
    """Whether every coefficient is positive, and the value at u = 0 (k = 1/2) too."""
    at_zero = any(exponents[place] == 0 for exponents in polynomial.monoms())
    return at_zero and all(c > 0 for c in polynomial.coeffs())


def decisive(derived: Derived) -> tuple[list[StabilityCondition], list[Obligation]]:
    """The conditions that decide, and the proofs of the others.

    Examples
    --------
    >>> z = sympy.Symbol("z")
    >>> rolling = Derived(2, True, (sympy.Poly(LAM**2 + 2 * K * z - 1, LAM, K, z),))
    >>> [str(c.polynomial.as_expr()) for c in decisive(rolling)[0]]
    ['2*k*z - 1']
    """
    proved: list[Obligation] = []
    asked: dict[Expr, str] = {}
    for name, value in conditions(derived):
        doubtful = sympy.Integer(1)
        sign, factors = sympy.factor_list(value)
        sign = sympy.sign(sign)
        for factor, power in factors:
            if positive(factor):
                continue
            if power % 2 == 0:
                raise StabilityError(f"the {name} has a square factor, {factor}.")
            if positive(-factor):
                sign = -sign
                continue
            doubtful = doubtful * factor
        if doubtful == 1:
            if sign < 0:
                raise StabilityError(f"the {name} is negative everywhere: never stable.")
            proved.append(Obligation(name, value, positive(value) or "factor by factor"))
            continue
        asked.setdefault(sympy.expand(sign * doubtful), name)
    for expression, name in list(asked.items()):
        others = sorted((o for o in asked if o != expression), key=lambda o: len(o.args))
        reason = next((p for o in others if (p := positive(expression, o))), None)
        if reason:
            del asked[expression]
            proved.append(Obligation(name, expression, reason))
    return [_condition(e, name, derived) for e, name in asked.items()], proved


def _condition(expression: Expr, name: str, derived: Derived) -> StabilityCondition:
    kind = "auxiliary"
    if name == "constant term":
        kind = "static"
    elif name in {
        f"Hurwitz determinant {sympy.Poly(f.as_expr(), LAM).degree() - 1}" for f in derived.factors
    }:
        kind = "flutter"
    variables: Sequence[sympy.Symbol] = derived.factors[0].gens[1:]
    return StabilityCondition(kind, sympy.Poly(expression, *variables))
