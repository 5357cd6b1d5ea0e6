"""The disk's equations written by hand for heyoka, against this package's `simulate` on heyoka.

No package code is in the peer's half: the equations below are derived on paper, their one pivot is
divided out by hand, and the script first holds their rates against the package's at random states.
Then motions to T = 100, one at a time and a thousand by batches.  The package also runs each launch
again, a little off, to say how far its end is determined (not with check=False); it watches for
lift-off and other ends, audits the energy and names the nearest steady motion.  The peer does not.

First calls count the imports: heyoka's in this process, the package's in a fresh one.  heyoka's
cache on disk is off for both, so that both compile.  Repeats are medians, the two in turns.  Ratios
are the peer's time over the package's: above 1 the package is faster.
"""

from __future__ import annotations

import importlib
import importlib.util
import os
import sys
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from tables import COLD, Seconds, first_call, medians, report, table, timed

import stability as st

K, MU, LAST, COUNT = 0.25, 0.3, 100.0, 1000
STARTS = {
    "viscous": (np.pi / 2 - 0.1, 0.0, 0.0, 1.2, 0.0, 0.0),
    "rough": (1.45, 0.05, 0.1, 1.3),
}
TOLERANCES = (1e-9, 1e-15)
AGREE = 1e-12
NAMES = ("theta", "theta_dot", "phi_dot", "omega3", "slip_x", "slip_y")


def by_hand(hy: Any, law: str) -> list[tuple[Any, Any]]:
    """Newton and Euler for m = R = g = 1, I1 = k, I3 = 2k; par[0] = k, par[1] = mu.

    Frames: 1^ from the centre to the contact point, 2^ horizontal, 3^ the symmetry axis, and
    x^ = cos(theta) 1^ + sin(theta) 3^, y^ = 2^, z^ up.  The centre moves with
    (vx + theta_dot sin(theta)) x^ + (vy - omega3) y^ + theta_dot cos(theta) z^.  The force at the
    contact is fx x^ + fy y^ + n z^ with n = 1 + theta_ddot cos(theta) - theta_dot^2 sin(theta):

        k phi_ddot sin(theta) = 2 k theta_dot (omega3 - phi_dot cos(theta))
        k theta_ddot = k phi_dot sin(theta) (phi_dot cos(theta) - 2 omega3)
                       - fx sin(theta) - n cos(theta)
        2 k omega3_dot = fy

    Viscous: fx = -mu n vx, fy = -mu n vy.  Rough: the centre's acceleration at vx = vy = 0.
    """
    theta, theta_dot, phi_dot, omega3, vx, vy = hy.make_vars(*NAMES)
    k, mu = hy.par[0], hy.par[1]
    sine, cosine = hy.sin(theta), hy.cos(theta)
    turning = k * phi_dot * sine * (phi_dot * cosine - 2.0 * omega3)
    phi_ddot = 2.0 * theta_dot * (omega3 - phi_dot * cosine) / sine
    if law == "rough":
        pull = sine * phi_dot * omega3 + cosine
        theta_ddot = (turning - pull) / (k + 1.0)
        omega3_dot = phi_dot * theta_dot * sine / (2.0 * k + 1.0)
        return [
            (theta, theta_dot),
            (theta_dot, theta_ddot),
            (phi_dot, phi_ddot),
            (omega3, omega3_dot),
        ]
    lever = cosine - mu * vx * sine
    hanging = 1.0 - sine * theta_dot**2
    theta_ddot = (turning - hanging * lever) / (k + cosine * lever)
    drag = mu * (hanging + cosine * theta_ddot)
    omega3_dot = -drag * vy / (2.0 * k)
    vx_dot = -drag * vx + phi_dot * (vy - omega3) - theta_ddot * sine - theta_dot**2 * cosine
    vy_dot = -drag * vy + omega3_dot - phi_dot * (vx + theta_dot * sine)
    return [
        (theta, theta_dot),
        (theta_dot, theta_ddot),
        (phi_dot, phi_ddot),
        (omega3, omega3_dot),
        (vx, vx_dot),
        (vy, vy_dot),
    ]


