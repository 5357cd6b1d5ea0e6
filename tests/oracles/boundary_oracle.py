"""Boundaries of the disk counted apart from the package.

The characteristic polynomials come from Kane's equations (`kane_disk`), linearised and expanded
here by SymPy; tests/data/kane_polynomials.json keeps them.  Along an axis the constant term and the
Hurwitz determinant are expanded as polynomials of the axis, their real roots counted by Sturm's
chains and halved to thirty digits, and the verdict between is read from Routh's array over Q.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from pathlib import Path
from typing import Any

import mpmath
from flint import fmpq, fmpq_poly

DATA = Path(__file__).parents[1] / "data" / "kane_polynomials.json"
CASES = [
    *(
        (f, law)
        for law in ("smooth", "viscous", "linear-viscous", "rough")
        for f in ("rolling", "spinning", "tumbling")
    ),
    ("circling", "rough"),
]
NAMES = ("k", "M", "z", "s")

Terms = list[list[int]]


# --- derivation ---


def derive(family: str, law: str) -> list[Terms]:
    """Coefficients of a positive multiple of det(λ - A), λ = mu σ, lowest power of σ first.

    Each is a list of [coefficient, powers of k, M = mu², z = at², s = sinθ]; factors λ are left
    out.
    """
    import sympy as sp
    from kane_disk import kane_system
    from sympy.polys.matrices import DomainMatrix

    point = sp.symbols("s c s_phi c_phi theta_dot phi_dot omega3 slip_x slip_y k mu")
    s, c, sin_phi, cos_phi, theta_dot, w, o, slip_x, slip_y, k, mu = point
    system = kane_system(law)
    u_dot, forces = sp.symbols("d1:6"), sp.symbols("N F_x F_y")
    unknowns = [*u_dot, *forces]
    matrix, forcing = sp.Matrix(system.matrix(*point)), sp.Matrix(system.forcing(*point))
    states = [None, theta_dot, w, o, slip_x, slip_y][: 4 if law == "rough" else 6]
    rates = sp.Matrix(system.rates(*point, *u_dot))[: len(states), :]
    equations = matrix * sp.Matrix(unknowns) - forcing

    def slope(expression: Any, v: Any) -> Any:  # the first state is θ, known by sine and cosine
        if v is None:
            return expression.diff(s) * c - expression.diff(c) * s
        return expression.diff(v)

    by_state = sp.Matrix.hstack(*[slope(equations, v) for v in states])
    rates_by_state = sp.Matrix.hstack(*[slope(rates, v) for v in states])
    rates_by_unknown = rates.jacobian(unknowns)
    upright = {s: 1, c: 0}
    place = {sin_phi: 0, cos_phi: 1, theta_dot: 0, slip_x: 0, slip_y: 0}
    place |= {
        "rolling": upright | {w: 0},
        "spinning": upright | {o: 0},
        "tumbling": {o: 0},
        "circling": {},
    }[family]
    circling = {o: c * (k * w**2 * s - 1) / ((2 * k + 1) * w * s)} if family == "circling" else {}
    field = sp.QQ.frac_field(s, c, w, o, k, mu)

    def read(m: Any, more: Any = None) -> Any:
        m = m.subs(place).subs(circling)
        return DomainMatrix.from_Matrix(m.subs(more) if more else m).convert_to(field)

    steady = read(matrix).lu_solve(read(forcing)).to_Matrix()
    known = dict(zip(unknowns, steady, strict=True))
    jacobian = read(rates_by_state, known) - read(rates_by_unknown, known) * read(matrix).lu_solve(
        read(by_state, known)
    )
    z, M = sp.symbols("z M")
    out = []
    for power, value in enumerate(reversed(jacobian.charpoly())):
        e = sp.together(jacobian.domain.to_sympy(value) * mu**power)
        out.append(e * mu if len(states) % 2 else e)
    if family == "tumbling":
        out = [sp.together(e.subs(w, sp.sqrt(z))) for e in out]
    bottom = sp.Integer(1)
    for e in out:
        bottom = sp.lcm(bottom, sp.fraction(e)[1])
    polynomials = [sp.expand(sp.cancel(e * bottom)) for e in out]
    at = o if family == "rolling" else w
    polynomials = [_folded(sp, p, c, 1 - s**2) for p in polynomials]
    polynomials = [_folded(sp, _folded(sp, p, at, z), mu, M) for p in polynomials]
    if family == "tumbling":  # z = 1/(k s)
        degree = max(sp.degree(p, z) if p.has(z) else 0 for p in polynomials)
        polynomials = [
            sp.expand(sp.expand(p * (k * s) ** degree).subs(z, 1 / (k * s))) for p in polynomials
        ]
    while polynomials[0] == 0:
        polynomials = polynomials[1:]
    common = sp.gcd_list(polynomials)
    polynomials = [sp.expand(sp.cancel(p / common)) for p in polynomials]
    sign = (
        1
        if polynomials[-1].subs({k: sp.Rational(1, 4), M: 1, z: 1, s: sp.Rational(1, 2)}) > 0
        else -1
    )
    return [
        [
            [int(sign * coefficient), *map(int, powers)]
            for powers, coefficient in sp.Poly(p, k, M, z, s).terms()
            if coefficient != 0
        ]
        for p in polynomials
    ]


def _folded(sp: Any, p: Any, old: Any, square: Any) -> Any:
    """A polynomial even in a variable, by its square."""
    out = 0
    for (power,), coefficient in sp.Poly(p, old).terms():
        assert power % 2 == 0 or coefficient == 0
        out += coefficient * square ** (power // 2)
    return sp.expand(out)


@lru_cache
def polynomials() -> dict[str, list[Terms]]:
    """The kept polynomials by family and law."""
    found: dict[str, list[Terms]] = json.loads(DATA.read_text())
    return found


# --- along an axis ---


@dataclass(frozen=True)
class Change:
    """A change of verdict."""

    value: Any
    """mpmath, thirty digits or more."""
    stable_below: bool
    """Whether the stable or neutral side is below."""


def changes(
    family: str, law: str, axis: str, low: float, high: float, given: dict[str, float]
) -> list[Change]:
    """Every change of verdict on the closed interval.

    `given` holds what is not the axis: at (or theta and phi_dot), lean, k, mu or c, mass, radius,
    gravity, as the package takes them.
    """
    exact = {n: fmpq(*float(v).as_integer_ratio()) for n, v in given.items()}
    angle = (
        axis
        if axis in ("theta", "lean")
        else "theta"
        if (family, axis) == ("tumbling", "at")
        else ""
    )
    coefficients = _along(family, law, axis, exact, angle)
    n = len(coefficients) - 1
    critical = coefficients[0] * coefficients[-1]
    even = all(c.is_zero() for c in coefficients[1::2])
    if not even and n > 1:
        critical = critical * _hurwitz(coefficients)
    if even and n == 4:
        c, _, b, _, a = coefficients
        critical = critical * (b * b - 4 * a * c)
    if angle:
        ends = fmpq(0), fmpq(1)
        critical = critical * fmpq_poly([0, -1, 1])
    else:
        ends = (fmpq(*v.as_integer_ratio()) for v in (low, high))
    low_x, high_x = ends
    intervals = isolate(critical, low_x, high_x)
    verdicts = []
    edges = [
        low_x - fmpq(1, 10**40),
        *[e for pair in intervals for e in pair],
        high_x + fmpq(1, 10**40),
    ]
    for left, right in zip(edges[0::2], edges[1::2], strict=True):
        verdicts.append(good([c((left + right) / 2) for c in coefficients]))
    out = []
    with mpmath.workdps(45):
        for i, (left, right) in enumerate(intervals):
            if verdicts[i] == verdicts[i + 1]:
                continue
            middle = (left + right) / 2
            x = mpmath.mpf(int(middle.p)) / int(middle.q)
            if angle and not 1e-30 < x < 1 - mpmath.mpf("1e-30"):  # upright or flat: no crossing
                continue
            turned = verdicts[i]
            values = [(x, turned)]
            if angle == "theta":
                values = [(mpmath.asin(x), turned), (mpmath.pi - mpmath.asin(x), not turned)]
            if angle == "lean":
                values = [(-mpmath.acos(x), turned), (mpmath.acos(x), not turned)]
            inside = [(v, t) for v, t in values if not angle or low <= v <= high]
            out += [Change(v, t) for v, t in inside]
    return sorted(out, key=lambda c: c.value)


def _along(family: str, law: str, axis: str, exact: dict[str, Any], angle: str) -> list[Any]:
    """The characteristic polynomial with the axis as variable, times a power of it."""
    x = fmpq_poly([0, 1])
    one = fmpq_poly([1])
    v = {n: fmpq_poly([value]) for n, value in exact.items()}
    inverse = {n: fmpq_poly([1 / value]) for n, value in exact.items() if value != 0}
    shift = {n: 0 for n in NAMES}  # powers of 1/x in M and z
    v[axis], inverse[axis] = x, one
    if axis == "gravity":
        shift["z"] = 1
    place = {"k": v["k"], "M": one, "z": one, "s": one}
    if "mu" in v:
        place["M"] = v["mu"] * v["mu"] * v["gravity"] * v["radius"]
    elif "c" in v:
        place["M"] = (v["c"] * inverse["mass"]) ** 2 * v["radius"] * inverse["gravity"]
        shift["M"] = {"mass": 2, "gravity": 1}.get(axis, 0)
    turn = v.get("phi_dot", v.get("at"))
    if turn is not None:
        place["z"] = turn * turn * v["radius"] * inverse["gravity"]
    if angle:
        place["s"] = x
    elif family == "tumbling" or family == "circling":
        with mpmath.workdps(130):
            theta = exact.get("theta", exact.get("at"))
            if theta is None:
                lean = exact["lean"]
                sine = mpmath.cos(mpmath.mpf(int(lean.p)) / int(lean.q))
            else:
                sine = mpmath.sin(mpmath.mpf(int(theta.p)) / int(theta.q))
            place["s"] = fmpq_poly([fmpq(int(mpmath.nint(sine * 10**120)), 10**120)])
    table = polynomials()[f"{family} {law}"]
    most = max(
        sum(shift[n] * p for n, p in zip(NAMES, powers, strict=True))
        for terms in table
        for _, *powers in terms
    )
    powers_of = {n: [one] for n in NAMES}
    out = []
    for terms in table:
        total = fmpq_poly([0])
        for coefficient, *powers in terms:
            product = fmpq_poly([coefficient])
            down = 0
            for n, p in zip(NAMES, powers, strict=True):
                while len(powers_of[n]) <= p:
                    powers_of[n].append(powers_of[n][-1] * place[n])
                product = product * powers_of[n][p]
                down += shift[n] * p
            total = total + product * x ** (most - down)
        out.append(total)
    return out


def _hurwitz(coefficients: list[Any]) -> Any:
    """The Hurwitz determinant of order n - 1, expanded by the first column."""
    n = len(coefficients) - 1
    high = coefficients[::-1]

    def entry(i: int, j: int) -> Any:
        place = 2 * (j + 1) - (i + 1)
        return high[place] if 0 <= place <= n else fmpq_poly([0])

    def minor(rows: tuple[int, ...], columns: tuple[int, ...]) -> Any:
        if not rows:
            return fmpq_poly([1])
        total = fmpq_poly([0])
        for sign, row in enumerate(rows):
            e = entry(row, columns[0])
            if not e.is_zero():
                rest = minor(rows[:sign] + rows[sign + 1 :], columns[1:])
                total = total + e * rest * (-1) ** sign
        return total

    return minor(tuple(range(n - 1)), tuple(range(n - 1)))


def good(polynomial: list[Any]) -> bool:
    """Whether no root has a positive real part, by Routh's array over Q (or by λ²)."""
    if all(c == 0 for c in polynomial[1::2]):  # even: every λ² real and negative
        *squares, lead = (c / polynomial[-1] for c in polynomial[::2])
        assert lead == 1 and len(squares) <= 2
        two = len(squares) == 2
        return all(c > 0 for c in squares) and (not two or squares[1] ** 2 >= 4 * squares[0])
    high = polynomial[::-1]
    upper, lower = high[0::2], high[1::2]
    while lower:
        if not lower[0] / upper[0] > 0:
            return False
        ratio = upper[0] / lower[0]
        padded = [*lower[1:], fmpq(0)]
        upper, lower = lower, [u - ratio * v for u, v in zip(upper[1:], padded, strict=False)]
    return True


