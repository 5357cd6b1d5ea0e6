"""Motions under resistance to rolling and turning, against inertial axes and energy balances."""

import math
from typing import Any

import body_profiles as shapes
import casadi as ca
import numpy as np
import pytest
from body_motion import move
from convex_body import Law, pose_at
from resisted import moments

import stability as st

RHO, SIGMA, DRAG = 0.03, 0.05, 0.02
EVERY = (st.RollingResistance(RHO), st.PivotingResistance(SIGMA), st.AirTorque(DRAG))
BODIES = {
    "torus": (
        shapes.torus(1.0, 0.2, 1.03, 0.525),
        st.Torus(0.2),
        (1.3, 0.1, 0.4, 1.2, 0.1, -0.2),
        (0.8, 6.0),
    ),
    "tippe top": (
        shapes.eccentric_sphere(0.15, 0.4, 0.4),
        st.EccentricSphere(0.15, axial=0.4, transverse=0.4),
        (0.3, 0.0, 0.0, 4.0, 0.0, 0.0),
        (1.0, 10.0),
    ),
    "through both poles": (
        shapes.spheroid(1.0, 1.2, 0.4, 0.488),
        st.Spheroid(1.2),
        (0.8, -1.2, 0.0, 0.0, 0.1, 0.0),
        (1.0, 8.0),
    ),
    "thick disk in SI": (
        shapes.thick_disk(0.3, 0.03, 0.09, 0.0456, 2.0, 9.81),
        st.ThickDisk(0.2, mass=2.0, gravity=9.81, length=0.3),
        (1.2, 0.5, 2.0, 5.0, 0.1, 0.0),
        (0.15, 1.2),
    ),
}


@pytest.mark.few(4)
@pytest.mark.parametrize("law", ["viscous", "rough", "smooth"])
@pytest.mark.parametrize("which", [(0, 1), (2,)], ids=["rolling and pivoting", "air"])
@pytest.mark.parametrize("scene", BODIES)
@pytest.mark.parametrize("long", [False, pytest.param(True, marks=pytest.mark.long)])
def test_resisted_motions_are_those_of_the_geometry(
    scene: str, which: Any, law: str, long: bool
) -> None:
    of, body, start, ends = BODIES[scene]
    last = ends[long]
    resistance = tuple(EVERY[i] for i in which)
    six = np.array(start)
    if law == "rough":
        six[4:] = 0
    mu = 0.3 if law == "viscous" else 0.0
    contact = st.Viscous(mu) if mu else law
    times = np.linspace(0.0, last, 9 if long else 4)
    run = st.simulate(
        body,
        contact,
        six,
        times,
        resistance=resistance,
        tolerance=1e-14,
        check=False,
        max_seconds=60.0,
        method="auto" if long else "dop853",  # which compiles nothing
    )
    true = move(of, Law(law, mu, moments(resistance)), pose_at(of, six), times[: len(run.time)])
    assert len(run.time) == len(times)
    scale = np.abs(true.spin).max()
    assert np.abs(np.cos(run.theta) - true.axis[:, 2]).max() < 1e-9
    assert np.abs(run.omega3 - np.sum(true.spin * true.axis, axis=1)).max() < 1e-9 * scale
    s, c = np.sin(run.theta.values), np.cos(run.theta.values)
    assert np.abs(run.phi_dot * s**2 + run.omega3 * c - true.spin[:, 2]).max() < 1e-9 * scale
    speed = np.hypot(true.slip[:, 0], true.slip[:, 1])
    assert np.abs(np.hypot(run.slip_x, run.slip_y) - speed).max() < 1e-9 * scale
    weight = of.mass * of.gravity
    assert np.abs(run.normal_force - true.normal_force).max() < 1e-9 * weight * (1 + scale**2)
    assert np.abs(run.dissipated - true.lost).max() < 1e-9 * abs(true.energy[0])
    assert float(run.dissipated[-1]) > 1e-3 * abs(true.energy[0])


