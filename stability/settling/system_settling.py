"""Settling of a user's system on the families that were given: members, distances, surroundings.

Along a family with a state in `at`, settling is proved where no root-finder is needed and the rates
vanish by structure.  A member that stands alone needs neither (`stability.settling.attraction`).
For other families only distances are given, and no state counts as settled.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import casadi as ca
import numpy as np

from ..algebra.kernels.double_balls import add
from ..algebra.program import Program
from ..algebra.upright import Upright
from ..base.errors import StabilityError, listing
from ..base.quantities import rate_unit
from ..base.types import Floats
from ..systems.family import Family
from ..systems.graph.constants import Constants
from .attraction import Surroundings, Tilted, smooth_field
from .nearest import Nearest
from .proof import settles
from .together.kernel import Balls
from .together.many import RIGHT_ANGLE, NearestMany, nearest_many


@dataclass(frozen=True)
class SystemSettling:
    """Settling of a user's system."""

    families: tuple[Family, ...]
    """The families that the system may settle on."""

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the families."""
        return tuple(family.name for family in self.families)

    def at_of(self, family: Family, state: Floats, p: Floats) -> Floats:
        """The numbers that name the nearest member of a family, shape (at,)."""
        found: Floats = at_of(family, state[None], p)[0]
        return found

    def deviation(self, family: Family, state: Floats, p: Floats) -> Floats | None:
        """State less the member of a family with its `at`; None where there is no member."""
        there = members(family, state[None], p)
        if there is None or not np.isfinite(there).all():
            return None
        found: Floats = state - there[0]
        return found

    def closest(self, state: Floats, p: Floats) -> Nearest:
        """The nearest member of all families, with its states; settling is not tested."""
        return self._closest(state, p)[0]

    def _closest(self, state: Floats, p: Floats) -> tuple[Nearest, Family | None, str]:
        """The nearest member, its family, and its name in words."""
        if not self.families:
            why = "it lasted to the last time; give families=... to see what it settles on"
            return Nearest("", 0.0, np.inf, False, 0.0, why), None, ""
        found = [(members(f, state[None], p), f) for f in self.families]
        far = [np.inf if m is None else float(length(state - m[0])) for m, _ in found]
        best = int(np.argmin(far))
        (states, family), distance = found[best], far[best]
        if states is None:
            names = ", ".join(f.name for f in self.families)
            why = f"none of {names} has a member there"
            return Nearest("", 0.0, np.inf, False, 0.0, why), None, ""
        called = member_in_words(family, at_of(family, state[None], p)[0])
        where = f"nearest is {called}, {distance:.3g} away"
        return Nearest(family.name, 0.0, distance, False, 0.0, where, states[0]), family, called

    def nearest(self, state: Floats, p: Floats, within: float) -> Nearest:
        """The nearest member of all families, and whether the state has settled on it."""
        near, family, called = self._closest(state, p)
        if family is None or near.member is None or near.distance > within:
            return near
        member, distance = near.member, near.distance
        why, proof = _proved(family, state, member, p)
        if proof is None:
            where = f"{distance:.3g} from {called}; {why}"
            return Nearest(family.name, 0.0, distance, False, 0.0, where, member)
        along = [n for n in family.system.states if n in family.at]  # as y is ordered
        limit = ""
        if along:  # the limit is one of many members, known within an error
            limit = f" at {in_words(family, along, proof.limit)} within {proof.error:.2g}"
        unit = rate_unit(family.system.units, family.system.quantities)
        where = (
            f"{distance:.3g} from {called}; proved in ball arithmetic: from there on "
            f"the motion converges to {family.name}{limit}, its deviation falling at the rate "
            f"{proof.rate:.3g}{'' if unit == '1' else f' {unit}'} at least"
        )
        where = family.system.qualified(where)
        return Nearest(family.name, 0.0, distance, True, proof.reach, where, member)

    def many(
        self, states: Floats, p: Floats, within: float | Floats, *, plain: bool = False
    ) -> NearestMany:
        """The nearest family of many states, and which have settled, as `nearest_many`."""
        places = [_Place(family) for family in self.families]
        return nearest_many(places, states, p, within, plain=plain)

    def distances(self, states: Floats, p: Floats, near: Nearest) -> Floats:
        """Distances of states, shape (t, n), from the family of a nearest member, shape (t,)."""
        family = next(f for f in self.families if f.name == near.family)
        found = np.full(len(states), np.inf)
        known = members(family, states, p)
        if known is not None:
            found = length(states - known)
        else:  # some have no member
            for i, state in enumerate(states):
                one = members(family, state[None], p)
                found[i] = np.inf if one is None else length(state - one[0])
        return found


@dataclass(frozen=True)
class _Place:
    """A family, for many states."""

    family: Family

    @property
    def name(self) -> str:
        """Name of the family."""
        return self.family.name

    @property
    def attracting(self) -> Surroundings | None:
        """Surroundings of the family; None where nothing is proved about it."""
        found = surroundings(self.family)
        return None if isinstance(found, str) else found

    def place(self, states: Floats, p: Floats, *, plain: bool) -> tuple[Balls, Balls, Floats]:  # noqa: ARG002
        """As `Place.place`."""
        family, names = self.family, self.family.system.states
        known = dict(zip(names, states.T, strict=True))
        known |= dict(zip(family.system.parameters, p.T, strict=True))
        count = len(states)
        a = _columns([known[n] for n in family.at], count)
        q = _columns([known[n] for n in family.parameters], count)
        found = family.members(a, q)
        u = np.where(found.good[:, None], found.u, np.nan)
        there = dict(zip(family.unknown, u.T, strict=True))
        y = _columns([known[n] for n in names if n in family.at], count)
        mid = np.zeros((count, len(names) - y.shape[1]))
        rad = np.zeros_like(mid)
        for i, name in enumerate(n for n in names if n not in family.at):
            value: Any = there.get(name, family.fixed.get(name))
            m, r = RIGHT_ANGLE if isinstance(value, Upright) else (np.asarray(value), 0.0)
            mid[:, i], rad[:, i] = add(known[name], 0.0, -m, r)
        mid[~found.good] = np.nan
        return Balls(y, np.zeros_like(y)), Balls(mid, rad), np.hstack([p, u])


def _columns(rows: list[Floats], count: int) -> Floats:
    return np.column_stack(rows) if rows else np.zeros((count, 0))


def length(vectors: Floats) -> Floats:
    """Euclidean length along the last axis, which no square on the way can make overflow.

    Parameters
    ----------
    vectors
        Shape (…, n).

    Examples
    --------
    >>> round(float(length(np.array([3e200, 4e200]))) / 1e200, 12)
    5.0
    """
    found: Floats = np.hypot.reduce(vectors, axis=-1)
    return found


def in_words(family: Family, names: Sequence[str], values: Iterable[float]) -> str:
    """Names with values and units, for a sentence.

    Parameters
    ----------
    family
        The family.
    names, values
        Names of states or parameters, and their values.
    """
    units = (family.system.units.get(n, "1") for n in names)
    parts = zip(names, values, units, strict=True)
    return ", ".join(listing((n,), (v,)) + ("" if u == "1" else f" {u}") for n, v, u in parts)


def member_in_words(family: Family, at: Iterable[float]) -> str:
    """A family with the values that name its member; its name alone where it has one member."""
    return f"{family.name} at {in_words(family, family.at, at)}" if family.at else family.name


def at_of(family: Family, states: Floats, p: Floats) -> Floats:
    """Family parameters `at` from the values of states and parameters, shape (t, at).

    Parameters
    ----------
    family
        The family.
    states, p
        States, shape (t, n), and the system's parameters, shape (m,).
    """
    system, count = family.system, len(states)
    columns = [
        states[:, system.states.index(n)] if n in system.states
        else np.full(count, p[system.parameters.index(n)])
        for n in family.at
    ]  # fmt: skip
    return np.column_stack(columns) if columns else np.zeros((count, 0))


def members(family: Family, states: Floats, p: Floats) -> Floats | None:
    """The members of a family that have the same `at` as given states.

    Parameters
    ----------
    family
        Family of the system.
    states, p
        States, shape (t, n), and the system's parameters, shape (m,).

    Returns
    -------
    ndarray or None
        States of the members, shape (t, n); None where a member does not exist.
    """
    values = [p[family.system.parameters.index(n)] for n in family.parameters]
    a, q = at_of(family, states, p), np.tile(np.array(values, dtype=float), (len(states), 1))
    try:
        found = family.checked_states(a, family.solve(a, q), q)
    except StabilityError:
        return None
    moving = [family.system.index(n) for n in family.left_out]
    found[:, moving] = states[:, moving]  # a state left out has any value
    return found


def _proved(family: Family, state: Floats, member: Floats, p: Floats) -> tuple[str, Any]:
    """Reason why convergence is not proved, and the proof or None."""
    from flint import arb

    around = surroundings(family)
    if isinstance(around, str):
        return around, None
    system = family.system
    known = dict(zip(system.states, (arb(v) for v in state.tolist()), strict=True))
    y = [known[n] for n in system.states if n in family.at]
    fixed = dict(zip(system.states, member.tolist(), strict=True)) | family.fixed
    e = [
        known[n] - (arb.pi() / 2 if isinstance(v, Upright) else arb(float(v)))
        for n, v in ((n, fixed[n]) for n in system.states if n not in family.at)
    ]
    given = [*p.tolist(), *(float(fixed[n]) for n in family.unknown)]
    proof = settles(around, given, y, e)
    return "convergence to it is not proved from there", proof


@lru_cache(maxsize=32)
def surroundings(family: Family) -> Surroundings | str:
    """Surroundings of a family, or the reason why nothing is proved about it.

    Parameters
    ----------
    family
        Any family.

    Returns
    -------
    Surroundings or str
        The reason is a sentence without its full stop.
    """
    system = family.system
    along = [n for n in system.states if n in family.at]
    across = [n for n in system.states if n not in family.at]
    if not across:
        return "every state names a member, so that there is nothing to converge"
    if along and family.unknown and not family.closed:
        return (
            "its members are found by a root-finder along "
            f"{', '.join(along)}, and convergence to those is not proved"
        )
    try:
        return _surroundings(family, along, across)
    except StabilityError as error:
        return f"convergence to it is not proved: {str(error).rstrip('.')}"


def _surroundings(family: Family, along: list[str], across: list[str]) -> Surroundings | str:
    system, constants = family.system, Constants()
    y, e = (ca.SX.sym(name, len(names)) for name, names in (("y", along), ("e", across)))
    u, p = ca.SX.sym("u", len(family.unknown)), ca.SX.sym("p", len(system.parameters))
    fixed: dict[str, Any] = {n: constants(v) if not isinstance(v, Upright) else v
                             for n, v in family.fixed.items()}  # fmt: skip
    fixed |= dict(zip(family.unknown, ca.vertsplit(u), strict=False))
    moving = dict(zip(along, ca.vertsplit(y) if along else [], strict=True))
    off = dict(zip(across, ca.vertsplit(e), strict=True))
    there = {n: moving[n] if n in moving else fixed[n] for n in system.states}
    near = {
        n: v if n in moving else Tilted(off[n]) if isinstance(v, Upright) else v + off[n]
        for n, v in there.items()
    }
    guards = ca.vertcat(1, *(c.value for c in system.conditions))
    graph = Program(ca.Function("graph", [system.x, system.p], [ca.densify(system.rhs), guards]))
    algebra, own = constants.algebra(), ca.vertsplit(p) if system.parameters else []
    order = [system.index(n) for n in (*across, *along)]
    rest = graph.run(algebra, [list(there.values()), own])[0]
    values, positive = graph.run(algebra, [list(near.values()), own])
    still = all(ca.SX(rest[i]).is_zero() for i in order)
    if along and not still:
        return "that its rates vanish along the family is not seen from the graph's structure"
    field = ca.densify(ca.vertcat(*(values[i] for i in order)))
    slope = ca.densify(ca.jacobian(field, e))
    inputs = [y, ca.vertcat(p, u), e, constants.column]

    def program(name: str, output: ca.SX) -> Program:
        return Program(ca.Function(name, inputs, [ca.densify(output)]), constants.values)

    remainder = None if along else program("rest", ca.vertcat(*(rest[i] for i in order)))
    whole = smooth_field(ca.Function("field", inputs, [field]), tuple(constants.values))
    return Surroundings(
        len(along), len(across), program("slopes", slope),
        program("positive", ca.vertcat(*positive)), remainder, whole if len(along) == 1 else None,
    )  # fmt: skip
