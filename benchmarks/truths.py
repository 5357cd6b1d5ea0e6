"""The true motions of 25 hard scenes, by two independent high-precision integrations.

Route A: Newton and Euler in the inertial frame (axis, angular momentum, contact velocity) by Radau
IIA collocation of 30 stages with numbers of 200 bits, without code of the package.  Route B: the
package's graph in its angles, by heyoka's Taylor series with numbers of 160 bits.  Digits on which
both routes agree are those of the model.  Coulomb: the tests' scenes next to the package.

    OMP_NUM_THREADS=1 python benchmarks/truths.py --only gentle \
        --out stability/compare/motion/reference_motions.json

One scene takes seconds to a minute, all scenes half an hour on one core; several threads make the
small matrices slower.  For a new scene add an entry to `SCENES`, then run `--only` with its name.
"""

from __future__ import annotations

import argparse
import json
import math
import time
from functools import lru_cache
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import casadi as ca
import heyoka as hy
import numpy as np
from flint import arb, arb_mat, ctx
from numpy.polynomial.chebyshev import chebder, chebroots, chebval
from scipy.special import roots_jacobi

import stability as st
from stability.algebra.number_types import balls, heyoka_algebra
from stability.algebra.program import Program
from stability.bodies.model import FLAT, LIFT_OFF
from stability.bodies.newton_euler import STATES
from stability.integrators.flow import flow

Scene = tuple[str, float, "float | None", tuple[float, ...], float]
UPRIGHT = 1.5707963267948966  # the double nearest pi/2, which is not upright
GRAZE = 1.2749966795259895  # the spin at which the normal force dips to about zero near t = 16.56


def rolled(spin: float, tilt: float = 0.1, mu: float = 0.3, last: float = 40.0) -> Scene:
    return "viscous", 0.25, mu, (UPRIGHT - tilt, 0.0, 0.0, spin, 0.0, 0.0), last


LEANING = (1.3, 0.1, 0.4, 1.1, 0.0, 0.0)
NEAR = (1.2, 0.0, 1e-3, 0.0, 0.0, 0.0)
SCENES: dict[str, Scene] = {
    "gentle": ("viscous", 0.25, 0.3, (1.4, 0.0, 0.1, 1.2, 0.0, 0.0), 20.0),
    "near-threshold": rolled(1.4142, 1e-3, last=200.0),
    "stiff-300": ("viscous", 0.25, 300.0, (1.3, 0.1, 0.4, 1.1, 0.002, -0.002), 20.0),
    "stiff-10000": ("viscous", 0.25, 1e4, LEANING, 10.0),
    "stiff-100000": ("viscous", 0.25, 1e5, LEANING, 2.0),
    "rough-long": ("rough", 0.25, None, LEANING, 1000.0),
    "near-flat": ("rough", 0.5, None, NEAR, 6.0),
    "near-flat-viscous": ("viscous", 0.5, 0.3, NEAR, 4.0),
    "falls-flat": ("viscous", 0.5, 0.3, (1.2, 0.0, 0.0, 0.0, 0.0, 0.0), 10.0),
    "lift-off": rolled(1.28),
    **{
        f"graze-{side}-{step}": rolled(GRAZE + sign * float(step))
        for step in ("1e-3", "1e-6", "1e-9", "1e-12")
        for side, sign in (("plus", 1), ("minus", -1))
    },
    "graze-plus-ulp": rolled(1.2749966795259897),
    "graze-minus-ulp": rolled(GRAZE),
    "slow-drift": rolled(1.5, 0.05, mu=1.0, last=400.0),
    "slower-drift": rolled(1.45, 0.02, mu=1.0, last=1000.0),
    "double-upright": rolled(0.3, 0.0, last=60.0),
    "double-upright-rough": ("rough", 0.25, None, (UPRIGHT, 0.0, 0.0, 0.3, 0.0, 0.0), 60.0),
    "spin-down": ("viscous", 0.25, 0.3, (1.56, 0.0, 2.05, 0.0, 0.0, 0.0), 400.0),
}
COULOMB = [
    *("slides_then_sticks", "many_transitions_through_upright", "planar_sticks_slips_reverses"),
    *("starts_stuck_then_slips", "lifts_off_sliding"),
]
BITS, STAGES, TAIL = 200, 30, 1e-31  # route A; TAIL: last Chebyshev coefficients of a step
PRECISION, TOLERANCE = 160, "1e-36"  # route B
SAMPLES, FLAT_ANGLE, MOVING = 20, 1e-6, "moving"
AGREE = 1e-12  # ends further apart than this leave the outcome undetermined
PAST = 1.0  # how long a grazing motion is continued past lift-off, to the bottom of its dip
LEAST = 1e-40  # written in place of a difference of zero


