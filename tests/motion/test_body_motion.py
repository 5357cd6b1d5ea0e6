"""Motions of bodies of revolution, against a formulation in inertial axes by their geometry."""

import json
import math
from pathlib import Path
from typing import Any

import body_profiles as shapes
import casadi as ca
import numpy as np
import pytest
from body_motion import move
from convex_body import Law, axis_rates, pose_at
from random_bodies import random_scene

import stability as st
from stability.bodies.contact_laws import LAWS
from stability.bodies.round_body.pole_equations import pole_system

SMOOTH = ("eccentric sphere", "spheroid")
STORED = Path(__file__).parents[1] / "data" / "body_motions.json"


def own_body(name: str, g: dict[str, float], **rest: Any) -> st.Body:
    """The body of the package for one of the oracle, by its height."""
    heights = {
        "eccentric sphere": lambda t: g["radius"] - g["offset"] * ca.cos(t),
        "spheroid": lambda t: ca.sqrt(
            (g["across"] * ca.sin(t)) ** 2 + (g["along"] * ca.cos(t)) ** 2
        ),
        "thick disk": lambda t: g["radius"] * ca.sin(t) + g["half"] * ca.cos(t),
        "lens": lambda t: g["radius"] * math.sin(g["angle"]) * ca.sin(t),
    }
    ends = {"thick disk": (0.0, math.pi / 2), "lens": (g.get("angle"), math.pi - g.get("angle", 0))}
    between: Any = ends.get(name, (0.0, math.pi))
    return st.Body(heights[name], name=name, between=between, **rest)


@pytest.mark.few(2)
@pytest.mark.parametrize("law", ["smooth", "viscous", "linear-viscous", "rough"])
@pytest.mark.parametrize("name", SMOOTH)
@pytest.mark.parametrize("lean", [0.0, 1e-9, 0.4])
@pytest.mark.parametrize("side", [1, -1])
def test_rates_at_a_pole_are_those_of_the_geometry(
    name: str, law: str, lean: float, side: int
) -> None:
    rng = np.random.default_rng(3)
    given = {"viscous": ("mu",), "linear-viscous": ("c",)}.get(law, ())
    for _ in range(4):
        scene = random_scene(rng, name=name, law=law)
        if scene.body.parameters.get("offset", 0) > 0.45:
            continue
        of, mu = scene.body, scene.law.coefficient
        body = own_body(
            name,
            of.parameters,
            axial=of.axial / of.mass,
            transverse=of.transverse / of.mass,
            mass=of.mass,
            gravity=of.gravity,
            length=1.0,
        )
        system = pole_system(body, LAWS[law], given, physical=True, slip_states=True)
        values = np.array([lean, -lean / 2, *rng.normal(size=3), *rng.normal(0, 0.1, 2)])
        if law == "rough":
            values[5:] = 0
        true = axis_rates(of, scene.law, values, side)
        up = side * math.sqrt(1 - values[0] ** 2 - values[1] ** 2)
        x = np.array([*values[:2], up, *values[2:]])[: len(system.states)]
        known = dict(body.given) | {"mu": mu, "c": mu}
        found = np.delete(system.rates(x, [known[n] for n in system.parameters]), 2)
        assert np.abs(found - true[: len(found)]).max() <= 1e-12 * (1 + np.abs(true).max())


def _six(start: dict[str, list[float]]) -> tuple[np.ndarray, np.ndarray]:
    """The six states of vectors along fixed axes, and x̂, ŷ and ẑ as rows."""
    axis, spin = np.array(start["axis"]), np.array(start["spin"])
    axis = axis / np.linalg.norm(axis)
    slip = np.array([*start["slip"], 0.0])
    sine, up = math.hypot(*axis[:2]), axis[2]
    east = np.array([*axis[:2], 0.0]) / sine if sine else np.array([1.0, 0, 0])
    frame = np.array([east, [-east[1], east[0], 0.0], [0.0, 0.0, 1.0]])
    omega3, over = spin @ axis, spin @ east
    phi_dot = spin[2] - up * over / sine
    theta = math.atan2(sine, up)
    six = [theta, spin @ frame[1], phi_dot, omega3, slip @ frame[0], slip @ frame[1]]
    return np.array(six), frame


