"""Maps: labelled, exact at their boundaries, whole in their files, the same by every route."""

import json
from pathlib import Path

import mpmath
import numpy as np
import pytest
import xarray

import stability as st
from stability.base.axis import Axis
from stability.base.verdict import CODES, Verdict
from stability.boundary.curves import KINDS
from stability.maps.files import read_map, write_map

AXES = {"rolling": (0.2, 3.0), "spinning": (0.5, 5.0), "tumbling": (0.05, 1.55)}


@pytest.fixture(scope="module")
def maps() -> dict[str, xarray.Dataset]:
    return {
        family: st.stability_map(family, x=("at", *ends, 48), y=("mu", 0.05, 20, 36, "log"))
        for family, ends in AXES.items()
    }


@pytest.mark.few(1)
@pytest.mark.parametrize("family", AXES)
def test_cells_agree_with_spectra_asked_one_by_one(
    maps: dict[str, xarray.Dataset], family: str
) -> None:
    found = maps[family]
    for i, j in ((0, 0), (5, 40), (35, 47), (20, 13)):
        at, mu = float(found["at"][j]), float(found["mu"][i])
        one = st.spectrum(family, at=at, contact=st.Viscous(mu))
        assert float(found.abscissa[i, j]) == pytest.approx(one.abscissa, rel=1e-12, abs=1e-14)
        assert int(found.verdict[i, j]) == one.verdict.code
        lead = one.eigenvalues[-1]
        assert float(found.frequency[i, j]) == pytest.approx(abs(lead.imag), abs=1e-12)
        assert float(found.abscissa_error[i, j]) == pytest.approx(one.abscissa_error, rel=0.5)


def test_names_units_flags_and_provenance_are_there(maps: dict[str, xarray.Dataset]) -> None:
    found = maps["rolling"]
    assert found.abscissa.dims == ("mu", "at")
    assert set(found.coords) == {"mu", "at", "omega3"}
    assert found.verdict.dtype == np.int8
    words = found.verdict.attrs["flag_meanings"].split()
    flags = dict(zip(words, found.verdict.attrs["flag_values"].tolist(), strict=True))
    assert flags == {v.word: v.code for v in st.Verdict}
    for name in ("at", "mu", "abscissa", "frequency", "boundary_at", "boundary_frequency"):
        assert "units" in found[name].attrs
    attributes = found.attrs
    assert json.loads(attributes["parameters"]) == {
        "gravity": 1.0,
        "k": 0.25,
        "mass": 1.0,
        "radius": 1.0,
    }
    for word in ("casadi", "numpy", "scipy", "python-flint", "python"):
        assert word in attributes["versions"]
    assert attributes["axes"] == "at:0.2:3:48 mu:0.05:20:36:log"
    assert attributes["structural_zeros"] == 2
    si = st.stability_map(
        "rolling", x=("at", 2, 30, 4), y=("mu", 0.1, 1, 3), disk=st.Disk.named("quarter")
    )
    assert si["at"].attrs["units"] == "rad/s"
    assert si["mu"].attrs["units"] == "s/m"
    assert si.abscissa.attrs["units"] == "1/s"


# --- boundaries ---


def hurwitz_in_many_digits(family: str, at: float, k: float, mu: float) -> tuple[float, float]:
    """Constant term and Hurwitz determinant of the reduced polynomial by mpmath at 60 digits.

    The polynomial comes from traces of powers (Newton's identities) of the graph's Jacobian, the
    determinant from its definition: nothing of `stability.algebra.exact.routh` is used.
    """
    with mpmath.workdps(60):
        from spectrum_oracle import truth_matrix

        resolved = st.disk_family(family, "viscous")
        matrix = truth_matrix(resolved, at, [k, mu])
        n = matrix.rows
        traces, power = [], mpmath.eye(n)
        for _ in range(n):
            power = power * matrix
            traces.append(sum(power[i, i] for i in range(n)))
        c = [mpmath.mpf(1)]
        for m in range(1, n + 1):
            c.append(-sum(c[m - i] * traces[i - 1] for i in range(1, m + 1)) / m)
        zeros = {"rolling": 2, "spinning": 1, "tumbling": 1}[family]
        c = c[: n + 1 - zeros]
        degree = len(c) - 1
        rows = [
            [
                c[2 * (j + 1) - (i + 1)] if 0 <= 2 * (j + 1) - (i + 1) <= degree else mpmath.mpf(0)
                for j in range(degree - 1)
            ]
            for i in range(degree - 1)
        ]
        return c[-1], mpmath.det(mpmath.matrix(rows))


