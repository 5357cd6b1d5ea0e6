"""Motions agree with an inertial formulation, keep their energy account, and end as outcomes."""

import math
from functools import lru_cache
from typing import Any

import numpy as np
import pytest
import reference
import sympy as sp
from hypothesis import given, settings
from hypothesis import strategies as some

import stability as st
from stability.bodies.newton_euler import STATES
from stability.integrators import taylor
from stability.integrators.flow import flow
from stability.motion.result import BY_CODE, Outcome

UPRIGHT = math.pi / 2
LAUNCH = [UPRIGHT - 0.1, 0, 0, 1.2, 0, 0]
HEYOKA = pytest.param(
    "heyoka", marks=pytest.mark.skipif(not taylor.available(), reason="heyoka is an extra")
)
TIGHT = [HEYOKA, "dop853", "lsoda"]


def states(run: Any) -> Any:
    return np.stack([run[name].values for name in STATES], axis=-1)


def outcome(run: Any) -> Outcome:
    return BY_CODE[int(run.outcome)]


# --- against the inertial formulation ---


@pytest.mark.few(6)
@pytest.mark.parametrize("method", [*TIGHT, "cvodes", "idas", "auto"])
@pytest.mark.parametrize("number", range(5))
@pytest.mark.parametrize("count", [2, pytest.param(3, marks=pytest.mark.long)])
def test_reference_trajectories_are_met(method: str, number: int, count: int) -> None:
    # dop853, lsoda, heyoka and auto to 1e-9; the two of order five to 1e-8 at this tolerance
    allowed = 1e-8 if method in ("cvodes", "idas") else 1e-9
    case = reference.trajectories()[number]
    run = st.simulate(
        st.Disk(k=case["k"]),
        st.Viscous(case["mu"]),
        case["start"],
        case["times"][:count],
        method=method,
        tolerance=1e-12,
    )
    assert np.abs(states(run) - np.array(case["states"])[:count]).max() < allowed


@pytest.mark.parametrize(
    ("method", "last"),
    [("heyoka", 100.0), ("dop853", 8.0), pytest.param("dop853", 100.0, marks=pytest.mark.long)],
)
def test_the_energy_account_closes_to_1e11_over_100(method: str, last: float) -> None:
    if method == "heyoka" and not taylor.available():
        pytest.skip("heyoka is an extra")
    run = st.simulate(st.Disk(), st.Viscous(0.3), LAUNCH, last, method=method, tolerance=1e-16)
    assert float(run.energy_error) < 1e-11
    assert float(run.dissipated[-1]) > 0.1  # there was something to account for


def test_auto_takes_a_tight_route_at_the_tightest_tolerance() -> None:
    run = st.simulate(st.Disk(), st.Viscous(0.3), LAUNCH, 100.0, tolerance=1e-16)
    assert run.attrs["method"] == ("heyoka" if taylor.available() else "dop853")
    assert float(run.energy_error) < 1e-11


# --- the normal force and D ---


def test_viscous_friction_never_reaches_d_zero_while_gn_d_stays_positive() -> None:
    # D gn = N is bounded; as D falls to 0+ the normal force grows without bound and pushes D up:
    # dD/dt = mu (k + 1) gn + bounded.  Derived here from the closed form, not from the graph.
    th, q, p, w, vx, vy, k, mu, gn = sp.symbols("theta q p w v_x v_y k mu g_n", real=True)
    s, c = sp.sin(th), sp.cos(th)
    d = k + c**2 - mu * vx * s * c
    theta_acc = (k * p**2 * s * c - 2 * k * w * p * s - gn * (c - mu * vx * s)) / k
    slip_acc = p * (vy - w) - mu * gn * vx - theta_acc * s - q**2 * c
    rate = sp.diff(d, th) * q + sp.diff(d, vx) * slip_acc
    coefficient = sp.expand(rate).coeff(gn)
    on_zero = coefficient.subs(vx, (k + c**2) / (mu * s * c))
    assert sp.simplify(on_zero - mu * (k + 1)) == 0


def test_the_viscous_flow_keeps_d_positive_where_gn_d_is() -> None:
    # starts close to D = 0: the slip is braked at once
    k, mu, theta = 0.25, 3.0, 1.0
    s, c = math.sin(theta), math.cos(theta)
    start = [theta, 0, 0, 0, (k + c * c) / (mu * s * c) * (1 - 1e-6), 0]
    run = st.simulate(st.Disk(k=k), st.Viscous(mu), start, np.linspace(1e-3, 0.5, 200))
    system = st.disk_system("viscous")
    six = states(run)
    assert (system.observe(six[:-1], np.array([k, mu]))["determinant"] > 0).all()


