"""Guards that dip below zero by very little: with any steps the first zero ends the run."""

import casadi as ca
import numpy as np
import pytest

import stability as st
from stability.integrators.sundials import lowest

GRAZING = 1.2749966762959954
"""Angular velocity at which the normal force of the launch below touches zero."""


@pytest.mark.parametrize("method", ["cvodes", "lsoda", "radau"])
@pytest.mark.parametrize("last", [17.0, 17.5, 18.0])
def test_a_shallow_dip_of_the_normal_force_is_a_lift_off(method: str, last: float) -> None:
    """Near one end of an interval; at 16.5595, as by the Taylor series of 1e-14."""
    start = [np.pi / 2 - 0.1, 0, 0, GRAZING + 2e-7, 0, 0]
    run = st.simulate(
        st.Disk(), st.Viscous(0.3), start, [last], tolerance=1e-11, method=method, check=False
    )
    assert run.attrs["outcome"] == "lift-off"
    assert float(run.end_time) == pytest.approx(16.5594595, abs=2e-6)


@pytest.mark.few(4)
@pytest.mark.parametrize("unit", [1e-6, 1.0, 1e3])
@pytest.mark.parametrize("depth", [1e-4, 1e-7, -1e-7])
@pytest.mark.parametrize("method", ["cvodes", "radau", "bdf", "lsoda", "heyoka", "dop853"])
def test_a_turn_that_just_crosses_a_line(method: str, depth: float, unit: float) -> None:
    """A stiff state follows a turn about a circle; the angle at the line is known."""
    y = ca.SX.sym("y", 3)
    rates = ca.vertcat(-y[1], y[0], -500 * (y[2] - y[0])) / unit
    for angle in np.random.default_rng(8).uniform(0.5, 6.0, 3).tolist():
        left = 1 - depth - (y[0] * np.cos(angle) + y[1] * np.sin(angle))
        system = st.System(
            "turn",
            y,
            ca.SX.sym("p", 0),
            rates,
            states=("c", "s", "z"),
            conditions=(st.Condition(left, "left = {value}"),),
        )
        run = st.simulate(
            system, None, [1.0, 0.0, 1.0], [6.2 * unit], tolerance=1e-11, method=method, check=False
        )
        assert run.attrs["outcome"] == ("domain-end" if depth > 0 else "moving")
        if depth > 0:
            crossing = angle - np.arccos(1 - depth)
            assert float(run.end_time) / unit == pytest.approx(crossing, abs=1e-5)


def test_the_lowest_point_of_a_cubic_is_that_of_its_roots() -> None:
    rng = np.random.default_rng(2)
    for _ in range(200):
        cubic = np.polynomial.Polynomial(rng.normal(size=4) * 10.0 ** rng.integers(-3, 4, 4))
        slope = cubic.deriv()
        found = float(lowest(*(np.array(v) for v in (cubic(0), cubic(1), slope(0), slope(1)))))
        turns = [t.real for t in slope.roots() if abs(t.imag) < 1e-12 and 0 < t.real < 1]
        right = min((cubic(t) for t in turns if slope.deriv()(t) > 0), default=np.inf)
        assert found == pytest.approx(right, rel=1e-9, abs=1e-9)
    assert lowest(*(np.array(v) for v in (1.0, 2.0, 0.0, 2.0))) == np.inf  # rises from the start