# Route A: the inertial equations, for balls and for arrays alike
def cross(u: Any, v: Any) -> Any:
    return np.array([u[i - 2] * v[i - 1] - u[i - 1] * v[i - 2] for i in range(3)])


def dot(u: Any, v: Any) -> Any:
    return u[0] * v[0] + u[1] * v[1] + u[2] * v[2]


def axis(y: Any) -> tuple[Any, Any, Any]:
    """The axis, its horizontal part and the unit vector from the centre to the contact."""
    n = y[:3] / dot(y, y) ** 0.5
    sine = (n[0] * n[0] + n[1] * n[1]) ** 0.5
    return n, sine, np.array([n[2] * n[0] / sine, n[2] * n[1] / sine, -sine])


def inertial(k: Any, mu: Any, y: Any) -> tuple[list[Any], Any]:
    """Rates of (axis, angular momentum, contact velocity), and the normal force; no mu is rough."""
    # the velocity of the contact obeys v' = free + F + I^-1(a x F) x a under the force F at a
    n, sine, a = axis(y)

    def response(torque: Any) -> Any:
        return (torque - n * (dot(torque, n) / 2)) / k

    omega = response(y[3:6])
    turn = cross(omega, n)
    # a = (cos n - z)/sin, so a' = (cos' n + cos n')/sin - a sin'/sin with sin' = -cos cos'/sin
    move = (n * turn[2] + turn * n[2]) / sine + a * (n[2] * turn[2] / (sine * sine))
    free = cross(response(cross(y[3:6], omega)), a) + cross(omega, move)
    free[2] = free[2] - 1
    if mu is None:
        side = cross(n, a)
        force = side * (dot(free, side) / (2 * k + 1)) + n * (dot(free, n) / (k + 1)) - free
        return [*turn, *cross(a, force)], force[2]
    unit = np.array([-mu * y[6], -mu * y[7], 1 + 0 * y[6]])
    torque = cross(a, unit)
    answer = unit + cross(response(torque), a)
    normal = -free[2] / answer[2]
    return [*turn, *(torque * normal), *(free + answer * normal)[:2]], normal


def from_six(six: tuple[float, ...], k: float, rough: bool) -> Any:
    """The inertial start; the doubles count as exact, and their sines have all digits."""
    theta, theta_dot, phi_dot, omega3, *slip = (arb(value) for value in six)
    cosine, sine, zero = theta.cos(), theta.sin(), arb(0)
    n, a, y = np.array([[sine, zero, cosine], [cosine, zero, -sine], [zero, arb(1), zero]])
    momentum = (n * (2 * omega3) + y * theta_dot - a * (phi_dot * sine)) * k
    return np.array([*n, *momentum, *([] if rough else slip)])


def to_six(y: Any, k: float) -> list[arb]:
    n, sine, a = axis(y)
    x_hat, y_hat = np.array([[n[0], n[1], arb(0)], [-n[1], n[0], arb(0)]]) / sine
    omega3, omega = dot(y[3:6], n) / (2 * k), y[3:6] / k  # omega is right except along n
    rates, slip = [dot(omega, y_hat), -dot(omega, a) / sine, omega3], [*y[6:8], *[arb(0)] * 3]
    return [arb.atan2(sine, n[2]), *rates, dot(slip, x_hat), dot(slip, y_hat)]


# Route A: collocation
middle = np.frompyfunc(arb.mid, 1, 1)


@lru_cache(maxsize=1)
def radau() -> tuple[Any, Any]:
    """Integration matrix of Radau IIA on [0, 1]; matrix from values to Chebyshev coefficients."""
    s, nodes = STAGES, []
    ctx.prec = 4 * BITS  # the construction loses many bits
    for u in map(arb, np.sort(roots_jacobi(s - 1, 1, 0)[0]).tolist()):
        for _ in range(10):  # Newton on P_s - P_(s-1)
            p = [u.legendre_p(m) for m in (s - 2, s - 1, s)]
            slopes = [m * (p[i] - u * p[i + 1]) / (1 - u * u) for i, m in ((0, s - 1), (1, s))]
            u = (u - (p[2] - p[1]) / (slopes[1] - slopes[0])).mid()
        nodes.append((u + 1) / 2)
    nodes.append(arb(1))
    integrals = arb_mat([[c**m / m for m in range(1, s + 1)] for c in nodes])
    matrix = integrals * arb_mat([[c**m for m in range(s)] for c in nodes]).inv()
    values = [[(2 * c - 1).chebyshev_t(m) for m in range(s + 1)] for c in (arb(0), *nodes)]
    ctx.prec = BITS
    return middle(np.array(matrix.tolist())), middle(np.array(arb_mat(values).inv().tolist()))


