"""A motion as a labelled dataset: states, observables, events, units, provenance."""

from __future__ import annotations

import json
import platform
from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from datetime import UTC, datetime
from functools import cache, lru_cache, partial
from importlib.metadata import PackageNotFoundError, version
from typing import TYPE_CHECKING, Any

import casadi as ca
import numpy as np

from ..algebra.program import Program, entries
from ..base.citation import cited
from ..base.errors import DomainError, listed
from ..base.quantities import Kind
from ..base.types import Floats
from ..base.version import __version__
from ..bodies.families import named_by
from ..bodies.model import POSE, POSE_UNIT, Model
from ..bodies.quantities import SYSTEM
from ..integrators.flow import flow_of
from ..integrators.selection import works_of
from ..integrators.stick_slip import REST, SLIDING, STICKING
from .result import Outcome, outcome_flags
from .starts import Starts

if TYPE_CHECKING:
    import xarray

    from ..bodies.model import Model
    from ..settling.settling import Nearest
    from .result import Result, Settings
    from .starts import Starts


FORMAT = "stability trajectory 1"
"""Mark of the motion files that this package writes."""
ACCOUNT = 1e-2
"""Largest `energy_error` of a run with an outcome."""
LIBRARIES = ("casadi", "numpy", "scipy", "heyoka", "xarray")
ENERGY_ERROR = (
    "largest |audit| over the energy at the start",
    "largest |audit| over the largest sum of |x dE/dx| of the states, or the energy lost",
)
"""Definition of the energy error: of a disk, of a user's system."""


@cache
def _versions() -> str:
    found = []
    for name in LIBRARIES:
        try:
            found.append(f"{name} {version(name)}")
        except PackageNotFoundError:  # noqa: PERF203 - heyoka is optional
            continue
    return ", ".join(found) + f", python {platform.python_version()}"


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
    import xarray

    single = launches.shape == ()
    dims = _dims(launches.shape)
    y, running, modes, times = _samples(launches, results, single)
    heading = None
    if launches.dry:  # a start at rest from which slip sets in at once
        first = [r.transitions[0].direction if r.transitions else 0.0 for r in results]
        heading = np.broadcast_to(np.array(first)[:, None], y.shape[:2])
    series = _series(launches, settings, y, modes, heading)
    along = (*dims, "time")
    shape = (*launches.shape, y.shape[1])
    fast: Any = xarray.Variable
    labels = _labels(launches.model, launches.dimensionless)
    variables = {
        n: fast(along, v.reshape(shape), labels(n), fastpath=True) for n, v in series.items()
    }
    if not single:
        variables["running"] = fast(
            along,
            running.reshape(shape),
            {
                "long_name": "whether the run had not ended",
                "flag_values": [0, 1],
                "flag_meanings": "ended running",
            },
        )
    if modes is not None:
        variables["mode"] = fast(
            along,
            modes.astype(np.int8).reshape(shape),
            {
                "long_name": "mode of dry friction",
                "flag_values": np.array([SLIDING, STICKING], dtype=np.int8),
                "flag_meanings": "sliding sticking",
            },
        )
    error = account(launches, y, series) if launches.model.accounted else None
    if error is not None:
        results = _accounted(results, error)
    variables |= _summary(launches, results, error, dims)
    variables |= event_log(launches, results)
    coordinates = start_states(launches, dims)  # a launch is known by its start
    coordinates["time"] = fast("time", times, labels("time"), fastpath=True)
    for name, value in launches.given.items():
        kept = ((), value) if value.ndim == 0 else (dims, value.reshape(launches.shape))
        coordinates[name] = fast(*kept, {} if launches.law else labels(name), fastpath=True)
    if not single:  # a slice keeps it to find its own events
        numbers = np.arange(launches.count).reshape(launches.shape)
        coordinates["number"] = fast(
            dims, numbers, {"long_name": "launch, counted flat"}, fastpath=True
        )
    return _dataset(variables, coordinates, _provenance(launches, settings, results))


def _dataset(
    variables: dict[str, Any], coordinates: dict[str, Any], attributes: dict[str, Any]
) -> xarray.Dataset:
    """A dataset from variables that are known to fit.

    xarray's constructor aligns and copies, which for a short run takes as long as the integration.
    Where its direct constructor is missing, the public one gives the same dataset
    (tests/motion/test_trajectory.py).
    """
    import xarray

    try:
        import pandas
        from xarray.core.indexes import PandasIndex

        index = PandasIndex(pandas.Index(coordinates["time"].values, name="time"), "time")
        coordinates |= index.create_variables({"time": coordinates["time"]})
        every = coordinates | variables
        sizes = {d: n for v in every.values() for d, n in zip(v.dims, v.shape, strict=True)}
        return xarray.Dataset._construct_direct(
            every, set(coordinates), sizes, attributes, {"time": index}
        )
    except (ImportError, AttributeError, TypeError):
        return xarray.Dataset(variables, coordinates, attributes)


