"""The slow flow of straight rolling on its centre manifold, derived from the graph.

Rolling under friction has one structural zero more than its family explains: a tilt α = θ - π/2
with its precession and lateral slip.  The centre manifold is a graph over (α, omega3).  Its Taylor
coefficients in α follow order by order from the invariance equation, whose right-hand side CasADi
differentiates and SymPy reads.  `stability.boundary.drift` states the result in closed form;
tests/boundary/test_drift.py compares the two.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import casadi as ca
import sympy

from stability.algebra.number_types import Algebra, sympy_algebra
from stability.algebra.program import Program
from stability.bodies.newton_euler import STATES
from stability.bodies.thin_disk import disk_system
from stability.derivation.characteristic import MU, K

W = sympy.Symbol("w", positive=True)
DEPENDENT = ("theta_dot", "phi_dot", "slip_x", "slip_y")
"""States that are functions of the tilt and omega3 on the manifold."""


@dataclass(frozen=True)
class SlowFlow:
    """Leading order of the flow on the centre manifold of rolling."""

    tilt: sympy.Expr
    """a in dα/dt = a α³ + …, in k, mu, w."""
    spin: sympy.Expr
    """b in dw/dt = b α² + …"""
    manifold: dict[str, tuple[sympy.Expr, ...]]
    """Coefficients of α, α², … of each dependent state."""
    launch: sympy.Expr
    """Ratio of the tilt on the slow manifold to the tilt of a launch with phi_dot = slip = 0."""


def derive_slow_flow(law: str = "viscous", order: int = 3) -> SlowFlow:
    """The slow flow of rolling under a law with friction.

    Parameters
    ----------
    law
        viscous or linear-viscous.
    order
        Highest power of the tilt; 3 gives the leading order of both equations.

    Returns
    -------
    SlowFlow

    Examples
    --------
    >>> sympy.factor(derive_slow_flow().spin)
    -1/(mu*w*(2*k + 1)**3)
    """
    terms = _taylor(law, order)
    known: dict[str, list[sympy.Expr]] = {n: [] for n in DEPENDENT}
    spin: list[sympy.Expr] = []
    jacobian = _block(law)
    for power in range(1, order + 1):
        base = {n: [*c, sympy.Integer(0)] for n, c in known.items()}
        rates = {n: sympy.together(e) for n, e in terms(power, base).items()}
        right = []
        for name in DEPENDENT:
            moved = sum(
                (i + 1) * known[name][i] * known["theta_dot"][power - i - 1]
                for i in range(1, power - 1)
            )
            moved += sum(
                sympy.diff(known[name][i], W) * spin[power - i - 2] for i in range(power - 1)
            )
            right.append(sympy.together(moved - rates[name]))
        # α̇ is theta_dot: its unknown coefficient also multiplies the slope of the manifold
        matrix = jacobian.copy()
        if power > 1:
            for row, name in enumerate(DEPENDENT):
                matrix[row, 0] -= known[name][0]
        solution = matrix.LUsolve(sympy.Matrix(right))
        for name, value in zip(DEPENDENT, solution, strict=True):
            known[name].append(sympy.factor(sympy.simplify(value)))
        full = terms(power, known)["omega3"]
        spin.append(sympy.factor(sympy.simplify(full)))
    return SlowFlow(
        known["theta_dot"][2], spin[1], {n: tuple(c) for n, c in known.items()}, _launch(law, known)
    )


def _upright_algebra() -> Algebra:
    """SymPy with every sine 1 and every cosine 0, as theta = π/2 is the only angle in the graph."""
    algebra = sympy_algebra()
    exact = {"sin": lambda _: sympy.Integer(1), "cos": lambda _: sympy.Integer(0)}
    return replace(algebra, functions=dict(algebra.functions) | exact)


def _taylor(law: str, order: int) -> Any:
    """Function from the states' coefficients to those of each rate, at a power of the tilt."""
    system = disk_system(law)
    tilt, w = ca.SX.sym("tilt"), ca.SX.sym("w")
    symbols = {n: ca.SX.sym(n, order) for n in DEPENDENT}
    upright = ca.SX.sym("upright")
    powers = ca.vertcat(*[tilt**i for i in range(1, order + 1)])
    values = {n: ca.dot(c, powers) for n, c in symbols.items()}
    values |= {"theta": upright + tilt, "omega3": w}
    state = ca.vertcat(*[values[n] for n in STATES])
    rates = ca.substitute(system.rhs, system.x, state)
    programs = []
    derivative, factorial = rates, 1
    for power in range(1, order + 1):
        derivative = ca.jacobian(derivative, tilt)
        factorial *= power
        at_zero = ca.substitute(derivative / factorial, tilt, ca.SX(0))
        inputs = [upright, w, system.p, *symbols.values()]
        programs.append(Program(ca.Function("taylor", inputs, [ca.densify(at_zero)])))
    algebra = _upright_algebra()

    def coefficient(power: int, known: dict[str, list[sympy.Expr]]) -> dict[str, sympy.Expr]:
        padded = [[*known[n], *[sympy.Integer(0)] * order][:order] for n in DEPENDENT]
        angle = [sympy.Symbol("upright")]
        found = programs[power - 1].dense(algebra, [angle, [W], [K, MU], *padded])
        return {n: row[0] for n, row in zip(STATES, found, strict=True)}

    return coefficient


def _jacobian(law: str) -> sympy.Matrix:
    system = disk_system(law)
    program = Program(ca.Function("jacobian", [system.x, system.p], [system.jacobian]))
    zero = sympy.Integer(0)
    state = [sympy.Symbol("upright"), zero, zero, W, zero, zero]
    return sympy.Matrix(program.dense(_upright_algebra(), [state, [K, MU]]))


def _block(law: str) -> sympy.Matrix:
    rows = [STATES.index(n) for n in DEPENDENT]
    return _jacobian(law).extract(rows, rows)


def _launch(law: str, known: dict[str, list[Any]]) -> sympy.Expr:
    """Projection of a pure tilt on the slow manifold along the fast directions."""
    left = _jacobian(law).T.nullspace()
    slow = [sympy.Integer(0)] * len(STATES)
    slow[0] = sympy.Integer(1)
    for name in DEPENDENT:
        slow[STATES.index(name)] = known[name][0]
    family = [sympy.Integer(n == "omega3") for n in STATES]
    basis = sympy.Matrix([slow, family]).T
    rows = sympy.Matrix.hstack(*left).T
    # coordinates on the centre space: (rows · basis)⁻¹ rows · launch
    start = sympy.Matrix([sympy.Integer(n == "theta") for n in STATES])
    return sympy.factor(sympy.simplify(((rows * basis).inv() * rows * start)[0]))
