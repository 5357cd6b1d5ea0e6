"""Surroundings of a family that one state names and whose members are known in closed form.

Vertical spin of a body at a smooth pole is one: its member has the same ω_Z.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from types import SimpleNamespace
from typing import Any

import casadi as ca
import numpy as np

from ..algebra.kernels.tape import Tape, recorded
from ..algebra.number_types import Algebra, balls, casadi_algebra
from ..algebra.program import Program
from ..algebra.upright import UPRIGHT
from ..base.types import Floats
from ..systems.family import Family
from ..systems.system import System
from .attraction import Attraction, Surroundings, Tilted, attraction
from .kernel import Balls


def line_surroundings(
    system: System, positive: ca.SX, own: str, member: Mapping[str, Any], y: ca.SX, given: ca.SX
) -> Surroundings:
    """Programs of (y, given, e) → ∂G/∂e and ∂g/∂e, and → conditions, around a family.

    Parameters
    ----------
    system
        The equations of motion.
    positive
        Conditions of the system's states that must stay positive.
    own
        The state that names a member.
    member
        The states of a member by name: expressions of `y` and `given`, numbers, or `UPRIGHT`.
    y
        Symbol of the state that names a member.
    given
        Symbols of the second argument of the programs, which end with the system's parameters.

    Returns
    -------
    Surroundings
    """
    others = [n for n in system.states if n != own]  # whose deviations are e
    e = ca.SX.sym("e", len(others))
    deviations = {n: e[i] for i, n in enumerate(others)}
    x = [
        y if n == own
        else Tilted(deviations[n]) if member[n] is UPRIGHT
        else member[n] + deviations[n]
        for n in system.states
    ]  # fmt: skip
    graph = Program(ca.Function("graph", [system.x, system.p], [system.rhs, positive]))
    values = graph.run(casadi_algebra(), [x, ca.vertsplit(system.p)])
    rows = (system.states[row] for row, _ in graph.places[0])
    rhs = dict.fromkeys(system.states, ca.SX(0)) | dict(zip(rows, values[0], strict=True))
    along = rhs[own]
    for n in others:  # a member moves with its parameter
        if member[n] is not UPRIGHT and ca.depends_on(ca.SX(member[n]), y):
            rhs[n] = rhs[n] - ca.jacobian(member[n], y) * along
    slope = ca.densify(ca.jacobian(ca.vertcat(*(rhs[n] for n in others), along), e))
    inputs = [y, given, e]
    return Surroundings(
        1, len(others), Program(ca.Function("slopes", inputs, [slope])),
        Program(ca.Function("positive", inputs, [ca.densify(ca.vertcat(*values[1]))])),
    )  # fmt: skip


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
        """As `Place.place`."""
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
        return attraction(self.around, p.tolist(), [own], off)


@lru_cache(maxsize=1)
def _pole_chart() -> Tape:
    """Six states → ω_Z, then the six deviations."""

    def chart(a: list[Any], number: Algebra) -> list[Any]:
        return Vertical._chart(a, SimpleNamespace(**number.functions))

    return recorded(chart, 6)
