"""Charts of scenes: every model of a motion, and which one answers."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from ..bodies.contact_laws import LinearViscous, Rough, Viscous
from ..bodies.disk import Disk
from ..jobs.measured_cells import Cell, Task
from ..scene.chart import chart
from ..scene.scene import Scene

if TYPE_CHECKING:
    import xarray

SCENES: dict[str, tuple[str, Scene]] = {
    "rolling": (
        "A disk rolls almost steadily, for a long time.",
        Scene(Disk(), Viscous(0.3), {"theta": 1.57, "omega3": 2.2}, 1000.0, 1e-5),
    ),
    "sticky": (
        "The plane is a thousand times stickier: slip follows the motion.",
        Scene(
            Disk(), Viscous(300.0), {"theta": 1.3, "omega3": 2.0}, 10.0, 1e-6, uncertain={"mu": 0.2}
        ),
    ),
    "falling": (
        "A disk falls far from every steady motion.",
        Scene(Disk(), Viscous(3.0), {"theta": 1.1, "omega3": 1.2}, 10.0, 1e-6),
    ),
}
"""Scenes of the report by name, each with a sentence."""
COLUMNS = ("scene", "model", "kind", "states", "time [s]", "true error", "estimate", "chosen")
"""Columns of the table."""
FACTOR = 1.5
"""Time over that of the cheapest fine model that counts as the same: repeats differ by as much."""


def tasks() -> list[list[Task]]:
    """One cell for each scene, each in its own process."""
    return [[Task(f"scenes/{name}", measure, (name,), 120.0)] for name in SCENES]


def measure(name: str) -> dict[str, Any]:
    """One cell: the chart of a scene, with two other laws as models of its law.

    Returns
    -------
    dict
        The dataset as plain numbers and texts.
    """
    scene = SCENES[name][1]
    mu = float(scene.contact.given["mu"])
    result = chart(scene, {"linear-viscous": LinearViscous(mu=mu), "rough": Rough()})
    return {str(key): value for key, value in result.to_dict().items()}


def datasets(cells: Mapping[str, Cell]) -> dict[str, xarray.Dataset]:
    """The charts of the cells that are done, by scene."""
    import xarray

    wanted = {name: cells.get(f"scenes/{name}") for name in SCENES}
    return {
        name: xarray.Dataset.from_dict(cell.value)
        for name, cell in wanted.items()
        if cell is not None and cell.value is not None
    }


def choice(dataset: xarray.Dataset) -> tuple[str, str, float]:
    """Which model answers, which is the cheapest that truly could, and the ratio of their times."""
    models, costs = dataset.model.values, dataset.cost.values
    ours = dataset.kind.values != "other law"
    fine = ours & (dataset.true_error.values <= float(dataset.tolerance))
    chosen = int(np.flatnonzero(dataset.chosen.values)[0])
    best = int(np.argmin(np.where(fine, costs, math.inf))) if fine.any() else chosen
    return str(models[chosen]), str(models[best]), float(costs[chosen] / costs[best])


def rows(charts: Mapping[str, xarray.Dataset]) -> Iterator[list[Any]]:
    """Rows of the table with `COLUMNS`."""
    for name, data in charts.items():
        for i in range(data.sizes["model"]):
            model = data.isel(model=i)
            numbers = (float(model[key]) for key in ("cost", "true_error", "estimate"))
            yield [
                name,
                str(model.model.values),
                str(model.kind.values),
                int(model.dimension),
                *(f"{v:.3e}" if math.isfinite(v) else "" for v in numbers),
                "yes" if bool(model.chosen) else "no",
            ]


def sentence(charts: Mapping[str, xarray.Dataset]) -> str:
    """How often the model that answers is the cheapest one that could."""
    picks = [choice(data) for data in charts.values()]
    good = sum(ratio <= FACTOR for _, _, ratio in picks)
    words = "; ".join(
        f"{name}: {chosen}" + (f" ({ratio:.2g} times the time of {best})" if ratio > FACTOR else "")
        for name, (chosen, best, ratio) in zip(charts, picks, strict=True)
    )
    return (
        f"In {good} of {len(picks)} scenes the model that answers is the cheapest whose true error "
        f"is within the tolerance, or takes at most {FACTOR:g} times as long ({words})."
    )
