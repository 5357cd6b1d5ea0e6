"""A system's graph read at a family: state, rates, Jacobian, equations, tangent."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import casadi as ca
import numpy as np

from .algebra import Program, Upright, casadi_algebra

if TYPE_CHECKING:
    from .families import Family


class FamilyGraph:
    """Programs of a family, each with inputs (family parameters, unknowns, parameters).

    Parameters
    ----------
    family
        The family.
    """

    def __init__(self, family: Family) -> None:
        system, sx = family.system, casadi_algebra()
        a = [ca.SX.sym(n) for n in family.at]
        u = [ca.SX.sym(n) for n in family.unknown]
        q = [ca.SX.sym(n) for n in family.parameters]
        table: dict[str, Any] = dict(zip(family.at, a, strict=True))
        table |= {
            n: v if isinstance(v, Upright) else ca.SX(float(v)) for n, v in family.held.items()
        }
        table |= dict(zip(family.parameters, q, strict=True))
        table_guess = table | {n: ca.SX(float(v)) for n, v in family.unknown.items()}
        table |= dict(zip(family.unknown, u, strict=True))
        graph = Program(ca.Function("graph", [system.x, system.p], [system.rhs, system.jacobian]))

        def read(values: dict[str, Any]) -> tuple[ca.SX, ca.SX]:
            x = [values[n] for n in system.states]
            p = [values[n] for n in system.parameters]
            rates, slopes = graph.run(sx, [x, p])
            n = len(x)
            f, jac = ca.SX(n, 1), ca.SX(n, n)
            for (i, _), value in zip(graph.places[0], rates, strict=True):
                f[i] = value
            for (i, j), value in zip(graph.places[1], slopes, strict=True):
                jac[i, j] = value
            return f, ca.sparsify(jac)

        rows = [system.index(n) for n in family.equations]
        f, jac = read(table)
        f_guess, jac_guess = read(table_guess)
        self.closed = bool(family.unknown) and all(f_guess[i].is_zero() for i in rows)
        if self.closed:
            f, jac = f_guess, jac_guess
        states = [table_guess[n] if self.closed else table[n] for n in system.states]
        state = ca.vertcat(*[ca.SX(np.pi / 2) if isinstance(v, Upright) else v for v in states])
        va, vu, vq = (ca.vertcat(*s) if s else ca.SX(0, 1) for s in (a, u, q))
        inputs = [va, vu, vq]
        full, _ = read(table)
        residual = ca.vertcat(*[full[i] for i in rows]) if rows else ca.SX(0, 1)
        x = ca.vertcat(*[ca.SX(np.pi / 2) if isinstance(table[n], Upright) else table[n]
                         for n in system.states])  # fmt: skip
        p = ca.vertcat(*[table[n] for n in system.parameters]) if system.parameters else ca.SX(0, 1)
        values = [ca.substitute(c.value, ca.vertcat(system.x, system.p), ca.vertcat(x, p))
                  for c in system.conditions]  # fmt: skip
        free = [i for i, v in enumerate(values) if not u or not ca.depends_on(v, vu)]
        self.early = (
            [system.conditions[i] for i in free],
            Program(ca.Function("early", inputs, [values[i] for i in free])),
        )
        self.state = Program(ca.Function("state", inputs, [state]))
        self.rates = Program(ca.Function("rates", inputs, [f]))
        self.matrix = Program(ca.Function("matrix", inputs, [jac]))
        by_u = ca.jacobian(residual, vu)
        self.tangent = Program(ca.Function("tangent", inputs, [
            ca.jacobian(state, va), ca.jacobian(state, vu),
            ca.densify(residual), by_u, ca.jacobian(residual, va),
        ]))  # fmt: skip
        self.residual = Program(ca.Function("residual", inputs, [ca.densify(residual), by_u]))
        parameters = ca.vertcat(va, vq)
        self.used = [i for i in range(parameters.numel()) if ca.depends_on(residual, parameters[i])]
        self._size = len(u)
        if u:
            problem = ca.Function("residual", [vu, parameters], [residual])
            options = {
                "abstol": 1e-300,
                "abstolStep": 1e-14,
                "max_iter": 200,
                "error_on_fail": False,
            }
            self.finder = ca.rootfinder("root", "fast_newton", problem, options)

    def place(self, entries: list[Any]) -> list[list[Any]]:
        """Rows of the unknowns' Jacobian from its stored entries."""
        dense: list[list[Any]] = [[0] * self._size for _ in range(self._size)]
        for (i, j), value in zip(self.residual.places[1], entries, strict=True):
            dense[i][j] = value
        return dense
