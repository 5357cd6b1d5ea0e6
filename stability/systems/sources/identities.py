"""Whether expressions vanish identically, by balls at fixed points without special values.

An analytic expression that vanishes to many bits at such points vanishes everywhere; a ball without
zero proves that it does not.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import casadi as ca
import numpy as np
from flint import arb, arb_mat

from ...algebra.number_types import balls, precision
from ...algebra.program import Program
from ...base.errors import StabilityError
from ...base.types import Floats

BITS = 512
"""Working precision at the points."""
SMALL = 2.0**-200
"""Largest size of a value that counts as an identical zero."""
POINTS = 3
"""Number of points."""


def _point(size: int, number: int) -> list[arb]:
    """Incommensurable numbers between 0.4 and 1.2."""
    roots = [arb(2 + 5 * number + 3 * i).sqrt() for i in range(size)]
    return [((r - r.floor()) * 4 / 5 + arb(2) / 5).mid() for r in roots]


def _at_points(
    matrix: ca.SX, symbols: ca.SX, judge: Callable[[Any], Any], zeros: int = 0
) -> list[Any]:
    """What `judge` finds in the matrix of balls at each point where the matrix is finite.

    The first `zeros` symbols are zero at every point.
    """
    found = []
    try:
        program = Program(ca.Function("identity", [symbols], [ca.densify(matrix)]))
        with precision(BITS):
            for number in range(POINTS):
                point = [arb(0)] * zeros + _point(symbols.numel(), number)[zeros:]
                values = program.dense(balls(), [point])
                rows = [[arb(v) for v in row] for row in values]
                if all(v.is_finite() for row in rows for v in row):
                    found.append(judge(rows))
    except (StabilityError, ZeroDivisionError):  # an operation that balls do not have
        return []
    return found


def _is_zero(value: Any) -> bool:
    return bool(value.contains(0)) and float(value.abs_upper()) < SMALL


def vanishing(column: ca.SX, symbols: ca.SX) -> list[bool]:
    """Whether each entry of a column vanishes identically; no proof counts as no.

    Parameters
    ----------
    column
        Expressions in the symbols, shape (k, 1).
    symbols
        Every symbol of the expressions.

    Returns
    -------
    list of bool

    Examples
    --------
    >>> x = ca.SX.sym("x")
    >>> vanishing(ca.vertcat(ca.sin(x) ** 2 + ca.cos(x) ** 2 - 1, x), x)
    [True, False]
    """
    if not column.numel():
        return []
    found = _at_points(column, symbols, lambda rows: [_is_zero(row[0]) for row in rows])
    return [bool(found) and all(f[i] for f in found) for i in range(column.numel())]


def singular(matrix: ca.SX, symbols: ca.SX) -> bool:
    """Whether the determinant of a square matrix vanishes identically; no proof counts as no.

    Parameters
    ----------
    matrix
        Expressions in the symbols, shape (n, n).
    symbols
        Every symbol of the expressions.

    Returns
    -------
    bool

    Examples
    --------
    >>> x = ca.SX.sym("x")
    >>> singular(ca.vertcat(ca.horzcat(x, 2 * x), ca.horzcat(1, 2)), x)
    True
    """
    if _plainly_regular(matrix, symbols):
        return False
    found = _at_points(matrix, symbols, lambda rows: _is_zero(arb_mat(rows).det()))
    return bool(found) and all(found)


def _plainly_regular(matrix: ca.SX, symbols: ca.SX) -> bool:
    """Whether doubles at one point already show that the matrix is regular there."""
    point = [float(v) for v in _point(symbols.numel(), 0)]
    value = np.array(ca.Function("at", [symbols], [ca.densify(matrix)])(point))
    if not (value.size and np.isfinite(value).all()):
        return False
    for axis in (0, 1):  # columns, then rows, of like size
        value = value / np.maximum(np.abs(value).max(axis=axis, keepdims=True), 1e-300)
    sizes = np.linalg.svd(value, compute_uv=False)
    return bool(sizes[-1] > 1e-8 * sizes[0])


def pivots_of(matrix: ca.SX, symbols: ca.SX, states: int) -> list[tuple[int, int]] | None:
    """Pairs (row, column) that eliminate a square matrix; constant and sparse pivots first.

    A pivot that vanishes where all states are zero, as in many symmetric motions, comes last.

    Parameters
    ----------
    matrix
        Expressions in the symbols, shape (n, n).
    symbols
        Every symbol of the expressions.
    states
        Number of the first symbols that are states.

    Returns
    -------
    list of (int, int) or None
        None where the matrix is singular at the points.

    Examples
    --------
    >>> x = ca.SX.sym("x")
    >>> pivots_of(ca.vertcat(ca.horzcat(x, 2), ca.horzcat(1, 0)), x, 1)
    [(0, 1), (1, 0)]
    """

    def plain(rows: Any) -> list[list[float]]:
        return [[float(v) for v in row] for row in rows]

    found = _at_points(matrix, symbols, plain)
    size = matrix.size1()
    if not found:
        return [(i, i) for i in range(size)]
    near = _at_points(matrix, symbols, plain, states)[:1]
    values = np.array([*near, *found])
    values /= np.maximum(np.abs(values).max(axis=(0, 2), keepdims=True), 1e-300)
    rows, columns = list(range(size)), list(range(size))
    order = []
    while rows:
        best = _best(values, rows, columns, bool(near))
        if best is None:
            return None
        row, column = best
        order.append(best)
        rows.remove(row)
        columns.remove(column)
        for other in rows:
            with np.errstate(all="ignore"):
                factor = values[:, other, column] / values[:, row, column]
                values[:, other] -= factor[:, None] * values[:, row]
    return order


def _best(
    values: Floats, rows: Sequence[int], columns: Sequence[int], near: bool
) -> tuple[int, int] | None:
    """The pivot that does not vanish at the first point, is constant, sparse, and large."""
    rest = np.abs(values[int(near) :, rows][:, :, columns]).min(axis=0) > 1e-9
    scores = {}
    for i, row in enumerate(rows):
        for j, column in enumerate(columns):
            if rest[i, j]:
                entry = values[int(near) :, row, column]
                fill = (rest[i].sum() - 1) * (rest[:, j].sum() - 1)
                sound = bool(abs(values[0, row, column]) > 1e-9)  # False for NaN
                scores[row, column] = (
                    not sound,
                    np.ptp(entry) > 1e-12,
                    fill,
                    -np.abs(entry).min(),
                )
    return min(scores, key=lambda place: scores[place]) if scores else None
