"""SymPy's own test models, and their linearisation by SymPy's `Linearizer` to 30 digits.

The models are harvested: SymPy's test functions run, and each KanesMethod or LagrangesMethod whose
equations they form is kept.  The oracle shares no code with the package: constraints, accelerations
and multipliers at a random state come from mpmath, and the linearisation from SymPy.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, NamedTuple

import mpmath
import numpy as np
import sympy as sm
from sympy.core.function import AppliedUndef
from sympy.physics.mechanics import KanesMethod, LagrangesMethod, dynamicsymbols

T = dynamicsymbols._t
DIGITS = 30


class Point(NamedTuple):
    """A state of a model on its constraints, and the linearisation there."""

    place: dict[str, float]
    """Values of coordinates, speeds, parameters and inputs by name."""
    names: tuple[str, ...]
    """Independent coordinates and speeds, in the order of the matrix."""
    matrix: Any
    """SymPy's linearisation, doubles."""


@contextmanager
def harvest() -> Iterator[list[Any]]:
    """A list that fills with the models whose equations are formed within the context."""
    found: list[Any] = []
    depth = 0

    def kept(method: Callable[..., Any]) -> Callable[..., Any]:
        def run(self: Any, *given: Any, **named: Any) -> Any:
            nonlocal depth
            depth += 1
            try:
                out = method(self, *given, **named)
            finally:
                depth -= 1
            if not depth:
                found.append(self)
            return out

        return run

    whole = KanesMethod.kanes_equations, LagrangesMethod.form_lagranges_equations
    KanesMethod.kanes_equations = kept(whole[0])
    LagrangesMethod.form_lagranges_equations = kept(whole[1])
    try:
        yield found
    finally:
        KanesMethod.kanes_equations, LagrangesMethod.form_lagranges_equations = whole


def named(symbol: Any) -> str:
    """The package's documented name: q, q_dot."""
    if symbol.is_Derivative:
        return f"{named(symbol.expr)}_dot"
    return symbol.name if symbol.is_Symbol else symbol.func.__name__


def partition(model: Any, dependent: tuple[Any, ...] = ()) -> tuple[list[Any], ...]:
    """Independent and dependent coordinates, then speeds."""
    if isinstance(model, KanesMethod):
        own = (*model._qdep, *model._udep)
    else:
        own = (*dependent, *(d.diff(T) for d in dependent if d in list(model.q)))
    parts = []
    for some in (list(model.q), list(model.u)):
        parts += [[s for s in some if s not in own], [s for s in some if s in own]]
    return tuple(parts)


def linearised(
    model: Any,
    dependent: tuple[Any, ...] = (),
    seed: int = 1,
    near: dict[str, float] | None = None,
    rest: bool = False,
) -> Point:
    """SymPy's linearisation at a random state on the constraints.

    `near` fixes values by name (dependent coordinates start there); `rest` sets all independent
    coordinates and speeds to zero.
    """
    near = near or {}
    made = random.Random(seed)
    q_i, q_d, u_i, u_d = partition(model, dependent)
    kane = isinstance(model, KanesMethod)
    matrix, forcing = model.mass_matrix_full, model.forcing_full
    known = {*model.q, *model.u}
    inputs = sorted((matrix.atoms(AppliedUndef) | forcing.atoms(AppliedUndef)) - known, key=str)
    aux = list(model._uaux) if kane else []
    symbols = sorted((matrix.free_symbols | forcing.free_symbols | _free(model)) - {T}, key=str)
    place: dict[Any, Any] = {s: _given(near, s, made.uniform(0.6, 1.9)) for s in symbols}
    place |= {f: _given(near, f, made.uniform(-0.5, 0.5)) for f in inputs if f not in aux}
    for s in (*q_i, *u_i):
        place[s] = _given(near, s, 0.0 if rest else made.uniform(-0.4, 0.4))
    zero = dict.fromkeys([*aux, *(a.diff(T) for a in aux)], sm.Integer(0))
    with mpmath.workdps(DIGITS + 10):
        place |= zero
        _solve_coordinates(model, q_d, place, near)
        _solve_speeds(model, u_d, place)
        point, operating = _accelerations(model, matrix, forcing, place)
    linearizer = model.to_linearizer() if kane else model.to_linearizer(q_i, u_i, q_d, u_d)
    m, a, _ = linearizer.linearize(op_point=operating)
    m, a = (_numbers(sm.Matrix(one).xreplace(operating)) for one in (m, a))
    whole = linearizer.perm_mat.T * m.LUsolve(a)
    names = tuple(named(s) for s in (*q_i, *u_i))
    return Point(
        {named(s): float(v) for s, v in point.items()}, names, np.array(whole.tolist(), dtype=float)
    )


