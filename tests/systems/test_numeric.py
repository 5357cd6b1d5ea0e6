"""Numeric systems: a Python function gets discs that hold the true eigenvalues, and no proof."""

from collections.abc import Callable
from typing import Any

import mpmath
import numpy as np
import pytest

import stability as st

SWING = {"name": "swing", "states": ("q", "v"), "parameters": ("g", "c", "T")}


def swing(x: Any, p: Any) -> list[float]:
    return [x[1], -p[0] * np.sin(x[0]) - p[1] * x[1] + p[2]]


def rest(function: Callable[[Any, Any], Any] = swing) -> st.Family:
    system = st.System.from_function(function, **SWING)
    return st.Family(
        system, "rest", at=("T",), held={"v": 0.0}, unknown={"q": 0.1}, equations=("v",)
    )


def true_values(g: float, c: float, torque: float) -> list[complex]:
    """Roots of λ² + c λ + g cos q with g sin q = T, by mpmath."""
    with mpmath.workdps(40):
        q = mpmath.asin(mpmath.mpf(torque) / mpmath.mpf(g))
        roots = mpmath.polyroots([1, mpmath.mpf(c), mpmath.mpf(g) * mpmath.cos(q)], extraprec=200)
        return [complex(r) for r in roots]


@pytest.mark.few(6)
@pytest.mark.parametrize("torque", [0.0, 0.5, 3.0, -8.0])
@pytest.mark.parametrize("c", [-0.3, 0.2, 9.0])
def test_the_discs_hold_the_true_eigenvalues(torque: float, c: float) -> None:
    found = st.spectrum(rest(), at=torque, g=9.81, c=c)
    for value in true_values(9.81, c, torque):
        off = np.abs(found.eigenvalues - value)
        assert (off <= found.radius).any()
    assert found.radius.max() < 1e-9
    assert found.verdict.word == ("unstable" if c < 0 else "stable")
    assert "not proved" in found.reason
    assert not found.certified


def test_a_verdict_within_the_estimate_is_undecided() -> None:
    assert st.spectrum(rest(), at=0.5, g=9.81, c=0.0).verdict.word == "undecided"
    assert st.spectrum(rest(), at=0.5, g=9.81, c=1e-14).verdict.word == "undecided"


def test_noise_widens_the_discs() -> None:
    """An error of 1e-9 that looks random widens the error of the derivative."""

    def rough(x: Any, p: Any) -> Any:
        wobble = 1e-9 * np.sin(1e9 * np.array([x[0], x[0] + x[1]]))
        return np.array(swing(x, p)) + wobble

    system = st.System.from_function(rough, **SWING)
    found = system.derivative(np.array([0.3, 0.1]), np.array([9.81, 0.2, 0.0]))
    true = np.array([[0, 1], [-9.81 * np.cos(0.3), -0.2]])
    assert (np.abs(found.value - true) <= found.error + 1e-12).all()
    assert 1e-12 < found.error.max() < 1e-3


CURVED = [
    (lambda t: np.exp(30 * t), 30.0),
    (lambda t: np.sin(200 * t), 200.0),
    (lambda t: 1 / (1.001 - t), 1 / 1.001**2),
    (lambda t: 1e8 + t, 1.0),
    (lambda t: np.arctan(1e3 * t), 1e3),
    (lambda t: t**3, 0.0),
]


@pytest.mark.parametrize(("function", "slope"), CURVED)
def test_the_estimate_of_the_error_holds_for_hard_functions(
    function: Callable[[float], float], slope: float
) -> None:
    system = st.System.from_function(lambda x, _: [function(x[0])], states=("x",))
    found = system.derivative(np.zeros(1), np.zeros(0))
    assert abs(found.value[0, 0] - slope) <= found.error[0, 0]


