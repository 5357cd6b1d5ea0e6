"""A system's graph read at a family: state, rates, Jacobian, equations, tangent."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import casadi as ca
import numpy as np

from ...algebra.number_types import Algebra
from ...algebra.program import Program
from ...algebra.upright import Upright
from ..equations import Equations
from .constants import Constants, exact_numbers, rounded
from .implicit import Asked, Implicit, solvable, solved_rates
from .slopes import rates_and_slopes

FINDER = {"abstol": 1e-300, "abstolStep": 1e-14, "max_iter": 200, "error_on_fail": False}
"""Options for CasADi's root-finder, to the last digit; `Family` checks the root afterwards."""
LARGE = 40_000
"""Instructions times states above which slopes are folded on the way."""


@dataclass(frozen=True, eq=False)
class Frame:
    """A system with the parts that a family fixes."""

    system: Equations
    """The equations of motion."""
    at: Sequence[str]
    """Names of the family parameters."""
    held: Mapping[str, float | Upright]
    """Values of the states that do not change along the family."""
    unknown: Mapping[str, float]
    """First guesses of the states solved for."""
    equations: Sequence[str]
    """States whose rates must vanish, and observables that must vanish."""
    zero: Sequence[tuple[int, int]] = ()
    """Entries of the linearisation that are proved zero, for any entry of the graph."""
    decimals: bool = False
    """Whether a double that is the nearest one to a short decimal is read as the decimal."""


