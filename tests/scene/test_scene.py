"""The public scene: choice, evidence, uncertain inputs, several laws, refusals."""

from __future__ import annotations

import math

import numpy as np
import pytest

import stability as st
from stability.bodies.newton_euler import STATES

FAR = {"theta": 1.1, "omega3": 2.0}
COIN = {"theta": 1.5, "omega3": 1.6}


def _scene(**given):
    return st.Scene(**{"contact": st.Viscous(0.3), "start": COIN, "horizon": 5.0} | given)


def test_the_chosen_rung_is_the_cheapest_that_is_fine_enough() -> None:
    answer = _scene(contact=st.Viscous(3000.0), horizon=20.0, tolerance=1e-5).answer()
    chosen = [r for r in answer.rungs if r.chosen]
    assert [r.name for r in chosen] == [answer.model]
    before = answer.rungs[: answer.rungs.index(chosen[0])]
    assert all(not r.estimate <= 1 for r in before)
    assert answer.rungs[-1].name == "viscous"
    assert answer.rungs[-1].cost == 0  # the full model was not run
    assert all(r.why for r in answer.rungs)


def test_a_finer_tolerance_takes_a_higher_order() -> None:
    models = [
        _scene(contact=st.Viscous(3000.0), start=FAR, horizon=20.0, tolerance=tolerance)
        .answer()
        .model
        for tolerance in (3e-2, 1e-5, 1e-9)
    ]
    assert models == ["rough", "creep-1", "creep-3"]


@pytest.mark.parametrize("mu", [0.3, 300.0])
@pytest.mark.parametrize("quantity", ["final", "path", "largest_tilt"])
def test_verify_holds_the_answer_against_the_full_model(mu: float, quantity: str) -> None:
    answer = _scene(contact=st.Viscous(mu), tolerance=1e-6, quantities=quantity).verify()
    assert answer.true_error <= 1e-6
    assert answer.estimate <= 1e-6


def test_one_rung_alone_answers_whatever_its_error_is() -> None:
    steady = _scene(start={"theta": 1.57, "omega3": 1.6}, tolerance=1e-9).answer(only="steady")
    assert steady.model == "steady"
    assert steady.estimate > 1e-9
    orders = [
        _scene(contact=st.Viscous(300.0), start=FAR).answer(only=f"creep-{n}") for n in (1, 2)
    ]
    assert [o.model for o in orders] == ["creep-1", "creep-2"]
    assert orders[1].estimate < orders[0].estimate / 5


def test_a_rung_that_does_not_apply_says_why_and_nothing_else_runs() -> None:
    answer = _scene(start=FAR).answer(only="linearised")
    assert (answer.model, answer.value) == ("none", None)
    assert "linearised cannot answer" in answer.sentence
    with pytest.raises(st.StabilityError, match="known are steady, linearised"):
        _scene(start=FAR).answer(only="magic")


def test_outcome_and_event_come_from_the_full_model_when_nothing_else_will_do() -> None:
    start = {"theta": 1.4707963267948965, "omega3": 1.28}
    answer = _scene(start=start, horizon=30.0, quantities=("outcome", "lift_off_time")).answer()
    assert answer.value["outcome"] == "lift-off"
    # benchmarks/truths.py: two integrations of 30 digits
    from stability.compare.motion.reference_motions import scene as reference

    assert answer.value["lift_off_time"] == pytest.approx(reference("lift-off").end_time, abs=1e-9)
    assert answer.until == pytest.approx(answer.value["lift_off_time"])


def test_settling_is_a_time_or_nothing() -> None:
    start = {"theta": 1.47, "phi_dot": 2.5}
    asked = {"quantities": ("outcome", "settling_time"), "horizon": 200.0, "tolerance": 1e-3}
    answer = _scene(start=start, **asked).answer()
    run = st.simulate(st.Disk(), st.Viscous(0.3), start, np.linspace(0, 200, 4001))
    assert answer.value["outcome"] == run.attrs["outcome"] == "settled"
    late = float(run.settled_time) - answer.value["settling_time"]
    assert 0 <= late <= 0.051  # the samples of `simulate`
    never = _scene(contact=st.Smooth(), start=start, **asked).answer()
    assert never.value["settling_time"] is None


