"""The disk's quantities: the one place for their names, symbols and units."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from ...base.citation.used import DISK
from ...base.quantities import Kind, Quantity
from ..contact import Contact
from ..contact_laws import MOTION_LAWS

PHYSICAL = ("mass", "radius", "gravity")
"""The disk's dimensional quantities."""
SYSTEM = DISK
"""Start of the names of the disk's systems; the name of the law follows."""

_TABLE = (
    Quantity("mass", "m", "mass", Kind.MASS),
    Quantity("radius", "R", "radius", Kind.LENGTH),
    Quantity("gravity", "g", "gravity", Kind.ACCELERATION),
    Quantity("k", "k", "inertia factor", Kind.NUMBER),
    Quantity("mu", "μ", "friction coefficient", Kind.INVERSE_VELOCITY, r"\mu"),
    Quantity("c", "c", "linear friction coefficient", Kind.DRAG),
    Quantity(
        "epsilon", "ε", "slip speed below which friction gives way", Kind.VELOCITY, r"\varepsilon"
    ),
    Quantity("direction", "", "direction of slip from x̂", Kind.ANGLE),
    Quantity("time", "t", "time", Kind.TIME),
    Quantity("lean", "π/2-θ", "lean from upright", Kind.ANGLE, r"\pi/2-\theta"),
    Quantity("theta", "θ", "axis inclination", Kind.ANGLE, r"\theta"),
    Quantity("theta_dot", "θ̇", "nutation rate", Kind.ANGULAR_VELOCITY, r"\dot\theta"),
    Quantity("phi_dot", "φ̇", "precession rate", Kind.ANGULAR_VELOCITY, r"\dot\varphi"),
    Quantity("omega3", "ω₃", "axial angular velocity", Kind.ANGULAR_VELOCITY, r"\omega_3"),
    Quantity("slip_x", "vx", "slip along x̂, across the disk", Kind.VELOCITY, "v_x"),
    Quantity("slip_y", "vy", "slip along ŷ, along the disk's tangent", Kind.VELOCITY, "v_y"),
    Quantity("slip", "", "slip along x̂ and ŷ", Kind.VELOCITY),
    Quantity("determinant", "D", "Painlevé's determinant", Kind.NUMBER),
    Quantity("energy", "", "energy", Kind.ENERGY),
    Quantity("kinetic", "", "kinetic energy", Kind.ENERGY),
    Quantity("potential", "", "potential energy", Kind.ENERGY),
    Quantity("dissipated", "", "energy lost to friction since the start", Kind.ENERGY),
    Quantity("audit", "", "energy plus what was lost, less the energy at the start", Kind.ENERGY),
    Quantity("normal_force", "", "normal force", Kind.FORCE),
    Quantity("contact_force", "", "contact force along x̂ and ŷ", Kind.FORCE),
    Quantity("force_x", "", "contact force along x̂", Kind.FORCE),
    Quantity("force_y", "", "contact force along ŷ", Kind.FORCE),
    Quantity("power", "", "power lost to friction", Kind.POWER),
    Quantity("phi", "φ", "precession angle", Kind.ANGLE, r"\varphi"),
    Quantity("psi", "ψ", "relative spin angle", Kind.ANGLE, r"\psi"),
    Quantity("centre_x", "", "centre, X", Kind.LENGTH),
    Quantity("centre_y", "", "centre, Y", Kind.LENGTH),
    Quantity("contact_x", "", "contact point, X", Kind.LENGTH),
    Quantity("contact_y", "", "contact point, Y", Kind.LENGTH),
)
QUANTITIES: Mapping[str, Quantity] = {q.name: q for q in _TABLE}
"""Every quantity by name, in the order of a motion's dataset; mu is that of the viscous law."""


def disk_quantities(law: type[Contact] | None = None) -> Mapping[str, Quantity]:
    """The quantities under a contact law, with those of its parameters."""
    own = {}
    for p in law.parameters if law else ():
        kind = next((k for k in Kind if k.si == p.unit), Kind.NUMBER)
        one = QUANTITIES.get(p.name) or Quantity(p.name, p.name, p.name, kind)
        own[p.name] = replace(one, kind=kind)
    return {**QUANTITIES, **own}


def quantities_of(system: str) -> Mapping[str, Quantity]:
    """Quantities of a system by its name; none for a user's, whose `theta` may be anything."""
    if not system.startswith(SYSTEM):
        return {}
    return disk_quantities(MOTION_LAWS.get(system.removeprefix(SYSTEM)))


def is_angle(name: str) -> bool:
    """Whether a quantity is an angle, which no choice of units changes."""
    return QUANTITIES[name].kind is Kind.ANGLE
