"""Points of a branch that are solved for: turning points, and what they share with crossings."""

from __future__ import annotations

from dataclasses import dataclass

from ...base.types import Floats, Record


@dataclass(frozen=True, eq=False)
class SingularPoint(Record):
    """A point of a branch where the equations of members lose rank."""

    value: float
    """Family parameter, in the unit of that parameter."""
    state: Floats
    """State there, shape (n,)."""
    error: float
    """Last step of Newton's method in the parameter; half the last bracket if not resolved."""


@dataclass(frozen=True, eq=False)
class Fold(SingularPoint):
    """A turning point of a branch: no member lies beyond it nearby.

    Source: continuation as in E. L. Allgower & K. Georg (1990); closed forms: tests/systems.

    Examples
    --------
    >>> import stability as st
    >>> import casadi as ca
    >>> x, p = ca.SX.sym("x"), ca.SX.sym("p")
    >>> s = st.System("f", x, p, p - x**2, states=("x",), parameters=("p",))
    >>> up = st.Family(s, "up", at=("p",), unknown={"x": 1.0}, equations=("x",))
    >>> abs(st.branch(up, 1, -1, [], points=11).folds[0].value) < 1e-9
    True
    """

    resolved: bool
    """Whether the extended system was solved, to rounding."""
