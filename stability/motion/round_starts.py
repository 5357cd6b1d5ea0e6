"""Launches of a disk or another body: starts and parameters, checked and made dimensionless."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike

from ..algebra.program import Program
from ..base.checks import broadcast, checked, rows
from ..base.citation import cited
from ..base.errors import (
    DomainError,
    NameUnknownError,
    ParameterError,
    if_degrees,
    listed,
    shown,
)
from ..base.quantities import Kind, Units
from ..base.types import Floats
from ..bodies.contact_laws import MOTION_LAWS, Contact, law_class, law_missing, law_only, spelled
from ..bodies.disk import Disk
from ..bodies.families import named_by
from ..bodies.model import FLAT, LIFT_OFF, NO_CONTACT, TAKEN, Dry, Model
from ..bodies.newton_euler import STATES
from ..bodies.quantities import SYSTEM
from ..bodies.resistance import UNITS, Resistance, resistances
from ..bodies.round_body.body import Body
from ..bodies.round_body.equations import Resistances
from ..bodies.round_body.models.angle_model import round_model
from ..bodies.round_body.models.pole_model import pole_model
from ..bodies.round_body.pole_equations import smooth_at
from ..bodies.round_body.shape import RoundShape
from ..bodies.round_body.thin import unit_disk
from ..bodies.thin_disk import disk_model
from ..integrators.flow import flow_of
from ..integrators.stick_slip import REST, continuations
from ..settling.body_lines import body_settling
from ..settling.settling import Nearest, Settling
from ..systems.system import System
from .result import Outcome
from .starts import (
    MotionSubject,
    Starts,
    Unfit,
    by_name,
    counted,
    nearest_families,
    place_in,
    times_of,
)

FASTEST = 1e9
"""Largest dimensionless rate or slip of a start: beyond it forces are lost in rounding."""
ROUGHEST = 1e8
"""Largest dimensionless friction."""
FLAT_AT_BOTH = (
    "theta must lie strictly between 0 and π, because the disk is flat at both and its equations "
    "of motion end there"
)
"""Why the disk's inclination has ends."""
LONGEST, BRIEFEST = 1e12, 1e-200
"""Range of the last time, dimensionless."""


def gather_round(
    body: Disk | Body,
    contact: Any,
    start: Any,
    times: ArrayLike | None,
    *,
    numbers: Mapping[str, Any] | None = None,
    families: Any = (),
    resistance: Any = None,
    pose: bool = False,
    mark: bool = False,
) -> Starts:
    """As `stability.motion.gather.launches_of`, of a disk or body."""
    contact = law_only(contact, dict(numbers or {}), motion=True)
    if not isinstance(families, Sequence) or families:
        raise ParameterError("families belong to a stability.System; leave them out.")
    accepted(contact)
    with np.errstate(all="ignore"):  # an overflow is refused by _check
        return _gathered(body, contact, start, times, resistance, pose=pose, mark=mark)


def accepted(contact: Any) -> type[Contact]:
    """The class of a law that a motion can have.

    Parameters
    ----------
    contact
        The law.

    Raises
    ------
    StabilityError
        If it is none.
    """
    if contact is None:
        raise law_missing(MOTION_LAWS)
    if not isinstance(contact, Contact) or not contact.name:
        raise NameUnknownError(f"contact is {shown(contact)}; give one of {spelled(MOTION_LAWS)}.")
    return law_class(type(contact))


def _acting(body: RoundShape, contact: Contact, argument: Any) -> tuple[Resistance, ...]:
    """The resistances of a call that are not zero everywhere."""
    acting = tuple(r for r in resistances(argument) if np.any(r.value))
    for r in acting:
        if r.coefficient in {*body.given, *contact.given, *contact.symbols()}:
            raise ParameterError(
                f"{r.coefficient} is the coefficient of {r.name}, and a number of {body.name} or "
                f"of the {contact.name} law; give that another name."
            )
    return acting


def _model(
    body: RoundShape,
    law: type[Contact],
    parameters: tuple[str, ...],
    resistance: Resistances,
    *,
    pose: bool,
) -> Model:
    """Fixed axes where the body can pass a pole, and otherwise angles."""
    if smooth_at(body, 1) or smooth_at(body, -1):
        with suppress(ParameterError):  # of a law that needs the directions that angles give
            return pole_model(body, law, parameters, pose=pose, resistance=resistance)
    return round_model(body, law, parameters, pose=pose, resistance=resistance)


def _check_names(body: RoundShape, model: Model) -> None:
    """Refuse a number of the shape with a name that the motion has for itself."""
    for name in body.shape:
        if (
            name in TAKEN
            or name in model.series
            or name in {*model.names, "kinetic", "determinant"}
        ):
            raise ParameterError(
                f"{body.name} has a number called {name!r}, a name that a motion has for itself; "
                "give it another one."
            )


