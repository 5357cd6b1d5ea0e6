"""Characteristic polynomials of the disk's families over Q, in the variables that are stored.

No formula is typed in.  `CharacteristicPolynomial` reads the graph of a family with all its numbers
free.  Here cosθ is eliminated, and at, mu and λ are replaced by their squares and ratios.
tests/derivation derives the stored polynomials again and compares.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import sympy

from stability.algebra.exact.hurwitz_forms import Budget
from stability.algebra.exact.number_fields import NotExact
from stability.algebra.number_types import Algebra, sympy_algebra
from stability.algebra.upright import UPRIGHT
from stability.base.errors import StabilityError, listed
from stability.bodies.contact_laws import law_class
from stability.bodies.families import FAMILIES
from stability.bodies.subject import disk_family
from stability.derivation.characteristic import COS, LAM, MU, SIN, SQUARE, Derived, K, M
from stability.polynomials.characteristic import CharacteristicPolynomial

FRICTION = {"mu": "s/m", "c": "kg/s"}
"""Numbers of friction that a polynomial depends on, with their units; M is made of them."""
AT = sympy.Symbol("at")
TRIG = sympy.Poly(SIN**2 + COS**2 - 1, COS)
SYMBOLS = {"k": K, "mu": MU, "sin(theta)": SIN, "cos(theta)": COS, "phi_dot": AT, "omega3": AT}
"""Symbols of the numbers of a disk's family."""
MOST_TERMS = 100_000
"""Largest number of terms of a polynomial that is derived."""
SECONDS = 600.0
"""Longest time for it [s]."""


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
    budget = Budget(MOST_TERMS, SECONDS)
    try:
        whole = CharacteristicPolynomial(disk_family(family, law), {}, budget).factored
    except NotExact as error:
        raise StabilityError(f"{family} under the {law} law has no exact form: {error}.") from None
    symbols = [SYMBOLS.get(name) for name in whole.names]
    rest: list[sympy.Expr] = []
    for row, count in whole.factors:
        top = sum(_in_symbols(c, symbols) * LAM**k for k, c in enumerate(row))
        _, factors = sympy.factor_list(_without_cosine(top))
        rest += [f for f, n in factors if f.has(LAM) for _ in range(n * count)]
    even = all(_even(f) for f in rest)
    polys = tuple(_scaled(f, variables(family), even) for f in rest)
    return Derived(whole.zeros, even, tuple(sorted(polys, key=lambda p: (p.degree(), str(p)))))


def _refuse_form(family: str, law: str) -> None:
    """Refuse a law or a family whose numbers are no variables of the stored polynomials."""
    numbers = {p.name: p.unit for p in law_class(law).parameters}
    if not numbers.items() <= FRICTION.items():
        known = listed([f"{n} [{unit}]" for n, unit in FRICTION.items()], "or")
        own = listed([f"{n} [{unit}]" for n, unit in numbers.items()])
        raise StabilityError(
            f"the {law} law has {own}; polynomials are derived for laws of {known} alone."
        )
    theta, unknown = FAMILIES[family].disk_held.get("theta", UPRIGHT), FAMILIES[family].unknown
    if theta is not UPRIGHT or "theta" in unknown:
        how = "solves for theta" if "theta" in unknown else f"holds theta at {theta}"
        raise StabilityError(
            f"{family} {how}, whose sine is no rational number; polynomials are derived for "
            "families that are upright or named by theta."
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


def _in_symbols(poly: Any, symbols: Sequence[Any]) -> sympy.Expr:
    """A polynomial over Q as an expression."""
    total = sympy.Integer(0)
    for exponents, c in poly.to_dict().items():
        powers = [(x, int(n)) for x, n in zip(symbols, exponents, strict=False) if n]
        if any(x is None for x, _ in powers):
            raise StabilityError("the characteristic polynomial keeps an unknown or a function.")
        total += sympy.Rational(int(c.p), int(c.q)) * sympy.prod(x**n for x, n in powers)
    return total


def _without_cosine(top: sympy.Expr) -> sympy.Expr:
    """A polynomial by cos² + sin² = 1 without cosθ, up to a power of cosθ as a common factor."""
    top = sympy.rem(sympy.Poly(top, COS), TRIG)
    if len(top.terms()) != 1:
        raise StabilityError("the characteristic polynomial keeps cosθ, not only its square.")
    return sympy.expand(top.LC())


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