def verified(hy: Any, count: int = 1000) -> list[Any]:
    """The rates by hand against the package's; no time is measured where they differ."""
    rng = np.random.default_rng(11)
    rows: list[list[Any]] = []
    for law in STARTS:
        equations = by_hand(hy, law)
        size = len(equations)
        states = np.column_stack(
            [rng.uniform(0.2, 2.9, count), rng.uniform(-2, 2, (count, size - 1))]
        )
        numbers = np.column_stack([rng.uniform(0.05, 0.5, count), rng.uniform(0.01, 5, count)])
        system = st.disk_system(law)
        # far from D = 0, where the rates of the viscous disk are without bound
        lever = np.cos(states[:, 0]) - numbers[:, 1] * states[:, -2] * np.sin(states[:, 0])
        kept = (numbers[:, 0] + np.cos(states[:, 0]) * lever > 0.1) | (law == "rough")
        states, numbers = states[kept], numbers[kept]
        hand = hy.cfunc([right for _, right in equations], [left for left, _ in equations])(
            np.ascontiguousarray(states.T), pars=np.ascontiguousarray(numbers.T[: system.p.numel()])
        ).T
        theirs = package_rates(system, states, numbers)
        largest = np.abs(theirs).max(axis=1)
        worst = float((np.abs(hand - theirs).max(axis=1) / np.maximum(1, largest)).max())
        if not worst < AGREE:
            raise RuntimeError(f"{law}: rates by hand differ from the package's by {worst:.1e}")
        rows.append([law, len(states), worst])
    return [table("rates by hand against the package's", ("law", "states", "difference"), rows)]


def package_rates(system: Any, states: Any, numbers: Any) -> Any:
    import casadi as ca

    rates = ca.Function("rates", [system.x, system.p], [system.rhs])
    size = system.p.numel()
    return np.array(
        [rates(x, p[:size]).full().ravel() for x, p in zip(states, numbers, strict=True)]
    )


def ours(
    law: str, starts: Any, tolerance: float, workers: int | None = None, check: bool = True
) -> Any:
    """Final states by the package; a run that ended early is a failure."""
    contact = st.Viscous(MU) if law == "viscous" else st.Rough()
    six = np.zeros((*np.shape(starts)[:-1], 6))
    six[..., : np.shape(starts)[-1]] = starts
    run = st.simulate(
        st.Disk(k=K),
        contact,
        six,
        [LAST],
        method="heyoka",
        tolerance=tolerance,
        workers=workers,
        check=check,
    )
    meanings = run.outcome.attrs["flag_meanings"].split()
    if not set(np.ravel(run.outcome.values)) <= {meanings.index(n) for n in ("moving", "settled")}:
        raise RuntimeError(f"{law}: a run of the package ended early or undetermined")
    final = np.stack([run[n].values[..., -1] for n in NAMES], axis=-1)
    return final[..., : np.shape(starts)[-1]]


def finest(hy: Any, law: str) -> Any:
    """Final state by hand in extended precision."""
    wide = np.longdouble
    pars = [K, MU] if law == "viscous" else [K]
    motion = hy.taylor_adaptive(
        by_hand(hy, law),
        np.array(STARTS[law], dtype=wide),
        pars=np.array(pars, dtype=wide),
        tol=wide(1e-18),
        fp_type=wide,
    )
    reached(motion.propagate_until(wide(LAST))[0], hy)
    return motion.state.astype(float)


def reached(outcome: Any, hy: Any) -> None:
    if outcome != hy.taylor_outcome.time_limit:
        raise RuntimeError(f"heyoka ended early: {outcome}")


def single(hy: Any, law: str, imported: Seconds) -> list[Any]:
    exact, start = finest(hy, law), np.array(STARTS[law])
    errors: list[Any] = []
    cost: list[Any] = []
    for tolerance in TOLERANCES:
        pars = [K, MU] if law == "viscous" else [K]
        motion, built = timed(
            lambda: hy.taylor_adaptive(by_hand(hy, law), start, pars=pars, tol=tolerance)  # noqa: B023
        )

        def theirs(motion: Any = motion) -> Any:
            motion.state[:], motion.time = start, 0.0
            reached(motion.propagate_until(LAST)[0], hy)
            return motion.state.copy()

        def mine(tolerance: float = tolerance, check: bool = True) -> Any:
            return ours(law, start, tolerance, check=check)

        there, first = timed(theirs)
        here = mine()
        gaps = [
            float(np.abs(a - b).max()) for a, b in ((there, exact), (here, exact), (there, here))
        ]
        errors.append([f"{law}, tolerance {tolerance:.0e}", *gaps])
        whole = Seconds(imported + built + first)
        cost.append((f"{tolerance:.0e}: first call", whole, fresh(law, tolerance)))
        cost.append((f"{tolerance:.0e}: of which JIT", built, None))
        cost.append((f"{tolerance:.0e}: repeated", *medians(theirs, mine, 15)))
        once = medians(theirs, lambda: mine(check=False), 15)  # noqa: B023
        cost.append((f"{tolerance:.0e}: repeated, check=False", *once))
    return [errors, [[n, a, b, a / b if b else None] for n, a, b in cost]]


def fresh(law: str, tolerance: float) -> Seconds:
    contact = f"st.Viscous({MU})" if law == "viscous" else "st.Rough()"
    start = [float(v) for v in STARTS[law]] + [0.0] * (6 - len(STARTS[law]))
    return first_call(
        f"st.simulate(st.Disk(k={K}), {contact}, {start}, [{LAST}], method='heyoka', "
        f"tolerance={tolerance})",
        cold=COLD,
    )


