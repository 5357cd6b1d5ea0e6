"""Stability conditions as formulas: polynomials, boundaries, limits, and statements for every mu.

SymPy computes everything from the polynomials of `stability.bodies.disk_polynomials`.
Hurwitz determinants are factored.  Boundaries are solved where they are at most quadratic.

A condition that is quadratic in at² or mu² has two roots; one of these may be no boundary of the
family.  The ranges hold for every k in (0, 1/2].  tests/derivation/test_branches.py proves them
from the polynomials and tries to refute them.

Through all mu the verdicts are followed by cylindrical decomposition of the condition.  The pattern
of verdicts along the family can change only where a leading coefficient, an end value
or a discriminant of the condition vanishes.  One exact sample in between shows the pattern.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, field
from fractions import Fraction
from functools import lru_cache
from itertools import combinations
from typing import Any

import sympy
from flint import Ordering, fmpq, fmpq_poly, fmpz_mpoly_ctx, fmpz_poly

from ..algebra.number_types import precision
from ..algebra.polynomial import Exact, Polynomial
from ..base.errors import ParameterError, shown
from ..bodies.disk_polynomials import exact_polynomial, known_polynomial
from ..bodies.families import FAMILIES, families_under
from .characteristic import LAM, MU, SIN, SQUARE, Derived, K, M
from .hurwitz import conditions, decisive, factored
from .signs import real_roots

NOWHERE = "no member: the root is complex, negative or outside the family"
_CIRCLING = (
    "sin(theta)**2 >= (2*k + 3 + sqrt(6*(k + 1)*(2*k + 1)**3))/(2*(4*k**2 + 6*k + 3)); "
    "unstable between the two, neutral for every phi_dot where they are not real"
)
_PRECESSION = (
    "sin(theta)**4 >= 3/4; unstable between the two, neutral for every phi_dot where they are not "
    "real"
)
WHERE = {
    ("spinning", "phi_dot**2"): (
        NOWHERE,
        "4*k/(2*k + 1)**2 < mu**2 < 24*k/((2*k + 1)*(4*k + 3))",
    ),
    ("spinning", "mu**2"): (NOWHERE, "phi_dot**2 > 1/k"),
    ("tumbling", "mu**2"): (
        NOWHERE,
        "(1 - 3*k)*(2*k + 1)*cos(theta)**2 < k; elsewhere tumbling is stable for every mu",
    ),
    ("circling", "phi_dot**2"): (_CIRCLING, _CIRCLING),
    ("precession", "phi_dot**2"): (_PRECESSION, _PRECESSION),
}
"""Ranges of the root with +√ and of the root with -√, by family and solved quantity."""
LIMITS = "limits in mu hold at each member, not uniformly along the family"
"""Meaning of the limits."""


def where(family: str, of: str, roots: int) -> tuple[str, ...]:
    """The range of each root, in the order in which they are printed.

    Returns
    -------
    tuple of str
        Empty strings for roots that are boundaries everywhere.

    Examples
    --------
    >>> where("spinning", "mu**2", 2)[1]
    'phi_dot**2 > 1/k'
    """
    ranges = WHERE.get((family, of), ())
    return ranges if len(ranges) == roots else ("",) * roots


ROOT_BITS, DIGITS = 1024, 300
"""Bits and digits of irrational roots, far more than any pair of roots so far needs."""
Expr = Any
"""A SymPy expression; SymPy states no types."""


@dataclass(frozen=True)
class Range:
    """An interval of mu over which the verdicts along a family have one pattern."""

    low: str
    """mu*² at its low end: exact, a formula in k, or 20 digits of a root (0 for none)."""
    high: str
    """mu*² at its high end, in the same form (oo for none)."""
    mu_low: float
    """mu* at its low end (at k = 1/4 for a formula in k)."""
    mu_high: float
    """mu* at its high end (at k = 1/4 for a formula in k)."""
    pattern: str
    """Verdicts in order along the family, in words."""


class FlutterCondition:
    """The flutter condition along a family: verdicts in order, for each mu.

    Parameters
    ----------
    family
        Name of a family whose members one number names.
    condition
        Condition in k, M = mu*² and z = at*² or s = sinθ; positive where stable.
    static
        The static boundary, 0 where there is none; only verdicts beyond the boundary count.
    """

    def __init__(self, family: str, condition: Expr, static: Expr = 0) -> None:
        self.family, self.condition = family, condition
        record = FAMILIES[family]
        self.name = record.at[0]
        self.x = SIN if record.by_angle else SQUARE
        self.low: Expr = sympy.sympify(static)
        self.high: Expr = sympy.Integer(1) if record.by_angle else sympy.oo
        self.obligation = ""

    def critical(self, condition: Expr) -> list[Expr]:
        """Factors in M (and k) at whose zeros the pattern may change."""
        return [f for f in self._factors(condition) if f.has(M) and f != M]

    def _factors(self, condition: Expr) -> list[Expr]:
        """Factors of the leading and lowest coefficient, the discriminant and the end values."""
        poly = sympy.Poly(condition, self.x)
        expressions = [poly.LC(), sympy.discriminant(poly.as_expr(), self.x), poly.nth(0)]
        ends = [e for e in (self.low, self.high) if e is not sympy.oo]
        expressions += [sympy.fraction(sympy.together(condition.subs(self.x, e)))[0] for e in ends]
        factors: dict[Expr, None] = {}
        for expression_ in expressions:
            for factor in _irreducible(expression_):
                factors[factor] = None
        return list(factors)

    def for_one_k(self, k: Expr) -> list[Range]:
        """Ranges of mu for one inertia factor."""
        condition = self.condition.subs(K, k)
        line = FlutterCondition(self.family, condition, self.low.subs(K, k))
        critical = line.critical(condition)
        roots: list[Expr] = []
        for factor in critical:
            roots += [r for r in _real_roots(sympy.Poly(factor, M)) if r > 0]
        roots = sorted(set(roots))
        self.obligation = (
            "checked: between consecutive critical mu*² (zeros in mu*² of the leading coefficient, "
            "the end values and the discriminant of the flutter condition) no boundary is born or "
            "dies; the pattern is that of an exact sample in each"
        )
        edges: list[Expr] = [sympy.Integer(0), *roots, sympy.oo]
        samples = [_between(a, b) for a, b in zip(edges[:-1], edges[1:], strict=True)]
        patterns = [line.pattern(condition.subs(M, m)) for m in samples]
        return _merged(edges, patterns)

    def for_every_k(self) -> list[Range] | None:
        """Ranges of mu with ends as functions of k, or None if k in (0, 1/2] has several cells."""
        critical = self.critical(self.condition)
        half = sympy.Rational(1, 2)
        # a factor without M may change the pattern at some k
        watched: list[Expr] = [
            f for f in self._factors(self.condition) if f.has(K) and not f.has(M)
        ]
        alone = len(watched)
        for factor in critical:
            poly = sympy.Poly(factor, M)
            watched += [poly.LC(), poly.nth(0)]
            if poly.degree() > 1:
                watched.append(sympy.discriminant(factor, M))
        watched += [sympy.resultant(a, b, M) for a, b in combinations(critical, 2)]
        for expression_ in watched:
            for factor in _irreducible(expression_):
                if factor.has(K) and _roots_in(sympy.Poly(factor, K), half):
                    return None
        sample = self.for_one_k(sympy.Rational(1, 4))
        symbolic: list[Range] = []
        ends = {str(r.low): r for r in sample} | {str(r.high): r for r in sample}
        names: dict[str, str] = {"0": "0", "oo": "oo"}
        for end in ends:
            for factor in critical:
                poly = sympy.Poly(factor, M)
                if end not in names and poly.degree() == 1:
                    value = sympy.factor(-poly.nth(0) / poly.nth(1))
                    if value.subs(K, sympy.Rational(1, 4)) == sympy.sympify(end):
                        names[end] = str(value)
        if any(end not in names for end in ends):
            return None
        for r in sample:
            symbolic.append(Range(names[r.low], names[r.high], r.mu_low, r.mu_high, r.pattern))
        self.obligation = (
            f"checked: {len(critical)} critical polynomials in mu*² (leading coefficient, end "
            "values and discriminant of the flutter condition), whose "
            f"{len(watched) - alone} leading and constant coefficients, discriminants and pairwise "
            f"resultants, and the {alone} factors that hold no mu, have no zero for k in (0, 1/2]; "
            "so the order of their roots, and the pattern between them, is that of k = 1/4"
        )
        return symbolic

    def pattern(self, condition: Expr) -> str:
        """Verdicts in order along the family, at one mu and k."""
        poly = sympy.Poly(condition, self.x)
        roots = [r for r in sorted(set(_real_roots(poly))) if r > self.low]
        roots = [r for r in roots if self.high is sympy.oo or r < self.high]
        ends = [self.low, *roots, self.high]
        signs = []
        for a, b in zip(ends[:-1], ends[1:], strict=True):
            at = _between(a, b)
            signs.append("stable" if poly.eval(at) > 0 else "unstable")
        kept = [s for i, s in enumerate(signs) if i == 0 or s != signs[i - 1]]
        beyond = " beyond the static boundary" if self.low != 0 else ""
        if len(kept) == 1:
            return kept[0] + (beyond or f" for every {self.name}")
        turn = "the disk goes from flat to upright" if self.x is SIN else f"{self.name} grows"
        return f"{', then '.join(kept)} as {turn}{beyond}"


def _irreducible(expression_: Expr) -> list[Expr]:
    """Irreducible factors over Z, by Flint, since SymPy needs a minute for some polynomials."""
    expanded = sympy.expand(expression_)
    if not expanded.free_symbols:
        return []
    poly = sympy.Poly(expanded).clear_denoms(convert=True)[1]
    names = [str(g) for g in poly.gens]
    terms = {m: int(c) for m, c in poly.terms()}
    try:
        factors = fmpz_mpoly_ctx.get(names, Ordering.lex).from_dict(terms).factor()[1]
        dicts = [f.to_dict() for f, _ in factors]
    except OverflowError:  # python-flint cannot sort factors with long coefficients
        if len(names) > 1:
            return [sympy.expand(f) for f, _ in sympy.factor_list(expanded)[1]]
        whole = fmpz_poly([int(c) for c in reversed(poly.all_coeffs())])
        dicts = [{(i,): c for i, c in enumerate(f.coeffs()) if c} for f, _ in whole.factor()[1]]
    return [
        sympy.Poly({tuple(map(int, m)): int(c) for m, c in d.items()}, *poly.gens).as_expr()
        for d in dicts
    ]


def _real_roots(poly: sympy.Poly) -> list[Expr]:
    """Real roots: rational ones exactly, others to many digits."""
    roots: list[Expr] = []
    coefficients = [fmpq(int(c.p), int(c.q)) for c in reversed(poly.all_coeffs())]
    with precision(ROOT_BITS):
        for root in real_roots(fmpq_poly(coefficients)):
            exact = isinstance(root, fmpq)
            value = root if exact else root.mid().fmpq()
            number = sympy.Rational(int(value.p), int(value.q))
            roots.append(number if exact else sympy.Float(number, DIGITS))
    return roots


def _between(a: Expr, b: Expr) -> Expr:
    """A rational strictly between two real algebraic numbers; the second may be infinite."""
    if b is sympy.oo:
        return sympy.ceiling(a) + 1
    low, high = (sympy.Rational(v) for v in (a, b))
    middle, slack = (low + high) / 2, (high - low) / 10
    digits = 1
    while True:  # the shortest decimal that is well between
        short = sympy.Rational(str(sympy.N(middle, digits)))
        if low + slack < short < high - slack:
            return short
        digits += 1


def _roots_in(poly: sympy.Poly, high: Expr) -> bool:
    """Whether a polynomial in k has a zero in (0, high]."""
    return poly.degree() > 0 and bool(poly.count_roots(0, high) - (poly.eval(0) == 0))


def _merged(edges: Sequence[Expr], patterns: Sequence[str]) -> list[Range]:
    out: list[Range] = []
    start = 0
    for i, pattern in enumerate(patterns):
        if i + 1 < len(patterns) and patterns[i + 1] == pattern:
            continue
        low, high = edges[start], edges[i + 1]
        out.append(
            Range(
                _exactly(low),
                _exactly(high),
                float(sympy.sqrt(sympy.N(low, 30))),
                float("inf") if high is sympy.oo else float(sympy.sqrt(sympy.N(high, 30))),
                pattern,
            )
        )
        start = i + 1
    return out


def _exactly(value: Expr) -> str:
    """A rational in full; 20 digits of any other algebraic number."""
    if value.is_rational or value is sympy.oo:
        return str(value)
    return f"{sympy.N(value, 20)}…"


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

    Examples
    --------
    >>> expression(exact_polynomial("rolling", "viscous").conditions[0][1])
    2*k*z - 1
    """
    names = [sympy.Symbol(n) for n in polynomial.variables]
    return sympy.Add(
        *[c * sympy.prod(x**p for x, p in zip(names, e, strict=True)) for c, e in polynomial.terms]
    )


