"""Fast kernels from the exact polynomials against AD Jacobian + numpy.linalg.eigvals.

One run measures all routes on the same map, the baseline on some of its rows.  The routes take
turns, since machines are shared and noisy: compare ratios of medians.  Times are of the processor
and of one thread, so that neither the number of processors nor other programs count.  The baseline
evaluates the AD Jacobian of its points at once and calls one batched `eigvals`: no bound, many
wrong signs.  `cold` is the first map of a machine, `warm` the first one of a process.  The arrays
of a map are new memory: `memory` is the time in which the system gives it, 25 bytes a point.  Some
virtual machines take a hundred times as long for it as others, so it is timed by itself.

The settling test of many launches is timed against the single test in flint's balls.

Usage: python benchmarks/kernels.py [--large] [--growth | --settling]
"""

from __future__ import annotations

import json
import os
import platform
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from timing import in_turns, seconds

import stability as st
from stability.base.axis import Axis
from stability.maps.cells import Cells
from stability.maps.compiled.rates import CompiledRates
from stability.maps.engine import COMPILED_FROM
from stability.maps.verdicts import SliceVerdicts, slice_verdicts
from stability.spectra.axes import swept
from stability.spectra.certificate import certify
from stability.spectra.problem import disk_problem

REPEATS = 5
NX, NY = 2000, 1500
AXES = {"rolling": (0.2, 3.0), "spinning": (0.55, 5.0), "tumbling": (0.05, 1.55)}
MU = (0.05, 3.0)
BASE_ROWS = 40
"""Rows of the map on which the slow route is timed."""


LAWS: dict[str, tuple[Any, tuple[Any, ...]]] = {
    "viscous": (st.Viscous, ("mu", *MU, True)),
    "linear-viscous": (st.LinearViscous, ("c", *MU, True)),
    "rough": (st.Rough(), ("k", 0.05, 0.5, False)),
    "smooth": (st.Smooth(), ("k", 0.05, 0.5, False)),
}
"""Each law and the second axis of its maps."""
PAIRS = {"circling": "rough", "precession": "smooth"}
"""Families of two numbers, and the law that they have."""


spent = partial(seconds, clock=time.process_time)
"""Processor time of a run [s]."""


def cases() -> list[tuple[str, str]]:
    return [(f, law) for law in LAWS for f in AXES] + list(PAIRS.items())


def problem_of(family: str, law: str, nx: int, ny: int) -> tuple[Any, tuple[Axis, Axis]]:
    kind, (name, low, high, log) = LAWS[law]
    if family in PAIRS:
        axes = Axis("theta", 0.3, 1.2, nx), Axis("phi_dot", 0.3, 3.0, ny)
    else:
        axes = Axis("at", *AXES[family], nx), Axis(name, low, high, ny, log)
    return swept(family, {a.name: a for a in axes}, contact=kind)[0], axes


def verdicts_of(question: Any, axes: tuple[Axis, Axis]) -> SliceVerdicts:
    found = slice_verdicts(question, axes)
    assert found is not None
    return found


def cells_of(question: Any, axes: tuple[Axis, Axis], *, quick: bool) -> Any:
    """The cells of a map by compiled loops or by NumPy, of any size."""
    cells = Cells(question, axes, False)
    bands: Any = cells.bands
    rows = [row for row, _, _ in bands._factors]
    bands.loops = CompiledRates.of(rows, even=bands.verdicts.slice.even) if quick else None
    return cells


