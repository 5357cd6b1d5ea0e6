"""A motion as a labelled dataset: states, observables, events, units, provenance."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from functools import cache, lru_cache, partial
from typing import TYPE_CHECKING, Any

import casadi as ca
import numpy as np

from ..algebra.program import Program, entries
from ..base.provenance import today, versions
from ..base.quantities import Kind
from ..base.types import Floats
from ..base.version import __version__
from ..bodies.model import POSE, POSE_UNIT, Model
from ..integrators.flow import flow_of
from ..integrators.selection import works_of
from ..integrators.stick_slip import REST, SLIDING, STICKING, Transition
from ..storage.datasets import labelled
from .result import Outcome, Result, Settings, outcome_flags
from .starts import Starts

if TYPE_CHECKING:
    import xarray


FORMAT = "stability trajectory 1"
"""Mark of the motion files that this package writes."""
ACCOUNT = 1e-2
"""Largest `energy_error` of a run with an outcome."""
LIBRARIES = ("casadi", "numpy", "scipy", "heyoka", "xarray")


@lru_cache(maxsize=64)
def _labels(model: Model, dimensionless: bool) -> Callable[[str], dict[str, str]]:  # noqa: FBT001
    """Name in words and units of each series."""
    return cache(partial(model.attributes, dimensionless=dimensionless))


def assemble(launches: Starts, settings: Settings, results: list[Result]) -> xarray.Dataset:
    """The dataset that `simulate` returns.

    Parameters
    ----------
    launches
        The launches.
    settings
        Settings of the runs.
    results
        Result of each launch.

    Returns
    -------
    xarray.Dataset
    """
    single, dims = launches.shape == (), _dims(launches.shape)
    y, running, modes, times = _samples(launches, results)
    heading = None
    if launches.dry:  # a start at rest from which slip sets in at once
        first = [log[0].direction if (log := _transitions(r)) else 0.0 for r in results]
        heading = np.broadcast_to(np.array(first)[:, None], y.shape[:2])
    series = _series(launches, settings, y, modes, heading)
    labels = _labels(launches.model, launches.dimensionless)

    def along(values: Any, **attributes: Any) -> Any:
        return (*dims, "time"), values.reshape(*launches.shape, -1), attributes

    variables = {n: along(v, **labels(n)) for n, v in series.items()}
    if not single:
        variables["running"] = along(
            running,
            long_name="whether the run had not ended",
            flag_values=[0, 1],
            flag_meanings="ended running",
        )
    if modes is not None:
        variables["mode"] = along(
            modes.astype(np.int8),
            long_name="mode of dry friction",
            flag_values=np.array([SLIDING, STICKING], dtype=np.int8),
            flag_meanings="sliding sticking",
        )
    error = account(launches, y, series) if launches.model.accounted else None
    if error is not None:
        results = _accounted(results, error)
    variables |= _summary(launches, results, error, dims)
    variables |= event_log(launches, results)
    states = launches.states_in_units(launches.starts).reshape(*launches.shape, -1)
    coordinates = {  # a launch is known by its start
        "start_state": _states((*dims, "state"), launches, states, "at time 0"),
        "time": ("time", times, labels("time")),
    }
    for name, value in launches.given.items():
        axes, kept = (dims, value.reshape(launches.shape)) if value.ndim else ((), value)
        coordinates[name] = axes, kept, launches.subject.numbers.get(name, {})
    if not single:  # a slice keeps it to find its own events
        numbers = np.arange(launches.count).reshape(launches.shape)
        coordinates["number"] = dims, numbers, {"long_name": "launch, counted flat"}
    return labelled(variables, coordinates, _provenance(launches, settings, results))


def _states(dims: tuple[str, ...], launches: Starts, states: Floats, when: str) -> Any:
    """States in the user's units, shape (…, s), as a labelled array."""
    names = " ".join(launches.model.states)
    return dims, states, {"long_name": f"state {when}", "columns": names}


def _dims(shape: tuple[int, ...]) -> tuple[str, ...]:
    if len(shape) <= 1:
        return ("launch",)[: len(shape)]
    return tuple(f"launch_{i}" for i in range(len(shape)))


def _samples(
    launches: Starts, results: list[Result]
) -> tuple[Floats, Floats, Floats | None, Floats]:
    """States over (launch, time), whether each was still running, the modes, and the times."""
    times = launches.times
    skip, kept = int(times[0] != 0), len(times)  # the start was added in front
    if launches.shape == () and results[0].path.end is not None:  # the end is the last sample
        end = results[0].time * float(launches.size(Kind.TIME))
        before = times[: len(results[0].path.states) - skip]
        kept = len(before) - int(len(before) > 0 and before[-1] >= end)
        times = np.append(before[:kept], end)
    y = np.empty((len(results), len(times), len(results[0].final)))
    running = np.ones(y.shape[:2], dtype=np.int8)
    modes = np.zeros(y.shape[:2]) if launches.dry else None
    for i, result in enumerate(results):
        rows = result.path.states[skip:][:kept]
        y[i, : len(rows)] = rows
        y[i, len(rows) :] = result.final
        running[i, len(rows) :] = 0
        if modes is not None and result.dry is not None:
            modes[i, : len(rows)] = result.dry.modes[skip:][:kept]
            modes[i, len(rows) :] = result.dry.mode
    return y, running, modes, times