# --- outcomes ---


def neighbours(count: int) -> Any:
    rng = np.random.default_rng(20161)
    return np.array(LAUNCH) + rng.uniform(-0.3, 0.3, (count, 6))


def attached(starts: Any, mu: float) -> Any:
    seen = st.disk_system("viscous").observe(starts, np.array([0.25, mu]))
    return starts[seen["normal_force"] > 0]


@pytest.mark.long
def test_neighbours_of_the_reference_launch_all_end_as_outcomes() -> None:
    starts = attached(neighbours(128), 0.3)
    run = st.simulate(st.Disk(), st.Viscous(0.3), starts, np.linspace(0, 100, 51))
    words = [BY_CODE[int(o)].word for o in run.outcome.values]
    assert set(words) <= {"moving", "settled", "lift-off", "flat"}
    assert words.count("lift-off") > 10
    for name in ("normal_force", *STATES, "energy", "audit"):
        assert np.isfinite(run[name].values).all()
    assert (run.normal_force.values[run.running.values == 1] > -1e-9).all()


@lru_cache
def of_neighbours(method: str, first: int, last: int, until: int) -> Any:
    starts, times = attached(neighbours(24), 0.3)[first:last], np.linspace(0, until, until + 1)
    return st.simulate(st.Disk(), st.Viscous(0.3), starts, times, method=method, tolerance=1e-11)


@pytest.mark.parametrize("method", ["dop853", "lsoda", "cvodes"])
@pytest.mark.parametrize("some", [(18, 20, 6), pytest.param((14, 24, 20), marks=pytest.mark.long)])
def test_routes_agree_on_outcomes_and_lift_off_times(
    method: str, some: tuple[int, int, int]
) -> None:
    runs = [of_neighbours(m, *some) for m in (method, "idas")]
    assert (runs[0].outcome == runs[1].outcome).all()
    assert np.allclose(runs[0].end_time, runs[1].end_time, rtol=0, atol=1e-6)
    assert (runs[0].outcome == Outcome.LIFT_OFF.code).any()


def test_lift_off_ends_the_run_at_zero_normal_force() -> None:
    start = [1.0, 0.0, 5.0, -5.0, 0.0, 0.0]
    for method in ("dop853", "lsoda", "cvodes", "idas"):
        run = st.simulate(
            st.Disk(), st.Viscous(3.0), start, 3.0, method=method, tolerance=1e-11, check=False
        )
        assert outcome(run) is Outcome.LIFT_OFF
        assert abs(float(run.normal_force[-1])) < 1e-8
        assert float(run.time[-1]) == float(run.end_time) == pytest.approx(0.1302615, abs=1e-6)
        assert (run.normal_force.values[:-1] > 0).all()
        assert run.event_kind.values.tolist() == ["lift-off"]


def test_a_disk_let_go_falls_flat() -> None:
    # smooth: the centre falls straight down; θ̈ from energy, time by quadrature
    from mpmath import cos, mpf, quad, sin, sqrt, workdps

    def rate(u: Any) -> Any:  # with theta = 1 - u²; sin 1 - sin theta = 2 cos(1 - u²/2) sin(u²/2)
        drop = 2 * cos(1 - u * u / 2) * sin(u * u / 2)
        return 2 * u * sqrt((cos(1 - u * u) ** 2 + mpf(1) / 4) / (2 * drop))

    with workdps(30):
        expected = quad(rate, [0, sqrt(1 - mpf("1e-6"))])
    run = st.simulate(st.Disk(), st.Smooth(), {"theta": 1.0}, 10.0, tolerance=1e-13)
    assert outcome(run) is Outcome.FLAT
    assert float(run.end_time) == pytest.approx(float(expected), abs=1e-9)
    assert float(run.theta[-1]) == pytest.approx(1e-6, rel=1e-6)


def test_a_passage_close_to_flat_is_integrated_through() -> None:
    start = [0.5, -0.3, 0.02, 0.0, 0.0, 0.0]
    run = st.simulate(st.Disk(), st.Rough(), start, np.linspace(0, 2, 2001), tolerance=1e-12)
    assert outcome(run) is Outcome.MOVING
    assert 1e-6 < float(run.theta.min()) < 1e-2
    assert float(run.energy_error) < 1e-9