@pytest.mark.parametrize("family", AXES)
def test_boundary_points_are_exact_to_their_stated_error(
    maps: dict[str, xarray.Dataset], family: str
) -> None:
    """The determinant that vanishes changes sign within the bracket, by 60-digit arithmetic."""
    found = maps[family]
    count = found.sizes["boundary_point"]
    assert count > 20
    assert found.attrs["boundary_unresolved"] == 0
    for i in np.linspace(0, count - 1, 9).astype(int):
        at, mu = float(found.boundary_at[i]), float(found.boundary_mu[i])
        error = float(found.boundary_error[i])
        size = at if int(found.boundary_axis[i]) == 0 else mu
        assert error <= 1e-12 * size
        which = 0 if int(found.boundary_kind[i]) == KINDS[st.Crossing.STATIC] else 1
        signs = []
        for side in (-1, 1):
            moved = (at + side * error, mu) if size == at else (at, mu + side * error)
            signs.append(hurwitz_in_many_digits(family, moved[0], 0.25, moved[1])[which])
        assert signs[0] * signs[1] < 0


def test_boundary_kinds_and_frequencies_are_those_of_the_spectrum_there(
    maps: dict[str, xarray.Dataset],
) -> None:
    found = maps["spinning"]
    kinds = set(found.boundary_kind.values.tolist())
    assert kinds == {KINDS[st.Crossing.STATIC], KINDS[st.Crossing.FLUTTER]}
    for i in range(0, found.sizes["boundary_point"], 7):
        at, mu = float(found.boundary_at[i]), float(found.boundary_mu[i])
        lead = st.spectrum("spinning", at=at, contact=st.Viscous(mu)).eigenvalues
        nearest = lead[np.abs(lead.real).argmin()]
        assert abs(nearest.real) < 1e-12
        assert abs(nearest.imag) == pytest.approx(float(found.boundary_frequency[i]), abs=1e-11)


@pytest.mark.parametrize(("k", "mu"), [(0.5, 0.1), (0.3125, 10.0), (0.5, 0.3)])
def test_boundary_of_a_nearly_flat_body_is_exact_where_root_finding_on_doubles_is_not(
    k: float, mu: float
) -> None:
    """The abscissa crosses with a slope of 1e-8 there; LAPACK's zero of it is far off."""
    [point] = st.boundaries(
        "tumbling", axis=("at", 1e-3, 1.5, 200, "log"), disk=st.Disk(k=k), contact=st.Viscous(mu)
    )
    assert point.error <= 1e-12 * point.value
    signs = [
        hurwitz_in_many_digits("tumbling", point.value + s * point.error, k, mu)[1] for s in (-1, 1)
    ]
    assert signs[0] * signs[1] < 0


def test_rollings_boundary_at_large_mu_is_exact() -> None:
    for mu in (1e2, 1e4, 1e6):
        [point] = st.boundaries("rolling", axis=("at", 1, 2, 20), contact=st.Viscous(mu))
        assert point.value == pytest.approx(2**0.5, rel=1e-15)
        assert point.error <= 1e-15