class Step(NamedTuple):
    """Chebyshev coefficients of a step: a column for each state, normal force and squared sine."""

    begin: arb
    span: arb
    table: Any

    def time(self, u: arb) -> arb:
        return (self.begin + self.span * (u + 1) / 2).mid()


def make_step(k: float, mu: float | None, begin: arb, y: Any, h: float) -> Step | None:
    """One step by Newton's method: slopes in doubles, residual in all digits; None if it fails."""
    exact, n, many, tiny = radau()[0], len(y), STAGES * len(y), 1e-30
    moves, size, before, inverse = np.full((STAGES, n), arb(0)), math.inf, math.inf, None
    while not (size < 1e-45 or (size < 1e-40 and size > before / 10)):
        if inverse is None or size > 1e-9:
            points = (y + moves).astype(float)[:, None, :] + 1j * tiny * np.eye(n)
            slopes = np.stack(inertial(k, mu, np.moveaxis(points, -1, 0))[0], axis=1).imag / tiny
            blocks = np.einsum("ij,jab->iajb", h * exact.astype(float), slopes)
            inverse = np.linalg.inv(np.eye(many) - blocks.reshape(many, many))
        rates = np.array([inertial(k, mu, row)[0] for row in y + moves])
        change = inverse @ (h * (exact @ rates) - moves).astype(float).ravel()
        before, size = size, np.abs(change).max()
        if not size < min(1e3, 10 * before):
            return None
        moves = middle(moves + change.reshape(STAGES, n).astype(object))
    rows = [y, *(y + moves)]
    seen = [[*r, inertial(k, mu, r)[1], r[0] * r[0] + r[1] * r[1]] for r in rows]
    return Step(begin, arb(h), middle(radau()[1] @ np.array(seen)))


def place(c: Any, low: arb, high: arb) -> arb:
    """Root of a polynomial between two places at which its signs differ."""
    positive = chebval(low, c) > 0
    for _ in range(BITS - 10):
        u = ((low + high) / 2).mid()
        low, high = (u, high) if (chebval(u, c) > 0) == positive else (low, u)
    return low


def turns(c: Any) -> list[arb]:
    """Extrema of a polynomial on [-1, 1]: a grazing shows in no other place."""
    slope, reach = chebder(c.astype(float)), arb(1e-6)
    found = chebroots(slope) if np.abs(slope).max() > 0 else np.empty(0)
    near = [arb(u.real) for u in found if abs(u.imag) < 1e-9 and abs(u.real) < 1]
    return [place(chebder(c), u - reach, u + reach) for u in near]


def first_below(step: Step, column: int, level: arb) -> arb | None:
    """Time at which a column first falls below a level, or None."""
    c = step.table[:, column].copy()
    c[0] = c[0] - level
    if np.abs(c[1:].astype(float)).sum() < float(c[0]):
        return None
    spots = sorted([*turns(c), *map(arb, np.linspace(-1, 1, 21).tolist())], key=float)
    found = (step.time(place(c, *s)) for s in pairwise(spots) if chebval(s[1], c) < 0)
    return next(found, None)


def six_at(steps: list[Step], t: float, k: float) -> list[arb]:
    step = steps[sum(s.begin <= t for s in steps) - 1]
    return to_six(chebval(2 * (t - step.begin) / step.span - 1, step.table[:, :-2]), k)


