"""Graphs of thousands of operations: machine code of loops, with the same motions."""

from __future__ import annotations

import numpy as np
import pytest

import stability as st
from stability.integrators import taylor
from stability.integrators.flow import flow_of
from stability.motion.round_starts import gather_round as gather

pytestmark = pytest.mark.skipif(not taylor.available(), reason="heyoka is an extra")
START = {"theta": 1.2, "omega3": 2.0}


def test_only_long_graphs_are_compiled_as_loops() -> None:
    flows = [
        flow_of(gather(st.Disk(), law, START, np.array([0.0, 1.0])).model)
        for law in (st.Viscous(50.0), *(st.Creep(50.0, order=n) for n in (1, 2, 3)))
    ]
    assert [taylor.compact(flow) for flow in flows] == [False, False, True, True]


def test_loops_give_the_same_motion(monkeypatch: pytest.MonkeyPatch) -> None:
    found = []
    for most in (taylor.LONG, 0):
        monkeypatch.setattr(taylor, "LONG", most)
        taylor._single.cache_clear()
        motion = st.simulate(st.Disk(), st.Viscous(0.3), START, 3.0, method="heyoka", check=False)
        found.append(motion.state.values)
    taylor._single.cache_clear()
    np.testing.assert_allclose(found[0], found[1], rtol=1e-10, atol=1e-11)
