"""A function of a body's own numbers, kept as text, so that bodies compare, pickle and hash."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import casadi as ca

from ....algebra.program import operations
from ....base.errors import ParameterError, shown
from ....base.types import Record, fields_of


@dataclass(frozen=True, eq=False)
class ShapeFunction(Record):
    """A scalar function as a CasADi graph, equal to any other with the same graph.

    Examples
    --------
    >>> sine = expression("height", ca.sin, ["theta"], 1)
    >>> float(sine(0.5)) == float(ca.sin(0.5)), sine == expression("height", ca.sin, ["theta"], 1)
    (True, True)
    """

    text: str
    """The graph as CasADi writes it."""
    error: float = 0.0
    """Relative error of a graph that is a fit; 0 for a formula."""

    __getstate__ = fields_of

    @cached_property
    def function(self) -> ca.Function:
        """The CasADi function."""
        return ca.Function.deserialize(self.text)

    def __call__(self, *values: Any) -> Any:
        """Value at numbers or expressions."""
        return self.function(*values)

    def __repr__(self) -> str:
        return f"<function of {', '.join(self.function.name_in()) or 'nothing'}>"


def expression(
    what: str, function: Callable[..., Any], names: Sequence[str], places: int = 0
) -> ShapeFunction:
    """The graph of a function that a user gives.

    Parameters
    ----------
    what
        Name of the argument in messages.
    function
        A function of CasADi expressions, or an `ShapeFunction`.
    names
        Names of its arguments.
    places
        Number of arguments that are passed by place; the others are passed by name.

    Raises
    ------
    ParameterError
        If the function cannot be called with these arguments, or gives no single expression.

    Examples
    --------
    >>> expression("height", lambda theta, e: 1 - e * ca.cos(theta), ["theta", "e"], 1)
    <function of theta, e>
    """
    if isinstance(function, ShapeFunction):
        if function.function.name_in() != list(names):
            raise ParameterError(
                f"{what} is a function of {', '.join(function.function.name_in()) or 'nothing'}; "
                f"give one of {', '.join(names) or 'nothing'}."
            )
        return function
    if not callable(function):
        raise ParameterError(
            f"{what} is {shown(function)}; give a function of {', '.join(names) or 'nothing'}."
        )
    symbols = [ca.SX.sym(n) for n in names]
    by_name = dict(zip(names[places:], symbols[places:], strict=True))
    try:
        value = function(*symbols[:places], **by_name)
    except Exception as error:  # a user's function may raise anything
        raise ParameterError(
            f"{what} is {shown(function)}, which has no value at CasADi expressions "
            f"({type(error).__name__}: {error}); give a function of "
            f"{', '.join(names) or 'nothing'}."
        ) from None
    result = ca.SX()
    with suppress(Exception):  # what it gives may be anything
        result = ca.SX(value)
    if result.shape != (1, 1) or ca.symvar(ca.veccat(result, *symbols))[len(symbols) :]:
        raise ParameterError(
            f"{what} gives {shown(value)}; one expression in {', '.join(names) or 'numbers'} is "
            "needed."
        )
    graph = ca.Function(what, symbols, [result], list(names), ["value"])
    if ca.OP_SIGN in operations(graph):
        raise ParameterError(
            f"{what} uses sign, which has no slope at its jump; give a function that is smooth, or "
            "has fabs alone."
        )
    return ShapeFunction(graph.serialize())
