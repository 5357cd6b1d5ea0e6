"""The mean path of a ring: rates and frequencies by hand, energy, and integrated motions."""

import math

import casadi as ca
import numpy as np
import pytest
from ring_motion import Ring
from scipy.integrate import solve_ivp

import stability as st
from stability.boundary.mean_path import _Circling, retrograde_map

RANDOM = np.random.default_rng(20)


def members(count: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Inclinations and precession rates of circling with nutation, and moments of inertia."""
    theta, k = RANDOM.uniform(0.1, 1.4, count), RANDOM.uniform(0.25, 0.5, count)
    speed = RANDOM.uniform(0.85, 2.0, count) / np.sqrt(k * np.sin(theta))
    return theta, speed, k


def thin_ring(k: float) -> st.Body:
    return st.Body(lambda theta: ca.sin(theta), axial=2 * k, transverse=k)


def test_rates_and_frequencies_are_those_by_hand() -> None:
    theta, speed, k = members(40)
    share = RANDOM.uniform(0, 1, 40)
    rates, frequency = _Circling()(np.stack([theta, speed], axis=1), k, share)
    for i, air in enumerate(share):
        ring = Ring(k[i], 1 - air, air)
        assert rates[i] == pytest.approx(ring.drift(theta[i], speed[i]), rel=1e-9, abs=1e-11)
        assert frequency[i] == pytest.approx(ring.nutation(theta[i], speed[i]), rel=1e-9)


def test_the_slow_flow_of_two_numbers_is_the_same_and_loses_the_energy_of_the_moments() -> None:
    theta, speed, k = members(6)
    for kind, ring in (
        (st.RollingResistance(0.01), {"rho": 0.01}),
        (st.AirTorque(0.02), {"drag": 0.02}),
    ):
        for t, p, inertia in zip(theta, speed, k, strict=True):
            body = thin_ring(inertia)
            flow = st.slow_flow("circling", body=body, contact=st.Rough(), resistance=kind)
            found, hand, step = flow.rate([t, p]), Ring(inertia, **ring), 1e-5
            assert found == pytest.approx(hand.drift(t, p), rel=1e-9, abs=1e-12)
            slope = [
                (hand.energy(t + step, p) - hand.energy(t - step, p)) / (2 * step),
                (hand.energy(t, p + step) - hand.energy(t, p - step)) / (2 * step),
            ]
            assert found @ slope == pytest.approx(-hand.lost(t, p), rel=1e-7)
    with pytest.raises(st.StabilityError, match=r"named by theta and phi_dot; a drift has no"):
        flow.time(1.0, 0.5)
    with pytest.raises(st.StabilityError, match="give theta and phi_dot along its last axis"):
        flow.rate([0.5, 1.0, 2.0])


def test_near_flat_the_ratio_of_a_ring_at_rest_has_a_closed_form() -> None:
    """(Ω/φ̇)² = 3k/(k + 1) at θ = 0: up to the hoop, where it is 1, no ring at rest turns back."""
    for inner in (0.0, 0.6, 1.0):
        k, theta = (1 + inner**2) / 4, 1e-4
        at = np.array([[theta, 1 / math.sqrt(k * math.sin(theta))]])
        _, frequency = _Circling()(at, np.array([k]), np.array([0.0]))
        assert (frequency[0] / at[0, 1]) ** 2 == pytest.approx(3 * k / (k + 1), rel=1e-6)


@pytest.mark.few(1)
@pytest.mark.parametrize(
    ("inner", "share", "backward"),
    [(0.0, 0.0, False), (1.0, 0.0, True), (0.0, 1.0, True), (1.0, 1.0, True), (0.5, 0.0, False)],
)
def test_integrated_motions_turn_back_where_the_map_says(
    inner: float, share: float, backward: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The turn of the mean path changes sign there; the angle turned back is off by amplitude."""
    monkeypatch.setattr("stability.boundary.mean_path.FLAT", 0.15)
    chart = retrograde_map([inner], [share], starts=[(80.0, 1.0)])
    assert bool(chart.largest_ratio > 1) == backward
    k, size, theta = (1 + inner**2) / 4, 0.004, math.radians(80)
    ring = Ring(k, size * (1 - share), size * share)
    seen, turn = ring.mean_path(theta, 1 / math.sqrt(k * math.sin(theta)), 0.1, 0.15)
    mean = np.convolve(turn, np.ones(5) / 5, "valid")
    assert (mean.min() < -0.1) == backward
    assert backward or mean.min() > 0.05
    if backward:
        assert seen[2:-2][np.argmax(mean < 0)] == pytest.approx(chart.theta_back.item(), abs=0.015)
        angle = -turn[turn < 0].sum() * size
        assert angle == pytest.approx(chart.backward.item(), rel=0.15)


@pytest.mark.long
def test_the_map_does_not_depend_on_its_steps(monkeypatch: pytest.MonkeyPatch) -> None:
    points = ([0.0, 0.7, 1.0], [0.0, 0.3, 1.0])
    chart = retrograde_map(*points)
    monkeypatch.setattr("stability.boundary.mean_path.STEP", 0.02)
    fine = retrograde_map(*points)
    np.testing.assert_allclose(chart.largest_ratio, fine.largest_ratio, rtol=1e-3)
    np.testing.assert_allclose(chart.backward, fine.backward, atol=0.02)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"inner": [0.5, 0.2]}, "give rising numbers"),
        ({"share": [0.0, 1.2]}, r"must lie in \[0, 1\]"),
        ({"starts": [(95.0, 1.0)]}, "between 3 and 89 degrees"),
        ({"starts": [3]}, "give .theta in degrees, speed."),
    ],
)
def test_what_is_no_map_is_refused(given: dict, words: str) -> None:  # type: ignore[type-arg]
    with pytest.raises(st.StabilityError, match=words):
        retrograde_map(**given)


@pytest.mark.long
@pytest.mark.parametrize(("mu", "backward"), [(100.0, False), (300.0, True)])
def test_slip_hides_the_turn_of_a_hoop(mu: float, backward: bool) -> None:
    """With viscous friction the nutation dies out, unless the slip is far below the resistance."""
    body = thin_ring(0.5)
    flow = st.slow_flow(
        "tumbling", body=body, contact=st.Viscous(mu), resistance=st.RollingResistance(0.01)
    )
    system = flow.disturbed
    p = [(flow.numbers | {"rho": 0.01})[n] for n in system.parameters]
    rates = ca.Function("rates", [system.x, system.p], [system.rhs])
    theta = math.radians(80)
    start = [theta, 0.3, 1 / math.sqrt(0.5 * math.sin(theta)), 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]

    def along(_: float, y: np.ndarray) -> np.ndarray:
        speed = y[4] + math.sin(y[0]) * y[1] + 1j * (y[5] - y[3])
        speed *= np.exp(1j * y[6])
        return np.concatenate([np.array(rates(y[:6], p)).ravel(), [y[2], speed.real, speed.imag]])

    def highest(_: float, y: np.ndarray) -> float:
        return float(y[1])

    def low(_: float, y: np.ndarray) -> float:
        return float(y[0] - 0.12)

    highest.direction, low.terminal = -1, True  # type: ignore[attr-defined]
    path = solve_ivp(along, (0, 600), start, "LSODA", events=[highest, low], rtol=1e-8, atol=1e-10)
    assert path.status == 1
    shift = np.diff(path.y_events[0][:, 7] + 1j * path.y_events[0][:, 8])
    mean = np.convolve(np.angle(shift[1:] / shift[:-1]), np.ones(5) / 5, "valid")
    assert (mean.min() < -0.05) == backward