def eigvals_of(question: Any, axes: tuple[Axis, Axis]) -> tuple[Callable[[], Any], int]:
    """AD Jacobian and LAPACK on some rows of a map; the members are not timed."""
    step = max(1, axes[1].count // BASE_ROWS)
    at, other = np.meshgrid(axes[0].values, axes[1].values[::step])
    swept = {axes[0].name: at.ravel(), axes[1].name: other.ravel()}
    a, q, _, _ = question.arrays(dict(question.values) | swept)
    u = question.family.members(a, q).u
    run = lambda: np.linalg.eigvals(question.family.matrix(a, u, q)).real.max(axis=1)  # noqa: E731
    return run, len(a)


def ratios(family: str, law: str, side: int = 1000) -> dict[str, Any]:
    """Growth rates with bounds and verdicts against the slow route, on one thread."""
    question, axes = problem_of(family, law, side, side)
    slow, count = eigvals_of(question, axes)
    verdicts = verdicts_of(question, axes)
    by_numpy = cells_of(question, axes, quick=False).bands
    rows = min(side, 262144 // side)
    rounds: dict[str, list[float]] = {
        name: [] for name in ("eigvals", "verdicts", "memory", "map", "numpy")
    }
    for turn in range(REPEATS + 1):  # the first one is not counted
        cells = cells_of(question, axes, quick=True)
        found = {
            "eigvals": spent(slow) / count,
            "verdicts": spent(lambda: verdicts(axes[0].values, axes[1].values)) / side**2,
            "memory": spent(lambda cells=cells: touched(cells)) / side**2,
            "map": spent(lambda cells=cells: cells.fill(1, None)) / side**2,
            "numpy": spent(lambda: by_numpy.rates(axes[0].values, axes[1].values[:rows]))
            / (rows * side),
        }
        for name, value in found.items() if turn else ():
            rounds[name].append(value)
    point = {name: statistics.median(times) for name, times in rounds.items()}
    each = [a / b for a, b in zip(rounds["eigvals"], rounds["map"], strict=True)]
    both = [a + b for a, b in zip(rounds["memory"], rounds["map"], strict=True)]
    whole = [a / b for a, b in zip(rounds["eigvals"], both, strict=True)]
    return {
        "family": family,
        "law": law,
        "points": side**2,
        "ns_per_point": {name: round(1e9 * t, 2) for name, t in point.items()},
        "ratio": round(statistics.median(each)),
        "least_ratio": round(min(each)),
        "ratio_with_memory": round(statistics.median(whole)),
        "ratio_of_numpy": round(point["eigvals"] / (point["numpy"] + point["verdicts"]), 1),
        "exactly": cells.handed_on,
    }


def touched(cells: Cells) -> None:
    """Write every page of a map's arrays once."""
    for array in (cells.abscissa, cells.error, cells.frequency, cells.codes):
        array.fill(0)


def sizes(family: str = "tumbling") -> list[dict[str, Any]]:
    """Time per point of maps of 10^4 to 10^7 points, one thread, by both routes."""
    out = []
    for side in (100, 316, 1000, 3162):
        question, axes = problem_of(family, "viscous", side, side)
        line: dict[str, Any] = {"points": side * side, "by_default": "numpy"}
        if side * side >= COMPILED_FROM:
            line["by_default"] = "compiled"
        for quick in (True, False):
            cells = cells_of(question, axes, quick=quick)
            _, *times = (spent(lambda cells=cells: cells.fill(1, None)) for _ in range(4))
            name = "compiled_ns_per_point" if quick else "numpy_ns_per_point"
            line[name] = round(1e9 * min(times) / side**2, 1)
        out.append(line)
    return out


FRESH = """
import json, resource, sys, time
start = time.perf_counter()
sys.path.insert(0, {here!r})
import kernels as k
from stability.maps.cells import Cells
loaded = time.perf_counter()
question, axes = k.problem_of("tumbling", "viscous", {nx}, {ny})
{body}
print(json.dumps(found | {{"peak_memory_MiB": resource.getrusage(
    resource.RUSAGE_SELF).ru_maxrss // 1024}}))
"""
FIRST = """
Cells(question, axes, False).fill(1, None)
found = {"first_map_s": round(time.perf_counter() - loaded, 2)}
"""
STREAM = """
import numpy as np
cells = k.cells_of(question, axes, quick=True).bands
start, count, worst, growing = time.process_time(), 0, 0.0, 0
for row in range(0, axes[1].count, 100):
    part = cells.band(axes[0].values, axes[1].values[row : row + 100])
    assert ((part["abscissa"] > 0) == (part["codes"] == 2)).all()
    count += part["codes"].size
    growing += int((part["codes"] == 2).sum())
    worst = max(worst, float(part["error"].max()))
used = time.process_time() - start
found = {"points": count, "ns_per_point": round(1e9 * used / count, 1), "growing": growing,
         "largest_bound": worst}
"""


def fresh(body: str, nx: int, ny: int, cache: str | None = None) -> dict[str, Any]:
    """The result of a new process."""
    here = str(Path(__file__).parent)
    code = FRESH.format(here=here, nx=nx, ny=ny, body=body)
    extra = {} if cache is None else {"STABILITY_CACHE_DIR": cache}
    done = subprocess.run(
        [sys.executable, "-c", code],
        env=os.environ | extra,
        check=True,
        capture_output=True,
        text=True,
    )
    found: dict[str, Any] = json.loads(done.stdout)
    return found


def growth(large: bool) -> None:
    """Everything on growth rates, a line each."""
    with tempfile.TemporaryDirectory() as cache:
        print(json.dumps({"cold": fresh(FIRST, 2000, 1000, cache)}), flush=True)
        print(json.dumps({"warm": fresh(FIRST, 2000, 1000, cache)}), flush=True)
    for family, law in cases():
        for side in (317, 1000):
            print(json.dumps(ratios(family, law, side)), flush=True)
    for line in sizes():
        print(json.dumps(line), flush=True)
    if large:
        print(json.dumps({"stream": fresh(STREAM, 10000, 10000)}), flush=True)


def axes_of(family: str, packed: float | None = None) -> tuple[Axis, Axis]:
    low, high = AXES[family]
    mu = MU
    if packed is not None:
        edge = {"rolling": np.sqrt(2), "spinning": 2.0, "tumbling": None}[family]
        if edge is None:
            [point] = st.boundaries(
                "tumbling", axis=("at", 0.9, 1.2, 9), contact=st.Viscous(1.5), disk=st.Disk()
            )
            edge, mu = point.value, (1.5 * (1 - packed), 1.5 * (1 + packed))
        low, high = edge * (1 - packed), edge * (1 + packed)
    return Axis("at", low, high, NX), Axis("mu", *mu, NY, packed is None)


def maps(family: str) -> dict[str, Any]:
    """The routes with all processors, by wall time, and the signs that LAPACK gets wrong."""
    axes = axes_of(family)
    question = swept(family, {a.name: a for a in axes}, contact=st.Viscous)[0]
    slow, count = eigvals_of(question, axes)
    grid = verdicts_of(question, axes)
    workers = os.cpu_count() or 1
    runs: dict[str, Callable[[], Any]] = {
        "eigvals": slow,
        "verdicts": lambda: grid(axes[0].values, axes[1].values),
        "growth": lambda: Cells(question, axes, False).fill(workers, None),
    }
    for run in runs.values():
        run()
    sizes = {"eigvals": count, "verdicts": NX * NY, "growth": NX * NY}
    rounds = {n: [t / sizes[n] for t in ts] for n, ts in in_turns(runs, REPEATS).items()}
    point = {name: statistics.median(times) for name, times in rounds.items()}
    return {
        "ns_per_point": {name: round(1e9 * t, 2) for name, t in point.items()},
        "verdict_ratio": round(point["eigvals"] / point["verdicts"]),
        "growth_and_verdict_ratio": round(point["eigvals"] / point["growth"], 1),
        "signs_wrong_by_eigvals": signs_wrong(question, axes, slow),
        "raw_seconds_per_point": rounds,
    }


def signs_wrong(question: Any, axes: tuple[Axis, Axis], slow: Callable[[], Any]) -> str:
    rows = axes[1].values[:: NY // BASE_ROWS]
    codes, _ = verdicts_of(question, axes)(axes[0].values, rows)
    lead = slow().reshape(codes.shape)
    return f"{int(((lead < 0) != (codes == 1)).sum())} of {codes.size}"


def packed(family: str, distance: float) -> dict[str, Any]:
    """Time of the verdict route on a grid packed around a boundary, exact arithmetic included."""
    axes = axes_of(family, distance)
    question = swept(family, {a.name: a for a in axes}, contact=st.Viscous)[0]
    grid = verdicts_of(question, axes)
    xs = np.linspace(axes[0].low, axes[0].high, 400)
    ys = np.linspace(axes[1].low, axes[1].high, 300)
    start = time.perf_counter()
    codes, left = grid(xs, ys)
    used = time.perf_counter() - start
    return {
        "distance": distance,
        "ns_per_point": round(1e9 * used / codes.size, 1),
        "handed_to_exact": left / codes.size,
        "undecided": int((codes == 0).sum()),
    }


def queries() -> dict[str, float]:
    """Median time of a certified single query, in ms, after first use."""
    random = np.random.default_rng(1)
    whole, alone = [], []
    for family, (low, high) in AXES.items():
        st.spectrum(family, at=low, contact=st.Viscous(1.0), certify=True)
        for _ in range(100):
            at, mu = random.uniform(low, high), 10 ** random.uniform(-3, 3)
            law = st.Viscous(mu)
            whole.append(
                seconds(
                    lambda at=at, law=law, family=family: st.spectrum(
                        family, at=at, contact=law, certify=True
                    )
                )
            )
            question = disk_problem(family, st.Disk(), law, at)
            values = {n: float(v) for n, v in question.values.items()}
            alone.append(seconds(lambda q=question, v=values: certify(q, v)))
    return {
        "spectrum(certify=True)_ms": 1e3 * statistics.median(whole),
        "verdict_and_eigenvalues_alone_ms": 1e3 * statistics.median(alone),
    }


def streamed(side: int) -> dict[str, Any]:
    with tempfile.TemporaryDirectory() as folder:
        target = Path(folder) / "map.nc"
        axes: dict[str, Any] = {"x": ("at", 0.011, 1.57, side), "y": ("mu", 0.01, 10, side, "log")}
        used = seconds(lambda: st.stream_map("tumbling", **axes, out=target))
        start = time.perf_counter()
        with st.read_map(target, lazy=True) as dataset:
            corner = int(dataset.verdict[-1, -1])
        opened = time.perf_counter() - start
        return {
            "cells": side * side,
            "seconds": round(used, 1),
            "corner": corner,
            "file_MiB": round(target.stat().st_size / 2**20, 2),
            "peak_memory_MiB": round(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**10),
            "opened_lazily_in_s": round(opened, 3),
        }


def settling(count: int = 20_000, singles: int = 1000) -> dict[str, Any]:
    """CPU time of a settling test, in microseconds, launches side by side in one run.

    `own`: each launch has its own k and mu; `shared`: one body and friction; `far`: states at no
    family.  flint tests some of the launches of `own`.
    """
    from stability.settling.body_lines import disk_settling

    rng = np.random.default_rng(1)
    near, own = (
        np.zeros((count, 6)),
        np.column_stack([rng.uniform(0.15, 0.5, count), 10 ** rng.uniform(-0.8, 0.5, count)]),
    )
    near[:, 0], near[:, 2] = np.pi / 2, rng.uniform(2.3, 4, count)
    off = rng.normal(size=near.shape)
    near += off * (10 ** rng.uniform(-6, -3.2, count) / np.linalg.norm(off, axis=1))[:, None]
    far, p, test = near + [0.3, 0, 0, 0.5, 0, 0], np.array([0.25, 0.3]), disk_settling(st.Viscous)
    runs = {
        f"{word}_{'numpy' if plain else 'compiled'}": lambda x=x, q=q, plain=plain: test.many(
            x, q, 1e-3, plain=plain
        )
        for word, x, q in (("own", near, own), ("shared", near, p), ("far", far, p))
        for plain in (False, True)
    }
    one = [(near[i], own[i]) for i in range(singles)]
    runs["own_flint"] = lambda: [test.nearest(x, q, 1e-3) for x, q in one]
    for run in runs.values():
        run()
    tests = dict.fromkeys(runs, count) | {"own_flint": singles}
    times = in_turns(runs, REPEATS, time.process_time)
    return {
        "us_per_test": {
            name: round(1e6 * statistics.median(v) / tests[name], 2) for name, v in times.items()
        },
        "proved_share": {
            "own": float(test.many(near, own, 1e-3).settled.proved.mean()),
            "shared": float(test.many(near, p, 1e-3).settled.proved.mean()),
        },
        "first_call_s": first_calls(),
    }


def first_calls() -> dict[str, float]:
    """CPU time of the first test in a process: with an empty cache, then with a full one."""
    code = (
        "import time, numpy as np, stability as st\n"
        "from stability.settling.body_lines import disk_settling\n"
        "start = time.process_time()\n"
        "x = np.array([[np.pi / 2, 0, 2.5, 0, 0, 1e-5]])\n"
        "disk_settling(st.Viscous).many(x, np.array([0.25, 0.3]), 1e-3)\n"
        "print(time.process_time() - start)"
    )
    with tempfile.TemporaryDirectory() as cache:
        where = os.environ | {"STABILITY_CACHE_DIR": cache}
        runs = [
            subprocess.run([sys.executable, "-c", code], env=where, capture_output=True, check=True)
            for _ in range(2)
        ]
    cold, kept = (round(float(run.stdout), 2) for run in runs)
    return {"cold": cold, "kept": kept}


def main() -> None:
    if "--settling" in sys.argv[1:]:
        print(json.dumps({"settling": settling()}), flush=True)
        return
    large, only = "--large" in sys.argv[1:], "--growth" in sys.argv[1:]
    if large and not only:  # first, so that the peak memory is that of the stream
        print(json.dumps({"streamed": streamed(31623)}), flush=True)
    print(
        json.dumps(
            {
                "machine": platform.machine(),
                "python": platform.python_version(),
                "numpy": np.__version__,
            }
        )
    )
    growth(large)
    if only:
        return
    print(json.dumps({"certified_query": queries()}), flush=True)
    print(json.dumps({"settling": settling()}), flush=True)
    for family in AXES:
        result = maps(family)
        raw = result.pop("raw_seconds_per_point")
        print(json.dumps({family: result, "raw": raw}), flush=True)
        for distance in (1e-3, 1e-9, 1e-13, 1e-15):
            print(json.dumps({family: "packed", **packed(family, distance)}), flush=True)


if __name__ == "__main__":
    main()
