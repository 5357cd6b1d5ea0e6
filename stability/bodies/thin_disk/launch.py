"""Starts near the disk's steady motions, their symmetry axis tilted."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from ...algebra.upright import UPRIGHT
from ...base.checks import checked, instance, known
from ...base.errors import ParameterError, if_degrees
from ...base.types import Floats
from ..disk import Disk
from ..families import FAMILIES
from .disk_equations import STATES

TILT = 0.1
"""Tilt of the symmetry axis [rad]."""


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
