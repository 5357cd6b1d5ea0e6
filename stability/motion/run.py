"""Launches run in legs, judged, and compared with their neighbours."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from contextlib import closing
from dataclasses import replace
from functools import partial
from itertools import repeat
from typing import Any

import numpy as np

from ..base.types import Floats
from ..bodies.model import FLAT, LIFT_OFF, NO_CONTACT
from ..integrators.flow import ASKING, Flow, flow_of
from ..integrators.leg import UNRESOLVED, End, Leg, Path
from ..integrators.painleve import OPEN_END, closer
from ..integrators.scipy_methods import Trail
from ..integrators.scipy_methods import integrate as integrate_by_steps
from ..integrators.selection import METHODS, Choice, explicit, run
from ..integrators.stick_slip import DryPath
from ..integrators.stick_slip import integrate as integrate_dry
from ..integrators.taylor import CORES
from ..jobs.pipeline import Counted, here, ordered, shared
from ..settling.settling import NOWHERE, Nearest
from .error_estimate import (
    COMPARED,
    HIDDEN,
    LARGEST,
    NONE,
    SMALL,
    between,
    estimate_errors,
    grows,
    growth,
    growth_along,
    signs,
    with_growth,
)
from .result import OF_END, TIGHTEST, ErrorEstimate, Outcome, Result, Settings
from .starts import Starts

TOGETHER = 1e-6
"""D below which a zero of gn D counts as a zero of both gn D and D."""

LONG_STEPS = 3.0
"""Steps of an explicit method per unit of the growth's logarithm from which they hide no growth."""
FINE_ENOUGH = 1e-12
"""Smallest tolerance of the run by which the growth of errors is decided."""
CHUNK = 4096
"""Launches that are run and checked together."""


def results(
    launches: Starts, settings: Settings, progress: Callable[[int, int], None] | None = None
) -> list[Result]:
    """Run every launch and judge its outcome.

    Parameters
    ----------
    launches
        Checked launches.
    settings
        Settings of the runs.
    progress
        As for `simulate`.

    Returns
    -------
    list of Result
        In the order of the launches.
    """
    legs, judged = _legs(launches, settings), []
    for first in range(0, len(legs), CHUNK):  # the neighbours of all would fill the memory
        some = slice(first, first + CHUNK)
        report = None if progress is None else partial(_later, progress, first, len(legs))
        judged += _checked(legs[some], launches.starts[some], launches, settings, report)
    return judged


SMOOTH = 0.1
"""Most by which a path turns between two samples that draw it [rad]."""
EVENLY = 0.25
"""Share of the samples of a path that are evenly spaced in time, however it turns."""
MOST_SAMPLES = 20_001
"""Most samples that draw a path."""


def resampled(
    launches: Starts, settings: Settings, results: list[Result]
) -> tuple[Starts, list[Result]]:
    """A single launch with samples up to its end, closer where its path turns faster.

    It runs once more, and is judged by its first run.
    """
    [result] = results
    if result.outcome is Outcome.UNRESOLVED or not result.time > 0:
        return launches, results
    clock, end = float(launches.clock[0]), result.path.end
    times = _chosen_times(launches, settings, result)
    if end is None and len(times) == len(launches.times):
        return launches, results
    if end is not None:  # the run meets its end again, before its last time
        times[-1] = launches.times[-1] / clock
    again = replace(launches, times=times * clock)
    [fine] = _run(
        _legs(again, settings), again, settings, [result.choice.method], None, by_user=False
    )
    if (fine.path.end is None) != (end is None):
        return launches, results
    return again, [replace(result, path=replace(fine.path, end=end), dry=fine.dry)]


def _chosen_times(launches: Starts, settings: Settings, result: Result) -> Floats:
    """Times from 0 to the end of a run: evenly spaced, or by the angle that its path turns."""
    states = result.path.states[: len(launches.times)]
    when = np.append(launches.times[: len(states)] / launches.clock[0], result.time)
    even = np.linspace(0.0, result.time, len(launches.times))
    model = launches.model
    turning = [model.names.index("phi_dot")] if "phi_dot" in model.names else [*model.turning]
    if not settings.pose or not turning:
        return even
    rates = np.linalg.norm(np.vstack([states, result.final])[:, turning], axis=1)
    steps = np.diff(when) * (rates[1:] + rates[:-1]) / 2
    angle = np.concatenate([[0.0], np.cumsum(steps)])
    count = min(max(math.ceil(angle[-1] / SMOOTH / (1 - EVENLY)) + 1, len(even)), MOST_SAMPLES)
    if count == len(even):
        return even
    along = (1 - EVENLY) * angle / angle[-1] + EVENLY * when / result.time
    rising = np.append(np.diff(along) > 0, True)  # the end may be the last sample
    times: Floats = np.interp(np.linspace(0.0, 1.0, count), along[rising], when[rising])
    times[-1] = result.time
    return times


