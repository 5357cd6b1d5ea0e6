"""The page of the disk or of another body of revolution: its families under its laws."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..base.axis import Axis
from ..base.checks import one_number
from ..base.errors import NameUnknownError, ParameterError, StabilityError, listed, shown
from ..base.quantities import Kind
from ..bodies.contact_laws import LAWS, Viscous, law_given
from ..bodies.disk import Disk
from ..bodies.disk_polynomials import stored_laws
from ..bodies.families import FAMILIES
from ..bodies.quantities import QUANTITIES
from ..bodies.round_body.body import Body
from ..bodies.round_body.inclinations import tumbling_ranges
from ..bodies.round_body.pole_equations import smooth_at
from ..bodies.round_body.shape import RoundShape, refuse_constants
from ..bodies.round_body.shapes import named
from ..bodies.round_body.thin import unit_disk
from ..bodies.subject import disk_family
from ..spectra.axes import swept
from ..spectra.problem import Problem
from ..systems.family import Family
from .certificates import certificate, own_certificates
from .formulas import PageFormulas
from .motion import body_of, launch_model, meridian, motion_of, start_along_axes, through_poles
from .page import LAW_NAMES, Contents, shared
from .quantities import PageQuantity, PageUnits
from .subject import PageSubject
from .verdicts import closed_formulas, derived_formulas, stored_formulas

FRICTION = 0.02, 3.0, 0.3
"""Range of a coefficient of friction on the page, dimensionless, and its value at first."""
MOST = 720_000
"""Largest size of families and motions [bytes]; a page of 1.5 MB has the library and proofs too."""


@dataclass(frozen=True)
class PageFamily:
    """A family on the page; of a body, vertical spin on either pole."""

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
    def arguments(self) -> dict[str, Any]:
        """The pole or the inclination as an argument of calls."""
        if self.theta is not None:
            return {"theta": self.theta}
        return {} if not self.pole else {"pole": 0 if self.pole == 1 else "pi"}


class _PageBody:
    """A body: its families under three laws, by polynomials that are derived or have its height."""

    argument = "body"
    """Name of the body in calls."""
    laws: tuple[str, ...] = ("smooth", "viscous", "rough")
    """Laws of the page."""
    says = "A body of revolution"
    """The body, in words."""
    computed_from = "polynomials that were derived exactly from the equations of motion"
    """What the page computes from, in words."""
    title = "{} of a body"
    """Title of the page, with a place for the family."""
    choices: Sequence[PageFamily]
    """Families of the page."""
    friction = FRICTION[2]
    """Coefficient of friction at first, dimensionless."""
    called_at = ""
    """Name in calls of what names a member; the name of its state where empty."""
    first: Mapping[str, float] = {"rolling": 1.5, "spinning": 1.5, "vertical": 2.0}
    """Member that is shown at first; of tumbling the middle of its range."""
    speeds = 0.05, 5.0
    """Range of angular velocities [√(g/R)]."""

    def __init__(self, body: Body, theta: Any = None) -> None:
        self.units = PageUnits.of(body, "length")
        if not body.dimensionless:
            body = replace(body, mass=1.0, gravity=1.0, length=1.0)
        self.shape: RoundShape = body
        """The body without dimension."""
        self.body = body
        self.made = _made(body)
        """How Python makes it, with a place for each number; empty for one of the user's own."""
        near = None if theta is None else one_number("theta", theta)
        self.choices = [
            PageFamily("rolling", "rolling", "Rolling", theta=near),
            PageFamily("spinning", "spinning", "Spinning"),
            PageFamily("tumbling", "tumbling", "Tumbling"),
            *self._vertical(),
        ]

    def _vertical(self) -> list[PageFamily]:
        """Vertical spin, at θ = π too where it is another motion there."""
        theta = np.linspace(0.3, 1.2, 4)
        height, turned = (self.body.height_at(t) for t in (theta, math.pi - theta))
        both = smooth_at(self.body, 1) and smooth_at(self.body, -1)
        if both and np.allclose(height, turned, rtol=1e-13):
            return [PageFamily("vertical", "vertical", "Vertical", 1)]
        return [
            PageFamily("vertical", "vertical", "Vertical, θ = 0", 1),
            PageFamily("vertical-pi", "vertical", "Vertical, θ = π", -1),
        ]

    def motion(self, name: str) -> str:
        """The motion of a family in words."""
        return f"{self.body.name}: {FAMILIES[name].motion}"

    def family(self, choice: PageFamily, law: str) -> Family:
        """A family under a law."""
        return self.body.family(choice.name, law, **choice.arguments)

    def members(self, name: str) -> tuple[float, float, float]:
        """Usual speeds; of tumbling the first wide range of its inclinations."""
        if name != "tumbling":
            return *self.speeds, self.first[name]
        ranges = tumbling_ranges(self.body)
        widest = max((b - a for a, b in ranges), default=0.0)
        low, high = next((r for r in ranges if r[1] - r[0] > 0.8 * widest), self.body.between)
        room = 0.01 * (high - low)
        return round(low + room, 3), round(high - room, 3), round((low + high) / 2, 2)

    def numbers(self, family: Family, law: str) -> dict[str, PageQuantity]:  # noqa: ARG002
        """The numbers of the law and of the body, by their names in the family."""
        return {name: self._number(family, name) for name in family.parameters}

    def _number(self, family: Family, name: str) -> PageQuantity:
        """A coefficient of friction, or a number of the body."""
        quantity = family.system.quantities[name]
        if name == "mu":
            return PageQuantity.of(quantity, *FRICTION[:2], self.friction, least=0.0)
        value = float(self.body.given[name])
        least, most = self.body.limits.get(name, (0.0, math.inf))
        high = min(2.0 * value if value > 0 else 1.0, most)
        return PageQuantity.of(
            quantity,
            max(least, 0.0) + 0.02 * high,
            high,
            value,
            unit="m R²" if name in ("axial", "transverse") else "R",
            least=least if math.isfinite(least) else None,
            most=float(np.nextafter(most, math.inf)) if math.isfinite(most) else None,
        )

    def formulas(
        self,
        family: Family,
        law: str,  # noqa: ARG002
        quantities: Mapping[str, PageQuantity],
    ) -> PageFormulas:
        """What decides the verdict."""
        derive = derived_formulas if family.formulas is None else closed_formulas
        formulas = derive(family, quantities)
        if formulas.solver:
            raise StabilityError(
                f"{family.name}: {', '.join(family.unknown)} of its members is solved for; of a "
                "body the page draws families whose members are known in closed form."
            )
        return formulas

    def surface(self, family: Family) -> dict[str, Any]:
        """The surface that is drawn."""
        return {"meridian": meridian(self.body, family)}

    def certificates(self, subject: PageSubject) -> list[Any]:
        """Proved rectangles of a subject."""
        return own_certificates(subject)

    def subject(self, choice: PageFamily, law: str, at: Any = None) -> PageSubject:
        """A family under a law, with its member at first."""
        family = self.family(choice, law)
        state = family.system.quantities[family.at[0]]
        ends: dict[str, Any] = {}
        if state.kind is Kind.ANGLE:
            ends = dict(zip(("least", "most"), self.shape.between, strict=True))
        first = PageQuantity.of(state, *self.members(choice.name), name=self.called_at, **ends)
        if at is not None:
            first = replace(first, value=self.units.plain(first, first.checked(at)))
        quantities = {state.name: first, **self.numbers(family, law)}
        formulas = self.formulas(family, law, quantities)
        poles, start = through_poles(self.shape), ""
        if poles:
            start = start_along_axes(family, formulas, launch_model(self.shape, law), choice.pole)
        names = [q.name for q in quantities.values()]
        return PageSubject(
            key=f"{choice.key} {law}",
            family=family,
            button=choice.key,
            law=law,
            title=self.motion(choice.name),
            quantities=quantities,
            axes=(names[0], "mu" if "mu" in names else names[1]),
            formulas=formulas,
            model=law,
            call={
                "what": self.argument,
                "made": self.made,
                "name": self.shape.name,
                "family": choice.name,
                "law": law,
                "class": LAWS[law].__name__,
                "si": {p.place: p.name for p in LAWS[law].parameters if p.name != p.place},
                "pole": choice.arguments.get("pole"),
                "theta": choice.theta,
                "state": "" if poles else state.name,
            },
            symbols={n: q.symbol for n, q in family.system.quantities.items()},
            body={
                **body_of(self.shape, family, choice.pole),
                **self.surface(family),
                "start": start,
            },
        )


