"""A family whose unknowns and characteristic polynomial are known as formulas."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import casadi as ca
import numpy as np
from flint import arb
from numpy.typing import NDArray

from ..algebra.number_types import Algebra, balls, numpy_algebra
from ..algebra.program import Program, Varying
from ..algebra.running_error import bounded
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
        """Coefficients, unknowns, and numbers that are positive at every member.

        Parameters
        ----------
        algebra
            The number type.
        a, q
            Family parameters and parameters.
        """
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

    def _columns(self, algebra: Algebra, found: list[list[Any]]) -> Columns:
        """Stored entries of the outputs, with their zeros."""
        zero = algebra.constant(0.0)
        out = []
        for values, places, (rows, _) in zip(
            found, self.program.places, self.program.shapes, strict=True
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

        Parameters
        ----------
        a, q
            Family parameters and parameters, shapes (N, ·).

        Returns
        -------
        unknowns, lacking
            Shapes (N, u) and (N,); None where the formulas have no bounds.
        """
        given = [[(v, 0.0) for v in table.T] for table in (a, q)]
        found = self.program.enclosed(given, a.shape[:1])
        near, lacking = np.zeros((len(a), self.program.shapes[1][0])), np.zeros(len(a), dtype=bool)
        if found is not None:
            for (row, _), (mid, _) in zip(self.program.places[1], found[1], strict=True):
                near[:, row] = mid
            pairs = found[2]
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

    Parameters
    ----------
    form
        The formulas.
    """

    def __init__(self, form: ClosedForm) -> None:
        self._form = form
        self._given: tuple[list[Any], list[Any]] | None = None
        self._moving: frozenset[tuple[int, int]] = frozenset()
        self._formulas: Formulas | None = None

    def __call__(self, a: list[Any], q: list[Any]) -> Columns:
        """Coefficients, unknowns, and numbers that are positive at every member.

        Parameters
        ----------
        a, q
            Family parameters and parameters, as balls.
        """
        given = a, q
        if self._given is None:
            self._given = given
            return self._form(balls(), a, q)
        moved = {
            (i, j)
            for i, numbers in enumerate(given)
            for j, v in enumerate(numbers)
            if (i, j) not in self._moving and not _identical(v, self._given[i][j])
        }
        if moved or self._formulas is None:
            self._given, self._moving, self._formulas = given, self._moving | moved, None
            self._formulas = self._form.begun(balls(), a, q, self._moving)
        return self._formulas(a, q)


def _identical(x: Any, y: Any) -> bool:
    return bool(x.mid() == y.mid() and x.rad() == y.rad())
