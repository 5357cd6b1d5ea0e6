"""The drift of rolling bodies, against the full model, `stability.drift` and its closed form."""

from __future__ import annotations

import os
from typing import Any

import casadi as ca
import numpy as np
import pytest
from disk_as_body import disk_as_body
from random_body_scenes import columns, far

import stability as st
from stability.motion.round_starts import gather_round as gather
from stability.scene.rungs.drifting import SlowManifold, _manifold, drifting
from stability.scene.rungs.track import LaunchProblem, Refused, Track, relative

STATES = ("theta", "theta_dot", "phi_dot", "omega3", "slip_x", "slip_y")


def _problem(k: float, law, start, last: float) -> LaunchProblem:
    times = np.linspace(0.0, last, 9)
    return LaunchProblem(gather(st.Disk(k=k), law, start, times), 1e-4, times)


def _error(k: float, law, spin: float, tilt: float, last: float) -> tuple[float, float]:
    """True and stated error of the drift."""
    start = st.launch("rolling", at=spin, tilt=tilt)
    problem = _problem(k, law, start, last)
    track = drifting(problem)
    assert isinstance(track, Track)
    run = st.simulate(st.Disk(k=k), law, start, problem.times, tolerance=1e-13, check=False)
    true = np.stack([run[n].values for n in STATES], axis=-1)
    return float(relative(track.states - true, true)[1:].max()), track.error


@pytest.mark.parametrize(
    ("k", "law", "spin", "tilt", "last"),
    [
        (0.25, st.Viscous(1.0), 1.8, 1e-2, 2000.0),
        (0.5, st.Viscous(1.0), -1.5, 1e-2, 1000.0),
        (0.25, st.LinearViscous(1.0), 1.8, -1e-2, 1000.0),
        (0.3, st.Viscous(30.0), 2.0, 1e-2, 500.0),
    ],
)
def test_the_drift_states_its_error_where_the_second_order_fails(k, law, spin, tilt, last) -> None:
    true, stated = _error(k, law, spin, tilt, last)
    assert true <= stated < 30 * true
    assert true < 0.3 * tilt**2


def test_the_error_falls_as_the_square_of_the_tilt_over_the_same_share_of_the_way() -> None:
    """An expansion in the tilt, over a time that grows as its inverse square."""
    errors = [_error(0.25, st.Viscous(1.0), 1.8, tilt, 0.2 / tilt**2)[0] for tilt in (2e-2, 1e-2)]
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.15)


def test_the_manifold_of_the_disk_keeps_the_integral_and_has_the_rates_of_the_closed_form() -> None:
    """The closed form is derived from another graph: notebooks/proofs/centre_manifold.py."""
    law = st.Viscous(1.0)
    slow = _manifold(_problem(0.25, law, st.launch("rolling", at=1.8, tilt=2e-2), 4e3), 0.02, 1.8)
    assert isinstance(slow, SlowManifold)
    tilts, spins = slow.at(np.linspace(0, 4e3, 7))
    kept = tilts**2 * (3 * spins**2 - 1) / spins**2  # 2 (2k + 1) = 3
    assert kept == pytest.approx(kept[0], rel=1e-7)
    for tilt, spin in zip(tilts, spins, strict=True):
        found = st.drift(at=spin, tilt=tilt, contact=law, launch=False)
        wanted = found.tilt_rate * tilt**3, found.spin_rate * tilt**2
        assert [float(v) for v in slow.rates(tilt, spin)] == pytest.approx(wanted, rel=1e-6)


def test_a_scene_of_long_rolling_is_answered_by_the_drift() -> None:
    start = st.launch("rolling", at=1.8, tilt=5e-3)
    answer = st.Scene(contact=st.Viscous(1.0), start=start, horizon=4e3, tolerance=1e-4).answer()
    assert answer.model == "drift"
    run = st.simulate(st.Disk(), st.Viscous(1.0), start, [4e3], tolerance=1e-13)
    true = np.array([float(run[n].values[-1]) for n in STATES])
    error = float(relative(np.array(list(answer.value.values())) - true, true))
    assert error <= answer.estimate <= 1e-4


# --- other bodies ---

SEED = int(os.environ.get("STABILITY_SEED", "20261128"))
UNEVEN = st.Body(
    lambda theta: 0.8 * ca.sin(theta) + 0.2 + 0.02 * ca.cos(theta) ** 3,
    axial=1.0,
    transverse=0.55,
    name="uneven ring",
)


def _of_body(body: st.Body, law: Any, start: Any, last: float) -> LaunchProblem:
    times = np.linspace(0.0, last, 9)
    return LaunchProblem(gather(body, law, start, times), 1e-4, times)


def _off(body: st.Body, law: Any, start: Any, last: float) -> tuple[float, float] | Refused:
    """True and stated error of the drift of a body."""
    problem = _of_body(body, law, start, last)
    track = drifting(problem)
    if isinstance(track, Refused):
        return track
    run = st.simulate(body, law, start, problem.times, tolerance=1e-13, check=False)
    return far(track.states, columns(run)), track.error


@pytest.mark.parametrize(
    ("tube", "law", "spin", "tilt", "last"),
    [
        (0.2, st.Viscous(1.0), 1.8, 1e-2, 2000.0),
        (0.5, st.Viscous(0.5), -2.0, -1e-2, 2000.0),
        (0.1, st.LinearViscous(3.0), 2.0, -1e-2, 3000.0),
    ],
)
def test_a_torus_drifts_within_the_stated_error(
    tube: float, law: Any, spin: float, tilt: float, last: float
) -> None:
    body = st.Torus(tube)
    told = _off(body, law, st.launch("rolling", at=spin, tilt=tilt, body=body), last)
    assert not isinstance(told, Refused)
    true, stated = told
    assert true <= stated < 30 * true
    assert true < 0.3 * tilt**2


