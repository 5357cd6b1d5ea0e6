"""A family whose unknowns and characteristic polynomial are known as formulas.

One unknown may obey an equation in the parameters alone.  That equation may have several roots.
The one nearest to the start is meant, for every number type.  Doubles find it by Newton's method,
and by a search where Newton's method goes to another one.  Balls prove it by the mean value
theorem, series follow power by power.

Source: tests/bodies/test_closed_forms.py compares with the linearisation of the graph.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from itertools import product
from typing import Any

import casadi as ca
import numpy as np
from flint import arb, arb_series, ctx
from numpy.typing import NDArray

from ..algebra.double_double import DOUBLE_DOUBLE, DoubleDouble, exact
from ..algebra.number_types import Algebra, balls, numpy_algebra
from ..algebra.program import Program, Varying
from ..algebra.running_error import TRACKED, RunningError, bounded
from ..base.errors import NoMemberError
from ..base.types import Floats, Record, fields_of

Columns = tuple[list[Any], list[Any], list[Any]]
"""Coefficients, unknowns, and numbers that are positive at every member."""
Formulas = Callable[[list[Any], list[Any]], Columns]
"""These of family parameters and parameters."""


@dataclass(frozen=True, eq=False)
class ClosedForm(Record):
    """Formulas in the family parameters and parameters, for numbers of any type.

    They are taken for every member of a family.  At first use they are compared with the
    linearisation of the graph at sampled members.
    """

    text: str
    """A CasADi function, serialised: (family parameters, parameters, constants) → coefficients by
    powers of λ without the zeros by structure, unknowns, and numbers that are positive at every
    member."""
    zeros: int
    """Number of zeros by structure."""
    even: bool
    """Whether the coefficients of odd powers vanish identically."""
    constants: tuple[float, ...] = ()
    """Entries of the function's last input: numbers that CasADi must not multiply in doubles."""

    __getstate__ = fields_of

    def __hash__(self) -> int:
        return hash(self.text)  # of all that equal ones have in common the longest, kept by Python

    @cached_property
    def function(self) -> ca.Function:
        """The CasADi function."""
        return ca.Function.deserialize(self.text)

    @cached_property
    def program(self) -> Program:
        """Its instructions."""
        return Program(self.function, self.constants)

    def __call__(self, algebra: Algebra, a: Any, q: Any) -> Columns:
        """Coefficients, unknowns, and numbers that are positive at every member."""
        return self.entries(algebra, a, q)

    def entries(self, algebra: Algebra, a: Any, q: Any) -> Columns:
        """The outputs of the function for its first two inputs."""
        return self._columns(algebra, self.program.run(algebra, [a, q]))

    def begun(self, algebra: Algebra, a: Any, q: Any, moving: Varying) -> Formulas:
        """The same for many members, with what is equal for all of them computed once.

        Parameters
        ----------
        algebra
            The number type.
        a, q
            Family parameters and parameters; those that move may be anything.
        moving
            (0, place) of each family parameter that later calls change, (1, place) of each
            parameter.

        Returns
        -------
        callable
            Of (a, q).
        """
        then = self.program.begun(algebra, [a, q], moving)
        return lambda a, q: self._columns(algebra, then([a, q]))

    def _columns(self, algebra: Algebra, outputs: list[list[Any]]) -> Columns:
        """Stored entries of the outputs, with their zeros."""
        zero = algebra.constant(0.0)
        out = []
        for values, places, (rows, _) in zip(
            outputs, self.program.places, self.program.shapes, strict=True
        ):
            column = [zero] * rows
            for (row, _), value in zip(places, values, strict=True):
                column[row] = value
            out.append(column)
        return out[0], out[1], out[2]

    def polynomial(self, a: list[Any], q: list[Any], formulas: Formulas | None = None) -> list[Any]:
        """The monic characteristic polynomial of a member in balls, by powers, with its zeros.

        Parameters
        ----------
        a, q
            Family parameters and parameters, as balls.
        formulas
            What `begun` gave for balls, or None.

        Raises
        ------
        NoMemberError
            If the numbers are not proved to be those of a member.
        """
        coefficients, _, positive = formulas(a, q) if formulas else self(balls(), a, q)
        if not all(v > 0 for v in positive):
            raise NoMemberError("no member is proved there.")
        return [arb(0)] * self.zeros + [c / coefficients[-1] for c in coefficients]

    def guess(self, a: Floats, q: Floats) -> tuple[Floats, NDArray[np.bool_]] | None:
        """Unknowns in doubles, and where a number that is positive at members is negative.

        Returns
        -------
        unknowns, lacking
            Shapes (N, u) and (N,); None where the formulas have no bounds.
        """
        arguments = [[(v, 0.0) for v in table.T] for table in (a, q)]
        outputs = self.program.enclosed(arguments, a.shape[:1])
        near, lacking = np.zeros((len(a), self.program.shapes[1][0])), np.zeros(len(a), dtype=bool)
        if outputs is not None:
            for (row, _), (mid, _) in zip(self.program.places[1], outputs[1], strict=True):
                near[:, row] = mid
            pairs = outputs[2]
        else:
            try:
                with np.errstate(all="ignore"):
                    values = self.with_bounds.run(numpy_algebra(), [list(a.T), list(q.T)])
            except KeyError:  # a function whose rounding is not counted
                return None
            for row, value in enumerate(values[1]):
                near[:, row] = value
            pairs = list(zip(values[2], values[5], strict=True))
        for mid, rad in pairs:
            lacking |= mid + 1.01 * rad < 0
        return near, lacking

    @cached_property
    def with_bounds(self) -> Program:
        """Values of all outputs, then bounds on the errors of all in double precision."""
        return bounded(self.function, self.constants)


