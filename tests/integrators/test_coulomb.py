"""Dry friction sticks and slips as an inertial formulation with set-valued friction does."""

import math
from typing import Any

import numpy as np
import pytest
import reference

import stability as st
from stability.bodies.newton_euler import STATES
from stability.bodies.thin_disk import disk_model
from stability.integrators.stick_slip import (
    continuations,
    directions,
    slip_acceleration,
    sticking_force,
)
from stability.motion.result import BY_CODE, Outcome

DISK = disk_model("coulomb").dry
assert DISK is not None
SCENES = {case["name"]: case for case in reference.coulomb()}


def states(run: Any) -> Any:
    return np.stack([run[name].values for name in STATES], axis=-1)


def events(case: dict[str, Any]) -> list[tuple[str, float]]:
    """The reference's events; a stick and a slip at one time are one reversal."""
    found: list[tuple[str, float]] = []
    for event in case["events"]:
        if found and event["kind"] == "slip" and found[-1] == ("stick", event["time"]):
            found[-1] = ("reverse", event["time"])
        else:
            found.append((event["kind"], event["time"]))
    return found


@pytest.mark.few(2)
@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize("method", ["auto", pytest.param("dop853", marks=pytest.mark.long)])
def test_scenes_meet_the_inertial_formulation(name: str, method: str) -> None:
    case = SCENES[name]
    times = np.array(case["times"])
    keep = times > 0
    asked = times[keep]
    lifts = case["events"] and case["events"][-1]["kind"] == "lift-off"
    if lifts:  # ask beyond it: the run must end there
        asked = np.append(asked, case["events"][-1]["time"] + 1.0)
    run = st.simulate(
        st.Disk(k=case["k"]),
        st.Coulomb(case["mu"]),
        case["start"],
        asked,
        method=method,
        tolerance=1e-12,
    )
    expected = np.array(case["states"])[keep]
    allowed = 1e-10 + 3 * case["error_estimate"]
    assert np.abs(states(run)[: len(expected)] - expected).max() < allowed
    kinds = run.event_kind.values.tolist()
    assert kinds == [kind for kind, _ in events(case)]
    for mine, (_, when) in zip(run.event_time.values, events(case), strict=True):
        assert abs(mine - when) < allowed + 1e-9
    assert float(run.energy_error) < 1e-11
    assert (BY_CODE[int(run.outcome)] is Outcome.LIFT_OFF) == bool(lifts)


def test_backspin_on_an_upright_disk_is_exact() -> None:
    # straight on: slip 0.9 is braked by mu (1 + 1/(2k)) = 0.6 per unit time: it rolls from 1.5 on
    run = st.simulate(
        st.Disk(), st.Coulomb(0.2), [math.pi / 2, 0, 0, 2.0, 0, 0.9], [1.0, 2.0], tolerance=1e-13
    )
    assert run.event_kind.values.tolist() == ["stick"]
    assert float(run.event_time[0]) == pytest.approx(1.5, abs=1e-12)
    assert float(run.omega3[-1]) == pytest.approx(1.4, abs=1e-12)
    assert float(run.slip_y[0]) == pytest.approx(0.3, abs=1e-12)
    assert run["mode"].values.tolist() == [0, 1]
    # work of friction: mu times the way slipped
    assert float(run.dissipated[-1]) == pytest.approx(0.2 * 0.9 * 1.5 / 2, abs=1e-12)


@pytest.mark.few(1)
@pytest.mark.parametrize(
    ("name", "order"),
    [("slides_throughout", 2.0), ("slides_then_sticks", 1.0), ("starts_stuck_then_slips", 0.8)],
)
def test_regularised_friction_tends_to_true_sticking(name: str, order: float) -> None:
    # order 2 while it slides, 1 once it sticks (creep), 4/5 once it has slipped from sticking
    case = SCENES[name]
    times = np.array(case["times"])
    times = times[times > 0]
    true = states(
        st.simulate(
            st.Disk(k=case["k"]), st.Coulomb(case["mu"]), case["start"], times, tolerance=1e-12
        )
    )
    errors = []
    for epsilon in (1e-2, 1e-3, 1e-4):
        run = st.simulate(
            st.Disk(k=case["k"]),
            st.RegularisedCoulomb(case["mu"], epsilon),
            case["start"],
            times,
            tolerance=1e-11,
        )
        errors.append(np.abs(states(run) - true).max())
    slope = math.log10(errors[1] / errors[2])
    assert slope == pytest.approx(order, abs=0.15)


