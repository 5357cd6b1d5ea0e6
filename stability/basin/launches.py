"""The launches of a map or a sample: which numbers vary, and the value of every other one."""

from __future__ import annotations

import json
import math
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ..base.axis import Axis
from ..base.checks import one_number
from ..base.errors import NameUnknownError, ParameterError, listed, shown
from ..base.quantities import Kind
from ..base.types import Floats
from ..bodies.contact_laws import (
    MOTION_LAWS,
    Contact,
    Smooth,
    law_given,
    law_missing,
    refuse_second,
)
from ..bodies.disk import Disk
from ..bodies.families import FAMILIES, at_name
from ..bodies.launch import launch
from ..bodies.newton_euler import STATES
from ..bodies.quantities import round_quantities
from ..bodies.resistance import Resistance, resistances
from ..bodies.round_body.body import Body
from ..bodies.round_body.families import place_of
from ..bodies.round_body.shape import refuse_constants
from ..integrators.flow import CASADI
from ..motion.gather import launches_of
from ..motion.result import Settings
from ..motion.starts import Starts
from ..systems.family import Family
from ..systems.system import System

TILT = "tilt"
"""Name of the angle by which a launch near a steady motion leans from it."""


@dataclass(frozen=True)
class Steady:
    """Steady motions near which launches start, for their linear verdict."""

    family: str
    """Name of the family."""
    words: str
    """The family and the law, in words."""
    axis: Axis
    """Axis of the number that names the members."""
    call: Mapping[str, Any]
    """What names the family in a call of `spectrum`."""


@dataclass(frozen=True, kw_only=True)
class Launches(ABC):
    """Launches of one body or system: some numbers vary, all others have one value."""

    varied: tuple[str, ...]
    """Names of the numbers that vary."""
    held: Mapping[str, float]
    """Values of others by name."""
    horizon: float
    """Last time."""
    settings: Settings
    """Settings of the runs."""
    families: tuple[Family, ...] = ()
    """Families on which a user's system may settle; a body has its own."""

    @property
    @abstractmethod
    def names(self) -> tuple[str, ...]:
        """Names that may vary or be held."""

    @property
    @abstractmethod
    def needed(self) -> tuple[str, ...]:
        """Names that must vary or be held."""

    @abstractmethod
    def gathered(self, values: Mapping[str, Floats], times: Sequence[float]) -> Starts:
        """The launches with these numbers, shape (N,) each; bad starts are marked."""

    @abstractmethod
    def label(self, sample: Starts, name: str) -> dict[str, str]:
        """Name in words and units of a number that varies or is held."""

    @abstractmethod
    def attributes(self, sample: Starts) -> dict[str, Any]:
        """What is launched, for the attributes of a dataset."""

    def steady(self, axes: Sequence[Axis]) -> Steady | None:  # noqa: ARG002
        """The steady motions near which they start; None where no axis alone names them."""
        return None

    def starts(self, points: Mapping[str, Floats]) -> Starts:
        """The launches at some values of the numbers that vary.

        Parameters
        ----------
        points
            Values of every number that varies, shape (N,) each.

        Returns
        -------
        Starts
            Those without contact at the start are marked.
        """
        count = len(next(iter(points.values())))
        values = {n: np.full(count, v) for n, v in self.held.items()} | {
            n: np.asarray(v, dtype=float) for n, v in points.items()
        }
        with CASADI:  # calls from several threads take turns
            return self.gathered(values, [0.0, self.horizon])

    def check_edges(self, axes: Sequence[Axis]) -> None:
        """Refuse a map with launches that do not exist before any of them runs.

        Members exist or not by the numbers of one axis, and tilts are largest at ends: along every
        edge of the map each launch is made.

        Parameters
        ----------
        axes
            Axes of the map.

        Raises
        ------
        StabilityError
            In one sentence, if a launch is refused.
        """
        rows = []
        for along in axes:
            sides = [a.values if a is along else a.values[[0, -1]] for a in axes]
            rows.append(np.stack([v.ravel() for v in np.meshgrid(*sides, indexing="ij")]))
        edges = np.concatenate(rows, axis=1)
        self.starts({a.name: edges[i] for i, a in enumerate(axes)})


