"""Maps of families of one's own against CasADi's mapped Jacobian with LAPACK, in one run.

The bicycle has its 25 parameters as symbols, so CasADi builds its Jacobian as a user would.  The
other route maps CasADi's function over all cells and takes one batched `numpy.linalg.eigvals`: no
bound, no proof.  The routes take turns, since machines are shared and noisy; the least processor
time of each counts.

Usage: python benchmarks/maps.py --own

Source of the bicycle: J. P. Meijaard, J. M. Papadopoulos, A. Ruina & A. L. Schwab, Proc. R. Soc. A
463 (2007) 1955-1982, appendix A and table 1.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import casadi as ca
import numpy as np

import stability as st
from stability.base.axis import Axis
from stability.maps.cells import Cells
from stability.maps.general.slice_verdicts import slice_verdicts
from stability.maps.general.slices import _cached
from stability.spectra.axes import swept

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

BICYCLE = {
    "w": 1.02,
    "trail": 0.08,
    "tilt": np.pi / 10,
    "g": 9.81,
    "rR": 0.3,
    "mR": 2,
    "IRxx": 0.0603,
    "IRyy": 0.12,
    "xB": 0.3,
    "zB": -0.9,
    "mB": 85,
    "IBxx": 9.2,
    "IBxz": 2.4,
    "IBzz": 2.8,
    "xH": 0.9,
    "zH": -0.7,
    "mH": 4,
    "IHxx": 0.05892,
    "IHxz": -0.00756,
    "IHzz": 0.00708,
    "rF": 0.35,
    "mF": 3,
    "IFxx": 0.1405,
    "IFyy": 0.28,
}


def matrices(s: Any) -> tuple[Any, Any, Any, Any]:
    """M, C₁, K₀, K₂ of the linear bicycle."""
    sn, cs = ca.sin(s["tilt"]), ca.cos(s["tilt"])
    total = s["mR"] + s["mB"] + s["mH"] + s["mF"]
    x = (s["xB"] * s["mB"] + s["xH"] * s["mH"] + s["w"] * s["mF"]) / total
    z = (-s["rR"] * s["mR"] + s["zB"] * s["mB"] + s["zH"] * s["mH"] - s["rF"] * s["mF"]) / total
    ixx = s["IRxx"] + s["IBxx"] + s["IHxx"] + s["IFxx"] + s["mR"] * s["rR"] ** 2
    ixx += s["mB"] * s["zB"] ** 2 + s["mH"] * s["zH"] ** 2 + s["mF"] * s["rF"] ** 2
    ixz = s["IBxz"] + s["IHxz"] - s["mB"] * s["xB"] * s["zB"] - s["mH"] * s["xH"] * s["zH"]
    ixz += s["mF"] * s["w"] * s["rF"]
    izz = s["IRxx"] + s["IBzz"] + s["IHzz"] + s["IFxx"] + s["mB"] * s["xB"] ** 2
    izz += s["mH"] * s["xH"] ** 2 + s["mF"] * s["w"] ** 2
    front = s["mH"] + s["mF"]
    xa = (s["xH"] * s["mH"] + s["w"] * s["mF"]) / front
    za = (s["zH"] * s["mH"] - s["rF"] * s["mF"]) / front
    axx = s["IHxx"] + s["IFxx"] + s["mH"] * (s["zH"] - za) ** 2 + s["mF"] * (s["rF"] + za) ** 2
    axz = s["IHxz"] - s["mH"] * (s["xH"] - xa) * (s["zH"] - za)
    axz += s["mF"] * (s["w"] - xa) * (s["rF"] + za)
    azz = s["IHzz"] + s["IFxx"] + s["mH"] * (s["xH"] - xa) ** 2 + s["mF"] * (s["w"] - xa) ** 2
    u = (xa - s["w"] - s["trail"]) * cs - za * sn
    all_ = front * u**2 + axx * sn**2 + 2 * axz * sn * cs + azz * cs**2
    alx = -front * u * za + axx * sn + axz * cs
    alz = front * u * xa + axz * sn + azz * cs
    mu = s["trail"] / s["w"] * cs
    sf = s["IFyy"] / s["rF"]
    st_ = s["IRyy"] / s["rR"] + sf
    sa = front * u + mu * total * x
    cross = alx + mu * ixz
    mass = _two(ixx, cross, cross, all_ + 2 * mu * alz + mu**2 * izz)
    damping = _two(
        0,
        mu * st_ + sf * cs + ixz / s["w"] * cs - mu * total * z,
        -(mu * st_ + sf * cs),
        alz / s["w"] * cs + mu * (sa + izz / s["w"] * cs),
    )
    still = _two(total * z, -sa, -sa, -sa * sn)
    moving = _two(0, (st_ - total * z) / s["w"] * cs, 0, (sa + sf * sn) / s["w"] * cs)
    return mass, damping, still, moving


def _two(a: Any, b: Any, c: Any, d: Any) -> Any:
    return ca.vertcat(ca.horzcat(a, b), ca.horzcat(c, d))


def bicycle() -> Any:
    """The upright bicycle at a speed."""
    s = {n: ca.SX.sym(n) for n in ("v", *BICYCLE)}
    mass, damping, still, moving = matrices(s)
    x, v = ca.SX.sym("x", 4), s["v"]
    forces = ca.mtimes(v * damping, x[2:]) + ca.mtimes(s["g"] * still + v**2 * moving, x[:2])
    system = st.System.from_mass_matrix(
        "bicycle",
        x,
        ca.vertcat(*s.values()),
        mass=mass,
        forcing=-forces,
        unknowns=("d_lean_rate", "d_steer_rate"),
        rates={"lean": x[2], "steer": x[3]},
        states=("lean", "steer", "lean_rate", "steer_rate"),
        parameters=tuple(s),
    )
    return st.Family(
        system, "upright", at=("v",), held=dict.fromkeys(system.states, 0.0), typical=dict(BICYCLE)
    )


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


def least(runs: dict[str, Callable[[], Any]]) -> dict[str, float]:
    """Least processor time of each, of all threads, taken in turns."""
    out = dict.fromkeys(runs, np.inf)
    for run in runs.values():
        run()
    for _ in range(REPEATS):
        for name, run in runs.items():
            start = time.process_time()
            run()
            out[name] = min(out[name], time.process_time() - start)
    return out


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
    found = least(runs)
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
    for name, low, high in (("g", 1, 20), ("trail", 0.01, 0.2), ("mB", 20, 150)):
        fixed = {n: float(v) for n, v in BICYCLE.items() if n != name}
        rows.append(compare(bicycle(), speed, (name, low, high, SIDE), fixed))
    rows.append(compare(magnet(), ("a", -1, 2, SIDE // 2), ("b", -1, 1.4, SIDE // 2), {}))
    return rows
