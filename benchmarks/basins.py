"""Maps of outcomes: launches a second, against heyoka's own batch mode, and the cost predicted.

The raw batch integrates the same launches to the same horizon with the same events, as heyoka's
documentation does: whole batches of as many launches as the processor has lanes, no outcome, no
proof, no second run.  It stops where all launches of a batch have ended.  It has the equations of
the Newton-Euler graph in the disk's six states, without the account of energy; a second raw batch
has those of `momenta.py`, which the package integrates itself: two ratios separate what the
equations give from what ends by proof and full lanes give.  CPU time of one process, paired;
medians of the ratios.
"""

import argparse
import contextlib
import os
import resource
import statistics
import threading
import time
from pathlib import Path
from typing import Any

import numpy as np

import stability as st
from stability.basin.basins import planned
from stability.basin.cost import predict
from stability.basin.launches import prepare
from stability.basin.outcomes import outcomes
from stability.integrators import taylor
from stability.integrators.flow import flow, flow_of
from stability.integrators.lanes import lean_of
from stability.motion.result import BY_CODE, Settings
from stability.motion.starts import Starts

MU, HORIZON = 0.3, 2000.0
HORIZONS = (200.0, 1000.0, 2000.0)
SCENES = {"spinning": "phi_dot", "rolling": "omega3"}
BODIES = {"uniform disk": 0.25, "annulus": 0.4, "hoop": 0.5}


def launches(family: str, k: float, count: int, seed: int, horizon: float) -> Starts:
    """Random launches of the scene: angular velocity 0.3 to 4, tilt 0 to 0.6."""
    own = SCENES[family]
    asked = prepare(
        st.Disk(k=k),
        "viscous",
        (own, "tilt"),
        {},
        horizon,
        Settings(),
        family=family,
        parameters={"mu": MU},
    )
    rng = np.random.default_rng(seed)
    points = {own: rng.uniform(0.3, 4, count), "tilt": rng.uniform(0, 0.6, count)}
    return asked.starts(points)


