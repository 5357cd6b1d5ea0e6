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

from ...algebra.program import Program
from ...base.types import Floats
from ...systems.equations import Equations
from .elements import Elements, carried
from .full import between
from .track import Finish, Problem, Refused, Track, decade, relative

POINTS, LENGTH = 12, 1.0
"""Points of an element, and its first length in units of the motion's own time."""
RESOLVED, SMOOTH = 1e-9, 1e-7
"""Size of the last coefficients of an element above which it is divided: of the path, and of the
sensitivities over their largest value."""
SPLITS = 12
"""Most divisions of an element."""
STIFF, GRADED = 8.0, 3.0
"""Fastest rate over an element above which the first elements are short, and their growth."""
FINE = 1e-12
"""Tolerance of the full model along its own path."""
CURVED = 0.1
"""Share of the linear change up to which the curvature may be."""
LOW = 1e-3
"""Share of the largest change below which a change counts as none."""
CLEAR = 2.0
"""Least margin of a guard, over what the change takes of it."""
TURNED = 2.0
"""Most by which the rate of a guard at its zero may change."""
BRIEF, SUBSTEPS, NEWTON = 0.5, 8, 8
"""Longest change of the end's time, in units of the motion's own time; steps of the method of Runge
and Kutta in it; steps of Newton's method."""
DOUBT = 0.3
"""Defect of a model's path, carried, above which its sensitivities are those of another path."""
PER_NUMBER = 4e-10
"""Time for the linear equation of an element over the cube of its unknowns [s]."""
CURVES = "the answer is not linear within its uncertainty"
"""Why a sensitivity says too little."""


@lru_cache(maxsize=64)
def _slopes(system: Equations) -> Program:
    """Program of (x, p) → rates, ∂f/∂x and ∂f/∂p, without a check of conditions."""
    slopes = [ca.jacobian(system.rhs, symbols) for symbols in (system.x, system.p)]
    outputs = [ca.densify(v) for v in (system.rhs, *slopes)]
    return Program(ca.Function("slopes", [system.x, system.p], outputs))


@lru_cache(maxsize=64)
def _rates(system: Equations) -> Program:
    """Program of (x, p) → rates, without a check of conditions."""
    return Program(ca.Function("rates", [system.x, system.p], [ca.densify(system.rhs)]))


def _run(program: Program, states: Floats, p: Floats) -> list[Floats]:
    """Values at states, shape (…, n)."""
    with np.errstate(all="ignore"):
        found: list[Floats] = program.arrays(
            [list(np.moveaxis(states, -1, 0)), list(p)], states.shape[:-1]
        )
    return found


@dataclass(frozen=True, eq=False)
class Forward:
    """A path on elements of time, and its sensitivities along given directions."""

    problem: Problem
    """The problem."""
    elements: Elements
    """Division of time."""
    states: Floats
    """The path at the points, shape (E, N, n)."""
    slopes: tuple[Floats, Floats, Floats]
    """Rates, ∂f/∂x and ∂f/∂p at the points."""
    starts: Floats
    """Change of the start along each direction, shape (n, c)."""
    parameters: Floats
    """Change of the parameters along each, shape (m, c)."""
    first: Floats
    """Sensitivities: the change of the path along each, shape (E, N, n, c)."""

    def displaced(self, others: Sequence[tuple[Problem, Problem]]) -> tuple[Floats, Floats]:
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
        n, system = self.problem.own, self.problem.flow.system
        rates, slope, by_p = self.slopes
        defect = np.empty((*self.first.shape, 2))
        start = np.empty((n, self.first.shape[-1], 2))
        for i, pair in enumerate(others):
            for j, (other, sign) in enumerate(zip(pair, (-1.0, 1.0), strict=True)):
                linear = sign * self.first[..., i]
                [there] = _run(_rates(system), self.states + linear, other.p)
                straight = (slope @ linear[..., None])[..., 0] + by_p @ (
                    sign * self.parameters[:, i]
                )
                defect[..., i, j] = there[..., 0] - rates - straight
                start[:, i, j] = other.start[:n] - self.problem.start[:n] - sign * self.starts[:, i]
        flat = defect.reshape(*defect.shape[:3], -1)
        bad = ~np.isfinite(flat).all(axis=(0, 1, 2))
        flat[..., bad] = 0.0
        found = carried(self.elements, slope, flat, start.reshape(n, -1))
        found[..., bad] = np.inf
        curvature = np.moveaxis(found.reshape(defect.shape), (3, 4), (0, 1))
        both = np.moveaxis(np.stack([-self.first, self.first], axis=-1), (3, 4), (0, 1))
        return both + curvature, curvature


def forward(
    problem: Problem, track: Track, starts: Floats, parameters: Floats, *, exact: bool,
    seconds: float = np.inf,
) -> Forward | Refused:  # fmt: skip
    """The sensitivities of a track along directions.

    Parameters
    ----------
    problem
        The problem.
    track
        Its track by any model.
    starts
        Change of the start along each direction, shape (n, c).
    parameters
        Change of the system's parameters along each, shape (m, c).
    exact
        Whether the track is that of the full model.  The path of another model is corrected first,
        by its defect in the full equations.
    seconds
        Time that the linear equations are expected to take at most [s].

    Returns
    -------
    Forward or Refused
    """
    if problem.launches.dry:
        return Refused("dry friction sticks and slips, so that the motion has no derivative")
    limit = RESOLVED if exact else max(RESOLVED, track.error)
    most = seconds / (3 * PER_NUMBER * ((POINTS - 1) * problem.own) ** 3)
    elements = _first_elements(problem, track)
    for _ in range(SPLITS):
        if not len(elements.lengths) <= most:
            return Refused("the linear equations along the path cost more than displaced runs")
        states = _path(problem, track, elements, exact=exact)
        if not np.isfinite(states).all():
            return Refused("the path is not known at all times")
        coarse = elements.tails(states) > limit
        if not coarse.any():
            found = _solved(problem, elements, states, (starts, parameters), exact=exact)
            if isinstance(found, Refused):
                return found
            coarse = _rough_in(found, limit)
            if not coarse.any():
                return found
        halves = (elements.edges[:-1] + elements.edges[1:])[coarse] / 2
        elements = Elements(np.union1d(elements.edges, halves), POINTS)
    return Refused("the path is not smooth enough")


