"""Random systems with planted boundaries along an axis in which they are algebraic, not rational.

Real parts of eigenvalues are polynomials in sines, roots, or an unknown that obeys a polynomial
equation.  Integer matrices with determinant one hide them.  Truth is a closed form, or real roots
by SymPy to sixty digits, kept where they lie on the family's branch by mpmath.
"""

from __future__ import annotations

import random
from collections.abc import Callable
from typing import Any

import casadi as ca
import mpmath
import sympy
from transcendental_boundaries import Question

import stability as st

DIGITS = 60
LEFT = ca.DM([[1, 2, 0, 1], [3, 7, 1, 0], [0, 0, 1, 2], [0, 0, 1, 3]])
RIGHT = ca.DM([[7, -2, 13, -11], [-3, 1, -6, 5], [0, 0, 3, -2], [0, 0, -1, 1]])
Value = Callable[[Any, Any], Any]
"""(axis, module of functions) → value."""
P, U = sympy.symbols("p u", real=True)


def hidden(value: Any, kind: str) -> Any:
    """A matrix with the value as a real eigenvalue, or as the real part of a pair."""
    if kind == "pair":
        parts = [ca.blockcat([[value, -1.5], [1.5, value]]), ca.SX(-1), ca.SX(-2)]
    else:
        parts = [value, ca.SX(-3), ca.SX(-1), ca.SX(-0.5)]
    return ca.SX(LEFT) @ ca.diagcat(*parts) @ ca.SX(RIGHT)


def question(seed: int) -> Question:
    """A random question."""
    draw = random.Random(f"algebraic {seed}")
    kind = draw.choice(["turn", "turn", "root", "cubic", "cubic", "hyperbola", "gap"])
    with mpmath.workdps(DIGITS):
        return {
            "turn": _turn,
            "root": _root,
            "cubic": _cubic,
            "hyperbola": _hyperbola,
            "gap": _gap,
        }[kind](draw)


def _asked(
    draw: random.Random,
    kind: str,
    truth: Value,
    value: Value,
    zeros: list[Any],
    axis: Any,
    relation: Callable[[Any, Any], Any] | None = None,
    **options: Any,
) -> Question:
    """A family in which `value` of (axis or unknown) is planted; `truth` is of the axis alone."""
    p, u, x = ca.SX.sym("p"), ca.SX.sym("u"), ca.SX.sym("x", 4)
    shape = draw.choice(["real", "real", "pair"])
    words = ("a", "b", "c", "d")
    if relation is None:
        rates = hidden(value(p, ca), shape) @ x
        system = st.System("planted", x, p, rates, words, ("p",))
        family = st.Family(system, "fixed", ("p",), held=dict.fromkeys(words, 0.0))
    else:
        rates = hidden(value(ca.vertcat(u, p), ca), shape) @ x
        both = ca.vertcat(rates, relation(u, p))
        system = st.System("planted", ca.vertcat(x, u), p, both, (*words, "u"), ("p",))
        family = st.Family(
            system, "solved", ("p",), held=dict.fromkeys(words, 0.0), equations=("u",), **options
        )
    low, high = axis
    inside = sorted(z for z in zeros if low <= z <= high)
    return Question(family, ("p", low, high, 3), [truth], inside, lambda p: p, False, kind)


def _turn(draw: random.Random) -> Question:
    """Products of cos(m p) - r and sin(m p) - r, some squared."""
    parts: list[tuple[str, int, float, int]] = []
    for _ in range(draw.choice([1, 1, 2])):
        r = draw.choice([0.0, 0.5, -0.5, 1.0, -1.0, 0.75, 0.3, 1.5])
        parts.append(
            (
                draw.choice(["sin", "cos"]),
                draw.choice([1, 1, 2, 3]),
                r,
                1 if abs(r) == 1 else draw.choice([1, 1, 2]),
            )
        )
    size = draw.choice([1.0, -1.0, 0.25])

    def value(p: Any, f: Any) -> Any:
        out: Any = size
        for name, m, r, power in parts:
            for _ in range(power):
                out = out * (getattr(f, name)(m * p) - r)
        return out

    zeros = []
    for name, m, r, _ in parts:
        if abs(r) <= 1:
            a = getattr(mpmath, "a" + name)(mpmath.mpf(r))
            pair = [a, mpmath.pi - a] if name == "sin" else [a, -a]
            zeros += [(b + 2 * mpmath.pi * k) / m for b in pair for k in range(-20, 20)]
    return _asked(draw, "turn", value, value, zeros, draw.choice([(-1.0, 3.0), (0.0, 7.0)]))


