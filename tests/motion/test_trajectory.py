"""A motion is a labelled dataset: whole, finite, with units, provenance and an event log."""

import math
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
import pytest
import xarray

import stability as st
from stability.bodies.newton_euler import STATES
from stability.integrators import taylor
from stability.motion.result import BY_CODE, Outcome

LAUNCH = st.launch("rolling", at=1.2)
DRY = [1.12, -0.31, 1.18, -1.45, -0.49, 0.46]


FEW = ["theta", "normal_force", "power", "outcome", "event_kind"]


def is_finite(dataset: Any) -> bool:
    """Every number is finite, but estimates of errors where the final state is unknown."""
    return all(
        bool(np.isfinite(v.values).all())
        for name, v in dataset.variables.items()
        if v.dtype.kind == "f" and name not in ("final_error", "end_time_error")
    ) and math.isfinite(float(dataset.attrs["tolerance"]))


def states(run: Any) -> Any:
    return np.stack([run[name].values for name in STATES], axis=-1)


@pytest.mark.parametrize(
    ("contact", "start"),
    [
        (st.Viscous(0.3), LAUNCH),
        (st.LinearViscous(0.3), LAUNCH),
        (st.Smooth(), LAUNCH),
        (st.Rough(), LAUNCH),
        (st.Coulomb(0.15), DRY),
        (st.RegularisedCoulomb(0.15, 1e-3), DRY),
    ],
)
@pytest.mark.parametrize(("last", "count"), [(1, 3), pytest.param(8, 33, marks=pytest.mark.long)])
def test_every_law_comes_back_whole_from_a_file(
    contact: Any, start: Any, last: float, count: int, tmp_path: Path
) -> None:
    times, method = np.linspace(0, last, count), "auto" if last > 1 else "dop853"
    run = st.simulate(st.Disk(k=0.3), contact, start, times, pose=last > 1, method=method)
    if last == 1 and contact.name != "coulomb":  # h5netcdf takes its time for each variable
        run = run[FEW]
    back = st.read_motion(st.write_motion(run, tmp_path / "run.nc"))
    assert back.identical(run)
    for name, variable in back.variables.items():
        # errors are infinite where the final state is unknown
        if variable.dtype.kind == "f" and name not in ("final_error", "end_time_error"):
            assert np.isfinite(variable.values).all(), name
    for name, variable in run.data_vars.items():
        if "time" in variable.dims and name != "mode":
            assert variable.attrs["units"]
            assert variable.attrs["long_name"]
    if last > 1 or contact.name == "coulomb":
        with xarray.open_dataset(tmp_path / "run.nc") as plain:  # any NetCDF reader will do
            assert plain.attrs["contact"] == contact.name


def test_the_provenance_says_how() -> None:
    run = st.simulate(st.Disk(), st.Viscous(0.3), LAUNCH, 5.0, tolerance=1e-8)
    assert run.attrs["tolerance"] == 1e-8
    assert run.attrs["method_asked"] == "auto"
    assert run.attrs["method"] == ("heyoka" if taylor.available() else "cvodes")
    assert "cheaper" in run.attrs["method_reason"] or "not installed" in run.attrs["method_reason"]
    for word in ("casadi", "numpy", "scipy", "python"):
        assert word in run.attrs["versions"]
    assert run.attrs["software"] == f"stability {st.__version__}"


def test_si_units_are_owed_and_given() -> None:
    disk = st.Disk.named("quarter")
    run = st.simulate(disk, st.Viscous(2.0), {"theta": 1.4, "omega3": 60.0}, 0.5, pose=True)
    assert run.time.attrs["units"] == "s"
    assert run.energy.attrs["units"] == "J"
    assert run.normal_force.attrs["units"] == "N"
    assert run.slip_x.attrs["units"] == "m/s"
    assert run.centre_x.attrs["units"] == "m"
    weight = float(disk.force)
    assert float(run.potential[0]) == pytest.approx(weight * float(disk.radius) * math.sin(1.4))
    assert 0 < float(run.normal_force[0]) < 2 * weight
    assert np.allclose(run.kinetic + run.potential, run.energy)


