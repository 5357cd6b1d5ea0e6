"""Derivatives of a system up to the third, exactly from its graph, for numbers of any type.

No number of the graph is rounded: CasADi differentiates a graph whose numbers are symbols, which
become the exact doubles at the end.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import casadi as ca
import numpy as np
from flint import arb

from ...algebra.number_types import balls
from ...algebra.program import Program
from ...algebra.upright import Upright
from ...base.errors import ParameterError, StabilityError
from ...systems.equations import Equations
from ...systems.family import Family
from ...systems.graph.constants import Constants, exact_numbers
from ...systems.structure.linearity import kept

Balls = list[Any]


class Derivatives:
    """Programs of a system, with inputs x and p and then directions in the state.

    Parameters
    ----------
    system
        The equations of motion.
    """

    def __init__(self, system: Equations) -> None:
        self.system = system
        constants = Constants()
        entries = [ca.vertsplit(s) if s.numel() else [] for s in (system.x, system.p)]
        bare = Program(ca.Function("rates", [system.x, system.p], [ca.densify(system.rhs)]))
        rates = ca.vertcat(*bare.run(constants.algebra(), entries)[0])
        n = len(system.states)
        u, v, w = (ca.SX.sym(name, n) for name in "uvw")
        slopes = ca.jacobian(rates, system.x)
        once = ca.jtimes(rates, system.x, u)
        twice = ca.jtimes(once, system.x, v)
        thrice = ca.jtimes(twice, system.x, w)
        numbers = constants.column

        def program(name: str, directions: list[Any], *outputs: Any) -> Program:
            dense = [ca.densify(o) for o in outputs]
            if not exact_numbers(*dense):
                raise StabilityError(
                    f"{system.name}: a number of its derivatives is not exact in double precision; "
                    "write powers with whole or half exponents."
                )
            inputs = [system.x, system.p, *directions, numbers]
            return Program(ca.Function(name, inputs, dense), constants.values)

        self.first = program("first", [], rates, slopes, ca.jacobian(rates, system.p))
        self.second = program("second", [u, v], twice)
        self.third = program("third", [u, v, w], thrice)
        mixed = ca.jacobian(once, system.p)
        self.mixed = program("mixed", [u], mixed)
        self.kept = kept(slopes)
        """States that others depend on: the rest follow them, and are left out."""


@lru_cache(maxsize=16)
def derivatives(system: Equations) -> Derivatives:
    """The derivatives of a system, built once."""
    return Derivatives(system)


class Line:
    """A family with one number free, at a member, in terms of the system's states and parameters.

    Parameters
    ----------
    family
        A family of a user's system.
    axis
        The free quantity: a state or parameter in `at`, or another parameter.
    fixed
        Value of every other quantity, doubles or balls.
    """

    def __init__(self, family: Family, axis: str, fixed: dict[str, Any]) -> None:
        self.family, self.axis, self.fixed = family, axis, fixed
        system = family.system
        for name in family.equations:
            if name not in system.states:
                raise ParameterError(
                    f"{family.name} is solved for by {name} = 0, an observable; what happens "
                    "beyond the linearisation is found only where rates of states are solved."
                )
        self.d = derivatives(system)
        self.solved = [] if family.closed else [system.index(n) for n in family.unknown]
        self.rows = [] if family.closed else [system.index(n) for n in family.equations]
        self.by_state = axis in system.states
        self.place = (system.states if self.by_state else system.parameters).index(axis)

    def point(self, value: Any, unknowns: Sequence[Any]) -> tuple[Balls, Balls]:
        """States and parameters as balls.

        Parameters
        ----------
        value
            Value of the axis.
        unknowns
            The unknowns; not read where the family's guess solves its equations.
        """
        family, system = self.family, self.family.system
        table: dict[str, Any] = {n: arb(v) for n, v in self.fixed.items()}
        table[self.axis] = arb(value)
        for name, held in family.held.items():
            table[name] = arb.pi() / 2 if isinstance(held, Upright) else arb(held)
        found = list(family.unknown.values()) if family.closed else list(unknowns)
        table |= {n: arb(v) for n, v in zip(family.unknown, found, strict=True)}
        return [table[n] for n in system.states], [table[n] for n in system.parameters]

    def member(self, value: float) -> list[float]:
        """The unknowns of the family's member, in double precision; none where they are known."""
        if not self.solved:
            return []
        given = {n: float(arb(v).mid()) for n, v in self.fixed.items()} | {self.axis: value}
        a = np.array([[given[n] for n in self.family.at]])
        q = np.array([[given[n] for n in self.family.parameters]]).reshape(1, -1)
        return [float(v) for v in self.family.solve(a, q)[0]]

    def first(self, x: Balls, p: Balls) -> tuple[Balls, list[Balls], Balls]:
        """Rates, Jacobian, and slope of the rates by the axis alone."""
        n = len(x)
        rates, slopes, by_p = self.d.first.run(balls(), [x, p])
        rows = [[arb(slopes[j * n + i]) for j in range(n)] for i in range(n)]
        if self.by_state:
            return [arb(r) for r in rates], rows, [row[self.place] for row in rows]
        column = by_p[self.place * n : (self.place + 1) * n]
        return [arb(r) for r in rates], rows, [arb(v) for v in column]

    def turned(self, x: Balls, p: Balls, v: Balls) -> Balls:
        """Slope of A v by the axis alone."""
        n = len(x)
        if self.by_state:
            return self.second(x, p, v, self.unit(self.place))
        column = self.d.mixed.run(balls(), [x, p, v])[0]
        return list(column[self.place * n : (self.place + 1) * n])

    def second(self, x: Balls, p: Balls, u: Balls, v: Balls) -> Balls:
        """B(u, v), the second derivative."""
        return self.d.second.run(balls(), [x, p, u, v])[0]

    def third(self, x: Balls, p: Balls, u: Balls, v: Balls, w: Balls) -> Balls:
        """C(u, v, w), the third derivative."""
        return self.d.third.run(balls(), [x, p, u, v, w])[0]

    def unit(self, index: int) -> Balls:
        """Direction of one state."""
        return [arb(int(i == index)) for i in range(len(self.family.system.states))]
