"""Sensitivities along a path, against closed forms and against displaced runs."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import casadi as ca
import numpy as np
import pytest

import stability as st
from stability.scene.ladder import climb
from stability.scene.rungs.sensitivities import CURVES, forward
from stability.scene.rungs.track import Refused
from stability.scene.uncertain import DISPLACED, SENSITIVITY, WASTED, apart
from tests.oracles.random_scenes import random_scene

NAMES = ("theta", "theta_dot", "phi_dot", "omega3", "slip_x", "slip_y")
ROLLED = {"theta": 1.2, "phi_dot": 0.1, "omega3": 1.6}
LIFTING = {"theta": 1.0, "theta_dot": -0.5, "phi_dot": 1.0, "omega3": -2.5}


def scene(contact: Any, start: Any, horizon: float, **more: Any) -> st.Scene:
    asked = {"tolerance": 1e-8, "quantities": ("final",), **more}
    return st.Scene(contact=contact, start=start, horizon=horizon, **asked)


def last(contact: Any, start: Any, horizon: float, disk: Any = None) -> Any:
    """The states at the end, by `simulate`."""
    run = st.simulate(disk or st.Disk(), contact, start, [horizon], tolerance=1e-13)
    return np.array([float(run[n].values[-1]) for n in NAMES])


def slopes(asked: st.Scene, only: str | None = None) -> Any:
    """Derivatives of the final states in the start and in the parameters, by the chosen model."""
    problem = asked._problem(asked.contact)
    found = climb(problem, asked.quantities, tuple(asked.models), only)
    n, m = problem.own, len(problem.p)
    starts = np.hstack([np.eye(n), np.zeros((n, m))])
    parameters = np.hstack([np.zeros((m, n)), np.diag(problem.p)])
    exact = found.model == problem.launches.name
    told = forward(problem, found.track, starts, parameters, exact=exact)
    assert not isinstance(told, Refused), told
    by_p = told.first[-1, -1, :, n:] / problem.p
    return found.model, told.first[-1, -1, :, :n], by_p


def differences(of: Any, at: float, step: float) -> Any:
    """A derivative by central differences with two steps, extrapolated by Richardson."""
    coarse, fine = ((of(at + h) - of(at - h)) / (2 * h) for h in (step, step / 2))
    return (4 * fine - coarse) / 3


# --- closed forms ---


def decay() -> tuple[st.System, st.ReducedModel]:
    """The system x' = -c x + y, y' = -y/eps, and the model of it without y."""
    z, p = ca.SX.sym("z", 2), ca.SX.sym("p", 2)
    both = st.System(
        "both",
        z,
        p,
        ca.vertcat(z[1] - p[0] * z[0], -z[1] / p[1]),
        states=("x", "y"),
        parameters=("c", "eps"),
    )
    x, c = ca.SX.sym("x"), ca.SX.sym("c")
    slow = st.System("slow", x, c, -c * x, states=("x",), parameters=("c",))
    return both, st.ReducedModel(
        "slow alone",
        slow,
        lambda states, p: (states[:1], p[:1]),
        lambda states, p: np.concatenate([states, 0 * states], axis=-1),  # noqa: ARG005
    )


@pytest.mark.parametrize("only", ["slow alone", "both"])
def test_linear_decay_has_the_sensitivities_of_its_closed_form(only: str) -> None:
    c, eps, x, horizon = 0.7, 1e-4, 0.8, 3.0
    system, model = decay()
    asked = st.Scene(
        system,
        {"c": c, "eps": eps},
        {"x": x, "y": 0.0},
        horizon,
        1e-6,
        models=[model],
        uncertain={"c": 1e-3, "x": 1e-4},
    )
    name, by_start, by_p = slopes(asked, only)
    assert name == only
    left = np.exp(-c * horizon)
    pull = 1 / (1 / eps - c)  # y at the start moves x by what it feeds while it decays
    expected = [[left, pull * (left - np.exp(-horizon / eps))], [0.0, np.exp(-horizon / eps)]]
    assert by_start == pytest.approx(np.array(expected), rel=1e-6, abs=1e-9)
    assert by_p[:, 0] == pytest.approx([-horizon * x * left, 0.0], rel=1e-6, abs=1e-12)
    told = asked.answer(only=only).spread
    assert set(told.routes.values()) == {SENSITIVITY}
    assert told.moves["final"]["x"] == pytest.approx(1e-4 * left, rel=1e-6)
    ends = [abs(x * np.exp(-c * (1 + s * 1e-3) * horizon) - x * left) for s in (-1, 1)]
    assert told.moves["final"]["c"] == pytest.approx(max(ends), rel=1e-5)


def test_a_pendulum_near_rest_has_the_sensitivities_of_its_linear_motion() -> None:
    z, w = ca.SX.sym("z", 2), ca.SX.sym("w")
    system = st.System(
        "pendulum",
        z,
        w,
        ca.vertcat(z[1], -(w**2) * ca.sin(z[0])),
        states=("q", "v"),
        parameters=("w",),
    )
    w0, q0, horizon = 2.0, 1e-5, 7.3
    asked = st.Scene(system, {"w": w0}, {"q": q0, "v": 0.0}, horizon, 1e-9)
    _, by_start, by_p = slopes(asked)
    turn = w0 * horizon
    expected = [[np.cos(turn), np.sin(turn) / w0], [-w0 * np.sin(turn), np.cos(turn)]]
    assert by_start == pytest.approx(np.array(expected), abs=1e-7)  # sin q - q is of order 1e-15
    by_w = [-horizon * np.sin(turn), -np.sin(turn) - turn * np.cos(turn)]
    assert by_p[:, 0] / q0 == pytest.approx(by_w, abs=2e-6)


# --- the disk ---


def test_sensitivities_are_the_derivatives_of_the_full_model() -> None:
    asked = scene(st.Viscous(0.7), ROLLED, 6.0, tolerance=1e-10)
    model, by_start, by_p = slopes(asked)
    assert model == "viscous"
    by_mu = differences(lambda mu: last(st.Viscous(mu), ROLLED, 6.0), 0.7, 4e-3)
    by_k = differences(lambda k: last(st.Viscous(0.7), ROLLED, 6.0, st.Disk(k=k)), 0.25, 1e-3)
    by_theta = differences(lambda v: last(st.Viscous(0.7), ROLLED | {"theta": v}, 6.0), 1.2, 2e-3)
    for mine, theirs in ((by_p[:, 1], by_mu), (by_p[:, 0], by_k), (by_start[:, 0], by_theta)):
        assert np.abs(mine - theirs).max() <= 1e-6 * np.abs(theirs).max()


@pytest.mark.parametrize(
    ("tolerance", "model", "horizon"),
    [
        pytest.param(1e-6, "creep-1", 12.0, marks=pytest.mark.long),
        pytest.param(1e-3, "rough", 12.0, marks=pytest.mark.long),
        (1e-3, "rough", 4.0),
    ],
)
def test_a_stiff_path_has_the_sensitivities_of_the_full_model(
    tolerance: float, model: str, horizon: float
) -> None:
    mu, start, share = 3e3, {"theta": 1.3, "omega3": 2.0}, 20 * tolerance
    name, by_start, by_p = slopes(scene(st.Viscous(mu), start, horizon, tolerance=tolerance))
    assert name == model
    by_mu = differences(lambda v: last(st.Viscous(v), start, horizon), mu, 0.02 * mu)
    by_theta = differences(lambda v: last(st.Viscous(mu), start | {"theta": v}, horizon), 1.3, 2e-3)
    for mine, theirs in ((by_p[:, 1], by_mu), (by_start[:, 0], by_theta)):
        assert np.abs(mine - theirs).max() <= share * np.abs(theirs).max()


def moved(quantity: str, width: dict[str, float], contact: Any, start: Any, horizon: float) -> Any:
    """A move by the sensitivity, and the same by two scenes at the ends."""
    [(name, by)] = width.items()
    asked = scene(contact, start, horizon, quantities=(quantity,), uncertain=width)
    answer = asked.answer()
    assert answer.spread.routes == {name: SENSITIVITY}
    ends = []
    for sign in (-1, 1):
        if name in start:
            ends.append(replace(asked, start=start | {name: start[name] + sign * by}, uncertain={}))
        else:
            law = st.Viscous(contact.mu * (1 + sign * by))
            ends.append(replace(asked, contact=law, uncertain={}))
    far = max(apart(answer.value, end.answer().value) for end in ends)
    return answer.spread.moves[quantity][name], far


@pytest.mark.parametrize("width", [{"omega3": 1e-3}, {"theta": 1e-4}, {"mu": 1e-3}])
def test_the_time_of_lift_off_moves_as_displaced_runs_say(width: dict[str, float]) -> None:
    mine, far = moved("lift_off_time", width, st.Viscous(3.0), LIFTING, 5.0)
    assert mine == pytest.approx(far, rel=1e-2)
    assert far > 1e-6


def test_the_largest_tilt_moves_as_displaced_runs_say() -> None:
    mine, far = moved("largest_tilt", {"theta": 1e-3}, st.Viscous(0.7), ROLLED, 6.0)
    assert mine == pytest.approx(far, rel=1e-3)
    assert far > 1e-4


@pytest.mark.few(1)
@pytest.mark.parametrize("width", [{"theta": 1e-4}, {"mu": 1e-3}])
def test_the_time_of_settling_moves_as_displaced_runs_say(width: dict[str, float]) -> None:
    start = {"theta": 1.5, "phi_dot": 6.0, "omega3": 0.1}
    mine, far = moved("settling_time", width, st.Viscous(0.3), start, 400.0)
    assert mine == pytest.approx(far, rel=2e-2)
    assert far > 1e-5


# --- where displaced runs decide ---


def test_an_outcome_that_changes_is_still_the_answer() -> None:
    asked = scene(st.Viscous(3.0), LIFTING, 5.0, quantities=("outcome",), tolerance=1e-6)
    near = replace(asked, start=LIFTING | {"omega3": -2.4006741})  # lifts off below -2.40167
    for width, ends in ((9e-4, ("moving", "moving")), (1.1e-3, ("lift-off", "moving"))):
        told = replace(near, uncertain={"omega3": width}).answer().spread
        assert told.routes["omega3"].startswith(DISPLACED)
        assert told.outcomes == {"omega3": ends}
        assert told.contrary == (("omega3",) if len(set(ends)) > 1 else ())
    told = replace(near, uncertain={"omega3": 1e-5}).answer().spread
    assert told.routes == {"omega3": SENSITIVITY}
    assert told.outcomes == {"omega3": ("moving", "moving")}


def test_a_large_uncertainty_is_not_linear() -> None:
    asked = scene(st.Viscous(0.7), ROLLED, 6.0, uncertain={"mu": 0.5, "theta": 1e-4})
    told = asked.answer().spread
    assert told.routes == {"mu": f"{DISPLACED}, because {CURVES}", "theta": SENSITIVITY}
    ends = [last(st.Viscous(mu), ROLLED, 6.0) for mu in (0.35, 1.05)]
    middle = last(st.Viscous(0.7), ROLLED, 6.0)
    far = max(apart(middle, end) for end in ends)
    assert told.moves["final"]["mu"] == pytest.approx(far, rel=1e-6)
    assert any(line.strip() == f"theta: {SENSITIVITY}" for line in told.lines())


def test_dry_friction_has_displaced_runs() -> None:
    asked = scene(st.Coulomb(0.3), ROLLED, 1.0, tolerance=1e-4, uncertain={"theta": 1e-3})
    told = asked.answer().spread
    assert told.routes["theta"].startswith(f"{DISPLACED}, because dry friction")
    ends = [last(st.Coulomb(0.3), ROLLED | {"theta": v}, 1.0) for v in (1.199, 1.2, 1.201)]
    far = max(apart(ends[1], ends[0]), apart(ends[1], ends[2]))
    assert told.moves["final"]["theta"] == pytest.approx(far, abs=2e-4)


def test_a_model_finer_than_the_inputs_is_called_wasted() -> None:
    asked = scene(
        st.Viscous(3e3),
        {"theta": 1.3, "omega3": 2.0},
        12.0,
        tolerance=1e-6,
        uncertain={"theta": 1e-2},
    )
    told = asked.answer()
    assert (told.model, told.spread.enough) == ("creep-1", "rough")
    truth = last(asked.contact, asked.start, 12.0)
    coarse = asked.answer(only="rough").value
    assert apart(truth, np.array(list(coarse.values()))) <= WASTED * told.spread.size
    assert any("finer than is of use" in line for line in told.spread.lines())
    sharp = replace(asked, uncertain={"theta": 1e-6}).answer()
    assert sharp.spread.enough == ""


# --- random scenes ---


def held(number: int) -> list[tuple[float, float]]:
    """Moves of a random smooth scene by sensitivities, and by displaced runs of the full model."""
    asked, _ = random_scene(number, 21)
    if asked.contact.sticks:
        return []
    rng = np.random.default_rng([21, number])
    widths = {n: 10 ** rng.uniform(-4, -1.5) for n in asked.contact.given}
    widths |= {"k": 10 ** rng.uniform(-4, -2), "theta": 10 ** rng.uniform(-6, -3)}
    asked = replace(
        asked, quantities=("final",), uncertain=widths, horizon=min(asked.horizon, 60.0)
    )
    try:
        told = asked.answer().spread
    except st.StabilityError:
        return []
    found = []
    for name in widths if told is not None else ():
        if told.routes[name] != SENSITIVITY:
            continue
        ends = [_displaced(asked, name, sign * widths[name]) for sign in (0, -1, 1)]
        far = max(apart(ends[0], ends[1]), apart(ends[0], ends[2]))
        mine = told.moves["final"][name]
        known = 0.05 * far + 0.1 * asked.tolerance + 1e-10
        assert abs(mine - far) <= known, (number, name, mine, far, asked)
        found.append((mine, far))
    return found


def _displaced(asked: st.Scene, name: str, by: float) -> Any:
    disk, law, start = asked.disk, asked.contact, np.array(asked.start, dtype=float)
    if name == "k":
        disk = st.Disk(k=disk.k * (1 + by))
    elif name == "theta":
        start[0] += by
    else:
        law = type(law)(**{n: v * (1 + by) for n, v in law.given.items()})
    return last(law, start, asked.horizon, disk)


def test_random_scenes_move_as_displaced_runs_of_the_full_model_say() -> None:
    found = [pair for number in (5, 6, 8) for pair in held(number)]
    assert len(found) > 5
    clear = [abs(mine - far) / far for mine, far in found if far > 1e-7]
    assert np.median(clear) < 1e-3


@pytest.mark.long
def test_many_random_scenes_move_as_displaced_runs_of_the_full_model_say() -> None:
    found = [pair for number in range(150) for pair in held(number)]
    assert len(found) > 100
