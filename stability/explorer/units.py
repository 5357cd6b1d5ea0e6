"""Units of a page: dimensionless, and SI for a body whose mass, length and gravity are given."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from ..base.checks import checked
from ..base.errors import ParameterError
from ..base.quantities import Kind, Units, readable
from ..bodies.disk import Disk
from ..bodies.round_body.body import Body
from .quantity import Quantity

CURVES = {
    "time": Kind.TIME,
    "growth rate": Kind.GROWTH_RATE,
    "energy": Kind.ENERGY,
    "normal force": Kind.FORCE,
}
"""Kinds of times, rates and curves of a body."""


@dataclass(frozen=True)
class PageUnits:
    """How large the units of a body are; a page computes without dimension and shows either."""

    units: Units
    """The body's units, each one number."""
    length: str
    """What the length is called in calls: radius or length."""

    @property
    def dimensionless(self) -> bool:
        """Whether all units are 1."""
        return (self.units.mass, self.units.length, self.units.gravity) == (1.0, 1.0, 1.0)

    @property
    def sizes(self) -> Mapping[Kind, float]:
        """SI size of the unit of each kind."""
        return {kind: float(self.units.size(kind)) for kind in Kind}

    def plain(self, quantity: Quantity, value: Any) -> float:
        """A number of a quantity without dimension, from the user's units."""
        return float(checked(quantity.name, value)) / float(self.units.size(quantity.kind))

    @property
    def body(self) -> str:
        """Mass, length and gravity as a reader sees them."""
        one = self.units
        return f"m = {one.mass:.6g} kg, R = {one.length:.6g} m, g = {one.gravity:.6g} m/s²"

    def told(self) -> dict[str, Any]:
        """The record in the page; empty for a body without dimension."""
        if self.dimensionless:
            return {}
        one = self.units
        given = {"mass": one.mass, self.length: one.length, "gravity": one.gravity}
        sizes = {k.name: [v, readable(k.si)] for k, v in self.sizes.items() if k.words}
        return {"given": given, "body": self.body, "sizes": sizes}


def units_of(body: Disk | Body) -> PageUnits:
    """Units of a disk, or of a body.

    Raises
    ------
    ParameterError
        If one of them is an array.

    Examples
    --------
    >>> units_of(Disk(radius=0.1, gravity=10.0)).sizes[Kind.TIME]
    0.1
    """
    length = "radius" if isinstance(body, Disk) else "length"
    given = {n: getattr(body, n) for n in ("mass", length, "gravity")}
    for name, value in given.items():
        if not isinstance(checked(name, value), float):
            raise ParameterError(f"{name} is an array; a page needs one number.")
    return PageUnits(Units(given["mass"], given[length], given["gravity"]), length)


def without_scales(body: Body) -> Body:
    """The same shape with m = R = g = 1."""
    return body if body.dimensionless else replace(body, mass=1.0, gravity=1.0, length=1.0)
