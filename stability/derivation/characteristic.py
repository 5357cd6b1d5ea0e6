"""Characteristic polynomials over Q, derived by SymPy from the graph of a family.

No formula is typed in.  The Jacobian at a family is read from the CasADi graph in SymPy's algebra,
with the sine and cosine of theta as symbols.  The family's unknown is eliminated, and the
determinant is factored.  `stability.bodies.disk_polynomials` stores the polynomials as
package data; tests/derivation/test_exact.py derives these polynomials again and compares.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import sympy

from ..algebra.number_types import Algebra, sympy_algebra
from ..algebra.upright import UPRIGHT
from ..base.errors import StabilityError, listed
from ..bodies.contact_laws import law_class
from ..bodies.disk_polynomials import FRICTION
from ..bodies.families import FAMILIES
from ..bodies.subject import disk_family
from ..systems.family import Family

LAM, K, MU, SIN, COS = sympy.symbols("lam k mu s c")
AT, SQUARE, M = sympy.symbols("at z M")
TRIG = sympy.Poly(SIN**2 + COS**2 - 1, COS)


@dataclass(frozen=True)
class Derived:
    """The reduced characteristic polynomial of a family under a law, in factors."""

    zeros: int
    """Multiplicity of the factor λ."""
    even: bool
    """Whether the rest of the polynomial is even in λ."""
    factors: tuple[sympy.Poly, ...]
    """Irreducible factors of the rest over Q, polynomials in σ; λ = σ mu for a law with mu."""


def derive(family: str, law: str) -> Derived:
    """The characteristic polynomial of a disk's family under a law, from its graph.

    Raises
    ------
    StabilityError
        If the graph does not have the form that this derivation needs; the form is checked.

    Examples
    --------
    >>> derive("spinning", "rough").factors[0].as_expr()
    k*lam**2 + k*z + lam**2 + z - 1
    """
    _refuse_form(family, law)
    resolved = disk_family(family, law)
    matrix, relation = _matrix(resolved)
    whole = sympy.Poly(matrix.charpoly(LAM).as_expr(), LAM)
    numerator = sympy.fraction(sympy.together(whole.as_expr()))[0]
    reduced = _reduced(sympy.expand(numerator), relation)
    _, factors = sympy.factor_list(reduced, *sorted(reduced.free_symbols, key=str))
    zeros = sum(n for f, n in factors if f.as_expr() == LAM)
    kept = [(sympy.sympify(f), n) for f, n in factors if sympy.sympify(f).has(LAM)]
    rest = [f for f, n in kept if f != LAM for _ in range(n)]
    even = all(_even(f) for f in rest)
    polys = tuple(_scaled(f, variables(family), even) for f in rest)
    return Derived(zeros, even, tuple(sorted(polys, key=lambda p: (p.degree(), str(p)))))


def _refuse_form(family: str, law: str) -> None:
    """Refuse a law or a family whose numbers are no variables of the stored polynomials."""
    numbers = {p.name: p.unit for p in law_class(law).parameters}
    if not numbers.items() <= FRICTION.items():
        known = listed([f"{n} [{unit}]" for n, unit in FRICTION.items()], "or")
        own = listed([f"{n} [{unit}]" for n, unit in numbers.items()])
        raise StabilityError(
            f"the {law} law has {own}; polynomials are derived for laws of {known} alone."
        )
    theta = FAMILIES[family].disk_held.get("theta", UPRIGHT)
    if theta is not UPRIGHT:
        raise StabilityError(
            f"{family} holds theta at {theta}, whose sine is no rational number; polynomials are "
            "derived for families that are upright or named by theta."
        )


def variables(family: str) -> tuple[sympy.Symbol, ...]:
    """Variables of the coefficients: k, M = mu*² and z = at*² or s = sinθ (or both)."""
    record = FAMILIES[family]
    friction = () if record.law else (M,)  # families of one law (smooth, rough) have no friction
    turning = (SQUARE,) if set(record.at) - {"theta"} else ()
    return (K, *friction, *turning, *((SIN,) if "theta" in record.at else ()))


def algebra_of_angle() -> Algebra:
    """SymPy's algebra with one symbol for every sine and one for every cosine."""
    algebra = sympy_algebra()
    functions = dict(algebra.functions) | {"sin": lambda _: SIN, "cos": lambda _: COS}
    return replace(algebra, functions=functions)


