"""Times of slow drift against motions under resistance: order in the coefficient, ends of families.

A drift of rate |y - end|^p reaches the end in finite time for p < 1, and never for p ≥ 1.
"""

import math
from collections.abc import Sequence

import casadi as ca
import numpy as np
import pytest

import stability as st

SIZES = np.array([4e-3, 2e-3, 1e-3, 5e-4])
"""Coefficients at which an order is fitted."""
NUMBER = {"rolling": "omega3", "spinning": "phi_dot", "tumbling": "theta"}
LYING = math.pi / 2


def _flow(
    family: str, body: st.Body, resistance: st.Resistance, mu: float = 0.5
) -> tuple[st.SlowFlow, st.Viscous]:
    law = st.Viscous(mu)
    return st.slow_flow(family, body=body, contact=law, resistance=resistance), law


def _member(flow: st.SlowFlow, at: float) -> np.ndarray:
    return flow.family.member([at], [flow.numbers[n] for n in flow.family.parameters])


def order(sizes: Sequence[float], gaps: Sequence[float]) -> float:
    """Exponent of the best fit gap = C size^p."""
    return float(np.polyfit(np.log(sizes), np.log(gaps), 1)[0])


@pytest.mark.few(1)
@pytest.mark.parametrize(
    ("body", "family", "start", "end", "kind"),
    [
        (st.Torus(0.2), "rolling", 3.0, 2.4, st.RollingResistance),
        (st.Spheroid(0.5), "tumbling", 0.7, 0.6, st.AirTorque),
        (st.ThickDisk(0.3), "tumbling", 0.8, 0.7, st.RollingResistance),
        (st.Egg(0.2), "tumbling", 1.2, 1.3, st.AirTorque),
    ],
    ids=["torus", "spheroid", "thick disk", "egg"],
)
def test_a_motion_is_at_the_member_after_the_stated_time(
    body: st.Body, family: str, start: float, end: float, kind: type[st.Resistance]
) -> None:
    gaps = []
    for small in SIZES:
        flow, law = _flow(family, body, kind(float(small)))
        time = flow.time(start, end)
        run = st.simulate(
            body,
            law,
            _member(flow, start),
            [0.0, time],
            resistance=kind(float(small)),
            tolerance=1e-11,
            check=False,
        )
        assert len(run.time) == 2
        gaps.append(abs(float(run[NUMBER[family]][-1]) - end))
    assert gaps[-1] < 0.05 * abs(end - start)
    assert order(SIZES, gaps) == pytest.approx(1, abs=0.07)


def test_spinning_keeps_the_stated_time_to_the_end_exactly() -> None:
    """Upright turning under pivoting: every motion on the family stays on it."""
    body = st.Torus(0.3, solid=False)
    flow, law = _flow("spinning", body, st.PivotingResistance(0.01))
    time = flow.time(4.0, 3.2)
    run = st.simulate(
        body,
        law,
        _member(flow, 4.0),
        [0.0, time],
        resistance=st.PivotingResistance(0.01),
        tolerance=1e-12,
        check=False,
    )
    assert float(run.phi_dot[-1]) == pytest.approx(3.2, rel=1e-9)


def _hits(
    body: st.Body | st.Disk,
    law: st.Viscous,
    start: np.ndarray,
    last: float,
    resistance: st.Resistance,
    distances: Sequence[float],
    end: float,
) -> list[float]:
    """Times at which a motion first comes within distances of an end."""
    run = st.simulate(
        body,
        law,
        start,
        np.linspace(0, last, 8001),
        resistance=resistance,
        tolerance=1e-11,
        check=False,
    )
    gap, times = np.abs(run.theta.values - end), run.time.values
    found = []
    for distance in distances:
        i = int(np.argmax(gap < distance))
        assert gap[i] < distance <= gap[i - 1]
        part = (gap[i - 1] - distance) / (gap[i - 1] - gap[i])
        found.append(float(times[i - 1] + part * (times[i] - times[i - 1])))
    return found


