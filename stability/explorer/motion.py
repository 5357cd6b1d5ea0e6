"""Launches, the steady motion and modes of a body in space, and its surface, as JavaScript."""

from __future__ import annotations

import math
from typing import Any

import casadi as ca

from ..algebra.number_types import Algebra
from ..algebra.program import Program
from ..bodies.contact_laws import LAWS
from ..bodies.model import POSE, POSE_UNIT, PROBE, Model, placed
from ..bodies.round_body.height.pole_height import height_of_angle, height_of_cosine
from ..bodies.round_body.models.angle_model import round_model
from ..bodies.round_body.models.pole_model import FRONT, PLACE, pole_model
from ..bodies.round_body.pole_equations import SLIP, smooth_at
from ..bodies.round_body.shape import RoundShape
from ..systems.family import Family
from .formulas import PageFormulas, Values
from .source import graph, javascript

FLAT = math.sin(1e-6)
"""Sine of the angle that counts as flat, as in `simulate`."""
SERIES = 2
"""Observables of a user's system whose curves are drawn; one named energy is the first."""
CURVES = {"energy": "energy", "normal force": "normal_force"}
"""Observables of a body whose curves are drawn, with their names in a `Model`."""


def through_poles(body: RoundShape) -> bool:
    """Whether a launch moves along fixed axes: the body is smooth at a pole."""
    return smooth_at(body, 1) or smooth_at(body, -1)


def launch_model(body: RoundShape, law: str) -> Model:
    """The model of a body under a law that `simulate` integrates."""
    kind = LAWS[law]
    make = pole_model if through_poles(body) else round_model
    return make(body, kind, kind.symbols(), pose=True)


def motion_of(model: Model, *, solid: bool) -> dict[str, Any]:
    """Equations, guards, observables and, of a body, its place: a launch as the page runs it."""
    kept = len(model.names) - (PROBE in model.names)
    y, p, series = model.x[:kept], model.p, model.series
    if solid:
        observed, words = {n: series[name] for n, name in CURVES.items()}, dict(model.words)
    else:
        energy_first = sorted(series.items(), key=lambda s: s[0] != "energy")
        observed = dict(energy_first[:SERIES])
        words = dict.fromkeys(model.guards, "a condition of the system reaches zero")
    guards = model.guards or {"none": ca.SX(1)}
    parts = {
        "rates": model.rhs[:kept],
        "guard": ca.vertcat(*guards.values()),
        "observe": ca.vertcat(*observed.values(), ca.SX(0, 1)),
    }
    if solid:
        parts["frame"] = _frame(model)
    return {
        **{n: graph(Program(ca.Function(n, [y, p], [value]))) for n, value in parts.items()},
        "names": model.names[:kept],
        "states": len(model.system.states),
        "guards": list(guards),
        "observed": list(observed),
        "more": [FLAT] * (p.numel() - model.system.p.numel()),
        "words": words,
    }


def _frame(model: Model) -> ca.SX:
    """The place of a body along its launch."""
    y, names, series = model.x, model.names, model.series
    if FRONT[0] in names:
        front, centre = (
            y[names.index(part[0]) : names.index(part[0]) + len(part)] for part in (FRONT, PLACE)
        )
        arm = ca.vertcat(series["arm_X"], series["arm_Y"])
        return _frame_of_axis(y[:3], front, centre, series["potential"], arm)
    first = names.index(POSE[0])
    return _frame_of_angles(
        y[0], y[first : first + len(POSE)], series["potential"], series["reach"]
    )


def body_of(body: RoundShape, family: Family, pole: int = 0) -> dict[str, Any]:
    """How the states of the spectrum move the body: `pose`, `frame` and `still` of a subject.

    The pole is 1 or -1 for vertical spin at θ = 0 or π, and 0 for every other family.
    """
    x, p = family.system.x, family.system.p
    numbers = ca.vertsplit(p)[: len(body.shape)]
    pose = ca.SX.sym("pose", len(FRONT) + len(PLACE) if pole else len(POSE))
    if pole:
        frame, rates = _along_axis(body, family, numbers, pose, pole)
    else:
        frame, rates = _by_angles(body, family, numbers, pose)
    inputs = [x, p, pose]
    return {
        "pose": graph(Program(ca.Function("pose", inputs, [rates]))),
        "frame": graph(Program(ca.Function("frame", inputs, [frame]))),
        "still": (1.0, 0.0, 0.0, 0.0, 0.0) if pole else (0.0,) * len(POSE),
    }


def _by_angles(
    body: RoundShape, family: Family, numbers: list[ca.SX], pose: ca.SX
) -> tuple[ca.SX, ca.SX]:
    """Place and rates of the pose in the disk's angles; ṡ = vA − ω×a."""
    x, slip = family.system.x, family.system.observables["slip"]
    theta, theta_dot, phi_dot, omega3 = (x[i] for i in range(4))
    h = ca.SX(height_of_angle(body.height, theta, numbers))  # type: ignore[arg-type]
    slope, sine, cosine = ca.jacobian(h, theta), ca.sin(theta), ca.cos(theta)
    relative = omega3 - phi_dot * cosine
    rim_speed = (phi_dot + relative * cosine) * slope + relative * sine * h
    rates = placed(x, slip[0] + theta_dot * h, slip[1] - rim_speed, pose)
    return _frame_of_angles(theta, pose, h, slope), rates