@dataclass(frozen=True, eq=False, kw_only=True)
class _BodySubject(MotionSubject):
    """A disk or another body, whose quantities have kinds."""

    def in_units(self, launches: Starts, series: dict[str, Floats]) -> dict[str, Floats]:
        series["kinetic"] = series["energy"] - series["potential"]
        kinds = {n: q.kind for n, q in launches.model.quantities.items() if n in series}
        if launches.dimensionless:
            return {n: series[n] for n in kinds}
        sizes = {kind: launches.size(kind)[..., None] for kind in set(kinds.values())}
        return {n: series[n] * sizes[kind] for n, kind in kinds.items()}

    def energy_scale(self, launches: Starts, *_: Any) -> Floats:
        """The energy at the start, which is positive."""
        return np.asarray(launches.energies * launches.size(Kind.ENERGY))

    def nearest(self, launches: Starts, near: Sequence[Nearest], variable: Any) -> dict[str, Any]:
        kinds = [named_by(n.family) for n in near]
        sizes = {kind: np.broadcast_to(launches.size(kind), len(near)) for kind in set(kinds)}
        which = enumerate(zip(near, kinds, strict=True))
        at = np.array([n.at * sizes[kind][i] for i, (n, kind) in which])
        words = "dimensionless distance from it"
        return nearest_families(near, variable, words) | {"nearest_at": variable(at, **self.member)}


@lru_cache(maxsize=64)
def _subject(
    name: str,
    law: str,
    formula: str,
    settling: Settling,
    against: tuple[type[Resistance], ...],
    *,
    dimensionless: bool,
) -> _BodySubject:
    numbers = list(dict.fromkeys(line.along[0] for line in settling.lines))
    words = f"its {listed(numbers, 'or')}" if numbers else "the number that names it"
    rate = f"{Kind.ANGULAR_VELOCITY.si} (theta: {Kind.ANGLE.si})"
    body = {} if name.startswith(SYSTEM) else {"body": name.rpartition(", ")[0]}
    return _BodySubject(
        attributes=body | {"contact": law, "law": formula, "dimensionless": int(dimensionless)},
        cited=partial(cited, law, model=True),
        outcomes=tuple(Outcome),
        energy_error="largest |audit| over the energy at the start",
        member={"long_name": words, "units": "1" if dimensionless else rate},
        numbers={
            r.coefficient: {"long_name": r.name, "units": "1" if dimensionless else r.unit}
            for r in against
        },
        settings=("flat",),
        slips=True,
    )


def _gathered(
    body: Disk | Body,
    contact: Contact,
    start: Any,
    times: ArrayLike | None,
    resistance: Any,
    *,
    pose: bool,
    mark: bool,
) -> Starts:
    law = type(contact)
    outline: RoundShape = unit_disk() if isinstance(body, Disk) else body
    disk = outline is unit_disk()
    against = _acting(outline, contact, resistance)
    every = outline, law, law.symbols(), tuple(type(r) for r in against)
    settling = body_settling(*every)
    model = disk_model(law, pose=pose, resistance=every[-1]) if disk else _model(*every, pose=pose)
    _check_names(outline, model)
    six, when = six_states(start, contact), times_of(times)
    fields = body.given | contact.given | {r.coefficient: r.value for r in against}
    shape = broadcast(start=six.shape[:-1], **{n: np.shape(v) for n, v in fields.items()})
    count = counted(shape, when)
    flat = {
        n: a
        if (a := np.asarray(v, dtype=float)).ndim == 0
        else np.broadcast_to(a, shape).reshape(-1)
        for n, v in fields.items()
    }
    units = Units(flat["mass"], flat["radius" if disk else "length"], flat["gravity"], np.sqrt)
    starts = np.empty((*shape, 6))
    starts[...] = six
    starts = starts.reshape(count, 6)
    starts[:, 1:4] *= np.asarray(units.time)[..., None]
    starts[:, 4:] /= np.asarray(units.speed)[..., None]
    if law.holds:
        starts[:, 4:] = 0.0
    dimensionless = {**flat, **contact.arguments(flat, units)}
    sizes = dict(zip(UNITS, (units.mass, units.length, units.time, units.force), strict=True))
    for r in against:
        dimensionless[r.coefficient] = replace(
            r, **{r.coefficient: flat[r.coefficient]}
        ).dimensionless(sizes)
    p = np.empty((count, len(model.system.parameters)))
    for column, name in zip(p.T, model.system.parameters, strict=True):
        column[:] = dimensionless[name]
    last = when[-1] / units.time
    if not (np.all(last <= LONGEST) and np.all(last >= BRIEFEST)):
        raise ParameterError(
            f"times end at {when[-1]:g}; in units of √({'R' if disk else 'length'}/g) give a last "
            f"time from {BRIEFEST:g} to {LONGEST:g}."
        )
    energies, unfit = _check(outline, model, contact, shape, starts, p, mark=mark)
    return Starts(
        model,
        shape,
        starts,
        p,
        when,
        flat,
        units,
        body.dimensionless,
        energies,
        settling,
        _subject(
            model.system.name,
            contact.name,
            contact.formula,
            settling,
            every[-1],
            dimensionless=body.dimensionless,
        ),
        law,
        unfit,
        law.name,
    )


