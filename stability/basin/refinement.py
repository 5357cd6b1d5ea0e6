"""Borders of a finished map, refined wave by wave, and written next to it.

Each wave of launches is kept like a map.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from concurrent.futures import Executor
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..base.axis import Axis
from ..base.errors import ParameterError
from ..base.types import Floats, Progress
from ..jobs.filling import fill
from ..jobs.pipeline import shared
from ..motion.result import CODES, Outcome
from ..storage.chunks import Arrays, Block, Layout, Memory, Store, Variable
from ..storage.targets import refusing
from ..storage.zarr_store import ZarrStore
from .borders import Borders, between, borders
from .labels import Ints
from .launch_labels import FAMILIES, LaunchLabels, coded
from .statistics.box_counting import HALVINGS, SPAN, box_dimension, sensitive

if TYPE_CHECKING:
    import xarray

FOLDER = "border_labels"
"""Folder in a store of a map, with a store for each wave of launches along its borders."""
LABEL = Variable("label", "int64", -1, {"long_name": "outcome and family of a launch"})
"""The array of such a store; no label is below 0."""
LEAST_CHUNK, MOST_CHUNK = 256, 2048
"""Fewest and most launches of a chunk."""
EACH = 4
"""Launches for each cell that is cut: its middle, and half of the four on its edges and more."""
BLOCK = "border_block"
"""Dimension of the blocks along a border."""
LEAST = HALVINGS + 1
"""Fewest halvings that tell a sensitive block: those of a local exponent, and one more."""
UNFINISHED = {o.code for o in (Outcome.MOVING, Outcome.UNDETERMINED, Outcome.UNRESOLVED)}
"""Outcomes of launches whose end is not known."""


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
    """
    there = kept.dataset()
    coarse = coded(there.outcome.values, there.family.values)
    total = kept.layout.total
    waves = Waves(
        labels,
        kept.folder,
        pool,
        workers,
        progress,
        total,
        total + expected_launches(mixed_cells(coarse), levels),
    )
    refined = borders(
        waves,
        *((a.name, a.low, a.high, a.count, *(["log"] * a.log)) for a in axes),
        levels=levels,
        known=coarse,
    )
    kept.attach(border_arrays(refined, axes))
    waves.finish()


