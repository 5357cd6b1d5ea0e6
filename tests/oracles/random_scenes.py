"""Random scenes, the answer to each, and the truth by `simulate` at a fine tolerance."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass, field
from typing import Any

import numpy as np

import stability as st

STATES = ("theta", "theta_dot", "phi_dot", "omega3", "slip_x", "slip_y")
QUANTITIES = ("final", "path", "outcome", "settling_time", "lift_off_time", "largest_tilt")
SAMPLES = 201


@dataclass
class Held:
    """An answer held against the truth."""

    number: int
    scene: st.Scene
    answer: st.Answer
    quantity: str
    true: float = math.nan
    """True error of the answer, over 1 or the size of the value."""
    known: float = 0.0
    """Error of the truth itself."""
    full: float = math.nan
    """Time of `simulate` for the same accuracy [s]."""
    note: str = ""
    more: dict[str, Any] = field(default_factory=dict)

    @property
    def share(self) -> float:
        """The true error over the tolerance."""
        return self.true / self.scene.tolerance

    @property
    def claimed(self) -> bool:
        """Whether the answer says that it is within the tolerance."""
        chosen = self.answer.chosen
        return chosen is not None and chosen.estimate <= 1

    @property
    def missed(self) -> bool:
        """Whether the answer claims the tolerance and is outside it, beyond the truth's error."""
        return self.claimed and not self.true <= self.scene.tolerance + self.known


def random_scene(number: int, seed: int = 0) -> tuple[st.Scene, str]:
    """A scene by its number, so that any order of work gives the same scenes."""
    rng = np.random.default_rng([seed, number])
    k = float(rng.choice([0.25, 0.5, rng.uniform(0.25, 0.5)]))
    mu = 10 ** rng.uniform(-3, 5)
    kind = rng.choice(["viscous", "viscous", "viscous", "linear", "rough", "smooth", "coulomb"])
    horizon = 10 ** rng.uniform(0, 3)
    tolerance = 10 ** rng.uniform(-9, -2)
    if kind == "coulomb":
        horizon, tolerance, mu = min(horizon, 30.0), max(tolerance, 1e-6), 10 ** rng.uniform(-1, 0)
    law = {
        "viscous": st.Viscous,
        "linear": st.LinearViscous,
        "coulomb": st.Coulomb,
    }.get(str(kind), lambda _: st.Rough() if kind == "rough" else st.Smooth())(mu)
    disk = st.Disk(k=k)
    if rng.random() < 0.5:  # near a steady motion
        family = str(rng.choice(["rolling", "spinning", "tumbling"]))
        at = rng.uniform(0.4, 1.5) if family == "tumbling" else rng.uniform(0.2, 4.0)
        start = st.launch(family, at=at, tilt=10 ** rng.uniform(-7, -0.7), disk=disk)
        start[1:4] += rng.normal(size=3) * 10 ** rng.uniform(-8, -1)
    else:
        start = np.array([rng.uniform(0.3, np.pi - 0.3), *rng.normal(size=2), 0.0, 0.0, 0.0])
        start[3] = rng.normal() * 2
    if law.slips and rng.random() < 0.5:
        start[4:] = rng.normal(size=2) * 10 ** rng.uniform(-4, 0) / max(1.0, mu)
    if not law.slips and law.holds:
        start[4:] = 0.0
    quantity = str(rng.choice(QUANTITIES))
    return st.Scene(disk, law, start, horizon, tolerance, (quantity,)), quantity


def truth(scene: st.Scene, times: Any, method: str = "auto") -> Any:
    """The motion of the full model at a fine tolerance, and the error that it states."""
    return st.simulate(
        scene.disk,
        scene.contact,
        scene.start,
        times,
        tolerance=max(1e-15, 1e-5 * scene.tolerance),
        max_seconds=15.0,
        max_steps=10**8,
        method=method,
    )


def _second_opinion(held: Held, times: Any, theirs: Any) -> None:
    """The error of the truth between its samples, where it states that of its end only.

    A passage near flat magnifies errors for a while; another integrator shows by how much.
    """
    other = truth(held.scene, times, "radau")
    if other.attrs["outcome"] == "moving":
        states = np.stack([other[n].values for n in STATES], -1)[: len(theirs)]
        apart = np.abs(states - theirs[: len(states)]) / np.maximum(1, np.abs(theirs))
        held.known = max(held.known, float(apart.max()))