def test_unresolved_never_hands_out_a_state_that_failed() -> None:
    run = st.simulate(st.Disk(), st.Viscous(0.3), LAUNCH, 100.0, method="dop853", max_steps=20)
    assert outcome(run) is Outcome.UNRESOLVED
    assert "20 steps" in str(run.evidence.values)
    assert np.isfinite(states(run)).all()
    assert float(run.end_time) < 100
    exact = st.simulate(
        st.Disk(), st.Viscous(0.3), LAUNCH, run.time.values[1:], method="dop853", tolerance=1e-12
    )
    assert np.abs(states(exact)[-1] - states(run)[-1]).max() < 1e-6


@pytest.mark.few(6)
@pytest.mark.parametrize("mu", [1e-4, 1e-2, 1.0, 1e2, 1e4, 1e6])
@pytest.mark.parametrize("slip", [0.0, 0.3])
def test_friction_over_ten_decades_runs_without_a_stall(mu: float, slip: float) -> None:
    # slip to the side where friction cannot make D fall
    start = [UPRIGHT - 0.1, 0, 0.1, 1.2, -slip, slip]
    run = st.simulate(st.Disk(), st.Viscous(mu), start, np.linspace(0, 50, 11))
    assert outcome(run) in (Outcome.MOVING, Outcome.LIFT_OFF, Outcome.SETTLED)
    assert int(run.steps) < 60_000
    assert float(run.energy_error) < 1e-5


def test_very_large_friction_still_has_its_normal_force() -> None:
    # force is mu times a slip of 1e-8: the absolute tolerance has to follow
    start, times = [UPRIGHT - 0.1, 0, 0.3, 1.2, 0, 0], np.linspace(1, 20, 191)
    rough = st.simulate(st.Disk(), st.Rough(), start, times, tolerance=1e-12, check=False)
    run = st.simulate(st.Disk(), st.Viscous(1e8), start, times, check=False)
    assert np.abs(run.normal_force - rough.normal_force).max() < 1e-7


def test_large_friction_tends_to_the_rough_disk() -> None:
    times = np.linspace(0, 5, 6)
    rough = states(st.simulate(st.Disk(), st.Rough(), LAUNCH, times, tolerance=1e-12))
    errors = [
        np.abs(
            states(st.simulate(st.Disk(), st.Viscous(mu), LAUNCH, times, tolerance=1e-10)) - rough
        ).max()
        for mu in (1e3, 1e4, 1e5)
    ]
    orders = np.log10(np.array(errors[:-1]) / np.array(errors[1:]))
    assert np.allclose(orders, 1.0, atol=0.1)


# --- properties ---

START = some.tuples(
    some.floats(0.6, 2.4),
    some.floats(-0.8, 0.8),
    some.floats(-1.5, 1.5),
    some.floats(-1.5, 1.5),
    some.floats(-0.4, 0.4),
    some.floats(-0.4, 0.4),
)
FRICTION = some.floats(-2, 1.5).map(lambda e: 10**e)
INERTIA = some.floats(0.05, 0.5)


def launched(start: Any, k: float, mu: float, times: Any, **options: Any) -> Any:
    """The run, or None where the start is not in contact."""
    try:
        return st.simulate(st.Disk(k=k), st.Viscous(mu), list(start), times, **options)
    except st.StabilityError:
        return None


@given(START, INERTIA, FRICTION)
@settings(max_examples=20, deadline=None)
def test_energy_never_rises_and_contact_is_pressed(start: Any, k: float, mu: float) -> None:
    run = launched(start, k, mu, np.linspace(0, 8, 81))
    if run is None:
        return
    energy = run.energy.values
    assert (np.diff(energy) <= 1e-7 * max(1.0, energy[0])).all()
    assert (run.normal_force.values[:-1] > 0).all()
    if outcome(run) is Outcome.NO_CONTACT:  # an open set of starts: D runs to zero with gn > 0
        theta, _, _, _, slip, _ = run.event_state.values[-1]
        assert abs(k + math.cos(theta) ** 2 - mu * slip * math.sin(theta) * math.cos(theta)) < 1e-6
        return
    assert outcome(run) in (Outcome.MOVING, Outcome.LIFT_OFF, Outcome.FLAT, Outcome.SETTLED)
    assert np.isfinite(states(run)).all()


