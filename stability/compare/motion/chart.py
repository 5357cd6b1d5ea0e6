"""Drivers on scenes at many tolerances: work against precision, as a dataset."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ...base.errors import StabilityError
from ...base.types import Floats
from ...jobs.measured_cells import Cell, Late, Task
from ..chart import Line, attributes, csv_of, methods, numbers, padded, variable, words
from ..cost import Place, least, places, timed, timings
from .drivers import DRIVERS, MODELS, OWN, PEOPLE, Driver, MotionAnswer, driver
from .reference_motions import ReferenceMotion, scene, scenes

if TYPE_CHECKING:
    import xarray

CHARTED: dict[str, str] = {
    "gentle": "gentle: viscous, μ = 0.3, until t = 20",
    "near-threshold": "near threshold: rolling at ω₃ = 1.4142, until t = 200",
    "stiff-300": "stiff: μ = 300, until t = 20",
    "stiff-10000": "stiff: μ = 10⁴, until t = 10",
    "rough-long": "long: rough, until t = 1000",
    "slides_then_sticks": "dry friction: slides, then sticks, until t = 10",
    "near-flat": "approach to flatness: rough hoop, 6·10⁻⁴ rad from flat",
    "lift-off": "lift-off at t = 16.1",
}
"""Scenes of the chart and their titles."""
NAMES = tuple(d.name for d in (*OWN, *PEOPLE, *MODELS))
"""Drivers of the chart."""
PATIENCE = 0.3
"""Time of a run beyond which no tighter tolerance is tried [s]."""
LIMIT = 7.0
"""Time limit of a cell [s]."""
METRICS = ("final", "path", "audit", "event")
"""Names of the errors of a motion."""


def tasks() -> list[list[Task]]:
    """Tasks of the chart, each in a fresh process, so that its first call is the first."""
    return [
        [Task(f"motion/{s}/{name}", measure, (s, name), LIMIT)]
        for s in CHARTED
        if s in scenes()
        for name in NAMES
        if DRIVERS[name]().takes(scene(s))
    ]


def measure(which: str, name: str) -> dict[str, Any]:
    """One cell: a driver on a scene at all its tolerances.

    Returns
    -------
    dict
        first: seconds of the first call, or None; tolerance: values that were tried; rows: a dict
        for each of them.  A row holds final, path, audit, event (errors), outcome (a word), seconds
        (every repeat), stated and an empty message.  A row without an answer holds only the
        message: the reason.
    """
    it, mine = scene(which), driver(name)
    times = it.asked
    _forget()
    out: dict[str, Any] = {"first": None, "tolerance": [], "rows": []}
    for tolerance in mine.tolerances:
        out["tolerance"].append(tolerance)
        start = time.perf_counter()
        try:
            motion = mine.run(it, times, tolerance)
            took = time.perf_counter() - start
            out["first"] = took if out["first"] is None else out["first"]
            if took > PATIENCE:  # Taylor compiles code for each order: time the run again
                [took] = timed(lambda t=tolerance: mine.run(it, times, t), least=1, most=1)  # type: ignore[misc]
            row = judged(it, motion)
            row |= {"seconds": _repeated(mine, it, tolerance, took), "message": ""}
        except (StabilityError, ArithmeticError, ValueError, RuntimeError) as error:
            took, row = time.perf_counter() - start, {"message": str(error)[:200]}
        except Late:
            out["rows"].append({"message": f"no answer within the {LIMIT:g} s of the cell"})
            return out
        out["rows"].append(row)
        if took > PATIENCE:
            break
    return out


def _repeated(mine: Driver, it: ReferenceMotion, tolerance: float, took: float) -> list[float]:
    """Time of each repeat [s]; the first run alone where it took long."""
    if took > PATIENCE:
        return [took]
    return timed(lambda: mine.run(it, it.asked, tolerance), least=1, most=9, budget=0.08)


def _forget() -> None:
    """Keep heyoka from its store of compiled code on disk, so that a first call compiles."""
    from ...integrators import taylor

    if taylor.available():
        import heyoka

        with contextlib.suppress(AttributeError):  # older versions have no such store
            heyoka.llvm_state.set_diskcache_enabled(False)


def judged(it: ReferenceMotion, motion: MotionAnswer) -> dict[str, Any]:
    """The errors of a motion.

    Returns
    -------
    dict
        final: error of the last true state, over 1 or its size; path: the largest such error along
        the path; both None where the driver lacks a time of the truth.  event: error of the time of
        the end, where the truth has one, or of the events of dry friction; None where outcome or
        kinds of events differ, or there are none.  audit, outcome, stated: as in `MotionAnswer`.
    """
    both = [t for t in it.times if t in set(motion.times.tolist())]
    mine = motion.states[np.isin(motion.times, both)]
    true = it.states[np.isin(it.times, both)]
    off = distance(mine, true)
    whole = len(both) == len(it.times)
    return {
        "final": float(off[-1]) if whole else None,
        "path": float(off.max()) if whole else None,
        "audit": motion.audit,
        "event": _event(it, motion),
        "outcome": motion.outcome,
        "stated": motion.stated,
    }


def distance(mine: Floats, true: Floats) -> Floats:
    """Largest difference of states, each over 1 or its own size.

    Parameters
    ----------
    mine, true
        States of the driver and of the truth, shape (t, 6).

    Returns
    -------
    ndarray
        Shape (t,).
    """
    return np.asarray((np.abs(mine - true) / np.maximum(1.0, np.abs(true))).max(axis=-1))


def _event(it: ReferenceMotion, motion: MotionAnswer) -> float | None:
    if it.ends:
        return abs(motion.end_time - it.end_time) if motion.outcome == it.outcome else None
    if not it.events:
        return None
    if [kind for kind, _ in it.events] != [kind for kind, _ in motion.events]:
        return None
    pairs = zip(it.events, motion.events, strict=True)
    return max(abs(a - b) for (_, a), (_, b) in pairs)


# --- the chart as data ---


FORMAT = "stability chart motion 1"
"""Attribute `format` of a file of this chart."""
LONG = {
    "final": "error of the last state, the largest over the states, each over 1 or its own size",
    "path": "the same, the largest along the path",
    "audit": "largest error of the energy account over the initial energy",
    "event": "error of the time of the end, or of the events of dry friction",
    "stated": "the driver's own estimate of the error of the last state",
}
"""Description of each metric."""


def dataset(cells: Mapping[str, Cell]) -> xarray.Dataset:
    """Numbers of the motion chart, with every raw timing.

    Parameters
    ----------
    cells
        Cells by key, as in `stability.compare.motion.chart.tasks`; missing cells are gaps;
        scenes and drivers without any are left out.

    Returns
    -------
    xarray.Dataset
        Over (scene, driver, rung | repeat); a rung is one of the driver's tolerances, from loose
        to tight.  NaN marks a gap: no such tolerance, no answer, or none in time; `message` and
        `status` say which.
    """
    import xarray

    kinds = [k for k in CHARTED if any(key.startswith(f"motion/{k}/") for key in cells)]
    names = [n for n in NAMES if any(key.endswith(f"/{n}") for key in cells)]
    most = max((len(DRIVERS[n].tolerances) for n in names), default=0)
    pairs = [(kind, name) for kind in kinds for name in names]
    shape = (len(kinds), len(names), most)
    grid = [cells.get(f"motion/{kind}/{name}") or NOT_ASKED for kind, name in pairs]
    rows = [row for cell in grid for row in _rows(cell, most)]
    along = ("scene", "driver", "rung")
    data: dict[str, Any] = {
        key: variable(along, numbers([row.get(key) for row in rows], shape), text)
        for key, text in {"tolerance": "tolerance, step or ε", **LONG}.items()
    }
    times = padded([row.get("seconds") for row in rows], shape)
    first = numbers([c.value and c.value["first"] for c in grid], shape[:2])
    data |= {
        "seconds": variable((*along, "repeat"), times, "time of each repeated run", "s"),
        "first": variable(
            along[:2],
            first,
            "time of the first run in its process: graphs built, code compiled",
            "s",
        ),
        "outcome": (along, words([row.get("outcome", "") for row in rows], shape, 14)),
        "message": (along, words([row.get("message", "") for row in rows], shape, 200)),
        "status": (along[:2], words([c.status for c in grid], shape[:2], 10)),
    }
    truths = [scene(k) for k in kinds]
    coordinates = methods("driver", DRIVERS, names) | {
        "scene": kinds,
        "scene_title": ("scene", [CHARTED[k] for k in kinds]),
        "true_outcome": ("scene", [t.outcome for t in truths]),
        "truth_error": ("scene", [t.error for t in truths]),
    }
    truth = "two independent integrations in many digits (reference_motions.json)"
    title = "ways to a motion: time against error"
    return xarray.Dataset(data, coordinates, attributes(FORMAT, title, truth))


NOT_ASKED = Cell("", "not asked", None, "", 0.0)
"""Cell of a driver that does not take a scene."""


def _rows(cell: Cell, count: int) -> list[dict[str, Any]]:
    """The row of each rung with its tolerance; without a value each has the cell's message."""
    if cell.value is None:
        return [{"message": cell.message}] * count
    pairs = zip(cell.value["rows"], cell.value["tolerance"], strict=True)
    rows = [row | {"tolerance": tolerance} for row, tolerance in pairs]
    return rows + [{}] * (count - len(rows))