class RepeatedBalls:
    """Formulas in balls of one precision, for members that differ in few numbers.

    What follows from the other numbers is computed at the second member and kept.  Every call
    compares all numbers with those that were kept.
    """

    def __init__(self, form: ClosedForm) -> None:
        self._form = form
        self._arguments: tuple[list[Any], list[Any]] | None = None
        self._moving: frozenset[tuple[int, int]] = frozenset()
        self._formulas: Formulas | None = None

    def __call__(self, a: list[Any], q: list[Any]) -> Columns:
        """Coefficients, unknowns, and numbers that are positive at every member."""
        arguments = a, q
        if self._arguments is None:
            self._arguments = arguments
            return self._form(balls(), a, q)
        moved = {
            (i, j)
            for i, numbers in enumerate(arguments)
            for j, v in enumerate(numbers)
            if (i, j) not in self._moving and not _identical(v, self._arguments[i][j])
        }
        if moved or self._formulas is None:
            self._arguments, self._moving, self._formulas = arguments, self._moving | moved, None
            self._formulas = self._form.begun(balls(), a, q, self._moving)
        return self._formulas(a, q)


def _identical(x: Any, y: Any) -> bool:
    return bool(x.mid() == y.mid() and x.rad() == y.rad())


# --- with one unknown ---


STEPS = 60
"""Most steps of Newton's method."""
LEAST = 2.0**-52
"""Step, relative to 1 or the unknown, at which Newton's method ends in doubles."""
WIDER = 4.0
"""Factor from the first bound on an error to the interval that proves it."""
TRIES = 4
"""Intervals that are tried, each wider than the one before."""
SIGNS = 32
"""Values between the start and a root, and as many on the other side, whose signs are compared."""
SAMPLES = 720
"""Steps of the search for the nearest root."""
HALVINGS = 60
"""Halvings of a step in which a root lies."""
SAME = 1e-12
"""Distance of a root in doubles from the ball of the same root, relative to 1 or to the root."""
KEPT = 1024
"""Most roots that are kept."""


_PLAIN = numpy_algebra()


