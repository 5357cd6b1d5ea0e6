"""Input of integrators: a model's graph as functions of one state or many, with its guards."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Any

import casadi as ca
import numpy as np

from ..algebra.eigensolver import eigenvalues_alone
from ..algebra.program import Program, entries
from ..base.errors import DomainError
from ..base.types import Floats, fields_of
from ..bodies.contact_laws import Contact
from ..bodies.model import Model
from ..bodies.thin_disk import disk_model
from ..systems.sources.numeric import NumericSystem
from ..systems.system import System


@dataclass(frozen=True, eq=False)
class Flow:
    """The rates of a model's y and the guards that must stay positive, as numbers.

    Examples
    --------
    >>> f = flow("viscous")
    >>> f.names
    ('theta', 'theta_dot', 'phi_dot', 'omega3', 'slip_x', 'slip_y', 'work')
    >>> list(f.guards)
    ['lift-off', 'flat', 'no-contact']
    """

    model: Model
    """Equations, guards and names."""

    @cached_property
    def system(self) -> System:
        """The equations of motion."""
        return self.model.system

    @cached_property
    def x(self) -> ca.SX:
        """Symbols of y, shape (n,)."""
        return self.model.x

    @cached_property
    def p(self) -> ca.SX:
        """Symbols of the parameters, shape (m,)."""
        return self.model.p

    @cached_property
    def rhs(self) -> ca.SX:
        """dy/dt, shape (n,)."""
        return self.model.rhs

    @cached_property
    def guards(self) -> Mapping[str, ca.SX]:
        """Functions that stay positive, by name."""
        return self.model.guards

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Names of the entries of y."""
        return self.model.names

    @cached_property
    def length(self) -> int:
        """Number of operations of the rates."""
        count: int = ca.Function("rates", [self.x, self.p], [self.rhs]).n_instructions()
        return count

    @cached_property
    def friction(self) -> str:
        """Name of the parameter that the decay rate of slip is proportional to; empty for none."""
        return self.model.friction

    @cached_property
    def compared(self) -> int:
        """Number of entries of y, from the first, in which two runs are compared."""
        states = self.system.states if self.model.chart else self.model.states
        return min(len(self.names), len(states))

    def having(self, **fields: Any) -> Flow:
        """The flow of the same model with other fields."""
        return Flow(replace(self.model, **fields))

    def paces(self, points: Floats, p: Floats, spans: Floats) -> Floats:
        """Rates at which N motions change: the unit of stiffness and of looks at guards.

        The largest angular velocity, and at least 1, where the model names some.  Otherwise the
        largest of the relative rates of the states, the frequencies of the linearised motion and
        one over the length of the run, `spans`.
        """
        turning = list(self.model.turning)
        if turning:
            fast: Floats = np.maximum(1.0, np.abs(points[:, turning]).max(axis=1))
            return fast
        count = len(self.system.states)
        paces = 1 / spans
        for i, (y, values) in enumerate(zip(points, p, strict=True)):
            rates = self.quick.rates(values, y)[:count]
            matrix = self.quick.jacobian(values, y)[:count, :count]
            with np.errstate(all="ignore"):
                pace = float((np.abs(rates) / np.maximum(1.0, np.abs(y[:count]))).max())
                if np.isfinite(matrix).all():
                    pace = max(pace, float(np.abs(eigenvalues_alone(matrix).imag).max()))
            paces[i] = max(paces[i], pace) if np.isfinite(pace) else paces[i]
        return paces

    __getstate__ = fields_of

    @cached_property
    def rates(self) -> ca.Function:
        """CasADi function (y, p) → dy/dt."""
        return ca.Function("rates", [self.x, self.p], [ca.densify(self.rhs)])

    @cached_property
    def jacobian(self) -> ca.Function:
        """CasADi function (y, p) → ∂(dy/dt)/∂y, dense, by automatic differentiation."""
        return ca.Function(
            "jacobian", [self.x, self.p], [ca.densify(ca.jacobian(self.rhs, self.x))]
        )

    @cached_property
    def _rates_program(self) -> Program:
        return Program(self.rates)

    def rates_at(self, y: Floats, p: Floats) -> Floats:
        """dy/dt at many points, shapes (N, n) and (N, m) to (N, n)."""
        rates: Floats = self._rates_program.arrays([list(y.T), list(p.T)], y.shape[:1])[0][..., 0]
        return rates

    @cached_property
    def _jacobian_program(self) -> Program:
        return Program(self.jacobian)

    def jacobians(self, y: Floats, p: Floats) -> Floats:
        """∂(dy/dt)/∂y at many points, shapes (N, n) and (N, m) to (N, n, n)."""
        if len(y) == 1:
            return self.quick.jacobian(p[0], y[0])[None]
        matrices: Floats = self._jacobian_program.arrays([list(y.T), list(p.T)], y.shape[:-1])[0]
        return matrices

    @cached_property
    def watch(self) -> ca.Function:
        """CasADi function (y, p) → guards and their rates along the motion."""
        values = ca.vertcat(*self.guards.values())
        return ca.Function(
            "watch",
            [self.x, self.p],
            [ca.densify(ca.vertcat(values, ca.jtimes(values, self.x, self.rhs)))],
        )

    @cached_property
    def guard_slopes(self) -> ca.Function:
        """CasADi function (y, p) → gradients of the guards."""
        values = ca.vertcat(*self.guards.values())
        slopes = ca.densify(ca.jacobian(values, self.x))
        return ca.Function("guard_slopes", [self.x, self.p], [slopes])

    @cached_property
    def _watch_program(self) -> Program:
        return Program(self.watch)

    def margins(self, y: Floats, p: Floats) -> tuple[Floats, Floats]:
        """Guards and their rates, shape (…, guards), at y (…, n) and p (m,) or (…, m)."""
        if not self.guards:
            return np.empty((*y.shape[:-1], 0)), np.empty((*y.shape[:-1], 0))
        if y.ndim == 1:
            return self.quick.watch(p, y)
        both = self._watch_program.arrays([entries(y), entries(p)], y.shape[:-1])[0][..., 0]
        count = len(self.guards)
        return both[..., :count], both[..., count:]

    @property
    def quick(self) -> PointFunctions:
        """The flow's functions for one point at a time, bound to memory of this thread."""
        held: dict[Flow, PointFunctions] = _THREAD.__dict__.setdefault("held", {})
        if self not in held:
            held[self] = PointFunctions(self)
        return held[self]

    def pack(self, states: Floats) -> Floats:
        """The state y at the start: the system's own states, no work done, pose at the origin."""
        if self.model.chart:
            return self.model.chart.pack(states)
        count = len(self.system.states)
        y = np.zeros((*states.shape[:-1], len(self.names)))
        y[..., :count] = states[..., :count]
        return y

    def reported(self, y: Floats) -> Floats:
        """The states that a motion reports, from y; those that the system does not have are 0."""
        if self.model.chart:
            return self.model.chart.report(y)
        width, count = len(self.system.states), len(self.model.states)
        if width == count:
            return y[..., :count]
        return np.concatenate([y[..., :width], np.zeros((*y.shape[:-1], count - width))], axis=-1)


