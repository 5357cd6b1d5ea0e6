"""Contact laws: what a law says of itself, the laws of the package, and how a call names one."""

from __future__ import annotations

import os
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from importlib import import_module
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from ..base.checks import Number, broadcast, instance, known, positive, whole_number
from ..base.errors import NameUnknownError, ParameterError, listed, meant, shown
from ..base.quantities import Kind, Units
from ..base.types import Record
from ..base.user_code import arithmetic, imported
from .disk import Disk

ZERO_MU = "friction must be positive (without friction the law is Smooth(), `--contact smooth`)"

OVER_ANY_NUMBER = arithmetic(
    "give a slip of two numbers that is not zero under dry friction, the normal force and mu, all "
    "of one number type"
)


def plain(value: Any, scales: Units) -> Any:  # noqa: ARG001
    """The number itself, which has no unit."""
    return value


TAKEN = ", taken because mu is given without a law; dry friction is Coulomb"
"""Note on a law that nobody has named, behind its formula."""


@dataclass(frozen=True)
class Parameter:
    """One number of a contact law: a field of its class, an axis of maps, an option.

    Source: this package; a parameter of a user's law: tests/bodies/test_contact_law.py.

    Examples
    --------
    >>> import stability as st
    >>> st.Viscous.parameters[0].name, st.Viscous.parameters[0].unit
    ('mu', 's/m')
    """

    name: str
    """Name of the field."""
    unit: str
    """SI unit, one of those of `stability.base.quantities.Kind`; `1` for a number without one."""
    dimensionless: Callable[[Any, Units], Any] = plain
    """(value in SI, units of the body) → the number in the equations, by + - * / alone."""
    symbol: str = ""
    """Name in the equations, `name` if empty; fields with the same symbol are alternatives."""
    zero: bool = False
    """Whether zero is accepted."""

    @property
    def place(self) -> str:
        """Name in the equations."""
        return self.symbol or self.name

    @property
    def kind(self) -> Kind:
        """Kind of the number, by its unit.

        Raises
        ------
        ParameterError
            If no kind has this unit: its label in files and figures would be wrong.
        """
        units = {kind.si: kind for kind in Kind}
        if self.unit not in units:
            raise ParameterError(
                f"the unit of the parameter {self.name} is {shown(self.unit)}; known are "
                f"{', '.join(units)}."
            )
        return units[self.unit]


