"""Problems about the families of the disk: units, exact data, roundings."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..base.checks import checked
from ..base.errors import NameUnknownError, NoMemberError, ParameterError, if_degrees, shown
from ..base.quantities import Units
from ..base.types import Floats
from ..bodies.contact import Contact
from ..bodies.contact_laws import LAWS, spelled, stored
from ..bodies.disk import Disk
from ..bodies.disk_polynomials import disk_polynomial
from ..bodies.families import FAMILIES, leaning
from ..bodies.quantities import PHYSICAL, is_angle
from ..bodies.thin_disk import disk_family
from .problem import Problem, _scalar


def disk_problem(
    family: str,
    disk: Disk,
    contact: Contact,
    at: ArrayLike | None = None,
    lean: ArrayLike | None = None,
) -> Problem:
    """The problem of one of the disk's families.

    Parameters
    ----------
    family
        A key of `FAMILIES`.
    disk, contact
        The body and the law; their fields may be arrays.
    at
        Family parameter; several numbers that name a member lie along the last axis.  None where
        the parameter is an axis.
    lean
        Angle π/2 - theta [rad] instead of `at`, where theta alone names a member; 0 is exactly
        upright.

    Returns
    -------
    Problem

    Raises
    ------
    StabilityError
        If the family, the law or a number is not accepted.

    Examples
    --------
    >>> from stability.bodies.contact_laws import Viscous
    >>> disk_problem("rolling", Disk(radius=0.3, gravity=9.81), Viscous(0.2), 5.0).names
    ('at', 'k', 'mass', 'radius', 'gravity', 'mu')
    """
    if not isinstance(family, str):
        raise NameUnknownError(f"family is {shown(family)}; give a name or a stability.Family.")
    if not isinstance(contact, Contact) or not contact.name:
        raise NameUnknownError(f"contact is {shown(contact)}; give one of {spelled(LAWS)}.")
    law = type(contact)
    if not law.linearises:
        raise NameUnknownError(
            f"contact is {shown(contact)}, dry friction, which has no linearisation of its own; "
            "inside the friction cone it is Rough()."
        )
    if not isinstance(disk, Disk):
        raise ParameterError(f"disk is {shown(disk)}; give a stability.Disk.")
    resolved = disk_family(family, law)
    parts = resolved.at
    keys = ("at",) if len(parts) == 1 else parts
    values: dict[str, Any] = {}
    if at is not None:
        given = np.asarray(checked("at", at), dtype=float)
        if len(keys) > 1 and (given.ndim == 0 or given.shape[-1] != len(keys)):
            raise ParameterError(
                f"at has shape {given.shape}; for {family} it is the pair ({', '.join(keys)}) "
                "along the last axis."
            )
        columns = [given] if len(keys) == 1 else list(np.moveaxis(given, -1, 0))
        values |= {key: _scalar(c) for key, c in zip(keys, columns, strict=True)}
        for part, column in zip(parts, columns, strict=True):
            _check_theta(family, part, column)
    if lean is not None:
        values |= {"lean": checked_lean(family, at, lean)}
    values |= {"k": disk.k} | {n: getattr(disk, n) for n in PHYSICAL}
    values |= contact.given

    return Problem(
        resolved,
        values,
        disk.dimensionless,
        partial(_reduce, parts, keys, law),
        _units,
        disk_roundings(parts, contact, si=not disk.dimensionless, lean=lean is not None),
        contact,
        disk_polynomial(family, law.name) if stored(law) else None,
    )


def _reduce(
    parts: Sequence[str],
    keys: Sequence[str],
    law: type[Contact],
    v: Mapping[str, Any],
    root: Callable[[Any], Any],
) -> tuple[list[Any], list[Any], Any]:
    time = root(v["radius"] / v["gravity"])
    if "lean" in v:
        # no double is π/2, so the right angle has the type of the lean
        upright = v["lean"].pi() / 2 if hasattr(v["lean"], "pi") else np.pi / 2
        v = dict(v) | {"at": upright - v["lean"]}
    a = [v[k] if is_angle(p) else v[k] * time for k, p in zip(keys, parts, strict=True)]
    # under the linear law mu means c = mu m g
    q = [v["k"], *law.arguments(v, _units(v, root)).values()]
    return a, q, 1 / time


def _units(v: Mapping[str, Any], root: Callable[[Any], Any] = np.sqrt) -> Units:
    return Units(v["mass"], v["radius"], v["gravity"], root)


def checked_lean(family: str, at: ArrayLike | None, lean: ArrayLike) -> Any:
    """The lean as finite numbers strictly between -π/2 and π/2, or a refusal."""
    if not FAMILIES[family].by_angle:
        raise ParameterError(f"lean names a member of {leaning()}; for {family} give at.")
    if at is not None:
        raise ParameterError("at and lean are both given; give one of them.")
    value = checked("lean", lean)
    bad = np.asarray(value)[np.abs(value) >= np.pi / 2]
    if bad.size:
        worst = float(bad.flat[np.abs(bad).argmax()])
        raise ParameterError(
            f"lean is {worst:g}; it must lie strictly between -π/2 and π/2, 0 is upright"
            f"{if_degrees(worst)}."
        )
    return value


def disk_roundings(
    parts: Sequence[str], contact: Contact, *, si: bool, lean: bool = False
) -> tuple[int, ...]:
    """Number of roundings in each dimensionless number: none for k and for a given angle."""
    some = 4 if si else 0
    angle = 2 if lean else 0
    turns = (angle if is_angle(p) else some for p in parts)
    return (*turns, 0, *((some,) * len(contact.symbols())))


def _check_theta(family: str, part: str, values: Any) -> None:
    """Refuse an inclination at which the disk is flat; a guess at degrees says so."""
    if part != "theta":
        return
    bad = values[(values <= 0) | (values >= math.pi)]
    if bad.size:
        worst = float(bad.flat[np.abs(bad).argmax()])
        raise NoMemberError(
            f"{family} does not exist there: theta is {worst:g}; theta must lie strictly "
            "between 0 and π, because the disk is flat at both and its equations of motion end "
            f"there{if_degrees(worst)}."
        )


def check_axis(problem: Problem, name: str, values: Floats) -> None:
    """Refuse an axis with values that the body or the law does not accept."""
    if problem.law is None:
        return
    part = problem.family.at[0] if name == "at" else name
    _check_theta(problem.family.name, part, values)
    if name == "lean":
        checked_lean(problem.family.name, None, values)
    if problem.law.alternatives(name):
        problem.law.accepted(name, values)
    elif name in ("k", *PHYSICAL):
        Disk(**{name: values})