class _Disk(_PageBody):
    """The disk: its families under every stored law, by the stored polynomials."""

    argument = "disk"
    says = "A thin disk, ring or hoop"
    computed_from = "the exact polynomials and the equations of motion of the package"
    title = "Steady motions of a disk"
    called_at = "at"
    choices = tuple(PageFamily(n, n, n.capitalize()) for n, f in FAMILIES.items() if f.drawn)
    first = {"rolling": 1.2, "spinning": 2.2, "tumbling": 0.9}
    inertia = PageQuantity.of(
        QUANTITIES["k"],
        *(0.05, 0.5, 0.25),
        unit="",
        least=0.0,
        most=0.5 + 1e-12,
        marks=((0.25, "uniform disk"), (0.3125, "ring, inner radius R/2"), (0.5, "hoop")),
    )
    """The inertia factor."""
    certified = 0.25, 0.5
    """Values of k at which the diagrams over friction carry proved rectangles."""
    levels = 7
    """Halvings of a diagram in both directions for proved rectangles."""

    def __init__(self, disk: Disk) -> None:
        self.laws = tuple(stored_laws())
        self.units = PageUnits.of(disk, "radius")
        self.k = self.inertia.at(disk.k)
        self.shape = unit_disk()
        self.made = "st.Disk(k={k})"

    def motion(self, name: str) -> str:
        return FAMILIES[name].disk_motion

    def family(self, choice: PageFamily, law: str) -> Family:
        return disk_family(choice.name, law)

    def members(self, name: str) -> tuple[float, float, float]:
        record = FAMILIES[name]
        low, high = record.drawn or (0.0, 1.0)
        return (
            low,
            round(high, 2) if record.by_angle else high,
            self.first.get(name, (low + high) / 2),
        )

    def numbers(self, family: Family, law: str) -> dict[str, PageQuantity]:  # noqa: ARG002
        """Friction, in words that are the same for every law, and the inertia factor."""
        quantities = {}
        for number in LAWS[law].parameters[:1]:
            coefficient = replace(QUANTITIES[number.name], long_name=QUANTITIES["mu"].long_name)
            quantities[number.place] = PageQuantity.of(
                coefficient, *FRICTION[:2], self.friction, name="mu", least=0.0
            )
        return quantities | {"k": self.k}

    def formulas(
        self, family: Family, law: str, quantities: Mapping[str, PageQuantity]
    ) -> PageFormulas:
        return stored_formulas(family, law, quantities)

    def certificates(self, subject: PageSubject) -> list[Any]:
        def problem(axes: list[Axis], held: dict[str, float]) -> Problem:
            disk = Disk(k=held["k"]) if "k" in held else None
            called = {a.name: a for a in axes}
            return swept(subject.family.name, called, disk, contact=subject.law)[0]

        factors = sorted({*self.certified, self.k.value})
        slices = [{}] if "k" in subject.axes else [{"k": k} for k in factors]
        return [certificate(subject, held, self.levels, problem) for held in slices]

    def surface(self, family: Family) -> dict[str, Any]:  # noqa: ARG002
        return {}  # a disk is drawn by its k


