"""A body of revolution under a contact law as a `System`, for every height h(θ).

Units are SI: with m = g = length = 1 the numbers are dimensionless.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache

import casadi as ca

from ...algebra.program import Program
from ...base.quantities import Units
from ...systems.equations import Condition, eliminate
from ...systems.system import System
from ..contact_laws import CREEP, Contact, Creep, Rough
from ..creep import CREEPS, follows, slip_of
from ..explicit import surface
from ..held_motion import SLIP, held_in_angles
from ..newton_euler import STATES, NewtonEuler
from ..quantities import round_quantities
from ..resistance import Resistance
from .height.pole_height import height_of_angle
from .shape import RoundShape, of_fit
from .si_law import BodySymbols, Law, Shape, shape_of
from .thin import is_thin

Resistances = tuple[type[Resistance], ...]


def round_system(
    body: RoundShape,
    law: type[Contact],
    parameters: tuple[str, ...],
    *,
    physical: bool,
    slip_states: bool = False,
    resistance: Resistances = (),
) -> System:
    """A body under a contact law as a `System`, built once for each.

    Parameters
    ----------
    body
        The body; its numbers do not matter, only their names.
    law
        Class of the law.
    parameters
        Names of the law's parameters, which become parameters of the system.
    physical
        Whether mass, gravity and length are parameters too; otherwise they are 1.
    slip_states
        Whether the smooth body has its slip in the state too, as a motion needs.
    resistance
        Classes of the resistances to rolling and turning, whose coefficients are parameters too.

    Returns
    -------
    System
        States `STATES` (the first four for a law without slip in the state).  Parameters: numbers
        of the shape, moments that are numbers, scales, and those of the law.  Observables:
        `energy`, `normal_force`, `contact_force` (x̂ and ŷ), `slip`, `determinant` (D over
        m·length²), `power` (dissipated), `rim_speed` (of the point of contact about the centre,
        along ŷ; it vanishes where the centre rests and nothing slips), `lever` (h', the distance of
        the contact point from the foot of the centre along x̂).
    """
    slips = law.slips or (slip_states and not law.holds)
    return _system(shape_of(body), law, parameters, physical, resistance, slips)  # type: ignore[arg-type]  # a class is hashable


@lru_cache(maxsize=64)
def _system(  # noqa: PLR0913
    shape: Shape,
    law: type[Contact],
    parameters: tuple[str, ...],
    physical: bool,  # noqa: FBT001
    resistance: Resistances,
    slips: bool,  # noqa: FBT001
) -> System:
    name, height, *_ = shape
    numbers = BodySymbols.of(
        shape, (*parameters, *(r.coefficient for r in resistance)), physical=physical
    )
    states = STATES if slips else STATES[:4]
    x = ca.SX.sym("x", len(states))
    along = height_of_angle(height, x[0], numbers.shape_symbols)

    def below(order: int) -> System:
        names = parameters if order else ()
        return _system(shape, CREEP[order], names, physical, resistance, False)  # type: ignore[arg-type]  # a class is hashable

    slip, creeps = None, []
    if issubclass(law, Creep):
        mass, length, gravity = (numbers.table[n] for n in ("mass", "length", "gravity"))
        units = Units(mass, length, gravity, ca.sqrt)
        slip = slip_of(law, below(law.order - 1), x, numbers.table)
        creeps = [Condition(follows(below(0), x, numbers.table, units), CREEPS)]
    body = _body(x, along, numbers, Law(law, numbers.table, parameters), slips, slip, resistance)
    system = System.from_mass_matrix(
        f"{name}, {law.name}",
        x,
        numbers.p,
        *body.implicit_form(),
        unknowns=body.unknown_names,
        rates={"theta": x[1]},
        pivots=body.pivots,
        observables=body.observables,
        conditions=_conditions(x, shape, creeps),
        states=states,
        parameters=numbers.names,
    )
    return with_quantities(system, shape, law, resistance, physical=physical)


def rough_round(shape: Shape, resistance: Resistances) -> System:
    """The body that does not slip, dimensionless."""
    return _system(shape, Rough, (), False, resistance, False)


@lru_cache(maxsize=32)
def held_round(shape: Shape, resistance: Resistances) -> tuple[Program, Program]:
    """A body held to a slip in its angles, dimensionless: see `held_programs`."""
    numbers = BodySymbols.of(shape, [r.coefficient for r in resistance], physical=False)
    x = ca.SX.sym("x", 4)
    along = height_of_angle(shape[1], x[0], numbers.shape_symbols)
    law, slip = Law(Rough, numbers.table, ()), ca.vertsplit(SLIP)
    return held_in_angles(_body(x, along, numbers, law, False, slip, resistance), numbers.p)


def _body(  # noqa: PLR0913
    x: ca.SX,
    along: ca.SX,
    numbers: BodySymbols,
    law: Law,
    slips: bool,  # noqa: FBT001
    slip: list[ca.SX] | None = None,
    resistance: Resistances = (),
) -> NewtonEuler:
    """The equations of a body with a height, in the units of its numbers."""
    table, length = numbers.table, numbers.table["length"]
    square = law.mass * length * length
    moments = square * table["transverse"], square * table["axial"]
    return NewtonEuler(
        x,
        surface(x[0], along, *moments, length),
        law,
        slips,
        slip,
        mass=law.mass,
        weight=law.weight,
        square=square,
        against=[(r, table[r.coefficient]) for r in resistance],
    )


def conditions_along(
    shape: Shape,
    law: type[Contact],
    parameters: Sequence[str],
    numbers: BodySymbols,
    x: ca.SX,
    along: ca.SX,
) -> ca.SX:
    """The numbers that a system's conditions ask to be positive, for another reading of the height.

    Parameters
    ----------
    shape, law, parameters
        As for `closed_form`.
    numbers
        Symbols of the parameters.
    x
        Symbols of the states; without slip those of the slip are left out.
    along
        The height at the inclination `x[0]`; it may hold symbols of its own.
    """
    stated = Law(law, numbers.table, parameters)
    body = _body(x, along, numbers, stated, x.numel() == len(STATES))
    solution, pivots = eliminate(*body.implicit_form(), body.pivots)
    seen = body.observables(dict(zip(body.unknown_names, solution, strict=True)), pivots)
    return ca.SX(ca.vertcat(*[c.value for c in _conditions(x, shape)(seen)]))


def with_quantities(
    system: System, shape: Shape, law: type[Contact], resistance: Resistances, *, physical: bool
) -> System:
    """A body's system with its quantities, and a unit for each.

    Parameters
    ----------
    system
        The system.
    shape
        From `shape_of`.
    law, resistance, physical
        As for `round_system`.
    """
    every = (*system.states, *system.parameters, *system.observables)
    coefficients = {r.coefficient: r.unit if physical else "1" for r in resistance}
    quantities = round_quantities(
        shape[0], law, shape[3], [n for n in every if n not in coefficients]
    )
    of_system = {n: q for n, q in quantities.items() if n in every}
    units = {n: q.kind.unit(dimensionless=not physical) for n, q in of_system.items()}
    fit = of_fit(shape[0], shape[1].error)
    return replace(system, units=units | coefficients, quantities=quantities, approximation=fit)


def _conditions(  # type: ignore[no-untyped-def]
    x: ca.SX, shape: Shape, more: Sequence[Condition] = ()
):
    name, *_, between = shape
    low, high = between
    ends = " and ".join("π" if v == math.pi else f"{v:.6g}" for v in between)
    why = f"where the height of the {name} holds"
    if is_thin(shape):
        why = f"because the {name} is flat at both and its equations of motion end there"
    flat = (
        f"theta must lie strictly between {ends}, {why}; the distance from the {{end}} end is "
        "{{value:.3g}}"
    )

    def build(observables: dict[str, ca.SX]) -> tuple[Condition, ...]:
        return (
            Condition(x[0] - low, flat.format(end="lower")),
            Condition(high - x[0], flat.format(end="upper")),
            *more,
            Condition(
                observables["determinant"],
                f"D = {{value:.3g}} is not positive: no contact force holds the {name} on the "
                "plane there (Painlevé's paradox); take a smaller mu or slip_x",
            ),
        )

    return build
