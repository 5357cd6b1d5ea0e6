"""Observables along a path."""

from __future__ import annotations

from functools import cache

import casadi as ca
import numpy as np

from ..algebra.program import Program
from ..base.types import Floats
from ..bodies.contact import Contact
from ..bodies.contact_laws import Rough
from ..integrators.flow import moving_system
from ..integrators.stick_slip import REST, STICKING


@cache
def _observer(law: type[Contact]) -> Program:
    """Energy, height, gn, contact force and power of six states."""
    system = moving_system(law)
    seen = system.observables
    values = [
        seen["energy"], ca.sin(system.x[0]), seen["normal_force"], seen["contact_force"],
        seen["power"],
    ]  # fmt: skip
    return Program(ca.Function("observer", [system.x, system.p], [ca.vertcat(*values)]))


OBSERVED = ("energy", "potential", "normal_force", "force_x", "force_y", "power")


def observe(
    law: type[Contact], six: Floats, p: Floats, modes: Floats | None, heading: Floats | None = None
) -> Floats:
    """The observables of states.

    Parameters
    ----------
    law
        The law.
    six
        States, shape (…, 6).
    p
        Parameters of the law's system, shape (…, m).
    modes
        Sliding or sticking, shape (…), for dry friction.
    heading
        Direction of the slip where it is zero but sets in, shape (…) [rad].

    Returns
    -------
    ndarray
        `OBSERVED` along the first axis, then (…).
    """
    program = _observer(law)  # type: ignore[arg-type]  # a class is hashable
    if heading is not None:
        still = np.hypot(six[..., 4], six[..., 5]) < REST
        six = six.copy()
        six[still, 4] = REST * np.cos(heading[still])
        six[still, 5] = REST * np.sin(heading[still])
    own = len(moving_system(law).states)
    x, q = list(np.moveaxis(six[..., :own], -1, 0)), list(np.moveaxis(p, -1, 0))
    values = program.arrays([x, q], six.shape[:-1])[0][..., 0]
    if modes is not None and (modes == STICKING).any():
        sticking = modes == STICKING
        held = [list(np.moveaxis(six[sticking][:, :4], -1, 0)),
                [np.broadcast_to(p[..., 0], modes.shape)[sticking]]]  # fmt: skip
        values[sticking] = _observer(Rough).arrays(held, (int(sticking.sum()),))[0][..., 0]
    return np.moveaxis(values, -1, 0)
