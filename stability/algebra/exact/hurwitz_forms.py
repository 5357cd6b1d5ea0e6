"""Polynomials in parameters whose signs decide where the roots of another polynomial lie.

For a polynomial without symmetry these are coefficients and Hurwitz determinants, for an even
polynomial q(λ²) the coefficients and subdiscriminants of q.  All are elements of one ring over Q.
"""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Sequence
from typing import Any

from .number_fields import NotExact
from .routh import hurwitz_matrix

Poly = Any
"""An `fmpq_mpoly`."""
MOST_FACTORED = 2000
"""Number of terms beyond which a polynomial counts as one factor."""


class TooLarge(NotExact):
    """The work exceeds its limits; the message says terms and seconds."""


class Budget:
    """Limits of exact work: terms of a polynomial, terms of one product, seconds, and degree.

    Other work on the machine does not count, so that a busy one gives the same answers.

    Parameters
    ----------
    terms
        Largest number of terms of a polynomial.
    seconds
        Computing time of the thread that made the budget, after which work ends.
    degree
        Largest degree of a determinant in its variables.
    work
        Largest number of terms of all polynomials together.
    """

    def __init__(
        self, terms: int, seconds: float, degree: float = math.inf, work: float = math.inf
    ) -> None:
        self.terms, self.seconds, self.degree, self.work = terms, seconds, degree, work
        self.largest = 0
        """Largest number of terms so far."""
        self._start, self._used = time.monotonic(), time.thread_time()
        self._thread = threading.get_ident()

    @property
    def spent(self) -> float:
        """Seconds since the start; the wall clock, which is never behind, measures short times."""
        wall = time.monotonic() - self._start
        if wall <= self.seconds or threading.get_ident() != self._thread:
            return wall
        return time.thread_time() - self._used

    def watch(self, *polynomials: Poly) -> None:
        """Count the terms of polynomials, and end the work beyond the limits."""
        sizes = [len(p) for p in polynomials]
        self.largest = max(self.largest, *sizes)
        self.work -= sum(sizes)
        if self.largest > self.terms or self.work < 0 or self.spent > self.seconds:
            raise TooLarge(self.said())

    def expect(self, size: int, entries: Sequence[Poly]) -> None:
        """End the work before a determinant of some size whose degree may be beyond the limit."""
        if size * max(int(p.total_degree()) for p in entries) > self.degree:
            raise TooLarge(f"a polynomial of degree beyond {self.degree}")

    def product(self, p: Poly, q: Poly) -> Poly:
        """A product, refused beforehand where it is certain to take long."""
        if len(p) * len(q) > 100 * self.terms:
            self.largest = max(self.largest, len(p), len(q))
            raise TooLarge(self.said())
        out = p * q
        self.watch(out)
        return out

    def said(self) -> str:
        """Terms and seconds so far, with the limits."""
        return (
            f"{self.largest} terms after {self.spent:.1f} s (limits: {self.terms} terms, "
            f"{self.seconds:g} s)"
        )


def hurwitz_determinants(coefficients: Sequence[Poly], budget: Budget) -> list[Poly]:
    """Hurwitz determinants of order 1 … n - 1, by elimination without fractions.

    Parameters
    ----------
    coefficients
        Coefficients by powers of λ, lowest first, in one ring.
    budget
        Limits of the work.

    Returns
    -------
    list

    Source: E. H. Bareiss, Math. Comp. 22 (1968) 565-578.
    """
    lead = coefficients[-1]
    rows = hurwitz_matrix(coefficients, len(coefficients) - 2, lead - lead)
    return _leading_minors(rows, budget)


