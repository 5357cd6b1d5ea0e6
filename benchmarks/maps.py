"""Maps against the obvious route, side by side in one run: cost and benefit.

The obvious route takes the same Jacobian as a SymPy expression, lambdifies it once (not timed), and
takes the largest real part of `numpy.linalg.eigvals` point by point.  This route gives no error
bound, no boundary, and no reliable verdict near a boundary.  A second, faster obvious route
evaluates the whole grid at once.

`--calls` times whole calls of every kind of subject, with their curves, against CasADi's Jacobian
mapped over all cells and one batched `eigvals`; that route gets steady motions in closed form for
nothing, and solves for others by CasADi's Newton method.

Usage: python benchmarks/maps.py [--large | --own | --calls]
(own: families of one's own alone)
"""

from __future__ import annotations

import json
import platform
import resource
import statistics
import subprocess
import sys
from collections.abc import Callable
from typing import Any

import casadi as ca
import numpy as np
import sympy
from timing import seconds

import stability as st
from stability.algebra.number_types import casadi_algebra, sympy_algebra

REPEATS = 5
NX, NY = 400, 300
AXES = {"rolling": (0.2, 3.0), "spinning": (0.5, 5.0), "tumbling": (0.05, 1.55)}
MU = (0.05, 3.0)


def timed(run: Callable[[], Any], repeats: int = REPEATS) -> list[float]:
    return [seconds(run) for _ in range(repeats)]


def obvious(family: str) -> tuple[Callable[..., Any], Callable[..., Any]]:
    """The linearisation as two NumPy functions of (at, k, mu): its matrix, and its entries."""
    at, k, mu = sympy.symbols("at k mu", positive=True)
    resolved = st.disk_family(family, "viscous")
    unknown = {"tumbling": 1 / sympy.sqrt(k * sympy.sin(at))}.get(family, sympy.Integer(0))
    rows = resolved.graph.matrix.dense(sympy_algebra(), [[at], [unknown], [k, mu]])
    matrix = sympy.Matrix(rows)
    names = (at, k, mu)
    return sympy.lambdify(names, matrix, "numpy"), sympy.lambdify(names, list(matrix), "numpy")


def point_by_point(matrix: Callable[..., Any], xs: Any, ys: Any) -> list[float]:
    return [
        float(np.linalg.eigvals(np.array(matrix(x, 0.25, y), dtype=float)).real.max())
        for y in ys
        for x in xs
    ]


def at_once(entries: Callable[..., Any], xs: Any, ys: Any) -> Any:
    x, y = np.meshgrid(xs, ys)
    values = entries(x, 0.25, y)
    full = np.empty((*x.shape, len(values)))
    for i, value in enumerate(values):
        full[..., i] = value
    size = round(len(values) ** 0.5)
    return np.linalg.eigvals(full.reshape(*x.shape, size, size)).real.max(axis=-1)


def compare(family: str) -> dict[str, Any]:
    low, high = AXES[family]
    axes = {"x": ("at", low, high, NX), "y": ("mu", *MU, NY)}
    first = timed(lambda: st.stability_map(family, **axes), 1)
    ours = timed(lambda: st.stability_map(family, **axes))
    without = timed(lambda: st.stability_map(family, **axes, boundaries=False))
    matrix, entries = obvious(family)
    xs, ys = np.linspace(low, high, NX), np.linspace(*MU, NY)
    some = timed(lambda: point_by_point(matrix, xs[::10], ys[::10]), 3)
    scale = NX * NY / (len(xs[::10]) * len(ys[::10]))
    grid = timed(lambda: at_once(entries, xs, ys), 3)
    naive = at_once(entries, xs, ys) > 0
    found = st.stability_map(family, **axes)
    decided = found.verdict.values != 0
    wrong = int((naive != (found.verdict.values == 2))[decided].sum())
    med = statistics.median
    return {
        "family": family,
        "cells": NX * NY,
        "map_s": ours,
        "map_first_call_s": first[0],
        "map_without_boundaries_s": without,
        "obvious_point_by_point_s": [t * scale for t in some],
        "obvious_at_once_s": grid,
        "ratio_to_point_by_point": med(some) * scale / med(ours),
        "ratio_to_at_once": med(grid) / med(ours),
        "obvious_wrong_signs": wrong,
        "boundary_points": found.sizes["boundary_point"],
        "largest_relative_bracket": float(
            (
                found.boundary_error
                / np.where(found.boundary_axis == 0, found.boundary_at, found.boundary_mu)
            ).max()
        ),
    }


def import_time() -> list[float]:
    command = [sys.executable, "-c", "import stability"]
    bare = [sys.executable, "-c", "pass"]
    return [
        a - b
        for a, b in zip(
            timed(lambda: subprocess.run(command, check=True)),
            timed(lambda: subprocess.run(bare, check=True)),
            strict=True,
        )
    ]


def large() -> dict[str, float]:
    axes: dict[str, Any] = {"x": ("at", 0.5, 5.0, 4000), "y": ("mu", *MU, 3000)}
    return {
        "cells": 12e6,
        "seconds": seconds(lambda: st.stability_map("spinning", **axes)),
        "peak_GiB": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20,
    }