class PointFunctions:
    """A flow as fast functions of one point, without conversions; for one thread.

    Parameters
    ----------
    flow
        The flow.

    Examples
    --------
    >>> f = flow("viscous")
    >>> start = f.pack(np.array([np.pi / 2, 0, 0, 1.2, 0, 0]))
    >>> f.quick.rates(np.array([0.25, 0.3, 1e-6]), start).shape
    (7,)
    """

    def __init__(self, flow: Flow) -> None:
        self.flow, self.guards = flow, len(flow.guards)
        n, self.p = len(flow.names), np.zeros(flow.p.numel())
        self._rates = _bound(flow.rates, self.p, n, (n,))
        self._watch = _bound(flow.watch, self.p, n, (2 * self.guards,)) if self.guards else None
        self._jacobian: Callable[[Floats], Floats] | None = None

    def rates(self, p: Floats, y: Floats) -> Floats:
        """dy/dt, shape (n,)."""
        self.p[:] = p
        rates: Floats = self._rates(y)
        return rates

    def jacobian(self, p: Floats, y: Floats) -> Floats:
        """∂(dy/dt)/∂y, shape (n, n)."""
        if self._jacobian is None:
            n = len(self.flow.names)
            self._jacobian = _bound(self.flow.jacobian, self.p, n, (n, n))
        self.p[:] = p
        matrix: Floats = self._jacobian(y)
        return matrix

    def watch(self, p: Floats, y: Floats) -> tuple[Floats, Floats]:
        """Guards and their rates, shape (guards,) each."""
        if self._watch is None:
            return np.empty(0), np.empty(0)
        self.p[:] = p
        both = self._watch(y)
        return both[: self.guards], both[self.guards :]


