"""What a map or sample of launches will cost, from some of its launches."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from operator import itemgetter

import numpy as np
from numpy.typing import NDArray

from ..base.types import Floats
from ..integrators.lanes import STRIDE, lanes_of_batch
from ..storage.chunks import Arrays, Block
from .basins import Plan
from .dataset import arrays
from .launch_labels import coded
from .outcomes import outcomes
from .refinement import expected_launches
from .statistics.samples import sample

FIRST, LAST, GROWTH = 8, 512, 4
"""Launches of the first and of the last trial, and their ratio from one trial to the next."""
SECONDS, SHARE = 3.0, 0.01
"""Computing time of a trial at most [s], or the share of the expected cost that it may take."""
NEAR = 4
"""Neighbours of a launch that are compared with it for the length of borders."""


@dataclass(frozen=True)
class Cost:
    """Expected cost of a call of `basins`."""

    launches: int
    """Launches of the map or sample to run."""
    stored: int
    """Launches that the store holds already."""
    sampled: int
    """Launches that were run for the estimate."""
    computing: float
    """Computing time of all workers together [s]."""
    seconds: float
    """Time until the end, where each worker has a processor of its own [s]."""
    least: float
    """The same without the launches that are decided one by one, which are few and slow [s]."""
    workers: int
    """Number of workers."""
    size: int
    """Size of the whole store, compressed [bytes]."""
    border: int = 0
    """Launches expected along borders, about; they are part of the times."""


@dataclass(frozen=True)
class _Trial:
    """What some launches cost, and how that grows with their number."""

    columns: Arrays
    """Arrays of the launches."""
    turns: Floats
    """Numbers of steps at which a launch ended, ascending, whole strides."""
    together: float
    """Cost of the batches [s]."""
    alone: float
    """Cost of the launches that were decided one by one [s]."""

    @property
    def count(self) -> int:
        """Number of launches."""
        return len(self.columns["outcome"])

    def steps(self, launches: float) -> float:
        """Steps of whole batches if so many launches end as these do.

        A batch costs the same for one lane as for all.  Lanes that are free take the launches of
        other batches, so that Σ ceil(launches that still run/lanes of a batch) steps are made.
        """
        running = launches * (1 - np.arange(self.count) / self.count)
        return float(np.diff(self.turns, prepend=0.0) @ np.ceil(running / lanes_of_batch()))

    def price(self, launches: float) -> tuple[float, float]:
        """Expected cost of the batches, and of single launches, of so many launches [s]."""
        if not launches:
            return 0.0, 0.0
        steps = self.steps(self.count)
        together = self.together * self.steps(launches) / steps if steps else 0.0
        return together, self.alone * launches / self.count


def predict(
    plan: Plan,
    workers: int = 1,
    missing: Sequence[Block] | None = None,
    clock: Callable[[], float] = time.process_time,
    levels: int = 0,
) -> Cost:
    """Expected cost of a plan, from trials of launches that are spread over it.

    The steps at which the launches of a trial end say how many steps whole batches make for any
    number of launches.  Trials grow up to `LAST` launches while they are cheap.

    Parameters
    ----------
    plan
        The launches, from `planned`.
    workers
        Number of workers.
    missing
        Chunks to compute; all when left out.
    clock
        Computing time of this process [s].
    levels
        Halvings of the steps of a map along its borders, if these are to be refined.

    Returns
    -------
    Cost

    Raises
    ------
    StabilityError
        In one sentence, if a launch of a trial is refused.

    Source: benchmarks/basins.py compares it with the cost of whole maps.

    Examples
    --------
    >>> import stability as st
    >>> from stability.basin.basins import planned
    >>> plan = planned(None, "viscous", mu=0.3, family="spinning", x=("at", 1, 3, 30),
    ...                y=("tilt", 0.1, 0.2, 20), horizon=5.0)
    >>> cost = predict(plan, workers=2)
    >>> cost.launches, cost.stored, 0 < cost.seconds <= cost.computing
    (600, 0, True)
    """
    layout = plan.layout
    blocks = layout.blocks() if missing is None else list(missing)
    counts = [layout.count(b) for b in blocks]
    launches = sum(counts)
    if not launches and not levels:
        return Cost(0, layout.total, 0, 0.0, 0.0, 0.0, workers, 0)
    cells = _spread(layout.shape)
    trial = _trials(plan, cells, max(launches, 1), clock)
    columns = trial.columns
    border = _along_borders(layout.shape, cells[: trial.count], columns, levels) if levels else 0
    waves = 2 * levels  # of a refinement; they follow each other
    parts = [trial.price(launches / max(len(blocks), 1))] * len(blocks)
    rounds = parts[: math.ceil(len(blocks) / workers)]
    share = [trial.price(border / waves / workers)] * waves if waves else []
    seconds, least = (sum(map(part, rounds + share)) for part in (sum, itemgetter(0)))
    computing = sum(map(sum, parts)) + workers * sum(map(sum, share))
    size = (_compressed(columns) * layout.total) + border
    done = layout.total - launches
    return Cost(
        launches,
        done,
        trial.count,
        computing,
        seconds,
        least or seconds,
        workers,
        round(size),
        border,
    )


def _along_borders(
    shape: tuple[int, ...], cells: NDArray[np.intp], columns: Arrays, levels: int
) -> int:
    """Launches along borders, from neighbours among scattered ones.

    A line of length L parts a share f of the pairs at distance r, f = 2 L r/(π A), and passes
    through 4 L/π cells of a lattice (Buffon).
    """
    from scipy.spatial import KDTree

    labels, near = coded(columns["outcome"], columns["family"]), min(NEAR, len(cells) - 1)
    if not near:
        return 0
    apart, place = KDTree(cells).query(cells, near + 1)
    unlike = labels[place[:, 1:]] != labels[:, None]
    area = float(math.prod(n - 1 for n in shape))
    mixed = min(2 * area * unlike.sum() / apart[:, 1:].sum(), area)
    return expected_launches(mixed, levels)


def _trials(
    plan: Plan, cells: NDArray[np.intp], launches: int, clock: Callable[[], float]
) -> _Trial:
    """The last trial that is cheap."""
    _run(plan, cells[:FIRST], clock)  # compiles
    size = FIRST
    while True:
        trial = _run(plan, cells[:size], clock)
        spent = trial.together + trial.alone
        budget = max(SECONDS, SHARE * sum(trial.price(launches)))
        if trial.count == len(cells) or GROWTH * spent > budget:
            return trial
        size *= GROWTH


def _run(plan: Plan, cells: NDArray[np.intp], clock: Callable[[], float]) -> _Trial:
    """Some launches, and what they cost."""
    launches = plan.launches.starts(_points(plan, cells))
    begin = clock()
    middle: list[float] = []
    done = outcomes(launches, plan.launches.settings, lambda: middle.append(clock()))
    columns, end = arrays(done, launches), clock()
    [parting] = middle or [begin]  # none ran on lanes
    strides = np.ceil(np.sort(done.steps) / STRIDE) * STRIDE
    return _Trial(columns, strides, parting - begin, end - parting)


def _points(plan: Plan, cells: NDArray[np.intp]) -> dict[str, Floats]:
    """Values of the numbers that vary, of some launches, shape (n, axes) by their indices."""
    if plan.distribution is None:
        return {a.name: a.values[i] for a, i in zip(plan.axes, cells.T, strict=True)}
    rows = [sample(plan.distribution, int(i), 1, plan.seed)[0] for i in cells[:, 0]]
    return dict(zip(plan.launches.varied, np.array(rows).T, strict=True))


def _spread(shape: tuple[int, ...]) -> NDArray[np.intp]:
    """Indices of `LAST` launches, or of all, any first of them evenly spread, shape (n, axes).

    Source: the additive recurrence of the generalised golden ratio (Roberts, 2018).
    """
    total = math.prod(shape)
    if total <= LAST:
        order = np.random.default_rng(0).permutation(total)
        return np.stack(np.unravel_index(order, shape), axis=1)
    golden = 2.0
    for _ in range(60):
        golden = (1 + golden) ** (1 / (len(shape) + 1))
    steps = golden ** -np.arange(1.0, len(shape) + 1)
    cells = ((0.5 + np.arange(LAST)[:, None] * steps) % 1.0 * shape).astype(np.intp)
    first = np.unique(cells, axis=0, return_index=True)[1]
    return cells[np.sort(first)]


def _compressed(columns: Arrays) -> float:
    """Bytes of a launch in a store."""
    from ..storage.zarr_store import LEVEL

    number = len(next(iter(columns.values())))
    plain = {n: np.ascontiguousarray(v).tobytes() for n, v in columns.items()}
    try:
        from numcodecs.zstd import Zstd
    except ImportError:
        total = sum(map(len, plain.values()))
    else:
        total = sum(len(Zstd(level=LEVEL).encode(v)) for v in plain.values())
    return total / number
