"""Terms of a graph with exact rational numbers: fractions as long as possible, then quotients.

CasADi holds doubles and computes with two constants at once in doubles.  A third of x as a constant
times x would be another system than the user's.  So a rational number stays a `Fraction` next to
the graph, and enters the graph as operations: (2 · x) / 3.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any

import casadi as ca
import numpy as np

from ...base.errors import ParameterError
from ...base.types import Floats

Term = Any
"""A `Fraction`, or a CasADi SX scalar."""

ZERO, ONE, MINUS = Fraction(0), Fraction(1), Fraction(-1)
LEAST_PIVOT = 1e-9
"""Smallest nonzero pivot at a probe, over the largest entry of its row."""
NATURAL = 1e-3
"""Share of the best pivot that is enough for an entry of the natural order."""


def graph(term: Term) -> ca.SX:
    """A term as an SX; a fraction alone becomes the nearest double."""
    return ca.SX(float(term)) if isinstance(term, Fraction) else term


def plus(a: Term, b: Term) -> Term:
    """The sum a + b.

    Examples
    --------
    >>> x = ca.SX.sym("x")
    >>> ca.Function("f", [x], [plus(Fraction(1, 3), x)])(ca.DM(1) / 6)
    DM(0.5)
    """
    if isinstance(a, Fraction):
        a, b = b, a
    if not isinstance(b, Fraction) or isinstance(a, Fraction):
        return a + b
    if b == 0:
        return a
    if _double(b):
        return a + float(b)
    total = _scaled(b.denominator, a)
    for part in _parts(b.numerator):
        total = total + part
    return total / _denominator(b) if b.denominator != 1 else total


def times(a: Term, b: Term) -> Term:
    """The product a · b.

    Examples
    --------
    >>> x = ca.SX.sym("x")
    >>> ca.Function("f", [x], [times(Fraction(2, 3), x)])(0.75)  # (2 x) / 3
    DM(0.5)
    """
    if isinstance(b, Fraction):
        a, b = b, a
    if not isinstance(a, Fraction) or isinstance(b, Fraction):
        return a * b
    if a == 0 or a == 1:
        return b if a else ZERO
    if a == -1:
        return -b
    if _double(a):
        return float(a) * b
    scaled = _scaled(a.numerator, b)
    return scaled / _denominator(a) if a.denominator != 1 else scaled


def over(a: Term, b: Term) -> Term:
    """The quotient a / b."""
    if isinstance(b, Fraction):
        return times(a, 1 / b)
    if isinstance(a, Fraction):
        if a == 0:
            return ZERO
        top = Fraction(a.numerator)
        below = times(Fraction(a.denominator), b)
        return float(top) / below if _double(top) else times(top, 1 / below)
    return a / b


def power(base: Term, exponent: int) -> Term:
    """A whole power, by repeated squares."""
    if isinstance(base, Fraction):
        return base**exponent
    if exponent < 0:
        return over(ONE, power(base, -exponent))
    product: Term = ONE
    square = base
    while exponent:
        if exponent & 1:
            product = times(product, square)
        exponent >>= 1
        if exponent:
            square = square * square
    return product


def _double(value: Fraction) -> bool:
    try:
        return Fraction(float(value)) == value
    except OverflowError:
        return False


def _parts(value: int) -> list[float]:
    """Doubles whose sum is a whole number."""
    parts = []
    while value:
        try:
            part = float(value)
        except OverflowError:
            raise ParameterError(
                f"the equations hold a number of {value.bit_length()} bits; give it as a symbol, "
                "with its value as a parameter."
            ) from None
        parts.append(part)
        value -= int(part)
    return parts


def _scaled(number: int, term: ca.SX) -> ca.SX:
    """Return number · term, in two or more products where the number is no double."""
    if number == 1:
        return term
    products = [part * term for part in _parts(number)]
    return sum(products[1:], start=products[0])


def _denominator(value: Fraction) -> float:
    if not _double(Fraction(value.denominator)):
        raise ParameterError(
            f"the equations hold {value}, whose denominator has more than 53 bits; give the number "
            "as a symbol, with its value as a parameter."
        )
    return float(value.denominator)


class Probes:
    """Random and special numbers at which a matrix of terms is evaluated, to choose pivots."""

    COUNT = 6

    def __init__(self, x: ca.SX, p: ca.SX) -> None:
        self._symbols = [x, p]
        made = np.random.default_rng(7)  # the choice of pivots is the same in every run
        size = x.numel() + p.numel()
        points = made.uniform(0.3, 1.3, (self.COUNT, size))
        points[1::2, : x.numel()] *= -1
        special = made.uniform(0.3, 1.3, (1, size))
        special[:, : x.numel()] = 0.0  # rest at the origin: where removable singularities lie
        self._points = np.vstack([special, points])

    def values(self, matrix: Sequence[Sequence[Term]]) -> Floats:
        """The matrix at the points where it is finite, special points first, shape (K, n, n)."""
        n = len(matrix)
        entries = ca.vertcat(*[graph(t) for row in matrix for t in row])
        function = ca.Function("probe", [ca.vertcat(*self._symbols)], [entries])
        values = np.array(function(self._points.T)).T.reshape(-1, n, n)
        return values[np.isfinite(values).all(axis=(1, 2))]


def solve(
    matrix: Sequence[Sequence[Term]],
    right: Sequence[Term],
    stages: Sequence[tuple[Sequence[int], Sequence[int]]],
    probes: Probes,
) -> tuple[list[Term], list[tuple[int, int]]]:
    """Solve matrix · u = right by elimination, with pivots that do not vanish at the probes.

    In each stage a number is preferred as a pivot, then the natural order if it is sound, then the
    entry that is largest at all probes.

    Parameters
    ----------
    matrix, right
        Rows of terms, and the right-hand side.
    stages
        (rows, columns) of the blocks in the order of elimination; row i of a block belongs to its
        column i by nature.
    probes
        Where the pivots are tried.

    Returns
    -------
    solution, pivots
        Terms u, and (row, column) of each step.

    Raises
    ------
    ParameterError
        If the matrix is singular at every probe.

    Examples
    --------
    >>> a = ca.SX.sym("a")
    >>> rows = [[a, ONE], [ONE, ZERO]]  # no division by a
    >>> solve(rows, [ONE, a], [([0, 1], [0, 1])], Probes(a, ca.SX(0, 1)))[1]
    [(1, 0), (0, 1)]
    """
    rows, column_of = [list(r) for r in matrix], list(right)
    work = probes.values(matrix)
    order: list[tuple[int, int]] = []
    free_rows, free_columns = set(range(len(rows))), set(range(len(rows)))
    for some, others in [*stages, (range(len(rows)), range(len(rows)))]:
        twins = dict(zip(some, others, strict=True))
        while free_rows & set(some) and free_columns & set(others):
            tried = sorted(free_rows & set(some)), sorted(free_columns & set(others))
            pivot, work = _pivot(rows, work, tried, twins)
            if pivot is None:
                break  # a singular block: its rows are left to the last stage
            order.append(pivot)
            free_rows.discard(pivot[0])
            free_columns.discard(pivot[1])
            _step(rows, column_of, work, pivot, free_rows)
    if free_rows:
        raise ParameterError(
            "the mass matrix (or the constraints' matrix for the dependent ones) is singular at "
            "every sampled state; give equations that determine each acceleration."
        )
    return _back(rows, column_of, order), order


def _pivot(
    rows: list[list[Term]], work: Floats, tried: tuple[list[int], list[int]], twins: dict[int, int]
) -> tuple[tuple[int, int] | None, Floats]:
    """The best pivot, and the probes at which it is not zero."""
    block = np.abs(work[np.ix_(range(len(work)), *tried)])
    scale = np.abs(work[:, tried[0], :]).max(axis=2)[:, :, None]
    share = np.where(scale > 0, block / np.where(scale > 0, scale, 1.0), 0.0)
    while len(share):
        score = share.min(axis=0)
        if score.max(initial=0.0) > LEAST_PIVOT:
            place = _preferred(rows, score, tried, twins)
            return place, work
        share, work = share[1:], work[1:]  # singular at a special point: leave the point out
    return None, work


def _preferred(
    rows: list[list[Term]], score: Floats, tried: tuple[list[int], list[int]], twins: dict[int, int]
) -> tuple[int, int]:
    best = score.max()
    ranked = sorted(
        (
            not (isinstance(rows[r][c], Fraction) and score[i, j] > LEAST_PIVOT),
            not (twins.get(r) == c and score[i, j] >= NATURAL * best),
            -score[i, j] if twins.get(r) != c else -best,
            r,
            c,
        )
        for i, r in enumerate(tried[0])
        for j, c in enumerate(tried[1])
        if score[i, j] > LEAST_PIVOT
    )
    return ranked[0][-2], ranked[0][-1]


def _step(
    rows: list[list[Term]], right: list[Term], work: Floats, pivot: tuple[int, int], left: set[int]
) -> None:
    """Eliminate the pivot's column from the rows that are left, in terms and at the probes."""
    row, column = pivot
    for other in left:
        if _zero(rows[other][column]):
            continue
        factor = over(rows[other][column], rows[row][column])
        minus = times(MINUS, factor)
        for j, entry in enumerate(rows[row]):
            if j != column and not _zero(entry):
                rows[other][j] = plus(rows[other][j], times(minus, entry))
        rows[other][column] = ZERO
        if not _zero(right[row]):
            right[other] = plus(right[other], times(minus, right[row]))
        share = work[:, other, column] / work[:, row, column]
        work[:, other] -= share[:, None] * work[:, row]
        work[:, other, column] = 0.0


def _back(rows: list[list[Term]], right: list[Term], order: list[tuple[int, int]]) -> list[Term]:
    solution: dict[int, Term] = {}
    for row, column in reversed(order):
        total = right[row]
        for j, value in solution.items():
            if not _zero(rows[row][j]) and not _zero(value):
                total = plus(total, times(MINUS, times(rows[row][j], value)))
        solution[column] = over(total, rows[row][column])
    return [solution[j] for j in range(len(solution))]


def _zero(term: Term) -> bool:
    return isinstance(term, Fraction) and term == 0
