"""The general graph of a body of revolution around a pole, in SymPy.

The height is a cubic polynomial in c = cosθ about c = ±1, whose value and slopes are free symbols.
At θ = 0 its second derivative by θ is h′′ = -f′(1), and at θ = π it is f′(-1).  Mass, gravity and
length are 1.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import casadi as ca
import sympy

from stability.algebra.number_types import sympy_algebra
from stability.algebra.program import Program
from stability.base.errors import StabilityError
from stability.bodies.contact_laws import LAWS, Contact
from stability.bodies.round_body.pole_equations import PoleBody
from stability.bodies.round_body.shape import SCALES
from stability.bodies.round_body.si_law import Law
from stability.derivation.characteristic import MU

from ..body_polynomials import BEND, FORCE_X, FORCE_Y, I1, I3, SLIP_X, SLIP_Y, H

Expr = Any
"""A SymPy expression; SymPy states no types."""
RATE = sympy.Symbol("n")
"""Rate ω_Z of vertical spin."""
TURN_X, TURN_Y = sympy.symbols("omega_X omega_Y")
SECOND, THIRD = sympy.symbols("f′′ f′′′")
"""Derivatives of the height by cosθ at the pole."""
POLES = {1: "0", -1: "π"}
"""Sign of cosθ, and the inclination in words."""
PAIRS = ((0, 1), (2, 3), (5, 6))
"""Places of axis, angular velocity and slip along X and Y."""


@dataclass(frozen=True)
class PoleGraph:
    """Rates and their derivatives at a state with the axis vertical."""

    rates: tuple[Expr, ...]
    """Rates of axis (X, Y), angular velocity (X, Y, Z) and slip (X, Y)."""
    by_state: sympy.Matrix
    """Derivatives of the rates by these states."""
    normal: Expr
    """Normal force."""


@lru_cache(maxsize=16)
def pole_graph(law: str | type[Contact], side: int, *, still: bool = True) -> PoleGraph:
    """The equations of every body under a law, at a state with its axis vertical.

    Examples
    --------
    >>> pole_graph("smooth", 1).rates
    (0, 0, 0, 0, 0)
    """
    contact = LAWS[law] if isinstance(law, str) else law
    given = tuple(p.name for p in contact.parameters)
    values = {
        "axial": I3,
        "transverse": I1,
        "h": H,
        "slope": -side * BEND,
        "second": SECOND,
        "third": THIRD,
        "mu": MU,
        "force_x": FORCE_X,
        "force_y": FORCE_Y,
    }
    names = [n for n in values if n in given or n not in ("mu", "force_x", "force_y")]
    numbers = {n: ca.SX.sym(n) for n in names}
    table = dict.fromkeys(SCALES, 1) | numbers
    x, cosine = ca.SX.sym("x", 7 if contact.slips else 5), ca.SX.sym("c")
    step = cosine - side
    height = numbers["h"] + step * (
        numbers["slope"] + step * (numbers["second"] / 2 + step * numbers["third"] / 6)
    )
    up = side * ca.sqrt(1 - ca.sumsqr(x[:2]))
    body = PoleBody(
        ca.vertcat(x[:2], up), x[2:5], x[5:], (cosine, height), Law(contact, table, given), table
    )
    rhs, seen = body.solved()
    whole = ca.vertcat(ca.cross(body.turn, body.axis)[:2], rhs)
    outputs = [whole, ca.jacobian(whole, x), seen["normal_force"]]
    program = Program(ca.Function("pole", [x, ca.vertcat(*numbers.values())], outputs))
    zero = sympy.Integer(0)
    state = [zero] * 4 + [RATE] + [zero] * (x.numel() - 5)
    if not still:
        state[2:4], state[5:] = (TURN_X, TURN_Y), (SLIP_X, SLIP_Y)[: x.numel() - 5]
    at = [state, [values[n] for n in names]]
    read = [
        sympy.Matrix(program.dense(sympy_algebra(), at, i)).applyfunc(sympy.cancel)
        for i in range(3)
    ]
    return PoleGraph(tuple(read[0]), read[1], read[2][0])


def complex_matrix(law: str, side: int) -> sympy.Matrix:
    """The linearisation at vertical spin on vectors X + i Y: axis, angular velocity, slip.

    Examples
    --------
    >>> complex_matrix("smooth", 1)[0, :]
    Matrix([[I*n, -I]])
    """
    matrix = pole_graph(law, side).by_state
    pairs = PAIRS[: 3 if matrix.rows == 7 else 2]
    rest = [matrix[4, :], matrix[:, 4].T]
    whole = sympy.zeros(len(pairs))
    for i, (a, b) in enumerate(pairs):
        for j, (c, d) in enumerate(pairs):
            even = (matrix[a, c] - matrix[b, d], matrix[a, d] + matrix[b, c])
            if any(sympy.expand(e) != 0 for e in even):
                raise StabilityError(f"the {law} graph at a pole does not turn with the vertical.")
            whole[i, j] = matrix[a, c] + sympy.I * matrix[b, c]
    if any(e != 0 for row in rest for e in row):
        raise StabilityError(f"the rate of vertical spin does not stand apart ({law}).")
    return whole
