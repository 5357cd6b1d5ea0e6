"""A body held to a stated slip: its rates, and the force that holds it.

Creep is this motion with the slip that the viscous law has under that very force.  Where the slip
is a function of time, so is the force: no graph of a function of the state is needed, and each
order of creep costs one evaluation along the path.
"""

from __future__ import annotations

import casadi as ca

from ..algebra.program import Program
from ..systems.equations import eliminate
from .newton_euler import NewtonEuler

SLIP, SLIP_RATE = ca.SX.sym("slip", 2), ca.SX.sym("slip_rate", 2)
"""Symbols of the stated slip and its rate, along the axes of the body's equations."""


def held_programs(x: ca.SX, p: ca.SX, rates: ca.SX, forces: ca.SX) -> tuple[Program, Program]:
    """A body held to a slip, as programs of (x, p, slip, rate of slip).

    Parameters
    ----------
    x, p
        Symbols of the n states without slip, and of the parameters.
    rates, forces
        Rates of the states, and the two components of the contact force with the normal force, as
        expressions in these symbols, `SLIP` and `SLIP_RATE`.

    Returns
    -------
    motion, slope
        The first gives the rates, shape (n, 1), and the forces, shape (3, 1).  The second gives the
        slope of the rates in x, shape (n, n).

    Source: the equations are those of the body's own laws; with no slip they are those of the body
    that does not slip, and with the slip of the viscous law and its rate those of that law
    (tests/bodies/test_held_motion.py).
    """
    inputs = [x, p, SLIP, SLIP_RATE]
    motion = [ca.densify(rates), ca.densify(forces)]
    slope = ca.densify(ca.jacobian(rates, x))
    return Program(ca.Function("held", inputs, motion)), Program(
        ca.Function("slope", inputs, [slope])
    )


def held_in_angles(body: NewtonEuler, p: ca.SX) -> tuple[Program, Program]:
    """The programs of a body in its angles.

    Parameters
    ----------
    body
        Its equations without slip in the state, under a law that holds the slip at `SLIP`.
    p
        Symbols of its parameters.
    """
    body.slip_rate = SLIP_RATE
    solved, _ = eliminate(*body.implicit_form(), body.pivots)
    solution = dict(zip(body.unknown_names, solved, strict=True))
    rates = ca.vertcat(body.x[1], *(solution[f"d_{n}"] for n in ("theta_dot", "phi_dot", "omega3")))
    forces = ca.vertcat(solution["force_x"], solution["force_y"], solution["normal"])
    return held_programs(body.x, p, rates, forces)