def _transitions(result: Result) -> list[Transition]:
    """The transitions between sliding and sticking."""
    return result.dry.transitions if result.dry else []


def _series(
    launches: Starts,
    settings: Settings,
    y: Floats,
    modes: Floats | None,
    heading: Floats | None = None,
) -> dict[str, Floats]:
    """Every series by name, in the user's units, shape (launch, time)."""
    model = launches.model
    count, states = len(model.system.states), flow_of(model).reported(y)
    series = dict(zip(model.states, np.moveaxis(states, -1, 0), strict=True))
    series |= observe(model, y, launches.p[:, None, :], modes, heading)
    if model.accounted:
        series["dissipated"] = work = y[..., count]
        series["audit"] = series["energy"] + work - launches.energies[:, None]
    if model.chart is not None:
        series = model.chart.along(y, series)
    elif settings.pose:
        series |= dict(zip(POSE, POSE_UNIT * np.moveaxis(y[..., count + 1 :], -1, 0), strict=True))
        reach = series.pop("reach")
        series["contact_x"] = series["centre_x"] + reach * np.cos(series["phi"])
        series["contact_y"] = series["centre_y"] + reach * np.sin(series["phi"])
    return launches.subject.in_units(launches, series)


def _summary(
    launches: Starts, results: list[Result], error: Floats | None, dims: tuple[str, ...]
) -> dict[str, Any]:
    """One value for each launch: outcome, evidence, times, the nearest steady motion."""
    clock = launches.size(Kind.TIME)

    def variable(values: Any, **attributes: Any) -> Any:
        return dims, np.asarray(values).reshape(launches.shape), attributes

    second = launches.unit("time")
    subject, account = launches.subject, {}
    if error is not None:
        account["energy_error"] = variable(error, units="1", long_name=subject.energy_error)
    return {
        "outcome": variable(
            np.array([r.outcome.code for r in results], dtype=np.int8),
            long_name="what became of the launch",
            **outcome_flags(subject.outcomes),
        ),
        "evidence": variable([r.evidence for r in results], long_name="why"),
        "end_time": variable(
            np.array([r.time for r in results]) * clock, long_name="end of the run", units=second
        ),
        "settled_time": variable(
            np.array([r.settled_at for r in results]) * clock,
            long_name="time from which it stayed near the steady motion, or the end",
            units=second,
        ),
        **account,
        **subject.nearest(launches, [r.near for r in results], variable),
        **_errors(results, clock, variable, second),
        "steps": variable([r.path.steps for r in results], long_name="steps of the integrator"),
        "method": variable([r.choice.method for r in results], long_name="integrator"),
    }


def _errors(results: list[Result], clock: Floats, variable: Any, second: str) -> dict[str, Any]:
    """Estimated errors of the final state and of the end's time; empty without neighbours."""
    if any(r.doubt is None and r.outcome is not Outcome.UNRESOLVED for r in results):
        return {}
    # a run without an outcome has no neighbours: its error has no bound
    state = [r.doubt.final_error if r.doubt else np.inf for r in results]
    late = [r.doubt.time_error if r.doubt and r.path.end else 0.0 for r in results]
    trusted = [r.time * (r.doubt.together if r.doubt else 0.0) for r in results]
    return {
        "trusted_time": variable(
            np.array(trusted) * clock,
            units=second,
            long_name="time up to which neighbours of the run, within its tolerance, stay together",
        ),
        "final_error": variable(
            state,
            units="1",
            long_name="estimated error of the final state, the largest over "
            "the states, each over 1 or its own size",
        ),
        "end_time_error": variable(
            np.array(late) * clock, units=second, long_name="estimated error of the end's time"
        ),
    }


def _accounted(results: list[Result], error: Floats) -> list[Result]:
    """The results, without the outcome of a run whose energy account does not close."""
    if not (error > ACCOUNT).any():
        return results
    return [
        result
        if error[i] <= ACCOUNT
        else replace(
            result,
            outcome=Outcome.UNRESOLVED,
            evidence=f"the energy account fails by {error[i]:.1e} of the initial energy",
        )
        for i, result in enumerate(results)
    ]