@given(START, INERTIA, FRICTION)
@settings(max_examples=12, deadline=None)
def test_the_other_end_of_the_axis_tells_the_same_motion(start: Any, k: float, mu: float) -> None:
    theta, theta_dot, phi_dot, omega3, vx, vy = start
    mirrored = (math.pi - theta, -theta_dot, phi_dot, -omega3, -vx, -vy)
    times = [0.5, 2.0]
    one, two = (launched(s, k, mu, times, tolerance=1e-11) for s in (start, mirrored))
    if one is None or two is None:
        assert one is None
        assert two is None
        return
    assert int(one.outcome) == int(two.outcome)
    if outcome(one) is not Outcome.MOVING:
        assert float(one.end_time) == pytest.approx(float(two.end_time), abs=1e-6)
        return
    sign = np.array([-1, -1, 1, -1, -1, -1])
    shift = np.array([math.pi, 0, 0, 0, 0, 0])
    assert np.allclose(states(two), sign * states(one) + shift, rtol=1e-6, atol=1e-7)


@given(START, INERTIA, FRICTION)
@settings(max_examples=12, deadline=None)
def test_restarting_in_the_middle_equals_going_through(start: Any, k: float, mu: float) -> None:
    whole = launched(start, k, mu, [0.7, 1.4], tolerance=1e-12)
    if whole is None or len(whole.time) < 2 or outcome(whole) is not Outcome.MOVING:
        return
    second = launched(states(whole)[0], k, mu, [0.7], tolerance=1e-12)
    assert np.allclose(states(second)[-1], states(whole)[-1], rtol=1e-7, atol=1e-8)


@given(START, some.floats(0.01, 10), some.floats(0.01, 3), some.floats(1, 30), some.floats(-1, 1))
@settings(max_examples=12, deadline=None)
def test_scaled_bodies_move_alike(
    start: Any, mass: float, radius: float, gravity: float, decade: float
) -> None:
    mu = 10**decade
    plain = launched(start, 0.25, mu, [0.5, 1.0], tolerance=1e-11)
    if plain is None:
        return
    disk = st.Disk(mass=mass, radius=radius, gravity=gravity)
    rate, speed = float(disk.rate), float(disk.speed)
    scale = np.array([1, rate, rate, rate, speed, speed])
    run = st.simulate(
        disk,
        st.Viscous(mu / speed),
        np.array(start) * scale,
        np.array([0.5, 1.0]) / rate,
        tolerance=1e-11,
    )
    assert int(run.outcome) == int(plain.outcome)
    assert np.allclose(states(run) / scale, states(plain), rtol=1e-6, atol=1e-8)
    assert np.allclose(run.energy.values / float(disk.energy), plain.energy.values, rtol=1e-6)
    assert run.theta_dot.attrs["units"] == ("1" if disk.dimensionless else "rad/s")


@pytest.mark.few(1)
@pytest.mark.parametrize(
    "contact",
    [
        st.Smooth(),
        st.Viscous(0.4),
        st.LinearViscous(0.4),
        st.Rough(),
        st.Coulomb(0.3),
        st.RegularisedCoulomb(0.3, 1e-2),
    ],
)
def test_the_paths_in_the_plane_are_those_of_the_slip(contact: st.Contact) -> None:
    # the material point at the contact moves with ṡ + ω×a = vA, turned by φ
    slip = 0.0 if contact.name == "rough" else 0.2
    start = [1.2, 0.3, 1.0, -0.5, slip, -slip]
    times = np.linspace(0, 1.5, 3001)
    run = st.simulate(st.Disk(), contact, start, times, pose=True, tolerance=1e-12)
    step = times[1]
    velocity = [np.gradient(run[n].values, step, edge_order=2) for n in ("centre_x", "centre_y")]
    cosine, sine = np.cos(run.phi.values), np.sin(run.phi.values)
    along_x = cosine * velocity[0] + sine * velocity[1]
    along_y = -sine * velocity[0] + cosine * velocity[1]
    slip_x = along_x - run.theta_dot.values * np.sin(run.theta.values)
    slip_y = along_y + run.omega3.values
    inner = slice(2, -2)
    error = np.maximum(np.abs(slip_x - run.slip_x), np.abs(slip_y - run.slip_y))[inner]
    # central differences; at a landing of dry friction the acceleration jumps
    assert np.quantile(error, 0.99) < 2e-6
    assert np.allclose(
        np.gradient(run.phi.values, step, edge_order=2)[inner], run.phi_dot.values[inner], atol=1e-5
    )


