"""What integrators read: the motion's graph with work, pose and the guards that end a run."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import casadi as ca
import numpy as np

from ..algebra.program import Program
from ..base.types import Floats, fields_of
from ..bodies.contact import Contact
from ..bodies.contact_laws import Rough, law_class
from ..bodies.disk_equations import disk_system
from ..systems.system import System

POSE = ("phi", "psi", "centre_x", "centre_y")
"""Precession angle, relative spin angle, horizontal place of the centre; x̂ = (cos φ, sin φ)."""
POSE_UNIT = 1024.0
"""What the pose is counted in while it is integrated: it grows without bound, and an integrator
whose tolerance is relative to the largest entry of the state would grow careless with it."""
LIFT_OFF, FLAT, NO_CONTACT, CONE = "lift-off", "flat", "no-contact", "slip"
"""Names of the guards."""


@dataclass(frozen=True, eq=False)
class Flow:
    """The rates of an extended state y and the guards that must stay positive; dimensionless.

    y holds the law's own states, then the dissipated work, then the pose if asked.  The guards are
    functions of y: when the first of them reaches zero, the run has ended there.

    Examples
    --------
    >>> f = flow("viscous")
    >>> f.names
    ('theta', 'theta_dot', 'phi_dot', 'omega3', 'slip_x', 'slip_y', 'work')
    >>> list(f.guards)
    ['lift-off', 'flat', 'no-contact']
    """

    system: System
    """The disk under its law."""
    x: ca.SX
    """Symbols of y, shape (n,)."""
    p: ca.SX
    """Parameters: those of the system, then the sine of the angle that counts as flat."""
    rhs: ca.SX
    """dy/dt, shape (n,)."""
    guards: Mapping[str, ca.SX]
    """What must stay positive, by name."""
    names: tuple[str, ...]
    """Names of the entries of y."""
    friction: str = ""
    """The parameter in proportion to which slip decays, if there is one."""

    __getstate__ = fields_of

    @cached_property
    def rates(self) -> ca.Function:
        """CasADi function (y, p) → dy/dt."""
        return ca.Function("rates", [self.x, self.p], [self.rhs])

    @cached_property
    def jacobian(self) -> ca.Function:
        """CasADi function (y, p) → ∂(dy/dt)/∂y, dense, by automatic differentiation."""
        return ca.Function(
            "jacobian", [self.x, self.p], [ca.densify(ca.jacobian(self.rhs, self.x))]
        )

    @cached_property
    def _jacobian_program(self) -> Program:
        return Program(self.jacobian)

    def jacobians(self, y: Floats, p: Floats) -> Floats:
        """∂(dy/dt)/∂y at many points.

        Parameters
        ----------
        y, p
            States and parameters, shapes (N, n) and (N, m).

        Returns
        -------
        ndarray
            Shape (N, n, n).
        """
        if len(y) == 1:
            return self.quick.jacobian(p[0], y[0])[None]
        found: Floats = self._jacobian_program.arrays([list(y.T), list(p.T)], y.shape[:-1])[0]
        return found

    @cached_property
    def watch(self) -> ca.Function:
        """CasADi function (y, p) → guards and their rates along the motion."""
        values = ca.vertcat(*self.guards.values())
        return ca.Function(
            "watch", [self.x, self.p],
            [ca.vertcat(values, ca.jtimes(values, self.x, self.rhs))],
        )  # fmt: skip

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
        """Guards and their rates at many points.

        Parameters
        ----------
        y
            States, shape (…, n).
        p
            Parameters, shape (m,) or (…, m).

        Returns
        -------
        values, rates
            Shape (…, guards).
        """
        if y.ndim == 1:
            return self.quick.watch(p, y)
        arguments = [list(np.moveaxis(y, -1, 0)), list(np.moveaxis(p, -1, 0))]
        both = self._watch_program.arrays(arguments, y.shape[:-1])[0][..., 0]
        count = len(self.guards)
        return both[..., :count], both[..., count:]

    @property
    def quick(self) -> Quick:
        """The flow's functions for one point at a time, bound to memory of this thread."""
        held: dict[Flow, Quick] = _THREAD.__dict__.setdefault("held", {})
        if self not in held:
            held[self] = Quick(self)
        return held[self]

    def pack(self, six: Floats) -> Floats:
        """The state y at the start: the law's own states, no work done, pose at the origin.

        Parameters
        ----------
        six
            The six states, shape (…, 6).

        Returns
        -------
        ndarray
            Shape (…, n).
        """
        own = len(self.system.states)
        y = np.zeros((*six.shape[:-1], len(self.names)))
        y[..., :own] = six[..., :own]
        return y

    def six(self, y: Floats) -> Floats:
        """The six states in y; a law without slip in its state has none.

        Parameters
        ----------
        y
            Shape (…, n).

        Returns
        -------
        ndarray
            Shape (…, 6).
        """
        own = len(self.system.states)
        if own == 6:
            return y[..., :6]
        return np.concatenate([y[..., :own], np.zeros((*y.shape[:-1], 6 - own))], axis=-1)


