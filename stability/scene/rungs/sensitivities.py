"""Neighbours of a path: how far small changes of its start and of its parameters move it.

The forward sensitivities obey S' = (∂f/∂x) S + ∂f/∂p along the path, with both slopes from the
graph.  This linear equation is solved once for all inputs, by collocation on elements of time.  The
path that an input displaces is x + S δ + z, where z is carried from the defect of x + S δ in the
full equations.  So z is the curvature that S leaves out: where it is not small, S says too little.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, partial

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from ...algebra.program import Program, entries
from ...base.types import Floats
from ...integrators.leg import Leg
from ...integrators.selection import HEYOKA, dense, explicit
from ...systems.equations import Equations
from .elements import Elements, LinearEquation, carried
from .full import between
from .near_steady import rates_of
from .track import Finish, LaunchProblem, Refused, Track, decade, relative

POINTS, LENGTH = 12, 1.5
"""Points of an element, and its first length in units of the motion's own time."""
SMOOTH, FINER = 1e-5, 1e-2
"""Size of the last coefficients of the sensitivities, over their largest value, above which an
element is divided; the share of it for the path."""
EASY, CORRECTIONS, EXACT = 40.0, 5, 1e-7
"""Norm of the slope over an element, above which it is stiff; the most corrections of steps where
it is not, and the size of a correction over the solution at which they end."""
SPLITS = 12
"""Most divisions of an element."""
STEPS, MOST_STEPS = 5, 1_000_000
"""Steps of the Taylor method in an element, and the most of all."""
STIFF, GRADED = 8.0, 3.0
"""Fastest rate over an element above which the first elements are short, and their growth."""
FINE = 1e-12
"""Tolerance of the full model along its own path."""
NOISE = 1e-9
"""Size of a sensitivity below which its last coefficients are rounding."""
NEWTON = 4
"""Most corrections of the path of another model."""
DOUBT, CLOSE = 0.3, 1e-5
"""Error of a model's path above which its sensitivities are those of another path, and correction
below which none follows."""
PER_NUMBER = 2.4e-10
"""Time for the linear equation of an element over the cube of its unknowns [s]."""
CURVED = 0.1
"""Share of the linear change up to which the curvature may be."""
LOW = 1e-3
"""Share of the largest change below which a change counts as none."""
CLEAR = 2.0
"""Least margin of a guard, over what the change takes of it."""
TURNED = 2.0
"""Most by which the rate of a guard at its zero may change."""
BRIEF, SUBSTEPS, NEWTON_OF_END = 0.5, 8, 4
"""Longest change of the end's time, in units of the motion's own time; steps of the method of Runge
and Kutta in it; steps of Newton's method."""
CURVES = "the answer is not linear within its uncertainty"
"""Why a sensitivity says too little."""
Pair = tuple[tuple[LaunchProblem, Track], tuple[LaunchProblem, Track]]
"""The two ends of an uncertain input: problem and track of each."""


@lru_cache(maxsize=64)
def _slopes(system: Equations) -> Program:
    """Program of (x, p) → rates, ∂f/∂x and ∂f/∂p, without a check of conditions."""
    slopes = [ca.jacobian(system.rhs, symbols) for symbols in (system.x, system.p)]
    outputs = [ca.densify(v) for v in (system.rhs, *slopes)]
    return Program(ca.Function("slopes", [system.x, system.p], outputs))


def _run(program: Program, states: Floats, p: Floats) -> list[Floats]:
    """Values at states, shape (…, n), and parameters that fit."""
    with np.errstate(all="ignore"):
        values: list[Floats] = program.arrays([entries(states), entries(p)], states.shape[:-1])
    return values


class Variation:
    """The linear equation e' = A(t) e + δ(t) along a path, solved to the accuracy of its elements.

    Where it is not stiff, steps of Runge and Kutta are corrected by the defect that they leave.
    That is many times cheaper than collocation, which solves a stiff one.

    Parameters
    ----------
    elements
        Division of time.
    slope
        A at the points, shape (E, N, n, n).
    """

    def __init__(self, elements: Elements, slope: Floats) -> None:
        self.elements, self.slope = elements, slope
        fastest = np.abs(slope).sum(axis=3).max(axis=(1, 2)) * elements.lengths
        easy = float(fastest.max()) < EASY
        self._steps = LinearEquation.along(elements, slope) if easy else None

    def solve(self, drive: Floats, start: Floats) -> Floats:
        """The solutions for drives of shape (E, N, n, c) and starts of shape (n, c)."""
        if self._steps is None:
            return carried(self.elements, self.slope, drive, start)
        solution = self._steps.solve(drive, start)
        size = np.abs(solution).max(axis=(0, 1, 2))
        none, flat = np.zeros_like(start), (*drive.shape[:2], -1)
        for _ in range(CORRECTIONS):
            rate = self.elements.derivative(solution.reshape(flat)).reshape(drive.shape)
            more = self._steps.solve(drive + self.slope @ solution - rate, none)
            solution = solution + more
            if not (np.abs(more).max(axis=(0, 1, 2)) > EXACT * size).any():
                return solution
        return carried(self.elements, self.slope, drive, start)


