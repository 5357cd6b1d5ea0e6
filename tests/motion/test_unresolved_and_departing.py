"""Motions of a user's system that leave an unstable steady motion, and runs that give up."""

import math
from typing import Any

import casadi as ca
import numpy as np
import pytest

import stability as st
from stability.settling.departure import departures
from stability.settling.system_lines import system_settling

METHODS = ("auto", "heyoka", "dop853", "lsoda", "radau", "bdf", "cvodes")
LIBRARY_WORDS = ("taylor", "outcome", "err_", "spacing between", "heyoka stopped")


def growing() -> tuple[st.System, st.Family]:
    """ẋ = c x, with the closed form x₀ e^(c t)."""
    x, c = ca.SX.sym("x"), ca.SX.sym("c")
    system = st.System("growth", x, c, c * x, states=("x",), parameters=("c",))
    return system, st.Family(system, "rest", at=("c",), held={"x": 0})


def pitchfork() -> tuple[st.System, st.Family, st.Family]:
    """ẋ = r x - x³: zero is unstable for r > 0, and √r is stable."""
    x, r = ca.SX.sym("x"), ca.SX.sym("r")
    system = st.System("fork", x, r, r * x - x**3, states=("x",), parameters=("r",))
    zero = st.Family(system, "zero", at=("r",), held={"x": 0})
    side = st.Family(
        system, "side", at=("r",), unknown={"x": 1.0}, equations=("x",), positive=("x",)
    )
    return system, zero, side


def oscillator() -> tuple[st.System, st.Family]:
    """ẋ = v, v̇ = -w²x - cv: its amplitude, v²/w² + x², grows as exp(-ct) for small c."""
    x, p = ca.SX.sym("x", 2), ca.SX.sym("p", 2)
    rate = ca.vertcat(x[1], -(p[0] ** 2) * x[0] - p[1] * x[1])
    system = st.System("oscillator", x, p, rate, states=("q", "v"), parameters=("w", "c"))
    return system, st.Family(system, "rest", at=("w",), held={"q": 0, "v": 0})


def said(run: Any) -> str:
    return str(run.attrs["evidence"])


# --- departures ---


def test_a_motion_departs_from_an_unstable_member_and_says_how_far() -> None:
    system, rest = growing()
    run = st.simulate(system, {"c": 0.5}, {"x": 1e-3}, 10.0, families=rest)
    assert run.attrs["outcome"] == "moving"
    far = 1e-3 * math.exp(5)
    assert said(run).endswith(
        f"departs from rest, unstable at c = 0.5: 0.001 away at the start, {far:.3g} at the end"
    )


@pytest.mark.parametrize(
    ("c", "start", "last", "why"),
    [
        (-0.5, 1e-3, 10.0, "stable"),
        (0.5, 1e-3, 2.0, "grown by e only"),
        (0.0, 1.0, 10.0, "still"),
        (0.5, 1e-6, 5.0, "within settle"),
        (0.5, 0.0, 10.0, "on the member itself"),
    ],
)
def test_no_other_motion_departs(c: float, start: float, last: float, why: str) -> None:
    system, rest = growing()
    run = st.simulate(system, {"c": c}, {"x": start}, last, families=rest)
    assert "departs" not in said(run), why


def test_a_motion_departs_from_one_family_and_settles_on_another() -> None:
    system, zero, side = pitchfork()
    starts = {"x": [0.01, 0.9, 0.01]}
    run = st.simulate(system, {"r": [1.0, 1.0, -1.0]}, starts, 40.0, families=[zero, side])
    evidence = run.evidence.values.tolist()
    assert run.attrs["outcome"] == "3 settled"
    assert ["departs from zero, unstable at r = 1" in e for e in evidence] == [True, False, False]


@pytest.mark.parametrize(("c", "departs"), [(-1e-6, False), (-0.4, False), (-1.0, True)])
def test_the_phase_of_a_swing_is_no_departure(c: float, departs: bool) -> None:
    """At the last time the distance is 20 times the first one, by the phase or by growth.

    The amplitudes grow by 1.000003, 2.8 and 12.8.
    """
    system, rest = oscillator()
    run = st.simulate(system, {"w": 20.0, "c": c}, {"q": 0.01, "v": 0.0}, 5.105, families=rest)
    far = float(np.hypot(run.q[-1], run.v[-1]))
    assert far > 0.19
    assert ("departs from rest" in said(run)) == departs


def test_no_departure_is_told_where_the_error_hides_it() -> None:
    _, rest = growing()
    ends = np.array([[0.2], [0.2]])
    found = departures(
        system_settling((rest,)),
        ends / 100,
        ends,
        np.array([[0.5], [0.5]]),
        1e-3,
        np.array([0.1, 0.199]),
    )
    assert [bool(words) for words in found] == [True, False]


# --- runs that give up ---