@pytest.mark.few(1)
@pytest.mark.parametrize(
    "entry",
    [e for e in json.loads(STORED.read_text())["motions"] if e["body"] not in ("egg", "torus")],
    ids=lambda e: e["name"],
)
def test_motions_meet_those_of_18_digits_through_the_poles(entry: dict[str, Any]) -> None:
    body = own_body(
        entry["body"], entry["parameters"], axial=entry["axial"], transverse=entry["transverse"]
    )
    six, frame = _six(entry["start"])
    if entry["law"] == "rough":  # 1e-23 in the file
        six[4:] = 0.0
    law = {"viscous": st.Viscous(entry["coefficient"] or 1.0), "rough": st.Rough()}[entry["law"]]
    times = np.array(entry["times"])
    run = st.simulate(body, law, six, times, pose=True, tolerance=1e-15, check=False)
    assert len(run.time) == len(times)
    true = {n: np.array(entry[n], dtype=float) @ frame.T for n in ("axis", "spin", "centre")}
    # this motion multiplies errors a thousandfold, and those of its start with them
    bound = 1e-9 if times[-1] > 10 else 1e-12
    vertical = run.phi_dot * np.sin(run.theta) ** 2 + run.omega3 * np.cos(run.theta)
    assert np.abs(vertical - true["spin"][:, 2]).max() < bound
    place = np.array([run.centre_x, run.centre_y]).T
    moved = true["centre"][:, :2] - true["centre"][0, :2]
    assert np.abs(place - moved).max() < bound * max(1.0, times[-1])
    assert np.abs(np.cos(run.theta) - true["axis"][:, 2]).max() < bound
    speed = np.linalg.norm(np.array(entry["slip"], dtype=float), axis=1)
    assert np.abs(np.hypot(run.slip_x, run.slip_y) - speed).max() < bound
    if entry["body"] in SMOOTH:
        axis = np.array([run.axis_x, run.axis_y, run.axis_z]).T
        assert np.abs(axis - true["axis"]).max() < bound
        assert np.abs(np.sin(run.theta.values)).min() < 1e-12 or "over" in entry["name"]


SCENES = {
    "torus": (
        shapes.torus(1.0, 0.2, 1.03, 0.525),
        st.Torus(0.2),
        (1.3, 0.1, 0.4, 1.2, 0.1, -0.2),
        (0.6, 8.0),
    ),
    "thick disk in SI": (
        shapes.thick_disk(0.3, 0.03, 0.09, 0.0456, 2.0, 9.81),
        st.ThickDisk(0.2, mass=2.0, gravity=9.81, length=0.3),
        (1.2, 0.5, 2.0, 5.0, 0.1, 0.0),
        (0.2, 1.5),
    ),
    "through both poles": (
        shapes.spheroid(1.0, 1.2, 0.4, 0.488),
        st.Spheroid(1.2),
        (0.8, -1.2, 0.0, 0.0, 0.1, 0.0),
        (2.0, 12.0),
    ),
    "tippe top": (
        shapes.eccentric_sphere(0.15, 0.4, 0.4),
        st.EccentricSphere(0.15, axial=0.4, transverse=0.4),
        (0.3, 0.0, 0.0, 4.0, 0.0, 0.0),
        (0.8, 15.0),
    ),
}


