"""Surroundings of a family that one state names and whose members are known in closed form."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import casadi as ca

from ..algebra.number_types import casadi_algebra
from ..algebra.program import Program
from ..algebra.upright import UPRIGHT
from ..systems.system import System
from .attraction import Surroundings, Tilted, smooth_field


def line_surroundings(
    system: System, positive: ca.SX, own: str, member: Mapping[str, Any], y: ca.SX, given: ca.SX
) -> Surroundings:
    """Programs of (y, given, e) → ∂G/∂e and ∂g/∂e, and → conditions, around a family.

    Parameters
    ----------
    system
        The equations of motion.
    positive
        Conditions of the system's states that must stay positive.
    own
        The state that names a member.
    member
        The states of a member by name: expressions of `y` and `given`, numbers, or `UPRIGHT`.
    y
        Symbol of the state that names a member.
    given
        Symbols of the second argument of the programs, which end with the system's parameters.

    Returns
    -------
    Surroundings
    """
    others = [n for n in system.states if n != own]  # whose deviations are e
    e = ca.SX.sym("e", len(others))
    deviations = {n: e[i] for i, n in enumerate(others)}
    x = [
        y if n == own
        else Tilted(deviations[n]) if member[n] is UPRIGHT
        else member[n] + deviations[n]
        for n in system.states
    ]  # fmt: skip
    graph = Program(ca.Function("graph", [system.x, system.p], [system.rhs, positive]))
    values = graph.run(casadi_algebra(), [x, ca.vertsplit(system.p)])
    rows = (system.states[row] for row, _ in graph.places[0])
    rhs = dict.fromkeys(system.states, ca.SX(0)) | dict(zip(rows, values[0], strict=True))
    along = rhs[own]
    for n in others:  # a member moves with its parameter
        if member[n] is not UPRIGHT and ca.depends_on(ca.SX(member[n]), y):
            rhs[n] = rhs[n] - ca.jacobian(member[n], y) * along
    field = ca.densify(ca.vertcat(*(rhs[n] for n in others), along))
    slope = ca.densify(ca.jacobian(field, e))
    inputs = [y, given, e]
    return Surroundings(
        1, len(others), Program(ca.Function("slopes", inputs, [slope])),
        Program(ca.Function("positive", inputs, [ca.densify(ca.vertcat(*values[1]))])),
        field=smooth_field(ca.Function("field", inputs, [field])),
    )  # fmt: skip