class FamilyGraph:
    """Programs of a family, each with inputs (family parameters, unknowns, parameters).

    Parameters
    ----------
    frame
        A system with the parts that the family fixes.
    """

    def __init__(self, frame: Frame) -> None:
        self._frame = frame
        self._system = system = frame.system
        self._zero = frame.zero
        others = [n for n in system.parameters if n not in frame.at]
        a, u, q = ([ca.SX.sym(n) for n in names] for names in (frame.at, frame.unknown, others))
        self._inputs = [ca.vertcat(*s) if s else ca.SX(0, 1) for s in (a, u, q)]
        self._size = len(u)
        self._constants = Constants(decimals=frame.decimals)
        known: dict[str, Any] = dict(zip([*frame.at, *others], [*a, *q], strict=True))
        known |= {
            n: v if isinstance(v, Upright) else self._constants(v) for n, v in frame.held.items()
        }
        guessed = known | {n: self._constants(v) for n, v in frame.unknown.items()}
        table = known | dict(zip(frame.unknown, u, strict=True))
        self._seen = [n for n in frame.equations if n not in system.states]
        table_of_rows = [*system.states, *self._seen]
        rows = [table_of_rows.index(n) for n in frame.equations]
        if self._solvable():
            self._solved_for(frame, table, guessed, rows, others)
            self._conditions(table)
            return
        values, slopes = self._read(table)
        residual = self._vanishing(values, table, rows)
        at_guess = self._read(guessed) if u else (values, slopes)
        self.closed = bool(u) and all(at_guess[0][i].is_zero() for i in rows)
        """Whether the first guess solves the equations identically."""
        if self.closed:
            values, slopes = at_guess
        self.rates = self._program("rates", values[: len(system.states)])
        self.matrix = self._program("matrix", slopes)
        self._equations(residual, self._numbers(guessed if self.closed else table, system.states))
        self._conditions(table)

    def _vanishing(self, values: ca.SX, table: Mapping[str, Any], rows: Sequence[int]) -> ca.SX:
        """What vanishes at a member: these rates, but F in place of M⁻¹ F where all of it does.

        The roots are the same where M is regular, as it is wherever the rates have values; a graph
        of F is much smaller than one that has eliminated M, and so are its enclosures.
        """
        system = self._system
        found = {i: values[i] for i in rows}
        if rows and system.mass is not None and system.forcing is not None:
            solved = solved_rates(system)
            if len(solved) == system.mass.size1() and set(solved) <= set(rows):
                forcing = self._forcing(system.forcing, table)
                if exact_numbers(system.mass, system.forcing, forcing) and solvable(system):
                    found |= {i: forcing[j] for i, j in solved.items()}
        return ca.vertcat(*found.values()) if found else ca.SX(0, 1)

    def _forcing(self, forcing: ca.SX, table: Mapping[str, Any]) -> ca.SX:
        """The forcing with these values for the symbols, zeros folded."""
        system = self._system
        bare = Program(ca.Function("forcing", [system.x, system.p], [ca.densify(forcing)]))
        given = [[table[n] for n in names] for names in (system.states, system.parameters)]
        for strict in (False, True):
            values = bare.run(self._constants.algebra(strict=strict), given)[0]
            found = ca.vertcat(*map(ca.SX, values))
            if exact_numbers(found):
                break
        return found

    @property
    def numbers(self) -> tuple[list[float], tuple[float, ...]]:
        """Doubles that are read as they are, and doubles that are read as decimals."""
        return self._constants.values, self._constants.read

    def __reduce__(self) -> tuple[type[FamilyGraph], tuple[Frame]]:
        return FamilyGraph, (self._frame,)  # built again: compiled programs have no pickle

    def _program(self, name: str, *outputs: Any, more: Sequence[ca.SX] = ()) -> Program:
        inputs = [*self._inputs, *more, self._constants.column]
        return Program(ca.Function(name, inputs, list(outputs)), self._constants.values)

    @property
    def _large(self) -> bool:
        return self._bare.size * len(self._system.states) > LARGE

    @cached_property
    def _bare(self) -> Program:
        system = self._system
        values = ca.vertcat(system.rhs, *[system.observables[n] for n in self._seen])
        return Program(ca.Function("rates", [system.x, system.p], [ca.densify(values)]))

    @cached_property
    def _opened(self) -> tuple[ca.SX, ca.SX, list[tuple[str, Any]]]:
        """Rates (then observables), Jacobian of the rates, functions with their arguments.

        Numbers are symbols.
        """
        system, bare = self._system, self._bare
        entries = [ca.vertsplit(s) if s.numel() else [] for s in (system.x, system.p)]
        met: list[tuple[str, Any]] = []
        rhs = ca.vertcat(*bare.run(self._constants.algebra(met), entries)[0])
        # constants are symbols, so nothing is rounded
        return rhs, ca.jacobian(rhs[: len(system.states)], system.x), met

    def _read(self, values: Mapping[str, Any]) -> tuple[ca.SX, ca.SX]:
        """Rates (then observables) and Jacobian with these values for the symbols, zeros folded."""
        system = self._system
        if self._large:
            return self._read_large(values)
        rhs, slopes_of, met = self._opened
        numbers = self._constants.column
        inputs = [system.x, system.p, numbers]
        arguments = [[values[n] for n in names] for names in (system.states, system.parameters)]
        arguments.append(ca.vertsplit(numbers))
        plain = False
        if not any(isinstance(v, Upright) for v in arguments[0]):
            # CasADi's own evaluation is the same, and faster, where it rounds no number
            asked = ca.vertcat(*[x for _, x in met]) if met else ca.SX(0, 1)
            whole = ca.Function("graph", inputs, [rhs, slopes_of, asked])
            f, jac, given = whole(*[ca.vertcat(*a) if a else ca.SX(0, 1) for a in arguments])
            pairs = zip(met, ca.vertsplit(given) if met else [], strict=True)
            plain = not any(rounded(n, x) for (n, _), x in pairs)
            if plain and exact_numbers(f, jac):
                return ca.densify(f), ca.sparsify(jac)
        graph = Program(ca.Function("graph", inputs, [rhs, slopes_of]))
        if not plain:
            f, jac = self._run(graph, arguments, self._constants.algebra())
        if plain or not exact_numbers(f, jac):
            f, jac = self._run(graph, arguments, self._constants.algebra(strict=True))
        return f, jac

    def _run(self, graph: Program, arguments: list[Any], algebra: Algebra) -> tuple[ca.SX, ca.SX]:
        """Rates and Jacobian by an algebra of CasADi's expressions."""
        rates, slopes = graph.run(algebra, arguments)
        n = len(self._system.states)
        f, jac = ca.SX(n + len(self._seen), 1), ca.SX(n, n)
        for (i, _), value in zip(graph.places[0], rates, strict=True):
            f[i] = value
        for (i, j), value in zip(graph.places[1], slopes, strict=True):
            jac[i, j] = value
        for i, j in self._zero:
            jac[i, j] = 0
        return f, ca.sparsify(jac)

    def _read_large(self, values: Mapping[str, Any]) -> tuple[ca.SX, ca.SX]:
        """As `_read`, with each slope folded on the way."""
        system, n = self._system, len(self._system.states)
        given = [[values[n] for n in names] for names in (system.states, system.parameters)]
        for strict in (False, True):
            algebra = self._constants.algebra(strict=strict)
            rates, slopes = rates_and_slopes(self._bare, algebra, *given)
            jac = ca.SX(n, n)
            for i, row in enumerate(slopes[:n]):
                for j, value in row.items():
                    jac[i, j] = value
            f = ca.vertcat(*map(ca.SX, rates))
            if exact_numbers(f, jac):
                break
        return f, ca.sparsify(jac)

    # --- an implicit form, solved for in the number type ---

    def _solvable(self) -> bool:
        system = self._system
        if self._seen or not self._large or system.mass is None or system.forcing is None:
            return False
        # a mass matrix with a rounded third is not that of the rates, which keep thirds exact
        return exact_numbers(system.mass, system.forcing) and solvable(system)

    def _form(self, values: Mapping[str, Any]) -> Implicit:
        """The implicit form with these values, zeros folded."""
        for strict in (False, True):
            algebra = self._constants.algebra(strict=strict)
            form = Implicit(self._system, values, algebra, self._program, self._zero)
            if exact_numbers(form.mass, form.forcing, form.free, form.table):
                break
        return form

    def _solved_for(
        self,
        frame: Frame,
        table: Mapping[str, Any],
        guessed: Mapping[str, Any],
        rows: Sequence[int],
        others: Sequence[str],
    ) -> None:
        """Rates, Jacobian and equations of a large system with a mass matrix."""
        system, (a, u, q) = self._system, self._inputs
        names = [*system.states, *system.parameters]
        form = self._form(table)
        best = self._form(guessed) if self._size else form
        self.closed = bool(self._size) and all(best.still[i] for i in rows)
        every = range(len(system.states))
        member = best if self.closed else form
        self.rates = member.program(Asked(every))
        self.matrix = member.program(Asked(every, every))
        state = self._numbers(guessed if self.closed else table, system.states)
        self.state = self._program("state", state)
        of_a, of_u, of_q = (
            [names.index(n) for n in some] for some in (frame.at, frame.unknown, others)
        )
        values, by_u = Asked(rows), Asked(rows, of_u)
        moved = [Asked(other=self._program("state", ca.jacobian(state, s))) for s in (a, u)]
        self.residual = form.program(values, by_u)
        self.tangent = form.program(*moved, values, by_u, Asked(rows, of_a))
        self.along = form.program(values, by_u, Asked(rows, [*of_a, *of_q]))
        given = ca.vertcat(a, q)
        sides = ca.veccat(form.mass, form.forcing, form.free)
        self.used = [i for i in range(given.numel()) if ca.depends_on(sides, given[i])]
        if self._size:
            numbers = self._constants.column, self._constants.values
            problem = form.equations(rows, (u, given), numbers)
            self.finder = None
            pattern = np.zeros((len(rows), len(rows)))
            for place in self.residual.places[1]:
                pattern[place] = 1
            if ca.sprank(ca.sparsify(ca.DM(pattern))) == self._size:
                self.finder = ca.rootfinder("root", "fast_newton", problem, FINDER)

    @staticmethod
    def _numbers(values: Mapping[str, Any], names: Sequence[str]) -> ca.SX:
        """Values as a column, with the nearest double for the right angle."""
        column = [values[n] for n in names]
        column = [ca.SX(np.pi / 2) if isinstance(v, Upright) else ca.SX(v) for v in column]
        return ca.vertcat(*column) if column else ca.SX(0, 1)

    def _equations(self, residual: ca.SX, state: ca.SX) -> None:
        """State, equations, their derivatives, and CasADi's root-finder for them."""
        a, u, q = self._inputs
        self._unsolved = residual
        by_u = ca.jacobian(residual, u)
        dense = ca.densify(residual)
        self.state = self._program("state", state)
        self.residual = self._program("residual", dense, by_u)
        self.tangent = self._program(
            "tangent",
            ca.jacobian(state, a),
            ca.jacobian(state, u),
            dense,
            by_u,
            ca.jacobian(residual, a),
        )
        given = ca.vertcat(a, q)
        self.used = [i for i in range(given.numel()) if ca.depends_on(residual, given[i])]
        """Indices in (family parameters, parameters) of those in the equations."""
        if self._size:
            numbers = ca.DM(self._constants.values)
            plain = ca.substitute(residual, self._constants.column, numbers)
            problem = ca.Function("residual", [u, given], [plain])
            self.finder = None  # None where the Jacobian is singular for all numbers
            if ca.sprank(by_u) == self._size:
                self.finder = ca.rootfinder("root", "fast_newton", problem, FINDER)

    @cached_property
    def along(self) -> Program:
        """Equations, and their slopes by the unknowns and by (family parameters, parameters)."""
        residual, (a, u, q) = self._unsolved, self._inputs
        return self._program(
            "along",
            ca.densify(residual),
            ca.jacobian(residual, u),
            ca.jacobian(residual, ca.vertcat(a, q)),
        )

    def _conditions(self, table: Mapping[str, Any]) -> None:
        """The conditions without unknowns, to be checked before solving."""
        system, unknowns = self._system, self._inputs[1]
        symbols = ca.vertcat(system.x, system.p)
        place = ca.vertcat(
            self._numbers(table, system.states), self._numbers(table, system.parameters)
        )
        values = [ca.substitute(c.value, symbols, place) for c in system.conditions]
        free = [i for i, v in enumerate(values) if not self._size or not ca.depends_on(v, unknowns)]
        self.early = (
            [system.conditions[i] for i in free],
            self._program("early", *[values[i] for i in free]),
        )

    def place(self, entries: list[Any]) -> list[list[Any]]:
        """Rows of the unknowns' Jacobian from its stored entries.

        Parameters
        ----------
        entries
            Stored entries from `residual`.

        Returns
        -------
        list of list
        """
        dense: list[list[Any]] = [[0] * self._size for _ in range(self._size)]
        for (i, j), value in zip(self.residual.places[1], entries, strict=True):
            dense[i][j] = value
        return dense
