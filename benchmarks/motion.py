"""Speed of motions, side by side in one run: `make bench` (ARGS=--large for 1024 neighbours).

Times of routes are the best of several turns.  The routes alternate, so that a busy machine hits
all alike.
Compilation, once per process, is timed separately.  Raw routes are the libraries themselves on the
same CasADi graph: no events, no energy account, no outcome, no labels.
"""

from __future__ import annotations

import argparse
import math
import os
import time
from collections import Counter
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import casadi as ca
import numpy as np
from timing import least, seconds

import stability as st
from stability.algebra.program import Program
from stability.bodies.newton_euler import STATES
from stability.integrators import taylor
from stability.integrators.flow import Evaluator, flow
from stability.integrators.leg import Leg
from stability.motion.result import BY_CODE

LAUNCH = np.array([math.pi / 2 - 0.1, 0, 0, 1.2, 0, 0])
GRID = np.linspace(0.0, 100.0, 101)


def states(run: Any) -> Any:
    return np.stack([run[n].values for n in STATES], axis=-1)


def raw_heyoka(tolerance: float, width: int = 0) -> Any:
    """Heyoka's own integrator of the six equations, and its time to compile [s]."""
    import heyoka as hy

    system = st.disk_system("viscous")
    program = Program(ca.Function("raw", [system.x, system.p], [system.rhs]))
    symbols = list(hy.make_vars(*system.states))
    rows = program.dense(taylor.heyoka_algebra(), [symbols, [hy.par[0], hy.par[1]]])
    equations = list(zip(symbols, [row[0] for row in rows], strict=True))
    begin = time.perf_counter()
    if width:
        made = hy.taylor_adaptive_batch(
            equations, np.zeros((6, width)), pars=np.zeros((2, width)), tol=tolerance
        )
    else:
        made = hy.taylor_adaptive(equations, np.zeros(6), pars=np.zeros(2), tol=tolerance)
    return made, time.perf_counter() - begin


def lsoda(tolerance: float, mu: float = 0.3) -> Callable[[Any], Any]:
    """SciPy's LSODA through solve_ivp on a CasADi right-hand side."""
    from scipy.integrate import solve_ivp

    which = flow("viscous")
    run = Evaluator(which, np.array([0.25, mu, 1e-6]))

    def call(start: Any) -> Any:
        return (
            solve_ivp(
                run.rates,
                (0, 100),
                which.pack(start),
                "LSODA",
                GRID,
                rtol=tolerance,
                atol=tolerance,
            )
            .y[:6]
            .T
        )

    return call


def reference() -> None:
    """The reference launch against the libraries at equal accuracy."""
    disk, contact = st.Disk(), st.Viscous(0.3)
    exact = states(st.simulate(disk, contact, LAUNCH, GRID, tolerance=1e-16))
    print("reference launch: k = 1/4, mu = 0.3, tilt 0.1, omega3 = 1.2, T = 100, 101 samples")
    if not taylor.available():
        print("  heyoka is not installed")
        return
    for tolerance in (1e-6, 1e-9, 1e-12):
        raw, compiled = raw_heyoka(tolerance)
        kept: dict[str, Any] = {}

        def bare(raw: Any = raw, kept: dict[str, Any] = kept) -> None:
            raw.state[:], raw.pars[:], raw.time = LAUNCH, [0.25, 0.3], 0.0
            kept["raw heyoka"] = raw.propagate_grid(GRID)[5]

        def ours(tolerance: float = tolerance, kept: dict[str, Any] = kept) -> None:
            kept["simulate"] = st.simulate(
                disk, contact, LAUNCH, GRID, tolerance=tolerance, check=False
            )

        def checked(tolerance: float = tolerance) -> None:
            st.simulate(disk, contact, LAUNCH, GRID, tolerance=tolerance)

        which = flow("viscous")
        leg = Leg(which, np.array([0.25, 0.3, 1e-6]), which.pack(LAUNCH), GRID, tolerance, 10**6)

        def route(leg: Leg = leg, kept: dict[str, Any] = kept) -> None:
            kept["our route"] = taylor.integrate(leg).states[:, :6]

        first = seconds(ours)
        routes = {"raw heyoka": bare, "our route": route, "simulate": ours, "checked": checked}
        found = least(routes, 40)
        errors = {
            "raw heyoka": np.abs(kept["raw heyoka"] - exact).max(),
            "our route": np.abs(kept["our route"] - exact).max(),
            "simulate": np.abs(states(kept["simulate"]) - exact).max(),
        }
        errors["checked"] = errors["simulate"]
        for name, took in found.items():
            once = compiled if name == "raw heyoka" else first
            print(
                f"  {tolerance:.0e}  {name:<11} {1e3 * took:7.2f} ms  error "
                f"{errors[name]:.1e}  first call {once:.2f} s"
            )
        raw_time = found["raw heyoka"]
        print(
            f"         guards and energy account: {found['our route'] / raw_time:.2f} of raw; "
            f"with outcome, labels: {found['simulate'] / raw_time:.2f}; "
            f"run thrice for its error: {found['checked'] / raw_time:.2f}"
        )
    run = lsoda(1e-6)
    error = np.abs(run(LAUNCH) - exact).max()
    took = least({"lsoda": lambda: run(LAUNCH)}, 5)["lsoda"]
    print(f"  1e-06  SciPy LSODA {1e3 * took:7.2f} ms  error {error:.1e}")