def _free(model: Any) -> set[Any]:
    if isinstance(model, KanesMethod):
        return model._f_h.free_symbols | model._k_nh.free_symbols | model._f_nh.free_symbols
    return model._hol_coneqs.free_symbols | model.coneqs.free_symbols


def _given(near: dict[str, float], symbol: Any, otherwise: float) -> Any:
    value = near.get(named(symbol), otherwise)
    return sm.Rational(*float(value).as_integer_ratio())  # the same double for both sides


def _numbers(matrix: Any) -> Any:
    return matrix.applyfunc(lambda e: sm.nsimplify(e) if e.is_Float and e == 0 else e.evalf(DIGITS))


def _solve_coordinates(
    model: Any, q_d: list[Any], place: dict[Any, Any], near: dict[str, float]
) -> None:
    if not q_d:
        return
    constraints = sm.Matrix(model._f_h if isinstance(model, KanesMethod) else model._hol_coneqs)
    function = sm.lambdify(q_d, list(constraints.xreplace(place)), "mpmath")
    start = [near.get(named(s), 0.7) for s in q_d]
    found = mpmath.findroot(lambda *v: function(*v), start, tol=mpmath.mpf(10) ** (-2 * DIGITS))
    found = [found] if len(q_d) == 1 else list(found)
    found = [v[0] if hasattr(v, "rows") else v for v in found]
    place |= {s: sm.Float(str(v), DIGITS + 8) for s, v in zip(q_d, found, strict=True)}


def _solve_speeds(model: Any, u_d: list[Any], place: dict[Any, Any]) -> None:
    if not u_d:
        return
    if isinstance(model, KanesMethod):
        constraints = model._k_nh * sm.Matrix(model.u) + model._f_nh
    else:
        constraints = model.coneqs
    constraints = sm.Matrix(constraints)
    slopes = constraints.jacobian(u_d).xreplace(place)
    right = constraints.xreplace(dict.fromkeys(u_d, sm.Integer(0))).xreplace(place)
    found = slopes.evalf(DIGITS + 8).LUsolve(-right.evalf(DIGITS + 8))
    place |= dict(zip(u_d, found, strict=True))


def _accelerations(model: Any, matrix: Any, forcing: Any, place: dict[Any, Any]) -> tuple[Any, Any]:
    """Values of every symbol, and SymPy's operating point with derivatives and multipliers."""
    found = (
        matrix.xreplace(place).evalf(DIGITS + 8).LUsolve(forcing.xreplace(place).evalf(DIGITS + 8))
    )
    states = [*model.q, *model.u]
    rates = dict(zip([s.diff(T) for s in states], found, strict=False))
    operating = place | {k: v for k, v in rates.items() if k not in place}
    if isinstance(model, LagrangesMethod) and len(model.lam_vec):
        # SymPy's mass matrix holds its multipliers with the other sign
        operating |= dict(zip(model.lam_vec, -found[len(states) :, 0], strict=True))
    seen = {s: v for s, v in place.items() if not (s.is_Derivative and s not in states)}
    return seen, operating
