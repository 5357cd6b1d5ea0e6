"""The contact laws: what the plane does to the rim, one class each."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from ..base.checks import Number, arithmetic, broadcast, instance, known, positive
from ..base.errors import NameUnknownError, ParameterError, shown
from .disk import Disk

ZERO_MU = "friction must be positive (without friction the law is Smooth(), `--contact smooth`)"

OVER_ANY_NUMBER = arithmetic(
    "give a slip of two numbers that is not zero under dry friction, the normal force and mu, all "
    "of one number type"
)


@dataclass(frozen=True, eq=False)
class Contact:
    """The base of the contact laws; use a subclass.

    A new law states `name`, `coefficient`, `conservative`, and the two methods `force` and
    `power`, in dimensionless form; from these everything else works.

    Examples
    --------
    >>> [law.name for law in Contact.__subclasses__()]
    ['smooth', 'viscous', 'linear-viscous', 'rough', 'coulomb', 'coulomb-regularised']
    """

    name: ClassVar[str] = ""
    """The word on the command line and in files."""
    coefficient: ClassVar[str | None] = None
    """Name of the friction coefficient's field, or None."""
    conservative: ClassVar[bool] = False
    """Whether energy is kept, so that the reduced spectrum is even in λ."""
    slips: ClassVar[bool] = True
    """Whether the slip at the contact belongs to the state that a spectrum needs."""

    @property
    def given(self) -> dict[str, Any]:
        """The coefficient by the name under which it was given; empty for a law without one."""
        values = {n: getattr(self, n, None) for n in ("mu", "c")}
        return {n: v for n, v in values.items() if v is not None}

    @OVER_ANY_NUMBER
    def force(self, slip: Any, normal: Any, mu: Any) -> Any:  # noqa: ARG002
        """Horizontal contact force over m g, for the slip over √(gR) and the normal force over m g.

        Parameters
        ----------
        slip
            Horizontal velocity of the contact point, shape (2,) [√(gR)].
        normal
            Normal force [m g].
        mu
            The law's dimensionless coefficient [-].
        """
        raise NameUnknownError(f"the contact law {type(self).__name__} states no force.")

    @OVER_ANY_NUMBER
    def power(self, slip: Any, normal: Any, mu: Any) -> Any:
        """Power that the law dissipates [m g √(gR)]; arguments as in `force`."""
        force = self.force(slip, normal, mu)
        return -(force[0] * slip[0] + force[1] * slip[1])


@dataclass(frozen=True, eq=False)
class Smooth(Contact):
    """No friction at all: L·ẑ, omega3 and energy are kept.

    Examples
    --------
    >>> Smooth().conservative
    True
    """

    name: ClassVar[str] = "smooth"
    conservative: ClassVar[bool] = True
    slips: ClassVar[bool] = False

    @OVER_ANY_NUMBER
    def force(self, slip: Any, normal: Any, mu: Any) -> Any:  # noqa: ARG002
        """Zero."""
        return [0, 0]


@dataclass(frozen=True, eq=False)
class Viscous(Contact):
    """Friction −mu·gn·vA, the law of Przybylska & Rauch-Wojciechowski 2016.

    Parameters
    ----------
    mu
        Positive [s/m]; dimensionless mu* = mu √(gR).

    Raises
    ------
    ParameterError
        If mu is not a finite number above zero.

    Source: Przybylska & Rauch-Wojciechowski 2016, Section 2.

    Examples
    --------
    >>> Viscous(0.3).mu
    0.3
    """

    mu: ArrayLike
    """Friction coefficient [s/m]."""
    name: ClassVar[str] = "viscous"
    coefficient: ClassVar[str | None] = "mu"

    def __post_init__(self) -> None:
        object.__setattr__(self, "mu", positive("mu", self.mu, ZERO_MU))

    @OVER_ANY_NUMBER
    def force(self, slip: Any, normal: Any, mu: Any) -> Any:
        """Against the slip, in proportion to it and to the normal force."""
        return [-mu * normal * slip[0], -mu * normal * slip[1]]


