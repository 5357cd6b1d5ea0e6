"""`mechanics`: a mechanical system from its energies, forces and constraints."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import casadi as ca

from ..base.checks import known
from ..base.errors import ParameterError, shown
from .condition import Condition
from .equations import eliminate
from .sources.mechanical_model import Model, read_model, within
from .sources.multipliers import balance, choice, dependent, guarded, invariant, unknowns
from .system import System
from .system_checks import expression, mapping, names


def mechanics(
    q: ca.SX,
    u: ca.SX,
    p: ca.SX | None = None,
    *,
    kinetic: Any,
    potential: Any = 0.0,
    forces: Any = None,
    velocity_constraints: Any = (),
    holonomic: Any = (),
    q_dot: Any = None,
    independent: Sequence[str] | None = None,
    pivots: Mapping[str, str] | None = None,
    ignorable: Sequence[str] = (),
    observables: Mapping[str, Any] | None = None,
    conditions: Sequence[Condition] = (),
    units: Mapping[str, str] | None = None,
    name: str = "mechanical system",
) -> System:
    """A system from its kinetic and potential energy, forces and constraints.

    States are the coordinates and the velocities, with the names of their symbols.

    *Families of constrained systems.*  Without `independent` every velocity is a state, and each
    constraint adds one eigenvalue 0, a holonomic one two: motions that break the constraint are
    motions of the graph too.  A family then holds the dependent velocities and coordinates at
    values that keep the constraints.  With `independent` the constraints on velocities are solved,
    and these zeros are gone; a constraint that can be integrated, such as a holonomic one, leaves
    one zero, since its value is constant.  A coordinate that no equation contains, such as a place
    on a level plane, is never steady: name it in `ignorable`.

    Numbers within expressions are combined in double precision when CasADi builds the graph.
    Dimensions given as parameters `p` stay exact, and with them zeros by structure.

    Parameters
    ----------
    q
        Coordinates: a column of SX symbols, shape (k, 1).
    u
        Velocities: a column of SX symbols, shape (n, 1).  They are the rates of q, or
        quasi-velocities with `q_dot`.
    p
        Parameters: a column of SX symbols, or None.
    kinetic
        Kinetic energy in q, u, p, without any constraint inserted.
    potential
        Potential energy in q, p.
    forces
        Generalised forces on the velocities in q, u, p: a column, shape (n, 1), or expressions by
        the velocities' names.  Their power is forces · u.
    velocity_constraints
        Expressions in q, u, p that vanish, linear in u: a column, a list, or by name.  Without
        names they are numbered from 1, holonomic ones after those on velocities.
    holonomic
        Expressions in q, p that vanish: as above.
    q_dot
        Rates of the coordinates, N(q, p) u, shape (k, 1); q̇ = u when left out.
    independent
        Names of the velocities that stay as states, as many as velocities less constraints; the
        others are solved from the constraints, and become observables.
    pivots
        For each constraint, by name, the velocity for which it is solved, in the order of
        elimination.  When left out: with `independent`, constant pivots first; otherwise the mass
        matrix is eliminated in natural order, then the multipliers.  These pivots are positive
        wherever the mass matrix is positive definite and the constraints are independent.
    ignorable
        Names of coordinates that no equation contains: the state goes without them.  This is proved
        to 200 bits at three points, not taken from the user.  Observables of the list below that
        contain one are left out.
    observables
        More observables: expressions in q, u, p by name.
    conditions
        More quantities that must be positive.
    units
        SI unit by the name of state, parameter or observable.
    name
        Name of the system in messages and files.

    Returns
    -------
    System
        With the observables `energy` (kinetic + potential; Jacobi's energy where the kinetic energy
        is not quadratic in u), `power` (energy that forces and moving constraints take in a unit of
        time), and, for each constraint c, `multiplier_c` (the force of the constraint is its
        gradient in u times this), `residual_c` and, for a holonomic one, `residual_rate_c`;
        `pivot_c` and `pivot_u` for pivots that are not constant (squared where a constraint is
        solved for a velocity); with `independent` each dependent velocity v and its rate `d_v`.
        Each `pivot` is a condition, so that a pivot that vanishes is refused.

    Raises
    ------
    ParameterError, NameUnknownError
        If an expression has another symbol, a constraint is not linear in u, the mass matrix is
        singular at every state, shapes or names do not fit, or a coordinate is not ignorable.

    Source: Lagrange's equations with multipliers, and their form in quasi-velocities (Boltzmann and
    Hamel); J. Neimark & N. Fufaev, Dynamics of Nonholonomic Systems (1972), ch. III.

    Examples
    --------
    >>> import casadi as ca
    >>> import stability as st
    >>> q, u, p = ca.SX.sym("angle"), ca.SX.sym("rate"), ca.SX.sym("g")
    >>> pendulum = st.mechanics(q, u, p, kinetic=u**2 / 2, potential=-p * ca.cos(q))
    >>> pendulum.rates([0.5, 0.0], [9.81])
    array([ 0.        , -4.70316453])

    A sleigh: the blade does not move across; u are velocities in its frame.

    >>> q, u = ca.SX.sym("q", 3), ca.vertcat(*map(ca.SX.sym, ("v", "across", "w")))
    >>> c, s = ca.cos(q[2]), ca.sin(q[2])
    >>> sleigh = st.mechanics(
    ...     q, u, kinetic=(u[0] ** 2 + (u[1] + u[2]) ** 2 + u[2] ** 2) / 2,
    ...     q_dot=ca.vertcat(c * u[0] - s * u[1], s * u[0] + c * u[1], u[2]),
    ...     velocity_constraints={"blade": u[1]}, independent=("v", "w"),
    ...     ignorable=("q_0", "q_1", "q_2"))
    >>> sleigh.states, sleigh.rates([1.0, 2.0], [])  # v' = w², 2 w' = -v w
    (('v', 'w'), array([ 4., -1.]))
    """
    model = read_model(
        q,
        u,
        p,
        kinetic=kinetic,
        potential=potential,
        forces=forces,
        q_dot=q_dot,
        velocity_constraints=velocity_constraints,
        holonomic=holonomic,
    )
    solved = choice(model, independent, pivots)
    limits = _limits(model, conditions)
    graph = _graph(model, solved, _own(model, observables), limits)
    states = [*model.coordinates, *model.velocities]
    if independent is not None and solved:
        gone = [model.velocities[i] for i in solved.values()]
        states = [s for s in states if s not in gone]
        graph = _reduced(model, graph, solved, gone)
    left = names("ignorable", ignorable)
    for coordinate in left:
        known("ignorable", coordinate, model.coordinates)
    if left:
        states = [s for s in states if s not in left]
        graph = _without(model, graph.shared(), states, left, len(limits))
    graph = graph.shared()
    table = dict(
        zip((*model.coordinates, *model.velocities), ca.vertsplit(ca.vertcat(q, u)), strict=True)
    )
    gone_too = [s for s in table if s not in states and s not in graph.seen]
    given = {n: unit for n, unit in mapping("units", units or {}).items() if n not in gone_too}
    return System(
        name,
        ca.vertcat(*[table[s] for s in states]),
        model.p,
        ca.vertcat(*[graph.rates[s] for s in states]),
        tuple(states),
        model.parameters,
        graph.seen,
        graph.conditions,
        given,
        graph.mass,
        graph.forcing,
        unknowns(model),
    )


@dataclass(frozen=True, eq=False)
class _Graph:
    """The expressions of a system, while its states are chosen."""

    mass: ca.SX
    forcing: ca.SX
    rates: dict[str, ca.SX]
    seen: dict[str, ca.SX]
    conditions: tuple[Condition, ...]

    def replaced(self, symbols: ca.SX, values: ca.SX) -> _Graph:
        """The same with values in place of symbols."""
        return self._renewed(ca.substitute(self._entries(), [symbols], [values]))

    def shared(self) -> _Graph:
        """The same with each expression that occurs twice computed once."""
        return self._renewed(ca.cse(self._entries()))

    def _entries(self) -> list[ca.SX]:
        limits = [c.value for c in self.conditions]
        return [self.mass, self.forcing, *self.rates.values(), *self.seen.values(), *limits]

    def _renewed(self, found: list[ca.SX]) -> _Graph:
        rates = dict(zip(self.rates, found[2:], strict=False))
        seen = dict(zip(self.seen, found[2 + len(rates) :], strict=False))
        rest = found[2 + len(rates) + len(seen) :]
        conditions = [replace(c, value=v) for c, v in zip(self.conditions, rest, strict=True)]
        return _Graph(found[0], found[1], rates, seen, tuple(conditions))


def _own(model: Model, observables: Any) -> dict[str, ca.SX]:
    """The user's observables, checked."""
    table = {} if observables is None else mapping("observables", observables)
    return {
        n: within(f"observable {n}", expression(f"observable {n}", e), model.symbols, "q, u or p")
        for n, e in table.items()
    }


