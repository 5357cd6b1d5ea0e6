"""A large implicit system M(x) z = F(x) read at a family: z is solved for in the number type.

A graph that has eliminated a dense mass matrix of n rows holds n³/3 products, and its slopes n
times as many.  Balls lose a digit with each pivot of it.  Here M, F and the slopes of F - M z stay
small graphs.  Then z = M⁻¹ F, and the slopes of z are M⁻¹ ∂(F - M z) with z held.

Source: tests/systems/test_implicit.py.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import casadi as ca
import numpy as np

from ...algebra.linear_systems import solution
from ...algebra.number_types import Algebra
from ...algebra.program import Program
from ..equations import Equations
from .slopes import rates_and_slopes

AGREES = 1e-6
"""Relative difference up to which rates and the solution of the implicit form are the same."""


def solvable(system: Equations) -> bool:
    """Whether the implicit form gives every rate that it names, tried at a point of doubles.

    Parameters
    ----------
    system
        A system; one that is built from its mass matrix passes wherever its graph has values.
    """
    if system.mass is None or system.forcing is None:
        return False
    point = [
        [0.1 + 0.37 * ((5 * i) % 7) for i in range(len(names))]
        for names in (system.states, system.parameters)
    ]
    sides = ca.Function("sides", [system.x, system.p], [system.mass, system.forcing, system.rhs])
    mass, forcing, rates = (np.array(v) for v in sides(*point))
    if not all(np.isfinite(v).all() for v in (mass, forcing, rates)):
        return False
    try:
        z = np.linalg.solve(mass, forcing)[:, 0]
    except np.linalg.LinAlgError:
        return False
    own = [(z[j], rates[i, 0]) for i, j in solved_rates(system).items()]
    return bool(own) and all(abs(v - r) <= AGREES * (1 + np.abs(z).max()) for v, r in own)


def solved_rates(system: Equations) -> dict[int, int]:
    """Index of the unknown of the implicit form by index of the state whose rate it is."""
    places = {name: j for j, name in enumerate(system.unknowns)}
    return {i: places[f"d_{n}"] for i, n in enumerate(system.states) if f"d_{n}" in places}


@dataclass(frozen=True)
class Asked:
    """One output: some rates, or some of their slopes; or an output of another program."""

    rows: Sequence[int] = ()
    """Indices of states."""
    columns: Sequence[int] | None = None
    """Indices in (states, parameters) of the slopes' variables; None for the rates themselves."""
    other: Program | None = None
    """The other program, of one output."""


