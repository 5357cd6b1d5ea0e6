"""The model of a body of revolution for a launch, in the disk's angles."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache

import casadi as ca
import numpy as np

from ...base.quantities import Kind, Quantity
from ...systems.system import System
from ..contact import Contact
from ..model import WORK, Model
from ..newton_euler import STATES
from ..thin_disk.disk_model import (
    FLAT,
    LIFT_OFF,
    NO_CONTACT,
    POSE,
    WORDS,
    placed,
)
from ..thin_disk.disk_quantities import disk_quantities
from .body import Body
from .equations import round_system
from .expression import Expression

LOWEST, HIGHEST = "lower end of theta", "upper end of theta"
"""Names of the guards of the ends of a height, other than those at which the body lies flat."""
ENDS = {
    LOWEST: "theta has reached {end:.6g}, where the height of the body ends{why}",
    HIGHEST: "theta has reached {end:.6g}, where the height of the body ends{why}",
}
"""Each of these guards in words."""
POLE = ": the axis is vertical, where the angles have no meaning"
EDGE = ": the body may change there to another rim or face"
EVEN = 1e-12
"""Largest difference of heights on both sides of a pole that counts as none."""


def round_model(body: Body, law: type[Contact], given: tuple[str, ...], *, pose: bool) -> Model:
    """A body under a contact law, dimensionless; built once for each.

    Parameters
    ----------
    body
        The body; of its numbers only the names matter.
    law
        Class of the law.
    given
        Names of the law's parameters, in the order of `round_system`.
    pose
        Whether y holds φ, ψ and the place of the centre.

    Returns
    -------
    Model

    Raises
    ------
    ParameterError
        If the law is made for the disk alone.

    Examples
    --------
    >>> from stability.bodies.contact_laws import Viscous
    >>> from stability.bodies.round_body.named import ThickDisk
    >>> list(round_model(ThickDisk(0.1), Viscous, ("mu",), pose=False).guards)
    ['lift-off', 'flat', 'upper end of theta', 'no-contact']
    """
    system = round_system(body, law, given, physical=False, slip_states=True)
    return _round_model(
        system, body.name, body.height, tuple(body.shape), body.between, smooth_poles(body),
        law, given, bool(pose),  # type: ignore[arg-type]  # a class is hashable
    )  # fmt: skip


def smooth_poles(body: Body) -> tuple[bool, bool]:
    """Whether the body's surface is smooth where its axis is vertical, at θ = 0 and at θ = π.

    There the height is an even function of the angle from the pole, and the body does not lie flat.

    Examples
    --------
    >>> from stability.bodies.round_body.named import EccentricSphere, ThickDisk
    >>> smooth_poles(EccentricSphere(0.1)), smooth_poles(ThickDisk(0.1))
    ((True, True), (False, False))
    """
    angles = np.linspace(0.05, 0.9, 18).reshape(-1, *[1] * _dimensions(body))
    found = []
    for pole, reached in ((0.0, body.between[0] == 0), (math.pi, body.between[1] == math.pi)):
        with np.errstate(all="ignore"):
            one, other = body.height_at(pole + angles), body.height_at(pole - angles)
        found.append(bool(reached and (np.abs(one - other) <= EVEN * np.abs(one)).all()))
    return found[0], found[1]


def _dimensions(body: Body) -> int:
    return max((np.ndim(v) for v in body.shape.values()), default=0)


@lru_cache(maxsize=32)
def _round_model(  # noqa: PLR0913
    system: System, name: str, height: Expression, shape: tuple[str, ...],
    between: tuple[float, float], smooth: tuple[bool, bool], law: type[Contact],
    given: tuple[str, ...], pose: bool,  # noqa: FBT001
) -> Model:  # fmt: skip
    x, seen, flat = system.x, system.observables, ca.SX.sym("flat")
    h = ca.SX(height(x[0], *(system.p[i] for i in range(len(shape)))))
    slope = ca.jacobian(h, x[0])
    columns, names = [x, ca.SX.sym(WORK)], [*system.states, WORK]
    rates = [system.rhs, seen["power"]]
    normal = seen["normal_force"]
    series = {
        "energy": seen["energy"], "potential": h, "normal_force": normal,
        "force_x": seen["contact_force"][0], "force_y": seen["contact_force"][1],
        "power": seen["power"],
    }  # fmt: skip
    if pose:
        extra = ca.SX.sym("pose", len(POSE))
        columns.append(extra)
        velocity = seen["slip"][0] + x[1] * h, seen["slip"][1] - seen["rim_speed"]
        rates.append(placed(x, *velocity, extra))
        names += POSE
        series["reach"] = slope
    guards, words = _ends(x[0], flat, between, smooth)
    guards = {LIFT_OFF: normal * seen["determinant"]} | guards
    if ca.depends_on(seen["determinant"], x[4:]):
        guards[NO_CONTACT] = seen["determinant"]
    return Model(
        system, STATES, ca.vertcat(*columns), ca.vertcat(system.p, flat), ca.vertcat(*rates),
        tuple(names), guards, WORDS | words, series, _quantities(law, shape),
        given[0] if law.relaxes else "",
        turning=(1, 2, 3), sliding=(4, 5) if len(system.states) == 6 else (),
        title=f"motion of {name}, {law.name} contact",
        source="equations of a convex body of revolution (docs/bodies.md), integrated",
    )  # fmt: skip


def _ends(
    theta: ca.SX, flat: ca.SX, between: tuple[float, float], smooth: tuple[bool, bool]
) -> tuple[dict[str, ca.SX], dict[str, str]]:
    """Guards of the ends of θ, and their words: the body falls flat on a face at a pole."""
    low, high = between
    lies = (low == 0 and not smooth[0], high == math.pi and not smooth[1])
    guards = {FLAT: ca.sin(theta) - flat} if any(lies) else {}
    words = {}
    room = {LOWEST: (theta - low, low), HIGHEST: (high - theta, high)}
    for (name, (value, end)), flat_there in zip(room.items(), lies, strict=True):
        if not flat_there:
            pole = end in (0.0, math.pi)
            guards[name] = value - flat if pole else value
            words[name] = ENDS[name].format(end=end, why=POLE if pole else EDGE)
    if any(lies) and not all(lies):  # sin θ vanishes at the other pole too, which is not flat
        guards[FLAT] = (theta if lies[0] else math.pi - theta) - flat
    return guards, words


def _quantities(law: type[Contact], shape: tuple[str, ...]) -> Mapping[str, Quantity]:
    """Those of the disk, with the body's own length and shape."""
    known = dict(disk_quantities(law))
    known["slip_x"] = replace(known["slip_x"], long_name="slip along x̂, away from the axis")
    known["slip_y"] = replace(known["slip_y"], long_name="slip along ŷ, across the axis")
    known["length"] = Quantity("length", "", "length of the body", Kind.LENGTH)
    own = {n: Quantity(n, n, n, Kind.NUMBER) for n in (*shape, "axial", "transverse")}
    return own | known
