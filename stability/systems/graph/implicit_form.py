"""Formulas in an unknown that obeys one equation in the parameters alone.

Each number type solves the equation in its own way, with a proof: arrays and balls by Newton's
method and the mean value theorem, series power by power.

Source: tests/bodies/test_closed_forms.py compares with the linearisation of the graph.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

import casadi as ca
import numpy as np
from flint import arb, arb_series, ctx

from ...algebra.number_types import Algebra, balls, numpy_algebra
from ...algebra.program import Program
from ...algebra.running_error import TRACKED, RunningError
from ...algebra.source.python_source import Varying
from ...base.errors import NoMemberError
from ...base.types import Floats, fields_of
from ..closed_form import ClosedForm, Columns, Formulas

STEPS = 60
"""Most steps of Newton's method."""
LEAST = 2.0**-52
"""Step, relative to 1 or the unknown, at which Newton's method ends in doubles."""
WIDER = 4.0
"""Factor from the first bound on an error to the interval that proves it."""
TRIES = 4
"""Intervals that are tried, each wider than the one before."""


@dataclass(frozen=True, eq=False)
class ImplicitForm(ClosedForm):
    """Formulas whose function takes the unknown as its last family parameter."""

    equation: str = ""
    """A CasADi function, serialised: (unknown, parameters) → a number that vanishes at members, and
    its slope by the unknown."""
    start: float = 0.0
    """First guess of the unknown, from which every number type starts."""

    __getstate__ = fields_of

    @cached_property
    def used(self) -> tuple[int, ...]:
        """Parameters on which the unknown depends, by their places."""
        function = ca.Function.deserialize(self.equation)
        count = function.numel_in(1)
        pattern = function.jac_sparsity(0, 1)
        return tuple(i for i in range(count) if pattern.has_nz(0, i))

    @cached_property
    def _program(self) -> Program:
        return Program(ca.Function.deserialize(self.equation))

    def __call__(self, algebra: Algebra, a: Any, q: Any) -> Columns:
        """As for every closed form; the equation is solved first."""
        return self.entries(algebra, [*a, self.solved(algebra, q)], q)

    def begun(self, algebra: Algebra, a: Any, q: Any, moving: Varying) -> Formulas:
        """As for every closed form; the equation is solved once where its parameters stay."""
        if moving is None or any((1, place) in moving for place in self.used):
            return partial(self, algebra)
        u = self.solved(algebra, q)
        then = super().begun(algebra, [*a, u], q, moving)
        return lambda a, q: then([*a, u], q)

    def guess(self, a: Floats, q: Floats) -> None:
        """No unknowns: the equation for them is solved by the root-finder."""

    def solved(self, algebra: Algebra, q: Sequence[Any]) -> Any:
        """The unknown, in the number type of the parameters.

        Parameters
        ----------
        algebra
            The number type.
        q
            Parameters.

        Raises
        ------
        NoMemberError
            If no unique root is proved near the one in double precision.
        """
        own = [q[i] for i in self.used]
        if any(isinstance(v, arb_series) for v in own):
            return self._series(algebra, q)
        if algebra is TRACKED:
            return self._tracked(q)
        if any(isinstance(v, arb) for v in q) or isinstance(algebra.constant(0.0), arb):
            return self._ball([v[0] if isinstance(v, arb_series) else arb(v) for v in q])
        return self.near([q[i] if i in self.used else 0.0 for i in range(len(q))])

    def _both(self, algebra: Algebra, u: Any, q: Sequence[Any]) -> tuple[Any, Any]:
        value, slope = self._program.run(algebra, [[u], list(q)])
        zero = algebra.constant(0.0)
        return (value or [zero])[0], (slope or [zero])[0]

    def near(self, q: Sequence[Any]) -> Any:
        """The unknown in doubles, not a number where Newton's method does not end.

        Parameters
        ----------
        q
            Parameters, numbers or arrays.
        """
        plain = numpy_algebra()
        shape = np.broadcast_shapes(*(np.shape(q[i]) for i in self.used))
        u: Any = np.full(shape, self.start)
        with np.errstate(all="ignore"):
            for _ in range(STEPS):
                value, slope = self._both(plain, u, q)
                step = np.asarray(value / slope)
                u = u - step
                last = np.abs(step) <= LEAST * (1 + np.abs(u))
                if last.all():
                    break
        return np.where(np.abs(step) <= 4 * LEAST * (1 + np.abs(u)), u, np.nan)

    def _tracked(self, q: Sequence[Any]) -> RunningError:
        """With a bound: |f(u)| over the least slope on an interval that this bound fits into."""
        plain = [v.value if isinstance(v, RunningError) else v for v in q]
        u = self.near(plain)
        with np.errstate(all="ignore"):
            value, slope = self._both(TRACKED, RunningError(u, 0.0), q)
            off = np.abs(value.value) + 1.01 * value.error
            width = WIDER * off / np.abs(slope.value) + LEAST**2
            bound: Any = np.full(np.shape(u), np.inf)
            for _ in range(TRIES):
                _, over = self._both(TRACKED, RunningError(u, width), q)
                least = np.abs(over.value) - 1.01 * over.error
                found = 1.01 * off / np.where(least > 0, least, np.nan)
                bound = np.where(found <= width, np.minimum(bound, found), bound)
                width = WIDER * width
        return RunningError(u, bound)

    @cached_property
    def _known(self) -> dict[Any, Any]:
        return {}

    def _ball(self, q: Sequence[Any]) -> Any:
        """As a ball by an interval Newton step; one for exact numbers is kept."""
        own = [q[i] for i in self.used]
        points = [float(v.mid()) for v in own]
        exact = all(v == arb(p) for v, p in zip(own, points, strict=True))
        key = (ctx.prec, *points) if exact else None
        if key is None or key not in self._known:
            table = dict(zip(self.used, points, strict=True))
            found = self._proved(q, float(self.near([table.get(i, 0.0) for i in range(len(q))])))
            if key is None:
                return found
            self._known[key] = found
        return self._known[key]

    def _proved(self, q: Sequence[Any], rough: float) -> Any:
        if not np.isfinite(rough):
            raise NoMemberError("no root is found there.")
        middle = [v.mid() for v in q]
        u = arb(rough)
        for _ in range(ctx.prec.bit_length()):  # quadratically, from the digits of a double
            value, slope = self._both(balls(), u, middle)
            u = (u - value / slope).mid()
        value, slope = self._both(balls(), u, q)
        width = (abs(value) / abs(slope) * WIDER).upper() + arb(2) ** (8 - ctx.prec)
        for _ in range(TRIES):
            wide = arb(u, width.upper())
            _, over = self._both(balls(), wide, q)
            if not over.contains(0):
                found = u - value / over
                if found.is_finite() and wide.contains_interior(found):
                    return found
            width = WIDER * width
        raise NoMemberError("no unique root is proved there.")

    def _series(self, algebra: Algebra, q: Sequence[Any]) -> Any:
        """Power by power (implicit function theorem)."""
        plain = [v[0] if isinstance(v, arb_series) else arb(v) for v in q]
        found = [self._ball(plain)]
        slope = self._both(balls(), found[0], plain)[1]
        for k in range(1, ctx.cap):
            rest, _ = self._both(algebra, arb_series([*found, 0]), q)
            rest = rest[k] if isinstance(rest, arb_series) else arb(0)
            found.append(-rest / slope)
        return arb_series(found)
