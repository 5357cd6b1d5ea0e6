"""Double-precision arrays that carry a bound on their own rounding error.

Running error analysis (N. J. Higham, Accuracy and Stability of Numerical Algorithms, 2nd ed., SIAM
2002, Section 3.3): each operation adds its own rounding to the inherited error.  Bounds are
absolute and hold to every order, like those of an interval: an error may exceed its value.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import casadi as ca
import numpy as np
from flint import arb

from ..base.types import Floats
from .number_types import Algebra, balls, upper
from .program import Program

UNIT = 2.0**-53
"""Unit roundoff of a double."""
TINY = 2.0**-1074
"""Least double: largest loss of a product or quotient that underflows."""


def _value_and_bound(number: Any) -> tuple[Any, Any]:
    """Value and bound; a plain number is exact."""
    return (number.value, number.error) if isinstance(number, RunningError) else (number, 0.0)


def tracked(number: Any) -> RunningError:
    """A number with its bound; a plain one, and a constant of a graph, is exact."""
    return number if isinstance(number, RunningError) else RunningError(np.float64(number), 0.0)


class RunningError:
    """An array and a bound on how far each entry is from the exact result.

    Parameters
    ----------
    value
        Array of doubles.
    error
        Bound on the absolute error, same shape (or broadcastable).

    Examples
    --------
    >>> third = RunningError(1.0, 0.0) / RunningError(3.0, 0.0)
    >>> bool(third.error >= 2.0**-56)
    True
    """

    __slots__ = ("error", "value")
    __array_ufunc__ = None

    def __init__(self, value: Any, error: Any) -> None:
        self.value, self.error = value, error

    def __add__(self, other: Any) -> RunningError:
        value, error = _value_and_bound(other)
        total = self.value + value
        return RunningError(total, self.error + error + UNIT * abs(total))

    __radd__ = __add__

    def __sub__(self, other: Any) -> RunningError:
        value, error = _value_and_bound(other)
        total = self.value - value
        return RunningError(total, self.error + error + UNIT * abs(total))

    def __rsub__(self, other: Any) -> RunningError:
        return (-self).__add__(other)

    def __neg__(self) -> RunningError:
        return RunningError(-self.value, self.error)

    def __mul__(self, other: Any) -> RunningError:
        if not isinstance(other, RunningError):
            total = self.value * other
            return RunningError(total, abs(other) * self.error + (UNIT * abs(total) + TINY))
        value, error = other.value, other.error
        total = self.value * value
        passed = abs(self.value) * error + (abs(value) + error) * self.error
        return RunningError(total, passed + UNIT * abs(total) + TINY)

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> RunningError:
        if not isinstance(other, RunningError):
            total = self.value / other
            return RunningError(total, self.error / abs(other) + (UNIT * abs(total) + TINY))
        value, error = other.value, other.error
        total = self.value / value
        size = abs(total)
        least = abs(value) - error
        passed = (self.error + size * error) / ((least + abs(least)) / 2)
        return RunningError(total, passed + UNIT * size + TINY)

    def __rtruediv__(self, other: Any) -> RunningError:
        return RunningError(other, 0.0) / self

    def __pow__(self, power: Any) -> RunningError:
        exponent, unsure = _value_and_bound(tracked(power))
        total = self.value**exponent
        size = np.abs(self.value)
        low, high = size - self.error, size + self.error
        # |x|^y is monotone in |x|; across zero only whole powers y ≥ 0 have a bound
        ends = [np.abs(np.maximum(end, 0.0) ** exponent - np.abs(total)) for end in (low, high)]
        passed = np.maximum(*ends)
        passed = np.where(low < 0, np.where(exponent >= 0, 2 * high**exponent, np.inf), passed)
        if np.any(unsure):
            reach = np.maximum(np.abs(np.log(np.maximum(low, 0.0))), np.abs(np.log(high)))
            passed = passed + (np.abs(total) + passed) * np.expm1(unsure * reach)
        return RunningError(total, passed + 4 * UNIT * np.abs(total) + TINY)


class Constant(float):
    """An exact number of a graph; its sum or product with another is rounded."""

    def _with(self, other: Any, operation: Any) -> Any:
        if isinstance(other, Constant):
            return operation(tracked(self), other)
        return NotImplemented

    def __add__(self, other: Any) -> Any:
        return self._with(other, RunningError.__add__)

    def __sub__(self, other: Any) -> Any:
        return self._with(other, RunningError.__sub__)

    def __mul__(self, other: Any) -> Any:
        return self._with(other, RunningError.__mul__)

    def __truediv__(self, other: Any) -> Any:
        return self._with(other, RunningError.__truediv__)

    def __rtruediv__(self, other: Any) -> Any:  # the graph's own 1 / x
        return tracked(other) / self

    def __neg__(self) -> Constant:
        return Constant(-float(self))


def _elementary(function: Any, change: Any) -> Any:
    """A function with its largest change within an error: change(x, error, |value|)."""

    def elementary(x: Any) -> Any:
        x = tracked(x)
        total = function(x.value)
        size = np.abs(total)
        rounding = 2 * UNIT * size + TINY * (size > 0)  # only exp rounds a nonzero value to zero
        return RunningError(total, change(x.value, x.error, size) + rounding)

    return elementary


def _low(x: Any, e: Any) -> Any:
    """The least modulus within an error."""
    return np.maximum(np.abs(x) - e, 0.0)


def _room(value: Any) -> Any:
    return np.where(value > 0, value, 0.0)


def _arcsine_change(x: Any, e: Any, _: Any) -> Any:
    return e / np.sqrt(_room(1 - (np.abs(x) + e) ** 2))


def _angle(y: Any, x: Any) -> RunningError:
    """The angle of (x, y): it changes by less than π/2 of the way over the distance from 0."""
    y, x = tracked(y), tracked(x)
    total = np.arctan2(y.value, x.value)
    way = np.hypot(y.error, x.error)
    passed = np.pi / 2 * way / np.hypot(y.value, x.value)
    jumps = (x.value - x.error <= 0) & (np.abs(y.value) <= y.error)
    jumps |= way >= np.hypot(y.value, x.value)
    return RunningError(total, np.where(jumps, np.inf, passed) + 2 * UNIT * np.abs(total) + TINY)


def _tan(x: Any) -> Any:
    functions = TRACKED.functions
    return functions["sin"](x) / functions["cos"](x)


TRACKED = Algebra(
    "tracked",
    lambda constant: Constant(constant),
    {
        "sin": _elementary(np.sin, lambda x, e, _: np.minimum(np.abs(np.cos(x)) + e, 1.0) * e),
        "cos": _elementary(np.cos, lambda x, e, _: np.minimum(np.abs(np.sin(x)) + e, 1.0) * e),
        "tan": _tan,
        "sqrt": _elementary(np.sqrt, lambda x, e, y: e / (y + np.sqrt(np.maximum(x - e, 0.0)))),
        "exp": _elementary(np.exp, lambda _, e, y: TINY + np.maximum(y, TINY) * np.expm1(e)),
        "log": _elementary(np.log, lambda x, e, _: -np.log1p(-np.minimum(e / x, 1.0))),
        "asin": _elementary(np.arcsin, _arcsine_change),
        "acos": _elementary(np.arccos, _arcsine_change),
        "atan": _elementary(np.arctan, lambda x, e, _: e / (1 + _low(x, e) ** 2)),
        "sinh": _elementary(np.sinh, lambda x, e, _: np.cosh(np.abs(x) + e) * e),
        "cosh": _elementary(np.cosh, lambda x, e, _: np.sinh(np.abs(x) + e) * e),
        "tanh": _elementary(np.tanh, lambda x, e, _: (1 - np.tanh(_low(x, e)) ** 2) * e),
        "expm1": _elementary(np.expm1, lambda x, e, _: TINY + np.exp(x) * np.expm1(e)),
        "log1p": _elementary(np.log1p, lambda x, e, _: -np.log1p(-np.minimum(e / (1 + x), 1.0))),
        "asinh": _elementary(np.arcsinh, lambda x, e, _: e / np.sqrt(1 + _low(x, e) ** 2)),
        "acosh": _elementary(
            np.arccosh, lambda x, e, _: e / np.sqrt(np.maximum(x - e, 1) ** 2 - 1)
        ),
        "atanh": _elementary(np.arctanh, lambda x, e, _: e / _room(1 - (np.abs(x) + e) ** 2)),
        "atan2": _angle,
        "fabs": _elementary(np.abs, lambda _, e, __: e),
        "pow": lambda x, y: tracked(x) ** y,
    },
)
"""The algebra in which each value of a graph carries a bound on its rounding error."""


def running_error_arrays(
    program: Any, arguments: list[list[RunningError]], shape: tuple[int, ...]
) -> list[tuple[Floats, Floats]]:
    """Run a `Program` on tracked arrays of one shape.

    Parameters
    ----------
    program
        The instruction list.
    arguments
        Entries of each input.
    shape
        Leading shape of the results.

    Returns
    -------
    list of (value, error)
        For each output, arrays of shape `shape + (rows, columns)`; the error bound is widened by
        1 % for its own roundings.
    """
    if program.constant is not None:
        return [_repeated(program.constant, shape)]
    pairs = [[_value_and_bound(v) for v in some] for some in arguments]
    kernel = program.enclosed(pairs, shape)
    with np.errstate(all="ignore"):
        values = program.run(TRACKED, arguments) if kernel is None else kernel
    results = _tables(
        program, values, shape, lambda v: v if isinstance(v, tuple) else _value_and_bound(v)
    )
    for _, error in results:
        error *= 1.01
        error[np.isnan(error)] = np.inf  # 0/0, or the root of a number that may be negative
    return results


def _tables(
    program: Any,
    values: Sequence[Sequence[Any]],
    shape: tuple[int, ...],
    pair: Callable[[Any], tuple[Any, Any]],
) -> list[tuple[Floats, Floats]]:
    """Value and error of each output; zero without an error where the graph holds no entry."""
    results = []
    for (rows, columns), places, entries in zip(
        program.shapes, program.places, values, strict=True
    ):
        value, error = np.zeros((2, *shape, rows, columns))
        for (row, column), entry in zip(places, entries, strict=True):
            value[..., row, column], error[..., row, column] = pair(entry)
        results.append((value, error))
    return results


def _rounded(entry: Any) -> tuple[float, float]:
    """A ball as a double and a bound on its distance."""
    ball = arb(entry)
    middle = float(ball.mid())
    return middle, upper(ball - middle)


def _repeated(constant: tuple[Floats, Floats], shape: tuple[int, ...]) -> tuple[Floats, Floats]:
    value, error = (np.broadcast_to(v, (*shape, *v.shape)).copy() for v in constant)
    return value, error


def ball_arrays(
    program: Program, arguments: Sequence[Sequence[Any]]
) -> list[tuple[Floats, Floats]]:
    """Run a `Program` on balls at the current precision, for one point.

    Parameters
    ----------
    program
        The instruction list.
    arguments
        Entries of each input, balls.

    Returns
    -------
    list of (value, error)
        For each output, arrays of shape (1, rows, columns); an entry that the graph does not hold
        is zero without an error.
    """
    if program.constant is not None:
        return [_repeated(program.constant, (1,))]
    return _tables(program, program.run(balls(), arguments), (1,), _rounded)


# --- errors counted once, before any number is known ---


class Sized:
    """An expression, the size of its terms, and the number of roundings on the way to it.

    In double precision its error is at most roundings times size times the unit roundoff, as long
    as their product with the unit is far below one: a quotient or root for which this fails has an
    infinite size.
    """

    __slots__ = ("count", "size", "value")

    def __init__(self, value: Any, size: Any, count: int) -> None:
        self.value, self.size, self.count = value, size, count

    def _of(self, other: Any) -> Sized:
        return other if isinstance(other, Sized) else Sized(other, ca.fabs(ca.SX(other)), 0)

    def __add__(self, other: Any) -> Sized:
        o = self._of(other)
        return Sized(self.value + o.value, self.size + o.size, max(self.count, o.count) + 1)

    __radd__ = __add__

    def __sub__(self, other: Any) -> Sized:
        o = self._of(other)
        return Sized(self.value - o.value, self.size + o.size, max(self.count, o.count) + 1)

    def __rsub__(self, other: Any) -> Sized:
        return (-self).__add__(other)

    def __neg__(self) -> Sized:
        return Sized(-self.value, self.size, self.count)

    def __mul__(self, other: Any) -> Sized:
        o = self._of(other)
        return Sized(self.value * o.value, self.size * o.size, self.count + o.count + 1)

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Sized:
        o = self._of(other)
        value, size = self.value / o.value, ca.fabs(o.value)
        if o.count:
            size = _room_of(size - 1.01 * o.count * UNIT * o.size)
        passed = self.size + ca.fabs(value) * o.size
        return Sized(value, passed / size, max(self.count, o.count) + 1)

    def __rtruediv__(self, other: Any) -> Sized:
        return self._of(other) / self

    def __pow__(self, power: Any) -> Sized:
        whole = -1 if isinstance(power, Sized) else int(power)  # -1: not known before the numbers
        if whole != power or not 0 <= whole <= MOST_POWER:
            raise KeyError("pow")
        out = self._of(1.0)
        for _ in range(whole):
            out = out * self
        return out


MOST_POWER = 16
"""Largest power that is written as products."""
LEAST_SIZE = 1e-250
"""Added to every bound: far above what underflow may lose."""


def _room_of(x: Any) -> Any:
    """X where it is positive, otherwise zero."""
    return (x + ca.fabs(x)) / 2


def _wave(function: Any) -> Any:
    """Sine or cosine: with four roundings of its own; an inexact argument adds its whole error."""

    def wave(x: Any) -> Sized:
        x = x if isinstance(x, Sized) else Sized(x, ca.fabs(x), 0)
        value = function(x.value)
        size = ca.fabs(value)
        return Sized(value, size + x.size if x.count else size, x.count + 4)

    return wave


def _root(x: Any) -> Sized:
    x = x if isinstance(x, Sized) else Sized(x, x, 0)
    value = ca.sqrt(x.value)
    least = _room_of(x.value - 1.01 * x.count * UNIT * x.size) if x.count else x.value
    return Sized(value, x.size / ca.sqrt(least), x.count + 1)


def _power(x: Any, y: Any) -> Sized:
    return Sized.__pow__(x if isinstance(x, Sized) else Sized(x, ca.fabs(x), 0), y)


SIZED = Algebra(
    "sized", ca.SX, {"sin": _wave(ca.sin), "cos": _wave(ca.cos), "sqrt": _root, "pow": _power}
)
"""Expressions with the sizes of their terms; other functions have no entry."""


def bounded(function: ca.Function, constants: Sequence[float] | None = None) -> Program:
    """A program with the values of a function's outputs, then bounds on their errors.

    Parameters
    ----------
    function
        Function of exact doubles, made of + - * /, whole powers, sin, cos and sqrt.
    constants
        Entries of its last input, as for `Program`.

    Returns
    -------
    Program
        Twice as many outputs; a bound that is infinite or no number says nothing.

    Raises
    ------
    KeyError
        If the function has others in it.

    Examples
    --------
    >>> from stability.algebra.number_types import numpy_algebra
    >>> x = ca.SX.sym("x")
    >>> program = bounded(ca.Function("f", [x], [x * x - 2]))
    >>> (value,), (error,) = program.run(numpy_algebra(), [[1.5]])
    >>> float(value), 0 < float(error) < 1e-14
    (0.25, True)
    """
    inputs = [ca.SX.sym(f"a{i}", function.numel_in(i)) for i in range(function.n_in())]
    program = Program(function)
    entries = [[Sized(v, ca.fabs(v), 0) for v in ca.vertsplit(some)] for some in inputs]
    values, errors = [], []
    for outputs, places, shape in zip(
        program.run(SIZED, entries), program.places, program.shapes, strict=True
    ):
        value, error = ca.SX.zeros(*shape), ca.SX.zeros(*shape)
        for place, entry in zip(places, outputs, strict=True):
            if isinstance(entry, Sized):
                value[place] = entry.value
                error[place] = 1.01 * entry.count * UNIT * entry.size + LEAST_SIZE
            else:
                value[place] = entry
        values.append(ca.densify(value))
        errors.append(ca.densify(error))
    return Program(ca.Function("bounded", inputs, [*values, *errors]), constants)
