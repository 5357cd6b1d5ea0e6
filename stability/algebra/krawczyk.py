"""Proof of a solution of a square system of equations (Krawczyk's test).

One system in balls, or many at once in numbers of two doubles.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from flint import arb, arb_mat, ctx

from ..base.types import Floats
from .double_double import DoubleDouble, exact
from .linear_systems import inverse_of, solve
from .running_error import UNIT

Values = list[Any]
System = Callable[[Values], tuple[Values, list[Values]]]
"""Function from balls to the values of the equations and the rows of their slopes."""
NEWTON = 60
"""Most steps of Newton's method."""
INFLATIONS = 6
"""Most boxes in one test; each next box is twice the last image."""


WIDER = 4.0
"""Factor from the first bound on an error to the box that proves it."""
LEAST = 1e-300
"""Least half-width of a box."""


class NotProvedError(ArithmeticError):
    """No solution is proved."""


def polished(system: System, start: Sequence[float]) -> Values:
    """A solution to nearly the working precision, by Newton's method; not proved.

    Raises
    ------
    NotProvedError
        If the slopes are singular, or the steps do not become small.
    """
    x = [arb(v).mid() for v in start]
    half = arb(2) ** (-ctx.prec * 3 // 4)
    for _ in range(NEWTON):
        shift = _solve(system, x)
        x = [(v - s).mid() for v, s in zip(x, shift, strict=True)]
        size = max((abs(v) for v in x), key=lambda v: float(v), default=arb(1))
        if all(abs(s) <= half * (size + arb(2) ** -40) for s in shift):
            return x
    raise NotProvedError


def _solve(system: System, x: Values) -> Values:
    values, slopes = system(x)
    if not all(v.is_finite() for row in slopes for v in row):
        raise NotProvedError
    try:
        step = arb_mat(slopes).mid().solve(arb_mat(len(x), 1, [v.mid() for v in values]))
    except ZeroDivisionError:
        raise NotProvedError from None
    return [step[i, 0].mid() for i in range(len(x))]


def proved(system: System, rough: Values, least: Sequence[Any] | None = None) -> Values:
    """Balls in which the equations have one solution, as `tested` finds them."""
    return tested(system, rough, least)[0]


def tested(
    system: System, rough: Values, least: Sequence[Any] | None = None
) -> tuple[Values, Values]:
    """Balls in which the equations have one solution, and the box of the test.

    No other solution is in the box.  Where numbers of the equations are balls themselves, this
    holds for each of their values.

    Parameters
    ----------
    system
        The equations.
    rough
        Numbers near the solution, as exact balls.
    least
        Half-widths of a box that the test has to cover, so that the solution is unique in it.

    Raises
    ------
    NotProvedError
        If the test fails.

    Source: R. Krawczyk, Computing 4 (1969) 187-201.

    Examples
    --------
    >>> root, = proved(lambda x: ([x[0] * x[0] - 2], [[2 * x[0]]]), [arb(2).sqrt().mid()])
    >>> bool(abs(root * root - 2) < 1e-12)
    True
    """
    size = len(rough)
    values, slopes = system(rough)
    if not all(v.is_finite() for row in slopes for v in row):
        raise NotProvedError
    try:
        inverse = arb_mat(slopes).mid().inv().mid()
    except ZeroDivisionError:
        raise NotProvedError from None
    x = arb_mat(size, 1, rough)
    shift = inverse * arb_mat(size, 1, values)
    small = arb(2) ** (24 - ctx.prec)
    spread = [(2 * abs(shift[i, 0]) + (1 + abs(x[i, 0])) * small).abs_upper() for i in range(size)]
    if least is not None:
        spread = [max(s, arb(v).abs_upper()) for s, v in zip(spread, least, strict=True)]

    def slope(box: Any) -> Any:
        return arb_mat(system((x + box).entries())[1])

    enclosure = contained(slope, shift, inverse, spread, INFLATIONS if least is None else 1)
    if enclosure is None:
        raise NotProvedError
    image, box = enclosure
    return (x + image).entries(), (x + box).entries()


def contained(
    slope: Callable[[Any], Any], shift: Any, inverse: Any, spread: Sequence[Any], most: int
) -> tuple[Any, Any] | None:
    """The image of a box about zero that lies inside it, and the box; None where none does.

    Parameters
    ----------
    slope
        Function from a box about zero to the slopes of the equations over it.
    shift
        An inverse of the slopes times the values at the middle.
    inverse
        This inverse, a matrix of exact numbers.
    spread
        Half-widths of the first box.
    most
        Most boxes; each next box is twice the last image.
    """
    size = inverse.nrows()
    for _ in range(most):
        box = arb_mat(size, 1, [arb(0, s) for s in spread])
        image = operator(inverse, slope(box), box, shift)
        if all(box[i, 0].contains_interior(image[i, 0]) for i in range(size)):
            return image, box
        # an unknown's image may be wide only because the other unknowns are wide
        moved = [(2 * image[i, 0]).abs_upper() for i in range(size)]
        if not all(v.is_finite() for v in moved):
            return None
        spread = [max(s, m) for s, m in zip(spread, moved, strict=True)]
    return None


def operator(inverse: Any, slope: Any, box: Any, shift: Any) -> Any:
    """Krawczyk's image of a box about zero."""
    size = inverse.nrows()
    identity = arb_mat(size, size, [int(i == j) for i in range(size) for j in range(size)])
    return (identity - inverse * slope) * box - shift


def many_proved(system: System, start: Floats) -> tuple[list[DoubleDouble], Floats]:
    """Solutions of many systems, and half-widths of boxes about them without another one.

    Parameters
    ----------
    system
        Function as for one system, of numbers of two doubles, arrays with an entry for each system.
    start
        Solutions to double precision, shape (N, unknowns).

    Returns
    -------
    solutions, widths
        Errors are infinite where none is proved; widths, shape (N, unknowns).

    Source: tests/algebra/test_double_double.py.
    """
    x = [DoubleDouble(v) for v in start.T]
    for _ in range(2):  # each step doubles the digits of a double
        values, slopes = _read(system, x)
        step = (inverse_of(slopes[0]) @ values[0])[..., 0]
        moved = [v - s for v, s in zip(x, step.T, strict=True)]
        x = [DoubleDouble(v.hi, v.lo) for v in moved]
    width = np.zeros_like(start)
    values, _ = _read(system, x)
    for _ in range(2):  # at the point, then over a box
        box = [DoubleDouble(v.hi, v.lo, w) for v, w in zip(x, width.T, strict=True)]
        shift, error = solve(*_read(system, box)[1], *values)
        image = (np.abs(shift) + error)[..., 0]
        proved = (image < width).all(axis=1, keepdims=True)
        width = np.where(proved, width, WIDER * image + LEAST)
    radius = np.where(proved, image, np.inf)
    return [DoubleDouble(v.hi, v.lo, r) for v, r in zip(x, radius.T, strict=True)], width


def _read(system: System, x: list[DoubleDouble]) -> list[tuple[Floats, Floats]]:
    """Values and slopes as doubles with bounds, shapes (N, n, 1) and (N, n, n)."""
    values, slopes = system(x)
    shape, pairs = np.shape(x[0].hi), []
    for rows in ([[v] for v in values], slopes):
        numbers = [[exact(v) for v in row] for row in rows]
        middle, error = (
            np.moveaxis(
                np.array([[np.broadcast_to(getattr(v, n), shape) for v in row] for row in numbers]),
                -1,
                0,
            )
            for n in ("hi", "error")
        )
        pairs.append((middle, 1.01 * error + 2 * UNIT * np.abs(middle)))
    return pairs
