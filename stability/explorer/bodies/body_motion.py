"""Launches, modes and the surface of a body of revolution for the page, in angles or fixed axes."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

import casadi as ca

from ...algebra.number_types import Algebra
from ...algebra.program import Program
from ...bodies.contact_laws import LAWS
from ...bodies.model import Model
from ...bodies.round_body.body import Body
from ...bodies.round_body.height.pole_height import height_of_angle, height_of_cosine
from ...bodies.round_body.models.angle_model import round_model
from ...bodies.round_body.models.pole_model import FRONT, PLACE, pole_model
from ...bodies.round_body.pole_equations import SLIP, smooth_at
from ...bodies.thin_disk.disk_model import POSE, POSE_UNIT, placed
from ...systems.family import Family
from ..disk_subjects import FLAT
from ..source.formulas import Values
from ..source.frames import frame_of_angles, frame_of_axis
from ..source.source_text import graph, javascript

States = Callable[[Algebra, Values], list[Any]]
"""Function of the number type and the quantities to the states of a member."""


def through_poles(body: Body) -> bool:
    """Whether a launch moves along fixed axes: the body is smooth at a pole."""
    return smooth_at(body, 1) or smooth_at(body, -1)


def launch_model(body: Body, law: str) -> Model:
    """The model that `simulate` integrates.

    Parameters
    ----------
    body
        The body.
    law
        A key of `stability.bodies.contact_laws.LAWS`.
    """
    kind = LAWS[law]
    make = pole_model if through_poles(body) else round_model
    return make(body, kind, tuple(p.name for p in kind.parameters), pose=True)


def body_motion(body: Body, law: str) -> Mapping[str, Any]:
    """Equations, guards and observables of a launch of a body under a law.

    Parameters
    ----------
    body, law
        As for `launch_model`.

    Returns
    -------
    dict
        Record of the page.
    """
    model = launch_model(body, law)
    y, p, series = model.x, model.p, model.series
    observed = {"energy": series["energy"], "normal force": series["normal_force"]}
    if through_poles(body):
        place = {n: model.names.index(n) for n in (FRONT[0], PLACE[0])}
        front = y[place[FRONT[0]] : place[FRONT[0]] + len(FRONT)]
        centre = y[place[PLACE[0]] : place[PLACE[0]] + len(PLACE)]
        arm = ca.vertcat(series["arm_X"], series["arm_Y"])
        frame = frame_of_axis(y[:3], front, centre, series["potential"], arm)
    else:
        first = model.names.index(POSE[0])
        pose = y[first : first + len(POSE)]
        frame = frame_of_angles(y[0], pose, series["potential"], series["reach"])
    parts = {"rates": model.rhs, "guard": ca.vertcat(*model.guards.values()),
             "observe": ca.vertcat(*observed.values()), "frame": frame}  # fmt: skip
    written = {n: graph(Program(ca.Function(n, [y, p], [value]))) for n, value in parts.items()}
    return {
        **written, "names": model.names, "states": len(model.system.states),
        "guards": list(model.guards), "observed": list(observed), "more": [FLAT],
        "work": model.names.index("work"), "words": dict(model.words),
    }  # fmt: skip


def start_of(body: Body, law: str, states: States, count: int, pole: int) -> str:
    """JavaScript: quantities, tilt → start of a launch, as `launch` gives it.

    Parameters
    ----------
    body, law
        As for `launch_model`.
    states
        States of a member, by angles; of vertical spin its angular velocity alone counts.
    count
        Number of quantities.
    pole
        1 or -1 for vertical spin at θ = 0 or π; 0 for every other family.
    """
    model = launch_model(body, law)

    def start(algebra: Algebra, q: Values, tilt: Values) -> list[Any]:
        if pole:
            upright = 0.0 if pole == 1 else math.pi
            six = [upright + pole * tilt[0], 0.0, 0.0, pole * q[0], 0.0, 0.0]
        else:
            found = states(algebra, q)
            six = [found[0] - tilt[0], *found[1:], *[0.0] * (6 - len(found))]
        if through_poles(body):
            return _along_axes(algebra, six, model)
        return [*six[: len(model.system.states)], *[0.0] * (1 + len(POSE))]

    return javascript([count, 1], start)


def _along_axes(algebra: Algebra, six: list[Any], model: Model) -> list[Any]:
    """States along fixed axes with x̂ along X; the front is 1̂ (`pole_model`)."""
    theta, theta_dot, phi_dot, omega3, *slip = six
    sine, cosine = (algebra.functions[n](theta) for n in ("sin", "cos"))
    spin = omega3 - phi_dot * cosine
    turn = [spin * sine, theta_dot, phi_dot + spin * cosine]
    slides = slip if SLIP[0] in model.system.states else []
    return [sine, 0.0, cosine, *turn, *slides, 0.0, cosine, 0.0, -1.0 * sine, 0.0, 0.0]


def mode_pose(body: Body, family: Family, pole: int) -> dict[str, Any]:
    """How the states of the spectrum move the body: `pose`, `frame` and `still` of a subject.

    Parameters
    ----------
    body, pole
        As for `start_of`.
    family
        The family.
    """
    system = family.system
    x, p = system.x, system.p
    own = ca.vertsplit(p)[: len(body.shape)]
    if pole:
        pose, frame, rates = _pose_of_axis(body, system, own, pole)
    else:
        h = ca.SX(height_of_angle(body.height, x[0], own))  # type: ignore[arg-type]
        pose, seen = ca.SX.sym("pose", len(POSE)), system.observables
        frame = frame_of_angles(x[0], pose, h, ca.jacobian(h, x[0]))
        rates = placed(x, seen["slip"][0] + x[1] * h, seen["slip"][1] - seen["rim_speed"], pose)
    inputs = [x, p, pose]
    return {
        "pose": graph(Program(ca.Function("pose", inputs, [rates]))),
        "frame": graph(Program(ca.Function("frame", inputs, [frame]))),
        "still": (1.0, 0.0, 0.0, 0.0, 0.0) if pole else (0.0,) * len(POSE),
    }


def _pose_of_axis(
    body: Body, system: Any, own: list[ca.SX], pole: int
) -> tuple[ca.SX, ca.SX, ca.SX]:
    """Pose, place and rates of the pose in the chart around a pole."""
    x, pose, c = system.x, ca.SX.sym("pose", len(FRONT) + len(PLACE)), ca.SX.sym("c")
    axis = ca.vertcat(x[0], x[1], pole * ca.sqrt(1 - ca.sumsqr(x[:2])))
    turn, f = x[2:5], height_of_cosine(body.height, c, own)  # type: ignore[arg-type]
    both = ca.densify(ca.vertcat(f, ca.jacobian(f, c)))
    h, slope = ca.vertsplit(ca.substitute(both, c, axis[2]))
    arm = -slope * axis - (h - axis[2] * slope) * ca.SX([0, 0, 1])
    along = system.observables["slip"] - ca.cross(turn, arm)[:2]
    rates = ca.vertcat(ca.cross(turn, pose[:3]), along / POSE_UNIT)
    return pose, frame_of_axis(axis, pose[:3], pose[3:], h, arm), rates


def meridian(body: Body, family: Family) -> dict[str, Any]:
    """The surface of a body: JavaScript of θ and the parameters → r and place along the axis.

    Parameters
    ----------
    body, family
        The body and one of its families.

    Source: docs/explanation/bodies.md, r = h sinθ + h' cosθ; the film of `animate` draws the same.
    """
    theta, p = ca.SX.sym("theta"), family.system.p
    h = ca.SX(height_of_angle(body.height, theta, ca.vertsplit(p)[: len(body.shape)]))  # type: ignore[arg-type]
    slope, s, c = ca.jacobian(h, theta), ca.sin(theta), ca.cos(theta)
    point = ca.Function("point", [theta, p], [ca.vertcat(h * s + slope * c, slope * s - h * c)])
    low, high = body.between
    return {"point": graph(Program(point)), "low": low, "high": high}
