"""A disk that rolls in a circle without slip: closed forms and Kane's method.

Le Saux, Leine & Glocker, J. Nonlinear Sci. 15 (2005) 27-61, eq. (5.10)-(5.12), give spin and
precession.  The balance of moments about the contact point gives the nutation.  The disk is theirs.
"""

import math

import numpy as np
import pytest
from kane_disk import kane
from scipy.optimize import brentq

import stability as st

K, DISK = 0.25, st.Disk(mass=1.0, radius=0.05, gravity=9.81)
RATE = math.sqrt(9.81 / 0.05)


def relation(lean: float, ratio: float) -> float:
    """Spin relative to the turning frame [rad/s]; ratio is the disk's radius over the circle's."""
    return RATE * math.sqrt(
        math.tan(lean) / (ratio * ((1 + 2 * K) - (1 + K) * ratio * math.sin(lean)))
    )


def nutation(lean: float, turn: float) -> float:
    """Square of the frequency of nutation [1/s²]: the balance of moments at a circle."""
    s, c, z = math.cos(lean), math.sin(lean), (turn / RATE) ** 2
    across = 2 * c**2 * (1 + K * z * s) * (1 + (K + 1) * z * s) / ((2 * K + 1) * s**2 * z)
    return RATE**2 * (z * s**2 + (across - 1 / s) / (K + 1))


def slopes(x: list[float]) -> np.ndarray:
    """Jacobian of SymPy's Kane equations of the rough disk by central differences of rates."""
    step = 1e-5

    def rates(state: np.ndarray) -> np.ndarray:
        six = np.concatenate([state, np.zeros((*state.shape[:-1], 2))], axis=-1)
        return kane("rough", six, np.broadcast_to([K, 0.0], (*state.shape[:-1], 2))).rates[..., :4]

    moved = np.array(x) + step * np.vstack([np.eye(4), -np.eye(4), 2 * np.eye(4), -2 * np.eye(4)])
    one, back, two, far = np.split(rates(moved), 4)
    return np.asarray((8 * (one - back) - (two - far)) / (12 * step)).T


@pytest.mark.parametrize(("lean", "ratio"), [(5, 0.1), (20, 0.1), (20, 0.5), (45, 0.5), (60, 1.0)])
def test_circles_are_those_of_the_closed_forms_and_of_kanes_method(lean: int, ratio: float) -> None:
    spin = relation(math.radians(lean), ratio)
    turn, theta = ratio * spin, math.pi / 2 - math.radians(lean)
    member = st.disk_family("circling", "rough").member([theta, turn / RATE], [K])
    assert abs(member[3] * RATE - turn * math.cos(theta)) == pytest.approx(spin, rel=1e-12)
    kanes = [theta, 0.0, turn / RATE, member[3]]
    assert abs(kane("rough", [*kanes, 0, 0], [K, 0.0]).rates).max() < 1e-13
    fast = max(np.linalg.eigvals(slopes(kanes)), key=abs)
    found = st.spectrum("circling", at=(theta, turn), disk=DISK, contact=st.Rough(), certify=True)
    assert found.certified and found.verdict is st.Verdict.NEUTRAL
    nodding = abs(found.eigenvalues).max()
    assert nodding == pytest.approx(math.sqrt(nutation(math.radians(lean), turn)), rel=1e-10)
    assert nodding == pytest.approx(abs(fast) * RATE, rel=1e-8)
    assert abs(fast.real) < 1e-6


@pytest.mark.parametrize("lean", [5, 10, 15])
def test_unstable_precessions_end_where_both_frequencies_vanish(lean: int) -> None:
    theta = math.pi / 2 - math.radians(lean)

    def square(turn: float) -> float:
        """The square of the frequency, from equations of Kane's method."""
        s, c, turn = math.sin(theta), math.cos(theta), turn / RATE
        omega3 = c * (K * turn**2 * s - 1) / ((2 * K + 1) * turn * s)
        matrix = slopes([theta, 0.0, turn, omega3])
        return -float(np.trace(matrix @ matrix)) / 2  # two zeros, and a pair

    found = st.boundaries(
        "circling", axis=("phi_dot", 0.5, 16, 9), at=theta, disk=DISK, contact=st.Rough()
    )
    sides = [(theta, point.value * (1 + side)) for point in found for side in (-1e-12, 1e-12)]
    near = st.spectrum("circling", at=sides, disk=DISK, contact=st.Rough(), certify=True)
    assert [v.word for v in near.verdict] == ["neutral", "unstable", "unstable", "neutral"]
    assert near.certified.all()
    for point in found:
        ends = 0.99 * point.value, 1.01 * point.value
        assert brentq(square, *ends, xtol=1e-10) == pytest.approx(point.value, rel=1e-7)
        closed = brentq(lambda turn: nutation(math.radians(lean), turn), *ends, xtol=1e-13)
        assert closed == pytest.approx(point.value, rel=1e-9)


def test_a_simulated_turn_runs_round_the_circle_of_the_paper() -> None:
    lean, ratio = math.radians(5), 0.1
    turn, theta = ratio * relation(lean, ratio), math.pi / 2 - lean
    omega3 = st.disk_family("circling", "rough").member([theta, turn / RATE], [K])[3] * RATE
    start = {"theta": theta, "phi_dot": turn, "omega3": omega3}
    run = st.simulate(DISK, st.Rough(), start, np.linspace(0, 2 * math.pi / turn, 5), pose=True)
    x, y = run.contact_x.values, run.contact_y.values  # a quarter of a turn apart
    assert math.hypot(x[2] - x[0], y[2] - y[0]) / 2 == pytest.approx(0.05 / ratio, rel=2e-10)