def test_the_force_of_sticking_stays_inside_the_cone_and_sliding_lies_on_it() -> None:
    case = SCENES["many_transitions_through_upright"]
    run = st.simulate(
        st.Disk(k=case["k"]),
        st.Coulomb(case["mu"]),
        case["start"],
        np.linspace(0.01, 10, 500),
        check=False,
    )
    ratio = np.hypot(run.force_x, run.force_y) / (case["mu"] * run.normal_force)
    sticking = run["mode"].values == 1
    assert sticking.any()
    assert not sticking.all()
    assert (ratio.values[sticking] <= 1 + 1e-9).all()
    assert ratio.values[sticking].min() < 0.9
    for i in np.flatnonzero(sticking)[::23]:
        held = sticking_force(DISK, states(run)[i, :4], np.array([case["k"], case["mu"]]))
        mine = [float(run[n][i]) for n in ("normal_force", "force_x", "force_y")]
        assert mine == pytest.approx(held, abs=1e-12)
    assert np.allclose(ratio.values[~sticking], 1.0, atol=1e-12)
    assert (np.hypot(run.slip_x, run.slip_y).values[sticking] == 0).all()
    assert (np.diff(run.dissipated.values) >= -1e-15).all()


def test_force_and_acceleration_at_rest_are_those_of_the_closed_formulas() -> None:
    # docs/explanation/dry-friction.md: gn = -k bz/(k + c² - mu s c cos a), and so on
    rng = np.random.default_rng(8)
    for _ in range(50):
        theta, q, p, w = rng.uniform(0.4, 2.7), *rng.uniform(-1, 1, 3)
        k, mu, a = rng.uniform(0.05, 0.5), rng.uniform(0.05, 1.0), rng.uniform(-3, 3)
        s, c = math.sin(theta), math.cos(theta)
        bx = w * p * (s * s - c * c) - p * p * s * s * c - c * q * q
        by = -p * q * s
        bz = -1 + s * q * q - p * p * s * c * c + 2 * w * p * s * c
        gn = -k * bz / (k + c * c - mu * s * c * math.cos(a))
        ax = bx + gn * (s * c / k - mu * math.cos(a) * (1 + s * s / k))
        ay = by - mu * gn * (1 + 1 / (2 * k)) * math.sin(a)
        four = np.array([theta, q, p, w])
        f, h, normal, _ = slip_acceleration(DISK, four, np.array([k, mu]), np.array([a]))
        assert f[0] == pytest.approx(ax * math.cos(a) + ay * math.sin(a), abs=1e-12 / (k + c * c))
        assert h[0] == pytest.approx(ay * math.cos(a) - ax * math.sin(a), abs=1e-12 / (k + c * c))
        assert normal[0] == pytest.approx(gn, rel=1e-12)
        b3 = s * bx + c * bz
        held = sticking_force(DISK, four, np.array([k, mu]))
        assert held[0] == pytest.approx(-bz + c * b3 / (1 + k), abs=1e-12)
        assert held[1] == pytest.approx(-bx + s * b3 / (1 + k), abs=1e-12)
        assert held[2] == pytest.approx(-by * 2 * k / (2 * k + 1), abs=1e-12)


def test_every_radial_direction_is_found() -> None:
    # against a scan of h for sign changes
    rng = np.random.default_rng(4)
    angles = np.linspace(-math.pi, math.pi, 4001)
    for _ in range(60):
        four = np.array([rng.uniform(0.4, 2.7), *rng.uniform(-1.5, 1.5, 3)])
        k, mu = rng.uniform(0.05, 0.5), rng.uniform(0.05, 0.4)
        h = slip_acceleration(DISK, four, np.array([k, mu]), angles)[1]
        changes = angles[:-1][np.sign(h[:-1]) != np.sign(h[1:])]
        found = np.sort(np.angle(np.exp(1j * directions(DISK, four, np.array([k, mu])))))
        assert len(found) == len(changes)
        assert np.abs(found - changes).max() < 2e-3
        assert np.abs(slip_acceleration(DISK, four, np.array([k, mu]), found)[1]).max() < 1e-9


