"""Data of a page: of the disk, of a body of revolution, of one family of a user's system."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from typing import Any

from ..base.axis import Axis
from ..base.errors import (
    NameUnknownError,
    ParameterError,
    StabilityError,
    StabilityWarning,
    listed,
    shown,
)
from ..base.version import __version__
from ..bodies.contact_laws import LAWS, Viscous
from ..bodies.disk import Disk
from ..bodies.law_names import law_given
from ..bodies.round_body.body import Body
from ..systems.family import Family
from .certificates import certificate
from .disk_subjects import FAMILY_NAMES, WORDS, disk_motion, disk_subject
from .own_subject import given_values, own_certificate, own_motion, own_subject
from .subject import Subject

CERTIFIED = (0.25, 0.5)
"""Values of k at which the diagrams over friction carry proved rectangles."""
MOTIONS = {"rolling": "Rolling", "spinning": "Spinning", "tumbling": "Tumbling"}
LAW_NAMES = {
    "smooth": "Smooth", "viscous": "Viscous", "linear-viscous": "Linear", "rough": "Rough",
}  # fmt: skip
"""Words on the buttons."""
BODY_FAMILIES, BODY_LAWS = ("rolling", "spinning"), ("smooth", "viscous", "rough")
"""Families and laws of a body whose conditions are polynomials in its numbers."""
DECIMALS = (
    " Floats in the equations count as the decimals that were written, which "
    "st.conditions(family, decimals=True).numbers lists."
)
"""What the reader of a page learns of numbers that are not exact."""
SPEEDS = (0.05, 5.0)
"""Range of omega3 and phi_dot of a body [√(g/R)]."""


def disk_page(
    family: Any, at: Any, contact: Any, disk: Disk | None, axes: Sequence[Any],
    parameters: Mapping[str, Any], *, certify: bool,
) -> dict[str, Any]:  # fmt: skip
    """Data of the page of the disk: every family under every stored law.

    Parameters
    ----------
    family, at, contact, disk, parameters, certify
        As for `explore`.
    axes
        The two axes, or None for each.
    """
    if not isinstance(family, str) or family not in FAMILY_NAMES:
        raise NameUnknownError(
            f"family is {shown(family)}; give {listed(FAMILY_NAMES, 'or')}, or a Family of your "
            "own."
        )
    numbers = dict(parameters)
    law, values = _law(contact, numbers)
    values["k"] = _k(disk)
    if at is not None:
        values["at"] = at
    subjects = [disk_subject(name, one) for name in FAMILY_NAMES for one in LAWS]
    start = next(s for s in subjects if s.key == f"{family} {law}")
    planes: dict[str, list[Any]] = {}
    checked = _checked(start, values)
    for subject in subjects if certify else ():
        over_k = "k" in subject.axes
        slices = [{}] if over_k else [{"k": k} for k in sorted({*CERTIFIED, checked["k"]})]
        planes[subject.key] = [certificate(subject, held) for held in slices]
    return {
        **_common(subjects, start, checked, axes), "solid": True, "certificates": planes,
        "motions": {n: disk_motion(n) for n in LAWS},
        "names": {"families": MOTIONS, "laws": LAW_NAMES, "says": {
            law: f"A thin disk, ring or hoop on a plane; {words}." for law, words in WORDS.items()
        }},
        "foot": _foot("the exact polynomials and the equations of motion of the package; numbers "
                      "are dimensionless, m = R = g = 1"),
    }  # fmt: skip


def body_page(
    family: Any, at: Any, contact: Any, body: Body, axes: Sequence[Any],
    parameters: Mapping[str, Any], *, certify: bool,
) -> dict[str, Any]:  # fmt: skip
    """Data of the page of a body of revolution: rolling and spinning, under three laws.

    Parameters
    ----------
    family, at, contact, body, parameters, certify
        As for `explore`.
    axes
        The two axes, or None for each.
    """
    if not isinstance(family, str) or family not in BODY_FAMILIES:
        raise NameUnknownError(
            f"family is {shown(family)}; of a body the page draws {listed(BODY_FAMILIES, 'and')}."
        )
    if not body.dimensionless:
        raise ParameterError(
            "body has a mass, gravity or length other than 1; the page is dimensionless: leave "
            "them out."
        )
    law, numbers = _law(contact, dict(parameters))
    mu = numbers.get("mu", 0.3)
    subjects: list[Subject] = []
    motions: dict[str, Any] = {}
    planes: dict[str, Any] = {}
    for name in BODY_FAMILIES:
        for one in BODY_LAWS:
            friction = {"mu": mu} if LAWS[one].parameters else {}
            try:
                member = body.family(name, LAWS[one](**friction))
                values = {n: float(v) for n, v in (body.given | friction).items()}
                values[member.at[0]] = 1.5 if at is None else at
                values = {n: values[n] for n in (*member.at, *member.parameters)}
                subject = own_subject(
                    member,
                    values,
                    _body_axes(member, values),
                    (),
                    {
                        "family": name,
                        "law": one,
                        "motion": one,
                        "title": f"{name}, {body.name}" if getattr(body, "name", "") else name,
                    },
                )
            except StabilityError:
                if (name, one) == (family, law):
                    raise
                continue
            subjects.append(subject)
            motions[one] = motions.get(one) or own_motion(member)
            planes[subject.key] = _proved(member, subject, values) if certify else []
    start = next((s for s in subjects if s.key == f"{family} {law}"), None)
    if start is None:
        raise NameUnknownError(f"contact is {shown(law)}; of a body the page draws "
                               f"{listed(BODY_LAWS, 'or')}.")  # fmt: skip
    return {
        **_common(subjects, start, {q.name: q.value for q in start.quantities}, axes),
        "solid": False, "certificates": planes, "motions": motions,
        "names": {"families": MOTIONS, "laws": LAW_NAMES, "says": {
            law: f"A body of revolution on a plane; {WORDS[law]}." for law in BODY_LAWS}},
        "foot": _foot("conditions that were derived exactly from the equations of motion; numbers "
                      "are dimensionless"),
    }  # fmt: skip


def own_page(
    family: Family, at: Any, axes: Sequence[Any], positive: Sequence[str],
    parameters: Mapping[str, Any], *, certify: bool,
) -> dict[str, Any]:  # fmt: skip
    """Data of the page of one family of a user's system.

    Parameters
    ----------
    family, at, positive, parameters, certify
        As for `explore`.
    axes
        The two axes, or None for each.
    """
    values = given_values(family, at, parameters)
    names = [*family.at, *family.parameters]
    if len(names) < 2:
        raise ParameterError(
            f"{family.name} has one quantity, {names[0]}; a diagram needs two: make a number of "
            "the system a parameter."
        )
    asked = [None if axis is None else (axis.name, axis.low, axis.high) for axis in axes]
    used = [a[0] for a in asked if a is not None]
    free = iter([n for n in names if n not in used])
    pair = [one or _range(next(free), values) for one in asked]
    subject = own_subject(family, values, (pair[0], pair[1]), positive)
    checked = _checked(subject, values)
    return {
        **_common([subject], subject, checked, (None, None)), "solid": False,
        "motions": {subject.model: own_motion(family)},
        "certificates": {subject.key: _proved(family, subject, checked) if certify else []},
        "names": {"families": {}, "laws": {}, "says": {
            "": "A family of a user's system, its conditions derived exactly by the package."}},
        "foot": _foot("conditions that were derived exactly from the system's equations")
        + DECIMALS * bool(subject.call["numbers"]),
    }  # fmt: skip


def _common(
    subjects: Sequence[Subject], start: Subject, values: Mapping[str, float], axes: Sequence[Any]
) -> dict[str, Any]:
    for axis in axes:
        if axis is not None and axis.name not in values:
            raise NameUnknownError(
                f"axis is {shown(axis.name)}; give {listed(list(values), 'or')}."
            )
    return {
        "format": 1, "version": __version__, "subjects": [s.told() for s in subjects],
        "start": {"subject": start.key, "values": dict(values), "axes": [
            None if a is None else [a.name, a.low, a.high] for a in axes]},
    }  # fmt: skip


def _foot(source: str) -> str:
    return f"Made by stability {__version__}. This page computes everything itself, from {source}."


def _checked(subject: Subject, values: Mapping[str, Any]) -> dict[str, float]:
    return {q.name: q.checked(values.get(q.name, q.value)) for q in subject.quantities}


def _range(name: str, values: Mapping[str, float]) -> tuple[str, float, float]:
    value = float(values[name])
    low, high = (0.0, 2 * value) if value > 0 else (2 * value, 0.0) if value < 0 else (-1.0, 1.0)
    return name, low, high


def _body_axes(family: Family, values: Mapping[str, float]) -> Any:
    """The family's quantity across, and up friction or else a number of the shape."""
    other = "mu" if "mu" in values else family.parameters[0]
    high = 3.0 if other == "mu" else min(0.9, 2 * values[other])
    return (family.at[0], *SPEEDS), (other, 0.02, high)


