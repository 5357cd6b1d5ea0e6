"""Double-precision arrays that carry a bound on their own rounding error.

Running error analysis (N. J. Higham, Accuracy and Stability of Numerical Algorithms, 2nd ed., SIAM
2002, Section 3.3): each operation adds its own rounding to what it inherits.  Bounds are kept in
absolute terms, to first order, with a factor that covers the higher orders.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .algebra import Algebra

Floats = NDArray[np.float64]

UNIT = 2.0**-53
"""Unit roundoff of a double."""


class Tracked:
    """An array and a bound on how far each entry is from the exact result.

    Parameters
    ----------
    value
        Array of doubles.
    error
        Bound on the absolute error, same shape (or broadcastable).

    Examples
    --------
    >>> third = Tracked(1.0, 0.0) / Tracked(3.0, 0.0)
    >>> bool(third.error >= 2.0**-56)
    True
    """

    __slots__ = ("error", "value")
    __array_ufunc__ = None

    def __init__(self, value: Any, error: Any) -> None:
        self.value, self.error = value, error

    def _pair(self, other: Any) -> tuple[Any, Any]:
        if isinstance(other, Tracked):
            return other.value, other.error
        return other, 0.0

    def __add__(self, other: Any) -> Tracked:
        value, error = self._pair(other)
        total = self.value + value
        return Tracked(total, self.error + error + UNIT * np.abs(total))

    __radd__ = __add__

    def __sub__(self, other: Any) -> Tracked:
        value, error = self._pair(other)
        total = self.value - value
        return Tracked(total, self.error + error + UNIT * np.abs(total))

    def __rsub__(self, other: Any) -> Tracked:
        return (-self).__add__(other)

    def __neg__(self) -> Tracked:
        return Tracked(-self.value, self.error)

    def __mul__(self, other: Any) -> Tracked:
        value, error = self._pair(other)
        total = self.value * value
        size = np.abs(total)
        return Tracked(total, np.abs(self.value) * error + np.abs(value) * self.error + UNIT * size)

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Tracked:
        value, error = self._pair(other)
        total = self.value / value
        size = np.abs(total)
        return Tracked(total, (self.error + size * error) / np.abs(value) + UNIT * size)

    def __rtruediv__(self, other: Any) -> Tracked:
        return Tracked(other, 0.0) / self

    def __pow__(self, power: Any) -> Tracked:
        exponent = power.value if isinstance(power, Tracked) else power
        total = self.value**exponent
        slope = exponent * self.value ** (exponent - 1)
        return Tracked(total, np.abs(slope) * self.error + 4 * UNIT * np.abs(total))


def _elementary(function: Any, slope: Any) -> Any:
    def apply(x: Any) -> Any:
        if not isinstance(x, Tracked):
            return Tracked(function(x), UNIT * 2 * np.abs(function(x)))
        total = function(x.value)
        return Tracked(total, np.abs(slope(x.value, total)) * x.error + 2 * UNIT * np.abs(total))

    return apply


TRACKED = Algebra(
    "tracked",
    lambda constant: constant,
    {
        "sin": _elementary(np.sin, lambda x, _: np.cos(x)),
        "cos": _elementary(np.cos, lambda x, _: np.sin(x)),
        "tan": _elementary(np.tan, lambda _, y: 1 + y * y),
        "sqrt": _elementary(np.sqrt, lambda _, y: 0.5 / y),
        "exp": _elementary(np.exp, lambda _, y: y),
        "log": _elementary(np.log, lambda x, _: 1 / x),
        "asin": _elementary(np.arcsin, lambda x, _: 1 / np.sqrt(1 - x * x)),
        "acos": _elementary(np.arccos, lambda x, _: 1 / np.sqrt(1 - x * x)),
        "atan": _elementary(np.arctan, lambda x, _: 1 / (1 + x * x)),
        "sinh": _elementary(np.sinh, lambda x, _: np.cosh(x)),
        "cosh": _elementary(np.cosh, lambda x, _: np.sinh(x)),
        "tanh": _elementary(np.tanh, lambda _, y: 1 - y * y),
        "fabs": _elementary(np.abs, lambda x, _: np.sign(x)),
        "pow": lambda x, y: x**y,
    },
)
"""The algebra in which a graph tells the rounding error of its own value."""


def tracked_arrays(
    program: Any, arguments: list[list[Tracked]], shape: tuple[int, ...]
) -> list[tuple[Floats, Floats]]:
    """Run a `Program` on tracked arrays of one shape.

    Parameters
    ----------
    program
        The instruction list.
    arguments
        For each input its entries.
    shape
        Leading shape of the results.

    Returns
    -------
    list of (value, error)
        For each output, arrays of shape `shape + (rows, columns)`; the error bound is widened by
        1 % for the orders that running error analysis leaves out.
    """
    with np.errstate(all="ignore"):
        values = program.run(TRACKED, arguments)
    results = []
    for (rows, columns), places, entries in zip(
        program.shapes, program.places, values, strict=True
    ):
        value, error = np.zeros((*shape, rows, columns)), np.zeros((*shape, rows, columns))
        for (row, column), entry in zip(places, entries, strict=True):
            if isinstance(entry, Tracked):
                value[..., row, column] = entry.value
                error[..., row, column] = 1.01 * entry.error
            else:
                value[..., row, column] = entry
        results.append((value, error))
    return results
