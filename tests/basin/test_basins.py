"""Maps and samples of launches: outcomes, units, stores, refusals."""

import json
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
import pytest
import xarray

import stability as st
from stability.base.errors import StabilityError
from stability.basin import basins as module
from stability.integrators.taylor import available

SPIN: dict[str, Any] = {
    "contact": "viscous",
    "mu": 0.3,
    "family": "spinning",
    "horizon": 60.0,
    "x": ("phi_dot", 2.0, 3.9, 7),
    "y": ("tilt", 0.1, 0.55, 4),
}


@pytest.fixture(scope="module")
def spin() -> xarray.Dataset:
    return st.basins(**SPIN)


def test_each_cell_is_the_outcome_of_simulate(spin: xarray.Dataset) -> None:
    start = spin.start_state.values
    run = st.simulate(contact="viscous", mu=0.3, start=start, times=60.0)
    assert (spin.outcome.values == run.outcome.values).all()
    assert len(set(spin.outcome.values.ravel().tolist())) >= 2
    assert np.allclose(start[..., 0], np.pi / 2 - spin.tilt.values[:, None])
    assert (start[..., 2] == spin.phi_dot.values).all()
    early = np.isin(spin.outcome.values, [3])
    assert early.any()
    assert np.abs(spin.end_time.values - run.end_time.values)[early].max() < 1e-7


def test_a_map_has_its_starts_units_flags_and_provenance(spin: xarray.Dataset) -> None:
    assert spin.outcome.dims == ("tilt", "phi_dot") and "start_state" in spin.coords
    assert spin.tilt.attrs["units"] == "rad" and spin.end_time.attrs["units"] == "1"
    meanings = spin.outcome.attrs["flag_meanings"].split()
    assert len(meanings) == len(spin.outcome.attrs["flag_values"]) and "settled" in meanings
    assert spin.family.attrs["flag_meanings"].split()[0] == "none"
    told = spin.attrs
    assert told["horizon"] == 60.0 and json.loads(told["parameters"])["k"] == 0.25
    assert "created" not in told and told["launched_near"] == "spinning"
    settled = spin.outcome.values == 1
    assert np.isfinite(spin.member.values[settled]).all()
    assert np.isnan(spin.member.values[~settled]).all()
    assert (spin.member_error.values[settled] < 0.01).all()


def test_numbers_have_the_users_units() -> None:
    disk = st.Disk(mass=0.3, radius=0.12, gravity=9.81)
    rate = float(np.asarray(disk.rate))
    plain = st.basins(**(SPIN | {"x": ("phi_dot", 2.0, 3.0, 3)}))
    found = st.basins(
        disk,
        st.Viscous(0.3 / float(np.asarray(disk.speed))),
        family="spinning",
        horizon=60.0 / rate,
        x=("phi_dot", 2.0 * rate, 3.0 * rate, 3),
        y=SPIN["y"],
    )
    assert (found.outcome.values == plain.outcome.values).all()
    assert found.end_time.attrs["units"] == "s" and "rad/s" in found.member.attrs["units"]
    assert np.allclose(found.end_time.values * rate, plain.end_time.values, rtol=1e-6)
    settled = plain.outcome.values == 1
    spinning = settled & (found.family.values == plain.family.values)
    names = found.family.attrs["flag_meanings"].split()
    spinning &= found.family.values == names.index("spinning")
    assert np.allclose(found.member.values[spinning] / rate, plain.member.values[spinning], 1e-4)


@pytest.mark.parametrize("name", ["k", "mu"])
def test_numbers_of_body_and_law_are_axes(name: str) -> None:
    given = {"contact": "viscous", "family": "spinning", "horizon": 30.0, "held": {"tilt": 0.3}}
    given |= {"mu": 0.3} if name == "k" else {}
    found = st.basins(x=("phi_dot", 1.0, 3.0, 3), y=(name, 0.3, 0.5, 2), **given)
    for value in (0.3, 0.5):
        row = found.sel({name: value})
        disk = st.Disk(k=value) if name == "k" else st.Disk()
        contact = st.Viscous(value if name == "mu" else 0.3)
        run = st.simulate(disk, contact, row.start_state.values, 30.0)
        assert (row.outcome.values == run.outcome.values).all()


