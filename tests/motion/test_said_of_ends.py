"""What is said of a run that lasted: it rests, lies almost flat, or goes on."""

from typing import Any

import casadi as ca
import numpy as np
import pytest

import stability as st

CALM = "at the end no state changes by more than 1e-06 in a unit of time"
UNLISTED = ", on no steady motion of a known family"
COIN = st.Disk(mass=0.0058, radius=0.012125, gravity=9.81)


def system(name: str, force: Any) -> tuple[st.System, st.Family]:
    x, c = ca.SX.sym("x", 2), ca.SX.sym("c")
    rates = ca.vertcat(x[1], force(x[0], x[1], c))
    found = st.System(name, x, c, rates, states=("q", "v"), parameters=("c",))
    return found, st.Family(found, "origin", at=("c",), held={"q": 0.0, "v": 0.0})


def said(run: Any) -> str:
    assert run.attrs["outcome"] == "moving"
    assert "later times" not in run.attrs["outcome_sentence"]
    return str(run.evidence.values)


def test_a_limit_cycle_is_not_asked_for_later_times() -> None:
    moving, origin = system("van der Pol", lambda q, v, c: c * (1 - q**2) * v - q)
    run = st.simulate(moving, start={"q": 1, "v": 0}, times=50.0, c=1.0, families=origin)
    assert CALM not in said(run)


def test_a_rest_that_no_family_lists_is_told() -> None:
    moving, origin = system("two wells", lambda q, v, c: q - q**3 - c * v)
    start: dict[str, Any] = {"start": {"q": 0.1, "v": 0}, "c": 0.5}
    run = st.simulate(moving, times=100.0, families=origin, **start)
    assert abs(float(run.q[-1])) == pytest.approx(1.0, abs=1e-6)
    assert said(run).endswith(CALM + UNLISTED)
    assert CALM not in said(st.simulate(moving, times=5.0, families=origin, **start))


def test_sticking_is_a_rest() -> None:
    run = st.simulate(st.Disk(), st.Coulomb(0.3), {"theta": np.pi / 2}, 3.0)
    assert said(run).endswith("no settling is proved; it rests")


def test_a_coin_that_lies_almost_flat_is_told() -> None:
    start, against = {"theta": 0.02, "phi_dot": 400.0}, st.RollingResistance(1e-5)
    run = st.simulate(COIN, st.Viscous(0.3), start, 3.0, resistance=against)
    assert 1e-6 < float(run.theta[-1]) < 1e-3
    assert said(run).endswith(f"; it lies {float(run.theta[-1]):.2g} rad from flat")
    upright = st.simulate(COIN, st.Viscous(0.3), {"theta": 1.2, "phi_dot": 50.0}, 0.5)
    assert "flat" not in said(upright)


def test_a_quantity_without_a_value_is_not_moved() -> None:
    start = {"theta": 1.5, "omega3": 3.0, "slip_y": 3.0}
    answer = st.Scene(
        disk=st.Disk(),
        contact=st.Coulomb(0.3),
        start=start,
        horizon=1.0,
        quantities=["final", "settling_time"],
        uncertain={"mu": 0.02},
    ).answer()
    assert answer.spread is not None
    lines = "\n".join(answer.spread.lines())
    assert "moves final by" in lines and "moves settling_time" not in lines
    assert "settling_time: has not settled, at both ends of every uncertain input too" in lines
