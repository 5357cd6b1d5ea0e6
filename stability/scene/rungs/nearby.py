"""Tracks at both ends of uncertain inputs, from one linear equation along the track of a model.

Where the change is not small against the curvature, or a guard is as near as the change, there is
none: then the model has to run from the ends.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from ...base.types import Floats
from .track import Finish, Problem, Refused, Track, relative
from .variational import Forward, forward

CURVED = 0.1
"""Share of the linear change up to which the curvature may be."""
LOW = 1e-3
"""Share of the largest change below which a change counts as none."""
CLEAR = 2.0
"""Least margin of a guard, over what the change takes of it."""
TURNED = 2.0
"""Most by which the rate of a guard at its zero may change."""
BRIEF, SUBSTEPS, NEWTON = 0.5, 8, 4
"""Longest change of the end's time, in units of the motion's own time; steps of the method of Runge
and Kutta in it; steps of Newton's method."""
CURVES = "the answer is not linear within its uncertainty"
"""Why a sensitivity says too little."""

Pair = tuple[tuple[Problem, Track], tuple[Problem, Track]]
"""The two ends of an uncertain input: problem and track of each."""


def nearby(
    problem: Problem,
    track: Track,
    others: Sequence[tuple[Problem, Problem]],
    *,
    exact: bool,
    seconds: float = np.inf,
) -> tuple[Track, list[Pair | Refused]] | Refused:
    """The tracks at both ends of each input, from one linear equation along the track.

    Parameters
    ----------
    problem, track
        The problem and its track by any model.
    others
        The problem at the two ends of each input.
    exact, seconds
        As for `forward`.

    Returns
    -------
    track, ends
        The track on the same elements, and for each input both ends, or why a sensitivity does not
        give them.
    """
    n = problem.own
    apart = [(two.start - one.start, two.p - one.p) for one, two in others]
    starts = np.stack([x[:n] for x, _ in apart], axis=1) / 2
    parameters = np.stack([p for _, p in apart], axis=1) / 2
    found = forward(problem, track, starts, parameters, exact=exact, seconds=seconds)
    if isinstance(found, Refused):
        return found
    changes, bends = found.displaced(others)
    flow, p = problem.flow, np.array([[other.flow_p for other in pair] for pair in others])
    with np.errstate(all="ignore"):
        here, _ = flow.margins(flow.pack(found.states), problem.flow_p)
        there, _ = flow.margins(flow.pack(found.states + changes), p[:, :, None, None])
    ends: list[Pair | Refused] = []
    for pair, *given in zip(others, changes, bends, there, strict=True):
        one, other = (
            _end(found, track, end, change, bend, (here, margins))
            for end, change, bend, margins in zip(pair, *given, strict=True)
        )
        if isinstance(one, Refused) or isinstance(other, Refused):
            ends.append(one if isinstance(one, Refused) else other)  # type: ignore[arg-type]
        else:
            ends.append((one, other))
    return _track(found, track, np.zeros_like(found.states), track.errors), ends


def _end(
    found: Forward,
    track: Track,
    other: Problem,
    change: Floats,
    bend: Floats,
    margins: tuple[Floats, Floats],
) -> tuple[Problem, Track] | Refused:
    """Problem and track at one end of an input."""
    other = replace(other, times=found.problem.times)
    if not np.isfinite(change).all():
        return Refused(CURVES)
    size, curve = (relative(v, found.states) for v in (change - bend, bend))
    floor = LOW * size.max() + LOW * found.problem.tolerance
    share = float((curve / (size + floor)).max())
    if not share <= CURVED:
        return Refused(CURVES)
    rest = share * found.elements.at(track.times, curve[..., None])[:, 0]
    if track.finish is None:
        if not _stands(margins, found.elements.times >= 0):
            return Refused("a guard is as near as the change")
        return other, _track(found, track, change, track.errors + rest)
    return _ended(found, track, other, (change, rest), margins)


def _stands(margins: tuple[Floats, Floats], inside: NDArray[np.bool_]) -> bool:
    """Whether every guard is positive at some points, and well above what the change takes."""
    here, there = (v[inside] for v in margins)
    return bool((here > CLEAR * np.abs(there - here)).all() and (there > 0).all())


def _ended(
    found: Forward,
    track: Track,
    other: Problem,
    given: tuple[Floats, Floats],
    margins: tuple[Floats, Floats],
) -> tuple[Problem, Track] | Refused:
    """The track at one end of an input, where the motion ends before the horizon.

    The time of the guard's zero moves by -(∂g · S δ)/(∂g · f), and by Newton's method beyond that.
    """
    assert track.finish is not None
    change, rest = given
    flow, kind = found.problem.flow, track.finish.kind
    if kind not in flow.guards:
        return Refused("the motion ends in a way that has no derivative")
    index = list(flow.guards).index(kind)
    last = flow.pack(found.states[-1, -1])
    _, rate = (float(v[index]) for v in flow.margins(last, found.problem.flow_p))
    y = flow.pack((found.states + change)[-1, -1])
    late, steps = 0.0, []
    for _ in range(NEWTON):
        value, slope = (float(v[index]) for v in flow.margins(y, other.flow_p))
        turned = slope / rate if rate < 0 else np.inf
        step = -value / slope if slope else np.inf
        if not (1 / TURNED < turned < TURNED and abs(late + step) * other.pace < BRIEF):
            return Refused("the time of the end is not linear within its uncertainty")
        steps.append(step)
        y, late = _forward_by(other, y, step), late + step
    end = track.finish.time + late
    if abs(late - steps[0]) > CURVED * abs(late) + 1e-12 or end > found.problem.last:
        return Refused("the time of the end is not linear within its uncertainty")
    sure = min(end, track.finish.time - 2 * CLEAR * abs(late))
    if not _stands(margins, found.elements.times < sure):
        return Refused("a guard is as near as the change")
    moved = _track(found, track, change, track.errors + rest)
    keep = track.times < end
    keep[-1] = False
    times = np.append(track.times[keep], end)
    states = np.vstack([moved.states[keep], flow.reported(y)[None]])
    errors = np.append(moved.errors[keep], moved.errors[-1])
    finish = Finish(kind, end, track.finish.error + abs(late - steps[0]), track.finish.evidence)
    return other, replace(moved, times=times, states=states, errors=errors, finish=finish)


def _forward_by(problem: Problem, y: Floats, span: float) -> Floats:
    """The state y after a short time, by the classical method of Runge and Kutta."""
    rates, h = partial(problem.flow.quick.rates, problem.flow_p), span / SUBSTEPS
    for _ in range(SUBSTEPS):
        a = rates(y)
        b = rates(y + h / 2 * a)
        c = rates(y + h / 2 * b)
        y = y + h / 6 * (a + 2 * (b + c) + rates(y + h * c))
    return y


def _track(found: Forward, track: Track, change: Floats, errors: Floats) -> Track:
    """The track with a change, at the samples of the track."""
    states, width = found.states + change, track.states.shape[1]

    def at(times: Floats) -> Floats:
        every = np.zeros((len(times), width))
        every[:, : states.shape[-1]] = found.elements.at(times, states)
        return every

    return replace(track, states=at(track.times), errors=errors, at=at)