def _provenance(launches: Starts, settings: Settings, results: list[Result]) -> dict[str, Any]:
    used = Counter(r.choice.method for r in results)
    outcomes = Counter(r.outcome.word for r in results)
    first, subject = results[0].choice, launches.subject
    attributes: dict[str, Any] = {
        "format": FORMAT,
        "title": launches.model.title,
        **subject.attributes,
        "outcome": ", ".join(
            word if launches.shape == () else f"{count} {word}" for word, count in outcomes.items()
        ),
        "method_asked": settings.method,
        "method": ", ".join(used),
        "method_reason": first.reason,
        "tolerance": settings.tolerance,
        "tolerance_used": results[0].tolerance,
        **{n: getattr(settings, n) for n in subject.settings},
        "settle": settings.settle,
        "max_steps": settings.max_steps,
        "citation": subject.cited(methods=works_of(used)),
        "software": f"stability {__version__}",
        "versions": versions(LIBRARIES),
        "source": launches.model.source,
        "created": today(),
        "Conventions": "CF-1.11",
    }
    if launches.shape == ():
        attributes["evidence"] = results[0].evidence
        attributes["outcome_sentence"] = results[0].outcome.value
        attributes["parameters"] = json.dumps(
            {n: float(v) for n, v in launches.given.items()}, sort_keys=True
        )
    return attributes


@lru_cache(maxsize=64)
def _observer(model: Model) -> Program:
    """Program of every series from states and parameters."""
    system, values = model.system, list(model.series.values())
    return Program(ca.Function("observer", [system.x, system.p], [ca.densify(ca.vertcat(*values))]))


def observe(
    model: Model,
    states: Floats,
    p: Floats,
    modes: Floats | None = None,
    heading: Floats | None = None,
) -> dict[str, Floats]:
    """The observables of states.

    Parameters
    ----------
    model
        Model of the body or system.
    states
        Entries of y, of which those of the system's states count, shape (…, n).
    p
        Parameters of the system, shape (…, m).
    modes
        Sliding or sticking, shape (…), for dry friction.
    heading
        Direction of the slip where it is zero but sets in, shape (…) [rad].

    Returns
    -------
    dict
        Arrays of shape (…) by name.
    """
    if not model.series:
        return {}
    if heading is not None:
        still = np.hypot(states[..., 4], states[..., 5]) < REST
        states = states.copy()
        states[still, 4] = REST * np.cos(heading[still])
        states[still, 5] = REST * np.sin(heading[still])
    count = len(model.system.states)
    x, q = entries(states[..., :count]), entries(p)
    values = _observer(model).arrays([x, q], states.shape[:-1])[0][..., 0]
    if modes is not None and (modes == STICKING).any():
        sticking = modes == STICKING
        assert model.dry is not None
        parameters = model.dry.at_rest([np.broadcast_to(v, modes.shape)[sticking] for v in q])
        held = [entries(states[sticking][:, :4]), parameters]
        at_rest = _observer(model.dry.sticking())
        values[sticking] = at_rest.arrays(held, (int(sticking.sum()),))[0][..., 0]
    return dict(zip(model.series, np.moveaxis(values, -1, 0), strict=True))


def account(launches: Starts, y: Floats, series: dict[str, Floats]) -> Floats:
    """Error of the energy account of each launch, over a measure of the energy.

    Parameters
    ----------
    launches
        Launches with an energy account.
    y
        Entries of y, shape (N, t, n).
    series
        Series by name in the user's units, shape (N, t).

    Returns
    -------
    ndarray
        Shape (N,).
    """
    audit = np.abs(series["audit"]).max(axis=-1)
    return np.asarray(audit / launches.subject.energy_scale(launches, y, series))


def event_log(launches: Starts, results: list[Result]) -> dict[str, Any]:
    """The event log: transitions between sliding and sticking, and early ends.

    Parameters
    ----------
    launches, results
        The launches, and the result of each.

    Returns
    -------
    dict
        Variables over (event), and `event_state` over (event, state).
    """
    motion = flow_of(launches.model)
    rows: list[tuple[int, float, str, Floats, float]] = []
    for i, result in enumerate(results):
        for t in _transitions(result):
            rows.append((i, t.time, t.kind, t.state[:6], t.direction))
        end = result.path.end
        if end is not None:
            rows.append((i, end.time, result.outcome.word, motion.reported(end.state), 0.0))
    which = np.array([r[0] for r in rows], dtype=np.int64)
    times = np.array([r[1] for r in rows], dtype=float) * launches.clock[which]
    states = np.array([r[3] for r in rows]).reshape(len(rows), len(launches.model.states))
    states = launches.states_in_units(states, which)
    log: dict[str, Any] = {
        "event_launch": ("event", which, {"long_name": "launch, counted flat"}),
        "event_time": ("event", times, {"units": launches.unit("time")}),
        "event_kind": ("event", np.array([r[2] for r in rows], dtype="U12"), {}),
        "event_state": _states(("event", "state"), launches, states, "at the event"),
    }
    if launches.subject.slips:
        words = "direction of slip from x̂, before sticking or at its onset"
        angles = np.array([r[4] for r in rows], dtype=float)
        label = {"long_name": words, "units": Kind.ANGLE.si}
        log["event_direction"] = "event", angles, label
    return log