def test_a_store_continues_and_is_the_same_as_memory(
    spin: xarray.Dataset, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("zarr")
    place = tmp_path / "map.zarr"
    plain, calls = module.outcomes, []

    def stopping(*given: Any) -> Any:
        calls.append(1)
        if len(calls) == 3:
            raise KeyboardInterrupt
        return plain(*given)

    monkeypatch.setattr(module, "outcomes", stopping)
    with pytest.raises(KeyboardInterrupt):
        st.basins(**SPIN, store=place, chunk=7, workers=1)
    stored = [n for n in contents(place) if n.startswith("outcome/c.")]
    assert len(stored) >= 2
    calls.extend([1] * 3)  # no interruption any more
    before = len(calls)
    found = st.basins(**SPIN, store=place, chunk=7, workers=1)
    whole = [n for n in contents(place) if n.startswith("outcome/c.")]
    assert len(calls) - before == len(whole) - len(stored) > 0  # nothing twice
    found.load()
    assert set(found.variables) == set(spin.variables)
    for name in spin.variables:
        np.testing.assert_array_equal(found[name].values, spin[name].values)
    other = tmp_path / "other.zarr"
    st.basins(**SPIN, store=other, chunk=7)
    assert contents(place) == contents(other)
    with pytest.raises(StabilityError, match=r"map\.zarr"):
        st.basins(**(SPIN | {"horizon": 70.0}), store=place, chunk=7)
    assert contents(place) == contents(other)


def contents(folder: Path) -> dict[str, bytes]:
    return {
        str(p.relative_to(folder)): p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file()
    }


@pytest.mark.long
@pytest.mark.skipif(not available(), reason="heyoka is not installed")
def test_processes_give_the_same_bytes(tmp_path: Path) -> None:
    pytest.importorskip("zarr")
    given = SPIN | {"x": ("phi_dot", 2.0, 3.0, 4), "y": ("tilt", 0.1, 0.3, 2), "chunk": 4}
    st.basins(**given, store=tmp_path / "one.zarr")
    st.basins(**given, store=tmp_path / "two.zarr", executor="processes", workers=2)
    assert contents(tmp_path / "one.zarr") == contents(tmp_path / "two.zarr")


def test_without_heyoka_each_launch_runs_alone(
    spin: xarray.Dataset, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("stability.basin.outcomes.available", lambda: False)
    small = SPIN | {"x": ("phi_dot", 2.0, 3.9, 2), "y": ("tilt", 0.1, 0.55, 2)}
    found = st.basins(**small)
    assert (found.outcome.values == spin.outcome.values[::3, ::6]).all()


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"x": None}, "x and y are missing; give two axes"),
        ({"horizon": -1.0}, "horizon is -1; give a last time above 0"),
        ({"x": ("omega", 0, 1, 3)}, "'omega' varies nothing here; known are phi_dot, tilt"),
        ({"held": {"tilt": 0.1}}, "tilt is given twice"),
        ({"x": ("theta_dot", 0, 1, 3)}, "phi_dot has no value"),
        ({"family": "circling"}, "give one of rolling, spinning, tumbling"),
        ({"tolerance": 1.0}, "tolerance is 1; give one from"),
        ({"mu": 0.3, "nu": 2.0}, "'nu' is not an argument here"),
        ({"distribution": {"tilt": st.Uniform(0, 1)}}, "a sample has no axes"),
        ({"distribution": {"tilt": st.Uniform(0, 1)}, "x": None, "y": None}, "count is missing"),
        ({"distribution": 3, "count": 3, "x": None, "y": None}, "distribution is 3; give Ball"),
        ({"more": 3}, "more is 3; give a list"),
        ({"levels": 99}, "levels is 99"),
        ({"executor": "cluster"}, "cluster"),
        ({"body": st.Disk(), "disk": st.Disk()}, "give one of them"),
    ],
)
def test_what_is_wrong_is_said_in_one_sentence(change: dict[str, Any], words: str) -> None:
    with pytest.raises(StabilityError, match=words) as caught:
        st.basins(**(SPIN | change))
    assert str(caught.value).endswith(".") and "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"families": 3}, "families is 3; give a list"),
        ({"contact": "viscous"}, "contact is 'viscous', which a system does not take"),
        ({"family": "rolling"}, "family is 'rolling', which a system does not take"),
    ],
)
def test_what_a_system_does_not_take_is_refused(change: dict[str, Any], words: str) -> None:
    x = ca.SX.sym("x", 2)
    swing = st.System(
        "swing", x, ca.SX(), ca.vertcat(x[1], -ca.sin(x[0])), states=("q", "v"), parameters=()
    )
    with pytest.raises(StabilityError, match=words):
        st.basins(swing, x=("q", 0, 1, 3), y=("v", 0, 1, 3), horizon=1.0, **change)