@pytest.mark.few(4)
@pytest.mark.parametrize("law", ["viscous", "rough", "smooth"])
@pytest.mark.parametrize("scene", SCENES)
@pytest.mark.parametrize("long", [False, pytest.param(True, marks=pytest.mark.long)])
def test_motions_are_those_of_the_geometry_in_inertial_axes(
    scene: str, law: str, long: bool
) -> None:
    of, body, start, ends = SCENES[scene]
    last = ends[long]
    six = np.array(start)
    if law == "rough":
        six[4:] = 0
    mu = 0.3 if law == "viscous" else 0.0
    contact = st.Viscous(mu) if mu else law
    times = np.linspace(0.0, last, 13 if long else 4)
    method = "auto" if long else "dop853"  # which compiles nothing
    run = st.simulate(
        body, contact, six, times, pose=True, tolerance=1e-15, check=False, method=method
    )
    assert run.attrs["outcome"] in ("moving", "settled")
    true = move(of, Law(law, mu), pose_at(of, six), times)
    up = true.axis[:, 2]
    scale = np.abs(true.spin).max()
    assert np.abs(np.cos(run.theta) - up).max() < 1e-9
    assert np.abs(run.omega3 - np.sum(true.spin * true.axis, axis=1)).max() < 1e-9 * scale
    s, c = np.sin(run.theta.values), np.cos(run.theta.values)
    vertical = run.phi_dot * s**2 + run.omega3 * c
    assert np.abs(vertical - true.spin[:, 2]).max() < 1e-9 * scale
    level = np.hypot(true.spin[:, 0], true.spin[:, 1])
    ours = np.hypot(run.theta_dot, (run.omega3 - run.phi_dot * c) * s)
    assert np.abs(ours - level).max() < 1e-9 * scale
    speed = np.hypot(true.slip[:, 0], true.slip[:, 1])
    assert np.abs(np.hypot(run.slip_x, run.slip_y) - speed).max() < 1e-9 * scale
    weight = of.mass * of.gravity
    assert np.abs(run.normal_force - true.normal_force).max() < 1e-9 * weight * (1 + scale**2)
    assert np.abs(run.dissipated - true.lost).max() < 1e-9 * abs(true.energy[0])
    assert np.abs(run.energy - true.energy).max() < 1e-9 * abs(true.energy[0])
    # places begin at the centre, with the axis along X
    place = np.array([run.centre_x, run.centre_y]).T
    assert np.abs(place - true.centre[:, :2]).max() < 1e-9 * max(1.0, scale * last)
    tilted = s > 1e-3
    heading = np.array([np.cos(run.phi), np.sin(run.phi)]).T
    assert np.abs(heading * s[:, None] - true.axis[:, :2])[tilted].max() < 1e-9 * scale
    if scene == "through both poles":
        # it turns over again and again in a plane, so that its axis passes vertical
        assert up.max() > 0.9 and up.min() < -0.9 or not long
        assert true.axis[0, 0] * true.axis[-1, 0] < 0 or long
    if "axis_z" in run:
        axis = np.array([run.axis_x, run.axis_y, run.axis_z]).T
        assert np.abs(axis - true.axis).max() < 1e-9 * scale


def _jellett(run: object, body: st.Body) -> np.ndarray:
    """-L·a of a motion by its fixed axes, from the definition, for the eccentric sphere."""
    axial, across = body.moments()
    offset = body.shape["offset"]
    e = np.array([run.axis_x, run.axis_y, run.axis_z]).T  # type: ignore[attr-defined]
    s, c = np.sin(run.theta.values), np.cos(run.theta.values)  # type: ignore[attr-defined]
    # along e and Z: L = I1 ω + (I3 - I1) ω3 e, and the contact lies at e·offset - Z
    omega3, phi_dot = run.omega3.values, run.phi_dot.values  # type: ignore[attr-defined]
    vertical = phi_dot * s**2 + omega3 * c
    assert np.abs(e[:, 2] - c).max() < 1e-12
    momentum = axial * omega3, across * vertical + (axial - across) * omega3 * c
    found: np.ndarray = momentum[1] - offset * momentum[0]
    return found


@pytest.mark.parametrize("last", [400.0, pytest.param(1500.0, marks=pytest.mark.long)])
def test_jelletts_integral_is_kept_while_a_tippe_top_turns_over(last: float) -> None:
    top = st.EccentricSphere(0.15, axial=0.4, transverse=0.42)
    start = {"theta": 0.05, "omega3": 5.0}
    run = st.simulate(top, st.Viscous(0.3), start, last, tolerance=1e-15)
    assert run.theta[0] < 0.06 and run.theta[-1] > 3.1
    kept = _jellett(run, top)
    assert np.abs(kept - kept[0]).max() < 1e-11 * abs(kept[0])
    assert float(run.energy_error) < 1e-11
    assert float(run.energy[-1]) < float(run.energy[0]) - 1.0


