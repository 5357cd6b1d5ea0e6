"""Theorem: the shape of tumbling's boundary M_b(θ), in three ranges of k.

M_b changes its direction only where the polynomial R(x, k) vanishes, a factor of the resultant of
the condition and of its derivative along θ.  In k the number of roots of R changes only at zeros
of its discriminant, leading coefficient and end values.  One exact count in each cell decides.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import sympy

from stability.derivation.characteristic import K

from ..proof import DISK_TESTS, Proof, Theorem
from ..signs import HALF, cells, equal, positive_in_k
from .case import M2
from .tumbling import STEEP, N, X, coefficients, tumbling

Expr = Any
"""A SymPy expression; SymPy states no types."""
FOLD = 128 * K**3 + 196 * K**2 + 31 * K - 36
"""Zero at k_f."""


def slope_form() -> sympy.Poly:
    """H(N, x) with the sign of dM_b/dsinθ at N = N_b: N ∂G/∂N - 2(1-x) ∂G/∂x."""
    a, b, c = coefficients()
    g = a * N**2 + b * N + c
    return sympy.Poly(sympy.expand(N * sympy.diff(g, N) - 2 * (1 - X) * sympy.diff(g, X)), N)


@lru_cache(maxsize=1)
def turning() -> tuple[sympy.Poly, Expr]:
    """R(x, k), and the rest of the resultant of G and H in N."""
    a, b, c = coefficients()
    condition = sympy.Poly(sympy.expand(a * N**2 + b * N + c), N)
    whole = sympy.resultant(condition, slope_form(), N)
    number, factors = sympy.factor_list(whole)
    simple = [f for f, power in factors if f.has(X) and power == 1]
    if len(simple) != 1:
        raise ValueError(f"the resultant has {len(simple)} simple factors with x, not 1")
    rest = number
    for factor, power in factors:
        rest *= factor**power if factor != simple[0] else 1
    return sympy.Poly(simple[0], X), rest


@lru_cache(maxsize=1)
def boundary_shape() -> Theorem:
    """The shape of M_b in θ; some seconds at first use."""
    proof = Proof()
    proof.step(
        "M_b is the boundary wherever A < 0",
        "theorem `tumbling for every k`",
        lambda: tumbling().proved,
    )
    proof.step(
        "as θ rises to π/2, M_b tends to M2; its slope in x = cos²θ there has the sign of "
        "36 - 31k - 196k² - 128k³",
        "expansion of N_b at x = 0",
        _upright,
    )
    proof.step(
        "at the other end M_b tends to infinity for k < 1/2",
        "A → 0 with B > 0 and C > 0 (k ≤ (√7-1)/6); otherwise sinθ → 0 with N_b > 0, as "
        "A < 0 < C at x = 1",
        _other_end,
    )
    proof.step(
        "k = 1/2: M_b tends to 0 as θ → 0",
        "C vanishes like 1 - x, with A < 0 and B < 0 at x = 1; M_b = N_b/sinθ",
        _hoop_end,
    )
    proof.step(
        "dM_b/dsinθ has the sign of H(N_b) = N ∂G/∂N - 2(1-x) ∂G/∂x, with G = A N² + B N + C",
        "implicit differentiation with N = M sinθ; ∂G/∂N < 0 at N_b",
        _slope_identity,
    )
    proof.step(
        "H(N_b) = 0 only where R(x, k) = 0",
        "resultant of G and H in N: R, times a factor that does not vanish for 0 < x < 1",
        _other_factor,
    )
    proof.step(
        "number of roots of R with A < 0, 0 < x < 1: none for k < k_f, one, simple, for "
        "k_f < k < 1/2",
        "its changes in k: zeros of the leading coefficient, the "
        "discriminant, R at both ends; Sturm's count at one k in each cell",
        _counts,
    )
    proof.step(
        "k_f = 0.32913651889476… is the one root of 128k³+196k²+31k-36 in (0, 1/2)",
        "Sturm, root isolation",
        _fold,
    )
    proof.step("k = 1/2: R has no root with 0 < x < 1", "Sturm", _hoop)
    proof.conclude(
        "k < k_f outside the zeros of those polynomials: no turning point, so M_b falls "
        "in θ from ∞ to M2; k_f < k < 1/2: M_b comes from ∞, rises to M2 at the end, "
        "and has at most one turning point, so exactly one minimum, below M2; "
        "k = 1/2: it rises from 0 to 6/5",
        "ends and number of turning points",
    )
    proof.conclude(
        "the same at those zeros in k",
        "M_b is analytic in x and continuous in k: a "
        "limit of monotone (one-minimum) functions is so too, and not constant on an "
        "interval, as it tends to ∞; for k > k_f its slope at the end is not zero",
    )
    proof.conclude(
        "elliptic where M_b falls in θ, hyperbolic where it rises",
        "the drift is to smaller θ (theorem `tumbling for every k`): to stable members "
        "where M_b falls; there dM_b/dθ ≠ 0, so the pair crosses with nonzero speed",
    )
    return Theorem(
        "shape of tumbling's boundary",
        ("M_b(θ), on the part of 0 < θ < π/2 where it exists, with M2 = 24k/((2k+1)(4k+3)) and "
         "k_f = 0.32913651889476… the root of 128k³+196k²+31k-36:",
         "k ≤ k_f: M_b falls strictly from ∞ to M2; elliptic.",
         "k_f < k < 1/2: M_b falls from ∞ to one minimum M_f(k) < M2 (elliptic) and then rises to "
         "M2 (hyperbolic).",
         "k = 1/2: M_b rises strictly from 0 to M2 = 6/5; hyperbolic."),
        ("0 < k ≤ 1/2; viscous or linear viscous friction",
         "elliptic or hyperbolic: by the direction of the drift along the family at leading "
         "order, where dM_b/dθ ≠ 0"),
        tuple(proof.steps),
        (f"{DISK_TESTS}::test_the_boundary_of_tumbling_has_the_stated_shape",),
    )  # fmt: skip


def _upright() -> tuple[bool, str]:
    a, b, c = (sympy.Poly(e, X) for e in coefficients())
    a0, b0 = a.eval(0), b.eval(0)
    if c.eval(0) != 0 or not positive_in_k(-a0) or not positive_in_k(b0):
        return False, "C(0), A(0) or B(0) is not as stated"
    start = sympy.cancel(-b0 / a0)
    slope = -(a.nth(1) * start**2 + b.nth(1) * start + c.nth(1)) / (2 * a0 * start + b0)
    slope = sympy.factor(slope + start / 2)  # M = N (1 - x)^(-1/2)
    ratio = sympy.cancel(-slope / FOLD)
    return equal(start, M2) and positive_in_k(ratio), f"dM_b/dx = {slope}"


def _other_end() -> bool:
    """C(1) > 0 for k < 1/2; the signs of A and B near the end are steps of `tumbling`."""
    steps = [s for s in tumbling().steps if s.claim.startswith(("A ≥ 0", "where A ≥ 0", "C > 0"))]
    known = len(steps) == 3 and all(s.proved for s in steps)
    return known and equal(coefficients()[2].subs(X, 1), 96 * K**3 * (1 - 2 * K))


def _hoop_end() -> bool:
    a, b, c = (e.subs(K, HALF) for e in coefficients())
    rest = sympy.cancel(c / (1 - X))
    return bool(a.subs(X, 1) < 0 and b.subs(X, 1) < 0 and rest.subs(X, 1) > 0)


def _slope_identity() -> bool:
    """d/ds of G(N, x) = 0 along M = N/s: s² G_N dM/ds = -H."""
    s, g_n, g_x, slope = sympy.symbols("s G_N G_x slope")
    n_slope = sympy.solve(g_n * slope + g_x * (-2 * s), slope)[0]  # x = 1 - s²
    m_slope = (n_slope * s - N) / s**2
    h = N * g_n - 2 * s**2 * g_x
    a, b, c = coefficients()
    g = a * N**2 + b * N + c
    stated = h.subs({g_n: sympy.diff(g, N), g_x: sympy.diff(g, X)}).subs(s**2, 1 - X)
    return equal(s**2 * g_n * m_slope, -h) and equal(stated, slope_form().as_expr())


def _other_factor() -> tuple[bool, str]:
    _, rest = turning()
    _, factors = sympy.factor_list(rest)
    for factor, _ in factors:
        if factor.has(X):
            poly = sympy.Poly(factor, X)
            # linear in x with values of one sign at both ends
            ends = [poly.eval(0), poly.eval(1)]
            one_sign = any(all(positive_in_k(sign * e) for e in ends) for sign in (1, -1))
            if poly.degree() > 1 or not one_sign:
                return False, f"the factor {factor} may vanish"
        elif not (positive_in_k(factor) or positive_in_k(-factor)):
            return False, f"the factor {factor} may vanish"
    return True, f"R = {turning()[0].as_expr()}"


def _watched() -> list[Expr]:
    """Polynomials in k at whose zeros the number of roots of R in the domain may change."""
    r, _ = turning()
    return [
        r.LC(), sympy.discriminant(r.as_expr(), X), r.eval(0), r.eval(1),
        sympy.resultant(r.as_expr(), STEEP, X), STEEP.subs(X, 1), sympy.LC(STEEP, X),
    ]  # fmt: skip


def inside(k: Expr) -> int:
    """Number of roots of R at a rational k with A < 0 and 0 < x < 1."""
    r = sympy.Poly(turning()[0].as_expr().subs(K, k), X, domain="QQ")
    lead = (1 - 3 * k) * (1 + 2 * k)
    end = min(sympy.Integer(1), k / lead) if lead > 0 else sympy.Integer(1)
    ends = sum(r.eval(e) == 0 for e in (sympy.Integer(0), end))
    return int(r.count_roots(0, end) - ends)


def _counts() -> tuple[bool, str]:
    roots, samples = cells(_watched())
    fold = [pair for pair in roots if _holds_fold(*pair)]
    if len(fold) != 1:
        return False, "k_f is not among the zeros"
    found = [(k, inside(k)) for k in samples]
    good = all(count == (1 if k > fold[0][1] else 0) for k, count in found)
    words = ", ".join(f"{float(k):.4f}: {count}" for k, count in found)
    return good, f"{len(roots)} zeros in (0, 1/2); roots at k = {words}"


def _holds_fold(low: Expr, high: Expr) -> bool:
    poly = sympy.Poly(FOLD, K)
    return bool(poly.eval(low) * poly.eval(high) < 0)


def _fold() -> tuple[bool, str]:
    poly = sympy.Poly(FOLD, K)
    near = sympy.Rational(32913651889476, 10**14)
    width = sympy.Rational(1, 10**14)
    one = poly.count_roots(0, HALF) == 1 and poly.eval(0) < 0
    ratio = sympy.cancel(turning()[0].eval(0) / FOLD)
    return (
        bool(one and poly.eval(near) * poly.eval(near + width) < 0)
        and (positive_in_k(ratio) or positive_in_k(-ratio)),
        f"R(0) = {sympy.factor(turning()[0].eval(0))}",
    )


def _hoop() -> bool:
    r = sympy.Poly(turning()[0].as_expr().subs(K, HALF), X, domain="QQ")
    ends = sum(r.eval(e) == 0 for e in (0, 1))
    return bool(r.count_roots(0, 1) == ends)
