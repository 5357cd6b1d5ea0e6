"""Creep: the slip that the viscous law has under the force which holds the order below."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import casadi as ca

from ..base.quantities import Units
from ..systems.system import System
from .contact_laws import Creep

DIMENSIONLESS = Units()
LEAST_RELAXATION = 5.0
"""Rate at which slip decays, over that of the motion, above which the slip follows the motion."""
CREEPS = (
    "creep needs slip that decays faster than the body moves: mu times the normal force, over the "
    f"rate of the motion, less {LEAST_RELAXATION:g}, must be positive and is {{value:.3g}}; take "
    "Viscous(mu) there"
)
"""Reason to refuse a state under creep."""


def slip_of(law: type[Creep], lower: System, x: ca.SX, named: Mapping[str, ca.SX]) -> list[ca.SX]:
    """The slip of an order along x̂ and ŷ.

    Parameters
    ----------
    law
        The order.
    lower
        The body under the order below; order 0 is rolling without slip.
    x, named
        Symbols of the four states, and of the parameters by name.
    """
    seen = [lower.observables[n] for n in ("contact_force", "normal_force")]
    force, normal = _at(seen, lower, x, named)
    slip: list[ca.SX] = law.__new__(law).slip([force[0], force[1]], normal, named["mu"])
    return slip


def follows(
    rough: System, x: ca.SX, named: Mapping[str, ca.SX], units: Units = DIMENSIONLESS
) -> ca.SX:
    """Rate at which slip decays over that at which the motion changes it, less what is needed.

    mu times the slip follows the ratio of the two forces, whose rate is an acceleration that the
    orders add one by one: it must be small next to the normal force, and is not where that fades.

    Parameters
    ----------
    rough
        The body without slip.
    x, named
        As for `slip_of`.
    units
        Units of the equations.
    """
    normal = rough.observables["normal_force"]
    drag = ca.jtimes(rough.observables["contact_force"] / normal, rough.x, rough.rhs)
    pace = ca.sqrt(1 + units.time**2 * (ca.sumsqr(rough.x[1:4]) + ca.sumsqr(drag)))
    [ratio] = _at([normal / units.force / pace], rough, x, named)
    return ca.SX(named["mu"] * units.speed * ratio - LEAST_RELAXATION)


def _at(
    expressions: Sequence[ca.SX], lower: System, x: ca.SX, named: Mapping[str, ca.SX]
) -> list[ca.SX]:
    """Expressions of a lower order in the symbols of this one."""
    parameters = [named[n] for n in lower.parameters]
    p = ca.vertcat(*parameters) if parameters else ca.SX(0, 1)
    values: list[ca.SX] = ca.substitute(list(expressions), [lower.x, lower.p], [x, p])
    return values
