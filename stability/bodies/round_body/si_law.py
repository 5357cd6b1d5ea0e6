"""Numbers of a body's equations by name, and a contact law in their units."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import casadi as ca

from ...base.quantities import Units
from ..contact_laws import MOTION_LAWS, Contact, LinearViscous
from .height.expression import ShapeFunction
from .shape import MOMENTS, SCALES, RoundShape

Shape = tuple[
    str, ShapeFunction, tuple[ShapeFunction | None, ...], tuple[str, ...], tuple[float, float]
]
"""Name, height, moments (None for a number), names of the shape's numbers, range of θ."""


def shape_of(body: RoundShape) -> Shape:
    """What equations depend on, and no number of the body.

    Parameters
    ----------
    body
        The body.
    """
    moments = tuple(
        m if isinstance(m, ShapeFunction) else None for m in (getattr(body, n) for n in MOMENTS)
    )
    height: Any = body.height
    return body.name, height, moments, tuple(body.shape), body.between


@dataclass(frozen=True, eq=False)
class BodySymbols:
    """Symbols of the parameters of a body's equations."""

    names: tuple[str, ...]
    """Names of the parameters, in order."""
    table: dict[str, Any]
    """Expression of each scale, moment, number of the shape and coefficient by name."""
    shape_symbols: list[ca.SX]
    """Symbols of the shape's numbers."""

    @classmethod
    def of(cls, shape: Shape, parameters: Sequence[str], *, physical: bool) -> BodySymbols:
        """The numbers of a body under a law.

        Parameters
        ----------
        shape
            From `shape_of`.
        parameters
            Names of the law's coefficients.
        physical
            Whether mass, gravity and length are parameters; otherwise they are 1.
        """
        _, _, moments, words, _ = shape
        free = [n for n, m in zip(MOMENTS, moments, strict=True) if m is None]
        names = (*words, *free, *(SCALES if physical else ()), *parameters)
        symbols = {n: ca.SX.sym(n) for n in names}
        shape_symbols = [symbols[n] for n in words]
        table: dict[str, Any] = dict.fromkeys(SCALES, 1) | symbols
        for name, moment in zip(MOMENTS, moments, strict=True):
            table[name] = symbols[name] if moment is None else ca.SX(moment(*shape_symbols))
        return cls(names, table, shape_symbols)

    @property
    def p(self) -> ca.SX:
        """The parameters as a column."""
        column = [self.table[n] for n in self.names]
        return ca.SX(ca.vertcat(*column)) if column else ca.SX(0, 1)


class Law:
    """A contact law with its coefficients: force and power in the units of the equations.

    A stored law takes SI as it is.  A user's law is given slip over √(g·length) and the normal
    force over m g, as its docstring says.

    Parameters
    ----------
    law
        Class of the law.
    table
        Numbers by name.
    parameters
        Names of the law's coefficients.
    """

    def __init__(
        self, law: type[Contact], table: dict[str, Any], parameters: Sequence[str]
    ) -> None:
        self.form = law.__new__(law)  # only its formulas are used, never its coefficient
        self.name, self.holds = law.name, law.holds
        self.mass, self.weight = table["mass"], table["mass"] * table["gravity"]
        self._scales = Units(self.mass, table["length"], table["gravity"], ca.sqrt)
        dimensionless = all(isinstance(table[n], int) for n in SCALES)  # dimensionless
        self._direct = dimensionless or law in MOTION_LAWS.values()
        if law is LinearViscous and "mu" in parameters:
            coefficients = [table["mu"] * self.weight]
        elif self._direct:
            coefficients = [table[n] for n in parameters]
        else:
            coefficients = [
                *law.arguments({n: table[n] for n in parameters}, self._scales).values()
            ]
        self.coefficient: Any = coefficients[0] if len(coefficients) == 1 else tuple(coefficients)

    def force(self, slip: Sequence[Any], normal: Any) -> Any:
        """Horizontal force for a slip and a normal force."""
        if self._direct:
            return self.form.force(slip, normal, self.coefficient)
        speed = self._scales.speed
        force = self.form.force([v / speed for v in slip], normal / self.weight, self.coefficient)
        return [self.weight * f for f in force] if isinstance(force, (list, tuple)) else force

    def power(self, slip: Sequence[Any], normal: Any) -> Any:
        """Power that the law dissipates."""
        if self._direct:
            return self.form.power(slip, normal, self.coefficient)
        speed = self._scales.speed
        scaled = [v / speed for v in slip]
        return self.weight * speed * self.form.power(scaled, normal / self.weight, self.coefficient)
