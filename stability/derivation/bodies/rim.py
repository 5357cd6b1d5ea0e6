"""How the thresholds of a coin move when its rim is rounded by a small radius ε.

Mass and moments stay those of the coin: I1 = k, I3 = 2k over m R².  The height changes in one of
two ways: sin θ + ε, the rim added outside, or (1-ε) sin θ + ε, the outer radius kept.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import sympy

from ..characteristic import COS, MU, SIN, K, M
from ..hurwitz import determinant
from ..theorems.motion import PHI, SPIN
from . import rolling, spinning
from .graph import BEND, I1, I3, RHO, H, R, Z, folded
from .polynomials import SQUARE, characteristic

Expr = Any
"""A SymPy expression; SymPy states no types."""
EPS = sympy.Symbol("ε")
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

    Parameters
    ----------
    rounded
        A key of `INCLINED`.
    law
        viscous: the Hurwitz determinant.  rough, smooth: the constant term.

    Examples
    --------
    >>> sympy.factor(tumbling_polynomials("h = sinθ + ε", "smooth")[0])
    -3*k**2*(s - 1)*(s + 1)
    """
    place = INCLINED[rounded]
    top, bottom = sympy.fraction(sympy.cancel(SQUARE.subs(COIN).subs(place)))
    if bottom.subs({K: 1, SIN: 1, EPS: 0}) < 0:
        top, bottom = -top, -bottom
    parts = [sympy.Poly(c.subs(COIN).subs(place), PHI) for c in characteristic("tumbling", law)
             .coefficients]  # fmt: skip
    degree = max(p.degree() for p in parts) // 2
    pairs = []
    for part in parts:  # every coefficient times the same power of the denominator
        whole = folded(sum(c * top ** (n // 2) * bottom ** (degree - n // 2)
                           for (n,), c in part.terms()))  # fmt: skip
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


def tumbling_shift(rounded: str, k: float, theta: float) -> tuple[tuple[float, float], ...]:
    """mu² at the flutter boundaries of tumbling of a coin, and its derivative by ε.

    Parameters
    ----------
    rounded
        A key of `INCLINED`.
    k
        Inertia factor.
    theta
        Inclination [rad].

    Returns
    -------
    tuple of (mu² [1/(g R)], derivative by ε)
        One pair for each positive root; roots in double precision of exact polynomials.
    """
    import math

    value, slope = (
        sympy.Poly(sympy.together(p.subs({K: k, SIN: math.sin(theta)})), M)
        for p in tumbling_polynomials(rounded)
    )
    roots = [complex(r) for r in value.nroots(n=20)]
    real = [r.real for r in roots if abs(r.imag) < 1e-12 and r.real > 0]
    return tuple((r, -float(slope.eval(r) / value.diff().eval(r))) for r in real)
