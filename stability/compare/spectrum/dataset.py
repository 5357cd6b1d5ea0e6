"""Cells of the spectrum chart as a labelled dataset, and the standing of each route in it."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ...base.provenance import machine, today
from ...jobs.measured_cells import Cell
from ..pareto import Place, places
from .hardness import EDGES, classes
from .measure import CHARTED, ROUTES

if TYPE_CHECKING:
    import xarray


FORMAT = "stability chart spectrum 1"
"""Attribute `format` of a file of this chart."""
QUANTITIES = ("eigenvalues", "abscissa", "verdict", "boundary")
"""Quantities of the chart."""


def padded(rows: Sequence[Sequence[float | None] | None], shape: tuple[int, ...]) -> Any:
    """Rows of different lengths as one array of doubles, with NaN for missing numbers.

    Parameters
    ----------
    rows
        Rows of numbers, or None for a missing row.
    shape
        Leading shape that the rows fill.

    Returns
    -------
    ndarray
        `shape + (longest,)`.

    Examples
    --------
    >>> padded([[1.0, 2.0], None, [3.0]], (3,)).tolist()
    [[1.0, 2.0], [nan, nan], [3.0, nan]]
    """
    longest = max((len(r) for r in rows if r), default=1)
    out = np.full((len(rows), longest), np.nan)
    for index, row in enumerate(rows):
        if row:
            out[index, : len(row)] = [np.nan if v is None else v for v in row]
    return out.reshape(*shape, longest)


def dataset(cells: Mapping[str, Cell]) -> xarray.Dataset:
    """Numbers of the spectrum chart, with every raw timing.

    Parameters
    ----------
    cells
        Cells by key, as in `stability.compare.spectrum.measure.tasks`: of some of the hardness
        classes, with or without boundaries, by the same routes.

    Returns
    -------
    xarray.Dataset
        Over (route, hardness, point | call) and, if asked, (route, boundary).  NaN marks
        missing numbers: a route without that answer, fewer points or calls than another's, or a
        cell whose `status` is not done.
    """
    import xarray

    names = [n for n in CHARTED if any(key.endswith(f"/{n}") for key in cells)]
    kinds = [c for c in classes() if any(key.startswith(f"spectrum/{c}/") for key in cells)]
    grid = [cells[f"spectrum/{c}/{n}"] for n in names for c in kinds]
    edges = [cell for n in names if (cell := cells.get(f"boundary/{n}")) is not None]
    shape = (len(names), len(kinds))

    def rows(key: str, from_: Sequence[Cell]) -> list[Any]:
        return [None if c.value is None else c.value[key] for c in from_]

    def number(key: str) -> Any:
        return np.array([np.nan if v is None else v for v in rows(key, grid)], float).reshape(shape)

    two, long = (
        ("route", "hardness"),
        {
            "eigenvalues": "error of the eigenvalues over the largest modulus, best matching",
            "abscissa": "error of the abscissa over the abscissa, over the largest modulus where 0",
            "one": "time of a call with one point",
            "many": "time a point of a call with many points",
        },
    )
    data: dict[str, Any] = {}
    for key, unit, last in (
        ("eigenvalues", "1", "point"),
        ("abscissa", "1", "point"),
        ("one", "s", "call_one"),
        ("many", "s", "call_many"),
    ):
        values = padded(rows(key, grid), shape)
        data[key] = (
            (*two, f"{last}_{key}" if last == "point" else last),
            values,
            {"units": unit, "long_name": long[key]},
        )
    for key, text in (
        ("wrong", "wrong verdicts"),
        ("undecided", "verdicts said to be undecided"),
        ("count", "points asked"),
    ):
        data[key] = (two, number(key), {"long_name": text, "units": "1"})
    data["first"] = (two, number("first"), {"long_name": "time of the first call", "units": "s"})
    data["status"] = (two, np.array([c.status for c in grid], dtype="U10").reshape(shape))
    data["message"] = (two, np.array([c.message for c in grid], dtype="U200").reshape(shape))
    coordinates: dict[str, Any] = {
        "route": names,
        "hardness": kinds,
        "title": ("route", [ROUTES[n].title for n in names]),
        "own": ("route", [ROUTES[n].own for n in names]),
        "default": ("route", [ROUTES[n].default for n in names]),
        "class_title": ("hardness", [classes()[c] for c in kinds]),
    }
    attributes = {
        "format": FORMAT,
        "title": "routes to a spectrum: time against error",
        "machine": json.dumps(machine()),
        "created": today(),
        "truth": "characteristic polynomial of the graph in balls of 1024 bits and more",
    }
    if edges:
        data |= _boundaries(edges)
        coordinates["boundary"] = [" ".join(str(part) for part in e[:4]) for e in EDGES]
    return xarray.Dataset(data, coordinates, attributes)


def _boundaries(edges: Sequence[Cell]) -> dict[str, Any]:
    """Variables over (route, boundary)."""
    data: dict[str, Any] = {}
    for key, unit, text in (
        ("error", "1", "relative error of a boundary found"),
        ("seconds", "s", "time to find it"),
        ("width", "1", "stated half-width, relative"),
    ):
        values = padded([c.value and c.value[key] for c in edges], (len(edges),))
        values = np.pad(values, ((0, 0), (0, len(EDGES) - values.shape[1])), constant_values=np.nan)
        data[f"boundary_{key}"] = (
            ("route", "boundary"),
            values,
            {"units": unit, "long_name": text},
        )
    asked = [
        [r is not None for r in c.value["seconds"]] if c.value else [True] * len(EDGES)
        for c in edges
    ]
    data["boundary_asked"] = (("route", "boundary"), np.array(asked))
    return data


def seconds(chart: xarray.Dataset, route: str, hardness: str) -> tuple[float, float]:
    """Least times per point [s]: of calls with many points, if any, and with one point.

    Other work on the machine only adds to a time.

    Parameters
    ----------
    chart
        From `dataset`.
    route, hardness
        Names of the route and of the hardness class.

    Returns
    -------
    best, one
        Equal without calls with many points; NaN where the cell is not done.
    """
    here = chart.sel(route=route, hardness=hardness)
    one, many = (_least(here[key].values) for key in ("one", "many"))
    return (many if np.isfinite(many) else one), one


def _least(values: Any) -> float:
    known = values[np.isfinite(values)]
    return float(known.min()) if known.size else float("nan")


def _median(values: Any) -> float:
    known = values[np.isfinite(values)]
    return float(np.median(known)) if known.size else float("nan")


def _worst(values: Any) -> float:
    known = values[np.isfinite(values)]
    return float(known.max()) if known.size else float("nan")


def standing(chart: xarray.Dataset, quantity: str, hardness: str = "") -> dict[str, Place]:
    """Standing of every route in a panel; routes with a wrong verdict have none.

    Parameters
    ----------
    chart
        From `dataset`.
    quantity
        eigenvalues, abscissa, verdict (error: share of points undecided) or boundary.
    hardness
        Hardness class; not used for boundary.

    Returns
    -------
    dict
    """
    panel: dict[str, tuple[float, float]] = {}
    for route in chart.route.values.tolist():
        if quantity == "boundary":
            here = chart.sel(route=route)
            asked = here.boundary_asked.values
            error = here.boundary_error.values[asked]
            if not error.size or not np.isfinite(error).all():
                continue
            panel[route] = (_median(here.boundary_seconds.values[asked]), float(error.max()))
            continue
        cell = chart.sel(route=route, hardness=hardness)
        if str(cell.status.values) != "done" or float(cell.wrong) > 0:
            continue
        time = seconds(chart, route, hardness)[0]
        if quantity == "verdict":
            panel[route] = (time, float(cell.undecided / cell["count"]))
        elif np.isfinite(error := _worst(cell[quantity].values)):
            panel[route] = (time, error)
    return places(panel)