def _proved(family: Family, subject: Subject, values: Mapping[str, float]) -> list[Any]:
    """Proved rectangles, or none where the map of the family proves nothing."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", StabilityWarning)
            return [own_certificate(family, subject, values)]
    except StabilityError:
        return []


def axis(given: Any, which: str) -> Axis | None:
    """An axis from (name, low, high), as for a map but without a count; None for none.

    Parameters
    ----------
    given
        What the caller gave.
    which
        x or y, for the message.
    """
    if given is None:
        return None
    if isinstance(given, (list, tuple)) and len(given) == 3:
        given = (*given, 2)
    found = Axis.of(given, which)
    if found.log:
        raise ParameterError(f"{which} is logarithmic; the page draws plain axes.")
    return found


def _law(contact: Any, numbers: dict[str, Any]) -> tuple[str, dict[str, Any]]:
    """Name of the law and its dimensionless number."""
    if not numbers and contact is None:
        return Viscous.name, {}
    if not numbers and isinstance(contact, str) and contact in LAWS:
        return contact, {}
    if not numbers and isinstance(contact, type) and contact in LAWS.values():
        return str(vars(contact)["name"]), {}
    law = law_given(contact, numbers)
    if numbers:
        raise NameUnknownError(
            f"{next(iter(numbers))} is no number of the page; give at, a contact law and its mu, "
            "and disk=stability.Disk(k=...)."
        )
    if LAWS.get(getattr(law, "name", "")) is not type(law):
        raise NameUnknownError(
            f"contact is {shown(contact)}; the page draws {listed(list(LAWS), 'or')}."
        )
    numbers_of = list(law.given.values())  # c of a linear law is its dimensionless mu
    return law.name, {"mu": numbers_of[0]} if numbers_of else {}


def _k(disk: Disk | None) -> Any:
    """Inertia factor of one dimensionless disk."""
    if disk is None:
        return Disk().k
    if not isinstance(disk, Disk):
        raise ParameterError(f"disk is {shown(disk)}; give a stability.Disk.")
    if any(v != 1.0 for v in (disk.mass, disk.radius, disk.gravity) if isinstance(v, float)):
        raise ParameterError(
            "disk has a mass, radius or gravity other than 1; the page is dimensionless: give "
            "Disk(k=...) and mu in units of 1/√(gR)."
        )
    return disk.k
