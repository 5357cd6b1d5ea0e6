"""Motions near saddles, through ghosts of folds and past delayed bifurcations, in closed form.

Each is a plane motion with its solution at 40 digits, a stiff third state that follows, and a
change of coordinates by whole numbers, so that neither the saddle nor its directions are special.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import casadi as ca
import mpmath
import numpy as np

import stability as st

DIGITS = 40


def pitchfork(a: Any, u: Any, v: Any) -> list[Any]:
    return [a[0] * u - a[1] * u**3, -a[2] * v]


def pitchfork_at(a: Any, u: Any, v: Any, t: Any) -> list[Any]:
    grown = mpmath.exp(a[0] * t)
    return [
        u * grown / mpmath.sqrt(1 + a[1] / a[0] * u**2 * (grown**2 - 1)),
        v * mpmath.exp(-a[2] * t),
    ]


def front(a: Any, u: Any, v: Any) -> list[Any]:
    return [a[0] * u * (1 - u), -a[2] * v]


def front_at(a: Any, u: Any, v: Any, t: Any) -> list[Any]:
    grown = mpmath.exp(a[0] * t)
    return [u * grown / (1 + u * (grown - 1)), v * mpmath.exp(-a[2] * t)]


def ghost(a: Any, u: Any, v: Any) -> list[Any]:
    return [a[1] ** 2 + u**2, -a[2] * v]


def ghost_at(a: Any, u: Any, v: Any, t: Any) -> list[Any]:
    return [a[1] * mpmath.tan(mpmath.atan(u / a[1]) + a[1] * t), v * mpmath.exp(-a[2] * t)]


def delayed(a: Any, u: Any, v: Any) -> list[Any]:
    return [u * v, a[1] + 0 * u]


def delayed_at(a: Any, u: Any, v: Any, t: Any) -> list[Any]:
    return [u * mpmath.exp(v * t + a[1] * t**2 / 2), v + a[1] * t]


KINDS = {
    "pitchfork": (pitchfork, pitchfork_at),
    "front": (front, front_at),
    "ghost": (ghost, ghost_at),
    "delayed": (delayed, delayed_at),
}


@dataclass(frozen=True)
class Motion:
    """A random system with a start, a last time, and its state there."""

    name: str
    system: st.System
    start: list[float]
    last: float
    truth: list[Any]

    def error(self, run: Any) -> float:
        """Distance of a run's end from the truth, each over 1 or the state's own size."""
        found = [float(run[n].values[-1]) for n in self.system.states]
        pairs = zip(found, self.truth, strict=True)
        return max(float(abs(f - t) / max(1, abs(f))) for f, t in pairs)


def motion(rng: np.random.Generator) -> Motion:
    """A random motion in which an error, or a distance from a saddle, grows far."""
    name = str(rng.choice(list(KINDS)))
    rates, at = KINDS[name]
    stiff = float(rng.choice([0.0, 50.0, 2000.0, 1e5]))
    a = [float(rng.uniform(0.3, 2.0)), float(rng.uniform(0.3, 2.0)), float(rng.uniform(0.2, 3.0))]
    u, v = float(10 ** rng.uniform(-14, -2)), float(rng.choice([0.0, 1.0]))
    last = float(rng.uniform(2, 45)) / a[0]
    if name == "ghost":
        a[1] = float(10 ** rng.uniform(-3, -0.5))
        u = -float(rng.uniform(0.2, 2.0))
        last = float(rng.uniform(0.3, 0.97) * (np.pi / 2 + np.arctan(-u / a[1])) / a[1])
    if name == "delayed":
        a[1], v = float(10 ** rng.uniform(-1.5, 0)), -float(rng.uniform(1.0, 3.0))
        last = float(rng.uniform(0.7, 1.0) * (-v + np.sqrt(v**2 - 2 * a[1] * np.log(u))) / a[1])
    count = 3 if stiff else 2
    whole = np.tril(rng.integers(-1, 2, (count, count)), -1) + np.eye(count, dtype=int)
    whole = whole @ (np.triu(rng.integers(-1, 2, (count, count)), 1) + np.eye(count, dtype=int))
    if rng.random() < 0.3:
        whole = np.eye(count, dtype=int)
    inverse = np.rint(np.linalg.inv(whole)).astype(int)
    shift = rng.choice([0.0, 0.0, 1.0, -0.5]) * np.ones(count)
    y = ca.SX.sym("y", count)
    inner = ca.mtimes(ca.DM(inverse), y - ca.DM(shift))
    flow = rates(a, inner[0], inner[1])
    if stiff:
        flow.append(-stiff * (inner[2] - inner[0]) + flow[0])
    states = tuple("xyz"[:count])
    system = st.System(
        name, y, ca.SX.sym("p", 0), ca.mtimes(ca.DM(whole), ca.vertcat(*flow)), states=states
    )
    start = whole @ np.array([u, v, u][:count]) + shift
    with mpmath.workdps(DIGITS):
        exact = [
            mpmath.mpf(float(s)) - mpmath.mpf(float(b)) for s, b in zip(start, shift, strict=True)
        ]
        u0, v0, *z0 = [sum(int(i) * e for i, e in zip(row, exact, strict=True)) for row in inverse]
        numbers = [mpmath.mpf(value) for value in a]
        ends = at(numbers, u0, v0, mpmath.mpf(last))
        ends += [ends[0] + (z - u0) * mpmath.exp(-mpmath.mpf(stiff) * last) for z in z0]
        truth = [
            sum(int(i) * e for i, e in zip(row, ends, strict=True)) + mpmath.mpf(float(b))
            for row, b in zip(whole, shift, strict=True)
        ]
    return Motion(name, system, start.tolist(), last, truth)
