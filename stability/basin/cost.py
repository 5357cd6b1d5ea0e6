"""What a map or sample of launches will cost, from some of its launches."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from ..base.types import Floats
from ..integrators.flow import CASADI
from ..jobs.chunks import Arrays, Block
from .basins import Plan
from .dataset import arrays
from .launch_labels import coded
from .outcomes import outcomes
from .refinement.waves import expected_launches
from .statistics.samples import sample

FIRST, LAST, GROWTH = 8, 512, 4
"""Launches of the first and of the last trial, and their ratio from one trial to the next."""
SECONDS, SHARE = 3.0, 0.01
"""Computing time of a trial at most [s], or the share of the expected cost that it may take."""
NEAR = 4
"""Neighbours of a launch that are compared with it for the length of borders."""
LEAST_SHARE = 0.2
"""Least part of a trial's mean cost that counts as the cost of one more launch."""


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
    workers: int
    """Number of workers."""
    size: int
    """Size of the whole store, compressed [bytes]."""
    border: int = 0
    """Launches expected along borders, about; they are part of the times."""


def predict(
    plan: Plan, workers: int = 1, missing: Sequence[Block] | None = None,
    clock: Callable[[], float] = time.process_time, levels: int = 0,
) -> Cost:  # fmt: skip
    """Expected cost of a plan, from trials of launches that are spread over it.

    A trial costs something at once, since lanes stand empty at its end, and something for each
    launch.  Two trials of different sizes give both numbers.  Trials grow up to `LAST` launches
    while they are cheap.

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
        In one sentence, if a launch at a corner of a map or one of a trial is refused.

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
        return Cost(0, layout.total, 0, 0.0, 0.0, workers, 0)
    _corners(plan)
    cells = _spread(layout.shape)
    once, each, found = _trials(plan, cells, max(launches, 1), clock)
    tried = len(found["outcome"])
    border = _along_borders(layout.shape, cells[:tried], found, levels) if levels else 0
    computing = len(blocks) * once + launches * each
    rounds = math.ceil(len(blocks) / workers)
    seconds = rounds * (once + each * launches / max(len(blocks), 1))
    # waves of a refinement follow each other: two for a level
    computing += 2 * levels * workers * once + border * each
    seconds += 2 * levels * once + border * each / workers
    size = (_compressed(found) * layout.total) + border
    done = layout.total - launches
    return Cost(launches, done, tried, computing, seconds, workers, round(size), border)


def _along_borders(
    shape: tuple[int, ...], cells: NDArray[np.intp], found: Arrays, levels: int
) -> int:
    """Launches along borders, from neighbours among scattered ones.

    A line of length L parts a share f of the pairs at distance r, f = 2 L r/(π A), and passes
    through 4 L/π cells of a lattice (Buffon).
    """
    labels, near = coded(found["outcome"], found["family"]), min(NEAR, len(cells) - 1)
    if not near:
        return 0
    apart, place = KDTree(cells).query(cells, near + 1)
    unlike = labels[place[:, 1:]] != labels[:, None]
    area = float(math.prod(n - 1 for n in shape))
    mixed = min(2 * area * unlike.sum() / apart[:, 1:].sum(), area)
    return expected_launches(mixed, levels)


def _trials(
    plan: Plan, cells: NDArray[np.intp], launches: int, clock: Callable[[], float]
) -> tuple[float, float, Arrays]:
    """Cost of a chunk without launches, of one more launch, and the arrays of the last trial."""
    found = _run(plan, cells[:FIRST])  # compiles
    size, former = FIRST, (0, 0.0)
    while True:
        some, begin = cells[:size], clock()
        found = _run(plan, some)
        last = len(some), clock() - begin
        budget = max(SECONDS, SHARE * last[1] / last[0] * launches)
        if len(some) == len(cells) or GROWTH * last[1] > budget:
            break
        size, former = GROWTH * size, last
    mean = last[1] / last[0]
    slope = (last[1] - former[1]) / (last[0] - former[0])
    each = min(max(slope, LEAST_SHARE * mean), mean)
    return max(last[1] - each * last[0], 0.0), each, found


def _run(plan: Plan, cells: NDArray[np.intp]) -> Arrays:
    """Arrays of some launches."""
    with CASADI:
        launches = plan.launches.starts(_points(plan, cells), plan.horizon)
    return arrays(outcomes(launches, plan.judging), launches)


def _points(plan: Plan, cells: NDArray[np.intp]) -> dict[str, Floats]:
    """Values of the numbers that vary, of some launches, shape (n, axes) by their indices."""
    if plan.distribution is None:
        return {a.name: a.values[i] for a, i in zip(plan.axes, cells.T, strict=True)}
    rows = [sample(plan.distribution, int(i), 1, plan.seed)[0] for i in cells[:, 0]]
    return dict(zip(plan.launches.varied, np.array(rows).T, strict=True))


def _corners(plan: Plan) -> None:
    """Refuse a map at once if a launch at one of its corners is refused."""
    if plan.distribution is None:
        ends = [sorted({0, a.count - 1}) for a in plan.axes]
        with CASADI:
            plan.launches.starts(_points(plan, np.array(list(product(*ends)))), plan.horizon)


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


def _compressed(found: Arrays) -> float:
    """Bytes of a launch in a store."""
    from ..jobs.zarr_store import LEVEL

    number = len(next(iter(found.values())))
    plain = {n: np.ascontiguousarray(v).tobytes() for n, v in found.items()}
    try:
        from numcodecs.zstd import Zstd
    except ImportError:
        total = sum(map(len, plain.values()))
    else:
        total = sum(len(Zstd(level=LEVEL).encode(v)) for v in plain.values())
    return total / number