def test_a_grid_point_on_the_boundary_itself_is_no_hole() -> None:
    """phi_dot = 2 is exactly spinning's static boundary for k = 1/4."""
    found = st.stability_map("spinning", x=("at", 1.5, 2.5, 11), y=("mu", 0.1, 0.5, 6))
    assert (found.verdict[:, 5] == CODES[Verdict.NEUTRAL]).all()  # decided by rational arithmetic
    assert (found.abscissa[:, 5] == 0).all()
    assert found.boundary_at.values == pytest.approx(2.0, abs=1e-15)
    assert found.sizes["boundary_point"] == 6
    [point] = st.boundaries("spinning", axis=("at", 1.5, 2.5, 11), contact=st.Viscous(0.3))
    assert point.value == 2.0


def test_conservative_boundaries_are_static_and_mark_neutral_against_unstable() -> None:
    found = st.stability_map(
        "rolling", x=("at", 0.2, 1.5, 40), y=("k", 0.05, 0.5, 30), contact=st.Rough()
    )
    expected = 1 / np.sqrt(2 * (2 * found.boundary_k.values + 1))
    assert found.boundary_at.values == pytest.approx(expected, rel=1e-14)
    assert set(np.unique(found.verdict)) <= {0, 2, 3}
    assert set(found.boundary_kind.values.tolist()) == {KINDS[st.Crossing.STATIC]}


# --- axes ---


@pytest.mark.parametrize(
    ("x", "y", "at"),
    [
        (("k", 0.1, 0.5, 5), ("mu", 0.1, 1, 4), 8.0),
        (("radius", 0.01, 0.1, 5), ("gravity", 1.6, 20, 4), 8.0),
        (("mass", 0.01, 0.1, 5), ("at", 5, 30, 4), None),
    ],
)
@pytest.mark.parametrize("contact", [st.Viscous(0.4), st.LinearViscous(0.01)])
def test_any_two_quantities_may_be_axes(x: tuple, y: tuple, at: float | None, contact) -> None:
    disk = st.Disk(mass=0.02, radius=0.05, gravity=9.81)
    if "mu" in (x[0], y[0]):
        contact = type(contact)
    found = st.stability_map("rolling", x=x, y=y, disk=disk, contact=contact, at=at)
    i, j = 2, 3
    values = {x[0]: float(found[x[0]][j]), y[0]: float(found[y[0]][i])}
    body = st.Disk(
        **{n: values.get(n, getattr(disk, n)) for n in ("mass", "radius", "k", "gravity")}
    )
    if "mu" in values:
        law = contact(values["mu"]) if contact is st.Viscous else contact.like(values["mu"], body)
    else:
        law = contact
    one = st.spectrum("rolling", at=values.get("at", at), disk=body, contact=law)
    assert float(found.abscissa[i, j]) == pytest.approx(one.abscissa, rel=1e-11)


def test_coarse_scans_name_what_crosses_as_fine_ones_do() -> None:
    """On a coarse scan both determinants may change an even number of times between neighbours."""
    disk, law = st.Disk(k=0.44322082648807054), st.Viscous(0.049348406290313625)
    fine, coarse = (
        st.boundaries("rolling", axis=("at", 0.02, 20.0, n, "log"), disk=disk, contact=law)
        for n in (200, 2)
    )
    assert [p.crossing for p in fine] == [p.crossing for p in coarse] == [st.Crossing.FLUTTER]
    assert coarse[0].value == pytest.approx(fine[0].value, rel=1e-15)
    assert coarse[0].frequency == pytest.approx(fine[0].frequency, rel=1e-12)


