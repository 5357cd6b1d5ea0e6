"""Quantities of the disk and of bodies: the one place for names, symbols and units.

The unit of length, called R, is the radius of a disk and the length of a `Body`.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import replace

from ..base.citation import DISK
from ..base.quantities import Kind, Quantity
from .contact_laws import MOTION_LAWS, Contact

PHYSICAL = ("mass", "radius", "gravity")
"""The disk's dimensional quantities."""
SYSTEM = DISK
"""Start of the names of the disk's systems; the name of the law follows."""
THIN = DISK.rstrip(", ")
"""Name of the thin disk as a body."""

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
    Quantity("rim_speed", "", "speed of the contact point about the centre", Kind.VELOCITY),
    Quantity(
        "lever", "h'", "distance of the contact point from the foot of the centre", Kind.LENGTH
    ),
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
    if law is None:
        return QUANTITIES
    of_law = {}
    for p in law.parameters:
        quantity = QUANTITIES.get(p.name) or Quantity(p.name, p.name, p.name, p.kind)
        leads = p.place == law.parameters[0].place
        of_law[p.name] = replace(quantity, kind=p.kind, formula=law.formula if leads else "")
    return {**QUANTITIES, **of_law}


def quantities_of(system: str) -> Mapping[str, Quantity]:
    """Quantities of a system by its name; none for a user's, whose `theta` may be anything."""
    if not system.startswith(SYSTEM):
        return {}
    return disk_quantities(MOTION_LAWS.get(system.removeprefix(SYSTEM)))


_OWN = (
    Quantity("length", "R", "length", Kind.LENGTH),
    Quantity("axial", "I₃/mR²", "axial moment of inertia", Kind.NUMBER, "I_3/mR^2"),
    Quantity("transverse", "I₁/mR²", "transverse moment of inertia", Kind.NUMBER, "I_1/mR^2"),
    Quantity("axis_X", "e_X", "symmetry axis along X", Kind.NUMBER),
    Quantity("axis_Y", "e_Y", "symmetry axis along Y", Kind.NUMBER),
    Quantity("axis_Z", "e_Z", "symmetry axis along Z", Kind.NUMBER),
    Quantity("omega_X", "ω_X", "angular velocity along X", Kind.ANGULAR_VELOCITY, r"\omega_X"),
    Quantity("omega_Y", "ω_Y", "angular velocity along Y", Kind.ANGULAR_VELOCITY, r"\omega_Y"),
    Quantity("omega_Z", "ω_Z", "angular velocity along Z", Kind.ANGULAR_VELOCITY, r"\omega_Z"),
    Quantity("slip_X", "v_X", "slip along X", Kind.VELOCITY),
    Quantity("slip_Y", "v_Y", "slip along Y", Kind.VELOCITY),
)
_SHAPES = {
    "torus": Quantity("tube", "b", "relative tube radius", Kind.NUMBER),
    "hollow torus": Quantity("tube", "b", "relative tube radius", Kind.NUMBER),
    "spheroid": Quantity("aspect", "a", "aspect ratio", Kind.NUMBER),
    "eccentric sphere": Quantity("offset", "e", "relative offset of the centre", Kind.NUMBER),
    "disk": QUANTITIES["k"],
    "thick disk": Quantity("thickness", "t", "relative thickness", Kind.NUMBER),
}
"""The number of a named body's shape; over the length."""


def round_quantities(
    body: str, law: type[Contact] | None, shape: Collection[str], names: Collection[str]
) -> Mapping[str, Quantity]:
    """Quantities of a body under a law.

    Parameters
    ----------
    body
        Name of the body.
    law
        Class of the law; None for one that is not known.
    shape
        Numbers of the shape, by name; one that no named body has is called by its name.
    names
        States, parameters and observables of the system.

    Examples
    --------
    >>> from stability.bodies.contact_laws import Rough
    >>> quantities = round_quantities("torus", Rough, ["tube"], ["tube", "omega3"])
    >>> [q.symbol for q in quantities.values()]
    ['b', 'ω₃']
    """
    if body == THIN:
        return disk_quantities(law)
    quantities = {**disk_quantities(law), **{q.name: q for q in _OWN}}
    for name in ("slip_x", "slip_y"):  # of the disk, these words name its sides
        quantities[name] = replace(
            quantities[name], long_name=quantities[name].long_name.split(",")[0]
        )
    for name in shape:
        of_shape = _SHAPES.get(body)
        quantities[name] = (
            of_shape
            if of_shape and of_shape.name == name
            else Quantity(name, "", name, Kind.NUMBER)
        )
    return {n: quantities.get(n, Quantity(n, "", n, Kind.NUMBER)) for n in names}
