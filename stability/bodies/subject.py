"""What a question is asked about, resolved once from names, objects and numbers."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..base.checks import checked, instance, known
from ..base.errors import NameUnknownError, NoMemberError, ParameterError, if_degrees, listed, shown
from ..base.exact_numbers import no_double
from ..systems.family import Family, refuse_system
from .contact_laws import (
    LAWS,
    Contact,
    Viscous,
    class_named,
    law_class,
    law_given,
    law_missing,
    law_only,
    refuse_misspelt,
    spelled,
)
from .disk import UNIFORM, Disk
from .disk_polynomials import stored
from .families import (
    FAMILIES,
    SteadyFamily,
    families_of_disk,
    families_under,
    leaning,
    record_of,
)
from .quantities import PHYSICAL
from .resistance import Resistance, resistances
from .round_body.body import Body
from .round_body.families import body_family, round_family, survives, unknown_family
from .round_body.inclinations import level
from .round_body.shape import SCALES, RoundShape, refuse_constants, single_pole
from .round_body.thin import round_shape, unit_disk

NONE: Mapping[str, Any] = MappingProxyType({})
LEAN = ("lean",)
"""The key of a member that a lean names."""


@dataclass(frozen=True, eq=False)
class Subject:
    """A family with the numbers that the caller gave.

    Only where its numbers become dimensionless does a disk differ from a body.
    """

    family: Family
    """The family; that of a disk is dimensionless."""
    keys: tuple[str, ...]
    """Names under which the numbers of a member stand; `at` for the single one of a disk."""
    member: Mapping[str, Any]
    """The numbers of the member by key, as far as they are given."""
    numbers: Mapping[str, Any]
    """Every other number by name, but those of `disk` and `law`."""
    body: RoundShape | None = None
    """A body of revolution, whose numbers are the family's own."""
    disk: Disk | None = None
    """A disk, whose numbers become dimensionless."""
    law: Contact | None = None
    """The contact law of a body or disk."""
    record: SteadyFamily | None = None
    """The family of a body or disk by its name."""

    @property
    def names(self) -> tuple[str, ...]:
        """Names that an axis may have."""
        if self.disk is not None:
            return tuple(dict.fromkeys((*self.keys, *_numbers_of(self.law))))
        return (*self.family.at, *self.family.parameters)

    def alternatives(self, name: str) -> tuple[str, ...]:
        """Names of the law's coefficient that a name is one of; empty for any other number."""
        return self.law.alternatives(name) if self.law else ()

    def key(self, axis: str) -> str:
        """The key of an axis: `at` and the member's own name are two names for one number."""
        single = len(self.keys) == 1 and axis in ("at", *self.family.at)
        return axis if not single or axis in self.family.parameters else self.keys[0]

    def check_axis(self, name: str, low: float, high: float) -> None:
        """Refuse an axis with values that the body or the law does not accept."""
        if self.law and self.law.alternatives(name):
            self.law.accepted(name, [low, high])
        between = np.linspace(low, high, 17)
        if self.disk is not None:
            check_angle(self.family.name, self.family.at[0] if name == "at" else name, between)
            if name == "lean":
                checked_lean(between)
            if name in ("k", *PHYSICAL):
                replace(self.disk, **{name: between})
        elif isinstance(self.body, Body) and name in self.body.given:
            first = {n: float(np.asarray(v).flat[0]) for n, v in self.body.shape.items()}
            shaped = {"shape": first | {name: between}} if name in first else {name: between}
            replace(self.body, **shaped)
        elif self.body is not None and name in self.body.given:
            numbers = self.body.given | {name: between}
            Disk(**{"radius" if n == "length" else n: v for n, v in numbers.items()})