def test_the_error_of_a_torus_falls_as_the_square_of_the_tilt() -> None:
    body, errors = st.Torus(0.2), []
    for tilt in (2e-2, 1e-2):
        start = st.launch("rolling", at=1.8, tilt=tilt, body=body)
        told = _off(body, st.Viscous(1.0), start, 0.4 / tilt**2)
        assert not isinstance(told, Refused)
        errors.append(told[0])
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.15)


def test_the_manifold_of_a_body_obeys_its_rates() -> None:
    problem = _of_body(st.Torus(0.2), st.Viscous(1.0), st.launch("rolling", at=1.8, tilt=2e-2), 2e3)
    slow = _manifold(problem, 0.02, 1.8)
    assert isinstance(slow, SlowManifold)
    times = np.linspace(20.0, 1900.0, 7)
    tilt, spin = slow.at(times)
    ahead, back = slow.at(times + 1e-1), slow.at(times - 1e-1)
    for i, rate in enumerate(slow.rates(tilt, spin)):
        assert (ahead[i] - back[i]) / 2e-1 == pytest.approx(rate, rel=1e-5)
    assert tilt[-1] > tilt[0] > 0 and spin[-1] < spin[0]


def test_a_long_roll_of_a_torus_is_answered_by_the_drift() -> None:
    body = st.Torus(0.2)
    start = st.launch("rolling", at=2.5, tilt=5e-3, body=body)
    answer = st.Scene(body, st.Viscous(1.0), start, 1.5e4, 1e-4).verify()
    assert answer.model == "drift"
    assert answer.true_error <= answer.estimate <= 1e-4


def test_fast_modes_that_hardly_decay_lose_their_phase_as_the_spin_drifts() -> None:
    """Near the threshold a change of the spin by 1e-4 is a phase of 0.05 after long."""
    start, law = [1.566, 0.0, 0.0, 1.5837, 0.0, 0.0], st.LinearViscous(24.18)
    track = drifting(_problem(0.2283, law, np.array(start), 460.0))
    assert isinstance(track, Track)
    run = st.simulate(st.Disk(k=0.2283), law, start, track.times, tolerance=1e-13, check=False)
    assert far(track.states, columns(run)) <= track.error


@pytest.mark.parametrize(
    ("count", "seed"), [(5, 20261128), pytest.param(150, SEED, marks=pytest.mark.long)]
)
def test_random_bodies_drift_within_the_stated_error(count: int, seed: int) -> None:
    low, answered = [], 0
    for number in range(count):
        rng = np.random.default_rng([seed, number])
        body = st.Torus(float(rng.uniform(0.03, 0.6)))
        if rng.random() < 0.3:
            body = disk_as_body(st.Disk(k=float(rng.uniform(0.15, 0.5))))
        mu = 10 ** rng.uniform(-0.5, 1.5)
        law: Any = st.Viscous(mu) if rng.random() < 0.6 else st.LinearViscous(mu)
        spin, tilt = rng.uniform(0.9, 3) * rng.choice([-1, 1]), 10 ** rng.uniform(-3, -1.5)
        start = st.launch("rolling", at=spin, tilt=tilt * rng.choice([-1, 1]), body=body)
        start[1:4] += rng.normal(size=3) * tilt * rng.choice([0, 0.3])
        told = _off(body, law, start, 10 ** rng.uniform(2, 4))
        if isinstance(told, Refused):
            continue
        answered += 1
        if told[0] > told[1] + 1e-12:
            low.append((number, body.name, law, start, *told))
    assert not low, low
    assert answered > count / 2


@pytest.mark.parametrize(
    ("body", "start", "words"),
    [
        (st.ThickDisk(0.2), {"at": 3.0}, "leans by 0.0997 rad as it rolls"),
        (st.Egg(0.2), {"at": 3.0}, "the heading turns without end"),
        (UNEVEN, {"at": 3.0}, "alike on both sides"),
        (st.Torus(0.2), {"at": 1.0}, "two zero eigenvalues and decaying ones"),
        (st.Torus(0.2), {"at": 3.0, "tilt": 0.0}, "nothing drifts"),
    ],
)
def test_a_body_that_has_no_known_drift_is_told_so(body: st.Body, start: Any, words: str) -> None:
    six = st.launch("rolling", **({"tilt": 5e-3} | start), body=body)
    answer = st.Scene(body, st.Viscous(1.0), six, 100.0, 1e-4).answer(only="drift")
    assert words in answer.sentence
    assert answer.model == "none"


# --- what does not drift ---


@pytest.mark.parametrize(
    ("law", "start", "last", "words"),
    [
        (st.Rough(), st.launch("rolling", at=1.8, tilt=0.01), 10.0, "no rolling drifts"),
        (st.Viscous(1.0), st.launch("spinning", at=2.5, tilt=0.01), 10.0, "nearest steady motion"),
        (st.Viscous(1.0), st.launch("rolling", at=1.3, tilt=0.01), 10.0, "two zero eigenvalues"),
        (st.Viscous(1.0), st.launch("rolling", at=1.8, tilt=0.02), 6000.0, "no longer decays"),
    ],
)
def test_what_does_not_drift_is_refused_with_the_reason(law, start, last, words: str) -> None:
    told = drifting(_problem(0.25, law, start, last))
    assert isinstance(told, Refused)
    assert words in told.why
