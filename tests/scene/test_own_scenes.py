"""Scenes of a user's own system: a towed castor with a tyre that relaxes."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from typing import Any

import casadi as ca
import numpy as np
import pytest
from scipy.integrate import solve_ivp

import stability as st
from stability.scene import ladder

GIVEN = {"v": 3.0, "e": 0.1, "sigma": 0.3, "c": 1.0, "I": 0.5, "K": 3e4, "z0": 0.02}
START = {"psi": 0.05, "r": 0.0, "z": 0.0}
UNITS = {
    "psi": "rad",
    "r": "rad/s",
    "z": "m",
    "v": "m/s",
    "e": "m",
    "sigma": "m",
    "c": "N m s",
    "I": "kg m2",
    "K": "N/m",
    "z0": "m",
}


def rates(x: Any, p: Any, m: Any) -> tuple[Any, Any, Any]:
    """Yaw, its rate, and the deflection of the contact patch; `m` has sin, cos and sqrt."""
    (psi, r, z), (v, e, sigma, c, inertia, k, z0) = x, p
    force = k * z / m.sqrt(1 + (z / z0) ** 2)
    slide = v * m.sin(psi) + e * r - v * m.cos(psi) * z / sigma
    return r, (-c * r - e * force) / inertia, slide


def castor() -> st.System:
    x, p = ca.SX.sym("x", 3), ca.SX.sym("p", 7)
    right = ca.vertcat(*rates(ca.vertsplit(x), ca.vertsplit(p), ca))
    return st.System(
        "castor", x, p, right, states=tuple(START), parameters=tuple(GIVEN), units=UNITS
    )


def scene(horizon: float, tolerance: float, **more: Any) -> st.Scene:
    """The castor beyond its border: it grows from the start to a large swing."""
    return st.Scene(castor(), GIVEN, START, horizon=horizon, tolerance=tolerance, **more)


def truth(horizon: float) -> Any:
    """The final states by SciPy, for a motion that grows e^34 times from its start."""
    found = solve_ivp(
        lambda _, x: rates(x, GIVEN.values(), np),
        [0, horizon],
        list(START.values()),
        method="DOP853",
        rtol=3e-14,
        atol=1e-15,
    )
    return found.y[:, -1]


@pytest.mark.few(1)
@pytest.mark.parametrize(("horizon", "tolerance"), [(7.0, 1e-2), (7.0, 1e-3), (10.0, 0.1)])
def test_the_integrator_tightens_where_its_loose_neighbours_part(
    horizon: float, tolerance: float
) -> None:
    answer = scene(horizon, tolerance).answer()
    true = truth(horizon)
    far = np.abs(np.array(list(answer.value.values())) - true) / np.maximum(1, np.abs(true))
    assert far.max() <= answer.estimate <= tolerance
    assert answer.sentence.startswith("castor answers")


def test_where_no_tightening_helps_the_answer_holds_for_less_than_the_horizon() -> None:
    answer = scene(15.0, 1e-2).answer()
    assert math.isinf(answer.estimate)
    assert 10 < answer.until < 15
    assert f"the answer holds until {answer.until:.4g} s" in answer.sentence


@pytest.mark.few(2)
@pytest.mark.parametrize("horizon", [11.5, 12.0, 12.6])
def test_an_answer_without_a_bound_is_not_said_to_hold_to_the_horizon(horizon: float) -> None:
    """Near the last horizon that is answered, the finest runs agree and their neighbours part."""
    answer = scene(horizon, 0.1).answer()
    assert answer.estimate > 0.1
    assert 10 < answer.until < horizon
    assert f"the answer holds until {answer.until:.4g} s" in answer.sentence


def test_the_report_begins_with_the_question_and_shows_the_digits_that_are_known() -> None:
    answer = scene(4.0, 1e-2).answer()
    head, told, *_ = answer.report().split("\n\n")
    assert head == (
        "system castor: v = 3 m/s, e = 0.1 m, sigma = 0.3 m, c = 1 N m s, I = 0.5 kg m², "
        "K = 30000 N/m, z0 = 0.02 m\n"
        "start: psi = 0.05 rad, all others 0; horizon 4 s; tolerance 0.01"
    )
    for name, value in answer.value.items():
        [text] = re.findall(rf"\b{name} = (\S+) {UNITS[name]}", told)
        error = answer.estimate * max(1.0, abs(value))
        digits = len(text.split(".")[1]) if "." in text else 0
        assert 10.0 ** (1 - digits) > error  # the last digit is the first that the error reaches
        assert abs(float(text) - value) <= 10.0**-digits


def test_a_small_number_shows_no_digit_below_its_error() -> None:
    """The tolerance is over 1 or the size: a state far below 1 is known to few digits."""
    answer = scene(1.0, 1e-2).answer()
    small = replace(answer, estimate=2.2e-4, value={"psi": 0.5, "r": 0.0, "z": 0.000252})
    assert "z = 0.0003 m" in small.report()
    scaled = replace(small, estimate=2.2e-9)
    assert "z = 0.000252 m" in scaled.report()
    lost = replace(small, estimate=math.inf, value={"psi": 0.512, "r": 0.0, "z": 0.000252})
    assert "psi = 0.51 rad" in lost.report()


def test_what_is_built_once_is_not_in_the_cost_of_a_rung(monkeypatch: pytest.MonkeyPatch) -> None:
    """A clock of its own: the first call of each rung takes 0.4 s more."""
    clock, built = [0.0], set()

    def slow(name: str, seconds: float, run: Any) -> Any:
        def call(problem: Any, *args: Any, **more: Any) -> Any:
            clock[0] += seconds + (0.4 if name not in built else 0.0)
            built.add(name)
            return run(problem, *args, **more)

        return call

    monkeypatch.setattr("time.perf_counter", lambda: clock[0])
    monkeypatch.setattr(ladder, "near_steady", slow("near", 1e-3, ladder.near_steady))
    monkeypatch.setattr(ladder, "full", slow("full", 5e-3, ladder.full))
    asked = scene(2.0, 1e-2)
    first, later = asked.answer(), asked.answer()
    for answer, once in ((first, 0.4), (later, 0.0)):
        assert [r.cost for r in answer.rungs] == pytest.approx([1e-3, 5e-3])
        assert [r.built for r in answer.rungs] == pytest.approx([once, once])
    assert "built once, not in the costs: 400 ms for linearised, 400 ms for castor" in (
        first.report()
    )
    assert "built once" not in later.report()
    assert first.value == later.value
