"""Cells of the motion chart as a labelled dataset, and the standing of each driver in it."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from ...base.provenance import machine, today
from ...jobs.measured_cells import Cell
from ..pareto import Place, places
from .drivers import DRIVERS
from .measure import CHARTED, METRICS, NAMES
from .reference_motions import scene

if TYPE_CHECKING:
    import xarray


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
        Cells by key, as in `stability.compare.motion.measure.tasks`; missing cells are gaps;
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
    rungs = max((len(DRIVERS[n].tolerances) for n in names), default=0)
    repeats = max(
        (
            len(r.get("seconds", ()))
            for key, c in cells.items()
            if key.startswith("motion/") and c.value
            for r in c.value["rows"]
        ),
        default=1,
    )
    shape = (len(kinds), len(names), rungs)
    numbers = {key: np.full(shape, np.nan) for key in ("tolerance", *LONG)}
    seconds = np.full((*shape, repeats), np.nan)
    first = np.full(shape[:2], np.nan)
    outcome, message = np.full(shape, "", "U14"), np.full(shape, "", "U200")
    status = np.full(shape[:2], "not asked", "U10")
    for i, kind in enumerate(kinds):
        for j, name in enumerate(names):
            cell = cells.get(f"motion/{kind}/{name}")
            if cell is None:
                continue
            status[i, j] = cell.status
            if cell.value is None:
                message[i, j] = cell.message
                continue
            first[i, j] = np.nan if cell.value["first"] is None else cell.value["first"]
            for m, row in enumerate(cell.value["rows"]):
                place = (i, j, m)
                numbers["tolerance"][place] = cell.value["tolerance"][m]
                message[place] = row["message"]
                if row["message"]:
                    continue
                outcome[place] = row["outcome"]
                seconds[place][: len(row["seconds"])] = row["seconds"]
                for key in LONG:
                    numbers[key][place] = np.nan if row[key] is None else row[key]
    along = ("scene", "driver", "rung")
    data: dict[str, Any] = {
        key: (along, values, {"long_name": LONG.get(key, "tolerance, step or ε"), "units": "1"})
        for key, values in numbers.items()
    }
    data["seconds"] = (
        (*along, "repeat"),
        seconds,
        {"long_name": "time of each repeated run", "units": "s"},
    )
    data["first"] = (
        along[:2],
        first,
        {
            "long_name": "time of the first run in its process: graphs built, code compiled",
            "units": "s",
        },
    )
    data |= {
        "outcome": (along, outcome),
        "message": (along, message),
        "status": (along[:2], status),
    }
    truths = [scene(k) for k in kinds]
    coordinates = {
        "scene": kinds,
        "driver": names,
        "scene_title": ("scene", [CHARTED[k] for k in kinds]),
        "title": ("driver", [DRIVERS[n].title for n in names]),
        "own": ("driver", [DRIVERS[n].own for n in names]),
        "default": ("driver", [DRIVERS[n].default for n in names]),
        "true_outcome": ("scene", [t.outcome for t in truths]),
        "truth_error": ("scene", [t.error for t in truths]),
    }
    attributes = {
        "format": FORMAT,
        "title": "ways to a motion: time against error",
        "machine": json.dumps(machine()),
        "created": today(),
        "truth": "two independent integrations in many digits (reference_motions.json)",
    }
    return xarray.Dataset(data, coordinates, attributes)


def points(chart: xarray.Dataset, which: str, metric: str) -> dict[str, list[tuple[float, float]]]:
    """(seconds, error) of every driver at each tolerance that has a right outcome.

    The least repeat counts: other work on the machine only adds to a time.

    Parameters
    ----------
    chart
        From `dataset`.
    which
        Name of the scene.
    metric
        One of `stability.compare.motion.measure.METRICS`.

    Returns
    -------
    dict
        By driver, from loose to tight; drivers without such a tolerance are left out.
    """
    if metric not in METRICS:
        raise KeyError(metric)
    here = chart.sel(scene=which)
    true = str(here.true_outcome.values)
    found: dict[str, list[tuple[float, float]]] = {}
    for name in here.driver.values.tolist():
        mine = here.sel(driver=name)
        rows = []
        for m in range(mine.sizes["rung"]):
            rung = mine.isel(rung=m)
            error, times = float(rung[metric]), rung.seconds.values
            if np.isfinite(error) and str(rung.outcome.values) == true:
                rows.append((float(np.nanmin(times)), error))
        if rows:
            found[name] = rows
    return found


def standing(chart: xarray.Dataset, which: str, metric: str = "path") -> dict[str, Place]:
    """Standing of each driver, at the best of its tolerances.

    Parameters
    ----------
    chart
        From `dataset`.
    which
        Name of the scene.
    metric
        Metric whose error counts.

    Returns
    -------
    dict
        By driver: the standing of its tolerance that is on the front, or nearest to it.
    """
    flat = {
        f"{name} {m}": point
        for name, rows in points(chart, which, metric).items()
        for m, point in enumerate(rows)
    }
    best: dict[str, Place] = {}
    for key, place in places(flat).items():
        name = key.split()[0]
        if name not in best or place.factor < best[name].factor:
            best[name] = Place(
                place.time, place.error, place.on_front, place.factor, place.rival.split()[0]
            )
    return best