@pytest.mark.parametrize(
    "method",
    [
        pytest.param(m, marks=[pytest.mark.long] * (m in ("auto", "radau", "bdf", "cvodes")))
        for m in METHODS
    ],
)
def test_an_overflow_is_told_in_words_with_a_remedy(method: str) -> None:
    system, rest = growing()
    run = st.simulate(system, {"c": 1.0}, {"x": 1.0}, 1000.0, families=rest, method=method)
    assert run.attrs["outcome"] == "unresolved"
    assert "the state has grown to" in said(run)
    assert "ask for an earlier last time" in said(run)
    assert not any(word in said(run) for word in LIBRARY_WORDS)
    assert float(run.x[-1]) == pytest.approx(math.exp(float(run.end_time)), rel=1e-3)
    assert float(run.final_error) == math.inf


@pytest.mark.parametrize("method", METHODS)
def test_a_limit_of_steps_is_told_in_words_with_a_remedy(method: str) -> None:
    system, _ = growing()
    run = st.simulate(system, {"c": 1.0}, {"x": 1.0}, 30.0, method=method, max_steps=2)
    assert run.attrs["outcome"] == "unresolved"
    assert said(run) == "max_steps = 2 steps were not enough; give a larger max_steps"
    assert float(run.final_error) == math.inf


@pytest.mark.few(1)
@pytest.mark.parametrize("method", ["auto", "dop853", "radau", "cvodes"])
def test_a_pole_in_time_is_told_in_words_and_no_limit_is_blamed(method: str) -> None:
    """ẋ = x² reaches infinity at 1, and ẋ = -1/x has no value from 1/2 on."""
    x = ca.SX.sym("x")
    for rate, end in ((x**2, 1.0), (-1 / x, 0.5)):
        system = st.System("pole", x, ca.SX(0, 1), rate, states=("x",))
        run = st.simulate(system, None, [1.0], 2.0, method=method)
        assert run.attrs["outcome"] == "unresolved"
        assert "finds no further state: the motion grows without bound, or" in said(run)
        assert not any(word in said(run) for word in LIBRARY_WORDS)
        assert float(run.end_time) == pytest.approx(end, abs=1e-5)


@pytest.mark.few(1)
@pytest.mark.parametrize("method", ["auto", "dop853"])
def test_a_launch_that_overflows_spoils_no_other_of_its_batch(method: str) -> None:
    system, rest = growing()
    run = st.simulate(
        system,
        {"c": 1.0},
        {"x": [1.0, 1e99, 1e-3]},
        60.0 + np.arange(100.0),
        families=rest,
        method=method,
    )
    assert run.outcome.values.tolist() == [
        st.Outcome.MOVING.code,
        st.Outcome.UNRESOLVED.code,
        st.Outcome.MOVING.code,
    ]
    assert np.isfinite(run.x.values).all()
    assert float(run.x[0, -1]) == pytest.approx(math.exp(159), rel=1e-5)
    assert np.isfinite(run.final_error.values).tolist() == [True, False, True]
    assert "departs" in str(run.evidence.values[0])


def test_without_neighbours_there_is_no_error() -> None:
    system, _ = growing()
    assert "final_error" not in st.simulate(system, {"c": 1.0}, {"x": 1.0}, 2.0, check=False)


def test_a_motion_that_turns_stiff_is_run_by_an_implicit_method() -> None:
    """Robertson's reaction: right is 0.0178659211, by SciPy's Radau at 1e-11."""
    y, k = ca.SX.sym("y", 3), ca.SX.sym("k")
    slow, back, fast = 0.04 * y[0], k * y[1] * y[2], 3e7 * y[1] ** 2
    rates = ca.vertcat(back - slow, slow - back - fast, fast)
    system = st.System("robertson", y, k, rates, states=("x", "y", "z"), parameters=("k",))
    run = st.simulate(system, [1e4], [1.0, 0.0, 0.0], 1e5, max_steps=100_000)
    assert run.attrs["outcome"] == "moving"
    assert str(run.method.values) == "cvodes"
    assert float(run.x[-1]) == pytest.approx(0.0178659211, abs=2e-8)
    assert abs(float(run.x[-1]) - 0.0178659211) <= float(run.final_error) < 1e-6


def test_a_motion_that_is_stiff_only_on_its_way_is_run_by_an_implicit_method() -> None:
    """The Oregonator at a coarse tolerance: right is 1.0008149, by SciPy's Radau at 1e-11."""
    y = ca.SX.sym("y", 3)
    rates = ca.vertcat(
        77.27 * (y[1] + y[0] * (1 - 8.375e-6 * y[0] - y[1])),
        (y[2] - (1 + y[0]) * y[1]) / 77.27,
        0.161 * (y[0] - y[2]),
    )
    system = st.System("oregonator", y, ca.SX(0, 1), rates, states=("x", "y", "z"), parameters=())
    run = st.simulate(system, None, [1.0, 2.0, 3.0], 360.0, tolerance=1e-4, max_steps=100_000)
    assert run.attrs["outcome"] == "moving"
    assert abs(float(run.x[-1]) - 1.0008149) <= float(run.final_error) < 1e-1
