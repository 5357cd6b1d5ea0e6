"""Rates and their slopes in one pass over a graph, with zeros folded on the way.

CasADi's Jacobian of a large graph is larger by the number of states, before a family folds most of
it to zero.  Here each number carries its slopes along the states, and a slope that folds to zero at
the family is never built.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from ...algebra.number_types import MORE, UNARY, Algebra
from ...algebra.program import Program
from ...base.errors import StabilityError

Slopes = dict[int, Any]


class Sloped:
    """A number with its nonzero slopes along the states, by index.

    Parameters
    ----------
    value
        The number.
    slopes
        Slope by index of the state.
    """

    __slots__ = ("slopes", "value")

    def __init__(self, value: Any, slopes: Slopes) -> None:
        self.value, self.slopes = value, slopes

    def __add__(self, other: Any) -> Sloped:
        value, slopes = _split(other)
        return Sloped(self.value + value, _joined(self.slopes, slopes))

    __radd__ = __add__

    def __neg__(self) -> Sloped:
        return Sloped(-self.value, {j: -s for j, s in self.slopes.items()})

    def __sub__(self, other: Any) -> Sloped:
        value, slopes = _split(other)
        return Sloped(self.value - value, _joined(self.slopes, {j: -s for j, s in slopes.items()}))

    def __rsub__(self, other: Any) -> Sloped:
        return Sloped(other, {}) - self

    def __mul__(self, other: Any) -> Sloped:
        value, slopes = _split(other)
        product = _joined(_scaled(self.slopes, value), _scaled(slopes, self.value))
        return Sloped(self.value * value, product)

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Sloped:
        value, slopes = _split(other)
        quotient = self.value / value
        above = _joined(self.slopes, _scaled(slopes, -quotient) if slopes else {})
        return Sloped(quotient, {j: s / value for j, s in above.items()})

    def __rtruediv__(self, other: Any) -> Sloped:
        return Sloped(other, {}) / self


def _split(number: Any) -> tuple[Any, Slopes]:
    return (number.value, number.slopes) if isinstance(number, Sloped) else (number, {})


def _zero(value: Any) -> bool:
    return bool(value.is_zero()) if hasattr(value, "is_zero") else value == 0


def _scaled(slopes: Slopes, factor: Any) -> Slopes:
    if not slopes or _zero(factor):
        return {}
    products = ((j, s * factor) for j, s in slopes.items())
    return {j: s for j, s in products if not _zero(s)}


def _joined(first: Slopes, second: Slopes) -> Slopes:
    if not second:
        return first
    out = dict(first)
    for j, s in second.items():
        total = out[j] + s if j in out else s
        if _zero(total):
            out.pop(j, None)
        else:
            out[j] = total
    return out


BY_VALUE: dict[str, Callable[[Any], Any]] = {
    "tan": lambda y: 1 + y * y,
    "sqrt": lambda y: 1 / (2 * y),
    "exp": lambda y: y,
    "tanh": lambda y: 1 - y * y,
}
"""Derivatives that the value y of the function gives."""


def _by_argument(f: Mapping[str, Callable[..., Any]]) -> dict[str, Callable[[Any], Any]]:
    """Derivatives of the other functions, from the argument x."""
    return {
        "sin": f["cos"],
        "cos": lambda x: -f["sin"](x),
        "log": lambda x: 1 / x,
        "asin": lambda x: 1 / f["sqrt"](1 - x * x),
        "acos": lambda x: -1 / f["sqrt"](1 - x * x),
        "atan": lambda x: 1 / (1 + x * x),
        "sinh": f["cosh"],
        "cosh": f["sinh"],
        "expm1": f["exp"],
        "log1p": lambda x: 1 / (x + 1),
        "asinh": lambda x: 1 / f["sqrt"](x * x + 1),
        "acosh": lambda x: 1 / f["sqrt"](x * x - 1),
        "atanh": lambda x: 1 / (-(x * x) + 1),
    }


def sloped_algebra(plain: Algebra) -> Algebra:
    """Numbers of an algebra with slopes.

    Parameters
    ----------
    plain
        The algebra of values and slopes.
    """
    f = plain.functions

    by_argument = _by_argument(f)

    def lifted(name: str) -> Callable[[Any], Any]:
        def apply(number: Any) -> Any:
            x, slopes = _split(number)
            y = f[name](x)
            if not slopes:
                return y
            slope = BY_VALUE[name](y) if name in BY_VALUE else by_argument[name](x)
            return Sloped(y, _scaled(slopes, slope))

        return apply

    def power(base: Any, exponent: Any) -> Any:
        (x, by_x), (n, by_n) = _split(base), _split(exponent)
        y = f["pow"](x, n)
        slopes = _scaled(by_x, n * f["pow"](x, n - 1)) if by_x else {}
        if by_n:
            slopes = _joined(slopes, _scaled(by_n, y * f["log"](x)))
        return Sloped(y, slopes)

    def fabs(number: Any) -> Any:
        x, slopes = _split(number)
        if slopes:
            raise StabilityError(
                "the graph takes the absolute value of a state, which has no slope at zero; only "
                "smooth elementary functions are read."
            )
        return f["fabs"](x)

    table: dict[str, Callable[..., Any]] = {n: lifted(n) for n in (*UNARY, *MORE) if n in f}
    return Algebra(f"sloped {plain.name}", plain.constant, table | {"pow": power, "fabs": fabs})


def rates_and_slopes(
    program: Program, algebra: Algebra, states: Sequence[Any], parameters: Sequence[Any]
) -> tuple[list[Any], list[Slopes]]:
    """Rates and their slopes along the states, at states and parameters of any number type.

    Parameters
    ----------
    program
        The rates, a dense column in (states, parameters).
    algebra
        The number type.
    states, parameters
        Values.

    Returns
    -------
    values, slopes
        For each rate its value, and its nonzero slopes by index of the state.

    Examples
    --------
    >>> import casadi as ca
    >>> from stability.algebra.number_types import casadi_algebra
    >>> x, p = ca.SX.sym("x", 2), ca.SX.sym("p")
    >>> rates = Program(ca.Function("f", [x, p], [ca.vertcat(x[1], -p * ca.sin(x[0]))]))
    >>> rates_and_slopes(rates, casadi_algebra(), [ca.SX(0), ca.SX(0)], [p])
    ([SX(0), SX(0)], [{1: 1}, {0: SX((-p))}])
    """
    sloped = [Sloped(value, {j: 1}) for j, value in enumerate(states)]
    found = program.run(sloped_algebra(algebra), [sloped, parameters])[0]
    values, slopes = zip(*map(_split, found), strict=True) if found else ((), ())
    return list(values), list(slopes)
