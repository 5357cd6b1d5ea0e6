"""Zero eigenvalues that constant vectors prove, at any size.

The center of a free chain may lie anywhere and move at any constant speed: vectors without
parameters say so.  If A maps V₁ to 0, V₂ to V₁, and so on, then A is nilpotent on the last of these
spaces, so λ = 0 has at least its dimension as multiplicity.  No polynomial is multiplied out.

Source: tests/systems/test_null_chains.py.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from flint import fmpq, fmpq_mat

from ...algebra.exact.function_field import Expression
from ...algebra.exact.number_fields import NotExact

SAMPLES = 2
"""Values of the indeterminates at which vectors are sought; each vector is then proved."""


def constant_zeros(matrix: Sequence[Sequence[Any]], zero: Callable[[Any], bool]) -> int:
    """Number of zero eigenvalues that chains of constant vectors prove, from right or left.

    Parameters
    ----------
    matrix, zero
        As for `constant_kernels`.

    Examples
    --------
    >>> from stability.algebra.exact.function_field import FunctionField
    >>> [k] = FunctionField(["k"]).symbols
    >>> free = [[0, 0, 1, 0], [0, 0, 0, 1], [-k, k, 0, 0], [k, -k, 0, 0]]
    >>> constant_zeros(free, lambda v: bool(v == 0))
    2
    """
    return max(constant_kernels(matrix, zero), default=0)


def constant_kernels(matrix: Sequence[Sequence[Any]], zero: Callable[[Any], bool]) -> list[int]:
    """Dimensions of the kernels of A, A², … that chains of constant vectors prove.

    Parameters
    ----------
    matrix
        Rationals, and expressions of one function field.
    zero
        Test whether an entry is zero.

    Examples
    --------
    >>> constant_kernels([[0, 1], [0, 0]], lambda v: bool(v == 0))
    [1, 2]
    """
    try:
        found = [_sample(matrix, number) for number in range(SAMPLES)]
    except (NotExact, ZeroDivisionError):
        return []
    turned = [list(column) for column in zip(*matrix, strict=True)]
    right = _chain(matrix, found, zero)
    left = _chain(turned, [m.transpose() for m in found], zero)
    longer = max(len(right), len(left))  # a chain that has ended keeps its dimension
    right, left = ([*s, *s[-1:] * (longer - len(s))] for s in (right, left))
    return list(map(max, right, left)) if right and left else right or left


def _sample(matrix: Sequence[Sequence[Any]], number: int) -> Any:
    """The matrix with a rational in place of each indeterminate, related or not."""

    def value(entry: Any) -> Any:
        if not isinstance(entry, Expression):
            if not isinstance(entry, (int, fmpq)):
                raise NotExact("an algebraic entry")
            return fmpq(entry)
        count = entry.num.context().nvars()
        point = [
            fmpq(3 + 2 * ((i + 7 * number) % 11) + i, 5 + (i + number) % 3) for i in range(count)
        ]
        return fmpq(entry.num(*point)) / fmpq(entry.den(*point))

    return fmpq_mat([[value(entry) for entry in row] for row in matrix])


def _chain(
    matrix: Sequence[Sequence[Any]], samples: Sequence[Any], zero: Callable[[Any], bool]
) -> list[int]:
    """Dimensions of the spaces of the chain."""
    size, dimensions = len(matrix), list[int]()
    space: list[list[Any]] = []
    while True:
        if len(space) == size:
            return dimensions
        checks = _kernel(space, size)  # rows that vanish on the space
        shadow = fmpq_mat(checks)
        rows = [row for m in samples for row in (shadow * m).tolist()]
        wider = _kernel(rows, size)
        if len(wider) <= len(space) or not _mapped(matrix, wider, checks, zero):
            return dimensions
        space = wider
        dimensions.append(len(space))


def _kernel(rows: list[list[Any]], size: int) -> list[list[Any]]:
    """A basis of the vectors on which all rows vanish."""
    if not rows:
        return [[fmpq(int(i == j)) for j in range(size)] for i in range(size)]
    table, rank = fmpq_mat(rows).rref()
    pivots = [next(j for j in range(size) if table[i, j] != 0) for i in range(rank)]
    out = []
    for free in (j for j in range(size) if j not in pivots):
        vector = [fmpq(0)] * size
        vector[free] = fmpq(1)
        for i, j in enumerate(pivots):
            vector[j] = -table[i, free]
        out.append(vector)
    return out


def _mapped(
    matrix: Sequence[Sequence[Any]],
    vectors: list[list[Any]],
    checks: list[list[Any]],
    zero: Callable[[Any], bool],
) -> bool:
    """Whether the matrix maps vectors to where all checks vanish, identically."""
    for vector in vectors:
        image = [_product(row, vector) for row in matrix]
        if not all(zero(_product(image, check)) for check in checks):
            return False
    return True


def _product(entries: Sequence[Any], vector: Sequence[Any]) -> Any:
    total: Any = fmpq(0)
    for entry, c in zip(entries, vector, strict=True):
        if c != 0 and not (isinstance(entry, (int, fmpq)) and entry == 0):
            total = total + entry * c
    return total