def _made(body: Body) -> str:
    """How Python makes a body of the package, with a place for each number."""
    make = named.NAMED.get(body.name.replace(" ", "-"))
    numbers = {n: v for n, v in body.given.items() if n not in ("mass", "gravity", "length")}
    places = [f"{n}={{{n}}}" for n in numbers]
    if make is None:
        return ""
    for more in ({}, {"solid": False}):
        with suppress(TypeError, StabilityError):
            same = make(**numbers, **more)
            if same.moments() == body.moments() and same.name == body.name:
                arguments = [*places, *(f"{n}={v}" for n, v in more.items())]
                return f"st.{make.__name__}({', '.join(arguments)})"
    return ""


def round_page(
    body: Disk | Body,
    family: Any,
    at: Any,
    contact: Any,
    axes: Sequence[Axis | None],
    parameters: Mapping[str, Any],
    *,
    certify: bool,
    pole: Any = None,
    theta: Any = None,
) -> Contents:
    """The page of a body: the family under the law that are asked for, and all others that fit."""
    if isinstance(body, Disk):
        for word, value, motion in (("pole", pole, "vertical spin"), ("theta", theta, "rolling")):
            if value is not None:
                raise ParameterError(f"{word} belongs to {motion} of a body; leave it out.")
        source: _PageBody = _Disk(body)
    else:
        refuse_constants(body, [axis.name for axis in axes if axis is not None])
        source = _PageBody(body, theta)
    names = list(dict.fromkeys(choice.name for choice in source.choices))
    if not isinstance(family, str) or family not in names:
        raise NameUnknownError(
            f"family is {shown(family)}; give {listed(names, 'or')}, or a Family of your own."
        )
    law, source.friction = _law(contact, dict(parameters), source)
    choice = _chosen(source, family, pole, theta)
    start = source.subject(choice, law, at)
    motions = {n: motion_of(launch_model(source.shape, n), solid=True) for n in source.laws}
    kept, left_out = _fitting(source, motions, choice, start, at)
    return Contents(
        title=source.title.format(family),
        subjects=kept,
        start=start,
        units=source.units,
        motions={s.law: motions[s.law] for s in kept},
        certificates={s.key: source.certificates(s) for s in kept if certify},
        families={c.key: c.button for c in source.choices},
        says=f"{source.says} on a plane",
        computed_from=source.computed_from,
        more=_left_out(source.choices, left_out, choice),
    )