@dataclass(frozen=True, kw_only=True)
class SystemLaunches(Launches):
    """Launches of a user's system."""

    system: System
    """The system."""

    @property
    def names(self) -> tuple[str, ...]:
        """States, then parameters."""
        return (*self.system.states, *self.system.parameters)

    needed = names

    def gathered(self, values: Mapping[str, Floats], times: Sequence[float]) -> Starts:
        """States and parameters by name."""
        x, p = (
            {n: values[n] for n in names} for names in (self.system.states, self.system.parameters)
        )
        return launches_of(self.system, p or None, x, times, families=self.families, mark=True)

    def label(self, sample: Starts, name: str) -> dict[str, str]:
        """As the system states them."""
        return sample.model.attributes(name, dimensionless=True)

    def attributes(self, sample: Starts) -> dict[str, Any]:  # noqa: ARG002
        """Its name."""
        return {"system": self.system.name}


@dataclass(frozen=True, kw_only=True)
class BodyLaunches(Launches):
    """Launches of a disk or body, by the states at their starts.

    With `family` they are given by a steady motion, by the tilt from it, and by states that differ
    from those of that motion.
    """

    body: Disk | Body
    """The disk or body, with any value for a number that varies."""
    contact: Contact
    """The contact law, with any value for a number that varies."""
    family: str = ""
    """Family near which launches start; empty where the states are given."""
    resistance: tuple[Resistance, ...] = ()
    """Resistances to rolling and turning."""
    where: Mapping[str, Any] = field(default_factory=dict)
    """`theta` or `pole` of that family, for a body that needs them."""

    @property
    def own(self) -> str:
        """Name of the number that names members of `family`."""
        return at_name(self.family)

    @property
    def near(self) -> str:
        """The family near which launches start, in words; empty where the states are given."""
        if not self.family or not isinstance(self.body, Body):
            return self.family
        pole = self.where.get("pole")
        at = place_of(self.body, self.family, self.where.get("theta"), pole)
        if FAMILIES[self.family].pole:
            return f"{self.family} at theta = {'pi' if at else 0}"
        return self.family if at in (None, math.pi / 2) else f"{self.family} at theta = {at:.6g}"

    @property
    def names(self) -> tuple[str, ...]:
        """What names a member and the tilt from it, states, and numbers of the body and the law."""
        near = (self.own, TILT) if self.family else ()
        return tuple(dict.fromkeys((*near, *STATES, *self.body.given, *self.contact.given)))

    @property
    def needed(self) -> tuple[str, ...]:
        """The number that names a member, or the inclination."""
        return (self.own,) if self.family else ("theta",)

    def having(self, values: Mapping[str, Any]) -> tuple[Disk | Body, Contact]:
        """The body and the law with those of some numbers that are their own."""
        body = self.body.having({n: v for n, v in values.items() if n in self.body.given})
        law = self.contact.given
        if set(law) & set(values):
            return body, type(self.contact)(**(law | {n: values[n] for n in law if n in values}))
        return body, self.contact

    def steady(self, axes: Sequence[Axis]) -> Steady | None:
        """Those of `family`, along the axis that names them."""
        along = [a for a in axes if a.name == self.own]
        others = {a.name for a in axes} - {self.own}
        if self.resistance or not self.family or not along or not others <= {TILT, *STATES}:
            return None
        body, law = self.having(self.held)
        call = {"body": body, "contact": law, **self.where}
        return Steady(self.family, f"{self.near} under {law.name} contact", along[0], call)

    def gathered(self, values: Mapping[str, Floats], times: Sequence[float]) -> Starts:
        """The body and the law with their numbers, and the six states."""
        body, law = self.having(values)
        six, resistance = self._six(body, values), self.resistance or None
        return launches_of(body, law, six, times, mark=True, resistance=resistance)

    def _six(self, body: Disk | Body, values: Mapping[str, Floats]) -> Floats:
        """The six states of each launch."""
        count = len(next(iter(values.values())))
        six = np.zeros((count, 6))
        if self.family:
            six = launch(
                self.family,
                at=values[self.own],
                tilt=values.get(TILT, 0.0),
                body=body,
                **self.where,
            )
            six = np.array(np.broadcast_to(six, (count, 6)))
        for column, name in enumerate(STATES):
            if name in values and not (self.family and name == self.own):
                six[:, column] = values[name]
        return six

    def label(self, sample: Starts, name: str) -> dict[str, str]:
        """As the body states them; tilt and the number of a member too."""
        if name == TILT:
            return {"long_name": "tilt from the steady motion", "units": Kind.ANGLE.si}
        if name == self.own and name not in sample.model.quantities:  # of no state of the angles
            quantity = round_quantities("", Smooth, (), (name,))[name]
            return quantity.attributes(dimensionless=sample.dimensionless)
        return sample.model.attributes(name, dimensionless=sample.dimensionless)

    def attributes(self, sample: Starts) -> dict[str, Any]:
        """Body, law, their fixed numbers, and the family nearby."""
        swept = {*self.varied, *self.held}
        against = {r.coefficient: r.value for r in self.resistance}
        numbers = {**self.body.given, **self.contact.given, **against}
        fixed = {n: float(v) for n, v in numbers.items() if n not in swept and np.ndim(v) == 0}
        attrs = {
            "body": sample.subject.attributes.get("body", "disk"),
            "contact": self.contact.name,
            "law": self.contact.formula,
            "flat": self.settings.flat,
            "dimensionless": int(sample.dimensionless),
            "parameters": json.dumps(fixed, sort_keys=True),
        }
        return attrs | ({"launched_near": self.near} if self.family else {})