@dataclass(frozen=True, eq=False)
class Contact(Record):
    """The base of the contact laws; a law is one frozen subclass, here or in a user's module.

    A law states its `name`, its `parameters` and its `force`.  These give everything else:
    spectra, boundaries, maps, motions, and the command line (`--contact module:Class`).  Each
    parameter is a field of the class.  Its value must be a finite number above zero (or zero, where
    `Parameter.zero` says so).  The force must vanish with the slip and depend linearly on the
    normal force.

    Raises
    ------
    ParameterError
        If a parameter is not a finite number above zero, or zero where that is not accepted.

    Source: docs/explanation/architecture.md; a user's law: tests/bodies/test_contact_law.py.

    Examples
    --------
    >>> from dataclasses import dataclass
    >>> import stability as st
    >>> @dataclass(frozen=True, eq=False)
    ... class Weakening(st.Contact):
    ...     nu: float
    ...     name = "weakening"
    ...     parameters = (st.Parameter("nu", "s/m", lambda nu, scales: nu * scales.speed),)
    ...
    ...     def force(self, slip, normal, nu):
    ...         share = nu * normal / (1 + slip[0] ** 2 + slip[1] ** 2)
    ...         return [-share * slip[0], -share * slip[1]]
    >>> st.spectrum("rolling", contact=Weakening(0.3), at=2.0).verdict.word
    'stable'
    """

    name: ClassVar[str] = ""
    """Name of the law in files and messages."""
    parameters: ClassVar[tuple[Parameter, ...]] = ()
    """Parameters of the force, in the order of its last argument."""
    formula: ClassVar[str] = ""
    """The force in a few letters, F for it, N for the normal force and v for the slip."""
    conservative: ClassVar[bool] = False
    """Whether energy is conserved, so that the reduced spectrum is even in λ."""
    slips: ClassVar[bool] = True
    """Whether the slip at the contact belongs to the state that a spectrum needs."""
    linearises: ClassVar[bool] = True
    """Whether the law has a linearisation at rest."""
    sticks: ClassVar[bool] = False
    """Whether the contact can stick, with any force inside the friction cone."""
    relaxes: ClassVar[bool] = False
    """Whether slip decays at a rate in proportion to the first parameter, stiff if large."""
    holds: ClassVar[bool] = False
    """Whether the slip follows from the other states, and the force is the one that keeps it so."""

    def __post_init__(self) -> None:
        for p in self.parameters:
            if not hasattr(self, p.name):
                raise ParameterError(
                    f"{type(self).__name__} has the parameter {p.name} and no such field; write "
                    f"`{p.name}: float` in the class, under @dataclass(frozen=True, eq=False)."
                )
            if getattr(self, p.name) is None and len(self.alternatives(p.name)) > 1:
                continue
            object.__setattr__(self, p.name, self.accepted(p.name, getattr(self, p.name)))

    @property
    def given(self) -> dict[str, Any]:
        """Each given parameter by name; empty for a law without parameters."""
        values = {p.name: getattr(self, p.name, None) for p in self.parameters}
        return {n: v for n, v in values.items() if v is not None}

    @classmethod
    def symbols(cls) -> tuple[str, ...]:
        """Names of the parameters in the equations."""
        return tuple(dict.fromkeys(p.place for p in cls.parameters))

    @classmethod
    def arguments(cls, given: Mapping[str, Any], scales: Units) -> dict[str, Any]:
        """Dimensionless parameters of the equations by name, over any number type.

        Parameters
        ----------
        given
            Numbers by name, in the user's units; names that are no parameters are ignored.
        scales
            Units of the body.
        """
        return {
            p.place: p.dimensionless(given[p.name], scales)
            for p in cls.parameters
            if p.name in given
        }

    @classmethod
    def accepted(cls, name: str, value: Any) -> Number:
        """Values of a parameter in double precision, or an error that says what is accepted.

        Parameters
        ----------
        name
            Name of the parameter.
        value
            A number or an array of numbers, any shape.
        """
        [parameter] = [p for p in cls.parameters if p.name == name]
        if parameter.zero:
            return positive(name, value, "it must not be negative", zero=True)
        first = parameter.place == cls.parameters[0].place
        return positive(name, value, *((ZERO_MU,) if first else ()))

    @classmethod
    def alternatives(cls, name: str) -> tuple[str, ...]:
        """Names of the parameters with the symbol of this one, its own name included.

        Parameters
        ----------
        name
            Name of a parameter; for any other name the result is empty.
        """
        places = {p.place for p in cls.parameters if p.name == name}
        return tuple(p.name for p in cls.parameters if p.place in places)

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
            Dimensionless parameter of the law [-]; for several parameters a tuple, in order.
        """
        raise NameUnknownError(f"the contact law {type(self).__name__} states no force.")

    @OVER_ANY_NUMBER
    def power(self, slip: Any, normal: Any, mu: Any) -> Any:
        """Power that the law dissipates [m g √(gR)]; arguments as in `force`."""
        force = self.force(slip, normal, mu)
        return -(force[0] * slip[0] + force[1] * slip[1])


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
    formula: ClassVar[str] = "F = 0"
    conservative: ClassVar[bool] = True
    slips: ClassVar[bool] = False

    @OVER_ANY_NUMBER
    def force(self, slip: Any, normal: Any, mu: Any) -> Any:  # noqa: ARG002
        """Zero."""
        return [0, 0]


@dataclass(frozen=True, eq=False)
class Viscous(Contact):
    """Friction −mu·gn·vA, the law of Przybylska & Rauch-Wojciechowski 2016.

    The force grows with the slip: 0.3 s/m is next to no friction for a coin.  A coefficient of
    friction from a table, a number without unit, is that of `Coulomb`.

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
    formula: ClassVar[str] = "F = -μ N v"
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
    >>> st.LinearViscous.like(0.3, st.Disk(mass=2.0, radius=1.0, gravity=1.0)).c
    0.6
    """

    c: ArrayLike | None = None
    """Friction coefficient [kg/s], or None."""
    mu: ArrayLike | None = None
    """Friction coefficient of the viscous law with the same linearisation [s/m], or None."""
    name: ClassVar[str] = "linear-viscous"
    formula: ClassVar[str] = "F = -c v, c = μ m g"
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
    formula: ClassVar[str] = "v = 0"
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
    formula: ClassVar[str] = "F = -μ N v"
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


MU, DIRECTION = "mu", "direction"
"""Parameters: the friction coefficient, and a stated direction of slip."""


def _over_speed(value: Any, scales: Units) -> Any:
    return value / scales.speed


@dataclass(frozen=True, eq=False)
class Coulomb(Contact):
    """Dry friction, set-valued at rest: −mu·gn along the slip, or sticking with |F| ≤ mu·gn.

    Sticking is the rough disk inside the friction cone.  The law has no linearisation at rest, so
    it is for motion (`simulate`) and not for spectra.

    Parameters
    ----------
    mu
        Friction coefficient, positive [-], the same at rest and in slip.

    Raises
    ------
    ParameterError
        If mu is not a finite number above zero.

    Source: Le Saux, Leine & Glocker, J. Nonlinear Sci. 15 (2005) 27-61, for the disk.

    Examples
    --------
    >>> import stability as st
    >>> st.Coulomb(0.3).force([3.0, 4.0], 1.0, 0.3)
    [-0.18, -0.24]
    """

    mu: ArrayLike
    """Friction coefficient [-]."""
    name: ClassVar[str] = "coulomb"
    formula: ClassVar[str] = "|F| = μ N"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("mu", "1"),)
    linearises: ClassVar[bool] = False
    sticks: ClassVar[bool] = True

    @OVER_ANY_NUMBER
    def force(self, slip: Any, normal: Any, mu: Any) -> Any:
        """Against the slip, mu times the normal force; not defined at rest."""
        size = (slip[0] * slip[0] + slip[1] * slip[1]) ** 0.5
        return [-mu * normal * slip[0] / size, -mu * normal * slip[1] / size]


class CoulombAlong(Coulomb):
    """Dry friction against a stated direction of slip, an angle from x̂ and the second parameter."""

    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter(MU, "1"), Parameter(DIRECTION, "rad"))

    def force(self, slip: Any, normal: Any, mu: Any) -> Any:  # noqa: ARG002
        """Against the direction, mu times the normal force."""
        import casadi as ca  # the command line reads the laws for its help

        coefficient, angle = mu
        return [-coefficient * normal * ca.cos(angle), -coefficient * normal * ca.sin(angle)]


@dataclass(frozen=True, eq=False)
class RegularisedCoulomb(Contact):
    """Dry friction made smooth: −mu·gn·vA/√(|vA|² + ε²); the disk creeps where `Coulomb` sticks.

    Parameters
    ----------
    mu
        Friction coefficient, positive [-].
    epsilon
        Slip speed ε below which the force decreases to zero, positive [m/s].

    Raises
    ------
    ParameterError
        If mu or epsilon is not a finite number above zero.

    Source: tends to dry friction at a known rate: tests/integrators/test_coulomb.py.

    Examples
    --------
    >>> import stability as st
    >>> st.RegularisedCoulomb(0.3, 1e-3).epsilon
    0.001
    """

    mu: ArrayLike
    """Friction coefficient [-]."""
    epsilon: ArrayLike
    """Slip speed below which the force decreases to zero [m/s]."""
    name: ClassVar[str] = "coulomb-regularised"
    formula: ClassVar[str] = "F = -μ N v/√(v² + ε²)"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("mu", "1"),
        Parameter("epsilon", "m/s", _over_speed),
    )
    linearises: ClassVar[bool] = False

    @OVER_ANY_NUMBER
    def force(self, slip: Any, normal: Any, mu: Any) -> Any:
        """Against the slip; mu is the pair (mu, epsilon)."""
        coefficient, epsilon = mu
        size = (slip[0] * slip[0] + slip[1] * slip[1] + epsilon * epsilon) ** 0.5
        return [-coefficient * normal * slip[0] / size, -coefficient * normal * slip[1] / size]


CREEP: tuple[type[Contact], ...] = (Rough, Creep, Creep2, Creep3)
"""The slow manifold of viscous contact by order; order 0 is the rough disk."""
_EVERY: tuple[type[Contact], ...] = (
    Smooth,
    Viscous,
    LinearViscous,
    Rough,
    Coulomb,
    RegularisedCoulomb,
    *CREEP[1:],
)
MOTION_LAWS: dict[str, type[Contact]] = {law.name: law for law in _EVERY}
"""The contact laws of the package by name: `simulate` accepts them all."""
LAWS = {n: law for n, law in MOTION_LAWS.items() if law.linearises and law not in CREEP[1:]}
"""Those with a linearisation that are no approximation of another one."""


def law_class(law: str | Contact | type[Contact] | None, *, motion: bool = True) -> type[Contact]:
    """The class of a contact law, of the package or of a user.

    Parameters
    ----------
    law
        A key of `MOTION_LAWS`, a contact law, or a subclass of `Contact`.
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
    linear = [n for n, entry in MOTION_LAWS.items() if entry.linearises]
    if law is None:
        raise law_missing(MOTION_LAWS if motion else LAWS)
    kind = type(law) if isinstance(law, Contact) else law
    if isinstance(kind, type) and issubclass(kind, Contact) and kind.name:
        law_type = kind
    elif isinstance(law, str) and law in MOTION_LAWS:
        law_type = MOTION_LAWS[law]
    else:
        law_type = MOTION_LAWS[known("contact", law, MOTION_LAWS if motion else linear)]
    if (law_type.sticks or not law_type.slips) and law_type not in MOTION_LAWS.values():
        raise NameUnknownError(
            f"the {law_type.name} law sticks or leaves out the slip, whose equations are those of "
            "the stored laws only; give a law with a force at every slip."
        )
    if not motion and not law_type.linearises:
        raise NameUnknownError(
            f"contact is {law_type.name}, which has no linearisation of its own; known are "
            f"{', '.join(linear)}; inside the friction cone it is `rough`."
        )
    return law_type


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
    calls = []
    for law in laws.values():
        first = {p.place: p.name for p in reversed(law.parameters)}
        calls.append(as_called(law, *reversed(first.values())))
    return calls


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


