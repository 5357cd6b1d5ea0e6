"""What ends a motion that takes too long, and guards that are looked at within long steps."""

import dataclasses
import math
import time
from typing import Any

import casadi as ca
import numpy as np
import pytest

import stability as st
from stability.integrators import selection as integrators
from stability.integrators import sundials
from stability.integrators.flow import flow
from stability.integrators.leg import Budget, Leg
from stability.integrators.selection import METHODS
from stability.motion.result import BY_CODE
from stability.motion.run import CHUNK
from stability.motion.starts import MOST_LAUNCHES, MOST_SAMPLES

FAST = {"theta": 1.4, "omega3": -3.6e7}


def word(run: Any) -> str:
    return BY_CODE[int(run.outcome)].word


@pytest.mark.few(1)
@pytest.mark.parametrize("method", ["heyoka", "dop853", "lsoda", "cvodes"])
def test_a_run_ends_when_its_computing_time_is_spent(method: str) -> None:
    run = st.simulate(st.Disk(), st.Viscous(0.3), FAST, 10.0, method=method, max_seconds=0.2)
    assert word(run) == "unresolved"
    assert "more than 0.2 s of computing" in str(run.evidence.values)
    assert "max_seconds" in run.attrs["outcome_sentence"]
    assert float(run.end_time) < 10


def test_dry_friction_has_a_budget_too() -> None:
    start = {"theta": 1.4, "omega3": 1e4, "slip_x": 0.5}
    run = st.simulate(st.Disk(), st.Coulomb(0.1), start, 1e3, method="dop853", max_seconds=0.2)
    assert word(run) == "unresolved"
    assert "more than 0.2 s of computing" in str(run.evidence.values)


@pytest.mark.long
def test_a_budget_is_of_the_thread_and_of_no_other() -> None:
    budget = Budget(1e6)
    assert budget(None)
    assert 0 < budget.left <= 1e6
    assert not Budget(0.0)(None)
    for _ in range(3):  # a reading of the clock that serves several budgets
        budget = Budget(0.2)
        time.sleep(0.3)
        assert budget.left > 0.15 and not budget.spent
        end = time.thread_time() + 0.21
        while time.thread_time() < end:
            pass
        assert budget.spent


@pytest.mark.parametrize("seconds", [0, -1.0, math.inf, math.nan, 1e9, "long", [1.0, 2.0]])
def test_a_budget_is_refused_in_one_sentence(seconds: Any) -> None:
    with pytest.raises(st.StabilityError, match="max_seconds"):
        st.simulate(st.Disk(), st.Rough(), {"theta": 1.2}, 1.0, max_seconds=seconds)


