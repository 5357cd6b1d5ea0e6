"""A mechanical model as a user gives it: energies, forces, constraints, all checked."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import casadi as ca

from ...base.checks import known
from ...base.errors import ParameterError, shown
from ..system_checks import expression, mapping, names
from .identities import singular, vanishing


@dataclass(frozen=True, eq=False)
class Model:
    """Energies, forces and constraints of a mechanical system, with the names of its symbols."""

    q: ca.SX
    """Coordinates, shape (k, 1)."""
    u: ca.SX
    """Velocities, shape (n, 1)."""
    p: ca.SX
    """Parameters, shape (m, 1)."""
    coordinates: tuple[str, ...]
    """Names of the coordinates."""
    velocities: tuple[str, ...]
    """Names of the velocities."""
    parameters: tuple[str, ...]
    """Names of the parameters."""
    kinetic: ca.SX
    """Kinetic energy."""
    potential: ca.SX
    """Potential energy."""
    forces: ca.SX
    """Generalised forces on the velocities, shape (n, 1)."""
    q_dot: ca.SX
    """Rates of the coordinates, linear in the velocities, shape (k, 1)."""
    constraints: tuple[str, ...]
    """Names of the constraints, those on velocities first."""
    rates: ca.SX
    """What vanishes at the level of velocities, one entry for each constraint, shape (c, 1)."""
    positions: Mapping[str, ca.SX]
    """Holonomic constraints by name: what vanishes at the level of coordinates."""

    @property
    def symbols(self) -> ca.SX:
        """Every symbol, in a column."""
        return ca.vertcat(self.q, self.u, self.p)


def symbols_of(what: str, value: Any, given: Any = None) -> tuple[ca.SX, tuple[str, ...]]:
    """A column of symbols and their names, or a refusal.

    Parameters
    ----------
    what
        Name of the argument in the message.
    value
        SX symbols, or None for none.
    given
        Names, or None for those of the symbols.

    Returns
    -------
    symbols, names
    """
    column = ca.SX(0, 1) if value is None else value
    if not isinstance(column, ca.SX) or not (
        column.numel() == 0
        or (column.is_valid_input() and column.is_dense() and column.is_column())
    ):
        raise ParameterError(
            f"{what} is {shown(value)}; give one column of symbols, as SX.sym does."
        )
    found = [s.name() for s in ca.vertsplit(column)] if column.numel() else []
    own = names(f"the names of {what}", found if given is None else given)
    if len(own) != column.numel():
        raise ParameterError(
            f"{what} has {column.numel()} entries but {len(own)} names; give each entry one name."
        )
    return column, own


def read_model(
    q: Any,
    u: Any,
    p: Any,
    *,
    kinetic: Any,
    potential: Any,
    forces: Any,
    q_dot: Any,
    velocity_constraints: Any,
    holonomic: Any,
) -> Model:
    """The model, or a refusal that says what does not fit.

    Parameters
    ----------
    q, u, p, kinetic, potential, forces, q_dot, velocity_constraints, holonomic
        As in `stability.systems.mechanics.mechanics`.

    Returns
    -------
    Model
    """
    (q, at), (u, speeds), (p, given) = (symbols_of(w, v) for w, v in (("q", q), ("u", u), ("p", p)))
    if not (q.numel() and u.numel()):
        raise ParameterError("q or u is empty; give at least one coordinate and one velocity.")
    names("q, u and p", [*at, *speeds, *given])
    place, everything = ca.vertcat(q, p), ca.vertcat(q, u, p)
    on_rates = _by_name("velocity_constraints", velocity_constraints, 1)
    on_places = _by_name("holonomic", holonomic, 1 + len(on_rates))
    labels = names("velocity_constraints and holonomic", [*on_rates, *on_places])
    for name, one in on_rates.items():
        within(f"velocity constraint {name}", one, everything, "q, u or p")
    for name, one in on_places.items():
        within(f"holonomic constraint {name}", one, place, "q or p")
    rates = _kinematics(q, u, q_dot, everything)
    moving = [*on_rates.values(), *(ca.jtimes(e, q, rates) for e in on_places.values())]
    column = ca.vertcat(*moving) if moving else ca.SX(0, 1)
    slopes = ca.jacobian(column, u)
    for i, name in enumerate(labels):
        if ca.depends_on(slopes[i, :], u):
            raise ParameterError(
                f"velocity constraint {name} is not linear in u; give an expression that is zero "
                "and linear in the velocities."
            )
    energy = within("kinetic", expression("kinetic", kinetic, 1, 1), everything, "q, u or p")
    height = within("potential", expression("potential", potential, 1, 1), place, "q or p")
    force = within("forces", _forces(forces, speeds), everything, "q, u or p")
    return Model(
        q, u, p, at, speeds, given, energy, height, force, rates, labels, column, on_places
    )


def within(what: str, value: ca.SX, symbols: ca.SX, where: str) -> ca.SX:
    """The expression, or a refusal if it has another symbol.

    Parameters
    ----------
    what
        Name of the expression in the message.
    value
        The expression.
    symbols
        Symbols that it may have.
    where
        Names of their arguments, for the message.

    Returns
    -------
    SX
    """
    free = [s for s in ca.symvar(value) if not ca.depends_on(symbols, s)]
    if free:
        raise ParameterError(
            f"{what} has the symbol {free[0]}, which is not in {where}; list it there."
        )
    return value


def _by_name(what: str, value: Any, first: int) -> dict[str, ca.SX]:
    """Expressions by name; a column or a list takes numbers as names."""
    if isinstance(value, Mapping):
        return {n: expression(f"{what} {n}", e, 1, 1) for n, e in mapping(what, value).items()}
    if isinstance(value, (list, tuple)):
        entries = [expression(f"an entry of {what}", e, 1, 1) for e in value]
    else:
        column = expression(what, value)
        if column.numel() and column.size2() != 1:
            raise ParameterError(f"{what} has {column.size2()} columns; give one column.")
        entries = ca.vertsplit(column) if column.numel() else []
    return {str(first + i): e for i, e in enumerate(entries)}


def _forces(value: Any, speeds: Sequence[str]) -> ca.SX:
    """A column of generalised forces from a column, or from a mapping by the velocities' names."""
    if value is None:
        return ca.SX.zeros(len(speeds), 1)
    if not isinstance(value, Mapping):
        return expression("forces", value, len(speeds), 1)
    table = mapping("forces", value)
    for name in table:
        known("forces", name, speeds)
    return ca.vertcat(*[expression(f"force on {s}", table.get(s, 0.0), 1, 1) for s in speeds])