def prepare(
    mover: Any,
    contact: Any,
    varied: Sequence[str],
    held: Mapping[str, Any] | None,
    horizon: Any,
    settings: Settings,
    *,
    family: str = "",
    families: Any = (),
    box: Mapping[str, Any] | None = None,
    parameters: Mapping[str, Any] | None = None,
    theta: Any = None,
    pole: Any = None,
    resistance: Any = None,
) -> Launches:
    """Check what is launched.

    Parameters
    ----------
    mover, contact, families
        As for `simulate`.
    varied
        Names of the numbers that vary.
    held
        Values of others by name.
    horizon
        Last time.
    settings
        Settings of the runs, which are checked here.
    family
        Family near which launches start; empty where states are given.
    box
        Ends of states of a system, in which the equilibria are found that launches may settle on.
    parameters
        Numbers of a contact law that is named, or of a system, by name.
    theta, pole
        Where a body rolls or spins, as for `launch`.
    resistance
        As for `simulate`, one number each.

    Returns
    -------
    Launches

    Raises
    ------
    StabilityError
        In one sentence, if a name is unknown, given twice or missing.
    """
    settings.refuse()
    last = one_number("horizon", horizon)
    if not last > 0:
        raise ParameterError(f"horizon is {last:g}; give a last time above 0.")
    common: dict[str, Any] = {"varied": tuple(varied), "held": _held(held)}
    common |= {"horizon": last, "settings": settings}
    parameters = dict(parameters or {})
    if isinstance(mover, System):
        others = {
            "contact": contact,
            "family": family or None,
            "theta": theta,
            "pole": pole,
            "resistance": resistance,
        }
        for name, value in others.items():
            if value is not None:
                raise ParameterError(
                    f"{name} is {shown(value)}, which a system does not take; leave it out."
                )
        common["held"] |= _held(parameters)
        if box is not None and families != ():
            raise ParameterError("families and a box are both given; give one of them.")
        of_system = SystemLaunches(system=mover, families=_families(families), **common)
        launches: Launches = of_system if box is None else with_equilibria(of_system, box)
    else:
        if families is not None and not (isinstance(families, (tuple, list)) and not families):
            raise ParameterError("families belong to a stability.System; leave them out.")
        if box is not None:
            raise ParameterError("a box belongs to a stability.System; leave it out.")
        contact = law_given(contact, parameters, motion=True, swept=(*varied, *common["held"]))
        for name in parameters:
            refuse_second(contact, name)
            raise ParameterError(
                f"{shown(name)} is not an argument here; give it in held, or as an axis."
            )
        if contact is None:
            raise law_missing(MOTION_LAWS)
        if not isinstance(contact, Contact) or not contact.name:
            raise NameUnknownError(f"contact is {shown(contact)}; give a contact law.")
        near, where = _family(mover, family, theta, pole)
        against = resistances(resistance)
        for r in against:
            one_number(r.coefficient, r.value)
        launches = BodyLaunches(
            body=mover, contact=contact, family=near, where=where, resistance=against, **common
        )
    refuse_constants(mover, (*launches.varied, *launches.held))
    _complete(launches)
    return launches