def test_a_tippe_top_settles_on_its_other_pole() -> None:
    top = st.EccentricSphere(0.15, axial=0.4, transverse=0.4)
    run = st.simulate(top, st.Viscous(0.3), {"theta": 0.05, "omega3": 4.0}, 3000.0)
    assert run.attrs["outcome"] == "settled"
    assert str(run.nearest_family.values) == "vertical at theta = pi"
    # Jellett's integral L·(Z - offset e) fixes the rate there: L = 0.4 ω for equal moments
    first = 0.4 * 4.0 * math.cos(0.05) - 0.15 * 0.4 * 4.0
    assert float(run.nearest_at) == pytest.approx(first / (0.4 * 1.15), abs=1e-5)
    slow = st.simulate(top, st.Viscous(0.3), {"theta": 0.05, "omega3": 0.2}, 3000.0)
    assert str(slow.nearest_family.values) != "vertical at theta = pi"


def test_a_start_on_a_pole_and_a_passage_through_it_are_motions() -> None:
    egg = st.Spheroid(1.3)
    start = {"theta": 0.0, "theta_dot": 1.1}
    run = st.simulate(egg, st.Rough(), start, 20.0, method="dop853", tolerance=1e-11)
    assert run.attrs["outcome"] == "moving"
    assert float(run.axis_z.min()) < -0.99 and float(run.energy_error) < 1e-9
    assert float(np.abs(run.axis_y).max()) < 1e-12  # it keeps its plane
    torus = st.simulate(st.Torus(0.2), st.Viscous(0.3), {"theta": 1.5}, 30.0)
    assert torus.attrs["outcome"] == "flat" and "body" in torus.attrs["outcome_sentence"]


def test_another_rim_ends_the_motion_of_a_thick_disk() -> None:
    start = {"theta": 1.5, "theta_dot": 0.5}
    run = st.simulate(st.ThickDisk(0.2), st.Viscous(0.3), start, 30.0)
    assert run.attrs["outcome"] == "domain-end"
    assert float(run.theta[-1]) == pytest.approx(math.pi / 2, abs=1e-9)
    assert "another rim" in str(run.evidence.values)
    falls = st.simulate(st.ThickDisk(0.2), st.Rough(), {"theta": 0.3}, 30.0, check=False)
    assert falls.attrs["outcome"] == "flat"


@pytest.mark.few(2)
@pytest.mark.parametrize("law", ["viscous", "linear-viscous", "rough", "smooth"])
@pytest.mark.parametrize("last", [4.0, pytest.param(40.0, marks=pytest.mark.long)])
def test_the_thin_body_moves_and_ends_as_the_disk(law: str, last: float) -> None:
    thin = st.Body(lambda theta: ca.sin(theta), axial=0.5, transverse=0.25, name="thin")
    contact = LAWS[law](0.3) if LAWS[law].parameters else LAWS[law]()
    launches = [[1.4, 0.1, 0.3, 1.0, 0, 0], [1.2, 0, 0.1, 0.2, 0, 0], [1.5, 0, 2.5, 0, 0, 0]]
    for six in launches[: 2 if last < 40 else 3]:
        # dop853 compiles nothing
        options: Any = dict(
            pose=True, tolerance=1e-12, check=False, method="auto" if last == 40 else "dop853"
        )
        known = st.simulate(st.Disk(), contact, six, last, **options)
        run = st.simulate(thin, contact, six, last, **options)
        assert run.attrs["outcome"] == known.attrs["outcome"]
        assert str(run.nearest_family.values) == str(known.nearest_family.values)
        assert float(run.end_time) == pytest.approx(float(known.end_time), rel=1e-9)
        for name in ("theta", "phi_dot", "energy", "normal_force", "contact_x", "contact_y"):
            scale = 1 + float(np.abs(known[name]).max())
            assert np.abs(run[name].values - known[name].values).max() < 1e-6 * scale, name


@pytest.mark.long
def test_settled_motions_of_a_body_stay_where_they_are_said_to_converge() -> None:
    flat = st.Spheroid(0.5)
    run = st.simulate(flat, st.Viscous(0.3), {"theta": 1.3, "phi_dot": 0.5}, 600.0)
    assert run.attrs["outcome"] == "settled"
    assert str(run.nearest_family.values) == "tumbling"
    last = [float(run[n][-1]) for n in ("theta", "theta_dot", "phi_dot", "omega3")]
    slips = [float(run[n][-1]) for n in ("slip_x", "slip_y")]
    later = st.simulate(flat, st.Viscous(0.3), [*last, *slips], 900.0)
    assert float(later.theta[-1]) == pytest.approx(float(run.nearest_at), abs=1e-8)
    at = float(run.nearest_at)
    member = st.spectrum("tumbling", at=at, body=flat, contact=st.Viscous(0.3))
    assert member.verdict is st.Verdict.STABLE
    s, c = math.sin(at), math.cos(at)
    h, slope = flat.height_at(at), flat.height_at(at, 1)
    axial, across = flat.moments()
    r, z = h * s + slope * c, h * c - slope * s
    square = slope * r / (s * (across * r * c - axial * z * s))
    assert float(run.phi_dot[-1]) == pytest.approx(math.sqrt(square), abs=1e-7)


