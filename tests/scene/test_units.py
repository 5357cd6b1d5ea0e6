"""Answers in SI are those without dimension, scaled by the similarity of motions."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np
import pytest

import stability as st
from stability.base.quantities import Kind
from stability.scene.linear import LINEAR
from stability.scene.questions import QUESTIONS, Estimate, Question
from stability.scene.rungs.track import LaunchProblem, Track
from tests.tools.similarity import size

SCALES = (0.6, 0.04, 3.0)
"""Mass, length and gravity."""
STATES = {
    "theta": "rad",
    "theta_dot": "rad/s",
    "phi_dot": "rad/s",
    "omega3": "rad/s",
    "slip_x": "m/s",
    "slip_y": "m/s",
}
FIXED = {"axis": "1", "omega": "rad/s", "slip": "m/s"}
ROLLS = {"theta": 1.45, "theta_dot": 0.05, "phi_dot": 0.02, "omega3": 2.0}


def si(unit: str) -> float:
    return size(unit, *SCALES)


@dataclass(frozen=True)
class Pair:
    """A launch without dimension, and the same in SI."""

    body: Callable[..., Any]
    """Body from `mass`, `gravity` and its length."""
    length: str
    law: Callable[..., st.Contact]
    given: dict[str, tuple[float, str]]
    """Parameters of the law without dimension, with their SI units."""
    start: dict[str, float]

    def scene(self, *, dimensionless: bool, horizon: float, **more: Any) -> st.Scene:
        def one(unit: str) -> float:
            return 1.0 if dimensionless else si(unit)

        mass, length, gravity = (1.0, 1.0, 1.0) if dimensionless else SCALES
        body = self.body(mass=mass, gravity=gravity, **{self.length: length})
        law = self.law(**{n: v * one(unit) for n, (v, unit) in self.given.items()})
        start = {n: v * one(STATES[n]) for n, v in self.start.items()}
        return st.Scene(body, law, start, horizon * one("s"), **more)

    def answers(self, horizon: float, **more: Any) -> tuple[st.Answer, st.Answer]:
        plain, scaled = (
            self.scene(dimensionless=d, horizon=horizon, **more).answer() for d in (True, False)
        )
        return plain, scaled


def disk(law: Any, start: dict[str, float], **given: tuple[float, str]) -> Pair:
    return Pair(st.Disk, "radius", law, given, start)


def torus(**scales: Any) -> st.Body:
    return st.Torus(0.3, **scales)


def egg(**scales: Any) -> st.Body:
    return st.Spheroid(1.4, **scales)


VISCOUS = {"mu": (0.8, "s/m")}
SLIPS = ROLLS | {"slip_x": 0.3, "slip_y": -0.1}
PAIRS = {
    "viscous": disk(st.Viscous, SLIPS, **VISCOUS),
    "linear": disk(st.LinearViscous, SLIPS, c=(0.8, "kg/s")),
    "linear by mu": disk(st.LinearViscous, SLIPS, mu=(0.8, "s/m")),
    "rough": disk(st.Rough, ROLLS),
    "smooth": disk(st.Smooth, ROLLS),
    "coulomb": disk(st.Coulomb, SLIPS, mu=(0.3, "1")),
    "torus": Pair(torus, "length", st.Viscous, VISCOUS, SLIPS),
    "egg": Pair(egg, "length", st.Viscous, VISCOUS, SLIPS),
    "rough torus": Pair(torus, "length", st.Rough, {}, ROLLS),
}


def close(found: Any, expected: float) -> bool:
    """Whether two numbers agree; both are those of one computation but for rounding."""
    return bool(found == pytest.approx(expected, rel=1e-6, abs=1e-9 * max(1.0, abs(expected))))


def unit_of_state(name: str) -> str:
    return STATES.get(name) or FIXED[name.split("_")[0]]


@pytest.mark.parametrize("name", PAIRS)
def test_questions_of_a_motion_are_similar(name: str) -> None:
    asked = ("final", "path", "outcome", "settling_time", "lift_off_time", "largest_tilt")
    plain, scaled = PAIRS[name].answers(3.0, quantities=asked)
    assert plain.value["outcome"] == scaled.value["outcome"]
    assert plain.value["largest_tilt"] == pytest.approx(scaled.value["largest_tilt"], rel=1e-7)
    assert scaled.until == pytest.approx(plain.until * si("s"))
    for state, value in plain.value["final"].items():
        assert close(scaled.value["final"][state] / si(unit_of_state(state)), value), state
        expected = si(unit_of_state(state))
        assert scaled.measures[state][1] == pytest.approx(expected), state
    for state in plain.value["final"]:
        one, other = (a.path[state] for a in (plain, scaled) if a.path is not None)
        assert np.allclose(other / si(unit_of_state(state)), one, rtol=1e-6, atol=1e-8)
        assert other.attrs["units"] == unit_of_state(state)


LIFTS = {"theta": 1.0, "theta_dot": -0.5, "phi_dot": 1.0, "omega3": -2.5}
ENDS = {
    "lift_off_time": (disk(st.Viscous, LIFTS, mu=(3.0, "s/m")), 5.0),
    "settling_time": (disk(st.Viscous, {"theta": 1.5, "phi_dot": 6.0}, mu=(0.3, "s/m")), 400.0),
}


@pytest.mark.parametrize("asked", ENDS)
def test_times_are_similar(asked: str) -> None:
    pair, horizon = ENDS[asked]
    plain, scaled = pair.answers(horizon, quantities=asked)
    assert plain.value is not None and plain.value > 0
    assert scaled.value / si("s") == pytest.approx(plain.value, rel=1e-5)
    assert scaled.estimate == pytest.approx(plain.estimate, rel=0.5)
    assert scaled.measures[asked] == ("s", pytest.approx(si("s")))


@pytest.mark.parametrize("name", ["viscous", "linear", "rough", "torus", "egg"])
@pytest.mark.parametrize("asked", LINEAR)
def test_linear_questions_are_similar(name: str, asked: str) -> None:
    unit = {"growth_rate": "1/s", "boundary": "rad/s"}.get(asked, "1")
    plain, scaled = PAIRS[name].answers(1.0, quantities=asked)
    if not isinstance(plain.value, float):
        assert scaled.value == plain.value
        return
    assert close(scaled.value / si(unit), plain.value)
    assert scaled.measures[asked] == (unit, pytest.approx(si(unit)))
    assert max(scaled.estimate, plain.estimate) < 1e-11


def test_a_boundary_in_theta_is_an_angle() -> None:
    plain, scaled = disk(st.Viscous, {"theta": 0.9, "phi_dot": 2.2}, **VISCOUS).answers(
        1.0, quantities="growth_rate"
    )
    assert plain.sentence.startswith("tumbling at") and scaled.sentence.startswith("tumbling at")
    assert plain.sentence.split(",")[0] == scaled.sentence.split(",")[0]


@pytest.mark.parametrize("kind", Kind)
def test_a_question_of_any_kind_is_scaled_by_its_kind(
    kind: Kind, monkeypatch: pytest.MonkeyPatch
) -> None:
    def find(problem: LaunchProblem, track: Track) -> Estimate:  # noqa: ARG001
        return Estimate(float(np.hypot(*track.states[-1, 4:6])), float(track.errors[-1]))

    # the end of the name says nothing about the kind
    monkeypatch.setitem(QUESTIONS, "lost_time", Question("lost_time", find, kind, False, "slip"))
    plain, scaled = PAIRS["viscous"].answers(0.5, quantities="lost_time")
    assert plain.value > 0.01
    assert scaled.value / si(kind.si) == pytest.approx(plain.value, rel=1e-7)


def test_a_users_system_is_asked_for_no_unit_but_that_of_time(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def find(problem: LaunchProblem, track: Track) -> Estimate:  # noqa: ARG001
        return Estimate(1.0, 0.0)

    x = ca.SX.sym("x")
    system = st.System("decay", x, ca.SX(0, 1), -x, states=("x",), parameters=(), units={"x": "m"})
    for kind in Kind:
        monkeypatch.setitem(QUESTIONS, "size", Question("size", find, kind, False, "size"))
        if kind is Kind.TIME:
            assert st.Scene(system, None, [1.0], 1.0, quantities="size").answer().value == 1.0
            continue
        with pytest.raises(st.StabilityError, match="names size, which only a disk has"):
            st.Scene(system, None, [1.0], 1.0, quantities="size")


def test_a_question_of_an_unknown_kind_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    def find(problem: LaunchProblem, track: Track) -> Estimate:  # noqa: ARG001
        return Estimate(1.0, 0.0)

    kind: Any = "furlong"
    monkeypatch.setitem(QUESTIONS, "speed", Question("speed", find, kind, False, "speed"))
    with pytest.raises(st.StabilityError, match="no size in the units of a body is known"):
        PAIRS["viscous"].answers(0.5, quantities="speed")


@pytest.mark.parametrize("name", ["viscous", "rough torus"])
def test_uncertain_inputs_move_answers_alike(name: str) -> None:
    pair, widths = PAIRS[name], {"theta": 1e-3, "omega3": 1e-3}
    wide = {n: v * si(STATES[n]) for n, v in widths.items()}
    plain = pair.scene(dimensionless=True, horizon=2.0, uncertain=widths).answer()
    scaled = pair.scene(dimensionless=False, horizon=2.0, uncertain=wide).answer()
    assert plain.spread is not None and scaled.spread is not None
    for given, moved in plain.spread.moves["final"].items():
        assert scaled.spread.moves["final"][given] == pytest.approx(moved, rel=1e-4)