# --- Sturm ---


def isolate(p: Any, low: Any, high: Any) -> list[tuple[Any, Any]]:
    """Disjoint intervals (a, b) of width below 1e-33, each about one root in [low, high]."""
    p = p / p.gcd(p.derivative())
    chain = [p, p.derivative()]
    while chain[-1].degree() > 0:
        rest = -(chain[-2] % chain[-1])
        if rest.is_zero():
            break
        chain.append(rest / abs(rest.leading_coefficient()))

    def variations(x: Any) -> int:
        signs = [v > 0 for q in chain if (v := q(x)) != 0]
        return sum(a != b for a, b in zip(signs[:-1], signs[1:], strict=True))

    off = fmpq(1, 10**38)  # so that no end is a root
    a, b = low - off, high + off
    width = fmpq(1, 10**33)
    work = [(a, b, variations(a), variations(b))]
    out = []
    while work:
        a, b, left, right = work.pop()
        if left == right:
            continue
        if left - right == 1 and b - a < width:
            out.append((a, b))
            continue
        middle = (a + b) / 2
        if p(middle) == 0:
            middle = middle + (b - a) / 1024
        if left - right == 1:  # a simple root: its sign says where it is
            inside = (p(a) > 0) != (p(middle) > 0)
            work.append((a, middle, 1, 0) if inside else (middle, b, 1, 0))
            continue
        there = variations(middle)
        work += [(a, middle, left, there), (middle, b, there, right)]
    return sorted(out, key=lambda pair: Fraction(int(pair[0].p), int(pair[0].q)))


def main() -> None:
    """Derive everything and write it."""
    found = {f"{family} {law}": derive(family, law) for family, law in CASES}
    body = ",\n".join(f"{json.dumps(k)}: {json.dumps(v)}" for k, v in found.items())
    DATA.write_text("{\n" + body + "\n}\n")


if __name__ == "__main__":
    main()