def _limits(model: Model, conditions: Any) -> list[Condition]:
    """The user's conditions, checked."""
    if not isinstance(conditions, (tuple, list)) or not all(
        isinstance(c, Condition) for c in conditions
    ):
        raise ParameterError(f"conditions is {shown(conditions)}; give a tuple of Condition.")
    for condition in conditions:
        within("a condition", condition.value, model.symbols, "q, u or p")
    return list(conditions)


def _graph(
    model: Model, solved: Mapping[int, int], own: dict[str, ca.SX], limits: list[Condition]
) -> _Graph:
    """Rates, observables and conditions with every velocity as a state."""
    parts = balance(model, solved)
    solution, pivots = eliminate(parts.mass, parts.forcing, parts.order)
    rates = dict(zip(model.coordinates, ca.vertsplit(model.q_dot), strict=True))
    rates |= dict(zip(model.velocities, solution, strict=False))
    multipliers = solution[len(model.velocities) :]
    moving = ca.substitute(model.rates, model.u, ca.SX.zeros(*model.u.shape))
    lost = parts.power + sum(m * b for m, b in zip(multipliers, ca.vertsplit(moving), strict=True))
    seen = {"energy": parts.energy, "power": ca.SX(lost)}
    for i, (label, multiplier) in enumerate(zip(model.constraints, multipliers, strict=True)):
        seen[f"multiplier_{label}"] = multiplier
        seen[f"residual_{label}"] = model.positions.get(label, model.rates[i])
        if label in model.positions:
            seen[f"residual_rate_{label}"] = model.rates[i]
    pivotal, guards = guarded(model, solved, pivots)
    names("observables", [*seen, *pivotal, *own])
    return _Graph(parts.mass, parts.forcing, rates, seen | pivotal | own, tuple([*guards, *limits]))


