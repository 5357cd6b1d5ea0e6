"""The equations of motion near a family of steady motions: along it, and across.

With y along the family and e across it, ė = G(y, e) and ẏ = g(y, e), where G and g vanish at e = 0.
Numbers of the graph stay symbols, so that CasADi rounds none, and π/2 is exact.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import casadi as ca

from ..algebra.program import Program, operations
from ..algebra.upright import Upright
from ..systems.graph.constants import Constants
from ..systems.system import System

MOST_ACROSS = 16
"""Most states across a family for which the roundings of a tube are bounded."""
KINKED = (ca.OP_FABS, ca.OP_SIGN)
"""Operations whose graphs have a kink that no derivative shows: |x|' = sign x, and sign' = 0."""
NOT_PROVED = "convergence to it is not proved from there"
"""Reason why a state near a family has not settled."""


class Tilted(Upright):
    """The exact angle π/2 + e."""

    def __init__(self, e: Any) -> None:
        self.e = e

    def sin(self) -> Any:
        """Cos e."""
        return ca.cos(self.e)

    def cos(self) -> Any:
        """−sin e."""
        return -ca.sin(self.e)


@dataclass(frozen=True, eq=False)
class Field:
    """The graph of (y, given, e, constants) → G, then g."""

    function: ca.Function
    """The graph; without constants it takes three arguments."""
    constants: tuple[float, ...] | None = None
    """Values of the last argument, which the graph keeps as symbols; None where there is none."""

    @property
    def symbols(self) -> list[ca.SX]:
        """Fresh symbols of the constants, in a list; empty where there are none."""
        count = self.function.n_in() - 3
        return [ca.SX.sym("constant", self.function.numel_in(3))] if count else []


def smooth_field(function: ca.Function, constants: tuple[float, ...] | None = None) -> Field | None:
    """The field of a family, or None where a Taylor series does not say how far it is true.

    Parameters
    ----------
    function
        As in `Field`; an SX function.
    constants
        As in `Field`.
    """
    if not set(KINKED).isdisjoint(operations(function)) or function.numel_in(2) > MOST_ACROSS:
        return None
    return Field(function, constants)


@dataclass(frozen=True, eq=False)
class Surroundings:
    """Surroundings of a family: programs of (y, given, e)."""

    along: int
    """Number of entries of y."""
    across: int
    """Number of entries of e."""
    slopes: Program
    """∂G/∂e, then ∂g/∂e, shape (across + along, across)."""
    positive: Program
    """The guards."""
    remainder: Program | None = None
    """G at e = 0 for a family without y; None for a family with y, where G is zero by structure."""
    field: Field | None = None
    """The field itself, for a family that one number names; None where no tube is sought."""


def surroundings(
    system: System,
    guards: Sequence[ca.SX],
    member: Mapping[str, Any],
    y: ca.SX,
    arguments: ca.SX,
    *,
    steady: bool,
) -> Surroundings | str:
    """Surroundings of a family, or the reason why nothing is proved about it.

    Parameters
    ----------
    system
        The equations of motion.
    guards
        Functions of the system's states that must stay positive.
    member
        The states across the family by name: expressions of `y` and `arguments`, numbers,
        `UPRIGHT`, or None where a state may have any value.  The others name a member, in the order
        of `y`.
    y, arguments
        Symbols of the first two arguments of the programs; `arguments` ends with the parameters.
    steady
        Whether the members are known to be steady; if not, the graph must show it.

    Returns
    -------
    Surroundings or str
        The reason is a sentence without its full stop.

    Raises
    ------
    StabilityError, TypeError, AttributeError
        If a graph has a function of which nothing is known: an exact π/2 has a sine and a cosine
        alone.
    """
    constants, e = Constants(), ca.SX.sym("e", len(member))
    along = [n for n in system.states if n not in member]
    there: dict[str, Any] = dict(zip(along, ca.vertsplit(y) if along else [], strict=True))
    for name, value in member.items():
        symbolic = isinstance(value, (Upright, ca.SX))
        there[name] = value if symbolic else constants(0.0 if value is None else value)
    off = dict(zip(member, ca.vertsplit(e), strict=True))
    near = {
        n: v if n in along else Tilted(off[n]) if isinstance(v, Upright) else v + off[n]
        for n, v in there.items()
    }
    watched = ca.vertcat(1, *guards)
    graph = Program(ca.Function("graph", [system.x, system.p], [ca.densify(system.rhs), watched]))
    p = arguments[arguments.numel() - len(system.parameters) :]

    def read(states: Mapping[str, Any]) -> tuple[dict[str, ca.SX], list[Any]]:
        point = [[states[n] for n in system.states], ca.vertsplit(p) if p.numel() else []]
        rates, positive = graph.run(constants.algebra(), point)
        return dict(zip(system.states, map(ca.SX, rates), strict=True)), positive

    rates, positive = read(near)
    moving = ca.vertcat(*(rates[n] for n in along))
    for n in member:  # a member moves with its parameters
        if isinstance(there[n], ca.SX) and along and ca.depends_on(there[n], y):
            rates[n] -= ca.jacobian(there[n], y) @ moving
    at_rest = {} if steady and along else read(there)[0]
    if along and not all(v.is_zero() for v in at_rest.values()):
        return "that its rates vanish along the family is not seen from the graph's structure"
    field = ca.densify(ca.vertcat(*(rates[n] for n in (*member, *along))))
    inputs = [y, arguments, e, constants.column]

    def program(name: str, output: ca.SX) -> Program:
        return Program(ca.Function(name, inputs, [ca.densify(output)]), constants.values)

    slopes, positive = program("slopes", ca.jacobian(field, e)), ca.vertcat(*positive)
    rest = None if along else program("rest", ca.vertcat(*(at_rest[n] for n in member)))
    whole = smooth_field(ca.Function("field", inputs, [field]), tuple(constants.values))
    return Surroundings(
        len(along),
        len(member),
        slopes,
        program("positive", positive),
        rest,
        whole if len(along) == 1 else None,
    )