def batches(count: int = 1000) -> None:
    """Many starts at once, against heyoka's own batch mode and a loop over LSODA."""
    if not taylor.available():
        return
    import copy

    import heyoka as hy

    rng = np.random.default_rng(7)
    starts = LAUNCH + rng.uniform(-0.01, 0.01, (count, 6))
    times = np.linspace(0.0, 100.0, 11)
    width = hy.recommended_simd_size()
    raw, _ = raw_heyoka(1e-9, width)
    cores = len(os.sched_getaffinity(0))
    copies = [copy.deepcopy(raw) for _ in range(cores)]
    grid = np.repeat(times[:, None], width, axis=1)

    def block(ta: Any, first: int) -> Any:
        chunk = starts[first : first + width]
        ta.state[:, : len(chunk)] = chunk.T
        ta.pars[:] = [[0.25] * width, [0.3] * width]
        ta.set_time(0.0)
        return ta.propagate_grid(grid)[1]

    def bare(threads: int) -> None:
        def part(i: int) -> None:
            for first in range(i * width, count, threads * width):
                block(copies[i], first)

        with ThreadPoolExecutor(threads) as pool:
            list(pool.map(part, range(threads)))

    def ours(threads: int, check: bool = False) -> None:
        st.simulate(
            st.Disk(), st.Viscous(0.3), starts, times, tolerance=1e-9, workers=threads, check=check
        )

    ours(1)
    routes: dict[str, Callable[[], Any]] = {}
    for n in sorted({1, cores}):
        routes |= {f"raw {n}": lambda n=n: bare(n), f"ours {n}": lambda n=n: ours(n)}
    routes["checked"] = lambda: ours(cores, check=True)
    found = least(routes, 4)
    run = lsoda(1e-9)
    loop = seconds(lambda: [run(start) for start in starts[:20]]) / 20 * count
    print(f"batch of {count} starts near it, tolerance 1e-9, lanes of {width}")
    for n in sorted({1, cores}):
        a, b = found[f"raw {n}"], found[f"ours {n}"]
        print(
            f"  {n} thread(s): raw heyoka batch {a:.3f} s, simulate {b:.3f} s: throughput "
            f"{a / b:.2f} of it; LSODA loop {loop:.1f} s: {loop / b:.0f} times"
        )
    print(f"  each run thrice for its error: {found['checked']:.3f} s on {cores} threads")


