"""Error of a motion: each launch is run again, at other tolerances and from changed starts.

The first neighbour is finer than the launch, by a factor that depends on the method.  Its distance
measures the launch's own error.  Its start is changed by the tolerance to one side (zeros stay, so
that a motion in a plane of symmetry keeps its plane).  The second neighbour is a thousand times
looser, and its start is changed by its own tolerance to the other side.  Its distance, scaled down,
shows how errors grow, and whether a border between outcomes is near.  The stated error is the
larger of the two distances, with a factor on each, plus the unit roundoff of every step times the
largest growth from any time to the end.

Where the launch's error is larger than the looser neighbour's distance explains, finer neighbours
follow until two agree.  Where neighbours part or end differently, one more neighbour is as fine as
the first, on the other side.  If one of these ends differently, the launch's outcome is not
determined at its tolerance, and is not given.  This is evidence, not proof: a border between
outcomes that runs along the line of the starts, within the error of the finer neighbour, is not
seen.

A method with large steps can damp what the equations let grow.  Two of its runs near a saddle
then stay together where the motions part, so that their distance shows no growth.  Here errors grow
as the Jacobian says: between two samples by the exponential of its mean, which damps nothing, and
over a step of a fine run by Magnus' method of order four.  Order matters where a motion jumps: its
errors are large and nearly along the motion there, and cancel on the next slow branch.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cache
from itertools import islice
from typing import TYPE_CHECKING

import numpy as np

from ..base.types import Floats
from ..integrators.flow import Flow
from ..integrators.scipy_methods import GAUSS, Trail
from ..integrators.selection import METHODS
from .result import ErrorEstimate, Outcome

if TYPE_CHECKING:
    from .result import Result


COARSE = 1e-2
"""The neighbours' tolerance over that of a launch that is itself coarse."""
LOOSER = 1e3
"""The looser neighbour's tolerance over that of the launch, up to `LOOSEST`."""
LOOSEST = 1e-6
"""Tolerance above which no scaling holds and a stiff motion is lost.  A launch with more than a
tenth of it is coarse, and has three finer neighbours instead."""
ROUNDING = 1e-15
"""Relative change of a start below which it is lost in rounding."""
MEASURED = 5.0
"""Factor on the distance from the finer neighbour, which has an error too."""
MARGIN = 10.0
"""Factor on a scaled distance, because an error falls a little more slowly than the tolerance."""
PER_STEP = 2.0 * np.finfo(float).eps
"""Rounding of one step, relative to 1 or the state's size."""
CLOSE = 0.03
"""Distance of states up to which the scaling is trusted."""
NOTHING = 0.3
"""Estimate from which the final state is unknown: its error then has no bound."""
APART = 1e-2
"""Relative difference of the times of two early ends above which the ends are different."""
AGREED = 1 / 3
"""Distance of two finer neighbours, over the launch's from the finest, at which they agree."""
TURNS = 4
"""Most finer neighbours that follow where two do not agree."""
LASTING = (Outcome.MOVING, Outcome.SETTLED)
SIGNS = np.array([1.0, -0.83, 0.71, -0.91, 0.77, 0.87])
"""Direction of the start's change: fixed, and without symmetry."""
GOLDEN = (5**0.5 - 1) / 2
"""Number whose multiples modulo 1 never repeat, for the change of further states."""
COMPARED = 17
"""Times at which two neighbours are compared."""
HIDDEN = 10.0
"""Errors of the size of the tolerance, grown by the linearised motion, over the stated error, from
which the neighbours may hide a growth: their methods damp it."""
SMALL = 1e-3
"""Size up to which an error of the run that decides may grow, if its tolerance can be so small."""
Rerun = Callable[[Sequence[int], Floats, Floats], "list[Result]"]
"""(launches by number, tolerances, relative changes of the starts) → their results."""
Pair = tuple["Result", "Result"]
"""Two neighbours of a launch."""
DEGREE, NORM = 9, 0.5
"""Degree of the Taylor polynomial of an exponential, and the norm below which it is exact."""
LARGEST = 1e100
"""Growth that counts as without bound; its square does not overflow."""
WORK = 4e7
"""Most intervals of a path, times the cube of the number of states; further ones are joined."""