def subdiscriminants(coefficients: Sequence[Poly], budget: Budget) -> list[Poly]:
    """Subdiscriminants of order 2 … m: all positive exactly when all m roots are real and simple.

    Parameters
    ----------
    coefficients
        Coefficients of q(y), lowest first, with a positive leading coefficient.
    budget
        Limits of the work.

    Returns
    -------
    list
        Each up to a positive factor.

    Source: leading minors of Hermite's matrix of power sums; S. Basu, R. Pollack & M.-F. Roy,
    Algorithms in Real Algebraic Geometry, ch. 4.3.
    """
    a = list(coefficients)[::-1]
    m, lead = len(a) - 1, a[0]
    # power sums by Newton's identities, times lead^i
    sums: list[Poly] = [lead - lead + m]
    powers = [lead - lead + 1]
    for i in range(2 * m - 2):
        powers.append(budget.product(powers[i], lead))
    for i in range(1, 2 * m - 1):
        total = lead - lead
        for j in range(1, min(i, m) + 1):
            factor = budget.product(a[j], powers[j - 1])
            other = sums[i - j] if j < i else lead - lead + i
            total = total - budget.product(factor, other)
        sums.append(total)
    rows = [[sums[i + j] for j in range(m)] for i in range(m)]
    return _leading_minors(rows, budget)[1:]


def _leading_minors(rows: list[list[Poly]], budget: Budget) -> list[Poly]:
    """Leading principal minors; Bareiss while pivots are not zero, then one by one."""
    size, out = len(rows), []
    work = [list(row) for row in rows]
    previous = None
    for k in range(size):
        pivot = work[k][k]
        out.append(pivot)
        if pivot == 0:
            rest = [_determinant([r[:n] for r in rows[:n]], budget) for n in range(k + 2, size + 1)]
            return out + rest
        _eliminate(work, k, previous, budget)
        previous = pivot
    return out


def _determinant(rows: list[list[Poly]], budget: Budget) -> Poly:
    """A determinant by Bareiss' elimination, with exchanges of rows."""
    work, sign, previous = [list(r) for r in rows], 1, None
    size = len(work)
    for k in range(size - 1):
        place = next((i for i in range(k, size) if work[i][k] != 0), None)
        if place is None:
            return work[k][k]
        if place != k:
            work[k], work[place], sign = work[place], work[k], -sign
        _eliminate(work, k, previous, budget)
        previous = work[k][k]
    return work[-1][-1] * sign


def _eliminate(work: list[list[Poly]], k: int, previous: Poly | None, budget: Budget) -> None:
    """One step of Bareiss' elimination without fractions, in place."""
    for row in work[k + 1 :]:
        for j in range(k + 1, len(work)):
            value = budget.product(row[j], work[k][k]) - budget.product(row[k], work[k][j])
            row[j] = value if previous is None else value / previous
            budget.watch(row[j])


def by_power(poly: Poly, index: int) -> dict[int, Poly]:
    """Coefficients of a polynomial by powers of one variable.

    Parameters
    ----------
    poly
        The polynomial.
    index
        Index of the variable in the ring.

    Returns
    -------
    dict
        Only powers that occur.
    """
    parts: dict[int, dict[tuple[int, ...], Any]] = {}
    for exponents, c in poly.to_dict().items():
        rest = (*exponents[:index], 0, *exponents[index + 1 :])
        parts.setdefault(int(exponents[index]), {})[tuple(map(int, rest))] = c
    ring = poly.context()
    return {power: ring.from_dict(terms) for power, terms in sorted(parts.items())}


def coefficient_row(poly: Poly, index: int) -> list[Poly]:
    """Coefficients by powers of one variable, lowest first, zeros written out."""
    parts, zero = by_power(poly, index), poly.context().constant(0)
    return [parts.get(power, zero) for power in range(max(parts, default=0) + 1)]


def factors(poly: Poly) -> tuple[Any, list[tuple[Poly, int]]]:
    """A rational and the irreducible factors over Q, each primitive; unfactored where too large.

    Parameters
    ----------
    poly
        A polynomial, not zero.
    """
    if poly.is_constant():
        return poly.leading_coefficient(), []
    if len(poly) <= MOST_FACTORED:
        try:
            constant, factored = poly.factor()
        except OverflowError:  # python-flint cannot sort factors with long coefficients
            pass
        else:
            return constant, [(f, int(n)) for f, n in factored]
    return poly.leading_coefficient() ** 0, [(poly, 1)]
