"""Conditions: expressions that must be positive for a state to have a meaning."""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca

from ..base.checks import instance, real_numbers
from ..base.errors import ParameterError, shown
from ..base.types import Record
from .serialisation import Portable
from .system_checks import expression


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