@cache
def signs(count: int) -> Floats:
    """The direction of the change of a start.

    Parameters
    ----------
    count
        Number of states.

    Returns
    -------
    ndarray
        Shape (count,), of sizes from 0.7 to 1.

    Examples
    --------
    >>> signs(8).round(2).tolist()
    [1.0, -0.83, 0.71, -0.91, 0.77, 0.87, -0.91, 0.8]
    """
    more = np.arange(len(SIGNS), count)
    rest = (0.7 + 0.3 * (GOLDEN * more % 1)) * np.where(more % 2, 1, -1)
    return np.concatenate([SIGNS[:count], rest])


def between(method: str) -> int:
    """Intervals of a neighbour's path between two times of a comparison.

    The growth of errors along it is of interest where a method can damp it in many steps.

    Parameters
    ----------
    method
        Name of the integrator.

    Examples
    --------
    >>> between("heyoka"), between("cvodes")
    (1, 16)
    """
    return 1 if METHODS[method].turn else 16


def estimate_errors(
    results: Sequence[Result], finest: Sequence[float], rerun: Rerun
) -> list[ErrorEstimate | None]:
    """Judge each launch by its neighbours.

    Parameters
    ----------
    results
        The launches after their runs.
    finest
        The smallest tolerance that the integrator of each accepts.
    rerun
        Function that runs some launches again.

    Returns
    -------
    list of ErrorEstimate or None
        None where the launch itself has no outcome.

    Examples
    --------
    >>> import stability as st
    >>> run = st.simulate(st.Disk(), st.Viscous(0.3), {"theta": 1.47, "omega3": 1.0}, 20.0)
    >>> bool(run.final_error < 1e-6)
    True
    """
    out: list[ErrorEstimate | None] = [None] * len(results)
    for judge, coarse in ((_of_fine, False), (_of_coarse, True)):
        which = [
            i
            for i, r in enumerate(results)
            if r.outcome is not Outcome.UNRESOLVED and (10 * r.tolerance > LOOSEST) == coarse
        ]
        if which:
            limits = np.array([finest[i] for i in which])
            with np.errstate(all="ignore"):  # a ratio may be infinite
                judged = judge([results[i] for i in which], limits, _of(which, rerun))
            for i, doubt in zip(which, judged, strict=True):
                out[i] = _at_end(doubt, results[i])
    return out


def _at_end(doubt: ErrorEstimate, launch: Result) -> ErrorEstimate:
    """The estimate with the error of a singular end added."""
    end = launch.path.end
    if end is None or not end.early:
        return doubt
    final, late = doubt.final_error + end.short, doubt.time_error + 1.1 * end.early
    return replace(doubt, final_error=final, time_error=late)


def _in_time(launch: Result, final: float, others: Sequence[Result]) -> float:
    """Error of the end's time from an error of the final state, in the neighbours' directions.

    A neighbour's end may be close in time by chance, where its state is not.
    """
    lags = None if launch.path.end is None else launch.path.end.lags
    if lags is None:
        return 0.0
    late = 0.0
    for other in others:
        far = _distance(launch, other)
        if 0 < far < np.inf and np.isfinite(final):
            moved = np.abs(launch.final - other.final)
            moving = moved > 0  # zero times an infinite lag has no value
            late = max(late, float(lags[moving] @ moved[moving]) * final / far)
    return late


def _of(which: Sequence[int], rerun: Rerun) -> Rerun:
    """Rerun for some launches, numbered among themselves."""

    def call(some: Sequence[int], tolerances: Floats, off: Floats) -> list[Result]:
        return rerun([which[j] for j in some], tolerances, off) if len(some) else []

    return call


