"""Families of a body that one number names: members, deviations and surroundings in closed form."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from types import SimpleNamespace
from typing import Any

import casadi as ca
import numpy as np

from ..algebra.kernels.tape import Tape, recorded
from ..algebra.number_types import Algebra, balls
from ..algebra.program import Program
from ..algebra.upright import UPRIGHT
from ..base.errors import StabilityError
from ..base.types import Floats
from ..bodies.newton_euler import STATES
from ..systems.family import Family
from ..systems.system import System
from .attraction import Attraction, Surroundings
from .lines import line_surroundings
from .proof import settles
from .together.kernel import Balls
from .together.many import RIGHT_ANGLE

TURNING = STATES.index("phi_dot")
ROOT = 60
"""Most iterations for the inclination of rolling."""


@dataclass(frozen=True, eq=False)
class Line:
    """A family that one state names, with its members in closed form."""

    family: Family
    """The family, for its verdict."""
    system: System
    """The body with every state of a motion that the law leaves."""
    conservative: bool
    """Whether the law keeps the energy."""
    height: ca.Function
    """(θ, numbers of the shape) → h, h' and h''."""
    moments: ca.SX
    """Axial and transverse moment in the parameters of the system."""
    between: tuple[float, float]
    """Interval of θ in which the height holds."""
    level: float | None = None
    """Inclination near that of rolling; None for exactly upright, and for tumbling."""
    several: bool = False
    """Whether the body rolls at other inclinations too."""

    @property
    def name(self) -> str:
        """Name of the family."""
        return self.family.name

    @property
    def call(self) -> dict[str, Any]:
        """The family and what else names it in a call of `spectrum`."""
        name = self.name.partition(" ")[0]
        theta = math.pi / 2 if self.level is None else self.level
        return {"family": name} | ({"theta": theta} if self.several else {})

    @property
    def own(self) -> str:
        """The state that names a member."""
        return self.family.at[0]

    @cached_property
    def symbols(self) -> tuple[ca.SX, ca.SX]:
        """Symbols: the state that names a member; sign of φ̇, inclination of rolling, parameters."""
        given = ca.vertcat(ca.SX.sym("sign"), ca.SX.sym("level"), self.system.p)
        return ca.SX.sym("y"), given

    @cached_property
    def member(self) -> dict[str, Any]:
        """The states of a member by name."""
        y, given = self.symbols
        found: dict[str, Any] = dict.fromkeys(self.system.states, 0.0) | {self.own: y}
        if self.own != "theta":
            found["theta"] = UPRIGHT if self.level is None else given[1]
            return found
        shape = ca.vertsplit(self.system.p)[: self.height.n_in() - 1]
        h, slope, _ = self.height(y, *shape)
        sine, cosine = ca.sin(y), ca.cos(y)
        r, z = h * sine + slope * cosine, h * cosine - slope * sine
        axial, transverse = self.moments[0], self.moments[1]
        square = slope * r / (sine * (transverse * r * cosine - axial * z * sine))
        found["phi_dot"] = given[0] * ca.sqrt(square)
        found["omega3"] = found["phi_dot"] * sine * z / r
        return found

    @cached_property
    def deviation(self) -> Program:
        """(states, (sign, level, p), π/2) → at, then the deviations of the other states."""
        x, (y, given), right = self.system.x, self.symbols, ca.SX.sym("right")
        own = self.system.states.index(self.own)
        parts = [x[own]]
        for i, name in enumerate(self.system.states):
            if i != own:
                parts.append(x[i] - (right if self.member[name] is UPRIGHT else self.member[name]))
        found = ca.substitute(ca.densify(ca.vertcat(*parts)), y, x[own])
        return Program(ca.Function("deviation", [x, given, right], [found]))

    @cached_property
    def around(self) -> Surroundings | None:
        """Surroundings of the family; None where its graph cannot be read there."""
        system, (y, given) = self.system, self.symbols
        seen, theta = system.observables, system.x[0]
        # the exact π/2 has a sine and a cosine alone
        room = [sign * ca.sin(theta) * math.cos(end) - sign * ca.cos(theta) * math.sin(end)
                for sign, end in zip((1, -1), self.between, strict=True)]  # fmt: skip
        positive = ca.vertcat(seen["normal_force"], seen["determinant"], *room)
        try:
            return line_surroundings(system, positive, self.own, self.member, y, given)
        except (StabilityError, TypeError, AttributeError):
            return None

    def given(self, p: Floats, sign: float) -> list[float]:
        """Second argument of the programs."""
        return [sign, self._level(tuple(p.tolist())), *p.tolist()]

    def _level(self, p: tuple[float, ...]) -> float:
        return math.pi / 2 if self.level is None else _level(self, p)

    def deviations(self, states: Floats, p: Floats) -> Floats:
        """Deviations of states, shape (t, s), from members with the same `at`, shape (t, n - 1)."""
        signs = np.copysign(1.0, states[:, TURNING])
        given = self.given(p, 1.0)
        x = list(states[:, : len(self.system.states)].T)
        with np.errstate(all="ignore"):
            values = self.deviation.arrays([x, [signs, *given[1:]], [math.pi / 2]], signs.shape)[0]
        found: Floats = np.nan_to_num(values[:, 1:, 0], nan=np.inf)  # where there is no member
        return found

    @property
    def attracting(self) -> Surroundings | None:
        """Surroundings of the family; None where no motion is proved to settle on it."""
        # an inclination that leans is not known exactly
        return None if self.conservative or self.level is not None else self.around

    def _parts(self, a: list[Any], number: Algebra) -> list[Any]:
        """States, second argument of the programs and π/2 → at, then the deviations."""
        n = len(self.system.states)
        return [v for [v] in self.deviation.dense(number, [a[:n], a[n:-1], a[-1:]])]

    @cached_property
    def _tape(self) -> Tape:
        return recorded(self._parts, sum(self.deviation.inputs))

    def place(self, states: Floats, p: Floats, *, plain: bool) -> tuple[Balls, Balls, Floats]:
        """Parameters, deviations and second arguments of the programs, launch by launch.

        Parameters
        ----------
        states, p, plain
            As for `stability.settling.together.many.Place`.
        """
        signs = np.copysign(1.0, states[:, TURNING])
        heights = np.array([self._level(tuple(q)) for q in p.tolist()])
        given = np.column_stack([signs, heights, p])
        right = np.broadcast_to(RIGHT_ANGLE, (2, len(states)))
        mid = np.vstack([states[:, : len(self.system.states)].T, given.T, right[0]])
        rad = np.vstack([np.zeros_like(mid[:-1]), right[1]])
        try:
            m, r = self._tape.run(mid, rad, plain=plain)
        except StabilityError:  # a function without a kernel
            m, r = self._one_by_one(mid, rad)
        return Balls(m[:1].T, r[:1].T), Balls(m[1:].T, r[1:].T), given

    def _one_by_one(self, mid: Floats, rad: Floats) -> tuple[Floats, Floats]:
        from flint import arb

        found = np.empty((2, len(self.system.states), mid.shape[1]))
        for i in range(mid.shape[1]):
            own = [arb(*v) for v in zip(mid[:, i].tolist(), rad[:, i].tolist(), strict=True)]
            for j, v in enumerate(self._parts(own, balls())):
                found[:, j, i] = float(v.mid()), float(v.rad())  # at 53 bits both are doubles
        return found[0], found[1]

    def at(self, state: Floats) -> float:
        """The number that names the member of a state."""
        return float(state[self.system.states.index(self.own)])

    def at_member(self, state: Floats, p: Floats) -> Floats:
        """The states of the member that belongs to a state."""
        off = self.deviations(state[None], p)[0]
        found = state.copy()
        others = [i for i, n in enumerate(self.system.states) if n != self.own]
        found[others] -= off
        return found

    def settled(self, state: Floats, p: Floats) -> Attraction | None:
        """A proof that a motion converges to one steady motion of the family."""
        from flint import arb

        around = self.around
        if around is None or self.level is not None:  # that inclination is not known exactly
            return None
        given = self.given(p, math.copysign(1.0, state[TURNING]))
        exact = [arb(v) for v in state[: len(self.system.states)].tolist()]
        held, right = [arb(v) for v in given], [arb.pi() / 2]
        [y, *e] = (v for [v] in self.deviation.dense(balls(), [exact, held, right]))
        return settles(around, given, [y], e)


