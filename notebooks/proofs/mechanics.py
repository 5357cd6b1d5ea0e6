"""What the proofs share: any contact force, the power theorem, derivatives along a motion."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import sympy

from stability.bodies.contact_laws import LAWS, Contact, Parameter
from stability.derivation.characteristic import COS, MU, SIN

from .body_polynomials import (
    BEND,
    FORCE_X,
    FORCE_Y,
    NORMAL,
    PHI,
    RATES,
    SLIP_X,
    SLIP_X_DOT,
    SLIP_Y,
    SLIP_Y_DOT,
    SLOPE,
    SPEEDS,
    SPIN,
    THETA_DOT,
    THIRD,
    H,
    equations,
    folded,
)

Expr = Any
"""A SymPy expression; SymPy states no types."""
STEADY = dict.fromkeys((THETA_DOT, *RATES), 0)
"""θ̇ and every rate zero."""
NO_SLIP = dict.fromkeys((SLIP_X, SLIP_Y, SLIP_X_DOT, SLIP_Y_DOT), 0)
"""Slip zero on an interval."""


@dataclass(frozen=True, eq=False)
class StatedForce(Contact):
    """A horizontal contact force of two free numbers: every law has some force."""

    force_x: float
    """Force along x̂."""
    force_y: float
    """Force along ŷ."""
    name: ClassVar[str] = "stated-force"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("force_x", "1"),
        Parameter("force_y", "1"),
    )

    def force(self, slip: Any, normal: Any, mu: Any) -> Any:  # noqa: ARG002
        """The two numbers."""
        return list(mu)


def force(law: str) -> tuple[Expr, Expr]:
    """The force of a stored law of one coefficient, as the package states it.

    Examples
    --------
    >>> force("viscous")[0]
    -g_n*mu*slip_x
    """
    stated = LAWS[law].__new__(LAWS[law])  # only its formula is used
    x, y = stated.force([SLIP_X, SLIP_Y], NORMAL, MU)
    return x, y


def same_linearisation() -> bool:
    """Whether both viscous laws have one linearisation where vA = 0 and gn = 1."""
    rest = {SLIP_X: 0, SLIP_Y: 0, NORMAL: 1}
    pairs = zip(force("viscous"), force("linear-viscous"), strict=True)
    return all(
        (a - b).subs(rest) == 0 and (a - b).diff(x).subs(rest) == 0
        for a, b in pairs
        for x in (SLIP_X, SLIP_Y, NORMAL)
    )


def along(expression: Expr) -> Expr:
    """The derivative by θ, where the height and its slopes change with θ.

    Examples
    --------
    >>> along(H * SIN)
    c*h + h′*s
    """
    pairs = ((SIN, COS), (COS, -SIN), (H, SLOPE), (SLOPE, BEND), (BEND, THIRD))
    return sum(sympy.diff(expression, x) * slope for x, slope in pairs)


def rate(expression: Expr) -> Expr:
    """d/dt along a motion of a polynomial in s, c, h, its slopes and the speeds."""
    pairs = zip(SPEEDS, RATES, strict=True)
    return THETA_DOT * along(expression) + sum(expression.diff(x) * d for x, d in pairs)


def power_theorem() -> bool:
    """Whether dE/dt = F·vA for every body and every force, as an identity of the rows."""
    found = equations(StatedForce)
    up = PHI + (SPIN - PHI * COS) * COS
    rim = up * SLOPE + (SPIN - PHI * COS) * SIN * H
    velocity = (SLIP_X + THETA_DOT * H, SLIP_Y - rim, THETA_DOT * SLOPE)
    turning = (-PHI * SIN, THETA_DOT, SPIN)
    work = sum(a * b for a, b in zip(found.rows, (*velocity, *turning), strict=True))
    return vanishes(rate(found.energy) - FORCE_X * SLIP_X - FORCE_Y * SLIP_Y - work)


def vanishes(expression: Expr) -> bool:
    """Whether a rational function is zero, given s² + c² = 1.

    Examples
    --------
    >>> vanishes((1 - SIN**2) / COS - COS)
    True
    """
    return bool(folded(sympy.fraction(sympy.together(expression))[0]) == 0)


def simplified(expression: Expr) -> Expr:
    """A polynomial in s and c with cosθ to the first power at most, factored."""
    return sympy.factor(folded(expression))


def same(left: Expr, right: Expr) -> bool:
    """Whether two polynomials in s and c are equal, given s² + c² = 1.

    Examples
    --------
    >>> same(SIN**2, 1 - COS**2), same(SIN, COS)
    (True, False)
    """
    return bool(folded(sympy.sympify(left) - right) == 0)