def singles(hy: Any, imported: Seconds) -> list[Any]:
    found = {law: single(hy, law, imported) for law in STARTS}
    title = f"one motion to T = {LAST:g}, k = 1/4 (viscous: mu = {MU})"
    rows = [row for errors, _ in found.values() for row in errors]
    columns = ("error of the final state", "heyoka by hand", "package", "difference")
    notes = ("Errors are against the equations by hand in extended precision at 1e-18.",)
    out = [table(title, columns, rows, *notes)]
    for law, (_, rows) in found.items():
        out.append(
            table(f"times, {law}", ("tolerance", "heyoka by hand", "package", "ratio"), rows)
        )
    return out


def batches(hy: Any) -> list[Any]:
    """At the looser tolerance; a finer batch by hand, not timed, says how far off each one is."""
    rng = np.random.default_rng(7)
    starts = np.array(STARTS["viscous"]) + rng.uniform(-0.01, 0.01, (COUNT, 6))
    width, cores = hy.recommended_simd_size(), len(os.sched_getaffinity(0))
    loose, fine = TOLERANCES

    def batch(tolerance: float) -> Any:
        pars = np.repeat([[K], [MU]], width, axis=1)
        zero = np.zeros((6, width))
        return hy.taylor_adaptive_batch(by_hand(hy, "viscous"), zero, tol=tolerance, pars=pars)

    exact = lanes(hy, batch(fine), starts, width, 1)()
    motion, built = timed(lambda: batch(loose))
    rows: list[Any] = [["JIT of the batch", built, None, None]]
    errors: list[Any] = []
    for threads, check in dict.fromkeys([(1, True), (1, False), (cores, False)]):
        theirs = lanes(hy, motion, starts, width, threads)

        def mine(threads: int = threads, check: bool = check) -> Any:
            return ours("viscous", starts, loose, threads, check)

        if not errors:  # threads change no number
            errors += deviations(theirs(), mine(), exact)
        spent = medians(theirs, mine, 5)
        rows.append([f"all, {threads} thread(s), check={check}", *spent, spent[0] / spent[1]])
    title = f"{COUNT} viscous motions to T = {LAST:g} at {loose:.0e}, lanes of {width}"
    columns = ("error of the final states", "heyoka by hand", "package", "difference")
    note = f"Errors are against the batch by hand at {fine:.0e}."
    last = ("quantity", "heyoka by hand", "package", "ratio")
    return [table(title, columns, errors, note), table("times", last, rows)]


def deviations(there: Any, here: Any, exact: Any) -> list[Any]:
    pairs = ((there, exact), (here, exact), (there, here))
    gaps = [np.abs(a - b).max(axis=1) for a, b in pairs]
    return [
        ["largest", *(float(g.max()) for g in gaps)],
        ["median", *(float(np.median(g)) for g in gaps)],
    ]


def lanes(hy: Any, motion: Any, starts: Any, width: int, threads: int) -> Callable[[], Any]:
    """All starts through the batch integrator: a loop, or heyoka's own ensemble over threads."""
    padded = np.vstack([starts, np.repeat(starts[-1:], -len(starts) % width, axis=0)])
    blocks = padded.reshape(-1, width, starts.shape[1]).transpose(0, 2, 1)

    def begin(motion: Any, i: int) -> Any:
        motion.set_time(0.0)
        motion.state[:] = blocks[i]
        return motion

    def finals(done: Sequence[Any]) -> Any:
        return np.vstack([state.T for state in done])[: len(starts)]

    def loop() -> Any:
        done = []
        for i in range(len(blocks)):
            begin(motion, i).propagate_until(LAST)
            for outcome, *_ in motion.propagate_res:
                reached(outcome, hy)
            done.append(motion.state.copy())
        return finals(done)

    def ensemble() -> Any:
        done = hy.ensemble_propagate_until_batch(
            motion, LAST, len(blocks), begin, algorithm="thread", max_workers=threads
        )
        for one in done:
            for outcome, *_ in one[0].propagate_res:
                reached(outcome, hy)
        return finals([one[0].state for one in done])

    return loop if threads == 1 else ensemble


def parts() -> list[tuple[str, Callable[[], Any]]]:
    if importlib.util.find_spec("heyoka") is None:
        return []
    hy, imported = timed(lambda: importlib.import_module("heyoka"))
    hy.llvm_state.set_diskcache_enabled(False)
    return [
        ("rates", lambda: verified(hy)),
        ("one motion", lambda: singles(hy, imported)),
        ("a thousand", lambda: batches(hy)),
    ]


if __name__ == "__main__":
    sys.exit(report(("heyoka", "numpy", "casadi"), parts()))