def _later(
    progress: Callable[[int, int], None], before: int, total: int, done: int, _: int
) -> None:
    progress(before + done, total)


def _checked(
    legs: Sequence[Leg],
    starts: Floats,
    launches: Starts,
    settings: Settings,
    progress: Callable[[int, int], None] | None,
) -> list[Result]:
    """Run some launches, and their neighbours."""
    runs = _run(legs, launches, settings, [settings.method] * len(legs), progress)
    if not settings.check:
        return runs

    compared = [
        replace(leg, times=_compared(leg, ran.choice.method))
        for leg, ran in zip(legs, runs, strict=True)
    ]
    left = [settings.max_seconds] * len(legs)  # seconds that the neighbours of each share
    finer: dict[int, Result] = {}  # the first neighbour of each

    def rerun(which: Sequence[int], tolerances: Floats, off: Floats) -> list[Result]:
        methods = [runs[i].choice.method for i in which]
        numbers = zip(which, tolerances.tolist(), off.tolist(), strict=True)
        shadows = [
            _shadow(compared[i], starts[i], tolerance, size, left[i])
            for i, tolerance, size in numbers
        ]
        results = _run(shadows, launches, settings, methods, None, by_user=False)
        for i, result in zip(which, results, strict=True):
            left[i] -= result.path.seconds
            finer.setdefault(i, result)
        return results

    judged = estimate_errors(runs, [METHODS[r.choice.method].finest for r in runs], rerun)
    if not launches.dry:
        for i, result in finer.items():
            doubt, leg = judged[i], replace(compared[i], seconds=left[i])
            if doubt is not None and not doubt.contrary and math.isfinite(doubt.final_error):
                judged[i] = _grown(leg, runs[i], doubt, result, launches, settings)
    return [_doubted(result, doubt) for result, doubt in zip(runs, judged, strict=True)]


def _grown(
    leg: Leg,
    result: Result,
    doubt: ErrorEstimate,
    finer: Result,
    launches: Starts,
    settings: Settings,
) -> ErrorEstimate:
    """The estimate, with a growth of errors that the neighbours may hide because they damp it.

    An explicit method damps only in a few long steps.  Where the linearised motion along the finer
    neighbour lets errors grow far beyond the estimate, a run by LSODA decides: its steps show how
    the Jacobian changes, and its tolerance is small against the growth.
    """
    explicit = METHODS[result.choice.method].turn > 0
    steps = math.exp(min(result.path.steps / LONG_STEPS, 700.0)) if explicit else 1.0
    shown = max(HIDDEN * doubt.final_error / result.tolerance, steps)
    if shown >= LARGEST:
        return doubt
    states = finer.path.states
    with np.errstate(all="ignore"):
        for every in (4, 1):  # few samples are enough nearly always
            times = leg.times[: len(states) : every]
            grown = growth(leg.flow, leg.p, times, states[::every], shown)
            if grown.largest <= shown:
                return doubt
        for smallest in (False, True):
            fine = FINE_ENOUGH if smallest else max(SMALL / grown.largest, FINE_ENOUGH)
            fine = max(min(fine, result.tolerance / 10), FINE_ENOUGH)
            shadow = replace(leg, times=leg.times[[0, -1]], tolerance=fine)
            trail: Trail = []
            path = integrate_by_steps(shadow, solver="LSODA", trail=trail)
            grown = growth_along(leg.flow, leg.p, trail)
            choice = Choice("lsoda", "its steps show how errors grow")
            [other] = _judged([shadow], [(path, choice)], launches, settings, by_user=False)
            if fine * grown.largest < SMALL or fine == FINE_ENOUGH:
                break
    if grown.largest > shown:
        return with_growth(result, doubt, other, grown)
    # nothing was hidden along the true path: that of the launch must be close to it
    return with_growth(result, doubt, other, NONE) if fine < result.tolerance else doubt


def _legs(launches: Starts, settings: Settings) -> list[Leg]:
    which, turning = flow_of(launches.model), list(launches.model.turning)
    lead = launches.times[:1] != 0
    times = np.concatenate([[0.0], launches.times]) if lead else launches.times
    # launches of one time scale share their array of times
    shared = times / launches.clock[0] if np.ndim(launches.units.time) == 0 else None
    rows = zip(
        launches.flow_p(settings.flat), which.pack(launches.starts), launches.clock, strict=True
    )
    return [
        Leg(
            which,
            p,
            y,
            times / clock if shared is None else shared,
            _finer(settings.tolerance, y[turning]),
            settings.max_steps,
            settings.max_seconds,
        )
        for p, y, clock in rows
    ]