def inertial_motion(scene: Scene, past: float) -> tuple[str, arb, list[Any], list[Step]]:
    """Route A: outcome, its time, dips (value, time) of a run followed past lift-off, steps."""
    law, k, mu, start, limit = scene
    y, begin, h = from_six(start, k, law == "rough"), arb(0), 0.1 / (1 + (mu or 0))
    outcome, end, dips, steps = MOVING, arb(limit), [], []
    watched = ((LIFT_OFF, -2, arb(0)), (FLAT, -1, arb(FLAT_ANGLE).sin() ** 2))
    while float(begin) < limit:
        step = make_step(k, mu, begin, y, h)
        if step is None:
            h /= 2
            continue
        states = np.abs(step.table[:, :-2].astype(float))
        tail = (states[-2:] / np.maximum(1, states[0])).max() + 1e-99
        h *= min(2.5, max(0.4, 0.95 * (TAIL / tail) ** (1 / STAGES)))
        if tail > 4 * TAIL:
            continue
        steps.append(step)
        c = step.table[:, -2]
        lows = [u for u in turns(c) if chebval(u, chebder(c, 2)) > 0] if past else []
        dips += [(chebval(u, c), step.time(u)) for u in lows]
        for name, column, level in watched if outcome == MOVING else ():
            met = first_below(step, column, level)
            if met is not None and met < end:
                outcome, end = name, met
                limit = float(end) + (past if name == LIFT_OFF else 0.0)
        begin, y = (begin + step.span).mid(), middle(step.table[:, :-2].sum(axis=0))
    return outcome, end, dips, steps


# Route B: the package's graph
def reals(values: Any) -> Any:
    texts = [v.str(60, radius=False) if isinstance(v, arb) else v for v in values]
    return np.array([hy.real(v, PRECISION) for v in texts], dtype=hy.real)


def balled(values: Any) -> list[arb]:
    return [arb(str(v)) for v in values]


def launched(scene: Scene, stops: bool) -> Any:
    """An integrator of the package's graph at its start, with or without events that end it."""
    law, k, mu, start, _ = scene
    found, symbols = flow(law), list(hy.make_vars(*flow(law).names))
    program = Program(ca.Function("f", [found.x, found.p], [found.rhs, *found.guards.values()]))
    inputs = [symbols, [hy.par[i] for i in range(found.p.numel())]]
    rates = program.dense(heyoka_algebra(), inputs)
    guards = program.run(heyoka_algebra(), inputs)[1:] if stops else []
    falls = {"direction": hy.event_direction.negative, "fp_type": hy.real}
    numbers = [k, *([] if mu is None else [mu]), *([arb(FLAT_ANGLE).sin()] if stops else [])]
    return hy.taylor_adaptive(
        [(s, r[0]) for s, r in zip(symbols, rates, strict=True)],
        reals([*start[: len(symbols) - 1], 0.0]),  # the work is the last state
        pars=reals(numbers),
        t_events=[hy.t_event(g[0], **falls) for g in guards],
        fp_type=hy.real,
        prec=PRECISION,
        tol=reals([arb(TOLERANCE)])[0],
        compact_mode=True,
    )


def graph_motion(scene: Scene, times: list[float]) -> tuple[str, arb, list[list[arb]]]:
    """Route B: outcome, its time, and the six states at the given times."""
    ta = launched(scene, True)
    result = ta.propagate_grid(reals([*(t for t in times if t < scene[4]), scene[4]]))
    names = {-1 - i: name for i, name in enumerate(flow(scene[0]).guards)}  # events from -1 down
    names[int(hy.taylor_outcome.time_limit)] = MOVING
    states = [[*balled(row[:-1]), arb(0), arb(0)][:6] for row in result[5]]
    return names.get(int(result[0]), "failed"), balled([ta.time])[0], states


def graph_press(scene: Scene, t: arb) -> arb:
    """Route B: the normal force at a time, with or without contact."""
    ta, found = launched(scene, False), flow(scene[0])
    ta.propagate_until(reals([t])[0])
    normal = found.system.observables["normal_force"]
    program = Program(ca.Function("press", [found.x, found.p], [normal]))
    return program.run(balls(), [balled(ta.state), [*balled(ta.pars), arb(0)]])[0][0]


# The two together
def magnitude(value: float) -> int:
    return math.floor(math.log10(max(value, LEAST)))


def written(value: arb, error: float) -> str:
    """Text of the digits that agree, at most 25; the error is over max(1, |value|)."""
    size = abs(float(value))
    count = magnitude(size) - magnitude(error * max(1.0, size))
    return value.str(min(25, count), radius=False) if size and count > 0 else "0"


def apart(one: Any, two: Any) -> float:
    return max(LEAST, abs(float(one - two)) / max(1.0, abs(float(one))))


