"""The cost of a map, predicted from some of its launches."""

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

import stability as st
from stability.basin import cost
from stability.basin.basins import Plan, planned, run
from stability.basin.cost import Cost, predict
from stability.integrators import lanes

SCENES: dict[str, dict[str, Any]] = {
    "rolling": {"family": "rolling", "x": ("at", 0.1, 3.0, 60), "y": ("tilt", 0.01, 1.2, 40)},
    "spinning": {"family": "spinning", "x": ("at", 0.1, 3.0, 60), "y": ("tilt", 0.01, 1.2, 40)},
}
"""Two scenes whose launches cost very different times, by where they end."""


def plan_of(scene: dict[str, Any], horizon: float = 60.0) -> Plan:
    return planned(None, "viscous", mu=0.3, horizon=horizon, **scene)


@pytest.fixture
def made(monkeypatch: pytest.MonkeyPatch) -> Iterator[list[float]]:
    """The steps of whole batches so far: a clock that is the same on every machine."""
    spent = [0.0]
    plain = lanes._LaneRun._propagate

    def counted(self: Any, *arguments: Any) -> Any:
        found = plain(self, *arguments)
        spent[0] += max(steps for *_, steps in found)
        return found

    monkeypatch.setattr(lanes._LaneRun, "_propagate", counted)
    yield spent


@pytest.mark.long
@pytest.mark.parametrize("name", SCENES)
def test_predicted_steps_of_batches_are_those_that_they_make(name: str, made: list[float]) -> None:
    plan = plan_of(SCENES[name])
    found = predict(plan, workers=2, clock=lambda: 1e-6 * made[0])
    before = made[0]
    run(plan, None, False, None, 1, None)
    true = 1e-6 * (made[0] - before)
    assert found.launches == 2400
    assert found.sampled == cost.LAST
    assert true / 1.2 < found.computing < 1.2 * true
    assert found.least == pytest.approx(found.seconds)


def test_a_trial_tells_batches_from_launches_that_are_decided_alone() -> None:
    """Half of 20 launches make 128 steps, half 1280; of 64 000 each lane is as full as they are."""
    turns, width = np.repeat([128.0, 1280.0], 10), cost.lanes_of_batch()
    trial = cost._Trial({"outcome": np.zeros(20)}, turns, together=3.0, alone=0.5)
    assert trial.steps(20) == 128 * -(-20 // width) + (1280 - 128) * -(-10 // width)
    assert trial.steps(64_000) == pytest.approx(64_000 * (128 + 1280) / 2 / width)
    together, alone = trial.price(64_000)
    assert together == pytest.approx(3.0 * trial.steps(64_000) / trial.steps(20))
    assert alone == pytest.approx(1600.0)
    assert trial.price(0) == (0.0, 0.0)


def clock_of(each: float, asked: list[int], monkeypatch: pytest.MonkeyPatch) -> Any:
    """A clock of launches that are decided one by one, at one price."""
    now = [0.0]
    plain = cost.outcomes

    def slow(launches: Any, judging: Any, before_single: Any) -> Any:
        found = plain(launches, judging, before_single)
        asked.append(launches.count)
        now[0] += each * launches.count
        return found

    monkeypatch.setattr("stability.basin.cost.outcomes", slow)
    return lambda: now[0]


def test_launches_that_are_decided_one_by_one_cost_the_same_each(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    plan = planned(None, "viscous", mu=0.3, horizon=1.0, chunk=400, **SCENES["rolling"])
    blocks = plan.layout.blocks()
    found = predict(plan, 4, clock=clock_of(0.001, [], monkeypatch))
    assert found.computing == pytest.approx(2.4)
    assert found.seconds == pytest.approx(-(-len(blocks) // 4) * 2.4 / len(blocks))


def test_expensive_launches_are_tried_less_often(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[int] = []
    found = predict(plan_of(SCENES["rolling"]), clock=clock_of(1.0, asked, monkeypatch))
    assert asked == [8, 8]
    assert found.computing == pytest.approx(2400)


def test_chunks_that_are_there_cost_nothing() -> None:
    plan = planned(None, "viscous", mu=0.3, horizon=1.0, chunk=400, **SCENES["rolling"])
    blocks = plan.layout.blocks()
    found = predict(plan, missing=blocks[1:])
    assert found.launches + found.stored == 2400
    assert found.stored == plan.layout.count(blocks[0])
    assert predict(plan, missing=[]) == Cost(0, 2400, 0, 0.0, 0.0, 0.0, 1, 0)


@pytest.mark.parametrize("shape", [(60, 40), (2, 3), (1000, 2, 5), (1, 7), (100_000, 9)])
def test_trials_are_spread_over_every_axis(shape: tuple[int, ...]) -> None:
    cells = cost._spread(shape)
    assert len(np.unique(cells, axis=0)) == len(cells)
    for count in (32, len(cells)):
        for axis, length in enumerate(shape):
            parts = min(length, 5)
            there, every = (
                np.bincount(c * parts // length, minlength=parts)
                for c in (cells[:count, axis], np.arange(length))
            )
            assert (there > 0.5 * min(count, len(cells)) * every / length).all()


def test_a_map_with_a_corner_that_is_refused_is_refused_before_it_starts() -> None:
    with pytest.raises(st.StabilityError, match="the tilt takes theta to"):
        planned(
            None,
            "viscous",
            mu=0.3,
            family="rolling",
            x=("at", 0.1, 3, 50),
            y=("tilt", 0.1, 1.6, 50),
            horizon=10.0,
        )


def test_a_random_sample_is_tried_by_its_own_launches() -> None:
    spread = {"theta": st.Uniform(0.3, 1.5), "omega3": st.Uniform(0.1, 3.0)}
    plan = planned(None, "viscous", mu=0.3, distribution=spread, count=5000, seed=3, horizon=5.0)
    found = predict(plan)
    assert found.launches == 5000
    assert 0 < found.seconds < 600
    assert 10 < found.size / 5000 < 150
