"""The model of the disk for a launch: its motion with work and pose, and the guards of a run."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache, partial
from typing import Any

import casadi as ca
import numpy as np

from ...algebra.program import Program
from ...base.types import Floats
from ...systems.system import System
from ..contact import Contact
from ..contact_laws import Creep, Rough, law_class
from ..creep import CREEPS
from ..explicit import Surface, explicit
from ..held_motion import SLIP, held_in_angles
from ..model import WORK, Dry, Held, Model
from .disk_equations import STATES, DiskBody, disk_system
from .disk_momenta import momenta_model
from .disk_quantities import QUANTITIES

POSE = ("phi", "psi", "centre_x", "centre_y")
"""Precession angle, relative spin angle, horizontal place of the centre; x̂ = (cos φ, sin φ)."""
POSE_UNIT = 1024.0
"""Unit of the pose in the integration.  The pose grows without bound, and without this unit it
would loosen a tolerance that is relative to the largest entry of the state."""
LIFT_OFF, FLAT, NO_CONTACT, CONE = "lift-off", "flat", "no-contact", "slip"
CREEP_ENDS = "creep ends"
"""Names of the guards."""
WORDS = {
    LIFT_OFF: "normal force times D",
    FLAT: "sine of theta less that of flat",
    NO_CONTACT: "D",
    CREEP_ENDS: CREEPS,
}
"""Each guard in words."""


def moving_system(law: str | type[Contact]) -> System:
    """The disk with every state of a motion, so with the slip of the smooth disk too.

    Parameters
    ----------
    law
        A key of `stability.bodies.contact_laws.MOTION_LAWS`, or the class of a law.

    Returns
    -------
    System

    Examples
    --------
    >>> len(moving_system("smooth").states), len(moving_system("rough").states)
    (6, 4)
    """
    contact = law_class(law)
    return disk_system(contact, slip_states=None if contact.holds else True)


def disk_model(law: str | type[Contact], *, pose: bool = False, sticking: bool = False) -> Model:
    """The disk under a contact law; built once for each.

    Parameters
    ----------
    law
        A key of `stability.bodies.contact_laws.MOTION_LAWS`, or the class of a law; for a law that
        sticks, the model is of sliding.
    pose
        Whether y holds φ, ψ and the place of the centre.
    sticking
        Whether the model is of sticking under `coulomb`: the rough disk with a guard that keeps the
        force inside the friction cone.

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
    return _disk_model(law_class(law), bool(pose), bool(sticking))  # type: ignore[arg-type]  # a class is hashable


@lru_cache(maxsize=32)
def _disk_model(law: type[Contact], pose: bool, sticking: bool) -> Model:  # noqa: FBT001
    if sticking:
        system = disk_system("rough")
        mu = ca.SX.sym("mu")
        parameters = ca.vertcat(system.p, mu)
    else:
        system = moving_system(law)
        mu, parameters = ca.SX(0), system.p
    x = system.x
    seen = system.observables
    columns, names = [x, ca.SX.sym(WORK)], [*system.states, WORK]
    normal, determinant = seen["normal_force"], seen["determinant"]
    rates, pressing = [system.rhs, seen["power"]], normal * determinant
    if len(system.states) == len(STATES):
        rates, pressing, determinant = _solved(system, law)
    if pose:
        extra = ca.SX.sym("pose", len(POSE))
        columns.append(extra)
        rates.append(pose_rates(x, seen["slip"], extra))
        names += POSE
    flat = ca.SX.sym("flat")
    # gn D has the sign of gn, and stays finite where D vanishes
    guards = {LIFT_OFF: pressing, FLAT: ca.sin(x[0]) - flat}
    if sticking:
        guards[CONE] = (mu * normal) ** 2 - ca.sumsqr(seen["contact_force"])
    if not sticking and ca.depends_on(determinant, x[4:]):
        # viscous friction pushes D away from zero while gn D is positive, but both may reach zero
        # together (stability/integrators/painleve.py)
        guards[NO_CONTACT] = determinant
    friction = [system.parameters.index("mu")] if "mu" in system.parameters else []
    series = {
        "energy": seen["energy"],
        "potential": ca.sin(system.x[0]),
        "normal_force": normal,
        "force_x": seen["contact_force"][0],
        "force_y": seen["contact_force"][1],
        "power": seen["power"],
    }
    if pose:
        series["reach"] = ca.cos(x[0])
    if issubclass(law, Creep):
        [guards[CREEP_ENDS]] = (c.value for c in system.conditions if c.sentence == CREEPS)
        series |= {"slip_x": seen["slip"][0], "slip_y": seen["slip"][1]}
    return Model(
        system,
        STATES,
        ca.vertcat(*columns),
        ca.vertcat(parameters, flat),
        ca.vertcat(*rates),
        tuple(names),
        guards,
        WORDS,
        series,
        QUANTITIES,
        law.symbols()[0] if law.relaxes and not sticking else "",
        turning=(1, 2, 3),
        sliding=() if law.sticks or len(system.states) < 6 else (4, 5),
        parking=partial(_park, friction),
        sound=_stands,
        short=_short(law, sticking or pose),
        dry=_dry(law, pose) if law.sticks and not sticking else None,
        held=Held(partial(disk_model, Rough), held_disk) if law.relaxes else None,
        title=f"motion of a disk, {law.name} contact",
        source="equations of Przybylska & Rauch-Wojciechowski, Regul. Chaotic Dyn. 21 (2016) "
        "204-231, integrated",
    )


