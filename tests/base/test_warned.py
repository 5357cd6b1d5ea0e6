"""A warning points to the line of the caller, through guards and generated constructors."""

import warnings
from fractions import Fraction
from pathlib import Path
from typing import Any

import casadi as ca

import stability as st

HERE = str(Path(__file__))


def _saddle() -> Any:
    x = ca.SX.sym("x", 2)
    system = st.System(
        "wells",
        x,
        ca.SX(0, 1),
        ca.vertcat(x[1], x[0] - x[0] ** 3 - 0.2 * x[1]),
        states=("x", "v"),
        parameters=(),
    )
    return st.simulate(system, None, [1e-12, 0.0], [50.0], tolerance=1e-4, method="cvodes")


def test_every_warning_is_shown_at_the_callers_line() -> None:
    calls = (
        lambda: st.Disk(k=Fraction(1, 3)),
        lambda: st.simulate(
            st.Disk(k=Fraction(1, 3)), st.Rough(), {"theta": 1.5, "omega3": 1.0}, 1.0
        ),
        _saddle,
    )
    shown = 0
    for call in calls:
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            call()
        assert all(w.filename == HERE for w in caught), [w.filename for w in caught]
        shown += len(caught)
    assert shown >= 2
