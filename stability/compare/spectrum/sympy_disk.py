"""The disk's equations in SymPy, from Newton and Euler, as people write them; no CasADi here.

Frames as in `stability.bodies.thin_disk`, whose code is not used: this is the route
of a person who has SymPy and the paper.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Any

import numpy as np
import sympy

from ...base.types import Floats

Matrices = Callable[[Floats, Floats], Floats]
"""(states (N, n), parameters (N, m)) → linearisations (N, n, n)."""

K, MU = sympy.symbols("k mu")
X = sympy.symbols("theta theta_dot phi_dot omega3 slip_x slip_y")
RATES = sympy.symbols("d_theta_dot d_phi_dot d_omega3 d_slip_x d_slip_y")
NORMAL, FORCE_X, FORCE_Y = sympy.symbols("normal force_x force_y")


@lru_cache(maxsize=8)
def residual(law: str) -> tuple[sympy.Matrix, list[Any], list[Any]]:
    """Residuals of the laws of Newton and Euler, their unknowns, and the states.

    Returns
    -------
    residual, unknowns, states
        The residual is linear in the unknowns, which begin with the accelerations in order.
    """
    theta, q, p, w, sx, sy = X
    slides = law in ("viscous", "linear-viscous")
    if not slides:
        sx, sy = (-q * sympy.sin(theta), w) if law == "smooth" else (sympy.S.Zero, sympy.S.Zero)
    fx, fy = {
        "smooth": (sympy.S.Zero, sympy.S.Zero),
        "rough": (FORCE_X, FORCE_Y),
        "viscous": (-MU * NORMAL * sx, -MU * NORMAL * sy),
        "linear-viscous": (-MU * sx, -MU * sy),
    }[law]
    sine, cosine = sympy.sin(theta), sympy.cos(theta)
    speed = dict(zip(X, (q, *RATES), strict=True))

    def rate(vector: sympy.Matrix) -> sympy.Matrix:
        return sum((vector.diff(s) * d for s, d in speed.items()), sympy.zeros(3, 1))

    velocity = sympy.Matrix([sx + q * sine, sy - w, q * cosine])
    newton = rate(velocity) + sympy.Matrix([0, 0, p]).cross(velocity)
    newton -= sympy.Matrix([fx, fy, NORMAL - 1])
    momentum = K * sympy.Matrix([-p * sine, q, 2 * w])
    frame = sympy.Matrix([-p * sine, q, p * cosine])
    torque = sympy.Matrix([0, -fx * sine - NORMAL * cosine, fy])
    euler = rate(momentum) + frame.cross(momentum) - torque
    # the vertical equation first: it is the simplest
    rows = [newton[2], *euler] + ([] if law == "smooth" else [newton[0], newton[1]])
    unknowns = [*RATES[:3], NORMAL]
    if law != "smooth":
        unknowns += list(RATES[3:]) if slides else [FORCE_X, FORCE_Y]
    return sympy.Matrix(rows), unknowns, list(X if slides else X[:4])


def _accelerations(unknowns: Sequence[Any], states: Sequence[Any]) -> list[int]:
    """Index of the unknown that is the rate of each state, from theta_dot on."""
    wanted = RATES[: len(states) - 1]
    return [list(unknowns).index(symbol) for symbol in wanted]


def _numbers(parameters: Floats) -> list[Any]:
    """K and mu of each point; 0 for a law without friction."""
    return [parameters[:, 0], parameters[:, 1] if parameters.shape[1] > 1 else 0.0]


def _compiled(arguments: Sequence[Any], expressions: Sequence[Any]) -> Callable[..., list[Any]]:
    compiled: Callable[..., list[Any]] = sympy.lambdify(
        arguments, list(expressions), modules="numpy", cse=True
    )
    return compiled


def _filled(values: Sequence[Any], shape: tuple[int, ...]) -> Floats:
    columns = [np.broadcast_to(v, shape[:1]) for v in values]
    return np.stack(columns, axis=-1).reshape(shape).astype(float)


@lru_cache(maxsize=8)
def kept_mass(law: str) -> Matrices:
    """Linearisation of the implicit equations, with a numerical solve by the mass matrix."""
    equations, unknowns, states = residual(law)
    mass, forcing = sympy.linear_eq_to_matrix(list(equations), unknowns)
    slopes = equations.jacobian(states)
    n, m = len(states), len(unknowns)
    symbols = [*states, K, MU]
    first = _compiled(symbols, [*mass, *forcing])
    second = _compiled([*symbols, *unknowns], list(slopes))
    picked = _accelerations(unknowns, states)

    def matrices(x: Floats, parameters: Floats) -> Floats:
        count = len(x)
        q = _numbers(parameters)
        both = _filled(first(*x.T, *q), (count, m * m + m))
        left, right = both[:, : m * m].reshape(count, m, m), both[:, m * m :, None]
        solved = np.linalg.solve(left, right)[..., 0]
        slope = _filled(second(*x.T, *q, *solved.T), (count, m, n))
        changes = -np.linalg.solve(left, slope)
        out = np.zeros((count, n, n))
        out[:, 0, 1] = 1.0
        out[:, 1:, :] = changes[:, picked, :]
        return out

    return matrices


@lru_cache(maxsize=8)
def solved(law: str) -> Matrices:
    """Linearisation of the accelerations as SymPy solves for them, one pivot after the other.

    The vertical equation comes first, so the first pivot is cosθ.  The result has cosθ in numerator
    and denominator, which cancels on paper and is 0/0 upright.
    """
    equations, unknowns, states = residual(law)
    mass, forcing = sympy.linear_eq_to_matrix(list(equations), unknowns)
    accelerations = mass.LUsolve(forcing)
    rates = sympy.Matrix([X[1], *[accelerations[i] for i in _accelerations(unknowns, states)]])
    compiled = _compiled([*states, K, MU], list(rates.jacobian(states)))
    n = len(states)

    def matrices(x: Floats, parameters: Floats) -> Floats:
        with np.errstate(all="ignore"):
            return _filled(compiled(*x.T, *_numbers(parameters)), (len(x), n, n))

    return matrices