@pytest.mark.long
def test_a_long_run_of_heyoka_is_the_same_on_both_sides_of_its_first_part(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    from stability.integrators import taylor

    pytest.importorskip("heyoka")
    times = np.linspace(0, 50, 41)
    start = {"theta": 1.4, "phi_dot": 0.3, "omega3": 1.3, "slip_x": 0.1}
    plain = st.simulate(st.Disk(), st.Viscous(0.3), start, times, method="heyoka")
    monkeypatch.setattr(taylor, "QUIET", 57)
    parted = st.simulate(st.Disk(), st.Viscous(0.3), start, times, method="heyoka")
    assert int(parted.steps) > 57
    assert parted.sizes["time"] == 41
    assert np.abs(parted.theta - plain.theta).max() < 1e-8
    few = st.simulate(st.Disk(), st.Viscous(0.3), start, times, method="heyoka", max_steps=60)
    assert word(few) == "unresolved"
    six = np.array([1.4, 0, 0.3, 1.3, 0.1, 0]) + np.linspace(0, 0.01, 5)[:, None]
    many = st.simulate(st.Disk(), st.Viscous(0.3), six, times, method="heyoka")
    assert np.abs(many.theta[0] - plain.theta).max() < 1e-8


def test_a_stiff_leg_ends_between_two_stretches_once_its_time_is_spent(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    run, stretches = sundials._run, list[int]()

    def slow(leg: Leg, plugin: str, start: Any, span: float, shares: Any, most: int) -> Any:
        """A run of the library that takes its time, and gives up over the whole."""
        stretches.append(len(shares))
        end = time.thread_time() + 0.1
        while time.thread_time() < end:
            pass
        return None if len(stretches) == 1 else run(leg, plugin, start, span, shares, most)

    monkeypatch.setattr(sundials, "_run", slow)
    roll = flow("viscous", pose=False)
    start = roll.pack(np.array([1.4, 0, 0, 1.2, 0, 0]))
    times = np.linspace(0.0, 1.0, 200)
    leg = Leg(roll, np.array([0.25, 0.3, 1e-6]), start, times, 1e-6, 10**6, seconds=0.15)
    path = METHODS["cvodes"](leg)
    assert path.end is not None and path.end.kind == "unresolved"
    assert "more than 0.15 s of computing" in path.end.message
    assert len(stretches) == 2 and 0 < path.end.time < 1


@pytest.mark.parametrize("method", ["dop853", "lsoda"])
def test_a_guard_that_dips_within_a_long_step_is_seen(method: str) -> None:
    # upright spinning is exact, so a loose run takes it in long steps; the guard is below zero
    # for 0.09 of each turn
    spin = flow("smooth", pose=True)
    phi = spin.x[7] * 1024.0
    watched = spin.having(guards={"dip": 0.999 + ca.cos(2 * phi)})
    start = watched.pack(np.array([math.pi / 2, 0, 3.0, 0, 0, 0]))
    leg = Leg(watched, np.array([0.25, 1e-6]), start, np.array([0.0, 10.0]), 1e-2, 10**6)
    path = METHODS[method](leg)
    assert path.end is not None
    first = (math.pi - math.acos(0.999)) / 2 / 3.0
    assert path.end.time == pytest.approx(first, abs=1e-3)


def test_absurd_counts_are_refused_before_memory_is_taken() -> None:
    start = np.broadcast_to(np.array([1.4, 0, 0, 1.2, 0, 0]), (MOST_LAUNCHES + 1, 6))
    with pytest.raises(st.StabilityError, match="launches at 1 times are asked; give at most"):
        st.simulate(st.Disk(), st.Viscous(0.3), start, [1.0])
    few = np.broadcast_to(np.array([1.4, 0, 0, 1.2, 0, 0]), (MOST_SAMPLES // 100, 6))
    with pytest.raises(st.StabilityError, match="launches at 201 times are asked; give at most"):
        st.simulate(st.Disk(), st.Viscous(0.3), few, 1.0)


def test_no_launches_are_refused() -> None:
    with pytest.raises(st.StabilityError):
        st.simulate(st.Disk(), st.Viscous(0.3), np.empty((0, 6)), 1.0)


def test_launches_in_several_chunks_are_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    from stability.motion import run as motion

    start = np.array([1.4, 0, 0, 1.2, 0, 0]) + np.linspace(0, 0.1, 5)[:, None]
    whole = st.simulate(st.Disk(), st.Viscous(0.3), start, [2.0])
    told: list[tuple[int, int]] = []
    monkeypatch.setattr(motion, "CHUNK", 2)
    assert CHUNK > 2
    parts = st.simulate(
        st.Disk(), st.Viscous(0.3), start, [2.0], progress=lambda *d: told.append(d)
    )
    assert np.abs(whole.theta - parts.theta).max() < 1e-9
    assert told[-1] == (5, 5)


def test_the_neighbours_of_a_launch_share_one_budget(monkeypatch: pytest.MonkeyPatch) -> None:
    # each run is said to take 0.4 of the budget: the third neighbour has a fifth of it left
    given: list[float] = []

    def one(leg: Leg) -> Any:
        given.append(leg.seconds)
        return dataclasses.replace(plain(leg), seconds=0.4)

    plain = integrators.METHODS["dop853"]
    monkeypatch.setattr(integrators, "_timed", lambda _, leg: one(leg))
    start = {"theta": 1.4, "omega3": 1.0}
    st.simulate(
        st.Disk(), st.Viscous(0.3), start, 1.0, method="dop853", tolerance=1e-2, max_seconds=1.0
    )
    assert given == pytest.approx([1.0, 1.0, 0.6, 0.2])


@pytest.mark.long
def test_a_neighbour_without_time_leaves_the_launch_undetermined(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    asked: dict[str, Any] = {"method": "dop853", "tolerance": 1e-9}
    start, plain = {"theta": 1.4, "omega3": 1e4}, integrators._timed
    alone = st.simulate(st.Disk(), st.Viscous(0.3), start, 0.05, **asked)
    calls: list[str] = []

    def hurried(method: str, leg: Leg) -> Any:
        calls.append(method)
        return plain(method, leg if len(calls) == 1 else dataclasses.replace(leg, seconds=1e-9))

    monkeypatch.setattr(integrators, "_timed", hurried)
    both = st.simulate(st.Disk(), st.Viscous(0.3), start, 0.05, **asked)
    assert word(alone) == "moving"
    assert word(both) == "undetermined"
    assert "more than 1e-09 s of computing" in str(both.evidence.values)
    assert float(both.final_error) == math.inf