def _of_fine(launches: Sequence[Result], limits: Floats, rerun: Rerun) -> list[ErrorEstimate]:
    """One finer neighbour on one side, one looser on the other, and more where in doubt."""
    every = range(len(launches))
    asked = np.array([r.tolerance for r in launches])
    offsets, loose = np.maximum(asked, ROUNDING), np.minimum(LOOSER * asked, LOOSEST)
    tight = np.maximum(asked * [METHODS[r.choice.method].finer for r in launches], limits)
    # without a finer neighbour, the distance of a looser one is above the launch's own error
    tight = np.where(tight < asked / 2, tight, 10 * asked)
    finer = rerun(every, tight, offsets)
    failed = [j for j in every if finer[j].outcome is Outcome.UNRESOLVED and tight[j] < asked[j]]
    tight[failed] = 10 * asked[failed]
    for j, result in zip(failed, rerun(failed, tight[failed], offsets[failed]), strict=True):
        finer[j] = result
    pairs = list(zip(finer, rerun(every, loose, -loose), strict=True))
    out = [
        _estimate(launch, pair, float(size), MARGIN * float(mine / size))
        for launch, pair, size, mine in zip(launches, pairs, loose, offsets, strict=True)
    ]
    unsure = [
        j
        for j in every
        if tight[j] < asked[j] and not _converges(launches[j], pairs[j], float(asked[j] / loose[j]))
    ]
    parted = [j for j in every if not _close(launches[j], pairs[j])]
    others = rerun(parted, tight[parted], -offsets[parted])
    for j, other in zip(parted, others, strict=True):
        out[j] = _pinched(launches[j], [pairs[j][0], other])
    unsure = [j for j in unsure if not out[j].contrary and np.isfinite(out[j].final_error)]
    return _settled(launches, [p[0] for p in pairs], out, unsure, tight, limits, rerun)


def _of_coarse(launches: Sequence[Result], limits: Floats, rerun: Rerun) -> list[ErrorEstimate]:
    """Three finer neighbours: one from the same start, and one on each side."""
    every = range(len(launches))
    asked = np.array([r.tolerance for r in launches])
    tight = np.maximum(COARSE * asked, limits)
    three = [rerun(every, tight, off) for off in (0 * asked, asked, -asked)]
    return [_pinched(launch, others) for launch, *others in zip(launches, *three, strict=True)]


def _estimate(launch: Result, pair: Pair, off: float, scale: float) -> ErrorEstimate:
    """The error from a finer neighbour, and from one that is looser and off by a relative size."""
    finer, looser = (_distances(launch, other) for other in pair)
    growth = max(_growth(*pair), looser[0] / off)
    rounding = PER_STEP * launch.path.steps
    final = max(MEASURED * finer[0], scale * looser[0]) + rounding * growth
    late = max(MEASURED * finer[1], scale * looser[1]) + rounding * (looser[1] / off + launch.time)
    return ErrorEstimate(
        final, max(late, _in_time(launch, final, pair)), _contrary(launch, [pair[0]])
    )


def _pinched(launch: Result, others: Sequence[Result]) -> ErrorEstimate:
    """The error from neighbours that are all finer, on any side."""
    contrary = _contrary(launch, others)
    if any(other.outcome is Outcome.UNRESOLVED for other in others):
        return ErrorEstimate(np.inf, np.inf, contrary)
    final, late = np.max([_distances(launch, other) for other in others], axis=0)
    # neighbours that part on the way meet at the end by chance only
    apart = _spread(others[-2], others[-1])
    size = MEASURED * max(final, apart if apart > CLOSE else 0.0)
    size += PER_STEP * launch.path.steps * _growth(others[-2], others[-1])
    time = max(float(MEASURED * late), _in_time(launch, float(size), others))
    if size < NOTHING:
        return ErrorEstimate(float(size), time, contrary)
    return ErrorEstimate(np.inf, time, contrary, _together(others[-2], others[-1]))


def _close(launch: Result, pair: Pair) -> bool:
    """Whether a launch and its neighbours stay together and end alike."""
    if not all(_alike(launch, other) for other in pair):
        return False
    far = max(max(_distances(launch, other)) for other in pair)
    return max(far, _spread(*pair)) <= CLOSE


def _converges(launch: Result, pair: Pair, ratio: float) -> bool:
    """Whether the distance falls with the tolerance, at least like its root."""
    near, between = _distances(launch, pair[0]), _distances(*pair)
    floor = 1e3 * PER_STEP * max(1.0, launch.time)
    return all(a <= max(np.sqrt(ratio) * b, floor) for a, b in zip(near, between, strict=True))


