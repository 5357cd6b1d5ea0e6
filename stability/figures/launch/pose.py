"""A disk in space: its points from the angles and the centre of a motion, at any time."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from ...base.types import Floats

POSED = ("theta", "phi", "psi", "centre_x", "centre_y")
"""Series that place the disk."""
LINEAR = (
    "theta_dot",
    "phi_dot",
    "omega3",
    "slip_x",
    "slip_y",
    "normal_force",
    "force_x",
    "force_y",
)
"""Series that are interpolated by lines."""


@dataclass(frozen=True, eq=False)
class Geometry:
    """Place of the disk in space at n times; Z is up, vectors have shape (n, 3)."""

    radius: float
    """R, in the unit of the motion."""
    psi: Floats
    """Angle of the mark from `towards`, shape (n,) [rad]."""
    towards: Floats
    """1̂, from the centre to the contact point."""
    along: Floats
    """2̂, along the rim and level."""
    axis: Floats
    """3̂, the symmetry axis."""
    centre: Floats
    """The centre."""
    contact: Floats
    """The contact point."""

    def points(self, angle: Any, share: Any = 1.0) -> Floats:
        """Points fixed in the disk at every time.

        Parameters
        ----------
        angle
            Angle from the mark, shape (m,) [rad].
        share
            Distance from the centre, shape (m,) or () [R].

        Returns
        -------
        ndarray
            Shape (n, m, 3).
        """
        turn = (self.psi[:, None] + np.asarray(angle, dtype=float))[..., None]
        arm = np.cos(turn) * self.towards[:, None] + np.sin(turn) * self.along[:, None]
        reach = self.radius * np.asarray(share, dtype=float).reshape(-1, 1)
        return np.asarray(self.centre[:, None] + reach * arm)


def geometry(motion: Mapping[Any, Any]) -> Geometry:
    """The disk in space from its angles and the path of its centre.

    Parameters
    ----------
    motion
        A single run from `simulate` with `pose=True`, one time of a run, or its series by name.

    Returns
    -------
    Geometry

    Examples
    --------
    >>> import stability as st
    >>> seen = geometry(st.simulate(st.Disk(), st.Rough(), {"theta": 1.2}, 2.0, pose=True))
    >>> float(abs(seen.contact[:, 2]).max()) < 1e-15
    True
    """
    theta, phi, psi, x, y = (np.atleast_1d(np.asarray(motion[n], dtype=float)) for n in POSED)
    radius, zero = float(motion["radius"]), np.zeros_like(theta)
    out = np.stack([np.cos(phi), np.sin(phi), zero], axis=-1)
    along = np.stack([-np.sin(phi), np.cos(phi), zero], axis=-1)
    cosine, sine = np.cos(theta)[:, None], np.sin(theta)[:, None]
    up = np.array([0.0, 0.0, 1.0])
    towards, axis = cosine * out - sine * up, sine * out + cosine * up
    centre = np.stack([x, y, radius * np.sin(theta)], axis=-1)
    return Geometry(radius, psi, towards, along, axis, centre, centre + radius * towards)


def resample(motion: dict[str, Any], times: Floats) -> dict[str, Any]:
    """A motion at other times: the pose by cubics through values and rates, the rest by lines.

    Parameters
    ----------
    motion
        Series by name: `time`, `POSED`, `LINEAR`, and the radius.
    times
        Times within those of the motion, shape (n,).

    Returns
    -------
    dict
        The same series at these times.
    """
    found = {n: np.interp(times, motion["time"], motion[n]) for n in LINEAR}
    for name, rate in _rates(motion).items():
        found[name] = CubicHermiteSpline(motion["time"], motion[name], rate)(times)
    # between coarse samples a cubic may overshoot flat, and put the disk under the plane
    found["theta"] = np.clip(found["theta"], 0.0, math.pi)
    return found | {"time": times, "radius": motion["radius"]}


def _rates(motion: dict[str, Any]) -> dict[str, Floats]:
    """Rates of the pose; ṡ = vA − ω × R1̂ gives the rates of the centre."""
    theta, phi, omega3, radius = (motion[n] for n in ("theta", "phi", "omega3", "radius"))
    x = motion["slip_x"] + radius * motion["theta_dot"] * np.sin(theta)
    y = motion["slip_y"] - radius * omega3
    spin = omega3 - motion["phi_dot"] * np.cos(theta)
    centre = x * np.cos(phi) - y * np.sin(phi), x * np.sin(phi) + y * np.cos(phi)
    return dict(zip(POSED, (motion["theta_dot"], motion["phi_dot"], spin, *centre), strict=True))