def test_mu_under_the_linear_law_follows_the_mass_and_gravity_of_each_cell() -> None:
    law = st.LinearViscous(mu=0.3)
    axes = {"x": ("mass", 0.5, 2.0, 4), "y": ("gravity", 0.5, 2.0, 3)}
    size = st.Disk(mass=1.0, radius=1.0, gravity=1.0)
    found = st.stability_map("rolling", **axes, at=1.3, contact=law, disk=size)
    for i, gravity in enumerate(found.gravity.values):
        for j, mass in enumerate(found.mass.values):
            disk = st.Disk(mass=float(mass), radius=1.0, gravity=float(gravity))
            one = st.spectrum("rolling", at=1.3, disk=disk, contact=law)
            two = st.spectrum("rolling", at=1.3, disk=disk, contact=st.Viscous(0.3))
            assert float(found.abscissa[i, j]) == pytest.approx(one.abscissa, rel=1e-12)
            assert one.abscissa == pytest.approx(two.abscissa, rel=1e-12)
    with pytest.raises(st.StabilityError, match="two names for one"):
        st.stability_map("rolling", x=("c", 1, 2, 3), y=("mu", 1, 2, 3), at=1, contact=law)
    with pytest.raises(st.StabilityError, match="exactly one"):
        st.LinearViscous()


def test_circling_has_both_its_parameters_as_axes() -> None:
    found = st.stability_map(
        "circling", x=("theta", 0.3, 1.5, 12), y=("phi_dot", 0.2, 2, 10), contact=st.Rough()
    )
    assert found.abscissa.dims == ("phi_dot", "theta")
    assert np.isfinite(found.abscissa.values).all()


def test_a_logarithmic_axis_keeps_its_ends() -> None:
    grid = Axis("mu", 1e-3, 7.0, 9, True)
    assert grid.values[0] == 1e-3
    assert grid.values[-1] == 7.0
    assert np.ptp(np.diff(np.log(grid.values))) < 1e-13


def test_chunks_and_workers_do_not_change_a_map(monkeypatch: pytest.MonkeyPatch) -> None:
    import stability.maps.cells as module

    arguments = {"x": ("at", 0.05, 1.5, 31), "y": ("mu", 0.1, 5, 23)}
    whole = st.stability_map("tumbling", **arguments, workers=1)
    monkeypatch.setattr(module, "CHUNK", 50)
    parts = st.stability_map("tumbling", **arguments, workers=3)
    assert whole.drop_attrs().identical(parts.drop_attrs())


def test_progress_is_told_and_an_interruption_stops_the_work() -> None:
    seen: list[tuple[int, int]] = []
    st.stability_map(
        "rolling",
        x=("at", 1, 2, 40),
        y=("mu", 1, 2, 30),
        progress=lambda done, total: seen.append((done, total)),
    )
    assert seen[0][1] == 1200
    assert (1200, 1200) in seen

    def stop(*_: int) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        st.stability_map("rolling", x=("at", 1, 2, 40), y=("mu", 1, 2, 30), progress=stop)


