"""Launches: starts, parameters and times, checked and made dimensionless."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike

from ..algebra.program import Program
from ..base.checks import checked
from ..base.errors import DomainError, NameUnknownError, ParameterError, if_degrees, shown
from ..base.quantities import Kind, Units
from ..base.types import Floats
from ..bodies.contact import Contact
from ..bodies.contact_laws import MOTION_LAWS, Rough, law_missing, spelled
from ..bodies.disk import Disk
from ..bodies.model import Model
from ..bodies.thin_disk.disk_equations import STATES, disk_system
from ..bodies.thin_disk.disk_model import FLAT, LIFT_OFF, NO_CONTACT, disk_model, moving_system
from ..integrators.friction_at_rest import continuations
from ..integrators.stick_slip import REST
from ..settling.disk_lines import disk_settling
from ..settling.settling import Settling

FASTEST = 1e9
"""Largest dimensionless rate or slip of a start: beyond it forces are lost in rounding."""
ROUGHEST = 1e8
"""Largest dimensionless friction."""
LONGEST, BRIEFEST = 1e12, 1e-200
"""Range of the last time, dimensionless."""
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


def gather(
    disk: Disk, contact: Contact, start: Any, times: ArrayLike, *, pose: bool = False,
    mark: bool = False,
) -> Starts:  # fmt: skip
    """Check the arguments of `simulate` and make them dimensionless.

    Parameters
    ----------
    disk, contact, start, times, pose
        As for `simulate`.
    mark
        Whether a start without contact is marked, in place of an error.

    Returns
    -------
    Starts

    Raises
    ------
    StabilityError
        In one sentence, if something is not accepted.
    """
    if not isinstance(disk, Disk):
        raise ParameterError(f"disk is {shown(disk)}; give a stability.Disk.")
    if contact is None:
        raise law_missing(MOTION_LAWS)
    if not isinstance(contact, Contact) or not contact.name:
        raise NameUnknownError(f"contact is {shown(contact)}; give one of {spelled(MOTION_LAWS)}.")
    with np.errstate(all="ignore"):  # an overflow is refused by _check
        return _gathered(disk, contact, start, times, pose=pose, mark=mark)


def _gathered(
    disk: Disk, contact: Contact, start: Any, times: ArrayLike, *, pose: bool, mark: bool
) -> Starts:
    six = six_states(start, contact)
    when = times_of(times)
    fields = {n: getattr(disk, n) for n in ("mass", "radius", "gravity", "k")} | contact.given
    try:
        shape = np.broadcast_shapes(six.shape[:-1], *(np.shape(v) for v in fields.values()))
    except ValueError:
        listed = ", ".join(f"{n} {np.shape(v)}" for n, v in fields.items() if np.shape(v))
        raise ParameterError(
            f"start has leading shape {six.shape[:-1]} and the parameters {listed}: they do not "
            "broadcast; make them fit."
        ) from None
    flat = {n: _flat(v, shape) for n, v in fields.items()}
    units = Units(flat["mass"], flat["radius"], flat["gravity"], np.sqrt)
    count = counted(shape, when)
    starts = np.broadcast_to(six, (*shape, 6)).reshape(count, 6).copy()
    if not disk.dimensionless:
        starts[:, 1:4] *= np.asarray(units.time)[..., None]
        starts[:, 4:] /= np.asarray(units.speed)[..., None]
    own = {"k": flat["k"]} | contact.arguments(flat, units)
    p = np.column_stack([np.broadcast_to(v, (count,)) for v in own.values()])
    last = when[-1] / units.time
    if not (np.all(last <= LONGEST) and np.all(last >= BRIEFEST)):
        raise ParameterError(
            f"times end at {when[-1]:g}; in units of √(R/g) give a last time from {BRIEFEST:g} to "
            f"{LONGEST:g}."
        )
    law = type(contact)
    seen = _check(law, starts, p)
    fit = seen[:, :-1] > 0
    if not (mark or fit.all()):
        _refuse(law, shape, seen)
    return Starts(
        disk_model(law, pose=pose), shape, starts, p, when, flat, units,
        disk.dimensionless, seen[:, -1],
        disk_settling(law), law, unfit_of(fit, [FLAT, FLAT], len(disk_system(law).conditions)),
    )  # fmt: skip


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


def _flat(value: Any, shape: tuple[int, ...]) -> Floats:
    array = np.asarray(value, dtype=float)
    return array if array.ndim == 0 else np.broadcast_to(array, shape).reshape(-1)


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


@cache
def _first_look(law: type[Contact]) -> Program:
    """The conditions of a law's system, then gn and the energy."""
    system = moving_system(law)
    seen = system.observables
    values = [c.value for c in system.conditions] + [seen["normal_force"], seen["energy"]]
    return Program(ca.Function("start", [system.x, system.p], [ca.vertcat(*values)]))


