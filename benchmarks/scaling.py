"""Scaling of many launches: measured with one and two workers, simulated for up to 1000.

Chunks of real launches go to a Zarr folder by one and by two workers, in turns, so that a busy
machine hits both alike.  The CPU time of each chunk is measured in this process, and the CPU time
that the driver (with dask its scheduler too) spends for a chunk, on chunks without work, with as
many in flight as the workers would have.  An event simulation then serves workers from one driver:
times of chunks are drawn from the measured ones.  It prints a table and what loses most, and keeps
the shares in docs/scaling.json, from which the documentation draws its figure.
"""

from __future__ import annotations

import argparse
import heapq
import json
import os
import statistics
import tempfile
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import stability as st
from stability.jobs.dask import engine
from stability.jobs.filling import AHEAD, fill
from stability.jobs.pipeline import here
from stability.storage.chunks import Layout, Variable
from stability.storage.zarr_store import ZarrStore

RECORD = Path(__file__).resolve().parents[1] / "docs" / "scaling.json"
ENGINES = ("processes", "dask")
WORKERS = (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000)
SHOWN = (1, 2, 10, 100, 1000)
VARIABLES = (Variable("outcome", "int8", -1), Variable("end_time", "float64", float("nan")))
EMPTY = 1500
"""Chunks without work, by which the driver is measured."""
EACH, LARGER = 100, 20
"""Chunks of each worker in a simulated run; factor of the longer ones."""


@dataclass(frozen=True)
class Launches:
    """Work of a chunk: launches by number, so that any order of work gives the same ones."""

    size: int

    def __call__(self, block: tuple[int, ...], part: slice) -> Mapping[str, NDArray[Any]]:
        starts = np.random.default_rng([20261123, *block]).uniform(-1.0, 1.0, (self.size, 6))
        starts = [1.3, 0, 0, 1.2, 0, 0] + starts * [0.2, 0.2, 0.2, 0.4, 1e-3, 1e-3]
        found = st.simulate(
            st.Disk(), st.Viscous(0.3), starts[part], [0.0, 40.0], workers=1, check=False
        )
        return {name: found[name].values for name in ("outcome", "end_time")}


@dataclass(frozen=True)
class Nothing:
    """Work of a chunk without work."""

    def __call__(self, _: tuple[int, ...], part: slice) -> Mapping[str, NDArray[Any]]:
        return blank(part.stop - part.start)


def blank(count: int) -> dict[str, NDArray[Any]]:
    return {"outcome": np.full(count, 6, np.int8), "end_time": np.full(count, np.nan)}


def filled(folder: Path, chunks: int, size: int, work: Any, **how: Any) -> Any:
    store = ZarrStore(
        folder / "a.zarr", Layout(("launch",), (chunks * size,), (size,)), VARIABLES, overwrite=True
    )
    for block in store.layout.blocks():  # of the turn before
        (store.folder / "outcome" / f"c.{block[0]}").unlink(missing_ok=True)
    return fill(store, work, blank=blank, **how)


# --- measured ---


def chunk_times(folder: Path, chunks: int, size: int) -> list[float]:
    """CPU time of each chunk, its files included [s]; the first compiles and does not count."""
    work, marks = Launches(size), []

    def mark(*_: int) -> None:
        marks.append(time.process_time())

    filled(folder, chunks + 1, size, work, start_pool=here, progress=mark)
    return list(np.diff(marks[1:]))


def turns(
    folder: Path, name: str, chunks: int, size: int, count: int
) -> tuple[dict[int, float], dict[int, float]]:
    """Median times of one and two workers [s], started and compiled before; share of chunks in it.

    The share does not count that workers slow each other down, nor that the machine is busy.
    """
    times: dict[int, list[float]] = {1: [], 2: []}
    shares: dict[int, list[float]] = {1: [], 2: []}
    with engine(name, 1) as (single, _), engine(name, 2) as (pair, _):
        pools = {1: single, 2: pair}
        for workers, pool in pools.items():
            filled(folder, 2 * workers, size, Launches(size), executor=pool, workers=workers)
        for turn in range(count):
            for workers in (1, 2) if turn % 2 else (2, 1):
                begin = time.perf_counter()
                found = filled(
                    folder, chunks, size, Launches(size), executor=pools[workers], workers=workers
                )
                took = time.perf_counter() - begin
                times[workers].append(took)
                shares[workers].append(sum(found.seconds) / (workers * took))
    return tuple({n: statistics.median(v) for n, v in d.items()} for d in (times, shares))


def driver_times(folder: Path, name: str) -> dict[int, float]:
    """CPU time of the driver for a chunk [s], by the number of workers that it would have."""
    found = {}
    with engine(name, 2) as (pool, _):
        filled(folder, 50, 10, Nothing(), executor=pool, workers=2)
        for workers in (2, 100, 1000):
            begin = time.process_time()
            filled(folder, max(EMPTY, 3 * workers), 10, Nothing(), executor=pool, workers=workers)
            found[workers] = (time.process_time() - begin) / max(EMPTY, 3 * workers)
    return found


def start_time(name: str, size: int, chunk: float) -> float:
    """CPU time of a driver and a worker for their start and a first chunk, less a chunk's [s]."""
    begin = sum(os.times()[:4])
    with tempfile.TemporaryDirectory() as folder:
        with engine(name, 1) as (pool, _):
            filled(Path(folder), 1, size, Launches(size), executor=pool, workers=1)
    return sum(os.times()[:4]) - begin - chunk


