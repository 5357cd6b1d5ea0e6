"""Polynomials in x and y whose coefficients are balls: sines and roots of fixed numbers in them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from flint import arb

from ...algebra.exact.hurwitz_forms import Budget
from ...algebra.exact.number_fields import characteristic

Exponents = tuple[int, int]


@dataclass(frozen=True, eq=False)
class BallPolynomial:
    """A polynomial with a ball for each coefficient; no term means an exact zero."""

    terms: dict[Exponents, Any]
    """Ball by exponents of x and y."""

    @classmethod
    def number(cls, value: Any) -> BallPolynomial:
        """A constant."""
        return cls({(0, 0): arb(value)})

    def __reduce__(self) -> Any:
        """For other processes: the bounds of each ball, exactly."""
        parts = {e: (_bits(c.mid()), _bits(c.rad())) for e, c in self.terms.items()}
        return _rebuilt, (parts,)

    def __add__(self, other: Any) -> BallPolynomial:
        out = dict(self.terms)
        for e, c in _terms(other).items():
            out[e] = out[e] + c if e in out else c
        return BallPolynomial(out)

    __radd__ = __add__

    def __neg__(self) -> BallPolynomial:
        return BallPolynomial({e: -c for e, c in self.terms.items()})

    def __sub__(self, other: Any) -> BallPolynomial:
        return self.__add__(-other)

    def __mul__(self, other: Any) -> BallPolynomial:
        out: dict[Exponents, Any] = {}
        for (i, j), c in self.terms.items():
            for (k, m), d in _terms(other).items():
                e = i + k, j + m
                out[e] = out[e] + c * d if e in out else c * d
        return BallPolynomial(out)

    __rmul__ = __mul__

    def __eq__(self, other: object) -> bool:
        """Whether both are the same object, or this is an exact zero and the other one 0."""
        return self is other or (other == 0 and self.is_zero())

    __hash__ = None  # type: ignore[assignment]

    def __len__(self) -> int:
        return len(self.terms)

    def is_zero(self) -> bool:
        """Whether every coefficient is exactly zero."""
        return all(c == 0 for c in self.terms.values())

    def is_constant(self) -> bool:
        """Whether this is a constant with a known sign."""
        return set(self.terms) <= {(0, 0)} and not (self.terms and self.terms[0, 0].contains(0))

    def leading_coefficient(self) -> Any:
        """The constant."""
        return self.terms.get((0, 0), arb(0))


def ball_determinants(coefficients: Sequence[BallPolynomial], budget: Budget) -> list[Any]:
    """Hurwitz determinants of order 1 … n - 1, without divisions.

    Parameters
    ----------
    coefficients
        Coefficients by powers of λ, lowest first.
    budget
        Limits of the work.
    """
    a = list(coefficients)[::-1]
    n = len(a) - 1
    out: list[Any] = []
    for size in range(1, n):
        rows = [
            [a[k] if 0 <= (k := 2 * (j + 1) - (i + 1)) <= n else 0 for j in range(size)]
            for i in range(size)
        ]
        found = characteristic(rows)[0] + BallPolynomial({})
        out.append(-found if size % 2 else found)
        budget.watch(out[-1])
    return out


def _terms(value: Any) -> dict[Exponents, Any]:
    return value.terms if isinstance(value, BallPolynomial) else {(0, 0): arb(value)}


def _bits(value: Any) -> tuple[int, int]:
    man, exp = value.man_exp()
    return int(man), int(exp)


def _rebuilt(parts: dict[Exponents, Any]) -> BallPolynomial:
    from ...algebra.balls import precision

    with precision(4096):
        return BallPolynomial(
            {
                e: arb(m[0]) * arb(2) ** m[1] + arb(0, arb(r[0]) * arb(2) ** r[1])
                for e, (m, r) in parts.items()
            }
        )
