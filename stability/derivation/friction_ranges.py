"""Change of verdicts along a family with mu, by cylindrical decomposition of its condition.

The pattern of verdicts along the family can change only where a leading coefficient, an end value
or a discriminant of the condition vanishes.  One exact sample in between shows the pattern.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import sympy
from flint import Ordering, fmpz_mpoly_ctx, fmpz_poly

from ..algebra.number_types import precision
from ..bodies.families import FAMILIES
from .characteristic import SIN, SQUARE, K, M

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
        found = [poly.LC(), sympy.discriminant(poly.as_expr(), self.x), poly.nth(0)]
        ends = [e for e in (self.low, self.high) if e is not sympy.oo]
        found += [sympy.fraction(sympy.together(condition.subs(self.x, e)))[0] for e in ends]
        factors: dict[Expr, None] = {}
        for expression_ in found:
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
        dicts = [{(i,): c for i, c in enumerate(f.coeffs()) if c} for f in _factored(poly)]
    return [
        sympy.Poly({tuple(map(int, m)): int(c) for m, c in d.items()}, *poly.gens).as_expr()
        for d in dicts
    ]


def _factored(poly: sympy.Poly) -> list[Any]:
    """Irreducible factors of a polynomial in one variable, as `fmpz_poly`."""
    whole = poly.clear_denoms(convert=True)[1]
    return [f for f, _ in fmpz_poly([int(c) for c in reversed(whole.all_coeffs())]).factor()[1]]


def _real_roots(poly: sympy.Poly) -> list[Expr]:
    """Real roots: rational ones exactly, others to many digits."""
    roots: list[Expr] = []
    with precision(ROOT_BITS):
        for factor in _factored(poly):
            if factor.degree() == 1:
                roots.append(sympy.Rational(-int(factor[0]), int(factor[1])))
            else:
                found = [r.real.mid().fmpq() for r, _ in factor.complex_roots() if r.imag == 0]
                roots += [sympy.Float(sympy.Rational(int(r.p), int(r.q)), DIGITS) for r in found]
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
