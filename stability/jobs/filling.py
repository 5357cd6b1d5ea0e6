"""Stores filled by workers: each computes and writes whole chunks, and may be lost."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator
from concurrent.futures import Executor
from contextlib import closing, contextmanager, nullcontext
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np

from ..base.checks import whole_number
from ..base.errors import StabilityError
from ..base.types import Progress
from ..storage.chunks import Arrays, Block, Store, Writer
from ..storage.targets import path_text
from .pipeline import ENDED, Counted, Pool, check_run, here, ordered, resumable, threads
from .processes import worker_ended

TRIES = 2
"""Times that a chunk may lose its worker before it is divided."""
MOST_TRIES = 100
AHEAD = 2
"""Chunks in flight for each worker: one that runs, one that waits."""
MOST_ENDED = 1000
"""Workers that may end in a run: more is no accident of single cells."""


Work = Callable[[Block, slice], Arrays]
"""Arrays of a part of a chunk's cells, in row-major order, normally of all; picklable where the
workers are processes."""
Blank = Callable[[int], Arrays]
"""Arrays of this many cells without a result."""


@dataclass(frozen=True)
class Filled:
    """What a call of `fill` did."""

    stored: int
    """Cells that were in the store before."""
    computed: int
    """Cells that were added."""
    lost: tuple[int, ...]
    """Numbers of the cells that ended their workers, row-major in the whole array."""
    ended: int
    """Times that a worker ended."""
    seconds: tuple[float, ...]
    """Time of each chunk computed here: its work and its files [s]."""


def fill(
    store: Store,
    work: Work,
    *,
    blank: Blank,
    executor: Executor | None = None,
    workers: int | None = None,
    start_pool: Pool = threads,
    progress: Progress | None = None,
    tries: int = TRIES,
) -> Filled:
    """Compute and store the chunks that are not there.

    A worker computes a whole chunk and writes it, where the store has a folder.  So a driver that
    is killed loses no more than the chunks that run.  A chunk whose worker ends is tried again
    alone, when the others are done.  After some tries it is divided, down to the cell that ends
    its worker; that cell gets a blank.

    Parameters
    ----------
    store
        Where chunks are kept.
    work
        Work of a chunk; data that all chunks need are best `shared`.
    blank
        Arrays for cells that end their worker.
    executor
        Any executor of the protocol of `concurrent.futures`; it is not shut down.
    workers
        Number of workers; that of the processors when left out.
    start_pool
        Starts the workers where there is no executor.
    progress
        Called with (cells done, cells in all).
    tries
        Times that a chunk may lose its worker before it is divided.

    Returns
    -------
    Filled

    Raises
    ------
    StabilityError
        If the work is refused, an executor breaks, or the disk is full; chunks that are there stay.
    KeyboardInterrupt
        On Ctrl-C, with a sentence on where the finished cells are.

    Source: tests/jobs/test_filling.py.

    Examples
    --------
    >>> from ..storage.chunks import Layout, Memory, Variable
    >>> store = Memory(Layout(("x",), (5,), (2,)), (Variable("outcome", "int8", -1),))
    >>> def work(block, part):
    ...     return {"outcome": np.full(part.stop - part.start, block[0], dtype=np.int8)}
    >>> fill(store, work, blank=lambda n: {"outcome": np.full(n, 9, dtype=np.int8)}).computed
    5
    >>> store.dataset().outcome.values.tolist()
    [0, 0, 1, 1, 2]
    """
    check_run(workers, progress, executor)
    whole_number("tries", tries, most=MOST_TRIES)
    missing = store.missing()
    layout = store.layout
    stored = layout.total - sum(map(layout.count, missing))
    count = Counted(progress, layout.total)
    number = workers or os.cpu_count() or 1
    start = start_pool(number) if executor is None else nullcontext(executor)
    with kept_on_stop(store, count), start as pool:
        count.add(stored)
        filling = _Filling(store, work, blank, pool, number, tries, count)
        filling.every(missing)
        if store.writer is not None:
            store.writer.clean()
    return Filled(
        stored,
        layout.total - stored,
        tuple(sorted(filling.lost)),
        filling.ended,
        tuple(filling.seconds),
    )


@contextmanager
def kept_on_stop(store: Store, count: Counted) -> Iterator[None]:
    """Say on Ctrl-C how many cells are kept, those of workers that have ended meanwhile too."""
    if store.folder is None:
        yield
        return
    with resumable(store.folder, count):
        try:
            yield
        except KeyboardInterrupt:
            left = sum(map(store.layout.count, store.missing()))
            count.done = max(count.done, store.layout.total - left)
            raise


@dataclass(frozen=True)
class _Done:
    """Record of a chunk, small where a worker has written it."""

    seconds: float
    """Time of the chunk [s]."""
    arrays: Arrays | None
    """Its arrays, where the driver writes them."""


def _compute(work: Work, writer: Writer | None, block: Block, part: slice) -> _Done:
    """Cells of a chunk, which a worker with a writer writes too: then all of them."""
    begin = time.perf_counter()
    if writer is not None and writer.done(block):  # of another run
        return _Done(0.0, None)
    arrays = work(block, part)
    if writer is not None:
        writer.add(block, arrays)
    return _Done(time.perf_counter() - begin, arrays if writer is None else None)


@dataclass
class _Filling:
    """A run of `fill`."""

    store: Store
    work: Work
    blank: Blank
    pool: Executor | None
    workers: int
    tries: int
    count: Counted
    lost: list[int] = field(default_factory=list)
    ended: int = 0
    seconds: list[float] = field(default_factory=list)

    def every(self, blocks: list[Block]) -> None:
        """All chunks at once, then one by one those that lost their worker."""
        left = []
        results = self._results(blocks, self._task, self.workers, AHEAD)
        with closing(results):
            for block, done in results:
                if done is None:
                    left.append(block)
                else:
                    self._finish(block, done)
        for block in left:
            self._again(block)

    def _results(self, keys: list[Any], task: Any, workers: int, ahead: int) -> Any:
        """Results as they come, None where a worker ended."""
        return ordered(
            keys,
            task,
            executor=self.pool,
            workers=workers,
            start_pool=here,
            ahead=ahead,
            in_order=False,
            lost=self._lose,
            broken=self._broken(),
        )

    def _task(self, block: Block) -> Callable[[], _Done]:
        return partial(_compute, self.work, self.store.writer, block, self._cells(block))

    def _cells(self, block: Block) -> slice:
        return slice(0, self.store.layout.count(block))

    def _alone(self, task: Any) -> _Done | None:
        """A piece of work while nothing else runs."""
        with closing(self._results([None], lambda _: task, 1, 1)) as results:
            return next(iter(results))[1]  # type: ignore[no-any-return]

    def _lose(self, _: Any, error: Exception) -> None:
        if not worker_ended(error):
            raise error
        self.ended += 1
        if self.ended > MOST_ENDED:
            raise StabilityError(
                f"workers ended {self.ended} times, which is too often to look for the cells that "
                f"cause it{self._where()}."
            )

    def _again(self, block: Block) -> None:
        """A chunk that lost its worker: whole, then in parts."""
        task = self._task(block)
        for _ in range(self.tries - 1):
            done = self._alone(task)
            if done is not None:
                self._finish(block, done)
                return
        arrays = self._divided(block, self._cells(block))
        self._finish(block, _Done(0.0, arrays))

    def _divided(self, block: Block, part: slice) -> Arrays:
        """Arrays of a part of a chunk that, as a whole, ended its workers."""
        cells = part.stop - part.start
        if cells == 1:
            self.lost.append(self.store.layout.number(block, part.start))
            return self.blank(1)
        middle = part.start + cells // 2
        halves = [
            self._half(block, p) for p in (slice(part.start, middle), slice(middle, part.stop))
        ]
        return {name: np.concatenate([h[name] for h in halves]) for name in halves[0]}

    def _half(self, block: Block, part: slice) -> Arrays:
        """A half is tried once, a single cell as often as a chunk."""
        for _ in range(self.tries if part.stop - part.start == 1 else 1):
            done = self._alone(partial(_compute, self.work, None, block, part))
            if done is not None and done.arrays is not None:
                return done.arrays
        return self._divided(block, part)

    def _finish(self, block: Block, done: _Done) -> None:
        if done.arrays is not None:
            self.store.add(block, done.arrays)
        self.seconds.append(done.seconds)
        self.count.add(self.store.layout.count(block))

    def _broken(self) -> str:
        if self.store.folder is None:
            return ENDED
        return (
            "a worker was ended from outside, or did not start (a script needs "
            f"`if __name__ == '__main__':`){self._where()}."
        )

    def _where(self) -> str:
        if self.store.folder is None:
            return ""
        return (
            f"; finished chunks are kept in {path_text(self.store.folder)}: give the same call, "
            "with a fresh executor, to go on"
        )