@dataclass(frozen=True, eq=False)
class Forward:
    """A path on elements of time, and its sensitivities along given directions."""

    problem: LaunchProblem
    """The problem."""
    elements: Elements
    """Division of time."""
    states: Floats
    """The path at the points, shape (E, N, n)."""
    slopes: tuple[Floats, Floats]
    """Rates and ∂f/∂p at the points."""
    equation: Variation
    """The linear equation along the path."""
    starts: Floats
    """Change of the start along each direction, shape (n, c)."""
    parameters: Floats
    """Change of the parameters along each, shape (m, c)."""
    first: Floats
    """Sensitivities: the change of the path along each, shape (E, N, n, c)."""

    def displaced(
        self, others: Sequence[tuple[LaunchProblem, LaunchProblem]]
    ) -> tuple[Floats, Floats]:
        """Changes of the path at both ends of each direction, to second order.

        Parameters
        ----------
        others
            The problem at the two ends of each direction.

        Returns
        -------
        changes, curvature
            The change and what is in it beyond the sensitivity, shape (c, 2, E, N, n).
        """
        n = self.problem.own
        signs = np.tile([-1.0, 1.0], len(others))
        linear = np.repeat(self.first, 2, axis=-1) * signs
        changed = np.repeat(self.parameters, 2, axis=-1) * signs
        displaced = np.moveaxis(self.states[..., None] + linear, -1, 0)
        p = np.array([other.p for pair in others for other in pair])
        [there] = _run(rates_of(self.problem.flow.system), displaced, p[:, None, None])
        rates, by_p = self.slopes
        straight = rates[..., None] + self.equation.slope @ linear + by_p @ changed
        defect = np.moveaxis(there[..., 0], 0, -1) - straight
        start = np.array([other.start[:n] for pair in others for other in pair]).T
        start = start - self.problem.start[:n, None] - np.repeat(self.starts, 2, axis=-1) * signs
        bad = ~np.isfinite(defect).all(axis=(0, 1, 2))
        defect[..., bad] = 0.0
        curvature = self.equation.solve(defect, start)
        curvature[..., bad] = np.inf
        shape = (len(others), 2, *self.states.shape)
        changes, bends = (
            np.moveaxis(v, -1, 0).reshape(shape) for v in (linear + curvature, curvature)
        )
        return changes, bends


def forward(
    problem: LaunchProblem,
    track: Track,
    starts: Floats,
    parameters: Floats,
    *,
    exact: bool,
    seconds: float = np.inf,
) -> Forward | Refused:
    """The sensitivities of a track along directions.

    `starts` and `parameters` change along each direction, shapes (n, c) and (m, c).  The path of a
    model that is not the full one, `exact`, is corrected first, by its defect in the full
    equations.  The linear equations may take `seconds` as expected.

    Source: tests/scene/test_sensitivities.py holds them against closed forms and differences.
    """
    if problem.launches.dry:
        return Refused("dry friction sticks and slips, so that the motion has no derivative")
    limit = FINER * SMOOTH if exact else max(FINER * SMOOTH, track.error)
    most = seconds / (3 * PER_NUMBER * ((POINTS - 1) * problem.own) ** 3)
    elements = _first_elements(problem, track, exact=exact)
    for _ in range(SPLITS):
        if elements is None or not len(elements.lengths) <= most:
            return Refused("the linear equations along the path cost more than displaced runs")
        states = _path(problem, track, elements, exact=exact)
        if not np.isfinite(states).all():
            return Refused("the path is not known at all times")
        coarse = elements.tails(states) > limit
        if not coarse.any():
            sensitivities = _solved(problem, elements, states, (starts, parameters), exact=exact)
            if isinstance(sensitivities, Refused):
                return sensitivities
            coarse = _rough_in(sensitivities, max(SMOOTH, limit))
            if not coarse.any():
                return sensitivities
        elements = elements.halved(coarse)
    return Refused("the path is not smooth enough")


