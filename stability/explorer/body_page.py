"""Data of the page of a body of revolution: its families under three laws."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..base.checks import one_number
from ..base.errors import NameUnknownError, ParameterError, StabilityError, listed, shown
from ..base.quantities import Kind
from ..base.quantities import Quantity as Known
from ..bodies.contact_laws import LAWS
from ..bodies.families import FAMILIES
from ..bodies.round_body.body import Body
from ..bodies.round_body.inclinations import tumbling_ranges
from ..bodies.round_body.pole_equations import smooth_at
from ..bodies.round_body.shape import refuse_constants
from ..bodies.round_body.shapes import named
from .certificates import own_certificates
from .motion import (
    body_of,
    launch_model,
    meridian,
    motion_of,
    start_along_axes,
    through_poles,
)
from .page import FRICTION, LAW_NAMES, law_of, page_data, shared
from .quantities import PageUnits, Quantity, units_of, without_scales
from .subject import Subject
from .verdicts import closed_formulas, derived_formulas

LAW_KEYS = ("smooth", "viscous", "rough")
"""Laws of the page."""
SPEEDS = (0.05, 5.0)
"""Range of angular velocities [√(g/R)]."""
FIRST = {"rolling": 1.5, "spinning": 1.5, "vertical": 2.0}
"""Member that is shown at first; of tumbling the middle of its range."""
MOST = 720_000
"""Largest size of families and motions [bytes]; a page of 1.5 MB has the library and proofs too."""


@dataclass(frozen=True)
class Shown:
    """A family on the page."""

    key: str
    """Name in links."""
    name: str
    """Name of the family in calls."""
    button: str
    """Word on its button."""
    pole: int = 0
    """1 or -1 for vertical spin at θ = 0 or π."""
    theta: float | None = None
    """Inclination near that of rolling, where one is given."""

    @property
    def choice(self) -> dict[str, Any]:
        """The pole or the inclination as an argument of calls."""
        if self.theta is not None:
            return {"theta": self.theta}
        return {} if not self.pole else {"pole": 0 if self.pole == 1 else "pi"}


def _families(body: Body, near: float | None) -> list[Shown]:
    """Every family that one number names; vertical spin at π only where it is another motion."""
    known = [Shown("rolling", "rolling", "Rolling", 0, near)]
    known += [Shown(n, n, n.capitalize()) for n in ("spinning", "tumbling")]
    theta = np.linspace(0.3, 1.2, 4)
    both = smooth_at(body, 1) and smooth_at(body, -1)
    if both and np.allclose(body.height_at(theta), body.height_at(math.pi - theta), rtol=1e-13):
        return [*known, Shown("vertical", "vertical", "Vertical", 1)]
    return [
        *known,
        Shown("vertical", "vertical", "Vertical, θ = 0", 1),
        Shown("vertical-pi", "vertical", "Vertical, θ = π", -1),
    ]


def body_page(
    family: Any,
    at: Any,
    contact: Any,
    body: Body,
    axes: Sequence[Any],
    parameters: Mapping[str, Any],
    *,
    certify: bool,
    pole: Any = None,
    theta: Any = None,
) -> dict[str, Any]:
    """Data of the page of a body of revolution."""
    refuse_constants(body, [axis.name for axis in axes if axis is not None])
    families = _families(body, None if theta is None else one_number("theta", theta))
    names = list(dict.fromkeys(f.name for f in families))
    if not isinstance(family, str) or family not in names:
        raise NameUnknownError(
            f"family is {shown(family)}; of a body the page draws {listed(names, 'or')}."
        )
    units, body = units_of(body), without_scales(body)
    law, numbers = law_of(contact, dict(parameters), units)
    if law not in LAW_KEYS:
        raise NameUnknownError(
            f"contact is {shown(law)}; of a body the page draws {listed(LAW_KEYS, 'or')}."
        )
    mu = numbers.get("mu", FRICTION[2])
    first = _chosen(families, family, pole)
    if theta is not None and first.theta is None:
        raise ParameterError(f"theta chooses where a body rolls; leave it out for {family}.")
    subjects: list[Subject] = []
    for one in families:
        for name in LAW_KEYS:
            try:
                subjects.append(_subject(body, one, name, mu, at if one == first else None, units))
            except StabilityError:
                if one == first and name == law:
                    raise
    motions = {n: motion_of(launch_model(body, n), solid=True) for n in LAW_KEYS}
    [start] = [s for s in subjects if s.key == f"{first.key} {law}"]
    kept = _fitting(subjects, motions, start)
    left = _left_out(families, subjects, kept, first)
    return page_data(
        kept,
        start,
        {},
        axes,
        units=units,
        more=left,
        motions={s.law: motions[s.law] for s in kept},
        certificates={s.key: own_certificates(s) if certify else [] for s in kept},
        families={f.key: f.button for f in families},
        says="A body of revolution on a plane",
        source="polynomials that were derived exactly from the equations of motion",
    )


def _fitting(
    subjects: Sequence[Subject], motions: Mapping[str, Any], first: Subject
) -> list[Subject]:
    """What fits into the size of a page: that asked for, its other laws, then whole families."""
    groups: dict[str, list[Subject]] = {first.key: [first]}
    for one in subjects:
        if one is not first:
            group = one.key if one.button == first.button else one.button
            groups.setdefault(group, []).append(one)
    kept: list[Subject] = []
    for some in groups.values():
        more = [*kept, *some]
        told = {
            "subjects": [s.record for s in more],
            "motions": {s.law: motions[s.law] for s in more},
        }
        if not kept or len(json.dumps(shared(told))) < MOST:
            kept = more
    return [s for s in subjects if s in kept]


def _left_out(
    families: Sequence[Shown], subjects: Sequence[Subject], kept: Sequence[Subject], first: Shown
) -> str:
    """The sentence that names the families and laws without room on the page."""
    gone = [s for s in subjects if s not in kept]
    laws = [LAW_NAMES[s.law] for s in gone if s.button == first.key]
    names = {s.button for s in gone} - {first.key}
    words = [f.button for f in families if f.key in names]
    words += [f"{first.button} ({law.lower()})" for law in laws]
    if not words:
        return ""
    return f" Left out for size: {listed(words)}; name the family and the contact law to have it."


def _chosen(families: Sequence[Shown], name: str, pole: Any) -> Shown:
    """The family with a name and pole."""
    if name != "vertical" and pole is not None:
        raise ParameterError(f"pole belongs to vertical spin; leave it out for {name}.")
    wanted = {None: 1, 0: 1, "pi": -1}.get(pole if isinstance(pole, (int, str)) else None)
    if wanted is None or (pole is not None and not isinstance(pole, (int, str))):
        raise ParameterError(f"pole is {shown(pole)}; give 0 or 'pi'.")
    found = [f for f in families if f.name == name]
    return next((f for f in found if f.pole == wanted), found[0])


def _subject(body: Body, one: Shown, law: str, mu: float, at: Any, units: PageUnits) -> Subject:
    """A family under a law."""
    family = body.family(one.name, law, **one.choice)
    numbers = body.given | {p.name: mu for p in LAWS[law].parameters}
    low, high, value = _range(body, one)
    first = _member(body, family.system.quantities[family.at[0]], low, high, value)
    if at is not None:
        first = replace(first, value=units.plain(first, first.checked(at)))
    quantities = {first.name: first}
    for name in family.parameters:
        quantities[name] = _number(body, family.system.quantities[name], float(numbers[name]))
    derive = derived_formulas if family.formulas is None else closed_formulas
    formulas = derive(family, quantities)
    if formulas.solver:
        raise StabilityError(
            f"{family.name}: {', '.join(family.unknown)} of its members is solved for; of a body "
            "the page draws families whose members are known in closed form."
        )
    start = (
        start_along_axes(family, formulas, launch_model(body, law), one.pole)
        if through_poles(body)
        else ""
    )
    return Subject(
        key=f"{one.key} {law}",
        family=family,
        button=one.key,
        law=law,
        title=f"{body.name}: {FAMILIES[one.name].motion}",
        quantities=quantities,
        axes=(first.name, "mu" if "mu" in quantities else family.parameters[0]),
        formulas=formulas,
        model=law,
        call={
            "what": "body",
            "made": _made(body),
            "name": body.name,
            "family": one.name,
            "law": law,
            "class": LAWS[law].__name__,
            "si": {},
            "pole": one.choice.get("pole"),
            "theta": one.theta,
            "state": "" if through_poles(body) else first.name,
        },
        symbols={n: q.symbol for n, q in family.system.quantities.items()},
        body=body_of(body, family, one.pole) | {"meridian": meridian(body, family), "start": start},
    )


def _range(body: Body, one: Shown) -> tuple[float, float, float]:
    """Range of the number that names a member, and the one that is shown at first."""
    if one.name != "tumbling":
        return *SPEEDS, FIRST[one.name]
    ranges = tumbling_ranges(body)
    widest = max((b - a for a, b in ranges), default=0.0)
    low, high = next((r for r in ranges if r[1] - r[0] > 0.8 * widest), body.between)
    room = 0.01 * (high - low)
    return round(low + room, 3), round(high - room, 3), round((low + high) / 2, 2)


def _member(body: Body, known: Known, low: float, high: float, value: float) -> Quantity:
    """The number that names a member."""
    ends: dict[str, Any] = {}
    if known.kind is Kind.ANGLE:
        ends = dict(zip(("least", "most"), body.between, strict=True))
    return Quantity.of(known, low, high, value, **ends)


def _number(body: Body, known: Known, value: float) -> Quantity:
    """A coefficient of friction, or a number of the body."""
    if known.name == "mu":
        return Quantity.of(known, *FRICTION[:2], value, least=0.0)
    least, most = body.limits.get(known.name, (0.0, math.inf))
    high = min(2.0 * value if value > 0 else 1.0, most)
    return Quantity.of(
        known,
        max(least, 0.0) + 0.02 * high,
        high,
        value,
        unit="m R²" if known.name in ("axial", "transverse") else "R",
        least=least if math.isfinite(least) else None,
        most=float(np.nextafter(most, math.inf)) if math.isfinite(most) else None,
    )


def _made(body: Body) -> str:
    """How Python makes the body, with a place for each number; empty for one of the user's own."""
    make = named.NAMED.get(body.name.replace(" ", "-"))
    numbers = {n: v for n, v in body.given.items() if n not in ("mass", "gravity", "length")}
    places = [f"{n}={{{n}}}" for n in numbers]
    if make is None:
        return ""
    for more in ({}, {"solid": False}):
        with suppress(TypeError, StabilityError):
            same = make(**numbers, **more)
            if same.moments() == body.moments() and same.name == body.name:
                given = [*places, *(f"{n}={v}" for n, v in more.items())]
                return f"st.{make.__name__}({', '.join(given)})"
    return ""
