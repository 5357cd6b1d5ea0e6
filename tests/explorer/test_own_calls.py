"""The Python calls of a page of one's own family: run as they are printed, against the page."""

from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
import pytest
from node import Engine
from own_families import spring
from own_systems import system_of
from page_numbers import OPEN, VERDICT
from towed_wheel import GIVEN, towed_wheel

import stability as st


def pumped() -> st.Family:
    """A pendulum on a turning support: its inclination is solved for."""
    angle, rate, turn, loss = (ca.SX.sym(n) for n in ("angle", "rate", "turn", "loss"))
    pull = ca.sin(angle) * (turn**2 * ca.cos(angle) - 1)
    system = system_of("pendulum", [angle, rate], [turn, loss], [rate, pull - loss * rate])
    near = {"angle": 1.0, "turn": 1.5, "loss": 0.2}
    return system.steady("turn", held={"rate": 0.0}, guess=near, name="inclined")


def pushed() -> st.Family:
    """A spring that is at rest only where nothing pushes it."""
    x, v, k, c, push = (ca.SX.sym(n) for n in ("x", "v", "k", "c", "push"))
    system = system_of("pushed", [x, v], [k, c, push], [v, push - k * x - c * v])
    return st.Family(system, "rest", at=("k",), held={"x": 0, "v": 0})


CASES: dict[str, tuple[Any, dict[str, Any]]] = {
    "spring": (spring, {"at": 9.81, "k": 40.0, "c": 0.3}),
    "an input of 0": (pushed, {"at": 2.0, "c": 0.3, "push": 0.0}),
    "closed form": (towed_wheel, {"at": 0.3, **GIVEN}),
    "solved for": (pumped, {"at": 1.6, "loss": 0.3}),
}
SLOWER = [pytest.param(name, marks=pytest.mark.long) for name in ("closed form", "solved for")]


@pytest.mark.parametrize("name", ["spring", "an input of 0", *SLOWER])
def test_the_calls_give_the_verdict_the_map_and_the_launch_of_the_page(
    tmp_path: Path, name: str
) -> None:
    make, given = CASES[name]
    family = make()
    page = Engine(st.explore(family, certify=False, out=tmp_path / "own.html", **given))
    page.evaluate("stabilityExplorer.view.set({kick: 1, tilt: 0.05, until: 30})")
    page.evaluate("stabilityExplorer.motion.run()")
    code = page.evaluate("stabilityExplorer.python()")
    final = page.evaluate("stabilityExplorer.motion.launch.final")
    outcome = page.evaluate("stabilityExplorer.motion.launch.outcome")
    verdict = page.evaluate(VERDICT)
    space: dict[str, Any] = {"family": family}
    exec(code.replace(", 300)", ", 12)").replace(", 200)", ", 9)"), space)  # noqa: S102
    assert space["point"].verdict.word == verdict
    run = space["motion"]
    assert run.attrs["outcome"] in (outcome, "settled")
    ours = np.array([run[n].values[-1] for n in family.system.states])
    assert float(run.time[-1]) == 30.0
    assert ours == pytest.approx(np.array(final)[: len(ours)], abs=1e-6)
    steady = np.array([space["start"][n] for n in family.system.states])
    steady[1] -= 0.05
    known = family.member([given["at"]], [given.get(n, given["at"]) for n in family.parameters])
    assert steady == pytest.approx(np.ravel(known)[: len(ours)], abs=1e-9)


@pytest.mark.long
def test_without_a_member_the_calls_speak_of_no_launch(tmp_path: Path) -> None:
    """Below turn = 1 the pendulum hangs straight: the page prints nothing that is not there."""
    page = Engine(st.explore(pumped(), certify=False, out=tmp_path / "own.html", at=1.6, loss=0.3))
    page.evaluate(OPEN, "#show=inclined&turn=0.5&loss=0.3")
    assert page.evaluate(VERDICT) == "absent"
    assert "motion" not in page.evaluate("stabilityExplorer.python()")