def _dims(shape: tuple[int, ...]) -> tuple[str, ...]:
    if len(shape) <= 1:
        return ("launch",)[: len(shape)]
    return tuple(f"launch_{i}" for i in range(len(shape)))


def _samples(
    launches: Starts, results: list[Result], single: bool
) -> tuple[Floats, Any, Floats | None, Floats]:
    """States over (launch, time), whether each was still running, the modes, and the times."""
    asked = launches.times
    skip = int(asked[0] != 0)  # the start was added in front
    dry = results[0].modes is not None
    if single:
        result = results[0]
        rows, times = result.path.states[skip:], asked[: len(result.path.states) - skip]
        modes = result.modes[skip:] if result.modes is not None else None
        if result.path.end is not None:
            clock = float(launches.size(Kind.TIME))
            end_time = result.time * clock
            if len(times) and times[-1] >= end_time:  # ended on a sample, or at the start
                rows, times = rows[:-1], times[:-1]
                modes = modes[:-1] if modes is not None else None
            rows = np.vstack([rows, result.final[None]])
            times = np.append(times, end_time)
            modes = np.append(modes, result.last_mode) if modes is not None else None
        return rows[None], None, modes[None] if modes is not None else None, times
    width = len(results[0].final)
    y = np.empty((len(results), len(asked), width))
    running = np.ones((len(results), len(asked)), dtype=np.int8)
    held = np.zeros(y.shape[:2]) if dry else None
    for i, result in enumerate(results):
        rows = result.path.states[skip:]
        y[i, : len(rows)] = rows
        y[i, len(rows) :] = result.final
        running[i, len(rows) :] = 0
        if held is not None and result.modes is not None:
            held[i, : len(rows)] = result.modes[skip:]
            held[i, len(rows) :] = result.last_mode
    return y, running, held, asked


def _series(
    launches: Starts,
    settings: Settings,
    y: Floats,
    modes: Floats | None,
    heading: Floats | None = None,
) -> dict[str, Floats]:
    """Every series by name, in the user's units, shape (launch, time)."""
    model = launches.model
    own, states = len(model.system.states), flow_of(model).reported(y)
    found = dict(zip(model.states, np.moveaxis(states, -1, 0), strict=True))
    found |= observe(model, y, launches.p[:, None, :], modes, heading)
    if launches.law is not None:
        found["kinetic"] = found["energy"] - found["potential"]
    if model.accounted:
        found["dissipated"] = work = y[..., own]
        found["audit"] = found["energy"] + work - launches.energies[:, None]
    if model.chart is not None:
        found = model.chart.along(y, found)
    elif settings.pose:
        found |= dict(zip(POSE, POSE_UNIT * np.moveaxis(y[..., own + 1 :], -1, 0), strict=True))
        reach = found.pop("reach")
        found["contact_x"] = found["centre_x"] + reach * np.cos(found["phi"])
        found["contact_y"] = found["centre_y"] + reach * np.sin(found["phi"])
    if launches.law is None:
        require_values(model.system.name, found)
        return found
    named = {n: q.kind for n, q in model.quantities.items() if n in found}
    if launches.dimensionless:
        return {n: found[n] for n in named}
    sizes = {kind: launches.size(kind)[..., None] for kind in set(named.values())}
    return {n: found[n] * sizes[kind] for n, kind in named.items()}


