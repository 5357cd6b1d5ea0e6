"""Linear systems are recognised by a proof, and no status speaks of higher orders then."""

from collections.abc import Callable, Sequence
from typing import Any

import casadi as ca
import pytest

import stability as st
from stability.systems.structure.linearity import linear

Rates = Callable[[Any, Any], Sequence[Any]]


def family(rates: Rates, count: int = 2) -> st.Family:
    x, p = ca.SX.sym("x", count), ca.SX.sym("p", 2)
    system = st.System(
        "oscillator",
        x,
        p,
        ca.SX(ca.vertcat(*rates(x, p))),
        states=("q", "v", "angle")[:count],
        parameters=("c", "k"),
    )
    return st.Family(system, "rest", at=("c",), held=dict.fromkeys(system.states, 0))


def spring(x: Any, p: Any, more: Any = 0) -> tuple[Any, Any]:
    return x[1], -p[1] * x[0] + p[0] * x[1] + more


LINEAR: list[tuple[str, Rates, int]] = [
    ("plain", spring, 2),
    ("terms cancel", lambda x, p: spring(x, p, (x[0] + 1) ** 2 - x[0] ** 2 - 2 * x[0] - 1), 2),
    (
        "sines cancel",
        lambda x, p: (x[1], -p[1] * x[0] + p[0] * x[1] * (ca.sin(x[0]) ** 2 + ca.cos(x[0]) ** 2)),
        2,
    ),
    ("functions of parameters", lambda x, p: (x[1], -ca.exp(p[1]) * x[0] + p[0] * x[1]), 2),
    ("a state that follows", lambda x, p: (*spring(x, p), x[0] * ca.cos(x[1])), 3),
]
OTHERS: list[tuple[str, Rates]] = [
    ("a tiny term", lambda x, p: spring(x, p, -1e-12 * x[0] ** 2 * x[1])),
    ("no term of order two or three", lambda x, p: spring(x, p, -(x[0] ** 5))),
    ("an absolute value", lambda x, p: spring(x, p, 1 - ca.fabs(x[1] - 1) - x[1])),
    ("a sign, whose slope is zero", lambda x, p: spring(x, p, ca.sign(x[0] - 1) + 1)),
]


@pytest.mark.parametrize(("rates", "count"), [c[1:] for c in LINEAR], ids=[c[0] for c in LINEAR])
def test_a_linear_system_is_said_to_be_linear(rates: Rates, count: int) -> None:
    rest = family(rates, count)
    assert linear(rest.system)
    [birth] = st.hopf(rest, axis=("c", -1, 1, 9), k=1.0)
    assert birth.kind is st.Onset.LINEAR
    assert "terms of order two and three vanish identically" in birth.reason
    assert birth.coefficient == 0 and birth.coefficient_error < 1e-300
    found = st.spectrum(rest, at=0.0, k=1.0)
    assert found.verdict is st.Verdict.NEUTRAL
    assert found.nonlinear is st.Nonlinear.LINEAR
    assert "no higher orders exist" in found.nonlinear.value
    decaying = st.spectrum(family(spring), at=-1.0, k=1.0)
    assert decaying.nonlinear is st.Nonlinear.ASYMPTOTIC


@pytest.mark.parametrize("rates", [c[1] for c in OTHERS], ids=[c[0] for c in OTHERS])
def test_no_other_system_is_called_linear(rates: Rates) -> None:
    rest = family(rates)
    assert not linear(rest.system)
    found = st.spectrum(rest, at=0.0, k=1.0)
    assert found.nonlinear is not st.Nonlinear.LINEAR
    for birth in st.hopf(rest, axis=("c", -1.5, 1.5, 9), k=1.0):
        assert birth.kind is not st.Onset.LINEAR


def test_a_numeric_system_is_never_called_linear() -> None:
    def rates(x: Any, p: Any) -> list[float]:
        return [x[1], -x[0] + p[0] * x[1]]

    numeric = st.System.from_function(rates, name="n", states=("q", "v"), parameters=("c",))
    rest = st.Family(numeric, "rest", at=("c",), held={"q": 0, "v": 0})
    assert st.spectrum(rest, at=0.0).nonlinear is st.Nonlinear.OPEN
