"""Starts near the steady motions of the disk and of bodies of revolution."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..algebra.upright import UPRIGHT
from ..base.checks import broadcast, checked, instance, known
from ..base.errors import NoMemberError, ParameterError, if_degrees, listing
from ..base.types import Floats
from .disk import Disk
from .families import _RECORDS, FAMILIES, SteadyFamily
from .newton_euler import STATES
from .round_body.body import Body
from .round_body.families import place_of
from .round_body.inclinations import tumbling_rates
from .round_body.shape import RoundShape
from .round_body.si_law import shape_of
from .round_body.thin import is_thin, round_shape, thin_body
from .subject import disk_family

TILT = 0.1
"""Tilt of the symmetry axis [rad]."""
LEVEL = 1e-9
"""Largest slope of the height, over the height, where a body rolls."""
SAME = 1e-6
"""Largest difference, relative or absolute, of a closed form from the member solved for."""


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
    is_body = isinstance(body, Body)
    names = [n for n, f in FAMILIES.items() if (len(f.at) == 1 if is_body else f.line)]
    record = FAMILIES[known("family", family, names)]
    if not is_body and (theta is not None or pole is not None):
        raise ParameterError(
            "theta and pole belong to a stability.Body; leave them out for a disk."
        )
    shape = thin_body(_disk_of(record, disk)) if body is None else round_shape(body)
    place = place_of(shape, family, theta, pole) if is_body else None
    if place is not None and not record.pole:
        _same_place(shape, family, place)
    where, lean = np.asarray(checked("at", at)), np.asarray(checked("tilt", tilt))
    sizes = {n: np.shape(v) for n, v in shape.given.items()}
    six = np.zeros((*broadcast(at=where.shape, tilt=lean.shape, **sizes), 6))
    if record.by_angle:
        _inside(f"at of {family} is theta =", where, where, shape)
    rate = np.sqrt(np.asarray(shape.gravity) / shape.length)
    with np.errstate(all="ignore"):  # a member that does not exist is refused
        if is_body:
            member = _member(shape, record, where, place, rate)
        else:
            member = record.member(np, where, shape.shape["k"], rate)
            _check_solution(record, where, shape.shape["k"], rate)
        for column, name in enumerate(STATES):
            value = member.get(name, 0.0)
            six[..., column] = math.pi / 2 if value is UPRIGHT else value
    if not np.isfinite(six).all():
        raise ParameterError(
            f"at of {family} is {where.min():g}, where its rate overflows double precision, or "
            f"where {shape.name} has no such motion; give another."
        )
    six[..., 0] += lean if place == 0 else -lean
    _inside("the tilt takes theta to", six[..., 0], lean, shape)
    return six


def _disk_of(record: SteadyFamily, disk: Any) -> Disk:
    if disk is None and record.solution is not None:
        raise ParameterError(
            f"disk is missing; {', '.join(record.disk_unknown)} of {record.name} depends on the "
            "body: give disk=stability.Disk(...)."
        )
    return Disk() if disk is None else instance("disk", disk, Disk, "give a stability.Disk")


def _check_solution(record: SteadyFamily, where: Floats, k: Any, rate: Any) -> None:
    """Refuse a user's closed form whose first value is not that of the member solved for."""
    if record.solution is None or record in _RECORDS:  # tests compare those of the package
        return
    family = disk_family(record.name, record.law or "viscous")
    at, inertia, clock = (float(np.ravel(v)[0]) for v in (where, k, rate))
    closed = record.member(np, at / record.unit(clock), inertia)
    first = [closed[name] for name in family.unknown]
    if not np.isfinite(first).all():
        return
    numbers = [{"k": inertia}.get(name, 1.0) for name in family.parameters]
    try:
        solved = family.member([closed[name] for name in family.at], numbers, first)
        near = solved[[family.system.index(name) for name in family.unknown]]
    except NoMemberError:
        near = np.full(len(first), np.nan)
    if not np.allclose(first, near, rtol=SAME, atol=SAME):
        raise ParameterError(
            f"solution of {record.name} gives {listing(family.unknown, first)} at "
            f"{listing(family.at, [closed[n] for n in family.at])}, k = {inertia:g}, which is no "
            "steady motion; correct the record."
        )


def _same_place(body: RoundShape, family: str, place: float) -> None:
    """Refuse numbers of the shape that move the inclination, which is that of the first of them."""
    height, slope, _ = (np.asarray(v) for v in body.heights(place))
    level = np.abs(slope) <= LEVEL * height
    if not level.all():
        raise ParameterError(
            f"{', '.join(body.shape)} of {body.name} takes several values, and {family} has "
            "another inclination at each; make one call for each value."
        )


def _member(
    body: RoundShape, record: SteadyFamily, where: Floats, place: float | None, rate: Any
) -> dict[str, Any]:
    """The states of a body's member, from its closed form."""
    if place is None:
        spin, roll = tumbling_rates(body, where)
        return {"theta": where, "phi_dot": spin * rate, "omega3": roll * rate}
    if record.at == ("phi_dot",):
        return {"theta": place, "phi_dot": where}
    return {"theta": place, "omega3": -where if place == math.pi else where}


def _inside(what: str, theta: Floats, angle: Floats, body: RoundShape) -> None:
    """Refuse inclinations at which a body does not stand; `angle` may be in degrees by mistake."""
    low, high = body.between
    edge = is_thin(shape_of(body))  # it lies flat at both ends
    inside = (theta > low) & (theta < high) if edge else (theta >= low) & (theta <= high)
    if not inside.all():
        worst = float(angle.flat[np.abs(angle).argmax()])
        raise ParameterError(
            f"{what} {theta[~inside].flat[0]:g}; the height of {body.name} holds strictly between "
            f"{low:.6g} and {high:.6g}{if_degrees(worst)}."
        )