def _first_elements(problem: LaunchProblem, track: Track, *, exact: bool) -> Elements | None:
    """Some steps of an explicit method each, or equal elements, and short ones at a fast start.

    None where there are more than `MOST_STEPS` of them.
    """
    last, n = float(track.times[-1]), problem.own
    _, slope, _ = _run(_slopes(problem.flow.system), track.states[:1, :n], problem.p)
    finite = bool(np.isfinite(slope).all())
    rate = float(np.abs(np.linalg.eigvals(slope[0])).max()) if finite else 0.0
    if exact and rate < STIFF * problem.pace / LENGTH and explicit(problem.flow) == HEYOKA:
        span, y = np.array([0.0, last]), problem.flow.pack(problem.start)
        run = dense(
            Leg(problem.flow, problem.flow_p, y, span, FINE, MOST_STEPS, problem.max_seconds)
        )
        if len(run.steps) >= MOST_STEPS:
            return None
        inner = run.steps[STEPS:-1:STEPS]
        return Elements(np.concatenate([[0.0], inner[inner < last], [last]]), POINTS)
    count = max(1, int(np.ceil(min(last * problem.pace / LENGTH, MOST_STEPS))))
    if count == MOST_STEPS:
        return None
    edges = np.linspace(0.0, last, count + 1)
    if rate * last > STIFF * count:
        powers = np.arange(np.floor(np.log(rate * last / count) / np.log(GRADED)) + 1)
        edges = np.union1d(edges, GRADED**powers / rate)
    return Elements(edges, POINTS)


def _path(problem: LaunchProblem, track: Track, elements: Elements, *, exact: bool) -> Floats:
    """The system's own states at the points."""
    times = elements.times.ravel()
    if exact:
        start = problem.start[None]
        tolerance = decade(min(FINE, problem.tolerance))
        states = between(problem, np.zeros(1), start, times, tolerance)
    else:
        states = track.at(times)
    nodes: Floats = states[:, : problem.own].reshape(*elements.times.shape, -1)
    return nodes


def _solved(
    problem: LaunchProblem,
    elements: Elements,
    states: Floats,
    directions: tuple[Floats, Floats],
    *,
    exact: bool,
) -> Forward | Refused:
    """The sensitivities on elements that resolve the path."""
    n, program = problem.own, _slopes(problem.flow.system)
    starts, parameters = directions
    rates, slope, by_p = _run(program, states, problem.p)
    for _ in range(0 if exact else NEWTON):  # the path of another model is corrected
        if not (np.isfinite(rates).all() and np.isfinite(slope).all()):
            break
        defect = rates - elements.derivative(states)[..., None]
        off = (problem.start[:n] - states[0, 0])[:, None]
        error = Variation(elements, slope).solve(defect, off)[..., 0]
        size = relative(error, states).max()
        if not size < DOUBT:
            return Refused("the path of the model is too far from that of the full one")
        states = states + error
        rates, slope, by_p = _run(program, states, problem.p)
        if size < CLOSE:
            break
    if not all(np.isfinite(v).all() for v in (rates, slope, by_p)):
        return Refused("the rates have no derivative along the path")
    equation = Variation(elements, slope)
    first = equation.solve(by_p @ parameters, starts)
    if not np.isfinite(first).all():
        return Refused("the sensitivities grow beyond all numbers")
    slopes = rates[..., 0], by_p
    return Forward(problem, elements, states, slopes, equation, starts, parameters, first)


def _rough_in(sensitivities: Forward, limit: float) -> NDArray[np.bool_]:
    """Which elements do not resolve the sensitivities."""
    size = np.abs(sensitivities.first).max(axis=(0, 1, 2), keepdims=True)
    share = sensitivities.first / np.maximum(size, NOISE)
    tails = sensitivities.elements.tails(share.reshape(*share.shape[:2], -1))
    return np.asarray(tails > limit)


