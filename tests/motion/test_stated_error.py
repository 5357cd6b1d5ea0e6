"""Errors that a motion states, against launches whose end is known to 20 digits.

`tests/data/stated_errors.json` comes from `benchmarks/reference/motion.cpp`, which shares no code
and no formula with the package; its source is told there.  Version 0.4 fails on most of them.
"""

import importlib.util
import json
import os
import sys
import warnings
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
import pytest
from programs import needed
from reference import trajectories

import stability as st
from stability.bodies.newton_euler import STATES
from stability.motion.result import BY_CODE

TESTS = Path(__file__).parents[1]
STORED = json.loads((TESTS / "data" / "stated_errors.json").read_text())["cases"]
LAWS = {"viscous": st.Viscous, "linear-viscous": st.LinearViscous, "rough": lambda _: st.Rough()}


def word(run: Any) -> str:
    return BY_CODE[int(run.outcome)].word


def asked(case: Any, tolerance: float, method: str) -> Any:
    disk, contact = st.Disk(k=case["k"]), LAWS[case["law"]](case["mu"])
    return st.simulate(
        disk, contact, case["start"], case["last"], tolerance=tolerance, method=method
    )


def distance(run: Any, case: Any) -> float:
    truth = np.array([np.longdouble(v) for v in case["state"]])
    final = np.array([np.longdouble(run[name].values[-1]) for name in STATES])
    return float((np.abs(final - truth) / np.maximum(1, np.abs(truth))).max())


def check(run: Any, case: Any) -> None:
    said = word(run)
    if said in ("undetermined", "unresolved"):
        return
    assert ("moving" if said == "settled" else said) == case["outcome"]
    assert distance(run, case) <= float(run.final_error)
    if said in ("lift-off", "no-contact"):
        late = abs(np.longdouble(float(run.end_time)) - np.longdouble(case["time"]))
        assert float(late) <= float(run.end_time_error)


@pytest.mark.few(3)
@pytest.mark.parametrize("case", STORED, ids=lambda c: c["name"])
def test_hard_launches_state_an_error_that_is_not_too_small(case: Any) -> None:
    run = asked(case, case["tolerance"], case["method"])
    check(run, case)
    assert word(run) != "unresolved"


@pytest.mark.filterwarnings("ignore::stability.StabilityWarning")  # the coarsest has no bound
@pytest.mark.parametrize(
    ("tolerance", "cases"),
    [
        (1e-4, STORED[:1]),
        *[
            pytest.param(t, STORED[:2], marks=pytest.mark.long)
            for t in (1e-2, 1e-3, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12)
        ],
    ],
    ids=lambda v: str(len(v)) if isinstance(v, list) else None,
)
def test_a_stiff_launch_at_every_tolerance(tolerance: float, cases: list[Any]) -> None:
    for case in cases:
        check(asked(case, tolerance, "auto"), case)


@pytest.mark.long
def test_a_fine_stiff_launch_is_answered_and_its_error_is_not_large() -> None:
    for case in STORED[:2]:
        run = asked(case, 1e-9, "auto")
        assert word(run) == case["outcome"]
        assert float(run.final_error) < 1e-4


def campaign() -> Any:
    """The campaign next to the reference code, which is no part of the package."""
    where = TESTS.parent / "benchmarks" / "reference" / "campaign.py"
    spec = importlib.util.spec_from_file_location("motion_campaign", where)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


def test_a_verdict_of_the_campaign_can_be_each_of_its_words() -> None:
    verdict = campaign().verdict
    good = {
        "outcome": "moving",
        "truth": "moving",
        "truth_error": 0.0,
        "error": 1e-9,
        "stated": 2e-9,
        "late": 0.0,
        "stated_time": 0.0,
    }
    assert verdict(good) == "right"
    assert verdict(good | {"error": 3e-9}) == "below"
    assert verdict(good | {"truth": "lift-off"}) == "wrong"
    assert verdict(good | {"outcome": "lift-off", "truth": "lift-off", "late": 1.0}) == "below"
    assert verdict(good | {"outcome": "undetermined"}) == "open"
    assert verdict(good | {"truth": "lost"}) == "lost"


