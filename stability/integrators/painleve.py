"""The end of contact where D is small: lift-off, or gn D and D running to zero together.

gn = N/D with N and D smooth.  In stretched time, dt = D dσ, the motion is smooth through D = 0,
and near D = N = 0 it obeys

    D' = d₀ D + β N,   N' = n₀ D + n₁ N

(for the viscous law β = mu (k + 1)).  Two real negative eigenvalues ρ₂ < ρ₁ with the direction of
ρ₁ inside the quadrant D, N > 0 attract an open set of motions: D and N reach zero after a finite
time, and gn tends to (ρ₁ - d₀)/β > 0.  Contact then ends with a positive normal force: no lift-off.
(F. Génot & B. Brogliato, Eur. J. Mech. A/Solids 18 (1999) 653-677, for the planar rod;
tests/integrators/test_painleve.py derives it for the disk.)

Plain time is singular there, so that an integrator's N changes sign by its own error.  A run that
ends with D small is therefore run again in stretched time, from its last sample on.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import casadi as ca
import numpy as np

from ..algebra.eigensolver import eigenpairs
from ..base.types import Floats
from ..bodies.model import CREEP_ENDS, NO_CONTACT
from .flow import Flow
from .leg import UNRESOLVED, End, Leg, Path
from .scipy_methods import FINEST
from .scipy_methods import integrate as integrate_scipy

SMALL = 0.1
"""D over its value without slip below which an end is examined again."""
NARROW = 1e-10
"""D at which the linear equations in stretched time decide; their error is of that size."""
STRETCHED = 1e12
"""Longest stretched time."""
OPEN_END = "open end"
"""Kind of an end on which two routes do not agree."""
CLOSE = 1e-2
"""D over its value without slip below which a run that gave up may have been near D = 0."""


@dataclass(frozen=True)
class Approach:
    """A motion near D = N = 0, by its linear equations in stretched time."""

    rates: tuple[complex, complex]
    """Eigenvalues, the larger real part first."""
    normal: float
    """The normal force to which gn tends, if D and N run to zero together; otherwise 0."""
    state: tuple[float, float]
    """D and gn at the point."""

    @property
    def together(self) -> bool:
        """Whether D and N reach zero together, with gn > 0."""
        return self.normal > 0

    @property
    def left(self) -> float:
        """Time until both reach zero together."""
        return self.state[0] / -self.rates[0].real

    @property
    def sentence(self) -> str:
        """The evidence, where both reach zero together."""
        d, gn = self.state
        return (
            f"gn D and D run to zero together: D = {d:.1e}, {self.left:.1e} before "
            f"it vanishes, and gn = {gn:.6g} stays positive, with the limit {self.normal:.6g}; no "
            "contact force is determined beyond"
        )


@lru_cache(maxsize=8)
def stretched_flow(flow: Flow, least: float = NARROW) -> Flow:
    """A sliding flow in stretched time, dt = D dσ, with the time as its last state.

    The force of its law is proportional to gn; the motion ends where D is `least`.
    """
    d = flow.system.observables["determinant"]
    guards = {n: g for n, g in flow.guards.items() if n != CREEP_ENDS} | {NO_CONTACT: d - least}
    return flow.having(
        x=ca.vertcat(flow.x, ca.SX.sym("time")),
        rhs=ca.vertcat(d * flow.rhs, d),
        guards=guards,
        names=(*flow.names, "time"),
    )


@lru_cache(maxsize=8)
def _slopes(flow: Flow) -> ca.Function:
    """(y, p) → D and N, their gradients, the Jacobian in stretched time, and D without slip."""
    system = flow.system
    d = system.observables["determinant"]
    still = ca.substitute(d, system.observables["slip"], ca.SX.zeros(2))
    both = ca.vertcat(d, system.observables["normal_force"] * d)
    return ca.Function(
        "slopes",
        [flow.x, flow.p],
        [
            both,
            ca.densify(ca.jacobian(both, system.x)),
            ca.densify(ca.jacobian(d * system.rhs, system.x)),
            still,
        ],
    )


def approach(flow: Flow, y: Floats, p: Floats) -> Approach:
    """Linear equations of a motion that is close to D = N = 0, both positive, and its limit.

    Source: module docstring.
    """
    both, gradients, jacobian, _ = (np.array(part) for part in _slopes(flow)(y, p))
    # to leading order ∇(D, N) J = M ∇(D, N), since J = f₀ ∇Dᵀ + f₁ ∇Nᵀ there
    matrix = np.linalg.lstsq(gradients.T, (gradients @ jacobian).T, rcond=None)[0].T
    rates, vectors = eigenpairs(matrix.astype(float))
    order = np.argsort(-rates.real)
    slow, fast = (complex(r) for r in rates[order])
    shares = np.linalg.solve(vectors[:, order], both.ravel().astype(complex))
    along = (vectors[:, order[0]] * shares[0]).real
    attracts = slow.imag == 0 and fast.real < slow.real < 0
    normal = float(along[1] / along[0]) if attracts and (along > 0).all() else 0.0
    d, n = (float(v) for v in both.ravel())
    return Approach((slow, fast), normal, (d, n / d))


def small(flow: Flow, y: Floats, p: Floats) -> float | None:
    """D over its value without slip (k + cos²θ of a disk); None where no friction moves D."""
    if "mu" not in flow.system.parameters or NO_CONTACT not in flow.guards:
        return None
    slopes = _slopes(flow)(y, p)
    return float(slopes[0][0]) / float(slopes[3])


def closer(leg: Leg, path: Path) -> tuple[Path, str] | None:
    """A path that ended with D small, its end found in stretched time from the last sample on.

    The end is of kind `OPEN_END` where the motion in stretched time contradicts the integrator.
    The evidence is empty where the guard's value is enough.  None where D is not small at the end,
    or stretched time decides nothing, so that the integrator's end is kept.
    """
    assert path.end is not None
    share = small(leg.flow, path.end.state, leg.p)
    if share is None or share > (CLOSE if path.end.kind == UNRESOLVED else SMALL):
        return None
    # a coarse step may have put the last samples beyond D = 0
    count = len(path.states)
    while count and (small(leg.flow, path.states[count - 1], leg.p) or 0.0) <= NARROW:
        count -= 1
    if not count:
        return None
    final = path.end
    path = replace(path, states=path.states[:count])
    first = np.append(path.states[-1], leg.times[count - 1])
    stretched = _stretched(leg, stretched_flow(leg.flow), first, leg.times[count:])
    last = stretched.end
    if last is not None and last.kind == NO_CONTACT:
        end = End(NO_CONTACT, float(last.state[-1]), last.state[:-1])
        fate = approach(leg.flow, end.state, leg.p)
        if fate.together:
            rates = np.array(leg.flow.rates(end.state, leg.p)).ravel()
            speed = float((np.abs(rates) / np.maximum(1.0, np.abs(end.state))).max())
            end = replace(end, early=fate.left, short=2 * fate.left * speed)
            return _extended(path, stretched, end), fate.sentence
        rest = leg.times[count + len(stretched.states) :]
        on = _stretched(leg, stretched_flow(leg.flow, 0.0), last.state, rest)
        last = on.end
        if last is not None and last.kind == NO_CONTACT:
            why = f"D = {NARROW:.1e} runs to zero, and the contact force grows without bound"
            off = np.abs(last.state[:-1] - end.state) / np.maximum(1.0, np.abs(end.state))
            end = replace(end, early=float(last.state[-1]) - end.time, short=float(off.max()))
            return _extended(path, stretched, end), why
        stretched = on
    if last is not None and last.kind != UNRESOLVED:
        end = End(last.kind, float(last.state[-1]), last.state[:-1])
        return _extended(path, stretched, end), ""
    if last is not None or final.kind == UNRESOLVED:
        return None
    why = (
        "gn D and D come close to zero together, and in stretched time the motion goes on: its end "
        "is not determined at this tolerance"
    )
    return replace(path, end=replace(final, kind=OPEN_END)), why


def _stretched(leg: Leg, which: Flow, start: Floats, times: Floats) -> Path:
    """A motion in stretched time, sampled at plain times up to the last of them."""
    span = np.array([0.0, STRETCHED])
    run = Leg(which, leg.p, start, span, FINEST, leg.max_steps, leg.seconds)
    return integrate_scipy(run, solver="LSODA", clock=times)


def _extended(path: Path, stretched: Path, end: End) -> Path:
    """The path to a new end, with the samples that the run in stretched time added."""
    return Path(
        np.vstack([path.states, stretched.states[:, :-1]]), end, path.steps + stretched.steps
    )