def points(chart: xarray.Dataset, which: str, metric: str) -> dict[str, list[tuple[float, float]]]:
    """(seconds, error) of every driver at each tolerance that has a right outcome.

    The least repeat counts: other work on the machine only adds to a time.

    Returns
    -------
    dict
        By driver, from loose to tight; drivers without such a tolerance are left out.
    """
    if metric not in METRICS:
        raise KeyError(metric)
    here = chart.sel(scene=which)
    true = str(here.true_outcome.values)
    by_driver: dict[str, list[tuple[float, float]]] = {}
    for name in here.driver.values.tolist():
        mine = here.sel(driver=name)
        rows = []
        for m in range(mine.sizes["rung"]):
            rung = mine.isel(rung=m)
            error, times = float(rung[metric]), rung.seconds.values
            if np.isfinite(error) and str(rung.outcome.values) == true:
                rows.append((float(np.nanmin(times)), error))
        if rows:
            by_driver[name] = rows
    return by_driver


def rungs(chart: xarray.Dataset, which: str, metric: str) -> dict[str, Place]:
    """Standing of each driver at each of its tolerances, by driver and number of the tolerance."""
    return places(
        {
            f"{name} {number}": point
            for name, rows in points(chart, which, metric).items()
            for number, point in enumerate(rows)
        }
    )


