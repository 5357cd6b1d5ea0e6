"""A family whose unknowns and characteristic polynomial are known as formulas."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import casadi as ca
from flint import arb

from ..algebra.number_types import Algebra, balls
from ..algebra.program import Program
from ..algebra.running_error import bounded
from ..base.errors import NoMemberError
from ..base.types import Record, fields_of


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

    @cached_property
    def function(self) -> ca.Function:
        """The CasADi function."""
        return ca.Function.deserialize(self.text)

    @cached_property
    def program(self) -> Program:
        """Its instructions."""
        return Program(self.function, self.constants)

    def __call__(self, algebra: Algebra, a: Any, q: Any) -> tuple[list[Any], list[Any], list[Any]]:
        """Coefficients, unknowns, and numbers that are positive at every member.

        Parameters
        ----------
        algebra
            The number type.
        a, q
            Family parameters and parameters.
        """
        return self.entries(algebra, a, q)

    def entries(self, algebra: Algebra, a: Any, q: Any) -> tuple[list[Any], list[Any], list[Any]]:
        """The outputs of the function for its first two inputs."""
        zero = algebra.constant(0.0)
        found = self.program.run(algebra, [a, q])
        out = []
        for values, places, (rows, _) in zip(
            found, self.program.places, self.program.shapes, strict=True
        ):
            column = [zero] * rows
            for (row, _), value in zip(places, values, strict=True):
                column[row] = value
            out.append(column)
        return out[0], out[1], out[2]

    def polynomial(self, a: list[Any], q: list[Any]) -> list[Any]:
        """The monic characteristic polynomial of a member in balls, by powers, with its zeros.

        Parameters
        ----------
        a, q
            Family parameters and parameters, as balls.

        Raises
        ------
        NoMemberError
            If the numbers are not proved to be those of a member.
        """
        coefficients, _, positive = self(balls(), a, q)
        if not all(v > 0 for v in positive):
            raise NoMemberError("no member is proved there.")
        return [arb(0)] * self.zeros + [c / coefficients[-1] for c in coefficients]

    @cached_property
    def with_bounds(self) -> Program:
        """Values of all outputs, then bounds on the errors of all in double precision."""
        return bounded(self.function, self.constants)
