"""Characteristic polynomials of every body of revolution, derived from the general graph.

They are no reading of one family's Jacobian: the height is any function, and det(λ - A) is that of
the implicit equations, whose form by the place of the contact point is short.

At rolling and spinning h′ = 0.  At tumbling h = r sinθ + z cosθ and h′ = r cosθ - z sinθ, where r
and z say where the contact point lies: the centre rests, so ω₃ = φ̇ sinθ z/r, and φ̇² follows from
φ̇² sinθ (I1 r cosθ - I3 z sinθ) = h′ r.

The graph is read at one state, in SymPy.  The height is a cubic polynomial in θ about the state, so
its value, slope, second and third derivative there are four free symbols.  Mass, gravity and length
are 1.  Sine and cosine of θ are symbols with s² + c² = 1.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import casadi as ca
import sympy
from sympy.polys.matrices import DomainMatrix

from stability.algebra.program import Program
from stability.base.checks import known
from stability.bodies.contact_laws import LAWS, Contact
from stability.bodies.round_body.body import Body
from stability.bodies.round_body.equations import round_system
from stability.derivation.characteristic import COS, LAM, MU, SIN
from stability.derivation.hurwitz import factored

from .disk_polynomials import algebra_of_angle

Expr = Any
"""A SymPy expression; SymPy states no types."""
H, SLOPE, BEND, THIRD = sympy.symbols("h h′ h′′ h′′′")
"""The height at the state and its derivatives."""
I1, I3 = sympy.symbols("I1 I3")
"""Moments of inertia, transverse and axial."""
RHO = sympy.Symbol("ρ")
"""Radius of curvature of the meridian, h + h′′."""
R, Z = sympy.symbols("r z")
"""Distances of the contact point from the axis, and along the axis from the centre."""
THETA_DOT, PHI, SPIN, SLIP_X, SLIP_Y = sympy.symbols("theta_dot phi_dot omega3 slip_x slip_y")
FORCE_X, FORCE_Y, NORMAL = sympy.symbols("F_x F_y g_n")
RATES = sympy.symbols("theta_ddot phi_ddot omega3_dot slip_x_dot slip_y_dot")
THETA_DDOT, PHI_DDOT, SPIN_DOT, SLIP_X_DOT, SLIP_Y_DOT = RATES
SPEEDS = (THETA_DOT, PHI, SPIN, SLIP_X, SLIP_Y)
STILL = {THETA_DOT: 0} | dict.fromkeys((THETA_DDOT, PHI_DDOT, SPIN_DOT), 0)
"""θ̇ and the accelerations of a steady motion."""
KNOWN = {
    "d_theta_dot": THETA_DDOT,
    "d_phi_dot": PHI_DDOT,
    "d_omega3": SPIN_DOT,
    "normal": NORMAL,
    "force_x": FORCE_X,
    "force_y": FORCE_Y,
    "d_slip_x": SLIP_X_DOT,
    "d_slip_y": SLIP_Y_DOT,
}
"""Symbols of the unknowns of the equations."""


@dataclass(frozen=True)
class Equations:
    """Newton and Euler at one state: every row is zero along a motion."""

    rows: tuple[Expr, ...]
    """Newton along x̂, ŷ, ẑ (ẑ alone without friction), Euler along 1̂, 2̂, 3̂."""
    by_state: sympy.Matrix
    """Derivatives of the rows by the states."""
    by_unknown: sympy.Matrix
    """Derivatives of the rows by accelerations, normal force, and forces or slip rates."""
    energy: Expr
    """Energy, without the third derivative."""


def _height(theta: Any, here: Any, h: Any, slope: Any, bend: Any, third: Any) -> Any:  # noqa: PLR0913
    step = theta - here
    return h + slope * step + bend * step**2 / 2 + third * step**3 / 6


@lru_cache(maxsize=8)
def equations(law: str | type[Contact]) -> Equations:
    """The equations of every body under a law, at a state with free symbols.

    Parameters
    ----------
    law
        Name of a law with at most one coefficient, or `StatedForce` for any force.

    Examples
    --------
    >>> equations("smooth").rows[-1]
    I3*omega3_dot
    """
    contact = LAWS[law] if isinstance(law, str) else law
    shape = {"here": 1.5, "h": 1.0, "slope": 0.0, "bend": 0.0, "third": 0.0}
    body = Body(
        _height, axial=0.5, transverse=0.4, shape=shape, name="any body", between=(1.4, 1.6)
    )
    system = round_system(body, contact, tuple(p.name for p in contact.parameters), physical=False)
    assert system.mass is not None and system.forcing is not None
    unknown = ca.SX.sym("u", len(system.unknowns))
    rows = system.mass @ unknown - system.forcing
    out = [
        rows,
        ca.jacobian(rows, system.x),
        ca.jacobian(rows, unknown),
        ca.SX(system.observables["energy"]),
    ]
    program = Program(ca.Function("implicit", [system.x, unknown, system.p], out))
    here = sympy.Symbol("theta")
    table = {
        "here": here,
        "h": H,
        "slope": SLOPE,
        "bend": BEND,
        "third": THIRD,
        "axial": I3,
        "transverse": I1,
        "mu": MU,
        "c": MU,
        "force_x": FORCE_X,
        "force_y": FORCE_Y,
    }
    state = [here, *SPEEDS][: len(system.states)]
    given = [state, [KNOWN[n] for n in system.unknowns], [table[n] for n in system.parameters]]
    algebra = algebra_of_angle()
    read = [sympy.Matrix(program.dense(algebra, given, i)).expand() for i in range(4)]
    return Equations(tuple(read[0]), read[1], read[2], read[3][0])


def pencil(law: str) -> sympy.Matrix:
    """The linearisation at a state with θ̇ = 0 and no slip, as a matrix that is polynomial in λ.

    A disturbance of θ, φ̇, ω₃, the normal force, and of slip or contact force grows with e^(λt)
    where the determinant vanishes.  θ̇ grows as λ times θ.
    """
    found = equations(law)
    x, u = found.by_state, found.by_unknown
    columns = [
        x[:, 0] + LAM * x[:, 1] + LAM**2 * u[:, 0],
        x[:, 2] + LAM * u[:, 1],
        x[:, 3] + LAM * u[:, 2],
        u[:, 3],
    ]
    more = u[:, 4:]
    if LAWS[law].slips:
        more = x[:, 4:] + LAM * more
    rest = STILL | dict.fromkeys((SLIP_X_DOT, SLIP_Y_DOT, *SPEEDS[3:]), 0)
    matrix = sympy.Matrix.hstack(*columns, more)
    return matrix.subs(rest | {NORMAL: 1, FORCE_Y: 0}).expand()


def folded(expression: Expr) -> Expr:
    """A polynomial with cosθ to the first power at most, expanded."""
    poly = sympy.Poly(sympy.expand(expression), COS)
    return sympy.expand(
        sum(a * COS ** (n % 2) * (1 - SIN**2) ** (n // 2) for (n,), a in poly.terms())
    )


CENTRE = {H: R * SIN + Z * COS, SLOPE: R * COS - Z * SIN}
"""The height and its slope by the place of the contact point."""
SQUARE = CENTRE[SLOPE] * R / (SIN * (I1 * R * COS - I3 * Z * SIN))
"""φ̇² of tumbling."""
STATES: dict[str, dict[Expr, Expr]] = {
    "rolling": {SLOPE: 0, PHI: 0},
    "spinning": {SLOPE: 0, SPIN: 0, SIN: 1, COS: 0},
    "tumbling": CENTRE | {SPIN: PHI * SIN * Z / R, BEND: RHO - CENTRE[H]},
}
"""Values of a family's states."""
RADIUS, AXIAL = H * SIN + SLOPE * COS, H * COS - SLOPE * SIN
"""r and z of the contact point."""
STORED_LAWS = ("viscous", "rough", "smooth")
"""Laws whose polynomials are derived."""
PAIRS = {"circling": "rough", "precession": "smooth"}
"""Families that two numbers name, each under its one law."""
PLACED = CENTRE | {BEND: RHO - CENTRE[H]}
"""The height and its slopes by r, z and ρ."""
PAIRED: dict[str, dict[Expr, Expr]] = {"circling": PLACED, "precession": {}}
"""Values by which the polynomials of such families are short."""


