"""Exact linearisation of an ellipsoid of revolution that spins about its vertical axis.

Newton's and Euler's laws in inertial axes over the rationals.  The lowest point comes from the
quadric x² / a² + y² / a² + (z - z0)² / b² = 1 of the surface, in axes with the centre of mass as
origin, and no support function is used.  Units: m = g = 1.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import sympy as sp

Expr = Any
UP = sp.Matrix([0, 0, 1])
AXIS = sp.symbols("ex ey")
TURN = sp.symbols("wx wy wz")
SLIP = sp.symbols("vx vy")
NAMES = sp.symbols("square b z0 I1 I3 mu n")
"""a², b, z0, moments, friction, rate."""


@dataclass(frozen=True)
class Ellipsoid:
    """An ellipsoid on its end; all numbers rational."""

    square: Expr
    """a², of the equator's radius."""
    half: Expr
    """b, half of the axis."""
    centre: Expr
    """z0, the middle of the ellipsoid along its axis from the centre of mass."""
    transverse: Expr
    axial: Expr

    def height(self, side: int) -> Expr:
        """Height of the centre of mass on the end: side 1 where the axis points up."""
        return self.half - side * self.centre

    @property
    def curvature(self) -> Expr:
        """Radius of curvature of the meridian at both ends."""
        return self.square / self.half


@lru_cache(maxsize=8)
def _jacobian(law: str, side: int) -> sp.Matrix:
    """Derivatives of the rates of axis, angular velocity and slip, in symbols."""
    square, b, z0, i1, i3, mu, n = NAMES
    e = sp.Matrix([*AXIS, side])  # its vertical part changes at second order
    w = sp.Matrix(TURN)
    rate = sp.symbols("ax ay az")
    push, load = sp.symbols("fx fy"), sp.Symbol("N")
    slide = sp.symbols("dx dy")
    shape = square * sp.eye(3) + (b**2 - square) * e * e.T
    arm = z0 * e - shape * UP / sp.sqrt((UP.T * shape * UP)[0])
    turned = w.cross(e)
    moved = sum((arm.diff(x) * t for x, t in zip(AXIS, turned[:2], strict=True)), sp.zeros(3, 1))
    turning = sp.Matrix(rate)
    force = sp.Matrix([*push, load])
    newton = force - UP  # of the centre
    contact = newton + turning.cross(arm) + w.cross(moved) - sp.Matrix([*slide, 0])
    spin = turning.dot(e)
    euler = i1 * turning + (i3 - i1) * (spin * e + w.dot(e) * turned) - arm.cross(force)
    if law == "viscous":
        held = [f + mu * load * s for f, s in zip(push, SLIP, strict=True)]
    elif law == "rough":
        held = list(slide)
    else:
        held = list(push)
    rows = sp.Matrix([*euler, *contact, *held])
    unknown = sp.Matrix([*rate, load, *push, *slide])
    states = sp.Matrix([*AXIS, *TURN, *(SLIP if law == "viscous" else ())])
    base = dict.fromkeys((*AXIS, *TURN[:2], *SLIP, *rate, *push, *slide), 0) | {load: 1, TURN[2]: n}
    by_unknown = rows.jacobian(unknown).subs(base)
    by_state = rows.jacobian(states).subs(base)
    rates = -by_unknown.LUsolve(by_state)
    kept = [0, 1, 2, 6, 7][: 5 if law == "viscous" else 3]
    axis = turned[:2, :].jacobian(states).subs(base)
    assert all(sp.simplify(r) == 0 for r in rows.subs(base).subs(sp.sqrt(b**2), b))
    return sp.Matrix.vstack(axis, rates[kept, :])


def jacobian(body: Ellipsoid, law: str, side: int, mu: Expr, n: Expr) -> sp.Matrix:
    """The exact Jacobian at vertical spin with rate n: axis X, Y; angular velocity; slip X, Y."""
    values = (body.square, body.half, body.centre, body.transverse, body.axial, mu, n)
    given = dict(zip(NAMES, values, strict=True))
    return _jacobian(law, side).subs(given)
