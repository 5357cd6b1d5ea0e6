"""What is called settled stays so; slow passages and drifts are not called settled."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as some

import stability as st
from stability.equations import STATES
from stability.outcome import BY_CODE, Outcome
from stability.settling import FAMILIES, deviation, nearest


def outcome(run: Any) -> Outcome:
    return BY_CODE[int(run.outcome)]


def last(run: Any) -> Any:
    return np.array([float(run[name][-1]) for name in STATES])


def test_settled_launches_stay_and_come_closer() -> None:
    # run each on for as long again: it is nearer to a member of the same family
    for at, mu, family in ((2.6, 0.3, "spinning"), (1.2, 0.3, "tumbling"), (2.5, 1.0, "tumbling")):
        start = st.launch("spinning", at=at, tilt=0.1)
        run = st.simulate(st.Disk(), st.Viscous(mu), start, 1500.0)
        assert outcome(run) is Outcome.SETTLED
        assert str(run.nearest_family.values) == family
        on = st.simulate(st.Disk(), st.Viscous(mu), last(run), 1500.0)
        assert str(on.nearest_family.values) == family
        assert float(on.nearest_distance) < 0.5 * float(run.nearest_distance) + 1e-7
        assert float(on.nearest_at) == pytest.approx(float(run.nearest_at), abs=2e-3)
        assert float(run.settled_time) < 1500


def test_the_settled_time_is_when_the_distance_fell_for_good() -> None:
    start = st.launch("spinning", at=2.6, tilt=0.1)
    run = st.simulate(st.Disk(), st.Viscous(0.3), start, np.linspace(0, 300, 3001), settle=1e-3)
    six = np.stack([run[n].values for n in STATES], axis=-1)
    _, e = deviation(six, 0.25, "spinning")
    far = run.time.values[np.linalg.norm(e, axis=-1) > 1e-3]
    assert float(run.settled_time) == pytest.approx(far.max(), abs=0.11)


def test_slow_passage_by_an_unstable_motion_is_not_settling() -> None:
    # a start 1e-7 from unstable spinning stays within 1e-3 of it for a while: not settled
    member = st.launch("spinning", at=1.9, tilt=1e-7)
    run = st.simulate(st.Disk(), st.Viscous(0.3), member, 10.0)
    assert float(run.nearest_distance) < 1e-3
    assert st.spectrum("spinning", at=1.9, contact=st.Viscous(0.3)).verdict is st.Verdict.UNSTABLE
    assert outcome(run) is Outcome.MOVING
    assert "not asymptotically stable" in str(run.evidence.values)
    later = st.simulate(st.Disk(), st.Viscous(0.3), member, 400.0)
    assert str(later.nearest_family.values) == "tumbling"


def test_near_a_stable_motion_but_beyond_its_lyapunov_function_is_not_settled() -> None:
    six = np.array([math.pi / 2 + 0.03, 0, 2.5, 0, 0, 0.03])
    p = np.array([0.25, 0.3])
    assert st.spectrum("spinning", at=2.5, contact=st.Viscous(0.3)).verdict is st.Verdict.STABLE
    far = nearest(six, "viscous", p, 0.1)
    assert far.distance < 0.1
    assert not far.settled
    assert "too far" in far.evidence
    close = nearest(six * [1, 0, 1, 0, 0, 0.01] - [0.0299, 0, 0, 0, 0, 0], "viscous", p, 0.1)
    assert close.settled


def test_stable_rolling_is_said_to_drift_and_not_to_settle() -> None:
    run = st.simulate(st.Disk(), st.Viscous(1.0), st.launch("rolling", at=3.0, tilt=1e-4), 100.0)
    assert float(run.nearest_distance) < 1e-3
    assert outcome(run) is Outcome.MOVING
    assert "drifts" in str(run.evidence.values)


@pytest.mark.parametrize("contact", [st.Smooth(), st.Rough()])
def test_conservative_motions_settle_on_nothing(contact: Any) -> None:
    run = st.simulate(st.Disk(), contact, st.launch("spinning", at=3.0, tilt=1e-5), 20.0)
    assert outcome(run) is Outcome.MOVING
    assert "energy is kept" in str(run.evidence.values)


@given(some.sampled_from(FAMILIES), some.floats(0.3, 2.8), some.floats(0.05, 0.5))
@settings(max_examples=60, deadline=None)
def test_members_are_at_no_distance_from_their_family(family: str, at: float, k: float) -> None:
    six = st.launch(family, at=at, tilt=0.0, disk=st.Disk(k=k))
    where, e = deviation(six, k, family)
    assert float(where) == pytest.approx(at, rel=1e-15)
    assert np.abs(e).max() < 1e-15
    found = nearest(six, "viscous", np.array([k, 0.3]), 1e-3)
    assert found.distance < 1e-15


@given(
    some.sampled_from(["spinning", "tumbling"]), some.floats(0.3, 3.0), some.floats(0.1, 0.5),
    some.floats(-1, 1), some.integers(0, 2**30),
)  # fmt: skip
@settings(max_examples=30, deadline=None)
def test_what_counts_as_settled_is_stable_by_the_spectrum_and_does_fall(
    family: str, at: float, k: float, decade: float, seed: int
) -> None:
    mu = 10**decade
    disk, contact = st.Disk(k=k), st.Viscous(mu)
    if family == "tumbling":
        at = min(at, 2.8)
    member = st.launch(family, at=at, tilt=0.0, disk=disk)
    direction = np.random.default_rng(seed).normal(size=6)
    six = member + 3e-4 * direction / np.linalg.norm(direction)
    p = np.array([k, mu])
    found = nearest(six, "viscous", p, 1e-3)
    verdict = st.spectrum(found.family, at=found.at, disk=disk, contact=contact, certify=True)
    if verdict.verdict is not st.Verdict.STABLE:
        assert not found.settled
        return
    if not found.settled:
        return  # it may be too far for its Lyapunov function
    span = 5 / abs(verdict.abscissa)
    run = st.simulate(disk, contact, six, [span], tolerance=1e-12)
    assert outcome(run) is not Outcome.LIFT_OFF
    _, e = deviation(last(run), k, found.family)
    assert np.linalg.norm(e) < found.distance
    assert abs(verdict.abscissa) > 0


def test_the_lyapunov_function_falls_along_a_settled_motion() -> None:
    from scipy.linalg import solve_continuous_lyapunov

    from stability.settling import _transverse

    disk, k, mu = st.Disk(), 0.25, 0.3
    start = st.launch("spinning", at=2.6, tilt=2e-4, disk=disk)
    run = st.simulate(disk, st.Viscous(mu), start, np.linspace(0, 60, 601), tolerance=1e-13)
    six = np.stack([run[n].values for n in STATES], axis=-1)
    at, e = deviation(six, k, "spinning")
    a = np.array(_transverse("viscous", "spinning")(float(at[-1]), 1.0, [k, mu], np.zeros(5))[0])
    p = solve_continuous_lyapunov(a.T, -np.eye(5))
    height = np.einsum("ti,ij,tj->t", e, p, e)
    assert (np.diff(height) < 0).all()
    assert math.sqrt(height[0] / height[-1]) > 100
