"""Odd input of a hostile user to systems of any source: one sentence, and no word of a disk."""

import warnings
from collections.abc import Callable
from typing import Any

import casadi as ca
import numpy as np
import pytest
import sympy as sp
from scipy.optimize import brentq
from sympy.physics.mechanics import dynamicsymbols

import stability as st

X, C = ca.SX.sym("x", 2), ca.SX.sym("c")


def spring(**more: Any) -> st.System:
    rates = ca.vertcat(X[1], -X[0] - C * X[1])
    return st.System("spring", X, C, rates, states=("q", "v"), parameters=("c",), **more)


def numeric(rates: Callable[[Any, Any], Any]) -> Any:
    return st.System.from_function(rates, name="box", states=("q", "v"), parameters=("c",))


SPRING, BOX = spring(), numeric(lambda x, p: [x[1], -x[0] - p[0] * x[1]])
REST = st.Family(SPRING, "rest", at=("c",), held={"q": 0, "v": 0})
OUTSIDE = spring(conditions=(st.Condition(X[0] - 1, "q is {value}"),))
U, V = sp.symbols("u v")

REFUSED: list[tuple[str, Callable[[], Any], str]] = [
    ("numeric basins", lambda: st.basins(BOX, horizon=1.0), "box is a numeric system"),
    ("numeric scene", lambda: st.Scene(BOX, {"c": 1}, [1, 0], 1.0), "box is a numeric system"),
    ("numeric steady", lambda: BOX.steady("c", guess={"q": 0.0}), "box is a numeric system"),
    ("numeric ignorable", lambda: BOX.ignorable, "box is a numeric system"),
    ("complex rates", lambda: numeric(lambda x, _: [x[1], 1j]).rates([0, 0], [1]), "are complex"),
    ("no system", lambda: st.simulate("spring", None, [1, 0], 1.0), "stability.Disk, a Body"),
    ("flat", lambda: st.simulate(SPRING, {"c": 1}, [1, 0], 1.0, flat=0.05), "only a disk falls"),
    ("no start", lambda: st.simulate(SPRING, {"c": 1}, None, 1.0), "by name or in order: q, v"),
    ("a law", lambda: st.simulate(SPRING, st.Viscous(1), [1, 0], 1.0), "by name or in order: c"),
    (
        "no member anywhere",
        lambda: st.conditions(st.Family(OUTSIDE, "rest", at=("c",), held={"q": 0, "v": 0})),
        "rest has no member anywhere: q is -1.0.",
    ),
    (
        "a function of a state",
        lambda: st.System.from_sympy({U: V, V: sp.Function("f")(U)}),
        "hold 'f(u)', an unknown function of a state",
    ),
    ("no equations", lambda: st.System.from_sympy({}), "model is an empty mapping"),
    ("axis backwards", lambda: st.boundaries(REST, axis=("c", 1, -1, 5)), "axis c runs from 1"),
]


@pytest.mark.parametrize(("call", "words"), [c[1:] for c in REFUSED], ids=[c[0] for c in REFUSED])
def test_it_is_refused_in_one_sentence(call: Callable[[], Any], words: str) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(st.StabilityError) as caught:
            call()
    assert words in str(caught.value)
    assert "axis axis" not in str(caught.value)
    if "stability.Disk, a Body" != words:
        assert "give a stability.Disk" not in str(caught.value)


def test_a_function_of_time_and_one_of_parameters_stay_inputs() -> None:
    q, force = dynamicsymbols("q force")
    a = sp.Symbol("a")
    system = st.System.from_sympy({q: force - q * sp.Function("g")(a)})
    assert set(system.parameters) >= {"force", "g"}


def test_a_condition_that_ends_like_a_root_warns_of_nothing() -> None:
    """Slope and rate of √(q - ½) are both infinite where it reaches zero."""
    ends = spring(conditions=(st.Condition(ca.sqrt(X[0] - 0.5), "q is {value}"),))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        run = st.simulate(ends, {"c": 0.1}, [1.0, 0.0], 5.0)
    turn = np.sqrt(1 - 0.05**2)

    def above(t: float) -> float:
        swing = np.cos(turn * t) + 0.05 / turn * np.sin(turn * t)
        return float(np.exp(-0.05 * t) * swing - 0.5)

    assert run.attrs["outcome"] == "domain-end"
    assert float(run.end_time) == pytest.approx(brentq(above, 0.5, 1.5), abs=1e-6)
    assert not np.isnan(float(run.end_time_error))
