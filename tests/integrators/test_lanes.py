"""Launches on lanes end as each of them does alone."""

from typing import Any

import casadi as ca
import numpy as np
import pytest

import stability as st
from stability.bodies.model import system_model
from stability.integrators import lanes
from stability.integrators.flow import flow, flow_of
from stability.integrators.lanes import EVENT, FAILED, LASTED, PROVED, ends
from stability.integrators.leg import Leg
from stability.integrators.taylor import available, integrate, on_guards

pytestmark = pytest.mark.skipif(not available(), reason="heyoka is not installed")
REFERENCE = st.launch("rolling", at=1.2)
STATES = ("theta", "theta_dot", "phi_dot", "omega3", "slip_x", "slip_y")


def many(count: int, spread: float, seed: int = 1) -> tuple[Any, Any]:
    rng = np.random.default_rng(seed)
    starts = REFERENCE + rng.uniform(-spread, spread, (count, 6))
    return flow("viscous").pack(starts), np.tile([0.25, 0.3, 1e-6], (count, 1))


def test_a_lane_ends_where_the_launch_alone_does() -> None:
    f = flow("viscous")
    y = f.pack(st.launch("spinning", at=np.linspace(3.2, 3.9, 60), tilt=0.55))  # fast ones lift off
    p = np.tile([0.25, 0.3, 1e-6], (60, 1))
    found = ends(f, y, p, np.full(60, 40.0), 1e-9, 10**6)
    run = st.simulate(st.Disk(), st.Viscous(0.3), y[:, :6], [20.0, 40.0], check=False)
    lifted = found.kind == EVENT
    words = np.array(run.outcome.attrs["flag_meanings"].split())[run.outcome.values]
    assert 3 < lifted.sum() < 57, lifted.sum()
    assert (lifted == (words == "lift-off")).all()
    assert (found.kind[~lifted] == LASTED).all() and (found.time[~lifted] == 40.0).all()
    last = np.stack([run[n].values[:, -1] for n in STATES], axis=-1)
    assert np.abs(found.state[~lifted, :6] - last[~lifted]).max() < 1e-6
    # an event lies on a step's polynomial, next to the guard's zero
    assert np.abs(found.time - run.end_time.values)[lifted].max() < 1e-6


def test_a_launch_does_not_depend_on_the_others(monkeypatch: pytest.MonkeyPatch) -> None:
    f, (y, p) = flow("viscous"), many(40, 0.1)
    whole = ends(f, y, p, np.full(40, 20.0), 1e-9, 10**6)
    order = np.random.default_rng(2).permutation(40)[:23]
    monkeypatch.setattr(lanes, "TURNS", 1)
    some = ends(f, y[order], p[order], np.full(23, 20.0), 1e-9, 10**6)
    assert (some.state == whole.state[order]).all() and (some.time == whole.time[order]).all()
    assert (some.steps == whole.steps[order]).all()


def test_a_launch_is_seen_at_the_same_steps_in_any_company(monkeypatch: pytest.MonkeyPatch) -> None:
    f = flow("viscous")
    y = f.pack(st.launch("spinning", at=np.linspace(3.2, 3.9, 40), tilt=0.55))  # some lift off
    p, horizon = np.tile([0.25, 0.3, 1e-6], (40, 1)), np.linspace(3.0, 30.0, 40)

    def times(order: Any) -> dict[int, list[float]]:
        seen: dict[int, list[float]] = {int(i): [] for i in order}

        def watch(rows: Any, _states: Any, at: Any) -> Any:
            for row, time in zip(rows, at, strict=True):
                seen[int(order[row])].append(float(time))
            return np.zeros(len(rows), dtype=bool)

        ends(f, y[order], p[order], horizon[order], 1e-9, 10**6, watch)
        return seen

    whole = times(np.arange(40))
    order = np.random.default_rng(3).permutation(40)[:17]
    monkeypatch.setattr(lanes, "TURNS", 1)
    some = times(order)
    assert {i: some[i] for i in some} == {i: whole[i] for i in some}


def test_each_launch_has_its_own_horizon() -> None:
    f, (y, p) = flow("viscous"), many(30, 0.01)
    horizon = np.linspace(0.5, 30.0, 30)
    found = ends(f, y, p, horizon, 1e-9, 10**6)
    assert (found.time == horizon).all() and (found.kind == LASTED).all()


def test_a_watcher_ends_launches_and_sees_them_at_their_last_time() -> None:
    f, (y, p) = flow("viscous"), many(30, 0.05)
    seen: dict[int, list[float]] = {i: [] for i in range(30)}

    def watch(rows: Any, states: Any, times: Any) -> Any:
        assert states.shape == (len(rows), 7)
        for row, time in zip(rows, times, strict=True):
            seen[int(row)].append(float(time))
        return (rows % 2 == 0) & (times > 3.0)

    found = ends(f, y, p, np.full(30, 20.0), 1e-9, 10**6, watch)
    assert (found.kind[::2] == PROVED).all() and (found.kind[1::2] == LASTED).all()
    assert all(3.0 < times[-1] < 20.0 for times in list(seen.values())[::2])
    assert all(times[-1] == 20.0 for times in list(seen.values())[1::2])


