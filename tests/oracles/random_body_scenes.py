"""Random scenes of bodies, and the truth by `simulate` at a tolerance 100 times finer."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

import stability as st

SIX = ("theta", "theta_dot", "phi_dot", "omega3", "slip_x", "slip_y")
QUANTITIES = ("final", "final", "path", "outcome", "lift_off_time", "largest_tilt")
SAMPLES = 401


def random_body(rng: np.random.Generator) -> st.Body:
    """A torus, a spheroid or a thick disk."""
    kind = rng.integers(3)
    if kind == 0:
        return st.Torus(float(rng.choice([0.05, 0.2, 0.5])))
    if kind == 1:
        return st.Spheroid(float(rng.choice([0.5, 0.8, 1.3])))
    return st.ThickDisk(float(rng.choice([0.1, 0.4])))


def random_scene(number: int, seed: int) -> st.Scene:
    """A scene by its number; a third near a steady motion."""
    rng = np.random.default_rng([seed, number])
    body = random_body(rng)
    law: Any = [
        st.Viscous(10 ** rng.uniform(-2, 2)),
        st.LinearViscous(10 ** rng.uniform(-2, 1)),
        st.Rough(),
        st.Smooth(),
    ][rng.choice(4, p=[0.5, 0.2, 0.2, 0.1])]
    horizon, tolerance = 10 ** rng.uniform(0, 2), 10 ** rng.uniform(-9, -2)
    low, high = body.between
    start = np.array([rng.uniform(low + 0.3, high - 0.1), *rng.normal(size=2), 0.0, 0.0, 0.0])
    start[3] = rng.normal() * 1.5
    if rng.random() < 0.6:
        names = {
            "spheroid": ["vertical", "rolling", "spinning"],
            "torus": ["rolling", "spinning", "tumbling"],
            "thick disk": ["rolling", "tumbling"],
        }[body.name]
        family = str(rng.choice(names))
        at = rng.uniform(0.4, 1.2) if family == "tumbling" else rng.uniform(0.3, 4.0)
        start = st.launch(family, at=at, tilt=10 ** rng.uniform(-6, -1), body=body)
        start[1:4] += rng.normal(size=3) * 10 ** rng.uniform(-8, -2)
    if law.slips and rng.random() < 0.5:
        start[4:] = rng.normal(size=2) * 10 ** rng.uniform(-4, -1)
    quantity = str(rng.choice(QUANTITIES))
    return st.Scene(body, law, start, horizon, tolerance, (quantity,))


def stiff_scene(number: int, seed: int) -> st.Scene:
    """A scene of large friction, away from steady motions, of one of five bodies."""
    rng = np.random.default_rng([seed, number, 1])
    kind = rng.integers(5)
    if kind == 0:
        body = st.Torus(float(rng.choice([0.05, 0.2, 0.5])))
    elif kind == 1:
        body = st.Spheroid(float(rng.choice([0.5, 0.8, 1.3])))
    elif kind == 2:
        body = st.ThickDisk(float(rng.choice([0.1, 0.4])))
    elif kind == 3:
        body = st.Egg(float(rng.choice([0.1, 0.2])))
    else:
        body = st.EccentricSphere(float(rng.choice([0.1, 0.3])), axial=0.4, transverse=0.4)
    mu = 10 ** rng.uniform(1.3, 5)
    law: Any = st.Viscous(mu) if rng.random() < 0.6 else st.LinearViscous(mu)
    low, high = body.between
    start = np.zeros(6)
    start[0] = rng.uniform(low + 0.3, high - 0.3)
    start[1:4] = rng.normal(size=3) * [0.5, 0.7, 1.5]
    if rng.random() < 0.5:
        start[4:] = rng.normal(size=2) * 10 ** rng.uniform(-4, -1)
    horizon, tolerance = 10 ** rng.uniform(0, 1.7), 10 ** rng.uniform(-9, -2)
    return st.Scene(body, law, start, horizon, tolerance, (str(rng.choice(QUANTITIES)),))


def columns(run: Any) -> np.ndarray:
    """The states of a scene from a motion of `simulate`: those of the angles, or along fixed axes.

    ω = θ̇ ŷ + (ω₃ - φ̇ cos θ) sin θ x̂ + ω_Z Ẑ, with x̂ and ŷ from the axis.
    """
    theta, theta_dot, phi_dot, omega3, *slip = (run[n].values for n in SIX)
    if "axis_x" not in run:
        return np.stack([theta, theta_dot, phi_dot, omega3, *slip], -1)
    e = np.stack([run[n].values for n in ("axis_x", "axis_y", "axis_z")], -1)
    s, c = np.hypot(e[:, 0], e[:, 1]), e[:, 2]
    x, y = e[:, 0] / s, e[:, 1] / s
    over = (omega3 - phi_dot * c) * s
    turn = [over * x - theta_dot * y, over * y + theta_dot * x, phi_dot * s**2 + omega3 * c]
    slide = [slip[0] * x - slip[1] * y, slip[0] * y + slip[1] * x]
    return np.stack([*e.T, *turn, *slide], -1)


def truth(scene: st.Scene, times: Any) -> Any:
    """The motion of the full model at a tolerance 100 times finer, or finer still."""
    return st.simulate(
        scene.disk,
        scene.contact,
        scene.start,
        times,
        tolerance=max(1e-15, 1e-4 * scene.tolerance),
        max_seconds=20.0,
    )


def far(mine: np.ndarray, theirs: np.ndarray) -> float:
    """The largest difference, over 1 or the size of the value."""
    return float((np.abs(mine - theirs) / np.maximum(1, np.abs(theirs))).max(initial=0.0))


def missed(scene: st.Scene, answer: st.Answer) -> str:
    """What is wrong with an answer that claims its tolerance; empty if nothing is."""
    [name], value, allowed = scene.quantities, answer.value, scene.tolerance
    times = answer.path.time.values if name == "path" else np.linspace(0, scene.horizon, SAMPLES)
    times = np.union1d(times[times < scene.horizon], scene.horizon)
    run = truth(scene, times)
    ended = run.attrs["outcome"] not in ("moving", "settled")
    known = float(run.final_error) if "final_error" in run else math.inf
    if name == "outcome":
        return "" if value == run.attrs["outcome"] else f"{value}, {run.attrs['outcome']}"
    if name == "lift_off_time":
        theirs = float(run.end_time) if run.attrs["outcome"] == "lift-off" else None
        if value is None or theirs is None:
            return "" if value is theirs else f"{value}, {theirs}"
        off = abs(value - theirs) / max(1.0, theirs)
    elif name == "largest_tilt":
        tilt = np.abs(np.pi / 2 - run.theta.values)
        # samples may miss the largest by the square of their distance
        gap = (np.abs(np.diff(run.theta_dot.values)).max(initial=0.0) * np.diff(times).max()) / 2
        if not tilt.max() - allowed - known <= value <= tilt.max() + gap + allowed + known:
            return f"{value}, {tilt.max()} within {gap:.2g}"
        return ""
    else:
        theirs = columns(run)
        mine = np.stack([answer.path[n].values for n in answer.path.data_vars if n != "error"], -1)
        _, one, other = np.intersect1d(
            answer.path.time.values, run.time.values, return_indices=True
        )
        pairs = [(mine[one], theirs[other])] if name == "path" else []
        off = max(far(a, b) for a, b in [*pairs, (mine[-1:], theirs[-1:])])
        if ended:  # the states of an end are known as well as its time
            rate = np.abs(np.diff(theirs[-3:], axis=0)).max() / np.diff(run.time.values[-3:]).min()
            known += float(run.end_time_error) * float(rate)
    return "" if off <= allowed + known else f"off by {off:.3g}, truth within {known:.2g}"
