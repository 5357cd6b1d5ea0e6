"""Equations of points of codimension two, from the coefficients of a characteristic polynomial.

With p(λ) = E(λ²) + λ O(λ²), where structural zeros are left out:

* double zero: the constant and the linear coefficient vanish;
* zero and a pair: the constant coefficient vanishes, and E and O of p(λ)/λ have a common root;
* two pairs: E and O have two common roots, so both coefficients of their first subresultant vanish.

Each is a pair of equations with simple solutions at a generic point.  Subresultants are minors of
the Bezout matrix.

Source: B. L. van der Waerden, Algebra I, § 34 (resultants); tests/boundary/test_codimension_two.py.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from flint import arb

from ....algebra.routh_balls import hurwitz_sign
from ..krawczyk import NotProvedError
from .point_records import PointKind

Poly = list[Any]
"""Coefficients, lowest power first, of any ring."""


@dataclass(frozen=True)
class Slope:
    """A number with its slopes along both axes, in balls."""

    value: Any
    """Value."""
    x: Any
    """Slope along x."""
    y: Any
    """Slope along y."""

    def __add__(self, other: Any) -> Slope:
        o = _slope(other)
        return Slope(self.value + o.value, self.x + o.x, self.y + o.y)

    def __sub__(self, other: Any) -> Slope:
        o = _slope(other)
        return Slope(self.value - o.value, self.x - o.x, self.y - o.y)

    def __mul__(self, other: Any) -> Slope:
        o = _slope(other)
        return Slope(
            self.value * o.value,
            self.x * o.value + self.value * o.x,
            self.y * o.value + self.value * o.y,
        )


def _slope(value: Any) -> Slope:
    return value if isinstance(value, Slope) else Slope(arb(value), arb(0), arb(0))


# --- Bezout ---


def halves(p: Poly) -> tuple[Poly, Poly]:
    """E and O of a polynomial E(λ²) + λ O(λ²)."""
    return p[::2], p[1::2]


def bezout(f: Poly, g: Poly) -> list[Poly]:
    """The Bezout matrix of two polynomials, the degree of `f` not below that of `g`."""
    size = len(f) - 1
    zero = f[0] - f[0]
    g = [*g, *[zero] * (size + 1 - len(g))]
    rows = [[zero] * size for _ in range(size)]
    for i in range(size):
        for j in range(size):
            total = zero
            for k in range(max(0, i + j + 1 - size), min(i, j) + 1):
                total = total + (f[i + j + 1 - k] * g[k] - f[k] * g[i + j + 1 - k])
            rows[i][j] = total
    return rows


def determinant(rows: Sequence[Sequence[Any]]) -> Any:
    """Determinant without divisions, by minors of the first rows; for small matrices."""
    minors: dict[int, Any] = {}
    for number, row in enumerate(rows):
        longer: dict[int, Any] = {}
        for j, entry in enumerate(row):
            for used, minor in minors.items() if number else ((0, None),):
                if used >> j & 1:
                    continue
                term = entry if minor is None else minor * entry
                swaps = bin(used >> (j + 1)).count("1")
                key = used | 1 << j
                term = (entry - entry) - term if swaps % 2 else term
                longer[key] = longer[key] + term if key in longer else term
        minors = longer
    return minors[(1 << len(rows)) - 1]


def subresultant(f: Poly, g: Poly, order: int) -> Poly:
    """Subresultant of an order as a polynomial, up to powers of the leading coefficient of `f`.

    Parameters
    ----------
    f, g
        Polynomials, the degree of `f` not below that of `g`.
    order
        Its degree at most; 0 for the resultant.

    Examples
    --------
    >>> subresultant([arb(2), arb(-3), arb(1)], [arb(-1), arb(1)], 1) == [arb(-1), arb(1)]
    True
    """
    size = len(f) - 1
    if order >= size:
        return list(f)
    rows = bezout(f, g)[order:]
    tail = list(range(order + 1, size))
    return [determinant([[row[j] for j in (i, *tail)] for row in rows]) for i in range(order + 1)]


def equations(kind: PointKind, p: Poly) -> list[Any] | None:
    """The two equations of a kind; None where the polynomial is too short for it.

    Parameters
    ----------
    kind
        Kind of point.
    p
        Coefficients, lowest first, in any ring.
    """
    degree = len(p) - 1
    if kind is PointKind.DOUBLE_ZERO:
        return [p[0], p[1]] if degree >= 2 else None
    if kind is PointKind.ZERO_HOPF:
        return [p[0], subresultant(*halves(p[1:]), 0)[0]] if degree >= 3 else None
    return subresultant(*halves(p), 1) if degree >= 4 else None


# --- what a solution is ---


@dataclass(frozen=True)
class Nature:
    """What a proved solution of the equations is."""

    frequencies: tuple[Any, ...]
    """ω of each pair, as balls, in increasing order."""
    others: int
    """1: every other eigenvalue is proved to be stable; -1: one is unstable; 0: open."""


def nature(kind: PointKind, p: Poly) -> Nature | None:
    """Pairs and other eigenvalues at a solution; None where no pair is on the imaginary axis.

    Parameters
    ----------
    kind
        Kind of point.
    p
        Coefficients as balls at the solution.

    Raises
    ------
    NotProvedError
        If it is not decided, as where more eigenvalues meet.
    """
    if _sign(p[-1]) < 0:
        p = [-c for c in p]
    if kind is PointKind.DOUBLE_ZERO:
        _sign(p[2])
        return Nature((), _stable(p[2:]))
    if kind is PointKind.ZERO_HOPF:
        d = p[1:]
        low, high = subresultant(*halves(d), 1)
        _sign(high)
        place = -low / high
        if _sign(place) > 0:
            return None
        return Nature(((-place).sqrt(),), _stable(_divided(d, [-place, arb(0), arb(1)])))
    low, middle, high = subresultant(*halves(p), 2)
    _sign(high)
    s, t = -middle / high, low / high
    spread = s * s - 4 * t
    if _sign(spread) < 0 or _sign(t) < 0 or _sign(s) > 0:
        return None
    root = spread.sqrt()
    pairs = (((-s - root) / 2).sqrt(), ((-s + root) / 2).sqrt())
    return Nature(pairs, _stable(_divided(p, [t, arb(0), -s, arb(0), arb(1)])))


def _sign(value: Any) -> int:
    if value > 0:
        return 1
    if value < 0:
        return -1
    raise NotProvedError


def _stable(p: Poly) -> int:
    return hurwitz_sign(p) if len(p) > 1 else 1


def _divided(p: Poly, by: Poly) -> Poly:
    """Quotient by a monic divisor, whose remainder is zero."""
    rest, size = list(p), len(by) - 1
    out = []
    for k in range(len(rest) - 1, size - 1, -1):
        lead = rest[k]
        out.append(lead)
        for j in range(size + 1):
            rest[k - size + j] = rest[k - size + j] - lead * by[j]
    return out[::-1]
