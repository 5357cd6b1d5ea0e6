"""SI units of a body with mass and length: the page's numbers, its calls as they are printed."""

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from node import Engine
from page_numbers import COIN, OPEN, RATE, SAME, VERDICT, apart, eigenvalues

import stability as st

BODY = {"aspect": 0.7, "mass": 0.1, "gravity": 9.81, "length": 0.04}
ENDS = """() => {
  const {view} = stabilityExplorer, q = view.subject.quantity[view.state.x];
  return view.state.ranges[q.name].slice(0, 2).map((v) => v * view.shown(q).size);
}"""
"""Ends of the horizontal axis in the unit that is shown."""
LAUNCH = """() => {
  const {view, motion} = stabilityExplorer;
  motion.run();
  const {launch} = motion, shown = (name) => view.curve(name);
  return {outcome: launch.outcome, time: launch.until * shown("time").size,
    energy: launch.series.energy.map((v) => v * shown("energy").size),
    units: ["time", "energy", "normal force"].map((name) => shown(name).unit)};
}"""


@pytest.fixture
def coin(page_of_coin: Path) -> Engine:
    return Engine(page_of_coin)


def called(page: Engine) -> dict[str, Any]:
    """What the Python calls of the page give."""
    code = page.evaluate("stabilityExplorer.python()")
    space: dict[str, Any] = {"code": code}
    exec(re.sub(r", (?:300|200)((?:, \"log\")?\))", r", 3\1", code), space)  # noqa: S102
    return space


def test_the_numbers_that_were_given_are_those_of_the_page(coin: Engine) -> None:
    state = coin.evaluate("stabilityExplorer.view.state")
    assert state["values"]["at"] * RATE == pytest.approx(45.0, rel=1e-12)
    assert np.array(state["ranges"]["at"]) * RATE == pytest.approx([5.0, 100.0], rel=1e-12)
    shown = coin.evaluate(
        "(() => { const {view} = stabilityExplorer;"
        "return view.subject.quantities.map((q) => [q.name, view.state.values[q.name],"
        "view.shown(q)]); })()"
    )
    given = {name: (value * one["size"], one["unit"]) for name, value, one in shown}
    assert given["at"] == (pytest.approx(45.0, rel=1e-12), "rad/s")
    assert given["mu"] == (pytest.approx(0.9, rel=1e-12), "s/m")
    known = st.spectrum("rolling", at=45.0, disk=COIN, contact=st.Viscous(0.9))
    assert apart(eigenvalues(coin), np.asarray(known.eigenvalues)) < SAME


@pytest.mark.few(1)
@pytest.mark.parametrize("law", ["smooth", "viscous", "linear-viscous", "rough"])
@pytest.mark.parametrize("family", ["rolling", "spinning", "tumbling"])
def test_the_calls_give_the_eigenvalues_and_the_verdict_of_the_page(
    coin: Engine, family: str, law: str
) -> None:
    coin.evaluate("(key) => stabilityExplorer.view.choose(key)", f"{family} {law}")
    space = called(coin)
    assert "mass=0.00567, radius=0.01213, gravity=9.81" in space["code"]
    assert apart(eigenvalues(coin), np.asarray(space["point"].eigenvalues)) < SAME
    assert coin.evaluate(VERDICT) == space["point"].verdict.word
    values = space["diagram"]["at"].values
    assert (values[0], values[-1]) == pytest.approx(coin.evaluate(ENDS), rel=1e-12)
    assert space["diagram"].abscissa.attrs["units"] == "1/s"


def test_a_launch_is_told_in_seconds_joules_and_newtons(coin: Engine) -> None:
    coin.evaluate("stabilityExplorer.view.move({at: 1.4066})")
    told, run = coin.evaluate(LAUNCH), called(coin)["motion"]
    assert told["outcome"] == run.attrs["outcome"] == "lift-off"
    assert told["time"] == pytest.approx(float(run.end_time), rel=1e-6)
    assert told["units"] == ["s", "J", "N"]
    assert max(told["energy"]) == pytest.approx(float(run.energy.max()), rel=1e-6)


def test_the_switch_is_kept_by_link_and_call(coin: Engine, page_of_coin: Path) -> None:
    coin.evaluate("stabilityExplorer.view.set({si: false})")
    space = called(coin)
    assert "mass=" not in space["code"]
    assert apart(eigenvalues(coin), np.asarray(space["point"].eigenvalues)) < SAME
    link = coin.evaluate("stabilityExplorer.view.write()")
    assert "units=dimensionless" in link
    fresh = Engine(page_of_coin)
    assert fresh.evaluate("stabilityExplorer.view.state.si")
    fresh.evaluate(OPEN, f"#{link}")
    state = "stabilityExplorer.view.state"
    assert fresh.evaluate(state) == coin.evaluate(state)


def test_a_page_without_mass_and_length_has_no_si_units(disk: Engine) -> None:
    assert not disk.evaluate("stabilityExplorer.view.state.si")


@pytest.mark.long
def test_a_body_with_mass_and_length_has_si_units(tmp_path: Path) -> None:
    body = st.Spheroid(**BODY)
    page = Engine(
        st.explore(
            "vertical", body=body, at=30.0, mu=1.0, certify=False, out=tmp_path / "body.html"
        )
    )
    for key in ("vertical viscous", "tumbling rough"):
        page.evaluate("(key) => stabilityExplorer.view.choose(key)", key)
        space = called(page)
        assert "mass=0.1, length=0.04, gravity=9.81" in space["code"]
        assert apart(eigenvalues(page), np.asarray(space["point"].eigenvalues)) < SAME
        assert page.evaluate(VERDICT) == space["point"].verdict.word
        run = space["motion"]
        assert run.end_time.attrs["units"] == "s" and float(run.end_time) > 0
