"""What a user's system settles on: the families that were given.

Along a family with a state in `at`, settling is proved where no root-finder is needed and the rates
vanish by structure.  A member that stands alone needs neither (`stability.settling.box`).
For other families only distances are given, and no state counts as settled.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache, partial
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from ..base.errors import ParameterError, StabilityError
from ..base.types import Floats
from ..systems.family import Family
from ..systems.sources.numeric import NumericSystem
from .line import FamilyLine
from .settling import Settling

KEPT = 4
"""Sets of members of a family that are kept."""
Members = tuple[Floats, NDArray[np.bool_]]


def system_settling(families: tuple[Family, ...]) -> Settling:
    """The families that a user's system may settle on.

    Parameters
    ----------
    families
        Families of one system.

    Returns
    -------
    Settling
    """
    names = ", ".join(family.name for family in families)
    none = f"none of {names} has a member there"
    if not families:
        none = "it lasted to the last time; give families=... to see what it settles on"
    return Settling(tuple(map(_line, families)), none)


@lru_cache(maxsize=32)
def _line(family: Family) -> FamilyLine:
    system = family.system
    if family.trimmed:
        raise ParameterError(
            f"{family.name} is solved for {', '.join(family.trimmed)}, and a launch gives it a "
            "value; give families that are named by states or parameters alone."
        )
    along = tuple(n for n in system.states if n in family.at)
    u = ca.SX.sym("u", len(family.unknown))
    member: dict[str, Any] = dict(family.held) | dict.fromkeys(family.left_out)
    member |= dict(zip(family.unknown, ca.vertsplit(u) if family.unknown else [], strict=True))
    reason = ""
    if along and family.unknown and not family.closed:
        reason = (
            "its members are found by a root-finder along "
            f"{', '.join(along)}, and convergence to those is not proved"
        )
    if isinstance(system, NumericSystem):
        reason = "by floats convergence to it is not proved"
    return FamilyLine(
        family.name,
        system,  # type: ignore[arg-type]  # motions are of systems with a graph
        system.states,
        along,
        member,
        ca.SX.sym("y", len(along)),
        ca.vertcat(u, ca.SX.sym("p", len(system.parameters))),
        partial(_numbers, family, lru_cache(maxsize=KEPT)(partial(_members, family))),
        [c.value for c in system.conditions],
        steady=False,
        reason=reason,
        family=family,
        spelled=True,
    )


def _numbers(
    family: Family, members: Callable[..., Members], states: Floats, p: Floats
) -> tuple[Floats, NDArray[np.bool_]]:
    """The unknowns at members with the `at` of states, then the parameters; and which exist."""
    values = dict(zip(family.system.states, states.T, strict=True))
    values |= dict(zip(family.system.parameters, p.T, strict=True))
    a, q = (
        np.column_stack([values[n] for n in names]) if names else np.zeros((len(states), 0))
        for names in (family.at, family.parameters)
    )
    u, good = members(len(states), a.tobytes(), q.tobytes())
    return np.hstack([u, p]), good


def _members(family: Family, count: int, *numbers: bytes) -> Members:
    """The unknowns at members with values of `at` and parameters, and which exist.

    A launch begins and ends with the same values where no state is among them.
    """
    a, q = (
        np.frombuffer(values).reshape(count, len(names))
        for values, names in zip(numbers, (family.at, family.parameters), strict=True)
    )
    members = family.members(a, q)
    good = members.good.copy()
    good[good] = steady(family, a[good], members.u[good], q[good])
    return members.u, good


def steady(family: Family, a: Floats, u: Floats, q: Floats) -> NDArray[np.bool_]:
    """Whether a family has members at rows of numbers: its rates vanish there.

    Parameters
    ----------
    family, a, u, q
        As for `Family.checked_states`.
    """
    try:
        if len(a):
            family.checked_states(a, u, q)
    except StabilityError:
        if len(a) == 1:
            return np.array([False])
        half = len(a) // 2
        parts = (slice(half), slice(half, None))
        return np.concatenate([steady(family, a[i], u[i], q[i]) for i in parts])
    return np.ones(len(a), dtype=bool)
