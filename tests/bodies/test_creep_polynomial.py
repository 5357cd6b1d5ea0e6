"""The characteristic polynomial of creep is the slow factor of the viscous disk's, in rationals.

With ε = 1/mu the viscous polynomial times ε² is a polynomial in λ and ε.  At ε = 0 it has the
degree 4, so it is a quartic whose roots stay finite, times a factor whose two roots grow like 1/ε.
By Hensel's lemma the monic quartic is unique as a series in ε.  So a monic quartic agrees with it
up to εⁿ exactly where it divides the polynomial up to εⁿ.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

import casadi as ca
import pytest
import sympy

from stability.algebra.number_types import Algebra
from stability.algebra.program import Program
from stability.bodies.contact_laws import CREEP, Viscous
from stability.bodies.thin_disk import disk_system

TERMS = 6
"""Terms of a series in ε, from ε⁻¹ to ε⁴: friction is ε⁻¹."""


@dataclass(frozen=True)
class Angle:
    """An angle with a rational sine and cosine."""

    sine: Fraction
    cosine: Fraction


class Series:
    """A series in ε with rational coefficients, from ε⁻ˢ on; s is carried along."""

    def __init__(self, coefficients: list[Fraction], low: int = 0) -> None:
        while len(coefficients) > 1 and coefficients[0] == 0:
            coefficients, low = coefficients[1:], low + 1
        self.c, self.low = coefficients[:TERMS], low

    def at(self, power: int) -> Fraction:
        i = power - self.low
        return self.c[i] if 0 <= i < len(self.c) else Fraction(0)

    def _of(self, other: object) -> Series:
        return other if isinstance(other, Series) else Series([Fraction(other)])  # type: ignore[arg-type]

    def __add__(self, other: object) -> Series:
        o = self._of(other)
        low = min(self.low, o.low)
        return Series([self.at(i) + o.at(i) for i in range(low, low + TERMS)], low)

    def __neg__(self) -> Series:
        return Series([-v for v in self.c], self.low)

    def __sub__(self, other: object) -> Series:
        return self + -self._of(other)

    def __rsub__(self, other: object) -> Series:
        return self._of(other) + -self

    def __mul__(self, other: object) -> Series:
        o = self._of(other)
        found = [
            sum(
                (
                    self.c[j] * o.c[i - j]
                    for j in range(i + 1)
                    if j < len(self.c) and i - j < len(o.c)
                ),
                Fraction(0),
            )
            for i in range(TERMS)
        ]
        return Series(found, self.low + o.low)

    __radd__, __rmul__ = __add__, __mul__

    def __truediv__(self, other: object) -> Series:
        o = self._of(other)
        assert o.c[0] != 0
        found: list[Fraction] = []
        for i in range(TERMS):
            mine = self.c[i] if i < len(self.c) else Fraction(0)
            rest = sum((found[j] * o.c[i - j] for j in range(i) if i - j < len(o.c)), Fraction(0))
            found.append((mine - rest) / o.c[0])
        return Series(found, self.low - o.low)

    def __rtruediv__(self, other: object) -> Series:
        return self._of(other) / self


def _power(x: Series, n: object) -> Series:
    exponent = n.c[0] if isinstance(n, Series) else Fraction(n)  # type: ignore[arg-type]
    assert exponent.denominator == 1
    found = Series([Fraction(1)])
    for _ in range(int(exponent)):
        found = found * x
    return found


RATIONAL_SERIES = Algebra(
    "rational series",
    lambda v: Series([Fraction(v)]),
    {"sin": lambda a: Series([a.sine]), "cos": lambda a: Series([a.cosine]), "pow": _power},
)

UPRIGHT = Angle(Fraction(1), Fraction(0))
MEMBERS = {
    "rolling": (Fraction(1, 4), UPRIGHT, 0, Fraction(6, 5)),
    "spinning": (Fraction(1, 3), UPRIGHT, Fraction(5, 2), 0),
    # k φ̇² sinθ = 1
    "tumbling": (Fraction(5, 16), Angle(Fraction(4, 5), Fraction(3, 5)), 2, 0),
}


def _polynomial(order: int | None, name: str) -> list[Series]:
    """Coefficients of the monic characteristic polynomial, from the leading one down."""
    law = Viscous if order is None else CREEP[order]
    system = disk_system(law)
    k, theta, phi_dot, omega3 = MEMBERS[name]
    n = len(system.states)
    slope = ca.densify(ca.jacobian(system.rhs, system.x))
    program = Program(ca.Function("slope", [system.x, system.p], [slope]))
    numbers = [Series([Fraction(v)]) for v in (0, phi_dot, omega3, 0, 0)][: n - 1]
    mu = [] if order == 0 else [Series([Fraction(1)], -1)]
    matrix = program.dense(RATIONAL_SERIES, [[theta, *numbers], [Series([k]), *mu]])
    # Faddeev and Le Verrier
    found, power = [Series([Fraction(1)])], matrix
    for i in range(1, n + 1):
        trace = sum((power[j][j] for j in range(n)), Series([Fraction(0)]))
        found.append(-trace / Series([Fraction(i)]))
        shifted = [[power[r][c] + (found[-1] if r == c else 0) for c in range(n)] for r in range(n)]
        power = [
            [
                sum((matrix[r][j] * shifted[j][c] for j in range(n)), Series([Fraction(0)]))
                for c in range(n)
            ]
            for r in range(n)
        ]
    return found


@pytest.mark.few(2)
@pytest.mark.parametrize("order", [0, 1, 2, pytest.param(3, marks=pytest.mark.long)])
@pytest.mark.parametrize("name", list(MEMBERS))
def test_the_polynomial_of_creep_is_the_slow_factor_up_to_its_order(name: str, order: int) -> None:
    eps, x = sympy.symbols("eps x")

    def as_expression(series: Series, lowest: int, highest: int) -> sympy.Expr:
        return sum(
            (
                sympy.Rational(series.at(p).numerator, series.at(p).denominator)
                * eps ** (p - lowest)
                for p in range(lowest, highest + 1)
            ),
            sympy.Integer(0),
        )

    whole = _polynomial(None, name)
    assert all(c.low >= -2 for c in whole if any(c.c))
    viscous = sum(as_expression(c, -2, 2) * x ** (6 - i) for i, c in enumerate(whole))
    slow = _polynomial(order, name)
    quartic = sum(as_expression(c, 0, order + 1) * x ** (4 - i) for i, c in enumerate(slow))
    rest = sympy.Poly(sympy.rem(viscous, quartic, x), eps)
    powers = {m[0] for m, c in rest.terms() if c != 0}
    assert min(powers, default=99) == order + 1
