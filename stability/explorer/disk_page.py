"""The page of the disk: every family under every stored law."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from ..base.axis import Axis
from ..base.errors import NameUnknownError, ParameterError, listed, shown
from ..bodies.contact_laws import LAWS
from ..bodies.disk import Disk
from ..bodies.disk_polynomials import known_polynomial, stored_laws
from ..bodies.families import FAMILIES
from ..bodies.quantities import QUANTITIES
from ..bodies.round_body.thin import thin_body
from ..bodies.thin_disk import disk_family, disk_model
from ..spectra.arguments import prepare
from ..spectra.problem import Problem
from .certificates import certificate
from .motion import body_of, motion_of
from .page import FRICTION, law_of, page_data
from .quantities import Quantity, units_of
from .subject import Subject
from .verdicts import stored_formulas

FAMILY_NAMES = tuple(f.name for f in FAMILIES.values() if f.drawn)
"""Families of the page, which one number names."""
STARTS = {"rolling": 1.2, "spinning": 2.2, "tumbling": 0.9}
"""Member that is shown at first, dimensionless."""
INERTIA = 0.05, 0.5, 0.25
"""Range of k on the page, and its value at first."""
BODIES = ((0.25, "uniform disk"), (0.3125, "ring, inner radius R/2"), (0.5, "hoop"))
"""Values of k with a name."""
CERTIFIED = (0.25, 0.5)
"""Values of k at which the diagrams over friction carry proved rectangles."""
LEVELS = 7
"""Halvings of a diagram in both directions for proved rectangles."""


def disk_page(
    family: Any,
    at: Any,
    contact: Any,
    disk: Disk | None,
    axes: Sequence[Any],
    parameters: Mapping[str, Any],
    *,
    certify: bool,
) -> dict[str, Any]:
    """Data of the page of the disk."""
    if not isinstance(family, str) or family not in FAMILY_NAMES:
        raise NameUnknownError(
            f"family is {shown(family)}; give {listed(FAMILY_NAMES, 'or')}, or a Family of your "
            "own."
        )
    if not isinstance(disk, Disk | None):
        raise ParameterError(f"disk is {shown(disk)}; give a stability.Disk.")
    disk = disk or Disk()
    units = units_of(disk)
    law, values = law_of(contact, dict(parameters), units)
    laws = stored_laws()
    stored = [(n, word) for n in FAMILY_NAMES for word in laws if known_polynomial(n, word)]
    if (family, law) not in stored:
        raise NameUnknownError(
            f"{family} under the {law} law has no stored polynomial; the page draws "
            f"{listed(laws, 'or')}, each with the families that have one."
        )
    subjects = {pair: disk_subject(*pair) for pair in stored}
    start = subjects[family, law]
    values["k"] = start.quantities["k"].checked(disk.k)
    if at is not None:
        first = start.called["at"]
        values["at"] = units.plain(first, first.checked(at))
    return page_data(
        list(subjects.values()),
        start,
        values,
        axes,
        units=units,
        motions={n: motion_of(disk_model(n, pose=True), solid=True) for n in laws},
        certificates={s.key: _certificates(s, values["k"]) for s in subjects.values() if certify},
        families={n: n.capitalize() for n in FAMILY_NAMES},
        says="A thin disk, ring or hoop on a plane",
        source="the exact polynomials and the equations of motion of the package",
    )


def disk_subject(name: str, law: str) -> Subject:
    """One of the disk's families under a stored law.

    Examples
    --------
    >>> [(rule.text, rule.filled) for rule in disk_subject("rolling", "viscous").formulas.rules]
    [('2<i>k</i><i>ω₃</i><sup>2</sup> − 1', '2 · {k} · {at}<sup>2</sup> − 1')]
    """
    record, family = FAMILIES[name], disk_family(name, law)
    state = QUANTITIES[record.at[0]]
    low, high = record.drawn or (0.02, 3.0)
    ends: dict[str, Any] = {}
    if record.by_angle:
        high, ends = round(high, 2), {"least": 0.0, "most": math.pi}
    first = STARTS.get(name, (low + high) / 2)
    quantities = {state.name: Quantity.of(state, low, high, first, name="at", **ends)}
    renamed = {}
    for number in LAWS[law].parameters[:1]:
        renamed = {number.place: number.name} if number.name != number.place else {}
        coefficient = replace(QUANTITIES[number.name], long_name=QUANTITIES["mu"].long_name)
        quantities[number.place] = Quantity.of(coefficient, *FRICTION, name="mu", least=0.0)
    quantities["k"] = Quantity.of(
        QUANTITIES["k"], *INERTIA, unit="m R²", least=0.0, most=0.5 + 1e-12, marks=BODIES
    )
    return Subject(
        key=f"{name} {law}",
        family=family,
        law=law,
        title=record.disk_motion,
        quantities=quantities,
        axes=("at", "mu" if "mu" in quantities else "k"),
        formulas=stored_formulas(family, law, quantities),
        model=law,
        call={
            "what": "disk",
            "made": "st.Disk(k={k})",
            "family": name,
            "law": law,
            "class": LAWS[law].__name__,
            "si": renamed,
            "pole": None,
            "theta": None,
            "state": state.name,
        },
        symbols={n: q.symbol for n, q in QUANTITIES.items()},
        body=body_of(thin_body(Disk()), family),
    )


def _certificates(subject: Subject, k: float) -> list[Any]:
    """Proved rectangles of a family at some inertia factors, or over all of them."""

    def problem(axes: list[Axis], held: dict[str, float]) -> Problem:
        disk = Disk(k=held["k"]) if "k" in held else None
        return prepare(subject.family.name, axes, disk, subject.law, None, {})

    slices = [{}] if "k" in subject.axes else [{"k": v} for v in sorted({*CERTIFIED, k})]
    return [certificate(subject, held, LEVELS, problem) for held in slices]
