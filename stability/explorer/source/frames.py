"""Where a body is in space, for the 3-D view: axis, mark, centre and contact point as a graph."""

from __future__ import annotations

from typing import Any

import casadi as ca

from ...bodies.model import POSE_UNIT

ENTRIES = 12
"""Numbers of a place: axis, direction of the mark, centre, contact point, three each."""


def frame_of_angles(theta: Any, pose: ca.SX, height: Any, slope: Any) -> ca.SX:
    """The place of a body from its angles; that of the centre has the unit `POSE_UNIT`.

    Source: docs/explanation/bodies.md, frames and contact point a = h' x̂ - h ẑ.

    Examples
    --------
    >>> theta = ca.SX.sym("theta")
    >>> found = frame_of_angles(theta, ca.SX.zeros(4), ca.sin(theta), ca.cos(theta))
    >>> [round(float(v), 12) + 0.0 for v in ca.Function("f", [theta], [found])(1.5707963267948966).full()[:, 0]]
    [1.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]
    """  # noqa: E501
    phi, psi, x, y = (POSE_UNIT * pose[i] for i in range(4))
    st, ct, sp, cp = ca.sin(theta), ca.cos(theta), ca.sin(phi), ca.cos(phi)
    first, second = ca.vertcat(ct * cp, ct * sp, -st), ca.vertcat(-sp, cp, 0)
    mark = ca.cos(psi) * first + ca.sin(psi) * second
    contact = ca.vertcat(x + slope * cp, y + slope * sp, 0)
    return ca.SX(ca.vertcat(st * cp, st * sp, ct, mark, x, y, height, contact))


def frame_of_axis(axis: ca.SX, front: ca.SX, place: ca.SX, height: Any, arm: ca.SX) -> ca.SX:
    """The place of a body from its axis and a direction fixed in it, made a unit and normal to it.

    Source: docs/explanation/bodies.md, the chart along fixed axes.
    """
    along = axis / ca.norm_2(axis)
    across = front - ca.dot(front, along) * along
    centre = ca.vertcat(POSE_UNIT * place, height)
    contact = ca.vertcat(centre[:2] + arm[:2], 0)
    return ca.SX(ca.vertcat(along, across / ca.norm_2(across), centre, contact))