@dataclass(eq=False)
class Waves:
    """A function of launches that gives their labels; a call is a wave, and is kept."""

    labels: LaunchLabels
    """Labels of launches."""
    folder: Path | None
    """Folder of the map; None for memory."""
    pool: Executor | None
    """Executor that runs the launches; None for threads."""
    workers: int | None
    """Number of workers."""
    progress: Progress | None
    """Called with (launches done, launches in all), those of the map among both."""
    done: int
    """Launches that are done."""
    expected: int
    """Launches in all, as far as is known."""
    count: int = field(default=0, init=False)
    """Waves so far."""

    def __call__(self, points: Floats) -> Ints:
        """The labels of a wave, from its store as far as they are there."""
        count = len(points)
        layout = Layout(("launch",), (count,), (min(MOST_CHUNK, max(LEAST_CHUNK, -(-count // 8))),))
        store = self._store(points, layout)
        self.count += 1
        fill(
            store,
            partial(_labelled, shared((self.labels, points), self.pool), layout),
            blank=_unresolved,
            executor=self.pool,
            workers=self.workers,
            progress=self._told,
        )
        self.done += count
        labels: Ints = store.dataset()[LABEL.name].values
        return labels

    def finish(self) -> None:
        """Say that nothing is left."""
        if self.progress is not None:
            self.progress(self.done, self.done)

    def _told(self, done: int, total: int) -> None:
        if self.progress is not None:
            self.progress(self.done + done, max(self.expected, self.done + total))

    def _store(self, points: Floats, layout: Layout) -> Store:
        if self.folder is None:
            return Memory(layout, (LABEL,))
        folder = self.folder / FOLDER
        with refusing(folder):
            folder.mkdir(exist_ok=True)
        asked = hashlib.sha256(np.ascontiguousarray(points).tobytes()).hexdigest()
        name = folder / f"{self.count:04d}.zarr"
        return ZarrStore(name, layout, (LABEL,), question={"launches": asked}, overwrite=True)


def _labelled(
    content: Callable[[], tuple[LaunchLabels, Floats]], layout: Layout, block: Block, part: slice
) -> Arrays:
    """The labels of a part of a chunk of a wave."""
    labels, points = content()
    return {LABEL.name: labels.of(points[layout.slices(block)][part])}


def _unresolved(count: int) -> Arrays:
    """Labels of launches that ended their worker."""
    return {LABEL.name: np.full(count, coded(CODES[Outcome.UNRESOLVED], 0))}


def expected_launches(mixed: float, levels: int) -> int:
    """Launches of a refinement, about: those of a smooth border.

    Parameters
    ----------
    mixed
        Cells of the map whose corners differ.
    levels
        Halvings of its steps.

    Examples
    --------
    >>> expected_launches(12, 6)  # the circle in the example of `borders` takes 3232
    3024
    """
    return int(EACH * mixed * (2**levels - 1) + 0.5)


def mixed_cells(labels: Ints) -> int:
    """Cells of a map whose corners differ.

    Parameters
    ----------
    labels
        Labels, shape (y, x).

    Examples
    --------
    >>> mixed_cells(np.array([[0, 0, 1], [0, 0, 1]]))
    1
    """
    corners = np.stack([labels[:-1, :-1], labels[:-1, 1:], labels[1:, :-1], labels[1:, 1:]])
    return int((corners != corners[0]).any(axis=0).sum())


def border_arrays(borders: Borders, axes: tuple[Axis, Axis]) -> xarray.Dataset:
    """The borders between the outcomes of a map.

    Parameters
    ----------
    borders
        Borders of its labels.
    axes
        x and y.

    Returns
    -------
    xarray.Dataset
        Along `border_point`: `border_X` for each axis X, the points of each line in turn
        (`border_curve`), and the flag values of the outcomes and families on both sides; along
        `border_block`, which parts are sensitive.  Attributes hold the uncertainty exponent.
    """
    import xarray

    parts, meaning = _blocks(borders, axes)
    return xarray.Dataset(
        _variables(borders, axes) | parts,
        attrs={
            "border_width": [float(w) for w in borders.widths[-1]],
            "border_levels": borders.lattice_levels,
            "border_launches": borders.asked,
            "border_note": borders.note,
            "border_cells": [int(n) for n in borders.counts],
            **_exponent_attributes(borders),
            **meaning,
        },
    )


def _variables(borders: Borders, axes: tuple[Axis, Axis]) -> dict[str, Any]:
    lines = [_closed(line) for line in borders.lines]
    points, lengths = np.concatenate([np.zeros((0, 2)), *lines]), [len(p) for p in lines]
    pairs = np.array([line.labels for line in borders.lines], dtype=np.int64).reshape(-1, 2)
    sides = np.repeat(pairs, lengths, axis=0)
    made: dict[str, Any] = {
        f"border_{a.name}": (
            "border_point",
            points[:, i],
            {"long_name": f"{a.name} of the border, off the true one by less than border_width"},
        )
        for i, a in enumerate(axes)
    }
    made["border_curve"] = (
        "border_point",
        np.repeat(np.arange(len(lines)), lengths),
        {"long_name": "number of the line"},
    )
    for side, column in (("low", 0), ("high", 1)):
        for name, part in (
            ("outcome", sides[:, column] // FAMILIES),
            ("family", sides[:, column] % FAMILIES),
        ):
            made[f"border_{name}_{side}"] = (
                "border_point",
                part.astype(np.int8),
                {"long_name": f"{name} on the {side} side, a flag value of {name}"},
            )
    return made


def _closed(line: Any) -> Floats:
    points: Floats = np.vstack([line.points, line.points[:1]]) if line.closed else line.points
    return points


def _blocks(borders: Borders, axes: tuple[Axis, Axis]) -> tuple[dict[str, Any], dict[str, Any]]:
    """The blocks of a map that hold a border, and which are sensitive."""
    span = min(SPAN, borders.levels)
    if span < LEAST:
        few = (
            f"not sought: sensitive parts need {LEAST} halvings, and {borders.levels} are complete"
        )
        return {}, {"border_sensitive_note": few}
    open_ = [c for c in np.unique(borders.labels) if c // FAMILIES in UNFINISHED]
    local = sensitive(borders, span=span, unfinished=open_)
    arrays: dict[str, Any] = {}
    for axis, index in zip(axes, local.blocks.T, strict=True):
        ends = [between(axis, (index + i) << span, borders.levels) for i in (0, 1)]
        arrays[f"border_block_{axis.name}"] = (
            (BLOCK, "edge"),
            np.stack(ends, axis=-1),
            {"long_name": f"{axis.name} at the low and high edge of the block"},
        )
    arrays["border_block_exponent"] = (
        BLOCK,
        local.block_exponent,
        {"long_name": "local uncertainty exponent between the last widths", "units": "1"},
    )
    arrays["border_sensitive"] = (
        BLOCK,
        np.where(local.strips, 2, local.block_exponent < local.bound).astype(np.int8),
        {
            "long_name": "whether the block is sensitive",
            "flag_values": [0, 1, 2],
            "flag_meanings": "smooth sensitive open",
        },
    )
    return arrays, {"border_sensitive_note": local.note}


def _exponent_attributes(borders: Borders) -> dict[str, Any]:
    """The uncertainty exponent of a border and its confidence interval, as attributes."""
    try:
        dimension = box_dimension(borders)
    except ParameterError as error:
        return {"border_exponent_note": f"none: {error}"}
    low, high = dimension.interval
    first, last = dimension.levels
    return {
        "border_exponent": float(dimension.exponent),
        "border_exponent_interval": [float(2 - high), float(2 - low)],
        "border_exponent_level": dimension.level,
        "border_exponent_note": "2 - D, with D the slope of the number of unlike neighbours (two "
        "launches side by side with different ends) over their distance, halvings "
        f"{first} to {last}; all borders together{_moving(borders)}",
    }


def _moving(borders: Borders) -> str:
    """The share of borders next to launches whose end is not known, for the note."""
    open_ = np.isin(borders.pair_labels // FAMILIES, list(UNFINISHED)).any(axis=1)
    if not open_.any():
        return ""
    return (
        f"; {100 * open_.mean():.0f} % of the finest pairs hold a launch whose end is not known, "
        "and a longer horizon may change the exponent"
    )