def truth(name: str) -> dict[str, Any]:
    """One scene by both routes."""
    law, k, mu, start, last = scene = SCENES[name]
    began, grazes = time.perf_counter(), name.startswith("graze")
    radau()  # sets the precision of all balls
    kind, stop, dips, steps = inertial_motion(scene, PAST if grazes else 0.0)
    until = last if kind == MOVING else math.floor(float(stop) * 1e4) / 1e4
    times = [until * i / SAMPLES for i in range(SAMPLES)] + [until]
    one, half = [six_at(steps, t, k) for t in times], time.perf_counter()
    outcome, end, two = graph_motion(scene, times)
    pairs = [(x, y) for a, b in zip(one, two, strict=False) for x, y in zip(a, b, strict=True)]
    error, gap = max(apart(x, y) for x, y in pairs), apart(stop, end)
    agreed = outcome == kind and gap <= AGREE and len(two) >= len(one)
    entry: dict[str, Any] = {
        "name": name,
        "law": law,
        "k": k,
        "mu": mu,
        "start": start,
        "times": times,
        "states": [[written(v, error) for v in row] for row in one],
        "outcome": outcome if agreed else "undetermined",
        "end_time": written(stop, gap),
        "error": error,
        "end_time_error": gap,
        "digits": -magnitude(error) - 1,
        "events": [],
    }
    if grazes:
        least, when = min(dips, key=lambda dip: float(dip[0]))
        # at the bottom, an error of the time changes the force by its square only
        entry["least_normal_force"] = written(least, apart(least, graph_press(scene, when)))
        entry["least_normal_force_time"] = when.str(20, radius=False)
    spent = f"{half - began:4.0f} s {time.perf_counter() - half:4.0f} s"
    ends = f"{kind:8s} {outcome:8s} {entry['end_time']:27s} {gap:.0e} {error:.0e} {spent}"
    print(f"{name:20s} {ends} {entry.get('least_normal_force', '')}", flush=True)
    return entry


def dry(name: str) -> dict[str, Any]:
    """A Coulomb scene of the tests, and its distance from the package's motion."""
    path = Path(__file__).parents[1] / "tests" / "data" / "coulomb.json"
    known = {s["name"]: s for s in json.loads(path.read_text())["scenes"]}[name]
    k, mu, start, times, states, events, error = list(known.values())[1:]
    disk, grid = st.Disk(k=k), [0.0, *times, times[-1] + 1]
    run = st.simulate(disk, st.Coulomb(mu), start, grid, method="heyoka", tolerance=1e-14)
    own = np.stack([run[n].values for n in STATES], axis=-1)[1 : len(times) + 1]
    far = max(apart(x, y) for x, y in zip(np.ravel(states), own.ravel(), strict=True))
    seen = np.append(run["event_time"].values, run["end_time"].values)
    far = max(far, *(float(np.abs(seen - e["time"]).min()) for e in events))
    print(f"{name:34s} {error:.0e}, the package is {far:.0e} away", flush=True)
    lifts = events[-1]["kind"] == LIFT_OFF
    kind, last = (LIFT_OFF, events[-1]["time"]) if lifts else (MOVING, times[-1])
    return {
        "name": name,
        "law": "coulomb",
        "k": k,
        "mu": mu,
        "start": start,
        "times": times,
        "states": [[*map(repr, row)] for row in states],
        "outcome": kind,
        "end_time": repr(last),
        "error": error,
        "digits": -magnitude(error) - 1,
        "events": events,
        "package_difference": far,
    }


SOURCE = (
    f"Newton-Euler in the inertial frame by Radau IIA of {STAGES} stages in {BITS} bits next to "
    f"the package's graph by Taylor series in {PRECISION} bits (tolerance {TOLERANCE}); error: "
    "their largest difference over max(1, |state|).  Coulomb: an independent inertial formulation "
    "in doubles, error: the spread of its three settings; package_difference: the package's "
    "distance."
)


def main() -> None:
    parser = argparse.ArgumentParser(description="True motions of hard scenes.")
    parser.add_argument("--only", action="append", help="a scene by name; may be repeated")
    parser.add_argument("--out", type=Path, help="where to write; scenes already there are kept")
    asked = parser.parse_args()
    old = json.loads(asked.out.read_text())["scenes"] if asked.out and asked.out.exists() else []
    held = {s["name"]: s for s in old}
    for name in asked.only or [*SCENES, *COULOMB]:
        held[name] = truth(name) if name in SCENES else dry(name)
        if asked.out:
            scenes = [held[n] for n in [*SCENES, *COULOMB] if n in held]
            table = {"source": SOURCE, "script": "benchmarks/truths.py", "scenes": scenes}
            asked.out.write_text(json.dumps(table, indent=1) + "\n")


if __name__ == "__main__":
    main()