@pytest.mark.parametrize("size", [1.0, 1e-6])
def test_a_kink_is_refused(size: float) -> None:
    system = st.System.from_function(
        lambda x, _: [x[1], -x[0] - size * abs(x[0]) - x[1]], name="kink", states=("q", "v")
    )
    family = st.Family(system, "rest", at=("q",), held={"v": 0.0})
    with pytest.raises(st.StabilityError, match="kink along q"):
        st.spectrum(family, at=0.0)


def test_everything_that_needs_a_graph_is_refused_in_one_sentence() -> None:
    family = rest()
    asked: list[Callable[[], Any]] = [
        lambda: st.spectrum(family, at=0.5, g=9.81, c=0.2, certify=True),
        lambda: st.stability_map(family, x=("c", -1, 1, 4), y=("g", 1, 2, 4), at=0.5, certify=True),
        lambda: st.hopf(family, axis=("c", -1, 1, 20), at=0.5, g=9.81),
        lambda: st.codimension_two(family, x=("c", -1, 1, 4), y=("g", 1, 2, 4), at=0.5),
        lambda: st.conditions(family),
        lambda: st.explore(family, at=0.5, g=9.81, c=0.2),
        lambda: st.Scene(family.system, [9.81, 0.2, 0.5], [0.1, 0.0], 5.0),
        lambda: st.basins(family.system, x=("q", 0, 1, 2), y=("v", 0, 1, 2), horizon=1.0),
        lambda: family.system.equilibria({"q": (-1, 1), "v": 0.0}, g=9.81, c=0.2, T=0.5),
        lambda: family.system.steady("T", guess={"q": 0.1}),
        lambda: st.branch(family, 0.0, 1.0, [9.81, 0.2]),
        lambda: family.system.rhs,
        lambda: family.system.x,
        lambda: family.system.p,
    ]
    for ask in asked:
        with pytest.raises(st.StabilityError, match="is a numeric system: a Python function gives"):
            ask()


def test_arrays_and_modes_work() -> None:
    found = st.spectrum(rest(), at=[0.0, 0.5, 1.0], g=9.81, c=0.2)
    assert found.eigenvalues.shape == (3, 2)
    assert found.states[:, 0] == pytest.approx(np.arcsin(np.array([0, 0.5, 1]) / 9.81), abs=1e-12)
    one = st.spectrum(rest(), at=0.5, g=9.81, c=0.2)
    assert one.modes.labels == ("decaying oscillation of v", "decaying oscillation of v")


def test_motions_that_are_not_steady_or_not_reached_are_refused() -> None:
    with pytest.raises(st.StabilityError, match="no member that Newton"):
        st.spectrum(rest(), at=20.0, g=9.81, c=0.2)  # sin q = 2
    system = st.System.from_function(swing, **SWING)
    held = st.Family(system, "held", at=("T",), held={"v": 0.0, "q": 0.3})
    with pytest.raises(st.StabilityError, match="is not steady: v still changes"):
        st.spectrum(held, at=0.0, g=9.81, c=0.2)


@pytest.mark.parametrize(
    ("function", "said"),
    [
        (lambda x, _: [x[1]], "returns 1 rates for 2 states"),
        (lambda *_: 1 / 0, "fails at .*ZeroDivisionError"),
        (lambda x, _: [x[1], np.nan], "not finite"),
        (lambda *_: "no", "fails at"),
        (lambda x: x, "fails at .*TypeError"),
    ],
)
def test_wrong_functions_are_refused(function: Callable[..., Any], said: str) -> None:
    system = st.System.from_function(function, name="wrong", states=("q", "v"))
    with pytest.raises(st.StabilityError, match=said):
        system.rates([0.0, 1.0], [])


def test_names_are_needed_and_checked() -> None:
    for given, said in (
        ({}, "states is empty"),
        ({"states": ("q", "q")}, "twice"),
        ({"states": ("q",), "parameters": ("q",)}, "a state and a parameter"),
        ({"states": ("q",), "name": ""}, "name of the system"),
    ):
        with pytest.raises(st.StabilityError, match=said):
            st.System.from_function(swing, **given)
