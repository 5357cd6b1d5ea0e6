"""Labels of the launches along borders, wave by wave, each wave kept like a map."""

from __future__ import annotations

import hashlib
from concurrent.futures import Executor
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ...base.types import Floats, Progress
from ...jobs.chunks import Arrays, Block, Layout, Memory, Store, Variable
from ...jobs.filling import fill
from ...jobs.shared import shared
from ...jobs.zarr_store import ZarrStore
from ...motion.result import CODES, Outcome
from ...storage.targets import refusing
from ..labels import Ints
from ..launch_labels import LaunchLabels, coded

FOLDER = "border_labels"
"""Folder in a store of a map, with a store for each wave of launches along its borders."""
LABEL = Variable("label", "int64", -1, {"long_name": "outcome and family of a launch"})
"""The array of such a store; no label is below 0."""
LEAST, PIECE = 256, 2048
"""Fewest and most launches of a chunk."""
EACH = 4
"""Launches for each cell that is cut: its middle, and half of the four on its edges and more."""


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
        layout = Layout(("launch",), (count,), (min(PIECE, max(LEAST, -(-count // 8))),))
        store = self._store(points, layout)
        self.count += 1
        fill(
            store,
            _Wave(shared((self.labels, points), self.pool), layout),
            blank=_unresolved,
            executor=self.pool,
            workers=self.workers,
            progress=self._told,
        )
        self.done += count
        found: Ints = store.dataset()[LABEL.name].values
        return found

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


@dataclass(frozen=True)
class _Wave:
    """Work of a chunk of a wave."""

    content: Any
    """Function that gives this worker's labels and launches."""
    layout: Layout
    """The grid of chunks."""

    def __call__(self, block: Block, part: slice) -> Arrays:
        labels, points = self.content()
        return {LABEL.name: labels.of(points[self.layout.slices(block)][part])}


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


def mixed_cells(known: Ints) -> int:
    """Cells of a map whose corners differ.

    Parameters
    ----------
    known
        Labels, shape (y, x).

    Examples
    --------
    >>> mixed_cells(np.array([[0, 0, 1], [0, 0, 1]]))
    1
    """
    corners = np.stack([known[:-1, :-1], known[:-1, 1:], known[1:, :-1], known[1:, 1:]])
    return int((corners != corners[0]).any(axis=0).sum())
