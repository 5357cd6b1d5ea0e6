"""Equations of motion of a body of revolution for every height h(θ), as a CasADi graph.

The contact point lies at a = h' x̂ - h ẑ from the centre of mass.  Only h and h' stand in the
equations; their rates bring in h'', so a linearisation at a steady motion (θ̇ = 0) needs h, h' and
h'' alone.  Units are SI: with m = g = length = 1 the numbers are dimensionless.
tests/bodies/test_round_bodies.py compares these equations with an inertial formulation.
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from typing import Any

import casadi as ca

from ...base.errors import ParameterError
from ...systems.condition import Condition
from ...systems.system import System
from ..contact import Contact, Scales
from ..contact_laws import MOTION_LAWS, Creep, LinearViscous, stored
from ..newton_euler import STATES, NewtonEuler
from .expression import Expression
from .quantities import round_quantities
from .shape import MOMENTS, SCALES, RoundShape


def round_system(
    body: RoundShape, law: type[Contact], given: tuple[str, ...], *, physical: bool
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

    Returns
    -------
    System
        States `STATES` (the first four for a law without slip in the state).  Parameters: numbers
        of the shape, moments that are numbers, scales, and those of the law.  Observables:
        `energy`, `normal_force`, `contact_force` (x̂ and ŷ), `slip`, `determinant` (D over
        m·length²), `power` (dissipated), `rim_speed` (of the point of contact about the centre,
        along ŷ; it vanishes where the centre rests and nothing slips), `lever` (h', the distance of
        the contact point from the foot of the centre along x̂).

    Raises
    ------
    ParameterError
        If the law is made for the disk alone.
    """
    if issubclass(law, Creep):
        raise ParameterError(
            f"the {law.name} law is made for the disk; for {body.name} take Viscous(mu)."
        )
    moments = tuple(getattr(body, n) if isinstance(getattr(body, n), Expression) else None
                    for n in MOMENTS)  # fmt: skip
    shape = body.name, body.height, moments, tuple(body.shape), body.between
    return _system(*shape, law, given, physical)  # type: ignore[arg-type]  # a class is hashable


@lru_cache(maxsize=64)
def _system(  # noqa: PLR0913
    name: str, height: Expression, moments: tuple[Expression | None, ...], shape: tuple[str, ...],
    between: tuple[float, float], law: type[Contact], given: tuple[str, ...], physical: bool,  # noqa: FBT001
) -> System:  # fmt: skip
    free = tuple(n for n, known in zip(MOMENTS, moments, strict=True) if known is None)
    names = (*shape, *free, *(SCALES if physical else ()), *given)
    symbols = {n: ca.SX.sym(n) for n in names}
    table: dict[str, Any] = dict.fromkeys(SCALES, 1) | symbols
    own = [symbols[n] for n in shape]
    for word, known in zip(MOMENTS, moments, strict=True):
        table[word] = symbols[word] if known is None else ca.SX(known(*own))
    states = STATES if law.slips else STATES[:4]
    x = ca.SX.sym("x", len(states))
    body = RoundBody(x, ca.SX(height(x[0], *own)), table, law, given)
    p = ca.vertcat(*symbols.values()) if symbols else ca.SX(0, 1)
    system = System.from_mass_matrix(
        f"{name}, {law.name}", x, p, *body.implicit_form(),
        unknowns=body.unknown_names, rates={"theta": x[1]}, pivots=body.pivots,
        observables=body.observables, conditions=_conditions(x, between),
        states=states, parameters=names,
    )  # fmt: skip
    every = (*system.states, *system.parameters, *system.observables)
    quantities = round_quantities(name, law, shape, every)
    units = {n: q.kind.unit(dimensionless=not physical) for n, q in quantities.items()}
    return replace(system, units=units, quantities=quantities)


def _conditions(x: ca.SX, between: tuple[float, float]):  # type: ignore[no-untyped-def]
    low, high = between
    flat = (
        f"theta must lie strictly between {low:.6g} and {high:.6g}, where the body's height holds; "
        "the distance from the {end} end is {{value:.3g}}"
    )

    def build(observables: dict[str, ca.SX]) -> tuple[Condition, ...]:
        return (
            Condition(x[0] - low, flat.format(end="lower")),
            Condition(high - x[0], flat.format(end="upper")),
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
        self, x: ca.SX, height: ca.SX, table: dict[str, Any], contact: type[Contact],
        given: tuple[str, ...],
    ) -> None:  # fmt: skip
        length = table["length"]
        self.mass, self.weight = table["mass"], table["mass"] * table["gravity"]
        self.h = length * height
        self.slope = ca.jacobian(self.h, x[0])
        square = self.mass * length * length
        self.axial, self.transverse = square * table["axial"], square * table["transverse"]
        self.square = square
        self.scales = Scales(
            {"mass": self.mass, "radius": length, "gravity": table["gravity"]}, ca.sqrt
        )
        self.direct = stored(contact) or contact in MOTION_LAWS.values()
        super().__init__(x, contact, self._coefficient(contact, table, given), contact.slips)

    def _coefficient(
        self, law: type[Contact], table: dict[str, Any], given: tuple[str, ...]
    ) -> Any:
        """The coefficients as the law's force takes them: in SI for a stored law."""
        if law is LinearViscous:
            return table["c"] if "c" in given else table["mu"] * self.weight
        if self.direct:
            found = [table[n] for n in given]
        else:
            found = [*law.arguments({n: table[n] for n in given}, self.scales).values()]
        return found[0] if len(found) == 1 else tuple(found)

    def law_force(self, slip: Any, normal: Any, mu: Any) -> Any:
        """The force in SI; a law of a user is given numbers over the units of the body."""
        if self.direct:
            return self.law.force(slip, normal, mu)
        speed = self.scales.speed
        found = self.law.force([v / speed for v in slip], normal / self.weight, mu)
        return [self.weight * f for f in found] if isinstance(found, (list, tuple)) else found

    def law_power(self, slip: Any, normal: Any, mu: Any) -> Any:
        """The dissipated power in SI."""
        if self.direct:
            return self.law.power(slip, normal, mu)
        speed = self.scales.speed
        scaled = self.law.power([v / speed for v in slip], normal / self.weight, mu)
        return self.weight * speed * scaled

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
            self.slip[0] + theta_dot * self.h, self.slip[1] - self.rim_speed(),
            theta_dot * self.slope,
        )  # fmt: skip

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
        return ca.SX(ca.vertcat(around * fy, -h * fx - slope * self.normal, across * fy))

    def potential(self) -> ca.SX:
        """Weight times the height of the centre."""
        return ca.SX(self.weight * self.h)

    def observables(self, solved: dict[str, ca.SX], pivots: list[ca.SX]) -> dict[str, ca.SX]:
        """Those of every body, with D over m·length², the speed of the rim, and h'."""
        found = super().observables(solved, pivots)
        found["determinant"] = found["determinant"] / self.square
        return found | {"rim_speed": self.rim_speed(), "lever": self.slope}