def test_a_start_without_contact_is_an_answer_with_its_reason() -> None:
    answer = _scene(start={"theta": 0.5, "theta_dot": 8.0}).answer()
    assert (answer.model, answer.until, answer.value) == ("none", 0.0, None)
    assert "normal force" in answer.sentence


def test_a_motion_beyond_its_horizon_of_prediction_says_until_when_it_holds() -> None:
    start = {"theta": math.pi / 2 - 1e-3, "omega3": 0.2}
    answer = _scene(contact=st.Rough(), start=start, horizon=400.0, tolerance=1e-12).answer()
    assert 0 < answer.until < 400.0
    assert "No rung keeps" in answer.sentence


def test_a_rung_alone_that_misses_the_tolerance_holds_until_it_parts_from_the_full_model() -> None:
    asked = {"start": {"theta": 1.3, "omega3": 2.0}, "horizon": 20.0, "tolerance": 1e-3}
    scene = _scene(contact=st.Viscous(300.0), quantities="path", **asked)
    answer = scene.answer(only="rough")
    times = answer.path.time.values
    full = st.simulate(st.Disk(), st.Viscous(300.0), asked["start"], times, tolerance=1e-12)
    far = np.max(
        [abs(answer.path[n] - full[n]) / np.maximum(1.0, abs(full[n])) for n in STATES], axis=0
    )
    parted = times[np.argmax(far > 1e-3)]
    assert parted - 0.25 < answer.until < parted < 15.0
    assert answer.sentence.startswith("rough misses the tolerance 0.001")
    assert answer.sentence.endswith(f"the answer holds until {answer.until:.4g}.")


def test_si_units_are_those_of_the_disk() -> None:
    disk = st.Disk(mass=2.0, radius=0.3, gravity=9.81)
    start = {"theta": 1.4, "omega3": 9.0}
    answer = st.Scene(disk, st.Viscous(80.0), start, 2.0, 1e-7).answer()
    run = st.simulate(disk, st.Viscous(80.0), start, [2.0], tolerance=1e-13)
    for name, value in answer.value.items():
        assert value == pytest.approx(float(run[name].values[-1]), abs=3e-6)
    assert answer.path.time.attrs["units"] == "s"
    assert answer.path.omega3.attrs["units"] == "rad/s"


def test_uncertain_inputs_move_the_answer_as_two_runs_say() -> None:
    width = 1e-4
    scene = _scene(tolerance=1e-9, uncertain={"theta": width, "mu": 0.01})
    spread = scene.answer().spread
    ends = [
        st.simulate(st.Disk(), st.Viscous(0.3), COIN | {"theta": 1.5 + d}, [5.0], tolerance=1e-13)
        for d in (-width, 0.0, width)
    ]
    names = ("theta", "theta_dot", "phi_dot", "omega3", "slip_x", "slip_y")
    low, mid, high = (np.array([float(e[n].values[-1]) for n in names]) for e in ends)
    size = max(np.max(np.abs(v - mid) / np.maximum(1, np.abs(mid))) for v in (low, high))
    assert spread.moves["final"]["theta"] == pytest.approx(size, rel=1e-4)
    assert spread.wasted
    assert any("wasted" in line for line in spread.lines())


def test_an_input_that_changes_the_outcome_is_the_answer() -> None:
    start = {"theta": 1.4707963267948965, "omega3": 1.28}
    scene = _scene(start=start, horizon=30.0, quantities="outcome", uncertain={"omega3": 0.02})
    spread = scene.answer().spread
    assert spread.contrary == ("omega3",)
    assert set(spread.outcomes["omega3"]) == {"moving", "lift-off"}


def test_several_laws_say_where_they_part() -> None:
    laws = {"rough": st.Rough(), "viscous": st.Viscous(300.0), "stiffer": st.Viscous(3e5)}
    answer = _scene(contact=laws, start=FAR, tolerance=1e-3, horizon=20.0).answer()
    assert set(answer.value) == set(laws)
    assert answer.until < 20.0
    assert "rough and viscous differ from" in answer.sentence
    assert "rough and stiffer agree" in answer.sentence


