"""Equations of motion with multipliers: pivots, independent velocities."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import casadi as ca

from ...base.checks import known
from ...base.errors import ParameterError, shown
from ..condition import Condition
from ..equations import eliminate
from ..system_checks import mapping, names
from .identities import pivots_of, singular, vanishing
from .mechanical_model import Model, brackets


@dataclass(frozen=True, eq=False)
class Balance:
    """mass · (accelerations, multipliers) = forcing, and the order of its elimination."""

    mass: ca.SX
    """[[M, -Aᵀ], [A, 0]]: rows of the velocities, then of the constraints."""
    forcing: ca.SX
    """Right-hand side."""
    energy: ca.SX
    """Kinetic plus potential energy (Jacobi's energy)."""
    power: ca.SX
    """Energy that the forces take in a unit of time."""
    order: tuple[tuple[int, int], ...]
    """Pivots (row, column)."""


def unknowns(model: Model) -> tuple[str, ...]:
    """Names of accelerations and multipliers.

    Parameters
    ----------
    model
        The model.
    """
    rates = [f"d_{s}" for s in model.velocities]
    return (*rates, *[f"multiplier_{c}" for c in model.constraints])


def balance(model: Model, solved: Mapping[int, int]) -> Balance:
    """The equations of motion of a model.

    Parameters
    ----------
    model
        Energies, forces, constraints.
    solved
        Velocity for which each constraint is solved, by index; empty for the natural order.

    Returns
    -------
    Balance

    Source: J. Neimark & N. Fufaev, Dynamics of Nonholonomic Systems (1972), ch. III;
    tests/systems/test_mechanics.py compares with SymPy and with closed forms.
    """
    q, u, rates = model.q, model.u, model.q_dot
    slopes = ca.jacobian(rates, u)
    momenta = ca.gradient(model.kinetic, u)
    across = ca.gradient(model.kinetic - model.potential, q)
    forcing = model.forces + slopes.T @ across - ca.jtimes(momenta, q, rates)
    turning = ca.sparsify(brackets(slopes, rates, q))
    if turning.nnz():  # N (NᵀN)⁻¹: the Gram matrix is positive wherever q̇ determines u
        gram = slopes.T @ slopes
        own, _ = eliminate(gram, momenta, [(i, i) for i in range(u.numel())])
        forcing -= turning.T @ (slopes @ ca.vertcat(*own))
    mass = ca.jacobian(momenta, u)
    held = ca.jacobian(model.rates, u)
    count = len(model.constraints)
    whole = ca.blockcat([[mass, -held.T], [held, ca.SX(count, count)]])
    _refuse_singular(model, mass, whole, solved)
    if solved:
        _refuse_pivots(model, solved, held[list(solved), list(solved.values())])
    right = ca.vertcat(forcing, -ca.jtimes(model.rates, q, rates))
    free = [i for i in range(u.numel()) if i not in solved.values()]
    natural = [(i, i) for i in range(u.numel() + count)]
    first = [(u.numel() + c, j) for c, j in solved.items()]
    order = [*first, *[(j, c) for c, j in first], *[(i, i) for i in free]] if solved else natural
    energy = ca.dot(momenta, u) - model.kinetic + model.potential
    power = -ca.dot(model.forces, u)
    return Balance(whole, right, energy, power, tuple(order))


def _refuse_singular(model: Model, mass: ca.SX, whole: ca.SX, solved: Any) -> None:
    if not solved and singular(mass, model.symbols):
        raise ParameterError(
            "kinetic gives a mass matrix that is singular at every state; give each velocity a "
            "mass, or name by pivots or independent the velocities that the constraints determine."
        )
    if singular(whole, model.symbols):
        raise ParameterError(
            "mass matrix and constraints together are singular at every state; leave out "
            "constraints that follow from others, and give each free velocity a mass."
        )


def choice(model: Model, independent: Any, pivots: Any) -> dict[int, int]:
    """The velocity for which each constraint is solved, in the order of elimination.

    Parameters
    ----------
    model
        The model.
    independent
        Names of the independent velocities, or None.
    pivots
        Names of velocities by the constraints' names, or None.

    Returns
    -------
    dict
        Index of the velocity by the constraint's index; empty for the natural order.
    """
    table = _stated(model, pivots)
    if independent is None:
        return table
    kept = names("independent", independent)
    for name in kept:
        known("independent", name, model.velocities)
    wanted = len(model.velocities) - len(model.constraints)
    if len(kept) != wanted:
        raise ParameterError(
            f"independent names {len(kept)} velocities; give {wanted}, the number of velocities "
            "less that of constraints."
        )
    rest = [i for i, s in enumerate(model.velocities) if s not in kept]
    if pivots is not None:
        if sorted(table.values()) != rest:
            raise ParameterError(
                f"pivots is {shown(pivots)}; give each velocity outside independent one constraint."
            )
        return table
    found = pivots_of(
        ca.jacobian(model.rates, model.u)[:, rest],
        model.symbols,
        len(model.coordinates) + len(model.velocities),
    )
    if found is None:
        raise ParameterError(
            "the constraints do not determine the velocities outside independent at any state; "
            "give another choice of independent."
        )
    return {row: rest[column] for row, column in found}


def _stated(model: Model, pivots: Any) -> dict[int, int]:
    if pivots is None:
        return {}
    table = mapping("pivots", pivots)
    if sorted(table) != sorted(model.constraints):
        raise ParameterError(
            f"pivots is {shown(pivots)}; name each constraint once: {', '.join(model.constraints)}."
        )
    speeds = [known(f"pivot of {c}", s, model.velocities) for c, s in table.items()]
    names("pivots", speeds)
    return {
        model.constraints.index(c): model.velocities.index(s)
        for c, s in zip(table, speeds, strict=True)
    }


def dependent(model: Model, solved: Mapping[int, int]) -> tuple[ca.SX, ca.SX]:
    """The dependent velocities, and what they are in terms of the independent ones.

    Parameters
    ----------
    model
        The model.
    solved
        Velocity for which each constraint is solved, by index.

    Returns
    -------
    symbols, expressions
        Columns.
    """
    places = list(solved.values())
    symbols = model.u[places]
    rows = model.rates[list(solved)]
    without = ca.substitute(rows, symbols, ca.SX.zeros(len(places), 1))
    order = [(i, i) for i in range(len(places))]
    found, _ = eliminate(ca.jacobian(rows, symbols), -without, order)
    return symbols, ca.vertcat(*found)


def _refuse_pivots(model: Model, solved: Mapping[int, int], slopes: ca.SX) -> None:
    """Refuse an order in which a pivot vanishes identically."""
    for size, (constraint, speed) in enumerate(solved.items(), 1):
        if singular(slopes[:size, :size], model.symbols):
            raise ParameterError(
                f"constraint {model.constraints[constraint]} cannot be solved for "
                f"{model.velocities[speed]} in the order of pivots: its pivot vanishes at every "
                "state; give another velocity or order."
            )


def guarded(
    model: Model, solved: Mapping[int, int], pivots: Sequence[ca.SX]
) -> tuple[dict[str, ca.SX], list[Condition]]:
    """The pivots that are not constant, as observables, and as conditions.

    Parameters
    ----------
    model
        The model.
    solved
        Velocity for which each constraint is solved, by index.
    pivots
        Pivot of each step of the elimination.

    Returns
    -------
    observables, conditions
        In natural order each pivot is positive where masses are and constraints are independent.
    """
    speeds, constraints = model.velocities, model.constraints
    count = len(constraints)
    if solved:
        free = [s for i, s in enumerate(speeds) if i not in solved.values()]
        ties = [constraints[c] for c in solved]
        held, masses = dict(zip(ties, pivots[:count], strict=True)), pivots[2 * count :]
    else:
        free, ties = list(speeds), list(constraints)
        held, masses = dict(zip(ties, pivots[len(speeds) :], strict=True)), pivots[: len(speeds)]
    word = "its pivot, squared," if solved else "its pivot"
    firm = [
        (n, v, f"the mass matrix is not positive: its pivot for {n}", False)
        for n, v in zip(free, masses, strict=True)
    ]
    tied = [
        (
            n,
            v,
            f"constraint {n} does not determine a force or velocity of its own: {word}",
            bool(solved),
        )
        for n, v in held.items()
    ]
    seen, conditions = {}, []
    entries = [*tied, *firm] if solved else [*firm, *tied]  # as eliminated: the cause comes first
    for name, value, reason, either in entries:
        value = value**2 if either else value
        if value.is_constant():
            if not float(value) > 0:
                raise ParameterError(f"{reason} is {float(value):.3g}; give a positive one.")
            continue
        seen[f"pivot_{name}"] = value
        sentence = reason.replace("{", "{{").replace("}", "}}") + " is {value:.3g}"
        conditions.append(Condition(value, sentence))
    return seen, conditions


def invariant(model: Model, outputs: Mapping[str, ca.SX], left: Sequence[str]) -> dict[str, bool]:
    """Whether each output is the same for every value of the coordinates that are left out.

    Parameters
    ----------
    model
        The model.
    outputs
        Expressions by name.
    left
        Names of the coordinates.

    Returns
    -------
    dict
        Whether each output is independent of all of them, by name.
    """
    places = model.q[[model.coordinates.index(n) for n in left]]
    along = ca.SX.sym("along", places.numel())  # any direction: each slope has its own factor
    slopes = ca.cse(ca.jtimes(ca.vertcat(*outputs.values()), places, along))
    return dict(zip(outputs, vanishing(slopes, ca.vertcat(model.symbols, along)), strict=True))
