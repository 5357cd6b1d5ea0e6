"""The full model of a scene: the law that is taken for the truth, with neighbours for its error."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...base.quantities import Kind
from ...base.types import Floats
from ...motion.error_estimate import ROUNDING, signs
from ...motion.result import Outcome, Result, Settings
from ...motion.run import results
from .track import Finish, LaunchProblem, Track, decade, relative

FIRST, STIFF, SHARPER, FINEST = 1e-4, 1e-2, 1e-3, 1e-15
"""Tolerance of the integrator over that of the scene, for an explicit method, whose cost hardly
depends on it, and for a stiff motion; the factor of the next; the smallest."""
COARSEST = 1e-7
"""Largest tolerance of the integrator: above it an error does not scale with the tolerance."""
TRUTH, COARSE_TRUTH, TRUEST = 1e-3, 1e-6, 1e-14
"""Tolerance of the truth over that of the scene, its largest and its smallest."""
FALL = 0.7
"""Power of the tolerance with which an error falls at least."""
SLOW = 300.0
"""Friction, over the rate of the motion, above which a motion counts as stiff."""
LOOKS, SAFETY, ALONG = 201, 5.0, 1e-2
"""Times at which two runs are compared, the factor on their distance, and the ratio of tolerances
of two runs that are compared on the way."""
MOST_STEPS = 1_000_000_000
"""Steps of a run; its computing time ends it before."""
BRIEF = 0.25
"""Share of the computing time of a run for each that finds until when an answer holds."""
LASTING = (Outcome.MOVING, Outcome.SETTLED)


def full(
    problem: LaunchProblem,
    begin: float = 0.0,
    start: Floats | None = None,
    carried: Floats | None = None,
    last: float | None = None,
) -> Track:
    """The track of the full model, at tolerances that fall until the error is small enough.

    It runs from `start` at `begin` to `last`, by default as the problem does.  `carried` is the
    error of that state, shape (s,): a second run from the displaced state carries it on.  Where no
    tolerance is enough, the smallest error counts.
    """
    end = problem.last if last is None else last
    times = problem.times[(problem.times >= begin) & (problem.times < end)]
    times = np.append(times, end) - begin
    state = problem.start if start is None else start
    stiff = problem.friction > SLOW * problem.pace  # an explicit method would be slow
    first = STIFF if stiff else FIRST
    asked = decade(first * problem.tolerance, FINEST, COARSEST)
    best: Track | None = None
    while True:
        track = _run(problem, begin, state, times, asked, carried)
        if best is None or track.errors[-1] <= best.errors[-1]:
            best = track
        hope = track.errors[-1] * (FINEST / asked) ** FALL
        if _parted(track, carried):
            hope = 0.0
        if track.errors[-1] <= problem.tolerance or asked <= FINEST or hope > problem.tolerance:
            return best
        asked = decade(asked * SHARPER, FINEST)


def _parted(track: Track, carried: Floats | None) -> bool:
    """Whether only the neighbours have parted: these are looser, and finer ones may stay close."""
    bounded = carried is None or bool(np.isfinite(carried).all())
    return bounded and track.finish is None and bool(np.isinf(track.errors[-1]))


def truth_of(problem: LaunchProblem) -> tuple[LaunchProblem, Track]:
    """The full model at a much finer tolerance: the problem with it, and its track."""
    tolerance = max(TRUEST, min(TRUTH * problem.tolerance, COARSE_TRUTH))
    fine = replace(problem, tolerance=tolerance)
    return fine, full(fine)


def kept_until(problem: LaunchProblem, track: Track) -> float:
    """The time up to which an answer that misses the tolerance at its end holds.

    Up to there two fine runs of the full model, and runs from starts that differ from the given one
    by rounding, agree within the tolerance, and the track agrees with these.
    """
    times = np.linspace(0.0, problem.last, LOOKS)
    brief = replace(problem, max_seconds=BRIEF * problem.max_seconds)
    off = np.outer([0.0, 1.0, -1.0], signs(len(problem.start))) * ROUNDING * problem.start
    fine, *others = (
        problem.flow.reported(run.path.states)
        for starts, tolerance in ((off[:1], FINEST), (off, 100 * FINEST))
        for run in _results(brief, problem.start + starts, times, tolerance, check=False)
    )
    end = times[-1] if track.finish is None else min(times[-1], track.finish.time)
    both = min(len(fine), *map(len, others), int(np.searchsorted(times, end, side="right")))
    if not both:
        return 0.0
    fine, times = fine[:both], times[:both]
    apart = [SAFETY * relative(other[:both] - fine, fine) for other in others]
    apart.append(relative(track.at(times) - fine, fine))
    bad = ~(np.max(apart, axis=0) <= problem.tolerance)
    bad[-1] |= end == problem.last  # an error above the tolerance is stated there
    return float(times[max(int(np.argmax(bad)) - 1, 0) if bad.any() else -1])


def _settings(problem: LaunchProblem, tolerance: float, *, check: bool) -> Settings:
    return Settings(
        "auto",
        tolerance,
        False,
        problem.flat,
        problem.settle,
        MOST_STEPS,
        1,
        check,
        problem.max_seconds,
    )


def _results(
    problem: LaunchProblem, states: Floats, times: Floats, tolerance: float, *, check: bool
) -> list[Result]:
    """Runs of the full model from some states, at times after theirs."""
    clock = float(problem.launches.size(Kind.TIME))
    many = (len(states),)
    launches = replace(
        problem.launches,
        starts=states,
        times=times * clock,
        shape=many,
        p=np.broadcast_to(problem.p, (*many, len(problem.p))).copy(),
    )
    return results(launches, _settings(problem, tolerance, check=check))


def _run(
    problem: LaunchProblem,
    begin: float,
    start: Floats,
    times: Floats,
    tolerance: float,
    carried: Floats | None,
) -> Track:
    [result] = _results(problem, start[None], times, tolerance, check=True)
    track = _track(problem, begin, times, result, tolerance)
    if len(times) > 2 and np.isfinite(track.errors[-1]):
        track = _along(problem, track, start, times, tolerance)
    if carried is None or not np.abs(carried).any():
        return track
    if not np.isfinite(carried).all():
        return replace(track, errors=np.full(len(track.errors), np.inf))
    for side in (1.0, -1.0):
        off = (start + side * carried)[None]
        [other] = _results(problem, off, times, tolerance, check=False)
        track = _displaced(problem, track, begin, int(times[0] != 0), result, other)
    return track


def _gaps(problem: LaunchProblem, track: Track, other: Result, skip: int) -> Floats:
    """Relative distances of another run from the samples of a track, as far as both go."""
    away = problem.flow.reported(other.path.states)[skip:]
    both = min(len(away), len(track.states))
    return relative(away[:both] - track.states[:both], track.states[:both])


def _displaced(
    problem: LaunchProblem, track: Track, begin: float, skip: int, result: Result, other: Result
) -> Track:
    """The track with the error that a displaced run shows."""
    more = _gaps(problem, track, other, skip)
    beyond = np.full(len(track.states) - len(more), more.max(initial=0.0))
    more, finish = np.append(more, beyond), track.finish
    alike = (other.outcome in LASTING) == (result.outcome in LASTING)
    if finish is None:
        more[-1] = more[-1] if alike else np.inf
        return replace(track, errors=track.errors + more)
    ends = problem.flow.reported(np.stack([result.final, other.final]))
    more[-1] = max(more[-1], relative(ends[1] - ends[0], ends[0]))
    late = abs(other.time + begin - finish.time)
    same = other.outcome.word == finish.kind
    finish = replace(finish, error=finish.error + late if same else np.inf)
    return replace(track, errors=track.errors + more, finish=finish)


def _along(
    problem: LaunchProblem, track: Track, start: Floats, times: Floats, tolerance: float
) -> Track:
    """The track with its error on the way, which may be larger than at the end."""
    fine = decade(tolerance * ALONG, FINEST)
    if fine >= tolerance:
        fine = decade(tolerance / ALONG)
    [other] = _results(problem, start[None], times, fine, check=False)
    gaps = _gaps(problem, track, other, int(times[0] != 0))
    errors = track.errors.copy()
    errors[: len(gaps)] = np.maximum(errors[: len(gaps)], SAFETY * gaps)
    return replace(track, errors=errors)


def _track(
    problem: LaunchProblem, begin: float, times: Floats, result: Result, tolerance: float
) -> Track:
    """The samples of a result, and its end as the last of them."""
    reported = problem.flow.reported(result.path.states)[int(times[0] != 0) :]
    when = times[: len(reported)] + begin
    size = np.inf if result.doubt is None else result.doubt.final_error
    finish = None
    if result.outcome not in LASTING:
        late = 0.0 if result.doubt is None else result.doubt.time_error
        finish = Finish(result.outcome.word, result.time + begin, late, result.evidence)
        if result.path.end is not None and (not len(when) or when[-1] < finish.time):
            when = np.append(when, finish.time)
            reported = np.vstack([reported, problem.flow.reported(result.final)[None]])
    knots, passed = when, reported
    if times[0] != 0:  # states before the first sample follow from the start
        knots = np.append(begin, when)
        passed = np.vstack([problem.flow.reported(result.path.states)[:1], reported])
    errors = np.full(len(when), size)
    errors[when == 0.0] = 0.0

    def at(asked: Floats) -> Floats:
        return between(problem, knots, passed, asked, tolerance)

    notes = (result.choice.reason,) if result.choice.reason else ()
    methods = (result.choice.method,)
    return Track(when, reported, errors, at, finish, result.path.steps, notes, methods=methods)


def between(
    problem: LaunchProblem, when: Floats, states: Floats, asked: Floats, tolerance: float
) -> Floats:
    """States of the full model at times `asked`: short runs from the samples before them."""
    when_there = np.isin(asked, when)
    if when_there.all():
        return states[np.searchsorted(when, asked)]
    filled = np.empty((len(asked), states.shape[1]))
    before = np.clip(np.searchsorted(when, asked, side="right") - 1, 0, len(when) - 1)
    for i in np.unique(before):
        mine = np.flatnonzero(before == i)
        later, places = np.unique(asked[mine] - when[i], return_inverse=True)
        later = np.maximum(later, 0.0)
        rows = np.tile(states[i], (len(later), 1))
        ahead = later > 0
        if ahead.any():
            [run] = _results(problem, states[i][None], later[ahead], tolerance, check=False)
            path = problem.flow.reported(run.path.states)[1:]
            fill = np.tile(problem.flow.reported(run.final), (int(ahead.sum()), 1))
            fill[: len(path)] = path[: len(fill)]
            rows[ahead] = fill
        filled[mine] = rows[places]
    return filled
