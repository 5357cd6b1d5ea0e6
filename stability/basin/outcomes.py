"""The outcome of many launches, without samples: each launch ends as soon as it is proved.

A launch ends where its settling is proved, where a guard reaches zero, or at its last time.  It is
run again at a looser tolerance from a slightly changed start, and the difference is the estimate of
its error.  Where the two end differently, or an end is of a rare kind, `simulate` with all its
neighbours decides (`stability.motion.run`).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..base.types import Floats
from ..bodies.model import FLAT, LIFT_OFF, NO_CONTACT
from ..integrators.flow import ASKING, Flow, flow_of
from ..integrators.lanes import EVENT, FAILED, LASTED, PROVED, ends, lean_of
from ..integrators.taylor import at_guards, available, unread
from ..motion.error_estimate import signs
from ..motion.result import CODES, OF_END, Outcome, Settings
from ..motion.run import TOGETHER, results
from ..motion.starts import Starts
from ..settling.settling import NONE, Settling, Watcher

LOOSER = 100.0
"""Tolerance of the second run over that of the first."""
ROUNDING = 2.0**-53
"""Relative size of a rounding error."""
PARTED = 0.01
"""Error of a steady motion or final state beyond which the two runs of a launch have parted."""


@dataclass(frozen=True, eq=False)
class Outcomes:
    """Outcomes of N launches, dimensionless for a body."""

    outcome: NDArray[np.int8]
    """Flag values of `Outcome`, shape (N,)."""
    time: Floats
    """Time of the end: of the event, of the proof, or the last time, shape (N,)."""
    family: NDArray[np.int8]
    """Number of the family that is settled on, `NONE` for none, shape (N,)."""
    member: Floats
    """Value that names the steady motion that is settled on; NaN for none, shape (N,)."""
    member_error: Floats
    """Bound on its distance from the true one, for the state that was computed; NaN for none."""
    error: Floats
    """Estimated effect of the integration's error on time, member or final state; NaN where the
    launch was not run again, or its runs part, shape (N,)."""
    steps: NDArray[np.int64]
    """Steps of the first run, shape (N,)."""


def outcomes(
    launches: Starts, settings: Settings, before_single: Callable[[], Any] = lambda: None
) -> Outcomes:
    """Judge every launch.

    Parameters
    ----------
    launches
        Launches, gathered with marks; the last of their times is the horizon.
    settings
        Settings; `check` asks for a second run, at a looser tolerance.
    before_single
        Called when all lanes have come to their ends, before launches are decided one by one.

    Returns
    -------
    Outcomes

    Source: tests/basin/test_outcomes.py compares them with `simulate`.
    """
    fit = np.ones(launches.count, dtype=bool)
    table = _blank(launches.count)
    flow = flow_of(launches.model)
    ended = (launches.unfit or {}) | dict.fromkeys(launches.flat(settings.flat).tolist(), FLAT)
    for row, kind in ended.items():
        fit[row] = False
        table.outcome[row] = CODES[OF_END.get(kind, Outcome.DOMAIN_END)]
        table.error[row] = 0.0
    rows = np.flatnonzero(fit)
    if not rows.size:
        return table
    alone = rows
    if on_lanes(launches):
        alone = _together(table, launches, rows, settings, flow)
        before_single()
    _singly(table, launches, alone, settings)
    return table


def on_lanes(launches: Starts) -> bool:
    """Whether launches run on the lanes of heyoka; otherwise each is run as by `simulate`.

    Parameters
    ----------
    launches
        Launches, or some of them.
    """
    return not launches.dry and available() and not unread(flow_of(launches.model))


def _blank(count: int) -> Outcomes:
    nan = np.full(count, np.nan)
    return Outcomes(
        np.full(count, CODES[Outcome.MOVING], dtype=np.int8),
        np.zeros(count),
        np.full(count, NONE, dtype=np.int8),
        nan.copy(),
        nan.copy(),
        nan.copy(),
        np.zeros(count, dtype=np.int64),
    )


def _together(
    table: Outcomes, launches: Starts, rows: NDArray[np.intp], settings: Settings, flow: Flow
) -> NDArray[np.intp]:
    """Run launches on lanes, twice; those that the two runs leave open."""
    starts, p = flow.pack(launches.starts[rows]), launches.flow_p(settings.flat)[rows]
    horizon = launches.times[-1] / launches.clock[rows]
    tolerance, settling = settings.tolerance, launches.settling
    first = _judged(flow, starts, p, horizon, tolerance, settings, settling)
    alone = first.outcome == CODES[Outcome.UNRESOLVED]
    if settings.check:
        loose = min(tolerance * LOOSER, 1e-2)
        states = launches.starts[rows]
        moved = flow.pack(states * (1 + tolerance * signs(states.shape[1])))
        second = _judged(flow, moved, p, horizon, loose, settings, settling)
        same = (first.outcome == second.outcome) & (first.family == second.family)
        alone |= ~same
        first.error[:] = _differences(first, second)
        first.error[:] *= _decades(tolerance, loose)
        # where the two runs have parted, neither says how the launch ends
        lasting = np.isin(first.outcome, [CODES[Outcome.MOVING], CODES[Outcome.SETTLED]])
        alone |= lasting & (first.error > PARTED)
    _write(table, rows, first)
    left: NDArray[np.intp] = rows[alone]
    return left


def _decades(tolerance: float, loose: float) -> float:
    """Factor from the difference of two runs to the error of the first.

    A motion that leaves an unstable one leaves later by equal times for each decade of error: the
    two runs differ by the decades between their tolerances, the first from an exact motion by those
    down to rounding.
    """
    if not loose > tolerance:
        return 1.0
    return max(1.0, math.log(tolerance / ROUNDING) / math.log(loose / tolerance))


@dataclass(frozen=True, eq=False)
class _RunOutcomes(Outcomes):
    """Outcomes of one run with the states at its ends."""

    state: Floats
    """y at the end, shape (N, n)."""


def _judged(
    flow: Flow,
    starts: Floats,
    p: Floats,
    horizon: Floats,
    tolerance: float,
    settings: Settings,
    settling: Settling,
) -> _RunOutcomes:
    """One run of launches, and what its ends mean; rare ends count as unresolved."""
    lean = lean_of(flow)
    parameters = p[:, : len(flow.system.parameters)]
    watch = Watcher(settling, lean.report, parameters, horizon, settings.settle)
    done = ends(lean.flow, lean.pack(starts), p, horizon, tolerance, settings.max_steps, watch)
    run = _RunOutcomes(**vars(_blank(len(starts))), state=lean.whole(done.state))
    run.time[:], run.steps[:] = done.time, done.steps
    run.outcome[done.kind == FAILED] = CODES[Outcome.UNRESOLVED]
    proved = done.kind == PROVED
    run.outcome[proved] = CODES[Outcome.SETTLED]
    run.family[:], run.member[:], run.member_error[:] = watch.family, watch.member, watch.error
    with ASKING:
        kept = np.flatnonzero(proved | (done.kind == LASTED))
        if kept.size and flow.guards:
            lost = ~(flow.margins(run.state[kept], p[kept])[0] > 0).all(axis=1)
            run.outcome[kept[lost]] = CODES[Outcome.UNRESOLVED]
        rows = np.flatnonzero(done.kind == EVENT)
        if rows.size:
            _events(run, flow, rows, p, horizon)
    return run


def _events(
    run: _RunOutcomes, flow: Flow, rows: NDArray[np.intp], p: Floats, horizon: Floats
) -> None:
    """Name events, and move them along the motion to the zeros of their guards."""
    names, parameters = list(flow.guards), p[rows]
    which, times, y = at_guards(flow, parameters, run.state[rows], run.time[rows], horizon[rows])
    run.state[rows], run.time[rows] = y, times
    for kind in set(which.tolist()):
        mine = rows[which == kind]
        run.outcome[mine] = CODES[OF_END.get(names[kind], Outcome.DOMAIN_END)]
    if NO_CONTACT in names:  # the contact force may be singular: decided alone
        near = np.abs(flow.margins(y, parameters)[0][:, names.index(NO_CONTACT)]) < 1e4 * TOGETHER
        contact = np.array([names[k] in (LIFT_OFF, NO_CONTACT) for k in which])
        run.outcome[rows[near & contact]] = CODES[Outcome.UNRESOLVED]


def _differences(first: _RunOutcomes, second: _RunOutcomes) -> Floats:
    """What the integration's error changes: member, time of an event, or final state."""
    differences = np.full(len(first.time), np.nan)
    same = (first.outcome == second.outcome) & (first.family == second.family)
    settled = same & (first.outcome == CODES[Outcome.SETTLED])
    differences[settled] = np.abs(first.member - second.member)[settled]
    lasted = same & (first.outcome == CODES[Outcome.MOVING])
    size = np.maximum(1.0, np.abs(first.state[lasted]))
    differences[lasted] = (np.abs(first.state - second.state)[lasted] / size).max(axis=1)
    other = same & ~settled & ~lasted
    differences[other] = np.abs(first.time - second.time)[other]
    return differences


def _write(table: Outcomes, rows: NDArray[np.intp], run: Outcomes) -> None:
    for name in Outcomes.__dataclass_fields__:
        getattr(table, name)[rows] = getattr(run, name)


def _singly(table: Outcomes, launches: Starts, rows: NDArray[np.intp], settings: Settings) -> None:
    """Decide some launches one by one, with all their neighbours."""
    if not rows.size:
        return
    some = results(launches.some(rows), replace(settings, check=True, workers=1))
    for row, result in zip(rows, some, strict=True):
        table.outcome[row] = result.outcome.code
        table.time[row] = result.settled_at if result.outcome is Outcome.SETTLED else result.time
        table.steps[row] = result.path.steps
        doubt = result.doubt
        if doubt is not None:
            timed = result.outcome not in (Outcome.SETTLED, Outcome.MOVING)
            error = doubt.time_error if timed else doubt.final_error
            table.error[row] = error if math.isfinite(error) else np.nan
        if result.outcome is Outcome.SETTLED:
            near = result.near
            table.family[row] = launches.settling.names.index(near.family)
            table.member[row], table.member_error[row] = near.limit, near.error
