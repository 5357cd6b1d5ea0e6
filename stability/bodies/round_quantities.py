"""Quantities of a body of revolution: those of the disk, with its length and numbers of its shape.

The unit of length, called R, is `Body.length`.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import replace

from ..base.quantities import Kind, Quantity
from .contact import Contact
from .thin_disk.disk_quantities import QUANTITIES, disk_quantities

_OWN = (
    Quantity("length", "R", "length", Kind.LENGTH),
    Quantity("axial", "I₃/mR²", "axial moment of inertia", Kind.NUMBER, "I_3/mR^2"),
    Quantity("transverse", "I₁/mR²", "transverse moment of inertia", Kind.NUMBER, "I_1/mR^2"),
    Quantity(
        "lever", "h'", "distance of the contact point from the foot of the centre", Kind.LENGTH
    ),
    Quantity("axis_X", "e_X", "symmetry axis along X", Kind.NUMBER),
    Quantity("axis_Y", "e_Y", "symmetry axis along Y", Kind.NUMBER),
    Quantity("axis_Z", "e_Z", "symmetry axis along Z", Kind.NUMBER),
    Quantity("omega_X", "ω_X", "angular velocity along X", Kind.ANGULAR_VELOCITY, r"\omega_X"),
    Quantity("omega_Y", "ω_Y", "angular velocity along Y", Kind.ANGULAR_VELOCITY, r"\omega_Y"),
    Quantity("omega_Z", "ω_Z", "angular velocity along Z", Kind.ANGULAR_VELOCITY, r"\omega_Z"),
    Quantity("slip_X", "v_X", "slip along X", Kind.VELOCITY),
    Quantity("slip_Y", "v_Y", "slip along Y", Kind.VELOCITY),
    Quantity("rim_speed", "", "speed of the contact point about the centre", Kind.VELOCITY),
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
    body: str, law: type[Contact], shape: Collection[str], names: Collection[str]
) -> Mapping[str, Quantity]:
    """Quantities of a body under a law.

    Parameters
    ----------
    body
        Name of the body.
    law
        Class of the law.
    shape
        Numbers of the shape, by name; one that no named body has is called by its name.
    names
        States, parameters and observables of the system.

    Examples
    --------
    >>> from stability.bodies.contact_laws import Rough
    >>> found = round_quantities("torus", Rough, ["tube"], ["tube", "omega3"])
    >>> [q.symbol for q in found.values()]
    ['b', 'ω₃']
    """
    known = {**disk_quantities(law), **{q.name: q for q in _OWN}}
    for name in ("slip_x", "slip_y"):  # of the disk, these words name its sides
        known[name] = replace(known[name], long_name=known[name].long_name.split(",")[0])
    for name in shape:
        own = _SHAPES.get(body)
        known[name] = own if own and own.name == name else Quantity(name, "", name, Kind.NUMBER)
    return {n: known.get(n, Quantity(n, "", n, Kind.NUMBER)) for n in names}
