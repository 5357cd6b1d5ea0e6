"""Stores filled by workers: each computes and writes whole chunks, and may be lost."""

from __future__ import annotations

from concurrent.futures import Executor
from dataclasses import dataclass
from typing import Protocol

from ..base.types import Progress
from .chunks import Arrays, Block, Store
from .pipeline import Pool, threads

TRIES = 2
"""Times that a chunk may lose its worker before it is divided."""


class Work(Protocol):
    """Work of a chunk; picklable where the executor is of processes."""

    def __call__(self, block: Block, part: slice, /) -> Arrays:
        """Arrays of a part of the chunk's cells, in row-major order; normally of all."""


class Blank(Protocol):
    """Arrays for cells without a result."""

    def __call__(self, count: int, /) -> Arrays:
        """Arrays of this many cells."""


@dataclass(frozen=True)
class Filled:
    """What a call of `fill` did."""

    stored: int
    """Cells that were in the store before."""
    computed: int
    """Cells that were added."""
    lost: tuple[int, ...]
    """Numbers of the cells that ended their worker, row-major in the whole array."""
    ended: int
    """Workers that ended."""
    seconds: tuple[float, ...]
    """Time of each chunk computed here, from the start of its work to its last file [s]."""


def fill(
    store: Store,
    work: Work,
    *,
    blank: Blank,
    executor: Executor | None = None,
    workers: int | None = None,
    own: Pool = threads,
    progress: Progress | None = None,
    tries: int = TRIES,
) -> Filled:
    """Compute and store the chunks that are not there."""
    raise NotImplementedError