def _law(contact: Any, numbers: dict[str, Any], source: _PageBody) -> tuple[str, float]:
    """Name of the law at first, and its coefficient without dimension."""
    word, friction = contact, source.friction
    if contact is None and not numbers:
        word = Viscous.name
    elif isinstance(contact, type) and contact in LAWS.values():
        word = vars(contact)["name"]
    if numbers or not isinstance(word, str) or word not in LAWS:
        law = law_given(contact, numbers)
        if numbers:
            raise NameUnknownError(
                f"{next(iter(numbers))} is no number of the page; give at, a contact law and its "
                "mu, and every other number to the body."
            )
        word = getattr(law, "name", "")
        if LAWS.get(word) is type(law):
            friction = law.arguments(law.given, source.units.units).get("mu", friction)
        else:
            word = ""
    if word not in source.laws:
        raise NameUnknownError(
            f"contact is {shown(contact)}; the page draws {listed(source.laws, 'or')}."
        )
    return word, friction


def _chosen(source: _PageBody, name: str, pole: Any, theta: Any) -> PageFamily:
    """The family with a name, at the pole or inclination."""
    if name != "vertical" and pole is not None:
        raise ParameterError(f"pole belongs to vertical spin; leave it out for {name}.")
    if name != "rolling" and theta is not None:
        raise ParameterError(f"theta chooses where a body rolls; leave it out for {name}.")
    wanted = {None: 1, 0: 1, "pi": -1}.get(pole if isinstance(pole, int | str | None) else "")
    if wanted is None:
        raise ParameterError(f"pole is {shown(pole)}; give 0 or 'pi'.")
    same = [choice for choice in source.choices if choice.name == name]
    return next((choice for choice in same if choice.pole == wanted), same[0])


def _fitting(
    source: _PageBody,
    motions: Mapping[str, Any],
    first: PageFamily,
    start: PageSubject,
    at: Any,
) -> tuple[list[PageSubject], list[PageSubject]]:
    """What fits into the size of a page, in its order, and one of each group without room.

    First comes the subject that is asked for, then each other law of its family, then whole
    families.  What has no room is not built further.
    """
    groups = [(first, [law]) for law in source.laws if law != start.law]
    groups += [(choice, list(source.laws)) for choice in source.choices if choice is not first]
    kept, left_out = [start], []
    for choice, laws in groups:
        more = list(kept)
        for law in laws:
            try:
                subject = source.subject(choice, law, at if choice is first else None)
            except StabilityError:  # no such family, or formulas that are too large
                continue
            more.append(subject)
            if _size(more, motions) >= MOST:
                left_out.append(subject)
                break
        else:
            kept = more
    order = [(c.key, law) for c in source.choices for law in source.laws]
    return sorted(kept, key=lambda s: order.index((s.button, s.law))), left_out


def _size(subjects: Sequence[PageSubject], motions: Mapping[str, Any]) -> int:
    """Size of families and their motions on a page [bytes]."""
    data = {
        "subjects": [s.record for s in subjects],
        "motions": {s.law: motions[s.law] for s in subjects},
    }
    return len(json.dumps(shared(data)))


def _left_out(choices: Sequence[PageFamily], gone: Sequence[PageSubject], first: PageFamily) -> str:
    """The sentence that names the families and laws without room on the page."""
    laws = [LAW_NAMES.get(s.law, s.law) for s in gone if s.button == first.key]
    names = {s.button for s in gone} - {first.key}
    words = [c.button for c in choices if c.key in names]
    words += [f"{first.button} ({law.lower()})" for law in laws]
    if not words:
        return ""
    return f" Left out for size: {listed(words)}; name the family and the contact law to have it."