def test_laws_part_by_the_same_in_any_units() -> None:
    laws = {"rough": st.Rough(), "viscous": st.Viscous(300.0)}
    one = _scene(contact=laws, start=FAR, tolerance=1e-3, horizon=20.0).answer()
    disk = st.Disk(mass=1.0, radius=1e-4, gravity=1.0)
    laws["viscous"] = st.Viscous(300.0 / float(disk.speed))
    start = {"theta": 1.1, "omega3": 2.0 * float(disk.rate)}
    other = st.Scene(disk, laws, start, 20.0 * float(disk.time), 1e-3).answer()
    assert other.apart == pytest.approx(one.apart, rel=1e-6)


def test_weights_give_the_share_of_each_outcome_and_the_mean_of_numbers() -> None:
    laws = {"little": st.Viscous(0.3), "more": st.Viscous(3.0)}
    start = {"theta": 1.4707963267948965, "omega3": 1.28}
    asked = {"contact": laws, "start": start, "horizon": 30.0, "tolerance": 1e-4}
    weights = {"little": 1.0, "more": 3.0}
    answer = _scene(quantities="outcome", weights=weights, **asked).answer()
    assert set(answer.value.values()) == {"lift-off", "moving"}
    assert "lift-off 25%" in answer.sentence
    assert "moving 75%" in answer.sentence
    tilts = _scene(quantities="largest_tilt", weights=weights, **asked).answer()
    mean = (tilts.value["little"] + 3 * tilts.value["more"]) / 4
    assert f"largest_tilt by weight: {mean:.4g}" in tilts.sentence


def test_a_vain_tolerance_is_raised_where_the_scene_says_so() -> None:
    widths = {"theta": 1e-3}
    fine = _scene(tolerance=1e-9, uncertain=widths).answer()
    coarse = _scene(tolerance=1e-9, uncertain=widths, raise_tolerance=True).answer()
    assert fine.tolerance == 1e-9
    assert coarse.tolerance == pytest.approx(0.1 * fine.spread.size, rel=1e-3)
    assert "the tolerance is raised" in coarse.notes[0]
    assert not coarse.spread.wasted


def test_linear_questions_are_those_of_the_nearest_steady_motion() -> None:
    start = {"theta": 1.56, "phi_dot": 2.1}
    asked = {"contact": st.Viscous(0.97), "start": start, "horizon": 1.0, "tolerance": 1e-9}
    answer = st.Scene(quantities=("verdict", "growth_rate", "boundary"), **asked).answer()
    s = st.spectrum("spinning", at=2.1, contact=st.Viscous(0.97), certify=True)
    assert answer.value["verdict"] == s.verdict.word
    assert answer.value["growth_rate"] == pytest.approx(s.abscissa, abs=1e-9)
    lines = st.boundaries("spinning", axis=("at", 0.5, 8, 9), contact=st.Viscous(0.97))
    assert answer.value["boundary"] == min((b.value for b in lines), key=lambda v: abs(v - 2.1))


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"tolerance": 0.0}, "tolerance is 0"),
        ({"tolerance": 1.0}, "from 1e-13 to 0.1"),
        ({"horizon": -1.0}, "horizon is -1"),
        ({"horizon": float("inf")}, "horizon"),
        ({"quantities": ("speed",)}, "known are final, path"),
        ({"quantities": 3}, "quantities is 3"),
        ({"contact": {}}, "contact holds no law"),
        ({"weights": {"rough": 1.0}}, "weights names rough"),
        ({"weights": 2}, "weights is 2"),
        ({"raise_tolerance": 2}, "raise_tolerance is 2"),
        ({"disk": 3}, "disk is 3"),
        ({"quantities": ()}, "quantities is empty"),
        ({"quantities": ("final", "verdict")}, "one kind in one scene"),
        ({"uncertain": {"weight": 0.1}}, "uncertain names 'weight'"),
        ({"uncertain": {"mu": -0.1}}, "half-width above 0"),
        ({"uncertain": 3}, "half-widths by name"),
        ({"contact": 0.3}, "give a contact law"),
        ({"start": None}, "start is missing"),
        ({"models": [1]}, "give a list of stability.ReducedModel"),
    ],
)
def test_what_is_not_accepted_is_refused_in_a_sentence(given, words: str) -> None:
    with pytest.raises(st.StabilityError) as caught:
        _scene(**given)
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)