def subject_of(
    family: str | Family,
    *,
    at: ArrayLike | None = None,
    lean: ArrayLike | None = None,
    disk: Disk | None = None,
    body: Any = None,
    contact: Contact | type[Contact] | str | None = None,
    parameters: Mapping[str, Any] = NONE,
    axes: Collection[str] = (),
    whole: bool = False,
    laws: Mapping[str, type[Contact]] = LAWS,
) -> Subject:
    """What a question is asked about.

    Parameters
    ----------
    family
        Name of a family of a disk or body, or a `Family`.
    at
        Number that names the member; where axes take some of several numbers, the others.
    lean
        Angle π/2 - theta [rad] instead of `at`, where theta alone names a member of a disk.
    disk, body, contact
        Body and law, for a family by its name; the uniform disk where neither is given.
    parameters
        Numbers by name.  One that has the name of an argument, such as `at`, is given in a mapping
        called `parameters`.
    axes
        Names of the axes, whose values are set later.
    whole
        Whether every number of the member must be given.
    laws
        Laws that this question takes, for the refusal of a call without one.

    Raises
    ------
    StabilityError
        If the arguments do not fit together.

    Examples
    --------
    >>> asked = subject_of("rolling", contact="viscous", parameters={"omega3": 1.2, "mu": 0.3})
    >>> asked.member, asked.law.mu
    ({'at': 1.2}, 0.3)
    """
    refuse_system(family)
    numbers = dict(parameters)
    shape = _revolved(body, disk, numbers)
    if isinstance(family, Family):
        _refuse_words(family, {"lean": lean, "disk": disk, "contact": contact, "body": body})
        subject = Subject(family, family.at, {}, {})
        return _with_numbers(subject, at, _opened(family, numbers), axes, whole=whole)
    if shape is not None:
        return _of_body(family, shape, contact, numbers, at, lean, axes, whole=whole)
    thin = next((d for d in (body, disk) if d is not None), UNIFORM)
    return _of_thin(family, thin, contact, numbers, at, lean, axes, whole, laws)


def _of_thin(  # noqa: PLR0913
    name: Any,
    disk: Any,
    contact: Any,
    numbers: dict[str, Any],
    at: Any,
    lean: Any,
    axes: Collection[str],
    whole: bool,
    laws: Mapping[str, type[Contact]],
) -> Subject:
    record, leans = _of_disk(name), lean is not None or "lean" in axes
    if axes:
        check_names(name, axes, contact)
    keys = _keys(record.at)
    member = _member(name, record.at, keys, at, numbers, axes, whole=whole and lean is None)
    law = _stated(law_only(contact, numbers, swept=axes), numbers, axes, laws)
    instance("disk", disk, Disk, "give a stability.Disk")
    family = disk_family(name, law)
    member = {key: checked(key, value) for key, value in member.items()}
    for part, key in zip(record.at, keys, strict=True):
        if key in member:
            check_angle(name, part, np.asarray(member[key]))
    if leans:
        if not record.by_angle:
            raise ParameterError(f"lean names a member of {leaning()}; for {name} give at.")
        if member:
            raise ParameterError(f"{record.at[0]} and lean are both given; give one of them.")
        keys, member = LEAN, {} if lean is None else {"lean": checked_lean(lean)}
    return Subject(family, keys, member, {}, disk=disk, law=law, record=record)


def disk_family(name: str, law: str | Contact | type[Contact] | None = None) -> Family:
    """One of the disk's families under a contact law; dimensionless, built once.

    In each family the rate of theta_dot must vanish.  This equation is solved for phi_dot (rolling,
    tumbling) or omega3 (spinning, circling, precession).  Rolling and spinning satisfy it
    identically.

    Parameters
    ----------
    name
        A key of `FAMILIES`.
    law
        A contact law, its name or its class; its numbers stay parameters of the family.

    Returns
    -------
    Family
        The family, as `spectrum` and the others take it.

    Raises
    ------
    NameUnknownError, ParameterError
        If there is no such family under this law, or the law is missing.

    Source: Przybylska & Rauch-Wojciechowski 2016, Section 2; notebooks/theorems_disk.py proves
    that no law of friction has further steady motions.

    Examples
    --------
    >>> import stability as st
    >>> import math
    >>> st.disk_family("tumbling", "viscous").member([math.pi / 6], [0.5, 1.0]).round(12)[2]
    np.float64(2.0)
    """
    record = _of_disk(name)
    contact = law_class(law, motion=False)
    word = contact.name
    if record.law and (record.law != word or not stored(contact)):
        families = families_under(word if stored(contact) else "")
        raise NameUnknownError(
            f"{name} is a family of the {record.law} disk; steady motions under the {word} law are "
            f"{listed([f.name for f in families])}."
        )
    return _disk_family(record, contact)  # type: ignore[arg-type]  # a class is hashable