def law_named(
    name: str,
    mu: float | None,
    *,
    motion: bool = False,
    others: Mapping[str, float] | None = None,
) -> Contact:
    """The contact law of that name, with its parameters.

    Parameters
    ----------
    name
        A key of `MOTION_LAWS`, or `module:Class` for a user's law.
    mu
        Friction coefficient [s/m, dry friction: -], or None for a law without one.  For
        `linear-viscous` it gives c = mu m g, with the same linearisation.
    motion
        Whether the law is for a motion; dry friction is accepted only then.
    others
        Further parameters of the law by name.

    Returns
    -------
    Contact

    Raises
    ------
    NameUnknownError
        If the law is unknown, or is refused by `law_class`.
    ParameterError
        If a parameter is missing or not positive, or the law does not have it.

    Examples
    --------
    >>> law_named("viscous", 0.3).mu
    0.3
    """
    law = class_named(name, motion=motion)
    parameters = {"mu": mu} | dict(others or {})
    parameters = {n: v for n, v in parameters.items() if v is not None}
    for n in parameters:
        if n not in [p.name for p in law.parameters]:
            if n == "mu":
                names = listed([p.name for p in law.parameters] or ["no coefficient"])
                remedy = f"takes {names}" if law.parameters else f"has {names}; leave it out"
                raise ParameterError(f"mu is given but the {law.name} law {remedy}.")
            owners = [w for w, o in MOTION_LAWS.items() if o.alternatives(n)]
            where = f"; it belongs to {listed(owners)}" if owners else ""
            raise ParameterError(f"{n} is given but the {law.name} law has none{where}.")
    for p in law.parameters:
        if not set(law.alternatives(p.name)) & set(parameters):
            word = "mu" if "mu" in law.alternatives(p.name) else p.name
            option = "--mu" if word == "mu" else f"--set {word}=VALUE"
            raise ParameterError(
                f"{word} is missing; the {law.name} law needs a positive coefficient ({option})."
            )
    return law(**parameters)