def test_a_body_departs_from_an_unstable_member() -> None:
    long = st.Spheroid(1.5)
    start = {"theta": 0.0, "theta_dot": 1e-4, "omega3": 0.01}
    run = st.simulate(long, st.Viscous(0.3), start, 300.0)
    assert "departs from vertical at theta = 0" in str(run.evidence.values)


def test_si_numbers_arrays_and_names_work_as_those_of_the_disk() -> None:
    offsets, mu = np.array([0.1, 0.2]), np.array([[0.1], [0.3], [0.5]])
    length, gravity = 0.02, 9.81
    rate, speed = math.sqrt(gravity / length), math.sqrt(gravity * length)
    top = st.EccentricSphere(offsets, mass=0.03, gravity=gravity, length=length)
    start = {"theta": [0.3, 0.4], "omega3": 2.0 * rate, "slip_x": 0.01 * speed}
    si = st.simulate(body=top, contact=st.Viscous(mu / speed), start=start, times=5.0 / rate)
    assert si.theta.shape == (3, 2, 201) and si.theta.dims == ("launch_0", "launch_1", "time")
    assert si.omega3.attrs["units"] == "rad/s" and si.energy.attrs["units"] == "J"
    assert si.slip_x.attrs["units"] == "m/s" and si.attrs["body"] == "eccentric sphere"
    assert si.offset.shape == (2,) or si.offset.shape == (3, 2)
    for i, j in ((0, 1), (2, 0)):
        alone = st.simulate(
            st.EccentricSphere(offsets[j]),
            "viscous",
            mu=mu[i, 0],
            times=5.0,
            start=[start["theta"][j], 0, 0, 2.0, 0.01, 0],
        )
        one = si.isel(launch_0=i, launch_1=j)
        assert one.theta.values == pytest.approx(alone.theta.values, abs=1e-7)
        assert one.omega3.values / rate == pytest.approx(alone.omega3.values, abs=1e-7)
        assert one.slip_y.values / speed == pytest.approx(alone.slip_y.values, abs=1e-7)
    disk = st.Disk()
    same = [
        st.simulate(contact="rough", start={"theta": 1.0}, times=0.5, **{n: disk})
        for n in ("disk", "body")
    ]
    assert np.array_equal(same[0].theta, same[1].theta)


def test_what_a_body_cannot_do_is_refused_in_a_sentence() -> None:
    torus, times = st.Torus(0.2), 1.0
    cases = [
        (dict(contact="viscous"), "mu is missing"),
        (dict(contact=7), "contact is 7; give one of Smooth"),
        (dict(start={"theta": 0.0}), "theta is 0; the height of torus holds"),
        (dict(start={"theta": 1e-7}), "start more upright"),
        (dict(start={"theta": 1.0, "slip_x": 1.0}), "the slip of the rough contact"),
        (dict(start={"theta": 1.0, "theta_dot": 9.0}), "the body is not in contact"),
        (dict(start={"lean": 1.0}), "start names 'lean'"),
        (dict(families=[3]), "families belong to a stability.System"),
        (dict(disk=st.Disk()), "give one of them"),
        (dict(body=7), "body is 7; give a stability.Body"),
    ]
    for change, sentence in cases:
        given = dict(body=torus, contact=st.Rough(), start={"theta": 1.0}, times=times) | change
        with pytest.raises(st.StabilityError) as caught:
            st.simulate(**given)
        assert sentence in str(caught.value)
        assert "\n" not in str(caught.value)
    own = st.Body(
        lambda theta, energy: energy + 0 * theta, axial=0.4, transverse=0.4, shape={"energy": 1.0}
    )
    with pytest.raises(st.StabilityError, match="a name that a motion has for itself"):
        st.simulate(own, st.Rough(), {"theta": 1.0}, times)
