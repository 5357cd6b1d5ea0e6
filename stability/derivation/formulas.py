"""Stability conditions as formulas: polynomials, boundaries, limits, and statements for every mu.

SymPy computes everything from the polynomials of `stability.bodies.disk_polynomials`.
Hurwitz determinants are factored.  Boundaries are solved where they are at most quadratic.  The
pattern of verdicts along a family is followed through all mu
(`stability.derivation.friction_ranges`).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, field
from fractions import Fraction
from functools import lru_cache
from typing import Any

import sympy

from ..algebra.exact.known_polynomial import Exact
from ..algebra.polynomial import Polynomial
from ..base.errors import ParameterError, shown
from ..bodies.disk_polynomials import exact_polynomial, known_polynomial
from ..bodies.families import FAMILIES, families_under
from .branches import where
from .characteristic import LAM, MU, SQUARE, Derived, M
from .friction_ranges import FlutterCondition, Range
from .hurwitz import conditions, decisive, factored

Expr = Any
"""A SymPy expression; SymPy states no types."""


@dataclass(frozen=True)
class Formulas:
    """Formulas of a family under a law, dimensionless (m = R = g = 1)."""

    family: str
    """Name of the family."""
    contact: str
    """Name of the contact law."""
    structural_zeros: int
    """Multiplicity of the factor λ, divided out."""
    polynomial: list[str]
    """Factors over Q of the rest, in λ, mu, k and at² or s = sin(theta)."""
    determinants: dict[str, str]
    """Coefficients and Hurwitz determinants that must be positive, factored (λ = σ mu, M = mu²)."""
    conditions: list[dict[str, str]]
    """Deciding conditions: kind and polynomial, positive on the stable (or neutral) side."""
    proved: list[dict[str, str]]
    """Other conditions, which hold wherever the deciding ones hold, each with its proof."""
    boundaries: list[dict[str, str]]
    """Solved boundaries: kind, solved quantity, formula, and `where` it holds (if stated)."""
    limits: dict[str, list[str]]
    """Factored leading terms of conditions as mu → 0 and mu → ∞; at each member, not uniformly."""
    statements: list[str] = field(default_factory=list)
    """Verdicts for whole ranges of mu, with the checked obligations."""
    ranges: list[dict[str, Any]] = field(default_factory=list)
    """Ranges of mu as data, each with its k ("all" for every k in (0, 1/2])."""


def expression(polynomial: Polynomial) -> Expr:
    """A polynomial of `stability.bodies.disk_polynomials` as a SymPy expression.

    Parameters
    ----------
    polynomial
        The polynomial.

    Examples
    --------
    >>> expression(exact_polynomial("rolling", "viscous").conditions[0][1])
    2*k*z - 1
    """
    names = [sympy.Symbol(n) for n in polynomial.variables]
    return sympy.Add(
        *[c * sympy.prod(x**p for x, p in zip(names, e, strict=True)) for c, e in polynomial.terms]
    )


def derived(known: Exact) -> Derived:
    """The cached polynomials in the form that `stability.derivation.hurwitz` takes.

    Parameters
    ----------
    known
        Result of `exact_polynomial`.

    Returns
    -------
    Derived
    """
    names = [sympy.Symbol(n) for n in known.variables]
    factors = tuple(
        sympy.Poly(sum(expression(c) * LAM**i for i, c in enumerate(f)), LAM, *names)
        for f in known.factors
    )
    return Derived(known.zeros, known.even, factors)


def formulas(family: str, law: str, k: Sequence[str] = ()) -> Formulas:
    """Conditions, boundaries, limits and statements of a family under a law.

    Parameters
    ----------
    family, law
        Names of the family and of the contact law.
    k
        Inertia factors as exact numbers ("1/4", "0.3") for the ranges of mu.

    Returns
    -------
    Formulas

    Raises
    ------
    ParameterError, NameUnknownError
        If k is not in (0, 1/2], or there is no such family or law.

    Source: tests/derivation/test_formulas.py tries to refute each statement.

    Examples
    --------
    >>> found = formulas("spinning", "viscous")
    >>> found.boundaries[0]
    {'kind': 'static', 'of': 'phi_dot**2', 'formula': '1/k'}
    >>> found.statements[0]
    'for every k in (0, 1/2] and mu*² < 4*k/(2*k + 1)**2: stable beyond the static boundary'
    """
    return _formulas(str(family), str(law), tuple(_inertia(value) for value in k))


def _inertia(value: Any) -> str:
    """An inertia factor as an exact number in (0, 1/2]."""
    try:
        number = Fraction(value)
    except (TypeError, ValueError, ZeroDivisionError, OverflowError):
        number = Fraction(-1)
    if not 0 < number <= Fraction(1, 2):
        raise ParameterError(f"k is {shown(value)}; give exact numbers in (0, 1/2], such as '1/4'.")
    return str(number)


@lru_cache(maxsize=32)
def _formulas(family: str, law: str, k: tuple[str, ...]) -> Formulas:
    known = exact_polynomial(family, law)
    whole = derived(known)
    asked, proved = decisive(whole)
    in_lambda = [_in_lambda(f, known) for f in whole.factors]
    found = Formulas(
        family,
        law,
        known.zeros,
        [str(f) for f in in_lambda],
        {name: str(value) for name, value in conditions(whole)},
        [{"kind": c.kind, "positive": str(factored(c.polynomial.as_expr()))} for c in asked],
        [{"name": o.name, "positive": str(o.polynomial), "proof": o.proof} for o in proved],
        [b for c in asked for b in _solved(c.kind, c.polynomial.as_expr(), family)],
        _limits([c.polynomial.as_expr() for c in asked]),
    )
    return Formulas(**(asdict(found) | _statements(family, known, asked, k)))


def _in_lambda(factor: sympy.Poly, known: Exact) -> Expr:
    """A factor in λ and mu again: σ = λ/mu, without powers of mu in a denominator."""
    if known.even or "M" not in known.variables:
        return factored(factor.as_expr())
    value = factor.as_expr().subs({LAM: LAM / MU, M: MU**2})
    return sympy.expand(sympy.fraction(sympy.together(value))[0])


def _solved(kind: str, condition: Expr, family: str) -> list[dict[str, str]]:
    """The boundary solved for at² and for mu², where the condition is at most quadratic."""
    out = []
    for variable in (SQUARE, M):
        if not condition.has(variable):
            continue
        poly = sympy.Poly(condition, variable)
        if poly.degree() > 2:
            continue
        of = f"{FAMILIES[family].at[-1]}**2" if variable is SQUARE else "mu**2"
        if poly.degree() == 1:
            roots = [sympy.factor(-poly.nth(0) / poly.nth(1))]
        else:
            roots = _quadratic(*poly.all_coeffs())
        ranges = where(family, of, len(roots)) if len(roots) == 2 else ("",)
        for root, text in zip(roots, ranges, strict=True):
            out.append({"kind": kind, "of": of, "formula": str(root)})
            if text:
                out[-1]["where"] = text
    return out


def _quadratic(a: Expr, b: Expr, c: Expr) -> list[Expr]:
    """Both roots, with squares taken out of √; the order of the roots depends on the point."""
    content, factors = sympy.factor_list(sympy.expand(b**2 - 4 * a * c))
    outer, inner = sympy.Integer(1), content
    for factor, power in factors:
        outer, inner = outer * factor ** (power // 2), inner * factor ** (power % 2)
    square = sympy.sqrt(content)
    if square.is_rational:
        outer, inner = outer * square, inner / content
    out = []
    for sign in (1, -1):
        # cancel the common factor of top and bottom
        common = sympy.gcd(sympy.gcd(sympy.expand(b), sympy.expand(2 * a)), sympy.expand(outer))
        top = -sympy.cancel(b / common) + sign * sympy.cancel(outer / common) * sympy.sqrt(inner)
        out.append(top / sympy.factor(sympy.cancel(2 * a / common)))
    return out


def _limits(polynomials: Sequence[Expr]) -> dict[str, list[str]]:
    """Factored coefficients of the lowest and highest power of M in each condition with M."""
    out: dict[str, list[str]] = {"mu -> 0": [], "mu -> oo": []}
    for polynomial in polynomials:
        if not polynomial.has(M):
            continue
        terms = sympy.Poly(polynomial, M).terms()
        out["mu -> 0"].append(str(factored(terms[-1][1])))
        out["mu -> oo"].append(str(factored(terms[0][1])))
    return out if out["mu -> 0"] else {}


# --- ranges of mu ---


def _statements(
    family: str, known: Exact, asked: Sequence[Any], k: Sequence[str]
) -> dict[str, Any]:
    flutter = [c.polynomial.as_expr() for c in asked if c.kind == "flutter"]
    if not flutter or known.even:
        return {"statements": _plain(family, known, asked)}
    [condition] = flutter
    if not condition.has(M):
        where = _solved("flutter", condition, family)[0]
        text = (
            f"for every k in (0, 1/2] and every mu: stable for {where['of']} > {where['formula']}, "
        )
        return {"statements": [text + "unstable below"]}
    statements: list[str] = []
    ranges: list[dict[str, Any]] = []
    static = next((c.polynomial.as_expr() for c in asked if c.kind == "static"), None)
    beyond: Expr = sympy.Integer(0)
    if static is not None:
        [slope, offset] = sympy.Poly(static, SQUARE).all_coeffs()
        beyond = sympy.cancel(-offset / slope)
    line = FlutterCondition(family, condition, beyond)
    general = line.for_every_k() if beyond != 0 else None
    if general is not None:
        statements += [f"for every k in (0, 1/2] and {_span(r)}: {r.pattern}" for r in general]
        statements.append(line.obligation)
        ranges += [{"k": "all", **asdict(r)} for r in general]
    for value in k:
        exactly = sympy.Rational(value)
        for r in line.for_one_k(exactly):
            statements.append(f"for k = {exactly} and {_span(r)}: {r.pattern}")
            ranges.append({"k": str(exactly), **asdict(r)})
    if k and general is None:
        statements.append(line.obligation)
    return {"statements": statements, "ranges": ranges}


def _plain(family: str, known: Exact, asked: Sequence[Any]) -> list[str]:
    good = "neutral" if known.even else "stable"
    if not asked:
        return [f"for every k in (0, 1/2] and every {FAMILIES[family].at[-1]}: {good}"]
    shown = [factored(c.polynomial.as_expr()) for c in asked]
    return [f"{good} where {value} > 0, unstable where it is negative" for value in shown]


def _span(r: Range) -> str:
    if r.low == "0" and r.high == "oo":
        return "every mu"
    if r.low == "0":
        return f"mu*² < {r.high}"
    return f"mu*² > {r.low}" if r.high == "oo" else f"{r.low} < mu*² < {r.high}"


def cases(laws: Sequence[str]) -> list[tuple[str, str]]:
    """Family and law of every polynomial, for the given laws.

    Parameters
    ----------
    laws
        Names of contact laws.
    """
    return [
        (family.name, law)
        for law in laws
        for family in families_under(law)
        if known_polynomial(family.name, law)
    ]


def rows(
    laws: Sequence[str], k: Sequence[float], progress: Callable[[int, int], None] | None = None
) -> list[Formulas]:
    """Formulas of every family under the given laws.

    Parameters
    ----------
    laws
        Names of contact laws.
    k
        Inertia factors for the ranges of mu, each taken as its shortest decimal.
    progress
        Called with (families done, families in all).

    Returns
    -------
    list of Formulas
    """
    asked = cases(laws)
    values = tuple(str(sympy.Rational(repr(float(x)))) for x in k)
    out = []
    for done, (family, law) in enumerate(asked, start=1):
        out.append(formulas(family, law, values))
        if progress:
            progress(done, len(asked))
    return out