def test_a_launch_that_takes_too_many_steps_or_overflows_fails_and_the_others_go_on() -> None:
    f, (y, p) = flow("viscous"), many(12, 0.05)
    assert (ends(f, y, p, np.full(12, 50.0), 1e-9, 100).kind == FAILED).all()
    x = ca.SX.sym("x")
    system = st.System("blow-up", x, ca.SX(0, 1), x**2, states=("x",), parameters=())
    grown = flow_of(system_model(system))
    starts = grown.pack(np.array([[-1.0], [0.5], [-2.0], [0.1]]))
    found = ends(grown, starts, np.zeros((4, 0)), np.full(4, 5.0), 1e-9, 10**5)
    assert found.kind.tolist() == [LASTED, FAILED, LASTED, LASTED]
    exact = 1 / (1 / starts[[0, 2, 3], 0] - 5.0)
    assert np.abs(found.state[[0, 2, 3], 0] - exact).max() < 1e-8


def test_no_launches_are_no_error() -> None:
    f = flow("viscous")
    assert len(ends(f, np.zeros((0, 7)), np.zeros((0, 3)), np.zeros(0), 1e-9, 10).kind) == 0


def test_samples_are_those_of_each_launch_alone_whatever_its_neighbours_do() -> None:
    f = flow("viscous")
    y = f.pack(st.launch("spinning", at=np.linspace(3.2, 3.9, 60), tilt=0.55))  # fast ones lift off
    p = np.tile([0.25, 0.3, 1e-6], (60, 1))
    times = np.linspace(5.0, 40.0, 60)[:, None] * np.concatenate([[0.0], np.logspace(-2, 0, 30)])
    found = ends(f, y, p, times[:, -1], 1e-12, 10**6, times=times)
    lifted = found.kind == EVENT
    assert 3 < lifted.sum() < 57 and found.samples is not None
    for i in range(60):
        last = times[i] <= found.time[i]
        assert np.isfinite(found.samples[i, last]).all()
        assert np.isnan(found.samples[i, ~last]).all()
        path = integrate(Leg(f, p[i], y[i], times[i], 1e-12, 10**6))
        shared = min(len(path.states), int(last.sum()))
        assert abs(len(path.states) - last.sum()) <= 1
        assert np.abs(path.states[:shared] - found.samples[i, :shared]).max() < 1e-9
    order = np.random.default_rng(2).permutation(60)[:23]
    some = ends(f, y[order], p[order], times[order, -1], 1e-12, 10**6, times=times[order])
    assert some.samples is not None
    np.testing.assert_allclose(some.samples, found.samples[order], rtol=0, atol=1e-14)
    assert (some.steps == found.steps[order]).all()


def test_a_launch_that_stops_just_before_a_sample_fails_and_the_others_go_on(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(lanes, "STRIDE", lanes.UNSEEN)
    f, (y, p) = flow("viscous"), many(2, 0.05)
    stops: list[float] = []

    def watch(rows: Any, _states: Any, at: Any) -> Any:
        stops.extend(at[rows == 0].tolist())
        return np.zeros(len(rows), dtype=bool)

    ends(f, y, p, np.full(2, 100.0), 1e-9, 10**6, watch)
    stop = stops[0]  # after the first stride
    near = np.array([*np.linspace(0, stop / 2, 10), np.nextafter(stop, 100.0), 99.0, 100.0])
    far = np.array([0.0, *np.linspace(90.0, 100.0, 12)])
    found = ends(f, y, p, np.full(2, 100.0), 1e-9, 10**6, times=np.stack([near, far]))
    assert found.kind.tolist() == [FAILED, LASTED]
    assert found.samples is not None and np.isfinite(found.samples[1]).all()


def test_a_launch_without_computing_time_left_fails_and_the_others_go_on() -> None:
    f, (y, p) = flow("viscous"), many(20, 0.05)
    times, seconds = np.tile([0.0, 50.0], (20, 1)), np.where(np.arange(20) % 3, 60.0, 0.0)
    found = ends(f, y, p, times[:, -1], 1e-9, 10**6, times=times, seconds=seconds)
    assert ((found.kind == FAILED) == (seconds == 0)).all()
    assert (found.kind[seconds > 0] == LASTED).all()


@pytest.mark.parametrize(("span", "moved"), [(1e-2, False), (1.0, True)])
def test_an_event_moves_by_a_share_of_the_run(span: float, moved: bool) -> None:
    """The unit of time is the user's: no event of a short run moves beyond a thousandth of it."""
    x, rate = ca.SX.sym("x"), ca.SX.sym("rate")
    above = st.Condition(x, "left is {value}")
    names: dict[str, Any] = {"states": ("left",), "parameters": ("rate",)}
    clock = flow_of(system_model(st.System("clock", x, rate, -rate, conditions=(above,), **names)))
    off = 5e-4  # from the guard's zero, which is reached after the same time
    state = clock.pack(np.array([off]))
    leg = Leg(clock, np.ones(1), state, np.array([0.0, span]), 1e-9, 10)
    [end] = on_guards([leg], np.array([span - off]), state[None])
    assert end.time == pytest.approx(span if moved else span - off, abs=1e-12)
    assert end.state[0] == pytest.approx(0.0 if moved else off, abs=1e-15)