def _kinematics(q: ca.SX, u: ca.SX, q_dot: Any, symbols: ca.SX) -> ca.SX:
    """The rates of the coordinates, or a refusal where they do not determine the velocities."""
    if q_dot is None:
        if q.numel() != u.numel():
            raise ParameterError(
                f"q has {q.numel()} entries and u has {u.numel()}; give as many, or q_dot with the "
                "rate of each coordinate."
            )
        return u
    rates = within("q_dot", expression("q_dot", q_dot, q.numel(), 1), symbols, "q, u or p")
    slopes = ca.jacobian(rates, u)
    if ca.depends_on(slopes, u) or not all(vanishing(rates - slopes @ u, symbols)):
        raise ParameterError("q_dot is not linear in u without a free term; give q_dot = N(q) u.")
    if singular(slopes.T @ slopes, symbols):
        raise ParameterError(
            "q_dot does not determine u: its slope in u has dependent columns at every state; give "
            "each velocity a coordinate that it moves."
        )
    if q.numel() > u.numel() and not _closes(slopes, rates, q, symbols):
        raise ParameterError(
            f"q has {q.numel()} entries, u has {u.numel()}, and q_dot is no motion on a surface of "
            "as many dimensions; give a velocity for each coordinate, and velocity_constraints."
        )
    return rates


def _closes(slopes: ca.SX, rates: ca.SX, q: ca.SX, symbols: ca.SX) -> bool:
    """Whether brackets of the columns stay within their span (Frobenius)."""
    bracket = brackets(slopes, rates, q)
    gram = slopes.T @ slopes
    rest = bracket - slopes @ ca.solve(gram, slopes.T @ bracket)
    return all(vanishing(ca.vec(rest), symbols))


def brackets(slopes: ca.SX, rates: ca.SX, q: ca.SX) -> ca.SX:
    """(∂q̇/∂q) N - Ṅ: brackets of the columns of N with q̇ = N u.

    Parameters
    ----------
    slopes, rates, q
        N, N u and the coordinates.

    Returns
    -------
    SX
        Shape (k, n).
    """
    turned = ca.jtimes(ca.vec(ca.densify(slopes)), q, rates)
    return ca.jacobian(rates, q) @ slopes - ca.reshape(turned, *slopes.shape)