def six_states(start: Any, contact: Contact) -> Floats:
    """The six states of a start as numbers, shape (…, 6)."""
    if start is None:
        raise ParameterError(
            "start is missing; give the states by name or in order: theta at least."
        )
    if isinstance(start, Mapping):
        six = by_name("start", start, STATES, 0.0)
        if "theta" not in start:
            raise ParameterError("start does not name theta; give at least theta [rad].")
    else:
        six = np.asarray(checked("start", start), dtype=float)
        if six.shape[-1:] == (4,) and not contact.slips:
            six = np.concatenate([six, np.zeros((*six.shape[:-1], 2))], axis=-1)
        six = rows("start", six, STATES)
    if contact.holds and (six[..., 4:] != 0).any():
        why = "follows from the other states" if contact.given else "is 0"
        raise ParameterError(
            f"slip_x, slip_y of start are {six[..., 4:].reshape(-1, 2).max(axis=0).tolist()}; the "
            f"slip of the {contact.name} contact {why}, so leave them out or give 0."
        )
    return six


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


@lru_cache(maxsize=64)
def _look(model: Model) -> Program:
    """The conditions of a model's system, then gn and the energy."""
    return _seen(model.system)


@lru_cache(maxsize=32)
def _look_held(dry: Dry) -> Program:
    """The same for a body that is held at rest."""
    return _seen(dry.held)


def _seen(system: System) -> Program:
    seen = system.observables
    values = [c.value for c in system.conditions] + [seen["normal_force"], seen["energy"]]
    column = ca.densify(ca.vertcat(*values))
    return Program(ca.Function("start", [system.x, system.p], [column]))


def _look_at_rest(dry: Dry, starts: Floats, p: Floats, values: Floats) -> None:
    """Fill in what a start without slip needs to be positive: dry friction is set-valued there."""
    rest = np.flatnonzero(np.hypot(starts[:, 4], starts[:, 5]) <= REST)
    if not len(rest):
        return
    four, held = list(starts[rest, :4].T), dry.at_rest(p[rest].T)
    values[rest] = _look_held(dry).arrays([four, held], rest.shape)[0][..., 0]
    for row in rest:
        # without sticking the body may slip, or do neither although gn of sticking is positive
        pressed, normal = continuations(dry, starts[row, :4], p[row]).pressed, values[row, -2]
        values[row, -2] = max(normal, 1e-300) if pressed else min(normal, 0.0)


def _check(
    outline: RoundShape,
    model: Model,
    contact: Contact,
    shape: tuple[int, ...],
    starts: Floats,
    p: Floats,
    *,
    mark: bool,
) -> tuple[Floats, Unfit | None]:
    """Energies of the starts; a start without contact is marked, or refused with the reason."""
    system, theta = model.system, starts[:, 0]
    zeros = {parameter.place for parameter in contact.parameters if parameter.zero}
    forces = {n: p[:, system.parameters.index(n)] for n in contact.symbols()}
    lost = any((v < 0).any() or (n not in zeros and (v == 0).any()) for n, v in forces.items())
    if lost or not (np.isfinite(p).all() and np.abs(starts).max() < FASTEST):
        raise ParameterError(
            "a dimensionless number of the start or the body leaves the range of double precision "
            f"(rates up to {FASTEST:g}); give values nearer to 1."
        )
    for name, values in forces.items():
        if values.max() > ROUGHEST:
            raise ParameterError(
                f"the dimensionless {name} is {values.max():.3g}, above {ROUGHEST:g}, where double "
                "precision cannot resolve the slip; take Rough(), to which the motion tends."
            )
    low, high = outline.between
    inside = (theta > low) & (theta < high)
    if model.chart:  # a smooth pole belongs to the motion
        for pole, end in ((1, low), (-1, high)):
            inside |= (theta == end) & smooth_at(outline, pole)
    disk = outline is unit_disk()
    if not (mark or inside.all()):
        row = int(np.argmin(inside))
        why = f"the height of {outline.name} holds for theta between {low:.6g} and {high:.6g}"
        why = FLAT_AT_BOTH if disk else why
        raise DomainError(
            f"start{place_in(shape, row)}: theta is {theta[row]:g}; {why}"
            f"{if_degrees(float(theta[row]))}."
        )
    packed = flow_of(model).pack(starts)[:, : len(system.states)]
    seen = _look(model).arrays([list(packed.T), list(p.T)], starts.shape[:1])[0][..., 0]
    if model.dry is not None:
        _look_at_rest(model.dry, starts, p, seen)
    positive = seen[:, :-1] > 0
    if not (mark or positive.all()):
        row, column = (int(i) for i in np.argwhere(~positive)[0])
        where, value = place_in(shape, row), float(seen[row, column])
        if column < len(system.conditions):
            raise DomainError(f"start{where}: {system.conditions[column].refusal(value)}")
        raise DomainError(
            f"start{where}: the normal force is {value:.4g} m g, which is not positive: "
            f"the {'disk' if disk else 'body'} is not in contact; turn it slower."
        )
    energies: Floats = seen[:, -1]
    fit = np.column_stack([inside, positive])
    return energies, unfit_of(fit, [FLAT], len(system.conditions) + 1)