def raw(some: Starts, tolerance: float, most: int, *, short: bool = False) -> float:
    """CPU time of heyoka's batch mode for a launch [s].

    `short`: in the states that the package integrates; otherwise in the six of the disk.
    """
    import heyoka as hy

    whole = flow_of(some.model)
    lean = lean_of(whole)
    which = (
        lean.flow
        if short
        else whole.having(x=whole.x[:-1], rhs=whole.rhs[:-1], names=whole.names[:-1])
    )
    symbols, rates, guards = taylor.expressions(which)
    width = hy.recommended_simd_size()
    batch = hy.taylor_adaptive_batch(
        list(zip(symbols, rates, strict=True)),
        np.zeros((len(symbols), width)),
        tol=tolerance,
        t_events=[
            hy.t_event_batch(guards[0], direction=hy.event_direction.negative, callback=_Park(some))
        ],
        pars=np.ones((which.p.numel(), width)),
    )
    fit = [i for i in range(some.count) if i not in (some.unfit or {})]
    y, p = whole.pack(some.starts), np.column_stack([some.p, np.full(some.count, 1e-6)])
    y = lean.pack(y) if short else y[:, :-1]
    begin = time.process_time()
    for first in range(0, len(fit) - width + 1, width):
        rows = fit[first : first + width]
        batch.state[:], batch.pars[:] = y[rows].T, p[rows].T
        batch.set_time(0.0)
        batch.reset_cooldowns()
        batch.propagate_until(float(some.times[-1]), max_steps=most)
    return (time.process_time() - begin) / (len(fit) // width * width)


class _Park:
    """Puts an ended lane on a stable upright spin without friction, which needs few steps."""

    def __init__(self, some: Starts) -> None:
        p = some.model.system.parameters
        self.friction = [p.index(n) for n in ("mu",) if n in p]

    def __call__(self, batch: Any, _sign: int, lane: int) -> bool:
        batch.state[:, lane] = 0.0
        batch.state[0, lane] = np.pi / 2
        batch.state[2, lane] = 2.0 / np.sqrt(batch.pars[0, lane])
        batch.pars[self.friction, lane] = 0.0
        return True


def reference(count: int, repeats: int) -> None:
    """Launches near the reference launch, to T = 100: the same work, and what it costs here."""
    rng = np.random.default_rng(7)
    start = st.launch("rolling", at=1.2) + rng.uniform(-0.01, 0.01, (count, 6))
    names = ("theta", "theta_dot", "phi_dot", "omega3", "slip_x", "slip_y")
    asked = prepare(st.Disk(), "viscous", names, {}, 100.0, Settings(), parameters={"mu": MU})
    some = asked.starts(dict(zip(names, start.T, strict=True)))
    shares = []
    outcomes(some, Settings(check=False))
    for _ in range(repeats):
        bare = raw(some, 1e-9, 10**6)
        begin = time.process_time()
        outcomes(some, Settings(check=False))
        shares.append(bare / ((time.process_time() - begin) / count))
    print(
        f"reference batch, {count} launches to T = 100, tolerance 1e-9: throughput "
        f"{statistics.median(shares):.2f} of raw heyoka's batch"
    )


def scene(count: int, repeats: int, horizon: float) -> None:
    """The scene of rolling and spinning starts, against raw batches."""
    print(
        f"rolling and spinning starts, mu = {MU}, to T = {horizon:g}, tolerance 1e-9, "
        f"{count} launches each"
    )
    all_raw = all_own = 0.0
    for body, k in BODIES.items():
        for family in SCENES:
            some = launches(family, k, count, 1, horizon)
            outcomes(launches(family, k, 2048, 2, 2.0), Settings())
            ratios, shorter, single, checked = [], [], [], []
            for _ in range(repeats):
                bare = raw(some, 1e-9, 10**6)
                begin = time.process_time()
                found = outcomes(some, Settings(check=False))
                middle = time.process_time()
                outcomes(some, Settings())
                checked.append((time.process_time() - middle) / count)
                single.append((middle - begin) / count)
                ratios.append(bare / single[-1])
                shorter.append(raw(some, 1e-9, 10**6, short=True) / single[-1])
            codes, many = np.unique(found.outcome, return_counts=True)
            ends = ", ".join(f"{n} {BY_CODE[c].word}" for c, n in zip(codes, many, strict=True))
            once, twice = (1e6 * min(seconds) for seconds in (single, checked))
            all_own += statistics.median(single)
            all_raw += statistics.median(ratios) * statistics.median(single)
            print(
                f"  {body}, {family}: {once:.0f} us a launch, run twice {twice:.0f} us; "
                f"{statistics.median(ratios):.1f} times raw batches, "
                f"{statistics.median(shorter):.1f} times those in momenta; {ends}",
                flush=True,
            )
    print(f"  the whole scene: {all_raw / all_own:.1f} times raw batches")


def predicted() -> None:
    """The cost that is predicted, over that which it takes."""
    for family, own in SCENES.items():
        asked: dict[str, Any] = {
            "mu": MU,
            "family": family,
            "horizon": 300.0,
            "x": (own, 0.3, 4.0, 64),
            "y": ("tilt", 0.01, 0.6, 32),
        }
        cost = predict(planned(None, "viscous", **asked))
        begin = time.process_time()
        st.basins(contact="viscous", workers=1, **asked)
        real = time.process_time() - begin
        print(f"predicted cost, {family}: {cost.computing:.1f} s, real {real:.1f} s")


def million(count: int, family: str, horizon: float, workers: int, *, check: bool) -> float:
    """Wall time of a map of many launches in a store, by processes [s]; prints memory too."""
    import tempfile

    side = round(count**0.5)
    with tempfile.TemporaryDirectory() as folder, Together() as memory:
        begin, before = time.perf_counter(), _spent()
        found = st.basins(
            contact="viscous",
            mu=MU,
            family=family,
            horizon=horizon,
            x=(SCENES[family], 0.3, 4.0, side),
            y=("tilt", 0.0, 0.6, side),
            check=check,
            store=f"{folder}/map.zarr",
            executor="processes",
            workers=workers,
        )
        wall, spent = time.perf_counter() - begin, _spent() - before
        codes, many = np.unique(found.outcome.values, return_counts=True)
    own, theirs = (
        resource.getrusage(who).ru_maxrss / 2**20
        for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
    )
    ends = ", ".join(f"{n} {BY_CODE[c].word}" for c, n in zip(codes, many, strict=True))
    runs = "twice" if check else "once"
    print(
        f"{side * side} launches, {family}, to T = {horizon:g}, run {runs}, "
        f"{workers} processes: {wall:.0f} s, computing time {spent:.0f} s, peak memory "
        f"{own:.2f} and {theirs:.2f} GiB a process, {memory.peak / 2**30:.2f} GiB together; "
        f"{ends}; load {os.getloadavg()[0]:.1f}",
        flush=True,
    )
    return wall


class Together:
    """The largest memory of this process and its children together [bytes], where there is /proc.

    Pages that several of them share count once (PSS).
    """

    def __init__(self) -> None:
        self.peak = 0
        self._ended = threading.Event()
        self._watch = threading.Thread(target=self._look, daemon=True)

    def __enter__(self) -> "Together":
        self._watch.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._ended.set()
        self._watch.join()

    def _look(self) -> None:
        while not self._ended.wait(0.5):
            family, seen = [os.getpid()], set()
            while family:
                one = family.pop()
                seen.add(one)
                for task in Path(f"/proc/{one}/task").glob("*/children"):
                    with contextlib.suppress(OSError):
                        family += map(int, task.read_text().split())
            self.peak = max(self.peak, sum(map(_shared_out, seen)))


def _shared_out(process: int) -> int:
    """Memory of a process, its share of common pages [bytes]; 0 where it has ended."""
    with contextlib.suppress(OSError):
        for line in Path(f"/proc/{process}/smaps_rollup").read_text().splitlines():
            if line.startswith("Pss:"):
                return 1024 * int(line.split()[1])
    return 0


def scaling(count: int, family: str, horizon: float) -> None:
    """The same map by one worker and by two."""
    one, two = (million(count, family, horizon, n, check=False) for n in (1, 2))
    print(f"two workers: {one / two:.2f} times as fast as one")


def _spent() -> float:
    """Computing time of this process and of those that have ended [s]."""
    used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(one.ru_utime + one.ru_stime for one in used)


WHAT = ("reference", "scene", "predicted", "million", "scaling")
"""What can be measured; the first three by default."""


def main() -> None:
    """Print the figures that are asked."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("what", nargs="*", help=f"some of {', '.join(WHAT)}; the first three")
    parser.add_argument("--count", type=int, help="launches: 4096, of a million 1000000")
    parser.add_argument("--family", choices=tuple(SCENES), action="append")
    parser.add_argument("--time", type=float, action="append", help="last times")
    parser.add_argument("--check", action="store_true", help="run each of a million twice")
    parser.add_argument("--repeats", type=int, default=3)
    asked = parser.parse_args()
    what = asked.what or WHAT[:3]
    if set(what) - set(WHAT):
        parser.error(f"give some of {', '.join(WHAT)}")
    if not taylor.available():
        print("heyoka is not installed")
        return
    flow("viscous")
    families, last = asked.family or tuple(SCENES), (asked.time or [HORIZON])[0]
    if "reference" in what:
        reference(asked.count or 4096, asked.repeats)
    for horizon in (asked.time or HORIZONS) if "scene" in what else ():
        scene(asked.count or 4096, asked.repeats, horizon)
    if "predicted" in what:
        predicted()
    for family in families:
        if "million" in what:
            million(asked.count or 1_000_000, family, last, 2, check=asked.check)
        if "scaling" in what:
            scaling(asked.count or 65_536, family, last)


if __name__ == "__main__":
    main()
