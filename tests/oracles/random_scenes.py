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
        "viscous": st.Viscous, "linear": st.LinearViscous, "coulomb": st.Coulomb,
    }.get(str(kind), lambda _: st.Rough() if kind == "rough" else st.Smooth())(mu)  # fmt: skip
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


def truth(scene: st.Scene, times: Any) -> Any:
    """The motion of the full model at a fine tolerance, and the error that it states."""
    return st.simulate(
        scene.disk, scene.contact, scene.start, times, tolerance=max(1e-15, 1e-5 * scene.tolerance),
        max_seconds=15.0, max_steps=10**8,
    )  # fmt: skip


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
        both = min(len(theirs), len(ours))
        gap = np.abs(ours[:both] - theirs[:both]) / np.maximum(1, np.abs(theirs[:both]))
        held.true = float(gap.max())
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
        dense = np.linspace(0, last, 20 * SAMPLES)
        tilt = np.abs(np.pi / 2 - truth(scene, dense).theta.values)
        theirs = float(tilt.max())
        walled = np.concatenate([[-1.0], tilt, [-1.0]])
        peaks = np.flatnonzero((tilt >= walled[:-2]) & (tilt >= walled[2:]))
        peaks = peaks[np.argsort(tilt[peaks])[-40:]]  # all that may be the largest
        around = [(dense[max(i - 1, 0)], dense[min(i + 1, len(dense) - 1)]) for i in peaks]
        finer = np.unique([t for low, high in around for t in np.linspace(low, high, 60)])
        if finer.size:
            finer = finer if finer[-1] >= last else np.append(finer, last)
            more = np.abs(np.pi / 2 - truth(scene, finer[finer > 0]).theta.values)
            theirs = max(theirs, float(more.max()))
        held.known += 1e-7 * (last / 20) ** 2 / 100
        _number(held, mine, float(theirs))


def _number(held: Held, mine: Any, theirs: Any) -> None:
    if mine is None or theirs is None:
        held.true = 0.0 if mine is theirs else math.inf
        held.note = f"{mine}, and {theirs}"
        return
    held.true = abs(mine - theirs) / max(1.0, abs(theirs))