def test_the_energy_account_is_what_it_says() -> None:
    run = st.simulate(st.Disk(), st.Viscous(0.5), LAUNCH, np.linspace(0, 10, 1001))
    assert np.allclose(run.audit, run.energy + run.dissipated - run.energy[0], atol=1e-15)
    lost = np.trapezoid(run.power.values, run.time.values)
    assert lost == pytest.approx(float(run.dissipated[-1]), rel=1e-4)
    slip = np.hypot(run.slip_x, run.slip_y)
    assert np.allclose(run.power, 0.5 * run.normal_force * slip**2)


def test_a_batch_is_its_launches_one_by_one() -> None:
    rng = np.random.default_rng(2)
    starts = np.array(LAUNCH) + rng.uniform(-0.25, 0.25, (12, 6))
    keep = [
        s for s in starts if st.disk_system("viscous").observe(s, [0.25, 0.3])["normal_force"] > 0
    ]
    times = np.linspace(0, 40, 9)
    many = st.simulate(st.Disk(), st.Viscous(0.3), keep, times, tolerance=1e-11)
    assert set(many.outcome.values.tolist()) >= {Outcome.LIFT_OFF.code}
    for i, start in enumerate(keep):
        one = st.simulate(st.Disk(), st.Viscous(0.3), start, times, tolerance=1e-11)
        mine = many.isel(launch=i)
        assert int(one.outcome) == int(mine.outcome)
        running = mine.running.values == 1
        assert float(one.end_time) == pytest.approx(float(mine.end_time), abs=1e-6)
        count = int(running.sum())
        assert np.allclose(states(one)[:count], states(mine)[:count], rtol=0, atol=2e-6)
        if not running.all():  # held after its end
            held = states(mine)[count:]
            assert (held == held[0]).all()
            assert len(one.time) == count + 1
            assert float(one.time[-1]) == float(one.end_time)


def test_workers_do_not_change_a_batch() -> None:
    starts = np.array(LAUNCH) + np.linspace(-0.05, 0.05, 11)[:, None]
    runs = [st.simulate(st.Disk(), st.Viscous(0.3), starts, [1.0, 9.0], workers=n) for n in (1, 2)]
    runs[1].attrs["created"] = runs[0].attrs["created"]
    assert runs[0].identical(runs[1])


def test_parameters_broadcast_over_leading_axes() -> None:
    disk = st.Disk(k=[0.25, 0.3, 0.5], mass=1.0, radius=2.0, gravity=9.81)
    run = st.simulate(disk, st.Viscous([[0.1], [0.4]]), [1.2, 0, 0.5, 0.5, 0, 0], [0.5, 1.0])
    assert run.theta.dims == ("launch_0", "launch_1", "time")
    assert run.theta.shape == (2, 3, 2)
    assert run.mu.shape == run.k.shape == run.outcome.shape == (2, 3)
    one = st.simulate(
        st.Disk(k=0.5, mass=1.0, radius=2.0, gravity=9.81),
        st.Viscous(0.4),
        [1.2, 0, 0.5, 0.5, 0, 0],
        [0.5, 1.0],
    )
    assert np.allclose(run.theta[1, 2], one.theta, atol=1e-8)


def test_bodies_of_several_time_scales_share_a_batch() -> None:
    radii = np.array([0.5, 1.0, 4.0])
    many = st.simulate(
        st.Disk(mass=1.0, radius=radii, gravity=1.0),
        st.Viscous(0.3),
        [1.2, 0, 0.5, 0.5, 0, 0],
        [0.5, 1.5],
        tolerance=1e-11,
    )
    for i, radius in enumerate(radii):
        one = st.simulate(
            st.Disk(mass=1.0, radius=radius, gravity=1.0),
            st.Viscous(0.3),
            [1.2, 0, 0.5, 0.5, 0, 0],
            [0.5, 1.5],
            tolerance=1e-11,
        )
        assert np.allclose(states(many.isel(launch=i)), states(one), atol=1e-9)


