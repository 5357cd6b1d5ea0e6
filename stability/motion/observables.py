"""Observables along a path; the states at which a motion starts, and those of its events."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING, Any

import casadi as ca
import numpy as np

from ..algebra.program import Program, entries
from ..base.errors import DomainError
from ..base.quantities import Kind
from ..base.types import Floats
from ..bodies.model import Model
from ..integrators.flow import flow_of
from ..integrators.stick_slip import REST, STICKING
from .starts import Starts

if TYPE_CHECKING:
    from .result import Result

ENERGY_ERROR = (
    "largest |audit| over the energy at the start",
    "largest |audit| over the largest sum of |x dE/dx| of the states, or the energy lost",
)
"""Definition of the energy error: of a disk, of a user's system."""


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
