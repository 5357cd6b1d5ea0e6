"""Long rolling with slip: the slow drift of tilt and spin on the centre manifold, in closed form.

Straight rolling beyond its threshold is spectrally stable, with two zero eigenvalues: the spin, and
a slow circling with a tilt.  Both drift, the tilt at the rate of its cube, until the threshold is
crossed (`stability.boundary.drift`).  The closed forms near a steady motion lose this after a time
of 1/tilt².  The drift keeps it at any time before the threshold, at the same cost.

With C = α²(2(2k+1)w² - 1)/w² constant, the spin obeys
(2k+1)w² - ln w = (2k+1)w0² - ln w0 - C t/(mu (2k+1)³).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ...algebra.eigensolver import eigenpairs
from ...base.types import Floats
from ...bodies.contact_laws import LinearViscous, Viscous
from ...boundary.drift import FORMULAS
from .near_steady import SAMPLES, Modes, modes
from .track import Problem, Refused, Track, relative

DRIFT, ROLLING = "drift", "rolling"
"""Name of the rung, and of the family that drifts."""
SOURCE = FORMULAS["time"]
"""The formula of `stability.boundary.drift` that the closed form inverts."""
ZERO = 1e-9
"""Size of an eigenvalue, over the largest, below which it is one of the two zeros."""
MARGIN = 0.1
"""Share of the spin's way to the threshold that must be left at the horizon."""
LOOKS, TURNS, NEWTON = 5, 3, 30
"""Times at which the error is estimated; corrections of the manifold there; steps for the spin."""
SAFETY = 2.0
"""Factor on the estimate, for higher powers of the tilt."""
FADED = 12.0
"""Exponent of decay after which the fast modes have faded."""


@dataclass(frozen=True, eq=False)
class SlowManifold:
    """Tilt and spin at the start, with the numbers that their drift depends on."""

    k: float
    """Inertia factor."""
    mu: float
    """Friction."""
    tilt: float
    """Tilt θ - π/2 on the slow manifold at the start [rad]."""
    spin: float
    """ω₃ there."""

    def at(self, times: Floats) -> tuple[Floats, Floats]:
        """Tilt and spin at times, shape (t,)."""
        many, w0 = 2 * self.k + 1, abs(self.spin)
        kept = self.tilt**2 * (2 * many * w0**2 - 1) / w0**2
        goal = many * w0**2 - np.log(w0) - kept * times / (self.mu * many**3)
        w = np.full(times.shape, w0)
        for _ in range(NEWTON):  # convex and rising: Newton's method converges from above
            w = w - (many * w**2 - np.log(w) - goal) / (2 * many * w - 1 / w)
        tilt = np.sign(self.tilt) * np.sqrt(kept * w**2 / (2 * many * w**2 - 1))
        return tilt, np.sign(self.spin) * w

    def rates(self, tilt: Floats, spin: Floats) -> tuple[Floats, Floats]:
        """Rates of tilt and spin."""
        many = 2 * self.k + 1
        common = 1 / (self.mu * spin * many**3)
        return common / (spin * (2 * many * spin**2 - 1)) * tilt**3, -common * tilt**2

    @property
    def crossing(self) -> float:
        """The time at which the spin reaches the threshold."""
        many, w0, wc = 2 * self.k + 1, abs(self.spin), 1 / np.sqrt(2 * self.k)
        kept = self.tilt**2 * (2 * many * w0**2 - 1) / w0**2
        way = many * (w0**2 - wc**2) - np.log(w0 / wc)
        return float(self.mu * many**3 * way / kept) if kept else np.inf


def drifting(problem: Problem) -> Track | Refused:
    """The track of a rolling disk that drifts, and of its fast modes while they decay.

    Parameters
    ----------
    problem
        The problem.

    Returns
    -------
    Track or Refused
    """
    if not problem.thin:
        return Refused("the drift of rolling is known in closed form for a disk alone")
    if problem.launches.law not in (Viscous, LinearViscous):
        return Refused("no rolling drifts under this law")
    near = problem.launches.settling.closest(problem.start, problem.p)
    if near.member is None or near.family != ROLLING:
        return Refused(f"the nearest steady motion is {near.family or 'unknown'}, not rolling")
    k, mu = (float(v) for v in problem.p[:2])
    if 2 * k * near.at**2 <= 1:
        return Refused("rolling is below its threshold, where nothing lasts")
    found = modes(problem, near.member, near.family)
    if isinstance(found, Refused):
        return found
    zero = np.abs(found.values) < ZERO * np.abs(found.values).max()
    if zero.sum() != 2 or not (found.values[~zero].real < 0).all():
        return Refused("rolling has not two zero eigenvalues and decaying ones")
    slow, fast = _split(found, zero)
    manifold = SlowManifold(k, mu, float(slow[0]), float(found.member[3] + slow[1]))
    where = {"time of crossing the threshold": manifold.crossing, "tilt": abs(manifold.tilt)}
    if problem.last > (1 - MARGIN) * manifold.crossing:
        return Refused(
            f"the drift crosses the threshold at {problem.when(manifold.crossing)}", where
        )
    return _track(problem, found, manifold, fast, where)


def _split(found: Modes, zero: Floats) -> tuple[Floats, Floats]:
    """Tilt and change of spin on the slow manifold, and the fast modes of the start."""
    first = np.where(zero, found.first, 0)
    slow = (found.vectors @ first).real
    return slow[[0, 3]], np.where(zero, 0, found.first)


