"""What the page on scenes says, one test for each statement, and the page against today's answers.

The page is docs/explanation/scenes.md.
"""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import stability as st
from stability.scene.chart import chart
from stability.scene.ladder import price_of_full
from stability.scene.questions import QUESTIONS
from stability.scene.rungs.creeping import name_of
from stability.scene.rungs.drifting import DRIFT
from stability.scene.rungs.near_steady import LINEARISED, SECOND, STEADY

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs" / "explanation" / "scenes.md").read_text()
START = {"theta": 1.55, "omega3": 1.5}
CHART = {
    "rough": 2.7e-2,
    "creep-1": 2.3e-3,
    "creep-2": 5.7e-6,
    "creep-3": 3.4e-8,
    "viscous": 5e-11,
    "linear-viscous law": 1.5e-3,
    "rough law": 2.6e-2,
    "coulomb law, mu = 0.3": 2.6e-2,
    "smooth law": 1.9,
}
"""True errors that docs/scene.png shows."""
LADDER = (
    (1e-1, STEADY, 2e-2, 2e-2),
    (1e-2, LINEARISED, 8e-5, 3e-5),
    (1e-4, LINEARISED, 8e-5, 3e-5),
    (1e-5, "creep-1", 3e-8, 2e-8),
    (1e-8, "creep-2", 2e-10, 3e-11),
    (1e-12, "creep-3", 6e-14, 6e-14),
)
"""Of the page's launch: tolerance, model, estimated and true error."""
DIPPING = {"theta": 1.206, "theta_dot": 0.782, "phi_dot": 0.404, "omega3": 0.789}
NAMES = ("theta", "theta_dot", "phi_dot", "omega3", "slip_x", "slip_y")


def scene(tolerance: float = 1e-6, mu: float = 300.0, **more: Any) -> st.Scene:
    """The launch of the page."""
    return st.Scene(
        st.Disk(), st.Viscous(mu), START, **{"horizon": 10.0, "tolerance": tolerance, **more}
    )


def simulated(disk: Any, contact: Any, start: Any, times: Any) -> Any:
    """States of the full model by `simulate`, shape (t, 6)."""
    run = st.simulate(disk, contact, start, times, tolerance=1e-12)
    return np.stack([run[n].values for n in NAMES], axis=-1)


def apart(one: Any, other: Any) -> float:
    """Largest difference over 1 or the size of the state."""
    return float(np.max(np.abs(one - other) / np.maximum(1.0, np.abs(other))))


def table(head: str) -> list[list[str]]:
    """Cells of the table of the page below a head."""
    lines = PAGE[PAGE.index(head) :].split("\n")[2:]
    rows = lines[: lines.index("")]
    return [[cell.strip().strip("`") for cell in row.strip("|").split(" | ")] for row in rows]


def lines_of(report: str) -> list[tuple[bool, str, int, float]]:
    """Mark, name, states and error of each rung of a report."""
    found = re.findall(r"^([ *])([a-z][\w-]*) +(\d) +(?:[\d.]+ ms|-) +(\S+)  ", report, re.M)
    return [
        (mark == "*", name, int(states), np.inf if size == "-" else float(size))
        for mark, name, states, size in found
    ]


# --- the page ---


def test_every_rung_and_quantity_is_on_the_page() -> None:
    rungs = [row[0] for row in table("| rung | states |")]
    closed = [STEADY, LINEARISED, SECOND, DRIFT]
    assert rungs == [*closed, "a user's name", name_of(0), "creep-n", "the law's name"]
    assert {row[0] for row in table("| name | what it is |")} == set(QUESTIONS)


