"""Launches: starts, parameters and times, checked and made dimensionless."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..base.checks import checked
from ..base.errors import NameUnknownError, ParameterError, shown
from ..base.quantities import Kind, Units
from ..base.types import Floats
from ..bodies.contact_laws import Contact
from ..bodies.model import LIFT_OFF, NO_CONTACT, Model
from ..bodies.newton_euler import STATES
from ..settling.settling import Settling

MOST_LAUNCHES, MOST_SAMPLES = 1_000_000, 20_000_000
"""Most launches of one call, and most samples (launches by times): all are held in memory."""
POINTS = 201
"""Samples of a run for which only a last time is given."""


Unfit = dict[int, str]
"""The end that a start has had already, by its number."""


@dataclass(frozen=True, eq=False)
class Starts:
    """N launches of one model, dimensionless for a disk, with the user's units."""

    model: Model
    """The equations."""
    shape: tuple[int, ...]
    """The shape the user's arrays broadcast to."""
    starts: Floats
    """The states that are reported, shape (N, s)."""
    p: Floats
    """Parameters of the system, shape (N, m)."""
    times: Floats
    """Times as the user gave them, shape (t,)."""
    given: Mapping[str, Floats]
    """Parameters as the user gave them by name, shape (N,) or ()."""
    units: Units
    """The user's units of each launch, of shape (N,) or (); all 1 of a user's system."""
    dimensionless: bool
    """Whether all units are 1, or those of the user's own system."""
    energies: Floats
    """Energy at the start, shape (N,); 0 where none is counted."""
    settling: Settling
    """The steady motions that the launches may settle on."""
    law: type[Contact] | None = None
    """The contact law; None for a user's system."""
    unfit: Unfit | None = None
    """Which starts are no launches, as marked by `gather`; None where all were checked."""
    name: str = ""
    """What the full model is called: its contact law, or the user's system."""

    @property
    def count(self) -> int:
        """Number N of launches."""
        return len(self.starts)

    @property
    def dry(self) -> bool:
        """Whether friction sticks."""
        return self.law is not None and self.law.sticks

    def size(self, kind: Kind) -> Any:
        """A dimensionless 1 of a kind in the user's units, shape (N,) or ()."""
        return np.asarray(self.units.size(kind))

    def unit(self, name: str) -> str:
        """The unit of a series or of time, as in a file."""
        return self.model.attributes(name, dimensionless=self.dimensionless)["units"]


def unfit_of(fit: Any, first: list[str], conditions: int) -> Unfit | None:
    """The ends that starts without contact have had already.

    Parameters
    ----------
    fit
        Whether each condition and then the normal force is positive, shape (N, conditions + 1).
    first
        Ends that the first conditions mean; the others mean `NO_CONTACT`.
    conditions
        Number of conditions.
    """
    if fit.all():
        return None
    kinds = (first + [NO_CONTACT] * conditions)[:conditions] + [LIFT_OFF]
    rows = np.flatnonzero(~fit.all(axis=1))
    return {int(i): kinds[int(np.argmin(fit[i]))] for i in rows}


def counted(shape: tuple[int, ...], when: Floats) -> int:
    """The number of launches, refused where memory would not hold their samples."""
    count = math.prod(shape)
    if count == 0:
        raise ParameterError(
            f"start and the parameters have shape {shape}: give a launch at least."
        )
    if count > MOST_LAUNCHES or count * len(when) > MOST_SAMPLES:
        raise ParameterError(
            f"{count} launches at {len(when)} times are asked; give at most {MOST_LAUNCHES} "
            f"launches and {MOST_SAMPLES} samples in all, and call again for more."
        )
    return count


def six_states(start: Any, contact: Contact) -> Floats:
    """The six states of a start as numbers, shape (…, 6)."""
    if isinstance(start, Mapping):
        unknown = [n for n in start if n not in STATES]
        if unknown:
            raise NameUnknownError(
                f"start names {shown(unknown[0])}; known are {', '.join(STATES)}."
            )
        if "theta" not in start:
            raise ParameterError("start does not name theta; give at least theta [rad].")
        columns = [np.asarray(checked(f"start {n}", start.get(n, 0.0))) for n in STATES]
        try:
            six = np.stack(np.broadcast_arrays(*columns), axis=-1)
        except ValueError:
            raise ParameterError(
                f"the states of start have shapes {[c.shape for c in columns]}; make them fit."
            ) from None
    else:
        six = np.asarray(checked("start", start), dtype=float)
        width = six.shape[-1] if six.ndim else 0
        if width == 4 and not contact.slips:
            six = np.concatenate([six, np.zeros((*six.shape[:-1], 2))], axis=-1)
        elif width != 6:
            raise ParameterError(
                f"start has shape {six.shape}; its last axis must hold 6 values "
                f"({', '.join(STATES)})."
            )
    if contact.holds and (six[..., 4:] != 0).any():
        why = "follows from the other states" if contact.given else "is 0"
        raise ParameterError(
            f"slip_x, slip_y of start are {six[..., 4:].reshape(-1, 2).max(axis=0).tolist()}; the "
            f"slip of the {contact.name} contact {why}, so leave them out or give 0."
        )
    return six


def times_of(times: Any) -> Floats:
    """Times to report, rising from 0."""
    when = np.asarray(checked("times", times), dtype=float)
    if when.ndim == 0:
        if when <= 0:
            raise ParameterError(f"times is {when:g}; give a last time above 0, or an array.")
        return np.linspace(0.0, float(when), POINTS)
    if when.ndim != 1:
        raise ParameterError(f"times has shape {when.shape}; give one axis of rising times.")
    if when[0] < 0:
        raise ParameterError(f"times begin at {when[0]:g}; the start is time 0 and comes first.")
    falls = np.flatnonzero(np.diff(when) <= 0)
    if falls.size:
        i = int(falls[0])
        raise ParameterError(
            f"times go from {when[i]:g} to {when[i + 1]:g}; they must rise from one to the next."
        )
    if when[-1] == 0:
        raise ParameterError("times end at 0; give a last time above 0.")
    return when