def _held(held: Any) -> dict[str, float]:
    if held is None:
        return {}
    if not isinstance(held, Mapping):
        raise ParameterError(f"held is {shown(held)}; give values by name.")
    return {n: one_number(f"held {n}", v) for n, v in held.items()}


def _families(families: Any) -> tuple[Family, ...]:
    sequence = (families,) if isinstance(families, Family) else families
    if not isinstance(sequence, (tuple, list)):
        raise ParameterError(f"families is {shown(families)}; give a list of stability.Family.")
    return tuple(sequence)


def with_equilibria(launches: SystemLaunches, box: Mapping[str, Any]) -> SystemLaunches:
    """Launches that may settle on the equilibria in a box too; all have the same parameters."""
    system = launches.system
    for name in system.parameters:
        if name not in launches.held:
            raise ParameterError(
                f"{name} varies, and a box is searched at one value of each parameter; give "
                "families in place of the box."
            )
    numbers = {n: launches.held[n] for n in system.parameters}
    families = system.equilibria(box, **numbers).families(at=system.parameters[:1])
    return replace(launches, families=(*launches.families, *families))


def _family(body: Disk | Body, family: Any, theta: Any, pole: Any) -> tuple[str, Mapping[str, Any]]:
    """The family near which launches start, and where it is."""
    where = {n: v for n, v in (("theta", theta), ("pole", pole)) if v is not None}
    name = str("" if family is None else family)
    if not name:
        if theta is not None:
            raise ParameterError(
                "theta chooses where a family rolls; name the family, or give the state theta as "
                "an axis or held."
            )
        if pole is not None:
            raise ParameterError("pole belongs to the family vertical; name the family.")
        return "", {}
    outline = body if isinstance(body, Body) else None  # whose members all have formulas
    lines = [
        n
        for n, record in FAMILIES.items()
        if (len(record.at) == 1 if outline is not None else record.line)
    ]
    if name not in lines:
        raise NameUnknownError(f"family is {shown(family)}; give one of {', '.join(lines)}.")
    if outline is not None:
        place_of(outline, name, theta, pole)
    elif where:
        raise ParameterError(
            f"{next(iter(where))} belongs to a stability.Body; leave it out for a disk."
        )
    return name, where


def _complete(launches: Launches) -> None:
    """Refuse names that are unknown, given twice or missing."""
    for name in (*launches.varied, *launches.held):
        if name not in launches.names:
            raise NameUnknownError(
                f"{shown(name)} varies nothing here; known are {', '.join(launches.names)}."
            )
    double = [n for n in launches.varied if n in launches.held] or [
        n for n in launches.varied if launches.varied.count(n) > 1
    ]
    if double:
        raise ParameterError(f"{double[0]} is given twice; give it as an axis or in held.")
    missing = [n for n in launches.needed if n not in (*launches.varied, *launches.held)]
    if missing:
        raise ParameterError(f"{listed(missing)} has no value; give it in held, or as an axis.")