def _reduced(model: Model, graph: _Graph, solved: Mapping[int, int], gone: list[str]) -> _Graph:
    """The same in independent velocities; the others become observables."""
    symbols, values = dependent(model, solved)
    extra = {s: symbols[i] for i, s in enumerate(gone)}
    extra |= {f"d_{s}": graph.rates[s] for s in gone}
    names("observables", [*graph.seen, *extra])
    return replace(graph, seen=graph.seen | extra).replaced(symbols, values)


def _without(
    model: Model, graph: _Graph, states: list[str], left: tuple[str, ...], limits: int
) -> _Graph:
    """The same without coordinates that no equation contains, or a refusal.

    The last `limits` conditions are the user's.  A pivot may change with these coordinates where
    the rates do not: the elimination is then that at zero.
    """
    vital = {f"rate of {s}": graph.rates[s] for s in states}
    own = graph.conditions[len(graph.conditions) - limits :]
    vital |= {f"condition {i + 1}": c.value for i, c in enumerate(own)}
    same = invariant(model, vital | graph.seen, left)
    for what in vital:
        if not same[what]:
            raise ParameterError(
                f"the {what} changes with {', '.join(left)}, so not all of these are ignorable; "
                "leave out what the equations contain."
            )
    seen = {n: e for n, e in graph.seen.items() if same[n] or n.startswith("pivot_")}
    places = model.q[[model.coordinates.index(n) for n in left]]
    kept = replace(graph, seen=seen, rates={s: graph.rates[s] for s in states})
    return kept.replaced(places, ca.SX.zeros(*places.shape))