@pytest.mark.parametrize("kind", [st.RollingResistance, st.PivotingResistance, st.AirTorque])
def test_the_energy_lost_is_the_power_of_the_resistance_along_the_run(kind: Any) -> None:
    """Gauss points on pieces of the run; the power is written down again from the definition."""
    small, mu = 0.02, 0.3
    nodes, weights = np.polynomial.legendre.leggauss(8)
    edges = np.linspace(0.0, 6.0, 41)
    half = np.diff(edges)[:, None] / 2
    times = edges[:-1, None] + half * (1 + nodes)
    run = st.simulate(
        st.Disk(),
        st.Viscous(mu),
        {"theta": 1.45, "phi_dot": 0.3, "omega3": 1.6, "slip_y": 0.3},
        np.append(times.ravel(), 6.0),
        resistance=kind(small),
        tolerance=1e-14,
        check=False,
    )
    assert run.attrs["outcome"] == "moving"
    s, c, w = np.sin(run.theta), np.cos(run.theta), run.omega3 - run.phi_dot * np.cos(run.theta)
    level, vertical = run.theta_dot**2 + (w * s) ** 2, (run.phi_dot + w * c) ** 2
    turning = {
        st.RollingResistance: run.normal_force * level,
        st.PivotingResistance: run.normal_force * vertical,
        st.AirTorque: level + vertical,
    }[kind]
    power = small * turning + mu * run.normal_force * (run.slip_x**2 + run.slip_y**2)
    shares = power.values[:-1].reshape(times.shape) * weights * half
    lost = _energy([1.45, 0.0, 0.3, 1.6, 0.0, 0.3]) - float(run.energy[-1])
    assert shares.sum() == pytest.approx(lost, rel=1e-9)
    assert shares.sum() == pytest.approx(float(run.dissipated[-1]), rel=1e-9)
    assert small * (turning.values[:-1].reshape(times.shape) * weights * half).sum() > 1e-3


def _energy(six: list[float]) -> float:
    """The energy of the disk with m = R = g = 1 and k = 1/4, from its velocities."""
    theta, theta_dot, phi_dot, omega3, slip_x, slip_y = six
    s, c = math.sin(theta), math.cos(theta)
    spin = 0.25 * (theta_dot**2 + (phi_dot * s) ** 2 + 2 * omega3**2)
    centre = (slip_x + theta_dot * s) ** 2 + (slip_y - omega3) ** 2 + (theta_dot * c) ** 2
    return (spin + centre) / 2 + s


def test_a_family_that_loses_nothing_is_settled_on_and_no_other() -> None:
    top = st.EccentricSphere(0.15, axial=0.4, transverse=0.4)
    start = {"theta": 0.05, "omega3": 4.0}
    run = st.simulate(
        top, st.Viscous(0.3), start, 3000.0, resistance=st.RollingResistance(1e-3), check=False
    )
    assert run.attrs["outcome"] == "settled"
    assert str(run.nearest_family.values) == "vertical at theta = pi"
    # pivoting costs energy in vertical spin, so that nothing is settled on while it turns
    run = st.simulate(
        top, st.Viscous(0.3), start, 60.0, resistance=st.PivotingResistance(1e-3), check=False
    )
    assert run.attrs["outcome"] == "moving"
    assert "vertical" not in str(run.nearest_family.values)