@pytest.mark.outside
def test_the_reference_meets_independent_trajectories(tmp_path: Path) -> None:
    needed("g++", "g++")
    module = campaign()
    reference = module.Reference(tmp_path)
    for case in trajectories():
        for last, state in zip(case["times"], case["states"], strict=True):
            numbers = [case["k"], case["mu"], 0, 1e-6, last, 14, 14, *case["start"], 10**6]
            outcome, _, found = reference.ask("viscous " + " ".join(map(repr, numbers)))
            assert outcome == "moving"
            assert np.abs(found.astype(float) - state).max() < 1e-12
    reference.close()


@pytest.mark.outside
def test_the_reference_agrees_with_itself_in_two_formats(tmp_path: Path) -> None:
    needed("g++", "g++")
    module = campaign()
    reference = module.Reference(tmp_path, quadruple=True)
    for case in STORED:
        kind = case["law"].split("-")[0]
        numbers = [case["k"], case["mu"], 0, 1e-6, case["last"], 16, 17, *case["start"], 10**6]
        outcome, time, found = reference.ask(" ".join([kind, *map(repr, numbers)]))
        assert {"stuck": "no-contact"}.get(outcome, outcome) == case["outcome"]
        assert abs(time - np.longdouble(case["time"])) < 1e-17
        for one, two in zip(found, case["state"], strict=True):
            assert abs(one - np.longdouble(two)) < 1e-17
    reference.close()


@pytest.mark.outside
@pytest.mark.filterwarnings("ignore::stability.StabilityWarning")  # an error without a bound
def test_random_launches_state_no_error_that_is_too_small(tmp_path: Path) -> None:
    # STABILITY_LAUNCHES=300 as a campaign, 30000 for all of them: hours
    needed("g++", "g++")
    module, seed = campaign(), 20261121
    count = int(os.environ.get("STABILITY_LAUNCHES", "40"))
    found = list(module.campaign(seed, count, None, tmp_path))
    print(f"seed {seed}\n{module.summary(found)}")
    verdicts = [f["verdict"] for f in found]
    assert verdicts.count("wrong") == 0
    assert verdicts.count("below") == 0
    assert verdicts.count("right") > 0.8 * count


def test_a_final_state_without_a_bound_of_its_error_is_told_with_a_remedy() -> None:
    """Lorenz's system at r = 28: nearby motions part like exp(0.9 t), so no double knows t = 60."""
    x, p = ca.SX.sym("x", 3), ca.SX.sym("r")
    rates = ca.vertcat(10 * (x[1] - x[0]), x[0] * (p - x[2]) - x[1], x[0] * x[1] - 8 * x[2] / 3)
    lorenz = st.System("lorenz", x, p, rates, states=("a", "b", "c"), parameters=("r",))
    start, said = {"a": 1.0, "b": 1.0, "c": 1.0}, "the error of the final state has no bound"
    with pytest.warns(st.StabilityWarning, match=f"^{said}: .*a smaller tolerance"):
        run = st.simulate(lorenz, {"r": 28.0}, start, 60.0)
    assert run.final_error == np.inf
    assert f"; {said}" in run.attrs["evidence"]
    part = float(run.attrs["evidence"].split("part after ")[1].split("%")[0]) / 100
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        short = st.simulate(lorenz, {"r": 28.0}, start, 60.0 * part / 2)
    assert short.final_error < 1
    assert said not in short.attrs["evidence"]
    with pytest.warns(st.StabilityWarning, match=r"^launch 1: .* \(2 of 3 launches\)\.$"):
        st.simulate(lorenz, {"r": [0.5, 28.0, 29.0]}, start, 60.0)


@pytest.mark.few(1)
@pytest.mark.parametrize("method", ["lsoda", "dop853", "cvodes"])
def test_every_integrator_tells_of_an_error_without_a_bound(method: str) -> None:
    """A loose run at a launch whose neighbours part: a sentence, by any library."""
    start = st.launch("rolling", at=1.2, tilt=0.1)
    with pytest.warns(st.StabilityWarning, match="the error of the final state has no bound"):
        st.simulate(st.Disk(), st.Viscous(0.3), start, 60.0, tolerance=1e-3, method=method)