def test_a_spinning_egg_lies_down_in_finite_time_under_drag() -> None:
    """A prolate spheroid tumbles towards lying: there its energy is stationary, and drag is not.

    So the rate grows like 1/distance.  In simulations the time over the coefficient tends to that
    of the slow flow: in first order away from the end, and in order 2/3 next to it, where the
    eigenvalue across the family falls with the square of the distance.
    """
    body, mu, start = st.Spheroid(1.7), 0.1, LYING - 0.5
    sizes, distances = np.array([4e-4, 2e-4, 1e-4]), (0.4, 0.1)
    flow, law = _flow("tumbling", body, st.AirTorque(1.0), mu)
    assert flow.exponent(LYING, LYING - 0.2) == pytest.approx(-1, abs=0.01)
    ends = [flow.time(start, LYING - d) for d in (0.04, 0.02, 0.01)]
    assert (ends[1] - ends[0]) / (ends[2] - ends[1]) == pytest.approx(4, rel=0.02)  # as a square
    known = np.array([flow.time(start, LYING - d) for d in distances])
    scaled = []
    for small in sizes:
        hits = _hits(
            body,
            law,
            _member(flow, start),
            2 * known[-1] / small,
            st.AirTorque(float(small)),
            distances,
            LYING,
        )
        scaled.append(np.array(hits) * small)
    gaps = np.abs(np.array(scaled) - known)
    assert order(sizes, gaps[:, 0]) == pytest.approx(1, abs=0.1)
    assert order(sizes, gaps[:, 1]) == pytest.approx(2 / 3, abs=0.1)
    assert (gaps[-1] < [0.04 * known[0], 0.1 * known[1]]).all()


@pytest.mark.long
def test_rolling_resistance_lets_it_lie_down_never() -> None:
    """Lying, it turns on the spot, where rolling resistance takes nothing: exponent 1."""
    body, mu, small = st.Spheroid(1.7), 0.1, 1e-3
    flow, law = _flow("tumbling", body, st.RollingResistance(small), mu)
    assert flow.exponent(LYING, LYING - 0.05) == pytest.approx(1, abs=2e-3)
    distances = (0.2, 0.1, 0.05, 0.025)
    last = 1.05 * flow.time(LYING - 0.3, LYING - distances[-1])
    hits = _hits(
        body, law, _member(flow, LYING - 0.3), last, st.RollingResistance(small), distances, LYING
    )
    halvings = np.diff(hits)
    assert halvings == pytest.approx(halvings[-1], rel=0.02)
    known = [
        flow.time(LYING - a, LYING - b) for a, b in zip(distances, distances[1:], strict=False)
    ]
    assert halvings == pytest.approx(known, rel=0.01)


@pytest.mark.few(1)
@pytest.mark.parametrize(
    ("kind", "power", "distances"),
    [
        (st.AirTorque, 1, (0.4, 0.2, 0.1, 0.05)),
        (st.RollingResistance, 1, (0.4, 0.2, 0.1)),
        (st.PivotingResistance, 3, (0.4, 0.2, 0.1)),
    ],
)
def test_a_falling_disk_is_as_slow_as_its_exponent_says(
    kind: type[st.Resistance], power: int, distances: tuple[float, ...]
) -> None:
    """Each halving of the inclination takes 2^(p - 1) times as long as the one before."""
    disk, resistance = st.Disk(k=0.25), kind(4e-3)
    flow, law = _flow(
        "tumbling", st.Body(lambda t: ca.sin(t), axial=0.5, transverse=0.25), resistance
    )
    assert flow.exponent(0.0, 0.02) == pytest.approx(power, abs=1e-3)
    known = [flow.time(0.8, d) for d in distances]
    hits = _hits(disk, law, _member(flow, 0.8), 1.05 * known[-1], resistance, distances, 0.0)
    assert hits == pytest.approx(known, rel=0.02)
    halvings = np.diff(hits)
    assert math.log2(halvings[-1] / halvings[-2]) + 1 == pytest.approx(power, abs=0.1)
