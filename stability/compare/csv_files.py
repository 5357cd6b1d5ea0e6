"""Cells of the charts as CSV, with every raw timing."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from ..jobs.measured_cells import Cell
from ..storage.text import csv_text
from .spectrum.hardness import EDGES


def _least(values: Sequence[float] | None) -> float | None:
    return min(values) if values else None


def _timings(values: Sequence[float] | None) -> str:
    return " ".join(f"{v:.3e}" for v in values or ())


def spectrum_csv(cells: Mapping[str, Cell]) -> str:
    """CSV of the spectra: one line for each route and hardness class.

    Parameters
    ----------
    cells
        Cells of any chart by key.

    Returns
    -------
    str
    """
    columns = (
        "hardness",
        "route",
        "status",
        "points",
        "wrong",
        "undecided",
        "worst_eigenvalue_error",
        "worst_abscissa_error",
        "first_call_s",
        "one_point_s",
        "a_point_of_many_s",
        "one_point_timings_s",
        "many_timings_s",
        "message",
    )
    rows: list[Sequence[Any]] = []
    for key, cell in cells.items():
        if not key.startswith("spectrum/"):
            continue
        _, hardness, route = key.split("/")
        v = cell.value
        if v is None:
            rows.append((hardness, route, cell.status, *[None] * 10, cell.message))
            continue
        worst = [None if v[q] is None else max(v[q]) for q in ("eigenvalues", "abscissa")]
        rows.append(
            (
                hardness,
                route,
                cell.status,
                v["count"],
                v["wrong"],
                v["undecided"],
                *worst,
                v["first"],
                _least(v["one"]),
                _least(v["many"]),
                _timings(v["one"]),
                _timings(v["many"]),
                "",
            )
        )
    return csv_text(columns, rows)


def boundary_csv(cells: Mapping[str, Cell]) -> str:
    """CSV of the boundaries: one line for each route and each boundary that it is asked.

    Parameters
    ----------
    cells
        Cells of any chart by key.

    Returns
    -------
    str
    """
    columns = (
        "route",
        "family",
        "contact",
        "k",
        "mu",
        "relative_error",
        "stated_half_width",
        "seconds",
        "status",
    )
    rows: list[Sequence[Any]] = []
    for key, cell in cells.items():
        if not key.startswith("boundary/"):
            continue
        route = key.split("/")[1]
        for i, edge in enumerate(EDGES):
            if cell.value is None:
                rows.append((route, *edge[:4], *[None] * 3, cell.status))
            elif (seconds := cell.value["seconds"][i]) is not None:
                error = cell.value["error"][i]
                rows.append(
                    (
                        route,
                        *edge[:4],
                        error,
                        cell.value["width"][i],
                        seconds,
                        "not found" if error is None else "found",
                    )
                )
    return csv_text(columns, rows)


def motion_csv(cells: Mapping[str, Cell]) -> str:
    """CSV of the motions: one line for each scene, driver and tolerance.

    Parameters
    ----------
    cells
        Cells of any chart by key.

    Returns
    -------
    str
    """
    metrics = ("final", "path", "audit", "event", "stated")
    columns = (
        "scene",
        "driver",
        "tolerance",
        "outcome",
        *(f"{m}_error" for m in metrics[:4]),
        "stated_error",
        "least_s",
        "timings_s",
        "first_call_s",
        "message",
    )
    rows: list[Sequence[Any]] = []
    for key, cell in cells.items():
        if not key.startswith("motion/"):
            continue
        _, which, driver = key.split("/")
        if cell.value is None:
            rows.append((which, driver, *[None] * 10, f"{cell.status}: {cell.message}"))
            continue
        for tolerance, row in zip(cell.value["tolerance"], cell.value["rows"], strict=True):
            if row["message"]:
                rows.append(
                    (
                        which,
                        driver,
                        tolerance,
                        *[None] * 8,
                        cell.value["first"],
                        row["message"],
                    )
                )
                continue
            rows.append(
                (
                    which,
                    driver,
                    tolerance,
                    row["outcome"],
                    *(row[m] for m in metrics),
                    _least(row["seconds"]),
                    _timings(row["seconds"]),
                    cell.value["first"],
                    "",
                )
            )
    return csv_text(columns, rows)
