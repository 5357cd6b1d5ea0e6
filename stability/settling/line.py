"""A family of steady motions as a motion settles on it: its members, and the directions off it.

What settling knows of a body or a system stands in these records: the states that name a member,
the other states at that member, and how the numbers are found that a member needs.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from typing import Any, NamedTuple

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from ..algebra.kernels.double_balls import U
from ..algebra.number_types import balls, numpy_algebra
from ..algebra.program import Program
from ..algebra.upright import UPRIGHT
from ..base.errors import StabilityError, listing
from ..base.quantities import rate_unit
from ..base.types import Floats
from ..bodies.contact_laws import Contact
from ..bodies.newton_euler import STATES as SIX
from ..systems.family import Family
from ..systems.system import System
from .box import Balls
from .surroundings import NOT_PROVED, Surroundings, surroundings

NUMPY = numpy_algebra()
RIGHT_ANGLE = (np.pi / 2, U)
"""π/2 as a ball."""
ENERGY_KEPT = "energy is kept, so nothing is settled on"
STICKS = "dry friction ends in sticking, of which no settling is proved"


def idle_under(law: type[Contact]) -> str:
    """Why nothing settles under a contact law; empty where motions do."""
    return ENERGY_KEPT if law.conservative else STICKS if law.sticks else ""


def signed(states: Floats, p: Floats) -> tuple[Floats, None]:
    """The sign of φ̇ of launches by their six states, then the parameters."""
    arguments = np.empty((len(p), 1 + p.shape[1]))
    arguments[:, 0], arguments[:, 1:] = np.copysign(1.0, states[:, SIX.index("phi_dot")]), p
    return arguments, None


class Near(NamedTuple):
    """The members of a family that are nearest to launches."""

    y: Floats
    """The states that name them, shape (launches, along)."""
    distance: Floats
    """Norms of the deviations, shape (launches,); nan where there is no member."""
    arguments: Floats
    """Their other numbers, shape (launches, ·)."""


@dataclass(frozen=True, eq=False)
class FamilyLine:
    """A family of steady motions, with the directions along it and across it."""

    name: str
    """Name of the family."""
    system: System
    """Equations of the motions near it."""
    states: tuple[str, ...]
    """Names of the states of a launch, or of those that `chart` makes of them."""
    along: tuple[str, ...]
    """The states that name a member, y, in their order."""
    member: Mapping[str, Any]
    """The others at a member: expressions of `y` and `arguments`, numbers, `UPRIGHT`, or None where
    any value will do."""
    y: ca.SX
    """Symbol of y."""
    arguments: ca.SX
    """Symbols of the other numbers of a member, which end with the parameters of `system`."""
    numbers: Callable[[Floats, Floats], tuple[Floats, NDArray[np.bool_] | None]]
    """(states of launches, parameters) → values of `arguments`, and which launches have a member
    near; None where all have."""
    guards: Sequence[ca.SX]
    """Functions of the system's states that must stay positive."""
    steady: bool = True
    """Whether the members are known to be steady; if not, the graph must show it."""
    idle: str = ""
    """Why nothing settles on any family under the law; empty where motions do."""
    reason: str = ""
    """Why nothing is proved about this family; empty where a proof is tried."""
    family: Family | None = None
    """The family, for verdicts of its members; None where the law has no linearisation."""
    spelled: bool = False
    """Whether words name the numbers of a member, with their units."""
    call: Mapping[str, Any] = field(default_factory=dict)
    """What names the family in a call of `spectrum`."""
    chart: Callable[[list[ca.SX]], Sequence[ca.SX]] | None = None
    """From the six states of a launch to `states`; None where these are the first of them."""
    unchart: Callable[[Floats], Floats] | None = None
    """From y of members to the six states of a launch; None without a chart."""

    @cached_property
    def across(self) -> tuple[str, ...]:
        """The states off the family, e, in their order."""
        return tuple(n for n in self.states if n not in self.along)

    @cached_property
    def around(self) -> Surroundings | str:
        """Surroundings of the family, or the reason why nothing is proved about it."""
        if self.idle or self.reason:
            return self.idle or self.reason
        if not self.across:
            return "every state names a member, so that there is nothing to converge"
        member = {n: self.member[n] for n in self.across}
        try:
            return surroundings(
                self.system, self.guards, member, self.y, self.arguments, steady=self.steady
            )
        except StabilityError as error:
            return f"convergence to it is not proved: {str(error).rstrip('.')}"
        except (TypeError, AttributeError):  # an exact π/2 has a sine and a cosine alone
            return NOT_PROVED

    @cached_property
    def reading(self) -> ca.Function:
        """(states of a launch, given, π/2) → y, then e."""
        x = ca.SX.sym("x", len(SIX) if self.chart else len(self.states))
        right = ca.SX.sym("right")
        states = ca.vertsplit(x)
        values = dict(zip(self.states, self.chart(states) if self.chart else states, strict=True))
        y, off = ca.vertcat(*(values[n] for n in self.along)), []
        for name in self.across:
            there = self.member[name]
            place = values[name] if there is None else right if there is UPRIGHT else there
            off.append(values[name] - place)
        e = ca.vertcat(*off)
        if self.along:
            e = ca.substitute(e, self.y, y)
        both = ca.densify(ca.vertcat(y, e))
        return ca.Function("reading", [x, self.arguments, right], [both])

    @cached_property
    def _there(self) -> Program:
        """(y, given, π/2) → the states across the family at a member."""
        right = ca.SX.sym("right")
        values = (self.member[n] for n in self.across)
        column = (0.0 if v is None else right if v is UPRIGHT else v for v in values)
        there = ca.densify(ca.vertcat(*column))
        return Program(ca.Function("there", [self.y, self.arguments, right], [there]))

    def near(self, states: Floats, p: Floats) -> Near:
        """The members nearest to states of launches, and how far these are from them.

        Parameters
        ----------
        states, p
            Shapes (N, s) and (N, m).

        Returns
        -------
        Near
        """
        return nearest((self,), states, p)[0]

    def deviations(self, states: Floats, near: Near) -> Floats:
        """Deviations of states from the nearest members, shape (N, across)."""
        return _read((self,), states, [near.arguments])[len(self.along) :].T

    def enclosed(
        self, states: Floats, arguments: Floats, *, plain: bool = False
    ) -> tuple[Balls, Balls]:
        """As `near`, in balls that hold the true values for numbers that are taken as exact.

        Parameters
        ----------
        states, arguments
            Shapes (N, s) and (N, ·).
        plain
            Whether NumPy does the work although Numba is installed.

        Returns
        -------
        y, e
        """
        reading, right = _reading((self,)), np.full((1, len(states)), RIGHT_ANGLE[0])
        mid = np.vstack([states.T[: reading.inputs[0]], arguments.T, right])
        rad = np.zeros_like(mid)
        rad[-1] = RIGHT_ANGLE[1]
        tape = reading.tape
        m, r = self._singly(mid, rad) if tape is None else tape.run(mid, rad, plain=plain)
        cut = len(self.along)
        return Balls(m[:cut].T, r[:cut].T), Balls(m[cut:].T, r[cut:].T)

    def _singly(self, mid: Floats, rad: Floats) -> tuple[Floats, Floats]:
        """The readings one by one, where a function has no kernel."""
        from flint import arb

        reading, readings = _reading((self,)), np.empty((2, len(self.states), mid.shape[1]))
        parts = np.cumsum(reading.inputs)[:-1].tolist()
        for i in range(mid.shape[1]):
            numbers = [arb(*v) for v in zip(mid[:, i].tolist(), rad[:, i].tolist(), strict=True)]
            blocks = [numbers[: parts[0]], numbers[parts[0] : parts[1]], numbers[parts[1] :]]
            for j, [v] in enumerate(reading.dense(balls(), blocks)):
                readings[:, j, i] = float(v.mid()), float(v.rad())  # at 53 bits both are doubles
        return readings[0], readings[1]

    def members(self, states: Floats, y: Floats, arguments: Floats) -> Floats:
        """The states of the members nearest to launches; `near` gives y and `arguments`."""
        if self.unchart is not None:
            return self.unchart(y)
        with np.errstate(all="ignore"):
            across = self._there.run(NUMPY, [list(y.T), list(arguments.T), [math.pi / 2]])[0]
        there = states.copy()
        for name, value in zip(self.across, across, strict=True):
            if self.member[name] is not None:
                there[:, self.states.index(name)] = value
        return there

    def at(self, y: Floats, p: Floats) -> list[float]:
        """The numbers that name a member of the family in `spectrum`."""
        values = dict(zip(self.along, y.tolist(), strict=True))
        values |= dict(zip(self.system.parameters, p.tolist(), strict=False))
        names = self.along if self.family is None else self.family.at
        return [values[n] for n in names]

    def worded(self, names: Sequence[str], values: Iterable[float]) -> str:
        """Names of states or parameters with values and units, for a sentence."""
        units = (self.system.units.get(n, "1") for n in names)
        parts = zip(names, values, units, strict=True)
        return ", ".join(listing((n,), (v,)) + ("" if u == "1" else f" {u}") for n, v, u in parts)

    def called(self, y: Floats, p: Floats) -> str:
        """A member in words."""
        if not self.spelled:
            return f"{self.name} at {y[0]:.6g}"
        assert self.family is not None
        place = self.worded(self.family.at, self.at(y, p))
        return f"{self.name} at {place}" if place else self.name

    def proved(self, limit: Floats, error: float, rate: float) -> str:
        """What a proof says, in words."""
        where, unit = "", "1"
        if self.spelled:
            unit = rate_unit(self.system.units, self.system.quantities)
        if self.along:  # the limit is one of many members, known within an error
            place = self.worded(self.along, limit) if self.spelled else f"{limit[0]:.6g}"
            where = f" at {place} within {error:.2g}"
        return self.system.qualified(
            f"proved in ball arithmetic: from there on the motion converges to {self.name}{where}, "
            f"its deviation falling at the rate {rate:.3g}{'' if unit == '1' else f' {unit}'} at "
            "least"
        )


