"""Number types in which a graph is read: NumPy arrays, balls, SymPy, CasADi itself."""

from __future__ import annotations

import operator
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import casadi as ca
import numpy as np

from .upright import Upright


@dataclass(frozen=True)
class Algebra:
    """A number type: its constants, and its functions beyond + - * /."""

    name: str
    """Name of the number type."""
    constant: Callable[[float], Any]
    """Function from a double to the same number in this type, exactly."""
    functions: dict[str, Callable[..., Any]]
    """sin, cos, tan, sqrt, exp, log, … by name."""


UNARY = ("sin", "cos", "tan", "sqrt", "exp", "log", "asin", "acos", "atan", "sinh", "cosh", "tanh")


def numpy_algebra() -> Algebra:
    """Double-precision arrays, elementwise.

    Examples
    --------
    >>> numpy_algebra().functions["sqrt"](4.0)
    np.float64(2.0)
    """
    other = {"asin": np.arcsin, "acos": np.arccos, "atan": np.arctan, "pow": np.power}
    other |= {"fabs": np.abs}
    table = {name: getattr(np, name) for name in UNARY if name not in other}
    return Algebra("numpy", float, table | other)


def ball_algebra() -> Algebra:
    """Real balls of python-flint at its context's precision: a result encloses the exact value.

    Examples
    --------
    >>> ball_algebra().functions["sqrt"](ball_algebra().constant(4.0))
    2.00000000000000
    """
    from flint import arb

    table: dict[str, Callable[..., Any]] = {name: operator.methodcaller(name) for name in UNARY}
    table["pow"] = _ball_power
    table["fabs"] = abs
    return Algebra("ball", arb, table)


MOST_PRODUCTS = 64
"""Largest whole exponent for which a power of a ball is a product."""


def _ball_power(x: Any, y: Any) -> Any:
    """A power; a small whole one by products, since python-flint's is no number around zero."""
    count = int(float(y)) if y.is_integer() and 0 <= y <= MOST_PRODUCTS else -1
    if count < 0 or not x.contains(0):
        return x**y
    out = x**0
    for _ in range(count):
        out = out * x
    return out


def sympy_algebra() -> Algebra:
    """SymPy expressions, with every constant an exact rational.

    Examples
    --------
    >>> sympy_algebra().constant(0.25)
    1/4
    """
    import sympy

    table = {name: getattr(sympy, name) for name in UNARY}
    return Algebra("sympy", sympy.Rational, table | {"pow": sympy.Pow, "fabs": sympy.Abs})


def casadi_algebra() -> Algebra:
    """CasADi's own SX, which folds constants, for a graph at the exact right angle.

    Examples
    --------
    >>> casadi_algebra().constant(0.25)
    SX(0.25)
    """

    def exact(name: str) -> Callable[[Any], Any]:
        # only this algebra meets the exact right angle
        return lambda x: getattr(x, name)() if isinstance(x, Upright) else getattr(ca, name)(x)

    table = {name: exact(name) for name in UNARY}
    return Algebra("casadi", ca.SX, table | {"pow": ca.power, "fabs": ca.fabs})


@lru_cache(maxsize=1)
def balls() -> Algebra:
    """The ball algebra, imported at first use."""
    return ball_algebra()