def _summary(
    launches: Starts, results: list[Result], error: Floats | None, dims: tuple[str, ...]
) -> dict[str, Any]:
    """One value for each launch: outcome, evidence, times, the nearest steady motion."""
    import xarray

    shape, clock = launches.shape, launches.size(Kind.TIME)
    make: Any = xarray.Variable

    def variable(values: Any, **attributes: Any) -> Any:
        array = np.asarray(values).reshape(shape)
        return make(dims, array, attributes, fastpath=True)

    second = launches.unit("time")
    account = (
        {}
        if error is None
        else {
            "energy_error": variable(error, units="1", long_name=ENERGY_ERROR[launches.law is None])
        }
    )
    return {
        "outcome": variable(
            np.array([r.outcome.code for r in results], dtype=np.int8),
            long_name="what became of the launch",
            **outcome_flags(disk=launches.law is not None),
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
        **_nearest(launches, [r.near for r in results], variable),
        **_errors(results, clock, variable, second),
        "steps": variable([r.path.steps for r in results], long_name="steps of the integrator"),
        "method": variable([r.choice.method for r in results], long_name="integrator"),
    }


def _nearest(launches: Starts, near: list[Nearest], variable: Any) -> dict[str, Any]:
    """The nearest steady motions; those of a user's system only where all launches have one."""
    found = {
        "nearest_family": variable([n.family for n in near], long_name="nearest steady motion"),
        "nearest_distance": variable(
            [n.distance for n in near], units="1", long_name="dimensionless distance from it"
        ),
    }
    if launches.law is not None:
        named = list(dict.fromkeys(line.along[0] for line in launches.settling.lines))
        kinds = [named_by(n.family) for n in near]
        sizes = {kind: np.broadcast_to(launches.size(kind), len(near)) for kind in set(kinds)}
        which = enumerate(zip(near, kinds, strict=True))
        plain = launches.dimensionless
        found["nearest_at"] = variable(
            np.array([n.at * sizes[kind][i] for i, (n, kind) in which]),
            long_name=f"its {listed(named, 'or')}" if named else "the number that names it",
            units="1" if plain else f"{Kind.ANGULAR_VELOCITY.si} (theta: {Kind.ANGLE.si})",
        )
        return found
    if any(n.member is None for n in near):
        return {}
    found["nearest_distance"].attrs["long_name"] = "distance from it, in units of the states"
    member = np.array([n.member for n in near]).reshape(*launches.shape, -1)
    label = {"long_name": "states of the steady motion", "columns": " ".join(launches.model.states)}
    dims = (*found["nearest_family"].dims, "state")
    return found | {"nearest_member": type(found["nearest_family"])(dims, member, label)}


def _errors(results: list[Result], clock: Floats, variable: Any, second: str) -> dict[str, Any]:
    """Estimated errors of the final state and of the end's time; empty without neighbours."""
    if any(r.doubt is None and r.outcome is not Outcome.UNRESOLVED for r in results):
        return {}
    # a run without an outcome has no neighbours: its error has no bound
    state = [r.doubt.final_error if r.doubt else np.inf for r in results]
    late = [r.doubt.time_error if r.doubt and r.path.end else 0.0 for r in results]
    return {
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


def _body(launches: Starts) -> dict[str, Any]:
    if launches.law is None:
        name = launches.model.system.name
        return {"system": name, "states": json.dumps(launches.model.states)}
    found = {"contact": launches.law.name, "dimensionless": int(launches.dimensionless)}
    name = launches.model.system.name
    return found if name.startswith(SYSTEM) else {"body": name.rpartition(", ")[0]} | found


def _provenance(launches: Starts, settings: Settings, results: list[Result]) -> dict[str, Any]:
    used = Counter(r.choice.method for r in results)
    outcomes = Counter(r.outcome.word for r in results)
    first, body = results[0].choice, _body(launches)
    attributes: dict[str, Any] = {
        "format": FORMAT,
        "title": launches.model.title,
        **body,
        "outcome": ", ".join(
            word if launches.shape == () else f"{count} {word}" for word, count in outcomes.items()
        ),
        "method_asked": settings.method,
        "method": ", ".join(used),
        "method_reason": first.reason,
        "tolerance": settings.tolerance,
        "tolerance_used": results[0].tolerance,
        **({"flat": settings.flat} if launches.law else {}),
        "settle": settings.settle,
        "max_steps": settings.max_steps,
        "citation": cited(
            launches.law.name if launches.law else None,
            model=launches.law is not None,
            methods=works_of(used),
        ),
        "software": f"stability {__version__}",
        "versions": _versions(),
        "source": launches.model.source,
        "created": datetime.now(UTC).isoformat(timespec="seconds"),
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


@lru_cache(maxsize=64)
def _slopes(model: Model) -> Program:
    system = model.system
    slopes = ca.densify(ca.jacobian(model.series["energy"], system.x)).T
    return Program(ca.Function("slopes", [system.x, system.p], [slopes]))


def _energy_slopes(model: Model, states: Floats, p: Floats) -> Floats:
    """Gradient of the energy, shape (…, n)."""
    given = [entries(states), entries(p)]
    return np.asarray(_slopes(model).arrays(given, states.shape[:-1])[0][..., 0])


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
    own = len(model.system.states)
    x, q = entries(states[..., :own]), entries(p)
    values = _observer(model).arrays([x, q], states.shape[:-1])[0][..., 0]
    if modes is not None and (modes == STICKING).any():
        sticking = modes == STICKING
        assert model.dry is not None
        given = model.dry.at_rest([np.broadcast_to(v, modes.shape)[sticking] for v in q])
        held = [entries(states[sticking][:, :4]), given]
        at_rest = _observer(model.dry.sticking())
        values[sticking] = at_rest.arrays(held, (int(sticking.sum()),))[0][..., 0]
    return dict(zip(model.series, np.moveaxis(values, -1, 0), strict=True))


def require_values(system: str, found: dict[str, Floats]) -> None:
    """Refuse an observable that has no value at a sample.

    Parameters
    ----------
    system
        Name of the system.
    found
        Series by name.
    """
    for name, values in found.items():
        if not np.isfinite(values).all():
            raise DomainError(
                f"{system}: {name} has no value somewhere on the way; give the system a condition "
                "that ends the run before, or leave the observable out."
            )


def account(launches: Starts, y: Floats, series: dict[str, Floats]) -> Floats:
    """Error of the energy account of each launch, over a measure of the energy.

    For the disk the measure is the energy at the start, which is positive.  The energy of a user's
    system may have any zero: there the measure is the largest Σ |x ∂E/∂x| or energy lost.

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
    if launches.law is not None:
        scale = launches.energies * launches.size(Kind.ENERGY)
    else:
        x = y[..., : len(launches.model.states)]
        share = np.abs(x * _energy_slopes(launches.model, x, launches.p[:, None, :])).sum(axis=-1)
        scale = np.maximum(share, np.abs(series["dissipated"])).max(axis=-1)
        scale = np.where(scale > 0, scale, 1.0)
    return np.asarray(audit / scale)


# --- starts and events ---


def start_states(launches: Starts, dims: tuple[str, ...]) -> dict[str, Any]:
    """The state at time 0 of each launch, also where no sample is at that time.

    Parameters
    ----------
    launches
        The launches.
    dims
        Names of their dimensions.

    Returns
    -------
    dict
        `start_state` over (…, state), in the user's units.
    """
    import xarray

    states = launches.starts.copy()
    _scale(states, launches, np.arange(launches.count))
    label = {"long_name": "state at time 0", "columns": " ".join(launches.model.states)}
    make: Any = xarray.Variable
    shaped = states.reshape(*launches.shape, -1)
    return {"start_state": make((*dims, "state"), shaped, label, fastpath=True)}


def _scale(states: Floats, launches: Starts, which: Any) -> None:
    """Give rows of states of a disk its units, row i those of launch `which[i]`."""
    if launches.dimensionless:
        return
    for column, name in enumerate(launches.model.states):
        scale = launches.size(launches.model.quantities[name].kind)
        states[:, column] *= scale[which] if scale.ndim else scale


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
    import xarray

    motion = flow_of(launches.model)
    count = len(launches.model.states)
    rows: list[tuple[int, float, str, Floats, float]] = []
    for i, result in enumerate(results):
        for t in result.transitions:
            rows.append((i, t.time, t.kind, t.state[:6], t.direction))
        end = result.path.end
        if end is not None:
            rows.append((i, end.time, result.outcome.word, motion.reported(end.state), 0.0))
    clock = launches.size(Kind.TIME)
    which = np.array([r[0] for r in rows], dtype=np.int64)
    times = np.array([r[1] for r in rows], dtype=float)
    states = np.array([r[3] for r in rows], dtype=float).reshape(len(rows), count)
    _scale(states, launches, which)

    make: Any = xarray.Variable

    def variable(dims: Any, values: Any, attributes: Any = None) -> Any:
        return make(dims, values, attributes or {}, fastpath=True)

    log: dict[str, Any] = {
        "event_launch": variable("event", which, {"long_name": "launch, counted flat"}),
        "event_time": variable(
            "event",
            times * (clock[which] if clock.ndim else clock),
            {"units": launches.unit("time")},
        ),
        "event_kind": variable("event", np.array([r[2] for r in rows], dtype="U12")),
        "event_state": variable(
            ("event", "state"),
            states,
            {"long_name": "state at the event", "columns": " ".join(launches.model.states)},
        ),
    }
    if launches.law is not None:  # no user's system sticks
        log["event_direction"] = variable(
            "event",
            np.array([r[4] for r in rows], dtype=float),
            {
                "long_name": "direction of slip from x̂, before sticking or at its onset",
                "units": Kind.ANGLE.si,
            },
        )
    return log