class Quick:
    """A flow as fast functions of one point, without a conversion on the way; for one thread.

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
        found: Floats = self._rates(y)
        return found

    def jacobian(self, p: Floats, y: Floats) -> Floats:
        """∂(dy/dt)/∂y, shape (n, n)."""
        if self._jacobian is None:
            n = len(self.flow.names)
            self._jacobian = _bound(self.flow.jacobian, self.p, n, (n, n))
        self.p[:] = p
        found: Floats = self._jacobian(y)
        return found

    def watch(self, p: Floats, y: Floats) -> tuple[Floats, Floats]:
        """Guards and their rates, shape (guards,) each."""
        if self._watch is None:
            return np.empty(0), np.empty(0)
        self.p[:] = p
        both = self._watch(y)
        return both[: self.guards], both[self.guards :]


class Evaluator:
    """One launch's equations as an integrator wants them: functions of (t, y).

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
        # stretched time has a pace of its own
        self.paced = flow.names[3] == "omega3" and flow.names[-1] != "time"

    def rates(self, _t: float, y: Floats) -> Floats:
        """dy/dt, shape (n,)."""
        return self._quick.rates(self.p, y)

    def jacobian(self, _t: float, y: Floats) -> Floats:
        """∂(dy/dt)/∂y, shape (n, n)."""
        return self._quick.jacobian(self.p, y)

    def watch(self, y: Floats) -> tuple[Floats, Floats]:
        """Guards and their rates, shape (guards,) each."""
        return self._quick.watch(self.p, y)


_THREAD = threading.local()
CASADI = threading.RLock()
"""Held while a motion is made: CasADi's objects are not for several threads at once."""
ASKING = threading.Lock()
"""Held by the worker of a motion that asks CasADi something: the solvers of a process share its
standard error."""


def _bound(function: ca.Function, p: Floats, n: int, shape: tuple[int, ...]) -> Any:
    """A CasADi function of (y, p) bound to memory of its own."""
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


def moving_system(law: str | type[Contact]) -> System:
    """The disk with every state that a motion has: the smooth disk's slip too.

    Parameters
    ----------
    law
        A key of `stability.bodies.contact_laws.MOTION_LAWS`, or the class of a law.

    Returns
    -------
    System

    Examples
    --------
    >>> len(moving_system("smooth").states), len(moving_system("rough").states)
    (6, 4)
    """
    contact = law_class(law)
    return disk_system(contact, slip_states=None if issubclass(contact, Rough) else True)


def flow(law: str | type[Contact], *, pose: bool = False, sticking: bool = False) -> Flow:
    """The flow of the disk under a contact law; built once for each.

    Parameters
    ----------
    law
        A key of `stability.bodies.contact_laws.MOTION_LAWS`, or the class of a law; one that
        sticks is taken for its sliding.
    pose
        Whether φ, ψ and the centre's place are carried along.
    sticking
        Whether this is the sticking of `coulomb`: the rough disk with a guard that keeps the force
        inside the friction cone.

    Returns
    -------
    Flow
    """
    return _flow(law_class(law), bool(pose), bool(sticking))  # type: ignore[arg-type]  # a class is hashable


@lru_cache(maxsize=32)
def _flow(law: type[Contact], pose: bool, sticking: bool) -> Flow:  # noqa: FBT001
    if sticking:
        system = disk_system("rough")
        mu = ca.SX.sym("mu")
        parameters = ca.vertcat(system.p, mu)
    else:
        system = moving_system(law)
        mu, parameters = ca.SX(0), system.p
    x = system.x
    seen = system.observables
    work = ca.SX.sym("work")
    columns, rates, names = [x, work], [system.rhs, seen["power"]], [*system.states, "work"]
    if pose:
        extra = ca.SX.sym("pose", len(POSE))
        columns.append(extra)
        rates.append(_pose_rates(x, seen["slip"], extra))
        names += POSE
    flat = ca.SX.sym("flat")
    normal = seen["normal_force"]
    # gn D has the sign of gn, and stays finite where D vanishes
    guards = {LIFT_OFF: normal * seen["determinant"], FLAT: ca.sin(x[0]) - flat}
    if sticking:
        guards[CONE] = (mu * normal) ** 2 - ca.sumsqr(seen["contact_force"])
    if not sticking and ca.depends_on(seen["determinant"], x[4:]):
        # viscous friction pushes D away from zero while gn D is positive, but both may reach zero
        # together (stability/integrators/painleve.py)
        guards[NO_CONTACT] = seen["determinant"]
    return Flow(
        system, ca.vertcat(*columns), ca.vertcat(parameters, flat), ca.vertcat(*rates), guards,
        tuple(names), law.symbols()[0] if law.relaxes and not sticking else "",
    )  # fmt: skip


def _pose_rates(x: ca.SX, slip: ca.SX, pose: ca.SX) -> ca.SX:
    """φ̇, ψ̇ = ω₃ − φ̇ cosθ, and ṡ = vA − ω×a turned by φ."""
    theta, theta_dot, phi_dot, omega3 = (x[i] for i in range(4))
    along_x = slip[0] + theta_dot * ca.sin(theta)
    along_y = slip[1] - omega3
    heading = POSE_UNIT * pose[0]
    cosine, sine = ca.cos(heading), ca.sin(heading)
    rates = ca.vertcat(
        phi_dot,
        omega3 - phi_dot * ca.cos(theta),
        cosine * along_x - sine * along_y,
        sine * along_x + cosine * along_y,
    )
    return rates / POSE_UNIT
