"""Conditions: expressions that must be positive for a state to have a meaning."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from ..base.checks import instance, real_numbers
from ..base.errors import DomainError, ParameterError, listing, shown
from ..base.types import Record
from .serialisation import Portable
from .system_checks import expression


def not_finite(name: str, values: Mapping[str, Any], found: NDArray[np.float64]) -> DomainError:
    """The error of a graph with a value that is not finite; it names the first such place.

    Parameters
    ----------
    name
        Name of the system.
    values
        What the graph is computed from by name, arrays that broadcast to the leading shape.
    found
        Its values, matrices of shape (…, rows, columns).
    """
    fine = np.isfinite(found).all(axis=(-1, -2))
    first = int(np.argmin(fine))
    at = [np.broadcast_to(v, fine.shape).flat[first] for v in values.values()]
    return DomainError(
        f"{name} at {listing(values, at)}: values are not finite there, or overflow double "
        "precision; give other states or parameters, nearer to 1."
    )


@dataclass(frozen=True, eq=False)
class Condition(Portable, Record):
    """A quantity that must be positive for the equations to have a meaning, and the reason.

    Source: this package; the end of a run at a condition: tests/motion/test_system_motion.py.

    Examples
    --------
    >>> import stability as st
    >>> import casadi as ca
    >>> g = ca.SX.sym("g")
    >>> st.Condition(g, "g is {value:g}, which must be positive").sentence
    'g is {value:g}, which must be positive'
    """

    value: ca.SX
    """Expression in the states and parameters; a state without a positive value is refused."""
    sentence: str
    """The reason as a sentence for the user, with `{value}` in place of the number."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "value", expression("value of a condition", self.value, 1, 1))
        sentence = instance("sentence of a condition", self.sentence, str, "give a string")
        try:
            sentence.format(value=1.0)
        except (LookupError, ValueError, AttributeError, TypeError):
            raise ParameterError(
                f"sentence of a condition is {shown(sentence)}; the only thing in braces is "
                "{value}, with a format for numbers."
            ) from None

    def _content(self) -> tuple[object, ...]:
        graph = ca.Function("condition", ca.symvar(self.value), [self.value])
        return (type(self), self.sentence, graph.serialize())

    def refusal(self, value: float) -> str:
        """The reason with its value, one sentence."""
        number = real_numbers("value", value)
        if number.size != 1:
            raise ParameterError(f"value has shape {number.shape}; give one number.")
        return self.sentence.format(value=float(number.item())) + "."
