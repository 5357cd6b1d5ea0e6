"""The body: a thin disk, annulus or hoop, and its scales."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from ..base.checks import Number, broadcast, checked, known, positive
from ..base.errors import ParameterError, shown
from ..base.quantities import ONE, DefaultScale, Units, refuse_partial_units
from ..base.types import Record


@dataclass(frozen=True, eq=False)
class Disk(Record):
    """A thin rigid body of revolution with a sharp circular rim in its mid-plane.

    With the defaults m = R = g = 1 every number is dimensionless (time in √(R/g), speed in √(gR)).
    With mass, radius and gravity in SI units, all three, every number is SI.  Any field may be an
    array: arrays broadcast.

    Parameters
    ----------
    mass, radius, gravity
        Mass, radius of the rim and acceleration of free fall, positive [kg, m, m/s²].
    k
        Inertia factor in (0, 1/2] [-].

    Raises
    ------
    ParameterError
        If a value is not a finite number in its range, or some of mass, radius and gravity are
        given and not all.

    Source: Przybylska & Rauch-Wojciechowski 2016, Section 2 (I₁ = I₂ = k m R², I₃ = 2 k m R²).

    Examples
    --------
    >>> import stability as st
    >>> st.Disk.hoop(mass=0.3, radius=0.45, gravity=9.81).k
    0.5
    """

    mass: Number = ONE
    """Mass m [kg]."""
    radius: Number = ONE
    """Radius R of the rim [m]."""
    k: Number = 0.25
    """Diametral moment of inertia over m R² [-]: 1/4 uniform disk, 1/2 hoop; axial is 2k."""
    gravity: Number = ONE
    """Acceleration of free fall g [m/s²]."""

    def __new__(cls, *numbers: Any, **named: Any) -> Self:
        """A disk; a single number without a name is likely to be meant as k."""
        if len(numbers) == 1 and not named:
            raise ParameterError(
                f"Disk({shown(numbers[0])}) gives the mass alone; give Disk(k=...) for the inertia "
                "factor, or mass, radius and gravity in SI units by name."
            )
        return super().__new__(cls)

    def __post_init__(self) -> None:
        scales_given = {n: getattr(self, n) for n in ("mass", "radius", "gravity")}
        for name, value in scales_given.items():
            if not isinstance(value, DefaultScale):
                object.__setattr__(self, name, positive(name, value))
        refuse_partial_units("the disk", scales_given)
        k = checked("k", self.k)
        bad = np.asarray(k)[(np.asarray(k) <= 0) | (np.asarray(k) > 0.5)]
        if bad.size:
            raise ParameterError(
                f"k is {bad.flat[0]:g}; a thin body has a diametral inertia factor in (0, 1/2]."
            )
        object.__setattr__(self, "k", k)
        broadcast(**{n: np.shape(getattr(self, n)) for n in ("mass", "radius", "k", "gravity")})
        with np.errstate(all="ignore"):
            scales = [np.asarray(s) for s in (self.time, self.rate, self.speed, self.force)]
        if any((~np.isfinite(s) | (s == 0)).any() for s in scales):
            raise ParameterError(
                f"mass {self.mass}, radius {self.radius} and gravity {self.gravity} have scales "
                "beyond double precision; give values nearer to 1."
            )

    @classmethod
    def uniform(cls, **scales: Any) -> Disk:
        """A disk of uniform density, k = 1/4.

        Parameters
        ----------
        **scales
            `mass`, `radius`, `gravity` as in the constructor.

        Examples
        --------
        >>> import stability as st
        >>> st.Disk.uniform().k
        0.25
        """
        return cls(**_scales(scales, "a uniform disk"), k=0.25)

    @classmethod
    def annulus(cls, inner_radius: ArrayLike, **scales: Any) -> Disk:
        """A uniform ring between `inner_radius` and the rim, k = (1 + (r/R)²)/4.

        Parameters
        ----------
        inner_radius
            Inner radius r in [0, R], in the same unit as `radius` [m].
        **scales
            `mass`, `radius`, `gravity` as in the constructor.

        Raises
        ------
        ParameterError
            If r is outside [0, R].

        Examples
        --------
        >>> import stability as st
        >>> st.Disk.annulus(0.5).k
        0.3125
        """
        scales = _scales(scales, "an annulus")
        inner = np.asarray(checked("inner_radius", inner_radius))
        radius = np.asarray(positive("radius", scales.get("radius", 1.0)))
        broadcast(inner_radius=inner.shape, radius=radius.shape)
        with np.errstate(all="ignore"):  # an overflow is refused below
            ratio = inner / radius
        if (ratio < 0).any() or (ratio > 1).any():
            bad = np.broadcast_to(inner, ratio.shape)[(ratio < 0) | (ratio > 1)].flat[0]
            raise ParameterError(f"inner_radius is {bad:g}; it must lie between 0 and the radius.")
        return cls(k=(1 + ratio**2) / 4, **scales)

    @classmethod
    def hoop(cls, **scales: Any) -> Disk:
        """All mass on the rim, k = 1/2.

        Parameters
        ----------
        **scales
            `mass`, `radius`, `gravity` as in the constructor.

        Examples
        --------
        >>> import stability as st
        >>> st.Disk.hoop().k
        0.5
        """
        return cls(**_scales(scales, "a hoop"), k=0.5)

    @classmethod
    def named(cls, name: str) -> Disk:
        """A real disk, in SI units, from `REAL_DISKS`.

        Parameters
        ----------
        name
            One of the keys of `REAL_DISKS`.

        Raises
        ------
        NameUnknownError
            If there is no such disk.

        Examples
        --------
        >>> import stability as st
        >>> coin = st.Disk.named("quarter")
        >>> coin.mass, coin.radius
        (0.00567, 0.01213)
        """
        return cls(**REAL_DISKS[known("disk", name, REAL_DISKS)][0])

    @property
    def given(self) -> dict[str, Number]:
        """Every number of the disk by name, as that of a body."""
        return {n: getattr(self, n) for n in ("mass", "radius", "gravity", "k")}

    def having(self, numbers: Mapping[str, Any]) -> Disk:
        """The same disk with other values of some of its numbers, by name."""
        for name in numbers:
            known("number of the disk", name, self.given)
        return replace(self, **numbers)

    @property
    def units(self) -> Units:
        """The units in which m = R = g = 1."""
        return Units(self.mass, self.radius, self.gravity, _sqrt)

    @property
    def time(self) -> Number:
        """Unit of time √(R/g) [s]."""
        unit: Number = self.units.time
        return unit

    @property
    def rate(self) -> Number:
        """Unit of angular velocity and growth rate √(g/R) [1/s]."""
        unit: Number = self.units.rate
        return unit

    @property
    def speed(self) -> Number:
        """Unit of speed √(gR) [m/s]."""
        unit: Number = self.units.speed
        return unit

    @property
    def energy(self) -> Number:
        """Unit of energy m g R [J]."""
        unit: Number = self.units.energy
        return unit

    @property
    def force(self) -> Number:
        """Unit of force m g [N]."""
        unit: Number = self.units.force
        return unit

    @cached_property
    def dimensionless(self) -> bool:
        """Whether m = R = g = 1, so that numbers have no unit."""
        return all(np.all(np.asarray(v) == 1) for v in (self.mass, self.radius, self.gravity))


def _scales(scales: dict[str, Any], what: str) -> dict[str, Any]:
    """Mass, radius and gravity as given; k and unknown keywords are refused."""
    if "k" in scales:
        raise ParameterError(f"k is given, but {what} has its own; leave it out.")
    for name in scales:
        known("keyword", name, ("mass", "radius", "gravity"))
    return scales


def _sqrt(value: Number) -> Number:
    return math.sqrt(value) if isinstance(value, float) else np.sqrt(value)


UNIFORM = Disk()
"""The uniform disk with m = R = g = 1, of a call without a body."""

REAL_DISKS: dict[str, tuple[dict[str, float], str]] = {
    "quarter": (
        {"mass": 5.67e-3, "radius": 12.13e-3, "k": 0.25, "gravity": 9.81},
        "US quarter dollar: 5.670 g, diameter 24.26 mm (United States Mint, coin specifications); "
        "taken as a uniform thin disk",
    ),
    "le-saux": (
        {"mass": 0.3048, "radius": 0.05, "k": 0.25, "gravity": 9.81},
        "the disk of Le Saux, Leine & Glocker, J. Nonlinear Sci. 15 (2005) 27-61; "
        "taken as a uniform thin disk",
    ),
    "gymnastics-hoop": (
        {"mass": 0.3, "radius": 0.45, "k": 0.5, "gravity": 9.81},
        "rhythmic gymnastics hoop at the limits of the FIG apparatus norms: "
        "300 g, 90 cm interior diameter; taken as a thin hoop",
    ),
}
"""Real disks by name: constructor arguments in SI units, and their source.

Source: named in each entry.

Examples
--------
>>> import stability as st
>>> sorted(st.REAL_DISKS)
['gymnastics-hoop', 'le-saux', 'quarter']
"""
