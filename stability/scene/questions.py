"""What a scene may ask of a motion: each quantity with its error, from the track of any model."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..base.quantities import Kind
from ..base.types import Floats
from ..motion.neighbours import signs
from ..settling.nearest import Nearest
from .rungs.elements import chebyshev
from .rungs.track import Problem, Track

PEAKS = 8
"""Samples next to which the largest value is sought."""
LOCAL = 12
"""Points of a stretch on which a largest value or a crossing is found."""
UNKNOWN = ("unresolved", "undetermined", "non-unique")
"""Ends after which nothing is known."""


@dataclass(frozen=True, eq=False)
class Found:
    """The value of a quantity, dimensionless, with its error."""

    value: Any
    """The value; None where the motion has none."""
    error: float
    """Estimated error; 0 for a word that is certain, infinite where nothing is known."""
    says: str = ""
    """What the value means, where that is not plain."""


def relative_error(found: Found) -> float:
    """The error of a value, over 1 or its size.

    Parameters
    ----------
    found
        The value.
    """
    size = abs(found.value) if isinstance(found.value, float) else 1.0
    return float(found.error / max(1.0, size))


def final(problem: Problem, track: Track) -> Found:  # noqa: ARG001
    """The states at the horizon or at the end before it."""
    return Found(track.states[-1], float(track.errors[-1]))


def path(problem: Problem, track: Track) -> Found:  # noqa: ARG001
    """The states at all times asked for."""
    return Found(track.states, track.error)


def outcome(problem: Problem, track: Track) -> Found:
    """What has become of the launch, as a word of `Outcome`."""
    if track.finish is not None:
        sure = track.finish.kind not in UNKNOWN and np.isfinite(track.finish.error)
        return Found(track.finish.kind, 0.0 if sure else math.inf, track.finish.evidence)
    if not np.isfinite(track.errors[-1]):
        return Found("unresolved", math.inf, "the error of the end has no bound")
    near = _near(problem, track)
    if track.errors[-1] > near.reach and near.settled != _near(problem, track, 1.0).settled:
        return Found("moving", math.inf, "settling is proved for the end, not for one in its error")
    return Found("settled" if near.settled else "moving", 0.0, near.evidence)


def settling_time(problem: Problem, track: Track) -> Found:
    """The time from which the motion stays within `settle` of the family on which it settles."""
    word = outcome(problem, track)
    if word.value != "settled":
        return Found(None, word.error, f"it has not settled: {word.says}")
    near = _near(problem, track)
    settling, p = problem.launches.settling, problem.p
    apart = settling.distances(track.states, p, near)
    outside = np.flatnonzero(apart > problem.settle)
    if not outside.size:
        return Found(0.0, 0.0, "it is there from the start")
    i = int(outside[-1])
    times, values = _stretch(track, i, lambda x: settling.distances(x, p, near) - problem.settle)
    when, slope = _crossing(times, values)
    error = float(track.errors[i : i + 2].max()) * math.sqrt(problem.own) / max(slope, 1e-300)
    return Found(when, error)


def lift_off_time(problem: Problem, track: Track) -> Found:  # noqa: ARG001
    """The time at which the normal force reaches zero."""
    end = track.finish
    if end is not None and end.kind == "lift-off":
        return Found(float(end.time), float(end.error))
    if end is not None and end.kind in UNKNOWN:
        return Found(None, math.inf, end.evidence)
    return Found(None, 0.0 if np.isfinite(track.error) else math.inf, "it does not lift off")


def largest_tilt(problem: Problem, track: Track) -> Found:  # noqa: ARG001
    """The largest |π/2 - θ| on the way."""
    tilt = np.abs(np.pi / 2 - track.states[:, 0])
    best, error = float(tilt.max()), track.error
    if len(tilt) < 3:
        return Found(best, error)
    for i in sorted({min(max(j + d, 0), len(tilt) - 2) for j in _peaks(tilt) for d in (-1, 0)}):
        _, values = _stretch(track, i, lambda x: np.abs(np.pi / 2 - x[:, 0]))
        best = max(best, _largest(values))
    return Found(best, error)


@dataclass(frozen=True)
class Question:
    """One quantity that a scene may ask for."""

    name: str
    """Its name."""
    find: Callable[[Problem, Track], Found]
    """Function that finds it."""
    kind: Kind | None
    """Its kind, of which a number has its unit; None for states and words."""
    whole: bool
    """Whether it needs samples all along the motion."""
    about: str
    """What it is, in words."""
    of_disk: bool = False
    """Whether only a disk has it."""


QUESTIONS = {
    q.name: q for q in (
        Question("final", final, None, False, "the states at the horizon or at an earlier end"),
        Question("path", path, None, False, "the motion at all times"),
        Question("outcome", outcome, None, False, "what has become of the launch"),
        Question("settling_time", settling_time, Kind.TIME, True,
                 "time from which it stays near a steady motion"),
        Question("lift_off_time", lift_off_time, Kind.TIME, False,
                 "time at which the normal force reaches zero", True),
        Question("largest_tilt", largest_tilt, Kind.ANGLE, True, "largest |π/2 - θ| on the way",
                 True),
    )
}  # fmt: skip
"""Every quantity of a motion by name."""


def _near(problem: Problem, track: Track, share: float = 0.0) -> Nearest:
    """The nearest steady motion of the end, displaced by a share of its error."""
    last = track.states[-1]
    off = share * track.errors[-1] * np.maximum(1.0, np.abs(last)) * signs(len(last))
    return problem.launches.settling.nearest(last + off, problem.p, problem.settle)


def _stretch(track: Track, i: int, of: Callable[[Floats], Floats]) -> tuple[Floats, Floats]:
    """Chebyshev points between two samples, and the values of a function of the states there."""
    share = chebyshev(LOCAL)[0]
    times = track.times[i] + share * (track.times[i + 1] - track.times[i])
    return times, of(track.at(times))


def _polynomial(values: Floats) -> Any:
    """The polynomial through values at Chebyshev points, on [-1, 1]."""
    from numpy.polynomial import Chebyshev

    order = np.arange(LOCAL)
    matrix = np.cos(np.pi * np.outer(order, order[::-1]) / (LOCAL - 1))
    matrix[:, [0, -1]] /= 2
    matrix[[0, -1]] /= 2
    return Chebyshev(matrix @ values * 2 / (LOCAL - 1))


def _peaks(values: Floats) -> list[int]:
    """The samples next to the largest peaks, by the parabola through each and its neighbours."""
    left, here, right = values[:-2], values[1:-1], values[2:]
    bend = np.maximum(2 * here - left - right, 1e-300)
    top = np.where((here >= left) & (here >= right), here + (right - left) ** 2 / (8 * bend), here)
    every = np.concatenate([values[:1], top, values[-1:]])
    return [int(i) for i in np.argsort(every)[-PEAKS:]]


def _largest(values: Floats) -> float:
    """The largest value of the polynomial through them."""
    found = _polynomial(values)
    turns = found.deriv().roots()
    real = turns[(np.abs(turns.imag) < 1e-9) & (np.abs(turns.real) <= 1)].real
    return float(max([values.max(), *found(real)]))


def _crossing(times: Floats, values: Floats) -> tuple[float, float]:
    """The last time at which values cross zero, and their slope there."""
    found = _polynomial(values)
    roots = found.roots()
    real = np.sort(roots[(np.abs(roots.imag) < 1e-9) & (np.abs(roots.real) <= 1 + 1e-9)].real)
    half = (times[-1] - times[0]) / 2
    x = float(real[-1]) if real.size else 1.0
    return float(times[0] + half * (1 + x)), abs(float(found.deriv()(x))) / half
