"""Tables of states in the dataset of a motion: each start, and each event."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..base.quantities import Kind
from ..base.types import Floats
from ..integrators.flow import flow_of

if TYPE_CHECKING:
    from .result import Result
    from .starts import Starts


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
    for column, name in ((slice(1, 4), "rate"), (slice(4, 6), "speed")):
        scale = launches.scales[name]
        states[:, column] *= scale[which][:, None] if scale.ndim else scale


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
    clock = launches.scales["time"]
    which = np.array([r[0] for r in rows], dtype=np.int64)
    times = np.array([r[1] for r in rows], dtype=float)
    states = np.array([r[3] for r in rows], dtype=float).reshape(len(rows), count)
    _scale(states, launches, which)

    make: Any = xarray.Variable

    def variable(dims: Any, values: Any, attributes: Any = None) -> Any:
        return make(dims, values, attributes or {}, fastpath=True)

    log: dict[str, Any] = {
        "event_launch": variable("event", which, {"long_name": "launch, counted flat"}),
        "event_time": variable("event", times * (clock[which] if clock.ndim else clock),
                               {"units": launches.unit("time")}),
        "event_kind": variable("event", np.array([r[2] for r in rows], dtype="U12")),
        "event_state": variable(("event", "state"), states, {
            "long_name": "state at the event", "columns": " ".join(launches.model.states)}),
    }  # fmt: skip
    if launches.law is not None:  # no user's system sticks
        log["event_direction"] = variable("event", np.array([r[4] for r in rows], dtype=float), {
            "long_name": "direction of slip from x̂, before sticking or at its onset",
            "units": Kind.ANGLE.si})  # fmt: skip
    return log
