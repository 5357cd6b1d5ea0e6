"""A system's graph read at a family: state, rates, Jacobian, equations, tangent."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import casadi as ca
import numpy as np

from ..algebra.exact.number_fields import RATIONAL_AT
from ..algebra.number_types import Algebra, casadi_algebra
from ..algebra.program import Program
from ..algebra.upright import Upright
from .equations import Equations

FINDER = {"abstol": 1e-300, "abstolStep": 1e-14, "max_iter": 200, "error_on_fail": False}
"""Options for CasADi's root-finder, to the last digit; `Family` checks the root afterwards."""


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
    """States whose rates must vanish."""


class Constants:
    """The numbers of a graph as symbols, so that CasADi folds only zeros.

    CasADi computes sums, products or sines of numbers in double precision when it builds an
    expression.  A graph for exact arithmetic must not hold such rounded numbers.
    """

    def __init__(self) -> None:
        self._symbols: dict[float, ca.SX] = {}

    def __call__(self, value: float) -> ca.SX:
        """The number as a symbol; zero stays a number, since zeros fold without rounding."""
        if value == 0:
            return ca.SX(0)
        return self._symbols.setdefault(float(value), ca.SX.sym(f"c{len(self._symbols)}"))

    @property
    def column(self) -> ca.SX:
        """All symbols so far, as a column."""
        return ca.vertcat(*self._symbols.values()) if self._symbols else ca.SX(0, 1)

    @property
    def values(self) -> list[float]:
        """Values of the symbols, in the same order."""
        return list(self._symbols)

    def algebra(self) -> Algebra:
        """CasADi's own expressions with these constants."""
        plain = casadi_algebra()

        def kept(name: str) -> Any:
            def apply(x: Any) -> Any:
                known = isinstance(x, ca.SX) and x.is_constant()
                if known and float(x) != RATIONAL_AT.get(name, (float(x), 0))[0]:
                    x = ca.SX.sym("folded") if np.isnan(float(x)) else self._kept(float(x))
                return plain.functions[name](x)

            return apply

        table = {name: kept(name) for name in plain.functions if name not in ("pow", "fabs")}
        return Algebra("casadi", self, table | {"pow": self._power, "fabs": ca.fabs})

    def _kept(self, value: float) -> ca.SX:
        """A number, also zero, as a symbol: acos(0) is not rational."""
        return self._symbols.setdefault(value, ca.SX.sym(f"c{len(self._symbols)}"))

    def _power(self, x: Any, exponent: Any) -> Any:
        """A power; a whole or half exponent stays a number, so that its rule is known."""
        number = next((v for v, s in self._symbols.items() if ca.is_equal(s, exponent)), None)
        if number is None and exponent.is_constant():
            number = float(exponent)
        if number is not None and 2 * number == round(2 * number) and abs(number) < 2**20:
            return ca.power(x, number)
        return ca.power(x, exponent)


class FamilyGraph:
    """Programs of a family, each with inputs (family parameters, unknowns, parameters).

    Parameters
    ----------
    frame
        A system with the parts that the family fixes.
    """

    def __init__(self, frame: Frame) -> None:
        self._system = system = frame.system
        others = [n for n in system.parameters if n not in frame.at]
        a, u, q = ([ca.SX.sym(n) for n in names] for names in (frame.at, frame.unknown, others))
        self._inputs = [ca.vertcat(*s) if s else ca.SX(0, 1) for s in (a, u, q)]
        self._size = len(u)
        self._constants = Constants()
        known: dict[str, Any] = dict(zip([*frame.at, *others], [*a, *q], strict=True))
        known |= {n: v if isinstance(v, Upright) else self._constants(v)
                  for n, v in frame.held.items()}  # fmt: skip
        guessed = known | {n: self._constants(v) for n, v in frame.unknown.items()}
        table = known | dict(zip(frame.unknown, u, strict=True))
        rows = [system.index(n) for n in frame.equations]

        rates, slopes = self._read(table)
        residual = ca.vertcat(*[rates[i] for i in rows]) if rows else ca.SX(0, 1)
        at_guess = self._read(guessed)
        self.closed = bool(u) and all(at_guess[0][i].is_zero() for i in rows)
        """Whether the first guess solves the equations identically."""
        if self.closed:
            rates, slopes = at_guess
        self.rates = self._program("rates", rates)
        self.matrix = self._program("matrix", slopes)
        self._equations(residual, self._numbers(guessed if self.closed else table, system.states))
        self._conditions(table)

    def _program(self, name: str, *outputs: Any) -> Program:
        inputs = [*self._inputs, self._constants.column]
        return Program(ca.Function(name, inputs, list(outputs)), self._constants.values)

    def _read(self, values: Mapping[str, Any]) -> tuple[ca.SX, ca.SX]:
        """Rates and Jacobian with these values in place of the symbols, zeros folded."""
        system = self._system
        algebra = self._constants.algebra()
        bare = Program(ca.Function("rates", [system.x, system.p], [ca.densify(system.rhs)]))
        entries = [ca.vertsplit(s) if s.numel() else [] for s in (system.x, system.p)]
        rhs = ca.vertcat(*bare.run(algebra, entries)[0])
        slopes_of = ca.jacobian(rhs, system.x)  # constants are symbols, so nothing is rounded
        numbers = self._constants.column
        graph = Program(ca.Function("graph", [system.x, system.p, numbers], [rhs, slopes_of]))
        arguments = [[values[n] for n in names] for names in (system.states, system.parameters)]
        rates, slopes = graph.run(algebra, [*arguments, ca.vertsplit(numbers)])
        n = len(system.states)
        f, jac = ca.SX(n, 1), ca.SX(n, n)
        for (i, _), value in zip(graph.places[0], rates, strict=True):
            f[i] = value
        for (i, j), value in zip(graph.places[1], slopes, strict=True):
            jac[i, j] = value
        return f, ca.sparsify(jac)

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
            "tangent", ca.jacobian(state, a), ca.jacobian(state, u), dense, by_u,
            ca.jacobian(residual, a),
        )  # fmt: skip
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
            "along", ca.densify(residual), ca.jacobian(residual, u),
            ca.jacobian(residual, ca.vertcat(a, q)),
        )  # fmt: skip

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
