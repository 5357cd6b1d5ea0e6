"""Frames of a film of a body of revolution: its outline, stripes, and the end of its axis."""

from __future__ import annotations

import math
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.path import Path
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, QhullError
from scipy.spatial.transform import Rotation, Slerp

from ...base.types import Floats
from ...bodies.round_body.body import Body
from .film import BLUE, Camera

if TYPE_CHECKING:
    import xarray

STRIPES, ROUND, ALONG = 6, 48, 61
"""Stripes along the surface; points round it and along a meridian."""
CAP, WEDGE = 0.55, 2
"""Half opening of the coloured cap at the end of the axis, as an angle of normals [rad]; on a flat
end a wedge shows the turning: its half width, in points round the axis."""


@dataclass(frozen=True, eq=False)
class Placed:
    """Path of a body, as a camera needs it."""

    radius: float
    """Largest distance of the surface from the centre."""
    centre: Floats
    """The centre, shape (n, 3)."""
    contact: Floats
    """The contact point, shape (n, 3)."""


def meridian(body: Body) -> tuple[Floats, Floats, Floats]:
    """The meridian about the centre of mass: distance from the axis, place along it, inclination.

    Parameters
    ----------
    body
        The body; its numbers are single ones.

    Returns
    -------
    r, z, theta
        Shapes (m,) [m, m, rad].  The point touches the plane when the axis is inclined by theta.

    Examples
    --------
    >>> from stability.bodies.round_body.shapes.named import EccentricSphere
    >>> r, z, _ = meridian(EccentricSphere(0.2))
    >>> bool(abs(r**2 + (z - 0.2) ** 2 - 1).max() < 1e-12)
    True
    """
    low, high = body.between
    theta = np.linspace(low, high, ALONG)
    theta[[0, -1]] += [1e-9, -1e-9]  # the height may have no value at its ends
    h, slope = body.height_at(theta), body.height_at(theta, 1)
    size, s, c = float(body.length), np.sin(theta), np.cos(theta)
    return size * (h * s + slope * c), size * (slope * s - h * c), theta


@dataclass(frozen=True, eq=False)
class Surface:
    """The closed surface that is drawn: rows along the meridian."""

    r: Floats
    """Distance from the axis, shape (m,) [m]."""
    z: Floats
    """Place along the axis from the centre of mass, shape (m,) [m]."""
    theta: Floats
    """Inclination at which the row touches the plane, shape (m,) [rad]."""
    mark: NDArray[np.bool_]
    """Coloured points, shape (m, ROUND)."""


def surface(body: Body) -> Surface:
    """The surface of a body: the other half where the two are equal, and its flat ends.

    Parameters
    ----------
    body
        The body; its numbers are single ones.

    Examples
    --------
    >>> from stability.bodies.round_body.shapes.named import ThickDisk
    >>> seen = surface(ThickDisk(0.4))
    >>> round(float(seen.z.min()), 12), round(float(seen.z.max()), 12), float(seen.r[-1])
    (-0.2, 0.2, 0.0)
    """
    r, z, theta = meridian(body)
    if theta[-1] < math.pi / 2 + CAP:  # a height up to upright is that of a body with equal halves
        r, z = np.concatenate([r, r[::-1]]), np.concatenate([z, -z[::-1]])
        theta = np.concatenate([theta, math.pi - theta[::-1]])
    flat = r[-1] > 1e-6 * r.max()
    if flat:
        r, z = np.concatenate([[0.0], r, [0.0]]), np.concatenate([z[:1], z, z[-1:]])
        theta = np.concatenate([[0.0], theta, [math.pi]])
    around = np.arange(ROUND)
    near = np.minimum(around, ROUND - around) <= WEDGE if flat else np.full(ROUND, True)
    upper = theta > (math.pi / 2 if flat else theta[-1] - CAP)
    return Surface(r, z, theta, upper[:, None] & near)


def placed(motion: Mapping[str, Floats], body: Body, times: Floats) -> dict[str, Any]:
    """A motion at other times: the attitude by turns about fixed axes, the rest by lines.

    Parameters
    ----------
    motion
        Series of a run with pose.
    body
        The body.
    times
        Times within those of the motion, shape (n,).
    """
    names = "theta", "centre_x", "centre_y", "contact_x", "contact_y"
    found: dict[str, Any] = {n: np.interp(times, motion["time"], motion[n]) for n in names}
    angles = np.stack([motion[n] for n in ("phi", "theta", "psi")], axis=-1)
    found["turn"] = Slerp(motion["time"], Rotation.from_euler("ZYZ", angles))(times).as_matrix()
    found["theta"] = np.arccos(np.clip(found["turn"][:, 2, 2], -1.0, 1.0))
    height = body.length * np.asarray(body.height_at(found["theta"]))
    flat = np.zeros_like(times)
    r, z, _ = meridian(body)
    found["placed"] = Placed(
        float(np.hypot(r, z).max()),
        np.stack([found["centre_x"], found["centre_y"], height], axis=-1),
        np.stack([found["contact_x"], found["contact_y"], flat], axis=-1),
    )
    return found | {"time": times, "phi": motion["phi"][:1]}