def hold(number: int, seed: int = 0) -> Held | None:
    """One scene, answered and held against the truth; None where no disk can start so."""
    try:
        scene, quantity = random_scene(number, seed)
        answer = scene.answer()
    except st.StabilityError:
        return None
    if answer.model == "none":
        return Held(number, scene, answer, quantity, note="no contact")
    began = time.perf_counter()
    held = Held(number, scene, answer, quantity)
    last = min(answer.until, scene.horizon)
    _compare(held, quantity, last)
    held.more["seconds of truth"] = time.perf_counter() - began
    return held


def _compare(held: Held, quantity: str, last: float) -> None:
    scene, answer = held.scene, held.answer
    if not held.claimed:
        held.true, held.note = math.nan, "no rung"
        return
    path = answer.path
    times = path.time.values if quantity == "path" else np.linspace(0, scene.horizon, SAMPLES)
    if quantity == "path":
        times = times[times < scene.horizon]
        times = np.append(times, scene.horizon)
    run = truth(scene, times)
    held.known = float(run.final_error) if "final_error" in run else math.inf
    mine = answer.value
    if quantity == "final":
        theirs = np.array([float(run[n].values[-1]) for n in STATES])
        mine = np.array([mine[n] for n in STATES])
        held.true = float(np.max(np.abs(mine - theirs) / np.maximum(1, np.abs(theirs))))
    elif quantity == "path":
        theirs = np.stack([run[n].values for n in STATES], -1)
        ours = np.stack([path[n].values for n in STATES], -1)
        _, one, other = np.intersect1d(path.time.values, run.time.values, return_indices=True)
        pairs = [(ours[one], theirs[other])]
        if run.attrs["outcome"] not in ("moving", "settled"):
            pairs.append((ours[-1:], theirs[-1:]))
            fast = st.disk_system(scene.contact.name).rates if scene.contact.slips else None
            if fast is not None and not scene.contact.sticks:
                p = [scene.disk.k, next(iter(scene.contact.given.values()))]
                held.known += float(run.end_time_error) * np.abs(fast(theirs[-1], p)).max()
        held.true = max(
            float((np.abs(a - b) / np.maximum(1, np.abs(b))).max(initial=0.0)) for a, b in pairs
        )
        if held.missed:
            _second_opinion(held, times, theirs)
    elif quantity == "outcome":
        held.true, held.known = (0.0, 0.0) if mine == run.attrs["outcome"] else (math.inf, 0.0)
        held.note = f"{mine}, and {run.attrs['outcome']}: {run.evidence.values}"
    elif quantity == "lift_off_time":
        lifted = run.attrs["outcome"] == "lift-off"
        theirs = float(run.end_time) if lifted else None
        held.known = float(run.end_time_error) if lifted else 0.0
        _number(held, mine, theirs)
    elif quantity == "settling_time":
        settled = run.attrs["outcome"] == "settled"
        theirs = float(run.settled_time) if settled else None
        # `simulate` gives the first sample after it
        held.known = 1.01 * scene.horizon / (SAMPLES - 1) if settled and mine else 0.0
        _number(held, mine, theirs)
    elif quantity == "largest_tilt":
        theirs = _largest(scene, last)
        _number(held, mine, float(theirs))


def _largest(scene: st.Scene, last: float) -> float:
    """The largest tilt: samples, and finer ones where the tilt turns from rising to falling."""
    run = truth(scene, np.linspace(0, last, 50 * SAMPLES))
    tilt, sign = np.abs(np.pi / 2 - run.theta.values), -np.sign(np.pi / 2 - run.theta.values)
    rate, times = sign * run.theta_dot.values, run.time.values
    turns = np.flatnonzero((rate[:-1] > 0) & (rate[1:] < 0))
    a, b, h = rate[turns], rate[turns + 1], np.diff(times)[turns]
    high = tilt[turns] + a * (tilt[turns + 1] - tilt[turns] - b * h) / (a - b)
    best = float(tilt.max())
    for k in np.argsort(high)[::-1][:60]:
        if high[k] <= best:
            break
        low, top = times[turns[k]], times[turns[k] + 1]
        for _ in range(3):  # each time a hundred times finer
            finer = np.linspace(low, top, 200)
            asked = finer[finer > 0]
            asked = asked if asked[-1] >= last else np.append(asked, last)
            values = np.abs(np.pi / 2 - truth(scene, asked).theta.values)
            i = int(np.argmax(values))
            best = max(best, float(values[i]))
            low, top = asked[max(i - 1, 0)], asked[min(i + 1, len(asked) - 1)]
    return best


def _number(held: Held, mine: Any, theirs: Any) -> None:
    if mine is None or theirs is None:
        held.true = 0.0 if mine is theirs else math.inf
        held.note = f"{mine}, and {theirs}"
        return
    held.true = abs(mine - theirs) / max(1.0, abs(theirs))
