"""Ignorable states: coordinates such as a heading or a place, found in a system's graph.

State j acts on state i if the rate of i is not proved independent of j.  A proof is the absence of
j from the graph of the rate, or an identity: with two symbols in place of j the two rates are equal
as expressions.  A sample that shows no change is no proof.

A state is ignorable if its rate is not identically zero, and no path of such actions leads from it
to a cycle, to a condition, or to a state that is not ignorable.  So the rates of the other states
do not depend on ignorable states, and among ignorable states the linearisation is strictly
triangular: each gives an eigenvalue that is exactly zero, at every state.

States that other states turn, such as a quaternion or a row of a rotation matrix, act on each other
in a cycle and never rest in a spin.  They are ignorable too where nothing else depends on them and
the sum of their squares is constant by an identity.  A family that leaves them out is a family of
the other states: what is turned has no part in its linearisation.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import casadi as ca
import numpy as np
from flint import arb
from numpy.typing import NDArray

from ...algebra.exact.function_field import FunctionField
from ...algebra.exact.number_fields import EXACT, vanishes
from ...algebra.number_types import balls, precision
from ...algebra.program import Program
from ...base.errors import StabilityError
from ..equations import Equations

BITS = 200
"""Precision of the samples that show which independence an identity might prove."""
MOST_TRIED = 2000
"""Most identities that are tried for one system."""


@dataclass(frozen=True, eq=False)
class Influence:
    """Which state acts on which rate, and on which condition."""

    acts: NDArray[np.bool_]
    """Whether rate i may depend on state j, shape (n, n)."""
    guards: NDArray[np.bool_]
    """Whether a condition may depend on state j, shape (n,)."""
    still: NDArray[np.bool_]
    """Whether rate i is zero identically, shape (n,)."""
    hidden: tuple[tuple[int, int], ...]
    """Pairs (i, j) where the graph of rate i holds state j, but does not depend on it by proof."""


@lru_cache(maxsize=64)
def influence(system: Equations) -> Influence:
    """Which state acts on which rate; no action is left out without a proof."""
    conditions = ca.vertcat(*[c.value for c in system.conditions])
    inputs, outputs = [system.x, system.p], [ca.densify(system.rhs), ca.densify(ca.SX(conditions))]
    graph = ca.Function("rates", inputs, outputs)
    size = len(system.states)
    acts = np.zeros((size, size), dtype=bool)
    rows, columns = graph.jac_sparsity(0, 0).get_triplet()
    acts[rows, columns] = True
    guards = np.zeros(size, dtype=bool)
    if system.conditions:
        guards[graph.jac_sparsity(1, 0).get_triplet()[1]] = True
    still = np.array([bool(system.rhs[i].is_zero()) for i in range(size)])
    hidden = []
    for i, j in _suspects(system, acts):
        if _vanishes(system, i, j):
            hidden.append((i, j))
            acts[i, j] = False
    for i in map(int, np.flatnonzero(~still & ~acts.any(axis=1))):
        still[i] = _vanishes(system, i)
    return Influence(acts, guards, still, tuple(hidden))


def _suspects(system: Equations, acts: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Pairs (i, j) in the graph for which a change of state j alone shows no change of rate i."""
    size = len(system.states)
    try:
        program = Program(ca.Function("rates", [system.x, system.p], [ca.densify(system.rhs)]))
    except StabilityError:  # a branch or a comparison: what the graph holds counts as an action
        return []
    with precision(BITS):
        x = [(arb(3 + 2 * i).sqrt() / 5).mid() for i in range(size)]
        p = [(arb(2 + 3 * i).sqrt() / 2).mid() for i in range(len(system.parameters))]
        first = _values(program, x, p)
        out = []
        for j in np.flatnonzero(acts.any(axis=0)):
            moved = [v * 9 / 8 if i == j else v for i, v in enumerate(x)]
            second = _values(program, moved, p)
            suspects = map(int, np.flatnonzero(acts[:, j]))
            out += [(i, int(j)) for i in suspects if (first[i] - second[i]).contains(0)]
    return out[:MOST_TRIED]