@dataclass(frozen=True, eq=False)
class LinearViscous(Contact):
    """Friction −c·vA, whatever the normal force.

    Its linearisation is that of `Viscous(mu)` with c = mu m g at each steady motion.

    Parameters
    ----------
    c
        Positive [kg/s]; dimensionless c* = (c/m) √(R/g).
    mu
        In place of c: positive [s/m], meaning c = mu m g of whatever disk is asked about.

    Raises
    ------
    ParameterError
        If not exactly one of them is given, or it is not a finite number above zero.

    Examples
    --------
    >>> LinearViscous.like(0.3, Disk(mass=2.0)).c
    0.6
    """

    c: ArrayLike | None = None
    """Friction coefficient [kg/s], or None."""
    mu: ArrayLike | None = None
    """Friction coefficient of the viscous law it is like [s/m], or None."""
    name: ClassVar[str] = "linear-viscous"
    coefficient: ClassVar[str | None] = "c"

    def __post_init__(self) -> None:
        if (self.c is None) == (self.mu is None):
            raise ParameterError(
                f"LinearViscous has c = {shown(self.c)} and mu = {shown(self.mu)}; give exactly "
                "one of them."
            )
        name = "c" if self.mu is None else "mu"
        object.__setattr__(self, name, positive(name, getattr(self, name), ZERO_MU))

    @classmethod
    def like(cls, mu: ArrayLike, disk: Disk) -> LinearViscous:
        """The linear law with the force of `Viscous(mu)` where the normal force is m g.

        Parameters
        ----------
        mu
            Friction coefficient of the viscous law [s/m].
        disk
            Gives m g.

        Examples
        --------
        >>> LinearViscous.like(0.3, Disk()).c
        0.3
        """
        coefficient: Number = positive("mu", mu, ZERO_MU)
        force = instance("disk", disk, Disk, "give a stability.Disk").force
        broadcast(mu=np.shape(coefficient), disk=np.shape(force))
        with np.errstate(over="ignore", under="ignore"):  # what overflows is refused
            return cls(coefficient * force)

    @OVER_ANY_NUMBER
    def force(self, slip: Any, normal: Any, mu: Any) -> Any:  # noqa: ARG002
        """Against the slip, in proportion to it."""
        return [-mu * slip[0], -mu * slip[1]]


@dataclass(frozen=True, eq=False)
class Rough(Contact):
    """No slip: whatever force keeps the contact point at rest.

    Examples
    --------
    >>> Rough().slips
    False
    """

    name: ClassVar[str] = "rough"
    conservative: ClassVar[bool] = True
    slips: ClassVar[bool] = False

    @OVER_ANY_NUMBER
    def power(self, slip: Any, normal: Any, mu: Any) -> Any:  # noqa: ARG002
        """Zero: no slip, no loss."""
        return 0


@dataclass(frozen=True, eq=False)
class Coulomb(Contact):
    """Dry friction, set-valued at rest: −mu·gn along the slip, or sticking with |F| ≤ mu·gn.

    Sticking is the rough disk inside the friction cone.  The law has no linearisation of its own,
    so it is for motion (`simulate`) and not for spectra.

    Parameters
    ----------
    mu
        Positive [-], static and kinetic alike.

    Raises
    ------
    ParameterError
        If mu is not a finite number above zero.

    Source: Le Saux, Leine & Glocker, J. Nonlinear Sci. 15 (2005) 27-61, for the disk.

    Examples
    --------
    >>> Coulomb(0.3).force([3.0, 4.0], 1.0, 0.3)
    [-0.18, -0.24]
    """

    mu: ArrayLike
    """Friction coefficient [-]."""
    name: ClassVar[str] = "coulomb"
    coefficient: ClassVar[str | None] = "mu"

    def __post_init__(self) -> None:
        object.__setattr__(self, "mu", positive("mu", self.mu, ZERO_MU))

    @OVER_ANY_NUMBER
    def force(self, slip: Any, normal: Any, mu: Any) -> Any:
        """Against the slip, mu times the normal force; not defined at rest."""
        size = (slip[0] * slip[0] + slip[1] * slip[1]) ** 0.5
        return [-mu * normal * slip[0] / size, -mu * normal * slip[1] / size]


