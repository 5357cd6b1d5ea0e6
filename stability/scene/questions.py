"""What a scene may ask of a motion: each quantity with its error, from the track of any model."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..base.quantities import Kind
from ..base.types import Floats
from ..bodies.round_body.pole_equations import AXIS
from ..motion.error_estimate import signs
from ..settling.fixed_axes import STATES
from ..settling.settling import Nearest, is_close, last_outside
from .rungs.elements import chebyshev, coefficients
from .rungs.track import LaunchProblem, Track

SECTIONS, ROUNDS = 16, 13
"""Parts into which an interval with a turn of the tilt is cut, so many times: 16^13 parts are the
rounding of a time."""
LOCAL = 12
"""Points of a stretch on which a crossing is found."""
ROUNDED = 2.0**-52
"""Rounding of a sine."""
SIDES = ((1.0, 1.0), (-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0))
"""Sides to which the end is displaced by its error: every other state, and the rest."""
SMALL = 0.01
"""Error of the end over the reach of the proof that it settles, up to which its sides do too."""
UNKNOWN = ("unresolved", "undetermined", "non-unique")
"""Ends after which nothing is known."""


@dataclass(frozen=True, eq=False)
class Estimate:
    """The value of a quantity, dimensionless, with its error."""

    value: Any
    """The value; None where the motion has none."""
    error: float
    """Estimated error; 0 for a word that is certain, infinite where nothing is known."""
    says: str = ""
    """What the value means, where that is not plain."""


def relative_error(estimate: Estimate, unit: float = 1.0) -> float:
    """The error of a value, over its size or a dimensionless 1 in its unit."""
    size = abs(estimate.value) if isinstance(estimate.value, float) else unit
    return float(estimate.error / max(unit, size))


def final(problem: LaunchProblem, track: Track) -> Estimate:  # noqa: ARG001
    """The states at the horizon or at the end before it."""
    return Estimate(track.states[-1], float(track.errors[-1]))


def path(problem: LaunchProblem, track: Track) -> Estimate:  # noqa: ARG001
    """The states at all times asked for."""
    return Estimate(track.states, track.error)


def outcome(problem: LaunchProblem, track: Track) -> Estimate:
    """What has become of the launch, as a word of `Outcome`."""
    if track.finish is not None:
        sure = track.finish.kind not in UNKNOWN and np.isfinite(track.finish.error)
        return Estimate(track.finish.kind, 0.0 if sure else math.inf, track.finish.evidence)
    if not np.isfinite(track.errors[-1]):
        return Estimate("unresolved", math.inf, "the error of the end has no bound")
    [near] = _near(problem, track)
    sides = [near.settled]
    room = float(np.linalg.norm(track.errors[-1] * np.maximum(1.0, np.abs(track.states[-1]))))
    here, there = is_close(np.array([near.distance, near.distance + room]), problem.settle)
    if room > SMALL * near.reach or here != there:
        sides += [side.settled for side in _near(problem, track, SIDES)]
    if len(set(sides)) > 1:
        said = "settling is proved for the end, and not for another within its error"
        return Estimate("undetermined", math.inf, said)
    return Estimate("settled" if near.settled else "moving", 0.0, near.evidence)


def settling_time(problem: LaunchProblem, track: Track) -> Estimate:
    """The time from which the motion stays within `settle` of the family on which it settles."""
    word = outcome(problem, track)
    if word.value != "settled":
        return Estimate(None, word.error, f"it has not settled: {word.says}")
    [near] = _near(problem, track)
    settling, p = problem.launches.settling, problem.p
    apart = settling.distances(track.states, p, near)
    wide = math.sqrt(problem.own) * np.maximum.accumulate(track.errors[::-1])[::-1]
    late, when, early = (
        _last_outside(problem, track, near, apart + shift) for shift in (wide, 0 * wide, -wide)
    )
    if late is None or when is None or early is None:
        return Estimate(
            None, math.inf, "its error is larger than the distance that counts as settled"
        )
    return Estimate(when, max(late - when, when - early))


def _last_outside(
    problem: LaunchProblem, track: Track, near: Nearest, apart: Floats
) -> float | None:
    """The last time at which a distance is above `settle`; 0 for never, None for at the end."""
    i = last_outside(apart, problem.settle)
    if i < 0:
        return 0.0
    if i + 1 >= len(apart):
        return None
    settling, p = problem.launches.settling, problem.p
    shift = float(apart[i] - settling.distances(track.states[i : i + 1], p, near)[0])

    def above(states: Floats) -> Floats:
        return settling.distances(states, p, near) + shift - problem.settle

    low, high = float(track.times[i]), float(track.times[i + 1])
    times = low + chebyshev(LOCAL)[0] * (high - low)
    return _crossing(times, above(track.at(times)))


def _crossing(times: Floats, values: Floats) -> float:
    """The last zero of the polynomial through values at Chebyshev points."""
    from numpy.polynomial import Chebyshev

    roots = Chebyshev(coefficients(LOCAL) @ values).roots()
    real = np.sort(roots[(np.abs(roots.imag) < 1e-9) & (np.abs(roots.real) <= 1 + 1e-9)].real)
    x = float(real[-1]) if real.size else 1.0
    return float(times[0] + (times[-1] - times[0]) / 2 * (1 + x))


def _end_time(kind: str, says: str, problem: LaunchProblem, track: Track) -> Estimate:  # noqa: ARG001
    """The time of an end of one kind; `says` is why there is none."""
    end = track.finish
    if end is not None and end.kind == kind:
        return Estimate(float(end.time), float(end.error))
    if end is not None and end.kind in UNKNOWN:
        return Estimate(None, math.inf, end.evidence)
    return Estimate(None, 0.0 if np.isfinite(track.error) else math.inf, says)


def largest_tilt(problem: LaunchProblem, track: Track) -> Estimate:  # noqa: ARG001
    """The largest |π/2 - θ| on the way."""
    if track.states.shape[-1] == len(STATES):  # along fixed axes
        best, at = _largest(track, _rise)
        across, along, up = track.at(np.array([at]))[0, : len(AXIS)]
        far = math.hypot(across, along)
        lost = ROUNDED / max(far, math.sqrt(ROUNDED))  # near a pole the sine hardly changes
        size = math.sqrt(len(AXIS)) * float(track.errors.max(initial=0.0))
        return Estimate(math.atan2(abs(up), far), size + lost)
    best, _ = _largest(track, _tilt)
    # the track's errors are over 1 or the size of the state; the tilt may be near 0 where θ is not
    sizes = track.errors * np.maximum(1.0, np.abs(track.states[:, 0]))
    return Estimate(best, float(sizes.max(initial=0.0)))


def _largest(track: Track, of: Callable[[Floats], Floats]) -> tuple[float, float]:
    """The largest value of a function of the states, given with its rate, and its time."""
    times, (tilt, rate) = track.times[None], of(track.states[None])
    where = float(times.flat[tilt.argmax()])
    best = float(tilt.max())
    gains = np.diff(rate) / np.diff(times)
    falls = 2 * float(gains.max(initial=0.0, where=rate[:, :-1] * rate[:, 1:] > 0))
    for _ in range(ROUNDS):
        rows, at = np.nonzero(_turns(rate))
        pair = np.stack([at, at + 1])
        (low, high), (a, b), (first, second) = times[rows, pair], rate[rows, pair], tilt[rows, pair]
        h = high - low
        # The tilt falls ever faster towards a passage near flat, a short pulse: the peak is above
        # the place where the tangents meet, by what that acceleration adds.
        bound = first + a * (second - first - b * h) / (a - b) + falls * h**2 / 2
        kept = bound > best
        if not kept.any():
            break
        times = low[kept, None] + h[kept, None] * (np.arange(SECTIONS + 1) / SECTIONS)
        tilt, rate = of(track.at(times.ravel()).reshape(*times.shape, -1))
        if tilt.max() > best:
            best, where = float(tilt.max()), float(times.flat[tilt.argmax()])
    return best, where


def _turns(rate: Floats) -> NDArray[np.bool_]:
    """Whether the tilt turns from rising to falling between two samples of a row."""
    return (rate[:, :-1] > 0) & (rate[:, 1:] <= 0)


def _tilt(states: Floats) -> Floats:
    """The tilt |π/2 - θ| and its rate, on a new first axis."""
    tilt = np.pi / 2 - states[..., 0]
    return np.stack([np.abs(tilt), -np.sign(tilt) * states[..., 1]])


def _rise(states: Floats) -> Floats:
    """The sine of the tilt and its rate along fixed axes, on a new first axis."""
    size = np.sqrt((states[..., : len(AXIS)] ** 2).sum(axis=-1))
    up, turn = states[..., 2], states[..., len(AXIS) :]
    rate = turn[..., 0] * states[..., 1] - turn[..., 1] * states[..., 0]
    rise: Floats = np.stack([np.abs(up), np.sign(up) * rate]) / size
    return rise


@dataclass(frozen=True)
class Question:
    """One quantity of a motion that a scene may ask for."""

    name: str
    """Its name, in `quantities` of a scene and of its file."""
    find: Callable[[LaunchProblem, Track], Estimate]
    """Function that finds it.  States are those of the launch's model, for some bodies along fixed
    axes: `problem.launches.settling.read(states)` gives the angles of any body."""
    kind: Kind | None
    """Its kind, of which a number has its unit; None for states and words."""
    whole: bool
    """Whether it needs samples all along the motion."""
    about: str
    """What it is, in words."""
    touching: bool = False
    """Whether only a body on a plane has it."""
    none: str = "none"
    """What it means where the motion has no value."""

    @property
    def of_body(self) -> bool:
        """Whether only a body has it: a user's system states no unit but that of time."""
        return self.touching or self.kind not in (None, Kind.TIME)


