"""Refine the borders of a finished map, and write them next to it."""

from __future__ import annotations

from concurrent.futures import Executor

from ...base.axis import Axis
from ...base.types import Progress
from ...jobs.chunks import Store
from ..borders import borders
from ..launch_labels import LaunchLabels, coded
from .arrays import border_arrays
from .waves import Waves, expected_launches, mixed_cells


def refine(
    kept: Store,
    labels: LaunchLabels,
    axes: tuple[Axis, Axis],
    levels: int,
    pool: Executor | None,
    workers: int | None,
    progress: Progress | None,
) -> None:
    """Add the borders between the outcomes of a map to its store.

    Launches along the borders are kept wave by wave.  The borders are added when all are there.

    Parameters
    ----------
    kept
        The full store of a map.
    labels
        Labels of launches over x and y.
    axes
        x and y.
    levels
        Halvings of the steps of the map.
    pool, workers, progress
        As for `stability.jobs.filling.fill`.
    """
    there = kept.dataset()
    known = coded(there.outcome.values, there.family.values)
    total = kept.layout.total
    waves = Waves(
        labels,
        kept.folder,
        pool,
        workers,
        progress,
        total,
        total + expected_launches(mixed_cells(known), levels),
    )
    found = borders(
        waves,
        *((a.name, a.low, a.high, a.count, *(["log"] * a.log)) for a in axes),
        levels=levels,
        known=known,
    )
    kept.attach(border_arrays(found, axes))
    waves.finish()
