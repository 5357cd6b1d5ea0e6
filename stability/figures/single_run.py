"""One launch of a motion as its samples, events and spans of sticking, for figures."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..base.errors import ParameterError, shown
from ..base.types import Floats
from ..bodies.model import POSE
from ..integrators.stick_slip import SLIP, STICK, STICKING
from ..motion.dataset import FORMAT

if TYPE_CHECKING:
    import xarray


KEPT = (
    "end_time",
    "event_time",
    "event_kind",
    "event_launch",
    "outcome",
    "evidence",
    "method",
)
"""Variables that every figure needs in addition to its series."""
ACCOUNT = ("energy", "dissipated", "audit")
"""Series of the energy; a user's system has them where it observes `energy` and `power`."""
PLACES = (*POSE, "contact_x", "contact_y")
"""Series of a disk's place."""
Event = tuple[float, str]
Span = tuple[float, float]


class SingleRun(NamedTuple):
    """One launch up to its end: samples, times, events, and spans of sticking."""

    data: xarray.Dataset
    """The dataset, cut at the end of the run."""
    times: Floats
    """Times of the samples."""
    events: list[Event]
    """Time and word of each event between the first and the last sample."""
    sticking: list[Span]
    """Begin and end of each span of sticking."""
    trusted: float
    """Time after which neighbours of the run part: the motion is not known there."""


def one_launch(dataset: xarray.Dataset, needed: tuple[str, ...]) -> SingleRun:
    """One launch up to its end; an error in one sentence for other datasets.

    Parameters
    ----------
    dataset
        From `simulate`.
    needed
        Names of the series that it must have.

    Returns
    -------
    SingleRun

    Raises
    ------
    ParameterError
        If the dataset is not from `simulate`, holds several launches, lacks a series, or has
        fewer than two samples.
    """
    import xarray

    if not isinstance(dataset, xarray.Dataset) or dataset.attrs.get("format") != FORMAT:
        raise ParameterError(f"dataset is {shown(dataset)}; give what simulate returns.")
    missing = [name for name in ("time", *needed, *KEPT) if name not in dataset.variables]
    if missing and system_states(dataset) and missing[0] not in ("time", *KEPT):
        raise ParameterError(
            f"dataset of {dataset.attrs['system']} has no {missing[0]}; this figure needs "
            + ("a system that observes energy and power." if missing[0] in ACCOUNT else "a disk.")
        )
    if missing:
        remedy = "with pose=True" if missing[0] in PLACES else "unchanged"
        raise ParameterError(f"dataset has no {missing[0]}; give what simulate returns {remedy}.")
    several = [d for d in dataset.sizes if d not in ("time", "event", "state")]
    if several:
        taken = ", ".join(f"{d}=i" for d in several)
        count = " x ".join(str(dataset.sizes[d]) for d in several)
        raise ParameterError(f"dataset holds {count} launches; take one by .isel({taken}).")
    data = _until_end(dataset)
    if data.sizes.get("time", 0) < 2:
        raise ParameterError("dataset has fewer than two samples; ask simulate for more times.")
    times = np.asarray(data.time.values, dtype=float)
    log = events_of(data)
    spans = _spans(log, data, times)
    seen = [(t, word) for t, word in log if times[0] <= t <= times[-1]]
    end = float(data.trusted_time) if "trusted_time" in data else times[-1]
    return SingleRun(data, times, seen, spans, end if end < times[-1] else np.inf)


def length_of(data: xarray.Dataset) -> float:
    """The unit of length of a motion: the radius of a disk, the `length` of another body."""
    return float(data["length" if "body" in data.attrs else "radius"])


def system_states(dataset: Any) -> tuple[str, ...]:
    """The states of a user's system; none for a disk.

    Parameters
    ----------
    dataset
        From `simulate`.

    Returns
    -------
    tuple of str
    """
    states = getattr(dataset, "attrs", {}).get("states", "[]")
    return tuple(json.loads(states)) if isinstance(states, str) else ()


def _until_end(dataset: xarray.Dataset) -> xarray.Dataset:
    """A slice of several launches without repeated last states; its last sample is at its end."""
    if "running" not in dataset or dataset.running.values.all():
        return dataset
    count = int(np.argmin(dataset.running.values))
    times, end = dataset.time.values[: count + 1].astype(float), float(dataset.end_time)
    if count and times[count - 1] >= end:
        return dataset.isel(time=slice(0, count))
    times[-1] = end
    kept = dataset.isel(time=slice(0, count + 1))
    return kept.assign_coords(time=("time", times, dataset.time.attrs))


def events_of(data: xarray.Dataset) -> list[Event]:
    """The events of this launch; a slice of several launches selects them by its number.

    Parameters
    ----------
    data
        From `simulate`, one launch.

    Returns
    -------
    list of (time, word)
        In order of time.
    """
    rows = data.event_launch.values == int(data.coords.get("number", 0))
    pairs = zip(data.event_time.values[rows], data.event_kind.values[rows], strict=True)
    return sorted((float(t), str(word)) for t, word in pairs)


def _spans(log: list[Event], data: xarray.Dataset, times: Floats) -> list[Span]:
    """Spans of sticking from the log, or from the samples where the log has no such event."""
    if "mode" not in data:
        return []
    stuck = data["mode"].values == STICKING
    turns = [(t, word) for t, word in log if word in (STICK, SLIP)]
    if not turns:
        flips = np.flatnonzero(np.diff(stuck.astype(int))) + 1
        turns = [(float(times[i]), STICK if stuck[i] else SLIP) for i in flips]
    begins = turns[0][1] == SLIP if turns else bool(stuck[0])
    edges = [-np.inf] * begins + [t for t, _ in turns]
    edges += [np.inf] * (len(edges) % 2)
    clipped = np.clip(edges, times[0], times[-1]).reshape(-1, 2).tolist()
    return [(a, b) for a, b in clipped if b > a]