def test_an_opened_store_has_its_starts_as_coordinates_and_names_versions(tmp_path: Path) -> None:
    few = dict(SPIN, x=("phi_dot", 2.0, 3.9, 2), y=("tilt", 0.1, 0.55, 2), horizon=1.0)
    held = {"k": 0.3}
    inside = st.basins(**few, held=held, store=tmp_path / "a.zarr")
    sample = st.basins(
        contact="viscous",
        mu=0.3,
        family="spinning",
        horizon=1.0,
        count=3,
        distribution={"phi_dot": st.Uniform(2, 3), "tilt": st.Uniform(0.1, 0.2)},
        store=tmp_path / "b.zarr",
    )
    for name, whole in (("a", inside), ("b", sample)):
        opened = xarray.open_zarr(tmp_path / f"{name}.zarr")
        assert set(opened.coords) == set(whole.coords) >= {"start_state"}
        assert set(opened.data_vars) == set(whole.data_vars)
        assert f"casadi {ca.__version__}, " in opened.attrs["versions"]
        assert "python 3." in opened.attrs["versions"]
    assert {"phi_dot", "tilt"} <= set(sample.coords) and "k" in inside.coords
    memory = st.basins(**few, held=held)
    assert set(memory.coords) == set(inside.coords)


def test_at_names_the_member_in_samples_and_held_numbers_too() -> None:
    common: dict[str, Any] = {"contact": "viscous", "mu": 0.3, "family": "spinning", "count": 2}
    one, other = (
        st.basins(
            **common, horizon=1.0, held={name: 2.5}, distribution={"tilt": st.Uniform(0.1, 0.2)}
        )
        for name in ("at", "phi_dot")
    )
    assert one.identical(other) and float(one.phi_dot) == 2.5
    one, other = (
        st.basins(**common, horizon=1.0, held={"tilt": 0.1}, distribution={name: st.Uniform(2, 3)})
        for name in ("at", "phi_dot")
    )
    assert one.identical(other) and one.phi_dot.dims == ("launch",)


@pytest.mark.parametrize("name", ["at", "phi_dot"])
def test_basins_have_the_number_of_their_members_under_both_names(name: str) -> None:
    found = st.basins(
        contact="viscous",
        mu=0.3,
        family="spinning",
        x=(name, 1.0, 3.0, 2),
        y=("tilt", 0.1, 0.2, 2),
        horizon=1.0,
    )
    assert found.at.values.tolist() == found.phi_dot.values.tolist() == [1, 3]
    assert found.at.dims == ("phi_dot",) and found.at.attrs == found.phi_dot.attrs
