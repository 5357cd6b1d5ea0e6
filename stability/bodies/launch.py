"""Starts near the steady motions of the disk and of bodies of revolution."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..algebra.upright import UPRIGHT
from ..base.checks import broadcast, checked, instance, known
from ..base.errors import ParameterError, if_degrees
from ..base.types import Floats
from .disk import Disk
from .families import FAMILIES
from .newton_euler import STATES
from .round_body.body import Body
from .round_body.families import place_of
from .round_body.inclinations import tumbling_rates

TILT = 0.1
"""Tilt of the symmetry axis [rad]."""
LEVEL = 1e-9
"""Largest slope of the height, over the height, where a body rolls."""


def launch(
    family: str,
    *,
    at: ArrayLike,
    tilt: ArrayLike = TILT,
    disk: Disk | None = None,
    body: Body | Disk | None = None,
    theta: float | None = None,
    pole: Any = None,
) -> Floats:
    """The start of a launch near a steady motion, its symmetry axis tilted.

    Parameters
    ----------
    family
        A family whose members one number names: rolling, spinning or tumbling; of a body that is
        smooth at a pole vertical too.
    at
        Number omega3, phi_dot, theta or omega_Z of the steady motion, shape (…) [rad/s or rad].
    tilt
        Angle subtracted from theta, and added to it at theta = 0, shape (…) [rad].
    disk
        The disk; needed for tumbling, whose rate depends on it.
    body
        A `Body`, or a `Disk`, in its place.
    theta, pole
        Of a body, as for `spectrum`: where it rolls if at several inclinations; 0 or "pi".

    Returns
    -------
    ndarray
        The six states, shape (…, 6), for `simulate`.

    Raises
    ------
    NameUnknownError
        If there is no such family.
    ParameterError
        If tumbling has no disk, or an angle leaves the range in which the body stands.

    Source: definitions of docs/explanation/scenes.md; tests/motion/test_motion.py.

    Examples
    --------
    >>> import stability as st
    >>> st.launch("rolling", at=1.2, tilt=0.1).round(3).tolist()
    [1.471, 0.0, 0.0, 1.2, 0.0, 0.0]
    """
    if disk is not None and body is not None:
        raise ParameterError("body and disk are both given; give one of them.")
    if isinstance(body, Body):
        return _near_member(body, family, at, tilt, theta, pole)
    if theta is not None or pole is not None:
        raise ParameterError(
            "theta and pole belong to a stability.Body; leave them out for a disk."
        )
    return near_steady(family, at=at, tilt=tilt, disk=disk if body is None else body)


def _same_place(body: Body, family: str, place: float) -> None:
    """Refuse numbers of the shape that move the inclination, which is that of the first of them."""
    height, slope, _ = (np.asarray(v) for v in body.heights(place))
    level = np.abs(slope) <= LEVEL * height
    if not level.all():
        raise ParameterError(
            f"{', '.join(body.shape)} of {body.name} takes several values, and {family} has "
            "another inclination at each; make one call for each value."
        )


def _near_member(
    body: Body, family: str, at: ArrayLike, tilt: ArrayLike, theta: float | None, pole: Any
) -> Floats:
    """The six states near a member of a body's family, from its closed form."""
    known("family", family, [n for n, one in FAMILIES.items() if len(one.at) == 1])
    place = place_of(body, family, theta, pole)
    if place is not None and not FAMILIES[family].pole:
        _same_place(body, family, place)
    where, lean = np.asarray(checked("at", at)), np.asarray(checked("tilt", tilt))
    rate = np.sqrt(np.asarray(body.gravity) / body.length)
    sizes = {n: np.shape(v) for n, v in body.given.items()}
    shape = broadcast(at=where.shape, tilt=lean.shape, **sizes)
    six = np.zeros((*shape, 6))
    six[..., 0] = where if place is None else place
    if place is None:
        with np.errstate(all="ignore"):  # a member that does not exist is refused
            spin, roll = tumbling_rates(body, where)
            six[..., 2], six[..., 3] = spin * rate, roll * rate
    elif family == "spinning":
        six[..., 2] = where
    else:
        six[..., 3] = -where if place == math.pi else where
    if not np.isfinite(six).all():
        raise ParameterError(
            f"at of {family} is {where.min():g}, where {body.name} has no such motion, or its rate "
            "overflows double precision; give another."
        )
    six[..., 0] += lean if place == 0 else -lean
    low, high = body.between
    inside = (six[..., 0] >= low) & (six[..., 0] <= high)
    if not inside.all():
        raise ParameterError(
            f"the tilt takes theta to {six[..., 0][~inside].flat[0]:g}; the height of {body.name} "
            f"holds between {low:.6g} and {high:.6g}{if_degrees(float(np.abs(lean).max()))}."
        )
    return six


def near_steady(family: str, *, at: ArrayLike, tilt: ArrayLike, disk: Disk | None) -> Floats:
    """The start of a launch of the disk; numbers and errors as those of `stability.launch`."""
    known("family", family, [name for name, one in FAMILIES.items() if one.line])
    record = FAMILIES[family]
    if disk is None and record.solution is not None:
        raise ParameterError(
            f"disk is missing; {', '.join(record.disk_unknown)} of {family} depends on the body: "
            "give disk=stability.Disk(...)."
        )
    body = Disk() if disk is None else instance("disk", disk, Disk, "give a stability.Disk")
    where, lean = np.asarray(checked("at", at)), np.asarray(checked("tilt", tilt))
    shapes = where.shape, lean.shape, np.shape(body.k), np.shape(body.rate)
    try:
        shape = np.broadcast_shapes(*shapes)
    except ValueError:
        raise ParameterError(
            f"at, tilt and the disk have shapes {', '.join(map(str, shapes))}; make them fit."
        ) from None
    if record.by_angle and ((where <= 0) | (where >= math.pi)).any():
        bad = where[(where <= 0) | (where >= math.pi)].flat[0]
        raise ParameterError(
            f"at of {family} is theta = {bad:g}; it must lie strictly between 0 and π"
            f"{if_degrees(bad)}."
        )
    with np.errstate(all="ignore"):  # an overflow is refused
        member = record.member(np, where, body.k, body.rate)
    six = np.zeros((*shape, 6))
    for column, name in enumerate(STATES):
        six[..., column] = math.pi / 2 if member[name] is UPRIGHT else member[name]
    if not np.isfinite(six).all():
        raise ParameterError(
            f"at of {family} is {where.min():g}, where its rate overflows double precision, "
            "or where there is no such motion; give another."
        )
    six[..., 0] -= lean
    bad = six[..., 0][(six[..., 0] <= 0) | (six[..., 0] >= math.pi)]
    if bad.size:
        raise ParameterError(
            f"the tilt takes theta to {bad.flat[0]:g}; it must stay strictly between 0 and π"
            f"{if_degrees(float(lean.flat[np.abs(lean).argmax()]))}."
        )
    return six