def _of_disk(name: Any) -> SteadyFamily:
    """The record of a family of the disk by its name."""
    if not isinstance(name, str):
        raise NameUnknownError(f"family is {shown(name)}; give a name or a stability.Family.")
    record = FAMILIES.get(name)
    if record is None or record.pole:
        known("family", name, families_of_disk())
    assert record
    return record


@lru_cache(maxsize=32)
def _disk_family(record: SteadyFamily, law: type[Contact]) -> Family:
    return replace(
        round_family(unit_disk(), record.name, law, law.symbols(), physical=False),
        conservative=law.conservative,
        integrals=law.conservative and stored(law),
        drifts=record.drifts and stored(law) and bool(law.parameters),
    )


def family_by_name(
    family: Any, body: Any, contact: Any, numbers: Collection[str], word: str = "family"
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
    numbers
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
        for name, value in (("contact", contact), ("body", body)):
            if value is not None:
                raise ParameterError(
                    f"{name} belongs to a family by its name; leave it out where {word} is "
                    f"{shown(family)}."
                )
        return family
    contact = Viscous if contact is None and "mu" in numbers else contact
    shape = _revolved(body, None, {})
    if shape is None:
        return disk_family(family, contact)
    return body_family(shape, family, contact, None)


def check_names(family: str, axes: Collection[str], contact: Any) -> None:
    """Refuse an axis that no disk has, before anything else that is missing.

    Parameters
    ----------
    family
        Name of a family of the disk.
    axes
        Names of the axes as they were given.
    contact
        A law, its name or class, or None for viscous.
    """
    record = record_of(family)
    law: Any = Viscous if contact is None else contact
    law = class_named(law, motion=True) if isinstance(law, str) else law
    if record is None or not isinstance(law, (type, Contact)) or not hasattr(law, "parameters"):
        return
    single = ("at", *record.at, *LEAN[: record.by_angle]) if len(record.at) == 1 else record.at
    for name in axes:
        refuse_unknown(name, family, dict.fromkeys((*single, *_numbers_of(law))))


def refuse_unknown(axis: str, family: str, names: Collection[str]) -> None:
    """Refuse an axis that a family does not have."""
    if axis not in names:
        raise NameUnknownError(f"axis is {shown(axis)}; known for {family} are {', '.join(names)}.")


def check_angle(family: str, part: str, values: Any) -> None:
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


def checked_lean(lean: ArrayLike) -> Any:
    """The lean as finite numbers strictly between -π/2 and π/2, or a refusal."""
    value = checked("lean", lean)
    bad = np.asarray(value)[np.abs(value) >= np.pi / 2]
    if bad.size:
        worst = float(bad.flat[np.abs(bad).argmax()])
        raise ParameterError(
            f"lean is {worst:g}; it must lie strictly between -π/2 and π/2, 0 is upright"
            f"{if_degrees(worst)}."
        )
    return value


def _numbers_of(law: Any) -> tuple[str, ...]:
    """Names of the numbers of a disk under a law."""
    return ("k", *PHYSICAL, *(p.name for p in law.parameters))


def _keys(names: tuple[str, ...]) -> tuple[str, ...]:
    return ("at",) if len(names) == 1 else names


def _revolved(body: Any, disk: Any, numbers: dict[str, Any]) -> RoundShape | None:
    """The body of revolution of a call; None for a disk without resistance."""
    if body is not None and disk is not None:
        raise ParameterError("body and disk are both given; give one of them.")
    thin = disk if body is None else body
    if thin is None:
        return None
    if isinstance(thin, Disk) and numbers.get("resistance") is None:
        numbers.pop("resistance", None)
        return None
    return round_shape(thin) if body is not None or isinstance(disk, Disk) else None


def _refuse_words(family: Family, words: Mapping[str, Any]) -> None:
    """Refuse what belongs to families by name."""
    stated = [word for word, value in words.items() if value is not None]
    if "body" in stated:
        raise ParameterError(
            f"body belongs to families by name; {family.name} is a family of "
            f"{family.system.name}, which has its own equations."
        )
    for word in stated:
        if word in family.parameters:
            raise ParameterError(
                f"{word} is an argument of the disk here; give the parameter {word} of "
                f"{family.name} as parameters={{{word!r}: …}}."
            )
    if "lean" in stated:
        raise ParameterError(f"lean belongs to families of the disk; {family.name} takes at.")
    if stated:
        raise ParameterError(
            f"{' and '.join(stated)} belong{'s' * (len(stated) == 1)} to the disk's families; "
            f"{family.name} takes {', '.join(family.parameters) or 'no parameters'}."
        )


def _opened(family: Family, numbers: dict[str, Any]) -> dict[str, Any]:
    """The numbers by name, with those of a mapping called `parameters`."""
    inner = numbers.get("parameters")
    if "parameters" in (*family.at, *family.parameters) or not isinstance(inner, Mapping):
        return numbers
    out = {name: value for name, value in numbers.items() if name != "parameters"}
    for name, value in inner.items():
        if not isinstance(name, str):
            raise ParameterError(f"parameters names {shown(name)}; give names, each a string.")
        if name in out:
            raise ParameterError(f"{name} is given by name and in parameters; give it once.")
        out[name] = value
    return out


def _with_numbers(
    subject: Subject, at: Any, numbers: dict[str, Any], axes: Collection[str], *, whole: bool
) -> Subject:
    """A subject whose numbers are the family's own."""
    family = subject.family
    if "at" in numbers and "at" not in (*family.at, *family.parameters):
        at = numbers.pop("at")
    for name in numbers:
        if name not in (*family.parameters, *family.at):
            raise NameUnknownError(
                f"{shown(name)} is not a parameter of {family.name}; known are "
                f"{', '.join((*family.parameters, *family.at)) or 'none'}."
            )
    member = _member(family.name, family.at, family.at, at, numbers, axes, whole=whole)
    return replace(subject, member=member, numbers=numbers)


def _member(
    family: str,
    names: tuple[str, ...],
    keys: tuple[str, ...],
    at: Any,
    numbers: dict[str, Any],
    axes: Collection[str],
    *,
    whole: bool,
) -> dict[str, Any]:
    """The numbers that name a member, by key: of `at`, or taken out of `numbers` by name.

    Numbers that are exact by their type stay so.
    """
    by_name = {n: numbers.pop(n) for n in names if n in numbers}
    if at is None:
        if whole and len(by_name) < len(names):
            raise ParameterError(
                f"at is missing; it names the member of the family, here {' and '.join(names)}."
            )
        return {k: _number(n, by_name[n]) for n, k in zip(names, keys, strict=True) if n in by_name}
    if not names:
        raise ParameterError(f"{family} has one member alone; leave at out.")
    if by_name:
        raise ParameterError(f"{next(iter(by_name))} is given as at and by name; give it once.")
    rest = tuple(k for k in keys if k not in axes)
    several = isinstance(at, (tuple, list)) or getattr(at, "ndim", 0) > 0
    parts = list(at) if several else [at]
    if len(keys) == 1:
        parts = [at]
    elif len(parts) == len(rest) < len(keys):
        keys = rest
    elif len(parts) != len(keys) and len(rest) < len(keys):
        raise ParameterError(
            f"at holds {len(parts)} numbers; a member of {family} is named by "
            f"{', '.join(names)}, and beyond the axis at holds "
            + (f"{len(rest)} ({', '.join(rest)})." if rest else "none, so leave it out.")
        )
    elif len(parts) != len(keys) or any(isinstance(p, (tuple, list)) or np.ndim(p) for p in parts):
        array = np.asarray(checked("at", at), dtype=float)
        if array.ndim == 0 or array.shape[-1] != len(keys):
            raise ParameterError(
                f"at has shape {array.shape}; for {family} it holds ({', '.join(keys)}) along its "
                "last axis."
            )
        parts = list(np.moveaxis(array, -1, 0))
    return {key: _number("at", part) for key, part in zip(keys, parts, strict=True)}


def _number(name: str, value: Any) -> Any:
    exact = type(value) is not float and no_double(value) is not None
    return value if exact else checked(name, value)


def _stated(
    law: Any,
    numbers: Mapping[str, Any],
    axes: Collection[str],
    laws: Mapping[str, type[Contact]] = LAWS,
) -> Contact:
    """A contact law with its numbers, for a linearisation."""
    if law is None:
        refuse_misspelt(Viscous, numbers)
        raise law_missing(laws, ", or make mu an axis" if axes else "")
    if not isinstance(law, Contact) or not law.name:
        raise NameUnknownError(f"contact is {shown(law)}; give one of {spelled(LAWS)}.")
    law_class(law, motion=False)
    return law


def _of_body(
    name: Any,
    body: RoundShape,
    contact: Any,
    numbers: dict[str, Any],
    at: Any,
    lean: Any,
    axes: Collection[str],
    *,
    whole: bool,
) -> Subject:
    record = record_of(name)
    if record is None:
        raise unknown_family(name, body)
    refuse_constants(body, axes)
    law = _stated(law_given(contact, numbers, swept=axes), numbers, axes)
    theta = numbers.pop("theta", None) if record.level else None
    pole = single_pole(numbers.pop("pole", None))
    against = resistances(numbers.pop("resistance", None))
    coefficients = dict(law.given)
    for axis in axes:  # an axis takes the place of its alternatives
        others = law.alternatives(axis)
        if others:
            coefficients = {n: v for n, v in coefficients.items() if n not in others} | {axis: 1.0}
    for r in against:
        if np.any(r.value) or r.coefficient in axes:
            _survives(record, body, r, theta)
    family = round_family(
        body,
        name,
        type(law),
        tuple(coefficients),
        physical=not body.dimensionless or any(n in SCALES for n in axes),
        theta=theta,
        pole=pole,
        resistance=tuple(type(r) for r in against),
    )
    values = body.given | coefficients | {r.coefficient: r.value for r in against}
    for number in numbers:
        if number in values:
            owner = f"the {law.name} law" if number in coefficients else body.name
            raise ParameterError(f"{number} is {owner}'s own number; give it there alone.")
    _refuse_words(family, {"lean": lean})
    values = {n: values[n] for n in family.system.parameters if n not in axes}
    subject = Subject(family, family.at, {}, {}, body=body, law=law, record=record)
    return _with_numbers(subject, at, values | _opened(family, numbers), axes, whole=whole)


def _survives(
    record: SteadyFamily, body: RoundShape, resistance: Resistance, theta: float | None
) -> None:
    """Refuse a family whose members lose energy to a resistance, so that none is steady."""
    upright = record.level and level(body, theta) is None
    if not survives(record.name, (type(resistance),), upright=upright):
        raise NoMemberError(
            f"{record.name} of {body.name} does not survive {resistance.name}, which costs energy "
            "there; slow_flow gives its drift along the family."
        )
