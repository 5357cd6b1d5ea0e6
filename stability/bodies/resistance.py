"""Resistance to rolling and turning: moments that add to a contact law."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

from numpy.typing import ArrayLike

from ..base.checks import positive
from ..base.errors import ParameterError, shown
from ..base.types import Record

UNITS = ("kg", "m", "s", "N")
"""Units whose products are those of coefficients: of mass, length, time and force."""


@dataclass(frozen=True, eq=False)
class Resistance(Record):
    """The base of the resistances: a moment against the body's rotation; one frozen subclass each.

    A resistance states its `name`, the name and unit of its coefficient, and its `moment`, which
    must be linear in the normal force and in the coefficient.  A subclass has one field, the
    coefficient; its unit is a product of kg, m, s and N.

    Source: linear resistance;
    its work against the power along the run: tests/motion/test_resisted_motion.py.

    Examples
    --------
    >>> import stability as st
    >>> st.RollingResistance(0.01).moment((1.0, 2.0, 3.0), 10.0, 0.01)
    [-0.1, -0.2, 0]
    """

    name: ClassVar[str] = ""
    """Name in messages and files."""
    coefficient: ClassVar[str] = ""
    """Name of the coefficient: of the field, and of the parameter in equations and maps."""
    unit: ClassVar[str] = "1"
    """SI unit of the coefficient."""
    against: ClassVar[tuple[str, ...]] = ("level", "vertical")
    """Parts of the angular velocity that cost energy."""

    def __post_init__(self) -> None:
        if not self.coefficient or not hasattr(self, self.coefficient):
            raise ParameterError(
                f"{type(self).__name__} has the coefficient {shown(self.coefficient)} and no such "
                "field; write `coefficient` and a field of that name in a subclass, under "
                "@dataclass(frozen=True, eq=False)."
            )
        value = positive(self.coefficient, getattr(self, self.coefficient), zero=True)
        object.__setattr__(self, self.coefficient, value)

    @property
    def value(self) -> Any:
        """The coefficient."""
        return getattr(self, self.coefficient)

    def dimensionless(self, units: Mapping[str, Any]) -> Any:
        """The coefficient where mass, gravity and length are 1.

        Parameters
        ----------
        units
            The body's units of `kg`, `m`, `s` and `N` by name.

        Examples
        --------
        >>> import stability as st
        >>> st.AirTorque(6.0).dimensionless({"N": 2.0, "m": 0.5, "s": 3.0})
        2.0
        """
        value = self.value
        for word in self.unit.split():
            if word == "1":
                continue
            if word not in units:
                raise ParameterError(
                    f"the unit of {self.coefficient} is {shown(self.unit)}; give a product of "
                    f"{', '.join(units)}, or 1."
                )
            value = value / units[word]
        return value

    def moment(self, turn: Sequence[Any], normal: Any, value: Any) -> list[Any]:  # noqa: ARG002
        """Moment on the body along two horizontal axes and the vertical.

        Parameters
        ----------
        turn
            Angular velocity along the same axes [rad/s].
        normal
            Normal force [N].
        value
            The coefficient.
        """
        raise ParameterError(f"the resistance {type(self).__name__} states no moment.")


@dataclass(frozen=True, eq=False)
class RollingResistance(Resistance):
    """A moment -ρ·N·ω against the horizontal angular velocity: viscous rolling friction.

    Parameters
    ----------
    rho
        Coefficient, at least 0 [m s].

    Raises
    ------
    ParameterError
        If it is not a finite number of at least 0.

    Source: linear resistance; its work against the power along the run:
    tests/motion/test_resisted_motion.py.

    Examples
    --------
    >>> import stability as st
    >>> st.RollingResistance(0.01).rho
    0.01
    """

    rho: ArrayLike
    """Coefficient [m s]."""
    name: ClassVar[str] = "rolling resistance"
    coefficient: ClassVar[str] = "rho"
    unit: ClassVar[str] = "m s"
    against: ClassVar[tuple[str, ...]] = ("level",)

    def moment(self, turn: Sequence[Any], normal: Any, value: Any) -> list[Any]:
        """Against ω_x and ω_y, in proportion to the normal force."""
        return [-value * normal * turn[0], -value * normal * turn[1], 0]


@dataclass(frozen=True, eq=False)
class PivotingResistance(Resistance):
    """A moment -σ·N·ω_z against turning about the vertical: viscous pivoting (drilling) friction.

    Parameters
    ----------
    sigma
        Coefficient, at least 0 [m s].

    Raises
    ------
    ParameterError
        If it is not a finite number of at least 0.

    Source: linear resistance;
    its work against the power along the run: tests/motion/test_resisted_motion.py.

    Examples
    --------
    >>> import stability as st
    >>> st.PivotingResistance(0.01).moment((1.0, 2.0, 3.0), 10.0, 0.01)[2]
    -0.30000000000000004
    """

    sigma: ArrayLike
    """Coefficient [m s]."""
    name: ClassVar[str] = "pivoting resistance"
    coefficient: ClassVar[str] = "sigma"
    unit: ClassVar[str] = "m s"
    against: ClassVar[tuple[str, ...]] = ("vertical",)

    def moment(self, turn: Sequence[Any], normal: Any, value: Any) -> list[Any]:
        """Against ω_z, in proportion to the normal force."""
        return [0, 0, -value * normal * turn[2]]


@dataclass(frozen=True, eq=False)
class AirTorque(Resistance):
    """A moment -d·ω against the whole angular velocity: the drag of air, linear in the rate.

    Parameters
    ----------
    drag
        Coefficient, at least 0 [N m s].

    Raises
    ------
    ParameterError
        If it is not a finite number of at least 0.

    Source: linear resistance;
    its work against the power along the run: tests/motion/test_resisted_motion.py.

    Examples
    --------
    >>> import stability as st
    >>> st.AirTorque(0.5).moment((1.0, 2.0, 3.0), 10.0, 0.5)
    [-0.5, -1.0, -1.5]
    """

    drag: ArrayLike
    """Coefficient [N m s]."""
    name: ClassVar[str] = "air torque"
    coefficient: ClassVar[str] = "drag"
    unit: ClassVar[str] = "N m s"

    def moment(self, turn: Sequence[Any], normal: Any, value: Any) -> list[Any]:  # noqa: ARG002
        """Against every component."""
        return [-value * w for w in turn]


RESISTANCES = {
    "rolling_resistance": RollingResistance,
    "pivoting_resistance": PivotingResistance,
    "air_torque": AirTorque,
}
"""The package's resistances by name, as in files and options."""