# --- simulated ---


@dataclass(frozen=True)
class Run:
    """A simulated run."""

    time: float
    """From the first chunk sent to the last one taken [s]."""
    busy: float
    """Time of all chunks [s]."""
    driver: float
    """Time in which the driver worked [s]."""
    tail: float
    """Idle time of all workers after their last chunk [s]."""


def simulated(times: Sequence[float], workers: int, driver: float) -> Run:
    """One driver serves the workers: it sends each chunk, and takes each result, in turn."""
    free, served = 0.0, 0.0
    done = [0.0] * workers
    left = list(times)
    busy = sum(left)
    # the first entries bring no result: they only ask for a chunk
    ended = [(0.0, w, False) for _ in range(AHEAD) for w in range(workers)]
    while ended:
        at, worker, result = heapq.heappop(ended)
        cost = driver / 2 * (result + bool(left))
        free, served = max(free, at) + cost, served + cost
        if left:
            done[worker] = max(done[worker], free) + left.pop()
            heapq.heappush(ended, (done[worker], worker, True))
    return Run(max(free, *done), busy, served, sum(max(done) - d for d in done))


def overhead(driver: Mapping[int, float], workers: int) -> float:
    """Driver's time for a chunk, between the numbers of workers at which it was measured."""
    return float(np.interp(np.log(workers), np.log(list(driver)), list(driver.values())))


def bottleneck(run: Run, workers: int, start: float) -> str:
    """What loses most of the workers' time."""
    total = workers * (run.time + start)
    lost = {
        "start of the workers": workers * start,
        "last chunks, while others are done": run.tail,
    }
    lost["driver"] = max(0.0, total - run.busy - sum(lost.values()))
    name = max(lost, key=lambda n: lost[n])
    return f"{name} ({lost[name] / total:.1%})"


def efficiency(run: Run, workers: int, start: float) -> float:
    """Share of the workers' time in which they compute chunks."""
    return run.busy / (workers * (run.time + start))


def table(runs: Mapping[int, Run], chunks: Mapping[int, int], size: int, start: float) -> None:
    print(f"{'workers':>8} {'launches':>9} {'time [s]':>9} {'efficiency':>10}  loses most")
    for n in SHOWN:
        run = runs[n]
        print(
            f"{n:8d} {chunks[n] * size:9.1e} {run.time + start:9.1f} "
            f"{efficiency(run, n, start):10.3f}  {bottleneck(run, n, start)}"
        )


def main() -> None:
    parser = argparse.ArgumentParser(description=str(__doc__).split("\n")[0])
    parser.add_argument("--size", type=int, default=3000, help="launches of a chunk")
    parser.add_argument("--chunks", type=int, default=8, help="chunks of a measured run")
    parser.add_argument("--turns", type=int, default=3, help="runs of each number of workers")
    parser.add_argument("--launches", type=float, default=1e7, help="launches of a simulated run")
    parser.add_argument("--no-record", action="store_true", help="print alone")
    options = parser.parse_args()
    size, random = options.size, np.random.default_rng(20261123)
    curves: dict[str, list[float]] = {}
    measured = {}
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        times = chunk_times(folder, options.chunks, size)
        print(
            f"{size} launches a chunk: {statistics.mean(times):.3f} s of CPU, "
            f"{min(times):.3f} to {max(times):.3f}; load of the machine {os.getloadavg()[0]:.1f}"
        )
        for kind in ENGINES:
            took, share = turns(folder, kind, options.chunks, size, options.turns)
            measured[kind] = share[2]
            driver, start = (
                driver_times(folder, kind),
                start_time(kind, size, statistics.mean(times)),
            )
            per = ", ".join(f"{1e3 * t:.2f} ms for {n}" for n, t in driver.items())
            print(
                f"\n{kind}: 1 worker {took[1]:.2f} s, 2 workers {took[2]:.2f} s, efficiency "
                f"{took[1] / took[2] / 2:.3f}; share of chunks {share[1]:.3f} and {share[2]:.3f}"
            )
            print(f"driver's time for a chunk {per} workers; start {start:.1f} s")
            whole = dict.fromkeys(WORKERS, round(options.launches / size))
            each = {n: EACH * n for n in WORKERS}
            for words, chunks, larger in (
                ("", whole, 1),
                (f"{EACH} chunks a worker", each, 1),
                (f"{EACH} chunks a worker, {LARGER} times as long", each, LARGER),
            ):
                runs = {
                    n: simulated(larger * random.choice(times, chunks[n]), n, overhead(driver, n))
                    for n in WORKERS
                }
                print(words or f"{options.launches:.0e} launches")
                table(runs, chunks, larger * size, start)
                if words:
                    length = f"{larger * statistics.mean(times):.2g} s"
                    curves[f"{kind}, {length}"] = [
                        efficiency(run, n, start) for n, run in runs.items()
                    ]
    if not options.no_record:
        shares = {
            "workers": WORKERS,
            "chunks a worker": EACH,
            "simulated": curves,
            "measured with two workers": measured,
        }
        RECORD.write_text(json.dumps(shares, indent=1) + "\n", encoding="utf-8")
        print(f"\n{RECORD.name}; `python docs/scaling_picture.py` draws it")


if __name__ == "__main__":
    main()