def standing(chart: xarray.Dataset, which: str, metric: str = "path") -> dict[str, Place]:
    """Standing of each driver, at the best of its tolerances.

    Returns
    -------
    dict
        By driver: the standing of its tolerance that is on the front, or nearest to it.
    """
    best: dict[str, Place] = {}
    for key, place in rungs(chart, which, metric).items():
        name = key.split()[0]
        if name not in best or place.factor < best[name].factor:
            best[name] = Place(
                place.time, place.error, place.on_front, place.factor, place.rival.split()[0]
            )
    return best


# --- as text ---


def motion_csv(cells: Mapping[str, Cell]) -> str:
    """CSV of the motions: one line for each scene, driver and tolerance."""
    return csv_of("motion", cells, _lines)


def _lines(names: Sequence[str], cell: Cell) -> list[Line]:
    which, driver = names
    if cell.value is None:
        cell = replace(cell, message=f"{cell.status}: {cell.message}")
    count = 1 if cell.value is None else len(cell.value["rows"])
    return [
        {
            "scene": which,
            "driver": driver,
            "tolerance": row.get("tolerance"),
            "outcome": row.get("outcome"),
            **{f"{metric}_error": row.get(metric) for metric in LONG},
            "least_s": least(row.get("seconds")),
            "timings_s": timings(row.get("seconds")) if cell.value else None,
            "first_call_s": cell.value and cell.value["first"],
            "message": row["message"],
        }
        for row in _rows(cell, count)
    ]