@pytest.mark.long
def test_the_errors_of_the_chart_are_those_of_the_picture(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("stability.scene.chart.LEAST", 1)  # its times are not looked at
    monkeypatch.setattr("stability.scene.chart.BUDGET", 0.0)
    hoop = st.Scene.from_toml(ROOT / "examples" / "scenes" / "hoop-on-a-rough-floor.toml")
    data = chart(hoop)
    known = np.isfinite(data.true_error.values)
    assert set(CHART) == set(data.model.values[known])
    for name, error in CHART.items():
        found = float(data.true_error.sel(model=name))
        # the error of the full model is rounding in part
        assert found < 1e-9 if error < 1e-9 else found == pytest.approx(error, rel=0.05), name
    assert float(data.spread) == pytest.approx(0.22, abs=0.005)
    assert data.model.values[data.chosen.values].tolist() == ["creep-2"]
    path = replace(hoop, quantities=("path",), uncertain={}).answer(only="creep-2").path
    true = simulated(hoop.disk, hoop.contact, hoop.start, path.time.values[1:])
    scale = np.array([1.0, *[float(hoop.disk.rate)] * 3, *[float(hoop.disk.speed)] * 2])
    mine = np.stack([path[n].values[1:] for n in NAMES], axis=-1)
    assert apart(mine / scale, true / scale) == pytest.approx(CHART["creep-2"], rel=0.05)


def test_the_report_of_the_page_is_that_of_today() -> None:
    block = re.search(r"```text\n(disk: .*?creep-1 answers.*?)```", PAGE, re.DOTALL)
    assert block
    shown = lines_of(block[1])
    answer = scene().answer()
    assert block[1].split("\n\n")[0].split("\n") == list(answer.setting)
    for name, value in answer.value.items():
        [printed] = re.findall(
            rf"\b{name} = (\S+) (?:rad|√\(g/R\)|√\(gR\))[,\n]", block[1].split("\n\n")[1] + "\n"
        )
        assert float(printed) == pytest.approx(value, abs=scene().tolerance)
    told = [(r.chosen, r.name, r.dimension, r.estimate) for r in answer.rungs]
    assert len(shown) == 4
    assert [row[:3] for row in shown] == [row[:3] for row in told]
    assert [row[3] for row in shown] == pytest.approx([row[3] for row in told], rel=0.1)


def test_each_tolerance_has_its_model() -> None:
    for tolerance, model, estimate, error in LADDER:
        answer = scene(tolerance).verify()
        assert answer.model == model, tolerance
        assert answer.estimate == pytest.approx(estimate, rel=0.5)
        assert answer.true_error <= answer.estimate <= tolerance
        if error > 1e-13:  # below, the truth itself is known to few digits
            assert answer.true_error == pytest.approx(error, rel=0.6)


def test_errors_are_dimensionless() -> None:
    coin = st.Disk.named("quarter")
    si = {"theta": 1.55, "omega3": 1.5 * coin.rate}
    law = st.Viscous(300.0 / coin.speed)
    mine, other = (
        scene(1e-2).answer(),
        st.Scene(coin, law, si, horizon=10.0 / coin.rate, tolerance=1e-2).answer(),
    )
    assert (mine.model, other.model) == (LINEARISED, LINEARISED)
    assert other.estimate == pytest.approx(mine.estimate, rel=1e-6)
    assert other.value["omega3"] == pytest.approx(mine.value["omega3"] * coin.rate)


# --- the rungs ---


def test_the_full_model_is_not_run_where_it_is_not_needed() -> None:
    for tolerance in (1e-2, 1e-6):
        *_, last = scene(tolerance).answer().rungs
        assert (last.name, last.cost, last.chosen) == ("viscous", 0.0, False)


def test_creep_is_skipped_where_the_full_model_is_expected_to_be_faster() -> None:
    soft = scene(mu=0.3)
    rungs = {r.name: r for r in soft.answer().rungs}
    assert rungs["viscous"].chosen
    assert rungs["creep"].cost == 0.0
    assert rungs["creep"].price > price_of_full(soft._problem(soft.contact))


@pytest.mark.few(2)
@pytest.mark.parametrize(
    ("start", "law", "horizon", "reason"),
    [
        ({"theta": 0.8, "omega3": 1.5}, st.Viscous(0.3), 5.0, "the nearest steady motion"),
        ({"theta": 1.5707, "omega3": 1.0}, st.Viscous(0.3), 400.0, "grows e^"),
        ({"theta": 1.5706, "omega3": 1.5}, st.Smooth(), 50.0, "two modes of rolling are parallel"),
        ({"theta": 1.562, "omega3": 1.5}, st.Viscous(0.3), 8.0, "is expected to take no longer"),
        (
            {"theta": 1.07, "theta_dot": -1.2, "phi_dot": -2.1, "omega3": -0.2},
            st.Viscous(5000.0),
            5.0,
            "a guard of the full model fails before the slip has decayed",
        ),
    ],
)
def test_a_rung_that_does_not_apply_says_why(
    start: Any, law: Any, horizon: float, reason: str
) -> None:
    answer = st.Scene(contact=law, start=start, horizon=horizon, tolerance=1e-6).answer()
    *tried, _ = answer.rungs
    assert any(reason in rung.why and not rung.chosen for rung in tried)
    assert answer.model == law.name


@pytest.mark.parametrize(("name", "order"), [(STEADY, 1), (LINEARISED, 2), (SECOND, 3)])
def test_errors_near_a_steady_motion_fall_as_their_orders_say(name: str, order: int) -> None:
    """Expansion in the distance: the rest of order n falls as its power n."""
    law, errors, estimates = st.Viscous(0.3), [], []
    for far in (0.02, 0.01):
        start = {"theta": np.pi / 2 - far, "omega3": 2.0}
        answer = st.Scene(contact=law, start=start, horizon=10.0).answer(only=name)
        assert answer.model == name
        [truth] = simulated(st.Disk(), law, start, [10.0])
        errors.append(apart(np.array(list(answer.value.values())), truth))
        estimates.append(answer.estimate)
    assert errors[0] / errors[1] == pytest.approx(2**order, rel=0.1)
    for stated, true in zip(estimates, errors, strict=True):
        assert true <= stated <= 5 * true


# --- creep ---


def test_the_transient_shortens_with_friction_and_creep_does_not_grow() -> None:
    ends, counts = [], []
    for mu in (1e3, 1e4, 1e5):
        answer = scene(mu=mu, tolerance=1e-8).answer(only="creep")
        ends.append(float(re.findall(r"the full model to (\S+), until", answer.notes[0])[0]))
        counts.append(int(re.findall(r"on (\d+) elements", answer.notes[1])[0]))
    assert len(set(counts)) == 1
    assert all(6 < a / b < 14 for a, b in zip(ends, ends[1:], strict=False))


def test_creep_is_left_and_entered_again() -> None:
    asked = st.Scene(contact=st.Viscous(1300.0), start=DIPPING, horizon=7.0, tolerance=1e-4)
    answer = asked.answer(only="creep")
    words = [re.sub(r" to .*?,? (until|on|where)", r" \1", note) for note in answer.notes]
    turn = ["the full model until the slip has decayed", "creep on elements"]
    plain = [re.sub(r"creep-\d on \d+ elements?", "creep on elements", w) for w in words]
    assert plain == [*turn * 2, "the full model where slip is not bound"]
    assert list(answer.notes) == [
        "the full model to 0.06976, until the slip has decayed",
        "creep-4 to 1.866 on 2 elements",
        "the full model to 4.489, until the slip has decayed",
        "creep-2 to 5.348 on 1 element",
        "the full model to 7, where slip is not bound",
    ]
    [truth] = simulated(st.Disk(), asked.contact, DIPPING, [7.0])
    error = apart(np.array(list(answer.value.values())), truth)
    assert error <= answer.estimate * 3
    assert error <= asked.tolerance
    assert answer.estimate <= asked.tolerance


def test_creep_is_given_up_before_a_stretch_that_may_cost_as_much_as_the_whole() -> None:
    asked = st.Scene(contact=st.Viscous(1300.0), start=DIPPING, horizon=7.0, tolerance=1e-4)
    *_, creep, last = asked.answer().rungs
    assert (creep.name, last.name, last.chosen) == ("creep", "viscous", True)
    assert "may cost as much as from the start" in creep.why
    long = replace(asked, start={"theta": 1.3, "omega3": 2.0}, horizon=20.0)
    assert long.answer().model.startswith("creep")


# --- uncertain inputs, several laws ---


def test_the_spread_is_that_of_separate_scenes() -> None:
    widths = {"mu": 0.2, "theta": 1e-4}
    told = scene(uncertain=widths).answer().spread
    assert told is not None
    middle = np.array(list(scene().answer().value.values()))
    share = {"mu": 1e-6, "theta": 1e-5}  # displaced runs are these scenes; a sensitivity is not
    for name, ends in {
        "mu": [scene(mu=240.0), scene(mu=360.0)],
        "theta": [replace(scene(), start={**START, "theta": 1.55 + d}) for d in (-1e-4, 1e-4)],
    }.items():
        moved = max(apart(np.array(list(s.answer().value.values())), middle) for s in ends)
        assert told.moves["final"][name] == pytest.approx(moved, rel=share[name])
    assert told.size == pytest.approx(np.hypot(*told.moves["final"].values()))
    assert told.wasted
    for line in told.lines():
        assert line in PAGE
    loose = scene(1e-5, uncertain=widths).answer().spread
    assert loose is not None
    assert not loose.wasted


@pytest.mark.long
def test_a_move_is_known_to_twice_the_tolerance() -> None:
    for tolerance, model in ((1e-3, "rough"), (1e-6, "creep-2")):
        asked = st.Scene(
            contact=st.Viscous(1e3),
            start={"theta": 1.3, "omega3": 2.0},
            horizon=20.0,
            tolerance=tolerance,
            uncertain={"mu": 0.2},
        )
        answer = asked.answer()
        assert answer.model == model
        assert answer.spread is not None
        middle, *ends = (
            simulated(st.Disk(), st.Viscous(mu), asked.start, [20.0])[0]
            for mu in (1e3, 800.0, 1.2e3)
        )
        moved = max(apart(end, middle) for end in ends)
        assert abs(answer.spread.moves["final"]["mu"] - moved) < 2 * tolerance


def test_an_outcome_within_the_uncertainty_is_named() -> None:
    def asked(spin: float, **more: Any) -> Any:
        start = {"theta": 1.0, "theta_dot": -0.5, "phi_dot": 1.0, "omega3": spin}
        return st.Scene(
            contact=st.Viscous(3.0),
            start=start,
            horizon=5.0,
            tolerance=1e-3,
            quantities=("outcome",),
            **more,
        ).answer()

    answer = asked(-2.5, uncertain={"omega3": 0.2})
    apart = (asked(-2.7).value, asked(-2.3).value)
    assert apart == ("lift-off", "moving")
    assert answer.spread.outcomes == {"omega3": apart}
    assert answer.spread.contrary == ("omega3",)
    assert "not determined" in answer.report()
    sure = asked(-2.5, uncertain={"omega3": 0.01})
    assert sure.spread.contrary == ()


def test_two_laws_part_where_their_motions_do() -> None:
    laws = {"viscous": st.Viscous(0.3), "rough": st.Rough()}
    start = {"theta": 1.4, "omega3": 2.0}
    answer = st.Scene(contact=laws, start=start, horizon=5.0, tolerance=1e-3).answer()
    times = np.linspace(0, 5, 201)
    one, other = (simulated(st.Disk(), law, start, times)[:, :4] for law in laws.values())
    far = (np.abs(one - other) / np.maximum(1, np.abs(one))).max(axis=1)
    assert answer.until == pytest.approx(times[np.argmax(far > 1e-3)])
    assert answer.apart == pytest.approx(far[-1], abs=2e-3)
    assert "viscous and rough differ from" in answer.sentence
    assert set(answer.parts) == set(laws)


# --- what a scene does not do ---


def test_dry_friction_has_the_full_model_alone() -> None:
    asked = st.Scene(contact=st.Coulomb(0.2), start=START, horizon=5.0, tolerance=1e-3)
    answer = asked.answer()
    assert answer.model == "coulomb"
    assert [r.why.split(":")[0] for r in answer.rungs[:2]] == [
        "dry friction has no linear motion",
        "coulomb has no creep",
    ]


def test_a_scene_has_one_launch() -> None:
    many = st.Scene(contact=st.Viscous(0.3), start={"theta": [1.4, 1.5]}, horizon=5.0)
    with pytest.raises(st.StabilityError, match="2 launches; give one"):
        many.answer()


def test_a_start_without_contact_has_no_model() -> None:
    start = {"theta": 0.8, "phi_dot": -0.9, "omega3": -2.4}
    answer = st.Scene(contact=st.Viscous(3.0), start=start, horizon=5.0).answer()
    assert (answer.model, answer.value, answer.until) == ("none", None, 0.0)
    assert "contact" in answer.sentence