def nearby(
    problem: LaunchProblem,
    track: Track,
    others: Sequence[tuple[LaunchProblem, LaunchProblem]],
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
    apart = [(upper.start - lower.start, upper.p - lower.p) for lower, upper in others]
    starts = np.stack([x[:n] for x, _ in apart], axis=1) / 2
    parameters = np.stack([p for _, p in apart], axis=1) / 2
    sensitivities = forward(problem, track, starts, parameters, exact=exact, seconds=seconds)
    if isinstance(sensitivities, Refused):
        return sensitivities
    changes, bends = sensitivities.displaced(others)
    flow, p = problem.flow, np.array([[other.flow_p for other in pair] for pair in others])
    with np.errstate(all="ignore"):
        here, _ = flow.margins(flow.pack(sensitivities.states), problem.flow_p)
        there, _ = flow.margins(flow.pack(sensitivities.states + changes), p[:, :, None, None])
    ends: list[Pair | Refused] = []
    for pair, *parts in zip(others, changes, bends, there, strict=True):
        lower, upper = (
            _end(sensitivities, track, end, change, bend, (here, margins))
            for end, change, bend, margins in zip(pair, *parts, strict=True)
        )
        if isinstance(lower, Refused) or isinstance(upper, Refused):
            ends.append(lower if isinstance(lower, Refused) else upper)  # type: ignore[arg-type]
        else:
            ends.append((lower, upper))
    return _track(sensitivities, track, np.zeros_like(sensitivities.states), track.errors), ends


def _end(
    sensitivities: Forward,
    track: Track,
    other: LaunchProblem,
    change: Floats,
    bend: Floats,
    margins: tuple[Floats, Floats],
) -> tuple[LaunchProblem, Track] | Refused:
    """Problem and track at one end of an input."""
    other = replace(other, times=sensitivities.problem.times)
    if not np.isfinite(change).all():
        return Refused(CURVES)
    size, curve = (relative(v, sensitivities.states) for v in (change - bend, bend))
    floor = LOW * size.max() + LOW * sensitivities.problem.tolerance
    share = float((curve / (size + floor)).max())
    if not share <= CURVED:
        return Refused(CURVES)
    rest = share * sensitivities.elements.at(track.times, curve[..., None])[:, 0]
    if track.finish is None:
        if not _stands(margins, sensitivities.elements.times >= 0):
            return Refused("a guard is as near as the change")
        return other, _track(sensitivities, track, change, track.errors + rest)
    return _ended(sensitivities, track, other, (change, rest), margins)


def _stands(margins: tuple[Floats, Floats], inside: NDArray[np.bool_]) -> bool:
    """Whether every guard is positive at some points, and well above what the change takes."""
    here, there = (v[inside] for v in margins)
    return bool((here > CLEAR * np.abs(there - here)).all() and (there > 0).all())


def _ended(
    sensitivities: Forward,
    track: Track,
    other: LaunchProblem,
    shift: tuple[Floats, Floats],
    margins: tuple[Floats, Floats],
) -> tuple[LaunchProblem, Track] | Refused:
    """The track at one end of an input, where the motion ends before the horizon.

    The time of the guard's zero moves by -(∂g · S δ)/(∂g · f), and by Newton's method beyond that.
    """
    assert track.finish is not None
    change, rest = shift
    flow, kind = sensitivities.problem.flow, track.finish.kind
    if kind not in flow.guards:
        return Refused("the motion ends in a way that has no derivative")
    index = list(flow.guards).index(kind)
    last = flow.pack(sensitivities.states[-1, -1])
    _, rate = (float(v[index]) for v in flow.margins(last, sensitivities.problem.flow_p))
    y = flow.pack((sensitivities.states + change)[-1, -1])
    late, steps = 0.0, []
    for _ in range(NEWTON_OF_END):
        value, slope = (float(v[index]) for v in flow.margins(y, other.flow_p))
        turned = slope / rate if rate < 0 else np.inf
        step = -value / slope if slope else np.inf
        if not (1 / TURNED < turned < TURNED and abs(late + step) * other.pace < BRIEF):
            return Refused("the time of the end is not linear within its uncertainty")
        steps.append(step)
        y, late = _forward_by(other, y, step), late + step
    end = track.finish.time + late
    if abs(late - steps[0]) > CURVED * abs(late) + 1e-12 or end > sensitivities.problem.last:
        return Refused("the time of the end is not linear within its uncertainty")
    sure = min(end, track.finish.time - 2 * CLEAR * abs(late))
    if not _stands(margins, sensitivities.elements.times < sure):
        return Refused("a guard is as near as the change")
    moved = _track(sensitivities, track, change, track.errors + rest)
    keep = track.times < end
    keep[-1] = False
    times = np.append(track.times[keep], end)
    states = np.vstack([moved.states[keep], flow.reported(y)[None]])
    errors = np.append(moved.errors[keep], moved.errors[-1])
    finish = Finish(kind, end, track.finish.error + abs(late - steps[0]), track.finish.evidence)
    return other, replace(moved, times=times, states=states, errors=errors, finish=finish)


def _forward_by(problem: LaunchProblem, y: Floats, span: float) -> Floats:
    """The state y after a short time, by the classical method of Runge and Kutta."""
    rates, h = partial(problem.flow.quick.rates, problem.flow_p), span / SUBSTEPS
    for _ in range(SUBSTEPS):
        a = rates(y)
        b = rates(y + h / 2 * a)
        c = rates(y + h / 2 * b)
        y = y + h / 6 * (a + 2 * (b + c) + rates(y + h * c))
    return y


def _track(sensitivities: Forward, track: Track, change: Floats, errors: Floats) -> Track:
    """The track with a change, at the samples of the track."""
    states, width = sensitivities.states + change, track.states.shape[1]

    def at(times: Floats) -> Floats:
        every = np.zeros((len(times), width))
        every[:, : states.shape[-1]] = sensitivities.elements.at(times, states)
        return every

    return replace(track, states=at(track.times), errors=errors, at=at)
