"""Growth of errors along a path, against closed forms."""

import casadi as ca
import numpy as np
import pytest
from scipy.linalg import expm

import stability as st
from stability.base.types import Floats
from stability.bodies.model import system_model
from stability.integrators.flow import Flow, flow_of
from stability.integrators.leg import Leg
from stability.integrators.scipy_methods import Trail, integrate
from stability.motion.error_estimate import exponentials, growth, growth_along


def flow(rates: ca.SX, y: ca.SX) -> Flow:
    names = tuple("xyz"[: y.numel()])
    return flow_of(system_model(st.System("plane", y, ca.SX.sym("p", 0), rates, states=names)))


def grown(rates: ca.SX, y: ca.SX, times: Floats, path: Floats) -> float:
    """The growth along a path, with further entries of the flow's y as zeros."""
    which = flow(rates, y)
    whole = np.zeros((len(path), len(which.names)))
    whole[:, : y.numel()] = path
    return growth(which, np.empty(0), times, whole).largest


@pytest.mark.parametrize("stiff", [3.0, 1e7])
def test_errors_grow_from_a_saddle_like_its_fastest_mode(stiff: float) -> None:
    y = ca.SX.sym("y", 2)
    times = np.linspace(0.0, 20.0, 65)
    path = np.full((65, 2), 1e-12)
    found = grown(ca.vertcat(0.9 * y[0], -stiff * y[1]), y, times, path)
    assert found == pytest.approx(np.sqrt(np.exp(1.8 * times).sum()), rel=1e-7)


def test_a_state_that_is_always_zero_has_no_error() -> None:
    y = ca.SX.sym("y", 2)
    times, path = np.linspace(0.0, 20.0, 65), np.zeros((65, 2))
    path[:, 1] = np.exp(-times)
    rates = ca.vertcat(y[0], -y[1])
    assert grown(rates, y, times, path) < 2
    assert grown(rates, y, times, path + 1e-300) > 1e8


def test_an_error_relative_to_a_state_that_grows_alike_does_not_grow() -> None:
    y = ca.SX.sym("y", 1)
    times = np.linspace(0.0, 30.0, 257)
    path = np.exp(times)[:, None]
    found = grown(y, y, times, path)
    assert found == pytest.approx(np.sqrt(257), rel=1e-6)


def test_an_error_along_a_delayed_bifurcation_grows_from_its_middle() -> None:
    y = ca.SX.sym("y", 2)
    times = np.linspace(0.0, 8.0, 257)
    path = np.column_stack([np.full(257, 1e-200), times - 4.0])
    found = grown(ca.vertcat(y[1] * y[0], 1 + 0 * y[0]), y, times, path)
    after = np.sqrt(np.exp(16.0 - (times - 4.0) ** 2).sum())
    assert found == pytest.approx(after, rel=1e-2)


def test_a_jump_lets_errors_grow_and_shrink_again() -> None:
    """Van der Pol's: on the slow branch an error is one of time, as before the jump.

    The oracle is the ratio of speeds of the motion itself, which solves the linearised equations.
    """
    y, mu = ca.SX.sym("y", 2), 1000.0
    which = flow(ca.vertcat(y[1], mu * (1 - y[0] ** 2) * y[1] - y[0]), y)
    start, no = which.pack(np.array([2.0, 0.0])), np.empty(0)
    times = np.array([0.0, 1000.0])
    trail: Trail = []
    path = integrate(Leg(which, no, start, times, 1e-12, 10**6), solver="LSODA", trail=trail)
    along = growth_along(which, no, trail)
    assert path.states[-1, 0] < -1  # it has jumped
    speeds = np.array([abs(float(state[1])) for _, state, _ in trail])
    assert along.last < 100 * speeds[-1] / speeds[100:].min()
    assert along.largest > speeds.max() / speeds[-1]
    coarse = np.linspace(0, 1000, 257)
    fine = integrate(Leg(which, no, start, coarse, 1e-12, 10**6), solver="LSODA")
    assert growth(which, no, coarse, fine.states).last > 10 * along.last


def test_exponentials_are_those_of_scipy() -> None:
    matrices = (
        np.random.default_rng(4).normal(size=(5, 6, 6)) * np.geomspace(0.01, 30, 5)[:, None, None]
    )
    for found, matrix in zip(exponentials(matrices), matrices, strict=True):
        right = expm(matrix)
        assert np.abs(found - right).max() < 1e-11 * np.abs(right).max()
