"""A body held to a slip, against its rough and viscous equations at random states."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from disk_as_body import disk_as_body

import stability as st
from stability.bodies.model import Model
from stability.motion.round_starts import gather_round as gather

RNG = np.random.default_rng(7)
COUNT = 50
ANGLES = np.column_stack([RNG.uniform(0.5, 2.6, COUNT), RNG.normal(size=(COUNT, 3))])
SLIPS = RNG.normal(size=(COUNT, 2))
AXES = RNG.normal(size=(COUNT, 3))
TURNING = np.hstack([AXES / np.linalg.norm(AXES, axis=1)[:, None], RNG.normal(size=(COUNT, 3))])
DRAG = st.RollingResistance(0.01), st.PivotingResistance(0.02), st.AirTorque(0.03)
BODIES = {
    "disk": st.Disk(k=0.4),
    "disk as a body": disk_as_body(st.Disk(k=0.4)),
    "torus": st.Torus(0.2),
    "egg": st.Egg(0.2),
    "sphere": st.EccentricSphere(0.15, axial=0.4, transverse=0.45),
}


def launch(name: str, law: Any) -> tuple[Model, np.ndarray, np.ndarray]:
    """Model, parameters and random states without slip, of a body by name; with drag if it says so.

    States lie along fixed axes where the body is smooth at a pole.
    """
    name, _, drag = name.partition(" with ")
    body, start = BODIES[name], {"theta": 1.5, "omega3": 1.0}
    if isinstance(body, st.Disk):
        found = gather(body, law, start, 1.0)
    else:
        found = gather(body, law, start, 1.0, resistance=DRAG if drag else None)
    turning = found.model.system.states[0] == "axis_X"
    return found.model, found.p[0], TURNING if turning else ANGLES


def held(model: Model, p: np.ndarray, x: Any, slip: Any, rate: Any) -> tuple[Any, Any, Any]:
    """Rates, forces with the normal force, and slope of the rates, one row for each state."""
    assert model.held is not None
    names, rough = model.system.parameters, model.held.rough().system
    own = [float(p[names.index(n)]) for n in rough.parameters]
    given = [list(x.T), own, list(slip.T), list(rate.T)]
    motion, slope = model.held.programs()
    rates, forces = (v.reshape(len(x), -1) for v in motion.arrays(given, (len(x),)))
    n = x.shape[1]
    return rates, forces, slope.arrays(given, (len(x),))[0].reshape(len(x), n, n)


EVERY = [*BODIES, "torus with drag", "egg with drag"]


@pytest.mark.parametrize("name", EVERY)
def test_without_slip_it_is_the_rough_body(name: str) -> None:
    model, p, states = launch(name, st.Viscous(1.0))
    none = np.zeros_like(SLIPS)
    rates, forces, _ = held(model, p, states, none, none)
    rough = model.held.rough().system  # type: ignore[union-attr]
    own = [p[model.system.parameters.index(n)] for n in rough.parameters]
    own = np.tile(np.array(own).reshape(1, -1), (COUNT, 1))
    np.testing.assert_allclose(rates, rough.rates(states, own), rtol=1e-9, atol=1e-11)
    seen = rough.observe(states, own)
    np.testing.assert_allclose(forces[:, 2], np.ravel(seen["normal_force"]), rtol=1e-9, atol=1e-11)


@pytest.mark.parametrize("name", EVERY)
@pytest.mark.parametrize("law", [st.Viscous(0.3), st.Viscous(30.0), st.LinearViscous(30.0)])
def test_with_the_slip_of_a_law_it_is_that_law(name: str, law: Any) -> None:
    """Slip and its rate give back the law's motion and its force, -mu N slip or -c slip."""
    model, p, states = launch(name, law)
    [mu] = [v for v in law.given.values() if v is not None]
    slip = SLIPS * 0.1 / mu  # so small that D is positive
    every = np.hstack([states, slip])
    full = model.system.rates(every, np.tile(p, (COUNT, 1)))
    n = states.shape[1]
    rates, forces, _ = held(model, p, states, slip, full[:, n:])
    np.testing.assert_allclose(rates, full[:, :n], rtol=1e-8, atol=1e-10)
    load = forces[:, 2:] if isinstance(law, st.Viscous) else 1.0
    np.testing.assert_allclose(forces[:, :2], -mu * load * slip, rtol=1e-8, atol=1e-10)


@pytest.mark.parametrize("name", EVERY)
def test_the_slope_is_that_of_the_rates(name: str) -> None:
    model, p, states = launch(name, st.Viscous(1.0))
    step, rate = 1e-5, SLIPS[::-1]
    _, _, slope = held(model, p, states, SLIPS, rate)
    for i in range(states.shape[1]):
        off = np.zeros(states.shape[1])
        off[i] = step
        ahead, back = (held(model, p, states + s * off, SLIPS, rate)[0] for s in (1, -1))
        size = 1 + np.abs(slope).max()
        np.testing.assert_allclose(slope[:, :, i], (ahead - back) / (2 * step), atol=1e-8 * size)
