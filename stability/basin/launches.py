"""The launches of a map or a sample: which numbers vary, and the value of every other one."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ..base.axis import Axis
from ..base.checks import one_number
from ..base.errors import NameUnknownError, ParameterError, listed, shown
from ..base.types import Floats
from ..bodies.contact_laws import MOTION_LAWS, Contact, law_given, law_missing
from ..bodies.disk import Disk
from ..bodies.families import FAMILIES, at_name
from ..bodies.launch import launch
from ..bodies.newton_euler import STATES
from ..bodies.round_body.body import Body
from ..bodies.round_body.families import place_of
from ..bodies.round_body.shape import refuse_constants
from ..integrators.flow import CASADI
from ..motion.gather import launches_of
from ..motion.starts import Starts
from ..systems.family import Family
from ..systems.system import System

TILT = "tilt"
"""Name of the angle by which a launch near a steady motion leans from it."""
SCALES = ("k", "mass", "radius", "gravity")
"""Numbers of a disk by name."""


@dataclass(frozen=True)
class Launches:
    """Launches of one body or system: some numbers vary, all others have one value.

    A launch is given by the states at its start.  With `family` it is given by a steady motion, by
    the tilt from it, and by states that differ from those of that motion.
    """

    thing: Disk | Body | System
    """The body or system."""
    contact: Contact | None
    """The contact law, with any value for a number that varies; None for a system."""
    varied: tuple[str, ...]
    """Names of the numbers that vary."""
    held: Mapping[str, float]
    """Values of others by name."""
    family: str = ""
    """Family of the disk or body near which launches start; empty where the states are given."""
    where: Mapping[str, Any] = field(default_factory=dict)
    """`theta` or `pole` of that family, for a body that needs them."""
    families: tuple[Family, ...] = ()
    """Families on which a user's system may settle."""

    @property
    def own(self) -> str:
        """Name of the number that names members of `family`."""
        return at_name(self.family)

    @property
    def near(self) -> str:
        """The family near which launches start, in words; empty where the states are given."""
        if not self.family or not isinstance(self.thing, Body):
            return self.family
        pole = self.where.get("pole")
        at = place_of(self.thing, self.family, self.where.get("theta"), pole)
        if FAMILIES[self.family].pole:
            return f"{self.family} at theta = {'pi' if at else 0}"
        return self.family if at in (None, math.pi / 2) else f"{self.family} at theta = {at:.6g}"

    @property
    def names(self) -> tuple[str, ...]:
        """Names that may vary or be held."""
        if isinstance(self.thing, System):
            return (*self.thing.states, *self.thing.parameters)
        own = SCALES if isinstance(self.thing, Disk) else tuple(self.thing.given)
        law = tuple(self.contact.given) if self.contact is not None else ()
        near = (self.own, TILT) if self.family else ()
        return tuple(dict.fromkeys((*near, *STATES, *own, *law)))

    def starts(self, points: Mapping[str, Floats], horizon: float) -> Starts:
        """The launches at some values of the numbers that vary.

        Parameters
        ----------
        points
            Values of every number that varies, shape (N,) each.
        horizon
            Last time.

        Returns
        -------
        Starts
            Those without contact at the start are marked.
        """
        count = len(next(iter(points.values())))
        given = {n: np.full(count, v) for n, v in self.held.items()} | {
            n: np.asarray(v, dtype=float) for n, v in points.items()
        }
        times = [0.0, horizon]
        if isinstance(self.thing, System):
            x, p = (
                {n: given[n] for n in names} for names in (self.thing.states, self.thing.parameters)
            )
            return launches_of(self.thing, p or None, x, times, families=self.families, mark=True)
        if isinstance(self.thing, Body):
            thing: Disk | Body = self.body(given)
        else:
            thing = replace(self.thing, **{n: given[n] for n in SCALES if n in given})
        return launches_of(thing, self._law(given), self._six(thing, given), times, mark=True)

    def body(self, given: Mapping[str, Any]) -> Body:
        """The body with those of some numbers that are its own."""
        assert isinstance(self.thing, Body)
        return _with(self.thing, {n: v for n, v in given.items() if n in self.thing.given})

    def check_edges(self, axes: Sequence[Axis], horizon: float) -> None:
        """Refuse a map with launches that do not exist before any of them runs.

        Members exist or not by the numbers of one axis, and tilts are largest at ends: along every
        edge of the map each launch is made.

        Parameters
        ----------
        axes
            Axes of the map.
        horizon
            Last time.

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
        with CASADI:
            self.starts({a.name: edges[i] for i, a in enumerate(axes)}, horizon)

    def _law(self, given: Mapping[str, Floats]) -> Contact:
        assert self.contact is not None
        mine = self.contact.given
        if not set(mine) & set(given):
            return self.contact
        return type(self.contact)(**(mine | {n: given[n] for n in mine if n in given}))

    def _six(self, body: Disk | Body, given: Mapping[str, Floats]) -> Floats:
        """The six states of each launch of a disk or body."""
        count = len(next(iter(given.values())))
        six = np.zeros((count, 6))
        if self.family:
            six = launch(
                self.family, at=given[self.own], tilt=given.get(TILT, 0.0), body=body, **self.where
            )
            six = np.array(np.broadcast_to(six, (count, 6)))
        for column, name in enumerate(STATES):
            if name in given and not (self.family and name == self.own):
                six[:, column] = given[name]
        return six


def _with(body: Body, given: Mapping[str, Floats]) -> Body:
    """A body with other numbers."""
    shape = dict(body.shape) | {n: v for n, v in given.items() if n in body.shape}
    others: dict[str, Any] = {n: v for n, v in given.items() if n not in body.shape}
    return replace(body, shape=shape, **others)


def prepare(
    thing: Any,
    contact: Any,
    varied: Sequence[str],
    held: Mapping[str, Any] | None,
    family: str,
    families: Any,
    parameters: dict[str, Any],
    theta: Any = None,
    pole: Any = None,
) -> Launches:
    """Check what is launched.

    Parameters
    ----------
    thing, contact, families
        As for `simulate`.
    varied
        Names of the numbers that vary.
    held
        Values of others by name.
    family
        Family near which launches start; empty where states are given.
    parameters
        Numbers of a contact law that is named, or of a system, by name.
    theta, pole
        Where a body rolls or spins, as for `launch`.

    Returns
    -------
    Launches

    Raises
    ------
    StabilityError
        In one sentence, if a name is unknown, given twice or missing.
    """
    held = _held(held)
    if isinstance(thing, System):
        others = ("contact", contact), ("family", family or None), ("theta", theta), ("pole", pole)
        for name, value in others:
            if value is not None:
                raise ParameterError(
                    f"{name} is {shown(value)}, which a system does not take; leave it out."
                )
        held |= _held(parameters)
        found = Launches(thing, None, tuple(varied), held, families=_families(families))
    else:
        if families is not None and not (isinstance(families, (tuple, list)) and not families):
            raise ParameterError("families belong to a stability.System; leave them out.")
        contact = law_given(contact, parameters, motion=True, swept=(*varied, *held))
        for name in parameters:
            raise ParameterError(
                f"{shown(name)} is not an argument here; give it in held, or as an axis."
            )
        if contact is None:
            raise law_missing(MOTION_LAWS)
        if not isinstance(contact, Contact) or not contact.name:
            raise NameUnknownError(f"contact is {shown(contact)}; give a contact law.")
        near = _family(thing, family, theta, pole)
        found = Launches(thing, contact, tuple(varied), held, *near)
    _complete(found)
    return found


def _held(held: Any) -> dict[str, float]:
    if held is None:
        return {}
    if not isinstance(held, Mapping):
        raise ParameterError(f"held is {shown(held)}; give values by name.")
    return {n: one_number(f"held {n}", v) for n, v in held.items()}


def _families(families: Any) -> tuple[Family, ...]:
    given = (families,) if isinstance(families, Family) else families
    if not isinstance(given, (tuple, list)):
        raise ParameterError(f"families is {shown(families)}; give a list of stability.Family.")
    return tuple(given)


def _family(
    thing: Disk | Body, family: Any, theta: Any, pole: Any
) -> tuple[str, Mapping[str, Any]]:
    """The family near which launches start, and where it is."""
    where = {n: v for n, v in (("theta", theta), ("pole", pole)) if v is not None}
    if family is None or (isinstance(family, str) and not family):
        if theta is not None:
            raise ParameterError(
                "theta chooses where a family rolls; name the family, or give the state theta as "
                "an axis or held."
            )
        if pole is not None:
            raise ParameterError("pole belongs to the family vertical; name the family.")
        return "", {}
    single = isinstance(thing, Body)  # whose members have formulas wherever one number names them
    lines = [n for n, one in FAMILIES.items() if (len(one.at) == 1 if single else one.line)]
    if not isinstance(family, str) or family not in lines:
        raise NameUnknownError(f"family is {shown(family)}; give one of {', '.join(lines)}.")
    if isinstance(thing, Body):
        place_of(thing, family, theta, pole)
    elif where:
        raise ParameterError(
            f"{next(iter(where))} belongs to a stability.Body; leave it out for a disk."
        )
    return str(family), where


def _complete(found: Launches) -> None:
    """Refuse names that are unknown, given twice or missing."""
    refuse_constants(found.thing, (*found.varied, *found.held))
    for name in (*found.varied, *found.held):
        if name not in found.names:
            raise NameUnknownError(
                f"{shown(name)} varies nothing here; known are {', '.join(found.names)}."
            )
    double = [n for n in found.varied if n in found.held] or [
        n for n in found.varied if found.varied.count(n) > 1
    ]
    if double:
        raise ParameterError(f"{double[0]} is given twice; give it as an axis or in held.")
    if isinstance(found.thing, System):
        needed = list(found.names)
    elif found.family:
        needed = [found.own]
    else:
        needed = ["theta"]
    missing = [n for n in needed if n not in (*found.varied, *found.held)]
    if missing:
        raise ParameterError(f"{listed(missing)} has no value; give it in held, or as an axis.")