def _settled(
    launches: Sequence[Result],
    finer: list[Result],
    out: list[ErrorEstimate],
    unsure: list[int],
    tight: Floats,
    limits: Floats,
    rerun: Rerun,
) -> list[ErrorEstimate]:
    """The estimates, with finer neighbours for unsure launches until two of them agree."""
    for _ in range(TURNS):
        unsure = [j for j in unsure if tight[j] > limits[j]]
        if not unsure:
            break
        tight[unsure] = np.maximum(tight[unsure] / 10, limits[unsure])
        more = rerun(unsure, tight[unsure], np.zeros(len(unsure)))
        left = []
        for j, result in zip(unsure, more, strict=True):
            launch, before = launches[j], out[j]
            if result.outcome is Outcome.UNRESOLVED:
                continue
            new, between = _distances(launch, result), _distances(finer[j], result)
            size = max(before.final_error, MEASURED * new[0])
            late = max(before.time_error, MEASURED * new[1], _in_time(launch, size, [result]))
            out[j] = ErrorEstimate(
                size if size < NOTHING else np.inf, late, _contrary(launch, [result])
            )
            finer[j] = result
            if any(b > AGREED * n for b, n in zip(between, new, strict=True)):
                left.append(j)
        unsure = left
    for j in unsure:  # no two agree: only their scatter is known
        out[j] = ErrorEstimate(
            MEASURED * out[j].final_error, MEASURED * out[j].time_error, out[j].contrary
        )
    return out


def with_growth(
    launch: Result, doubt: ErrorEstimate, other: Result, growth: Growth
) -> ErrorEstimate:
    """The estimate with the distance of a run whose own error grows by a known factor.

    Parameters
    ----------
    launch, doubt
        The launch, and the estimate by its neighbours.
    other
        A finer run.
    growth
        Growth of errors along it.
    """
    if other.outcome is Outcome.UNRESOLVED:
        size, late, contrary = np.inf, np.inf, doubt.contrary
    else:
        far, late = _distances(launch, other)
        grown = other.tolerance + PER_STEP * other.path.steps
        # errors that stay small on the way grow as the linearised motion says, and shrink again
        grown *= growth.last if grown * growth.largest < SMALL else growth.largest
        size = MEASURED * far + grown if grown < NOTHING else np.inf
        late = max(MEASURED * late, _in_time(launch, size, [other]))
        contrary = doubt.contrary or _contrary(launch, [other])
    size = max(doubt.final_error, size)
    if size >= NOTHING:
        size = np.inf
        if launch.outcome is not Outcome.MOVING and not contrary:
            contrary = f"an error of the tolerance {launch.tolerance:g} {grows(growth.largest)}"
    return ErrorEstimate(
        size, max(doubt.time_error, late), contrary, doubt.together, growth.largest
    )


def grows(factor: float) -> str:
    """How much an error grows, in words."""
    by = f"by a factor of {factor:.0e}" if factor < np.inf else "without bound"
    return f"may grow {by} on the way"


def _distances(launch: Result, other: Result) -> tuple[float, float]:
    """Distance of the final states, and of the times of the end."""
    if Outcome.UNRESOLVED in (launch.outcome, other.outcome):
        return np.inf, np.inf
    return _distance(launch, other), abs(launch.time - other.time)


def _gaps(launch: Result, other: Result) -> Floats:
    """Distances of two neighbours at the times at which both were still running."""
    count = min(len(launch.path.states), len(other.path.states))
    every = between(launch.choice.method)
    ours, theirs = (r.path.states[:count:every] for r in (launch, other))
    return _each(ours, theirs, launch.compared)


def _spread(launch: Result, other: Result) -> float:
    """Half the largest distance of two neighbours on the way."""
    return float(_gaps(launch, other).max()) / 2


def _together(launch: Result, other: Result) -> float:
    """Part of the time up to which two neighbours stay close."""
    close = np.logical_and.accumulate(_gaps(launch, other) / 2 <= CLOSE)
    return float(max(int(close.sum()) - 1, 0) / (COMPARED - 1))


