"""What is known of a family over two axes: its polynomial in factors, and the signs that decide."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from flint import Ordering, fmpq, fmpq_mpoly, fmpq_mpoly_ctx, fmpq_poly

from ...algebra.exact.hurwitz_forms import factors
from ...algebra.exact.number_fields import rational
from ...algebra.exact.routh import on_the_axis
from ...base.types import fields_of
from ...base.verdict import Verdict
from .ball_polynomials import BallPolynomial

Poly = Any
"""An `fmpq_mpoly` in x, y, λ, or a `BallPolynomial` in x and y."""
Rows = tuple[tuple[tuple[Poly, ...], bool, int], ...]
"""(coefficients by powers of λ lowest first, whether even, multiplicity) of each factor."""
RING = fmpq_mpoly_ctx.get(("x", "y", "l"), Ordering.degrevlex)
"""The ring of all slices: x, y and λ."""
MOST_FACTORED = 80
"""Terms of a condition beyond which its factors are not sought."""


@dataclass(frozen=True)
class Condition:
    """A polynomial as a sign times powers of factors, given by their place in a list."""

    sign: int
    """1, -1, or 0 for the polynomial zero."""
    powers: tuple[tuple[int, int], ...]
    """(place of the factor, power)."""


@dataclass(frozen=True, eq=False)
class Slice:
    """The polynomial and the conditions of a family in the axes of a map, over Q."""

    factors: Rows
    """(coefficients by powers of λ lowest first, whether even, multiplicity) of each factor."""
    surfaces: tuple[Poly, ...]
    """Polynomials in x and y whose signs are asked."""
    conditions: tuple[Condition, ...]
    """All positive: best verdict; one negative: unstable."""
    required: tuple[Condition, ...]
    """Positive at every member of the family."""
    nonzero: tuple[Condition, ...]
    """Not zero where the polynomial holds."""
    even: bool
    """Whether the best verdict is neutral."""

    def __reduce__(self) -> Any:
        """For other processes: polynomials as their terms."""
        return _unpacked, tuple(map(_packed, fields_of(self).values()))

    def verdict(self, x: float, y: float) -> Verdict | None:
        """The verdict of one cell over Q; None where it is no member, or this form fails.

        Parameters
        ----------
        x, y
            Doubles, taken as exact.
        """
        if any(isinstance(p, BallPolynomial) for p in self.surfaces):
            return None  # a ball proves no zero
        point = rational(x), rational(y), fmpq(0)
        signs = [_sign(p(*point)) for p in self.surfaces]
        value = [_value(c, signs) for c in self.required]
        if any(v <= 0 for v in value) or any(_value(c, signs) == 0 for c in self.nonzero):
            return None
        polys = [fmpq_poly([c(*point) for c in row]) for row, _, _ in self.factors]
        return on_the_axis(polys)


def _packed(value: Any) -> Any:
    if isinstance(value, fmpq_mpoly):
        return {tuple(map(int, e)): (int(c.p), int(c.q)) for e, c in value.to_dict().items()}
    return tuple(map(_packed, value)) if type(value) is tuple else value


def _rebuilt(value: Any) -> Any:
    if isinstance(value, dict):
        return RING.from_dict({e: fmpq(*c) for e, c in value.items()})
    return tuple(map(_rebuilt, value)) if type(value) is tuple else value


def _unpacked(*values: Any) -> Slice:
    return Slice(*map(_rebuilt, values))


def _sign(value: Any) -> int:
    return 1 if value > 0 else -1 if value < 0 else 0


def _value(condition: Condition, signs: Sequence[int]) -> int:
    out = condition.sign
    for place, power in condition.powers:
        out *= signs[place] ** power
    return out


class Table:
    """Polynomials in x and y, each kept once, and conditions as products of them."""

    def __init__(self) -> None:
        self.polys: list[Poly] = []

    def condition(self, *product: Poly) -> Condition:
        """A product of polynomials as a product of kept ones."""
        sign, powers = 1, Counter[int]()
        for poly in product:
            if poly == 0:  # neither positive nor negative: exact arithmetic decides each cell
                return Condition(0, ())
            if poly.is_constant():
                sign *= _sign(poly.leading_coefficient())
                continue
            whole = isinstance(poly, BallPolynomial) or len(poly) > MOST_FACTORED
            constant, found = (fmpq(1), [(poly, 1)]) if whole else factors(poly)
            sign *= _sign(constant)
            for factor, count in found:
                powers[self._place(factor)] += count
        return Condition(sign, tuple(powers.items()))

    def _place(self, poly: Poly) -> int:
        if poly not in self.polys:
            self.polys.append(poly)
        return self.polys.index(poly)
