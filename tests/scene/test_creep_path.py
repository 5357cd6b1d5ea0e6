"""Creep along one motion: its orders against the full model and against the laws of creep."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest

import stability as st
from stability.scene.rungs.creep import CreepPath, creep_path, held_of, transient
from stability.scene.rungs.track import relative

START = {"theta": 1.3, "theta_dot": 0.1, "phi_dot": 0.2, "omega3": 2.0}
STATES = ("theta", "theta_dot", "phi_dot", "omega3", "slip_x", "slip_y")
LAST, FRICTIONS, ORDERS = 4.0, (200.0, 400.0), (0, 1, 2)


@cache
def orders(law: type[Any], mu: float) -> tuple[Any, CreepPath]:
    """The state in which creep begins with its time, and all orders from there."""
    problem = st.Scene(contact=law(mu), start=START, horizon=LAST)._problem(law(mu))
    held = held_of(problem)
    times, states, end = transient(problem, held, problem.start, 0.0, 1e-12)
    assert end is None
    path = creep_path(problem, held, states[-1], float(times[-1]), LAST, 1e-11)
    assert isinstance(path, CreepPath)
    return (float(times[-1]), states[-1]), path


@cache
def errors(law: type[Any], mu: float) -> tuple[list[float], list[float]]:
    """True and stated error of each order at the end, by `simulate` of the law itself."""
    (begin, start), path = orders(law, mu)
    run = st.simulate(st.Disk(), law(mu), start, [LAST - begin], tolerance=1e-13)
    truth = np.array([float(run[n][-1]) for n in STATES])
    at = path.elements.at
    last = np.array([LAST])
    found = [at(last, o.states)[0] for o in path.orders]
    stated = [float(relative(at(last, o.errors)[0], truth)) for o in path.orders]
    return [float(relative(state - truth, truth)) for state in found], stated


@pytest.mark.few(2)
@pytest.mark.parametrize("law", [st.Viscous, st.LinearViscous])
@pytest.mark.parametrize("order", ORDERS)
def test_the_error_of_an_order_falls_with_friction(law: type[Any], order: int) -> None:
    """An expansion in 1/mu: order n is wrong by mu to the power -(n + 1)."""
    less, more = (errors(law, mu)[0][order] for mu in FRICTIONS)
    assert less / more == pytest.approx(2 ** (order + 1), rel=0.25)


@pytest.mark.parametrize("law", [st.Viscous, st.LinearViscous])
@pytest.mark.parametrize("order", ORDERS)
def test_the_correction_of_the_next_order_is_the_error_of_this_one(
    law: type[Any], order: int
) -> None:
    true, stated = (v[order] for v in errors(law, FRICTIONS[0]))
    assert stated == pytest.approx(true, rel=0.3)


@pytest.mark.parametrize(("order", "law"), [(1, st.Creep1), (2, st.Creep2), (3, st.Creep3)])
def test_an_order_is_the_law_of_creep_of_that_order(order: int, law: type[Any]) -> None:
    """Both leave out the same power of 1/mu: they differ by no more than twice their error."""
    mu = FRICTIONS[0]
    (begin, start), path = orders(st.Viscous, mu)
    run = st.simulate(st.Disk(), law(mu), start[:4], [LAST - begin], tolerance=1e-12)
    other = np.array([float(run[n][-1]) for n in STATES[:4]])
    mine = path.elements.at(np.array([LAST]), path.orders[order].path)[0]
    before = path.elements.at(np.array([LAST]), path.orders[order - 1].path)[0]
    apart = float(relative(mine - other, other))
    assert apart < 0.2 * float(relative(before - other, other))
    assert apart < 2 * errors(st.Viscous, mu)[0][order] + 1e-11
