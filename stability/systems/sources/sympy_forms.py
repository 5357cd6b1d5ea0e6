"""What SymPy's models say, brought to one form: matrix · unknowns = forcing, with constraints."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from ...base.errors import ParameterError, shown

FORMS = (
    "a KanesMethod, a LagrangesMethod, a mechanics.System, a tuple (mass matrix, forcing, q, u), "
    "or a mapping from states to rates"
)


@dataclass(frozen=True)
class Implicit:
    """A model's equations: matrix · (rates, accelerations, multipliers) = forcing."""

    q: tuple[Any, ...]
    """Coordinates."""
    u: tuple[Any, ...]
    """Speeds: functions of time, or derivatives of coordinates."""
    matrix: Any
    """Square SymPy matrix over the derivatives of q and u, then the multipliers."""
    forcing: Any
    """SymPy column."""
    blocks: tuple[int, ...]
    """Number of rows of each block: kinematics, dynamics, constraints of the accelerations."""
    zero: tuple[Any, ...] = ()
    """Symbols that are zero: auxiliary speeds."""
    configuration: tuple[Any, ...] = ()
    """Expressions in q that vanish."""
    velocity: tuple[Any, ...] = ()
    """Expressions linear in u that vanish."""
    dependent: tuple[Any, ...] = ()
    """Coordinates and speeds that the model itself calls dependent."""
    multipliers: int = 0
    """Number of constraint forces among the unknowns."""


def implicit(model: Any, chosen: Sequence[Any]) -> Implicit:
    """The equations of a SymPy model.

    Parameters
    ----------
    model
        One of `FORMS`, but no mapping.
    chosen
        Coordinates and speeds that the user calls dependent.

    Raises
    ------
    ParameterError
        If the model is none of these, or has no equations yet.
    """
    from sympy import Matrix, MatrixBase
    from sympy.physics import mechanics

    if isinstance(model, mechanics.System):
        method = model.eom_method
        if method is None:
            raise ParameterError(
                "the mechanics.System has no equations yet; call its form_eoms() first."
            )
        own = (*model.q_dep, *model.u_dep)
        return implicit(method, (*chosen, *(d for d in own if d not in chosen)))
    if isinstance(model, mechanics.KanesMethod):
        return _kane(model)
    if isinstance(model, mechanics.LagrangesMethod):
        return _lagrange(model, chosen)
    if isinstance(model, tuple) and len(model) == 4:
        try:
            mass, forcing = Matrix(model[0]), Matrix(model[1])
            q, u = (tuple(s if isinstance(s, MatrixBase) else list(s)) for s in model[2:])
        except (TypeError, ValueError, NotImplementedError):
            raise ParameterError(f"model is {shown(model)}; give {FORMS}.") from None
        return _matrices(mass, forcing, q, u)
    raise ParameterError(f"model is {shown(model)}; give {FORMS}.")


def _kane(model: Any) -> Implicit:
    try:
        matrix, forcing = model.mass_matrix_full, model.forcing_full
    except ValueError:
        raise ParameterError(
            "the KanesMethod has no equations yet; call its kanes_equations(bodies, loads) first."
        ) from None
    q, u, aux = tuple(model.q), tuple(model.u), tuple(model._uaux)
    depends = len(model._udep)
    velocity = tuple(model._k_nh * model.u + model._f_nh) if depends else ()
    return Implicit(
        q,
        u,
        matrix,
        forcing,
        (len(q), len(u) - depends, depends),
        zero=(*aux, *(a.diff() for a in aux)),
        configuration=tuple(model._f_h),
        velocity=velocity,
        dependent=(*model._qdep, *model._udep),
    )


def _lagrange(model: Any, chosen: Sequence[Any]) -> Implicit:
    if model.eom is None:
        raise ParameterError(
            "the LagrangesMethod has no equations yet; call its form_lagranges_equations() first."
        )
    q, u = tuple(model.q), tuple(model.u)
    constraints = tuple(model.coneqs)
    speed = dict(zip(q, u, strict=True))
    named = dict.fromkeys((*chosen, *(speed[c] for c in chosen if c in speed)))
    if len([s for s in named if s in u]) != len(constraints):
        raise ParameterError(
            f"the model has {len(constraints)} constraint{'s' * (len(constraints) != 1)}; name as "
            "many dependent coordinates (or rates) in dependent, such as dependent=[q1]."
        )
    return Implicit(
        q,
        u,
        model.mass_matrix_full,
        model.forcing_full,
        (len(q), len(q), len(constraints)),
        configuration=tuple(model._hol_coneqs),
        velocity=constraints,
        dependent=tuple(s for s in named if s in (*q, *u)),
        multipliers=len(constraints),
    )


def _matrices(mass: Any, forcing: Any, q: tuple[Any, ...], u: tuple[Any, ...]) -> Implicit:
    from sympy import diag, eye

    n, m = len(q), len(u)
    size = mass.rows
    fits = mass.rows == mass.cols == forcing.rows and forcing.cols == 1
    if fits and size == n + m:
        return Implicit(q, u, mass, forcing, (n, m, 0))
    if fits and size == m == n:
        return Implicit(q, u, diag(eye(n), mass), type(forcing)([*u, *forcing]), (n, m, 0))
    raise ParameterError(
        f"the mass matrix is {mass.rows} x {mass.cols} and the forcing {forcing.rows} x "
        f"{forcing.cols} for {n} coordinates and {m} speeds; give {n + m} rows, or {m} where each "
        "speed is the rate of its coordinate."
    )