def _values(program: Program, x: Sequence[Any], p: Sequence[Any]) -> list[Any]:
    try:
        values: list[Any] = [arb(v) for v in program.run(balls(), [list(x), list(p)])[0]]
    except ZeroDivisionError:
        return [arb("nan")] * len(x)
    return values


def _vanishes(system: Equations, i: int, j: int | None = None) -> bool:
    """Whether rate i is zero as an expression, or its change with another symbol for state j."""
    field = FunctionField([*system.states, *system.parameters, "other"])
    size = len(system.states)
    x, p, other = field.symbols[:size], field.symbols[size:-1], field.symbols[-1]
    rate = ca.densify(system.rhs[i])
    try:
        program = Program(ca.Function("rate", [system.x, system.p], [rate]))
        value = program.run(EXACT, [x, p])[0][0]
        if j is not None:
            value = value - program.run(EXACT, [[*x[:j], other, *x[j + 1 :]], p])[0][0]
        return vanishes(value)
    except (ArithmeticError, StabilityError):
        return False


def ignorable(system: Equations) -> tuple[str, ...]:
    """Ignorable states in an order in which each acts only on those before it, or on its group.

    Returns
    -------
    tuple of str
        The largest such set.
    """
    return _ordered(system)[0]


def turned(system: Equations) -> tuple[str, ...]:
    """Ignorable states that act on each other in a cycle."""
    return _ordered(system)[1]


@lru_cache(maxsize=64)
def _ordered(system: Equations) -> tuple[tuple[str, ...], tuple[str, ...]]:
    influences = influence(system)
    out = influences.guards | influences.still | np.isin(system.states, system.algebraic)
    order: list[int] = []
    groups: list[int] = []
    while True:  # next come the states that act on nothing but what is there already
        rest = np.ones(len(out), dtype=bool)
        rest[order] = False
        free = [int(i) for i in np.flatnonzero(rest & ~out & ~influences.acts[rest].any(axis=0))]
        if not free:
            free = _group(system, rest & ~out, rest)
            groups += free
        if not free:
            states, cycles = (tuple(system.states[i] for i in some) for some in (order, groups))
            return states, cycles
        order += free


def _group(system: Equations, able: NDArray[np.bool_], rest: NDArray[np.bool_]) -> list[int]:
    """States that the rest turns, and that act on nothing but each other; perhaps none."""
    from scipy.sparse.csgraph import connected_components

    acts = influence(system).acts
    places = np.flatnonzero(rest)
    _, labels = connected_components(acts[np.ix_(places, places)], connection="strong")
    for label in np.unique(labels):
        some = places[labels == label]
        others = np.setdiff1d(places, some)
        closed = able[some].all() and not acts[np.ix_(others, some)].any()
        if len(some) > 1 and closed and acts[np.ix_(some, others)].any() and _norm(system, some):
            return [int(i) for i in some]
    return []


def _norm(system: Equations, some: NDArray[np.intp]) -> bool:
    """Whether the sum of the squares of some states is constant by an identity."""
    field = FunctionField([*system.states, *system.parameters])
    size = len(system.states)
    x, p = field.symbols[:size], field.symbols[size:]
    rates = ca.densify(ca.vertcat(*[system.rhs[int(i)] for i in some]))
    try:
        program = Program(ca.Function("rates", [system.x, system.p], [rates]))
        values = [row[0] if isinstance(row, list) else row for row in program.run(EXACT, [x, p])[0]]
        return bool(vanishes(sum(x[int(i)] * v for i, v in zip(some, values, strict=True))))
    except (ArithmeticError, StabilityError):
        return False


def hidden_pairs(system: Equations, columns: Collection[str]) -> list[tuple[int, int]]:
    """Entries (i, j) of the linearisation that are zero by an identity, not by sparsity."""
    return [(i, j) for i, j in influence(system).hidden if system.states[j] in columns]


def acting_on(system: Equations, state: str, among: Collection[str]) -> str:
    """The first of some states whose rate depends on a state, or an empty string."""
    column = influence(system).acts[:, system.index(state)]
    return next((n for n, a in zip(system.states, column, strict=True) if a and n in among), "")