def _growth(launch: Result, other: Result) -> float:
    """Largest ratio of the distance of two neighbours at the end to one before, and at least 1."""
    gaps = _gaps(launch, other)
    last = max(gaps[-1], min(_distance(launch, other), 1.0))
    least = gaps[gaps > 0]
    return max(1.0, float(last / least.min())) if least.size else 1.0


def _each(a: Floats, b: Floats, count: int) -> Floats:
    """Largest difference of the states of each pair, over 1 or the state's own size."""
    a, b = a[..., :count], b[..., :count]
    differences: Floats = (np.abs(a - b) / np.maximum(1.0, np.abs(a))).max(axis=-1)
    return differences


def _distance(launch: Result, other: Result) -> float:
    """Distance of the final states, as `_each`; one by one is faster for six numbers."""
    pairs = zip(launch.final.tolist(), other.final.tolist(), strict=True)
    apart = [abs(a - b) / max(1.0, abs(a)) for a, b in islice(pairs, launch.compared)]
    return math.nan if any(map(math.isnan, apart)) else max(apart)


def _alike(launch: Result, other: Result) -> bool:
    if launch.outcome in LASTING and other.outcome in LASTING:
        both = launch.outcome is other.outcome is Outcome.SETTLED
        return not both or launch.near.family == other.near.family
    return launch.outcome is other.outcome and abs(launch.time - other.time) <= APART * max(
        1.0, launch.time
    )


def _contrary(launch: Result, others: Sequence[Result]) -> str:
    """End of a neighbour that ends differently, in words; empty where none does."""
    unlike = [other for other in others if not _alike(launch, other)]
    lost = [other for other in unlike if other.outcome is Outcome.UNRESOLVED]
    # a neighbour that gives up contradicts a launch that lasted, and no other
    if not unlike or (lost and launch.outcome not in LASTING):
        return ""
    if lost:
        return (
            f"a run within the tolerance {launch.tolerance:g} of it is unresolved at "
            f"{lost[0].time:.9g}: {lost[0].evidence}"
        )
    other = unlike[0]

    def in_words(result: Result) -> str:
        if result.outcome is Outcome.SETTLED:
            return f"{result.outcome.word} to {result.near.family}"
        at = "" if result.outcome in LASTING else f" at {result.time:.9g}"
        return f"{result.outcome.word}{at}"

    return (
        f"two runs within the tolerance {launch.tolerance:g} of each other end differently: "
        f"{in_words(launch)}, and {in_words(other)}"
    )


@dataclass(frozen=True)
class Growth:
    """Growth of errors of size one in each interval of a path; at least 1."""

    largest: float
    """Largest size at any time."""
    last: float
    """Size at the end."""


NONE = Growth(1.0, 1.0)
"""No growth."""


def growth(flow: Flow, p: Floats, times: Floats, states: Floats, enough: float = 0.0) -> Growth:
    """Growth of errors along a path, by the mean of the Jacobian between its samples.

    Parameters
    ----------
    flow
        The flow.
    p
        Its parameters, shape (m,).
    times, states
        A path, shapes (t,) and (t, n).
    enough
        Growth below which an upper bound of it is enough.

    Returns
    -------
    Growth
        The size of an error is the largest over the states, each over 1 or the state's own size.  A
        state that is zero all along has no error: a symmetry keeps it there.

    Source: tests/motion/test_growth.py compares it with closed forms.

    Examples
    --------
    >>> from stability.integrators.flow import flow
    >>> f, times = flow("viscous"), np.linspace(0.0, 10.0, 65)
    >>> rolling = np.tile(f.pack(np.array([np.pi / 2, 0, 0, 1.2, 0, 0])), (65, 1))
    >>> bool(1 <= growth(f, np.array([0.25, 0.3, 1e-6]), times, rolling).largest < 1e3)
    True
    """
    y = states[:, : flow.compared]
    live = (y != 0).any(axis=0)
    if len(y) < 2 or not live.any():
        return NONE
    matrices = _jacobians(flow, p, states)
    if not np.isfinite(matrices).all():
        return Growth(np.inf, np.inf)
    sizes = np.maximum(1.0, np.abs(y))
    scaled = matrices * sizes[:, None, :] / sizes[:, :, None]
    exponents = np.diff(times)[:, None, None] * (scaled[1:] + scaled[:-1]) / 2
    diagonal = np.arange(flow.compared)
    exponents[:, diagonal, diagonal] -= np.diff(np.log(sizes), axis=0)
    bound = float(np.sqrt(len(times) * flow.compared) * np.exp(min(_upper(exponents), 700.0)))
    if bound <= enough:
        return Growth(bound, bound)
    return _grown(exponents, np.ones((len(exponents), flow.compared)), live)


