"""Dry friction: set-valued at rest, and made smooth."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from numpy.typing import ArrayLike

from ..base.quantities import Units
from .contact import OVER_ANY_NUMBER, Contact, Parameter

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
