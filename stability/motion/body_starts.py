"""Launches of a body of revolution: starts and parameters, checked and made dimensionless."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike

from ..algebra.program import Program
from ..base.checks import broadcast
from ..base.errors import DomainError, NameUnknownError, ParameterError, if_degrees, shown
from ..base.quantities import Units
from ..base.types import Floats
from ..bodies.contact import Contact
from ..bodies.contact_laws import MOTION_LAWS, law_missing, spelled
from ..bodies.model import TAKEN, Dry, Model
from ..bodies.resistance import UNITS, Resistance, resistances
from ..bodies.round_body.body import Body
from ..bodies.round_body.equations import Resistances
from ..bodies.round_body.models.angle_model import round_model
from ..bodies.round_body.models.pole_model import pole_model
from ..bodies.round_body.pole_equations import smooth_at
from ..bodies.thin_disk.disk_model import FLAT
from ..integrators.flow import flow_of
from ..integrators.friction_at_rest import continuations, sticking_force
from ..integrators.stick_slip import REST
from ..settling.body_lines import body_settling
from .starts import (
    BRIEFEST,
    FASTEST,
    LONGEST,
    ROUGHEST,
    Starts,
    Unfit,
    counted,
    six_states,
    times_of,
    unfit_of,
)


def gather_body(
    body: Body, contact: Contact, start: Any, times: ArrayLike, *, pose: bool = False,
    mark: bool = False, resistance: Any = None,
) -> Starts:  # fmt: skip
    """Check the arguments of `simulate` for a body of revolution and make them dimensionless.

    Parameters
    ----------
    body, contact, start, times, pose, mark
        As for `gather`.
    resistance
        As for `simulate`.

    Returns
    -------
    Starts

    Raises
    ------
    StabilityError
        In one sentence, if something is not accepted.
    """
    law = accepted(contact)
    with np.errstate(all="ignore"):  # an overflow is refused by _check
        against = _acting(body, contact, resistance)
        return _gathered(body, contact, law, start, times, against, pose=pose, mark=mark)


def _acting(body: Body, contact: Contact, given: Any) -> tuple[Resistance, ...]:
    """The resistances of a call that are not zero everywhere."""
    found = tuple(r for r in resistances(given) if np.any(r.value))
    for r in found:
        if r.coefficient in body.given | contact.given:
            raise ParameterError(
                f"{r.coefficient} is the coefficient of {r.name}, and a number of {body.name} or "
                f"of the {contact.name} law; give that another name."
            )
    return found


def accepted(contact: Any) -> type[Contact]:
    """The class of a law that a body's motion can have.

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
    return type(contact)


def _gathered(
    body: Body, contact: Contact, law: type[Contact], start: Any, times: ArrayLike,
    against: tuple[Resistance, ...], *, pose: bool, mark: bool,
) -> Starts:  # fmt: skip
    six, when = six_states(start, contact), times_of(times)
    fields = body.given | contact.given | {r.coefficient: r.value for r in against}
    kinds = tuple(type(r) for r in against)
    model = _model(body, law, tuple(contact.given), kinds, pose=pose)
    _check_names(body, model)
    shape = broadcast(start=six.shape[:-1], **{n: np.shape(v) for n, v in fields.items()})
    count = counted(shape, when)
    flat = {
        n: a if (a := np.asarray(v, dtype=float)).ndim == 0
        else np.broadcast_to(a, shape).reshape(-1)
        for n, v in fields.items()
    }  # fmt: skip
    units = Units(flat["mass"], flat["length"], flat["gravity"], np.sqrt)
    starts = np.broadcast_to(six, (*shape, 6)).reshape(count, 6).copy()
    starts[:, 1:4] /= np.asarray(units.rate)[..., None]
    starts[:, 4:] /= np.asarray(units.speed)[..., None]
    if law.holds:
        starts[:, 4:] = 0.0
    own = flat | {p.name: p.dimensionless(flat[p.name], units)
                  for p in law.parameters if p.name in flat}  # fmt: skip
    own_units = flat["mass"], flat["length"], units.time, units.force
    sizes = dict(zip(UNITS, own_units, strict=True))
    own |= {r.coefficient: replace(r, **{r.coefficient: flat[r.coefficient]}).dimensionless(sizes)
            for r in against}  # fmt: skip
    columns = [np.broadcast_to(own[n], (count,)) for n in model.system.parameters]
    p = np.column_stack(columns) if columns else np.zeros((count, 0))
    last = when[-1] / units.time
    if not (np.all(last <= LONGEST) and np.all(last >= BRIEFEST)):
        raise ParameterError(
            f"times end at {when[-1]:g}; in units of √(length/g) give a last time from "
            f"{BRIEFEST:g} to {LONGEST:g}."
        )
    energies, unfit = _check(body, model, contact, shape, starts, p, mark=mark)
    return Starts(
        model, shape, starts, p, when, flat, units, body.dimensionless, energies,
        body_settling(body, law, tuple(contact.given), kinds), law, unfit,
    )  # fmt: skip


