"""Motions of Python functions: exact solutions, the same equations as a graph, and refusals."""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np
import pytest

import stability as st

NAMES: dict[str, Any] = {"states": ("q", "v"), "parameters": ("k", "c")}


def damped(x: Any, p: Any) -> list[Any]:
    return [x[1], -p[0] * x[0] - p[1] * x[1]]


def oscillator() -> st.System:
    return st.System.from_function(damped, name="damped", **NAMES)


def exact(t: Any, k: float, c: float) -> Any:
    """The place from q = 1 at rest."""
    rate = np.sqrt(k - c**2 / 4)
    return np.exp(-c * t / 2) * (np.cos(rate * t) + c / (2 * rate) * np.sin(rate * t))


@pytest.mark.parametrize("method", ["auto", "dop853", "lsoda", "radau", "bdf"])
def test_a_motion_is_the_exact_one_within_its_error(method: str) -> None:
    run = st.simulate(oscillator(), {"k": 4, "c": 0.3}, {"q": 1, "v": 0}, 10.0, method=method)
    off = np.abs(run.q.values - exact(run.time.values, 4.0, 0.3))
    assert off[-1] <= float(run.final_error)
    assert off.max() < 1e-6
    assert run.attrs["source"] == "a Python function, integrated by floats"
    assert run.attrs["outcome"] == "moving"


def test_many_launches_are_those_of_the_graph() -> None:
    x, p = ca.SX.sym("x", 2), ca.SX.sym("p", 2)
    rates = ca.vertcat(x[1], -p[0] * ca.sin(x[0]) - p[1] * x[1])
    graph = st.System("swing", x, p, rates, **NAMES)
    function = st.System.from_function(
        lambda x, p: [x[1], -p[0] * np.sin(x[0]) - p[1] * x[1]], name="swing", **NAMES
    )
    start = {"q": np.linspace(-2, 2, 20), "v": 0.3}
    one, two = (st.simulate(s, {"k": 9.81, "c": 0.2}, start, 3.0) for s in (graph, function))
    off = np.abs(one.q.values[:, -1] - two.q.values[:, -1])
    assert (off <= (one.final_error + two.final_error).values * 2).all()


def test_a_stiff_function_takes_an_implicit_method() -> None:
    system = st.System.from_function(
        lambda x, _: [-1e6 * (x[0] - np.cos(x[1])), 1.0], name="stiff", states=("y", "t")
    )
    run = st.simulate(system, None, {"y": 1, "t": 0}, 3.0)
    assert run.attrs["method"] == "lsoda"
    assert run.y.values[-1] == pytest.approx(np.cos(3.0), abs=2e-6)


def test_nothing_counts_as_settled_by_floats() -> None:
    system = oscillator()
    rest = st.Family(system, "rest", at=("k",), held={"q": 0.0, "v": 0.0})
    run = st.simulate(system, {"k": 4, "c": 1.0}, {"q": 1, "v": 0}, 60.0, families=[rest])
    assert (run.attrs["outcome"], str(run.nearest_family.values)) == ("moving", "rest")
    assert float(run.nearest_distance) < 1e-9
    assert "by floats convergence to it is not proved" in run.attrs["evidence"]


@pytest.mark.parametrize(
    "function",
    [
        lambda x, _: [x[0] ** 2],
        lambda x, _: [1 / 0 if x[0] > 2 else 1],
        lambda x, _: [-(x[0] ** -3)],
    ],
    ids=["grows", "raises", "pole"],
)
def test_a_function_without_a_value_ends_the_run(function: Any) -> None:
    system = st.System.from_function(function, name="ends", states=("x",))
    run = st.simulate(system, None, {"x": 1.0}, 5.0)
    assert run.attrs["outcome"] == "unresolved"
    assert "finds no further state" in run.attrs["evidence"]


@pytest.mark.parametrize("method", ["heyoka", "cvodes", "idas"])
def test_methods_that_need_a_graph_are_refused(method: str) -> None:
    with pytest.raises(st.StabilityError, match="takes no Python function; give dop853, lsoda"):
        st.simulate(oscillator(), {"k": 4, "c": 0.3}, {"q": 1, "v": 0}, 1.0, method=method)


@pytest.mark.parametrize(
    ("start", "said"),
    [({"q": 1}, "does not name v"), ({"q": 1, "w": 0}, "names 'w'"), ([1.0], "shape")],
)
def test_wrong_launches_are_refused(start: Any, said: str) -> None:
    with pytest.raises(st.StabilityError, match=said):
        st.simulate(oscillator(), {"k": 4, "c": 0.3}, start, 1.0)
