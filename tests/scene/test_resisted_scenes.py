"""Scenes with resistance to rolling and turning: fall times, uncertain coefficients, the file."""

import math
from pathlib import Path
from typing import Any

import inertial_disk
import numpy as np
import pytest
from scipy.integrate import solve_ivp

import stability as st
from stability.integrators import stick_slip
from stability.scene.toml_file import read

RHO, DRAG = 0.3, 0.2
WHIRL = {"theta": 0.5, "phi_dot": 1.5}
FALL = {"theta": 1.2}
EVERY = (st.RollingResistance(0.05), st.PivotingResistance(0.02), st.AirTorque(0.01))


def fall_time(rho: float, drag: float, k: float = 0.25) -> float:
    """Time to 1e-6 rad of a disk that turns over about the tangent at a point that stays in place.

    (k + 1) θ'' = -cos θ - (ρ N + d) θ', with N = 1 + (sin θ)'' and m = R = g = 1.
    """

    def rates(_: float, y: Any) -> Any:
        theta, w = y
        s, c = math.sin(theta), math.cos(theta)
        return w, -(c + (rho * (1 - s * w**2) + drag) * w) / (k + 1 + rho * w * c)

    def flat(_: float, y: Any) -> float:
        return float(y[0]) - 1e-6

    flat.terminal = True  # type: ignore[attr-defined]
    run = solve_ivp(
        rates, (0, 50), [FALL["theta"], 0.0], "DOP853", events=flat, rtol=1e-12, atol=1e-13
    )
    return float(run.t_events[0][0])


def test_the_fall_time_is_that_of_the_equation_of_a_turning_disk() -> None:
    resistance = [st.RollingResistance(RHO), st.AirTorque(DRAG)]
    scene = st.Scene(
        contact=st.Rough(),
        start=FALL,
        horizon=20.0,
        tolerance=1e-8,
        quantities=("fall_time", "outcome"),
        resistance=resistance,
        uncertain={"rho": 0.2, "drag": 0.1},
    )
    answer = scene.answer()
    true = fall_time(RHO, DRAG)
    assert answer.value["outcome"] == "flat"
    assert answer.value["fall_time"] == pytest.approx(true, abs=1e-7)
    assert true > fall_time(0.0, 0.0) + 0.05
    assert answer.spread is not None
    for name, width, ends in (
        ("rho", 0.2, lambda s: fall_time(RHO * s, DRAG)),
        ("drag", 0.1, lambda s: fall_time(RHO, DRAG * s)),
    ):
        moved = max(abs(ends(1 + side * width) - true) for side in (1, -1)) / max(1.0, true)
        assert answer.spread.moves["fall_time"][name] == pytest.approx(moved, rel=1e-3), name


@pytest.mark.parametrize("body", [st.Disk(), st.Torus(0.2), st.EccentricSphere(0.15)], ids=str)
@pytest.mark.parametrize("law", [st.Coulomb(0.3), st.Viscous(1.0)], ids=["coulomb", "viscous"])
def test_a_scene_ends_where_simulate_ends(body: Any, law: Any) -> None:
    start = {"theta": 1.3, "phi_dot": 1.0, "omega3": 0.5}
    scene = st.Scene(
        body=body, contact=law, start=start, horizon=3.0, tolerance=1e-6, resistance=EVERY
    )
    run = st.simulate(body, law, start, 3.0, resistance=EVERY, tolerance=1e-11, check=False)
    value = scene.answer().value
    if "theta" in value:
        far = [value[n] - float(run[n][-1]) for n in ("theta", "theta_dot", "phi_dot", "omega3")]
        assert np.abs(far).max() < 1e-5
    else:
        assert value["axis_Z"] == pytest.approx(math.cos(float(run.theta[-1])), abs=1e-5)
    plain = st.Scene(body=body, contact=law, start=start, horizon=3.0, tolerance=1e-6)
    assert plain.answer().value != pytest.approx(value, abs=1e-2)


def nodding(**settings: Any) -> st.Scene:
    """A low disk that slips and sticks as it nods, under dry friction and two resistances."""
    return st.Scene(
        contact=st.Coulomb(0.3),
        start={"theta": 0.3, "theta_dot": 0.2, "phi_dot": 3.68},
        horizon=50.0,
        tolerance=1e-4,
        quantities=("fall_time",),
        resistance=[st.RollingResistance(0.2), st.PivotingResistance(0.05)],
        **settings,
    )


def test_the_fall_time_under_dry_friction_is_the_limit_of_smoothed_friction(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    start, law = (0.3, 0.2, 3.68, 0.0, 0.0, 0.0), (0.25, 0.3, 0.2, 0.05)
    far, near = (inertial_disk.fall_time(start, 0.03, 50.0, *law, eps) for eps in (1e-4, 1e-5))
    assert near == pytest.approx(far, abs=1e-4)
    for most in (stick_slip.SWITCHES, 40):  # the second: BDF takes over in every slip
        monkeypatch.setattr(stick_slip, "SWITCHES", most)
        answer = nodding(flat=0.03).answer()
        assert answer.value == pytest.approx(near, abs=2e-5)
        assert answer.estimate < 1e-6


def test_a_run_that_gave_up_is_not_said_to_stay_up() -> None:
    answer = nodding(max_seconds=1e-3, uncertain={"rho": 0.2}).answer()
    assert answer.value is None
    report = answer.report()
    assert "not known, because runs are unresolved" in report
    assert "does not fall flat" not in report
    assert "more than 0.001 s of computing; give a larger max_seconds" in report


def test_a_start_that_is_flat_is_refused() -> None:
    with pytest.raises(st.StabilityError, match=r"theta of start is 0.05, flat within flat = 0\.1"):
        st.Scene(contact=st.Rough(), start={"theta": 0.05}, horizon=1.0, flat=0.1).answer()


def test_a_file_states_resistances(tmp_path: Path) -> None:
    text = '[contact]\nlaw = "rough"\n[start]\ntheta = 1.2\n[question]\nhorizon = 5.0\n'
    file = tmp_path / "resisted.toml"
    file.write_text(text + "[resistance]\nrolling_resistance = 0.3\nair_torque = 0.2\n")
    found = {r.coefficient: r.value for r in read(file)["resistance"]}
    assert found == {"rho": 0.3, "drag": 0.2}
    file.write_text(text + "[resistance]\nrho = 0.3\n")
    with pytest.raises(st.StabilityError, match="known are rolling_resistance, pivoting_resist"):
        read(file)


def test_a_system_has_no_resistance() -> None:
    import casadi as ca

    x = ca.SX.sym("x")
    own = st.System("own", x, ca.SX(0, 1), -x, states=("x",), parameters=())
    with pytest.raises(st.StabilityError, match="belongs to a disk or a body"):
        st.Scene(own, None, {"x": 1.0}, horizon=1.0, resistance=EVERY[0])
