"""A family of steady motions as isolated equilibria, for programs that continue those.

Along a family that is named by a state, the Jacobian A has a zero with the family's tangent t.  A
program that continues isolated equilibria wants none.  With c the value that names the member and a
the state, f(x) - t (a - c) has the same equilibrium, and there the Jacobian A - t e_a^T, whose
eigenvalues are those of A but for one: the zero of the tangent is -1 (Brauer 1952).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from ..base.checks import instance
from ..base.errors import NameUnknownError, ParameterError, shown
from ..base.types import Floats
from ..systems.family import Family
from ..systems.structure.structural_zeros import structure
from ..systems.system import A_FAMILY, refuse_system

STEPS = 50
"""Steps of the first run, about."""


@dataclass(frozen=True, eq=False)
class SteadyProblem:
    """Rates whose equilibria are the steady motions, one for each value of the parameters."""

    states: tuple[str, ...]
    """Names of the states."""
    parameters: tuple[str, ...]
    """Names of the parameters: what names a member, then the system's own."""
    function: ca.Function
    """(u, par) to the rates, their Jacobian by u, and by par, all dense."""
    start: Floats
    """State at the start."""
    values: Floats
    """Parameters at the start."""
    free: str
    """Parameter that is continued."""
    stop: float
    """Its last value."""

    @property
    def first(self) -> float:
        """The first value of the parameter that is continued."""
        return float(self.values[self.parameters.index(self.free)])

    @property
    def low(self) -> float:
        """Smaller end."""
        return min(self.first, self.stop)

    @property
    def high(self) -> float:
        """Larger end."""
        return max(self.first, self.stop)

    @property
    def steps(self) -> dict[str, float]:
        """First, shortest and longest step of the continuation; the first has its direction."""
        length = self.high - self.low
        first = math.copysign(length / (10 * STEPS), self.stop - self.first)
        return {"ds": first, "dsmin": length * 1e-9, "dsmax": length / STEPS}


def steady_problem(
    family: Family, free: str, start: float, stop: float, given: Mapping[str, Any]
) -> SteadyProblem:
    """The problem of a family, with its start.

    Parameters
    ----------
    family
        The family.
    free
        Name of the parameter that is continued.
    start, stop
        Its first and last value.
    given
        Values of all others by name.

    Returns
    -------
    SteadyProblem

    Raises
    ------
    ParameterError, NameUnknownError
        If names or numbers do not fit, or the equilibria are not isolated.

    Source: A. Brauer, Duke Math. J. 19 (1952) 75-91; tests/export/test_continuation.py.
    """
    refuse_system(family)
    instance("family", family, Family, A_FAMILY)
    names = (*family.at, *family.parameters)
    if free not in names:
        raise NameUnknownError(f"free is {shown(free)}; known are {', '.join(names)}.")
    if float(start) == float(stop) or not np.isfinite([start, stop]).all():
        raise ParameterError(f"start is {start:g} and stop is {stop:g}; give two finite numbers.")
    _check(names, free, given)
    _isolated(family)
    numbers = {n: float(given[n]) for n in names if n != free} | {free: float(start)}
    values = np.array([numbers[n] for n in names])
    whole = family.member(values[: len(family.at)], values[len(family.at) :])
    keep = [i for i, n in enumerate(family.system.states) if n not in family.left_out]
    return SteadyProblem(
        tuple(family.system.states[i] for i in keep),
        names,
        _function(family, keep),
        whole[keep],
        values,
        free,
        float(stop),
    )


def _check(names: tuple[str, ...], free: str, given: Mapping[str, Any]) -> None:
    for name in given:
        if name not in names or name == free:
            left = ", ".join(n for n in names if n != free)
            raise NameUnknownError(f"{name} is no parameter to give; these are {left}.")
    missing = [n for n in names if n != free and n not in given]
    if missing:
        raise ParameterError(f"{missing[0]} has no value; give {', '.join(missing)}.")
    for name, value in given.items():
        if not isinstance(value, (int, float, np.number)) or not np.isfinite(value):
            raise ParameterError(f"{name} is {shown(value)}; give one finite number.")


def _isolated(family: Family) -> None:
    """Refuse zeros of the Jacobian that are no tangents of the family."""
    zeros = structure(family).zeros - len(family.left_out) - family.tangents
    if zeros > 0:
        raise ParameterError(
            f"{family.name} has {zeros} more eigenvalue{'s' * (zeros > 1)} 0 by structure than "
            "its own tangents; continuation needs isolated steady motions. Take "
            "st.boundaries, which leaves these zeros out."
        )


def _function(family: Family, keep: list[int]) -> ca.Function:
    system = family.system
    names = (*family.at, *family.parameters)
    u, par = ca.SX.sym("u", len(keep)), ca.SX.sym("par", len(names))
    table: dict[str, Any] = dict(zip(names, ca.vertsplit(par), strict=True))
    state: Any = ca.SX.zeros(len(system.states))  # ignorable states act on nothing
    state[keep] = u
    own = ca.vertcat(*[table.get(n, 0) for n in system.parameters])
    rates, seen = ca.substitute(
        [system.rhs, ca.vertcat(*[system.observables[n] for n in _seen(family)])],
        [system.x, system.p],
        [state, own],
    )
    rows = [
        *(rates[system.states.index(n)] for n in family.equations if n in system.states),
        *ca.vertsplit(seen),
    ]
    f = rates[keep]
    position = {system.states[i]: row for row, i in enumerate(keep)}
    for name in (n for n in family.at if n in system.states):
        tangent = _tangent(family, ca.vertcat(*rows), u, position, name)
        f = f - tangent * (u[position[name]] - table[name])
    parts = [ca.densify(e) for e in (f, ca.jacobian(f, u), ca.jacobian(f, par))]
    return ca.Function("steady", [u, par], ca.cse(parts), ["u", "par"], ["f", "dfdu", "dfdp"])


def _seen(family: Family) -> list[str]:
    return [n for n in family.equations if n not in family.system.states]


def _tangent(
    family: Family, rows: ca.SX, u: ca.SX, position: Mapping[str, int], name: str
) -> ca.SX:
    """Direction of the family in the state, with 1 for the state that names the member."""
    tangent = ca.SX.zeros(u.numel())
    tangent[position[name]] = 1
    unknown = [position[n] for n in family.unknown]
    if unknown:
        slopes = ca.jacobian(rows, u)
        solved = ca.solve(slopes[:, unknown], -slopes[:, position[name]])
        for row, value in zip(unknown, ca.vertsplit(solved), strict=True):
            tangent[row] = value
    return tangent