def test_heading_and_place_do_not_matter_since_pose_only_follows() -> None:
    times = [1.0, 5.0]
    with_pose = st.simulate(st.Disk(), st.Viscous(0.3), LAUNCH, times, pose=True, tolerance=1e-12)
    without = st.simulate(st.Disk(), st.Viscous(0.3), LAUNCH, times, tolerance=1e-12)
    assert np.allclose(states(with_pose), states(without), rtol=0, atol=1e-12)
    # a path that grows does not loosen the tolerance of the rest
    far = [
        st.simulate(st.Disk(), st.Viscous(3.0), st.launch("rolling", at=4.0), [300.0], pose=pose)
        for pose in (True, False)
    ]
    assert abs(float(far[0].centre_y[-1])) > 100
    assert float(far[0].energy_error) < 2 * float(far[1].energy_error) + 1e-13
    which = flow("viscous", pose=True)
    own = which.names.index("phi")
    import casadi as ca

    depends = ca.which_depends(which.rhs[:own], which.x[own:], 1, False)
    assert not any(depends)


# --- linear theory, measured ---


V = st.Viscous
BOTH_SIDES = [
    ("rolling", V(0.3), 0.25, 2**0.5),
    ("rolling", V(3.0), 0.25, 2**0.5),
    ("rolling", st.Rough(), 0.25, 3**-0.5),
    ("rolling", st.Smooth(), 0.25, 1.0),
    ("spinning", V(0.3), 0.25, 2.0),
    ("spinning", V(0.8), 0.25, None),
    ("spinning", st.Rough(), 0.25, 1.25**-0.5),
    ("spinning", st.Smooth(), 0.4, 0.4**-0.5),
    ("tumbling", V(0.9), 0.375, 0.5148137315460574),
    ("tumbling", V(0.9), 0.375, 0.8416302082000889),
    ("spinning", st.LinearViscous(0.3), 0.25, 2.0),
]
"""Family, law, k and a boundary: known, or to be asked for."""


@pytest.mark.few(2)
@pytest.mark.parametrize("side", [-1, 1])
@pytest.mark.parametrize(
    ("family", "contact", "k", "boundary"),
    BOTH_SIDES,
    ids=[f"{f}-{c.name}-{k}" for f, c, k, _ in BOTH_SIDES],
)
def test_growth_and_frequency_measured_from_motions_are_those_of_the_spectrum(
    family: str, contact: Any, k: float, boundary: float | None, side: int
) -> None:
    disk = st.Disk(k=k)
    if boundary is None:  # the last one along the family
        scan = ("at", 0.1, 1.55, 60) if family == "tumbling" else ("at", 2.05, 8.0, 60)
        found = st.boundaries(family, axis=scan, disk=disk, contact=contact)
        if not found:
            pytest.skip("no boundary there")
        boundary = found[-1].value
    at = boundary * (1 + 0.1 * side)
    if family == "tumbling":
        at = min(at, 1.5)
    spectrum = st.spectrum(family, at=at, disk=disk, contact=contact)
    member = st.launch(family, at=at, tilt=0.0, disk=disk)
    measured = 0
    for value, mode in zip(spectrum.eigenvalues, spectrum.modes.vectors, strict=True):
        if value.imag < 0 or abs(value.real) > 1.5 or abs(value) < 1e-3:
            continue
        direction = np.zeros(6, dtype=complex)
        direction[: len(mode)] = mode / np.abs(mode).max()
        times = np.linspace(0, 2.0 / max(0.1, abs(value.real), abs(value.imag)), 9)
        motion = np.zeros((9, 6), dtype=complex)
        for part, unit in ((direction.real, 1), (direction.imag, 1j)):
            if np.abs(part).max() < 1e-12:
                continue
            runs = [
                states(
                    st.simulate(
                        disk,
                        contact,
                        member + sign * 1e-6 * part,
                        times,
                        tolerance=1e-15,
                        method="dop853",
                    )
                )
                for sign in (1, -1)
            ]
            motion += unit * (runs[0] - runs[1]) / 2e-6
        own = slice(0, len(mode))
        expected = (direction * np.exp(value * times)[:, None])[:, own]
        assert np.abs(motion[:, own] - expected).max() < 2e-5 * np.abs(expected).max()
        measured += 1
    assert measured