def _matrix(family: Family) -> tuple[sympy.Matrix, sympy.Poly | None]:
    """The Jacobian at the family in SymPy, and the equation of its unknown."""
    algebra = algebra_of_angle()
    theta, unknown = sympy.symbols("theta unknown")  # theta occurs in sine and cosine only
    a = [theta if name == "theta" else AT for name in family.at]
    q = [K, MU][: len(family.parameters)]
    graph = family.graph
    if not family.unknown or family.closed:
        u = [sympy.Integer(0)] * len(family.unknown)
        return sympy.Matrix(graph.matrix.dense(algebra, [a, u, q])), None
    residual = graph.residual.dense(algebra, [a, [unknown], q])[0][0]
    top = sympy.fraction(sympy.together(residual))[0]
    found = [f for f, _ in sympy.factor_list(top)[1] if f.has(unknown)]
    if len(found) != 1:
        raise StabilityError(f"the equation of {family.name} has no single factor to solve.")
    matrix = sympy.Matrix(graph.matrix.dense(algebra, [a, [unknown], q]))
    return matrix, sympy.Poly(found[0], unknown)


def _reduced(top: sympy.Expr, relation: sympy.Poly | None) -> sympy.Expr:
    """The numerator modulo the family's relation and cos² + sin² = 1, without cosθ."""
    if relation is not None:
        unknown = relation.gen
        rest = sympy.rem(sympy.Poly(top, unknown), relation)
        top = sympy.fraction(sympy.together(rest.as_expr()))[0]
        if sympy.sympify(top).has(unknown):
            # only a power of the unknown, which is not zero, may be left as a common factor
            top = sympy.Poly(top, unknown)
            if len(top.terms()) != 1:
                raise StabilityError("the characteristic polynomial keeps the family's unknown.")
            top = top.LC()
    top = sympy.rem(sympy.Poly(top, COS), TRIG)
    if len(top.terms()) != 1:
        raise StabilityError("the characteristic polynomial keeps cosθ, not only its square.")
    return sympy.factor_terms(sympy.expand(top.LC()))


def _even(factor: sympy.Expr) -> bool:
    return all(power % 2 == 0 for (power,) in sympy.Poly(factor, LAM).monoms())


def _scaled(factor: sympy.Expr, variables: tuple[sympy.Symbol, ...], even: bool) -> sympy.Poly:
    """A factor with M = mu², z = at² and, where it is not even, λ = σ mu; leading sign positive.

    The flow reversed in time is the flow with mu reversed.  So each factor is even or odd in
    (λ, mu) together, and only mu² is left after the scaling; the code checks this evenness.
    """
    poly = sympy.Poly(factor, LAM, MU, AT)
    total = min(i + j for i, j, _ in poly.monoms())
    expression = sympy.Integer(0)
    for (i, j, n), c in poly.terms():
        power = (i + j if not even else j) - (0 if even else total)
        if power % 2 or n % 2:
            raise StabilityError(f"the factor {factor} is not even in (λ, mu) and at.")
        expression += c * LAM**i * M ** (power // 2) * SQUARE ** (n // 2)
    result = sympy.Poly(sympy.expand(expression), LAM, *variables)
    result = result.primitive()[1]
    lead = result.as_expr().subs(
        {K: sympy.Rational(1, 3), M: 1, SQUARE: 1, SIN: sympy.Rational(1, 2)}
    )
    return -result if sympy.Poly(lead, LAM).LC() < 0 else result