def stiff() -> None:
    """Cost and error over friction.

    The time of an explicit method grows with friction; that of an implicit method stays the same,
    with a larger error.  `auto` takes the cheaper method for the same error.
    """
    print("stiff launch: k = 1/4, tilt 0.1, omega3 = 1.2, T = 100, 101 samples: ms (error)")
    methods = ["heyoka"] * taylor.available() + ["cvodes", "lsoda", "auto"]
    for tolerance in (1e-6, 1e-9):
        print(
            f"  tolerance {tolerance:.0e}\n      mu  "
            + "".join(f"{m:>18}" for m in methods)
            + "   auto / lower"
        )
        for mu in (0.3, 3.0, 30.0, 100.0, 300.0, 3000.0, 30000.0):
            kept: dict[str, Any] = {}

            def ask(method: str, mu: float, tolerance: float, kept: dict[str, Any]) -> None:
                kept[method] = st.simulate(
                    st.Disk(),
                    st.Viscous(mu),
                    LAUNCH,
                    GRID,
                    method=method,
                    tolerance=tolerance,
                    max_steps=10**8,
                    max_seconds=1e4,
                    check=False,
                )

            fine = "heyoka" if taylor.available() and mu <= 3000 else "cvodes"
            ask(fine, mu, 1e-14, kept)
            exact = states(kept.pop(fine))

            routes = {
                m: lambda m=m, mu=mu, tolerance=tolerance, kept=kept: ask(m, mu, tolerance, kept)
                for m in methods
            }
            for run in routes.values():
                run()
            found = least(routes, 2 if mu > 1000 else 5)
            cells = "".join(
                f"{1e3 * found[m]:10.1f} ({np.abs(states(kept[m]) - exact).max():.0e})".rjust(18)
                for m in methods
            )
            lower = min(found[m] for m in methods if m != "auto")
            print(
                f"  {mu:>7g} {cells}   {found['auto'] / lower:.2f} ({kept['auto'].attrs['method']})"
            )


def neighbours(count: int) -> None:
    """Launches near the reference launch, some with lift-off: all end in bounded time."""
    rng = np.random.default_rng(20161)
    starts = LAUNCH + rng.uniform(-0.1, 0.1, (count, 6))
    begin = time.perf_counter()
    run = st.simulate(st.Disk(), st.Viscous(0.3), starts, np.linspace(0, 100, 101))
    took = time.perf_counter() - begin
    words = Counter(BY_CODE[int(o)].word for o in run.outcome.values)
    print(
        f"{count} neighbours within 0.1: {dict(words)}, {took:.2f} s in all, each run thrice, "
        f"worst audit {float(run.energy_error.max()):.1e}"
    )
    slowest = {}
    for method in ("lsoda", "cvodes"):

        def alone(start: Any, method: str = method) -> None:
            st.simulate(st.Disk(), st.Viscous(0.3), start, GRID, method=method, check=False)

        slowest[method] = max(seconds(lambda s=s: alone(s)) for s in starts[:128])
    print(
        "  slowest single launch of 128: "
        + ", ".join(f"{m} {1e3 * s:.0f} ms" for m, s in slowest.items())
    )


def audits() -> None:
    """Energy errors over long times of viscous, rough and smooth disks."""
    for method in ["heyoka"] * taylor.available() + ["dop853"]:
        run = st.simulate(st.Disk(), st.Viscous(0.3), LAUNCH, 100.0, method=method, tolerance=1e-16)
        line = f"audit over T = 100 by {method}: viscous {float(run.energy_error):.1e}"
        for contact in (st.Rough(), st.Smooth()):
            long = st.simulate(
                st.Disk(),
                contact,
                [1.3, 0.1, 0.4, 1.1, 0, 0],
                [1000.0],
                method=method,
                tolerance=1e-16,
            )
            line += f"; {contact.name} over T = 1000 {float(long.energy_error):.1e}"
        print(line)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--large", action="store_true", help="1024 neighbours instead of 128")
    options = parser.parse_args()
    if taylor.available():
        import heyoka

        heyoka.llvm_state.set_diskcache_enabled(False)  # a first call must compile
    reference()
    batches()
    stiff()
    neighbours(1024 if options.large else 128)
    audits()


if __name__ == "__main__":
    main()
