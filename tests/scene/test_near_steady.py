"""The closed forms near a steady motion against the full model, and what they say of themselves."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

import stability as st
from stability.motion.round_starts import gather_round as gather
from stability.scene.rungs.near_steady import LINEARISED, SECOND, STEADY, near_steady
from stability.scene.rungs.track import LaunchProblem, Refused, Track, relative

STATES = ("theta", "theta_dot", "phi_dot", "omega3", "slip_x", "slip_y")
CASES = [
    ("rolling", 1.2, 100.0, st.Rough(), 0.25),
    ("rolling", 1.2, 100.0, st.Viscous(300.0), 0.5),
    ("spinning", 2.6, 100.0, st.Smooth(), 0.5),
    ("spinning", 2.6, 60.0, st.Viscous(3.0), 0.25),
    ("tumbling", 1.0, 30.0, st.Viscous(1.0), 0.25),
    ("rolling", 1.6, 1000.0, st.Rough(), 0.3),
]


def _tracks(family, at, last, law, k, tilt=1e-3, count=41):
    disk = st.Disk(k=k)
    start = st.launch(family, at=at, tilt=tilt, disk=disk)
    times = np.linspace(0.0, last, count)
    problem = LaunchProblem(gather(disk, law, start, times), 1e-6, times)
    run = st.simulate(disk, law, start, times, tolerance=1e-15)
    true = np.stack([run[n].values for n in STATES], axis=-1)[:, : problem.own]
    return near_steady(problem), true, problem


@pytest.mark.parametrize(("family", "at", "last", "law", "k"), CASES)
def test_each_order_states_its_error(family, at, last, law, k) -> None:
    tracks, true, problem = _tracks(family, at, last, law, k)
    sizes = []
    for name in (STEADY, LINEARISED, SECOND):
        track = tracks[name]
        assert isinstance(track, Track), track.why
        error = float(relative(track.states[:, : problem.own] - true, true).max())
        assert error <= track.error
        assert track.error < 30 * error + 1e-13
        sizes.append(error)
    assert sizes[0] > 30 * sizes[1] >= 30 * sizes[2] * 0.9


def test_the_orders_fall_with_the_powers_of_the_tilt() -> None:
    errors = []
    for tilt in (4e-3, 1e-3):
        tracks, true, problem = _tracks("tumbling", 1.0, 20.0, st.Viscous(1.0), 0.25, tilt)
        errors.append(
            [
                float(relative(tracks[n].states[:, : problem.own] - true, true).max())
                for n in (STEADY, LINEARISED, SECOND)
            ]
        )
    powers = np.log(np.array(errors[0]) / np.array(errors[1])) / np.log(4)
    assert powers == pytest.approx([1, 2, 3], abs=0.25)


def test_any_time_costs_the_same_states() -> None:
    tracks, _, _ = _tracks("tumbling", 1.0, 30.0, st.Viscous(1.0), 0.25)
    track = tracks[SECOND]
    assert track.at(track.times) == pytest.approx(track.states, abs=1e-14)


def test_a_start_far_from_every_family_is_refused_with_the_distance() -> None:
    problem = LaunchProblem(
        gather(st.Disk(), st.Viscous(0.3), [0.9, 0.2, 0.5, 1.5, 0, 0], 5.0),
        1e-6,
        np.array([0.0, 5.0]),
    )
    told = near_steady(problem)
    assert isinstance(told, Refused)
    assert "nearest steady motion" in told.why


def test_growth_out_of_the_linear_domain_is_refused() -> None:
    told, _, _ = _tracks("rolling", 0.3, 40.0, st.Viscous(0.3), 0.25, 1e-6, 3)
    assert isinstance(told, Refused)
    assert "grows" in told.why


def test_parallel_modes_are_refused() -> None:
    x, p = ca.SX.sym("x", 2), ca.SX.sym("p")
    free = st.System(
        "free", x, p, ca.vertcat(x[1], -p * x[0] ** 2), states=("q", "v"), parameters=("p",)
    )
    rest = st.Family(free, "rest", at=("p",), held={"q": 0, "v": 0})
    scene = st.Scene(free, {"p": 1.0}, {"q": 1e-3, "v": 0.0}, 1.0, 1e-6, families=rest)
    assert scene.answer().model == "free"
    assert "parallel" in scene.answer(only=LINEARISED).sentence


def test_a_system_without_known_steady_motions_is_told_the_argument_that_mends_it() -> None:
    x, c = ca.SX.sym("x", 2), ca.SX.sym("c")
    swing = st.System(
        "swing",
        x,
        c,
        ca.vertcat(x[1], -ca.sin(x[0]) - c * x[1]),
        states=("angle", "rate"),
        parameters=("c",),
    )
    start = {"angle": 1e-3, "rate": 0.0}
    bare = st.Scene(swing, {"c": 0.2}, start, 10.0, 1e-4).answer()
    whys = [r.why for r in bare.rungs if r.name == LINEARISED]
    assert whys == ["no steady motion is known near the start; name some with families="]
    fast = st.Family(
        swing,
        "fast",
        at=("c",),
        held={"rate": 0},
        unknown={"angle": 1.0},
        equations=("rate",),
        positive=("angle",),
    )
    none = st.Scene(swing, {"c": 0.2}, start, 10.0, 1e-4, families=fast).answer()
    assert "families=" not in " ".join(r.why for r in none.rungs)
    rest = st.Family(swing, "rest", at=("c",), held={"angle": 0, "rate": 0})
    near = st.Scene(swing, {"c": 0.2}, start, 10.0, 1e-4, families=rest)
    assert near.answer().model == LINEARISED