_EVERY = (
    Question("final", final, None, False, "the states at the horizon or at an earlier end"),
    Question("path", path, None, False, "the motion at all times"),
    Question("outcome", outcome, None, False, "what has become of the launch"),
    Question(
        "settling_time",
        settling_time,
        Kind.TIME,
        True,
        "time from which it stays near a steady motion",
        none="has not settled",
    ),
    Question(
        "lift_off_time",
        partial(_end_time, "lift-off", "it does not lift off"),
        Kind.TIME,
        False,
        "time at which the normal force reaches zero",
        touching=True,
        none="does not lift off",
    ),
    Question(
        "fall_time",
        partial(_end_time, "flat", "it does not fall flat"),
        Kind.TIME,
        False,
        "time at which the body lies within `flat`, an angle, of flat",
        touching=True,
        none="does not fall flat",
    ),
    Question("largest_tilt", largest_tilt, Kind.ANGLE, True, "largest |π/2 - θ| on the way"),
)
QUESTIONS = {q.name: q for q in _EVERY}
"""Every quantity of a motion by name."""


def _near(
    problem: LaunchProblem, track: Track, sides: Sequence[tuple[float, float]] = ((0.0, 0.0),)
) -> list[Nearest]:
    """The steady motions nearest to the end, displaced by its error to some sides."""
    last = track.states[-1]
    odd = np.arange(len(last)) % 2 == 1
    shares = np.array([np.where(odd, *side) for side in sides]) * signs(len(last))
    off = shares * track.errors[-1] * np.maximum(1.0, np.abs(last))
    return problem.launches.settling.each(last + off, problem.p, problem.settle)