def nearest(lines: tuple[FamilyLine, ...], states: Floats, p: Floats) -> list[Near]:
    """The members of each of some families that are nearest to launches; one graph reads them all.

    Parameters
    ----------
    lines
        The families.
    states, p
        As for `Line.near`.

    Returns
    -------
    list of Near
    """
    numbers = {find: find(states, p) for find in {line.numbers for line in lines}}
    read = _read(lines, states, [numbers[line.numbers][0] for line in lines])
    members, first = [], 0
    for line in lines:
        arguments, exists = numbers[line.numbers]
        middle = first + len(line.along)
        last = middle + len(line.across)
        # no square on the way can make it overflow
        distance = np.hypot.reduce(read[middle:last], axis=0, initial=0.0)
        if exists is not None:
            distance[~exists] = np.nan
        members.append(Near(read[first:middle].T, distance, arguments))
        first = last
    return members


def _read(lines: tuple[FamilyLine, ...], states: Floats, arguments: Sequence[Floats]) -> Floats:
    """The states y that name members, then the deviations e, of each family; shape (·, N)."""
    program = _reading(lines)
    blocks = [list(states.T[: program.inputs[0]]), *(list(g.T) for g in arguments), [math.pi / 2]]
    with np.errstate(all="ignore"):
        values = program.run(NUMPY, blocks)[0]
    readings = np.empty((len(values), len(states)))
    for i, value in enumerate(values):
        readings[i] = value
    return readings


@lru_cache(maxsize=64)
def _reading(lines: tuple[FamilyLine, ...]) -> Program:
    """(states of a launch, given of each family, π/2) → y, then e, of each family."""
    functions = [line.reading for line in lines]
    x = ca.SX.sym("x", max((f.numel_in(0) for f in functions), default=0))
    arguments, right = [ca.SX.sym("given", f.numel_in(1)) for f in functions], ca.SX.sym("right")
    parts = [f(x[: f.numel_in(0)], g, right) for f, g in zip(functions, arguments, strict=True)]
    return Program(ca.Function("reading", [x, *arguments, right], [ca.vertcat(*parts)]))