def _shadow(leg: Leg, states: Floats, tolerance: float, off: float, seconds: float) -> Leg:
    """The leg from a start with a relative change."""
    start = leg.flow.pack(states * (1.0 + off * signs(len(states))))
    return replace(leg, start=start, tolerance=tolerance, seconds=seconds)


def _compared(leg: Leg, method: str) -> Floats:
    """The times of a neighbour's samples."""
    return np.linspace(leg.times[0], leg.times[-1], between(method) * (COMPARED - 1) + 1)


def _doubted(result: Result, doubt: ErrorEstimate | None) -> Result:
    if doubt is None or not doubt.contrary:
        said = (
            "" if doubt is None or math.isfinite(doubt.final_error) else _unbounded(result, doubt)
        )
        return replace(result, doubt=doubt, evidence=result.evidence + said)
    return replace(result, doubt=doubt, outcome=Outcome.UNDETERMINED, evidence=doubt.contrary)


def _unbounded(result: Result, doubt: ErrorEstimate) -> str:
    """What is known of a final state whose error has no bound, and what to ask instead."""
    finer = bool(result.tolerance > METHODS[result.choice.method].finest)  # SciPy's is of NumPy
    why = f"runs within the tolerance {result.tolerance:g} of it part after {doubt.together:.0%} "
    why += "of its time"
    if doubt.growth > 1:
        why = f"an error of the tolerance {result.tolerance:g} {grows(doubt.growth)}"
    return (
        f"; the error of the final state has no bound: {why}; ask for an earlier last time"
        + " or a smaller tolerance" * finer
    )


def _run(
    legs: Sequence[Leg],
    launches: Starts,
    settings: Settings,
    methods: Sequence[str],
    progress: Callable[[int, int], None] | None,
    *,
    by_user: bool = True,
) -> list[Result]:
    """Run legs, each by its method, and judge how they ended; `by_user` as for `_judged`."""
    if launches.dry:
        asked = shared(legs[0].flow, settings.executor)

        def task(i: int) -> Callable[[], DryPath]:
            return partial(_dry, asked, legs[i].numbers, methods[i])

        with closing(
            ordered(
                range(len(legs)),
                task,
                executor=settings.executor,
                workers=settings.workers or CORES,
                start_pool=here,
                progress=Counted(progress, len(legs)),
            )
        ) as results:
            dries = [dry for _, dry in results]
        names = [explicit() if method == "auto" else method for method in methods]
        said = "sliding and sticking; landings by LSODA, onsets by CVODES"
        ran = [(dry.path, Choice(name, said)) for dry, name in zip(dries, names, strict=True)]
        return _judged(legs, ran, launches, settings, dries, by_user=by_user)
    by_leg: dict[int, tuple[Path, Choice]] = {}
    for method in dict.fromkeys(methods):
        mine = [i for i, name in enumerate(methods) if name == method]
        paths, choices = run(
            [legs[i] for i in mine],
            method,
            workers=settings.workers,
            progress=progress,
            executor=settings.executor,
        )
        by_leg |= zip(mine, zip(paths, choices, strict=True), strict=True)
    return _judged(legs, [by_leg[i] for i in range(len(legs))], launches, settings, by_user=by_user)


def _dry(flow: Callable[[], Flow], numbers: tuple[Any, ...], method: str) -> DryPath:
    """One launch with dry friction, by a worker."""
    with ASKING:  # sticking and landing have flows that the threads of a process share
        return integrate_dry(Leg(flow(), *numbers), method)


def _finer(tolerance: float, turning: Floats) -> float:
    """The tolerance of a launch: finer by a decade for each decade of angular velocity above 10.

    The normal force holds products of angular velocities.  The error of a product is the error of
    one factor times the other.
    """
    fast = float(np.abs(turning).max(initial=0.0)) / 10
    return tolerance if fast <= 1 else max(tolerance * 10.0 ** -np.ceil(np.log10(fast)), TIGHTEST)


