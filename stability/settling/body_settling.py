"""Settling of a body of revolution: closed forms of its steady motions, and their surroundings.

The families are those of docs/bodies.md that one number names: rolling at each zero of the height's
slope, spinning where that slope vanishes upright, tumbling, vertical spin at smooth poles.  As for
the disk, a state counts as settled if its distance is within the limit and
`stability.settling.attraction` proves that the motion from there on converges to one member.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
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
from .attraction import Attraction, Surroundings, attraction
from .kernel import Balls
from .lines import line_surroundings
from .many import RIGHT_ANGLE, NearestMany, nearest_many
from .nearest import Nearest

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

    @cached_property
    def _tape(self) -> Tape:
        n, held = len(self.system.states), 2 + self.system.p.numel()

        def parts(a: list[Any], number: Algebra) -> list[Any]:
            rows = self.deviation.dense(number, [a[:n], a[n : n + held], a[n + held :]])
            return [v for [v] in rows]

        return recorded(parts, n + held + 1)

    def place(self, states: Floats, p: Floats, *, plain: bool) -> tuple[Balls, Balls, Floats]:
        """Parameters, deviations and second arguments of the programs, launch by launch."""
        signs = np.copysign(1.0, states[:, TURNING])
        heights = np.array([self._level(tuple(q)) for q in p.tolist()])
        given = np.column_stack([signs, heights, p])
        right = np.broadcast_to(RIGHT_ANGLE, (2, len(states)))
        mid = np.vstack([states[:, : len(self.system.states)].T, given.T, right[0]])
        rad = np.vstack([np.zeros_like(mid[:-1]), right[1]])
        m, r = self._tape.run(mid, rad, plain=plain)
        return Balls(m[:1].T, r[:1].T), Balls(m[1:].T, r[1:].T), given

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
        return attraction(around, given, [y], e)


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

    def _chart(self, states: Floats) -> tuple[Floats, Floats]:
        """ω_Z, and axis_X, axis_Y, ω_X, ω_Y and the slip of the six states."""
        theta, theta_dot, phi_dot, omega3, *slip = np.moveaxis(states, -1, 0)
        sine, spin = np.sin(theta), omega3 - phi_dot * np.cos(theta)
        off = [sine, 0 * sine, spin * sine, theta_dot, *slip]
        return phi_dot + spin * np.cos(theta), np.stack(off, axis=-1)

    def deviations(self, states: Floats, p: Floats) -> Floats:  # noqa: ARG002
        """Deviations of states, shape (t, 6), from the members with their ω_Z, shape (t, 6)."""
        off = self._chart(states)[1]
        off[self.pole * np.cos(states[:, 0]) <= 0] = np.inf
        return off

    @property
    def attracting(self) -> Surroundings | None:
        """Surroundings of the family; None where no motion is proved to settle on it."""
        return None if self.conservative else self.around

    def place(self, states: Floats, p: Floats, *, plain: bool) -> tuple[Balls, Balls, Floats]:  # noqa: ARG002
        """Parameters, deviations and second arguments of the programs, launch by launch."""
        own, off = self._chart(states)
        off[self.pole * np.cos(states[:, 0]) <= 0] = np.inf
        y = np.asarray(own)[:, None]
        return Balls(y, np.zeros_like(y)), Balls(off, np.zeros_like(off)), p

    def at(self, state: Floats) -> float:
        """The number that names the member of a state."""
        return float(self._chart(state)[0])

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

        own, off = self._chart(state)
        return attraction(
            self.around, p.tolist(), [arb(float(own))], [arb(v) for v in off.tolist()]
        )


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
class BodySettling:
    """Settling of a body of revolution under a contact law."""

    lines: tuple[Line | Vertical, ...]
    """Its families that one number names."""

    @property
    def families(self) -> tuple[Family, ...]:
        """The families, for the verdicts of their members."""
        return tuple(line.family for line in self.lines)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the families."""
        return tuple(line.name for line in self.lines)

    def closest(self, state: Floats, p: Floats) -> Nearest:
        """The steady motion nearest to a state, with its states; settling is not tested."""
        return self._closest(state, p)[0]

    def many(
        self, states: Floats, p: Floats, within: float | Floats, *, plain: bool = False
    ) -> NearestMany:
        """The nearest family of many states, and which have settled, as `nearest_many`."""
        return nearest_many(self.lines, states, p, within, plain=plain)

    def at_of(self, family: Family, state: Floats, p: Floats) -> Floats:  # noqa: ARG002
        """The number that names the nearest member of a family, shape (1,)."""
        return np.array([line.at(state) for line in self.lines if line.family is family])

    def deviation(self, family: Family, state: Floats, p: Floats) -> Floats | None:
        """Deviation from the member with the same `at`, in the states of the family's equations."""
        [line] = (one for one in self.lines if one.family is family)
        values = line.deviations(state[None], p)[0]
        if not np.isfinite(values).all():
            return None
        states = line.system.states
        names = [n for n in states if n != line.family.at[0]]
        table = dict(zip(names, values, strict=False))
        return np.array([table.get(n, 0.0) for n in family.system.states])

    def _closest(self, state: Floats, p: Floats) -> tuple[Nearest, Line | Vertical | None]:
        far = [float(np.linalg.norm(line.deviations(state[None], p))) for line in self.lines]
        if not far or not math.isfinite(min(far)):
            return Nearest("", math.nan, math.inf, False, 0.0, "no steady motion is near"), None
        line = self.lines[int(np.argmin(far))]
        at = line.at(state)
        where = f"nearest is {line.name} at {at:.6g}, {min(far):.3g} away"
        member = line.at_member(state, p)
        return Nearest(line.name, at, min(far), False, 0.0, where, member), line

    def nearest(self, state: Floats, p: Floats, within: float) -> Nearest:
        """The steady motion nearest to a state, and whether the state has settled on it."""
        near, line = self._closest(state, p)
        if line is None:
            return near
        if line.conservative:
            said = f"{near.evidence}; energy is kept, so nothing is settled on"
            return replace(near, evidence=said)
        if near.distance > within:
            return near
        found = line.settled(state, p)
        where = f"{near.distance:.3g} from {line.name} at {near.at:.6g}"
        if found is None:
            said = f"{where}; convergence to it is not proved from there"
            return replace(near, evidence=said)
        said = (
            f"{where}; proved in ball arithmetic: from there on the motion converges to "
            f"{line.name} at {found.limit[0]:.6g} within {found.error:.2g}, its deviation falling "
            f"at the rate {found.rate:.3g} at least"
        )
        return replace(near, settled=True, reach=found.reach, evidence=said)

    def distances(self, states: Floats, p: Floats, near: Nearest) -> Floats:
        """Distances of states, shape (t, 6), from the family of a nearest member, shape (t,)."""
        line = next(one for one in self.lines if one.name == near.family)
        found: Floats = np.linalg.norm(line.deviations(states, p), axis=-1)
        return found
