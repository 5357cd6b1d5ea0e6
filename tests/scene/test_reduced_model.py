"""A user's system with reduced models of it, held against the full equations."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
import pytest

import stability as st

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs" / "explanation" / "scenes.md"
NAME = "slow manifold"


def two_scales() -> st.System:
    """The system x' = y - x, eps y' = x² - y: y tends to x² within a time of eps."""
    z, eps = ca.SX.sym("z", 2), ca.SX.sym("eps")
    rates = ca.vertcat(z[1] - z[0], (z[0] ** 2 - z[1]) / eps)
    return st.System("two scales", z, eps, rates, states=("x", "y"), parameters=("eps",))


def slow_model(
    y: Callable[[Any, Any], Any], name: str = NAME, *, down: Any = None, up: Any = None
) -> st.ReducedModel:
    """The model in which y is a function of x and eps."""
    x, eps = ca.SX.sym("x"), ca.SX.sym("eps")
    slow = st.System("slow", x, eps, y(x, eps) - x, states=("x",), parameters=("eps",))
    return st.ReducedModel(
        name,
        slow,
        down or (lambda states, p: (states[:1], p)),
        up or (lambda states, p: np.concatenate([states, y(states, p)], axis=-1)),
    )


FULL = two_scales()
FIRST = slow_model(lambda x, eps: x**2)  # noqa: ARG005
SECOND = slow_model(lambda x, eps: x**2 + 2 * eps * x * (x - x**2), "order 1")
"""Fenichel's expansion: y = x² - eps y', and y' = 2x (x² - x) to lowest order."""


def scene(eps: float, tolerance: float, y: float = 0.25, **more: Any) -> st.Scene:
    asked = {"horizon": 2.0, "models": [FIRST], **more}
    return st.Scene(FULL, {"eps": eps}, {"x": 0.5, "y": y}, tolerance=tolerance, **asked)


def truth(eps: float, y: float = 0.25, time: float = 2.0) -> Any:
    """The full system by `simulate`, finely."""
    run = st.simulate(FULL, {"eps": eps}, {"x": 0.5, "y": y}, [time], tolerance=1e-12)
    return np.array([float(run[n][-1]) for n in ("x", "y")])


def error(answer: st.Answer, eps: float, y: float = 0.25) -> float:
    """True error of the final state; states are below 1."""
    return float(np.abs(np.array([answer.value["x"], answer.value["y"]]) - truth(eps, y)).max())


# --- chosen where its defect is small ---


@pytest.mark.parametrize("eps", [1e-2, 1e-3, 1e-4])
@pytest.mark.parametrize("model", [FIRST, SECOND], ids=lambda m: m.name)
def test_the_estimate_is_near_the_true_error(eps: float, model: st.ReducedModel) -> None:
    answer = scene(eps, 1e-2, models=[model]).answer()
    assert answer.model == model.name
    found = error(answer, eps)
    assert found > 1e-10  # far above that of the truth
    assert found / 3 < answer.estimate < 30 * found


def test_the_error_falls_with_the_order_of_the_model() -> None:
    """Fenichel: an error of eps for y = x², of eps² for the next order."""
    for model, order in ((FIRST, 1), (SECOND, 2)):
        sizes = [error(scene(e, 1e-2, models=[model]).answer(), e) for e in (1e-2, 1e-3)]
        assert np.log10(sizes[0] / sizes[1]) == pytest.approx(order, abs=0.2)


def test_the_cheapest_model_that_is_fine_enough_is_taken() -> None:
    eps, models = 1e-3, [FIRST, SECOND]
    for tolerance, model in ((1e-2, NAME), (1e-5, "order 1"), (1e-10, "two scales")):
        answer = scene(eps, tolerance, models=models).answer()
        assert answer.model == model
        assert error(answer, eps) < max(tolerance, 1e-11)
        assert [r.name for r in answer.rungs if r.chosen] == [model]


@pytest.mark.parametrize(("eps", "tolerance"), [(0.1, 1e-3), (1e-2, 1e-4), (1e-4, 1e-6)])
def test_a_model_whose_defect_is_too_large_is_not_taken(eps: float, tolerance: float) -> None:
    """The same model is wrong by more than the tolerance there, by the full equations."""
    answer = scene(eps, tolerance).answer()
    assert answer.model == "two scales"
    rung = next(r for r in answer.rungs if r.name == NAME)
    assert 1 < rung.estimate < np.inf
    assert "times the tolerance" in rung.why
    assert error(scene(eps, tolerance).answer(only=NAME), eps) > tolerance
    assert error(answer, eps) < tolerance


def test_a_start_off_the_manifold_is_forgotten_within_eps() -> None:
    """`final` is answered by the slow model, and `path`, which has the fast part, is not."""
    eps, y = 1e-2, 0.3
    answer = scene(eps, 1e-2, y).answer()
    assert answer.model == NAME
    found = error(answer, eps, y)
    assert found / 3 < answer.estimate < 30 * found
    whole = scene(eps, 1e-2, y, quantities=("path",)).answer()
    assert whole.model == "two scales"
    rung = next(r for r in whole.rungs if r.name == NAME)
    assert rung.estimate * 1e-2 == pytest.approx(y - 0.25, rel=0.01)  # the error at the start