def law_given(
    contact: Any, values: dict[str, Any], *, motion: bool = False, swept: Collection[str] = ()
) -> Any:
    """The contact law of a call: an instance as it is, or a word or class with numbers by name.

    Parameters
    ----------
    contact
        What the caller gave; None counts as viscous where `mu` is given or swept.
    values
        Numbers by name; those of the law are taken out.
    motion
        As for `law_named`.
    swept
        Parameters of an axis, whose value is set later.

    Returns
    -------
    Contact
        Anything else that was given is returned as it is.

    Raises
    ------
    NameUnknownError, ParameterError
        As for `law_named`.

    Examples
    --------
    >>> law_given("viscous", {"mu": 0.3}).mu
    0.3
    """
    if contact is None and "mu" in (*values, *swept):
        law = law_given(Viscous, values, motion=motion, swept=swept)
        object.__setattr__(law, "formula", law.formula + TAKEN)
        return law
    if not isinstance(contact, (str, type)):
        return contact
    law = (
        class_named(contact, motion=motion)
        if isinstance(contact, str)
        else law_class(contact, motion=motion)
    )
    parameters: dict[str, Any] = {}
    for p in law.parameters:
        if p.name in swept and p.name in values:
            raise ParameterError(f"{p.name} is given as a value and as an axis; give it once.")
        if p.name in values:
            parameters[p.name] = values.pop(p.name)
        elif p.name in swept and not set(law.alternatives(p.name)) & set(parameters):
            parameters[p.name] = 1.0  # the axis replaces this value
    for p in law.parameters:
        if not set(law.alternatives(p.name)) & set(parameters):
            refuse_misspelt(law, values)
            words = dict.fromkeys(
                "mu" if "mu" in law.alternatives(n) else n for n in (q.name for q in law.parameters)
            )
            word = "mu" if "mu" in law.alternatives(p.name) else p.name
            numbers = listed([f"{n}=NUMBER" for n in words])
            named = f", or contact={law.name!r} with {numbers}" * (law in MOTION_LAWS.values())
            axis = f", or make {word} an axis" * bool(swept)
            raise ParameterError(f"{word} is missing; give {as_called(law, *words)}{named}{axis}.")
    return law(**parameters)