def on_page(motion: Mapping[str, Floats], body: Body, times: Floats) -> dict[str, Any]:
    """Series and shape of a body for a page that a reader turns.

    Parameters
    ----------
    motion
        Series of a run with pose.
    body
        The body.
    times
        Times within those of the motion, shape (n,).

    Returns
    -------
    dict
        `turn`, quaternions (x, y, z, w) whose signs do not jump; centre, contact point and forces
        along fixed axes; `shape`, the surface; `size`, its largest distance from the centre.
    """
    found = placed(motion, body, times)
    turn = Rotation.from_matrix(found["turn"]).as_quat()
    jumps = np.sum(turn[1:] * turn[:-1], axis=1) < 0
    turn[1:] *= np.where(np.cumsum(jumps) % 2, -1.0, 1.0)[:, None]
    # x̂ turns with phi: forces are turned into fixed axes before they are interpolated
    force = (motion["force_x"] + 1j * motion["force_y"]) * np.exp(1j * motion["phi"])
    across = {"normal_force": motion["normal_force"], "push_x": force.real, "push_y": force.imag}
    series = {n: np.interp(times, motion["time"], v) for n, v in across.items()}
    names = "theta", "centre_x", "centre_y", "contact_x", "contact_y"
    series |= {n: found[n] for n in names}
    shape = surface(body)
    return series | {
        "time": times,
        "phi": found["phi"],
        "centre_z": found["placed"].centre[:, 2],
        "turn": turn,
        "shape": shape,
        "size": found["placed"].radius,
    }


class BodyCamera(Camera):
    """The figure of a film of a body."""

    def __init__(
        self,
        motion: dict[str, Any],
        dataset: xarray.Dataset,
        pace: float,
        body: Body,
        *,
        contact_path: bool = True,
    ) -> None:
        super().__init__(motion, dataset, pace, motion["placed"], contact_path=contact_path)
        shape = surface(body)
        angle = np.linspace(0, 2 * math.pi, ROUND, endpoint=False)
        self.points = _turned(shape.r, shape.z, angle)
        self.normals = _turned(np.sin(shape.theta), -np.cos(shape.theta), angle)
        self.marked = shape.mark.ravel()

    def show(self, frame: int) -> None:
        """Move all parts to their places at a frame."""
        i = frame * self.fine
        turn, target = self.motion["turn"][i], self.target[i]
        points = self.seen.centre[i] + self.points.reshape(-1, 3) @ turn.T
        facing = self.normals.reshape(-1, 3) @ turn.T @ self.to_camera > 0
        flat = (points - target) @ self.screen
        self.grid.set_data(*((self._lines(target) - target) @ self.screen).T)
        self.shadow.set_path(_outline((points * [1, 1, 0] - target) @ self.screen))
        self.body.set_path(_outline(flat))
        self.body.set_facecolor(BLUE)
        self.mark.set_path(_outline(flat[facing & self.marked]))
        seen = np.where(facing[:, None], flat, np.nan).reshape(-1, ROUND, 2)
        lines = seen[:, :: ROUND // STRIPES].transpose(1, 0, 2)
        gaps = np.full((len(lines), 1, 2), np.nan)
        self.ticks.set_data(*np.concatenate([lines, gaps], axis=1).reshape(-1, 2).T)
        self.follow(i, self.seen.contact[i : i + 1])


def _turned(r: Floats, z: Floats, angle: Floats) -> Floats:
    """Points of a surface of revolution, shape (m, angles, 3)."""
    rows = np.outer(r, np.cos(angle)), np.outer(r, np.sin(angle)), np.outer(z, np.ones_like(angle))
    return np.stack(rows, axis=-1)


def _outline(points: Floats) -> Path:
    """The convex outline of points of the picture; nothing where they lie on a line."""
    if len(points) >= 3:
        with suppress(QhullError):  # an edge on which the eye looks along a flat end
            return Path(points[ConvexHull(points).vertices], closed=True)
    return Path([[0.0, 0.0]])
