"""Theorem: for every k, which tumbling disks are stable, symbolic in k and θ."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import sympy

from stability.derivation.characteristic import COS, SIN, K, M

from ..proof import DISK_TESTS, Proof, Theorem
from ..signs import equal, positive_in_k, positive_in_strip
from .case import deciding
from .flutter import drift, premises

Expr = Any
"""A SymPy expression; SymPy states no types."""
N, X = sympy.symbols("N x")
"""N = mu*² sinθ and x = cos²θ."""
LIMIT = (sympy.sqrt(7) - 1) / 6
"""Largest k with a member that is stable for every mu; left out."""
ABOVE_LIMIT = sympy.Rational(2743, 10000)
"""A rational number just above `LIMIT`."""
STEEP = (1 - 3 * K) * (1 + 2 * K) * X - K
"""Sign of A."""
E = (9 * K**2 + 6 * K * (1 - K) * (1 - 4 * K) * X
     + (1 - 10 * K + K**2 + 24 * K**3 + 144 * K**4) * X**2)  # fmt: skip


@lru_cache(maxsize=1)
def coefficients() -> tuple[Expr, Expr, Expr]:
    """(A, B, C) of the flutter condition A N² + B N + C > 0, from the graph.

    A factor that is positive for every member is left out.
    """
    condition = sympy.expand(deciding("tumbling").conditions["flutter"].subs(M, N / SIN))
    folded = sympy.Integer(0)
    for (i, j), c in sympy.Poly(condition, N, SIN).terms():
        if j % 2:
            raise ValueError("the condition is not even in sinθ")
        folded += c * N**i * (1 - X) ** (j // 2)
    number, factors = sympy.factor_list(sympy.expand(folded))
    kept = number
    for factor, power in factors:
        if factor.has(N):
            kept = kept * factor**power
        elif not positive_in_strip(factor, X):
            raise ValueError(f"the sign of the factor {factor} is not proved")
    poly = sympy.Poly(sympy.expand(kept), N)
    if poly.degree() != 2:
        raise ValueError(f"the condition has degree {poly.degree()} in N, not 2")
    a, b, c = poly.all_coeffs()
    return a, b, c


@lru_cache(maxsize=1)
def tumbling() -> Theorem:
    """Tumbling for every k and θ; some seconds at first use."""
    proof = Proof()
    premises(proof, "tumbling", {"flutter"})
    proof.step(
        "with N = mu*² sinθ and x = cos²θ the flutter polynomial is A N² + B N + C, times a "
        "positive factor",
        "expansion, sin²θ = 1 - x",
        lambda: (
            True,
            "; ".join(
                f"{name} = {sympy.factor(c)}" for name, c in zip("ABC", coefficients(), strict=True)
            ),
        ),
    )
    proof.step(
        "A has the sign of (1-3k)(1+2k)x - k",
        "factors of A: the other is positive for k in (0, 1/2], 0 < x < 1",
        _sign_of_a,
    )
    proof.step(
        "C > 0",
        "C is x times a polynomial that is positive for k < 1/2, 0 < x < 1; at "
        "k = 1/2 it is x (1 - x) times a positive number",
        _c_is_positive,
    )
    proof.step(
        "B² - 4AC = 16k²(2k+1)² [2k+(2-3k)x]² E, with E a quadratic polynomial in x",
        "identity",
        _discriminant,
    )
    proof.step(
        "A ≥ 0 for some x < 1 needs k < (√7-1)/6 = 0.27429…",
        "(1-3k)(1+2k) - k = 1 - 2k - 6k² falls in k and vanishes there",
        _limit,
    )
    proof.step(
        "where A ≥ 0, B > 0: then A N² + B N + C > 0 for every N > 0",
        "B/(4k(2k+1)) = 6k² + k(8-25k)x + (2-7k+9k²-36k³)x², each coefficient positive for "
        "k ≤ 0.2743 (Sturm)",
        _b_is_positive,
    )
    proof.step(
        "where A < 0 < C, A N² + B N + C has one positive root N_b, simple, and is positive "
        "exactly for 0 ≤ N < N_b",
        "Descartes' rule: one change of sign, C > 0; N_b = 2C/(√(B²-4AC) - B)",
        _root,
    )
    drift(proof, "tumbling", sympy.Rational(3, 2) * COS)
    proof.conclude(
        "the statements hold for 0 < θ < π/2, and by reflection for π/2 < θ < π",
        "the steps above; the conditions hold sinθ alone",
    )
    return Theorem(
        "tumbling for every k",
        ("Let x = cos²θ and mu*² = mu² g R.",
         "If x ≥ k/((1-3k)(1+2k)) with 1 - 3k > 0, which needs k < (√7-1)/6 = 0.27429…: stable for "
         "every mu.",
         "Otherwise stable exactly for mu*² < M_b = 2C/((√(B²-4AC) - B) sinθ), unstable for "
         "mu*² > M_b, with",
         "A = (2k+1)² [k(4k+3)+(2k+1)x] [(1-3k)(1+2k)x-k],",
         "B = 4k(2k+1) [6k²+k(8-25k)x+(2-7k+9k²-36k³)x²],",
         "C = 96k³x [k+(1-3k)x] > 0,",
         "B² - 4AC = 16k²(2k+1)² [2k+(2-3k)x]² E, "
         "E = 9k²+6k(1-k)(1-4k)x+(1-10k+k²+24k³+144k⁴)x²."),
        ("0 < k ≤ 1/2, mu > 0, 0 < θ < π, θ ≠ π/2; viscous or linear viscous friction",
         "stable: every eigenvalue but the structural zero has a negative real part"),
        tuple(proof.steps),
        (f"{DISK_TESTS}::test_tumbling_is_stable_exactly_where_the_theorem_says",),
    )  # fmt: skip


def _sign_of_a() -> tuple[bool, str]:
    other = sympy.cancel(coefficients()[0] / STEEP)
    words = positive_in_strip(other, X)
    said = (2 * K + 1) ** 2 * (K * (4 * K + 3) + (2 * K + 1) * X)
    return bool(words) and equal(other, said), words


def _c_is_positive() -> tuple[bool, str]:
    c = coefficients()[2]
    said = equal(c, 96 * K**3 * X * (K + (1 - 3 * K) * X))
    inner = sympy.Poly(K + (1 - 3 * K) * X, X)
    # linear in x: at x = 0 it is k > 0, at x = 1 it is 1 - 2k ≥ 0
    ends = positive_in_k(inner.eval(0)) and equal(inner.eval(1), 1 - 2 * K)
    hoop = equal(c.subs(K, sympy.Rational(1, 2)), 6 * X * (1 - X))
    return said and ends and hoop, f"C = {sympy.factor(c)}, linear in x between k and 1 - 2k"


def _discriminant() -> bool:
    a, b, c = coefficients()
    square = 16 * K**2 * (2 * K + 1) ** 2 * (2 * K + (2 - 3 * K) * X) ** 2
    return equal(b**2 - 4 * a * c, square * E)


def _limit() -> bool:
    at_one = STEEP.subs(X, 1)
    return (
        equal(at_one, 1 - 2 * K - 6 * K**2)
        and positive_in_k(-sympy.diff(at_one, K))
        and sympy.simplify(at_one.subs(K, LIMIT)) == 0
        and bool(LIMIT < ABOVE_LIMIT)
    )


def _b_is_positive() -> bool:
    inner = sympy.Poly(sympy.cancel(coefficients()[1] / (4 * K * (2 * K + 1))), X)
    said = equal(inner.as_expr(), 6 * K**2 + K * (8 - 25 * K) * X
                 + (2 - 7 * K + 9 * K**2 - 36 * K**3) * X**2)  # fmt: skip
    return said and all(positive_in_k(c, 0, ABOVE_LIMIT) for c in inner.all_coeffs())


def _root() -> bool:
    a, b, c = coefficients()
    root = sympy.Symbol("r")  # √(B² - 4AC)
    at = 2 * c / (root - b)
    top = sympy.fraction(sympy.together(a * at**2 + b * at + c))[0]
    inserted = sympy.rem(sympy.Poly(sympy.expand(top), root),
                         sympy.Poly(root**2 - b**2 + 4 * a * c, root))  # fmt: skip
    return bool(sympy.expand(inserted.as_expr()) == 0)
