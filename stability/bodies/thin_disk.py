"""The thin disk: the body of height h = sinθ, whose rim is an edge.

Everything is dimensionless (m = R = g = 1).
Source: Przybylska & Rauch-Wojciechowski 2016, Section 2.
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from typing import Any

from ..base.checks import flag, known
from ..base.errors import NameUnknownError, ParameterError, listed
from ..systems.family import Family
from ..systems.system import System
from .contact_laws import DIRECTION, LAWS, Contact, CoulombAlong, Smooth, law_class
from .disk_polynomials import stored
from .families import FAMILIES, SteadyFamily, families_of_disk, families_under
from .model import Model
from .round_body.equations import Resistances, round_system
from .round_body.families import round_family
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
    contact = law_class(type(law) if isinstance(law, Contact) else law)
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


def disk_family(name: str, law: str | Contact | type[Contact] | None = None) -> Family:
    """One of the disk's families under a contact law; dimensionless, built once.

    In each family the rate of theta_dot must vanish.  This equation is solved for phi_dot (rolling,
    tumbling) or omega3 (spinning, circling, precession).  Rolling and spinning satisfy it
    identically.

    Parameters
    ----------
    name
        A key of `FAMILIES`.
    law
        A contact law, its name or its class; its numbers stay parameters of the family.

    Returns
    -------
    Family
        The family, as `spectrum` and the others take it.

    Raises
    ------
    NameUnknownError, ParameterError
        If there is no such family under this law, or the law is missing.

    Source: Przybylska & Rauch-Wojciechowski 2016, Section 2; notebooks/theorems_disk.py proves
    that no law of friction has further steady motions.

    Examples
    --------
    >>> import stability as st
    >>> import math
    >>> st.disk_family("tumbling", "viscous").member([math.pi / 6], [0.5, 1.0]).round(12)[2]
    np.float64(2.0)
    """
    record = FAMILIES[known("family", name, families_of_disk())]
    law = type(law) if isinstance(law, Contact) else law
    if law is not None and not isinstance(law, type):
        known("contact", law, LAWS)
    contact = law_class(law, motion=False)
    word = contact.name
    if record.law and (record.law != word or not stored(contact)):
        own = families_under(word if stored(contact) else "")
        raise NameUnknownError(
            f"{name} is a family of the {record.law} disk; steady motions under the {word} law are "
            f"{listed([f.name for f in own])}."
        )
    return _disk_family(record, contact)  # type: ignore[arg-type]  # a class is hashable


@lru_cache(maxsize=32)
def _disk_family(record: SteadyFamily, law: type[Contact]) -> Family:
    return replace(
        round_family(unit_disk(), record.name, law, law.symbols(), physical=False),
        conservative=law.conservative,
        integrals=law.conservative and stored(law),
        drifts=record.drifts and stored(law) and bool(law.parameters),
    )


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
