"""The thin disk: the body of height h = sinθ, whose rim is an edge.

Everything is dimensionless (m = R = g = 1).
Source: Przybylska & Rauch-Wojciechowski 2016, Section 2.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any

from ..base.checks import flag
from ..base.errors import ParameterError
from ..systems.system import System
from .contact_laws import DIRECTION, Contact, CoulombAlong, Smooth, law_class
from .model import Model
from .round_body.equations import Resistances, round_system
from .round_body.models.angle_model import round_model
from .round_body.thin import unit_disk


def disk_system(
    law: str | Contact | type[Contact] | None = None,
    *,
    slip_states: bool | None = None,
    direction: bool = False,
) -> System:
    """The disk under a contact law as a `System`; dimensionless, built once for each law.

    Parameters
    ----------
    law
        A contact law, its name or its class; its numbers stay parameters of the system.
    slip_states
        Whether the two slip velocities are states; None for the choice of the law.  Only the
        smooth disk allows both (its slip follows the other four states).  Without them its
        observables are those of a disk whose centre has no horizontal velocity.
    direction
        For `coulomb`: whether the angle of the slip is a separate parameter, so that the equations
        keep a meaning where the slip is zero.

    Returns
    -------
    System
        States `STATES` (or the first four); parameters `k` and, for a law with a coefficient,
        `mu` (its value is c* for `linear-viscous`; `coulomb-regularised` has `epsilon` too).
        Observables: `energy`, `normal_force`,
        `contact_force` (horizontal, x̂ and ŷ), `slip`, `determinant` (D), `power` (dissipated),
        `rim_speed` and `lever` (as for every body).

    Raises
    ------
    ParameterError
        If the law is missing, or has no such form of its equations.

    Source: equations of Przybylska & Rauch-Wojciechowski 2016; tests/bodies/test_equations.py.

    Examples
    --------
    >>> import math
    >>> import stability as st
    >>> system = st.disk_system("viscous")
    >>> upright = [math.pi / 2, 0, 0, 1.2, 0, 0]
    >>> float(system.observe(upright, [0.25, 0.3])["normal_force"])
    1.0
    """
    contact = law_class(law)
    if slip_states is not None:
        slip_states = flag("slip_states", slip_states)
        if slip_states != contact.slips and contact is not Smooth:
            raise ParameterError(
                f"slip_states is {slip_states}; the {contact.name} law leaves no choice, leave it "
                "out."
            )
    names = contact.symbols()
    if flag("direction", direction):
        if not contact.sticks:
            raise ParameterError(
                f"direction belongs to the coulomb law, not to {contact.name}; leave it out."
            )
        contact, names = CoulombAlong, (*names, DIRECTION)
    return round_system(unit_disk(), contact, names, physical=False, slip_states=bool(slip_states))


def disk_model(
    law: str | type[Contact], *, pose: bool = False, resistance: Resistances = ()
) -> Model:
    """The disk under a contact law, for a launch; built once for each.

    Parameters
    ----------
    law
        A key of `stability.bodies.contact_laws.MOTION_LAWS`, or the class of a law; for a law that
        sticks, the model is of sliding.
    pose
        Whether y holds φ, ψ and the place of the centre.
    resistance
        Classes of the resistances to rolling and turning.

    Returns
    -------
    Model

    Examples
    --------
    >>> model = disk_model("viscous")
    >>> model.names
    ('theta', 'theta_dot', 'phi_dot', 'omega3', 'slip_x', 'slip_y', 'work')
    >>> list(model.guards)
    ['lift-off', 'flat', 'no-contact']
    """
    every: Any = law_class(law), bool(pose), resistance
    return _disk_model(*every)


@lru_cache(maxsize=64)
def _disk_model(law: type[Contact], pose: bool, resistance: Resistances) -> Model:  # noqa: FBT001
    return round_model(unit_disk(), law, law.symbols(), pose=pose, resistance=resistance)
