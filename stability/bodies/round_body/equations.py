"""Equations of motion of a body of revolution for every height h(θ), as a CasADi graph.

The contact point lies at a = h' x̂ - h ẑ from the centre of mass.  Only h and h' stand in the
equations; their rates bring in h'', so a linearisation at a steady motion (θ̇ = 0) needs h, h' and
h'' alone.  Units are SI: with m = g = length = 1 the numbers are dimensionless.
tests/bodies/test_round_bodies.py compares these equations with an inertial formulation.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Any

import casadi as ca

from ...algebra.program import Program
from ...base.quantities import Units
from ...systems.condition import Condition
from ...systems.equations import eliminate
from ...systems.system import System
from ..contact import Contact
from ..contact_laws import CREEP, Creep, Rough
from ..creep import CREEPS, follows, slip_of
from ..held_motion import SLIP, held_in_angles
from ..newton_euler import STATES, NewtonEuler
from ..resistance import Resistance, total_moment
from ..round_quantities import round_quantities
from .height.pole_height import height_of_angle
from .shape import RoundShape, of_fit
from .si_law import Law, Numbers, Shape, shape_of

Resistances = tuple[type[Resistance], ...]


def round_system(
    body: RoundShape,
    law: type[Contact],
    given: tuple[str, ...],
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
    given
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
    return _system(shape_of(body), law, given, physical, resistance, slips)  # type: ignore[arg-type]  # a class is hashable


@lru_cache(maxsize=64)
def _system(  # noqa: PLR0913
    shape: Shape,
    law: type[Contact],
    given: tuple[str, ...],
    physical: bool,  # noqa: FBT001
    resistance: Resistances,
    slips: bool,  # noqa: FBT001
) -> System:
    name, height, _, _, between = shape
    numbers = Numbers.of(shape, (*given, *(r.coefficient for r in resistance)), physical=physical)
    states = STATES if slips else STATES[:4]
    x = ca.SX.sym("x", len(states))
    along = height_of_angle(height, x[0], numbers.own)

    def below(order: int) -> System:
        names = given if order else ()
        return _system(shape, CREEP[order], names, physical, resistance, False)  # type: ignore[arg-type]  # a class is hashable

    slip, creeps = None, []
    if issubclass(law, Creep):
        mass, length, gravity = (numbers.table[n] for n in ("mass", "length", "gravity"))
        units = Units(mass, length, gravity, ca.sqrt)
        slip = slip_of(law, below(law.order - 1), x, numbers.table)
        creeps = [Condition(follows(below(0), x, numbers.table, units), CREEPS)]
    body = RoundBody(x, along, numbers.table, law, given, slips, slip)
    body.against = [(r, numbers.table[r.coefficient]) for r in resistance]
    system = System.from_mass_matrix(
        f"{name}, {law.name}",
        x,
        numbers.p,
        *body.implicit_form(),
        unknowns=body.unknown_names,
        rates={"theta": x[1]},
        pivots=body.pivots,
        observables=body.observables,
        conditions=_conditions(x, between, creeps),
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
    numbers = Numbers.of(shape, [r.coefficient for r in resistance], physical=False)
    x = ca.SX.sym("x", 4)
    along = height_of_angle(shape[1], x[0], numbers.own)
    body = RoundBody(x, along, numbers.table, Rough, (), False, ca.vertsplit(SLIP))
    body.against = [(r, numbers.table[r.coefficient]) for r in resistance]
    return held_in_angles(body, numbers.p)


def conditions_along(
    shape: Shape, law: type[Contact], given: Sequence[str], numbers: Numbers, x: ca.SX, along: ca.SX
) -> ca.SX:
    """The numbers that a system's conditions ask to be positive, for another reading of the height.

    Parameters
    ----------
    shape, law, given
        As for `closed_form`.
    numbers
        Symbols of the parameters.
    x
        Symbols of the states; without slip those of the slip are left out.
    along
        The height at the inclination `x[0]`; it may hold symbols of its own.
    """
    body = RoundBody(x, along, numbers.table, law, tuple(given), x.numel() == len(STATES))
    solution, pivots = eliminate(*body.implicit_form(), body.pivots)
    seen = body.observables(dict(zip(body.unknown_names, solution, strict=True)), pivots)
    return ca.SX(ca.vertcat(*[c.value for c in _conditions(x, shape[4])(seen)]))


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
    known = round_quantities(shape[0], law, shape[3], [n for n in every if n not in coefficients])
    units = {n: q.kind.unit(dimensionless=not physical) for n, q in known.items()}
    fit = of_fit(shape[0], shape[1].error)
    return replace(system, units=units | coefficients, quantities=known, approximation=fit)


def _conditions(  # type: ignore[no-untyped-def]
    x: ca.SX, between: tuple[float, float], more: Sequence[Condition] = ()
):
    low, high = between
    flat = (
        f"theta must lie strictly between {low:.6g} and {high:.6g}, where the body's height holds; "
        "the distance from the {end} end is {{value:.3g}}"
    )

    def build(observables: dict[str, ca.SX]) -> tuple[Condition, ...]:
        return (
            Condition(x[0] - low, flat.format(end="lower")),
            Condition(high - x[0], flat.format(end="upper")),
            *more,
            Condition(
                observables["determinant"],
                "D = {value:.3g} is not positive: no contact force holds the body on the plane "
                "there (Painlevé's paradox); take a smaller mu or slip_x",
            ),
        )

    return build


class RoundBody(NewtonEuler):
    """A body of revolution: its contact point lies at a = h' x̂ - h ẑ from the centre."""

    def __init__(
        self,
        x: ca.SX,
        height: ca.SX,
        table: dict[str, Any],
        contact: type[Contact],
        given: tuple[str, ...],
        slips: bool,
        slip: list[ca.SX] | None = None,  # noqa: FBT001
    ) -> None:
        length = table["length"]
        self.si = Law(contact, table, given)
        self.mass, self.weight = self.si.mass, self.si.weight
        self.h = length * height
        self.slope = ca.jacobian(self.h, x[0])
        self.square = self.mass * length * length
        self.axial = self.square * table["axial"]
        self.transverse = self.square * table["transverse"]
        self.against: list[tuple[type[Resistance], ca.SX]] = []
        super().__init__(x, contact, self.si.coefficient, slips, slip)

    def moment(self, normal: Any) -> list[Any]:
        """Moment of all resistances along (x̂, ŷ, ẑ)."""
        return total_moment(self.against, self.turn(), normal)

    def law_force(self, slip: Any, normal: Any, mu: Any) -> Any:  # noqa: ARG002
        """The force in the units of the equations."""
        return self.si.force(slip, normal)

    def law_power(self, slip: Any, normal: Any, mu: Any) -> Any:  # noqa: ARG002
        """The dissipated power in the units of the equations."""
        return self.si.power(slip, normal)

    def turn(self) -> list[ca.SX]:
        """Angular velocity along (x̂, ŷ, ẑ)."""
        _, theta_dot, phi_dot, omega3 = (self.x[i] for i in range(4))
        relative = omega3 - phi_dot * self.cosine
        return [relative * self.sine, theta_dot, phi_dot + relative * self.cosine]

    def rim_speed(self) -> ca.SX:
        """(ω×a) along ŷ."""
        along, _, up = self.turn()
        found: ca.SX = up * self.slope + along * self.h
        return found

    def own_slip(self) -> list[ca.SX]:
        """(ω×a) along x̂ and ŷ."""
        return [-self.x[1] * self.h, self.rim_speed()]

    def velocity(self) -> ca.SX:
        """ṡ = vA - ω×a along (x̂, ŷ, ẑ)."""
        theta_dot = self.x[1]
        return ca.vertcat(
            self.slip[0] + theta_dot * self.h,
            self.slip[1] - self.rim_speed(),
            theta_dot * self.slope,
        )

    def momentum(self) -> ca.SX:
        """L along (1̂, 2̂, 3̂)."""
        theta_dot, phi_dot, omega3 = self.x[1], self.x[2], self.x[3]
        across = self.transverse
        return ca.SX(
            ca.vertcat(-across * phi_dot * self.sine, across * theta_dot, self.axial * omega3)
        )

    def spin(self, momentum: ca.SX) -> ca.SX:  # noqa: ARG002
        """ω along (1̂, 2̂, 3̂)."""
        return ca.vertcat(-self.x[2] * self.sine, self.x[1], self.x[3])

    def torque(self, fx: Any, fy: Any) -> ca.SX:
        """Torque a × force along (1̂, 2̂, 3̂); x̂ = cosθ 1̂ + sinθ 3̂, ẑ = -sinθ 1̂ + cosθ 3̂."""
        h, slope = self.h, self.slope
        around, across = self.cosine * h - self.sine * slope, self.sine * h + self.cosine * slope
        along, side, up = self.moment(self.normal)
        resisting = ca.vertcat(
            self.cosine * along - self.sine * up, side, self.sine * along + self.cosine * up
        )
        sliding = ca.vertcat(around * fy, -h * fx - slope * self.normal, across * fy)
        return ca.SX(sliding + resisting) if self.against else ca.SX(sliding)

    def potential(self) -> ca.SX:
        """Weight times the height of the centre."""
        return ca.SX(self.weight * self.h)

    def observables(self, solved: dict[str, ca.SX], pivots: list[ca.SX]) -> dict[str, ca.SX]:
        """Those of every body, with D over m·length², the speed of the rim, and h'."""
        found = super().observables(solved, pivots)
        found["determinant"] = found["determinant"] / self.square
        if self.against:
            moment = self.moment(found["normal_force"])
            found["power"] -= ca.dot(ca.vertcat(*moment), ca.vertcat(*self.turn()))
        return found | {"rim_speed": self.rim_speed(), "lever": self.slope}
