"""Basins of a system whose equilibria are found first: ends against SciPy's integration."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
import pytest
from scipy.integrate import solve_ivp

import stability as st
from stability.cli.commands import main

X, V, C, P = (ca.SX.sym(n) for n in "xvcp")
WELLS = st.System(
    "wells",
    ca.vertcat(X, V),
    ca.vertcat(C, P),
    ca.vertcat(V, P * X - X**3 - C * V),
    states=("x", "v"),
    parameters=("c", "p"),
)
"""A particle in the two wells of p x²/2 - x⁴/4, with damping c."""
AXES: dict[str, Any] = {"x": ("x", -2, 1.9, 4), "y": ("v", -2, 1.9, 4)}
NUMBERS = {"c": 0.2, "p": 1.0}


def well(x: float, v: float) -> int:
    """The sign of x at the end."""
    run = solve_ivp(
        lambda _, y: [y[1], y[0] - y[0] ** 3 - 0.2 * y[1]], (0, 60), [x, v], rtol=1e-8, atol=1e-10
    )
    return int(np.sign(run.y[0, -1]))


@pytest.mark.parametrize("box", [None, {"x": (-3, 3), "v": (-1, 1)}])
def test_launches_settle_on_equilibria_that_nobody_named(box: Any) -> None:
    found = st.basins(WELLS, **AXES, horizon=300.0, box=box, **NUMBERS)
    assert found.family.attrs["flag_meanings"] == "none wells_1 wells_2 wells_3"
    assert (found.outcome == 1).all()
    for i, j in np.ndindex(found.family.shape):
        end = well(float(found.x[j]), float(found.v[i]))
        assert int(found.family[i, j]) == {-1: 1, 1: 3}[end]


def test_a_sample_takes_a_box() -> None:
    spread = {"x": st.statistics.Uniform(-2, 2)}
    box = {"x": (-2, 2), "v": (-1, 1)}
    sample = {"distribution": spread, "count": 4, "held": {"v": 0.0}}
    found = st.basins(WELLS, **sample, horizon=300.0, box=box, **NUMBERS)
    assert set(found.family.values.tolist()) <= {1, 3}


def test_without_equilibria_launches_move() -> None:
    rates = ca.vertcat(V, C * (1 - X**2) * V - X)
    cycle = st.System("cycle", ca.vertcat(X, V), C, rates, states=("x", "v"), parameters=("c",))
    found = st.basins(cycle, **AXES, horizon=20.0, c=0.2)
    assert (found.outcome == 0).all() and not found.family.any()


def test_a_box_that_does_not_fit_is_refused() -> None:
    box = {"x": (-2, 2), "v": (-1, 1)}
    right = st.Family(
        WELLS, "right", at=("c",), unknown={"x": 1.0}, held={"v": 0}, equations=("v",)
    )
    with pytest.raises(st.StabilityError, match="families and a box are both given"):
        st.basins(WELLS, **AXES, horizon=1.0, box=box, families=right, **NUMBERS)
    with pytest.raises(st.StabilityError, match="p varies, and a box is searched at one value"):
        st.basins(WELLS, x=AXES["x"], y=("p", 1, 2, 3), held={"v": 0}, horizon=1.0, box=box, c=0.2)
    with pytest.raises(st.StabilityError, match="box lacks v"):
        st.basins(WELLS, **AXES, horizon=1.0, box={"x": (-2, 2)}, **NUMBERS)
    with pytest.raises(st.StabilityError, match=r"a box belongs to a stability\.System"):
        st.basins(x=("theta", 1, 1.5, 2), y=("phi_dot", 1, 2, 2), horizon=1.0, box=box)


def test_the_commands_take_a_box(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The governor has one steady speed at every load of the map (Watt, 1788)."""
    system = "--system examples/watt_governor.py"
    box = "--box x=0.1:3 --box y=-1:1 --box z=0.1:5 --set e=0.8"
    place = "--set a=0.5 --set b=0.5"
    launched = f"basins {system}:governor --x x:0.9:1.1:2 --y y:-0.1:0.1:2 --set z=1.4 {place}"
    main(f"{launched} {box} --time 200 --out {tmp_path}/g.zarr".split())
    assert "4 settled" in capsys.readouterr().out
    box = box.replace("--box y=-1:1 ", "")
    drawn = f"map {system}:running --x a:0.3:0.7:4 --y b:0.3:0.7:3"
    main(f"{drawn} {box} --out {tmp_path}/m.nc".split())
    assert "equilibria in the box: from 1 to 1; proved in 12 of 12 cells" in capsys.readouterr().out
    assert main(f"{drawn} --set e=0.8 --box x0.1:3 --out {tmp_path}/n.nc".split()) == 2
    assert "--box is 'x0.1:3'; give NAME=LO:HI." in capsys.readouterr().err