def test_the_report_names_every_rung() -> None:
    answer = _scene(contact=st.Viscous(3000.0), horizon=20.0, tolerance=1e-5).answer()
    text = answer.report()
    assert all(r.name in text for r in answer.rungs)
    assert sum(line.startswith("*") for line in text.splitlines()) == 1


@pytest.mark.few(2)
@pytest.mark.parametrize(("size", "word"), [(1, "settled"), (30, "moving"), (300, "moving")])
def test_a_model_at_rest_settles_what_is_proved_to_settle_alone(size: float, word: str) -> None:
    """At 30 the steady motion is within its error of the end, which is not within 1e-3 of it."""
    start = [math.pi / 2 - 4e-5 * size, -4.6e-7 * size, 1.97033107, -5.6e-6 * size, 0.0, 0.0]
    asked = {"contact": st.LinearViscous(0.0011), "start": start, "horizon": 110.0}
    scene = _scene(disk=st.Disk(k=0.5), quantities="outcome", tolerance=1e-4, **asked)
    steady = scene.answer(only="steady")
    assert steady.estimate == (0.0 if word == "settled" else math.inf)
    run = st.simulate(st.Disk(k=0.5), st.LinearViscous(0.0011), start, 110.0)
    assert scene.answer().value == run.attrs["outcome"] == word


@pytest.mark.parametrize("law", [st.Smooth(), st.Rough(), st.Coulomb(0.3), st.Viscous(0.3)])
def test_each_rung_asked_for_alone_answers_or_says_why_not(law: st.Contact) -> None:
    start = {
        "theta": 1.5,
        "theta_dot": 0.01,
        "phi_dot": 0.02,
        "omega3": 2.0,
        "slip_x": 0.0,
        "slip_y": 0.0,
    }
    scene = st.Scene(st.Disk(), law, start, 1.0, 1e-5)
    for name in ("steady", "linearised", "second-order", "drift", law.name):
        answer = scene.answer(only=name)
        assert answer.model == name or (answer.model == "none" and "cannot" in answer.sentence)
    assert answer.model == law.name  # the law itself always answers


@pytest.mark.parametrize(
    ("quantity", "mu", "horizon", "tolerance", "start"),
    [
        # slip is free again where the normal force fades, before it decays
        pytest.param(
            "final",
            10642.5,
            3.54565,
            3.5374e-7,
            (0.6207726, -0.3893043, 0.5506503, 1.4027599, 3.2279e-7, 9.997e-6),
            marks=pytest.mark.long,
        ),
        # an error over the size of theta is no error of a tilt near 0
        (
            "largest_tilt",
            88940.0,
            5.3806,
            8.4414e-5,
            (1.57079594, -3.93612e-5, 1.58916684, 4.95743e-5, -2.33e-8, 8.3e-9),
        ),
    ],
)
def test_an_answer_that_was_once_outside_its_tolerance(
    quantity: str, mu: float, horizon: float, tolerance: float, start: tuple[float, ...]
) -> None:
    names = ("theta", "theta_dot", "phi_dot", "omega3", "slip_x", "slip_y")
    scene = st.Scene(
        st.Disk(k=0.25),
        st.Viscous(mu),
        dict(zip(names, start, strict=True)),
        horizon,
        tolerance,
        quantities=(quantity,),
    )
    answer = scene.verify()
    assert answer.true_error <= tolerance
    assert answer.estimate <= tolerance


def test_the_largest_tilt_is_not_passed_over_where_tangents_meet_below_it() -> None:
    """A tilt may rise faster between two samples than at them; the truth is by dense samples."""
    start = [0.457136611, 0.037003631, 0.655572591, 0.722622832, 2.47271907e-4, -9.86218573e-4]
    disk, law = st.Disk(k=0.2852856659488584), st.LinearViscous(0.004705502372324683)
    scene = st.Scene(disk, law, start, 60.0, 1e-5, quantities=("largest_tilt",))
    run = st.simulate(disk, law, start, np.linspace(36.95, 37.05, 2001), tolerance=1e-12)
    tilt = float(np.abs(np.pi / 2 - run.theta.values).max())
    assert tilt > 1.5702
    assert scene.answer().value > tilt - 1e-5
