"""Scenes that are wrong, extreme, or beyond all models: a sentence, or an honest answer."""

from __future__ import annotations

import math
import pickle
from concurrent.futures import ThreadPoolExecutor

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
        ({"quantities": (np.zeros((2, 3)),)}, "quantities is an array"),
        ({"quantities": ["final", 3]}, "quantities is 3"),
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


def test_more_turns_than_a_number_holds_are_refused() -> None:
    x, p = ca.SX.sym("x", 2), ca.SX.sym("p", 2)
    swing = ca.vertcat(x[1], -p[0] * ca.sin(x[0]) - p[1] * x[1])
    own = st.System("pendulum", x, p, swing, states=("angle", "rate"), parameters=("g", "d"))
    scene = st.Scene(
        own,
        {"g": 9.81, "d": 0.5},
        {"angle": 1.0, "rate": 0.0},
        horizon=1e308,
        quantities="settling_time",
    )
    with pytest.raises(st.StabilityError, match="more than 1e308 times"):
        scene.answer()


def test_a_model_that_gives_up_has_no_error_and_no_true_error() -> None:
    # no step leaves so fast a start: the start is all that is known
    answer = _scene(start={"theta": 1e-3, "phi_dot": 9e8}).verify()
    assert "No rung keeps" in answer.sentence
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
        ({"down": lambda _, p: ("a", p[1:])}, "down of slow is 'a'"),
        ({"down": lambda _, p: ([[1], [2, 3]], p[1:])}, "down of slow is"),
        ({"down": lambda _, p: ([1j], p[1:])}, "a real number is needed"),
        ({"up": lambda *_: "a"}, "up of slow is 'a'"),
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
    swing = st.System(
        "swing",
        x,
        p,
        ca.vertcat(x[1], -p * x[0]),
        states=("angle", "rate"),
        parameters=("g",),
        conditions=held,
    )
    answer = st.Scene(swing, [1.0], [1.0, 0.0], 2.0, 1e-9).answer()
    assert answer.value["angle"] == pytest.approx(math.cos(2.0), abs=1e-9)
    far = st.Scene(swing, [1.0], [0.0, 2.0], 2.0, 1e-9, "outcome").answer()
    assert far.until == pytest.approx(math.asin(0.75), abs=1e-9)


def test_a_motion_without_a_first_step_ends_at_its_start() -> None:
    x, p = ca.SX.sym("x", 2), ca.SX.sym("p", 1)
    swing = st.System(
        "swing",
        x,
        p,
        ca.vertcat(x[1], -p * ca.sin(x[0])),
        states=("angle", "rate"),
        parameters=("g",),
    )
    answer = st.Scene(swing, [1e300], [0.0, 4.0], 10.0).answer()
    assert answer.estimate == math.inf
    assert answer.until == 0.0


def test_a_linear_question_of_creep_has_its_reason() -> None:
    start = st.launch("tumbling", at=0.7, tilt=0.0, disk=st.Disk())
    answer = _scene(contact=st.Creep(100.0), start=start, quantities="verdict").answer()
    same = st.spectrum("tumbling", at=0.7, contact=st.Viscous(100.0))  # it has the fast modes too
    assert answer.value == same.verdict.word == "unstable"
    assert "largest real part" in answer.sentence


# --- several laws ---


def test_laws_that_refuse_the_start_agree_in_nothing() -> None:
    laws = {"creep": st.Creep(1.0), "viscous": st.Viscous(0.3)}
    one = _scene(contact=laws).answer()
    assert (one.parts["creep"].model, one.value["creep"]) == ("none", None)
    assert one.apart == math.inf
    assert one.until == 0.0
    assert "agree" not in one.sentence
    none = _scene(contact=laws, start={"theta": 0.5, "theta_dot": 8.0}).answer()
    assert (none.apart, none.until) == (math.inf, 0.0)


def test_laws_of_other_growth_differ_by_the_difference_of_their_rates() -> None:
    laws = {"soft": st.Viscous(0.3), "stiff": st.Viscous(0.9)}
    answer = _scene(contact=laws, quantities="growth_rate").answer()
    one, other = answer.value.values()
    assert answer.apart == pytest.approx(abs(one - other))
    assert one != other


# --- copies and threads ---


@pytest.mark.parametrize("contact", [st.Viscous(300.0), {"a": st.Viscous(300.0), "b": st.Rough()}])
def test_an_answer_and_its_scene_have_a_pickle(contact) -> None:
    scene = _scene(contact=contact, uncertain={"theta": 1e-3}, quantities=("final", "outcome"))
    answer = scene.answer()
    same, again = pickle.loads(pickle.dumps((answer, scene)))
    assert same.report() == answer.report()
    for name, part in (answer.parts or {"": answer}).items():
        kept = same.parts[name] if name else same
        assert kept.path.identical(part.path)
    assert again.answer().value == answer.value


def test_scenes_in_threads_have_the_answers_that_they_have_alone() -> None:
    scenes = [_scene(contact=st.Viscous(10.0**n), horizon=10.0) for n in (0, 1, 2, 3)] * 2
    alone = [scene.answer().value for scene in scenes]
    with ThreadPoolExecutor(4) as pool:
        assert list(pool.map(lambda scene: scene.answer().value, scenes)) == alone