@lru_cache(maxsize=256)
def _level(line: Line, p: tuple[float, ...]) -> float:
    """The zero of the height's slope near that of the line, by Newton's method."""
    theta = float(line.level or 0.0)
    shape = p[: line.height.n_in() - 1]
    for _ in range(ROOT):
        _, slope, bend = (float(v) for v in line.height(theta, *shape))
        step = slope / bend if bend else math.nan
        theta -= step
        if not abs(step) > 1e-15:
            return theta
    return math.nan


@dataclass(frozen=True, eq=False)
class Vertical:
    """Spin about the vertical axis at a pole, in the chart around it with x̂ along X."""

    family: Family
    """The family, for its verdict."""
    system: System
    """The system of the family."""
    conservative: bool
    """Whether the law keeps the energy."""
    pole: int
    """1 for θ = 0, -1 for θ = π."""

    @property
    def name(self) -> str:
        """Name of the family."""
        return self.family.name

    @property
    def call(self) -> dict[str, Any]:
        """The family and what else names it in a call of `spectrum`."""
        return {"family": "vertical", "pole": 0 if self.pole == 1 else "pi"}

    @staticmethod
    def _chart(six: Sequence[Any], functions: Any) -> list[Any]:
        """ω_Z, then axis_X, axis_Y, ω_X, ω_Y and the slip, of six states of any number type."""
        theta, theta_dot, phi_dot, omega3, *slip = six
        sine, cosine = functions.sin(theta), functions.cos(theta)
        spin = omega3 - phi_dot * cosine
        return [phi_dot + spin * cosine, sine, 0 * sine, spin * sine, theta_dot, *slip]

    def deviations(self, states: Floats, p: Floats) -> Floats:  # noqa: ARG002
        """Deviations of states, shape (t, 6), from the members with their ω_Z, shape (t, 6)."""
        off = np.stack(self._chart([*np.moveaxis(states, -1, 0)], np)[1:], axis=-1)
        off[self.pole * np.cos(states[:, 0]) <= 0] = np.inf
        return off

    @property
    def attracting(self) -> Surroundings | None:
        """Surroundings of the family; None where no motion is proved to settle on it."""
        return None if self.conservative else self.around

    def place(self, states: Floats, p: Floats, *, plain: bool) -> tuple[Balls, Balls, Floats]:
        """Parameters, deviations and second arguments of the programs, launch by launch.

        Parameters
        ----------
        states, p, plain
            As for `stability.settling.together.many.Place`.
        """
        m, r = (v.T for v in _pole_chart().run(states.T, plain=plain))
        m[self.pole * np.cos(states[:, 0]) <= 0] = np.inf  # the other pole is nearer
        return Balls(m[:, :1], r[:, :1]), Balls(m[:, 1:], r[:, 1:]), p

    def at(self, state: Floats) -> float:
        """The number that names the member of a state."""
        return float(self._chart(state.tolist(), np)[0])

    def at_member(self, state: Floats, p: Floats) -> Floats:  # noqa: ARG002
        """The states of the member that belongs to a state."""
        theta = 0.0 if self.pole == 1 else math.pi
        return np.array([theta, 0.0, 0.0, self.pole * self.at(state), 0.0, 0.0])

    @cached_property
    def around(self) -> Surroundings:
        """Surroundings of the family."""
        system = self.system
        member = dict.fromkeys(system.states, 0.0)
        positive = ca.vertcat(
            system.observables["normal_force"], *(c.value for c in system.conditions)
        )
        return line_surroundings(system, positive, "omega_Z", member, ca.SX.sym("y"), system.p)

    def settled(self, state: Floats, p: Floats) -> Attraction | None:
        """A proof that a motion converges to one steady motion of the family."""
        from flint import arb

        functions = SimpleNamespace(**balls().functions)
        own, *off = self._chart([arb(v) for v in state.tolist()], functions)
        return settles(self.around, p.tolist(), [own], off)


@lru_cache(maxsize=1)
def _pole_chart() -> Tape:
    """Six states → ω_Z, then the six deviations."""

    def chart(a: list[Any], number: Algebra) -> list[Any]:
        return Vertical._chart(a, SimpleNamespace(**number.functions))

    return recorded(chart, 6)