def test_an_interrupted_map_goes_on_where_it_stopped(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    import stability.maps.cells as module

    monkeypatch.setattr(module, "BAND", 40)  # two rows
    axes = {"x": ("at", 0.05, 1.5, 20), "y": ("mu", 0.1, 5, 20)}
    kept = tmp_path / "kept"

    def stop(done: int, _: int) -> None:
        if done > 130:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        st.stability_map("tumbling", **axes, checkpoint=kept, progress=stop, workers=1)
    finished = len(list(kept.glob("*.npz")))
    assert 3 < finished < 10
    (kept / "0.npz").write_bytes(b"damaged")
    worked: list[int] = []
    original = module.Cells._band
    monkeypatch.setattr(
        module.Cells, "_band", lambda self, *a: worked.append(1) or original(self, *a)
    )
    resumed = st.stability_map("tumbling", **axes, checkpoint=kept)
    assert len(worked) == 10 - finished + 1
    fresh = st.stability_map("tumbling", **axes)
    assert resumed.drop_attrs().identical(fresh.drop_attrs())
    with pytest.raises(st.StabilityError, match="another map"):
        st.stability_map("tumbling", **axes, disk=st.Disk(k=0.3), checkpoint=kept)


def test_a_checkpoint_folder_keeps_what_is_not_its_own(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from stability.cli import main

    monkeypatch.chdir(tmp_path)
    words = ["map", "rolling", "--x", "at:1:2:8", "--y", "mu:0.1:1:8", "--out", "m.nc"]
    assert main([*words, "--checkpoint", "."]) == 0
    assert [p.name for p in tmp_path.iterdir()] == ["m.nc"]


def test_a_chunk_of_another_length_is_worked_anew(tmp_path: Path) -> None:
    axes = {"x": ("at", 1, 2, 8), "y": ("mu", 0.1, 1, 8)}
    fresh = st.stability_map("rolling", **axes, checkpoint=tmp_path / "kept")
    [part] = (tmp_path / "kept").glob("*.npz")
    with np.load(part) as stored:
        cut = {name: array[:5] for name, array in stored.items()}
    np.savez(part, **cut)
    again = st.stability_map("rolling", **axes, checkpoint=tmp_path / "kept")
    assert again.drop_attrs().identical(fresh.drop_attrs())


def test_a_swept_radius_makes_the_map_si() -> None:
    disk = st.Disk(mass=1.0, radius=1.0, gravity=1.0)
    found = st.stability_map(
        "rolling", x=("radius", 0.1, 1, 3), y=("mu", 1, 2, 3), at=3.0, disk=disk
    )
    assert found.abscissa.attrs["units"] == "1/s"
    assert found.radius.attrs["units"] == "m"


def test_a_change_of_odd_order_at_zero_is_found() -> None:
    """Damping c³: the Hurwitz determinant has a triple root, and the axis passes through zero."""
    import casadi as ca

    x, p = ca.SX.sym("x", 2), ca.SX.sym("p", 2)
    system = st.System(
        "pendulum",
        x,
        p,
        ca.vertcat(x[1], -p[0] * ca.sin(x[0]) - p[1] ** 3 * x[1]),
        states=("angle", "rate"),
        parameters=("g", "c"),
    )
    hanging = st.Family(system, "hanging", at=("g",), held={"angle": 0, "rate": 0})
    [point] = st.boundaries(hanging, axis=("c", -1, 1.3, 10), at=1)
    assert abs(point.value) <= point.error <= 1e-9


# --- files ---


def test_a_map_with_complex_data_survives_the_file(tmp_path: Path) -> None:
    found = st.stability_map("tumbling", x=("at", 0.1, 1.5, 9), y=("mu", 0.1, 5, 8), modes=True)
    assert np.iscomplexobj(found.eigenvalues)
    path = write_map(found, tmp_path / "map.nc")
    back = read_map(path)
    assert back.identical(found)
    assert back.eigenvalues.dtype == complex
    assert list(back.variables) == list(found.variables)
    assert [p.name for p in tmp_path.iterdir()] == ["map.nc"]
    # an independent reader sees the same names and numbers
    import h5py

    with h5py.File(path) as raw:
        assert set(raw) >= {"abscissa", "verdict", "eigenvalues", "at", "mu"}
        assert np.array_equal(raw["abscissa"][...], found.abscissa.values)


def test_a_map_without_any_boundary_survives_too(tmp_path: Path) -> None:
    found = st.stability_map("rolling", x=("at", 2, 3, 5), y=("mu", 1, 2, 5))
    assert found.sizes["boundary_point"] == 0
    assert read_map(write_map(found, tmp_path / "m.nc")).identical(found)


def test_files_are_not_overwritten_unless_asked(tmp_path: Path) -> None:
    found = st.stability_map("rolling", x=("at", 1, 2, 3), y=("mu", 1, 2, 3))
    path = tmp_path / "map.nc"
    write_map(found, path)
    before = path.read_bytes()
    with pytest.raises(st.StabilityError, match="exists"):
        write_map(found, path)
    assert path.read_bytes() == before
    write_map(found, path, overwrite=True)


@pytest.mark.filterwarnings("ignore::ResourceWarning")
def test_what_is_not_a_map_is_refused(tmp_path: Path) -> None:
    whole = write_map(
        st.stability_map("rolling", x=("at", 1, 2, 9), y=("mu", 1, 2, 9)), tmp_path / "whole.nc"
    )
    (tmp_path / "empty.nc").write_bytes(b"")
    (tmp_path / "text.nc").write_text("not a map")
    (tmp_path / "cut.nc").write_bytes(whole.read_bytes()[:3000])
    xarray.Dataset({"a": ("x", [1.0])}).to_netcdf(tmp_path / "foreign.nc", engine="h5netcdf")
    (tmp_path / "folder.nc").mkdir()
    for kind in ("empty", "text", "cut", "foreign", "missing", "folder"):
        path = tmp_path / f"{kind}.nc"
        with pytest.raises(st.StabilityError) as caught:
            read_map(path)
        assert str(path) in str(caught.value)
        assert len(str(caught.value).splitlines()) == 1, kind


def test_nothing_is_left_when_writing_fails(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = st.stability_map("rolling", x=("at", 1, 2, 3), y=("mu", 1, 2, 3))

    def fail(*_: object, **__: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(xarray.Dataset, "to_netcdf", fail)
    with pytest.raises(st.StabilityError, match="No space left"):
        write_map(found, tmp_path / "map.nc")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.long
def test_a_map_of_twelve_million_cells_fits_in_two_gigabytes(tmp_path: Path) -> None:
    import subprocess
    import sys

    script = (
        "import resource, stability as st\n"
        "m = st.stability_map('spinning', x=('at', 0.5, 5, 4000), y=('mu', 0.05, 3, 3000))\n"
        f"st.write_map(m, {str(tmp_path / 'large.nc')!r})\n"
        "print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20, m.sizes)\n"
    )
    run = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    print(run.stdout)
    assert float(run.stdout.split()[0]) < 2.0


def test_a_motion_is_not_written_as_a_map(tmp_path: Path) -> None:
    run = st.simulate(st.Disk(), st.Viscous(0.3), st.launch("rolling", at=1.2), [0.0, 1.0])
    with pytest.raises(st.StabilityError, match="give what stability_map returns"):
        st.write_map(run, tmp_path / "x.nc")
    assert list(tmp_path.iterdir()) == []


def test_the_axis_of_a_member_has_its_own_name_too(tmp_path: Path) -> None:
    y = ("mu", 0.1, 2.0, 3)
    plain, named = (
        st.stability_map("spinning", x=(n, 1.0, 4.0, 5), y=y) for n in ("at", "phi_dot")
    )
    assert named.assign_attrs(created=plain.attrs["created"]).identical(plain)
    for found in (
        plain,
        named,
        read_map(write_map(named, tmp_path / "a.nc")),
        read_map(st.stream_map("spinning", x=("phi_dot", 1.0, 4.0, 5), y=y, out=tmp_path / "b.nc")),
    ):
        assert found.verdict.dims == ("mu", "at") and "phi_dot" in found.coords
        np.testing.assert_array_equal(found.phi_dot.values, np.linspace(1, 4, 5))
        assert found.phi_dot.dims == ("at",)


@pytest.mark.parametrize("name", ["at", "omega3"])
@pytest.mark.parametrize("body", [None, st.Torus(0.2)], ids=["disk", "body"])
def test_a_map_has_the_number_of_its_members_under_both_names(
    name: str, body: st.Body | None
) -> None:
    found = st.stability_map(
        "rolling", x=(name, 1, 2, 3), y=("mu", 0.1, 1, 3), contact=st.Viscous, body=body
    )
    assert found.at.values.tolist() == found.omega3.values.tolist() == [1, 1.5, 2]
    assert found.at.dims == found.omega3.dims and found.at.attrs == found.omega3.attrs
