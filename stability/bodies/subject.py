"""A family of a body of revolution by name, turned into a `Family` with its numbers by name."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..base.checks import one_number
from ..base.errors import NameUnknownError, NoMemberError, ParameterError, shown
from ..systems.family import Family
from .contact_laws import LAWS, Contact, Viscous, law_class, law_given, law_missing, spelled
from .disk import Disk
from .families import FAMILIES
from .resistance import Resistance, resistances
from .round_body.body import Body
from .round_body.families import body_family, round_family, survives, unknown_family
from .round_body.inclinations import level
from .round_body.shape import SCALES, RoundShape, refuse_constants, single_pole
from .round_body.thin import thin_body
from .thin_disk import disk_family


def of_body(
    family: Any,
    body: Any,
    disk: Any,
    contact: Any,
    parameters: Mapping[str, Any],
    axes: Sequence[Any] = (),
) -> tuple[Any, Any, Any, dict[str, Any]]:
    """Family, disk, contact and parameters of a call, with a body's numbers among the parameters.

    Parameters
    ----------
    family
        What the caller gave: a name, or a `Family`.
    body
        A `Body`, a `Disk`, or None, which leaves everything as it is.
    disk, contact, parameters
        What the caller gave.
    axes
        Axes as the caller gave them; their values are set later.

    Returns
    -------
    family, disk, contact, parameters
        For a `Body` its `Family`, None, None, and every number by name but those swept.

    Raises
    ------
    StabilityError
        If the arguments do not fit together.

    Examples
    --------
    >>> import casadi as ca
    >>> from stability.bodies.round_body.body import Body
    >>> ball = Body(lambda theta: 1.0, axial=0.4, transverse=0.4, name="ball")
    >>> of_body("spinning", ball, None, "rough", {})[0].system.name
    'ball, rough'
    """
    given = dict(parameters)
    if body is None and isinstance(disk, Disk) and given.get("resistance") is not None:
        body, disk = disk, None
    if body is None:
        return family, disk, contact, given
    if disk is not None:
        raise ParameterError("body and disk are both given; give one of them.")
    if isinstance(body, Disk) and given.get("resistance") is not None:
        body = thin_body(body)
    if isinstance(body, Disk):
        return family, body, contact, {n: v for n, v in given.items() if n != "resistance"}
    if not isinstance(body, RoundShape):
        raise ParameterError(f"body is {shown(body)}; give a stability.Body or a stability.Disk.")
    if isinstance(family, Family):
        raise ParameterError(
            f"body belongs to families by name; {family.name} is a family of "
            f"{family.system.name}, which has its own equations."
        )
    if not isinstance(family, str) or family not in FAMILIES:
        raise unknown_family(family, body)
    swept = [a[0] for a in axes if isinstance(a, (tuple, list)) and a and isinstance(a[0], str)]
    refuse_constants(body, swept)
    law = _law(contact, given, swept)
    for axis in axes:
        _check_axis(body, law, axis)
    return _resolved(family, body, law, given, swept)


def _check_axis(body: RoundShape, law: Contact, axis: Any) -> None:
    """Refuse an axis with values that the body or the law does not accept."""
    if not (isinstance(axis, (tuple, list)) and len(axis) > 2 and isinstance(axis[0], str)):
        return
    name = axis[0]
    low, high = (
        one_number(f"the {side} end of the axis {name}", value)
        for side, value in zip(("low", "high"), axis[1:3], strict=True)
    )
    if type(law).alternatives(name):
        type(law).accepted(name, [low, high])
    if name not in body.given:
        return
    between = np.linspace(low, high, 17)
    if not isinstance(body, Body):
        Disk(**{"radius" if name == "length" else name: between})  # a disk checks its numbers
        return
    single = {n: float(np.asarray(v).flat[0]) for n, v in body.shape.items()}
    change = {"shape": single | {name: between}} if name in body.shape else {name: between}
    replace(body, **change)  # and so does a body


def family_by_name(
    family: Any, body: Any, contact: Any, given: Collection[str], word: str = "family"
) -> Any:
    """A family of a call that keeps every number as a variable: by its name, or as it is.

    Parameters
    ----------
    family
        What the caller gave: a name, or anything else, which is returned as it is.
    body
        A `Body` or `Disk`; the disk when None.
    contact
        A law, its name or its class; None counts as viscous where `mu` is given, as in `spectrum`.
    given
        Names of the numbers that the caller gave.
    word
        Name of the argument of the family.

    Raises
    ------
    StabilityError
        If the law is missing, or body or law are given with a family that has its own.

    Examples
    --------
    >>> family_by_name("spinning", None, "rough", ()).parameters
    ('k',)
    """
    if not isinstance(family, str):
        for name, one in (("contact", contact), ("body", body)):
            if one is not None:
                raise ParameterError(
                    f"{name} belongs to a family by its name; leave it out where {word} is "
                    f"{shown(family)}."
                )
        return family
    contact = Viscous if contact is None and "mu" in given else contact
    if body is None or isinstance(body, Disk):
        return disk_family(family, contact)
    if not isinstance(body, RoundShape):
        raise ParameterError(f"body is {shown(body)}; give a stability.Body or a stability.Disk.")
    return body_family(body, family, contact, None)


def _law(contact: Any, given: dict[str, Any], swept: Collection[str]) -> Contact:
    found = law_given(contact, given, swept=swept)
    if found is None:
        raise law_missing(LAWS, ", or make mu an axis" if swept else "")
    if not isinstance(found, Contact) or not found.name:
        raise NameUnknownError(f"contact is {shown(found)}; give one of {spelled(LAWS)}.")
    law_class(type(found), motion=False)
    return found


def _resolved(
    family: str, body: RoundShape, law: Contact, given: dict[str, Any], swept: Collection[str]
) -> tuple[Family, None, None, dict[str, Any]]:
    theta = given.pop("theta", None) if FAMILIES[family].level else None
    pole = single_pole(given.pop("pole", None))
    against = resistances(given.pop("resistance", None))
    physical = not body.dimensionless or any(n in SCALES for n in swept)
    coefficients = dict(law.given)
    for name in swept:  # an axis takes the place of its alternatives
        others = type(law).alternatives(name)
        if others:
            coefficients = {n: v for n, v in coefficients.items() if n not in others} | {name: 1.0}
    for r in against:
        if np.any(r.value) or r.coefficient in swept:
            _survives(family, body, r, theta)
    found = round_family(
        body,
        family,
        type(law),
        tuple(coefficients),
        physical=physical,
        theta=theta,
        pole=pole,
        resistance=tuple(type(r) for r in against),
    )
    numbers = body.given | coefficients | {r.coefficient: r.value for r in against}
    for name in given:
        if name in numbers:
            owner = f"the {law.name} law" if name in coefficients else body.name
            raise ParameterError(f"{name} is {owner}'s own number; give it there alone.")
    own = {n: numbers[n] for n in found.system.parameters if n not in swept}
    return found, None, None, own | given


def _survives(family: str, body: RoundShape, resistance: Resistance, theta: float | None) -> None:
    """Refuse a family whose members lose energy to a resistance, so that none is steady."""
    upright = FAMILIES[family].level and level(body, theta) is None
    if not survives(family, (type(resistance),), upright=upright):
        raise NoMemberError(
            f"{family} of {body.name} does not survive {resistance.name}, which costs energy "
            "there; slow_flow gives its drift along the family."
        )