def resistances(argument: Any) -> tuple[Resistance, ...]:
    """Resistances of a call: none, one, or several of different kinds.

    Parameters
    ----------
    argument
        None, a `Resistance`, or a sequence of them.

    Raises
    ------
    ParameterError
        If it is anything else, or two are of one kind.

    Examples
    --------
    >>> [r.name for r in resistances([AirTorque(0.1), RollingResistance(0.2)])]
    ['air torque', 'rolling resistance']
    """
    every = (
        () if argument is None else (argument,) if isinstance(argument, Resistance) else argument
    )
    if not isinstance(every, Sequence) or not all(isinstance(r, Resistance) for r in every):
        raise ParameterError(
            f"resistance is {shown(argument)}; give RollingResistance(rho), "
            "PivotingResistance(sigma) or AirTorque(drag), or a list of these."
        )
    names = [r.coefficient for r in every]
    double = {n for n in names if names.count(n) > 1}
    if double:
        raise ParameterError(f"two resistances have the coefficient {min(double)}; give one.")
    return tuple(every)


def total_moment(
    against: Sequence[tuple[type[Resistance], Any]], turn: Sequence[Any], normal: Any
) -> list[Any]:
    """Moment of several resistances along two horizontal axes and the vertical.

    Parameters
    ----------
    against
        Classes, each with its coefficient.
    turn, normal
        As for `Resistance.moment`.

    Examples
    --------
    >>> total_moment([(AirTorque, 0.5), (RollingResistance, 0.1)], (1.0, 2.0, 4.0), 10.0)
    [-1.5, -3.0, -2.0]
    """
    total: list[Any] = [0, 0, 0]
    for kind, value in against:
        form = kind.__new__(kind)  # only its formula is used, never its coefficient
        moment = form.moment(turn, normal, value)
        if not isinstance(moment, (tuple, list)) or len(moment) != 3:
            raise ParameterError(
                f"the moment of {kind.name or kind.__name__} is {shown(moment)}; give a list of "
                "three, along two horizontal axes and the vertical."
            )
        total = [a + b for a, b in zip(total, moment, strict=True)]
    return total