@pytest.mark.parametrize("draws", [60, pytest.param(1500, marks=pytest.mark.long)])
def test_below_the_threshold_there_is_exactly_one_way_on(draws: int) -> None:
    # theorem of docs/explanation/dry-friction.md for mu < 2√(k(k+1)) and a contact that is pressed
    rng = np.random.default_rng(6)
    seen = set()
    for _ in range(draws):
        k = rng.choice([0.02, 0.1, 0.25, 0.5])
        mu = rng.uniform(0.02, 0.999) * 2 * math.sqrt(k * (k + 1))
        four = np.array([rng.uniform(0.1, 3.0), *rng.uniform(-2, 2, 3)])
        _, _, normal, d = slip_acceleration(DISK, four, np.array([k, mu]), np.zeros(1))
        if normal[0] * d[0] <= 1e-6:
            continue
        ways = continuations(DISK, four, np.array([k, mu]))
        if abs(ways.ratio - 1) < 1e-6:
            continue
        assert ways.count == 1
        seen.add(ways.sticks)
    assert seen == {True, False}


def by_force(four: Any, k: float, mu: float) -> tuple[bool, list[float]]:
    """Ways on by F(λ) of docs/explanation/dry-friction.md in 40 digits: sticking, angles of slip.

    With gn and A affine in the contact force, A = b' + W F: no trigonometric polynomial in it.
    """
    import mpmath

    with mpmath.workdps(40):
        theta, q, p, w = (mpmath.mpf(float(v)) for v in four)
        kk, m = mpmath.mpf(k), mpmath.mpf(mu)
        s, c = mpmath.sin(theta), mpmath.cos(theta)
        bx = w * p * (s * s - c * c) - p * p * s * s * c - c * q * q
        by = -p * q * s
        bz = -1 + s * q * q - p * p * s * c * c + 2 * w * p * s * c
        push = (bx - s * c * bz / (kk + c * c), by)
        weight = ((kk + 1) / (kk + c * c), 1 + 1 / (2 * kk))

        def force(lam: Any) -> Any:
            fx, fy = (-b / (v + lam) for b, v in zip(push, weight, strict=True))
            return fx, fy, -(kk * bz + s * c * fx) / (kk + c * c)

        def beyond(t: Any) -> Any:  # ψ at λ = t/(1 - t)
            fx, fy, gn = force(t / (1 - t))
            return mpmath.sqrt(fx * fx + fy * fy) - m * gn

        grid = [mpmath.mpf(i) / 1500 for i in range(1500)]
        values = [beyond(t) for t in grid]
        roots = [
            mpmath.findroot(beyond, (a, b), solver="anderson")
            for a, b, fa, fb in zip(grid, grid[1:], values, values[1:], strict=False)
            if fa * fb < 0
        ]
        forces = [force(t / (1 - t)) for t in roots]
        angles = [float(mpmath.atan2(-fy, -fx)) for fx, fy, gn in forces if gn > 0]
        return bool(values[0] <= 0 and force(0)[2] > 0), angles


def test_the_threshold_of_uniqueness_is_sharp() -> None:
    # a thousandth above mu = 2√(k(k+1)) the disk may stick, or slip in two directions
    k, mu = 0.25, 1.1191520227386447
    assert mu / (2 * math.sqrt(k * (k + 1))) == pytest.approx(1.001, abs=1e-9)
    four = np.array(
        [1.1405036155603199, -0.003713908095680414 * 0.9999, 1.82547123230798, 1.1032082780622803]
    )
    ways = continuations(DISK, four, np.array([k, mu]))
    sticks, angles = by_force(four, k, mu)
    assert sticks
    assert ways.sticks
    assert sorted(ways.directions) == pytest.approx(sorted(angles), abs=1e-9)
    assert len(angles) == 2
    run = st.simulate(st.Disk(k=k), st.Coulomb(mu), [*four, 0, 0], 1.0)
    assert BY_CODE[int(run.outcome)] is Outcome.NON_UNIQUE
    # just below it there is one
    below = continuations(DISK, four, np.array([k, 2 * math.sqrt(k * (k + 1)) * (1 - 1e-9)]))
    assert below.count == 1