def _look(law: type[Contact], x: Floats, p: Floats) -> Floats:
    columns = [list(np.moveaxis(x, -1, 0)), list(np.moveaxis(p, -1, 0))]
    return np.asarray(_first_look(law).arrays(columns, x.shape[:-1])[0][..., 0])  # type: ignore[arg-type]  # a class is hashable


def _check(law: type[Contact], starts: Floats, p: Floats) -> Floats:
    """What a start needs to be positive, and its energy; numbers out of range are refused."""
    zeros = {one.place for one in law.parameters if one.zero}
    may = np.array([False, *(n in zeros for n in law.symbols())])
    finite = np.isfinite(starts).all() and np.isfinite(p).all() and ((p > 0) | may & (p == 0)).all()
    if not (finite and np.abs(starts).max() < FASTEST):
        raise ParameterError(
            "a dimensionless number of the start or the body leaves the range of double precision "
            f"(rates up to {FASTEST:g}); give values nearer to 1."
        )
    if p.shape[1] > 1 and p[:, 1].max() > ROUGHEST:
        raise ParameterError(
            f"the dimensionless friction is {p[:, 1].max():.3g}, above {ROUGHEST:g}, where double "
            "precision cannot resolve the slip; take Rough(), to which the motion tends."
        )
    own = len(moving_system(law).states)
    if law.sticks:
        dry = disk_model(law).dry
        assert dry is not None
        rest = np.hypot(starts[:, 4], starts[:, 5]) <= REST
        seen = np.empty((len(starts), 5))
        seen[~rest] = _look(law, starts[~rest], p[~rest])
        if rest.any():
            seen[rest] = _look(Rough, starts[rest, :4], p[rest, :1])
        for i in np.flatnonzero(rest & (seen[:, :2] > 0).all(axis=1)):
            # without sticking the disk may slip, or do neither although gn of sticking is positive
            pressed = continuations(dry, starts[i, :4], p[i]).pressed
            seen[i, 3] = max(seen[i, 3], 1e-300) if pressed else min(seen[i, 3], 0.0)
    else:
        seen = _look(law, starts[:, :own], p)
    return seen


def _refuse(law: type[Contact], shape: tuple[int, ...], seen: Floats) -> None:
    row = int(np.flatnonzero(~(seen[:, :-1] > 0).all(axis=1))[0])
    column = int(np.flatnonzero(~(seen[row, :-1] > 0))[0])
    where = f" {[int(j) for j in np.unravel_index(row, shape)]}" if shape else ""
    conditions = disk_system(law).conditions
    value = float(seen[row, column])
    if column < 2:  # the two conditions of theta
        theta = value if column == 0 else math.pi - value
        raise DomainError(
            f"start{where}: theta is {theta:g}; theta must lie strictly between 0 and π, because "
            f"the disk is flat at both and its equations of motion end there{if_degrees(theta)}."
        )
    if column < len(conditions):
        raise DomainError(f"start{where}: {conditions[column].refusal(value)}")
    raise DomainError(
        f"start{where}: the normal force is {value:.4g} m g, which is not positive: "
        "the disk is not in contact; turn it slower."
    )
