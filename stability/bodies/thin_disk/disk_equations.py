"""The disk's equations of motion, written once from Newton-Euler as a CasADi graph.

Frames and signs are those of Przybylska & Rauch-Wojciechowski 2016, Section 2: 3̂ is the symmetry
axis, 1̂ points from the centre to the contact point A, 2̂ = 3̂×1̂ is horizontal; ẑ is vertical,
ŷ = 2̂, x̂ = ŷ×ẑ.  Everything is dimensionless (m = R = g = 1).  tests/bodies/test_equations.py
compares these equations with two derivations that share nothing with them.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache
from typing import Any

import casadi as ca

from ...base.checks import flag
from ...base.errors import ParameterError
from ...systems.condition import Condition
from ...systems.system import System
from ..contact import Contact
from ..contact_laws import CREEP, Creep, Smooth, law_class
from ..creep import CREEPS, follows, slip_of
from ..dry_friction import DIRECTION, CoulombAlong
from ..newton_euler import STATES as STATES
from ..newton_euler import NewtonEuler
from .disk_quantities import SYSTEM, disk_quantities


def disk_system(
    law: str | Contact | type[Contact] | None = None,
    *,
    slip_states: bool | None = None,
    direction: bool = False,
) -> System:
    """The disk under a contact law as a `System`; dimensionless, built once for each law.

    Parameters
    ----------
    law
        A contact law, its name or its class; its numbers stay parameters of the system.
    slip_states
        Whether the two slip velocities are states; None for the choice of the law.  Only the
        smooth disk allows both (its slip follows the other four states).  Without them its
        observables are those of a disk whose centre has no horizontal velocity.
    direction
        For `coulomb`: whether the angle of the slip is a separate parameter, so that the equations
        keep a meaning where the slip is zero.

    Returns
    -------
    System
        States `STATES` (or the first four); parameters `k` and, for a law with a coefficient,
        `mu` (its value is c* for `linear-viscous`; `coulomb-regularised` has `epsilon` too).
        Observables: `energy`, `normal_force`,
        `contact_force` (horizontal, x̂ and ŷ), `slip`, `determinant` (D), `power` (dissipated).

    Raises
    ------
    ParameterError
        If the law is missing, or has no such form of its equations.

    Source: equations of Przybylska & Rauch-Wojciechowski 2016; tests/bodies/test_equations.py.

    Examples
    --------
    >>> import math
    >>> import stability as st
    >>> system = st.disk_system("viscous")
    >>> upright = [math.pi / 2, 0, 0, 1.2, 0, 0]
    >>> float(system.observe(upright, [0.25, 0.3])["normal_force"])
    1.0
    """
    contact = law_class(type(law) if isinstance(law, Contact) else law)
    if slip_states is not None:
        slip_states = flag("slip_states", slip_states)
        if slip_states != contact.slips and contact is not Smooth:
            raise ParameterError(
                f"slip_states is {slip_states}; the {contact.name} law leaves no choice, leave it "
                "out."
            )
    if flag("direction", direction) and not contact.sticks:
        raise ParameterError(
            f"direction belongs to the coulomb law, not to {contact.name}; leave it out."
        )
    return _disk_system(contact, slip_states, direction=bool(direction))  # type: ignore[arg-type]  # a class is hashable


@lru_cache(maxsize=32)
def _disk_system(contact: type[Contact], slip_states: bool | None, *, direction: bool) -> System:
    slips = contact.slips if slip_states is None else slip_states
    names = STATES if slips else STATES[:4]
    x = ca.SX.sym("x", len(names))
    named = {n: ca.SX.sym(n) for n in ("k", *contact.symbols())}
    k, *numbers = named.values()
    coefficient: Any = numbers[0] if len(numbers) == 1 else tuple(numbers)
    law = contact.name
    if direction:
        named[DIRECTION] = ca.SX.sym(DIRECTION)
        contact, coefficient = CoulombAlong, (*numbers, named[DIRECTION])
    p = ca.vertcat(*named.values())
    slip = None
    if issubclass(contact, Creep):
        slip = slip_of(contact, _below(contact), x, named)
    body = DiskBody(x, k, contact, coefficient, slips, slip)
    system = System.from_mass_matrix(
        SYSTEM + law,
        x,
        p,
        *body.implicit_form(),
        unknowns=body.unknown_names,
        rates={"theta": x[1]},
        pivots=body.pivots,
        observables=body.observables,
        conditions=_conditions(x, named, contact),
        states=names,
        parameters=tuple(named),
    )
    own = (*system.states, *system.parameters, *system.observables)
    quantities = disk_quantities(contact)
    return replace(system, units={n: quantities[n].kind.si for n in own if n in quantities})


def _below(law: type[Creep]) -> System:
    """The disk under the order below."""
    return _disk_system(CREEP[law.order - 1], None, direction=False)  # type: ignore[arg-type]  # a class is hashable


def _conditions(x: ca.SX, named: Mapping[str, ca.SX], contact: type[Contact]):  # type: ignore[no-untyped-def]
    flat = (
        "theta must lie strictly between 0 and π, because the disk is flat at both and its "
        "equations of motion end there; the distance from the nearer, positive inside, is "
        "{value:.3g}"
    )

    def build(observables: dict[str, ca.SX]) -> tuple[Condition, ...]:
        more: tuple[Condition, ...] = ()
        if issubclass(contact, Creep):
            more = (Condition(follows(disk_system("rough"), x, named), CREEPS),)
        return (
            Condition(x[0], flat),
            Condition(math.pi - x[0], flat),
            *more,  # has no value at a flat disk
            Condition(
                observables["determinant"],
                "D = {value:.3g} is not positive: no contact force holds the disk on the plane "
                "there (Painlevé's paradox); take a smaller mu or slip_x",
            ),
        )

    return build


class DiskBody(NewtonEuler):
    """The disk: its contact point is fixed in the plane of the frame, a = 1̂; m = R = g = 1."""

    def __init__(  # noqa: PLR0913
        self,
        x: ca.SX,
        k: ca.SX,
        contact: type[Contact],
        mu: Any,
        slips: bool,
        slip: list[ca.SX] | None = None,
    ) -> None:
        self.k = k
        super().__init__(x, contact, mu, slips, slip)

    def own_slip(self) -> list[ca.SX]:
        """(ω×a)ₓ and (ω×a)ᵧ, where ω×a = ω₃2̂ - θ̇3̂."""
        return [-self.x[1] * self.sine, self.x[3]]

    def velocity(self) -> ca.SX:
        """ṡ = vA - ω×a along (x̂, ŷ, ẑ) (eq. 2.2)."""
        theta_dot, omega3 = self.x[1], self.x[3]
        horizontal_x = self.slip[0] + theta_dot * self.sine
        horizontal_y = self.slip[1] - omega3
        return ca.vertcat(horizontal_x, horizontal_y, theta_dot * self.cosine)

    def momentum(self) -> ca.SX:
        """L along (1̂, 2̂, 3̂)."""
        _, theta_dot, phi_dot, omega3 = (self.x[i] for i in range(4))
        spin = ca.vertcat(-phi_dot * self.sine, theta_dot, 2 * omega3)
        return self.k * spin

    def spin(self, momentum: ca.SX) -> ca.SX:
        """ω along (1̂, 2̂, 3̂), from L."""
        return ca.vertcat(momentum[0], momentum[1], momentum[2] / 2) / self.k

    def torque(self, fx: Any, fy: Any) -> ca.SX:
        """Torque a × force, where x̂ = cosθ 1̂ + sinθ 3̂, ẑ = -sinθ 1̂ + cosθ 3̂, a = 1̂."""
        axial = fx * self.sine + self.normal * self.cosine
        return ca.SX(ca.vertcat(0, -axial, fy))

    def potential(self) -> ca.SX:
        """Height of the centre."""
        return self.sine
