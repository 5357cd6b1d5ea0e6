"""The drift of rolling in closed form, against the full model and `stability.drift`."""

from __future__ import annotations

import numpy as np
import pytest

import stability as st
from stability.motion.round_starts import gather_round as gather
from stability.scene.rungs.drifting import SlowManifold, drifting
from stability.scene.rungs.track import Problem, Refused, Track, relative

STATES = ("theta", "theta_dot", "phi_dot", "omega3", "slip_x", "slip_y")


def _problem(k: float, law, start, last: float) -> Problem:
    times = np.linspace(0.0, last, 9)
    return Problem(gather(st.Disk(k=k), law, start, times), 1e-4, times)


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
        (0.25, st.Viscous(1.0), 1.8, 1e-2, 2000.0), (0.5, st.Viscous(1.0), -1.5, 1e-2, 1000.0),
        (0.25, st.LinearViscous(1.0), 1.8, -1e-2, 1000.0),
        (0.3, st.Viscous(30.0), 2.0, 1e-2, 500.0),
    ],
)  # fmt: skip
def test_the_drift_states_its_error_where_the_second_order_fails(k, law, spin, tilt, last) -> None:
    true, stated = _error(k, law, spin, tilt, last)
    assert true <= stated < 30 * true
    assert true < 0.3 * tilt**2


def test_the_error_falls_as_the_square_of_the_tilt_over_the_same_share_of_the_way() -> None:
    """An expansion in the tilt, over a time that grows as its inverse square."""
    errors = [_error(0.25, st.Viscous(1.0), 1.8, tilt, 0.2 / tilt**2)[0] for tilt in (2e-2, 1e-2)]
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.15)


def test_the_closed_form_obeys_the_rates_and_keeps_the_integral() -> None:
    slow = SlowManifold(0.25, 1.0, 0.02, 1.8)
    times = np.linspace(0, 0.8 * slow.crossing, 7)
    tilt, spin = slow.at(times)
    ahead, back = slow.at(times + 1e-2), slow.at(times - 1e-2)
    for i, rate in enumerate(slow.rates(tilt, spin)):
        assert (ahead[i] - back[i]) / 2e-2 == pytest.approx(rate, rel=1e-6)
    kept = tilt**2 * (3 * spin**2 - 1) / spin**2  # 2 (2k + 1) = 3
    assert kept == pytest.approx(kept[0], rel=1e-12)


def test_the_crossing_is_that_of_the_drift() -> None:
    slow = SlowManifold(0.25, 1.0, 0.02, 1.8)
    found = st.drift(at=1.8, tilt=0.02, contact=st.Viscous(1.0), launch=False)
    assert slow.crossing == pytest.approx(found.time, rel=1e-12)
    assert abs(slow.at(np.array([slow.crossing]))[1][0]) == pytest.approx(found.threshold, rel=1e-9)


def test_a_scene_of_long_rolling_is_answered_by_the_drift() -> None:
    start = st.launch("rolling", at=1.8, tilt=5e-3)
    answer = st.Scene(contact=st.Viscous(1.0), start=start, horizon=4e3, tolerance=1e-4).answer()
    assert answer.model == "drift"
    run = st.simulate(st.Disk(), st.Viscous(1.0), start, [4e3], tolerance=1e-13)
    true = np.array([float(run[n].values[-1]) for n in STATES])
    error = float(relative(np.array(list(answer.value.values())) - true, true))
    assert error <= answer.estimate <= 1e-4


@pytest.mark.parametrize(
    ("law", "start", "last", "words"),
    [
        (st.Rough(), st.launch("rolling", at=1.8, tilt=0.01), 10.0, "no rolling drifts"),
        (st.Viscous(1.0), st.launch("spinning", at=2.5, tilt=0.01), 10.0, "nearest steady motion"),
        (st.Viscous(1.0), st.launch("rolling", at=1.3, tilt=0.01), 10.0, "below its threshold"),
        (st.Viscous(1.0), st.launch("rolling", at=1.8, tilt=0.02), 5000.0, "crosses the threshold"),
    ],
)
def test_what_does_not_drift_is_refused_with_the_reason(law, start, last, words: str) -> None:
    told = drifting(_problem(0.25, law, start, last))
    assert isinstance(told, Refused)
    assert words in told.why