class Implicit:
    """M, F and the slopes of F - M z at a family, as graphs.

    Parameters
    ----------
    system
        The system.
    values
        Values of states and parameters by name: symbols, or numbers as symbols.
    algebra
        CasADi's expressions, which fold zeros alone.
    program
        Function from outputs in the family's symbols, and more inputs, to a `Program`.
    hidden
        Slopes (rate, state) that are proved zero.
    """

    def __init__(
        self,
        system: Equations,
        values: Mapping[str, Any],
        algebra: Algebra,
        program: Callable[..., Program],
        hidden: Sequence[tuple[int, int]],
    ) -> None:
        assert system.mass is not None and system.forcing is not None
        self.solved = solved_rates(system)
        self.own = [i for i in range(len(system.states)) if i not in self.solved]
        size, states = system.mass.size1(), len(system.states)
        given = [[values[n] for n in names] for names in (system.states, system.parameters)]
        bare = Program(
            ca.Function(
                "sides", [system.x, system.p], [ca.densify(system.mass), ca.densify(system.forcing)]
            )
        )
        mass, forcing = bare.run(algebra, given)
        self.mass = ca.sparsify(ca.reshape(ca.vertcat(*map(ca.SX, mass)), size, size))
        self.forcing = ca.vertcat(*map(ca.SX, forcing))
        z = ca.SX.sym("z", size)
        self.rest = bool(self.forcing.is_zero())
        """Whether F vanishes identically, so that z does."""
        column = ca.vertcat(*[system.rhs[i] for i in self.own], system.forcing - system.mass @ z)
        core = Program(
            ca.Function("core", [ca.vertcat(system.x, system.p), z], [ca.densify(column)])
        )
        inner = [ca.SX(0)] * size if self.rest else ca.vertsplit(z)
        found, slopes = rates_and_slopes(core, algebra, [v for g in given for v in g], inner)
        self.free = ca.vertcat(*map(ca.SX, found[: len(self.own)])) if self.own else ca.SX(0, 1)
        table = ca.SX(len(slopes), states + len(system.parameters))
        for i, row in enumerate(slopes):
            for j, value in row.items():
                table[i, j] = value
        self.table = ca.sparsify(table)
        self._z, self._program = z, program
        self._pattern = self._patterns(states, hidden)

    def _patterns(self, states: int, hidden: Sequence[tuple[int, int]]) -> tuple[Any, Any]:
        """Whether each rate, and each slope, may differ from zero."""
        from scipy.sparse import bmat
        from scipy.sparse.csgraph import connected_components

        mass = np.array(ca.DM(self.mass.sparsity(), 1)) != 0
        size, own = len(mass), len(self.own)
        _, labels = connected_components(bmat([[None, mass], [mass.T, None]]), directed=False)
        joined = labels[size:, None] == labels[None, :size]  # which equations move an unknown
        moved = np.array(ca.DM(self.table.sparsity(), 1)) != 0
        pushed = np.array([not self.forcing[i].is_zero() for i in range(size)])
        rates = np.array([False] * states)
        slopes = np.zeros((states, moved.shape[1]), dtype=bool)
        for k, i in enumerate(self.own):
            rates[i], slopes[i] = not self.free[k].is_zero(), moved[k]
        for i, j in self.solved.items():
            rates[i] = (joined[j] & pushed).any()
            slopes[i] = (joined[j][:, None] & moved[own:]).any(axis=0)
        for i, j in hidden:
            slopes[i, j] = False
        return rates, slopes

    @property
    def still(self) -> list[bool]:
        """Whether each rate vanishes identically."""
        return [not bool(v) for v in self._pattern[0]]

    def program(self, *outputs: Asked) -> Program:
        """Rates and slopes as a program.

        Parameters
        ----------
        outputs
            What it returns, in order.
        """
        return _Solved(self, outputs)

    def equations(
        self, rows: Sequence[int], inputs: Sequence[ca.SX], numbers: tuple[ca.SX, Sequence[float]]
    ) -> ca.Function:
        """Some rates as a function of (unknowns, given) in doubles, for a root-finder.

        Parameters
        ----------
        rows
            Indices of states.
        inputs
            Symbols of the unknowns and of (family parameters, parameters).
        numbers
            Symbols of the graph's numbers, and their values.
        """
        column, values = numbers
        sides = [self.mass, self.forcing, self.free]
        if values:
            sides = ca.substitute(sides, [column], [ca.DM(values)])
        known = ca.Function("sides", list(inputs), sides)
        symbols = [ca.MX.sym("unknowns", inputs[0].numel()), ca.MX.sym("given", inputs[1].numel())]
        mass, forcing, free = known(*symbols)
        z = ca.solve(mass, forcing)
        places = {i: free[k] for k, i in enumerate(self.own)}
        places |= {i: z[j] for i, j in self.solved.items()}
        return ca.Function("residual", symbols, [ca.vertcat(*[places[i] for i in rows])])

    def shape(self, asked: Asked) -> tuple[int, int]:
        """Shape of an output."""
        if asked.other is not None:
            return asked.other.shapes[0]
        return len(asked.rows), 1 if asked.columns is None else len(asked.columns)

    def places(self, asked: Asked) -> tuple[tuple[int, int], ...]:
        """(row, column) of each stored entry of an output."""
        rates, slopes = self._pattern
        if asked.other is not None:
            return asked.other.places[0]
        if asked.columns is None:  # rates are a dense column
            return tuple((i, 0) for i in range(len(asked.rows)))
        return tuple(
            (i, j)
            for j, column in enumerate(asked.columns)
            for i, row in enumerate(asked.rows)
            if slopes[row, column]
        )

    @cached_property
    def _sides(self) -> Program:
        return self._program("sides", self.mass, self.forcing, self.free)

    @cached_property
    def _slopes(self) -> Program:
        return self._program("slopes", self.table, more=[self._z])

    def run(
        self, algebra: Algebra, arguments: Sequence[Sequence[Any]], *, slopes: bool
    ) -> tuple[dict[int, Any], dict[tuple[int, int], Any]]:
        """Every rate, and every slope where asked, by index."""
        mass, forcing, free = (self._sides.dense(algebra, arguments, k) for k in range(3))
        z = [[algebra.constant(0.0)]] * len(mass)
        if not self.rest:
            z = solution(algebra, mass, forcing)
        rates = {i: row[0] for i, row in zip(self.own, free, strict=True)}
        rates |= {i: z[j][0] for i, j in self.solved.items()}
        if not slopes:
            return rates, {}
        table = self._slopes.dense(algebra, [*arguments, [row[0] for row in z]])
        moved = solution(algebra, mass, table[len(self.own) :])
        rows = dict(zip(self.own, table, strict=False)) | {
            i: moved[j] for i, j in self.solved.items()
        }
        return rates, {(i, j): v for i, row in rows.items() for j, v in enumerate(row)}


class _Solved(Program):
    """Rates and slopes of an implicit form, with the face of a `Program`."""

    tape = None
    """None: it solves linear systems, for which no kernel runs."""

    def __init__(self, form: Implicit, outputs: Sequence[Asked]) -> None:
        self._form, self._outputs, self.name = form, outputs, "implicit"
        self.places = tuple(map(form.places, outputs))
        self.shapes = tuple(map(form.shape, outputs))
        self.size = form.mass.numel() + form.table.nnz()

    def run(self, algebra: Algebra, arguments: Sequence[Sequence[Any]]) -> list[list[Any]]:
        """As `Program.run`."""
        sloped = any(one.columns is not None for one in self._outputs)
        rates, slopes = self._form.run(algebra, arguments, slopes=sloped)
        out = []
        for one, places in zip(self._outputs, self.places, strict=True):
            if one.other is not None:
                out.append(one.other.run(algebra, arguments)[0])
            elif one.columns is None:
                out.append([rates[i] for i in one.rows])
            else:
                out.append([slopes[one.rows[i], one.columns[j]] for i, j in places])
        return out
