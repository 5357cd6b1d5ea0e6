"""The linear verdict of the family near which launches start, next to their outcomes."""

from __future__ import annotations

import warnings
from dataclasses import replace
from typing import Any

import numpy as np

from ..base.axis import Axis
from ..base.errors import StabilityError, StabilityWarning
from ..base.verdict import CODES
from ..bodies.disk import Disk
from ..bodies.newton_euler import STATES
from ..bodies.round_body.body import Body
from ..boundary.changes import boundaries
from ..spectra.spectrum import spectrum
from .launches import SCALES, TILT, Launches

LINEAR = "linear_verdict"
"""Name of the coordinate."""
DIGITS = 12
"""Significant digits of a change of verdict, so that any machine writes the same bytes."""


def linear_verdict(launches: Launches, axes: tuple[Axis, ...]) -> dict[str, Any]:
    """Verdict of the steady motions near which launches start, along the axis that names these.

    Verdicts are proved, so that any machine finds the same ones.

    Parameters
    ----------
    launches
        What is launched.
    axes
        Axes of a map.

    Returns
    -------
    dict
        The coordinate by name, with attributes `changes`, where the verdict changes, and `zones`,
        the verdicts before, between and after.  It is empty where launches start near no family,
        where another axis changes the verdict, or where the contact law has no linearisation.

    Examples
    --------
    >>> import stability as st
    >>> found = st.basins(contact="viscous", mu=0.3, family="spinning", horizon=1.0,
    ...                   x=("at", 1.0, 3.0, 2), y=("tilt", 0.1, 0.2, 2))
    >>> found.linear_verdict.dims, found.linear_verdict.values.tolist()
    (('phi_dot',), [2, 1])
    >>> found.linear_verdict.attrs["changes"], found.linear_verdict.attrs["zones"]
    ([2.0], [2, 1])
    """
    if not launches.family or launches.contact is None:
        return {}
    own = launches.own
    along = [a for a in axes if a.name == own]
    others = [a.name for a in axes if a.name != own]
    if not along or any(n != TILT and n not in STATES for n in others):
        return {}
    held, law = dict(launches.held), launches.contact
    thing: dict[str, Any] = {}
    if isinstance(launches.thing, Body):
        thing = {"body": launches.body(held), **launches.where, "certify": True}
    elif isinstance(launches.thing, Disk):
        thing = {"disk": replace(launches.thing, **{n: held[n] for n in SCALES if n in held})}
    if set(law.given) & set(held):
        law = type(law)(**(law.given | {n: held[n] for n in law.given if n in held}))
    try:
        given = thing | {"contact": law}
        found = spectrum(launches.family, at=along[0].values, **given)
        changes, zones = _zones(launches.family, along[0], given)
    except StabilityError:  # dry friction is not smooth at a member
        return {}
    attributes: dict[str, Any] = {
        "long_name": f"linear verdict of {launches.near} under {law.name} contact",
        "flag_values": [int(c) for c in CODES.values()],
        "flag_meanings": " ".join(v.word for v in CODES),
    }
    if zones:
        attributes |= {"changes": changes, "zones": zones}
    return {LINEAR: (own, np.asarray(found.codes, dtype=np.int8), attributes)}


def _zones(family: str, axis: Axis, given: dict[str, Any]) -> tuple[list[float], list[int]]:
    """Changes of verdict and the verdicts between them; none where a piece stays open."""
    of_all = {n: v for n, v in given.items() if n != "certify"}
    with warnings.catch_warnings():  # an open piece leaves out the zones, and nothing else
        warnings.simplefilter("ignore", StabilityWarning)
        found = boundaries(family, axis=("at", axis.low, axis.high, axis.count), **of_all)
    if not found.complete or not len(found):
        return [], []
    changes = [float(f"{p.value:.{DIGITS}g}") for p in found]
    ends = np.array([axis.low, *changes, axis.high])
    between = spectrum(family, at=(ends[1:] + ends[:-1]) / 2, **given)
    return changes, [int(c) for c in between.codes]