@dataclass(frozen=True, eq=False)
class ImplicitForm(ClosedForm):
    """Formulas whose function takes the unknown as its last family parameter."""

    equation: str = ""
    """A CasADi function, serialised: (unknown, parameters) → a number that vanishes at members, and
    its slope by the unknown."""
    start: float = 0.0
    """Number to which the root that is meant is the nearest."""
    between: tuple[float, float] = (-np.inf, np.inf)
    """Interval in which other roots are sought; a condition of the system says what is valid."""

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

    def guess(self, a: Floats, q: Floats) -> tuple[Floats, NDArray[np.bool_]]:
        """The unknown, and where it is not found; the root-finder would take any other root."""
        near = np.broadcast_to(self.near(list(q.T)), a.shape[:1])
        return np.array(near)[:, None], ~np.isfinite(near)

    def solved(self, algebra: Algebra, q: Sequence[Any]) -> Any:
        """The unknown, in the number type of the parameters.

        Raises
        ------
        NoMemberError
            If no unique root is proved near the one in double precision.
        """
        inputs = [q[i] for i in self.used]
        if any(isinstance(v, arb_series) for v in inputs):
            return self._series(algebra, q)
        if algebra is TRACKED:
            return self._tracked(q)
        if algebra is DOUBLE_DOUBLE:
            return self._in_two_doubles(q)
        if any(isinstance(v, arb) for v in q) or isinstance(algebra.constant(0.0), arb):
            return self._ball([v[0] if isinstance(v, arb_series) else arb(v) for v in q])
        return self.near([q[i] if i in self.used else 0.0 for i in range(len(q))])

    def _both(self, algebra: Algebra, u: Any, q: Sequence[Any]) -> tuple[Any, Any]:
        value, slope = self._program.run(algebra, [[u], list(q)])
        zero = algebra.constant(0.0)
        return (value or [zero])[0], (slope or [zero])[0]

    def near(self, q: Sequence[Any]) -> Any:
        """The root nearest to the start in doubles, not a number where none is found.

        Parameters
        ----------
        q
            Parameters, numbers or arrays.
        """
        inputs = [np.asarray(q[i], dtype=float) for i in self.used]
        key = tuple(v.item() for v in inputs) if all(v.ndim == 0 for v in inputs) else None
        if key is not None and key in self._roots:
            return self._roots[key]
        parameters = [np.asarray(0.0)] * len(q)
        for i, v in zip(self.used, inputs, strict=True):
            parameters[i] = v
        shape = np.broadcast_shapes(*(v.shape for v in inputs))
        with np.errstate(all="ignore"):
            u = self._newton(np.full(shape, self.start), parameters)
            lost = ~self._nearest(u, parameters)
            if lost.any():
                rows = [np.broadcast_to(v, shape)[lost] for v in parameters]
                u[lost] = self._searched(rows, int(lost.sum()))
        if key is not None:
            if len(self._roots) >= KEPT:
                self._roots.clear()
            self._roots[key] = u
        return u

    @cached_property
    def _roots(self) -> dict[tuple[float, ...], Any]:
        return {}

    def _newton(self, u: Any, q: Sequence[Any]) -> Any:
        """Newton's method; not a number where it does not end."""
        for _ in range(STEPS):
            value, slope = self._both(_PLAIN, u, q)
            step = np.asarray(value / slope)
            u = u - step
            if (np.abs(step) <= LEAST * (1 + np.abs(u))).all():
                break
        return np.array(np.where(np.abs(step) <= 4 * LEAST * (1 + np.abs(u)), u, np.nan))

    def _nearest(self, u: Any, q: Sequence[Any]) -> Any:
        """Whether no sample nearer to the start than a root has another sign than the start."""
        low, high = self.between
        share = (np.arange(SIGNS) / SIGNS).reshape(-1, *[1] * u.ndim)
        other = -share - 1 / SIGNS  # up to the place as far away as the root
        sides = np.stack([self.start + (u - self.start) * side for side in (share, other)])
        value = np.sign(self._value(np.clip(sides, low, high), q))
        return (value == value[:1, :1]).all(axis=(0, 1)) | (u == self.start)

    def _value(self, u: Any, q: Sequence[Any]) -> Any:
        return np.broadcast_to(self._both(_PLAIN, u, q)[0], np.shape(u))

    def _searched(self, q: Sequence[Any], count: int) -> Any:
        """The root next to the nearest change of sign; not a number where there is none."""
        low, high = self.between
        if not np.isfinite(high - low):
            return np.full(count, np.nan)
        grid = low + (high - low) * (np.arange(SAMPLES) + 0.5) / SAMPLES
        value = self._value(np.tile(grid[:, None], count), q)
        change = np.sign(value[:-1]) * np.sign(value[1:]) <= 0
        far = np.abs((grid[:-1] + grid[1:]) / 2 - self.start)
        order = np.where(change, far[:, None], np.inf)
        best = order.argmin(axis=0)
        left, right = grid[best], grid[best + 1]
        begin = np.sign(np.take_along_axis(value, best[None], 0)[0])
        for _ in range(HALVINGS):
            middle = (left + right) / 2
            here = np.sign(self._value(middle, q)) == begin
            left, right = np.where(here, middle, left), np.where(here, right, middle)
        root = self._newton((left + right) / 2, q)
        close = np.abs(root - left) <= (high - low) / SAMPLES
        return np.where(close & np.isfinite(order.min(axis=0)), root, np.nan)

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
                radius = 1.01 * off / np.where(least > 0, least, np.nan)
                bound = np.where(radius <= width, np.minimum(bound, radius), bound)
                width = WIDER * width
        return RunningError(u, bound)

    def _in_two_doubles(self, q: Sequence[Any]) -> DoubleDouble:
        """After a step of Newton's method, with a bound as `_tracked`."""
        u = exact(self.near([exact(v).hi for v in q]))
        with np.errstate(all="ignore"):
            value, slope = self._both(DOUBLE_DOUBLE, u, q)
            u = u - value / exact(slope).hi
            value, slope = self._both(DOUBLE_DOUBLE, DoubleDouble(u.hi, u.lo), q)
            width = WIDER * exact(value).most / exact(slope).size
            _, over = self._both(DOUBLE_DOUBLE, DoubleDouble(u.hi, u.lo, width), q)
            bound = exact(value).most / exact(over).least
        return DoubleDouble(u.hi, u.lo, np.where(bound <= width, bound, np.inf))

    @cached_property
    def _balls(self) -> dict[Any, Any]:
        return {}

    def _ball(self, q: Sequence[Any]) -> Any:
        """As a ball by an interval Newton step; one for exact numbers is kept."""
        inputs = [q[i] for i in self.used]
        points = [float(v.mid()) for v in inputs]
        exact = all(v == arb(p) for v, p in zip(inputs, points, strict=True))
        key = (ctx.prec, *points) if exact else None
        if key is None or key not in self._balls:
            table = dict(zip(self.used, points, strict=True))
            root = self._proved(q, float(self.near([table.get(i, 0.0) for i in range(len(q))])))
            if key is None:
                self._require_one(inputs, root, q)
                return root
            self._balls[key] = root
        return self._balls[key]

    def _require_one(self, inputs: Sequence[Any], root: Any, q: Sequence[Any]) -> None:
        """Refuse an interval at whose ends another root is the nearest."""
        ends = [{float(v.mid() - v.rad()), float(v.mid() + v.rad())} for v in inputs]
        if all(len(some) == 1 for some in ends):
            return
        room = SAME * (1 + abs(float(root.mid()))) + float(root.rad())
        for corner in product(*ends):
            table = dict(zip(self.used, corner, strict=True))
            there = float(self.near([table.get(i, 0.0) for i in range(len(q))]))
            if not abs(there - float(root.mid())) <= room:
                raise NoMemberError("another root is the nearest in a part of the interval.")

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
                root = u - value / over
                if root.is_finite() and wide.contains_interior(root):
                    return root
            width = WIDER * width
        raise NoMemberError("no unique root is proved there.")

    def _series(self, algebra: Algebra, q: Sequence[Any]) -> Any:
        """Power by power (implicit function theorem)."""
        plain = [v[0] if isinstance(v, arb_series) else arb(v) for v in q]
        series = [self._ball(plain)]
        slope = self._both(balls(), series[0], plain)[1]
        for k in range(1, ctx.cap):
            rest, _ = self._both(algebra, arb_series([*series, 0]), q)
            rest = rest[k] if isinstance(rest, arb_series) else arb(0)
            series.append(-rest / slope)
        return arb_series(series)
