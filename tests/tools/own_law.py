"""A contact law as a user would write it, from the docstring of `Contact` alone."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from stability.base.quantities import Units
from stability.bodies.contact_laws import Contact, Parameter


def by_speed(nu: Any, scales: Units) -> Any:
    """Nu √(gR)."""
    return nu * scales.speed


@dataclass(frozen=True, eq=False)
class Weakening(Contact):
    """Viscous friction that gives way to fast slip: −nu gn vA / (1 + |vA|²/(gR))."""

    nu: Any
    name: ClassVar[str] = "weakening"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("nu", "s/m", by_speed),)

    def force(self, slip: Any, normal: Any, nu: Any) -> Any:
        share = nu * normal / (1 + slip[0] * slip[0] + slip[1] * slip[1])
        return [-share * slip[0], -share * slip[1]]


@dataclass(frozen=True, eq=False)
class Cubic(Contact):
    """Viscous friction that grows with the slip: -mu gn (1 + beta |v|²) v."""

    mu: Any
    beta: Any
    name: ClassVar[str] = "cubic"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("mu", "s/m", by_speed),
        Parameter("beta", "s2/m2", lambda v, s: v * s.speed * s.speed, zero=True),
    )

    def force(self, slip: Any, normal: Any, p: Any) -> Any:
        share = p[0] * normal * (1 + p[1] * (slip[0] ** 2 + slip[1] ** 2))
        return [-share * slip[0], -share * slip[1]]
