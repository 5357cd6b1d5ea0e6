"""A number that the reader of a page may change: name, words, unit and range."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ..base.checks import checked
from ..base.errors import ParameterError, shown
from ..base.quantities import Kind
from ..base.quantities import Quantity as Known


@dataclass(frozen=True)
class Quantity:
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
        known: Known,
        low: float,
        high: float,
        value: float,
        *,
        name: str = "",
        unit: str | None = None,
        **limits: Any,
    ) -> Quantity:
        """A quantity of a disk or body: name in calls and unit are its own where none is given."""
        symbol = (known.symbol or known.name).removesuffix("/mR²")
        label = "" if known.long_name == symbol else known.long_name
        unit = known.kind.label(dimensionless=True) if unit is None else unit
        return cls(
            name or known.name, symbol, label, unit, low, high, value, kind=known.kind, **limits
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
