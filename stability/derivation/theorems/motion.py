"""The disk's equations in SymPy, read from the graph, for any contact force.

A contact law whose force is two free numbers gives Newton-Euler for every law at once.  Sine and
cosine of theta are symbols with s² + c² = 1.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, ClassVar

import casadi as ca
import sympy

from ...algebra.number_types import sympy_algebra
from ...algebra.program import Program
from ...bodies.contact import Contact, Parameter
from ...bodies.contact_laws import LAWS
from ...bodies.thin_disk.disk_equations import disk_system
from ..characteristic import COS, MU, SIN, K

Expr = Any
"""A SymPy expression; SymPy states no types."""
THETA_DOT, PHI, SPIN, SLIP_X, SLIP_Y = sympy.symbols("theta_dot phi_dot omega3 slip_x slip_y")
FORCE_X, FORCE_Y, NORMAL = sympy.symbols("F_x F_y g_n")
RATES = sympy.symbols("theta_ddot phi_ddot omega3_dot slip_x_dot slip_y_dot")
THETA_DDOT, PHI_DDOT, SPIN_DOT, SLIP_X_DOT, SLIP_Y_DOT = RATES
SPEEDS = (THETA_DOT, PHI, SPIN, SLIP_X, SLIP_Y)
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
        Parameter("force_x", "1"), Parameter("force_y", "1"),
    )  # fmt: skip

    def force(self, slip: Any, normal: Any, mu: Any) -> Any:  # noqa: ARG002
        """The two numbers."""
        return list(mu)


@dataclass(frozen=True)
class Motion:
    """Newton-Euler for any contact force: every row is zero along a motion."""

    newton: tuple[Expr, Expr, Expr]
    """Newton's law along x̂, ŷ, ẑ."""
    euler: tuple[Expr, Expr, Expr]
    """Euler's law along 1̂, 2̂, 3̂."""
    energy: Expr
    """Energy, a polynomial in the speeds and s."""

    @property
    def rows(self) -> tuple[Expr, ...]:
        """Every row."""
        return (*self.newton, *self.euler)


def _read(law: str | type[Contact]) -> tuple[sympy.Matrix, sympy.Matrix, Expr, tuple[str, ...]]:
    """Mass matrix, forcing, energy and names of the unknowns of a law."""
    system = disk_system(law)
    assert system.mass is not None and system.forcing is not None
    out = [system.mass, system.forcing, system.observables["energy"]]
    program = Program(ca.Function("implicit", [system.x, system.p], out))
    algebra = sympy_algebra()
    functions = dict(algebra.functions) | {"sin": lambda _: SIN, "cos": lambda _: COS}
    algebra = replace(algebra, functions=functions)
    numbers = [FORCE_X, FORCE_Y] if law is StatedForce else [MU]
    given = [[sympy.Symbol("theta"), *SPEEDS], [K, *numbers]]
    mass, forcing, energy = (sympy.Matrix(program.dense(algebra, given, i)) for i in range(3))
    return mass, forcing, energy[0], system.unknowns


@lru_cache(maxsize=1)
def motion() -> Motion:
    """The equations for any contact force, from the graph.

    Examples
    --------
    >>> simplified(motion().newton[2].subs(STEADY))
    1 - g_n
    """
    mass, forcing, energy, names = _read(StatedForce)
    known = {"normal": NORMAL, "d_theta_dot": THETA_DDOT, "d_phi_dot": PHI_DDOT}
    known |= {"d_omega3": SPIN_DOT, "d_slip_x": SLIP_X_DOT, "d_slip_y": SLIP_Y_DOT}
    rows = mass * sympy.Matrix([known[n] for n in names]) - forcing
    return Motion(tuple(rows[:3]), tuple(rows[3:]), energy)


@lru_cache(maxsize=4)
def determinant(law: str) -> Expr:
    """Determinant of the equations for the accelerations and the normal force.

    Parameters
    ----------
    law
        Name of a contact law with slip.

    Examples
    --------
    >>> determinant("linear-viscous").has(K)
    True
    """
    return simplified(_read(law)[0].det(method="berkowitz"))


def force(law: str) -> tuple[Expr, Expr]:
    """The force of a stored law of one coefficient, as the package states it.

    Parameters
    ----------
    law
        Name of the law.

    Examples
    --------
    >>> force("viscous")[0]
    -g_n*mu*slip_x
    """
    stated = LAWS[law].__new__(LAWS[law])  # only its formula is used
    x, y = stated.force([SLIP_X, SLIP_Y], NORMAL, MU)
    return x, y


def rate(expression: Expr) -> Expr:
    """d/dt along the motion, by the chain rule.

    Parameters
    ----------
    expression
        Polynomial in s, c and the speeds.
    """
    along = THETA_DOT * (COS * expression.diff(SIN) - SIN * expression.diff(COS))
    return along + sum(expression.diff(x) * d for x, d in zip(SPEEDS, RATES, strict=True))


def simplified(expression: Expr) -> Expr:
    """The polynomial with cosθ to the first power at most, factored.

    Parameters
    ----------
    expression
        Polynomial in s and c.
    """
    poly = sympy.Poly(sympy.expand(expression), COS)
    terms = (a * COS ** (n % 2) * (1 - SIN**2) ** (n // 2) for (n,), a in poly.terms())
    return sympy.factor(sympy.expand(sum(terms)))


def same(left: Expr, right: Expr) -> bool:
    """Whether two polynomials are equal, given s² + c² = 1.

    Parameters
    ----------
    left, right
        Polynomials in s and c.

    Examples
    --------
    >>> same(SIN**2, 1 - COS**2), same(SIN, COS)
    (True, False)
    """
    return bool(simplified(sympy.sympify(left) - right) == 0)
