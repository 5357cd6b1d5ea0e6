"""How the thresholds of a coin move when its rim is rounded by a small radius ε.

Mass and moments stay those of the coin: I1 = k, I3 = 2k over m R².  The height changes in one of
two ways: sin θ + ε, the rim added outside, or (1-ε) sin θ + ε, the outer radius kept.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from typing import Any

import sympy
from flint import arb, fmpq

from stability.algebra.number_types import precision
from stability.derivation.characteristic import COS, MU, SIN, K, M
from stability.derivation.hurwitz import determinant

from . import rolling, spinning
from .body_polynomials import (
    BEND,
    I1,
    I3,
    PHI,
    RHO,
    SPIN,
    SQUARE,
    H,
    R,
    Z,
    characteristic,
    folded,
)

Expr = Any
"""A SymPy expression; SymPy states no types."""
EPS = sympy.Symbol("ε")
BITS = 200
"""Precision of balls."""
SCALED = {I1: I1 / H**2, I3: I3 / H**2, RHO: (H + BEND) / H}
"""Numbers over h(π/2), as `spinning` has them."""


def _zero(condition: Expr, rate: Expr) -> Expr:
    """The square of a rate at which a condition, linear in it, vanishes."""
    poly = sympy.Poly(sympy.expand(condition), rate)
    return sympy.factor(-poly.nth(0) / poly.nth(2))


THRESHOLDS: dict[tuple[str, str, str], Expr] = {
    ("rolling", "rough", "ω₃²"): _zero(rolling.WITHOUT_SLIP.subs(rolling.UPRIGHT), SPIN),
    ("rolling", "smooth", "ω₃²"): _zero(rolling.WITHOUT_FRICTION, SPIN),
    ("rolling", "viscous", "ω₃²"): _zero(rolling.FLUTTER, SPIN),
    ("spinning", "rough", "φ̇²"): _zero(spinning.WITHOUT_SLIP, PHI),
    ("spinning", "smooth", "φ̇²"): _zero(spinning.WITHOUT_FRICTION, PHI),
    ("spinning", "viscous", "φ̇²"): _zero(spinning.STATIC, PHI),
    ("spinning", "viscous", "mu² M1"): sympy.factor(spinning.M1.subs(SCALED) / H),
    ("spinning", "viscous", "mu² M2"): sympy.factor(spinning.M2.subs(SCALED) / H),
}
"""Thresholds of upright motion by family, law and quantity, from the theorems; m = g = 1."""
ROUNDED = {
    "h = sinθ + ε": {H: 1 + EPS, BEND: sympy.Integer(-1)},
    "h = (1-ε) sinθ + ε": {H: sympy.Integer(1), BEND: EPS - 1},
}
"""The height and its second derivative upright, by how the rim is rounded."""
COIN = {I1: K, I3: 2 * K}
INCLINED = {
    "h = sinθ + ε": {R: 1 + EPS * SIN, Z: EPS * COS, RHO: EPS},
    "h = (1-ε) sinθ + ε": {R: 1 - EPS + EPS * SIN, Z: EPS * COS, RHO: EPS},
}
"""r, z and ρ of tumbling."""


@dataclass(frozen=True)
class Shift:
    """A threshold of a coin and its change at first order in ε, symbolic in k."""

    family: str
    """Name of the family."""
    law: str
    """Name of the law."""
    quantity: str
    """What has the threshold."""
    rounded: str
    """The height."""
    value: Expr
    """Threshold of the thin disk."""
    slope: Expr
    """Derivative by ε at ε = 0."""


@lru_cache(maxsize=1)
def shifts() -> tuple[Shift, ...]:
    """Every threshold of upright motion, at first order.

    Examples
    --------
    >>> shifts()[0].value, shifts()[0].slope
    (1/(2*(2*k + 1)), -1/(2*k + 1)**2)
    """
    out = []
    for (family, law, quantity), formula in THRESHOLDS.items():
        for rounded, height in ROUNDED.items():
            exact = formula.subs(COIN).subs(height)
            value, slope = (sympy.factor(e.subs(EPS, 0)) for e in (exact, exact.diff(EPS)))
            out.append(Shift(family, law, quantity, rounded, value, slope))
    return tuple(out)


@lru_cache(maxsize=4)
def tumbling_polynomials(rounded: str, law: str = "viscous") -> tuple[Expr, Expr]:
    """The condition of tumbling at ε = 0 and its derivative by ε, in k, s = sinθ and M = mu².

    Examples
    --------
    >>> sympy.factor(tumbling_polynomials("h = sinθ + ε", "smooth")[0])
    -3*k**2*(s - 1)*(s + 1)
    """
    place = INCLINED[rounded]
    top, bottom = sympy.fraction(sympy.cancel(SQUARE.subs(COIN).subs(place)))
    if bottom.subs({K: 1, SIN: 1, EPS: 0}) < 0:
        top, bottom = -top, -bottom
    parts = [
        sympy.Poly(c.subs(COIN).subs(place), PHI)
        for c in characteristic("tumbling", law).coefficients
    ]
    degree = max(p.degree() for p in parts) // 2
    pairs = []
    for part in parts:  # every coefficient times the same power of the denominator
        whole = folded(
            sum(c * top ** (n // 2) * bottom ** (degree - n // 2) for (n,), c in part.terms())
        )
        if whole.has(COS):
            raise ValueError("a coefficient is not even in cosθ")
        by_eps = sympy.Poly(whole, EPS)
        pairs.append((by_eps.nth(0), by_eps.nth(1)))
    if law != "viscous":
        return pairs[-1]
    names = sympy.symbols(f"a:{len(pairs)}")
    last = determinant(sympy.Poly(names, sympy.Symbol("lam")), len(pairs) - 2)
    # in the ring of polynomials, where products are fast
    ring, *_ = sympy.ring([K, SIN, MU], sympy.ZZ)
    at, step = ([ring.from_expr(p[i]) for p in pairs] for i in (0, 1))
    moved = sum(_at(last.diff(n), names, at, ring) * d for n, d in zip(names, step, strict=True))
    return _in_m(_at(last, names, at, ring).as_expr()), _in_m(moved.as_expr())


def _at(expression: Expr, names: tuple[Expr, ...], values: list[Any], ring: Any) -> Any:
    """A polynomial in the names at elements of a ring."""
    total = ring.zero
    for powers, c in sympy.Poly(expression, *names).terms():
        term = ring(int(c))
        for value, power in zip(values, powers, strict=True):
            term = term * value**power
        total = total + term
    return total


def _in_m(expression: Expr) -> Expr:
    """A polynomial in mu², even in mu, over mu², in M."""
    poly = sympy.Poly(expression, MU)
    if any(n % 2 or n < 2 for (n,) in poly.monoms()):
        raise ValueError("the condition is not even in mu")
    return sum(c * M ** (n // 2 - 1) for (n,), c in poly.terms())


@dataclass(frozen=True)
class TumblingShift:
    """The limit of M = mu² of tumbling of a coin, and its change at first order in ε.

    At an inclination with sine s and cosine c tumbling is stable where A s² M² + B s M + C > 0,
    with C > 0.  Where A < 0 the limit is the one positive root.  It moves by ε dM/dε, with
    dM/dε = -2 D/(s E (2 A s² M + B s)) at the root.
    """

    rounded: str
    """A key of `INCLINED`."""
    a: Expr
    """A, a polynomial in k and c."""
    b: Expr
    """B, a polynomial in k and c."""
    c: Expr
    """C, a polynomial in k and c."""
    divisor: Expr
    """E, a polynomial in k and c; positive for k ≤ 1/2."""
    moved: tuple[Expr, ...]
    """Coefficients of D in M, the highest power first: polynomials in k and s."""

    @property
    def condition(self) -> Expr:
        """A s² M² + B s M + C."""
        return self.a * SIN**2 * M**2 + self.b * SIN * M + self.c

    @property
    def limit(self) -> Expr:
        """The root M, for A < 0."""
        return (self.b + sympy.sqrt(self.b**2 - 4 * self.a * self.c)) / (-2 * self.a * SIN)

    @property
    def slope(self) -> Expr:
        """dM/dε, with the root M in it."""
        top = sympy.Poly(list(self.moved), M).as_expr()
        return -2 * top / (SIN * self.divisor * (2 * self.a * SIN**2 * M + self.b * SIN))


@lru_cache(maxsize=4)
def tumbling_formula(rounded: str) -> TumblingShift:
    """The limit of mu² of tumbling of a coin at first order in ε, symbolic in k and sinθ."""
    value, slope = tumbling_polynomials(rounded)
    divisor = K + (1 - 3 * K) * COS**2
    ring = sympy.Poly(value, M)
    parts: list[Expr] = []
    for power in (2, 1, 0):
        own = sympy.cancel(ring.nth(power) / (SIN ** (6 + power) * K**10))
        in_cosine = sympy.Poly(own, SIN)
        if any(n % 2 for (n,) in in_cosine.monoms()):
            raise ValueError("the condition of tumbling is not even in sinθ")
        turned = sum(e * (1 - COS**2) ** (n // 2) for (n,), e in in_cosine.terms())
        parts.append(sympy.factor(sympy.cancel(turned / divisor)))
    moved = sympy.Poly(sympy.cancel(slope / (2 * SIN**5 * K**10)), M)
    if ring.degree() != 2 or not all(e.is_polynomial(K, COS, SIN) for e in (*parts, moved.LC())):
        raise ValueError("the condition of tumbling is not quadratic in M")
    a, b, c = parts
    coefficients = tuple(sympy.factor(e) for e in moved.all_coeffs())
    return TumblingShift(rounded, a, b, c, divisor, coefficients)


def tumbling_shift(
    rounded: str, k: Fraction | float, theta: Fraction | float
) -> tuple[arb, arb] | None:
    """mu² at the flutter boundary of tumbling of a coin, and its derivative by ε, enclosed."""
    found = tumbling_formula(rounded)
    with precision(BITS):
        near = [arb(fmpq(*v.as_integer_ratio())) for v in (k, theta)]
        given = {K: near[0], SIN: near[1].sin(), COS: near[1].cos()}
        a, b, c = (_ball(e, given) for e in (found.a, found.b, found.c))
        square = b * b - 4 * a * c
        if a >= 0 and c > 0 and (b >= 0 or square < 0):
            return None
        if not (a < 0 and c > 0):  # one sign change: one positive root
            raise ValueError(f"the limit of tumbling at {theta} is not enclosed")
        root = (b + square.sqrt()) / (-2 * a * given[SIN])
        return root, _ball(found.slope, given | {M: root})


def _ball(expression: Expr, given: dict[Expr, arb]) -> arb:
    """A rational expression with rational coefficients, at balls."""
    parts = []
    for part in sympy.fraction(sympy.together(expression)):
        total = arb(0)
        for powers, c in sympy.Poly(part, *given).terms():
            term = arb(fmpq(int(c.p), int(c.q)))
            for ball, power in zip(given.values(), powers, strict=True):
                term *= ball**power
            total += term
        parts.append(total)
    return parts[0] / parts[1]
