"""Long rolling with slip: the slow drift of tilt and spin on the centre manifold.

Straight rolling beyond its threshold is spectrally stable, with two zero eigenvalues: the spin, and
a slow circling with a tilt.  Both drift, the tilt at the rate of its cube, until the threshold is
crossed (`stability.boundary.drift`).  The closed forms near a steady motion lose this after a time
of 1/tilt².  The drift keeps it at any time before the threshold, at the same cost.

Of a body that is alike on both sides of its equator the rates are a(w) α³ and b(w) α², with a and
b from its graph at a small tilt.  Then ln α is the integral of a/b over the spin, and the time that
of 1/(b α²).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ...base.types import Floats
from ...bodies.contact_laws import LinearViscous, Viscous
from .elements import Elements, chebyshev
from .near_steady import SAMPLES, ModalMotion, modes, modes_of, rates_at, slope_at
from .track import LaunchProblem, Refused, Track, relative

DRIFT, ROLLING = "drift", "rolling"
"""Name of the rung, and of the family that drifts."""
ZERO = 1e-9
"""Size of an eigenvalue, over the largest, below which it is one of the two zeros."""
LOOKS, TURNS, NEWTON = 5, 3, 30
"""Times at which the error is estimated; corrections of the manifold there; steps for the spin."""
SAFETY = 2.0
"""Factor on the estimate, for higher powers of the tilt."""
FADED = 12.0
"""Exponent of decay after which the fast modes have faded."""
REFERENCE, CHORDS = 1e-2, 6
"""Tilt at which rates are found, with half of it for their limit; corrections of the manifold."""
NODES, REACHES = 10, 12
"""Spins at which rates are found; intervals of the spin that are tried."""
RESOLVED, UNEVEN = 1e-6, 1e-4
"""Largest last coefficient of the rates as a function of the spin; largest difference of the rates
of two opposite tilts of a body that is alike on both sides; both relative."""
STEP = 1e-4
"""Relative step of the spin for the slope of the circling mode."""


@dataclass(frozen=True, eq=False)
class SlowManifold:
    """Tilt and spin with their drift, as functions of the spin."""

    tilt: float
    """Tilt θ - π/2 on the slow manifold at the start [rad]."""
    spin: float
    """ω₃ there."""
    reach: float
    """Change of the spin over the interval that is known."""
    nodes: Floats
    """Time, ln |tilt|, a and b at the Chebyshev points of the interval, shape (NODES, 4)."""

    def _seen(self, share: Floats) -> Floats:
        """Time, ln |tilt|, a and b at shares of the interval, shape (t, 4)."""
        return Elements(np.array([0.0, 1.0]), NODES).at(share, self.nodes[None])

    def at(self, times: Floats) -> tuple[Floats, Floats]:
        """Tilt and spin at times, shape (t,)."""
        share = np.interp(times, self.nodes[:, 0], chebyshev(NODES)[0])
        for _ in range(NEWTON):
            time, log, _, b = self._seen(share).T
            share = np.clip(share - (time - times) * b * np.exp(2 * log) / self.reach, 0.0, 1.0)
        return np.sign(self.tilt) * np.exp(self._seen(share)[:, 1]), self.spin + share * self.reach

    def rates(self, tilt: Floats, spin: Floats) -> tuple[Floats, Floats]:
        """Rates of tilt and spin."""
        share = (np.atleast_1d(spin) - self.spin) / self.reach
        a, b = self._seen(share)[:, 2:].T.reshape(2, *np.shape(spin))
        return a * tilt**3, b * tilt**2


def _manifold(problem: LaunchProblem, tilt: float, spin: float) -> SlowManifold | Refused:
    """The drift of a body up to the horizon, on an interval of the spin that is found."""
    first = _coefficients(problem, np.array([spin]))
    if isinstance(first, Refused):
        return first
    reach = 2 * float(first[0, 1]) * tilt**2 * problem.last
    why = Refused("its drift is not resolved")
    points, derivative, _ = chebyshev(NODES)
    integral = np.zeros((NODES, NODES))
    integral[1:, 1:] = np.linalg.inv(derivative[1:, 1:])
    low, high = 0.0, np.inf  # an interval that is known, and one that is too long
    for _ in range(REACHES):
        coefficients = _coefficients(problem, spin + reach * points)
        resolved = not isinstance(coefficients, Refused)
        if isinstance(coefficients, Refused):
            why = coefficients
        else:
            a, b = coefficients.T
            log = np.log(abs(tilt)) + reach * integral @ (a / b)
            time = reach * integral @ (1 / (b * np.exp(2 * log)))
            shares = np.stack([a / a[0], b / b[0]], -1)
            resolved = Elements(np.array([0.0, 1.0]), NODES).tails(shares[None]).max() < RESOLVED
            if resolved and time[-1] >= problem.last:
                return SlowManifold(tilt, spin, reach, np.stack([time, log, a, b], axis=-1))
        low, high = (abs(reach), high) if resolved else (low, abs(reach))
        reach = np.copysign(2 * low if np.isinf(high) else (low + high) / 2, reach)
    return why


def _coefficients(problem: LaunchProblem, spins: Floats) -> Floats | Refused:
    """Both coefficients a and b at spins, shape (s, 2), to fourth order in the reference tilt."""
    step = STEP * np.abs(spins)
    every = [_here(problem, spin) for spin in np.concatenate([spins, spins + step, spins - step])]
    members = [here for here in every if here is not None and here.decays]
    if len(members) < len(every):
        return Refused("the drift ends before the horizon, where rolling no longer decays")
    member, slow, follow, mode = (
        np.stack([getattr(here, n) for here in members])
        for n in ("member", "slow", "follow", "circling")
    )
    many = len(spins)
    slow, follow = slow[:many, None], follow[:many, None]
    bend = ((mode[many : 2 * many] - mode[2 * many :]) / (2 * step[:, None]))[:, None]
    tilts = np.array([REFERENCE, REFERENCE / 2, -REFERENCE])[:, None]
    first = member[:many, None] + tilts * mode[:many, None]
    e = moving = np.zeros_like(first)
    for _ in range(CHORDS):
        rates = rates_at(problem, first + e)
        moving = (slow @ rates[..., None])[..., 1, :] * tilts * bend
        e = e - (follow @ (rates - moving)[..., None])[..., 0]
    true = (slow @ (rates_at(problem, first + e) - moving)[..., None])[..., 0]
    large, small, other = np.moveaxis(true / np.hstack([tilts**3, tilts**2]), 1, 0)
    if not (np.abs(large - other) <= UNEVEN * np.abs(large)).all():
        return Refused("its drift is known for bodies alone that are alike on both sides")
    coefficients: Floats = (4 * small - large) / 3
    return coefficients


def drifting(problem: LaunchProblem) -> Track | Refused:
    """The track of a rolling body that drifts, and of its fast modes while they decay."""
    if problem.launches.law not in (Viscous, LinearViscous):
        return Refused("no rolling drifts under this law")
    near = problem.near
    if near.member is None and near.family:
        return Refused(f"near {near.family} the heading turns without end: no drift follows it")
    if near.member is None or near.family != ROLLING:
        return Refused(f"the nearest steady motion is {near.family or 'unknown'}, not rolling")
    if near.member[0] != np.pi / 2:
        return Refused(
            f"the body leans by {np.pi / 2 - near.member[0]:.3g} rad as it rolls, where "
            "no drift is known"
        )
    motion = modes(problem, near.member, near.family)
    if isinstance(motion, Refused):
        return motion
    zero = np.abs(motion.values) < ZERO * np.abs(motion.values).max()
    if zero.sum() != 2 or not (motion.values[~zero].real < 0).all():
        return Refused("rolling has not two zero eigenvalues and decaying ones")
    slow, fast = _split(motion, zero)
    tilt, spin = float(slow[0]), float(motion.member[3] + slow[1])
    if not tilt:
        return Refused("it does not lean: nothing drifts")
    drift = _manifold(problem, tilt, spin)
    where = {"tilt": abs(tilt)}
    return drift if isinstance(drift, Refused) else _track(problem, motion, drift, fast, where)


def _split(motion: ModalMotion, zero: Floats) -> tuple[Floats, Floats]:
    """Tilt and change of spin on the slow manifold, and the fast modes of the start."""
    first = np.where(zero, motion.first, 0)
    slow = (motion.vectors @ first).real
    return slow[[0, 3]], np.where(zero, 0, motion.first)


def _track(
    problem: LaunchProblem,
    start: ModalMotion,
    manifold: SlowManifold,
    fast: Floats,
    where: dict[str, float],
) -> Track | Refused:
    looks = problem.last * (np.arange(1, LOOKS + 1) / LOOKS)
    sizes, mode, moved = np.empty(LOOKS), np.empty((LOOKS + 1, 6)), np.empty((LOOKS + 1, 6))
    every = np.append(0.0, looks)
    for i, (tilt, spin) in enumerate(zip(*manifold.at(every), strict=True)):
        here = _here(problem, float(spin))
        if here is None:
            return Refused("rolling has not two zero eigenvalues on the way", where)
        mode[i] = here.circling
        moved[i] = np.abs(here.values[:, None] - start.values).min(axis=0)
        if i:
            sizes[i - 1] = _size(problem, here, manifold, (float(tilt), float(spin)), mode[i])
    size = SAFETY * (np.maximum.accumulate(sizes) + _offset(start, manifold, problem.last))
    size += _phase(problem, start, fast, every, moved)
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
    return Track(times, at(times), errors, at, notes=(note,), indicators=where)


@dataclass(frozen=True, eq=False)
class LinearRolling:
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

    @property
    def decays(self) -> bool:
        """Whether all other modes decay."""
        return bool((self.values[~self.zero].real < 0).all())

    @cached_property
    def slow(self) -> Floats:
        """Matrix that gives tilt and spin of the part that does not decay, shape (2, 6)."""
        matrix: Floats = (self.vectors[:, self.zero] @ self.back[self.zero]).real[[0, 3]]
        return matrix

    @cached_property
    def follow(self) -> Floats:
        """Matrix from rates to a displacement with these linear rates, in the modes that decay."""
        over = np.where(self.zero, 0, 1 / np.where(self.zero, 1, self.values))
        matrix: Floats = (self.vectors * over @ self.back).real
        return matrix


def _offset(start: ModalMotion, manifold: SlowManifold, last: float) -> float:
    """Second order of the start in tilt and spin: that of the motion, less the drift itself."""
    decay = float(-start.values.real[np.abs(start.values.real) > ZERO].max())
    early = min(last, FADED / decay)
    second = start.states(start.second(np.array([early])))[0]
    tilt, spin = manifold.rates(np.array(manifold.tilt), np.array(manifold.spin))
    second[0] -= tilt * early
    second[3] -= spin * early
    return float(relative(second, start.member))


def _phase(
    problem: LaunchProblem, start: ModalMotion, fast: Any, every: Floats, moved: Floats
) -> Floats:
    """Error of the fast modes: their rates change by tilt, spin and their own size.

    They may decay so slowly that a small change of a frequency is a large phase in the end.
    `moved` says by how much the drift of the spin has moved each rate at each time of `every`,
    shape (t, 6).
    """
    kept = np.where(fast == 0, 0.0, 1.0)
    shares = np.arange(1, SAMPLES + 1) / SAMPLES
    times, third = start.only(kept).third(problem.last * shares**2)
    slow = start.member + (start.vectors @ np.where(kept == 0, start.first, 0)).real
    there = np.linalg.eigvals(problem.flow.system.linearise(slow, problem.p))
    apart = np.abs(there[:, None] - start.values).min(axis=0)
    apart = apart + np.stack([np.interp(times, every, m) for m in moved.T], axis=-1)
    lost = np.exp(np.multiply.outer(times, start.values)) * fast * apart * times[:, None]
    error = third + SAFETY * relative(np.abs(lost) @ np.abs(start.vectors).T, start.member)
    error = np.append(0.0, np.maximum.accumulate(error))
    along: Floats = np.interp(every[1:], np.append(0.0, times), error)
    return along


def _here(problem: LaunchProblem, spin: float) -> LinearRolling | None:
    """The linear motion about rolling at a spin; None where not exactly two modes are zero."""
    member = np.array([np.pi / 2, 0.0, 0.0, spin, 0.0, 0.0])
    values, vectors, back = modes_of(slope_at(problem, member))
    zero = np.abs(values) < ZERO * np.abs(values).max()
    if zero.sum() != 2 or back is None:
        return None
    return LinearRolling(member, values, vectors, back, zero)


def _size(
    problem: LaunchProblem,
    here: LinearRolling,
    manifold: SlowManifold,
    place: tuple[float, float],
    mode: Floats,
) -> float:
    """Error at a point: what the fast modes follow, and the relative error of the drift so far."""
    tilt, spin = place
    rates = manifold.rates(np.array(tilt), np.array(spin))
    moving = rates[0] * mode + rates[1] * np.eye(6)[3]
    e, first = np.zeros(6), here.member + tilt * mode
    for _ in range(TURNS):
        defect = rates_at(problem, first + e) - moving
        e = e - here.follow @ defect
    true = here.slow @ rates_at(problem, first + e)
    off = np.abs(true - np.array(rates)) / np.maximum(np.abs(rates), 1e-300)
    gone = np.array([tilt - manifold.tilt, spin - manifold.spin])
    return float(relative(e, first)) + float(np.abs(off * gone).max())