def test_the_errors_of_a_path_are_those_on_the_way() -> None:
    eps = 1e-3
    answer = scene(eps, 1e-2, quantities=("path",)).answer()
    assert answer.model == NAME
    path = answer.path
    assert path is not None
    assert path.attrs["model"] == NAME
    times = path.time.values[[20, 60, 120, 200]]
    run = st.simulate(FULL, {"eps": eps}, {"x": 0.5, "y": 0.25}, times, tolerance=1e-12)
    for i, time in enumerate(times.tolist()):
        now = path.sel(time=time)
        found = max(abs(float(now[n]) - float(run[n].sel(time=time))) for n in ("x", "y"))
        assert found / 3 < float(now.error) < 30 * found, i


def test_a_defect_that_grows_along_the_path_is_seen() -> None:
    """Next to log 3, at which x' = x² - x from 1.5 is infinite, the defect has grown much."""
    eps, start = 1e-4, {"x": 1.5, "y": 2.25}
    asked = st.Scene(FULL, {"eps": eps}, start, horizon=1.0, tolerance=0.1, models=[FIRST])
    answer = asked.answer()
    run = st.simulate(FULL, {"eps": eps}, start, [1.0], tolerance=1e-12)
    true = [float(run[n][-1]) for n in ("x", "y")]
    found = max(abs(answer.value[n] / v - 1) for n, v in zip(("x", "y"), true, strict=True))
    assert answer.model == NAME
    assert found > 50 * eps
    assert found / 3 < answer.estimate < 30 * found


@pytest.mark.parametrize("eps", [-1.0, -0.3])
def test_a_manifold_that_is_left_is_not_taken(eps: float) -> None:
    """With eps below 0 the full motion leaves y = x² like e^(t/|eps|), the reduced one never."""
    answer = scene(eps, 1e-3).answer()
    rung = next(r for r in answer.rungs if r.name == NAME)
    assert (answer.model, rung.chosen) == ("two scales", False)
    assert abs(truth(eps)[1] - truth(eps)[0] ** 2) > 0.1
    assert rung.estimate > 100


@pytest.mark.parametrize(
    ("eps", "horizon"), [(-1e-2, 0.05), pytest.param(-1e-3, 2.0, marks=pytest.mark.long)]
)
def test_a_fast_departure_is_shown_by_verify(eps: float, horizon: float) -> None:
    asked = scene(eps, 1e-3, horizon=horizon)
    answer = asked.verify()
    assert answer.model != NAME or answer.true_error > 100 * asked.tolerance


def test_what_is_verified_is_the_difference_from_the_full_model() -> None:
    eps = 1e-3
    answer = scene(eps, 1e-2).verify()
    assert answer.model == NAME
    assert answer.true_error == pytest.approx(error(answer, eps), rel=1e-3)


# --- what is refused ---


@pytest.mark.parametrize(
    ("down", "shapes"),
    [
        (lambda x, p: (x, p), r"\(2,\) and \(1,\)"),
        (lambda x, p: (x[:1], p[:0]), r"\(1,\) and \(0,\)"),
        (lambda x, p: (x[0], p), r"\(\) and \(1,\)"),
    ],
)
def test_a_wrong_shape_of_down_is_refused(down: Any, shapes: str) -> None:
    model = slow_model(lambda x, eps: x**2, down=down)  # noqa: ARG005
    message = f"^down of {NAME} gives shapes {shapes}; give 1 states and 1 parameters.$"
    with pytest.raises(st.StabilityError, match=message):
        scene(1e-3, 1e-3, models=[model]).answer()


@pytest.mark.parametrize(
    "up",
    [
        lambda x: x,
        lambda x: np.array([x[..., 0], x[..., 0] ** 2]),
        lambda x: np.concatenate([x, x, x], axis=-1),
    ],
)
def test_a_wrong_shape_of_up_is_refused(up: Any) -> None:
    model = slow_model(lambda x, eps: x**2, up=lambda x, p: up(x))  # noqa: ARG005
    message = rf"^up of {NAME} gives shape \(.*\); give 2 states along the last axis.$"
    with pytest.raises(st.StabilityError, match=message):
        scene(1e-3, 1e-3, models=[model]).answer()


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"name": " "}, "the name of a reduced model is ' '; give a word."),
        ({"system": 3}, "system is 3; give a stability.System."),
        ({"up": 2.0}, "up is 2.0; give a function of states and parameters."),
        ({"down": None}, "down is None; give a function of states and parameters."),
    ],
)
def test_a_model_without_its_parts_is_refused(changed: dict[str, Any], message: str) -> None:
    parts = {"name": NAME, "system": FIRST.system, "down": FIRST.down, "up": FIRST.up}
    with pytest.raises(st.StabilityError) as caught:
        st.ReducedModel(**{**parts, **changed})
    assert str(caught.value) == message


def test_models_of_the_disk_are_refused() -> None:
    with pytest.raises(st.StabilityError, match="models belong to a stability.System"):
        st.Scene(contact=st.Viscous(0.3), start={"theta": 1.4}, horizon=1.0, models=[FIRST])


# --- the page ---


def test_the_example_of_the_page_is_short_and_says_what_it_prints(
    capsys: pytest.CaptureFixture[str],
) -> None:
    blocks = re.findall(r"```python\n(.*?)```", PAGE.read_text(), re.S)
    [block] = [b for b in blocks if "ReducedModel" in b]
    assert len([line for line in block.split("\n") if line.strip()]) <= 30
    exec(compile(block, "docs/explanation/scenes.md", "exec"), {})
    first, second = capsys.readouterr().out.splitlines()
    assert first.startswith("0.1 two scales ")
    assert second.startswith("0.0001 slow manifold ")
    said = re.search(r"# 0.0001 slow manifold +(\S+) (\S+)", block)
    assert said
    assert [float(v) for v in second.split()[-2:]] == pytest.approx(
        [float(v) for v in said.groups()], rel=0.05
    )
