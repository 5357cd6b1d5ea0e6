"""The disk held to a stated slip: its rates, and the force that holds it.

Creep is this motion with the slip that the viscous law has under that very force.  Where the slip
is a function of time, so is the force: no graph of a function of the state is needed, and each
order of creep costs one evaluation along the path.
"""

from __future__ import annotations

from functools import lru_cache

import casadi as ca

from ...algebra.program import Program
from ...systems.equations import eliminate
from ..contact_laws import Rough
from .disk_equations import DiskBody


class _Held(DiskBody):
    """The rough disk's equations, with a slip that changes at a stated rate."""

    def __init__(self, x: ca.SX, k: ca.SX, slip: ca.SX, slip_rate: ca.SX) -> None:
        super().__init__(x, k, Rough, 0, False, ca.vertsplit(slip))
        self.stated, self.stated_rate = slip, slip_rate

    def rate(self, expression: ca.SX) -> ca.SX:
        return super().rate(expression) + ca.jtimes(expression, self.stated, self.stated_rate)


@lru_cache(maxsize=1)
def held_disk() -> tuple[Program, Program]:
    """The disk held to a slip, as programs of (x, k, slip, rate of slip).

    Returns
    -------
    motion, slope
        Programs with inputs of 4, 1, 2 and 2 entries.  The first gives the rates, shape (4, 1), and
        the force along x̂ and ŷ with the normal force, shape (3, 1).  The second gives the slope
        of the rates in x, shape (4, 4).

    Source: the equations of `disk_equations`; with no slip they are the rough disk's, and with the
    slip and its rate of the viscous disk they are its own (tests/bodies/test_held_disk.py).

    Examples
    --------
    >>> held_disk()[0].shapes
    ((4, 1), (3, 1))
    """
    x, k = ca.SX.sym("x", 4), ca.SX.sym("k")
    slip, rate = ca.SX.sym("slip", 2), ca.SX.sym("slip_rate", 2)
    body = _Held(x, k, slip, rate)
    solved, _ = eliminate(*body.implicit_form(), body.pivots)
    found = dict(zip(body.unknown_names, solved, strict=True))
    rates = ca.vertcat(x[1], *(found[f"d_{n}"] for n in ("theta_dot", "phi_dot", "omega3")))
    forces = ca.vertcat(found["force_x"], found["force_y"], found["normal"])
    slope, given = ca.densify(ca.jacobian(rates, x)), [x, k, slip, rate]
    return (
        Program(ca.Function("held", given, [ca.densify(rates), ca.densify(forces)])),
        Program(ca.Function("slope", given, [slope])),
    )
