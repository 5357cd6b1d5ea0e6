"""The model of a body that is smooth at a pole, for a launch: fixed axes, reported as angles.

A motion runs along fixed axes, where nothing happens at a pole.  It reports the angles' states too:
near a pole θ̇, φ̇ and the slips depend on a heading that turns fast, and their errors grow like one
over sin θ; where the axis is exactly vertical, φ̇ is 0 and x̂ such that θ̇ is the rate of tilting.
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import lru_cache, partial
from typing import Any

import casadi as ca
import numpy as np

from ....base.types import Floats
from ....systems.system import System
from ...contact_laws import Contact, Rough
from ...model import (
    LIFT_OFF,
    NO_CONTACT,
    POSE,
    POSE_UNIT,
    WORDS,
    WORK,
    Chart,
    Held,
    Model,
)
from ...newton_euler import STATES
from ..equations import Resistances
from ..height.pole_height import height_of_cosine
from ..pole_equations import SLIP, held_at_pole, pole_system, rough_at_pole, smooth_at
from ..shape import RoundShape
from ..si_law import Shape, shape_of
from .angle_model import quantities_with, series_of, words_of_end

FRONT = ("front_X", "front_Y", "front_Z")
"""Unit vector of the body across its axis, from which ψ is read."""
PLACE = ("centre_X", "centre_Y")
"""Horizontal place of the centre over `POSE_UNIT`."""


def pole_model(
    body: RoundShape,
    law: type[Contact],
    parameters: tuple[str, ...],
    *,
    pose: bool,
    resistance: Resistances = (),
) -> Model:
    """A body that is smooth at a pole, dimensionless; built once for each.

    Parameters
    ----------
    body, law, parameters, pose, resistance
        As for `stability.bodies.round_body.models.angle_model.round_model`.

    Returns
    -------
    Model

    Raises
    ------
    StabilityError
        If the body is smooth at no pole, or the law has no meaning there.

    Examples
    --------
    >>> from stability.bodies.contact_laws import Viscous
    >>> from stability.bodies.round_body.shapes.named import EccentricSphere
    >>> model = pole_model(EccentricSphere(0.1), Viscous, ("mu",), pose=False)
    >>> model.names[:3], list(model.guards)
    (('axis_X', 'axis_Y', 'axis_Z'), ['lift-off', 'no-contact'])
    """
    system = pole_system(
        body, law, parameters, physical=False, slip_states=True, resistance=resistance
    )
    smooth = smooth_at(body, 1), smooth_at(body, -1)
    return _pole_model(system, shape_of(body), smooth, law, parameters, bool(pose), resistance)  # type: ignore[arg-type]  # a class is hashable


@lru_cache(maxsize=32)
def _pole_model(  # noqa: PLR0913
    system: System,
    shape: Shape,
    smooth: tuple[bool, bool],
    law: type[Contact],
    parameters: tuple[str, ...],
    pose: bool,
    resistance: Resistances,  # noqa: FBT001
) -> Model:
    name, height, _, shape_names, between = shape
    x, seen, slips = system.x, system.observables, SLIP[0] in system.states
    axis, turn, c = x[:3], x[3:6], ca.SX.sym("c")
    f = height_of_cosine(height, c, ca.vertsplit(system.p)[: len(shape_names)])
    both = ca.vertcat(f, ca.jacobian(f, c))
    h, slope = ca.vertsplit(ca.substitute(ca.densify(both), c, axis[2]))
    arm = -slope * axis - (h - axis[2] * slope) * ca.SX([0, 0, 1])
    columns, names = [x, ca.SX.sym(WORK)], [*system.states, WORK]
    rates = [system.rhs, seen["power"]]
    normal = seen["normal_force"]
    series = series_of(seen, h) | dict(zip(AXES, ca.vertsplit(axis), strict=True))
    if pose:
        extra = ca.SX.sym("pose", len(FRONT) + len(PLACE))
        columns.append(extra)
        along = seen["slip"] - ca.cross(turn, arm)[:2]
        rates += [ca.cross(turn, extra[:3]), along / POSE_UNIT]
        names += [*FRONT, *PLACE]
        series |= {"arm_X": arm[0], "arm_Y": arm[1]}
    guards, words = _end_guards(axis[2], between, smooth)
    guards = {LIFT_OFF: normal * seen["determinant"]} | guards
    if slips and ca.depends_on(seen["determinant"], x[6:]):
        guards[NO_CONTACT] = seen["determinant"]
    held = None
    if law.relaxes:
        held = Held(
            partial(_rough_model, shape, smooth, resistance),
            partial(held_at_pole, shape, resistance),
        )
    return Model(
        system,
        STATES,
        ca.vertcat(*columns),
        ca.vertcat(system.p, ca.SX.sym("flat")),
        ca.vertcat(*rates),
        tuple(names),
        guards,
        WORDS | words,
        series,
        quantities_with(law, shape_names, AXES),
        parameters[0] if law.relaxes else "",
        turning=(3, 4, 5),
        sliding=(6, 7) if slips else (),
        title=f"motion of {name}, {law.name} contact",
        source=system.qualified(
            "equations of a convex body of revolution along fixed axes "
            "(docs/explanation/bodies.md), integrated"
        ),
        chart=Chart(
            partial(_packed, slips, len(names), pose),
            partial(_angles, slips),
            partial(_along, len(system.states)),
        ),
        held=held,
    )


@lru_cache(maxsize=32)
def _rough_model(shape: Shape, smooth: tuple[bool, bool], resistance: Resistances) -> Model:
    kind: Any = Rough
    system = rough_at_pole(shape, resistance)
    return replace(_pole_model(system, shape, smooth, kind, (), False, resistance), chart=None)


AXES = ("axis_x", "axis_y", "axis_z")
"""Names of the axis's components in a motion's dataset."""


def _end_guards(
    cosine: ca.SX, between: tuple[float, float], smooth: tuple[bool, bool]
) -> tuple[dict[str, ca.SX], dict[str, str]]:
    """Guards of the ends of θ that are not smooth poles, and their words."""
    guards, words = {}, {}
    for sign, end, through in zip((1, -1), between, smooth, strict=True):
        if not through:
            name, said = words_of_end(end, lower=sign == 1)
            guards[name] = sign * (math.cos(end) - cosine)
            words[name] = said
    return guards, words


# --- between the charts ---


def _packed(slips: bool, width: int, pose: bool, states: Floats) -> Floats:  # noqa: FBT001
    """The entries of y for the six states, with x̂ along X."""
    theta, theta_dot, phi_dot, omega3, *slip = np.moveaxis(states, -1, 0)
    sine, cosine = np.sin(theta), np.cos(theta)
    y = np.zeros((*states.shape[:-1], width))
    spin = omega3 - phi_dot * cosine
    for i, value in (
        (0, sine),
        (2, cosine),
        (3, spin * sine),
        (4, theta_dot),
        (5, phi_dot + spin * cosine),
    ):
        y[..., i] = value
    if slips:
        y[..., 6], y[..., 7] = slip
    if pose:
        y[..., -5], y[..., -3] = cosine, -sine  # 1̂
    return y


def _heading(y: Floats) -> tuple[Floats, Floats, Floats]:
    """The direction x̂ along X and Y, and sin θ."""
    across, along = y[..., 0], y[..., 1]
    sine = np.hypot(across, along)
    vertical = sine == 0
    if vertical.any():  # there ŷ is along the horizontal angular velocity, or along Y
        tilting = np.hypot(y[..., 3], y[..., 4])
        still = vertical & (tilting == 0)
        across = np.where(vertical, np.where(still, 1.0, y[..., 4]), across)
        along = np.where(vertical, np.where(still, 0.0, -y[..., 3]), along)
    size = np.hypot(across, along)
    return across / size, along / size, sine


def _angles(slips: bool, y: Floats) -> Floats:  # noqa: FBT001
    """The six states of entries of y."""
    cosine, sine_of, sine = _heading(y)
    up, turn = y[..., 2], np.moveaxis(y[..., 3:6], -1, 0)
    over = turn[0] * cosine + turn[1] * sine_of  # along x̂
    with np.errstate(all="ignore"):
        phi_dot = np.where(sine > 0, turn[2] - up * over / sine, 0.0)
    six = np.zeros((*y.shape[:-1], 6))
    six[..., 0] = np.arctan2(sine, up)
    six[..., 1] = turn[1] * cosine - turn[0] * sine_of
    six[..., 2] = phi_dot
    six[..., 3] = over * sine + turn[2] * up
    if slips:
        six[..., 4] = y[..., 6] * cosine + y[..., 7] * sine_of
        six[..., 5] = y[..., 7] * cosine - y[..., 6] * sine_of
    return six


def _along(count: int, y: Floats, series: dict[str, Floats]) -> dict[str, Floats]:
    """Series along x̂ and ŷ, and the pose, from those along X and Y."""
    cosine, sine_of, sine = _heading(y)
    east, north = series["force_x"], series["force_y"]
    series |= {
        "force_x": east * cosine + north * sine_of,
        "force_y": north * cosine - east * sine_of,
    }
    if y.shape[-1] == count + 1:
        return series
    front, place = y[..., count + 1 : count + 4], POSE_UNIT * y[..., count + 4 :]
    across = front[..., 1] * cosine - front[..., 0] * sine_of  # along ŷ
    ahead = (front[..., 0] * cosine + front[..., 1] * sine_of) * y[..., 2] - front[..., 2] * sine
    values = np.arctan2(sine_of, cosine), np.arctan2(across, ahead), place[..., 0], place[..., 1]
    series |= dict(zip(POSE, values, strict=True))
    series["contact_x"] = series["centre_x"] + series.pop("arm_X")
    series["contact_y"] = series["centre_y"] + series.pop("arm_Y")
    return series