def test_the_start_is_time_zero_whether_asked_or_not() -> None:
    asked = st.simulate(st.Disk(), st.Viscous(0.3), LAUNCH, [0.0, 2.0, 4.0])
    left_out = st.simulate(st.Disk(), st.Viscous(0.3), LAUNCH, [2.0, 4.0])
    assert np.array_equal(states(asked)[0], LAUNCH)
    assert np.allclose(states(asked)[1:], states(left_out), atol=1e-12)
    assert len(st.simulate(st.Disk(), st.Viscous(0.3), LAUNCH, 4.0).time) == 201


def test_a_run_that_ends_before_its_first_sample_reports_the_end() -> None:
    run = st.simulate(st.Disk(), st.Viscous(3.0), [1.0, 0.0, 5.0, -5.0, 0, 0], [1.0, 2.0])
    assert BY_CODE[int(run.outcome)] is Outcome.LIFT_OFF
    assert run.time.values.tolist() == [float(run.end_time)]
    assert run.event_kind.values.tolist() == ["lift-off"]
    assert np.array_equal(run.event_state.values[0], states(run)[-1])


def test_other_files_are_refused_in_one_sentence(tmp_path: Path) -> None:
    m = st.stability_map("rolling", x=("at", 1, 2, 2), y=("mu", 1, 2, 2))
    a_map = st.write_map(m, tmp_path / "map.nc")
    run = st.simulate(st.Disk(), st.Viscous(0.3), LAUNCH, 1.0)[["theta", "outcome"]]
    a_run = st.write_motion(run, tmp_path / "run.nc")
    (tmp_path / "text.nc").write_text("no")
    for reader, path in (
        (st.read_motion, a_map),
        (st.read_map, a_run),
        (st.read_motion, tmp_path / "text.nc"),
        (st.read_motion, tmp_path / "none.nc"),
        (st.read_motion, tmp_path),
    ):
        with pytest.raises(st.StabilityError) as caught:
            reader(path)
        assert "\n" not in str(caught.value)
    with pytest.raises(st.StabilityError, match="exists"):
        st.write_motion(run, a_run)
    with pytest.raises(st.StabilityError, match="give what simulate returns"):
        st.write_motion(m, tmp_path / "b.nc")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["map.nc", "run.nc", "text.nc"]


@pytest.mark.parametrize("filed", [False, pytest.param(True, marks=pytest.mark.long)])
def test_every_launch_keeps_its_start_also_without_a_sample_at_time_0(
    filed: bool, tmp_path: Path
) -> None:
    disk = st.Disk(mass=0.3, radius=0.2, k=0.25, gravity=9.81)
    names = ("theta", "theta_dot", "phi_dot", "omega3", "slip_x", "slip_y")
    given = {"theta": [[1.4], [1.5]], "omega3": [10.0, 12.0, 14.0], "slip_x": 0.3}
    many = st.simulate(disk, st.Viscous(0.3), given, [0.5, 1.0])
    found = many.start_state
    assert found.dims == ("launch_0", "launch_1", "state") and found.attrs["columns"].split() == [
        *names
    ]
    for name, values in zip(names, np.moveaxis(found.values, -1, 0), strict=True):
        expected = np.broadcast_to(np.asarray(given.get(name, 0.0)), (2, 3))
        assert np.allclose(values, expected, rtol=1e-15, atol=0), name
    assert "start_state" in many.coords
    if filed:
        read = st.read_motion(st.write_motion(many, tmp_path / "many.nc"))
        assert "start_state" in read.coords and read.start_state.identical(found)
    one = st.simulate(disk, st.Viscous(0.3), {"theta": 1.4, "omega3": 10.0, "slip_x": 0.3}, 1.0)
    assert np.array_equal(one.start_state, found[0, 0])
    again = st.simulate(disk, st.Viscous(0.3), found.values, [0.5, 1.0])
    assert np.allclose(again.theta, many.theta, rtol=1e-8)
    x, c = ca.SX.sym("x", 2), ca.SX.sym("c")
    system = st.System(
        "own", x, c, ca.vertcat(x[1], -x[0] - c * x[1]), states=("q", "v"), parameters=("c",)
    )
    own = st.simulate(system, {"c": 0.1}, {"q": [0.1, 0.2], "v": 1.0}, [1.0])
    assert own.start_state.values.tolist() == [[0.1, 1.0], [0.2, 1.0]]