def test_the_two_sides_of_a_boundary_have_the_verdicts_that_were_measured() -> None:
    for family, contact, k, boundary in BOTH_SIDES:
        if boundary is None:
            continue
        verdicts = [
            st.spectrum(family, at=boundary * f, disk=st.Disk(k=k), contact=contact).verdict
            for f in (0.9, 1.1)
        ]
        if boundary == 0.5148137315460574:  # here the stable side is the lower one
            verdicts = verdicts[::-1]
        assert verdicts[0] is st.Verdict.UNSTABLE
        assert verdicts[1] in (st.Verdict.STABLE, st.Verdict.NEUTRAL)


# --- refusals ---

GOOD: dict[str, Any] = {
    "disk": st.Disk(),
    "contact": st.Viscous(0.3),
    "start": LAUNCH,
    "times": 1.0,
}


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"start": [0, 0, 0, 1, 0, 0]}, "theta must lie strictly between 0 and π"),
        ({"start": [math.pi, 0, 0, 1, 0, 0]}, "theta must lie strictly between 0 and π"),
        ({"start": [1e-7, 0, 0, 0, 0, 0]}, "flat within flat = 1e-06"),
        ({"start": [1.0, 5.0, 0, 0, 0, 0]}, "the normal force is -"),
        ({"start": [1.0, 0, 0, 0, 30.0, 0]}, "Painlevé"),
        ({"start": [math.nan, 0, 0, 0, 0, 0]}, "start is nan"),
        ({"start": [1, 0, 0, math.inf, 0, 0]}, "start is inf"),
        ({"start": [1, 0, 0]}, "start has shape (3,)"),
        ({"start": 1.0}, "start has shape ()"),
        ({"start": "upright"}, "a real number is needed"),
        ({"start": {"omega3": 1}}, "does not name theta"),
        ({"start": {"theta": 1, "spin": 2}}, "start names 'spin'"),
        ({"start": {"theta": [1, 1], "omega3": [1, 2, 3]}}, "make them fit"),
        ({"start": np.ones((3, 6)), "contact": st.Viscous([0.1, 0.2])}, "do not broadcast"),
        ({"contact": st.Rough(), "start": [1, 0, 0, 0, 0.1, 0]}, "leave them out or give 0"),
        ({"contact": "viscous"}, "mu is missing; give Viscous(mu)"),
        ({"disk": 0.25}, "disk is 0.25"),
        ({"times": 0.0}, "times is 0"),
        ({"times": -1.0}, "times is -1"),
        ({"times": math.nan}, "times is nan"),
        ({"times": [0.0]}, "times end at 0"),
        ({"times": [-1.0, 1.0]}, "times begin at -1"),
        ({"times": [0.0, 2.0, 1.0, 3.0]}, "times go from 2 to 1"),
        ({"times": [1.0, 1.0]}, "times go from 1 to 1"),
        ({"times": []}, "empty"),
        ({"times": [[1.0, 2.0]]}, "times has shape (1, 2)"),
        ({"times": "long"}, "a real number is needed"),
        ({"method": "rk4"}, "method is 'rk4'"),
        ({"tolerance": 0.0}, "tolerance is 0"),
        ({"tolerance": 1.0}, "tolerance is 1"),
        ({"tolerance": math.nan}, "tolerance is nan"),
        ({"flat": 0.0}, "flat is 0"),
        ({"flat": 1.0}, "flat is 1"),
        ({"settle": -1.0}, "settle is -1"),
        ({"max_steps": 0}, "max_steps is 0"),
        ({"max_steps": 1.5}, "max_steps is 1.5"),
        ({"workers": 0}, "workers is 0"),
        (
            {"contact": st.Viscous(1e308), "disk": st.Disk(mass=1.0, radius=1e300, gravity=1.0)},
            "double precision",
        ),
    ],
)
def test_bad_input_gets_one_sentence(change: dict[str, Any], says: str) -> None:
    arguments = GOOD | change
    positional = [arguments.pop(n) for n in ("disk", "contact", "start", "times")]
    with pytest.raises(st.StabilityError) as caught:
        st.simulate(*positional, **arguments)
    message = str(caught.value)
    assert says in message
    assert "\n" not in message
    assert message.endswith(".")
