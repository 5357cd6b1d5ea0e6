"""Algebraic equations 0 = g(x, y) of index 1: the linearisation of x without the variables y.

With B = -(∂g/∂y)⁻¹ ∂g/∂x a disturbance of x moves y by B x, and x by S = ∂f/∂x + ∂f/∂y B.  The
linearisation of (x, y) is [S, 0; B S, 0]: each column of an algebraic variable is zero, and the
other eigenvalues are the finite ones of the pencil ∂(f, g)/∂(x, y) - λ diag(1, 0).

Source: P. Kunkel & V. Mehrmann, Differential-Algebraic Equations (2006), ch. 2 and 4;
tests/systems/test_algebraic.py compares with the pencils.
"""

from __future__ import annotations

from collections.abc import Sequence

import casadi as ca

from ...base.errors import ParameterError

MOST_JOINED = 6
"""Most algebraic equations that are left when constant pivots are eliminated."""


def without_algebraic(slopes: ca.SX, places: Sequence[int], numbers: ca.SX) -> tuple[ca.SX, ca.SX]:
    """The linearisation of (x, y) with zero columns for y, and a determinant that must not vanish.

    Parameters
    ----------
    slopes
        Slopes of (f, g) by (x, y), shape (n, n).
    places
        Indices of y, and so of g.
    numbers
        Symbols of numbers, none of which is zero.

    Examples
    --------
    >>> x, y = ca.SX.sym("x"), ca.SX.sym("y")
    >>> without_algebraic(ca.SX(ca.blockcat([[x, 1], [2, y]])), [1], ca.SX(0, 1))[1]
    SX(y)
    """
    table = ca.SX(slopes)
    rows, columns = list(places), list(places)
    pivots: list[tuple[int, int]] = []

    def constant(i: int, j: int) -> bool:
        free = ca.symvar(table[i, j])
        return bool(free) and all(ca.depends_on(numbers, s) for s in free)

    while pivot := next(((i, j) for i in rows for j in columns if constant(i, j)), None):
        row, column = pivot
        for i in range(table.size1()):
            if i != row and not table[i, column].is_zero():
                table[i, :] = table[i, :] - table[i, column] / table[row, column] * table[row, :]
                table[i, column] = 0
        rows.remove(row)
        columns.remove(column)
        pivots.append(pivot)
    if len(rows) > MOST_JOINED:
        raise ParameterError(
            f"{len(rows)} algebraic equations are left that no constant slope solves, and at most "
            f"{MOST_JOINED} are accepted; solve some for their variables."
        )
    joined = table[rows, columns] if rows else ca.SX.eye(0)
    determinant = ca.det(joined) if rows else ca.SX(1)
    moving = [i for i in range(table.size1()) if i not in places]
    moved = ca.SX(table.size1(), len(moving))  # B below the unit matrix
    for k, i in enumerate(moving):
        moved[i, k] = 1
    if rows:
        moved[columns, :] = -(ca.adj(joined) @ table[rows, moving]) / determinant
    for row, column in reversed(pivots):
        others = [*columns, *moving]
        moved[column, :] = -(table[row, others] @ moved[others, :]) / table[row, column]
        columns.append(column)
    out = ca.SX(*table.shape)
    out[:, moving] = moved @ (slopes[moving, :] @ moved)
    return ca.sparsify(out), determinant
