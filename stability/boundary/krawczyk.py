"""Proof of a solution of a square system of equations in balls (Krawczyk's test)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from flint import arb, arb_mat, ctx

Values = list[Any]
System = Callable[[Values], tuple[Values, list[Values]]]
"""Function from balls to the values of the equations and the rows of their slopes."""
NEWTON = 60
"""Most steps of Newton's method."""
INFLATIONS = 6
"""Most boxes in one test; each next box is twice the last image."""


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
    one = arb_mat(size, size, [int(i == j) for i in range(size) for j in range(size)])
    small = arb(2) ** (24 - ctx.prec)
    spread = [(2 * abs(shift[i, 0]) + (1 + abs(x[i, 0])) * small).abs_upper() for i in range(size)]
    if least is not None:
        spread = [max(s, arb(v).abs_upper()) for s, v in zip(spread, least, strict=True)]
    for _ in range(INFLATIONS):
        box = [x[i, 0] + arb(0, spread[i]) for i in range(size)]
        slope = arb_mat(system(box)[1])
        step = (one - inverse * slope) * (arb_mat(size, 1, box) - x)
        image = [x[i, 0] - shift[i, 0] + step[i, 0] for i in range(size)]
        if all(b.contains_interior(v) for b, v in zip(box, image, strict=True)):
            return image, box
        if least is not None:
            raise NotProvedError
        moved = [(2 * (v - x[i, 0])).abs_upper() for i, v in enumerate(image)]
        if not all(v.is_finite() for v in moved):
            raise NotProvedError
        spread = [max(s, m) for s, m in zip(spread, moved, strict=True)]
    raise NotProvedError
