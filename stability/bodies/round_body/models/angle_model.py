"""The model of a body of revolution for a launch, in the disk's angles."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache, partial
from typing import Any

import casadi as ca
import numpy as np

from ....base.quantities import Kind, Quantity
from ....systems.system import System
from ...contact_laws import DIRECTION, MU, Contact, CoulombAlong, Creep, Rough
from ...creep import CREEPS
from ...explicit import ContactGeometry, angular_velocity, explicit, surface
from ...model import (
    CONE,
    CREEP_ENDS,
    FLAT,
    LIFT_OFF,
    NO_CONTACT,
    POSE,
    WORDS,
    WORK,
    Dry,
    Held,
    Model,
    placed,
)
from ...newton_euler import STATES
from ...quantities import disk_quantities
from ...resistance import total_moment
from ..equations import Resistances, held_round, rough_round, round_system
from ..height.pole_height import height_of_angle
from ..shape import RoundShape
from ..si_law import BodySymbols, Law, Shape, shape_of
from ..thin import is_thin, of_thin

LOWEST, HIGHEST = "lower end of theta", "upper end of theta"
"""Names of the guards of the ends of a height, other than those at which the body lies flat."""
LEVEL = 1e-9
"""Smallest slope of the height at a pole, over the height, of a body that falls flat there."""


def round_model(
    body: RoundShape,
    law: type[Contact],
    parameters: tuple[str, ...],
    *,
    pose: bool,
    resistance: Resistances = (),
) -> Model:
    """A body under a contact law, dimensionless; built once for each.  Of dry friction, sliding.

    Parameters
    ----------
    body
        The body; of its numbers only the names matter.
    law
        Class of the law.
    parameters
        Names of the law's parameters, in the order of `round_system`.
    pose
        Whether y holds φ, ψ and the place of the centre.
    resistance
        Classes of the resistances to rolling and turning.

    Returns
    -------
    Model

    Raises
    ------
    ParameterError
        If the law is made for the disk alone.

    Examples
    --------
    >>> from stability.bodies.contact_laws import Viscous
    >>> from stability.bodies.round_body.shapes.named import ThickDisk
    >>> list(round_model(ThickDisk(0.1), Viscous, ("mu",), pose=False).guards)
    ['lift-off', 'flat', 'upper end of theta', 'no-contact']
    """

    def system(contact: type[Contact], names: tuple[str, ...]) -> System:
        return round_system(
            body, contact, names, physical=False, slip_states=True, resistance=resistance
        )

    at_rest = None
    if law.sticks:
        at_rest = system(CoulombAlong, (*parameters, DIRECTION)), system(Rough, ())
    kind: Any = law  # a class is hashable
    return _round_model(
        system(law, parameters),
        shape_of(body),
        flat_poles(body),
        kind,
        parameters,
        resistance,
        bool(pose),
        at_rest,
        sticking=False,
    )


def flat_poles(body: RoundShape) -> tuple[bool, bool]:
    """Whether the body falls flat at θ = 0 and at θ = π: the contact stays away from the axis.

    Examples
    --------
    >>> from stability.bodies.round_body.shapes.named import EccentricSphere, ThickDisk
    >>> flat_poles(EccentricSphere(0.1)), flat_poles(ThickDisk(0.1))
    ((False, False), (True, False))
    """
    flat = []
    for reached, end in zip(
        (body.between[0] == 0, body.between[1] == math.pi), (0.0, math.pi), strict=True
    ):
        with np.errstate(all="ignore"):
            slope, height = body.height_at(end, 1), body.height_at(end)
        flat.append(bool(reached and not (np.abs(slope) <= LEVEL * np.abs(height)).all()))
    return flat[0], flat[1]


@lru_cache(maxsize=32)
def _round_model(  # noqa: PLR0913
    system: System,
    of: Shape,
    flat_at: tuple[bool, bool],
    law: type[Contact],
    parameters: tuple[str, ...],
    resistance: Resistances,
    pose: bool,  # noqa: FBT001
    at_rest: tuple[System, System] | None,
    *,
    sticking: bool,
) -> Model:
    name, height, _, shape, between = of
    p, mu, dry = system.p, ca.SX.sym(MU), None
    if at_rest is not None and sticking:  # the parameters of sliding
        sliding, system = system, at_rest[1]
        symbols = dict(zip(system.parameters, ca.vertsplit(system.p), strict=True)) | {MU: mu}
        p = ca.vertcat(*(symbols[n] for n in sliding.parameters))
    elif at_rest is not None:
        every: Any = system, of, flat_at, law, parameters, resistance, pose, at_rest
        dry = Dry(*at_rest, partial(_round_model, *every, sticking=True))
    x, seen, flat = system.x, system.observables, ca.SX.sym("flat")
    h = height_of_angle(height, x[0], ca.vertsplit(system.p)[: len(shape)])
    columns, names = [x, ca.SX.sym(WORK)], [*system.states, WORK]
    normal, determinant = seen["normal_force"], seen["determinant"]
    rates, pressing = [system.rhs, seen["power"]], normal * determinant
    if len(system.states) == len(STATES):
        solved = _solved(system, of, law, parameters, resistance)
        rates, pressing, determinant = [*solved[:2]], solved[2], solved[3]
    series = series_of(seen, h)
    if pose:
        extra = ca.SX.sym("pose", len(POSE))
        columns.append(extra)
        velocity = seen["slip"][0] + x[1] * h, seen["slip"][1] - seen["rim_speed"]
        rates.append(placed(x, *velocity, extra))
        names += POSE
        series["reach"] = seen["lever"]
    guards, words = _end_guards(x[0], flat, between, flat_at)
    guards = {LIFT_OFF: pressing} | guards
    if sticking:
        guards[CONE] = (mu * normal) ** 2 - ca.sumsqr(seen["contact_force"])
    elif ca.depends_on(determinant, x[4:]):
        guards[NO_CONTACT] = determinant
    if issubclass(law, Creep):
        [guards[CREEP_ENDS]] = (c.value for c in system.conditions if c.sentence == CREEPS)
        series |= {"slip_x": seen["slip"][0], "slip_y": seen["slip"][1]}
    held = None
    if law.relaxes:
        held = Held(
            partial(_rough_model, of, flat_at, resistance), partial(held_round, of, resistance)
        )
    model = Model(
        system,
        STATES,
        ca.vertcat(*columns),
        ca.vertcat(p, flat),
        ca.vertcat(*rates),
        tuple(names),
        guards,
        WORDS | words,
        series,
        quantities_with(law, shape),
        parameters[0] if law.relaxes else "",
        turning=(1, 2, 3),
        sliding=() if law.sticks or len(system.states) < 6 else (4, 5),
        dry=dry,
        held=held,
        title=f"motion of {name}, {law.name} contact",
        source=system.qualified(
            "equations of a convex body of revolution (docs/explanation/bodies.md), integrated"
        ),
    )
    return of_thin(model, law) if is_thin(of) else model


def series_of(seen: Mapping[str, ca.SX], height: ca.SX) -> dict[str, ca.SX]:
    """The series that a motion of any body reports beyond its states, in the axes of its model."""
    return {
        "energy": seen["energy"],
        "potential": height,
        "normal_force": seen["normal_force"],
        "force_x": seen["contact_force"][0],
        "force_y": seen["contact_force"][1],
        "power": seen["power"],
    }


def _solved(
    system: System,
    of: Shape,
    law: type[Contact],
    parameters: tuple[str, ...],
    resistance: Resistances,
) -> tuple[ca.SX, ca.SX, ca.SX, ca.SX]:
    """Rates of the states, the dissipated power, N D and D, in few operations."""
    numbers = BodySymbols.of(
        of, (*parameters, *(r.coefficient for r in resistance)), physical=False
    )
    stated, x = Law(law, numbers.table, parameters), system.x
    against = [(r, numbers.table[r.coefficient]) for r in resistance]

    def moment(turn: Any, normal: Any) -> Any:
        return total_moment(against, turn, normal)

    at, moments = ca.SX.sym("at"), (numbers.table["transverse"], numbers.table["axial"])
    at_symbol = surface(at, height_of_angle(of[1], at, numbers.shape_symbols), *moments)
    places = ca.cse(ca.densify(ca.vertcat(*at_symbol[:7])))
    h, slope, curve, r, z, s, c = ca.vertsplit(ca.substitute(places, at, x[0]))
    body = ContactGeometry(h, slope, curve, r, z, s, c, *moments)
    solution = explicit(x, body, stated.force, moment if against else None)
    power = stated.power([x[4], x[5]], solution.normal)
    if against:
        turn = angular_velocity(x)
        power -= ca.dot(ca.vertcat(*moment(turn, solution.normal)), ca.vertcat(*turn))
    every = [solution.rates, ca.SX(power), solution.pressing, solution.determinant]
    rates, power, pressing, determinant = ca.substitute(every, [numbers.p], [system.p])
    return rates, power, pressing, determinant


def _rough_model(of: Shape, flat_at: tuple[bool, bool], resistance: Resistances) -> Model:
    kind: Any = Rough
    return _round_model(
        rough_round(of, resistance), of, flat_at, kind, (), resistance, False, None, sticking=False
    )


def _end_guards(
    theta: ca.SX, flat: ca.SX, between: tuple[float, float], flat_at: tuple[bool, bool]
) -> tuple[dict[str, ca.SX], dict[str, str]]:
    """Guards of the ends of θ, and their words."""
    low, high = between
    guards, words = {}, {}
    if all(flat_at):
        guards[FLAT] = ca.sin(theta) - flat
    elif any(flat_at):
        guards[FLAT] = (theta if flat_at[0] else math.pi - theta) - flat
    ends = (theta - low, low, True), (high - theta, high, False)
    for (value, end, lower), lies in zip(ends, flat_at, strict=True):
        if not lies:
            name, words_there = words_of_end(end, lower=lower)
            guards[name] = value - flat if end in (0, math.pi) else value
            words[name] = words_there
    return guards, words


def words_of_end(end: float, *, lower: bool) -> tuple[str, str]:
    """Name of the guard of an end of θ at which a body does not fall flat, and its words.

    Parameters
    ----------
    end
        The end [rad].
    lower
        Whether it is the lower one.
    """
    why = "the body may change there to another rim or face"
    if end in (0, math.pi):
        why = "the axis is vertical, where the angles have no meaning"
    said = f"theta has reached {end:.6g}, where the height of the body ends: {why}"
    return (LOWEST if lower else HIGHEST), said


def quantities_with(
    law: type[Contact], shape: tuple[str, ...], axis: tuple[str, ...] = ()
) -> Mapping[str, Quantity]:
    """The quantities of a body's motion: those of the disk, its own length and shape, its axis.

    Parameters
    ----------
    law
        Class of the law.
    shape
        Names of the shape's numbers.
    axis
        Names of the components of the axis, where a motion reports them.
    """
    quantities = dict(disk_quantities(law))
    quantities["slip_x"] = replace(
        quantities["slip_x"], long_name="slip along x̂, away from the axis"
    )
    quantities["slip_y"] = replace(quantities["slip_y"], long_name="slip along ŷ, across the axis")
    quantities["length"] = Quantity("length", "", "length of the body", Kind.LENGTH)
    of_shape = {n: Quantity(n, n, n, Kind.NUMBER) for n in (*shape, "axial", "transverse")}
    words = (f"symmetry axis along {n}" for n in "XYZ")
    of_axis = {n: Quantity(n, "", w, Kind.NUMBER) for n, w in zip(axis, words, strict=False)}
    return of_shape | quantities | of_axis
