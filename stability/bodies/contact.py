"""The base of the contact laws: the force of the plane on the rim."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from ..base.checks import Number, positive
from ..base.errors import NameUnknownError, ParameterError
from ..base.quantities import Units
from ..base.types import Record
from ..base.user_code import arithmetic

ZERO_MU = "friction must be positive (without friction the law is Smooth(), `--contact smooth`)"

OVER_ANY_NUMBER = arithmetic(
    "give a slip of two numbers that is not zero under dry friction, the normal force and mu, all "
    "of one number type"
)


def plain(value: Any, scales: Units) -> Any:  # noqa: ARG001
    """The number itself, which has no unit."""
    return value


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
    """SI unit, `1` for a number without one."""
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
