"""Creep along motions of bodies: its orders against the full model and the laws of creep."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
from random_body_scenes import columns, far

import stability as st
from stability.scene.rungs.creep import CreepPath, creep_path, held_of, transient

BODIES = {
    "disk": st.Disk(),
    "torus": st.Torus(0.2),
    "egg": st.Egg(0.2),
    "spheroid": st.Spheroid(0.6),
    "thick disk": st.ThickDisk(0.3),
}
LEAST = {"thick disk": 400.0}
"""Friction of a body from which the next power of 1/mu is small; 200 for others."""
START = {"theta": 1.3, "theta_dot": 0.1, "phi_dot": 0.2, "omega3": 2.0}
LAST, FRICTION, ORDERS = 4.0, 200.0, (0, 1, 2)


@cache
def orders(name: str, law: type[Any], mu: float) -> tuple[Any, CreepPath]:
    """The state in which creep begins with its time, and all orders from there."""
    problem = st.Scene(BODIES[name], law(mu), START, horizon=LAST)._problem(law(mu))
    held = held_of(problem)
    times, states, end = transient(problem, held, problem.start, 0.0, 1e-12)
    assert end is None
    path = creep_path(problem, held, states[-1], float(times[-1]), LAST, 1e-11)
    assert isinstance(path, CreepPath)
    return (float(times[-1]), states[-1]), path


@cache
def errors(name: str, law: type[Any], mu: float) -> tuple[list[float], list[float]]:
    """True and stated error of each order at the end, by `simulate` of the law itself."""
    _, path = orders(name, law, mu)
    run = st.simulate(BODIES[name], law(mu), START, [LAST], tolerance=1e-13, check=False)
    truth = columns(run)[-1]
    at = path.elements.at
    last = np.array([LAST])
    found = [at(last, o.states)[0] for o in path.orders]
    stated = [far(truth + at(last, o.errors)[0], truth) for o in path.orders]
    return [far(state, truth) for state in found], stated


@pytest.mark.few(4)
@pytest.mark.parametrize("law", [st.Viscous, st.LinearViscous])
@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("name", BODIES)
def test_the_error_of_an_order_falls_with_friction(name: str, law: type[Any], order: int) -> None:
    """An expansion in 1/mu: order n is wrong by mu to the power -(n + 1)."""
    mu = LEAST.get(name, FRICTION)
    less, more = (errors(name, law, m)[0][order] for m in (mu, 2 * mu))
    assert less / more == pytest.approx(2 ** (order + 1), rel=0.25)


@pytest.mark.few(4)
@pytest.mark.parametrize("law", [st.Viscous, st.LinearViscous])
@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("name", BODIES)
def test_the_correction_of_the_next_order_is_the_error_of_this_one(
    name: str, law: type[Any], order: int
) -> None:
    true, stated = (v[order] for v in errors(name, law, FRICTION))
    assert stated == pytest.approx(true, rel=0.3)


@pytest.mark.parametrize("order", [1, 2, 3])
@pytest.mark.parametrize("name", ["disk", pytest.param("torus", marks=pytest.mark.long)])
def test_an_order_is_the_law_of_creep_of_that_order(name: str, order: int) -> None:
    """Both leave out the same power of 1/mu: they differ by no more than twice their error."""
    mu = FRICTION
    (begin, start), path = orders(name, st.Viscous, mu)
    law = st.Creep(mu, order=order)
    run = st.simulate(BODIES[name], law, start[:4], [LAST - begin], tolerance=1e-12)
    other = columns(run)[-1, :4]
    mine = path.elements.at(np.array([LAST]), path.orders[order].path)[0]
    before = path.elements.at(np.array([LAST]), path.orders[order - 1].path)[0]
    apart = far(mine, other)
    assert apart < 0.2 * far(before, other)
    assert apart < 2 * errors(name, st.Viscous, mu)[0][order] + 1e-11
