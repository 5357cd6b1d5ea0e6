"""Numbers that the reader of a page may change, and their units: dimensionless, or SI of a body."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from ..base.checks import checked
from ..base.errors import ParameterError, shown
from ..base.quantities import Kind, Units, readable
from ..base.quantities import Quantity as Known


@dataclass(frozen=True)
class PageQuantity:
    """A number that the reader of the page may change."""

    name: str
    """Name in calls."""
    symbol: str
    """Symbol on the page."""
    label: str
    """The quantity in words."""
    unit: str
    """Unit, or what it is measured in; empty for a plain number."""
    low: float
    """Lower end of its slider and axis."""
    high: float
    """Upper end."""
    value: float
    """Value at first."""
    least: float | None = None
    """Largest number that is too small, or None."""
    most: float | None = None
    """Largest number that is accepted, or None."""
    marks: tuple[tuple[float, str], ...] = ()
    """Values with a name."""
    kind: Kind = Kind.NUMBER
    """Kind, which gives it a unit where the body has SI units."""

    @classmethod
    def of(
        cls,
        quantity: Known,
        low: float,
        high: float,
        value: float,
        *,
        name: str = "",
        unit: str | None = None,
        **limits: Any,
    ) -> PageQuantity:
        """A quantity of a disk or body: name in calls and unit are its own where none is given."""
        symbol = (quantity.symbol or quantity.name).removesuffix("/mR²")
        label = "" if quantity.long_name == symbol else quantity.long_name
        unit = quantity.kind.label(dimensionless=True) if unit is None else unit
        return cls(
            name or quantity.name,
            symbol,
            label,
            unit,
            low,
            high,
            value,
            kind=quantity.kind,
            **limits,
        )

    def told(self) -> dict[str, Any]:
        """The record in the page."""
        return vars(self) | {"kind": self.kind.name}

    def checked(self, value: Any) -> float:
        """A number that the quantity may have, or an error that says which it may."""
        number = checked(self.name, value)
        if not isinstance(number, float):
            raise ParameterError(f"{self.name} is {shown(value)}; give one number.")
        low = self.least is not None and number <= self.least
        if low or (self.most is not None and number >= self.most):
            ends = [
                f"above {self.least:g}" if self.least is not None else "",
                f"below {self.most:.6g}" if self.most is not None else "",
            ]
            raise ParameterError(
                f"{self.name} is {number:g}; give a number {' and '.join(e for e in ends if e)}."
            )
        return number

    def at(self, value: Any) -> PageQuantity:
        """The quantity with another number at first, or an error that says which it may have."""
        return replace(self, value=self.checked(value))


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

    @classmethod
    def of(cls, body: Any, length: str) -> PageUnits:
        """Units of a disk, or of a body, by the name of its length.

        Raises
        ------
        ParameterError
            If one of them is an array.

        Examples
        --------
        >>> import stability as st
        >>> PageUnits.of(st.Disk(mass=1.0, radius=0.1, gravity=10.0), "radius").sizes[Kind.TIME]
        0.1
        """
        names = ("mass", length, "gravity")
        for name in names:
            if not isinstance(checked(name, getattr(body, name)), float):
                raise ParameterError(f"{name} is an array; a page needs one number.")
        return cls(Units(*(getattr(body, name) for name in names)), length)

    @property
    def dimensionless(self) -> bool:
        """Whether all units are 1."""
        return (self.units.mass, self.units.length, self.units.gravity) == (1.0, 1.0, 1.0)

    @property
    def sizes(self) -> Mapping[Kind, float]:
        """SI size of the unit of each kind."""
        return {kind: float(self.units.size(kind)) for kind in Kind}

    @property
    def scale(self) -> str:
        """What a page without SI units measures in, in words."""
        return f"dimensionless, m = {'R' if self.length == 'radius' else 'R (length)'} = g = 1"

    def plain(self, quantity: PageQuantity, value: Any) -> float:
        """A number of a quantity without dimension, from the user's units."""
        return float(checked(quantity.name, value)) / float(self.units.size(quantity.kind))

    @property
    def body(self) -> str:
        """Mass, length and gravity as a reader sees them."""
        units = self.units
        return f"m = {units.mass:.6g} kg, R = {units.length:.6g} m, g = {units.gravity:.6g} m/s²"

    def told(self) -> dict[str, Any]:
        """The record in the page; empty for a body without dimension."""
        if self.dimensionless:
            return {}
        units = self.units
        scales = {"mass": units.mass, self.length: units.length, "gravity": units.gravity}
        sizes = {k.name: [v, readable(k.si)] for k, v in self.sizes.items() if k.words}
        return {"given": scales, "body": self.body, "sizes": sizes}
