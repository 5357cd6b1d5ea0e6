"""Precision of ball arithmetic, and bounds in doubles."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from threading import RLock
from typing import Any

import numpy as np
from flint import arb, ctx

from .number_types import MORE, UNARY, Algebra, ball_angle, ball_power


def upper(ball: Any) -> float:
    """A double that is not below any number of a ball; 0 for an exact zero.

    Parameters
    ----------
    ball
        A nonnegative real ball.
    """
    if ball == 0:
        return 0.0
    return float(np.nextafter(float(ball.abs_upper()), np.inf))


_PRECISION = RLock()


@contextmanager
def precision(bits: int) -> Iterator[None]:
    """A context with balls of the given precision; the former precision returns afterwards.

    Parameters
    ----------
    bits
        Working precision, in bits.

    Examples
    --------
    >>> from flint import arb
    >>> with precision(200):
    ...     print((arb(1) / 3).rel_accuracy_bits() > 190)
    True
    """
    with _PRECISION:  # one precision for the whole process: threads take turns
        before = ctx.prec
        ctx.prec = bits
        try:
            yield
        finally:
            ctx.prec = before


MIXED = Algebra(
    "rationals and balls",
    arb,
    {name: partial(lambda method, x: getattr(arb(x), method)(), name) for name in (*UNARY, *MORE)}
    | {"pow": ball_power, "fabs": abs, "atan2": ball_angle},
)
"""Rationals stay rational; a function makes them balls."""
