"""A family of a body of revolution by name, turned into a `Family` with its numbers by name."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import Any

from ...base.errors import NameUnknownError, ParameterError, shown
from ...systems.family import Family
from ..contact import Contact
from ..contact_laws import LAWS, law_class, spelled
from ..disk import Disk
from ..law_names import class_named, law_given
from .families import FAMILIES, round_family
from .shape import SCALES, RoundShape


def of_body(
    family: Any, body: Any, disk: Any, contact: Any, parameters: Mapping[str, Any],
    axes: Sequence[Any] = (),
) -> tuple[Any, Any, Any, dict[str, Any]]:  # fmt: skip
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
    if body is None:
        return family, disk, contact, given
    if disk is not None:
        raise ParameterError("body and disk are both given; give one of them.")
    if isinstance(body, Disk):
        return family, body, contact, given
    if not isinstance(body, RoundShape):
        raise ParameterError(f"body is {shown(body)}; give a stability.Body or a stability.Disk.")
    if isinstance(family, Family):
        raise ParameterError(
            f"body belongs to families by name; {family.name} is a family of "
            f"{family.system.name}, which has its own equations."
        )
    if not isinstance(family, str) or family not in FAMILIES:
        raise _unknown(family, body)
    swept = [a[0] for a in axes if isinstance(a, (tuple, list)) and a and isinstance(a[0], str)]
    return _resolved(family, body, _law(contact, given, swept), given, swept)


def _law(contact: Any, given: dict[str, Any], swept: Collection[str]) -> Contact:
    found = law_given(contact, given, swept=swept)
    if found is None:
        raise ParameterError(f"contact is missing; give {spelled(LAWS)}, or make mu an axis.")
    if not isinstance(found, Contact) or not found.name:
        raise NameUnknownError(f"contact is {shown(found)}; give one of {spelled(LAWS)}.")
    law_class(type(found), motion=False)
    return found


def _resolved(
    family: str, body: RoundShape, law: Contact, given: dict[str, Any], swept: Collection[str]
) -> tuple[Family, None, None, dict[str, Any]]:
    theta = given.pop("theta", None) if FAMILIES[family].level else None
    physical = not body.dimensionless or any(n in SCALES for n in swept)
    coefficients = dict(law.given)
    for name in swept:  # an axis takes the place of its alternatives
        others = type(law).alternatives(name)
        if others:
            coefficients = {n: v for n, v in coefficients.items() if n not in others} | {name: 1.0}
    found = round_family(
        body, family, type(law), tuple(coefficients), physical=physical, theta=theta
    )
    numbers = body.given | coefficients
    for name in given:
        if name in numbers:
            raise ParameterError(f"{name} is {body.name}'s own number; give it there alone.")
    own = {n: numbers[n] for n in found.system.parameters if n not in swept}
    return found, None, None, own | given


def body_family(body: RoundShape, name: str, contact: Any, theta: float | None) -> Family:
    """A family of a body under a law, its class or its name, as `Body.family` describes.

    Parameters
    ----------
    body, name, contact, theta
        As for `Body.family`.
    """
    if not isinstance(name, str) or name not in FAMILIES:
        raise _unknown(name, body)
    law: Any = class_named(contact, motion=False) if isinstance(contact, str) else contact
    kind = law_class(type(law) if isinstance(law, Contact) else law, motion=False)
    given: Collection[str] = (
        law.given
        if isinstance(law, Contact)
        else {kind.alternatives(p.name)[0]: None for p in kind.parameters}
    )  # one name a coefficient
    return round_family(
        body, name, kind, tuple(given), physical=not body.dimensionless, theta=theta
    )


def _unknown(family: Any, body: RoundShape) -> NameUnknownError:
    return NameUnknownError(
        f"family is {shown(family)}; known for {body.name} are {', '.join(FAMILIES)}."
    )