def growth_along(flow: Flow, p: Floats, trail: Trail) -> Growth:
    """As `growth`, along the steps of a fine run and of higher order.

    Parameters
    ----------
    flow, p
        The flow and its parameters, shape (m,).
    trail
        The steps, with the state at the points of Gauss of each.
    """
    times, states, inner = (np.array(part) for part in zip(*trail, strict=True))
    y = states[:, : flow.compared]
    live = (y != 0).any(axis=0)
    if len(y) < 2 or not live.any():
        return NONE
    sizes = np.maximum(1.0, np.abs(y))
    first, second = (
        _jacobians(flow, p, inner[1:, :, i]) * sizes[:-1, None, :] / sizes[:-1, :, None]
        for i in (0, 1)
    )
    if not (np.isfinite(first).all() and np.isfinite(second).all()):
        return Growth(np.inf, np.inf)
    h = np.diff(times)[:, None, None]
    apart = (GAUSS[1] - GAUSS[0]) / 4
    exponents = h * (first + second) / 2 - apart * h**2 * (first @ second - second @ first)
    return _grown(exponents, sizes[:-1] / sizes[1:], live)


def _jacobians(flow: Flow, p: Floats, states: Floats) -> Floats:
    ask, count = flow.quick.jacobian, flow.compared
    return np.array([ask(p, state)[:count, :count] for state in states])


def _upper(exponents: Floats) -> float:
    """Most growth by the logarithmic norm of largest entries, as a logarithm."""
    diagonal = np.diagonal(exponents, axis1=1, axis2=2)
    rows = np.abs(exponents).sum(axis=2) - np.abs(diagonal) + diagonal
    return float(np.maximum(rows.max(axis=1), 0.0).sum())


def _grown(exponents: Floats, after: Floats, live: Floats) -> Growth:
    """Roots of a variance that grows by each exponential, with ones added after each.

    Each exponential is followed by a change of the states' sizes.
    """
    step = int(np.ceil(len(exponents) * live.size**3 / WORK))
    every = np.arange(0, len(exponents), step)
    exponents = np.add.reduceat(exponents, every)
    resized = np.multiply.reduceat(after, every)
    ones = np.diag(live.astype(float))
    variance, largest, size = ones, 1.0, 1.0
    with np.errstate(all="ignore"):
        for matrix in resized[:, :, None] * exponentials(exponents):
            variance = matrix @ variance @ matrix.T + ones
            size = float(np.sqrt(np.diagonal(variance).max()))
            if not size < LARGEST:
                return Growth(np.inf, np.inf)
            largest = max(largest, size)
    return Growth(largest, size)


def exponentials(matrices: Floats) -> Floats:
    """The exponential of each matrix, by scaling and squaring.

    Parameters
    ----------
    matrices
        Shape (N, n, n).

    Returns
    -------
    ndarray
        Shape (N, n, n).

    Examples
    --------
    >>> exponentials(np.array([[[0.0, 1.0], [0.0, 0.0]]])).tolist()
    [[[1.0, 1.0], [0.0, 1.0]]]
    """
    norm = float(np.abs(matrices).sum(axis=2).max(initial=NORM))
    halvings = int(np.ceil(np.log2(norm / NORM)))
    small, identity = matrices / 2.0**halvings, np.eye(matrices.shape[-1])
    series = np.broadcast_to(identity, matrices.shape)
    for k in range(DEGREE, 0, -1):
        series = identity + small @ series / k
    for _ in range(halvings):
        series = series @ series
    return series
