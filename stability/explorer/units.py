"""Units of a page: dimensionless, and SI for a body whose mass, length and gravity are given."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from ..base.checks import checked
from ..base.errors import ParameterError
from ..base.quantities import Kind, readable
from ..bodies.disk import Disk
from ..bodies.round_body.body import Body
from .subject import Quantity

CURVES = {"time": Kind.TIME, "growth rate": Kind.GROWTH_RATE, "energy": Kind.ENERGY,
          "normal force": Kind.FORCE}  # fmt: skip
"""Kinds of times, rates and curves of a body."""


@dataclass(frozen=True)
class Units:
    """How large the units of a body are; a page computes without dimension and shows either."""

    scales: Disk
    """The body's mass, gravity and, as a radius, its length."""
    length: str
    """What the length is called in calls: radius or length."""

    @property
    def sizes(self) -> Mapping[Kind, float]:
        """SI size of the unit of each kind; the kinds that are left out have the same numbers."""
        one = self.scales
        found = {
            Kind.ANGULAR_VELOCITY: one.rate, Kind.GROWTH_RATE: one.rate, Kind.TIME: one.time,
            Kind.INVERSE_VELOCITY: 1 / one.speed, Kind.DRAG: one.mass * one.rate,
            Kind.ENERGY: one.energy, Kind.FORCE: one.force,
        }  # fmt: skip
        return {kind: float(size) for kind, size in found.items()}

    def plain(self, quantity: Quantity, value: Any) -> float:
        """A number of a quantity without dimension, from the user's units."""
        return float(checked(quantity.name, value)) / self.sizes.get(quantity.kind, 1.0)

    @property
    def body(self) -> str:
        """Mass, length and gravity as a reader sees them."""
        m, length, g = self.scales.mass, self.scales.radius, self.scales.gravity
        return f"m = {m:.6g} kg, R = {length:.6g} m, g = {g:.6g} m/s²"

    def told(self) -> dict[str, Any]:
        """The record in the page; empty for a body without dimension."""
        one = self.scales
        if one.dimensionless:
            return {}
        given = {"mass": one.mass, self.length: one.radius, "gravity": one.gravity}
        return {
            "given": given, "body": self.body,
            "sizes": {kind.name: [size, readable(kind.si)] for kind, size in self.sizes.items()},
        }  # fmt: skip


def units_of(body: Disk | Body) -> Units:
    """Units of a disk, or of a body.

    Parameters
    ----------
    body
        The disk or body, with one number for each of mass, length and gravity.

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
    return Units(Disk(mass=given["mass"], radius=given[length], gravity=given["gravity"]), length)


def without_scales(body: Body) -> Body:
    """The same shape with m = R = g = 1.

    Parameters
    ----------
    body
        A body.
    """
    return body if body.dimensionless else replace(body, mass=1.0, gravity=1.0, length=1.0)
