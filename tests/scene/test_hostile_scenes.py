"""Scenes that are wrong, extreme, or beyond what any model knows: a sentence, or an honest answer."""

from __future__ import annotations

import math

import casadi as ca
import numpy as np
import pytest

import stability as st

COIN = {"theta": 1.5, "omega3": 1.6}


def _scene(**given):
    return st.Scene(**{"contact": st.Viscous(0.3), "start": COIN, "horizon": 5.0} | given)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"quantities": np.array([])}, "quantities is an array"),
        ({"quantities": np.array(["final", "path"])}, "quantities is an array"),
        ({"families": 3}, "families belong to a stability.System"),
        ({"families": [st.disk_family("rolling", "viscous")]}, "families belong"),
        ({"contact": {math.nan: st.Rough()}}, "give each law a word"),
        ({"contact": {"a\nb": st.Rough()}}, "give each law a word"),
        ({"contact": {" ": st.Rough()}}, "give each law a word"),
    ],
)
def test_what_is_not_accepted_is_refused_in_a_sentence(given, words: str) -> None:
    with pytest.raises(st.StabilityError) as caught:
        _scene(**given)
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_model_that_gives_up_has_no_error_and_no_true_error() -> None:
    # at the smallest number above 0 no step leaves the start: the start is all that is known
    answer = _scene(start={"theta": 5e-324}).verify()
    assert "No rung answers" in answer.sentence
    assert answer.until == 0.0
    assert answer.estimate == math.inf
    assert answer.true_error == math.inf


def test_a_truth_that_cannot_be_finer_is_not_free_of_error() -> None:
    answer = _scene(contact=st.Smooth(), tolerance=1e-13, horizon=20.0).verify()
    assert answer.model == "smooth"
    assert 0.0 < answer.true_error <= answer.estimate


# --- reduced models ---


def _relaxing() -> st.System:
    """A fast state that follows the cosine of a clock."""
    x, p = ca.SX.sym("x", 2), ca.SX.sym("p", 2)
    rates = ca.vertcat(-p[0] * (x[0] - ca.cos(x[1])), p[1])
    return st.System("relaxing", x, p, rates, states=("a", "b"), parameters=("pull", "pace"))


def _down(x, p):
    return x[1:], p[1:]


def _up(x, p):  # noqa: ARG001
    return np.stack([np.cos(x[..., 0]), x[..., 0]], axis=-1)


def _reduced(down=_down, up=_up) -> st.Scene:
    a, b = ca.SX.sym("a"), ca.SX.sym("b")
    clock = st.System("clock", a, b, b, states=("b",), parameters=("pace",))
    model = st.ReducedModel("slow", clock, down, up)
    return st.Scene(_relaxing(), [1e3, 1.0], [0.9, 0.0], 3.0, 1e-2, models=[model])


@pytest.mark.parametrize(
    ("maps", "words"),
    [
        ({"down": lambda x, p: ("a", p[1:])}, "down of slow is 'a'"),
        ({"down": lambda x, p: ([[1], [2, 3]], p[1:])}, "down of slow is"),
        ({"down": lambda x, p: ([1j], p[1:])}, "a real number is needed"),
        ({"up": lambda x, p: "a"}, "up of slow is 'a'"),
        ({"up": lambda x, p: _up(x, p) + 0j}, "up of slow is"),
        ({"up": lambda x, p: _up(x, p) * np.nan}, "up of slow gives NaN"),
    ],
)
def test_a_map_that_gives_no_numbers_is_refused_in_a_sentence(maps, words: str) -> None:
    with pytest.raises(st.StabilityError) as caught:
        _reduced(**maps).answer()
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_map_that_writes_into_the_states_changes_nothing() -> None:
    def down(x, p):
        found = x[1:].copy(), p[1:].copy()
        x[:], p[:] = 7.0, 7.0
        return found

    def up(x, p):
        found = _up(x, p)
        x[...], p[...] = 7.0, 7.0
        return found

    kind, spoilt = _reduced().answer(), _reduced(down, up).answer()
    assert kind.model == spoilt.model == "slow"
    assert kind.value == spoilt.value
    assert kind.value["b"] == pytest.approx(3.0, abs=1e-12)  # the clock


# --- faults of the rooms below that a scene meets ---


def test_a_condition_on_parameters_alone_is_no_event() -> None:
    x, p = ca.SX.sym("x", 2), ca.SX.sym("p")
    held = (st.Condition(p, "g = {value:.3g} must be positive"), st.Condition(1.5 - x[0], "far"))
    swing = st.System("swing", x, p, ca.vertcat(x[1], -p * x[0]), states=("angle", "rate"),
                      parameters=("g",), conditions=held)  # fmt: skip
    answer = st.Scene(swing, [1.0], [1.0, 0.0], 2.0, 1e-9).answer()
    assert answer.value["angle"] == pytest.approx(math.cos(2.0), abs=1e-9)
    far = st.Scene(swing, [1.0], [0.0, 2.0], 2.0, 1e-9, "outcome").answer()
    assert far.until == pytest.approx(math.asin(0.75), abs=1e-9)


def test_a_motion_without_a_first_step_ends_at_its_start() -> None:
    x, p = ca.SX.sym("x", 2), ca.SX.sym("p", 1)
    swing = st.System("swing", x, p, ca.vertcat(x[1], -p * ca.sin(x[0])), states=("angle", "rate"),
                      parameters=("g",))  # fmt: skip
    answer = st.Scene(swing, [1e300], [0.0, 4.0], 10.0).answer()
    assert answer.estimate == math.inf
    assert answer.until == 0.0


def test_a_linear_question_of_creep_has_its_reason() -> None:
    start = st.launch("tumbling", at=0.7, tilt=0.0, disk=st.Disk())
    answer = _scene(contact=st.Creep1(100.0), start=start, quantities="verdict").answer()
    same = st.spectrum("tumbling", at=0.7, contact=st.Viscous(100.0))  # of which it is the slow part
    assert answer.value == same.verdict.word == "unstable"
    assert "largest real part" in answer.sentence