@pytest.mark.parametrize("count", [2, pytest.param(40, marks=pytest.mark.long)])
def test_ways_on_by_the_force_are_those_by_the_direction(count: int) -> None:
    rng = np.random.default_rng(12)
    for _ in range(count):
        k = float(rng.choice([0.1, 0.25, 0.5]))
        mu = float(2 * math.sqrt(k * (k + 1)) * rng.uniform(0.3, 2))
        four = np.array([rng.uniform(0.3, 2.8), *rng.uniform(-1, 1, 3)])
        ways = continuations(DISK, four, np.array([k, mu]))
        sticks, angles = by_force(four, k, mu)
        assert ways.sticks == sticks
        assert sorted(ways.directions) == pytest.approx(sorted(angles), abs=1e-8)


@pytest.mark.parametrize(
    ("draws", "seed"), [(30, 24), pytest.param(2000, 5, marks=pytest.mark.long)]
)
def test_the_number_of_ways_that_keep_contact_is_odd_if_pressed_and_even_if_not(
    draws: int, seed: int
) -> None:
    rng = np.random.default_rng(seed)
    several = 0
    for _ in range(draws):
        k = float(rng.choice([0.05, 0.1, 0.25, 0.5]))
        mu = float(2 * math.sqrt(k * (k + 1)) * rng.uniform(0.3, 4))
        theta, q, p, w = four = np.array([rng.uniform(0.1, 3.0), *rng.uniform(-3, 3, 3)])
        s, c = math.sin(theta), math.cos(theta)
        bz = -1 + s * q * q - p * p * s * c * c + 2 * w * p * s * c
        ways = continuations(DISK, four, np.array([k, mu]))
        if min(abs(ways.ratio - 1), abs(bz)) < 1e-6:
            continue
        assert ways.lifts == (bz > 0)
        assert (ways.sticks + len(ways.directions)) % 2 == (bz < 0)
        if bz > 0:  # every direction that is listed has D < 0 then
            d = slip_acceleration(
                DISK, four, np.array([k, mu]), np.array(ways.directions or [0.0])
            )[3]
            assert not ways.directions or (d < 0).all()
            several += bool(ways.directions)
    assert several > 0


def test_a_contact_that_may_also_lift_off_is_not_said_to_stick_or_slip() -> None:
    # bz > 0: 0.4 did not count lift-off among the ways on
    k, mu = 0.05, 1.4557359438338509
    start = [1.4537490894200014, 0.20206492406184573, 1.9205967531509573, 2.535225920807088, 0, 0]
    assert continuations(DISK, np.array(start[:4]), np.array([k, mu])).lifts
    run = st.simulate(st.Disk(k=k), st.Coulomb(mu), start, 1.0)
    assert BY_CODE[int(run.outcome)] is Outcome.NON_UNIQUE
    assert "can lift off" in str(run.evidence.values)


@pytest.mark.parametrize("case", reference.corners(), ids=lambda c: f"{c['kind'][:24]} {c['k']}")
def test_corners_have_the_continuations_that_were_solved_for(case: dict[str, Any]) -> None:
    four = np.array(case["state"][:4])
    ways = continuations(DISK, four, np.array([case["k"], case["mu"]]))
    assert ways.sticks == case["stick_admissible"]
    expected = sorted(math.remainder(t["angle"], 2 * math.pi) for t in case["takeoff"])
    found = sorted(math.remainder(a, 2 * math.pi) for a in ways.directions)
    assert np.allclose(found, expected, atol=1e-6)


@pytest.mark.parametrize("case", reference.corners()[:6], ids=lambda c: f"{c['k']} {c['mu']}")
def test_a_start_with_two_continuations_ends_as_non_unique(case: dict[str, Any]) -> None:
    run = st.simulate(st.Disk(k=case["k"]), st.Coulomb(case["mu"]), case["state"], 1.0)
    assert BY_CODE[int(run.outcome)] is Outcome.NON_UNIQUE
    assert float(run.end_time) == 0.0
    assert "slip can set in at" in str(run.evidence.values)
    # regularised friction does pick one
    picked = st.simulate(
        st.Disk(k=case["k"]), st.RegularisedCoulomb(case["mu"], 1e-3), case["state"], 0.01
    )
    assert float(picked.end_time) == 0.01