class Evaluator:
    """One launch's equations as an integrator needs them: functions of (t, y).

    Parameters
    ----------
    flow
        The flow.
    p
        Its parameters, shape (m,).

    Examples
    --------
    >>> f = flow("viscous")
    >>> e = Evaluator(f, np.array([0.25, 0.3, 1e-6]))
    >>> e.rates(0.0, f.pack(np.array([np.pi / 2, 0, 0, 1.2, 0, 0]))).shape
    (7,)
    """

    def __init__(self, flow: Flow, p: Floats) -> None:
        self.flow, self.p, self._quick = flow, p, flow.quick
        # stretched time has another pace
        self.turning = [] if flow.names[-1] == "time" else list(flow.model.turning)
        self.looks = 1 if flow.model.turning else LOOKS

    def rates(self, _t: float, y: Floats) -> Floats:
        """dy/dt, shape (n,)."""
        return self._quick.rates(self.p, y)

    def jacobian(self, _t: float, y: Floats) -> Floats:
        """∂(dy/dt)/∂y, shape (n, n)."""
        return self._quick.jacobian(self.p, y)

    def watch(self, y: Floats) -> tuple[Floats, Floats]:
        """Guards and their rates, shape (guards,) each."""
        return self._quick.watch(self.p, y)


LOOKS = 12
"""Looks at the guards within a step, where the model names no angular velocities."""
_THREAD = threading.local()
CASADI = threading.RLock()
"""Lock for one motion at a time: CasADi's objects are not for several threads at once."""
ASKING = threading.Lock()
"""Lock for a worker that calls CasADi: the solvers of a process share its standard error."""


def _bound(function: ca.Function, p: Floats, n: int, shape: tuple[int, ...]) -> Any:
    """A CasADi function of (y, p) bound to its own memory."""
    buffer: Any
    buffer, evaluate = function.buffer()
    y: Any = np.zeros(n)
    out: Any = np.zeros(shape, order="F")
    fixed: Any = p
    buffer.set_arg(0, memoryview(y))
    buffer.set_arg(1, memoryview(fixed))
    buffer.set_res(0, memoryview(out.T))

    def call(state: Floats, _keep: Any = buffer) -> Any:
        y[:] = state
        evaluate()
        return out.copy()

    return call


def flow(law: str | type[Contact], *, pose: bool = False) -> Flow:
    """The flow of the disk under a contact law; built once for each."""
    return flow_of(disk_model(law, pose=pose))


@lru_cache(maxsize=64)
def flow_of(model: Model) -> Flow:
    """The flow of a model; built once for each."""
    return (NumericFlow if isinstance(model.system, NumericSystem) else Flow)(model)


class NumericFlow(Flow):
    """The flow of a numeric system: a Python function and its slopes by differences."""

    def rates_at(self, y: Floats, p: Floats) -> Floats:
        """dy/dt at many points, shapes (N, n) and (N, m) to (N, n)."""
        return np.array([self.quick.rates(*both) for both in zip(p, y, strict=True)])

    def jacobians(self, y: Floats, p: Floats) -> Floats:
        """∂(dy/dt)/∂y at many points, shapes (N, n) and (N, m) to (N, n, n)."""
        return np.array([self.quick.jacobian(*both) for both in zip(p, y, strict=True)])

    @property
    def quick(self) -> PointFunctions:
        """The functions for one point at a time."""
        return NumericPointFunctions(self)


class NumericPointFunctions(PointFunctions):
    """A numeric flow at one point; not finite where the function has no value there."""

    def __init__(self, flow: Flow) -> None:
        self.flow, self.guards = flow, 0
        self._watch = None

    def rates(self, p: Floats, y: Floats) -> Floats:
        """dy/dt, shape (n,)."""
        return self._asked("call", p, y, (len(y),))

    def jacobian(self, p: Floats, y: Floats) -> Floats:
        """∂(dy/dt)/∂y, shape (n, n)."""
        return self._asked("slopes", p, y, (len(y), len(y)))

    def _asked(self, what: str, p: Floats, y: Floats, shape: tuple[int, ...]) -> Floats:
        try:
            found: Floats = getattr(self.flow.system, what)(y, p)
        except DomainError:
            return np.full(shape, np.nan)
        return found
