"""Polynomial and Hurwitz determinant of one block of a matrix of Taylor forms.

Source: S. J. Berkowitz, Inf. Process. Lett. 18 (1984) 147-150, for the polynomial without
divisions; tests/boundary/test_interval_search.py.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from flint import arb, arb_mat

from .taylor import product, quotient

SKEW = 1e7
"""Condition number of eigenvectors above which Schur vectors take their place."""

Form = list[Any]


class NoValueError(ArithmeticError):
    """A quantity has no finite enclosure over a piece."""


@dataclass
class Basis:
    """Regular matrices that carry the functions of one block to narrow ones."""

    left: Any
    right: Any
    scale: Any
    turns: list[tuple[Any, Any]] = field(default_factory=list)
    """Left and right factor of the Hurwitz matrix; filled at first use."""


def nonzero(ball: Any) -> bool:
    """Whether a ball is finite and does not hold zero."""
    return bool(ball.is_finite() and not ball.contains(0))


def finite(matrix: Any) -> bool:
    """Whether every entry of a matrix of balls is finite."""
    return all(v.is_finite() for v in matrix.entries())


def basis_of(matrix: Any) -> Basis:
    """A basis in which a matrix is nearly diagonal, with its inverse divided by its size."""
    import scipy.linalg

    size = len(matrix)
    right = np.eye(size)
    scale = 1.0
    if np.isfinite(matrix).all() and np.abs(matrix).max() < 1e100:
        values, vectors = np.linalg.eig(matrix)
        real = np.where(values.imag < 0, vectors.imag, vectors.real)
        skew = np.linalg.cond(real) if np.isfinite(real).all() else np.inf
        right = real if skew < SKEW else scipy.linalg.schur(matrix, output="real")[1]
        largest = float(np.abs(values).max())
        scale = 2.0 ** round(math.log2(largest)) if largest > 1e-100 else 1.0
    exact = arb_mat(right.tolist())
    return Basis(exact.inv() / arb(scale), exact, scale)


def polynomial(matrix: Sequence[Any], *, fold: bool) -> list[Form]:
    """det(λ - B) by powers of λ, lowest first, for a matrix of forms (Berkowitz)."""
    top, size = len(matrix) - 1, matrix[0].nrows()
    one = [arb(1), *[arb(0)] * top]
    poly = [one]
    for r in range(size):
        first = [one, [-m[r, r] for m in matrix]]
        if r:
            inner = [arb_mat([[m[i, j] for j in range(r)] for i in range(r)]) for m in matrix]
            row = [arb_mat([[-m[r, j] for j in range(r)]]) for m in matrix]
            column = [arb_mat([[m[i, r]] for i in range(r)]) for m in matrix]
            for power in range(r):
                first.append([v[0, 0] for v in product(row, column, fold=fold)])
                if power < r - 1:
                    row = product(row, inner, fold=fold)
        longer = []
        for i in range(r + 2):
            total = [arb(0)] * (top + 1)
            for j in range(max(0, i - len(first) + 1), min(i, r) + 1):
                term = poly[j] if i == j else product(first[i - j], poly[j], fold=fold)
                total = [x + y for x, y in zip(total, term, strict=True)]
            longer.append(total)
        poly = longer
    return poly[::-1]


def determinant(poly: Sequence[Form], basis: Basis, *, fold: bool) -> Form:
    """A function with the zeros of the Hurwitz determinant of order n - 1."""
    degree, top = len(poly) - 1, len(poly[0]) - 1
    high = list(reversed(poly))

    def entry(i: int, j: int, k: int) -> Any:
        index = 2 * (j + 1) - (i + 1)
        return high[index][k] if 0 <= index <= degree else arb(0)

    size = degree - 1
    table = [
        arb_mat([[entry(i, j, k) for j in range(size)] for i in range(size)])
        for k in range(top + 1)
    ]
    if not basis.turns:
        basis.turns.append(_turns(table[0]))
    left, right = basis.turns[0]
    table = [left * m * right for m in table]
    rows = [[[m[i, j] for m in table] for j in range(size)] for i in range(size)]
    for step in range(size - 1):
        pivot = rows[step]
        for other in rows[step + 1 :]:
            share = quotient(other[step], pivot[step], fold=fold)
            for j in range(step + 1, size):
                less = product(share, pivot[j], fold=fold)
                other[j] = [x - y for x, y in zip(other[j], less, strict=True)]
    return rows[-1][-1]


def _turns(matrix: Any) -> tuple[Any, Any]:
    """Regular factors that make a matrix nearly the identity but for its last diagonal entry."""
    size = matrix.nrows()
    table = np.array([[float(matrix[i, j].mid()) for j in range(size)] for i in range(size)])
    if not np.isfinite(table).all():
        raise NoValueError
    left, sizes, right = np.linalg.svd(table)
    sizes[-1] = sizes[0]
    if not (sizes > 0).all():
        raise NoValueError
    rows = arb_mat((left.T / sizes[:, None]).tolist())
    columns = arb_mat(right.T.tolist())
    if rows.det().contains(0) or columns.det().contains(0):
        raise NoValueError
    return rows, columns