def _track(
    problem: Problem, start: Modes, manifold: SlowManifold, fast: Floats,
    where: dict[str, float],
) -> Track | Refused:  # fmt: skip
    looks = problem.last * (np.arange(1, LOOKS + 1) / LOOKS)
    sizes, mode = np.empty(LOOKS), np.empty((LOOKS + 1, 6))
    every = np.append(0.0, looks)
    for i, (tilt, spin) in enumerate(zip(*manifold.at(every), strict=True)):
        here = _here(problem, float(spin))
        if here is None:
            return Refused("rolling has not two zero eigenvalues on the way", where)
        mode[i] = here.circling
        if i:
            sizes[i - 1] = _size(problem, here, manifold, (float(tilt), float(spin)), mode[i])
    size = SAFETY * (np.maximum.accumulate(sizes) + _offset(start, manifold, problem.last))
    size += _phase(problem, start, fast, looks)
    if not (np.isfinite(size).all() and size.max() < 0.1):
        return Refused("the tilt is too large for the drift to leading order", where)
    spins = manifold.at(every)[1]

    def at(times: Floats) -> Floats:
        tilt, spin = manifold.at(times)
        states = np.zeros((len(times), 6))
        states[:, 0], states[:, 3] = np.pi / 2, spin
        order = np.argsort(spins)  # modes as a function of the spin, which falls
        for j in range(6):
            states[:, j] += tilt * np.interp(spin, spins[order], mode[order, j])
        moving = np.exp(np.multiply.outer(times, start.values)) * fast
        return states + start.states(moving)

    times = problem.times
    errors = np.interp(times, every, np.append(size[0], size))
    note = f"drift from omega3 = {manifold.spin:.6g} to {spins[-1]:.6g} (dimensionless)"
    return Track(times, at(times), errors, at, None, 0, (note,), where)


@dataclass(frozen=True, eq=False)
class Linear:
    """The linear motion about rolling at one spin."""

    member: Floats
    """The rolling motion, shape (6,)."""
    values: Any
    """Eigenvalues, shape (6,)."""
    vectors: Any
    """Modes as columns, shape (6, 6)."""
    back: Any
    """Their inverse."""
    zero: Any
    """Which two modes do not decay, shape (6,)."""

    @property
    def circling(self) -> Floats:
        """The zero mode with tilt 1 and no change of spin, shape (6,)."""
        basis = self.vectors[:, self.zero].real
        mode: Floats = basis @ np.linalg.solve(basis[[0, 3]], np.array([1.0, 0.0]))
        return mode


def _offset(start: Modes, manifold: SlowManifold, last: float) -> float:
    """Second order of the start in tilt and spin: that of the motion, less the drift itself."""
    decay = float(-start.values.real[np.abs(start.values.real) > ZERO].max())
    early = min(last, FADED / decay)
    second = start.states(start.second(np.array([early])))[0]
    tilt, spin = manifold.rates(np.array(manifold.tilt), np.array(manifold.spin))
    second[0] -= tilt * early
    second[3] -= spin * early
    return float(relative(second, start.member))


def _phase(problem: Problem, start: Modes, fast: Any, looks: Floats) -> Floats:
    """Error of the fast modes: their rates change by the slow tilt, and by their own size.

    They may decay so slowly that a small change of a frequency is a large phase in the end.
    """
    kept = np.where(fast == 0, 0.0, 1.0)
    shares = np.arange(1, SAMPLES + 1) / SAMPLES
    times, own = start.only(kept).third(problem.last * shares**2)
    slow = start.member + (start.vectors @ np.where(kept == 0, start.first, 0)).real
    there = np.linalg.eigvals(problem.flow.system.linearise(slow, problem.p))
    apart = np.abs(there[:, None] - start.values).min(axis=0)
    lost = np.exp(np.multiply.outer(times, start.values)) * fast * apart * times[:, None]
    error = own + SAFETY * relative(np.abs(lost) @ np.abs(start.vectors).T, start.member)
    error = np.append(0.0, np.maximum.accumulate(error))
    found: Floats = np.interp(looks, np.append(0.0, times), error)
    return found


def _here(problem: Problem, spin: float) -> Linear | None:
    """The linear motion about rolling at a spin; None where not exactly two modes are zero."""
    member = np.array([np.pi / 2, 0.0, 0.0, spin, 0.0, 0.0])
    values, vectors = eigenpairs(problem.flow.system.linearise(member, problem.p))
    zero = np.abs(values) < ZERO * np.abs(values).max()
    if zero.sum() != 2:
        return None
    return Linear(member, values, vectors, np.linalg.inv(vectors), zero)


def _size(
    problem: Problem, here: Linear, manifold: SlowManifold, place: tuple[float, float], mode: Floats
) -> float:
    """Error at a point: what the fast modes follow, and the relative error of the drift so far."""
    tilt, spin = place
    back = np.where(here.zero[:, None], 0, here.back)
    rates = manifold.rates(np.array(tilt), np.array(spin))
    moving = rates[0] * mode + rates[1] * np.eye(6)[3]
    over = back / np.where(here.zero, 1, here.values)[:, None]
    e, first = np.zeros(6), here.member + tilt * mode
    for _ in range(TURNS):
        defect = problem.flow.system.rates(first + e, problem.p) - moving
        e = e - (here.vectors @ (over @ defect)).real
    found = np.where(here.zero, here.back @ problem.flow.system.rates(first + e, problem.p), 0)
    true = (here.vectors @ found).real[[0, 3]]
    off = np.abs(true - np.array(rates)) / np.maximum(np.abs(rates), 1e-300)
    gone = np.array([tilt - manifold.tilt, spin - manifold.spin])
    return float(relative(e, first)) + float(np.abs(off * gone).max())