def _root(draw: random.Random) -> Question:
    """√(p + a) - r, or p - r + √(p² + 1), perhaps times p - c or squared."""
    a, r, c = (draw.choice([0.5, 1.0, 2.0, 1.25]) for _ in range(3))
    plain, power = draw.random() < 0.5, draw.choice([1, 1, 2])
    size = draw.choice([1.0, -1.0])

    def value(p: Any, f: Any) -> Any:
        inner = f.sqrt(p + a) - r if plain else p - r + f.sqrt(p * p + 1)
        return size * (inner if power == 1 else inner * inner) * (p - c)

    zero = mpmath.mpf(r) ** 2 - a if plain else (mpmath.mpf(r) ** 2 - 1) / (2 * r)
    return _asked(draw, "root", value, value, [zero, mpmath.mpf(c)], (-0.25, 4.0))


def _polynomial(draw: random.Random) -> Any:
    """A polynomial in u, with some double zeros."""
    out = sympy.Integer(draw.choice([1, -1]))
    for _ in range(draw.choice([1, 2])):
        one = draw.choice(
            [
                U - sympy.Rational(draw.randint(-6, 6), 4),
                U**2 - draw.randint(1, 3),
                U**3 - U - draw.randint(-1, 1),
            ]
        )
        out *= one ** draw.choice([1, 1, 2])
    return sympy.expand(out)


def _cubic(draw: random.Random) -> Question:
    """The unknown is the only real root of u³ + k u = p."""
    k, poly = draw.choice([1, 2, 0.5]), _polynomial(draw)
    numbers = sympy.Poly(poly, U).all_coeffs()

    def at(u: Any) -> Any:
        out = 0 * u
        for c in numbers:
            out = out * u + float(c)
        return out / 4

    def truth(p: Any, _: Any) -> Any:
        roots = mpmath.polyroots([1, 0, k, -p], maxsteps=500, extraprec=400)
        return at(min(roots, key=lambda r: abs(mpmath.im(r))).real)

    zeros = [mpmath.mpf(str(sympy.N(r, DIGITS + 10))) for r in sympy.Poly(poly, U).real_roots()]
    return _asked(
        draw,
        "cubic",
        truth,
        lambda v, _: at(v[0]),
        [u**3 + k * u for u in set(zeros)],
        (-3.0, 5.0),
        lambda u, p: p - u**3 - k * u,
        unknown={"u": 0.3},
    )


def _hyperbola(draw: random.Random) -> Question:
    """U² = p² + k with u > 0; the planted line meets the other branch at other values."""
    k, a, b = (
        draw.choice([1, 2]),
        draw.choice([0.5, -0.5, 2.0, -1.0]),
        draw.choice([0.5, 1.5, -2.0]),
    )
    power = draw.choice([1, 1, 2])
    norm = (sympy.nsimplify(a) * P + sympy.nsimplify(b)) ** 2 - P**2 - k
    zeros = []
    for root in sympy.Poly(norm, P).real_roots() if norm.has(P) else []:
        p = mpmath.mpf(str(sympy.N(root, DIGITS + 10)))
        if abs(mpmath.sqrt(p * p + k) - a * p - b) < 1e-40:
            zeros.append(p)
    return _asked(
        draw,
        "hyperbola",
        lambda p, _: (mpmath.sqrt(p * p + k) - a * p - b) ** power,
        lambda v, _: (v[0] - a * v[1] - b) ** power,
        zeros,
        (-3.0, 3.0),
        lambda u, p: p * p + k - u * u,
        unknown={"u": 2.0},
        positive=("u",),
    )


def _gap(draw: random.Random) -> Question:
    """U² = (p - 1) (p - 2) with u > 0: no member from 1 to 2."""
    r = draw.choice([0.5, 1.0, 0.25, 3.0])
    zeros = [
        mpmath.mpf(1.5) + s * mpmath.sqrt(mpmath.mpf(0.25) + mpmath.mpf(r) ** 2) for s in (1, -1)
    ]

    def truth(p: Any, _: Any) -> Any:
        square = (p - 1) * (p - 2)
        return mpmath.sqrt(square) - r if square >= 0 else mpmath.mpf(-r)

    return _asked(
        draw,
        "gap",
        truth,
        lambda v, _: v[0] - r,
        zeros,
        (-1.0, 4.0),
        lambda u, p: (p - 1) * (p - 2) - u * u,
        unknown={"u": 1.0},
        positive=("u",),
    )
