"""Creep along a path against stored motions in 30 digits and against the full model."""

from __future__ import annotations

import numpy as np
import pytest

import stability as st
from stability.compare.motion.reference_motions import scene as reference
from stability.motion.round_starts import gather_round as gather
from stability.scene.rungs.creep import creep_path, held_of, transient
from stability.scene.rungs.creeping import creeping
from stability.scene.rungs.full import full
from stability.scene.rungs.track import LaunchProblem, Track, relative

START = np.array([1.3, 0.1, 0.4, 1.1, 0.0, 0.0])


def _problem(mu: float, last: float, tolerance: float, start=START, k=0.25, law=st.Viscous):
    launches = gather(st.Disk(k=k), law(mu), start, last)
    return LaunchProblem(launches, tolerance, np.array([0.0, last]))


@pytest.mark.parametrize("name", ["stiff-300", "stiff-10000", "stiff-100000"])
def test_stored_motions_are_met_to_1e_10(name: str) -> None:
    motion = reference(name)
    scene = st.Scene(motion.disk(), motion.contact(), motion.start, float(motion.times[-1]), 1e-10)
    answer = scene.answer(only="creep")
    found = np.array(list(answer.value.values()))
    error = float(relative(found - motion.states[-1], motion.states[-1]))
    assert answer.model.startswith("creep")
    assert error < 1e-10
    assert answer.estimate < 1e-10


@pytest.mark.parametrize("name", ["stiff-300", "stiff-10000"])
def test_the_next_order_is_the_error_of_an_order(name: str) -> None:
    motion = reference(name)
    last = float(motion.times[-1])
    launches = gather(motion.disk(), motion.contact(), motion.start, last)
    problem = LaunchProblem(launches, 1e-10, np.array([0.0, last]))
    held = held_of(problem)
    times, states, _ = transient(problem, held, problem.start, 0.0, 1e-10)
    path = creep_path(problem, held, states[-1], float(times[-1]), last, 1e-10)
    i = int(np.flatnonzero(motion.times <= path.elements.edges[-1])[-1])
    when = motion.times[i : i + 1]
    for order in path.orders[:-1]:
        true = motion.states[i] - path.elements.at(when, order.states)[0]
        if np.abs(true).max() > 1e-9:
            stated = np.abs(path.elements.at(when, order.errors)[0]).max()
            ratio = stated / np.abs(true).max()
            assert 0.5 < ratio < 2


def test_linear_viscous_contact_creeps_too() -> None:
    start, last = np.array([1.3, 0.1, 0.4, 1.1, 1e-3, 0.0]), 5.0
    scene = st.Scene(st.Disk(), st.LinearViscous(2000.0), start, last, 1e-8)
    answer = scene.answer(only="creep")
    fine = st.simulate(st.Disk(), st.LinearViscous(2000.0), start, [last], tolerance=1e-13)
    true = np.array([float(fine[n].values[-1]) for n in answer.value])
    assert float(relative(np.array(list(answer.value.values())) - true, true)) < 1e-8


def test_creep_gives_way_before_a_lift_off_and_the_full_model_meets_the_event() -> None:
    start = [1.4708, 0.0, 0.0, 1.35, 0.0, 0.0]
    scene = st.Scene(contact=st.Viscous(0.3), start=start, horizon=40.0)
    end = scene.answer().until
    assert end < 40.0  # it lifts off with this little friction, and with more it does not
    hard = np.array([1.1, 0.0, 0.3, 2.2, 0.0, 0.0])
    found = [creeping(_problem(mu, 6.0, 1e-7, hard))[2] for mu in (50.0, 400.0)]
    for mu, track in zip((50.0, 400.0), found, strict=True):
        run = st.simulate(st.Disk(), st.Viscous(mu), hard, 6.0, tolerance=1e-13)
        if isinstance(track, Track) and track.finish is not None:
            assert track.finish.kind == run.attrs["outcome"]
            assert track.finish.time == pytest.approx(float(run.end_time), abs=1e-6)
        elif isinstance(track, Track):
            assert run.attrs["outcome"] in ("moving", "settled")


def test_no_full_model_runs_where_the_motion_ends_before_creep(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def refuse(*_: object) -> None:
        raise AssertionError("the full model ran")

    monkeypatch.setattr("stability.scene.rungs.creeping.full", refuse)
    start = np.array([1.07, -1.2, -2.1, -0.2, 0.0, 0.0])
    orders, _, told = creeping(_problem(5000.0, 200.0, 1e-6, start))
    assert not isinstance(told, Track)
    assert "before the slip has decayed" in told.why
    assert not orders


def test_elements_that_stay_coarse_have_the_path_at_their_own_points(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The divisions of elements may end before all resolve the motion."""
    monkeypatch.setattr("stability.scene.rungs.creep.SPLITS", 1)
    monkeypatch.setattr("stability.scene.rungs.creep.RESOLVED", 1e-6)
    orders, _, told = creeping(_problem(3000.0, 5.0, 1e-6))
    assert isinstance(told, Track)
    assert min(orders.values()) < 1e-6


def test_laws_whose_slip_does_not_relax_have_no_creep() -> None:
    for law in (st.Smooth(), st.Rough(), st.Coulomb(0.3)):
        launches = gather(st.Disk(), law, {"theta": 1.3, "omega3": 1.2}, 1.0)
        _, _, told = creeping(LaunchProblem(launches, 1e-6, np.array([0.0, 1.0])))
        assert not isinstance(told, Track)
        assert "no creep" in told.why


def test_little_friction_is_refused_with_the_number() -> None:
    _, _, told = creeping(_problem(1.0, 5.0, 1e-6))
    assert not isinstance(told, Track)
    assert "horizon ends before the slip has decayed" in told.why


def test_a_start_whose_error_has_no_bound_gives_an_end_of_which_nothing_is_known() -> None:
    problem = _problem(0.3, 2.0, 1e-6)
    track = full(problem, 0.0, problem.start, np.full(6, np.inf))
    assert np.isinf(track.errors).all()
    assert np.isfinite(track.states).all()