@dataclass(frozen=True, eq=False)
class RegularisedCoulomb(Contact):
    """Dry friction made smooth: −mu·gn·vA/√(|vA|² + ε²); it creeps where `Coulomb` sticks.

    Parameters
    ----------
    mu
        Positive [-].
    epsilon
        Slip speed below which the force gives way, positive [m/s].

    Raises
    ------
    ParameterError
        If one of them is not a finite number above zero.

    Examples
    --------
    >>> RegularisedCoulomb(0.3, 1e-3).epsilon
    0.001
    """

    mu: ArrayLike
    """Friction coefficient [-]."""
    epsilon: ArrayLike
    """Slip speed below which the force gives way [m/s]."""
    name: ClassVar[str] = "coulomb-regularised"
    coefficient: ClassVar[str | None] = "mu"

    def __post_init__(self) -> None:
        object.__setattr__(self, "mu", positive("mu", self.mu, ZERO_MU))
        object.__setattr__(self, "epsilon", positive("epsilon", self.epsilon))

    @OVER_ANY_NUMBER
    def force(self, slip: Any, normal: Any, mu: Any) -> Any:
        """Against the slip; mu stands for the pair (mu, epsilon)."""
        coefficient, epsilon = mu
        size = (slip[0] * slip[0] + slip[1] * slip[1] + epsilon * epsilon) ** 0.5
        return [-coefficient * normal * slip[0] / size, -coefficient * normal * slip[1] / size]


LAWS: dict[str, type[Contact]] = {law.name: law for law in (Smooth, Viscous, LinearViscous, Rough)}
"""The contact laws of which spectra are asked, by name."""
MOTION_LAWS: dict[str, type[Contact]] = LAWS | {
    law.name: law for law in (Coulomb, RegularisedCoulomb)
}
"""The contact laws that `simulate` takes, by name."""


def law_named(
    name: str, mu: float | None, *, needed: bool = True, motion: bool = False,
    epsilon: float | None = None,
) -> Contact:  # fmt: skip
    """The contact law of that name, with its coefficient where it has one.

    Parameters
    ----------
    name
        A key of `LAWS`.
    mu
        Friction coefficient [s/m], or None for a law without one; for `linear-viscous` the
        coefficient is c = mu m g, which has the same linearisation.
    needed
        Whether a law with a coefficient must be given one; else 1 stands in.
    motion
        Whether it is for a motion, which dry friction can have.
    epsilon
        Slip speed of `coulomb-regularised` [m/s].

    Returns
    -------
    Contact

    Raises
    ------
    NameUnknownError
        If the law is unknown.
    ParameterError
        If mu is missing, or given to a law that has none, or not positive.

    Examples
    --------
    >>> law_named("viscous", 0.3).mu
    0.3
    """
    if not motion and isinstance(name, str) and name in MOTION_LAWS and name not in LAWS:
        raise NameUnknownError(
            f"contact is {shown(name)}, dry friction, which has no linearisation of its own; "
            "inside the friction cone it is `rough`."
        )
    law = (MOTION_LAWS if motion else LAWS)[known("contact", name, MOTION_LAWS if motion else LAWS)]
    if epsilon is not None and name != RegularisedCoulomb.name:
        raise ParameterError(
            f"epsilon is given but the {name} law has none; it goes with coulomb-regularised."
        )
    if law.coefficient is None:
        if mu is not None:
            raise ParameterError(
                f"mu is given but the {name} law has no coefficient; leave it out."
            )
        return law()
    if mu is None and not needed:
        mu = 1.0
    if mu is None:
        raise ParameterError(f"mu is missing; the {name} law needs a positive coefficient (--mu).")
    if law is RegularisedCoulomb:
        if epsilon is None:
            raise ParameterError(
                "epsilon is missing; coulomb-regularised needs the slip speed below which its "
                "force gives way (--epsilon)."
            )
        return RegularisedCoulomb(mu, epsilon)
    if law is LinearViscous:
        return LinearViscous(mu=mu)
    return Coulomb(mu) if law is Coulomb else Viscous(mu)