def refuse_misspelt(law: type[Contact], arguments: Collection[str]) -> None:
    """Refuse a name that the law does not have, before a parameter that it has is missing.

    Parameters
    ----------
    law
        The law.
    arguments
        Names that the caller gave.
    """
    names = [n for p in law.parameters for n in (p.name, *law.alternatives(p.name))]
    for name in arguments:
        near = meant(name, names)
        if near and near != name:
            raise NameUnknownError(f"{shown(name)} is not an argument here; {near} is.")


def law_only(
    contact: Any, values: dict[str, Any], *, motion: bool = False, swept: Collection[str] = ()
) -> Any:
    """The contact law of a call that takes no other numbers by name.

    Parameters
    ----------
    contact, values, motion, swept
        As for `law_given`.

    Returns
    -------
    Contact
        Anything else that was given is returned as it is.

    Raises
    ------
    NameUnknownError, ParameterError
        As for `law_given`, or if a number belongs to no law.

    Examples
    --------
    >>> law_only("rough", {}).name
    'rough'
    """
    law = law_given(contact, values, motion=motion, swept=swept)
    for name in values:
        refuse_second(law, name)
        refuse_misspelt(Viscous, values)
        raise ParameterError(
            f"{shown(name)} is not an argument here; the disk's numbers go in disk=Disk(...), and "
            "in contact=Viscous(mu) or contact='viscous' with mu=NUMBER."
        )
    return law


def refuse_second(law: Any, name: str) -> None:
    """Refuse the number of a law where the law is given with its numbers."""
    if isinstance(law, Contact) and any(m.alternatives(name) for m in MOTION_LAWS.values()):
        raise ParameterError(f"{name} is given, and contact is {law}; leave {name} out.")


def class_named(name: str, *, motion: bool = False) -> type[Contact]:
    """The class of a contact law by its name; arguments as in `law_named`."""
    of_module = isinstance(name, str) and ":" in name
    return law_class(_imported(name) if of_module else name, motion=motion)


def _imported(place: str) -> Any:
    """The class at `module:Class`, found from the working directory too."""
    module, _, name = place.partition(":")
    if not all(part.isidentifier() for part in (*module.split("."), name)):
        raise NameUnknownError(f"contact is {shown(place)}; give `module:Class`.")
    law_type = imported(
        "contact",
        place,
        lambda: getattr(import_module(module), name),
        os.getcwd(),
        "give a module on Python's path or in this folder, and a class in it",
    )
    if not (isinstance(law_type, type) and issubclass(law_type, Contact) and law_type.name):
        raise NameUnknownError(
            f"contact is {shown(place)}, which is not a subclass of Contact with a name of its own."
        )
    return law_type
