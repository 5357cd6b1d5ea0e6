"""The stored contact laws, one class each, and their names; dry friction is in `dry_friction`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from ..base.checks import Number, broadcast, instance, known, positive, whole_number
from ..base.errors import NameUnknownError, ParameterError, listed, shown
from ..base.quantities import Units
from .contact import OVER_ANY_NUMBER, ZERO_MU, Contact, Parameter
from .disk import Disk
from .dry_friction import Coulomb, RegularisedCoulomb


def _times_speed(value: Any, scales: Units) -> Any:
    return value * scales.speed


def _drag(value: Any, scales: Units) -> Any:
    return value / scales.mass * scales.time


@dataclass(frozen=True, eq=False)
class Smooth(Contact):
    """No friction at all: L·ẑ, omega3 and energy are conserved.

    Source: rates and forces against Kane's equations: tests/bodies/test_equations.py;
    conserved quantities: tests/motion/test_conserved.py.

    Examples
    --------
    >>> import stability as st
    >>> st.Smooth().conservative
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
        Friction coefficient, positive [s/m]; dimensionless mu* = mu √(gR).

    Raises
    ------
    ParameterError
        If mu is not a finite number above zero.

    Source: Przybylska & Rauch-Wojciechowski 2016, Section 2.

    Examples
    --------
    >>> import stability as st
    >>> st.Viscous(0.3).mu
    0.3
    """

    mu: ArrayLike
    """Friction coefficient [s/m]."""
    name: ClassVar[str] = "viscous"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("mu", "s/m", _times_speed),)
    relaxes: ClassVar[bool] = True

    @OVER_ANY_NUMBER
    def force(self, slip: Any, normal: Any, mu: Any) -> Any:
        """Against the slip, in proportion to it and to the normal force."""
        return [-mu * normal * slip[0], -mu * normal * slip[1]]


@dataclass(frozen=True, eq=False)
class LinearViscous(Contact):
    """Friction −c·vA, independent of the normal force.

    Its linearisation is that of `Viscous(mu)` with c = mu m g at each steady motion.

    Parameters
    ----------
    c
        Friction coefficient, positive [kg/s]; dimensionless c* = (c/m) √(R/g).
    mu
        Friction coefficient in place of c, positive [s/m]; then c = mu m g of the disk.

    Raises
    ------
    ParameterError
        Unless exactly one of c and mu is given, as a finite number above zero.

    Source: linear friction at the contact point; rates, forces and dissipated power against
    Kane's equations: tests/bodies/test_equations.py.

    Examples
    --------
    >>> import stability as st
    >>> st.LinearViscous.like(0.3, st.Disk(mass=2.0)).c
    0.6
    """

    c: ArrayLike | None = None
    """Friction coefficient [kg/s], or None."""
    mu: ArrayLike | None = None
    """Friction coefficient of the viscous law with the same linearisation [s/m], or None."""
    name: ClassVar[str] = "linear-viscous"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("c", "kg/s", _drag, "mu"),
        Parameter("mu", "s/m", _times_speed, "mu"),
    )
    relaxes: ClassVar[bool] = True

    def __post_init__(self) -> None:
        if (self.c is None) == (self.mu is None):
            raise ParameterError(
                f"LinearViscous has c = {shown(self.c)} and mu = {shown(self.mu)}; give exactly "
                "one of them."
            )
        super().__post_init__()

    @classmethod
    def like(cls, mu: ArrayLike, disk: Disk) -> LinearViscous:
        """The linear law with the force of `Viscous(mu)` where the normal force is m g.

        Parameters
        ----------
        mu
            Friction coefficient of the viscous law [s/m].
        disk
            The body, for m g.

        Examples
        --------
        >>> import stability as st
        >>> st.LinearViscous.like(0.3, st.Disk()).c
        0.3
        """
        coefficient: Number = positive("mu", mu, ZERO_MU)
        force = instance("disk", disk, Disk, "give a stability.Disk").force
        broadcast(mu=np.shape(coefficient), disk=np.shape(force))
        with np.errstate(over="ignore", under="ignore"):  # an overflow is refused
            return cls(coefficient * force)

    @OVER_ANY_NUMBER
    def force(self, slip: Any, normal: Any, mu: Any) -> Any:  # noqa: ARG002
        """Against the slip, in proportion to it."""
        return [-mu * slip[0], -mu * slip[1]]


@dataclass(frozen=True, eq=False)
class Rough(Contact):
    """No slip: the force that keeps the contact point at rest.

    Source: rates and forces against Kane's equations: tests/bodies/test_equations.py;
    conserved quantities: tests/motion/test_conserved.py.

    Examples
    --------
    >>> import stability as st
    >>> st.Rough().slips
    False
    """

    name: ClassVar[str] = "rough"
    conservative: ClassVar[bool] = True
    slips: ClassVar[bool] = False
    holds: ClassVar[bool] = True

    @OVER_ANY_NUMBER
    def power(self, slip: Any, normal: Any, mu: Any) -> Any:  # noqa: ARG002
        """Zero, because there is no slip."""
        return 0


@dataclass(frozen=True, eq=False, init=False, repr=False)
class Creep(Contact):
    """Viscous friction with the slip eliminated: the slow manifold of `Viscous` at large mu.

    Slip decays within a time of 1/mu to sₙ(x) + O(mu⁻⁽ⁿ⁺¹⁾), a function of the other four states.
    The disk held to the slip sₙ is a system of four states, without stiffness, with an error of
    O(mu⁻⁽ⁿ⁺¹⁾); s₀ = 0 is the rough disk.  The force that holds sₙ, put into the viscous law,
    gives sₙ₊₁.  Where mu times the normal force is no longer large, before a lift-off, the slip
    does not follow the motion: a run ends there.

    Parameters
    ----------
    mu
        Positive [s/m], as in `Viscous`.
    order
        Number n of the approximation, 1, 2 or 3.  Each order has equations of its own, so each is
        a class: this one for 1, a subclass for 2 and for 3.

    Raises
    ------
    ParameterError
        If mu is not a finite number above zero, or there is no such order.

    Source: N. Fenichel, J. Differ. Equ. 31 (1979) 53-98, for the manifold; the iteration is that of
    Fraser, J. Chem. Phys. 88 (1988) 4732, with the constraint kept exactly.  Orders 0 to 3 are
    measured in tests/bodies/test_creep.py.

    Examples
    --------
    >>> import stability as st
    >>> st.Creep(300.0, order=2)
    Creep(mu=300.0, order=2)
    >>> st.Creep(300.0).name
    'creep-1'
    """

    mu: ArrayLike
    """Friction coefficient [s/m]."""
    name: ClassVar[str] = "creep-1"
    parameters: ClassVar[tuple[Parameter, ...]] = Viscous.parameters
    slips: ClassVar[bool] = False
    holds: ClassVar[bool] = True
    order: ClassVar[int] = 1
    """Number n of the approximation: errors fall as mu⁻⁽ⁿ⁺¹⁾."""
    force = Viscous.force

    def __new__(cls, mu: ArrayLike | None = None, order: int = 1) -> Creep:  # noqa: ARG004
        """A law of the class of its order."""
        chosen = CREEP[whole_number("order", order, 1, len(CREEP) - 1)] if cls is Creep else cls
        return object.__new__(chosen)  # type: ignore[return-value]  # order 0 is not chosen

    def __init__(self, mu: ArrayLike, order: int = 1) -> None:  # noqa: ARG002  # the class has it
        object.__setattr__(self, "mu", mu)
        self.__post_init__()

    def __repr__(self) -> str:
        return f"{Creep.__name__}(mu={self.mu!r}, order={self.order})"

    @OVER_ANY_NUMBER
    def slip(self, force: Any, normal: Any, mu: Any) -> Any:
        """The slip at which the viscous law has this force."""
        return [-force[0] / (mu * normal), -force[1] / (mu * normal)]


@dataclass(frozen=True, eq=False, init=False, repr=False)
class Creep2(Creep):
    """The class of order 2."""

    name: ClassVar[str] = "creep-2"
    order: ClassVar[int] = 2


@dataclass(frozen=True, eq=False, init=False, repr=False)
class Creep3(Creep):
    """The class of order 3."""

    name: ClassVar[str] = "creep-3"
    order: ClassVar[int] = 3


CREEP: tuple[type[Contact], ...] = (Rough, Creep, Creep2, Creep3)
"""The slow manifold of viscous contact by order; order 0 is the rough disk."""
LAWS: dict[str, type[Contact]] = {law.name: law for law in (Smooth, Viscous, LinearViscous, Rough)}
"""The stored contact laws that `spectrum` accepts, by name."""
_FURTHER: tuple[type[Contact], ...] = (Coulomb, RegularisedCoulomb, *CREEP[1:])
MOTION_LAWS: dict[str, type[Contact]] = LAWS | {law.name: law for law in _FURTHER}
"""The stored contact laws that `simulate` accepts, by name."""


def law_class(law: str | type[Contact] | None, *, motion: bool = True) -> type[Contact]:
    """The class of a contact law, of the package or of a user.

    Parameters
    ----------
    law
        A key of `MOTION_LAWS`, or a subclass of `Contact`.
    motion
        Whether the law is for a motion; a spectrum needs a law with a linearisation.

    Raises
    ------
    ParameterError
        If `law` is None.
    NameUnknownError
        If `law` is neither, or has no linearisation where one is needed, or is a user's law that
        sticks or leaves out the slip.

    Examples
    --------
    >>> law_class("viscous")
    <class 'stability.bodies.contact_laws.Viscous'>
    """
    linear = [n for n, one in MOTION_LAWS.items() if one.linearises]
    if law is None:
        raise law_missing(MOTION_LAWS if motion else LAWS)
    if isinstance(law, type) and issubclass(law, Contact) and law.name:
        found = law
    elif isinstance(law, str) and law in MOTION_LAWS:
        found = MOTION_LAWS[law]
    else:
        found = MOTION_LAWS[known("contact", law, MOTION_LAWS if motion else linear)]
    if (found.sticks or not found.slips) and found not in MOTION_LAWS.values():
        raise NameUnknownError(
            f"the {found.name} law sticks or leaves out the slip, whose equations are those of the "
            "stored laws only; give a law with a force at every slip."
        )
    if not motion and not found.linearises:
        raise NameUnknownError(
            f"contact is {found.name}, which has no linearisation of its own; known are "
            f"{', '.join(linear)}; inside the friction cone it is `rough`."
        )
    return found


def law_missing(laws: Mapping[str, type[Contact]], more: str = "") -> ParameterError:
    """The refusal of a call without a contact law, the same for every question.

    Parameters
    ----------
    laws
        The laws that this question takes, by name.
    more
        What else the caller may do, at the end of the sentence.

    Examples
    --------
    >>> print(law_missing({"viscous": Viscous, "rough": Rough}))
    contact is missing; give Viscous(mu) or Rough().
    """
    return ParameterError(f"contact is missing; give {listed(_spelled(laws), 'or')}{more}.")


def spelled(laws: Mapping[str, type[Contact]]) -> str:
    """Laws as a user writes them, for a message: `Smooth(), Viscous(mu)`.

    Parameters
    ----------
    laws
        Laws by name.
    """
    return ", ".join(_spelled(laws))


def _spelled(laws: Mapping[str, type[Contact]]) -> list[str]:
    found = []
    for law in laws.values():
        first = {p.place: p.name for p in reversed(law.parameters)}
        found.append(as_called(law, *reversed(first.values())))
    return found


def as_called(law: type[Contact], *names: str) -> str:
    """A law as a user writes it.

    Parameters
    ----------
    law
        The law.
    names
        Its numbers by name.

    Examples
    --------
    >>> as_called(Viscous, "mu"), as_called(Creep2, "mu")
    ('Viscous(mu)', 'Creep(mu, order=2)')
    """
    if issubclass(law, Creep):
        return f"{Creep.__name__}({', '.join((*names, f'order={law.order}'))})"
    return f"{law.__name__}({', '.join(names)})"


def stored(law: type[Contact]) -> bool:
    """Whether the package has exact polynomials and proofs for a law; false for a user's law.

    Parameters
    ----------
    law
        Class of the law.
    """
    return LAWS.get(law.name) is law
