"""Motions of ten systems next to a steady one, against SciPy's eighth-order method."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from ten_systems import KNOWN, Known

import stability as st


@pytest.mark.few(1)
@pytest.mark.parametrize("known", KNOWN, ids=lambda k: k.name)
def test_a_motion_ends_where_scipys_does(known: Known) -> None:
    values = list(known.parameters.values())
    state = known.followed(values)
    assert state is not None
    start = state * 1.02 + 0.01
    run = st.simulate(
        known.family.system,
        known.parameters,
        dict(zip(known.states, start.tolist(), strict=True)),
        4.0,
    )
    wanted = solve_ivp(
        lambda _, y: known.flow(y, values), (0, 4.0), start, method="DOP853", rtol=1e-13, atol=1e-14
    ).y[:, -1]
    ended = np.array([float(run[n][-1]) for n in known.states])
    assert np.abs(ended - wanted).max() <= max(float(run.final_error), 1e-9)
    assert float(run.final_error) < 1e-4