def _first_elements(problem: Problem, track: Track) -> Elements:
    """Equal elements, and short ones at the start where a part of the motion decays fast."""
    last = float(track.times[-1])
    count = max(1, int(np.ceil(last * problem.pace / LENGTH)))
    edges = np.linspace(0.0, last, count + 1)
    n, length = problem.own, last / count
    _, slope, _ = _run(_slopes(problem.flow.system), track.states[:1, :n], problem.p)
    if np.isfinite(slope).all():
        rate = float(np.abs(np.linalg.eigvals(slope[0])).max())
        if rate * length > STIFF:
            powers = np.arange(np.floor(np.log(rate * length) / np.log(GRADED)) + 1)
            edges = np.union1d(edges, GRADED**powers / rate)
    return Elements(edges, POINTS)


def _path(problem: Problem, track: Track, elements: Elements, *, exact: bool) -> Floats:
    """The system's own states at the points."""
    times = elements.times.ravel()
    if exact:
        start = problem.start[None]
        tolerance = decade(min(FINE, problem.tolerance))
        states = between(problem, np.zeros(1), start, times, tolerance)
    else:
        states = track.at(times)
    found: Floats = states[:, : problem.own].reshape(*elements.times.shape, -1)
    return found


def _solved(
    problem: Problem, elements: Elements, states: Floats, directions: tuple[Floats, Floats], *,
    exact: bool,
) -> Forward | Refused:  # fmt: skip
    """The sensitivities on elements that resolve the path."""
    n, program = problem.own, _slopes(problem.flow.system)
    starts, parameters = directions
    rates, slope, by_p = _run(program, states, problem.p)
    if not exact and np.isfinite(rates).all() and np.isfinite(slope).all():
        defect = rates[..., 0] - elements.derivative(states)
        error = carried(elements, slope, defect, problem.start[:n] - states[0, 0])
        if not relative(error, states).max() < DOUBT:
            return Refused("the path of the model is too far from that of the full one")
        states = states + error
        rates, slope, by_p = _run(program, states, problem.p)
    if not all(np.isfinite(v).all() for v in (rates, slope, by_p)):
        return Refused("the rates have no derivative along the path")
    first = carried(elements, slope, by_p @ parameters, starts)
    if not np.isfinite(first).all():
        return Refused("the sensitivities grow beyond all numbers")
    slopes = rates[..., 0], slope, by_p
    return Forward(problem, elements, states, slopes, starts, parameters, first)


def _rough_in(found: Forward, limit: float) -> NDArray[np.bool_]:
    """Which elements do not resolve the sensitivities."""
    size = np.abs(found.first).max(axis=(0, 1, 2), keepdims=True)
    share = found.first / np.where(size > 0, size, 1.0)
    tails = found.elements.tails(share.reshape(*share.shape[:2], -1))
    return np.asarray(tails > max(SMOOTH, limit))


Pair = tuple[tuple[Problem, Track], tuple[Problem, Track]]
"""The two ends of an uncertain input: problem and track of each."""


def nearby(
    problem: Problem, track: Track, others: Sequence[tuple[Problem, Problem]], *, exact: bool,
    seconds: float = np.inf,
) -> tuple[Track, list[Pair | Refused]] | Refused:  # fmt: skip
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
    changes, curvature = found.displaced(others)
    ends: list[Pair | Refused] = []
    for pair, change, bend in zip(others, changes, curvature, strict=True):
        one, other = (_end(found, track, *given) for given in zip(pair, change, bend, strict=True))
        if isinstance(one, Refused) or isinstance(other, Refused):
            ends.append(one if isinstance(one, Refused) else other)  # type: ignore[arg-type]
        else:
            ends.append((one, other))
    return _track(found, track, np.zeros_like(found.states), track.errors), ends


def _end(
    found: Forward, track: Track, other: Problem, change: Floats, bend: Floats
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
        if not _stands(found, other, change, np.inf):
            return Refused("a guard is as near as the change")
        return other, _track(found, track, change, track.errors + rest)
    return _ended(found, track, other, change, rest)


def _stands(found: Forward, other: Problem, change: Floats, before: float) -> bool:
    """Whether every guard stays positive before a time, and well above what the change takes."""
    flow = found.problem.flow
    inside = found.elements.times < before
    here, there = (
        flow.margins(flow.pack(v[inside]), of.flow_p)[0]
        for v, of in ((found.states, found.problem), (found.states + change, other))
    )
    return bool((here > CLEAR * np.abs(there - here)).all() and (there > 0).all())


def _ended(
    found: Forward, track: Track, other: Problem, change: Floats, rest: Floats
) -> tuple[Problem, Track] | Refused:
    """The track at one end of an input, where the motion ends before the horizon.

    The time of the guard's zero moves by -(∂g · S δ)/(∂g · f), and by Newton's method beyond that.
    """
    assert track.finish is not None
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
    if not _stands(found, other, change, sure):
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
