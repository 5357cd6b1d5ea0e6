"""The launches of a map or a sample: which numbers vary, and the value of every other one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..base.checks import one_number
from ..base.errors import NameUnknownError, ParameterError, listed, shown
from ..base.types import Floats
from ..bodies.contact import Contact
from ..bodies.contact_laws import MOTION_LAWS, law_missing
from ..bodies.disk import Disk
from ..bodies.law_names import law_given
from ..bodies.round_body.body import Body
from ..bodies.round_body.shape import refuse_constants
from ..bodies.thin_disk.disk_equations import STATES
from ..bodies.thin_disk.disk_families import FAMILIES
from ..bodies.thin_disk.launch import near_steady
from ..motion.body_starts import gather_body
from ..motion.starts import Starts, gather
from ..motion.system_starts import gather_system
from ..systems.family import Family
from ..systems.sources.numeric import NumericSystem
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
    """Family of the disk near which launches start; empty where the states are given."""
    families: tuple[Family, ...] = ()
    """Families on which a user's system may settle."""

    @property
    def names(self) -> tuple[str, ...]:
        """Names that may vary or be held."""
        if isinstance(self.thing, System):
            return (*self.thing.states, *self.thing.parameters)
        own = SCALES if isinstance(self.thing, Disk) else tuple(self.thing.given)
        law = tuple(self.contact.given) if self.contact is not None else ()
        near = (*FAMILIES[self.family].at, TILT) if self.family else ()
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
            x, p = ({n: given[n] for n in names}
                    for names in (self.thing.states, self.thing.parameters))  # fmt: skip
            return gather_system(self.thing, p or None, x, times, self.families, mark=True)
        contact = self._law(given)
        if isinstance(self.thing, Body):
            body = _with(self.thing, {n: v for n, v in given.items() if n in self.thing.given})
            start = {n: given[n] for n in STATES if n in given}
            return gather_body(body, contact, start, times, mark=True)
        disk = replace(self.thing, **{n: given[n] for n in SCALES if n in given})
        return gather(disk, contact, self._six(disk, given), times, mark=True)

    def _law(self, given: Mapping[str, Floats]) -> Contact:
        assert self.contact is not None
        mine = self.contact.given
        if not set(mine) & set(given):
            return self.contact
        return type(self.contact)(**(mine | {n: given[n] for n in mine if n in given}))

    def _six(self, disk: Disk, given: Mapping[str, Floats]) -> Floats:
        """The six states of each launch of a disk."""
        count = len(next(iter(given.values())))
        six = np.zeros((count, 6))
        if self.family:
            own = FAMILIES[self.family].at[0]
            six = near_steady(self.family, at=given[own], tilt=given.get(TILT, 0.0), disk=disk)
            six = np.array(np.broadcast_to(six, (count, 6)))
        for column, name in enumerate(STATES):
            if name in given and not (self.family and name == FAMILIES[self.family].at[0]):
                six[:, column] = given[name]
        return six


def _with(body: Body, given: Mapping[str, Floats]) -> Body:
    """A body with other numbers."""
    shape = dict(body.shape) | {n: v for n, v in given.items() if n in body.shape}
    others: dict[str, Any] = {n: v for n, v in given.items() if n not in body.shape}
    return replace(body, shape=shape, **others)


def moving(first: Any, body: Any) -> Any:
    """What moves: the first argument, or `body`.

    Parameters
    ----------
    first, body
        `disk` and `body` of `basins`.

    Raises
    ------
    ParameterError
        If both are given, or `body` is none.
    """
    if body is None:
        return first
    if first is not None:
        raise ParameterError("body is given, and another one in the first place; give one of them.")
    if not isinstance(body, (Body, Disk)):
        raise ParameterError(f"body is {shown(body)}; give a stability.Body or a stability.Disk.")
    return body


def prepare(
    thing: Any, contact: Any, varied: Sequence[str], held: Mapping[str, Any] | None,
    family: str, families: Any, parameters: dict[str, Any],
) -> Launches:  # fmt: skip
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

    Returns
    -------
    Launches

    Raises
    ------
    StabilityError
        In one sentence, if a name is unknown, given twice or missing.
    """
    held = _held(held)
    if isinstance(thing, NumericSystem):
        raise ParameterError(thing.no_graph)
    if isinstance(thing, System):
        for name, value in (("contact", contact), ("family", family or None)):
            if value is not None:
                raise ParameterError(
                    f"{name} is {shown(value)}, which a system does not take; leave it out."
                )
        held |= _held(parameters)
        found = Launches(thing, None, tuple(varied), held, "", _families(families))
    else:
        thing = Disk() if thing is None else thing
        if not isinstance(thing, (Disk, Body)):
            raise ParameterError(
                f"disk is {shown(thing)}; give a stability.Disk, a Body or a System."
            )
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
        found = Launches(thing, contact, tuple(varied), held, _family(thing, family))
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


def _family(thing: Disk | Body, family: Any) -> str:
    if family is None or (isinstance(family, str) and not family):
        return ""
    lines = [n for n, one in FAMILIES.items() if one.line]
    if not isinstance(thing, Disk):
        raise ParameterError("family names steady motions of a stability.Disk; give states.")
    if not isinstance(family, str) or family not in lines:
        raise NameUnknownError(f"family is {shown(family)}; give one of {', '.join(lines)}.")
    return str(family)


def _complete(found: Launches) -> None:
    """Refuse names that are unknown, given twice or missing."""
    refuse_constants(found.thing, (*found.varied, *found.held))
    for name in (*found.varied, *found.held):
        if name not in found.names:
            raise NameUnknownError(f"{shown(name)} varies nothing here; known are "
                                   f"{', '.join(found.names)}.")  # fmt: skip
    double = [n for n in found.varied if n in found.held] or [
        n for n in found.varied if found.varied.count(n) > 1
    ]
    if double:
        raise ParameterError(f"{double[0]} is given twice; give it as an axis or in held.")
    if isinstance(found.thing, System):
        needed = list(found.names)
    elif found.family:
        needed = [FAMILIES[found.family].at[0]]
    else:
        needed = ["theta"]
    missing = [n for n in needed if n not in (*found.varied, *found.held)]
    if missing:
        raise ParameterError(f"{listed(missing)} has no value; give it in held, or as an axis.")