def test_batches_of_dry_launches_are_each_their_own() -> None:
    cases = [SCENES[n] for n in ("slides_then_sticks", "starts_stuck_then_slips")]
    times = [0.5, 2.0, 4.0]
    many = st.simulate(
        st.Disk(k=[c["k"] for c in cases]),
        st.Coulomb([c["mu"] for c in cases]),
        [c["start"] for c in cases],
        times,
    )
    for i, case in enumerate(cases):
        one = st.simulate(st.Disk(k=case["k"]), st.Coulomb(case["mu"]), case["start"], times)
        assert np.allclose(states(one), states(many.isel(launch=i)), atol=1e-12)
        mine = many.event_launch.values == i
        assert many.event_kind.values[mine].tolist() == one.event_kind.values.tolist()


def test_a_start_at_rest_from_which_slip_sets_in_has_its_forces_at_once() -> None:
    start = {"theta": 1.3, "theta_dot": 0.1, "phi_dot": 0.4, "omega3": 1.5}
    run = st.simulate(st.Disk(), st.Coulomb(0.2), start, np.linspace(0, 1, 11))
    assert run.event_kind.values[0] == "slip"
    assert float(run.slip_x[0]) == float(run.slip_y[0]) == 0.0
    force = math.hypot(float(run.force_x[0]), float(run.force_y[0]))
    assert force == pytest.approx(0.2 * float(run.normal_force[0]), rel=1e-12)
    assert math.atan2(-float(run.force_y[0]), -float(run.force_x[0])) == pytest.approx(
        float(run.event_direction[0]), abs=1e-9
    )
    assert all(np.isfinite(run[n].values).all() for n in ("normal_force", "power", "energy"))


def test_a_start_at_rest_that_nothing_holds_down_is_refused() -> None:
    # the force of sticking would press (gn > 0) but lies far outside the cone, and no slip sets in
    start = [1.3584861398296046, 0.8731793602881994, 0.47383312494378416, 1.9119442312294206, 0, 0]
    k, mu = 0.13306917881431404, 0.4060094943121223
    assert sticking_force(DISK, np.array(start[:4]), np.array([k, mu]))[0] > 0
    assert not continuations(DISK, np.array(start[:4]), np.array([k, mu])).pressed
    with pytest.raises(st.StabilityError, match="not in contact"):
        st.simulate(st.Disk(k=k), st.Coulomb(mu), start, 1.0)


def test_the_account_closes_through_a_slip_that_sets_in_close_to_flat() -> None:
    # at 3.4648 the disk lies within 1e-4 of flat and turns at 3e4: an onset must be as brief
    k, mu = 0.1786199664366368, 0.5075477197942422
    start = [
        1.7857585771816074,
        -0.5203646835713671,
        0.49026995133059526,
        -0.5709883297832943,
        0.23468959865375028,
        -0.2095820483810763,
    ]
    run = st.simulate(
        st.Disk(k=k), st.Coulomb(mu), start, np.linspace(0, 4, 41), tolerance=1e-12, check=False
    )
    assert float(np.abs(run.event_state[:, 2]).max()) > 1e4
    assert float(run.energy_error) < 1e-9


def test_spectra_refuse_dry_friction_with_the_reason() -> None:
    with pytest.raises(st.StabilityError, match="no linearisation of its own"):
        st.spectrum("rolling", at=1.0, contact=st.Coulomb(0.3))


def test_a_disk_that_is_nearly_flat_leaves_the_cone_with_a_slip_that_counts() -> None:
    # it turns so fast that the slip of its first moment is 1e-15
    low = [2.31141661e-05, -5.65619920e-06, 416.088242, -7.20943231e-04, 0, 0]
    run = st.simulate(
        st.Disk(),
        st.Coulomb(0.3),
        low,
        0.03,
        resistance=st.RollingResistance(0.0704),
        check=False,
        tolerance=1e-6,
    )
    assert run.attrs["outcome"] == "moving"
    assert run.event_kind.values.tolist()[:3] == ["slip", "stick", "slip"]
    turn = 2 * math.pi / 416
    assert 0.5 * turn < float(run.event_time[2] - run.event_time[0]) < 2 * turn
