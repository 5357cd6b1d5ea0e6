"""The disk held to a slip, against the rough and the viscous disk at random states."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import stability as st
from stability.bodies.thin_disk.held_disk import held_disk

RNG = np.random.default_rng(7)
COUNT = 50
STATES = np.column_stack([RNG.uniform(0.5, 2.6, COUNT), RNG.normal(size=(COUNT, 3))])
SLIPS = RNG.normal(size=(COUNT, 2))
KS = (0.25, 0.4)


def held(x: Any, k: float, slip: Any, rate: Any) -> tuple[Any, Any, Any]:
    """Rates, forces with the normal force, and slope of the rates, one row for each state."""
    given = [list(x.T), [k], list(slip.T), list(rate.T)]
    motion, slope = held_disk()
    rates, forces = (v.reshape(len(x), -1) for v in motion.arrays(given, (len(x),)))
    return rates, forces, slope.arrays(given, (len(x),))[0].reshape(len(x), 4, 4)


@pytest.mark.parametrize("k", KS)
def test_without_slip_it_is_the_rough_disk(k: float) -> None:
    none = np.zeros_like(SLIPS)
    rates, _, _ = held(STATES, k, none, none)
    rough = st.disk_system("rough").rates(STATES, np.full((COUNT, 1), k))
    np.testing.assert_allclose(rates, rough, rtol=1e-10, atol=1e-12)


@pytest.mark.parametrize("k", KS)
@pytest.mark.parametrize("mu", [0.3, 30.0])
def test_with_the_slip_of_the_viscous_disk_it_is_the_viscous_disk(k: float, mu: float) -> None:
    """Slip and its rate of the law give back the law's motion and its force, -mu gn slip."""
    slip = SLIPS * 0.1 / mu  # so small that D is positive
    states, p = np.hstack([STATES, slip]), np.tile([k, mu], (COUNT, 1))
    viscous = st.disk_system("viscous").rates(states, p)
    rates, forces, _ = held(STATES, k, slip, viscous[:, 4:])
    np.testing.assert_allclose(rates, viscous[:, :4], rtol=1e-9, atol=1e-11)
    np.testing.assert_allclose(forces[:, :2], -mu * forces[:, 2:] * slip, rtol=1e-9, atol=1e-11)


def test_the_slope_is_that_of_the_rates() -> None:
    step, k, rate = 1e-5, 0.3, SLIPS[::-1]
    _, _, slope = held(STATES, k, SLIPS, rate)
    for i in range(4):
        off = np.zeros(4)
        off[i] = step
        ahead, back = (held(STATES + s * off, k, SLIPS, rate)[0] for s in (1, -1))
        size = 1 + np.abs(slope).max()
        np.testing.assert_allclose(slope[:, :, i], (ahead - back) / (2 * step), atol=1e-8 * size)