def test_numbers_in_si_are_those_without_units() -> None:
    mass, length, gravity = 0.03, 0.02, 9.81
    time = math.sqrt(length / gravity)
    units = {"mass": mass, "length": length, "gravity": gravity}
    small, large = np.array([0.01, 0.03]), st.AirTorque(0.02)
    start = [1.4, 0.1, 0.3, 1.2, 0.1, 0.0]
    bare = st.simulate(
        st.Torus(0.2),
        st.Viscous(0.3),
        start,
        4.0,
        check=False,
        resistance=[st.RollingResistance(small), large],
    )
    six = np.array(start) / [1, time, time, time, time / length, time / length]
    si = st.simulate(
        st.Torus(0.2, **units),
        st.Viscous(0.3 * time / length),
        six,
        4.0 * time,
        check=False,
        resistance=[
            st.RollingResistance(small * length * time),
            st.AirTorque(0.02 * mass * gravity * length * time),
        ],
    )
    assert bare.theta.shape == si.theta.shape == (2, 201)
    assert si.theta.values == pytest.approx(bare.theta.values, abs=1e-8)
    assert si.omega3.values * time == pytest.approx(bare.omega3.values, abs=1e-8)
    assert np.abs(bare.theta[0] - bare.theta[1]).max() > 1e-3
    assert si.rho.values == pytest.approx(small * length * time)


@pytest.mark.long
def test_no_resistance_and_one_of_zero_change_nothing() -> None:
    start = {"theta": 1.2, "omega3": 1.0}
    plain = st.simulate(st.Torus(0.2), "rough", start, 5.0)
    for resistance in (None, [], st.AirTorque(0.0)):
        run = st.simulate(st.Torus(0.2), "rough", start, 5.0, resistance=resistance)
        assert np.array_equal(run.theta, plain.theta)
        assert str(run.nearest_family.values) == str(plain.nearest_family.values)
    disk = st.simulate(st.Disk(), st.Viscous(0.3), start, 2.0)
    run = st.simulate(st.Disk(), st.Viscous(0.3), start, 2.0, resistance=st.AirTorque(0.0))
    assert run.theta.values == pytest.approx(disk.theta.values, abs=1e-8)
    assert set(disk.variables) == set(run.variables) and "body" not in run.attrs


def test_what_is_no_resistance_is_refused_in_a_sentence() -> None:
    x = ca.SX.sym("x")
    own = st.System("own", x, ca.SX(0, 1), -x, states=("x",), parameters=())
    rho = st.Body(
        lambda theta, rho: 1 + rho * ca.sin(theta),
        axial=0.4,
        transverse=0.4,
        shape={"rho": 0.1},
        name="ball",
    )
    air = st.AirTorque(0.1)
    cases: list[tuple[dict[str, Any], str]] = [
        ({"resistance": 3}, "resistance is 3; give RollingResistance(rho)"),
        ({"resistance": [air, air]}, "two resistances have the coefficient drag"),
        ({"disk": own, "contact": None, "start": [1.0], "resistance": air}, "belongs to a disk"),
        ({"disk": rho, "resistance": st.RollingResistance(0.1)}, "give that another name"),
        ({"resistance": st.AirTorque([0.1, 0.2]), "start": np.ones((3, 4))}, "shape"),
    ]
    for change, words in cases:
        given = {"disk": st.Disk(), "contact": "rough", "start": {"theta": 1.0}, "times": 1.0}
        with pytest.raises(st.StabilityError) as caught:
            st.simulate(**given | change)
        assert words in str(caught.value), str(caught.value)
        assert "\n" not in str(caught.value)


@pytest.mark.parametrize("k", [0.25, 0.4, 0.5])
def test_a_low_disk_sinks_at_the_rate_of_its_balance_of_energy(k: float) -> None:
    """E = 3/2 θ and ω² = θ/k for m = R = g = 1, so θ' = -2ρ/(3k) θ as θ tends to 0."""
    rho, disk = 1e-3, st.Disk(k=k)
    start = st.launch("tumbling", at=0.02, tilt=0, disk=disk)
    times = [0.0, 500.0, 1000.0]
    run = st.simulate(disk, st.Rough(), start, times, resistance=st.RollingResistance(rho))
    theta = run.theta.values
    rate = math.log(theta[1] / theta[2]) / 500.0
    assert rate == pytest.approx(2 * rho / (3 * k), rel=2e-3)
