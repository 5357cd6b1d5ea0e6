"""Data of a page: of the disk, of one family of a user's system; what every page shares."""

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
from ..systems.family import Family
from .certificates import certificate
from .disk_subjects import FAMILY_NAMES, WORDS, disk_motion, disk_subject
from .own_subject import (
    given_values,
    own_certificate,
    own_motion,
    own_subject,
    own_units,
    without_inputs,
)
from .subject import Subject
from .units import CURVES, PageUnits, units_of

CERTIFIED = (0.25, 0.5)
"""Values of k at which the diagrams over friction carry proved rectangles."""
LAW_NAMES = {
    "smooth": "Smooth", "viscous": "Viscous", "linear-viscous": "Linear", "rough": "Rough",
}  # fmt: skip
"""Words on the buttons."""
DECIMALS = (
    " Floats in the equations count as the decimals that were written, which "
    "st.conditions(family, decimals=True).numbers lists."
)
"""What the reader of a page learns of numbers that are not exact."""


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
    one = _disk(disk)
    units = units_of(one)
    law, values = law_of(contact, numbers, units)
    values["k"] = one.k
    subjects = [disk_subject(name, law) for name in FAMILY_NAMES for law in LAWS]
    start = next(s for s in subjects if s.key == f"{family} {law}")
    if at is not None:
        values["at"] = units.plain(start.quantities[0], start.quantities[0].checked(at))
    planes: dict[str, list[Any]] = {}
    checked = _checked(start, values)
    for subject in subjects if certify else ():
        over_k = "k" in subject.axes
        slices = [{}] if over_k else [{"k": k} for k in sorted({*CERTIFIED, checked["k"]})]
        planes[subject.key] = [certificate(subject, held) for held in slices]
    return {
        **common(subjects, start, checked, axes, units), "solid": True, "certificates": planes,
        "motions": {n: disk_motion(n) for n in LAWS},
        "names": {
            "families": {n: n.capitalize() for n in FAMILY_NAMES}, "laws": LAW_NAMES,
            "says": {law: f"A thin disk, ring or hoop on a plane; {words}."
                     for law, words in WORDS.items()},
        },
        "foot": foot("the exact polynomials and the equations of motion of the package", units),
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
    family, values, zeros = without_inputs(family, given_values(family, at, parameters))
    names = [*family.at, *family.parameters]
    if len(names) < 2:
        raise ParameterError(
            f"{family.name} has {f'one quantity, {names[0]}' if names else 'no quantity'}; a "
            "diagram needs two: make a number of the system a parameter."
        )
    asked = [None if axis is None else (axis.name, axis.low, axis.high) for axis in axes]
    used = [a[0] for a in asked if a is not None]
    free = iter([n for n in names if n not in used])
    pair = [one or _range(next(free), values) for one in asked]
    subject = own_subject(family, values, (pair[0], pair[1]), positive, zeros=zeros)
    checked = _checked(subject, values)
    if subject.solver:  # an error says why there is no member to start from
        family.member([checked[n] for n in family.at], [checked[n] for n in family.parameters])
    return {
        **common([subject], subject, checked, axes), "units": own_units(family), "solid": False,
        "motions": {subject.model: own_motion(family)},
        "certificates": {subject.key: proved(family, subject, checked) if certify else []},
        "names": {"families": {}, "laws": {}, "says": {
            "": "A family of a user's system, its conditions derived exactly by the package."}},
        "foot": foot("conditions that were derived exactly from the system's equations"
                     + f" where {', '.join(f'{n} = 0' for n in zeros)}" * bool(zeros))
        + DECIMALS * bool(subject.call["numbers"]),
    }  # fmt: skip


def common(
    subjects: Sequence[Subject], start: Subject, values: Mapping[str, float], axes: Sequence[Any],
    units: PageUnits | None = None,
) -> dict[str, Any]:  # fmt: skip
    """What every page has: its subjects, and what is shown at first.

    Parameters
    ----------
    subjects, start
        Every subject, and the one at first.
    values
        Values of its quantities.
    axes
        The two axes, or None for each.
    units
        Units of a body; None for a system of one's own.
    """
    size = {q.name: units.sizes[q.kind] if units else 1.0 for q in start.quantities}
    for axis in axes:
        if axis is not None and axis.name not in values:
            raise NameUnknownError(
                f"axis is {shown(axis.name)}; give {listed(list(values), 'or')}."
            )
    return {
        "format": 1, "version": __version__, "subjects": [s.told() for s in subjects],
        "start": {"subject": start.key, "values": dict(values), "axes": [
            None if a is None else told_axis(a, size[a.name]) for a in axes]},
        "units": {n: kind.words for n, kind in CURVES.items()},
        "si": units.told() if units else {}, "kinds": {n: k.name for n, k in CURVES.items()},
    }  # fmt: skip


def told_axis(axis: Axis, size: float = 1.0) -> list[Any]:
    """Name, ends and spacing of an axis in the page.

    Parameters
    ----------
    axis
        The axis.
    size
        Size of its unit, in the units of the axis.
    """
    return [axis.name, axis.low / size, axis.high / size, *["log"] * axis.log]


PROOFS = (
    "Float: computed in floating point, without a proof. Proved in this page: at this point the "
    "signs of the conditions exceed their rounding errors. Certified by the package: the verdict "
    "holds on a whole rectangle, by exact arithmetic."
)
"""What the words on a page say of numbers and verdicts."""


def foot(source: str, units: PageUnits | None = None) -> str:
    """The last line of a page.

    Parameters
    ----------
    source
        What the page computes from.
    units
        Units of a body; None for a system of one's own.
    """
    made = f"Made by stability {__version__}. This page computes everything itself, from {source}"
    words = f"{PROOFS} {made}"
    if units is None:
        return f"{words}."
    if units.dimensionless:
        where = ", R the length of the body" if units.length == "length" else ""
        return f"{words}; numbers are dimensionless, m = R = g = 1{where}."
    return f"{words}, without dimension (m = R = g = 1), and shows SI units for {units.body}."


def _checked(subject: Subject, values: Mapping[str, Any]) -> dict[str, float]:
    return {q.name: q.checked(values.get(q.name, q.value)) for q in subject.quantities}


def _range(name: str, values: Mapping[str, float]) -> tuple[str, float, float]:
    value = float(values[name])
    low, high = (0.0, 2 * value) if value > 0 else (2 * value, 0.0) if value < 0 else (-1.0, 1.0)
    return name, low, high


def proved(family: Family, subject: Subject, values: Mapping[str, float]) -> list[Any]:
    """Proved rectangles, or none where the map of the family proves nothing."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", StabilityWarning)
            return [own_certificate(family, subject, values)]
    except StabilityError:
        return []


def axis(given: Any, which: str) -> Axis | None:
    """An axis from (name, low, high) and perhaps "log", as of a map without its count.

    Parameters
    ----------
    given
        What the caller gave.
    which
        x or y, for the message.
    """
    if given is None:
        return None
    if not isinstance(given, (list, tuple)) or len(given) not in (3, 4):
        raise ParameterError(
            f"{which} is {shown(given)}; give (name, low, high) or (name, low, high, 'log')."
        )
    return Axis.of((*given[:3], 2, *given[3:]), which)


def law_of(
    contact: Any, numbers: dict[str, Any], units: PageUnits
) -> tuple[str, dict[str, Any]]:  # fmt: skip
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
    return law.name, law.arguments(law.given, units.units)


def _disk(disk: Disk | None) -> Disk:
    """The disk, or an error that says what to give."""
    if disk is None:
        return Disk()
    if not isinstance(disk, Disk):
        raise ParameterError(f"disk is {shown(disk)}; give a stability.Disk.")
    return disk
