"""Maps of families of one's own against CasADi's mapped Jacobian with LAPACK, in one run.

The bicycle of `table benchmarks` has its 25 parameters as symbols, so CasADi builds its Jacobian as
a user would.  The other route maps CasADi's function over all cells and takes one batched
`numpy.linalg.eigvals`: no bound, no proof.  The routes take turns, since machines are shared and
noisy; the least processor time of each counts.

Usage: python benchmarks/maps.py --own
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import casadi as ca
import numpy as np
from timing import least

import stability as st
from stability.base.axis import Axis
from stability.maps.cells import Cells
from stability.maps.slices import _cached
from stability.maps.verdicts import slice_verdicts
from stability.spectra.axes import swept
from stability.tables.benchmarks.bicycle import BENCHMARK, bicycle

SIDE = 1000
"""Cells along each axis."""
EVERY = 5
"""Both routes are compared on every fifth cell along each axis."""
SOME = 20
"""The other route is timed on every twentieth: runs of like length meet a busy machine alike."""
COARSE = 3
"""Growth rates are timed on axes with so many times fewer cells."""
REPEATS = 7
CLEAR = 1e-9
"""Share of the largest modulus beyond which LAPACK's sign is taken as clear."""


def magnet() -> Any:
    """Two coupled pendula with exponential forces: no polynomial exists."""
    x, p = ca.SX.sym("x", 4), ca.SX.sym("p", 2)
    pull = ca.exp(-p[0]) * ca.sin(x[0] + p[1]) - ca.exp(-p[0]) * ca.sin(p[1])
    rhs = ca.vertcat(
        x[2],
        x[3],
        -pull - 0.3 * ca.tanh(p[0] * x[2]) + 0.2 * x[1],
        -ca.sinh(x[1]) * ca.cos(p[1]) - 0.1 * p[1] * x[3] - 0.4 * x[0],
    )
    system = st.System("magnets", x, p, rhs, states=("q1", "q2", "v1", "v2"), parameters=("a", "b"))
    return st.Family(system, "rest", at=("a",), held=dict.fromkeys(system.states, 0.0))


def described(
    name: str, states: str, parameters: str, rates: str, at: str, unknown: dict[str, float]
) -> Any:
    """A family of equilibria from the text of its rates; what is not unknown rests at 0."""
    names = states.split(), parameters.split()
    x, p = (ca.SX.sym(n, len(some)) for n, some in zip("xp", names, strict=True))
    symbols = dict(zip(sum(names, []), ca.vertsplit(x) + ca.vertsplit(p), strict=True))
    rhs = ca.vertcat(*eval(rates, {"tanh": ca.tanh, "cos": ca.cos, "sin": ca.sin}, symbols))
    system = st.System(name, x, p, rhs, states=tuple(names[0]), parameters=tuple(names[1]))
    held = {} if unknown else dict.fromkeys(names[0], 0.0)
    return st.Family(system, name, at=(at,), held=held, unknown=unknown, equations=tuple(unknown))


SYSTEMS: dict[str, tuple[Any, Any, Any]] = {
    "Lorenz": (
        described(
            "Lorenz",
            "x y z",
            "r s",
            "(s * (y - x), x * (r - z) - y, x * y - 8 / 3 * z)",
            "r",
            {"x": 8.0, "y": 8.0, "z": 27.0},
        ),
        ("r", 2, 60),
        ("s", 4, 20),
    ),
    "column under a follower load": (
        described(
            "column",
            "a b u v",
            "load c",
            "(u, v, (load - 3) * a / 2 + (2 - load) * b / 2 - (a - b) / 2 - c * (2 * u - 1.5 * v),"
            " 2 * (a - b) - (load - 3) * a / 2 - (2 - load) * b / 2 + c * (2.5 * u - 2 * v))",
            "load",
            {},
        ),
        ("load", 0.1, 5),
        ("c", 0.01, 1),
    ),
    "rotor with inner damping": (
        described(
            "rotor",
            "x y u v",
            "speed c",
            "(u, v, -(0.3 + c) * u - x - c * speed * y, -(0.3 + c) * v - 1.2 * y + c * speed * x)",
            "speed",
            {},
        ),
        ("speed", 0.1, 6),
        ("c", 0.01, 1),
    ),
    "towed wheel": (
        described(
            "wheel",
            "angle rate slip",
            "v k",
            "(rate, -k * angle - 0.1 * rate - tanh(slip), v * sin(angle) + 0.5 * rate * cos(angle)"
            " - v * slip)",
            "v",
            {},
        ),
        ("v", 0.1, 8),
        ("k", 0.1, 5),
    ),
}
"""Families of users' systems with two axes each."""


