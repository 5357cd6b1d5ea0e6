"""The Python calls of a page of one's own family: run as they are printed, against the page."""

from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
import pytest
from chromium import visit
from towed_wheel import GIVEN, towed_wheel

import stability as st


def pumped() -> st.Family:
    """A pendulum on a turning support: its inclination is solved for."""
    angle, rate, turn, loss = (ca.SX.sym(n) for n in ("angle", "rate", "turn", "loss"))
    pull = ca.sin(angle) * (turn**2 * ca.cos(angle) - 1)
    system = st.System("pendulum", ca.vertcat(angle, rate), ca.vertcat(turn, loss),
                       ca.vertcat(rate, pull - loss * rate), states=("angle", "rate"),
                       parameters=("turn", "loss"))  # fmt: skip
    near = {"angle": 1.0, "turn": 1.5, "loss": 0.2}
    return system.steady("turn", held={"rate": 0.0}, guess=near, name="inclined")


CASES: dict[str, tuple[Any, dict[str, Any]]] = {
    "closed form": (towed_wheel, {"at": 0.3, **GIVEN}),
    "solved for": (pumped, {"at": 1.6, "loss": 0.3}),
}


@pytest.mark.parametrize("name", CASES)
def test_the_calls_give_the_verdict_the_map_and_the_launch_of_the_page(
    browser: Any, tmp_path: Path, name: str
) -> None:
    make, given = CASES[name]
    family = make()
    path = st.explore(family, certify=False, out=tmp_path / "own.html", **given)
    with visit(browser, path) as seen:
        page = seen.page
        page.evaluate("stabilityExplorer.view.set({kick: 1, tilt: 0.05, until: 30})")
        page.wait_for_function("!stabilityExplorer.motion.waits")
        page.evaluate("document.querySelector('button[title^=\"Show the Python\"]').click()")
        code = page.locator("pre").inner_text()
        final = page.evaluate("stabilityExplorer.motion.launch.final")
        outcome = page.evaluate("stabilityExplorer.motion.launch.outcome")
        badge = page.locator(".badge").inner_text().split()[-1]
    space: dict[str, Any] = {"family": family}
    exec(code.replace(", 300)", ", 12)").replace(", 200)", ", 9)"), space)  # noqa: S102
    assert space["point"].verdict.word == badge
    run = space["motion"]
    assert run.attrs["outcome"] in (outcome, "settled")
    ours = np.array([run[n].values[-1] for n in family.system.states])
    assert float(run.time[-1]) == 30.0
    assert ours == pytest.approx(np.array(final)[: len(ours)], abs=1e-6)
    steady = np.array([space["start"][n] for n in family.system.states])
    steady[1] -= 0.05
    known = family.member([given["at"]], [given.get(n, given["at"]) for n in family.parameters])
    assert steady == pytest.approx(np.ravel(known)[: len(ours)], abs=1e-9)


def test_without_a_member_the_calls_speak_of_no_launch(browser: Any, tmp_path: Path) -> None:
    """Below turn = 1 the pendulum hangs straight: the page prints nothing that is not there."""
    path = st.explore(pumped(), certify=False, out=tmp_path / "own.html", at=1.6, loss=0.3)
    with visit(browser, path, "#show=inclined&turn=0.5&loss=0.3") as seen:
        assert seen.page.locator(".badge").inner_text().endswith("no member")
        seen.page.evaluate("document.querySelector('button[title^=\"Show the Python\"]').click()")
        assert "motion" not in seen.page.locator("pre").inner_text()