def _judged(
    legs: Sequence[Leg],
    ran: Sequence[tuple[Path, Choice]],
    launches: Starts,
    settings: Settings,
    dries: Sequence[DryPath] | None = None,
    *,
    by_user: bool = True,
) -> list[Result]:
    """How each of some paths ended; the motions nearest to their ends are found together.

    Of a neighbour, which is not the user's own launch, only its outcome counts.
    """
    paths, why = [], []
    for leg, (path, _) in zip(legs, ran, strict=True):
        moved = None
        if path.end is not None and dries is None and path.end.kind != FLAT:
            moved = closer(leg, path)
        paths.append(moved[0] if moved else path)
        why.append(moved[1] if moved else "")
    ends = np.array([path.states[-1] if path.end is None else path.end.state for path in paths])
    p = np.array([leg.p[: len(leg.flow.system.parameters)] for leg in legs])
    near = [NOWHERE] * len(legs)
    if by_user or not launches.settling.idle:
        near = launches.settling.each(legs[0].flow.reported(ends), p, settings.settle)
    return [
        _judge(leg, path, end, choice, nearest, launches, settings, dry, said)
        for leg, path, end, (_, choice), nearest, dry, said in zip(
            legs, paths, ends, ran, near, dries or repeat(None, len(legs)), why, strict=True
        )
    ]


def _judge(  # noqa: PLR0913
    leg: Leg,
    path: Path,
    final: Floats,
    choice: Choice,
    near: Nearest,
    launches: Starts,
    settings: Settings,
    dry: DryPath | None,
    why: str,
) -> Result:
    end: End | None = path.end
    time = float(leg.times[-1]) if end is None else end.time
    p = leg.p[: len(leg.flow.system.parameters)]
    since = time
    if end is not None:
        outcome, evidence = _ending(leg, end)
        evidence = why or evidence
        if end.kind in leg.flow.guards and not end.early:
            path = replace(path, end=replace(end, lags=_lags(leg, end)))
    else:
        outcome, evidence = Outcome.MOVING, near.evidence
        if near.settled:
            outcome = Outcome.SETTLED
            states = leg.flow.reported(path.states)
            since = float(leg.times[launches.settling.since(states, p, near, settings.settle)])
    bare = launches.dimensionless or outcome is Outcome.UNRESOLVED  # of seconds, and of steps
    return Result(
        path,
        choice,
        outcome,
        time,
        final,
        near,
        since,
        dry,
        evidence + ("" if bare else " (dimensionless numbers)"),
        max(leg.tolerance, METHODS[choice.method].finest),
        leg.flow.compared,
    )


def _lags(leg: Leg, end: End) -> Floats:
    """Shift in time of the zero of an end's guard for a unit change of each entry of the state."""
    index = list(leg.flow.guards).index(end.kind)
    rate = abs(float(leg.flow.margins(end.state, leg.p)[1][index]))
    slope: Floats = np.abs(np.array(leg.flow.guard_slopes(end.state, leg.p))[index])
    with np.errstate(invalid="ignore"):  # both are infinite where a root begins
        lags = slope / rate if rate else np.where(slope > 0, np.inf, 0.0)
    return np.where(np.isnan(lags), np.inf, lags)


def _ending(leg: Leg, end: End) -> tuple[Outcome, str]:
    """The outcome of an early end, and its evidence, dimensionless.

    Where dry friction makes D run to zero an integrator gives up.  Near t* D falls like the root of
    t* - t, so that D over twice its rate is the remaining time.  Or gn D and D reach zero together,
    at a point that attracts sliding motions, where gn, their ratio, is still positive: no lift-off
    (Génot & Brogliato, Eur. J. Mech. A/Solids 18 (1999) 653-677, for the planar rod).
    """
    if end.kind == OPEN_END:
        return Outcome.UNDETERMINED, ""
    margins = zip(*leg.flow.margins(end.state, leg.p), strict=True)
    seen = {n: (float(v), float(r)) for n, (v, r) in zip(leg.flow.guards, margins, strict=True)}
    d, d_rate = seen.get(NO_CONTACT, (np.inf, 0.0))
    if end.kind == LIFT_OFF and abs(d) < TOGETHER:
        why = "gn D and D have reached zero together: the contact force is not determined there"
        return Outcome.NO_CONTACT, why
    if end.kind == UNRESOLVED and d_rate < 0 and d < 1e-2:
        if d / (2 * -d_rate) < 1e-6 * max(1.0, end.time):
            why = f"D = {d:.1e} falls at {-d_rate:.1e}: it runs to zero, and the contact force "
            return Outcome.NO_CONTACT, why + "grows without bound"
    outcome = OF_END.get(end.kind, Outcome.DOMAIN_END)
    if end.message or end.kind not in seen:
        return outcome, end.message or end.kind
    value, rate = seen[end.kind]
    words = leg.flow.model.words[end.kind]
    said = words.format(value=value) if outcome is Outcome.DOMAIN_END else f"{words} {value:.1e}"
    fall = f"at {-rate:.4g}" if math.isfinite(rate) else "without bound"
    return outcome, f"{said}, falling {fall}"