def derived(exact: Exact) -> Derived:
    """The cached polynomials in the form that `stability.derivation.hurwitz` takes."""
    names = [sympy.Symbol(n) for n in exact.variables]
    factors = tuple(
        sympy.Poly(sum(expression(c) * LAM**i for i, c in enumerate(f)), LAM, *names)
        for f in exact.factors
    )
    return Derived(exact.zeros, exact.even, factors)


def formulas(family: str, law: str, k: Sequence[str] = ()) -> Formulas:
    """Conditions, boundaries, limits and statements of a family under a law.

    Parameters
    ----------
    family, law
        Names of the family and of the contact law.
    k
        Inertia factors as exact numbers ("1/4", "0.3") for the ranges of mu.

    Raises
    ------
    ParameterError, NameUnknownError
        If k is not in (0, 1/2], or there is no such family or law.

    Source: tests/derivation/test_formulas.py tries to refute each statement.

    Examples
    --------
    >>> conditions = formulas("spinning", "viscous")
    >>> conditions.boundaries[0]
    {'kind': 'static', 'of': 'phi_dot**2', 'formula': '1/k'}
    >>> conditions.statements[0]
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
    exact = exact_polynomial(family, law)
    whole = derived(exact)
    asked, proved = decisive(whole)
    in_lambda = [_in_lambda(f, exact) for f in whole.factors]
    formulas = Formulas(
        family,
        law,
        exact.zeros,
        [str(f) for f in in_lambda],
        {name: str(value) for name, value in conditions(whole)},
        [{"kind": c.kind, "positive": str(factored(c.polynomial.as_expr()))} for c in asked],
        [{"name": o.name, "positive": str(o.polynomial), "proof": o.proof} for o in proved],
        [b for c in asked for b in _solved(c.kind, c.polynomial.as_expr(), family)],
        _limits([c.polynomial.as_expr() for c in asked]),
    )
    return Formulas(**(asdict(formulas) | _statements(family, exact, asked, k)))


def _in_lambda(factor: sympy.Poly, exact: Exact) -> Expr:
    """A factor in λ and mu again: σ = λ/mu, without powers of mu in a denominator."""
    if exact.even or "M" not in exact.variables:
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
    family: str, exact: Exact, asked: Sequence[Any], k: Sequence[str]
) -> dict[str, Any]:
    flutter = [c.polynomial.as_expr() for c in asked if c.kind == "flutter"]
    if not flutter or exact.even:
        return {"statements": _plain(family, exact, asked)}
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


def _plain(family: str, exact: Exact, asked: Sequence[Any]) -> list[str]:
    good = "neutral" if exact.even else "stable"
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
    """Family and law of every polynomial, for the given laws."""
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
    """
    asked = cases(laws)
    values = tuple(str(sympy.Rational(repr(float(x)))) for x in k)
    out = []
    for done, (family, law) in enumerate(asked, start=1):
        out.append(formulas(family, law, values))
        if progress:
            progress(done, len(asked))
    return out
