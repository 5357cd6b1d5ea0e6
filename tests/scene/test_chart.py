"""The chart of a scene: its errors are those of `verify`, its choice that of `answer`."""

import json
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
import pytest
import xarray

import stability as st
from stability.base.errors import FileError, ParameterError
from stability.scene import chart as module
from stability.scene.chart import chart, other_laws, true_error
from stability.scene.rungs.full import full
from stability.scene.rungs.reduced import ReducedModel
from stability.scene.rungs.track import Finish, Track

STIFF = st.Scene(
    contact=st.Viscous(3000.0),
    start={"theta": 1.3, "omega3": 2.0},
    horizon=8.0,
    tolerance=1e-6,
    uncertain={"mu": 0.2},
)
ROLLING = st.Scene(
    contact=st.Viscous(0.3),
    start={"theta": 1.5706, "omega3": 2.2},
    horizon=20.0,
    quantities=("path",),
)


@pytest.fixture(autouse=True, scope="module")
def _few_repeats() -> Any:
    """No test reads a time, so that few repeats are enough."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, "LEAST", 1)
        patch.setattr(module, "BUDGET", 0.0)
        yield


@pytest.fixture(scope="module")
def stiff() -> xarray.Dataset:
    return chart(STIFF)


@pytest.fixture(scope="module")
def rolling() -> xarray.Dataset:
    return chart(ROLLING)


def row(dataset: xarray.Dataset, name: str, kind: str = "") -> xarray.Dataset:
    where = dataset.model.values == name
    if kind:
        where &= dataset.kind.values == kind
    [i] = np.flatnonzero(where)
    return dataset.isel(model=int(i))


def test_a_relative_width_is_told_in_percent(stiff: xarray.Dataset) -> None:
    assert stiff.attrs["uncertain"] == "mu ± 20 %"


def test_the_true_error_of_the_choice_is_that_of_verify(stiff: xarray.Dataset) -> None:
    told = STIFF.verify()
    assert stiff.model.values[stiff.chosen.values].tolist() == [told.model] == ["creep-1"]
    assert float(row(stiff, "creep-1").true_error) == pytest.approx(told.true_error, rel=1e-6)
    assert float(row(stiff, "creep-1").estimate) == pytest.approx(told.estimate, rel=1e-6)


def test_the_true_error_along_a_path_is_that_of_verify(rolling: xarray.Dataset) -> None:
    told = ROLLING.verify()
    assert rolling.model.values[rolling.chosen.values].tolist() == [told.model] == ["linearised"]
    assert float(row(rolling, "linearised").true_error) == pytest.approx(told.true_error, rel=1e-6)


def test_the_closed_forms_are_charted_with_falling_errors(rolling: xarray.Dataset) -> None:
    """The deviation is 2e-4, so each order gains about that factor."""
    names = ["steady", "linearised", "second-order"]
    errors = [float(row(rolling, n).true_error) for n in names]
    assert errors[0] > 300 * errors[1] > 300**2 * errors[2]
    for name, error in zip(names, errors, strict=True):
        assert error <= float(row(rolling, name).estimate)


def test_each_order_of_creep_is_charted_at_its_own_error(stiff: xarray.Dataset) -> None:
    creep = stiff.isel(model=stiff.kind.values == "creep")
    assert creep.model.values.tolist() == ["rough", "creep-1", "creep-2"]
    errors = creep.true_error.values
    ratios = errors[1:] / errors[:-1]  # a factor of about 1/mu = 3.3e-4 each
    assert ((ratios > 1e-4) & (ratios < 1e-2)).all()
    np.testing.assert_array_less(errors, 2 * creep.estimate.values)


def test_another_law_has_the_distance_of_the_two_motions(stiff: xarray.Dataset) -> None:
    """Oracle: two runs of `simulate`; the chart runs each law to the tolerance of 1e-6."""
    runs = {
        name: st.simulate(st.Disk(), law, STIFF.start, [STIFF.horizon], tolerance=1e-11)
        for name, law in {"true": STIFF.contact, "rough": st.Rough(), "smooth": st.Smooth()}.items()
    }
    names = ("theta", "theta_dot", "phi_dot", "omega3", "slip_x", "slip_y")
    states = {n: np.array([float(np.ravel(r[s])[-1]) for s in names]) for n, r in runs.items()}
    for name in ("rough", "smooth"):
        far = np.abs(states[name] - states["true"]) / np.maximum(1, np.abs(states["true"]))
        assert float(row(stiff, f"{name} law").true_error) == pytest.approx(far.max(), abs=1e-6)


def test_the_spread_is_that_of_the_answer(stiff: xarray.Dataset, rolling: xarray.Dataset) -> None:
    spread = STIFF.answer().spread
    assert spread is not None
    assert float(stiff.spread) == spread.size > 0
    assert np.isnan(rolling.spread)


def test_a_model_that_does_not_apply_has_a_reason_and_no_numbers(stiff: xarray.Dataset) -> None:
    out = stiff.isel(model=np.isnan(stiff.true_error.values))
    assert out.model.values.tolist() == ["steady", "linearised", "second-order"]
    assert all("the nearest" in w or "grows" in w or "do not fall" in w for w in out.why.values)
    assert np.isnan(out.cost.values).all()


def test_the_cost_is_the_least_of_the_repeats(stiff: xarray.Dataset) -> None:
    ran = stiff.isel(model=np.isfinite(stiff.cost.values))
    np.testing.assert_array_equal(ran.cost.values, np.nanmin(ran.seconds.values, axis=1))
    assert (ran.cost.values > 0).all() and float(stiff.answer_cost) > 0


def test_the_dataset_says_where_it_comes_from_and_survives_a_file(
    stiff: xarray.Dataset, tmp_path: Path
) -> None:
    told = stiff.attrs
    assert json.loads(told["parameters"]) == {"k": 0.25, "mu": 3000.0}
    assert json.loads(told["start"])["theta"] == 1.3
    assert json.loads(told["machine"])["stability"] == st.__version__ == told["stability_version"]
    for name, variable in stiff.data_vars.items():
        assert variable.attrs["long_name"], name
    assert stiff.cost.attrs["units"] == stiff.seconds.attrs["units"] == "s"
    stiff.to_netcdf(tmp_path / "chart.nc", engine="h5netcdf")
    with xarray.open_dataset(tmp_path / "chart.nc", engine="h5netcdf") as back:
        np.testing.assert_array_equal(back.true_error.values, stiff.true_error.values)


def test_si_units_change_no_error() -> None:
    disk = st.Disk.named("quarter")
    rate, speed = (float(np.ravel(v)[0]) for v in (disk.rate, disk.speed))
    clock = float(np.ravel(disk.time)[0])
    plain = st.Scene(
        disk=st.Disk(k=disk.k),
        contact=st.Viscous(300.0),
        horizon=5.0,
        start={"theta": 1.3, "omega3": 2.0},
        tolerance=1e-5,
    )
    coin = st.Scene(
        disk=disk,
        contact=st.Viscous(300.0 / speed),
        horizon=5.0 * clock,
        start={"theta": 1.3, "omega3": 2.0 * rate},
        tolerance=1e-5,
    )
    laws = {"rough": st.Rough()}
    one, other = chart(plain, laws), chart(coin, laws)
    assert one.model.values.tolist() == other.model.values.tolist()
    known = np.isfinite(one.true_error.values) & (one.true_error.values > 1e-9)
    assert known.sum() >= 3
    np.testing.assert_allclose(other.true_error[known], one.true_error[known], rtol=1e-5)
    assert json.loads(other.attrs["start"])["omega3"] == pytest.approx(2.0 * rate)
    assert other.attrs["time_unit"] == "s"


def test_dry_friction_has_no_closed_form_and_starts_with_slip_no_rough_law() -> None:
    scene = st.Scene(
        contact=st.Coulomb(0.2),
        start={"theta": 1.3, "omega3": 1.0, "slip_x": 0.1},
        horizon=3.0,
        tolerance=1e-5,
    )
    found = chart(scene, {"rough": st.Rough(), "smooth": st.Smooth()})
    assert "dry friction" in str(row(found, "linearised").why.values)
    assert "slip_x" in str(row(found, "rough law").why.values)
    assert bool(row(found, "coulomb").chosen)


def test_a_motion_that_ends_in_another_way_has_an_infinite_error() -> None:
    """The smooth disk falls flat; with friction this one rolls on."""
    scene = st.Scene(contact=st.Viscous(30.0), start={"theta": 1.3, "omega3": 2.0}, horizon=20.0)
    truth = full(scene._problem(scene.contact))
    short = Track(
        truth.times[:1], truth.states[:1], truth.errors[:1], truth.at, Finish("flat", 2.0, 0.0, "")
    )
    error, why = true_error(short, truth)
    assert error == np.inf and why == "flat at 2; truly, the motion lasts"
    assert true_error(short, short) == (0.0, "")
    late = Track(
        truth.times[:1], truth.states[:1], truth.errors[:1], truth.at, Finish("flat", 2.2, 0.0, "")
    )
    assert true_error(late, short)[0] == pytest.approx(0.1)


def test_a_users_system_is_charted_with_its_reduced_model() -> None:
    """Oracle: x' = -x, y' = -1e3 (y - x): the slow model y = x has an error of about 1e-3."""
    x, p = ca.SX.sym("x", 2), ca.SX.sym("p", 1)
    pair = st.System(
        "pair", x, p, ca.vertcat(-x[0], -p * (x[1] - x[0])), states=("x", "y"), parameters=("rate",)
    )
    z, q = ca.SX.sym("z"), ca.SX.sym("q")
    slow = st.System("slow", z, q, -z, states=("z",), parameters=("rate",))
    model = ReducedModel(
        "slow", slow, lambda x, p: (x[:1], p[:1]), lambda z, _: np.concatenate([z, z], axis=-1)
    )
    scene = st.Scene(
        disk=pair,
        contact={"rate": 1e3},
        start={"x": 1.0, "y": 1.0},
        horizon=1.0,
        tolerance=1e-2,
        models=(model,),
    )
    found = chart(scene)
    exact = np.exp(-1.0) * (1000 / 999 - 1)
    assert float(row(found, "slow").true_error) == pytest.approx(exact, rel=1e-3)
    assert str(row(found, "slow").kind.values) == "reduced model"
    assert str(row(found, "pair").kind.values) == "full model"
    with pytest.raises(ParameterError, match="laws belong to a disk"):
        chart(scene, {"rough": st.Rough()})


def test_progress_counts_to_its_end() -> None:
    told: list[tuple[int, int]] = []
    chart(ROLLING, {}, lambda done, total: told.append((done, total)))
    assert [d for d, _ in told] == list(range(1, len(told) + 1)) and told[-1][0] == told[-1][1]


@pytest.mark.parametrize(
    ("laws", "message"),
    [([1], "laws is"), ({"a": 1}, "laws has 'a'"), ({1: st.Rough()}, "laws has 1")],
)
def test_laws_that_are_none_are_refused(laws: Any, message: str) -> None:
    with pytest.raises(ParameterError, match=message):
        chart(ROLLING, laws)


def test_the_first_of_several_laws_is_the_truth() -> None:
    several = st.Scene(
        contact={"a": st.Viscous(1.0), "b": st.Rough()},
        start={"theta": 1.5},
        horizon=1.0,
        uncertain={"mu": 0.1},
    )
    found = chart(several)
    assert found.attrs["law"] == "viscous" and found.spread > 0
    assert found.model.values[found.kind.values == "other law"].tolist() == ["b law"]


def test_a_progress_that_is_no_function_is_refused() -> None:
    with pytest.raises(ParameterError, match="progress is 3"):
        chart(ROLLING, {}, 3)  # type: ignore[arg-type]


def test_other_laws_have_the_friction_of_the_truth() -> None:
    coin = st.Disk.named("quarter")
    weight = float(np.ravel(coin.force)[0])
    viscous: Any = other_laws(coin.units, st.LinearViscous(c=2.0 * weight))["viscous"]
    assert float(viscous.mu) == pytest.approx(2.0)
    assert list(other_laws(st.Disk().units, st.Rough())) == [
        "smooth",
        "viscous, mu = 100",
        "coulomb, mu = 0.3",
    ]


@pytest.mark.few(1)
@pytest.mark.parametrize("suffix", ["png", "pdf", "svg"])
def test_a_plot_is_written_whole(suffix: str, tmp_path: Path) -> None:
    path = tmp_path / f"chart.{suffix}"
    figure = ROLLING.plot(path, laws={})
    assert figure.axes and [p.name for p in tmp_path.iterdir()] == [path.name]
    first = {"png": b"\x89PNG", "pdf": b"%PDF", "svg": b"<?xml"}[suffix]
    assert path.read_bytes().startswith(first)


def test_a_plot_is_refused_before_anything_is_computed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "chart", None)  # a call would end in a TypeError
    with pytest.raises(FileError, match=r"must end in \.png, \.pdf or \.svg"):
        ROLLING.plot(tmp_path / "chart.gif")
    taken = tmp_path / "chart.png"
    taken.write_bytes(b"mine")
    with pytest.raises(FileError, match="exists"):
        ROLLING.plot(taken)
    with pytest.raises(FileError, match="does not exist"):
        ROLLING.plot(tmp_path / "none" / "chart.png")
    assert taken.read_bytes() == b"mine" and list(tmp_path.iterdir()) == [taken]


def test_a_plot_that_fails_leaves_the_old_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = Path.write_bytes

    def broken(path: Path, content: bytes) -> None:
        whole(path, content[:100])
        raise OSError(28, "No space left on device")

    taken = tmp_path / "chart.png"
    taken.write_bytes(b"mine")
    monkeypatch.setattr(Path, "write_bytes", broken)
    with pytest.raises(FileError, match="No space left"):
        ROLLING.plot(taken, overwrite=True, laws={})
    assert taken.read_bytes() == b"mine" and list(tmp_path.iterdir()) == [taken]


def test_a_linear_question_has_no_chart() -> None:
    asked = st.Scene(
        contact=st.Viscous(0.3),
        start={"theta": 1.57, "omega3": 1.8},
        horizon=2.0,
        quantities="growth_rate",
    )
    with pytest.raises(st.StabilityError, match="no chart"):
        chart(asked)