def whole_calls() -> None:
    """A line for each map: seconds of the call with its curves, and the other route's over it."""
    from own_maps import SYSTEMS, magnet

    from stability.tables.benchmarks.bicycle import BENCHMARK, bicycle

    mu = ("mu", *MU)
    torus, egg, spheroid = st.Torus(0.2), st.Egg(0.2), st.Spheroid(0.6)
    fixed = {n: float(v) for n, v in BENCHMARK.items() if n != "g"}
    asked: list[tuple[str, Any, Any, Any, dict[str, Any]]] = [
        (f"disk, {name}", name, ("at", *ends), mu, {}) for name, ends in AXES.items()
    ]
    asked += [
        (
            "disk, spinning, rough",
            "spinning",
            ("at", 0.5, 5.0),
            ("k", 0.1, 0.5),
            {"contact": "rough"},
        ),
        (
            "disk, rolling, smooth",
            "rolling",
            ("at", 0.2, 3.0),
            ("k", 0.1, 0.5),
            {"contact": "smooth"},
        ),
        ("torus, tumbling", "tumbling", ("at", 0.05, 1.55), mu, {"body": torus}),
        ("egg, rolling", "rolling", ("at", 0.2, 3.0), mu, {"body": egg}),
        ("egg, tumbling", "tumbling", ("at", 1.0, 1.7), mu, {"body": egg}),
        ("spheroid, tumbling", "tumbling", ("at", 1.6, 3.0), mu, {"body": spheroid}),
        ("bicycle", bicycle(), ("v", 0.1, 10), ("g", 1, 20), fixed),
        ("magnets", magnet(), ("a", -1, 2), ("b", -1, 1.4), {}),
    ]
    asked += [(name, *some, {}) for name, some in SYSTEMS.items()]
    for name, family, x, y, more in asked:
        for nx, ny in ((NX, NY), (1250, 800)):
            axes = {"x": (*x, nx), "y": (*y, ny)}
            other = eigvals_at_once(family, axes, more)
            ours = timed(lambda: st.stability_map(family, **axes, **more), 3)  # noqa: B023
            best, theirs = min(ours), min(timed(other, 2 if nx == NX else 1))
            print(f"{name:24s} {nx} x {ny}: {best:.3f} s, {theirs / best:.1f} times", flush=True)


def eigvals_at_once(family: Any, axes: dict[str, Any], more: dict[str, Any]) -> Callable[[], Any]:
    """CasADi's Jacobian mapped over all cells, and one batched `eigvals`."""
    from stability.base.axis import Axis
    from stability.spectra.axes import swept

    known = {n: more.get(n) for n in ("body", "contact")}
    fixed = {n: v for n, v in more.items() if n not in known}
    lines = {n: Axis.of(v, n) for n, v in axes.items()}
    problem, (across, up) = swept(family, lines, parameters=fixed, **known)
    x, y = (v.ravel() for v in np.meshgrid(across.values, up.values))
    values = dict(problem.values) | {across.name: x, up.name: y}
    a, q, *_ = problem.arrays(values)
    u = problem.family.solve(a, q)
    a, u, q = (np.where(np.isfinite(v), v, 0.0).T for v in (a, u, q))
    inputs = [ca.SX.sym(n, len(v)) for n, v in zip("auq", (a, u, q), strict=True)]
    rows = problem.family.graph.matrix.dense(casadi_algebra(), list(map(ca.vertsplit, inputs)))
    entries = ca.densify(ca.vertcat(*[ca.horzcat(*row) for row in rows]))
    mapped = ca.Function("J", inputs, [entries]).map(len(x))
    size = entries.shape[0]

    searched = problem.family.unknown and problem.family.formulas is None
    guess = np.tile(list(problem.family.unknown.values()), (len(x), 1)).T
    finder = problem.family.graph.finder.map(len(x)) if searched else None

    def run() -> Any:
        member = u if finder is None else finder(guess, np.vstack([a, q]))
        found = np.nan_to_num(np.asarray(mapped(a, member, q)))
        return np.linalg.eigvals(found.reshape(size, len(x), size).transpose(1, 0, 2))

    return run


def own() -> None:
    from own_maps import report

    for row in report():
        print(json.dumps(row), flush=True)


def main() -> None:
    if "--own" in sys.argv or "--calls" in sys.argv:
        (own if "--own" in sys.argv else whole_calls)()
        return
    report: dict[str, Any] = {
        "machine": f"{platform.machine()}, python {platform.python_version()}",
        "import_s": import_time(),
    }
    if "--large" in sys.argv:
        report["large_map"] = large()
    report["maps"] = [compare(family) for family in AXES]
    print(json.dumps(report, indent=2))
    for row in report["maps"]:
        print(
            f"{row['family']:9s} {NX} x {NY} map {statistics.median(row['map_s']):.2f} s; "
            f"{row['ratio_to_point_by_point']:.1f} times faster than point by point, "
            f"{row['ratio_to_at_once']:.2f} times all at once (no bounds, no boundaries), "
            f"which gets {row['obvious_wrong_signs']} signs wrong"
        )


if __name__ == "__main__":
    main()