@dataclass(frozen=True)
class Characteristic:
    """The characteristic polynomial of a family of every body, without factors of known sign."""

    family: str
    """Name of the family."""
    law: str
    """Name of the law."""
    zeros: int
    """Multiplicity of the factor λ."""
    coefficients: tuple[Expr, ...]
    """Coefficients of the rest, the highest power of λ first, each factored."""
    left_out: Expr
    """The factor without λ that is left out."""

    @property
    def polynomial(self) -> sympy.Poly:
        """The rest as a polynomial in λ."""
        return sympy.Poly(list(self.coefficients), LAM)


@lru_cache(maxsize=16)
def characteristic(family: str, law: str) -> Characteristic:
    """The characteristic polynomial of a family with an inclined axis, for every body.

    Parameters
    ----------
    family
        rolling, spinning or tumbling; circling or precession, where ω₃ follows from their surface.
    law
        viscous, rough or smooth; rough for circling, smooth for precession.

    Examples
    --------
    >>> characteristic("spinning", "smooth").coefficients
    (I1, 0, I1*phi_dot**2 + h′′)
    """
    known("family", family, (*STATES, *PAIRS))
    if family in PAIRS:
        known("law", law, (PAIRS[family],))
        poly = pair_polynomial(family, PAIRED[family])
    else:
        rest = dict(STATES[family])
        spin = {SPIN: rest.pop(SPIN, SPIN)}  # with its fraction only after the determinant
        det = _determinant(known("law", law, STORED_LAWS), {FORCE_X: 0} | rest)
        poly = sympy.Poly(folded(sympy.fraction(sympy.together(det.subs(spin)))[0]), LAM)
    zeros = min(n for (n,) in poly.monoms())
    content, factors = sympy.factor_list(poly.as_expr())
    left = sympy.Mul(content, *[f**n for f, n in factors if not f.has(LAM)])
    rest = sympy.Poly(sympy.cancel(poly.as_expr() / left / LAM**zeros), LAM)
    if _negative(rest.LC()):
        rest, left = -rest, -left
    coefficients = tuple(factored(c) for c in rest.all_coeffs())
    return Characteristic(family, law, zeros, coefficients, left)


def _determinant(law: str, values: dict[Expr, Expr]) -> Expr:
    """The determinant of the pencil at values of its symbols."""
    whole = DomainMatrix.from_Matrix(pencil(law).subs(values, simultaneous=True).expand())
    return whole.domain.to_sympy(whole.det())


def pair_polynomial(family: str, place: dict[Expr, Expr]) -> sympy.Poly:
    """The whole polynomial in λ of circling or precession; ω₃ and φ̇ both stay in it."""
    law = PAIRS[family]
    force = PHI * (R * SPIN - PHI * SIN * Z) if law == "rough" else 0  # mass times acceleration
    det = _determinant(law, place | {FORCE_X: force})
    return sympy.Poly(folded(det), LAM)


def _negative(expression: Expr) -> bool:
    """Whether an expression is negative at one body, which only chooses a sign."""
    point = {
        I1: sympy.Rational(1, 3),
        I3: sympy.Rational(1, 2),
        H: 1,
        SLOPE: 0,
        R: 1,
        Z: 0,
        SIN: sympy.Rational(4, 5),
        COS: sympy.Rational(3, 5),
    }
    return bool(expression.subs(point) < 0)
