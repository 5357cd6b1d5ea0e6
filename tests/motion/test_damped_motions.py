"""Stated errors where a method damps what the equations let grow, against closed forms."""

import warnings

import casadi as ca
import numpy as np
import pytest
from damped_motions import motion
from scipy.integrate import solve_ivp

import stability as st

METHODS = ("auto", "heyoka", "dop853", "lsoda", "radau", "bdf", "cvodes")


def wells(stiff: bool) -> st.System:
    """A ball between two wells, and a stiff state that follows."""
    x = ca.SX.sym("x", 3 if stiff else 2)
    rates = [x[1], x[0] - x[0] ** 3 - 0.2 * x[1]]
    if stiff:
        rates.append(-2000 * (x[2] - x[0]))
    names = ("x", "v", "z")[: len(rates)]
    return st.System("wells", x, ca.SX.sym("p", 0), ca.vertcat(*rates), states=names)


@pytest.mark.few(3)
@pytest.mark.parametrize("tolerance", [1e-2, 1e-4, 1e-6])
@pytest.mark.parametrize("method", ["auto", "cvodes", "radau", "bdf", "lsoda"])
def test_a_ball_that_is_damped_on_a_hill_has_an_error_without_a_bound(
    method: str, tolerance: float
) -> None:
    system = wells(stiff=method == "auto")
    start = [1e-12] + [0.0] * (len(system.states) - 1)
    with pytest.warns(st.StabilityWarning, match="the error of the final state has no bound"):
        run = st.simulate(system, None, start, [50.0], tolerance=tolerance, method=method)
    assert float(run.final_error) == np.inf  # right is 1.03


def test_a_scene_on_a_hill_does_not_claim_its_tolerance() -> None:
    start = {"x": 1e-12, "v": 0.0, "z": 0.0}
    answer = st.Scene(wells(stiff=True), {}, start, horizon=50.0, tolerance=1e-2).answer()
    assert not answer.estimate <= 1e-2


def test_a_ball_at_rest_on_the_hill_stays_and_is_sure() -> None:
    run = st.simulate(wells(stiff=True), None, [0.0, 0.0, 0.0], [50.0], tolerance=1e-4)
    assert float(run.x[-1]) == 0.0
    assert float(run.final_error) < 1e-6


def check(seed: int) -> str:
    """What a random run states: *bounded*, *unbounded* or another outcome."""
    rng = np.random.default_rng(seed)
    case, tolerance = motion(rng), float(10 ** rng.uniform(-10, -2))
    method = str(rng.choice(METHODS if len(case.start) == 2 else ("auto", *METHODS[3:])))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", st.StabilityWarning)
        run = st.simulate(
            case.system, None, case.start, [case.last], tolerance=tolerance, method=method
        )
    if run.attrs["outcome"] != "moving":
        return str(run.attrs["outcome"])
    error, stated = case.error(run), float(run.final_error)
    assert error <= stated, (seed, case.name, method, tolerance)
    return "unbounded" if stated == np.inf else "bounded"


@pytest.mark.parametrize("seed", [11, 72, 112, 116, 168, 195])
def test_a_motion_that_neighbours_damp_states_an_error_that_is_not_too_small(seed: int) -> None:
    check(seed)


@pytest.mark.long
def test_random_motions_state_no_error_that_is_too_small() -> None:
    found = [check(seed) for seed in range(1000, 1400)]
    assert found.count("bounded") > 200


@pytest.mark.long
def test_twelve_jumps_have_an_error_with_a_bound() -> None:
    """Van der Pol's relaxation, whose errors grow ten million times in a jump and shrink again."""
    y, mu = ca.SX.sym("y", 2), 1000.0
    system = st.System(
        "relaxation",
        y,
        ca.SX(0, 1),
        ca.vertcat(y[1], mu * (1 - y[0] ** 2) * y[1] - y[0]),
        states=("x", "v"),
        parameters=(),
    )

    def slope(_: float, y: np.ndarray) -> list[list[float]]:
        return [[0, 1], [-2 * mu * y[0] * y[1] - 1, mu * (1 - y[0] ** 2)]]

    right = solve_ivp(
        lambda _, y: [y[1], mu * (1 - y[0] ** 2) * y[1] - y[0]],
        (0, 1e4),
        [2.0, 0.0],
        method="Radau",
        rtol=1e-11,
        atol=1e-12,
        jac=slope,
    )
    for tolerance in (1e-6, 1e-9):
        run = st.simulate(system, None, [2.0, 0.0], [1e4], tolerance=tolerance)
        error = abs(float(run.x[-1]) - right.y[0, -1])
        assert error < float(run.final_error) < 1e4 * tolerance