def other(
    family: Any, axes: tuple[Axis, Axis], fixed: dict[str, float], every: int
) -> Callable[[], Any]:
    """CasADi's Jacobian mapped over the cells, and one batched `eigvals`."""
    system = family.system
    size = len(system.states)
    x, y = (g.values[::every] for g in axes)
    grid = dict(zip((g.name for g in axes), np.meshgrid(x, y), strict=True))
    count = len(x) * len(y)
    numbers = np.array(
        [
            np.broadcast_to(grid.get(n, fixed.get(n)), (len(y), len(x))).ravel()
            for n in system.parameters
        ]
    )
    jacobian = ca.Function("J", [system.x, system.p], [ca.densify(system.jacobian)]).map(count)
    state = ca.DM.zeros(size, count)

    def run() -> Any:
        found = np.asarray(jacobian(state, numbers))
        return np.linalg.eigvals(found.reshape(size, count, size).transpose(1, 0, 2))

    run.count = count  # type: ignore[attr-defined]
    return run


def compare(family: Any, x: Any, y: Any, fixed: dict[str, float]) -> dict[str, Any]:
    """Times per cell, ratios, and whether both routes agree where LAPACK's sign is clear."""
    axes = Axis.of(x, "x"), Axis.of(y, "y")
    slow = other(family, axes, fixed, SOME)
    question = swept(family, {a.name: a for a in axes}, parameters=fixed)[0]
    xs, ys = axes[0].values, axes[1].values
    start = time.perf_counter()
    judge = slice_verdicts(question, axes)
    derived = time.perf_counter() - start
    coarse = tuple(Axis(g.name, g.low, g.high, g.count // COARSE, g.log) for g in axes)
    cells = Cells(question, coarse, False)  # type: ignore[arg-type]
    runs: dict[str, Callable[[], Any]] = {"eigvals": slow, "map": lambda: cells.fill(1, None)}
    if judge is not None:
        runs["verdicts"] = lambda: judge(xs, ys)

        def whole() -> None:
            _cached.cache_clear()
            slice_verdicts(question, axes)(xs, ys)  # type: ignore[misc]

        runs["verdicts_and_derivation"] = whole
    for run in runs.values():
        run()
    found = least(runs, REPEATS, time.process_time)
    total = axes[0].count * axes[1].count
    counts = {"eigvals": slow.count, "map": cells.codes.size}  # type: ignore[attr-defined]
    each = {n: t / counts.get(n, total) for n, t in found.items()}
    values = other(family, axes, fixed, EVERY)()
    lead = values.real.max(axis=1)
    clear = np.abs(lead) > CLEAR * np.abs(values).max(axis=1)
    if judge is not None:
        codes = judge(xs, ys)[0][::EVERY, ::EVERY].ravel()
    else:  # the same cells, since no verdicts come without growth rates
        fine = Cells(question, tuple(map(_every, axes)), False)  # type: ignore[arg-type]
        fine.fill(1, None)
        codes = fine.codes.ravel()
    wrong = int(((codes == 2) != (lead > 0))[clear & (codes != 0)].sum())
    return {
        "family": f"{family.name}, {axes[0].name} x {axes[1].name}",
        "route": "graph" if cells.bands is None else "polynomial",
        "derivation_s": round(derived, 3),
        "ns_per_cell": {n: round(1e9 * t, 1) for n, t in each.items()},
        "times_faster": {n: round(each["eigvals"] / t, 1) for n, t in each.items()},
        "undecided": int((cells.codes == 0).sum()),
        "disagree_where_clear": f"{wrong} of {int(clear.sum())}",
        "clear": f"{int(clear.sum())} of {len(lead)}",
    }


def _every(axis: Axis) -> Axis:
    values = axis.values[::EVERY]
    return Axis(axis.name, float(values[0]), float(values[-1]), len(values), axis.log)


def report() -> list[dict[str, Any]]:
    """Every comparison of this file."""
    speed, rows = ("v", 0.1, 10, SIDE), []
    for name, low, high in (("g", 1, 20), ("c", 0.01, 0.2), ("mB", 20, 150)):
        fixed = {n: float(v) for n, v in BENCHMARK.items() if n != name}
        rows.append(compare(bicycle(), speed, (name, low, high, SIDE), fixed))
    rows.append(compare(magnet(), ("a", -1, 2, SIDE // 2), ("b", -1, 1.4, SIDE // 2), {}))
    return rows