def _look_at_rest(dry: Dry, starts: Floats, p: Floats, values: Floats) -> None:
    """Fill in what a start without slip needs to be positive: dry friction is set-valued there."""
    for row in np.flatnonzero(np.hypot(starts[:, 4], starts[:, 5]) <= REST):
        four, held = starts[row, :4], dry.at_rest(p[row])
        conditions = dry.held.condition_program.quick([list(four), held], ())
        energy = float(dry.held.observe(four, held)["energy"])
        normal, _, _ = sticking_force(dry, four, p[row])
        # without sticking the body may slip, or do neither although gn of sticking is positive
        pressed = continuations(dry, four, p[row]).pressed
        normal = max(normal, 1e-300) if pressed else min(normal, 0.0)
        values[row] = [*np.ravel(conditions), normal, energy]


def _model(
    body: Body, law: type[Contact], given: tuple[str, ...], resistance: Resistances, *, pose: bool
) -> Model:
    """Fixed axes where the body can pass a pole, and otherwise angles."""
    if smooth_at(body, 1) or smooth_at(body, -1):
        with suppress(ParameterError):  # of a law that needs the directions that angles give
            return pole_model(body, law, given, pose=pose, resistance=resistance)
    return round_model(body, law, given, pose=pose, resistance=resistance)


def _check_names(body: Body, model: Model) -> None:
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


def _check(
    body: Body, model: Model, contact: Contact, shape: tuple[int, ...], starts: Floats, p: Floats,
    *, mark: bool,
) -> tuple[Floats, Unfit | None]:  # fmt: skip
    """Energies of the starts; a start without contact is marked, or refused with the reason."""
    if not (np.isfinite(starts).all() and np.isfinite(p).all() and np.abs(starts).max() < FASTEST):
        raise ParameterError(
            "a dimensionless number of the start or the body leaves the range of double precision "
            f"(rates up to {FASTEST:g}); give values nearer to 1."
        )
    for name in contact.given:
        most = p[:, model.system.parameters.index(name)].max()
        if most > ROUGHEST:
            raise ParameterError(
                f"the dimensionless {name} is {most:.3g}, above {ROUGHEST:g}, where double "
                "precision cannot resolve the slip; take Rough(), to which the motion tends."
            )
    (low, high), theta = body.between, starts[:, 0]
    inside = (theta > low) & (theta < high)
    if model.chart:  # a smooth pole belongs to the motion
        for pole, end in ((1, low), (-1, high)):
            inside |= (theta == end) & smooth_at(body, pole)
    if not (mark or inside.all()):
        row = int(np.argmin(inside))
        where = f" {[int(j) for j in np.unravel_index(row, shape)]}" if shape else ""
        raise DomainError(
            f"start{where}: theta is {theta[row]:g}; the height of {body.name} holds for theta "
            f"between {low:.6g} and {high:.6g}{if_degrees(float(theta[row]))}."
        )
    system = model.system
    seen = system.observables
    conditions = [c.value for c in system.conditions]
    look = Program(ca.Function("start", [system.x, system.p], [
        ca.densify(ca.vertcat(*conditions, seen["normal_force"], seen["energy"]))
    ]))  # fmt: skip
    own = flow_of(model).pack(starts)[:, : len(system.states)]
    values = look.arrays([list(own.T), list(p.T)], starts.shape[:1])[0][..., 0]
    if model.dry is not None:
        _look_at_rest(model.dry, starts, p, values)
    bad = np.argwhere(~(values[:, :-1] > 0))
    fit = np.column_stack([inside, values[:, :-1] > 0])
    if len(bad) and not mark:
        row, column = (int(i) for i in bad[0])
        where = f" {[int(j) for j in np.unravel_index(row, shape)]}" if shape else ""
        value = float(values[row, column])
        if column < len(conditions):
            raise DomainError(f"start{where}: {system.conditions[column].refusal(value)}")
        raise DomainError(
            f"start{where}: the normal force is {value:.4g} m g, which is not positive: "
            "the body is not in contact; turn it slower."
        )
    found: Floats = values[:, -1]
    return found, unfit_of(fit, [FLAT], len(conditions) + 1)