def _solved(system: System, law: type[Contact]) -> tuple[list[ca.SX], ca.SX, ca.SX]:
    """Rates of the states and the dissipated power, N D and D, in few operations."""
    k, *numbers = ca.vertsplit(system.p)
    mu: Any = numbers[0] if len(numbers) == 1 else tuple(numbers)
    x, stated = system.x, law.__new__(law)
    s, c = ca.sin(x[0]), ca.cos(x[0])
    found = explicit(x, Surface(s, c, -s, 1, 0, k, 2), lambda v, n: stated.force(v, n, mu))
    power = ca.SX(stated.power([x[4], x[5]], found.normal, mu))
    return [found.rates, power], found.pressing, found.determinant


@lru_cache(maxsize=1)
def held_disk() -> tuple[Program, Program]:
    """The disk held to a slip, as programs of (x, k, slip, rate of slip)."""
    x, k = ca.SX.sym("x", 4), ca.SX.sym("k")
    return held_in_angles(DiskBody(x, k, Rough, 0, False, ca.vertsplit(SLIP)), k)


def _dry(law: type[Contact], pose: bool) -> Dry:  # noqa: FBT001
    """The disk at rest."""
    return Dry(
        disk_system(law, direction=True),
        disk_system("rough"),
        partial(disk_model, law, pose=pose, sticking=True),
        _unique,
    )


def _unique(p: Floats) -> bool:
    """Whether mu < 2√(k(k+1)), where docs/explanation/dry-friction.md proves it."""
    k, mu = p
    return bool(mu < 2 * math.sqrt(k * (k + 1)))


def _short(law: type[Contact], other: bool) -> Callable[[Model], Model] | None:  # noqa: FBT001
    """The disk in momenta, where the slip is a state and its force has a value at rest."""
    return None if other or law.sticks or law.holds else partial(momenta_model, law)


def _park(friction: list[int], states: Any, parameters: Any, lane: int) -> None:
    """Put a lane on a stable upright spin without friction, which needs few steps."""
    states[:, lane] = 0.0
    states[0, lane] = math.pi / 2
    states[2, lane] = 2.0 / math.sqrt(parameters[0, lane])
    for index in friction:
        parameters[index, lane] = 0.0


def _stands(states: Any) -> bool:
    return bool((np.sin(states[:, 0]) > 0).all())


def pose_rates(x: ca.SX, slip: ca.SX, pose: ca.SX) -> ca.SX:
    """The rates of φ, ψ and the place of the centre, from the slip; ṡ = vA − ω×a."""
    return placed(x, slip[0] + x[1] * ca.sin(x[0]), slip[1] - x[3], pose)


def placed(x: ca.SX, along_x: ca.SX, along_y: ca.SX, pose: ca.SX) -> ca.SX:
    """φ̇, ψ̇ = ω₃ − φ̇ cosθ, and the horizontal velocity of the centre turned by φ."""
    theta, phi_dot, omega3 = x[0], x[2], x[3]
    heading = POSE_UNIT * pose[0]
    cosine, sine = ca.cos(heading), ca.sin(heading)
    rates = ca.vertcat(
        phi_dot,
        omega3 - phi_dot * ca.cos(theta),
        cosine * along_x - sine * along_y,
        sine * along_x + cosine * along_y,
    )
    return rates / POSE_UNIT
