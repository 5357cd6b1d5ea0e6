"""Data of a page, from its subjects: what is shown at first, units, buttons and words."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from ..base.axis import Axis
from ..base.errors import NameUnknownError, ParameterError, listed, shown
from ..base.version import __version__
from ..bodies.contact_laws import LAWS, Viscous
from ..bodies.law_names import law_given
from .subject import Subject
from .units import CURVES, PageUnits

LAW_NAMES = {
    "smooth": "Smooth",
    "viscous": "Viscous",
    "linear-viscous": "Linear",
    "rough": "Rough",
}
"""Words on the buttons."""
FRICTION = 0.02, 3.0, 0.3
"""Range of a coefficient of friction on the page, dimensionless, and its value at first."""
WORDS = {
    "smooth": "no friction",
    "viscous": "viscous friction, −μ\u00a0N\u00a0v",
    "linear-viscous": "linear viscous friction, −c\u00a0v",
    "rough": "no slip",
}
"""Each law in words."""
PROOFS = (
    "Float: computed in floating point, without a proof. Proved in this page: at this point the "
    "signs of the conditions exceed their rounding errors. Certified by the package: the verdict "
    "holds on a whole rectangle, by exact arithmetic."
)
"""What the words on a page say of numbers and verdicts."""


def page_data(
    subjects: Sequence[Subject],
    start: Subject,
    given: Mapping[str, Any],
    axes: Sequence[Any],
    *,
    motions: Mapping[str, Any],
    certificates: Mapping[str, list[Any]],
    source: str,
    families: Mapping[str, str],
    says: str,
    units: PageUnits | None = None,
    stated: Mapping[str, str] | None = None,
    more: str = "",
) -> dict[str, Any]:
    """Data of a page.

    Parameters
    ----------
    subjects, start
        Every subject, and the one at first.
    given
        Values of its quantities, where they are not those that it has by itself.
    axes
        The two axes, or None for each.
    motions
        Equations of launches by `Subject.model`.
    certificates
        Proved rectangles by the key of a subject.
    source
        What the page computes from, in words.
    families
        Word on each family's button.
    says
        What moves, in words.
    units
        Units of a body; None for a system of one's own.
    stated
        Units that such a system states, by the names of times, rates and curves.
    more
        Further sentences of the last line.
    """
    values = {n: q.checked(given.get(n, q.value)) for n, q in start.called.items()}
    for axis_ in axes:
        if axis_ is not None and axis_.name not in values:
            raise NameUnknownError(
                f"axis is {shown(axis_.name)}; give {listed(list(values), 'or')}."
            )
    sizes = {n: units.sizes[q.kind] if units else 1.0 for n, q in start.called.items()}
    laws = dict.fromkeys(s.law for s in subjects)
    return {
        "format": 1,
        "version": __version__,
        "subjects": [s.record for s in subjects],
        "start": {
            "subject": start.key,
            "values": values,
            "axes": [None if a is None else told_axis(a, sizes[a.name]) for a in axes],
        },
        "units": {n: kind.words for n, kind in CURVES.items()} if stated is None else stated,
        "si": units.told() if units else {},
        "kinds": {n: k.name for n, k in CURVES.items()},
        "solid": bool(start.body),
        "motions": motions,
        "certificates": certificates,
        "names": {
            "families": families,
            "laws": {law: LAW_NAMES[law] for law in laws if law},
            "says": {law: f"{says}; {WORDS[law]}." if law else f"{says}." for law in laws},
        },
        "foot": foot(source, units) + more,
    }


def told_axis(axis: Axis, size: float = 1.0) -> list[Any]:
    """Name, ends and spacing of an axis in the page, whose unit has a size."""
    return [axis.name, axis.low / size, axis.high / size, *["log"] * axis.log]


def foot(source: str, units: PageUnits | None = None) -> str:
    """The last line of a page."""
    made = f"Made by stability {__version__}. This page computes everything itself, from {source}"
    words = f"{PROOFS} {made}"
    if units is None:
        return f"{words}."
    if units.dimensionless:
        where = ", R the length of the body" if units.length == "length" else ""
        return f"{words}; numbers are dimensionless, m = R = g = 1{where}."
    return f"{words}, without dimension (m = R = g = 1), and shows SI units for {units.body}."


def axis(given: Any, which: str) -> Axis | None:
    """An axis from (name, low, high) and perhaps "log", as of a map without its count."""
    if given is None:
        return None
    if not isinstance(given, (list, tuple)) or len(given) not in (3, 4):
        raise ParameterError(
            f"{which} is {shown(given)}; give (name, low, high) or (name, low, high, 'log')."
        )
    return Axis.of((*given[:3], 2, *given[3:]), which)


def law_of(contact: Any, numbers: dict[str, Any], units: PageUnits) -> tuple[str, dict[str, Any]]:
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