def _along_axis(
    body: RoundShape, family: Family, numbers: list[ca.SX], pose: ca.SX, pole: int
) -> tuple[ca.SX, ca.SX]:
    """Place and rates of the pose in the chart around a pole."""
    x, c = family.system.x, ca.SX.sym("c")
    axis = ca.vertcat(x[0], x[1], pole * ca.sqrt(1 - ca.sumsqr(x[:2])))
    turn, f = x[2:5], height_of_cosine(body.height, c, numbers)  # type: ignore[arg-type]
    both = ca.densify(ca.vertcat(f, ca.jacobian(f, c)))
    h, slope = ca.vertsplit(ca.substitute(both, c, axis[2]))
    arm = -slope * axis - (h - axis[2] * slope) * ca.SX([0, 0, 1])
    along = family.system.observables["slip"] - ca.cross(turn, arm)[:2]
    rates = ca.vertcat(ca.cross(turn, pose[:3]), along / POSE_UNIT)
    return _frame_of_axis(axis, pose[:3], pose[3:], h, arm), rates


def meridian(body: RoundShape, family: Family) -> dict[str, Any]:
    """The surface of a body: JavaScript of θ and the parameters → r and place along the axis.

    Source: docs/explanation/bodies.md, r = h sinθ + h' cosθ; the film of `animate` draws the same.
    """
    theta, p = ca.SX.sym("theta"), family.system.p
    h = ca.SX(height_of_angle(body.height, theta, ca.vertsplit(p)[: len(body.shape)]))  # type: ignore[arg-type]
    slope, s, c = ca.jacobian(h, theta), ca.sin(theta), ca.cos(theta)
    point = ca.Function("point", [theta, p], [ca.vertcat(h * s + slope * c, slope * s - h * c)])
    low, high = body.between
    return {"point": graph(Program(point)), "low": low, "high": high}


def start_along_axes(family: Family, formulas: PageFormulas, model: Model, pole: int) -> str:
    """JavaScript: quantities, tilt → start of a launch along fixed axes, as `launch` gives it."""

    def start(algebra: Algebra, q: Values, tilt: Values) -> list[Any]:
        if pole:  # of vertical spin the angular velocity alone counts
            upright = 0.0 if pole == 1 else math.pi
            six = [upright + pole * tilt[0], 0.0, 0.0, pole * q[0], 0.0, 0.0]
        else:
            states = formulas.states(family, algebra, q)
            six = [states[0] - tilt[0], *states[1:], *[0.0] * (6 - len(states))]
        theta, theta_dot, phi_dot, omega3, *slip = six
        sine, cosine = (algebra.functions[n](theta) for n in ("sin", "cos"))
        spin = omega3 - phi_dot * cosine
        turn = [spin * sine, theta_dot, phi_dot + spin * cosine]
        slides = slip if SLIP[0] in model.system.states else []
        # x̂ is along X; the front is 1̂ (`pole_model`)
        return [sine, 0.0, cosine, *turn, *slides, 0.0, cosine, 0.0, -1.0 * sine, 0.0, 0.0]

    return javascript([len(formulas.names), 1], start)


def _frame_of_angles(theta: Any, pose: ca.SX, height: Any, slope: Any) -> ca.SX:
    """The place of a body from its angles; that of the centre has the unit `POSE_UNIT`.

    Source: docs/explanation/bodies.md, frames and contact point a = h' x̂ - h ẑ.

    Examples
    --------
    >>> theta = ca.SX.sym("theta")
    >>> found = _frame_of_angles(theta, ca.SX.zeros(4), ca.sin(theta), ca.cos(theta))
    >>> [round(float(v), 12) + 0.0 for v in ca.Function("f", [theta], [found])(1.5707963267948966).full()[:, 0]]
    [1.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]
    """  # noqa: E501
    phi, psi, x, y = (POSE_UNIT * pose[i] for i in range(4))
    st, ct, sp, cp = ca.sin(theta), ca.cos(theta), ca.sin(phi), ca.cos(phi)
    first, second = ca.vertcat(ct * cp, ct * sp, -st), ca.vertcat(-sp, cp, 0)
    mark = ca.cos(psi) * first + ca.sin(psi) * second
    contact = ca.vertcat(x + slope * cp, y + slope * sp, 0)
    return ca.SX(ca.vertcat(st * cp, st * sp, ct, mark, x, y, height, contact))


def _frame_of_axis(axis: ca.SX, front: ca.SX, place: ca.SX, height: Any, arm: ca.SX) -> ca.SX:
    """The place of a body from its axis and a direction fixed in it, made a unit and normal to it.

    Source: docs/explanation/bodies.md, the chart along fixed axes.
    """
    along = axis / ca.norm_2(axis)
    across = front - ca.dot(front, along) * along
    centre = ca.vertcat(POSE_UNIT * place, height)
    contact = ca.vertcat(centre[:2] + arm[:2], 0)
    return ca.SX(ca.vertcat(along, across / ca.norm_2(across), centre, contact))
