"""Intervals of variables, and the rationals and roots inside them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from flint import fmpq, fmpq_poly

from ...algebra.exact.hurwitz_forms import by_power

Poly = Any
"""An `fmpq_mpoly`."""


@dataclass(frozen=True)
class Bounds:
    """An interval of a variable; None means no bound."""

    low: Any = None
    """Lower bound, a rational."""
    high: Any = None
    """Upper bound, a rational."""
    at_low: bool = False
    """Whether the lower bound itself is allowed."""
    at_high: bool = False
    """Whether the upper bound itself is allowed."""

    @property
    def free(self) -> bool:
        """Whether there is no bound."""
        return self.low is None and self.high is None

    def holds(self, value: Any) -> bool:
        """Whether a rational or a whole ball lies inside."""
        inside = self.low is None or value > self.low or (self.at_low and value == self.low)
        below = self.high is None or value < self.high or (self.at_high and value == self.high)
        return bool(inside and below)

    def outside(self, value: Any) -> bool:
        """Whether a rational or a whole ball lies outside."""
        under = self.low is not None and (
            value < self.low or (value == self.low and not self.at_low)
        )
        over = self.high is not None and (
            value > self.high or (value == self.high and not self.at_high)
        )
        return bool(under or over)

    def narrowed(self, low: Any, high: Any, allowed: bool) -> Bounds:
        """The interval cut by another one, whose bounds are allowed or not."""
        bottom, at_low, top, at_high = self.low, self.at_low, self.high, self.at_high
        if low is not None and (bottom is None or low >= bottom):
            bottom, at_low = low, allowed and (at_low or low != bottom)
        if high is not None and (top is None or high <= top):
            top, at_high = high, allowed and (at_high or high != top)
        return Bounds(bottom, top, at_low, at_high)


def number_of(poly: Any) -> Any:
    """The value of a constant polynomial; None counts as zero."""
    if poly is None or poly == 0:
        return fmpq(0)
    return poly.leading_coefficient()


def univariate(poly: Poly, index: int) -> Any:
    """A polynomial in one variable as an `fmpq_poly`.

    Parameters
    ----------
    poly
        The polynomial; no other variable occurs.
    index
        Index of the variable.
    """
    parts = by_power(poly, index)
    return fmpq_poly([number_of(parts.get(k)) for k in range(max(parts) + 1)])


def real_roots(poly: Any) -> list[Any]:
    """Real roots of an `fmpq_poly` as balls, sorted; a rational root is exact.

    Parameters
    ----------
    poly
        The polynomial, not zero.
    """
    found: list[Any] = []
    for factor, _ in poly.numer().factor()[1]:
        if factor.degree() == 1:
            found.append(fmpq(-int(factor[0]), int(factor[1])))
        elif factor.degree() > 1:
            found += [r.real for r, _ in factor.complex_roots() if r.imag == 0]
    return sorted(found, key=lambda r: r if isinstance(r, fmpq) else r.mid().fmpq())


def between(roots: Sequence[Any], low: Any, high: Any) -> Iterator[Any]:
    """Rationals between neighbouring roots and beyond the outer ones, within open bounds.

    Parameters
    ----------
    roots
        Sorted balls or rationals.
    low, high
        Rationals or None.
    """
    inner = [r if isinstance(r, fmpq) else r.mid().fmpq() for r in roots]
    inner = [r for r in inner if (low is None or r > low) and (high is None or r < high)]
    first = low if low is not None else (min(inner, default=fmpq(0)) - 1) * 2
    last = high if high is not None else (max(inner, default=fmpq(0)) + 1) * 2
    edges = [first, *inner, max(last, first + 1)] if high is None else [first, *inner, last]
    for a, b in zip(edges, edges[1:], strict=False):
        if a < b:
            yield short(a, b)


def short(low: Any, high: Any) -> Any:
    """The decimal of fewest digits well inside an interval.

    Parameters
    ----------
    low, high
        Rationals, low below high.

    Examples
    --------
    >>> short(fmpq(1, 3), fmpq(1, 2))
    2/5
    """
    slack = (high - low) / 10
    middle, scale = (low + high) / 2, fmpq(1)
    while scale < high - low:
        scale *= 10
    while True:
        value = fmpq(int((middle / scale + fmpq(1, 2)).floor())) * scale
        if low + slack < value < high - slack:
            return value
        scale /= 10
